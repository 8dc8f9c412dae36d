/* Suggestions for misspelt words. */
#include "base/suggest.h"
#include "tests/check.h"

static const char *const commands[] = { "fit", "trace", "draw", "classify", "bench", "catalogue" };
static const char *const columns[] = { "x", "y", "theta", "angle", "t", "weight" };

static const char *command(const char *word) { return lw_suggest(word, commands, 6); }
static const char *column(const char *word) { return lw_suggest(word, columns, 6); }

TEST(near_words)
{
    CHECK_TEXT(command("fti"), "fit");               /* swapped neighbours count once */
    CHECK_TEXT(command("FIT"), "fit");
    CHECK_TEXT(command("clasify"), "classify");
    CHECK_TEXT(command("darw"), "draw");
    CHECK_TEXT(command("catalog"), "catalogue");     /* its beginning */
    CHECK_TEXT(command("cat"), "catalogue");
    CHECK_TEXT(column("wieght"), "weight");
    CHECK_TEXT(column("thetha"), "theta");
    CHECK_TEXT(column("angel"), "angle");
    CHECK_TEXT(column("X"), "x");
    static const char *const options[] = { "length-range", "min-transmission-angle", "gear-ratios" };
    CHECK_TEXT(lw_suggest("min-transmision", options, 3), "min-transmission-angle");      /* its beginning, misspelt */
    CHECK_TEXT(lw_suggest("transmission", options, 3), "min-transmission-angle");         /* a part of it */
    CHECK_TEXT(lw_suggest("ratio", options, 3), "gear-ratios");
    CHECK(lw_suggest("rat", options, 3) == NULL);
}

TEST(far_words)
{
    char longer[200];
    memset(longer, 'a', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    CHECK(command("zebra") == NULL);
    CHECK(command("") == NULL);
    CHECK(command(longer) == NULL);
    CHECK(lw_suggest("fit", commands, 0) == NULL);
    CHECK(lw_suggest("fit", (const char *const[]){ longer }, 1) == NULL);
}

TEST(exact_beats_beginning)
{
    static const char *const words[] = { "fitting", "fit" };
    CHECK_TEXT(lw_suggest("fit", words, 2), "fit");
}

/* Status texts and error records. */
#include "base/error.h"
#include "tests/check.h"

TEST(every_status_has_a_text)
{
    int n = 0;
#define X(name, code, text) CHECK_INT(name, code); CHECK_TEXT(lw_status_text(name), text); \
                            CHECK_TEXT(lw_status_name(name), #name); n++;
    LW_STATUS_LIST(X)
#undef X
    CHECK(n >= 10);
}

TEST(numbers_that_are_no_status)
{
    for (int i = -50; i < 50; i++) {
        CHECK(lw_status_text((lw_status)i) != NULL);
        CHECK(lw_status_name((lw_status)i) != NULL);
    }
    CHECK_TEXT(lw_status_name((lw_status)77), "LW_?");
    CHECK_TEXT(lw_status_text((lw_status)-77), "no such status");
}

TEST(sign_tells_outcome_from_failure)
{
    CHECK(LW_OK == 0 && LW_OPEN > 0 && LW_STOPPED > 0 && LW_NOTHING > 0);
    CHECK(LW_E_ARG < 0 && LW_E_MEMORY < 0 && LW_E_NOTATION < 0 && LW_E_IO < 0 && LW_E_KIND < 0);
}

static void printed(const lw_error *e, const char *want)
{
    char buf[1200];
    lw_error_print(e, buf, sizeof buf);
    CHECK_TEXT(buf, want);
}

TEST(places_are_printed_as_far_as_known)
{
    lw_error e;
    CHECK_INT(lw_error_at(&e, LW_E_NOTATION, "a.csv", 3, 7, "column %s", "x"), LW_E_NOTATION);
    CHECK_INT(e.status, LW_E_NOTATION);
    printed(&e, "a.csv:3:7: column x");
    lw_error_at(&e, LW_E_IO, "a.csv", 3, 0, "t");
    printed(&e, "a.csv:3: t");
    lw_error_at(&e, LW_E_IO, "a.csv", 0, 9, "t");       /* a column without a line says nothing */
    printed(&e, "a.csv: t");
    lw_error_at(&e, LW_E_IO, "-", 1, 2, "t");
    printed(&e, "standard input:1:2: t");
    lw_error_at(&e, LW_E_IO, NULL, 1, 2, "t");
    printed(&e, "line 1:2: t");
    CHECK_INT(lw_error_set(&e, LW_E_ARG, "%d %s", 4, "bars"), LW_E_ARG);
    printed(&e, "4 bars");
    CHECK_INT(lw_error_set(NULL, LW_E_ARG, "lost"), LW_E_ARG);
    CHECK_INT(lw_error_at(NULL, LW_E_IO, "f", 1, 1, "lost"), LW_E_IO);
}

TEST(long_and_hostile_text_stays_one_line)
{
    char longer[3000], buf[64];
    lw_error e;
    memset(longer, 'y', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    lw_error_at(&e, LW_E_IO, longer, 1, 1, "%s", longer);
    CHECK_INT(strlen(e.text), sizeof e.text - 1);
    CHECK_INT(strlen(e.file), sizeof e.file - 1);
    memset(buf, 'z', sizeof buf);
    lw_error_print(&e, buf, sizeof buf);
    CHECK_INT(strlen(buf), sizeof buf - 1);
    lw_error_print(&e, buf, 1);
    CHECK_INT(strlen(buf), 0);
    lw_error_print(&e, buf, 0);
    lw_error_at(&e, LW_E_IO, "a\033[2J", 1, 1, "a\nb\tc\x7f");
    CHECK_TEXT(e.text, "a?b?c?");
    CHECK_TEXT(e.file, "a?[2J");
}

#include "check.h"
#include "grammar/topology/franke.h"
#include "topology.h"

static void check_text(const lw_chain *c, const char *want)
{
    lw_franke f;
    char text[LW_FRANKE_SIZE];
    CHECK_INT(lw_franke_from_chain(c, &f), LW_OK);
    CHECK_INT(lw_franke_print(&f, text, sizeof text), strlen(want));
    CHECK_TEXT(text, want);
}

/* The variants {2,2,0} and {2,1,1} of thesis line 425; of the four printed there only these have the
 * sum 4 that six links need. */
TEST(six_links)
{
    lw_chain watt = watt_chain(), stephenson = stephenson_chain(), four = ring_of(4);
    check_text(&watt, "(3 3) 1-2:0 1-2:2 1-2:2");
    check_text(&stephenson, "(3 3) 1-2:1 1-2:1 1-2:2");
    check_text(&four, "() :4");
}

/* Chain -> Franke -> text -> Franke -> chain -> Franke ends where it began, and links and joints are as
 * many as before. */
TEST(reads_back)
{
    int n_seen = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 4000; trial++) {
        lw_mechanism m = random_topology(&rng, 3 + trial % 14, 1 + trial % 14, "r");
        lw_chain c, back;
        lw_franke f, g, h;
        char text[LW_FRANKE_SIZE];
        lw_mechanism_chain(&m, &c);
        if (lw_franke_from_chain(&c, &f) != LW_OK)
            continue;                                        /* a link with one joint */
        n_seen++;
        size_t n = lw_franke_print(&f, text, sizeof text);
        CHECK_INT(lw_franke_read(text, n, NULL, &g, NULL), LW_OK);
        CHECK(!memcmp(&f, &g, sizeof f));
        CHECK_INT(lw_franke_chain(&g, &back), LW_OK);
        CHECK_INT(back.n_link, c.n_link);
        CHECK_INT(lw_chain_count(&back, 1), lw_chain_count(&c, 1));
        CHECK_INT(lw_franke_from_chain(&back, &h), LW_OK);
        CHECK(!memcmp(&f, &h, sizeof f));
    }
    CHECK(n_seen > 300);
}

/* A cut link carries lines that come back to it. */
TEST(fractionated_at_a_link)
{
    lw_chain c;
    lw_franke f;
    static const char text[] = "(4) 1-1:3 1-1:3";
    CHECK_INT(lw_franke_read(text, strlen(text), NULL, &f, NULL), LW_OK);
    CHECK_INT(lw_franke_chain(&f, &c), LW_OK);
    CHECK_INT(c.n_link, 7);
    CHECK_INT(lw_chain_mobility(&c), 2);
    CHECK_INT(__builtin_popcount(lw_chain_cut_links(&c)), 1);
    check_text(&c, text);
}

TEST(refusals)
{
    lw_franke f;
    lw_chain c = ring_of(4);
    lw_chain_unjoin(&c, 0, 1);
    CHECK_INT(lw_franke_from_chain(&c, &f), LW_E_ARG);       /* open ends */
    lw_chain_join(&c, 0, 1, 2);
    CHECK_INT(lw_franke_from_chain(&c, &f), LW_E_KIND);
    lw_chain_clear(&c, 8);
    for (int i = 0; i < 8; i++)
        lw_chain_join(&c, i, i ^ 1, 1), lw_chain_join(&c, i, (i & 4) | ((i + 2) & 3), 1);
    CHECK_INT(lw_franke_from_chain(&c, &f), LW_E_ARG);       /* two rings apart */
    f = (lw_franke){ .n_circle = 2, .n_line = 2, .end = { { 0, 1 }, { 0, 1 } }, .weight = { 1, 1 } };
    CHECK_INT(lw_franke_chain(&f, &c), LW_E_ARG);            /* circles on two lines */
}

TEST(faults_have_a_column)
{
    static const struct { const char *text; long column; const char *part; } known[] = {
        { "", 1, "'(' before the circles" },
        { "(3 3", 5, "a number of joints" },
        { "(2 3) ", 2, "2 is no number of joints" },
        { "(3 3) 1-3:0", 9, "3 is no circle" },
        { "(3 3) 1-2", 10, "':' before" },
        { "(3 3) 1:2", 8, "'-' between" },
        { "(3 3) 1-2:x", 11, "'x' where a number of binary" },
        { "(3 4) 1-2:0 1-2:2 1-2:2", 4, "4 joints, but 3 line ends" },
        { "(3 3) 1-2:0 1-2:2 1-2:0", 19, "share a joint already" },
        { "(4) 1-1:3 1-1:0", 11, "to itself" },
        { "(4) 1-1:3 1-1:1", 11, "share a joint already" },
        { "() :2", 4, "share a joint already" },
        { "() :1", 4, "to itself" },
        { "() :4 :4", 1, "one closed line" },
        { "() :33", 5, "33 is no number of binary links" },
        { "(3 3) 1-2:20 1-2:20 1-2:2", 1, "too many links" },
        { "(4 4) 1-1:3 1-1:3 2-2:3 2-2:3", 1, "do not connect" },
        { "() :4\n() :4", 1, "one line of text" },
        { "()", 1, "no link" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_franke f;
        lw_error e = { 0 };
        CHECK_INT(lw_franke_read(known[i].text, strlen(known[i].text), NULL, &f, &e), LW_E_NOTATION);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
    }
}

#include "check.h"
#include "grammar/topology/lam.h"
#include "topology.h"

/* The matrix printed at the end of paper F (Makkonen 1999, line 3396), six parts and seven joints; its
 * last rows, cut off there, can only hold joint 7 of the last two parts. */
TEST(matrix_of_the_source)
{
    static const char text[] = "0 1 0 2 0 3\n0 0 4 0 0 0\n0 0 0 5 6 0\n0 0 0 0 0 0\n0 0 0 0 0 7\n0 0 0 0 0 0\n";
    lw_lam a, b;
    lw_mechanism m;
    lw_chain c;
    char out[LW_LAM_SIZE];
    CHECK_INT(lw_lam_read(text, strlen(text), NULL, &a, NULL), LW_OK);
    CHECK_INT(a.n_link, 6);
    CHECK_INT(a.n_joint, 7);
    lw_lam_mechanism(&a, &m, NULL);
    lw_mechanism_chain(&m, &c);
    CHECK_INT(lw_chain_mobility(&c), 1);
    CHECK_INT(lw_chain_check(&c, NULL), LW_OK);
    lw_lam_from_mechanism(&m, &b);                     /* it numbers row by row, as we do */
    lw_lam_print(&b, out, sizeof out);
    CHECK_TEXT(out, text);
}

TEST(reads_back)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 500; trial++) {
        lw_mechanism m = random_topology(&rng, 1 + trial % LW_LINK_MAX, trial % 20, "rtpg"), back;
        uint8_t number[LW_JOINT_MAX];
        lw_lam a, b;
        char text[LW_LAM_SIZE];
        lw_lam_from_mechanism(&m, &a);
        for (int j = 0; j < a.n_joint/2; j++) {        /* another numbering: swap j and its mirror */
            int k = a.n_joint - 1 - j;
            a.number[m.link[j][0]][m.link[j][1]] = (uint8_t)(k + 1);
            a.number[m.link[k][0]][m.link[k][1]] = (uint8_t)(j + 1);
            a.kind[k] = m.kind[j];
            a.kind[j] = m.kind[k];
        }
        size_t n = lw_lam_print(&a, text, sizeof text);
        CHECK(n < sizeof text);
        CHECK_INT(lw_lam_read(text, n, NULL, &b, NULL), LW_OK);
        CHECK(!memcmp(&a, &b, sizeof a));
        lw_lam_mechanism(&b, &back, number);
        CHECK(lw_mechanism_same(&m, &back));
        for (int j = 0; j < m.n_joint; j++)
            CHECK_INT(number[j], m.n_joint - j);
    }
}

/* The adjacency matrix of any chain, symmetric or its upper triangle, gives the chain. */
TEST(plain_matrices)
{
    static const char *const cut[] = { " ", ",", " , " };
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 300; trial++) {
        lw_mechanism m = random_topology(&rng, 2 + trial % 11, trial % 20, "r"), back;
        char text[4096];
        size_t n = 0;
        lw_chain c;
        lw_lam a;
        lw_error e = { 0 };
        lw_mechanism_chain(&m, &c);
        for (int i = 0; i < m.n_link; i++)
            for (int k = 0; k < m.n_link; k++) {
                int one = lw_chain_freedom(&c, i, k) > 0 && (k > i || trial & 1);
                n += (size_t)snprintf(text + n, sizeof text - n, "%d%s", one, k + 1 < m.n_link ? cut[trial % 3] : "\n");
            }
        CHECK_INT(lw_lam_read(text, n, NULL, &a, &e), LW_OK);
        lw_lam_mechanism(&a, &back, NULL);
        CHECK(lw_mechanism_same(&m, &back));
    }
    lw_lam a;
    lw_error e;
    CHECK_INT(lw_lam_read("0 1 1\n1 0 1\n0 1 0\n", 18, NULL, &a, &e), LW_OK);
    CHECK_INT(lw_lam_read("0 0 1\n1 0 1\n0 1 0\n", 18, NULL, &a, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "mirror");
}

TEST(other_ways_to_write_it)
{
    static const char *const same[] = {
        "0 1 0 2;0 0 3 0;0 0 0 4p;0 0 0 0", "# a four-bar\n0 1 0 2\r\n\n1 0 3 0\n0 3 0 4p # p\n2 0 4p 0\n",
        "0\t1 0 2\n0 0 3 0\n0 0 0 4p\n0 0 0 0",
    };
    lw_lam first, other;
    CHECK_INT(lw_lam_read(same[0], strlen(same[0]), NULL, &first, NULL), LW_OK);
    CHECK_INT(first.kind[3], 'p');
    for (size_t i = 1; i < sizeof same/sizeof *same; i++) {
        CHECK_INT(lw_lam_read(same[i], strlen(same[i]), NULL, &other, NULL), LW_OK);
        CHECK(!memcmp(&first, &other, sizeof first));
    }
}

TEST(faults_have_a_place)
{
    static const struct { const char *text; long line, column; const char *part; } known[] = {
        { "", 1, 1, "no matrix" },
        { "# nothing\n", 2, 1, "no matrix" },
        { "0 1 2\n0 0 1\n0 0 0\n", 2, 5, "numbered twice: first at line 1, column 3" },
        { "0 1\n0 2\n", 2, 3, "link 2 is joined to itself" },
        { "0 1 2\n0 0\n", 2, 4, "row 2 has 2 entries" },
        { "0 1 2\n0 0 3\n", 3, 1, "must be square" },
        { "0 1 3\n0 0 4\n0 0 0\n", 2, 5, "no joint 2" },
        { "0 1k\n0 0\n", 1, 4, "'k' is no joint letter" },
        { "0 x\n0 0\n", 1, 3, "'x' where a joint number" },
        { "0 0p\n0 0\n", 1, 4, "takes no joint letter" },
        { "0 1 2\n0 0 3\n0 2 0\n", 3, 3, "mirror image" },
        { "0 65\n0 0\n", 1, 3, "at most 64" },
        { "0 9999999999\n0 0\n", 1, 3, "where a joint number" },
        { "0 -1\n0 0\n", 1, 3, "'-'" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_lam a;
        lw_error e = { 0 };
        CHECK_INT(lw_lam_read(known[i].text, strlen(known[i].text), "m.lam", &a, &e), LW_E_NOTATION);
        CHECK_INT(e.line, known[i].line);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
    }
}

TEST(too_large)
{
    char text[4096] = "";
    lw_lam a;
    for (int i = 0; i < 33; i++)
        strcat(text, "0 ");
    CHECK_FAILS(lw_lam_read(text, strlen(text), NULL, &a, &check_error), LW_E_NOTATION, "more than 32 entries");
    text[0] = '\0';
    for (int i = 0; i < 33; i++)
        strcat(text, "0\n");
    CHECK_INT(lw_lam_read(text, strlen(text), NULL, &a, &check_error), LW_E_NOTATION);
}

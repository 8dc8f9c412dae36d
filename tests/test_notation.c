/* Every notation by its row, told apart by how it begins, and streams of all of them mixed. */
#include "check.h"
#include "grammar/topology/graph6.h"
#include "grammar/topology/notation.h"
#include "topology.h"

TEST(every_row_reads_what_it_prints)
{
    static char text[LW_NOTATION_SIZE];
    lw_rng rng = check_rng(1);
    for (const lw_notation *n = lw_notations; n->name; n++) {
        CHECK(lw_notation_find(n->name) == n);
        CHECK(n->most <= sizeof text);
        for (int trial = 0; trial < 300; trial++) {
            lw_mechanism m = random_topology(&rng, 2 + trial % 20, trial % 20, "r"), back;
            lw_chain a, b;
            size_t length;
            lw_status s = n->print(&m, text, sizeof text, &length);
            if (!n->read || s != LW_OK) {
                CHECK(!n->read || !strcmp(n->name, "franke"));          /* links with one joint */
                continue;
            }
            CHECK(length < n->most);
            CHECK_INT(text[length - 1] == '\n', n->lines);
            CHECK(lw_notation_of(text, length) == n);
            CHECK_INT(n->read(text, length, NULL, &back, NULL), LW_OK);
            lw_mechanism_chain(&m, &a);
            lw_mechanism_chain(&back, &b);
            if (strcmp(n->name, "franke") != 0)                          /* which renames links */
                CHECK(lw_chain_same(&a, &b));
        }
    }
    CHECK(!lw_notation_find("tgf"));
}

/* Thirty topologies in all notations, with empty lines and remarks between. */
TEST(mixed_stream)
{
    static char text[1 << 16], piece[LW_NOTATION_SIZE];
    lw_mechanism want[30], got;
    size_t n = 0, length;
    lw_rng rng = check_rng(2);
    for (int i = 0; i < 30; i++) {
        static const char *const names[] = { "graph6", "lam", "sentence", "edges", "json" };
        const lw_notation *row = lw_notation_find(names[i % 5]);
        want[i] = random_topology(&rng, 2 + i % 9, 5, "r");
        CHECK_INT(row->print(&want[i], piece, sizeof piece, &length), LW_OK);
        n += (size_t)sprintf(text + n, "%s\n%s", piece, i % 3 ? "" : "\n# a remark\n\n");
    }
    lw_topologies t = lw_topologies_open(text, n, "mixed");
    for (int i = 0; i < 30; i++) {
        CHECK_SILENT(lw_topologies_next(&t, &got, &check_error));
        CHECK(lw_mechanism_same(&got, &want[i]));
    }
    CHECK_INT(lw_topologies_next(&t, &got, NULL), LW_NOTHING);
}

/* A stream that comes in pieces of any size says the same as the whole. */
TEST(in_portions)
{
    static const char text[] = "# first\n\nCl\n0 1 0 2\n0 0 3 0\n0 0 0 4\n0 0 0 0\n\n((1 r 2 r 3 r 4 r)\n (1 r 2 r 3 r 4 r))\n"
                               "1-2 2-3 # no\n{\"links\": 2, \"joints\":\n[[1, 2]]}\n# Cl\n(3 3) 1-2:0 1-2:2 1-2:2\nC!\nCl";
    static const int is_good[] = { 1, 1, 1, 0, 1, 1, 0, 1 };
    for (size_t portion = 1; portion <= sizeof text; portion++) {
        size_t have = 0;
        int n = 0;
        lw_topologies t = lw_topologies_open(text, 0, "in");
        t.more = true;
        for (;;) {
            lw_mechanism m;
            lw_error e = { 0 };
            lw_status s = lw_topologies_next(&t, &m, &e);
            if (s == LW_NOTHING)
                break;
            if (s == LW_STOPPED) {
                have = have + portion < strlen(text) ? have + portion : strlen(text);
                t.size = have;
                t.more = have < strlen(text);
                continue;
            }
            CHECK_INT(s == LW_OK, is_good[n++]);
            if (n == 7)
                CHECK_INT(e.line, 16);
        }
        CHECK_INT(n, 8);
    }
}

/* After a fault the stream goes on with the next piece; faults have their place in the whole text. */
TEST(goes_on_after_a_fault)
{
    static const char text[] = "Cl\nC!\n1-2 2-2\n((1 r 2 r 3 r\n 4 k) (1 r))\n0 1\n0 2\n\n{\"links\": 2,\n"
                               "\"joints\": [[1, 1]]}\nCl x\n(3 3) 1-2:0\n\n  \nCl";
    static const struct { lw_status s; long line, column; } want[] = {
        { LW_OK, 0, 0 }, { LW_E_NOTATION, 2, 2 }, { LW_E_NOTATION, 3, 5 }, { LW_E_NOTATION, 5, 4 },
        { LW_E_NOTATION, 7, 3 }, { LW_E_NOTATION, 10, 12 }, { LW_E_NOTATION, 11, 4 },
        { LW_E_NOTATION, 12, 2 }, { LW_OK, 0, 0 }, { LW_NOTHING, 0, 0 },
    };
    lw_topologies t = lw_topologies_open(text, strlen(text), "in");
    for (size_t i = 0; i < sizeof want/sizeof *want; i++) {
        lw_mechanism m;
        lw_error e = { 0 };
        CHECK_INT(lw_topologies_next(&t, &m, &e), want[i].s);
        CHECK_INT(e.line, want[i].line);
        CHECK_INT(e.column, want[i].column);
    }
}

TEST(too_many_joints)
{
    lw_chain c;
    lw_mechanism m;
    char text[LW_GRAPH6_SIZE];
    lw_chain_clear(&c, 13);
    for (int i = 0; i < 13; i++)
        for (int k = 0; k < i; k++)
            lw_chain_join(&c, i, k, 1);
    size_t n = lw_graph6_print(&c, text, sizeof text);
    lw_topologies t = lw_topologies_open(text, n, NULL);
    CHECK_FAILS(lw_topologies_next(&t, &m, &check_error), LW_E_NOTATION, "more than 64 joints");
}

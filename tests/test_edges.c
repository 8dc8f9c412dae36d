#include "check.h"
#include "grammar/topology/edges.h"
#include "topology.h"

TEST(reads_back)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 1000; trial++) {
        lw_mechanism m = random_topology(&rng, 2 + trial % 30, trial % 30, "rtpg"), back;
        char text[LW_EDGES_SIZE];
        m.ground = trial % 3 ? trial % m.n_link : LW_NONE;
        m.output = trial % 2 ? (trial + 1) % m.n_link : LW_NONE;
        for (int j = 0; j < m.n_joint && m.n_input < trial % 4; j += 2)
            if (lw_joint_freedoms(m.kind[j]) == 1)
                m.input[m.n_input++] = (uint8_t)j;
        size_t n = lw_edges_print(&m, text, sizeof text);
        CHECK(n < sizeof text);
        CHECK_INT(lw_edges_read(text, n, NULL, &back, NULL), LW_OK);
        CHECK(lw_mechanism_same(&m, &back));
    }
}

/* DOT and GraphML written here are read back; documents of other programs give the same chain. */
TEST(documents)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 300; trial++) {
        lw_mechanism m = random_topology(&rng, 2 + trial % 31, 40 + trial % 20, "rtpg"), back;
        char text[LW_GRAPHML_SIZE];
        uint32_t joined = 0;
        for (int j = 0; j < m.n_joint; j++)
            joined |= 1u << m.link[j][0] | 1u << m.link[j][1];
        if (joined != (uint32_t)(((uint64_t)1 << m.n_link) - 1))
            continue;                                        /* a link without joint is not written */
        m.ground = trial % m.n_link;
        m.output = trial % 3 ? trial/3 % m.n_link : LW_NONE;
        for (int j = 0; j < m.n_joint && m.n_input < trial % 4; j++)
            if (lw_joint_freedoms(m.kind[j]) == 1)
                m.input[m.n_input++] = (uint8_t)j;
        CHECK_INT(lw_dot_read(text, lw_dot_print(&m, "m", text, sizeof text), NULL, &back, NULL), LW_OK);
        CHECK(lw_mechanism_same(&m, &back));
        CHECK_INT(lw_graphml_read(text, lw_graphml_print(&m, text, sizeof text), NULL, &back, NULL), LW_OK);
        CHECK(lw_mechanism_same(&m, &back));
    }
    static const char *const dot[] = {
        "graph { 0--1--2--3--0 }", ("strict graph \"x\" { node [shape=box]; rankdir=LR; a -- b // crank\n; b -- c\n"
        "/* two */ c -- d -- a [color=\"red\", label=\"A\"] }\n"),
        "graph g {4;3;2;1; 1--2; 2--3; 3--4; 4--1 [weight=1.5]}",
    };
    static const char graphml[] =              /* as networkx writes it */
        "<?xml version='1.0' encoding='utf-8'?>\n<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n"
        "<!-- <node> --><key id=\"d0\" for=\"edge\" attr.name=\"weight\" attr.type=\"long\"/>\n"
        "<graph edgedefault=\"undirected\"><node id=\"n0\"/><node id=\"n1\"/><node id=\"n2\"/><node id=\"n3\"/>\n"
        "<edge source=\"n0\" target=\"n1\"><data key=\"d0\">1</data></edge><edge source=\"n1\" target='n2'/>\n"
        "<edge source=\"n2\" target=\"n3\"/><edge source=\"n3\" target=\"n0\"/></graph></graphml>\n";
    lw_mechanism m, ring;
    lw_error e;
    CHECK_INT(lw_edges_read("1-2 2-3 3-4 1-4", 15, NULL, &ring, NULL), LW_OK);
    for (int k = 0; k < 3; k++) {
        CHECK_INT(lw_dot_read(dot[k], strlen(dot[k]), NULL, &m, &e), LW_OK);
        CHECK(lw_mechanism_same(&m, &ring));
    }
    CHECK_INT(lw_graphml_read(graphml, strlen(graphml), NULL, &m, &e), LW_OK);
    CHECK(lw_mechanism_same(&m, &ring));
    static const struct { const char *text, *part; long line, column; } fault[] = {
        { "graph {\n 1 -> 2 }", "no direction", 2, 4 },        { "digraph { 1 }", "begins with the word graph", 1, 1 },
        { "graph { 1--1 }", "joined to itself", 1, 12 },       { "graph { 1--2; 2--1 }", "joined twice", 1, 18 },
        { "graph { 1--2", "cut short", 1, 13 },                { "graph { subgraph s { 1--2 } }", "subgraphs", 1, 9 },
        { "graph { 1--2; 3 }", "link 3 has no joint", 1, 1 },  { "graph { }", "no joint", 1, 1 },
        { "graph { 1--2 [label=\"r] }", "do not close", 1, 21 },
    };
    for (size_t k = 0; k < sizeof fault/sizeof *fault; k++) {
        CHECK_INT(lw_dot_read(fault[k].text, strlen(fault[k].text), NULL, &m, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, fault[k].part);
        CHECK_INT(e.line, fault[k].line);
        CHECK_INT(e.column, fault[k].column);
    }
    CHECK_FAILS(lw_graphml_read(graphml, strlen(graphml) - 12, NULL, &m, &check_error), LW_E_NOTATION, "cut short");
    CHECK_FAILS(lw_graphml_read("<graphml><graph edgedefault='directed'>", 39, NULL, &m, &check_error), LW_E_NOTATION, "no direction");
}

TEST(as_documented)
{
    static const char text[] = "1-2! 1-4 2-3 3-4:p @1 >3";
    lw_mechanism m;
    char out[LW_EDGES_SIZE], dot[LW_DOT_SIZE];
    CHECK_INT(lw_edges_read("3-4:p  4-1 2-1! >3 3-2 @1\n", 26, NULL, &m, NULL), LW_OK);
    lw_edges_print(&m, out, sizeof out);
    CHECK_TEXT(out, text);
    lw_dot_print(&m, "m", dot, sizeof dot);
    CHECK_HAS(dot, "graph m {");
    CHECK_HAS(dot, "  1 [shape=doublecircle];\n");
    CHECK_HAS(dot, "  3 -- 4 [label=\"p\"];\n");
    CHECK_HAS(dot, "  1 -- 2 [label=\"r\" penwidth=3];\n");
}

/* The largest topology fits the documented sizes. */
TEST(sizes)
{
    lw_rng rng = check_rng(2);
    lw_mechanism m = random_topology(&rng, 32, 600, "t");
    char out[LW_GRAPHML_SIZE];
    CHECK_INT(m.n_joint, LW_JOINT_MAX);
    m.ground = m.output = 31;
    for (; m.n_input < LW_INPUT_MAX; m.n_input++)
        m.input[m.n_input] = (uint8_t)(m.n_joint - LW_INPUT_MAX + m.n_input);
    CHECK(lw_edges_print(&m, out, sizeof out) < LW_EDGES_SIZE);
    CHECK(lw_dot_print(&m, "m", out, sizeof out) < LW_DOT_SIZE);
    CHECK(lw_graphml_print(&m, out, sizeof out) < LW_GRAPHML_SIZE);
    CHECK_HAS(out, "</graphml>");
    CHECK_INT(lw_graphml_print(&m, out, 10), lw_graphml_print(&m, NULL, 0));
    CHECK_INT(strlen(out), 9);
}

TEST(faults_have_a_column)
{
    static const struct { const char *text; long column; const char *part; } known[] = {
        { "", 1, "no joint" },
        { "1-2 2-2", 5, "link 2 is joined to itself" },
        { "1-2 2-3 2-1", 9, "2 and 1 are joined twice" },
        { "1-2:k", 5, "'k' is no joint letter" },
        { "1-2:p!", 6, "one freedom" },
        { "1-33", 3, "numbered 1 to 32" },
        { "0-1", 1, "numbered 1 to 32" },
        { "1 2", 2, "'-' between two links" },
        { "1-2 1-4 2-4", 1, "no link 3" },
        { "1-2 @3", 5, "link 3 has no joint" },
        { "1-2 >1 >2", 8, "second output" },
        { "1-2 @x", 6, "'x' where a link" },
        { "1-2\n1-3", 1, "one line" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_mechanism m;
        lw_error e = { 0 };
        CHECK_INT(lw_edges_read(known[i].text, strlen(known[i].text), NULL, &m, &e), LW_E_NOTATION);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
    }
}

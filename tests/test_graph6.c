/* graph6 against words written by nauty's tools, and back. */
#include "check.h"
#include "grammar/topology/graph6.h"
#include "topology.h"

TEST(known_words)
{
    /* geng 2.8.6 and its formats.txt: "DQc" is the graph with edges 0-2, 0-4, 1-3, 3-4 */
    static const struct { const char *word; int n; uint8_t pair[9][2]; int n_joint; } known[] = {
        { "DQc", 5, { {0,2}, {0,4}, {1,3}, {3,4} }, 4 },
        { "Cl", 4, { {0,1}, {1,2}, {2,3}, {0,3} }, 4 },
        { "Bw", 3, { {0,1}, {0,2}, {1,2} }, 3 },
        { "A_", 2, { {0,1} }, 1 },
        { "@", 1, { {0,0} }, 0 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_chain c, want;
        char word[LW_GRAPH6_SIZE];
        lw_chain_clear(&want, known[i].n);
        for (int j = 0; j < known[i].n_joint; j++)
            lw_chain_join(&want, known[i].pair[j][0], known[i].pair[j][1], 1);
        CHECK_INT(lw_graph6_read(known[i].word, strlen(known[i].word), NULL, &c, NULL), LW_OK);
        CHECK(lw_chain_same(&c, &want));
        CHECK_INT(lw_graph6_print(&want, word, sizeof word), strlen(known[i].word));
        CHECK_TEXT(word, known[i].word);
    }
}

TEST(reads_back)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 2000; trial++) {
        lw_mechanism m = random_topology(&rng, 1 + trial % LW_LINK_MAX, trial % 40, trial % 2 ? "r" : "rp");
        lw_chain c, back;
        char line[LW_GRAPH6_SIZE + 16];
        lw_mechanism_chain(&m, &c);
        size_t n = lw_graph6_print(&c, line, LW_GRAPH6_SIZE);
        CHECK(n < LW_GRAPH6_SIZE);
        CHECK_INT(lw_graph6_print(&c, NULL, 0), n);
        strcpy(line + n, trial % 3 ? "\r\n" : "");
        CHECK_INT(lw_graph6_read(line, strlen(line), NULL, &back, NULL), LW_OK);
        CHECK(lw_chain_same(&c, &back));
    }
}

TEST(faults_have_a_column)
{
    static const struct { const char *text; long column; const char *part; } known[] = {
        { "", 1, "a graph6 word was expected" },
        { "\n", 1, "the end of the line" },
        { "C", 2, "1 more byte is due" },
        { "C]]", 3, "after the end" },
        { "E?!", 3, "no byte of graph6" },
        { "EQj\x80", 4, "byte 0x80" },
        { "EQjO", 1, NULL },
        { "E", 2, "3 more bytes are due" },
        { "Bx", 2, "beyond the last pair" },
        { ":Fa@x^", 1, "sparse6" },
        { "&C@", 1, "digraph6" },
        { "?", 1, "no vertex" },
        { "`", 1, "more than 32" },
        { "~?@?", 1, "more than 32" },
        { ">>graph6<<C!", 12, "no byte" },
        { "Cl Bw", 4, "second word has 3 links" },
        { "Cl CN", 4, "links 2 and 4" },
        { "Cl C@ x", 7, "after the end" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_chain c;
        lw_error e = { 0 };
        lw_status s = lw_graph6_read(known[i].text, strlen(known[i].text), "in", &c, &e);
        if (!known[i].part) {
            CHECK_INT(s, LW_OK);
            continue;
        }
        CHECK_INT(s, LW_E_NOTATION);
        CHECK_INT(e.line, 1);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
    }
}

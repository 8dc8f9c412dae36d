/* Sentences of the source, and what every sentence must keep: a = L + 1 words, every joint in two of
 * them, the same chain after reading. */
#include "check.h"
#include "grammar/topology/sentence.h"
#include "topology.h"

#define WATT "((1 r 2 r 3 r 4 r 5 r 6 r) (1 r 2 r 3 r 4 r) (1 r 4 r 5 r 6 r))"

static lw_status read_text(const char *text, lw_sentence *s, lw_error *e)
{
    return lw_sentence_read(text, strlen(text), "in", s, e);
}

/* Makkonen 1999, paper F, eq. 18, 19. */
TEST(watt_as_printed)
{
    lw_chain c = watt_chain(), back;
    lw_mechanism m, from_text;
    lw_sentence s;
    char text[LW_SENTENCE_SIZE];
    lw_mechanism_from_chain(&c, &m);
    CHECK_INT(lw_sentence_from_mechanism(&m, &s), LW_OK);
    lw_sentence_print(&s, text, sizeof text);
    CHECK_TEXT(text, WATT);
    CHECK_INT(read_text("; Watt II\n((1 r 2 r 3 r\n  4 r 5 r 6 r)\n (1 r 2 r 3 r 4 r)\n (1 r 4 r 5 r 6 r))\n", &s, NULL), LW_OK);
    CHECK_INT(lw_sentence_mechanism(&s, &from_text, NULL), LW_OK);
    CHECK(lw_mechanism_same(&m, &from_text));
    lw_mechanism_chain(&from_text, &back);
    CHECK(lw_chain_same(&c, &back));
}

TEST(random_chains_read_back)
{
    static lw_sentence s, again;
    static char text[LW_SENTENCE_SIZE];
    int n_basis = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 1500; trial++) {
        lw_mechanism m = random_topology(&rng, 2 + trial % 15, trial % 17, "rtpg"), back;
        CHECK_INT(lw_sentence_from_mechanism(&m, &s), LW_OK);
        n_basis += s.basis;
        CHECK_INT(s.n_word >= m.n_joint - m.n_link + 1 + !s.basis, 1);
        size_t n = lw_sentence_print(&s, text, sizeof text);
        CHECK(n < sizeof text);
        CHECK_INT(read_text(text, &again, NULL), LW_OK);
        CHECK_INT(again.n_word, s.n_word);
        CHECK(!memcmp(again.part, s.part, sizeof s.part) && !memcmp(again.joint, s.joint, sizeof s.joint));
        CHECK_INT(lw_sentence_mechanism(&again, &back, NULL), LW_OK);
        CHECK(lw_mechanism_same(&m, &back));
    }
    CHECK(n_basis > 100 && n_basis < 1400);
}

/* Words may begin anywhere and turn either way. */
TEST(words_may_turn)
{
    lw_sentence s;
    lw_mechanism m, want;
    CHECK_INT(read_text(WATT, &s, NULL), LW_OK);
    CHECK_INT(lw_sentence_mechanism(&s, &want, NULL), LW_OK);
    CHECK_INT(read_text("((4 r 3 r 2 r 1 r) (3 r 4 r 5 r 6 r 1 r 2 r) (6 r 5 r 4 r 1 r))", &s, NULL), LW_OK);
    CHECK_INT(lw_sentence_mechanism(&s, &m, NULL), LW_OK);
    CHECK(lw_mechanism_same(&m, &want));
}

TEST(not_planar)
{
    lw_chain c = nonplanar_chain();
    lw_mechanism m;
    lw_sentence s;
    char text[LW_SENTENCE_SIZE];
    CHECK_INT(lw_chain_mobility(&c), 1);
    CHECK_INT(lw_chain_check(&c, NULL), LW_OK);
    lw_mechanism_from_chain(&c, &m);
    CHECK_INT(lw_sentence_from_mechanism(&m, &s), LW_OK);
    CHECK(s.basis);
    CHECK_INT(s.n_word, 4);                                 /* L circuits, no outer region */
    lw_sentence_print(&s, text, sizeof text);
    CHECK(!strncmp(text, "(basis (", 8));
    s.basis = false;
    CHECK_FAILS(lw_sentence_mechanism(&s, &m, &check_error), LW_E_NOTATION, "each joint separates two regions");
}

/* A chain in pieces at link 1, and a bridge joint 4-5: the outer word passes them twice. */
TEST(fractionated)
{
    static const char *const text[] = {
        "((1 r 2 r 3 r 4 r 1 r 5 r 6 r 7 r) (1 r 2 r 3 r 4 r) (1 r 5 r 6 r 7 r))",
        "((1 r 2 r 3 r 4 r 5 r 6 r 7 r 8 r 5 r 4 r) (1 r 2 r 3 r 4 r) (5 r 6 r 7 r 8 r))",
        "((1 p 2 p))",
    };
    for (size_t i = 0; i < sizeof text/sizeof *text; i++) {
        lw_sentence s;
        lw_mechanism m, back;
        CHECK_SILENT(read_text(text[i], &s, &check_error));
        CHECK_INT(lw_sentence_mechanism(&s, &m, NULL), LW_OK);
        CHECK_INT(lw_sentence_from_mechanism(&m, &s), LW_OK);
        CHECK_INT(lw_sentence_mechanism(&s, &back, NULL), LW_OK);
        CHECK(lw_mechanism_same(&m, &back));
    }
}

TEST(faults_have_a_place)
{
    static const struct { const char *text; long line, column; const char *part; } known[] = {
        { "", 1, 1, "begins with '('" },
        { "1 r 2 r", 1, 1, "begins with '(', not '1'" },
        { "()", 1, 1, "no word" },
        { "(())", 1, 2, "empty" },
        { "((1 r 2 r 3 r 4 r)\n (1 r 2 r 3 r 4 r", 2, 2, "this word is not closed" },
        { "((1 r 2 r 3 r 4 (1 r 2 r 3 r 4 r))", 1, 2, "this word is not closed" },
        { "((1 r 2 r 3 r 4 r)\n (1 r 2 r 3 r 4 r)", 1, 1, "this sentence is not closed" },
        { "((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r)) x", 1, 39, "after the end" },
        { "((1 r 2 k 3 r))", 1, 9, "'k' is no joint letter" },
        { "((1 r 2 r 3))", 1, 12, "joint letter is missing" },
        { "((r 1 r 2))", 1, 3, "'r' where a part number" },
        { "(x)", 1, 2, "'x' where a word" },
        { "((1 r 2 r 2 r 3 r))", 1, 7, "part 2 is joined to itself" },
        { "((1 r))", 1, 3, "part 1 is joined to itself" },
        { "((1 r 2 r 3 r 1 r))", 1, 15, "part 1 is joined to itself" },
        { "((0 r 1 r))", 1, 3, "numbered 1 to 32" },
        { "((1 r 2 r 33 r))", 1, 11, "numbered 1 to 32" },
        { "((1 r 2 r 3 r 4 r) (1 r 2 r 3 t 4 r))", 1, 29, "3 and 4 is t here and r elsewhere" },
        { "((1 r 2 r 3 r 5 r) (1 r 2 r 3 r 5 r))", 1, 2, "no part 4" },
        { "((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r))", 1, 39, "side of 3 words" },
        { "((1 r 2 r 3 r 4 r))", 1, 3, "side of 1 word only" },
        { "((1 r 2 r 3 r) (1 r 2 r 3 r) (4 r 5 r 6 r) (4 r 5 r 6 r))", 1, 2, "nothing connects" },
        { "((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r) (1 r 5 r 6 r 7 r) (1 r 5 r 6 r 7 r))", 1, 2,
          "make 3 regions, but there are 4 words" },
        { "(basis (1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r))", 1, 26, "follows from those before" },
        { "(basis (1 r 2 r 3 r 4 r) (1 r 2 r))", 1, 27, "bridge joint" },
        { "(basis (1 r 2 r 3 r 1 r 4 r 5 r))", 1, 21, "passes part 1 once" },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        static lw_sentence s;
        lw_error e = { 0 };
        CHECK_INT(read_text(known[i].text, &s, &e), LW_E_NOTATION);
        CHECK_INT(e.line, known[i].line);
        CHECK_INT(e.column, known[i].column);
        CHECK_HAS(e.text, known[i].part);
    }
}

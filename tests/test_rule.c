/* The rules as printed: eq. 21 to 25 of paper F, and F = 1 with no rigid part kept by every step. */
#include "check.h"
#include "grammar/topology/growth.h"
#include "topology.h"

static void check_says(const lw_sentence *s, const char *want)
{
    char text[LW_SENTENCE_SIZE];
    lw_sentence_print(s, text, sizeof text);
    CHECK_TEXT(text, want);
}

static lw_sentence planted(int rule, const char *kinds)
{
    lw_production p = lw_production_of(rule);
    lw_sentence s;
    memcpy(p.kind, kinds, strlen(kinds));
    CHECK_INT(lw_rule_plant(&p, &s, NULL), LW_OK);
    return s;
}

TEST(seeds)
{
    lw_sentence crank = planted(1, "rt"), four = planted(2, "rtrr");
    check_says(&crank, "((1 r 2 t 3 p) (1 r 2 t 3 p))");                          /* eq. 21 */
    check_says(&four, "((1 r 2 t 3 r 4 r) (1 r 2 t 3 r 4 r))");                   /* eq. 22 */
}

/* Makkonen 1999, paper F, eq. 25: a piston-crank between parts 3 and 4 of a four-bar. */
TEST(example_of_the_source)
{
    lw_sentence s = planted(2, "rrrr");
    lw_production p = lw_production_of(3);
    lw_mechanism m;
    lw_chain c;
    p.x = 3;
    p.y = 4;
    CHECK_INT(lw_rule_apply(&s, &p, &s, NULL), LW_OK);
    check_says(&s, "((1 r 2 r 3 r 5 p 4 r) (4 r 3 r 5 p) (1 r 2 r 3 r 4 r))");
    CHECK_INT(lw_sentence_mechanism(&s, &m, NULL), LW_OK);
    lw_mechanism_chain(&m, &c);
    CHECK_INT(lw_chain_mobility(&c), 1);
    CHECK_INT(lw_chain_check(&c, NULL), LW_OK);
}

/* Rule 4 between 1 and 4 of the outer word gives Watt's chain, eq. 19, but for the order of words. */
TEST(watt_by_rule_4)
{
    lw_sentence s = planted(2, "rrrr"), from_chain;
    lw_production p = lw_production_of(4);
    lw_mechanism m;
    lw_chain c = watt_chain(), got;
    p.x = 4;
    p.y = 1;
    CHECK_INT(lw_rule_apply(&s, &p, &s, NULL), LW_OK);
    check_says(&s, "((1 r 2 r 3 r 4 r 5 r 6 r) (1 r 4 r 5 r 6 r) (1 r 2 r 3 r 4 r))");
    CHECK_INT(lw_sentence_mechanism(&s, &m, NULL), LW_OK);
    lw_mechanism_chain(&m, &got);
    CHECK(lw_chain_same(&c, &got));
    lw_sentence_from_mechanism(&m, &from_chain);
    check_says(&from_chain, "((1 r 2 r 3 r 4 r 5 r 6 r) (1 r 2 r 3 r 4 r) (1 r 4 r 5 r 6 r))");
}

static lw_production random_step(lw_rng *rng, const lw_sentence *s)
{
    lw_production p = lw_production_of(3 + (int)lw_rng_range(rng, 0, 2));
    p.word = (int)lw_rng_range(rng, 0, s->n_word);
    int n = s->first[p.word + 1] - s->first[p.word], i = (int)lw_rng_range(rng, 0, n);
    int k = (i + 1 + (int)lw_rng_range(rng, 0, n - 1)) % n;
    p.x = s->part[s->first[p.word] + i];
    p.y = s->part[s->first[p.word] + k];
    for (int q = 0; q < 3; q++)
        p.kind[q] = lw_rng_bits(rng) & 1 ? 'r' : 't';
    return p;
}

/* Any rule anywhere: the words stay the regions of a drawing, F stays 1, nothing gets rigid, and the
 * sentence says the same as the step done on links and joints. */
TEST(every_step_keeps_its_promises)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        lw_sentence s = trial % 2 ? planted(1, "rr") : planted(2, "rtrr");
        lw_mechanism m, same;
        CHECK_INT(lw_sentence_mechanism(&s, &same, NULL), LW_OK);
        while (same.n_link < 24) {
            lw_production p = random_step(&rng, &s);
            lw_chain c;
            CHECK_OK(lw_rule_apply(&s, &p, &s, &check_error));
            CHECK_INT(lw_mechanism_grow(&same, &p), LW_OK);
            CHECK_SILENT(lw_sentence_mechanism(&s, &m, &check_error));
            CHECK(lw_mechanism_same(&m, &same));
            lw_mechanism_chain(&m, &c);
            CHECK_INT(lw_chain_mobility(&c), 1);
            CHECK_INT(lw_chain_check(&c, NULL), LW_OK);
            CHECK_INT(s.n_word, m.n_joint - m.n_link + 2);
        }
    }
}

TEST(refusals)
{
    lw_sentence s = planted(2, "rrrr"), before = s;
    lw_production p = lw_production_of(4);
    lw_error e = { 0 };
    char text[80];
    p.x = p.y = 2;
    CHECK_FAILS(lw_rule_apply(&s, &p, &s, &check_error), LW_E_ARG, "joined to itself");
    p.y = 5;
    CHECK_FAILS(lw_rule_apply(&s, &p, &s, &check_error), LW_E_ARG, "no word holds both part 2 and part 5");
    p.word = 7;
    CHECK_FAILS(lw_rule_apply(&s, &p, &s, &check_error), LW_E_ARG, "word 8 does not hold");
    p = (lw_production){ .rule = 4, .word = 0, .x = 1, .y = 3, .kind = "rpr" };
    CHECK_FAILS(lw_rule_apply(&s, &p, &s, &check_error), LW_E_ARG, "k = r or t");
    CHECK(!memcmp(&s, &before, sizeof s));
    p = lw_production_of(2);
    CHECK_FAILS(lw_rule_apply(&s, &p, &s, &check_error), LW_E_ARG, "grows nothing");
    p = lw_production_of(3);
    CHECK_FAILS(lw_rule_plant(&p, &s, &check_error), LW_E_ARG, "plants no seed");
    p = (lw_production){ .rule = 4, .word = 1, .x = 3, .y = 4, .kind = "rrt" };
    lw_production_print(&p, text, sizeof text);
    CHECK_TEXT(text, "rule 4 at 3,4 of word 2, k = r r t");
    p = lw_production_of(4);
    p.x = 1;
    p.y = 3;
    while (lw_rule_apply(&s, &p, &s, &e) == LW_OK)
        continue;
    CHECK_HAS(e.text, "more than 32 links");
    CHECK_INT(lw_sentence_mechanism(&s, &(lw_mechanism){ 0 }, NULL), LW_OK);
}

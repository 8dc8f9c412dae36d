/* grammar/topology/rule.h - the four production rules of the published grammar (Makkonen 1999, paper F, eqs.
 * 21 to 24), applied to sentences word by word as printed.
 *
 *     rule 1   M -> ((1 k 2 k 3 p) (1 k 2 k 3 p))                  seed, crank with pin in slot
 *     rule 2   M -> ((1 k 2 k 3 k 4 k) (1 k 2 k 3 k 4 k))          seed, four-bar
 *     rule 3   between X and Y of one word: new string  X r Q p Y
 *     rule 4   between X and Y of one word: new string  X k Q1 k Q2 k Y        k = r or t
 *
 * In the word, the new string replaces the old one that led from X to Y.  A new word is inserted after it: the
 * old string read back from Y to X, closed by the new one.  New parts get the next numbers.  F stays 1.  If the
 * rule is applied to an inner word, the new word turns opposite to the "clockwise" of the source; readers of
 * sentences accept both senses. */
#ifndef LW_GRAMMAR_TOPOLOGY_RULE_H
#define LW_GRAMMAR_TOPOLOGY_RULE_H

#include "grammar/topology/sentence.h"

typedef struct lw_production {
    int     rule;          /* 1 .. 4                                                                */
    int     word;          /* 3, 4: which word, from 0; LW_NONE: the first with X and Y             */
    uint8_t x, y;          /* 3, 4: parts as written, from 1                                        */
    char    kind[4];       /* the k's in order: rule 1 two, rule 2 four, rule 4 three; r or t       */
} lw_production;

/* Number of k's in a rule; 0 for rule 3 and for numbers that are no rule. */
int lw_rule_kinds(int rule);

/* Links a rule adds: 3, 4, 1, 2. */
int lw_rule_links(int rule);

/* A production with all k = r; X, Y and the word are not set. */
lw_production lw_production_of(int rule);

/* Rule 1 or 2.  LW_E_ARG for another rule or a kind that is not r or t. */
lw_status lw_rule_plant(const lw_production *p, lw_sentence *s, lw_error *e);

/* Rule 3 or 4 applied to s; out may be s.  LW_E_ARG with a text, out untouched: X = Y, no word holds
 * both, too many links or joints, another rule, a wrong kind. */
lw_status lw_rule_apply(const lw_sentence *s, const lw_production *p, lw_sentence *out, lw_error *e);

/* "rule 4 at 3,4 of word 1, k = r r t" into buf; returns the length as snprintf does. */
size_t lw_production_print(const lw_production *p, char *buf, size_t size);

#endif

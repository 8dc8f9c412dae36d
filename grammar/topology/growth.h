/* grammar/topology/growth.h - how rules 1 to 4 make a mechanism, or why they cannot.
 *
 * Read backwards, rule 4 removes a line of two binary links with joints r or t, and rule 3 removes a line of
 * one binary link with a pin r and a pin in slot p.  The rest at the end must be a seed.  The order of removal
 * does not matter: in a chain of F = 1 without rigid subchain a line between two circles has at most three
 * freedoms in its joints, so removable lines never overlap.  A removable line stays removable after another is
 * removed, unless only a ring is left; a ring of F = 1 without g is a seed.  So the first sequence of removals
 * that ends in a seed is as good as any, and one that gets stuck proves that there is none.
 *
 * The source also requires that X and Y lie at one region.  A planar drawing of the whole contains a drawing of
 * every part of it.  So a planar mechanism is reached by words exactly when it is reached at all, and a
 * mechanism whose graph is not planar never is.  docs/theory.md, "The published grammar", has the proof. */
#ifndef LW_GRAMMAR_TOPOLOGY_GROWTH_H
#define LW_GRAMMAR_TOPOLOGY_GROWTH_H

#include "grammar/topology/rule.h"

/* The derivation of one mechanism.  step[0] plants the seed, the others grow it. */
typedef struct lw_growth {
    int           n_step;
    lw_production step[LW_LINK_MAX];
    uint8_t       link_of[LW_LINK_MAX];   /* part n + 1 of the derivation is this link */
} lw_growth;

typedef enum lw_reach {
    LW_REACHED,             /* by words of regions, as printed                                     */
    LW_REACHED_NO_REGIONS,  /* only if X and Y need not lie at one region: the graph is not planar */
    LW_NOT_MOBILITY,        /* F is not 1, but all rules keep F = 1                                */
    LW_NOT_GEAR,            /* a joint g, which no rule makes                                      */
    LW_NOT_CORE             /* removal ends at a chain that is no seed and has no removable line   */
} lw_reach;

/* Find the derivation.  *reach gets the result; g is filled for LW_REACHED and LW_REACHED_NO_REGIONS.  *core
 * (may be NULL) gets, for LW_NOT_CORE, the links that remain when removal ends, as bits.  LW_E_ARG with the text
 * of lw_chain_check when m is no closed chain that moves. */
lw_status lw_growth_find(const lw_mechanism *m, lw_growth *g, lw_reach *reach, uint32_t *core, lw_error *e);

/* The reason as one sentence for the user; links count from 1.  Length as snprintf does. */
size_t lw_reach_print(const lw_mechanism *m, lw_reach reach, uint32_t core, char *buf, size_t size);

/* Replay the first n_step steps as sentences (LW_REACHED only), in the numbering of the derivation.  LW_E_ARG when a
 * step does not apply. */
lw_status lw_growth_sentence(const lw_growth *g, int n_step, lw_sentence *s, lw_error *e);

/* Apply one step to a mechanism; X and Y need not lie at one region.  Rules 1 and 2 begin a new mechanism.
 * LW_E_ARG as lw_rule_apply. */
lw_status lw_mechanism_grow(lw_mechanism *m, const lw_production *p);

#endif

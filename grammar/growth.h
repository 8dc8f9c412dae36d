/* grammar/growth.h - how rules 1 to 4 make a mechanism, or why they cannot.
 *
 * Read backwards, rule 4 takes away a line of two binary links with joints r or t, rule 3 a line of one
 * binary link with a pin r and a pin in slot p, and what is left in the end must be a seed.  Taking
 * away is confluent: in a chain of F = 1 without rigid subchain a line between two circles has at most
 * three freedoms in its joints, so lines that can go never overlap, and one that can go still can
 * after another went, unless only a ring is left; a ring of F = 1 without g is a seed.  So the first
 * way back that ends in a seed is as good as any, and one that gets stuck proves that there is none.
 *
 * The source demands more: X and Y at one region.  A planar drawing of the whole shows one of every
 * part of it, so a planar mechanism is reached by words exactly when it is reached at all, and one
 * whose graph is not planar is never. */
#ifndef LW_GRAMMAR_GROWTH_H
#define LW_GRAMMAR_GROWTH_H

#include "grammar/rule.h"

/* The derivation of one mechanism.  step[0] plants the seed, the others grow it. */
typedef struct lw_growth {
    int           n_step;
    lw_production step[LW_LINK_MAX];
    uint8_t       link_of[LW_LINK_MAX];   /* part n + 1 of the derivation is this link */
} lw_growth;

typedef enum lw_reach {
    LW_REACHED,             /* by words of regions, as printed                                     */
    LW_REACHED_NO_REGIONS,  /* only if X and Y need not lie at one region: the graph is not planar */
    LW_NOT_MOBILITY,        /* F is not 1, which all rules keep                                    */
    LW_NOT_GEAR,            /* a joint g, which no rule makes                                      */
    LW_NOT_CORE             /* taking away ends at a chain that is no seed and has no line to go   */
} lw_reach;

/* Find the derivation.  *reach tells; g is filled for the first two.  *core (may be NULL): for
 * LW_NOT_CORE the links left where taking away ends, as bits.  LW_E_ARG with the text of
 * lw_chain_check when m is no closed chain that moves. */
lw_status lw_growth_find(const lw_mechanism *m, lw_growth *g, lw_reach *reach, uint32_t *core,
                         lw_error *e);

/* One sentence that says why, links counted from 1. */
size_t lw_reach_print(const lw_mechanism *m, lw_reach reach, uint32_t core, char *buf, size_t size);

/* Replay the first n_step steps as sentences (LW_REACHED only), or as a mechanism, in the numbering of
 * the derivation.  LW_E_ARG when a step does not apply. */
lw_status lw_growth_sentence(const lw_growth *g, int n_step, lw_sentence *s, lw_error *e);
lw_status lw_growth_mechanism(const lw_growth *g, int n_step, lw_mechanism *m);

/* One step on a mechanism, X and Y wherever they are; rules 1 and 2 start anew.  LW_E_ARG as
 * lw_rule_apply. */
lw_status lw_mechanism_grow(lw_mechanism *m, const lw_production *p);

#endif

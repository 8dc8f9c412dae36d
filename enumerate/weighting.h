/* enumerate/weighting.h - the chains of one structure: binary links distributed over its lines.
 *
 * A chain with V circles, E lines and F freedoms has B = F + 3 + 2 E - 3 V binary links.  A weighting
 * w_e >= 0 with sum B gives a chain without rigid subchain exactly when no critical set of circles is
 * overfull (critical.h).  Two weightings give isomorphic chains exactly when an automorphism of the structure maps
 * one to the other.  So no chain needs a canonical form: the lexicographically largest weighting of each orbit is
 * kept, and structures without symmetry need no test at all.
 *
 * F = 0 (Baranov trusses): the whole chain has F = 0, so the set of all circles is exempt.  w_e <= 1, because
 * removing a line with two binary links would leave a rigid proper subchain. */
#ifndef LW_ENUMERATE_WEIGHTING_H
#define LW_ENUMERATE_WEIGHTING_H

#include <stddef.h>
#include "base/whole.h"
#include "grammar/topology/structure.h"

/* One structure prepared for one F.  Create one for each thread and prepare it for one structure after the other.
 * Functions with a const argument may be called from several threads. */
typedef struct lw_weighting lw_weighting;

lw_weighting *lw_weighting_create(void);                   /* NULL when out of memory */
void          lw_weighting_free(lw_weighting *w);

/* LW_E_ARG when dof is not 0 .. LW_DOF_MAX or the chains would have more than LW_LINK_MAX links; LW_E_MEMORY. */
lw_status lw_weighting_prepare(lw_weighting *w, const lw_structure *s, int dof);

const lw_structure *lw_weighting_structure(const lw_weighting *w);

/* One chain: weight[e] of each line.  A status other than LW_OK ends the walk and is returned by it. */
typedef lw_status lw_weighting_visit(void *context, const uint8_t *weight);

/* Visit every chain once, weightings in falling lexicographic order. */
lw_status lw_weighting_each(const lw_weighting *w, lw_weighting_visit *visit, void *context);

/* Numbers of chains, and of ways to choose a ground link of them up to symmetry.  n_labelled: the labelled chains where
 * labelled.h counts them, P! n_chain less the labelled chains where lw_weighting_excess does, otherwise 0. */
typedef struct lw_tally { uint64_t n_chain, n_ground; lw_whole n_labelled; } lw_tally;

/* LW_E_ARG: n_labelled is more than 2^128 - 1, and the sum is wrong. */
static inline lw_status lw_tally_add(lw_tally *sum, const lw_tally *n)
{
    sum->n_chain += n->n_chain;
    sum->n_ground += n->n_ground;
    return __builtin_add_overflow(sum->n_labelled, n->n_labelled, &sum->n_labelled) ? LW_E_ARG : LW_OK;
}

/* Labelled forms of a chain with n links and `order` automorphisms times `count`: count n!/order.  LW_E_ARG if it is too
 * large. */
static inline lw_status lw_labelled_forms(int n, uint64_t order, uint64_t count, lw_whole *labelled)
{
    bool fits = true;
    *labelled = count;
    for (int i = 2; i <= n; i++)
        fits = fits && !__builtin_mul_overflow(*labelled, (unsigned)i, labelled);
    *labelled /= order;
    return fits ? LW_OK : LW_E_ARG;
}

/* Both numbers without visiting each chain, by Burnside's lemma: the mean over all automorphisms of the number of
 * weightings, and of pairs of weighting and link, that the automorphism leaves unchanged.  The last binary link is
 * counted in closed form.  LW_E_MEMORY. */
lw_status lw_weighting_count(const lw_weighting *w, lw_tally *tally);

/* Only tally->n_labelled: P! times the mean over the automorphisms of circles and lines of the weightings that they leave
 * unchanged, without the identity.  With the labelled chains (labelled.h), which are P! times the share of the identity, it
 * gives P! times the chains, in a quarter of the time of _count.  LW_E_MEMORY; LW_E_ARG: more than 2^128 - 1. */
lw_status lw_weighting_excess(const lw_weighting *w, lw_tally *tally);

/* Links of the chain that are equivalent by symmetry: lowest[i] is the lowest link equivalent to link i, links
 * numbered as by lw_structure_chain.  lowest (P).  Returns the number of classes. */
int lw_weighting_orbits(const lw_weighting *w, const uint8_t *weight, uint8_t *lowest);

#endif

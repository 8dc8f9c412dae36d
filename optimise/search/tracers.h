/* optimise/search/tracers.h - several points of one mechanism: on which links they lie.
 *
 * The first tracer of a family is the point that is fitted.  Further points of a target lie on further tracers: those
 * that the family's linkage brings, else new ones.  Of the four-link types a point lies on the coupler and an angle
 * alone is that of the output (of the coupler, when the output is the first), unless the task names another link. */
#ifndef LW_OPTIMISE_SEARCH_TRACERS_H
#define LW_OPTIMISE_SEARCH_TRACERS_H

#include "optimise/search/families.h"

/* The linkage of a family with a tracer for every point of the target.  LW_E_KIND: it has no such link, or its
 * output only slides and has no angle. */
lw_status lw_tracers_linkage(const lw_family *f, const lw_target *t, const lw_fit_spec *s, lw_linkage *k, lw_error *e);

/* Those of a plan for this target: bits of lw_plan_outputs.tracers. */
unsigned lw_tracers_mask(const lw_target *t);

/* Families made of others, one for each choice of links for the points: those that bring a tracer for every point stay
 * as they are; of the rest one point lies where the family's tracer does, and the others on every link that suits them;
 * so also the first, on links that feel fewer links than the family has (a point that feels all is the tracer of a
 * family of its own).  A point lies on links not joined to the ground, an angle is that of any but the driven link,
 * unless the task says otherwise. */
#define LW_SPREAD_MAX 1000000

/* The family it is made from, the link of each point; -1 of the first: all tracers as the family brings them. */
typedef struct lw_tracer_choice { int family; signed char link[1 + LW_ALSO_MAX]; } lw_tracer_choice;

typedef struct lw_tracer_spread {
    int          n, capacity;
    lw_tracer_choice *choice;        /* (n) owned                                                   */
    lw_families  of;
    int          n_point;
} lw_tracer_spread;

/* LW_E_ARG: more than LW_SPREAD_MAX; LW_E_MEMORY.  Families of four links by type are not among the given ones. */
lw_status lw_tracers_spread(const lw_families *of, const lw_target *t, const lw_fit_spec *s,
                            lw_tracer_spread *out, lw_error *e);
void      lw_tracer_spread_free(lw_tracer_spread *spread);

/* What it holds as families; it must stay, as must those it was made from. */
lw_families lw_tracer_spread_families(const lw_tracer_spread *spread);

#endif

/* optimise/search/tracer_spread.h - families for every choice of links on which the points of a target may lie. */
#ifndef LW_OPTIMISE_SEARCH_TRACER_SPREAD_H
#define LW_OPTIMISE_SEARCH_TRACER_SPREAD_H

#include "optimise/search/families.h"

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

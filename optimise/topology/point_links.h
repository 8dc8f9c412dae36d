/* optimise/topology/point_links.h - for a target with several points: families for every choice of links that carry the
 * points. */
#ifndef LW_OPTIMISE_TOPOLOGY_POINT_LINKS_H
#define LW_OPTIMISE_TOPOLOGY_POINT_LINKS_H

#include "optimise/search/families.h"

#define LW_POINT_CHOICE_MAX 1000000

/* The family, and the link of each point; link[0] == -1: all tracers as in the family. */
typedef struct lw_point_choice { int family; signed char link[1 + LW_ALSO_MAX]; } lw_point_choice;

typedef struct lw_point_links {
    int              n, capacity;
    lw_point_choice *choice;         /* (n) owned                                                   */
    lw_families      of;
    int              n_point;
} lw_point_links;

/* List the choices for each of the given families, which are no four-link types.  A family with a tracer for every
 * point is one choice.  In other families at least one point lies on the link of the family's tracer, and the others
 * on every link that suits them.  The first point may also lie on a link whose motion depends on fewer links than the
 * family has; where it depends on all, that is the tracer of a family of its own.  A point suits links that are not
 * joined to the ground, an angle any but the driven link, unless spec.carrier says otherwise. LW_E_ARG: there are
 * more than LW_POINT_CHOICE_MAX; LW_E_MEMORY. */
lw_status lw_point_links_make(const lw_families *of, const lw_target *t, const lw_fit_spec *s, lw_point_links *out, lw_error *e);
void      lw_point_links_free(lw_point_links *links);

/* The choices as families; `links` must stay, as must the families that it was made from. */
lw_families lw_point_links_families(const lw_point_links *links);

#endif

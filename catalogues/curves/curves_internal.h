/* catalogues/curves/curves_internal.h - curves of topologies with more than four links. */
#ifndef LW_CATALOGUES_CURVES_CURVES_INTERNAL_H
#define LW_CATALOGUES_CURVES_CURVES_INTERNAL_H

#include "catalogues/curves/curves.h"
#include "optimise/problem/problem.h"

#define LW_CURVE_WORD 192             /* the text of a topology, or the name of a family            */

/* A ground, input and tracer link of a chain whose linkages a plan of dyads works out.  As text, of which it can be
 * made again: name=1-2r.1-3r.[...]=g1i1t4, joints with the links they join and their kind, ground, number of the
 * driven joint, link of the tracer; commas of the name as semicolons. */
typedef struct lw_curve_topology {
    char       name[64];
    lw_linkage linkage;               /* of this topology, anywhere                                 */
    lw_family  family;
    lw_problem problem;               /* what members are drawn of                                  */
} lw_curve_topology;

/* LW_E_ARG: too long for a text. */
lw_status lw_curve_topology_text(const char *name, const lw_linkage *k, char text[LW_CURVE_WORD]);

/* LW_E_NOTATION: no such text; LW_E_KIND: a plan of dyads does not do; LW_E_MEMORY. */
lw_status lw_curve_topology_make(const char *text, lw_curve_topology **t, lw_error *e);
void      lw_curve_topology_free(lw_curve_topology *t);

/* The member that belongs to a key, with an input that turns fully or, unless that is asked for, any: dim (n_dim) with
 * the tracer, mode (n_dyad), and the range of its input.  false: none.  work: 64-byte aligned. */
size_t lw_curve_topology_work_size(const lw_curve_topology *t);
bool   lw_curve_topology_draw(const lw_curve_topology *t, const uint32_t key[2], bool turns, void *work, double *dim,
                              double *mode, lw_range *range);

#endif

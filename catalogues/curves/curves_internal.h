/* catalogues/curves/curves_internal.h - curves of topologies with more than four links. */
#ifndef LW_CATALOGUES_CURVES_CURVES_INTERNAL_H
#define LW_CATALOGUES_CURVES_CURVES_INTERNAL_H

#include "catalogues/curves/curves.h"
#include "grammar/topology/mechanism.h"
#include "optimise/problem/problem.h"

#define LW_CURVE_WORD 192             /* the text of a topology, or the name of a family            */

/* A chain with ground, input and tracer link whose linkages a plan of dyads solves. Its text, from which it can be
 * made again, is name=1-2r.1-3r.[...]=g1i1t4: each joint with its links and kind, ground, number of the driven joint,
 * link of the tracer. Commas of the name become semicolons. */
typedef struct lw_curve_topology {
    char       name[64];
    lw_linkage linkage;               /* of this topology, with any dimensions                      */
    bool       slides;                /* it has a slider                                            */
    lw_family  family;
    lw_problem problem;               /* from which random linkages are drawn                       */
    void      *work;                  /* scratch of one thread for drawing them, owned               */
    void      *batch;                 /* and for postures of problem.plan, owned                     */
} lw_curve_topology;

/* LW_E_ARG: too long for a text. */
lw_status lw_curve_topology_text(const char *name, const lw_linkage *linkage, char text[LW_CURVE_WORD]);

/* Is it the text of a topology?  Whether dyads solve it shows when it is made. */
bool      lw_curve_topology_read(const char *text, char name[64], lw_mechanism *m);

/* LW_E_NOTATION: the text is wrong; LW_E_KIND: a plan of dyads does not solve it; LW_E_MEMORY. */
lw_status lw_curve_topology_make(const char *text, lw_curve_topology **t, lw_error *e);
void      lw_curve_topology_free(lw_curve_topology *t);

/* The linkage of a key: dim (n_dim) with the tracer, mode (n_dyad), and the range of its input. turns: the input must
 * turn fully. False: the key gives no linkage. */
bool      lw_curve_topology_draw(lw_curve_topology *t, const uint32_t key[2], bool turns, double *dim, double *mode, lw_range *range);

#endif

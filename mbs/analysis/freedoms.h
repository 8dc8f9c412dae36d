/* mbs/analysis/freedoms.h - how a planar model of any size moves: freedoms, redundant rows, links that stand still.
 *
 * The model is displaced along random motions of first order and its joints are closed again with a basis of its rows; the rank
 * there, and whether the other rows hold there, tell motion from a special posture.  Ranks follow from pivots of the sparse
 * factorisation of J M^-1 J^T, relative to 1e-10.  For up to 32 links mbs/constraints/mobility.h says more. */
#ifndef LW_MBS_ANALYSIS_FREEDOMS_H
#define LW_MBS_ANALYSIS_FREEDOMS_H

#include "grammar/model/model.h"
#include "mbs/constraints/mobility.h"

typedef struct lw_freedoms {
    lw_mobility_kind kind;
    int    n_body, n_q, n_row;
    int    count;                /* coordinates minus rows                                            */
    int    freedom;              /* dimension of the motion found through the posture                 */
    int    instant;              /* first-order freedoms in the posture                               */
    int    rank;                 /* of the rows along the motion; of a rigid model in the posture     */
    int    driven;               /* freedoms that the inputs determine                                */
    bool  *still, *loose;        /* (n_link) never moves; moves while the inputs rest                 */
    int    n_redundant;
    lw_system_row *redundant;    /* rows that follow from others                                      */
    double distance;             /* greatest change of a coordinate (sizes and radians)               */
    double residual;             /* greatest residual there [m]                                       */
} lw_freedoms;

/* tolerance: of a closed posture, relative to the size.  LW_OPEN: the posture does not close. */
lw_status lw_freedoms_find(const lw_model *m, double tolerance, uint64_t seed, lw_freedoms *f, lw_error *e);
void      lw_freedoms_free(lw_freedoms *f);

#endif

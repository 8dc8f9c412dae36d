/* mbs/space/space_adjust.h - overconstrained spatial linkages that move, drawn with rounded numbers: Bennett's, Bricard's, Sarrus'.
 *
 * Places and axes of joints change by the least squares that let them move (mbs/constraints/adjust.h); the drawn posture stays. */
#ifndef LW_MBS_SPACE_SPACE_ADJUST_H
#define LW_MBS_SPACE_SPACE_ADJUST_H

#include "grammar/model/spatial.h"

typedef struct lw_space_adjusted {
    double moved, turned;        /* greatest change of a joint's place [m], of an axis [rad]; 0: none          */
    lw_spatial model;            /* shares everything but the joints with the model given, which must outlive it */
} lw_space_adjusted;

/* Adjust the joints of m; elastic links count as rigid, couplings are left out.  LW_NOTHING: there is nothing to adjust, see lw_adjust;
 * out->model is m then.  lw_space_adjusted_free after success and failure. */
lw_status lw_space_adjust(const lw_spatial *m, lw_space_adjusted *out, lw_error *e);
void      lw_space_adjusted_free(lw_space_adjusted *a);

#endif

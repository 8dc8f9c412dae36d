/* mbs/analysis/held.h - the lowest eigenfrequency of a robot with its drives held, posture by posture.
 *
 * The elastic links stand undeformed in a posture of the rigid robot (mbs/space/robot.h); gravity, applied forces and motors are
 * left out, springs count. */
#ifndef LW_MBS_ANALYSIS_HELD_H
#define LW_MBS_ANALYSIS_HELD_H

#include "mbs/dynamics/dynamics_space.h"
#include "mbs/space/robot.h"

typedef struct lw_held {
    lw_spatial        model;             /* shares all but its inputs, which are the drives                  */
    lw_spatial_input *input;
    lw_dynamics      *d;
    double           *q;                 /* (n_q of d) */
    struct lw_tangent *kept;             /* matrices of the place before, whose pattern and pivots serve the next one */
} lw_held;

/* The model must outlive h.  LW_E_ARG: nothing can vibrate, or a link has no mass.  h needs lw_held_free, after a failure too. */
lw_status lw_held_make(const lw_spatial *m, lw_held *h, lw_error *e);
void      lw_held_free(lw_held *h);

/* In the posture that r, of the same model, stands in: [Hz]; 0: a free motion is left, or the posture is unstable. */
lw_status lw_held_frequency(lw_held *h, const lw_robot *r, double *frequency, lw_error *e);

#endif

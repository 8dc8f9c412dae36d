/* mbs/newton.h - the second opinion: any planar linkage of pins and sliders by Newton's method on
 * its loop equations (three coordinates a moving link, two equations a joint, one an input), sharing
 * no code with the plan.  Slow, general, used to verify. */
#ifndef LW_MBS_NEWTON_H
#define LW_MBS_NEWTON_H

#include "grammar/linkage.h"

typedef struct lw_newton lw_newton;

lw_status lw_newton_create(const lw_linkage *k, lw_newton **out, lw_error *e);
void      lw_newton_free(lw_newton *s);

/* Follow the branch of the posture from the present input to `input` by predictor and corrector with
 * steps that are cut until each correction is small against the step.  LW_OPEN when the motion ends
 * before (a limit), *reached tells where.  Positions then are those at *reached. */
lw_status lw_newton_move(lw_newton *s, double input, double *reached);

/* Back to the posture of the file. */
void      lw_newton_reset(lw_newton *s);

lw_vec2   lw_newton_tracer(const lw_newton *s, int which);
double    lw_newton_angle(const lw_newton *s, int link);   /* turn of the link since the posture [rad] */
double    lw_newton_residual(const lw_newton *s);          /* largest loop equation left over [m]      */

#endif

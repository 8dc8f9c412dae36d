/* mbs/constraints/newton.h - the second opinion: any planar linkage by Newton's method on its loop equations
 * (mbs/constraints/system.h), sharing no code with the plan.  General, used to verify: a full turn of a four-bar takes
 * about 0.1 ms.
 *
 * Works in coordinates relative to the middle of the posture and divided by its size, so a linkage
 * far from the origin or of any unit loses nothing but what the posture's own digits cannot hold. */
#ifndef LW_MBS_CONSTRAINTS_NEWTON_H
#define LW_MBS_CONSTRAINTS_NEWTON_H

#include "grammar/linkage.h"

typedef struct lw_newton lw_newton;

/* Overconstrained linkages are accepted if they can move.  Inputs after the first stay where they are,
 * but tied ones go with it.  LW_E_ARG: fewer inputs than freedoms; failures of lw_system_make; LW_E_NUMERIC: the
 * linkage is rigid, or its posture is a dead point of the input, where two branches meet and none can be chosen. */
lw_status lw_newton_create(const lw_linkage *k, lw_newton **out, lw_error *e);
void      lw_newton_free(lw_newton *s);

/* Follow the branch of the posture from the present input to `input` by predictor and corrector along
 * the curve of postures, in steps that are cut until the curve turns little and the correction is
 * small against the step.
 *
 * The input is that of the linkage's first lw_input and has its `value` in the posture of the file.
 * For a pin it grows with the turn of the moving link against the ground, for two moving links of
 * link[1] against link[0]; for a slider with the displacement of link[1] against link[0].
 *
 * LW_OPEN: the motion ends before, at a limit; *reached tells where (to 1e-10 rad or of the size) and
 * the positions are those there; a later move goes back the way it came.  LW_E_NUMERIC: the branch
 * was lost, positions are the last good ones.  *reached may be NULL.
 *
 * Two branches that cross (a change point) are passed straight on and counted, see below.  Branches
 * that come nearer to each other than about 1e-6 (of the size, or rad) are taken to cross: for a
 * four-bar a margin of 1e-12 in mbs/kinematics/fourbar.h, where rounding of the posture begins to decide. */
lw_status lw_newton_move(lw_newton *s, double input, double *reached);

/* Back to the posture of the file. */
void      lw_newton_reset(lw_newton *s);

lw_vec2   lw_newton_tracer(const lw_newton *s, int which);
lw_vec2   lw_newton_joint(const lw_newton *s, int joint);  /* its point on link[0]                    */
double    lw_newton_angle(const lw_newton *s, int link);   /* turn of the link since the posture [rad] */
double    lw_newton_input(const lw_newton *s);             /* present input [rad] or [m]             */
double    lw_newton_residual(const lw_newton *s);          /* largest loop equation left over [m]      */
int       lw_newton_crossings(const lw_newton *s);         /* change points passed since the posture */

#endif

/* mbs/constraints/newton.h - independent simulation of any planar linkage by Newton's method on its loop equations
 * (mbs/constraints/system.h).  It shares no code with the plan and verifies its results.  A full turn of a four-bar
 * takes about 0.1 ms.
 *
 * It works in coordinates relative to the middle of the posture and divided by its size, so the unit and the distance
 * from the origin cost no accuracy beyond the digits of the posture itself. */
#ifndef LW_MBS_CONSTRAINTS_NEWTON_H
#define LW_MBS_CONSTRAINTS_NEWTON_H

#include "grammar/linkage/linkage.h"

typedef struct lw_newton lw_newton;

/* Overconstrained linkages are accepted if they can move.  Inputs after the first rest, except that tied inputs
 * follow it.  LW_E_ARG: fewer inputs than degrees of freedom; LW_E_NUMERIC: the linkage is rigid, or its posture is a
 * dead point of the input where two branches meet and none can be chosen.  Fails as lw_system_make. */
lw_status lw_newton_create(const lw_linkage *linkage, lw_newton **out, lw_error *e);
void      lw_newton_free(lw_newton *s);

/* Move from the present input to `input` along the curve of postures by predictor and corrector.  Steps are shortened
 * until the curve turns little and the correction is small compared with the step.
 *
 * The input is that of the linkage's first lw_input and has its `value` in the posture of the file.
 * For a pin it grows with the rotation of the moving link relative to the ground; if both links move, of link[1]
 * relative to link[0].  For a slider it grows with the displacement of link[1] relative to link[0].
 *
 * LW_OPEN: the motion ends earlier, at a limit.  *reached is that input (to 1e-10 rad or of the size), and the
 * positions are those of the limit; a later move returns the same way.  LW_E_NUMERIC: the branch was lost; the
 * positions are the last good ones.  reached may be NULL.
 *
 * Where two branches cross (a change point), the motion goes straight on, and the crossing is counted, see below.
 * Branches nearer to each other than about 1e-6 (of the size, or rad) count as crossing.  For a four-bar this is a
 * margin of 1e-12 in mbs/kinematics/fourbar.h, where rounding of the posture begins to decide. */
lw_status lw_newton_move(lw_newton *s, double input, double *reached);

/* One step of that motion, of a length of at most `most` in the coordinates (rotations in rad, places divided by the
 * size).  LW_STOPPED: on the way.  LW_OK: at the input.  Else as lw_newton_move. */
lw_status lw_newton_step(lw_newton *s, double input, double most);

/* A posture between two that are one step apart, for pictures: lw_newton_keep stores the present posture and its tangent
 * towards growing inputs in node (lw_newton_node_size); lw_newton_between places s on the cubic through a (x = 0) and
 * b (x = 1), whose error is about 1/400 of the fourth power of the step. Only the positions of s are valid then, until
 * lw_newton_reset. */
size_t    lw_newton_node_size(const lw_newton *s);
void      lw_newton_keep(const lw_newton *s, double *node);
void      lw_newton_between(lw_newton *s, const double *a, const double *b, double x);

/* Back to the posture of the file. */
void      lw_newton_reset(lw_newton *s);

lw_vec2   lw_newton_tracer(const lw_newton *s, int which);
lw_vec2   lw_newton_joint(const lw_newton *s, int joint);  /* its point on link[0]                    */
lw_vec2   lw_newton_point(const lw_newton *s, int link, lw_vec2 at);  /* of the link, at `at` [m] in the posture */
double    lw_newton_angle(const lw_newton *s, int link);   /* rotation of the link since the posture [rad] */
double    lw_newton_input(const lw_newton *s);             /* present input [rad] or [m]             */
double    lw_newton_residual(const lw_newton *s);          /* largest residual of a loop equation [m]  */
int       lw_newton_crossings(const lw_newton *s);         /* change points passed since the posture */

#endif

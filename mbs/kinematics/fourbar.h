/* mbs/kinematics/fourbar.h - what the lengths of a four-bar say about its motion: class, turning, limits.
 * Barker 1985; Makkonen 1999, table 2, as corrected in docs/theory.md. */
#ifndef LW_MBS_KINEMATICS_FOURBAR_H
#define LW_MBS_KINEMATICS_FOURBAR_H

#include "base/error.h"     /* lw_fourbar_class: linkwright.h */

/* Classify frame r[0], input r[1], coupler r[2], output r[3], in any unit.  Sums are called equal
 * within tolerance * perimeter; the usual tolerance is LW_FOURBAR_TOLERANCE, 0 asks for equality.
 * The sums themselves are exact to the last bit of the result, so that limits and margins keep
 * their relative accuracy however near a change point is.  LW_E_ARG: a length that is not positive
 * and finite, or the linkage cannot be assembled (longest >= sum of the others). */
#define LW_FOURBAR_TOLERANCE 1e-12
lw_status lw_fourbar_classify(const double r[4], double tolerance, lw_fourbar_class *c, lw_error *e);

/* The other two linkages that trace the same coupler curve (Roberts 1875; Dijksman 1976).
 * in, out: r1 r2 r3 r4 cx cy x0 y0 theta0; the coupler point (cx, cy) has its origin at the crank
 * pin A, the x axis towards B; mode +1: B lies left of the line from A to the rocker's ground pin.
 *
 *   out[0]  its crank turns as the crank of `in`: same input angle from its frame, so also the same
 *           timing; its mode is -mode in every posture, out_mode[0].
 *   out[1]  stands on the ground pin of the crank of `in`, and its input turns as the coupler of
 *           `in`.  Its mode changes along the curve; out_mode[1] is the one it has where `in` stands
 *           at a third of the first range of lw_fourbar_class.  See lw_fourbar_cognate_pose.
 *
 * LW_E_ARG: lengths that are no four-bar.  LW_E_NUMERIC: the coupler point is on a pivot (nearer than
 * 1e-12 of the coupler), so that a cognate shrinks to a point: its nine numbers are 0, the other
 * cognate is good. */
lw_status lw_fourbar_cognates(const double in[9], double mode, double out[2][9], double out_mode[2]);

/* Input angle from the frame line [rad, in (-pi, pi]] and mode of both cognates where `in` has its
 * input at `angle`.  LW_OPEN when `in` cannot close there, LW_E_ARG as above. */
lw_status lw_fourbar_cognate_pose(const double in[9], double mode, double angle,
                                  double out_angle[2], double out_mode[2]);

#endif

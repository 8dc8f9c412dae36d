/* mbs/kinematics/fourbar.h - the motion of a four-bar from its lengths: class, links that turn, limits; cognates.
 * Barker 1985; Makkonen 1999, table 2, as corrected in docs/theory.md. */
#ifndef LW_MBS_KINEMATICS_FOURBAR_H
#define LW_MBS_KINEMATICS_FOURBAR_H

#include "base/error.h"     /* lw_fourbar_class: linkwright.h */

/* Classify the four-bar with frame r[0], input r[1], coupler r[2], output r[3], in any unit.  Sums of lengths count as
 * equal when they differ by at most tolerance * perimeter.  The usual tolerance is LW_FOURBAR_TOLERANCE; 0 means exact
 * equality.  The sums are exact to the last bit of the result, so that limits and margins keep their relative accuracy
 * near change points.  LW_E_ARG: a length is not positive and finite, or the linkage cannot be assembled (longest >=
 * sum of the others). */
#define LW_FOURBAR_TOLERANCE 1e-12
lw_status lw_fourbar_classify(const double r[4], double tolerance, lw_fourbar_class *c, lw_error *e);

/* Compute the other two four-bars that trace the same coupler curve (Roberts 1875; Dijksman 1976).  in, out:
 * r1 r2 r3 r4 cx cy x0 y0 theta0.  The coupler point (cx, cy) has its origin at the crank pin A and its x axis towards
 * B.  Mode +1: B lies left of the line from A to the ground pin of the rocker.
 *
 *   out[0]  Its input angle from its frame is that of `in`, so that the timing is the same too.  Its mode out_mode[0]
 * is
 *           -mode in every posture.
 *   out[1]  It shares the ground pin of the crank of `in`, and its input turns as the coupler of `in`.  Its mode
 * changes
 *           along the curve; out_mode[1] is its mode where the input of `in` is at a third of the first range of
 *           lw_fourbar_class.  See lw_fourbar_cognate_posture.
 *
 * LW_E_ARG: the lengths are no four-bar.  LW_E_NUMERIC: the coupler point is on a pivot (nearer than 1e-12 of the
 * coupler), so that one cognate shrinks to a point.  Its nine numbers are 0; the other cognate is valid. */
lw_status lw_fourbar_cognates(const double in[9], double mode, double out[2][9], double out_mode[2]);

/* The input angle from the frame [rad], in (-pi, pi], and the mode of both cognates when the input of `in` is at
 * `angle`. LW_OPEN when `in` cannot close there; LW_E_ARG as above. */
lw_status lw_fourbar_cognate_posture(const double in[9], double mode, double angle, double out_angle[2], double out_mode[2]);

#endif

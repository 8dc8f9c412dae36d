/* optimise/report/report_internal.h - the independent simulation behind a report. */
#ifndef LW_OPTIMISE_REPORT_REPORT_INTERNAL_H
#define LW_OPTIMISE_REPORT_REPORT_INTERNAL_H

#include "mbs/kinematics/closed_motion.h"
#include "mbs/batch/pose.h"
#include "optimise/report/report.h"
#include "optimise/task/motion_limits.h"

/* Turns, limits, dead points and circuits of a result with higher groups, whose posture is r->linkage, and its way:
 * over the whole curve when the input turns, else from input `from` to `to`. */
void lw_fit_report_curve(const lw_plan *plan, const lw_fit_spec *s, const lw_candidate *c, double from, double to,
                     lw_motion_limits *way, lw_fit_report *r);

/* Of a closed target, a result through limits: the cycle of its first station, in that assembly; false: it is no such
 * result. */
bool lw_fit_report_cycle(const lw_target *t, const lw_plan *plan, const lw_candidate *c, const double *modes,
                     lw_closed_motion *cycle);

/* Points of its curve, `most` or fewer, as many each leg, from its leg 0 on.  Returns how many. */
size_t lw_fit_report_cycle_points(const lw_plan *plan, const lw_candidate *c, const lw_closed_motion *cycle, size_t most,
                              lw_vec2 *curve);

/* One more reversal, unless there is no room. */
void lw_fit_report_reversal(lw_fit_report *r, bool limit, int joint, double input);

/* Write the posture as a file would hold it, read it back, move it from station to station by
 * Newton's method on the loop equations, and compare with `at`, the plan's positions (n of each point).  Fills
 * verified ... fault of the report. */
void lw_verify(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_plan *plan,
               const lw_vec2 *at, lw_fit_report *r);

#endif

/* optimise/report/report_internal.h - the parts of a report. */
#ifndef LW_OPTIMISE_REPORT_REPORT_INTERNAL_H
#define LW_OPTIMISE_REPORT_REPORT_INTERNAL_H

#include "mbs/kinematics/closed_motion.h"
#include "mbs/batch/posture.h"
#include "optimise/report/report.h"
#include "optimise/task/motion_limits.h"

/* Fill in turns, limits, dead points and circuits of a linkage with higher groups, whose posture is r->linkage, and
 * the limits of its motion: over the whole curve if the input turns, else from input `from` to `to`. */
void lw_fit_report_curve(const lw_plan *plan, const lw_fit_spec *s, const lw_candidate *c, double from, double to,
                     lw_motion_limits *limits, lw_fit_report *r);

/* The closed motion across limits that holds the first station, in its assembly mode.  false: the
 * linkage does not move across limits. */
bool lw_fit_report_cycle(const lw_plan *plan, const lw_candidate *c, const double *modes, lw_closed_motion *cycle);

/* At most `most` points of its curve, equally many on each leg, from leg 0 on.  Returns how many. */
size_t lw_fit_report_cycle_points(const lw_plan *plan, const lw_candidate *c, const lw_closed_motion *cycle, size_t most, lw_vec2 *curve);

/* Fill in size and lengths, which limits are active, and which the result does not keep. */
void lw_fit_report_limits(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_motion_limits *motion, lw_fit_report *r);

/* Add a reversal, unless there are LW_REVERSAL_MAX. */
void lw_fit_report_reversal(lw_fit_report *r, bool limit, int joint, double input);

/* Write the posture as a file, read it back, move it from station to station by Newton's method on the loop
 * equations, and compare with `at`, the positions by the plan (n of each point).  Fills `verified` ... `fault` of the
 * report. LW_OK or LW_E_MEMORY. */
lw_status lw_verify(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_plan *plan,
                    const lw_vec2 *at, lw_fit_report *r);

#endif

/* catalogues/draw/motion_path.h - the motion of any linkage as postures q(t), t from 0 to 1: along the curve of its postures
 * (mbs/constraints/motion_curve.h), whatever its joints are, or in time with several inputs at once (mbs/constraints/prescribed_motion.h).
 *
 * Along a curve t goes evenly with the input when the input turns without end, else evenly with the arc, to where the
 * curve closes, or there and back between its two ends. */
#ifndef LW_CATALOGUES_DRAW_MOTION_PATH_H
#define LW_CATALOGUES_DRAW_MOTION_PATH_H

#include "mbs/constraints/circuits.h"
#include "mbs/constraints/prescribed_motion.h"

typedef enum lw_motion_path_pace { LW_PACE_INPUT, LW_PACE_ARC, LW_PACE_RANGE, LW_PACE_TIME } lw_motion_path_pace;

typedef struct lw_motion_path {
    lw_system      s;
    lw_circuits    curves;          /* curve 0 holds the posture of the linkage                       */
    lw_prescribed_motion      *drive;           /* NULL: along curve `shown`                                      */
    int            shown;
    lw_motion_path_pace pace;
    double         from, to;        /* LW_PACE_INPUT, _RANGE: of the input; _TIME: of the time [s]    */
    bool           loops;           /* t = 1 is t = 0                                                 */
    double         start;           /* t of the drawn posture (curve 0; in time: 0)                   */
    int            turns;           /* whole turns of the input until the curve closes, 0: it swings  */
} lw_motion_path;                        /* { 0 } is empty                                                 */

/* Follow the curve of k's posture by its first input, others at rest; all: the curves of other circuits and
 * assemblies too, as far as they are found (those of one seed).  Failures of lw_system_make, lw_motion_curve_create. */
lw_status lw_motion_path_along(const lw_linkage *k, bool all, lw_motion_path *c, lw_error *e);

/* Move all inputs of k by `motion` from time `from` to `to`, from the posture of the linkage; ends before the first
 * time that cannot be reached, with LW_OPEN and a text.  Other failures as lw_prescribed_motion_create. */
lw_status lw_motion_path_in_time(const lw_linkage *k, lw_input_function *motion, void *context, double from, double to,
                            lw_motion_path *c, lw_error *e);
void      lw_motion_path_free(lw_motion_path *c);

/* Show all of this curve. */
void      lw_motion_path_choose(lw_motion_path *c, int curve);

/* Show only where the input is between first and last, as far as that is reached from the posture without passing
 * a limit: there and back. */
void      lw_motion_path_restrict(lw_motion_path *c, double first, double last);

/* Coordinates (n_q of s) at t; returns what the first input is there [rad] or [m], through turns; 0 without input. */
double    lw_motion_path_at(lw_motion_path *c, double t, double *q);

#endif

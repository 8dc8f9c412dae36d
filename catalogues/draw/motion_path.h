/* catalogues/draw/motion_path.h - the motion of any linkage as postures q(t), t from 0 to 1: along its motion curve
 * (mbs/constraints/motion_curve.h), or in time with several inputs at once (mbs/constraints/prescribed_motion.h).
 *
 * Along a motion curve: when the input turns endlessly, t is proportional to the input; else t follows the arc length.
 * The motion ends where the curve closes, or runs there and back between the two ends of the curve. */
#ifndef LW_CATALOGUES_DRAW_MOTION_PATH_H
#define LW_CATALOGUES_DRAW_MOTION_PATH_H

#include "mbs/constraints/circuits.h"
#include "mbs/constraints/prescribed_motion.h"

typedef enum lw_motion_path_pace { LW_PACE_INPUT, LW_PACE_ARC, LW_PACE_RANGE, LW_PACE_TIME } lw_motion_path_pace;

typedef struct lw_motion_path {
    lw_system             s;
    lw_circuits           curves;   /* curve 0 holds the posture of the linkage                       */
    lw_prescribed_motion *drive;    /* NULL: along curve `shown`                                      */
    int                   shown;
    lw_motion_path_pace   pace;
    double                from, to; /* LW_PACE_INPUT, _RANGE: of the input; _TIME: of the time [s]    */
    bool                  loops;    /* t = 1 is t = 0                                                 */
    double                start;    /* t of the drawn posture (curve 0; in time: 0)                   */
    int                   turns;    /* full turns of the input until the curve closes; 0: it swings   */
} lw_motion_path;                   /* { 0 } is empty                                                 */

/* Follow the motion curve through the linkage's posture by its first input; other inputs rest.  all: also find the
 * curves of other circuits and assembly modes, with a fixed seed.  Fails as lw_system_make and lw_motion_curve_create do. */
lw_status lw_motion_path_along(const lw_linkage *linkage, bool all, lw_motion_path *c, lw_error *e);

/* Move all inputs by `motion` from time `from` to `to`, starting at the linkage's posture. LW_OPEN with a text: the
 * motion ends before the first time that cannot be reached. Other failures as lw_prescribed_motion_create. */
lw_status lw_motion_path_in_time(const lw_linkage *linkage, lw_input_function *motion, void *context, double from,
                                 double to, lw_motion_path *c, lw_error *e);
void      lw_motion_path_free(lw_motion_path *c);

/* How long a motion in time is shown if nobody says so [s]: until the inputs repeat or come to rest, within 100 s, else 1 s.
 * alike: are the values and rates of the inputs at the times a and b the same, to LW_INPUTS_ALIKE? */
#define LW_INPUTS_ALIKE 1e-6
double lw_motion_path_duration(bool (*alike)(void *context, double a, double b), void *context);

/* Show the whole of this curve. */
void      lw_motion_path_choose(lw_motion_path *c, int curve);

/* Show only inputs between first and last, as far as they are reached from the posture without passing a limit: there
 * and back. */
void      lw_motion_path_restrict(lw_motion_path *c, double first, double last);

/* Coordinates q (n_q of s) at t. Returns the first input there [rad] or [m], counted over full turns; 0 without
 * input. */
double    lw_motion_path_at(lw_motion_path *c, double t, double *q);

#endif

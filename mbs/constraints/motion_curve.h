/* mbs/constraints/motion_curve.h - the whole motion of a linkage with one input as a curve of postures.
 *
 * With all inputs but one at rest the postures of a linkage form curves in the space of its coordinates.  The curve
 * through a posture is followed by planes across its tangent (pseudo-arclength: Keller 1977; Allgower & Georg
 * 1990), over limits of the input, to where it closes: after one turn of the input, after several, or without any.
 * Every step is so short that a theorem keeps it on its branch (mbs/constraints/continuation_internal.h); where no step is short
 * enough, at a branch point, the curve is continued analytically, straight on, which is told.
 *
 * A place on the curve is a station, 0 .. n_segment: segment number and how far along it (as a share of its
 * plane's way).  Arc lengths are in the coordinates of mbs/constraints/system.h: places over the size of the posture and turns
 * [rad] of all moving links; good to about 1e-4, meant for even spacing. */
#ifndef LW_MBS_CONSTRAINTS_MOTION_CURVE_H
#define LW_MBS_CONSTRAINTS_MOTION_CURVE_H

#include "mbs/constraints/system.h"

typedef enum lw_motion_curve_event_kind {
    LW_EVENT_LIMIT,           /* the free input turns back: a limit of it, its dead point              */
    LW_EVENT_TURNING,         /* another joint at the ground turns back: end of a swing, a dead point of the */
                              /* linkage if that joint drove it                                        */
    LW_EVENT_CROSSING         /* branch point: branches cross, the curve goes straight on              */
} lw_motion_curve_event_kind;

typedef struct lw_motion_curve_event {
    lw_motion_curve_event_kind kind;
    int    joint;             /* that turns back; -1                                               */
    double station;           /* located to 1e-10 of the arc                                        */
    double input;             /* of the free input [rad] or [m], as lw_input counts                 */
} lw_motion_curve_event;

typedef enum lw_motion_curve_end {
    LW_MOTION_CURVE_CLOSED,         /* the curve is closed: its last posture is its first                 */
    LW_MOTION_CURVE_FAR,            /* it leaves for beyond `reach`, both ways                            */
    LW_MOTION_CURVE_LOST,           /* an end is a singular posture that could not be passed              */
    LW_MOTION_CURVE_STOPPED         /* `most_segments` were not enough                                    */
} lw_motion_curve_end;

typedef struct lw_motion_curve_options {
    int    input;             /* the free input                                                     */
    double reach;             /* of links from the middle of the posture, in sizes of it; 0: 30      */
    int    most_segments;     /* 0: 20000                                                          */
} lw_motion_curve_options;

typedef struct lw_motion_curve lw_motion_curve;

/* Follow the curve through posture q (NULL: the drawn one) of the linkage that s was made from; s must outlive
 * it.  Station 0 is the posture if the curve is closed; the curve begins with a growing input there.  Where the
 * posture is a branch point of two branches, that on which the input moves faster is followed, from a little way off.
 *
 * LW_E_ARG: the linkage has not one input more than the inputs at rest leave freedoms, in number; LW_E_NUMERIC: it
 * cannot move, or more than two branches meet in the posture. */
lw_status lw_motion_curve_create(const lw_system *s, const double *q, const lw_motion_curve_options *o, lw_motion_curve **out,
                           lw_error *e);
void      lw_motion_curve_free(lw_motion_curve *b);

lw_motion_curve_end lw_motion_curve_ended(const lw_motion_curve *b);
int           lw_motion_curve_segments(const lw_motion_curve *b);
double        lw_motion_curve_length(const lw_motion_curve *b);            /* arc                                    */
double        lw_motion_curve_start(const lw_motion_curve *b);             /* station of the posture it began with    */
double        lw_motion_curve_worst(const lw_motion_curve *b);             /* greatest residual at the joints of segments [m] */

/* Whole turns of a link (link < 0: of the input, if it is a pin) over a closed curve. */
int           lw_motion_curve_turns(const lw_motion_curve *b, int link);

/* Events in the order of their stations; *n their number. */
const lw_motion_curve_event *lw_motion_curve_events(const lw_motion_curve *b, int *n);

/* A posture q (n_q) on the other branch at event number `event`, a crossing, a little way off.  False where more than
 * two branches meet, or where it touches. */
bool   lw_motion_curve_other(lw_motion_curve *b, int event, double *q);

/* Coordinates (n_q) of a station, and the unit tangent there when given. */
void   lw_motion_curve_pose(lw_motion_curve *b, double station, double *q, double *tangent);

/* What the free input is in a posture [rad] or [m], as lw_input counts; through turns. */
double lw_motion_curve_input(const lw_motion_curve *b, const double *q);

double lw_motion_curve_arc(const lw_motion_curve *b, double station);
double lw_motion_curve_station(const lw_motion_curve *b, double arc);

/* Between two stations without a limit of the input in between: where the input is `input`, to rounding. */
double lw_motion_curve_find(lw_motion_curve *b, double first, double last, double input);

/* Is posture q (closing, this free input or another) on the curve?  Whole turns of links do not count. */
bool   lw_motion_curve_holds(lw_motion_curve *b, const double *q);

/* +1, -1: side of the linkage with respect to its input, which changes at every limit; 0 where it cannot be told
 * (more equations than coordinates). */
int    lw_motion_curve_side(lw_motion_curve *b, double station);

/* Coefficients q[k*n_q + i], k = 0 .. order, of the motion by the inputs through posture q[0 ..]: input i is input
 * there plus the sum of motion[i*(order + 1) + k] x^k [rad] or [m], k >= 1.  False at a dead point of the
 * inputs, where there is none. */
bool   lw_motion_curve_rates(lw_motion_curve *b, int order, const double *motion, double *q);

/* The same through the posture of a station, which is put into q[0 ..]: the free input moves by motion[k] x^k, k = 1 ..
 * order <= 8, the others rest.  Branch points are no exception: there the derivatives are those of the curve,
 * which goes straight on. */
bool   lw_motion_curve_motion(lw_motion_curve *b, double station, int order, const double *motion, double *q);

/* Does the free input stand still on the whole curve, while links move? */
bool   lw_motion_curve_rests(const lw_motion_curve *b);

#endif

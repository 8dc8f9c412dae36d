/* mbs/constraints/motion_curve.h - the whole motion of a linkage with one input as a curve of postures.
 *
 * If all inputs but one rest, the postures of a linkage form curves in the space of its coordinates.  The curve
 * through a posture is followed on planes across its tangent (pseudo-arclength: Keller 1977; Allgower & Georg 1990),
 * over limits of the input, until it closes: after one turn of the input, after several, or without any.  Every step
 * is so short that a theorem keeps it on its branch (mbs/constraints/continuation_internal.h).  At a branch point no
 * step is short enough; there the curve is continued analytically, straight on, and an event reports it.
 *
 * A position on the curve is a station, 0 .. n_segment: the number of a segment plus the fraction of its length.  Arc
 * lengths are in the coordinates of mbs/constraints/system.h: positions relative to the size of the posture, and
 * rotations [rad], of all moving links.  They are accurate to about 1e-4 and meant for even spacing. */
#ifndef LW_MBS_CONSTRAINTS_MOTION_CURVE_H
#define LW_MBS_CONSTRAINTS_MOTION_CURVE_H

#include <signal.h>
#include "mbs/constraints/system.h"

typedef enum lw_motion_curve_event_kind {
    LW_EVENT_LIMIT,           /* the free input turns back: its limit                                */
    LW_EVENT_TURNING,         /* another joint at the ground turns back: the end of its swing, and a  */
                              /* dead point if that joint drove the linkage                           */
    LW_EVENT_CROSSING         /* branch point: two curves cross, this one goes straight on            */
} lw_motion_curve_event_kind;

typedef struct lw_motion_curve_event {
    lw_motion_curve_event_kind kind;
    int    joint;             /* the joint that turns back; -1: none                               */
    double station;           /* located to 1e-10 of the arc                                        */
    double input;             /* value of the free input [rad] or [m], as in lw_input               */
} lw_motion_curve_event;

typedef enum lw_motion_curve_end {
    LW_MOTION_CURVE_CLOSED,         /* the curve is closed: its last posture is its first                 */
    LW_MOTION_CURVE_FAR,            /* both ends lead farther than `reach`                                */
    LW_MOTION_CURVE_LOST,           /* an end is a singular posture that could not be passed              */
    LW_MOTION_CURVE_STOPPED         /* `most_segments` were not enough                                    */
} lw_motion_curve_end;

typedef struct lw_motion_curve_options {
    int    input;             /* the free input                                                     */
    double reach;             /* largest distance of links from the middle, in sizes; 0: 30 times the size, or the longest arm of a tracer */
    int    most_segments;     /* 0: 20000                                                          */
    const volatile sig_atomic_t *stop;     /* may be NULL; nonzero: LW_STOPPED at the next step            */
    double until;             /* wall time (lw_clock_wall) at which a search for circuits ends; 0: never */
} lw_motion_curve_options;

typedef struct lw_motion_curve lw_motion_curve;

/* Follow the curve through posture q (NULL: the drawn one) of the linkage that s was made from; s must outlive it.
 * If the curve is closed, station 0 is the posture, and the curve begins there with a growing input.  If the posture
 * is a branch point of two branches, the branch on which the input moves faster is followed, from a point nearby.
 *
 * LW_E_ARG: the inputs at rest do not leave exactly one degree of freedom, by count; LW_E_NUMERIC: the linkage cannot
 * move, or more than two branches meet in the posture. */
lw_status lw_motion_curve_create(const lw_system *s, const double *q, const lw_motion_curve_options *o, lw_motion_curve **out, lw_error *e);
void      lw_motion_curve_free(lw_motion_curve *b);

lw_motion_curve_end lw_motion_curve_ended(const lw_motion_curve *b);
int           lw_motion_curve_segments(const lw_motion_curve *b);
double        lw_motion_curve_length(const lw_motion_curve *b);     /* arc length                             */
double        lw_motion_curve_start(const lw_motion_curve *b);      /* station of the first posture           */
double        lw_motion_curve_worst(const lw_motion_curve *b);      /* largest residual at segment ends [m]   */

/* Whole turns of a link over a closed curve (link < 0: turns of the input, if it is a pin). */
int           lw_motion_curve_turns(const lw_motion_curve *b, int link);

/* Events in the order of their stations; *n their number. */
const lw_motion_curve_event *lw_motion_curve_events(const lw_motion_curve *b, int *n);

/* A posture q (n_q) on the other branch near event number `event`, which must be a crossing.  False if more than two
 * branches meet there, or if the branches touch without crossing. */
bool   lw_motion_curve_other(lw_motion_curve *b, int event, double *q);

/* Coordinates (n_q) of a station, and the unit tangent there if tangent is not NULL. */
void   lw_motion_curve_posture(lw_motion_curve *b, double station, double *q, double *tangent);

/* Value of the free input in a posture [rad] or [m], as in lw_input; it counts whole turns. */
double lw_motion_curve_input(const lw_motion_curve *b, const double *q);

double lw_motion_curve_arc(const lw_motion_curve *b, double station);
double lw_motion_curve_station(const lw_motion_curve *b, double arc);

/* The station between `first` and `last` at which the input has the value `input`, to rounding.  There must be no
 * limit of the input between them. */
double lw_motion_curve_find(lw_motion_curve *b, double first, double last, double input);

/* Is the closed posture q on the curve?  Whole turns of links are ignored. */
bool   lw_motion_curve_holds(lw_motion_curve *b, const double *q);

/* +1 or -1: a sign that changes at every limit of the input; 0 if it is not defined (more equations than
 * coordinates).  Of systems larger than a linkage: whether the input grows along the curve. */
int    lw_motion_curve_side(lw_motion_curve *b, double station);

/* Coefficients q[k*n_q + i], k = 0 .. order, of the motion through posture q[0 ..] when input i moves by the sum of
 * motion[i*(order + 1) + k] x^k [rad] or [m], k >= 1.  False at a dead point of the inputs, where no such motion
 * exists. */
bool   lw_motion_curve_rates(lw_motion_curve *b, int order, const double *motion, double *q);

/* The same through the posture of a station, which is written to q[0 ..]: the free input moves by motion[k] x^k,
 * k = 1 .. order <= 8, and the others rest.  At a branch point the derivatives are those of the curve straight on. */
bool   lw_motion_curve_motion(lw_motion_curve *b, double station, int order, const double *motion, double *q);

/* Does the free input stand still on the whole curve, while links move? */
bool   lw_motion_curve_rests(const lw_motion_curve *b);

#endif

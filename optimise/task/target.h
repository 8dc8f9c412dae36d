/* optimise/task/target.h - what the point (or the output) must do: stations read from a CSV file.
 *
 *     # comments; "# closed: yes|no" and "# units: mm deg" are obeyed, all others passed over
 *     x,y[,theta][,angle|t][,weight]         path or motion: theta is the tool angle, angle the input
 *     angle,theta[,weight]                   function: input angle, output angle
 *     ...,x2,y2[,theta2][,weight2]           where a further point is at the same stations, and how its link is
 *     ...,theta2[,weight2]                   turned; or only an output angle that goes with it; then 3, 4
 *
 * Also understood, because published files use them: theta_in for the input angle, in which case
 * `angle` is the tool (or output) angle; suffixes _rad, _deg, _mm, _m ... fix the unit of a column, and
 * with it of all columns of its kind.  A column t is the input in turns: from 0 to 1 is one turn.
 * Fields are separated by commas, or by semicolons, tabs or blanks when the header has no comma.
 * docs/notation.md, "Target", has the whole of it.
 *
 * Any number of stations from 1 on is read; whether they are enough is the fitter's business. */
#ifndef LW_OPTIMISE_TASK_TARGET_H
#define LW_OPTIMISE_TASK_TARGET_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/units.h"
#include "base/vec2.h"

#define LW_STATION_MAX 100000
#define LW_ALSO_MAX 3             /* greatest number of further points                               */

/* Positions and angles of a further point of the linkage at the stations of the first point. */
typedef struct lw_also {
    double *x, *y;              /* [m]; NULL: only the angle of its link is given (n)              */
    double *theta;              /* tool or output angle [rad]; NULL: not given (n)                 */
    double *weight;             /* that of the stations if not given (n)                           */
    double  length;             /* of its polygon, closed if the target is [m]; 0 without points   */
} lw_also;

typedef struct lw_target {
    size_t   n;                 /* stations                                                        */
    double  *x, *y;             /* [m]; NULL for a function                             (n)        */
    double  *theta;             /* tool or output angle [rad]; NULL when not given      (n)        */
    double  *angle;             /* input angle [rad], rising or falling throughout, over at most
                                 * LW_INPUT_TURNS_PER_PERIOD_MAX turns (a wrap at the full turn is
                                 * undone); NULL when not given                         (n)        */
    double  *weight;            /* >= 0, not all 0; 1 when not given                    (n)        */
    long    *line;              /* line of the file, for messages; 0 by _make           (n)        */
    bool     closed;            /* the last station is followed by the first                      */
    double   length;            /* length of the polygon through the stations, closed if so [m]    */
    double   size;              /* least diagonal of a rectangle around it, in any direction, so that a target may be turned [m]; both 0 for
                                 * a function                                                      */
    int      n_also;
    lw_also  also[LW_ALSO_MAX]; /* further points, in the order of their numbers          (n_also) */
    double   extent;            /* the same around all points [m]                                  */
    double   noise;             /* RMS distance of the points from the path they were smoothed to: an error below it says
                                 * nothing [m]; 0: not smoothed                                   */
    lw_units units;
    char     note[400];         /* what was assumed when it was read, for a person; "": nothing    */
    void    *store;             /* what _free frees                                                */
} lw_target;

/* Read; o may be NULL.  LW_E_NOTATION, LW_E_ARG (an option) or LW_E_MEMORY; after a failure t is
 * empty and needs no _free. */
lw_status lw_target_read(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);
/* Make a target from arrays in SI units (copied). x and y are both given or, for a function, both NULL; theta, angle,
 * weight may be NULL; closed as in the options. LW_E_ARG: a condition that also holds for files is not met. */
lw_status lw_target_make(size_t n, const double *x, const double *y, const double *theta,
                         const double *angle, const double *weight, int closed, lw_target *t,
                         lw_error *e);
/* The same with further points; also[i].length is ignored. */
lw_status lw_target_make_all(size_t n, const double *x, const double *y, const double *theta,
                             const double *angle, const double *weight, const lw_also *also, int n_also,
                             int closed, lw_target *t, lw_error *e);
/* Join targets of one point each, row by row, into one target; each point keeps its own weights. A single part is
 * copied. If one part has input angles, they hold for all. LW_E_ARG, naming the tracer: different numbers of rows,
 * input angles that disagree, too many parts. */
lw_status lw_target_join(const lw_target *const *part, int n_part, lw_target *t, lw_error *e);
void      lw_target_free(lw_target *t);

/* Distance of a place from the polygon of the stations [m]. */
double lw_target_distance(const lw_target *t, lw_vec2 place);

/* The circle of least squares through the points of the path.  Returns their greatest distance from it [m]; INFINITY: fewer
 * than 6 points, or a straight line. */
double    lw_target_circle(const lw_target *t, lw_vec2 *centre, double *radius);

/* The point about which a body turns that moves through all places and angles of a motion, by least squares.  Returns the greatest
 * distance of a place from the one that the body then has [m]; INFINITY: no motion, one station, or the body hardly turns. */
double    lw_target_pivot(const lw_target *t, lw_vec2 *pivot);

/* Greatest height over its chord of an arc on which the body turns about one point from one pose to the next; of two stations at least
 * that of an arc of 90 degrees, as a rocker may swing [m]. */
double    lw_target_arc(const lw_target *t);

/* Greatest distance of a point of the path from one straight line [m]; INFINITY: no path.  A path that leaves it by LW_STRAIGHT diagonals is straight. */
#define LW_STRAIGHT 1e-6
double    lw_target_straight(const lw_target *t);

/* The range of the angles of a motion or function, a full turn at most [rad]; 0: it has none. */
double    lw_target_swing(const lw_target *t);

/* Of how many equal parts round a centre the closed path consists, 3 to 12, as a star of five rays has 5: turned by one part, no station
 * leaves the polygon of the stations by more than `off` [m].  1: none. */
int       lw_target_parts(const lw_target *t, double off);

/* Are linkages preferred whose input turns fully?  Of all but open functions, for which an input goes to and fro in any case. */
static inline bool lw_target_prefers_turns(const lw_target *t) { return t->closed || t->extent > 0; }

#endif

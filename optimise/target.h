/* optimise/target.h - what the point (or the output) must do: stations read from a CSV file.
 *
 *     # comments; "# closed: yes|no" "# units: mm deg" are read, other comments are kept as notes
 *     x,y[,theta][,angle|t][,weight]         path or motion: theta is the tool angle, angle the input
 *     angle,theta[,weight]                   function: input angle, output angle
 *
 * Also understood, because published files use them: theta_in_rad | theta_in_deg | theta_in for the
 * input angle, in which case `angle` is the tool (or output) angle; suffixes _rad, _deg, _mm, _m ... fix the unit of
 * a column. A column t counts as input angle up to scale: t from 0 to 1 is one turn. */
#ifndef LW_OPTIMISE_TARGET_H
#define LW_OPTIMISE_TARGET_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/units.h"

#define LW_STATION_MAX 100000

typedef struct lw_target {
    size_t   n;                 /* stations                                                        */
    double  *x, *y;             /* [m]; NULL for a function                             (n)        */
    double  *theta;             /* tool or output angle [rad]; NULL when not given      (n)        */
    double  *angle;             /* input angle [rad]; NULL when not given               (n)        */
    double  *weight;            /* >= 0, not all 0; 1 when not given                    (n)        */
    long    *line;              /* line of the file, for messages                       (n)        */
    bool     closed;            /* the last station is followed by the first                      */
    double   length;            /* length of the polygon through the stations, closed if so [m]    */
    double   size;              /* diagonal of the bounding box [m]                                */
    lw_units units;
    void    *store;             /* what _free frees                                                */
} lw_target;

/* Options of reading that a command line may force. */
typedef struct lw_target_options {
    int         closed;         /* 1 yes, 0 no, -1 by the file: its "closed" comment, or by guess:
                                 * the gap from last to first is no longer than 1.5 times the longest
                                 * step, or the last station repeats the first (which is kept)     */
    const char *length_unit;    /* NULL: by the file, else metre                                   */
    const char *angle_unit;     /* NULL: by the file, else radian                                  */
} lw_target_options;

lw_status lw_target_read(const char *text, size_t size, const char *file,
                         const lw_target_options *o, lw_target *t, lw_error *e);
/* From arrays (copied). theta, angle, weight may be NULL. */
lw_status lw_target_make(size_t n, const double *x, const double *y, const double *theta,
                         const double *angle, const double *weight, int closed, lw_target *t,
                         lw_error *e);
void      lw_target_free(lw_target *t);

#endif

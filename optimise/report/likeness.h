/* optimise/report/likeness.h - distances of two curves, as tools that learn linkages from curves report them.
 *
 * The curve of a target goes through its stations, smooth except at corners: a polygon of chords would deviate from
 * the curve behind the stations by more than good linkages do.  Both curves are divided into LW_LIKENESS_POINTS
 * points at equal steps of length.  Distances are means, divided by the RMS radius of the target (of its points about
 * their mean).
 *     chamfer    half of: from each target point to the nearest place of the curve, and the other way
 *     ordered    between points of equal rank, at the best shift (closed curves) and sense
 * (Nobari et al. 2024, "LInK", report both; they add the two directions of the Chamfer distance.) */
#ifndef LW_OPTIMISE_REPORT_LIKENESS_H
#define LW_OPTIMISE_REPORT_LIKENESS_H

#include "optimise/task/target.h"
#include "base/vec2.h"

#define LW_LIKENESS_POINTS 200

typedef struct lw_likeness {
    double to_curve, to_target;     /* the two directions of the Chamfer distance                   */
    double chamfer, ordered;        /* NaN for targets without extent, or without memory            */
} lw_likeness;

/* curve (n) is a polyline, closed if the target is.  n >= 2. */
lw_status lw_likeness_measure(const lw_target *t, const lw_vec2 *curve, size_t n, lw_likeness *out);

/* How far curve and target are apart [m]: the greatest distance of a station from the curve, and of a place of the
 * curve from the curve through the stations.  Between few stations that curve is a guess: `unsure` is twice the greatest
 * height of an arc through three stations over its chords, or lw_target_arc, if that is more. */
typedef struct lw_stray { double to_curve, to_target, unsure; } lw_stray;

/* NaN without memory.  n >= 2. */
lw_stray lw_likeness_stray(const lw_target *t, const lw_vec2 *curve, size_t n);

#endif

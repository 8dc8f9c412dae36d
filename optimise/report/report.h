/* optimise/report/report.h - the report of a linkage that was found, computed from its dimensions alone: posture,
 * errors, motion, and whether an independent simulation agrees. */
#ifndef LW_OPTIMISE_REPORT_REPORT_H
#define LW_OPTIMISE_REPORT_REPORT_H

#include "mbs/kinematics/fourbar.h"
#include "optimise/search/fit.h"
#include "optimise/report/likeness.h"

/* Errors of a further point at the stations. */
typedef struct lw_also_error {
    double mean, rms, max;         /* distances [m]; NaN when its place is not asked for            */
    double percent;                /* 100 mean / length of its path; NaN for one without length     */
    size_t worst;                  /* station of max, of angle_max where there is only an angle      */
    double angle_mean, angle_max;  /* [rad]; NaN when its angle is not asked for                    */
} lw_also_error;

#define LW_REVERSAL_MAX 32
#define LW_ACTIVE_MAX   12

/* Where a joint reverses: the input joint at a limit of the motion; another joint at the ground at an end of its
 * swing, which would be a dead point if that joint drove the linkage. */
typedef struct lw_reversal {
    bool   limit;                  /* the input reverses                                            */
    int    joint, link;            /* the joint, and its link that is not the ground                */
    double input;                  /* in the ground frame, as lw_candidate.input [rad] or [m]       */
} lw_reversal;

typedef struct lw_fit_report {
    lw_linkage linkage;            /* posture at the first station; tracer 0 is the fitted one, 1, ... are the
                                    * further points of the target                                  */
    char     dim_name[LW_DIM_MAX][16];
    lw_dim_kind dim_kind[LW_DIM_MAX];
    double   objective;            /* eq. 17 from the positions of the plan                         */
    double   error_mean, error_rms, error_max;      /* distance of the stations [m]                */
    double   error_percent;        /* 100 error_mean / path length; NaN for a path without length   */
    size_t   worst;                /* station of error_max                                          */
    double   angle_mean, angle_max;/* of the tool or output [rad]; NaN when the task has none      */
    int      n_also;
    lw_also_error also[LW_ALSO_MAX];
    double   curve_max;            /* greatest distance of the curve from the target polygon, between the first and the
                                    * last station [m]                                              */
    lw_likeness likeness;          /* of the curve between the stations and the target; NaN for functions */
    bool     turns;                /* the input turns fully                                         */
    bool     rests;                /* a pin does not turn from station to station, as in a kite folded so that two of its pins coincide: the
                                    * linkage moves as one with fewer links                         */
    int      input_turns_per_period;   /* turns of the input until gears return to their first position, else 1; the
                                    * candidate's inputs count them as one turn, inputs here and in files do not */
    int      circuits;             /* of the linkage with these lengths; 0: not counted.  With higher groups: circuits
                                    * found from random starting postures; maybe not all (mbs/constraints/circuits.h) */
    double   input_first, input_last;  /* range of the input around the first station without passing a limit, as
                                    * lw_candidate.input times input_turns_per_period; of a turning input one period;
                                    * NaN: not known                                                */
    int      legs;                 /* of a motion across limits: number of strokes from limit to limit until it closes;
                                    * else 0                                                        */
    int      n_reversal;
    lw_reversal reversal[LW_REVERSAL_MAX];  /* in that range, limits first                          */
    double   transmission_min, transmission_max;    /* over the whole turn, or from station to station if the input does
                                    * not turn [rad]: the angle in [0, pi/2] whose squared sine is the margin of
                                    * mbs/batch/batch.h                                             */
    double   acceleration_max;     /* over the same range, by the input: of the tracer [m/rad^2], of a function of the
                                    * output angle [rad/rad^2]                                      */
    bool     has_class;            /* a four-bar that could be classified                           */
    lw_fourbar_class barker;
    int      n_cognate;            /* 0 or 2                                                        */
    double   cognate[2][9], cognate_mode[2];
    lw_stray stray;                /* of the whole closed curve from a closed target, of the arc between the ends from an
                                    * open one, both ways [m]; NaN for functions                    */
    double   as_made;              /* about 95 of 100 linkages made with the tolerances of the specification, or else of a workshop, stay
                                    * this near to the curve, and of a motion to the angle, over half the diagonal [m], of a function to
                                    * its output angle [rad]; NaN: the linkage has no derivatives; set by lw_fit_results_make        */
    double   spread;               /* the same if the specification has tolerances, else NaN                        */
    double   counts_as;            /* the error of an equally good four-bar of the target's size whose crank turns, with transmission angles of
                                    * at least 45 degrees, as a part of the diagonal, or of the swing of a function; NaN: without default
                                    * limits; set by lw_fit_results_make                                             */
    bool     passes_limit;         /* between the stations the input passes a limit or turns back; on a closed target it
                                    * does not turn fully                                           */
    double   size;                 /* greatest distance of two pins, or of a pin and a point, of one link [m]       */
    double   arm;                  /* greatest distance of a point from the nearest pin of its link [m]             */
    double   length_least, length_most;  /* distances of two pins of one link; NaN: no link has two [m]             */
    int      n_active;
    char     active[LW_ACTIVE_MAX][24];  /* limits that the result is at: "r1", "transmission", ...  (n_active)     */
    unsigned broken;               /* LW_LIMIT_ bits of the limits of the specification that it does not keep       */
    char     broken_text[160];     /* the first of them, in words                                   */
    /* the second simulation: the linkage written as a file, read back, moved by Newton's method */
    bool     meets;                /* the conditions on its motion and pivots (optimise/task/motion_limits.h)       */
    bool     no_memory;            /* inside lw_fit_report_make, which then fails                   */
    bool     verified;             /* it meets them, and both simulations agree                     */
    double   verified_objective;
    double   difference;           /* largest distance between the two simulations at a station [m] */
    char     fault[256];           /* why it was not verified; "" when it was                       */
} lw_fit_report;

/* "turns", "rocks", "limit": how the input moves between the stations. */
const char *lw_fit_report_input(const lw_fit_report *r);

/* Greatest distance of curve and target, both ways [m]; NaN for functions. */
double lw_fit_report_stray(const lw_fit_report *r);

/* The objective; 0 if no error of the report is more than rounding. */
double lw_fit_report_objective(const lw_candidate *c, const lw_fit_report *r);

/* Does a four-bar nearer than `margin` perimeters to a change point come near its flat posture, so that small errors of its lengths make
 * the motion another one?  One that rocks with transmission angles of 20 degrees or more, as a parallelogram may, does not, if all its pins
 * turn. */
bool lw_fit_report_may_change(const lw_fit_report *r, double margin);

/* The longest length, or the longest arm of a point of a path or motion if that is longer, over the shortest length. */
double lw_fit_report_ratio(const lw_target *t, const lw_fit_report *r);

/* The stray, but not less than the greatest error at a station, with its angle counted over half the diagonal of the
 * target [m]. */
double lw_fit_report_misses(const lw_target *t, const lw_fit_report *r);

/* How far the linkage is from what is known of the target [m]: its point at the stations, with the angle as above, and its curve.
 * Between the stations the target is an interpolation.  If a linkage meets all of many stations, its curve is more exact than that.
 * If a four-bar meets all of a few stations, it may leave the interpolation as far as other smooth curves through them do.  Longer
 * linkages may not: they can meet a few stations with any curve. */
double lw_fit_report_distance(const lw_target *t, const lw_fit_report *r);

/* What the linkage surely misses the target by [m]: as above, but between a few stations any linkage may leave the interpolation so far,
 * whether it meets them or not; this part of that distance counts. */
double lw_fit_report_known_miss(const lw_target *t, const lw_fit_report *r, double doubt);

/* The active limits with commas between. */
void lw_fit_report_active(const lw_fit_report *r, char *text, size_t size);

/* The least and greatest input of the candidate at the stations [rad] or [m]. */
void lw_fit_report_range(const lw_target *t, const lw_candidate *c, double *from, double *to);

/* Make the report.  `verified` is false, and `fault` says why, if the second simulation differs by more than 1e-9 of
 * the path's length (plus the rounding of its coordinates) or the conditions of s are not met.  LW_E_MEMORY. */
lw_status lw_fit_report_make(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r, lw_error *e);

/* The same from a twentieth of the postures and without likeness, reversals and second simulation, in a tenth of the time: for a search that
 * compares many linkages. */
lw_status lw_fit_report_sketch(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r);

/* The linkage of a candidate alone, in the posture of the first station, in the units of the target.  LW_OPEN: it does
 * not close there. */
lw_status lw_fit_report_linkage(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_linkage *k, lw_error *e);

#endif

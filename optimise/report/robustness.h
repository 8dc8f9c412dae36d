/* optimise/report/robustness.h - how far the path of a linkage spreads when every dimension varies.
 *
 * Lengths and coordinates of the plan (pins, offsets, the tracer, the place of the frame) vary independently, with a
 * standard deviation of a third of the tolerance.  Angles vary by the same over the mean length of the linkage.  A
 * clearance lets each pin lie anywhere in a circle of this radius around its place on the next link: the variance along
 * each axis is a quarter of the squared radius.  The input link keeps its angle. */
#ifndef LW_OPTIMISE_REPORT_ROBUSTNESS_H
#define LW_OPTIMISE_REPORT_ROBUSTNESS_H

#include "optimise/report/report.h"

#define LW_PART_MAX (LW_DIM_MAX + LW_JOINT_MAX)

typedef struct lw_robustness {
    /* to first order, from exact derivatives: root mean square distance of the point from its place [m] ... */
    double rms, worst;              /* ... over all postures, and in the worst posture                       */
    /* random linkages */
    int    trials, open;            /* drawn; of these do not close in every posture                      */
    double trial_rms;               /* the same as rms, of those that close [m]                        */
    double within;                  /* 95 of 100 of them stay this near in every posture [m]           */
    int    n_part, first;           /* dimensions, then pins if they have clearance; the one with the greatest part of rms^2 */
    char   name[LW_PART_MAX][4 + LW_NAME_SIZE];    /* of a pin "pin B"                                */
    double part[LW_PART_MAX];       /* of rms^2, their sum is 1                                        */
} lw_robustness;

/* Postures: the linkage's posture with its input moved by each of input[n] [rad] or [m], as the plan counts it.
 * LW_OPEN: the linkage itself does not close in one of them; LW_E_KIND: no plan knows it; LW_E_MEMORY; with a text. */
lw_status lw_robustness_make(const lw_linkage *linkage, const double *input, size_t n, const lw_tolerances *of,
                             lw_robustness *out, lw_error *e);

/* The same for a result, over the turn or between its stations.  LW_E_KIND: its motion passes a limit of the input. */
lw_status lw_robustness_of(const lw_target *t, const lw_candidate *c, const lw_fit_report *r, const lw_tolerances *of,
                           lw_robustness *out, lw_error *e);

/* The same to first order alone: the standard deviation in the worst posture [m], of a motion with that of the angle times half the
 * diagonal of the target; of a function that of the output angle alone [rad]. */
lw_status lw_robustness_deviation(const lw_target *t, const lw_candidate *c, const lw_fit_report *r, const lw_tolerances *of, double *out);

#endif

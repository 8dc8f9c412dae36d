/* optimise/report/results.h - the candidates of a search that pass the second simulation, each with its report. */
#ifndef LW_OPTIMISE_REPORT_RESULTS_H
#define LW_OPTIMISE_REPORT_RESULTS_H

#include "optimise/report/report.h"

/* A linkage that leaves the target by no more than this part of its diagonal follows it well. */
#define LW_NEAR 0.02
/* More links are searched where the first row counts as missing the target by more than this (lw_fit_report.counts_as); ... */
#define LW_ENOUGH 0.025
/* ... of few stations by more than this, since more links meet them nearly exactly. */
#define LW_GOOD   0.01

/* A candidate that is no result. */
typedef struct lw_left_out {
    int  candidate;
    char fault[256];               /* why                                                           */
} lw_left_out;

typedef struct lw_fit_results {
    int            n;
    int           *candidate;      /* number in lw_fit.candidate of each result, best first    (n)  */
    lw_fit_report *report;         /*                                                          (n)  */
    unsigned       broken;         /* LW_LIMIT_ bits that no linkage was found to keep, so that results break them */
    int            n_within;       /* results within the tolerance; 0: none is, or none was asked for */
    int            n_unfit;        /* candidates left out because they break a limit that results keep, ... */
    int            unfit_by[LW_LIMITS];  /* ... and of these, how many break limit 1 << i           (LW_LIMITS) */
    int            n_unseen;       /* candidates without a report, since the time was over          */
    int            n_left_out;
    lw_left_out   *left_out;       /*                                                 (n_left_out)  */
} lw_fit_results;

/* How much work the reports may be. */
typedef struct lw_results_effort {
    int    jobs;                   /* threads; < 1: one per core                                    */
    double until;                  /* wall clock (base/clock.h); 0: no limit                        */
    const volatile int *interrupt; /* may be NULL.  After `until`, or when this becomes nonzero, no further report is begun
                                    * once there is one to keep                                     */
} lw_results_effort;

/* Report on every candidate of `fit` and keep those that are verified: the first `most`, and beyond these the first
 * of each number of links; with default limits in order of lw_fit_report.counts_as, the first of each number of links
 * before the others.  may_fail (fit->n, or NULL): candidates with a nonzero entry need not pass the second simulation
 * if they meet the conditions; a linkage that must be taken apart between two stations cannot pass it.
 * effort: NULL for one thread without limit.
 * LW_E_MEMORY; then nothing is left to free. */
lw_status lw_fit_results_make(const lw_target *t, const lw_fit_spec *s, const lw_fit *fit, int most,
                              const unsigned *may_fail, const lw_results_effort *effort, lw_fit_results *out,
                              lw_error *e);
/* End a list where quality ends: leave out the rows that count as more than five times the best and as more than 2.5 %, and beside one
 * before them are neither much smaller nor simpler, gentler or alone in turning. */
void      lw_fit_results_end(const lw_target *t, const lw_fit *fit, lw_fit_results *r);
/* Make the report of each candidate that has none, and keep it with the candidate for lw_fit_results_make.  A report that cannot be
 * made, or not in time, is left to that. */
void      lw_fit_results_keep(const lw_target *t, const lw_fit_spec *s, lw_fit *fit, const lw_results_effort *effort);
/* The logarithm of counts_as, as lw_fit_options.cost, from a sketch of the report; INFINITY: the candidate breaks a limit or does not close. */
double    lw_fit_results_cost(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c);
void      lw_fit_results_free(lw_fit_results *r);

#endif

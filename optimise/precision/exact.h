/* optimise/precision/exact.h - precision points: linkages that pass through a few given positions exactly.
 *
 * A linkage of four links guides its coupler twice.  Each guide keeps a point of the coupler on a circle (RR), a
 * point on a line (PR), or a line of the coupler on a fixed pin (RP).  Given poses of the coupler, the guides that
 * suit all poses are computed; any two of them are a linkage (Burmester 1888; Bottema & Roth 1979, ch. 8).  A
 * function is a motion of the output link seen from the input link (Freudenstein 1955).  A path has poses whose
 * angles are free (Wampler, Morgan & Sommese 1992). */
#ifndef LW_OPTIMISE_PRECISION_EXACT_H
#define LW_OPTIMISE_PRECISION_EXACT_H

#include "base/vec2.h"
#include "optimise/search/fit.h"

/* ---- guides ------------------------------------------------------------------------------------- */

typedef enum lw_guide_kind { LW_GUIDE_RR, LW_GUIDE_PR, LW_GUIDE_RP } lw_guide_kind;

typedef struct lw_guide {
    lw_guide_kind kind;
    lw_vec2 centre;    /* RR, RP: fixed pin; PR: a point of the fixed line [m]                         */
    lw_vec2 point;     /* RR, PR: moving pin; RP: a point of the moving line.  In the frame of the tool:
                        * at pose j it is at  p_j + point e^{i angle_j}  [m]                           */
    lw_vec2 along;     /* unit direction of the line, PR in the plane, RP in the frame of the tool     */
} lw_guide;

/* Bodies at p[j], turned to angle[j] [m, rad]. */
typedef struct lw_poses { size_t n; const lw_vec2 *p; const double *angle; } lw_poses;

/* Four-bars with frame 1 whose output turns by theta[j] - theta[0] when the input turns by angle[j] - angle[0], for
 * three to five pairs.  Three: angles count from the frame.  Four: one offset is free, once the input's and once the
 * output's.  Five: both are free.  At most LW_FREUDENSTEIN_MAX. */
#define LW_FREUDENSTEIN_MAX 6
typedef struct lw_function_bar {
    double  length[4];             /* frame 1, input, coupler, output [1]                          */
    double  input0, output0;       /* angles of input and output at pair 0, from the frame [rad];
                                    * the output's from its ground pin to the coupler's            */
} lw_function_bar;
lw_status lw_freudenstein(size_t n, const double *angle, const double *theta,
                          lw_function_bar out[LW_FREUDENSTEIN_MAX], int *n_out, lw_error *e);

/* ---- linkages for a target --------------------------------------------------------------- */

/* Linkages through five points whose fixed pins are given, each driven from one of them. */
#define LW_EXACT_FIVE_MAX 36

typedef struct lw_exact {
    lw_fit    fit;                 /* candidates sorted by defects, then by quality                   */
    unsigned *defect;              /* bits of each                                            (fit.n) */
    double   *quality;             /* least sine of the transmission angle from the first to the last position, reduced
                                    * for links much longer than the target [1]               (fit.n) */
    long      n_real;              /* linkages with real dimensions; at most n_result are listed      */
    long      n_clean, n_order, n_branch, n_circuit;      /* of these: without defect, and by the worst defect */
    int       n_guide;             /* five poses: the guides found                                    */
    lw_guide  guide[4];
    int       n_theory;            /* nine points: 1442 Roberts triples over the complex numbers; five points with both
                                    * fixed pins given: 36 solutions; 0: other tasks                */
    long      n_general;           /* of these found at general complex points ...                  */
    long      n_triple, n_real_triple;     /* ... and at those of the target, complex and real       */
    long      n_singular;          /* of those not found there: their paths end at infinity or at a singular solution */
    bool      complete;            /* all linkages were found, as far as theory knows their number    */
    char      choice[256];         /* which dimensions were free and how they were chosen; "" none     */
} lw_exact;

/* Find linkages that pass through all stations of t, by o->spec.task: 2 to 5 poses, 3 to 5 pairs of a function, 2 to
 * 9 points of a path.  Five points with bounds x0, y0, r1, theta0 that leave one value each have finitely many, and all
 * are found.  Linkages that do not meet the bounds and conditions of the specification are left out.
 * max_rounds limits the effort.  types NULL: all types for five poses, else four-bars.  Input angles of a path or
 * motion, and weights, are ignored. The result is the same for any number of threads; max_seconds and interrupt end
 * the search earlier and keep what was found. LW_OK, LW_NOTHING (no real solution), LW_STOPPED, failures < 0:
 * LW_E_ARG too few or too many stations. */
lw_status lw_exact_run(const lw_target *t, const lw_fit_options *o, lw_exact *out, lw_error *e);
void      lw_exact_free(lw_exact *x);

#endif

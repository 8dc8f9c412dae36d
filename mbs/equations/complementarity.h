/* mbs/equations/complementarity.h - which forces act where bodies touch, with friction, at several places at once.
 *
 * For places i = 0 .. n-1 with normal forces N_i and tangential forces T_i (or impulses), the rates of gaps and slips
 * are  W f + b,  f = (N_0, T_0, N_1, ..), and
 *
 *     N_i >= least_i,  rate of the gap >= 0,  one of them 0;
 *     |T_i| <= mu_i N_i; where the slip has a rate or, with `slips`, a known sense, T_i = -mu_i N_i against it.
 *
 * Rates of rates for forces, rates for impulses.  In the form of Stewart & Trinkle 1996, by Lemke's method (base/lcp.h):
 * with set-valued friction at every place there always is a solution. */
#ifndef LW_MBS_EQUATIONS_COMPLEMENTARITY_H
#define LW_MBS_EQUATIONS_COMPLEMENTARITY_H

#include <stdbool.h>
#include "base/status.h"

typedef struct lw_touch_law {
    double friction;             /* mu; 0: none                                                        */
    double least;                /* of N                                                               */
    bool   fixed;                /* N is `least`: a compliant contact                                  */
    int    slips;                /* known sense of the slip, -1 or 1; 0: set-valued                    */
    bool   holds;                /* set-valued friction holds wherever it can: lw_complementarity_held */
} lw_touch_law;

/* w (2n x 2n), b (2n), law (n); force (2n), rate (2n) = W force + b.  LW_NOTHING: no solution was found (Painleve);
 * LW_E_MEMORY. */
lw_status lw_complementarity(int n, const double *w, const double *b, const lw_touch_law *law, double *force, double *rate);

/* Where rigid bodies share loads in several ways, friction that gives way in one solution may hold in another.  With law[].holds set, lw_complementarity
 * finds the forces within the friction cones that bring the rates nearest to 0 (Gauss's principle): a convex problem, whose rates are unique.  Does place
 * `which` then hold, its rates below a small part of the rate `slip` with which it gave way, and do all places with such friction that carry a force, so that
 * Coulomb's law is satisfied, too? */
bool lw_complementarity_held(int n, const lw_touch_law *law, const double *force, const double *rate, int which, double slip);

#endif

/* mbs/ode/panel_internal.h - integrals over a short interval from sixteen values of the integrand.
 *
 * A function f on 0 <= x <= 1 is known at the zeros of a Chebyshev polynomial.  Every integral needed is a mean
 * over the interval from 0 to x, which is a polynomial again and keeps its digits as x falls,
 *     mean(x) = 1/x int_0^x f = int_0^1 f(x y) dy,
 * and, for a motion that turns back at x = 0 and varies like u^2 there,
 *     root(x) = int_0^1 f(x y^2) dy,     so that    int_0^u f(u'^2) du' = u root(u^2). */
#ifndef LW_MBS_ODE_PANEL_INTERNAL_H
#define LW_MBS_ODE_PANEL_INTERNAL_H

#include "base/status.h"

#define LW_PANEL_NODES 16
#define LW_PANEL_PAST  6                                  /* values that predict the integral up to the next node */

typedef struct lw_panel_matrix { double row[LW_PANEL_NODES][LW_PANEL_NODES]; } lw_panel_matrix;

typedef struct lw_panel_rule {
    double at[LW_PANEL_NODES];                            /* the nodes, rising                                    */
    double whole[LW_PANEL_NODES];                         /* weights of the integral from 0 to 1                   */
    double begin[LW_PANEL_NODES], end[LW_PANEL_NODES];    /* weights of the values at 0 and 1                      */
    double gauss_at[LW_PANEL_NODES], gauss[LW_PANEL_NODES];   /* points and weights of Gauss: exact to degree 31       */
    lw_panel_matrix coef;                                 /* Chebyshev coefficients of the values                  */
    lw_panel_matrix mean, root;                           /* map values at the nodes to the means                  */
    /* Weights of the integral up to node i from the node before it, or from 0: ahead of the values at the nodes i - 1, i - 2 ..., those before
     * the first being the value at 0; and with the value at node i, which then is the first of them. */
    double ahead[LW_PANEL_NODES][LW_PANEL_PAST], with[LW_PANEL_NODES][LW_PANEL_PAST];
} lw_panel_rule;

/* LW_E_MEMORY */
lw_status lw_panel_rule_make(lw_panel_rule *r);

/* out = m f */
void lw_panel_apply(const lw_panel_matrix *m, const double *f, double *out);

/* Sum of weights f: with r->whole, or a row of a matrix. */
double lw_panel_sum(const double *weight, const double *f);

/* Value at x of the polynomial with Chebyshev coefficients c. */
double lw_panel_value(const double *c, double x);

/* The last two coefficients relative to the largest value of f: an estimate of the unresolved part. */
double lw_panel_tail(const lw_panel_rule *r, const double *f);

#endif

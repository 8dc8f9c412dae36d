/* mbs/fourbar.h - what the lengths of a four-bar say about its motion: class, turning, limits.
 * Barker 1985; Makkonen 1999, table 2, as corrected in docs/theory.md. */
#ifndef LW_MBS_FOURBAR_H
#define LW_MBS_FOURBAR_H

#include <stdbool.h>
#include "base/error.h"

typedef struct lw_fourbar_class {
    int         number;          /* 1 .. 14                                                       */
    const char *symbol;          /* "GCCC", "GCRR", ..., "CP3X"                                   */
    const char *name;            /* "crank-rocker", ...                                           */
    bool        grashof;         /* s + l <= p + q within the tolerance                           */
    bool        crank;           /* the input link turns fully                                    */
    bool        rocker_turns;    /* the output link turns fully                                   */
    double      change;          /* s + l - p - q over the perimeter: 0 at a change point [1]     */
    double      margin;          /* distance to the nearest change point: least over the three    */
                                 /* pairings of |sum of two - sum of the others| / perimeter [1]  */
    int         circuits;        /* 1 or 2                                                        */
    int         n_limit;         /* limits of the input angle: 0, 2 or 4                          */
    double      limit[4];        /* [rad], rising, in (-pi, pi], from the frame line              */
    int         n_dead;          /* input angles at which the output cannot be driven backwards   */
    double      dead[4];         /* (crank and coupler in line) [rad], rising                     */
    double      transmission[2]; /* least and greatest angle between coupler and output over the  */
                                 /* motion [rad], in [0, pi]                                      */
} lw_fourbar_class;

/* Classify frame r[0], input r[1], coupler r[2], output r[3], in any unit.  Sums are called equal
 * within tolerance * perimeter (default 1e-12).  LW_E_ARG: a length that is not positive and
 * finite, or the linkage cannot be assembled (longest >= sum of the others). */
lw_status lw_fourbar_classify(const double r[4], double tolerance, lw_fourbar_class *c, lw_error *e);

/* The other two linkages that trace the same coupler curve (Roberts): for a four-bar with coupler
 * point (cx, cy), frame at x0, y0, theta0.  in, out: r1 r2 r3 r4 cx cy x0 y0 theta0, and the mode.
 * LW_E_NUMERIC when a cognate degenerates (coupler point on a pivot). */
lw_status lw_fourbar_cognates(const double in[9], double mode, double out[2][9], double out_mode[2]);

#endif

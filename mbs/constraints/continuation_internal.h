/* mbs/constraints/continuation_internal.h - continuation of a motion: equations that determine one posture
 * (constraint rows, driven inputs and, on a curve of postures, a plane across it), Newton's method on them, Taylor
 * series along the motion, and a bound for a step that cannot jump to another branch.
 *
 * Why a step stays on its branch.  Let A be the derivative of the equations G(q) = c at q0, G(q0) = c0, and
 * T(q) = q - A^+ (G(q) - c).  With
 *
 *     |A^+ (G'(q) - G'(p)) v|  <=  kappa |q - p| |v|     for all q, p nearer to q0 than R = 1/kappa        (1)
 *     eta = |A^+ (c - c0)|,    2 kappa eta < 1                                                              (2)
 *
 * T maps the ball of radius r_- = (1 - sqrt(1 - 2 kappa eta))/kappa into itself and contracts all closed balls
 * within R (Kantorovich; Ortega & Rheinboldt 1970, 12.6), so every c on the way has exactly one solution
 * there, and it depends on c continuously.  A posture found within R for such a c is therefore on the branch of q0.
 *
 * kappa.  Pins and welds: the second derivative by the turn of body b is the stack of its arms, -R(phi_b) a, whose
 * length does not depend on q.  A^+ of it is c g + s g', where g and g' belong to the arms here and a quarter turn
 * further, so its length is at most the largest singular value of [g g'].  Rows that project on a slide line (slider,
 * slot, rack, driven slider) are bilinear in rotations and positions; the .c file derives their coefficients.  All
 * other rows are linear.  Norms take only the coordinates in which G is not linear: rotations, and positions of
 * bodies at slide lines.
 *
 * Systems of linkages are solved by dense matrices, larger ones by sparse ones: there the plane is replaced by one coordinate, and the
 * solution is moved along the null vector onto the plane. */
#ifndef LW_MBS_CONSTRAINTS_CONTINUATION_INTERNAL_H
#define LW_MBS_CONSTRAINTS_CONTINUATION_INTERNAL_H

#include "mbs/constraints/sparse_rows_internal.h"

#define LW_CONTINUATION_SHARE 0.9      /* share of the reach 1/(2 kappa) that a step may use                  */
#define LW_CONTINUATION_LEAST 1e-6     /* shortest step: branches nearer than about this count as crossing    */
#define LW_CONTINUATION_BACK  0.03     /* distance before a branch point from which a step crosses it          */

typedef struct lw_continuation {
    const lw_system *s;
    int     n, m;                          /* coordinates; equations                                */
    int     n_held, *held;                 /* driven inputs: rows n_row, n_row + 1, ...             */
    double *value;                         /* their values relative to the posture [rad or units]; with room for all inputs, tied ones too */
    bool    plane;                         /* last row: row . (q - origin) = distance               */
    double  distance;
    double *row, *origin, *tangent;        /* (n); tangent: result of the last lw_continuation_tangent    */
    bool    rough;                         /* few digits of solutions are needed                    */
    bool    has_tangent;                   /* make solutions orthogonal to the tangent              */
    bool   *curved;                        /* coordinates that norms include                        */
    double  kappa;                         /* result of the last lw_continuation_bound                    */
    double *matrix, *diag, *rest, *work, *series;    /* matrix: NULL where it is sparse                  */
    double *located;                       /* (m + 2 n) room for lw_continuation_locate                   */
    lw_body_frame *frame;                  /* (n_body + 1)                                          */
    lw_sparse_rows sparse;
    double *null;                          /* sparse, with a plane: null vector of the rows factored  */
    double *store;
} lw_continuation;

/* s must outlive f.  False: out of memory. */
bool   lw_continuation_create(const lw_system *s, const int *held, int n_held, bool plane, lw_continuation *f);
void   lw_continuation_free(lw_continuation *f);

/* Equations at q into f->rest, their derivatives into f->matrix (m x n, by columns), or into f->sparse without the plane. */
void   lw_continuation_assemble(lw_continuation *f, const double *q);

/* Factor the derivatives at q (with f->row as plane).  Returns the condition estimate of base/linalg.h. */
double lw_continuation_factor(lw_continuation *f, const double *q);

/* Unit tangent of the curve, on the side of f->row, from the factors; false if it is not determined.  The plane is
 * across this tangent until the next factorisation. */
bool   lw_continuation_tangent(lw_continuation *f);

/* Solve with right-hand side b (m); the first n numbers of b receive the solution. */
void   lw_continuation_solve(const lw_continuation *f, double *b);

/* kappa of (1) at q; f holds the factors at q. */
double lw_continuation_bound(lw_continuation *f, const double *q);

/* |q - p| in the norm that the bound uses. */
double lw_continuation_distance(const lw_continuation *f, const double *q, const double *p);

/* Newton's method from q; false if it does not converge.  Overwrites the factors. */
bool   lw_continuation_correct(lw_continuation *f, double *q);

/* Largest residual at q of the equations without the plane. */
double lw_continuation_residual(lw_continuation *f, const double *q);

/* Coefficients q[k*n ..], k = 1 .. order, of the motion through q[0 .. n-1]; f holds the factors there.  Driven
 * inputs move by value[i*(order + 1) + k]; NULL: they rest.  With a plane, q_1 is the tangent and the other
 * coefficients lie in the plane, so the parameter is the distance along the tangent. */
void   lw_continuation_series(lw_continuation *f, int order, const double *value, double *q);

/* What a series by least squares leaves in more equations than coordinates: the largest coefficient k of an equation, divided by rate^k.
 * It is rounding where the equations agree.  *rate: 0 is replaced by the rate at which inputs and coordinates move. */
double lw_continuation_misfit(lw_continuation *f, int order, const double *value, const double *q, double *rate);

/* out = sum of q[k*n ..] h^k */
void   lw_continuation_sum(const lw_continuation *f, int order, const double *q, double h, double *out);

/* Degrees of freedom that rows and driven inputs leave at q, from their rank (diagonals below 1e-9 count as 0), and a
 * unit vector (n) of such a motion if there is one.  -1: out of memory. */
int    lw_continuation_freedoms(lw_continuation *f, const double *q, double *direction);

/* The same with another `least` diagonal; the motion is drawn by `seed`, across the unit vector `without` unless
 * that is NULL. */
int    lw_continuation_null(lw_continuation *f, const double *q, double least, uint64_t seed, const double *without, double *out);

/* out (m without the plane): a unit vector of the null space of the transposed derivatives.  Returns its dimension, -1: out of
 * memory. */
int    lw_continuation_left_null(lw_continuation *f, const double *q, double least, double *out);

/* Locate where the equations lose rank between two regular postures.  `series` is the motion as a function of x from a
 * posture before that point, `guess` an estimate.  set(context, x) sets the equations of f to those at x.  Accurate to
 * about 1e-11; returns the guess if nothing better is found. */
double lw_continuation_locate(lw_continuation *f, int order, const double *series, double guess,
                        void (*set)(void *context, double x), void *context);

#endif

/* mbs/constraints/continuation_internal.h - the equations of a linkage that is held to one posture: rows, driven inputs and, on a
 * curve of postures, a plane across it; Newton's method on them, series along the motion, and a bound that
 * tells how far one branch reaches.  Internal to mbs/.
 *
 * Why a step stays on its branch.  Let A be the derivative of the equations G(q) = c at q0, G(q0) = c0, and
 * T(q) = q - A^+ (G(q) - c).  With
 *
 *     |A^+ (G'(q) - G'(p)) v|  <=  kappa |q - p| |v|     for all q, p nearer to q0 than R = 1/kappa        (1)
 *     eta = |A^+ (c - c0)|,    2 kappa eta < 1                                                              (2)
 *
 * T maps the ball of radius r_- = (1 - sqrt(1 - 2 kappa eta))/kappa into itself and contracts all closed balls
 * within R (Kantorovich; Ortega & Rheinboldt 1970, 12.6), so every c on the way has one solution there, which
 * depends on c continuously: a posture found within R for such a c is on the branch of q0.  There is no other.
 *
 * kappa.  Pins and welds: the second derivative by the turn of body b is the stack of its arms, -R(phi_b) a, of
 * constant length whatever q, so A^+ of it is c g + s g' with g, g' that of the arms here and a quarter turn on; its
 * length is at most the greatest singular value of [g g'].  Rows that project on a slide line (slider, slot, rack,
 * driven slider) are bilinear in turns and places with coefficients read off below.  All other rows are linear.
 * Norms are those of the coordinates in which G is not linear: turns, and places of bodies at slide lines. */
#ifndef LW_MBS_CONSTRAINTS_CONTINUATION_INTERNAL_H
#define LW_MBS_CONSTRAINTS_CONTINUATION_INTERNAL_H

#include "mbs/constraints/system_internal.h"

#define LW_CONTINUATION_SHARE 0.9      /* of the reach 1/(2 kappa) that a step may use                        */
#define LW_CONTINUATION_LEAST 1e-6     /* step: branches nearer than about this are taken to cross            */
#define LW_CONTINUATION_BACK  0.03     /* before a branch point, from where it is leapt over                   */

typedef struct lw_continuation {
    const lw_system *s;
    int     n, m;                          /* coordinates; equations                                */
    int     n_held, held[LW_INPUT_MAX];    /* inputs that are driven: rows n_row, n_row + 1, ...    */
    double  value[LW_INPUT_MAX];           /* what they count, from the posture [rad or units]      */
    bool    plane;                         /* last row: row . (q - origin) = distance               */
    double  distance;
    double *row, *origin, *tangent;        /* (n); tangent: of the last lw_continuation_tangent           */
    bool    has_tangent;                   /* solutions are made orthogonal to it                   */
    bool    curved[LW_SYSTEM_Q_MAX];       /* coordinates that count in norms                       */
    double  kappa;                         /* of the last lw_continuation_bound                           */
    double *matrix, *diag, *rest, *work, *series;
    double *store;
} lw_continuation;

/* s must outlive f.  False: out of memory. */
bool   lw_continuation_create(const lw_system *s, const int *held, int n_held, bool plane, lw_continuation *f);
void   lw_continuation_free(lw_continuation *f);

/* Equations at q into f->rest, their derivatives into f->matrix (m x n, by columns). */
void   lw_continuation_assemble(lw_continuation *f, const double *q);

/* Factors at q (with f->row as plane).  Returns the quick condition of base/linalg.h. */
double lw_continuation_factor(lw_continuation *f, const double *q);

/* Unit tangent of the curve, on the side of f->row, from the factors; false when it is not determined.  From
 * now on the plane is across it, until the next factors. */
bool   lw_continuation_tangent(lw_continuation *f);

/* b (m) -> solution in its first n numbers. */
void   lw_continuation_solve(const lw_continuation *f, double *b);

/* kappa of (1) at q, whose factors f holds. */
double lw_continuation_bound(lw_continuation *f, const double *q);

/* |q - p| in the norm of the bound */
double lw_continuation_distance(const lw_continuation *f, const double *q, const double *p);

/* Newton's method from q; false when it does not converge.  Factors are lost. */
bool   lw_continuation_correct(lw_continuation *f, double *q);

/* What the equations without the plane leave over at q, the greatest in size. */
double lw_continuation_residual(lw_continuation *f, const double *q);

/* Coefficients q[k*n ..], k = 1 .. order, of the motion through q[0 .. n-1], whose factors f holds.  Driven inputs
 * count value[i*(order + 1) + k]; NULL: they rest.  Plane: q_1 is the tangent, the others lie in the
 * plane, so the parameter is the distance along the tangent. */
void   lw_continuation_series(lw_continuation *f, int order, const double *value, double *q);

/* Sum of q[k*n ..] h^k */
void   lw_continuation_sum(const lw_continuation *f, int order, const double *q, double h, double *out);

/* How many freedoms the rows and driven inputs leave at q, by their rank (diagonals below 1e-9 count as 0), and a unit
 * vector (n) of the freedoms, if there are any.  -1: out of memory. */
int    lw_continuation_freedoms(const lw_continuation *f, const double *q, double *direction);

/* Where between two good postures the equations lose rank (follow_singular.c): `series` of the motion by x from a
 * posture before, guess: about where.  set(context, x) makes f's equations those at x.
 * Right to about 1e-11; the guess where nothing better is found. */
double lw_continuation_locate(lw_continuation *f, int order, const double *series, double guess,
                        void (*set)(void *context, double x), void *context);

#endif

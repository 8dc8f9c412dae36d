/* mbs/dynamics/modes_internal.h - eigenvalues (bridge to GSL) and the reduced equations behind mbs/dynamics/modes.h. */
#ifndef LW_MBS_DYNAMICS_MODES_INTERNAL_H
#define LW_MBS_DYNAMICS_MODES_INTERNAL_H

#include "base/rank.h"
#include "mbs/dynamics/modes.h"
#include "mbs/dynamics/statics.h"

/* K x = w M x for symmetric K (n*n) and symmetric positive definite M, by rows; w (n) rising, x[k*n + i] component i of
 * vector k.  K, M are overwritten.  LW_E_NUMERIC: M is not positive definite. */
lw_status lw_eigen_symmetric(int n, double *k, double *m, double *w, double *x);

/* A x = s x for any A (n*n), overwritten; re, im (n), x_re, x_im[k*n + i] component i of vector k. */
lw_status lw_eigen_general(int n, double *a, double *re, double *im, double *x_re, double *x_im);

/* One posture's equations: rows (system, then held inputs), null space, reduced matrices. */
typedef struct lw_vibration {
    const lw_forces *f;
    int     n_q, n_row, n_free;          /* n_row with held inputs                                     */
    int     n_held, held[LW_INPUT_MAX];
    double  want[LW_INPUT_MAX];          /* what held inputs count                                      */
    int     redundant;
    double *phi, *jac;                   /* (n_row), (n_row*n_q) by columns                             */
    double *null;                        /* [k*n_q + i], orthonormal (n_free)                           */
    double *force, *dq, *dv, *l;         /* (n_q) (n_q*n_q) (n_q*n_q) (n_row)                           */
    double *mass, *damping, *stiffness;  /* reduced (n_free*n_free), by rows                            */
    double *load;                        /* reduced force (n_free)                                      */
    lw_rank rank, kkt;
    double *memory;
    int    *ints;
} lw_vibration;

lw_status lw_vibration_make(const lw_forces *f, bool hold_inputs, double t, const double *q, lw_vibration *v);
void      lw_vibration_free(lw_vibration *v);

/* Body coordinates of a reduced vector re + i im (NULL: real) of a mode; its numbers for an eigenvalue. */
void lw_mode_shape(const lw_vibration *v, const double *re, const double *im, lw_mode *mode);
void lw_mode_finish(lw_mode *m, double re, double im);

/* All modes of a damped or not symmetric vibration; room of 17 n_free^2 + 8 n_free. */
lw_status lw_modes_damped(const lw_vibration *v, double *room, lw_modes *out);

/* Put q on the rows by the least change.  LW_OPEN: not near. */
lw_status lw_vibration_project(lw_vibration *v, double *q);

/* Null space, multipliers and reduced matrices at (t, q). */
lw_status lw_vibration_linearise(lw_vibration *v, double t, const double *q);

/* Move q to where no force is left, downhill: to a stable rest where there is one near (mbs/dynamics/statics.c).  LW_NOTHING: the
 * forces drive it away. */
lw_status lw_vibration_rest(lw_vibration *v, double t, double *q, lw_rest *r, lw_error *e);

#endif

/* mbs/dynamics/tangent_internal.h - sparse matrices of implicit steps, of equilibrium and of vibrations; internal to mbs/.
 *
 *     [ m M + c C + K   -dQ/dz        s J^T ]        K = -dQ/dq + sum l_r H_r,  C = -dQ/dv,  J: the kept rows,
 *     [ -f_q - c f_v    c 1 - df/dz     0   ]        H_r: second derivatives of row r (none of gears and ties are counted)
 *     [      s J            0           0   ]        f: rates of the first-order states z, which are counted in their scales
 *
 * m and c may be complex: then each unknown is a pair (real, imaginary), one after the other.  The scale s keeps the rows
 * near the size of the rest. */
#ifndef LW_MBS_DYNAMICS_TANGENT_INTERNAL_H
#define LW_MBS_DYNAMICS_TANGENT_INTERNAL_H

#include "base/sparse_lu.h"
#include "mbs/dynamics/dynamics_equations_internal.h"

typedef struct lw_tangent {
    lw_dynamics *d;
    bool    is_complex, consistent;      /* consistent: masses of elements by their shape functions, where asked for */
    bool    rubs;                        /* friction counts in C, its reactions those of l */
    int     n, z, c;                     /* velocities; states; kept rows */
    double  scale;                       /* s */
    lw_columns columns;
    double *value;
    lw_sparse_lu *lu;
    int    *kept;                        /* (c) the rows it was made for */
    int    *pair;                        /* while the pattern is listed */
    long    n_pair, most_pair;
    bool    failed;
    double  weight_re, weight_im;        /* of C, while it is filled; */
    double  mass_re, mass_im;            /* of M */
    double *heavy;                       /* entries of M besides its diagonal, as filled last; NULL: there are none */
    double *work;                        /* (n + z + c) scratch, where there are such entries */
} lw_tangent;

/* LW_E_MEMORY.  t needs lw_tangent_free, after a failure too. */
lw_status lw_tangent_make(lw_dynamics *d, bool is_complex, bool consistent, lw_tangent *t);
void      lw_tangent_free(lw_tangent *t);

/* The same for a tangent that may have been made for this d before: made anew only where other rows are kept now. */
lw_status lw_tangent_renew(lw_dynamics *d, bool is_complex, bool consistent, lw_tangent *t);

/* Fill and factor at (t, q, v, l), l of the kept rows; the rows are those of lw_mbs_rows at q.  m, c: real and imaginary
 * part.  LW_E_NUMERIC: singular. */
lw_status lw_tangent_factor(lw_tangent *t, double time, const double *q, const double *v, const double *l,
                            const double m[2], const double c[2]);
void      lw_tangent_fill(lw_tangent *t, double time, const double *q, const double *v, const double *l,
                          const double m[2], const double c[2]);         /* without the factors */

/* Solve in place: b (n + z + c, or twice as many); the last c are multipliers, already divided by s. */
void lw_tangent_solve(lw_tangent *t, double *b);

/* out (n) = M x, of consistent masses where they are asked for. */
void lw_tangent_mass(const lw_tangent *t, const double *q, const double *x, double *out);

/* The same with the masses as they were filled last. */
void lw_tangent_mass_filled(const lw_tangent *t, const double *x, double *out);

/* Accelerations a and multipliers l (n_c) at (t, q, v) of masses that depend on q: M a + J^T l = force, J a = d->rhs, the rows those at
 * hand; friction, if any, under l.  LW_OPEN: not found. */
lw_status lw_tangent_accelerate(lw_dynamics *d, const double *q, const double *v, const double *force, double *a, double *l);

/* out (n + z) += by C x, below it -by f_v x, x (n), from the imaginary parts of a complex matrix as it was filled last. */
void lw_tangent_damp(const lw_tangent *t, double by, const double *x, double *out);

/* Accelerations a and multipliers of the kept rows l at rest: M a + J^T l = Q, J a = 0.  Leaves Q in d->force. */
lw_status lw_tangent_at_rest(lw_dynamics *d, double t, const double *q, const double *still, double *a, double *l);

/* d->l (n_c) from l of the kept rows. */
void lw_tangent_spread(lw_dynamics *d, const double *l);

/* out (n) += J^T l, l of the kept rows. */
void lw_tangent_push(const lw_dynamics *d, const double *l, double *out);

#endif

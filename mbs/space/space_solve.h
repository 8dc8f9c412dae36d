/* mbs/space/space_solve.h - the rows in force of a spatial model at one posture, factored, and what is solved with
 * them.
 *
 *     x = W (f - J^T l),   J x = c          W: a positive diagonal, the inverse masses or a metric of displacements
 *
 * by Cholesky's method on J W J^T over a basis of the rows, stored and computed without zeros.  Massless bodies and
 * models where that fails are solved by rank (lw_space_dense). */
#ifndef LW_MBS_SPACE_SPACE_SOLVE_H
#define LW_MBS_SPACE_SPACE_SOLVE_H

#include "base/rank.h"
#include "base/sparse.h"
#include "mbs/space/space.h"

/* More rows than these are not judged by a full matrix if the sparse factors leave no doubt: each pivot over its diagonal is above
 * this, or rounding. */
enum { LW_SPACE_MANY_ROWS = 300 };
#define LW_SPACE_CLEAR_SHARE 1e-8

/* Two kept rows that share a body: their derivatives by it in jac and jac_w, and the entry of schur they add to. */
typedef struct lw_space_pair { int row, other, to; } lw_space_pair;

typedef struct lw_space_rows_set {
    const lw_space *s;
    int      n_row, n_extra;             /* rows in force: joints, couplings, extras                      */
    lw_space_extra *extra;
    double  *weight;                     /* (n_v) W                                                        */
    int      n_near;                     /* n_extra, and with couplings n_joint                            */
    double  *near;                       /* (n_near) angle near which each measure counts; turns of joints for couplings */
    lw_space_frame *frame;               /* (n_body + 1) at the posture placed last                        */
    double  *phi, *jac, *jac_w;          /* (n_row); derivatives of row r from at[r] to at[r + 1], six for each body; times W */
    int     *at;                         /* (n_row + 1)                                                    */
    int     *body;                       /* (at[n_row]/6) lw_space_rows_bodies                             */
    int      n_kept, *kept, *place;      /* a basis in the order of elimination; place in it, -1: left out */
    int      rank;                       /* greatest n_kept so far: in a singular posture the basis has fewer rows; 0: not counted yet */
    int      n_pair;
    lw_space_pair *pair;
    lw_cholesky schur;
    double   weak;                       /* least pivot over its diagonal when factored last; NAN: never   */
    double  *filled, *factored;          /* (n_q) postures of the rows and of the factors                  */
    double  *small, *full, *step;                /* (n_row) (n_v) (n_v) scratch                            */
    double (*four)[4];                   /* (n_row + n_v) scratch                                          */
    double  *moved;                      /* (n_v) sum of the steps of lw_space_rows_close                  */
    void    *memory;
} lw_space_rows_set;

/* The bodies by which row r has derivatives; -1: ground, or none. */
static inline int  lw_space_rows_sides(const lw_space_rows_set *z, int r) { return (z->at[r + 1] - z->at[r])/6; }
static inline int *lw_space_rows_bodies(const lw_space_rows_set *z, int r) { return z->body + z->at[r]/6; }

/* Rows of the joints and the extras (copied).  weight (n_v).  The basis is found at q.  LW_E_MEMORY. */
lw_status lw_space_rows_make(const lw_space *s, const lw_space_extra *extra, int n_extra, const double *weight,
                             const double *q,
                             lw_space_rows_set *z, lw_error *e);
void      lw_space_rows_free(lw_space_rows_set *z);

/* Find the basis anew at q: `rank` rows, as independent as possible there, or fewer where the posture is singular.  n_kept is the rank there. */
lw_status lw_space_rows_arrange(lw_space_rows_set *z, const double *q, lw_error *e);

/* Rows at q, with wanted values `target` of the extras (over their scale; 0 for spins), and their factors. */
void lw_space_rows_fill(lw_space_rows_set *z, const double *q, const double *target);

/* How far the joints are open where the rows were filled, those left out as dependent, too: the greatest row, over the size or in radians. */
double lw_space_rows_open(const lw_space_rows_set *z);

bool lw_space_rows_factor(lw_space_rows_set *z);       /* false: singular */

/* The same for solves that refine: factors of a posture so near that these leave rounding only are kept. */
bool lw_space_rows_factor_near(lw_space_rows_set *z);

/* x and l (n_row, 0 for rows left out; not z->small) of the system above; f, rhs NULL: 0.  Factored.  `refine`: corrected for the
 * rounding, once or until little changes.  false: it does not converge, the factors are too inexact. */
bool lw_space_rows_solve(lw_space_rows_set *z, const double *f, const double *rhs, bool refine, double *x, double *l);

/* The motions x (n of n_v) that change one of n rows from `first` on, all kept, at the rate 1 and no other row; refined.  false as above. */
bool lw_space_rows_motions(lw_space_rows_set *z, int n, int first, double *x);

/* l of J^T l = f in the metric of W, for f that the rows can carry. */
void lw_space_rows_carry(lw_space_rows_set *z, const double *f, double *l);

/* x += sign J^T l. */
void lw_space_rows_add(const lw_space_rows_set *z, double sign, const double *l, double *x);

/* The greatest entry of J x - rhs in the rows left out as dependent. */
double lw_space_rows_left_out(const lw_space_rows_set *z, const double *x, const double *rhs);

/* The right-hand side of J a = out (n_row), without second rates of extras, which the caller adds. */
void lw_space_rows_bias(const lw_space_rows_set *z, const double *v, double *out);

/* Put q on the rows by Newton's method, the change least in W.  LW_OPEN: it does not converge, or a first step is
 * longer than `longest` (in lengths over the size and radians; 0: no limit). */
lw_status lw_space_rows_close(lw_space_rows_set *z, double *q, const double *target, double longest);

/* The greatest displacement of a body in by (n_v): over the size, and in radians. */
double lw_space_length(const lw_space *s, const double *by);

/* W of displacements: 1 for lengths over the size and for radians. */
void lw_space_metric(const lw_space *s, double *weight);

/* The same rows as a full matrix J^T (n_v x n_row) in a rank-revealing factorisation, scaled by the root of W. */
typedef struct lw_space_dense { lw_rank rank; double *doubles; int *ints; int n_v, n_row; } lw_space_dense;
lw_status lw_space_dense_make(const lw_space_rows_set *z, lw_space_dense *d, lw_error *e);
void      lw_space_dense_free(lw_space_dense *d);
void      lw_space_dense_factor(const lw_space_rows_set *z, lw_space_dense *d, double least);

#endif

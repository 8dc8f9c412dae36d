/* mbs/equilibrium/vibration_internal.h - equations of small vibrations and of equilibrium; internal to mbs/. */
#ifndef LW_MBS_EQUILIBRIUM_VIBRATION_INTERNAL_H
#define LW_MBS_EQUILIBRIUM_VIBRATION_INTERNAL_H

#include "base/rank.h"
#include "mbs/equilibrium/modes.h"
#include "mbs/equilibrium/statics.h"

/* Equations of one posture: rows (system, then held inputs), null space, reduced matrices. */
typedef struct lw_vibration {
    const lw_forces *f;                  /* NULL where eq is given, */
    const lw_equations *eq;              /* for names of links only */
    int     n_q, n_row, n_free;          /* n_row includes held inputs */
    int     n_held, held[LW_INPUT_MAX];
    double  held_value[LW_INPUT_MAX];          /* values of held inputs */
    int     redundant;
    double *phi, *jac;                   /* (n_row), (n_row*n_q) by columns */
    double *null;                        /* [k*n_q + i], orthonormal (n_free) */
    double *force, *dq, *dv, *l;         /* (n_q) (n_q*n_q) (n_q*n_q) (n_row) */
    double *mass, *damping, *stiffness;  /* reduced (n_free*n_free), by rows */
    double *load;                        /* reduced force (n_free) */
    lw_rank rank, kkt;
    double *memory;
    int    *ints;
} lw_vibration;

lw_status lw_vibration_make(const lw_forces *f, bool hold_inputs, double t, const double *q, lw_vibration *v);
void      lw_vibration_free(lw_vibration *v);

/* Put q on the rows by the least change.  LW_OPEN: no posture near q. */
lw_status lw_vibration_project(lw_vibration *v, double *q);

/* Modes of the reduced matrices, n_free at most LW_SYSTEM_Q_MAX; the rest of *out is unchanged. */
lw_status lw_modes_solve(lw_vibration *v, lw_modes *out, lw_error *e);

/* Modes of a model of any size about q, with *modes cleared before; else as lw_modes_find_large (mbs/equilibrium/modes_large.c).  damping:
 * false leaves it out, for stability at rest; LW_E_KIND then also for few freedoms under loads without potential.  kept: its matrices from the call
 * before, or NULL. */
lw_status lw_modes_about(lw_dynamics *d, int wanted, bool damping, struct lw_tangent *kept, double t, double *q, lw_modes *modes, lw_error *e);

/* Null space, multipliers and reduced matrices at (t, q). */
lw_status lw_vibration_linearise(lw_vibration *v, double t, const double *q);

/* Move q downhill to equilibrium, a stable one where there is one near.  LW_NOTHING: the forces drive it away. */
lw_status lw_vibration_rest(lw_vibration *v, double t, double *q, lw_rest *r, lw_error *e);

#endif

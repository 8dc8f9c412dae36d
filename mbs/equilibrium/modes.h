/* mbs/equilibrium/modes.h - small vibrations of a model about a posture: eigenfrequencies, damping, shapes.
 *
 * With Z a basis of the motions that the constraints J allow, l their multipliers in the posture at rest (M a + J^T l =
 * Q, J a = 0) and H_r the second derivatives of row r:
 *
 *     Z^T M Z x'' + Z^T C Z x' + Z^T (K + sum l_r H_r) Z x = 0,    K = -dQ/dq,  C = -dQ/dv
 *
 * The sum is the geometric stiffness of the constraint forces: without it a pendulum would have no frequency.  Where
 * the posture is no equilibrium, `unbalanced` says by how much, and the result is that of the equations frozen
 * there.  Inputs with a motion are held. */
#ifndef LW_MBS_EQUILIBRIUM_MODES_H
#define LW_MBS_EQUILIBRIUM_MODES_H

#include "mbs/equations/forces.h"

typedef struct lw_mode {
    double re, im;               /* eigenvalue s [1/s], im >= 0; one mode for a conjugate pair */
    double frequency;            /* im/(2 pi) [Hz] */
    double natural;              /* |s|/(2 pi) [Hz] */
    double damping;              /* -re/|s|; 0 for s = 0; below 0 the motion grows */
    double *shape, *phase;       /* (n_q) coordinate i moves as shape_i cos(im t + phase_i) exp(re t); greatest shape 1;
                                    coordinates are those of the system, scaled */
} lw_mode;

typedef struct lw_modes {
    int     freedom;             /* degree of freedom of the vibration */
    int     n_mode;              /* conjugate pairs and real eigenvalues, sorted by |s| */
    int     redundant;           /* rows that depend on others */
    double  unbalanced;          /* greatest generalised force left without constraint, over the greatest of all */
    bool    cut;                 /* further modes were wanted, which are not known to 1e-6 (large models under loads without a potential) */
    bool    conservative;        /* no damping, symmetric stiffness: eigenvalues are exactly imaginary, 0 or real */
    lw_mode mode[2*LW_SYSTEM_Q_MAX];
    double *memory;              /* of the shapes */
} lw_modes;

void lw_modes_free(lw_modes *modes);

#define LW_MODES_DEFAULT 20          /* modes of a large model that are looked for unless told otherwise */

typedef struct lw_modes_options {
    bool hold_inputs;            /* hold every input, not only those with a motion */
    bool rest;                   /* move to the static equilibrium first */
    struct lw_tangent *kept;     /* lw_modes_find_large: matrices kept between calls for one model; NULL: none */
} lw_modes_options;

/* modes needs lw_modes_free after each call.
 *
 * Modes about q (n_q), which is put on the constraints and, with o->rest, moved to equilibrium.  Loads are those at
 * time t.  LW_NOTHING: no freedom is left.  LW_E_ARG: a motion has no mass (the link is named).  LW_OPEN: no posture
 * on the constraints is near q.  LW_E_NUMERIC: no equilibrium was found. */
lw_status lw_modes_find(const lw_forces *f, const lw_modes_options *o, double t, double *q, lw_modes *modes, lw_error *e);

/* The same for models of any size, with elastic links: the `wanted` slowest modes, at most LW_SYSTEM_Q_MAX/2 - 2.  Inputs with a
 * motion are held where d holds them; o->hold_inputs is not looked at. */
struct lw_dynamics;
lw_status lw_modes_find_large(struct lw_dynamics *d, const lw_modes_options *o, int wanted, double t, double *q, lw_modes *modes,
                              lw_error *e);

/* Move q to where input `input` has the value [rad] or [m] and the other inputs stay, in steps of a twentieth of the
 * size of the linkage or of a radian, which keeps the assembly mode.  LW_OPEN: q does not get there and is as far as
 * it came. */
lw_status lw_modes_move_input(const lw_forces *f, double t, int input, double value, double *q, lw_error *e);

#endif

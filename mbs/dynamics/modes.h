/* mbs/dynamics/modes.h - small vibrations of a model about a posture: eigenfrequencies, damping, shapes.
 *
 * With Z a basis of the motions the constraints J leave, l their multipliers in that posture at rest (M a + J^T l = Q,
 * J a = 0) and H_r the second derivatives of row r:
 *
 *     Z^T M Z x'' + Z^T C Z x' + Z^T (K + sum l_r H_r) Z x = 0,    K = -dQ/dq,  C = -dQ/dv
 *
 * The sum is the geometric stiffness of the constraint forces: without it a pendulum would have no frequency.  Where
 * the posture is no equilibrium, `unbalanced` says by how much, and the numbers are those of the equations
 * frozen there.  Motions that inputs prescribe are held. */
#ifndef LW_MBS_DYNAMICS_MODES_H
#define LW_MBS_DYNAMICS_MODES_H

#include "mbs/dynamics/forces.h"

typedef struct lw_mode {
    double re, im;               /* eigenvalue s [1/s], im >= 0; one mode for a pair                  */
    double frequency;            /* im/(2 pi) [Hz]                                                    */
    double natural;              /* |s|/(2 pi) [Hz]                                                    */
    double damping;              /* -re/|s|; 0 for s = 0; < 0: grows                                   */
    double shape[LW_SYSTEM_Q_MAX], phase[LW_SYSTEM_Q_MAX];
                                 /* coordinate i moves as shape_i cos(im t + phase_i) exp(re t); greatest shape 1;
                                    coordinates are those of the system, scaled                       */
} lw_mode;

typedef struct lw_modes {
    int     freedom;             /* of the vibration                                                  */
    int     n_mode;              /* pairs and single real eigenvalues, by |s|                          */
    int     redundant;           /* rows that say nothing new                                         */
    double  unbalanced;          /* greatest generalised force no constraint takes, over the greatest of all */
    bool    conservative;        /* undamped, symmetric: eigenvalues are exactly imaginary, 0 or real   */
    lw_mode mode[2*LW_SYSTEM_Q_MAX];
} lw_modes;

typedef struct lw_modes_options {
    bool hold_inputs;            /* hold every input, not only those with a motion                    */
    bool rest;                   /* go to the static equilibrium first                                */
} lw_modes_options;

/* Modes about q (n_q), which is put on the constraints and, with o->rest, at rest; t for loads that know time.
 * LW_NOTHING: no freedom is left.  LW_E_ARG: a motion without any mass or stiffness (the link is named).
 * LW_OPEN: no posture on the constraints near q.  LW_E_NUMERIC: no equilibrium found. */
lw_status lw_modes_find(const lw_forces *f, const lw_modes_options *o, double t, double *q, lw_modes *modes,
                        lw_error *e);

/* Move q to where input `input` counts `value` [rad] or [m], the others held where they are: in steps of a twentieth
 * of the linkage's size or rad, so that the branch is kept.  LW_OPEN: it does not get there; q is as far as it came. */
lw_status lw_modes_drive(const lw_forces *f, double t, int input, double value, double *q, lw_error *e);

/* Check by ear: let the model go from q, its modes pushed a little, and look where the spectra of its motion have
 * their peaks.  The full equations are integrated, none of the matrices above is used.  peak (n_mode) [Hz]; NAN: the
 * mode does not vibrate, dies out too fast (damping above 0.1) or has no peak of its own near.  Loads are taken at t,
 * and motions of inputs held.  LW_NOTHING: no mode vibrates; LW_E_NUMERIC: the run breaks off. */
lw_status lw_modes_listen(const lw_forces *f, const lw_modes_options *o, double t, const double *q,
                          const lw_modes *modes, double *peak, lw_error *e);

#endif

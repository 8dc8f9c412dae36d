/* mbs/dynamics/dynamics_internal.h - the equations of a run and their memory; internal to mbs/.
 *
 *     M a + J^T l = Q,   J a = c          rows: system, driven inputs, touched stops
 *
 * Two ways.  Where all masses are positive and the rows kept are well apart, by Cholesky's method on
 * J M^-1 J^T ("fast"); else, with massless links, near singular postures and for reactions that are not
 * unique, by a rank-revealing factorisation of J^T and the null space it leaves ("sure"). */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_INTERNAL_H
#define LW_MBS_DYNAMICS_DYNAMICS_INTERNAL_H

#include "base/rank.h"
#include "mbs/dynamics/dynamics.h"
#include "mbs/ode/integrate.h"
#include "mbs/constraints/system_internal.h"

#define LW_STOP_ROW_MAX 16               /* stops that can be touched at one time                     */
#define LW_MBS_ROW_MAX  (LW_SYSTEM_ROW_MAX + LW_INPUT_MAX + LW_STOP_ROW_MAX)

typedef struct lw_pair { int row, other, body, to; } lw_pair;     /* rows that share a body, and where in schur  */

typedef struct lw_contact { int joint; bool greatest, touching; } lw_contact;    /* a rigid stop      */

struct lw_dynamics {
    const lw_model      *model;
    lw_dynamics_options  o;
    lw_system            s;
    lw_forces            f;
    int     n_q, n_row, n_c;                  /* n_c: rows in force, n_row of the system first         */
    int     n_driven, driven[LW_INPUT_MAX];   /* inputs with a motion                                  */
    int     n_contact;
    lw_contact contact[2*LW_JOINT_MAX];
    int     n_touching, touching[LW_STOP_ROW_MAX];
    int     n_friction, friction[LW_JOINT_MAX];
    int     rank, freedom;                    /* of J in a posture that is not singular; n_q - rank     */
    bool    has_zero_mass;
    int     n_pair, most_pair;
    lw_pair *pair;
    int     n_kept, kept[LW_MBS_ROW_MAX], place[LW_MBS_ROW_MAX];   /* rows of the fast way; -1: left out */
    int     *after, after_at[LW_MBS_ROW_MAX + 1];    /* pattern of U, S = U^T U: columns right of the diagonal */
    unsigned char *near;                      /* (n_c*n_c) while that is found                         */
    int     row_body[LW_MBS_ROW_MAX][LW_SYSTEM_ROW_BODIES];
    /* at the posture last factored */
    lw_system_frames frames;
    double *phi, *jac, *rhs, *schur, *diag;   /* (n_c) (n_c*n_q) (n_c) (n_c*n_c) (n_c)                 */
    double *by_mass;                          /* (n_q) 1/mass                                          */
    bool    sure, null_ready;                 /* which way holds; mass_null is made                    */
    double  weak;                             /* least pivot over its row, of the fast way             */
    lw_rank rank_of;                          /* of J^T                                                */
    double *rank_work, *null, *mass_null, *small;
    int    *rank_ints;
    double *force, *bias, *q_try, *v_try, *a, *l, *l_each, *hold;
    double *hold_rows;                        /* (n_c*n_q) for reports                                 */
    double *response;                         /* n_friction x (n_q + n_c): of a and l to friction      */
    double *start_q, *start_v;
    double  moved, moved_rate;
    struct lw_reduced *reduced;               /* when it is one of one coordinate                       */
    struct lw_panel_rule *rule;               /* when time is an integral over it                       */
    lw_dynamics_report choice;                         /* what was chosen                                        */
    double *work;                             /* all of it                                             */
    lw_error *e;                              /* of the run under way                                   */
};

/* What driven input i prescribes at t: value, rate, second rate of its row, scaled. */
lw_status lw_mbs_motion(const lw_dynamics *d, int i, double t, double out[3]);

/* Rows and their derivatives at (t, q); d->phi, d->jac, d->frames. */
lw_status lw_mbs_rows(lw_dynamics *d, double t, const double *q);

/* Factor what lw_mbs_rows left.  LW_OPEN: a singular posture. */
lw_status lw_mbs_factor(lw_dynamics *d, bool sure);

/* d->rhs: what J v must be. */
lw_status lw_mbs_rate_wanted(lw_dynamics *d, double t);

/* a and l at (t, q, v), all of it.  LW_OPEN: singular. */
lw_status lw_mbs_accelerate(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                            double *power);
/* The same where factored already, with the multipliers of least norm; *unique says if they are the only ones. */
lw_status lw_mbs_solve(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                       double *power);

/* Put q, then v on the constraints (in the metric of the masses or, the sure way, by least change).  Steps of
 * q longer than `far` are refused: LW_OPEN. */
lw_status lw_mbs_project_q(lw_dynamics *d, double t, double *q, double far);
lw_status lw_mbs_project_v(lw_dynamics *d, double t, const double *q, double *v);

/* Both, after a step or for a stage. */
lw_status lw_mbs_settle(lw_dynamics *d, double t, double *q, double *v);

/* Change v by an impulse along a row g (n_q) that leaves the constraints: v += W g p; returns g W g.  Factored. */
double lw_mbs_impulse(lw_dynamics *d, const double *g, double *change);

/* After stops were touched or left: rows, pairs, rank. */
lw_status lw_mbs_arrange(lw_dynamics *d, double t, const double *q);

/* Fill a moment at (t, q, v), reactions of least norm. */
lw_status lw_mbs_moment(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m);

/* x and l of M x + J^T l = force, J x = rhs; factored.  force NULL: 0. */
lw_status lw_mbs_linear(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l);

/* Force of friction at a joint for a reaction of 1 N, out (n_q); returns its power. */
double lw_mbs_friction_direction(const lw_dynamics *d, int joint, const double *q, const double *v, double *out);

/* Change a and l, worked out without friction, to what they are with it. */
lw_status lw_mbs_friction(lw_dynamics *d, const double *q, const double *v, double *a, double *l, double *power);

#endif

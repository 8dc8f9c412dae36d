/* mbs/dynamics/dynamics_equations_internal.h - a model made ready and its equations at one moment; internal to mbs/.
 *
 *     M a + J^T l = Q,   J a = c          rows of J: system, driven inputs, stops that are rested on
 *
 * Two ways to solve them.  Fast: Cholesky's method on J M^-1 J^T over a basis of the rows, where all masses are
 * positive and those rows are well independent; large models know this way only.  By rank: a rank-revealing factorisation of J^T and the null space it
 * leaves, for massless links, near singular postures and where reactions are not unique. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_EQUATIONS_INTERNAL_H
#define LW_MBS_DYNAMICS_DYNAMICS_EQUATIONS_INTERNAL_H

#include "base/rank.h"
#include "base/sparse.h"
#include "mbs/constraints/prescribed_motion.h"
#include "mbs/constraints/system_internal.h"
#include "mbs/dynamics/dynamics.h"
#include "mbs/elastic/expand_space.h"
#include "mbs/equations/equations_planar.h"
#include "mbs/equations/equations_space.h"
#include "mbs/equations/friction.h"
#include "mbs/equations/rigid_stops_internal.h"
#include "mbs/space/space_adjust.h"

#define LW_STOP_ROW_MAX 16               /* stops that can be rested on at one time */
#define LW_MBS_ROW_MAX  (LW_SYSTEM_ROW_MAX + LW_INPUT_MAX + LW_STOP_ROW_MAX)

/* Diagonals of a rank-revealing factorisation below this, relative to the first, count as 0. */
#define LW_RANK_TOLERANCE 1e-9

/* Two kept rows that share a block: their derivatives by it in jac, and the entry of schur that they add to. */
typedef struct lw_row_pair { int row, other, to; } lw_row_pair;

/* A weld between two parts of a block adds `by` times an entry of jac_by_mass (at_row) or of by_mass to entry `to` of schur. */
typedef struct lw_weld { bool at_row; int from, to; double by; } lw_weld;

struct lw_dynamics {
    const lw_model      *given;               /* that of the caller; NULL: a spatial one */
    const lw_model      *model;               /* the same, or `expansion.model` or `rigid` */
    lw_elastic_expansion         expansion;           /* elastic links as chains of elements */
    lw_model             rigid;               /* elastic links as rigid bars */
    lw_spatial_expansion spatial_expansion;   /* the same in space */
    lw_space_adjusted    spatial_adjusted;    /* with its overconstrained linkages made to move */
    lw_spatial           spatial_rigid;
    lw_spatial           spatial_open;        /* with its clearances opened */
    bool                 elastic;
    lw_dynamics_options  o;
    lw_system            s;
    lw_forces            f;
    lw_planar            planar;
    lw_spatial_scene    *space;           /* a spatial scene; NULL: a planar one, for which the above holds */
    lw_equations         eq;                  /* what the solvers use of either */
    int     n_q, n_v, n_row, n_c;             /* n_c: rows in force; the n_row of the scene come first */
    bool    large;                            /* more parts than a linkage holds, or elastic links: no way by rank */
    int     n_velocity;                       /* links whose velocity at the start is given */
    int     n_input;
    int     n_driven, *driven, *driven_measure;      /* inputs with a motion, and what they move */
    int     n_stop;                           /* rigid stops */
    lw_rigid_stop *stop;
    int     n_resting, resting[LW_STOP_ROW_MAX];     /* stops in the order of their rows */
    int     n_friction;
    lw_friction_joint *friction;
    int    *friction_row;
    bool    ideal_friction;                   /* in some joint */
    struct lw_touching *touch;                /* places where parts touch; NULL: none are named */
    int     rank, freedom;                    /* of J in a posture that is not singular; n_v - rank */
    bool    has_zero_mass, uneven;            /* uneven: masses are farther apart than 1e4 */
    bool    rows_only;                        /* nothing but the rows is wanted, by the way of large models */
    bool    weighed;                          /* by_mass is a metric: links of a large model have no mass */
    /* rows of the fast way */
    int     n_kept, *kept, *place;            /* rows in the order of elimination; place among them, -1: left out */
    int     *unknown;                         /* (n_kept) place in schur: that of kept, unless there are welds */
    int     n_pair, n_weld;
    lw_row_pair *pair;
    lw_weld *weld;
    int     *parts;                           /* (n_block) equal parts into which blocks are divided */
    lw_cholesky schur;                        /* J M^-1 J^T over the kept rows, and welds */
    int     row_size;                         /* LW_BLOCK*eq.n_slot: derivatives of a row in jac */
    int    *row_block;                        /* (n_c*eq.n_slot): lw_mbs_blocks */
    lw_bend *bend;                            /* (eq.bend_most) scratch */
    bool    by_fronts;                        /* the factor of schur comes from the rows: for large linkages that are all driven, */
    lw_row_fronts fronts;                     /* whose rows are so weak that J M^-1 J^T loses their digits, and beside singular postures */
    int    *front_entry;                      /* of each entry of fronts: (index in jac, velocity); NULL: fronts are not prepared */
    double *front_value;
    int     rank_alone;                       /* rank of the rows of the system alone; -1: not known */
    /* at the posture last factored */
    lw_body_frame *frames;                    /* (n_body + 1) */
    double *phi, *jac, *rhs;                  /* (n_c) (n_c*row_size), in blocks by row_block; (n_c) */
    double *jac_by_mass;                      /* J M^-1, as jac */
    double *by_mass;                          /* (n_v) 1/mass */
    bool    by_rank, null_ready;              /* which way holds; mass_null is made */
    double  weak;                             /* least pivot of the fast way over its diagonal and weak_scale: how singular */
    double  weak_scale;                       /* in the posture in which the rows were chosen: this pivot in space, what different masses take of it in the
                                               * plane; 0: not known */
    lw_rank rank_of;                          /* of J^T */
    double *rank_work, *null, *mass_null, *small, *along_null;
    int    *rank_ints;
    double *force, *bias, *q_try, *v_try, *small_v, *stop_v, *a, *l, *l_each, *hold;
    double  friction_determinant, least_determinant;    /* of the friction equations, without contacts; the least of a run */
    bool    jams;                             /* in a prescribed motion friction of rigid links left no forces, or several */
    double *rub;                              /* n_friction reactions, 2*(n_v + n_c): scratch of many joints with friction */
    double *response;                         /* lw_mbs_response; NULL: not yet wanted */
    double *start_q, *start_v, *start_z, *drawn_q;   /* drawn_q: of the drawing, closed */
    double *speed_rows;                       /* (n_c + inputs) x n_v: rows that decide the velocities of the start */
    bool   *at_rest;                          /* (inputs) without a speed, which start at rest */
    double  moved;                            /* change of the start by putting it on the constraints */
    double  adjusted;                         /* greatest change of a dimension (mbs/constraints/adjust.h) */
    struct lw_reduced *reduced;               /* one coordinate, once asked for; whether the model allows it, */
    lw_status reduced_status;
    char    not_reduced[128];                 /* and if not, why */
    struct lw_panel_rule *rule;               /* of panels along the input */
    struct lw_space_tree *tree;               /* in the coordinates of the joints (mbs/space/recursive_stages.h), once asked for */
    struct lw_tangent *masses;                /* those that depend on the posture, with the rows; NULL: not yet made */
    /* lw_tangent_accelerate, which finds accelerations with these masses; by a pointer, since it uses the functions below. */
    lw_status (*accelerate)(struct lw_dynamics *d, const double *q, const double *v, const double *force, double *a, double *l);
    bool    frozen;                           /* time stands at o.from, and what is driven at `held` (n_driven): lw_mbs_freeze */
    double *held;
    double  settling;                         /* damping of all motion [1/s], frozen, statics of contacts only; 0: none */
    double  decay, frequency;                 /* at the start: fastest decay by dampers, greatest frequency by springs [1/s], where known */
    bool    decay_known;
    lw_dynamics_report choice;                /* the formulation chosen */
    double *work;                             /* memory of all arrays of numbers */
    int    *ints;                             /* of indices */
    lw_error *e;                              /* of the run under way */
};

/* Velocities beyond which a model knows no way by rank. */
#define LW_MBS_DENSE 240

/* Make d, whose model and options are set, ready: system, forces, memory, a start on the constraints. */
lw_status lw_dynamics_prepare(lw_dynamics *d, lw_error *e);
lw_status lw_dynamics_prepare_spatial(lw_dynamics *d, const lw_spatial *m, lw_error *e);

/* Parts of that: lists of joints, stops and inputs, before the special ones are found; take the equations; memory for the numbers
 * of d. */
lw_status lw_mbs_reserve_lists(lw_dynamics *d, size_t joints, size_t stops, size_t inputs, lw_error *e);
void      lw_mbs_take_equations(lw_dynamics *d, lw_equations eq);
lw_status lw_mbs_reserve(lw_dynamics *d, lw_error *e);

/* LW_E_ARG: velocities of the start that are `off` from those given, of which the greatest is `top`; a place (or NULL) and a note
 * for the text. */
lw_status lw_mbs_check_speeds(lw_error *e, const char *place, double off, double top, const char *note);

/* Values of the first-order states at the start.  LW_E_NUMERIC: one is not a number. */
lw_status lw_mbs_start_states(lw_dynamics *d, lw_error *e);

/* Value, rate and second rate at t that the motion of driven input i prescribes for its row, scaled. */
lw_status lw_mbs_motion(const lw_dynamics *d, int i, double t, double out[3]);

/* From now on time stands, and driven inputs are held where they are in q. */
void lw_mbs_freeze(lw_dynamics *d, const double *q);

/* The blocks of a row in force, at most eq.n_slot, -1 after the last; its derivatives, LW_BLOCK by each of them. */
static inline int *lw_mbs_blocks(const lw_dynamics *d, int row) { return d->row_block + row*d->eq.n_slot; }
static inline double *lw_mbs_jac(const lw_dynamics *d, int row) { return d->jac + row*d->row_size; }

/* Second derivatives of a row in force at the posture placed last, as in lw_equations, into d->bend; returns how many.  Those of
 * resting stops are left out. */
int lw_mbs_bends(const lw_dynamics *d, int row);

/* Rows and their derivatives at (t, q) into d->phi, d->jac, d->frames. */
lw_status lw_mbs_rows(lw_dynamics *d, double t, const double *q);

/* The rows of the system alone at q, into d->phi, d->jac, d->frames: for reports, once the sample is solved. */
void lw_mbs_system_rows(const lw_dynamics *d, const double *q);

/* Row r of the rows in force with its zeros, into out (n_v). */
void lw_mbs_row(const lw_dynamics *d, int r, double *out);

/* S = J M^-1 J^T over the kept rows; its factor, or that of the rows themselves where d->by_fronts.  dependent (schur.n) or NULL: whose relative
 * pivot is below the tolerance.  Returns the least relative pivot. */
#define LW_MBS_LEAST_SHARE_ROWS (LW_RANK_TOLERANCE*LW_RANK_TOLERANCE)     /* pivot of a dependent row where factors come from the rows */
void      lw_mbs_form_schur(lw_dynamics *d);
double    lw_mbs_factor_kept(lw_dynamics *d, double tolerance, bool *dependent);
void      lw_mbs_free_fronts(lw_dynamics *d);

/* Factor the rows of lw_mbs_rows.  LW_OPEN: a singular posture. */
lw_status lw_mbs_factor(lw_dynamics *d, bool by_rank);

/* out (n_c) = J x. */
void lw_mbs_times(const lw_dynamics *d, const double *x, double *out);

/* d->rhs: the value that J v must have. */
lw_status lw_mbs_rate_wanted(lw_dynamics *d, double t);
/* d->rhs: the value that J a must have at the velocities v. */
lw_status lw_mbs_acceleration_wanted(lw_dynamics *d, double t, const double *v);

/* a and l at (t, q, v): rows, factors and solution.  LW_OPEN: singular. */
lw_status lw_mbs_accelerate(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                            double *power);
/* The same where the rows are factored already. */
lw_status lw_mbs_solve(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                       double *power);

/* All is driven, with d->a and the rows at (t, q): the force of a single moving input from its power, in a singular posture too; NAN where it rests, has
 * others beside it, or joints have friction.  d->force: forces less those of inertia, which a quasi-static analysis does not count. */
double lw_mbs_drive_by_power(lw_dynamics *d, double t, const double *q, const double *v);

/* Size of the reaction of friction joint j [N] in d->l; rows are those solved. */
double lw_mbs_reaction(const lw_dynamics *d, int j);

/* Where inputs prescribe all motion, set-valued friction acts in full against the velocities v, however slow they are: choose the speeds of the
 * first n joints so.  Velocities within rounding of 0 have no friction. */
void   lw_mbs_full_friction(lw_dynamics *d, int n, const double *v);

/* Add the friction of a joint for a reaction of `size` [N], along its sense, to force (n_v); returns its power. */
double lw_mbs_rub_one(const lw_dynamics *d, const lw_friction_joint *f, const double *q, const double *v, double size, double *force);

/* Friction of all joints at (q, v), regularised, under the multipliers d->l of the rows at hand: added to force (n_v); returns its
 * power.  The slopes of that of revolute joints, pins and slides by v, the reactions kept. */
double lw_mbs_rub(lw_dynamics *d, const double *q, const double *v, double *force);
void   lw_mbs_rub_slopes(lw_dynamics *d, const double *q, const double *v, const lw_force_sink *sink);

/* Scratch of n joints with friction at once, made by the first call: n times `most` numbers, those that friction of 1 N causes;
 * lw_friction_doubles; 2*n.  NULL: out of memory. */
double *lw_mbs_response(lw_dynamics *d, int n, int most);

/* Rates of the first-order states at the z placed last.  LW_E_NUMERIC: one is not a number; it is named. */
lw_status lw_mbs_state_rates(lw_dynamics *d, double t, const double *q, const double *v, double *rate);

/* Follow the motions of all driven inputs, which leave no freedom, from the posture of the file to where they begin at
 * d->o.from and on.  s becomes the system with these inputs only; it must outlive the motion, and needs
 * lw_system_free. */
lw_input_function lw_mbs_driven_inputs;         /* the inputs with a motion, in the order of d->driven; context: d */
lw_space_path     lw_mbs_driven_path;           /* the same of a spatial model */
lw_status lw_mbs_follow(const lw_dynamics *d, lw_system *s, lw_prescribed_motion **out, lw_error *e);

/* Put q, then v on the constraints, by the least change in the metric of the masses or, by rank, of the coordinates.
 * LW_OPEN: a step of q would be longer than `longest`; velocities do not satisfy the rows, as in a singular posture. */
lw_status lw_mbs_project_q(lw_dynamics *d, double t, double *q, double longest);
lw_status lw_mbs_project_v(lw_dynamics *d, double t, double *v);

/* Both, after a step or for a stage. */
lw_status lw_mbs_settle(lw_dynamics *d, double t, double *q, double *v);

/* Change of v by the impulse g (n_v) that satisfies the constraints, W g; returns g W g.  Factored. */
double lw_mbs_impulse(lw_dynamics *d, const double *g, double *change);

/* Find rows in force, basis, pattern and rank anew, after the rows have changed or those kept became dependent. */
lw_status lw_mbs_arrange(lw_dynamics *d, double t, const double *q);

/* Fill a moment at (t, q, v): residuals and energies; a and l are those in d->a and d->l.  Rows are those at q. */
lw_status lw_mbs_measure(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m);

/* Its accelerations and multipliers, these of least norm, into d->a and d->l.  LW_OPEN: a singular posture, which has none. */
lw_status lw_mbs_moment_forces(lw_dynamics *d, const lw_moment *m);
/* Both. */
lw_status lw_mbs_moment(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m);

/* x (n_c) has values in the rows left out as dependent.  Fill in its values in the rows kept, so that J^T x = 0; factored. */
void lw_mbs_dependence(lw_dynamics *d, double *x);

/* Replace the multipliers l (n_c) by those of least norm that have the same generalised forces J^T l.  Call it after lw_mbs_rows.
 * In a singular posture, and with captured contacts, l does not change. */
void lw_mbs_least_norm(lw_dynamics *d, double *l);

/* x and l of M x + J^T l = force, J x = rhs; factored.  force NULL: 0. */
lw_status lw_mbs_linear(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l);

/* Rows of contacts beside the independent rows of the joints, kept (n): for mbs/formulations/capture.c.  All stay in the pattern;
 * those set to 0 in d->jac take no part.  lw_mbs_linear solves.  LW_OPEN: dependent rows of joints. */
lw_status lw_mbs_arrange_touch(lw_dynamics *d, const int *kept, int n);
lw_status lw_mbs_factor_touch(lw_dynamics *d);

/* Accelerations a (n_v) and multipliers l (n_c) whose J a is not quite d->rhs, corrected so that they balance the same forces; factored. */
lw_status lw_mbs_refine(lw_dynamics *d, double *a, double *l);

/* Row r times x (n_v). */
double lw_mbs_row_rate(const lw_dynamics *d, int r, const double *x);

/* The power method for the response of accelerations to a change of velocities, the fastest decay [1/s], or of places, the square of the
 * greatest frequency.  rubs: with friction.  0: none is known.  Forces alone count: geometry that turns forces of constraints does not. */
double lw_mbs_fastest(lw_dynamics *d, double t, const double *q, const double *v, bool by_v, bool rubs);

/* The fastest decay that dampers and states cause [1/s], where the state is q, v and the states are those placed last: of all dampers together
 * where derivatives are at hand, else of one.  rubs: regularised friction by the reactions d->l, too. */
double lw_mbs_fastest_decay(lw_dynamics *d, double t, const double *q, const double *v, bool rubs);

/* Do dampers make the equations stiff over the length of the run? */
bool lw_mbs_is_stiff(lw_dynamics *d);

/* Does decay (as above) keep the steps of an explicit method as short as h, from t on to the end of the run?  returns: may it, so that an implicit
 * method is worth a try, from which the run can return? */
bool lw_mbs_became_stiff(lw_dynamics *d, double t, const double *q, const double *v, double h, bool returns);

/* Do first-order states decay so fast that cvode takes less time than index1 at the tolerance? */
bool lw_mbs_states_decay(lw_dynamics *d);

/* Does regularised friction, at twice the reactions of the start, make joints that rest stiff? */
bool lw_mbs_friction_is_stiff(lw_dynamics *d);

/* Do dampers, or springs, keep the steps of an explicit method so short that an implicit one of high order is faster?  reduced: dampers
 * alone, in one coordinate.  lw_mbs_vibrates: do springs? */
bool lw_mbs_is_damped(lw_dynamics *d, bool reduced);
bool lw_mbs_vibrates(lw_dynamics *d);

/* Are the derivatives complete that the dae solver asks for (mbs/formulations/ggl.c)? */
bool lw_mbs_has_derivatives(const lw_dynamics *d);

/* "", or a note that a spatial model could be written as a planar one. */
const char *lw_mbs_is_planar(const lw_dynamics *d);

/* Is ggl faster than cvode: are dampers stiff, and are all derivatives known? */
bool lw_mbs_suits_ggl(lw_dynamics *d);

#endif

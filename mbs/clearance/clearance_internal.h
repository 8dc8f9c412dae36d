/* mbs/clearance/clearance_internal.h - scenes with clearance, their equations and runs; internal to mbs/. */
#ifndef LW_MBS_CLEARANCE_CLEARANCE_INTERNAL_H
#define LW_MBS_CLEARANCE_CLEARANCE_INTERNAL_H

#include "base/rank.h"
#include "mbs/clearance/clearance.h"
#include "mbs/clearance/clearance_tree_internal.h"
#include "mbs/constraints/system_internal.h"
#include "mbs/elastic/contact.h"
#include "mbs/equations/equations_planar.h"
#include "mbs/equations/forces.h"
#include "mbs/equations/friction.h"
#include "mbs/equations/kinks.h"
#include "mbs/equations/rigid_stops_internal.h"
#include "mbs/equations/timed.h"

/* ---- scenes and runs ----------------------------------------------------------------------------- */

typedef struct lw_journal {              /* an opened joint */
    int    joint, body[2];
    lw_vec2 arm[2];
    const lw_clearance *c;               /* of the model, or `own` */
    lw_clearance own;                    /* with the friction of the joint itself */
    double pin;                          /* radius of the pin, for friction [m] */
} lw_journal;

struct lw_clearance_scene {
    const lw_model *m;
    lw_system  s;
    lw_forces  f;
    lw_tree    tree;
    int        n_journal;
    lw_journal journal[LW_CLEARANCE_JOINT_MAX];
    int        n_friction;               /* joints with friction that depends on multipliers */
    lw_friction_joint friction[LW_JOINT_MAX];
    int        friction_journal[LW_JOINT_MAX];   /* index of a held journal, else -1 */
    int        n_stop;
    lw_rigid_stop stop[2*LW_JOINT_MAX];
    double     turns[LW_INPUT_MAX];      /* whole turns from the input's value to its motion [rad] */
};

/* Rows of constraints in force besides those of loops. */
typedef struct lw_row_choice {
    bool hold[LW_CLEARANCE_JOINT_MAX];   /* both centres at one place (or `offset` apart) */
    bool link[LW_CLEARANCE_JOINT_MAX];   /* centres at the distance of the gap */
    bool stop[LW_CLEARANCE_STOP_MAX];    /* the stop is rested on */
    bool input[LW_INPUT_MAX];            /* the input has its prescribed value */
} lw_row_choice;

typedef struct lw_play {                 /* geometry of a journal at a moment; lengths scaled */
    lw_vec2 r[2], d, rate;               /* turned arms; pin from bush, and its rate */
} lw_play;

typedef struct lw_clearance_work {
    const lw_clearance_scene *c;
    lw_clearance_options o;
    lw_row_choice rows;
    lw_rigid_stop stop[LW_CLEARANCE_STOP_MAX];       /* with their state */
    lw_tree_state state;
    lw_contact_phase phase[LW_CLEARANCE_JOINT_MAX];
    double   struck[LW_CLEARANCE_JOINT_MAX];         /* rate at which contact began [m/s] */
    double   pressed[LW_CLEARANCE_JOINT_MAX];        /* force at the end of the step before [N] */
    lw_vec2  offset[LW_CLEARANCE_JOINT_MAX], offset_rate[LW_CLEARANCE_JOINT_MAX];    /* for the start */
    int      n_u, n_c;
    double  *q, *v, *force, *series, *jac, *phi, *row;    /* of the bodies' system */
    double  *mass, *load;                /* (n_u*n_u), (n_u) */
    double  *a, *off, *wanted, *lambda;  /* rows (n_c*n_u), residuals, wanted rates, multipliers */
    double  *answer;                     /* (n_u + n_c) */
    double  *response;                   /* n_friction*(n_u + n_c): answer to friction of 1 N; lw_friction_doubles */
    int      friction_row[LW_JOINT_MAX]; /* first row of each joint with friction */
    lw_error undetermined;               /* set where friction leaves a reaction undetermined */
    double   heaviest;                   /* greatest entry of the mass matrix: scale of the rows */
    lw_rank  kkt, fit;
    lw_timed timed;                      /* where steps must end because of functions of time */
    lw_planar planar;                    /* the bodies' system as equations, for the kinks and jumps of its forces */
    lw_equations eq;
    lw_kinks *kinks;                     /* NULL: there are none */
    lw_clearance_result *r;
    double   quickest;                   /* fastest rate of the scene [1/s] */
    const double *held;                  /* NULL, or constant values of the inputs, scaled */
    bool     settled;
    bool     touching[LW_CLEARANCE_JOINT_MAX];
    double   since[LW_CLEARANCE_JOINT_MAX];              /* time at which contact was lost */
    double  *y, *rate, *memory;
    int     *ints;
} lw_clearance_work;

lw_status lw_clearance_work_make(const lw_clearance_scene *c, const lw_clearance_options *o, lw_clearance_work *w);
void      lw_clearance_work_free(lw_clearance_work *w);

/* Number of rows in force. */
int lw_clearance_count_rows(const lw_clearance_scene *c, const lw_row_choice *choice);

/* Accelerations ddu (n_u) and multipliers at (t, u, du) with the rows w->rows.  LW_E_NUMERIC: some coordinate moves
 * no mass. */
lw_status lw_clearance_accelerate(lw_clearance_work *w, double t, const double *u, const double *du, double *ddu);

/* Change of the accelerations by a generalised force g (n_u), or of velocities by an impulse, on w->rows; out (n_u). */
lw_status lw_clearance_respond(lw_clearance_work *w, double t, const double *u, const double *du, const double *g, double *out);

/* out (n_u) += row (of the bodies' system) times B. */
void lw_clearance_through_tree(const lw_clearance_work *w, const double *row, double *out);

/* Pressure on stop i, which is rested on, after an acceleration; > 0 presses. */
double lw_clearance_stop_press(const lw_clearance_work *w, int i);

/* Impacts, rests and departures of stops at (t, y = (u, du)); *flight: duration of the shortest bounce that begins [s],
 * 0: none. */
lw_status lw_clearance_strike(lw_clearance_work *w, double t, double *y, unsigned long long events, double *flight, lw_error *e);

/* Acceleration of the centres of journal i by a unit force, the larger of x and y [1/kg]; 0 where a massless link
 * leaves it undetermined. */
double lw_clearance_compliance(lw_clearance_work *w, int i, const double *u, const double *du);

/* The body whose coordinate moves the least mass, for a message. */
int lw_clearance_lightest(lw_clearance_work *w, const double *u);

/* Put u, then du on the chosen rows by the least change.  LW_OPEN: no state near. */
lw_status lw_clearance_project(lw_clearance_work *w, const lw_row_choice *choice, double t, double *u, double *du);

lw_play lw_clearance_play(const lw_clearance_work *w, int i, const double *du);

/* Force that presses pin and bush of journal i together, after an acceleration [N]. */
double lw_clearance_press(const lw_clearance_work *w, int i, const lw_play *p);

/* Reaction on the pin of a held or linked journal after an acceleration [N]. */
lw_vec2 lw_clearance_reaction(const lw_clearance_work *w, int i);

/* u, du (n_u) of the start, and the phases of contact. */
lw_status lw_clearance_begin(lw_clearance_work *w, double *u, double *du, lw_error *e);

/* Reaction on the pin of journal i without clearance, and its rate along the motion, at (t, y).  All journals are
 * held. */
lw_status lw_clearance_reaction_rate(lw_clearance_work *w, double t, const double *y, int i, lw_vec2 *f, lw_vec2 *rate);

#endif

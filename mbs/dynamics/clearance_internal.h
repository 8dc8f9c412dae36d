/* mbs/dynamics/clearance_internal.h - a linkage with some joints opened, in as few coordinates as a tree of its joints gives.
 *
 * The joints that stay are spanned by a tree of pins, sliders and welds from the ground.  A pin adds the turn of its
 * outer link since the posture, a slider its displacement, a link no joint holds its place and turn:
 *     q = q(u),   dq/dt = B du/dt,   d2q/dt2 = B d2u/dt2 + bias.
 * What closes loops beyond the tree, and driven inputs, are rows of mbs/constraints/system.h times B, with multipliers. */
#ifndef LW_MBS_DYNAMICS_CLEARANCE_INTERNAL_H
#define LW_MBS_DYNAMICS_CLEARANCE_INTERNAL_H

#include "base/rank.h"
#include "mbs/dynamics/clearance.h"
#include "mbs/dynamics/contact.h"
#include "mbs/dynamics/forces.h"
#include "mbs/constraints/system_internal.h"

/* How a body hangs in the tree. */
typedef struct lw_tree_joint {
    int     parent;                      /* body; -1: ground                                           */
    enum { LW_TREE_PIN, LW_TREE_SLIDE, LW_TREE_WELD, LW_TREE_FREE } kind;
    int     joint;
    lw_vec2 arm[2];                      /* of the joint on the parent and on the body                  */
    double  sign;                        /* slide: +1 where the body is link[1], else -1                */
    int     coordinate;                  /* its own; -1: a weld.  Free: the first of three              */
    int     turn;                        /* the coordinate that is its turn; -1: it does not turn        */
    int     n_path, path[LW_SYSTEM_Q_MAX];   /* coordinates that move it                                */
} lw_tree_joint;

typedef struct lw_tree {
    const lw_system *s;
    int n_u;
    int n_body, order[LW_LINK_MAX];      /* bodies, parents first                                      */
    lw_tree_joint branch[LW_LINK_MAX];       /* of body b                                                  */
    int n_close, close[LW_JOINT_MAX];    /* joints that are neither in the tree nor opened              */
    int n_row;                           /* their rows                                                 */
} lw_tree;

/* A moment of the tree; b[body*n_u + k] is the column of coordinate k for the body's place. */
typedef struct lw_tree_state {
    lw_vec2  at[LW_LINK_MAX], dir[LW_LINK_MAX];      /* of body b at b + 1; ground at 0                */
    double   turn[LW_LINK_MAX], spin[LW_LINK_MAX];
    lw_vec2  bias[LW_LINK_MAX];
    lw_vec2 *b;
} lw_tree_state;

/* (n_joint) opened: joints to leave out; apart: joints to keep as rows with multipliers, nothing hangs by them. */
void lw_tree_make(const lw_system *s, const bool *opened, const bool *apart, lw_tree *t);

/* Everything of s at (u, du); du NULL: places and columns only. */
void lw_tree_place(const lw_tree *t, const double *u, const double *du, lw_tree_state *s);

/* u (n_u) of body coordinates q, and du of v where du is not NULL. */
void lw_tree_read(const lw_tree *t, const double *q, const double *v, double *u, double *du);

/* Body coordinates q (n_q) of a state, velocities v where v is not NULL (then du is wanted too). */
void lw_tree_write(const lw_tree *t, const lw_tree_state *s, const double *du, double *q, double *v);

/* A point fixed to body (-1: ground), r its arm turned: velocity, and what a force f on it does to Q (n_u). */
lw_vec2 lw_tree_velocity(const lw_tree *t, const lw_tree_state *s, int body, lw_vec2 r, const double *du);
void    lw_tree_push(const lw_tree *t, const lw_tree_state *s, int body, lw_vec2 r, lw_vec2 f, double torque,
                     double *force);
/* ---- scenes and runs ----------------------------------------------------------------------------- */

typedef struct lw_journal {              /* an opened joint                                            */
    int    joint, body[2];
    lw_vec2 arm[2];
    const lw_clearance *c;               /* that of the model, or `own`                                 */
    lw_clearance own;                    /* with the friction the joint itself has                      */
    double pin;                          /* radius of the pin, for friction [m]                         */
} lw_journal;

typedef struct lw_rough {                /* a joint with friction: rows, whose multipliers press        */
    int    joint, journal;               /* journal: held one, else -1                                  */
    double coefficient, speed, arm;
} lw_rough;

typedef struct lw_rigid {                /* a rigid stop                                               */
    int    joint;
    double sign, limit;                  /* gap = sign (measure - limit), scaled                        */
    double restitution;
} lw_rigid;

struct lw_clearance_scene {
    const lw_model *m;
    lw_system  s;
    lw_forces  f;
    lw_tree    tree;
    int        n_journal;
    lw_journal journal[LW_CLEARANCE_JOINT_MAX];
    int        n_rough, n_rigid;
    lw_rough   rough[LW_JOINT_MAX];
    lw_rigid   rigid[LW_CLEARANCE_STOP_MAX];
    double     turns[LW_INPUT_MAX];      /* whole turns between an input's value and its motion [rad]    */
};

/* Which rows of constraints hold besides those of loops. */
typedef struct lw_row_choice {
    bool hold[LW_CLEARANCE_JOINT_MAX];   /* both centres at one place (or `offset` apart)               */
    bool link[LW_CLEARANCE_JOINT_MAX];   /* the gap apart                                              */
    bool stop[LW_CLEARANCE_STOP_MAX];    /* rests on it                                                */
    bool input[LW_INPUT_MAX];            /* of this value                                              */
} lw_row_choice;

typedef struct lw_play {                 /* geometry of a journal at a moment; lengths scaled            */
    lw_vec2 r[2], d, rate;               /* turned arms; pin from bush, and its rate                    */
} lw_play;

typedef struct lw_clearance_work {
    const lw_clearance_scene *c;
    lw_clearance_options o;
    lw_row_choice rows;
    lw_tree_state state;
    lw_contact_phase phase[LW_CLEARANCE_JOINT_MAX];
    double   struck[LW_CLEARANCE_JOINT_MAX];         /* speed of the last touch [m/s]                   */
    lw_vec2  offset[LW_CLEARANCE_JOINT_MAX], offset_rate[LW_CLEARANCE_JOINT_MAX];    /* wanted at a start */
    int      n_u, n_c;
    double  *q, *v, *force, *series, *jac, *phi, *row;    /* of the bodies' system                      */
    double  *mass, *load;                /* (n_u*n_u), (n_u)                                            */
    double  *a, *off, *wanted, *lambda;  /* rows (n_c*n_u), left over, wanted rates, multipliers          */
    double  *answer;                     /* (n_u + n_c)                                                */
    double  *response;                   /* (n_rough*(n_u + n_c)) of the same to friction of 1 N        */
    int      rough_row[LW_JOINT_MAX];    /* first row of each joint with friction                      */
    int      undetermined;               /* joint with friction whose reaction cannot be found; -1: none */
    double   heaviest;                   /* entry of the mass matrix, scale of the rows                 */
    lw_rank  kkt, fit;
    lw_clearance_result *r;
    double   quickest;                   /* rate of the scene [1/s]                                    */
    const double *held;                  /* NULL, or what the rows of inputs keep for ever, as they count, scaled */
    bool     settled;
    bool     touching[LW_CLEARANCE_JOINT_MAX];
    double   since[LW_CLEARANCE_JOINT_MAX];              /* when contact was lost                       */
    double  *y, *rate, *memory;
    int     *ints;
} lw_clearance_work;

lw_status lw_clearance_work_make(const lw_clearance_scene *c, const lw_clearance_options *o, lw_clearance_work *w);
void      lw_clearance_work_free(lw_clearance_work *w);

/* A scene without journals: the plain linkage in tree coordinates.  Not for lw_clearance_run. */
void lw_clearance_plain(const lw_forces *f, lw_clearance_scene *c);

/* Number of rows of a choice. */
int lw_clearance_count_rows(const lw_clearance_scene *c, const lw_row_choice *choice);

/* Accelerations ddu (n_u) and the multipliers of w->rows at (t, u, du).  LW_E_NUMERIC: no mass moves with some
 * coordinate. */
lw_status lw_clearance_accelerate(lw_clearance_work *w, double t, const double *u, const double *du, double *ddu);

/* What a generalised force g (n_u) changes accelerations by, and an impulse speeds, on w->rows, out (n_u). */
lw_status lw_clearance_respond(lw_clearance_work *w, double t, const double *u, const double *du, const double *g,
                               double *out);

/* Friction of the scene's rough joints into ddu and the multipliers, after a solve with rows.  LW_E_NUMERIC: it leaves
 * reactions undetermined; w->undetermined says where. */
lw_status lw_clearance_friction(lw_clearance_work *w, const double *du, double *ddu);

/* out (n_u) += row (of the bodies' system) times B. */
void lw_clearance_through_tree(const lw_clearance_work *w, const double *row, double *out);

/* A solve more of the factored equations: b (n_u + n_c) overwritten, x. */
void lw_clearance_solve_again(lw_clearance_work *w, double *b, double *x);

/* ---- rigid stops (clearance_stop.c) --------------------------------------------------------------- */

/* Rows of the stops that are rested on, from row *n. */
void lw_clearance_stop_rows(lw_clearance_work *w, const lw_row_choice *choice, bool series, int *n);

/* Gap of stop i, scaled; what presses on one that is rested on.  The state is placed and w->q written; for the second
 * also accelerated. */
double lw_clearance_gap(lw_clearance_work *w, int i);
double lw_clearance_stop_press(const lw_clearance_work *w, int i);

/* Impacts, rests and departures of stops at (t, u, du); flight: of the shortest bounce that begins [s], 0: none. */
lw_status lw_clearance_strike(lw_clearance_work *w, double t, double *u, double *du, double *flight, lw_error *e);

/* What a unit force on the centres of journal i accelerates them by, the larger of x and y [1/kg]; 0 where a link
 * without mass does not let one say. */
double lw_clearance_compliance(lw_clearance_work *w, int i, const double *u, const double *du);

/* The body whose coordinate moves least mass, for a message. */
int lw_clearance_lightest(lw_clearance_work *w, const double *u);

/* Put u, then du on the rows of a choice by the least change. LW_OPEN: not near. */
lw_status lw_clearance_project(lw_clearance_work *w, const lw_row_choice *choice, double t, double *u, double *du);

lw_play lw_clearance_play(const lw_clearance_work *w, int i, const double *du);

/* Force that presses pin and bush of journal i together, after an acceleration [N]. */
double lw_clearance_press(const lw_clearance_work *w, int i, const lw_play *p);

/* Reaction on the pin of a held or linked journal after an acceleration [N]. */
lw_vec2 lw_clearance_reaction(const lw_clearance_work *w, int i);

/* u, du (n_u) of the start, and the phases. */
lw_status lw_clearance_begin(lw_clearance_work *w, double *u, double *du, lw_error *e);

/* Reaction on the pin of journal i without clearance, and its rate along the motion, at (t, y); every journal held. */
lw_status lw_clearance_reaction_rate(lw_clearance_work *w, double t, const double *y, int i, lw_vec2 *f,
                                     lw_vec2 *rate);

#endif

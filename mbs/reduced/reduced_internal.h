/* mbs/reduced/reduced_internal.h - one freedom, one coordinate: the motion of a rigid linkage of dyads along its
 * motion curve; internal to mbs/.
 *
 *     M(s) s'' + M'(s)/2 s'^2 = Q(s, s'),     M = sum of m |c'|^2 + I phi'^2,   Q = sum of F.c' + T phi'
 *
 * (primes of c and phi: by the input s of the plan).  With p = sqrt(M) s', so that p^2/2 is the kinetic energy, this is
 *     s' = p/sqrt(M),   p' = Q/sqrt(M)
 * and M' is not needed: p p' = s' (M s'' + M'/2 s'^2).  Everything comes from the closed forms of the plan and their
 * first derivatives; nothing is solved.  At a change point (parallelograms) two assembly modes of a dyad meet and
 * part again: velocities continue, so the mode changes.  Near such a point, where the closed forms lose digits, the
 * angles of the dyad are polynomials through values on both sides (bridges). */
#ifndef LW_MBS_REDUCED_REDUCED_INTERNAL_H
#define LW_MBS_REDUCED_REDUCED_INTERNAL_H

#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/plan/steps_internal.h"

typedef struct lw_reduced lw_reduced;

#define LW_CHANGE_POINT_MAX   32
#define LW_REDUCED_LOAD_MAX   64       /* springs; forces: models with more take another formulation */
#define LW_BRIDGE_SIZE 12             /* coefficients of a polynomial over a change point */

/* Angles of the links of a dyad near a change point: polynomials of (input - at)/reach. */
typedef struct lw_bridge { int dyad; double c[2][LW_BRIDGE_SIZE]; } lw_bridge;

/* A change point and the bridges of the dyads that change there. */
typedef struct lw_change_point {
    double    at, reach;
    int       n_bridge;
    lw_bridge bridge[LW_DYAD_MAX];
} lw_change_point;

/* A body with mass.  Bodies on ground pins come first; their inertia is about the pin. */
typedef struct lw_mass_point { int origin, dir; lw_vec2 arm; double mass, inertia; lw_vec2 weight; } lw_mass_point;
typedef struct lw_end_point { int origin, dir, body; lw_vec2 arm; } lw_end_point;      /* origin, body -1: on ground */

/* A joint between body[0] and body[1] (-1: ground).  dir: registers of their directions; point: its place on each;
 * along: direction of a slide in the frame of body[0]; sign: of its measure (mbs/constraints/system.h). */
typedef struct lw_reduced_joint {
    bool   slides;
    int    body[2], dir[2];
    double sign;
    lw_end_point point[2];
    int    pin;                               /* register of a pin, where friction needs it; else -1 */
    lw_vec2 along;
} lw_reduced_joint;

/* Force and moment about the origin of the ground frame. */
typedef struct lw_wrench { lw_vec2 f; double m; } lw_wrench;

/* Turns of the bodies since the posture and their rates by the input, where they were counted last: at input `at`. */
typedef struct lw_turn_count { double at, turn[LW_LINK_MAX], rate[LW_LINK_MAX]; } lw_turn_count;

struct lw_reduced {
    lw_linkage linkage;
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_DYAD_MAX];
    int        n_step;                        /* steps that move and that something depends on */
    lw_dyad_step step[LW_STEP_MAX];
    lw_reg1    reg[LW_REG_MAX];               /* of the last evaluation; those of ground keep their values */
    double     known;                         /* input of the registers; NAN: none */
    double     first, start, scale;           /* input at the start, in the posture; unit of the coordinate */
    double     sense;                           /* -1: the measure of the input joint falls with s */
    lw_vec2    z0, turn;                      /* ground frame in the plane */
    int        n_mass, n_pivot;
    lw_mass_point mass[LW_LINK_MAX];
    lw_end_point  centre[LW_LINK_MAX];        /* of body b */
    lw_end_point  end[LW_REDUCED_LOAD_MAX][2], point[LW_REDUCED_LOAD_MAX];
    double     dir0[LW_LINK_MAX];             /* angle of each body's link in the posture */
    const lw_model *model;
    const lw_dynamics *dynamics;
    /* Loads that depend on the whole state are found in the coordinates of the bodies. */
    bool       general, counts_turns;         /* counts_turns: loads depend on whole turns of the links */
    bool       constant_loads;                /* loads at rest do not depend on time */
    double     *q, *v, *force;                /* (n_q) scratch */
    lw_turn_count count;
    lw_reduced_joint joint[LW_JOINT_MAX];     /* those of the linkage */
    struct lw_reduced_friction *friction;     /* NULL: none */
    lw_wrench  load[LW_LINK_MAX];             /* of the bodies, and their centres, where there is friction */
    lw_reg1    at[LW_LINK_MAX];
    /* Change points: change[i] lies between pieces i and i + 1, which have their own modes.  period 0: none. */
    int        n_change;
    lw_change_point   change[LW_CHANGE_POINT_MAX];
    double     piece_mode[LW_CHANGE_POINT_MAX + 1][LW_DYAD_MAX];
    double     low, high, period;             /* range scanned */
};

/* Makes d->reduced ready, once.  LW_E_KIND: the model is not of this kind, for the reason in d->not_reduced. */
lw_status lw_reduced_able(lw_dynamics *d);

/* The coordinate at the start and p = sqrt(M) s' there, by the velocities in y = (q, v) of the bodies. */
lw_status lw_reduced_start(lw_reduced *r, const lw_dynamics *d, const double *y, double *s, double *p);

/* A mass M so many times the least one means that a dead point is near.  There the links move like the square root of
 * the distance to it, which magnifies rounding and the allowed error of the coordinate too much. */
#define LW_REDUCED_TURNING_BACK 100

/* Evaluate all registers at an input.  LW_OPEN: the linkage does not close, or nearly not. */
lw_status lw_reduced_registers(lw_reduced *r, double input);

/* The same with given modes and bridges.  *margin: least of all dyads; margin_of (n_dyad), unless NULL: of each,
 * 0 where its assembly modes meet. */
void lw_reduced_plain(lw_reduced *r, const double *mode, const lw_change_point *bridge, double input, double *margin_of, double *margin);

/* Find the change points, from an input at which the modes are those of r->mode.  LW_E_KIND: at one of them the
 * assembly modes come so near each other that the closed form cannot tell which of them goes on.  LW_E_MEMORY. */
lw_status lw_reduced_change_points(lw_reduced *r, double from);

/* s' and p' at (t, s, p), p = sqrt(M) s', and the power of the forces without potential. */
lw_status lw_reduced_rate(lw_reduced *r, double t, double s, double p, double *ds, double *dp, double *power);
lw_status lw_reduced_mass(lw_reduced *r, double s, double *mass);

/* ---- friction.c: Coulomb friction ----------------------------------------------------------------
 *
 * Friction is set-valued: mu times the reaction against the motion, and at rest any force up to that.  Sliding has a
 * sense, +1 or -1, that of s'.  A sense between them is the part of the friction that acts at rest.  Friction of joints with a "speed" is a
 * smooth function of their rate, and has no sense. */

/* As lw_dyad, of bodies.  before: those that its outer joints hold it to; side: of a joint, 1 where the dyad's first link, or the one at that
 * outer joint, is body[1] of it, else -1; slot: of a joint among those with friction, n: it has none. */
typedef struct lw_reduced_group { int body[2], before[2], joint[3], slot[3]; double side[3]; bool pins; } lw_reduced_group;

/* Reversals: inputs at which the rate of a joint with friction changes its sign, by cells of the input.  They are found
 * when the motion first comes near, and kept; for a pin, all turns share the cells. */
#define LW_REVERSAL_CELLS 512
#define LW_REVERSAL_MOST  6
typedef struct lw_reversal_cell { long number; int n; double at[LW_REVERSAL_MOST]; } lw_reversal_cell;

/* Reactions of joints with friction at an earlier evaluation. */
#define LW_REACTION_PAST 4
typedef struct lw_reaction_past { double t, x[LW_JOINT_MAX], y[LW_JOINT_MAX]; } lw_reaction_past;

typedef struct lw_reduced_friction {
    int    n, joint[LW_JOINT_MAX];            /* joints with friction */
    bool   set_valued;                        /* that of one of them at least */
    int    n_slide, slide[LW_JOINT_MAX];      /* those of them that are slides */
    double arm[LW_JOINT_MAX];                 /* coefficient times radius of a pin [m]; coefficient of a slide */
    double side[LW_JOINT_MAX];                /* sign of the joint's rate by the input; 0: the joint never moves, or its friction is smooth */
    double size[LW_JOINT_MAX];                /* reactions last found [N] */
    double x[LW_JOINT_MAX], y[LW_JOINT_MAX];  /* the same as vectors; of slides (x, 0), x across the slide */
    double feel[LW_JOINT_MAX];                /* greatest change of p' with the size of a reaction */
    double press[LW_JOINT_MAX];               /* that sign while the linkage slides on: the size of a reaction of a slide
                                               * has a kink where it changes; 0: pins, or not known */
    double part[LW_JOINT_MAX];                /* of the last evaluation: sense side arm, or that of the rate */
    int    n_past, newest;
    lw_reaction_past past[LW_REACTION_PAST];  /* since the parts changed */
    double sense, tolerance;
    bool   undetermined;                      /* the last failure: no reactions satisfy the equations */
    int    n_group, input_joint, input_body, input_slot;
    lw_reduced_group group[LW_DYAD_MAX];
    lw_reversal_cell cell[LW_REVERSAL_CELLS];
    lw_vec2 response[LW_JOINT_MAX*LW_JOINT_MAX];     /* scratch */
    double work[LW_JOINT_MAX*(LW_JOINT_MAX + 4)];
} lw_reduced_friction;

/* Friction at the registers and t: adds its force to *q and gives its power.  mass: M.  LW_OPEN: the reactions are not
 * determined. */
lw_status lw_reduced_friction_add(lw_reduced *r, double t, double ds, double mass, double *q, double *power);

/* Let the next evaluation at t begin with these reactions. */
void lw_reduced_friction_expect(lw_reduced_friction *f, double t, const lw_vec2 *reaction);

/* Sides of all joints from the rates at an input, with the direction of motion at rates that are 0. */
lw_status lw_reduced_friction_sides(lw_reduced *r, double input, double direction);

/* The next reversal from an input in a direction, or an input before it at which to look again; infinite: all friction is smooth. */
lw_status lw_reduced_next_reversal(lw_reduced *r, double input, double direction, double *next);

/* Potential at the registers [J], up to a constant. */
double lw_reduced_potential(const lw_reduced *r, double s);

/* Count the turns of the links from the registers on.  Call it at the start and after steps. */
void lw_reduced_count_turns(lw_reduced *r);

/* Value of a joint's measure at the registers, and its rate by the input [rad] or [m]. */
double lw_reduced_joint_rate(const lw_reduced *r, int joint);

/* System coordinates and velocities of every body at the registers and s'; turns are taken near those in q. */
void lw_reduced_state(const lw_reduced *r, const lw_dynamics *d, double ds, double *q, double *v);

#endif

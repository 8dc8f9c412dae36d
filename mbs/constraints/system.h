/* mbs/constraints/system.h - the equations of any planar linkage in the coordinates of its moving links.
 *
 *     q      3 numbers a moving link: place x, y of its reference point, turn phi since the drawn
 *            posture [rad].  Lengths are counted from `origin` and in multiples of `unit` [m].
 *     Phi(q) = 0    two rows a pin or slider, one a pin in a slot or a gear, three a fixed joint; then one a
 *                   tied input, which is no input here but a condition: h_tied = ratio h_first
 *     h_i(q)        what input i counts: turn of a pin, displacement of a slider, 0 in the posture
 *
 * Series.  Along any curve q(s) = sum of q_k s^k the rows have a series too; its coefficient k is
 * J q_k + (terms of q_0 .. q_{k-1}).  So one routine serves velocity, acceleration, jerk and predictors
 * of any order: put 0 for q_k, read off the rest, solve J q_k = -rest.
 *
 * Made once, const afterwards; evaluation allocates nothing.  No code of the plan (mbs/plan/plan.h) is used:
 * the two are each other's second opinion. */
#ifndef LW_MBS_CONSTRAINTS_SYSTEM_H
#define LW_MBS_CONSTRAINTS_SYSTEM_H

#include "grammar/expression.h"
#include "grammar/linkage.h"

#define LW_SYSTEM_ORDER_MAX LW_SERIES_ORDER_MAX
#define LW_SYSTEM_Q_MAX   (3*(LW_LINK_MAX - 1))
#define LW_SYSTEM_ROW_MAX (3*LW_JOINT_MAX + LW_INPUT_MAX)
#define LW_SYSTEM_ROW_BODIES 4             /* bodies whose coordinates a row knows, at most           */

/* One row: which joint, and what it says ("x", "y", "across", "turn", "ratio", "tie"). */
typedef struct lw_system_row { int joint; const char *what; } lw_system_row;

/* What an input (or any joint) counts, and its row of derivatives. */
typedef struct lw_system_joint {
    lw_joint_kind kind;
    int     body[2];                       /* of its two links; -1: ground                            */
    int     carrier;                       /* g: body that carries both centres; -1: ground           */
    double  sign;                          /* of what it counts: -1 for a pin whose link[1] is ground */
    lw_vec2 arm[2];                        /* the joint's point in the frames of the two links; g: in */
                                           /* that of the carrier                                     */
    lw_vec2 along;                         /* t, p: direction of the line, in the frame of link[0]    */
    double  ratio;                         /* g: of turns, or [unit/rad] where link[1] is a rack      */
    int     row;                           /* its first row                                           */
    int     slider[2];                     /* g: the joint in which that side slides on the carrier,  */
                                           /* a rack; -1: it turns                                    */
    double  slider_sign[2];                /* g: +1 where the rack is link[1] of that joint, else -1  */
} lw_system_joint;

typedef struct lw_system {
    int     n_body, n_q, n_row, n_joint, n_tracer;
    int     n_input, n_tie;                /* inputs that move by themselves; tied ones               */
    int     link[LW_LINK_MAX];             /* of body b                                               */
    int     body[LW_LINK_MAX];             /* of link l; -1: ground                                   */
    lw_vec2 origin;                        /* [m]                                                     */
    double  unit;                          /* [m]                                                     */
    lw_vec2 reference[LW_LINK_MAX];        /* of body b, in the posture, scaled                       */
    lw_system_joint joint[LW_JOINT_MAX];
    lw_system_row   row[LW_SYSTEM_ROW_MAX];
    int     input_joint[LW_INPUT_MAX];     /* (n_input + n_tie)                                       */
    double  input_value[LW_INPUT_MAX];     /* what the input counts in the posture                    */
    double  tie[LW_INPUT_MAX];             /* (n_tie) ratios to the first input, of turns or units     */
    int     tie_row;                       /* the first of their rows                                 */
    int     tracer_body[LW_TRACER_MAX];
    lw_vec2 tracer_arm[LW_TRACER_MAX];
} lw_system;

/* reference (n_link), [m]: reference points of the links, NULL: the middle of each link's joints.
 * unit 0: the size of the posture (the farthest joint from their middle; where all are at one point the distance of a
 * tracer, or 1 m), and origin its middle; else origin (0, 0).  LW_E_KIND: a gear without carrier (lw_linkage_gear);
 * failures of lw_linkage_check. */
lw_status lw_system_make(const lw_linkage *k, const lw_vec2 *reference, double unit, lw_system *s,
                         lw_error *e);

/* q (n_q) of the drawn posture. */
void lw_system_posture(const lw_system *s, double *q);

/* Phi (n_row), and its derivatives jac[row*n_q + i] when given (zeroed first). */
void lw_system_rows(const lw_system *s, const double *q, double *phi, double *jac);

/* What the turn (or way) of side 0, 1 is multiplied by in the row of gear j, which is their sum: divided so that
 * rounding of the row is that of a turn, whatever the ratio. */
double lw_system_gear_factor(const lw_system_joint *j, int side);

/* The bodies whose coordinates a row knows, or what joint j counts, each once, -1 behind the last: those that are
 * joined; of a gear those that turn or slide on each other, four where racks are welded to what they are. */
void lw_system_row_bodies(const lw_system *s, int row, int body[LW_SYSTEM_ROW_BODIES]);
void lw_system_joint_bodies(const lw_system *s, int j, int body[LW_SYSTEM_ROW_BODIES]);

/* Series of the rows, phi[k*n_row + r], from that of the coordinates, q[k*n_q + i], k = 0 .. order. */
void lw_system_series(const lw_system *s, int order, const double *q, double *phi);

/* What joint j counts (turn or displacement from the posture, in rad or units), and its row of
 * derivatives (n_q, zeroed first) when given; and its series.  Sliders and slots: link[1] against link[0]
 * along the line; pins too, but where link[1] is the ground, link[0] against it, as an input counts.
 * Gears and welds count nothing: 0. */
double lw_system_measure(const lw_system *s, int j, const double *q, double *row);
void   lw_system_measure_series(const lw_system *s, int j, int order, const double *q, double *out);

/* A point fixed to a body (-1: ground; arm: in its frame, scaled): place [m], and its series (coefficients:
 * derivatives over k!). */
lw_vec2 lw_system_point(const lw_system *s, int body, lw_vec2 arm, const double *q);
void    lw_system_point_series(const lw_system *s, int body, lw_vec2 arm, int order, const double *q,
                               lw_vec2 *out);

/* Where a point of the posture [m] sits on a link: body and arm. */
lw_vec2 lw_system_arm(const lw_system *s, int body, lw_vec2 at);

/* Put posture q into a copy of the linkage: joints (sliders: their point on link[0]; slots: the pin), slide
 * lines, tracers, input values. */
void lw_system_write(const lw_system *s, const double *q, lw_linkage *k);

#endif

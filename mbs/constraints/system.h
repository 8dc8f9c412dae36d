/* mbs/constraints/system.h - the equations of any planar linkage in the coordinates of its moving links.
 *
 *     q      3 numbers for each moving link: position x, y of its reference point, rotation phi since the drawn
 *            posture [rad].  Lengths are relative to `origin` and in multiples of `unit` [m].
 *     Phi(q) = 0    constraint rows: two for a pin or slider, one for a pin in a slot or a gear, three for a fixed
 *                   joint, and one for a tied input, which is a condition here: h_tied = ratio h_first
 *     h_i(q)        value of input i: rotation of a pin, displacement of a slider, 0 in the posture
 *
 * Series.  Along a curve q(s) = sum of q_k s^k the rows have a series too.  Its coefficient k is
 * J q_k + (terms of q_0 .. q_{k-1}).  So one routine serves velocity, acceleration, jerk and predictors of any order:
 * evaluate with q_k = 0, and solve J q_k = -result.
 *
 * A system is constant after it is made, and evaluation does not allocate.  It shares no code with the plan
 * (mbs/plan/plan.h), so that each can verify the other. */
#ifndef LW_MBS_CONSTRAINTS_SYSTEM_H
#define LW_MBS_CONSTRAINTS_SYSTEM_H

#include "grammar/functions/expression.h"
#include "grammar/linkage/assembly.h"

#define LW_SYSTEM_ORDER_MAX LW_SERIES_ORDER_MAX
#define LW_SYSTEM_Q_MAX   (3*(LW_LINK_MAX - 1))
#define LW_SYSTEM_ROW_MAX (3*LW_JOINT_MAX + LW_INPUT_MAX)
#define LW_SYSTEM_ROW_BODIES 4             /* most bodies whose coordinates a row can contain         */

/* One row: its joint and its meaning ("x", "y", "across", "turn", "ratio", "tie"). */
typedef struct lw_system_row { int joint; const char *what; } lw_system_row;

/* A joint as the equations see it. */
typedef struct lw_system_joint {
    lw_joint_kind kind;
    int     body[2];                       /* of its two links; -1: ground                            */
    int     carrier;                       /* g: body that carries both centres; -1: ground           */
    double  sign;                          /* of its displacement: -1 for a pin whose link[1] is ground */
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
    int     n_input, n_tie;                /* independent inputs; tied inputs                         */
    int    *link;                          /* of body b                                               */
    int    *body;                          /* of link l; -1: ground                                   */
    lw_vec2 origin;                        /* [m]                                                     */
    double  unit;                          /* [m]                                                     */
    lw_vec2 *reference;                    /* of body b, in the posture, scaled                       */
    lw_system_joint *joint;
    lw_system_row   *row;
    int    *input_joint;                   /* (n_input + n_tie)                                       */
    double *input_value;                   /* value of the input in the posture                       */
    double *tie;                           /* (n_tie) ratios to the first input, of turns or units     */
    int     tie_row;                       /* the first of their rows                                 */
    int    *tracer_body;
    lw_vec2 *tracer_arm;
    void   *memory;                        /* of all arrays                                           */
} lw_system;

/* reference (n_link), [m]: reference points of the links; NULL: the middle of each link's joints.  unit 0: the size
 * of the posture (largest distance of a joint from the middle of the joints; if all joints are at one point, the
 * distance of a tracer, or 1 m), with the origin in that middle; otherwise the origin is (0, 0).  LW_E_KIND: a gear
 * without carrier (lw_linkage_gear).  Fails as lw_linkage_check.  s needs lw_system_free, after a failure too. */
lw_status lw_system_make(const lw_linkage *linkage, const lw_vec2 *reference, double unit, lw_system *s, lw_error *e);
void      lw_system_free(lw_system *s);

/* The same of an assembly.  Code that holds arrays of LW_SYSTEM_Q_MAX numbers takes systems of linkages only. */
lw_status lw_system_assemble(const lw_assembly *assembly, const lw_vec2 *reference, double unit, lw_system *s, lw_error *e);

/* The same equations with other inputs: `inputs` (n), indices of those of `from`, and all that are tied.  *s needs
 * lw_system_free. */
lw_status lw_system_choose_inputs(const lw_system *from, const int *inputs, int n, lw_system *s);

/* q (n_q) of the drawn posture. */
void lw_system_posture(const lw_system *s, double *q);

/* For systems of linkages: Phi (n_row), and its derivatives jac[row*n_q + i] when given (zeroed first). */
void lw_system_rows(const lw_system *s, const double *q, double *phi, double *jac);

/* Factor of the rotation (or displacement) of side 0 or 1 in the row of gear j, which is the sum of both.  The
 * factors are scaled so that the rounding error of the row is that of an angle for any ratio. */
double lw_system_gear_factor(const lw_system_joint *j, int side);

/* The bodies whose coordinates a row, or the displacement of joint j, contains; each once, -1 after the last.  For a
 * gear these are the bodies that turn or slide on each other, up to four with welded racks. */
void lw_system_row_bodies(const lw_system *s, int row, int body[LW_SYSTEM_ROW_BODIES]);
void lw_system_joint_bodies(const lw_system *s, int j, int body[LW_SYSTEM_ROW_BODIES]);

/* Series of the rows, phi[k*n_row + r], from that of the coordinates, q[k*n_q + i], k = 0 .. order. */
void lw_system_series(const lw_system *s, int order, const double *q, double *phi);

/* Displacement of joint j since the posture (rotation in rad, or displacement in units), and its derivatives (n_q,
 * zeroed first) if row is not NULL; and its series.  It is that of link[1] relative to link[0], for a slider or slot
 * along the line; for a pin whose link[1] is the ground, that of link[0], as for an input.  0 for gears and welds. */
double lw_system_measure(const lw_system *s, int j, const double *q, double *row);
void   lw_system_measure_series(const lw_system *s, int j, int order, const double *q, double *out);

/* Unit of that displacement: 1 [rad] for a pin, s->unit [m] for others. */
static inline double lw_system_joint_unit(const lw_system *s, int joint)
{
    return lw_joint_turns(s->joint[joint].kind) ? 1.0 : s->unit;
}

/* Position [m] of a point fixed to a body (-1: ground; arm: in its frame, scaled), and its series (coefficient k is the
 * derivative divided by k!). */
lw_vec2 lw_system_point(const lw_system *s, int body, lw_vec2 arm, const double *q);
void    lw_system_point_series(const lw_system *s, int body, lw_vec2 arm, int order, const double *q, lw_vec2 *out);

/* The arm on a body of a point `at` [m] of the posture. */
lw_vec2 lw_system_arm(const lw_system *s, int body, lw_vec2 at);

/* Write posture q into a copy of the linkage: joints (slider: its point on link[0]; slot: the pin), slide lines,
 * tracers, input values. */
void lw_system_write(const lw_system *s, const double *q, lw_linkage *linkage);

#endif

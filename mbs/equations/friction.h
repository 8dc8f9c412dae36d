/* mbs/equations/friction.h - Coulomb friction, regularised, which depends on reactions that depend on it.
 *
 * Friction along the measure of joint j is -mu N_j tanh(v/speed), with N_j the size of its reaction R_j [N].
 * Accelerations and reactions are affine in the N,
 *     R_j = R0_j + sum over k of N_k R_jk,
 * so N_j = |R_j| is a dense system, one equation a joint with friction, solved by Newton's method.  Its matrix is I
 * without friction; where its determinant reaches 0 as joint after joint gets its friction, rigid bodies with friction leave
 * the reactions undetermined (Painleve 1895). */
#ifndef LW_MBS_EQUATIONS_FRICTION_H
#define LW_MBS_EQUATIONS_FRICTION_H

#include "mbs/equations/forces.h"

/* A joint with friction, or a contact that slips (joint -1).  lever_arm: radius of the pin [m]; 1 for a joint that slides.  ideal: the model wants
 * set-valued friction; a formulation that knows it sets `held`, and `part`, the part of the friction that acts and its
 * sense. */
typedef struct lw_friction_joint {
    int    joint;
    double coefficient, speed, lever_arm;
    bool   ideal, held;
    double part;
} lw_friction_joint;

/* The friction that a model gives joint j. */
lw_friction_joint lw_friction_joint_of(const lw_model *m, int j);

/* Force [N] or torque [N m] along the measure of the joint for a reaction of 1 N, at the rate of the measure [rad/s] or
 * [m/s]. */
double lw_friction_push(const lw_friction_joint *f, double rate);

/* The least speed of n joints with friction, in units of length a second; infinite where n is 0. */
double lw_friction_least_slip(int n, const lw_friction_joint *f, double unit);

/* Adds the generalised force of the friction for a reaction of `size` [N] to force (n_q); returns its power [W]. */
double lw_friction_force(const lw_system *s, const lw_friction_joint *f, const double *q, const double *v, double size, double *force);

/* Reaction of a joint [N] in the multipliers of its rows: both rows of a pin, the row across the line of a slide. */
static inline lw_vec2 lw_friction_reaction(const lw_system *s, int joint, const double *multiplier)
{
    bool pin = lw_joint_turns(s->joint[joint].kind);
    return lw_v2(multiplier[0]/s->unit, pin ? multiplier[1]/s->unit : 0);
}

/* Sizes N of n reactions of `dim` numbers, 2 in the plane, 3 in space.  The last n_signed are forces along one direction, the
 * first number, which keep their sign.  rest (n x dim): R0; response[dim*(j + n*k)]: R_jk; size (n): N; work: n*(n + dim + 2).
 * *determinant, unless NULL, is 1 without friction: the least pivot, or with n_signed > 0 the determinant.  LW_E_NUMERIC: they
 * are not determined. */
lw_status lw_friction_sizes(int n, int n_signed, int dim, const double *rest, const double *response, double *size,
                            double *work, double *determinant);

/* The scene of joints with friction: the reaction [N] of joint j of them in multipliers, out (dim); its name. */
typedef struct lw_friction_scene {
    const void *context;
    int  dim;
    void (*reaction)(const void *context, int j, const double *multiplier, double *out);
    const char *(*name)(const void *context, int j);
} lw_friction_scene;

static inline size_t lw_friction_doubles(int n, int dim)
{
    return (size_t)n*((size_t)(dim + 1)*(size_t)n + 2*(size_t)dim + 2);
}

/* Changes accelerations a (n_a) and multipliers l (n_l), found without friction, to those with it.  response: n times
 * (n_a + n_l), the a and l that the friction of each joint causes for a reaction of 1 N; behind them lw_friction_doubles of
 * scratch.  size (n): the reactions found.  LW_E_NUMERIC: they are not determined; the error names the first joint.
 * LW_OPEN: the same, with a contact among them. */
lw_status lw_friction_add(const lw_friction_scene *scene, int n, const lw_friction_joint *joint, double *response, double t,
                          int n_a, double *a, int n_l, double *l, double *size, double *determinant, lw_error *e);

#endif

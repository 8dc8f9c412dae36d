/* mbs/dynamics/friction.h - Coulomb friction, regularised, that depends on reactions which depend on it.
 *
 * Friction along what joint j counts is -mu N_j tanh(v/speed), N_j the size of its reaction R_j [N].  Accelerations
 * and reactions are affine in the N,
 *     R_j = R0_j + sum over k of N_k R_jk,
 * so N_j = |R_j| is a system as small as the number of such joints, solved by Newton's method.  Its matrix is I without
 * friction; where the determinant reaches 0, reactions are not determined by rigid bodies with
 * friction (Painleve 1895). */
#ifndef LW_MBS_DYNAMICS_FRICTION_H
#define LW_MBS_DYNAMICS_FRICTION_H

#include "base/status.h"
#include "base/vec2.h"

/* n <= LW_JOINT_MAX; rest (n): R0; response[j + n*k]: R_jk; press (n): N.  LW_E_NUMERIC: not determined. */
lw_status lw_friction_presses(int n, const lw_vec2 *rest, const lw_vec2 *response, double *press);

/* Force [N] or torque [N m] along what the joint counts for a reaction of 1 N, at its rate [rad/s] or [m/s]; arm: the
 * pin's radius [m], 1 for what slides. */
double lw_friction_push(double coefficient, double speed, double arm, double rate);

#endif

/* mbs/drives/servo_internal.h - the equations of a servo axis, shared by run and linear analysis; internal to mbs/. */
#ifndef LW_MBS_DRIVES_SERVO_INTERNAL_H
#define LW_MBS_DRIVES_SERVO_INTERNAL_H

#include "grammar/model/servo.h"
#include "mbs/ode/integrate.h"

/* Integrated states: motor and load seen at the load, current, sums of continuous controllers, then energies.  A state
 * that an axis does not have stays 0. */
enum { LW_SERVO_XM, LW_SERVO_VM, LW_SERVO_X, LW_SERVO_V, LW_SERVO_I, LW_SERVO_SUM_S, LW_SERVO_SUM_C, LW_SERVO_PHYSICAL,
       LW_SERVO_ELECTRICAL = LW_SERVO_PHYSICAL, LW_SERVO_HEAT, LW_SERVO_FRICTION, LW_SERVO_TRANSMISSION, LW_SERVO_WORK,
       LW_SERVO_SQUARE, LW_SERVO_N };

/* Values that sampled controllers hold between samples. */
enum { LW_HELD_SPEED, LW_HELD_CURRENT, LW_HELD_VOLTAGE, LW_HELD_SUM_S, LW_HELD_SUM_C, LW_HELD_POSITION, LW_HELD_N };

typedef struct lw_servo_axis {
    const lw_servo *s;
    bool   linear;                       /* no friction but viscous, no play, limits, steps                     */
    double motor_mass, mass;             /* at the load: of the motor; of both                                   */
    lw_axis_state wanted;                /* linear: the wanted motion, constant                                   */
    double force;                        /* linear: on the load                                                   */
    double held[LW_HELD_N];
    struct { bool is; double t, value; } pending[3];       /* outputs on their way: speed, current, voltage       */
    long   n_sample[3];                  /* taken by each controller                                             */
} lw_servo_axis;

lw_servo_axis lw_servo_axis_of(const lw_servo *s, bool linear);

/* Rates (LW_SERVO_N) at (t, y). */
void lw_servo_rates(const lw_servo_axis *a, double t, const double *y, double *dy);

/* Wanted current and voltage at (t, y). */
void lw_servo_outputs(const lw_servo_axis *a, double t, const double *y, double *current, double *voltage, bool limited[2]);

/* Integrate from t to `end`, events included. */
typedef lw_status lw_servo_seen(void *context, lw_integrator *w);     /* after each step */
lw_status lw_servo_integrate(lw_servo_axis *a, double t, double end, double tolerance, double *y, lw_servo_seen *seen,
                             void *context, long *steps, lw_error *e);

#endif

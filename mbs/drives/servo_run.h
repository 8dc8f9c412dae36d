/* mbs/drives/servo_run.h - simulation of a servo axis. */
#ifndef LW_MBS_DRIVES_SERVO_RUN_H
#define LW_MBS_DRIVES_SERVO_RUN_H

#include <signal.h>
#include "grammar/servo.h"

/* One moment; positions and forces are those of the load. */
typedef struct lw_servo_row {
    double t;
    lw_axis_state wanted;
    double position, speed, error;       /* of the load; wanted less reached                                 */
    double motor_position, motor_speed;  /* of the motor, seen at the load                                   */
    double current, voltage, torque;     /* of the motor [A] [V] [N m]                                       */
    double heat, electrical;             /* in the copper, and energy taken from the amplifier, since 0 [J]   */
} lw_servo_row;
typedef lw_status lw_servo_sink(void *context, const lw_servo_row *row);

typedef struct lw_servo_options {
    double to;                           /* [s]; 0: the end of the motion and a half more                     */
    int    intervals;                    /* rows less one                                                     */
    double tolerance;                    /* of a step of the integration                                      */
    double band;                         /* settled: |error| stays below this [m] or [rad]                     */
    const volatile sig_atomic_t *stop;   /* may be NULL                                                       */
} lw_servo_options;

typedef struct lw_servo_report {
    double end, to;                      /* end of the motion, of the run [s]                                 */
    double error_peak, error_peak_t, error_end;
    double settled;                      /* |error| <= band from here on [s]; NaN: not at the end             */
    double overshoot;                    /* beyond the end of the last move, in its direction                 */
    double current_peak, current_rms, voltage_peak, torque_peak, speed_peak;      /* speed of the motor [rad/s] */
    double current_limited, voltage_limited;      /* time at these limits [s]                                  */
    double electrical, heat, friction, transmission;     /* energy taken; lost in copper, friction, gear [J]   */
    double stored, work;                 /* change of kinetic, elastic, magnetic energy; done by the force [J]  */
    double energy_error;                 /* electrical + work - heat - friction - transmission - stored [J]     */
    long   steps;
} lw_servo_report;

/* 0, 1000, 1e-9, 1e-3 */
lw_servo_options lw_servo_options_default(void);

/* Run from rest at the wanted position at t = 0.  sink may be NULL.  LW_E_NUMERIC: numbers that are not finite, as of an
 * unstable loop; LW_STOPPED. */
lw_status lw_servo_run(const lw_servo *s, const lw_servo_options *o, lw_servo_sink *sink, void *context,
                       lw_servo_report *r, lw_error *e);

#endif

/* mbs/drives/motor.h - loads of drives, and whether a motor with a gear and an amplifier can carry them.
 * Types and the choice: linkwright.h. */
#ifndef LW_MBS_DRIVES_MOTOR_H
#define LW_MBS_DRIVES_MOTOR_H

#include <stdbool.h>
#include <stddef.h>
#include "grammar/model/drive_parts.h"

/* A gear of the list; -1: none, the motor turns the joint itself. */
const lw_gear_part *lw_drive_gear(const lw_drive_parts *p, int gear);

/* Torque of the motor at a sample: the load through the gear, whose losses the driving side pays, and the inertia of motor
 * and gear. */
double lw_drive_torque(const lw_load *l, size_t k, double ratio, double efficiency, double inertia);

/* One choice.  greatest_inertia: limit of the inertia ratio; INFINITY: none.  work (2 n of the load): scratch. */
lw_drive_choice lw_drive_try(const lw_load *l, const lw_drive_parts *p, int motor, int gear, int amplifier,
                             double greatest_inertia, double *work);

/* A mass on a wheel or pinion of radius r, moved over `way` by a motor: Makkonen 1999, paper D.
 *
 *     a = T r/(J + m r^2)                     greatest at r = sqrt(J/m):  a = T/(2 sqrt(J m))
 *     t = s/(r w) + w (J + m r^2)/T           while s >= v^2/a; least at r = (s T/(2 w^2 m))^(1/3)
 *
 * The printed program takes the acceleration limit for a, not what the motor reaches, and r = a J/T, which leaves out
 * the load.  Both are given beside the true values. */
typedef struct lw_radius {
    double r, alpha, speed, efficiency;      /* [m] [rad/s^2] [m/s]; 1/(1 + J/(m r^2))         */
    double printed_way, printed_time;        /* v^2/a and 2 v/a with the limit of acceleration */
    double acceleration, time;               /* that the axis truly reaches; true time of the way */
} lw_radius;

lw_radius lw_radius_at(const lw_motor_part *m, double mass, double way, double limit, double r);
double    lw_radius_printed(const lw_motor_part *m, double limit);               /* a J/T                       */
double    lw_radius_of_way(const lw_motor_part *m, double mass, double way);     /* formula for the least time  */
double    lw_radius_of_acceleration(const lw_motor_part *m, double mass);        /* sqrt(J/m)                   */
double    lw_radius_best(const lw_motor_part *m, double mass, double way);       /* of least true time          */

#endif

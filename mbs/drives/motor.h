/* mbs/drives/motor.h - loads of drives, and whether a motor with a gear and an amplifier can carry them.
 *
 * Sign: torque and speed of the same sign drive the load.  `torque` and `speed` of a slider are a force [N] and [m/s],
 * and a transmission then has radians of the motor per metre. */
#ifndef LW_MBS_DRIVES_MOTOR_H
#define LW_MBS_DRIVES_MOTOR_H

#include <stdbool.h>
#include <stddef.h>
#include "grammar/drive_parts.h"

/* Evenly spaced samples of a cycle. */
typedef struct lw_load {
    const char   *name;
    bool          slides;
    size_t        n;
    double        step;                      /* [s]                                            */
    const double *speed, *torque, *acceleration;
    double        inertia[2];                /* least and greatest reflected inertia [kg m^2] or [kg]; NaN: not known */
} lw_load;

typedef struct lw_load_figures {
    double torque_peak, torque_rms, speed_peak, power_peak, power_mean, power_least;
    double energy_out, energy_back;          /* of the drive into the load; from the load into the drive [J] */
} lw_load_figures;

/* Integrals by the trapezoidal rule; the power is taken as straight between two samples. */
lw_load_figures lw_load_figures_of(const lw_load *l);

/* What keeps a choice from the work: bits of lw_drive_choice.fails. */
#define LW_DRIVE_LIMIT_LIST(X) \
    X(SPEED,          "speed of the motor") \
    X(PEAK,           "peak torque of the motor") \
    X(RMS,            "continuous torque of the motor") \
    X(GEAR_SPEED,     "speed of the gear") \
    X(GEAR_PEAK,      "peak torque of the gear") \
    X(GEAR_RMS,       "continuous torque of the gear") \
    X(VOLTAGE,        "voltage of the amplifier") \
    X(CURRENT,        "peak current of the amplifier") \
    X(CURRENT_RMS,    "continuous current of the amplifier") \
    X(HEAT,           "i^2 t of the amplifier") \
    X(INERTIA,        "inertia ratio")
enum {
#define X(name, text) LW_DRIVE_##name,
    LW_DRIVE_LIMIT_LIST(X)
#undef X
    LW_DRIVE_N_LIMIT
};
const char *lw_drive_limit_text(int limit);

typedef struct lw_drive_choice {
    int      motor, gear, amplifier;         /* of the lists; amplifier -1: none was asked for */
    double   ratio;                          /* motor angle over load angle, or [rad/m]        */
    double   speed, torque_peak, torque_rms; /* of the motor [rad/s] [N m]                     */
    double   current_peak, current_rms, voltage, heat;     /* [A] [A] [V]; heat of the winding, mean [W] */
    double   i2t;                            /* greatest charge of the amplifier, over what it allows */
    double   inertia_ratio;                  /* load, greatest, over motor and gear; NaN       */
    double   use[LW_DRIVE_N_LIMIT];          /* what is used of each limit; NaN: no such limit */
    double   worst;                          /* greatest of use: <= 1 can do it                */
    unsigned fails;
    double   cost;                           /* price of all, or mass [kg] if no price is given, or rated power [W] */
} lw_drive_choice;

/* One choice.  greatest_inertia: limit of the inertia ratio; INFINITY: none. */
lw_drive_choice lw_drive_try(const lw_load *l, const lw_drive_parts *p, int motor, int gear, int amplifier,
                             double greatest_inertia);

/* All choices, the best first: those that can do it by cost and then by `worst`; then the others by `worst`.  *out is
 * freed with free().  front[i]: no other choice that can do it is both cheaper and less used. */
lw_status lw_drive_choose(const lw_load *l, const lw_drive_parts *p, double greatest_inertia, size_t *n,
                          lw_drive_choice **out, bool **front, lw_error *e);

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

/* grammar/model/servo.h - a servo axis as a file describes it (docs/drive.md, "Loop"): motor, amplifier, transmission, load,
 * encoder, controllers and the motion that they are to follow.
 *
 * SI units.  Positions, speeds and forces are those of the load: of a slide [m] with "radius", of a shaft [rad] with
 * "ratio". */
#ifndef LW_GRAMMAR_MODEL_SERVO_H
#define LW_GRAMMAR_MODEL_SERVO_H

#include "grammar/functions/expression.h"
#include "grammar/functions/moves.h"     /* lw_servo: linkwright.h */

/* Force against the motion: (coulomb + (breakaway - coulomb) exp(-(v/stribeck)^2)) tanh(v/smoothing) + viscous v. */
typedef struct lw_servo_friction { double coulomb, breakaway, stribeck, viscous, smoothing; } lw_servo_friction;

/* A controller, its sampling time (0: it acts at every moment) and the time from a sample to its output. */
typedef struct lw_servo_loop { double proportional, integral, sample, delay; } lw_servo_loop;

struct lw_servo {
    char   name[64];
    bool   slides;                         /* the load is a slide                                              */
    double constant, inertia, resistance, inductance;      /* motor [N m/A] [kg m^2] [Ohm] [H]                */
    lw_servo_friction motor;               /* of the motor's shaft [N m], [N m s]                              */
    double voltage, current;               /* limits of the amplifier; infinite: none                          */
    double factor;                         /* way of the load over the turn of the motor: radius [m], 1/ratio   */
    bool   elastic;
    double stiffness, damping, backlash;   /* between motor and load, seen at the load; backlash: whole play     */
    double load;                           /* mass [kg] or inertia [kg m^2]                                    */
    lw_servo_friction friction;            /* of the load [N], [N m]                                            */
    lw_expression *force;                  /* on the load as a function of t; NULL: none                        */
    double encoder;                        /* steps of a turn of the encoder's shaft or metre of the slide; 0: none */
    bool   encoder_at_load;
    /* Position: wanted speed from the error [1/s].  Speed: wanted acceleration from the error of speed [1/s] and its
     * integral [1/s^2].  Current: voltage from the error of the current [V/A], [V/(A s)]. */
    lw_servo_loop position, speed, circuit;
    bool   ideal_current;                  /* no current controller: the wanted current flows                    */
    double speed_feed_forward, acceleration_feed_forward;   /* shares of the wanted speed and acceleration        */
    bool   emf_compensation;
    lw_moves moves;                        /* the wanted motion; none with a reference                            */
    lw_expression *reference;              /* wanted position as a function of t instead of moves                 */
};

/* LW_E_NOTATION with line and column; s needs lw_servo_free after success. */
lw_status lw_servo_read(const char *text, size_t size, const char *file, lw_servo *s, lw_error *e);
void      lw_servo_free(lw_servo *s);

/* Wanted position, speed, acceleration at t. */
lw_axis_state lw_servo_wanted(const lw_servo *s, double t);

/* The first time after t at which the wanted motion has a kink; infinite: none. */
double lw_servo_next_kink(const lw_servo *s, double t);

#endif

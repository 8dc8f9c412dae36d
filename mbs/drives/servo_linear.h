/* mbs/drives/servo_linear.h - the linear equations of a servo axis: without dry friction, play, limits, encoder steps. */
#ifndef LW_MBS_DRIVES_SERVO_LINEAR_H
#define LW_MBS_DRIVES_SERVO_LINEAR_H

#include "grammar/model/servo.h"

#define LW_MATRIX_STATE_MAX  16
#define LW_MATRIX_INPUT_MAX   4
#define LW_MATRIX_OUTPUT_MAX  6

/* x' = A x + B u, or (sample > 0) x after the next `sample` seconds; y = C x + D u.  Entry (i, k) of a matrix with n
 * columns is [i*n + k]. */
typedef struct lw_state_matrices {
    int    n_state, n_input, n_output;
    const char *state[LW_MATRIX_STATE_MAX], *input[LW_MATRIX_INPUT_MAX], *output[LW_MATRIX_OUTPUT_MAX];
    const char *state_unit[LW_MATRIX_STATE_MAX], *input_unit[LW_MATRIX_INPUT_MAX], *output_unit[LW_MATRIX_OUTPUT_MAX];
    double a[LW_MATRIX_STATE_MAX*LW_MATRIX_STATE_MAX], b[LW_MATRIX_STATE_MAX*LW_MATRIX_INPUT_MAX],
           c[LW_MATRIX_OUTPUT_MAX*LW_MATRIX_STATE_MAX], d[LW_MATRIX_OUTPUT_MAX*LW_MATRIX_INPUT_MAX];
    double sample;
} lw_state_matrices;

/* Motor, transmission and load without controllers: inputs are the voltage (an ideal current: the current) and a force on
 * the load. */
void lw_servo_plant(const lw_servo *s, lw_state_matrices *m);

/* The whole with its controllers: inputs are the wanted position, speed, acceleration and a force on the load.  Sampled
 * controllers: from one moment before all samples to the next.  LW_E_KIND: the sampling times have no common multiple
 * that is one of them, or some controllers sample and slower ones do not. */
lw_status lw_servo_closed(const lw_servo *s, lw_state_matrices *m, lw_error *e);

/* Eigenvalues of A as poles [1/s], the least damped first; of sampled equations the logarithms of the eigenvalues over
 * the sampling time, without those at 0, which have died out after one period.  LW_E_NUMERIC, LW_E_MEMORY. */
lw_status lw_matrices_poles(const lw_state_matrices *m, int *n, double *re, double *im);

/* Least margins of the open loop of a controller, with holds and delays of all samplings, up to half its sampling
 * frequency. */
typedef struct lw_servo_margin {
    double crossover;                    /* where the gain is 1, with the least margin [rad/s]; NaN: nowhere     */
    double phase;                        /* margin there [rad], -pi .. pi                                        */
    double reversal;                     /* where the phase is -180 degrees [rad/s]; NaN: nowhere               */
    double gain;                         /* 1/gain there                                                        */
} lw_servo_margin;

enum { LW_SERVO_POSITION, LW_SERVO_SPEED, LW_SERVO_CIRCUIT };

/* Open loop at frequency w [rad/s] as gain and phase [rad], -pi .. pi.  The current loop of an ideal current is 0. */
void lw_servo_response(const lw_servo *s, int loop, double w, double *gain, double *phase);
lw_servo_margin lw_servo_margin_of(const lw_servo *s, int loop);

#endif

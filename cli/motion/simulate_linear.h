/* cli/motion/simulate_linear.h - `simulate --analysis linear`: modes about a posture, its rest, or along the motion. */
#ifndef CLI_MOTION_SIMULATE_LINEAR_H
#define CLI_MOTION_SIMULATE_LINEAR_H

#include "cli/program/command.h"
#include "grammar/model.h"

typedef struct cli_linear {
    bool   rest;                 /* at the static equilibrium                                        */
    bool   hold;                 /* inputs held                                                     */
    bool   fft;                  /* compare with the spectra of a free vibration                      */
    int    along;                /* > 0: that many intervals of input 0 from its first to its last value, or a turn */
    double t;                    /* of loads and motions [s]                                         */
} cli_linear;

/* The whole of it: tables or --json to what -o names.  An exit code. */
int cli_simulate_linear(const cli_call *call, const lw_model *m, const cli_linear *o);

#endif

/* cli/motion/simulate_linear.h - `simulate --analysis linear`: modes about a posture, about its rest position, or along
 * the motion. */
#ifndef CLI_MOTION_SIMULATE_LINEAR_H
#define CLI_MOTION_SIMULATE_LINEAR_H

#include "cli/program/command.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"

typedef struct cli_linear {
    bool   rest;                 /* at the static equilibrium                                        */
    bool   hold;                 /* inputs fixed                                                    */
    bool   fft;                  /* compare with the spectra of a free vibration                      */
    int    along;                /* > 0: that many intervals of input 0 from its first to its last value, or a turn */
    int    modes;                /* slowest modes of a large or elastic model                        */
    bool   rigid;                /* elastic links as rigid bars                                      */
    double t;                    /* time at which loads and motions are taken [s]                    */
} cli_linear;

/* Run the analysis of a planar model or a spatial one (the other is NULL) and print tables or --json to the file of -o. Returns an exit code. */
int cli_simulate_linear(const cli_call *call, lw_model *m, lw_spatial *space, const cli_linear *o);

#endif

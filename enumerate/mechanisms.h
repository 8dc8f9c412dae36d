/* enumerate/mechanisms.h - from a chain to mechanisms in steps: ground, joint kinds, inputs, output.  Each step is
 * optional; the mechanisms after each step are counted. */
#ifndef LW_ENUMERATE_MECHANISMS_H
#define LW_ENUMERATE_MECHANISMS_H

#include "enumerate/inputs.h"

typedef enum lw_input_choice { LW_INPUT_LEFT, LW_INPUT_GROUND, LW_INPUT_ANY } lw_input_choice;

typedef struct lw_mechanism_steps {
    bool            ground;    /* choose a ground link                                            */
    const char     *kinds;     /* letters for joints, of "rtpg"; NULL: joints stay as they are    */
    lw_input_choice input;     /* drive F joints: at the ground (needs one), or any; or no inputs */
    bool            output;    /* choose an output link (needs a ground)                          */
    bool            slider_direction, translating_cams;    /* as in lw_mechanism; both with kinds */
} lw_mechanism_steps;

/* Numbers of mechanisms after each step; that of the last step taken is the number of visits. */
typedef struct lw_mechanism_counts {
    uint64_t n_chain, n_ground, n_labelled, n_driven, n_output;
    uint64_t n_void[LW_VOID_LOCKED + 1];       /* labellings left out, by reason */
} lw_mechanism_counts;

/* Visit all results of the steps, each once up to symmetry.  Steps whose choice m already has (a ground, for example)
 * must be left out.  Adds to *counts.  visit and left_out may be NULL.  LW_E_ARG: steps that contradict each other;
 * LW_E_MEMORY; or the status of visit. */
lw_status lw_mechanisms_each(const lw_mechanism *m, const lw_mechanism_steps *steps, lw_mechanism_counts *counts,
                             lw_mechanism_visit *visit, lw_void_visit *left_out, void *context);

#endif

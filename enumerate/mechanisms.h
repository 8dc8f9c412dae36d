/* enumerate/mechanisms.h - from a chain to mechanisms: ground, joint kinds, inputs, output, one step after the
 * other, each of which may be left out, with counts by step. */
#ifndef LW_ENUMERATE_MECHANISMS_H
#define LW_ENUMERATE_MECHANISMS_H

#include "enumerate/inputs.h"

typedef enum lw_input_choice { LW_INPUT_LEFT, LW_INPUT_GROUND, LW_INPUT_ANY } lw_input_choice;

typedef struct lw_mechanism_steps {
    bool            ground;    /* choose a ground link                                            */
    const char     *kinds;     /* letters for joints, of "rtpg"; NULL: joints stay as they are    */
    lw_input_choice input;     /* drive F joints: at the ground (wants one), or any; or leave it  */
    bool            output;    /* choose an output link (wants a ground)                          */
} lw_mechanism_steps;

/* How many there were after each step; the last one of those taken is the number of visits. */
typedef struct lw_mechanism_counts {
    uint64_t n_chain, n_ground, n_labelled, n_driven, n_output;
    uint64_t n_void[LW_VOID_LOCKED + 1];       /* labellings left out, by reason */
} lw_mechanism_counts;

/* Only the ground. */
lw_mechanism_steps lw_mechanism_steps_default(void);

/* Everything that m becomes by the steps, each once up to symmetry.  Steps that m has gone already (a ground
 * chosen) must be left out.  Adds to *counts.  visit and left_out may be NULL.  LW_E_ARG: steps that do not go
 * together, LW_E_MEMORY, or what visit returns. */
lw_status lw_mechanisms_each(const lw_mechanism *m, const lw_mechanism_steps *steps, lw_mechanism_counts *counts,
                             lw_mechanism_visit *visit, lw_void_visit *left_out, void *context);

#endif

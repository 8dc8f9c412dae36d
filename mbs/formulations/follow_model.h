/* mbs/formulations/follow_model.h - follow a model (mbs/dynamics/follow.h). */
#ifndef LW_MBS_FORMULATIONS_FOLLOW_MODEL_H
#define LW_MBS_FORMULATIONS_FOLLOW_MODEL_H

#include "mbs/dynamics/follow.h"

/* Move the inputs of m straight from the posture of the file to motion(t).  motion gives as many functions as m has
 * inputs that are not tied.  m must outlive f.  LW_E_ARG: fewer inputs than freedoms; LW_OPEN, LW_E_NUMERIC: the posture does
 * not close or is singular, or the motion cannot be reached; the text says which. */
lw_status lw_follow_create(const lw_model *m, lw_input_function *motion, void *context, double t,
                           const volatile sig_atomic_t *stop, lw_follow **f, lw_error *e);

#endif

/* grammar/model_internal.h - memory of a model, for its reader; internal to grammar/. */
#ifndef LW_GRAMMAR_MODEL_INTERNAL_H
#define LW_GRAMMAR_MODEL_INTERNAL_H

#include "grammar/model.h"

/* Zeroed arrays for the links, joints and inputs of m->linkage.  After LW_E_MEMORY too, m needs lw_model_free. */
lw_status lw_model_reserve(lw_model *m);

#endif

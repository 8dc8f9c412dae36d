/* optimise/task/contradiction.h - conditions that no linkage can meet, told before any search. */
#ifndef LW_OPTIMISE_TASK_CONTRADICTION_H
#define LW_OPTIMISE_TASK_CONTRADICTION_H

#include "optimise/problem/problem.h"

/* What contradicts what, in words; NULL: nothing that this finds.  It knows places of the pivots against the range of
 * positions and against forbidden zones, several of them together. */
const char *lw_contradiction(const lw_fit_spec *s);

#endif

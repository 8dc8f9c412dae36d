/* optimise/solvers/lowdiscrepancy.h - points that fill a cube evenly: Sobol's sequence of GSL with a random shift
 * (Cranley & Patterson 1976), different for every seed and every block. */
#ifndef LW_OPTIMISE_SOLVERS_LOWDISCREPANCY_H
#define LW_OPTIMISE_SOLVERS_LOWDISCREPANCY_H

#include <stdbool.h>
#include <stddef.h>
#include "base/rng.h"

/* Store n points of [0, 1)^d, d <= 40, one after the other in u. False: out of memory. */
bool lw_low_discrepancy(lw_rng *shift, size_t n, int d, double *u);

#endif

/* optimise/solvers/feasible.h - find points that meet the conditions: before a method starts, and at its end. */
#ifndef LW_OPTIMISE_SOLVERS_FEASIBLE_H
#define LW_OPTIMISE_SOLVERS_FEASIBLE_H

#include "optimise/solvers/record.h"

/* Move x into the interior, all g > 0 and lo <= x <= hi. A damped Gauss-Newton method minimises the sum of squared
 * violations of g >= margin. The margin is lowered from 1e-2 in steps until it can be met, from x first and then from
 * seeded random points around it. A point already inside stays as it is. False: no such point was found (x is then the
 * last point tried). */
bool lw_feasible_start(lw_record *r, double *x);

/* Move x, which slightly violates bounds or conditions, to the nearest point, to first order, that meets them. False: x
 * could not be made feasible in the sense of record.h. */
bool lw_feasible_repair(lw_record *r, double *x);

#endif

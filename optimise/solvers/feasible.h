/* optimise/solvers/feasible.h - points inside the subsidiary conditions: phase one and the last repair. */
#ifndef LW_OPTIMISE_SOLVERS_FEASIBLE_H
#define LW_OPTIMISE_SOLVERS_FEASIBLE_H

#include "optimise/solvers/record.h"

/* Phase one.  Move x into the interior, all g > 0 and lo <= x <= hi: the sum of squared violations of
 * g >= margin is minimised by a damped Gauss-Newton method, the margin being lowered from 1e-2 in steps
 * until it can be met, from x first and then from seeded random points around it.  A point already
 * inside stays as it is.  false when nothing was found (x is then the last point tried). */
bool lw_feasible_start(lw_record *r, double *x);

/* Move x, which violates bounds or conditions a little, onto them by the shortest way to first order.
 * false when it could not be made feasible in the sense of record.h. */
bool lw_feasible_repair(lw_record *r, double *x);

#endif

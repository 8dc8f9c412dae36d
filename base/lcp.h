/* base/lcp.h - linear complementarity problems: z >= 0, w = M z + q >= 0, z.w = 0.
 *
 * Lemke's method with the lexicographic rule against cycling (Cottle, Pang & Stone 2009, section 4.4).  It finds a
 * solution for every copositive M whose q lies in the dual cone of its solutions, which covers impacts with friction
 * (Stewart & Trinkle 1996); for other M it may end on a ray. */
#ifndef LW_BASE_LCP_H
#define LW_BASE_LCP_H

#include <stddef.h>
#include "base/status.h"

/* Doubles of workspace for n unknowns. */
size_t lw_lcp_work(int n);

/* m (n*n) by rows, q (n); z (n) the solution.  LW_NOTHING: the method ends on a ray; LW_E_NUMERIC: too many pivots or
 * numbers that are not finite. */
lw_status lw_lcp_solve(int n, const double *m, const double *q, double *work, double *z);

#endif

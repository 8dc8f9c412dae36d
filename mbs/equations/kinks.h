/* mbs/equations/kinks.h - where steps end because forces have kinks or jumps that depend on the motion (lw_equations.switches).
 *
 * One event function serves all of them: the least distance from a kink or jump, on the sides where the motion is now.  A kink is passed where
 * the motion is behind it by more than a small part of the tolerance and by more than rounding, so that a motion that rests there has no event at each
 * step. */
#ifndef LW_MBS_EQUATIONS_KINKS_H
#define LW_MBS_EQUATIONS_KINKS_H

#include "base/error.h"
#include "mbs/equations/equations.h"

typedef struct lw_kinks lw_kinks;

/* *k is NULL if the forces have no kinks or jumps.  The equations must outlive it.  LW_E_MEMORY. */
lw_status lw_kinks_make(const lw_equations *eq, lw_kinks **k);
void      lw_kinks_free(lw_kinks *k);

/* Note the sides where the motion is at (t, q, v), at the start of a run; first-order states are placed.  tolerance: of the run. */
void   lw_kinks_start(lw_kinks *k, double tolerance, double t, const double *q, const double *v);

/* The event function: falls to 0 at the next kink or jump. */
double lw_kinks_ahead(lw_kinks *k, double t, const double *q, const double *v);

/* Call after a step to (t, q, v); event: the step has ended at this event.  True: a kink has been passed, and the solver must begin anew. */
bool   lw_kinks_pass(lw_kinks *k, double t, const double *q, const double *v, bool event);

/* Is the motion on the other side of kink i than before?  Distances `before` and `side` as lw_equations.switches gives them.  A motion that stays on
 * a kink changes its side by errors alone, which do not count.  h: length of the step, whose velocities are differences of places. */
bool   lw_kinks_crossed(const lw_kinks *k, int i, double before, double side, double h);

#endif

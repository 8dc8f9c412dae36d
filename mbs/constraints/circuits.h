/* mbs/constraints/circuits.h - find the circuits of a linkage with one free input: all assembly modes, and both
 * curves at a branch point.
 *
 * The search draws random postures and closes each by Newton's method with least-norm steps.  A posture that lies on no
 * known curve starts a new one, which is then followed completely.  The total number of circuits is unknown; `since` is
 * the number of closed postures since the last new curve.  Of systems larger than a linkage hardly any random posture closes:
 * there a few neighbouring links of a posture on a known curve are drawn, and closed by Levenberg's method with sparse rows. */
#ifndef LW_MBS_CONSTRAINTS_CIRCUITS_H
#define LW_MBS_CONSTRAINTS_CIRCUITS_H

#include <signal.h>
#include <stdint.h>
#include "mbs/constraints/motion_curve.h"

typedef struct lw_circuits {
    int        n, capacity;
    lw_motion_curve **curve;               /* the first one contains the posture given                */
    int        draws, closed;              /* postures drawn; number of these that closed             */
    int        since;                      /* closed postures since the last new curve                */
    bool       late;                       /* the time ended the search                               */
} lw_circuits;

/* The circuit of posture q (NULL: the drawn one) alone if patience is 0, else the search: it ends after `patience` closed postures
 * without a new curve, n/16 times as many beyond 16 curves, after 20 times as many draws, at time o->until,
 * or when *o->stop is set: the curves found so far stay.  The same seed gives the same curves.  Fails as lw_motion_curve_create for
 * the first posture. */
lw_status lw_circuits_find(const lw_system *s, const double *q, const lw_motion_curve_options *o, int patience, uint64_t seed,
                           lw_circuits *c, lw_error *e);
void      lw_circuits_free(lw_circuits *c);

#endif

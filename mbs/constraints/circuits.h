/* mbs/constraints/circuits.h - find the circuits of a linkage with one free input: all assembly modes, and both
 * curves at a branch point.
 *
 * The search draws random postures and closes each by Newton's method with least-norm steps.  A posture that lies on no
 * known curve starts a new one, which is then followed completely.  The total number of circuits is unknown; `since` is
 * the number of closed postures since the last new curve. */
#ifndef LW_MBS_CONSTRAINTS_CIRCUITS_H
#define LW_MBS_CONSTRAINTS_CIRCUITS_H

#include <signal.h>
#include <stdint.h>
#include "mbs/constraints/motion_curve.h"

#define LW_CIRCUIT_MAX 64

typedef struct lw_circuits {
    int        n;
    lw_motion_curve *curve[LW_CIRCUIT_MAX];        /* the first one contains the drawn posture                */
    int        draws, closed;              /* postures drawn; number of these that closed             */
    int        since;                      /* closed postures since the last new curve                */
    bool       full;                       /* more than LW_CIRCUIT_MAX were found                      */
} lw_circuits;

/* The search ends after `patience` closed postures without a new curve, after 20 times as many draws, or when
 * *o->stop is set: the curves found so far stay.  The same seed gives the same curves.  Fails as lw_motion_curve_create for the drawn
 * posture. */
lw_status lw_circuits_find(const lw_system *s, const lw_motion_curve_options *o, int patience, uint64_t seed,
                           lw_circuits *c, lw_error *e);
void      lw_circuits_free(lw_circuits *c);

#endif

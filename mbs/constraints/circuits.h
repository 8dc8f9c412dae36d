/* mbs/constraints/circuits.h - every curve of postures of a linkage with one free input: all circuits, in all assembly modes, and
 * at branch points both branches.
 *
 * Postures are drawn by chance and brought to closing by Newton's method with steps of least length; one that is on
 * no curve found yet starts the next. A curve once found is known with every posture on it, so what is counted is
 * circuits, not postures. How many there are in all nobody says: `since` tells how many draws brought nothing new. */
#ifndef LW_MBS_CONSTRAINTS_CIRCUITS_H
#define LW_MBS_CONSTRAINTS_CIRCUITS_H

#include <signal.h>
#include <stdint.h>
#include "mbs/constraints/motion_curve.h"

#define LW_CIRCUIT_MAX 64

typedef struct lw_circuits {
    int        n;
    lw_motion_curve *curve[LW_CIRCUIT_MAX];        /* the first is that of the drawn posture                  */
    int        draws, closed;              /* postures drawn, and of these closed                     */
    int        since;                      /* closed ones since the last new curve                    */
    bool       full;                       /* there were more than LW_CIRCUIT_MAX                       */
} lw_circuits;

/* Ends after `patience` closed postures without a new curve, or 20 times as many draws, or when *stop is set (NULL:
 * never).  Same seed, same curves.  Failures of lw_motion_curve_create for the drawn posture. */
lw_status lw_circuits_find(const lw_system *s, const lw_motion_curve_options *o, int patience, uint64_t seed,
                         const volatile sig_atomic_t *stop, lw_circuits *c, lw_error *e);
void      lw_circuits_free(lw_circuits *c);

#endif

/* mbs/run/passage_internal.h - the motion over a singular posture as a polynomial; internal to mbs/.
 *
 * The equations hold at twenty nodes, none of which is near the middle, where the singular posture lies.  The polynomial is as
 * accurate as the accelerations at the nodes. */
#ifndef LW_MBS_RUN_PASSAGE_INTERNAL_H
#define LW_MBS_RUN_PASSAGE_INTERNAL_H

#include "base/real.h"
#include "mbs/run/run_internal.h"
#include "mbs/ode/panel_internal.h"

/* Nodes on either side, as fractions of half the length. */
enum { LW_PASSAGE_SIDE = 10, LW_PASSAGE_NODES = 2*LW_PASSAGE_SIDE };
static const double lw_passage_node[LW_PASSAGE_SIDE] = { 0.261, 0.337, 0.447, 0.564, 0.677, 0.778, 0.863, 0.929, 0.974, 0.997 };

typedef struct lw_passage {
    lw_run *run;
    const lw_panel_rule *rule;
    double  start, length, *begun;           /* begun (n): state at `anchor`, a fraction of the length */
    double  anchor;
    double  at[LW_PASSAGE_NODES];                /* nodes as fractions of the length */
    double  enough;                          /* change of the states that the next pass is not worth; 0: passes go on to rounding */
    double  rounding;                        /* change of the states in the last pass of a solution */
    double *rate, *state;                    /* (LW_PASSAGE_NODES x n) at the nodes */
} lw_passage;

/* Its nodes and its rule.  LW_E_MEMORY. */
lw_status lw_passage_begin(lw_passage *z);

/* Integrate anew from (t, y) to end by an explicit method; `fixed`: by one step, whatever its error.  LW_OPEN: it takes too many steps. */
lw_status lw_passage_integrate(lw_run *run, double t, double end, double *y, bool fixed);

/* First guess of the states at the nodes: those before the middle are integrated, each behind it follows from the rates before. */
lw_status lw_passage_guess(lw_passage *z);

/* Is the root of the least pivot greater than `least` at all nodes? */
bool lw_passage_is_clear(const lw_passage *z, double least);

/* Put the singular posture into the middle: the pivot's root changes its sign there.  false: there is none within. */
bool lw_passage_centre(lw_passage *z);

/* Put the turn of a motion that turns back near the singular posture into the middle.  *t: its time [s]; *beyond: by how far it is
 * behind the posture, negative: before; *bend: second derivative of the pivot's root there [1/s^2].  false: there is none. */
bool lw_passage_centre_turn(lw_passage *z, double *t, double *beyond, double *bend);

/* Iterate the states at the nodes.  y: the state at the end; *tail: the part of it that is not resolved. */
lw_status lw_passage_solve(lw_passage *z, double *y, double *tail);

/* Do the states in the middle satisfy the rows to the tolerance?  Else motion curves come near each other and do not meet. */
bool lw_passage_meets(const lw_passage *z, double tolerance);

/* State at x in 0 .. 1. */
void lw_passage_state(const lw_passage *z, double x, double *y);

/* Is a residual of the rows on the polynomial small enough?  Where motion curves come near each other and do not meet, it is
 * not. */
static inline bool lw_passage_fits(double off, double tolerance) { return off <= fmin(fmax(1e-12, tolerance), 1e-8); }
#endif

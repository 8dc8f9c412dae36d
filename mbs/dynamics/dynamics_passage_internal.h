/* mbs/dynamics/dynamics_passage_internal.h - the motion over a singular posture as a polynomial; internal to mbs/.
 *
 * The equations hold at twelve nodes, none of which is near the middle, where the singular posture lies.  The polynomial is as
 * accurate as the accelerations at the nodes, and its order is far higher than that of the explicit step, which serves as
 * the first guess. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_PASSAGE_INTERNAL_H
#define LW_MBS_DYNAMICS_DYNAMICS_PASSAGE_INTERNAL_H

#include "base/real.h"
#include "mbs/dynamics/dynamics_run_internal.h"
#include "mbs/ode/panel_internal.h"

/* Nodes on either side, as fractions of half the length. */
enum { LW_PASSAGE_SIDE = 6, LW_PASSAGE_NODES = 2*LW_PASSAGE_SIDE };
static const double lw_passage_node[LW_PASSAGE_SIDE] = { 0.280, 0.447, 0.640, 0.808, 0.929, 0.992 };

typedef struct lw_passage {
    lw_run *run;
    const lw_panel_rule *rule;
    double  start, length, *begun;           /* begun (n): state at `anchor`, a fraction of the length */
    double  anchor;
    double  at[LW_PASSAGE_NODES];                /* nodes as fractions of the length */
    double *rate, *state;                    /* (LW_PASSAGE_NODES x n) at the nodes */
} lw_passage;

/* Its nodes and its rule.  LW_E_MEMORY. */
lw_status lw_passage_begin(lw_passage *z);

/* Integrate anew from (t, y) to end; `fixed`: by one step, whatever its error. */
lw_status lw_passage_integrate(lw_run *run, double t, double end, double *y, bool fixed);

/* First guess of the states at the nodes, by explicit steps. */
lw_status lw_passage_guess(lw_passage *z);

/* Put the singular posture into the middle: the pivot's root changes its sign there.  false: there is none within. */
bool lw_passage_centre(lw_passage *z);

/* Iterate the states at the nodes.  y: the state at the end; *tail: the part of it that is not resolved. */
lw_status lw_passage_solve(lw_passage *z, double *y, double *tail);

/* State at x in 0 .. 1. */
void lw_passage_state(const lw_passage *z, double x, double *y);

/* Is a residual of the rows on the polynomial small enough?  Where motion curves come near each other and do not meet, it is
 * not. */
static inline bool lw_passage_fits(double off, double tolerance) { return off <= fmin(fmax(1e-12, tolerance), 1e-8); }
#endif

/* mbs/run/closed_internal.h - the places that are closed, and impacts at them: what touch.c asks of touch_impact.c. */
#ifndef LW_MBS_RUN_CLOSED_INTERNAL_H
#define LW_MBS_RUN_CLOSED_INTERNAL_H

#include "mbs/dynamics/touch_internal.h"
#include "mbs/equations/complementarity.h"
#include "mbs/run/run_internal.h"

static const double lw_touch_overlap = 1e-6;     /* a gap below minus this: shapes overlap, scaled */
/* Rates of slips below this times a speed count as 0.  The speed is the greatest velocity, or the speed that the free accelerations
 * reach over the size of the linkage. */
static const double lw_touch_no_slip = 1e-10;

static inline bool lw_touch_is_rigid(const lw_touch *p) { return !(p->surface->stiffness > 0); }

static inline bool lw_touch_has_set_valued_friction(const lw_touch *p)
{
    return p->surface->friction > 0 && !(p->surface->friction_speed > 0) && p->kind <= LW_TOUCH_DISCS;
}

static inline double lw_touch_row_dot(const lw_touch *p, const double *row, const double *x)
{
    double sum = 0;
    for (int i = 0; i < 6; i++)
        if (p->body[i/3] >= 0)
            sum += row[i]*x[3*p->body[i/3] + i%3];
    return sum;
}

/* m closed places: their numbers, rows (12 m: gap, slip), responses of the velocities to unit impulses (2m x n_q), W, the responses of
 * the rates (2m x 2m), and rates u (2m). */
typedef struct lw_closed {
    int     m, *place;
    double *row, *response, *w, *u, *b, *force, *rate, *gap, *sub;
    lw_touch_law *law;
    bool   *in, *noted;                  /* takes part; its impact has been reported                    */
    double  slow;                        /* slips below this are rounding                               */
} lw_closed;

void lw_closed_free(lw_closed *c);

/* Find the closed places, with their rows, responses and W. */
lw_status lw_closed_find(lw_run *run, double t, const double *y, lw_closed *c);

/* The rates u of the places at velocities v. */
void lw_closed_rates(const lw_dynamics *d, const double *v, lw_closed *c);

/* Solve for the places of c that are `in`, with c->law and the rates `b`; c->force and c->rate (2m) of all places. */
lw_status lw_closed_solve(const lw_closed *c, const double *b, double *force, double *rate);

/* Report an event of a place: an impact at this rate, or another change. */
void lw_run_touch_note(lw_run *run, int place, double t, bool impact, double rate);

/* Apply the impacts at places that approach faster than *tiny, and those that they cause.  Impulses between wedged bodies
 * may be far greater than the changes of rates that they cause; *tiny then grows to the rounding errors of the solution. */
lw_status lw_run_touch_strike(lw_run *run, double t, lw_closed *c, double *tiny, double *v, bool *any);

/* Used if the complementarity problem of the forces has no solution, or none is found.  Solve for the impulses over a time h in
 * which free accelerations change the rates by a small fraction; this problem always has a solution.  Impulses
 * proportional to h are forces (c->force, c->rate).  Impulses that remain as h goes to 0 end slips at once at places that do not
 * approach (Painleve); they are applied and *any is set.  LW_NOTHING: no solution was found. */
lw_status lw_run_touch_impulses(lw_run *run, double t, lw_closed *c, double speed, double *v, bool *any);

#endif

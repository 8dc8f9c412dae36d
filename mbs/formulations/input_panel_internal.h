/* mbs/formulations/input_panel_internal.h - the motion of one freedom over a short way of the input, by sixteen values; internal to mbs/.
 *
 * With K the kinetic energy, M(s) the mass and Q the force of the coordinate, dK/ds = Q and dt/ds = sqrt(M/(2 K)).  A panel is as long as
 * its values resolve both. */
#ifndef LW_MBS_FORMULATIONS_INPUT_PANEL_INTERNAL_H
#define LW_MBS_FORMULATIONS_INPUT_PANEL_INTERNAL_H

#include "mbs/reduced/reduced_internal.h"
#include "mbs/run/run_internal.h"
#include "mbs/ode/panel_internal.h"

/* A panel.  s = from + sense length x for 0 <= x <= 1.  A turning panel, which ends where K is 0: s = from - sense length x, x = u^2, with u
 * from `begin` (-1; 0 out of rest) to 1. */
typedef struct lw_input_panel {
    const lw_panel_rule *rule;
    bool   turning;
    double from, sense, length, begin;
    double t, t_end, kinetic, work;          /* at its beginning */
    double mass[LW_PANEL_NODES], force[LW_PANEL_NODES], other[LW_PANEL_NODES];      /* M; Q; the part of Q without potential */
    double rate[LW_PANEL_NODES][LW_LINK_MAX];        /* of the links' turns by s */
    double pace[LW_PANEL_NODES];             /* dt/dx over length, or dt/du */
    double pace_c[LW_PANEL_NODES], time_c[LW_PANEL_NODES];         /* coefficients: pace and its mean; */
    double force_c[LW_PANEL_NODES], other_c[LW_PANEL_NODES];       /* means of Q and `other` */
    bool   ready;                            /* the coefficients are made */
    bool   still[LW_LINK_MAX];               /* the link turns by less than 2 rad in it */
    /* of lw_input_panel_step: */
    double kinetic_end, work_end, next;      /* next: length proposed for the next panel */
    double least_mass, absolute;             /* absolute: error allowed in sqrt(2 K), besides the relative one */
    double cut;                              /* cut: x at which a shorter panel should end; 1: none */
    double force_begin, by_begin;            /* Q and its derivative by K at x = 0 */
    lw_turn_count count;                     /* at x = 0 */
    lw_vec2 reaction[LW_PANEL_NODES][LW_JOINT_MAX];  /* of joints with friction */
} lw_input_panel;

/* Make d->rule ready, once.  LW_E_MEMORY. */
lw_status lw_input_panel_rule(lw_dynamics *d);

/* Note the rates of all links at the registers as those at node i. */
void lw_input_panel_note_rates(lw_input_panel *p, const lw_reduced *r, int i);

/* Turn of body b since the beginning of the panel, accurate enough to tell one revolution from the next.  v: x, or u^2. */
double lw_input_panel_turned(const lw_input_panel *p, int b, double v);

/* Integral of the other forces over the length, from x = 0 to v. */
double lw_input_panel_work(lw_input_panel *p, const lw_reduced *r, double v);

/* The state y of the bodies at t within the panel; turns: of the bodies at its beginning, the first of them and every `stride`-th. */
lw_status lw_input_panel_state(lw_input_panel *p, lw_run *run, lw_reduced *r, double t, const double *turns, int stride, double *y);

/* May a panel begin with this K, which rises by `rise` with the way, where the last steps were in time? */
bool lw_input_panel_suits(const lw_reduced *r, double kinetic, double rise);

/* A panel from (p->from, t, kinetic, work) in the direction p->sense, not beyond `end` (may be infinite), where the forces may depend on the speed, but
 * not on the time.  LW_OPEN: none; K changes too fast, or a panel would be too short. */
lw_status lw_input_panel_step(lw_input_panel *p, lw_run *run, lw_reduced *r, double end);

#endif

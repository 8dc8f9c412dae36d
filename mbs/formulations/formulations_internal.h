/* mbs/formulations/formulations_internal.h - the table of formulations; internal to mbs/. */
#ifndef LW_MBS_FORMULATIONS_FORMULATIONS_INTERNAL_H
#define LW_MBS_FORMULATIONS_FORMULATIONS_INTERNAL_H

#include "mbs/run/run_internal.h"

/* One formulation.  To add one, write a file that defines its row, and add a line to LW_FORMULATION_LIST
 * (mbs/dynamics/dynamics.h).
 *
 * able: can the formulation solve the model of d, and, if asked is false, is it preferred to those after it in the list?
 * LW_OK: yes; r->why gives the reason, r->unknowns the number of unknowns.  Other status: no; r->why gives the reason. */
typedef struct lw_formulation_row {
    lw_status (*able)(lw_dynamics *d, bool asked, lw_dynamics_report *r);
    lw_status (*run)(lw_run *run);
} lw_formulation_row;

#define X(id, name, text) extern const lw_formulation_row lw_formulation_##name;
LW_FORMULATION_LIST(X)
#undef X

/* ---- bodies.c ---------------------------------------------------------------------------------------- */

/* Factor by which (v - rigid) is reduced after an explicit step to (q, v) so that a conservative model without moving
 * constraints keeps its energy; 0 if the correction is greater than the error allowed in a step.  rigid (n_v): a part of v that
 * is not changed, orthogonal to the rest in the metric of the masses; NULL: none. */
double lw_run_held(lw_run *run, const double *q, const double *v, const double *rigid);

/* Correct q and v: first to the momenta of bodies in free flight, then by this factor. */
void lw_run_hold(lw_run *run, double t, double *q, double *v);

/* LW_E_NUMERIC: steps of a multistep method have become so short that the rounding of places over their length hides the velocities, and the run would
 * not end.  h: the step that has led to the state y; *n: such steps in a row, 0 at the start. */
lw_status lw_run_check_rounding(const lw_run *run, double h, const double *y, long *n);

/* Continue from (run->r->t, y) in the coordinates of all bodies.  LW_NOTHING: the least pivot has grown to run->clear, and the run can go on from
 * (run->r->t, y) otherwise. */
lw_status lw_run_go_on(lw_run *run, double *y);

/* The same by cvode, whether the model is stiff or not. */
lw_status lw_run_go_on_implicit(lw_run *run, double *y);

/* A formulation gives up at r->t in the state y, for the reason in run->e: go on by index1, or by cvode where the model is stiff, and report it. */
lw_status lw_run_hand_over(lw_run *run, double *y);

/* May an explicit method begin a run that grows stiff on the way, to be left for an implicit one then? */
bool lw_run_may_leave(lw_dynamics *d);

/* Go on from (run->r->t, y) by index1 with a first step of length *h.  LW_NOTHING: y is the state where the equations became stiff again, *h the
 * mean length of the latest steps; *h = 0: the caller ended the run. */
lw_status lw_run_explicit_from(lw_run *run, double *y, double *h);

/* Does regularised friction limit the steps of w, and is enough left for an implicit method? */
bool lw_run_friction_limits(const lw_run *run, const lw_integrator *w);

/* ---- radau.c ----------------------------------------------------------------------------------------- */

/* Go on from (run->r->t, y) by radau, where explicit steps have the length *h.  LW_NOTHING: y is a state from which these cost less, *h their
 * length; *h = 0: the caller ended the run. */
lw_status lw_run_radau_from(lw_run *run, double *y, double *h);

#endif

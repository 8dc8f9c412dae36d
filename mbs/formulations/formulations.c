/* mbs/formulations/formulations.c - the table of formulations: which one a model takes, and its run. */
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/equilibrium/statics_internal.h"
#include "mbs/formulations/formulations.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const lw_formulation_row *const table[] = {
    [LW_FORMULATION_AUTO] = NULL,
#define X(id, name, text) [LW_FORMULATION_##id] = &lw_formulation_##name,
    LW_FORMULATION_LIST(X)
#undef X
};

/* ---- choice ---------------------------------------------------------------------------------------- */

/* Forward dynamics needs masses; the error names the link that lacks one. */
static lw_status check_masses(lw_dynamics *d)
{
    lw_status s = lw_mbs_rows(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, true);
    if (s == LW_OK)
        s = lw_mbs_solve(d, d->o.from, d->start_q, d->start_v, d->a, d->l, NULL);
    return s != LW_OPEN || !d->eq.more_inertia ? s
         : lw_error_set(d->e, LW_E_NUMERIC, "the accelerations of superelements at the start are not found; their mass matrix has motions of next to "
                        "no mass");
}

/* The formulation asked for: its reason is that, or why it cannot do the model. */
static lw_status take(lw_dynamics *d, lw_formulation f, lw_dynamics_report *r, lw_error *e)
{
    lw_status s = table[f]->able(d, true, r);
    r->formulation = f;
    bool pushed = d->n_friction || d->n_stop || d->touch;
    if (s == LW_OK && d->eq.more_inertia && f != LW_FORMULATION_RADAU && f != LW_FORMULATION_ALPHA && (f != LW_FORMULATION_INDEX1 || pushed))
        s = lw_formulation_say(r, LW_E_KIND, 0, "the mass of superelements and of consistent bars depends on the posture; radau, alpha and, without friction, "
                               "stops and contacts, index1 know that");
    return s == LW_OK ? LW_OK
         : s == LW_E_KIND ? lw_error_set(e, s, "the %s formulation cannot do this model: %s", lw_formulation_name(f),
                                         r->why)
                          : lw_error_set(e, s, "%s", r->why);
}

static lw_status choose(lw_dynamics *d, lw_dynamics_report *r, lw_error *e)
{
    lw_analysis a = d->o.analysis;
    r->freedom = d->freedom + d->n_driven;
    r->redundant = d->n_c - d->rank;
    r->moved = d->moved;
    r->adjusted = d->space ? d->spatial_adjusted.moved : d->adjusted*d->eq.unit;
    r->adjusted_turn = d->spatial_adjusted.turned;
    r->t = d->o.from;
    if (d->elastic && a == LW_ANALYSIS_KINEMATIC)
        return lw_error_set(e, LW_E_KIND, "the motion of elastic links does not follow from the inputs alone: run the model in time "
                            "(dynamic) or --rigid, or see its equilibrium (static, quasistatic)");
    bool settles = d->touch && a == LW_ANALYSIS_STATIC && d->freedom && !d->elastic && !d->large && !d->eq.n_z;
    bool postures = a == LW_ANALYSIS_KINEMATIC || a == LW_ANALYSIS_QUASISTATIC;
    bool prescribed = d->freedom == 0 && !d->elastic && !d->eq.n_z && !d->o.pieces;
    if (d->touch && !settles && (a == LW_ANALYSIS_STATIC || ((postures || d->freedom == 0) && !prescribed)))
        return lw_error_set(e, LW_E_KIND, "contacts, ropes and rigid stops take part in runs in time of models with a freedom, in prescribed motion of "
                            "rigid links without first-order states, and in statics of rigid links with a freedom");
    r->no_friction = !settles && (a == LW_ANALYSIS_STATIC || a == LW_ANALYSIS_QUASISTATIC)
                     && (d->n_friction || lw_mbs_touch_rubs(d) || (d->space && d->space->n_rub));
    if (r->no_friction)
        d->n_friction = 0;
    for (int i = 0; i < d->n_friction; i++)
        d->ideal_friction = d->ideal_friction || d->friction[i].ideal;
    for (int i = 0; d->space && i < d->space->model->n_contact; i++) {
        const lw_friction *f = &d->space->model->joint[d->space->model->contact[i]].friction;
        d->ideal_friction = d->ideal_friction || (f->coefficient > 0 && !(f->speed > 0));
    }
    if (d->eq.n_z && (postures || a == LW_ANALYSIS_STATIC))
        return lw_error_set(e, LW_E_KIND, "the model has first-order states (\"%s\"), whose values this analysis does not know; "
                            "run it in time (dynamic)", d->eq.name(d->eq.context, LW_NAMED_STATE, 0));
    if (settles) {
        lw_status s = check_masses(d);
        return s == LW_OK ? take(d, LW_FORMULATION_INDEX1, r, e) : s;
    }
    if (a == LW_ANALYSIS_STATIC)
        return lw_formulation_say(r, LW_OK, d->freedom, "at rest");
    if (d->elastic && a == LW_ANALYSIS_QUASISTATIC) {
        r->formulation = LW_FORMULATION_DRIVEN;
        return lw_formulation_say(r, LW_OK, d->n_q + d->n_kept, "equilibrium of the elastic links at every moment, without inertia");
    }
    if (postures || (d->freedom == 0 && !d->eq.n_z && !d->o.pieces))
        return take(d, LW_FORMULATION_DRIVEN, r, e);
    lw_status s = d->o.formulation == LW_FORMULATION_DRIVEN ? LW_OK : check_masses(d);
    if (s != LW_OK)
        return s;
    if (d->o.formulation != LW_FORMULATION_AUTO)
        return take(d, d->o.formulation, r, e);
    for (int f = 1; f < (int)(sizeof table/sizeof *table); f++) {
        r->formulation = (lw_formulation)f;
        if (d->o.pieces && (f == LW_FORMULATION_DRIVEN || f == LW_FORMULATION_QUADRATURE || f == LW_FORMULATION_CAPTURE))
            continue;
        s = table[f]->able(d, false, r);
        if (s == LW_OK || s == LW_E_MEMORY)
            return s;
        if (d->elastic && !d->touch && f == LW_FORMULATION_RADAU)
            return lw_error_set(e, LW_E_KIND, "the methods for elastic links cannot do this model: %s; take the rest out, ask for the "
                                "explicit \"index1\" formulation, or make the links rigid (--rigid)", r->why);
    }
    if (d->large) {                          /* no implicit method can: the explicit one takes short steps */
        r->formulation = LW_FORMULATION_INDEX1;
        return table[LW_FORMULATION_INDEX1]->able(d, true, r);
    }
    return lw_error_set(e, LW_E_KIND, "no formulation can do this model");
}

static const double no_determinant = 1e-3;   /* friction equations below it have no solution of use (friction.c) */

/* ---- making and running ---------------------------------------------------------------------------- */

/* The choice for d, which is made ready with status s; frees d when it fails. */
static lw_status finish(lw_dynamics *d, lw_status s, lw_dynamics **out, lw_error *e)
{
    if (s == LW_OK)
        s = choose(d, &d->choice, e);
    if (s != LW_OK) {
        lw_dynamics_free(d);
        return s;
    }
    *out = d;
    return LW_OK;
}

static lw_dynamics *begin(const lw_dynamics_options *o, lw_dynamics **out, lw_error *e)
{
    lw_dynamics *d = calloc(1, sizeof *d);
    *out = NULL;
    if (d)
        d->o = *o;
    else
        lw_error_set(e, LW_E_MEMORY, "out of memory");
    return d;
}

lw_status lw_dynamics_make(const lw_model *m, const lw_dynamics_options *o, lw_dynamics **out, lw_error *e)
{
    lw_error own = { 0 };
    lw_dynamics *d = begin(o, out, e);
    if (!d)
        return LW_E_MEMORY;
    d->given = d->model = m;
    return finish(d, lw_dynamics_prepare(d, e ? e : &own), out, e ? e : &own);
}

lw_status lw_dynamics_make_spatial(const lw_spatial *m, const lw_dynamics_options *o, lw_dynamics **out, lw_error *e)
{
    lw_error own = { 0 };
    lw_dynamics *d = begin(o, out, e);
    return d ? finish(d, lw_dynamics_prepare_spatial(d, m, e ? e : &own), out, e ? e : &own) : LW_E_MEMORY;
}

lw_status lw_dynamics_restart(lw_dynamics *d, double from, double to, const double *q, const double *v, const double *z,
                              lw_error *e)
{
    lw_error own = { 0 };
    d->e = e ? e : &own;
    d->o.from = from;
    d->o.to = to;
    memcpy(d->start_q, q, (size_t)d->n_q*sizeof *q);
    memcpy(d->start_v, v, (size_t)d->n_v*sizeof *v);
    memcpy(d->start_z, z, (size_t)d->eq.n_z*sizeof *z);
    d->eq.place_states(d->eq.context, z);
    if (!d->space)
        d->eq.exact = lw_planar_exact(&d->planar);           /* forces of the caller's may have come or gone */
    free(d->reduced);
    d->reduced = NULL;
    d->decay_known = d->ideal_friction = false;
    d->choice = (lw_dynamics_report){ 0 };
    lw_status s = lw_mbs_arrange(d, from, q);
    return s == LW_OK ? choose(d, &d->choice, d->e) : s;
}

/* Is the start of a model in space, if it is the posture of the file, singular for its joints? */
static bool starts_singular(const lw_dynamics *d)
{
    return d->space && memcmp(d->start_q, d->space->s.start, (size_t)d->n_q*sizeof *d->start_q) == 0 && lw_space_lost_freedoms(&d->space->follow) > 0;
}

/* lw_run.leave_stiff: cvode where there is a rigid stop, else radau and index1 in turn. */
static lw_status leave_stiff(lw_run *run, double *y, double length)
{
    lw_dynamics_report *r = run->r;
    const bool radau = run->returns;
    snprintf(r->why, sizeof r->why, "%s to t = %.3g s, where the equations became stiff, then an implicit method%s", lw_formulation_name(r->formulation), r->t,
             radau ? ", or index1 where that costs less" : "");
    r->formulation = radau ? LW_FORMULATION_RADAU : LW_FORMULATION_CVODE;
    size_t said = strlen(r->why);
    lw_status s = radau ? lw_run_radau_from(run, y, &length) : lw_run_go_on_implicit(run, y);
    for (int changes = 2; s == LW_NOTHING && length > 0; changes++) {    /* the caller ends a run by LW_NOTHING, too */
        snprintf(r->why + said, sizeof r->why - said, "; %d changes, the last one at t = %.3g s", changes, r->t);
        bool back = r->formulation == LW_FORMULATION_RADAU;
        run->n_back += back;
        r->formulation = back ? LW_FORMULATION_INDEX1 : LW_FORMULATION_RADAU;
        s = back ? lw_run_explicit_from(run, y, &length) : lw_run_radau_from(run, y, &length);
    }
    return s;
}

/* One run by the formulation of run->r; what it ended on is in run->e. */
static lw_status run_one(lw_run *run)
{
    lw_dynamics *d = run->d;
    lw_dynamics_report *r = run->r;
    run->has_work = !d->eq.conservative || d->n_driven || d->n_friction || d->n_stop || d->touch;
    run->n = d->n_q + d->n_v + run->has_work + d->eq.n_z;
    run->pivot_tried = 1;
    run->returns = lw_formulation_radau.able(d, true, &(lw_dynamics_report){ 0 }) == LW_OK;
    run->n_jumped = run->n_near = 0;
    run->jumps_t = -INFINITY;
    d->least_determinant = 1;
    d->jams = false;
    r->smooth_friction = d->ideal_friction && r->formulation != LW_FORMULATION_DRIVEN &&
                         r->formulation != LW_FORMULATION_REDUCED &&
                         !(r->formulation == LW_FORMULATION_INDEX1 && lw_stick_suits(d));
    if (d->eq.next_piece)
        d->eq.next_piece(d->eq.context, d->start_q, d->start_v, true);
    bool equilibria = d->elastic && d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    lw_status s = equilibria ? lw_statics_run_large(run) : table[r->formulation]->run(run);
    free(run->behind);
    run->behind = NULL;
    if (s == LW_OPEN && run->apart > 0 && run->apart < 1e-5)
        s = lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s two motion curves come within %.1e of the size of the "
                         "linkage, and it is undecided which of them goes on%s", r->t, run->apart, run->apart > 1e-8
                         ? "" : ": if they should meet, write the posture with more digits or give a greater "
                         "tolerance");
    bool lost = s == LW_OPEN && d->least_determinant < no_determinant;
    if ((s == LW_E_NUMERIC || lost) && d->n_friction && (d->weak < LW_SINGULAR_NEAR || run->jam != 0))
        s = d->least_determinant < no_determinant
          ? lw_error_set(run->e, s, "at t = %.9g s friction jams the linkage: near a singular posture reactions grow without limit, "
                         "and the equations of friction lose their solution (least pivot %.2g; 1 without friction: Painleve's "
                         "paradox); %s", r->t, fmax(0, d->least_determinant), d->o.formulation == LW_FORMULATION_AUTO
                         ? "no formulation goes on from there; lower the coefficient or the radius of the pins, or drive the "
                         "linkage through the posture" : "another formulation may go on (auto tries them all)")
          : lw_error_set(run->e, s, "at t = %.9g s, near a singular posture with friction, no step is short enough to go on", r->t);
    if (s == LW_E_NUMERIC && r->samples <= 1 && starts_singular(d))
        s = lw_error_set(run->e, s, "the posture at the start is singular: from there the linkage can go on in several ways; start it from a "
                         "posture nearby");
    else if (s == LW_E_NUMERIC && d->has_zero_mass && r->formulation != LW_FORMULATION_DRIVEN && !d->n_friction && !d->touch && !run->jam && run->e->text[0]) {
        char text[sizeof run->e->text];
        memcpy(text, run->e->text, sizeof text);
        lw_error_set(run->e, s, "%.300s; some links have no mass or no inertia: if they alone move there, they would do so infinitely fast. "
                     "With small masses, 1e-6 of the others, the run may go on", text);
    }
    if (s == LW_OPEN && run->e->status == LW_OPEN && run->e->text[0])        /* rates that failed where a step begins */
        s = run->e->status = LW_E_NUMERIC;
    if (s == LW_OPEN)
        s = lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the linkage stands in a singular posture, from "
                         "which it can go on in several ways", r->t);
    if (s == LW_OK && r->samples != d->o.intervals + 1L)
        s = lw_error_set(run->e, LW_E_NUMERIC, "the run ended at t = %.9g s after %ld of %ld samples", r->t, r->samples,
                         d->o.intervals + 1L);
    if (s < 0 && !run->e->text[0])
        lw_error_set(run->e, s, "the run ended at t = %.9g s: %s", r->t, lw_status_text(s));
    return s;
}

/* Run again from the start by the formulation of *next; run: sink, context and rows shown. */
static lw_status run_again(lw_run *run, const char *why, lw_dynamics_report *next, lw_error *e)
{
    lw_dynamics *d = run->d;
    lw_formulation f = next->formulation;
    *next = d->choice;
    next->formulation = f;
    snprintf(next->why, sizeof next->why, "%s", why);
    run->r = next;
    d->e = run->e = e;
    for (int i = 0; i < d->n_stop; i++)
        d->stop[i].resting = false;
    d->n_resting = 0;
    d->eq.place_states(d->eq.context, d->start_z);
    lw_status s = lw_mbs_arrange(d, d->o.from, d->start_q);
    return s == LW_OK ? run_one(run) : s;
}

/* A run like this one that has not begun. */
static lw_run from_start(const lw_run *run, lw_moment_sink *sink, void *context)
{
    return (lw_run){ .d = run->d, .sink = sink, .context = context, .leave_stiff = leave_stiff,
                     .sides = run->sides, .pulses = run->pulses, .kinks = run->kinks };
}

typedef struct ending { double *q; int n; } ending;

static lw_status keep_posture(void *context, const lw_moment *m)
{
    const ending *end = context;
    memcpy(end->q, m->q, (size_t)end->n*sizeof *m->q);
    return LW_OK;
}

/* May the formulation replace the one that gave up?  It may have stepped over a singular posture in which the other rightly stopped, and
 * what follows is then chance.  So its last posture has to agree with that at ten times the tolerance, within `agree` of that tolerance.
 * LW_E_NUMERIC: it does not. */
static lw_status confirm(const lw_run *run, lw_formulation f, const char *why)
{
    static const double agree = 1e3, most = 1e-2;
    lw_dynamics *d = run->d;
    const lw_dynamics_options given = d->o;
    const size_t n = (size_t)d->n_q;
    double *q = malloc((2*n + 1)*sizeof *q), off = 0;
    if (!q)
        return LW_E_MEMORY;
    lw_status s = LW_OK;
    for (int k = 0; s == LW_OK && k < 2; k++) {
        ending end = { q + (size_t)k*n, d->n_q };
        lw_error e = { 0 };
        lw_dynamics_report r = { .formulation = f };
        lw_run dry = from_start(run, keep_posture, &end);
        d->o.relative = given.relative*(k ? 1 : 10), d->o.absolute = given.absolute*(k ? 1 : 10);
        s = run_again(&dry, why, &r, &e);
    }
    d->o.relative = given.relative, d->o.absolute = given.absolute;
    for (size_t i = 0; s == LW_OK && i < n; i++)
        off = fmax(off, fabs(q[n + i] - q[i]));
    free(q);
    return s != LW_OK ? s : off <= fmin(agree*10*fmax(given.relative, given.absolute), most) ? LW_OK : LW_E_NUMERIC;
}

/* The formulation chosen by itself has given up: run again from the start by the others, without the samples handed out
 * already, which they have to go on from.  If none reaches the end, e and run->r keep what the first one ended on. */
static lw_status run_others(lw_run *run, lw_status s)
{
    lw_dynamics *d = run->d;
    lw_dynamics_report first = *run->r, next;
    lw_error said = *run->e, *e_run = run->e;
    long steps = d->o.max_step;
    char why[sizeof first.why];
    snprintf(why, sizeof why, "%s gave up at t = %.9g s", lw_formulation_name(first.formulation), first.t);
    const int n = sizeof table/sizeof *table - LW_FORMULATION_REDUCED, begin = lw_mbs_is_stiff(d) ? LW_FORMULATION_CVODE - LW_FORMULATION_REDUCED : 0;
    for (int k = 0; k < n && s == LW_E_NUMERIC && !run->refused; k++) {      /* explicit ones last where they would take long */
        int f = LW_FORMULATION_REDUCED + (begin + k)%n;
        next = d->choice;
        next.formulation = (lw_formulation)f;
        if (f == (int)first.formulation || f == LW_FORMULATION_CAPTURE || f == LW_FORMULATION_RADAU || f == LW_FORMULATION_ALPHA
            || table[f]->able(d, true, &next) != LW_OK)
            continue;
        lw_error e = { 0 };
        d->o.max_step = steps > 0 ? steps : 1000000;
        lw_status other = confirm(run, (lw_formulation)f, why);
        if (other == LW_E_MEMORY)
            s = lw_error_set(&said, other, "out of memory");
        if (other != LW_OK)
            continue;
        lw_run again = from_start(run, run->sink, run->context);
        again.shown = run->shown;
        again.last_shown = run->last_shown;
        other = run_again(&again, why, &next, &e);
        run->shown = next.samples > run->shown ? next.samples : run->shown;
        run->refused = again.refused;
        if (other == LW_OK || other == LW_E_MEMORY || again.refused) {
            *run->r = next;
            *run->e = e;
            s = other;
        }
    }
    d->o.max_step = steps;
    d->e = e_run;
    if (s == LW_E_NUMERIC || (s == LW_E_MEMORY && said.text[0]))
        *run->r = first, *run->e = said;
    return s;
}

lw_status lw_dynamics_run(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e)
{
    lw_error own = { 0 };
    lw_run run = { .d = d, .sink = sink, .context = context, .leave_stiff = leave_stiff, .r = r, .e = e ? e : &own };
    *r = d->choice;
    if (r->formulation == LW_FORMULATION_AUTO)
        return lw_error_set(e, LW_E_ARG, "a static analysis has no run");
    if (!(d->o.from < d->o.to))
        return lw_error_set(e, LW_E_ARG, "a run in time needs from < to");
    d->e = run.e;
    for (int i = 0; i < d->n_driven; i++) {
        const lw_expression *motion = d->space ? d->space->model->input[d->driven[i]].motion : d->model->motion[d->driven[i]];
        if (lw_motion_check(motion, lw_dynamics_input_name(d, d->driven[i]), d->o.from, d->o.to, run.e) != LW_OK)
            return LW_E_ARG;
    }
    bool others = d->o.formulation == LW_FORMULATION_AUTO && r->formulation != LW_FORMULATION_DRIVEN && !d->space && !d->large
               && !d->touch && !d->o.pieces;
    if (others && !(run.last_shown = malloc((size_t)d->n_q*sizeof *run.last_shown)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (d->eq.n_jump && !(run.sides = calloc(2*(size_t)(d->eq.n_switch + d->n_v) + 3*(size_t)d->eq.n_z + (size_t)d->eq.n_jump, sizeof *run.sides))) {
        free(run.last_shown);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    lw_status s = lw_run_make_pulses(&run);
    if (s == LW_OK && (s = lw_kinks_make(&d->eq, &run.kinks)) != LW_OK)
        lw_error_set(run.e, s, "out of memory");
    if (s == LW_OK)
        s = run_one(&run);
    if ((s == LW_E_ARG || s == LW_E_KIND) && (r->t > d->o.from || r->samples > 0))      /* the model ran until here */
        s = run.e->status = LW_E_NUMERIC;
    run.shown = r->samples;
    if (s == LW_E_NUMERIC && others && !run.refused)
        s = run_others(&run, s);
    free(run.last_shown);
    free(run.sides);
    lw_run_free_pulses(&run);
    lw_kinks_free(run.kinks);
    return s;
}

/* mbs/clearance/clearance_run.c - motion with clearance from 0 to the end, with contact made and lost. */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/clearance/clearance_internal.h"
#include "mbs/equations/limits_internal.h"
#include "mbs/ode/integrate.h"

#define LOOKS 8                          /* places in a step at which forces of a contact and the criterion of `zero` are taken */

/* Greatest error of a step: parts of the gap, and of the depth over which damping grows. */
#define FINEST_GAP   2e-3
#define FINEST_DEPTH 0.1

/* Events of journal i: contact at 2i, full damping at 2i + 1; those of the stops follow. */
enum { CONTACT, FULL, PER_JOURNAL };

/* ---- callbacks of the integrator ----------------------------------------------------------------- */

static lw_status rate_of(void *context, double t, const double *y, double *dy)
{
    lw_clearance_work *w = context;
    memcpy(dy, y + w->n_u, sizeof(double)*(size_t)w->n_u);
    return lw_clearance_accelerate(w, t, y, y + w->n_u, dy + w->n_u);
}

static lw_status put_back(void *context, double t, double *y)
{
    lw_clearance_work *w = context;
    return lw_clearance_project(w, &w->rows, t, y, y + w->n_u);
}

/* Gaps of stops, scaled; pressure of those that are rested on */
static void find_stop_events(lw_clearance_work *w, double *g)
{
    if (w->c->n_stop == 0)
        return;
    lw_tree_write(&w->c->tree, &w->state, NULL, w->q, NULL);
    for (int i = 0; i < w->c->n_stop; i++)
        g[i] = w->rows.stop[i] ? lw_clearance_stop_press(w, i)
                              : lw_rigid_stop_gap(&w->c->s, &w->stop[i], w->q, NULL);
}

static int strobe_event(const lw_clearance_scene *c)
{
    return PER_JOURNAL*c->n_journal + c->n_stop;
}

static bool has_strobe(const lw_clearance_work *w)
{
    return w->o.strobe && w->c->s.n_input > 0;
}

/* 0 where input 0 is back at its start; the state is placed */
static double round_trip(lw_clearance_work *w)
{
    const lw_system *s = &w->c->s;
    lw_tree_write(&w->c->tree, &w->state, NULL, w->q, NULL);
    double value = lw_system_measure(s, s->input_joint[0], w->q, NULL);
    return lw_joint_turns(s->joint[s->input_joint[0]].kind) ? sin(0.5*value) : value;
}

/* Posture and velocities of the bodies at y = (u, du) */
static void place_bodies(lw_clearance_work *w, const double *y)
{
    lw_tree_place(&w->c->tree, y, y + w->n_u, &w->state);
    lw_tree_write(&w->c->tree, &w->state, y + w->n_u, w->q, w->v);
}

/* Depth in gaps; for a link the pull of the pin in newtons (contact is lost when it would have to push) */
static lw_status find_events(void *context, double t, const double *y, double *g)
{
    lw_clearance_work *w = context;
    const lw_clearance_scene *c = w->c;
    bool forces = false;
    for (int i = 0; i < c->n_journal; i++)
        forces = forces || w->rows.link[i];
    for (int i = 0; i < c->n_stop; i++)
        forces = forces || w->rows.stop[i];
    lw_status s = LW_OK;
    if (forces) {
        double trash[LW_SYSTEM_Q_MAX];
        s = lw_clearance_accelerate(w, t, y, y + w->n_u, trash);
    } else
        lw_tree_place(&c->tree, y, NULL, &w->state);
    for (int i = 0; i < c->n_journal; i++) {
        const lw_clearance *law = c->journal[i].c;
        lw_play p = lw_clearance_play(w, i, NULL);
        double depth = lw_v2_norm(p.d)*c->s.unit - law->gap;
        g[PER_JOURNAL*i + CONTACT] = w->rows.link[i] ? lw_clearance_press(w, i, &p)
                                 : w->rows.hold[i] ? 1.0 : depth/law->gap;
        g[PER_JOURNAL*i + FULL] = lw_contact_rises(law) ? (depth - law->depth)/law->gap : -1.0;
    }
    find_stop_events(w, g + PER_JOURNAL*c->n_journal);
    if (has_strobe(w))
        g[strobe_event(c)] = round_trip(w);
    if (w->kinks) {
        place_bodies(w, y);
        g[strobe_event(c) + has_strobe(w)] = lw_kinks_ahead(w->kinks, t, w->q, w->v);
    }
    return s;
}

/* ---- book-keeping -------------------------------------------------------------------------------- */

static void note_contact(lw_clearance_work *w, int i, double t, bool touching)
{
    lw_clearance_outcome *o = &w->r->joint[i];
    if (touching == w->touching[i])
        return;
    w->touching[i] = touching;
    if (touching) {
        if (w->settled)
            o->apart += t - fmax(w->since[i], w->o.settle);
        return;
    }
    w->since[i] = t;
    if (w->settled) {
        o->losses++;
        o->first = o->lost ? o->first : t;
        o->lost = true;
    }
}

static void settle(lw_clearance_work *w, double t)
{
    w->settled = true;
    for (int i = 0; i < w->c->n_journal; i++)
        if (!w->touching[i]) {
            w->r->joint[i].lost = true;
            w->r->joint[i].first = t;
        }
}

static double energy(lw_clearance_work *w, const double *y)
{
    const lw_clearance_scene *c = w->c;
    lw_tree_place(&c->tree, y, y + w->n_u, &w->state);
    lw_tree_write(&c->tree, &w->state, y + w->n_u, w->q, w->v);
    double sum = lw_forces_kinetic(&c->f, w->v) + lw_forces_potential(&c->f, w->q);
    for (int i = 0; i < c->n_journal; i++) {
        const lw_clearance *law = c->journal[i].c;
        lw_play p = lw_clearance_play(w, i, NULL);
        if (!w->rows.hold[i] && !w->rows.link[i])
            sum += lw_contact_energy(law, w->phase[i], lw_v2_norm(p.d)*c->s.unit - law->gap);
    }
    return sum;
}

/* Value and rate of input 0 at the placed state with w->q, w->v written. */
static void read_input(lw_clearance_work *w, double *value, double *rate)
{
    const lw_system *s = &w->c->s;
    *value = *rate = 0.0;
    if (s->n_input == 0)
        return;
    double scale = lw_system_joint_unit(s, s->input_joint[0]);
    *value = s->input_value[0] + scale*lw_system_measure(s, s->input_joint[0], w->q, w->row);
    for (int k = 0; k < s->n_q; k++)
        *rate += scale*w->row[k]*w->v[k];
}

static void read_point(lw_clearance_work *w, int i, const double *du, lw_clearance_point *p)
{
    const lw_journal *j = &w->c->journal[i];
    lw_play play = lw_clearance_play(w, i, du);
    double r = lw_v2_norm(play.d), unit = w->c->s.unit;
    p->joint = j->joint;
    p->pin = lw_v2_scale(play.d, unit);
    p->in_bush = lw_v2_unturn(p->pin, w->state.dir[j->body[0] + 1]);
    p->rate = r > 0.0 ? lw_v2_dot(play.d, play.rate)/r*unit : 0.0;
    p->force = lw_clearance_press(w, i, &play);
    p->touching = w->touching[i];
}

static lw_status sample_at(lw_clearance_work *w, lw_clearance_sink *sink, double t, const double *y)
{
    lw_clearance_sample s = { .t = t, .n_point = w->c->n_journal };
    lw_status status = rate_of(w, t, y, w->rate);
    if (status != LW_OK)
        return status;
    for (int i = 0; i < s.n_point; i++)
        read_point(w, i, y + w->n_u, &s.point[i]);
    s.energy = energy(w, y);
    read_input(w, &s.input, &s.input_rate);
    return sink(w->o.context, &s);
}

/* Take the extremes of a joint at k/LOOKS of the step; *most: the greatest force so far of this step. */
static lw_status look(lw_clearance_work *w, lw_integrator *in, int i, int k, double *most)
{
    lw_clearance_outcome *o = &w->r->joint[i];
    double t = in->t_old + (in->t - in->t_old)*k/LOOKS;
    const double *y = k < LOOKS ? w->y : in->y;
    lw_status s = k < LOOKS ? lw_integrate_dense(in, t, w->y) : LW_OK;
    if (s != LW_OK)
        return s;
    place_bodies(w, y);
    if (w->rows.link[i])
        s = rate_of(w, k < LOOKS ? t : in->t, y, w->rate);
    lw_play p = lw_clearance_play(w, i, y + w->n_u);
    *most = fmax(*most, lw_clearance_press(w, i, &p));
    o->force_most = fmax(o->force_most, *most);
    if (!w->rows.link[i] || k == LOOKS)          /* a link keeps its length, its interpolated posture does not */
        o->distance_most = fmax(o->distance_most, lw_v2_norm(p.d)*w->c->s.unit);
    return s;
}

/* After a step: extremes, within it where there is contact, the criterion of Earles & Wu, speed of the input. */
static lw_status take_step(lw_clearance_work *w, lw_integrator *in)
{
    const lw_clearance_scene *c = w->c;
    double value, rate;
    lw_status s = LW_OK;
    place_bodies(w, in->y);
    read_input(w, &value, &rate);
    w->r->speed_least = fmin(w->r->speed_least, rate);
    w->r->speed_most = fmax(w->r->speed_most, rate);
    for (int i = 0; s == LW_OK && i < c->n_journal; i++) {
        lw_clearance_outcome *o = &w->r->joint[i];
        if (w->rows.hold[i])
            for (int k = 1; s == LW_OK && k <= LOOKS; k++) {
                lw_vec2 f, df;
                double t = in->t_old + (in->t - in->t_old)*k/LOOKS;
                s = lw_integrate_dense(in, t, w->y);
                if (s == LW_OK)
                    s = lw_clearance_reaction_rate(w, t, w->y, i, &f, &df);
                if (s != LW_OK)
                    break;
                double size = lw_v2_norm(f), turn = fabs(lw_v2_cross(f, df))/(size*size*size);
                o->force_most = fmax(o->force_most, size);
                o->criterion = fmax(o->criterion, turn);
                if (turn > 1.0 && !o->lost) {
                    o->lost = true;
                    o->first = t;
                }
            }
        else {
            double most = w->pressed[i], end = 0;
            s = look(w, in, i, LOOKS, &end);
            w->pressed[i] = end;
            most = fmax(most, end);
            for (int k = 1; s == LW_OK && k < LOOKS && most > 0.25*o->force_most && w->phase[i] != LW_CONTACT_APART; k++)
                s = look(w, in, i, k, &most);
        }
    }
    return s;
}

/* ---- events -------------------------------------------------------------------------------------- */

/* Next phase of a journal: contact made or lost, full damping reached or left. */
static void change_phase(lw_clearance_work *w, const lw_integrator *in, int i)
{
    const lw_clearance *law = w->c->journal[i].c;
    bool contact = in->side[PER_JOURNAL*i + CONTACT] > 0, full = in->side[PER_JOURNAL*i + FULL] > 0;
    lw_contact_phase next = !contact ? LW_CONTACT_APART : full || !lw_contact_rises(law) ? LW_CONTACT_FULL
                          : LW_CONTACT_RISING;
    if (w->phase[i] == LW_CONTACT_APART && next != LW_CONTACT_APART) {
        lw_tree_place(&w->c->tree, in->y, in->y + w->n_u, &w->state);
        lw_play p = lw_clearance_play(w, i, in->y + w->n_u);
        w->struck[i] = fabs(lw_v2_dot(p.d, p.rate))/lw_v2_norm(p.d)*w->c->s.unit;
    }
    w->phase[i] = next;
    note_contact(w, i, in->t, contact);
}

/* Events that change no law are handled at their own time. */
static void passed(void *context, int event, double t, const double *y)
{
    lw_clearance_work *w = context;
    w->r->events++;
    if (event != strobe_event(w->c)) {
        note_contact(w, event/PER_JOURNAL, t, !w->touching[event/PER_JOURNAL]);
        return;
    }
    lw_tree_place(&w->c->tree, y, NULL, &w->state);
    if (fabs(round_trip(w)) < 1e-7)      /* else it is the start, where rounding chose a side */
        sample_at(w, w->o.strobe, t, y);
}

/* ---- the run ------------------------------------------------------------------------------------- */

/* Fastest rate of the scene [1/s]: of a contact's stiffness with the mass that moves with it, or the speeds. */
static double quickest(lw_clearance_work *w, const double *u, const double *du)
{
    const lw_clearance_scene *c = w->c;
    double most = 0.0, speed = 1e-3;
    for (int i = 0; i < c->n_journal; i++)
        if (!w->rows.hold[i] && !w->rows.link[i])
            most = fmax(most, c->journal[i].c->stiffness*lw_clearance_compliance(w, i, u, du));
    for (int k = 0; k < w->n_u; k++)
        speed = fmax(speed, fabs(du[k]));
    return fmax(sqrt(most), speed);
}

static void choose_rows(lw_clearance_work *w)
{
    for (int i = 0; i < w->c->n_journal; i++) {
        w->rows.hold[i] = w->c->journal[i].c->model == LW_CLEARANCE_ZERO;
        w->rows.link[i] = w->c->journal[i].c->model == LW_CLEARANCE_LINK;
    }
    for (int i = 0; i < w->c->s.n_input; i++)
        w->rows.input[i] = w->c->m->motion[i] != NULL;
}

static void clear_result(lw_clearance_work *w, lw_clearance_result *r)
{
    *r = (lw_clearance_result){ .n_joint = w->c->n_journal, .speed_least = INFINITY, .speed_most = -INFINITY };
    w->r = r;
    for (int i = 0; i < r->n_joint; i++) {
        r->joint[i].joint = w->c->journal[i].joint;
        r->joint[i].first = NAN;
    }
}

static lw_ode equations(lw_clearance_work *w)
{
    const lw_clearance_scene *c = w->c;
    lw_ode ode = { .n = 2*w->n_u, .context = w, .rate = rate_of, .seen = passed };
    bool any = c->n_stop > 0 || has_strobe(w) || w->kinks;
    for (int i = 0; i < c->n_journal; i++) {
        bool smooth = c->journal[i].c->model == LW_CLEARANCE_MLSD || w->rows.link[i];
        any = any || !w->rows.hold[i];
        ode.passing[PER_JOURNAL*i + CONTACT] = smooth;
    }
    if (any) {
        ode.passing[strobe_event(c)] = has_strobe(w);
        ode.n_event = strobe_event(c) + has_strobe(w);
        if (w->kinks)
            ode.direction[ode.n_event++] = -1;
        ode.event = find_events;
    }
    ode.project = lw_clearance_count_rows(c, &w->rows) > 0 || c->n_stop > 0 ? put_back : NULL;
    return ode;
}

static lw_status sample_step(lw_clearance_work *w, lw_integrator *in, double *next)
{
    lw_status s = LW_OK;
    while (s == LW_OK && w->o.sink && w->o.every > 0.0 && *next <= in->t*(1.0 + 1e-14)) {
        s = lw_integrate_dense(in, *next, w->y);
        if (s == LW_OK)
            s = put_back(w, *next, w->y);
        if (s == LW_OK)
            s = sample_at(w, w->o.sink, *next, w->y);
        *next += w->o.every;
    }
    return s;
}

/* Apply impacts, rests and departures of stops */
static lw_status take_strikes(lw_clearance_work *w, lw_integrator *in, unsigned long long events, lw_error *e)
{
    double flight, least = 2e-14*fmax(fabs(in->t), 1e-6);
    memcpy(w->y, in->y, 2*sizeof(double)*(size_t)w->n_u);
    lw_status s = lw_clearance_strike(w, in->t, w->y, events, &flight, e);
    if (s == LW_OK)
        s = lw_integrate_restart(in, w->y, e);
    if (s == LW_OK && flight > 0.0)
        in->h = fmin(in->h, fmax(0.5*flight, least));
    w->r->events++;
    return s;
}

/* The integrator has just ended a step at an event that changes the laws of contact and so the equations.  First it
 * finds on which side of each event the motion goes on: a pin that only grazes its bush has no contact, and keeps no
 * law of contact. */
static lw_status take_events(lw_clearance_work *w, lw_integrator *in, lw_error *e)
{
    unsigned long long events = in->events;
    in->h = fmin(in->h, 1.0/w->quickest);                    /* steps of free flight are too long for a contact */
    unsigned long long stops = events >> PER_JOURNAL*w->c->n_journal & ~(~0ull << w->c->n_stop);
    lw_status s = stops ? take_strikes(w, in, stops, e) : lw_integrate_restart(in, NULL, e);
    for (int i = 0; i < w->c->n_journal; i++)
        if (!in->ode->passing[PER_JOURNAL*i + CONTACT] && (events >> (PER_JOURNAL*i) & ((1u << PER_JOURNAL) - 1u))) {
            change_phase(w, in, i);
            w->r->events++;
        }
    return s == LW_OK ? rate_of(w, in->t, in->y, in->dy) : s;
}

/* Begin anew behind a kink of the functions of time, where forces may have jumped: a stop that would have to pull is left. */
static lw_status pass_kink(lw_clearance_work *w, lw_integrator *in, lw_error *e)
{
    in->t = lw_timed_behind(&w->timed);
    in->t_low = 0;
    lw_status s = w->c->n_stop ? take_strikes(w, in, 0, e) : lw_integrate_restart(in, NULL, e);
    for (int i = 0; i < w->c->n_journal; i++)
        if (w->rows.link[i])
            note_contact(w, i, in->t, in->side[PER_JOURNAL*i + CONTACT] > 0);
    return s;
}

/* After a step: apply the events of contact and stops at its end, and begin anew behind a kink or jump of the forces. */
static lw_status end_step(lw_clearance_work *w, lw_integrator *in, bool event, lw_error *e)
{
    unsigned long long kink = w->kinks ? 1ull << (in->ode->n_event - 1) : 0, events = event ? in->events : 0;
    if (w->kinks)
        place_bodies(w, in->y);
    bool passed = w->kinks && lw_kinks_pass(w->kinks, in->t, w->q, w->v, events & kink);
    return events & ~kink ? take_events(w, in, e) : passed ? lw_integrate_restart(in, NULL, e) : LW_OK;
}

static void expressions(void *context, lw_expression_sink *see, void *of) { lw_model_expressions(context, see, of); }

static lw_status run_until(lw_clearance_work *w, lw_integrator *in, double t_end, double *next, lw_error *e)
{
    while (in->t < t_end) {
        lw_ode_stop stop;
        lw_status s = lw_limits_check(w->o.stop, w->o.until, in->n_step%256 == 0, in->t, e);
        if (s == LW_OK)
            s = lw_integrate_step(in, fmin(t_end, lw_timed_end(&w->timed, in->t)), &stop, e);
        if (s != LW_OK)
            return s;
        s = sample_step(w, in, next);
        if (s == LW_OK && w->settled)
            s = take_step(w, in);
        if (s != LW_OK)
            return lw_error_set(e, s, "the motion with clearance ends at t = %.9g s: %s", in->t, lw_status_text(s));
        if ((s = end_step(w, in, stop == LW_ODE_EVENT, e)) != LW_OK)
            return s;
        if (lw_timed_at_kink(&w->timed, in->t) && (s = pass_kink(w, in, e)) != LW_OK)
            return s;
    }
    return LW_OK;
}

static void finish(lw_clearance_work *w, const lw_integrator *in)
{
    lw_clearance_result *r = w->r;
    r->t = in->t;
    r->steps = in->n_step, r->refused = in->n_refused, r->rates = in->n_rate;
    r->energy_last = energy(w, in->y);
    for (int i = 0; i < r->n_joint; i++) {
        double time = in->t - w->o.settle;
        if (w->settled && !w->touching[i])
            r->joint[i].apart += in->t - fmax(w->since[i], w->o.settle);
        r->joint[i].apart = time > 0.0 ? r->joint[i].apart/time : 0.0;
    }
}

/* Error of a step in sizes of the linkage: as asked for, but small beside the gap and beside the depth over which
 * damping grows. */
static double error_allowed(const lw_clearance_work *w)
{
    double e = w->o.tolerance, unit = w->c->s.unit;
    for (int i = 0; i < w->c->n_journal; i++) {
        const lw_clearance *law = w->c->journal[i].c;
        if (w->rows.hold[i])
            continue;
        e = fmin(e, law->gap*FINEST_GAP/unit);
        if (lw_contact_rises(law))
            e = fmin(e, law->depth*FINEST_DEPTH/unit);
    }
    return e;
}

/* Tolerances of places and rates; the start; the first sample. */
static lw_status prepare(lw_clearance_work *w, double *each, lw_error *e)
{
    choose_rows(w);
    double *u = each + 2*w->n_u, *du = u + w->n_u;           /* scratch for the start */
    lw_status s = lw_clearance_begin(w, u, du, e);
    if (s != LW_OK)
        return s;
    double flight;
    if ((s = lw_clearance_strike(w, 0.0, u, 0, &flight, e)) != LW_OK)
        return s;
    memcpy(w->y, u, 2*sizeof(double)*(size_t)w->n_u);
    if (rate_of(w, 0.0, w->y, w->rate) == LW_E_NUMERIC && w->undetermined.status == LW_OK)
        return lw_error_set(e, LW_E_NUMERIC, "no mass moves with link \"%s\" alone, so its motion is not determined: "
                            "give it mass and inertia",
                            w->c->m->linkage.link_name[w->c->s.link[lw_clearance_lightest(w, u)]]);
    double rate = w->quickest = quickest(w, u, du), allowed = error_allowed(w);
    for (int k = 0; k < w->n_u; k++) {
        each[k] = allowed;
        each[w->n_u + k] = allowed*rate;
    }
    w->r->energy_first = energy(w, w->y);
    for (int i = 0; i < w->c->n_journal; i++)
        w->touching[i] = w->rows.hold[i] || w->rows.link[i] || w->c->journal[i].c->model == LW_CLEARANCE_MLSD
                      || w->phase[i] != LW_CONTACT_APART;
    return LW_OK;
}

static lw_status run(lw_clearance_work *w, double *memory, lw_error *e)
{
    double *each = memory, *start = memory + 2*w->n_u, *work = memory + 4*w->n_u, next = 0.0;
    lw_status s = prepare(w, each, e);
    if (s != LW_OK)
        return s;
    lw_integrator in;
    lw_ode ode = equations(w);
    lw_ode_options o = { .absolute_each = each, .max_step = w->o.max_step };
    w->timed = (lw_timed){ .expressions = expressions, .context = (void *)w->c->m, .to = w->o.time };
    if (w->kinks) {
        place_bodies(w, start);
        lw_kinks_start(w->kinks, each[0], 0.0, w->q, w->v);
    }
    s = lw_integrate_start(&in, &ode, &o, work, 0.0, start, e);
    if (s == LW_OK && w->o.sink && w->o.every > 0.0) {
        s = sample_at(w, w->o.sink, 0.0, in.y);
        next = w->o.every;
    }
    if (s != LW_OK)
        return s;
    double first = fmin(w->o.settle, w->o.time);
    s = first > 0.0 ? run_until(w, &in, first, &next, e) : LW_OK;
    if (s == LW_OK && in.t >= w->o.settle) {
        settle(w, in.t);
        s = run_until(w, &in, w->o.time, &next, e);
    }
    finish(w, &in);
    return s;
}

lw_status lw_clearance_run(const lw_clearance_scene *scene, const lw_clearance_options *o, lw_clearance_result *r, lw_error *e)
{
    lw_clearance_work w;
    if (!(o->time > 0.0) || !(o->settle >= 0.0) || !(o->tolerance > 0.0))
        return lw_error_set(e, LW_E_ARG, "a run with clearance needs a time and a tolerance above 0, and a time to settle of 0 or more");
    if (lw_clearance_work_make(scene, o, &w) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a run with clearance");
    size_t n = 2*(size_t)w.n_u;
    double *memory = calloc(2*n + lw_integrate_work((int)n, strobe_event(scene) + 2), sizeof *memory);
    clear_result(&w, r);
    lw_status s = memory ? run(&w, memory, e) : lw_error_set(e, LW_E_MEMORY, "no memory for a run with clearance");
    if (s == LW_E_NUMERIC && w.undetermined.status != LW_OK && e)
        *e = w.undetermined;
    free(memory);
    lw_clearance_work_free(&w);
    return s;
}

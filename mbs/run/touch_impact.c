/* mbs/run/touch_impact.c - the places that are closed at one time, and impacts at them.
 *
 * Impacts.  Poisson's law with friction: the impulses of the compression end the approach, and those of the expansion
 * are at least `restitution` times as great; both satisfy Coulomb's law (Glocker & Pfeiffer 1995).  Only places that
 * approach take part; then those that approach because of it, and so on: impacts travel through touching bodies as
 * in Newton's cradle.  Without restitution all places take part at once.  Where this would gain energy, the
 * restitution is halved until it does not. */
#include "base/real.h"
#include "mbs/run/closed_internal.h"

#include <stdlib.h>
#include <string.h>

static const double struck = 1e-13;          /* a gap below this takes part in an impact, scaled                */
static const double trace = 1e-11;           /* share of the speed that free accelerations may change          */
enum { PASSES = 400, TOGETHER = 100 };

/* ---- the places that are closed ---------------------------------------------------------------------- */

void lw_closed_free(lw_closed *c)
{
    free(c->place);
    free(c->row);
    free(c->law);
    free(c->in);
}

static bool allocate(lw_closed *c, size_t most, size_t n_q)
{
    size_t r = 2*most;
    c->place = calloc(2*most + 1, sizeof *c->place);
    c->row = calloc(12*most + r*n_q + r*r + 5*r + r*r + 6*r + 1, sizeof *c->row);
    c->law = calloc(2*most + 1, sizeof *c->law);
    c->in = calloc(2*most + 1, sizeof *c->in);
    if (!c->place || !c->row || !c->law || !c->in)
        return false;
    c->noted = c->in + most;
    c->response = c->row + 12*most;
    c->w = c->response + r*n_q;
    c->u = c->w + r*r;
    c->b = c->u + r;
    c->force = c->b + r;
    c->rate = c->force + r;
    c->gap = c->rate + r;
    c->sub = c->gap + r;
    return true;
}

/* Is the place closed at (t, y)?  Sets the state of a compliant one. */
static lw_status look_at(lw_run *run, double t, lw_touch *p, const lw_touch_motion *m, bool *is)
{
    *is = false;
    if (!lw_touch_is_rigid(p)) {
        bool in = m->gap < -LW_TOUCH_CLOSED || (m->gap <= LW_TOUCH_CLOSED && m->rate < 0);
        p->state = in ? LW_TOUCH_PRESSED : LW_TOUCH_APART;
        *is = in && lw_touch_has_set_valued_friction(p);
        return LW_OK;
    }
    if (m->gap < -lw_touch_overlap)
        return lw_error_set(run->e, LW_E_ARG, "\"%s\": %s at t = %.9g s", lw_touch_name(run->d->model, p),
                            p->kind == LW_TOUCH_STOP ? "the stop of this joint is passed" :
                            p->kind == LW_TOUCH_ROPE ? "this rope is longer than its length" : "these shapes overlap", t);
    bool on = m->gap <= LW_TOUCH_CLOSED && !lw_touch_past_end(p, m);
    *is = on && !lw_touch_beside_end(p, run->d->frames, m);
    p->state = on ? LW_TOUCH_PASSIVE : LW_TOUCH_APART;
    return LW_OK;
}

lw_status lw_run_touch_choose_sides(lw_run *run)
{
    lw_dynamics *d = run->d;
    for (int i = 0; i < d->touch->list.n; i++)
        if (!lw_touch_choose_side(&d->touch->list.touch[i], d->frames, !d->o.pieces, LW_TOUCH_END))
            return lw_error_set(run->e, LW_E_ARG, "\"%s\": an end lies on a segment without thickness, and it is not known on which side; give "
                                "one of them a \"radius\"", lw_touch_name(d->model, &d->touch->list.touch[i]));
    return LW_OK;
}

lw_status lw_run_touch_check(lw_run *run, double t)
{
    lw_dynamics *d = run->d;
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < d->touch->list.n; i++) {
        lw_touch_motion m;
        bool is;
        lw_touch_at(&d->touch->list.touch[i], &d->eq, d->frames, NULL, &m);
        s = look_at(run, t, &d->touch->list.touch[i], &m, &is);
        d->touch->list.touch[i].state = LW_TOUCH_APART;
    }
    return s;
}

/* Append a place to c, whose memory must hold it. */
static void add_place(const lw_dynamics *d, int place, const double *v, lw_closed *c)
{
    lw_touch_motion m;
    lw_touch_at(&d->touch->list.touch[place], &d->eq, d->frames, v, &m);
    c->gap[c->m] = m.gap;
    memcpy(c->row + 12*c->m, m.n, sizeof m.n);
    memcpy(c->row + 12*c->m + 6, m.t, sizeof m.t);
    c->place[c->m++] = place;
}

/* Fill in responses and W of the places of c.  The factored rows are those of the joints alone, without places. */
static void find_responses(lw_dynamics *d, lw_closed *c)
{
    const lw_touch_list *list = &d->touch->list;
    size_t r = 2*(size_t)c->m, n_q = (size_t)d->n_q;
    for (size_t k = 0; k < r; k++) {
        const lw_touch *p = &list->touch[c->place[k/2]];
        double *g = d->hold;
        memset(g, 0, n_q*sizeof *g);
        if (k%2 && !lw_touch_has_set_valued_friction(p))
            continue;                        /* no such force: zeros */
        for (int i = 0; i < 6; i++)
            if (p->body[i/3] >= 0)
                g[3*p->body[i/3] + i%3] += c->row[6*k + (size_t)i];
        lw_mbs_impulse(d, g, c->response + k*n_q);
        for (size_t j = 0; j < r; j++)
            c->w[j*r + k] = lw_touch_row_dot(&list->touch[c->place[j/2]], c->row + 6*j, c->response + k*n_q);
    }
}

lw_status lw_closed_find(lw_run *run, double t, const double *y, lw_closed *c)
{
    lw_dynamics *d = run->d;
    size_t n_q = (size_t)d->n_q, most = 0;
    lw_touch_list *list = &d->touch->list;
    lw_status s = LW_OK;
    for (int pass = 0; s == LW_OK && pass < 2; pass++) {
        if (pass && !allocate(c, most, n_q))
            return LW_E_MEMORY;
        for (int i = 0; s == LW_OK && i < list->n; i++) {
            lw_touch_motion m;
            bool is;
            lw_touch_at(&list->touch[i], &d->eq, d->frames, y + n_q, &m);
            s = look_at(run, t, &list->touch[i], &m, &is);
            most += is && !pass;
            if (is && pass)
                add_place(d, i, y + n_q, c);
        }
    }
    if (s == LW_OK)
        find_responses(d, c);
    return s;
}

void lw_closed_rates(const lw_dynamics *d, const double *v, lw_closed *c)
{
    for (int k = 0; k < 2*c->m; k++)
        c->u[k] = lw_touch_row_dot(&d->touch->list.touch[c->place[k/2]], c->row + 6*k, v);
}

static void apply_impulse(const lw_dynamics *d, const lw_closed *c, const double *impulse, double *v)
{
    for (int k = 0; k < 2*c->m; k++)
        for (int i = 0; impulse[k] != 0 && i < d->n_q; i++)
            v[i] += impulse[k]*c->response[(size_t)k*(size_t)d->n_q + (size_t)i];
}

lw_status lw_closed_solve(const lw_closed *c, const double *b, double *force, double *rate)
{
    int n = 0, *at = c->place + c->m;
    size_t r = 2*(size_t)c->m;
    lw_touch_law *law = c->law + c->m;
    for (int i = 0; i < c->m; i++)
        if (c->in[i]) {
            law[n] = c->law[i];
            at[n++] = i;
        }
    size_t q = 2*(size_t)n;
    double *w = c->sub, *own = w + r*r, *f = own + r, *u = f + r;
    for (size_t i = 0; i < q; i++) {
        own[i] = b[2*(size_t)at[i/2] + i%2];
        for (size_t j = 0; j < q; j++)
            w[i*q + j] = c->w[(2*(size_t)at[i/2] + i%2)*r + 2*(size_t)at[j/2] + j%2];
    }
    lw_status s = lw_complementarity(n, w, own, law, f, u);
    memset(force, 0, r*sizeof *force);
    for (size_t i = 0; i < q; i++)
        force[2*(size_t)at[i/2] + i%2] = f[i];
    for (size_t i = 0; i < r; i++) {
        rate[i] = b[i];
        for (size_t j = 0; j < r; j++) {
            bool counted = c->law[j/2].fixed && j%2 == 0;
            rate[i] += counted ? 0 : c->w[i*r + j]*force[j];
        }
    }
    return s;
}

/* ---- impacts ------------------------------------------------------------------------------------------- */

void lw_run_touch_note(lw_run *run, int place, double t, bool impact, double rate)
{
    lw_dynamics_report *r = run->r;
    const lw_touch *p = &run->d->touch->list.touch[place];
    bool stop = p->kind == LW_TOUCH_STOP;
    double unit = stop ? lw_system_joint_unit(&run->d->s, p->owner) : run->d->s.unit;
    if (r->n_event < LW_REPORT_EVENT_MAX)
        r->event[r->n_event++] = (lw_run_event){ t, stop ? p->owner : -1, p->sign < 0, impact, rate*unit,
                                                 stop ? run->d->model->linkage.joint[p->owner].name
                                                      : lw_touch_name(run->d->model, p), !stop };
    r->n_event_seen++;
}

/* Find the impulses c->force that end the approach of the places in c->in, and the rates c->rate after them.  If the linkage comes to rest,
 * Coulomb's law alone allows any friction up to the limit; but places that slipped until then had friction at the limit.  So a place that slips is
 * assumed to slip on, unless this contradicts Coulomb's law. */
static lw_status compress(const lw_dynamics *d, const lw_closed *c)
{
    double fastest = 0;
    for (int k = 0; k < 2*c->m; k++)
        fastest = fmax(fastest, fabs(c->u[k]));
    for (int i = 0; i < c->m; i++) {
        const lw_touch *p = &d->touch->list.touch[c->place[i]];
        double slip = c->u[2*i + 1], friction = lw_touch_has_set_valued_friction(p) ? p->surface->friction : 0;
        bool slips = c->in[i] && friction > 0 && fabs(slip) > lw_touch_no_slip*fastest;
        c->law[i] = (lw_touch_law){ .friction = friction, .slips = !slips ? 0 : slip > 0 ? 1 : -1 };
    }
    for (;;) {
        lw_status s = lw_closed_solve(c, c->u, c->force, c->rate);
        bool changed = false;
        for (int i = 0; i < c->m; i++) {
            int slips = c->law[i].slips;
            if (slips != 0 && (s == LW_NOTHING || slips*c->rate[2*i + 1] < -lw_touch_no_slip*fastest)) {
                c->law[i].slips = 0;
                changed = true;
            }
        }
        if (!changed)
            return s;
    }
}

/* Compression of the places in c->in, then expansion with `part` of the restitution: c->force is the impulse, c->rate the
 * rates after it.  *gains: the energy increases by more than rounding. */
static lw_status impact_once(const lw_dynamics *d, const lw_closed *c, double part, bool *gains)
{
    bool bounces = false;
    lw_status s = compress(d, c);
    for (int i = 0; s == LW_OK && i < c->m; i++) {
        c->law[i].slips = 0;
        c->law[i].least = part*d->touch->list.touch[c->place[i]].surface->restitution*c->force[2*i];
        bounces = bounces || c->law[i].least > 0;
    }
    if (s == LW_OK && bounces) {
        size_t r = 2*(size_t)c->m;
        double *first = c->b, *before = c->sub + r*r + 3*r;  /* free at this point */
        memcpy(first, c->force, r*sizeof *first);
        memcpy(before, c->rate, r*sizeof *before);
        s = lw_closed_solve(c, before, c->force, c->rate);
        for (size_t k = 0; k < r; k++)
            c->force[k] += first[k];
    }
    double gain = 0, size = 0;
    for (int k = 0; k < 2*c->m; k++) {
        gain += 0.5*c->force[k]*(c->u[k] + c->rate[k]);
        size += 0.5*fabs(c->force[k])*(fabs(c->u[k]) + fabs(c->rate[k]));
    }
    *gains = gain > 1e-12*size;
    return s;
}

/* The same with at most `part` of the restitution, reduced until the energy does not increase. */
static lw_status impact(const lw_dynamics *d, const lw_closed *c, double part)
{
    bool gains;
    lw_status s = impact_once(d, c, part, &gains);
    for (int k = 0; s == LW_OK && gains && part > 0; k++) {
        part = k < 30 ? 0.5*part : 0;
        s = impact_once(d, c, part, &gains);
    }
    return s;
}

lw_status lw_run_touch_impact(lw_run *run, double t, int n, const int *place, double *v)
{
    lw_dynamics *d = run->d;
    lw_closed c = { 0 };
    lw_status s = allocate(&c, (size_t)n, (size_t)d->n_q) ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < n; i++) {
        add_place(d, place[i], v, &c);
        c.in[i] = true;
    }
    if (s == LW_OK) {
        find_responses(d, &c);
        lw_closed_rates(d, v, &c);
        s = impact(d, &c, 1);
    }
    for (int i = 0; s == LW_OK && i < n; i++)
        lw_run_touch_note(run, place[i], t, true, c.u[2*i]);
    if (s == LW_OK)
        apply_impulse(d, &c, c.force, v);
    lw_closed_free(&c);
    return s;
}

lw_status lw_run_touch_strike(lw_run *run, double t, lw_closed *c, double *tiny, double *v, bool *any)
{
    lw_dynamics *d = run->d;
    const lw_touch *touch = d->touch->list.touch;
    bool plastic = true;
    for (int i = 0; i < c->m; i++)
        plastic = plastic && !(touch[c->place[i]].surface->restitution > 0);
    for (int pass = 0; pass < PASSES; pass++) {
        bool hit = false;
        for (int i = 0; i < c->m; i++) {
            c->in[i] = lw_touch_is_rigid(&touch[c->place[i]]) && c->gap[i] < struck && c->u[2*i] < -*tiny;
            hit = hit || c->in[i];
            if (c->in[i] && !c->noted[i] && (pass == 0 || !plastic)) {
                lw_run_touch_note(run, c->place[i], t, true, c->u[2*i]);
                c->noted[i] = true;
            }
        }
        if (!hit)
            return LW_OK;
        for (int i = 0; (plastic || pass >= TOGETHER) && i < c->m; i++)
            c->in[i] = lw_touch_is_rigid(&touch[c->place[i]]);
        lw_status s = impact(d, c, pass < TOGETHER);
        if (s == LW_E_MEMORY)
            return s;
        double blocked = 0;
        for (int i = 0; i < c->m; i++)
            blocked = c->in[i] && !(c->w[4*(size_t)c->m*(size_t)i + 2*(size_t)i] > 0) ? 1 : blocked;
        if (s != LW_OK || blocked > 0)
            return lw_error_set(run->e, LW_E_NUMERIC, "the impact at t = %.9g s has no solution: what is hit cannot give way", t);
        apply_impulse(d, c, c->force, v);
        lw_closed_rates(d, v, c);
        for (int i = 0; i < c->m; i++)
            *tiny = c->in[i] ? fmax(*tiny, -2*fmin(c->rate[2*i], c->u[2*i])) : *tiny;
        *any = true;
    }
    return lw_error_set(run->e, LW_E_NUMERIC, "impacts follow each other without end at t = %.9g s", t);
}

lw_status lw_run_touch_impulses(lw_run *run, double t, lw_closed *c, double speed, double *v, bool *any)
{
    size_t r = 2*(size_t)c->m;
    double *after = c->sub + r*r + 3*r, most = 0, change = 0;
    for (size_t k = 0; k < r; k++)
        most = fmax(most, fabs(c->b[k]));
    double h = trace*speed/fmax(most, 1e-300);
    for (int i = 0; i < c->m; i++) {
        after[2*i] = (c->in[i] ? fmin(c->u[2*i], 0) : c->u[2*i]) + h*c->b[2*i];
        after[2*i + 1] = c->u[2*i + 1] + h*c->b[2*i + 1];
        c->law[i].slips = 0;
        c->law[i].least *= h;
    }
    lw_status s = lw_closed_solve(c, after, c->force, c->rate);
    for (size_t k = 0; s == LW_OK && k < r; k++)
        change = fmax(change, fabs(c->rate[k] - after[k]));
    *any = change > 30*trace*speed;
    for (int i = 0; s == LW_OK && i < c->m; i++) {
        bool strikes = c->in[i] && !c->law[i].fixed && c->force[2*i]*c->w[2*(size_t)i*(r + 1)] > 30*trace*speed;
        if (*any && strikes)
            lw_run_touch_note(run, c->place[i], t, true, 0);
    }
    if (s == LW_OK && *any) {
        apply_impulse(run->d, c, c->force, v);
        lw_closed_rates(run->d, v, c);
    }
    for (size_t k = 0; s == LW_OK && !*any && k < r; k++) {
        c->rate[k] = c->b[k] + (c->rate[k] - after[k])/h;
        c->force[k] /= h;
    }
    return s;
}

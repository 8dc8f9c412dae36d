/* catalogues/draw/scene_draft.c - a draft: the motion quickly, for a linkage that is being dragged.
 *
 * By the plan, without the proof that no gap is passed over between two inputs; else by the steps of Newton's method
 * (mbs/constraints/newton.h) and on cubics between them, without the other assembly modes past a limit. */
#include "catalogues/draw/scene_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/constraints/newton.h"

enum { TURNS = 12, NODES = 500 };                /* after so many turns, or steps, a motion that does not repeat is cut */
enum { DRAFT_STEPS = 96, DRAFT_STAGES = 6 };     /* inputs tried in a turn; arcs of a walk                             */

static const double draft_step = 0.25;          /* longest step [1], see lw_newton_step                   */
static const double draft_margin = 1e-3;        /* nearer to a change point the plan does not decide the way */

lw_status lw_scene_draft_curves(lw_scene *s, size_t n)
{
    size_t frames = s->n_frame, parts = s->loops ? frames : frames - 1, each = (n + parts - 1)/parts;
    if (frames < 2 || n == 0)
        return LW_OK;
    for (int t = 0; t < s->linkage.n_tracer && s->n_curve < s->max_curve; t++) {
        const lw_tracer *tracer = &s->linkage.tracer[t];
        lw_curve c = { .tracer = t, .shown_branch = true, .closed = s->loops, .n = parts*each + !s->loops };
        if (!(c.p = malloc(c.n*sizeof *c.p)))
            return LW_E_MEMORY;
        for (size_t i = 0; i < parts; i++) {
            size_t at[4] = { i ? i - 1 : s->loops ? frames - 1 : 0, i, (i + 1) % frames,
                             i + 2 < frames ? i + 2 : s->loops ? (i + 2) % frames : frames - 1 };
            lw_vec2 p[4];
            for (int k = 0; k < 4; k++)
                p[k] = lw_scene_at(s, at[k], tracer->link, tracer->at);
            lw_vec2 v = lw_v2_scale(lw_v2_sub(p[2], p[0]), 0.5), w = lw_v2_scale(lw_v2_sub(p[3], p[1]), 0.5);
            for (size_t k = 0; k < each; k++) {
                double x = (double)k/(double)each, y = 1 - x;
                lw_vec2 q = lw_v2_add(lw_v2_scale(p[1], y*y*(1 + 2*x)), lw_v2_scale(p[2], x*x*(1 + 2*y)));
                c.p[i*each + k] = lw_v2_add(q, lw_v2_sub(lw_v2_scale(v, x*y*y), lw_v2_scale(w, x*x*y)));
            }
        }
        if (!s->loops)
            c.p[c.n - 1] = lw_scene_at(s, frames - 1, tracer->link, tracer->at);
        s->curve[s->n_curve++] = c;
    }
    return LW_OK;
}

void lw_scene_draft_thin(lw_scene *s)
{
    size_t n_link = (size_t)s->linkage.n_link, odd = s->first_frame % 2, n = (s->n_frame - odd + 1)/2;
    if (n < 2)
        return;
    for (size_t f = 0; f < n; f++) {
        memmove(s->place + f*n_link, s->place + (2*f + odd)*n_link, n_link*sizeof *s->place);
        s->input[f] = s->input[2*f + odd];
    }
    s->n_frame = n;
    s->first_frame /= 2;
}

bool lw_scene_draft_frames(lw_scene_work *w, const lw_scene_options *o)
{
    if (!lw_scene_take_frames(w, 2*(o->n_frame < 2 ? 2 : o->n_frame)) || lw_scene_draft_curves(w->s, o->n_curve_point) != LW_OK)
        return false;
    lw_scene_draft_thin(w->s);
    return true;
}

static bool plan_closes(lw_scene_work *w, const double *mode, double input)
{
    return lw_posture_solve(&w->plan, w->dim, mode, input, 0, &w->posture) == LW_OK;
}

/* The last input from `from` towards `end` that closes, looked for in `steps` steps; lowers *least to the margins met. */
static double plan_end(lw_scene_work *w, const double *mode, double from, double end, int steps, double *least)
{
    double good = 0, bad = 2;
    for (int i = 1; i <= steps && bad > 1; i++)
        if (plan_closes(w, mode, from + (end - from)*i/steps)) {
            good = (double)i/steps;
            *least = fmin(*least, w->posture.margin);
        } else
            bad = (double)i/steps;
    while (bad <= 1 && bad - good > 1e-12) {
        double middle = 0.5*(good + bad);
        *(plan_closes(w, mode, from + (end - from)*middle) ? &good : &bad) = middle;
    }
    return good == 1 ? end : from + (end - from)*good;
}

static bool has_mode(const lw_plan *p, int dyad)
{
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].dyad == dyad && (p->step[i].kind == LW_STEP_PRP || p->step[i].kind == LW_STEP_PPR))
            return false;
    return true;
}

/* The assembly mode beyond a limit: it differs in one dyad and has the same posture there.  Returns how many there are. */
static int mode_beyond(lw_scene_work *w, const double *mode, double limit, double *next)
{
    lw_posture here, there;
    int n = 0, flips = 0;
    lw_posture_solve(&w->plan, w->dim, mode, limit, 0, &here);
    memcpy(next, mode, sizeof w->mode);
    for (int i = 0; i < w->plan.n_dyad; i++) {
        next[i] = -next[i];
        lw_posture_solve(&w->plan, w->dim, next, limit, 0, &there);
        next[i] = -next[i];
        if (has_mode(&w->plan, i) && lw_plan_posture_distance(&w->plan, &here, &there) < 1e-4*lw_scene_span(&w->s->linkage)) {
            n++;
            flips = i;
        }
    }
    next[flips] = n == 1 ? -next[flips] : next[flips];
    return n;
}

bool lw_scene_draft_walk(lw_scene_work *w)
{
    bool slides = w->plan.input_is_slider;
    double least = 1, none = 1, way = slides ? 8*lw_scene_span(&w->s->linkage) : 2*LW_PI;
    double last = plan_end(w, w->mode, w->input, w->input + way, DRAFT_STEPS, &least);
    bool turns = !slides && last == w->input + way;
    double first = turns ? w->input : plan_end(w, w->mode, w->input, w->input - way, DRAFT_STEPS, &none);
    lw_walk *k = &w->walk;
    *k = (lw_walk){ .plan = &w->plan, .dim = w->dim, .n_stage = 1, .loops = turns, .turns = turns };
    k->stage[0] = (lw_walk_stage){ .from = first, .to = last };
    memcpy(k->stage[0].mode, w->mode, sizeof w->mode);
    if (turns || !(last > first))
        return turns && least > draft_margin;
    if (slides && (last == w->input + way || first == w->input - way))
        return true;
    while (k->n_stage < DRAFT_STAGES) {
        const lw_walk_stage *s = &k->stage[k->n_stage - 1];
        lw_walk_stage *next = &k->stage[k->n_stage];
        double end = s->to + (s->from < s->to ? -way : way);
        int n = mode_beyond(w, s->mode, s->to, next->mode);
        k->loops = n == 1 && fabs(s->to - first) < 1e-6*way
                   && memcmp(next->mode, w->mode, (size_t)w->plan.n_dyad*sizeof *w->mode) == 0;
        if (n != 1 || k->loops)
            return n < 2;
        next->from = s->to;
        next->to = plan_end(w, next->mode, s->to, end, DRAFT_STEPS, &none);
        if (next->to == end || next->to == next->from)
            break;
        if (!plan_closes(w, next->mode, 0.5*(next->from + next->to)) || w->posture.margin < 1e-6)
            return false;                                       /* two links lie on each other: the plan does not move */
        k->n_stage++;
    }
    return true;
}

/* The steps of a motion, in the order of the input. */
typedef struct draft_nodes { double *q; size_t n, size; bool failed; } draft_nodes;

static void draft_keep(draft_nodes *d, const lw_newton *m)
{
    if (d->n % 64 == 0) {
        double *q = realloc(d->q, (d->n + 64)*d->size*sizeof *q);
        d->failed = d->failed || !q;
        d->q = q ? q : d->q;
    }
    if (!d->failed)
        lw_newton_keep(m, d->q + d->size*d->n++);
}

/* Step from the present posture to `input`, and keep the postures on the way. */
static lw_status draft_go(draft_nodes *d, lw_newton *m, double input)
{
    lw_status st = LW_STOPPED;
    while (st == LW_STOPPED && d->n < NODES && !d->failed) {
        st = lw_newton_step(m, input, draft_step);
        if (st >= 0)
            draft_keep(d, m);
    }
    return d->failed ? LW_E_MEMORY : st;
}

static bool is_back(const lw_newton *m, int n_link)
{
    for (int i = 0; i < n_link; i++)
        if (fabs(remainder(lw_newton_angle(m, i), 2*LW_PI)) > 1e-6)
            return false;
    return true;
}

static void draft_reverse(draft_nodes *d)
{
    for (size_t i = 0; i < d->n/2; i++)
        for (size_t k = 0; k < d->size; k++) {
            double *a = d->q + d->size*i + k, *b = d->q + d->size*(d->n - 1 - i) + k, old = *a;
            *a = *b;
            *b = old;
        }
}

/* Step through the whole motion: turns until it is back where it began, else from limit to limit, only within
 * range[0] .. range[1] if range is not NULL.  A branch that is lost ends it: *lost. */
static lw_status draft_steps(draft_nodes *d, lw_newton *m, lw_scene *s, const double *range, bool *lost)
{
    bool slides = lw_joint_slides(s->linkage.joint[s->linkage.input[0].joint].kind);
    double now = lw_newton_input(m), far = slides ? 8*lw_scene_span(&s->linkage) : 2*LW_PI;
    lw_status st = LW_OK;
    draft_keep(d, m);
    for (int turn = 1; turn <= (range || slides ? 1 : TURNS) && st == LW_OK && !s->loops; turn++) {
        st = draft_go(d, m, range ? range[1] : now + turn*far);
        s->loops = st == LW_OK && !range && !slides && (is_back(m, s->linkage.n_link) || turn == TURNS);
    }
    *lost = st == LW_E_NUMERIC || st == LW_STOPPED;
    if (s->loops || st == LW_E_MEMORY)
        return st;
    size_t up = d->n;
    lw_newton_reset(m);
    draft_nodes down = { .size = d->size };
    st = draft_go(&down, m, range ? range[0] : now - far);
    *lost = *lost || st == LW_E_NUMERIC || st == LW_STOPPED;
    draft_reverse(&down);
    double *q = realloc(d->q, (up + down.n + 1)*d->size*sizeof *q);
    if (q) {
        d->q = q;
        memmove(q + down.n*d->size, q, up*d->size*sizeof *q);
        if (down.n)
            memcpy(q, down.q, down.n*d->size*sizeof *q);
        d->n = up + down.n;
    }
    free(down.q);
    return !q || st == LW_E_MEMORY ? LW_E_MEMORY : LW_OK;
}

/* Move m to `input`, between node *at or a later one and the next. */
static void draft_place(const draft_nodes *d, lw_newton *m, double input, size_t *at)
{
    double lo = 0, hi = 1;
    for (lw_newton_between(m, d->q, d->q, 1); *at + 2 < d->n; ++*at) {
        const double *next = d->q + d->size*(*at + 1);
        lw_newton_between(m, next, next, 1);
        if (lw_newton_input(m) >= input)
            break;
    }
    for (int i = 0; i < 30; i++) {
        double x = 0.5*(lo + hi);
        lw_newton_between(m, d->q + d->size**at, d->q + d->size*(*at + 1), x);
        *(lw_newton_input(m) < input ? &lo : &hi) = x;
    }
}

static bool draft_frames(lw_scene *s, const draft_nodes *d, lw_newton *m, double now, size_t n)
{
    const double *last = d->q + d->size*(d->n - 1);
    if (!lw_scene_make_frames(s, n))
        return false;
    lw_newton_between(m, d->q, d->q, 0);
    double from = lw_newton_input(m);
    lw_newton_between(m, last, last, 1);
    double to = lw_newton_input(m), middle = 0.5*(from + to), half = 0.5*(to - from);
    if (!s->loops)
        s->first_frame = (size_t)round(acos(fmin(fmax((middle - now)/half, -1), 1))/LW_PI*(double)(n - 1));
    size_t at = 0, n_link = (size_t)s->linkage.n_link;
    for (size_t f = 0; f < n; f++) {
        s->input[f] = f == s->first_frame ? now : s->loops ? from + (to - from)*(double)f/(double)n
                                                           : middle - half*cos(LW_PI*(double)f/(double)(n - 1));
        draft_place(d, m, s->input[f], &at);
        for (size_t i = 0; i < n_link && f != s->first_frame; i++)
            s->place[f*n_link + i] = (lw_place){ lw_newton_point(m, (int)i, s->origin[i]),
                                                 lw_v2_polar(1, lw_newton_angle(m, (int)i)) };
    }
    return true;
}

static bool draft_lines(lw_scene *s, const draft_nodes *d, lw_newton *m, size_t n)
{
    size_t parts = d->n - 1, each = (n + parts - 1)/parts, first = (size_t)s->n_curve;
    for (int t = 0; t < s->linkage.n_tracer && s->n_curve < s->max_curve; t++) {
        lw_curve *c = &s->curve[s->n_curve];
        *c = (lw_curve){ .tracer = t, .shown_branch = true, .closed = s->loops, .n = parts*each + !s->loops };
        if (!(c->p = malloc((parts*each + 1)*sizeof *c->p)))
            return false;
        s->n_curve++;
    }
    for (size_t i = 0; i <= parts*each && (int)first < s->n_curve; i++) {
        size_t part = i < parts*each ? i/each : parts - 1;
        const double *a = d->q + d->size*part;
        lw_newton_between(m, a, a + d->size, (double)(i - part*each)/(double)each);
        for (size_t c = first; c < (size_t)s->n_curve; c++)
            s->curve[c].p[i] = lw_newton_tracer(m, s->curve[c].tracer);
    }
    return true;
}

lw_status lw_scene_draft_steps(lw_scene *s, const lw_linkage *linkage, const double *range, const lw_scene_options *o)
{
    lw_newton *m = NULL;
    lw_error e = { 0 };
    bool lost = false;
    lw_status st = lw_newton_create(linkage, &m, &e);
    draft_nodes d = { .size = m ? lw_newton_node_size(m) : 0 };
    double now = m ? lw_newton_input(m) : 0;
    if (st == LW_OK)
        st = draft_steps(&d, m, s, range, &lost);
    bool moves = st == LW_OK && d.n > 1;
    if (moves && !(draft_frames(s, &d, m, now, o->n_frame < 2 ? 2 : o->n_frame) && draft_lines(s, &d, m, o->n_curve_point)))
        st = LW_E_MEMORY;
    if (st != LW_E_MEMORY && st != LW_E_ARG && !moves) {
        st = lw_scene_make_frames(s, 1) ? LW_OK : LW_E_MEMORY;
        snprintf(s->note, sizeof s->note, "Shown without motion: %.200s",
                 e.text[0] ? e.text : "two branches of the motion are too close to each other here");
    } else if (lost)
        snprintf(s->note, sizeof s->note, "Shown in part while it is dragged: the rest takes longer to follow");
    free(d.q);
    lw_newton_free(m);
    return st;
}

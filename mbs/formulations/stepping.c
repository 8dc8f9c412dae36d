#include "mbs/formulations/stepping.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/formulations/formulations.h"

/* memcpy, where there may be nothing and no place for it. */
static void copy(void *to, const void *from, size_t size)
{
    if (size > 0)
        memcpy(to, from, size);
}

/* The state of a touching place besides posture and velocities. */
typedef struct touch_memory { double anchor, anchor_angle, passed, force; int state, sticks, slips, side; } touch_memory;

struct lw_stepping {
    lw_dynamics    *d;
    lw_caller_force force;                   /* of the caller's own; apply NULL: none */
    bool            loaded;                  /* some load is held */
    bool            goes_on;                 /* the present is the end of a piece */
    int             n_link, width;           /* width: numbers of a load */
    double         *load;                    /* (n_link of width) loads that are held */
    double          t, work;                 /* at the present, and the work done since the start */
    double         *y, *next;                /* (n_q) posture, (n_v) velocities, (n_z) states; the same after a piece */
    int             n_turn;                  /* of joints in space, which count their turns */
    double         *turn;                    /* (n_turn) at the present */
    double          next_work;
    touch_memory   *touch;                   /* (of d->touch) at the present */
    unsigned char  *resting;                 /* (n_stop) is the stop rested on? TOUCHING: without a force since it began */
    bool            only_start;              /* the piece under way ends with its first sample */
    lw_moment_sink *sink;
    void           *context;
    lw_stepping    *coarse;                  /* the same run with less accuracy, up to its own present; NULL: none */
    long            steps;                   /* of this run since then */
    lw_coarse_run   off;                     /* how far they differ; 0: not known, because the coarse run ended early, or had the same steps */
};

enum { TOUCHING = 2 };

static int n_touch(const lw_stepping *s) { return s->d->touch ? s->d->touch->list.n : 0; }

static void put_memory(const lw_stepping *s)
{
    lw_dynamics *d = s->d;
    if (d->space)
        memcpy(d->space->f.turn, s->turn, (size_t)s->n_turn*sizeof *s->turn);
    d->n_resting = 0;
    for (int i = 0; i < d->n_stop; i++) {
        d->stop[i].touching = s->resting[i] == TOUCHING;
        if ((d->stop[i].resting = s->resting[i] != 0))
            d->resting[d->n_resting++] = i;
    }
    for (int i = 0; i < n_touch(s); i++) {
        lw_touch *p = &d->touch->list.touch[i];
        const touch_memory *m = &s->touch[i];
        p->anchor = m->anchor, p->anchor_angle = m->anchor_angle, p->passed = m->passed, p->force = m->force;
        p->state = (lw_touch_state)m->state, p->sticks = m->sticks, p->slips = m->slips, p->side = m->side;
    }
    if (d->touch) {                          /* which places are rows is decided at the start of the piece */
        d->touch->n_row = d->touch->n_slip = d->touch->n_redundant = 0;
        d->touch->stalled = 0;
        d->touch->goes_on = s->goes_on;
        d->touch->last = -INFINITY;
    }
}

static void take_memory(lw_stepping *s)
{
    if (s->d->space)
        memcpy(s->turn, s->d->space->f.turn, (size_t)s->n_turn*sizeof *s->turn);
    for (int i = 0; i < s->d->n_stop; i++)
        s->resting[i] = !s->d->stop[i].resting ? 0 : s->d->stop[i].touching ? TOUCHING : 1;
    for (int i = 0; i < n_touch(s); i++) {
        const lw_touch *p = &s->d->touch->list.touch[i];
        s->touch[i] = (touch_memory){ p->anchor, p->anchor_angle, p->passed, p->force, (int)p->state, p->sticks, p->slips,
                                      p->side };
    }
}

static size_t numbers(const lw_stepping *s) { return (size_t)(s->d->n_q + s->d->n_v + s->d->eq.n_z); }

/* The caller's forces and the loads that are held. */
static void apply(void *context, double t, const lw_link_motion *link, lw_link_load *load)
{
    const lw_stepping *s = context;
    if (s->force.apply)
        s->force.apply(s->force.context, t, link, load);
    for (int i = 0; s->loaded && i < s->n_link; i++) {
        const double *held = s->load + 3*i;
        load[i].force = lw_v2_add(load[i].force, lw_v2(held[0], held[1]));
        load[i].torque += held[2];
    }
}

/* Begin the coarse run of a model with contacts.  Where it cannot start, there is none. */
static lw_status begin_coarse(lw_stepping *s, const lw_model *m, const lw_dynamics_options *o, lw_error *e)
{
    lw_error why = { 0 };
    lw_dynamics_options with = *o;
    with.formulation = s->d->choice.formulation;
    s->off = lw_coarse_begin(with.formulation == LW_FORMULATION_CAPTURE, &with);
    lw_status status = lw_stepping_make(m, &with, &s->coarse, &why);
    if (status != LW_OK)
        s->off = (lw_coarse_run){ 0 };
    return status == LW_E_MEMORY ? lw_error_set(e, status, "%s", why.text) : LW_OK;
}

/* Bring the coarse run to the present.  Captured contacts have an error by the length of their steps, which end with a piece: where a piece is one step of
 * both runs, they do not differ. */
static void follow(lw_stepping *s)
{
    lw_dynamics_report r;
    lw_stepping *c = s->coarse;
    if (s->off.tolerance == 0 || c->t >= s->t)
        return;
    bool captured = s->d->choice.formulation == LW_FORMULATION_CAPTURE;
    if ((captured && s->steps <= 1) || lw_stepping_advance(c, s->t, NULL, NULL, &r, &(lw_error){ 0 }) != LW_OK)
        s->off = (lw_coarse_run){ 0 };
    else
        lw_coarse_compare(s->d, s->t, s->y, c->y, &s->off);
    s->steps = 0;
}

/* One of both models is given. */
static lw_status make(const lw_model *m, const lw_spatial *space, const lw_dynamics_options *o, lw_stepping **out, lw_error *e)
{
    lw_dynamics_options with = *o;
    lw_stepping *s = calloc(1, sizeof *s);
    *out = NULL;
    if (o->analysis != LW_ANALYSIS_TRANSIENT && o->analysis != LW_ANALYSIS_DYNAMIC) {
        free(s);
        return lw_error_set(e, LW_E_KIND, "only runs in time (transient, dynamic) go in pieces");
    }
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    s->force = o->force;
    if (m)
        with.force = (lw_caller_force){ s, apply };
    with.pieces = true;
    with.to = fmax(with.to, with.from + 1e-3);
    lw_status status = m ? lw_dynamics_make(m, &with, &s->d, e) : lw_dynamics_make_spatial(space, &with, &s->d, e);
    if (status == LW_OK) {
        s->width = m ? 3 : 6;                /* links: with the nodes of elastic ones */
        s->n_link = m ? s->d->model->linkage.n_link : s->d->space->model->n_link;
        s->n_turn = m ? 0 : s->d->space->s.n_joint;
        s->y = calloc(2*numbers(s) + 1, sizeof *s->y);
        s->load = calloc((size_t)(s->n_link*s->width), sizeof *s->load);
        s->turn = calloc((size_t)s->n_turn + 1, sizeof *s->turn);
        s->touch = calloc((size_t)n_touch(s) + 1, sizeof *s->touch);
        s->resting = calloc((size_t)s->d->n_stop + 1, 1);
        status = s->y && s->load && s->turn && s->touch && s->resting ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    if (status != LW_OK) {
        lw_stepping_free(s);
        return status;
    }
    if (s->d->space)
        s->d->eq.conservative = s->d->space->f.conservative = false;         /* loads may come */
    take_memory(s);
    s->next = s->y + numbers(s);
    s->t = o->from;
    lw_dynamics_start(s->d, s->y, s->y + s->d->n_q);
    memcpy(s->y + s->d->n_q + s->d->n_v, lw_dynamics_start_states(s->d), (size_t)s->d->eq.n_z*sizeof *s->y);
    status = lw_coarse_suits(s->d) ? begin_coarse(s, m, o, e) : LW_OK;
    if (status == LW_OK)
        *out = s;
    else
        lw_stepping_free(s);
    return status;
}

lw_status lw_stepping_make(const lw_model *m, const lw_dynamics_options *o, lw_stepping **out, lw_error *e)
{
    return make(m, NULL, o, out, e);
}

lw_status lw_stepping_make_spatial(const lw_spatial *m, const lw_dynamics_options *o, lw_stepping **out, lw_error *e)
{
    return make(NULL, m, o, out, e);
}

void lw_stepping_free(lw_stepping *s)
{
    if (s) {
        lw_dynamics_free(s->d);
        free(s->load);
        free(s->turn);
        free(s->touch);
        free(s->resting);
        free(s->y);
        lw_stepping_free(s->coarse);
    }
    free(s);
}

double lw_stepping_time(const lw_stepping *s) { return s->t; }
const lw_dynamics *lw_stepping_dynamics(const lw_stepping *s) { return s->d; }

/* Keep the state; hand on the moment at the end, or the only one. */
static lw_status take(void *context, const lw_moment *m)
{
    lw_stepping *s = context;
    size_t n = (size_t)s->d->n_q, n_v = (size_t)s->d->n_v;
    if (m->t < s->d->o.to && !s->only_start)
        return LW_OK;
    memcpy(s->next, m->q, n*sizeof *m->q);
    memcpy(s->next + n, m->v, n_v*sizeof *m->v);
    copy(s->next + n + n_v, m->z, (size_t)s->d->eq.n_z*sizeof *m->z);
    s->next_work = s->work + m->work;
    lw_moment with = *m;
    with.work = s->next_work;
    lw_status status = s->sink ? s->sink(s->context, &with) : LW_OK;
    return status == LW_OK && s->only_start ? LW_STOPPED : status;
}

lw_status lw_stepping_advance(lw_stepping *s, double t, lw_moment_sink *sink, void *context, lw_dynamics_report *r,
                              lw_error *e)
{
    lw_dynamics *d = s->d;
    lw_dynamics_report report = { 0 };
    if (!isfinite(t))
        return lw_error_set(e, LW_E_ARG, "the time to go on to is not a number");
    if (d->space)
        d->space->f.held = s->loaded ? s->load : NULL;
    else
        d->f.caller.apply = s->force.apply || s->loaded ? apply : NULL;
    s->sink = sink;
    s->context = context;
    s->only_start = t <= s->t;
    d->o.intervals = 1;
    put_memory(s);
    lw_status status = lw_dynamics_restart(d, s->t, s->only_start ? s->t + 1e-3 : t, s->y, s->y + d->n_q,
                                           s->y + d->n_q + d->n_v, e);
    if (status == LW_OK)
        status = lw_dynamics_run(d, take, s, &report, e);
    if (status == LW_STOPPED && s->only_start && report.samples > 0)
        status = LW_OK;
    if (status == LW_OK && !s->only_start) { /* a look leaves the state as it is, to the last digit */
        take_memory(s);
        s->goes_on = true;
        s->t = t;
        s->work = s->next_work;
        memcpy(s->y, s->next, numbers(s)*sizeof *s->y);
        s->steps += report.steps;
        if (report.captured_step == 0 || s->steps >= 4)
            follow(s);
    }
    report.coarse = s->off;
    if (r)
        *r = report;
    return status;
}

static void find_loaded(lw_stepping *s)
{
    s->loaded = false;
    for (int i = 0; i < s->n_link*s->width; i++)
        s->loaded = s->loaded || s->load[i] != 0;
}

lw_status lw_stepping_set_load(lw_stepping *s, int link, const double *load)
{
    bool good = link >= 0 && link < s->n_link;
    for (int k = 0; k < s->width; k++)
        good = good && isfinite(load[k]);
    if (!good)
        return LW_E_ARG;
    follow(s);                               /* the coarse run comes here with the loads of before */
    memcpy(s->load + link*s->width, load, (size_t)s->width*sizeof *load);
    find_loaded(s);
    if (s->off.tolerance > 0)
        lw_stepping_set_load(s->coarse, link, load);
    return LW_OK;
}

lw_status lw_stepping_set_state(lw_stepping *s, int state, double value)
{
    if (state < 0 || state >= s->d->eq.n_z || !isfinite(value))
        return LW_E_ARG;
    follow(s);
    s->y[s->d->n_q + s->d->n_v + state] = value;
    if (s->off.tolerance > 0)
        lw_stepping_set_state(s->coarse, state, value);
    return LW_OK;
}

/* ---- save and restore ------------------------------------------------------------------------------------- */

/* check: the hash of all bytes after it. Bytes: head, y, loads, turns, places that touch, for each rigid stop whether it is rested on, and the coarse
 * run (coarse bytes; 0: none). */
typedef struct head { char magic[8]; uint64_t check, model, numbers, loads, turns, touches, stops, coarse; double t, work; int64_t steps;
                      lw_coarse_run off; } head;

static const char magic[8] = "lwstep4";
static const size_t checked = offsetof(head, check) + sizeof(uint64_t);

/* FNV-1a */
static uint64_t hash(uint64_t h, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        h = (h ^ ((const unsigned char *)bytes)[i])*1099511628211u;
    return h;
}

static const uint64_t hash_start = 14695981039346656037u;

/* A hash of names, kinds and masses: tells models apart. */
static uint64_t fingerprint(const lw_dynamics *d)
{
    const lw_equations *eq = &d->eq;
    uint64_t h = hash_start;
    const struct { const void *at; size_t size; } part[] = {
        { eq->mass, (size_t)d->n_v*sizeof *eq->mass }, { eq->weight, (size_t)d->n_v*sizeof *eq->weight },
        { &eq->unit, sizeof eq->unit }
    };
    for (size_t p = 0; p < sizeof part/sizeof *part; p++)
        h = hash(h, part[p].at, part[p].size);
    for (int i = 0; i < eq->n_block + eq->n_z; i++) {
        bool block = i < eq->n_block;
        const char *name = eq->name(eq->context, block ? LW_NAMED_BLOCK : LW_NAMED_STATE, block ? i : i - eq->n_block);
        h = hash(h, name, strlen(name));
    }
    return h;
}

static head head_of(const lw_stepping *s)
{
    head h = { .model = fingerprint(s->d), .numbers = numbers(s), .loads = (uint64_t)(s->n_link*s->width),
               .turns = (uint64_t)s->n_turn, .touches = (uint64_t)n_touch(s), .stops = (uint64_t)s->d->n_stop, .t = s->t, .work = s->work,
               .steps = s->steps, .off = s->off };
    memcpy(h.magic, magic, sizeof magic);
    return h;
}

static size_t size_of(const head *h)
{
    return sizeof *h + (size_t)(h->numbers + h->loads + h->turns)*sizeof(double)
         + (size_t)h->touches*sizeof(touch_memory) + (size_t)(h->stops + h->coarse);
}

lw_status lw_stepping_save(const lw_stepping *s, void **bytes, size_t *size)
{
    head h = head_of(s);
    void *coarse = NULL;
    size_t more = 0;
    if (s->off.tolerance > 0 && lw_stepping_save(s->coarse, &coarse, &more) != LW_OK)
        return LW_E_MEMORY;
    h.coarse = more;
    unsigned char *to = malloc(size_of(&h));
    *bytes = to;
    *size = to ? size_of(&h) : 0;
    if (to) {
        memcpy(to, &h, sizeof h);
        memcpy(to += sizeof h, s->y, numbers(s)*sizeof *s->y);
        copy(to += numbers(s)*sizeof *s->y, s->load, (size_t)h.loads*sizeof *s->load);
        copy(to += (size_t)h.loads*sizeof *s->load, s->turn, (size_t)h.turns*sizeof *s->turn);
        copy(to += (size_t)h.turns*sizeof *s->turn, s->touch, (size_t)h.touches*sizeof *s->touch);
        copy(to += (size_t)h.touches*sizeof *s->touch, s->resting, (size_t)h.stops);
        copy(to + h.stops, coarse, more);
        h.check = hash(hash_start, (char *)*bytes + checked, *size - checked);
        memcpy(*bytes, &h, sizeof h);
    }
    free(coarse);
    return to ? LW_OK : LW_E_MEMORY;
}

lw_status lw_stepping_restore(lw_stepping *s, const void *bytes, size_t size, lw_error *e)
{
    head h, own = head_of(s);
    if (size < sizeof h || memcmp(bytes, magic, sizeof magic) != 0)
        return lw_error_set(e, LW_E_NOTATION, "these bytes are no saved run");
    memcpy(&h, bytes, sizeof h);
    own.coarse = h.coarse;
    if (h.coarse > size || size != size_of(&own) || h.model != own.model || h.numbers != own.numbers || h.loads != own.loads ||
        h.turns != own.turns || h.touches != own.touches || h.stops != own.stops)
        return lw_error_set(e, LW_E_NOTATION, "this run was saved of another model, or is incomplete");
    if (h.check != hash(hash_start, (const char *)bytes + checked, size - checked))
        return lw_error_set(e, LW_E_NOTATION, "this saved run is damaged");
    const unsigned char *from = (const unsigned char *)bytes + sizeof h;
    const bool compared = s->coarse && h.coarse > 0;
    lw_status status = compared ? lw_stepping_restore(s->coarse, (const unsigned char *)bytes + size - h.coarse, (size_t)h.coarse, e) : LW_OK;
    if (status != LW_OK)
        return status;
    memcpy(s->y, from, numbers(s)*sizeof *s->y);
    copy(s->load, from += numbers(s)*sizeof *s->y, (size_t)h.loads*sizeof *s->load);
    copy(s->turn, from += (size_t)h.loads*sizeof *s->load, (size_t)h.turns*sizeof *s->turn);
    copy(s->touch, from += (size_t)h.turns*sizeof *s->turn, (size_t)h.touches*sizeof *s->touch);
    copy(s->resting, from + (size_t)h.touches*sizeof *s->touch, (size_t)h.stops);
    s->goes_on = true;
    s->t = h.t;
    s->work = h.work;
    find_loaded(s);
    s->steps = h.steps;
    s->off = compared ? h.off : (lw_coarse_run){ 0 };
    return LW_OK;
}

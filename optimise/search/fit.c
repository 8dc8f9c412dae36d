/* optimise/search/fit.c - options, candidates and the problems made of them. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "optimise/search/fit_internal.h"

lw_fit_options lw_fit_options_default(void)
{
    return (lw_fit_options){ .spec = lw_fit_spec_default(), .types = "fourbar", .seed = 1,
                             .n_result = 10 };
}

int lw_fit_kept(const lw_fit_options *o)
{
    int results = o->n_result > 0 ? o->n_result : 1;
    return o->spec.by_default && results < LW_POOL_MAX ? LW_POOL_MAX : results;
}

int lw_candidate_links(const lw_candidate *c)
{
    return c->family->links > 0 ? c->family->links : c->family->linkage ? c->family->linkage->n_link : 4;
}

void lw_candidate_free(lw_candidate *c)
{
    free(c->input);
    free(c->mode_of);
    free(c->own);
    free(c->report);
    memset(c, 0, sizeof *c);
}

void lw_fit_free(lw_fit *f)
{
    for (int i = 0; i < f->n; i++)
        lw_candidate_free(&f->candidate[i]);
    free(f->candidate);
    free(f->state);
    memset(f, 0, sizeof *f);
}

/* Time kept back for the last polish [s], and at most this part of a time limit. */
#define POLISH_TIME 0.5
#define POLISH_PART 0.1
/* For the last polish when the user stops the search [s]: who stops it does not want to wait. */
#define LAST_POLISH 0.1
/* And for the front. */
#define WIDEN_PART  0.2

double lw_search_grace(const lw_search *s)
{
    if (s->o->interrupt && *s->o->interrupt)
        return LAST_POLISH;
    return s->o->max_seconds > 0 ? fmin(POLISH_TIME, POLISH_PART*s->o->max_seconds) : POLISH_TIME;
}

bool lw_search_widens(const lw_search *s)
{
    const lw_fit_options *o = s->o;
    bool sizes = lw_task_has_place(o->spec.task) || o->spec.length_ratio > 0;
    return o->spec.by_default && sizes && lw_fit_kept(o) >= LW_SEARCH_LEFT;
}

double lw_search_widening(const lw_search *s)
{
    return lw_search_widens(s) && !s->o->no_front ? WIDEN_PART*s->o->max_seconds : 0;
}

double lw_search_end(const lw_search *s)
{
    return s->o->max_seconds > 0 ? s->started + s->o->max_seconds - lw_search_grace(s) - lw_search_widening(s) : 0;
}

bool lw_search_stopped(const lw_search *s)
{
    return (s->o->interrupt && *s->o->interrupt) || (s->o->max_seconds > 0 && lw_clock_wall() > lw_search_end(s));
}

long lw_search_budget(const lw_search *s)
{
    return s->o->budget > 0 ? s->o->budget : LW_FIT_BUDGET;
}

/* Measured on closed targets compared both ways: with a condition on the transmission angle an evaluation of groups costs
 * three times as much as otherwise, one of dyads the same. */
int lw_search_group_cost(const lw_search *s)
{
    return s->o->spec.timing == LW_TIMING_NONE && s->o->spec.min_transmission > 0 ? 3*LW_HIGHER_COST : LW_HIGHER_COST;
}

/* Less a job for families of any linkage: they have more variables, their starts cost more, and there are many of them.
 * Higher groups cost most. */
lw_effort lw_search_effort(const lw_search *s, const lw_problem *p)
{
    if (!s->o->families)
        return (lw_effort){ LW_SEARCH_BLOCK, 100, 12, 1 };
    return p->plan.n_higher > 0 ? (lw_effort){ 40, 10, 3, lw_search_group_cost(s) } : (lw_effort){ 96, 24, 6, 1 };
}

/* ---- families ------------------------------------------------------------------------------------------- */

/* Is this type requested?  `types` is "all", or names and letters with commas between. */
static bool type_requested(const char *types, const lw_type *type)
{
    const char *names[] = { type->letters, type->name };
    if (strcmp(types, "all") == 0)
        return true;
    for (int i = 0; i < 2; i++)
        for (const char *at = types; (at = strstr(at, names[i])); at++) {
            size_t n = strlen(names[i]);
            if ((at == types || at[-1] == ',') && (at[n] == 0 || at[n] == ','))
                return true;
        }
    return false;
}

static bool family_requested(const lw_target *t, const lw_fit_options *o, const lw_family *f)
{
    bool must_turn = t->closed && lw_task_has_place(o->spec.task) && o->spec.by_default & LW_LIMIT_MOTION;
    if (!type_requested(o->types, lw_type_find(f->type)))
        return false;
    if (o->spec.crank_only && !f->turns)
        return false;
    if (o->part != LW_FIT_WHOLE && (o->part != LW_FIT_OTHERS) != (f->turns && !f->drag_link))
        return false;
    if ((o->part == LW_FIT_OTHERS || o->both_ways) && must_turn && !f->turns)
        return false;
    return !(o->spec.exclude_drag_link && f->drag_link);
}

static void note_skipped(lw_fit *out, const lw_family *f, const lw_error *e)
{
    const char *title = lw_type_find(f->type)->title;
    size_t n = strlen(out->skipped);
    if (!strstr(out->skipped, title))                       /* each type once, not each of its families */
        snprintf(out->skipped + n, sizeof out->skipped - n, "%s%s (%.60s)", n ? ", " : "", title, e->text);
}

lw_status lw_search_family(const lw_search *s, int candidate, lw_family_made *made, const lw_family **family)
{
    assert(candidate >= 0 && (s->o->families || s->candidate[candidate].row));
    const lw_search_candidate *a = &s->candidate[candidate];
    *family = a->row ? a->row : &made->family;
    return a->row ? LW_OK : s->o->families->make(s->o->families->of, candidate, made);
}

/* ---- problems of a thread ------------------------------------------------------------------------------- */

static lw_status make_slot(const lw_search *s, int candidate, bool coarse, lw_slot *slot, lw_error *e)
{
    const lw_search_candidate *c = &s->candidate[candidate];
    const lw_family *f;
    if (slot->candidate >= 0)
        lw_problem_free(&slot->problem);
    slot->candidate = -1;
    lw_status st = lw_search_family(s, candidate, &slot->made, &f);
    if (st == LW_OK)
        st = lw_problem_make(coarse ? &s->thin : s->t, &s->o->spec, f, c->mode, c->sense, &slot->problem, e);
    if (st == LW_OK) {
        slot->candidate = candidate;
        slot->coarse = coarse;
    }
    return st;
}

void lw_search_empty_slots(lw_workbench *b)
{
    for (int k = 0; b->slot && k < LW_SLOTS; k++) {
        if (b->slot[k].candidate >= 0)
            lw_problem_free(&b->slot[k].problem);
        b->slot[k].candidate = -1;
    }
}

/* The slot that holds the problem, else the one that was not used for the longest time. */
static lw_slot *find_slot(lw_workbench *b, int candidate, bool coarse)
{
    lw_slot *oldest = b->slot;
    for (int i = 0; i < LW_SLOTS; i++) {
        if (b->slot[i].candidate == candidate && b->slot[i].coarse == coarse)
            return &b->slot[i];
        if (b->slot[i].used < oldest->used)
            oldest = &b->slot[i];
    }
    return oldest;
}

const lw_problem *lw_search_made(lw_search *s, int thread, int candidate, bool coarse, lw_status *st)
{
    lw_workbench *b = &s->bench[thread];
    bool thin = coarse && s->thin.n > 0;
    lw_slot *slot = find_slot(b, candidate, thin);
    *st = slot->candidate == candidate && slot->coarse == thin ? LW_OK : make_slot(s, candidate, thin, slot, NULL);
    slot->used = ++b->used;
    if (*st == LW_E_MEMORY)
        s->no_memory = true;
    return *st == LW_OK ? &slot->problem : NULL;
}

/* Replace the scratch by a larger one if it is too small. */
static bool make_work(lw_workbench *b, size_t size)
{
    if (size <= b->work_size)
        return true;
    free(b->work);
    b->work_size = (size + size/4 + 127) & ~(size_t)63;
    if (!(b->work = aligned_alloc(64, b->work_size)))
        b->work_size = 0;
    return b->work != NULL;
}

lw_problem *lw_search_problem(lw_search *s, int thread, int candidate, bool coarse, lw_status *st)
{
    lw_workbench *b = &s->bench[thread];
    const lw_problem *p = lw_search_made(s, thread, candidate, coarse, st);
    if (p && !make_work(b, lw_problem_work_size(p))) {
        *st = LW_E_MEMORY;
        s->no_memory = true;
    }
    if (*st != LW_OK)
        return NULL;
    b->local = *p;
    lw_problem_work_init(&b->local, b->work);
    return &b->local;
}

lw_status lw_search_fault(lw_search *s, int candidate, lw_error *e)
{
    lw_slot *slot = s->bench[0].slot;
    lw_status st = make_slot(s, candidate, false, slot, e);
    return st == LW_OK ? lw_error_set(e, LW_E_MEMORY, "no memory for the search") : st;
}

/* ---- candidates ----------------------------------------------------------------------------------------- */

/* Add a four-link candidate, if its type can do the task. */
static lw_status add_candidate(lw_search *s, const lw_family *f, int mode, int sense, lw_error *e)
{
    assert(s->n_candidate < LW_SEARCH_CANDIDATE_MAX);
    s->candidate[s->n_candidate] = (lw_search_candidate){ .row = f, .mode = (signed char)mode,
                                                          .sense = (signed char)sense };
    lw_status st = make_slot(s, s->n_candidate, false, s->bench[0].slot, e);
    s->n_candidate += st == LW_OK;
    return st;
}

/* All candidates: families in both modes, and for ordered free timing and functions in both senses. */
static lw_status make_candidates(lw_search *s, lw_fit *out, lw_error *e)
{
    for (const lw_family *f = lw_family_table; f->name; f++) {
        if (!family_requested(s->t, s->o, f))
            continue;
        bool function = !lw_task_has_place(s->o->spec.task) && s->o->spec.datum == LW_DATUM_FREE;
        int senses = s->o->spec.timing == LW_TIMING_FREE || function ? 2 : 1;
        for (int k = 0; k < 2*senses; k++) {
            lw_error why = { .text = "" };
            lw_status st = add_candidate(s, f, k & 1 ? -1 : 1, k & 2 ? -1 : 1, &why);
            if (st == LW_E_KIND && k == 0)
                note_skipped(out, f, &why);
            if (st == LW_E_KIND)
                break;
            if (st != LW_OK) {
                if (e)
                    *e = why;
                return st;
            }
        }
    }
    if (s->n_candidate == 0)
        return lw_error_set(e, LW_E_ARG, "no linkage of the types asked for can do this%s%s%s",
                            s->o->spec.crank_only ? ", since its input must turn fully" : "",
                            out->skipped[0] ? ": " : "", out->skipped);
    return LW_OK;
}

/* A target with more than LONG stations is searched with THIN of them. */
enum { LONG = 48, THIN = 28 };

static void thin_column(const lw_target *t, const double *from, double to[THIN])
{
    for (size_t i = 0; i < THIN && from; i++)
        to[i] = from[t->closed ? i*t->n/THIN : i*(t->n - 1)/(THIN - 1)];
}

/* Weights; all 1 if only stations without weight are left. */
static void thin_weights(const lw_target *t, const double *from, double to[THIN])
{
    double weight = 0;
    thin_column(t, from, to);
    for (size_t i = 0; i < THIN; i++)
        weight += to[i];
    for (size_t i = 0; i < THIN && !(weight > 0); i++)
        to[i] = 1;
}

static lw_status make_thin_target(lw_search *s, lw_error *e)
{
    const lw_target *t = s->t;
    if (t->n <= LONG || !lw_task_has_place(s->o->spec.task))
        return LW_OK;
    double v[4][THIN], weight[THIN], more[LW_ALSO_MAX][4][THIN];
    lw_also also[LW_ALSO_MAX];
    const double *from[4] = { t->x, t->y, t->theta, t->angle };
    for (int c = 0; c < 4; c++)
        thin_column(t, from[c], v[c]);
    thin_weights(t, t->weight, weight);
    for (int k = 0; k < t->n_also; k++) {
        const lw_also *a = &t->also[k];
        thin_column(t, a->x, more[k][0]);
        thin_column(t, a->y, more[k][1]);
        thin_column(t, a->theta, more[k][2]);
        thin_weights(t, a->weight, more[k][3]);
        also[k] = (lw_also){ .x = a->x ? more[k][0] : NULL, .y = a->x ? more[k][1] : NULL,
                             .theta = a->theta ? more[k][2] : NULL, .weight = more[k][3] };
    }
    return lw_target_make_all(THIN, v[0], v[1], t->theta ? v[2] : NULL, t->angle ? v[3] : NULL, weight, also,
                              t->n_also, t->closed, &s->thin, e);
}

lw_status lw_search_make_candidates(lw_search *s, lw_fit *out, lw_error *e)
{
    const lw_families *f = s->o->families;
    lw_status st = s->thin.n > 0 ? LW_OK : make_thin_target(s, e);
    s->candidate = calloc((size_t)(f ? f->n : LW_SEARCH_CANDIDATE_MAX) + 1, sizeof *s->candidate);
    if (!s->candidate)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    if (st == LW_OK && !f) {
        st = make_candidates(s, out, e);
        if (st != LW_OK && st != LW_E_MEMORY && s->own.spec.by_default & LW_LIMIT_TURN && s->n_candidate == 0) {
            s->own.spec.crank_only = s->own.spec.within_limits = false;     /* none of these types can turn */
            out->skipped[0] = 0;
            st = make_candidates(s, out, e);
        }
    }
    if (st != LW_OK || !f)
        return st;
    for (int i = 0; i < f->n; i++)
        s->candidate[i] = (lw_search_candidate){ .mode = 1, .sense = 1 };
    s->n_candidate = f->n;
    return LW_OK;
}

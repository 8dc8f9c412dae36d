/* optimise/search/candidates.c - which problems a search consists of. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "optimise/search/fit_internal.h"

/* Is this type asked for?  `types` is "all", or names and letters separated by commas. */
static bool wanted(const char *types, const lw_type *type)
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

static bool family_wanted(const lw_fit_options *o, const lw_family *f)
{
    if (!wanted(o->types, lw_type_find(f->type)))
        return false;
    if (o->spec.crank_only && !f->turns)
        return false;
    return !(o->spec.exclude_drag_link && f->drag_link);
}

static void note_skipped(lw_fit *out, const lw_family *f, const lw_error *e)
{
    const char *title = lw_type_find(f->type)->title;
    size_t n = strlen(out->skipped);
    if (!strstr(out->skipped, title))                       /* a type once, not each of its families */
        snprintf(out->skipped + n, sizeof out->skipped - n, "%s%s (%.60s)", n ? ", " : "", title,
                 e->text);
}

lw_status lw_search_family(const lw_search *s, int arm, lw_family_made *made, const lw_family **family)
{
    const lw_search_candidate *a = &s->arm[arm];
    *family = a->row ? a->row : &made->family;
    return a->row ? LW_OK : s->o->families->make(s->o->families->of, arm, made);
}

static lw_status make_slot(const lw_search *s, int arm, bool coarse, lw_slot *slot, lw_error *e)
{
    const lw_family *f;
    if (slot->arm >= 0)
        lw_problem_free(&slot->problem);
    slot->arm = -1;
    lw_status st = lw_search_family(s, arm, &slot->made, &f);
    if (st == LW_OK)
        st = lw_problem_make(coarse ? &s->thin : s->t, &s->o->spec, f, s->arm[arm].mode, s->arm[arm].sense,
                             &slot->problem, e);
    if (st == LW_OK) {
        slot->arm = arm;
        slot->coarse = coarse;
    }
    return st;
}

/* The one that holds the problem, else the one that was longest not used. */
static lw_slot *find_slot(lw_workbench *b, int arm, bool coarse)
{
    lw_slot *oldest = b->slot;
    for (int i = 0; i < LW_SLOTS; i++) {
        if (b->slot[i].arm == arm && b->slot[i].coarse == coarse)
            return &b->slot[i];
        if (b->slot[i].used < oldest->used)
            oldest = &b->slot[i];
    }
    return oldest;
}

const lw_problem *lw_search_made(lw_search *s, int thread, int arm, bool coarse, lw_status *st)
{
    lw_workbench *b = &s->bench[thread];
    bool thin = coarse && s->thin.n > 0;
    lw_slot *slot = find_slot(b, arm, thin);
    *st = slot->arm == arm && slot->coarse == thin ? LW_OK : make_slot(s, arm, thin, slot, NULL);
    slot->used = ++b->used;
    return *st == LW_OK ? &slot->problem : NULL;
}

/* Scratch of another size, if that of before is too small. */
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

lw_problem *lw_search_problem(lw_search *s, int thread, int arm, bool coarse, lw_status *st)
{
    lw_workbench *b = &s->bench[thread];
    const lw_problem *p = lw_search_made(s, thread, arm, coarse, st);
    if (p && !make_work(b, lw_problem_work_size(p)))
        *st = LW_E_MEMORY;
    if (*st != LW_OK)
        return NULL;
    b->local = *p;
    lw_problem_work_init(&b->local, b->work);
    return &b->local;
}

lw_status lw_search_fault(lw_search *s, int arm, lw_error *e)
{
    lw_slot *slot = s->bench[0].slot;
    lw_status st = make_slot(s, arm, false, slot, e);
    return st == LW_OK ? lw_error_set(e, LW_E_MEMORY, "no memory for the search") : st;
}

/* An arm of four links, if its type can do the task. */
static lw_status add_arm(lw_search *s, const lw_family *f, int mode, int sense, lw_error *e)
{
    s->arm[s->n_arm] = (lw_search_candidate){ .row = f, .mode = (signed char)mode, .sense = (signed char)sense };
    lw_status st = make_slot(s, s->n_arm, false, s->bench[0].slot, e);
    s->n_arm += st == LW_OK;
    return st;
}

/* All arms: families in both modes, and for ordered free timing in both senses. */
static lw_status make_arms(lw_search *s, lw_fit *out, lw_error *e)
{
    for (const lw_family *f = lw_family_table; f->name; f++) {
        if (!family_wanted(s->o, f))
            continue;
        int senses = s->o->spec.timing == LW_TIMING_FREE ? 2 : 1;
        for (int k = 0; k < 2*senses; k++) {
            lw_error why = { .text = "" };
            lw_status st = add_arm(s, f, k & 1 ? -1 : 1, k & 2 ? -1 : 1, &why);
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
    if (s->n_arm == 0)
        return lw_error_set(e, LW_E_ARG, "no linkage of the types asked for can do this%s%s%s",
                            s->o->spec.crank_only ? ", since its input must turn fully" : "",
                            out->skipped[0] ? ": " : "", out->skipped);
    return LW_OK;
}

enum { MANY = 48, FEW = 28 };

static void thin_column(const lw_target *t, const double *from, double to[FEW])
{
    for (size_t i = 0; i < FEW && from; i++)
        to[i] = from[t->closed ? i*t->n/FEW : i*(t->n - 1)/(FEW - 1)];
}

/* Weights of which something is left. */
static void thin_weights(const lw_target *t, const double *from, double to[FEW])
{
    double weight = 0;
    thin_column(t, from, to);
    for (size_t i = 0; i < FEW; i++)
        weight += to[i];
    for (size_t i = 0; i < FEW && !(weight > 0); i++)
        to[i] = 1;
}

/* Every so-manieth station, for the search on long targets. */
static lw_status thin_out(lw_search *s, lw_error *e)
{
    const lw_target *t = s->t;
    if (t->n <= MANY || s->o->spec.task == LW_TASK_FUNCTION)
        return LW_OK;
    double v[4][FEW], weight[FEW], more[LW_ALSO_MAX][4][FEW];
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
    return lw_target_make_all(FEW, v[0], v[1], t->theta ? v[2] : NULL, t->angle ? v[3] : NULL, weight, also,
                              t->n_also, t->closed, &s->thin, e);
}

lw_status lw_search_make_candidates(lw_search *s, lw_fit *out, lw_error *e)
{
    const lw_families *f = s->o->families;
    lw_status st = thin_out(s, e);
    s->arm = calloc((size_t)(f ? f->n : LW_SEARCH_CANDIDATE_MAX) + 1, sizeof *s->arm);
    if (!s->arm)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    if (st != LW_OK || !f)
        return st == LW_OK ? make_arms(s, out, e) : st;
    for (int i = 0; i < f->n; i++)
        s->arm[i] = (lw_search_candidate){ .mode = 1, .sense = 1 };
    s->n_arm = f->n;
    return LW_OK;
}

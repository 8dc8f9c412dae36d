/* optimise/fit_arms.c - which problems a search consists of. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "optimise/fit_internal.h"

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

static lw_status make_arm(lw_search *s, const lw_family *f, double mode, int sense, lw_error *e)
{
    lw_arm *a = &s->arm[s->n_arm];
    lw_status st = lw_problem_make(s->t, &s->o->spec, f, mode, sense, &a->fine, e);
    if (st != LW_OK)
        return st;
    a->has_coarse = s->thin.n > 0;
    if (a->has_coarse && (st = lw_problem_make(&s->thin, &s->o->spec, f, mode, sense, &a->coarse, e))
            != LW_OK) {
        lw_problem_free(&a->fine);
        return st;
    }
    s->n_arm++;
    return LW_OK;
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
            lw_status st = make_arm(s, f, k & 1 ? -1 : 1, k & 2 ? -1 : 1, &why);
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

/* One arm a family; those that cannot do it say why. */
static lw_status make_family_arms(lw_search *s, lw_fit *out, lw_error *e)
{
    out->n_tried = s->o->n_family;
    out->tried = calloc((size_t)out->n_tried + 1, sizeof *out->tried);
    if (!out->tried)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %d families", out->n_tried);
    for (int i = 0; i < s->o->n_family; i++) {
        lw_error why = { .text = "" };
        lw_fit_try *t = &out->tried[i];
        t->status = make_arm(s, &s->o->family[i], 1, 1, &why);
        t->best = INFINITY;
        snprintf(t->why, sizeof t->why, "%.90s", why.text);
        if (t->status == LW_E_ARG || t->status == LW_E_MEMORY) {
            if (e)
                *e = why;
            return t->status;
        }
        if (t->status != LW_OK)
            continue;
        lw_arm *a = &s->arm[s->n_arm - 1];
        a->family = i;
        if (!(a->best = calloc(1, sizeof *a->best)))
            return lw_error_set(e, LW_E_MEMORY, "no memory for the finds of a family");
    }
    return LW_OK;
}

lw_status lw_search_arms(lw_search *s, lw_fit *out, lw_error *e)
{
    lw_status st = thin_out(s, e);
    s->arm = calloc((size_t)(s->o->family ? s->o->n_family : LW_ARM_MAX) + 1, sizeof *s->arm);
    if (!s->arm)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    if (st != LW_OK)
        return st;
    return s->o->family ? make_family_arms(s, out, e) : make_arms(s, out, e);
}

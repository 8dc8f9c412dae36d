/* optimise/search/fit_run.c - rounds until the search ends, and what the caller gets. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "optimise/search/fit_internal.h"
#include "optimise/search/start.h"

enum {
    HITS = 100,             /* if different starts found the best this often, a better one is unlikely */
    NO_LIMIT = 100000       /* rounds                                                                */
};
#define EXACT 1e-27         /* f of one station, of a target of size one, that is only rounding      */

static int rounds_of(const lw_search *s)
{
    /* A job takes about five milliseconds at eighteen stations.  500 jobs for one family of cranks solve every
     * published path problem with a margin (docs/benchmarks.md); several families share 700. */
    if (s->o->max_rounds > 0 || s->o->families || s->n_job == 0)
        return s->o->max_rounds > 0 ? s->o->max_rounds : NO_LIMIT;
    const lw_target *t = s->thin.n ? &s->thin : s->t;
    double of_eighteen = s->n_job > 16 ? 700.0 : 500.0;
    double jobs = of_eighteen*45/((double)t->n + 27);
    const lw_fit_spec *q = &s->o->spec;
    if (q->min_transmission > 0 || q->max_acceleration > 0 || q->n_zone > 0)      /* a job costs twice as much */
        jobs *= 0.5;
    if (s->o->part == LW_FIT_OTHERS || s->o->part == LW_FIT_COMPACT || s->o->both_ways)    /* after another search */
        jobs *= 0.4;
    int rounds = (int)(jobs/s->n_job + 0.5);
    return rounds < 5 ? 5 : rounds;
}

static lw_status make_benches(lw_search *s)
{
    s->n_thread = s->o->jobs > 0 ? s->o->jobs : lw_core_count();
    s->bench = calloc((size_t)s->n_thread, sizeof *s->bench);
    for (int i = 0; s->bench && i < s->n_thread; i++) {
        s->bench[i].slot = calloc(LW_SLOTS, sizeof *s->bench[i].slot);
        for (int k = 0; s->bench[i].slot && k < LW_SLOTS; k++)
            s->bench[i].slot[k].candidate = -1;
        s->bench[i].draws = malloc(sizeof(double)*LW_SEARCH_BLOCK*LW_START_DRAWS);
        if (!s->bench[i].slot || !s->bench[i].draws)
            return LW_E_MEMORY;
    }
    return s->bench ? LW_OK : LW_E_MEMORY;
}

static void bench_free(lw_workbench *b)
{
    lw_search_empty_slots(b);
    free(b->slot);
    free(b->work);
    free(b->draws);
}

static void search_free(lw_search *s)
{
    for (int i = 0; s->bench && i < s->n_thread; i++)
        bench_free(&s->bench[i]);
    for (int i = 0; i < s->n_candidate; i++)
        free(s->candidate[i].best);
    free(s->bench);
    free(s->candidate);
    free(s->sweep.order);
    free(s->sweep.candidate);
    free(s->found);
    lw_target_free(&s->thin);
    free(s);
}

/* This part of the rounds, as their number. */
static int part_of(int rounds, double part) { return (int)ceil(rounds*part - 1e-9); }

static double done_part(const lw_search *s, int rounds)
{
    double rounded = (s->round + 1.0)/rounds;
    return s->o->families ? fmax(rounded, fmin(1, (double)s->evals/(double)lw_search_budget(s))) : rounded;
}

/* Show the caller the best find, if it is better than the last one shown. */
static void show_best(lw_search *s, lw_found *shown)
{
    const lw_found *best = s->pool.item;
    lw_candidate c;
    if (!s->o->found || s->pool.n == 0 || best->beyond > shown->beyond || (best->beyond == shown->beyond && !(best->f < shown->f)))
        return;
    if (lw_search_fill(s, 0, best, &c)) {
        s->o->found(s->o->context, &c);
        lw_candidate_free(&c);
        shown->beyond = best->beyond;
        shown->f = best->f;
    }
}

/* Call the user's progress functions. */
static void report_progress(lw_search *s, int rounds, double *least, lw_found *shown)
{
    show_best(s, shown);
    double best = s->pool.n && !s->pool.item[0].beyond ? s->pool.item[0].f : INFINITY, now = lw_clock_wall() - s->started;
    lw_status st;
    const lw_problem *p = s->pool.n ? lw_search_made(s, 0, s->pool.item[0].candidate, false, &st) : NULL;
    double value = p ? best*p->scale : INFINITY;
    if (s->o->progress)
        s->o->progress(s->o->context, done_part(s, rounds), now, value);
    if (s->o->improved && best < *least)
        s->o->improved(s->o->context, s->evals, now, value);
    *least = fmin(*least, best);
}

static lw_status search_rounds(lw_search *s, lw_stop *stop, lw_error *e)
{
    double least = INFINITY;
    lw_found shown = { .f = INFINITY, .beyond = INT_MAX };
    int rounds = rounds_of(s), first = part_of(rounds, s->o->rounds_from);
    if (s->o->rounds_to > 0)
        rounds = part_of(rounds, s->o->rounds_to);
    *stop = LW_STOP_EVALS;
    for (s->round = first; s->round < rounds && s->n_job > 0; s->round++) {
        lw_status st = lw_search_round(s, e);
        if (st == LW_OK && s->no_memory)
            st = LW_E_MEMORY;
        if (st != LW_OK)
            return st;
        report_progress(s, rounds, &least, &shown);
        if (s->o->interrupt && *s->o->interrupt)
            *stop = LW_STOP_USER;
        else if (lw_search_stopped(s))
            *stop = LW_STOP_TIME;
        else if (least <= EXACT*(double)s->t->n)
            *stop = LW_STOP_F_TARGET;
        else if (s->hits >= HITS && s->round >= 2 && !s->o->families)
            *stop = LW_STOP_F_TOL;
        if (*stop != LW_STOP_EVALS || (s->o->families && s->evals >= lw_search_budget(s)))
            break;
        lw_search_halving(s);
    }
    return LW_OK;
}

static lw_status describe(const lw_search *s, lw_fit *out)
{
    out->improved = s->improved;
    out->evals = s->evals;
    out->rounds = s->round + (out->stop != LW_STOP_EVALS);       /* the round in which it stopped counts too */
    out->starts = s->starts;
    for (int i = 0; i < s->n_candidate; i++)
        out->starts += s->candidate[i].starts;
    out->n_state = s->o->families ? s->n_candidate : 0;
    out->state = malloc((size_t)out->n_state + 1);
    for (int i = 0; out->state && i < out->n_state; i++)
        out->state[i] = (unsigned char)s->candidate[i].state;
    return out->state ? LW_OK : LW_E_MEMORY;
}

static lw_status search_all(lw_search *s, lw_fit *out, lw_error *e)
{
    lw_status st = make_benches(s);
    if (st == LW_OK)
        st = lw_search_make_candidates(s, out, e);
    if (st == LW_OK)
        st = lw_search_halving_begin(s);
    if (st != LW_OK)
        return st;
    lw_search_halving(s);
    st = search_rounds(s, &out->stop, e);
    if (st == LW_OK && s->o->both_ways)
        st = lw_search_order_stations(s, out, e);
    if (st == LW_OK && (!s->o->no_front || out->stop == LW_STOP_F_TARGET))
        st = lw_search_widen(s, lw_search_climb);
    if (st == LW_OK)
        st = lw_search_rank(s, out);
    if (st == LW_OK && s->no_memory)
        st = LW_E_MEMORY;
    return st == LW_OK ? describe(s, out) : st;
}

lw_status lw_fit_run(const lw_target *t, const lw_fit_options *o, lw_fit *out, lw_error *e)
{
    memset(out, 0, sizeof *out);
    lw_search *s = calloc(1, sizeof *s);
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    s->t = t;
    s->own = *o;
    s->o = &s->own;
    if (o->part == LW_FIT_CRANKS || o->part == LW_FIT_COMPACT)
        s->own.spec.crank_only = s->own.spec.exclude_drag_link = true;
    if (o->part == LW_FIT_COMPACT && lw_task_has_place(o->spec.task))
        s->own.spec.max_size = LW_COMPACT_SIZE;
    else if (o->part == LW_FIT_COMPACT)
        s->own.spec.length_ratio = LW_COMPACT_RATIO;
    if (o->both_ways)
        s->own.spec.timing = LW_TIMING_NONE;
    s->started = lw_clock_wall();
    s->best_raw = INFINITY;
    s->light.by_cost = true;
    lw_status st = search_all(s, out, e);
    out->seconds = lw_clock_wall() - s->started;
    search_free(s);
    if (st == LW_E_MEMORY)
        lw_error_set(e, st, "no memory for the search");
    if (st != LW_OK) {
        lw_fit_free(out);
        return st;
    }
    if (out->stop == LW_STOP_TIME || out->stop == LW_STOP_USER)
        return LW_STOPPED;
    return out->n == 0 ? LW_NOTHING : LW_OK;
}

#include "optimise/fit.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "optimise/fit_internal.h"

enum { HITS = 100 };        /* found this often by different starts: nothing better is likely     */
enum { BUDGET = 1000000 };  /* evaluations of a search over families, when nobody says           */
#define EXACT 1e-27         /* f of one station, of size one, that is rounding                    */

lw_fit_options lw_fit_options_default(void)
{
    return (lw_fit_options){ .spec = lw_fit_spec_default(), .types = "fourbar", .seed = 1,
                             .n_result = 10 };
}

static int rounds_of(const lw_search *s)
{
    /* Jobs of about five milliseconds each at eighteen stations: 500 of them for one family of cranks
     * are enough for every published path problem with margin (docs/benchmarks.md); further families
     * take their share of more. */
    const lw_target *t = s->thin.n ? &s->thin : s->t;
    double share = s->n_job > 16 ? 700.0 : 500.0;
    double jobs = share*45/((double)t->n + 27);
    int rounds = (int)(jobs/s->n_job + 0.5);
    if (s->o->max_rounds > 0)
        return s->o->max_rounds;
    return s->o->family ? 100000 : rounds < 5 ? 5 : rounds;
}

/* Families of any linkage have more variables and dearer starts, and there are more of them; higher groups are
 * dearer still. */
static void size_jobs(lw_search *s)
{
    for (int i = 0; i < s->n_arm; i++) {
        lw_arm *a = &s->arm[i];
        bool any = s->o->family != NULL, higher = a->fine.plan.n_higher > 0;
        a->block = higher ? 40 : any ? 96 : LW_BLOCK;
        a->settle = higher ? 10 : any ? 24 : 100;
        a->improve = higher ? 3 : any ? 6 : 12;
        a->cost = higher ? LW_HIGHER_COST : 1;
    }
}

static lw_status make_room(lw_search *s)
{
    size_t bytes = 0;
    for (int i = 0; i < s->n_arm; i++) {
        size_t need = lw_problem_work_size(&s->arm[i].fine);
        bytes = need > bytes ? need : bytes;
    }
    s->n_thread = s->o->jobs > 0 ? s->o->jobs : lw_core_count();
    s->found = malloc(sizeof *s->found*(size_t)(LW_JOB_MAX*LW_KEEP));
    s->evals = calloc(LW_JOB_MAX, sizeof *s->evals);
    s->improved = calloc(LW_JOB_MAX, sizeof *s->improved);
    s->work = calloc((size_t)s->n_thread, sizeof *s->work);
    s->local = calloc((size_t)s->n_thread, sizeof *s->local);
    if (!s->found || !s->evals || !s->improved || !s->work || !s->local)
        return LW_E_MEMORY;
    for (int i = 0; i < s->n_thread; i++)
        if (!(s->work[i] = aligned_alloc(64, (bytes + 127) & ~(size_t)63)))
            return LW_E_MEMORY;
    size_jobs(s);
    lw_search_share(s, 0);
    return LW_OK;
}

static void search_free(lw_search *s)
{
    for (int i = 0; i < s->n_arm; i++) {
        lw_problem_free(&s->arm[i].fine);
        if (s->arm[i].has_coarse)
            lw_problem_free(&s->arm[i].coarse);
        free(s->arm[i].best);
    }
    free(s->arm);
    free(s->local);
    for (int i = 0; s->work && i < s->n_thread; i++)
        free(s->work[i]);
    lw_target_free(&s->thin);
    free(s->work);
    free(s->found);
    free(s->evals);
    free(s->improved);
    free(s);
}

static long evals_of(const lw_search *s)
{
    long sum = 0;
    for (int i = 0; i < LW_JOB_MAX; i++)
        sum += s->evals[i];
    return sum;
}

static long budget_of(const lw_search *s)
{
    return s->o->budget > 0 ? s->o->budget : BUDGET;
}

static double done_share(const lw_search *s, int rounds)
{
    double rounded = (s->round + 1.0)/rounds;
    return s->o->family ? fmax(rounded, fmin(1, (double)evals_of(s)/(double)budget_of(s))) : rounded;
}

static lw_stop search_rounds(lw_search *s)
{
    double least = INFINITY;
    int rounds = rounds_of(s);
    for (s->round = 0; s->round < rounds && s->n_job > 0; s->round++) {
        lw_search_round(s);
        double best = s->pool.n ? s->pool.item[0].f : INFINITY, now = lw_clock_wall() - s->started;
        if (s->o->progress)
            s->o->progress(s->o->context, done_share(s, rounds), now, best*s->arm[0].fine.scale);
        if (s->o->improved && best < least)
            s->o->improved(s->o->context, evals_of(s), now, best*s->arm[0].fine.scale);
        least = fmin(least, best);
        if (s->o->interrupt && *s->o->interrupt)
            return LW_STOP_USER;
        if (lw_search_stopped(s))
            return LW_STOP_TIME;
        if (best <= EXACT*(double)s->t->n)
            return LW_STOP_F_TARGET;
        if (s->hits >= HITS && s->round >= 2 && !s->o->family)
            return LW_STOP_F_TOL;
        if (s->o->family && evals_of(s) >= budget_of(s))
            break;
        lw_search_share(s, s->round + 1);
    }
    return LW_STOP_EVALS;
}

static void describe_tries(const lw_search *s, lw_fit *out)
{
    for (int i = 0; s->o->family && i < s->n_arm; i++) {
        const lw_arm *a = &s->arm[i];
        lw_fit_try *t = &out->tried[a->family];
        t->starts = a->starts;
        t->improved = a->improved;
        if (a->best->n > 0)
            t->best = a->best->item[0].f*(a->has_coarse ? a->coarse.scale : a->fine.scale);
    }
}

lw_status lw_fit_run(const lw_target *t, const lw_fit_options *o, lw_fit *out, lw_error *e)
{
    memset(out, 0, sizeof *out);
    lw_search *s = calloc(1, sizeof *s);
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    s->t = t;
    s->o = o;
    s->started = lw_clock_wall();
    s->best_raw = INFINITY;
    lw_status st = lw_search_arms(s, out, e);
    if (st == LW_OK && s->n_arm > 0 && (st = make_room(s)) == LW_OK) {
        out->stop = search_rounds(s);
        st = lw_search_rank(s, out);
        for (int i = 0; i < LW_JOB_MAX; i++)
            out->improved += s->improved[i];
        out->evals = evals_of(s);
        describe_tries(s, out);
    }
    out->rounds = s->round + (out->stop != LW_STOP_EVALS);       /* it ended in a round, or after all */
    for (int i = 0; i < s->n_arm; i++)
        out->starts += s->arm[i].starts;
    out->seconds = lw_clock_wall() - s->started;
    search_free(s);
    if (st == LW_E_MEMORY)
        return lw_error_set(e, st, "no memory for the search");
    if (st == LW_OK && (out->stop == LW_STOP_TIME || out->stop == LW_STOP_USER))
        return LW_STOPPED;
    return st == LW_OK && out->n == 0 ? LW_NOTHING : st;
}

void lw_fit_free(lw_fit *f)
{
    for (int i = 0; i < f->n; i++) {
        free(f->candidate[i].input);
        free(f->candidate[i].mode_of);
    }
    free(f->candidate);
    free(f->tried);
    memset(f, 0, sizeof *f);
}

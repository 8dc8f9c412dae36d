/* cli/bench/bench_links.c - error over number of links and time: every problem is searched with four links, then six,
 * then eight; the best linkage with each number of links is listed with its time. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "catalogues/pages/draw.h"
#include "catalogues/draw/plot.h"
#include "cli/bench/bench.h"
#include "optimise/topology/topology_search.h"

enum { POINT_MAX = 512 };

/* The best error so far; stage counts the search's numbers of links. */
typedef struct point { int stage; long evals; double seconds, error; } point;

typedef struct watch {
    double started, least[LW_STAGE_MAX];
    int    stage, n;
    long   last;
    point  p[POINT_MAX];
    int    stop;
} watch;

/* The best linkage with at most this many links, simulated a second time. */
typedef struct best {
    int    links;
    char   name[64];
    double objective, percent, seconds;
    lw_likeness likeness;
} best;

typedef struct cli_bench_outcome { int n; best best[LW_STAGE_MAX]; watch watch; } outcome;

static void record(void *context, long evals, double seconds, double error)
{
    watch *w = context;
    (void)seconds;
    w->stage += evals < w->last;               /* the count of evaluations starts again at 0 for each number of links */
    w->last = evals;
    w->stop |= cli_interrupted();
    if (w->n < POINT_MAX)
        w->p[w->n++] = (point){ w->stage, evals, lw_clock_wall() - w->started, error };
}

static void look_for_interrupt(void *context, double done, double seconds, double error)
{
    watch *w = context;
    (void)done; (void)seconds; (void)error;
    w->stop |= cli_interrupted();
}

static void pick_best(const lw_topology_search *s, outcome *out)
{
    double seconds = 0;
    out->n = s->found.n_stage;
    for (int k = 0; k < out->n; k++) {
        best *b = &out->best[k];
        seconds += s->found.stage[k].seconds;
        *b = (best){ .links = s->found.stage[k].links, .objective = INFINITY, .percent = NAN, .seconds = seconds,
                     .likeness = { NAN, NAN, NAN, NAN } };
        for (int i = 0; i < s->results.n; i++) {
            const lw_candidate *c = &s->found.fit.candidate[s->results.candidate[i]];
            if (lw_candidate_links(c) > b->links || c->objective >= b->objective)
                continue;
            b->objective = c->objective;
            b->percent = s->results.report[i].error_percent;
            b->likeness = s->results.report[i].likeness;
            snprintf(b->name, sizeof b->name, "%s", lw_family_title(c->family));
        }
    }
}

static lw_status run_one(const cli_bench_problem *p, const cli_bench_links *o, outcome *out, lw_error *e)
{
    lw_topology_search found;
    lw_topology_search_options t = lw_topology_search_options_default();
    t.links = o->links;
    t.fit.spec = p->spec;
    if (o->both_ways && t.fit.spec.timing == LW_TIMING_FREE)
        t.fit.spec.timing = LW_TIMING_NONE;
    t.fit.seed = o->seed;
    t.fit.jobs = o->jobs;
    t.fit.budget = o->budget;
    t.fit.n_result = 12;
    t.fit.interrupt = &out->watch.stop;
    t.fit.progress = look_for_interrupt;
    t.fit.improved = record;
    t.fit.context = &out->watch;
    out->watch.started = lw_clock_wall();
    lw_status st = lw_topology_search_run(&p->target, &t, &found, e);
    if (st == LW_OK || st == LW_STOPPED) {
        pick_best(&found, out);
        lw_topology_search_free(&found);
    }
    return st < 0 ? st : LW_OK;
}


static void print_rows(const cli_bench_problem *p, const outcome *out, FILE *f)
{
    for (int k = 0; k < out->n; k++) {
        const best *b = &out->best[k];
        fprintf(f, "| %-18s | %2d | %.4g | %.3g | %.3g | %.3g | %6.1f | %s |\n", p->name, b->links,
                b->percent, b->objective, b->likeness.chamfer, b->likeness.ordered,
                b->seconds, b->name[0] ? b->name : "none");
    }
}

/* Print the mean over the problems for each number of links. */
static void print_means(const outcome *out, int n, FILE *f)
{
    for (int k = 0; n > 1 && k < out[0].n; k++) {
        double percent = 0, chamfer = 0, ordered = 0, seconds = 0;
        int count = 0;
        for (int i = 0; i < n; i++) {
            const best *b = &out[i].best[k];
            if (k >= out[i].n || !isfinite(b->likeness.chamfer))
                continue;
            percent += b->percent;
            chamfer += b->likeness.chamfer;
            ordered += b->likeness.ordered;
            seconds += b->seconds;
            count++;
        }
        if (count > 0)
            fprintf(f, "| mean of %-10d | %2d | %.4g | | %.3g | %.3g | %6.1f | |\n", count, out[0].best[k].links,
                    percent/count, chamfer/count, ordered/count, seconds/count);
    }
}

static lw_status save_csv(const cli_bench *b, const outcome *out, const char *folder, lw_error *e)
{
    char path[CLI_PATH_SIZE];
    lw_output o;
    snprintf(path, sizeof path, "%s/links.csv", folder);
    lw_status st = lw_output_open(&o, path, e);
    if (st != LW_OK)
        return st;
    fprintf(o.f, "# %s\nproblem,links,evaluations,seconds,objective\n", b->machine);
    for (int i = 0; i < b->n_problem; i++)
        for (int k = 0; k < out[i].watch.n; k++) {
            const point *p = &out[i].watch.p[k];
            int links = p->stage < out[i].n ? out[i].best[p->stage].links : 0;
            fprintf(o.f, "%s,%d,%ld,%.4f,%.9g\n", b->problem[i].name, links, p->evals, p->seconds, p->error);
        }
    return lw_output_commit(&o, e);
}

/* Save one plot per problem, with a line for each number of links. */
static lw_status save_plot(const cli_bench_problem *p, const outcome *out, const char *folder, lw_error *e)
{
    double x[POINT_MAX], y[POINT_MAX];
    lw_series series[LW_STAGE_MAX];
    char name[LW_STAGE_MAX][32], path[CLI_PATH_SIZE], label[64];
    lw_plot plot = { .title = p->name, .x_label = "time [s]", .y_label = label,
                     .log_x = true, .log_y = true, .series = series };
    cli_bench_error_label(p, label, sizeof label);
    for (int k = 0, at = 0; k < out->n; k++) {
        int first = at;
        for (; at < out->watch.n && out->watch.p[at].stage == k; at++) {
            x[at] = out->watch.p[at].seconds;
            y[at] = out->watch.p[at].error;
        }
        snprintf(name[k], sizeof name[k], "%d links", out->best[k].links);
        series[plot.n_series++] = (lw_series){ name[k], (size_t)(at - first), x + first, y + first, true };
    }
    snprintf(path, sizeof path, "%s/links-%s.svg", folder, p->name);
    lw_status st = lw_draw_plot(&plot, path, e);
    return st == LW_NOTHING ? LW_OK : st;
}

static lw_status save_all(const cli_bench *b, const outcome *out, const char *folder, lw_error *e)
{
    lw_status st = save_csv(b, out, folder, e);
    for (int i = 0; i < b->n_problem && st == LW_OK; i++)
        st = save_plot(&b->problem[i], &out[i], folder, e);
    return st;
}

lw_status cli_bench_links_begin(const cli_bench *b, cli_bench_links *o, lw_error *e)
{
    o->outcome = calloc((size_t)b->n_problem + 1, sizeof *o->outcome);
    return o->outcome ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void cli_bench_links_free(cli_bench_links *o)
{
    free(o->outcome);
    o->outcome = NULL;
}

lw_status cli_bench_links_one(const cli_bench_problem *p, const cli_bench_links *o, lw_bytes *answer, lw_error *e)
{
    outcome *out = calloc(1, sizeof *out);
    lw_status st = out ? run_one(p, o, out, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        lw_bytes_add(answer, out, sizeof *out);
    free(out);
    return st == LW_OK && cli_interrupted() ? LW_STOPPED : st;
}

lw_status cli_bench_links_take(cli_bench_links *o, int problem, const char *answer, size_t size, lw_error *e)
{
    if (size != sizeof *o->outcome)
        return lw_error_set(e, LW_E_NOTATION, "the kept runs are of another benchmark");
    memcpy(&o->outcome[problem], answer, size);
    return LW_OK;
}

lw_status cli_bench_links_end(const cli_bench *b, const cli_bench_links *o, lw_error *e)
{
    int done = 0;
    printf("%s\n\n| problem | links | %% of path | objective | Chamfer | ordered | s | linkage |\n"
           "|---|---|---|---|---|---|---|---|\n", b->machine);
    for (; done < b->n_problem && o->outcome[done].n > 0; done++)
        print_rows(&b->problem[done], &o->outcome[done], stdout);
    print_means(o->outcome, done, stdout);
    return o->folder ? save_all(b, o->outcome, o->folder, e) : LW_OK;
}

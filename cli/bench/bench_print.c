/* cli/bench/bench_print.c - output of a benchmark: Markdown tables, CSV, plots. */
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/real.h"
#include "base/vector.h"
#include "catalogues/pages/draw.h"
#include "cli/bench/bench.h"

#ifdef __clang__
#define COMPILER "clang " __clang_version__
#else
#define COMPILER "gcc " __VERSION__
#endif

void cli_bench_machine(char *text, size_t size)
{
    char line[160] = "", cpu[128] = "unknown processor";
    FILE *f = fopen("/proc/cpuinfo", "r");
    while (f && fgets(line, sizeof line, f))
        if (strncmp(line, "model name", 10) == 0 && strchr(line, ':')) {
            snprintf(cpu, sizeof cpu, "%s", strchr(line, ':') + 2);
            cpu[strcspn(cpu, "\n")] = 0;
            break;
        }
    if (f)
        fclose(f);
    snprintf(text, size, "%s | %s, %d cores | linkwright %s", COMPILER, cpu, lw_core_count(), LW_VERSION);
}

/* The error with which a problem is compared: the reachable one, else the least error in this benchmark. */
static double compared_error(const cli_bench *b, const cli_bench_problem *p)
{
    double least = INFINITY;
    for (int i = 0; i < b->n_curve; i++)
        if (b->curve[i].problem == p)
            least = fmin(least, cli_bench_error(&b->curve[i]));
    return p->known->reachable > 0 ? p->known->reachable : least;
}

static double best_published(const cli_bench_figures *k)
{
    double least = INFINITY;
    for (int i = 0; i < CLI_PUBLISHED_MAX && k->published[i].who; i++)
        least = fmin(least, k->published[i].error);
    return least;
}

/* ---- tables -------------------------------------------------------------------------------------- */

static void print_number(FILE *f, double v, int digits)
{
    if (isfinite(v))
        fprintf(f, " %.*g |", digits, v);
    else
        fputs(" - |", f);
}

static void bounds_text(const cli_bench_figures *k, char *text, size_t size)
{
    if (k->length[1] > 0)
        snprintf(text, size, "lengths %g:%g, positions %g:%g%s", k->length[0], k->length[1],
                 k->position[0], k->position[1], k->at_origin ? ", frame fixed" : "");
    else
        snprintf(text, size, "none");
}

/* Print one row: how often the error was reached, how fast, and the worst run. */
static void reach_row(const cli_bench *b, int i, double *seconds, double *evals, FILE *f)
{
    const cli_bench_problem *p = &b->problem[i];
    double worst = -INFINITY;
    int n = 0;
    char bounds[96];
    for (int k = 0; k < b->reach_done[i]; k++) {
        const cli_bench_reach *r = &b->reach[i*b->n_seed + k];
        worst = fmax(worst, r->error);
        if (!r->reached)
            continue;
        evals[n] = (double)r->evals;
        seconds[n++] = r->seconds;
    }
    lw_sort((size_t)n, seconds);
    lw_sort((size_t)n, evals);
    bounds_text(p->known, bounds, sizeof bounds);
    fprintf(f, "| %s | %s |", p->name, bounds);
    print_number(f, best_published(p->known), 5);
    print_number(f, p->known->reachable > 0 ? p->known->reachable : INFINITY, 5);
    fprintf(f, " %d of %d |", n, b->reach_done[i]);
    print_number(f, n ? seconds[n/2] : INFINITY, 2);
    print_number(f, n ? seconds[n - 1] : INFINITY, 2);
    print_number(f, n ? evals[n/2] : INFINITY, 6);
    print_number(f, worst, 5);
    fputc('\n', f);
}

static void reach_table(const cli_bench *b, FILE *f)
{
    size_t n = (size_t)b->n_seed;
    double *numbers = malloc(sizeof *numbers*2*n);
    if (!numbers)
        return;
    fprintf(f, "The default strategy on %d threads until it is within 1 %% of the reachable error, %g s at "
            "most:\n\n| problem | bounds | best published | reachable | reached | median s | slowest s | "
            "median evaluations | worst error |\n|---|---|---|---|---|---|---|---|---|\n", b->jobs, b->limit);
    for (int i = 0; i < b->n_problem; i++)
        reach_row(b, i, numbers, numbers + n, f);
    free(numbers);
}

static const cli_bench_curve *find_curve(const cli_bench *b, const char *solver, int problem)
{
    for (int i = 0; i < b->n_curve; i++)
        if (b->curve[i].problem == &b->problem[problem] && strcmp(b->curve[i].solver, solver) == 0)
            return &b->curve[i];
    return NULL;
}

static void curve_cell(const cli_bench *b, const cli_bench_curve *c, FILE *f)
{
    double when = c ? cli_bench_when(c, CLI_WITHIN*compared_error(b, c->problem)) : NAN;
    if (isfinite(when))
        fprintf(f, " %.2g s |", when);
    else if (c && c->n)
        fprintf(f, " (%.3g) |", cli_bench_error(c));
    else
        fputs(" - |", f);
}

static void solver_table(const cli_bench *b, FILE *f)
{
    fprintf(f, "\nEach solver for %g s on one core: seconds until it is within 1 %% of the reachable error, "
            "or (the error\nit ended with):\n\n| solver |", b->seconds);
    for (int i = 0; i < b->n_problem; i++)
        fprintf(f, " %s |", b->problem[i].name);
    fputs("\n|---|", f);
    for (int i = 0; i < b->n_problem; i++)
        fputs("---|", f);
    for (int k = 0; k < b->n_curve && b->curve[k].problem == b->curve[0].problem; k++) {
        fprintf(f, "\n| %s |", b->curve[k].solver);
        for (int i = 0; i < b->n_problem; i++)
            curve_cell(b, find_curve(b, b->curve[k].solver, i), f);
    }
    fputc('\n', f);
}

void cli_bench_tables(const cli_bench *b, FILE *f)
{
    fprintf(f, "%s\n\n", b->machine);
    if (b->n_seed)
        reach_table(b, f);
    if (b->n_curve)
        solver_table(b, f);
}

/* ---- files ------------------------------------------------------------------------------------------ */

static lw_status open_csv(const cli_bench *b, const char *line, const char *folder, const char *name, lw_output *o, lw_error *e)
{
    char path[CLI_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    lw_status st = lw_output_open(o, path, e);
    if (st == LW_OK)
        fprintf(o->f, "# %s\n# %s\n", line, b->machine);
    return st;
}

static lw_status save_curves(const cli_bench *b, const char *line, const char *folder, lw_error *e)
{
    lw_output o;
    lw_status st = open_csv(b, line, folder, "curves.csv", &o, e);
    if (st != LW_OK)
        return st;
    fprintf(o.f, "# best error so far, in squared units of the problem's file; one core, %g s a run\n"
            "problem,solver,seed,evals,seconds,objective\n", b->seconds);
    for (int i = 0; i < b->n_curve; i++) {
        const cli_bench_curve *c = &b->curve[i];
        for (size_t k = 0; k < c->n; k++)
            fprintf(o.f, "%s,%s,%llu,%ld,%.7f,%.17g\n", c->problem->name, c->solver,
                    (unsigned long long)c->seed, c->point[k].evals, c->point[k].seconds, c->point[k].error);
    }
    return lw_output_commit(&o, e);
}

static lw_status save_reach(const cli_bench *b, const char *line, const char *folder, lw_error *e)
{
    lw_output o;
    lw_status st = open_csv(b, line, folder, "reach.csv", &o, e);
    if (st != LW_OK)
        return st;
    fprintf(o.f, "# the default strategy, %d threads, until within 1 %% of the figure, %g s at most\n"
            "problem,figure,seed,evals,seconds,objective,reached\n", b->jobs, b->limit);
    for (int i = 0; i < b->n_problem; i++)
        for (int k = 0; k < b->reach_done[i]; k++) {
            const cli_bench_reach *r = &b->reach[i*b->n_seed + k];
            fprintf(o.f, "%s,%.9g,%llu,%ld,%.6f,%.9g,%d\n", b->problem[i].name,
                    b->problem[i].known->reachable, (unsigned long long)r->seed, r->evals, r->seconds,
                    r->error, r->reached);
        }
    return lw_output_commit(&o, e);
}

/* The errors that a plot shows. Worse ones are drawn on its upper edge, since the first guesses of a search would
 * otherwise fill the plot. */
void cli_bench_error_label(const cli_bench_problem *p, char *text, size_t size)
{
    const char *unit = p->target.units.length;
    snprintf(text, size, "error: sum of squared distances [%s^2]", *unit ? unit : "unit of the file");
}

typedef struct range { double top, decades; } range;

static range range_of(const cli_bench *b, const cli_bench_problem *p)
{
    const cli_bench_figures *k = p->known;
    double figure = compared_error(b, p), least = figure;
    for (int i = 0; i < b->n_curve; i++)
        if (b->curve[i].problem == p)
            least = fmin(least, cli_bench_error(&b->curve[i]));
    range r = { k->published[0].who ? 4*k->published[0].error : 100*figure, 1 };
    r.decades = log10(r.top/least);
    return r;
}

/* Keep the points of a curve that a plot can show apart, and the end of the run. */
static size_t thin(const cli_bench_curve *c, range r, double until, double *x, double *y)
{
    size_t n = 0;
    double least_step = pow(10, -r.decades/30), last = INFINITY;
    for (size_t i = 0; i < c->n; i++) {
        double error = fmin(c->point[i].error, r.top);
        if (error > least_step*last && i + 1 < c->n)
            continue;
        x[n] = c->point[i].seconds;
        y[n++] = last = error;
    }
    if (n && x[n - 1] < until) {
        x[n] = until;
        y[n] = y[n - 1];
        n++;
    }
    return n;
}

typedef struct labels { int n; lw_level level[LW_LEVEL_MAX]; char name[LW_LEVEL_MAX][96]; } labels;

/* Add a line for a published figure. Figures too close to the line above to have their own label share its label. */
static void add_level(labels *l, const char *who, double error, range r)
{
    int at = l->n;
    while (at > 0 && !l->name[at - 1][0])
        at--;
    bool shares = at > 0 && log10(l->level[at - 1].y/error) < 0.035*r.decades;
    l->level[l->n] = (lw_level){ l->name[l->n], error };
    l->name[l->n][0] = 0;
    char *name = l->name[shares ? at - 1 : l->n];
    size_t used = strlen(name);
    if (!strstr(name, who))
        snprintf(name + used, sizeof l->name[0] - used, "%s%s", shares ? ", " : "", who);
    l->n++;
}

static void add_levels(const cli_bench_figures *k, range r, labels *l)
{
    l->n = 0;
    for (int i = 0; i < CLI_PUBLISHED_MAX && k->published[i].who; i++)
        add_level(l, k->published[i].who, k->published[i].error, r);
    if (k->reachable > 0)
        add_level(l, "reachable", k->reachable, r);
}

#define LINES 8                     /* that a plot shows legibly */

static lw_status save_plot(const cli_bench *b, const cli_bench_problem *p, double *numbers, const char *folder, lw_error *e)
{
    char path[CLI_PATH_SIZE], title[224], bounds[96], label[64];
    int n_all = 0;
    lw_series series[LW_SERIES_MAX];
    labels l;
    range r = range_of(b, p);
    lw_plot plot = { .title = title, .x_label = "time on one core [s]", .y_label = label, .log_x = true, .log_y = true,
                     .series = series, .level = l.level };
    for (int i = 0; i < b->n_curve && plot.n_series < LW_SERIES_MAX; i++) {
        const cli_bench_curve *c = &b->curve[i];
        if (c->problem != p || c->n == 0)
            continue;
        n_all++;
        int better = 0;                                        /* curves that end with less error, or come first */
        for (int k = 0; k < b->n_curve; k++)
            better += b->curve[k].problem == p && b->curve[k].n > 0
                   && (cli_bench_error(&b->curve[k]) < cli_bench_error(c) || (k < i && cli_bench_error(&b->curve[k]) == cli_bench_error(c)));
        if (better >= LINES)
            continue;
        double *x = numbers, *y = numbers + c->n + 1;
        size_t n = thin(c, r, b->seconds, x, y);
        series[plot.n_series++] = (lw_series){ c->solver, n, x, y, LW_SERIES_STEPS };
        numbers = y + c->n + 1;
    }
    add_levels(p->known, r, &l);
    plot.n_level = l.n;
    bounds_text(p->known, bounds, sizeof bounds);
    int used = snprintf(title, sizeof title, "%s (bounds: %s)", p->name, bounds);
    if (n_all > LINES)
        snprintf(title + used, sizeof title - (size_t)used, ", the best %d of %d solvers", LINES, n_all);
    cli_bench_error_label(p, label, sizeof label);
    snprintf(path, sizeof path, "%s/%s.svg", folder, p->name);
    lw_status st = lw_draw_plot(&plot, path, e);
    return st == LW_NOTHING ? LW_OK : st;
}

static lw_status save_plots(const cli_bench *b, const char *folder, lw_error *e)
{
    size_t points = 1;
    lw_status st = LW_OK;
    for (int i = 0; i < b->n_curve; i++)
        points += 2*(b->curve[i].n + 1);
    double *numbers = malloc(sizeof *numbers*points);
    if (!numbers)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < b->n_problem && st == LW_OK && b->n_curve; i++)
        st = save_plot(b, &b->problem[i], numbers, folder, e);
    free(numbers);
    return st;
}

lw_status cli_bench_save(const cli_bench *b, const char *line, const char *folder, lw_error *e)
{
    lw_status st = save_curves(b, line, folder, e);
    if (st == LW_OK)
        st = save_reach(b, line, folder, e);
    return st == LW_OK ? save_plots(b, folder, e) : st;
}

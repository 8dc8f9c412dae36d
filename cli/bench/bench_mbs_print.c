/* cli/bench/bench_mbs_print.c - output of the multibody benchmark: Markdown tables, CSV, plots. */
#include "base/real.h"
#include "cli/bench/bench_mbs.h"

#include <stdlib.h>
#include <string.h>

#include "catalogues/pages/draw.h"

static bool any(const cli_mbs *b, const char *problem)
{
    for (int i = 0; i < b->n; i++)
        if (strcmp(b->row[i].problem, problem) == 0)
            return true;
    return false;
}

static bool begins(const cli_mbs *b, int i)
{
    return i == 0 || strcmp(b->row[i].problem, b->row[i - 1].problem) || strcmp(b->row[i].solver, b->row[i - 1].solver);
}

/* ---- Markdown ---------------------------------------------------------------------------------------------------- */

/* The least time of a solver at which the error is below `error`; INFINITY: it never is. */
static double soonest(const cli_mbs *b, const char *problem, const char *solver, double error)
{
    double least = INFINITY;
    for (int i = 0; i < b->n; i++) {
        const cli_mbs_row *r = &b->row[i];
        if (strcmp(r->problem, problem) == 0 && strcmp(r->solver, solver) == 0 && r->error <= error && !(r->off > 1e-2))
            least = fmin(least, r->seconds);
    }
    return least;
}

/* Print the milliseconds that each solver needs for an error. */
static void summary(const cli_mbs *b, const cli_mbs_problem *p, FILE *f)
{
    static const double error[] = { 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12 };
    fprintf(f, "%s; error: %s. Milliseconds for an error of\n\n| solver |", p->title, p->error);
    for (int k = 0; k < 6; k++)
        fprintf(f, " %g |", error[k]);
    fputs("\n|---|---|---|---|---|---|---|\n", f);
    for (int i = 0; i < b->n; i++) {
        if (!begins(b, i) || strcmp(b->row[i].problem, p->name))
            continue;
        fprintf(f, "| %s |", b->row[i].solver);
        for (int k = 0; k < 6; k++) {
            double s = soonest(b, p->name, b->row[i].solver, error[k]);
            if (isfinite(s))
                fprintf(f, " %.3g |", 1e3*s);
            else
                fputs(" - |", f);
        }
        fputc('\n', f);
    }
    fputc('\n', f);
}

static void number(FILE *f, double v, double times)
{
    if (isfinite(v))
        fprintf(f, " %.3g |", times*v);
    else
        fputs(" - |", f);
}

static bool known(const char *problem)
{
    const cli_mbs_problem *p = cli_mbs_problems;
    while (p->name && strcmp(p->name, problem))
        p++;
    return p->name != NULL;
}

static void rows(const cli_mbs *b, FILE *f)
{
    fputs("| problem | solver | tolerance | set up ms | run ms | error | off branch | energy | steps | evaluations | |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|\n", f);
    for (int i = 0; i < b->n; i++) {
        const cli_mbs_row *r = &b->row[i];
        if (!known(r->problem))              /* a model of the choice, of which mbs.csv holds the rows */
            continue;
        double power = log10(r->tolerance);
        fprintf(f, "| %s | %s |", r->problem, r->solver);
        if (fabs(power - round(power)) < 1e-6)
            fprintf(f, " %.0e |", r->tolerance);
        else
            number(f, r->tolerance, 1);
        number(f, r->make, 1e3);
        number(f, r->seconds, 1e3);
        number(f, r->error, 1);
        number(f, r->off, 1);
        number(f, r->energy, 1);
        fprintf(f, " %ld | %ld | %s |\n", r->steps, r->rates, r->note);
    }
}

void cli_mbs_tables(const cli_mbs *b, FILE *f)
{
    fprintf(f, "%s\n\n", b->machine);
    for (const cli_mbs_problem *p = cli_mbs_problems; p->name; p++)
        if (p->error[0] && any(b, p->name))
            summary(b, p, f);
    rows(b, f);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void csv_number(FILE *f, double v)
{
    fputc(',', f);
    if (isfinite(v))
        fprintf(f, "%.9g", v);
}

static lw_status save_csv(const cli_mbs *b, const char *folder, lw_error *e)
{
    char path[CLI_PATH_SIZE];
    lw_output o;
    snprintf(path, sizeof path, "%s/mbs.csv", folder);
    lw_status st = lw_output_open(&o, path, e);
    if (st != LW_OK)
        return st;
    fprintf(o.f, "# %s\n# %s\nproblem,solver,tolerance,setup,seconds,error,off,energy,steps,evaluations,note\n", b->call->line, b->machine);
    for (int i = 0; i < b->n; i++) {
        const cli_mbs_row *r = &b->row[i];
        fprintf(o.f, strchr(r->problem, ',') ? "\"%s\",%s" : "%s,%s", r->problem, r->solver);
        csv_number(o.f, r->tolerance);
        csv_number(o.f, r->make);
        csv_number(o.f, r->seconds);
        csv_number(o.f, r->error);
        csv_number(o.f, r->off);
        csv_number(o.f, r->energy);
        fprintf(o.f, ",%ld,%ld,\"", r->steps, r->rates);
        for (const char *c = r->note; *c; c++)
            fputc(*c == '"' ? '\'' : *c, o.f);
        fputs("\"\n", o.f);
    }
    return lw_output_commit(&o, e);
}

#define LINES 8                     /* that a plot shows legibly */

/* The least product of error and time among the points of a line. */
static double merit(const lw_series *s)
{
    double least = INFINITY;
    for (size_t i = 0; i < s->n; i++)
        if (s->x[i] > 0 && s->y[i] >= 0)
            least = fmin(least, s->x[i]*fmax(s->y[i], 1e-16));
    return least;
}

/* Keep the best lines, in their order.  Returns how many there are. */
static int keep_best(lw_series *series, int n)
{
    double of[LW_SERIES_MAX];
    int kept = 0;
    for (int i = 0; i < n; i++)
        of[i] = merit(&series[i]);
    for (int i = 0; i < n; i++) {
        int better = 0;
        for (int k = 0; k < n; k++)
            better += of[k] < of[i] || (of[k] == of[i] && k < i);
        if (better < LINES)
            series[kept++] = series[i];
    }
    return kept;
}

/* Save the plot of error over seconds, with a line for each of the best solvers. */
static lw_status save_plot(const cli_mbs *b, const cli_mbs_problem *p, double *numbers, const char *folder, lw_error *e)
{
    char path[CLI_PATH_SIZE], label[128], title[160];
    lw_series series[LW_SERIES_MAX];
    lw_plot plot = { .title = title, .x_label = "processor time [s]", .y_label = label, .log_x = true, .log_y = true,
                     .series = series };
    snprintf(label, sizeof label, "greatest error: %s", p->error);
    for (int i = 0; i < b->n; i++) {
        const cli_mbs_row *r = &b->row[i];
        if (strcmp(r->problem, p->name))
            continue;
        if (begins(b, i)) {
            if (plot.n_series == LW_SERIES_MAX)
                break;
            series[plot.n_series++] = (lw_series){ r->solver, 0, numbers + i, numbers + b->n + i, LW_SERIES_LINE };
        }
        numbers[i] = r->seconds;
        numbers[b->n + i] = r->error;
        series[plot.n_series - 1].n++;
    }
    int all = plot.n_series;
    plot.n_series = keep_best(series, all);
    snprintf(title, sizeof title, all > LINES ? "%s, the best %d of %d solvers" : "%s", p->title, LINES, all);
    snprintf(path, sizeof path, "%s/mbs-%s.svg", folder, p->name);
    lw_status st = lw_draw_plot(&plot, path, e);
    return st == LW_NOTHING ? LW_OK : st;
}

lw_status cli_mbs_save(const cli_mbs *b, const char *folder, lw_error *e)
{
    double *numbers = malloc(sizeof *numbers*(2*(size_t)b->n + 1));
    if (!numbers)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status st = save_csv(b, folder, e);
    for (const cli_mbs_problem *p = cli_mbs_problems; p->name && st == LW_OK; p++)
        if (p->error[0] && any(b, p->name))
            st = save_plot(b, p, numbers, folder, e);
    free(numbers);
    return st;
}

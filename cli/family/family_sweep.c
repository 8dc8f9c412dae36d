/* linkwright family sweep, optimise - figures over parameters: grids, even designs, sensitivities, the best variant. */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/parallel.h"
#include "base/real.h"
#include "base/suggest.h"
#include "catalogues/pages/draw.h"
#include "cli/family/family_measure.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/solvers/method_internal.h"

#define VARY_MAX 12
#define POINT_MAX 1000000

typedef struct vary { int parameter, n; double from, to; const char *name, *unit; } vary;

typedef struct sweep {
    const cli_call *call;
    lw_master  *m;
    lw_variant *v;                       /* the base */
    int         n_vary, n_measure;
    vary        vary[VARY_MAX];
    cli_measure measure[CLI_MEASURE_MAX];
    size_t      n;                       /* points */
    double     *point;                   /* (n * n_vary) in the units of the parameters */
    double     *value;                   /* (n * n_measure); NaN: it failed */
    char      (*why)[160];               /* (n) */
    bool       *done;
    lw_variant **worker;                 /* one for each thread */
    int         n_worker;
    atomic_bool  no_memory;            /* a variant failed for lack of memory */
} sweep;

/* ---- what is varied ---------------------------------------------------------------------------------- */

/* "reach", "reach=2:3", "reach=2:3:11" in the unit of the parameter. */
static lw_status read_vary(const lw_master *m, char *item, bool ranges, vary *y, lw_error *e)
{
    char *equals = strchr(item, '='), *end;
    if (equals)
        *equals = '\0';
    while (*item && item[strlen(item) - 1] == ' ')
        item[strlen(item) - 1] = '\0';
    *y = (vary){ .parameter = lw_master_find_parameter(m, item) };
    if (y->parameter < 0) {
        const char *names[64];
        int n = 0;
        while (n < 64 && lw_master_parameter(m, n)) {
            names[n] = lw_master_parameter(m, n)->name;
            n++;
        }
        const char *near = lw_suggest(item, names, n);
        return lw_error_set(e, LW_E_ARG, "--vary: there is no parameter \"%.60s\"%s%s%s", item, LW_DID_YOU_MEAN(near));
    }
    const lw_parameter *p = lw_master_parameter(m, y->parameter);
    y->name = p->name;
    y->unit = *p->unit ? p->unit : "1";
    if (p->kind != LW_AMOUNT_NUMBER)
        return lw_error_set(e, LW_E_ARG, "--vary: %s is no number; make a configuration for each of its values", p->name);
    y->from = p->least;
    y->to = p->most;
    if (!equals && !p->has_range)
        return lw_error_set(e, LW_E_ARG, "--vary: %s has no range in the master; write %s=FROM:TO", p->name, p->name);
    if (!equals)
        return LW_OK;
    y->from = strtod(equals + 1, &end);
    bool good = end > equals + 1 && *end == ':';
    const char *second = end + 1;
    y->to = good ? strtod(second, &end) : 0;
    good = good && end > second && isfinite(y->from) && isfinite(y->to) && y->from < y->to;
    if (good && *end == ':') {
        second = end + 1;
        long n = strtol(second, &end, 10);
        y->n = (int)n;
        good = end > second && n >= 2 && n <= POINT_MAX;
    }
    if (!good || *end || (ranges && y->n))
        return lw_error_set(e, LW_E_ARG, "--vary %s=%.60s: expected %s%s in the unit of %s [%s]", y->name, equals + 1,
                            "FROM:TO",
                            ranges ? "" : " or FROM:TO:N, N at least 2,", y->name, y->unit);
    return LW_OK;
}

static lw_status read_variation(sweep *s, const char *list, bool ranges, lw_error *e)
{
    char item[256];
    lw_status st = list ? LW_OK : lw_error_set(e, LW_E_ARG, "--vary is missing: the parameters to vary, as in \"reach=2:3:11\"");
    for (const char *at = list; st == LW_OK && cli_family_next(&at, item, sizeof item);) {
        if (s->n_vary == VARY_MAX)
            return lw_error_set(e, LW_E_ARG, "at most %d parameters can be varied", VARY_MAX);
        st = read_vary(s->m, item, ranges, &s->vary[s->n_vary++], e);
        for (int i = 0; st == LW_OK && i < s->n_vary - 1; i++)
            if (s->vary[i].parameter == s->vary[s->n_vary - 1].parameter)
                st = lw_error_set(e, LW_E_ARG, "--vary names %s twice", s->vary[i].name);
    }
    return st;
}

/* ---- points and their figures ------------------------------------------------------------------------------ */

static lw_status make_room(sweep *s, size_t n, lw_error *e)
{
    s->n = n;
    s->point = calloc(n*(size_t)s->n_vary + 1, sizeof *s->point);
    s->value = calloc(n*(size_t)s->n_measure + 1, sizeof *s->value);
    s->why = calloc(n + 1, sizeof *s->why);
    s->done = calloc(n + 1, sizeof *s->done);
    return s->point && s->value && s->why && s->done ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* Choose the variant that the options choose, for one more thread. */
static lw_status make_workers(sweep *s, lw_error *e)
{
    int n = s->call->common.jobs > 0 ? s->call->common.jobs : lw_core_count();
    s->worker = calloc((size_t)n, sizeof *s->worker);
    lw_status st = s->worker ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (s->n_worker = 0; st == LW_OK && s->n_worker < n; s->n_worker++)
        st = cli_family_variant(s->call, s->m, &s->worker[s->n_worker], e);
    return st;
}

static void work(void *context, size_t job, int thread)
{
    sweep *s = context;
    lw_variant *v = s->worker[thread];
    lw_error e = { 0 };
    cli_measure own[CLI_MEASURE_MAX];
    if (cli_interrupted())
        return;
    memcpy(own, s->measure, sizeof own);
    for (int i = 0; i < s->n_vary; i++)
        lw_variant_set_number(v, s->vary[i].parameter, s->point[job*(size_t)s->n_vary + (size_t)i]);
    lw_status st = cli_measures_run(s->call, v, s->n_measure, own, s->value + job*(size_t)s->n_measure, &e);
    for (int i = 0; st != LW_OK && i < s->n_measure; i++)
        s->value[job*(size_t)s->n_measure + (size_t)i] = NAN;
    if (st != LW_OK)
        snprintf(s->why[job], sizeof s->why[job], "%.159s", e.text);
    s->done[job] = st != LW_STOPPED || !cli_interrupted();
    if (st == LW_E_MEMORY)                      /* not the fault of this variant */
        s->no_memory = true;
}

/* Whole numbers stay whole. */
static double place_of(const sweep *s, int i, double share)
{
    const vary *y = &s->vary[i];
    double x = share <= 0 ? y->from : share >= 1 ? y->to : y->from + (y->to - y->from)*share;
    return lw_master_parameter(s->m, y->parameter)->whole ? round(x) : x;
}

static lw_status make_grid(sweep *s, lw_error *e)
{
    double n = 1;
    for (int i = 0; i < s->n_vary; i++) {
        vary *y = &s->vary[i];
        bool whole = lw_master_parameter(s->m, y->parameter)->whole;
        if (y->n == 0)
            y->n = whole && y->to - y->from < 50 ? (int)(floor(y->to) - ceil(y->from)) + 1 : s->n_vary == 1 ? 21 : 7;
        n *= y->n;
    }
    if (n > POINT_MAX)
        return lw_error_set(e, LW_E_ARG, "this grid has %.0f points, at most %d are computed; --samples N takes N "
                                         "points that fill the ranges evenly", n, POINT_MAX);
    lw_status st = make_room(s, (size_t)n, e);
    for (size_t k = 0; st == LW_OK && k < s->n; k++) {
        size_t rest = k;                                    /* the first parameter changes fastest */
        for (int i = 0; i < s->n_vary; i++) {
            size_t at = rest%(size_t)s->vary[i].n;
            rest /= (size_t)s->vary[i].n;
            s->point[k*(size_t)s->n_vary + (size_t)i] = place_of(s, i, (double)at/(s->vary[i].n - 1));
        }
    }
    return st;
}

static lw_status make_samples(sweep *s, int n, lw_error *e)
{
    lw_rng rng;
    lw_status st = make_room(s, (size_t)n, e);
    lw_rng_seed(&rng, s->call->common.seed, 0);
    if (st == LW_OK && !lw_low_discrepancy(&rng, s->n, s->n_vary, s->point))
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t k = 0; st == LW_OK && k < s->n*(size_t)s->n_vary; k++)
        s->point[k] = place_of(s, (int)(k%(size_t)s->n_vary), s->point[k]);
    return st;
}

static lw_status compute(sweep *s, lw_error *e)
{
    lw_status st = make_workers(s, e);
    if (st == LW_OK)
        st = lw_parallel(s->n_worker, s->n, work, s);
    return s->no_memory ? lw_error_set(e, LW_E_MEMORY, "out of memory") : st;
}

/* The first sample that fails says whether all do; a wrong figure is an error of the command. */
static lw_status try_base(sweep *s, double *value, lw_error *e)
{
    return cli_measures_run(s->call, s->v, s->n_measure, s->measure, value, e);
}

/* ---- tables --------------------------------------------------------------------------------------------------- */

static void put_cell(FILE *f, double x)
{
    char text[LW_NUMBER_SIZE];
    lw_number_print(x, text);
    fputs(isfinite(x) ? text : "", f);
}

static void write_csv(const sweep *s, FILE *f)
{
    bool failed = false;
    for (size_t k = 0; k < s->n; k++)
        failed = failed || s->why[k][0];
    fputs("# units: ", f);
    for (int i = 0; i < s->n_vary; i++)
        fprintf(f, "%s%s", i ? "," : "", s->vary[i].unit);
    for (int i = 0; i < s->n_measure; i++)
        fprintf(f, ",%s", s->measure[i].unit);
    fputc('\n', f);
    for (int i = 0; i < s->n_vary; i++)
        fputs(i ? "," : "", f), cli_csv_text(f, s->vary[i].name);
    for (int i = 0; i < s->n_measure; i++) {
        fputc(',', f);
        cli_csv_text(f, s->measure[i].text);
    }
    fputs(failed ? ",failure\n" : "\n", f);
    for (size_t k = 0; k < s->n; k++) {
        if (!s->done[k])
            continue;
        for (int i = 0; i < s->n_vary; i++) {
            fputs(i ? "," : "", f);
            put_cell(f, s->point[k*(size_t)s->n_vary + (size_t)i]);
        }
        for (int i = 0; i < s->n_measure; i++) {
            fputc(',', f);
            put_cell(f, s->value[k*(size_t)s->n_measure + (size_t)i]);
        }
        if (failed) {
            fputc(',', f);
            cli_csv_text(f, s->why[k]);
        }
        fputc('\n', f);
    }
}

static void write_json(const sweep *s, cli_json j)
{
    cli_json_array(&j, "columns");
    for (int i = 0; i < s->n_vary; i++)
        cli_json_text(&j, NULL, s->vary[i].name);
    for (int i = 0; i < s->n_measure; i++)
        cli_json_text(&j, NULL, s->measure[i].text);
    cli_json_end(&j);
    cli_json_array(&j, "units");
    for (int i = 0; i < s->n_vary; i++)
        cli_json_text(&j, NULL, s->vary[i].unit);
    for (int i = 0; i < s->n_measure; i++)
        cli_json_text(&j, NULL, s->measure[i].unit);
    cli_json_end(&j);
    cli_json_array(&j, "rows");
    double row[VARY_MAX + CLI_MEASURE_MAX];
    for (size_t k = 0; k < s->n; k++) {
        if (!s->done[k])
            continue;
        memcpy(row, s->point + k*(size_t)s->n_vary, (size_t)s->n_vary*sizeof *row);
        memcpy(row + s->n_vary, s->value + k*(size_t)s->n_measure, (size_t)s->n_measure*sizeof *row);
        cli_json_reals(&j, NULL, row, (size_t)(s->n_vary + s->n_measure));
    }
    cli_json_end(&j);
    cli_json_array(&j, "failures");
    for (size_t k = 0, r = 0; k < s->n; k++) {
        if (!s->done[k])
            continue;
        r++;
        if (!s->why[k][0])
            continue;
        cli_json_object(&j, NULL);
        cli_json_int(&j, "row", (long long)r);
        cli_json_text(&j, "why", s->why[k]);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_end(&j);
}

/* Figures over the first parameter, or over their value in the base; a line for each value of the others. */
static lw_status draw(const sweep *s, const double *base, bool normalised, const char *path, lw_error *e)
{
    enum { LINES = 8 };
    lw_plot plot[LW_PANEL_MAX] = { 0 };
    lw_series series[LW_PANEL_MAX][LINES];
    char label[LW_PANEL_MAX][96], name[LW_PANEL_MAX][LINES][128], x_label[128];
    size_t width = (size_t)s->vary[0].n, lines = s->n/width;
    int panels = 0;
    if ((size_t)s->n_measure*lines > LW_PANEL_MAX*LINES)
        return lw_error_set(e, LW_E_ARG, "a plot shows at most %d lines in a panel and %d panels; vary fewer "
                                         "parameters or measure fewer figures", LINES, LW_PANEL_MAX);
    double *xy = malloc((size_t)(s->n_measure + 1)*s->n*sizeof *xy);
    if (!xy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t k = 0; k < s->n; k++)
        xy[k] = s->point[k*(size_t)s->n_vary];
    snprintf(x_label, sizeof x_label, "%s [%s]", s->vary[0].name, s->vary[0].unit);
    for (int i = 0; i < s->n_measure; i++)
        for (size_t b = 0; b < lines; b++) {
            double *y = xy + (size_t)(i + 1)*s->n + b*width;
            const char *unit = normalised ? "relative to the base" : s->measure[i].unit;
            int p = 0;
            while (p < panels && (strcmp(label[p], unit) != 0 || plot[p].n_series == LINES))
                p++;
            if (p == LW_PANEL_MAX) {
                free(xy);
                return lw_error_set(e, LW_E_ARG, "these figures need more than %d panels", LW_PANEL_MAX);
            }
            if (p == panels) {
                snprintf(label[panels], sizeof label[0], "%s", unit);
                plot[panels++] = (lw_plot){ .x_label = x_label, .series = series[p] };
            }
            for (size_t k = 0; k < width; k++) {
                double v = s->value[(b*width + k)*(size_t)s->n_measure + (size_t)i];
                y[k] = !s->done[b*width + k] ? NAN : normalised ? v/base[i] : v;
            }
            int line = plot[p].n_series++;
            size_t used = (size_t)snprintf(name[p][line], sizeof name[p][line], "%.60s", s->measure[i].text);
            for (int k = 1; k < s->n_vary && lines > 1 && used < 100; k++)
                used += (size_t)snprintf(name[p][line] + used, sizeof name[p][line] - used, ", %.30s %.4g %s",
                                         s->vary[k].name, s->point[b*width*(size_t)s->n_vary + (size_t)k],
                                         strcmp(s->vary[k].unit, "1") != 0 ? s->vary[k].unit : "");
            series[p][line] = (lw_series){ .name = name[p][line], .n = width, .x = xy + b*width, .y = y };
        }
    for (int p = 0; p < panels; p++) {
        char unit[96];
        snprintf(unit, sizeof unit, normalised ? "%s" : "[%s]", label[p]);
        strcpy(label[p], unit);
        plot[p].y_label = label[p];
    }
    plot[0].title = lw_master_title(s->m);
    plot[0].height = panels == 1 ? 560 : 320*panels;
    lw_status st = lw_draw_plots(panels, plot, path, e);
    free(xy);
    return st;
}

/* ---- sensitivities ------------------------------------------------------------------------------------------ */

/* Central differences about the base, with steps of 1/1000 of the ranges: (p/r) dr/dp. */
static lw_status make_differences(sweep *s, double *base_point, lw_error *e)
{
    lw_status st = make_room(s, 2*(size_t)s->n_vary, e);
    for (int i = 0; st == LW_OK && i < s->n_vary; i++) {
        lw_amount a, unit;
        st = lw_variant_value(s->v, s->vary[i].parameter, &a, e);
        if (st == LW_OK && (lw_unit_parse(s->vary[i].unit, strlen(s->vary[i].unit), &unit, e) != LW_OK
                            || !lw_amount_in(&a, &unit, &base_point[i])))
            st = e->status;
    }
    for (int i = 0; st == LW_OK && i < s->n_vary; i++)
        for (int side = 0; side < 2; side++) {
            double *p = s->point + (size_t)(2*i + side)*(size_t)s->n_vary;
            memcpy(p, base_point, (size_t)s->n_vary*sizeof *p);
            double step = 1e-3*(s->vary[i].to - s->vary[i].from);
            p[i] += side ? step : -step;
            if (p[i] > s->vary[i].to || p[i] < s->vary[i].from)      /* at the end of the range: one-sided */
                p[i] = base_point[i];
        }
    return st;
}

static void write_sensitivities(const sweep *s, FILE *f, cli_json j, const double *base_point, const double *base)
{
    bool json = s->call->common.json;
    if (json) {
        cli_json_array(&j, "figures");
        for (int i = 0; i < s->n_measure; i++) {
            cli_json_object(&j, NULL);
            cli_json_text(&j, "figure", s->measure[i].text);
            cli_json_text(&j, "unit", s->measure[i].unit);
            cli_json_real(&j, "base", base[i]);
            cli_json_end(&j);
        }
        cli_json_end(&j);
        cli_json_array(&j, "sensitivities");
    } else {
        fputs("# percent of change of a figure for one percent of change of a parameter\nparameter,base,unit", f);
        for (int i = 0; i < s->n_measure; i++) {
            fputc(',', f);
            cli_csv_text(f, s->measure[i].text);
        }
        fputc('\n', f);
    }
    for (int i = 0; i < s->n_vary; i++) {
        const double *low = s->value + (size_t)(2*i)*(size_t)s->n_measure, *high = low + s->n_measure;
        double step = s->point[(size_t)(2*i + 1)*(size_t)s->n_vary + (size_t)i] - s->point[(size_t)(2*i)*(size_t)s->n_vary + (size_t)i];
        double values[CLI_MEASURE_MAX];
        for (int k = 0; k < s->n_measure; k++)
            values[k] = (high[k] - low[k])/step*base_point[i]/base[k];
        if (json) {
            cli_json_object(&j, NULL);
            cli_json_text(&j, "parameter", s->vary[i].name);
            cli_json_text(&j, "unit", s->vary[i].unit);
            cli_json_real(&j, "base", base_point[i]);
            cli_json_reals(&j, "normalised", values, (size_t)s->n_measure);
            cli_json_end(&j);
            continue;
        }
        cli_csv_text(f, s->vary[i].name);
        fprintf(f, ",%.10g,%s", base_point[i], s->vary[i].unit);
        for (int k = 0; k < s->n_measure; k++)
            fprintf(f, isfinite(values[k]) ? ",%.6g" : ",", values[k]);
        fputc('\n', f);
    }
    if (json) {
        cli_json_end(&j);
        cli_json_end(&j);
    }
}

/* ---- sweep -------------------------------------------------------------------------------------------------- */

static lw_status open_sweep(const cli_call *call, sweep *s, bool ranges, lw_error *e)
{
    const cli_family_settings *o = call->settings;
    s->call = call;
    lw_status st = o->from < o->to ? LW_OK : lw_error_set(e, LW_E_ARG, "--from must be less than --to");
    if (st == LW_OK)
        st = cli_family_open(call, &s->m, &s->v, e);
    return st == LW_OK ? read_variation(s, o->vary, ranges, e) : st;
}

static void free_sweep(sweep *s)
{
    for (int i = 0; i < s->n_worker; i++)
        lw_variant_free(s->worker[i]);
    free(s->worker);
    free(s->point);
    free(s->value);
    free(s->why);
    free(s->done);
    lw_variant_free(s->v);
    lw_master_free(s->m);
    free(s);
}

int cli_family_sweep(const cli_call *call)
{
    const cli_family_settings *o = call->settings;
    sweep *s = calloc(1, sizeof *s);
    lw_error e = { 0 };
    lw_output out;
    double base[CLI_MEASURE_MAX] = { 0 }, base_point[VARY_MAX] = { 0 };
    int code = CLI_DONE;
    lw_status st = s ? open_sweep(call, s, o->sensitivity || o->samples > 0, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && o->samples > 0 && o->plot)
        st = lw_error_set(&e, LW_E_ARG, "--plot draws grids; leave out --samples");
    if (st == LW_OK && o->sensitivity && o->plot)
        st = lw_error_set(&e, LW_E_ARG, "--plot draws grids; leave out --sensitivity");
    if (st == LW_OK)
        st = o->measure ? cli_measures_read(o->measure, &s->n_measure, s->measure, &e)
           : cli_measures_default(call, s->v, &s->n_measure, s->measure, &e);
    if (st == LW_OK)
        st = try_base(s, base, &e);
    if (st == LW_OK)
        st = o->sensitivity ? make_differences(s, base_point, &e) : o->samples > 0 ? make_samples(s, o->samples, &e)
            : make_grid(s, &e);
    bool opened = st == LW_OK && (st = cli_open(call, &out, &e)) == LW_OK;        /* before the long work */
    cli_json j = { 0 };
    if (opened && call->common.json) {           /* a first line, so that an output that takes none ends the work */
        j = cli_json_begin(out.f, 2);
        cli_json_head(&j, call->line);
    } else if (opened)
        fprintf(out.f, "# %s\n", call->line);
    if (opened && (st = compute(s, &e)) != LW_OK)
        lw_output_abandon(&out);
    else if (opened) {
        if (o->sensitivity)
            write_sensitivities(s, out.f, j, base_point, base);
        else if (call->common.json)
            write_json(s, j);
        else
            write_csv(s, out.f);
        code = cli_close(call, &out, CLI_DONE);
        char partial[LW_PATH_SIZE + 16];
        const char *to = o->plot ? cli_picture_path(call, o->plot, code, partial) : NULL;
        if (to)
            st = draw(s, base, o->normalised, to, &e);
    }
    if (st != LW_OK)
        code = st == LW_E_ARG ? cli_usage(call, "%s", e.text) : cli_fail(call, &e);
    if (s)
        free_sweep(s);
    return code;
}

/* ---- optimise ----------------------------------------------------------------------------------------------- */

typedef struct limit { int measure; double sign, bound; } limit;          /* sign*(bound - value) >= 0 */

typedef struct optimum {
    sweep *s;
    double sign, scale, first;           /* of the objective, measure 0 */
    int    n_limit;
    limit  limit[CLI_MEASURE_MAX];
    double at[VARY_MAX], value[CLI_MEASURE_MAX];
    bool   fresh, good;
    double best_at[VARY_MAX], best[CLI_MEASURE_MAX], best_breach;     /* the best so far; breach of the conditions, 0: none */
    bool   any;
    long   runs, failed;
    char   why[200];
} optimum;

/* By how much the condition is kept, over its bound. */
static double margin(const limit *k, const double *value)
{
    return k->sign*(k->bound - value[k->measure])/fmax(fabs(k->bound), 1e-30);
}

static void keep_best(optimum *p)
{
    double breach = 0;
    for (int i = 0; i < p->n_limit; i++)
        breach = fmax(breach, -margin(&p->limit[i], p->value));
    if (p->any && (breach > p->best_breach || (breach == p->best_breach && p->sign*p->value[0] >= p->sign*p->best[0])))
        return;
    p->any = true;
    p->best_breach = breach;
    memcpy(p->best_at, p->at, sizeof p->at);
    memcpy(p->best, p->value, sizeof p->value);
}

/* Figures at x, shares of the ranges. */
static bool figures_at(optimum *p, const double *x)
{
    sweep *s = p->s;
    lw_error e = { 0 };
    size_t bytes = (size_t)s->n_vary*sizeof *x;
    if (p->fresh && memcmp(p->at, x, bytes) == 0)
        return p->good;
    memcpy(p->at, x, bytes);
    for (int i = 0; i < s->n_vary; i++)
        lw_variant_set_number(s->v, s->vary[i].parameter, place_of(s, i, x[i]));
    p->fresh = true;
    lw_status st = cli_measures_run(s->call, s->v, s->n_measure, s->measure, p->value, &e);
    p->good = st == LW_OK;
    s->no_memory = s->no_memory || st == LW_E_MEMORY;
    p->runs++;
    p->failed += !p->good;
    if (p->good)
        keep_best(p);
    else
        snprintf(p->why, sizeof p->why, "%.199s", e.text);
    return p->good;
}

/* The methods want an objective above 0: 1 + z for z >= 0, else 1/(1 - z), which rises with z. */
static double objective(void *context, const double *x, double *grad)
{
    optimum *p = context;
    (void)grad;
    if (!figures_at(p, x))
        return INFINITY;
    double z = p->sign*(p->value[0] - p->first)/p->scale;
    return z >= 0 ? 1 + z : 1/(1 - z);
}

static void conditions(void *context, const double *x, double *g, double *j)
{
    optimum *p = context;
    (void)j;
    bool good = figures_at(p, x);
    for (int i = 0; i < p->n_limit; i++) {
        const limit *k = &p->limit[i];
        g[i] = good ? margin(k, p->value) : -1;
    }
}

/* "peak(A.drive)<=120": the figure joins those measured. */
static lw_status read_limits(optimum *p, const char *list, lw_error *e)
{
    sweep *s = p->s;
    char item[256];
    for (const char *at = list; at && cli_family_next(&at, item, sizeof item);) {
        char *sign = strpbrk(item, "<>"), *end;
        bool least = sign && *sign == '>';
        if (s->n_measure == CLI_MEASURE_MAX)
            return lw_error_set(e, LW_E_ARG, "at most %d figures can be measured", CLI_MEASURE_MAX);
        double bound = sign ? strtod(sign + 1 + (sign[1] == '='), &end) : 0;
        if (!sign || end == sign + 1 + (sign[1] == '=') || *end || !isfinite(bound))
            return lw_error_set(e, LW_E_ARG, "--require is \"%.80s\"; expected FIGURE<=NUMBER or FIGURE>=NUMBER", item);
        *sign = '\0';
        cli_measure one[1];
        int n;
        lw_status st = cli_measures_read(item, &n, one, e);
        if (st != LW_OK)
            return st;
        p->limit[p->n_limit++] = (limit){ s->n_measure, least ? -1 : 1, bound };
        s->measure[s->n_measure++] = *one;
    }
    return LW_OK;
}

static void write_optimum(const optimum *p, FILE *f, const double *x, const lw_solver_result *r, const double *first)
{
    const sweep *s = p->s;
    bool json = s->call->common.json;
    cli_json j = cli_json_begin(f, 2);
    if (json) {
        cli_json_head(&j, s->call->line);
        cli_json_array(&j, "parameters");
    }
    for (int i = 0; i < s->n_vary; i++) {
        double v = place_of(s, i, x[i]);
        const char *at = x[i] <= 1e-9 || x[i] >= 1 - 1e-9 ? "at the end of its range" : "";
        if (json) {
            cli_json_object(&j, NULL);
            cli_json_text(&j, "name", s->vary[i].name);
            cli_json_real(&j, "value", v);
            cli_json_text(&j, "unit", s->vary[i].unit);
            cli_json_bool(&j, "at_end_of_range", *at != 0);
            cli_json_end(&j);
        } else
            fprintf(f, "%-32s %.10g %s%s%s\n", s->vary[i].name, v, s->vary[i].unit, *at ? "   " : "", at);
    }
    if (json) {
        cli_json_end(&j);
        cli_json_array(&j, "figures");
    }
    for (int i = 0; i < s->n_measure; i++) {
        if (json) {
            cli_json_object(&j, NULL);
            cli_json_text(&j, "figure", s->measure[i].text);
            cli_json_text(&j, "unit", s->measure[i].unit);
            cli_json_real(&j, "value", p->value[i]);
            cli_json_real(&j, "before", first[i]);
            cli_json_end(&j);
        } else
            fprintf(f, "%-32s %.10g %s   (before %.10g)\n", s->measure[i].text, p->value[i], s->measure[i].unit, first[i]);
    }
    if (json) {
        cli_json_end(&j);
        cli_json_int(&j, "runs", p->runs);
        cli_json_int(&j, "failed_runs", p->failed);
        cli_json_text(&j, "stop", cli_stop_text(r->stop));
        cli_json_end(&j);
    } else
        fprintf(f, "# %ld model%s, %ld of them failed; %s\n", p->runs, lw_plural(p->runs), p->failed, cli_stop_text(r->stop));
}

static lw_status optimise(optimum *p, const cli_family_settings *o, lw_error *e, lw_output *out, int *code)
{
    sweep *s = p->s;
    double x[VARY_MAX], lo[VARY_MAX], hi[VARY_MAX], first[CLI_MEASURE_MAX] = { 0 };
    lw_status st = try_base(s, first, e);
    for (int i = 0; st == LW_OK && i < s->n_vary; i++) {
        lw_amount a, unit;
        double v = s->vary[i].from;
        st = lw_variant_value(s->v, s->vary[i].parameter, &a, e);
        if (st == LW_OK && lw_unit_parse(s->vary[i].unit, strlen(s->vary[i].unit), &unit, e) == LW_OK)
            lw_amount_in(&a, &unit, &v);
        lo[i] = 0;
        hi[i] = 1;
        x[i] = fmin(fmax((v - s->vary[i].from)/(s->vary[i].to - s->vary[i].from), 0.02), 0.98);
    }
    if (st != LW_OK)
        return st;
    const lw_solver *method = lw_solver_find(o->solver);
    if (!method || method->takes_gradient || !method->minimise)
        return lw_error_set(e, LW_E_ARG, "--solver %.40s: expected cobyla, neldermead, sbplx, bobyqa, isres, crs, "
                                         "direct or esch", o->solver);
    lw_function fn = { .n = (size_t)s->n_vary, .m = (size_t)p->n_limit, .lo = lo, .hi = hi, .context = p, .value
                       = objective,
                       .conditions = conditions };
    lw_solver_options so = lw_solver_options_default();
    lw_solver_result r;
    so.seed = s->call->common.seed;
    so.max_evals = o->max_evals;
    so.f_tol = so.x_tol = 1e-8;
    so.step = 0.1;
    so.interrupt = cli_stop_flag();
    p->first = first[0];
    p->scale = fabs(first[0]) > 0 ? fabs(first[0]) : 1;
    st = lw_method_run(method, &fn, &so, x, &r);
    if (s->no_memory)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (cli_interrupted() && p->any && p->best_breach == 0) {          /* no run can be made any more */
        memcpy(x, p->best_at, sizeof x);
        memcpy(p->value, p->best, sizeof p->value);
        memcpy(p->at, x, sizeof x);
        p->fresh = p->good = true;
    } else if (cli_interrupted())
        return lw_error_set(e, LW_STOPPED, "stopped before a variant was found that keeps all conditions");
    else if (st == LW_NOTHING)
        return lw_error_set(e, LW_NOTHING, "no variant that was tried keeps all conditions%s%s", p->why[0] ?
                            "; the last failure: " : "",
                            p->why);
    else if (st != LW_OK && st != LW_STOPPED)
        return lw_error_set(e, st, "the method failed: %s", cli_stop_text(r.stop));
    else
        p->fresh = false;
    if (!figures_at(p, x))
        return lw_error_set(e, LW_E_NUMERIC, "%s", p->why);
    write_optimum(p, out->f, x, &r, first);
    *code = cli_close(s->call, out, CLI_DONE);
    return LW_OK;
}

int cli_family_optimise(const cli_call *call)
{
    const cli_family_settings *o = call->settings;
    optimum *p = calloc(1, sizeof *p);
    sweep *s = calloc(1, sizeof *s);
    lw_error e = { 0 };
    lw_output out;
    int code = CLI_DONE;
    lw_status st = p && s ? open_sweep(call, s, true, &e) : lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && !o->minimise == !o->maximise)
        st = lw_error_set(&e, LW_E_ARG, "one figure to --minimise or to --maximise is needed");
    if (st == LW_OK)
        st = cli_measures_read(o->minimise ? o->minimise : o->maximise, &s->n_measure, s->measure, &e);
    if (st == LW_OK && s->n_measure != 1)
        st = lw_error_set(&e, LW_E_ARG, "only one figure can be minimised; the others are conditions of --require");
    if (st == LW_OK) {
        p->s = s;
        p->sign = o->minimise ? 1 : -1;
        st = read_limits(p, o->require, &e);
    }
    if (st == LW_OK && (st = cli_open(call, &out, &e)) == LW_OK && (st = optimise(p, o, &e, &out, &code)) != LW_OK)
        lw_output_abandon(&out);
    if (st != LW_OK)
        code = st == LW_E_ARG ? cli_usage(call, "%s", e.text) : cli_fail(call, &e);
    free(p);
    if (s)
        free_sweep(s);
    return code;
}

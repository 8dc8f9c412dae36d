/* Accuracy of models in space: every example that moves by its forces or is elastic, in every formulation, over tolerances from
 * 1e-4 to 1e-11.  Printed is the greatest error of a coordinate (places over the size of the model, quaternions) at ten times,
 * against radau or index1 at a tolerance of 1e-13 (elastic ones: 1e-12); then for each formulation the worst residual of the rows and
 * the error of the energy over its scale at 1e-11, or at the last tolerance that it finished.
 *
 *     bench_space [SECONDS]        limit of processor time of one run; 5
 *     bench_space energy [TO]      energy, momentum and rows over TO seconds (100) at 1e-10, by `auto` and index1
 *
 * Lines are those of the tables in docs/benchmarks.md. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/file.h"
#include "base/real.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"

enum { MOMENTS = 10, MOST_Q = 1024 };

static const char free_body[] = "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 2, \"centre\": [1, 2, 3], \"inertia\": "
    "[1, 2, 3], \"angular_velocity\": [1, 0, 1], \"velocity\": [1, 2, -1]}], \"joints\": [{\"name\": \"F\", \"kind\": \"free\", \"links\": "
    "[\"ground\", \"a\"], \"at\": [0, 0, 0]}]}";

static const struct { const char *file; double to; bool conservative, elastic; } models[] = {
    { "free body", 10, true, false }, { "top", 1, true, false }, { "slider-crank", 1, true, false }, { "bricard", 1, true, false },
    { "sarrus", 0.25, true, false }, { "governor", 0.2, false, false }, { "delta-elastic", 0.01, false, true },
    { "superelement", 0.02, false, true },
};

static lw_status read_it(const char *name, lw_spatial *m, lw_error *e)
{
    char path[128], *text = NULL;
    size_t size;
    if (!strcmp(name, "free body"))
        return lw_spatial_read(free_body, sizeof free_body - 1, name, m, e);
    snprintf(path, sizeof path, "examples/space/%s.json", name);
    lw_status s = lw_file_read(path, &text, &size, e);
    if (s == LW_OK)
        s = lw_spatial_read(text, size, path, m, e);
    free(text);
    return s;
}

typedef struct places { int n, n_q; double q[MOMENTS + 1][MOST_Q]; } places;
static places exact, got;

static lw_status keep(void *context, const lw_moment *m)
{
    places *p = context;
    if (p->n <= MOMENTS)
        memcpy(p->q[p->n++], m->q, (size_t)p->n_q*sizeof *m->q);
    return LW_OK;
}

static lw_status run(const lw_spatial *m, lw_formulation f, double to, double tolerance, double limit, places *p, lw_dynamics_report *r)
{
    lw_error e = { 0 };
    lw_dynamics *d;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.formulation = f;
    o.to = to;
    o.intervals = MOMENTS;
    o.relative = o.absolute = tolerance;
    o.until = lw_clock_wall() + 3*limit;
    *r = (lw_dynamics_report){ 0 };
    lw_status s = lw_dynamics_make_spatial(m, &o, &d, &e);
    if (s != LW_OK)
        return s;
    p->n = 0;
    p->n_q = lw_dynamics_space(d)->n_q;
    s = p->n_q <= MOST_Q ? lw_dynamics_run(d, keep, p, r, &e) : LW_E_ARG;
    lw_dynamics_free(d);
    return s;
}

static double difference(void)
{
    double most = 0;
    for (int i = 0; i <= MOMENTS; i++)
        for (int b = 0; b < got.n_q; b += 7) {               /* quaternions p and -p are the same turn */
            const double *p = got.q[i] + b, *x = exact.q[i] + b;
            double sign = p[3]*x[3] + p[4]*x[4] + p[5]*x[5] + p[6]*x[6] < 0 ? -1 : 1;
            for (int k = 0; k < 7; k++)
                most = fmax(most, fabs(k < 3 ? p[k] - x[k] : sign*p[k] - x[k]));
        }
    return most;
}

static void accuracy(int i, double limit)
{
    lw_spatial m;
    lw_error e = { 0 };
    lw_dynamics_report r;
    if (read_it(models[i].file, &m, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        return;
    }
    bool implicit = models[i].elastic || !strcmp(models[i].file, "governor");
    lw_status s = run(&m, implicit ? LW_FORMULATION_RADAU : LW_FORMULATION_INDEX1, models[i].to, models[i].elastic ? 1e-12 : 1e-13, 100*limit,
                      &exact, &r);
    if (s != LW_OK)
        printf("| %s | no reference |\n", models[i].file);
    static const lw_formulation every[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1, LW_FORMULATION_RADAU, LW_FORMULATION_ALPHA,
                                            LW_FORMULATION_CVODE, LW_FORMULATION_GGL };
    for (int f = 0; s == LW_OK && f < (int)(sizeof every/sizeof *every); f++) {
        lw_dynamics_report last = { 0 };
        bool goes_on = true;
        char line[256];
        int at = snprintf(line, sizeof line, "| %s, %g s | %s |", models[i].file, models[i].to, lw_formulation_name(every[f]));
        for (int k = 4; k <= 11; k++) {
            double start = lw_clock_cpu();
            bool done = goes_on && run(&m, every[f], models[i].to, pow(10, -k), limit, &got, &r) == LW_OK;
            goes_on = done && lw_clock_cpu() - start < limit;
            at += done ? snprintf(line + at, sizeof line - (size_t)at, " %.0e |", difference())
                       : snprintf(line + at, sizeof line - (size_t)at, " - |");
            last = done ? r : last;
        }
        if (last.samples)
            printf("%s %.0e | %.0e |\n", line, last.worst_off, last.energy_scale > 0 ? last.energy_error/last.energy_scale : 0);
        fflush(stdout);
    }
    lw_spatial_free(&m);
}

static void energy(int i, double to)
{
    lw_spatial m;
    lw_error e = { 0 };
    lw_dynamics_report r;
    if (!models[i].conservative || read_it(models[i].file, &m, &e) != LW_OK)
        return;
    for (int f = 0; f < 2; f++) {
        double start = lw_clock_cpu();
        lw_status s = run(&m, f ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, to, 1e-10, 1e3, &got, &r);
        printf("| %s | %s | %.0e | %.0e | %.0e | %ld | %.2f |%s\n", models[i].file, lw_formulation_name(r.formulation),
               r.energy_error/r.energy_scale, r.energy_held/r.energy_scale, r.worst_off, r.steps, lw_clock_cpu() - start,
               s == LW_OK ? "" : " failed");
        fflush(stdout);
    }
    lw_spatial_free(&m);
}

int main(int n, char **word)
{
    bool long_run = n > 1 && !strcmp(word[1], "energy");
    for (int i = 0; i < (int)(sizeof models/sizeof *models); i++) {
        if (long_run)
            energy(i, n > 2 ? atof(word[2]) : 100);
        else
            accuracy(i, n > 1 ? atof(word[1]) : 5);
    }
    return 0;
}

/* What a run of forward dynamics costs in each formulation, against the reduced form in the same run.
 *
 * CSV: model, formulation, tolerance, microseconds a run, evaluations, microseconds an evaluation, times the reduced
 * form, energy error over its scale.  Each time is the least of RUNS, made ready and run.
 *
 * bench_dynamics energy: conservative examples over 1000 s at 1e-10 by the automatic choice; greatest error of the
 * energy and sum of its corrections, over its scale. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/file.h"
#include "mbs/dynamics/dynamics.h"

#define RUNS 15

static const struct { const char *file; double to; lw_formulation f; double tolerance; } each[] = {
    { "examples/andrews.json", 0.03, LW_FORMULATION_REDUCED, 1e-11 },
    { "examples/andrews.json", 0.03, LW_FORMULATION_INDEX1, 1e-10 },
    { "examples/andrews.json", 0.03, LW_FORMULATION_CVODE, 1e-8 },
    { "examples/andrews.json", 0.03, LW_FORMULATION_GGL, 1e-7 },
    { "examples/andrews.json", 0.03, LW_FORMULATION_GGL, 1e-10 },
    { "examples/two-four-bars.json", 10, LW_FORMULATION_REDUCED, 1e-8 },
    { "examples/two-four-bars.json", 10, LW_FORMULATION_REDUCED, 1e-10 },
    { "examples/two-four-bars.json", 10, LW_FORMULATION_INDEX1, 1e-8 },
    { "examples/two-four-bars.json", 10, LW_FORMULATION_INDEX1, 1e-10 },
    { "examples/pendulum.json", 10, LW_FORMULATION_REDUCED, 1e-13 },
    { "examples/pendulum.json", 10, LW_FORMULATION_INDEX1, 1e-13 },
    { "examples/pendulum.json", 10, LW_FORMULATION_CVODE, 1e-9 },
    { "examples/pendulum.json", 10, LW_FORMULATION_GGL, 1e-9 },
};

static void fail(const char *what, const lw_error *e)
{
    fprintf(stderr, "bench_dynamics: %s: %s\n", what, e->text);
    exit(1);
}

static void read_model(const char *file, lw_model *m)
{
    char *text = NULL;
    size_t size;
    lw_error e = { 0 };
    if (lw_file_read(file, &text, &size, &e) != LW_OK || lw_model_read(text, size, file, m, &e) != LW_OK)
        fail(file, &e);
    free(text);
}

static void energy(void)
{
    static const char *const files[] = {
        "examples/pendulum.json", "examples/two-four-bars.json", "examples/dynamics/falling-ladder.json",
        "examples/dynamics/governor.json", "examples/dynamics/rolling-wheel.json", "examples/dynamics/trebuchet.json" };
    printf("model,formulation,steps,energy error,corrections\n");
    for (size_t i = 0; i < sizeof files/sizeof *files; i++) {
        lw_model m;
        lw_dynamics_report r = { 0 };
        lw_dynamics_options o = lw_dynamics_options_default();
        lw_dynamics *d;
        lw_error e = { 0 };
        read_model(files[i], &m);
        o.to = 1000;
        if (lw_dynamics_make(&m, &o, &d, &e) != LW_OK || lw_dynamics_run(d, NULL, NULL, &r, &e) != LW_OK)
            fail(files[i], &e);
        printf("%s,%s,%ld,%.1e,%.1e\n", files[i], lw_formulation_name(r.formulation), r.steps,
               r.energy_error/r.energy_scale, r.energy_held/r.energy_scale);
        lw_dynamics_free(d);
        lw_model_free(&m);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "energy") == 0)
        return energy(), 0;
    double reduced = 0;
    printf("model,formulation,tolerance,us,evaluations,us an evaluation,times reduced,energy error\n");
    for (size_t i = 0; i < sizeof each/sizeof *each; i++) {
        lw_model m;
        lw_dynamics_report r = { 0 };
        double best = INFINITY;
        if (argc > 1 && !strstr(each[i].file, argv[1]))
            continue;
        read_model(each[i].file, &m);
        for (int k = 0; k < RUNS && (k < 3 || best < 0.1); k++) {
            lw_dynamics_options o = lw_dynamics_options_default();
            lw_dynamics *d;
            lw_error e = { 0 };
            o.formulation = each[i].f;
            o.relative = o.absolute = each[i].tolerance;
            o.to = each[i].to;
            o.intervals = 1;
            double start = lw_clock_cpu();
            if (lw_dynamics_make(&m, &o, &d, &e) != LW_OK || lw_dynamics_run(d, NULL, NULL, &r, &e) != LW_OK)
                fail(each[i].file, &e);
            lw_dynamics_free(d);
            best = fmin(best, lw_clock_cpu() - start);
        }
        reduced = each[i].f == LW_FORMULATION_REDUCED ? best : reduced;
        printf("%s,%s,%.0e,%.1f,%ld,%.2f,%.2f,%.2g\n", each[i].file, lw_formulation_name(each[i].f), each[i].tolerance,
               1e6*best, r.rates, 1e6*best/fmax(1, (double)r.rates), best/reduced, r.energy_error/r.energy_scale);
        lw_model_free(&m);
    }
    return 0;
}

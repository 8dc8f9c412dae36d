/* Energy of every conservative example over a long time: the greatest error over the run, and what was put back after
 * steps, in parts of the energy scale.
 *
 *     bench_energy [SECONDS [FILE.json ...]]        1000 s, and the models below
 *
 * By the formulation that `auto` takes, and by each of the others that can do the model, for 20 s of processor time at most.  Lines are
 * those of the table in docs/benchmarks.md. */
#include <stdio.h>
#include <stdlib.h>
#include "base/clock.h"
#include "base/file.h"
#include "mbs/formulations/formulations.h"

static const char *const models[] = {
    "examples/pendulum.json", "examples/two-four-bars.json",
    "examples/dynamics/trebuchet.json", "examples/dynamics/rolling-wheel.json",
    "examples/dynamics/governor.json", "examples/dynamics/falling-ladder.json", "examples/dynamics/newtons-cradle.json",
};

enum { LIMIT = 20 };                     /* [s] of processor time */

static lw_status look_at_clock(void *context, const lw_moment *m)
{
    (void)m;
    return lw_clock_cpu() > *(const double *)context ? LW_STOPPED : LW_OK;
}

/* Print the row of one run; returns the formulation taken. */
static lw_formulation run(const char *file, double seconds, lw_formulation f)
{
    char *text = NULL;
    size_t size;
    lw_model m;
    lw_error e = { 0 };
    lw_dynamics *d = NULL;
    lw_dynamics_report r = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    o.to = seconds;
    o.intervals = 1000;
    o.formulation = f;
    if (lw_file_read(file, &text, &size, &e) != LW_OK || lw_model_read(text, size, file, &m, &e) != LW_OK) {
        fprintf(stderr, "%s: %s\n", file, e.text);
        free(text);
        return f;
    }
    double start = lw_clock_cpu(), end = start + LIMIT;
    lw_status s = lw_dynamics_make(&m, &o, &d, &e);
    if (s == LW_OK) {
        s = lw_dynamics_run(d, look_at_clock, &end, &r, &e);
        printf("| %s | %s | %.0e | %.0e | %ld | %.2g", file, lw_formulation_name(r.formulation), r.energy_error/r.energy_scale,
               r.energy_held/r.energy_scale, r.steps, lw_clock_cpu() - start);
        if (s != LW_OK)
            printf(", to %.0f s: %s", r.t, s == LW_STOPPED ? "time" : e.text);
        printf(" |\n");
        fflush(stdout);
    }
    lw_dynamics_free(d);
    lw_model_free(&m);
    free(text);
    return r.formulation;
}

int main(int n, char **word)
{
    static const lw_formulation others[] = { LW_FORMULATION_QUADRATURE, LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_RADAU,
                                             LW_FORMULATION_CVODE, LW_FORMULATION_GGL, LW_FORMULATION_ALPHA };
    double seconds = n > 1 ? atof(word[1]) : 1000;
    int count = n > 2 ? n - 2 : (int)(sizeof models/sizeof *models);
    printf("| model | formulation | error | put back | steps | s |\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < count; i++) {
        const char *file = n > 2 ? word[2 + i] : models[i];
        lw_formulation taken = run(file, seconds, LW_FORMULATION_AUTO);
        for (size_t f = 0; f < sizeof others/sizeof *others; f++)
            if (others[f] != taken)
                run(file, seconds, others[f]);
    }
    return 0;
}

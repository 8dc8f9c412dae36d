/* Energy of every conservative example over a long time: the greatest error over the run, and what was put back after
 * steps, in parts of the energy scale.
 *
 *     bench_energy [SECONDS [FILE.json ...]]        1000 s, and the models below
 *
 * Each by the formulation that `auto` takes, and by index1.  Lines are those of the table in docs/benchmarks.md. */
#include <stdio.h>
#include <stdlib.h>
#include "base/clock.h"
#include "base/file.h"
#include "mbs/dynamics/dynamics.h"

static const char *const models[] = {
    "examples/pendulum.json", "examples/two-four-bars.json",
    "examples/dynamics/trebuchet.json", "examples/dynamics/rolling-wheel.json",
    "examples/dynamics/governor.json", "examples/dynamics/falling-ladder.json", "examples/dynamics/newtons-cradle.json",
};

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
    o.max_step = 20000000;
    if (lw_file_read(file, &text, &size, &e) != LW_OK || lw_model_read(text, size, file, &m, &e) != LW_OK) {
        fprintf(stderr, "%s: %s\n", file, e.text);
        free(text);
        return LW_FORMULATION_INDEX1;
    }
    double start = lw_clock_wall();
    lw_status s = lw_dynamics_make(&m, &o, &d, &e);
    bool has = s == LW_OK;
    if (has)
        s = lw_dynamics_run(d, NULL, NULL, &r, &e);
    if (has || f == LW_FORMULATION_AUTO)
        printf("%-40s %-10s %9.1e %9.1e %9ld %8.2f %s\n", file, has ? lw_formulation_name(r.formulation) : "-",
               r.energy_scale > 0 ? r.energy_error/r.energy_scale : 0, r.energy_scale > 0 ? r.energy_held/r.energy_scale : 0,
               r.steps, lw_clock_wall() - start, s == LW_OK ? "" : e.text);
    fflush(stdout);
    lw_dynamics_free(d);
    lw_model_free(&m);
    free(text);
    return has ? r.formulation : LW_FORMULATION_INDEX1;
}

int main(int n, char **word)
{
    double seconds = n > 1 ? atof(word[1]) : 1000;
    int count = n > 2 ? n - 2 : (int)(sizeof models/sizeof *models);
    printf("%-40s %-10s %9s %9s %9s %8s\n", "model", "method", "error", "put back", "steps", "seconds");
    for (int i = 0; i < count; i++) {
        const char *file = n > 2 ? word[2 + i] : models[i];
        if (run(file, seconds, LW_FORMULATION_AUTO) != LW_FORMULATION_INDEX1)
            run(file, seconds, LW_FORMULATION_INDEX1);
    }
    return 0;
}

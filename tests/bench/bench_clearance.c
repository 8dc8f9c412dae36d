/* bench_clearance.c - Makkonen 1999, paper C: processor time of 1.25 s of motion, best of three; error of the regular
 * motion at 80 r/min, the pin seated at the start, against a run at 1e-13. */
#include <stdio.h>
#include <stdlib.h>
#include "base/clock.h"
#include "base/file.h"
#include "mbs/clearance/clearance.h"
#include "mbs/elastic/contact.h"

static const double rpm = 2.0*LW_PI/60.0;

typedef struct last { lw_vec2 pin; double force; } last;

static lw_status keep(void *context, const lw_clearance_sample *s)
{
    last *l = context;
    l->pin = s->point[0].pin;
    l->force = s->point[0].force;
    return LW_OK;
}

static double run(const lw_clearance_scene *scene, lw_clearance_options o, int times, last *l, lw_clearance_result *r)
{
    double best = HUGE_VAL;
    if (l) {
        o.every = o.time;
        o.sink = keep;
        o.context = l;
    }
    for (int i = 0; i < times; i++) {
        double start = lw_clock_cpu();
        if (lw_clearance_run(scene, &o, r, NULL) != LW_OK)
            return NAN;
        best = fmin(best, lw_clock_cpu() - start);
    }
    return best;
}

static void one_model(const lw_clearance_scene *scene, const char *name, double stiffness)
{
    lw_clearance_result r;
    last exact = { { 0, 0 }, 0 };
    lw_clearance_options o = lw_clearance_options_default();
    o.tolerance = 1e-13, o.speed = 80*rpm, o.start = LW_CLEARANCE_SEATED;
    run(scene, o, 1, &exact, &r);
    for (double tolerance = 1e-7; tolerance > 5e-13; tolerance *= 0.1) {
        last l;
        lw_clearance_options fast = lw_clearance_options_default();
        fast.speed = 250*rpm, o.tolerance = fast.tolerance = tolerance;
        run(scene, o, 1, &l, &r);
        double seconds = run(scene, fast, 3, NULL, &r);
        printf("%-7s %8.0e %9.0e %9.2f %8ld %8ld %11.2e %11.2e\n", name, stiffness, tolerance, 1e3*seconds,
               r.steps, r.events,
               lw_v2_norm(lw_v2_sub(l.pin, exact.pin)), fabs(l.force - exact.force));
    }
}

int main(void)
{
    char *text = NULL;
    size_t size;
    lw_error e = { 0 };
    lw_model *m = calloc(1, sizeof *m);
    if (!m || lw_file_read("examples/clearance-four-bar.json", &text, &size, &e) != LW_OK
        || lw_model_read(text, size, "examples/clearance-four-bar.json", m, &e) != LW_OK) {
        printf("%s\n", e.text);
        return 1;
    }
    puts("model        K     tolerance   250 rpm[ms]  steps   events   error[m] (80 rpm)  [N]");
    static const lw_clearance_model model[] = { LW_CLEARANCE_IMPACT, LW_CLEARANCE_MLSD, LW_CLEARANCE_LINK };
    for (int i = 0; i < 3; i++)
        for (double k = 1e6; k < 5e8; k *= 100) {
            lw_clearance_scene *scene;
            m->clearance[2].model = model[i];
            m->clearance[2].stiffness = k;
            if (lw_clearance_make(m, &scene, &e) == LW_OK) {
                one_model(scene, lw_clearance_name(model[i]), k);
                lw_clearance_free(scene);
            }
        }
    lw_model_free(m);
    free(m);
    free(text);
    return 0;
}

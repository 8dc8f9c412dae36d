/* tests/bench/bench_large.c - models of any size: time to make one ready, of one evaluation of the accelerations, and of one
 * step of the implicit method, each per body.  The rope has a damper in every pin; the row is n four-bars side by side. */
#include <stdio.h>

#include "base/clock.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/formulations/formulations.h"
#include "tests/large_models.h"

static double per_evaluation(const lw_model *m, double *set_up)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    lw_error e = { 0 };
    double best = INFINITY, power, from = lw_clock_cpu();
    o.formulation = LW_FORMULATION_INDEX1;
    if (lw_dynamics_make(m, &o, &d, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        return NAN;
    }
    *set_up = lw_clock_cpu() - from;
    int n_q = d->n_q, repeat = 1 + 3000000/n_q;
    double *q = calloc(2*(size_t)n_q, sizeof *q), *v = q + n_q;
    for (int i = 0; i < n_q; i++) {          /* links at different angles; the rows need not be satisfied */
        v[i] = d->start_v[i];
        q[i] = d->start_q[i] + (i%3 == 2 ? 0.3*sin(i) : 0);
    }
    for (int trial = 0; trial < 7; trial++) {
        from = lw_clock_cpu();
        for (int k = 0; k < repeat; k++)
            lw_mbs_accelerate(d, 0, q, v, d->a, d->l, &power);
        best = fmin(best, (lw_clock_cpu() - from)/repeat);
    }
    free(q);
    lw_dynamics_free(d);
    return best;
}

static lw_status ignore(void *context, const lw_moment *m)
{
    (void)context, (void)m;
    return LW_OK;
}

static double per_implicit_step(const lw_model *m)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics_report r = { 0 };
    lw_dynamics *d;
    lw_error e = { 0 };
    o.formulation = LW_FORMULATION_GGL;
    o.relative = o.absolute = 1e-6;
    o.max_step = 60;
    o.to = 1;
    if (lw_dynamics_make(m, &o, &d, &e) != LW_OK)
        return NAN;
    double from = lw_clock_cpu();
    lw_dynamics_run(d, ignore, NULL, &r, &e);
    double took = lw_clock_cpu() - from;
    lw_dynamics_free(d);
    return took/(double)r.steps;
}

static void row(const char *name, int n, lw_model *m)
{
    double set_up = NAN, one = per_evaluation(m, &set_up), step = per_implicit_step(m);
    int bodies = m->linkage.n_link - 1;
    printf("| %s | %d | %d | %.3g | %.3g | %.3g | %.3g |\n", name, n, bodies, 1e3*set_up, 1e6*set_up/bodies, 1e6*one/bodies,
           1e6*step/bodies);
    fflush(stdout);
    lw_model_free(m);
}

int main(void)
{
    static const int rope[] = { 4, 10, 31, 32, 100, 1000, 10000 }, loops[] = { 2, 10, 40, 100, 400, 1000 };
    lw_model m;
    printf("| model | n | bodies | made ready [ms] | per body [us] | evaluation, per body [us] | implicit step, per body [us] |\n"
           "|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof rope/sizeof *rope; i++) {
        read_chain(rope[i], 1e-4, &m);
        row("rope with dampers", rope[i], &m);
    }
    for (size_t i = 0; i < sizeof loops/sizeof *loops; i++) {
        read_row(loops[i], &m);
        row("row of four-bars", loops[i], &m);
    }
    return 0;
}

/* Radau IIA with eight stages: its tables, solutions in closed form, stiff equations. */
#include "mbs/ode/collocation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/batch/kernels_internal.h"
#include "mbs/ode/collocation_table_internal.h"
#include "tests/check.h"

/* The stages integrate powers up to 7 exactly, the end of the step up to 14; the other matrices belong to these. */
TEST(tables)
{
    for (int p = 0; p < 15; p++) {
        double sum = 0;
        for (int j = 0; j < 8; j++)
            sum += stage_column[j][7]*pow(node[j], p);
        CHECK_NEAR(sum, 1.0/(p + 1), 1e-15, 0);
        for (int k = 0; k < 8 && p < 8; k++) {
            double stage = 0;
            for (int j = 0; j < 8; j++)
                stage += stage_column[j][k]*pow(node[j], p);
            CHECK_NEAR(stage, pow(node[k], p + 1)/(p + 1), 1e-15, 0);
        }
        double beyond = 0, product = 1;      /* Newton's polynomial, continued as far again */
        for (int m = 0; m < 8; product *= 2 - node[7 - m], m++)
            for (int j = 0; j < 8; j++)
                beyond += difference_column[j][m]*pow(node[j], p)*product;
        if (p < 8)
            CHECK_NEAR(beyond, pow(2, p), 1e-10, 0);
    }
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            double slope = 0, vectors = 0, apply = 0, scaled = 0;
            for (int k = 0; k < 8; k++) {
                slope += slope_column[k][i]*stage_column[j][k];
                vectors += vector_column[k][i]*inverse_column[j][k];
                apply += stage_column[k][i]*vector_column[j][k];
            }
            double a = eigenvalue[j/2][0], b = eigenvalue[j/2][1], re = vector_column[j/2*2][i], im = vector_column[j/2*2 + 1][i];
            scaled = j%2 ? b*re + a*im : a*re - b*im;
            CHECK_NEAR(slope, i == j, 1e-12, 0);
            CHECK_NEAR(vectors, i == j, 1e-12, 0);
            CHECK_NEAR(apply, scaled, 1e-15, 0);
        }
}

/* x'' = -w^2 (x - cos t) - c (x' + sin t) - cos t with the solution cos t + a fast part; the integral of x x'. */
typedef struct problem { double stiffness, damping; int n_project; } problem;

static lw_status rates(void *context, const double t[LW_STAGES], bool again, const double *y, double *dy)
{
    const problem *p = context;
    (void)again;
    for (int k = 0; k < 8; k++) {
        double x = y[k], u = y[8 + k];
        dy[8 + k] = -p->stiffness*(x - cos(t[k])) - p->damping*(u + sin(t[k])) - cos(t[k]);
        dy[16 + k] = x*u;
    }
    return LW_OK;
}

static lw_status project(void *context, double t, double *y)
{
    (void)t, (void)y;
    ((problem *)context)->n_project++;
    return LW_OK;
}

static lw_collocation w;
static lw_error e;
static const char *isa;

static double seen[2];                       /* a mark of the solution to the last bit */

/* Run to t = 3 from x(0) = 1 + off; returns the greatest error of x, also within the steps, where the fast part has decayed. */
static double run(problem *p, bool implicit, double tolerance, double off)
{
    lw_stages_ode ode = { 3, 1, 1, implicit, p, rates, NULL, project, isa };
    lw_ode_options o = lw_ode_options_default();
    double *work = malloc(lw_collocation_work(3, true)*sizeof *work), y[3] = { 1 + off, 0, 0 }, worst = 0;
    seen[0] = seen[1] = 0;
    o.relative = o.absolute = tolerance;
    lw_collocation_start(&w, &ode, &o, work, 0, y);
    for (lw_ode_stop stop = LW_ODE_STEP; stop != LW_ODE_END;) {
        lw_status s = lw_collocation_step(&w, 3, &stop, &e);
        CHECK_INT(s, LW_OK);
        if (s != LW_OK)
            break;
        for (int i = 0; i <= 8; i++) {
            double t = w.t_old + (w.t - w.t_old)*i/8;
            lw_collocation_dense(&w, t, y);
            seen[0] = y[0] + 1.25*seen[1], seen[1] = y[2] - 0.75*seen[0];
            worst = t < 0.5 && off != 0 ? worst : fmax(worst, fabs(y[0] - cos(t)));
            CHECK_NEAR(y[2], 0.5*(y[0]*y[0] - (1 + off)*(1 + off)), 100*tolerance + 1e-14, 0);
        }
    }
    CHECK_NEAR(w.t, 3, 0, 0);
    CHECK_INT(p->n_project, w.n_step);
    free(work);
    return worst;
}

/* Errors follow the tolerance down to rounding, and steps grow shorter slowly. */
TEST(an_oscillator)
{
    for (int k = 2; k <= 14; k++) {
        problem p = { .stiffness = 4 };
        double tolerance = pow(10, -k), error = run(&p, false, tolerance, 0);
        CHECK(error < 20*tolerance);
        CHECK(w.n_step < 60 && w.n_rate < 8*400);
    }
}

/* Where an explicit method needs some 10^5 steps, the implicit one takes a few. */
TEST(a_stiff_damper)
{
    for (int k = 2; k <= 12; k += 2) {
        problem p = { .stiffness = 1e8, .damping = 1e6 };
        double tolerance = pow(10, -k), error = run(&p, true, tolerance, 1e-3);
        CHECK(error < 20*tolerance);
        CHECK(w.n_step < 120);
    }
}

/* Every instruction set gives the same bits as the one that all processors have. */
TEST(instruction_sets_agree)
{
    for (int implicit = 0; implicit < 2; implicit++) {
        problem p = { .stiffness = implicit ? 1e8 : 4, .damping = implicit ? 1e6 : 0 };
        isa = NULL;
        run(&p, implicit, 1e-8, 1e-3);
        double same[2] = { seen[0], seen[1] };
        long rate = w.n_rate;
        for (int rank = 0; lw_kernels_supported(rank); rank++) {
            isa = lw_kernels_supported(rank)->isa;
            p.n_project = 0;
            run(&p, implicit, 1e-8, 1e-3);
            CHECK(memcmp(seen, same, sizeof same) == 0);
            CHECK_INT(w.n_rate, rate);
        }
        isa = NULL;
    }
}

/* A direction x = cos a, sin a that turns by a' = u, drawn to a = t + 0.5 sin t. */
static double turned(double t) { return t + 0.5*sin(t); }

static lw_status turning(void *context, const double t[LW_STAGES], bool again, const double *y, double *dy)
{
    (void)context, (void)again;
    for (int k = 0; k < 8; k++)
        dy[16 + k] = 4*(y[k]*sin(turned(t[k])) - y[8 + k]*cos(turned(t[k]))) - 0.5*sin(t[k]);
    return LW_OK;
}

static void turns(void *context, const double *y, double *dx)
{
    (void)context;
    for (int k = 0; k < 8; k++)
        dx[k] = -y[16 + k]*y[8 + k], dx[8 + k] = y[16 + k]*y[k];
}

/* Coordinates whose rates depend on the coordinates: steps are as long, and errors as small, at any tolerance. */
TEST(coordinates_that_turn)
{
    for (int k = 1; k <= 14; k++) {
        problem p = { 0 };
        lw_stages_ode ode = { 3, 2, 1, false, &p, turning, turns, project, NULL };
        lw_ode_options o = lw_ode_options_default();
        double *work = malloc(lw_collocation_work(3, false)*sizeof *work), y[3] = { 1, 0, 1.5 };
        o.relative = o.absolute = pow(10, -k);
        lw_collocation_start(&w, &ode, &o, work, 0, y);
        for (lw_ode_stop stop = LW_ODE_STEP; stop != LW_ODE_END;) {
            lw_status s = lw_collocation_step(&w, 10, &stop, &e);
            CHECK_INT(s, LW_OK);
            if (s != LW_OK)
                break;
            CHECK_NEAR(w.y[0], cos(turned(w.t)), 20*o.absolute, 0);
            CHECK_NEAR(w.y[1], sin(turned(w.t)), 20*o.absolute, 0);
        }
        CHECK(w.n_step < 60);
        free(work);
    }
}

static lw_status undefined(void *context, const double t[LW_STAGES], bool again, const double *y, double *dy)
{
    lw_status s = rates(context, t, again, y, dy);
    return s == LW_OK && t[7] > 1 ? LW_OPEN : s;
}

/* x = atan(400 (t - 1)), to 1e-10: towards the sharp turn errors rise from step to step.  Steps follow this trend, so that few are refused. */
static lw_status turn_sharply(void *context, const double t[LW_STAGES], bool again, const double *y, double *dy)
{
    (void)context, (void)again, (void)y;
    for (int k = 0; k < 8; k++) {
        double s = 400*(t[k] - 1), size = 1 + s*s;
        dy[8 + k] = -2*400*400*s/(size*size);
    }
    return LW_OK;
}

TEST(few_steps_are_refused)
{
    problem p = { 0 };
    lw_stages_ode ode = { 2, 1, 1, false, &p, turn_sharply, NULL, project, NULL };
    lw_ode_options o = lw_ode_options_default();
    double work[100], y[2] = { atan(-400), 400/(1 + 400.0*400) };
    lw_ode_stop stop = LW_ODE_STEP;
    CHECK(lw_collocation_work(2, false) <= 100);
    o.relative = o.absolute = 1e-10;
    lw_collocation_start(&w, &ode, &o, work, 0, y);
    while (stop != LW_ODE_END)
        CHECK_INT(lw_collocation_step(&w, 2, &stop, &e), LW_OK);
    CHECK_NEAR(w.y[0], atan(400), 1e-9, 0);
    CHECK(w.n_refused < w.n_step/6);
}

/* Limits, and rates that end, are said. */
TEST(ends)
{
    problem p = { .stiffness = 4 };
    lw_stages_ode ode = { 3, 1, 1, false, &p, undefined, NULL, project, NULL };
    lw_ode_options o = lw_ode_options_default();
    double *work = malloc(lw_collocation_work(3, false)*sizeof *work), y[3] = { 1, 0, 0 };
    lw_ode_stop stop;
    lw_status s = LW_OK;
    lw_collocation_start(&w, &ode, &o, work, 0, y);
    while (s == LW_OK)
        s = lw_collocation_step(&w, 3, &stop, &e);
    CHECK_INT(s, LW_E_NUMERIC);
    CHECK(w.t <= 1 && w.t > 0.99);
    o.max_step = 3;
    lw_collocation_start(&w, &ode, &o, work, 0, y);
    for (s = LW_OK; s == LW_OK;)
        s = lw_collocation_step(&w, 3, &stop, &e);
    CHECK_INT(s, LW_STOPPED);
    CHECK(w.n_step + w.n_refused == 3);
    free(work);
}

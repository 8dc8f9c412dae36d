/* Hard scenes of dynamics against closed solutions: heavy on light, links without mass, long runs, dead points. */
#include "tests/dynamics_run.h"

static drun d;

static const lw_formulation all[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                      LW_FORMULATION_GGL };

/* g/length sets the pace; y: angle from +x, its rate */
static lw_status pendulum_rate(void *context, double t, const double *y, double *dy)
{
    (void)t;
    dy[0] = y[1];
    dy[1] = -*(const double *)context*cos(y[0]);
    return LW_OK;
}

static double pendulum_angle(double pace, double angle, double rate, double to)
{
    lw_ode ode = { .n = 2, .context = &pace, .rate = pendulum_rate };
    double y[2] = { angle, rate };
    drun_exact(&ode, 0, y, to);
    return y[0];
}

/* ---- masses -------------------------------------------------------------------------------------- */

/* 1 kg half way to 1e8 kg: the string is taut, the light mass hardly vibrates (at 7e4 rad/s), and the heavy one is a
 * pendulum of 2 m to within 1e-8. */
TEST(heavy_last)
{
    double angle = pendulum_angle(9.81/2, 0, 0, 0.5);
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'one', 'mass': 1, 'centre': [1, 0]},"
        "{'name': 'two', 'mass': 1e8, 'centre': [2, 0]}], 'joints': [{'name': 'A', 'links': ['ground', 'one'],"
        "'at': [0, 0]}, {'name': 'B', 'links': ['one', 'two'], 'at': [1, 0]}], 'input': {'joint': 'A'},"
        "'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'two', 'at': [2, 0]}]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 0.5, 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, 2*cos(angle), 1e-7, 0);
    CHECK_NEAR(d.tracer[1].y, 2*sin(angle), 1e-7, 0);
    CHECK(d.report.energy_error < 1e-9*d.report.energy_scale);
    lw_model_free(&d.model);
}

/* The mass of a planet on a rod of a thousand miles: only the units are unusual. */
TEST(large_units)
{
    double angle = pendulum_angle(9.81/1.6e6, 0, 0, 2000);
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 1e24, 'centre': [1.6e6, 0]}],"
        "'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at': [0, 0]}], 'input': {'joint': 'A'},"
        "'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [1.6e6, 0]}]}", 0, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], f < 2 ? 1e-11 : 1e-9, 2000, 1), LW_OK);
        CHECK_NEAR(d.tracer[1].x, 1.6e6*cos(angle), 1.6e6*(f < 2 ? 1e-9 : 1e-5), 0);
        CHECK(d.report.steps < 10000);
    }
    lw_model_free(&d.model);
}

static const char between[] = "{'linkwright': 1, 'links': ['ground', {'name': 'mid', 'mass': %g, 'centre': [1.2, 0]},"
    "{'name': 'cart', 'mass': 2, 'centre': [2, 0]}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'mid'],"
    "'at': [1.2, 0], 'along': [1, 0]}, {'name': 'T', 'kind': 't', 'links': ['ground', 'cart'], 'at': [2, 0],"
    "'along': [1, 0]}], 'springs': [{'links': ['ground', 'mid'], 'at': [[0, 0], [1.2, 0]], 'stiffness': 300,"
    "'free': 1},"
    "{'links': ['mid', 'cart'], 'at': [[1.2, 0], [2, 0]], 'stiffness': 600, 'free': 0.7}],"
    "'tracers': [{'name': 'P', 'link': 'cart', 'at': [2, 0]}]}";

/* The place of a massless link that hangs between springs is undetermined: refused by name.  With a milligram, which
 * would vibrate at 3e4 rad/s, the springs are in series, 200 N/m: 1.7 + 0.3 cos 10 t. */
TEST(massless_between_springs)
{
    drun_read_format(&d, between, 0, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-9, 1, 1), LW_E_ARG);
        CHECK_HAS(d.e.text, "\"mid\" can move without moving any mass");
    }
    lw_model_free(&d.model);
    drun_read_format(&d, between, 1e-6, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 1, 20), LW_OK);
    for (int i = 0; i <= 20; i++)
        CHECK_NEAR(d.tracer[i].x, 1.7 + 0.3*cos(10*d.t[i]), 1e-6, 0);
    lw_model_free(&d.model);
}

/* A four-bar without any mass: refused.  With a wheel welded to its crank it moves as that pendulum: g/length is m g
 * s/(I + m s^2). */
TEST(massless_loop)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'wheel', 'mass': %g, 'centre': [-1, 0],"
        "'inertia': %g}, 'crank', 'coupler', 'rocker'], 'joints': [{'name': 'W', 'kind': 'f',"
        "'links': ['wheel', 'crank'], 'at': [0, 0]}, {'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]},"
        "{'name': 'B', 'links': ['crank', 'coupler'], 'at': [0, 1]},"
        "{'name': 'C', 'links': ['coupler', 'rocker'], 'at': [2.5, 2]},"
        "{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2.5, 0]}], 'input': {'joint': 'A', 'speed': -1},"
        "'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'wheel', 'at': [-1, 0]}]}";
    double angle = pendulum_angle(9.81/1.3, LW_PI, -1, 0.4);
    drun_read_format(&d, text, 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 1, 1), LW_E_ARG);
    CHECK_HAS(d.e.text, "can move without moving any mass");
    lw_model_free(&d.model);
    drun_read_format(&d, text, 1, 0.3);
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], f == 1 ? 1e-12 : 1e-9, 0.4, 1), LW_OK);
        CHECK_NEAR(d.tracer[1].x, cos(angle), f == 1 ? 1e-10 : 1e-5, 0);
        CHECK_NEAR(d.tracer[1].y, sin(angle), f == 1 ? 1e-10 : 1e-5, 0);
    }
    lw_model_free(&d.model);
}

/* ---- long runs -------------------------------------------------------------------------------------- */

/* A slider on a spring, 1 Hz, and a pendulum released level, period 4 K(1/sqrt 2) sqrt(l/g): a million periods and a
 * quarter later they pass the middle, but for the error of the phase. */
TEST(a_million_periods)
{
    const double quarter = 1.8540746773013719184*sqrt(1/9.81);            /* K(1/sqrt 2)                   */
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [0, 0]}],"
        "'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]}],"
        "'input': {'joint': 'S'}, 'springs': [{'joint': 'S', 'stiffness': 39.478417604357434, 'free': -1}],"
        "'tracers': [{'name': 'P', 'link': 'cart', 'at': [0, 0]}]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-13, 1000000.25, 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, -1, 1e-6, 0);
    CHECK_NEAR(d.report.period, 1, 1e-12, 0);
    CHECK(d.report.energy_error < 1e-11*d.report.energy_scale);
    lw_model_free(&d.model);
    drun_read(&d, "examples/pendulum.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-13, 4000001*quarter, 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, 0, 1e-5, 0);
    CHECK_NEAR(d.tracer[1].y, -1, 1e-10, 0);
    CHECK_NEAR(d.report.period, 4*quarter, 0, 1e-11);
    CHECK(d.report.energy_error < 1e-11*d.report.energy_scale);
    CHECK(d.report.steps < 2000);
    lw_model_free(&d.model);
}

/* A four-bar that rocks under its weight, also between samples: the same as in the coordinates of all bodies, which
 * use no period. */
TEST(periods_of_a_four_bar)
{
    static lw_vec2 want[1100];
    double turn[3];
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'centre': [0, 0.5],"
        "'inertia': 0.1}, {'name': 'coupler', 'mass': 1, 'centre': [1, 1.5], 'inertia': 0.2},"
        "{'name': 'rocker', 'mass': 2, 'centre': [2, 1], 'inertia': 0.3}],"
        "'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]},"
        "{'name': 'B', 'links': ['crank', 'coupler'], 'at': [0, 1]},"
        "{'name': 'C', 'links': ['coupler', 'rocker'], 'at': [2, 2]},"
        "{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2, 0]}], 'input': {'joint': 'D', 'speed': 0.5},"
        "'gravity': [2, 9.81], 'tracers': [{'name': 'P', 'link': 'coupler', 'at': [1, 2]}]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-13, 60, 1000), LW_OK);
    memcpy(want, d.tracer, sizeof want);
    for (int b = 0; b < 3; b++)
        turn[b] = d.q[3*b + 2];
    CHECK(d.report.period == 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-13, 60, 1000), LW_OK);
    CHECK(d.report.period > 0.5 && d.report.period < 4);
    for (int i = 0; i <= 1000; i++) {
        CHECK_NEAR(d.t[i], 0.06*i, 1e-12, 0);
        CHECK_NEAR(d.tracer[i].x, want[i].x, 1e-8, 0);
        CHECK_NEAR(d.tracer[i].y, want[i].y, 1e-8, 0);
    }
    for (int b = 0; b < 3; b++)
        CHECK_NEAR(d.q[3*b + 2], turn[b], 1e-8, 0);
    lw_model_free(&d.model);
}

/* ---- dead points ----------------------------------------------------------------------------------- */

/* A free ladder between floor and wall: its middle moves on a circle, g/length = 3 g/(2 L).  The coordinate, that of
 * its foot, turns back when the ladder lies level, and the error falls with the tolerance all the same. */
TEST(dead_point)
{
    double before = 1, angle = pendulum_angle(3*9.81/4, 1.2, 0, 3);
    drun_read(&d, "examples/dynamics/falling-ladder.json");
    for (int k = 8; k <= 12; k += 2) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, pow(10, -k), 3, 3), LW_OK);
        CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
        double off = hypot(d.tracer[3].x - cos(angle), d.tracer[3].y - sin(angle));
        CHECK(off < 0.1*before);
        CHECK(d.report.energy_error < 1e4*pow(10, -k)*d.report.energy_scale);
        before = off;
    }
    CHECK(before < 1e-8);
    lw_model_free(&d.model);
}

/* Crank and rod of one length: the slider passes the crank's pin, where the rod could also turn with the crank.
 * Without gravity the crank keeps I(q) w^2, I = a + b sin^2 q. */
typedef struct share { double a, b, energy; } share;

static lw_status share_rate(void *context, double t, const double *y, double *dy)
{
    const share *s = context;
    (void)t;
    dy[0] = sqrt(s->energy/(s->a + s->b*sin(y[0])*sin(y[0])));
    return LW_OK;
}

TEST(equal_crank_and_rod)
{
    const double r = 0.3, inertia = 0.0075, m = 1, slide = 0.5;
    share s = { .a = 2*inertia + 0.5*m*r*r, .b = m*r*r*2 + slide*4*r*r };
    lw_ode ode = { .n = 1, .context = &s, .rate = share_rate };
    double q = 0.5, y = q;
    s.energy = 16*(s.a + s.b*sin(q)*sin(q));
    drun_exact(&ode, 0, &y, 3);
    char text[1500];
    double x = r*cos(q), h = r*sin(q);
    snprintf(text, sizeof text,
        "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'centre': [%.17g, %.17g],"
        "'inertia': 0.0075}, {'name': 'rod', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.0075},"
        "{'name': 'slider', 'mass': 0.5, 'centre': [%.17g, 0]}], 'joints': [{'name': 'A',"
        "'links': ['ground', 'crank'], 'at': [0, 0]}, {'name': 'B', 'links': ['crank', 'rod'],"
        "'at': [%.17g, %.17g]}, {'name': 'C', 'links': ['rod', 'slider'], 'at': [%.17g, 0]}, {'name': 'D',"
        "'kind': 't', 'links': ['ground', 'slider'], 'at': [%.17g, 0], 'along': [1, 0]}],"
        "'input': {'joint': 'A', 'speed': 4}, 'tracers': [{'name': 'P', 'link': 'crank', 'at': [%.17g, %.17g]}]}",
        x/2, h/2, 1.5*x, h/2, 2*x, x, h, 2*x, 2*x, x, h);
    drun_read_format(&d, text, 0, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], f < 2 ? 1e-11 : 1e-9, 3, 3), LW_OK);
        CHECK_NEAR(d.tracer[3].x, r*cos(y), f < 2 ? 1e-9 : 1e-5, 0);
        CHECK_NEAR(d.tracer[3].y, r*sin(y), f < 2 ? 1e-9 : 1e-5, 0);
        CHECK_NEAR(d.q[6], d.system.reference[2].x + (2*r*cos(y) - 2*x)/d.system.unit, f < 2 ? 1e-8 : 1e-4, 0);
    }
    lw_model_free(&d.model);
}

/* Peaucellier's inversor comes with speed to where its arms lie on its rhombus and cannot go on: all formulations
 * say so, after no more than some thousand steps. */
TEST(end_of_the_way)
{
    drun_read(&d, "examples/dynamics/inversor.json");
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-9, 3, 30), LW_E_NUMERIC);
        CHECK(f == 3 || strstr(d.e.text, "singular") != NULL);
        CHECK_NEAR(d.report.t, 0.8903, f == 3 ? 0.05 : 1e-4, 0);
        CHECK(d.report.steps < 30000);
        CHECK_INT(d.n_moment, 9);                             /* samples up to there are kept */
    }
    lw_model_free(&d.model);
}

/* Conservative examples for 20 s; for 1000 s: tests/bench/bench_energy.c. */
TEST(energy_of_examples)
{
    static const char *const files[] = { "examples/pendulum.json", "examples/two-four-bars.json", "examples/dynamics/trebuchet.json",
                                         "examples/dynamics/rolling-wheel.json", "examples/dynamics/governor.json",
                                         "examples/dynamics/falling-ladder.json" };
    for (int i = 0; i < 6; i++)
        for (int f = 0; f < 2; f++) {
            drun_read(&d, files[i]);
            CHECK_INT(drun_to(&d, f ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, 1e-10, 20, 100), LW_OK);
            CHECK(d.report.energy_error < 1e-11*d.report.energy_scale);
            CHECK(d.report.energy_held < 1e-7*d.report.energy_scale);
            lw_model_free(&d.model);
        }
}

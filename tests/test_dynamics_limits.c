/* Hard scenes of dynamics against closed solutions: heavy on light, links without mass, long runs, dead points. */
#include <complex.h>

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
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'one', 'mass': 1, 'centre': [1, 0]},{'name': 'two', 'mass': 1e8, 'centre': "
        "[2, 0]}], 'joints': [{'name': 'A', 'links': ['ground', 'one'],'at': [0, 0]}, {'name': 'B', 'links': ['one', 'two'], 'at': [1, 0]}], "
        "'input': {'joint': 'A'},'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'two', 'at': [2, 0]}]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 0.5, 1), LW_OK);
    CHECK_POINT(d.tracer[1], 2*cos(angle), 2*sin(angle), 1e-7, 0);
    CHECK(d.report.energy_error < 1e-9*d.report.energy_scale);
}

/* Two bars of 1 m, their angles from +x and rates; the second mass is this part of both. */
static lw_status two_bars_rate(void *context, double t, const double *y, double *dy)
{
    (void)t;
    const double part = *(const double *)context, g = 9.81, c = cos(y[0] - y[1]), s = sin(y[0] - y[1]);
    const double a = -part*s*y[3]*y[3] - g*cos(y[0]), b = s*y[2]*y[2] - g*cos(y[1]);
    dy[0] = y[2], dy[1] = y[3];
    dy[2] = (a - part*c*b)/(1 - part*c*c);
    dy[3] = b - c*dy[2];
    return LW_OK;
}

/* A point of 1 kg hangs from one of 1e8 kg: the reactions of the heavy one do not shake it by their rounding. */
TEST(light_last)
{
    double part = 1/(1e8 + 1), y[4] = { 0 };
    lw_ode ode = { .n = 4, .context = &part, .rate = two_bars_rate };
    drun_exact(&ode, 0, y, 2);
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'one', 'mass': 1e8, 'centre': [1, 0]},{'name': 'two', 'mass': 1, 'centre': "
        "[2, 0]}], 'joints': [{'name': 'A', 'links': ['ground', 'one'],'at': [0, 0]}, {'name': 'B', 'links': ['one', 'two'], 'at': [1, 0]}], "
        "'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'two', 'at': [2, 0]}]}", 0, 0);
    for (int k = 8; k <= 12; k += 2) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, pow(10, -k), 2, 1), LW_OK);
        CHECK_POINT(d.tracer[1], cos(y[0]) + cos(y[1]), sin(y[0]) + sin(y[1]), fmax(10*pow(10, -k), 1e-10), 0);
        CHECK(d.report.steps < 200);
    }
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
}

static const char between[] = "{'linkwright': 1, 'links': ['ground', {'name': 'mid', 'mass': %g, 'centre': [1.2, 0]},{'name': 'cart', 'mass': 2, "
    "'centre': [2, 0]}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'mid'],'at': [1.2, 0], 'along': [1, 0]}, {'name': 'T', 'kind': "
    "'t', 'links': ['ground', 'cart'], 'at': [2, 0],'along': [1, 0]}], 'springs': [{'links': ['ground', 'mid'], 'at': [[0, 0], [1.2, 0]], "
    "'stiffness': 300,'free': 1},{'links': ['mid', 'cart'], 'at': [[1.2, 0], [2, 0]], 'stiffness': 600, 'free': 0.7}],'tracers': [{'name': 'P', "
    "'link': 'cart', 'at': [2, 0]}]}";

/* The place of a massless link that hangs between springs is undetermined: refused by name.  With a milligram, which
 * would vibrate at 3e4 rad/s, the springs are in series, 200 N/m: 1.7 + 0.3 cos 10 t. */
TEST(massless_between_springs)
{
    drun_read_format(&d, between, 0, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-9, 1, 1), LW_E_ARG);
        CHECK_HAS(d.e.text, "\"mid\" can move without moving any mass");
    }
    drun_read_format(&d, between, 1e-6, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 1, 20), LW_OK);
    for (int i = 0; i <= 20; i++)
        CHECK_NEAR(d.tracer[i].x, 1.7 + 0.3*cos(10*d.t[i]), 1e-6, 0);
}

/* A four-bar without any mass: refused.  With a wheel welded to its crank it moves as that pendulum: g/length is m g
 * s/(I + m s^2). */
TEST(massless_loop)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'wheel', 'mass': %g, 'centre': [-1, 0],'inertia': %g}, 'crank', "
        "'coupler', 'rocker'], 'joints': [{'name': 'W', 'kind': 'f','links': ['wheel', 'crank'], 'at': [0, 0]}, {'name': 'A', 'links': ['ground', "
        "'crank'], 'at': [0, 0]},{'name': 'B', 'links': ['crank', 'coupler'], 'at': [0, 1]},{'name': 'C', 'links': ['coupler', 'rocker'], 'at': "
        "[2.5, 2]},{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2.5, 0]}], 'input': {'joint': 'A', 'speed': -1},'gravity': [0, -9.81], "
        "'tracers': [{'name': 'P', 'link': 'wheel', 'at': [-1, 0]}]}";
    double angle = pendulum_angle(9.81/1.3, LW_PI, -1, 0.4);
    drun_read_format(&d, text, 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 1, 1), LW_E_ARG);
    CHECK_HAS(d.e.text, "can move without moving any mass");
    drun_read_format(&d, text, 1, 0.3);
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], f == 1 ? 1e-12 : 1e-9, 0.4, 1), LW_OK);
        CHECK_POINT(d.tracer[1], cos(angle), sin(angle), f == 1 ? 1e-10 : 1e-5, 0);
    }
}

/* Four-bars in their crank angle, with complex numbers: masses, inertias, and centres from the first pin of each link, along it. */
typedef struct four_bar { double length[4], mass[3], inertia[3], side; double complex arm[3]; } four_bar;

static const double complex pull = 2 - 9.81*I;

static void angles_of(const four_bar *f, double crank, double angle[3])
{
    double complex pin = f->length[0]*cexp(I*crank), to = f->length[3] - pin;
    double way = cabs(to), x = (f->length[1]*f->length[1] - f->length[2]*f->length[2] + way*way)/(2*way);
    double complex end = pin + to/way*(x + I*f->side*sqrt(fmax(0, f->length[1]*f->length[1] - x*x)));
    angle[0] = crank;
    angle[1] = carg(end - pin);
    angle[2] = carg(end - f->length[3]);
}

/* Rates of y = crank angle, its rate; returns the mass that moves with the angle. */
static double four_bar_rates(const four_bar *f, const double *y, double *dy)
{
    double angle[3], mass = 0, half = 0, push = 0, w[3] = { 1 }, bend[3] = { 0 };        /* derivatives of the angles */
    double complex turn[3], left;
    angles_of(f, y[0], angle);
    for (int i = 0; i < 3; i++)
        turn[i] = cexp(I*angle[i]);
    double across = sin(angle[1] - angle[2]);
    w[1] = f->length[0]*sin(angle[2] - angle[0])/(f->length[1]*across);
    w[2] = f->length[0]*sin(angle[1] - angle[0])/(f->length[2]*across);
    left = -I*(f->length[0]*turn[0] + f->length[1]*w[1]*w[1]*turn[1] - f->length[2]*w[2]*w[2]*turn[2]);
    bend[1] = cimag(left*conj(turn[2]))/(f->length[1]*across);
    bend[2] = cimag(left*conj(turn[1]))/(f->length[2]*across);
    for (int i = 0; i < 3; i++) {
        double complex rate = I*w[i]*f->arm[i]*turn[i], second = (I*bend[i] - w[i]*w[i])*f->arm[i]*turn[i];
        rate += i == 1 ? I*f->length[0]*turn[0] : 0;
        second -= i == 1 ? f->length[0]*turn[0] : 0;
        mass += f->mass[i]*creal(rate*conj(rate)) + f->inertia[i]*w[i]*w[i];
        half += f->mass[i]*creal(second*conj(rate)) + f->inertia[i]*w[i]*bend[i];
        push += f->mass[i]*creal(pull*conj(rate));
    }
    dy[0] = y[1];
    dy[1] = (push - half*y[1]*y[1])/mass;
    return mass;
}

static lw_status four_bar_rate(void *context, double t, const double *y, double *dy)
{
    (void)t;
    four_bar_rates(context, y, dy);
    return LW_OK;
}

/* Draw one; false: it has no mass, or comes near a posture where coupler and rocker lie in line, or where hardly any mass moves.  y: the crank angle and rate at the start,
 * then after half a second.  *growth: of errors on the way. */
static bool draw_four_bar(lw_rng *rng, four_bar *f, double y[2], double *growth)
{
    static const double masses[] = { 0, 1e-8, 1, 1, 1e8 };
    const lw_ode ode = { .n = 2, .context = f, .rate = four_bar_rate };
    double most = 0, heaviest = 0, angle[3], nearest = 1, dy[2], moved[2] = { y[0] = lw_rng_range(rng, -3, 3), y[1] = lw_rng_range(rng, 1, 3) };
    for (int i = 0; i < 4; i++)
        f->length[i] = lw_rng_range(rng, 0.5, 2);
    f->side = lw_rng_range(rng, -1, 1) < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++) {
        f->mass[i] = masses[(int)lw_rng_range(rng, 0, 5)];
        f->arm[i] = f->length[i]*(lw_rng_range(rng, 0, 1) + I*lw_rng_range(rng, -0.3, 0.3));
        f->inertia[i] = f->mass[i]*(lw_rng_range(rng, 0, 1) < 0.3 ? 0 : lw_rng_range(rng, 0.02, 0.3));
        most = fmax(most, f->mass[i]);
    }
    double way = cabs(f->length[3] - f->length[0]*cexp(I*y[0]));
    if (most == 0 || way > f->length[1] + f->length[2] - 0.2 || way < fabs(f->length[1] - f->length[2]) + 0.2)
        return false;
    for (int i = 0; i < 100 && nearest > 0.3; i++) {
        double from = moved[0];
        drun_exact(&ode, 0.005*i, moved, 0.005*(i + 1));
        int n = (int)fmin(1e4, 1 + fabs(moved[0] - from)/0.002);          /* where hardly any mass moves, the crank flies past */
        for (int k = 1; k <= n; k++) {
            double here[2] = { from + (moved[0] - from)*k/n, moved[1] };
            angles_of(f, here[0], angle);
            double mass = four_bar_rates(f, here, dy);
            heaviest = fmax(heaviest, mass);
            nearest = fmin(nearest, fmin(fabs(sin(angle[1] - angle[2])), 30*mass/heaviest));
        }
    }
    *growth = 1;
    for (int i = 0; i < 2 && nearest > 0.3; i++) {
        double other[2] = { y[0] + (i ? 0 : 1e-7), y[1] + (i ? 1e-7 : 0) };
        drun_exact(&ode, 0, other, 0.5);
        *growth = fmax(*growth, fabs(other[0] - moved[0])/1e-7);
    }
    return nearest > 0.3;
}

/* Links without mass, of a milligram, a kilogram and 1e5 tons in one loop, in all formulations.  limit: error over tolerance and growth of
 * errors; the methods of low order are less exact. */
TEST(masses_far_apart)
{
    static const struct { lw_formulation f; double limit; } each[] = {
        { LW_FORMULATION_AUTO, 100 }, { LW_FORMULATION_QUADRATURE, 100 }, { LW_FORMULATION_REDUCED, 100 }, { LW_FORMULATION_INDEX1, 100 },
        { LW_FORMULATION_RADAU, 1000 }, { LW_FORMULATION_CVODE, 1e4 }, { LW_FORMULATION_GGL, 1e4 }, { LW_FORMULATION_ALPHA, 1e4 } };
    int runs = 0, heavy = 0;
    for (int k = 0; k < 60; k++) {
        four_bar f;
        double y[2], growth, angle[3], start;
        char text[2000];
        lw_rng rng = check_rng(500 + (uint64_t)k);
        if (!draw_four_bar(&rng, &f, y, &growth))
            continue;
        angles_of(&f, start = y[0], angle);
        double complex pin = f.length[0]*cexp(I*y[0]), end = pin + f.length[1]*cexp(I*angle[1]);
        int used = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
        for (int i = 0; i < 3; i++) {
            double complex c = (i == 1 ? pin : i == 2 ? f.length[3] : 0) + f.arm[i]*cexp(I*angle[i]);
            used += snprintf(text + used, sizeof text - (size_t)used, ", {'name': 'l%d', 'mass': %.17g, 'centre': [%.17g, %.17g], 'inertia': %.17g}", i,
                             f.mass[i], creal(c), cimag(c), f.inertia[i]);
            heavy += f.mass[i] > 1;
        }
        snprintf(text + used, sizeof text - (size_t)used, "], 'joints': [{'name': 'A', 'links': ['ground', 'l0'], 'at': [0, 0]}, {'name': 'B', 'links': ['l0', 'l1'], "
                 "'at': [%.17g, %.17g]}, {'name': 'C', 'links': ['l1', 'l2'], 'at': [%.17g, %.17g]}, {'name': 'D', 'links': ['l2', 'ground'], "
                 "'at': [%.17g, 0]}], 'input': {'joint': 'A', 'speed': %.17g}, 'gravity': [2, -9.81]}", creal(pin), cimag(pin), creal(end), cimag(end),
                 f.length[3], y[1]);
        drun_exact(&(lw_ode){ .n = 2, .context = &f, .rate = four_bar_rate }, 0, y, 0.5);
        drun_read_format(&d, text, 0, 0);
        for (int e = 0; e < 8; e++) {
            lw_status s = drun_to(&d, each[e].f, 1e-8, 0.5, 5);
            CHECK(s == LW_OK || s == LW_E_KIND);
            if (s == LW_OK)
                CHECK_NEAR(d.q[2], y[0] - start, each[e].limit*1e-8*growth, 0);
            runs += s == LW_OK;
        }
    }
    CHECK(runs > 50 && heavy > 0);
}

/* A crank and a coupler that hardly have mass turn a rocker without gravity: it turns evenly to and fro, and in its dead points, where only
 * they move, they turn 1e4 times as fast.  Without any mass the run ends there. */
TEST(light_crank)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL };
    const double last = acos(-0.3125), first = acos(0.6875), span = last - first;    /* 1 and 2 long, crank 0.5, rocker 1, ground 2 */
    four_bar f = { .length = { 0.5, 2, 1, 2 }, .side = 1 };
    double angle[3];
    angles_of(&f, 1, angle);
    double complex pin = 0.5*cexp(I), end = 2 + cexp(I*angle[2]);
    double from = angle[2] - (LW_PI - last);
    for (int k = 0; k < 2; k++) {
        char text[1500];
        double mass = k ? 0 : 1e-8;
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': %.17g, 'centre': [0, 0], 'inertia': %.17g}, {'name': 'b', 'mass': %.17g,"
                 " 'centre': [%.17g, %.17g], 'inertia': %.17g}, {'name': 'c', 'mass': 1, 'centre': [2, 0], 'inertia': 1}], 'joints': ["
                 "{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [%.17g, %.17g]},"
                 "{'name': 'C', 'links': ['b', 'c'], 'at': [%.17g, %.17g]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [2, 0]}],"
                 "'input': {'joint': 'D', 'speed': 1}}", mass, mass, mass, creal(pin), cimag(pin), mass, creal(pin), cimag(pin), creal(end), cimag(end));
        drun_read_format(&d, text, 0, 0);
        for (int e = 0; e < 5; e++) {
            lw_status s = drun_to(&d, each[e], 1e-8, 3, 10);
            double way = fmod(from + 3, 2*span);
            if (k == 0) {
                CHECK_INT(s, LW_OK);
                CHECK_NEAR(d.q[8], (way < span ? way : 2*span - way) - from, 2e-6, 0);
                CHECK_NEAR(d.v[8], way < span ? 1 : -1, 1e-6, 0);
            } else {
                CHECK_INT(s, LW_E_NUMERIC);
                CHECK(strstr(d.e.text, "no mass") || strstr(d.e.text, "without moving any mass"));
                CHECK_NEAR(d.report.t, span - from, 1e-5, 0);
            }
        }
    }
}

/* ---- long runs -------------------------------------------------------------------------------------- */

/* A slider on a spring, 1 Hz, and a pendulum released level, period 4 K(1/sqrt 2) sqrt(l/g): a million periods and a
 * quarter later they pass the middle, but for the error of the phase. */
TEST(a_million_periods)
{
    const double quarter = 1.8540746773013719184*sqrt(1/9.81);            /* K(1/sqrt 2)                   */
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [0, 0]}],'joints': [{'name': 'S', 'kind': 't', "
        "'links': ['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]}],'input': {'joint': 'S'}, 'springs': [{'joint': 'S', 'stiffness': "
        "39.478417604357434, 'free': -1}],'tracers': [{'name': 'P', 'link': 'cart', 'at': [0, 0]}]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-13, 1000000.25, 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, -1, 1e-6, 0);
    CHECK_NEAR(d.report.period, 1, 1e-12, 0);
    CHECK(d.report.energy_error < 1e-11*d.report.energy_scale);
    drun_read(&d, "examples/pendulum.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-13, 4000001*quarter, 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, 0, 1e-5, 0);
    CHECK_NEAR(d.tracer[1].y, -1, 1e-10, 0);
    CHECK_NEAR(d.report.period, 4*quarter, 0, 1e-11);
    CHECK(d.report.energy_error < 1e-11*d.report.energy_scale);
    CHECK(d.report.steps < 2000);
}

/* A damped cart rests, millions of years long: how short its first steps are has nothing to do with the end of the run. */
TEST(long_rest)
{
    drun_read_text(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 1, 'inertia': 1, 'centre': [2, 0]}], 'joints': [{'name': 'T', 'kind': 't', "
        "'links': ['ground', 'cart'], 'at': [2, 0], 'along': [1, 0]}], 'springs': [{'links': ['ground', 'cart'], 'at': [[0, 0], [2, 0]], 'stiffness': 300, "
        "'free': 1.5, 'damping': 2}], 'tracers': [{'name': 'P', 'link': 'cart', 'at': [2, 0]}]}");
    CHECK_INT(drun_to(&d, LW_FORMULATION_RADAU, 1e-9, 1e14, 1), LW_OK);
    CHECK_INT(d.report.formulation, LW_FORMULATION_RADAU);
    CHECK_NEAR(d.tracer[1].x, 1.5, 1e-12, 0);
}

/* A four-bar that rocks under its weight, also between samples: the same as in the coordinates of all bodies, which
 * use no period. */
TEST(periods_of_a_four_bar)
{
    static lw_vec2 want[1100];
    double turn[3];
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'centre': [0, 0.5],'inertia': 0.1}, {'name': 'coupler', "
        "'mass': 1, 'centre': [1, 1.5], 'inertia': 0.2},{'name': 'rocker', 'mass': 2, 'centre': [2, 1], 'inertia': 0.3}],'joints': [{'name': 'A', "
        "'links': ['ground', 'crank'], 'at': [0, 0]},{'name': 'B', 'links': ['crank', 'coupler'], 'at': [0, 1]},{'name': 'C', 'links': ['coupler', "
        "'rocker'], 'at': [2, 2]},{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2, 0]}], 'input': {'joint': 'D', 'speed': 0.5},'gravity': [2, "
        "9.81], 'tracers': [{'name': 'P', 'link': 'coupler', 'at': [1, 2]}]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-13, 60, 1000), LW_OK);
    memcpy(want, d.tracer, sizeof want);
    for (int b = 0; b < 3; b++)
        turn[b] = d.q[3*b + 2];
    CHECK(d.report.period == 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-13, 60, 1000), LW_OK);
    CHECK(d.report.period > 0.5 && d.report.period < 4);
    for (int i = 0; i <= 1000; i++) {
        CHECK_NEAR(d.t[i], 0.06*i, 1e-12, 0);
        CHECK_POINT(d.tracer[i], want[i].x, want[i].y, 1e-8, 0);
    }
    for (int b = 0; b < 3; b++)
        CHECK_NEAR(d.q[3*b + 2], turn[b], 1e-8, 0);
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
        "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'centre': [%.17g, %.17g],'inertia': 0.0075}, {'name': 'rod', 'mass': 1, "
        "'centre': [%.17g, %.17g], 'inertia': 0.0075},{'name': 'slider', 'mass': 0.5, 'centre': [%.17g, 0]}], 'joints': [{'name': 'A','links': "
        "['ground', 'crank'], 'at': [0, 0]}, {'name': 'B', 'links': ['crank', 'rod'],'at': [%.17g, %.17g]}, {'name': 'C', 'links': ['rod', "
        "'slider'], 'at': [%.17g, 0]}, {'name': 'D','kind': 't', 'links': ['ground', 'slider'], 'at': [%.17g, 0], 'along': [1, 0]}],'input': "
        "{'joint': 'A', 'speed': 4}, 'tracers': [{'name': 'P', 'link': 'crank', 'at': [%.17g, %.17g]}]}",
        x/2, h/2, 1.5*x, h/2, 2*x, x, h, 2*x, 2*x, x, h);
    drun_read_format(&d, text, 0, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], f < 2 ? 1e-11 : 1e-9, 3, 3), LW_OK);
        CHECK_POINT(d.tracer[3], r*cos(y), r*sin(y), f < 2 ? 1e-9 : 1e-5, 0);
        CHECK_NEAR(d.q[6], d.system.reference[2].x + (2*r*cos(y) - 2*x)/d.system.unit, f < 2 ? 1e-8 : 1e-4, 0);
    }
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
        }
}

/* Time as an integral over one coordinate: against closed forms, against the differential equations, at its edges. */
#include <math.h>
#include "tests/dynamics_run.h"

static drun d;
static drun twin;

static const char pendulum[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 2, 'centre': [%.17g, %.17g]}],"
    "'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at': [0, 0]}], 'input': {'joint': 'A'},"
    "'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [%.17g, %.17g]}]}";

/* A bob of 2 kg one metre from its pin, at `angle` from straight down, with a speed. */
static void hang(double angle, double speed)
{
    char text[900];
    snprintf(text, sizeof text, pendulum, sin(angle), -cos(angle), sin(angle), -cos(angle));
    drun_read_format(&d, text, 0, 0);
    d.model.has_speed[0] = true;
    d.model.speed[0] = speed;
}

/* The complete elliptic integral K(k), k' = sqrt(1 - k^2), by the arithmetic-geometric mean (Gauss) */
static double elliptic(double complement)
{
    long double a = 1, b = complement;
    for (int i = 0; i < 40; i++) {
        long double mean = 0.5L*(a + b);
        b = sqrtl(a*b);
        a = mean;
    }
    return (double)(acosl(-1)/(2*a));
}

static double period(double angle) { return 4/sqrt(9.81)*elliptic(cos(angle/2)); }

/* After whole periods of the elliptic integral a pendulum is where it was released; after half a period, on the
 * other side. */
TEST(swings)
{
    static const double angle[] = { 1e-3, 0.3, 1.5, 3, 3.14 };
    for (size_t i = 0; i < sizeof angle/sizeof *angle; i++)
        for (int k = 6; k <= 12; k += 2) {
            hang(angle[i], 0);
            CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, pow(10, -k), 10*period(angle[i]), 20), LW_OK);
            CHECK_INT(d.report.formulation, LW_FORMULATION_QUADRATURE);
            for (int n = 0; n <= 20; n++)
                CHECK_NEAR(d.tracer[n].x, (n%2 ? -1 : 1)*sin(angle[i]), 1e-11 + 10*pow(10, -k), 0);
            CHECK(d.report.energy_error < 1e-13*2*9.81);
        }
}

/* A slider on a spring, 10 rad/s, starts just before its middle, where the force is a fraction of that at the place from which it would start at rest. */
TEST(starts_beside_the_middle)
{
    static const double at[] = { -0.02, -0.005, -0.001, -1e-5 }, speed[] = { 0.02, 0.05, 0.1, 0.3 };
    for (int i = 0; i < 16; i++) {
        double x = at[i/4], v = speed[i%4];
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [%.17g, 0]}], 'joints': [{'name': 'S', 'kind': 't', "
            "'links': ['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]}], 'input': {'joint': 'S', 'value': 0, 'speed': %.17g}, 'springs': [{'links': ['ground', 'cart'], "
            "'at': [[-2, 0], [0, 0]], 'stiffness': 100, 'free': 2}], 'tracers': [{'name': 'P', 'link': 'cart', 'at': [0, 0]}]}", 0, v);
        d.model.spring[0].free = 2 - x;
        CHECK_INT(drun_to(&d, LW_FORMULATION_QUADRATURE, 1e-9, 3, 30), LW_OK);
        for (int n = 0; n <= 30; n++)
            CHECK_NEAR(x + d.tracer[n].x, x*cos(10*d.t[n]) + v/10*sin(10*d.t[n]), 1e-9, 0);
    }
}

/* Over the top: int dphi/speed is an elliptic integral too. */
TEST(turns_over)
{
    static const double speed[] = { 6.3, 7, 20, -6.3 };      /* it just stands on top with 2 sqrt(9.81) = 6.264 */
    for (size_t i = 0; i < sizeof speed/sizeof *speed; i++) {
        double turn = 4/fabs(speed[i])*elliptic(sqrt(1 - 4*9.81/(speed[i]*speed[i])));
        hang(0, speed[i]);
        CHECK_INT(drun_to(&d, LW_FORMULATION_QUADRATURE, 1e-11, 7*turn, 14), LW_OK);
        for (int n = 0; n <= 14; n++) {
            CHECK_NEAR(d.tracer[n].x, 0, 1e-10, 0);
            CHECK_NEAR(d.tracer[n].y, n%2 ? 1 : -1, 1e-12, 0);
        }
        CHECK_NEAR(fabs(d.q[2]), 14*LW_PI, 1e-10, 0);         /* turns are counted                              */
    }
}

/* Many periods: only rounding changes the phase. */
TEST(ten_thousand_periods)
{
    hang(2, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-14, 10000.25*period(2), 1), LW_OK);
    CHECK_NEAR(d.tracer[1].x, 0, 1e-8, 0);
    CHECK_NEAR(d.tracer[1].y, -1, 1e-12, 0);
}

/* On top without speed it stands; nearly on top it falls as the differential equations say. */
TEST(at_the_top)
{
    hang(LW_PI, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 5), LW_OK);
    CHECK_NEAR(d.tracer[5].y, 1, 1e-9, 0);
    hang(LW_PI - 1e-6, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_QUADRATURE, 1e-12, 8, 40), LW_OK);
    hang(LW_PI - 1e-6, 0);
    double y[40];
    for (int i = 0; i < 40; i++)
        y[i] = d.tracer[i + 1].y;
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-13, 8, 40), LW_OK);
    for (int i = 0; i < 40; i++)
        CHECK_NEAR(y[i], d.tracer[i + 1].y, 1e-6, 0);
}

/* The same motion by the differential equation of one coordinate, at every sample. */
static void against_the_equation(const char *file, double to, double allowed)
{
    drun_read(&d, file);
    drun_read(&twin, file);
    CHECK_INT(drun_to(&twin, LW_FORMULATION_REDUCED, 1e-13, to, 200), LW_OK);
    for (int k = 8; k <= 13; k++) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_QUADRATURE, pow(10, -k), to, 200), LW_OK);
        CHECK_INT(d.n_moment, twin.n_moment);
        for (int i = 0; i < d.n_moment; i++)
            CHECK_POINT(d.tracer[i], twin.tracer[i].x, twin.tracer[i].y, allowed + 100*pow(10, -k), 0);
        for (int i = 0; i < d.system.n_q; i++) {
            CHECK_NEAR(d.q[i], twin.q[i], allowed + 100*pow(10, -k), 0);        /* turns among them              */
            CHECK_NEAR(d.v[i], twin.v[i], allowed + 100*pow(10, -k), 100*(allowed + 100*pow(10, -k)));
        }
        CHECK(d.report.energy_error < 1e-10*d.report.energy_scale);
    }
}

TEST(linkages)
{
    against_the_equation("examples/two-four-bars.json", 10, 1e-9);
    against_the_equation("examples/andrews.json", 0.03, 1e-9);          /* its torque is constant               */
}

/* A slider on which a force of 3 N changes its sign at `at`: forwards over it, and back from a rest behind it.  No panel would end there. */
TEST(forces_that_jump)
{
    static const char slider[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 's', 'mass': 1, 'centre': [0, 0], 'inertia': 1}], 'joints': [{'name': 'S', 'kind': 't', 'links': "
        "['ground', 's'], 'at': [0, 0], 'along': [1, 0]}], 'input': {'joint': 'S', 'speed': 2}, 'springs': [{'joint': 'S', 'law': '-3*sign(displacement - "
        "%.17g)'}], 'tracers': [{'name': 'P', 'link': 's', 'at': [0, 0]}]}";
    double most = 0;
    for (int k = 0; k < 60; k++) {
        double at = 0.3 + 0.011*k, there = (sqrt(4 + 6*at) - 2)/3, v = 2 + 3*there;
        drun_read_format(&d, slider, at, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 3, 30), LW_OK);
        CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
        for (int n = 0; n <= 30; n++) {
            double t = 0.1*n, after = t - there, back = after - 2*v/3;
            double x = after < 0 ? 2*t + 1.5*t*t : back < 0 ? at + v*after - 1.5*after*after : at - v*back + 1.5*back*back;
            most = fmax(most, fabs(d.tracer[n].x - x));
        }
    }
    CHECK(most < 1e-9);
}

/* Loads that depend on time or speed are refused, and the formulation is not chosen. */
TEST(refusals)
{
    static const char *const more[] = { "'springs': [{'joint': 'A', 'stiffness': 1, 'damping': 1}]",
        "'forces': [{'link': 'bob', 'at': [0, 0], 'torque': 'sin(t)'}]",
        "'motors': [{'joint': 'A', 'stall': 2, 'free_speed': 9}]" };
    for (size_t i = 0; i < sizeof more/sizeof *more; i++) {
        char text[900];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 2,"
                 "'centre': [1, 0]}], 'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at': [0, 0]}],"
                 "'input': {'joint': 'A'}, %s}", more[i]);
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_QUADRATURE, 1e-9, 1, 1), LW_E_KIND);
        CHECK_HAS(d.e.text, "time or speed");
        CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 1, 1), LW_OK);
        CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
    }
}

/* From rest with a constant torque, whose work has no potential: phi = T t^2/(2 J). */
TEST(out_of_rest)
{
    for (int way = -1; way <= 1; way += 2) {
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'wheel', 'mass': 1, 'centre': [0, 0],"
                         "'inertia': 0.5}], 'joints': [{'name': 'A', 'links': ['ground', 'wheel'], 'at': [0, 0]}],"
                         "'input': {'joint': 'A'}, 'forces': [{'link': 'wheel', 'at': [0, 0], 'torque': %g}],"
                         "'tracers': [{'name': 'P', 'link': 'wheel', 'at': [1, 0]}]}", 3*way, 0);
        for (double speed = -2; speed <= 2; speed += 1) {      /* against the torque: it comes to rest first      */
            d.model.has_speed[0] = true;
            d.model.speed[0] = speed;
            CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 4, 8), LW_OK);
            CHECK_INT(d.report.formulation, LW_FORMULATION_QUADRATURE);
            CHECK_NEAR(d.q[2], speed*4 + 3*way*16, 1e-9, 0);
            CHECK(d.report.energy_error < 1e-13*d.report.energy_scale);
        }
    }
}

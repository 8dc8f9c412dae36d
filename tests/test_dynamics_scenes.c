/* Scenes with every kind of joint and load: all formulations that take them agree, energies balance, and closed
 * solutions are met. */
#include "tests/dynamics_run.h"

static drun d, first;

static const lw_formulation all[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                      LW_FORMULATION_GGL };

/* ---- masses and stiffnesses far apart ------------------------------------------------------------ */

static const char double_pendulum[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'one', 'mass': %g, 'centre': [1, 0]},{'name': 'two', 'mass': %g, 'centre': [2, 0]}], 'joints': "
    "[{'name': 'A', 'links': ['ground', 'one'],'at': [0, 0]},{'name': 'B', 'links': ['one', 'two'], 'at': [1, 0]}], 'input': {'joint': 'A'}, "
    "'gravity': [0, -9.81],'tracers': [{'name': 'P', 'link': 'two', 'at': [2, 0]}]}";

/* The equations of two mass points in their angles. */
static lw_status double_rate(void *context, double t, const double *y, double *dy)
{
    const double *m = context, g = 9.81, c = cos(y[0] - y[1]), s = sin(y[0] - y[1]);
    double a = m[0] + m[1], b = m[1]*c, p = -m[1]*s*y[3]*y[3] - a*g*cos(y[0]), r = s*y[2]*y[2] - g*cos(y[1]);
    (void)t;
    dy[0] = y[2];
    dy[1] = y[3];
    dy[2] = (p - b*r)/(a - b*c);
    dy[3] = r - c*dy[2];
    return LW_OK;
}

/* Place of the second mass at `to` [m]. */
static lw_vec2 double_place(double *mass, double to)
{
    lw_ode ode = { .n = 4, .context = mass, .rate = double_rate };
    double y[4] = { 0 };
    drun_exact(&ode, 0, y, to);
    return lw_v2_add(lw_v2_polar(1, y[0]), lw_v2_polar(1, y[1]));
}

/* With the heavy mass last, the light one is a bead on a taut string: slow, but the same. */
TEST(masses_far_apart)
{
    static const double mass[][2] = { { 1, 1 }, { 1e8, 1 }, { 1, 1e4 } }, slack[] = { 0, 1e-8, 1e-4, 1e-4 };
    for (int k = 0; k < 3; k++) {
        double m[2] = { mass[k][0], mass[k][1] };
        lw_vec2 want = double_place(m, 2);
        drun_read_format(&d, double_pendulum, m[0], m[1]);
        for (int f = 1; f < 4; f++) {
            CHECK_INT(drun_to(&d, all[f], f == 1 ? 1e-12 : 1e-9, 2, 1), LW_OK);
            CHECK_POINT(d.tracer[1], want.x, want.y, slack[f], 0);
            if (f == 1)
                CHECK(d.report.energy_error < 1e-9*d.report.energy_scale);
        }
    }
}

/* A four-bar whose coupler has no mass moves as with nearly none; a pendulum without mass is refused by name. */
TEST(without_mass)
{
    static const char text[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'centre': [0, 0.5], 'inertia': 0.1},{'name': 'coupler', 'mass': %g, "
        "'centre': [1, 1.5], 'inertia': %g},{'name': 'rocker', 'mass': 2, 'centre': [2, 1], 'inertia': 0.3}],'joints': [{'name': 'A', 'links': "
        "['ground', 'crank'], 'at': [0, 0]},{'name': 'B', 'links': ['crank', 'coupler'], 'at': [0, 1]},{'name': 'C', 'links': ['coupler', 'rocker'], "
        "'at': [2, 2]},{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2, 0]}], 'input': {'joint': 'A', 'speed': -1},'gravity': [0, -9.81],"
        "'tracers': [{'name': 'P', 'link': 'coupler', 'at': [1, 2]}]}";
    drun_read_format(&first, text, 1e-9, 1e-9);
    CHECK_INT(drun_to(&first, LW_FORMULATION_REDUCED, 1e-12, 2, 1), LW_OK);
    drun_read_format(&d, text, 0, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], f < 2 ? 1e-12 : 1e-9, 2, 1), LW_OK);
        CHECK_POINT(d.tracer[1], first.tracer[1].x, first.tracer[1].y, f < 2 ? 1e-7 : 1e-5, 0);
    }
    drun_read_format(&d, double_pendulum, 1, 0);
    for (int f = 0; f < 4; f++) {
        CHECK_INT(drun_to(&d, f ? all[f] : LW_FORMULATION_AUTO, 1e-9, 1, 1), LW_E_ARG);
        CHECK_HAS(d.e.text, "\"two\"");
    }
}

/* A slider on a spring of 1e10 N/m: cos(1e5 t); with a critical damper the soft one beside it sets the time. */
TEST(stiff_springs)
{
    static const char text[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'near', 'mass': 1, 'centre': [0, 0]},{'name': 'far', 'mass': 1,'centre': [1, 0]}], 'joints': "
        "[{'name': 'S', 'kind': 't', 'links': ['ground', 'near'], 'at': [0, 0],'along': [1, 0]},{'name': 'T', 'kind': 't', 'links': ['ground', "
        "'far'], 'at': [1, 0], 'along': [1, 0]}],'springs': [{'joint': 'S', 'stiffness': 1e10, 'free': %g},{'links': ['near', 'far'], 'at': [[0, 0], "
        "[1, 0]],'stiffness': 1, 'free': 0.5}], 'dampers': [{'joint': 'S', 'damping': %g}],'tracers': [{'name': 'P', 'link': 'far', 'at': [1, 0]}, "
        "{'name': 'Q', 'link': 'near', 'at': [0, 0]}]}";
    drun_read_format(&d, text, -1e-3, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-12, 1e-3, 10), LW_OK);
    CHECK_NEAR(d.q[0], d.system.reference[0].x + (-1e-3 + 1e-3*cos(100))/d.system.unit, 1e-9, 0);
    CHECK(d.report.energy_error < 1e-9*d.report.energy_scale);
    drun_read_format(&d, text, 0, 2e5);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 3, 10), LW_OK);
    CHECK_INT(d.report.formulation, LW_FORMULATION_GGL);
    for (int i = 0; i <= 10; i++)
        CHECK_NEAR(d.tracer[i].x, 0.5 + 0.5*cos(d.t[i]), 1e-7, 0);
    CHECK(d.report.steps < 3000);
}

/* ---- loads ------------------------------------------------------------------------------------- */

/* I w' = 2 (1 - w/10) - 0.1 w; a slider pushed by sin 3t and pulled back by 4 x: (sin 3t - 1.5 sin 2t)/-5. */
TEST(motor_and_law)
{
    static const char motor[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'wheel', 'mass': 1, 'centre': [0, 0], 'inertia': 0.1}],"
        "'joints': [{'name': 'A', 'links': ['ground', 'wheel'], 'at': [0, 0]}], 'input': {'joint': 'A'},"
        "'motors': [{'joint': 'A', 'stall': %g, 'free_speed': %g}], 'dampers': [{'joint': 'A', 'damping': 0.1}]}";
    static const char pushed[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [0, 0]}],'joints': [{'name': 'S', 'kind': 't', 'links': "
        "['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]}],'input': {'joint': 'S'}, 'forces': [{'link': 'cart', 'at': [0, 0], 'fx': 'sin(3*t) - "
        "4*q(S)'}],'tracers': [{'name': 'P', 'link': 'cart', 'at': [0, 0]}]}";
    drun_read_format(&d, motor, 2, 10);
    for (int f = 0; f < 4; f++) {
        double slack = f < 2 ? 1e-9 : 1e-6;
        CHECK_INT(drun_to(&d, all[f], 1e-10, 1, 10), LW_OK);
        CHECK_NEAR(d.v[2], 20./3*(1 - exp(-3)), slack, 0);
        CHECK_INT(drun_to(&d, all[f], 1e-10, 20, 10), LW_OK);
        CHECK_NEAR(d.v[2], 20./3, slack, 0);
        CHECK(d.report.energy_error < slack*100);
    }
    drun_read_format(&d, pushed, 0, 0);
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-10, 5, 10), LW_OK);
        for (int i = 0; i <= 10; i++)
            CHECK_NEAR(d.tracer[i].x, (1.5*sin(2*d.t[i]) - sin(3*d.t[i]))/5, f < 2 ? 1e-8 : 1e-6, 0);
        CHECK(d.report.energy_error < (f < 2 ? 1e-8 : 1e-5)*d.report.energy_scale);
    }
}

/* ---- starts ------------------------------------------------------------------------------------ */

/* Upright a pendulum stays; 1e-6 beside, it leaves as cosh.  Speeds that exclude each other are an error. */
TEST(starts)
{
    static const char up[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 1, 'centre': [%.17g, 1]}],'joints': [{'name': 'A', 'links': ['ground', "
        "'bob'], 'at': [0, 0]}], 'input': {'joint': 'A'},'gravity': [0, -%.17g],'tracers': [{'name': 'P', 'link': 'bob', 'at': [0, 1]}]}";
    static const char two[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5]},{'name': 'b', 'mass': 1, 'centre': [0.5, 1]}, {'name': "
        "'c', 'mass': 1, 'centre': [1, 0.5]}],'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},{'name': 'B', 'links': ['a', 'b'], "
        "'at': [0, 1]},{'name': 'C', 'links': ['b', 'c'], 'at': [1, 1]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0]}],'inputs': [{'joint': "
        "'A', 'speed': %g}, {'joint': 'D', 'speed': %g}],'tracers': [{'name': 'P', 'link': 'b', 'at': [0, 1]}]}";
    static const char dead[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1},{'name': 'b', 'mass': 1, 'centre': [2, "
        "0], 'inertia': 0.3}, {'name': 'c', 'mass': 1, 'centre': [3, 0]}],'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': "
        "'B', 'links': ['a', 'b'], 'at': [1, 0]},{'name': 'C', 'links': ['b', 'c'], 'at': [3, 0]}, {'name': 'S', 'kind': 't', 'links': ['ground', "
        "'c'], 'at': [3, 0],'along': [1, 0]}], 'input': {'joint': 'S', 'speed': %g}, 'tracers': [{'name': 'P', 'link': 'b', 'at': [1, 0]}]}";
    for (int f = 0; f < 4; f++) {
        drun_read_format(&d, up, 0, 9.81);
        CHECK_INT(drun_to(&d, all[f], 1e-10, 5, 10), LW_OK);
        CHECK_NEAR(d.tracer[10].x, 0, 1e-9, 0);
        drun_read_format(&d, up, 1e-6, 9);
        CHECK_INT(drun_to(&d, all[f], 1e-12, 2, 10), LW_OK);
        CHECK_NEAR(d.tracer[10].x, 1e-6*(cosh(6) - 1), 1e-8, 0);
    }
    drun_read_format(&d, two, 1, 2);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 0.1, 1), LW_E_ARG);
    CHECK_HAS(d.e.text, "they are off by 0.5 (of 2)");       /* both would be 1.5 */
    drun_read_format(&d, dead, 3, 0);                                    /* no speed moves a slider beyond its dead point */
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 0.1, 1), LW_E_ARG);
    CHECK_HAS(d.e.text, "at \"S\": they are off by ");
    drun_read_format(&d, dead, 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 0.1, 1), LW_OK);
    drun_read_format(&d, two, 1, 1);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 0.1, 1), LW_OK);
    CHECK_NEAR(d.v[2], 1, 1e-9, 0);
}

/* ---- every kind of joint ------------------------------------------------------------------------- */

static const char geared[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'wheel', 'mass': 1, 'centre': [0, 0.1], 'inertia': 0.2},{'name': 'pinion', 'mass': 0.5, "
    "'centre': [3, 0], 'inertia': 0.1},{'name': 'rod', 'mass': 1, 'centre': [1, 1.7]},{'name': 'bar', 'mass': 2, 'centre': [2.5, 1.9], 'inertia': "
    "0.1}], 'joints': [{'name': 'A','links': ['ground', 'wheel'],'at': [0, 0]}, {'name': 'B', 'links': ['ground', 'pinion'], 'at': [3, 0]},{'name': "
    "'C', 'links': ['wheel', 'rod'], 'at': [0.5, 0.5]},{'name': 'D', 'links': ['rod', 'bar'], 'at': [1.5, 3]},{'name': 'E', 'links': ['bar', "
    "'pinion'], 'at': [3.5, 0.8]},{'name': 'G', 'kind': 'g', 'links': ['wheel', 'pinion'], 'at': [1, 0], 'ratio': %g}],'input': {'joint': 'A', "
    "'speed': %g}, 'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'rod','at': [1, 2]}]}";
static const char slotted[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1},{'name': 'lever', 'mass': 2, 'centre': "
    "[0.2, -1], 'inertia': 0.5}], 'joints': [{'name': 'A','links': ['ground', 'crank'],'at': [0, 0]}, {'name': 'B', 'links': ['ground', 'lever'], "
    "'at': [0, -3]},{'name': 'C', 'kind': 'p', 'links': ['lever', 'crank'], 'at': [1, 0], 'along': [1, 3]}],'input': {'joint': 'A', 'speed': %g}, "
    "'gravity': [0, -%g], 'springs': [{'links': ['ground', 'lever'],'at': [[2, 0],[0.4, -0.5]], 'stiffness': 20}], 'tracers': [{'name': 'P', 'link': "
    "'lever', 'at': [0.5, 1]}]}";
static const char open_chain[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'one', 'mass': 1, 'centre': [0.4, 0.1], 'inertia': 0.1},{'name': 'two', 'mass': 2, 'centre': "
    "[1.5, 0.5], 'inertia': 0.2},{'name': 'three', 'mass': 0.5, 'centre': [2, 1.5]}],'joints': [{'name': 'A', 'links': ['ground', 'one'], 'at': [0, "
    "0]},{'name': 'B', 'kind': 't', 'links': ['one', 'two'],'at': [1, 0], 'along': [1, 1]}, {'name': 'C', 'links': ['two', 'three'], 'at': [2, 1]}],"
    "'input': {'joint': 'A', 'speed': %g}, 'gravity': [0, -9.81], 'springs': [{'joint': 'B', 'stiffness': %g}],'tracers': [{'name': 'P', 'link': "
    "'three', 'at': [2, 2]}]}";

static void agree(const char *text, double a, double b)
{
    first.n_moment = 0;
    int n_run = 0;
    drun_read_format(&d, text, a, b);
    for (int f = 1; f < 5; f++) {                 /* index1 first: it takes all */
        lw_status s = drun_to(&d, all[f%4], f == 1 || f == 4 ? 1e-12 : 1e-9, 1, 20);
        if (f == 4 && s == LW_E_KIND)
            continue;
        CHECK_INT(s, LW_OK);
        n_run += s == LW_OK;
        CHECK(d.report.energy_error < (f == 1 || f == 4 ? 1e-9 : 1e-4)*d.report.energy_scale);
        CHECK(d.report.worst_off < 1e-12);
        for (int i = 0; f > 1 && i <= 20; i++)
            CHECK_POINT(d.tracer[i], first.tracer[i].x, first.tracer[i].y, f == 4 ? 1e-8 : 1e-4, 0);
        if (f == 1)
            drun_keep_path(&first, &d);
    }
    CHECK(n_run >= 3);
}

/* A rack and the arm it slides on, each welded of two halves, move as those in one piece: the row of the gear has
 * four bodies and the pinion. */
TEST(welded_rack)
{
    static const char halves[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'arm', 'mass': 1, 'centre': [0.5, 0]},{'name': 'wheel', 'mass': 1, 'centre': [1.1, 0.5], "
        "'inertia': 0.1},{'name': 'rack', 'mass': 2, 'centre': [1, 0.2], 'inertia': 0.3}%s],'joints': [{'name': 'A', 'links': ['ground', 'arm'], "
        "'at': [0, 0]},{'name': 'P', 'links': ['arm', 'wheel'], 'at': [1, 0.5]},{'name': 'S', 'kind': 't', 'links': ['%s', '%s'], 'at': [1, 0.2], "
        "'along': [1, 0]},{'name': 'G', 'kind': 'g', 'links': ['wheel', 'rack'], 'at': [1, 0.2], 'ratio': 0.3}%s],'inputs': [{'joint': 'A', 'speed': "
        "1}, {'joint': 'P', 'speed': 2}], 'gravity': [0, -9.81],'tracers': [{'name': 'Q', 'link': 'rack', 'at': [1.5, 0.2]}]}";
    static const char more[] = ", {'name': 'arm2', 'mass': 0, 'centre': [0, 0]},{'name': 'rack2', 'mass': 0, 'centre': [0, 0]}";
    static const char welds[] = ", {'name': 'W', 'kind': 'f', 'links': ['arm', 'arm2'], 'at': [1, 0]},"
                                "{'name': 'X', 'kind': 'f', 'links': ['rack', 'rack2'], 'at': [1.2, 0.3]}";
    char text[2000];
    for (int f = 0; f < 4; f++) {
        snprintf(text, sizeof text, halves, "", "arm", "rack", "");
        drun_read_format(&first, text, 0, 0);
        CHECK_INT(drun_to(&first, LW_FORMULATION_INDEX1, 1e-11, 1, 10), LW_OK);
        snprintf(text, sizeof text, halves, more, "arm2", "rack2", welds);
        drun_read_format(&d, text, 0, 0);
        lw_status s = drun_to(&d, f ? all[f] : LW_FORMULATION_AUTO, 1e-11, 1, 10);
        CHECK_INT(s, LW_OK);
        CHECK(fabs(d.tracer[10].x - d.tracer[0].x) > 0.1);
        for (int i = 0; i <= 10; i++)
            CHECK_POINT(d.tracer[i], first.tracer[i].x, first.tracer[i].y, f < 2 ? 1e-9 : 1e-6, 0);
    }
}

TEST(kinds_of_joints)
{
    agree(geared, -0.5, 1);
    agree(geared, 2, -3);
    agree(slotted, 1, 9.81);
    agree(slotted, -6, 0);
    agree(open_chain, 1, 50);
    agree(open_chain, -4, 300);
}

/* A body tied to the ground by two massless sliders and a pin flies freely: its centre on a parabola, its turn at a
 * constant rate.  A link welded of two halves swings as the link in one piece.  A frame that cannot move carries its
 * weight. */
TEST(free_and_fixed)
{
    static const char flies[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'x', 'mass': 0, 'centre': [0, 0]},{'name': 'y', 'mass': 0, 'centre': [0, 0]}, {'name': 'b', "
        "'mass': 2, 'centre': [0.1, 0], 'inertia': 0.1}],'joints': [{'name': 'X', 'kind': 't', 'links': ['ground', 'x'], 'at': [0, 0], 'along': [1, "
        "0]},{'name': 'Y', 'kind': 't', 'links': ['x', 'y'], 'at': [0, 0], 'along': [0, 1]},{'name': 'R', 'links': ['y', 'b'], 'at': [0, 0]}], "
        "'inputs': [{'joint': 'X', 'speed': %g},{'joint': 'Y', 'speed': %g}, {'joint': 'R', 'speed': 3}], 'gravity': [0, -9.81],'tracers': [{'name': "
        "'P', 'link': 'b', 'at': [0.1, 0]}]}";
    static const char swings[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': %g, 'centre': [%g, 0], 'inertia': 0.1}%s],'joints': [{'name': 'A', 'links': "
        "['ground', 'a'], 'at': [0, 0]}%s], 'input': {'joint': 'A'},'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'a', 'at': [0.5, 0]}]}";
    static const char frame[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': %g, 'centre': [0.5, 0.5]},{'name': 'b', 'mass': %g, 'centre': [1.5, 0.5]}],"
        "'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]},{'name': 'B', 'links': ['a', 'b'], 'at': [1, 1]}, {'name': 'C', 'links': "
        "['b', 'ground'], 'at': [2, 0]}],'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'b', 'at': [1, 1]}]}";
    drun_read_format(&d, flies, 1, 2);
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-10, 1, 10), LW_OK);
        CHECK_INT(d.report.freedom, 3);
        for (int i = 0; i <= 10; i++) {
            double t = d.t[i], slack = f == 1 ? 1e-9 : 1e-6;
            CHECK_POINT(d.tracer[i], 0.1 + t, 2.3*t - 0.5*9.81*t*t, slack, 0);
        }
        CHECK_NEAR(d.q[8], 3, f == 1 ? 1e-9 : 1e-6, 0);
    }
    for (int f = 0; f < 4; f++) {
        char text[2000];
        double slack = f < 2 ? 1e-9 : 1e-6;
        snprintf(text, sizeof text, swings, 1.0, 0.5, ", {'name': 'b', 'mass': 1, 'centre': [1.5, 0], 'inertia': 0.15}",
                 ", {'name': 'W', 'kind': 'f', 'links': ['a', 'b'], 'at': [1, 0]}");
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, f ? all[f] : LW_FORMULATION_AUTO, 1e-10, 2, 10), LW_OK);
        /* together: 2 kg at 1, inertia 0.1 + 0.15 + 2 (0.5)^2 = 0.75; it is added to that of the text above */
        snprintf(text, sizeof text, swings, 2.0, 1.0, "", "");
        char *inertia = strstr(text, "0.1}");
        memmove(inertia + 4, inertia + 3, strlen(inertia + 3) + 1);
        memcpy(inertia, "0.75", 4);
        drun_read_format(&first, text, 0, 0);
        CHECK_INT(drun_to(&first, LW_FORMULATION_REDUCED, 1e-12, 2, 10), LW_OK);
        for (int i = 0; i <= 10; i++)
            CHECK_POINT(d.tracer[i], first.tracer[i].x, first.tracer[i].y, slack, 0);
    }
    drun_read_format(&d, frame, 1, 3);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 1, 2), LW_OK);
    CHECK_INT(d.report.freedom, 0);
    CHECK_NEAR(d.tracer[2].x, 1, 1e-12, 0);
    /* weights 1 and 3 at 0.5 and 1.5 of a span of 2: 1.5 and 2.5 g at its ends, in scaled coordinates */
    const double *l = d.l + 1, unit = d.system.unit;
    CHECK_NEAR(fabs(l[d.system.joint[0].row]), 1.5*9.81*unit, 1e-9, 0);
    CHECK_NEAR(fabs(l[d.system.joint[2].row]), 2.5*9.81*unit, 1e-9, 0);
}

/* ---- long runs and order ------------------------------------------------------------------------- */

/* Energy over 100 s, at the default tolerance and at a hundredth of it: kept to rounding at the ends of steps, with
 * corrections no larger than the errors of steps.  Samples lie between the ends, on a polynomial through each step
 * whose error falls with the eighth power of the step (integrate.h), as does the estimate that makes the steps so
 * long that it is the tolerance.  So energy is off by a few tolerances, 4.5 here. */
static void drift(lw_formulation f)
{
    double usual = lw_dynamics_options_default().relative;
    for (double tolerance = usual; tolerance > 0.001*usual; tolerance /= 100) {
        CHECK_INT(drun_to(&d, f, tolerance, 100, 1000), LW_OK);
        CHECK(d.report.energy_error < 1e-12*d.report.energy_scale);
        CHECK(d.report.energy_held > 0 && d.report.energy_held < 1000*tolerance*d.report.energy_scale);
        for (int i = 0; i <= 1000; i++)
            CHECK_NEAR(d.energy[i], d.energy[0], 10*tolerance*d.report.energy_scale, 0);
    }
}

static const char on_springs[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 1, 'centre': [0, 0]},{'name': 'bob', 'mass': 2, 'centre': [0.3, -1], 'inertia': "
    "0.2}],'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]},{'name': 'B', 'links': ['cart', 'bob'], "
    "'at': [0, 0]}], 'inputs': [{'joint': 'S', 'speed': %g}, {'joint': 'B'}],'gravity': [0, -9.81], 'springs': [{'joint': 'S', 'stiffness': %g},"
    "{'links': ['ground', 'bob'], 'at': [[2, -1], [0.3, -1.2]], 'stiffness': 15, 'free': 1}],'tracers': [{'name': 'P', 'link': 'bob', 'at': [0.3, "
    "-1]}]}";

TEST(long_runs)
{
    drun_read(&d, "examples/pendulum.json");
    drift(LW_FORMULATION_REDUCED);
    drift(LW_FORMULATION_INDEX1);
    drun_read_format(&d, double_pendulum, 1, 1);
    drift(LW_FORMULATION_AUTO);
    drun_read_format(&d, on_springs, 1, 40);
    drift(LW_FORMULATION_AUTO);
    drun_read(&d, "examples/two-four-bars.json");
    drift(LW_FORMULATION_REDUCED);
    drift(LW_FORMULATION_INDEX1);
    drun_read(&d, "examples/andrews.json");
    int forces = d.model.n_force;
    d.model.n_force = 0;                          /* its torque; the spring stays */
    CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-10, 2, 10), LW_OK);
    CHECK(d.report.energy_error < 1e-12*d.report.energy_scale && d.report.energy_held > 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 1, 10), LW_OK);
    CHECK(d.report.energy_error < 1e-12*d.report.energy_scale && d.report.energy_held > 0);
    d.model.n_force = forces;
}

/* Keeping the energy does not hide errors: those of place are a small multiple of the tolerance.  A01 at 10 s. */
TEST(kept_energy_is_no_mask)
{
    drun_read(&d, "examples/pendulum.json");
    for (int f = 0; f < 2; f++)
        for (int k = 5; k <= 11; k++) {
            CHECK_INT(drun_to(&d, all[f], pow(10, -k), 10, 1), LW_OK);
            CHECK_POINT(d.tracer[1], -0.2750874625761168600544, -0.9614192050991250642651, 30*pow(10, -k), 0);
        }
}

/* Slope of the line through n points, least squares. */
static double slope(int n, const double *x, const double *y)
{
    double mean = 0, top = 0, bottom = 0;
    for (int i = 0; i < n; i++)
        mean += x[i]/n;
    for (int i = 0; i < n; i++) {
        top += (x[i] - mean)*y[i];
        bottom += (x[i] - mean)*(x[i] - mean);
    }
    return top/bottom;
}

/* How errors of place fall with the tolerance and with the number of steps, as powers, from 1e-9 to 1e-13, of implicit methods from 1e-7 to 1e-10,
 * farther from rounding.  The error is the greatest of 30 samples: at a single one it may pass 0.
 * Explicit: an estimate that falls as h^8 is held at the tolerance, and so is the error: steps as its -1/8 power,
 * errors with the tolerance and with the 8th power of the steps.
 * Implicit: the error of a step, h^6 at order 5, is held at the 5/4 power of the tolerance; their sum, h^5, falls with the 5/6 power of that. */
TEST(order)
{
    enum { MOMENTS = 30, RUNS = 17 };
    double mass[2] = { 1, 1 }, y[4] = { 0 }, tolerance[RUNS], error[RUNS], steps[RUNS];
    lw_ode ode = { .n = 4, .context = mass, .rate = double_rate };
    lw_vec2 want[MOMENTS + 1];
    for (int i = 0; i <= MOMENTS; i++) {
        if (i > 0)
            drun_exact(&ode, 3.0*(i - 1)/MOMENTS, y, 3.0*i/MOMENTS);
        want[i] = lw_v2_add(lw_v2_polar(1, y[0]), lw_v2_polar(1, y[1]));
    }
    drun_read_format(&d, double_pendulum, 1, 1);
    for (int f = 1; f < 4; f++) {
        for (int k = 0; k < RUNS; k++) {
            double worst = 0;
            tolerance[k] = f == 1 ? -9 - 0.25*k : -7 - 0.1875*k;     /* looser, the implicit methods take lower orders */
            CHECK_INT(drun_to(&d, all[f], pow(10, tolerance[k]), 3, MOMENTS), LW_OK);
            for (int i = 1; i <= MOMENTS; i++)
                worst = fmax(worst, hypot(d.tracer[i].x - want[i].x, d.tracer[i].y - want[i].y));
            error[k] = log10(worst);
            steps[k] = log10((double)d.report.steps);
            CHECK(error[k] < tolerance[k] + (f == 1 ? 1 : 3));
        }
        if (f == 1) {
            CHECK_NEAR(slope(RUNS, tolerance, error), 1, 0.15, 0);
            CHECK_NEAR(slope(RUNS, tolerance, steps), -1/8.0, 0.01, 0);
            CHECK_NEAR(slope(RUNS, steps, error), -8, 0.8, 0);
        } else {
            CHECK_NEAR(slope(RUNS, tolerance, error), 5/6.0*5/4, 0.1, 0);
        }
    }
}

/* Stops, friction, redundant rows, masses and stiffnesses far apart: against closed solutions. */
#include "tests/dynamics_run.h"

static drun d, other;

static const lw_formulation all[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                      LW_FORMULATION_GGL };

/* ---- stops ------------------------------------------------------------------------------------- */

static const char falling[] = "{'linkwright': 1, 'links': ['ground', {'name': 'ball', 'mass': 2, 'centre': [0, 1]}],'joints': [{'name': 'S', 'kind': 't', "
    "'links': ['ground', 'ball'], 'at': [0, 1], 'along': [0, 1],'stop': {'least': -1, 'restitution': %.17g}}], 'input': {'joint': 'S'}, 'gravity': [0, "
    "%.17g],'tracers': [{'name': 'P', 'link': 'ball', 'at': [0, 1]}]}";

/* Height of a ball dropped from 1 at time t. */
static double bounced(double e, double g, double t)
{
    double fall = sqrt(2/g), speed = g*fall, since = fall;
    if (t <= fall)
        return 1 - 0.5*g*t*t;
    for (int k = 0; k < 200; k++) {
        speed *= e;
        double flight = 2*speed/g;
        if (t < since + flight)
            return speed*(t - since) - 0.5*g*(t - since)*(t - since);
        since += flight;
        if (flight < 1e-12)
            break;
    }
    return 0;
}

/* Dropped from 1: it falls for sqrt(2/g); each flight is e times as long as the one before; all end after (1 + e)/(1
 * - e) falls. */
TEST(bouncing)
{
    static const double restitution[] = { 0, 0.3, 0.5, 0.9, 1 };
    const double g = 9.81, fall = sqrt(2/g);
    for (int k = 0; k < 5; k++)
        for (int f = 1; f < 3; f++) {
            double e = restitution[k], t = fall, flight = 2*e*fall, slack = f == 1 ? 1e-12 : 1e-7;
            drun_read_format(&d, falling, e, -g);
            CHECK_INT(drun_to(&d, f == 1 ? LW_FORMULATION_AUTO : all[f], 1e-10, 3, 300), LW_OK);
            CHECK_INT(d.report.formulation, all[f]);
            CHECK(d.report.n_event > 0);
            for (int i = 0; i < d.report.n_event && (e == 1 || flight > (f == 1 ? 1e-6 : 1e-3)*fall); i++) {
                CHECK(d.report.event[i].impact && !d.report.event[i].greatest);
                CHECK_NEAR(d.report.event[i].t, t, slack*(i + 1), 0);
                CHECK_NEAR(d.report.event[i].speed, -g*fall*pow(e, i), 20*slack*(i + 1), 0);
                t += flight;
                flight *= e;
            }
            for (int i = 0; i <= 300; i++)
                CHECK_NEAR(d.tracer[i].y, bounced(e, g, d.t[i]), f == 1 ? 1e-9 : 1e-6, 0);
            if (e == 1) {
                CHECK_INT(d.report.n_event_seen, (int)((3/fall + 1)/2));
                CHECK(d.report.energy_error < (f == 1 ? 1e-10 : 1e-6)*d.report.energy_scale);
            } else if (e < 0.9) {
                CHECK_NEAR(d.v[1], 0, 1e-12, 0);
                CHECK_NEAR(d.a[1], 0, 1e-10, 0);
            }
            CHECK(d.report.energy_error < (f == 1 ? 1e-9 : 1e-5)*d.report.energy_scale);
        }
}

/* A mass of 1 resting on its stop is lifted by 5 t: it leaves when that is its weight, then rises by 5 s^3/6. */
TEST(leaves_a_stop)
{
    const double g = 9.81, off = g/5;
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'ball', 'mass': 1, 'centre': [0, 1]}],'joints': [{'name': 'S', 'kind': 't', "
        "'links': ['ground', 'ball'], 'at': [0, 1], 'along': [0, 1],'stop': {'least': 0}}], 'gravity': [0, -9.81], 'forces': [{'link': 'ball', 'at': [0, "
        "1],'fy': '5*t'}], 'tracers': [{'name': 'P', 'link': 'ball', 'at': [0, 1]}]}", 0, 0);
    for (int f = 1; f < 3; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-10, 3, 300), LW_OK);
        CHECK_INT(d.report.event[d.report.n_event - 1].impact, false);
        CHECK_NEAR(d.report.event[d.report.n_event - 1].t, off, f == 1 ? 1e-12 : 1e-6, 0);
        for (int i = 0; i <= 300; i++) {
            double s = fmax(0, d.t[i] - off);
            CHECK_NEAR(d.tracer[i].y, 1 + 5*s*s*s/6, f == 1 ? 1e-10 : 1e-6, 0);
        }
    }
}

/* A pendulum released level strikes a stop straight below: its speed is sqrt(2 g r), its next height e^2 of the
 * first; a compliant stop of high stiffness gives the energy back. */
TEST(pendulum_and_stop)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 1, 'centre': [-1, 0]}],"
        "'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at': [0, 0], 'stop': {'greatest': 1.5707963267948966,"
        "%s}}], 'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [-1, 0]}]}";
    char all_of_it[2000];
    snprintf(all_of_it, sizeof all_of_it, text, "'restitution': 0.7");
    drun_read_format(&d, all_of_it, 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-11, 2, 1000), LW_OK);
    double least = 0;
    for (int i = 0; i <= 1000; i++)
        least = d.t[i] > d.report.event[0].t ? fmin(least, -1 - d.tracer[i].y) : least;
    CHECK(d.report.event[0].greatest && d.report.event[0].impact);
    CHECK_NEAR(-d.report.event[0].speed, sqrt(2*9.81), 1e-9, 0);
    CHECK_NEAR(-least, 0.49, 1e-5, 0);
    snprintf(all_of_it, sizeof all_of_it, text, "'stiffness': 1e6");
    drun_read_format(&d, all_of_it, 0, 0);
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, all[f], 1e-11, 2, 1000), LW_OK);
        CHECK(d.report.energy_error < (f == 1 ? 1e-8 : 1e-5)*d.report.energy_scale);
        if (f > 1)
            CHECK_NEAR(d.tracer[1000].y, other.tracer[1000].y, 1e-5, 0);
        drun_keep_path(&other, &d);
    }
}

/* A five-bar with a heavy link whose joint bounces on its stop, rests and leaves, three times.  When it leaves, force and acceleration
 * pass 0, where rounding decides their signs: the stop held the joint until it pressed again, or was struck and left without end. */
TEST(leaves_at_rounding)
{
    static const char text[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1.1708440085774376, 'centre': [-0.13558758994303427, 0.38454020211557755], "
        "'inertia': 0.090610219576114}, {'name': 'b', 'mass': 0.9243288700235086, 'centre': [0.35287247759896667, 0.8767525649476808], 'inertia': "
        "0.07892615355784346}, {'name': 'c', 'mass': 251.06772139655345, 'centre': [0.858754387342009, 0.9653845128148961], 'inertia': "
        "21.815187385765512}, {'name': 'd', 'mass': 2.5891115256656594, 'centre': [1.1811005886596302, 0.3938158507092898], 'inertia': "
        "0.09880729671147104}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [-0.2, 0.6]}, "
        "{'name': 'C', 'links': ['b', 'c'], 'at': [0.6, 1.2], 'stop': {'least': -0.29201578986157845, 'greatest': 0.4350642069312127, 'restitution': "
        "0.5}}, {'name': 'D', 'links': ['c', 'd'], 'at': [1.3, 0.6]}, {'name': 'E', 'links': ['d', 'ground'], 'at': [1, 0]}], 'gravity': [0, -9.81], "
        "'tracers': [{'name': 'P', 'link': 'd', 'at': [1.2811005886596303, 0.3938158507092898]}], 'inputs': [{'joint': 'A', 'speed': 3.2805579759898205}, "
        "{'joint': 'B', 'speed': 1.513550568284554}], 'springs': [{'name': 'S', 'links': ['ground', 'd'], 'at': [[0.938685031167585, 1.8955170586199555], "
        "[1.1811005886596302, 0.3938158507092898]], 'stiffness': 2.772402612589362}, {'name': 'SJ', 'joint': 'E', 'law': "
        "'-10*sin(displacement)-rate*abs(rate)'}], 'forces': [{'link': 'd', 'at': [1.1811005886596302, 0.3938158507092898], 'fx': 'step(t,0.3,0,0.5,4)', "
        "'fy': '2*cos(3*t)-0.5*vy(P)*abs(vy(P))', 'torque': -1.4271000299051053, 'frame': 'plane'}, {'link': 'a', 'at': [-0.13558758994303427, "
        "0.38454020211557755], 'torque': '-10*integral(q(A)-0.3)'}]}";
    static const struct { lw_formulation f; double tolerance, off; } way[] = { { LW_FORMULATION_INDEX1, 1e-12, 1e-9 }, { LW_FORMULATION_INDEX1,
        1e-6, 1e-6 }, { LW_FORMULATION_INDEX1, 1e-8, 1e-7 }, { LW_FORMULATION_INDEX1, 1e-9, 1e-7 }, { LW_FORMULATION_INDEX1, 1e-10, 1e-8 },
        { LW_FORMULATION_AUTO, 1e-9, 1e-7 }, { LW_FORMULATION_CVODE, 1e-10, 1e-6 } };
    double turn = 0;
    drun_read_format(&d, text, 0, 0);
    for (int k = 0; k < 7; k++) {
        CHECK_INT(drun_to(&d, way[k].f, way[k].tolerance, 1, 1), LW_OK);
        turn = k ? turn : d.q[2];
        CHECK_NEAR(d.q[2], turn, way[k].off, 0);
    }
}

/* A mass of 1 is pressed on its stop by a state 1 - t: it leaves at t = 1, and then flies by (t - 1)^3/6.  The pressure at the stop
 * is that of the state at the time that is looked at, not at the last one of a step. */
TEST(pressed_by_a_state)
{
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0]}], 'joints': [{'name': 'S', 'kind': 't', "
        "'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0], 'stop': {'least': 0}}], 'input': {'joint': 'S', 'speed': 0}, 'states': [{'name': "
        "'u', 'rate': '-1', 'start': 1}], 'forces': [{'link': 'a', 'at': [0, 0], 'fx': '-state(u)'}], 'tracers': [{'name': 'P', 'link': 'a', "
        "'at': [0, 0]}]}", 0, 0);
    for (int f = 1; f < 3; f++)
        for (int n = 1; n <= 7; n += 2) {
            CHECK_INT(drun_to(&d, all[f], 1e-10, 2, n), LW_OK);
            CHECK_INT(d.report.n_event_seen, 2);                     /* rests at the start, leaves */
            CHECK_NEAR(d.report.event[1].t, 1, f == 1 ? 1e-12 : 1e-8, 0);
            CHECK_NEAR(d.tracer[n].x, 1.0/6, f == 1 ? 1e-10 : 1e-8, 0);
        }
}

/* A mass at 1 m/s meets a spring and damper at 0.5 m: z'' + c z' + k z = 0 from there until the force is 0, then it flies back.  The
 * damper makes the force jump.  Beside it a mass is pushed by a state that counts the time: x'' = t, so that no time is lost there. */
TEST(damped_stop)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 1}, {'name': 'b', "
        "'mass': 1, 'centre': [0, 1], 'inertia': 1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0], "
        "'stop': {'greatest': 0.5, 'stiffness': 2000, 'damping': 40}}, {'name': 'B', 'kind': 't', 'links': ['ground', 'b'], 'at': [0, 1], 'along': "
        "[1, 0]}], 'inputs': [{'joint': 'S', 'speed': 1}, {'joint': 'B', 'speed': 0}], 'states': [{'name': 'clock', 'rate': '1', 'start': 0}], "
        "'forces': [{'link': 'b', 'at': [0, 1], 'fx': 'state(clock)'}], 'tracers': [{'name': 'P', 'link': 'a', 'at': [0, 0]}]}";
    static const lw_formulation each[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL, LW_FORMULATION_RADAU };
    const double b = 20, w = sqrt(2000 - b*b), end = atan2(2*b*w, b*b - w*w)/w;       /* z'' = 0: tan(w t) = 2 b w/(b^2 - w^2) */
    const double z = exp(-b*end)*sin(w*end)/w, speed = exp(-b*end)*(cos(w*end) - b/w*sin(w*end));
    CHECK_NEAR(2000*z + 40*speed, 0, 1e-9, 0);
    for (int f = 0; f < 4; f++)
        for (int k = 0; k < 6; k++) {
            double tolerance = pow(10, -6 - 2*(k%3)), to = 1, off = (f == 1 || f == 2 ? 300 : 100)*tolerance + 1e-10;     /* BDF */
            drun_read_format(&d, text, 0, 0);
            CHECK_INT(drun_to(&d, each[f], tolerance, to, k < 3 ? 40 : 1), LW_OK);
            CHECK_NEAR(d.v[0]*d.system.unit, speed, off, 0);
            CHECK_NEAR(d.v[3]*d.system.unit, 0.5, off, 0);
            CHECK(d.report.energy_error < 10*off);
            CHECK_NEAR(d.tracer[d.n_moment - 1].x, 0.5 + z + speed*(to - 0.5 - end), off, 0);
        }
}

/* A brake on one of two masses closes at 0.2 s, decay 1e5/s, which index1 would follow in steps of 6e-5 s: it goes on by an implicit method.  The
 * other mass swings on, with 10 rad/s. */
TEST(stiff_on_the_way)
{
    double v = 0;
    for (int k = 0; k < 2; k++) {
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 1}, {'name': 'b', 'mass': 1, 'centre': "
            "[0, 1], 'inertia': 1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0]}, {'name': 'B', 'kind': 't', "
            "'links': ['ground', 'b'], 'at': [0, 1], 'along': [1, 0]}], 'inputs': [{'joint': 'S', 'speed': 1}, {'joint': 'B', 'speed': 1}], 'forces': [{'link': "
            "'a', 'at': [0, 0], 'fx': '1e5*step(t, 0.2, 0, 0.3, 1)*(sin(t) - v(S))'}, {'link': 'b', 'at': [0, 1], 'fx': '-100*x(P)'}], 'tracers': [{'name': 'P', "
            "'link': 'b', 'at': [0, 1]}]}", 0, 0);
        CHECK_INT(drun_to(&d, k ? LW_FORMULATION_AUTO : LW_FORMULATION_RADAU, k ? 1e-7 : 1e-9, 2, 1), LW_OK);
        CHECK_NEAR(d.tracer[1].x, sin(20)/10, k ? 1e-5 : 1e-8, 0);
        if (k) {
            CHECK_INT(d.report.formulation, LW_FORMULATION_RADAU);
            CHECK(d.report.rates < 4000);
            CHECK_NEAR(d.v[0], v, 1e-6, 0);
        }
        v = d.v[0];
    }
}

/* The errors of the steps of BDF methods add up to the same multiple of each tolerance: a slightly damped four-bar near a dead point. */
TEST(many_steps)
{
    double turn = 0;
    drun_read_format(&d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 9.888, 'centre': [-0.0294, 0.2158], 'inertia': "
        "0.095641}, {'name': 'b', 'mass': 0.117, 'centre': [0.0163, -0.2714], 'inertia': 0.021939}, {'name': 'c', 'mass': 8.015, 'centre': [0.6434, "
        "-0.6642], 'inertia': 0.565142}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': "
        "[-0.0956, 0.3738]}, {'name': 'C', 'links': ['b', 'c'], 'at': [0.2189, -0.9153]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1.1268, "
        "-0.2584]}], 'dampers': [{'joint': 'A', 'damping': 0.0236}, {'joint': 'B', 'damping': 0.0266}, {'joint': 'C', 'damping': 0.0203}, {'joint': 'D', "
        "'damping': 0.0245}], 'forces': [{'link': 'c', 'at': [0.2189, -0.9153], 'fx': '1.33426*sin(7.92708*t)'}]}", 0, 0);
    for (int k = 0; k < 7; k++) {
        double tolerance = k ? pow(10, -4 - 2*((k + 1)/2)) : 1e-12;
        CHECK_INT(drun_to(&d, !k ? LW_FORMULATION_INDEX1 : k%2 ? LW_FORMULATION_CVODE : LW_FORMULATION_GGL, tolerance, 1.6, 1), LW_OK);
        turn = k ? turn : d.q[2];
        CHECK_NEAR(d.q[2], turn, 100*tolerance, 0);
    }
}

/* Links of 47 t, 380, 15 and 6e-4 kg: pivots of the rows are small by the masses alone, and the posture is not singular.  Reference: ggl. */
TEST(masses_far_apart)
{
    double turn = 0;
    drun_read_format(&d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 46642.192135274316, 'centre': [0.2581, "
        "-0.0169], 'inertia': 1047.5874742218111}, {'name': 'b', 'mass': 379.7347527849832, 'centre': [0.9047, 0.5216], 'inertia': 35.85663976777318}, "
        "{'name': 'c', 'mass': 15.457733785158355, 'centre': [1.2106, 0.4803], 'inertia': 1.1983698180086213}, {'name': 'd', 'mass': "
        "0.0006256270012325914, 'centre': [1.1112, 0.0286], 'inertia': 1.5512089511129462e-06}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': "
        "[0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.4708, -0.0503]}, {'name': 'C', 'links': ['b', 'c'], 'at': [1.3237, 0.9051]}, {'name': 'D', "
        "'links': ['c', 'd'], 'at': [1.0442, -0.0649]}, {'name': 'E', 'links': ['ground', 'd'], 'at': [1.176, 0.1124]}]}", 0, 0);
    for (int k = 0; k < 3; k++) {
        double tolerance = k == 1 ? 1e-8 : 1e-10;
        CHECK_INT(drun_to(&d, k ? LW_FORMULATION_AUTO : LW_FORMULATION_GGL, tolerance, 3, 1), LW_OK);
        CHECK_INT(d.report.formulation, k ? LW_FORMULATION_INDEX1 : LW_FORMULATION_GGL);
        turn = k ? turn : d.q[11];
        CHECK_NEAR(d.q[11], turn, 1000*tolerance + 1e-6, 0);
    }
}

/* A spring turns a heavy rocker, and a crank and rod of next to no mass follow, with a damper at the crank: in the coordinates of the bodies as in one,
 * and in no more steps.  Rounding of forces over the masses of the light links took 1e7 of them. */
TEST(light_links_carry_forces)
{
    for (int k = 0; k < 2; k++)
        drun_read_format(k ? &other : &d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1e-11, 'centre': [0.1, 0], "
            "'inertia': "
            "1e-13}, {'name': 'b', 'mass': 1e-11, 'centre': [0.35, 0.25], 'inertia': 1e-13}, {'name': 'c', 'mass': 2, 'centre': [0.55, 0.2], 'inertia': 0.05}], "
            "'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.2, 0]}, {'name': 'C', 'links': ['b', "
            "'c'], 'at': [0.5, 0.4]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [0.6, 0]}], 'input': {'joint': 'D', 'speed': 0.5}, 'springs': [{'joint': 'D', "
            "'stiffness': 30}], 'dampers': [{'joint': 'A', 'damping': 0.1}]}", 0, 0);
    for (double tolerance = 1e-8; tolerance > 0.5e-12; tolerance *= 0.01) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, tolerance, 2, 10), LW_OK);
        CHECK_INT(drun_to(&other, LW_FORMULATION_REDUCED, 1e-12, 2, 10), LW_OK);
        for (int i = 0; i < 9; i++)
            CHECK_NEAR(d.q[i], other.q[i], 10*tolerance, 0);
        CHECK(d.report.rates < 3*other.report.rates);
    }
}

/* The same slider-crank in four sizes, from 100 um and 1e-12 kg to 100 km and 1e9 kg: scaled to one size the motions agree, and so does their accuracy. */
TEST(tiny_and_huge)
{
    static const struct { const char *unit; double metre, mass; } size[] = { { "m", 1, 1 }, { "um", 1e-6, 1e-12 }, { "mm", 1e-3, 1e-6 }, { "km", 1e3, 1e9 } };
    char text[2000];
    for (int f = 0; f < 4; f++)
        for (int k = 0; k < 4; k++) {
            double m = size[k].mass, l = 100*size[k].metre, turn = m*l*l/12;
            json_format(text, sizeof text, "{'linkwright': 1, 'units': {'length': '%s'}, 'links': ['ground', {'name': 'crank', 'mass': %.17g, 'centre': [50, 0], "
                "'inertia': %.17g}, {'name': 'rod', 'mass': %.17g, 'centre': [100, -50], 'inertia': %.17g}, {'name': 'block', 'mass': %.17g, 'centre': [100, "
                "-100], 'inertia': %.17g}], 'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]}, {'name': 'B', 'links': ['crank', 'rod'], 'at': "
                "[100, 0]}, {'name': 'C', 'links': ['rod', 'block'], 'at': [100, -100]}, {'name': 'D', 'kind': 't', 'links': ['ground', 'block'], 'at': [100, "
                "-100], 'along': [1, 0.3]}], 'input': {'joint': 'A'}, 'gravity': [0, %.17g], 'springs': [{'links': ['ground', 'block'], 'at': [[0, -100], [100, "
                "-100]], 'stiffness': %.17g, 'damping': %.17g}], 'tracers': [{'name': 'P', 'link': 'crank', 'at': [100, 0]}]}", size[k].unit, m, turn, m, turn,
                2*m, turn, -9.81*l, 9*m, 0.1*m);
            drun_read_json(&d, text);
            CHECK_INT(drun_to(&d, all[f], 1e-10, 5, 20), LW_OK);
            CHECK_INT(d.report.formulation, all[f]);
            if (k == 0)
                drun_keep_path(&other, &d);
            for (int i = 0; i <= 20; i++)
                CHECK_NEAR(d.tracer[i].x/size[k].metre, other.tracer[i].x, 100*100*1e-10, 0);
        }
}

/* Two inputs stretch a five-bar that carries a pendulum: the run ends at the limit, in few steps. */
TEST(inputs_to_a_limit)
{
    const double arm = hypot(0.2, 0.4), from = acos(-0.2/arm), limit = acos((0.8 - 2*hypot(0.6, 0.5))/(2*arm)) - from;
    drun_read_format(&d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [-0.1, 0.2], 'inertia': 0.01}, "
        "{'name': 'b', 'mass': 1, 'centre': [0.1, 0.7], 'inertia': 0.02}, {'name': 'c', 'mass': 1, 'centre': [0.7, 0.7], 'inertia': 0.02}, {'name': 'd', "
        "'mass': 1, 'centre': [1, 0.2], 'inertia': 0.01}, {'name': 'e', 'mass': 1, 'centre': [0.4, 0.5], 'inertia': 0.02}], 'joints': [{'name': 'A', "
        "'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [-0.2, 0.4]}, {'name': 'C', 'links': ['b', 'c'], 'at': [0.4, "
        "0.9]}, {'name': 'D', 'links': ['c', 'd'], 'at': [1, 0.4]}, {'name': 'E', 'links': ['ground', 'd'], 'at': [0.8, 0]}, {'name': 'F', 'links': ['b', "
        "'e'], 'at': [0.4, 0.9]}], 'inputs': [{'joint': 'A', 'motion': '%.17g + t'}, {'joint': 'E', 'motion': '%.17g - t'}]}", from, acos(0.2/arm));
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-10, 2, 20), LW_E_NUMERIC);
    CHECK_NEAR(d.report.t, limit, 1e-4, 0);
    CHECK(strstr(d.e.text, "end of its way") != NULL);
    CHECK(d.report.steps < 8000);
}

/* ---- sign() in forces of the user's own ---------------------------------------------------------- */

/* A mass of 1 at this speed on a guide; joint: the end of its text, and what follows. */
static void read_guide(const char *joint, const char *force, double speed)
{
    char text[1000];
    json_format(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 1}], 'joints': [{'name': "
                "'S', 'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0]%s, 'input': {'joint': 'S', 'speed': %g}, 'forces': [{'link': 'a', 'at': "
                "[0, 0], 'fx': '%s'}], 'tracers': [{'name': 'P', 'link': 'a', 'at': [0, 0]}]}", joint, speed, force);
    drun_read_text(&d, text);
}

static void read_sign(const char *force, double speed) { read_guide("}]", force, speed); }

/* Where the motion crosses the jump, every formulation goes on: under -5 sign(x) arcs of 0.4 s follow each other, so that x = 0 and
 * v = -1 at 2 s; -5 sign(v) v^2 does not jump at all, v = 1/(1 + 5 t), and comes to rest beside a strong damper. */
TEST(sign_is_crossed)
{
    static const lw_formulation each[] = { LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL,
                                           LW_FORMULATION_RADAU };
    for (int f = 0; f < 5; f++)
        for (double tolerance = 1e-6; tolerance > 1e-11; tolerance *= 1e-2) {
            double off = (f < 2 ? 3 : 30)*tolerance;
            read_sign("-5*sign(x(P))", 1);
            CHECK_INT(drun_to(&d, each[f], tolerance, 2, 4), LW_OK);
            CHECK_NEAR(d.tracer[4].x, 0, off, 0);
            CHECK_NEAR(d.v[0]*d.system.unit, -1, off, 0);
            read_sign("-5*sign(v(S))*v(S)^2", 1);
            CHECK_INT(drun_to(&d, each[f], tolerance, 2, 4), LW_OK);
            CHECK_NEAR(d.tracer[4].x, log(11)/5, off, 0);
            read_sign("-5*sign(v(S))*v(S)^2 - 1e4*v(S)", 1);
            CHECK_INT(drun_to(&d, each[f], tolerance, 0.2, 4), LW_OK);
            CHECK_NEAR(d.tracer[4].x, log(1 + 5e-4)/5, off, 0);
        }
}

/* A mass between two buffers with a clearance, 1 m/s: forces, compliant stops or a spring with a law.  Harmonic arcs of 10 and 5 rad/s with even
 * motion between them.  Steps end at the kinks of the force; BDF methods begin there at first order. */
TEST(kinks_are_seen)
{
    static const struct { lw_formulation f; double times; } each[] = { { LW_FORMULATION_RADAU, 10 }, { LW_FORMULATION_AUTO, 10 },
        { LW_FORMULATION_INDEX1, 10 }, { LW_FORMULATION_CVODE, 300 }, { LW_FORMULATION_GGL, 300 }, { LW_FORMULATION_ALPHA, 2000 } };
    static const char *more[] = { "}]", "}]", ", 'stop': {'least': -0.4, 'greatest': 0.3, 'stiffness': 100}}]",
                                  "}], 'springs': [{'joint': 'S', 'law': '-100*max(0, displacement - 0.3) - 25*min(0, displacement + 0.4)'}]" };
    static const char *force[] = { "-100*max(0, q(S) - 0.3) - 25*min(0, q(S) + 0.4)", "-50*(abs(x(P) - 0.3) + x(P) - 0.3) + 12.5*(abs(x(P) + 0.4) - x(P) - 0.4)",
                                   "75*min(0, q(S) + 0.4)", "0" };
    const double soft = LW_PI/5, hard = LW_PI/10, period = soft + hard + 2*0.7;
    for (int k = 0; k < 4; k++)
        for (int f = 0; f < 6; f++)
            for (double tolerance = f == 5 ? 1e-5 : 1e-6; tolerance > (f < 3 ? 1e-11 : k > 0 ? 1e-7 : 1e-9); tolerance *= 1e-2) {
                double t = fmod(10 - 0.3, period);       /* since it first left the clearance */
                double x = t < hard ? 0.3 + sin(10*t)/10 : t < hard + 0.7 ? 0.3 - (t - hard)
                         : t < hard + 0.7 + soft ? -0.4 - sin(5*(t - hard - 0.7))/5 : -0.4 + (t - hard - 0.7 - soft);
                read_guide(more[k], force[k], 1);
                CHECK_INT(drun_to(&d, each[f].f, tolerance, 10, 4), LW_OK);
                CHECK_NEAR(d.tracer[4].x, x, each[f].times*tolerance, 0);
            }
}

/* A mass at 1 m/s passes a detent of 1 mm on a way of 3 m and loses 0.2 J of 0.5 J, by a smooth bump and by one with kinks.  Only steps that are made
 * shorter for its sake see it. */
TEST(detents_are_seen)
{
    static const struct { lw_formulation f; double tolerance; int most; } each[] = {
        { LW_FORMULATION_REDUCED, 1e-7, 100 }, { LW_FORMULATION_INDEX1, 1e-7, 100 }, { LW_FORMULATION_CVODE, 1e-7, 1000 },
        { LW_FORMULATION_GGL, 1e-7, 1000 }, { LW_FORMULATION_RADAU, 1e-7, 600 }, { LW_FORMULATION_ALPHA, 1e-5, 600 } };
    static const char *force[] = { "-112.83791670955126*exp(-((x(P) - 0.7)/1e-3)^2)", "-200*max(0, 1 - abs(q(S) - 0.7)/1e-3)" };
    for (int k = 0; k < 2; k++)
        for (int f = 0; f < 6; f++) {
            read_sign(force[k], 1);
            CHECK_INT(drun_to(&d, each[f].f, each[f].tolerance, 3, 1), LW_OK);
            CHECK_NEAR(d.v[0]*d.system.unit, sqrt(0.6), (k ? 3000 : 30)*each[f].tolerance, 0);
            CHECK(d.report.steps < each[f].most);
        }
}

/* The law of a spring, too: with a spring that pushes for 1 mm, a mass of 1 kg at 1 m/s loses 0.2 J of 0.5 J; a law without detents is for quadrature. */
TEST(detents_of_springs_are_seen)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [1, 0], 'inertia': 1}], 'joints': [{'name': 'S', 'kind': 't', "
        "'links': ['ground', 'a'], 'at': [1, 0], 'along': [1, 0]}], 'input': {'joint': 'S', 'speed': 1}, 'springs': [{'links': ['ground', 'a'], "
        "'at': [[0, 0], [1, 0]], 'law': '%s'}]}";
    char all_text[1000];
    json_format(all_text, sizeof all_text, text, "112.83791670955126*exp(-((length - 1.7)/1e-3)^2)");
    drun_read_text(&d, all_text);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 3, 1), LW_OK);
    CHECK_INT(d.report.formulation, LW_FORMULATION_REDUCED);
    CHECK_NEAR(d.v[0]*d.system.unit, sqrt(0.6), 1e-7, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_QUADRATURE, 1e-9, 3, 1), LW_E_KIND);
    json_format(all_text, sizeof all_text, text, "100*(length - 1) + 30*(length - 1)^3");
    drun_read_text(&d, all_text);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 3, 1), LW_OK);
    CHECK_INT(d.report.formulation, LW_FORMULATION_QUADRATURE);
}

/* A crosshead keeps its angle, but for rounding, and so stays on the kink of abs() there: that is no event at each step. */
TEST(motion_rests_on_a_kink)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.5, 0], 'inertia': 0.1}, {'name': 'b', 'mass': 1, 'centre': "
        "[1.5, 0.2], 'inertia': 0.1}, {'name': 'c', 'mass': 1, 'centre': [2, 0], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, "
        "{'name': 'B', 'links': ['a', 'b'], 'at': [1, 0.3]}, {'name': 'C', 'links': ['b', 'c'], 'at': [2, 0.1]}, {'name': 'S', 'kind': 't', 'links': ['ground', 'c'], "
        "'at': [2, 0.1], 'along': [1, 0.3]}], 'input': {'joint': 'A', 'speed': 1}, 'forces': [{'link': 'c', 'torque': '700*abs(sin(3*angle(c)))'}]}";
    char all_text[1200];
    for (int f = LW_FORMULATION_RADAU; f <= LW_FORMULATION_GGL; f++)
        if (f == LW_FORMULATION_RADAU || f >= LW_FORMULATION_INDEX1) {
            json_format(all_text, sizeof all_text, "%s", text);
            drun_read_text(&d, all_text);
            d.o.max_step = 20000;
            CHECK_INT(drun_to(&d, (lw_formulation)f, 1e-6, 1, 1), LW_OK);
            CHECK(d.report.steps < 300);
        }
}

/* Where it slides along the jump, none answers: a mass that friction of its own stops, that a force cannot move, a sliding mode. */
TEST(sign_that_holds_is_an_error)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_REDUCED, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                           LW_FORMULATION_GGL, LW_FORMULATION_RADAU, LW_FORMULATION_ALPHA };
    static const struct { const char *force; double speed; } known[] = { { "8*sin(3*t) - 5*sign(v(S))", 0 }, { "4*sin(3*t) - 5*sign(v(S))", 0 },
                                                                         { "-5*sign(v(S) + 2*q(S))", 1 }, { "-2.5*sign(v(S))", 1 },
                                                                         { "-2.5*sign(v(S)) + 3*max(0, t - 1)", 1 } };
    for (int k = 0; k < 5; k++)
        for (int f = 0; f < 7; f++)
            for (int digits = 8; digits < 14; digits += 2) {
                double tolerance = pow(10, each[f] == LW_FORMULATION_ALPHA ? 5 - digits : -digits);      /* of second order */
                read_sign(known[k].force, known[k].speed);
                d.o.max_step = 200000;
                CHECK_INT(drun_to(&d, each[f], tolerance, 2, 4), LW_E_NUMERIC);
                CHECK(each[f] == LW_FORMULATION_GGL || strstr(d.e.text, "slides along the jump"));
                CHECK(d.report.steps < 200000);
            }
}

/* So it is where the force does not jump, but the rate of a state behind it: a relay that switches on a line and acts behind a lag comes to rest on it by ever
 * shorter switchings. */
TEST(relay_behind_a_lag)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL, LW_FORMULATION_RADAU,
                                           LW_FORMULATION_ALPHA };
    for (int f = 0; f < 6; f++)
        for (int digits = 6; digits < 10; digits += 2) {
            read_sign("-4*lag(sign(q(S) + 0.1*v(S)), 0.005, 1)", 1);
            d.o.max_step = 200000;
            CHECK_INT(drun_to(&d, each[f], pow(10, -digits), 4, 4), LW_E_NUMERIC);
            CHECK(strstr(d.e.text, "slides along the jump"));
            CHECK_NEAR(d.report.t, 0.675, 0.02, 0);              /* each tells when a switching takes about 1e-5 s */
        }
}

/* A mass thrown against a force c/(1 + q)^1.5 turns back before -1; trial steps lie behind, where the force is not a number.  A force that
 * falls to 0 and ends there with its root, before which the mass does not turn, ends the run. */
TEST(forces_without_a_value_behind_the_motion)
{
    static const char *force[] = { "1e-4/(1 + q(S))^1.5", "0.1*sqrt(1 + q(S))" };
    for (int f = 0; f < 2; f++)
        for (int root = 0; root < 2; root++) {
            read_sign(force[root], -3);
            CHECK_INT(drun_to(&d, all[f], 1e-4, 1, 1), root ? LW_E_NUMERIC : LW_OK);
            if (root)
                CHECK(fabs(d.report.t - 1/3.0) < 0.01 && strstr(d.e.text, "is not a number"));
            else
                CHECK_NEAR(d.v[0]*d.system.unit, 3, 1e-3, 0);
        }
}

/* Springs at the pins of a four-bar whose crank turns five times, while the coupler goes to and fro: those at the crank are wound up. */
TEST(springs_at_pins_count_turns)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1, 'inertia': 0.1, 'centre': [0, 0.5]}, {'name': 'coupler', "
        "'mass': 2, 'inertia': 1, 'centre': [1.25, 1.5]}, {'name': 'rocker', 'mass': 1, 'inertia': 0.5, 'centre': [2.5, 1]}], 'joints': [{'name': 'A', 'links': "
        "['ground', 'crank'], 'at': [0, 0]}, {'name': 'B', 'links': ['%s'], 'at': [0, 1]}, {'name': 'C', 'links': ['coupler', 'rocker'], 'at': [2.5, 2]}, "
        "{'name': 'D', 'links': ['rocker', 'ground'], 'at': [2.5, 0]}], 'input': {'joint': 'A', 'speed': 20}, 'springs': [{'joint': 'B', 'stiffness': 0.2}, "
        "{'joint': 'C', 'stiffness': 3}, {'joint': 'D', 'stiffness': 2, 'damping': 0.1}], 'tracers': [{'name': 'P', 'link': 'crank', 'at': [0, 1]}]}";
    static const char *const links[] = { "crank', 'coupler", "coupler', 'crank" };
    for (int i = 0; i < 2; i++) {
        char model[sizeof text + 32];
        snprintf(model, sizeof model, text, links[i]);
        drun_read_text(&d, model);
        drun_read_text(&other, model);
        CHECK_INT(drun_to(&d, LW_FORMULATION_REDUCED, 1e-10, 2, 20), LW_OK);
        CHECK_INT(drun_to(&other, LW_FORMULATION_INDEX1, 1e-10, 2, 20), LW_OK);
        CHECK(other.q[2] > 10*LW_PI);
        for (int k = 0; k <= 20; k++) {
            CHECK_NEAR(d.tracer[k].x, other.tracer[k].x, 1e-7, 0);
            CHECK_NEAR(d.tracer[k].y, other.tracer[k].y, 1e-7, 0);
        }
    }
}

/* ---- friction ---------------------------------------------------------------------------------- */

static const char incline[] = "{'linkwright': 1, 'links': ['ground', {'name': 'block', 'mass': 3, 'centre': [0, 0]}],'joints': [{'name': 'S', 'kind': "
    "'t', 'links': ['ground', 'block'], 'at': [0, 0], 'along': [1, 0],'friction': {'coefficient': 0.25}}], 'input': {'joint': 'S', 'speed': %.17g}, "
    "'gravity': [%.17g, -8],'tracers': [{'name': 'P', 'link': 'block', 'at': [0, 0]}]}";

/* Down a slope: 5 - 0.25*8 = 3.  On the level it stops after (v^2/2 + pi^2 s^2/12)/(mu g), with s the speed of
 * regularisation.  On a slope too flat to slide it creeps at s artanh(load/friction). */
TEST(sliding)
{
    static const double slack[] = { 0, 1e-9, 1e-6, 1e-5 };
    for (int f = 1; f < 4; f++) {
        drun_read_format(&d, incline, 1, 5);
        CHECK_INT(drun_to(&d, all[f], 1e-10, 2, 20), LW_OK);
        CHECK_NEAR(d.tracer[20].x, 2 + 0.5*3*4, slack[f], 0);
        CHECK(d.report.energy_error < 10*slack[f]*d.report.energy_scale);
        drun_read_format(&d, incline, 1, 0);
        d.model.friction[0].speed = 1e-3;
        CHECK_INT(drun_to(&d, f == 1 ? LW_FORMULATION_AUTO : all[f], 1e-10, 2, 20), LW_OK);
        CHECK_NEAR(d.tracer[20].x, (0.5 + LW_PI*LW_PI*1e-6/12)/2, slack[f == 1 ? 2 : f], 0);
        CHECK_NEAR(d.v[0], 0, 1e-6, 0);
    }
    drun_read_format(&d, incline, 1, -1);
    d.model.friction[0].speed = 1e-3;
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 2, 20), LW_OK);
    CHECK_NEAR(d.v[0], -1e-3*atanh(0.5), 1e-8, 0);
}

/* A wheel on a pin of radius 0.02: torque mu r m g slows it evenly. */
TEST(wheel_on_pin)
{
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'wheel', 'mass': 4, 'centre': [0, 0],'inertia': 0.05}], 'joints': [{'name': 'A', "
        "'links': ['ground', 'wheel'], 'at': [0, 0],'friction': {'coefficient': 0.3, 'radius': 0.02}}], 'input': {'joint': 'A', 'speed': 20},'gravity': "
        "[0, -9.81]}", 0, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-10, 3, 3), LW_OK);
    CHECK_NEAR(d.v[2], 20 - 3*0.3*0.02*4*9.81/0.05, 1e-7, 0);
    CHECK(d.report.energy_error < 1e-6*d.report.energy_scale);
}

/* A block pushed by a rod at 45 degrees presses as much as it is pushed.  With a coefficient above 1 the rod cannot
 * overcome the friction it causes: refused with the name of the joint; below 1 it runs. */
TEST(painleve)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1,'centre': [0, 0.5],'inertia': 0.1}, {'name': 'rod', "
    "'mass': 0, 'centre': [0.5, 0.5]}, {'name': 'block', 'mass': %.17g,'centre': [1, 0]}],'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': "
    "[0, 0]},{'name': 'B', 'links': ['crank', 'rod'], 'at': [0, 1]}, {'name': 'C', 'links': ['rod', 'block'],'at': [1, 0]},{'name': 'D', 'kind': 't', "
    "'links': ['ground', 'block'], 'at': [1, 0], 'along': [1, 0],'friction': {'coefficient': %.17g}}], 'input': {'joint': 'A', 'speed': -1},'tracers': "
    "[{'name': 'P', 'link': 'block', 'at': [1, 0]}]}";
    for (int f = 1; f < 4; f++) {
        drun_read_format(&d, text, 1, 0.5);
        CHECK_INT(drun_to(&d, all[f], 1e-9, 0.3, 3), LW_OK);
        CHECK(d.report.energy_error < 1e-4*d.report.energy_scale);
        if (f > 1)
            CHECK_NEAR(d.tracer[3].x, other.tracer[3].x, 1e-6, 0);
        drun_keep_path(&other, &d);
    }
    drun_read_format(&d, text, 1, 8);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-9, 0.3, 3), LW_E_NUMERIC);
    CHECK_HAS(d.e.text, "\"D\"");
    CHECK_HAS(d.e.text, "Painleve");
}

/* ---- more rows than needed --------------------------------------------------------------------- */

#define PINS(n, x, crank) "{'name': 'A" n "', 'links': ['ground', '" crank "'], 'at': [" x ", 0]}," \
                          "{'name': 'B" n "', 'links': ['" crank "', 'coupler'], 'at': [" x ".6, 0.8]}"

static const char parallel_two[] = "{'linkwright': 1, 'links': ['ground', {'name': 'c0', 'mass': 1,'centre': [0.3, 0.4]},{'name': 'c1', 'mass': 1, "
    "'centre': [1.3, 0.4]}, {'name': 'coupler', 'mass': 2, 'centre': [1.1, 0.8],'inertia': 1}],'joints': "
    "[" PINS("0", "0", "c0") "," PINS("1", "1", "c1") "], 'input': {'joint': 'A0', 'speed': 0.3},"
    "'gravity': [0, -9.81], 'tracers': [{'name': 'P', 'link': 'c0', 'at': [0.6, 0.8]}]}";
static const char parallel_three[] = "{'linkwright': 1, 'links': ['ground', {'name': 'c0', 'mass': 1,'centre': [0.3, 0.4]},{'name': 'c1', 'mass': 1, "
    "'centre': [1.3, 0.4]}, {'name': 'coupler', 'mass': 2, 'centre': [1.1, 0.8],'inertia': 1},{'name': 'c2', 'mass': %.17g, 'centre': [2.3, 0.4]}],"
    "'joints': [" PINS("0", "0", "c0") "," PINS("1", "1", "c1") "," PINS("2", "2", "c2") "],'input': {'joint': 'A0', 'speed': 0.3},'gravity': [0, -9.81], "
    "'tracers': [{'name': 'P', 'link': 'c0', 'at': [0.6, 0.8]}]}";

static void names_of_redundant(drun *r, char *text, size_t size)
{
    lw_dynamics *m;
    CHECK_INT(lw_dynamics_make(&r->model, &r->o, &m, &r->e), LW_OK);
    lw_dynamics_redundant(m, text, size);
    lw_dynamics_free(m);
}

/* A third crank makes one row redundant.  A massless one changes nothing; with mass, the equation of the angle is
 * (3/4 + 2) phi'' = -(3/2 + 2) g cos phi, that of a pendulum of length 5.5/7. */
TEST(parallelogram)
{
    char names[200];
    drun_read_format(&other, parallel_two, 0, 0);
    CHECK_INT(drun_to(&other, LW_FORMULATION_INDEX1, 1e-12, 1, 100), LW_OK);
    CHECK_INT(other.report.redundant, 0);
    names_of_redundant(&other, names, sizeof names);
    CHECK_TEXT(names, "");
    drun_read_format(&d, parallel_three, 0, 0);
    names_of_redundant(&d, names, sizeof names);
    CHECK_TEXT(names, " A0 B0 A1 B1 A2 B2");
    /* at 0.5 s it lies flat, a singular posture that implicit methods do not always pass */
    for (int f = 1; f < 4; f++) {
        CHECK_INT(drun_to(&d, f == 1 ? LW_FORMULATION_AUTO : all[f], f == 1 ? 1e-12 : 1e-9, f == 1 ? 1 : 0.4,
                          f == 1 ? 100 : 40), LW_OK);
        CHECK_INT(d.report.redundant, 1);
        CHECK_INT(d.report.freedom, 1);
        CHECK(!d.unique);
        for (int i = 0; i < d.n_moment; i++)
            CHECK_NEAR(d.tracer[i].y, other.tracer[i].y, f == 1 ? 1e-9 : 1e-5, 0);
    }
    drun_read_format(&d, parallel_three, 1, 0);
    CHECK_INT(drun_to(&d, LW_FORMULATION_AUTO, 1e-12, 0.7, 100), LW_OK);
    drun_read_format(&other, "{'linkwright': 1, 'links': ['ground', {'name': 'bob', 'mass': 1,'centre': [0.47142857142857142857, "
        "0.62857142857142857143]}],'joints': [{'name': 'A', 'links': ['ground', 'bob'], 'at': [0, 0]}], 'input': {'joint': 'A', 'speed': 0.3},'gravity': "
        "[0, -9.81], 'tracers': [{'name': 'P', 'link': 'bob', 'at': [0.6, 0.8]}]}", 0, 0);
    CHECK_INT(drun_to(&other, LW_FORMULATION_REDUCED, 1e-12, 0.7, 100), LW_OK);
    for (int i = 0; i <= 100; i++)
        CHECK_NEAR(d.tracer[i].y, other.tracer[i].y, 1e-9, 0);
    /* reactions of least norm: orthogonal to the self-stress 1, -2, 1 of the cranks */
    lw_vec2 u = d.tracer[100];
    double stress = 0, size = 0;
    static const double part[] = { 1, -2, 1 };
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 2; k++) {
            const double *l = d.l + d.system.joint[2*c + k].row;
            stress += part[c]*(u.x*l[0] + u.y*l[1]);
            size = fmax(size, hypot(l[0], l[1]));
        }
    CHECK(size > 0);
    CHECK_NEAR(stress, 0, 1e-10*size, 0);
}

/* A slider of 1 kg comes to the end of its stroke, where a crank of 1e-8 kg turns by some 1e4 rad/s for 1e-8 s, and goes back as fast as it
 * came. */
TEST(light_crank_at_its_dead_point)
{
    static const lw_formulation way[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_RADAU, LW_FORMULATION_ALPHA };
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'crank', 'mass': 1e-8, 'centre': [0, 0.5], 'inertia': 1e-9}, {'name': 'rod',"
        "'mass': 1e-8, 'centre': [1, 0.5], 'inertia': 1e-9}, {'name': 'slider', 'mass': 1, 'centre': [2, 0], 'inertia': 0.1}], 'joints': ["
        "{'name': 'O', 'links': ['ground', 'crank'], 'at': [0, 0]}, {'name': 'A', 'links': ['crank', 'rod'], 'at': [0, 1]}, {'name': 'B',"
        "'links': ['rod', 'slider'], 'at': [2, 0]}, {'name': 'S', 'kind': 't', 'links': ['ground', 'slider'], 'at': [2, 0], 'along': [1, 0]}],"
        "'input': {'joint': 'S', 'speed': 1}}", 0, 0);
    for (int f = 0; f < 4; f++)
        for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-2) {
            CHECK_INT(drun_to(&d, way[f], tolerance, 2, 1), LW_OK);
            CHECK_NEAR(d.v[6]*d.system.unit, -1, tolerance + 1e-7, 0);
        }
    CHECK_INT(drun_to(&d, LW_FORMULATION_GGL, 1e-12, 2, 1), LW_OK);          /* whose steps become too short; the rest is by another formulation */
    CHECK_INT(d.report.gave_up, LW_FORMULATION_GGL);
    CHECK_INT(d.report.formulation, LW_FORMULATION_INDEX1);
    CHECK(d.report.gave_up_t > 1 && d.report.gave_up_t < 2);
    CHECK_NEAR(d.v[6]*d.system.unit, -1, 1e-7, 0);
}

/* A cart is driven with 1 m/s from 0.5 s on, at once: the rod of 1 kg that hangs on it by its end is pushed by 1/(1/m + l^2/I) = 1/3 N s. */
TEST(motions_that_change_their_speed_at_once_push)
{
    static const lw_formulation way[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL, LW_FORMULATION_RADAU,
                                          LW_FORMULATION_ALPHA };
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 2, 'centre': [0, 0], 'inertia': 1}, {'name': 'rod', 'mass': 1,"
        "'centre': [0, -1], 'inertia': 0.5}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': [0, 0], 'along': [1, 0]},"
        "{'name': 'A', 'links': ['cart', 'rod'], 'at': [0, 0]}], 'input': {'joint': 'S', 'motion': 'max(0, t - 0.5)'}}", 0, 0);
    for (int f = 0; f < 5; f++) {
        CHECK_INT(drun_to(&d, way[f], 1e-8, 0.500001, 3), LW_OK);
        CHECK_NEAR(d.v[3]*d.system.unit, 1.0/3, 1e-5, 0);
        CHECK_NEAR(d.v[5], -2.0/3, 1e-5, 0);
        CHECK_INT(drun_to(&d, way[f], 1e-8, 1, 2), LW_OK);           /* a sample is at the push, whose work is not known */
        CHECK(d.report.energy_steps == 0);
        CHECK_NEAR(d.q[5], -1.0/3, way[f] == LW_FORMULATION_ALPHA ? 1e-5 : 2e-8, 0);
    }
}

/* Two four-bars that are parallelograms go through their flat posture at 0.714 s; at each tolerance as the explicit method tells. */
TEST(implicit_steps_through_a_flat_posture)
{
    drun_read(&d, "examples/two-four-bars.json");
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-12, 2, 20), LW_OK);
    drun_keep_path(&other, &d);
    for (double tolerance = 1e-4; tolerance > 1e-13; tolerance *= 1e-2) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_RADAU, tolerance, 2, 20), LW_OK);
        CHECK_INT(d.n_moment, 21);
        for (int k = 0; k < d.n_moment; k++)
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(d.tracer[k], other.tracer[k])), 0, 100*tolerance + 1e-10, 0);
    }
}

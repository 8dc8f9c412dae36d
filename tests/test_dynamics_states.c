/* First-order states: answers known in closed form, derivatives against differences, formulations against each other,
 * balances of energy. */
#include "mbs/formulations/ggl.c"
#include "base/vec2.h"
#include "mbs/dynamics/dynamics_space.h"
#include "tests/dynamics_run.h"
#include "tests/spatial_models.h"

#define MOST 160

/* A wheel on a pin, inertia %g; %s after its joint: input, loads. */
static const char wheel[] =
    "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'wheel', 'mass': 1, 'centre': [0, 0], "
    "'inertia': %g}], 'joints': [{'name': 'A', 'links': ['ground', 'wheel'], 'at': [0, 0]}], %s}";

static const char arm_with_all[] =
    "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'arm', 'mass': 3, 'centre': [0.5, 0.1], 'inertia': 0.2}, {'name': 'fore', "
    "'mass': 2, 'centre': [1.3, 0.3], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': ['ground', 'arm'], 'at': [0, 0]}, {'name': 'B', 'links': "
    "['arm', 'fore'], 'at': [1, 0.2]}], 'inputs': [{'joint': 'A', 'speed': 0.2}, {'joint': 'B', 'speed': -0.1}], 'gravity': [0, -9.81], 'tracers': "
    "[{'name': 'P', 'link': 'fore', 'at': [1.6, 0.4]}], 'states': [{'name': 'e', 'rate': '-3*state(e) + x(P)*state(C.p1)/1e6 + omega(fore)', 'start': "
    "'x(P)'}], 'controllers': [{'name': 'pid', 'wanted': '0.3*sin(2*t)', 'measured': 'q(B)', 'proportional': 60, 'integral': 90, 'derivative': 4, "
    "'filter': 0.01, 'feed_forward': 'lag(v(A), 0.05) + integral(0.1*q(A))', 'least': -40, 'greatest': 40}], 'motors': [{'name': 'M', 'joint': 'B', "
    "'voltage': 'output(pid)', 'resistance': 0.7, 'inductance': 2e-3, 'torque_constant': 0.1, 'inertia': 2e-4, 'ratio': 1, 'current': 0.5}], 'cylinders': "
    "[{'name': 'C', 'links': ['ground', 'arm'], 'at': [[0.3, -0.8], [0.8, 0.1]], 'bore': 0.05, 'rod': 0.03, 'retracted': 0.9, 'stroke': 0.4, "
    "'dead_volume': 1e-4, 'pressures': [3e6, 2e6], 'valve': '0.3*sin(3*t) + 0.1*q(A)', 'flow': 2e-4, 'supply': 1.2e7, 'tank': 1e5, 'leakage': 1e-12, "
    "'relief': 1.1e7, 'relief_flow': 1e-11, 'damping': 300, 'friction': 50, 'friction_speed': 0.01}], 'forces': [{'link': 'fore', 'at': [1.6, 0.4], 'fy': "
    "'-5*state(e) - 20*rate(C)', 'torque': '0.1*state(M.current)'}]}";

static double last_z[32], q_end, v_end, drive_end;      /* drive_end: what the motion of the first input pushes with */

static lw_status keep_last(void *context, const lw_moment *m)
{
    drun *d = context;
    if (d->model.states.n_state)
        memcpy(last_z, m->z, (size_t)d->model.states.n_state*sizeof *last_z);
    drive_end = d->model.motion[0] ? m->l[d->system.n_row] : 0;
    return drun_keep(context, m);
}

/* Run a model to `end`; states stay in last_z, the first joint's displacement and rate in q_end, v_end. */
static void run_to(drun *d, double end, lw_formulation f)
{
    lw_dynamics *made = NULL;
    lw_measure m;
    d->o.to = end;
    d->o.intervals = 20;
    d->o.formulation = f;
    d->o.relative = d->o.absolute = 1e-11;
    d->n_moment = 0;
    d->status = lw_dynamics_make(&d->model, &d->o, &made, &d->e);
    CHECK_TEXT(d->e.text, "");
    CHECK_INT(d->status, LW_OK);
    if (!made)
        return;
    lw_system_free(&d->system);             /* of drun_to */
    d->system = *lw_dynamics_system(made);
    d->status = lw_dynamics_run(made, keep_last, d, &d->report, &d->e);
    CHECK_TEXT(d->e.text, "");
    CHECK_INT(d->status, LW_OK);
    CHECK_INT(d->n_moment, 21);
    lw_measure_joint(lw_dynamics_system(made), 0, d->q, d->v, false, &m);
    q_end = m.value;
    v_end = m.rate;
    memset(&d->system, 0, sizeof d->system);
    lw_dynamics_free(made);
}

static drun d;

static void read_wheel(const char *format, double inertia, const char *rest)
{
    char text[6000];
    json_format(text, sizeof text, format, inertia, rest);
    drun_read_text(&d, text);
}

static const lw_formulation formulation[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                              LW_FORMULATION_GGL };

/* z' = 1 - z/T, z' = cos(w t), a lag and an integral in a force. */
TEST(answers_in_closed_form)
{
    for (int k = 0; k < 4; k++) {
        read_wheel(wheel, 0.5, "'input': {'joint': 'A', 'speed': 1}, 'states': [{'name': 'e', 'rate': '1 - state(e)/0.25'}, "
             "{'name': 's', 'rate': 'cos(5*t)', 'start': 2, 'scale': 10}, {'name': 'turn', 'rate': 'v(A)'}], "
             "'forces': [{'link': 'wheel', 'torque': 'lag(3, 0.1, 0) + 0*integral(exp(-t)) + 0*lag(q(A) + 7, 1)'}]");
        run_to(&d, 1, formulation[k]);
        double off = formulation[k] == LW_FORMULATION_CVODE || formulation[k] == LW_FORMULATION_GGL ? 1e-8 : 1e-10;
        CHECK_NEAR(last_z[0], 0.25*(1 - exp(-4)), off, 0);
        CHECK_NEAR(last_z[1], 2 + sin(5)/5, off, 0);
        CHECK_NEAR(last_z[2], q_end, off, 0);
        CHECK_NEAR(last_z[3], 3*(1 - exp(-10)), off, 0);
        CHECK_NEAR(last_z[4], 1 - exp(-1), off, 0);
        CHECK_NEAR(v_end, 1 + 6*(1 - 0.1*(1 - exp(-10))), off, 0);
    }
    /* a lag without a start begins at its input */
    read_wheel(wheel, 0.5, "'input': {'joint': 'A', 'speed': 0}, 'forces': [{'link': 'wheel', 'torque': '0*lag(q(A) + 7, 1)'}]");
    run_to(&d, 1, LW_FORMULATION_AUTO);
    CHECK_NEAR(last_z[0], 7, 1e-12, 0);
}

/* The motor of Makkonen 1999, table 4: poles of its speed over the voltage, and the step of voltage that they cause. */
static const char step_of_voltage[] =
    "'input': {'joint': 'A', %s}, 'motors': [{'name': 'M', 'joint': 'A', 'voltage': 100, 'resistance': 30, "
    "'inductance': 0.0703, 'torque_constant': 1.6, 'inertia': 0.0011}]";

TEST(a_motor_starts)
{
    const double p = -101.91534671, s = -324.8271853, t = 0.02, w = 100/1.6;
    char text[400];
    for (int k = 0; k < 4; k++) {
        snprintf(text, sizeof text, step_of_voltage, "'speed': 0");
        read_wheel(wheel, 0, text);
        run_to(&d, t, formulation[k]);
        CHECK_NEAR(v_end, w*(1 - (s*exp(p*t) - p*exp(s*t))/(s - p)), 1e-7, 0);
        /* all that came in is heat, in the coil, or moves */
        double kinetic = 0.5*0.0011*v_end*v_end, coil = 0.5*0.0703*last_z[0]*last_z[0];
        CHECK_NEAR(last_z[1], last_z[2] + kinetic + coil, 0, 1e-8);
        CHECK_NEAR(d.energy[20], kinetic, 0, 1e-9);
        /* held still, it is a coil with a resistor; 1.6 N m/A push against what holds it */
        snprintf(text, sizeof text, step_of_voltage, "'motion': '0*t'");
        read_wheel(wheel, 0.1, text);
        run_to(&d, t, formulation[k]);
        CHECK_NEAR(last_z[0], 100/30.0*(1 - exp(-30*t/0.0703)), 1e-9, 0);
        CHECK_NEAR(fabs(drive_end), 1.6*last_z[0], 1e-8, 0);
    }
}

/* A drive whose demand is above its curve ends at the speed without load, or holds with the torque of stall. */
TEST(a_drive_keeps_to_its_curve)
{
    static const char format[] = "'input': {'joint': 'A', %s}, 'motors': [{'joint': 'A', 'torque': '%s', 'stall': 6, 'free_speed': 40}]";
    char text[300];
    snprintf(text, sizeof text, format, "'speed': 0", "1000");
    read_wheel(wheel, 0.05, text);
    run_to(&d, 20, LW_FORMULATION_AUTO);
    CHECK_NEAR(v_end, 40, 1e-8, 0);
    snprintf(text, sizeof text, format, "'motion': '0*t'", "1000 - integral(0*t)");
    read_wheel(wheel, 0.05, text);
    run_to(&d, 1, LW_FORMULATION_INDEX1);
    CHECK_NEAR(fabs(drive_end), 6, 1e-10, 0);
    snprintf(text, sizeof text, format, "'speed': 0", "-0.3");
    read_wheel(wheel, 0.05, text);
    run_to(&d, 1, LW_FORMULATION_AUTO);
    CHECK_NEAR(v_end, -6, 1e-9, 0);
}

/* A mass on the oil of a closed cylinder swings at f = sqrt(K (A1^2/V1 + A2^2/V2)/m)/2 pi, in small motions. */
TEST(a_mass_on_oil)
{
    static const char format[] =
        "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'm', 'mass': 1000, 'centre': [0.8, 0], 'inertia': 1}], 'joints': "
        "[{'name': 'S', 'kind': 't', 'links': ['ground', 'm'], 'at': [0.8, 0], 'along': [1, 0]}], 'input': {'joint': 'S', 'speed': 1e-4}, 'cylinders': "
        "[{'name': 'C', 'links': ['ground', 'm'], 'at': [[0, 0], [0.8, 0]], 'bore': 0.125, 'rod': 0.08, 'retracted': 0.5, 'stroke': 0.6, 'dead_volume': "
        "1e-3, 'bulk_modulus': %.17g, 'pressures': [2e6, %.17g]}]}";
    double bulk = 1.4e9, a1 = LW_PI/4*0.125*0.125, a2 = a1 - LW_PI/4*0.08*0.08;
    double stiffness = bulk*(a1*a1/(1e-3 + 0.3*a1) + a2*a2/(1e-3 + 0.3*a2)), w = sqrt(stiffness/1000);
    CHECK_NEAR(stiffness, 6.819319e7, 5, 0);             /* of the declared boom cylinder */
    for (int k = 0; k < 4; k++) {
        drun_read_format(&d, format, bulk, 2e6*a1/a2);
        run_to(&d, 2.25*2*LW_PI/w, formulation[k]);
        CHECK_NEAR(q_end*w/1e-4, 1, 1e-4, 0);            /* two periods and a quarter: the top of the swing */
    }
}

/* Pistons driven by a valve: steady speed Q/A against no load, and the stop at the end of the stroke. */
TEST(a_valve_moves_a_piston)
{
    static const char format[] =
        "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'm', 'mass': 5, 'centre': [0.8, 0], 'inertia': 1}], 'joints': [{'name': "
        "'S', 'kind': 't', 'links': ['ground', 'm'], 'at': [0.8, 0], 'along': [1, 0]}], 'input': {'joint': 'S', 'speed': 0}, 'cylinders': [{'name': 'C', "
        "'links': ['ground', 'm'], 'at': [[0, 0], [0.8, 0]], 'bore': 0.05, 'rod': 0.03, 'retracted': 0.5, 'stroke': 0.6, 'dead_volume': 1e-4, "
        "'pressures': [1e6, 1e6], 'valve': %g, 'flow': 4e-4, 'drop': 3.5e6, 'supply': %g, 'damping': 500, 'stop_damping': 2e4}]}";
    double a1 = LW_PI/4*0.05*0.05, a2 = a1 - LW_PI/4*0.03*0.03;
    drun_read_format(&d, format, 0.5, 1e7);
    run_to(&d, 0.4, LW_FORMULATION_AUTO);
    /* p1 A1 - p2 A2 = c v; Q1 = A1 v through one edge, Q2 = A2 v through the other */
    double low = 0, high = 10, k = 0.5*4e-4/sqrt(3.5e6), p1 = 0, p2 = 0;
    for (int i = 0; i < 100; i++) {
        double v = 0.5*(low + high);
        p1 = 1e7 - pow(a1*v/k, 2), p2 = pow(a2*v/k, 2);
        *(p1*a1 - p2*a2 > 500*v ? &low : &high) = v;
    }
    CHECK_NEAR(v_end, low, 0, 1e-6);
    CHECK_NEAR(last_z[0], p1, 0, 1e-5);
    CHECK_NEAR(last_z[1], p2, 0, 1e-5);
    CHECK(d.report.formulation == LW_FORMULATION_GGL || d.report.formulation == LW_FORMULATION_INDEX1);
    double v_full[2];
    for (int i = 0; i < 2; i++) {                            /* a valve opens no wider than fully */
        static drun d2;
        drun_read_format(&d2, format, i == 0 ? 1.0 : 3.0, 1e6);
        run_to(&d2, 0.1, LW_FORMULATION_AUTO);
        v_full[i] = v_end;
    }
    CHECK_NEAR(v_full[1], v_full[0], 0, 1e-12);
    run_to(&d, 5, LW_FORMULATION_GGL);                       /* at the stop: full pressure on a spring of 1e8 N/m */
    CHECK_NEAR(q_end, 0.3 + (1e7*a1 - last_z[1]*a2)/1e8, 1e-7, 0);
    CHECK_NEAR(last_z[0], 1e7, 0, 1e-4);
}

/* With all parts at once every formulation gives the same, the work agrees with the energies. */
TEST(formulations_agree)
{
    double z[32], q = 0, v = 0;
    for (int k = 1; k < 4; k++) {
        drun_read_format(&d, arm_with_all, 0, 0);
        run_to(&d, 0.5, formulation[k]);
        CHECK(d.report.energy_error < 1e-6*d.report.energy_scale);
        for (int i = 0; k > 1 && i < d.model.states.n_state; i++)
            CHECK_NEAR(last_z[i], z[i], 2e-6*d.model.states.state[i].scale, 2e-6);
        if (k > 1) {
            CHECK_NEAR(q_end, q, 1e-7, 0);
            CHECK_NEAR(v_end, v, 1e-6, 0);
        }
        memcpy(z, last_z, sizeof z);
        q = q_end, v = v_end;
    }
}

/* A valve moves a four-bar: radau goes on at tolerances near rounding, where pressures have fewer digits than places, and agrees with index1. */
TEST(oil_at_fine_tolerances)
{
    double q = 0, v = 0;
    for (int k = 0; k < 2; k++) {
        drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.2, 0.3], 'inertia': 0.1}, {'name': 'b', 'mass': 2, "
            "'centre': [1, 0.8], 'inertia': 0.3}, {'name': 'c', 'mass': 1, 'centre': [1.8, 0.4], 'inertia': 0.1}], 'joints': [{'name': 'A', 'links': "
            "['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.4, 0.6]}, {'name': 'C', 'links': ['b', 'c'], 'at': [1.6, 0.9]}, "
            "{'name': 'D', 'links': ['c', 'ground'], 'at': [2, 0]}], 'input': {'joint': 'A', 'speed': 1}, 'gravity': [0, -9.81], 'cylinders': [{'name': 'Y', "
            "'links': ['ground', 'b'], 'at': [[1, -0.5], [1.1, 0.8]], 'bore': 0.05, 'rod': 0.03, 'retracted': 0.8, 'stroke': 1, 'dead_volume': 1e-4, "
            "'pressures': [2e5, 2e5], 'valve': '0.5*sin(4*t)', 'flow': 1e-3, 'supply': 1e6, 'damping': 50}]}", 0, 0);
        run_to(&d, 0.1, k ? LW_FORMULATION_RADAU : LW_FORMULATION_INDEX1);
        if (k) {
            CHECK_NEAR(q_end, q, 1e-10, 0);
            CHECK_NEAR(v_end, v, 1e-9, 0);
        }
        q = q_end, v = v_end;
    }
}

/* A four-bar turned by a motor: filter of a controller, inductance, voltage. */
static const char with_motor[] =
    "{'linkwright': 1, 'units': {'length': 'm'}, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.15], 'inertia': 0.01}, "
    "{'name': 'b', 'mass': 1.5, 'centre': [0.4, 0.5], 'inertia': 0.1}, {'name': 'c', 'mass': 1.2, 'centre': [0.9, 0.35], 'inertia': 0.05}], 'joints': "
    "[{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, 0.3]}, {'name': 'C', 'links': ['b', 'c'], 'at': "
    "[0.8, 0.7]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0]}], 'input': {'joint': 'A', 'speed': 6}, 'controllers': [{'name': 'k', 'wanted': "
    "'havsin(t, 0.1, 0, 0.6, 1)', 'measured': 'q(A)', 'proportional': 200, 'integral': 400, 'derivative': 20, 'filter': %g}], 'motors': [{'name': 'M', "
    "'joint': 'A', 'resistance': 0.8, 'inductance': %g, 'torque_constant': 0.05, 'inertia': 1e-4, 'ratio': 20, 'voltage': '%s'}]}";

static void read_motor(double filter, double inductance, const char *voltage)
{
    char text[3000];
    json_format(text, sizeof text, with_motor, filter, inductance, voltage);
    drun_read_json(&d, text);
}

/* The fast filter of a controller magnifies errors of the angle, which methods of low order answer by ever shorter steps (14000 at 1e-8 in a
 * second). */
TEST(a_fast_filter)
{
    double q = 0;
    for (int k = 0; k < 3; k++) {
        read_motor(2e-5, 1e-3, "output(k)");
        drun_to(&d, k ? LW_FORMULATION_AUTO : LW_FORMULATION_INDEX1, k < 2 ? 1e-8 : 1e-5, 0.3, 20);
        CHECK_TEXT(d.e.text, "");
        if (k) {
            CHECK(d.report.steps + d.report.refused < 200);
            CHECK_NEAR(d.q[2], q, k < 2 ? 1e-9 : 1e-6, 0);
        }
        q = k ? q : d.q[2];
    }
}

/* A current that follows the speed at once is a little off after each step.  Steps do not get short by that; where they do after all, an implicit method
 * goes on. */
TEST(a_current_that_follows_at_once)
{
    static const struct { double inductance, tolerance; lw_formulation asked, by; } part[] = {
        { 1e-6, 1e-9, LW_FORMULATION_RADAU, LW_FORMULATION_RADAU }, { 1e-6, 1e-10, LW_FORMULATION_AUTO, LW_FORMULATION_CVODE },
        { 5e-4, 1e-4, LW_FORMULATION_AUTO, LW_FORMULATION_RADAU }, { 5e-4, 1e-7, LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1 },
        { 6.5e-4, 1e-4, LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1 } };    /* more accurate in less time */
    for (int k = 0; k < 5; k++) {
        read_motor(0.1, part[k].inductance, "24");
        drun_to(&d, part[k].asked, part[k].tolerance, 0.6, 1);
        CHECK_TEXT(d.e.text, "");
        CHECK_INT(d.report.formulation, part[k].by);
    }
}

/* Voltages that jump at the start, to 24 V or to -24 V. */
TEST(a_jump_at_the_start)
{
    for (int k = 0; k < 2; k++) {
        double q = 0;
        for (int f = 0; f < 2; f++) {
            read_motor(0.1, 1e-4, k ? "-24*sign(sin(5*t))" : "24*sign(sin(5*t))");
            drun_to(&d, f ? LW_FORMULATION_RADAU : LW_FORMULATION_INDEX1, 1e-11, 0.3, 1);
            CHECK_TEXT(d.e.text, "");
            CHECK_INT(d.report.gave_up, LW_FORMULATION_AUTO);
            if (f)
                CHECK_NEAR(d.q[2], q, 1e-10, 0);
            q = d.q[2];
        }
    }
}

/* At rest, rounding moves the crank: at this speed it would be in a singular posture in 30 s. No step over that is tried. */
TEST(a_singular_posture_behind_the_end)
{
    static const char format[] =
        "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5], 'inertia': 0.01}, {'name': 'b', 'mass': 2, "
        "'centre': [4, 4], 'inertia': 0.02}, {'name': 'c', 'mass': 1.5, 'centre': [2, 1.25], 'inertia': 0.015}], 'joints': [{'name': 'O', 'links': ['ground', "
        "'a'], 'at': [0, 0]}, {'name': 'A', 'links': ['a', 'b'], 'at': [0, 1]}, {'name': 'B', 'links': ['b', 'c'], 'at': [2, 2.5]}, {'name': 'C', 'links': "
        "['c', 'ground'], 'at': [2, 0]}], 'input': {'joint': 'O'}, 'cylinders': [{'name': 'Y', 'links': ['ground', 'b'], 'at': [[3, -1], [4, 4]], 'bore': 0.05, "
        "'rod': 0.03, 'retracted': 4, 'stroke': 2.5, 'dead_volume': 1e-4, 'flow': 5e-4, 'supply': 1e7, 'valve': '0.2*sin(4*t)', 'pressures': [2e5, 3e5], "
        "'damping': 100}]}";
    drun_read_format(&d, format, 0, 0);
    for (int f = 0; f < 2; f++) {
        CHECK_INT(drun_to(&d, f ? LW_FORMULATION_CVODE : LW_FORMULATION_AUTO, 1e-8, 0.6, 12), LW_OK);
        CHECK_INT(d.n_moment, 13);
        CHECK(d.report.steps < 1500 && d.report.rates < 3000);
    }
}

/* ---- in space ---------------------------------------------------------------------------------------------------- */

/* arm_with_all in the plane y z of space. */
static const char arm_in_space[] =
    "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'arm', 'mass': 3, 'centre': [0, 0.5, 0.1], 'inertia': [0.2, 0.15, 0.17]}, "
    "{'name': 'fore', 'mass': 2, 'centre': [0, 1.3, 0.3], 'inertia': [0.1, 0.06, 0.07]}], 'joints': [{'name': 'A', 'links': ['ground', 'arm'], 'at': [0, "
    "0, 0], 'axis': [1, 0, 0]}, {'name': 'B', 'links': ['arm', 'fore'], 'at': [0, 1, 0.2], 'axis': [1, 0, 0]}], 'inputs': [{'joint': 'A', 'speed': 0.2}, "
    "{'joint': 'B', 'speed': -0.1}], 'gravity': [0, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'fore', 'at': [0, 1.6, 0.4]}], 'states': [{'name': 'e', "
    "'rate': '-3*state(e) + y(P)*state(C.p1)/1e6 + v(A) + v(B)', 'start': 'y(P)'}], 'controllers': [{'name': 'pid', 'wanted': '0.3*sin(2*t)', 'measured': "
    "'q(B)', 'proportional': 60, 'integral': 90, 'derivative': 4, 'filter': 0.01, 'feed_forward': 'lag(v(A), 0.05) + integral(0.1*q(A))', 'least': -40, "
    "'greatest': 40}], 'motors': [{'name': 'M', 'joint': 'B', 'voltage': 'output(pid)', 'resistance': 0.7, 'inductance': 2e-3, 'torque_constant': 0.1, "
    "'inertia': 2e-4, 'ratio': 1, 'current': 0.5}], 'cylinders': [{'name': 'C', 'links': ['ground', 'arm'], 'at': [[0, 0.3, -0.8], [0, 0.8, 0.1]], "
    "'bore': 0.05, 'rod': 0.03, 'retracted': 0.9, 'stroke': 0.4, 'dead_volume': 1e-4, 'pressures': [3e6, 2e6], 'valve': '0.3*sin(3*t) + 0.1*q(A)', "
    "'flow': 2e-4, 'supply': 1.2e7, 'tank': 1e5, 'leakage': 1e-12, 'relief': 1.1e7, 'relief_flow': 1e-11, 'damping': 300, 'friction': 50, "
    "'friction_speed': 0.01}], 'forces': [{'link': 'fore', 'at': [0, 1.6, 0.4], 'fz': '-5*state(e) - 20*rate(C)', 'tx': '0.1*state(M.current)'}]}";

static lw_spatial in_space;

typedef struct space_end { lw_dynamics *d; double z[32], q, v, energy; } space_end;

static lw_status keep_space(void *context, const lw_moment *m)
{
    space_end *to = context;
    lw_space_moment o;
    lw_error e;
    lw_status st = lw_dynamics_space_moment(to->d, m, &o, &e);
    memcpy(to->z, m->z, (size_t)in_space.states.n_state*sizeof *to->z);
    to->q = o.input[0];
    to->v = o.input_rate[0];
    return st;
}

static void run_in_space(double end, lw_formulation f, double tolerance, space_end *to)
{
    lw_dynamics_report r;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.to = end, o.intervals = 20, o.formulation = f, o.relative = o.absolute = tolerance;
    CHECK_SILENT(lw_dynamics_make_spatial(&in_space, &o, &to->d, &check_error));
    CHECK_SILENT(lw_dynamics_run(to->d, keep_space, to, &r, &check_error));
    CHECK(r.energy_error < 1e-6*r.energy_scale);
    lw_dynamics_free(to->d);
}

/* The same arm as a planar and as a spatial model, by every formulation that space has. */
TEST(states_in_space)
{
    static const lw_formulation way[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE };
    space_end s;
    drun_read_format(&d, arm_with_all, 0, 0);
    run_to(&d, 0.5, LW_FORMULATION_INDEX1);
    read_spatial(arm_in_space, "text", &in_space);
    CHECK_INT(in_space.states.n_state, d.model.states.n_state);
    for (size_t k = 0; k < sizeof way/sizeof *way; k++) {
        run_in_space(0.5, way[k], 1e-11, &s);
        CHECK_NEAR(s.q, q_end, 1e-7, 0);
        CHECK_NEAR(s.v, v_end, 1e-6, 0);
        for (int i = 0; i < d.model.states.n_state; i++)
            CHECK_NEAR(s.z[i], last_z[i], 2e-6*d.model.states.state[i].scale, 2e-6);
    }
    lw_spatial_free(&in_space);
}

/* A motor with a rotor between links that both turn about O; b has its centre there.  Angular momentum stays 0, and a circuit drives one inertia: solved in
 * closed form.  At loose tolerances the rotor turns several times in a step.  A ratio of -1 is a rotor of its own, too. */
TEST(a_rotor_between_moving_links)
{
    static const struct { double ratio, inertia, constant; } part[] = { { 60, 1e-4, 0.05 }, { -1, 0.05, 0.5 }, { 1, 0.05, 0.5 }, { -300, 1e-6, 0.01 } };
    static const lw_formulation way[] = { LW_FORMULATION_AUTO, LW_FORMULATION_CVODE, LW_FORMULATION_RADAU };
    const double a = 0.03, b = 0.02, volt = 24, r = 1, l = 1e-3, t = 0.5;
    for (size_t p = 0; p < sizeof part/sizeof *part; p++)
        for (int space = 0; space < 2; space++) {
            double n = part[p].ratio, j = part[p].inertia, k = part[p].constant*n, turn_a = -(b + j*n)/(a + b + j), turn_b = 1 + turn_a;
            double all = a*turn_a*turn_a + b*turn_b*turn_b + j*(turn_a + n)*(turn_a + n);
            double root = sqrt(r*r/(4*l*l) - k*k/(l*all)), x = -r/(2*l) + root, y = -r/(2*l) - root;
            double turn = volt/k*(t - (y/x*expm1(x*t) - x/y*expm1(y*t))/(y - x));
            const char *more = space ? ", 0" : "", *inertia = space ? "[0.02, 0.02, 0.02]" : "0.02";
            const char *axis = space ? ", 0], 'axis': [0, 0, 1], 'kind': 'r'" : "]";
            char text[2000];
            json_format(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0%s], 'inertia': %s}, {'name': 'b', "
                        "'mass': 2, 'centre': [0, 0%s], 'inertia': %s}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0%s}, {'name': 'B', "
                        "'links': ['a', 'b'], 'at': [0, 0%s}], 'input': {'joint': 'B'}, 'motors': [{'name': 'M', 'joint': 'B', 'voltage': 24, 'resistance': 1, "
                        "'inductance': 1e-3, 'torque_constant': %.17g, 'inertia': %.17g, 'ratio': %.17g}]}", more, inertia, more, inertia, axis, axis,
                        part[p].constant, j, n);
            for (int f = 0; f < 4; f++) {
                double tolerance = f < 3 ? 1e-10 : 1e-4;
                if (space) {
                    space_end s;
                    read_spatial(text, "text", &in_space);
                    run_in_space(t, f < 3 ? way[f] : way[0], tolerance, &s);
                    CHECK_NEAR(s.q, turn, f < 3 ? 1e-8 : 1e-3, 0);
                    lw_spatial_free(&in_space);
                } else {
                    drun_read_json(&d, text);
                    CHECK_INT(drun_to(&d, f < 3 ? way[f] : way[0], tolerance, t, 1), LW_OK);
                    CHECK_NEAR(d.q[2], turn_a*turn, f < 3 ? 1e-8 : 1e-3, 0);
                    CHECK_NEAR(d.q[5], turn_b*turn, f < 3 ? 1e-8 : 1e-3, 0);
                }
            }
        }
}

TEST(rotors_that_are_refused)
{
    static const struct { const char *link, *rotor, *part; } wrong[] = {
        { "'mass': 1, 'centre': [0.1, 0], 'inertia': 1", "M.rotor", "rename one of them" },
        { "'elastic': {'section': {'shape': 'round', 'diameter': 0.01}, 'material': 'steel'}", "c", "elastic link \"a\"" } };
    for (int k = 0; k < 2; k++) {
        char text[2000];
        lw_error e = { 0 };
        lw_model m;
        json_format(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', %s}, {'name': 'b', 'mass': 1, 'centre': [1, 0], 'inertia': 1}, "
                    "{'name': '%s', 'mass': 1, 'centre': [1, 0], 'inertia': 1}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': "
                    "'B', 'links': ['a', 'b'], 'at': [1, 0]}, {'name': 'C', 'links': ['b', '%s'], 'at': [2, 0]}], 'motors': [{'name': 'M', 'joint': 'B', "
                    "'voltage': 1, 'resistance': 1, 'inductance': 1, 'torque_constant': 1, 'inertia': 1, 'ratio': 3}]}",
                    wrong[k].link, wrong[k].rotor, wrong[k].rotor);
        CHECK_INT(lw_model_read(text, strlen(text), "text", &m, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, wrong[k].part);
        CHECK(e.line > 0);
    }
}

/* A rotor whose carrier turns about another axis than its own is a gyroscope.  Numbers: Lagrange's equations of the two angles, the kinetic energy of the
 * rotor J (n . omega + 20 E')^2/2, by the method of Dormand and Prince of order 8. */
TEST(a_rotor_as_a_gyroscope)
{
    static const lw_formulation way[] = { LW_FORMULATION_AUTO, LW_FORMULATION_RADAU };
    for (int f = 0; f < 2; f++) {
        space_end s;
        read_spatial("{'linkwright': 1, 'gravity': [0, -3, -9.81], 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.25, 0, 0], 'inertia': [0.02, "
                     "0.05, 0.06]}, {'name': 'b', 'mass': 1, 'centre': [0.7, 0.1, 0], 'inertia': [0.01, 0.03, 0.025]}], 'joints': [{'name': 'S', 'kind': "
                     "'r', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'E', 'kind': 'r', 'links': ['a', 'b'], 'at': [0.5, 0, 0], "
                     "'axis': [0, 0.644217687237691, 0.764842187284489]}], 'input': {'joint': 'S'}, 'motors': [{'name': 'M', 'joint': 'E', 'voltage': "
                     "'6*cos(2*t)', 'resistance': 1, 'inductance': 1e-2, 'torque_constant': 0.02, 'inertia': 2e-3, 'ratio': 20}]}", "text", &in_space);
        run_in_space(1.5, way[f], 1e-10, &s);
        CHECK_NEAR(s.q, -3.952696357365929, 1e-8, 0);
        CHECK_NEAR(s.v, -0.7005466323420043, 1e-8, 0);
        lw_spatial_free(&in_space);
    }
}

/* A slide that its input moves from the start, u = U cos(4 t), and a lag of this speed, T z' = u - z from z = U. */
TEST(states_beside_inputs_that_leave_no_freedom)
{
    static const lw_formulation way[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE };
    double t = 0.3, lag = 0.1, u = 0.06*4*0.6, part = 1/(1 + 16*lag*lag);
    for (size_t k = 0; k < sizeof way/sizeof *way; k++) {
        space_end s;
        read_spatial("{'linkwright': 1, 'links': ['ground', {'name': 'b', 'mass': 2, 'centre': [0.1, 0, 0], 'inertia': [0.01, 0.01, 0.01]}], "
                      "'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'b'], 'at': [0, 0, 0], 'axis': [0.6, 0.8, 0]}], "
                      "'tracers': [{'name': 'P', 'link': 'b', 'at': [0.1, 0.2, 0]}], 'inputs': [{'joint': 'S', 'motion': '0.06*sin(4*t)'}], "
                      "'forces': [{'link': 'b', 'at': [0, 0, 0], 'fy': '-3*lag(vx(P), 0.1)'}]}", "text", &in_space);
        run_in_space(t, way[k], 1e-11, &s);
        CHECK_NEAR(s.v, 0.24*cos(4*t), 1e-9, 0);
        CHECK_NEAR(s.z[0], u*part*(cos(4*t) + 4*lag*sin(4*t)) + u*(1 - part)*exp(-t/lag), 1e-8, 0);
        lw_spatial_free(&in_space);
    }
}

/* An elastic boom on a cylinder, from pressures that do not hold it: implicit with states, and explicit; in the plane the same. */
TEST(a_boom_on_oil)
{
    static const char *const part[2][4] = { { "[0, 0, 0]", "[2, 0, 0]", "[0.4, 0, -0.8]", "[1, 0, 0]" },
                                            { "[0, 0]", "[2, 0]", "[0.4, -0.8]", "[1, 0]" } };
    space_end s[2];
    for (int plane = 0; plane < 2; plane++) {
        const char *const *at = part[plane];
        char text[2000];
        json_format(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'boom', 'elastic': {'section': {'shape': 'box', "
                    "'width': 0.02, 'height': 0.02, 'wall': 0.002}, 'material': 'steel', 'axis': [%s, %s], %s'segments': 2}}, {'name': 'load', "
                    "'mass': 40, 'centre': %s, 'inertia': %s}], 'joints': [{'name': 'A', 'kind': 'r', 'links': ['ground', 'boom'], 'at': %s%s}, "
                    "{'name': 'W', 'kind': 'f', 'links': ['boom', 'load'], 'at': %s}], 'gravity': [0, %s -9.81], 'input': {'joint': 'A'}, "
                    "'cylinders': [{'name': 'C', 'links': ['ground', 'boom'], 'at': [%s, %s], 'bore': 0.05, 'rod': 0.03, 'retracted': 0.7, "
                    "'stroke': 0.6, 'dead_volume': 1e-4, 'pressures': [3e5, 2e5], 'valve': '0.3*t', 'flow': 1e-4, 'supply': 1e7, "
                    "'damping': 2e3}]}", at[0], at[1], plane ? "" : "'height': [0, 0, 1], ", at[1], plane ? "1" : "[1, 1, 1]", at[0],
                    plane ? "" : ", 'axis': [0, -1, 0]", at[1], plane ? "" : "0,", at[2], at[3]);
        if (plane) {
            drun_read_text(&d, text);
            run_to(&d, 0.05, LW_FORMULATION_AUTO);
            CHECK_INT(d.report.formulation, LW_FORMULATION_RADAU);
            CHECK_NEAR(d.report.energy_error, 0, 1e-6*d.report.energy_scale, 0);
            for (int i = 0; i < 2; i++)
                CHECK_NEAR(last_z[i], s[0].z[i], 0, 1e-7);
            CHECK(fabs(last_z[0] - 3e5) > 1e4);
            continue;
        }
        read_spatial(text, "text", &in_space);
        for (int k = 0; k < 2; k++)
            run_in_space(0.05, k ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO, 1e-11, &s[k]);
        CHECK_NEAR(s[0].q, s[1].q, 1e-9, 0);
        CHECK_NEAR(s[0].v, s[1].v, 1e-6, 0);
        for (int i = 0; i < 2; i++)
            CHECK_NEAR(s[0].z[i], s[1].z[i], 0, 1e-7);
        lw_spatial_free(&in_space);
    }
}

/* The Jacobian of the differential-algebraic equations, states included, against central differences. */
TEST(derivatives_are_exact)
{
    static double jac[MOST*MOST], value[MOST*MOST];
    lw_dynamics *made = NULL;
    lw_rng rng = check_rng(0);
    drun_read_format(&d, arm_with_all, 0, 0);
    d.o.formulation = LW_FORMULATION_GGL;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
    if (!made)
        return;
    lw_run run = { .d = made, .e = &d.e, .r = &d.report };
    ggl g = { .run = &run, .q = made->n_q, .v = made->n_v, .c = made->n_kept, .least_mass = 0.01 };
    int n = unknowns(&g), z = n - made->eq.n_z;
    double y[MOST], dy[MOST], up[MOST], down[MOST], c = 1.7;
    CHECK(n <= MOST);
    for (int i = 0; i < n; i++) {
        y[i] = 0.1*lw_rng_range(&rng, -1, 1) + (i < g.q ? made->start_q[i] : 0);
        dy[i] = lw_rng_range(&rng, -1, 1);
        if (i >= z)
            y[i] = made->start_z[i - z] + 0.1*lw_rng_range(&rng, 0, 1)*d.model.states.state[i - z].scale;
    }
    CHECK_INT(find_pattern(&g), LW_OK);
    CHECK_INT(jacobian(&g, 0.2, c, y, dy, value), LW_OK);
    for (int j = 0; j < n; j++)
        for (int k = g.columns.at[j]; k < g.columns.at[j + 1]; k++)
            jac[g.columns.row[k] + n*j] = value[k];      /* 0 outside the pattern */
    for (int j = 0; j < n; j++) {
        double was = y[j], rate = dy[j], h = 1e-6*(j >= z ? d.model.states.state[j - z].scale : 1);
        y[j] = was + h, dy[j] = rate + c*h;
        residual(&g, 0.2, y, dy, up);
        y[j] = was - h, dy[j] = rate - c*h;
        residual(&g, 0.2, y, dy, down);
        y[j] = was, dy[j] = rate;
        for (int i = 0; i < n; i++) {
            double row = i >= z ? d.model.states.state[i - z].scale : 100, column = j >= z ? d.model.states.state[j - z].scale : 1;
            CHECK_NEAR(jac[i + n*j], (up[i] - down[i])/(2*h), 1e-5*row/column, 1e-5);
        }
    }
    lw_columns_free(&g.columns);
    lw_dynamics_free(made);
}

/* A controller at its limit: its integral stays near what the output needs, and there is little overshoot. */
TEST(a_limited_controller_does_not_wind_up)
{
    static const char format[] =
        "'input': {'joint': 'A', 'speed': 0}, 'controllers': [{'name': 'c', 'wanted': 10, 'measured': 'v(A)', "
        "'proportional': 2, 'integral': 4, %s}], 'forces': [{'link': 'wheel', 'torque': 'output(c)'}]";
    char text[400];
    double overshoot[2];
    for (int k = 0; k < 2; k++) {
        snprintf(text, sizeof text, format, k ? "'least': -3, 'greatest': 3, 'unwind': 1e9" : "'least': -3, 'greatest': 3");
        read_wheel(wheel, 1, text);
        overshoot[k] = 0;
        for (int i = 1; i <= 30; i++) {
            run_to(&d, 0.4*i, LW_FORMULATION_AUTO);
            overshoot[k] = fmax(overshoot[k], v_end - 10);
        }
        CHECK_NEAR(v_end, 10, k ? 10 : 1e-3, 0);
    }
    CHECK(overshoot[0] < 1.5 && overshoot[1] > 5);
}

static void refused(const char *rest, const char *part)
{
    char text[3000];
    lw_error e = { 0 };
    lw_model m;
    json_format(text, sizeof text, wheel, 1.0, rest);
    CHECK_INT(lw_model_read(text, strlen(text), "text", &m, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, part);
    CHECK(e.line > 0 && e.column > 0);
}

TEST(bad_parts_are_named)
{
    refused("'states': [{'name': 'a', 'rate': 'state(b)'}]", "there is no state \"b\"");
    refused("'states': [{'name': 'a', 'rate': '1'}, {'name': 'a', 'rate': '1'}]", "two states");
    refused("'states': [{'name': 'a'}]", "\"rate\"");
    refused("'states': [{'name': 'a', 'rate': 'lag(t)'}]", "missing");
    refused("'states': [{'name': 'a', 'rate': 'lag(t, 0)'}]", "greater than 0");
    refused("'states': [{'name': 'a', 'rate': 'integral(t, t)'}]", "a number is expected");
    refused("'states': [{'name': 'a', 'rate': 'integral(q(Z))'}]", "no joint \"Z\"");
    refused("'input': {'joint': 'A', 'motion': 'integral(t)'}", "integral is possible in forces");
    refused("'forces': [{'link': 'wheel', 'torque': 'output(c)'}]", "no controller \"c\"");
    refused("'controllers': [{'name': 'c', 'wanted': 1, 'measured': 't', 'derivative': 1}]", "\"filter\"");
    refused("'controllers': [{'name': 'c', 'wanted': 1, 'measured': 't', 'least': 2, 'greatest': 1}]", "less than");
    refused("'controllers': [{'name': 'c', 'wanted': 1, 'measured': 't', 'integral': 1, 'least': 0}]", "\"unwind\"");
    refused("'motors': [{'joint': 'A', 'voltage': 1, 'resistance': 1, 'torque_constant': 1}]", "\"inductance\"");
    refused("'motors': [{'joint': 'A', 'voltage': 1, 'resistance': 1, 'inductance': 0, 'torque_constant': 1}]", "above 0");
    refused("'motors': [{'joint': 'A', 'voltage': 'q(B)', 'resistance': 1, 'inductance': 1, 'torque_constant': 1}]",
            "no joint \"B\"");
    refused("'motors': [{'joint': 'A', 'torque': '1', 'stall': -1, 'free_speed': 1}]", "greater than 0");
    refused("'cylinders': [{'links': ['ground', 'wheel'], 'at': [[1, 0], [0.1, 0]], 'bore': 0.1, 'retracted': 0.5, "
            "'stroke': 0.2, 'dead_volume': 1e-3}]", "not within");
    refused("'cylinders': [{'links': ['ground', 'wheel'], 'at': [[1, 0], [0.1, 0]], 'bore': 0.1, 'retracted': 0.8, "
            "'stroke': 0.2, 'dead_volume': 1e-3, 'valve': 1}]", "\"flow\"");
}

/* What cannot integrate states says so. */
TEST(others_refuse)
{
    static const lw_formulation cannot[] = { LW_FORMULATION_DRIVEN, LW_FORMULATION_QUADRATURE, LW_FORMULATION_REDUCED };
    lw_dynamics *made = NULL;
    read_wheel(wheel, 1, "'input': {'joint': 'A', 'speed': 0}, 'states': [{'name': 'a', 'rate': '1'}]");
    for (int i = 0; i < 3; i++) {
        d.o.formulation = cannot[i];
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_E_KIND);
        CHECK_HAS(d.e.text, "first-order state");
    }
    d.o.formulation = LW_FORMULATION_AUTO;
    for (lw_analysis a = LW_ANALYSIS_STATIC; a <= LW_ANALYSIS_KINEMATIC; a++) {
        d.o.analysis = a;
        CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_E_KIND);
        CHECK_HAS(d.e.text, "\"a\"");
    }
}

/* A force that a lag of 0.1 s raises from -1 to 3 N lifts 1 kg off its rigid stop at ln(4/3)/10 s; from there on a = 3 - 4 exp(-10 t). */
TEST(a_state_lifts_off_a_stop)
{
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE };
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 0.1}], 'states': [{'name': 'u',"
        "'rate': '-10*state(u) + 10', 'start': 0}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0],"
        "'stop': {'least': 0}}], 'forces': [{'link': 'a', 'at': [0, 0], 'fx': '-1 + 4*state(u)'}]}", 0, 0);
    double t0 = log(4.0/3)/10, v = 3*(0.5 - t0) + 0.4*(exp(-5) - exp(-10*t0));
    for (int f = 0; f < 3; f++)
        for (double tolerance = 1e-6; tolerance > 1e-13; tolerance *= 1e-2) {
            CHECK_INT(drun_to(&d, each[f], tolerance, 0.5, 5), LW_OK);
            CHECK_NEAR(d.v[0]*d.system.unit, v, (f == 2 ? 100 : 10)*tolerance, 0);
        }
}

/* A mass of 1 rests on its stop, where no force presses at 0 s.  What pushes it in later leaves it there; what pulls takes it away:
 * 2 t - sin(8 t) at its root t0, and then x = (t^3 - t0^3)/3 + (sin 8t - sin 8t0)/64 - (t - t0)(t0^2 + cos(8 t0)/8).  Its weight stands across
 * the slide, so that accelerations are rounding, not 0. */
TEST(pushed_against_a_stop_from_rest)
{
    double t0 = 0.3, x0;
    for (int k = 0; k < 20; k++)
        t0 -= (2*t0 - sin(8*t0))/(2 - 8*cos(8*t0));
    x0 = (1 - t0*t0*t0)/3 + (sin(8) - sin(8*t0))/64 - (1 - t0)*(t0*t0 + cos(8*t0)/8);
    const struct { const char *force; double end; } push[] = {
        { "cos(10*t) - 1", 0 }, { "-2*t", 0 }, { "-5*sin(t)^3", 0 }, { "2*t", 1.0/3 }, { "2*t^2", 1.0/6 }, { "2*t - sin(8*t)", x0 },
        { "-3*max(t - 0.3, 0)", 0 }, { "3*max(t - 0.3, 0)", 0.5*0.343 },
    };
    for (int k = 0; k < (int)(sizeof push/sizeof *push); k++) {
        char text[1000];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 0.1}], 'gravity': [-8, 6],"
            "'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], 'along': [0.6, 0.8], 'stop': {'least': 0, 'greatest': 9,"
            "'restitution': 0.5}}], 'forces': [{'link': 'a', 'at': [0, 0], 'fx': '0.6*(%s)', 'fy': '0.8*(%s)'}]}", push[k].force, push[k].force);
        drun_read_format(&d, text, 0, 0);
        for (double tolerance = 1e-6; tolerance > 1e-11; tolerance *= 1e-2)
            for (int f = 0; f < 2; f++) {
                CHECK_INT(drun_to(&d, f ? LW_FORMULATION_CVODE : LW_FORMULATION_INDEX1, tolerance, 1, 5), LW_OK);
                CHECK_NEAR(d.q[0]*d.system.unit, 0.6*push[k].end, (f ? 100 : 10)*tolerance, 0);
                CHECK_NEAR(d.q[1]*d.system.unit, 0.8*push[k].end, (f ? 100 : 10)*tolerance, 0);
            }
    }
}

/* Three equal blocks that touch by their stops, and a fourth that strikes them: without loss the far block alone goes on, with its speed. */
TEST(blocks_that_touch_are_struck_one_after_the_other)
{
    char text[3000];
    int n = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
    for (int i = 0; i < 4; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': 'b%d', 'mass': 1, 'centre': [%g, 0], 'inertia': 1, 'velocity': [%d, 0], 'omega': 0}",
                      i, i < 3 ? 0.2*i : 1.3, i < 3 ? 0 : -2);
    static const char *to[] = { "ground", "b0", "b1", "b2" };
    for (int i = 0; i < 4; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "%s{'name': 'S%d', 'kind': 't', 'links': ['%s', 'b%d'], 'at': [0, 0], 'along': [1, 0]%s}",
                      i ? ", " : "], 'joints': [", i, to[i], i, i == 0 ? "" : i < 3 ? ", 'stop': {'least': 0, 'restitution': 1}"
                      : ", 'stop': {'least': -0.7, 'restitution': 1}");
    snprintf(text + n, sizeof text - (size_t)n, "]}");
    drun_read_format(&d, text, 0, 0);
    for (int f = 0; f < 2; f++) {
        CHECK_INT(drun_to(&d, f ? LW_FORMULATION_CVODE : LW_FORMULATION_INDEX1, 1e-9, 1, 5), LW_OK);
        for (int i = 0; i < 4; i++) {
            CHECK_NEAR(d.q[3*i]*d.system.unit, i ? 0.2*i : -2*(1 - 0.35), 1e-7, 0);
            CHECK_NEAR(d.v[3*i]*d.system.unit, i ? 0 : -2, 1e-7, 0);
        }
    }
}

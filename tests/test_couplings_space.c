/* Couplings of turns and slides in space (gears, belts, ropes): closed forms, invariants, and references of their own equations. */
#include "tests/dynamics_run.h"
#include "tests/space_run.h"

static srun k;

static lw_formulation formulation = LW_FORMULATION_AUTO;

static lw_dynamics_report run(const lw_spatial *m, lw_analysis a, double to, int intervals, double tolerance)
{
    return srun_by(m, formulation, a, to, intervals, tolerance, &k);
}

static const lw_formulation in_time[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE,
                                          LW_FORMULATION_GGL, LW_FORMULATION_RADAU };

/* Two belts on a bridge and a carriage: r a = x + y, r b = x - y, so the torques are r/2 (Fx +- Fy) and those of the pulleys. */
TEST(a_gantry_on_two_belts)
{
    static const double r = 0.008, head = 0.4, both = 1.6, pulley = 8e-5;
    OWN(lw_spatial) m = { 0 };
    load_spatial("corexy", &m);
    CHECK_OK(lw_spatial_set_motion(&m, 0, "0.1*sin(5*t)", &check_error));
    CHECK_OK(lw_spatial_set_motion(&m, 1, "0.2*t^2 - 0.05*t", &check_error));
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, 1e-10);
    CHECK_INT(q.formulation, LW_FORMULATION_DRIVEN);
    for (int i = 0; i < k.n; i++) {
        double t = k.at[i].t, ax = -2.5*sin(5*t), ay = 0.4;
        for (int d = 0; d < 2; d++)
        {
            CHECK_NEAR(k.at[i].drive[d], r/2*(head*ax + (d ? -1 : 1)*both*ay) + pulley*(ax + (d ? -ay : ay))/r, 1e-12, 1e-10);
            CHECK_NEAR(k.at[i].coupling[d], -(head*ax + (d ? -1 : 1)*both*ay)/2, 1e-12, 1e-10);      /* forces of the belts */
        }
        double x = 0.1*sin(5*t), y = 0.2*t*t - 0.05*t;
        for (int d = 0; d < 2; d++) {        /* the pulleys turn about z: a quaternion of half the angle, several turns */
            double turn = (x + (d ? -y : y))/r;
            CHECK_NEAR(fabs(k.at[i].q[7*d + 3]), fabs(cos(turn/2)), 1e-11, 0);
            CHECK_NEAR(k.at[i].q[7*d + 3]*k.at[i].q[7*d + 6], 0.5*sin(turn), 1e-11, 0);
        }
    }
}

/* Bevel differential under constant torques: the rates of cage and wheels have constant accelerations, in all formulations. */
TEST(a_differential_under_torques)
{
    static const double cage = 0.02 + 2*0.002 + 1e-4 + 0.3*0.05*0.05, wheels = 2*0.002 + 2e-4*23*23/(17.*17);
    for (size_t f = 0; f < sizeof in_time/sizeof *in_time; f++) {
        OWN(lw_spatial) m = { 0 };
        load_spatial("differential", &m);
        formulation = in_time[f];
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 4, 1e-9);
        double allowed = f == 2 || f == 3 ? 2e-5 : 2e-8;          /* errors of BDF methods add up */
        CHECK_INT(q.formulation, formulation);
        CHECK_INT(q.freedom, 2);
        CHECK_INT(q.redundant, 0);
        CHECK(k.off < 1e-12 && k.off_rate < 1e-10);
        for (int i = 0; i < k.n; i++) {
            double t = k.at[i].t, c = 30*t + 0.15/cage*t*t, l = 11*t - 0.35/wheels*t*t;
            CHECK_NEAR(k.at[i].input, c, allowed, 0);
            CHECK_NEAR(k.at[i].input_rate, 30 + 0.3/cage*t, allowed, 0);
            for (int w = 0; w < 2; w++) {    /* half the angle of a wheel from its quaternion, whose sign is free */
                const double *p = k.at[i].q + 7*(w + 1) + 3;
                CHECK_NEAR(p[0]*p[1], 0.5*sin(c + (w ? -l : l)), allowed, 0);
                CHECK_NEAR(p[0]*p[0], 0.5 + 0.5*cos(c + (w ? -l : l)), allowed, 0);
            }
        }
        CHECK(q.energy_error < allowed*q.energy_scale);
    }
    formulation = LW_FORMULATION_RECURSIVE;          /* quadratic polynomials have no error: only the count of turns limits the steps */
    for (int p = 3; p <= 12; p++) {
        OWN(lw_spatial) m = { 0 };
        load_spatial("differential", &m);
        run(&m, LW_ANALYSIS_TRANSIENT, 1, 4, pow(10, -p));
        for (int i = 0; i < k.n; i++)
            CHECK_NEAR(k.at[i].input, 30*k.at[i].t + 0.15/cage*k.at[i].t*k.at[i].t, 1e-9, 0);
    }
    formulation = LW_FORMULATION_AUTO;
}

/* A tendon along five links whose hinges lie across each other: the sum of lever arms times turns stays 0.  Places and forces of an
 * independent model in the angles of the hinges (Lagrange's equations with a multiplier, Dormand & Prince's method of order 8). */
TEST(a_tendon_over_five_joints)
{
    static const double lever[] = { 0.02, -0.03, 0.025, 0.04, -0.015 }, pull[] = { 18.563268453, 40.510545188, 106.16125986 };
    static const lw_vec3 tip[] = { { 1.5, 0.5, 0.2 }, { 1.41677894668, 0.31995187642, -0.44587317 },
                                   { -0.19582001603, -0.02058057489, -0.99425899147 } };
    char text[4000], *at = text;
    lw_vec3 p = { 0, 0, 0 }, step;
    at += sprintf(at, "{'linkwright': 1, 'links': ['ground'");
    for (int i = 0; i < 5; i++, p = lw_v3_add(p, step)) {
        step = lw_v3(0.3, 0.05*i, 0.1*(i%2));
        at += sprintf(at, ", {'name': 'l%d', 'mass': %.17g, 'centre': [%.17g, %.17g, %.17g], 'inertia': [0.01, 0.012, 0.013]}", i, 1 - 0.1*i,
                      p.x + step.x/2, p.y + step.y/2, p.z + step.z/2);
    }
    at += sprintf(at, "], 'joints': [");
    for (int i = 0; i < 5; i++) {
        at += sprintf(at, "%s{'name': 'J%d', 'links': ['", i ? ", " : "", i);
        at += i ? sprintf(at, "l%d", i - 1) : sprintf(at, "ground");
        at += sprintf(at, "', 'l%d'], 'at': [%.17g, %.17g, %.17g], 'axis': [0, %d, %d]}", i, 0.3*i, 0.025*i*(i - 1), 0.1*(i/2), i%2, 1 - i%2);
    }
    at += sprintf(at, "], 'couplings': [{'name': 'tendon', 'terms': [");
    for (int i = 0; i < 5; i++)
        at += sprintf(at, "%s{'joint': 'J%d', 'factor': %g}", i ? ", " : "", i, lever[i]);
    sprintf(at, "]}], 'gravity': [0, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'l4', 'at': [1.5, 0.5, 0.2]}]}");
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "tendon", &m);
    for (size_t f = 0; f < sizeof in_time/sizeof *in_time; f++) {
        formulation = in_time[f];
        double allowed = f == 2 || f == 3 ? 1e-6 : 2e-9;          /* errors of BDF methods add up */
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 0.6, 2, 1e-9);
        CHECK_INT(q.formulation, formulation);
        CHECK_INT(q.freedom, 4);
        CHECK_INT(q.redundant, 0);
        CHECK(k.off < 1e-12);
        for (int i = 0; i < k.n; i++) {
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(k.at[i].tracer[0], tip[i])), 0, allowed, 0);
            CHECK_NEAR(k.at[i].coupling[0], pull[i], 0, 1e4*allowed);
        }
    }
    formulation = LW_FORMULATION_AUTO;
}

/* A ratio that no teeth have, over hundreds of turns, driven and free: the second wheel is where the first one says. */
TEST(couplings_count_turns)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}, {'name': 'b', "
        "'mass': 1, 'centre': [1, 0, 0], 'inertia': [1, 2, 2]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, "
        "{'name': 'B', 'links': ['ground', 'b'], 'at': [1, 0, 0], 'axis': [0, 1, 0]}], 'couplings': [{'name': 'belt', 'terms': [{'joint': 'A', 'factor': "
        "0.73714159}, {'joint': 'B', 'factor': 1}]}], 'input': {'joint': 'A', 'speed': 200}}";
    for (int way = 0; way < 3; way++) {
        OWN(lw_spatial) m = { 0 };
        read_spatial(text, "belt", &m);
        formulation = way == 1 ? LW_FORMULATION_INDEX1 : LW_FORMULATION_AUTO;
        if (way == 2)
            CHECK_OK(lw_spatial_set_motion(&m, 0, "200*t", &check_error));
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 10, 5, 1e-11);
        CHECK_INT(q.formulation, way == 0 ? LW_FORMULATION_RECURSIVE : way == 1 ? LW_FORMULATION_INDEX1 : LW_FORMULATION_DRIVEN);
        for (int i = 0; i < k.n; i++) {
            double turn = -0.73714159*200*k.at[i].t;
            const double *p = k.at[i].q + 7 + 3;
            CHECK_NEAR(k.at[i].input, 200*k.at[i].t, 1e-8, 0);
            CHECK_NEAR(p[0]*p[2], 0.5*sin(turn), 1e-8, 0);
            CHECK_NEAR(p[0]*p[0], 0.5 + 0.5*cos(turn), 1e-8, 0);
        }
    }
    formulation = LW_FORMULATION_AUTO;
}

/* A hook on a rope whose length a winch changes, l = 6 + 0.3 a: (J + m l^2) f'' = -m g l sin f - 2 m l l' f'. */
static double rope_at(double t, double *rate, double *second)
{
    *rate = 0.3*2*0.7*cos(0.7*t);
    *second = -0.3*2*0.7*0.7*sin(0.7*t);
    return 6 + 0.3*2*sin(0.7*t);
}

static lw_status hook_rate(void *context, double t, const double *y, double *dy)
{
    double dl, ddl, l = rope_at(t, &dl, &ddl);
    (void)context;
    dy[0] = y[1];
    dy[1] = -(800*9.81*l*sin(y[0]) + 2*800*l*dl*y[1])/(30 + 0.5 + 800*l*l);
    return LW_OK;
}

TEST(a_hook_on_a_winch)
{
    static const double angle = 0.3;
    char text[2000];
    double x = sin(angle), z = -cos(angle);
    OWN(lw_spatial) m = { 0 };
    snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground', {'name': 'drum', 'mass': 50, 'centre': [0, 1, 0], 'inertia': "
        "[2, 3, 2]}, {'name': 'rope', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [0.5, 0.5, 0.5]}, {'name': 'hook', 'mass': 800, 'centre': [%.17g, 0, %.17g], "
        "'inertia': [30, 30, 30]}], 'joints': [{'name': 'winch', 'links': ['ground', 'drum'], 'at': [0, 1, 0], 'axis': [0, 1, 0]}, {'name': 'head', 'kind': "
        "'universal', 'links': ['ground', 'rope'], 'at': [0, 0, 0], 'axis': [0, 1, 0], 'second_axis': [%.17g, 0, %.17g]}, {'name': 'hoist', 'kind': 'prismatic', "
        "'links': ['rope', 'hook'], 'at': [%.17g, 0, %.17g], 'axis': [%.17g, 0, %.17g]}], 'couplings': [{'name': 'reel', 'terms': [{'joint': 'winch', 'factor': 0.3}, "
        "{'joint': 'hoist', 'factor': -1}]}], 'input': {'joint': 'winch', 'motion': '2*sin(0.7*t)'}, 'tracers': [{'name': 'H', 'link': 'hook', 'at': [%.17g, 0, %.17g]}]}",
        6*x, 6*z, -z, x, x, z, x, z, 6*x, 6*z);
    read_spatial(text, "winch", &m);
    for (size_t f = 0; f < sizeof in_time/sizeof *in_time; f++) {
        bool bdf = in_time[f] == LW_FORMULATION_CVODE || in_time[f] == LW_FORMULATION_GGL;
        double y[2] = { angle, 0 }, dl, ddl, dy[2], allowed = bdf ? 1e-4 : 1e-7;
        formulation = in_time[f];
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 6, 3, 1e-9);
        CHECK_INT(q.formulation, formulation);
        CHECK_INT(q.freedom - 1, 2);         /* swings both ways, and the winch */
        for (int i = 1; i < k.n; i++) {
            drun_exact(&(lw_ode){ .n = 2, .rate = hook_rate }, k.at[i - 1].t, y, k.at[i].t);
            double l = rope_at(k.at[i].t, &dl, &ddl), pull = 800*(9.81*cos(y[0]) + l*y[1]*y[1] - ddl);
            hook_rate(NULL, k.at[i].t, y, dy);
            CHECK_NEAR(k.at[i].tracer[0].x, l*sin(y[0]), allowed, 0);
            CHECK_NEAR(k.at[i].tracer[0].z, -l*cos(y[0]), allowed, 0);
            CHECK_NEAR(k.at[i].drive[0], 3*ddl/0.3 - 0.3*pull, 0, f < 2 ? 1e-9 : 1e-5);     /* implicit: of stages */
            CHECK_NEAR(k.at[i].coupling[0], pull, 0, f < 2 ? 1e-9 : 1e-5);
        }
    }
    formulation = LW_FORMULATION_AUTO;
    lw_dynamics_report at_rest = run(&m, LW_ANALYSIS_STATIC, 1, 1, 1e-10);
    CHECK(at_rest.steps > 0 && k.n == 1);
    CHECK_NEAR(k.at[0].tracer[0].x, 0, 1e-9, 0);
    CHECK_NEAR(k.at[0].tracer[0].z, -6, 1e-9, 0);
    CHECK_NEAR(k.at[0].drive[0], -0.3*800*9.81, 1e-5, 0);
    CHECK_NEAR(k.at[0].coupling[0], 800*9.81, 1e-4, 0);
}

/* A load on a massless elastic rope whose free length is 5 - 0.25 t^2, from the end of a jib that turns by 0.1 t^2. */
static lw_status crane_rate(void *context, double t, const double *y, double *dy)
{
    double turn = 0.1*t*t, c = cos(turn), s = sin(turn);
    lw_vec3 arm = lw_v3_sub(lw_v3(y[0], y[1], y[2]), lw_v3(6*c, 6*s, 8)), rate = lw_v3_sub(lw_v3(y[3], y[4], y[5]), lw_v3(-1.2*t*s, 1.2*t*c, 0));
    double length = lw_v3_norm(arm);
    double pull = 8e5*(length - 5 + 0.25*t*t + 0.00981) + 4e3*(lw_v3_dot(arm, rate)/length + 0.5*t);
    if (context)
        *(double *)context = pull;
    memcpy(dy, y + 3, 3*sizeof *dy);
    dy[3] = -pull*arm.x/length/800, dy[4] = -pull*arm.y/length/800, dy[5] = -pull*arm.z/length/800 - 9.81;
    return LW_OK;
}

TEST(a_crane_turns_and_hoists)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("crane", &m);
    for (int i = 3; i <= 5; i++) {           /* rope and block become massless beside the load, and the load a point */
        m.body[i].mass = i < 5 ? 1e-4 : 800;
        for (int c = 0; c < 3; c++)
            m.body[i].inertia[c] = 1e-4;
    }
    CHECK_OK(lw_spatial_set_motion(&m, 0, "0.1*t^2", &check_error));
    CHECK_OK(lw_spatial_set_motion(&m, 1, "t^2", &check_error));
    double y[6] = { 6, 0, 3 }, dy[6], pull;
    run(&m, LW_ANALYSIS_TRANSIENT, 3, 6, 1e-10);
    for (int i = 1; i < k.n; i++) {
        drun_exact(&(lw_ode){ .n = 6, .rate = crane_rate }, k.at[i - 1].t, y, k.at[i].t);
        crane_rate(&pull, k.at[i].t, y, dy);
        CHECK(lw_v3_norm(lw_v3_sub(k.at[i].tracer[0], lw_v3(y[0], y[1], y[2]))) < 1e-6);
        CHECK_NEAR(k.at[i].coupling[0], pull, 0, 1e-5);
        CHECK_NEAR(k.at[i].drive[1], 7*2 + 0.25*pull, 0, 1e-5);
    }
}

/* A rack pulls its slide along the joint's axis, as a drive would: the joint carries what the mass beside the axis adds, whether the
 * wheel is driven or the slide. */
TEST(a_coupling_pulls_along_the_axis_of_the_slide)
{
    static const char *const driven[] = { "'D', 'motion': 't^2'", "'S', 'motion': '0.5*t^2'" };
    for (int i = 0; i < 2; i++) {
        char text[1200];
        OWN(lw_spatial) m = { 0 };
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'd', 'mass': 1, 'centre': [0, 0, 1], 'inertia': [1, 1, 1]}, {'name': 'c', "
            "'mass': 2, 'centre': [0, 0.5, 0.3], 'inertia': [1, 2, 2.5], 'frame': {'x': [3, 4, 0], 'y': [-4, 3, 0]}}], 'joints': [{'name': 'D', 'links': "
            "['ground', 'd'], 'at': [0, 0, 1], 'axis': [0, 0, 1]}, {'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'c'], 'at': [0, 0, 0], 'axis': "
            "[1, 0, 0]}], 'couplings': [{'name': 'rack', 'terms': [{'joint': 'D', 'factor': 0.5}, {'joint': 'S', 'factor': -1}]}], 'input': {'joint': %s}}",
            driven[i]);
        read_spatial(text, "rack", &m);
        run(&m, LW_ANALYSIS_TRANSIENT, 1, 2, 1e-10);
        for (int n = 0; n < k.n; n++) {      /* 2 kg at 1 m/s^2; the wheel at 2 rad/s^2 */
            CHECK_NEAR(k.at[n].drive[0], i ? 6 : 3, 1e-12, 0);
            CHECK_NEAR(k.at[n].coupling[0], i ? 4 : -2, 1e-12, 0);
            CHECK(lw_v3_norm(lw_v3_sub(k.at[n].joint[1].moment, lw_v3(0, 0.6, -1))) < 1e-12);
            CHECK(lw_v3_norm(k.at[n].joint[1].force) < 1e-12);
        }
    }
}

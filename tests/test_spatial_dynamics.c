/* Spatial models in time: reference values worked out by independent prototypes (published problems of IFToMM's
 * library of benchmarks, Euler's free body, the heavy top, a DELTA robot), invariants, a planar model written in
 * space. */
#include "mbs/equilibrium/modes.h"
#include "tests/space_run.h"

OWNS(lw_dynamics)

static srun k;

static lw_formulation formulation = LW_FORMULATION_AUTO;

static lw_dynamics_report run(const lw_spatial *m, lw_analysis a, double to, int intervals, double tolerance)
{
    return srun_by(m, formulation, a, to, intervals, tolerance, &k);
}

/* ---- free bodies ------------------------------------------------------------------------------------------------ */

/* Euler's equations, I = (1, 2, 3), w0 = (1, 0, 1): elliptic functions to 8 digits. */
TEST(a_free_body_tumbles)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [1, 2, 3], 'inertia': [1, 2, 3], "
                               "'angular_velocity': [1, 0, 1], 'velocity': [1, 2, -1]}], 'joints': [{'name': 'F', 'kind': 'free', 'links': ['ground', "
                               "'a'], 'at': [0, 0, 0]}]}";
    static const double want[3][4] = { { 1, .57780247, .81617664, .88201582 }, { 5, -.16435043, -.98640202, .82199170 },
                                       { 10, -.92107000, .38939704, .97440066 } };
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "free", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 10, 10, 1e-13);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(k.at[(int)want[i][0]].v[3 + c], want[i][1 + c], 1e-8, 0);
    for (int i = 0; i < k.n; i++) {
        const double *w = k.at[i].v + 3;
        CHECK_NEAR(w[0]*w[0] + 2*w[1]*w[1] + 3*w[2]*w[2], 4, 1e-13*4, 0);
        CHECK_NEAR(w[0]*w[0] + 4*w[1]*w[1] + 9*w[2]*w[2], 10, 1e-13*10, 0);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(k.at[i].angular, k.at[0].angular)), 0, 1e-12, 0);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(k.at[i].linear, k.at[0].linear)), 0, 1e-12, 0);
    }
    CHECK_INT(q.freedom, 6);
}

/* Spinning about its middle axis is unstable: it turns over again and again, and keeps energy and momentum. */
TEST(a_body_turns_over)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 2, 2.9], "
                               "'angular_velocity': [1e-4, 6, 0]}], 'joints': [{'name': 'F', 'kind': 'free', 'links': ['ground', 'a'], 'at': [0, 0, 0]}]}";
    OWN(lw_spatial) m = { 0 };
    double least = 6;
    read_spatial(text, "free", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 100, 1000, 1e-10);
    for (int i = 0; i < k.n; i++) {
        least = fmin(least, k.at[i].v[4]);
        CHECK_NEAR(lw_v3_norm(lw_v3_sub(k.at[i].angular, k.at[0].angular)), 0, 1e-12, 0);
    }
    CHECK(least < -5.99);
    CHECK(q.energy_error < 1e-9*q.energy_scale);
}

/* At the default tolerance: Euler's equations of a body about its middle axis by the classical Runge-Kutta method, where an error of
 * energy or momentum of 1e-10 brings the next somersault at another time; momenta and energy over 100 s. */
TEST(free_bodies_keep_momenta)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': "
        "[1, 2, 2.5], 'angular_velocity': [0.001, 5, 0], 'velocity': [1, 2, 3]}], 'joints': [{'name': 'F', 'kind': 'free', "
        "'links': ['ground', 'a'], 'at': [0, 0, 0]}]}";
    static const char two[] = "{'linkwright': 1, 'gravity': [0, 1, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': "
        "[1, 2, 2.5], 'angular_velocity': [0.3, 2, 0.1]}, {'name': 'b', 'mass': 2, 'centre': [1, 0.2, 0], 'inertia': [0.1, 0.2, 0.25]}], 'joints': "
        "[{'name': 'F', 'kind': 'free', 'links': ['ground', 'a'], 'at': [0, 0, 0]}, {'name': 'U', 'kind': 'universal', 'links': ['a', 'b'], 'at': [0.5, "
        "0, 0], 'axis': [0, 1, 0], 'second_axis': [0, 0, 1]}], 'springs': [{'links': ['a', 'b'], 'at': [[0, 1, 0], [1, 1, 0]], 'stiffness': 5}]}";
    static const lw_formulation how[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1 };
    const double inertia[3] = { 1, 2, 2.5 }, h = 1e-4;
    double w[3] = { 0.001, 5, 0 };
    for (int step = 0; step < 200000; step++) {
        double slope[5][3] = { { 0 } }, at[3];
        for (int i = 0; i < 4; i++) {
            for (int c = 0; c < 3; c++)
                at[c] = w[c] + (i == 0 ? 0 : i == 3 ? 1 : 0.5)*h*slope[i][c];
            for (int c = 0; c < 3; c++)
                slope[i + 1][c] = (inertia[(c + 1)%3] - inertia[(c + 2)%3])/inertia[c]*at[(c + 1)%3]*at[(c + 2)%3];
        }
        for (int c = 0; c < 3; c++)
            w[c] += h*(slope[1][c] + 2*slope[2][c] + 2*slope[3][c] + slope[4][c])/6;
    }
    for (int i = 0; i < 2; i++) {
        lw_spatial m;
        formulation = how[i];
        read_spatial(text, "middle", &m);
        run(&m, LW_ANALYSIS_TRANSIENT, 20, 10, 1e-10);
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(k.at[10].v[3 + c], w[c], 1e-7, 0);
        for (int pass = 0; pass < 2; pass++) {
            lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 100, 100, 1e-10);
            double mass = pass ? 3 : 1;
            CHECK_INT(q.formulation, how[i]);
            CHECK(q.energy_error < 1e-12*q.energy_scale);
            for (int j = 1; j <= 100; j++) {             /* those about the centre, which the momentum moves */
                lw_vec3 pull = lw_v3_scale(m.gravity, mass*k.at[j].t), p = k.at[j].linear;
                CHECK_NEAR(lw_v3_norm(lw_v3_sub(lw_v3_sub(p, pull), k.at[0].linear)), 0, 1e-12*fmax(1, lw_v3_norm(p)), 0);
                lw_vec3 fallen = lw_v3_scale(m.gravity, k.at[j].t*k.at[j].t/2);
                lw_vec3 centre = lw_v3_add(lw_v3_scale(lw_v3_scale(k.at[0].linear, 1/mass), k.at[j].t), fallen);
                lw_vec3 start = lw_v3(pass ? 2.0/3 : 0, pass ? 0.4/3 : 0, 0);
                lw_vec3 about = lw_v3_sub(k.at[j].angular, lw_v3_cross(lw_v3_add(start, centre), p));
                about = lw_v3_sub(about, lw_v3_sub(k.at[0].angular, lw_v3_cross(start, k.at[0].linear)));
                CHECK_NEAR(lw_v3_norm(about), 0, 1e-12*fmax(1, lw_v3_norm(centre)*lw_v3_norm(p)), 0);
            }
            lw_spatial_free(&m);
            read_spatial(two, "two", &m);
        }
        lw_spatial_free(&m);
    }
    formulation = LW_FORMULATION_AUTO;
}

/* Steady precession of the symmetric heavy top, I1 .05, I3 .02, m g l 2, 30 degrees, spin 60: 1.78114338 rad/s, over
 * 100 turns. */
TEST(the_top_precesses)
{
    static const double precession = 1.78114338;
    OWN(lw_spatial) m = { 0 };
    load_spatial("top", &m);
    double turn = 2*LW_PI/precession;
    run(&m, LW_ANALYSIS_TRANSIENT, 100*turn, 400, 1e-12);
    for (int i = 0; i < k.n; i++)
        CHECK_NEAR(k.at[i].tracer[0].z, .2*cos(LW_PI/6), 1e-9, 0);
    double angle = atan2(k.at[1].tracer[0].y, k.at[1].tracer[0].x);       /* a quarter of a turn */
    CHECK_NEAR(angle/(turn/4), precession, 1e-8, 0);
}

/* A cart is driven with 1 m/s from 0.5 s on, at once: the rod of 1 kg that hangs on it by its end is pushed by 1/3 N s, turns by 2/3 rad/s and
 * swings back: theta'' = -g sin(theta)/1.5. */
TEST(drives_push_at_once)
{
    static const double angle = 0.2499712278;
    static const lw_formulation how[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1 };
    lw_spatial m;
    read_spatial("{'linkwright': 1, 'links': ['ground', {'name': 'cart', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}, {'name': 'rod', 'mass': 1, "
                 "'centre': [0, 0, -1], 'inertia': [0.5, 0.5, 0.1]}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'cart'], 'at': [0, 0, 0], "
                 "'axis': [1, 0, 0]}, {'name': 'A', 'links': ['cart', 'rod'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], 'gravity': [0, 0, -9.81], 'input': {'joint': 'S', "
                 "'motion': 'max(0, t - 0.5)'}, 'tracers': [{'name': 'P', 'link': 'rod', 'at': [0, 0, -1]}]}", "cart", &m);
    for (int i = 0; i < 2; i++) {
        formulation = how[i];
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 2, 1e-6);
        CHECK(q.energy_steps == 0);
        CHECK_NEAR(k.at[2].tracer[0].x, 0.5 - sin(angle), 1e-6, 0);
        CHECK_NEAR(k.at[2].tracer[0].z, -cos(angle), 1e-6, 0);
        CHECK_NEAR(k.at[1].work, 7./6, 1e-9, 0);             /* of the impulse: the rod begins to turn by -2/3 rad/s */
        CHECK_NEAR(k.at[2].energy, k.at[0].energy, 1e-5, 0);
    }
    formulation = LW_FORMULATION_AUTO;
    lw_spatial_free(&m);
}

/* ---- published mechanisms ---- */

TEST(slider_crank)
{
    static const double want[3][3] = { { 2, 1.230926918, .2605459327 }, { 5, -1.033286465, .1887481033 },
                                       { 10, -2.082296776, .2337647503 } };
    OWN(lw_spatial) m = { 0 };
    load_spatial("slider-crank", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, 1e-12);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(remainder(k.at[(int)want[i][0]].input - want[i][1], 2*LW_PI), 0, 1e-9, 0);
        CHECK_NEAR(k.at[(int)want[i][0]].tracer[0].x, want[i][2], 1e-10, 0);
    }
    CHECK(q.energy_error < 1e-11*q.energy_scale);
    CHECK(k.off < 1e-12 && k.off_rate < 1e-12*20);
}

TEST(bricard)
{
    static const double want[3][4] = { { 20, .999223645, -1.038649891, .960603202 }, { 50, .968283679, -1.224625159,
                                                                                       .750146609 },
                                       { 100, .510501461, -1.649167599, .140123115 } };
    OWN(lw_spatial) m = { 0 };
    load_spatial("bricard", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 10, 1000, 1e-12);
    for (int i = 0; i < 3; i++) {
        lw_vec3 p = k.at[(int)want[i][0]].tracer[0];
        CHECK_NEAR(p.x, want[i][1], 1e-9, 0);
        CHECK_NEAR(p.y, want[i][2], 1e-9, 0);
        CHECK_NEAR(p.z, want[i][3], 1e-9, 0);
    }
    CHECK_INT(q.redundant, 1);
    CHECK_INT(q.freedom, 1);
    CHECK(q.energy_error < 1e-9*q.energy_scale);
    CHECK(k.off < 1e-12);
}

/* Its stiff dampers ask for 4000 steps a second of the explicit method.  The implicit one errs less the less its tolerance is. */
TEST(governor)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("governor", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-11);
    CHECK_NEAR(k.at[1].tracer[0].z, .501420922, 1e-9, 0);
    CHECK_NEAR(k.at[1].input_rate, 6.271125742, 1e-9, 0);
    CHECK(q.energy_error < 1e-9*q.energy_scale);
    CHECK_NEAR(k.at[1].angular.z, k.at[0].angular.z, 1e-11, 0);
    q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-6);      /* by BDF methods in the coordinates of the joints */
    CHECK(q.formulation == LW_FORMULATION_RECURSIVE && q.steps < 400);
    CHECK_NEAR(k.at[1].tracer[0].z, .501420922, 1e-4, 0);
    q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-8);
    CHECK(q.formulation == LW_FORMULATION_RECURSIVE && q.steps < 1000);
    CHECK_NEAR(k.at[1].tracer[0].z, .501420922, 1e-8, 0);
    CHECK_NEAR(k.at[1].input_rate, 6.271125742, 1e-8, 0);
    formulation = LW_FORMULATION_RADAU;
    run(&m, LW_ANALYSIS_TRANSIENT, 10, 2, 1e-13);
    CHECK_NEAR(k.at[1].tracer[0].z, .535563104, 1e-9, 0);
    CHECK_NEAR(k.at[1].input_rate, 6.022496500, 1e-9, 0);
    CHECK_NEAR(k.at[2].tracer[0].z, .619622917, 1e-9, 0);
    CHECK_NEAR(k.at[2].input_rate, 5.548203623, 1e-9, 0);
    for (int i = 0; i < 4; i++) {                /* against the explicit method at 1e-13 */
        static const double error[] = { 1e-4, 3e-6, 1e-10, 5e-11 };
        run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, pow(10, -7 - 2*i));
        CHECK_NEAR(k.at[1].tracer[0].z, .5014209223795634, error[i], 0);
        CHECK_NEAR(k.at[1].input_rate, 6.27112574187658, error[i], 0);
    }
    formulation = LW_FORMULATION_AUTO;
}

/* Long runs of the conservative examples, at the tolerance that a user gets without asking. */
TEST(a_hundred_seconds_keep_energy)
{
    static const char *const file[] = { "bricard", "sarrus", "slider-crank", "top" };
    for (int i = 0; i < 4; i++) {
        OWN(lw_spatial) m = { 0 };
        load_spatial(file[i], &m);
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 100, 20, lw_dynamics_options_default().relative);
        CHECK(q.energy_error < 1e-9*q.energy_scale);
        CHECK(k.off < 1e-12);
    }
}

/* ---- DELTA ---- */

/* 400 mm along x through the middle in 100 ms at 160 m/s^2, bars as slender rods: torques at the start, their peaks and
 * mean squares; and at rest in the middle. */
TEST(delta_torques)
{
    double sum[2] = { 0, 0 }, peak[2] = { 0, 0 };
    OWN(lw_spatial) m = { 0 };
    load_spatial("delta", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, .1, 1000, 1e-10);
    CHECK_INT(q.formulation, LW_FORMULATION_DRIVEN);
    CHECK_INT(k.idle, 6);
    CHECK_NEAR(k.at[0].drive[0], -37.7817, 5e-5, 0);
    CHECK_NEAR(k.at[0].drive[1], 8.8914, 5e-5, 0);
    CHECK_NEAR(k.at[0].drive[2], 8.8914, 5e-5, 0);
    for (int i = 0; i < k.n; i++)
        for (int d = 0; d < 2; d++) {
            double tau = k.at[i].drive[d], middle = 0;
            for (int side = -1; i == 500 && side < 2; side += 2) {       /* the torque jumps: both sides from their samples */
                double limit = 3*k.at[i + side].drive[d] - 3*k.at[i + 2*side].drive[d] + k.at[i + 3*side].drive[d];
                middle += .5*limit*limit;
            }
            sum[d] += (i == 500 ? middle : tau*tau*(i == 0 || i == 1000 ? .5 : 1))/1000;
            peak[d] = fmax(peak[d], fabs(tau));
        }
    CHECK_NEAR(peak[0], 37.7817, 5e-5, 0);
    CHECK_NEAR(peak[1], 20.0403, 5e-5, 0);
    CHECK_NEAR(sqrt(sum[0]), 30.3835, 5e-5, 0);
    CHECK_NEAR(sqrt(sum[1]), 15.2444, 5e-5, 0);
    for (int i = 0; i < 3; i++) {
        char still[] = "0";
        CHECK_OK(lw_spatial_set_motion(&m, i, i < 2 ? still : "-0.65", &check_error));
    }
    run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-10);
    for (int d = 0; d < 3; d++)
        CHECK_NEAR(k.at[0].drive[d], -1.20166, 5e-6, 0);
    run(&m, LW_ANALYSIS_STATIC, 1, 1, 1e-10);
    for (int d = 0; d < 3; d++)
        CHECK_NEAR(k.at[0].drive[d], -1.20166, 5e-6, 0);
    run(&m, LW_ANALYSIS_QUASISTATIC, 1, 1, 1e-10);
    for (int d = 0; d < 3; d++)
        CHECK_NEAR(k.at[0].drive[d], -1.20166, 5e-6, 0);
}

/* Virtual power: the power of the drives is the rate of the energy, along a smooth motion of the Stewart platform. */
TEST(drives_do_the_work)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("stewart", &m);
    double work = 0;
    static double power[1001];
    run(&m, LW_ANALYSIS_KINEMATIC, 1, 1000, 1e-10);
    for (int i = 0; i < k.n; i++) {
        power[i] = 0;
        for (int d = 0; d < 6; d++)
            power[i] += k.at[i].drive[d]*.05*(d + 2)*cos((d + 2)*k.at[i].t);
    }
    for (int i = 0; i + 2 < k.n; i += 2)     /* Simpson's rule */
        work += (power[i] + 4*power[i + 1] + power[i + 2])/3000;
    CHECK_NEAR(work, k.at[1000].work, 1e-8, 0);
}

/* ---- a planar model in space ---- */

static flat_run flat;

TEST(a_planar_four_bar_in_space)
{
    static const char plane[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0.2], 'inertia': 0.02}, {'name': 'b', 'mass': "
                                "2, 'centre': [0.6, 0.5], 'inertia': 0.1}, {'name': 'c', 'mass': 1.5, 'centre': [1.1, 0.3], 'inertia': 0.05}], 'joints': "
                                "[{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.2, 0.4]}, {'name': "
                                "'C', 'links': ['b', 'c'], 'at': [1.2, 0.7]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0]}], 'input': {'joint': "
                                "'A', 'speed': 3}, 'gravity': [0, -9.81]}";
    static const char space[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0.2, 0], 'inertia': [0.015, 0.015, "
                                "0.02]}, {'name': 'b', 'mass': 2, 'centre': [0.6, 0.5, 0], 'inertia': [0.07, 0.06, 0.1]}, {'name': 'c', 'mass': 1.5, "
                                "'centre': [1.1, 0.3, 0], 'inertia': [0.03, 0.04, 0.05]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, "
                                "0, 0], 'axis': [0, 0, 1]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.2, 0.4, 0], 'axis': [0, 0, 1]}, {'name': 'C', "
                                "'links': ['b', 'c'], 'at': [1.2, 0.7, 0], 'axis': [0, 0, 1]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0, 0], "
                                "'axis': [0, 0, 1]}], 'input': {'joint': 'A', 'speed': 3}, 'gravity': [0, -9.81, 0]}";
    OWN(lw_spatial) m = { 0 };
    lw_model p;
    lw_vec3 normal;
    read_spatial(space, "space", &m);
    CHECK(lw_spatial_is_planar(&m, &normal));
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, 1e-13);
    CHECK_INT(q.redundant, 3);
    CHECK_HAS(q.why, "parallel");
    CHECK(!lw_spatial_text(plane, strlen(plane)));
    read_planar(plane, "plane", &p);
    flat_go(&p, 1, 10, 1e-13, &flat);
    for (int i = 0; i < k.n && i < flat.n; i++)
        CHECK_NEAR(remainder(k.at[i].input - (flat.turn[i] - flat.turn[0]), 2*LW_PI), 0, 1e-12, 0);
    /* the same from the spatial model, in its plane; then turned so that the plane is y, z, with a hinge the other way round */
    for (int turned = 0; turned < 2; turned++) {
        for (int i = 0; turned && i < m.n_link; i++) {
            double *t = m.body[i].inertia, yy = t[0], zz = t[1];
            t[0] = t[2], t[1] = yy, t[2] = zz;
            m.body[i].centre = lw_v3(0.3, m.body[i].centre.x, m.body[i].centre.y);
        }
        for (int j = 0; turned && j < m.n_joint; j++) {
            m.joint[j].at = lw_v3(0.1*j, m.joint[j].at.x, m.joint[j].at.y);
            m.joint[j].axis = lw_v3(j == 2 ? -1 : 1, 0, 0);
        }
        m.gravity = turned ? lw_v3(2, 0, -9.81) : m.gravity;
        CHECK_SILENT(lw_spatial_in_plane(&m, &p, &check_error));
        flat_go(&p, 1, 10, 1e-13, &flat);
        CHECK_INT(flat.n, 11);
        for (int i = 0; i < k.n && i < flat.n; i++)
            CHECK_NEAR(remainder(k.at[i].input - (flat.turn[i] - flat.turn[0]), 2*LW_PI), 0, 1e-12, 0);
    }
    lw_spatial_free(&m);
    load_spatial("bricard", &m);
    CHECK_FAILS(lw_spatial_in_plane(&m, &p, &check_error), LW_E_KIND, "parallel");
}

/* A slender rod has no inertia about itself.  On a pin across, or on a ball, which lets it spin, it swings at sqrt(3 g/(2 L)). */
TEST(modes_of_slender_rods)
{
    for (int ball = 0; ball < 2; ball++) {
        char text[400];
        OWN(lw_spatial) m = { 0 };
        lw_dynamics *d;
        OWN(lw_modes) modes = { 0 };
        lw_dynamics_options o = lw_dynamics_options_default();
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': 3, 'centre': [0, 0, -1], 'inertia': [1, 1, 0]}], 'joints': [{'name': 'A', "
                 "%s, 'links': ['ground', 'rod'], 'at': [0, 0, 0]}], 'gravity': [0, 0, -9.81]}", ball ? "'kind': 'b'" : "'axis': [0, 1, 0]");
        read_spatial(text, "rod", &m);
        o.analysis = LW_ANALYSIS_STATIC;
        CHECK_OK(lw_dynamics_make_spatial(&m, &o, &d, &check_error));
        CHECK_TEXT(lw_dynamics_massless(d) ? lw_dynamics_massless(d) : "", "");
        double q[64] = { 0 };
        lw_dynamics_start(d, q, q + lw_dynamics_space(d)->n_q);
        CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ .rest = false }, 3, 0, q, &modes, &check_error));
        CHECK_INT(modes.n_mode, 1 + ball);
        for (int i = 0; i < modes.n_mode; i++)
            CHECK_NEAR(modes.mode[i].frequency, sqrt(9.81*3/4)/(2*LW_PI), 0, 1e-12);
        lw_dynamics_free(d);
    }
}

/* A pendulum without inputs; its hinge turns against the normal, y, or names the ground second: a spring and a stop push there alike. */
TEST(a_pendulum_in_its_plane)
{
    for (int n = 0; n < 4; n++) {
        char text[800];
        OWN(lw_spatial) m = { 0 };
        lw_model p;
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.4, 0.1, 0.2], 'inertia': [0.03, 0.04, 0.05]}], 'joints': "
                 "[{'name': 'A', 'links': [%s], 'at': [0, 0, 0], 'axis': [0, %d, 0], 'stop': {'greatest': 1, 'stiffness': 500, 'damping': 3}}], 'springs': "
                 "[{'joint': 'A', 'stiffness': 6, 'damping': 0.1, 'free': 0.3}], 'gravity': [0, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'a', 'at': [0.5, 0, 0]}]}",
                 n < 2 ? "'a', 'ground'" : "'ground', 'a'", n % 2 ? -1 : 1);
        read_spatial(text, "pendulum", &m);
        run(&m, LW_ANALYSIS_TRANSIENT, 1.5, 10, 1e-12);
        CHECK_SILENT(lw_spatial_in_plane(&m, &p, &check_error));
        flat_go(&p, 1.5, 10, 1e-12, &flat);
        CHECK_INT(flat.n, 11);
        for (int i = 0; i < k.n && i < flat.n; i++)
            CHECK_NEAR(remainder(flat.turn[i] - flat.turn[0] - atan2(-k.at[i].tracer[0].z, k.at[i].tracer[0].x), 2*LW_PI), 0, 1e-9, 0);
    }
}

/* ---- accuracy, forces, hard cases ---- */

/* The greatest error of ten samples falls with the tolerance, down to 1e-11. */
TEST(errors_fall_with_the_tolerance)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("slider-crank", &m);
    run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, 1e-14);
    double best[11], before = 1;
    for (int i = 0; i <= 10; i++)
        best[i] = k.at[i].input;
    for (double tolerance = 1e-4; tolerance > 0.5e-12; tolerance *= 1e-2) {
        run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, tolerance);
        double error = 0;
        for (int i = 0; i <= 10; i++)
            error = fmax(error, fabs(k.at[i].input - best[i]));
        CHECK(error < before || error < 1e-11);
        CHECK(error < 2e3*tolerance);
        before = error;
    }
    CHECK(before < 1e-11);
}

/* A Sarrus linkage with a redundant row falls through four singular postures, where its legs lie flat; whatever the tolerance. */
TEST(through_singular_postures)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("sarrus", &m);
    for (int i = 6; i <= 10; i += 2) {
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 3, 1, pow(10, -i));
        CHECK_NEAR(k.at[1].tracer[0].z, 0.5859714770667, 5*pow(10, -i) + 1e-11, 0);
        CHECK(q.energy_error < 10*pow(10, -i)*q.energy_scale + 1e-13);
    }
}

/* Newton's law for each body: what its joints carry, and gravity, accelerate it; reactions at the two ends of a joint
 * are opposite.  In the slider-crank at t = 0.4, the ground carries the whole. */
TEST(reactions_carry_the_masses)
{
    OWN(lw_spatial) m = { 0 };
    load_spatial("slider-crank", &m);
    run(&m, LW_ANALYSIS_TRANSIENT, .4, 400, 1e-12);
    double size = lw_spatial_size(&m);
    /* linear momentum rate by differences = weight + reactions of A and D on the moving links (link 1 is the moving
     * one) */
    const srow *s = &k.at[100];
    double h = 1e-3;
    lw_vec3 rate = lw_v3_scale(lw_v3_sub(lw_v3_scale(lw_v3_sub(s[1].linear, s[-1].linear), 8), lw_v3_sub(s[2].linear,
            s[-2].linear)),
                               1/(12*h));
    lw_vec3 sum = lw_v3(0, 0, -9.81*(.12 + .5 + 2));
    sum = lw_v3_add(sum, lw_v3_add(s->joint[0].force, s->joint[3].force));
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(sum, rate)), 0, 1e-6*lw_v3_norm(sum), 0);
    /* angular momentum about the origin: moments about the joints' points, forces with their levers */
    lw_vec3 spin = lw_v3_scale(lw_v3_sub(lw_v3_scale(lw_v3_sub(s[1].angular, s[-1].angular), 8),
                                         lw_v3_sub(s[2].angular, s[-2].angular)), 1/(12*h));
    lw_vec3 moment = lw_v3_add(s->joint[0].moment, lw_v3_cross(m.joint[0].at, s->joint[0].force));
    moment = lw_v3_add(moment, lw_v3_add(s->joint[3].moment, lw_v3_cross(s->tracer[0], s->joint[3].force)));
    for (int b = 0; b < 3; b++)
        moment = lw_v3_add(moment, lw_v3_cross(lw_v3_scale(lw_v3(s->q[7*b], s->q[7*b + 1], s->q[7*b + 2]), size),
                                               lw_v3(0, 0, -9.81*m.body[b + 1].mass)));
    CHECK_NEAR(lw_v3_norm(lw_v3_sub(moment, spin)), 0, 1e-6*lw_v3_norm(moment), 0);
}

/* A thin rod has no inertia about its axis: solved by rank.  A conical pendulum of a rod on a universal joint: steady
 * at 3 g/(2 L cos a) = w^2 for a thin rod. */
TEST(a_thin_rod_swings)
{
    char text[1024];
    double a = 0.5, c = cos(a), s = sin(a), w = sqrt(3*9.81/(2*c));
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'cross', {'name': 'rod', 'mass': 1, 'centre': [%.17g, 0, %.17g], 'inertia': [0, "
                                "%.17g, %.17g], 'frame': {'x': [%.17g, 0, %.17g], 'y': [0, 1, 0]}}], 'joints': [{'name': 'A', 'links': ['ground', "
                                "'cross'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'B', 'links': ['cross', 'rod'], 'at': [0, 0, 0], 'axis': [0, 1, "
                                "0]}], 'inputs': [{'joint': 'A', 'speed': %.17g}, {'joint': 'B', 'speed': 0}], 'gravity': [0, 0, -9.81], 'tracers': "
                                "[{'name': 'P', 'link': 'rod', 'at': [%.17g, 0, %.17g]}]}",
             s/2, -c/2, 1./12, 1./12, s, -c, w, s, -c);
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "rod", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 5, 50, 1e-12);
    for (int i = 0; i < k.n; i++) {
        CHECK_NEAR(k.at[i].tracer[0].z, -c, 1e-9, 0);
        CHECK_NEAR(k.at[i].input, w*k.at[i].t, 1e-8, 0);
    }
    CHECK_HAS(q.why, "by rank");
}

/* The same rod on a ball, where nothing determines its spin: it is held, whatever the speeds of the file say about it. */
TEST(a_thin_rod_on_a_ball_swings)
{
    char text[1024];
    double a = 0.5, c = cos(a), s = sin(a), w = sqrt(3*9.81/(2*c));
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': 1, 'centre': [%.17g, 0, %.17g], 'inertia': [0, %.17g, %.17g], "
                                "'frame': {'x': [%.17g, 0, %.17g], 'y': [0, 1, 0]}, 'angular_velocity': [0, 0, %.17g]}], 'joints': [{'name': 'A', 'kind': 'b', "
                                "'links': ['ground', 'rod'], 'at': [0, 0, 0]}], 'gravity': [0, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'rod', "
                                "'at': [%.17g, 0, %.17g]}]}",
             s/2, -c/2, 1./12, 1./12, s, -c, w, s, -c);
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "rod", &m);
    run(&m, LW_ANALYSIS_TRANSIENT, 5, 50, 1e-12);
    CHECK_INT(k.idle, 1);
    for (int i = 0; i < k.n; i++) {
        CHECK_NEAR(k.at[i].tracer[0].x, s*cos(w*k.at[i].t), 1e-8, 0);
        CHECK_NEAR(k.at[i].tracer[0].y, s*sin(w*k.at[i].t), 1e-8, 0);
        CHECK_NEAR(k.at[i].tracer[0].z, -c, 1e-9, 0);
    }
}

/* A loop that goes through singular postures in every swing keeps its energy at loose tolerances too: steps behind quiet ones are
 * improved until they meet the equations.  Behind each posture it goes on in joints' coordinates, in which steps are long. */
TEST(swings_through_singular_postures)
{
    for (int i = 1; i <= 8; i += i < 4 ? 1 : 4) {
        OWN(lw_spatial) m = { 0 };
        load_spatial("sarrus", &m);
        formulation = LW_FORMULATION_RECURSIVE;
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 4, 1, pow(10, -i));
        CHECK(q.energy_error < pow(10, -i)*q.energy_scale);
        CHECK(q.steps < 200);
    }
    formulation = LW_FORMULATION_AUTO;
}

/* A pendulum that turns over fast: turns are counted, though the steps could be longer than a turn. */
TEST(a_flywheel_counts_its_turns)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [1e-3, 0, 0], "
        "'inertia': [1, 1, 1]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}], "
        "'inputs': [{'joint': 'A', 'speed': 200}], 'gravity': [0, -1e-3, 0]}";
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "flywheel", &m);
    formulation = LW_FORMULATION_RECURSIVE;
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 10, 5, 1e-10);
    formulation = LW_FORMULATION_AUTO;
    for (int i = 0; i < k.n; i++)
        CHECK_NEAR(k.at[i].input, 200*k.at[i].t, 1e-6, 0);
    CHECK(q.energy_error < 1e-12*q.energy_scale);
}

/* A mass thrown against a force c/(1 + q)^1.5 turns back before -1.  Trial steps lie behind, where the force is not a number. */
TEST(steps_behind_a_barrier)
{
    static const lw_formulation each[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1 };
    OWN(lw_spatial) m = { 0 };
    read_spatial("{'linkwright': 1, 'links': ['ground', {'name': 'm', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], 'joints': [{'name': 'S', "
                 "'kind': 'prismatic', 'links': ['ground', 'm'], 'at': [0, 0, 0], 'axis': [1, 0, 0]}], 'input': {'joint': 'S', 'speed': -3}, "
                 "'forces': [{'link': 'm', 'at': [0, 0, 0], 'fx': '1e-4/(1 + q(S))^1.5'}]}", "barrier", &m);
    for (int f = 0; f < 2; f++) {
        formulation = each[f];
        run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-4);
        CHECK_NEAR(k.at[1].input_rate, 3, 1e-3, 0);
    }
    formulation = LW_FORMULATION_AUTO;
}

/* Constant rates leave no change to measure convergence by: bodies that spin and slide freely are where their speed says, at any speed
 * and tolerance, after up to 16000 turns. */
TEST(free_flywheels_spin)
{
    static const char *const joint[] = { "'kind': 'revolute'", "'kind': 'cylindrical'", "'kind': 'universal', 'second_axis': [1, 0, 0]" };
    static const double speed[] = { 1, 100, 6283, 1e5, 1e6 }, tolerance[] = { 1e-3, 1e-10, 1e-14 };
    for (int i = 0; i < 3*5*3; i++) {
        const double w = speed[i/3%5], slide = i/15 == 1 ? 3 : 0;
        char text[512];
        OWN(lw_spatial) m = { 0 };
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [0.01, 0.01, 0.02], "
                 "'angular_velocity': [0, 0, %.17g], 'velocity': [0, 0, %g]}], 'joints': [{'name': 'A', %s, 'links': ['ground', 'a'], 'at': [0, 0, 0], "
                 "'axis': [0, 0, 1]}], 'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 0, 0]}]}", w, slide, joint[i/15]);
        read_spatial(text, "flywheel", &m);
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 0.1, 3, tolerance[i%3]);
        CHECK_INT(k.n, 4);
        for (int n = 0; n < k.n; n++) {
            double angle = w*k.at[n].t, off = 4e-16*angle + 1e-14;
            CHECK_NEAR(k.at[n].tracer[0].x, cos(angle), off, 0);
            CHECK_NEAR(k.at[n].tracer[0].y, sin(angle), off, 0);
            CHECK_NEAR(k.at[n].tracer[0].z, slide*k.at[n].t, 1e-13, 0);
        }
        CHECK(q.energy_error <= 1e-14*q.energy_scale);
    }
}

/* A bar between two balls that is not symmetric spins as it swings; a symmetric one does not, and its spin is held. */
TEST(spins_of_bars)
{
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        char text[1024];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5, 0], 'inertia': [0.1, 0.1, 0.1]}, "
                                    "{'name': 'bar', 'mass': 1, 'centre': [0.5, 1, 0], 'inertia': [0.02, %g, 0.09, 0, 0, 0]}, {'name': 'c', 'mass': 1, "
                                    "'centre': [1, 0.5, 0.2], 'inertia': [0.1, 0.1, 0.1]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, "
                                    "0, 0], 'axis': [0, 0.2, 1]}, {'name': 'B', 'kind': 'spherical', 'links': ['a', 'bar'], 'at': [0, 1, 0]}, {'name': "
                                    "'C', 'kind': 'spherical', 'links': ['bar', 'c'], 'at': [1, 1, 0]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, "
                                    "0, 0], 'axis': [0.3, 0, 1]}], 'input': {'joint': 'A', 'speed': 1}, 'gravity': [0, -9.81, "
                                    "0]}", symmetric ? 0.09 : 0.08);
        OWN(lw_spatial) m = { 0 };
        read_spatial(text, "bar", &m);
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, 1e-12);
        CHECK_INT(k.idle, symmetric);
        CHECK(q.energy_error < 1e-11*q.energy_scale);
        CHECK(symmetric ? fabs(k.at[10].v[6 + 3]) < 1e-10 : fabs(k.at[10].v[6 + 3]) > 1e-6);
    }
}

/* A chain of 80 bars, hinged in turn along y and z, falls from level: its end after 0.5 s as by MuJoCo 2.2.2 (RK4,
 * steps of 6e-5 and 1.2e-4 s, which agree to 4e-14 m). */
TEST(a_long_chain_falls)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    fputs("{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground'", f);
    for (int i = 1; i <= 80; i++)
        fprintf(f, ", {'name': 'b%d', 'mass': 0.1, 'centre': [%.17g, 0, 0], 'inertia': [2e-6, 1e-4, 1e-4]}",
                i,
                0.1*i - 0.05);
    fputs("], 'joints': [", f);
    for (int i = 1; i <= 80; i++) {
        char before[16] = "ground";
        if (i > 1)
            snprintf(before, sizeof before, "b%d", i - 1);
        fprintf(f, "%s{'name': 'J%d', 'links': ['%s', 'b%d'], 'at': [%.17g, 0, 0], 'axis': [0, %d, %d]}",
                i > 1 ? ", " : "", i, before, i, 0.1*(i - 1), i%2, 1 - i%2);
    }
    fputs("], 'tracers': [{'name': 'P', 'link': 'b80', 'at': [8, 0, 0]}]}", f);
    fclose(f);
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "chain", &m);
    free(text);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 0.5, 1, 1e-9);
    CHECK_INT(q.freedom, 80);
    CHECK_NEAR(k.at[1].tracer[0].x, 7.63247606906, 1e-11, 0);
    CHECK_NEAR(k.at[1].tracer[0].z, -1.22625, 1e-11, 0);
    CHECK(q.energy_error < 1e-9*q.energy_scale && k.off < 1e-12);
}

/* 100 turns against a torsion spring are counted: a flywheel winds it up and comes back after half a period. */
TEST(turns_are_counted)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], 'joints': "
                               "[{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [1, 2, 2]}], 'input': {'joint': 'A', 'speed': "
                               "628.3185307179587}, 'springs': [{'joint': 'A', 'stiffness': 1}]}";
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "wheel", &m);
    run(&m, LW_ANALYSIS_TRANSIENT, LW_PI, 2, 1e-12);
    CHECK_NEAR(k.at[1].input, 200*LW_PI, 1e-7, 0);
    CHECK_NEAR(k.at[2].input, 0, 1e-7, 0);
    CHECK_OK(lw_spatial_set_motion(&m, 0, "1 + 628.3185307179586*t", &check_error));
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 2, 1e-10);          /* driven, 50 turns from sample to srow */
    CHECK_INT(q.formulation, LW_FORMULATION_DRIVEN);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(k.at[i].input, 1 + 100*LW_PI*i, 1e-9, 0);
        CHECK_NEAR(k.at[i].drive[0], k.at[i].input, 1e-9, 0);                    /* holds the spring */
    }
    /* 6000 turns from sample to sample: rounding of the angle is above 1e-11 */
    CHECK_OK(lw_spatial_set_motion(&m, 0, "1 + 75398.22368615503*t", &check_error));
    run(&m, LW_ANALYSIS_TRANSIENT, 1, 2, 1e-10);
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(k.at[i].input, 1 + 12000*LW_PI*i, 1e-9, 0);
}

/* A weight hung on three springs: at rest where the potential is least. */
TEST(a_weight_comes_to_rest)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.1, 0, 0], 'inertia': [0.1, 0.1, 0.1]}], "
                               "'joints': [{'name': 'A', 'kind': 'spherical', 'links': ['ground', 'a'], 'at': [0, 0, 0]}], 'springs': [{'links': "
                               "['ground', 'a'], 'at': [[0.1, 0.5, 1], [0.1, 0, 0]], 'stiffness': 50, 'free': 0.3}, {'links': ['ground', 'a'], 'at': [[1, "
                               "-0.2, 0.4], [0, 0.1, 0]], 'stiffness': 80, 'free': 0.2}], 'gravity': [0, 0, -9.81], 'tracers': [{'name': 'P', 'link': "
                               "'a', 'at': [0.1, 0, 0]}]}";
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "weight", &m);
    run(&m, LW_ANALYSIS_STATIC, 1, 1, 1e-10);
    double least = k.at[0].energy;
    srow rest = k.at[0];
    OWN(lw_space) s = { 0 };
    OWN(lw_space_forces) f = { 0 };
    lw_space_frame frame[2];
    lw_rng rng = check_rng(0);
    CHECK_OK(lw_space_make(&m, &s, &check_error));
    CHECK_OK(lw_space_forces_make(&s, &f, &check_error));
    for (int i = 0; i < 100; i++) {          /* turned a little about the ball: the potential is greater */
        double q[7], by[6] = { 0 };
        memcpy(q, rest.q, sizeof q);
        lw_vec3 turn = lw_v3_scale(lw_v3(lw_rng_normal(&rng), lw_rng_normal(&rng), lw_rng_normal(&rng)), 1e-3);
        lw_space_place(&s, q, frame);
        by[3] = turn.x, by[4] = turn.y, by[5] = turn.z;
        lw_space_move(&s, q, by);
        lw_space_place(&s, q, frame);
        lw_vec3 pin = lw_space_point_at(frame, (lw_space_point){ 0, s.joint[0].arm[1] });
        q[0] -= pin.x/s.unit, q[1] -= pin.y/s.unit, q[2] -= pin.z/s.unit;
        CHECK(lw_space_potential(&f, q, frame) > least);
    }
}

/* A spring that is wound up turns an arm with a weight far beyond half a turn: c (turn - free) = m g l cos(turn). */
TEST(a_wound_spring_comes_to_rest)
{
    static const double wound[] = { 2, 4, 10, -7.5 };
    for (int i = 0; i < 4; i++) {
        char text[700];
        OWN(lw_spatial) m = { 0 };
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.3, 0, 0], 'inertia': "
                 "[0.01, 0.02, 0.03]}], 'joints': [{'name': 'J', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], "
                 "'springs': [{'joint': 'J', 'stiffness': 5, 'free': %g}], 'gravity': [0, 0, -9.81], 'tracers': [{'name': "
                 "'P', 'link': 'a', 'at': [1, 0, 0]}]}", wound[i]);
        read_spatial(text, "wound", &m);
        run(&m, LW_ANALYSIS_STATIC, 1, 1, 1e-10);
        double turn = atan2(-k.at[0].tracer[0].z, k.at[0].tracer[0].x), want = wound[i] + 9.81*0.3*k.at[0].tracer[0].x/5;
        CHECK(k.rest.stable);
        CHECK_NEAR(remainder(turn - want, 2*LW_PI), 0, 1e-10, 0);
    }
}

/* Two pins of which the upper one is upright: the arms fall from a saddle and hang, in any direction (neutral); with gravity aside,
 * which leaves more than one saddle, in one (stable). */
TEST(arms_fall_from_saddles)
{
    for (int aside = 0; aside < 2; aside++) {
        char text[1500], *at = text;
        OWN(lw_spatial) m = { 0 };
        at += sprintf(at, "{'linkwright': 1, 'links': ['ground'");
        for (int i = 0; i < 3; i++)
            at += sprintf(at, ", {'name': 'l%d', 'mass': %g, 'centre': [%g, %g, %g], 'inertia': [0.01, 0.012, 0.013]}", i, 1 - 0.1*i,
                          0.15 + 0.3*i, i == 2 ? 0.1 : 0.025*i, i == 2 ? 0.1 : 0.05*i);
        at += sprintf(at, "], 'joints': [{'name': 'A', 'links': ['ground', 'l0'], 'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'B', "
                      "'links': ['l0', 'l1'], 'at': [0.3, 0, 0], 'axis': [0, 1, 0]}, {'name': 'C', 'links': ['l1', 'l2'], "
                      "'at': [0.6, 0.05, 0.1], 'axis': [0, 0, 1]}], 'gravity': [%g, %g, -9.81], 'tracers': [{'name': 'P', 'link': "
                      "'l2', 'at': [0.9, 0.15, 0.1]}]}", 0.3*aside, 0.2*aside);
        read_spatial(text, "arms", &m);
        run(&m, LW_ANALYSIS_STATIC, 1, 1, 1e-10);
        CHECK(aside ? k.rest.stable : k.rest.neutral);
        CHECK(k.at[0].tracer[0].z < -0.6);
    }
}

/* More drives than freedoms: of all torques that move the model, those of least norm, which are in proportion to the rates of
 * their joints; together they do the work. */
TEST(drives_share_a_load)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0.5, 0]}, {'name': 'b', 'mass': 1, 'centre': "
                               "[0.6, 1.1, 0]}, {'name': 'c', 'mass': 1, 'centre': [1.1, 0.6, 0]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
                               "'at': [0, 0, 0], 'axis': [0, 0, 1]}, {'name': 'B', 'links': ['a', 'b'], 'at': [0, 1, 0], 'axis': [0, 0, 1]}, {'name': "
                               "'C', 'links': ['b', 'c'], 'at': [1.2, 1.2, 0], 'axis': [0, 0, 1]}, {'name': 'D', 'links': ['ground', 'c'], 'at': [1, 0, "
                               "0], 'axis': [0, 0, 1]}], 'input': {'joint': 'A', 'motion': '0.1*t + t^2'}, 'drives': [{'joint': 'A'}, {'joint': 'D'}]}";
    OWN(lw_spatial) m = { 0 };
    double work = 0;
    read_spatial(text, "drives", &m);
    run(&m, LW_ANALYSIS_TRANSIENT, 0.5, 1000, 1e-12);
    CHECK(k.many_drives);
    for (int i = 0; i < k.n; i++) {
        const double *tau = k.at[i].drive, a = k.at[i].v[5], c = k.at[i].v[17];
        CHECK_NEAR(tau[0]*c - tau[1]*a, 0, 1e-7*(fabs(tau[0]) + fabs(tau[1]))*(fabs(a) + fabs(c)), 0);
        work += (i == 0 || i == 1000 ? 1 : i%2 ? 4 : 2)*(tau[0]*a + tau[1]*c)*0.5/3000;
    }
    CHECK_NEAR(work, k.at[1000].work, 1e-9, 0);
}

/* A weight half-way between two equal slides: each carries half of its force and moment, whichever rows the solver keeps.  Fifty of
 * them are a large model. */
TEST(redundant_slides_share_alike)
{
    static char text[40000];
    for (int large = 0; large < 2; large++) {
        int copies = large ? 50 : 1, used = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground'");
        for (int i = 0; i < copies; i++)
            used += snprintf(text + used, sizeof text - (size_t)used, ", {'name': 'b%d', 'mass': 2, 'centre': [0.5, %d, 0.2], 'inertia': "
                             "[0.1, 0.2, 0.25]}", i, i);
        for (int i = 0; i < 2*copies; i++)
            used += snprintf(text + used, sizeof text - (size_t)used, "%s{'name': '%c%d', 'kind': 'prismatic', 'links': "
                             "['ground', 'b%d'], 'at': [%d, %d, 0], 'axis': [0, 0, 1]}", i ? ", " : "], 'joints': [", "AB"[i%2], i/2, i/2, i%2, i/2);
        for (int i = 0; i < 2*copies; i++)
            used += snprintf(text + used, sizeof text - (size_t)used, "%s{'joint': '%c%d', 'stiffness': 1e3}", i ? ", " : "], 'springs': [",
                             "AB"[i%2], i/2);
        snprintf(text + used, sizeof text - (size_t)used, "], 'gravity': [1, 2, 0]}");
        OWN(lw_spatial) m = { 0 };
        read_spatial(text, "slides", &m);
        for (int way = 0; way < 3; way++) {
            formulation = way == 1 ? LW_FORMULATION_INDEX1 : way == 2 ? LW_FORMULATION_RADAU : LW_FORMULATION_AUTO;
            lw_dynamics_report q = run(&m, way ? LW_ANALYSIS_TRANSIENT : LW_ANALYSIS_STATIC, 1e-3, 1, 1e-10);
            CHECK_INT(q.redundant, 5*copies);
            for (int j = 0; j < (large ? 16 : 2); j++) {
                const lw_spatial_reaction *r = &k.at[k.n - 1].joint[j];
                double want[6] = { -1, -2, 0, 0.4, -0.2, 0 }, *v = want;
                CHECK_NEAR(lw_v3_norm(lw_v3_sub(r->force, lw_v3(v[0], v[1], v[2]))), 0, 1e-10, 0);
                CHECK_NEAR(lw_v3_norm(lw_v3_sub(r->moment, lw_v3(v[3], v[4], v[5]))), 0, 1e-10, 0);
            }
        }
        formulation = LW_FORMULATION_AUTO;
    }
}

/* A pendulum falls on a rigid stop, bounces and comes to rest on it: as the same model in the plane, and each bounce keeps the
 * square of the restitution of the energy. */
TEST(a_pendulum_bounces)
{
    static const char space[] = "{'linkwright': 1, 'gravity': [0, -9.81, 0], 'links': ['ground', {'name': 'a', 'mass': 2, "
        "'centre': [0.4, 0, 0], 'inertia': [0.01, 0.03, 0.03]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], "
        "'at': [0, 0, 0], 'axis': [0, 0, 1], 'stop': {'least': -0.5, 'restitution': 0.4}}]}";
    static const char plane[] = "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.4, 0], 'inertia': 0.03}], "
        "'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0], 'stop': {'least': -0.5, 'restitution': 0.4}}]}";
    OWN(lw_spatial) m = { 0 };
    lw_model p;
    read_spatial(space, "space", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 2, 100, 1e-12);
    CHECK(q.n_event_seen > 5 && q.event[0].impact);
    CHECK_NEAR(q.event[1].speed/q.event[0].speed, 0.4, 1e-9, 0);
    CHECK(q.energy_error < 1e-10*q.energy_scale);
    read_planar(plane, "plane", &p);
    flat_go(&p, 2, 100, 1e-12, &flat);
    CHECK_INT(q.n_event_seen, flat.r.n_event_seen);
    for (int i = 0; i < k.n && i < flat.n; i++) {
        double turn = 2*atan2(k.at[i].q[6], k.at[i].q[3]);
        CHECK_NEAR(remainder(turn - flat.turn[i], 2*LW_PI), 0, 1e-8, 0);
    }
}

/* A slider meets a compliant stop: its damper pushes but does not pull, so the slider leaves while the spring is still pressed
 * (test_dynamics_hard.c, damped_stop). */
TEST(a_damped_stop)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': "
        "[1, 1, 1]}], 'joints': [{'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': "
        "[1, 0, 0], 'stop': {'greatest': 0.5, 'stiffness': 2000, 'damping': 40}}], 'inputs': [{'joint': 'S', 'speed': 1}]}";
    static const lw_formulation each[] = { LW_FORMULATION_AUTO, LW_FORMULATION_INDEX1, LW_FORMULATION_RADAU };
    const double b = 20, w = sqrt(2000 - b*b), end = atan2(2*b*w, b*b - w*w)/w;
    const double z = exp(-b*end)*sin(w*end)/w, speed = exp(-b*end)*(cos(w*end) - b/w*sin(w*end));
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "text", &m);
    for (int f = 0; f < 3; f++) {
        formulation = each[f];
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-9);
        CHECK_NEAR(k.at[1].input, 0.5 + z + speed*(0.5 - end), 1e-7, 0);
        CHECK(q.energy_error < 1e-6*q.energy_scale);
    }
    formulation = LW_FORMULATION_AUTO;
}

/* A slider between two compliant stops: arcs of 10 rad/s, and 0.7 s at 1 m/s between them. */
TEST(steps_end_at_compliant_stops)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0, 0], 'inertia': "
        "[1, 1, 1]}], 'joints': [{'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': "
        "[1, 0, 0], 'stop': {'least': -0.4, 'greatest': 0.3, 'stiffness': 100}}], 'inputs': [{'joint': 'S', 'speed': 1}]}";
    static const lw_formulation each[] = { LW_FORMULATION_RECURSIVE, LW_FORMULATION_INDEX1 };
    double t = 5*(LW_PI/5 + 1.4);                        /* five periods */
    OWN(lw_spatial) m = { 0 };
    read_spatial(text, "text", &m);
    for (int f = 0; f < 2; f++) {
        formulation = each[f];
        run(&m, LW_ANALYSIS_TRANSIENT, t, 1, 1e-10);
        CHECK_NEAR(k.at[1].input, 0, 1e-9, 0);
    }
    formulation = LW_FORMULATION_AUTO;
}

TEST(refuses_what_it_cannot)
{
    static const struct { const char *link, *joint, *more, *says; } bad[] = {
        { "'mass': 1, 'centre': [1, 0, 0], 'inertia': [1, 1, 1], 'angular_velocity': [0, 1, 1]", "", "",
          "contradict" },
        { "'mass': 0, 'centre': [1, 0, 0]", "", "", "without moving any mass" },
        { "'mass': 1, 'centre': [1, 0, 0]", "", ", 'input': {'joint': 'A', 'motion': 'log(t - 1)'}",
          "not a number" },
        { "'mass': 1, 'centre': [1, 0, 0]", "", ", 'inputs': [{'joint': 'A', 'motion': 't'}, {'tracer': 'P', 'coordinate': 'x', 'motion': "
                                                    "'t'}]", "the model has 1 freedom and 2 inputs: 1 input is too many; A and x of P cannot all be inputs" },
        { "'mass': 1, 'centre': [1, 0, 0], 'angular_velocity': [0, 0, 5]", "", ", 'input': {'joint': 'A', 'motion': '2*t'}",
          "contradict" },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        char text[1024];
        OWN(lw_spatial) m = { 0 };
        lw_dynamics *r;
        lw_error e = { 0 };
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', %s}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': "
                                    "[0, 0, 0], 'axis': [0, 0, 1]%s}], 'tracers': [{'name': 'P', 'link': 'a', 'at': [1, 1, "
                                    "0]}]%s}", bad[i].link, bad[i].joint, bad[i].more);
        read_spatial(text, "bad", &m);
        lw_dynamics_options o = lw_dynamics_options_default();
        CHECK(lw_dynamics_make_spatial(&m, &o, &r, &e) != LW_OK);
        CHECK_HAS(e.text, bad[i].says);
    }
}

/* A hanging body on a universal joint with a spring: two modes in closed form. */
TEST(modes_of_a_hanging_body)
{
    static const char text[] = "{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0, 0, -0.5], "
        "'inertia': [0.3, 0.2, 0.1]}], 'joints': [{'name': 'U', 'kind': 'universal', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [1, 0, 0], "
        "'second_axis': [0, 1, 0]}], 'springs': [{'links': ['ground', 'a'], 'at': [[1, 0, -0.5], [0, 0, -0.5]], 'stiffness': 30, 'free': 1}]}";
    OWN(lw_spatial) m = { 0 };
    lw_dynamics *d;
    OWN(lw_modes) modes = { 0 };
    double q[7];
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    read_spatial(text, "hanging", &m);
    CHECK_OK(lw_dynamics_make_spatial(&m, &o, &d, &check_error));
    CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ .rest = true }, 20, 0, q, &modes, &check_error));
    CHECK_INT(modes.n_mode, 2);
    CHECK_NEAR(2*LW_PI*modes.mode[0].frequency, sqrt(9.81/.8), 1e-10, 0);
    CHECK_NEAR(2*LW_PI*modes.mode[1].frequency, sqrt((9.81 + 7.5)/.7), 1e-10, 0);
    lw_dynamics_free(d);
}

/* An input held along a slide that swings, or at the height of a tracer: the force that holds it brings back. */
TEST(modes_with_inputs_held)
{
    static const char slide[] = "{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 0.5, "
        "'centre': [0, 0, 0], 'inertia': [0.1, 0.1, 0.1]}, {'name': 'b', 'mass': 1, 'centre': [0, 0, -2], 'inertia': [0.01, 0.01, "
        "0.01]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}, {'name': 'B', 'kind': "
        "'t', 'links': ['a', 'b'], 'at': [0, 0, -1], 'axis': [0, 0, -1]}], 'input': {'joint': 'B'}}";
    /* a plate that slides and turns in a plane, a point of it kept at its place: a pendulum */
    static const char height[] = "{'linkwright': 1, 'gravity': [0, 0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0, 0, -0.5], "
        "'inertia': [0.3, 0.4, 0.3]}], 'joints': [{'name': 'E', 'kind': 'planar', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 1, 0]}], "
        "'inputs': [{'tracer': 'P', 'coordinate': 'z'}, {'tracer': 'P', 'coordinate': 'x'}], 'tracers': [{'name': 'P', 'link': 'a', 'at': [0, 0, 0]}]}";
    for (int i = 0; i < 2; i++) {
        OWN(lw_spatial) m = { 0 };
        lw_dynamics *d;
        OWN(lw_modes) modes = { 0 };
        double q[14];
        lw_dynamics_options o = lw_dynamics_options_default();
        o.analysis = LW_ANALYSIS_STATIC;
        o.hold_inputs = true;
        read_spatial(i ? height : slide, "held", &m);
        CHECK_OK(lw_dynamics_make_spatial(&m, &o, &d, &check_error));
        CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ .rest = true }, 20, 0, q, &modes, &check_error));
        CHECK_INT(modes.n_mode, 1);
        double want = i ? sqrt(2*9.81*0.5/(0.4 + 0.5)) : sqrt(9.81*2/(0.1 + 0.01 + 4));
        CHECK_NEAR(2*LW_PI*modes.mode[0].frequency, want, 1e-9, 0);
        lw_dynamics_free(d);
    }
}

/* Inertias far below mass times length squared: as many modes as freedoms, and those of even less inertia. */
TEST(modes_of_points_of_mass)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 2, 'centre': [0.8, -0.5, -1], 'inertia': [%g, %g, %g]}, "
        "{'name': 'b', 'mass': 2, 'centre': [2.6, -1.8, -3], 'inertia': [%g, %g, %g]}], 'joints': [{'name': 'A', 'kind': 'spherical', 'links': ['ground', "
        "'a'], 'at': [0, 0, 0]}, {'name': 'B', 'links': ['a', 'b'], 'at': [1.6, -1.1, -2], 'axis': [1, 0.1, 0]}], 'springs': [{'links': ['ground', 'a'], "
        "'at': [[-0.3, -1.4, -2.8], [1.1, -0.6, -1.3]], 'stiffness': 490}, {'links': ['ground', 'a'], 'at': [[1.8, -0.7, -1.7], [0.9, -0.7, -0.8]], "
        "'stiffness': 330}, {'links': ['ground', 'b'], 'at': [[2.5, -1.4, -2.5], [2.4, -1.7, -3.3]], 'stiffness': 930}, {'links': ['ground', 'b'], 'at': "
        "[[0.8, -1.5, -2.8], [2.8, -1.8, -3]], 'stiffness': 770}]}";
    double slow[2][4] = { { 0 } }, q[14];
    for (int i = 0; i < 2; i++) {
        OWN(lw_spatial) m = { 0 };
        lw_dynamics *d;
        OWN(lw_modes) modes = { 0 };
        char all[2000];
        double a = i ? 1e-12 : 1e-9, b = i ? 1e-14 : 1e-10;
        snprintf(all, sizeof all, text, a, a, 1.5*a, b, b, 1.5*b);
        read_spatial(all, "points", &m);
        lw_dynamics_options o = lw_dynamics_options_default();
        o.analysis = LW_ANALYSIS_STATIC;
        CHECK_OK(lw_dynamics_make_spatial(&m, &o, &d, &check_error));
        CHECK_OK(lw_modes_find_large(d, &(lw_modes_options){ .rest = true }, 20, 0, q, &modes, &check_error));
        CHECK_INT(modes.n_mode, 4);
        for (int j = 0; j < 4 && j < modes.n_mode; j++)
            slow[i][j] = modes.mode[j].frequency;
        lw_dynamics_free(d);
    }
    for (int j = 0; j < 4; j++)
        CHECK_NEAR(slow[1][j], slow[0][j], 0, 1e-7);
    CHECK(slow[0][0] > 0.1);
}

/* The implicit methods on turns in space: errors fall with the tolerance towards the explicit method's result, unless below it, for a closed loop
 * and for a fast top, and those of generalised alpha with the square of the number of steps; turns are counted; the stiff governor
 * takes a tenth of the evaluations. */
TEST(implicit_steps_turn_in_space)
{
    static const char *const name[] = { "slider-crank", "top" };
    static const struct { lw_formulation f; double last, most; } way[] = { { LW_FORMULATION_RADAU, 1e-9, 300 },
                                                      { LW_FORMULATION_GGL, 1e-9, 300 }, { LW_FORMULATION_ALPHA, 1e-7, 1000 } };
    lw_spatial m;
    for (int i = 0; i < 6; i++) {
        load_spatial(name[i%2], &m);
        run(&m, LW_ANALYSIS_TRANSIENT, .5, 1, 1e-12);
        lw_vec3 exact = k.at[1].tracer[0];
        double before = 1, input = k.at[1].input, constant = 0;
        formulation = way[i/2].f;
        for (double tolerance = 1e-5; tolerance > 0.5*way[i/2].last; tolerance *= 1e-2) {
            double steps = (double)run(&m, LW_ANALYSIS_TRANSIENT, .5, 1, tolerance).steps;
            double error = lw_v3_norm(lw_v3_sub(k.at[1].tracer[0], exact));
            CHECK(error < fmax(0.2*before, tolerance) && error < way[i/2].most*tolerance);
            CHECK(fabs(k.at[1].input - input) < 1);
            CHECK(k.off < 1e-12);
            if (constant > 0 && formulation == LW_FORMULATION_ALPHA)
                CHECK_NEAR(error*steps*steps, constant, 0, 0.2);
            constant = error*steps*steps;
            before = error;
        }
        formulation = LW_FORMULATION_AUTO;
        lw_spatial_free(&m);
    }
    load_spatial("governor", &m);
    formulation = LW_FORMULATION_RADAU;
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 1, 1e-7);
    formulation = LW_FORMULATION_AUTO;
    CHECK_NEAR(k.at[1].tracer[0].z, .5014209224, 1e-9, 0);
    CHECK(q.rates < 5000);
    lw_spatial_free(&m);
}

/* A tool driven beyond what the loops reach: how far they stay open, and where. */
TEST(loops_that_do_not_close)
{
    OWN(lw_spatial) m = { 0 };
    lw_error e = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    OWNED(lw_dynamics) *d = NULL;
    lw_dynamics_report r;
    o.intervals = 4;
    load_spatial("delta", &m);
    CHECK_INT(lw_spatial_set_motion(&m, 0, "0", &e), LW_OK);
    CHECK_INT(lw_spatial_set_motion(&m, 1, "0", &e), LW_OK);
    CHECK_INT(lw_spatial_set_motion(&m, 2, "-0.65 - t", &e), LW_OK);
    CHECK_INT(lw_dynamics_make_spatial(&m, &o, &d, &e), LW_OK);
    CHECK_INT(lw_dynamics_run(d, NULL, NULL, &r, &e), LW_E_NUMERIC);
    CHECK_HAS(e.text, "z of tool = -1.08972474 m");       /* the lowest place, sqrt(1.1^2 - 0.15^2) = 1.089724736 */
    CHECK_HAS(e.text, "m open");
}

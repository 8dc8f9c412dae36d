/* Coulomb friction of joints in space against closed forms: a block on a slope, two blocks on each other, pins, guides and balls
 * that come to rest; and against the plane. */
#include "tests/space_run.h"

static lw_formulation asked;

static srun k;

static void run(const char *text, lw_formulation wanted, double to, int intervals, double tolerance)
{
    OWN(lw_spatial) m = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    o.to = to, o.intervals = intervals, o.relative = o.absolute = tolerance, o.formulation = asked;
    read_spatial(text, "friction", &m);
    srun_go(&m, &o, &k);
    CHECK_INT(k.r.formulation, wanted);
}

/* A slope of 3 in 4; pushed up with 2 m/s the block stops after 2^2/(2 g (0.6 + 0.8 mu)) and, with a coefficient above 3/4,
 * stays; else it slides back. */
TEST(a_block_on_a_slope)
{
    static const double mu[] = { 0.3, 0.8 };
    for (int i = 0; i < 4; i++) {
        char text[1024];
        double u = i/2 ? 2 : 0, g = 9.81, f = mu[i%2], stop = u/(g*(0.6 + 0.8*f)), high = u*stop/2;
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'block', 'mass': 2, 'centre': [0, 0, 0], "
                 "'inertia': [0.01, 0.02, 0.03], 'velocity': [%g, %g, %g]}], 'joints': [{'name': 'S', 'kind': 'prismatic', "
                 "'links': ['ground', 'block'], 'at': [0, 0, 0], 'axis': [0.48, 0.64, 0.6], 'friction': {'coefficient': %g}}], "
                 "'gravity': [0, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'block', 'at': [0, 0, 0]}]}", 0.48*u, 0.64*u,
                 0.6*u, f);
        run(text, LW_FORMULATION_INDEX1, 1, 40, 1e-11);
        CHECK(!k.r.smooth_friction);
        for (int s = 0; s < k.n; s++) {
            double t = k.at[s].t, back = f < 0.75 ? g*(0.6 - 0.8*f)*(t - stop)*(t - stop)/2 : 0;
            double want = t < stop ? u*t - u/stop*t*t/2 : high - back;
            CHECK_NEAR(lw_v3_dot(k.at[s].tracer[0], lw_v3(0.48, 0.64, 0.6)), want, 1e-11, 0);
        }
    }
}

/* 1 kg on 2 kg on the ground, g = 10, coefficients 0.5 and 0.1, pulled by 10 t N at the upper one: nothing moves until 3 N, both
 * together until 6 N, then the lower one with 1 m/s^2, the upper one with (10 t - 5) m/s^2. */
TEST(blocks_on_each_other)
{
    run("{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}, {'name': 'B', 'mass': 1, 'centre': "
        "[0, 0, 0.1], 'inertia': [1, 1, 1]}], 'joints': [{'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'A'], 'at': [0, 0, 0], 'axis': [0, 1, 0], "
        "'friction': {'coefficient': 0.1}}, {'name': 'T', 'kind': 'prismatic', 'links': ['A', 'B'], 'at': [0, 0, 0.1], 'axis': [0, 1, 0], 'friction': "
        "{'coefficient': 0.5}}], 'gravity': [0, 0, -10], 'forces': [{'link': 'B', 'at': [0, 0, 0.1], 'fy': '10*t'}], 'tracers': [{'name': 'P', 'link': "
        "'A', 'at': [0, 0, 0]}, {'name': 'Q', 'link': 'B', 'at': [0, 0, 0.1]}]}", LW_FORMULATION_INDEX1, 1, 20, 1e-11);
    for (int i = 0; i < k.n; i++) {
        double t = k.at[i].t, s = fmax(0, fmin(t, 0.6) - 0.3), x = 10*s*s*s/18, v = 10*s*s/6, r = fmax(0, t - 0.6);
        CHECK_NEAR(k.at[i].tracer[0].y, x + v*r + r*r/2, 1e-10, 0);
        CHECK_NEAR(k.at[i].tracer[1].y, x + v*r + r*r/2 + 10*r*r*r/6, 1e-10, 0);
    }
}

/* A load that jumps from 0 to 7 N moves 2 kg that stick by 2 N, at once; when it jumps back, they slow down and stick again. */
TEST(a_load_jumps)
{
    run("{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], 'joints': [{'name': 'S', 'kind': "
        "'prismatic', 'links': ['ground', 'A'], 'at': [0, 0, 0], 'axis': [0, 1, 0], 'friction': {'coefficient': 0.1}}], 'gravity': [0, 0, -10], 'forces': "
        "[{'link': 'A', 'at': [0, 0, 0], 'fy': '7*max(0, sign(t - 0.5)*sign(0.7 - t))'}], 'tracers': [{'name': 'P', 'link': 'A', 'at': [0, 0, 0]}]}",
        LW_FORMULATION_INDEX1, 2, 20, 1e-11);
    for (int i = 0; i < k.n; i++) {
        double on = fmin(fmax(k.at[i].t - 0.5, 0), 0.2), off = fmin(fmax(k.at[i].t - 0.7, 0), 0.5);
        CHECK_NEAR(k.at[i].tracer[0].y, 2.5*on*on/2 + 0.5*off - off*off/2, 1e-11, 0);
    }
}

/* A body of 1 kg on a pin of radius r: each half swing is smaller by 2 mu r/l, if angles and friction are small; then it sticks
 * where the weight cannot turn it. */
TEST(a_pendulum_comes_to_rest)
{
    const double mu = 0.2, r = 0.002, l = 0.5, begin = 0.01;
    char text[1024];
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 1, 'centre': [%.17g, 0, %.17g], 'inertia': [1e-3, 1e-3, "
             "1e-3]}], 'joints': [{'name': 'O', 'links': ['ground', 'A'], 'at': [0, 0, 0], 'axis': [0, -1, 0], 'friction': {'coefficient': %g, 'radius': "
             "%g}}], 'gravity': [0, 0, -9.81], 'inputs': [{'joint': 'O', 'value': %g}]}", l*sin(begin), -l*cos(begin), mu, r, begin);
    double half = LW_PI*sqrt((l*l + 1e-3)/(9.81*l)), fall = 2*mu*r/l;
    run(text, LW_FORMULATION_INDEX1, 10*half, 10, 1e-11);
    for (int i = 0; i < k.n; i++) {
        double left = begin - i*fall;
        CHECK_NEAR(fabs(k.at[i].input), left > fall/2 ? left : fabs(k.at[k.n - 1].input), 1e-6, 0);
    }
    CHECK(fabs(k.at[k.n - 1].input) <= fall/2);
    CHECK_NEAR(k.at[k.n - 2].input, k.at[k.n - 1].input, 1e-12, 0);
}

/* Slip of constant direction where I = m r^2: it falls by mu g. */
TEST(guides_and_balls)
{
    static const struct { const char *joint, *velocity; double rate, axis; } row[] = {
        /* mu m g r/I = 0.2*2*10*0.1/0.02 = 20 rad/s^2 */
        { "'kind': 'spherical'", "'angular_velocity': [3, 4, 0]", 20, 5 },
        { "'kind': 'universal', 'axis': [1, 0, 0], 'second_axis': [0, 1, 0]", "'angular_velocity': [0, 5, 0]", 20, 5 },
        { "'kind': 'revolute', 'axis': [0.6, 0.8, 0]", "'angular_velocity': [3, 4, 0]", 20, 5 },
        /* slip 0.3 m/s along, 0.4 m/s around: 2 m/s^2 against it, 4/5 of which turn the pin */
        { "'kind': 'cylindrical', 'axis': [1, 0, 0]", "'velocity': [0.3, 0, 0], 'angular_velocity': [4, 0, 0]", 16, 4 },
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++)
        for (int ideal = 0; ideal < 2; ideal++) {
            char text[1024];
            snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 2, 'centre': [0, 0, 0], "
                     "'inertia': [0.02, 0.02, 0.02], %s}], 'joints': [{'name': 'J', %s, 'links': ['ground', 'A'], 'at': "
                     "[0, 0, 0], 'friction': {'coefficient': 0.2, 'radius': 0.1%s}}], 'gravity': [0, 0, -10], 'tracers': "
                     "[{'name': 'P', 'link': 'A', 'at': [0, 0, 0]}]}", row[i].velocity, row[i].joint, ideal ? "" :
                     ", 'speed': 1e-4");
            bool sticks = ideal && i == 2;
            /* 2 mu m g r^2/(I speed) is 4e3/s or 4e4/s */
            run(text, ideal ? LW_FORMULATION_INDEX1 : i == 2 ? LW_FORMULATION_RADAU : LW_FORMULATION_CVODE, 0.4, 16, 1e-9);
            CHECK_INT(k.r.smooth_friction, ideal && !sticks);
            for (int s = 0; s < k.n; s++)
                CHECK_NEAR(lw_v3_norm(k.at[s].omega), fmax(0, row[i].axis - row[i].rate*k.at[s].t), sticks ? 1e-9 : ideal ? 5e-2 : 5e-3, 0);
            if (i == 3)
                CHECK_NEAR(k.at[k.n - 1].tracer[0].x, 0.3*0.25/2, ideal ? 1e-3 : 1e-4, 0);
        }
}

/* A block with regularised friction that is not stiff bounces off a stop: an explicit method is exact at each impact, where an implicit one begins
 * anew with its lowest order. */
TEST(a_block_bounces)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], 'joints': [{'name': "
        "'J', 'kind': 'prismatic', 'links': ['ground', 'A'], 'at': [0, 0, 0], 'axis': [1, 0, 0], 'friction': {'coefficient': 0.3, 'speed': 0.01}, 'stop': "
        "{'least': -0.2, 'restitution': 0.7}}], 'gravity': [-4, 2, -9], 'input': {'joint': 'J', 'speed': 1}}";
    double x[21];
    asked = LW_FORMULATION_INDEX1;
    run(text, LW_FORMULATION_INDEX1, 2, 20, 1e-13);
    for (int i = 0; i < k.n; i++)
        x[i] = k.at[i].input;
    asked = LW_FORMULATION_AUTO;
    run(text, LW_FORMULATION_INDEX1, 2, 20, 1e-10);
    CHECK_INT(k.n, 21);
    for (int i = 0; i < k.n; i++)
        CHECK_NEAR(k.at[i].input, x[i], 2e-10, 0);
}

/* A four-bar with friction strikes its stops, rests on them and leaves them by a force that turns: rounding of the acceleration there begins no bounce. */
TEST(stops_are_left)
{
    static const struct { double restitution, stop, rate, phase; } row[] = { { 0, 0.05, 9, 0 }, { 0, 0.1, 9, 1 }, { 0.3, 0.05, 9, 1 } };
    for (int i = 0; i < 3; i++) {
        char text[1500];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0.1, 0.2, 0], 'inertia': [0.02, 0.02, 0.02]}, "
            "{'name': 'b', 'mass': 1, 'centre': [0.5, 0.45, 0], 'inertia': [0.02, 0.02, 0.02]}, {'name': 'c', 'mass': 1, 'centre': [0.85, 0.25, 0], 'inertia': "
            "[0.02, 0.02, 0.02]}], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [0, 0, 0], 'axis': [0, 0, 1], 'friction': {'coefficient': 0.1, "
            "'radius': 0.03, 'speed': 0.01}}, {'name': 'B', 'links': ['a', 'b'], 'at': [0.2, 0.4, 0], 'axis': [0, 0, 1], 'stop': {'least': %g, 'greatest': %g, "
            "'restitution': %g}}, {'name': 'C', 'links': ['b', 'c'], 'at': [0.8, 0.5, 0], 'axis': [0, 0, 1]}, {'name': 'D', 'links': ['ground', 'c'], 'at': "
            "[0.9, 0, 0], 'axis': [0, 0, 1]}], 'forces': [{'link': 'b', 'at': [0.5, 0.45, 0], 'fx': '10*sin(%g*t + %g)', 'fy': '-1'}], 'tracers': [{'name': 'P', 'link': 'b', "
            "'at': [0.5, 0.45, 0]}]}", -row[i].stop,
            row[i].stop, row[i].restitution, row[i].rate, row[i].phase);
        run(text, LW_FORMULATION_INDEX1, 2, 4, 1e-10);
        CHECK_INT(k.n, 5);
        CHECK(k.r.n_event > 4);
    }
}

/* A four-bar with friction in all pins, turned into any plane of space, beside the planar program. */
static flat_run plane;

static lw_vec3 turned(const lw_mat3 *t, double x, double y) { return lw_m3_apply(t, lw_v3(x, y, 0)); }

TEST(as_in_the_plane)
{
    static const struct { const char *a, *b; double x, y; } joint[] = {
        { "ground", "crank", 0, 0 }, { "crank", "coupler", 0.1, 0.2 }, { "coupler", "rocker", 0.6, 0.5 }, { "ground", "rocker", 0.7, 0 } };
    static const struct { const char *name; double m, x, y, i; } body[] = {
        { "crank", 1, 0.05, 0.1, 0.01 }, { "coupler", 2, 0.3, 0.4, 0.05 }, { "rocker", 1.5, 0.65, 0.3, 0.03 } };
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 2; trial++) {
        char flat[2048], deep[4096];
        int n = 0, d = 0;
        double mu = trial ? 0.5 : 0.1;
        lw_mat3 t = lw_quaternion_matrix(lw_quaternion_unit((lw_quaternion){ lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1),
                                                                           lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1) }));
        lw_vec3 axis = lw_m3_column(&t, 2), g = turned(&t, 0, -9.81);
        n += snprintf(flat + n, sizeof flat - (size_t)n, "{'linkwright': 1, 'links': ['ground'");
        d += snprintf(deep + d, sizeof deep - (size_t)d, "{'linkwright': 1, 'links': ['ground'");
        for (int i = 0; i < 3; i++) {
            lw_vec3 c = turned(&t, body[i].x, body[i].y);
            n += snprintf(flat + n, sizeof flat - (size_t)n, ", {'name': '%s', 'mass': %g, 'centre': [%g, %g], 'inertia': %g}",
                          body[i].name, body[i].m, body[i].x, body[i].y, body[i].i);
            d += snprintf(deep + d, sizeof deep - (size_t)d, ", {'name': '%s', 'mass': %g, 'centre': [%.17g, %.17g, %.17g], "
                          "'inertia': [%g, %g, %g]}", body[i].name, body[i].m, c.x, c.y, c.z, body[i].i, body[i].i, body[i].i);
        }
        for (int i = 0; i < 4; i++) {
            lw_vec3 at = turned(&t, joint[i].x, joint[i].y);
            n += snprintf(flat + n, sizeof flat - (size_t)n, "%s{'name': 'J%d', 'links': ['%s', '%s'], 'at': [%g, %g], "
                          "'friction': {'coefficient': %g, 'radius': 0.02}}", i ? ", " : "], 'joints': [", i, joint[i].a, joint[i].b,
                          joint[i].x, joint[i].y, mu);
            d += snprintf(deep + d, sizeof deep - (size_t)d, "%s{'name': 'J%d', 'links': ['%s', '%s'], 'at': [%.17g, %.17g, "
                          "%.17g], 'axis': [%.17g, %.17g, %.17g], 'friction': {'coefficient': %g, 'radius': 0.02}}", i ? ", " :
                          "], 'joints': [", i, joint[i].a, joint[i].b, at.x, at.y, at.z, axis.x, axis.y, axis.z, mu);
        }
        snprintf(flat + n, sizeof flat - (size_t)n, "], 'input': {'joint': 'J0', 'speed': 3}, 'gravity': [0, -9.81]}");
        snprintf(deep + d, sizeof deep - (size_t)d, "], 'input': {'joint': 'J0', 'speed': 3}, 'gravity': [%.17g, %.17g, %.17g]}",
                 g.x, g.y, g.z);
        lw_model m;
        read_planar(flat, "plane", &m);
        flat_go(&m, 2, 20, 1e-11, &plane);
        CHECK_INT(plane.r.formulation, LW_FORMULATION_REDUCED);
        run(deep, LW_FORMULATION_INDEX1, 2, 20, 1e-11);
        CHECK_INT(k.n, plane.n);
        for (int i = 0; i < k.n && i < plane.n; i++)
            CHECK_NEAR(k.at[i].input, plane.turn[i] - plane.turn[0], 1e-7, 0);
    }
}

/* A cart of 2 kg whose place is prescribed: its drive carries 2 a + mu m g, however slow it is.  An arm whose two joints are inputs and drives: as
 * without "drives". */
TEST(drives_carry_friction)
{
    static const char arm[] = "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 3, 'centre': [0.2, 0, 0], 'inertia': [0.1, 0.2, 0.3]}, "
        "{'name': 'B', 'mass': 1, 'centre': [0.6, 0.1, 0], 'inertia': [0.1, 0.2, 0.3]}], 'joints': [{'name': 'J', 'links': ['ground', 'A'], 'at': [0, 0, "
        "0], 'axis': [0, 0, 1], 'friction': {'coefficient': 0.3, 'radius': 0.05}}, {'name': 'K', 'links': ['A', 'B'], 'at': [0.4, 0, 0], 'axis': [0, 1, "
        "0], 'friction': {'coefficient': 0.4, 'radius': 0.03}}], 'gravity': [0, 0, -9.81], 'inputs': [{'joint': 'J', 'motion': 't*t'}, {'joint': 'K', "
        "'motion': 'sin(t)'}]%s}";
    char text[2048];
    double want[21][2];
    for (int c = 0; c < 4; c++) {                            /* slow, too; the input at the joint, or drives */
        double by = c%2 ? 1e-6 : 1;
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 2, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], 'joints': "
                 "[{'name': 'S', 'kind': 'prismatic', 'links': ['ground', 'A'], 'at': [0, 0, 0], 'axis': [1, 0, 0], 'friction': {'coefficient': 0.3}}], "
                 "'gravity': [0, 0, -10], 'tracers': [{'name': 'P', 'link': 'A', 'at': [0, 0, 0]}], 'inputs': [{%s, 'motion': '%g*(t + t*t*t)'}]%s}",
                 c/2 ? "'joint': 'S'" : "'tracer': 'P', 'coordinate': 'x'", by, c/2 ? "" : ", 'drives': [{'joint': 'S'}]");
        run(text, LW_FORMULATION_DRIVEN, 1, 20, 1e-10);
        for (int i = 0; i < k.n; i++)
            CHECK_NEAR(k.at[i].drive[0], by*2*6*k.at[i].t + 6, 1e-9, 0);
    }
    snprintf(text, sizeof text, arm, "");
    run(text, LW_FORMULATION_DRIVEN, 1, 20, 1e-10);
    CHECK_INT(k.n, 21);
    for (int i = 0; i < 21; i++)
        memcpy(want[i], k.at[i].drive, sizeof want[i]);
    snprintf(text, sizeof text, arm, ", 'drives': [{'joint': 'J'}, {'joint': 'K'}]");
    run(text, LW_FORMULATION_DRIVEN, 1, 20, 1e-10);
    for (int i = 0; i < k.n; i++)
        for (int j = 0; j < 2; j++)
            CHECK_NEAR(k.at[i].drive[j], want[i][j], 1e-9, 0);
}

/* A soft bar on a pin, and one on a guide, with friction: the implicit method, which has the reactions in its unknowns, against the explicit one,
 * which solves for them in each evaluation; and the same bar in the plane, whose elements, rows and friction are others. */
TEST(elastic_links_rub)
{
    static const char *const joint[] = { "'axis': [0, -1, 0], 'friction': {'coefficient': 0.3, 'radius': 0.05, 'speed': 0.02}",
        "'kind': 'prismatic', 'axis': [0.6, 0, -0.8], 'friction': {'coefficient': 0.4, 'speed': 0.02}" };
    static const char *const in_plane[] = { "'friction': {'coefficient': 0.3, 'radius': 0.05, 'speed': 0.02}",
        "'kind': 't', 'along': [0.6, -0.8], 'friction': {'coefficient': 0.4, 'speed': 0.02}" };
    for (int i = 0; i < 2; i++) {
        char text[1024];
        lw_vec3 explicit_one[11];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'elastic': {'section': {'shape': "
                 "'rectangle', 'width': 0.04, 'height': 0.04}, 'material': {'E': 2e7, 'G': 8e6, 'density': 1000}, 'segments': 2, "
                 "'damping': 0.001}}], 'joints': [{'name': 'J', 'links': ['ground', 'A'], 'at': [0, 0, 0], %s}], 'gravity': "
                 "[0, 0, -9.81], 'tracers': [{'name': 'P', 'link': 'A', 'at': [0.5, 0, 0]}]}", joint[i]);
        asked = LW_FORMULATION_INDEX1;
        run(text, LW_FORMULATION_INDEX1, 0.3, 10, 1e-8);
        CHECK_INT(k.n, 11);
        for (int s = 0; s < 11; s++)
            explicit_one[s] = k.at[s].tracer[0];
        asked = LW_FORMULATION_AUTO;
        run(text, LW_FORMULATION_RADAU, 0.3, 10, 1e-8);
        CHECK(k.r.energy_error < 1e-5*k.r.energy_scale);
        for (int s = 0; s < 11; s++)
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(k.at[s].tracer[0], explicit_one[s])), 0, 1e-7, 0);
        lw_model m;
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'elastic': {'section': {'shape': "
                 "'rectangle', 'width': 0.04, 'height': 0.04}, 'material': {'E': 2e7, 'G': 8e6, 'density': 1000}, 'segments': 2, "
                 "'damping': 0.001}}], 'joints': [{'name': 'J', 'links': ['ground', 'A'], 'at': [0, 0], %s}], 'gravity': "
                 "[0, -9.81], 'tracers': [{'name': 'P', 'link': 'A', 'at': [0.5, 0]}]}", in_plane[i]);
        read_planar(text, "plane", &m);
        flat_go(&m, 0.3, 10, 1e-8, &plane);
        CHECK_INT(plane.n, k.n);
        for (int s = 0; s < k.n && s < plane.n; s++)
            CHECK_NEAR(hypot(k.at[s].tracer[0].x - plane.tracer[s].x, k.at[s].tracer[0].z - plane.tracer[s].y), 0, 1e-8, 0);
    }
}

TEST(refused)
{
    static const struct { const char *joint, *why; } bad[] = {
        { "'kind': 'planar', 'axis': [0, 0, 1], 'friction': {'coefficient': 0.1}", "has no friction here" },
        { "'kind': 'spherical', 'friction': {'coefficient': 0.1}", "needs the \"radius\"" },
        { "'kind': 'prismatic', 'axis': [0, 0, 1], 'friction': {'coefficient': 0.1, 'radius': 1}", "only joints that turn" },
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        char text[1024];
        lw_spatial m;
        int n = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'A', 'mass': 1, 'centre': [0, 0, 0], 'inertia': [1, 1, 1]}], "
                         "'joints': [{'name': 'J', 'links': ['ground', 'A'], 'at': [0, 0, 0], %s}]}", bad[i].joint);
        CHECK_FAILS(lw_spatial_read(json_quotes(text), (size_t)n, "bad", &m, &check_error), LW_E_NOTATION, bad[i].why);
    }
}

/* Trees of bodies with every kind of joint: the recursive formulation, for one state and for eight at once, against that of the bodies. */
#include "mbs/equations/equations_space.h"
#include "mbs/space/kernel_tree_internal.h"
#include "tests/space_run.h"

static srun k;

static lw_formulation formulation = LW_FORMULATION_AUTO;

static lw_dynamics_report run(const lw_spatial *m, lw_analysis a, double to, int intervals, double tolerance)
{
    return srun_by(m, formulation, a, to, intervals, tolerance, &k);
}

static const char every_kind[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'a', 'mass': 1.2, 'centre': [0.3, 0.1, 0.2], 'inertia': [0.02, 0.03, 0.04, 0.002, -0.003, 0.001]}, "
    "{'name': 'b', 'mass': 0.7, 'centre': [0.6, 0.4, 0.1], 'inertia': [0.01, 0.02, 0.02, 0.001, 0.002, -0.003]}, {'name': 'c', 'mass': 0.9, 'centre': "
    "[0.9, 0.2, 0.5], 'inertia': [0.03, 0.02, 0.025, 0.003, 0.001, -0.002]}, {'name': 'd', 'mass': 0.5, 'centre': [1.2, 0.5, 0.3], 'inertia': [0.01, "
    "0.012, 0.014, 0.001, 0.0005, 0.002]}, {'name': 'e', 'mass': 0.4, 'centre': [1.5, 0.1, 0.2], 'inertia': [0.005, 0.006, 0.007, 0.001, 0.0005, "
    "0.0002]}, {'name': 'f', 'mass': 0.3, 'centre': [1.7, 0.3, 0.4], 'inertia': [0.004, 0.005, 0.006, 0.0001, 0.0005, 0.0002]}, {'name': 'g', 'mass': "
    "0.2, 'centre': [1.8, 0.2, 0.1], 'inertia': [0.004, 0.005, 0.006, 0.0001, 0.0005, 0.0002]}], 'joints': [{'name': 'C', 'kind': 'cylindrical', 'links': "
    "['ground', 'a'], 'at': [0, 0, 0], 'axis': [1, 2, -1]}, {'name': 'H', 'kind': 'screw', 'links': ['a', 'b'], 'at': [0.4, 0.2, 0.1], 'axis': [0.3, -1, "
    "0.5], 'lead': 0.4}, {'name': 'U', 'kind': 'universal', 'links': ['b', 'c'], 'at': [0.7, 0.3, 0.3], 'axis': [1, 0.2, 0.1], 'second_axis': [0.3, 1, "
    "0.4]}, {'name': 'E', 'kind': 'planar', 'links': ['c', 'd'], 'at': [1, 0.4, 0.4], 'axis': [0.2, 0.3, 1]}, {'name': 'T', 'kind': 'prismatic', 'links': "
    "['d', 'e'], 'at': [1.3, 0.3, 0.2], 'axis': [1, -1, 0.3]}, {'name': 'B', 'kind': 'spherical', 'links': ['e', 'f'], 'at': [1.6, 0.2, 0.3]}, {'name': "
    "'F', 'kind': 'fixed', 'links': ['g', 'f']}], 'springs': [{'joint': 'C', 'coordinate': 'slide', 'stiffness': 40}, {'joint': 'H', 'coordinate': "
    "'turn', 'stiffness': 2}, {'joint': 'T', 'stiffness': 30, 'free': 0.05},  {'links': ['c', 'd'], 'at': [[0.9, 0.4, 0.5], [1.2, 0.5, 0.2]], "
    "'stiffness': 50}, {'links': ['ground', 'g'], 'at': [[1.5, 0.5, 1], [1.9, 0.2, 0.3]], 'stiffness': 25}], 'inputs': [{'joint': 'C', 'coordinate': "
    "'turn', 'speed': 2}, {'joint': 'H', 'coordinate': 'turn', 'speed': -3}, {'joint': 'T', 'speed': 0.3}], 'gravity': [0.5, -1, -9.81], 'tracers': "
    "[{'name': 'P', 'link': 'g', 'at': [2, 0.2, 0.1]}]}";

/* A chain with every kind of joint keeps its energy: wrong rows, or wrong second rates, would change it. */
TEST(every_joint_keeps_energy)
{
    OWN(lw_spatial) m = { 0 };
    read_spatial(every_kind, "kinds", &m);
    lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 1, 10, 1e-12);
    CHECK_INT(q.freedom, 12);
    CHECK(q.energy_error < 1e-11*q.energy_scale);
    CHECK(k.off < 1e-12);
}

/* Swap the links of every joint. */
static void swap_links(lw_spatial *m)
{
    for (int j = 0; j < m->n_joint; j++) {
        lw_spatial_joint *p = &m->joint[j];
        int link = p->link[0];
        lw_vec3 axis = p->axis;
        p->link[0] = p->link[1], p->link[1] = link;
        if (p->kind == LW_SPATIAL_UNIVERSAL)
            p->axis = p->second, p->second = axis;
    }
}

/* The kinds of joints in a chain whose last link has such a joint to the ground as well; turned: link 0 is the outer one. */
static void make_kinds(lw_spatial_kind closing, bool turned, lw_spatial *m)
{
    read_spatial(every_kind, "kinds", m);
    if (turned)
        swap_links(m);
    m->joint = realloc(m->joint, sizeof *m->joint*((size_t)m->n_joint + 1));
    m->joint[m->n_joint++] = (lw_spatial_joint){ .name = "closing", .kind = closing, .link = { m->n_link - 1, m->ground },
        .at = { 2, 0.2, 0.1 }, .axis = { 0.6, 0, 0.8 }, .second = { 0, 1, 0 }, .lead = 0.3 };
}

/* The same motion and forces in the coordinates of the joints as in those of the bodies, in all rows of a run of 0.3 s. */
static void check_that_both_agree(const lw_spatial *m, int intervals)
{
    static srow bodies[40];
    for (int f = 0; f < 2; f++) {
        formulation = f ? LW_FORMULATION_RECURSIVE : LW_FORMULATION_INDEX1;
        lw_dynamics_report q = run(m, LW_ANALYSIS_TRANSIENT, 0.3, intervals, 1e-11);
        CHECK_INT(q.formulation, formulation);
        CHECK_INT(k.n, intervals + 1);
        CHECK(k.off < 1e-12 && k.off_rate < 1e-11);
        CHECK(q.energy_error < 1e-9*q.energy_scale);
        if (f == 0)
            memcpy(bodies, k.at, sizeof *bodies*(size_t)k.n);
    }
    for (int i = 0; i < k.n; i++) {
        const srow *by = &k.at[i], *to = &bodies[i];
        double most = 0;
        for (int n = 0; n < 6*(m->n_link - 1); n++)
            most = fmax(most, fabs(to->a[n]));
        for (int n = 0; n < 7*(m->n_link - 1); n++)
            CHECK_NEAR(by->q[n], n%7 < 3 || by->q[n]*to->q[n] > 0 ? to->q[n] : -to->q[n], 1e-9, 0);
        for (int n = 0; n < 6*(m->n_link - 1); n++) {
            CHECK_NEAR(by->v[n], to->v[n], 1e-8, 1e-8);
            CHECK_NEAR(by->a[n], to->a[n], 1e-7*most, 0);
        }
        CHECK_NEAR(by->work, to->work, 1e-9, 1e-8);
        CHECK_NEAR(by->drive[0], to->drive[0], 1e-6*(1 + fabs(to->drive[0])), 0);
        for (int j = 0; j < m->n_joint; j++) {
            lw_spatial_reaction a = to->joint[j], b = by->joint[j];
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(b.force, a.force)), 0, 1e-7*(1 + lw_v3_norm(a.force)), 0);
            CHECK_NEAR(lw_v3_norm(lw_v3_sub(b.moment, a.moment)), 0, 1e-7*(1 + lw_v3_norm(a.moment)), 0);
        }
    }
    formulation = LW_FORMULATION_AUTO;
}

/* Joints of every kind, either link first, in an open chain and in a loop closed by each kind, which cuts the joint with the fewest rows; an
 * input that is driven in half of them.  Then without what keeps steps and rows of output from working at eight states at once: springs in
 * joints, drives, screws; forty rows, some within one step, with dampers. */
TEST(recursive_and_bodies_agree)
{
    static const lw_spatial_kind closing[] = { LW_SPATIAL_FREE, LW_SPATIAL_REVOLUTE, LW_SPATIAL_PRISMATIC, LW_SPATIAL_CYLINDRICAL,
                                               LW_SPATIAL_SPHERICAL, LW_SPATIAL_UNIVERSAL, LW_SPATIAL_SCREW, LW_SPATIAL_PLANAR };
    for (int i = 0; i < 32; i++) {
        OWN(lw_spatial) m = { 0 };
        make_kinds(closing[i/2%8], i%2, &m);
        if (i >= 16) {
            m.n_joint_spring = 0;
            m.joint[1].kind = LW_SPATIAL_REVOLUTE;
            for (int j = 0; j < m.n_spring; j++)
                m.spring[j].damping = 3;
        }
        else if ((i/2 + i)%2)
            CHECK_OK(lw_spatial_set_motion(&m, 0, "t + 0.3*sin(2*t)", &check_error));
        check_that_both_agree(&m, i < 16 ? 1 : 39);
    }
    for (int i = 0; i < 2; i++) {            /* rows that depend on others: the multipliers of least norm */
        OWN(lw_spatial) m = { 0 };
        load_spatial(i ? "bennett" : "bricard", &m);
        for (int j = 0; j < m.n_input; j++)
            m.input[j].has_speed = true, m.input[j].speed = 2;
        check_that_both_agree(&m, 39);
    }
}

/* Calls with the factors of states y find the rates of states nearby, in the same bits by every kernel; of states far off at once. */
static void repeat_calls(lw_tree_stages *s, lw_rng *rng, const double *y)
{
    const int n = s->n_x + s->n_u, first = 8*s->n_x;
    const size_t bytes = 8*sizeof *y*(size_t)(s->n_u + 1);
    double near[8*64], at_y[8*64], exact[8*64], found[8*64], other[8*64];
    CHECK_INT(lw_tree_stages_rates(s, false, y, at_y), LW_OK);
    const double little = 0.07/s->n_x*fmin(1, 100*s->weak);  /* all coordinates together; near singular postures the factors change fast */
    for (int far = 0; far < 2; far++) {
        for (int j = 0; j < 8*n; j++)
            near[j] = y[j] + (far ? 0.3 : little)*lw_rng_range(rng, -1, 1);
        CHECK_INT(lw_tree_stages_rates(s, false, near, exact), LW_OK);
        for (int rank = 0; lw_kernels_supported(rank); rank++) {
            s->kernel = lw_tree_kernel_of(lw_kernels_supported(rank)->isa);
            CHECK_INT(lw_tree_stages_rates(s, false, y, at_y), LW_OK);
            memcpy(found, at_y, sizeof found);
            for (int i = 0; i < (far ? 1 : 12); i++) {
                CHECK_INT(lw_tree_stages_rates(s, true, near, found), LW_OK);
                CHECK(i > 0 || far || memcmp(found + first, exact + first, bytes) != 0);     /* not factored anew */
            }
            CHECK(rank == 0 || memcmp(found + first, other + first, bytes) == 0);
            memcpy(other, found, sizeof other);
            for (int j = first; j < first + 8*s->n_u; j++)
                CHECK_NEAR(found[j], exact[j], far ? 0 : 1e-9, far ? 0 : 1e-9);
        }
    }
}

/* Rates of eight states together are those of one state after the other, in every instruction set to the bit.  Coordinates are random, up to
 * `far` from those of the file, but for one [m] in the first state, where legs must be solved with all loops.  Returns how many rows hold legs. */
static int compare_eight(lw_spatial *m, lw_rng *rng, double far, int given, double value, bool repeats)
{
    OWN(lw_spatial_scene) c = { 0 };
    OWN(lw_recursive) r = { 0 };
    OWN(lw_tree_stages) s = { 0 };
    CHECK_OK(lw_spatial_scene_make(m, &c, &check_error));
    CHECK_OK(lw_recursive_make(&c.s, c.mass, NULL, 0, &r, &check_error));
    CHECK_INT(lw_tree_stages_make(&r, &c.f, &s), LW_OK);
    s.has_work = true;
    const int n = r.n_x + r.n_u;
    double y[8*64], dy[8*64], again[8*64], x[64], dx[64], q[128], v[128], force[128], power;
    CHECK(n < 64 && c.s.n_q <= 128);
    for (int j = 0; j < 8*n; j++)
        y[j] = far*lw_rng_range(rng, -1, 1);
    for (int i = 0; i < c.s.n_body && far < 1; i++)
        for (int lane = 0; lane < 8 && (r.body[i].kind == LW_SPATIAL_SPHERICAL || r.body[i].kind == LW_SPATIAL_FREE); lane++)
            y[8*(r.body[i].x + r.body[i].n_u - 3) + lane] += 1;
    int held = 0;
    for (int lane = 7; lane >= 0; lane--) {
        for (int j = 0; j < n; j++)
            x[j] = y[8*j + lane];
        lw_recursive_place(&r, x, q);
        lw_recursive_velocities(&r, x + r.n_x, v);
        lw_recursive_rows(&r, NULL, NULL, c.f.turn, v);
        lw_space_forces_apply(&c.f, 0, r.frame, v, force, &power, NULL);
        if (lane == 7) {
            CHECK_INT(lw_recursive_factor(&r), LW_OK);
            lw_tree_stages_keep_rows(&s, &r);
            held = s.n_apart;
            if (given >= 0)
                y[8*given] = value/c.s.unit;
            CHECK_INT(lw_tree_stages_rates(&s, false, y, dy), LW_OK);
            lw_tree_stages_motion(&s, y, dy);
            CHECK_INT(s.n_apart, given < 0 ? held : 0);
        }
        CHECK_INT(lw_recursive_factor(&r), LW_OK);
        lw_recursive_solve(&r, force, LW_WANT_MOTION, dx + r.n_x);
        lw_recursive_rates(&r, x, x + r.n_x, dx);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(dy[8*j + lane], dx[j], 1e-9, 1e-9);
        CHECK_NEAR(dy[8*n + lane], power, 1e-12, 1e-12);
    }
    for (int rank = 1; lw_kernels_supported(rank); rank++) {
        s.kernel = lw_tree_kernel_of(lw_kernels_supported(rank)->isa);
        lw_tree_stages_keep_rows(&s, &r);
        CHECK_INT(lw_tree_stages_rates(&s, false, y, again), LW_OK);
        CHECK(rank == 1 || memcmp(again + 8*r.n_x, dy + 8*r.n_x, 8*sizeof *dy*(size_t)(r.n_u + 1)) == 0);
        memcpy(dy, again, sizeof dy);
    }
    if (repeats)
        repeat_calls(&s, rng, y);
    return held;
}

/* Joints of every kind, either link first, an open chain and loops closed by joints of every kind but screws, springs and dampers. */
TEST(eight_states_at_once)
{
    static const lw_spatial_kind closing[] = { LW_SPATIAL_FREE, LW_SPATIAL_REVOLUTE, LW_SPATIAL_PRISMATIC, LW_SPATIAL_CYLINDRICAL,
                                               LW_SPATIAL_SPHERICAL, LW_SPATIAL_UNIVERSAL, LW_SPATIAL_PLANAR, LW_SPATIAL_FIXED };
    for (int i = 0; i < 16; i++) {
        OWN(lw_spatial) m = { 0 };
        lw_rng rng;
        lw_rng_seed(&rng, 7, (uint64_t)i);
        make_kinds(closing[i/2], i%2, &m);
        m.n_joint_spring = 0;
        for (int j = 0; j < m.n_spring; j++)
            m.spring[j].damping = 3;
        CHECK_INT(compare_eight(&m, &rng, 1, -1, 0, true), 0);
    }
}

/* Legs of two links from the ground to a platform, or back to the ground, with three joints of these kinds. */
static void make_legs(const char *const kind[3], int n, bool platform, lw_rng *rng, lw_spatial *m)
{
    char text[9000], links[4000] = "'ground'", joints[4000] = "";
    for (int i = 0; i < n; i++) {
        double a = 2*LW_PI*i/n, foot[3] = { cos(a), sin(a), 0 }, head[3] = { 0.5*cos(a + 0.3), 0.5*sin(a + 0.3), 1 };
        for (int j = 0; j < 2; j++) {
            double at[3];
            for (int c = 0; c < 3; c++)
                at[c] = (foot[c]*(2 - j) + head[c]*(1 + j))/3;
            sprintf(links + strlen(links), ", {'name': '%c%d', 'mass': 1.1, 'centre': [%.9f, %.9f, %.9f], 'inertia': [0.02, 0.03, 0.04]}", "ab"[j], i,
                    at[0], at[1], at[2]);
        }
        for (int j = 0; j < 3; j++) {
            double at[3], axis[3], second[3];
            for (int c = 0; c < 3; c++) {
                at[c] = 0.5*(foot[c]*(2 - j) + head[c]*j) + (j == 1 ? 0.4*foot[c] : 0);          /* knees stand out */
                axis[c] = strcmp(kind[j], "prismatic") ? lw_rng_range(rng, -1, 1) : head[c] - foot[c];
                second[c] = lw_rng_range(rng, -1, 1);
            }
            char outer[8], inner[8];
            snprintf(inner, sizeof inner, j ? "%c%d" : "ground", " ab"[j], i);
            snprintf(outer, sizeof outer, j < 2 ? "%c%d" : platform ? "plate" : "ground", "ab "[j], i);
            sprintf(joints + strlen(joints), "%s{'name': 'j%d%d', 'kind': '%s', 'links': ['%s', '%s'], 'at': [%.9f, %.9f, %.9f]", *joints ? ", " : "",
                    i, j, kind[j], inner, outer, at[0], at[1], at[2]);
            if (strcmp(kind[j], "spherical"))
                sprintf(joints + strlen(joints), ", 'axis': [%.9f, %.9f, %.9f]", axis[0], axis[1], axis[2]);
            if (!strcmp(kind[j], "universal"))
                sprintf(joints + strlen(joints), ", 'second_axis': [%.9f, %.9f, %.9f]", second[0], second[1], second[2]);
            strcat(joints, "}");
        }
    }
    if (platform)
        strcat(links, ", {'name': 'plate', 'mass': 3, 'centre': [0.1, 0, 1], 'inertia': [0.2, 0.3, 0.4]}");
    snprintf(text, sizeof text, "{'linkwright': 1, 'links': [%s], 'joints': [%s], 'gravity': [0, 1, -9.81], 'springs': [{'links': ['ground', '%s'], "
             "'at': [[0, 0, 2], [0.2, 0.1, 1]], 'stiffness': 50, 'damping': 2}]}", links, joints, platform ? "plate" : "a0");
    read_spatial(text, "legs", m);
}

/* Legs that hold themselves when their platform's acceleration is known are solved one by one: with as many rates as rows, with fewer, so that
 * rows of the platform are left, and legs that end at the ground.  In one state a leg is so short that its rows hold it no more.  Two chains
 * that form one loop are not legs. */
TEST(legs_one_by_one)
{
    static const struct { const char *kind[3]; int n; bool platform; int held; } robot[] = {
        { { "universal", "prismatic", "spherical" }, 6, true, 15 }, { { "universal", "prismatic", "spherical" }, 3, true, 6 },
        { { "revolute", "prismatic", "spherical" }, 3, true, 4 }, { { "revolute", "revolute", "universal" }, 3, true, 4 },
        { { "revolute", "universal", "spherical" }, 2, false, 6 }, { { "spherical", "revolute", "spherical" }, 3, true, 6 },
        { { "universal", "prismatic", "spherical" }, 2, true, 0 } };
    for (int i = 0; i < (int)(sizeof robot/sizeof *robot); i++) {
        OWN(lw_spatial) m = { 0 };
        lw_rng rng;
        lw_rng_seed(&rng, 9, (uint64_t)i);
        make_legs(robot[i].kind, robot[i].n, robot[i].platform, &rng, &m);
        CHECK_INT(compare_eight(&m, &rng, 0.1, -1, 0, true), robot[i].held);
        if (i == 0)                          /* its feet and heads are sqrt(9/4 - cos 0.3) apart; coordinate 17: the slide of the last one */
            CHECK_INT(compare_eight(&m, &rng, 0.1, 17, 1e-6 - sqrt(2.25 - cos(0.3)), false), robot[i].held);
    }
}

/* Loops that stay open from step to step are closed in rows of output, within steps and at the end, and do not open farther than an error. */
TEST(rows_are_closed)
{
    OWN(lw_spatial) m = { 0 };
    lw_rng rng;
    lw_rng_seed(&rng, 9, 0);
    const char *const kind[3] = { "universal", "prismatic", "spherical" };
    make_legs(kind, 6, true, &rng, &m);
    formulation = LW_FORMULATION_RECURSIVE;
    for (int i = 11; i >= 2; i -= 3) {
        static double exact[64];
        lw_dynamics_report q = run(&m, LW_ANALYSIS_TRANSIENT, 0.5, 7, pow(10, -i));
        CHECK(k.off < 1e-13 && k.off_rate < 1e-12);
        CHECK(q.energy_error < pow(10, -i)*q.energy_scale);
        if (i == 11)
            memcpy(exact, k.at[7].q, sizeof exact);
        for (int j = 0; j < 64; j++)
            CHECK_NEAR(k.at[7].q[j], exact[j], 3*pow(10, -i), 0);
    }
    formulation = LW_FORMULATION_AUTO;
}

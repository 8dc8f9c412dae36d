/* tests/test_statics.c - equilibrium: one of several, none, saddles, neutral ones; trusses, redundant supports;
 * power of machines in motion. */

#include "mbs/analysis/reactions.h"
#include "tests/dynamics_run.h"

static drun d;
static lw_rest found;
static lw_reaction reaction[LW_JOINT_MAX];
static lw_dynamics *made;
static double q[LW_SYSTEM_Q_MAX];

static lw_status keep_reactions(void *context, const lw_moment *m)
{
    lw_reactions_joints(made, m, reaction);
    *(bool *)context = m->unique;
    return LW_OK;
}

/* Equilibrium of a model written with single quotes, and its reactions */
static lw_status rest_of(const char *format, double a, double b, bool *unique)
{
    lw_rest none = { 0 };
    found = none;
    drun_read_format(&d, format, a, b);
    d.o.analysis = LW_ANALYSIS_STATIC;
    lw_status s = lw_dynamics_make(&d.model, &d.o, &made, &d.e);
    CHECK_INT(s, LW_OK);
    if (s == LW_OK)
        s = lw_statics_rest(made, 0, q, &found, &d.e);
    if (s == LW_OK)
        s = lw_statics_moment(made, 0, q, keep_reactions, unique, &d.e);
    return s;
}

static void drop(void)
{
    lw_dynamics_free(made);
}

/* ---- one freedom ---------------------------------------------------------------------------------- */

static const char pendulum[] = "{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.1}], "
    "'joints': [{'name': 'O', 'links': ['ground', 'rod'], 'at': [0, 0]}], 'gravity': [0, -9.81]}";

/* From the upper rest, from just beside it and from the side the pendulum goes down, even if its centre is as little above the pin as may be
 * and a stiff spring stands beside it.  With its centre in the pin it rests anywhere. */
TEST(saddles)
{
    static const double start[][2] = { { 0, 1 }, { 1e-9, 1 }, { 1, 0 }, { -0.6, 0.8 } };
    bool unique;
    for (int i = 0; i < 4; i++) {
        CHECK_INT(rest_of(pendulum, start[i][0], start[i][1], &unique), LW_OK);
        CHECK(found.stable && unique);
        CHECK_NEAR(cos(q[2])*start[i][1] + sin(q[2])*start[i][0], -hypot(start[i][0], start[i][1]), 1e-12, 0);
        CHECK_NEAR(reaction[0].force.y, 9.81, 1e-12, 0);
        drop();
    }
    CHECK_INT(rest_of(pendulum, 0, 0, &unique), LW_OK);
    CHECK(!found.stable && found.neutral);
    CHECK_NEAR(q[2], 0, 1e-12, 0);
    drop();
    for (int k = 3; k <= 6; k++) {
        CHECK_INT(rest_of("{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': 1, 'centre': [0, %.17g], 'inertia': 0.01}, {'name': 'block', "
                          "'mass': 1, 'centre': [0.5, 0], 'inertia': 0.01}], 'joints': [{'name': 'O', 'links': ['ground', 'rod'], 'at': [0, 0]}, {'name': 'S', "
                          "'kind': 't', 'links': ['ground', 'block'], 'at': [0.5, 0], 'along': [0, 1]}], 'springs': [{'joint': 'S', 'stiffness': %.17g}], "
                          "'gravity': [0, -9.81]}", 1e-6, pow(10, k), &unique), LW_OK);
        CHECK(found.stable && unique);
        CHECK_NEAR(fabs(remainder(q[2], 2*LW_PI)), LW_PI, 1e-9, 0);
        drop();
    }
}

/* A rod of length 1 at (0, 0), its tip at angle a, a spring of free length 2 from there to (0, 2): the spring has its
 * free length where |tip - (0, 2)|^2 = 5 - 4 sin a = 4, which is so at two angles, and the nearer one is found. */
static const char two_rests[] = "{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': 1, 'centre': [0, 0], 'inertia': 1}],'joints': "
    "[{'name': 'O', 'links': ['ground', 'rod'], 'at': [0, 0]}],'springs': [{'links': ['ground', 'rod'], 'at': [[0, 2], [%.17g, %.17g]], 'stiffness': "
    "100, 'free': 2}]}";

TEST(nearest_of_several)
{
    bool unique;
    for (int i = 0; i < 16; i++) {
        double a = -LW_PI/2 + 2*LW_PI*(i + 0.5)/16, low = asin(0.25), want = cos(a) > 0 ? low : LW_PI - low;
        CHECK_INT(rest_of(two_rests, cos(a), sin(a), &unique), LW_OK);
        CHECK(found.stable);
        CHECK_NEAR(remainder(a + q[2] - want, 2*LW_PI), 0, 1e-12, 0);
        CHECK_NEAR(lw_v2_norm(reaction[0].force), 0, 1e-9, 0);
        drop();
    }
}

/* Pushed along its slide for ever; against a rigid stop; held by a compliant one */
TEST(no_rest)
{
    static const char pushed[] = "{'linkwright': 1, 'links': ['ground', {'name': 'block', 'mass': 1, 'centre': [0, 0]}],'joints': [{'name': 'P', "
    "'kind': 't', 'links': ['ground', 'block'], 'at': [0, 0], 'along': [1, 0]}],'forces': [{'link': 'block', 'at': [0, 0], 'fx': %g, 'fy': %g}]}";
    static const char stopped[] = "{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': %g, 'centre': [1, 0], 'inertia': 0.1}], 'joints': "
    "[{'name': 'O', 'links': ['ground', 'rod'], 'at': [0, 0], 'stop': {'least': -0.5, 'stiffness': %g}}], 'gravity': [0, -10]}";
    bool unique;
    CHECK_INT(rest_of(pushed, 3, 0, &unique), LW_NOTHING);
    CHECK_HAS(d.e.text, "no static equilibrium");
    drop();
    drun_read_format(&d, "{'linkwright': 1, 'links': ['ground', {'name': 'rod', 'mass': %g, 'centre': [1, 0]}], 'joints': [{'name': 'O', 'links': "
    "['ground', 'rod'], 'at': [0, 0], 'stop': {'least': %g}}], 'gravity': [0, -10]}",
                     1, -0.5);
    d.o.analysis = LW_ANALYSIS_STATIC;
    CHECK_INT(lw_dynamics_make(&d.model, &d.o, &made, &d.e), LW_OK);
    CHECK_INT(lw_statics_rest(made, 0, q, &found, &d.e), LW_NOTHING);
    CHECK_HAS(d.e.text, "beyond that of joint \"O\"");
    drop();
    CHECK_INT(rest_of(stopped, 2, 1e6, &unique), LW_OK);
    double a = -0.5;                                     /* 1e6 depth = m g cos(a), depth = -0.5 - a */
    for (int i = 0; i < 50; i++)
        a = -0.5 - 20*cos(a)/1e6;
    CHECK_NEAR(q[2], a, 1e-13, 0);
    drop();
}

/* ---- trusses -------------------------------------------------------------------------------------- */

/* Two bars from (-1, 0) and (1, 0) to an apex at (0, 1) that carries fx, fy: bar forces (fy +- fx)/sqrt(2) */
TEST(truss)
{
    static const char two_bars[] = "{'linkwright': 1, 'links': ['ground', 'a', 'b'], 'joints': [{'name': 'A', 'links': ['ground', 'a'], 'at': [-1, "
        "0]}, {'name': 'B', 'links': ['ground', 'b'], 'at': [1, 0]},{'name': 'C', 'links': ['a', 'b'], 'at': [0, 1]}],'forces': [{'link': 'b', 'at': "
        "[0, 1], 'fx': %.17g, 'fy': %.17g}]}";
    bool unique;
    double fx = 3, fy = -7;
    CHECK_INT(rest_of(two_bars, fx, fy, &unique), LW_OK);
    CHECK(unique && found.stable);
    CHECK_NEAR(reaction[0].force.x, -(fx + fy)/2, 1e-12, 0);         /* both along their bars */
    CHECK_NEAR(reaction[0].force.y, -(fx + fy)/2, 1e-12, 0);
    CHECK_POINT(reaction[1].force, (fy - fx)/2, -(fy - fx)/2, 1e-12, 0);
    drop();
}

/* A beam on three upright legs: reactions are not unique, and those of least norm are reported; by symmetry the
 * outer ones are equal, and all three add up to the load. */
TEST(redundant_legs)
{
    static const char legs[] = "{'linkwright': 1, 'links': ['ground', 'a', 'b', 'c', {'name': 'beam', 'mass': %g, 'centre': [0, %g]}], 'joints': "
    "[{'name': 'A', 'links': ['ground', 'a'], 'at': [-1, 0]}, {'name': 'B', 'links': ['ground', 'b'], 'at': [0, 0]}, {'name': 'C', 'links': "
    "['ground', 'c'], 'at': [1, 0]}, {'name': 'D', 'links': ['a', 'beam'], 'at': [-1, 1]}, {'name': 'E', 'links': ['b', 'beam'], 'at': [0, 1]}, "
    "{'name': 'F', 'links': ['c', 'beam'], 'at': [1, 1]}], 'gravity': [0, -10], 'springs': [{'joint': 'A', 'stiffness': 1e4}]}";
    char names[256];
    bool unique;
    CHECK_INT(rest_of(legs, 6, 1, &unique), LW_OK);
    CHECK(!unique && found.stable);
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(reaction[i].force.y, 20, 1e-9, 0);
    lw_dynamics_redundant(made, names, sizeof names);
    CHECK_HAS(names, "A");
    CHECK_HAS(names, "F");
    drop();
}

/* ---- powers --------------------------------------------------------------------------------------- */

typedef struct power { double worst, most, off, most_force; int n; } power;

/* For every link cut free: the forces of its joints, loads and driving torque equal its mass times its acceleration. */
static void cut_free(const lw_moment *m, double drive, const double *load, power *p)
{
    const lw_system *s = lw_dynamics_system(made);
    lw_reaction sum[LW_LINK_MAX] = { 0 };
    lw_reactions_joints(made, m, reaction);
    for (int j = 0; j < s->n_joint; j++) {
        const lw_system_joint *k = &s->joint[j];
        lw_vec2 at = lw_system_point(s, k->body[1], k->arm[1], m->q);
        for (int end = 0; end < 2; end++) {
            int b = k->body[end];
            if (b < 0)
                continue;
            double sign = end ? 1 : -1, up = k->body[1] < 0 ? -sign : sign;
            lw_vec2 f = lw_v2_scale(reaction[j].force, sign);
            sum[b].force = lw_v2_add(sum[b].force, f);
            lw_vec2 arm = lw_v2_sub(at, lw_system_point(s, b, lw_v2(0, 0), m->q));
            sum[b].moment += sign*reaction[j].moment + lw_v2_cross(arm, f)
                           + (j == s->input_joint[0] ? up*drive : 0);
            p->most_force = fmax(p->most_force, lw_v2_norm(f));
        }
    }
    for (int b = 0; b < s->n_body; b++) {
        const lw_body *body = &d.model.body[s->link[b]];
        lw_vec2 a = lw_v2(m->a[3*b]*s->unit, m->a[3*b + 1]*s->unit);
        lw_vec2 applied = lw_v2_scale(lw_v2(load[3*b], load[3*b + 1]), 1/s->unit);
        lw_vec2 left = lw_v2_sub(lw_v2_add(sum[b].force, applied), lw_v2_scale(a, body->mass));
        p->off = fmax(p->off, lw_v2_norm(left));
        p->off = fmax(p->off, fabs(sum[b].moment + load[3*b + 2] - body->inertia*m->a[3*b + 2]));
    }
}

/* The power of the driving torques equals that of masses and weights. */
static lw_status look_at_power(void *context, const lw_moment *m)
{
    power *p = context;
    double drive[LW_INPUT_MAX], row[LW_SYSTEM_Q_MAX], rate = 0, change = 0, force[LW_SYSTEM_Q_MAX];
    const lw_system *s = lw_dynamics_system(made);
    const lw_forces *f = lw_dynamics_forces(made);
    lw_reactions_driving(made, m, drive);
    lw_system_measure(s, s->input_joint[0], m->q, row);
    for (int i = 0; i < s->n_q; i++)
        rate += row[i]*m->v[i];
    lw_forces_apply(f, m->t, m->q, m->v, force, NULL, NULL, NULL);
    for (int i = 0; i < s->n_q; i++)
        change += m->v[i]*(f->mass[i]*m->a[i] - force[i]);
    p->worst = fmax(p->worst, fabs(drive[0]*rate - change));
    p->most = fmax(p->most, fabs(change));
    p->n++;
    cut_free(m, drive[0], force, p);
    return LW_OK;
}

static const char watt[] = "{'linkwright': 1, 'links': ['ground', 'crank', 'coupler', 'rocker', 'arm', 'stay'], 'joints': [{'name': 'A', 'links': "
    "['ground', 'crank'], 'at': [0, 0]}, {'name': 'B', 'links': ['crank', 'coupler'], 'at': [%g, 0]},{'name': 'C', 'links': ['coupler', 'rocker'], "
    "'at': [0.4, 0.4]}, {'name': 'D', 'links': ['rocker', 'ground'], 'at': [%g, 0]}, {'name': 'E', 'links': ['coupler', 'arm'], 'at': [0.3, 0.6]}, "
    "{'name': 'F', 'links': ['arm', 'stay'], 'at': [0.7, 0.8]}, {'name': 'G', 'links': ['rocker', 'stay'], 'at': [0.75, 0.45]}], 'input': {'joint': "
    "'A'}}";

/* A full turn of driven machines under weight in a slanting direction */
TEST(machines)
{
    for (int i = 0; i < 3; i++) {
        power p = { 0 };
        char motion[96];
        if (i == 2)
            drun_read_format(&d, watt, 0.1, 0.5);
        else
            drun_read(&d, i ? "examples/jansen.json" : "examples/andrews.json");
        lw_assembly *k = &d.model.linkage;
        for (int j = 0; j < k->n_joint; j++)
            for (int end = 0; end < 2; end++)
                if (k->joint[j].link[end] != k->ground && !d.model.body[k->joint[j].link[end]].given)
                    d.model.body[k->joint[j].link[end]] = (lw_body){ .given = true,
                        .mass = 0.5 + 0.1*j, .centre = lw_v2_add(k->joint[j].at, lw_v2(0.01*j, 0.02)), .inertia = 0.01 };
        double w = i ? 3 : 100;
        snprintf(motion, sizeof motion, "%.17g + %g*t", k->input[0].value, w);
        CHECK_INT(lw_model_drive(&d.model, 0, motion, &d.e), LW_OK);
        d.model.gravity = lw_v2(1, -9.81);
        d.o.analysis = LW_ANALYSIS_KINEMATIC;
        d.o.to = 2*LW_PI/w, d.o.intervals = 40;
        lw_status s = lw_dynamics_make(&d.model, &d.o, &made, &d.e);
        if (s == LW_OK)
            s = lw_dynamics_run(made, look_at_power, &p, &d.report, &d.e);
        if (s != LW_OK)
            fprintf(stderr, "machine %d: %s\n", i, d.e.text);
        CHECK_INT(s, LW_OK);
        CHECK_INT(p.n, 41);
        CHECK(p.most > 0 && p.worst < 1e-10*p.most);
        CHECK(p.most_force > 0 && p.off < 1e-10*p.most_force);
        drop();
    }
}

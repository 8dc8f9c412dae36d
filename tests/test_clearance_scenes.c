/* tests/test_clearance_scenes.c - clearance together with friction, stops, sliders and further loops; laws of contact
 * against one another where they must agree. */
#include "mbs/clearance/clearance.h"
#include "tests/clearance_models.h"
#include "tests/dynamics_run.h"
#include "tests/planar_models.h"

static lw_clearance_result run(const lw_model *m, lw_clearance_options o, track *t)
{
    lw_clearance_scene *scene = NULL;
    lw_clearance_result r = { 0 };
    t->n = 0;
    o.sink = keep, o.context = t;
    lw_status s = lw_clearance_make(m, &scene, &check_error);
    if (s == LW_OK)
        s = lw_clearance_run(scene, &o, &r, &check_error);
    CHECK_OK(s);
    lw_clearance_free(scene);
    return r;
}

/* ---- against the equations of all bodies ---------------------------------------------------------- */

typedef struct twin { lw_system s; int n; double value[256], rate[256], energy[256]; } twin;

static lw_status keep_twin(void *context, const lw_moment *m)
{
    twin *t = context;
    double row[LW_SYSTEM_Q_MAX], scale = t->s.joint[t->s.input_joint[0]].kind == LW_JOINT_REVOLUTE ? 1 : t->s.unit;
    t->value[t->n] = t->s.input_value[0] + scale*lw_system_measure(&t->s, t->s.input_joint[0], m->q, row);
    t->rate[t->n] = 0;
    for (int i = 0; i < t->s.n_q; i++)
        t->rate[t->n] += scale*row[i]*m->v[i];
    t->energy[t->n++] = m->kinetic + m->potential;
    return LW_OK;
}

/* The same model by mbs/dynamics/dynamics.h, without clearance; number of impacts on stops */
static long same_motion(const lw_model *m, double time, int samples, double tight)
{
    twin t = { 0 };
    track k;
    lw_dynamics *d = NULL;
    lw_dynamics_report r;
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_DYNAMIC, o.formulation = LW_FORMULATION_INDEX1;
    o.to = time, o.intervals = samples, o.relative = o.absolute = 1e-11;
    lw_status s = lw_dynamics_make(m, &o, &d, &check_error);
    if (s == LW_OK) {
        t.s = *lw_dynamics_system(d);        /* as long as d */
        s = lw_dynamics_run(d, keep_twin, &t, &r, &check_error);
    }
    CHECK_OK(s);
    lw_clearance_options c = lw_clearance_options_default();
    c.time = time, c.settle = 0, c.every = time/samples, c.tolerance = 1e-11;
    long strikes = run(m, c, &k).strikes;
    CHECK_INT(k.n, t.n);
    for (int i = 0; i < k.n && i < t.n; i++) {
        CHECK_NEAR(k.s[i].input, t.value[i], tight, 0);
        CHECK_NEAR(k.s[i].input_rate, t.rate[i], 30*tight, 0);
        CHECK_NEAR(k.s[i].energy, t.energy[i], 100*tight, 0);
    }
    lw_dynamics_free(d);
    return strikes;
}

static void give_friction(lw_model *m, double mu, double radius, double speed)
{
    for (int j = 0; j < m->linkage.n_joint; j++)
        if (m->linkage.joint[j].kind != LW_JOINT_GEAR && m->linkage.joint[j].kind != LW_JOINT_FIXED)
            m->friction[j] = (lw_friction){ mu, radius, speed };
}

/* Friction in every pin, the held journal among them */
TEST(friction_without_gap)
{
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    m.clearance[2].model = LW_CLEARANCE_ZERO;
    m.clearance[2].friction = 0;
    give_friction(&m, 0.2, 0.02, 0.05);
    same_motion(&m, 1.0, 50, 1e-7);
}

static const char slider_crank[] = "{'linkwright': 1, 'links': ['ground',{'name': 'crank', 'mass': 2, 'centre': [0, 0.05], 'inertia': 0.01},{'name': "
    "'rod', 'mass': 1, 'centre': [0.15, 0.05], 'inertia': 0.008},{'name': 'piston', 'mass': 1.5, 'centre': [0.3, 0], 'inertia': 0.002}], 'joints': ["
    "{'name': 'O', 'links': ['ground', 'crank'], 'at': [0, 0]},{'name': 'A', 'links': ['crank', 'rod'], 'at': [0, 0.1]},{'name': 'B', 'links': ['rod', "
    "'piston'], 'at': [0.3, 0], 'clearance': {'model': 'zero', 'gap': 1e-4, 'stiffness': 1e7, 'damping': 1000, 'depth': 1e-6}},{'name': 'P', 'kind': 't', "
    "'links': ['ground', 'piston'], 'at': [0.3, 0], 'along': [1, 0]}],'input': {'joint': 'O', 'speed': 8}, 'gravity': [0, -9.81]}";

TEST(friction_of_a_slider)
{
    OWN(lw_model) m = { 0 };
    read_planar(slider_crank, "text", &m);
    give_friction(&m, 0.15, 0.01, 0.02);
    same_motion(&m, 0.8, 40, 1e-7);
    m.clearance[2].model = LW_CLEARANCE_NONE;        /* the same with the journal elsewhere */
    m.clearance[1] = (lw_clearance){ .model = LW_CLEARANCE_ZERO, .gap = 1e-4, .exponent = 1, .friction_speed = 1e-3 };
    same_motion(&m, 0.8, 40, 1e-7);
}

/* Stops that it bounces on, and one on which it comes to rest and which it leaves again */
TEST(stops_without_gap)
{
    OWN(lw_model) m = { 0 };
    read_planar(slider_crank, "text", &m);
    for (int i = 0; i < 3; i++) {
        m.stop[3] = (lw_joint_stop){ .has_least = true, .least = -0.12,
                                     .restitution = i == 0 ? 0.9 : i == 1 ? 0.3 : 0 };
        m.stop[0] = (lw_joint_stop){ .has_greatest = true, .greatest = 2.6, .restitution = 0.5 };
        CHECK(same_motion(&m, 1.2, 60, 2e-6) >= (i == 2 ? 1 : 4));
    }
}

/* A mass at 1 m/s between two buffers, by a force with kinks and by a compliant stop, beside a pendulum whose pin has clearance: harmonic arcs of
 * 10 and 5 rad/s with even motion between them.  Steps end at the kinks. */
TEST(kinks_of_forces)
{
    static const char *model = "{'linkwright': 1, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'a', 'mass': 1, 'centre': [0, 0], 'inertia': 1}, "
        "{'name': 'p', 'mass': 1, 'centre': [5, -1], 'inertia': 0.1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], "
        "'along': [1, 0]%s}, {'name': 'H', 'links': ['ground', 'p'], 'at': [5, 0], 'clearance': {'model': '%s', 'gap': 1e-3, 'stiffness': 1e4, "
        "'damping': 10}}], 'inputs': [{'joint': 'S', 'speed': 1}, {'joint': 'H', 'speed': 0}], 'forces': [{'link': 'a', 'at': [0, 0], 'fx': '%s'}]}";
    static const char *more[] = { "", ", 'stop': {'least': -0.4, 'greatest': 0.3, 'stiffness': 100}" }, *law[] = { "zero", "mlsd" };
    static const char *force[] = { "-100*max(0, q(S) - 0.3) - 25*min(0, q(S) + 0.4)", "75*min(0, q(S) + 0.4)" };
    const double soft = LW_PI/5, hard = LW_PI/10, t = fmod(10 - 0.3, soft + hard + 2*0.7);       /* since it first left the clearance */
    const double x = t < hard ? 0.3 + sin(10*t)/10 : t < hard + 0.7 ? 0.3 - (t - hard)
                   : t < hard + 0.7 + soft ? -0.4 - sin(5*(t - hard - 0.7))/5 : -0.4 + (t - hard - 0.7 - soft);
    for (int k = 0; k < 4; k++)
        for (double tolerance = 1e-6; tolerance > 1e-9; tolerance *= 1e-2) {
            char text[2048];
            lw_model m;
            track r;
            snprintf(text, sizeof text, model, more[k/2], law[k%2], force[k/2]);
            read_planar(text, "text", &m);
            lw_clearance_options o = lw_clearance_options_default();
            o.time = 10, o.settle = 0, o.every = 5, o.tolerance = tolerance;
            run(&m, o, &r);
            CHECK_INT(r.n, 3);
            CHECK_NEAR(r.s[2].input, x, 50*tolerance, 0);
            lw_model_free(&m);
        }
}

/* ---- loops ---------------------------------------------------------------------------------------- */

/* A Stephenson six-bar 1/10 m in size, journals at C and F */
static void six_bar(lw_model *m)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground',{'name': 'crank', 'mass': 2, 'centre': [0.02, 0.03], 'inertia': 0.02},{'name': "
        "'coupler', 'mass': 1, 'centre': [0.14, 0.17], 'inertia': 0.006},{'name': 'rocker', 'mass': 1.2, 'centre': [0.28, 0.1], 'inertia': 0.006},"
        "{'name': 'arm', 'mass': 0.8, 'centre': [0.03, 0.38], 'inertia': 0.01},{'name': 'stay', 'mass': 0.9, 'centre': [-0.17, 0.38], 'inertia': 0.01}], "
        "'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]},{'name': 'B', 'links': ['crank', 'coupler'], 'at': [0.05, 0.08]},{'name': "
        "'C', 'links': ['coupler', 'rocker'], 'at': [0.26, 0.21], 'clearance': {'model': 'impact', 'gap': 1e-4, 'stiffness': 1e7, 'damping': 2000, "
        "'depth': 1e-6}},{'name': 'D', 'links': ['ground', 'rocker'], 'at': [0.3, 0]},{'name': 'E', 'links': ['coupler', 'arm'], 'at': [0.11, 0.24]},"
        "{'name': 'F', 'links': ['arm', 'stay'], 'at': [-0.04, 0.52], 'clearance': {'model': 'impact', 'gap': 1e-4, 'stiffness': 1e7, 'damping': 2000, "
        "'depth': 1e-6}},{'name': 'G', 'links': ['ground', 'stay'], 'at': [-0.3, 0.25]}],'input': {'joint': 'A', 'speed': 6}, 'gravity': [0, -9.81]}";
    read_planar(text, "text", m);
}

static const lw_clearance_model laws[] = { LW_CLEARANCE_LINK, LW_CLEARANCE_MLSD, LW_CLEARANCE_IMPACT,
                                           LW_CLEARANCE_HUNT_CROSSLEY, LW_CLEARANCE_LANKARANI };

static void set_law(lw_model *m, lw_clearance_model law, double gap, double stiffness, double damping)
{
    for (int j = 0; j < m->linkage.n_joint; j++)
        if (m->clearance[j].model != LW_CLEARANCE_NONE) {
            m->clearance[j].model = law;
            m->clearance[j].gap = gap;
            m->clearance[j].depth = 0.01*gap;
            m->clearance[j].stiffness = stiffness;
            m->clearance[j].damping = damping;
            m->clearance[j].restitution = 0.7;
        }
}

/* Two loops, two journals: a run of every law ends; with small gaps and stiff contacts the crank moves as without
 * gaps */
TEST(laws_agree)
{
    OWN(lw_model) m = { 0 };
    track zero, law;
    lw_clearance_options o = lw_clearance_options_default();
    six_bar(&m);
    set_law(&m, LW_CLEARANCE_ZERO, 1e-6, 1e9, 0);
    o.time = 0.4, o.settle = 0.1, o.every = 0.02, o.start = LW_CLEARANCE_SEATED;
    run(&m, o, &zero);
    for (size_t i = 0; i < sizeof laws/sizeof *laws; i++) {
        set_law(&m, laws[i], 1e-6, 1e9, 1e4);
        lw_clearance_result r = run(&m, o, &law);
        CHECK_INT(r.n_joint, 2);
        CHECK_INT(law.n, zero.n);
        for (int k = 0; k < zero.n; k++) {
            CHECK_NEAR(law.s[k].input, zero.s[k].input, 2e-4, 0);
            CHECK_NEAR(law.s[k].energy, zero.s[k].energy, 1e-3*zero.s[0].energy, 0);
        }
        for (int j = 0; j < 2; j++)
            CHECK(r.joint[j].distance_most < 5e-6);
    }
}

/* Energy: kept by springs and links, never gained by damped contacts, friction and stops */
TEST(energy_of_loops)
{
    OWN(lw_model) m = { 0 };
    track k;
    lw_clearance_options o = lw_clearance_options_default();
    six_bar(&m);
    o.time = 0.3, o.settle = 0, o.every = 0.004, o.tolerance = 1e-11;
    for (int i = 0; i < 3; i++) {
        set_law(&m, laws[i], 1e-4, 1e7, 0);
        lw_clearance_result r = run(&m, o, &k);
        CHECK_NEAR(r.energy_last, r.energy_first, 1e-7, 0);
    }
    give_friction(&m, 0.1, 0.008, 0.01);
    m.stop[3] = (lw_joint_stop){ .has_greatest = true, .greatest = 0.2, .restitution = 0.6 };
    for (int i = 1; i < 5; i++) {
        set_law(&m, laws[i], 1e-4, 1e7, i == 1 ? 500 : 2000);
        lw_clearance_result r = run(&m, o, &k);
        CHECK(r.strikes >= 1);
        for (int s = 1; s < k.n; s++) {
            CHECK(k.s[s].energy < k.s[s - 1].energy + 1e-6);
            CHECK(laws[i] == LW_CLEARANCE_MLSD || (k.s[s].point[0].touching ? 1 : k.s[s].point[0].force == 0));
        }
        CHECK(r.energy_last < r.energy_first - 0.01);
    }
}

/* A disc falls in its bush while it turns: Coulomb's impulse.  It strikes head on, so that what its
 * spin loses is radius times friction times the normal impulse. */
TEST(impulse_with_friction)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'disc', 'mass': 2, 'centre': [0, 0], 'inertia': 0.02}], 'joints': "
        "[{'name': 'A', 'links': ['ground', 'disc'], 'at': [0, 0], 'friction': {'coefficient': 0.05, 'radius': 0.1, 'speed': 1e-4}, 'clearance': "
        "{'model': 'impact', 'gap': 0.01, 'stiffness': 1e8}}],'input': {'joint': 'A', 'speed': 20}, 'gravity': [0, -9.81]}";
    OWN(lw_model) m = { 0 };
    track k;
    read_planar(text, "text", &m);
    lw_clearance_options o = lw_clearance_options_default();
    double fall = sqrt(2*0.01/9.81), v = 9.81*fall, mu = 0.05, radius = 0.1;
    o.time = 1.5*fall, o.settle = 0, o.every = o.time, o.tolerance = 1e-12;
    lw_clearance_result r = run(&m, o, &k);
    CHECK_INT(k.n, 2);
    CHECK_INT(r.joint[0].losses, 1);
    double w = sqrt(1e8/2), impulse = 2*(2*v + 9.81*2*(LW_PI - atan(v*w/9.81))/w);
    CHECK_NEAR(k.s[1].input_rate, 20 - mu*radius*impulse/0.02, 1e-5, 0);    /* the wall is curved */
}

/* A wheel of 0.5 kg m^2 at rest, on a pin that is judged only: torques of the time within milliseconds, and jumps, give it their impulse
 * over its inertia.  At its stop it is held until the torque jumps. */
TEST(torques_of_the_time)
{
    const double root_pi = sqrt(LW_PI);
    const struct { const char *torque, *stop; double rate; } row[] = {
        { "100*exp(-((t - 0.4973)/1e-3)^2)", "", 0.2*root_pi }, { "2e4*max(0, sign(t - 0.5)*sign(0.5001 - t))", "", 4 },
        { "max(0, min(1e6*(t - 0.5), 1e6*(0.501 - t)))", "", 0.5 }, { "sign(sin(5*t))", "", 2*(2*LW_PI/5 - 1) },
        { "-1 + 3*max(0, sign(t - 0.5))", ", 'stop': {'least': 0}", 2 } };
    for (int i = 0; i < 10; i++) {
        char text[1000];
        OWN(lw_model) m = { 0 };
        track k;
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'disc', 'mass': 2, 'centre': [0, 0], 'inertia': 0.5}], 'joints': "
                 "[{'name': 'A', 'links': ['ground', 'disc'], 'at': [0, 0], 'clearance': {'model': 'zero', 'gap': 0.01}%s}], 'input': {'joint': 'A', "
                 "'speed': 0}, 'forces': [{'link': 'disc', 'at': [0, 0], 'torque': '%s'}]}", row[i/2].stop, row[i/2].torque);
        read_planar(text, "text", &m);
        lw_clearance_options o = lw_clearance_options_default();
        o.time = 1, o.settle = 0.3, o.every = i%2 ? 1 : 0.05, o.tolerance = 1e-9;
        run(&m, o, &k);
        CHECK_NEAR(k.s[k.n - 1].input_rate, row[i/2].rate, 1e-7, 0);
    }
}

/* A driven crank passes its start at known times. */
TEST(passes)
{
    OWN(lw_model) m = { 0 };
    track k = { 0 };
    lw_clearance_scene *scene;
    lw_clearance_result r;
    read_planar(slider_crank, "text", &m);
    m.clearance[2].model = LW_CLEARANCE_IMPACT;
    CHECK_OK(lw_model_drive(&m, 0, "pi/2 - 40*t", &check_error));
    lw_clearance_options o = lw_clearance_options_default();
    o.time = 1, o.settle = 0, o.strobe = keep, o.context = &k;
    CHECK_OK(lw_clearance_make(&m, &scene, &check_error));
    CHECK_OK(lw_clearance_run(scene, &o, &r, &check_error));
    CHECK_INT(k.n, 6);
    for (int i = 0; i < k.n; i++)
        CHECK_NEAR(k.s[i].t, 2*LW_PI*(i + 1)/40, 1e-9, 0);
    lw_clearance_free(scene);
}

/* Random linkages with journals, friction and stops, whatever closes their loops: energy does not grow */
TEST(random_scenes)
{
    lw_rng rng = check_rng(29);
    int n_run = 0, n_strike = 0;
    for (int trial = 0; trial < 40; trial++) {
        lw_linkage k;
        OWN(lw_model) m = { 0 };
        track t = { 0 };
        random_grown(&rng, 1 + trial%3, &k);
        int pin = random_pin(&rng, &k);
        give_masses(&rng, &k, pin, &m);
        m.clearance[pin].model = laws[trial%5];
        m.clearance[pin].damping = 20, m.clearance[pin].restitution = 0.8;
        for (int j = 0; j < k.n_joint; j++) {
            bool smooth = j == pin && laws[trial%5] == LW_CLEARANCE_LINK;
            bool plain = k.joint[j].kind == LW_JOINT_REVOLUTE || k.joint[j].kind == LW_JOINT_SLIDER;
            if (!smooth && plain && (trial + j)%3 == 0)
                m.friction[j] = (lw_friction){ 0.05, 0.05, 0.05 };
            if (plain && (trial + j)%4 == 1)
                m.stop[j] = (lw_joint_stop){ .has_least = true, .has_greatest = true, .least = -0.2, .greatest = 0.3,
                                             .restitution = 0.3*(trial%4) };
        }
        lw_clearance_scene *scene;
        lw_clearance_result r;
        lw_error e = { 0 };
        lw_clearance_options o = lw_clearance_options_default();
        o.time = 0.4, o.settle = 0, o.every = 0.02, o.tolerance = 1e-10, o.max_step = 200000;
        o.sink = keep, o.context = &t;
        CHECK_INT(lw_clearance_make(&m, &scene, &e), LW_OK);
        lw_status s = lw_clearance_run(scene, &o, &r, &e);
        if (s == LW_OK) {                    /* random linkages also run into singular postures */
            n_run++;
            n_strike += r.strikes > 0;
        } else
            CHECK(e.text[0]);
        for (int i = 1; i < t.n; i++)
            CHECK(t.s[i].energy < t.s[i - 1].energy + 1e-6*(10 + fabs(t.s[0].energy)));
        lw_clearance_free(scene);
    }
    CHECK(n_run >= 36);
    CHECK(n_strike >= 20);
}

/* tests/test_clearance.c - motion with clearance: paper C's threshold, exact bounces, energy, other formulations, bad
 * input. */
#include "mbs/clearance/clearance.h"
#include "tests/clearance_models.h"
#include "tests/planar_models.h"

static const double rpm = 2.0*LW_PI/60.0;

static lw_clearance_result run(const lw_model *m, const lw_clearance_options *o, lw_status want)
{
    lw_clearance_scene *scene = NULL;
    lw_clearance_result r = { 0 };
    lw_error e = { 0 };
    lw_status s = lw_clearance_make(m, &scene, &e);
    if (s == LW_OK)
        s = lw_clearance_run(scene, o, &r, &e);
    if (s != want)
        fprintf(stderr, "%s\n", e.text);
    CHECK_INT(s, want);
    lw_clearance_free(scene);
    return r;
}

/* ---- the paper ----------------------------------------------------------------------------------- */

/* Makkonen 1999, paper C, section 4: contact is kept at 92 r/min and lost at 94 r/min; whatever the tolerance, the
 * frame and the units. */
TEST(threshold_of_paper_c)
{
    static const struct { const char *unit; double metre, turn; bool mirrored; double tolerance; } row[] = {
        { "m", 1, 0, false, 1e-8 }, { "m", 1, 0, false, 1e-9 }, { "m", 1, 0, false, 1e-10 }, { "m", 1, 0, false,
        1e-11 },
        { "m", 1, 0, false, 1e-12 }, { "m", 1, 2.1, false, 1e-9 }, { "m", 1, 0, true, 1e-9 }, { "mm", 1e-3, 0,
        false, 1e-9 },
        { "in", 0.0254, -0.7, true, 1e-9 } };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        OWN(lw_model) m = { 0 };
        CHECK_OK(paper_c(row[i].unit, row[i].metre, row[i].turn, row[i].mirrored, &m, &check_error));
        for (int lost = 0; lost < 2; lost++) {
            lw_clearance_options o = lw_clearance_options_default();
            o.tolerance = row[i].tolerance;
            o.speed = (lost ? 94.0 : 92.0)*rpm*(row[i].mirrored ? -1 : 1);
            lw_clearance_result r = run(&m, &o, LW_OK);
            CHECK_INT(r.joint[0].lost, lost);
            CHECK(r.joint[0].force_most > 250 && r.joint[0].force_most < 350);
            CHECK(r.joint[0].distance_most < 1.05e-4);
            CHECK(lost ? r.joint[0].first > 0.6 && r.joint[0].first < 1.25 : isnan(r.joint[0].first));
        }
    }
}

/* Further limits that the models have here (docs/clearance.md): kept below, lost above */
TEST(limits_of_the_models)
{
    static const struct { lw_clearance_model model; double stiffness, below, above; } row[] = {
        { LW_CLEARANCE_IMPACT, 1e7, 94, 97 }, { LW_CLEARANCE_IMPACT, 1e6, 99, 102 }, { LW_CLEARANCE_MLSD, 1e8, 93, 97 },
        { LW_CLEARANCE_MLSD, 1e7, 95, 98 }, { LW_CLEARANCE_LINK, 1e8, 90, 100 } };
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    for (size_t i = 0; i < sizeof row/sizeof *row; i++)
        for (int lost = 0; lost < 2; lost++) {
            lw_clearance_options o = lw_clearance_options_default();
            m.clearance[2].model = row[i].model;
            m.clearance[2].stiffness = row[i].stiffness;
            o.speed = (lost ? row[i].above : row[i].below)*rpm;
            CHECK_INT(run(&m, &o, LW_OK).joint[0].lost, lost);
        }
}

/* ---- exact --------------------------------------------------------------------------------------- */

/* A link that hangs by one pin with clearance at its centre of mass: it falls in the gap, R, hits, and bounces.
 * Without damping contact lasts 2 (pi - atan(v w/g))/w, w^2 = K/m, v^2 = 2 g R. */
static void bounces(lw_model *m, double stiffness)
{
    static const char text[] = "{'linkwright': 1, 'links': ['ground', {'name': 'disc', 'mass': 2, 'centre': [1, 2], 'inertia': 0.3}], 'joints': [{'name': 'A', "
        "'links': ['ground', 'disc'], 'at': [1, 2], 'clearance': {'model': 'impact', 'gap': 0.01, 'stiffness': 1e5}}], 'gravity': [0, -9.81]}";
    read_planar(text, "disc", m);
    m->clearance[0].stiffness = stiffness;
}

TEST(exact_bounces)
{
    for (double k = 1e4; k < 1e9; k *= 10.0) {
        OWN(lw_model) m = { 0 };
        bounces(&m, k);
        lw_clearance_options o = lw_clearance_options_default();
        double g = 9.81, gap = 0.01, fall = sqrt(2*gap/g), w = sqrt(k/2), v = g*fall;
        double contact = 2*(LW_PI - atan(v*w/g))/w, period = 2*fall + contact;
        o.settle = fall + 0.5*contact;
        o.time = o.settle + 2.5*period;
        o.tolerance = 1e-12;
        lw_clearance_result r = run(&m, &o, LW_OK);
        CHECK(r.joint[0].lost);
        CHECK_NEAR(r.joint[0].first, fall + contact, 2e-10, 0);
        CHECK_INT(r.joint[0].losses, 3);
        CHECK_NEAR(r.joint[0].apart*(o.time - o.settle), 5*fall, 2e-9, 0);
        CHECK_NEAR(r.energy_last, r.energy_first, 1e-9, 0);
    }
}

/* ---- energy and formulations --------------------------------------------------------------------- */

/* Linkages with loops of every dyad, one pin opened: energy is kept without damping */
TEST(energy_is_kept)
{
    lw_rng rng = check_rng(11);
    int n_run = 0, n_touch = 0, n_two = 0;
    for (int trial = 0; trial < 40; trial++) {
        lw_linkage k;
        OWN(lw_model) m = { 0 };
        random_grown(&rng, 1 + trial%3, &k);
        int pin = random_pin(&rng, &k);
        give_masses(&rng, &k, pin, &m);
        m.clearance[pin].model = trial%4 == 0 ? LW_CLEARANCE_LINK : trial%4 == 1 ? LW_CLEARANCE_MLSD
                               : LW_CLEARANCE_IMPACT;
        m.clearance[pin].exponent = trial%4 == 3 ? 1.5 : 1.0;
        int other = random_pin(&rng, &k);                    /* often a second one, of another law */
        if (other != pin && trial%2)
            m.clearance[other] = (lw_clearance){ .model = LW_CLEARANCE_IMPACT, .gap = 0.02, .stiffness = 3e4,
                                                 .exponent = 1, .restitution = 1, .friction_speed = 1e-3 };
        lw_clearance_scene *scene;
        lw_clearance_result r;
        lw_clearance_options o = lw_clearance_options_default();
        o.time = 0.3, o.settle = 0.0, o.tolerance = 1e-11;
        CHECK_INT(lw_clearance_make(&m, &scene, NULL), LW_OK);
        lw_status s = lw_clearance_run(scene, &o, &r, NULL);
        double size = fabs(r.energy_first) + 10.0;
        if (s == LW_OK) {                    /* random linkages also run into singular postures */
            n_run++;
            n_touch += r.joint[0].distance_most > 0.01;
            n_two += r.n_joint == 2;
            CHECK_NEAR(r.energy_last, r.energy_first, 1e-7*size, 0);
            if (m.clearance[pin].model == LW_CLEARANCE_LINK)
                CHECK_NEAR(r.joint[r.joint[0].joint != pin].distance_most, 0.01, 1e-12, 0);
        }
        lw_clearance_free(scene);
    }
    CHECK(n_run >= 30);
    CHECK(n_touch >= 5);
    CHECK(n_two >= 8);
}

/* Damping takes energy, whatever the start; also at speeds where the pin grazes its bush */
TEST(damping_takes_energy)
{
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    for (int i = 0; i < 24; i++) {
        lw_clearance_options o = lw_clearance_options_default();
        o.time = 0.3, o.settle = 0.0, o.tolerance = 1e-8;
        o.start = i%2 ? LW_CLEARANCE_CRANK : LW_CLEARANCE_CLOSED;
        o.speed = (80 + 32*(i/2))*rpm*(i%3 ? 1 : -1);
        m.clearance[2].model = i%4 == 3 ? LW_CLEARANCE_HUNT_CROSSLEY : LW_CLEARANCE_IMPACT;
        m.clearance[2].restitution = 0.8;
        lw_clearance_result r = run(&m, &o, LW_OK);
        CHECK(r.energy_last < r.energy_first);
        CHECK(r.joint[0].distance_most < 2e-3);
    }
}

/* Whatever the tolerance, a run ends and the pin stays near its bush: errors greater than the gap would throw it
 * out, and grazing leaves contact unnoticed for some steps. */
TEST(every_tolerance)
{
    static const double speed[] = { 94, 250, -333 };
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    for (int i = 0; i < 27; i++) {
        lw_clearance_options o = lw_clearance_options_default();
        o.time = 1.25, o.tolerance = pow(10.0, -4.0 - i/3), o.speed = speed[i%3]*rpm;
        m.clearance[2].model = i%2 ? LW_CLEARANCE_HUNT_CROSSLEY : LW_CLEARANCE_IMPACT;
        lw_clearance_result r = run(&m, &o, LW_OK);
        CHECK(r.energy_last < r.energy_first*(1 + 1e-3));
        CHECK(r.energy_last > r.energy_first*(1 - 1e-2));
        CHECK(r.joint[0].distance_most < 1.5e-4);
        CHECK(r.joint[0].force_most < 6000);
    }
}

static void record(const lw_model *m, lw_clearance_options o, track *t)
{
    t->n = 0;
    o.sink = keep, o.context = t;
    run(m, &o, LW_OK);
}

/* The massless link is the limit of the spring-damper link for rising stiffness */
TEST(link_is_a_stiff_spring)
{
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    lw_clearance_options o = lw_clearance_options_default();
    o.time = 0.2, o.settle = 0.1, o.every = 0.01, o.tolerance = 1e-11, o.speed = 85*rpm;
    track link, spring;
    m.clearance[2].model = LW_CLEARANCE_LINK;
    record(&m, o, &link);
    double before = INFINITY;
    m.clearance[2].model = LW_CLEARANCE_MLSD;
    for (double k = 1e8; k < 2e10; k *= 10) {
        double worst = 0, force = 0;
        m.clearance[2].stiffness = k;
        m.clearance[2].damping = 0.1*sqrt(k);
        record(&m, o, &spring);
        CHECK_INT(spring.n, link.n);
        for (int i = 0; i < link.n; i++) {
            worst = fmax(worst, lw_v2_norm(lw_v2_sub(link.s[i].point[0].in_bush, spring.s[i].point[0].in_bush)));
            force = fmax(force, fabs(link.s[i].point[0].force - spring.s[i].point[0].force));
        }
        CHECK(worst < 0.2*before);
        before = worst;
        if (k > 5e9) {
            CHECK(worst < 2e-7);
            CHECK(force < 2.0);
        }
    }
    CHECK_INT(link.n, 21);
}

/* The pin that is pressed against its bush all the time has the reaction of the joint without clearance */
TEST(reaction_without_clearance)
{
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    lw_clearance_options o = lw_clearance_options_default();
    o.time = 0.5, o.settle = 0.05, o.every = 0.01, o.speed = 60*rpm, o.start = LW_CLEARANCE_SEATED;
    track zero, impact;
    m.clearance[2].model = LW_CLEARANCE_ZERO;
    record(&m, o, &zero);
    m.clearance[2].model = LW_CLEARANCE_IMPACT;
    m.clearance[2].gap = 1e-7, m.clearance[2].depth = 1e-9, m.clearance[2].damping = 3e4;
    record(&m, o, &impact);
    CHECK_INT(zero.n, impact.n);
    for (int i = 8; i < zero.n; i++) {
        CHECK_NEAR(impact.s[i].point[0].force, zero.s[i].point[0].force, 0.2, 1e-3);
        CHECK_NEAR(impact.s[i].input, zero.s[i].input, 1e-5, 0);
        CHECK_NEAR(zero.s[i].energy, zero.s[0].energy, 1e-7, 0);
        CHECK(zero.s[i].point[0].touching && lw_v2_norm(zero.s[i].point[0].pin) < 1e-14);
    }
}

/* The input of a driven crank follows its motion, the other links as before */
TEST(driven_crank)
{
    OWN(lw_model) m = { 0 };
    char text[6000];
    FILE *f = fopen("examples/clearance-four-bar.json", "rb");
    size_t n = f ? fread(text, 1, 3000, f) : 0;
    if (f)
        fclose(f);
    text[n] = 0;
    char *speed = strstr(text, "\"speed\":");
    CHECK(speed != NULL);
    if (!speed)
        return;
    static const char motion[] = "'motion': 'pi/2 + 2*pi + 9*t + 0.2*sin(10*t)'";
    const char *rest = strchr(speed, '}');
    memmove(speed + sizeof motion - 1, rest, strlen(rest) + 1);
    memcpy(speed, motion, sizeof motion - 1);
    read_planar(text, "driven", &m);
    lw_clearance_options o = lw_clearance_options_default();
    o.time = 0.4, o.settle = 0.1, o.every = 0.01;
    track t;
    record(&m, o, &t);
    CHECK_INT(t.n, 41);
    for (int i = 0; i < t.n; i++) {
        double at = t.s[i].t;
        CHECK_NEAR(t.s[i].input, LW_PI/2 + 9*at + 0.2*sin(10*at), 1e-10, 0);
        CHECK_NEAR(t.s[i].input_rate, 9 + 2*cos(10*at), 1e-6, 0);
    }
}

/* Restitution: a disc dropped on its bush returns with about s v (the laws aim at it; that of Lankarani & Nikravesh
 * only for s near 1) */
TEST(restitution)
{
    for (int law = 0; law < 2; law++) {
        OWN(lw_model) m = { 0 };
        bounces(&m, 1e8);
        m.clearance[0].model = law ? LW_CLEARANCE_LANKARANI : LW_CLEARANCE_HUNT_CROSSLEY;
        m.clearance[0].exponent = 1.5;
        m.clearance[0].restitution = 0.9;
        lw_clearance_options o = lw_clearance_options_default();
        double fall = sqrt(2*0.01/9.81);
        o.settle = 0.0, o.time = fall*2, o.every = 0.0005;
        lw_clearance_result before = run(&m, &o, LW_OK);
        double e0 = before.energy_first, e1 = before.energy_last, drop = 2*9.81*0.01;
        double back = sqrt((e1 - e0 + drop)/drop);       /* speed after, over speed before */
        CHECK_NEAR(back, 0.9, 0.02, 0);
    }
}

/* ---- limits and bad input ------------------------------------------------------------------------ */

static void refused(lw_model *m, lw_status want, const char *text)
{
    lw_clearance_scene *scene;
    lw_error e = { 0 };
    CHECK_INT(lw_clearance_make(m, &scene, &e), want);
    CHECK(scene == NULL);
    CHECK_HAS(e.text, text);
}

TEST(bad_input)
{
    OWN(lw_model) m = { 0 };
    CHECK_OK(paper_c("m", 1, 0, false, &m, &check_error));
    lw_clearance good = m.clearance[2];
    m.clearance[2].model = LW_CLEARANCE_NONE;
    refused(&m, LW_E_ARG, "no joint has clearance");
    m.clearance[2] = good;
    m.linkage.joint[2].kind = LW_JOINT_SLIDER;
    refused(&m, LW_E_ARG, "\"B\" is no pin");
    m.linkage.joint[2].kind = LW_JOINT_REVOLUTE;
    m.clearance[2].gap = 0;
    refused(&m, LW_E_ARG, "gap of joint \"B\"");
    m.clearance[2].gap = 1e-4, m.clearance[2].stiffness = 0;
    refused(&m, LW_E_ARG, "stiffness above 0");
    m.clearance[2] = good;
    m.body[2].given = false;
    refused(&m, LW_E_ARG, "\"coupler\" has no mass");
    m.body[2].given = true;
    m.clearance[2].model = LW_CLEARANCE_LINK;
    m.friction[2].coefficient = 0.1;
    refused(&m, LW_E_KIND, "a massless link has no surface");
    m.clearance[2] = good, m.friction[2].coefficient = 0;
    lw_clearance_options o = lw_clearance_options_default();
    o.max_step = 100;
    lw_clearance_result r = run(&m, &o, LW_STOPPED);
    CHECK(r.t > 0.0 && r.t < 1.25 && r.steps + r.refused == 100);
    o = lw_clearance_options_default();
    volatile sig_atomic_t now = 1;
    o.stop = &now;
    CHECK(run(&m, &o, LW_STOPPED).t == 0.0);
    o = lw_clearance_options_default();
    o.until = 1e-3;                                              /* long ago */
    CHECK(run(&m, &o, LW_STOPPED).t < 1.25);
    o = lw_clearance_options_default();
    o.tolerance = 0;
    run(&m, &o, LW_E_ARG);
    m.body[3].mass = m.body[3].inertia = 0;                      /* the rocker: held by its bush alone */
    lw_clearance_scene *scene;
    o = lw_clearance_options_default();
    CHECK_INT(lw_clearance_make(&m, &scene, NULL), LW_OK);
    CHECK_FAILS(lw_clearance_run(scene, &o, &r, &check_error), LW_E_NUMERIC, "\"rocker\"");
    lw_clearance_free(scene);
}

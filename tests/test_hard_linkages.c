/* tests/test_hard_linkages.c - curves of postures of walkers, exact straight-line linkages, chains of parallelograms
 * and every eight-link chain. */
#include "base/file.h"
#include "enumerate/chains.h"
#include "grammar/linkage/linkage.h"
#include "mbs/batch/posture.h"
#include "mbs/constraints/newton.h"
#include "mbs/kinematics/fourbar.h"
#include "tests/kept_system.h"
#include "tests/mbs_random.h"
#include "tests/motion_curve.h"
#include "tests/planar_models.h"
#include "tests/straight_lines.h"

/* --- exact straight lines --- */

/* Up to a millionth of a degree from the limit; input is t as drawn. */
static void peaucellier_by_plan(const lw_linkage *l, double t)
{
    const double limit = 96.37937020844280386828*LW_PI/180, near = 1e-6*LW_PI/180, c = 1.5;
    lw_plan plan;
    static lw_posture posture;
    double dim[LW_DIM_MAX], mode[LW_DYAD_MAX], input;
    CHECK_INT(lw_plan_make(l, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, l, dim, mode, &input, NULL), LW_OK);
    /* closed form: Q from two pins 2 h apart whose places hold some ulps (9e-16) of 5 */
    for (int i = 0; i <= 100; i++)
        for (int way = -1; way <= 1; way += 2) {
            double angle = limit - near*(1 + i), d = 2*c*cos(angle/2), mean = 0.5*(d + 16/d), h = sqrt(25 - mean*mean);
            CHECK_INT(lw_posture_solve(&plan, dim, mode, input - t + way*(limit - 0.05)*i/100, 0, &posture), LW_OK);
            CHECK_NEAR(posture.tracer[0][0].x, 16/3.0, 5e-14, 0);
            CHECK_INT(lw_posture_solve(&plan, dim, mode, input - t + way*angle, 0, &posture), LW_OK);
            CHECK_NEAR(posture.tracer[0][0].x, 16/3.0, 1.2e-14/h, 0);
        }
    /* that is the lengths read off coordinates, which miss 3 and 5 by an ulp: where they are right, 1e-12 of the arms */
    for (int d = 0; d < plan.n_dim; d++)
        dim[d] = plan.dim[d].kind == LW_DIM_LENGTH ? nearbyint(2*dim[d])/2 : dim[d];
    for (int i = 0; i <= 100; i++)
        for (int way = -1; way <= 1; way += 2) {
            CHECK_INT(lw_posture_solve(&plan, dim, mode, input - t + way*(limit - near*(1 + i)), 0, &posture), LW_OK);
            CHECK_NEAR(posture.tracer[0][0].x, 16/3.0, 5e-12, 0);
        }
}

/* Q on x = 16/3, input limits where the rhombus is flat and its halves may
 * part: a limit and a branch point in one. */
TEST(peaucellier_all_around)
{
    const double limit = 96.37937020844280386828*LW_PI/180, t = 0.3;
    lw_linkage l;
    peaucellier(&l, 1.5, t);
    curve *v = follow(&l, 0);
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
    CHECK_INT(count(v, LW_EVENT_LIMIT), 2);
    CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
    for (int i = 0; i < n; i++)
        if (e[i].kind != LW_EVENT_TURNING)
            CHECK_NEAR(fabs(e[i].input), limit, 1e-10, 0);
    for (int i = 0; i <= 2000; i++) {
        double station = lw_motion_curve_segments(v->b)*i/2000.0, input = fabs(input_at(v, station));
        double tolerance = input < limit - 0.05 ? 5e-14 : 5e-12;        /* 1e-14 and 1e-12 of the arms */
        CHECK_NEAR(tracer_at(v, 0, station).x, 16/3.0, tolerance, 0);
    }
    for (int i = -20; i <= 20; i++)
        CHECK_NEAR(tracer_at(v, 0, e[1].station + i*1e-4).x, 16/3.0, 5e-12, 0);
    curve_free(v);
    peaucellier_by_plan(&l, t);
}

/* The end of the coupler on x = 0, also where the slider passes the crank's pin. */
TEST(scott_russell_all_around)
{
    lw_linkage l;
    scott_russell(&l, 0.7);
    OWNED(curve) *v = follow(&l, 0);
    CHECK_INT(lw_motion_curve_turns(v->b, -1), 1);
    CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
    for (int i = 0; i <= 3600; i++) {
        double input = 0.7 + 2*LW_PI*i/3600;
        double station = lw_motion_curve_find(v->b, 0, lw_motion_curve_segments(v->b), input), away = fabs(cos(input));
        lw_vec2 p = tracer_at(v, 0, station);
        CHECK_NEAR(p.x, 0, away > 0.1 ? 2e-14 : 2e-12, 0);
        CHECK_NEAR(p.y, 2*sin(input), 4e-14, 0);
    }
    for (int i = -10; i <= 10; i++) {
        double station = lw_motion_curve_find(v->b, 0, lw_motion_curve_segments(v->b), 0.5*LW_PI + i*1e-7*LW_PI/180);
        CHECK_NEAR(tracer_at(v, 0, station).x, 0, 2e-12, 0);
    }
}

/* --- chains of parallelograms --- */

/* N parallelograms in a row lose N ranks at once twice a turn; the curve goes straight on, the couplers never turn. */
TEST(parallelograms_in_a_row)
{
    for (int n = 2; n <= 4; n++) {
        lw_linkage l;
        double q[LW_SYSTEM_Q_MAX];
        int found;
        blank_linkage(&l, 2 + 2*n);
        for (int i = 0; i <= n; i++)
            add_pin(&l, 0, 1 + i, lw_v2(i, 0));
        for (int i = 0; i < n; i++) {
            add_pin(&l, 1 + i, n + 2 + i, lw_v2(i + cos(0.5), sin(0.5)));
            add_pin(&l, n + 2 + i, 2 + i, lw_v2(i + 1 + cos(0.5), sin(0.5)));
        }
        add_input(&l, 0, 0.5);
        OWNED(curve) *v = follow(&l, 0);
        const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &found);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        CHECK_INT(lw_motion_curve_turns(v->b, -1), 1);
        CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
        for (int i = 0; i < found; i++)
            CHECK_NEAR(sin(e[i].input), 0, 1e-10, 0);
        for (int i = 0; i <= 500; i++) {
            lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b)*i/500.0, q, NULL);
            for (int body = n + 1; body < 2*n + 1; body++)
                CHECK_NEAR(q[3*body + 2], 0, 1e-11, 0);
            CHECK(residual(v, q) <= 1e-12);
        }
    }
}

/* --- walkers --- */

/* Theo Jansen's lengths; foot to 1e-13 of the leg. */
TEST(jansen_by_reference)
{
    lw_linkage l;
    char *text = NULL;
    size_t size;
    int n = 0;
    jansen_linkage(&l);
    curve *v = follow(&l, 0);
    CHECK_INT(lw_motion_curve_turns(v->b, -1), 1);
    CHECK_INT(lw_file_read("tests/data/linkages/jansen.csv", &text, &size, NULL), LW_OK);
    for (const char *line = text; line && *line; line += strcspn(line, "\n"), line += *line == '\n') {
        double d[11];
        char *at = (char *)line;
        if (*line < '0' || *line > '9')
            continue;
        for (int c = 0; c < 11; c++, at += *at == ',')
            d[c] = strtod(at, &at);
        double station = lw_motion_curve_find(v->b, 0, lw_motion_curve_segments(v->b), d[0]*LW_PI/180);
        CHECK_NEAR(distance(tracer_at(v, 0, station), lw_v2(d[9], d[10])), 0, 1e-11, 0);
        n++;
    }
    CHECK_INT(n, 72);
    free(text);
    curve_free(v);
}

/* A linkage of examples/ by its plan and along its curve. */
static void by_plan_and_curve(const char *file)
{
    lw_linkage l;
    lw_plan plan;
    static lw_posture posture;
    double dim[LW_DIM_MAX], mode[LW_DYAD_MAX], input;
    load_linkage(file, &l);
    CHECK_INT(lw_plan_make(&l, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &l, dim, mode, &input, NULL), LW_OK);
    OWNED(curve) *v = follow(&l, 0);
    CHECK_INT(abs(lw_motion_curve_turns(v->b, -1)), 1);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
    for (int i = 0; i <= 360; i++) {
        double u = l.input[0].value + 2*LW_PI*i/360;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + 2*LW_PI*i/360, 0, &posture), LW_OK);
        lw_vec2 p = tracer_at(v, 0, lw_motion_curve_find(v->b, 0, lw_motion_curve_segments(v->b), u));
        CHECK_NEAR(distance(p, posture.tracer[0][0]), 0, 1e-13*v->s.unit*20, 0);
    }
}

/* Klann: US patent 6260862; Chebyshev's walker: his lambda linkage, 1, 2, 2.5, 2.5, tracer 5. */
TEST(walkers_by_plan_and_curve)
{
    by_plan_and_curve("examples/klann.json");
    by_plan_and_curve("examples/hoeken.json");
    by_plan_and_curve("examples/jansen.json");
}

/* --- every eight-link chain --- */

static void draw_linkage(lw_rng *r, const lw_chain *c, int ground, lw_linkage *l)
{
    blank_linkage(l, c->n_link);
    l->ground = ground;
    for (int i = 0; i < c->n_link; i++)
        for (int k = i + 1; k < c->n_link; k++)
            if (c->one[i] >> k & 1)
                add_pin(l, i, k, lw_v2(lw_rng_range(r, -1, 1), lw_rng_range(r, -1, 1)));
    for (int i = 0; i < c->n_link; i++)
        add_tracer(l, i, lw_v2(lw_rng_range(r, -1, 1), lw_rng_range(r, -1, 1)));
}

static struct { lw_rng rng; int chains, curves, inputs, dead; } all;

/* Any joint may drive: rates exist but at a dead point, and their series satisfies the rows. */
static void drive_every_joint(const lw_linkage *l, const double *q)
{
    for (int j = 0; j < l->n_joint; j++) {
        lw_linkage k = *l;
        double series[3*LW_SYSTEM_Q_MAX], phi[3*LW_SYSTEM_ROW_MAX], speed[3] = { 0, 1, 0 }, counted[3];
        KEPT_SYSTEM s = { 0 };
        lw_motion_curve *b;
        k.n_input = 0;
        add_input(&k, j, 0);
        CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
        CHECK_INT(lw_motion_curve_create(&s, q, &(lw_motion_curve_options){ .most_segments = 1 }, &b, NULL), LW_OK);
        if (!b)
            continue;
        memcpy(series, q, (size_t)s.n_q*sizeof *q);
        all.inputs++;
        if (lw_motion_curve_rates(b, 2, speed, series)) {
            double most = 1;
            for (int i = 0; i < 3*s.n_q; i++)
                most = fmax(most, fabs(series[i]));
            lw_system_series(&s, 2, series, phi);
            for (int i = 0; i < 3*s.n_row; i++)
                CHECK_NEAR(phi[i], 0, 1e-11*most*most, 0);
            lw_system_measure_series(&s, j, 2, series, counted);
            CHECK_NEAR(counted[1], 1, 1e-9*most, 0);
        } else
            all.dead++;
        lw_motion_curve_free(b);
    }
}

static lw_status follow_chain(void *context, const lw_chain_item *item)
{
    (void)context;
    all.chains++;
    for (int ground = 0; ground < item->chain->n_link; ground++) {
        lw_linkage l;
        double q[LW_SYSTEM_Q_MAX];
        draw_linkage(&all.rng, item->chain, ground, &l);
        add_input(&l, (int)(lw_rng_bits(&all.rng)%(uint64_t)l.n_joint), 0);
        OWNED(curve) *v = follow(&l, 60);
        if (v->b) {
            all.curves++;
            CHECK(lw_motion_curve_worst(v->b) <= 1e-12*v->s.unit);
            for (int i = 0; i < 20; i++) {
                lw_motion_curve_posture(v->b, lw_rng_range(&all.rng, 0, lw_motion_curve_segments(v->b)), q, NULL);
                CHECK(residual(v, q) <= 1e-12);
            }
            drive_every_joint(&l, q);
        }
    }
    return LW_OK;
}

/* Sixteen chains, each link as ground, each joint as input, at random dimensions. */
TEST(every_eight_link_chain)
{
    lw_chains *chains;
    lw_rng_seed(&all.rng, check_seed(), 3);
    CHECK_INT(lw_chains_create(8, 1, 1, &chains, NULL), LW_OK);
    lw_chain_walk how = lw_chain_walk_default();
    CHECK_INT(lw_chains_each(chains, &how, follow_chain, NULL), LW_OK);
    CHECK_INT(all.chains, 16);
    CHECK_INT(all.curves, 128);
    CHECK_INT(all.inputs, 1280);
    CHECK(all.dead < 10);
    lw_chains_free(chains);
}

/* Links and joints told in another order: the same curve to 1e-12 at the same arcs. */
static lw_status relabel_chain(void *context, const lw_chain_item *item)
{
    (void)context;
    lw_linkage l, other;
    int to[LW_JOINT_MAX];
    draw_linkage(&all.rng, item->chain, 0, &l);
    add_input(&l, 0, 0);
    shuffle_linkage(&all.rng, &l, &other);
    lw_linkage mixed = other;
    for (int i = 0; i < l.n_joint; i++) {
        int j = (int)(lw_rng_bits(&all.rng)%(uint64_t)(i + 1));
        to[i] = to[j];
        to[j] = i;
    }
    for (int i = 0; i < l.n_joint; i++)
        mixed.joint[to[i]] = other.joint[i];
    mixed.input[0].joint = to[0];
    curve *v = follow(&l, 150), *w = follow(&mixed, 150);
    if (v->b && w->b) {
        CHECK_INT(lw_motion_curve_ended(v->b), lw_motion_curve_ended(w->b));
        CHECK_INT(lw_motion_curve_segments(v->b), lw_motion_curve_segments(w->b));
        CHECK_NEAR(lw_motion_curve_length(v->b), lw_motion_curve_length(w->b), 1e-12, 1e-12);
        for (int i = 0; i <= 40; i++) {
            double arc = lw_motion_curve_length(v->b)*i/40;
            double a = lw_motion_curve_station(v->b, arc), b = lw_motion_curve_station(w->b, arc);
            for (int k = 0; k < l.n_link; k++)
                CHECK_NEAR(distance(tracer_at(v, k, a), tracer_at(w, k, b)), 0, 1e-12, 0);
        }
    }
    curve_free(v);
    curve_free(w);
    return LW_OK;
}

TEST(relabelling_changes_nothing)
{
    for (int n_link = 6; n_link <= 8; n_link += 2) {
        lw_chains *chains;
        lw_rng_seed(&all.rng, check_seed(), 4);
        CHECK_INT(lw_chains_create(n_link, 1, 1, &chains, NULL), LW_OK);
        lw_chain_walk how = lw_chain_walk_default();
        CHECK_INT(lw_chains_each(chains, &how, relabel_chain, NULL), LW_OK);
        lw_chains_free(chains);
    }
}

/* --- Stephenson chains driven at a link that floats --- */

/* Two ternary links joined by three pairs of bars' ends; the input between two moving links, none at the ground. */
TEST(stephenson_driven_at_the_floating_link)
{
    static const int pair[7][2] = { { 0, 2 }, { 2, 1 }, { 0, 3 }, { 3, 4 }, { 4, 1 }, { 0, 5 }, { 5, 1 } };
    static const int input[] = { 1, 3, 4, 6 };
    int ends = 0;
    lw_rng r = check_rng(5);
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage l;
        double reached, end = 0.4;
        blank_linkage(&l, 6);
        l.ground = trial%2 ? 0 : 5;
        for (int j = 0; j < 7; j++)
            add_pin(&l, pair[j][0], pair[j][1], random_place(&r));
        add_input(&l, input[trial/2%4], 0);
        add_tracer(&l, 1, random_place(&r));
        curve *v = follow(&l, 0);
        lw_newton *s;
        CHECK_INT(lw_newton_create(&l, &s, NULL), LW_OK);
        int n;
        const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
        double last = lw_motion_curve_segments(v->b);
        for (int i = n - 1; i >= 0; i--)
            last = e[i].kind == LW_EVENT_LIMIT ? e[i].station : last;
        end = fmin(end, input_at(v, last));
        ends += end < 0.4;
        CHECK_INT(lw_newton_move(s, 0.99*end, &reached), LW_OK);
        double station = lw_motion_curve_find(v->b, 0, last, 0.99*end);
        CHECK_NEAR(distance(tracer_at(v, 0, station), lw_newton_tracer(s, 0)), 0, 1e-10, 0);
        if (end < 0.4) {
            CHECK_INT(lw_newton_move(s, end + 0.01, &reached), LW_OPEN);
            CHECK_NEAR(reached, end, 1e-10, 0);
        }
        lw_newton_free(s);
        curve_free(v);
    }
    CHECK(ends > 10 && ends < 50);
}

/* --- 1e-9 from a singularity --- */

/* Watt's chain on a four-bar 1e-9 from the parallelogram: its limits are those of the four-bar or of the other loop. */
TEST(six_links_next_to_a_change_point)
{
    double k[9] = { 4, 1, 4*(1 + 1e-9), 1, 1, 2, 0, 0, 0 };
    lw_fourbar_class c;
    lw_linkage l;
    int n, of_first = 0;
    lw_fourbar_classify(k, 0, &c, NULL);
    fourbar_linkage(&l, k, 1, 0.5);
    fourbar_joints at = fourbar_at(k, 1, 0.5);
    l.n_link = 6;
    strcpy(l.link_name[4], "E");
    strcpy(l.link_name[5], "F");
    lw_vec2 tip = lw_v2_add(at.b, lw_v2(0.5, 1));
    add_pin(&l, 2, 4, at.p);
    add_pin(&l, 4, 5, lw_v2_add(tip, lw_v2(2, 3)));
    add_pin(&l, 5, 0, lw_v2(6, 3));
    OWNED(curve) *v = follow(&l, 0);
    const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
    CHECK_INT(count(v, LW_EVENT_CROSSING), 0);
    for (int i = 0; i < n; i++)
        for (int d = 0; d < c.n_limit && e[i].kind == LW_EVENT_LIMIT; d++)
            of_first += fabs(remainder(e[i].input - c.limit[d], 2*LW_PI)) < 1e-10;
    CHECK(of_first >= 2);
    CHECK(lw_motion_curve_worst(v->b) <= 1e-12);
}

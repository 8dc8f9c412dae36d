/* tests/test_circuits.c - circuits found by chance against counts known in closed form. */
#include "mbs/constraints/circuits.h"
#include "mbs/kinematics/fourbar.h"
#include "mbs/kinematics/motion.h"
#include "tests/check.h"
#include "tests/kept_system.h"
#include "tests/large_models.h"
#include "tests/mbs_random.h"

static int circuits(const lw_linkage *k, uint64_t seed)
{
    KEPT_SYSTEM s = { 0 };
    OWN(lw_circuits) c = { 0 };
    CHECK_OK(lw_system_make(k, NULL, 0, &s, &check_error));
    CHECK_OK(lw_circuits_find(&s, NULL, &(lw_motion_curve_options){ .input = 0 }, 40, seed, &c, &check_error));
    CHECK(c.since == 40 && !c.late && c.closed <= c.draws);
    for (int i = 0; i < c.n; i++)
        CHECK(lw_motion_curve_worst(c.curve[i]) <= 1e-12*s.unit);
    int n = c.n;
    return n;
}

/* One circuit or two (Barker): two for Grashof's four-bars. */
TEST(four_bars)
{
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 60; trial++) {
        double k[9] = { 0 };
        lw_fourbar_class c;
        do {
            for (int i = 0; i < 4; i++)
                k[i] = lw_rng_range(&r, 0.2, 1.0);
        } while (lw_fourbar_classify(k, LW_FOURBAR_TOLERANCE, &c, NULL) != LW_OK || c.margin < 5e-3);
        lw_linkage l;
        fourbar_linkage(&l, k, 1, 0.5*(c.range[0][0] + c.range[0][1]));
        CHECK_INT(circuits(&l, 1), c.circuits);
    }
}

/* Linkages of two dyads: as many circuits as the plan finds in all its modes. */
TEST(six_links_as_the_plan_says)
{
    int most = 0;
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 25; trial++) {
        lw_linkage l;
        lw_plan p;
        FREED lw_motion *m = calloc(1, sizeof *m);
        double dim[LW_DIM_MAX], mode[LW_DYAD_MAX], input;
        blank_linkage(&l, 6);
        static const int pair[2][7][2] = { { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,3} },
                                           { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,0} } };
        for (int j = 0; j < 7; j++)
            add_pin(&l, pair[trial%2][j][0], pair[trial%2][j][1], random_place(&r));
        add_input(&l, 0, lw_linkage_posture_input(&l, 0));
        CHECK_INT(lw_plan_make(&l, (lw_plan_options){ .all_joints = true }, &p, NULL), LW_OK);
        CHECK_INT(lw_plan_read(&p, &l, dim, mode, &input, NULL), LW_OK);
        CHECK_INT(lw_motion_find(&p, dim, m), LW_OK);
        CHECK_INT(circuits(&l, 1), m->n_circuit);
        most = m->n_circuit > most ? m->n_circuit : most;
    }
    CHECK(most >= 3);
}

/* From the parallelogram the antiparallelogram is found at their crossings, and told apart from it. */
TEST(both_branches_at_a_change_point)
{
    double k[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 }, q[LW_SYSTEM_Q_MAX];
    lw_linkage l;
    KEPT_SYSTEM s = { 0 };
    OWN(lw_circuits) c = { 0 };
    fourbar_linkage(&l, k, 1, 0.5);
    CHECK_OK(lw_system_make(&l, NULL, 0, &s, &check_error));
    CHECK_OK(lw_circuits_find(&s, NULL, &(lw_motion_curve_options){ .input = 0 }, 30, 1, &c, &check_error));
    CHECK_INT(c.n, 2);
    for (int i = 0; i < c.n; i++) {
        int n, crossings = 0;
        const lw_motion_curve_event *event = lw_motion_curve_events(c.curve[i], &n);
        for (int j = 0; j < n; j++)
            if (event[j].kind == LW_EVENT_CROSSING) {
                crossings++;
                CHECK_NEAR(sin(event[j].input), 0, 1e-10, 0);
                CHECK(lw_motion_curve_other(c.curve[i], j, q) && lw_motion_curve_holds(c.curve[1 - i], q));
            } else
                CHECK(!lw_motion_curve_other(c.curve[i], j, q));
        CHECK_INT(crossings, 2);
        CHECK_INT(abs(lw_motion_curve_turns(c.curve[i], -1)), 1);
        for (int j = 0; j <= 200; j++) {
            lw_motion_curve_posture(c.curve[i], lw_motion_curve_segments(c.curve[i])*j/200.0, q, NULL);
            double angle = lw_motion_curve_input(c.curve[i], q);
            lw_vec2 at = lw_system_point(&s, s.tracer_body[0], s.tracer_arm[0], q);
            lw_vec2 a = lw_v2_sub(fourbar_at(k, 1, angle).p, at), b = lw_v2_sub(fourbar_at(k, -1, angle).p, at);
            CHECK_NEAR(fmin(lw_v2_norm(a), lw_v2_norm(b)), 0, 2e-8, 0);      /* half the digits of the formula */
            if (i == 0)
                CHECK_NEAR(q[5], 0, 1e-12, 0);
        }
    }
}

/* A crank turns three rockers, each of which has two assembly modes: 2^3 circuits.  With 30 more links, whose inputs rest, the
 * linkage is solved by sparse rows and has 31 inputs; with none it is not. */
static int modes_found(int more)
{
    text t = { 0 };
    OWN(lw_model) m = { 0 };
    KEPT_SYSTEM s = { 0 };
    OWN(lw_circuits) c = { 0 };
    lw_vec2 b = lw_v2_polar(1, 1);
    int seen = 0;
    put(&t, "{'linkwright': 1, 'links': ['ground', 'crank'");
    for (int i = 0; i < 3; i++)
        put(&t, ", 'b%d', 'r%d'", i, i);
    for (int i = 0; i < more; i++)
        put(&t, ", 'm%d'", i);
    put(&t, "], 'joints': [{'name': 'A', 'links': ['ground', 'crank'], 'at': [0, 0]}");
    for (int i = 0; i < 3; i++) {
        double rod = 2.8 + 0.03*i, rocker = 2 + 0.02*i;
        lw_vec2 d = lw_v2_polar(3, 0.7*i + 0.1), way = lw_v2_sub(d, b);
        double far = lw_v2_norm(way), along = (rod*rod - rocker*rocker + far*far)/(2*far), high = sqrt(rod*rod - along*along);
        lw_vec2 at = lw_v2_add(b, lw_v2_scale(lw_v2_turn(way, lw_v2(along, high)), 1/far));
        put(&t, ", {'name': 'B%d', 'links': ['crank', 'b%d'], 'at': [%.17g, %.17g]}", i, i, b.x, b.y);
        put(&t, ", {'name': 'C%d', 'links': ['b%d', 'r%d'], 'at': [%.17g, %.17g]}", i, i, i, at.x, at.y);
        put(&t, ", {'name': 'D%d', 'links': ['ground', 'r%d'], 'at': [%.17g, %.17g]}", i, i, d.x, d.y);
    }
    for (int i = 0; i < more; i++)
        put(&t, ", {'name': 'M%d', 'links': ['%s%.0d', 'm%d'], 'at': [%.3f, -1]}", i, i == 0 ? "ground" : i == 1 ? "m0" : "m",
            i > 1 ? i - 1 : 0, i, 0.05*i);
    put(&t, "], 'inputs': [{'joint': 'A'}");
    for (int i = 0; i < more; i++)
        put(&t, ", {'joint': 'M%d'}", i);
    put(&t, "]}");
    read_text(&t, &m);
    CHECK_OK(lw_system_assemble(&m.linkage, NULL, 0, &s, &check_error));
    CHECK(more == 0 || s.n_q > LW_SYSTEM_Q_MAX);
    CHECK_OK(lw_circuits_find(&s, NULL, &(lw_motion_curve_options){ .input = 0 }, 100, 1, &c, &check_error));
    FREED double *q = malloc((size_t)s.n_q*sizeof *q);
    for (int i = 0; i < c.n; i++) {
        lw_vec2 p[3];
        int number = 0;
        CHECK_INT(lw_motion_curve_turns(c.curve[i], -1), 1);
        lw_motion_curve_posture(c.curve[i], 0, q, NULL);
        for (int rocker = 0; rocker < 3; rocker++) {
            for (int k = 0; k < 3; k++) {
                const lw_system_joint *j = &s.joint[1 + 3*rocker + k];
                p[k] = lw_system_point(&s, j->body[1], j->arm[1], q);
            }
            number |= (lw_v2_cross(lw_v2_sub(p[2], p[0]), lw_v2_sub(p[1], p[0])) > 0) << rocker;
        }
        seen |= 1 << number;
    }
    CHECK_INT(c.n, 8);
    return seen;
}

TEST(three_rockers_have_eight_circuits_at_any_size)
{
    CHECK_INT(modes_found(0), 255);
    CHECK_INT(modes_found(30), 255);
}

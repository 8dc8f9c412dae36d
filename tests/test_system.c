/* tests/test_system.c - rows, derivatives and series against differences, sums and exact gear trains. */
#include "mbs/constraints/system.h"
#include "tests/check.h"
#include "tests/kept_system.h"
#include "tests/mbs_linkage.h"

static lw_vec2 draw_place(lw_rng *r) { return lw_v2(lw_rng_range(r, -2, 2), lw_rng_range(r, -2, 2)); }

/* A tree of links and some loops, of every kind of joint; gears between links of one carrier. */
static void draw_linkage(lw_rng *r, lw_linkage *k)
{
    static const lw_joint_kind kind[] = { LW_JOINT_REVOLUTE, LW_JOINT_REVOLUTE, LW_JOINT_SLIDER, LW_JOINT_SLOT,
                                          LW_JOINT_FIXED };
    int n = 3 + (int)(lw_rng_bits(r)%6);
    blank_linkage(k, n);
    k->ground = (int)(lw_rng_bits(r)%(uint64_t)n);
    for (int i = 0; i < n + 2; i++) {
        int a = i < n - 1 ? i + 1 : (int)(lw_rng_bits(r)%(uint64_t)n), b = (int)(lw_rng_bits(r)%(uint64_t)n);
        b = i < n - 1 ? (int)(lw_rng_bits(r)%(uint64_t)a) : a == b ? (b + 1)%n : b;
        int j = add_joint(k, kind[lw_rng_bits(r)%5], a, b, draw_place(r), lw_rng_range(r, -3, 3));
        if (k->joint[j].kind == LW_JOINT_FIXED)
            k->joint[j].along = lw_v2(0, 0);
    }
    for (int end = 0; end < 2; end++)                   /* two links on link `end`, meshing */
        add_joint(k, lw_rng_bits(r)%2 ? LW_JOINT_REVOLUTE : LW_JOINT_SLIDER, end ? 0 : 2, end ? 1 : 0, draw_place(r),
                  lw_rng_range(r, -3, 3));
    lw_gear gear;
    int j = add_joint(k, LW_JOINT_GEAR, 1, 2, draw_place(r), 0);
    k->joint[j].along = lw_v2(0, 0);
    k->joint[j].ratio = lw_rng_range(r, -3, 3);
    if (lw_linkage_gear(k, j, &gear, NULL) != LW_OK)
        k->n_joint--;
    for (j = 0; j < k->n_joint && k->n_input < 3; j++)
        if (k->joint[j].kind == LW_JOINT_REVOLUTE || k->joint[j].kind == LW_JOINT_SLIDER)
            add_input(k, j, lw_rng_range(r, -1, 1));
    add_tracer(k, n - 1, draw_place(r));
}

static lw_system make(const lw_linkage *k)
{
    lw_system s;
    CHECK_OK(lw_system_make(k, NULL, 0, &s, &check_error));
    return s;
}

static void draw_q(lw_rng *r, const lw_system *s, double *q)
{
    lw_system_posture(s, q);
    for (int i = 0; i < s->n_q; i++)
        q[i] += lw_rng_range(r, -1, 1);
}

TEST(the_posture_satisfies_its_rows)
{
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 500; trial++) {
        lw_linkage k;
        double q[LW_SYSTEM_Q_MAX], phi[LW_SYSTEM_ROW_MAX];
        draw_linkage(&r, &k);
        KEPT_SYSTEM s = make(&k);
        CHECK_INT(s.n_q, 3*(k.n_link - 1));
        CHECK_INT(s.n_q - s.n_row, lw_linkage_mobility(&k));
        lw_system_posture(&s, q);
        lw_system_rows(&s, q, phi, NULL);
        for (int i = 0; i < s.n_row; i++)
            CHECK_NEAR(phi[i], 0, 1e-15, 0);
        for (int j = 0; j < k.n_joint; j++)
            CHECK_NEAR(lw_system_measure(&s, j, q, NULL), 0, 1e-15, 0);
        lw_vec2 p = lw_system_point(&s, s.tracer_body[0], s.tracer_arm[0], q);
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(p, k.tracer[0].at)), 0, 2e-15, 0);
    }
}

/* Derivatives of rows and of what joints count against central differences away from the posture. */
TEST(derivatives_agree_with_differences)
{
    const double h = 1e-5;
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 300; trial++) {
        lw_linkage k;
        static double jac[LW_SYSTEM_ROW_MAX*LW_SYSTEM_Q_MAX], row[LW_JOINT_MAX][LW_SYSTEM_Q_MAX];
        double q[LW_SYSTEM_Q_MAX], phi[3][LW_SYSTEM_ROW_MAX], filled = 0;
        draw_linkage(&r, &k);
        KEPT_SYSTEM s = make(&k);
        draw_q(&r, &s, q);
        lw_system_rows(&s, q, phi[0], jac);
        for (int j = 0; j < k.n_joint; j++)
            lw_system_measure(&s, j, q, row[j]);
        for (int i = 0; i < s.n_q; i++) {
            double at = q[i], count[2][LW_JOINT_MAX];
            for (int side = 0; side < 2; side++) {
                q[i] = at + (side ? h : -h);
                lw_system_rows(&s, q, phi[1 + side], NULL);
                for (int j = 0; j < k.n_joint; j++)
                    count[side][j] = lw_system_measure(&s, j, q, NULL);
            }
            q[i] = at;
            for (int m = 0; m < s.n_row; m++)
                CHECK_NEAR(jac[m*s.n_q + i], (phi[2][m] - phi[1][m])/(2*h), 1e-8, 0);
            for (int j = 0; j < k.n_joint; j++)
                CHECK_NEAR(row[j][i], (count[1][j] - count[0][j])/(2*h), 1e-8, 0);
        }
        for (int m = 0; m < s.n_row; m++) {
            int body[LW_SYSTEM_ROW_BODIES], named = 0;
            lw_system_row_bodies(&s, m, body);
            while (named < LW_SYSTEM_ROW_BODIES && body[named] >= 0)
                named++;
            for (int i = 0; i < s.n_q; i++) {
                int n = 0;
                while (n < named && body[n] != i/3)
                    n++;
                CHECK(jac[m*s.n_q + i] == 0 || n < named);
                filled += jac[m*s.n_q + i] != 0;
            }
        }
        CHECK(filled > 0);
    }
}

/* Sum of coefficients at t against the rows there: the remainder is of order t^9. */
TEST(series_sum_to_the_rows)
{
    enum { K = LW_SYSTEM_ORDER_MAX };
    const double t = 0.01;
    lw_rng r = check_rng(3);
    for (int trial = 0; trial < 100; trial++) {
        lw_linkage k;
        static double q[(K + 1)*LW_SYSTEM_Q_MAX], phi[(K + 1)*LW_SYSTEM_ROW_MAX];
        static double jac[LW_SYSTEM_ROW_MAX*LW_SYSTEM_Q_MAX];
        double at[LW_SYSTEM_Q_MAX], want[LW_SYSTEM_ROW_MAX], count[K + 1];
        lw_vec2 p[K + 1], sum = { 0, 0 };
        draw_linkage(&r, &k);
        KEPT_SYSTEM s = make(&k);
        draw_q(&r, &s, q);
        for (int i = s.n_q; i < (K + 1)*s.n_q; i++)
            q[i] = lw_rng_range(&r, -1, 1);
        for (int i = 0; i < s.n_q; i++)
            for (int n = K; n >= 0; n--)
                at[i] = (n == K ? 0 : at[i]*t) + q[n*s.n_q + i];
        lw_system_series(&s, K, q, phi);
        lw_system_rows(&s, at, want, NULL);
        for (int m = 0; m < s.n_row; m++) {
            double got = 0;
            for (int n = K; n >= 0; n--)
                got = got*t + phi[n*s.n_row + m];
            CHECK_NEAR(got, want[m], 2e-14, 0);
        }
        for (int j = 0; j < k.n_joint; j++) {
            double got = 0;
            lw_system_measure_series(&s, j, K, q, count);
            for (int n = K; n >= 0; n--)
                got = got*t + count[n];
            CHECK_NEAR(got, lw_system_measure(&s, j, at, NULL), 2e-14, 0);
        }
        lw_system_point_series(&s, s.tracer_body[0], s.tracer_arm[0], K, q, p);
        for (int n = K; n >= 0; n--)
            sum = lw_v2_add(lw_v2_scale(sum, t), p[n]);
        lw_vec2 there = lw_system_point(&s, s.tracer_body[0], s.tracer_arm[0], at);
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(sum, there)), 0, 1e-13, 0);
        /* coefficient K = J q_K + what the others give */
        lw_system_rows(&s, q, want, jac);
        for (int m = 0; m < s.n_row; m++) {
            want[m] = phi[K*s.n_row + m];
            for (int i = 0; i < s.n_q; i++)
                want[m] -= jac[m*s.n_q + i]*q[K*s.n_q + i];
        }
        memset(q + K*s.n_q, 0, (size_t)s.n_q*sizeof *q);
        lw_system_series(&s, K, q, phi);
        for (int m = 0; m < s.n_row; m++)
            CHECK_NEAR(phi[K*s.n_row + m], want[m], 1e-12, 1e-12);
    }
}

/* Cardan's gears: in a ring twice its size a planet's rim runs on a diameter.  Planet: centre e^{i t}, turn -t. */
TEST(cardan_gears_satisfy_the_rows)
{
    lw_linkage k;
    blank_linkage(&k, 3);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), GEAR(0, 2, 2, 0, 2)));
    add_input(&k, 0, 0);
    add_tracer(&k, 2, lw_v2(2, 0));
    KEPT_SYSTEM s = make(&k);
    CHECK_INT(s.n_q - s.n_row, 1);
    double start[6], q[6], phi[5];
    lw_system_posture(&s, start);
    for (int i = 0; i < 50; i++) {
        double t = 0.37*i;
        lw_vec2 arm = lw_v2_scale(lw_v2_sub(k.joint[0].at, s.origin), -1/s.unit);        /* crank: turn about the pin */
        lw_vec2 turned = lw_v2_turn(lw_v2_add(lw_v2(start[0], start[1]), arm), lw_v2_polar(1, t));
        q[0] = turned.x - arm.x, q[1] = turned.y - arm.y, q[2] = t;
        lw_vec2 rel = lw_v2_sub(lw_v2(start[3], start[4]), lw_v2_scale(lw_v2_sub(lw_v2(1, 0), s.origin), 1/s.unit));
        lw_vec2 centre = lw_v2_scale(lw_v2_sub(lw_v2_polar(1, t), s.origin), 1/s.unit);
        centre = lw_v2_add(centre, lw_v2_turn(rel, lw_v2_polar(1, -t)));
        q[3] = centre.x, q[4] = centre.y, q[5] = -t;
        lw_system_rows(&s, q, phi, NULL);
        for (int m = 0; m < 5; m++)
            CHECK_NEAR(phi[m], 0, 1e-14, 0);
        lw_vec2 p = lw_system_point(&s, s.tracer_body[0], s.tracer_arm[0], q);
        CHECK_NEAR(p.y, 0, 1e-14, 0);
        CHECK_NEAR(p.x, 2*cos(t), 1e-14, 0);
        lw_linkage there = k;
        lw_system_write(&s, q, &there);
        CHECK_NEAR(there.input[0].value, t, 1e-14, 0);
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(there.joint[2].at, lw_v2_polar(2, t))), 0, 1e-13, 0);
    }
}

/* A pinion of radius 0.5 m on a rack that slides at 30 degrees: v = 0.5 w, either side the rack. */
TEST(rack_and_pinion)
{
    for (int way = 0; way < 4; way++) {
        lw_linkage k;
        blank_linkage(&k, 3);
        double phi[5], q[6], slope = LW_PI/6, sense = way & 2 ? -1 : 1;
        add_pin(&k, 0, 1, lw_v2(3, 4));
        if (way & 2)
            add_slide(&k, 2, 0, lw_v2(1, 2), slope);
        else
            add_slide(&k, 0, 2, lw_v2(1, 2), slope);
        lw_vec2 contact = lw_v2_add(lw_v2(3, 4), lw_v2_polar(0.5, slope - LW_PI/2));
        if (way & 1)
            add_gear(&k, 2, 1, contact, 2);
        else
            add_gear(&k, 1, 2, contact, 0.5);
        add_input(&k, 0, 0);
        lw_gear g;
        CHECK_INT(lw_linkage_gear(&k, 2, &g, NULL), LW_OK);
        CHECK_INT(g.carrier, 0);
        CHECK_INT(g.slider[way & 1 ? 0 : 1], 1);
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(lw_gear_contact(k.joint, 2, &g), contact)), 0, 1e-15, 0);
        KEPT_SYSTEM s = make(&k);
        lw_system_posture(&s, q);
        double turn = 0.7;
        lw_vec2 rel = lw_v2_sub(lw_v2(q[0], q[1]), lw_v2_scale(lw_v2_sub(lw_v2(3, 4), s.origin), 1/s.unit));
        lw_vec2 moved = lw_v2_add(lw_v2_scale(lw_v2_sub(lw_v2(3, 4), s.origin), 1/s.unit), lw_v2_turn(rel, lw_v2_polar(1, turn)));
        q[0] = moved.x, q[1] = moved.y, q[2] = turn;
        q[3] += 0.5*turn/s.unit*cos(slope);
        q[4] += 0.5*turn/s.unit*sin(slope);
        lw_system_rows(&s, q, phi, NULL);
        for (int m = 0; m < 5; m++)
            CHECK_NEAR(phi[m], 0, 1e-15, 0);
        CHECK_NEAR(lw_system_measure(&s, 1, q, NULL)*s.unit, 0.5*turn*sense, 1e-15, 0);
    }
}

/* Watt's sun and planet: the planet is fixed to the rod, the arm and the sun turn on one pin. */
TEST(the_carrier_is_found)
{
    lw_linkage k;
    lw_gear g;
    enum { GROUND, BEAM, ROD, ARM, SUN };
    blank_linkage(&k, 5);
    add_joints(&k, JOINTS(PIN(GROUND, BEAM, -3, 5), PIN(BEAM, ROD, 0, 5), PIN(ROD, ARM, 1, 0), PIN(GROUND, ARM, 0, 0),
                          PIN(GROUND, SUN, 0, 0), GEAR(ROD, SUN, 0.5, 0, -1)));
    CHECK_OK(lw_linkage_gear(&k, 5, &g, &check_error));
    CHECK_INT(g.carrier, ARM);
    CHECK(g.slider[0] < 0 && g.slider[1] < 0);
    /* welded links are one: the planet as a link of its own */
    blank_linkage(&k, 4);
    add_pin(&k, 0, 1, lw_v2(0, 0));
    add_pin(&k, 1, 2, lw_v2(2, 0));
    int weld = add_joint(&k, LW_JOINT_FIXED, 2, 3, lw_v2(2, 1), 0);
    k.joint[weld].along = lw_v2(0, 0);
    add_gear(&k, 0, 3, lw_v2(1, 0), -1);
    CHECK_OK(lw_linkage_gear(&k, 3, &g, &check_error));
    CHECK_INT(g.carrier, 1);
    CHECK_INT(lw_linkage_mobility(&k), 1);
    /* none, and two of which the contact tells one */
    k.joint[3].link[0] = 1;
    CHECK_FAILS(lw_linkage_gear(&k, 3, &g, &check_error), LW_E_KIND, "no link carries both");
    blank_linkage(&k, 4);
    for (int i = 0; i < 4; i++)
        add_pin(&k, i, (i + 1)%4, lw_v2_polar(1, 1.5*i));
    add_gear(&k, 1, 3, lw_v2(9, 9), -2);
    CHECK_FAILS(lw_linkage_gear(&k, 4, &g, &check_error), LW_E_KIND, "2 links in common");
    k.joint[4].at = lw_v2_add(lw_v2_scale(k.joint[1].at, 1/3.0), lw_v2_scale(k.joint[2].at, 2/3.0));
    CHECK_OK(lw_linkage_gear(&k, 4, &g, &check_error));
    CHECK_INT(g.carrier, 2);
}

/* A sun on an arm that carries more planets than a linkage holds links; the arm turns on the pin of the sun. */
TEST(the_carrier_of_many_gears_is_found)
{
    enum { PLANETS = 40, GROUND = 0, ARM, SUN, N_LINK, N_JOINT = 2 + 2*PLANETS };
    static char name[N_LINK + PLANETS][LW_NAME_SIZE];
    static lw_joint joint[N_JOINT];
    lw_assembly a = { .n_link = N_LINK + PLANETS, .n_joint = N_JOINT, .link_name = name, .joint = joint };
    joint[0] = (lw_joint){ .kind = LW_JOINT_REVOLUTE, .link = { GROUND, ARM } };
    joint[1] = (lw_joint){ .kind = LW_JOINT_REVOLUTE, .link = { GROUND, SUN } };
    for (int i = 0; i < PLANETS; i++) {
        lw_vec2 at = lw_v2_polar(3, 2*LW_PI*i/PLANETS);
        joint[2 + i] = (lw_joint){ .kind = LW_JOINT_REVOLUTE, .link = { ARM, N_LINK + i }, .at = at };
        joint[2 + PLANETS + i] = (lw_joint){ .kind = LW_JOINT_GEAR, .link = { N_LINK + i, SUN }, .ratio = -0.5 };
    }
    for (int i = 0; i < PLANETS; i++) {
        lw_gear g;
        lw_vec2 contact;
        CHECK_OK(lw_assembly_gear(&a, 2 + PLANETS + i, &g, &contact, &check_error));
        CHECK_INT(g.carrier, ARM);
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(contact, lw_v2_polar(2, 2*LW_PI*i/PLANETS))), 0, 1e-14, 0);
    }
}

/* A moved linkage written down is a posture of a system again, whose input counts on. */
TEST(a_written_posture_closes)
{
    lw_rng r = check_rng(4);
    for (int trial = 0; trial < 50; trial++) {
        lw_linkage k, moved;
        double q[9], phi[9];
        blank_linkage(&k, 4);                         /* crank, block on a slide, bar in a slot */
        add_pin(&k, 0, 1, draw_place(&r));
        add_slide(&k, 1, 2, draw_place(&r), lw_rng_range(&r, -3, 3));
        add_joint(&k, LW_JOINT_SLOT, 2, 3, draw_place(&r), lw_rng_range(&r, -3, 3));
        add_input(&k, 0, 0.3);
        add_input(&k, 1, 0.2);
        add_tracer(&k, 3, draw_place(&r));
        KEPT_SYSTEM s = make(&k);
        double turn = lw_rng_range(&r, -2, 2), way = lw_rng_range(&r, -2, 2), slot = lw_rng_range(&r, -2, 2);
        lw_vec2 o = k.joint[0].at, dir = lw_v2_polar(1, turn), along = lw_v2_turn(k.joint[1].along, dir);
        lw_system_posture(&s, q);
        for (int b = 0; b < 3; b++) {                     /* all turn about the pin, then slide */
            lw_vec2 at = lw_v2_add(s.origin, lw_v2_scale(lw_v2(q[3*b], q[3*b + 1]), s.unit));
            at = lw_v2_add(o, lw_v2_turn(lw_v2_sub(at, o), dir));
            at = lw_v2_add(at, lw_v2_scale(along, b > 0 ? way : 0));
            at = lw_v2_add(at, lw_v2_scale(lw_v2_turn(k.joint[2].along, dir), b > 1 ? slot : 0));
            q[3*b] = (at.x - s.origin.x)/s.unit, q[3*b + 1] = (at.y - s.origin.y)/s.unit, q[3*b + 2] = turn;
        }
        moved = k;
        lw_system_write(&s, q, &moved);
        CHECK_NEAR(moved.input[0].value, 0.3 + turn, 1e-14, 0);
        CHECK_NEAR(moved.input[1].value, 0.2 + way, 1e-14, 0);
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(moved.joint[0].at, o)), 0, 1e-14, 0);
        CHECK_NEAR(lw_v2_cross(moved.joint[1].along, along), 0, 1e-15, 0);
        KEPT_SYSTEM again = make(&moved);
        CHECK_NEAR(lw_system_measure(&s, 2, q, NULL)*s.unit, slot, 1e-14, 0);
        lw_system_posture(&again, q);
        lw_system_rows(&again, q, phi, NULL);
        for (int m = 0; m < again.n_row; m++)
            CHECK_NEAR(phi[m], 0, 1e-15, 0);
    }
}

TEST(scale_and_references_may_be_given)
{
    lw_linkage k;
    lw_vec2 reference[2] = { { 0, 0 }, { 5, 6 } };
    KEPT_SYSTEM s = { 0 };
    double q[3];
    blank_linkage(&k, 2);
    add_pin(&k, 0, 1, lw_v2(1, 1));
    CHECK_OK(lw_system_make(&k, reference, 1.0, &s, &check_error));
    lw_system_posture(&s, q);
    CHECK(q[0] == 5 && q[1] == 6 && q[2] == 0 && s.unit == 1 && s.origin.x == 0 && s.origin.y == 0);
    lw_system_free(&s);
    CHECK_OK(lw_system_make(&k, NULL, 0, &s, &check_error));   /* no extent: any unit, or that of a tracer */
    CHECK(s.unit == 1 && s.origin.x == 1 && s.origin.y == 1);
    add_tracer(&k, 1, lw_v2(4, 5));
    lw_system_free(&s);
    CHECK_OK(lw_system_make(&k, NULL, 0, &s, &check_error));
    CHECK(s.unit == 5);
    k.joint[0].link[1] = 7;
    lw_system_free(&s);
    CHECK_FAILS(lw_system_make(&k, NULL, 1, &s, &check_error), LW_E_ARG, "J1");
    blank_linkage(&k, 3);
    add_joints(&k, JOINTS(PIN(0, 1, 1, 1), PIN(1, 2, 2, 1), GEAR(1, 2, 3, 1, 2)));
    lw_system_free(&s);
    CHECK_FAILS(lw_system_make(&k, NULL, 0, &s, &check_error), LW_E_KIND, "no link carries both");
}

/* The plan: dimensions out of a posture and back, linkages told in any order, what cannot be planned. */
#include "mbs/constraints/newton.h"
#include "mbs/batch/posture.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

typedef struct planned { lw_linkage k; lw_plan p; double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input; } planned;

static bool plan_all(planned *q)
{
    lw_error e = { .text = "" };
    CHECK_INT(lw_plan_make(&q->k, (lw_plan_options){ .tracers = (1u << q->k.n_tracer) - 1, .all_joints = true }, &q->p,
                           &e), LW_OK);
    CHECK_TEXT(e.text, "");
    return lw_plan_read(&q->p, &q->k, q->dim, q->mode, &q->input, &e) == LW_OK;
}

/* How far two postures are apart, over the size of the first. */
static double apart(const lw_linkage *a, const lw_linkage *b)
{
    double size = 0, d = 0;
    for (int j = 0; j < a->n_joint; j++) {
        size = fmax(size, lw_v2_norm(a->joint[j].at));
        d = fmax(d, lw_v2_norm(lw_v2_sub(a->joint[j].at, b->joint[j].at)));
        d = fmax(d, size*lw_v2_norm(lw_v2_sub(a->joint[j].along, b->joint[j].along)));
    }
    for (int i = 0; i < a->n_tracer; i++) {
        d = fmax(d, lw_v2_norm(lw_v2_sub(a->tracer[i].at, b->tracer[i].at)));
        d = fmax(d, size*fabs(a->tracer[i].angle - b->tracer[i].angle));
    }
    return d/size;
}

/* Rounding grows near singular postures, by the reciprocal sine at the dyad, and with dimensions larger
 * than the posture: slides that are nearly parallel meet far away. */
static void check_round_trip(planned *q, double growth)
{
    lw_posture posture;
    lw_linkage back = q->k;
    double far = fmax(1, fabs(q->p.input_is_slider ? q->input : 0));
    for (int d = 0; d < q->p.n_dim; d++)
        far = fmax(far, fabs(q->dim[d]));
    growth *= far;
    CHECK_INT(lw_posture_solve(&q->p, q->dim, q->mode, q->input, 0, &posture), LW_OK);
    CHECK_INT(lw_plan_write(&q->p, q->dim, q->mode, q->input, &back), LW_OK);
    CHECK(apart(&q->k, &back) <= growth*1e-15/posture.margin);
    CHECK_NEAR(back.input[0].value, q->k.input[0].value, growth*1e-15/posture.margin, 0);
}

TEST(types_read_and_write)
{
    static planned q;
    lw_rng r = check_rng(1);
    for (const lw_type *t = lw_type_table; t->letters; t++)
        for (int trial = 0; trial < 500; trial++) {
            lw_linkage k;
            random_type(&r, t, &k);
            shuffle_linkage(&r, &k, &q.k);
            if (plan_all(&q))
                check_round_trip(&q, 100);
            CHECK_INT(q.p.n_dyad, 1);
            CHECK_INT(q.p.input_is_slider, t->input_is_slider);
        }
}

TEST(grown_linkages_read_and_write)
{
    static planned q;
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 2000; trial++) {
        lw_linkage k;
        random_grown(&r, 1 + trial%4, &k);
        shuffle_linkage(&r, &k, &q.k);
        CHECK(plan_all(&q));
        CHECK_INT(q.p.n_dyad, 1 + trial%4);
        check_round_trip(&q, 1e6);                   /* a slope of one dyad is the error of the next */
    }
}

/* The order of telling changes names at most: what is traced over a step of the input stays. */
TEST(order_of_telling_does_not_matter)
{
    static planned a, b;
    lw_rng r = check_rng(3);
    for (int trial = 0; trial < 500; trial++) {
        lw_posture pa, pb;
        random_grown(&r, 2, &a.k);
        shuffle_linkage(&r, &a.k, &b.k);
        CHECK(plan_all(&a) && plan_all(&b));
        lw_status sa = lw_posture_solve(&a.p, a.dim, a.mode, a.input + 1e-3, 1, &pa);
        lw_status sb = lw_posture_solve(&b.p, b.dim, b.mode, b.input + 1e-3, 1, &pb);
        CHECK_INT(sa, sb);
        if (sa != LW_OK || pa.margin < 1e-3)
            continue;
        double size = 1 + lw_v2_norm(pa.tracer[0][0]) + lw_v2_norm(pa.tracer[0][1]);
        for (int i = 0; i < 2; i++)
            CHECK_POINT(pb.tracer[0][i], pa.tracer[0][i].x, pa.tracer[0][i].y, 1e-9*size, 0);
    }
}

/* Another posture of the same linkage has the same dimensions. */
TEST(dimensions_do_not_move)
{
    static planned q;
    lw_rng r = check_rng(4);
    for (const lw_type *t = lw_type_table; t->letters; t++)
        for (int trial = 0; trial < 200; trial++) {
            double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input, step = lw_rng_range(&r, -0.2, 0.2);
            lw_posture posture;
            random_type(&r, t, &q.k);
            lw_linkage moved = q.k;
            if (!plan_all(&q) || lw_plan_write(&q.p, q.dim, q.mode, q.input + step, &moved) != LW_OK)
                continue;
            lw_posture_solve(&q.p, q.dim, q.mode, q.input + step, 0, &posture);
            if (posture.margin < 1e-6)
                continue;
            CHECK_INT(lw_plan_read(&q.p, &moved, dim, mode, &input, NULL), LW_OK);
            for (int d = 0; d < q.p.n_dim; d++)
                CHECK_NEAR(dim[d], q.dim[d], 1e-10*(1 + fabs(q.input)), 1e-10);
            double turn = q.p.input_is_slider ? 1e300 : 2*LW_PI, far = 1 + fabs(q.input);
            CHECK_NEAR(remainder(input - q.input - step, turn), 0, 1e-10*far, 0);
            CHECK_NEAR(moved.input[0].value - q.k.input[0].value, step, 1e-14*far, 0);
            CHECK(mode[0] == q.mode[0] || strchr("PRP PPR", t->letters[1]) != NULL);
        }
}

/* The displacement is that of link[1] against link[0] along `along`, whichever of them is the ground. */
TEST(slider_inputs_count_as_the_file_says)
{
    static planned q;
    lw_rng r = check_rng(5);
    for (const lw_type *t = lw_type_table; t->letters; t++)
        for (int trial = 0; t->input_is_slider && trial < 200; trial++) {
            random_type(&r, t, &q.k);
            if (trial & 1) {
                q.k.joint[0].link[0] = 1;
                q.k.joint[0].link[1] = 0;
            }
            lw_linkage moved = q.k;
            if (!plan_all(&q) || lw_plan_write(&q.p, q.dim, q.mode, q.input + 0.1, &moved) != LW_OK)
                continue;
            double far = 1 + fabs(q.input);
            CHECK_NEAR(moved.input[0].value, q.k.input[0].value + 0.1, 1e-14*far, 0);
            lw_vec2 step = lw_v2_sub(moved.joint[1].at, q.k.joint[1].at);
            if (t->letters[1] == 'R')                     /* the pin of the driven slider */
                CHECK_NEAR(lw_v2_dot(step, q.k.joint[0].along), trial & 1 ? -0.1 : 0.1, 1e-14*far, 0);
        }
}

/* The second opinion: Newton's method on the loop equations, from the same file to the same input. */
TEST(newton_arrives_at_the_same_place)
{
    static planned q;
    int n_checked = 0;
    lw_rng r = check_rng(6);
    for (int trial = 0; trial < 600; trial++) {
        lw_linkage k;
        lw_newton *s;
        lw_posture posture;
        if (trial%2)
            random_type(&r, &lw_type_table[trial/2%11], &k);
        else
            random_grown(&r, 1 + trial/2%3, &k);
        shuffle_linkage(&r, &k, &q.k);
        double step = lw_rng_range(&r, -0.3, 0.3), least = 1, reached;
        if (!plan_all(&q))
            continue;
        for (int i = 0; i <= 20; i++) {
            lw_posture_solve(&q.p, q.dim, q.mode, q.input + step*i/20, 0, &posture);
            least = fmin(least, posture.margin);
        }
        if (least < 0.01 || lw_newton_create(&q.k, &s, NULL) != LW_OK)
            continue;
        if (lw_newton_move(s, q.k.input[0].value + step, &reached) == LW_OK) {
            lw_vec2 p = lw_newton_tracer(s, 0);
            double size = 1 + lw_v2_norm(p);
            CHECK_POINT(posture.tracer[0][0], p.x, p.y, 1e-9*size, 0);
            n_checked++;
        }
        lw_newton_free(s);
    }
    CHECK(n_checked > 100);
}

TEST(jansen_is_five_dyads)
{
    static planned q;
    jansen_linkage(&q.k);
    CHECK(plan_all(&q));
    CHECK_INT(q.p.n_dyad, 5);
    CHECK_INT(q.p.n_dim, 1 + 1 + 10 + 2 + 3);             /* ground, crank, ten bars; tracer; place */
    CHECK_NEAR(q.dim[lw_plan_dim(&q.p, "r1")], hypot(38, 7.8), 1e-14, 0);
    CHECK_NEAR(q.dim[lw_plan_dim(&q.p, "r2")], 15, 1e-14, 0);
    check_round_trip(&q, 1e3);
}

/* Only what the tracer hangs on: on the bar j one dyad, whatever else the leg has. */
TEST(plans_hold_what_is_wanted)
{
    static planned q;
    jansen_linkage(&q.k);
    q.k.tracer[0].link = 2;
    CHECK_INT(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 1 }, &q.p, NULL), LW_OK);
    CHECK_INT(q.p.n_dyad, 1);
    CHECK_INT(q.p.n_dim, 9);
    add_tracer(&q.k, 8, lw_v2(1, 2));                     /* bar f: three dyads more, two names more */
    CHECK_INT(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 3 }, &q.p, NULL), LW_OK);
    CHECK_INT(q.p.n_dyad, 4);
    CHECK(q.p.n_output_step[0] < q.p.n_output_step[1]);
    CHECK(lw_plan_dim(&q.p, "cx2") >= 0 && lw_plan_dim(&q.p, "cx3") < 0);
    CHECK_INT(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 2 }, &q.p, NULL), LW_OK);
    CHECK_INT(q.p.output_tracer[0], 1);
}

/* Six bars that are no chain of dyads: three links on three links. */
static void triad_linkage(lw_linkage *k)
{
    blank_linkage(k, 6);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 1), PIN(0, 3, 4, 0), PIN(0, 4, 2, -2), PIN(2, 5, 2, 2), PIN(3, 5, 4, 2),
                         PIN(4, 5, 3, 1)));
    add_input(k, 0, 0);
    add_tracer(k, 5, lw_v2(3, 3));
}

TEST(says_what_cannot_be_planned)
{
    static planned q;
    const lw_plan_options want = { .tracers = 1 };
    triad_linkage(&q.k);
    CHECK_FAILS(lw_plan_make(&q.k, want, &q.p, &check_error), LW_E_KIND, "\"L3\", \"L4\", \"L5\", \"L6\"");
    CHECK_OK(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_HIGHER }, &q.p, &check_error));
    CHECK_INT(q.p.n_higher, 1);
    CHECK_INT(q.p.higher[0].n_link, 4);
    CHECK_INT(q.p.n_mode, 5);
    lw_type_linkage(lw_type_find("fourbar"), &q.k);
    CHECK_INT(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 0 }, &q.p, &check_error), LW_E_ARG);
    CHECK_INT(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 2 }, &q.p, &check_error), LW_E_ARG);
    q.k.input[0].joint = 1;
    CHECK_FAILS(lw_plan_make(&q.k, want, &q.p, &check_error), LW_E_KIND, "does not touch the ground");
    CHECK_OK(lw_plan_make(&q.k, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_HIGHER }, &q.p, &check_error));
    CHECK_INT(q.p.n_higher, 1);
    CHECK_INT(q.p.n_dyad, 0);
    q.k.n_input = 0;
    CHECK_INT(lw_plan_make(&q.k, want, &q.p, &check_error), LW_E_KIND);
    lw_type_linkage(lw_type_find("fourbar"), &q.k);
    q.k.joint[2].kind = LW_JOINT_GEAR;
    q.k.joint[2].ratio = 2;
    CHECK_FAILS(lw_plan_make(&q.k, want, &q.p, &check_error), LW_E_KIND, "kind 'g'");
    lw_type_linkage(lw_type_find("fourbar"), &q.k);
    strcpy(q.k.link_name[4], "loose");
    q.k.n_link = 5;
    CHECK_INT(lw_plan_make(&q.k, want, &q.p, &check_error), LW_E_ARG);
    blank_linkage(&q.k, 4);                                /* two bars more than freedom one */
    add_joints(&q.k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), PIN(2, 3, 2, 1)));
    add_input(&q.k, 0, 0);
    add_tracer(&q.k, 1, lw_v2(1, 1));
    CHECK_INT(lw_plan_make(&q.k, want, &q.p, &check_error), LW_E_KIND);
}

TEST(postures_that_contradict_themselves)
{
    static planned q;
    jansen_linkage(&q.k);
    CHECK(plan_all(&q));
    lw_linkage bad = q.k;
    bad.joint[2].at.x += 1e-3;                            /* one pin at two places */
    CHECK_FAILS(lw_plan_read(&q.p, &bad, q.dim, q.mode, &q.input, &check_error), LW_E_ARG, "one pin in the plan");
    CHECK_INT(lw_plan_write(&q.p, q.dim, q.mode, q.input, &bad), LW_E_ARG);
    lw_type_linkage(lw_type_find("fourbar"), &q.k);
    CHECK(plan_all(&q));
    bad = q.k;
    bad.joint[2].at = bad.joint[1].at;                    /* a coupler of no length has no direction */
    CHECK_FAILS(lw_plan_read(&q.p, &bad, q.dim, q.mode, &q.input, &check_error), LW_E_ARG, "at one place");
    bad.joint[2].kind = LW_JOINT_SLIDER;
    CHECK_INT(lw_plan_read(&q.p, &bad, q.dim, q.mode, &q.input, &check_error), LW_E_ARG);
    lw_linkage same = q.k;
    CHECK_INT(lw_plan_write(&q.p, (double[9]){ 9, 1, 2, 3, 0, 0, 0, 0, 0 }, q.mode, 0, &same), LW_OPEN);
    CHECK(memcmp(&same, &q.k, sizeof same) == 0);
}

/* Ground slides only: parallel ones have no meeting point, so that the offset counts; a ground of one
 * pin and no slide at all is a crank. */
TEST(grounds_of_every_kind)
{
    static planned q;
    lw_type_linkage(lw_type_find("trammel"), &q.k);
    q.k.joint[3].along = q.k.joint[0].along;
    CHECK(plan_all(&q));
    CHECK(lw_plan_dim(&q.p, "e1") >= 0 && lw_plan_dim(&q.p, "beta1") >= 0);
    CHECK_NEAR(fabs(q.dim[lw_plan_dim(&q.p, "e1")]), 1.5, 1e-15, 0);
    check_round_trip(&q, 10);
    blank_linkage(&q.k, 2);
    add_pin(&q.k, 0, 1, lw_v2(1, 2));
    add_input(&q.k, 0, LW_PI/4);
    add_tracer(&q.k, 1, lw_v2(2, 3));
    CHECK(plan_all(&q));
    CHECK_NEAR(q.dim[lw_plan_dim(&q.p, "cx")], sqrt(2), 1e-15, 0);
    CHECK_NEAR(q.input, LW_PI/4, 1e-15, 0);
    check_round_trip(&q, 10);
}

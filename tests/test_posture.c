/* One posture in full: bars keep their lengths, derivatives of each order against differences of the one below,
 * limits and dead points. */
#include "mbs/batch/batch.h"
#include "mbs/batch/posture.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

typedef struct subject { lw_linkage k; lw_plan p; double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input; } subject;

static bool plan_of(subject *q)
{
    CHECK_INT(lw_plan_make(&q->k, (lw_plan_options){ .tracers = (1u << q->k.n_tracer) - 1, .all_joints = true }, &q->p,
                           NULL), LW_OK);
    return lw_plan_read(&q->p, &q->k, q->dim, q->mode, &q->input, NULL) == LW_OK;
}

/* Four-link chains of every type and bigger ones in turn. */
static bool random_subject(lw_rng *r, int trial, subject *q)
{
    if (trial%2)
        random_grown(r, 1 + trial/2%3, &q->k);
    else
        random_type(r, &lw_type_table[trial/2%11], &q->k);
    return plan_of(q);
}

/* Distances between the pins and tracers of one link, and what slides: two sliding links keep their
 * angle and the distance of a pin of one from the slide line of the other. */
static void check_rigid(const subject *q, const lw_posture *now, double tolerance)
{
    const lw_linkage *k = &q->k;
    for (int i = 0; i < k->n_joint; i++)
        for (int j = 0; j < i; j++)
            for (int h = 0; h < 2; h++) {
                int link = k->joint[i].link[h];
                if (k->joint[i].kind != LW_JOINT_REVOLUTE || k->joint[j].kind != LW_JOINT_REVOLUTE ||
                    (k->joint[j].link[0] != link && k->joint[j].link[1] != link))
                    continue;
                double want = lw_v2_norm(lw_v2_sub(k->joint[i].at, k->joint[j].at));
                CHECK_NEAR(lw_v2_norm(lw_v2_sub(now->joint[i][0], now->joint[j][0])), want, tolerance, tolerance);
            }
    for (int i = 0; i < k->n_tracer; i++)
        for (int j = 0; j < k->n_joint; j++)
            if (k->joint[j].kind == LW_JOINT_REVOLUTE &&
                (k->joint[j].link[0] == k->tracer[i].link || k->joint[j].link[1] == k->tracer[i].link)) {
                double want = lw_v2_norm(lw_v2_sub(k->tracer[i].at, k->joint[j].at));
                CHECK_NEAR(lw_v2_norm(lw_v2_sub(now->tracer[i][0], now->joint[j][0])), want, tolerance, tolerance);
            }
}

/* Does every joint of the posture of `k` hold against the one it came from?  Slides: the angle between
 * the two links stays, and so do the distances of pins from the lines. */
static void check_slides(const lw_linkage *old, const lw_linkage *now, double tolerance)
{
    for (int j = 0; j < old->n_joint; j++) {
        if (old->joint[j].kind != LW_JOINT_SLIDER)
            continue;
        for (int h = 0; h < 2; h++) {
            int link = old->joint[j].link[h];
            lw_vec2 from[3], to[3];
            int n = 0;
            for (int i = 0; i < old->n_joint && n < 2; i++)
                if (old->joint[i].kind == LW_JOINT_REVOLUTE
                    && (old->joint[i].link[0] == link || old->joint[i].link[1] == link)) {
                    from[n] = old->joint[i].at;
                    to[n++] = now->joint[i].at;
                }
            for (int i = 0; i < n; i++) {
                double was = lw_v2_cross(old->joint[j].along, lw_v2_sub(from[i], old->joint[j].at));
                double is = lw_v2_cross(now->joint[j].along, lw_v2_sub(to[i], now->joint[j].at));
                CHECK_NEAR(is, was, tolerance, 0);
            }
        }
    }
}

TEST(bars_keep_their_lengths)
{
    static subject q;
    static lw_posture posture;
    int n_checked = 0;
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 4000; trial++) {
        if (!random_subject(&r, trial, &q))
            continue;
        for (int d = 0; d < q.p.n_dyad; d++)
            q.mode[d] = lw_rng_bits(&r) & 1 ? 1 : -1;                 /* both assemblies */
        double input = q.input + lw_rng_range(&r, -1, 1);
        if (lw_posture_solve(&q.p, q.dim, q.mode, input, 0, &posture) != LW_OK || posture.margin < 1e-3)
            continue;
        lw_linkage moved = q.k;
        CHECK_INT(lw_plan_write(&q.p, q.dim, q.mode, input, &moved), LW_OK);
        check_rigid(&q, &posture, 1e-10);
        check_slides(&q.k, &moved, 1e-9);
        n_checked++;
    }
    CHECK(n_checked > 1000);
}

/* Each order is the derivative of the one before: fourth-order central differences with a step that
 * balances truncation and rounding at about 1e-12 of the scale h^-1 of the motion. */
static void check_order(const lw_posture at[5], int order, double h, double tolerance, int n_tracer, int link)
{
    const lw_posture *p = &at[2];
    for (int i = 0; i < n_tracer; i++) {
        double dx = (at[0].tracer[i][order - 1].x - at[4].tracer[i][order - 1].x) +
                    8*(at[3].tracer[i][order - 1].x - at[1].tracer[i][order - 1].x);
        double dy = (at[0].tracer[i][order - 1].y - at[4].tracer[i][order - 1].y) +
                    8*(at[3].tracer[i][order - 1].y - at[1].tracer[i][order - 1].y);
        CHECK_POINT(p->tracer[i][order], dx/(12*h), dy/(12*h), tolerance, tolerance);
    }
    double da[4] = { at[0].angle[link][order - 1] - p->angle[link][order - 1],
                     at[1].angle[link][order - 1] - p->angle[link][order - 1],
                     at[3].angle[link][order - 1] - p->angle[link][order - 1],
                     at[4].angle[link][order - 1] - p->angle[link][order - 1] };
    for (int i = 0; i < 4; i++)
        da[i] = order == 1 ? remainder(da[i], 2*LW_PI) : da[i];
    CHECK_NEAR(p->angle[link][order], (da[0] - da[3] + 8*(da[2] - da[1]))/(12*h), tolerance, tolerance);
}

TEST(orders_follow_from_each_other)
{
    static subject q;
    static lw_posture at[5];
    const double h = 1e-4;
    int n_checked = 0;
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 3000; trial++) {
        if (!random_subject(&r, trial, &q))
            continue;
        double least = 1, size = 1;
        for (int i = 0; i < 5; i++) {
            lw_posture_solve(&q.p, q.dim, q.mode, q.input + (i - 2)*h, 3, &at[i]);
            least = fmin(least, at[i].margin);
        }
        for (int o = 0; o <= 3; o++)
            for (int t = 0; t < q.k.n_tracer; t++)
                size = fmax(size, lw_v2_norm(at[2].tracer[t][o]));
        if (least < 0.1 || size > 50)
            continue;                                                 /* the difference fails first there */
        for (int order = 1; order <= 3; order++)
            check_order(at, order, h, 1e-7, q.k.n_tracer, q.k.tracer[0].link);
        n_checked++;
    }
    CHECK(n_checked > 300);
}

/* The velocities against the adjoint sweep of the batch. */
TEST(velocities_agree_with_the_batch)
{
    static subject q;
    static lw_posture posture;
    static double work[1 << 17];
    lw_rng r = check_rng(3);
    for (int trial = 0; trial < 1000; trial++) {
        random_grown(&r, 1 + trial%3, &q.k);
        plan_of(&q);
        double c = cos(q.input), s = sin(q.input), x, y, u, v, m, jac[3*LW_DIM_MAX], t[3];
        lw_lanes in = { 1, &c, &s, q.dim, 0, q.mode, 0 };
        for (int which = 0; which < q.p.n_output; which++) {
            lw_jacobian out = { &x, &y, &u, &v, &m, jac, jac + LW_DIM_MAX, jac + 2*LW_DIM_MAX, t, t + 1, t + 2, 1,
                                NULL, NULL };
            lw_batch_jacobian(&q.p, &in, which, work, &out);
            lw_posture_solve(&q.p, q.dim, q.mode, q.input, 1, &posture);
            if (posture.margin < 1e-4)
                continue;
            double size = 1e-10*(1 + fabs(t[0]) + fabs(t[1]) + fabs(t[2]))/posture.margin;
            CHECK_POINT(posture.tracer[which][1], t[0], t[1], size, 0);
            CHECK_NEAR(posture.angle[q.p.output_link[which]][1], t[2], size, 0);
            CHECK_NEAR(remainder(posture.angle[q.p.output_link[which]][0] - atan2(v, u), 2*LW_PI), 0, 1e-9, 0);
        }
    }
}

/* A slider-crank by hand: x = r cos t + sqrt(l^2 - r^2 sin^2 t). */
TEST(slider_crank_by_hand)
{
    lw_linkage k;
    lw_plan p;
    lw_posture posture;
    lw_type_linkage(lw_type_find("slidercrank"), &k);
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &p, NULL), LW_OK);
    const double dim[8] = { 1, 3, 0, 3, 0, 0, 0, 0 }, mode[1] = { 1 };
    for (int i = 0; i < 36; i++) {
        double t = i*LW_PI/18, c = cos(t), s = sin(t), w = sqrt(9 - s*s), w1 = -s*c/w, w2 = -(c*c - s*s + w1*w1)/w;
        double w3 = (4*s*c - 3*w1*w2)/w;
        CHECK_INT(lw_posture_solve(&p, dim, mode, t, 3, &posture), LW_OK);
        CHECK_NEAR(posture.joint[2][0].x, c + w, 1e-15, 1e-15);
        CHECK_NEAR(posture.joint[2][1].x, -s + w1, 1e-15, 1e-14);
        CHECK_NEAR(posture.joint[2][2].x, -c + w2, 1e-15, 1e-14);
        CHECK_NEAR(posture.joint[2][3].x, s + w3, 1e-15, 1e-14);
        CHECK_NEAR(posture.angle[1][1], 1, 1e-15, 0);
        CHECK_NEAR(posture.tracer[0][2].x, posture.joint[2][2].x, 1e-14, 0);
    }
}

TEST(limits_and_dead_points)
{
    lw_linkage k;
    lw_plan p;
    lw_posture posture;
    const double dim[9] = { 4, 3, 2, 2.5, 1, 1, 0, 0, 0 }, mode[1] = { 1 };
    lw_type_linkage(lw_type_find("fourbar"), &k);
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &p, NULL), LW_OK);
    CHECK_INT(lw_posture_solve(&p, dim, mode, 0, -1, &posture), LW_E_ARG);
    CHECK_INT(lw_posture_solve(&p, dim, mode, 0, LW_ORDER_MAX + 1, &posture), LW_E_ARG);
    double limit = acos((16 + 9 - 4.5*4.5)/24);                    /* coupler and rocker in line: 2 + 2.5 */
    CHECK_INT(lw_posture_solve(&p, dim, mode, limit + 1e-3, 3, &posture), LW_OPEN);
    CHECK(posture.margin < 0);
    for (int o = 1; o <= 3; o++)
        CHECK(posture.tracer[0][o].x == 0 && posture.tracer[0][o].y == 0 && posture.angle[2][o] == 0);
    CHECK_NEAR(lw_v2_norm(lw_v2_sub(posture.tracer[0][0], posture.joint[1][0])), sqrt(2), 1e-14, 0);
    CHECK_INT(lw_posture_solve(&p, dim, mode, limit - 1e-3, 3, &posture), LW_OK);
    CHECK(posture.margin > 0 && isfinite(posture.tracer[0][3].x));
    const double stretched[9] = { 4, 1, 2, 1, 0, 0, 0, 0, 0 };     /* all in line at 0: the margin is exactly 0 */
    CHECK_INT(lw_posture_solve(&p, stretched, mode, 0, 3, &posture), LW_OK);
    CHECK(posture.margin == 0 && posture.tracer[0][1].x == 0);
    CHECK_NEAR(posture.joint[2][0].x, 3, 1e-15, 0);
}

/* The batch: every instruction set and every grouping of lanes gives the same bits; derivatives against
 * complex steps through formulas of the test's own; hard cases; linkages with known curves. */
#include <complex.h>
#undef I
#include "mbs/batch/batch.h"
#include "mbs/batch/kernels_internal.h"
#include "mbs/batch/posture.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

#define J _Complex_I

typedef struct subject { lw_linkage k; lw_plan p; double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input; } subject;

static _Alignas(64) double work[1 << 18];

static bool plan_of(subject *q, bool all)
{
    CHECK_INT(lw_plan_make(&q->k, (lw_plan_options){ .tracers = 1, .all_joints = all }, &q->p, NULL), LW_OK);
    CHECK(lw_batch_work_size(&q->p) <= sizeof work);
    return lw_plan_read(&q->p, &q->k, q->dim, q->mode, &q->input, NULL) == LW_OK;
}

static void named(subject *q, const char *type, const double *dim, double mode)
{
    lw_type_linkage(lw_type_find(type), &q->k);
    plan_of(q, false);
    for (int d = 0; d < q->p.n_dim; d++)
        q->dim[d] = dim[d];
    q->mode[0] = mode;
}

/* Input as the lanes take it. */
static double lane_c(const subject *q, double input) { return q->p.input_is_slider ? input : cos(input); }
static double lane_s(const subject *q, double input) { return q->p.input_is_slider ? 0 : sin(input); }

static double point_at(const subject *q, const double *dim, double input, lw_vec2 *p)
{
    double c = lane_c(q, input), s = lane_s(q, input), margin;
    lw_lanes in = { 1, &c, &s, dim, 0, q->mode, 0 };
    lw_batch_point(&q->p, &in, 0, work, &p->x, &p->y, NULL, NULL, &margin);
    return margin;
}

/* ---- the same bits ---------------------------------------------------------------------------------------- */

enum { MAX = 307 };

typedef struct lanes { double c[MAX], s[MAX], dim[LW_DIM_MAX*MAX], mode[LW_MODE_MAX*MAX]; } lanes;

static void draw_lanes(lw_rng *r, const subject *q, lanes *l)
{
    for (int i = 0; i < MAX; i++) {
        double input = q->input + lw_rng_range(r, -3, 3);
        l->c[i] = lane_c(q, input);
        l->s[i] = lane_s(q, input);
        for (int d = 0; d < q->p.n_dim; d++)
            l->dim[d*MAX + i] = q->dim[d]*lw_rng_range(r, 0.8, 1.2);
        for (int d = 0; d < q->p.n_dyad; d++)
            l->mode[d*MAX + i] = lw_rng_bits(r) & 1 ? 1 : -1;
    }
}

typedef struct outputs { double x[MAX], y[MAX], u[MAX], v[MAX], m[MAX], o[4][MAX], jac[3*LW_DIM_MAX*MAX], t[3][MAX],
                         grad[LW_DIM_MAX], f, least; } outputs;

static void run_lanes(const subject *q, const lanes *l, size_t n, int per_lane, outputs *out)
{
    static double tx[MAX], ty[MAX], w[MAX];
    size_t size = (size_t)q->p.n_dim*MAX;
    lw_lanes in = { n, l->c, l->s, per_lane ? l->dim : q->dim, per_lane & 1 ? MAX : 0,
                    per_lane & 2 ? l->mode : q->mode, per_lane & 2 ? MAX : 0 };
    if (per_lane == 2)
        in.dim = q->dim;
    memset(out, 0, sizeof *out);
    lw_batch_point(&q->p, &in, 0, work, out->x, out->y, out->u, out->v, out->m);
    lw_batch_frame(&q->p, &in, 0, work, out->o[0], out->o[1], out->o[2], out->o[3], NULL);
    if (per_lane)
        return;
    for (size_t i = 0; i < n; i++) {
        tx[i] = 1 + 0.1*(double)i;
        ty[i] = 2 - 0.1*(double)i;
        w[i] = 1 + (double)(i%3);
    }
    lw_jacobian j = { out->x, out->y, out->u, out->v, out->m, out->jac, out->jac + size, out->jac + 2*size,
                      out->t[0], out->t[1], out->t[2], MAX, NULL, NULL };
    lw_batch_jacobian(&q->p, &in, 0, work, &j);
    out->f = lw_batch_sum(&q->p, &in, 0, work, tx, ty, w, out->grad, &out->least);
}

TEST(same_bits_on_every_instruction_set)
{
    static subject q;
    static lanes l;
    static outputs a, b;
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 60; trial++) {
        if (trial < 44)
            random_type(&r, &lw_type_table[trial%11], &q.k);
        else
            random_grown(&r, 3, &q.k);
        plan_of(&q, false);
        draw_lanes(&r, &q, &l);
        for (int per_lane = 0; per_lane < 4; per_lane++) {
            q.p.kernels = lw_kernels_supported(0);
            run_lanes(&q, &l, MAX - (size_t)trial%9, per_lane, &a);
            for (int i = 1; lw_kernels_supported(i); i++) {
                q.p.kernels = lw_kernels_supported(i);
                run_lanes(&q, &l, MAX - (size_t)trial%9, per_lane, &b);
                CHECK(memcmp(&a, &b, sizeof a) == 0);
            }
        }
    }
}

/* Pins and the least margin of the whole plan: values against single postures, derivatives against their differences.
 * Returns how many numbers were compared; a margin that changes its dyad within the difference is left out. */
static int check_pins(const subject *q, double input)
{
    enum { N = LW_DIM_MAX };
    const double h = 1e-6;
    static lw_posture now, posture[2];
    double x, y, m, jx[N], jy[N], jm[N], tx, ty, tm, c = lane_c(q, input), s = lane_s(q, input);
    int n = 0;
    lw_lanes in = { 1, &c, &s, q->dim, 0, q->mode, 0 };
    if (lw_posture_solve(&q->p, q->dim, q->mode, input, 1, &now) != LW_OK || now.margin < 0.05)
        return 0;
    for (int j = 0; j < LW_JOINT_MAX; j++) {
        if (q->p.joint_point[j] < 0)
            continue;
        lw_jacobian out = { .x = &x, .y = &y, .margin = &m, .jx = jx, .jy = jy, .tx = &tx, .ty = &ty, .ld = 1, .jm = jm,
                            .tm = &tm };
        lw_batch_jacobian(&q->p, &in, LW_BATCH_JOINT(j), work, &out);
        CHECK_NEAR(x, now.joint[j][0].x, 1e-11, 1e-11);
        CHECK_NEAR(y, now.joint[j][0].y, 1e-11, 1e-11);
        CHECK_NEAR(m, now.margin, 1e-11, 0);
        for (int d = 0; d <= q->p.n_dim; d++) {
            double dim[N], by[3], size;
            for (int side = 0; side < 2; side++) {
                memcpy(dim, q->dim, sizeof dim);
                dim[d < q->p.n_dim ? d : 0] += d < q->p.n_dim ? (side ? h : -h) : 0;
                lw_posture_solve(&q->p, dim, q->mode, input + (d < q->p.n_dim ? 0 : side ? h : -h), 0, &posture[side]);
            }
            by[0] = (posture[1].joint[j][0].x - posture[0].joint[j][0].x)/(2*h);
            by[1] = (posture[1].joint[j][0].y - posture[0].joint[j][0].y)/(2*h);
            by[2] = (posture[1].margin - posture[0].margin)/(2*h);
            size = 1 + fabs(by[0]) + fabs(by[1]) + fabs(by[2]);
            if (size > 30)
                continue;
            CHECK_NEAR(d < q->p.n_dim ? jx[d] : tx, by[0], 1e-6*size, 0);
            CHECK_NEAR(d < q->p.n_dim ? jy[d] : ty, by[1], 1e-6*size, 0);
            if (fabs(posture[1].margin + posture[0].margin - 2*now.margin) < 1e-9)
                CHECK_NEAR(d < q->p.n_dim ? jm[d] : tm, by[2], 1e-6*size, 0);
            n++;
        }
    }
    return n;
}

TEST(pins_and_margins_have_derivatives)
{
    static subject q;
    int n = 0;
    lw_rng r = check_rng(9);
    for (const lw_type *t = lw_type_table; t->letters; t++)
        for (int trial = 0; trial < 20; trial++) {
            random_type(&r, t, &q.k);
            if (plan_of(&q, true))
                n += check_pins(&q, q.input + lw_rng_range(&r, -0.1, 0.1));
        }
    for (int trial = 0; trial < 100; trial++) {
        random_grown(&r, 1 + trial%3, &q.k);
        plan_of(&q, true);
        n += check_pins(&q, q.input);
    }
    CHECK(n > 10000);
}

/* One lane alone, or with a few, gives what it gives among many; dimensions shared or a set a lane. */
TEST(same_bits_in_every_company)
{
    static subject q;
    static lanes l;
    static outputs all, few;
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 33; trial++) {
        if (trial < 22)
            random_type(&r, &lw_type_table[trial%11], &q.k);
        else
            random_grown(&r, 2, &q.k);
        plan_of(&q, false);
        draw_lanes(&r, &q, &l);
        for (int per_lane = 0; per_lane < 4; per_lane++) {
            run_lanes(&q, &l, MAX, per_lane, &all);
            static const size_t some[] = { 1, 2, 7, 8, 9, 15, 18, 60, 130 };
            for (size_t i = 0; i < sizeof some/sizeof *some; i++) {
                size_t n = some[i], bytes = n*sizeof(double);
                run_lanes(&q, &l, n, per_lane, &few);
                CHECK(memcmp(few.x, all.x, bytes) == 0 && memcmp(few.y, all.y, bytes) == 0);
                CHECK(memcmp(few.u, all.u, bytes) == 0 && memcmp(few.v, all.v, bytes) == 0);
                CHECK(memcmp(few.m, all.m, bytes) == 0 && memcmp(few.o[2], all.o[2], bytes) == 0);
                CHECK(few.x[n] == 0 && few.m[n] == 0 && few.o[0][n] == 0);        /* nothing past the end */
                for (int row = 0; !per_lane && row < 3*q.p.n_dim; row++) {
                    CHECK(memcmp(few.jac + row*MAX, all.jac + row*MAX, bytes) == 0);
                    CHECK(few.jac[row*MAX + (int)n] == 0);
                }
            }
        }
        for (int d = 0; d < q.p.n_dim; d++)
            for (int i = 0; i < MAX; i++)
                l.dim[d*MAX + i] = q.dim[d];
        run_lanes(&q, &l, MAX, 0, &all);
        run_lanes(&q, &l, MAX, 1, &few);
        CHECK(memcmp(all.x, few.x, sizeof all.x) == 0 && memcmp(all.y, few.y, sizeof all.y) == 0);
    }
}

/* Places of all pins and of the point at once are those of one after the other. */
TEST(places_at_once_are_those_of_each)
{
    static subject q;
    static lanes l;
    static double x[LW_JOINT_MAX + 1][MAX], y[LW_JOINT_MAX + 1][MAX], m[MAX], one[3][MAX];
    static const size_t some[] = { 3, 8, 25, 130, 139, MAX };
    lw_rng r = check_rng(12);
    for (int trial = 0; trial < 33; trial++) {
        int which[LW_JOINT_MAX + 1], n = 0;
        lw_jacobian all[LW_JOINT_MAX + 1];
        random_grown(&r, 1 + trial%3, &q.k);
        plan_of(&q, true);
        draw_lanes(&r, &q, &l);
        for (int j = 0; j < LW_JOINT_MAX; j++)
            if (q.p.joint_point[j] >= 0)
                which[n++] = LW_BATCH_JOINT(j);
        which[n++] = 0;
        for (size_t i = 0; i < sizeof some/sizeof *some; i++) {
            lw_lanes in = { .n = some[i], .c = l.c, .s = l.s, .dim = q.dim, .mode = q.mode };
            for (int k = 0; k < n; k++)
                all[k] = (lw_jacobian){ .x = x[k], .y = y[k], .margin = k == 0 ? m : NULL, .ld = MAX };
            lw_batch_jacobians(&q.p, &in, n, which, work, all);
            for (int k = 0; k < n; k++) {
                lw_batch_jacobian(&q.p, &in, which[k], work,
                                  &(lw_jacobian){ .x = one[0], .y = one[1], .margin = one[2], .ld = MAX });
                CHECK(memcmp(x[k], one[0], some[i]*sizeof **one) == 0 && memcmp(y[k], one[1], some[i]*sizeof **one) == 0);
                CHECK(k > 0 || memcmp(m, one[2], some[i]*sizeof **one) == 0);
            }
        }
    }
}

/* Tangents alone have the bits that they have beside a Jacobian. */
TEST(tangents_alone_are_those_of_the_jacobian)
{
    static subject q;
    static lanes l;
    static double jac[2][LW_DIM_MAX*MAX], of[2][4][MAX];
    static const size_t some[] = { 1, 7, 8, 25, 130, MAX };
    lw_rng r = check_rng(14);
    for (int trial = 0; trial < 44; trial++) {
        if (trial < 22)
            random_type(&r, &lw_type_table[trial%11], &q.k);
        else
            random_grown(&r, 1 + trial%3, &q.k);
        plan_of(&q, true);
        draw_lanes(&r, &q, &l);
        for (size_t i = 0; i < sizeof some/sizeof *some; i++)
            for (int pin = 0; pin < 2; pin++) {
                lw_lanes in = { .n = some[i], .c = l.c, .s = l.s, .dim = q.dim, .mode = q.mode };
                int which = 0;
                for (int j = 0; j < LW_JOINT_MAX && pin; j++)
                    which = q.p.joint_point[j] >= 0 ? LW_BATCH_JOINT(j) : which;
                for (int with = 0; with < 2; with++)
                    lw_batch_jacobian(&q.p, &in, which, work, &(lw_jacobian){
                        .x = of[with][0], .y = of[with][1], .tx = of[with][2], .ty = of[with][3], .ld = MAX,
                        .jx = with ? jac[0] : NULL, .jy = with ? jac[1] : NULL });
                for (int k = 0; k < 4; k++)
                    CHECK(memcmp(of[0][k], of[1][k], some[i]*sizeof(double)) == 0);
            }
    }
}

TEST(turns_are_cosines_and_sines)
{
    static subject q;
    double angle[24], c[24], s[24];
    lw_rng r = check_rng(13);
    lw_type_linkage(lw_type_find("fourbar"), &q.k);
    plan_of(&q, false);
    for (int i = 0; i < 24; i++)
        angle[i] = i < 20 ? lw_rng_range(&r, -30, 30) : ldexp(lw_rng_range(&r, -1, 1), 9*(i - 18));
    lw_batch_turns(&q.p, 21, angle, c, s);
    for (int i = 0; i < 21; i++) {
        CHECK_NEAR(c[i], cos(angle[i]), 5e-16, 0);
        CHECK_NEAR(s[i], sin(angle[i]), 5e-16, 0);
    }
}

/* The nearest point of a side by the distances to its ends and to the foot between them. */
static lw_vec2 foot_on_side(lw_vec2 a, lw_vec2 b, lw_vec2 at)
{
    lw_vec2 side = lw_v2_sub(b, a), off = lw_v2_sub(at, a);
    double along = lw_v2_dot(off, side), all = lw_v2_dot(side, side);
    return !(along > 0) ? a : along >= all ? b : lw_v2_add(a, lw_v2_scale(side, along/all));
}

TEST(nearest_points_of_polylines)
{
    enum { POINTS = 16, CORNERS = 9 };
    subject q;
    double x[POINTS], y[POINTS], corner_x[CORNERS], corner_y[CORNERS], first[2*POINTS], near[2*POINTS];
    lw_rng r = check_rng(16);
    named(&q, "fourbar", (double[]){ 3, 1, 2.5, 2.5, 1, 1, 0, 0, 0 }, 1);
    for (int trial = 0; trial < 200; trial++) {
        lw_polyline line = { 1 + (size_t)trial%CORNERS, corner_x, corner_y, trial & 1 };
        for (int i = 0; i < CORNERS; i++) {
            corner_x[i] = i == 3 && trial%5 == 0 ? corner_x[2] : lw_rng_normal(&r);      /* a side of length 0 */
            corner_y[i] = i == 3 && trial%5 == 0 ? corner_y[2] : lw_rng_normal(&r);
        }
        for (int i = 0; i < POINTS; i++) {
            x[i] = 2*lw_rng_normal(&r);
            y[i] = 2*lw_rng_normal(&r);
        }
        for (int isa = 0; lw_kernels_supported(isa); isa++) {
            q.p.kernels = lw_kernels_supported(isa);
            lw_batch_nearest(&q.p, &line, POINTS, x, y, near, near + POINTS);
            if (isa == 0)
                memcpy(first, near, sizeof near);
            CHECK(memcmp(first, near, sizeof near) == 0);
        }
        for (int i = 0; i < POINTS; i++) {
            lw_vec2 at = lw_v2(x[i], y[i]), found = lw_v2(near[i], near[POINTS + i]), best = lw_v2(corner_x[0], corner_y[0]);
            for (size_t k = line.closed ? 0 : 1, from = line.closed ? line.n - 1 : 0; k < line.n; from = k++) {
                lw_vec2 foot = foot_on_side(lw_v2(corner_x[from], corner_y[from]), lw_v2(corner_x[k], corner_y[k]), at);
                best = hypot(foot.x - at.x, foot.y - at.y) < hypot(best.x - at.x, best.y - at.y) ? foot : best;
            }
            CHECK_POINT(found, best.x, best.y, 1e-12, 0);
        }
    }
}

/* The same bits on every instruction set; test_timing.c holds costs and assignments against all there are. */
TEST(points_assigned_to_samples)
{
    enum { N = 5, M = 16, ROW = M + 8 };
    subject q;
    double at[6][M], cost[2][N*ROW] = { { 0 } }, least[2][N*ROW] = { { 0 } }, *point = at[5];
    const double weight[N] = { 1, 2, 0.5, 3, 1 };
    const lw_samples of = { M, at[0], at[1], at[2], at[3], at[4], 0.5 };
    lw_rng r = check_rng(17);
    named(&q, "fourbar", (double[]){ 3, 1, 2.5, 2.5, 1, 1, 0, 0, 0 }, 1);
    for (int trial = 0; trial < 40; trial++) {
        size_t first = lw_rng_bits(&r) % M;
        for (int k = 0; k < 6*M; k++)
            at[k/M][k % M] = lw_rng_normal(&r);
        for (int isa = 0; lw_kernels_supported(isa); isa++) {
            double *c = cost[isa > 0];
            q.p.kernels = lw_kernels_supported(isa);
            lw_batch_costs(&q.p, &of, N, point, point + N, weight, 0.3, c);
            for (int i = 0; i < N; i++)
                memcpy(c + i*ROW + M, c + i*ROW, 8*sizeof *c);
            double all = lw_batch_in_order(&q.p, N, M, c, first, trial & 1 ? 1 : -1, INFINITY, least[isa > 0]);
            CHECK(all > c[first]);
            CHECK(isa == 0 || (memcmp(cost[0], cost[1], sizeof cost[0]) == 0 && memcmp(least[0], least[1], sizeof least[0]) == 0));
        }
    }
}

TEST(no_lanes_no_work)
{
    static subject q;
    static lanes l;
    static outputs o, clean;
    lw_type_linkage(lw_type_find("fourbar"), &q.k);
    plan_of(&q, false);
    for (int per_lane = 0; per_lane < 4; per_lane++) {
        run_lanes(&q, &l, 0, per_lane, &o);
        clean.least = o.least;
        CHECK(memcmp(&o, &clean, sizeof o) == 0);
    }
}

/* ---- derivatives by complex steps --------------------------------------------------------------------------
 * The steps of the plan with complex dimensions (Squire & Trapp 1998: f'(x) = Im f(x + ih)/h, no
 * cancellation), from textbook formulas: law of cosines, Pythagoras, Cramer. */
typedef struct cpoint { double complex x, y; } cpoint;

static cpoint cadd(cpoint a, cpoint b) { return (cpoint){ a.x + b.x, a.y + b.y }; }
static cpoint csub(cpoint a, cpoint b) { return (cpoint){ a.x - b.x, a.y - b.y }; }
static cpoint cturn(cpoint a, cpoint u) { return (cpoint){ a.x*u.x - a.y*u.y, a.x*u.y + a.y*u.x }; }
static cpoint cscale(cpoint a, double complex s) { return (cpoint){ a.x*s, a.y*s }; }
static double complex cdot(cpoint a, cpoint b) { return a.x*b.x + a.y*b.y; }
static cpoint cdirection(double complex t) { return (cpoint){ ccos(t), csin(t) }; }

static void complex_dyad(const lw_step *s, const double complex *dim, double mode, cpoint *reg)
{
    const int *in = s->in, *out = s->out;
    cpoint d = csub(reg[in[1]], reg[in[0]]);
    double complex length = csqrt(cdot(d, d));
    if (s->kind == LW_STEP_RRR) {                             /* the angle at the pin of the shorter link */
        double complex a = dim[s->dim[0]], b = dim[s->dim[1]];
        bool second = cabs(b) < cabs(a);
        double complex r = second ? b : a, other = second ? a : b;
        double complex cosine = (length*length + r*r - other*other)/(2*length*r), sine = mode*csqrt(1 - cosine*cosine);
        cpoint u = cscale(cturn(d, (cpoint){ second ? -cosine : cosine, sine }), 1/length);
        reg[out[2]] = cadd(reg[in[second]], cscale(u, r));
        reg[out[0]] = second ? cscale(csub(reg[out[2]], reg[in[0]]), 1/a) : u;
        if (out[1] >= 0)
            reg[out[1]] = second ? u : cscale(csub(reg[out[2]], reg[in[1]]), 1/b);
    } else if (s->kind == LW_STEP_RRP) {                      /* along the line from the foot */
        double complex a = dim[s->dim[0]];
        cpoint w = reg[in[2]], foot = cadd(reg[in[1]], cscale(w, -cdot(d, w)));
        cpoint up = csub(foot, reg[in[0]]);
        reg[out[1]] = cadd(foot, cscale(w, mode*csqrt(a*a - cdot(up, up))));
        reg[out[0]] = cscale(csub(reg[out[1]], reg[in[0]]), 1/a);
    } else if (s->kind == LW_STEP_RPR) {                      /* the angle between span and slide */
        double complex sine = dim[s->dim[0]]/length, cosine = mode*csqrt(1 - sine*sine);
        reg[out[0]] = cscale(cturn(d, (cpoint){ cosine, -sine }), 1/length);
    } else {
        cpoint u = reg[in[1]], w = reg[in[3]], e = csub(reg[in[2]], reg[in[0]]);
        double complex t = (e.x*w.y - e.y*w.x)/(u.x*w.y - u.y*w.x);
        reg[out[0]] = cadd(reg[in[0]], cscale(u, t));
    }
}

/* Tracer in the plane and direction of its link. */
static void complex_output(const subject *q, const double complex *dim, double complex input, cpoint out[2])
{
    const lw_plan *p = &q->p;
    cpoint reg[LW_REG_MAX] = { { 0, 0 }, { 1, 0 } };
    for (int i = 0; i < p->n_step; i++) {
        const lw_step *s = &p->step[i];
        double complex a = s->dim[0] < 0 ? 0 : dim[s->dim[0]], b = s->dim[1] < 0 ? 0 : dim[s->dim[1]];
        switch (s->kind) {
        case LW_STEP_INPUT_PIN:   reg[s->out[0]] = cdirection(input); break;
        case LW_STEP_INPUT_SLIDE: reg[s->out[0]] = cadd(reg[s->in[0]], cscale(reg[s->in[1]], input)); break;
        case LW_STEP_POINT:       reg[s->out[0]] = cadd(reg[s->in[0]], cturn((cpoint){ a, b }, reg[s->in[1]])); break;
        case LW_STEP_LINE:
            reg[s->out[1]] = cturn(cdirection(b), reg[s->in[1]]);
            reg[s->out[0]] = cadd(reg[s->in[0]], cturn((cpoint){ 0, a }, reg[s->out[1]]));
            break;
        default: complex_dyad(s, dim, q->mode[s->dyad], reg);
        }
    }
    cpoint turn = cdirection(dim[p->i_theta0]);
    out[0] = cadd((cpoint){ dim[p->i_x0], dim[p->i_y0] }, cturn(reg[p->output_point[0]], turn));
    out[1] = cturn(reg[p->output_dir[0]], turn);
}

static void check_derivatives(const subject *q, double input)
{
    enum { N = LW_DIM_MAX };
    const double h = 1e-150;
    double x, y, u, v, m, jx[N], jy[N], jt[N], tx, ty, tt, c = lane_c(q, input), s = lane_s(q, input);
    lw_lanes in = { 1, &c, &s, q->dim, 0, q->mode, 0 };
    lw_jacobian out = { &x, &y, &u, &v, &m, jx, jy, jt, &tx, &ty, &tt, 1, NULL, NULL };
    lw_batch_jacobian(&q->p, &in, 0, work, &out);
    if (m < (q->p.n_dyad > 1 ? 0.05 : 0.01))       /* a chain of dyads multiplies errors by each 1/sine */
        return;
    double stiff = 100 + fabs(tx) + fabs(ty) + fabs(tt);      /* beyond 100, curvature decides the error */
    for (int d = 0; d < q->p.n_dim; d++)
        stiff = fmax(stiff, fabs(jx[d]) + fabs(jy[d]) + fabs(jt[d]));
    for (int d = 0; d <= q->p.n_dim; d++) {
        double complex dim[N];
        cpoint z[2];
        bool by_input = d == q->p.n_dim;
        for (int i = 0; i < q->p.n_dim; i++)
            dim[i] = q->dim[i] + (i == d ? h : 0)*J;
        complex_output(q, dim, input + (by_input ? h : 0)*J, z);
        double wx = cimag(z[0].x)/h, wy = cimag(z[0].y)/h;
        double wt = (creal(z[1].x)*cimag(z[1].y) - creal(z[1].y)*cimag(z[1].x))/h;
        double size = (fabs(wx) + fabs(wy) + fabs(wt) + 1)*stiff/100;       /* relative to the whole row */
        CHECK_NEAR(by_input ? tx : jx[d], wx, 1e-12*size/m, 0);
        CHECK_NEAR(by_input ? ty : jy[d], wy, 1e-12*size/m, 0);
        CHECK_NEAR(by_input ? tt : jt[d], wt, 1e-12*size/m, 0);
        if (by_input) {
            CHECK_NEAR(x, creal(z[0].x), 1e-13*size/m, 1e-13/m);    /* size: how errors of the crank spread */
            CHECK_NEAR(y, creal(z[0].y), 1e-13*size/m, 1e-13/m);
            CHECK_NEAR(u, creal(z[1].x), 1e-13*size/m, 0);
            CHECK_NEAR(v, creal(z[1].y), 1e-13*size/m, 0);
        }
    }
}

TEST(jacobian_agrees_with_complex_steps)
{
    static subject q;
    lw_rng r = check_rng(3);
    for (const lw_type *t = lw_type_table; t->letters; t++)
        for (int trial = 0; trial < 200; trial++) {
            random_type(&r, t, &q.k);
            if (plan_of(&q, false))
                check_derivatives(&q, q.input + lw_rng_range(&r, -0.1, 0.1));
        }
    for (int trial = 0; trial < 500; trial++) {
        random_grown(&r, 1 + trial%3, &q.k);
        plan_of(&q, false);
        check_derivatives(&q, q.input);
    }
}

/* The tracer on the rocker, the crank, the ground: other parts of the plan. */
TEST(jacobian_of_every_link)
{
    static subject q;
    lw_rng r = check_rng(4);
    for (const lw_type *t = lw_type_table; t->letters; t++)
        for (int trial = 0; trial < 100; trial++) {
            random_type(&r, t, &q.k);
            q.k.tracer[0].link = trial%4;
            if (plan_of(&q, trial & 4))
                check_derivatives(&q, q.input);
        }
    jansen_linkage(&q.k);
    plan_of(&q, false);
    check_derivatives(&q, q.input);
}

/* The fused sum against the points and the Jacobian. */
TEST(sum_agrees_with_its_parts)
{
    static subject q;
    static lanes l;
    static outputs o;
    lw_rng r = check_rng(5);
    for (int trial = 0; trial < 44; trial++) {
        random_type(&r, &lw_type_table[trial%11], &q.k);
        if (trial >= 33)
            random_grown(&r, 2, &q.k);
        plan_of(&q, false);
        draw_lanes(&r, &q, &l);
        for (int i = 0; i < MAX; i++) {
            double input = q.input + 0.05*sin(i);
            l.c[i] = lane_c(&q, input);
            l.s[i] = lane_s(&q, input);
        }
        size_t n = trial%2 ? MAX : (size_t)trial + 1;
        run_lanes(&q, &l, n, 0, &o);
        double f = 0, g[LW_DIM_MAX] = { 0 }, size[LW_DIM_MAX] = { 0 }, least = 1;
        for (size_t i = 0; i < n; i++) {
            double ex = o.x[i] - (1 + 0.1*(double)i), ey = o.y[i] - (2 - 0.1*(double)i), w = 1 + (double)(i%3);
            f += w*(ex*ex + ey*ey);
            least = fmin(least, o.m[i]);
            for (int d = 0; d < q.p.n_dim; d++) {
                double t = 2*w*(ex*o.jac[d*MAX + (int)i] + ey*o.jac[(q.p.n_dim + d)*MAX + (int)i]);
                g[d] += t;
                size[d] += fabs(t);
            }
        }
        CHECK_NEAR(o.f, f, 0, 1e-13);
        CHECK(o.least == least);
        for (int d = 0; d < q.p.n_dim; d++)
            CHECK_NEAR(o.grad[d], g[d], 1e-12*size[d]/fmax(least, 1e-3), 0);
    }
}

/* ---- symmetry ------------------------------------------------------------------------------------------------ */

/* Size s, turn a, shift, and mirror image of the whole: lengths, coordinates and angles by their kind. */
TEST(whole_can_be_moved)
{
    static subject q, m;
    lw_rng r = check_rng(6);
    for (int trial = 0; trial < 1000; trial++) {
        random_grown(&r, 1 + trial%2, &q.k);
        plan_of(&q, false);
        m = q;
        double s = exp(lw_rng_range(&r, -3, 3)), a = lw_rng_range(&r, -3, 3), mirror = trial & 1 ? -1 : 1;
        lw_vec2 p, w, shift = random_place(&r), z0 = lw_v2(q.dim[q.p.i_x0], mirror*q.dim[q.p.i_y0]);
        for (int d = 0; d < q.p.n_dim; d++) {
            lw_dim_role role = q.p.dim[d].role;
            bool odd = role == LW_ROLE_Y || role == LW_ROLE_E || role == LW_ROLE_BETA || role == LW_ROLE_CY ||
                       role == LW_ROLE_THETA0;
            m.dim[d] *= (odd ? mirror : 1)*(q.p.dim[d].kind == LW_DIM_ANGLE ? 1 : s);
        }
        z0 = lw_v2_add(shift, lw_v2_scale(lw_v2_turn(z0, lw_v2_polar(1, a)), s));
        m.dim[m.p.i_x0] = z0.x;
        m.dim[m.p.i_y0] = z0.y;
        m.dim[m.p.i_theta0] += a;
        for (int i = 0; i < q.p.n_step; i++)
            if (q.p.step[i].kind == LW_STEP_RRR)
                m.mode[q.p.step[i].dyad] *= mirror;
        double margin = point_at(&q, q.dim, q.input, &p);
        CHECK_NEAR(point_at(&m, m.dim, mirror*q.input, &w), margin, 1e-12, 1e-10);
        p = lw_v2_add(shift, lw_v2_scale(lw_v2_turn(lw_v2(p.x, mirror*p.y), lw_v2_polar(1, a)), s));
        double size = (lw_v2_norm(p) + s + lw_v2_norm(shift))/fmax(margin, 1e-12);
        CHECK_POINT(w, p.x, p.y, 1e-10*size, 0);
    }
}

TEST(batch_agrees_with_posture)
{
    static subject q;
    lw_rng r = check_rng(7);
    for (int trial = 0; trial < 1000; trial++) {
        random_grown(&r, 1 + trial%3, &q.k);
        plan_of(&q, false);
        lw_posture posture;
        lw_vec2 p;
        double input = q.input + lw_rng_range(&r, -1, 1), margin = point_at(&q, q.dim, input, &p);
        lw_status s = lw_posture_solve(&q.p, q.dim, q.mode, input, 0, &posture);
        double size = 1 + lw_v2_norm(p);
        CHECK_NEAR(margin, posture.margin, 1e-9, 1e-9);
        CHECK_INT(s, posture.margin < 0 ? LW_OPEN : LW_OK);
        if (posture.margin > 1e-6)
            CHECK_POINT(p, posture.tracer[0][0].x, posture.tracer[0][0].y, 1e-9*size, 0);
    }
}

/* ---- hard cases ------------------------------------------------------------------------------------------------ */

static void check_everywhere_finite(const subject *q)
{
    enum { N = 721 };
    static double c[N], s[N], x[N], y[N], u[N], v[N], m[N], jac[3*9*N], t[3*N], grad[LW_DIM_MAX];
    for (int i = 0; i < N; i++) {
        c[i] = cos(LW_PI*(i - 360)/360);
        s[i] = i == 360 ? 0 : sin(LW_PI*(i - 360)/360);
    }
    lw_lanes in = { N, c, s, q->dim, 0, q->mode, 0 };
    lw_jacobian out = { x, y, u, v, m, jac, jac + q->p.n_dim*N, jac + 2*q->p.n_dim*N, t, t + N, t + 2*N, N, NULL, NULL };
    lw_batch_jacobian(&q->p, &in, 0, work, &out);
    double least, f = lw_batch_sum(&q->p, &in, 0, work, c, s, NULL, grad, &least), size = 0;
    for (int d = 0; d < q->p.n_dim; d++)
        size += fabs(q->dim[d]);
    for (int i = 0; i < N; i++) {
        CHECK(isfinite(m[i]) && m[i] <= 1 + 1e-9);               /* links up to 1e6 apart: 1e6 roundings */
        CHECK(fabs(x[i]) <= 2*size && fabs(y[i]) <= 2*size);
        CHECK_NEAR(u[i]*u[i] + v[i]*v[i], 1, 1e-9, 0);
        for (int d = 0; d < 3*q->p.n_dim; d++)
            CHECK(isfinite(jac[d*N + i]));
        CHECK(isfinite(t[i]) && isfinite(t[N + i]) && isfinite(t[2*N + i]));
    }
    CHECK(isfinite(f) && least >= -1e30);
    for (int d = 0; d < q->p.n_dim; d++)
        CHECK(isfinite(grad[d]));
}

/* Ground, crank, coupler, rocker; also as an inverted slider-crank without offset and a slider-crank whose
 * crank and coupler are equal, where all positions meet. */
TEST(change_points_give_numbers)
{
    static const double lengths[][4] = { { 4, 1, 4, 1 }, { 1, 4, 1, 4 }, { 3, 1, 1, 3 }, { 1, 1, 3, 3 }, { 1, 1, 1, 1 },
                                         { 4, 1, 3, 2 }, { 2, 1, 3, 4 }, { 5, 1, 2, 2 }, { 1, 1, 1e-6, 1 } };
    static subject q;
    for (size_t i = 0; i < sizeof lengths/sizeof *lengths; i++)
        for (int sign = -1; sign <= 1; sign += 2)
            for (int e = -16; e <= -3; e++) {
                double eps = e == -16 ? 0 : pow(10, e);
                double dim[9] = { lengths[i][0], lengths[i][1], lengths[i][2]*(1 + eps), lengths[i][3], 0.5, 0.25, 0, 0,
                                  0 };
                named(&q, "fourbar", dim, sign);
                check_everywhere_finite(&q);
            }
    for (int sign = -1; sign <= 1; sign += 2)
        for (int e = -16; e <= -3; e++) {
            double eps = e == -16 ? 0 : pow(10, e);
            named(&q, "slidercrank", (double[8]){ 1, 1 + eps, 0, 2, 0, 0, 0, 0 }, sign);
            check_everywhere_finite(&q);
            named(&q, "inverted", (double[8]){ 1, 1 + eps, 0, 2, 0, 0, 0, 0 }, sign);
            check_everywhere_finite(&q);
            named(&q, "inverted", (double[8]){ 1, 1 + eps, eps, 2, 0, 0, 0, 0 }, sign);
            check_everywhere_finite(&q);
        }
}

/* Centres that coincide leave the dyad free to turn: margin at most 0. */
TEST(coinciding_centres_are_reported)
{
    static subject q;
    lw_vec2 p;
    named(&q, "fourbar", (double[9]){ 1, 1, 2, 2, 0.5, 0.25, 0, 0, 0 }, 1);
    CHECK(point_at(&q, q.dim, 0, &p) <= 0);
    CHECK_NEAR(hypot(p.x - 1, p.y), hypot(0.5, 0.25), 1e-15, 0);
    named(&q, "fourbar", (double[9]){ 1, 1, 2, 3, 0.5, 0.25, 0, 0, 0 }, 1);
    CHECK(point_at(&q, q.dim, 0, &p) < 0);
    named(&q, "inverted", (double[8]){ 1, 1, 0, 0.5, 0.25, 0, 0, 0 }, 1);
    CHECK(point_at(&q, q.dim, 0, &p) <= 0);
    named(&q, "RPRP", (double[7]){ 0, 1, 0, 0, 0, 0, 0 }, 1);
    CHECK(point_at(&q, q.dim, 0, &p) <= 0);                           /* parallel slides */
}

/* Near the change point 4 1 4(1+eps) 1 the margin is that of the exact formula: at the crank angle 0,
 * sin^2 = h/(2 r3 r4)^2 with h from the lengths. */
TEST(margins_near_change_points_are_right)
{
    static subject q;
    lw_vec2 p;
    for (int e = -15; e <= -3; e++) {
        double eps = pow(10, e), r3 = 4*(1 + eps), gain = r3 - 4;       /* the coupler as rounded */
        named(&q, "fourbar", (double[9]){ 4, 1, r3, 1, 0, 0, 0, 0, 0 }, 1);
        double h = (r3 + 1 + 3)*(r3 + 1 - 3)*(3 + r3 - 1)*(3 - r3 + 1);
        double want = h/(4*r3*r3);
        CHECK_NEAR(point_at(&q, q.dim, 0, &p), want, 1e-15, 1e-9);
        CHECK(want < 0 || gain == 0);
    }
}

/* A coupler of no length points anywhere: numbers all the same. */
TEST(lengths_of_zero)
{
    static subject q;
    for (int i = 0; i < 16; i++) {
        double dim[9] = { i & 1, (i & 2)/2, (i & 4)/4, (i & 8)/8, 0.5, 0.25, 0, 0, 0 }, x, y, m, jac[18];
        named(&q, "fourbar", dim, 1);
        for (int k = 0; k < 64; k++) {
            double c = cos(LW_PI*k/32), s = sin(LW_PI*k/32);
            lw_lanes in = { 1, &c, &s, q.dim, 0, q.mode, 0 };
            lw_jacobian out = { .x = &x, .y = &y, .margin = &m, .jx = jac, .jy = jac + 9, .ld = 1 };
            lw_batch_jacobian(&q.p, &in, 0, work, &out);
            CHECK(isfinite(x) && isfinite(y) && isfinite(m));
            for (int d = 0; d < 18; d++)
                CHECK(isfinite(jac[d]));
        }
    }
}

TEST(lengths_a_million_apart)
{
    static subject q;
    static const double lengths[][4] = { { 1e6, 1, 1e6, 1 }, { 1e6, 1, 1e6, 2 }, { 1, 1e6, 1e6, 1.5 },
                                         { 1e6, 1.5, 1, 1e6 },
                                         { 3, 1, 1e6, 1e6 }, { 1e6, 1e6, 1, 1.25 } };
    lw_rng r = check_rng(8);
    for (size_t i = 0; i < sizeof lengths/sizeof *lengths; i++)
        for (int trial = 0; trial < 300; trial++) {
            double dim[9] = { lengths[i][0], lengths[i][1], lengths[i][2], lengths[i][3], lengths[i][2], 0, 0, 0, 0 };
            double input = lw_rng_range(&r, -LW_PI, LW_PI);
            lw_vec2 b;
            named(&q, "fourbar", dim, trial & 1 ? 1 : -1);
            check_everywhere_finite(&q);
            if (point_at(&q, q.dim, input, &b) <= 1e-6)
                continue;
            CHECK_NEAR(hypot(b.x - dim[1]*cos(input), b.y - dim[1]*sin(input)), dim[2], 1e-9, 0);
            CHECK_NEAR(hypot(b.x - dim[0], b.y), dim[3], 1e-9, 0);            /* rounding of 1e6 */
        }
}

/* A tracer on a joint moves as the joint does; one at a fixed pivot stays. */
TEST(tracer_on_a_pivot)
{
    static subject q;
    lw_vec2 p;
    for (int i = 0; i < 100; i++) {
        double t = 0.1*i;
        named(&q, "fourbar", (double[9]){ 3, 1, 2.5, 2.8, 0, 0, 0, 0, 0 }, 1);
        point_at(&q, q.dim, t, &p);
        CHECK_POINT(p, cos(t), sin(t), 1e-16, 0);
        check_everywhere_finite(&q);
        q.dim[4] = 2.5;
        point_at(&q, q.dim, t, &p);
        CHECK_NEAR(hypot(p.x - 3, p.y), 2.8, 1e-14, 0);
    }
}

TEST(coordinates_of_every_size)
{
    static subject q;
    lw_vec2 unit, p;
    for (int e = -48; e <= 69; e += 3) {
        double s = pow(10, e), dim[9] = { 3*s, s, 2.5*s, 2.8*s, 1.2*s, 0.7*s, 5*s, -3*s, 0.3 };
        named(&q, "fourbar", (double[9]){ 3, 1, 2.5, 2.8, 1.2, 0.7, 5, -3, 0.3 }, 1);
        double m = point_at(&q, q.dim, 0.7, &unit);
        CHECK_NEAR(point_at(&q, dim, 0.7, &p), m, 0, 1e-13);
        CHECK_POINT(p, s*unit.x, s*unit.y, 0, 1e-14);
        named(&q, "fourbar", dim, 1);
        check_everywhere_finite(&q);
    }
}

/* Angles of many turns. */
TEST(far_angles)
{
    static subject q;
    lw_vec2 near, far;
    named(&q, "fourbar", (double[9]){ 3, 1, 2.5, 2.8, 1.2, 0.7, 0, 0, 0.3 }, 1);
    point_at(&q, q.dim, 0.7, &near);
    for (int i = 0; i < 60; i++) {
        double turns = pow(1.5, i);
        q.dim[8] = 0.3 + 2*LW_PI*floor(turns);
        point_at(&q, q.dim, 0.7, &far);
        lw_vec2 p = lw_v2_turn(near, lw_v2_polar(1, remainder(q.dim[8], 2*LW_PI) - 0.3));
        CHECK_POINT(far, p.x, p.y, 1e-14 + 1e-15*turns, 0);
        double c = cos(q.dim[8]), s = sin(q.dim[8]), x, y, u, v;
        lw_vec2 ground = lw_v2_unturn(near, lw_v2_polar(1, 0.3));
        point_at(&q, q.dim, 0.7, &far);
        x = ground.x*c - ground.y*s;
        y = ground.x*s + ground.y*c;
        u = far.x - x;
        v = far.y - y;
        CHECK(hypot(u, v) < 1e-14);
    }
}

/* ---- linkages with known curves ---------------------------------------------------------------------------------- */

TEST(jansen_foot)
{
    static subject q;
    jansen_linkage(&q.k);
    plan_of(&q, false);
    FILE *f = fopen("tests/data/linkages/jansen.csv", "r");
    CHECK(f != NULL);
    char row[512];
    int n = 0;
    while (f && fgets(row, sizeof row, f)) {
        double degree, foot[2];
        if (sscanf(row, "%lf,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%*f,%lf,%lf", &degree, &foot[0], &foot[1]) != 3)
            continue;
        lw_vec2 p;
        point_at(&q, q.dim, degree*LW_PI/180 - q.dim[q.p.i_theta0], &p);
        CHECK_POINT(p, foot[0], foot[1], 2e-12, 0);
        n++;
    }
    if (f)
        fclose(f);
    CHECK_INT(n, 72);
}

/* Greatest |x - line| or |y - line| over a range of the crank. */
static double deviation(const subject *q, double from, double to, double line, bool vertical)
{
    double worst = 0;
    for (int i = 0; i <= 20000; i++) {
        lw_vec2 p;
        CHECK(point_at(q, q->dim, from + (to - from)*i/20000, &p) >= 0);
        worst = fmax(worst, fabs((vertical ? p.x : p.y) - line));
    }
    return worst;
}

/* Scott Russell: coupler twice the crank with the crank pin in its middle; its end moves on x = 0.  The
 * sliding block passes its dead point at 90 degrees, where half the digits go. */
TEST(exact_straight_line)
{
    static subject q;
    named(&q, "slidercrank", (double[8]){ 1, 1, 0, -1, 0, 0, 0, 0 }, 1);
    CHECK(deviation(&q, -1.5, 1.5, 0, true) < 2e-14);
    for (int i = -100; i <= 100; i++) {
        lw_vec2 p;
        point_at(&q, q.dim, 0.015*i, &p);
        CHECK_NEAR(p.y, 2*sin(0.015*i), 2e-14, 0);
    }
}

/* Deviations worked out with 40 digits from the loop equations. Hoeken and Chebyshev in the proportions of Artobolevsky
 * 1975; Watt with rockers 2, coupler 1; Roberts with ground 2, coupler 1, legs 1.2; Evans (grasshopper) with a
 * rocker of 5 for the slide of Scott Russell. */
TEST(nearly_straight_lines)
{
    static subject q;
    lw_vec2 p;
    named(&q, "fourbar", (double[9]){ 2, 1, 2.5, 2.5, 5, 0, 0, 0, 0 }, 1);                   /* Hoeken */
    CHECK_NEAR(deviation(&q, LW_PI/2, 3*LW_PI/2, 4, false), 0.00975373308636001, 1e-9, 0);
    named(&q, "fourbar", (double[9]){ 4, 5, 2, 5, 1, 0, 0, 0, 0 }, -1);                      /* Chebyshev */
    CHECK_NEAR(deviation(&q, 0.72819521782354465, 1.2170903454404836, 4, false), 0.009047910620066203, 1e-9, 0);
    point_at(&q, q.dim, 0.72819521782354465, &p);
    CHECK_NEAR(p.x, 3, 1e-14, 0);
    named(&q, "fourbar", (double[9]){ sqrt(17), 2, 1, 2, 0.5, 0, 0, 0, atan2(-1, 4) }, -1);  /* Watt */
    CHECK_NEAR(deviation(&q, -0.2 + atan2(1, 4), 0.2 + atan2(1, 4), 2, true), 0.000329449596916485622, 1e-14, 0);
    named(&q, "fourbar", (double[9]){ 2, 1.2, 1, 1.2, 0.5, -sqrt(1.19), 0, 0, 0 }, 1);       /* Roberts */
    CHECK_NEAR(deviation(&q, 0.58568554345715096, 1.3417573819825720, 0, false), 0.0136420228761283217, 1e-9, 0);
    point_at(&q, q.dim, acos(0.5/1.2), &p);
    CHECK_POINT(p, 1, 0, 1e-15, 0);
    named(&q, "fourbar", (double[9]){ hypot(1.5, 5), 1, 1, 5, -1, 0, 0, 0, atan2(-5, 1.5) }, 1);  /* Evans */
    CHECK_NEAR(deviation(&q, 0.3 - atan2(-5, 1.5), 0.9 - atan2(-5, 1.5), 0, true), 0.00901446986345329143, 1e-14, 0);
}

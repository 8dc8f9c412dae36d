/* test_descriptor.c - shapes of curves: free of place, size, turn, start, direction, mirroring; the bound. */
#include "catalogues/curves/descriptor.h"

#include "tests/check.h"

#define N 600

/* A closed or open curve of a few waves. */
static void draw(lw_rng *rng, bool closed, lw_vec2 p[N])
{
    lw_vec2 c[5], d[5];
    for (int k = 0; k < 5; k++) {
        double r = exp(-0.9*k);
        c[k] = lw_v2(r*lw_rng_normal(rng), r*lw_rng_normal(rng));
        d[k] = lw_v2(r*lw_rng_normal(rng), r*lw_rng_normal(rng));
    }
    for (int i = 0; i < N; i++) {
        double t = closed ? 2*LW_PI*i/N : 2.5*i/(N - 1);
        p[i] = lw_v2(0, 0);
        for (int k = 0; k < 5; k++)
            p[i] = lw_v2_add(p[i], lw_v2_add(lw_v2_turn(c[k], lw_v2_polar(1, (k + 1)*t)), lw_v2_turn(d[k], lw_v2_polar(1, -(k + 1)*t))));
    }
}

/* Elsewhere, larger, turned; begun later, run through the other way, mirrored. */
static void disguise(lw_rng *rng, bool closed, const lw_vec2 *p, lw_vec2 *q, bool mirrored)
{
    double size = exp(lw_rng_range(rng, -3, 3)), turn = lw_rng_range(rng, -3, 3);
    lw_vec2 shift = lw_v2(lw_rng_range(rng, -9, 9), lw_rng_range(rng, -9, 9));
    size_t start = closed ? (size_t)lw_rng_range(rng, 0, N) : 0;
    bool reversed = lw_rng_uniform(rng) < 0.5;
    for (size_t i = 0; i < N; i++) {
        size_t k = reversed ? N - 1 - i : i;
        lw_vec2 a = p[(k + start)%N];
        if (mirrored)
            a.y = -a.y;
        q[i] = lw_v2_add(shift, lw_v2_turn(a, lw_v2_polar(size, turn)));
    }
}

static void make(const lw_vec2 *p, size_t n, bool closed, lw_descriptor *d)
{
    CHECK_INT(lw_descriptor_make(p, n, closed, d), LW_OK);
}

TEST(sees_through_disguises)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 60; trial++) {
        lw_vec2 p[N], q[N];
        lw_descriptor a, b;
        lw_match m;
        bool closed = trial%2, mirrored = trial%4 < 2;
        draw(&rng, closed, p);
        disguise(&rng, closed, p, q, mirrored);
        make(p, N, closed, &a);
        make(q, N, closed, &b);
        lw_descriptor_match(&a, &b, &m);
        CHECK_NEAR(m.distance, 0, 1e-3, 0);             /* 128 samples of a tight bend, begun elsewhere */
        CHECK_INT(m.mirrored, mirrored);
        /* the transformation lays q on p: the mean distance of points is what it says */
        double worst = 0;
        for (int i = 0; i < N; i += 7) {
            lw_vec2 v = lw_v2_sub(q[i], b.centre);
            double near = INFINITY;
            if (m.mirrored)
                v.y = -v.y;
            v = lw_v2_add(a.centre, lw_v2_turn(v, lw_v2_polar(a.size/b.size, m.turn)));
            for (int k = 0; k < N; k++)
                near = fmin(near, lw_v2_segment_distance(v, p[k], p[closed ? (k + 1)%N : k + 1 < N ? k + 1 : k]));
            worst = fmax(worst, near);
        }
        CHECK_NEAR(worst, 0, 5e-3*a.size, 0);
    }
}

/* Slow and obvious: every start, both directions, mirrored or not, the best turn for each. */
static double distance_by_force(const lw_vec2 *x, const lw_vec2 *y, int n, bool closed)
{
    double best = INFINITY;
    for (int v = 0; v < 4; v++)
        for (int start = 0; start < (closed ? n : 1); start++) {
            lw_vec2 f = lw_v2(0, 0);
            double squares = 0;
            for (int i = 0; i < n; i++) {
                lw_vec2 b = y[((v & 2 ? n - 1 - i : i) + start)%n];
                b.y = v & 1 ? -b.y : b.y;
                f = lw_v2_add(f, lw_v2_unturn(x[i], b));
                squares += lw_v2_dot(x[i], x[i]) + lw_v2_dot(b, b);
            }
            best = fmin(best, (squares - 2*lw_v2_norm(f))/n);
        }
    return sqrt(fmax(best, 0));
}

/* n points at even distances, centred, of size one. */
static void normalise(const lw_vec2 *p, const lw_descriptor *d, bool closed, lw_vec2 *out, int n)
{
    double length = 0, before = 0;
    for (int i = 0; i + 1 < N + closed; i++)
        length += lw_v2_norm(lw_v2_sub(p[(i + 1)%N], p[i]));
    int k = 0;
    for (int i = 0; i + 1 < N + closed; i++) {
        double piece = lw_v2_norm(lw_v2_sub(p[(i + 1)%N], p[i]));
        for (; k < n && (k + 0.5)*length/n <= before + piece; k++) {
            double t = ((k + 0.5)*length/n - before)/piece;
            out[k] = lw_v2_scale(lw_v2_sub(lw_v2_add(p[i], lw_v2_scale(lw_v2_sub(p[(i + 1)%N], p[i]), t)), d->centre), 1/d->size);
        }
        before += piece;
    }
}

TEST(distance_as_by_force)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 20; trial++) {
        lw_vec2 p[N], q[N], x[200], y[200];
        lw_descriptor a, b;
        lw_match m;
        bool closed = trial%2;
        draw(&rng, closed, p);
        draw(&rng, closed, q);
        make(p, N, closed, &a);
        make(q, N, closed, &b);
        lw_descriptor_match(&a, &b, &m);
        normalise(p, &a, closed, x, 200);
        normalise(q, &b, closed, y, 200);
        double slow = distance_by_force(x, y, 200, closed);
        CHECK_NEAR(m.distance, slow, 0.02, 0);                 /* terms beyond the sixteenth */
    }
}

/* The quick distance and the bound, against the exact one. */
TEST(quick_ones_bound_it)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 300; trial++) {
        lw_vec2 p[N], q[N];
        lw_descriptor a, b, c;
        lw_packed packed;
        lw_matcher quick;
        lw_match m, exact;
        float forth[LW_TERMS], back[LW_TERMS], size[LW_TERMS], bound = 0, bound_back = 0;
        bool closed = trial%2;
        draw(&rng, closed, p);
        draw(&rng, closed, q);
        make(p, N, closed, &a);
        make(trial%3 ? q : p, N, closed, &b);
        lw_descriptor_pack(&b, &packed);
        lw_descriptor_unpack(&packed, closed, &c);
        lw_descriptor_match(&a, &b, &exact);
        lw_descriptor_match(&a, &c, &m);
        CHECK_NEAR(m.distance, exact.distance, trial%3 ? 2e-4 : 1e-3, 0);
        lw_matcher_make(&a, &quick);
        double limit = m.distance*m.distance*lw_rng_uniform(&rng)*2, square = lw_matcher_square(&quick, &packed, limit);
        if (square <= limit || limit >= m.distance*m.distance)
            CHECK_NEAR(square, m.distance*m.distance, 1e-12, 0);
        CHECK(square >= m.distance*m.distance - 1e-12);
        lw_descriptor_sizes(&a, forth, back);
        lw_packed_size(&packed, size);
        for (int k = 0; k < LW_TERMS; k++) {
            bound += (forth[k] - size[k])*(forth[k] - size[k]);
            bound_back += (back[k] - size[k])*(back[k] - size[k]);
        }
        CHECK(fmin(bound, bound_back) <= m.distance*m.distance + 1e-5);
    }
}

/* The best of all starts against 5000 starts in each sense, by the terms alone.  Between two starts |F| changes by less
 * than the second-order remainder; near circles and curves with several equally good starts are among them. */
TEST(best_start_as_by_force)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 60; trial++) {
        lw_vec2 p[N], q[N];
        lw_descriptor a, b;
        lw_match m;
        double squares = 0, best = 0, bend = 0;
        draw(&rng, true, p);
        for (int i = 0; i < N && trial%4 == 1; i++)            /* threefold symmetry */
            p[i] = lw_v2_polar(1 + 0.1*cos(6*LW_PI*i/N), 2*LW_PI*i/N);
        draw(&rng, true, q);
        for (int i = 0; i < N && trial%4 >= 2; i++)
            q[i] = lw_v2_polar(1 + (trial%4 == 2 ? 0.1 : 1e-7)*cos(6*LW_PI*i/N + trial), 2*LW_PI*i/N);
        make(p, N, true, &a);
        make(q, N, true, &b);
        lw_descriptor_match(&a, &b, &m);
        for (int k = 0; k < LW_TERMS; k++) {
            squares += lw_v2_dot(a.term[k], a.term[k]) + lw_v2_dot(b.term[k], b.term[k]);
            bend += (k/2 + 1)*(k/2 + 1)*lw_v2_norm(a.term[k])*fmax(lw_v2_norm(b.term[k]), lw_v2_norm(b.term[k ^ 1]));
        }
        for (int i = 0; i < 5000; i++)
            for (int v = 0; v < 4; v++) {
                lw_vec2 f = lw_v2(0, 0);
                for (int k = 0; k < LW_TERMS; k++) {
                    lw_vec2 c = b.term[v == 1 || v == 2 ? k ^ 1 : k];
                    c.y = v & 1 ? -c.y : c.y;
                    lw_vec2 start = lw_v2_polar(1, (k%2 ? -1 : 1)*(k/2 + 1)*2*LW_PI*i/5000);
                    f = lw_v2_add(f, lw_v2_turn(lw_v2_unturn(a.term[k], c), start));
                }
                best = fmax(best, lw_v2_norm(f));
            }
        CHECK(m.distance*m.distance <= squares - 2*best + 1e-12);
        CHECK(m.distance*m.distance >= squares - 2*best - bend*(LW_PI/5000)*(LW_PI/5000) - 1e-12);
    }
}

TEST(known_shapes)
{
    lw_vec2 p[N], two[2] = { { 0, 0 }, { 2, 0 } };
    lw_descriptor d;
    for (int i = 0; i < N; i++)
        p[i] = lw_v2_add(lw_v2(3, 4), lw_v2_polar(2, 2*LW_PI*i/N));
    make(p, N, true, &d);                                       /* a circle is c_1 alone */
    CHECK_NEAR(d.size, 2, 1e-4, 0);
    CHECK_NEAR(d.centre.x, 3, 1e-12, 0);
    CHECK_NEAR(d.term[0].x, 1, 1e-4, 0);
    for (int k = 1; k < LW_TERMS; k++)
        CHECK_NEAR(lw_v2_norm(d.term[k]), 0, 1e-4, 0);
    make(two, 2, false, &d);                                    /* a line: size 2/sqrt 12, only odd terms, as 1/k^2 */
    CHECK_NEAR(d.size, 2/sqrt(12), 1e-4, 0);
    for (int k = 1; k < LW_TERMS; k += 2)
        CHECK_NEAR(lw_v2_norm(d.term[k]), 0, 1e-12, 0);
    CHECK_NEAR(d.term[2].x/d.term[0].x, 1/9.0, 1e-3, 0);
    CHECK_INT(lw_descriptor_make(two, 1, false, &d), LW_E_ARG);
    two[1] = two[0];
    CHECK_INT(lw_descriptor_make(two, 2, false, &d), LW_E_ARG);
    two[1].x = NAN;
    CHECK_INT(lw_descriptor_make(two, 2, true, &d), LW_E_ARG);
}

/* Ten points on an ellipse make a curve within 1 % of it; the points are on it, also when some repeat. */
TEST(smooth_curves)
{
    lw_vec2 p[11], out[1001];
    for (int i = 0; i < 10; i++)
        p[i] = lw_v2(3*cos(2*LW_PI*i/10), 2*sin(2*LW_PI*i/10));
    lw_curve_smooth(p, 10, true, out, 1000);
    for (int j = 0; j < 1000; j++)
        CHECK_NEAR(hypot(out[j].x/3, out[j].y/2), 1, 0.012, 0);
    for (int i = 0; i < 10; i++)
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(out[100*i], p[i])), 0, 1e-12, 0);
    p[10] = p[9];
    lw_curve_smooth(p, 11, false, out, 1001);
    for (int j = 0; j < 1001; j++)
        CHECK(isfinite(out[j].x) && isfinite(out[j].y));
    for (int i = 0; i < 11; i++)
        CHECK_NEAR(lw_v2_norm(lw_v2_sub(out[100*i], p[i])), 0, 1e-12, 0);
    lw_curve_smooth(p, 2, false, out, 3);
    CHECK_NEAR(lw_v2_norm(lw_v2_sub(out[1], lw_v2_scale(lw_v2_add(p[0], p[1]), 0.5))), 0, 1e-12, 0);
}

/* Distances of curves: known ones, and what must not matter. */
#include "optimise/report/likeness.h"
#include "optimise/task/specification.h"
#include "tests/check.h"

enum { N = 900 };

static void circle(double r, lw_vec2 centre, double from, int sense, lw_vec2 p[N])
{
    for (int i = 0; i < N; i++)
        p[i] = lw_v2_add(centre, lw_v2_polar(r, from + sense*2*LW_PI*i/N));
}

static void make(const lw_vec2 p[N], int closed, lw_target *t)
{
    double x[N], y[N];
    for (int i = 0; i < N; i++) {
        x[i] = p[i].x;
        y[i] = p[i].y;
    }
    CHECK_INT(lw_target_make(N, x, y, NULL, NULL, NULL, closed, t, NULL), LW_OK);
}

TEST(concentric_circles)
{
    lw_vec2 a[N], b[N];
    OWN(lw_target) t = { 0 };
    lw_likeness l;
    circle(2, lw_v2(3, 4), 0, 1, a);
    make(a, 1, &t);
    for (int sense = -1; sense <= 1; sense += 2) {
        circle(2.5, lw_v2(3, 4), 1, sense, b);
        lw_likeness_measure(&t, b, N, &l);
        CHECK_NEAR(l.chamfer, 0.25, 1e-3, 0);             /* less the sagitta of the polygons       */
        CHECK_NEAR(l.ordered, 0.25, 1e-3, 0);
        CHECK_NEAR(l.chamfer, 0.5*(l.to_curve + l.to_target), 1e-15, 0);
    }
    lw_likeness_measure(&t, a, N, &l);
    CHECK_NEAR(l.chamfer, 0, 4e-6, 0);                    /* the sagitta of 900 chords               */
    CHECK_NEAR(l.ordered, 0, 4e-6, 0);
}

static void make_of(const lw_vec2 *p, size_t n, int closed, lw_target *t)
{
    double x[64], y[64];
    for (size_t i = 0; i < n; i++) {
        x[i] = p[i].x;
        y[i] = p[i].y;
    }
    CHECK_INT(lw_target_make(n, x, y, NULL, NULL, NULL, closed, t, NULL), LW_OK);
}

/* The curve that few stations were taken from is like them, open or closed; by chords it would be 1e-3 and more away. */
TEST(few_stations_of_a_smooth_curve)
{
    for (int closed = 0; closed < 2; closed++) {
        enum { FEW = 40 };
        lw_vec2 few[FEW], all[N];
        OWN(lw_target) t = { 0 };
        lw_likeness l;
        double turn = closed ? 2*LW_PI : 4;
        for (int i = 0; i < FEW; i++) {
            double s = turn*i/(closed ? FEW : FEW - 1);
            few[i] = lw_v2(3*cos(s) + 0.3*cos(2*s), 1.5*sin(s));
        }
        for (int i = 0; i < N; i++) {
            double s = turn*i/(closed ? N : N - 1);
            all[i] = lw_v2(3*cos(s) + 0.3*cos(2*s), 1.5*sin(s));
        }
        make_of(few, FEW, closed, &t);
        lw_likeness_measure(&t, all, N, &l);
        CHECK(l.chamfer < 1e-4);
        CHECK(l.chamfer > 0);
    }
}

/* A square of four stations, and one of many, stay squares. */
TEST(corners_stay_corners)
{
    static const lw_vec2 corner[4] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    for (int many = 1; many <= 15; many += 7) {
        lw_vec2 p[64];
        OWN(lw_target) t = { 0 };
        lw_likeness l;
        for (int i = 0; i < 4*many; i++) {
            double part = (double)(i % many)/many;
            lw_vec2 a = corner[i/many], b = corner[(i/many + 1) % 4];
            p[i] = lw_v2_add(a, lw_v2_scale(lw_v2_sub(b, a), part));
        }
        make_of(p, 4*(size_t)many, 1, &t);
        lw_likeness_measure(&t, corner, 4, &l);
        CHECK_NEAR(l.chamfer, 0, 1e-12, 0);
    }
}

/* A rounded rectangle whose stations stand on its corners only: its sides are straight. */
TEST(straight_sides_between_rounded_corners)
{
    enum { EACH = 6 };
    static const double centre[4][2] = { { 80, 30 }, { -80, 30 }, { -80, -30 }, { 80, -30 } };
    lw_vec2 p[4*EACH], side[2] = { { -80, 40 }, { 80, 40 } };
    OWN(lw_target) t = { 0 };
    for (int c = 0; c < 4; c++)
        for (int i = 0; i < EACH; i++)
            p[c*EACH + i] = lw_v2_add(lw_v2(centre[c][0], centre[c][1]), lw_v2_polar(10, LW_PI/2*(c + (double)i/(EACH - 1))));
    make_of(p, 4*EACH, 1, &t);
    CHECK_NEAR(lw_likeness_stray(&t, side, 2).to_target, 0, 1e-12, 0);
}

TEST(an_open_line_and_its_double)
{
    lw_vec2 a[N], b[2] = { { 2, 0 }, { 0, 0 } };
    OWN(lw_target) t = { 0 };
    lw_likeness l;
    for (int i = 0; i < N; i++)
        a[i] = lw_v2((double)i/(N - 1), 0);
    make(a, 0, &t);
    lw_likeness_measure(&t, b, 2, &l);
    double radius = sqrt(1.0/12)*sqrt((LW_LIKENESS_POINTS + 1.0)/(LW_LIKENESS_POINTS - 1));
    CHECK_NEAR(l.to_target*radius, 0.25, 5e-3, 0);        /* half of it lies 0 .. 1 away            */
    CHECK(l.to_curve*radius < 5e-3);
    CHECK_NEAR(l.ordered*radius, 0.5, 5e-3, 0);
}

TEST(scale_and_place_do_not_matter)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 20; trial++) {
        lw_vec2 a[N], b[N], u = lw_v2_polar(exp(lw_rng_normal(&rng)), 6*lw_rng_uniform(&rng));
        OWN(lw_target) t = { 0 };
        lw_likeness l, moved;
        for (int i = 0; i < N; i++) {
            double s = 2*LW_PI*i/N;
            a[i] = lw_v2(cos(s) + 0.3*cos(3*s), sin(s));
            b[i] = lw_v2(1.1*cos(s), sin(s) + 0.1*sin(2*s + trial));
        }
        make(a, 1, &t);
        lw_likeness_measure(&t, b, N, &l);
        lw_target_free(&t);
        for (int i = 0; i < N; i++) {
            a[i] = lw_v2_add(lw_v2(7, -2), lw_v2_turn(a[i], u));
            b[i] = lw_v2_add(lw_v2(7, -2), lw_v2_turn(b[i], u));
        }
        make(a, 1, &t);
        lw_likeness_measure(&t, b, N, &moved);
        CHECK_NEAR(moved.chamfer, l.chamfer, 1e-9, 1e-9);
        CHECK_NEAR(moved.ordered, l.ordered, 1e-9, 1e-9);
        CHECK(l.ordered >= l.to_curve - 1e-12);
    }
}

/* Between stations on a circle the curve is unsure by twice the height of the arcs, however few they are; on a line it is known. */
TEST(few_stations_leave_the_curve_unsure)
{
    lw_vec2 p[40], b[2] = { { 2, 0 }, { 0, 0 } };
    lw_target t;
    for (int n = 3; n <= 40; n += 7)
        for (int closed = 0; closed < 2; closed++) {
            for (int i = 0; i < n; i++)
                p[i] = lw_v2_polar(5, 2*LW_PI*i/n);
            make_of(p, (size_t)n, closed, &t);
            CHECK_NEAR(lw_likeness_stray(&t, b, 2).unsure, 2*5*(1 - cos(LW_PI/n)), 0, 1e-12);
            lw_target_free(&t);
        }
    for (int i = 0; i < 4; i++)
        p[i] = lw_v2(0.1*i*i, 0.2*i*i);
    make_of(p, 4, 0, &t);
    CHECK_NEAR(lw_likeness_stray(&t, b, 2).unsure, 0, 1e-15, 0);
    lw_target_free(&t);
    make_of(p, 2, 0, &t);
    CHECK_NEAR(lw_likeness_stray(&t, b, 2).unsure, 0.5*tan(LW_PI/8)*hypot(0.1, 0.2), 0, 1e-12);     /* an arc of 90 degrees */
    lw_target_free(&t);
}

/* Between poses a body may turn about one point, the shorter way: by 100 and 90 degrees here, along a straight line of stations. */
TEST(poses_leave_the_arc_of_a_turn_open)
{
    const double x[] = { 0, 3, 8 }, y[] = { 0, 0, 0 }, theta[] = { 0, 100*LW_PI/180, 370*LW_PI/180 };
    const lw_vec2 b[2] = { { 2, 0 }, { 0, 0 } };
    lw_target t;
    for (size_t n = 2; n <= 3; n++) {
        CHECK_INT(lw_target_make(n, x, y, theta, NULL, NULL, 0, &t, NULL), LW_OK);
        CHECK_NEAR(lw_likeness_stray(&t, b, 2).unsure, n == 2 ? 1.5*tan(25*LW_PI/180) : 2.5*tan(22.5*LW_PI/180), 0, 1e-12);
        CHECK_NEAR(lw_stray_allowed(&t, n), 0.02 + 0.5/(double)n, 0, 1e-12);
        lw_target_free(&t);
    }
    const double folded[] = { 0, LW_PI };                /* half a turn: a curve may go on a half circle, which is far from the line */
    CHECK_INT(lw_target_make(2, x, y, folded, NULL, NULL, 0, &t, NULL), LW_OK);
    CHECK_NEAR(lw_stray_allowed(&t, 2), 0.02 + 1.5/t.size, 0, 1e-12);
    lw_target_free(&t);
}

/* The greatest distance of the stations from wild polylines of several lengths, compared with a look at every segment. */
TEST(stray_looks_at_every_segment)
{
    lw_rng rng = check_rng(0);
    for (int trial = 0; trial < 20; trial++) {
        lw_vec2 a[N], b[N];
        OWN(lw_target) t = { 0 };
        int n = trial < 4 ? 2 + trial : (int)(2 + lw_rng_uniform(&rng)*(N - 2)), closed = trial % 2;
        circle(2, lw_v2(0, 0), 0, 1, a);
        for (int i = 0; i < n; i++)
            b[i] = lw_v2(3*lw_rng_normal(&rng), lw_rng_normal(&rng));
        make(a, closed, &t);
        double most = 0;
        for (int i = 0; i < N; i++) {
            double least = INFINITY;
            for (int j = 0; j + !closed < n; j++)
                least = fmin(least, lw_v2_segment_distance(a[i], b[j], b[(j + 1) % n]));
            most = fmax(most, least);
        }
        CHECK(lw_likeness_stray(&t, b, (size_t)n).to_curve == most);
    }
}

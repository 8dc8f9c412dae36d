/* Motions of one axis in least time: published values, limits, random states against a search by another way. */
#include "grammar/functions/profile.h"

#include <stdbool.h>
#include "tests/check.h"

static double least_time(lw_axis_state from, lw_axis_state to, lw_axis_limits l)
{
    lw_profile p;
    lw_error e = { 0 };
    lw_status s = lw_profile_make(from, to, &l, 0, &p, &e);
    if (s != LW_OK)
        printf("%s\n", e.text);
    return s == LW_OK ? p.duration : NAN;
}

static double rest_to_rest(double way, double v)
{
    return least_time((lw_axis_state){ 0 }, (lw_axis_state){ .x = way }, lw_axis_limits_even(v, 20, 400));
}

/* Values computed independently by two programs, with a = 20, j = 400. */
TEST(known_times)
{
    CHECK_NEAR(rest_to_rest(0.05, INFINITY), 0.158740105, 1e-9, 0);
    CHECK_NEAR(rest_to_rest(0.2, INFINITY), 0.256155281, 1e-9, 0);
    CHECK_NEAR(rest_to_rest(0.8, INFINITY), 0.453112887, 1e-9, 0);
    CHECK_NEAR(rest_to_rest(1, INFINITY), 0.5, 1e-12, 0);
    CHECK_NEAR(rest_to_rest(1, 3), 0.533333333, 1e-9, 0);
    CHECK_NEAR(rest_to_rest(4, 3), 1.533333333, 1e-9, 0);
    CHECK_NEAR(rest_to_rest(-4, 3), 1.533333333, 1e-9, 0);
    lw_axis_limits l = lw_axis_limits_even(3, 20, 400);
    CHECK_NEAR(least_time((lw_axis_state){ 0, 1, 0 }, (lw_axis_state){ 1, 0.5, 0 }, l), 0.45625, 1e-12, 0);
    CHECK_NEAR(least_time((lw_axis_state){ 0, 2, 0 }, (lw_axis_state){ 0.1, 0, 0 }, l), 0.260212879, 1e-9, 0);
    CHECK_NEAR(least_time((lw_axis_state){ 0, -1.054177999, -2.614587545 },
                          (lw_axis_state){ 0.008484006, 0.819532871, -8.989127874 }, l), 0.183371296, 1e-9, 0);
}

/* The cycle up .2, over 1.0, down .8 m of a robot, and without a limit of jerk. */
TEST(cycle_of_a_robot)
{
    double v = INFINITY;
    CHECK_NEAR(2*(rest_to_rest(0.2, v) + rest_to_rest(1, v) + rest_to_rest(0.8, v)), 2.418536337, 2e-9, 0);
    lw_axis_limits l = lw_axis_limits_even(INFINITY, 20, INFINITY);
    CHECK_NEAR(least_time((lw_axis_state){ 0 }, (lw_axis_state){ .x = 1 }, l), sqrt(4*1/20.0), 1e-12, 0);
    l = lw_axis_limits_even(3, 20, INFINITY);
    CHECK_NEAR(least_time((lw_axis_state){ 0 }, (lw_axis_state){ .x = 1 }, l), 1.0/3 + 3/20.0, 1e-12, 0);
}

static double between(lw_rng *r, double lo, double hi) { return lo + (hi - lo)*lw_rng_uniform(r); }

static bool feasible(lw_axis_state s, const lw_axis_limits *l, int sign)
{
    double rate = (s.a > 0) == (sign > 0) ? -l->j[0] : l->j[1];
    double v = s.v + sign*s.a*fabs(s.a)/2/rate;
    return v >= l->v[0] && v <= l->v[1];
}

static lw_axis_limits random_case(lw_rng *r, lw_axis_state *from, lw_axis_state *to)
{
    lw_axis_limits l;
    do {
        bool even = lw_rng_uniform(r) < 0.3, free_speed = lw_rng_uniform(r) < 0.1, free_a = lw_rng_uniform(r) < 0.1;
        double v = pow(10, between(r, -1, 1)), a = v*pow(10, between(r, 0, 1.5)), j = a*pow(10, between(r, 0, 1.5));
        l = lw_axis_limits_even(v, a, j);
        for (int side = 0; side < 2 && !even; side++)
            l.v[side] *= between(r, 0.3, 1), l.a[side] *= between(r, 0.3, 1), l.j[side] *= between(r, 0.3, 1);
        *from = (lw_axis_state){ between(r, -1, 1), between(r, l.v[0], l.v[1]), between(r, l.a[0], l.a[1]) };
        *to = (lw_axis_state){ from->x + v*between(r, -1, 1)*pow(10, between(r, -3, 1)), between(r, l.v[0], l.v[1]),
                               between(r, l.a[0], l.a[1]) };
        if (lw_rng_uniform(r) < 0.2)
            from->a = to->a = 0;
        if (lw_rng_uniform(r) < 0.1)
            to->v = from->v;
        if (lw_rng_uniform(r) < 0.1)
            from->v = to->v = from->a = to->a = 0;
        if (free_speed)
            l.v[0] = -INFINITY, l.v[1] = INFINITY;
        if (free_a)
            l.a[0] = -INFINITY, l.a[1] = INFINITY;
    } while (!feasible(*from, &l, 1) || !feasible(*to, &l, -1));
    return l;
}

static void check_motion(const lw_profile *p, lw_axis_state from, lw_axis_state to, const lw_axis_limits *l)
{
    double slack = 1e-12;
    lw_axis_limits e = lw_profile_extremes(p);
    lw_axis_state end = lw_profile_at(p, p->duration, NULL);
    double a_size = fmax(fmin(l->a[1] - l->a[0], 1e300), p->duration*fmin(l->j[1] - l->j[0], 1e300));
    a_size = fmin(a_size, fabs(e.a[0]) + fabs(e.a[1]) + p->duration*fmin(l->j[1] - l->j[0], 1e300));
    double v = fabs(e.v[0]) + fabs(e.v[1]), a = fmin(l->a[1], -l->a[0]), stop = v*v/a;      /* stop: way to a halt */
    double size = fabs(from.x) + fabs(to.x) + p->duration*(v + p->duration*a_size) + stop;
    CHECK_NEAR(end.x, to.x, 1e-12*size + 1e-300, 0);
    CHECK_NEAR(end.v, to.v, 1e-12*v + 1e-12*p->duration*a_size + 1e-300, 0);
    CHECK_NEAR(end.a, to.a, 1e-12*a_size + 1e-300, 0);
    CHECK(p->n == 0 || (p->at[0].x == from.x && p->at[0].v == from.v));
    const double *limit[3] = { l->v, l->a, l->j }, *seen[3] = { e.v, e.a, e.j };
    for (int k = 0; k < 3 && p->n; k++) {
        double scale = fmin(fabs(limit[k][0]), 1e300) + fmin(fabs(limit[k][1]), 1e300);
        CHECK(seen[k][0] >= limit[k][0] - slack*scale);
        CHECK(seen[k][1] <= limit[k][1] + slack*scale);
    }
    for (int i = 1; i < p->n; i++) {                       /* no step in position, speed, acceleration */
        lw_axis_state s = p->at[i - 1];
        double d = p->t[i] - p->t[i - 1], j = p->jerk[i - 1];
        CHECK_NEAR(p->at[i].x, s.x + d*(s.v + d*(s.a/2 + d*j/6)), 1e-12*size, 0);
        CHECK_NEAR(p->at[i].v, s.v + d*(s.a + d*j/2), 1e-12*v, 0);
        CHECK_NEAR(p->at[i].a, s.a + d*j, 1e-12*a_size, 0);
    }
}

TEST(random_states_keep_their_limits)
{
    lw_rng r = check_rng(0);
    for (int k = 0; k < 20000; k++) {
        lw_axis_state from, to;
        lw_axis_limits l = random_case(&r, &from, &to);
        lw_profile p;
        CHECK_OK(lw_profile_make(from, to, &l, 0, &p, &check_error));
        check_motion(&p, from, to, &l);
    }
}

/* A random motion within the limits, phase by phase, shows that its own duration is possible for the state where it
 * ends: the least time is never longer, and a motion of just that duration is found. */
TEST(nothing_random_is_quicker)
{
    lw_rng r = check_rng(1);
    int compared = 0;
    for (int k = 0; k < 100000; k++) {
        lw_axis_state from, to;
        lw_axis_limits l = random_case(&r, &from, &to);
        if (isinf(l.a[0]))
            l.a[1] = 1 + 2*fabs(from.a), l.a[0] = -l.a[1];
        from.x = 0;                                        /* the way is known to its own rounding */
        /* a random motion from `from` within the limits; where it ends is the goal, so its time is possible */
        lw_axis_state s = from;
        double T = 0;
        int n = 1 + (int)(lw_rng_uniform(&r)*7);
        for (int i = 0; i < n; i++) {
            double pick = lw_rng_uniform(&r), jerk = pick < 0.4 ? l.j[1] : pick < 0.8 ? l.j[0] : 0;
            double t = (l.a[1] - l.a[0])/(l.j[1] - l.j[0])*lw_rng_uniform(&r)*2;
            if (jerk > 0)
                t = fmin(t, (l.a[1] - s.a)/jerk);
            if (jerk < 0)
                t = fmin(t, (l.a[0] - s.a)/jerk);
            lw_axis_state next = { s.x + t*(s.v + t*(s.a/2 + t*jerk/6)), s.v + t*(s.a + t*jerk/2), s.a + t*jerk };
            double turn = jerk != 0 ? -s.a/jerk : -1;      /* where the speed is extreme */
            double extreme = turn > 0 && turn < t ? s.v + turn*(s.a + turn*jerk/2) : s.v;
            if (!feasible(next, &l, 1) || !feasible(next, &l, -1) || extreme < l.v[0] || extreme > l.v[1]
                || next.v < l.v[0] || next.v > l.v[1])
                continue;
            s = next;
            T += t;
        }
        if (T == 0)
            continue;
        double least = least_time(from, s, l);
        CHECK(least <= T*(1 + 1e-9) + 1e-12);
        compared++;
        /* the same time asked for exactly is possible, and so is what comes of it */
        lw_profile p;
        lw_error e = { 0 };
        double next = T;                                   /* at the end of an interval of durations: to rounding */
        CHECK(lw_profile_make_timed(from, s, &l, T*(1 - 1e-9), &p, &next, &e) == LW_OK || next <= T*(1 + 1e-8));
        check_motion(&p, from, s, &l);
    }
    CHECK(compared > 50000);
}

/* The first possible time is first: durations below it, on a fine grid, are refused by the exact condition that the way
 * lies between the extremes, and those reported as next are possible. */
TEST(times_between_are_refused)
{
    lw_axis_limits l = lw_axis_limits_even(3, 20, 400);
    lw_axis_state from = { 0, -2, 0 }, to = { -0.1, -2, 0 };       /* 0.05 s, or back and forth */
    lw_profile p;
    double next = 0;
    CHECK_NEAR(least_time(from, to, l), 0.05, 1e-3, 0);
    CHECK_INT(lw_profile_make_timed(from, to, &l, 0.2, &p, &next, &check_error), LW_NOTHING);
    CHECK(next > 0.2);
    CHECK_OK(lw_profile_make_timed(from, to, &l, next, &p, NULL, &check_error));
    check_motion(&p, from, to, &l);
    CHECK_OK(lw_profile_make_timed(from, to, &l, next + 0.5, &p, NULL, &check_error));
    check_motion(&p, from, to, &l);
    CHECK_NEAR(p.duration, next + 0.5, 1e-12, 0);
}

TEST(axes_arrive_together)
{
    lw_axis_state from[3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
    lw_axis_state to[3] = { { .x = 1 }, { .x = 0.2 }, { .x = 0.8 } };
    lw_axis_limits one = lw_axis_limits_even(3, 20, 400), l[3] = { one, one, one };
    lw_profile p[3];
    for (int phase = 0; phase < 2; phase++) {
        CHECK_OK(lw_profile_make_axes(3, from, to, l, 0, phase, p, &check_error));
        for (int i = 0; i < 3; i++) {
            CHECK_NEAR(p[i].duration, 0.533333333, 1e-9, 0);
            check_motion(&p[i], from[i], to[i], &l[i]);
        }
    }
    for (int k = 0; k <= 50; k++) {                        /* in phase: along a line */
        double t = p[0].duration*k/50, x = lw_profile_at(&p[0], t, NULL).x;
        CHECK_NEAR(lw_profile_at(&p[1], t, NULL).x, 0.2*x, 1e-13, 0);
        CHECK_NEAR(lw_profile_at(&p[2], t, NULL).x, 0.8*x, 1e-13, 0);
    }
    to[1].v = 0.5;
    CHECK_INT(lw_profile_make_axes(3, from, to, l, 0, true, p, &check_error), LW_NOTHING);
    CHECK_OK(lw_profile_make_axes(3, from, to, l, 0, false, p, &check_error));
    CHECK(p[0].duration == p[1].duration || fabs(p[0].duration - p[1].duration) < 1e-11);
}

TEST(impossible_limits_are_named)
{
    struct { lw_axis_state from, to; lw_axis_limits l; const char *part; } bad[] = {
        { { 0, 0, 0 }, { .x = 1, .v = 4 }, lw_axis_limits_even(3, 20, 400), "last speed 4" },
        { { .v = 2.9, .a = 20 }, { .x = 1 }, lw_axis_limits_even(3, 20, 400), "make the speed 3.4 afterwards" },
        { { 0, 0, 0 }, { .x = 1 }, lw_axis_limits_even(3, INFINITY, INFINITY), "neither" },
        { { 0, 0, 0 }, { .x = 1 }, lw_axis_limits_even(-3, 20, 400), "limits" },
        { { .v = 1 }, { .x = -1, .v = 1 }, { { 0.5, 3 }, { -20, 20 }, { -400, 400 } }, "do not allow a way" },
        { { 0, 0, 0 }, { .x = NAN }, lw_axis_limits_even(3, 20, 400), "not finite" }
    };
    for (size_t i = 0; i < sizeof bad/sizeof *bad; i++) {
        lw_profile p;
        CHECK_FAILS(lw_profile_make(bad[i].from, bad[i].to, &bad[i].l, 0, &p, &check_error), LW_E_ARG, bad[i].part);
    }
}

TEST(no_way_and_huge_and_tiny)
{
    CHECK_NEAR(rest_to_rest(0, 3), 0, 0, 0);
    double scale[] = { 1e-12, 1e-6, 1e6, 1e12 };
    for (int i = 0; i < 4; i++) {                          /* all lengths scaled: the time stays */
        double s = scale[i];
        CHECK_NEAR(least_time((lw_axis_state){ 0 }, (lw_axis_state){ .x = s }, lw_axis_limits_even(3*s, 20*s, 400*s)),
                   0.5333333333333333, 1e-12, 0);
    }
    CHECK_NEAR(rest_to_rest(1e9, 3), 1e9/3 + 3/20.0 + 20/400.0, 0, 1e-14);
    CHECK_NEAR(rest_to_rest(1e-15, 3), 4*cbrt(1e-15/2/400), 0, 1e-9);
}

/* Every law goes from rest to rest, its derivatives agree with differences, its peaks and its copper loss with what is
 * stated; the peaks of VDI 2143. */
TEST(laws_of_motion)
{
    static const struct { const char *name; double speed, acceleration, loss; } known[] = {
        { "havsin", 1.5708, 4.9348, 12.176 }, { "step", 1.5, 6, 12 }, { "cycloid", 2, 6.2832, 19.739 },
        { "345", 1.875, 5.7735, 0 }, { "4567", 2.1875, 7.5132, 0 }, { "modified-sine", 1.7596, 5.5280, 0 },
        { "modified-trapezoid", 2, 4.8881, 0 }, { "trapezoid", 1.5, 4.5, 13.5 }, { "triangle", 2, 4, 16 } };
    enum { N = 20000 };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        int law = lw_motion_law_find(known[i].name);
        const lw_motion_law *about = lw_motion_law_get(law);
        CHECK(about != NULL);
        double peak[4] = { 0 }, loss = 0, end[4];
        for (int k = 0; k < N; k++) {
            double u = (k + 0.5)/N, h = 1e-6, here[4], ahead[4], behind[4];
            lw_motion_law_at(law, u, here);
            lw_motion_law_at(law, u + h, ahead);
            lw_motion_law_at(law, u - h, behind);
            for (int d = 0; d < 3; d++)
                if (fabs(ahead[d] - behind[d]) < 1e-3)     /* no step between */
                    CHECK_NEAR((ahead[d] - behind[d])/(2*h), here[d + 1], 1e-3, 1e-4);
            for (int d = 0; d < 4; d++)
                peak[d] = fmax(peak[d], fabs(here[d]));
            loss += here[2]*here[2]/N;
        }
        lw_motion_law_at(law, 1 - 1e-12, end);
        CHECK_NEAR(end[0], 1, 1e-11, 0);
        CHECK_NEAR(end[1], 0, 1e-10, 0);
        CHECK_NEAR(peak[1], about->speed_peak, 1e-4, 0);
        CHECK_NEAR(peak[2], about->acceleration_peak, 0, 1e-3);
        CHECK(isinf(about->jerk_peak) || fabs(peak[3] - about->jerk_peak) < 2e-3*about->jerk_peak);
        CHECK_NEAR(loss, about->copper_loss, 0, 1e-4);
        CHECK_NEAR(about->speed_peak, known[i].speed, 5e-5, 0);
        CHECK_NEAR(about->acceleration_peak, known[i].acceleration, 5e-5, 0);
        CHECK(known[i].loss == 0 || fabs(about->copper_loss - known[i].loss) < 5e-4);
    }
    CHECK(lw_motion_law_get(9) == NULL && lw_motion_law_find("cycloids") == -1);
}

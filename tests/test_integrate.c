/* tests/test_integrate.c - the method's coefficients against the order conditions, its convergence, its
 * continuous solution, events against closed forms, and what happens at the limits. */
#include "mbs/ode/integrate.h"
#include "mbs/ode/integrate_table_internal.h"
#include "tests/check.h"
#include "tests/ode_problems.h"
#include "base/vec2.h"

/* ---- order conditions: sum b_i Phi_i(tree) = 1/gamma(tree) for every rooted tree (Butcher 1963) ------- */

/* Phi (16) and density of the tree whose root is at place `at` of a level sequence; returns its end */
static int tree_value(const int *level, int n, int at, double *phi, double *gamma, int *size)
{
    int next = at + 1;
    *size = 1;
    *gamma = 1.0;
    for (int i = 0; i < 16; i++)
        phi[i] = 1.0;
    while (next < n && level[next] > level[at]) {
        double child[16], g;
        int s;
        next = tree_value(level, n, next, child, &g, &s);
        for (int i = 0; i < 16; i++) {
            double sum = 0.0;
            for (int j = 0; j < i && j < 15; j++)
                sum += rk_matrix[i][j]*child[j];
            phi[i] *= sum;
        }
        *gamma *= g;
        *size += s;
    }
    *gamma *= *size;
    return next;
}

/* next rooted tree in the order of Beyer & Hedetniemi 1980; false after the last */
static bool next_tree(int *level, int n)
{
    int p = n - 1;
    while (p > 0 && level[p] <= 1)
        p--;
    if (p <= 0)
        return false;
    int q = p - 1;
    while (level[q] != level[p] - 1)
        q--;
    for (int i = p; i < n; i++)
        level[i] = level[i - (p - q)];
    return true;
}

/* weights of the continuous solution at x, from its formula applied to one stage at a time */
static void dense_weights(double x, double *w)
{
    double z = 1.0 - x;
    for (int j = 0; j < 16; j++) {
        double rise = j < 12 ? rk_matrix[12][j] : 0.0, bend = (j == 0) - rise, c3 = rise - (j == 12) - bend;
        w[j] = x*(rise + z*(bend + x*(c3 + z*(rk_dense[0][j] + x*(rk_dense[1][j] + z*(rk_dense[2][j] + x*rk_dense[3][j]))))));
    }
}

TEST(order_conditions)
{
    int n_tree = 0;
    for (int order = 1; order <= 8; order++) {
        int level[8];
        for (int i = 0; i < order; i++)
            level[i] = i;
        do {
            double phi[16], gamma, step = 0.0, e5 = 0.0, e3 = 0.0;
            int size;
            tree_value(level, order, 0, phi, &gamma, &size);
            n_tree++;
            for (int i = 0; i < 12; i++) {
                step += rk_matrix[12][i]*phi[i];
                e5 += rk_error5[i]*phi[i];
                e3 += rk_error3[i]*phi[i];
            }
            CHECK_NEAR(step, 1.0/gamma, 2e-14, 0);
            if (order <= 5)
                CHECK_NEAR(e5, 0.0, 2e-14, 0);
            if (order <= 3)
                CHECK_NEAR(e3, 1.0/gamma, 2e-14, 0);
            for (double x = 0.125; order <= 7 && x < 1.0; x += 0.25) {
                double w[16], sum = 0.0;
                dense_weights(x, w);
                for (int i = 0; i < 16; i++)
                    sum += w[i]*phi[i];
                CHECK_NEAR(sum, pow(x, order)/gamma, 1e-13, 0);
            }
        } while (next_tree(level, order));
    }
    CHECK_INT(n_tree, 1 + 1 + 2 + 4 + 9 + 20 + 48 + 115);
    for (int i = 1; i < 16; i++) {
        double sum = 0.0;
        for (int j = 0; j < i && j < 15; j++)
            sum += rk_matrix[i][j];
        CHECK_NEAR(sum, rk_node[i], 2e-14, 0);
    }
}

/* ---- scenes -------------------------------------------------------------------------------------- */

static lw_status kepler(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    double r2 = y[0]*y[0] + y[1]*y[1], r3 = r2*sqrt(r2);
    dy[0] = y[2], dy[1] = y[3], dy[2] = -y[0]/r3, dy[3] = -y[1]/r3;
    return LW_OK;
}

/* place on the ellipse of axis 1, eccentricity e, at t after the nearest point */
static lw_vec2 kepler_exact(double e, double t)
{
    double u = t;
    for (int i = 0; i < 50; i++)
        u -= (u - e*sin(u) - t)/(1.0 - e*cos(u));
    return lw_v2(cos(u) - e, sqrt(1.0 - e*e)*sin(u));
}

static const double eccentricity = 0.3;
static void kepler_start(double *y)
{
    y[0] = 1.0 - eccentricity, y[1] = y[2] = 0.0;
    y[3] = sqrt((1.0 + eccentricity)/(1.0 - eccentricity));
}

static lw_status run_to(lw_integrator *w, double t)
{
    lw_ode_stop stop = LW_ODE_STEP;
    lw_error e;
    lw_status s = LW_OK;
    while (s == LW_OK && stop != LW_ODE_END)
        s = lw_integrate_step(w, t, &stop, &e);
    return s;
}

static double kepler_error(double step, double *dense_error)
{
    lw_ode ode = { .n = 4, .rate = kepler };
    lw_ode_options o = { .fixed = step };
    lw_integrator w;
    double y[4], work[LW_INTEGRATE_WORK(4, 0)];
    kepler_start(y);
    CHECK_INT((int)lw_integrate_work(4, 0), 4*68);
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
    *dense_error = 0.0;
    lw_ode_stop stop = LW_ODE_STEP;
    while (stop != LW_ODE_END) {
        if (lw_integrate_step(&w, 6.4, &stop, NULL) != LW_OK)
            return NAN;
        double half = w.t - 0.4*(w.t - w.t_old), d[4];
        lw_integrate_dense(&w, half, d);
        lw_vec2 p = kepler_exact(eccentricity, half);
        *dense_error = fmax(*dense_error, hypot(d[0] - p.x, d[1] - p.y));
    }
    lw_vec2 p = kepler_exact(eccentricity, 6.4);
    return hypot(w.y[0] - p.x, w.y[1] - p.y);
}

TEST(converges_with_order_8)
{
    double d1, d2, e1 = kepler_error(0.1, &d1), e2 = kepler_error(0.05, &d2);
    double order = log2(e1/e2), dense = log2(d1/d2);
    CHECK(e2 < 1e-11);
    CHECK(order > 7.6 && order < 9.5);
    CHECK(dense > 6.7 && dense < 9.5);
}

/* A run to 40 with control of the step: its error. */
static double controlled_error(double tolerance, bool smooth, lw_integrator *w)
{
    static lw_ode ode = { .n = 4, .rate = kepler };
    static double y[4], work[LW_INTEGRATE_WORK(4, 0)];
    lw_ode_options o = lw_ode_options_default();
    o.relative = o.absolute = tolerance;
    o.smooth = smooth;
    kepler_start(y);
    CHECK_INT(lw_integrate_start(w, &ode, &o, work, 0.0, y, NULL), LW_OK);
    CHECK_INT(run_to(w, 40.0), LW_OK);
    lw_vec2 p = kepler_exact(eccentricity, 40.0);
    return hypot(w->y[0] - p.x, w->y[1] - p.y);
}

TEST(error_follows_tolerance)
{
    double before = 1.0;
    for (double tolerance = 1e-5; tolerance > 1e-13; tolerance *= 0.1) {
        lw_integrator w;
        double error = controlled_error(tolerance, false, &w);
        CHECK(error < 1000.0*tolerance);
        CHECK(error < 2.0*before);
        CHECK(w.t == 40.0);
        CHECK(w.n_rate <= 12*(w.n_step + w.n_refused) + 2);
        before = error;
        CHECK_INT(run_to(&w, 0.0), LW_OK);                   /* and back */
        CHECK_NEAR(w.y[0], 1.0 - eccentricity, 2000.0*tolerance, 0);
    }
}

/* Within a step the solution is as accurate as at its end, to a few times the error allowed: the motion is fast near the centre.  Many states in
 * a step cost no more evaluations than a few. */
TEST(accurate_within_steps)
{
    const double e = 0.9;
    for (double tolerance = 1e-4; tolerance > 1e-13; tolerance *= 0.1) {
        lw_ode ode = { .n = 4, .rate = kepler };
        lw_ode_options o = lw_ode_options_default(), fine = o;
        lw_integrator w, exact;
        double y[4] = { 1.0 - e, 0.0, 0.0, sqrt((1.0 + e)/(1.0 - e)) }, work[LW_INTEGRATE_WORK(4, 0)], work2[LW_INTEGRATE_WORK(4, 0)];
        lw_ode_stop stop = LW_ODE_STEP;
        o.relative = o.absolute = tolerance;
        fine.relative = fine.absolute = 1e-14;
        CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
        while (stop != LW_ODE_END && lw_integrate_step(&w, 7.0, &stop, NULL) == LW_OK)
            for (int k = 1; k < 32; k++) {
                double t = w.t_old + (w.t - w.t_old)*k/32, d[4];
                CHECK_INT(lw_integrate_dense(&w, t, d), LW_OK);
                if (k % 4)
                    continue;
                CHECK_INT(lw_integrate_start(&exact, &ode, &fine, work2, w.t_old, w.y_old, NULL), LW_OK);
                CHECK_INT(run_to(&exact, t), LW_OK);
                for (int i = 0; i < 4; i++)
                    CHECK_NEAR(d[i], exact.y[i], 8.0*tolerance, 8.0*tolerance);
            }
        CHECK(w.n_rate < 80*w.n_step);
    }
}

/* Where f is known to all digits the control told so refuses fewer steps, and errors stay as small. */
TEST(smooth_control)
{
    long refused[2] = { 0 };
    for (int smooth = 0; smooth < 2; smooth++)
        for (double tolerance = 1e-5; tolerance > 1e-13; tolerance *= 0.1) {
            lw_integrator w;
            CHECK(controlled_error(tolerance, smooth, &w) < 1000.0*tolerance);
            refused[smooth] += w.n_refused;
        }
    CHECK(2*refused[1] < refused[0]);
}

/* Steps that stability limits (y' = -200 (y - cos t) - sin t, y = cos t) are hardly ever refused, and are as long as it allows: 6.1/200. */
static lw_status fast_decay(void *context, double t, const double *y, double *dy)
{
    (void)context;
    dy[0] = -200.0*(y[0] - cos(t)) - sin(t);
    return LW_OK;
}

TEST(stable_steps_are_not_refused)
{
    for (int smooth = 0; smooth < 2; smooth++)
        for (double tolerance = 1e-3; tolerance > 5e-6; tolerance *= 0.1) {
            lw_ode ode = { .n = 1, .rate = fast_decay };
            lw_ode_options o = lw_ode_options_default();
            lw_integrator w;
            double y = 1.0, work[LW_INTEGRATE_WORK(1, 0)];
            o.relative = o.absolute = tolerance, o.smooth = smooth;
            CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, &y, NULL), LW_OK);
            CHECK_INT(run_to(&w, 20.0), LW_OK);
            CHECK_NEAR(w.y[0], cos(20.0), 10.0*tolerance, 0);
            CHECK(100*w.n_refused < w.n_step && w.n_step < 1.1*20.0*200.0/6.1);
        }
}

/* 1e4 periods with steps far below the truncation error: only rounding is left.  Without the compensated sum
 * the error is some 1e-13 larger by an order; with it, it stays near that of the place of 2 pi n in t. */
TEST(rounding_does_not_grow)
{
    lw_ode ode = { .n = 2, .rate = oscillator };
    lw_ode_options o = { .fixed = LW_PI/100.0 };
    lw_integrator w;
    double y[2] = { 1.0, 0.0 }, work[LW_INTEGRATE_WORK(2, 0)], t_end = 2.0*LW_PI*10000.0;
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
    CHECK_INT(run_to(&w, t_end), LW_OK);
    CHECK_NEAR(w.y[0]*w.y[0] + w.y[1]*w.y[1], 1.0, 4e-13, 0);
    CHECK_NEAR(w.y[1], 0.0, 4e-12, 0);                       /* t itself is good to 7e-12 only */
}

/* ---- events -------------------------------------------------------------------------------------- */

typedef struct seen_list { int n, event[64]; double t[64]; } seen_list;
static void note(void *context, int event, double t, const double *y)
{
    (void)y;
    seen_list *l = context;
    if (l->n < 64)
        l->event[l->n] = event, l->t[l->n++] = t;
}

TEST(zeros_of_the_cosine)
{
    for (double tolerance = 1e-6; tolerance > 1e-13; tolerance *= 0.01) {
        lw_ode ode = { .n = 2, .rate = oscillator, .n_event = 2, .event = two_levels, .direction = { 0, -1 } };
        lw_ode_options o = { .relative = 1e-13, .absolute = tolerance, .greatest = 2.5 };
        lw_integrator w;
        double y[2] = { 1.0, 0.0 }, work[LW_INTEGRATE_WORK(2, 2)];
        CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
        lw_ode_stop stop;
        double want[] = { LW_PI/3, LW_PI/2, 3*LW_PI/2, 7*LW_PI/3, 5*LW_PI/2, 7*LW_PI/2 };
        int event[] = { 1, 0, 0, 1, 0, 0 }, k = 0;
        while (lw_integrate_step(&w, 12.0, &stop, NULL) == LW_OK && stop != LW_ODE_END)
            if (stop == LW_ODE_EVENT && k < 6) {
                CHECK_INT((int)w.events, 1 << event[k]);
                CHECK_NEAR(w.t, want[k], 10.0*tolerance + 1e-12, 0);
                CHECK_NEAR(event[k] ? w.y[0] - 0.5 : w.y[0], 0.0, 1e-14, 0);
                k++;
            }
        CHECK_INT(k, 6);
    }
}

/* passing events are told in the order of time and do not disturb the run */
TEST(passing_events)
{
    seen_list l = { 0 };
    lw_ode ode = { .n = 2, .context = &l, .rate = oscillator, .n_event = 2, .event = two_levels,
                   .passing = { true, true }, .direction = { 1, 0 }, .seen = note };
    lw_ode_options o = lw_ode_options_default();
    o.relative = o.absolute = 1e-12;
    lw_integrator w, plain;
    double y[2] = { 1.0, 0.0 }, work[LW_INTEGRATE_WORK(2, 2)], work2[LW_INTEGRATE_WORK(2, 2)];
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
    CHECK_INT(run_to(&w, 10.0), LW_OK);
    double want[] = { LW_PI/3, 3*LW_PI/2, 5*LW_PI/3, 7*LW_PI/3 };
    int event[] = { 1, 0, 1, 1 };
    CHECK_INT(l.n, 4);
    for (int k = 0; k < 4 && k < l.n; k++) {
        CHECK_INT(l.event[k], event[k]);
        CHECK_NEAR(l.t[k], want[k], 1e-11, 0);
    }
    ode.n_event = 0;
    CHECK_INT(lw_integrate_start(&plain, &ode, &o, work2, 0.0, y, NULL), LW_OK);
    CHECK_INT(run_to(&plain, 10.0), LW_OK);
    CHECK(plain.y[0] == w.y[0] && plain.n_step == w.n_step);
}

static lw_status falling(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1], dy[1] = -9.81;
    return LW_OK;
}

static lw_status ground(void *context, double t, const double *y, double *g)
{
    (void)context, (void)t;
    g[0] = y[0];
    return LW_OK;
}

/* A ball dropped from 1 m, restitution r: bounce k is at t0 (1 + 2 (r + ... + r^k)), t0 = sqrt(2/g). */
TEST(bouncing_ball)
{
    lw_ode ode = { .n = 2, .rate = falling, .n_event = 1, .event = ground, .direction = { -1 } };
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    double y[2] = { 1.0, 0.0 }, work[LW_INTEGRATE_WORK(2, 2)], r = 0.7, t0 = sqrt(2.0/9.81), sum = 1.0, power = 1.0;
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
    for (int k = 0; k < 40; k++) {
        lw_ode_stop stop = LW_ODE_STEP;
        while (stop == LW_ODE_STEP)
            CHECK_INT(lw_integrate_step(&w, 10.0, &stop, NULL), LW_OK);
        CHECK(stop == LW_ODE_EVENT);
        CHECK_NEAR(w.t, t0*sum, 1e-12, 0);
        double after[2] = { 0.0, -r*w.y[1] };
        CHECK_INT(lw_integrate_restart(&w, after, NULL), LW_OK);
        power *= r;
        sum += 2.0*power;
    }
}

/* Touching within one long step: sin t - 0.9 is above 0 for a short while only */
static lw_status peak(void *context, double t, const double *y, double *g)
{
    (void)context, (void)y;
    g[0] = sin(t) - 0.9;
    g[1] = t - 2.0, g[2] = 2.0*(t - 2.0);
    return LW_OK;
}

static lw_status above(void *context, double t, const double *y, double *g)
{
    (void)t;
    *g = *(const double *)context + y[0];
    return LW_OK;
}

/* An oscillator that dips below a level by a little, once each turn: all dips are found, in whatever part of a step they
 * are, and those that end just above it are none. */
TEST(grazing)
{
    lw_rng rng = check_rng(9);
    for (int trial = 0; trial < 400; trial++) {
        lw_ode_options o = lw_ode_options_default();
        o.relative = o.absolute = pow(10, lw_rng_range(&rng, -13, -5));
        double phase = lw_rng_range(&rng, 0.1, 3), least = fmax(1e-8, 1e3*o.relative);      /* else the error hides it */
        double depth = least*pow(0.1/least, lw_rng_range(&rng, 0, 1))*(trial%4 ? 1 : -1), level = 1 - depth;
        double y[2] = { cos(phase), -sin(phase) }, work[LW_INTEGRATE_WORK(2, 2)], half = depth > 0 ? acos(level) : 0;
        lw_ode ode = { .n = 2, .context = &level, .rate = oscillator, .n_event = 1, .event = above, .direction = { -1 } };
        lw_integrator w;
        lw_ode_stop stop = LW_ODE_STEP;
        int n = 0, all = depth > 0 ? (int)((20 + phase + half + LW_PI)/(2*LW_PI)) : 0;
        if (cos(phase) + level < 0)
            continue;
        CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0, y, NULL), LW_OK);
        while (stop != LW_ODE_END && lw_integrate_step(&w, 20, &stop, NULL) == LW_OK) {
            if (stop != LW_ODE_EVENT)
                continue;
            CHECK_NEAR(w.t, LW_PI*(2*n++ + 1) - half - phase, 1e2*o.relative/half + 1e-9, 0);
            CHECK_INT(lw_integrate_restart(&w, NULL, NULL), LW_OK);
        }
        CHECK_INT(stop, LW_ODE_END);
        CHECK_INT(n, all);
    }
}

TEST(crossings_within_a_step_and_at_once)
{
    lw_ode ode = { .n = 2, .rate = oscillator, .n_event = 3, .event = peak };
    lw_ode_options o = { .fixed = 1.8 };
    lw_integrator w;
    double y[2] = { 1.0, 0.0 }, work[LW_INTEGRATE_WORK(2, 3)];
    lw_ode_stop stop;
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.6, y, NULL), LW_OK);
    CHECK_INT(lw_integrate_step(&w, 5.0, &stop, NULL), LW_OK);
    CHECK(stop == LW_ODE_EVENT && w.events == 1);
    CHECK_NEAR(w.t, asin(0.9), 1e-14, 0);
    CHECK_INT(lw_integrate_step(&w, 5.0, &stop, NULL), LW_OK);
    CHECK(stop == LW_ODE_EVENT && w.events == 6);            /* both at t = 2, */
    CHECK_NEAR(w.t, LW_PI - asin(0.9) < 2.0 ? NAN : 2.0, 1e-14, 0);
    CHECK_INT(lw_integrate_step(&w, 5.0, &stop, NULL), LW_OK);
    CHECK(stop == LW_ODE_EVENT && w.events == 1);            /* then the way down */
    CHECK_NEAR(w.t, LW_PI - asin(0.9), 1e-14, 0);
}

/* ---- projection, limits, bad input --------------------------------------------------------------- */

TEST(projection_keeps_constraints)
{
    lw_ode ode = { .n = 4, .rate = pendulum, .project = onto_circle };
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    double y[4] = { 1.0, 0.0, 0.0, 0.0 }, work[LW_INTEGRATE_WORK(4, 0)];
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL), LW_OK);
    CHECK_INT(run_to(&w, 20.0), LW_OK);
    CHECK_NEAR(hypot(w.y[0], w.y[1]), 1.0, 4e-16, 0);
    CHECK_NEAR(0.5*(w.y[2]*w.y[2] + w.y[3]*w.y[3]) + 9.81*w.y[1], 0.0, 2e-6, 0);
}

static lw_status walled(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    if (y[0] < 0.0)
        return LW_OPEN;
    dy[0] = -2.0*sqrt(y[0]);                                 /* (1 - t)^2, no meaning beyond 0 */
    return LW_OK;
}

TEST(limits_are_said)
{
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    lw_error e;
    double y[1] = { 1.0 }, work[LW_INTEGRATE_WORK(1, 0)];
    lw_ode_stop stop;
    struct { lw_status (*rate)(void *, double, const double *, double *); lw_status want; double t; } row[] = {
        { explodes, LW_E_NUMERIC, 1.0 }, { walled, LW_E_NUMERIC, 1.0 }, { breaks, LW_E_KIND, 0.5 } };
    for (int i = 0; i < 3; i++) {
        lw_ode ode = { .n = 1, .rate = row[i].rate };
        CHECK_INT(lw_integrate_start(&w, &ode, &o, work, 0.0, y, &e), LW_OK);
        lw_status s = LW_OK;
        while (s == LW_OK && w.t < 2.0)
            s = lw_integrate_step(&w, 2.0, &stop, &e);
        CHECK_INT(s, row[i].want);
        CHECK(w.t <= row[i].t + 1e-6 && w.t >= (i < 2 ? 0.99 : 0.0));
        CHECK(strlen(e.text) > 20 && isfinite(w.y[0]));
    }
    lw_ode ode = { .n = 2, .rate = oscillator };
    double y2[2] = { 1, 0 }, work2[LW_INTEGRATE_WORK(2, 0)];
    o.max_step = 10;
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work2, 0.0, y2, &e), LW_OK);
    CHECK_INT(run_to(&w, 1e6), LW_STOPPED);
    CHECK(w.t > 0.0 && w.n_step + w.n_refused == 10);
    o = (lw_ode_options){ 0 };
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work2, 0.0, y2, &e), LW_E_ARG);
    o = lw_ode_options_default();
    ode.n_event = LW_EVENT_MAX + 1;
    CHECK_INT(lw_integrate_start(&w, &ode, &o, work2, 0.0, y2, &e), LW_E_ARG);
}

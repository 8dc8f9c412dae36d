/* Stations along a path and smoothing: invariants, and the least of what is minimised. */
#include <math.h>

#include "optimise/task/target_outline_internal.h"
#include "tests/check.h"

/* A random closed or open polygon with a few sharp corners on a smooth curve. */
static size_t draw(lw_rng *rng, lw_vec2 *p)
{
    size_t n = 20 + (size_t)(lw_rng_uniform(rng)*180);
    double a = 0.2 + lw_rng_uniform(rng), b = lw_rng_uniform(rng);
    for (size_t i = 0; i < n; i++) {
        double u = 2*LW_PI*(double)i/(double)n;
        p[i] = lw_v2(cos(u) + b*cos(2*u), a*sin(u) + 0.3*fabs(sin(3*u)));
    }
    return n;
}

static double off_polygon(lw_vec2 q, const lw_vec2 *p, size_t n, bool closed)
{
    double least = INFINITY;
    for (size_t i = 0; i + !closed < n; i++)
        least = fmin(least, lw_v2_segment_distance(q, p[i], p[(i + 1) % n]));
    return least;
}

TEST(stations_lie_on_the_path)
{
    lw_rng rng = check_rng(0);
    for (int trial = 0; trial < 200; trial++) {
        lw_vec2 p[200], out[300];
        size_t from[300], n = draw(&rng, p), m = 2 + (size_t)(lw_rng_uniform(&rng)*298);
        bool closed = trial % 2, by_curvature = trial % 4 < 2;
        double length = 0, longest = 0;
        CHECK_OK(lw_resample(p, n, closed, by_curvature, m, out, from, &check_error));
        for (size_t i = 0; i + !closed < n; i++)
            length += lw_v2_norm(lw_v2_sub(p[(i + 1) % n], p[i]));
        for (size_t i = 0; i < m; i++) {
            CHECK_NEAR(off_polygon(out[i], p, n, closed), 0, 1e-14, 0);
            CHECK(from[i] < n && (i == 0 || from[i] + (closed ? n : 0) >= from[i-1]));
            if (i + !closed < m)
                longest = fmax(longest, lw_v2_norm(lw_v2_sub(out[(i + 1) % m], out[i])));
        }
        if (!closed) {
            CHECK(out[0].x == p[0].x && out[0].y == p[0].y);
            CHECK(out[m-1].x == p[n-1].x && out[m-1].y == p[n-1].y);
        }
        /* corners take a third of the stations at most, and of the others two thirds follow the length */
        CHECK(m < 12 || longest <= 2.5*length/(double)(closed ? m : m - 1));
    }
}

TEST(corners_are_kept)
{
    static const lw_vec2 square[] = { { 0, 0 }, { 3, 0 }, { 3, 1 }, { 0, 1 } };
    for (size_t m = 9; m < 100; m++) {
        lw_vec2 out[100];
        size_t from[100];
        int found = 0;
        CHECK_OK(lw_resample(square, 4, true, true, m, out, from, &check_error));
        for (size_t i = 0; i < m; i++)
            for (int k = 0; k < 4; k++)
                found += out[i].x == square[k].x && out[i].y == square[k].y;
        CHECK_INT(found, 4);
    }
}

/* ---- smoothing ----------------------------------------------------------------------------------------------- */

static void noisy_circle(lw_rng *rng, size_t n, double noise, double *x, double *y)
{
    for (size_t i = 0; i < n; i++) {
        double u = 2*LW_PI*((double)i + 0.3*lw_rng_uniform(rng))/(double)n;
        x[i] = cos(u) + noise*(2*lw_rng_uniform(rng) - 1);
        y[i] = sin(u) + noise*(2*lw_rng_uniform(rng) - 1);
    }
}

TEST(noise_goes)
{
    double all_before = 0, all_after = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 50; trial++) {
        double x[300], y[300], from[2][300], rms, most, noise = 0.01, before = 0, after = 0, worst = 0;
        size_t n = 100 + 4*(size_t)trial;
        noisy_circle(&rng, n, noise, x, y);
        memcpy(from[0], x, sizeof x);
        memcpy(from[1], y, sizeof y);
        CHECK_OK(lw_smooth(x, y, n, trial % 2, 1.2*noise, &rms, &most, &check_error));
        for (size_t i = 0; i < n; i++) {
            double d = hypot(x[i] - from[0][i], y[i] - from[1][i]);
            worst = fmax(worst, d);
            before += pow(hypot(from[0][i], from[1][i]) - 1, 2);
            after += pow(hypot(x[i], y[i]) - 1, 2);
        }
        CHECK_NEAR(worst, most, 1e-12, 0);
        CHECK(most <= 1.2*noise*(1 + 1e-9) && most > noise/2 && rms < most);
        all_before += before;
        all_after += after;
    }
    CHECK(all_after < 0.3*all_before);                /* the variance that is left, over all trials */
}

/* The noise of ellipses and of open arcs, drawn at uneven steps along them, beside which these steps alone count as noise where it is
 * smaller; a path of even steps without noise has next to none. */
TEST(noise_is_estimated)
{
    double all = 0;
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 60; trial++) {
        double x[3][300], y[3][300], work[300], noise = pow(10, lw_rng_range(&rng, -3.5, -1.5)), turn = trial % 2 ? 2*LW_PI : 4, got[3];
        size_t n = 60 + 4*(size_t)trial;
        for (size_t i = 0; i < n; i++) {
            double uneven = 0.2*lw_rng_uniform(&rng);
            for (int k = 0; k < 3; k++) {                  /* with noise, uneven alone, even                      */
                double u = turn*((double)i + (k < 2 ? uneven : 0))/(double)n;
                x[k][i] = 2*cos(u) + (k == 0 ? noise*lw_rng_normal(&rng) : 0);
                y[k][i] = sin(u) + (k == 0 ? noise*lw_rng_normal(&rng) : 0);
            }
        }
        for (int k = 0; k < 3; k++)
            got[k] = lw_noise(x[k], y[k], n, trial % 2, work);
        CHECK(got[2] < 1e-5);
        CHECK(got[0] > 0.3*noise && got[0] < 2.5*noise + got[1]);
        all += got[0]/noise/60;
    }
    CHECK(all > 0.8 && all < 1.15);
}

/* Neither the place of the first point of a closed curve, nor the direction, nor a turn of the plane matters. */
TEST(smoothing_is_invariant)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 50; trial++) {
        double x[60], y[60], u[60], v[60], rms, most, again, c = cos(trial), s = sin(trial);
        size_t n = 6 + (size_t)trial, shift = (size_t)(lw_rng_uniform(&rng)*(double)n);
        bool closed = trial % 3, back = trial % 2;
        noisy_circle(&rng, n, 0.05, x, y);
        for (size_t i = 0; i < n; i++) {
            size_t k = ((back ? n - 1 - i : i) + (closed ? shift : 0)) % n;
            u[i] = c*x[k] - s*y[k] + 7;
            v[i] = s*x[k] + c*y[k] - 3;
        }
        CHECK_OK(lw_smooth(x, y, n, closed, 0.04, &rms, &most, &check_error));
        CHECK_OK(lw_smooth(u, v, n, closed, 0.04, &rms, &again, &check_error));
        CHECK_NEAR(most, again, 1e-7, 0);
        for (size_t i = 0; i < n; i++) {
            size_t k = ((back ? n - 1 - i : i) + (closed ? shift : 0)) % n;
            CHECK_NEAR(u[i], c*x[k] - s*y[k] + 7, 1e-7, 0);
            CHECK_NEAR(v[i], s*x[k] + c*y[k] - 3, 1e-7, 0);
        }
    }
}

/* The integral of the squared second derivative of the natural (or periodic) cubic spline through z, from the
 * tridiagonal equations of its second derivatives, solved by Gauss's method. */
static double energy(const double *h, const double *z, size_t n, bool closed)
{
    static double a[64][65];
    double sum = 0;
    size_t m = closed ? n : n - 2, o = !closed;
    memset(a, 0, sizeof a);
    for (size_t i = 0; i < m; i++) {
        size_t k = i + o, b = (k + n - 1) % n, f = (k + 1) % n;
        a[i][i] += (h[b] + h[k])/3;
        if (closed || i > 0)
            a[i][(i + m - 1) % m] += h[b]/6;
        if (closed || i + 1 < m)
            a[i][(i + 1) % m] += h[k]/6;
        a[i][m] = (z[f] - z[k])/h[k] - (z[k] - z[b])/h[b];
    }
    double r[64];
    for (size_t i = 0; i < m; i++)
        r[i] = a[i][m];
    for (size_t i = 0; i < m; i++)
        for (size_t k = 0; k < m; k++)
            if (k != i) {
                double f = a[k][i]/a[i][i];
                for (size_t j = i; j <= m; j++)
                    a[k][j] -= f*a[i][j];
            }
    for (size_t i = 0; i < m; i++)
        sum += r[i]*a[i][m]/a[i][i];
    return sum;
}

/* At the least of |z - p|^2 + lambda energy(z), the gradient of the energy is proportional to what the points moved. */
TEST(smoothing_is_least)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 20; trial++) {
        double x[40], y[40], from[2][40], h[40], rms, most, lambda = 0, greatest = 0;
        size_t n = 8 + (size_t)trial;
        bool closed = trial % 2;
        noisy_circle(&rng, n, 0.05, x, y);
        memcpy(from[0], x, sizeof x);
        memcpy(from[1], y, sizeof y);
        for (size_t i = 0; i < n; i++)
            h[i] = hypot(x[(i + 1) % n] - x[i], y[(i + 1) % n] - y[i]);
        CHECK_OK(lw_smooth(x, y, n, closed, 0.03, &rms, &most, &check_error));
        for (int round = 0; round < 2; round++)
            for (size_t i = 0; i < n; i++) {
                double step = 1e-4, kept = x[i];
                x[i] = kept + step;
                double up = energy(h, x, n, closed);
                x[i] = kept - step;
                double down = energy(h, x, n, closed), g = (up - down)/(2*step), moved = from[0][i] - kept;
                x[i] = kept;
                if (round == 0 && fabs(moved) > greatest) {      /* lambda from the point that moved most */
                    greatest = fabs(moved);
                    lambda = 2*moved/g;
                }
                if (round == 1)
                    CHECK_NEAR(2*moved, lambda*g, 1e-6, 0);
            }
    }
}

TEST(smoothing_leaves_lines)
{
    double x[50], y[50], rms, most;
    for (int i = 0; i < 50; i++) {
        x[i] = i + 0.2*sin(i);
        y[i] = 3*x[i] - 1;
    }
    CHECK_OK(lw_smooth(x, y, 50, false, 0.1, &rms, &most, &check_error));
    CHECK_NEAR(most, 0, 1e-9, 0);
    CHECK_OK(lw_smooth(x, y, 4, true, 0.1, &rms, &most, &check_error));      /* too few to be smoothed */
    CHECK_NEAR(most, 0, 0, 0);
}

/* Slider-crank with a flexible coupler: Lagrange's equations by differences of the mass matrix, published end values. */
#include <math.h>
#include "cli/bench/flexible_crank.h"
#include "tests/check.h"

enum { N = LW_FLEXIBLE_N };

static lw_flexible_crank c;

static double kinetic2(const double *p, const double *v)
{
    double m[N*N], sum = 0;
    lw_flexible_crank_mass(&c, p, m);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            sum += v[i]*m[i*N + j]*v[j];
    return sum;
}

/* f = 1/2 d(v^T M v)/dp - dM/dt v - K q, with central differences of M. */
TEST(lagrange)
{
    lw_rng rng;
    lw_rng_seed(&rng, 1, 0);
    for (int trial = 0; trial < 200; trial++) {
        double p[N], v[N], f[N], on[N], back[N], ahead_m[N*N], back_m[N*N], h = 1e-5;
        for (int i = 0; i < N; i++) {
            p[i] = (i < 3 ? 3 : 0.1)*(2*lw_rng_uniform(&rng) - 1);
            v[i] = 2*lw_rng_uniform(&rng) - 1;
        }
        lw_flexible_crank_force(&c, p, v, f);
        for (int i = 0; i < N; i++)
            on[i] = p[i] + h*v[i], back[i] = p[i] - h*v[i];
        lw_flexible_crank_mass(&c, on, ahead_m);
        lw_flexible_crank_mass(&c, back, back_m);
        for (int i = 0; i < N; i++) {
            double want = 0, elastic = 0, q[N];
            for (int j = 0; j < N; j++)
                want -= (ahead_m[i*N + j] - back_m[i*N + j])/(2*h)*v[j];
            memcpy(q, p, sizeof q);
            q[i] = p[i] + h, want += kinetic2(q, v)/(4*h);
            q[i] = p[i] - h, want -= kinetic2(q, v)/(4*h);
            for (int j = 0; i >= 3 && j < 4; j++)
                elastic += c.stiffness[i - 3][j]*p[3 + j];
            CHECK_NEAR(f[i] + elastic, want, 1e-10 + 1e-15*fabs(elastic), 1e-8);
            for (int j = 0; j < N; j++)
                CHECK_NEAR(ahead_m[i*N + j], ahead_m[j*N + i], 0, 0);
        }
    }
}

TEST(rows)
{
    double p[N] = { 0.3, -0.2, 0.4, 0.01, 0.02, -0.03, 0.04 }, phi[3], g[3*N], ahead[3], back[3], h = 1e-6;
    lw_flexible_crank_rows(&c, 0.1, p, phi, g);
    for (int i = 0; i < N; i++) {
        double q[N];
        memcpy(q, p, sizeof q);
        q[i] = p[i] + h, lw_flexible_crank_rows(&c, 0.1, q, ahead, NULL);
        q[i] = p[i] - h, lw_flexible_crank_rows(&c, 0.1, q, back, NULL);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(g[k*N + i], (ahead[k] - back[k])/(2*h), 1e-9, 0);
    }
}

/* Mazzia & Magherini 2008, problem "slider crank", t = 0.1: good to 3e-8 of each elastic coordinate, as the start is printed with
 * nine digits only. */
TEST(published)
{
    static const double want[N] = { 15.00000000000104, -0.3311734988256260, 0.1697373328427860, 0.1893192899613509e-3,
                                    0.2375751249879174e-4, -0.5323896770569702e-5, -0.8363313279112129e-5 };
    static const double tolerance[] = { 1e-12, 1e-12, 1e-11, 1e-7 };
    static const double allowed[] = { 4e-8, 2e-7, 1e-5, 1.5e-2 };
    for (int k = 0; k < LW_FLEXIBLE_METHODS; k++) {
        lw_flexible_run r;
        double phi[3];
        CHECK_OK(lw_flexible_crank_run(&c, (lw_flexible_method)k, tolerance[k], 0.1, &r, &check_error));
        for (int i = 0; i < N; i++)
            CHECK_NEAR(r.p[i], want[i], i < 3 ? k == LW_FLEXIBLE_GGL ? 1e-7 : 1e-9 : 0, i < 3 ? 0 : allowed[k]);
        lw_flexible_crank_rows(&c, 0.1, r.p, phi, NULL);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(phi[i], 0, k == LW_FLEXIBLE_GGL ? 1e-8 : 1e-11, 0);
        CHECK(r.steps > 100 && r.rates > r.steps);
    }
}

CHECK_MAIN
{
    lw_flexible_crank_published(&c);
    check_run();
    return check_end();
}

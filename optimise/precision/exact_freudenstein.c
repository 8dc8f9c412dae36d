/* optimise/precision/exact_freudenstein.c - four-bars that generate a function at three to five pairs of angles.
 *
 * Three pairs, angles counted from the frame: Freudenstein's equation (1955)
 *
 *     K1 cos psi - K2 cos phi + K3 = cos(phi - psi),   K1 = 1/r2,  K2 = 1/r4,
 *     K3 = (1 + r2^2 + r4^2 - r3^2) / (2 r2 r4)
 *
 * is linear in K1, K2, K3.  Offsets of the angles make it nonlinear.  But seen from the input link, the output link
 * is a body that moves through poses, and the coupler is one of its guides.  Five pairs are five poses with up to
 * four guides: the known ground link and up to three couplers.  Four pairs and a given offset are four poses and a
 * line on which the guide's fixed (or moving) pin lies. */
#include "optimise/precision/exact_internal.h"

#include <string.h>
#include "base/linalg.h"

#define SAME 1e-7          /* a guide that is the ground link; links shorter are none          */

/* The output link seen from the input link: its ground pin and its turn, for frame 1. */
static void inverted(size_t n, const double *angle, const double *theta, lw_vec2 *p, double *turn)
{
    for (size_t j = 0; j < n; j++) {
        p[j] = lw_v2_polar(1, -angle[j]);
        turn[j] = theta[j] - angle[j];
    }
}

static void add(lw_function_bar bar, lw_function_bar *out, int *n)
{
    for (int i = 0; i < 4; i++)
        if (!(bar.length[i] > SAME && bar.length[i] < 1/SAME))
            return;
    if (*n < LW_FREUDENSTEIN_MAX)
        out[(*n)++] = bar;
}

/* The coupler as a guide: its fixed pin is on the input link, the moving one on the output. */
static void add_guide(const lw_guide *g, const double *angle, const double *theta, lw_function_bar *out, int *n)
{
    if (g->kind != LW_GUIDE_RR)
        return;
    lw_vec2 u = lw_v2_polar(1, theta[0] - angle[0]), q = lw_v2_turn(g->point, u);
    lw_vec2 coupler = lw_v2_sub(lw_v2_add(lw_v2_polar(1, -angle[0]), q), g->centre);
    lw_function_bar bar = {
        .length = { 1, lw_v2_norm(g->centre), lw_v2_norm(coupler), lw_v2_norm(g->point) },
        .input0 = angle[0] + atan2(g->centre.y, g->centre.x),
        .output0 = theta[0] + atan2(g->point.y, g->point.x)
    };
    add(bar, out, n);
}

static lw_status three(const double *angle, const double *theta, lw_function_bar *out, int *n, lw_error *e)
{
    double a[9], d[3], k[3];
    for (int j = 0; j < 3; j++) {
        a[j] = cos(theta[j]);
        a[j + 3] = -cos(angle[j]);
        a[j + 6] = 1;
        k[j] = cos(angle[j] - theta[j]);
    }
    if (!(lw_qr_factor(3, 3, a, d) > 1e-13))
        return lw_error_set(e, LW_E_NUMERIC, "the three pairs do not fix a four-bar: cos(angle) and cos(theta) lie on a line");
    lw_qr_solve(3, 3, a, d, k);
    double r2 = 1/k[0], r4 = 1/k[1], square = 1 + r2*r2 + r4*r4 - 2*r2*r4*k[2];
    lw_function_bar bar = {
        .length = { 1, fabs(r2), square > 0 ? sqrt(square) : 0, fabs(r4) },
        .input0 = angle[0] + (r2 < 0 ? LW_PI : 0), .output0 = theta[0] + (r4 < 0 ? LW_PI : 0)
    };
    add(bar, out, n);
    return LW_OK;
}

/* Four pairs: the offset of the input is free and the output's is 0, or vice versa. */
static void four(const lw_guide_rows *poses, bool input_free, const double *angle, const double *theta, lw_function_bar *out, int *n)
{
    lw_guide_rows r = *poses;
    lw_guide guide[4];
    lw_vec2 u = lw_v2_polar(1, theta[0] - angle[0]);
    double row[LW_GUIDE_Z] = { r.origin.y/r.unit, 0, 0, 0, 1, 0, 0 };       /* w, kx, ky, gx, gy, u, v:     */
    if (input_free) {                                                  /* the pin on the output's x axis, */
        memset(row, 0, sizeof row);
        row[1] = -u.y;
        row[2] = u.x;
    }                                                                  /* or on the input's               */
    int found = lw_guide_rows_add(&r, row) ? lw_guide_rows_solve(&r, guide) : 0;
    for (int i = 0; i < found; i++)
        add_guide(&guide[i], angle, theta, out, n);
}

lw_status lw_freudenstein(size_t n, const double *angle, const double *theta,
                          lw_function_bar out[LW_FREUDENSTEIN_MAX], int *n_out, lw_error *e)
{
    lw_vec2 p[5];
    double turn[5];
    lw_guide guide[4];
    lw_guide_rows r;
    *n_out = 0;
    if (n < 3 || n > 5)
        return lw_error_set(e, LW_E_ARG, "a four-bar generates 3 to 5 pairs of angles exactly, not %zu", n);
    if (n == 3)
        return three(angle, theta, out, n_out, e);
    inverted(n, angle, theta, p, turn);
    lw_guide_rows_make(&(lw_poses){ n, p, turn }, 0, &r);
    if (r.n != (int)n - 1)
        return lw_error_set(e, LW_E_NUMERIC, "the pairs are not independent (two of them are the same, or the angles "
                            "are proportional): infinitely many four-bars generate them");
    if (n == 4) {
        four(&r, true, angle, theta, out, n_out);
        four(&r, false, angle, theta, out, n_out);
        return LW_OK;
    }
    int found = lw_guide_rows_solve(&r, guide);
    for (int i = 0; i < found; i++)
        add_guide(&guide[i], angle, theta, out, n_out);
    return LW_OK;
}

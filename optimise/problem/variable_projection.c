#include "optimise/problem/variable_projection.h"

#include <string.h>

#include "optimise/problem/circuit.h"

double lw_problem_tangent(const lw_problem *p, const lw_work *w, size_t k, double t[LW_PROBLEM_ROW_MAX])
{
    double s = 0;
    int row = 0;
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_aim aim = lw_problem_aim(p, i);
        if (aim.x) {
            t[row++] = aim.wa[k]*j->tx[k];
            t[row++] = aim.wa[k]*j->ty[k];
        }
        if (aim.theta)
            t[row++] = aim.wb[k]*j->tt[k];
    }
    for (int i = 0; i < row; i++)
        s += t[i]*t[i];
    return s;
}

bool lw_timing_joined(const lw_problem *p, const lw_work *w, size_t k)
{
    if (p->timing != LW_TIMING_FREE || p->n < 2)
        return false;
    return k + 1 < p->n ? w->phase[k + 1] == w->phase[k]
                        : w->phase[k] == p->intended.sense*(p->intended.sense*w->phase[0] + 2*LW_PI);
}

/* At a cusp the input moves nothing, and is not eliminated: the squared derivative of the residuals by the input, over
 * the weight, is below this (a cusp is known to half of the digits). */
#define CUSP 1e-13

/* Products of a block's tangent with each column of its rows, and with its residuals. */
static void project(const lw_problem *p, const lw_work *w, size_t first, size_t count, double *by,
                    double *slip)
{
    size_t ld = w->ld, nv = (size_t)p->n_var;
    double t[LW_PROBLEM_ROW_MAX];
    memset(by, 0, sizeof *by*nv);
    for (size_t q = 0; q < count; q++) {
        size_t k = (first + q) % p->n;
        lw_problem_tangent(p, w, k, t);
        for (int i = 0; i < w->n_row; i++) {
            *slip += t[i]*w->res[(size_t)i*ld + k];
            for (size_t d = 0; d < nv; d++)
                by[d] += t[i]*w->row[((size_t)i*nv + d)*ld + k];
        }
    }
}

static void eliminate_block(const lw_problem *p, lw_work *w, size_t first, size_t count)
{
    size_t ld = w->ld, nv = (size_t)p->n_var;
    double t[LW_PROBLEM_ROW_MAX], t2 = 0, mass = 0, by[LW_VAR_MAX], slip = 0;
    for (size_t q = 0; q < count; q++) {
        size_t k = (first + q) % p->n;
        t2 += lw_problem_tangent(p, w, k, t);
        mass += p->w[k];
    }
    bool still = !(t2 > CUSP*mass);
    if (!still)
        project(p, w, first, count, by, &slip);
    for (size_t q = 0; q < count; q++) {
        size_t k = (first + q) % p->n;
        w->tie[k] = still;
        if (still)
            continue;
        lw_problem_tangent(p, w, k, t);
        w->slip[k] = slip/t2;
        bool limits_move = !w->swing.turning && w->rate[k] != 0;       /* then the input moves with the limits */
        for (size_t d = 0; d < nv; d++) {
            double drift = limits_move && d < (size_t)p->n_dim ? lw_circuit_drift(w, k, d)/w->rate[k] : 0;
            w->slide[d*ld + k] = by[d]/t2 + drift;
            for (int i = 0; i < w->n_row; i++)
                w->row[((size_t)i*nv + d)*ld + k] -= t[i]*by[d]/t2;
        }
    }
}

/* Split stations at one input whose steps differ: take the first-order step of each, put them in order, and
 * keep those together that the ordering merges. Sizes of the groups go to w->pool + 2 ld; returns their number. */
static size_t part(const lw_problem *p, lw_work *w, size_t first, size_t count)
{
    double *mean = w->pool, *mass = mean + w->ld, *size = mass + w->ld, t[LW_PROBLEM_ROW_MAX];
    size_t top = 0;
    for (size_t q = 0; q < count; q++) {
        size_t k = (first + q) % p->n;
        double t2 = lw_problem_tangent(p, w, k, t) + 1e-300, slope = 0;
        for (int i = 0; i < w->n_row; i++)
            slope += t[i]*w->res[(size_t)i*w->ld + k];
        mean[top] = -p->intended.sense*slope/t2;
        mass[top] = t2;
        size[top++] = 1;
        for (; top > 1 && mean[top - 2] > mean[top - 1]; top--) {
            double m = mass[top - 2] + mass[top - 1];
            mean[top - 2] = (mean[top - 2]*mass[top - 2] + mean[top - 1]*mass[top - 1])/m;
            mass[top - 2] = m;
            size[top - 2] += size[top - 1];
        }
    }
    return top;
}

void lw_variable_projection(const lw_problem *p, const double *x, lw_work *w)
{
    size_t n = p->n, start = 0, count;
    lw_circuit_slopes(p, x, w);
    while (start < n && lw_timing_joined(p, w, (n - start - 1) % n))
        start++;                                         /* go back to the beginning of a block   */
    for (size_t done = 0; done < n; done += count) {
        size_t first = (n - start % n + done) % n;
        count = 1;
        while (done + count < n && lw_timing_joined(p, w, (first + count - 1) % n))
            count++;
        size_t parts = count > 1 ? part(p, w, first, count) : 1;
        const double *size = w->pool + 2*w->ld;
        for (size_t b = 0, at = 0; b < parts; b++) {
            size_t some = count > 1 ? (size_t)size[b] : 1;
            eliminate_block(p, w, (first + at) % n, some);
            at += some;
        }
    }
}

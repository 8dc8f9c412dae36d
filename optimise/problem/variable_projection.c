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
            double x = aim.wa[k]*j->tx[k], y = aim.wa[k]*j->ty[k];
            t[row++] = x;
            t[row++] = y;
            s = s + x*x + y*y;
        }
        if (aim.theta) {
            double turn = aim.wb[k]*j->tt[k];
            t[row++] = turn;
            s += turn*turn;
        }
    }
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

/* Derivatives of the stations by their phases, the squares of these, and their products with the residuals. */
static void measure_tangents(const lw_problem *p, lw_work *w)
{
    for (size_t k = 0; k < p->n; k++) {
        double t[LW_PROBLEM_ROW_MAX];
        w->tangent2[k] = lw_problem_tangent(p, w, k, t);
        w->slip[k] = 0;
        for (int i = 0; i < w->n_row; i++) {
            w->tangent[(size_t)i*w->ld + k] = t[i];
            w->slip[k] += t[i]*w->res[(size_t)i*w->ld + k];
        }
    }
}

/* Split stations at one input whose steps differ: take the first-order step of each, put them in order, and
 * keep those together that the ordering merges. Sizes of the groups go to w->pool + 2 ld; returns their number. */
static size_t part(const lw_problem *p, lw_work *w, size_t first, size_t count)
{
    double *mean = w->pool, *mass = mean + w->ld, *size = mass + w->ld;
    size_t top = 0;
    for (size_t q = 0; q < count; q++) {
        size_t k = (first + q) % p->n;
        double t2 = w->tangent2[k] + 1e-300;
        mean[top] = -p->intended.sense*w->slip[k]/t2;
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

/* List the blocks of two or more stations that move together. */
static void find_blocks(const lw_problem *p, lw_work *w)
{
    size_t n = p->n, start = 0, count;
    w->n_block = 0;
    while (start < n && lw_timing_joined(p, w, (n - start - 1) % n))
        start++;                                         /* go back to the beginning of a block   */
    for (size_t done = 0; done < n; done += count) {
        size_t first = (n - start % n + done) % n;
        count = 1;
        while (done + count < n && lw_timing_joined(p, w, (first + count - 1) % n))
            count++;
        size_t parts = count > 1 ? part(p, w, first, count) : 0;
        const double *size = w->pool + 2*w->ld;
        for (size_t b = 0, at = 0; b < parts; at += (size_t)size[b++])
            if (size[b] > 1)
                w->block[w->n_block++] = (lw_block){ (first + at) % n, (size_t)size[b] };
    }
}

/* Replace the numbers of the stations of each block by their sum. */
static void sum_blocks(const lw_problem *p, const lw_work *w, double *of)
{
    for (size_t b = 0; b < w->n_block; b++) {
        double sum = 0;
        for (size_t q = 0; q < w->block[b].count; q++)
            sum += of[(w->block[b].first + q) % p->n];
        for (size_t q = 0; q < w->block[b].count; q++)
            of[(w->block[b].first + q) % p->n] = sum;
    }
}

/* Stations whose input moves nothing are not eliminated: their tangents become 0. */
static void tie_stations(const lw_problem *p, lw_work *w)
{
    double *mass = w->pool;
    memcpy(mass, p->w, sizeof *mass*p->n);
    sum_blocks(p, w, mass);
    sum_blocks(p, w, w->tangent2);
    sum_blocks(p, w, w->slip);
    for (size_t k = 0; k < p->n; k++) {
        w->tie[k] = !(w->tangent2[k] > CUSP*mass[k]);
        w->tangent2[k] = w->tie[k] ? 1 : w->tangent2[k];
        w->slip[k] /= w->tangent2[k];
        for (int i = 0; i < w->n_row && w->tie[k]; i++)
            w->tangent[(size_t)i*w->ld + k] = 0;
    }
}

/* Eliminate the inputs from the derivatives by variable d. */
static void eliminate(const lw_problem *p, lw_work *w, size_t d)
{
    size_t n = p->n, ld = w->ld, nv = (size_t)p->n_var;
    double *by = w->slide + d*ld;
    memset(by, 0, sizeof *by*n);
    for (int i = 0; i < w->n_row; i++) {
        const double *t = w->tangent + (size_t)i*ld, *row = w->row + ((size_t)i*nv + d)*ld;
        for (size_t k = 0; k < n; k++)
            by[k] += t[k]*row[k];
    }
    sum_blocks(p, w, by);
    for (size_t k = 0; k < n; k++)
        by[k] /= w->tangent2[k];
    for (int i = 0; i < w->n_row; i++) {
        const double *t = w->tangent + (size_t)i*ld;
        double *row = w->row + ((size_t)i*nv + d)*ld;
        for (size_t k = 0; k < n; k++)
            row[k] -= t[k]*by[k];
    }
    for (size_t k = 0; k < n && !w->swing.turning && d < (size_t)p->n_dim; k++)
        by[k] += w->rate[k] != 0 ? lw_circuit_drift(w, k, d)/w->rate[k] : 0;      /* the input moves with the limits */
}

void lw_variable_projection(const lw_problem *p, const double *x, lw_work *w)
{
    lw_circuit_slopes(p, x, w);
    measure_tangents(p, w);
    find_blocks(p, w);
    tie_stations(p, w);
    for (size_t d = 0; d < (size_t)p->n_var; d++)
        eliminate(p, w, d);
}

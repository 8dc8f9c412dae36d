/* mbs/constraints/continuation_singular.c - the rank of the equations, and where along a motion they lose it. */
#include "mbs/constraints/continuation_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/rng.h"

/* Solution of A x = right, in f->work */
static void solve_for(lw_continuation *f, const double *q, const double *right)
{
    lw_continuation_factor(f, q);
    memcpy(f->work, right, (size_t)f->m*sizeof *right);
    lw_continuation_solve(f, f->work);
}

/* A smooth function along the motion that is 0 where rank is lost.  The solution of the bordered system grows like
 * 1/distance there; this is the reciprocal of its component in a fixed direction (Govaerts 2000, chapter 3). */
static double singularity(lw_continuation *f, const double *q, const double *right, const double *along)
{
    double sum = 0.0;
    solve_for(f, q, right);
    for (int i = 0; i < f->n; i++)
        sum += f->work[i]*along[i];
    return 1.0/sum;
}

double lw_continuation_locate(lw_continuation *f, int order, const double *series, double guess,
                        void (*set)(void *context, double x), void *context)
{
    double x[4], g[4], at = 0.0, speed = 0.0;
    for (int i = 0; i < f->n; i++)
        speed += series[f->n + i]*series[f->n + i];
    double delta = fmin(4e-4/sqrt(speed), fabs(guess)/8.0);
    double *right = calloc((size_t)f->m + 2*(size_t)f->n, sizeof *right);
    if (!right)
        return guess;
    double *along = right + f->m, *q = along + f->n;
    lw_rng rng;
    lw_rng_seed(&rng, 7, 0);
    for (int i = 0; i < f->m - f->plane; i++)             /* any general right-hand side shows the loss */
        right[i] = lw_rng_range(&rng, -1.0, 1.0);
    lw_continuation_sum(f, order, series, guess + delta, q);
    set(context, guess + delta);
    lw_continuation_correct(f, q);
    solve_for(f, q, right);                               /* at a point where the loss is already visible */
    memcpy(along, f->work, (size_t)f->n*sizeof *along);
    for (int i = 0; i < 4; i++) {
        x[i] = guess + delta*(i < 2 ? i - 2 : i - 1);
        lw_continuation_sum(f, order, series, x[i], q);
        set(context, x[i]);
        lw_continuation_correct(f, q);
        g[i] = singularity(f, q, right, along);
    }
    /* a zero of higher order, if several ranks are lost; the order follows from the growth over twice the distance */
    double power = fmax(1.0, round(log2(sqrt(fabs(g[0]/g[1]*g[3]/g[2])))));
    for (int i = 0; i < 4; i++)
        g[i] = copysign(pow(fabs(g[i]), 1.0/power), power == 1.0 ? g[i] : i < 2 ? -1.0 : 1.0);
    for (int i = 0; i < 4; i++) {                         /* inverse interpolation */
        double weight = x[i];
        for (int j = 0; j < 4; j++)
            weight *= j == i ? 1.0 : g[j]/(g[j] - g[i]);
        at += weight;
    }
    free(right);
    return isfinite(at) && fabs(at - guess) < delta ? at : guess;
}

/* Rows and driven inputs at q, by columns */
static void fill(const lw_continuation *f, const double *q, int m, double *a)
{
    lw_body_frame at[LW_LINK_MAX];
    memset(a, 0, (size_t)m*(size_t)f->n*sizeof *a);
    lw_system_place(f->s, q, at);
    lw_system_fill(f->s, at, NULL, a, 1, m);
    for (int i = 0; i < f->n_held; i++)
        lw_system_count(f->s, at, f->s->input_joint[f->held[i]], a + f->s->n_row + i, m);
}

int lw_continuation_freedoms(const lw_continuation *f, const double *q, double *direction)
{
    int m = f->s->n_row + f->n_held, n = f->n, freedoms = -1;
    double *memory = malloc(lw_rank_doubles(m, n)*sizeof *memory), length = 0.0;
    int *ints = malloc(lw_rank_ints(m, n)*sizeof *ints);
    if (memory && ints) {
        lw_rank r;
        lw_rng rng;
        lw_rank_place(&r, m, n, memory, ints);
        fill(f, q, m, r.a);
        lw_rank_factor(&r, 1e-9);
        freedoms = n - r.rank;
        lw_rng_seed(&rng, 1, 0);
        for (int i = 0; i < n; i++)
            direction[i] = lw_rng_range(&rng, -1.0, 1.0);
        lw_rank_null_part(&r, direction);
        for (int i = 0; i < n; i++)
            length += direction[i]*direction[i];
        for (int i = 0; i < n; i++)
            direction[i] /= freedoms > 0 ? sqrt(length) : 1.0;
    }
    free(memory);
    free(ints);
    return freedoms;
}

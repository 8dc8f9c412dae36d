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
    double *right = f->located, *along = right + f->m, *q = along + f->n;
    lw_rng rng;
    lw_rng_seed(&rng, 7, 0);
    memset(right, 0, (size_t)f->m*sizeof *right);
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
    return isfinite(at) && fabs(at - guess) < delta ? at : guess;
}

/* Rows and driven inputs at q, by columns or, transposed, by rows: a is m x n. */
static void fill(lw_continuation *f, const double *q, int m, bool transposed, double *a)
{
    long row = transposed ? f->n : 1, column = transposed ? 1 : m;
    memset(a, 0, (size_t)m*(size_t)f->n*sizeof *a);
    lw_system_place(f->s, q, f->frame);
    lw_system_fill(f->s, f->frame, NULL, a, row, column);
    for (int i = 0; i < f->n_held; i++)
        lw_system_count(f->s, f->frame, f->s->input_joint[f->held[i]], a + (f->s->n_row + i)*row, column);
}

/* Make x (n) a unit vector, across `without`. */
static void make_unit(int n, const double *without, double *x)
{
    double along = 0.0, length = 0.0;
    for (int i = 0; i < n && without; i++)
        along += x[i]*without[i];
    for (int i = 0; i < n; i++) {
        x[i] -= without ? along*without[i] : 0.0;
        length += x[i]*x[i];
    }
    for (int i = 0; i < n; i++)
        x[i] /= length > 0.0 ? sqrt(length) : 1.0;
}

static void draw(lw_rng *rng, int n, double *x)
{
    for (int i = 0; i < n; i++)
        x[i] = lw_rng_range(rng, -1.0, 1.0);
}

/* Project a drawn vector onto the null space of the derivatives, or of the transposed ones.  Returns its dimension. */
static int null_part(lw_continuation *f, const double *q, double least, bool transposed, lw_rng *rng, double *out)
{
    int m = f->s->n_row + f->n_held, n = f->n, left = -1;
    if (transposed)
        m = n, n = f->s->n_row + f->n_held;
    double *memory = malloc(lw_rank_doubles(m, n)*sizeof *memory);
    int *ints = malloc(lw_rank_ints(m, n)*sizeof *ints);
    if (memory && ints) {
        lw_rank r;
        lw_rank_place(&r, m, n, memory, ints);
        fill(f, q, transposed ? n : m, transposed, r.a);
        lw_rank_factor(&r, least);
        left = n - r.rank;
        draw(rng, n, out);
        lw_rank_null_part(&r, out);
    }
    free(memory);
    free(ints);
    return left;
}

/* The rows at q, factored; returns how many coordinates are left out. */
static int factor_sparse(lw_continuation *f, const double *q, double least)
{
    int left;
    lw_system_place(f->s, q, f->frame);
    lw_sparse_rows_fill(&f->sparse, f->frame);
    memset(lw_sparse_rows_weights(&f->sparse), 0, (size_t)f->n*sizeof(double));
    lw_sparse_rows_factor(&f->sparse, least, &left);
    return left;
}

/* A combination of the null vectors that belong to the coordinates left out. */
static int null_sparse(lw_continuation *f, const double *q, double least, lw_rng *rng, double *out)
{
    int left = factor_sparse(f, q, least);
    memset(out, 0, (size_t)f->n*sizeof *out);
    for (int i = 0; i < f->n; i++)
        if (f->sparse.dependent[f->sparse.place[i]]) {
            double by = lw_rng_range(rng, -1.0, 1.0), length = 0.0;
            lw_sparse_rows_null(&f->sparse, i, f->diag);
            for (int k = 0; k < f->n; k++)
                length += f->diag[k]*f->diag[k];
            for (int k = 0; k < f->n; k++)
                out[k] += by/sqrt(length)*f->diag[k];
        }
    return left;
}

int lw_continuation_null(lw_continuation *f, const double *q, double least, uint64_t seed, const double *without, double *out)
{
    lw_rng rng;
    lw_rng_seed(&rng, seed, without != NULL);             /* a different random start than for `without` */
    int left = f->matrix ? null_part(f, q, least, false, &rng, out) : null_sparse(f, q, least, &rng, out);
    if (left > 0)
        make_unit(f->n, without, out);
    return left;
}

int lw_continuation_left_null(lw_continuation *f, const double *q, double least, double *out)
{
    int m = f->s->n_row + f->n_held, left;
    lw_rng rng;
    lw_rng_seed(&rng, 3, 0);
    if (f->matrix)
        left = null_part(f, q, least, true, &rng, out);
    else {                                                /* what a drawn vector has across the columns */
        left = m - f->n + factor_sparse(f, q, least);
        draw(&rng, m, out);
        lw_sparse_rows_solve(&f->sparse, out, false, f->diag);
        lw_sparse_rows_times(&f->sparse, f->diag, f->work);
        for (int i = 0; i < m; i++)
            out[i] -= f->work[i];
    }
    make_unit(m, NULL, out);
    return left;
}

int lw_continuation_freedoms(lw_continuation *f, const double *q, double *direction)
{
    return lw_continuation_null(f, q, 1e-9, 1, NULL, direction);
}

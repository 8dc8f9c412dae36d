#include "mbs/constraints/adjust.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/real.h"
#include "base/vector.h"

static const double loose = 5e-3;            /* a row this near to others, relatively, may depend on them if it were exact */
static const double strict = 1e-9;
static const double stride = 0.4;           /* between postures, scaled */
static const double exact = 1e-12;           /* rows that are satisfied by the dimensions given */
static const double closed = 4e-15;          /* rows that are satisfied by the dimensions adjusted */
static const double ease = 10;               /* a change of a posture costs less than one of a dimension by this factor */
static const double least_pivot[2] = { 1e-12, 1e-8 };  /* of the rows, relative: the first as far as rounding allows */
enum { POSTURES = 8, LEAST_SQUARES = 60, ROWS_MOST = 700 };

/* A dimension: coordinate `axis` of the arm of a joint at one end, or (end 2) the direction of its line. */
typedef struct dimension { int joint, end, axis; } dimension;

typedef struct adjuster {
    lw_system *s;
    int     n_q, n_row, n_dim, n_posture;
    dimension *dim;
    double *q;                               /* (n_posture * n_q) */
    double *phi, *jac, *other;               /* of one posture */
    double *a, *right, *step;                /* the least-squares problem */
    int    *order;
    double *doubles;                         /* of rank */
    int    *ints;
} adjuster;

static void free_adjuster(adjuster *w)
{
    void *const array[] = { w->dim, w->q, w->phi, w->a, w->order, w->doubles, w->ints };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
}

static double *value_of(const adjuster *w, const dimension *d)
{
    lw_vec2 *arm = &w->s->joint[d->joint].arm[d->end];
    return d->axis == 0 ? &arm->x : &arm->y;
}

static void change(const adjuster *w, const dimension *d, double by)
{
    if (d->end < 2)
        *value_of(w, d) += by;
    else {
        lw_vec2 *along = &w->s->joint[d->joint].along;
        *along = lw_v2_turn(*along, lw_v2_polar(1, by));
    }
}

static void list_dimensions(adjuster *w)
{
    for (int j = 0; j < w->s->n_joint; j++) {
        lw_joint_kind kind = w->s->joint[j].kind;
        for (int end = 0; end < 2 && lw_joint_has_position(kind); end++)
            for (int axis = 0; axis < 2; axis++)
                w->dim[w->n_dim++] = (dimension){ j, end, axis };
        if (lw_joint_slides(kind))
            w->dim[w->n_dim++] = (dimension){ j, 2, 0 };
    }
}

/* Rows at q; the factorisation of their transposed derivatives, with at most `most` of them (0: all). */
static void factor(adjuster *w, const double *q, int most, double least, lw_rank *r)
{
    lw_system_rows(w->s, q, w->phi, w->jac);
    lw_rank_place(r, w->n_q, w->n_row, w->doubles, w->ints);
    memcpy(r->a, w->jac, (size_t)w->n_q*(size_t)w->n_row*sizeof *r->a);
    r->most = most;
    lw_rank_factor(r, least);
}

/* Postures along motion k of the linkage, as if rows that nearly depend on others did: from q in both senses, each closed
 * in the sense of least squares.  Returns the greatest residual; infinite where the rows do not depend on others any more:
 * the posture given is singular. */
static double walk(adjuster *w, int rank, int k)
{
    lw_rank r;
    double worst = 0, *way = w->other, *old = way + w->n_q, *b = old + w->n_q;
    for (int sense = -1; sense <= 1; sense += 2) {
        const double *from = w->q;
        for (int i = 0; i < POSTURES/2; i++) {
            double *to = w->q + (size_t)w->n_posture++*(size_t)w->n_q, along = 0, size = 0;
            factor(w, from, rank, strict, &r);
            lw_rank_left_null(&r, i == 0 ? k : 0, way);
            for (int free = 0; i > 0 && free < w->n_q - r.rank; free++) {     /* the motion nearest to the last step */
                double *one = b, part = 0;
                lw_rank_left_null(&r, free, one);
                for (int c = 0; c < w->n_q; c++)
                    part += one[c]*old[c];
                for (int c = 0; c < w->n_q; c++)
                    way[c] = (free ? way[c] : 0) + part*one[c];
            }
            for (int c = 0; c < w->n_q; c++) {
                along += i ? way[c]*old[c] : 0;
                size = fmax(size, fabs(way[c]));
            }
            double by = (i == 0 ? sense : along < 0 ? -1 : 1)*stride/fmax(size, 1e-30);
            for (int c = 0; c < w->n_q; c++)
                to[c] = from[c] + (old[c] = by*way[c]);
            for (int pass = 0; pass < 30; pass++) {
                factor(w, to, rank, strict, &r);
                lw_rank_solve_transposed(&r, w->phi, way);
                for (int c = 0; c < w->n_q; c++)
                    to[c] -= way[c];
                if (lw_greatest(w->n_q, way) < 1e-14)
                    break;
            }
            factor(w, to, 0, loose, &r);
            worst = r.rank > rank ? INFINITY : fmax(worst, lw_greatest(w->n_row, w->phi));
            from = to;
        }
    }
    return worst;
}

/* The rows of all postures and their derivatives by the dimensions and, made easy but for the first, by the postures:
 * right (m), a (m x n). */
static double fill(adjuster *w, int n)
{
    const double h = 1e-6;
    double worst = 0;
    memset(w->a, 0, (size_t)w->n_posture*(size_t)w->n_row*(size_t)n*sizeof *w->a);
    for (int p = 0; p < w->n_posture; p++) {
        const double *q = w->q + (size_t)p*(size_t)w->n_q;
        double *a = w->a + (size_t)p*(size_t)w->n_row*(size_t)n;
        lw_system_rows(w->s, q, w->phi, w->jac);
        for (int r = 0; r < w->n_row; r++) {
            w->right[p*w->n_row + r] = w->phi[r];
            worst = fmax(worst, fabs(w->phi[r]));
            for (int c = 0; c < w->n_q; c++)
                a[(size_t)r*(size_t)n + (size_t)(w->n_dim + p*w->n_q + c)] = (p ? ease : 1)*w->jac[r*w->n_q + c];
        }
        for (int d = 0; d < w->n_dim; d++) {
            lw_system_joint *joint = &w->s->joint[w->dim[d].joint], drawn = *joint;
            change(w, &w->dim[d], h);
            lw_system_rows(w->s, q, w->phi, NULL);
            *joint = drawn;
            change(w, &w->dim[d], -h);
            lw_system_rows(w->s, q, w->other, NULL);
            *joint = drawn;
            for (int r = 0; r < w->n_row; r++)
                a[(size_t)r*(size_t)n + (size_t)d] = (w->phi[r] - w->other[r])/(2*h);
        }
    }
    return worst;
}

/* Newton's method on all rows of all postures, with the least step.  Rows are dependent in the limit, so directions in
 * which they change less than the residual are left alone, and weak ones until the residual falls no more without. */
static bool close_all(adjuster *w, double *total)
{
    int m = w->n_posture*w->n_row, n = w->n_dim + w->n_posture*w->n_q;
    double before = INFINITY, pivot = least_pivot[1], last = 0;
    for (int pass = 0; pass < LEAST_SQUARES; pass++) {
        double worst = fill(w, n);
        lw_rank r;
        if (worst < closed)
            return true;
        if (worst > 0.5*before)
            pivot = fmax(0.1*pivot, least_pivot[0]);
        before = worst;
        lw_rank_place(&r, n, m, w->a, w->order);        /* the rows of A, one after the other, are the columns of A^T */
        lw_rank_factor(&r, fmax(worst, pivot));
        lw_rank_solve_transposed(&r, w->right, w->step);
        double now = lw_greatest(w->n_dim, w->step), factor = now > 0.4*last && now < 0.6*last ? 2 : 1;
        last = factor == 1 ? now : 0;                    /* steps that halve lead to a double root, twice as far away */
        for (int d = 0; d < w->n_dim; d++) {
            change(w, &w->dim[d], -factor*w->step[d]);
            total[d] -= factor*w->step[d];
        }
        for (int k = 0; k < w->n_posture*w->n_q; k++)
            w->q[k] -= factor*(k < w->n_q ? 1 : ease)*w->step[w->n_dim + k];
        if (!(lw_greatest(w->n_dim, total) <= LW_ADJUST_MOST))
            return false;
    }
    return false;
}

/* ---- double roots --------------------------------------------------------------------------------------------- */

/* Three parallel bars satisfy all rows for a deviation d of their dimensions up to d^2: Newton's method ends at d = 1e-8,
 * and in the flat posture the rows are off by d.  In the root itself, x, every direction v that satisfies J(x) v = 0
 * for a nearby x does so exactly, but for directions within the range of J.  With V such directions near the root and P the
 * projection out of the range, P (J v_i + sum of d_j F''[v_i, v_j]) = 0 gives x + V d (Ojika 1987), as a simple root. */

static const double weak_pivot = 1e-5;       /* of J near the root, relative; directions with less are V */
static const double bends = 1e-3;            /* least second derivative of a double root */
enum { DOUBLES_MOST = 4000000 };

typedef struct refiner { adjuster *w; int m, n, k; double *v, *base, *out, *h, *g, *normal, *b, *d; lw_system_joint *joint; } refiner;

/* Rows of all postures at the base moved by s v_i + z v_j. */
static void rows_beside(const refiner *f, int i, double s, int j, double z, double *out)
{
    adjuster *w = f->w;
    memcpy(w->s->joint, f->joint, (size_t)w->s->n_joint*sizeof *f->joint);
    for (int c = 0; c < f->n; c++) {
        double by = s*f->v[(size_t)i*(size_t)f->n + (size_t)c] + z*f->v[(size_t)j*(size_t)f->n + (size_t)c];
        int k = c - w->n_dim;
        if (k < 0)
            change(w, &w->dim[c], by);
        else
            w->q[k] = f->base[k] + (k < w->n_q ? 1 : ease)*by;
    }
    for (int p = 0; p < w->n_posture; p++)
        lw_system_rows(w->s, w->q + (size_t)p*(size_t)w->n_q, out + (size_t)p*(size_t)w->n_row, NULL);
}

/* J v_i by differences of order 6, and F''[v_i, v_j] of order 2, without their parts in the range of J. */
static void bend(const refiner *f, const lw_rank *r, int i)
{
    static const double part[3] = { 45.0/60, -9.0/60, 1.0/60 };
    const double step = 2e-3;
    size_t m = (size_t)f->m;
    double *g = f->g + (size_t)i*m;
    memset(g, 0, m*sizeof *g);
    for (int p = 1; p <= 3; p++)
        for (int side = -1; side <= 1; side += 2) {
            rows_beside(f, i, side*p*step, i, 0, f->out);
            for (size_t c = 0; c < m; c++)
                g[c] += side*part[p - 1]*f->out[c]/step;
        }
    lw_rank_null_part(r, g);
    for (int j = 0; j < f->k; j++) {
        double *h = f->h + ((size_t)i*(size_t)f->k + (size_t)j)*m;
        memset(h, 0, m*sizeof *h);
        for (int corner = 0; corner < 4; corner++) {
            double a = corner & 1 ? 1 : -1, b = corner & 2 ? 1 : -1;
            rows_beside(f, i, a*step, j, b*step, f->out);
            for (size_t c = 0; c < m; c++)
                h[c] += a*b*f->out[c]/(4*step*step);
        }
        lw_rank_null_part(r, h);
    }
}

/* One step towards the double root.  Returns the greatest change of a dimension or posture; 0: there is no double root. */
static double to_double_root(refiner *f, double *total)
{
    adjuster *w = f->w;
    size_t m = (size_t)f->m, k = (size_t)f->k;
    double most = 0, moved = 0;
    lw_rank r;
    fill(w, f->n);
    lw_rank_place(&r, f->n, f->m, w->a, w->order);
    lw_rank_factor(&r, weak_pivot);
    lw_rank_solve_transposed(&r, w->right, w->step);             /* first the directions that are not weak */
    for (int i = 0; i < f->k && i < f->n - r.rank; i++)
        lw_rank_left_null(&r, i, f->v + (size_t)i*(size_t)f->n);
    memcpy(f->joint, w->s->joint, (size_t)w->s->n_joint*sizeof *f->joint);
    memcpy(f->base, w->q, (size_t)w->n_posture*(size_t)w->n_q*sizeof *w->q);
    for (int i = 0; i < f->k; i++)
        bend(f, &r, i);
    memcpy(w->s->joint, f->joint, (size_t)w->s->n_joint*sizeof *f->joint);
    memcpy(w->q, f->base, (size_t)w->n_posture*(size_t)w->n_q*sizeof *w->q);
    memset(f->normal, 0, k*k*sizeof *f->normal);
    memset(f->b, 0, k*sizeof *f->b);
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) {
            const double *h = f->h + (i*k + j)*m;
            for (size_t l = 0; l <= j; l++)
                for (size_t c = 0; c < m; c++)
                    f->normal[j + l*k] += h[c]*f->h[(i*k + l)*m + c];
            for (size_t c = 0; c < m; c++)
                f->b[j] -= h[c]*f->g[i*m + c];
        }
    for (size_t j = 0; j < k; j++)
        for (size_t l = 0; l < j; l++)
            f->normal[l + j*k] = f->normal[j + l*k];
    for (size_t j = 0; j < k; j++)
        most = fmax(most, f->normal[j + j*k]);
    if (!(most > bends*bends))
        return 0;
    lw_rank_place(&r, f->k, f->k, f->normal, w->order);
    lw_rank_factor(&r, 1e-6);
    lw_rank_solve(&r, f->b, f->d);
    for (int c = 0; c < f->n; c++) {
        double by = -w->step[c];
        for (size_t j = 0; j < k; j++)
            by += f->d[j]*f->v[j*(size_t)f->n + (size_t)c];
        moved = fmax(moved, fabs(by));
        if (c < w->n_dim) {
            change(w, &w->dim[c], by);
            total[c] += by;
        } else
            w->q[c - w->n_dim] += (c - w->n_dim < w->n_q ? 1 : ease)*by;
    }
    return moved;
}

/* Sharpen the dimensions found, if they are near a double root. */
static lw_status sharpen(adjuster *w, double *total)
{
    int m = w->n_posture*w->n_row, n = w->n_dim + w->n_posture*w->n_q;
    lw_rank r;
    fill(w, n);
    lw_rank_place(&r, n, m, w->a, w->order);
    lw_rank_factor(&r, weak_pivot);
    size_t k = (size_t)(n - r.rank), rows = (size_t)m, joints = (size_t)w->s->n_joint*sizeof(lw_system_joint);
    if (k*k*rows > DOUBLES_MOST)
        return LW_OK;
    size_t square = lw_rank_doubles((int)k, (int)k), postures = (size_t)(w->n_posture*w->n_q);
    double *memory = calloc(k*(size_t)n + postures + rows + k*k*rows + k*rows + square + 2*k, sizeof *memory);
    refiner f = { .w = w, .m = m, .n = n, .k = (int)k, .joint = malloc(joints) };
    lw_system_joint *joint = malloc(joints);
    double *q = malloc((postures + (size_t)w->n_dim)*sizeof *q);
    if (memory && f.joint && joint && q) {
        f.v = memory, f.base = f.v + k*(size_t)n, f.out = f.base + postures, f.h = f.out + rows, f.g = f.h + k*k*rows;
        f.normal = f.g + k*rows, f.b = f.normal + square, f.d = f.b + k;
        memcpy(joint, w->s->joint, joints);
        memcpy(q, w->q, postures*sizeof *q);
        memcpy(q + postures, total, (size_t)w->n_dim*sizeof *q);
        double first = to_double_root(&f, total), moved = first;
        for (int pass = 1; pass < 6 && moved > 1e-13; pass++)
            moved = to_double_root(&f, total);
        if (!(first > 0) || !(fill(w, n) < 4*closed) || !(lw_greatest(w->n_dim, total) <= LW_ADJUST_MOST)) {
            memcpy(w->s->joint, joint, joints);
            memcpy(w->q, q, postures*sizeof *q);
            memcpy(total, q + postures, (size_t)w->n_dim*sizeof *q);
        }
    }
    lw_status s = memory && f.joint && joint && q ? LW_OK : LW_E_MEMORY;
    free(memory), free(f.joint), free(joint), free(q);
    return s;
}

static lw_status allocate(adjuster *w, int freedom, lw_error *e)
{
    size_t q = (size_t)w->n_q, r = (size_t)w->n_row, p = 1 + (size_t)freedom*POSTURES, dims = 5*(size_t)w->s->n_joint;
    size_t m = p*r, n = dims + p*q;
    w->dim = calloc(dims, sizeof *w->dim);
    w->q = calloc(p*q, sizeof *w->q);
    w->a = calloc(lw_rank_doubles((int)n, (int)m) + m + n + dims, sizeof *w->a);
    w->order = calloc(lw_rank_ints((int)n, (int)m), sizeof *w->order);
    if (!w->dim || !w->q || !w->a || !w->order)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    w->right = w->a + lw_rank_doubles((int)n, (int)m);
    w->step = w->right + m;
    return LW_OK;
}

lw_status lw_system_adjust(lw_system *s, double *q, double *by, lw_error *e)
{
    adjuster w = { .s = s, .n_q = s->n_q, .n_row = s->n_row };
    size_t n = (size_t)s->n_q, rows = (size_t)s->n_row;
    lw_rank r;
    *by = 0;
    w.phi = calloc(2*rows + rows*n + 3*n, sizeof *w.phi);
    w.doubles = calloc(lw_rank_doubles(s->n_q, s->n_row), sizeof *w.doubles);
    w.ints = calloc(lw_rank_ints(s->n_q, s->n_row), sizeof *w.ints);
    if (!w.phi || !w.doubles || !w.ints) {
        free_adjuster(&w);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    w.jac = w.phi + rows;
    w.other = w.jac + rows*n;
    factor(&w, q, 0, loose, &r);
    int rank = r.rank, freedom = s->n_q - rank;
    bool candidate = rank < s->n_row && freedom > 0 && (1 + freedom*POSTURES)*s->n_row <= ROWS_MOST;
    lw_status status = candidate ? allocate(&w, freedom, e) : LW_NOTHING;
    size_t bytes = (size_t)s->n_joint*sizeof *s->joint;
    lw_system_joint *before = malloc(bytes);
    if (status == LW_OK && !before)
        status = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (status == LW_OK) {
        double *total = w.step + (5*(size_t)s->n_joint + (size_t)(1 + freedom*POSTURES)*n), worst = 0;
        memcpy(before, s->joint, bytes);
        memcpy(w.q, q, n*sizeof *q);
        w.n_posture = 1;
        list_dimensions(&w);
        for (int k = 0; k < freedom; k++)
            worst = fmax(worst, walk(&w, rank, k));
        bool near = worst > exact && worst < LW_ADJUST_MOST && close_all(&w, total);
        if (near && sharpen(&w, total) != LW_OK)
            status = lw_error_set(e, LW_E_MEMORY, "out of memory");
        else if (near) {
            *by = lw_greatest(w.n_dim, total);
            memcpy(q, w.q, n*sizeof *q);
        } else {
            memcpy(s->joint, before, bytes);
            status = LW_NOTHING;
        }
    }
    free(before);
    free_adjuster(&w);
    return status;
}

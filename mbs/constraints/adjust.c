#include "mbs/constraints/adjust.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/real.h"
#include "base/vector.h"

static const double loose = 5e-3;            /* a row this near to others, relatively, may depend on them if it were exact */
static const double strict = 1e-9;
static const double unclear = 0.1;           /* which rows depend on others, where the weakest of those that do not is no farther from it */
static const double longest_stride = 0.4, least_stride = 0.05;           /* between postures, scaled */
static const double exact = 1e-12;           /* rows that are satisfied by the dimensions given */
static const double closed = 4e-15;          /* rows that are satisfied by the dimensions adjusted; a few more steps are tried until they are */
static const double rounded = 6e-16;         /* satisfied to this, since the motion through flat postures depends on it */
static const double ease = 10;               /* a change of a posture costs less than one of a dimension by this factor */
static const double first_pivot[2] = { 1e-2, 1e-8 };   /* of the rows, relative; where dimensions can be a double root it shows in weak directions */
static const double least_pivot = 1e-10;               /* as far as rounding allows */
enum { LEAST_SQUARES = 60, ROWS_MOST = 2000, SHARPEN_MOST = 700, LEAST_POSTURES = 4 };

typedef struct adjuster {
    const lw_adjustable *of;
    int     n_place, n_q, n_row, n_dim, n_posture, rank;
    int     each;                            /* postures of each motion: fewer where there are many motions */
    double *total;                           /* (n_dim) changes so far */
    double *place;                           /* (n_posture * n_place) */
    double *phi, *jac, *other;               /* of one posture */
    double *a, *right, *step;                /* the least-squares problem */
    int    *order;
    double *doubles;                         /* of rank */
    int    *ints;
} adjuster;

static void free_adjuster(adjuster *w)
{
    void *const array[] = { w->place, w->phi, w->a, w->order, w->doubles, w->ints };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
}

static void rows(const adjuster *w, const double *place, double *phi, double *jac)
{
    w->of->rows(w->of->context, place, phi, jac);
}

/* Move a posture by `factor` times the displacement by, which is overwritten. */
static void move(const adjuster *w, double *place, double factor, double *by)
{
    for (int c = 0; c < w->n_q; c++)
        by[c] *= factor;
    w->of->move(w->of->context, place, by);
}

/* Rows at a place; the factorisation of their transposed derivatives, with at most `most` of them (0: all). */
static void factor(adjuster *w, const double *place, int most, double least, lw_rank *r)
{
    rows(w, place, w->phi, w->jac);
    lw_rank_place(r, w->n_q, w->n_row, w->doubles, w->ints);
    memcpy(r->a, w->jac, (size_t)w->n_q*(size_t)w->n_row*sizeof *r->a);
    r->most = most;
    lw_rank_factor(r, least);
}

/* Close a posture in the sense of least squares, by rows of the rank along the motion.  way (n_q): scratch. */
static void close_posture(adjuster *w, double *place, double *way)
{
    double before = INFINITY, now;
    lw_rank r;
    for (int pass = 0; pass < 30; pass++) {
        factor(w, place, w->rank, strict, &r);
        lw_rank_solve_transposed(&r, w->phi, way);
        move(w, place, -1, way);
        now = lw_greatest(w->n_q, way);
        if (now < 1e-14 || (now < 1e-11 && now > 0.5*before))
            break;
        before = now;
    }
}

/* Postures along motion k of the linkage, `stride` apart, as if rows that nearly depend on others did: from the first in both senses by
 * turns, each closed in the sense of least squares.  A sense ends where the rank is not clear: near postures where two motions meet, rounded
 * numbers lead to neither.  Returns the greatest residual; infinite if both senses end before all postures are found. */
static double walk(adjuster *w, int k, double stride)
{
    lw_rank r;
    double worst = 0, *way = w->other, *b = way + w->n_q;
    const double *from[2] = { w->place, w->place };
    bool ended[2] = { false, false };
    for (int i = 0, sense = 1; i < w->each; ) {
        sense = ended[!sense] ? sense : !sense;
        if (ended[sense])
            return INFINITY;
        bool first = from[sense] == w->place;
        double *to = w->place + (size_t)w->n_posture*(size_t)w->n_place, *old = b + (1 + sense)*w->n_q, along = 0, size = 0;
        factor(w, from[sense], w->rank, strict, &r);
        lw_rank_left_null(&r, first ? k : 0, way);
        for (int free = 0; !first && free < w->n_q - r.rank; free++) {        /* the motion nearest to the last step */
            double *one = b, part = 0;
            lw_rank_left_null(&r, free, one);
            for (int c = 0; c < w->n_q; c++)
                part += one[c]*old[c];
            for (int c = 0; c < w->n_q; c++)
                way[c] = (free ? way[c] : 0) + part*one[c];
        }
        for (int c = 0; c < w->n_q; c++) {
            along += first ? 0 : way[c]*old[c];
            size = fmax(size, fabs(way[c]));
        }
        memcpy(to, from[sense], (size_t)w->n_place*sizeof *to);
        move(w, to, (first ? 2*sense - 1 : along < 0 ? -1 : 1)*stride/fmax(size, 1e-30), way);
        memcpy(old, way, (size_t)w->n_q*sizeof *old);
        close_posture(w, to, way);
        factor(w, to, w->rank, strict, &r);
        double kept = r.weakest;
        factor(w, to, w->rank + 1, strict, &r);
        ended[sense] = r.rank > w->rank && r.weakest > fmin(loose, unclear*kept);
        if (!ended[sense]) {
            worst = fmax(worst, lw_greatest(w->n_row, w->phi));
            from[sense] = to;
            w->n_posture++, i++;
        }
    }
    return worst;
}

/* The rows of all postures, right (m). */
static void fill_rows(const adjuster *w, double *right)
{
    for (int p = 0; p < w->n_posture; p++)
        rows(w, w->place + (size_t)p*(size_t)w->n_place, right + (size_t)p*(size_t)w->n_row, NULL);
}

/* The rows of all postures and their derivatives by the dimensions: right (m), a (m x n), of which the first n_dim columns are
 * written.  Returns the greatest row. */
static double fill_dimensions(adjuster *w, int n)
{
    const double h = 1e-6;
    size_t m = (size_t)(w->n_posture*w->n_row);
    memset(w->a, 0, m*(size_t)n*sizeof *w->a);
    for (int d = 0; d < w->n_dim; d++) {
        double drawn = w->total[d];
        for (int side = -1; side <= 1; side += 2) {
            w->total[d] = drawn + side*h;
            w->of->change(w->of->context, w->total);
            fill_rows(w, w->right);
            for (size_t r = 0; r < m; r++)
                w->a[r*(size_t)n + (size_t)d] += side*w->right[r]/(2*h);
        }
        w->total[d] = drawn;
    }
    w->of->change(w->of->context, w->total);
    fill_rows(w, w->right);
    return lw_greatest((int)m, w->right);
}

/* The part of the derivatives by the dimensions that no change of the postures, which are closed, makes up for. */
static void eliminate_postures(adjuster *w)
{
    lw_rank r;
    for (int p = 0; p < w->n_posture; p++) {
        double *a = w->a + (size_t)(p*w->n_row)*(size_t)w->n_dim;
        factor(w, w->place + (size_t)p*(size_t)w->n_place, w->rank, strict, &r);
        for (int d = 0; d < w->n_dim; d++) {
            for (int k = 0; k < w->n_row; k++)
                w->phi[k] = a[k*w->n_dim + d];
            lw_rank_null_part(&r, w->phi);
            for (int k = 0; k < w->n_row; k++)
                a[k*w->n_dim + d] = w->phi[k];
        }
    }
}

/* Newton's method on all rows of all postures, with the least step.  Rows are dependent in the limit, so directions in
 * which they change less than the residual are left alone, and weak ones until the residual falls no more without. */
static bool close_all(adjuster *w)
{
    int m = w->n_posture*w->n_row, n = w->n_dim;
    double before = INFINITY, pivot = first_pivot[w->of->doubles], last = 0;
    int more = 8;                            /* steps left once the rows are closed */
    for (int pass = 0; pass < LEAST_SQUARES; pass++) {
        double worst = fill_dimensions(w, n);
        lw_rank r;
        if (worst < rounded || (worst < closed && more-- == 0))
            return true;
        if (worst > 0.5*before)
            pivot = fmax(0.1*pivot, least_pivot);
        before = worst;
        eliminate_postures(w);
        lw_rank_place(&r, n, m, w->a, w->order);        /* the rows of A, one after the other, are the columns of A^T */
        lw_rank_factor(&r, fmax(worst, pivot));
        lw_rank_solve_transposed(&r, w->right, w->step);
        double now = lw_greatest(n, w->step), factor = now > 0.4*last && now < 0.6*last ? 2 : 1;
        last = factor == 1 ? now : 0;                    /* steps that halve lead to a double root, twice as far away */
        for (int d = 0; d < n; d++)
            w->total[d] -= factor*w->step[d];
        w->of->change(w->of->context, w->total);
        if (!(lw_greatest(n, w->total) <= LW_ADJUST_MOST))
            return false;
        for (int p = 0; p < w->n_posture; p++)
            close_posture(w, w->place + (size_t)p*(size_t)w->n_place, w->other);
    }
    return false;
}

/* ---- double roots --------------------------------------------------------------------------------------------- */

/* Three parallel bars satisfy all rows for a deviation d of their dimensions up to d^2: Newton's method ends at d = 1e-8,
 * and in the flat posture the rows are off by d.  In the root itself, x, every direction v that satisfies J(x) v = 0
 * for a nearby x does so exactly, but for directions within the range of J.  With V such directions near the root and P the
 * projection out of the range, P (J v_i + sum of d_j F''[v_i, v_j]) = 0 gives x + V d (Ojika 1987), as a simple root. */

/* As fill_dimensions, with the derivatives by the postures in columns n_dim .., made easy but for the first. */
static double fill(adjuster *w, int n)
{
    double worst = fill_dimensions(w, n);
    for (int p = 0; p < w->n_posture; p++) {
        double *a = w->a + (size_t)(p*w->n_row)*(size_t)n + (size_t)(w->n_dim + p*w->n_q);
        rows(w, w->place + (size_t)p*(size_t)w->n_place, w->phi, w->jac);
        for (int r = 0; r < w->n_row; r++)
            for (int c = 0; c < w->n_q; c++)
                a[(size_t)r*(size_t)n + (size_t)c] = (p ? ease : 1)*w->jac[r*w->n_q + c];
    }
    return worst;
}

/* Change dimensions and postures by `factor` times by (n), which is overwritten. */
static void step(adjuster *w, double factor, double *by)
{
    for (int d = 0; d < w->n_dim; d++)
        w->total[d] += factor*by[d];
    for (int p = 0; p < w->n_posture; p++)
        move(w, w->place + (size_t)p*(size_t)w->n_place, factor*(p ? ease : 1), by + w->n_dim + p*w->n_q);
    w->of->change(w->of->context, w->total);
}

static const double weak_pivot = 1e-5;       /* of J near the root, relative; directions with less are V */
static const double bends = 1e-3;            /* least second derivative of a double root */
enum { DOUBLES_MOST = 4000000 };

/* base: dimensions and postures from which rows are taken. */
typedef struct refiner { adjuster *w; int m, n, k; double *v, *base, *by, *out, *h, *g, *normal, *b, *d; } refiner;

/* Keep the dimensions and the postures, or put them back. */
static void keep(const adjuster *w, double *base)
{
    memcpy(base, w->total, (size_t)w->n_dim*sizeof *base);
    memcpy(base + w->n_dim, w->place, (size_t)(w->n_posture*w->n_place)*sizeof *base);
}

static void put_back(adjuster *w, const double *base)
{
    memcpy(w->total, base, (size_t)w->n_dim*sizeof *base);
    memcpy(w->place, base + w->n_dim, (size_t)(w->n_posture*w->n_place)*sizeof *base);
    w->of->change(w->of->context, w->total);
}

/* Rows of all postures at the base moved by s v_i + z v_j. */
static void rows_beside(const refiner *f, int i, double s, int j, double z, double *out)
{
    const double *v = f->v + (size_t)i*(size_t)f->n, *u = f->v + (size_t)j*(size_t)f->n;
    put_back(f->w, f->base);
    for (int c = 0; c < f->n; c++)
        f->by[c] = s*v[c] + z*u[c];
    step(f->w, 1, f->by);
    fill_rows(f->w, out);
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
static double to_double_root(refiner *f)
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
    keep(w, f->base);
    for (int i = 0; i < f->k; i++)
        bend(f, &r, i);
    put_back(w, f->base);
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
        f->by[c] = -w->step[c];
        for (size_t j = 0; j < k; j++)
            f->by[c] += f->d[j]*f->v[j*(size_t)f->n + (size_t)c];
    }
    moved = lw_greatest(f->n, f->by);
    step(w, 1, f->by);
    return moved;
}

/* Sharpen the dimensions found, if they are near a double root. */
static lw_status sharpen(adjuster *w)
{
    int m = w->n_posture*w->n_row, n = w->n_dim + w->n_posture*w->n_q;
    lw_rank r;
    if (!w->of->doubles || m > SHARPEN_MOST)
        return LW_OK;
    fill(w, n);
    lw_rank_place(&r, n, m, w->a, w->order);
    lw_rank_factor(&r, weak_pivot);
    size_t k = (size_t)(n - r.rank), rows = (size_t)m, base = (size_t)(w->n_dim + w->n_posture*w->n_place);
    if (k*k*rows > DOUBLES_MOST)
        return LW_OK;
    size_t square = lw_rank_doubles((int)k, (int)k);
    double *memory = calloc((k + 1)*(size_t)n + 2*base + rows + k*k*rows + k*rows + square + 2*k, sizeof *memory);
    if (!memory)
        return LW_E_MEMORY;
    refiner f = { .w = w, .m = m, .n = n, .k = (int)k, .v = memory };
    double *found = f.v + k*(size_t)n;
    f.base = found + base, f.by = f.base + base, f.out = f.by + n, f.h = f.out + rows, f.g = f.h + k*k*rows;
    f.normal = f.g + k*rows, f.b = f.normal + square, f.d = f.b + k;
    keep(w, found);
    double first = to_double_root(&f), moved = first;
    for (int pass = 1; pass < 6 && moved > 1e-13; pass++)
        moved = to_double_root(&f);
    if (!(first > 0) || !(fill(w, n) < 4*closed) || !(lw_greatest(w->n_dim, w->total) <= LW_ADJUST_MOST))
        put_back(w, found);
    free(memory);
    return LW_OK;
}

static lw_status allocate(adjuster *w, int freedom, lw_error *e)
{
    size_t p = 1 + (size_t)(freedom*w->each), m = p*(size_t)w->n_row;
    size_t n = (size_t)w->n_dim + (w->of->doubles ? p*(size_t)w->n_q : 0);
    w->place = calloc(p*(size_t)w->n_place, sizeof *w->place);
    w->a = calloc(lw_rank_doubles((int)n, (int)m) + m + n, sizeof *w->a);
    w->order = calloc(lw_rank_ints((int)n, (int)m), sizeof *w->order);
    if (!w->place || !w->a || !w->order)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    w->right = w->a + lw_rank_doubles((int)n, (int)m);
    w->step = w->right + m;
    return LW_OK;
}

lw_status lw_adjust(const lw_adjustable *a, double *place, double *by, lw_error *e)
{
    adjuster w = { .of = a, .n_place = a->n_place, .n_q = a->n_q, .n_row = a->n_row, .n_dim = a->n_dim, .total = by };
    size_t n = (size_t)a->n_q, rows = (size_t)a->n_row;
    lw_rank r;
    memset(by, 0, (size_t)a->n_dim*sizeof *by);
    if (a->n_row == 0 || (1 + a->postures)*a->n_row > ROWS_MOST)
        return LW_NOTHING;
    w.phi = calloc(rows + rows*n + 4*n, sizeof *w.phi);
    w.doubles = calloc(lw_rank_doubles(a->n_q, a->n_row), sizeof *w.doubles);
    w.ints = calloc(lw_rank_ints(a->n_q, a->n_row), sizeof *w.ints);
    if (!w.phi || !w.doubles || !w.ints) {
        free_adjuster(&w);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    w.jac = w.phi + rows;
    w.other = w.jac + rows*n;
    factor(&w, place, 0, loose, &r);
    int freedom = a->n_q - r.rank;
    w.rank = r.rank;
    w.each = a->postures;
    while (w.each > LEAST_POSTURES && (1 + freedom*w.each)*a->n_row > ROWS_MOST)
        w.each -= 2;
    bool candidate = w.rank < a->n_row && freedom > 0 && (1 + freedom*w.each)*a->n_row <= ROWS_MOST, near = false;
    lw_status status = candidate ? allocate(&w, freedom, e) : LW_NOTHING;
    if (status == LW_OK) {
        double worst = 0;
        memcpy(w.place, place, (size_t)a->n_place*sizeof *place);
        w.n_posture = 1;
        for (int k = 0; k < freedom; k++) {
            int before = w.n_posture;
            double off = INFINITY;
            for (double stride = longest_stride; !isfinite(off) && stride >= least_stride; stride /= 2) {
                w.n_posture = before;
                off = walk(&w, k, stride);
            }
            worst = fmax(worst, off);
        }
        near = worst > exact && worst < LW_ADJUST_MOST && close_all(&w);
        status = !near ? LW_NOTHING : sharpen(&w) == LW_OK ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    if (status == LW_OK)
        memcpy(place, w.place, (size_t)a->n_place*sizeof *place);
    else {
        memset(by, 0, (size_t)a->n_dim*sizeof *by);
        a->change(a->context, by);
    }
    free_adjuster(&w);
    return status;
}

/* ---- a system ------------------------------------------------------------------------------------------------- */

/* Coordinates of the arms of a joint at both ends, and the direction of its line: five dimensions of each joint. */
typedef struct drawing { lw_system *s; lw_system_joint *drawn; } drawing;

static void system_rows(void *context, const double *q, double *phi, double *jac) { lw_system_rows(((drawing *)context)->s, q, phi, jac); }

static void system_move(void *context, double *q, const double *by)
{
    for (int c = 0; c < ((drawing *)context)->s->n_q; c++)
        q[c] += by[c];
}

static void system_change(void *context, const double *by)
{
    const drawing *d = context;
    for (int j = 0; j < d->s->n_joint; j++, by += 5) {
        lw_system_joint *to = &d->s->joint[j];
        const lw_system_joint *from = &d->drawn[j];
        for (int end = 0; end < 2 && lw_joint_has_position(to->kind); end++)
            to->arm[end] = lw_v2_add(from->arm[end], (lw_vec2){ by[2*end], by[2*end + 1] });
        if (lw_joint_slides(to->kind))
            to->along = lw_v2_turn(from->along, lw_v2_polar(1, by[4]));
    }
}

lw_status lw_system_adjust(lw_system *s, double *q, double *by, lw_error *e)
{
    size_t joints = (size_t)s->n_joint, n = joints*sizeof *s->joint;
    drawing d = { s, malloc(n + 1) };
    double *change = malloc((5*joints + 1)*sizeof *change);
    lw_adjustable a = { &d, s->n_q, s->n_q, s->n_row, 5*s->n_joint, 8, true, system_change, system_rows, system_move };
    lw_status st = d.drawn && change ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    *by = 0;
    if (st == LW_OK) {
        memcpy(d.drawn, s->joint, n);
        if ((st = lw_adjust(&a, q, change, e)) == LW_OK)
            *by = lw_greatest(a.n_dim, change);
        else
            memcpy(s->joint, d.drawn, n);
    }
    free(d.drawn), free(change);
    return st;
}

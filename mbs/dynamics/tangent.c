#include "mbs/dynamics/tangent_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"

/* ---- pattern -------------------------------------------------------------------------------------------- */

/* Numbers of an entry */
static size_t width_of(const lw_tangent *t) { return t->is_complex ? 2 : 1; }

static void list(lw_tangent *t, int row, int column)
{
    if (t->n_pair == t->most_pair && !t->failed) {
        long most = 2*t->most_pair + 256;
        int *more = realloc(t->pair, 2*(size_t)most*sizeof *more);
        t->failed = !more;
        t->pair = more ? more : t->pair;
        t->most_pair = more ? most : t->most_pair;
    }
    if (t->failed)
        return;
    t->pair[2*t->n_pair] = row;
    t->pair[2*t->n_pair++ + 1] = column;
}

static void list_force(void *context, int row, int column, double by_q, double by_v)
{
    (void)by_q, (void)by_v;
    list(context, row, column);
}

lw_status lw_tangent_make(lw_dynamics *d, bool is_complex, bool consistent, lw_tangent *t)
{
    *t = (lw_tangent){ .d = d, .is_complex = is_complex, .consistent = consistent, .n = d->n_v, .z = d->eq.n_z, .c = d->n_kept,
                       .scale = 1 };
    int first = t->n + t->z;
    d->eq.pattern(d->eq.context, &(lw_force_sink){ .context = t, .add = list_force, .add_state = list_force });
    for (int i = 0; i < first + t->c; i++)
        list(t, i, i);
    for (int k = 0; k < t->c; k++) {
        const int *block = lw_mbs_blocks(d, d->kept[k]);
        for (int b = 0; b < d->row_size && block[b/LW_BLOCK] >= 0; b++) {
            int i = LW_BLOCK*block[b/LW_BLOCK] + b%LW_BLOCK;
            list(t, i, first + k);
            list(t, first + k, i);
            for (int c = 0; c < d->row_size && block[c/LW_BLOCK] >= 0; c++)
                list(t, i, LW_BLOCK*block[c/LW_BLOCK] + c%LW_BLOCK);
        }
    }
    bool ok = !t->failed && lw_columns_make(&t->columns, first + t->c, t->pair, t->n_pair);
    free(t->pair);
    t->pair = NULL;
    t->value = ok ? calloc(width_of(t)*((size_t)t->columns.at[t->columns.n] + 1), sizeof *t->value) : NULL;
    t->lu = t->value ? lw_sparse_lu_create(&t->columns, t->c > 0, is_complex) : NULL;
    t->kept = t->lu ? malloc(((size_t)t->c + 1)*sizeof *t->kept) : NULL;
    bool more = consistent && d->eq.more_mass;
    t->heavy = t->kept && more ? calloc((size_t)t->columns.at[t->columns.n] + 1, sizeof *t->heavy) : NULL;
    t->work = t->heavy ? malloc((size_t)(first + t->c + 1)*sizeof *t->work) : NULL;
    if (!t->kept || (more && !t->work))
        return LW_E_MEMORY;
    memcpy(t->kept, d->kept, (size_t)t->c*sizeof *t->kept);
    return LW_OK;
}

lw_status lw_tangent_renew(lw_dynamics *d, bool is_complex, bool consistent, lw_tangent *t)
{
    if (t->kept && t->c == d->n_kept && memcmp(t->kept, d->kept, (size_t)t->c*sizeof *t->kept) == 0)
        return LW_OK;
    lw_tangent_free(t);
    return lw_tangent_make(d, is_complex, consistent, t);
}

void lw_tangent_free(lw_tangent *t)
{
    lw_sparse_lu_free(t->lu);
    lw_columns_free(&t->columns);
    free(t->value);
    free(t->heavy);
    free(t->work);
    free(t->pair);
    free(t->kept);
    memset(t, 0, sizeof *t);
}

/* ---- entries ---------------------------------------------------------------------------------------------- */

static void put(lw_tangent *t, int row, int column, double re, double im)
{
    double *value = t->value + width_of(t)*(size_t)lw_columns_find(&t->columns, row, column);
    value[0] += re;
    if (t->is_complex)
        value[1] += im;
}

static void put_force(void *context, int row, int column, double by_q, double by_v)
{
    lw_tangent *t = context;
    put(t, row, column, -by_q - t->weight_re*by_v, -t->weight_im*by_v);
}

static void put_state(void *context, int row, int column, double by_q, double by_v)
{
    lw_tangent *t = context;
    const lw_equations *eq = &t->d->eq;
    double scale = (column < t->n ? 1 : eq->state_scale(eq->context, column - t->n))/
                   (row < t->n ? 1 : eq->state_scale(eq->context, row - t->n));
    put_force(t, row, column, scale*by_q, scale*by_v);
}

/* Entries of the mass matrix besides its diagonal, weighed. */
static void put_mass(void *context, int row, int column, double by_q, double by_v)
{
    lw_tangent *t = context;
    (void)by_v;
    put(t, row, column, t->mass_re*by_q, t->mass_im*by_q);
    t->heavy[lw_columns_find(&t->columns, row, column)] += by_q;
}

typedef struct product { const double *x; double *out; } product;

static void multiply(void *context, int row, int column, double by_q, double by_v)
{
    const product *p = context;
    (void)by_v;
    p->out[row] += by_q*p->x[column];
}

void lw_tangent_mass(const lw_tangent *t, const double *q, const double *x, double *out)
{
    const lw_equations *eq = &t->d->eq;
    for (int i = 0; i < t->n; i++)
        out[i] = eq->mass[i]*x[i];
    if (t->consistent && eq->more_mass)
        eq->more_mass(eq->context, q, &(lw_force_sink){ .context = &(product){ x, out }, .add = multiply });
}

void lw_tangent_mass_filled(const lw_tangent *t, const double *x, double *out)
{
    for (int i = 0; i < t->n; i++)
        out[i] = t->d->eq.mass[i]*x[i];
    for (int j = 0; t->heavy && j < t->n; j++)
        for (int k = t->columns.at[j]; k < t->columns.at[j + 1]; k++)
            if (t->columns.row[k] < t->n)
                out[t->columns.row[k]] += t->heavy[k]*x[j];
}

void lw_tangent_damp(const lw_tangent *t, double by, const double *x, double *out)
{
    const lw_columns *a = &t->columns;
    by /= t->weight_im;
    for (int j = 0; j < t->n; j++) {
        for (int k = a->at[j]; k < a->at[j + 1]; k++)
            if (a->row[k] < t->n + t->z)
                out[a->row[k]] += by*(t->value[2*k + 1] - (t->heavy ? t->mass_im*t->heavy[k] : 0))*x[j];
        out[j] -= by*t->mass_im*t->d->eq.mass[j]*x[j];
    }
}

static void put_rows(lw_tangent *t, const double *l)
{
    const lw_dynamics *d = t->d;
    for (int k = 0; k < t->c; k++) {
        int row = d->kept[k];
        const int *block = lw_mbs_blocks(d, row);
        for (int b = 0; b < d->eq.n_slot && block[b] >= 0; b++)
            for (int i = 0; i < 3; i++) {
                double x = t->scale*lw_mbs_jac(d, row)[LW_BLOCK*b + i];
                put(t, LW_BLOCK*block[b] + i, t->n + t->z + k, x, 0);
                put(t, t->n + t->z + k, LW_BLOCK*block[b] + i, x, 0);
            }
        for (int e = (l ? lw_mbs_bends(d, row) : 0) - 1; e >= 0; e--)
            put(t, d->bend[e].a, d->bend[e].b, l[k]*d->bend[e].h, 0);
    }
}

/* Weights are m; the scale is that of the diagonal. */
static void put_masses(lw_tangent *t, const double *q, const double m[2])
{
    const lw_equations *eq = &t->d->eq;
    for (int i = 0; i < t->n; i++)
        put(t, i, i, m[0]*eq->mass[i], m[1]*eq->mass[i]);
    t->mass_re = m[0];
    t->mass_im = m[1];
    if (t->heavy) {
        memset(t->heavy, 0, (size_t)t->columns.at[t->columns.n]*sizeof *t->heavy);
        eq->more_mass(eq->context, q, &(lw_force_sink){ .context = t, .add = put_mass });
    }
    double most = 0;
    for (int i = 0; i < t->n; i++)
        most = fmax(most, fabs(t->value[width_of(t)*(size_t)lw_columns_find(&t->columns, i, i)]));
    t->scale = most > 0 ? most : 1;
}

void lw_tangent_fill(lw_tangent *t, double time, const double *q, const double *v, const double *l, const double m[2], const double c[2])
{
    lw_dynamics *d = t->d;
    memset(t->value, 0, width_of(t)*(size_t)t->columns.at[t->columns.n]*sizeof *t->value);
    t->weight_re = c[0];
    t->weight_im = c[1];
    d->eq.derivatives(d->eq.context, time, q, v, d->force, &(lw_force_sink){ .context = t, .add = put_force,
                                                                                                  .add_state = put_state });
    if (t->rubs) {
        lw_tangent_spread(d, l);
        lw_mbs_rub_slopes(d, q, v, &(lw_force_sink){ .context = t, .add = put_force });
    }
    for (int i = 0; i < t->z; i++)
        put(t, t->n + i, t->n + i, c[0], c[1]);
    put_masses(t, q, m);
    put_rows(t, l);
}

lw_status lw_tangent_factor(lw_tangent *t, double time, const double *q, const double *v, const double *l,
                            const double m[2], const double c[2])
{
    lw_tangent_fill(t, time, q, v, l, m, c);
    lw_status s = lw_sparse_lu_factor(t->lu, t->value);
    return s == LW_OPEN ? LW_E_NUMERIC : s;
}

void lw_tangent_solve(lw_tangent *t, double *b)
{
    int width = t->is_complex ? 2 : 1;
    for (int i = width*(t->n + t->z); i < width*(t->n + t->z + t->c); i++)
        b[i] *= t->scale;
    lw_sparse_lu_solve(t->lu, b);
    for (int i = width*(t->n + t->z); i < width*(t->n + t->z + t->c); i++)
        b[i] *= t->scale;
}

void lw_tangent_push(const lw_dynamics *d, const double *l, double *out)
{
    for (int k = 0; k < d->n_kept; k++) {
        const int *block = lw_mbs_blocks(d, d->kept[k]);
        const double *jac = lw_mbs_jac(d, d->kept[k]);
        for (int b = 0; b < d->eq.n_slot && block[b] >= 0; b++)
            for (int i = 0; i < 3; i++)
                out[LW_BLOCK*block[b] + i] += l[k]*jac[LW_BLOCK*b + i];
    }
}

void lw_tangent_spread(lw_dynamics *d, const double *l)
{
    memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
    for (int k = 0; k < d->n_kept; k++)
        d->l[d->kept[k]] = l[k];
}

static const int most_passes = 60;
/* Of slender bars the mass of some shapes is tiny, so rounding of forces gives accelerations that no refinement takes away: changes that no
 * longer fall, below this part of the accelerations and of the squares of velocities, or below an acceleration that is none. */
static const double rounded = 1e-8, no_acceleration = 1e-10;

lw_status lw_tangent_accelerate(lw_dynamics *d, const double *q, const double *v, const double *force, double *a, double *l)
{
    lw_tangent *t = d->masses;
    if (!t && !(t = d->masses = calloc(1, sizeof *t)))
        return lw_error_set(d->e, LW_E_MEMORY, "out of memory");
    int n = d->n_v, first = n + d->eq.n_z, all = first + d->n_kept;
    lw_status s = lw_tangent_renew(d, false, true, t);
    if (s != LW_OK)
        return lw_error_set(d->e, s, "out of memory");
    double *b = t->work, before = INFINITY, fastest = 0;
    memset(t->value, 0, (size_t)t->columns.at[t->columns.n]*sizeof *t->value);
    put_masses(t, q, (const double[]){ 1, 0 });
    for (int i = n; i < first; i++)
        put(t, i, i, 1, 0);
    put_rows(t, NULL);
    for (int i = 0; i < n; i++)
        fastest = fmax(fastest, fabs(v[i]));
    memset(a, 0, (size_t)n*sizeof *a);
    memset(l, 0, (size_t)d->n_c*sizeof *l);
    s = lw_sparse_lu_factor(t->lu, t->value);
    s = s == LW_OK ? LW_NOTHING : s;
    for (int pass = 0; s == LW_NOTHING; pass++) {            /* the first solves, the next ones refine; friction takes more */
        double change = 0, size = 0;
        memset(b, 0, (size_t)all*sizeof *b);
        d->eq.more_inertia(d->eq.context, q, v, a, b);
        for (int i = 0; i < n; i++)
            b[i] = force[i] - d->eq.mass[i]*a[i] - b[i];
        if (d->n_friction) {
            if (l != d->l)
                memcpy(d->l, l, (size_t)d->n_c*sizeof *l);
            lw_mbs_rub(d, q, v, b);
        }
        for (int k = 0; k < d->n_kept; k++) {
            int row = d->kept[k];
            const int *block = lw_mbs_blocks(d, row);
            for (int c = 0; c < d->row_size && block[c/LW_BLOCK] >= 0; c++)
                b[LW_BLOCK*block[c/LW_BLOCK] + c%LW_BLOCK] -= l[row]*lw_mbs_jac(d, row)[c];
            b[first + k] = d->rhs[row] - lw_mbs_row_rate(d, row, a);
        }
        lw_tangent_solve(t, b);
        for (int i = 0; i < n; i++) {
            a[i] += b[i];
            change = fmax(change, fabs(b[i]));
            size = fmax(size, fabs(a[i]));
        }
        for (int k = 0; k < d->n_kept; k++)
            l[d->kept[k]] += b[first + k];
        if (!(change < INFINITY) || pass == most_passes)
            s = LW_OPEN;
        else if (pass > 0 && (change <= 4e-16*size || (change <= rounded*(size + fastest*fastest) + no_acceleration && change > 0.3*before)))
            s = LW_OK;
        before = change;
    }
    return s;
}

lw_status lw_tangent_at_rest(lw_dynamics *d, double t, const double *q, const double *still, double *a, double *l)
{
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    if (s != LW_OK)
        return s;
    d->eq.forces(d->eq.context, t, q, still, d->force, NULL);
    for (int i = 0; i < d->n_v; i++)
        if (!isfinite(d->force[i]))
            return LW_E_NUMERIC;
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    s = lw_mbs_linear(d, d->force, d->rhs, a, d->l);
    for (int k = 0; k < d->n_kept; k++)
        l[k] = d->l[d->kept[k]];
    return s;
}

#include "mbs/dynamics/tangent_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"

/* ---- pattern -------------------------------------------------------------------------------------------- */

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

static void list_each(lw_tangent *t, int row, int column)
{
    int width = t->is_complex ? 2 : 1;
    for (int i = 0; i < width; i++)
        for (int j = 0; j < width; j++)
            list(t, width*row + i, width*column + j);
}

static void list_force(void *context, int row, int column, double by_q, double by_v)
{
    (void)by_q, (void)by_v;
    list_each(context, row, column);
}

lw_status lw_tangent_make(lw_dynamics *d, bool is_complex, bool consistent, lw_tangent *t)
{
    *t = (lw_tangent){ .d = d, .is_complex = is_complex, .consistent = consistent, .n = d->n_q, .c = d->n_kept, .scale = 1 };
    d->eq.pattern(d->eq.context, &(lw_force_sink){ .context = t, .add = list_force });
    for (int i = 0; i < t->n + t->c; i++)
        list_each(t, i, i);
    for (int k = 0; k < t->c; k++) {
        const int *body = d->row_body[d->kept[k]];
        int coordinate[LW_ROW_SIZE], count = 0;
        for (int b = 0; b < LW_ROW_SIZE && body[b/3] >= 0; b++)
            coordinate[count++] = 3*body[b/3] + b%3;
        for (int b = 0; b < count; b++) {
            list_each(t, coordinate[b], t->n + k);
            list_each(t, t->n + k, coordinate[b]);
            for (int j = 0; j < count; j++)
                list_each(t, coordinate[b], coordinate[j]);
        }
    }
    int n = (is_complex ? 2 : 1)*(t->n + t->c);
    bool ok = !t->failed && lw_columns_make(&t->columns, n, t->pair, t->n_pair);
    free(t->pair);
    t->pair = NULL;
    t->value = ok ? calloc((size_t)t->columns.at[n] + 1, sizeof *t->value) : NULL;
    t->lu = t->value ? lw_sparse_lu_create(&t->columns) : NULL;
    return t->lu ? LW_OK : LW_E_MEMORY;
}

void lw_tangent_free(lw_tangent *t)
{
    lw_sparse_lu_free(t->lu);
    lw_columns_free(&t->columns);
    free(t->value);
    free(t->pair);
    memset(t, 0, sizeof *t);
}

/* ---- entries ---------------------------------------------------------------------------------------------- */

static void put(lw_tangent *t, int row, int column, double re, double im)
{
    if (!t->is_complex) {
        t->value[lw_columns_find(&t->columns, row, column)] += re;
        return;
    }
    int left = lw_columns_find(&t->columns, 2*row, 2*column), right = lw_columns_find(&t->columns, 2*row, 2*column + 1);
    t->value[left] += re;
    t->value[left + 1] += im;
    t->value[right] -= im;
    t->value[right + 1] += re;
}

static void put_force(void *context, int row, int column, double by_q, double by_v)
{
    lw_tangent *t = context;
    put(t, row, column, -by_q - t->weight_re*by_v, -t->weight_im*by_v);
}

/* What the consistent mass of an element has besides its lumps; calls add for each entry. */
static void mass_besides_lumps(const lw_tangent *t, const double *q, int beam, int at[6], double out[6][6])
{
    const lw_dynamics *d = t->d;
    const lw_beam *b = &d->model->beam[beam];
    double h = b->length, k = 12*b->stiffness[2]/(h*h*b->stiffness[1]) - 1, turn = 0;
    for (int end = 0; end < 2; end++) {
        int body = d->s.body[b->link[end]];
        turn += 0.5*q[3*body + 2];
        for (int i = 0; i < 3; i++)
            at[3*end + i] = 3*body + i;
    }
    lw_beam_mass(b->mass, h, k, b->gyration, b->direction + turn, out);
    for (int i = 0; i < 6; i++) {
        out[i][i] -= 0.5*b->mass*(i%3 == 2 ? b->gyration : 1);
        for (int j = 0; j < 6; j++)
            out[i][j] *= (i%3 == 2 ? 1 : d->s.unit)*(j%3 == 2 ? 1 : d->s.unit);
    }
}

void lw_tangent_mass(const lw_tangent *t, const double *q, const double *x, double *out)
{
    int at[6];
    double m[6][6];
    for (int i = 0; i < t->n; i++)
        out[i] = t->d->f.mass[i]*x[i];
    for (int b = 0; t->consistent && b < t->d->model->n_beam; b++) {
        if (!t->d->model->beam[b].consistent)
            continue;
        mass_besides_lumps(t, q, b, at, m);
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++)
                out[at[i]] += m[i][j]*x[at[j]];
    }
}

static void put_rows(lw_tangent *t, const double *l)
{
    const lw_dynamics *d = t->d;
    for (int k = 0; k < t->c; k++) {
        int row = d->kept[k];
        lw_bend bend[LW_BEND_MAX];
        for (int b = 0; b < LW_SYSTEM_ROW_BODIES && d->row_body[row][b] >= 0; b++)
            for (int i = 0; i < 3; i++) {
                double x = t->scale*d->jac[row*LW_ROW_SIZE + 3*b + i];
                put(t, 3*d->row_body[row][b] + i, t->n + k, x, 0);
                put(t, t->n + k, 3*d->row_body[row][b] + i, x, 0);
            }
        bool plain = row < d->n_row && !lw_joint_has_ratio(d->s.joint[d->s.row[row].joint].kind)
                     && !(d->s.n_tie && row >= d->s.tie_row);
        for (int e = (plain ? d->eq.bends(d->eq.context, row, bend) : 0) - 1; e >= 0; e--) {
            put(t, bend[e].a, bend[e].b, l[k]*bend[e].h, 0);
            if (bend[e].a != bend[e].b)
                put(t, bend[e].b, bend[e].a, l[k]*bend[e].h, 0);
        }
    }
}

lw_status lw_tangent_factor(lw_tangent *t, double time, const double *q, const double *v, const double *l,
                            const double m[2], const double c[2])
{
    lw_dynamics *d = t->d;
    memset(t->value, 0, (size_t)t->columns.at[t->columns.n]*sizeof *t->value);
    t->weight_re = c[0];
    t->weight_im = c[1];
    d->eq.derivatives(d->eq.context, time, q, v, d->force, &(lw_force_sink){ .context = t, .add = put_force });
    for (int i = 0; i < t->n; i++)
        put(t, i, i, m[0]*d->f.mass[i], m[1]*d->f.mass[i]);
    for (int b = 0; t->consistent && b < d->model->n_beam; b++) {
        int at[6];
        double more[6][6];
        if (!d->model->beam[b].consistent)
            continue;
        mass_besides_lumps(t, q, b, at, more);
        for (int i = 0; i < 36; i++)
            put(t, at[i/6], at[i%6], m[0]*more[i/6][i%6], m[1]*more[i/6][i%6]);
    }
    double most = 0;                             /* of the diagonal */
    for (int i = 0, width = t->is_complex ? 2 : 1; i < t->n; i++)
        most = fmax(most, fabs(t->value[lw_columns_find(&t->columns, width*i, width*i)]));
    t->scale = most > 0 ? most : 1;
    put_rows(t, l);
    return lw_sparse_lu_factor(t->lu, t->value) ? LW_OK : LW_E_NUMERIC;
}

void lw_tangent_solve(lw_tangent *t, double *b)
{
    int width = t->is_complex ? 2 : 1;
    for (int i = width*t->n; i < width*(t->n + t->c); i++)
        b[i] *= t->scale;
    lw_sparse_lu_solve(t->lu, b);
    for (int i = width*t->n; i < width*(t->n + t->c); i++)
        b[i] *= t->scale;
}

void lw_tangent_push(const lw_dynamics *d, const double *l, double *out)
{
    for (int k = 0; k < d->n_kept; k++)
        for (int b = 0; b < LW_SYSTEM_ROW_BODIES && d->row_body[d->kept[k]][b] >= 0; b++)
            for (int i = 0; i < 3; i++)
                out[3*d->row_body[d->kept[k]][b] + i] += l[k]*d->jac[d->kept[k]*LW_ROW_SIZE + 3*b + i];
}

lw_status lw_tangent_at_rest(lw_dynamics *d, double t, const double *q, const double *still, double *a, double *l)
{
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    if (s != LW_OK)
        return s;
    d->eq.forces(d->eq.context, t, q, still, d->force, NULL);
    for (int i = 0; i < d->n_q; i++)
        if (!isfinite(d->force[i]))
            return LW_E_NUMERIC;
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    s = lw_mbs_linear(d, d->force, d->rhs, a, d->l);
    for (int k = 0; k < d->n_kept; k++)
        l[k] = d->l[d->kept[k]];
    return s;
}

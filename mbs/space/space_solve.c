/* mbs/space/space_solve.c - rows in force, their basis and factors. */
#include "mbs/space/space_solve.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"

static const double small_change = 1e-10;    /* a refinement that changes the multipliers by less, relative, leaves rounding only */
static const int most_refined = 8;           /* corrections */
static const double left_over = 1e-16;       /* the same of what the next one would change, to go by the last two */
static const double least_share = 1e-11;     /* pivot over its diagonal below which a row depends on others */

double lw_space_length(const lw_space *s, const double *by)
{
    double most = 0;
    for (int i = 0; i < s->n_v; i++)
        most = fabs(by[i]) > most ? fabs(by[i]) : most;
    return most;
}

void lw_space_metric(const lw_space *s, double *weight)
{
    for (int i = 0; i < s->n_v; i++)
        weight[i] = 1;
}

/* ---- memory ---------------------------------------------------------------------------------------------- */

void lw_space_rows_free(lw_space_rows_set *z)
{
    lw_cholesky_free(&z->schur);
    free(z->pair);
    free(z->memory);
    memset(z, 0, sizeof *z);
}

static void find_bodies(lw_space_rows_set *z)
{
    const lw_space *s = z->s;
    for (int r = 0; r < z->n_row; r++)
        z->at[r + 1] = z->at[r] + (r >= s->n_joint_row && r < s->n_row ? 6*s->coupling[r - s->n_joint_row].n_side : LW_SPACE_ROW);
    for (int j = 0; j < s->n_joint; j++)
        for (int k = 0; k < lw_spatial_kind_of(s->joint[j].kind)->rows; k++)
            memcpy(lw_space_rows_bodies(z, s->joint[j].row + k), s->joint[j].body, sizeof s->joint[j].body);
    for (int i = 0; i < s->n_coupling; i++)
        memcpy(lw_space_rows_bodies(z, s->n_joint_row + i), s->coupling[i].body, (size_t)s->coupling[i].n_side*sizeof(int));
    for (int i = 0; i < z->n_extra; i++)
        lw_space_bodies(s, &z->extra[i], lw_space_rows_bodies(z, s->n_row + i));
}

static inline double dot6(const double *a, const double *b)
{
    const lw_pair *p = (const lw_pair *)a, *q = (const lw_pair *)b;
    lw_pair sum = p[0]*q[0] + p[1]*q[1] + p[2]*q[2];
    return sum[0] + sum[1];
}

/* x += f times row r of `jac` (J or J W). */
static inline void add_row(const lw_space_rows_set *z, int r, const double *jac, double f, double *x)
{
    const int *body = lw_space_rows_bodies(z, r), n = lw_space_rows_sides(z, r);
    const lw_pair *from = (const lw_pair *)(jac + z->at[r]);
    for (int k = 0; k < n; k++, from += 3) {
        lw_pair *to = (lw_pair *)(x + 6*body[k]);
        if (body[k] >= 0)
            to[0] += f*from[0], to[1] += f*from[1], to[2] += f*from[2];
    }
}

static int side_of(const lw_space_rows_set *z, int r, int body)
{
    int k = 0;
    while (lw_space_rows_bodies(z, r)[k] != body)
        k++;
    return 6*k;
}

lw_status lw_space_rows_make(const lw_space *s, const lw_space_extra *extra, int n_extra, const double *weight,
                             const double *q,
                             lw_space_rows_set *z, lw_error *e)
{
    memset(z, 0, sizeof *z);
    z->s = s;
    z->n_extra = n_extra;
    z->n_row = s->n_row + n_extra;
    z->n_near = n_extra + (s->n_coupling ? s->n_joint : 0);
    size_t rows = (size_t)z->n_row + 1, v = (size_t)s->n_v, x = (size_t)n_extra + 1, near = (size_t)z->n_near + 1;
    size_t q_size = (size_t)s->n_q, jac = rows*LW_SPACE_ROW;
    for (int i = 0; i < s->n_coupling; i++)
        jac += 6*(size_t)s->coupling[i].n_side - LW_SPACE_ROW;
    size_t doubles_all = 2*(jac + rows) + 4*v + 4*(rows + v) + near + 2*q_size;
    size_t bytes = doubles_all*sizeof(double) + ((size_t)s->n_body + 1)*sizeof *z->frame +
                   x*sizeof *z->extra + (jac/6 + 3*rows)*sizeof(int);
    char *at = z->memory = calloc(1, bytes);
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double **const doubles[] = { &z->jac, &z->jac_w, &z->phi, &z->small, &z->weight, &z->full, &z->step, &z->moved,
                                 &z->near, &z->filled, &z->factored };
    const size_t sizes[] = { jac, jac, rows, rows, v, v, v, v, near, q_size, q_size };
    for (size_t i = 0; i < sizeof doubles/sizeof *doubles; i++) {
        *doubles[i] = (double *)(void *)at;
        at += sizes[i]*sizeof(double);
    }
    z->four = (double (*)[4])(void *)at, at += (rows + v)*sizeof *z->four;
    z->frame = (lw_space_frame *)(void *)at, at += ((size_t)s->n_body + 1)*sizeof *z->frame;
    z->extra = (lw_space_extra *)(void *)at, at += x*sizeof *z->extra;
    z->body = (int *)(void *)at, at += jac/6*sizeof *z->body;
    z->at = (int *)(void *)at, at += rows*sizeof(int);
    z->kept = (int *)(void *)at, at += rows*sizeof(int);
    z->place = (int *)(void *)at;
    if (n_extra)
        memcpy(z->extra, extra, (size_t)n_extra*sizeof *extra);
    memcpy(z->weight, weight, v*sizeof *weight);
    find_bodies(z);
    lw_status st = lw_space_rows_arrange(z, q, e);
    if (st != LW_OK)
        lw_space_rows_free(z);
    return st;
}

/* ---- rows ------------------------------------------------------------------------------------------------- */

void lw_space_rows_fill(lw_space_rows_set *z, const double *q, const double *target)
{
    const lw_space *s = z->s;
    memcpy(z->filled, q, (size_t)s->n_q*sizeof *q);
    lw_space_place(s, q, z->frame);
    lw_space_rows(s, z->frame, z->phi, z->jac);
    for (int i = 0, r = s->n_joint_row; i < s->n_coupling; i++, r++)
        lw_space_coupling_row(s, i, z->frame, z->near + z->n_extra, &z->phi[r], z->jac + z->at[r]);
    for (int i = 0; i < z->n_extra; i++) {
        const lw_space_extra *x = &z->extra[i];
        double *jac = z->jac + z->at[s->n_row + i], *phi = &z->phi[s->n_row + i];
        if (x->spin) {
            *phi = 0;
            memset(jac, 0, LW_SPACE_ROW*sizeof *jac);
            jac[3] = x->axis.x, jac[4] = x->axis.y, jac[5] = x->axis.z;
        } else
            *phi = lw_space_measure(s, z->frame, x->measure, target ? target[i] : z->near[i], jac) -
                   (target ? target[i] : 0);
    }
}

double lw_space_rows_open(const lw_space_rows_set *z) { return lw_greatest(z->s->n_row, z->phi); }

/* J W, with 0 where a row has no body. */
static void weigh(lw_space_rows_set *z)
{
    for (int r = 0; r < z->n_row; r++) {
        double *jac = z->jac + z->at[r], *to = z->jac_w + z->at[r];
        const int *body = lw_space_rows_bodies(z, r);
        for (int k = 0; k < lw_space_rows_sides(z, r); k++) {
            const double *w = z->weight + 6*body[k];
            for (int i = 6*k; i < 6*k + 6; i++)
                to[i] = body[k] < 0 ? 0 : jac[i]*w[i - 6*k];
        }
    }
}

bool lw_space_rows_factor(lw_space_rows_set *z)
{
    double *value = z->schur.value;
    memcpy(z->factored, z->filled, (size_t)z->s->n_q*sizeof *z->filled);
    weigh(z);
    if (z->n_kept == 0) {
        z->weak = 1;
        return true;
    }
    if (!value)
        return false;
    memset(value, 0, (size_t)(z->schur.n_entry + z->n_kept)*sizeof *value);
    for (int p = 0; p < z->n_pair; p++)
        value[z->pair[p].to] += dot6(z->jac + z->pair[p].row, z->jac_w + z->pair[p].other);
    z->weak = lw_cholesky_factor(&z->schur, 0, NULL);
    return z->weak > 1e-14;
}

bool lw_space_rows_factor_near(lw_space_rows_set *z)
{
    double most = 1e-7*sqrt(z->weak);        /* factors are wrong by off/sqrt(weak), refined solves by its square */
    bool near = z->weak > 1e-14;
    for (int i = 0; near && i < z->s->n_q; i++)
        near = fabs(z->filled[i] - z->factored[i]) <= most;
    if (!near)
        return lw_space_rows_factor(z);
    weigh(z);
    return true;
}

/* ---- basis ---------------------------------------------------------------------------------------------------- */

/* Analyse the pattern of the kept rows; kept is in the order of the rows, and gets that of elimination. */
static lw_status analyse(lw_space_rows_set *z, lw_error *e)
{
    const lw_space *s = z->s;
    int n = z->n_kept, nb = s->n_body, pairs = 0;
    lw_cholesky_free(&z->schur);
    free(z->pair);
    z->pair = NULL;
    z->n_pair = 0;
    if (n == 0)
        return LW_OK;
    int *first = calloc((size_t)nb + 2, sizeof *first), *list = malloc(((size_t)z->at[z->n_row]/6 + 1)*sizeof *list);
    int *mark = malloc(((size_t)n + 1)*sizeof *mark), *near_at = malloc(((size_t)n + 1)*sizeof *near_at), *near = NULL;
    int *order = malloc((size_t)n*sizeof *order);
    bool good = first && list && mark && near_at && order;
    if (good) {                              /* kept rows of each body */
        for (int i = 0; i < n; i++)
            for (int k = 0; k < lw_space_rows_sides(z, z->kept[i]); k++)
                if (lw_space_rows_bodies(z, z->kept[i])[k] >= 0)
                    first[lw_space_rows_bodies(z, z->kept[i])[k] + 2]++;
        for (int b = 2; b <= nb + 1; b++)
            first[b] += first[b - 1];
        for (int i = 0; i < n; i++)
            for (int k = 0; k < lw_space_rows_sides(z, z->kept[i]); k++)
                if (lw_space_rows_bodies(z, z->kept[i])[k] >= 0)
                    list[first[lw_space_rows_bodies(z, z->kept[i])[k] + 1]++] = i;
        size_t most = 0;
        for (int b = 0; b < nb; b++) {
            size_t c = (size_t)(first[b + 1] - first[b]);
            most += c*c;
            pairs += (int)(c*(c + 1)/2);
        }
        near = malloc((most + 1)*sizeof *near);
        z->pair = malloc(((size_t)pairs + 1)*sizeof *z->pair);
        good = near && z->pair;
    }
    if (good) {
        int at = 0;
        for (int i = 0; i < n; i++)
            mark[i] = -1;
        for (int i = 0; i < n; i++) {
            near_at[i] = at;
            mark[i] = i;
            for (int k = 0; k < lw_space_rows_sides(z, z->kept[i]); k++) {
                int b = lw_space_rows_bodies(z, z->kept[i])[k];
                for (int p = b < 0 ? 0 : first[b]; b >= 0 && p < first[b + 1]; p++)
                    if (mark[list[p]] != i) {
                        mark[list[p]] = i;
                        near[at++] = list[p];
                    }
            }
        }
        near_at[n] = at;
        good = lw_cholesky_make(&z->schur, n, near_at, near);
    }
    if (good) {
        memcpy(order, z->kept, (size_t)n*sizeof *order);
        for (int i = 0; i < n; i++)
            z->kept[i] = order[z->schur.order[i]];
        for (int i = 0; i < z->n_row; i++)
            z->place[i] = -1;
        for (int i = 0; i < n; i++)
            z->place[z->kept[i]] = i;
        for (int b = 0; b < nb; b++)         /* list holds places in the old order of kept */
            for (int p = first[b]; p < first[b + 1]; p++)
                for (int o = first[b]; o <= p; o++) {
                    int row = order[list[p]], other = order[list[o]], i = z->place[row], j = z->place[other];
                    z->pair[z->n_pair++] = (lw_space_pair){ z->at[row] + side_of(z, row, b), z->at[other] + side_of(z, other, b),
                                                            lw_cholesky_entry(&z->schur, i < j ? i : j, i < j ? j
                                                                              : i) };
                }
    }
    free(first), free(list), free(mark), free(near_at), free(near), free(order);
    return good ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* J times the root of W, transposed. */
static void fill_dense(const lw_space_rows_set *z, lw_space_dense *d)
{
    memset(d->rank.a, 0, (size_t)d->n_v*(size_t)d->n_row*sizeof *d->rank.a);
    for (int r = 0; r < d->n_row; r++) {
        const int *body = lw_space_rows_bodies(z, r);
        for (int k = 0; k < lw_space_rows_sides(z, r); k++)
            for (int i = 0; body[k] >= 0 && i < 6; i++)
                d->rank.a[6*body[k] + i + r*d->n_v] = z->jac[z->at[r] + 6*k + i]*sqrt(z->weight[6*body[k] + i]);
    }
}

/* Among all rows, a basis of at most n rows that are as independent as possible; rows of which less than `least` remains are left out. */
static lw_status choose_basis(lw_space_rows_set *z, int n, double least, lw_error *e)
{
    lw_space_dense d;
    lw_status st = lw_space_dense_make(z, &d, e);
    if (st != LW_OK)
        return st;
    d.rank.most = n;
    fill_dense(z, &d);
    for (int r = 0; r < z->n_row; r++) {         /* a row of a heavy link counts as much as one of a light link */
        double *row = d.rank.a + (size_t)r*(size_t)d.n_v, size = 1/sqrt(lw_dot(d.n_v, row, row));
        for (int i = 0; isfinite(size) && i < d.n_v; i++)
            row[i] *= size;
    }
    lw_rank_factor(&d.rank, least);
    bool *in = calloc((size_t)z->n_row, sizeof *in);
    for (int i = 0; in && i < d.rank.rank; i++)
        in[d.rank.column[i]] = true;
    z->n_kept = 0;
    for (int i = 0; in && i < z->n_row; i++)
        if (in[i])
            z->kept[z->n_kept++] = i;
    lw_space_dense_free(&d);
    st = in ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(in);
    return st;
}

static lw_status arrange(lw_space_rows_set *z, const double *q, lw_error *e)
{
    int n = z->rank;
    lw_space_rows_fill(z, q, NULL);
    z->weak = NAN;
    bool known = n > 0 && n < z->n_row;
    if (!known || z->n_row > LW_SPACE_MANY_ROWS) {    /* count the rows that depend on none before them */
        z->n_kept = z->n_row;
        for (int i = 0; i < z->n_row; i++)
            z->kept[i] = i;
        lw_status st = analyse(z, e);
        if (st != LW_OK || z->n_row == 0)
            return st;
        bool *dependent = calloc((size_t)z->n_row, sizeof *dependent);
        if (!dependent)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        weigh(z);
        memset(z->schur.value, 0, (size_t)(z->schur.n_entry + z->n_kept)*sizeof *z->schur.value);
        for (int p = 0; p < z->n_pair; p++)
            z->schur.value[z->pair[p].to] += dot6(z->jac + z->pair[p].row, z->jac_w + z->pair[p].other);
        double least = lw_cholesky_factor(&z->schur, least_share, dependent);
        int count = 0;
        for (int i = 0; i < z->n_row; i++)
            count += !dependent[i];
        bool clear = least > LW_SPACE_CLEAR_SHARE;
        if (count == z->n_row && !known && (clear || z->n_row > LW_SPACE_MANY_ROWS))
            return free(dependent), LW_OK;
        z->n_kept = 0;
        for (int i = 0; i < z->n_row; i++)
            if (!dependent[z->place[i]])
                z->kept[z->n_kept++] = i;
        free(dependent);
        if (z->n_row > LW_SPACE_MANY_ROWS && clear && (!known || z->n_kept == n))
            return analyse(z, e);
        if (z->n_row <= LW_SPACE_MANY_ROWS && !clear && !known) {     /* pivots of squares are as small by rounding */
            st = choose_basis(z, z->n_row, sqrt(least_share), e);
            return st == LW_OK ? analyse(z, e) : st;
        }
        n = known ? n : z->n_kept;
    }
    lw_status st = choose_basis(z, n, 1e-12, e);
    return st == LW_OK ? analyse(z, e) : st;
}

lw_status lw_space_rows_arrange(lw_space_rows_set *z, const double *q, lw_error *e)
{
    lw_status st = arrange(z, q, e);
    z->rank = st == LW_OK && z->n_kept > z->rank ? z->n_kept : z->rank;
    if (st != LW_OK) {                       /* no part of an arrangement is left: no factors, until the next one */
        lw_cholesky_free(&z->schur);
        z->n_kept = z->n_row;
    }
    return st;
}

/* ---- solving ----------------------------------------------------------------------------------------------------- */

void lw_space_rows_add(const lw_space_rows_set *z, double sign, const double *l, double *x)
{
    for (int r = 0; r < z->n_row; r++)
        if (l[r] != 0)
            add_row(z, r, z->jac, sign*l[r], x);
}

static double row_times(const lw_space_rows_set *z, int r, const double *x)
{
    const int *body = lw_space_rows_bodies(z, r);
    double sum = 0;
    for (int k = 0; k < lw_space_rows_sides(z, r); k++)
        if (body[k] >= 0)
            sum += dot6(z->jac + z->at[r] + 6*k, x + 6*body[k]);
    return sum;
}

double lw_space_rows_left_out(const lw_space_rows_set *z, const double *x, const double *rhs)
{
    double most = 0;
    for (int r = 0; r < z->n_row; r++)
        if (z->place[r] < 0)
            most = fmax(most, fabs(row_times(z, r, x) - rhs[r]));
    return most;
}

/* l -= (J W J^T)^-1 (rhs - J x), x changed by W J^T of that; still: x is 0.  Returns the greatest change of l. */
static double improve(lw_space_rows_set *z, const double *rhs, bool still, double *x, double *l)
{
    double *b = z->small, most = 0;
    for (int i = 0; i < z->n_kept; i++) {
        int r = z->kept[i];
        const double *jac = z->jac + z->at[r];
        const int *body = lw_space_rows_bodies(z, r);
        b[i] = rhs ? -rhs[r] : 0;
        if (still)
            continue;
        for (int k = 0; k < lw_space_rows_sides(z, r); k++)
            if (body[k] >= 0)
                b[i] += dot6(jac + 6*k, x + 6*body[k]);
    }
    if (z->n_kept)
        lw_cholesky_solve_overlapped(&z->schur, b);
    for (int i = 0; i < z->n_kept; i++) {
        int r = z->kept[i];
        l[r] += b[i];
        add_row(z, r, z->jac_w, -b[i], x);
        most = fabs(b[i]) > most ? fabs(b[i]) : most;
    }
    return most;
}

/* Do corrections leave rounding only, after one of `change` that followed one of `before`? */
static bool refined(double first, double before, double change)
{
    return change <= small_change*first || change*change <= left_over*before*first;
}

bool lw_space_rows_solve(lw_space_rows_set *z, const double *f, const double *rhs, bool refine, double *x, double *l)
{
    for (int i = 0; i < z->s->n_v; i++)
        x[i] = f ? f[i]*z->weight[i] : 0;
    memset(l, 0, (size_t)z->n_row*sizeof *l);
    double first = improve(z, rhs, !f, x, l), before = first, change = refine ? INFINITY : 0;
    /* the pivots do not tell how much long rows of loops magnify rounding: more corrections where one is not small */
    for (int pass = 0; pass < most_refined && !refined(first, before, change); pass++) {
        before = pass ? change : first;
        change = improve(z, rhs, false, x, l);
    }
    return refined(first, before, change);
}

/* As improve, for four systems: the right-hand side of the k-th is 1 in row first + k, else 0. */
static void improve_four(lw_space_rows_set *z, int first, bool still, double (*x)[4], double change[4])
{
    for (int i = 0; i < z->n_kept; i++) {
        int r = z->kept[i], at = r - first;
        lw_pair left = { -(at == 0), -(at == 1) }, right = { -(at == 2), -(at == 3) };
        for (int k = 0; k < lw_space_rows_sides(z, r) && !still; k++) {
            int body = lw_space_rows_bodies(z, r)[k];
            const double *jac = z->jac + z->at[r] + 6*k;
            if (body < 0)
                continue;
            const lw_pair *by = (const lw_pair *)x[6*body];
            for (int j = 0; j < 6; j++)
                left += jac[j]*by[2*j], right += jac[j]*by[2*j + 1];
        }
        lw_pair *b = (lw_pair *)z->four[i];
        b[0] = left, b[1] = right;
    }
    lw_cholesky_solve_four(&z->schur, z->four);
    memset(change, 0, 4*sizeof *change);
    for (int i = 0; i < z->n_kept; i++) {
        int r = z->kept[i];
        const lw_pair *b = (const lw_pair *)z->four[i], left = b[0], right = b[1];
        for (int k = 0; k < lw_space_rows_sides(z, r); k++) {
            int body = lw_space_rows_bodies(z, r)[k];
            const double *jac = z->jac_w + z->at[r] + 6*k;
            if (body < 0)
                continue;
            lw_pair *to = (lw_pair *)x[6*body];
            for (int j = 0; j < 6; j++)
                to[2*j] -= jac[j]*left, to[2*j + 1] -= jac[j]*right;
        }
        for (int k = 0; k < 4; k++)
            change[k] = lw_greater(change[k], fabs(z->four[i][k]));
    }
}

bool lw_space_rows_motions(lw_space_rows_set *z, int n, int first, double *x)
{
    int n_v = z->s->n_v;
    double (*at)[4] = z->four + z->n_row;
    for (int from = 0; from < n; from += 4, x += 4*n_v) {
        int many = n - from < 4 ? n - from : 4;
        double whole[4], before[4], change[4];
        bool good = false;
        memset(at, 0, (size_t)n_v*sizeof *at);
        for (int pass = 0; pass <= most_refined && !good; pass++) {
            if (pass > 0)
                memcpy(before, change, sizeof before);
            improve_four(z, first + from, pass == 0, at, change);
            if (pass == 0)
                memcpy(whole, change, sizeof whole);
            good = pass > 0;
            for (int k = 0; k < many; k++)
                good = good && refined(whole[k], before[k], change[k]);
        }
        if (!good)
            return false;
        for (int k = 0; k < many; k++)
            for (int i = 0; i < n_v; i++)
                x[k*n_v + i] = at[i][k];
    }
    return true;
}

void lw_space_rows_carry(lw_space_rows_set *z, const double *f, double *l)
{
    lw_space_rows_solve(z, f, NULL, true, z->full, l);
}

void lw_space_rows_bias(const lw_space_rows_set *z, const double *v, double *out)
{
    lw_space_bias(z->s, z->frame, v, out);
    for (int i = 0; i < z->n_extra; i++)
        out[z->s->n_row + i] = z->extra[i].spin ? 0 : -lw_space_measure_bias(z->s, z->frame, z->extra[i].measure, v);
}

lw_status lw_space_rows_close(lw_space_rows_set *z, double *q, const double *target, double longest)
{
    static const double rounding = 4e-15, near = 1e-4;
    double before = INFINITY, noise = 1e-12, far = 1;
    bool chord = false;                      /* after a step so short the factors are good for the next one, and for the tangent */
    for (int i = 0; i < z->n_extra; i++)     /* rounding of a turn after many turns */
        noise = fmax(noise, 4*DBL_EPSILON*fabs(target[i]));
    for (int b = 0; b < z->s->n_body; b++)
        for (int i = 0; i < 3; i++)
            far = fmax(far, fabs(q[7*b + i]));
    memset(z->moved, 0, (size_t)z->s->n_v*sizeof *z->moved);
    for (int round = 0; round < 30; round++) {
        double open = 0, *b = z->small;
        lw_space_rows_fill(z, q, target);
        for (int i = 0; i < z->n_kept; i++) {
            b[i] = z->phi[z->kept[i]];
            open = lw_greater(open, fabs(b[i]));
        }
        if (round > 0 && open <= fmin(2*DBL_EPSILON, rounding*sqrt(z->weak)))        /* one more step would not close them better */
            return LW_OK;
        if (!chord && !lw_space_rows_factor(z))
            return LW_OPEN;
        noise = fmax(noise, 8*DBL_EPSILON*far/sqrt(z->weak));    /* rounding of the rows, magnified near a singular posture */
        memset(z->step, 0, (size_t)z->s->n_v*sizeof *z->step);
        if (z->n_kept)
            lw_cholesky_solve_overlapped(&z->schur, b);
        for (int i = 0; i < z->n_kept; i++)
            add_row(z, z->kept[i], z->jac_w, -b[i], z->step);
        double size = lw_space_length(z->s, z->step);
        if (!isfinite(size) || (longest > 0 && size > longest) || (round > 3 && size > before && size > noise))
            return LW_OPEN;
        lw_space_move(z->s, q, z->step);
        for (int i = 0; i < z->s->n_v; i++)
            z->moved[i] += z->step[i];
        bool next_is_rounding = round > 0 && size*size < (chord ? DBL_EPSILON : rounding)*before;      /* steps shrink as the last two, or faster */
        if (size < rounding || next_is_rounding || (size < noise && size > before/4))
            return LW_OK;
        chord = size < near && (!chord || size < 1e-3*before);
        before = size;
    }
    return before < 10*noise ? LW_OK : LW_OPEN;
}

/* ---- full matrix ---- */

lw_status lw_space_dense_make(const lw_space_rows_set *z, lw_space_dense *d, lw_error *e)
{
    *d = (lw_space_dense){ .n_v = z->s->n_v, .n_row = z->n_row };
    d->doubles = malloc(lw_rank_doubles(d->n_v, d->n_row)*sizeof *d->doubles);
    d->ints = malloc(lw_rank_ints(d->n_v, d->n_row)*sizeof *d->ints + sizeof *d->ints);
    if (!d->doubles || !d->ints) {
        lw_space_dense_free(d);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    lw_rank_place(&d->rank, d->n_v, d->n_row, d->doubles, d->ints);
    return LW_OK;
}

void lw_space_dense_free(lw_space_dense *d)
{
    free(d->doubles), free(d->ints);
    *d = (lw_space_dense){ 0 };
}

void lw_space_dense_factor(const lw_space_rows_set *z, lw_space_dense *d, double least)
{
    fill_dense(z, d);
    lw_rank_factor(&d->rank, least);
}

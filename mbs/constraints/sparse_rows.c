/* mbs/constraints/sparse_rows.c - see sparse_rows_internal.h */
#include "mbs/constraints/sparse_rows_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"

static void row_bodies(const lw_sparse_rows *r, int row, int body[LW_SYSTEM_ROW_BODIES])
{
    if (row < r->s->n_row)
        lw_system_row_bodies(r->s, row, body);
    else
        lw_system_joint_bodies(r->s, r->s->input_joint[r->held[row - r->s->n_row]], body);
}

/* The entries of each row, by coordinates. */
static bool list_entries(lw_sparse_rows *r)
{
    size_t all = (size_t)(r->m + r->n);
    int body[LW_SYSTEM_ROW_BODIES];
    r->at = calloc(all + 1, sizeof *r->at);
    r->column = malloc(((size_t)r->m*LW_SYSTEM_ROW_SIZE + (size_t)r->n + 1)*sizeof *r->column);
    r->entry = calloc((size_t)r->m*LW_SYSTEM_ROW_SIZE + (size_t)r->n + 1, sizeof *r->entry);
    r->block = malloc(((size_t)r->m + 1)*LW_SYSTEM_ROW_SIZE*sizeof *r->block);
    r->body = malloc(((size_t)r->m + 1)*sizeof *r->body);
    r->x = malloc((2*(size_t)r->n + (size_t)r->m + 1)*sizeof *r->x);
    r->dependent = calloc((size_t)r->n + 1, sizeof *r->dependent);
    r->place = malloc(((size_t)r->n + 1)*sizeof *r->place);
    if (!r->at || !r->column || !r->entry || !r->block || !r->body || !r->x || !r->dependent || !r->place)
        return false;
    r->right = r->x + r->n;
    r->rest = r->right + r->n;
    for (int i = 0; i < (int)all; i++) {
        int used = r->at[i];
        if (i < r->m)
            row_bodies(r, i, body);
        for (int k = 0; i < r->m && k < LW_SYSTEM_ROW_BODIES && body[k] >= 0; k++)
            for (int c = 0; c < 3; c++)
                r->column[used++] = 3*body[k] + c;
        if (i >= r->m)
            r->column[used++] = i - r->m;
        r->at[i + 1] = used;
    }
    for (int i = 0; i < r->m; i++)
        row_bodies(r, i, r->body[i]);
    return true;
}

/* Coordinates that share a row meet. */
static bool order(lw_sparse_rows *r)
{
    int n = r->n, *first = calloc((size_t)n + 2, sizeof *first), *row = malloc(((size_t)r->at[r->m] + 1)*sizeof *row);
    int *near_at = calloc((size_t)n + 1, sizeof *near_at), *mark = malloc(((size_t)n + 1)*sizeof *mark), *near = NULL;
    bool ok = first && row && near_at && mark;
    for (int p = 0; ok && p < r->at[r->m]; p++)
        first[r->column[p] + 2]++;
    for (int c = 0; ok && c < n; c++)
        first[c + 2] += first[c + 1];
    for (int i = 0; ok && i < r->m; i++)
        for (int p = r->at[i]; p < r->at[i + 1]; p++)
            row[first[r->column[p] + 1]++] = i;
    for (int pass = 0; ok && pass < 2; pass++) {             /* count, then list */
        memset(mark, -1, (size_t)n*sizeof *mark);
        for (int c = 0, used = 0; c < n; c++) {
            mark[c] = c;
            for (int k = first[c]; k < first[c + 1]; k++)
                for (int p = r->at[row[k]]; p < r->at[row[k] + 1]; p++)
                    if (mark[r->column[p]] != c) {
                        mark[r->column[p]] = c;
                        if (pass)
                            near[used] = r->column[p];
                        used++;
                    }
            near_at[c + 1] = used;
        }
        if (pass == 0)
            ok = (near = malloc(((size_t)near_at[n] + 1)*sizeof *near)) != NULL;
    }
    ok = ok && lw_cholesky_make(&r->factor, n, near_at, near);
    for (int k = 0; ok && k < n; k++)
        r->place[r->factor.order[k]] = k;
    for (int p = 0; ok && p < r->at[r->m + n]; p++)
        r->column[p] = r->place[r->column[p]];
    ok = ok && lw_row_fronts_make(&r->fronts, &r->factor, r->m + n, r->at, r->column);
    free(first), free(row), free(near_at), free(mark), free(near);
    return ok;
}

bool lw_sparse_rows_create(const lw_system *s, const int *held, int n_held, lw_sparse_rows *r)
{
    *r = (lw_sparse_rows){ .s = s, .m = s->n_row + n_held, .n = s->n_q, .n_held = n_held, .held = held };
    if (list_entries(r) && order(r))
        return true;
    lw_sparse_rows_free(r);
    return false;
}

void lw_sparse_rows_free(lw_sparse_rows *r)
{
    void *const array[] = { r->at, r->column, r->entry, r->block, r->body, r->x, r->dependent, r->place };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
    lw_cholesky_free(&r->factor);
    lw_row_fronts_free(&r->fronts);
    memset(r, 0, sizeof *r);
}

void lw_sparse_rows_fill(lw_sparse_rows *r, const lw_body_frame *f)
{
    memset(r->block, 0, (size_t)r->m*LW_SYSTEM_ROW_SIZE*sizeof *r->block);
    lw_system_fill_blocks(r->s, f, NULL, r->block, r->body);
    for (int i = 0; i < r->n_held; i++) {
        int row = r->s->n_row + i;
        lw_system_count_block(r->s, f, r->s->input_joint[r->held[i]], r->block + (size_t)row*LW_SYSTEM_ROW_SIZE, r->body[row]);
    }
    for (int i = 0; i < r->m; i++)
        memcpy(r->entry + r->at[i], r->block + (size_t)i*LW_SYSTEM_ROW_SIZE, (size_t)(r->at[i + 1] - r->at[i])*sizeof *r->entry);
}

double lw_sparse_rows_factor(lw_sparse_rows *r, double least, int *left)
{
    double low = INFINITY, high = 0;
    double share = lw_row_fronts_factor(&r->fronts, &r->factor, r->entry, least*least, left ? r->dependent : NULL);
    if (!left)
        memset(r->dependent, 0, (size_t)r->n*sizeof *r->dependent);
    else
        *left = 0;
    if (!left && !(share > 0))
        return share;
    for (int k = 0; k < r->n; k++) {
        double pivot = fabs(r->factor.diag[k]);              /* 1/R_kk; 0: left out */
        if (r->dependent[k]) {
            ++*left;
            continue;
        }
        if (isnan(pivot))
            return NAN;
        low = fmin(low, 1/pivot);
        high = fmax(high, 1/pivot);
    }
    return high > 0 ? low/high : 0;
}

void lw_sparse_rows_times(const lw_sparse_rows *r, const double *x, double *out)
{
    for (int i = 0; i < r->m; i++) {
        double sum = 0;
        for (int p = r->at[i]; p < r->at[i + 1]; p++)
            sum += r->entry[p]*x[r->factor.order[r->column[p]]];
        out[i] = sum;
    }
}

/* out (n) = A^T y */
static void times_transposed(const lw_sparse_rows *r, const double *y, double *out)
{
    memset(out, 0, (size_t)r->n*sizeof *out);
    for (int i = 0; i < r->m; i++)
        for (int p = r->at[i]; y[i] != 0 && p < r->at[i + 1]; p++)
            out[r->factor.order[r->column[p]]] += r->entry[p]*y[i];
}

void lw_sparse_rows_solve(const lw_sparse_rows *r, const double *b, bool rough, double *x)
{
    const double *weight = r->entry + r->at[r->m];
    memset(x, 0, (size_t)r->n*sizeof *x);
    memcpy(r->rest, b, (size_t)r->m*sizeof *b);
    for (int pass = 0; pass < 2; pass++) {
        times_transposed(r, r->rest, r->x);
        for (int i = 0; i < r->n; i++)
            r->right[r->place[i]] = r->x[i] - weight[i]*weight[i]*x[i];
        lw_cholesky_solve(&r->factor, r->right);
        for (int i = 0; i < r->n; i++)
            x[i] += r->right[r->place[i]];
        if (rough || pass > 0)
            break;
        lw_sparse_rows_times(r, x, r->rest);
        for (int i = 0; i < r->m; i++)
            r->rest[i] = b[i] - r->rest[i];
    }
}

void lw_sparse_rows_null(const lw_sparse_rows *r, int k, double *x)
{
    double *column = r->block;                               /* (m) fits */
    for (int i = 0; i < r->m; i++) {
        column[i] = 0;
        for (int p = r->at[i]; p < r->at[i + 1]; p++)
            column[i] -= r->column[p] == r->place[k] ? r->entry[p] : 0;
    }
    lw_sparse_rows_solve(r, column, false, x);
    x[k] += 1;
}

/* base/sparse.c - elimination that skips zeros. */
#include "base/sparse.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"

void lw_sparse_order(int n, unsigned char *near, int *order)
{
    for (int k = 0; k < n; k++)
        order[k] = k;
    for (int k = 0; k < n; k++) {
        int best = k, least = n + 1;
        for (int i = k; i < n; i++) {
            int met = 0;
            for (int j = k; j < n; j++)
                met += order[j] != order[i] && near[order[i]*n + order[j]];
            if (met < least)
                best = i, least = met;
        }
        int next = order[best];
        memmove(order + k + 1, order + k, (size_t)(best - k)*sizeof *order);
        order[k] = next;
        for (int i = k + 1; i < n; i++)              /* those it met now meet each other */
            for (int j = k + 1; near[next*n + order[i]] && j < n; j++)
                near[order[i]*n + order[j]] |= near[next*n + order[j]];
    }
}

size_t lw_sparse_doubles(int n) { return (size_t)n*(size_t)n + (size_t)n; }
size_t lw_sparse_ints(int n)    { return (size_t)n*(size_t)n + 4*(size_t)n + 1; }

void lw_sparse_place(lw_sparse *f, int n, double *doubles, int *ints)
{
    *f = (lw_sparse){ .n = n, .a = doubles, .work = doubles + (size_t)n*(size_t)n, .order = ints, .row = ints + n,
                      .at = ints + 2*n, .list = ints + 4*n + 1 };
}

void lw_sparse_prepare(lw_sparse *f, const double *a)
{
    int n = f->n;
    unsigned char *near = (unsigned char *)f->list;
    memset(near, 0, (size_t)n*(size_t)n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; a[i + n*j] != 0 && k < n; k++)
                near[j*n + k] |= a[i + n*k] != 0;
    lw_sparse_order(n, near, f->order);
}

static void swap_rows(lw_sparse *f, int i, int j)
{
    int row = f->row[i];
    f->row[i] = f->row[j];
    f->row[j] = row;
    for (int c = 0; c < f->n; c++) {
        double x = f->a[i + f->n*c];
        f->a[i + f->n*c] = f->a[j + f->n*c];
        f->a[j + f->n*c] = x;
    }
}

/* Where the factors are not 0. */
static void list_entries(lw_sparse *f)
{
    int n = f->n, used = 0;
    for (int k = 0; k < n; k++) {
        const double *column = f->a + k*n;
        f->at[2*k] = used;
        for (int i = k + 1; i < n; i++)
            if (column[i] != 0)
                f->list[used++] = i;
        f->at[2*k + 1] = used;
        for (int i = 0; i < k; i++)
            if (column[i] != 0)
                f->list[used++] = i;
    }
    f->at[2*n] = used;
}

int lw_sparse_factor(lw_sparse *f, const double *a)
{
    int n = f->n, *below = f->list;
    for (int k = 0; k < n; k++) {
        memcpy(f->a + k*n, a + f->order[k]*n, (size_t)n*sizeof *a);
        f->row[k] = k;
    }
    for (int k = 0; k < n; k++) {
        double *pivot = f->a + k*n;
        int best = k, m = 0;
        for (int i = k + 1; i < n; i++)
            best = fabs(pivot[i]) > fabs(pivot[best]) ? i : best;
        if (!(fabs(pivot[best]) > 0))
            return 1 + f->order[k];
        if (best != k)
            swap_rows(f, k, best);
        for (int i = k + 1; i < n; i++)
            if (pivot[i] != 0) {
                pivot[i] /= pivot[k];
                below[m++] = i;
            }
        for (int j = k + 1; j < n; j++) {
            double *column = f->a + j*n, x = column[k];
            for (int i = 0; x != 0 && i < m; i++)
                column[below[i]] -= pivot[below[i]]*x;
        }
    }
    list_entries(f);
    return 0;
}

void lw_sparse_solve(const lw_sparse *f, const double *b, double *x)
{
    int n = f->n;
    double *y = f->work;
    for (int k = 0; k < n; k++)
        y[k] = b[f->row[k]];
    for (int k = 0; k < n; k++)
        for (int i = f->at[2*k]; y[k] != 0 && i < f->at[2*k + 1]; i++)
            y[f->list[i]] -= f->a[f->list[i] + n*k]*y[k];
    for (int k = n - 1; k >= 0; k--) {
        double each = y[k] /= f->a[k + n*k];
        for (int i = f->at[2*k + 1]; i < f->at[2*k + 2]; i++)
            y[f->list[i]] -= f->a[f->list[i] + n*k]*each;
    }
    for (int k = 0; k < n; k++)
        x[f->order[k]] = y[k];
}

/* ---- symmetric positive definite ----------------------------------------------------------------- */

typedef struct neighbours { int n, capacity, *of; } neighbours;

/* The unknown of least degree, the first of those, by a tournament: a degree and, in the lower half, the number of its unknown. */
typedef struct tournament { int size; uint64_t *winner; } tournament;

static const uint64_t out = UINT64_MAX;

static int winner_of(const tournament *t) { return (int)(uint32_t)t->winner[1]; }

static void replay(tournament *t, int i, uint64_t key)
{
    int at = t->size + i;
    t->winner[at] = key;
    for (at /= 2; at > 0; at /= 2) {
        uint64_t a = t->winner[2*at], b = t->winner[2*at + 1], best = a < b ? a : b;
        if (t->winner[at] == best)           /* nor does anything change above */
            return;
        t->winner[at] = best;
    }
}

static void enter(tournament *t, const neighbours *all, int i) { replay(t, i, (uint64_t)all[i].n << 32 | (uint32_t)i); }

static bool has_room(neighbours *a, int n)
{
    if (n <= a->capacity)
        return true;
    int *more = realloc(a->of, 2*(size_t)n*sizeof *more);
    if (!more)
        return false;
    a->of = more;
    a->capacity = 2*n;
    return true;
}

/* Neighbours of i after k, one of them, is eliminated: those of both.  scratch has room for all unknowns. */
static bool join(neighbours *all, int i, int k, int *scratch)
{
    const neighbours *a = &all[i], *b = &all[k];
    int n = 0, p = 0, q = 0;
    while (p < a->n && q < b->n) {           /* without branches that depend on the numbers */
        int x = a->of[p], y = b->of[q], next = x < y ? x : y;
        p += x == next;
        q += y == next;
        scratch[n] = next;
        n += next != i && next != k;
    }
    for (; p < a->n; p++)
        scratch[n] = a->of[p], n += a->of[p] != k;
    for (; q < b->n; q++)
        scratch[n] = b->of[q], n += b->of[q] != i;
    if (!has_room(&all[i], n))
        return false;
    memcpy(all[i].of, scratch, (size_t)n*sizeof *scratch);
    all[i].n = n;
    return true;
}

static int compare(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

/* In ascending order; most lists are short, or nearly in order. */
static void sort(int n, int *x)
{
    enum { FEW = 64 };
    if (n > FEW) {
        qsort(x, (size_t)n, sizeof *x, compare);
        return;
    }
    for (int i = 1; i < n; i++) {
        int next = x[i], k = i;
        for (; k > 0 && x[k - 1] > next; k--)
            x[k] = x[k - 1];
        x[k] = next;
    }
}

static void drop(neighbours *a, int k)
{
    int at = lw_place_in(a->n, a->of, k);
    memmove(a->of + at, a->of + at + 1, (size_t)(--a->n - at)*sizeof *a->of);
}

/* Do the neighbours of k meet each other already?  They do if k and these were the neighbours of the unknown eliminated before. */
static bool is_clique(const neighbours *all, int before, int k)
{
    const neighbours *a = before < 0 ? NULL : &all[before];
    int at = a && a->n == all[k].n + 1 ? lw_place_in(a->n, a->of, k) : 0;
    return a && a->n == all[k].n + 1 && at < a->n && a->of[at] == k;
}

/* Eliminate all unknowns: the order, and in all[k].of the neighbours that k has then. */
static bool eliminate(lw_cholesky *c, neighbours *all, tournament *t, int *scratch)
{
    bool ok = true;
    for (int i = 0; i < c->n; i++)
        enter(t, all, i);
    for (int step = 0, before = -1; ok && step < c->n; step++) {
        int k = c->order[step] = winner_of(t);
        bool clique = is_clique(all, before, k);
        replay(t, k, out);
        for (int j = 0; ok && j < all[k].n; j++) {
            if (clique)
                drop(&all[all[k].of[j]], k);
            else
                ok = join(all, all[k].of[j], k, scratch);
            enter(t, all, all[k].of[j]);
        }
        before = k;
    }
    return ok;
}

/* Columns of every row, then the destinations of the products. */
static bool list_products(lw_cholesky *c, const neighbours *all, int *place)
{
    size_t n_product = 0, used = 0;
    c->n_entry = 0;
    for (int i = 0; i < c->n; i++) {
        size_t m = (size_t)all[i].n;
        place[c->order[i]] = i;
        c->n_entry += all[i].n;
        n_product += m*(m > 0 ? m - 1 : 0)/2;
    }
    c->list = malloc(((size_t)c->n_entry + 1)*sizeof *c->list);
    c->run = malloc((n_product + 1)*sizeof *c->run);
    c->value = calloc((size_t)c->n_entry + (size_t)c->n + 1, sizeof *c->value);
    if (!c->list || !c->run || !c->value)
        return false;
    for (int i = 0, at = 0; i < c->n; i++) {
        const neighbours *a = &all[c->order[i]];
        c->at[i] = at;
        for (int k = 0; k < a->n; k++)
            c->list[at++] = place[a->of[k]];
        sort(a->n, c->list + c->at[i]);
        c->at[i + 1] = at;
    }
    for (int i = 0; i < c->n; i++)
        for (int k = c->at[i]; k < c->at[i + 1]; k++)
            for (int j = k + 1, at = c->at[c->list[k]]; j < c->at[i + 1]; j++) {
                while (c->list[at] != c->list[j])
                    at++;
                if (j == k + 1 || at != c->run[used - 1].to + c->run[used - 1].n)
                    c->run[used++] = (lw_cholesky_run){ at, 0 };
                c->run[used - 1].n++;
            }
    lw_cholesky_run *less = realloc(c->run, (used + 1)*sizeof *less);
    c->run = less ? less : c->run;
    return true;
}

bool lw_cholesky_make(lw_cholesky *c, int n, const int *near_at, const int *near)
{
    size_t count = (size_t)n;
    tournament t = { .size = 1 };
    *c = (lw_cholesky){ .n = n };
    while (t.size < n)
        t.size *= 2;
    neighbours *all = calloc(count + 1, sizeof *all);
    int *scratch = malloc((2*count + 1)*sizeof *scratch);
    t.winner = malloc(2*(size_t)t.size*sizeof *t.winner);
    c->order = malloc((count + 1)*sizeof *c->order);
    c->at = calloc(count + 1, sizeof *c->at);
    c->diag = calloc(count + 1, sizeof *c->diag);
    bool ok = all && scratch && t.winner && c->order && c->at && c->diag;
    for (int i = 0; ok && i < 2*t.size; i++)
        t.winner[i] = out;
    for (int i = 0; ok && i < n; i++) {
        int m = near_at[i + 1] - near_at[i];
        ok = has_room(&all[i], m + 1);
        if (ok && m > 0)
            memcpy(all[i].of, near + near_at[i], (size_t)m*sizeof *near);
        if (ok) {
            all[i].n = m;
            sort(m, all[i].of);
        }
    }
    ok = ok && eliminate(c, all, &t, scratch) && list_products(c, all, scratch + count);
    for (int i = 0; all && i < n; i++)
        free(all[i].of);
    free(all);
    free(scratch);
    free(t.winner);
    if (!ok)
        lw_cholesky_free(c);
    return ok;
}

void lw_cholesky_free(lw_cholesky *c)
{
    free(c->order);
    free(c->at);
    free(c->list);
    free(c->run);
    free(c->value);
    free(c->diag);
    memset(c, 0, sizeof *c);
}

int lw_cholesky_entry(const lw_cholesky *c, int i, int j)
{
    return i == j ? c->n_entry + i : c->at[i] + lw_place_in(c->at[i + 1] - c->at[i], c->list + c->at[i], j);
}

/* y -= f x. */
static inline void subtract(int n, double f, const double *x, double *y)
{
    for (; n > 1; n -= 2, x += 2, y += 2)
        *(lw_pair *)y -= f**(const lw_pair *)x;
    if (n)
        *y -= f**x;
}

double lw_cholesky_factor(lw_cholesky *c, double tolerance, bool *dependent)
{
    double *value = c->value, *pivots = value + c->n_entry, *diag = c->diag, least = 1;
    const lw_cholesky_run *run = c->run;
    memcpy(diag, pivots, (size_t)c->n*sizeof *diag);
    for (int i = 0; i < c->n; i++) {
        double *row = value + c->at[i], pivot = pivots[i], share = pivot/diag[i];
        const int *list = c->list + c->at[i], m = c->at[i + 1] - c->at[i];
        if (dependent)
            dependent[i] = !(share > tolerance);
        if (dependent && dependent[i]) {
            diag[i] = 0;
            memset(row, 0, (size_t)m*sizeof *row);
            for (int left = m*(m - 1)/2; left > 0; run++)
                left -= run->n;
            continue;
        }
        least = share < least ? share : least;
        if (!(pivot > 0))
            return 0;
        double factor = diag[i] = 1/sqrt(pivot);
        for (int k = 0; k < m; k++)
            row[k] *= factor;
        for (int k = 0; k < m; k++) {
            double x = row[k];
            pivots[list[k]] -= x*x;
            for (int j = k + 1; j < m; j += run->n, run++)
                subtract(run->n, x, row + j, value + run->to);
        }
    }
    return least;
}

static void solve_forwards(const lw_cholesky *c, double *b)
{
    for (int i = 0; i < c->n; i++) {
        double x = b[i] *= c->diag[i];
        for (int k = c->at[i]; x != 0 && k < c->at[i + 1]; k++)       /* right-hand sides are often 0 up to some row */
            b[c->list[k]] -= c->value[k]*x;
    }
}

void lw_cholesky_solve(const lw_cholesky *c, double *b)
{
    solve_forwards(c, b);
    for (int i = c->n - 1; i >= 0; i--) {
        double sum = b[i];
        for (int k = c->at[i]; k < c->at[i + 1]; k++)
            sum -= c->value[k]*b[c->list[k]];
        b[i] = sum*c->diag[i];
    }
}

void lw_cholesky_solve_overlapped(const lw_cholesky *c, double *b)
{
    solve_forwards(c, b);
    for (int i = c->n - 1; i >= 0; i--) {
        double sum = b[i];
        for (int k = c->at[i + 1] - 1; k >= c->at[i]; k--)
            sum -= c->value[k]*b[c->list[k]];
        b[i] = sum*c->diag[i];
    }
}

/* Two registers, each named: compilers keep vectors of four in memory where registers hold two. */
void lw_cholesky_solve_four(const lw_cholesky *c, double (*b)[4])
{
    const int *at = c->at, *list = c->list;
    const double *value = c->value;
    for (int i = 0; i < c->n; i++) {
        lw_pair *own = (lw_pair *)b[i], x = own[0] *= c->diag[i], y = own[1] *= c->diag[i];
        for (int k = at[i]; k < at[i + 1]; k++) {
            lw_pair *to = (lw_pair *)b[list[k]];
            to[0] -= value[k]*x, to[1] -= value[k]*y;
        }
    }
    for (int i = c->n - 1; i >= 0; i--) {
        lw_pair *own = (lw_pair *)b[i], x = own[0], y = own[1];
        for (int k = at[i + 1] - 1; k >= at[i]; k--) {
            const lw_pair *by = (const lw_pair *)b[list[k]];
            x -= value[k]*by[0], y -= value[k]*by[1];
        }
        own[0] = x*c->diag[i], own[1] = y*c->diag[i];
    }
}

/* ---- the same factor from rows ---------------------------------------------------------------------- */

bool lw_row_fronts_make(lw_row_fronts *f, const lw_cholesky *c, int n_row, const int *at, const int *column)
{
    size_t n = (size_t)c->n, rows = (size_t)n_row, entries = (size_t)at[n_row], passed = 0, most = 0;
    int *ints = malloc(((rows + 1) + entries + (n + 1) + rows + 4*n + 1)*sizeof *ints);
    *f = (lw_row_fronts){ .n_row = n_row, .at = ints, .to = malloc((n + 1)*sizeof *f->to), .size = malloc((n + 1)*sizeof *f->size) };
    if (!ints || !f->to || !f->size) {
        lw_row_fronts_free(f);
        return false;
    }
    f->column = f->at + rows + 1;
    f->first = f->column + entries;
    f->row = f->first + n + 1;
    f->child = f->row + rows;
    f->sibling = f->child + n;
    f->height = f->sibling + n;
    f->place = f->height + n;
    memcpy(f->at, at, (rows + 1)*sizeof *at);
    memcpy(f->column, column, entries*sizeof *column);
    memset(f->first, 0, (n + 1)*sizeof *f->first);
    for (int pass = 0; pass < 2; pass++) {                   /* count, then list */
        for (int i = 0; i < n_row; i++) {
            int low = c->n;
            for (int k = at[i]; k < at[i + 1]; k++)
                low = column[k] < low ? column[k] : low;
            if (low < c->n && pass)
                f->row[f->place[low]++] = i;
            else if (low < c->n)
                f->first[low + 1]++;
        }
        for (int k = 0; k < c->n && !pass; k++) {
            f->place[k] = f->first[k];
            f->first[k + 1] += f->first[k];
        }
    }
    for (int k = 0; k < c->n; k++)
        f->child[k] = f->sibling[k] = -1;
    for (int k = 0; k < c->n; k++) {
        size_t others = (size_t)(c->at[k + 1] - c->at[k]), m = (size_t)(f->first[k + 1] - f->first[k]);
        for (int j = f->child[k]; j >= 0; j = f->sibling[j])
            m += (size_t)f->height[j];
        f->height[k] = (int)(m < others ? m : others);
        f->to[k] = passed;
        passed += (size_t)f->height[k]*others;
        most = m*(others + 1) > most ? m*(others + 1) : most;
        if (others > 0) {
            int parent = c->list[c->at[k]];
            f->sibling[k] = f->child[parent];
            f->child[parent] = k;
        }
    }
    f->pass = malloc((passed + 1)*sizeof *f->pass);
    f->front = malloc((most + 1)*sizeof *f->front);
    if (f->pass && f->front)
        return true;
    lw_row_fronts_free(f);
    return false;
}

void lw_row_fronts_free(lw_row_fronts *f)
{
    free(f->at);
    free(f->to);
    free(f->pass);
    free(f->front);
    free(f->size);
    memset(f, 0, sizeof *f);
}

/* Gather the rows of front k, of w columns, into f->front.  Returns how many there are. */
static int gather(lw_row_fronts *f, const lw_cholesky *c, const double *entry, int k, int w)
{
    int m = 0;
    f->place[k] = 0;
    for (int j = 1; j < w; j++)
        f->place[c->list[c->at[k] + j - 1]] = j;
    for (int i = f->first[k]; i < f->first[k + 1]; i++) {
        double *to = f->front + (size_t)m*(size_t)w;
        bool any = false;
        memset(to, 0, (size_t)w*sizeof *to);
        for (int p = f->at[f->row[i]]; p < f->at[f->row[i] + 1]; p++) {
            to[f->place[f->column[p]]] += entry[p];
            any = any || entry[p] != 0;
        }
        m += any;                                            /* rows of zeros are left out */
    }
    for (int j = f->child[k]; j >= 0; j = f->sibling[j]) {
        int others = c->at[j + 1] - c->at[j];
        for (int i = 0; i < f->height[j]; i++, m++) {
            double *to = f->front + (size_t)m*(size_t)w;
            memset(to, 0, (size_t)w*sizeof *to);
            for (int p = 0; p < others; p++)
                to[f->place[c->list[c->at[j] + p]]] = f->pass[f->to[j] + (size_t)i*(size_t)others + (size_t)p];
        }
    }
    return m;
}

/* Norm of column j of m rows of w numbers, from row i on. */
static double column_norm(const double *a, int i, int m, int w, int j)
{
    double sum = 0;
    for (; i < m; i++)
        sum += a[i*w + j]*a[i*w + j];
    return sqrt(sum);
}

/* Reflect m rows of w numbers so that column first + i ends at row i. */
static void reflect(double *a, int m, int w, int first)
{
    for (int i = 0; i < m - 1 && first + i < w; i++) {
        int j = first + i;
        double norm = column_norm(a, i, m, w, j);
        if (!(norm > 0))
            continue;
        double lead = a[i*w + j] + (a[i*w + j] >= 0 ? norm : -norm), by = lead*(lead > 0 ? norm : -norm);
        a[i*w + j] = lead;                                   /* the vector; its square over 2 is |lead| norm */
        for (int k = j + 1; k < w; k++) {
            double sum = 0;
            for (int r = i; r < m; r++)
                sum += a[r*w + j]*a[r*w + k];
            sum /= by;
            for (int r = i; r < m; r++)
                a[r*w + k] -= sum*a[r*w + j];
        }
        a[i*w + j] = lead > 0 ? -norm : norm;
        for (int r = i + 1; r < m; r++)
            a[r*w + j] = 0;
    }
}

double lw_row_fronts_factor(lw_row_fronts *f, lw_cholesky *c, const double *entry, double tolerance, bool *dependent)
{
    double least = 1;
    memset(f->size, 0, (size_t)c->n*sizeof *f->size);
    for (int p = 0; p < f->at[f->n_row]; p++)
        f->size[f->column[p]] += entry[p]*entry[p];
    for (int k = 0; k < c->n; k++) {
        int w = 1 + c->at[k + 1] - c->at[k], m = gather(f, c, entry, k, w);
        double *row = c->value + c->at[k], pivot = column_norm(f->front, 0, m, w, 0), share = f->size[k] > 0 ? pivot*pivot/f->size[k] : 0;
        bool left_out = dependent && !(share > tolerance);
        if (dependent)
            dependent[k] = left_out;
        reflect(f->front, m, w, left_out);
        if (!left_out) {
            least = fmin(least, share);
            if (!(pivot > 0))
                return 0;
            memcpy(row, f->front + 1, (size_t)(w - 1)*sizeof *row);
        } else
            memset(row, 0, (size_t)(w - 1)*sizeof *row);
        c->diag[k] = left_out ? 0 : 1/f->front[0];
        int from = !left_out, rows = m < w - left_out ? m : w - left_out;
        f->height[k] = rows > from ? rows - from : 0;
        for (int i = 0; i < f->height[k]; i++)
            memcpy(f->pass + f->to[k] + (size_t)i*(size_t)(w - 1), f->front + (size_t)(from + i)*(size_t)w + 1, (size_t)(w - 1)*sizeof *f->pass);
    }
    return least;
}

/* mbs/dynamics/dynamics_arrange.c - which of the rows in force are independent, and the pattern and order in which J M^-1 J^T is factored. */
#include "base/real.h"
#include "mbs/dynamics/dynamics_equations_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/dynamics/touch_internal.h"

static const double least_share = 1e-10;    /* relative pivot below which a row of a large model depends on others */
static const double few_digits = 1e-8;      /* relative error of a solution from which on solving loses digits */

/* ---- rows and who shares blocks ------------------------------------------------------------------ */

static void find_row_blocks(lw_dynamics *d)
{
    int row = d->n_row;
    for (int i = 0; i < d->n_c*d->eq.n_slot; i++)
        d->row_block[i] = -1;
    for (int r = 0; r < d->n_row; r++)
        d->eq.row_blocks(d->eq.context, r, lw_mbs_blocks(d, r));
    for (int i = 0; i < d->n_driven; i++)
        d->eq.measure_blocks(d->eq.context, d->driven_measure[i], lw_mbs_blocks(d, row++));
    for (int i = 0; i < d->n_resting; i++)
        d->eq.measure_blocks(d->eq.context, d->stop[d->resting[i]].measure, lw_mbs_blocks(d, row++));
    if (d->touch)
        lw_mbs_touch_bodies(d, row);
}

/* A block with many rows makes J M^-1 J^T full over these.  It counts as parts of equal mass instead, each with a few of the rows
 * and welded to another by LW_BLOCK rows more.  The solution is the same: no force acts between parts that move alike, so the
 * right-hand sides of welds are 0. */
enum { MANY_ROWS = 48, PART_ROWS = 8 };

/* Which unknowns (kept rows, then welds) meet which part: part p meets list[at[p]] .. list[at[p + 1] - 1], unknown i part
 * part[i*n_slot + k] in slot k: of a row as in row_block, of a weld its two sides. */
typedef struct part_rows { int n, n_unknown, *part, *at; struct part_row { int unknown, slot; } *list; } part_rows;

static void free_part_rows(part_rows *r)
{
    free(r->part);
    free(r->at);
    free(r->list);
}

/* Divide the blocks; d->parts: into how many. */
static bool count_parts(lw_dynamics *d, part_rows *r, bool divide)
{
    int n = d->eq.n_block;
    free(d->parts);
    d->parts = calloc((size_t)n + 1, sizeof *d->parts);
    if (!d->parts)
        return false;
    for (int i = 0; divide && i < d->n_kept; i++)
        for (int k = 0; k < d->eq.n_slot && lw_mbs_blocks(d, d->kept[i])[k] >= 0; k++)
            d->parts[lw_mbs_blocks(d, d->kept[i])[k]]++;
    r->n = 0;
    for (int b = 0; b < n; b++) {
        d->parts[b] = d->parts[b] > MANY_ROWS ? (d->parts[b] + PART_ROWS - 1)/PART_ROWS : 1;
        r->n += d->parts[b];
    }
    r->n_unknown = d->n_kept + LW_BLOCK*(r->n - n);
    return true;
}

/* The part, 1 .. n, to which part p is welded; 0: to none.  Welds make a tree of few levels that keeps to the order of the rows, and
 * so of neighbouring links: a chain would be as sparse, but magnify rounding. */
static int welded_to(int p, int n)
{
    int root = 1;
    while (2*root <= n)
        root *= 2;
    if (p == root)
        return 0;
    do {
        int low = p & -p;
        p += p & 2*low ? -low : low;
    } while (p > n);
    return p;
}

static bool list_part_rows(const lw_dynamics *d, part_rows *r)
{
    int n = d->eq.n_block, weld = d->n_kept, *next = calloc(2*((size_t)n + 1), sizeof *next), *first = next ? next + n + 1 : NULL;
    size_t size = (size_t)r->n_unknown*(size_t)d->eq.n_slot + 1;
    r->part = malloc(size*sizeof *r->part);
    r->at = calloc((size_t)r->n + 2, sizeof *r->at);
    r->list = malloc(size*sizeof *r->list);
    bool ok = next && r->part && r->at && r->list;
    for (size_t i = 0; ok && i < size; i++)
        r->part[i] = -1;
    for (int b = 0, p = 0; ok && b < n; b++) {
        first[b] = p;
        for (int i = 1, to; i <= d->parts[b]; i++, p++)
            for (int k = 0; k < LW_BLOCK && (to = welded_to(i, d->parts[b])) > 0; k++, weld++)
                r->part[weld*d->eq.n_slot] = p, r->part[weld*d->eq.n_slot + 1] = first[b] + to - 1;
    }
    for (int i = 0; ok && i < d->n_kept; i++)
        for (int k = 0; k < d->eq.n_slot && lw_mbs_blocks(d, d->kept[i])[k] >= 0; k++) {
            int b = lw_mbs_blocks(d, d->kept[i])[k];
            r->part[i*d->eq.n_slot + k] = first[b] + (d->parts[b] > 1 ? next[b]++/PART_ROWS : 0);
        }
    free(next);
    for (int i = 0; ok && i < (int)size; i++)
        if (r->part[i] >= 0)
            r->at[r->part[i] + 2]++;
    for (int p = 0; ok && p < r->n; p++)
        r->at[p + 2] += r->at[p + 1];
    for (int i = 0; ok && i < (int)size; i++)
        if (r->part[i] >= 0)
            r->list[r->at[r->part[i] + 1]++] = (struct part_row){ i/d->eq.n_slot, i%d->eq.n_slot };
    return ok;
}

/* Analyse the pattern of J M^-1 J^T, which has an entry where two unknowns share a part. */
static bool analyse(lw_dynamics *d, const part_rows *r)
{
    int n = r->n_unknown;
    int *at = calloc((size_t)n + 2, sizeof *at), *mark = malloc(((size_t)n + 1)*sizeof *mark), *near = NULL;
    bool ok = at && mark;
    for (int pass = 0; ok && pass < 2; pass++) {             /* count, then list */
        for (int i = 0; i < n; i++)
            mark[i] = -1;
        for (int i = 0, used = 0; i < n; i++) {
            mark[i] = i;
            for (int k = 0; k < d->eq.n_slot && r->part[i*d->eq.n_slot + k] >= 0; k++)
                for (int b = r->part[i*d->eq.n_slot + k], p = r->at[b]; p < r->at[b + 1]; p++) {
                    int j = r->list[p].unknown;
                    if (mark[j] == i)
                        continue;
                    mark[j] = i;
                    if (pass)
                        near[used] = j;
                    used++;
                }
            at[i + 1] = used;
        }
        if (pass == 0)
            ok = (near = malloc(((size_t)at[n] + 1)*sizeof *near)) != NULL;
    }
    lw_cholesky_free(&d->schur);
    ok = ok && lw_cholesky_make(&d->schur, n, at, near);
    free(at);
    free(mark);
    free(near);
    return ok;
}

/* List the products that unknowns x and y, which share a part of `block`, add to entry `to` of schur. */
static void add_pair(lw_dynamics *d, const int *row, const struct part_row *x, const struct part_row *y, int block, int to)
{
    bool welds[2] = { x->unknown >= d->n_kept, y->unknown >= d->n_kept };
    if (!welds[0] && !welds[1]) {
        d->pair[d->n_pair++] = (lw_row_pair){ row[x->unknown]*d->row_size + LW_BLOCK*x->slot,
                                              row[y->unknown]*d->row_size + LW_BLOCK*y->slot, to };
        return;
    }
    const struct part_row *w = welds[0] ? x : y, *other = welds[0] ? y : x;
    int i = (w->unknown - d->n_kept)%LW_BLOCK;
    if (!welds[0] || !welds[1])
        d->weld[d->n_weld++] = (lw_weld){ true, row[other->unknown]*d->row_size + LW_BLOCK*other->slot + i, to, w->slot ? -1 : 1 };
    else if (i == (other->unknown - d->n_kept)%LW_BLOCK)
        d->weld[d->n_weld++] = (lw_weld){ false, LW_BLOCK*block + i, to, (w->slot == other->slot ? 1 : -1)*d->parts[block] };
}

/* Put the kept rows in the order of elimination, and list the pairs of unknowns that share a part. */
static bool order_rows(lw_dynamics *d, const part_rows *r)
{
    int n = d->n_kept, all = r->n_unknown, m = 0, *old = malloc((size_t)(n + all + 1)*sizeof *old), *place = old ? old + n : NULL;
    size_t count = 0;
    if (!old)
        return false;
    memcpy(old, d->kept, (size_t)n*sizeof *old);
    for (int i = 0; i < all; i++) {
        int unknown = d->schur.order[i];
        place[unknown] = i;
        if (unknown < n) {
            d->kept[m] = old[unknown];
            d->unknown[m] = i;
            d->place[old[unknown]] = m++;
        }
    }
    for (int b = 0; b < r->n; b++) {
        size_t met = (size_t)(r->at[b + 1] - r->at[b]);
        count += met*(met + 1)/2;
    }
    free(d->pair);
    free(d->weld);
    d->pair = malloc((count + 1)*sizeof *d->pair);
    d->weld = malloc((all > n ? count + 1 : 1)*sizeof *d->weld);
    d->n_pair = d->n_weld = 0;
    for (int block = 0, b = 0, in = 0; d->pair && d->weld && b < r->n; b++, in++) {
        if (in == d->parts[block])
            block++, in = 0;
        for (int p = r->at[b]; p < r->at[b + 1]; p++)
            for (int q = r->at[b]; q <= p; q++) {
                int i = place[r->list[p].unknown], j = place[r->list[q].unknown];
                add_pair(d, old, &r->list[p], &r->list[q], block, lw_cholesky_entry(&d->schur, i < j ? i : j, i < j ? j : i));
            }
    }
    free(old);
    return d->pair && d->weld;
}

void lw_mbs_free_fronts(lw_dynamics *d)
{
    lw_row_fronts_free(&d->fronts);
    free(d->front_entry);
    free(d->front_value);
    d->front_entry = NULL;
    d->front_value = NULL;
    d->by_fronts = false;
}

/* Prepare the fast way for the rows in kept; divide: blocks with many rows into parts. */
static lw_status prepare_kept(lw_dynamics *d, bool divide)
{
    part_rows r = { 0 };
    lw_mbs_free_fronts(d);
    for (int i = 0; i < d->n_c; i++)
        d->place[i] = -1;
    bool ok = count_parts(d, &r, divide) && list_part_rows(d, &r) && analyse(d, &r) && order_rows(d, &r);
    free_part_rows(&r);
    return ok ? LW_OK : lw_error_set(d->e, LW_E_MEMORY, "out of memory");
}

static const int many_rows = 30;             /* from here on sparse rows cost less than dense ones, set-up included */

static int compare(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

/* Prepare factors from the kept rows themselves: list the entries of each column (velocity). */
static lw_status take_fronts(lw_dynamics *d)
{
    size_t most = (size_t)d->n_kept*(size_t)d->row_size;
    int *at = calloc((size_t)d->n_v + 2, sizeof *at), *column = malloc((most + 1)*sizeof *column);
    lw_mbs_free_fronts(d);
    d->front_entry = malloc(2*(most + 1)*sizeof *d->front_entry);
    d->front_value = malloc((most + 1)*sizeof *d->front_value);
    d->by_fronts = at && column && d->front_entry && d->front_value;
    for (int pass = 0; d->by_fronts && pass < 2; pass++) {   /* count, then list */
        for (int i = 0; i < d->n_kept; i++) {
            int row = d->kept[i];
            for (int k = 0; k < d->eq.n_slot && lw_mbs_blocks(d, row)[k] >= 0; k++)
                for (int c = 0; c < LW_BLOCK; c++) {
                    int v = LW_BLOCK*lw_mbs_blocks(d, row)[k] + c, to = pass ? at[v + 1]++ : at[v + 2]++;
                    if (pass) {
                        column[to] = i;
                        d->front_entry[2*to] = row*d->row_size + LW_BLOCK*k + c;
                        d->front_entry[2*to + 1] = v;
                    }
                }
        }
        for (int v = 0; v < d->n_v && !pass; v++)
            at[v + 2] += at[v + 1];
    }
    d->by_fronts = d->by_fronts && lw_row_fronts_make(&d->fronts, &d->schur, d->n_v, at, column);
    free(at);
    free(column);
    return d->by_fronts ? LW_OK : lw_error_set(d->e, LW_E_MEMORY, "out of memory");
}

/* Keep a basis of the rows, as the factorisation found it.  Where no row of many depends on others, the rows themselves can be
 * factored beside a singular posture, for less than by rank. */
static lw_status keep_basis(lw_dynamics *d)
{
    d->n_kept = d->rank_of.rank;
    assert(d->n_kept <= d->n_c);
    memcpy(d->kept, d->rank_of.column, (size_t)d->n_kept*sizeof *d->kept);
    qsort(d->kept, (size_t)d->n_kept, sizeof *d->kept, compare);
    lw_status s = prepare_kept(d, false);
    if (s == LW_OK && d->n_kept == d->n_c && d->n_c >= many_rows) {
        s = take_fronts(d);
        d->by_fronts = false;                /* until a posture is nearly singular */
    }
    return s;
}

/* Does solving with the rows, which leave no freedom, lose digits?  Solve J x = J (1, 1, ...), whose solution is known. */
static bool loses_digits(lw_dynamics *d)
{
    double off = 0;
    for (int i = 0; i < d->n_v; i++)
        d->hold[i] = 1;
    lw_mbs_times(d, d->hold, d->rhs);
    lw_mbs_linear(d, NULL, d->rhs, d->hold, d->l_each);
    for (int i = 0; i < d->n_v; i++)
        off = fmax(off, fabs(d->hold[i] - 1));
    return !(off < few_digits);
}

/* The same without a rank-revealing factorisation: leave out rows whose pivots vanish.  A pivot is the square of the
 * distance of a row from those eliminated before it.  dependent (n_c): of each row, whether it is left out.  Returns how many
 * are kept; -1: the pivot of a weld vanishes, which says nothing about rows. */
static int find_dependent(lw_dynamics *d, double tolerance, bool *pivot_vanishes, bool *dependent)
{
    int n = 0, vanished = 0;
    lw_mbs_factor_kept(d, tolerance, pivot_vanishes);
    for (int i = 0; i < d->schur.n; i++)
        vanished += pivot_vanishes[i];
    for (int i = 0; i < d->n_kept; i++) {
        dependent[d->kept[i]] = pivot_vanishes[d->unknown[i]];
        n += !dependent[d->kept[i]];
    }
    return vanished > d->n_kept - n ? -1 : n;
}

/* Prepare the fast way for all rows but those left out; NULL: for all. */
static lw_status prepare_rows(lw_dynamics *d, const bool *left_out, bool divide)
{
    d->n_kept = 0;
    for (int r = 0; r < d->n_c; r++)
        if (!left_out || !left_out[r])
            d->kept[d->n_kept++] = r;
    return prepare_kept(d, divide);
}

/* Leave out dependent rows.  In a long linkage whose inputs drive every freedom, J M^-1 J^T can lose all digits though no row depends
 * on others.  Then factor the rows themselves, if that keeps as many rows as the rank of the system without inputs and the
 * number of inputs require.  LW_NOTHING: blocks cannot be divided. */
static lw_status keep_independent(lw_dynamics *d, bool divide)
{
    lw_status s = prepare_rows(d, NULL, divide);
    size_t size = s == LW_OK ? (size_t)d->schur.n + (size_t)d->n_c + 1 : 1;
    bool *vanishes = s == LW_OK ? malloc(3*size) : NULL;
    if (!vanishes)
        return s != LW_OK ? s : lw_error_set(d->e, LW_E_MEMORY, "out of memory");
    bool *dependent = vanishes + size, *by_rows = dependent + size;
    int n = find_dependent(d, least_share, vanishes, dependent), wanted = d->rank_alone + d->n_driven;
    d->by_rank = false;
    if (!d->space && d->n_driven && d->rank_alone >= 0 && wanted == d->n_v && (n < wanted || loses_digits(d))) {
        s = prepare_rows(d, NULL, false);
        s = s == LW_OK ? take_fronts(d) : s;
        if (s == LW_OK && find_dependent(d, LW_MBS_LEAST_SHARE_ROWS, vanishes, by_rows) == wanted) {
            if (wanted < d->n_c)
                s = prepare_rows(d, by_rows, false);
            s = s == LW_OK && !d->by_fronts ? take_fronts(d) : s;
        } else if (s == LW_OK)
            s = n < 0 ? LW_NOTHING : prepare_rows(d, dependent, true);
    } else if (n < d->n_c)
        s = n < 0 ? LW_NOTHING : prepare_rows(d, dependent, true);
    free(vanishes);
    return s;
}

lw_status lw_mbs_arrange_touch(lw_dynamics *d, const int *kept, int n)
{
    int first = d->n_row + d->n_driven + d->n_resting;
    d->n_c = first + d->touch->n_row;
    find_row_blocks(d);
    memcpy(d->kept, kept, (size_t)n*sizeof *kept);
    for (int r = first; r < d->n_c; r++)
        d->kept[n++] = r;
    d->n_kept = n;
    return prepare_kept(d, false);
}

/* Rows of contacts give way by this share, so that those which depend on others share the load. */
static const double give = 1e-9;

lw_status lw_mbs_factor_touch(lw_dynamics *d)
{
    int first = d->n_row + d->n_driven + d->n_resting;
    double *diagonal = d->schur.value + d->schur.n_entry;
    d->by_rank = false;
    lw_mbs_form_schur(d);
    for (int i = 0; i < d->n_kept; i++)
        diagonal[i] = !(diagonal[i] > 0) ? 1 : d->kept[i] >= first ? diagonal[i]*(1 + give) : diagonal[i];
    d->weak = lw_cholesky_factor(&d->schur, 0, NULL);
    return d->weak > 0 ? LW_OK : LW_OPEN;
}

static void set_rank(lw_dynamics *d, int rank)
{
    d->rank = rank;
    d->freedom = d->n_v - rank;
}

static double least_pivot(lw_dynamics *d)
{
    lw_mbs_form_schur(d);
    return lw_cholesky_factor(&d->schur, 0, NULL);
}

/* The same if all bodies had a mass of 1, with the radii of gyration that they have. */
static double pivot_of_equal_masses(lw_dynamics *d)
{
    double *own = d->by_mass, *equal = d->small_v;
    for (int i = 0; i < d->n_v; i++)
        equal[i] = own[i]/own[i - i%LW_BLOCK];
    d->by_mass = equal;
    double pivot = least_pivot(d);
    d->by_mass = own;
    return pivot;
}

lw_status lw_mbs_arrange(lw_dynamics *d, double t, const double *q)
{
    d->n_c = d->n_row + d->n_driven + d->n_resting + (d->touch ? d->touch->n_row : 0);
    find_row_blocks(d);
    if (!d->large)
        lw_rank_place(&d->rank_of, d->n_v, d->n_c, d->rank_work, d->rank_ints);
    lw_status s = lw_mbs_rows(d, t, q);
    if (s != LW_OK)
        return s;
    if (d->large) {
        s = keep_independent(d, true);
        s = s == LW_NOTHING ? keep_independent(d, false) : s;
        set_rank(d, d->n_kept);
        return s;
    }
    set_rank(d, 0);
    lw_mbs_factor(d, true);
    set_rank(d, d->rank_of.rank);
    d->weak_scale = 0;
    s = keep_basis(d);
    if (s == LW_OK && !d->has_zero_mass) {
        double pivot = least_pivot(d);       /* spatial rows have small ones in any posture, planar ones where masses differ much */
        d->weak_scale = fmin(1, d->space ? pivot : pivot/pivot_of_equal_masses(d));
    }
    return s;
}

/* Contacts of rigid bodies are often redundant: M has dependent rows up to rounding, and many bases are all but
 * singular.  Where rounding leads astray, the basis is found with a slightly greater diagonal, and its values are those for
 * M itself.  Places that differ by 1e-8 still tie then; a diagonal that grows by unequal amounts tells them apart.  The last attempts keep the
 * values for the greater diagonal. */
#include "base/lcp.h"

#include <stdbool.h>
#include <string.h>
#include "base/real.h"

/* Walls of 10 to 60 boxes are solved at 1e-6 or 1e-5; below 1e-8 rounding leads astray there.  Places that are all but the same (corners that meet)
 * need 1e-11 to 1e-9. */
static const double shifts[] = { 0, 1e-6, 1e-5, 1e-7, 1e-8, 1e-4, 1e-10, 1e-11, 1e-9 };
static const double least_pivot = 1e-11;     /* a smaller entry of the column is rounding; entries are of order 1 */
static const double tie = 1e-12;             /* ratios that differ by less, relatively, are equal */
static const double accuracy = 1e-8, exact = 1e-12;      /* a solution satisfies its conditions to this */
enum { REFINEMENTS = 30, MANY = 100 };       /* of MANY unknowns the first accurate solution is taken, without a search for an exact one */

/* B^-1 (n x n) by rows and the values of the basis; a column is made when it enters. */
typedef struct tableau { int n; double shift; bool uneven; const double *m; double *inverse, *q, *column; int *basis; } tableau;

size_t lw_lcp_work(int n)
{
    size_t k = (size_t)n;
    return k*k + 4*k + 2;
}

/* What is added to diagonal entry i: equal amounts, or between 1 and 2 times the shift (multiples of the golden ratio, without their whole part). */
static double added(const tableau *t, int i)
{
    double part = 0.6180339887498949*i;
    return t->shift*(t->uneven ? 1 + part - floor(part) : 1);
}

/* Column of variable v in the present basis: 0 .. n-1 w, n .. 2n-1 z, 2n the artificial one.  w - M z - 1 z0 = q. */
static void make_column(const tableau *t, int v)
{
    int n = t->n;
    for (int i = 0; i < n; i++) {
        const double *row = t->inverse + (size_t)i*(size_t)n;
        double sum = 0;
        if (v < n)
            sum = row[v];
        else {
            for (int k = 0; k < n; k++)
                sum -= row[k]*(v < 2*n ? t->m[(size_t)k*(size_t)n + (size_t)(v - n)] : 1);
            sum -= v < 2*n ? row[v - n]*added(t, v - n) : 0;
        }
        t->column[i] = sum;
    }
}

static void pivot(tableau *t, int r, int v)
{
    int n = t->n;
    double *row = t->inverse + (size_t)r*(size_t)n, by = 1/t->column[r];
    for (int k = 0; k < n; k++)
        row[k] *= by;
    t->q[r] *= by;
    for (int i = 0; i < n; i++) {
        double factor = t->column[i], *to = t->inverse + (size_t)i*(size_t)n;
        if (i == r || factor == 0)
            continue;
        for (int k = 0; k < n; k++)
            if (row[k] != 0)
                to[k] -= factor*row[k];
        t->q[i] -= factor*t->q[r];
    }
    t->basis[r] = v;
}

/* Is row i before row j in the ratio test: least q over the column, ties broken by the rows of the inverse? */
static bool before(const tableau *t, int i, int j)
{
    int n = t->n;
    double a = t->column[i], b = t->column[j], x = t->q[i]/a, y = t->q[j]/b;
    if (fabs(x - y) > tie*(fabs(x) + fabs(y)))
        return x < y;
    for (int k = 0; k < n; k++) {
        x = t->inverse[(size_t)i*(size_t)n + (size_t)k]/a;
        y = t->inverse[(size_t)j*(size_t)n + (size_t)k]/b;
        if (fabs(x - y) > tie*(fabs(x) + fabs(y)))
            return x < y;
    }
    return false;
}

/* x += B^-1 (q - B x) for the values of the basis: removes the rounding of the pivots, and the shift.  Returns the greatest change over the
 * greatest value. */
static double refine(const tableau *t, const double *q)
{
    double most = 0, change = 0;
    int n = t->n;
    double *left = t->column;
    for (int i = 0; i < n; i++)
        left[i] = q[i];
    for (int r = 0; r < n; r++) {
        int v = t->basis[r];
        double x = t->q[r];
        if (v < n)
            left[v] -= x;
        for (int i = 0; v >= n && i < n; i++)
            left[i] += x*(v == 2*n ? 1 : t->m[(size_t)i*(size_t)n + (size_t)(v - n)] + (v - n == i)*added(t, i));
    }
    for (int r = 0; r < n; r++) {
        double add = 0;
        for (int k = 0; k < n; k++)
            add += t->inverse[(size_t)r*(size_t)n + (size_t)k]*left[k];
        t->q[r] += add;
        change = fmax(change, fabs(add));
        most = fmax(most, fabs(t->q[r]));
    }
    return most > 0 ? change/most : 0;
}

/* The basis by Lemke's method for M with the shift on its diagonal, its values for M, or with `keep` for that. */
static lw_status solve(int n, const double *m, double shift, bool uneven, bool keep, const double *q, double *work, double *z)
{
    size_t k = (size_t)n;
    tableau t = { n, shift, uneven, m, work, work + k*k, work + k*k + k, (int *)(void *)(work + k*k + 2*k) };
    int least = 0;
    memset(t.inverse, 0, k*k*sizeof *t.inverse);
    memset(z, 0, k*sizeof *z);
    for (int i = 0; i < n; i++) {
        t.inverse[(size_t)i*k + (size_t)i] = 1;
        t.q[i] = q[i];
        t.basis[i] = i;
        if (!isfinite(q[i]))
            return LW_E_NUMERIC;
        least = q[i] < q[least] ? i : least;
    }
    if (n == 0 || q[least] >= 0)
        return LW_OK;
    make_column(&t, 2*n);
    pivot(&t, least, 2*n);
    int enter = n + least;
    for (int pass = 0; pass < 100 + 2*n; pass++) {
        int r = -1;
        make_column(&t, enter);
        for (int i = 0; i < n; i++)
            if (t.column[i] > least_pivot && (r < 0 || before(&t, i, r)))
                r = i;
        if (r < 0)
            return LW_NOTHING;
        int leaves = t.basis[r];
        pivot(&t, r, enter);
        if (leaves == 2*n) {
            t.shift = keep ? shift : 0;
            double change = INFINITY, before;
            int passes = 0;
            do {                                 /* until only rounding changes */
                before = change;
                change = refine(&t, q);
            } while (++passes < REFINEMENTS && change > 1e-16 && change < 0.5*before);
            for (int i = 0; i < n; i++)
                if (t.basis[i] >= n && t.basis[i] < 2*n)
                    z[t.basis[i] - n] = fmax(t.q[i], 0);
            return LW_OK;
        }
        enter = leaves < n ? leaves + n : leaves - n;
    }
    return LW_E_NUMERIC;
}

/* Is z a solution?  Numbers are of the order of q. */
static bool solves(int n, const double *m, const double *q, const double *z, double tolerance)
{
    double size = 0, most = 0;
    for (int i = 0; i < n; i++) {
        size = fmax(size, fabs(q[i]));
        most = fmax(most, z[i]);
    }
    for (int i = 0; i < n; i++) {
        double w = q[i], terms = fabs(q[i]);
        for (int j = 0; j < n; j++) {
            w += m[(size_t)i*(size_t)n + (size_t)j]*z[j];
            terms += fabs(m[(size_t)i*(size_t)n + (size_t)j]*z[j]);
        }
        double off = z[i] > tolerance*most ? fabs(w) : fmax(-w, 0);
        if (!(off <= tolerance*fmax(terms, size)))
            return false;
    }
    return true;
}

lw_status lw_lcp_solve(int n, const double *m, const double *q, double *work, double *z)
{
    const int n_shift = (int)(sizeof shifts/sizeof *shifts);
    double *accurate = work + lw_lcp_work(n) - n;
    lw_status s = LW_NOTHING;
    bool found = false;
    for (int i = 0; i < 2*n_shift && !(found && (n > MANY || i >= n_shift)); i++) {
        s = solve(n, m, shifts[i % n_shift], i >= n_shift, false, q, work, z);
        if (s == LW_OK && solves(n, m, q, z, exact))
            return LW_OK;
        if (s == LW_OK && !found && solves(n, m, q, z, accuracy)) {
            memcpy(accurate, z, (size_t)n*sizeof *z);
            found = true;
        }
    }
    if (found) {
        memcpy(z, accurate, (size_t)n*sizeof *z);
        return LW_OK;
    }
    for (int i = 0; i < n_shift; i++) {
        s = solve(n, m, shifts[i], false, true, q, work, z);
        if (s == LW_OK && solves(n, m, q, z, accuracy))
            return LW_OK;
    }
    return s == LW_OK ? LW_E_NUMERIC : s;
}

/* base/eigen.c - bridge to GSL's eigenvalues; the QL method. */
#include <float.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include "base/gsl_errors.h"
#include "base/real.h"
#include "base/eigen.h"

/* Are the coefficients finite? Those that are next to nothing become zero: on subnormal numbers GSL iterates for ever. */
static bool prepare(double *v, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(v[i]))
            return false;
        if (fabs(v[i]) < 1e-290)
            v[i] = 0;
    }
    return true;
}

lw_status lw_eigen_symmetric(int n, double *k, double *m, double *w, double *x)
{
    size_t size = (size_t)n;
    if (!prepare(k, size*size) || (m && !prepare(m, size*size)))
        return LW_E_ARG;
    gsl_matrix_view a = gsl_matrix_view_array(k, size, size), b = gsl_matrix_view_array(m ? m : k, size, size);
    gsl_matrix_view vectors = gsl_matrix_view_array(x, size, size);
    gsl_vector_view values = gsl_vector_view_array(w, size);
    lw_gsl_begin();                        /* a mass matrix that is not positive is an error of GSL */
    gsl_eigen_gensymmv_workspace *work = m ? gsl_eigen_gensymmv_alloc(size) : NULL;
    gsl_eigen_symmv_workspace *plain = !m ? gsl_eigen_symmv_alloc(size) : NULL;
    lw_status s = work || plain ? LW_OK : LW_E_MEMORY;
    if (s == LW_OK && (m ? gsl_eigen_gensymmv(&a.matrix, &b.matrix, &values.vector, &vectors.matrix, work)
                         : gsl_eigen_symmv(&a.matrix, &values.vector, &vectors.matrix, plain)) != GSL_SUCCESS)
        s = LW_E_NUMERIC;
    if (s == LW_OK) {
        gsl_eigen_gensymmv_sort(&values.vector, &vectors.matrix, GSL_EIGEN_SORT_VAL_ASC);
        gsl_matrix_transpose(&vectors.matrix);
    }
    if (work)
        gsl_eigen_gensymmv_free(work);
    if (plain)
        gsl_eigen_symmv_free(plain);
    lw_gsl_end();
    return s;
}

/* Columns a and b (n) of the vectors turn. */
static void turn(int n, double *restrict a, double *restrict b, double c, double s)
{
    for (int i = 0; i < n; i++) {
        double x = a[i], y = b[i];
        a[i] = c*x - s*y;
        b[i] = s*x + c*y;
    }
}

/* One QL step with Wilkinson's shift on rows l to m. */
static void step_ql(double *d, double *e, int l, int m, int rows, double *x)
{
    double g = (d[l + 1] - d[l])/(2*e[l]), s = 1, c = 1, p = 0;
    g = d[m] - d[l] + e[l]/(g + copysign(sqrt(g*g + 1), g));
    for (int i = m - 1; i >= l; i--) {
        double f = s*e[i], b = c*e[i], r = sqrt(f*f + g*g);
        e[i + 1] = r;
        if (r == 0) {                        /* it has come apart here */
            d[i + 1] -= p;
            e[m] = 0;
            return;
        }
        s = f/r, c = g/r;
        g = d[i + 1] - p;
        r = (d[i] - g)*s + 2*c*b;
        p = s*r;
        d[i + 1] = g + p;
        g = c*r - b;
        turn(rows, x + (size_t)i*(size_t)rows, x + (size_t)(i + 1)*(size_t)rows, c, s);
    }
    d[l] -= p;
    e[l] = g;
    e[m] = 0;
}

lw_status lw_eigen_tridiagonal(int n, double *diagonal, double *beside, int rows, double *x)
{
    enum { MOST = 60 };                      /* steps for an eigenvalue; two are usual */
    double scale = 0;
    for (int i = 0; i < n; i++)
        scale = fmax(scale, fmax(fabs(diagonal[i]), i + 1 < n ? fabs(beside[i]) : 0));
    for (int i = 0; i < n; i++)
        if (!isfinite(diagonal[i]) || (i + 1 < n && !isfinite(beside[i])))
            return LW_E_ARG;
    if (!(scale > 0))
        return LW_OK;
    for (int i = 0; i < n; i++) {            /* squares stay in range */
        diagonal[i] /= scale;
        beside[i] = i + 1 < n ? beside[i]/scale : 0;
    }
    for (int l = 0, steps = 0; l < n;) {
        int m = l;
        while (m + 1 < n && fabs(beside[m]) > DBL_EPSILON*(fabs(diagonal[m]) + fabs(diagonal[m + 1])))
            m++;
        if (m == l)
            l++, steps = 0;
        else if (++steps > MOST)
            return LW_E_NUMERIC;
        else
            step_ql(diagonal, beside, l, m, rows, x);
    }
    for (int i = 0; i < n; i++)
        diagonal[i] *= scale;
    return LW_OK;
}

lw_status lw_eigen_general(int n, double *a, double *re, double *im, double *x_re, double *x_im)
{
    size_t size = (size_t)n;
    if (!prepare(a, size*size))
        return LW_E_ARG;
    gsl_matrix_view m = gsl_matrix_view_array(a, size, size);
    lw_gsl_begin();
    /* not GSL's own matrices: these leak if memory runs out while they are made */
    double *pairs = malloc((2*size + 2*size*size)*sizeof *pairs), *pair = pairs ? pairs + 2*size : NULL;
    gsl_eigen_nonsymmv_workspace *work = gsl_eigen_nonsymmv_alloc(size);
    lw_status s = pairs && work ? LW_OK : LW_E_MEMORY;
    if (s == LW_OK) {
        gsl_vector_complex_view values = gsl_vector_complex_view_array(pairs, size);
        gsl_matrix_complex_view vectors = gsl_matrix_complex_view_array(pair, size, size);
        gsl_eigen_nonsymmv_params(1, work);              /* balance: rates and places differ in size */
        s = gsl_eigen_nonsymmv(&m.matrix, &values.vector, &vectors.matrix, work) == GSL_SUCCESS ? LW_OK : LW_E_NUMERIC;
    }
    for (size_t j = 0; s == LW_OK && j < size; j++) {
        re[j] = pairs[2*j];
        im[j] = pairs[2*j + 1];
        for (size_t i = 0; i < size; i++) {
            x_re[j*size + i] = pair[2*(i*size + j)];
            x_im[j*size + i] = pair[2*(i*size + j) + 1];
        }
    }
    if (work)
        gsl_eigen_nonsymmv_free(work);
    free(pairs);
    lw_gsl_end();
    return s;
}

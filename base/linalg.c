/* base/linalg.c - Householder QR of small dense systems. */
#include "base/linalg.h"
#include "base/real.h"

/* v (length n) minus its reflection: v -= w (w . v) / beta */
static void reflect(int n, const double *w, double beta, double *v)
{
    double dot = 0.0;
    for (int i = 0; i < n; i++)
        dot += w[i]*v[i];
    double s = dot/beta;
    for (int i = 0; i < n; i++)
        v[i] -= s*w[i];
}

/* The reflector that maps column c (length n) onto a multiple of e1 takes its place; returns the
 * multiple.  The sign is chosen against cancellation, so w . c = beta = -r w[0] needs no storage. */
static double make_reflector(int n, double *c)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += c[i]*c[i];
    double r = c[0] > 0.0 ? -sqrt(sum) : sqrt(sum);
    c[0] -= r;
    return r;
}

double lw_qr_factor(int m, int n, double *a, double *diag)
{
    double least = HUGE_VAL, most = 0.0;
    for (int j = 0; j < n; j++) {
        double *w = a + (long)m*j + j;
        diag[j] = make_reflector(m - j, w);
        if (isnan(diag[j]))
            return diag[j];
        if (diag[j] != 0.0)
            for (int k = j + 1; k < n; k++)
                reflect(m - j, w, -diag[j]*w[0], a + (long)m*k + j);
        least = fmin(least, fabs(diag[j]));
        most = fmax(most, fabs(diag[j]));
    }
    return most > 0.0 ? least/most : 0.0;
}

void lw_qr_solve(int m, int n, const double *a, const double *diag, double *b)
{
    for (int j = 0; j < n; j++) {
        const double *w = a + (long)m*j + j;
        reflect(m - j, w, -diag[j]*w[0], b + j);
    }
    for (int j = n - 1; j >= 0; j--) {
        b[j] /= diag[j];
        for (int i = 0; i < j; i++)
            b[i] -= a[i + (long)m*j]*b[j];
    }
}

double lw_qr_determinant(int n, const double *diag)
{
    double d = n % 2 ? -1.0 : 1.0;           /* each of the n reflections has determinant -1 */
    for (int j = 0; j < n; j++)
        d *= diag[j];
    return d;
}

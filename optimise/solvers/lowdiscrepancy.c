#include "optimise/solvers/lowdiscrepancy.h"

#include <gsl/gsl_qrng.h>
#include "base/gsl_errors.h"

bool lw_low_discrepancy(lw_rng *shift, size_t n, int d, double *u)
{
    double by[40];
    lw_gsl_begin();
    gsl_qrng *q = d >= 1 && d <= 40 ? gsl_qrng_alloc(gsl_qrng_sobol, (unsigned)d) : NULL;
    lw_gsl_end();
    if (!q)
        return false;
    for (int k = 0; k < d; k++)
        by[k] = lw_rng_uniform(shift);
    for (size_t i = 0; i < n; i++) {
        double *p = u + i*(size_t)d;
        gsl_qrng_get(q, p);
        for (int k = 0; k < d; k++) {
            p[k] += by[k];
            p[k] -= p[k] >= 1;
        }
    }
    gsl_qrng_free(q);
    return true;
}

/* mbs/ode/panel.c - Chebyshev and Gauss-Legendre points (of GSL), and the matrices that integrate by them. */
#include "base/real.h"
#include "mbs/ode/panel_internal.h"

#include <gsl/gsl_integration.h>
#include "base/gsl_errors.h"
#include "base/vec2.h"

enum { N = LW_PANEL_NODES };

/* T_0 .. T_(N-1) at 2 x - 1.  In double precision the recurrence would lose digits near the ends. */
static void chebyshev(double x, double *t)
{
    long double z = 2*(long double)x - 1, before = 1, now = z;
    t[0] = 1;
    for (int k = 1; k < N; k++) {
        t[k] = (double)now;
        long double next = 2*z*now - before;
        before = now;
        now = next;
    }
}

/* out = a coef */
static void from_values(const lw_panel_rule *r, const lw_panel_matrix *a, lw_panel_matrix *out)
{
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            out->row[i][j] = 0;
            for (int k = 0; k < N; k++)
                out->row[i][j] += a->row[i][k]*r->coef.row[k][j];
        }
}

/* Weights of the integral up to node i by the polynomial through the values at the nodes last, last - 1 ... and at 0. */
static void weigh_past(const lw_panel_rule *r, int i, int last, double *weight)
{
    double at[LW_PANEL_PAST], from = i > 0 ? r->at[i - 1] : 0, length = r->at[i] - from;
    int n = last + 2 < LW_PANEL_PAST ? last + 2 : LW_PANEL_PAST;
    for (int k = 0; k < LW_PANEL_PAST; k++)
        weight[k] = 0, at[k] = k <= last ? r->at[last - k] : 0;
    for (int k = 0; k < n; k++)
        for (int g = 0; g < N; g++) {
            double x = from + length*r->gauss_at[g], value = length*r->gauss[g];
            for (int j = 0; j < n; j++)
                if (j != k)
                    value *= (x - at[j])/(at[k] - at[j]);
            weight[k] += value;
        }
}

lw_status lw_panel_rule_make(lw_panel_rule *r)
{
    lw_gsl_begin();
    gsl_integration_glfixed_table *gauss = gsl_integration_glfixed_table_alloc(N);
    lw_gsl_end();
    double y, w, t[N], one[N] = { 0 };
    lw_panel_matrix mean = { 0 }, root = { 0 };
    if (!gauss)
        return LW_E_MEMORY;
    for (int i = 0; i < N; i++) {
        double half = sin(0.5*LW_PI*(i + 0.5)/N);
        r->at[i] = half*half;
        chebyshev(r->at[i], t);
        for (int k = 0; k < N; k++)
            r->coef.row[k][i] = (k ? 2.0 : 1.0)/N*t[k];
    }
    for (int g = 0; g < N; g++) {
        gsl_integration_glfixed_point(0, 1, (size_t)g, &y, &w, gauss);
        r->gauss_at[g] = y;
        r->gauss[g] = w;
        chebyshev(y, t);
        for (int k = 0; k < N; k++)
            one[k] += w*t[k];
        for (int i = 0; i < N; i++) {
            chebyshev(r->at[i]*y, t);
            for (int k = 0; k < N; k++)
                mean.row[i][k] += w*t[k];
            chebyshev(r->at[i]*y*y, t);
            for (int k = 0; k < N; k++)
                root.row[i][k] += w*t[k];
        }
    }
    for (int i = 0; i < N; i++) {
        weigh_past(r, i, i - 1, r->ahead[i]);
        weigh_past(r, i, i, r->with[i]);
    }
    from_values(r, &mean, &r->mean);
    from_values(r, &root, &r->root);
    for (int j = 0; j < N; j++) {
        r->whole[j] = r->begin[j] = r->end[j] = 0;
        for (int k = 0; k < N; k++) {
            r->whole[j] += one[k]*r->coef.row[k][j];
            r->begin[j] += (k%2 ? -1 : 1)*r->coef.row[k][j];
            r->end[j] += r->coef.row[k][j];
        }
    }
    gsl_integration_glfixed_table_free(gauss);
    return LW_OK;
}

/* Not inlined into lw_panel_apply: its loops over nodes are 12 % slower then. */
__attribute__((noinline)) double lw_panel_sum(const double *weight, const double *f)
{
    double sum = 0;
    for (int j = 0; j < N; j++)
        sum += weight[j]*f[j];
    return sum;
}

void lw_panel_apply(const lw_panel_matrix *m, const double *f, double *out)
{
    for (int i = 0; i < N; i++)
        out[i] = lw_panel_sum(m->row[i], f);
}

double lw_panel_value(const double *c, double x)
{
    double z = 2*(2*x - 1), b1 = 0, b2 = 0;
    for (int k = N - 1; k > 0; k--) {
        double b = (c[k] - b2) + z*b1;       /* in this order one operation less has to wait for b1 */
        b2 = b1;
        b1 = b;
    }
    return c[0] + 0.5*z*b1 - b2;
}

double lw_panel_tail(const lw_panel_rule *r, const double *f)
{
    double most = 0;
    for (int i = 0; i < N; i++)
        most = fmax(most, fabs(f[i]));
    double last = fmax(fabs(lw_panel_sum(r->coef.row[N - 1], f)), fabs(lw_panel_sum(r->coef.row[N - 2], f)));
    return most > 0 ? last/most : 0;
}

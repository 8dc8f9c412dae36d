/* mbs/space/space_hold.c - how well drives hold a spatial model along a motion. */
#include "mbs/space/space_hold.h"

#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/vector.h"

static const double least_same = 0.5;        /* determinant of the cosines between the motions at two postures; less: too different */

lw_status lw_space_hold_make(int n, int n_v, lw_space_hold *h, lw_error *e)
{
    size_t columns = (size_t)n*(size_t)n_v;
    *h = (lw_space_hold){ .n = n, .n_v = n_v, .column = malloc(4*columns*sizeof *h->column + 1) };
    h->motions[0] = h->column + columns;
    h->motions[1] = h->motions[0] + columns;
    h->motions[2] = h->motions[1] + columns;
    return h->column ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void lw_space_hold_free(lw_space_hold *h)
{
    free(h->column);
    *h = (lw_space_hold){ 0 };
}

void lw_space_hold_begin(lw_space_hold *h)
{
    h->holds = 0;
    h->unsure = false;
}

void lw_space_hold_keep(lw_space_hold *h)
{
    h->kept = h->holds;
    if (h->holds != 0)
        memcpy(h->motions[2], h->motions[0], (size_t)h->n*(size_t)h->n_v*sizeof *h->column);
}

void lw_space_hold_back(lw_space_hold *h)
{
    double *last = h->motions[0];
    h->motions[0] = h->motions[2];
    h->motions[2] = last;
    h->holds = h->kept;
    h->unsure = false;
}

bool lw_space_hold_rates(lw_space_hold *h, lw_space_follow *f, const lw_spatial_measure *drive, double *a)
{
    const lw_space *s = f->z.s;
    int n = h->n;
    bool known = f->column == h->column && f->has_column;
    if (!known && !(lw_space_rows_factor_near(&f->z) && lw_space_rows_motions(&f->z, n, s->n_row + f->n_idle, h->column)))
        return false;
    for (int k = 0; k < n; k++) {
        int body[2];
        double jac[LW_SPACE_ROW];
        lw_space_measure(s, f->z.frame, drive[k], 0, jac);
        lw_space_bodies(s, &(lw_space_extra){ .measure = drive[k] }, body);
        for (int i = 0; i < n; i++) {
            a[i*n + k] = 0;
            for (int side = 0; side < 2; side++)
                if (body[side] >= 0)
                    a[i*n + k] += lw_dot(6, jac + 6*side, h->column + i*s->n_v + 6*body[side]);
        }
    }
    return true;
}

/* Make the n columns v (n_v each) orthonormal.  Returns the determinant of the columns in this basis; 0: they are dependent. */
static double orthonormalise(int n_v, int n, double *v)
{
    double det = 1;
    for (int i = 0; i < n; i++) {
        double *a = v + (size_t)i*(size_t)n_v;
        for (int pass = 0; pass < 2; pass++)             /* the second one removes the rounding of the first */
            for (int k = 0; k < i; k++) {
                const double *b = v + (size_t)k*(size_t)n_v;
                double along = lw_dot(n_v, a, b);
                for (int j = 0; j < n_v; j++)
                    a[j] -= along*b[j];
            }
        double length = sqrt(lw_dot(n_v, a, a));
        if (!(length > 0))
            return 0;
        for (int j = 0; j < n_v; j++)
            a[j] /= length;
        det *= length;
    }
    return det;
}

/* Determinant of a (n x n), which is changed. */
static double determinant(int n, double *a)
{
    double diag[LW_SPACE_HELD];
    lw_qr_factor(n, n, a, diag);
    return lw_qr_determinant(n, diag);
}

double lw_space_hold_now(lw_space_hold *h, double *a)
{
    int n = h->n, n_v = h->n_v;
    double cosine[LW_SPACE_HELD*LW_SPACE_HELD], holds = a ? determinant(n, a) : 1;
    memcpy(h->motions[1], h->column, (size_t)n*(size_t)n_v*sizeof *h->column);
    double det = orthonormalise(n_v, n, h->motions[1]);
    h->unsure = false;
    if (!(det > 0))
        return 0;
    if (h->holds == 0)
        return holds/det;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            cosine[i*n + k] = lw_dot(n_v, h->motions[0] + (size_t)i*(size_t)n_v, h->motions[1] + (size_t)k*(size_t)n_v);
    double same = determinant(n, cosine);
    h->unsure = fabs(same) < least_same;
    return same < 0 ? -holds/det : holds/det;
}

static void take(lw_space_hold *h, double holds)
{
    double *last = h->motions[0];
    h->motions[0] = h->motions[1];
    h->motions[1] = last;
    h->holds = holds;
}

bool lw_space_hold_lost(lw_space_hold *h, double holds)
{
    if (holds*h->holds < 0 || h->unsure)
        return true;
    if (holds != 0)
        take(h, holds);
    return false;
}

/* ---- along a path ---------------------------------------------------------------------------------------- */

static void look(void *context, const double *q)
{
    (void)q;                                 /* that of f */
    lw_space_watch *w = context;
    double a[LW_SPACE_HELD*LW_SPACE_HELD];
    double holds = lw_space_hold_rates(&w->hold, w->f, w->drive, a) ? lw_space_hold_now(&w->hold, a) : 0;
    if (lw_space_hold_lost(&w->hold, holds)) {
        if (!w->lost && !w->hold.unsure)
            w->lost = true, w->between[0] = fmin(w->at, w->f->u), w->between[1] = fmax(w->at, w->f->u);
        take(&w->hold, holds);
    }
    w->at = w->f->u;
}

lw_status lw_space_watch_begin(lw_space_watch *w, lw_space_follow *f, lw_error *e)
{
    const lw_space *s = f->z.s;
    const lw_spatial *m = s->model;
    int n = f->n_input;
    *w = (lw_space_watch){ .f = f };
    if (s->n_joint <= s->n_body || f->freedom > 0 || n > LW_SPACE_HELD || (m->n_drive ? m->n_drive != n : n < 2))
        return LW_OK;
    for (int i = 0; i < n; i++)
        w->drive[i] = m->n_drive ? m->drive[i] : f->z.extra[f->n_idle + i].measure;
    lw_status st = lw_space_hold_make(n, s->n_v, &w->hold, e);
    if (st == LW_OK)
        f->passed = look, f->passed_by = w, w->at = f->u, f->column = w->hold.column;
    return st;
}

void lw_space_watch_end(lw_space_watch *w)
{
    if (w->hold.column)
        w->f->passed = NULL, w->f->column = NULL, w->f->has_column = false;
    lw_space_hold_free(&w->hold);
}

/* mbs/analysis/freedoms.c - see freedoms.h */
#include "mbs/analysis/freedoms.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/rng.h"
#include "base/vector.h"
#include "mbs/dynamics/dynamics_equations_internal.h"

static const double step = 0.05;             /* greatest change of a coordinate that is tried, scaled */
static const double moves = 1e-6;            /* a link of which no coordinate moves more in a motion of length 1 stands still */

void lw_freedoms_free(lw_freedoms *f)
{
    free(f->still), free(f->loose), free(f->redundant);
    memset(f, 0, sizeof *f);
}

/* Close the kept rows from q.  Returns their greatest residual, infinite where a step is too long. */
static double close_kept(lw_dynamics *d, double *q, double tolerance)
{
    double off = INFINITY;
    for (int pass = 0; pass < 40; pass++) {
        double now = 0, *by = d->hold;
        if (lw_mbs_rows(d, d->o.from, q) != LW_OK)
            return INFINITY;
        for (int r = 0; r < d->n_c; r++) {
            d->rhs[r] = d->place[r] >= 0 ? -d->phi[r] : 0;
            now = fmax(now, fabs(d->rhs[r]));
        }
        if (now < 1e-15 || (now < tolerance && now > off/2))
            return now;
        if (lw_mbs_factor(d, false) != LW_OK)
            return INFINITY;
        off = now;
        lw_mbs_linear(d, NULL, d->rhs, by, d->l_each);
        if (!(lw_greatest(d->n_q, by) < 0.5))
            return INFINITY;
        d->eq.move(d->eq.context, q, by);
    }
    return off < tolerance ? off : INFINITY;
}

/* A random motion of first order at q, whose rows are arranged, of greatest coordinate 1. */
static void draw_motion(lw_dynamics *d, const double *q, lw_rng *rng, double *v)
{
    lw_mbs_rows(d, d->o.from, q);
    memset(v, 0, (size_t)d->n_v*sizeof *v);
    if (d->n_kept == d->n_v || lw_mbs_factor(d, false) != LW_OK)
        return;
    for (int i = 0; i < d->n_v; i++)
        d->force[i] = (2*lw_rng_uniform(rng) - 1)/d->by_mass[i];
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    lw_mbs_linear(d, d->force, d->rhs, v, d->l_each);
    lw_mbs_times(d, v, d->rhs);                          /* once more: rounding of the squared matrix */
    for (int r = 0; r < d->n_c; r++)
        d->rhs[r] = -d->rhs[r];
    lw_mbs_linear(d, NULL, d->rhs, d->hold, d->l_each);
    double top = 0;
    for (int i = 0; i < d->n_v; i++) {
        v[i] += d->hold[i];
        top = fmax(top, fabs(v[i]));
    }
    for (int i = 0; i < d->n_v; i++)
        v[i] /= top > 0 ? top : 1;
}

static double distance(const lw_dynamics *d, const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < d->n_q; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* Mark links that a motion at q does not move, or moves. */
static void mark(lw_dynamics *d, const double *q, lw_rng *rng, bool still, bool *link)
{
    double *v = d->stop_v;
    for (int b = 0; b < d->s.n_body; b++)
        link[d->s.link[b]] = still;
    for (int trial = 0; trial < 2; trial++) {
        draw_motion(d, q, rng, v);
        for (int b = 0; b < d->s.n_body; b++)
            if (lw_greatest(3, v + 3*b) > moves)
                link[d->s.link[b]] = !still;
    }
}

/* Displace the posture start and close it again; the best motion found is in f and its posture in best. */
static void find_motion(lw_dynamics *d, const double *start, double tolerance, lw_rng *rng, double *q, double *best, lw_freedoms *f)
{
    double least = fmax(tolerance, 1e-12);
    for (int trial = 0; trial < 8; trial++) {
        double length = step*(trial < 4 ? 1 : 0.2);
        if (lw_mbs_arrange(d, d->o.from, start) != LW_OK)
            return;
        draw_motion(d, start, rng, d->stop_v);
        for (int i = 0; i < d->n_q; i++)
            q[i] = start[i] + length*d->stop_v[i];
        double off = close_kept(d, q, least);
        off = off < INFINITY ? lw_greatest(d->n_c, d->phi) : off;
        if (!(off < least)) {                            /* rows that depend on others in the posture do not beside it */
            for (int i = 0; i < d->n_q; i++)
                q[i] = start[i] + length*d->stop_v[i];
            if (lw_mbs_arrange(d, d->o.from, q) != LW_OK)
                return;
            off = close_kept(d, q, least);
            off = off < INFINITY ? lw_greatest(d->n_c, d->phi) : off;
        }
        if (!(off < least) || distance(d, q, start) < 0.3*length || lw_mbs_arrange(d, d->o.from, q) != LW_OK)
            continue;
        if (f->kind == LW_MOBILITY_MOVES && d->n_q - d->n_kept <= f->freedom)
            continue;
        f->kind = LW_MOBILITY_MOVES;
        f->freedom = d->n_q - d->n_kept;
        f->rank = d->n_kept;
        f->distance = distance(d, q, start);
        f->residual = off*d->s.unit;
        memcpy(best, q, (size_t)d->n_q*sizeof *q);
        if (f->freedom == f->instant)
            return;
    }
}

static lw_status find(lw_dynamics *d, double tolerance, uint64_t seed, lw_freedoms *f, lw_error *e)
{
    int driven = d->n_driven;
    size_t n = (size_t)d->n_q;
    lw_rng rng;
    double *q = malloc(3*n*sizeof *q), *start = q + n, *best = start + n;
    f->still = calloc((size_t)d->model->linkage.n_link, sizeof *f->still);
    f->loose = calloc((size_t)d->model->linkage.n_link, sizeof *f->loose);
    f->redundant = calloc((size_t)d->n_row + 1, sizeof *f->redundant);
    if (!q || !f->still || !f->loose || !f->redundant) {
        free(q);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    lw_rng_seed(&rng, seed, 0);
    lw_system_posture(&d->s, start);
    d->n_driven = 0;
    f->n_body = d->s.n_body;
    f->n_q = d->n_q;
    f->n_row = d->n_row;
    f->count = d->n_q - d->n_row;
    lw_status st = lw_mbs_arrange(d, d->o.from, start);
    if (st == LW_OK && !(close_kept(d, start, fmax(tolerance, 1e-12)) < INFINITY))
        st = lw_error_set(e, LW_OPEN, "the posture of the file does not close, and no closed one is near");
    double off = lw_greatest(d->n_c, d->phi);
    if (st == LW_OK && !(off <= fmax(tolerance, 1e-9)))
        st = lw_error_set(e, LW_OPEN, "the posture does not close: joints that follow from others are off by %.3g m; give their places "
                          "with more digits, or a greater --tolerance", off*d->s.unit);
    if (st == LW_OK && (st = lw_mbs_arrange(d, d->o.from, start)) == LW_OK) {
        f->instant = d->n_q - d->n_kept;
        f->rank = d->n_kept;
        f->kind = f->instant > 0 ? LW_MOBILITY_SHAKY : LW_MOBILITY_RIGID;
        memcpy(best, start, n*sizeof *best);
        if (f->instant > 0)
            find_motion(d, start, tolerance, &rng, q, best, f);
        st = lw_mbs_arrange(d, d->o.from, best);
    }
    for (int r = 0; st == LW_OK && r < d->n_row; r++)
        if (d->place[r] < 0)
            f->redundant[f->n_redundant++] = d->s.row[r];
    if (st == LW_OK && f->kind == LW_MOBILITY_MOVES) {
        mark(d, best, &rng, true, f->still);
        d->n_driven = driven;
        st = lw_mbs_arrange(d, d->o.from, best);
        f->driven = d->n_kept - f->rank;
        if (st == LW_OK && driven)
            mark(d, best, &rng, false, f->loose);
    }
    free(q);
    return st;
}

lw_status lw_freedoms_find(const lw_model *m, double tolerance, uint64_t seed, lw_freedoms *f, lw_error *e)
{
    lw_dynamics *d = calloc(1, sizeof *d);
    memset(f, 0, sizeof *f);
    if (!d)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    d->model = m;
    d->o = lw_dynamics_options_default();
    d->o.rigid = d->o.hold_inputs = true;
    d->rows_only = true;
    lw_status s = lw_dynamics_prepare(d, e);
    if (s == LW_OK)
        s = find(d, tolerance, seed, f, e);
    lw_dynamics_free(d);
    if (s != LW_OK)
        lw_freedoms_free(f);
    return s;
}

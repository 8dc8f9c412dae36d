#include "optimise/pool.h"

#include <math.h>
#include <string.h>

/* Variables alike: lengths and coordinates to a part of the larger, angles the short way round. */
static bool alike(const lw_problem *p, const double *a, const double *b)
{
    for (int i = 0; i < p->n_var; i++) {
        bool angle = i >= p->n_dim || p->plan.dim[i].kind == LW_DIM_ANGLE;
        double d = angle ? remainder(a[i] - b[i], 2*LW_PI) : a[i] - b[i];
        double size = angle ? 1 : fmax(1, fmax(fabs(a[i]), fabs(b[i])));
        if (fabs(d) > 1e-4*size)
            return false;
    }
    return true;
}

static bool same(const lw_problem *p, const lw_found *a, const lw_found *b)
{
    double f = fmax(a->f, b->f);
    return a->arm == b->arm && fabs(a->f - b->f) <= 1e-4*f + 1e-24 && alike(p, a->x, b->x);
}

static void take_out(lw_pool *p, int i)
{
    p->n--;
    memmove(p->item + i, p->item + i + 1, sizeof p->item[0]*(size_t)(p->n - i));
}

void lw_pool_put(lw_pool *p, const lw_found *c, const lw_problem *problem)
{
    lw_found put = *c;
    put.hits = put.hits > 0 ? put.hits : 1;
    if (!isfinite(put.f))
        return;
    for (int i = 0; i < p->n; i++)
        if (same(problem, &p->item[i], &put)) {
            int hits = p->item[i].hits + put.hits;
            if (p->item[i].f <= put.f) {
                p->item[i].hits = hits;
                return;
            }
            put.hits = hits;
            take_out(p, i);
            break;
        }
    int at = p->n;
    while (at > 0 && p->item[at - 1].f > put.f)
        at--;
    if (at == LW_POOL_MAX)
        return;
    int move = (p->n < LW_POOL_MAX ? p->n : LW_POOL_MAX - 1) - at;
    memmove(p->item + at + 1, p->item + at, sizeof p->item[0]*(size_t)move);
    p->item[at] = put;
    p->n = at + move + 1;
}

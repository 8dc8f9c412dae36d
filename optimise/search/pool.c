#include "optimise/search/pool.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"

lw_variables lw_pool_variables(const lw_problem *p)
{
    lw_variables v = { .n = p->n_var };
    for (int i = 0; i < p->n_var; i++)
        if (i >= p->n_dim || p->plan.dim[i].kind == LW_DIM_ANGLE)
            v.angle[i/64] |= (uint64_t)1 << i % 64;
    return v;
}

#define SAME   1e-4         /* relative difference of variables and f of the same linkage              */
#define ROUNDING 1e-24      /* of f at an exact fit                                                    */
#define AS_SMALL 1.02       /* sizes that differ less are alike                                        */

/* Do the variables agree: lengths and coordinates relative to the larger, angles the short way round? */
static bool alike(const lw_variables *v, const double *a, const double *b)
{
    for (int i = 0; i < v->n; i++) {
        bool angle = v->angle[i/64] >> i % 64 & 1;
        double d = angle ? remainder(a[i] - b[i], 2*LW_PI) : a[i] - b[i];
        double size = angle ? 1 : fmax(1, fmax(fabs(a[i]), fabs(b[i])));
        if (fabs(d) > SAME*size)
            return false;
    }
    return true;
}

static bool same(const lw_variables *v, const lw_found *a, const lw_found *b)
{
    double f = fmax(a->f, b->f);
    return a->candidate == b->candidate && fabs(a->f - b->f) <= SAME*f + ROUNDING && alike(v, a->x, b->x);
}

static void take_out(lw_pool *p, int i)
{
    p->n--;
    memmove(p->item + i, p->item + i + 1, sizeof p->item[0]*(size_t)(p->n - i));
}

static bool before(const lw_pool *p, const lw_found *a, const lw_found *b)
{
    return p->by_cost ? a->cost < b->cost : a->beyond != b->beyond ? a->beyond < b->beyond : a->f < b->f;
}

static bool is_covered(const lw_pool *p, int i)
{
    const lw_found *c = &p->item[i];
    bool covered = false;
    for (int k = 0; k < i && !covered && !c->moved; k++)
        covered = p->item[k].size <= AS_SMALL*c->size && p->item[k].gentle >= c->gentle;
    return covered;
}

void lw_pool_shorten(lw_pool *p, int most)
{
    while (p->n > most) {
        int drop = p->by_cost ? 0 : p->n - 1;
        while (drop > 0 && !is_covered(p, drop))
            drop--;
        take_out(p, drop > 0 ? drop : p->n - 1);
    }
}

void lw_pool_put(lw_pool *p, const lw_found *c, const lw_variables *of)
{
    lw_found put = *c;
    put.hits = put.hits > 0 ? put.hits : 1;
    if (!isfinite(put.f))
        return;
    for (int i = 0; i < p->n; i++)
        if (same(of, &p->item[i], &put)) {
            int hits = p->item[i].hits + put.hits;
            if (!before(p, &put, &p->item[i])) {
                p->item[i].hits = hits;
                return;
            }
            put.hits = hits;
            take_out(p, i);
            break;
        }
    int at = p->n;
    while (at > 0 && before(p, &put, &p->item[at - 1]))
        at--;
    memmove(p->item + at + 1, p->item + at, sizeof p->item[0]*(size_t)(p->n - at));
    p->item[at] = put;
    p->n++;
    lw_pool_shorten(p, LW_POOL_MAX);
}

enum { HEAD = 5 };           /* numbers of a find before its variables */

static size_t size_of_one(const lw_best_starts *starts)
{
    return (size_t)(HEAD + starts->of.n + starts->n_mode);
}

lw_best_starts *lw_best_starts_of(const lw_pool *p, int most, const lw_variables *of, int n_mode)
{
    lw_best_starts head = { .n = p->n < most ? p->n : most, .n_mode = n_mode, .of = *of };
    size_t one = size_of_one(&head);
    lw_best_starts *starts = head.n > 0 ? malloc(sizeof *starts + sizeof(double)*one*(size_t)head.n) : NULL;
    if (!starts)
        return NULL;
    *starts = head;
    starts->candidate = p->item[0].candidate;
    for (int i = 0; i < starts->n; i++) {
        const lw_found *c = &p->item[i];
        double *at = starts->number + one*(size_t)i;
        memcpy(at, (double[HEAD]){ c->f, c->intended.sense, c->intended.turns, c->intended.mid, c->intended.half },
               HEAD*sizeof *at);
        memcpy(at + HEAD, c->x, sizeof *at*(size_t)of->n);
        memcpy(at + HEAD + of->n, c->intended.mode, sizeof *at*(size_t)n_mode);
    }
    return starts;
}

double lw_best_starts_f(const lw_best_starts *starts, int i)
{
    return starts->number[size_of_one(starts)*(size_t)i];
}

void lw_best_starts_get(const lw_best_starts *starts, int i, lw_found *c)
{
    assert(i >= 0 && i < starts->n);
    const double *at = starts->number + size_of_one(starts)*(size_t)i;
    *c = (lw_found){ .f = at[0], .candidate = starts->candidate, .hits = 1,
                     .intended = { .sense = (int)at[1], .turns = at[2] != 0, .mid = at[3], .half = at[4] } };
    memcpy(c->x, at + HEAD, sizeof *at*(size_t)starts->of.n);
    memcpy(c->intended.mode, at + HEAD + starts->of.n, sizeof *at*(size_t)starts->n_mode);
}

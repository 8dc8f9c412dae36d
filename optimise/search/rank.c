/* optimise/search/rank.c - the list of results: candidates in order, no two with the same curve. */
#include <stdlib.h>
#include <string.h>

#include "mbs/batch/posture.h"
#include "optimise/search/fit_internal.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/timing.h"

#define SAME_POINT 1e-4         /* stations of the same curve agree to this; the target has size one   */
#define SAME_CURVE 0.03         /* so do samples, as far as polygons through samples can tell           */
enum { PULLS = 20 };            /* each twice as far as the one before                               */
#define FIRST_PULL 1e-16        /* parts of a stroke                                                  */
#define ON_TARGET 1e-12         /* a sample nearer than this adds nothing; the target has size one    */
#define SMALLER    0.95         /* sizes of a cognate that is preferred                               */
#define SAME_ERROR 1e-3         /* relative, of f of cognates                                         */
#define SAME_RATIO 1e-4         /* relative, of two lengths of the same function generator              */

/* The positions of a find at the stations, and samples of its curve. */
typedef struct traced {
    const lw_found *of;
    double *px, *py;             /* stations of every point, one point after the other           */
    double  cx[LW_CURVE_SAMPLES], cy[LW_CURVE_SAMPLES];
} traced;

static double nearest_of(const traced *t, double x, double y)
{
    double least = INFINITY;
    for (int j = 0; j < LW_CURVE_SAMPLES; j++) {
        int k = (j + 1) % LW_CURVE_SAMPLES;
        least = lw_v2_nearer(lw_v2(x, y), lw_v2(t->cx[j], t->cy[j]), lw_v2(t->cx[k], t->cy[k]), least);
    }
    return least;
}

/* Do two finds have the same curve, as cognates or a linkage found twice have, and the same curves of further
 * points? */
static bool same_curves(const traced *a, const traced *b, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (hypot(a->px[k] - b->px[k], a->py[k] - b->py[k]) > SAME_POINT)
            return false;
    for (int j = 0; j < LW_CURVE_SAMPLES; j += 4)
        if (nearest_of(b, a->cx[j], a->cy[j]) > SAME_CURVE)
            return false;
    return true;
}

/* Are two finds the same function generator: links with the same proportions?  An offset to the other side with the
 * slide reversed is the same. */
static bool same_proportions(lw_search *s, const lw_found *a, const lw_found *b)
{
    lw_status st;
    const lw_problem *p = lw_search_made(s, 0, a->candidate, false, &st);
    const lw_problem *q = p ? lw_search_made(s, 0, b->candidate, false, &st) : NULL;
    if (!q || strcmp(lw_family_type(p->family), lw_family_type(q->family)) != 0 || p->n_dim != q->n_dim)
        return false;
    int first = p->family->linkage ? lw_problem_first_length(p) : lw_problem_index(p, p->family->shape[0]);
    for (int i = 0; i < p->n_dim; i++) {
        double u = fabs(a->x[i]/a->x[first]), v = fabs(b->x[i]/b->x[first]);
        if (p->plan.dim[i].kind != LW_DIM_ANGLE && fabs(u - v) > SAME_RATIO*fmax(1, u))
            return false;
    }
    return true;
}

/* The problem of a find in its intended motion, the stations at their best inputs; NULL: there are none. */
static const lw_problem *settled(lw_search *s, int thread, const lw_found *c, lw_work **w)
{
    lw_status st;
    lw_problem *p = lw_search_problem(s, thread, c->candidate, false, &st);
    if (!p)
        return NULL;
    *w = s->bench[thread].work;
    p->intended = c->intended;
    lw_problem_work_intended(p, *w);
    return lw_problem_settle(p, c->x, *w) ? p : NULL;
}

static bool trace(lw_search *s, const lw_found *c, traced *t)
{
    lw_work *w;
    const lw_problem *p = settled(s, 0, c, &w);
    t->of = c;
    if (!p)
        return false;
    for (int i = 0; i <= p->n_also; i++) {
        memcpy(t->px + (size_t)i*p->n, lw_work_jac(w, i)->x, sizeof *t->px*p->n);
        memcpy(t->py + (size_t)i*p->n, lw_work_jac(w, i)->y, sizeof *t->py*p->n);
    }
    if (!p->intended.turns && !lw_circuit_find(p, c->x, w)) {   /* no limits of motion found: compare stations only */
        for (int j = 0; j < LW_CURVE_SAMPLES; j++) {
            t->cx[j] = t->px[0];
            t->cy[j] = t->py[0];
        }
        return true;
    }
    lw_timing_sample(p, c->x, w);
    memcpy(t->cx, w->curve_x, sizeof t->cx);
    memcpy(t->cy, w->curve_y, sizeof t->cy);
    return true;
}

/* Give the candidate its family; one of lw_fit_options.families in memory of its own. */
static bool give_family(const lw_search *s, int candidate, lw_candidate *out)
{
    out->own = s->o->families ? malloc(sizeof *out->own) : NULL;
    return (out->own || !s->o->families) && lw_search_family(s, candidate, out->own, &out->family) == LW_OK;
}

/* Put input k and its assembly mode into the candidate.  Rounding may put a station at a limit just beyond it: it is
 * moved back inside by the least step that closes. */
static void put_input(const lw_problem *p, const lw_work *w, size_t k, double input, int leg, double psi_c, lw_candidate *c)
{
    double mode[LW_MODE_MAX], unit = p->plan.input_is_slider ? p->unit : 1, from = c->input[k] = input*unit;
    size_t dyads = (size_t)c->n_dyad;
    lw_posture posture;
    if (!c->mode_of)
        return;
    lw_circuit_put_mode(p, w, leg, c->mode_of + k*dyads, 1);
    if (w->swing.turning)
        return;
    double step = copysign(FIRST_PULL*w->swing.stroke[leg].half, psi_c)*unit;
    memcpy(mode, c->mode_of + k*dyads, sizeof *mode*dyads);
    for (int i = 0; i < PULLS && lw_posture_solve(&p->plan, c->dim, mode, c->input[k], 0, &posture) != LW_OK; i++, step *= 2)
        c->input[k] = from + step;
}

bool lw_search_fill(lw_search *s, int thread, const lw_found *c, lw_candidate *out)
{
    lw_work *w;
    const lw_problem *p = settled(s, thread, c, &w);
    if (!p)
        return false;
    *out = (lw_candidate){ .intended = p->intended,
                           .n_dim = p->n_dim, .objective = c->f*p->scale, .beyond = c->beyond, .evals = c->evals,
                           .longest = lw_problem_size(p, c->x)*p->unit, .gentle = c->gentle,
                           .seconds = c->seconds, .stop = c->stop, .part = s->o->part,
                           .part_number = s->o->part_number };
    lw_problem_to_dims(p, c->x, out->dim);
    out->input0 = p->i_input0 >= 0 ? c->x[p->i_input0] : 0;
    out->tool0 = p->i_tool0 >= 0 ? c->x[p->i_tool0] : 0;
    for (int i = 0; i < p->n_also; i++)
        out->tool[i] = p->also[i].i_tool >= 0 ? c->x[p->also[i].i_tool] : 0;
    bool both_modes = lw_problem_has_modes(p);
    size_t most = lw_problem_lane_count(p);
    out->input = malloc(sizeof *out->input*most);
    size_t dyads = (size_t)(out->n_dyad = p->plan.n_dyad);
    out->mode_of = both_modes ? malloc(sizeof *out->mode_of*most*dyads) : NULL;
    if (!out->input || (both_modes && !out->mode_of) || !give_family(s, c->candidate, out)) {
        s->no_memory = true;
        lw_candidate_free(out);
        return false;
    }
    for (size_t k = 0; k < p->n; k++)
        put_input(p, w, k, w->input[k], both_modes ? w->leg[k] : 0, both_modes ? w->psi_c[k] : 0, out);
    out->sample_weight = most > p->n ? w->sample_weight : 0;
    for (size_t k = p->n; k < most; k++) {
        size_t j = k - p->n;
        if (!(hypot(w->jac.x[k] - w->foot_x[j], w->jac.y[k] - w->foot_y[j]) > ON_TARGET))
            continue;
        lw_cycle_point at;
        lw_circuit_points(p, w, 1, &w->turn[j], &at);
        put_input(p, w, p->n + (size_t)out->n_sample++, at.input, at.leg, at.psi_c, out);
    }
    return true;
}

/* Find a, whose error is not less, has the same curve as b.  Is it a smaller linkage, which is the better one if the errors are the
 * same (a cognate), and else another result? */
static bool is_smaller(lw_search *s, const lw_found *a, const lw_found *b)
{
    lw_status st;
    const lw_problem *p = lw_search_made(s, 0, a->candidate, false, &st);
    double size = p ? lw_problem_size(p, a->x) : INFINITY;
    p = lw_search_made(s, 0, b->candidate, false, &st);
    return s->o->spec.by_default && p && a->beyond == b->beyond && size < SMALLER*lw_problem_size(p, b->x);
}

static bool is_as_exact(const lw_found *a, const lw_found *b)
{
    return fabs(a->f - b->f) <= SAME_ERROR*b->f;
}

/* The candidates in `out` with their curves. */
typedef struct ranking {
    traced *seen;                /*                                                       (out->n) */
    double *points;              /* coordinates of n stations each                                  */
    size_t  n;
    lw_fit *out;
} ranking;

/* Add up to `most` finds of a pool whose curves no candidate before has.  Shrunk finds replace none. */
static void rank_pool(lw_search *s, const lw_pool *pool, int most, bool shrunk, ranking *r)
{
    lw_fit *out = r->out;
    most += out->n;
    for (int i = 0; i < pool->n && out->n < most; i++) {
        const lw_found *c = &pool->item[i];
        traced *t = &r->seen[out->n];
        t->px = r->points + 2*r->n*(size_t)out->n;
        t->py = t->px + r->n;
        bool fresh = trace(s, c, t);
        for (int k = 0; fresh && k < out->n; k++) {
            traced *before = &r->seen[k];
            lw_candidate instead;
            fresh = !lw_task_has_place(s->o->spec.task) ? !same_proportions(s, t->of, before->of)
                                                        : !same_curves(t, before, r->n);
            bool smaller = !fresh && (is_smaller(s, c, before->of) || (c->moved && !before->of->moved)), exact = is_as_exact(c, before->of);
            fresh |= (shrunk || !exact || c->moved) && (smaller || c->gentle > before->of->gentle);
            if (fresh || !smaller || !exact || !lw_search_fill(s, 0, c, &instead))
                continue;
            lw_candidate_free(&out->candidate[k]);
            out->candidate[k] = instead;
            before->of = c;
        }
        if (fresh && lw_search_fill(s, 0, c, &out->candidate[out->n]))
            out->candidate[out->n++].shrunk = shrunk;
    }
}

lw_status lw_search_rank(lw_search *s, lw_fit *out)
{
    const int kept = lw_fit_kept(s->o);
    const size_t most = 2*(size_t)kept, n = s->t->n*(size_t)(1 + s->t->n_also);
    ranking r = { .seen = calloc(most + 1, sizeof *r.seen), .points = malloc(sizeof *r.points*2*n*(most + 1)), .n = n, .out = out };
    out->candidate = calloc(most, sizeof *out->candidate);
    lw_status st = r.seen && r.points && out->candidate ? LW_OK : LW_E_MEMORY;
    if (st == LW_OK) {
        rank_pool(s, &s->pool, kept, false, &r);
        rank_pool(s, &s->shrunk, kept, true, &r);
    }
    free(r.seen);
    free(r.points);
    return st;
}

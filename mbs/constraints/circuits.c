/* mbs/constraints/circuits.c - circuits found from random postures. */
#include "mbs/constraints/circuits.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/growable_array.h"
#include "base/owners.h"
#include "base/rank.h"
#include "base/rng.h"
#include "base/vector.h"
#include "mbs/constraints/sparse_rows_internal.h"

typedef struct closer {
    const lw_system *s;
    int     m, n, n_held, *held;
    bool    sparse;
    lw_rank rank;
    lw_sparse_rows rows;
    lw_owners joints;                      /* of each link                                            */
    lw_body_frame *frame;
    double *q, *rest, *step, *store;
    int    *ints;
} closer;

static bool make_closer(const lw_system *s, int free_input, closer *c)
{
    memset(c, 0, sizeof *c);
    c->s = s;
    c->n = s->n_q;
    c->sparse = c->n > LW_SYSTEM_Q_MAX;
    c->held = malloc(((size_t)s->n_input + 1)*sizeof *c->held);
    c->frame = malloc(((size_t)s->n_body + 1)*sizeof *c->frame);
    if (!c->held || !c->frame)
        return false;
    for (int i = 0; i < s->n_input; i++)
        if (i != free_input)
            c->held[c->n_held++] = i;
    c->m = s->n_row + c->n_held;
    c->store = malloc(((c->sparse ? 0 : lw_rank_doubles(c->m, c->n)) + (size_t)(c->m + 2*c->n))*sizeof *c->store);
    c->ints = malloc((c->sparse ? (size_t)c->n : lw_rank_ints(c->m, c->n))*sizeof *c->ints);
    if (!c->store || !c->ints)
        return false;
    c->q = c->store;
    c->rest = c->q + c->n;
    c->step = c->rest + c->m;
    if (c->sparse)
        return lw_sparse_rows_create(s, c->held, c->n_held, &c->rows)
               && lw_owners_make(&c->joints, s->n_body, s->joint, sizeof *s->joint, offsetof(lw_system_joint, body), s->n_joint, 2);
    lw_rank_place(&c->rank, c->m, c->n, c->step + c->n, c->ints);
    return true;
}

static void free_closer(closer *c)
{
    free(c->held);
    free(c->frame);
    free(c->store);
    free(c->ints);
    lw_sparse_rows_free(&c->rows);
    lw_owners_free(&c->joints);
}

/* Residuals of rows and resting inputs at q, and their derivatives; returns the largest. */
static double equations(closer *c, const double *q)
{
    double *jac = c->sparse ? NULL : c->rank.a;
    lw_system_place(c->s, q, c->frame);
    if (jac)
        memset(jac, 0, (size_t)c->m*(size_t)c->n*sizeof *jac);
    else
        lw_sparse_rows_fill(&c->rows, c->frame);
    lw_system_fill(c->s, c->frame, c->rest, jac, 1, c->m);
    for (int i = 0; i < c->n_held; i++) {
        int r = c->s->n_row + i;
        c->rest[r] = lw_system_count(c->s, c->frame, c->s->input_joint[c->held[i]], jac ? jac + r : NULL, c->m);
    }
    return lw_greatest(c->m, c->rest);
}

/* The least-norm step, or nearly that with sparse rows: Levenberg's, with a weight that falls with the residual. */
static bool solve(closer *c, double most)
{
    if (!c->sparse) {
        lw_rank_factor(&c->rank, 1e-10);
        lw_rank_solve(&c->rank, c->rest, c->step);
        return true;
    }
    double *weight = lw_sparse_rows_weights(&c->rows);
    for (int k = 0; k < c->n; k++)
        weight[k] = fmin(fmax(most, 1e-6), 1e-2);
    if (!(lw_sparse_rows_factor(&c->rows, 0.0, NULL) > 0.0))
        return false;
    lw_sparse_rows_solve(&c->rows, c->rest, false, c->step);
    return true;
}

/* Newton's method with least-norm steps, none longer than 1. */
static bool close_up(closer *c, double *q, const volatile sig_atomic_t *stop)
{
    for (int i = 0; i < 60 && !(stop && *stop); i++) {
        double most = equations(c, q), length = 0.0;
        if (most < 1e-14)
            return true;
        if (!solve(c, most))
            return false;
        for (int k = 0; k < c->n; k++)
            length += c->step[k]*c->step[k];
        double share = fmin(1.0, 1.0/sqrt(length));
        for (int k = 0; k < c->n; k++)
            q[k] -= share*c->step[k];
        if (!isfinite(length) || (length < 1e-28 && most > 1e-12))
            return false;
    }
    return equations(c, q) < 1e-13;
}

static void draw(lw_rng *r, const lw_system *s, double *q)
{
    for (int i = 0; i < s->n_q; i++)
        q[i] = i % 3 == 2 ? lw_rng_range(r, -LW_PI, LW_PI) : lw_rng_range(r, -1.5, 1.5);
}

/* The greatest distance of a joint of body b from its reference point. */
static double body_size(const closer *c, int b)
{
    double size = 0.0;
    for (int at = c->joints.start[b]; at < c->joints.start[b + 1]; at++)
        size = fmax(size, lw_v2_norm(c->s->joint[c->joints.entry[at]/2].arm[c->joints.entry[at]%2]));
    return size;
}

static int below(lw_rng *r, int n) { return (int)(n*lw_rng_uniform(r)); }

/* A posture of a known curve in which one to four neighbouring bodies are drawn anew. */
static void draw_patch(lw_rng *r, closer *c, const lw_circuits *known, double *q)
{
    const lw_system *s = c->s;
    lw_motion_curve *curve = known->curve[below(r, known->n)];
    int *patch = c->ints, n = 1, most = 1 + below(r, 4);
    lw_motion_curve_posture(curve, lw_rng_range(r, 0.0, lw_motion_curve_segments(curve)), q, NULL);
    patch[0] = below(r, s->n_body);
    for (int draws = 0; n < most && draws < 20; draws++) {
        int b = patch[below(r, n)], first = c->joints.start[b], joints = c->joints.start[b + 1] - first;
        if (joints == 0)
            continue;
        int entry = c->joints.entry[first + below(r, joints)], other = s->joint[entry/2].body[1 - entry%2];
        bool fresh = other >= 0;
        for (int i = 0; i < n; i++)
            fresh = fresh && patch[i] != other;
        if (fresh)
            patch[n++] = other;
    }
    for (int i = 0; i < n; i++) {
        double *p = q + 3*patch[i], size = 2.0*body_size(c, patch[i]);
        p[0] += lw_rng_range(r, -size, size);
        p[1] += lw_rng_range(r, -size, size);
        p[2] = lw_rng_range(r, -LW_PI, LW_PI);
    }
}

static bool known(const lw_circuits *c, const double *q)
{
    for (int i = 0; i < c->n; i++)
        if (lw_motion_curve_holds(c->curve[i], q))
            return true;
    return false;
}

static lw_status add_curve(const lw_system *s, const lw_motion_curve_options *o, const double *q, lw_circuits *c, lw_error *e)
{
    lw_motion_curve *b;
    lw_status status = lw_motion_curve_create(s, q, o, &b, e);
    if (status != LW_OK)
        return status;
    lw_motion_curve **grown = lw_array_grow(c->curve, c->n, &c->capacity, sizeof *grown);
    if (!grown) {
        lw_motion_curve_free(b);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    c->since = 0;
    c->curve = grown;
    c->curve[c->n++] = b;
    return LW_OK;
}

static bool ended(const lw_motion_curve_options *o, lw_circuits *c)
{
    c->late = c->late || (o->until > 0 && lw_clock_wall() > o->until);
    return c->late || (o->stop && *o->stop);
}

/* Add the curves that cross those from number `first` on, and repeat for the new ones. */
static lw_status add_crossing(const lw_system *s, const lw_motion_curve_options *o, int first, double *q, lw_circuits *c, lw_error *e)
{
    lw_status status = LW_OK;
    for (int i = first; i < c->n && status != LW_E_MEMORY && !ended(o, c); i++) {
        int n;
        lw_motion_curve_events(c->curve[i], &n);
        for (int event = 0; event < n && status != LW_E_MEMORY && !ended(o, c); event++)
            if (lw_motion_curve_other(c->curve[i], event, q) && !known(c, q))
                status = add_curve(s, o, q, c, e);
    }
    return status == LW_E_MEMORY ? status : LW_OK;
}

lw_status lw_circuits_find(const lw_system *s, const double *q, const lw_motion_curve_options *o, int patience, uint64_t seed,
                           lw_circuits *c, lw_error *e)
{
    closer by;
    lw_rng r;
    memset(c, 0, sizeof *c);
    lw_status status = add_curve(s, o, q, c, e);
    if (status != LW_OK || patience == 0)
        return status;
    if (!make_closer(s, o->input, &by))
        status = lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_rng_seed(&r, seed, 0);
    if (status == LW_OK)
        status = add_crossing(s, o, 0, by.q, c, e);
    for (int wanted = patience; status == LW_OK && c->since < wanted && c->draws < 20*wanted && !ended(o, c);
         wanted = patience*(c->n < 16 ? 1 : c->n/16)) {
        if (by.sparse)
            draw_patch(&r, &by, c, by.q);
        else
            draw(&r, s, by.q);
        c->draws++;
        if (!close_up(&by, by.q, o->stop) || ended(o, c))
            continue;
        c->closed++;
        c->since++;
        if (known(c, by.q))
            continue;
        int first = c->n;
        status = add_curve(s, o, by.q, c, e) == LW_E_MEMORY ? LW_E_MEMORY : add_crossing(s, o, first, by.q, c, e);
    }
    free_closer(&by);
    if (status != LW_OK)
        lw_circuits_free(c);
    return status;
}

void lw_circuits_free(lw_circuits *c)
{
    for (int i = 0; i < c->n; i++)
        lw_motion_curve_free(c->curve[i]);
    free(c->curve);
    c->curve = NULL;
    c->n = c->capacity = 0;
}

/* mbs/constraints/circuits.c - circuits found from random postures. */
#include "mbs/constraints/circuits.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/rng.h"
#include "mbs/constraints/system_internal.h"

typedef struct closer {
    const lw_system *s;
    int     m, n, n_held, held[LW_INPUT_MAX];
    lw_rank rank;
    double *rest, *step, *store;
    int    *ints;
} closer;

static bool make_closer(const lw_system *s, int free_input, closer *c)
{
    memset(c, 0, sizeof *c);
    c->s = s;
    for (int i = 0; i < s->n_input; i++)
        if (i != free_input)
            c->held[c->n_held++] = i;
    c->n = s->n_q;
    c->m = s->n_row + c->n_held;
    c->store = malloc((lw_rank_doubles(c->m, c->n) + (size_t)(c->m + c->n))*sizeof *c->store);
    c->ints = malloc(lw_rank_ints(c->m, c->n)*sizeof *c->ints);
    if (!c->store || !c->ints)
        return false;
    c->rest = c->store;
    c->step = c->rest + c->m;
    lw_rank_place(&c->rank, c->m, c->n, c->step + c->n, c->ints);
    return true;
}

static void free_closer(closer *c)
{
    free(c->store);
    free(c->ints);
}

/* Residuals of rows and resting inputs at q; returns the largest. */
static double equations(closer *c, const double *q)
{
    lw_body_frame f[LW_LINK_MAX];
    double most = 0.0;
    lw_system_place(c->s, q, f);
    memset(c->rank.a, 0, (size_t)c->m*(size_t)c->n*sizeof *c->rank.a);
    lw_system_fill(c->s, f, c->rest, c->rank.a, 1, c->m);
    for (int i = 0; i < c->n_held; i++) {
        int r = c->s->n_row + i;
        c->rest[r] = lw_system_count(c->s, f, c->s->input_joint[c->held[i]], c->rank.a + r, c->m);
    }
    for (int r = 0; r < c->m; r++)
        most = fmax(most, fabs(c->rest[r]));
    return most;
}

/* Newton's method with least-norm steps, none longer than 1. */
static bool close_up(closer *c, double *q, const volatile sig_atomic_t *stop)
{
    for (int i = 0; i < 60 && !(stop && *stop); i++) {
        double most = equations(c, q), length = 0.0;
        if (most < 1e-14)
            return true;
        lw_rank_factor(&c->rank, 1e-10);
        lw_rank_solve(&c->rank, c->rest, c->step);
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

static bool known(const lw_circuits *c, const double *q)
{
    for (int i = 0; i < c->n; i++)
        if (lw_motion_curve_holds(c->curve[i], q))
            return true;
    return false;
}

/* Add a curve if there is room. */
static lw_status add_curve(const lw_system *s, const lw_motion_curve_options *o, const double *q, lw_circuits *c)
{
    lw_motion_curve *b;
    lw_status status = lw_motion_curve_create(s, q, o, &b, NULL);
    if (status != LW_OK)
        return status;
    c->since = 0;
    if (c->n < LW_CIRCUIT_MAX)
        c->curve[c->n++] = b;
    else {
        lw_motion_curve_free(b);
        c->full = true;
    }
    return LW_OK;
}

/* Add the curves that cross those from number `first` on, and repeat for the new ones. */
static lw_status add_crossing(const lw_system *s, const lw_motion_curve_options *o, int first, lw_circuits *c)
{
    double q[LW_SYSTEM_Q_MAX];
    lw_status status = LW_OK;
    for (int i = first; i < c->n && status != LW_E_MEMORY && status != LW_STOPPED; i++) {
        int n;
        lw_motion_curve_events(c->curve[i], &n);
        for (int event = 0; event < n && !c->full && status != LW_E_MEMORY && status != LW_STOPPED; event++)
            if (lw_motion_curve_other(c->curve[i], event, q) && !known(c, q))
                status = add_curve(s, o, q, c);
    }
    return status == LW_E_MEMORY ? status : LW_OK;
}

lw_status lw_circuits_find(const lw_system *s, const lw_motion_curve_options *o, int patience, uint64_t seed,
                           lw_circuits *c, lw_error *e)
{
    const volatile sig_atomic_t *stop = o->stop;
    closer by;
    lw_rng r;
    double q[LW_SYSTEM_Q_MAX];
    memset(c, 0, sizeof *c);
    lw_status status = lw_motion_curve_create(s, NULL, o, &c->curve[0], e);
    if (status != LW_OK)
        return status;
    c->n = 1;
    if (!make_closer(s, o->input, &by))
        status = lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_rng_seed(&r, seed, 0);
    if (status == LW_OK)
        status = add_crossing(s, o, 0, c);
    while (status == LW_OK && !c->full && c->since < patience && c->draws < 20*patience && !(stop && *stop)) {
        draw(&r, s, q);
        c->draws++;
        if (!close_up(&by, q, stop) || (stop && *stop))
            continue;
        c->closed++;
        c->since++;
        if (known(c, q))
            continue;
        int first = c->n;
        if (add_curve(s, o, q, c) == LW_E_MEMORY || add_crossing(s, o, first, c) != LW_OK)
            status = lw_error_set(e, LW_E_MEMORY, "out of memory");
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
    c->n = 0;
}

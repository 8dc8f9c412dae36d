/* mbs/constraints/motion_curve_singular.c - the directions of the branches at a branch point.
 *
 * At a simple branch point the equations F lose one rank: the directions t, n span their null space, and psi F' = 0
 * for one psi.  The branches leave along v = a t + b n with psi F''[v, v] = 0 (Keller 1977; Allgower & Georg 1990,
 * section 8.1).  If t is one branch, the other is v = -(psi F''[n, n]/(2 psi F''[t, n])) t + n.  If neither is known,
 * t and n are any basis and the condition is a quadratic equation for v. */
#include "mbs/constraints/motion_curve_internal.h"

#include <stdlib.h>
#include <string.h>

static const double step_off = 0.02;       /* step along the other branch: beyond rounding, short for its curvature */
static const double least_rank = 1e-8;     /* pivot that counts as lost rank, at branch points known to 1e-11 */
static const double least_bend = 1e-6;     /* psi F'' below this: branches touch, or more than two meet        */

/* psi F''[v, v]/2 at q */
static double bent(const lw_motion_curve *b, const double *q, const double *v, const double *psi, double *series, double *phi)
{
    double sum = 0.0, count[3];
    int n = b->n, rows = b->s->n_row;
    memset(series, 0, 3*(size_t)n*sizeof *series);
    memcpy(series, q, (size_t)n*sizeof *q);
    memcpy(series + n, v, (size_t)n*sizeof *v);
    lw_system_series(b->s, 2, series, phi);
    for (int r = 0; r < rows; r++)
        sum += psi[r]*phi[2*rows + r];
    for (int i = 0; i < b->f.n_held; i++) {
        lw_system_measure_series(b->s, b->s->input_joint[b->f.held[i]], 2, series, count);
        sum += psi[rows + i]*count[2];
    }
    return sum;
}

/* The data of a branch point: two directions, psi, and scratch memory for `bent`. */
typedef struct crossing { double *t, *n, *sum, *psi, *try, *row, *series, *phi, *store; } crossing;

/* Fill c at q; own: the direction of a known branch, or NULL.  False if the branch point is not simple.  Call
 * free_crossing in any case. */
static bool make_crossing(lw_motion_curve *b, const double *q, const double *own, crossing *c)
{
    int m = b->f.m - 1, n = b->n;
    c->store = calloc((size_t)m + 8*(size_t)n + 3*(size_t)b->s->n_row, sizeof *c->store);
    if (!c->store)
        return false;
    c->psi = c->store;
    c->t = c->psi + m;
    c->n = c->t + n;
    c->sum = c->n + n;
    c->try = c->sum + n;
    c->row = c->try + n;
    c->series = c->row + n;
    c->phi = c->series + 3*n;
    if (own)
        memcpy(c->t, own, (size_t)n*sizeof *own);
    else
        lw_continuation_null(&b->f, q, least_rank, 3, NULL, c->t);
    return lw_continuation_null(&b->f, q, least_rank, 3, c->t, c->n) == 2 && lw_continuation_left_null(&b->f, q, least_rank, c->psi) >= 1;
}

static void free_crossing(crossing *c) { free(c->store); }

/* psi F''/2 of (t, t) and of (n, n), and psi F'' of (t, n). */
static void form(const lw_motion_curve *b, const double *q, crossing *c, double *tt, double *nn, double *tn)
{
    for (int i = 0; i < b->n; i++)
        c->sum[i] = c->t[i] + c->n[i];
    *nn = bent(b, q, c->n, c->psi, c->series, c->phi);
    *tt = bent(b, q, c->t, c->psi, c->series, c->phi);
    *tn = bent(b, q, c->sum, c->psi, c->series, c->phi) - *nn - *tt;
}

/* out = x t + y n, of length 1 */
static void combine(const lw_motion_curve *b, const crossing *c, double x, double y, double *out)
{
    double length = 0.0;
    for (int i = 0; i < b->n; i++) {
        out[i] = x*c->t[i] + y*c->n[i];
        length += out[i]*out[i];
    }
    for (int i = 0; i < b->n; i++)
        out[i] /= sqrt(length);
}

/* out: the direction of the other branch at q, given the direction t of the first one. */
static bool other_direction(lw_motion_curve *b, const double *q, const double *t, double *out)
{
    crossing c;
    double tt, nn, tn = 0.0;
    bool simple = make_crossing(b, q, t, &c);
    if (simple) {
        form(b, q, &c, &tt, &nn, &tn);
        simple = fabs(tn) > least_bend;
        combine(b, &c, simple ? -nn/tn : 0.0, 1.0, out);
    }
    free_crossing(&c);
    return simple;
}

/* out: the direction of the branch at q on which the free input moves faster. */
static bool faster_direction(lw_motion_curve *b, const double *q, double *out)
{
    crossing c;
    double tt, nn, tn, fastest = -1.0;
    bool simple = make_crossing(b, q, NULL, &c);
    if (simple) {
        form(b, q, &c, &tt, &nn, &tn);
        double size = hypot(tt - nn, tn), middle = atan2(tn, tt - nn), off = -(tt + nn)/size;
        simple = size > least_bend && fabs(off) < 1.0;
        lw_system_measure(b->s, b->s->input_joint[b->input], q, c.row);
        for (int sign = -1; sign <= 1 && simple; sign += 2) {
            double angle = 0.5*(middle + sign*acos(off)), rate = 0.0;
            combine(b, &c, cos(angle), sin(angle), c.try);
            for (int i = 0; i < b->n; i++)
                rate += c.row[i]*c.try[i];
            if (fabs(rate) > fastest) {
                fastest = fabs(rate);
                memcpy(out, c.try, (size_t)b->n*sizeof *out);
            }
        }
    }
    free_crossing(&c);
    return simple;
}

/* q: a posture a short distance from branch point `at` along v. */
static bool step_from(lw_motion_curve *b, const double *at, const double *v, double *q)
{
    for (int i = 0; i < b->n; i++) {
        b->f.row[i] = v[i];
        b->f.origin[i] = at[i];
        q[i] = at[i] + step_off*v[i];
    }
    b->f.distance = step_off;
    b->f.kappa = 1.0/step_off;
    return lw_continuation_correct(&b->f, q) && lw_continuation_distance(&b->f, q, at) < 2.0*step_off;
}

bool lw_motion_curve_other(lw_motion_curve *b, int event, double *q)
{
    double *at = b->a, *t = b->b, *v = b->c;
    if (event < 0 || event >= b->n_event || b->event[event].kind != LW_EVENT_CROSSING)
        return false;
    lw_motion_curve_posture(b, b->event[event].station, at, t);
    return other_direction(b, at, t, v) && step_from(b, at, v, q);
}

bool lw_motion_curve_leave(lw_motion_curve *b, double *q)
{
    double *at = b->a, *v = b->b;
    memcpy(at, q, (size_t)b->n*sizeof *q);
    if (faster_direction(b, at, v) && step_from(b, at, v, q))
        return true;
    memcpy(q, at, (size_t)b->n*sizeof *q);
    return false;
}

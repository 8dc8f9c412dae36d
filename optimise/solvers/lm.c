#include "optimise/solvers/lm.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/vector.h"
#include "optimise/problem/constraint.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"
#include "optimise/problem/variable_projection.h"
#include "optimise/solvers/method_internal.h"
#include "optimise/solvers/qp.h"

static_assert((int)LW_QP_MAX >= (int)LW_VAR_MAX, "the quadratic program takes every variable");

#define DAMPING_FIRST  1e-3      /* of a run                                                                     */
#define DAMPING_LEAST  1e-14     /* below this a step is a Gauss-Newton step                                     */
#define DAMPING_RETRY  1e-12     /* least damping that grows after a step that failed                            */
#define DAMPING_MOST   1e12      /* with more, steps are below rounding: x no longer moves                       */
#define DIAGONAL_LEAST 1e-10     /* least diagonal of J'J in the damping, relative to the largest                */
#define RIDGE          1e-15     /* added to the diagonal, relative to the largest: keeps J'J positive definite  */
#define PROMISE_LEAST  1e-16     /* a smaller relative fall is rounding: the gradient is zero                    */
#define REASSIGN_GAIN  1e-7      /* least relative fall of f for which a new assignment of inputs is kept        */
#define MARGIN         1e-12     /* conditions may be violated by this much, which is rounding                   */
#define KEEP_OUT       1e-9      /* steps keep this distance from the limits of conditions on the motion         */
#define FAR            0.5       /* conditions with more room than this do not bind a step                      */
#define PROBE          0.1       /* part of a step after which its bend is measured                              */
#define BEND_MOST      0.75      /* longer steps than those whose acceleration is so many times half their length are not tried */
#define MEET           1e-9      /* results violate conditions on the motion by no more                          */

lw_lm_options lw_lm_options_default(void)
{
    return (lw_lm_options){ .max_steps = 300, .f_tol = 1e-10, .f_stop = 1e-30, .reassign = true };
}

/* Quadratic model of f for the step, over the free variables. */
typedef struct model {
    int    n, var[LW_QP_MAX];                       /* free variables                          */
    double g[LW_QP_MAX], step[LW_QP_MAX];           /* J'r                                     */
    int    m, m_linear;                             /* conditions on the step: a step >= b; less the motion's */
    double *a, *b;                                  /* (m*n), (m), in the scratch              */
    short  *first, *column;                         /* the same: nonzero coefficients of the first m_linear rows */
    double *h, *l, *work;                           /* the same: J'J (lower) and the damped factor (n*n), (2*n*n) */
} model;

/* sign step[i] >= .. */
static void bound_row(model *q, int i, double sign)
{
    double *a = q->a + q->m_linear++*q->n;
    memset(a, 0, sizeof *a*(size_t)q->n);
    a[i] = sign;
}

/* Choose the free variables; set the rows of bounds and linear conditions, which are the same for all steps. */
static void begin_model(const lw_problem *p, const lw_work *w, model *q)
{
    q->n = q->m_linear = 0;
    q->a = w->step_a;
    q->b = w->step_b;
    q->first = w->step_first;
    q->column = w->step_column;
    for (int i = 0; i < p->n_var; i++)
        if (p->lo[i] < p->hi[i])
            q->var[q->n++] = i;
    q->h = w->step_h;
    q->l = q->h + q->n*q->n;
    q->work = q->l + q->n*q->n;
    for (int i = 0; i < q->n; i++) {
        if (isfinite(p->lo[q->var[i]]))
            bound_row(q, i, 1);
        if (isfinite(p->hi[q->var[i]]))
            bound_row(q, i, -1);
    }
    for (int j = 0; j < p->n_linear; j++, q->m_linear++)
        for (int i = 0; i < q->n; i++)
            q->a[q->m_linear*q->n + i] = p->linear[j][q->var[i]];
    lw_qp_list(q->n, q->m_linear, q->a, q->first, q->column);
}

/* The limits of the bounds and linear conditions on a step from x. */
static void linear_limits(const lw_problem *p, const double *x, model *q)
{
    q->m = 0;
    for (int i = 0; i < q->n; i++) {
        int v = q->var[i];
        if (isfinite(p->lo[v]))
            q->b[q->m++] = p->lo[v] - x[v];
        if (isfinite(p->hi[v]))
            q->b[q->m++] = x[v] - p->hi[v];
    }
    for (int j = 0; j < p->n_linear; j++) {
        double now = 0;
        for (int v = 0; v < p->n_var; v++)
            now += p->linear[j][v]*x[v];
        q->b[q->m++] = LW_LINEAR_LEAST - now;
    }
}

static lw_qp_rows step_rows(const model *q) { return (lw_qp_rows){ q->m, q->a, q->b, q->m_linear, q->first, q->column }; }

/* Add the conditions on the motion to first order.  A violated one has to become better by `part` of its violation. */
static void motion_conditions(const lw_problem *p, const lw_work *w, double part, model *q)
{
    int m = (int)lw_problem_constraint_count(p);
    q->m = q->m_linear;
    for (int j = p->n_linear; j < m; j++) {
        const double *row = w->g_row + (size_t)j*(size_t)p->n_var;
        double room = w->g_now[j] - KEEP_OUT;
        if (room > FAR)
            continue;
        for (int i = 0; i < q->n; i++)
            q->a[q->m*q->n + i] = row[q->var[i]];
        q->b[q->m++] = room < 0 ? -part*room : -room;
    }
}

/* How much the conditions on the motion are violated, from their values g. */
static double violation(const lw_problem *p, const double *g)
{
    double worst = 0;
    for (size_t j = (size_t)p->n_linear, m = lw_problem_constraint_count(p); j < m; j++)
        worst = g[j] > -INFINITY ? fmax(worst, -g[j]) : INFINITY;
    return worst;
}

/* Compute J'J and J'r from the rows. */
static void normal_equations(const lw_problem *p, const lw_work *w, model *q)
{
    lw_normal in = { q->n, w->n_row, q->var, w->row, w->res, (size_t)p->n_var, w->ld };
    lw_batch_normal(&p->plan, &in, q->h, q->g);
}

/* Solve for the damped step. Returns the decrease of f that the model predicts; NaN: there is no step. */
static double solve_step(model *q, double damping)
{
    int n = q->n;
    double *l = q->l, most = 0, promise = 0;
    memcpy(l, q->h, sizeof(double)*(size_t)(n*n));
    for (int i = 0; i < n; i++)
        most = fmax(most, q->h[i*n + i]);
    for (int i = 0; i < n; i++)
        l[i*n + i] += damping*fmax(q->h[i*n + i], DIAGONAL_LEAST*most) + RIDGE*most + 1e-300;
    const lw_qp_rows rows = step_rows(q);
    if (!lw_qp_cholesky(n, l) || !lw_qp_solve(n, l, q->g, &rows, q->work, q->step))
        return NAN;
    for (int i = 0; i < n; i++) {
        double hs = 0;
        for (int j = 0; j < n; j++)
            hs += (j <= i ? q->h[i*n + j] : q->h[j*n + i])*q->step[j];
        promise -= q->step[i]*(2*q->g[i] + hs);
    }
    return promise;
}

/* Add to d what `step` takes from the input of each of n stations that are free. */
static void slide(const lw_work *w, const model *q, const double *step, size_t n, double *d)
{
    for (int i = 0; i < q->n; i++) {
        const double *by = w->slide + (size_t)q->var[i]*w->ld;
        for (size_t k = 0; k < n; k++)
            d[k] += by[k]*step[i];
    }
}

/* Move the inputs of free stations with the step, and by `more` (NULL: nothing). */
static void move_inputs(const lw_problem *p, lw_work *w, const model *q, const double *more)
{
    double *weight = w->try_theta, *d = w->pool;
    memcpy(d, w->slip, p->n*sizeof *d);
    slide(w, q, q->step, p->n, d);
    for (size_t k = 0; k < p->n; k++) {
        double move = lw_greater(-LW_TIMING_MOVE_MAX, lw_lesser(LW_TIMING_MOVE_MAX, d[k] - (more ? more[k] : 0)));
        weight[k] = 1;
        w->phase[k] -= w->tie[k] ? 0 : move;
    }
    if (p->timing == LW_TIMING_FREE)
        lw_timing_order(p, w->phase, weight, w->pool);
}

/* f at x; residuals and Jacobian stay in w. */
static double evaluate(const lw_problem *p, const double *x, lw_work *w)
{
    if (p->timing == LW_TIMING_PRESCRIBED)
        lw_problem_prescribe(p, x, w);
    else if (!lw_problem_turn_stations(p, x, w))
        return INFINITY;
    if (!lw_problem_lanes(p, x, w))
        return INFINITY;
    if (p->timing == LW_TIMING_NONE)
        lw_timing_samples(p, w, w->jac.x + p->n, w->jac.y + p->n);
    return lw_problem_rows(p, x, w, false);
}

typedef struct run {
    const lw_problem    *p;
    const lw_lm_options *o;
    lw_work *w;
    model    q;
    double   f, damping, growth;
    bool     bend;                                   /* steps follow the bend of their way      */
    bool     conditioned;                            /* steps keep the conditions on the motion */
    bool     known;                                  /* which were worked out with the last step */
    bool     turning;                                /* the input turns fully at x              */
    int      strokes;                                /* of the circuit at x                     */
    double   broken, weight;                         /* their violation; its weight beside f    */
    int      steps, idle;
    long     evals;
} run;

/* Do the phases stand for the same inputs as at x?  Not where the input turns fully on one side of a change point only, or where strokes come or go. */
static bool same_circuit(const run *r)
{
    return r->p->timing == LW_TIMING_PRESCRIBED || (r->w->swing.turning == r->turning && r->w->swing.n == r->strokes);
}

/* f at a trial step.  Where phases stand for other inputs, the stations are assigned to the curve anew. */
static double evaluate_trial(run *r, const double *trial)
{
    const lw_problem *p = r->p;
    lw_work *w = r->w;
    double f = evaluate(p, trial, w);
    if (same_circuit(r) || !w->swing.closes)
        return f;
    memcpy(w->best_theta, w->keep_theta, p->n*sizeof *w->phase);       /* which refining the inputs writes to */
    bool closes = lw_problem_settle(p, trial, w);
    memcpy(w->keep_theta, w->best_theta, p->n*sizeof *w->phase);
    return closes ? evaluate(p, trial, w) : INFINITY;
}

static void clip(const lw_problem *p, double *x)
{
    for (int i = 0; i < p->n_var; i++)
        x[i] = fmin(fmax(x[i], p->lo[i]), p->hi[i]);
}

/* The fall that the model predicts of f + weight * violation.  The weight only grows: until a step that lowers the
 * violation by `part` lowers the sum, even where f rises. */
static double weigh_violation(run *r, double part, double promise)
{
    double better = part*r->broken;
    if (better > 0 && promise + 0.5*r->weight*better < 0)
        r->weight = -2*promise/better;
    return promise + r->weight*better;
}

/* Keep what bent steps from here need.  false: some stations have the same input and move together. */
static bool begin_bend(const lw_problem *p, lw_work *w)
{
    for (size_t k = 0; k < p->n; k++)
        if (lw_timing_joined(p, w, k))
            return false;
    memcpy(w->base_res, w->res, sizeof *w->res*(size_t)w->n_row*w->ld);
    return true;
}

/* The second derivatives r of the residuals along the step, inputs included, by a difference: how far along the tangents
 * they lead goes to along[], J'r of the rest to g.  false: the linkage does not close so near. */
static bool second_derivatives(run *r, const double *x, double *along, double *g)
{
    const lw_problem *p = r->p;
    lw_work *w = r->w;
    const model *q = &r->q;
    double trial[LW_VAR_MAX];
    memcpy(trial, x, sizeof trial[0]*(size_t)p->n_var);
    for (int i = 0; i < q->n; i++)
        trial[q->var[i]] += PROBE*q->step[i];
    memcpy(w->pool, w->slip, p->n*sizeof *w->pool);
    slide(w, q, q->step, p->n, w->pool);
    for (size_t k = 0; k < p->n; k++)
        w->phase[k] -= w->tie[k] ? 0 : PROBE*w->pool[k];
    r->evals++;
    if (!isfinite(evaluate(p, trial, w)) || !same_circuit(r))
        return false;
    memset(g, 0, sizeof *g*(size_t)q->n);
    for (size_t k = 0; k < p->n; k++) {
        double t2 = 0;
        along[k] = 0;
        for (int i = 0; i < w->n_row; i++) {
            size_t at = (size_t)i*w->ld + k;
            double t = w->tangent[at], rate = t != 0 ? -t*w->slip[k] : 0;
            for (int c = 0; c < q->n; c++)
                rate += w->row[((size_t)i*(size_t)p->n_var + (size_t)q->var[c])*w->ld + k]*q->step[c];
            w->res[at] = 2/PROBE*((w->res[at] - w->base_res[at])/PROBE - rate);
            along[k] += t*w->res[at];
            t2 += t*t;
        }
        along[k] /= t2 > 0 ? t2 : 1;
        for (int i = 0; i < w->n_row; i++) {
            double rest = w->res[(size_t)i*w->ld + k] - along[k]*w->tangent[(size_t)i*w->ld + k];
            for (int c = 0; c < q->n; c++)
                g[c] += w->row[((size_t)i*(size_t)p->n_var + (size_t)q->var[c])*w->ld + k]*rest;
        }
    }
    return true;
}

/* Half the geodesic acceleration of the step: of the variables to a, of the inputs to w->best_theta.  Returns the acceleration over
 * half the length of the step; 0: there is none, the step is straight. */
static double bend_of(run *r, const double *x, double *a)
{
    const lw_problem *p = r->p;
    lw_work *w = r->w;
    model *q = &r->q;
    double g[LW_QP_MAX], *more = w->best_theta, a2 = 0, step2 = 0;
    bool known = second_derivatives(r, x, more, g) && lw_qp_solve(q->n, q->l, g, NULL, q->work, a);
    memcpy(w->phase, w->keep_theta, p->n*sizeof *w->phase);
    for (int i = 0; i < q->n && known; i++) {
        a2 += q->h[i*q->n + i]*a[i]*a[i];
        step2 += q->h[i*q->n + i]*q->step[i]*q->step[i];
        a[i] *= 0.5;
    }
    for (size_t k = 0; k < p->n && known; k++)
        more[k] *= 0.5;
    if (known)
        slide(w, q, a, p->n, more);
    for (size_t k = 0; k < p->n && known; k++)
        more[k] = w->tie[k] ? 0 : -more[k];
    for (int j = 0; j < q->m && known; j++)
        known = lw_dot(q->n, q->a + j*q->n, q->step) + lw_dot(q->n, q->a + j*q->n, a) >= q->b[j];
    return known ? 2*sqrt(a2/step2) : 0;
}

/* The conditions of the trial become those of x.  Most trials are steps, so that their derivatives were worked out with them. */
static void take_conditions(lw_work *w)
{
    double *g = w->g_now, *row = w->g_row;
    w->g_now = w->g_try;
    w->g_row = w->g_try_row;
    w->g_try = g;
    w->g_try_row = row;
}

/* Try one step. LW_STOP_EVALS: a step was accepted; else the reason why none was. */
static lw_stop advance(run *r, double *x)
{
    const lw_problem *p = r->p;
    double *keep = r->w->keep_theta, trial[LW_VAR_MAX];
    double part = 1;
    lw_problem_rows(p, x, r->w, true);
    r->turning = r->w->swing.turning;
    r->strokes = r->w->swing.n;
    normal_equations(p, r->w, &r->q);
    linear_limits(p, x, &r->q);
    if (r->conditioned) {
        if (!r->known)
            lw_problem_conditions(p, x, true, FAR, r->w->g_now, r->w->g_row, r->w);
        r->broken = violation(p, r->w->g_now);
        motion_conditions(p, r->w, part, &r->q);
    }
    memcpy(keep, r->w->phase, p->n*sizeof *keep);
    const bool bends = r->bend && begin_bend(p, r->w);
    for (; r->steps < r->o->max_steps; r->steps++) {
        double promise = solve_step(&r->q, r->damping);
        for (int i = 0; r->conditioned && isnan(promise) && i < 6; i++) {       /* no step keeps them all so far */
            part = i < 5 ? 0.3*part : 0;
            motion_conditions(p, r->w, part, &r->q);
            promise = solve_step(&r->q, r->damping);
        }
        if (r->conditioned && !isnan(promise))
            promise = weigh_violation(r, part, promise);
        if (promise >= 0 && promise <= PROMISE_LEAST*r->f)
            return LW_STOP_GRADIENT;
        double half[LW_QP_MAX], bent = bends && promise >= 0 ? bend_of(r, x, half) : 0;
        if (bent > BEND_MOST)
            promise = NAN;
        memcpy(trial, x, sizeof trial[0]*(size_t)p->n_var);
        for (int i = 0; i < r->q.n; i++)
            trial[r->q.var[i]] += r->q.step[i] + (bent > 0 ? half[i] : 0);
        clip(p, trial);
        if (p->timing != LW_TIMING_PRESCRIBED)
            move_inputs(p, r->w, &r->q, bent > 0 ? r->w->best_theta : NULL);
        double f = !(promise >= 0) ? INFINITY : evaluate_trial(r, trial), broken = 0;
        r->evals++;
        if (r->conditioned && f < r->f + r->weight*r->broken) {      /* else the conditions cannot make it better */
            lw_problem_conditions(p, trial, true, FAR, r->w->g_try, r->w->g_try_row, r->w);
            broken = violation(p, r->w->g_try);
        }
        double fall = r->conditioned ? r->f - f + r->weight*(r->broken - broken) : r->f - f;
        if (fall > 0) {
            double gain = fall/promise;
            r->damping = fmax(DAMPING_LEAST, r->damping*fmax(0.1, 1 - pow(2*gain - 1, 3)));
            r->growth = 2;
            r->idle = fall < r->f*r->o->f_tol && broken <= MEET ? r->idle + 1 : 0;
            r->f = f;
            r->broken = broken;
            r->known = r->conditioned;
            if (r->known)
                take_conditions(r->w);
            r->steps++;
            memcpy(x, trial, sizeof trial[0]*(size_t)p->n_var);
            return r->idle >= 3 ? LW_STOP_F_TOL : LW_STOP_EVALS;
        }
        memcpy(r->w->phase, keep, p->n*sizeof *keep);
        r->damping = fmax(r->damping, DAMPING_RETRY)*r->growth;
        r->growth *= 2;
        if (r->conditioned && r->broken > 0)
            motion_conditions(p, r->w, part *= 0.5, &r->q);
        if (r->damping > DAMPING_MOST)
            return LW_STOP_X_TOL;
    }
    return LW_STOP_EVALS;
}

/* Was a stop requested from outside? */
static bool called_off(const run *r, lw_stop *why)
{
    if (r->o->interrupt && *r->o->interrupt)
        *why = LW_STOP_USER;
    else if (r->o->until > 0 && lw_clock_wall() > r->o->until)
        *why = LW_STOP_TIME;
    else
        return false;
    return true;
}

static lw_stop descend(run *r, double *x)
{
    lw_stop why;
    r->damping = DAMPING_FIRST;
    r->growth = 2;
    r->idle = 0;
    r->known = false;
    while (r->steps < r->o->max_steps) {
        lw_stop s = advance(r, x);
        if (r->o->improved)
            r->o->improved(r->o->context, r->evals, r->f);
        if (called_off(r, &why))
            return why;
        if (r->f <= r->o->f_stop)
            return LW_STOP_F_TARGET;
        if (s != LW_STOP_EVALS)
            return s;
        if (r->o->f_hopeless > 0 && r->steps > r->o->patience && r->f > r->o->f_hopeless)
            return LW_STOP_FAILED;
    }
    return LW_STOP_EVALS;
}

/* Assign the free stations to the curve again, and keep the assignment if f is lower. */
static bool reassigned(run *r, const double *x)
{
    double *inputs = r->w->best_theta, f = r->f;
    memcpy(inputs, r->w->phase, r->p->n*sizeof *inputs);
    if (lw_problem_settle(r->p, x, r->w))
        f = lw_problem_rows(r->p, x, r->w, false);
    r->evals++;
    if (f < r->f*(1 - REASSIGN_GAIN)) {
        r->f = f;
        return true;
    }
    memcpy(r->w->phase, inputs, r->p->n*sizeof *inputs);
    return false;
}

static double improve(const lw_problem *p, const lw_lm_options *o, double *x, bool keep_inputs, bool conditioned,
                      void *work, long *evals, lw_stop *stop)
{
    run r = { .p = p, .o = o, .w = work, .conditioned = conditioned, .evals = 1 };
    bool closes = true;
    begin_model(p, work, &r.q);
    if (!keep_inputs && p->timing != LW_TIMING_PRESCRIBED)
        closes = lw_problem_settle(p, x, r.w);
    r.f = closes ? evaluate(p, x, r.w) : INFINITY;
    *stop = LW_STOP_FAILED;
    if (isfinite(r.f)) {
        r.bend = o->bend && !conditioned && p->timing == LW_TIMING_FREE;
        *stop = descend(&r, x);
        if (r.bend) {                                    /* differences do not lead down to rounding */
            r.bend = false;
            *stop = r.f <= o->f_stop ? *stop : descend(&r, x);
        }
        bool again = o->reassign && p->timing != LW_TIMING_PRESCRIBED && *stop != LW_STOP_FAILED;
        for (int i = 0; i < 4 && again && r.steps < o->max_steps && reassigned(&r, x); i++)
            *stop = descend(&r, x);
    }
    *evals += r.evals;
    return r.f;
}

double lw_lm_improve(const lw_problem *p, const lw_lm_options *o, double *x, bool keep_inputs, void *work, long *evals, lw_stop *stop)
{
    return improve(p, o, x, keep_inputs, false, work, evals, stop);
}

bool lw_lm_feasible(const lw_problem *p, double *x, void *work)
{
    model q;
    begin_model(p, work, &q);
    clip(p, x);
    for (int j = 0, bad = 0; j < p->n_linear; j++) {
        double now = 0;
        for (int v = 0; v < p->n_var; v++)
            now += p->linear[j][v]*x[v];
        bad += now < LW_LINEAR_LEAST;
        if (j + 1 == p->n_linear && !bad)
            return true;
    }
    memset(q.l, 0, sizeof *q.l*(size_t)(q.n*q.n));
    for (int i = 0; i < q.n; i++) {
        q.l[i*q.n + i] = 1/fmax(0.1, fabs(x[q.var[i]]));
        q.g[i] = 0;
    }
    linear_limits(p, x, &q);
    const lw_qp_rows rows = step_rows(&q);
    if (p->n_linear && !lw_qp_solve(q.n, q.l, q.g, &rows, q.work, q.step))
        return false;
    for (int i = 0; p->n_linear && i < q.n; i++)
        x[q.var[i]] += q.step[i];
    clip(p, x);
    return true;
}

bool lw_lm_scatter(const lw_problem *p, double rise, double reach, const double *normal, double *x, void *work)
{
    lw_work *w = work;
    model q;
    if (!lw_problem_settle(p, x, w))
        return false;
    lw_problem_rows(p, x, w, true);
    begin_model(p, w, &q);
    normal_equations(p, w, &q);
    memcpy(q.l, q.h, sizeof(double)*(size_t)(q.n*q.n));
    for (int i = 0; i < q.n; i++) {
        double size = fmax(0.1, fabs(x[q.var[i]]));
        q.l[i*q.n + i] += rise/(size*size);
    }
    if (!lw_qp_cholesky(q.n, q.l))
        return false;
    for (int i = q.n - 1; i >= 0; i--) {                 /* the factor's transpose turns equal variances into these */
        q.step[i] = reach*sqrt(rise)*normal[i];
        for (int j = i + 1; j < q.n; j++)
            q.step[i] -= q.l[j*q.n + i]*q.step[j];
        q.step[i] /= q.l[i*q.n + i];
    }
    for (int i = 0; i < q.n; i++)
        x[q.var[i]] += q.step[i];
    return lw_lm_feasible(p, x, work);
}

double lw_lm_conditioned(const lw_problem *p, const lw_lm_options *o, double *x, void *work, long *evals, lw_stop *stop)
{
    double f = 0;
    if (!lw_problem_is_nonlinear(p) || !lw_problem_admissible(p, x, MEET, work)) {
        f = lw_lm_improve(p, o, x, false, work, evals, stop);
        if (!isfinite(f) || !lw_problem_is_nonlinear(p) || lw_problem_admissible(p, x, MARGIN, work))
            return f;
    }
    f = improve(p, o, x, false, true, work, evals, stop);
    return isfinite(f) && lw_problem_admissible(p, x, MEET, work) ? f : INFINITY;
}

/* ---- as a row of the table ------------------------------------------------------------------- */

typedef struct report { const lw_solver_options *o; double start; } report;

static void pass_on(void *context, long evals, double f)
{
    report *r = context;
    if (r->o->improved)
        r->o->improved(r->o->context, evals, lw_clock_wall() - r->start, f);
}

lw_status lw_lm_run(const lw_solver *self, const lw_problem *p, const lw_solver_options *o, double *x, lw_solver_result *r)
{
    (void)self;
    report told = { o, lw_clock_wall() };
    lw_lm_options lm = { .max_steps = (int)fmin(o->max_evals, 1e9), .f_tol = fmax(o->f_tol, 1e-15),
                         .f_stop = o->f_target, .reassign = true, .interrupt = o->interrupt,
                         .until = o->max_seconds > 0 ? told.start + o->max_seconds : 0,
                         .improved = pass_on, .context = &told };
    size_t size = (lw_problem_work_size(p) + 127) & ~(size_t)63;
    void *work = aligned_alloc(64, size);
    *r = (lw_solver_result){ .f = INFINITY, .stop = LW_STOP_FAILED };
    if (!work)
        return LW_E_MEMORY;
    double best[LW_VAR_MAX];
    memcpy(best, x, sizeof best[0]*(size_t)p->n_var);
    lw_problem_work_init(p, work);
    if (lw_lm_feasible(p, best, work))
        r->f = lw_lm_conditioned(p, &lm, best, work, &r->evals, &r->stop);
    free(work);
    if (!isfinite(r->f))
        return LW_NOTHING;
    memcpy(x, best, sizeof best[0]*(size_t)p->n_var);
    bool limited = r->stop == LW_STOP_EVALS || r->stop == LW_STOP_TIME || r->stop == LW_STOP_USER;
    return limited ? LW_STOPPED : LW_OK;
}

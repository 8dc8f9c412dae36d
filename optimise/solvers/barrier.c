/* optimise/solvers/barrier.c - see barrier.h. */
#include "optimise/solvers/barrier.h"

#include <string.h>
#include "base/real.h"
#include "optimise/solvers/feasible.h"

#define N_AGAIN     20           /* greatest number of runs of a method in a stage                */
#define PAYS        0.01         /* run again if the last run lowered F by this part of k, or of F if k is 0 */
#define N_STAGE     40
#define F_TOL       1e-4         /* a stage is solved to this part of its k                       */
#define EDGE        0.1          /* of the least g to be expected: k / (multipliers so far)       */
#define FIRST_STEP  0.1          /* variables are of order one                                    */
#define MIN_STEP    1e-7
#define WALL        1e3          /* above f of any useful linkage; times 1 + f(start)             */

/* k ln(1/g); below `edge` its second-order Taylor polynomial at the edge. */
static double term(double k, double g, double edge, double *slope)
{
    if (g >= edge) {
        *slope = -k/g;
        return -k*log(g);
    }
    double d = (g - edge)/edge;
    *slope = -k/edge*(1.0 - d);
    return -k*(log(edge) + d - 0.5*d*d);
}

static double least_condition(lw_record *r, const double *x)
{
    const double *g = lw_record_conditions(r, x, false);
    double least = INFINITY;
    for (size_t j = 0; j < r->fn->m; j++)
        least = g[j] >= least ? least : isnan(g[j]) ? -INFINITY : g[j];
    return least;
}

static double barrier(lw_record *r, double k, double edge, const double *x, double *grad)
{
    size_t n = r->fn->n, m = r->fn->m;
    if (k > 0.0 && !(edge > 0.0) && !(least_condition(r, x) > 0.0)) {
        lw_record_count(r);
        return INFINITY;
    }
    double f = lw_record_value(r, x, grad), slope;
    if (!(k > 0.0) || !isfinite(f))
        return f;
    const double *g = lw_record_conditions(r, x, grad != NULL);
    for (size_t j = 0; j < m; j++) {
        f += term(k, g[j], edge, &slope);
        for (size_t i = 0; grad && i < n; i++)
            grad[i] += slope*r->j[j*n + i];
    }
    return isfinite(f) ? f : INFINITY;
}

double lw_barrier_value(lw_record *r, double k, const double *x, double *grad)
{
    return barrier(r, k, 0.0, x, grad);
}

/* Value that replaces F outside. On entry grad holds the direction that lets the linkage close better; it is used if no
 * condition gives a better one. */
static double wall_value(lw_barrier_stage *s, const double *x, double *grad)
{
    size_t n = s->record->fn->n, m = s->record->fn->m;
    const double *g = lw_record_conditions(s->record, x, grad != NULL);
    double v = 0.0;
    for (size_t j = 0; j < m; j++)
        if (g[j] < 0.0)
            v += g[j]*g[j];
    if (grad && v > 0.0)
        memset(grad, 0, n*sizeof *grad);
    for (size_t i = 0; grad && i < n; i++) {
        for (size_t j = 0; j < m; j++)
            if (g[j] < 0.0)
                grad[i] += 2.0*g[j]*s->record->j[j*n + i];
        grad[i] = isfinite(grad[i]) ? s->wall*grad[i] : 0.0;
    }
    return s->wall*(1.0 + fmin(v, 1e6));
}

double lw_barrier_stage_value(lw_barrier_stage *s, const double *x, double *grad)
{
    size_t n = s->record->fn->n;
    if (grad)
        memset(grad, 0, n*sizeof *grad);
    if (!lw_finite(x, n)) {
        lw_record_count(s->record);
        return 1e6*s->wall;
    }
    if (lw_record_must_stop(s->record))
        return s->wall;
    double f = barrier(s->record, s->k, s->edge, x, grad);
    s->inside = isfinite(f) && (s->k > 0.0 ? least_condition(s->record, x) >= s->edge : s->record->fn->m == 0 || f == s->record->f);
    s->lowest = fmin(s->lowest, f);
    if (s->inside && f < s->best) {
        s->best = f;
        memcpy(s->x, x, n*sizeof *x);
    }
    return isfinite(f) ? f : wall_value(s, x, grad);
}

bool lw_barrier_stage_over(const lw_barrier_stage *s)
{
    return s->record->stopped || s->record->evals >= s->last_eval;
}

static lw_barrier_stage new_stage(lw_record *r, double k)
{
    return (lw_barrier_stage){
        .record = r, .k = k, .wall = WALL*(1.0 + (isfinite(r->f) ? fabs(r->f) : 0.0)),
        .f_tol = r->o->f_tol, .step = FIRST_STEP, .last_eval = r->limit, .best = INFINITY, .lowest = INFINITY
    };
}

/* Is F lower below the edge than inside? Then the edge is too far inside: move it towards g = 0. */
static bool draw_back_edge(lw_barrier_stage *s)
{
    bool drawn = s->edge > 0.0 && s->lowest < s->best - PAYS*s->k;
    if (drawn)
        s->edge *= EDGE;
    s->lowest = s->best;
    return drawn;
}

/* Run the method in the stage; put the stage's best point into x. */
static lw_stop run_stage(lw_barrier_stage *s, lw_minimise *method, bool again, double *x)
{
    lw_stop why = LW_STOP_FAILED;
    for (int k = 0; k < N_AGAIN && !lw_barrier_stage_over(s); k++) {
        double before = s->best;
        why = method(s, x);
        if (isfinite(s->best))
            memcpy(x, s->x, s->record->fn->n*sizeof *x);
        bool paid = before - s->best > PAYS*(s->k > 0.0 ? s->k : fabs(s->best));
        if (!again || !(draw_back_edge(s) || paid))
            break;
    }
    return why;
}

lw_stop lw_single_run(lw_record *r, lw_minimise *method, double k, bool again, double *x)
{
    lw_barrier_stage s = new_stage(r, k);
    s.edge = EDGE*k;                                  /* for multipliers of order one */
    return run_stage(&s, method, again, x);
}

/* Replace x by `other` if F of this stage is lower there. */
static double take_lower(lw_barrier_stage *s, double here, const double *other, double *x)
{
    double f = lw_barrier_value(s->record, s->k, other, NULL);
    if (!(f < here))
        return here;
    memcpy(x, other, s->record->fn->n*sizeof *x);
    return f;
}

/* Choose where a stage starts: at the end x of the stage before; or at the next optimum, extrapolated from the last
 * two, since the path x(k) is nearly straight at its end (Fiacco & McCormick 1968); or at the best point so far, which
 * a stage with too large a k may have left. Returns the expected distance to go. */
static double choose_start(lw_barrier_stage *s, const double *older, double k_older, double k, double *x)
{
    size_t n = s->record->fn->n;
    double guess[LW_VAR_MAX], way = FIRST_STEP, here = lw_barrier_value(s->record, s->k, x, NULL);
    if (k_older > k) {
        double t = (k - s->k)/(k_older - k);
        way = 0.0;
        for (size_t i = 0; i < n; i++) {
            guess[i] = x[i] + t*(x[i] - older[i]);
            way = fmax(way, fabs(guess[i] - x[i]));
        }
        lw_clip(s->record->fn, guess);
        here = take_lower(s, here, guess, x);
    }
    take_lower(s, here, s->record->x, x);
    return fmin(fmax(way, MIN_STEP), FIRST_STEP);
}

/* Number of stages from k to the last k, which is barrier_last times the best f: as given by barrier_ratio, and one
 * more each time f has fallen so far that the last k has moved. */
static int stages_left(const lw_record *r, double k, int planned)
{
    if (k <= r->o->barrier_last*r->f*(1.0 + 1e-9))
        return 0;
    return planned > 1 ? planned : 1;
}

lw_stop lw_barrier_run(lw_record *r, lw_minimise *method, double *x)
{
    const lw_solver_options *o = r->o;
    lw_stop why = LW_STOP_FAILED;
    double older[LW_VAR_MAX], end[LW_VAR_MAX], k_older = 0.0, k_end = 0.0;
    if (!lw_feasible_start(r, x) || !isfinite(lw_record_value(r, x, NULL)))
        return why;
    int planned = (int)ceil(log(o->barrier_last/o->barrier_first)/log(o->barrier_ratio) - 1e-9);
    double k = o->barrier_first*r->f;
    for (int done = 0; done < N_STAGE && !r->stopped; done++) {
        int left = stages_left(r, k, planned - done);
        lw_barrier_stage s = new_stage(r, k);
        if (left > 0) {                               /* an equal part of the remaining evaluations */
            s.f_tol = fmax(o->f_tol, F_TOL*k/r->f);
            s.last_eval = r->evals + (r->limit - r->evals)/(left + 1) + 1;
        }
        memcpy(end, x, r->fn->n*sizeof *x);
        s.step = choose_start(&s, older, k_older, k_end, x);
        s.edge = EDGE*least_condition(r, x)*(k_end > 0.0 ? k/k_end : 1.0);
        memcpy(older, end, r->fn->n*sizeof *x);
        k_older = k_end;
        k_end = k;
        why = run_stage(&s, method, true, x);
        left = stages_left(r, k, planned - done);
        if (left == 0)
            break;
        k *= fmin(pow(o->barrier_last*r->f/k, 1.0/left), o->barrier_ratio);
    }
    return why;
}

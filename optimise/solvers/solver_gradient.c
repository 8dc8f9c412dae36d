/* optimise/solvers/solver_gradient.c - the gradient method of the source,
 *
 *     x_{i+1} = x_i - k grad F(x_i)                                   (Makkonen 1999, eq. 20)
 *
 * once with a line search and once literally. */
#include <string.h>
#include "base/real.h"
#include "optimise/solvers/method_internal.h"

/* ---- with line search: spectral projected gradient (Birgin, Martinez & Raydan 2000, SPG2) ----
 *
 * k is the step of Barzilai & Borwein 1988 from the last two gradients. The point is projected on the bounds, and the
 * step is shortened until F falls below the largest of its last MEMORY values (Armijo's condition in the form of
 * Grippo, Lampariello & Lucidi 1986). */
#define MEMORY     10
#define PATIENCE   20            /* iterations without a new lowest F                             */
#define ARMIJO     1e-4
#define K_MIN      1e-15
#define K_MAX      1e15

typedef struct descent {
    lw_barrier_stage *stage;
    size_t    n;
    double    f, x[LW_VAR_MAX], g[LW_VAR_MAX];       /* current point                             */
    double    d[LW_VAR_MAX];                         /* step to the projected gradient point      */
    double    slope;                                 /* g . d                                     */
    double    trial[LW_VAR_MAX], gt[LW_VAR_MAX];
    double    past[MEMORY];
} descent;

/* d = P(x - k g) - x. Returns its largest component. */
static double direction(descent *s, double k)
{
    const lw_function *fn = s->stage->record->fn;
    double largest = 0.0;
    s->slope = 0.0;
    for (size_t i = 0; i < s->n; i++) {
        s->d[i] = fmin(fmax(s->x[i] - k*s->g[i], fn->lo[i]), fn->hi[i]) - s->x[i];
        s->slope += s->g[i]*s->d[i];
        largest = fmax(largest, fabs(s->d[i]));
    }
    return largest;
}

/* Armijo search along d. True: the new point is in trial, gt and *f. */
static bool line_search(descent *s, double *f)
{
    double reference = s->past[0], t = 1.0;
    for (int i = 1; i < MEMORY; i++)
        reference = fmax(reference, s->past[i]);
    for (int k = 0; k < 60 && !lw_barrier_stage_over(s->stage); k++) {
        for (size_t i = 0; i < s->n; i++)
            s->trial[i] = s->x[i] + t*s->d[i];
        lw_clip(s->stage->record->fn, s->trial);
        *f = lw_barrier_stage_value(s->stage, s->trial, s->gt);
        if (*f <= reference + ARMIJO*t*s->slope)
            return true;
        double best = -0.5*t*t*s->slope/(*f - s->f - t*s->slope);      /* minimum of the parabola */
        t = best >= 0.1*t && best <= 0.9*t ? best : 0.5*t;
    }
    return false;
}

/* Move to the trial point. Returns the step of Barzilai & Borwein for the next iteration. */
static double accept(descent *s, double f, int iteration)
{
    double ss = 0.0, sy = 0.0;
    for (size_t i = 0; i < s->n; i++) {
        double dx = s->trial[i] - s->x[i], dg = s->gt[i] - s->g[i];
        ss += dx*dx;
        sy += dx*dg;
    }
    s->f = s->past[iteration%MEMORY] = f;
    memcpy(s->x, s->trial, s->n*sizeof *s->x);
    memcpy(s->g, s->gt, s->n*sizeof *s->g);
    return sy > 0.0 ? fmin(fmax(ss/sy, K_MIN), K_MAX) : K_MAX;
}

static lw_stop descend(descent *s)
{
    double lowest = s->f, k = 1.0/fmax(direction(s, 1.0), 1e-12);
    for (int i = 1, last = 0; ; i++) {
        if (lw_barrier_stage_over(s->stage))
            return LW_STOP_EVALS;
        if (direction(s, 1.0) <= 1e-16*fmax(1.0, fabs(s->f)))
            return LW_STOP_GRADIENT;
        double f, move = direction(s, k);
        if (move > 1.0)                               /* no variable moves by more than one */
            direction(s, k/move);
        if (!line_search(s, &f))
            return lw_barrier_stage_over(s->stage) ? LW_STOP_EVALS : LW_STOP_X_TOL;
        k = accept(s, f, i);
        if (f < lowest - s->stage->f_tol*fabs(lowest)) {
            lowest = f;
            last = i;
        } else if (i - last > PATIENCE)
            return LW_STOP_F_TOL;
    }
}

lw_stop lw_gradient(lw_barrier_stage *stage, const double *start)
{
    descent s = { .stage = stage, .n = stage->record->fn->n };
    memcpy(s.x, start, s.n*sizeof *s.x);
    lw_clip(stage->record->fn, s.x);
    s.f = lw_barrier_stage_value(stage, s.x, s.g);
    for (int i = 0; i < MEMORY; i++)
        s.past[i] = s.f;
    return descend(&s);
}

/* ---- literally: k is a number that the user chose ----
 *
 * Only the bounds are checked. If k is too large, x oscillates or leaves the set where F is defined, which ends the run
 * as failed. If k is too small, progress is very slow. */
lw_stop lw_gradient_fixed(lw_barrier_stage *stage, const double *start)
{
    const lw_function *fn = stage->record->fn;
    double x[LW_VAR_MAX], g[LW_VAR_MAX], f, before = INFINITY;
    memcpy(x, start, fn->n*sizeof *x);
    lw_clip(fn, x);
    while (f = lw_barrier_stage_value(stage, x, g), !lw_barrier_stage_over(stage)) {
        if (!stage->inside)
            return LW_STOP_FAILED;
        if (fabs(before - f) <= stage->f_tol*fabs(f))
            return LW_STOP_F_TOL;
        before = f;
        for (size_t i = 0; i < fn->n; i++)
            x[i] -= stage->record->o->step*g[i];
        lw_clip(fn, x);
    }
    return LW_STOP_EVALS;
}

/* optimise/circuit.c - the way of the input: round and round, or from limit to limit and back in the
 * other assembly mode, by one phase that runs smoothly through the limits.  Where the ends of the
 * range are no limits (slides become parallel) it goes to and fro in one mode. */
#include <string.h>

#include "mbs/motion.h"
#include "optimise/family.h"
#include "optimise/problem_internal.h"

bool lw_circuit_find(const lw_problem *p, const double *x, lw_work *w)
{
    lw_range r;
    w->turning = true;
    if (p->branch.turns)
        return true;
    if (p->family->linkage) {                              /* a slider's way scales with the linkage */
        int size = p->plan.input_is_slider ? lw_problem_first_length(p) : -1;
        w->turning = w->flips = false;
        w->mid = p->branch.mid*(size >= 0 ? x[size] : 1);
        w->half = p->branch.half*(size >= 0 ? x[size] : 1);
        return w->half > 0;
    }
    if (lw_motion_range(&p->plan, x, p->branch.mode[0], &r) != LW_OK)
        return false;
    w->turning = r.turns;
    w->flips = r.limits;
    w->mid = 0.5*(r.first + r.last);
    w->half = 0.5*(r.last - r.first);
    return w->turning || w->half > 0;
}

void lw_circuit_slopes(const lw_problem *p, const double *x, lw_work *w)
{
    double at[LW_VAR_MAX], mid[2], half[2];
    memset(w->mid_by, 0, sizeof w->mid_by);
    memset(w->half_by, 0, sizeof w->half_by);
    if (w->turning)
        return;
    if (p->family->linkage) {
        int size = p->plan.input_is_slider ? lw_problem_first_length(p) : -1;
        if (size >= 0) {
            w->mid_by[size] = p->branch.mid;
            w->half_by[size] = p->branch.half;
        }
        return;
    }
    memcpy(at, x, sizeof at[0]*(size_t)p->n_var);
    for (int k = 0; p->family->shape[k]; k++) {            /* limits depend on the shape only        */
        int d = lw_plan_dim(&p->plan, p->family->shape[k]);
        double h = 1e-6*fmax(1, fabs(x[d]));
        bool there = true;
        for (int side = 0; side < 2; side++) {
            at[d] = side ? x[d] + h : x[d] - h;
            there &= lw_circuit_find(p, at, w) && !w->turning;
            mid[side] = w->mid;
            half[side] = w->half;
        }
        at[d] = x[d];
        w->mid_by[d] = there ? (mid[1] - mid[0])/(2*h) : 0;
        w->half_by[d] = there ? (half[1] - half[0])/(2*h) : 0;
    }
    lw_circuit_find(p, x, w);
}

static void place(const lw_problem *p, double input, double *c, double *s)
{
    *c = p->plan.input_is_slider ? input : cos(input);
    *s = p->plan.input_is_slider ? 0 : sin(input);
}

void lw_circuit_inputs(const lw_problem *p, const lw_work *w, size_t n, const double *phase,
                       double *c, double *s, double *mode, double *input, double *rate)
{
    for (size_t k = 0; k < n; k++) {
        double cosine = cos(phase[k]), sine = sin(phase[k]);
        double at = w->turning ? phase[k] : w->mid - w->half*cosine;
        if (w->turning) {
            c[k] = cosine;
            s[k] = sine;
        } else
            place(p, at, &c[k], &s[k]);
        mode[k] = w->turning || !w->flips ? p->branch.mode[0] : sine < 0 ? -1 : 1;
        if (input)
            input[k] = at;
        if (rate)
            rate[k] = w->turning ? 1 : w->half*sine;
    }
}

void lw_circuit_modes(const lw_problem *p, const lw_work *w, lw_lanes *in)
{
    if (!lw_problem_has_modes(p))
        return;
    in->mode = w->mode;
    in->mode_stride = w->ld;
}

/* optimise/circuit.c - the way of the input: round and round, or from limit to limit and back in the
 * other assembly mode, by one phase that runs smoothly through the limits. */
#include "mbs/motion.h"
#include "optimise/problem_internal.h"

bool lw_circuit_find(const lw_problem *p, const double *x, lw_work *w)
{
    double first, last;
    w->turning = true;
    if (p->turns)
        return true;
    if (lw_motion_range(&p->plan, x, p->mode[0], &first, &last, &w->turning) != LW_OK)
        return false;
    w->mid = 0.5*(first + last);
    w->half = 0.5*(last - first);
    return w->turning || w->half > 0;
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
        mode[k] = w->turning ? p->mode[0] : sine < 0 ? -1 : 1;
        if (input)
            input[k] = at;
        if (rate)
            rate[k] = w->turning ? 1 : w->half*sine;
    }
}

void lw_circuit_modes(const lw_problem *p, const lw_work *w, lw_lanes *in)
{
    if (p->turns || p->timing == LW_TIMING_PRESCRIBED)
        return;
    in->mode = w->mode;
    in->mode_stride = w->ld;
}

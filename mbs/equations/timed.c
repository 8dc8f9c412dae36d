/* mbs/equations/timed.c - kinks and pulses of all functions of time of a model. */
#include "mbs/equations/timed.h"

#include <float.h>
#include "base/real.h"
#include "grammar/model/model.h"

/* Ends of calm intervals are free to move by this part of the interval: no step is as short as rounding. */
static const double part = 1e-9;

/* Loads are not evaluated so near to a kink, because its time is rounded. */
static double beside(double kink) { return 8*DBL_EPSILON*fmax(fabs(kink), 1e-3); }

typedef struct search { double from, t, end, found; } search;

static void find_kink(void *context, const lw_expression *x)
{
    search *s = context;
    s->found = x ? fmin(s->found, lw_expression_next_kink(x, lw_variable(LW_QUANTITY_T, 0), s->t, fmin(s->end, s->found))) : s->found;
}

static void find_calm(void *context, const lw_expression *x)
{
    search *s = context;
    if (x)
        s->found = fmin(s->found, lw_expression_calm(x, lw_variable(LW_QUANTITY_T, 0), false, s->from, s->t, s->found, 1e-9*(s->found - s->from)));
}

typedef struct count { bool jumps; int n; } count;

static void count_breaks(void *context, const lw_expression *x)
{
    count *c = context;
    c->n += x ? lw_expression_breaks(x, lw_variable(LW_QUANTITY_T, 0), c->jumps, NULL, NULL) : 0;
}

/* Where the sides of kinks, of jumps are written next. */
typedef struct sides { double *next[2]; } sides;

static void note_sides(void *context, const lw_expression *x, const double *v)
{
    sides *to = context;
    for (int jumps = 0; jumps < 2; jumps++)
        to->next[jumps] += lw_expression_breaks(x, lw_variable(LW_QUANTITY_T, 0), jumps, v, to->next[jumps]);
}

void lw_timed_sides(lw_timed_values *values, void *context, double t, const double *q, const double *v, double *force, double *kink, double *jump)
{
    sides to = { { kink, jump } };
    values(context, t, q, v, force, note_sides, &to);
}

int lw_timed_breaks(const lw_timed *w, bool jumps)
{
    count c = { jumps, 0 };
    if (w->expressions)
        w->expressions(w->context, count_breaks, &c);
    return c.n;
}

double lw_timed_next_kink(const lw_timed *w, double t, double end)
{
    search s = { w->from, t, end, INFINITY };
    if (w->expressions)
        w->expressions(w->context, find_kink, &s);
    return s.found;
}

double lw_timed_begin(const lw_timed *w)
{
    double behind = w->from + beside(w->from);
    return lw_timed_next_kink(w, w->from - beside(w->from), behind) <= behind ? fmin(behind, w->to) : w->from;
}

double lw_timed_end(lw_timed *w, double t)
{
    if (!w->expressions)
        return w->to;
    while (w->kink - beside(w->kink) <= t)
        w->kink = lw_timed_next_kink(w, fmax(t, w->kink) + 2*beside(fmax(fabs(t), fabs(w->kink))), w->to);
    double end = fmin(w->to, w->kink - beside(w->kink));
    if (w->calm - t <= part*LW_CALM_SAMPLES*w->spacing) {
        search s = { w->from, t, end, end };
        w->expressions(w->context, find_calm, &s);
        w->calm = end - s.found <= part*(end - t) ? end : s.found;
        w->spacing = (w->calm - t)/LW_CALM_SAMPLES;
    }
    return fmin(end, w->calm);
}

double lw_timed_near(lw_timed *w, double t)
{
    double end = lw_timed_end(w, t);
    return !w->expressions || end - t < 1.5*w->spacing ? end : t + w->spacing;
}

bool lw_timed_at_kink(const lw_timed *w, double t)
{
    return w->expressions && t >= w->kink - beside(w->kink) && t < w->to;
}

double lw_timed_behind(const lw_timed *w) { return fmin(w->kink + beside(w->kink), w->to); }

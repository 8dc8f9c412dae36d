/* mbs/formulations/input_panel.c - what lies within a panel: times, turns and states. */
#include "base/real.h"
#include "mbs/formulations/input_panel_internal.h"

#include <stdlib.h>

enum { N = LW_PANEL_NODES };

lw_status lw_input_panel_rule(lw_dynamics *d)
{
    if (d->rule)
        return LW_OK;
    d->rule = malloc(sizeof *d->rule);
    if (d->rule && lw_panel_rule_make(d->rule) == LW_OK)
        return LW_OK;
    free(d->rule);
    d->rule = NULL;
    return LW_E_MEMORY;
}

void lw_input_panel_note_rates(lw_input_panel *p, const lw_reduced *r, int i)
{
    for (int b = 0; b < r->dynamics->s.n_body; b++)
        p->rate[i][b] = r->reg[r->centre[b].dir].d.x;
}

static void prepare(lw_input_panel *p, int n_body)
{
    double m[N];
    lw_panel_apply(&p->rule->coef, p->pace, p->pace_c);
    lw_panel_apply(p->turning ? &p->rule->root : &p->rule->mean, p->pace, m);
    lw_panel_apply(&p->rule->coef, m, p->time_c);
    lw_panel_apply(&p->rule->mean, p->force, m);
    lw_panel_apply(&p->rule->coef, m, p->force_c);
    lw_panel_apply(&p->rule->mean, p->other, m);
    lw_panel_apply(&p->rule->coef, m, p->other_c);
    for (int b = 0; b < n_body; b++) {
        double most = 0;
        for (int i = 0; i < N; i++)
            most = fmax(most, fabs(p->rate[i][b]));
        p->still[b] = p->length*most < 1;
    }
    p->ready = true;
}

/* Time since x = 0 as a function of x (turning: of u), and its slope */
static double time_at(const lw_input_panel *p, double x, double *slope)
{
    double v = p->turning ? x*x : x, by = p->turning ? 1 : p->length;
    *slope = by*lw_panel_value(p->pace_c, v);
    return by*x*lw_panel_value(p->time_c, v);
}

/* x (turning: u) at a time, by Newton's method within a bracket */
static double place_at(const lw_input_panel *p, double t)
{
    double slope, low = p->turning ? p->begin : 0, high = 1, zero = time_at(p, low, &slope);
    double fraction = (t - p->t)/(p->t_end - p->t), x = low + (high - low)*fraction;
    for (int k = 0; k < 60; k++) {
        double off = time_at(p, x, &slope) - zero - (t - p->t), next;
        *(off > 0 ? &high : &low) = x;
        next = x - off/slope;
        if (fabs(next - x) <= 1e-9)          /* the step after it would be of the size of its square */
            return fmin(fmax(next, low), high);
        next = next > low && next < high ? next : 0.5*(low + high);
        if (fabs(next - x) <= 2e-15)
            return next;
        x = next;
    }
    return x;
}

double lw_input_panel_turned(const lw_input_panel *p, int b, double v)
{
    const lw_panel_rule *rule = p->rule;
    double rate[N], from = 0;
    int i = 0;
    for (int k = 0; k < N; k++)
        rate[k] = p->rate[k][b];
    while (i < N - 1 && rule->at[i + 1] <= v)
        i++;
    double sum = rule->at[i]*lw_panel_sum(rule->mean.row[i], rate) + (v - rule->at[i])*rate[i];
    if (p->turning && p->begin < 0)
        from = lw_panel_sum(rule->whole, rate);
    return (p->turning ? -1 : 1)*p->sense*p->length*(sum - from);
}

double lw_input_panel_work(lw_input_panel *p, const lw_reduced *r, double v)
{
    if (v == 0)
        return 0;
    if (!p->ready)
        prepare(p, r->dynamics->s.n_body);
    return v*lw_panel_value(p->other_c, v);
}

lw_status lw_input_panel_state(lw_input_panel *p, lw_run *run, lw_reduced *r, double t, const double *turns, int stride, double *y)
{
    const lw_dynamics *d = run->d;
    if (!p->ready)
        prepare(p, d->s.n_body);
    double x = place_at(p, t), v = p->turning ? x*x : x, along = (p->turning ? -p->sense : p->sense)*p->length, mass;
    double kinetic = (p->turning ? 0 : p->kinetic) + along*v*lw_panel_value(p->force_c, v);
    double speed = (p->turning && x > 0 ? -p->sense : p->sense)*sqrt(fmax(2*kinetic, 0));
    lw_status st = lw_reduced_mass(r, p->from + along*v, &mass);
    if (st != LW_OK)
        return st;
    for (int b = 0; b < d->s.n_body; b++)
        y[3*b + 2] = turns[stride*b] + (p->still[b] ? 0 : lw_input_panel_turned(p, b, v));
    lw_reduced_state(r, d, speed/sqrt(mass), y, y + d->n_q);
    if (run->has_work)
        y[2*d->n_q] = p->work + along*(lw_input_panel_work(p, r, v) - lw_input_panel_work(p, r, p->begin*p->begin));
    return LW_OK;
}

/* mbs/reduced/steps.c - the steps of the plan with derivatives by the input; change points. */
#include "base/real.h"
#include "mbs/reduced/reduced_internal.h"

static const double closed = 1e-12;          /* a margin below this: a dead point */

/* ---- across a change point ------------------------------------------------------------------------ */

static lw_reg1 bridged(const double *c, double x, double reach)
{
    double v = 0, d = 0;
    for (int k = LW_BRIDGE_SIZE - 1; k >= 0; k--) {
        d = d*x + v;
        v = v*x + c[k];
    }
    return lw_rate_direction(lw_v2_polar(1, v), d/reach);
}

static void bridge_step(const lw_dyad_step *st, const lw_change_point *t, const lw_bridge *b, double input, lw_reg1 *reg)
{
    double x = (input - t->at)/t->reach;
    reg[st->out[0]] = bridged(b->c[0], x, t->reach);
    if (st->kind == LW_STEP_RRR) {
        if (st->out[1] >= 0)
            reg[st->out[1]] = bridged(b->c[1], x, t->reach);
        reg[st->out[2]] = lw_rate_arm_end(&reg[st->in[0]], &reg[st->out[0]], st->r1);
    } else if (st->kind == LW_STEP_RRP) {
        reg[st->out[1]] = lw_rate_arm_end(&reg[st->in[0]], &reg[st->out[0]], st->r1);
    }
}

/* ---- all steps ------------------------------------------------------------------------------------- */

static const lw_bridge *bridge_of(const lw_change_point *t, const lw_dyad_step *st)
{
    for (int i = 0; t && i < t->n_bridge; i++)
        if (st->kind >= LW_STEP_RRR && t->bridge[i].dyad == st->dyad)
            return &t->bridge[i];
    return NULL;
}

/* Square of the way of a slide from where it is at right angles to the line between its pins, over the size: without an eccentricity the
 * assembly modes meet where the pins do, which the margin of the dyad does not show. */
static double slid(const lw_reduced *r, const lw_dyad_step *st)
{
    lw_vec2 span = lw_v2_sub(r->reg[st->in[1]].p, r->reg[st->in[0]].p);
    double unit = r->dynamics->s.unit;
    return (lw_v2_dot(span, span) - st->r1*st->r1)/(unit*unit);
}

void lw_reduced_plain(lw_reduced *r, const double *mode, const lw_change_point *bridge, double input, double *margin_of, double *margin)
{
    lw_reg1 *reg = r->reg;
    *margin = 1;
    r->known = NAN;
    for (int i = 0; i < r->n_step; i++) {
        const lw_dyad_step *st = &r->step[i];
        const lw_bridge *b = bridge ? bridge_of(bridge, st) : NULL;
        double m = 1;
        if (b)
            bridge_step(st, bridge, b, input, reg);
        else
            m = lw_step_rates(st, mode, input, reg);
        *margin = m < *margin ? m : *margin;
        if (margin_of && st->kind >= LW_STEP_RRR)
            margin_of[st->dyad] = st->kind == LW_STEP_RPR ? slid(r, st) : m;
    }
}

/* Index of the piece that holds an input; *input is moved into the range scanned. */
static int find_piece(const lw_reduced *r, double *input, const lw_change_point **near)
{
    *near = NULL;
    if (r->period > 0)
        *input -= r->period*floor((*input - r->low)/r->period);
    int i = 0;
    while (i < r->n_change && *input >= r->change[i].at)
        i++;
    for (int k = i - 1; k <= i; k++)
        if (k >= 0 && k < r->n_change && fabs(*input - r->change[k].at) < r->change[k].reach)
            *near = &r->change[k];
    return i;
}

lw_status lw_reduced_registers(lw_reduced *r, double input)
{
    const lw_change_point *near = NULL;
    const double *mode = r->mode;
    double margin, at = input;
    if (input == r->known)
        return LW_OK;
    if (r->n_change) {
        int piece = find_piece(r, &at, &near);
        mode = r->piece_mode[piece];
    }
    if (r->period == 0 && (at < r->low || at > r->high))
        return LW_OPEN;
    lw_reduced_plain(r, mode, near, at, NULL, &margin);
    if (!(margin > closed))
        return LW_OPEN;
    r->known = input;
    return LW_OK;
}

double lw_reduced_joint_rate(const lw_reduced *r, int joint)
{
    const lw_reduced_joint *j = &r->joint[joint];
    if (!j->slides)
        return j->sign*(r->reg[j->dir[1]].d.x - r->reg[j->dir[0]].d.x);
    const lw_end_point *p = j->point;
    lw_reg1 a = lw_rate_point(r->reg, p[0].origin, p[0].dir, p[0].arm);
    lw_reg1 b = lw_rate_point(r->reg, p[1].origin, p[1].dir, p[1].arm);
    return j->sign*lw_v2_dot(lw_v2_sub(b.d, a.d), lw_v2_turn(j->along, r->reg[j->dir[0]].p));
}

/* mbs/dynamics/reduced_steps.c - the steps of the plan with derivatives by the input.
 *
 * The velocities of a dyad are linear in those of the links it is joined to.  For RRR, c = a + r1 u1 = b + r2 u2, x =
 * cross(u1, u2):
 *     r1 x w1 = (b' - a').u2,    r2 x w2 = (b' - a').u1. */
#include "base/real.h"
#include "mbs/dynamics/reduced_internal.h"

#include "mbs/plan/dyad_internal.h"

static const double closed = 1e-12;          /* a margin below this: a dead point */

static inline lw_reg1 direction(lw_vec2 u, double w) { return (lw_reg1){ u, { w, 0 } }; }

/* a + r u */
static inline lw_reg1 arm_end(const lw_reg1 *a, const lw_reg1 *u, double r)
{
    double w = r*u->d.x;
    return (lw_reg1){ lw_v2_add(a->p, lw_v2_scale(u->p, r)), lw_v2(a->d.x - w*u->p.y, a->d.y + w*u->p.x) };
}

/* One square root and beside it one division; the places need nothing else.  With (b - a)^2 = d2 and y = mode
 * sqrt(h) as in mbs/plan/dyad_internal.h, r1 r2 cross(u1, u2) = y/2. */
static double rates_rrr(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *b = &reg[st->in[1]];
    lw_vec2 span = lw_joint_span(a->p, b->p), e = lw_v2_sub(b->d, a->d);
    double d2 = lw_v2_dot(span, span), h = (st->sum2 - d2)*(d2 - st->dif2);
    double y = mode*sqrt(h > 0 ? h : 0), over_d2 = 0.5/d2, over_y = 2/y;
    lw_vec2 u1 = lw_v2_scale(lw_v2_turn(span, lw_v2(d2 + st->product, y)), over_d2*st->inv1);
    lw_vec2 u2 = lw_v2_scale(lw_v2_turn(span, lw_v2(st->product - d2, y)), over_d2*st->inv2);
    reg[st->out[0]] = direction(u1, st->r2*over_y*lw_v2_dot(e, u2));
    if (st->out[1] >= 0)
        reg[st->out[1]] = direction(u2, st->r1*over_y*lw_v2_dot(e, u1));
    reg[st->out[2]] = arm_end(a, &reg[st->out[0]], st->r1);
    return d2 > 2*LW_TINY2 ? h*st->flat : fmin(h*st->flat, 0);
}

/* With t = (c - q).w the place on the line and n = i w:   r (u.w) w1 = (q' - a').n + t ww. */
static double rates_rrp(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *q = &reg[st->in[1]], *w = &reg[st->in[2]];
    lw_rrp z = lw_rrp_solve_along(a->p, q->p, w->p, st->r1, mode);
    lw_vec2 u = lw_rrp_direction(&z), n = lw_v2_perp(w->p);
    double t = lw_v2_dot(lw_v2_sub(lw_v2_add(a->p, z.arm), q->p), w->p);
    double top = lw_v2_dot(lw_v2_sub(q->d, a->d), n) + t*w->d.x;
    reg[st->out[0]] = direction(u, top/(st->r1*lw_v2_dot(u, w->p)));
    reg[st->out[1]] = arm_end(a, &reg[st->out[0]], st->r1);
    return lw_rrp_margin(&z);
}

/* With t = (b - a).u:   t w = (b' - a').n. */
static double rates_rpr(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *b = &reg[st->in[1]];
    lw_rpr z = lw_rpr_solve(a->p, b->p, st->r1, mode);
    double t = lw_v2_dot(lw_v2_sub(b->p, a->p), z.u);
    reg[st->out[0]] = direction(z.u, lw_v2_cross(z.u, lw_v2_sub(b->d, a->d))/t);
    return lw_rpr_margin(&z);
}

/* c on both lines:  (c' - q2').n2 = t2 w2,  c = q1 + t1 w1. */
static double rates_prp(const lw_dyad_step *st, lw_reg1 *reg)
{
    const lw_reg1 *q1 = &reg[st->in[0]], *w1 = &reg[st->in[1]], *q2 = &reg[st->in[2]], *w2 = &reg[st->in[3]];
    lw_prp z = lw_prp_solve(q1->p, w1->p, q2->p, w2->p);
    lw_vec2 n1 = lw_v2_perp(w1->p), n2 = lw_v2_perp(w2->p);
    double t2 = lw_v2_dot(lw_v2_sub(z.c, q2->p), w2->p), a1 = z.t1*w1->d.x;
    double dt1 = -z.inv*(t2*w2->d.x + lw_v2_dot(lw_v2_sub(q2->d, q1->d), n2) - a1*lw_v2_dot(n1, n2));
    reg[st->out[0]] = (lw_reg1){ z.c, lw_v2_add(q1->d, lw_v2_add(lw_v2_scale(w1->p, dt1), lw_v2_scale(n1, a1))) };
    return lw_prp_margin(&z);
}

/* ---- across a change point ------------------------------------------------------------------------ */

static lw_reg1 bridged(const double *c, double x, double reach)
{
    double v = 0, d = 0;
    for (int k = LW_BRIDGE_SIZE - 1; k >= 0; k--) {
        d = d*x + v;
        v = v*x + c[k];
    }
    return direction(lw_v2_polar(1, v), d/reach);
}

static void bridge_step(const lw_dyad_step *st, const lw_change_point *t, const lw_bridge *b, double input,
                        lw_reg1 *reg)
{
    double x = (input - t->at)/t->reach;
    reg[st->out[0]] = bridged(b->c[0], x, t->reach);
    if (st->kind == LW_STEP_RRR) {
        if (st->out[1] >= 0)
            reg[st->out[1]] = bridged(b->c[1], x, t->reach);
        reg[st->out[2]] = arm_end(&reg[st->in[0]], &reg[st->out[0]], st->r1);
    } else if (st->kind == LW_STEP_RRP) {
        reg[st->out[1]] = arm_end(&reg[st->in[0]], &reg[st->out[0]], st->r1);
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

static inline double evaluate_step(const lw_dyad_step *st, const double *mode, double input, lw_reg1 *reg)
{
    double c, s;
    switch (st->kind) {
    case LW_STEP_INPUT_PIN:
        sincos(input, &s, &c);
        reg[st->out[0]] = direction(lw_v2(c, s), 1);
        return 1;
    case LW_STEP_INPUT_SLIDE:
        reg[st->out[0]] = (lw_reg1){ lw_frame_point(reg[st->in[0]].p, reg[st->in[1]].p, input, 0), reg[st->in[1]].p };
        return 1;
    case LW_STEP_POINT:
        reg[st->out[0]] = lw_reduced_point(reg, st->in[0], st->in[1], st->at);
        return 1;
    case LW_STEP_LINE:
        reg[st->out[1]] = direction(lw_v2_turn(st->line, reg[st->in[1]].p), reg[st->in[1]].d.x);
        reg[st->out[0]] = lw_reduced_point(reg, st->in[0], st->out[1], st->at);
        return 1;
    case LW_STEP_RRR: return rates_rrr(st, mode[st->dyad], reg);
    case LW_STEP_RRP: return rates_rrp(st, mode[st->dyad], reg);
    case LW_STEP_RPR: return rates_rpr(st, mode[st->dyad], reg);
    case LW_STEP_PRP:
    case LW_STEP_PPR: return rates_prp(st, reg);
    case LW_STEP_HIGHER: case LW_STEP_TURN: case LW_STEP_SLIDE: case LW_STEP_GEAR: case LW_STEP_ALONG:
    case LW_STEP_ROLL:
    case LW_STEP_RACK: break;                              /* not in plans of dyads alone */
    }
    return 1;
}

void lw_reduced_plain(lw_reduced *r, const double *mode, const lw_change_point *bridge, double input, double *margin_of,
                      double *margin)
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
            m = evaluate_step(st, mode, input, reg);
        *margin = m < *margin ? m : *margin;
        if (margin_of && st->kind >= LW_STEP_RRR)
            margin_of[st->dyad] = m;
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
    lw_reg1 a = lw_reduced_point(r->reg, p[0].origin, p[0].dir, p[0].arm);
    lw_reg1 b = lw_reduced_point(r->reg, p[1].origin, p[1].dir, p[1].arm);
    return j->sign*lw_v2_dot(lw_v2_sub(b.d, a.d), lw_v2_turn(j->along, r->reg[j->dir[0]].p));
}

/* Evaluate one posture step by step, and its derivatives in truncated Taylor arithmetic: every number is replaced by
 * its Taylor coefficients in the input, every operation by that on the coefficients (Griewank & Walther 2008, ch. 13).
 * The derivatives are exact to rounding. */
#include "mbs/batch/posture.h"
#include "mbs/batch/kernels_internal.h"
#include "mbs/plan/plan_internal.h"
#include "mbs/plan/steps_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- the posture alone --------------------------------------------------------------------------------- */

static double value(const double *dim, int d) { return d < 0 ? 0 : dim[d]; }

/* Evaluate one step.  Returns the margin of a dyad or rack, 1 for other steps. */
static double solve_step(const lw_step *s, const double *dim, const double *mode, double input, lw_vec2 *reg)
{
    lw_step_lane z = { .margin = 1 };
    lw_step_numbers q = { .mode = s->dyad < 0 ? 1 : mode[s->dyad], .power = { s->power[0], s->power[1] } };
    for (int h = 0; h < lw_step_dims(s->kind); h++)
        q.dim[h] = value(dim, s->dim[h]);
    if (s->kind == LW_STEP_INPUT_SLIDE)
        q.turn = lw_v2(input, 0);
    else if (s->kind == LW_STEP_INPUT_PIN || s->kind == LW_STEP_LINE || s->kind == LW_STEP_GEAR)
        q.turn = lw_v2_polar(1, s->kind == LW_STEP_INPUT_PIN ? input : q.dim[s->kind == LW_STEP_LINE]);
    lw_step_prepare(s->kind, &q);
    for (int h = 0; h < lw_step_inputs(s->kind) && s->in[h] >= 0; h++)
        z.in[h] = reg[s->in[h]];
    lw_step_value(s->kind, &z, &q, 0);
    for (int h = 0; h < lw_step_outputs(s->kind); h++)
        if (s->out[h] >= 0)
            reg[s->out[h]] = z.out[h];
    return z.margin;
}

/* Copy the directions and displacements of a higher group to the registers. */
static void take_group_posture(const lw_higher *g, const lw_group_posture *group_posture, lw_vec2 *reg)
{
    const double *row = group_posture->row + g->first_row;
    for (int a = 0; a < g->n_turn; a++, row += 2)
        reg[g->turn_reg[a]] = lw_v2(row[0], row[1]);
    for (int d = 0; d < g->n_disp; d++)
        reg[g->disp_reg[d]] = lw_v2(*row++, 0);
}

lw_status lw_group_posture_find(const lw_plan *plan, const double *dim, const double *mode, double input,
                                lw_group_posture *group_posture)
{
    void *work = malloc(lw_group_posture_size(plan));
    if (!work)
        return LW_E_MEMORY;
    lw_kernels_of(plan)->group_posture(plan, dim, mode, input, work, group_posture);
    free(work);
    return LW_OK;
}

/* Evaluate all steps.  group_posture: posture of the higher groups, unused without them.  Returns the least margin. */
static double registers(const lw_plan *plan, const double *dim, const double *mode, double input,
                        const lw_group_posture *group_posture,
                        lw_vec2 *reg)
{
    double margin = 1;
    reg[LW_ORIGIN_REG] = lw_v2(0, 0);
    reg[LW_AXIS_REG] = lw_v2(1, 0);
    for (int i = 0; i < plan->n_step; i++)
        if (plan->step[i].kind == LW_STEP_HIGHER)
            take_group_posture(&plan->higher[plan->step[i].dim[0]], group_posture, reg);
        else
            margin = fmin(margin, solve_step(&plan->step[i], dim, mode, input, reg));
    return margin;
}

lw_status lw_posture_registers(const lw_plan *plan, const double *dim, const double *mode, double input,
                               lw_vec2 reg[LW_REG_MAX])
{
    lw_group_posture group_posture;
    lw_status s = plan->n_higher ? lw_group_posture_find(plan, dim, mode, input, &group_posture) : LW_OK;
    if (s != LW_OK)
        return s;
    double least = plan->n_higher ? group_posture.margin : 1;
    return fmin(least, registers(plan, dim, mode, input, &group_posture, reg)) < 0 ? LW_OPEN : LW_OK;
}

/* ---- Taylor coefficients of numbers and vectors ------------------------------------------------------ */

#define N (LW_ORDER_MAX + 1)
typedef struct jet { double c[N]; } jet;
typedef struct jet2 { jet x, y; } jet2;

static jet constant(double a) { return (jet){ { a } }; }

static jet add(jet a, jet b)
{
    for (int i = 0; i < N; i++)
        a.c[i] += b.c[i];
    return a;
}

static jet scale(jet a, double s)
{
    for (int i = 0; i < N; i++)
        a.c[i] *= s;
    return a;
}

static jet sub(jet a, jet b) { return add(a, scale(b, -1)); }

static jet mul(jet a, jet b)
{
    jet p = { { 0 } };
    for (int i = 0; i < N; i++)
        for (int j = 0; j <= i; j++)
            p.c[i] += a.c[j]*b.c[i - j];
    return p;
}

static jet divide(jet a, jet b)
{
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < i; j++)
            a.c[i] -= a.c[j]*b.c[i - j];
        a.c[i] /= b.c[0];
    }
    return a;
}

static jet root(jet a)
{
    jet r = { { sqrt(a.c[0]) } };
    for (int i = 1; i < N; i++) {
        double rest = a.c[i];
        for (int j = 1; j < i; j++)
            rest -= r.c[j]*r.c[i - j];
        r.c[i] = rest/(2*r.c[0]);
    }
    return r;
}

static jet2 add2(jet2 a, jet2 b) { return (jet2){ add(a.x, b.x), add(a.y, b.y) }; }
static jet2 sub2(jet2 a, jet2 b) { return (jet2){ sub(a.x, b.x), sub(a.y, b.y) }; }
static jet2 turn2(jet2 a, jet2 u)
{
    return (jet2){ sub(mul(a.x, u.x), mul(a.y, u.y)), add(mul(a.x, u.y), mul(a.y, u.x)) };
}
static jet2 scale2(jet2 a, jet s) { return (jet2){ mul(a.x, s), mul(a.y, s) }; }
static jet2 conjugate(jet2 a) { return (jet2){ a.x, scale(a.y, -1) }; }
static jet cross2(jet2 a, jet2 b) { return sub(mul(a.x, b.y), mul(a.y, b.x)); }
static jet dot2(jet2 a, jet2 b) { return add(mul(a.x, b.x), mul(a.y, b.y)); }
static jet2 constant2(double x, double y) { return (jet2){ constant(x), constant(y) }; }
static jet2 point2(jet2 o, jet2 d, double x, double y) { return add2(o, turn2(constant2(x, y), d)); }

/* ---- steps in Taylor arithmetic: the formulas of mbs/plan/dyad_internal.h, where they close --------------- */

static jet2 input_direction(double input)
{
    double c = cos(input), s = sin(input);
    jet2 u = { { { c } }, { { s } } };
    for (int i = 1; i < N; i++) {
        u.x.c[i] = -u.y.c[i - 1]/i;
        u.y.c[i] = u.x.c[i - 1]/i;
    }
    return u;
}

static void jet_rrr(const lw_step *s, const double *dim, double mode, jet2 *reg)
{
    double r1 = dim[s->dim[0]], r2 = dim[s->dim[1]], sum = r1 + r2, dif = r1 - r2;
    jet2 a = reg[s->in[0]], span = sub2(reg[s->in[1]], a);
    jet d2 = dot2(span, span);
    jet y = scale(root(mul(sub(constant(sum*sum), d2), sub(d2, constant(dif*dif)))), mode);
    jet2 u1 = turn2(span, (jet2){ add(d2, constant(sum*dif)), y });
    jet2 u2 = turn2(span, (jet2){ sub(constant(sum*dif), d2), y });
    reg[s->out[0]] = scale2(u1, divide(constant(0.5/r1), d2));
    if (s->out[1] >= 0)
        reg[s->out[1]] = scale2(u2, divide(constant(0.5/r2), d2));
    reg[s->out[2]] = point2(a, reg[s->out[0]], r1, 0);
}

static void jet_rrp(const lw_step *s, const double *dim, double mode, jet2 *reg)
{
    double r = dim[s->dim[0]];
    jet2 a = reg[s->in[0]], w = reg[s->in[2]];
    jet away = cross2(w, sub2(reg[s->in[1]], a));
    jet y = scale(root(mul(sub(constant(r), away), add(constant(r), away))), mode);
    jet2 arm = turn2((jet2){ y, away }, w);
    reg[s->out[0]] = scale2(arm, constant(1/r));
    reg[s->out[1]] = add2(a, arm);
}

static void jet_rpr(const lw_step *s, const double *dim, double mode, jet2 *reg)
{
    double e = dim[s->dim[0]];
    jet2 span = sub2(reg[s->in[1]], reg[s->in[0]]);
    jet d2 = dot2(span, span);
    jet y = scale(root(sub(d2, constant(e*e))), mode);
    reg[s->out[0]] = scale2(turn2(span, conjugate((jet2){ y, constant(e) })), divide(constant(1), d2));
}

static void jet_prp(const lw_step *s, jet2 *reg)
{
    jet2 q1 = reg[s->in[0]], w1 = reg[s->in[1]], q2 = reg[s->in[2]], w2 = reg[s->in[3]];
    jet t = divide(cross2(sub2(q2, q1), w2), cross2(w1, w2));
    reg[s->out[0]] = add2(q1, scale2(w1, t));
}

static jet2 jet_times_power(jet2 u, jet2 v, int n)
{
    v = n < 0 ? conjugate(v) : v;
    for (int i = 0; i < abs(n); i++)
        u = turn2(u, v);
    return u;
}

static jet2 jet_gear(const lw_step *s, const double *dim, const jet2 *reg)
{
    double phase = value(dim, s->dim[0]);
    jet2 u = jet_times_power(constant2(cos(phase), sin(phase)), reg[s->in[0]], s->power[0]);
    return s->in[1] < 0 ? u : jet_times_power(u, reg[s->in[1]], s->power[1]);
}

/* The angle of a direction u, given its value: u' = i angle' u for a unit vector u. */
static jet jet_angle(const jet2 *u, double first)
{
    jet a = constant(first);
    for (int m = 1; m < N; m++)
        for (int l = 1; l <= m; l++)
            a.c[m] += l*(u->x.c[m - l]*u->y.c[l] - u->y.c[m - l]*u->x.c[l])/m;
    return a;
}

/* The direction of an angle. */
static jet2 jet_polar(jet a)
{
    jet2 u = constant2(cos(a.c[0]), sin(a.c[0]));
    for (int m = 1; m < N; m++)
        for (int l = 1; l <= m; l++) {
            u.x.c[m] -= l*a.c[l]*u.y.c[m - l]/m;
            u.y.c[m] += l*a.c[l]*u.x.c[m - l]/m;
        }
    return u;
}

static jet2 jet_roll(const lw_step *s, const double *dim, const jet2 *reg)
{
    jet travel = sub(reg[s->in[1]].x, constant(dim[s->dim[1]]));
    return turn2(reg[s->in[0]], jet_polar(scale(travel, 1/lw_away_from_zero(dim[s->dim[0]]))));
}

static jet2 jet_rack(const lw_step *s, const double *dim, const jet2 *reg)
{
    jet2 a = turn2(reg[s->in[0]], conjugate(reg[s->in[1]])), d = constant2(0, 0);
    double middle = dim[s->dim[2]], off = remainder(atan2(a.y.c[0], a.x.c[0]) - middle, 2*LW_PI);
    d.x = add(constant(dim[s->dim[1]]), scale(jet_angle(&a, middle + off), dim[s->dim[0]]));
    return d;
}

static void jet_step(const lw_step *s, const double *dim, const double *mode, double input, jet2 *reg)
{
    const int *in = s->in, *out = s->out;
    jet slide = { { input, 1 } };
    switch (s->kind) {
    case LW_STEP_INPUT_PIN:   reg[out[0]] = input_direction(input); break;
    case LW_STEP_INPUT_SLIDE: reg[out[0]] = add2(reg[in[0]], scale2(reg[in[1]], slide)); break;
    case LW_STEP_POINT:
        reg[out[0]] = point2(reg[in[0]], reg[in[1]], value(dim, s->dim[0]), value(dim, s->dim[1]));
        break;
    case LW_STEP_LINE:
        reg[out[1]] = turn2(constant2(cos(dim[s->dim[1]]), sin(dim[s->dim[1]])), reg[in[1]]);
        reg[out[0]] = point2(reg[in[0]], reg[out[1]], 0, value(dim, s->dim[0]));
        break;
    case LW_STEP_RRR: jet_rrr(s, dim, mode[s->dyad], reg); break;
    case LW_STEP_TURN:
        reg[out[0]] = turn2(reg[in[0]], s->power[0] < 0 ? conjugate(reg[in[1]]) : reg[in[1]]);
        break;
    case LW_STEP_GEAR:  reg[out[0]] = jet_gear(s, dim, reg); break;
    case LW_STEP_SLIDE: reg[out[0]] = add2(reg[in[0]], scale2(reg[in[1]], reg[in[2]].x)); break;
    case LW_STEP_ALONG:
        reg[out[0]] = (jet2){ dot2(sub2(reg[in[2]], reg[in[0]]), reg[in[1]]), constant(0) };
        break;
    case LW_STEP_ROLL:  reg[out[0]] = jet_roll(s, dim, reg); break;
    case LW_STEP_RACK:  reg[out[0]] = jet_rack(s, dim, reg); break;
    case LW_STEP_RRP:   jet_rrp(s, dim, mode[s->dyad], reg); break;
    case LW_STEP_RPR:   jet_rpr(s, dim, mode[s->dyad], reg); break;
    case LW_STEP_PRP:
    case LW_STEP_PPR:   jet_prp(s, reg); break;
    case LW_STEP_HIGHER: break;                            /* see jet_steps */
    }
}

/* ---- a higher group: one order after the other, with the same inverse Jacobian ---------------------------- */

typedef struct closing { const lw_higher *g; jet2 dir[LW_HIGHER_DIR_MAX]; jet turn[LW_UNKNOWN_MAX]; } closing;

/* Known directions, and directions turned from others. */
static void jet_turned(closing *q, const double *dim, const jet2 *reg)
{
    for (int a = 0; a < q->g->n_dir; a++) {
        const lw_higher_dir *d = &q->g->dir[a];
        if (d->base < 0 && d->root < 0)
            q->dir[a] = reg[d->reg];
        if (d->base < 0)
            continue;
        jet2 by = d->dim >= 0 ? constant2(cos(dim[d->dim]), sin(dim[d->dim])) : reg[d->reg];
        q->dir[a] = turn2(q->dir[d->base], d->input < 0 ? conjugate(by) : by);
    }
}

/* Coefficient m of the residuals of the loops. */
static void jet_loops(const closing *q, const double *dim, const jet2 *reg, int m, double *f)
{
    const lw_higher *g = q->g;
    for (int r = 0; r < 2*g->n_loop; r++)
        f[r] = 0;
    for (int i = 0; i < g->n_point; i++) {
        f[2*g->point[i].loop] += g->point[i].sign*reg[g->point[i].reg].x.c[m];
        f[2*g->point[i].loop + 1] += g->point[i].sign*reg[g->point[i].reg].y.c[m];
    }
    for (int i = 0; i < g->n_vector; i++) {
        const lw_higher_vector *v = &g->vector[i];
        lw_vec2 u = lw_v2(q->dir[v->dir].x.c[m], q->dir[v->dir].y.c[m]);
        u = lw_v2_turn(lw_v2(value(dim, v->x), value(dim, v->y)), u);
        f[2*v->loop] += v->sign*u.x;
        f[2*v->loop + 1] += v->sign*u.y;
    }
    for (int i = 0; i < g->n_slide; i++) {
        const lw_higher_slide *v = &g->slide[i];
        jet2 u = scale2(q->dir[v->dir], reg[g->disp_reg[v->disp]].x);
        f[2*v->loop] += v->sign*u.x.c[m];
        f[2*v->loop + 1] += v->sign*u.y.c[m];
    }
}

/* Coefficient m > 0 of the residuals of gears; phases and shifts are constants. */
static void jet_gears(const closing *q, const double *dim, const jet2 *reg, int m, double *f)
{
    const lw_higher *g = q->g;
    for (int i = 0; i < g->n_gear; i++) {
        const lw_higher_gear *v = &g->gear[i];
        double left = 0;
        for (int h = 0; h < v->n_term; h++)
            left += (double)v->power[h]/v->count*jet_angle(&q->dir[v->dir[h]], 0).c[m];
        if (v->disp >= 0)
            left -= reg[g->disp_reg[v->disp]].x.c[m]/lw_away_from_zero(dim[v->rho]);
        f[2*g->n_loop + i] = left;
    }
}

/* Coefficient m of the direction of a turn: u' = i turn' u. */
static void jet_direction(closing *q, int a, int m)
{
    jet2 *u = &q->dir[a];
    const double *turn = q->turn[q->g->dir[a].root].c;
    u->x.c[m] = u->y.c[m] = 0;
    for (int l = 1; l <= m; l++) {
        u->x.c[m] -= l*turn[l]*u->y.c[m - l]/m;
        u->y.c[m] += l*turn[l]*u->x.c[m - l]/m;
    }
}

static void jet_higher(const lw_higher *g, const double *inverse, const double *dim, jet2 *reg)
{
    closing q = { .g = g };
    int n = g->n_unknown;
    double f[LW_UNKNOWN_MAX];
    for (int a = 0; a < g->n_dir; a++)
        if (g->dir[a].base < 0 && g->dir[a].root >= 0)
            q.dir[a] = reg[g->turn_reg[g->dir[a].root]];
    for (int m = 1; m < N; m++) {
        for (int a = 0; a < g->n_dir; a++)
            if (g->dir[a].base < 0 && g->dir[a].root >= 0)
                jet_direction(&q, a, m);
        jet_turned(&q, dim, reg);
        jet_loops(&q, dim, reg, m, f);
        jet_gears(&q, dim, reg, m, f);
        for (int c = 0; c < n; c++) {
            double x = 0;
            for (int r = 0; r < n; r++)
                x -= inverse[c*n + r]*f[r];
            if (c < g->n_turn)
                q.turn[c].c[m] = x;
            else
                reg[g->disp_reg[c - g->n_turn]].x.c[m] = x;
        }
        for (int a = 0; a < g->n_dir; a++)
            if (g->dir[a].base < 0 && g->dir[a].root >= 0)
                jet_direction(&q, a, m);
    }
    for (int a = 0; a < g->n_dir; a++)
        if (g->dir[a].base < 0 && g->dir[a].root >= 0)
            reg[g->turn_reg[g->dir[a].root]] = q.dir[a];
}

/* Evaluate all steps in Taylor arithmetic, from a posture without derivatives. */
static void jet_steps(const lw_plan *plan, const double *dim, const double *mode, double input,
                      const lw_group_posture *group_posture, jet2 *reg)
{
    const double *inverse = group_posture->inverse;
    for (int i = 0; i < plan->n_step; i++) {
        const lw_step *s = &plan->step[i];
        if (s->kind != LW_STEP_HIGHER) {
            jet_step(s, dim, mode, input, reg);
            continue;
        }
        const lw_higher *g = &plan->higher[s->dim[0]];
        jet_higher(g, inverse, dim, reg);
        inverse += g->n_unknown*g->n_unknown;
    }
}

/* ---- results ------------------------------------------------------------------------------------------ */

typedef struct sink { int order; lw_vec2 z0, turn; double theta0; } sink;

static void put_point(const sink *k, const jet2 *p, lw_vec2 out[N])
{
    double factorial = 1;
    for (int i = 0; i <= k->order; i++) {
        factorial *= i > 1 ? i : 1;
        out[i] = lw_v2_scale(lw_v2_turn(lw_v2(p->x.c[i], p->y.c[i]), k->turn), factorial);
    }
    out[0] = lw_v2_add(k->z0, out[0]);
}

/* The rate of the angle of a unit vector is u x du. */
static void put_angle(const sink *k, const jet2 *u, double out[N])
{
    jet2 du = constant2(0, 0);
    for (int i = 1; i < N; i++) {
        du.x.c[i - 1] = i*u->x.c[i];
        du.y.c[i - 1] = i*u->y.c[i];
    }
    jet rate = cross2(*u, du);
    double factorial = 1;
    out[0] = atan2(u->y.c[0], u->x.c[0]) + k->theta0;
    for (int i = 1; i <= k->order; i++) {
        out[i] = factorial*rate.c[i - 1];
        factorial *= i;
    }
}

static void put_all(const lw_plan *plan, const sink *k, const jet2 *reg, lw_posture *posture)
{
    for (int j = 0; j < LW_JOINT_MAX; j++)
        if (plan->joint_point[j] >= 0)
            put_point(k, &reg[plan->joint_point[j]], posture->joint[j]);
    for (int i = 0; i < plan->n_link; i++)
        if (plan->link_dir[plan->link[i]] >= 0)
            put_angle(k, &reg[plan->link_dir[plan->link[i]]], posture->angle[plan->link[i]]);
    for (int o = 0; o < plan->n_output; o++)
        put_point(k, &reg[plan->output_point[o]], posture->tracer[o]);
}

/* The posture without derivatives. */
static void put_places(const lw_plan *plan, const sink *k, const lw_vec2 *reg, lw_posture *posture)
{
    for (int j = 0; j < LW_JOINT_MAX; j++)
        if (plan->joint_point[j] >= 0)
            posture->joint[j][0] = lw_v2_add(k->z0, lw_v2_turn(reg[plan->joint_point[j]], k->turn));
    for (int i = 0; i < plan->n_link; i++)
        if (plan->link_dir[plan->link[i]] >= 0) {
            lw_vec2 u = reg[plan->link_dir[plan->link[i]]];
            posture->angle[plan->link[i]][0] = atan2(u.y, u.x) + k->theta0;
        }
    for (int o = 0; o < plan->n_output; o++)
        posture->tracer[o][0] = lw_v2_add(k->z0, lw_v2_turn(reg[plan->output_point[o]], k->turn));
}

static bool all_finite(const jet2 *reg, int n)
{
    for (int r = 0; r < n; r++)
        for (int i = 0; i < N; i++)
            if (!isfinite(reg[r].x.c[i]) || !isfinite(reg[r].y.c[i]))
                return false;
    return true;
}

lw_status lw_posture_solve(const lw_plan *plan, const double *dim, const double *mode, double input, int order,
                           lw_posture *posture)
{
    lw_vec2 flat[LW_REG_MAX];
    jet2 reg[LW_REG_MAX];
    if (order < 0 || order > LW_ORDER_MAX)
        return LW_E_ARG;
    memset(posture, 0, sizeof *posture);
    posture->input = input;
    lw_group_posture group_posture;
    lw_status s = plan->n_higher ? lw_group_posture_find(plan, dim, mode, input, &group_posture) : LW_OK;
    if (s != LW_OK)
        return s;
    double least = plan->n_higher ? group_posture.margin : 1;
    posture->margin = fmin(least, registers(plan, dim, mode, input, &group_posture, flat));
    sink k = { order, lw_v2(dim[plan->i_x0], dim[plan->i_y0]), lw_v2_polar(1, dim[plan->i_theta0]),
               dim[plan->i_theta0] };
    if (order == 0) {
        put_places(plan, &k, flat, posture);
        return posture->margin < 0 ? LW_OPEN : LW_OK;
    }
    for (int r = 0; r < plan->n_reg; r++)
        reg[r] = constant2(flat[r].x, flat[r].y);
    if (posture->margin > LW_MARGIN_FLAT)
        jet_steps(plan, dim, mode, input, &group_posture, reg);
    /* by rounding a dyad may close in `registers` and not in Taylor arithmetic: no derivatives then */
    if (!all_finite(reg, plan->n_reg))
        for (int r = 0; r < plan->n_reg; r++)
            reg[r] = constant2(flat[r].x, flat[r].y);
    put_all(plan, &k, reg, posture);
    return posture->margin < 0 ? LW_OPEN : LW_OK;
}

/* Evaluate one posture step by step, and its derivatives in truncated Taylor arithmetic (mbs/plan/jet_internal.h). */
#include "mbs/batch/posture.h"
#include "mbs/batch/kernels_internal.h"
#include "mbs/plan/plan_internal.h"
#include "mbs/plan/steps_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- the posture alone --------------------------------------------------------------------------------- */

static double value(const double *dim, int d) { return d < 0 ? 0 : dim[d]; }

static lw_step_numbers numbers_of(const lw_step *s, const double *dim, const double *mode, double input)
{
    lw_step_numbers q = { .mode = s->dyad < 0 ? 1 : mode[s->dyad], .power = { s->power[0], s->power[1] } };
    for (int h = 0; h < lw_step_dims(s->kind); h++)
        q.dim[h] = value(dim, s->dim[h]);
    if (s->kind == LW_STEP_INPUT_SLIDE)
        q.turn = lw_v2(input, 0);
    else if (s->kind == LW_STEP_INPUT_PIN || s->kind == LW_STEP_LINE || s->kind == LW_STEP_GEAR)
        q.turn = lw_v2_polar(1, s->kind == LW_STEP_INPUT_PIN ? input : q.dim[s->kind == LW_STEP_LINE]);
    lw_step_prepare(s->kind, &q);
    return q;
}

/* Evaluate one step.  Returns the margin of a dyad or rack, 1 for other steps. */
static double solve_step(const lw_step *s, const double *dim, const double *mode, double input, lw_vec2 *reg)
{
    lw_step_lane z = { .margin = 1 };
    const lw_step_numbers q = numbers_of(s, dim, mode, input);
    for (int h = 0; h < lw_step_inputs(s->kind) && s->in[h] >= 0; h++)
        z.in[h] = reg[s->in[h]];
    lw_step_value(s->kind, &z, &q, 0);
    for (int h = 0; h < lw_step_outputs(s->kind); h++)
        if (s->out[h] >= 0)
            reg[s->out[h]] = z.out[h];
    return z.margin;
}

/* The same in Taylor arithmetic. */
static void jet_step(const lw_step *s, const double *dim, const double *mode, double input, lw_jet2 *reg)
{
    lw_jet2 in[4] = { 0 }, out[3];
    const lw_step_numbers q = numbers_of(s, dim, mode, input);
    for (int h = 0; h < lw_step_inputs(s->kind) && s->in[h] >= 0; h++)
        in[h] = reg[s->in[h]];
    lw_step_series(s->kind, in, &q, out);
    for (int h = 0; h < lw_step_outputs(s->kind); h++)
        if (s->out[h] >= 0)
            reg[s->out[h]] = out[h];
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

lw_status lw_group_posture_find(const lw_plan *plan, const double *dim, const double *mode, double input, lw_group_posture *group_posture)
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

lw_status lw_posture_registers(const lw_plan *plan, const double *dim, const double *mode, double input, lw_vec2 reg[LW_REG_MAX])
{
    lw_group_posture group_posture;
    lw_status s = plan->n_higher ? lw_group_posture_find(plan, dim, mode, input, &group_posture) : LW_OK;
    if (s != LW_OK)
        return s;
    double least = plan->n_higher ? group_posture.margin : 1;
    return fmin(least, registers(plan, dim, mode, input, &group_posture, reg)) < 0 ? LW_OPEN : LW_OK;
}

/* ---- a higher group: one order after the other, with the same inverse Jacobian ---------------------------- */

typedef struct closing { const lw_higher *g; lw_jet2 dir[LW_HIGHER_DIR_MAX]; lw_jet turn[LW_UNKNOWN_MAX]; } closing;

/* Known directions, and directions turned from others. */
static void jet_turned(closing *q, const double *dim, const lw_jet2 *reg)
{
    for (int a = 0; a < q->g->n_dir; a++) {
        const lw_higher_dir *d = &q->g->dir[a];
        if (d->base < 0 && d->root < 0)
            q->dir[a] = reg[d->reg];
        if (d->base < 0)
            continue;
        lw_jet2 by = d->dim >= 0 ? lw_jet2_constant(cos(dim[d->dim]), sin(dim[d->dim])) : reg[d->reg];
        q->dir[a] = lw_jet2_turn(q->dir[d->base], d->input < 0 ? lw_jet2_conjugate(by) : by);
    }
}

/* Coefficient m of the residuals of the loops. */
static void jet_loops(const closing *q, const double *dim, const lw_jet2 *reg, int m, double *f)
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
        lw_jet2 u = lw_jet2_scale(q->dir[v->dir], reg[g->disp_reg[v->disp]].x);
        f[2*v->loop] += v->sign*u.x.c[m];
        f[2*v->loop + 1] += v->sign*u.y.c[m];
    }
}

/* Coefficient m > 0 of the residuals of gears; phases and shifts are constants. */
static void jet_gears(const closing *q, const double *dim, const lw_jet2 *reg, int m, double *f)
{
    const lw_higher *g = q->g;
    for (int i = 0; i < g->n_gear; i++) {
        const lw_higher_gear *v = &g->gear[i];
        double left = 0;
        for (int h = 0; h < v->n_term; h++)
            left += (double)v->power[h]/v->count*lw_jet_angle(&q->dir[v->dir[h]], 0).c[m];
        if (v->disp >= 0)
            left -= reg[g->disp_reg[v->disp]].x.c[m]/lw_away_from_zero(dim[v->rho]);
        f[2*g->n_loop + i] = left;
    }
}

/* Coefficient m of the direction of a turn: u' = i turn' u. */
static void jet_direction(closing *q, int a, int m)
{
    lw_jet2 *u = &q->dir[a];
    const double *turn = q->turn[q->g->dir[a].root].c;
    u->x.c[m] = u->y.c[m] = 0;
    for (int l = 1; l <= m; l++) {
        u->x.c[m] -= l*turn[l]*u->y.c[m - l]/m;
        u->y.c[m] += l*turn[l]*u->x.c[m - l]/m;
    }
}

static void jet_higher(const lw_higher *g, const double *inverse, const double *dim, lw_jet2 *reg)
{
    closing q = { .g = g };
    int n = g->n_unknown;
    double f[LW_UNKNOWN_MAX];
    for (int a = 0; a < g->n_dir; a++)
        if (g->dir[a].base < 0 && g->dir[a].root >= 0)
            q.dir[a] = reg[g->turn_reg[g->dir[a].root]];
    for (int m = 1; m < LW_JET; m++) {
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
                      const lw_group_posture *group_posture, lw_jet2 *reg)
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

static void put_point(const sink *k, const lw_jet2 *p, lw_vec2 out[LW_JET])
{
    double factorial = 1;
    for (int i = 0; i <= k->order; i++) {
        factorial *= i > 1 ? i : 1;
        out[i] = lw_v2_scale(lw_v2_turn(lw_v2(p->x.c[i], p->y.c[i]), k->turn), factorial);
    }
    out[0] = lw_v2_add(k->z0, out[0]);
}

/* The rate of the angle of a unit vector is u x du. */
static void put_angle(const sink *k, const lw_jet2 *u, double out[LW_JET])
{
    lw_jet2 du = lw_jet2_constant(0, 0);
    for (int i = 1; i < LW_JET; i++) {
        du.x.c[i - 1] = i*u->x.c[i];
        du.y.c[i - 1] = i*u->y.c[i];
    }
    lw_jet rate = lw_jet2_cross(*u, du);
    double factorial = 1;
    out[0] = atan2(u->y.c[0], u->x.c[0]) + k->theta0;
    for (int i = 1; i <= k->order; i++) {
        out[i] = factorial*rate.c[i - 1];
        factorial *= i;
    }
}

static void put_all(const lw_plan *plan, const sink *k, const lw_jet2 *reg, lw_posture *posture)
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

static bool all_finite(const lw_jet2 *reg, int n)
{
    for (int r = 0; r < n; r++)
        for (int i = 0; i < LW_JET; i++)
            if (!isfinite(reg[r].x.c[i]) || !isfinite(reg[r].y.c[i]))
                return false;
    return true;
}

lw_status lw_posture_solve(const lw_plan *plan, const double *dim, const double *mode, double input, int order, lw_posture *posture)
{
    lw_vec2 flat[LW_REG_MAX];
    lw_jet2 reg[LW_REG_MAX];
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
        reg[r] = lw_jet2_constant(flat[r].x, flat[r].y);
    if (posture->margin > LW_MARGIN_FLAT)
        jet_steps(plan, dim, mode, input, &group_posture, reg);
    /* by rounding a dyad may close in `registers` and not in Taylor arithmetic: no derivatives then */
    if (!all_finite(reg, plan->n_reg))
        for (int r = 0; r < plan->n_reg; r++)
            reg[r] = lw_jet2_constant(flat[r].x, flat[r].y);
    put_all(plan, &k, reg, posture);
    return posture->margin < 0 ? LW_OPEN : LW_OK;
}

#include "optimise/problem/problem.h"

#include <string.h>

const char *lw_problem_variable(const lw_problem *p, int i)
{
    if (i < p->n_dim)
        return p->plan.dim[i].name;
    if (i == p->i_input0)
        return "input0";
    static const char *const tool[LW_PROBLEM_TRACER_MAX] = { "tool0", "tool2", "tool3", "tool4" };
    int k = p->n_also;
    while (k > 0 && p->also[k - 1].i_tool != i)
        k--;
    return tool[k];
}

int lw_problem_index(const lw_problem *p, const char *name)
{
    for (int i = 0; i < p->n_var; i++)
        if (strcmp(lw_problem_variable(p, i), name) == 0)
            return i;
    return -1;
}

void lw_problem_to_dims(const lw_problem *p, const double *x, double *dim)
{
    for (int i = 0; i < p->n_dim; i++)
        dim[i] = p->plan.dim[i].kind == LW_DIM_ANGLE ? x[i] : p->unit*x[i];
    dim[p->plan.i_x0] += p->origin.x;
    dim[p->plan.i_y0] += p->origin.y;
}

void lw_problem_from_dims(const lw_problem *p, const double *dim, double *x)
{
    for (int i = 0; i < p->n_dim; i++)
        x[i] = p->plan.dim[i].kind == LW_DIM_ANGLE ? dim[i] : dim[i]/p->unit;
    x[p->plan.i_x0] = (dim[p->plan.i_x0] - p->origin.x)/p->unit;
    x[p->plan.i_y0] = (dim[p->plan.i_y0] - p->origin.y)/p->unit;
}

int lw_problem_first_length(const lw_problem *p)
{
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH)
            return i;
    return -1;
}

size_t lw_problem_lane_count(const lw_problem *p)
{
    return p->n + (p->timing == LW_TIMING_NONE ? LW_CURVE_SAMPLES : 0);
}

bool lw_problem_has_modes(const lw_problem *p)
{
    return !p->intended.turns && p->timing != LW_TIMING_PRESCRIBED && (!p->family->linkage || p->intended.through);
}

int lw_problem_component_count(const lw_problem *p)
{
    int n = (lw_task_has_place(p->task) ? 2 : 0) + (lw_task_has_angle(p->task) ? 1 : 0);
    for (int i = 0; i < p->n_also; i++)
        n += (p->also[i].x ? 2 : 0) + (p->also[i].theta ? 1 : 0);
    return n;
}

void lw_problem_fixed_pivots(const lw_problem *p, const double *x, lw_pivots *v)
{
    int ground = p->plan.link[0];
    v->n = 1;
    v->at[0] = lw_v2(0, 0);
    v->of[0][0] = v->of[0][1] = -1;
    for (int d = 0; d < p->n_dim; d++) {
        const lw_dim_info *i = &p->plan.dim[d];
        if (i->link != ground)
            continue;
        if (i->role == LW_ROLE_R || i->role == LW_ROLE_X) {
            v->of[v->n][0] = d;
            v->of[v->n][1] = -1;
            v->at[v->n++] = lw_v2(x[d], 0);
        }
        if (i->role == LW_ROLE_Y) {
            v->of[v->n - 1][1] = d;
            v->at[v->n - 1].y = x[d];
        }
    }
}

bool lw_problem_must_close(const lw_problem *p)
{
    return !p->intended.turns && p->timing == LW_TIMING_PRESCRIBED;
}

bool lw_problem_is_nonlinear(const lw_problem *p)
{
    return lw_problem_must_close(p) || p->min_transmission > 0 || p->max_acceleration > 0 || p->n_zone > 0
        || p->n_side > 0;
}

size_t lw_problem_transmission_postures(const lw_problem *p)
{
    return p->intended.turns && !p->family->linkage ? 4 : LW_CURVE_SAMPLES;
}

size_t lw_problem_constraint_count(const lw_problem *p)
{
    return (size_t)p->n_linear + (size_t)p->n_side + (lw_problem_must_close(p) ? p->n : 0)
         + (p->min_transmission > 0 ? lw_problem_transmission_postures(p) : 0) + (p->max_acceleration > 0 ? LW_CURVE_SAMPLES : 0)
         + p->n_zone_condition;
}

size_t lw_problem_constraint_most(const lw_problem *p)
{
    return (size_t)p->n_linear + (size_t)p->n_side_known + p->n + 2*LW_CURVE_SAMPLES + p->n_zone_condition;
}

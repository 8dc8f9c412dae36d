/* Recognise the plans of lw_fast_dyad by their steps. */
#include "mbs/plan/plan_internal.h"

/* The step of output o that computes this register; NULL for the ground frame. */
static const lw_step *maker(const lw_plan *p, int o, int reg)
{
    for (int i = 0; i < p->n_output_step[o]; i++) {
        const lw_step *s = &p->step[p->output_step[o][i]];
        for (int h = 0; h < 4; h++)
            if (s->out[h] == reg)
                return s;
    }
    return NULL;
}

/* Is the register the ground point (x, 0) (axis 0) or (0, y) (axis 1)?  *dim: number of x or y, -1 at the origin. */
static bool ground_point(const lw_plan *p, int o, int reg, int axis, int *dim)
{
    *dim = -1;
    if (reg == LW_ORIGIN_REG)
        return true;
    const lw_step *s = maker(p, o, reg);
    if (!s || s->kind != LW_STEP_POINT || s->in[0] != LW_ORIGIN_REG || s->in[1] != LW_AXIS_REG || s->dim[1 - axis] >= 0)
        return false;
    *dim = s->dim[axis];
    return true;
}

static bool ground_line(const lw_plan *p, int o, int q, int w, lw_fast_dyad *f)
{
    f->beta = -1;
    if (w == LW_AXIS_REG)
        return ground_point(p, o, q, 1, &f->e);
    const lw_step *s = maker(p, o, w);
    if (!s || s->kind != LW_STEP_LINE || s->in[0] != LW_ORIGIN_REG || s->in[1] != LW_AXIS_REG || s->dim[0] >= 0)
        return false;
    f->e = -1;
    f->beta = s->dim[2];
    return true;
}

static bool driven_point(const lw_plan *p, int o, int reg, lw_fast_dyad *f)
{
    const lw_step *s = maker(p, o, reg);
    f->r2 = f->e_in = -1;
    if (!s)
        return false;
    if (p->input_is_slider)
        return s->kind == LW_STEP_INPUT_SLIDE && s->in[1] == LW_AXIS_REG && ground_point(p, o, s->in[0], 1, &f->e_in);
    const lw_step *turn = maker(p, o, s->in[1]);
    f->r2 = s->dim[0];
    return s->kind == LW_STEP_POINT && s->in[0] == LW_ORIGIN_REG && s->dim[0] >= 0 && s->dim[1] < 0 &&
           turn && turn->kind == LW_STEP_INPUT_PIN;
}

/* beta holds a number in plan.angle, like dim[2] of LINE. */
lw_fast_dyad lw_plan_find_fast_dyad(const lw_plan *p, int o)
{
    lw_fast_dyad f = { false, LW_STEP_RRR, -1, -1, -1, -1, -1, -1, -1 };
    const lw_step *dyad = maker(p, o, p->output_dir[o]);
    if (!dyad || dyad->dyad < 0 || dyad->out[0] != p->output_dir[o] ||
        p->link_origin[p->output_link[o]] != dyad->in[0] || !driven_point(p, o, dyad->in[0], &f))
        return f;
    f.dyad = dyad->kind;
    f.d1 = dyad->dim[0];
    f.d2 = dyad->dim[1];
    if (f.dyad == LW_STEP_RRP)
        f.applies = ground_line(p, o, dyad->in[1], dyad->in[2], &f);
    else
        f.applies = ground_point(p, o, dyad->in[1], 0, &f.b);
    return f;
}

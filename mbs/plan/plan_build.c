/* Add registers, steps and dimensions to a plan that is being made; look up points and lines of known links, and add
 * the steps for them when they are missing. */
#include "mbs/plan/plan_build_internal.h"

#include <stdio.h>

/* ---- growing the plan -------------------------------------------------------------------------- */

int lw_build_reg(lw_builder *b)
{
    if (b->p->n_reg == LW_REG_MAX) {
        b->full = true;
        return 0;
    }
    return b->p->n_reg++;
}

lw_step *lw_build_step(lw_builder *b, lw_step_kind kind)
{
    if (b->p->n_step == LW_STEP_MAX) {
        b->full = true;
        b->p->n_step--;
    }
    lw_step *s = &b->p->step[b->p->n_step++];
    *s = (lw_step){ kind, { -1, -1, -1, -1 }, { -1, -1, -1, -1 }, { -1, -1, -1 }, -1, { 0, 0 } };
    return s;
}

/* Name a dimension as mbs/plan/plan.h says. */
static void name_dim(const lw_builder *b, lw_dim_info *d, int number, int count)
{
    static const char *const stem[] = { "r", "x", "y", "e", "beta", "phi", "rho", "s", "mu", "cx", "cy", "x0", "y0",
                                        "theta0" };
    const char *s = stem[d->role];
    switch (d->role) {
    case LW_ROLE_X: case LW_ROLE_Y: snprintf(d->name, sizeof d->name, "%s%d_%d", s, b->number[d->link], number); break;
    case LW_ROLE_R: case LW_ROLE_E: case LW_ROLE_BETA:
    case LW_ROLE_PHASE: case LW_ROLE_PITCH: case LW_ROLE_SHIFT: case LW_ROLE_MIDDLE:
        if (count == 0)
            snprintf(d->name, sizeof d->name, "%s%d", s, b->number[d->link]);
        else
            snprintf(d->name, sizeof d->name, "%s%d_%d", s, b->number[d->link], number);
        break;
    case LW_ROLE_CX: case LW_ROLE_CY:
        if (count == 0)
            snprintf(d->name, sizeof d->name, "%s", s);
        else
            snprintf(d->name, sizeof d->name, "%s%d", s, count + 1);
        break;
    default: snprintf(d->name, sizeof d->name, "%s", s);
    }
}

/* Sort key of a dimension: links, then ground slides, then tracers, then the frame. */
static int place_of(const lw_builder *b, const lw_dim_info *d)
{
    bool line = d->role == LW_ROLE_E || d->role == LW_ROLE_BETA;
    int group = d->role >= LW_ROLE_X0 ? 3 : d->role >= LW_ROLE_CX ? 2 : line && d->link == b->t->k->ground ? 1 : 0;
    return (group*64 + (group == 0 ? b->number[d->link] : 0))*LW_DIM_MAX;
}

int lw_build_dim(lw_builder *b, lw_dim_role role, int link, int joint, int count)
{
    static const lw_dim_kind kind[] = {
        LW_DIM_LENGTH, LW_DIM_COORDINATE, LW_DIM_COORDINATE, LW_DIM_COORDINATE, LW_DIM_ANGLE, LW_DIM_ANGLE,
        LW_DIM_COORDINATE, LW_DIM_COORDINATE, LW_DIM_ANGLE, LW_DIM_COORDINATE, LW_DIM_COORDINATE, LW_DIM_COORDINATE,
        LW_DIM_COORDINATE, LW_DIM_ANGLE
    };
    lw_plan *p = b->p;
    for (int d = 0; d < p->n_dim; d++)
        if (p->dim[d].role == role && p->dim[d].link == link && p->dim[d].joint == joint)
            return d;
    if (p->n_dim == LW_DIM_MAX) {
        b->full = true;
        return 0;
    }
    lw_dim_info *d = &p->dim[p->n_dim];
    *d = (lw_dim_info){ .kind = kind[role], .link = link, .role = role, .joint = joint };
    if (role >= LW_ROLE_E && role <= LW_ROLE_MIDDLE)
        count = b->n_named[link][role - LW_ROLE_E]++;
    name_dim(b, d, joint + 1, count);
    b->place[p->n_dim] = place_of(b, d) + p->n_dim;
    return p->n_dim++;
}

void lw_build_slider(lw_builder *b, int j, int base, int ref)
{
    if (!lw_build_is_slider(b, j))
        return;
    b->p->slider_base[j] = base;
    b->p->slider_ref[j] = ref;
}

/* The first joint of a link other than the pin it turns on, in the order of lw_linkage_posture_input. */
static int next_joint(const lw_topology *t, int link, int pin)
{
    const lw_linkage *k = t->k;
    lw_vec2 at = k->joint[pin].at;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *q = &k->joint[j];
        if (t->slot[j] >= 0 && lw_joint_has(&k->joint[t->slot[j]], link))
            return t->slot[j];
        if (j != pin && !lw_joint_has_ratio(q->kind) && lw_joint_has(q, link) &&
            (lw_joint_translates(q->kind) || q->at.x != at.x || q->at.y != at.y))
            return j;
    }
    return -1;
}

static int first_tracer(const lw_topology *t, int link)
{
    for (int i = 0; i < t->k->n_tracer; i++)
        if (t->k->tracer[i].link == link)
            return i;
    return -1;
}

lw_frame lw_build_turning_frame(const lw_builder *b, int link, int pin)
{
    const lw_topology *t = b->t;
    int j = next_joint(t, link, pin);
    return (lw_frame){ t->pin[pin], { -1, -1 }, j < 0 || lw_build_is_slider(b, j) ? j : t->pin[j],
                       first_tracer(t, link) };
}

/* ---- points and lines of known links ------------------------------------------------------------ */

int lw_build_point(lw_builder *b, int link, int dim_x, int dim_y)
{
    lw_step *s = lw_build_step(b, LW_STEP_POINT);
    s->in[0] = b->p->link_origin[link];
    s->in[1] = b->p->link_dir[link];
    s->dim[0] = dim_x;
    s->dim[1] = dim_y;
    return s->out[0] = lw_build_reg(b);
}

void lw_build_pin_dims(lw_builder *b, int link, int pin, int *x, int *y)
{
    const lw_frame *f = &b->p->frame[link];
    *x = *y = -1;
    if (f->origin == pin)
        return;
    bool axis = f->axis == pin;
    *x = lw_build_dim(b, axis ? LW_ROLE_R : LW_ROLE_X, link, pin, 0);
    if (!axis)
        *y = lw_build_dim(b, LW_ROLE_Y, link, pin, 0);
}

int lw_build_pin(lw_builder *b, int joint, int base)
{
    int pin = b->t->pin[joint], x, y;
    if (b->pin_reg[pin] >= 0)
        return b->pin_reg[pin];
    lw_build_pin_dims(b, base, pin, &x, &y);
    return b->pin_reg[pin] = x < 0 ? b->p->link_origin[base] : lw_build_point(b, base, x, y);
}

/* A line through the origin needs no offset: a line that defines the origin, or one whose sliding link has no pin to
 * measure from.  The line along the axis needs no angle. */
void lw_build_line_dims(lw_builder *b, int j, int base, int *e, int *beta)
{
    const lw_frame *f = &b->p->frame[base];
    bool defines = f->origin < 0 && (f->meet[0] == j || f->meet[1] == j);
    *e = defines || b->p->slider_ref[j] < 0 ? -1 : lw_build_dim(b, LW_ROLE_E, base, j, 0);
    *beta = f->axis == j ? -1 : lw_build_dim(b, LW_ROLE_BETA, base, j, 0);
}

void lw_build_line(lw_builder *b, int j, int base, int *q, int *w)
{
    int e, beta;
    lw_build_line_dims(b, j, base, &e, &beta);
    *q = b->p->link_origin[base];
    *w = b->p->link_dir[base];
    if (beta >= 0) {
        lw_step *s = lw_build_step(b, LW_STEP_LINE);
        s->in[0] = *q;
        s->in[1] = *w;
        s->dim[0] = e;
        s->dim[1] = beta;
        *q = s->out[0] = lw_build_reg(b);
        *w = s->out[1] = lw_build_reg(b);
    } else if (e >= 0)
        *q = lw_build_point(b, base, -1, e);
    b->p->slider_dir[j] = *w;
}

void lw_build_link(lw_builder *b, int link, int origin, int dir)
{
    b->p->link_origin[link] = origin;
    b->p->link_dir[link] = dir;
}

void lw_build_ride(lw_builder *b, int link, int q, int w, int along)
{
    int pin = b->p->frame[link].origin;
    lw_step *s = lw_build_step(b, LW_STEP_SLIDE);
    s->in[0] = q;
    s->in[1] = w;
    s->in[2] = along;
    lw_build_link(b, link, s->out[0] = lw_build_reg(b), w);
    if (pin >= 0 && b->pin_reg[pin] < 0)
        b->pin_reg[pin] = s->out[0];
}

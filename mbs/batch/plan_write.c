/* The inverse of lw_plan_read: move a linkage into a posture of its plan; move the seeds of higher groups to another
 * posture. */
#include "mbs/batch/kernels_internal.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/dyad_internal.h"
#include "mbs/plan/plan_internal.h"

#include <string.h>

/* The new posture. */
typedef struct placed { const lw_plan *p; lw_vec2 o[LW_LINK_MAX], d[LW_LINK_MAX], reg[LW_REG_MAX], turn; } placed;

static void place(const lw_plan *p, const double *dim, placed *q)
{
    lw_vec2 z0 = lw_v2(dim[p->i_x0], dim[p->i_y0]);
    q->p = p;
    q->turn = lw_v2_polar(1, dim[p->i_theta0]);
    for (int i = 0; i < p->n_link; i++) {
        int link = p->link[i];
        q->o[link] = lw_v2_add(z0, lw_v2_turn(q->reg[p->link_origin[link]], q->turn));
        q->d[link] = lw_v2_turn(q->reg[p->link_dir[link]], q->turn);
    }
}

static lw_vec2 in_plane(const placed *q, const double *dim, int reg)
{
    return lw_v2_add(lw_v2(dim[q->p->i_x0], dim[q->p->i_y0]), lw_v2_turn(q->reg[reg], q->turn));
}

/* The new place of a slide point.  A point at the pin stays at the pin.  Any other point keeps its distance from the
 * path of the pin and its place along the path, in the frame of link[0]. */
static lw_vec2 move_slide(const lw_linkage *linkage, const lw_frames *f, const placed *q, const double *dim, int j)
{
    const lw_plan *p = q->p;
    int link = linkage->joint[j].link[0], rider = lw_joint_other(&linkage->joint[j], p->slider_base[j]);
    lw_vec2 ref = p->slider_ref[j] >= 0 ? linkage->joint[p->slider_ref[j]].at : f->o[rider];
    lw_vec2 at = linkage->joint[j].at, ref1 = in_plane(q, dim, p->joint_point[j]);
    lw_vec2 w = lw_plan_slide_direction(p, linkage, j), w1 = lw_v2_turn(q->reg[p->slider_dir[j]], q->turn);
    if (at.x == ref.x && at.y == ref.y)
        return ref1;
    double across = lw_v2_cross(w, lw_v2_sub(at, ref));
    double along = lw_v2_dot(lw_v2_sub(at, f->o[link]), w) - lw_v2_dot(lw_v2_sub(ref1, q->o[link]), w1);
    return lw_v2_add(ref1, lw_v2_turn(lw_v2(along, across), w1));
}

static void move_joints(const lw_frames *f, const placed *q, const double *dim, lw_linkage *linkage)
{
    const lw_linkage old = *linkage;
    for (int j = 0; j < linkage->n_joint; j++) {
        if (lw_joint_has_ratio(linkage->joint[j].kind))
            continue;
        if (!lw_joint_translates(linkage->joint[j].kind)) {
            linkage->joint[j].at = in_plane(q, dim, q->p->joint_point[j]);
            continue;
        }
        linkage->joint[j].at = move_slide(&old, f, q, dim, j);
        lw_vec2 w = lw_v2_turn(q->reg[q->p->slider_dir[j]], q->turn);
        linkage->joint[j].along = lw_v2_scale(w, q->p->slider_sign[j]);
    }
}

/* Set the ratios of racks, and the contacts of gears from the new pins of their wheels. */
static void move_gears(const lw_plan *p, const double *dim, lw_linkage *linkage)
{
    lw_gear g;
    for (int i = 0; i < p->n_dim; i++) {
        const lw_rack *r = p->rack;
        if (p->dim[i].role != LW_ROLE_PITCH)
            continue;
        while (r->joint != p->dim[i].joint)
            r++;
        linkage->joint[r->joint].ratio = r->side ? r->sign*dim[i] : r->sign/lw_away_from_zero(dim[i]);
    }
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_has_ratio(linkage->joint[j].kind) && lw_linkage_gear(linkage, j, &g, NULL) == LW_OK)
            linkage->joint[j].at = lw_gear_contact(linkage->joint, j, &g);
}

static void move_tracers(const lw_frames *f, const placed *q, const double *dim, lw_linkage *linkage)
{
    const lw_plan *p = q->p;
    for (int i = 0; i < linkage->n_tracer; i++) {
        int link = linkage->tracer[i].link;
        lw_vec2 turn = lw_v2_unturn(q->d[link], f->d[link]);
        linkage->tracer[i].at = lw_v2_add(q->o[link], lw_v2_turn(lw_v2_sub(linkage->tracer[i].at, f->o[link]), turn));
        linkage->tracer[i].angle += atan2(turn.y, turn.x);
    }
    for (int o = 0; o < p->n_output; o++)
        linkage->tracer[p->output_tracer[o]].at = in_plane(q, dim, p->output_point[o]);
}

static lw_status write_wide(const lw_plan *p, const double *dim, const double *mode, double input, lw_linkage *linkage)
{
    lw_frames f;
    placed q;
    lw_status s = lw_plan_frames(p, linkage, &f, NULL);
    if (s != LW_OK)
        return s;
    for (int j = 0; j < linkage->n_joint; j++)
        if ((p->joint_point[j] < 0 && !lw_joint_has_ratio(linkage->joint[j].kind))
            || (lw_joint_translates(linkage->joint[j].kind) && p->slider_dir[j] < 0))
            return LW_E_ARG;
    s = lw_posture_registers(p, dim, mode, input, q.reg);
    if (s != LW_OK)
        return s;
    place(p, dim, &q);
    double before = lw_plan_read_input(p, linkage, &f),
           turned = dim[p->i_theta0] - atan2(f.d[linkage->ground].y, f.d[linkage->ground].x);
    if (p->input_link[0] != linkage->ground)
        turned = 0;
    move_joints(&f, &q, dim, linkage);
    move_gears(p, dim, linkage);
    move_tracers(&f, &q, dim, linkage);
    linkage->input[0].value += p->input_is_slider
                              ? input - before
                              : remainder(p->input_turns_per_period*(input - before) + turned, 2*LW_PI);
    return LW_OK;
}

lw_status lw_plan_write(const lw_plan *p, const double *dim, const double *mode, double input, lw_linkage *linkage)
{
    lw_linkage wide;
    int slot[LW_JOINT_MAX];
    lw_status s = lw_plan_expand(linkage, &wide, slot, NULL);
    if (s == LW_OK)
        s = write_wide(p, dim, mode, input, &wide);
    if (s != LW_OK)
        return s;
    double before[LW_INPUT_MAX];
    for (int i = 1; i < linkage->n_input; i++)
        before[i] = lw_linkage_posture_input(linkage, linkage->input[i].joint);
    for (int j = 0; j < linkage->n_joint; j++) {
        linkage->joint[j].at = wide.joint[j].at;
        linkage->joint[j].ratio = wide.joint[j].ratio;
        linkage->joint[j].along = wide.joint[slot[j] >= 0 ? slot[j] : j].along;
    }
    memcpy(linkage->tracer, wide.tracer, sizeof linkage->tracer);
    linkage->input[0].value = wide.input[0].value;
    for (int i = 1; i < linkage->n_input; i++)
        linkage->input[i].value
            += remainder(lw_linkage_posture_input(linkage, linkage->input[i].joint) - before[i], 2*LW_PI);
    return LW_OK;
}

lw_status lw_plan_seed(const lw_plan *plan, const double *dim, double input, double *mode)
{
    lw_group_posture at;
    if (!plan->n_higher)
        return LW_OK;
    lw_status s = lw_group_posture_find(plan, dim, mode, input, &at);
    if (s != LW_OK)
        return s;
    if (!(at.margin > 0))
        return LW_OPEN;
    double size = lw_plan_size(plan, dim);
    for (int i = 0; i < plan->n_higher; i++) {
        const lw_higher *g = &plan->higher[i];
        const double *row = at.row + g->first_row;
        double *to = mode + g->first_mode;
        for (int a = 0; a < g->n_turn; a++, row += 2)
            *to++ = atan2(row[1], row[0]);
        for (int d = 0; d < g->n_disp; d++)
            *to++ = *row++/size;
    }
    mode[plan->n_mode - 1] = input;
    return LW_OK;
}

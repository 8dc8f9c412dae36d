/* Numbers from a posture and a posture from numbers. */
#include "mbs/plan/plan_internal.h"
#include "mbs/plan/dyad_internal.h"

#include <string.h>

/* The frames of the plan's links in the posture of a linkage, in the plane. */
typedef struct frames { lw_vec2 o[LW_LINK_MAX], d[LW_LINK_MAX]; } frames;

/* ---- frames in a posture ------------------------------------------------------------------------ */

static lw_vec2 slide_direction(const lw_plan *p, const lw_linkage *k, int j)
{
    return lw_v2_scale(k->joint[j].along, p->slider_sign[j]);
}

static lw_vec2 unit(lw_vec2 a)
{
    double n = lw_v2_norm(a);
    return n > 0 ? lw_v2_scale(a, 1/n) : lw_v2(1, 0);
}

/* A point of slide line j: the pin whose path it is; else the origin of the link that has the line,
 * unless that origin is what we are after (link == base). */
static lw_vec2 line_point(const lw_plan *p, const lw_linkage *k, int j, int link, const frames *f)
{
    if (p->slider_ref[j] >= 0)
        return k->joint[p->slider_ref[j]].at;
    return p->slider_base[j] == link ? k->joint[j].at : f->o[p->slider_base[j]];
}

static lw_vec2 meeting_point(lw_vec2 p, lw_vec2 u, lw_vec2 q, lw_vec2 v)
{
    double s = lw_v2_cross(u, v);
    return lw_v2_add(p, lw_v2_scale(u, lw_v2_cross(lw_v2_sub(q, p), v)/s));
}

static lw_vec2 frame_origin(const lw_plan *p, const lw_linkage *k, int link, const frames *f)
{
    const lw_frame *r = &p->frame[link];
    if (r->origin >= 0)
        return k->joint[r->origin].at;
    lw_vec2 q = line_point(p, k, r->meet[0], link, f), w = slide_direction(p, k, r->meet[0]);
    if (r->meet[1] >= 0)
        return meeting_point(q, w, line_point(p, k, r->meet[1], link, f), slide_direction(p, k, r->meet[1]));
    if (r->meet[0] != p->input_joint)
        return q;
    return link == k->ground ? lw_v2_sub(q, lw_v2_scale(w, k->input[0].value))
                             : lw_v2_add(f->o[k->ground], lw_v2_scale(w, k->input[0].value));
}

static lw_status frame_axis(const lw_plan *p, const lw_linkage *k, int link, frames *f, lw_error *e)
{
    const lw_frame *r = &p->frame[link];
    lw_vec2 d = lw_v2(1, 0);
    if (r->axis < 0 && r->axis_tracer >= 0)
        d = unit(lw_v2_sub(k->tracer[r->axis_tracer].at, f->o[link]));
    if (r->axis >= 0 && k->joint[r->axis].kind == LW_JOINT_SLIDER)
        d = slide_direction(p, k, r->axis);
    else if (r->axis >= 0) {
        d = lw_v2_sub(k->joint[r->axis].at, f->o[link]);
        if (!(lw_v2_norm(d) > 0))
            return lw_error_set(e, LW_E_ARG, "pins \"%s\" and \"%s\" of link \"%s\" lie at one place, so that their distance "
                                "gives no direction", k->joint[r->origin < 0 ? r->axis : r->origin].name,
                                k->joint[r->axis].name, k->link_name[link]);
        d = unit(d);
    }
    f->d[link] = d;
    return LW_OK;
}

static lw_status check_same(const lw_plan *p, const lw_linkage *k, lw_error *e)
{
    double size = 0;
    for (int j = 0; j < k->n_joint; j++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(k->joint[j].at, k->joint[0].at)));
    for (int j = 0; j < k->n_joint; j++) {
        if (p->joint_pin[j] < 0 || (k->joint[j].kind == LW_JOINT_SLIDER) != (p->slider_base[j] >= 0))
            return lw_error_set(e, LW_E_ARG, "joint \"%s\" is not of the topology of the plan", k->joint[j].name);
        if (lw_v2_norm(lw_v2_sub(k->joint[j].at, k->joint[p->joint_pin[j]].at)) > 1e-12*size)
            return lw_error_set(e, LW_E_ARG, "joints \"%s\" and \"%s\" are one pin in the plan, but not in this posture",
                                k->joint[j].name, k->joint[p->joint_pin[j]].name);
    }
    return LW_OK;
}

/* Of a linkage with dies in its slots. */
static lw_status frames_of(const lw_plan *p, const lw_linkage *k, frames *f, lw_error *e)
{
    lw_status s = check_same(p, k, e);
    for (int i = 0; s == LW_OK && i < p->n_link; i++) {
        f->o[p->link[i]] = frame_origin(p, k, p->link[i], f);
        s = frame_axis(p, k, p->link[i], f, e);
    }
    return s;
}

/* ---- reading ------------------------------------------------------------------------------------ */

static double angle_of(lw_vec2 u) { return atan2(u.y, u.x); }

/* How a rack stands to its pinion. */
typedef struct meshing { double rho, angle, along; } meshing;

static meshing read_rack(const lw_plan *p, const lw_linkage *k, const frames *f, int joint)
{
    const lw_rack *r = p->rack;
    while (r->joint != joint)
        r++;
    int base = p->slider_base[r->slider], rider = lw_joint_other(&k->joint[r->slider], base);
    double ratio = k->joint[joint].ratio, metres = r->side ? ratio : 1/ratio;
    return (meshing){ r->sign*metres, angle_of(lw_v2_unturn(f->d[r->pinion], f->d[r->carrier])),
                      lw_v2_dot(lw_v2_sub(f->o[rider], f->o[base]), slide_direction(p, k, r->slider)) };
}

static double read_dim(const lw_plan *p, const lw_linkage *k, const frames *f, const lw_dim_info *d)
{
    lw_vec2 o = f->o[d->link], u = f->d[d->link], w;
    int j = d->joint;
    meshing m;
    switch (d->role) {
    case LW_ROLE_R:  return lw_v2_norm(lw_v2_sub(k->joint[j].at, o));
    case LW_ROLE_X:  return lw_v2_unturn(lw_v2_sub(k->joint[j].at, o), u).x;
    case LW_ROLE_Y:  return lw_v2_unturn(lw_v2_sub(k->joint[j].at, o), u).y;
    case LW_ROLE_E:
        w = slide_direction(p, k, j);
        return lw_v2_cross(w, lw_v2_sub(line_point(p, k, j, d->link, f), o));
    case LW_ROLE_BETA: return angle_of(lw_v2_unturn(slide_direction(p, k, j), u));
    case LW_ROLE_PITCH:  return read_rack(p, k, f, j).rho;
    case LW_ROLE_MIDDLE: return read_rack(p, k, f, j).angle;
    case LW_ROLE_SHIFT:
        m = read_rack(p, k, f, j);
        return m.along - m.rho*m.angle;
    case LW_ROLE_CX: return lw_v2_unturn(lw_v2_sub(k->tracer[j].at, o), u).x;
    case LW_ROLE_CY: return lw_v2_unturn(lw_v2_sub(k->tracer[j].at, o), u).y;
    case LW_ROLE_X0: return o.x;
    case LW_ROLE_Y0: return o.y;
    default:         return angle_of(u);
    }
}

static int link_with(const lw_plan *p, int reg)
{
    for (int i = 0; i < p->n_link; i++)
        if (p->link_dir[p->link[i]] == reg)
            return p->link[i];
    return -1;
}

/* What a wheel is turned beyond what its gear makes of the input, or of carrier and partner. */
static double read_phase(const lw_plan *p, const frames *f, const lw_step *s, double input)
{
    lw_vec2 ground = f->d[p->link[0]];
    double turn = angle_of(lw_v2_unturn(f->d[p->dim[s->dim[0]].link], ground));
    if (s->in[1] < 0)
        return remainder(turn - s->power[0]*input, 2*LW_PI);
    for (int h = 0; h < 2; h++)
        turn -= s->power[h]*angle_of(lw_v2_unturn(f->d[link_with(p, s->in[h])], ground));
    return remainder(turn, 2*LW_PI);
}

/* Of wheels in higher groups. */
static void read_phases(const lw_plan *p, const frames *f, double *dim)
{
    for (int i = 0; i < p->n_higher; i++)
        for (int h = 0; h < p->higher[i].n_gear; h++) {
            const lw_higher_gear *g = &p->higher[i].gear[h];
            double turn = 0;
            for (int a = 0; a < g->n_term; a++)
                turn += g->power[a]*angle_of(lw_v2_unturn(f->d[g->link[a]], f->d[p->link[0]]));
            if (g->phase >= 0)
                dim[g->phase] = remainder(turn, 2*LW_PI)/g->count;
        }
}

/* Signs as at lw_dyad in mbs/plan/plan.h. */
static double read_mode(const lw_plan *p, const lw_linkage *k, const lw_step *s)
{
    const int *j = p->dyad[s->dyad].joint;
    lw_vec2 a = k->joint[j[0]].at, c = k->joint[j[1]].at, b = k->joint[j[2]].at;
    double side = 1;
    if (s->kind == LW_STEP_RRR)
        side = lw_v2_cross(lw_v2_sub(b, a), lw_v2_sub(c, a));
    if (s->kind == LW_STEP_RRP && k->joint[j[0]].kind == LW_JOINT_SLIDER)
        side = lw_v2_dot(lw_v2_sub(c, b), slide_direction(p, k, j[0]));
    else if (s->kind == LW_STEP_RRP)
        side = lw_v2_dot(lw_v2_sub(c, a), slide_direction(p, k, j[2]));
    if (s->kind == LW_STEP_RPR)
        side = lw_v2_dot(lw_v2_sub(b, a), slide_direction(p, k, j[1]));
    return side < 0 ? -1 : 1;
}

static double read_input(const lw_plan *p, const lw_linkage *k, const frames *f)
{
    int from = p->input_link[0], to = p->input_link[1];
    if (!p->input_is_slider)
        return angle_of(lw_v2_unturn(f->d[to], f->d[from]))/p->laps;
    return lw_v2_dot(lw_v2_sub(f->o[to], f->o[from]), slide_direction(p, k, p->input_joint));
}

double lw_plan_size(const lw_plan *p, const double *dim)
{
    double sum = 0;
    int n = 0;
    for (int d = 0; d < p->n_dim; d++)
        if (p->dim[d].kind != LW_DIM_ANGLE && d != p->i_x0 && d != p->i_y0) {
            sum += fabs(dim[d]);
            n++;
        }
    return sum > 0 ? sum/n : 1;
}

/* The seeds of the higher groups: where their links are in this posture. */
static void read_seeds(const lw_plan *p, const lw_linkage *k, const frames *f, const double *dim, double input, double *mode)
{
    double size = lw_plan_size(p, dim);
    for (int i = 0; i < p->n_higher; i++) {
        const lw_higher *g = &p->higher[i];
        double *to = mode + g->first_mode;
        for (int a = 0; a < g->n_turn; a++)
            *to++ = angle_of(lw_v2_unturn(f->d[g->turn_link[a]], f->d[k->ground]));
        for (int d = 0; d < g->n_disp; d++) {
            int j = g->disp_joint[d], base = p->slider_base[j], rider = lw_joint_other(&k->joint[j], base);
            *to++ = lw_v2_dot(lw_v2_sub(f->o[rider], f->o[base]), slide_direction(p, k, j))/size;
        }
    }
    if (p->n_higher)
        mode[p->n_mode - 1] = input;
}

static lw_status read_wide(const lw_plan *p, const lw_linkage *k, double *dim, double *mode, double *input, lw_error *e)
{
    frames f;
    lw_status s = frames_of(p, k, &f, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < p->n_dim; i++) {
        dim[i] = read_dim(p, k, &f, &p->dim[i]);
        if (!isfinite(dim[i]))
            return lw_error_set(e, LW_E_ARG, "dimension %s of link \"%s\" is not finite in this posture: two slides are parallel",
                                p->dim[i].name, k->link_name[p->dim[i].link]);
    }
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].dyad >= 0)
            mode[p->step[i].dyad] = read_mode(p, k, &p->step[i]);
    *input = read_input(p, k, &f);
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].kind == LW_STEP_GEAR && p->step[i].dim[0] >= 0)
            dim[p->step[i].dim[0]] = read_phase(p, &f, &p->step[i], *input);
    read_phases(p, &f, dim);
    read_seeds(p, k, &f, dim, *input, mode);
    return LW_OK;
}

lw_status lw_plan_read(const lw_plan *p, const lw_linkage *k, double *dim, double *mode, double *input, lw_error *e)
{
    lw_linkage wide;
    lw_status s = lw_plan_expand(k, &wide, NULL, e);
    return s == LW_OK ? read_wide(p, &wide, dim, mode, input, e) : s;
}

/* ---- writing ------------------------------------------------------------------------------------ */

/* The new posture: registers moved into the plane. */
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

/* A slide line keeps its place on the path when it was drawn at the pin; otherwise its distance from
 * the path and its place along it, in the frame of link[0]. */
static lw_vec2 move_slide(const lw_linkage *k, const frames *f, const placed *q, const double *dim, int j)
{
    const lw_plan *p = q->p;
    int link = k->joint[j].link[0], rider = lw_joint_other(&k->joint[j], p->slider_base[j]);
    lw_vec2 ref = p->slider_ref[j] >= 0 ? k->joint[p->slider_ref[j]].at : f->o[rider];
    lw_vec2 at = k->joint[j].at, ref1 = in_plane(q, dim, p->joint_point[j]);
    lw_vec2 w = slide_direction(p, k, j), w1 = lw_v2_turn(q->reg[p->slider_dir[j]], q->turn);
    if (at.x == ref.x && at.y == ref.y)
        return ref1;
    double across = lw_v2_cross(w, lw_v2_sub(at, ref));
    double along = lw_v2_dot(lw_v2_sub(at, f->o[link]), w) - lw_v2_dot(lw_v2_sub(ref1, q->o[link]), w1);
    return lw_v2_add(ref1, lw_v2_turn(lw_v2(along, across), w1));
}

static void move_joints(const frames *f, const placed *q, const double *dim, lw_linkage *k)
{
    const lw_linkage old = *k;
    for (int j = 0; j < k->n_joint; j++) {
        if (k->joint[j].kind == LW_JOINT_GEAR)
            continue;
        if (k->joint[j].kind != LW_JOINT_SLIDER) {
            k->joint[j].at = in_plane(q, dim, q->p->joint_point[j]);
            continue;
        }
        k->joint[j].at = move_slide(&old, f, q, dim, j);
        lw_vec2 w = lw_v2_turn(q->reg[q->p->slider_dir[j]], q->turn);
        k->joint[j].along = lw_v2_scale(w, q->p->slider_sign[j]);
    }
}

/* Ratios of racks; contacts of gears, once the pins of their wheels stand. */
static void move_gears(const lw_plan *p, const double *dim, lw_linkage *k)
{
    lw_gear g;
    for (int i = 0; i < p->n_dim; i++) {
        const lw_rack *r = p->rack;
        if (p->dim[i].role != LW_ROLE_PITCH)
            continue;
        while (r->joint != p->dim[i].joint)
            r++;
        k->joint[r->joint].ratio = r->side ? r->sign*dim[i] : r->sign/lw_away_from_zero(dim[i]);
    }
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].kind == LW_JOINT_GEAR && lw_linkage_gear(k, j, &g, NULL) == LW_OK)
            k->joint[j].at = lw_linkage_contact(k, j, &g);
}

static void move_tracers(const frames *f, const placed *q, const double *dim, lw_linkage *k)
{
    const lw_plan *p = q->p;
    for (int i = 0; i < k->n_tracer; i++) {
        int link = k->tracer[i].link;
        lw_vec2 turn = lw_v2_unturn(q->d[link], f->d[link]);
        k->tracer[i].at = lw_v2_add(q->o[link], lw_v2_turn(lw_v2_sub(k->tracer[i].at, f->o[link]), turn));
        k->tracer[i].angle += angle_of(turn);
    }
    for (int o = 0; o < p->n_output; o++)
        k->tracer[p->output_tracer[o]].at = in_plane(q, dim, p->output_point[o]);
}

static lw_status write_wide(const lw_plan *p, const double *dim, const double *mode, double input, lw_linkage *k)
{
    frames f;
    placed q;
    lw_status s = frames_of(p, k, &f, NULL);
    if (s != LW_OK)
        return s;
    for (int j = 0; j < k->n_joint; j++)
        if ((p->joint_point[j] < 0 && k->joint[j].kind != LW_JOINT_GEAR) || (k->joint[j].kind == LW_JOINT_SLIDER && p->slider_dir[j] < 0))
            return LW_E_ARG;
    if (lw_pose_registers(p, dim, mode, input, q.reg) < 0)
        return LW_OPEN;
    place(p, dim, &q);
    double before = read_input(p, k, &f), turned = dim[p->i_theta0] - angle_of(f.d[k->ground]);
    if (p->input_link[0] != k->ground)
        turned = 0;
    move_joints(&f, &q, dim, k);
    move_gears(p, dim, k);
    move_tracers(&f, &q, dim, k);
    k->input[0].value += p->input_is_slider ? input - before
                                                  : remainder(p->laps*(input - before) + turned, 2*LW_PI);
    return LW_OK;
}

lw_status lw_plan_write(const lw_plan *p, const double *dim, const double *mode, double input, lw_linkage *k)
{
    lw_linkage wide;
    int slot[LW_JOINT_MAX];
    lw_status s = lw_plan_expand(k, &wide, slot, NULL);
    if (s == LW_OK)
        s = write_wide(p, dim, mode, input, &wide);
    if (s != LW_OK)
        return s;
    double before[LW_INPUT_MAX];
    for (int i = 1; i < k->n_input; i++)
        before[i] = lw_linkage_posture_input(k, k->input[i].joint);
    for (int j = 0; j < k->n_joint; j++) {
        k->joint[j].at = wide.joint[j].at;
        k->joint[j].ratio = wide.joint[j].ratio;
        k->joint[j].along = wide.joint[slot[j] >= 0 ? slot[j] : j].along;
    }
    memcpy(k->tracer, wide.tracer, sizeof k->tracer);
    k->input[0].value = wide.input[0].value;
    for (int i = 1; i < k->n_input; i++)
        k->input[i].value += remainder(lw_linkage_posture_input(k, k->input[i].joint) - before[i], 2*LW_PI);
    return LW_OK;
}

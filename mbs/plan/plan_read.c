/* Read dimensions, modes and input off a posture. */
#include "mbs/plan/plan_internal.h"
#include "mbs/plan/dyad_internal.h"

#include <string.h>

/* ---- frames in a posture ------------------------------------------------------------------------ */

lw_vec2 lw_plan_slide_direction(const lw_plan *p, const lw_linkage *linkage, int j)
{
    return lw_v2_scale(linkage->joint[j].along, p->slider_sign[j]);
}

static lw_vec2 unit(lw_vec2 a)
{
    double n = lw_v2_norm(a);
    return n > 0 ? lw_v2_scale(a, 1/n) : lw_v2(1, 0);
}

/* A point of slide line j: the pin whose path it is, else the origin of the link that carries the line.  When that
 * origin is the one to be found (link is the carrier) it is the joint's own point. */
static lw_vec2 line_point(const lw_plan *p, const lw_linkage *linkage, int j, int link, const lw_frames *f)
{
    if (p->slider_ref[j] >= 0)
        return linkage->joint[p->slider_ref[j]].at;
    return p->slider_base[j] == link ? linkage->joint[j].at : f->o[p->slider_base[j]];
}

static lw_vec2 meeting_point(lw_vec2 p, lw_vec2 u, lw_vec2 q, lw_vec2 v)
{
    double s = lw_v2_cross(u, v);
    return lw_v2_add(p, lw_v2_scale(u, lw_v2_cross(lw_v2_sub(q, p), v)/s));
}

static lw_vec2 frame_origin(const lw_plan *p, const lw_linkage *linkage, int link, const lw_frames *f)
{
    const lw_frame *r = &p->frame[link];
    if (r->origin >= 0)
        return linkage->joint[r->origin].at;
    lw_vec2 q = line_point(p, linkage, r->meet[0], link, f), w = lw_plan_slide_direction(p, linkage, r->meet[0]);
    if (r->meet[1] >= 0)
        return meeting_point(q, w, line_point(p, linkage, r->meet[1], link, f), lw_plan_slide_direction(p, linkage, r->meet[1]));
    if (r->meet[0] != p->input_joint)
        return q;
    return link == linkage->ground ? lw_v2_sub(q, lw_v2_scale(w, linkage->input[0].value))
                             : lw_v2_add(f->o[linkage->ground], lw_v2_scale(w, linkage->input[0].value));
}

static lw_status frame_axis(const lw_plan *p, const lw_linkage *linkage, int link, lw_frames *f, lw_error *e)
{
    const lw_frame *r = &p->frame[link];
    lw_vec2 d = lw_v2(1, 0);
    if (r->axis < 0 && r->axis_tracer >= 0)
        d = unit(lw_v2_sub(linkage->tracer[r->axis_tracer].at, f->o[link]));
    if (r->axis >= 0 && lw_joint_translates(linkage->joint[r->axis].kind))
        d = lw_plan_slide_direction(p, linkage, r->axis);
    else if (r->axis >= 0) {
        d = lw_v2_sub(linkage->joint[r->axis].at, f->o[link]);
        if (!(lw_v2_norm(d) > 0))
            return lw_error_set(e, LW_E_ARG,
                                "pins \"%s\" and \"%s\" of link \"%s\" lie at one place, so that their distance "
                                "gives no direction", linkage->joint[r->origin < 0 ? r->axis : r->origin].name,
                                linkage->joint[r->axis].name, linkage->link_name[link]);
        d = unit(d);
    }
    f->d[link] = d;
    return LW_OK;
}

static lw_status check_same(const lw_plan *p, const lw_linkage *linkage, lw_error *e)
{
    double size = 0;
    for (int j = 0; j < linkage->n_joint; j++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(linkage->joint[j].at, linkage->joint[0].at)));
    for (int j = 0; j < linkage->n_joint; j++) {
        if (p->joint_pin[j] < 0 || (lw_joint_translates(linkage->joint[j].kind)) != (p->slider_base[j] >= 0))
            return lw_error_set(e, LW_E_ARG, "joint \"%s\" is not of the topology of the plan", linkage->joint[j].name);
        if (lw_v2_norm(lw_v2_sub(linkage->joint[j].at, linkage->joint[p->joint_pin[j]].at)) > 1e-12*size)
            return lw_error_set(e, LW_E_ARG,
                                "joints \"%s\" and \"%s\" are one pin in the plan, but not in this posture",
                                linkage->joint[j].name, linkage->joint[p->joint_pin[j]].name);
    }
    return LW_OK;
}

lw_status lw_plan_frames(const lw_plan *p, const lw_linkage *linkage, lw_frames *f, lw_error *e)
{
    lw_status s = check_same(p, linkage, e);
    for (int i = 0; s == LW_OK && i < p->n_link; i++) {
        f->o[p->link[i]] = frame_origin(p, linkage, p->link[i], f);
        s = frame_axis(p, linkage, p->link[i], f, e);
    }
    return s;
}

/* ---- reading ------------------------------------------------------------------------------------ */

static double angle_of(lw_vec2 u) { return atan2(u.y, u.x); }

/* The radius of a rack's pinion (signed), the angle of the pinion on the carrier, the displacement of the rack. */
typedef struct meshing { double rho, angle, along; } meshing;

static meshing read_rack(const lw_plan *p, const lw_linkage *linkage, const lw_frames *f, int joint)
{
    const lw_rack *r = p->rack;
    while (r->joint != joint)
        r++;
    int base = p->slider_base[r->slider], rider = lw_joint_other(&linkage->joint[r->slider], base);
    double ratio = linkage->joint[joint].ratio, metres = r->side ? ratio : 1/ratio;
    return (meshing){ r->sign*metres, angle_of(lw_v2_unturn(f->d[r->pinion], f->d[r->carrier])),
                      lw_v2_dot(lw_v2_sub(f->o[rider], f->o[base]), lw_plan_slide_direction(p, linkage, r->slider)) };
}

static double read_dim(const lw_plan *p, const lw_linkage *linkage, const lw_frames *f, const lw_dim_info *d)
{
    lw_vec2 o = f->o[d->link], u = f->d[d->link], w;
    int j = d->joint;
    meshing m;
    switch (d->role) {
    case LW_ROLE_R:  return lw_v2_norm(lw_v2_sub(linkage->joint[j].at, o));
    case LW_ROLE_X:  return lw_v2_unturn(lw_v2_sub(linkage->joint[j].at, o), u).x;
    case LW_ROLE_Y:  return lw_v2_unturn(lw_v2_sub(linkage->joint[j].at, o), u).y;
    case LW_ROLE_E:
        w = lw_plan_slide_direction(p, linkage, j);
        return lw_v2_cross(w, lw_v2_sub(line_point(p, linkage, j, d->link, f), o));
    case LW_ROLE_BETA: return angle_of(lw_v2_unturn(lw_plan_slide_direction(p, linkage, j), u));
    case LW_ROLE_PITCH:  return read_rack(p, linkage, f, j).rho;
    case LW_ROLE_MIDDLE: return read_rack(p, linkage, f, j).angle;
    case LW_ROLE_SHIFT:
        m = read_rack(p, linkage, f, j);
        return m.along - m.rho*m.angle;
    case LW_ROLE_CX: return lw_v2_unturn(lw_v2_sub(linkage->tracer[j].at, o), u).x;
    case LW_ROLE_CY: return lw_v2_unturn(lw_v2_sub(linkage->tracer[j].at, o), u).y;
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

/* The phase of a wheel: its turn minus the turn that its gear gives from the input, or from carrier and partner. */
static double read_phase(const lw_plan *p, const lw_frames *f, const lw_step *s, double input)
{
    lw_vec2 ground = f->d[p->link[0]];
    double turn = angle_of(lw_v2_unturn(f->d[p->dim[s->dim[0]].link], ground));
    if (s->in[1] < 0)
        return remainder(turn - s->power[0]*input, 2*LW_PI);
    for (int h = 0; h < 2; h++)
        turn -= s->power[h]*angle_of(lw_v2_unturn(f->d[link_with(p, s->in[h])], ground));
    return remainder(turn, 2*LW_PI);
}

/* The phases of wheels in higher groups. */
static void read_phases(const lw_plan *p, const lw_frames *f, double *dim)
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

/* The phases of all wheels. */
static void read_all_phases(const lw_plan *p, const lw_frames *f, double input, double *dim)
{
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].kind == LW_STEP_GEAR && p->step[i].dim[0] >= 0)
            dim[p->step[i].dim[0]] = read_phase(p, f, &p->step[i], input);
    read_phases(p, f, dim);
}

/* The assembly mode of a dyad; signs as at lw_dyad in mbs/plan/plan.h. */
static double read_mode(const lw_plan *p, const lw_linkage *linkage, const lw_step *s)
{
    const int *j = p->dyad[s->dyad].joint;
    lw_vec2 a = linkage->joint[j[0]].at, c = linkage->joint[j[1]].at, b = linkage->joint[j[2]].at;
    double side = 1;
    if (s->kind == LW_STEP_RRR)
        side = lw_v2_cross(lw_v2_sub(b, a), lw_v2_sub(c, a));
    if (s->kind == LW_STEP_RRP && lw_joint_translates(linkage->joint[j[0]].kind))
        side = lw_v2_dot(lw_v2_sub(c, b), lw_plan_slide_direction(p, linkage, j[0]));
    else if (s->kind == LW_STEP_RRP)
        side = lw_v2_dot(lw_v2_sub(c, a), lw_plan_slide_direction(p, linkage, j[2]));
    if (s->kind == LW_STEP_RPR)
        side = lw_v2_dot(lw_v2_sub(b, a), lw_plan_slide_direction(p, linkage, j[1]));
    return side < 0 ? -1 : 1;
}

double lw_plan_read_input(const lw_plan *p, const lw_linkage *linkage, const lw_frames *f)
{
    int from = p->input_link[0], to = p->input_link[1];
    if (!p->input_is_slider)
        return angle_of(lw_v2_unturn(f->d[to], f->d[from]))/p->input_turns_per_period;
    return lw_v2_dot(lw_v2_sub(f->o[to], f->o[from]), lw_plan_slide_direction(p, linkage, p->input_joint));
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

/* Write the posture of the higher groups into mode[] as their seeds. */
static void read_seeds(const lw_plan *p, const lw_linkage *linkage, const lw_frames *f, const double *dim, double input, double *mode)
{
    double size = lw_plan_size(p, dim);
    for (int i = 0; i < p->n_higher; i++) {
        const lw_higher *g = &p->higher[i];
        double *to = mode + g->first_mode;
        for (int a = 0; a < g->n_turn; a++)
            *to++ = angle_of(lw_v2_unturn(f->d[g->turn_link[a]], f->d[linkage->ground]));
        for (int d = 0; d < g->n_disp; d++) {
            int j = g->disp_joint[d], base = p->slider_base[j], rider = lw_joint_other(&linkage->joint[j], base);
            *to++ = lw_v2_dot(lw_v2_sub(f->o[rider], f->o[base]), lw_plan_slide_direction(p, linkage, j))/size;
        }
    }
    if (p->n_higher)
        mode[p->n_mode - 1] = input;
}

static lw_status read_wide(const lw_plan *p, const lw_linkage *linkage, double *dim, double *mode, double *input, lw_error *e)
{
    lw_frames f;
    lw_status s = lw_plan_frames(p, linkage, &f, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < p->n_dim; i++) {
        dim[i] = read_dim(p, linkage, &f, &p->dim[i]);
        if (!isfinite(dim[i]))
            return lw_error_set(e, LW_E_ARG,
                                "dimension %s of link \"%s\" is not finite in this posture: two slides are parallel",
                                p->dim[i].name, linkage->link_name[p->dim[i].link]);
    }
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].dyad >= 0)
            mode[p->step[i].dyad] = read_mode(p, linkage, &p->step[i]);
    *input = lw_plan_read_input(p, linkage, &f);
    read_all_phases(p, &f, *input, dim);
    read_seeds(p, linkage, &f, dim, *input, mode);
    return LW_OK;
}

lw_status lw_plan_read(const lw_plan *p, const lw_linkage *linkage, double *dim, double *mode, double *input, lw_error *e)
{
    lw_linkage wide;
    lw_status s = lw_plan_expand(linkage, &wide, NULL, e);
    return s == LW_OK ? read_wide(p, &wide, dim, mode, input, e) : s;
}

/* ---- play in a pin ------------------------------------------------------------------------------ */

/* The link of the joint to move the pin on: the one with fewer joints at this pin; -1: the plan leaves one of them out. */
static int link_to_move(const lw_plan *p, const lw_linkage *linkage, int joint)
{
    int found[2] = { 0 }, at[2] = { 0 };
    for (int h = 0; h < 2; h++) {
        for (int i = 0; i < p->n_link; i++)
            found[h] += p->link[i] == linkage->joint[joint].link[h];
        for (int j = 0; j < linkage->n_joint; j++)
            at[h] += p->joint_pin[j] == p->joint_pin[joint] && lw_joint_has(&linkage->joint[j], linkage->joint[joint].link[h]);
    }
    return found[0] && found[1] ? linkage->joint[joint].link[at[1] < at[0]] : -1;
}

/* Dimensions and input when the pin is at `by` from its place on this link alone. */
static lw_status read_moved(const lw_plan *plan, const lw_linkage *linkage, int joint, int link, lw_vec2 by, double *dim,
                            double *input, lw_error *e)
{
    lw_plan p = *plan;
    lw_linkage moved = *linkage, others = *linkage;        /* as this link has its pins, and as all others have theirs */
    lw_frames f;
    lw_status s = LW_OK;
    for (int j = 0; j < linkage->n_joint; j++)
        if (p.joint_pin[j] == p.joint_pin[joint])
            moved.joint[j].at = lw_v2_add(moved.joint[j].at, by);
    if (linkage->n_joint == LW_JOINT_MAX)
        return lw_error_set(e, LW_E_KIND, "play is worked out for less than %d joints", LW_JOINT_MAX);
    others.joint[linkage->n_joint] = moved.joint[linkage->n_joint] = moved.joint[joint];
    for (int j = 0; j < linkage->n_joint; j++) {           /* slide lines of this link that are the path of the pin */
        int pin = p.slider_ref[j];
        if (pin >= 0 && p.joint_pin[pin] == p.joint_pin[joint] && lw_joint_has(&linkage->joint[j], link))
            p.slider_ref[j] = linkage->n_joint;
    }
    for (int i = 0; i < p.n_link && s == LW_OK; i++) {
        int at = p.link[i];
        const lw_linkage *seen = at == link ? &moved : &others;
        f.o[at] = frame_origin(&p, seen, at, &f);
        s = frame_axis(&p, seen, at, &f, e);
    }
    for (int d = 0; d < p.n_dim && s == LW_OK; d++)
        dim[d] = read_dim(&p, p.dim[d].link == link ? &moved : &others, &f, &p.dim[d]);
    if (s == LW_OK) {
        *input = lw_plan_read_input(&p, linkage, &f);
        read_all_phases(&p, &f, *input, dim);
    }
    return s;
}

lw_status lw_plan_read_play(const lw_plan *p, const lw_linkage *linkage, int joint, double *const by[2], double input[2], lw_error *e)
{
    lw_linkage wide;
    double up[LW_DIM_MAX], down[LW_DIM_MAX], in[2];
    lw_status s = lw_plan_expand(linkage, &wide, NULL, e);
    int link = s == LW_OK ? link_to_move(p, &wide, joint) : -1;
    for (int k = 0; k < 2 && s == LW_OK; k++) {
        memset(by[k], 0, sizeof *by[k]*(size_t)p->n_dim);
        input[k] = 0;
        if (link < 0)
            continue;
        double h = 0;
        for (int j = 0; j < wide.n_joint; j++)
            h = fmax(h, 1e-6*lw_v2_norm(lw_v2_sub(wide.joint[j].at, wide.joint[joint].at)));
        lw_vec2 step = k == 0 ? lw_v2(h, 0) : lw_v2(0, h);
        s = read_moved(p, &wide, joint, link, step, up, &in[0], e);
        if (s == LW_OK)
            s = read_moved(p, &wide, joint, link, lw_v2_scale(step, -1), down, &in[1], e);
        for (int d = 0; d < p->n_dim && s == LW_OK; d++) {
            double change = up[d] - down[d];
            by[k][d] = (p->dim[d].kind == LW_DIM_ANGLE ? remainder(change, 2*LW_PI) : change)/(2*h);
        }
        double change = in[0] - in[1];
        input[k] = (p->input_is_slider ? change : remainder(change, 2*LW_PI))/(2*h);
    }
    return s;
}

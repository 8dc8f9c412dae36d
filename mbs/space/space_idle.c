#include "mbs/space/space_idle.h"

static bool on_line(lw_vec3 p, lw_vec3 at, lw_vec3 axis, double unit)
{
    return lw_v3_norm(lw_v3_cross(lw_v3_sub(p, at), axis)) < 1e-9*unit;
}

/* The line of the balls of body b, in its axes. */
static bool line_of_balls(const lw_space *s, int b, lw_vec3 *at, lw_vec3 *axis)
{
    int balls = 0;
    bool known = false;
    for (int j = 0; j < s->n_joint; j++)
        for (int k = 0; k < 2; k++) {
            const lw_space_joint *p = &s->joint[j];
            if (p->body[k] != b)
                continue;
            if (lw_spatial_kind_given(&s->model->joint[j]) != LW_SPATIAL_SPHERICAL)
                return false;
            lw_vec3 d = lw_v3_sub(p->arm[k], *at);
            double far = lw_v3_norm(d);
            if (balls++ == 0)
                *at = p->arm[k];
            else if (!known && far > 1e-6*s->unit) {
                *axis = lw_v3_scale(d, 1/far);
                known = true;
            } else if (known && !on_line(p->arm[k], *at, *axis, s->unit))
                return false;
        }
    return known;
}

/* The line through the centre of mass of body b about which it has no inertia, if only balls on this line hold it.  It is a principal axis. */
static bool line_without_inertia(const lw_space *s, int b, lw_vec3 *at, lw_vec3 *axis)
{
    const double *inertia = s->mass + 6*b + 3;
    int k = inertia[0] == 0 ? 0 : inertia[1] == 0 ? 1 : 2;
    if (inertia[k] != 0 || !(inertia[(k + 1)%3] > 0 && inertia[(k + 2)%3] > 0))
        return false;
    *at = lw_v3(0, 0, 0);
    *axis = lw_v3(k == 0, k == 1, k == 2);
    for (int j = 0; j < s->n_joint; j++)
        for (int i = 0; i < 2; i++) {
            lw_spatial_kind kind = lw_spatial_kind_given(&s->model->joint[j]);
            if (s->joint[j].body[i] == b && kind != LW_SPATIAL_FREE && !(kind == LW_SPATIAL_SPHERICAL && on_line(s->joint[j].arm[i], *at, *axis, s->unit)))
                return false;
        }
    return true;
}

int lw_space_idle(const lw_space *s, bool slender, lw_space_extra *out)
{
    const lw_spatial *m = s->model;
    int n = 0;
    for (int b = 0; b < s->n_body; b++) {
        lw_vec3 at = { 0, 0, 0 }, axis = { 0, 0, 0 };
        bool idle = (line_of_balls(s, b, &at, &axis) && on_line(lw_v3(0, 0, 0), at, axis, s->unit)) || (slender && line_without_inertia(s, b, &at, &axis));
        for (int i = 0; idle && i < m->n_tracer; i++)
            idle = s->tracer[i].body != b || on_line(s->tracer[i].arm, at, axis, s->unit);
        for (int i = 0; idle && i < m->n_spring; i++)
            for (int k = 0; k < 2; k++)
                idle = idle && (m->spring[i].link[k] != s->link_of[b] ||
                                on_line(lw_space_point_of(s, s->link_of[b], m->spring[i].at[k]).arm, at, axis,
                                        s->unit));
        for (int i = 0; idle && i < m->n_force; i++)
            idle = m->force[i].link != s->link_of[b];
        if (idle)
            out[n++] = (lw_space_extra){ .spin = true, .body = b, .axis = axis };
    }
    return n;
}

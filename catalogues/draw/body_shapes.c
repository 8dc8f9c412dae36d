/* catalogues/draw/body_shapes.c - see body_shapes.h */
#include "catalogues/draw/body_shapes.h"
#include "grammar/model/model.h"

static bool has_pin(const lw_joint *j, int link)
{
    return (lw_joint_turns(j->kind) && (j->link[0] == link || j->link[1] == link))
        || (lw_joint_has_slot(j->kind) && j->link[1] == link);
}

static bool is_welded(const lw_joint *j, int link)
{
    return lw_joint_freedoms(j->kind) == 0 && (j->link[0] == link || j->link[1] == link);
}

static bool has_tracer(const lw_assembly *linkage, int link)
{
    for (int i = 0; i < linkage->n_tracer; i++)
        if (linkage->tracer[i].link == link)
            return true;
    return false;
}

static double distance_from_line(const lw_joint *line, lw_vec2 p)
{
    return fabs(lw_v2_cross(line->along, lw_v2_sub(p, line->at)));
}

/* The pin of a link nearest to the line of a slider or slot; -1: the link has no pin. */
static int nearest_pin(const lw_assembly *linkage, int link, const lw_joint *line)
{
    int best = -1;
    for (int i = 0; i < linkage->n_joint; i++)
        if (has_pin(&linkage->joint[i], link)
            && (best < 0 || distance_from_line(line, linkage->joint[i].at)
                            < distance_from_line(line, linkage->joint[best].at)))
            best = i;
    return best;
}

static double pin_distance(const lw_assembly *linkage, int link, const lw_joint *line)
{
    int pin = nearest_pin(linkage, link, line);
    return pin < 0 ? 0 : distance_from_line(line, linkage->joint[pin].at);
}

/* Greatest distance of a joint from the point of a line. */
static double spread(const lw_assembly *linkage, const lw_joint *line)
{
    double d = 0;
    for (int i = 0; i < linkage->n_joint; i++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(linkage->joint[i].at, line->at)));
    return d;
}

static int choose_guide(const lw_assembly *linkage, const lw_joint *j)
{
    if (lw_joint_has_slot(j->kind) || j->link[0] == linkage->ground)
        return 0;
    if (j->link[1] == linkage->ground)
        return 1;
    double d0 = pin_distance(linkage, j->link[0], j), d1 = pin_distance(linkage, j->link[1], j);
    if (fabs(d0 - d1) > 0.02*(d0 + d1) + 1e-9*spread(linkage, j))
        return d0 < d1 ? 1 : 0;
    return has_tracer(linkage, j->link[1]) && !has_tracer(linkage, j->link[0]) ? 1 : 0;
}

static lw_vec2 foot(const lw_joint *line, lw_vec2 p)
{
    double t = lw_v2_dot(line->along, lw_v2_sub(p, line->at));
    return lw_v2_add(line->at, lw_v2_scale(line->along, t));
}

/* Intersection of two lines; a's own point if they are parallel. */
static lw_vec2 crossing(const lw_joint *a, const lw_joint *b)
{
    double sine = lw_v2_cross(a->along, b->along);
    if (fabs(sine) < 1e-6)
        return a->at;
    double t = lw_v2_cross(lw_v2_sub(b->at, a->at), b->along)/sine;
    return lw_v2_add(a->at, lw_v2_scale(a->along, t));
}

static lw_vec2 block_place(const lw_assembly *linkage, int j, int block)
{
    const lw_joint *line = &linkage->joint[j];
    int pin = lw_joint_has_slot(line->kind) ? j : nearest_pin(linkage, block, line);
    if (pin >= 0)
        return foot(line, linkage->joint[pin].at);
    for (int i = 0; i < linkage->n_joint; i++)
        if (i != j && lw_joint_translates(linkage->joint[i].kind)
            && (linkage->joint[i].link[0] == block || linkage->joint[i].link[1] == block))
            return crossing(line, &linkage->joint[i]);
    return line->at;
}

static void stretch(lw_slide *w, double t)
{
    w->lo = fmin(w->lo, t);
    w->hi = fmax(w->hi, t);
}

/* Extend lo .. hi by how far point p of link `moving` travels along a line of link `base`, over all frames. */
static void travel(const lw_scene *s, int base, int moving, lw_vec2 p, lw_vec2 along, double *lo, double *hi)
{
    for (size_t f = 0; f < s->n_frame; f++) {
        lw_vec2 at = lw_scene_at(s, f, moving, p), from = lw_scene_at(s, f, base, p);
        lw_vec2 turn = s->place[f*(size_t)s->linkage.n_link + (size_t)base].turn;
        double t = lw_v2_dot(along, lw_v2_unturn(lw_v2_sub(at, from), turn));
        *lo = fmin(*lo, t);
        *hi = fmax(*hi, t);
    }
}

lw_slide lw_body_shapes_slide(const lw_scene *s, int j)
{
    const lw_assembly *k = &s->linkage;
    const lw_joint *line = &k->joint[j];
    int g = choose_guide(k, line);
    lw_slide w = { .guide = line->link[g], .block = line->link[1 - g], .along = line->along };
    w.at = block_place(k, j, w.block);
    travel(s, w.guide, w.block, w.at, w.along, &w.lo, &w.hi);
    for (int i = 0; i < k->n_joint && w.guide != k->ground; i++)
        if (has_pin(&k->joint[i], w.guide))
            stretch(&w, lw_v2_dot(w.along, lw_v2_sub(k->joint[i].at, w.at)));
    return w;
}

/* ---- cylinders ---------------------------------------------------------------------------------- */

bool lw_body_shapes_cylinder(const lw_scene *s, int j, lw_cylinder *c)
{
    const lw_assembly *k = &s->linkage;
    const lw_joint *line = &k->joint[j];
    bool input = false;
    for (int i = 0; i < k->n_input; i++)
        input = input || k->input[i].joint == j;
    if (!input || !lw_joint_translates(line->kind) || line->link[0] == k->ground || line->link[1] == k->ground)
        return false;
    int g = choose_guide(k, line), tube = line->link[g], rod = line->link[1 - g];
    int pin[2] = { nearest_pin(k, tube, line), nearest_pin(k, rod, line) };
    double near = 1e-6*spread(k, line), lo = 0, hi = 0;
    if (pin[0] < 0 || pin[1] < 0 || pin_distance(k, tube, line) > near || pin_distance(k, rod, line) > near)
        return false;
    *c = (lw_cylinder){ .tube = tube, .rod = rod, .pin = { k->joint[pin[0]].at, k->joint[pin[1]].at } };
    double length = lw_v2_dot(line->along, lw_v2_sub(c->pin[1], c->pin[0]));
    c->along = lw_v2_scale(line->along, length < 0 ? -1 : 1);
    length = fabs(length);
    travel(s, tube, rod, c->pin[1], c->along, &lo, &hi);
    double least = length + lo, most = length + hi;
    if (!(least > near) || most > 1.9*least)
        return false;
    c->tube_length = 0.93*least;
    c->rod_length = most - 0.97*c->tube_length;
    return true;
}

/* ---- gears -------------------------------------------------------------------------------------- */

/* Choose the numbers of teeth, that of the smaller radius first, so that their ratio is nearest to the ratio of the
 * radii. */
static void choose_teeth(double lesser, double greater, int teeth[2])
{
    double best = INFINITY;
    for (int n = 18; n <= 32; n++) {
        double m = n*greater/lesser, off = fabs(m - round(m))/m;
        if (off < best - 1e-9) {
            best = off;
            teeth[0] = n;
            teeth[1] = (int)fmin(round(m), 400);
        }
    }
}

static bool set_wheel(const lw_scene *s, const lw_gear *g, int side, int link, lw_vec2 contact, lw_wheel *w)
{
    const lw_assembly *k = &s->linkage;
    *w = (lw_wheel){ .link = link, .rack = g->slider[side] >= 0, .centre = g->centre[side] };
    if (w->rack) {
        w->centre = contact;
        w->along = k->joint[g->slider[side]].along;
        travel(s, link, g->carrier, contact, w->along, &w->lo, &w->hi);
        return true;
    }
    lw_vec2 to = lw_v2_sub(contact, w->centre);
    w->radius = lw_v2_norm(to);
    w->along = lw_v2_scale(to, 1/w->radius);
    return w->radius > 0 && isfinite(w->radius);
}

bool lw_body_shapes_gear(const lw_scene *s, int j, lw_wheel w[2])
{
    const lw_assembly *k = &s->linkage;
    lw_gear g;
    int teeth[2];
    lw_vec2 contact;
    if (lw_assembly_gear(k, j, &g, &contact, NULL) != LW_OK)
        return false;
    for (int i = 0; i < 2; i++)
        if (!set_wheel(s, &g, i, k->joint[j].link[i], contact, &w[i]))
            return false;
    if (w[0].rack || w[1].rack) {
        for (int i = 0; i < 2; i++) {
            w[i].teeth = 18;
            w[i].pitch = 2*LW_PI*w[w[0].rack].radius/18;
        }
        w[1].gap = true;
        return !(w[0].rack && w[1].rack);
    }
    int large = w[1].radius > w[0].radius;
    choose_teeth(w[!large].radius, w[large].radius, teeth);
    bool internal = lw_v2_dot(w[0].along, w[1].along) > 0;
    for (int i = 0; i < 2; i++) {
        w[i].teeth = teeth[i == large];
        w[i].pitch = 2*LW_PI*w[i].radius/w[i].teeth;
        w[i].ring = internal && i == large;
    }
    w[1].gap = !internal;
    return true;
}

/* ---- links -------------------------------------------------------------------------------------- */

/* Add a node unless one is already there, within rounding of the coordinates. */
static int add_node(lw_vec2 *node, int room, int n, lw_vec2 at)
{
    for (int i = 0; i < n; i++)
        if (lw_v2_norm(lw_v2_sub(node[i], at)) <= 1e-12*(fabs(at.x) + fabs(at.y)))
            return n;
    if (n == room)
        return n;
    node[n] = at;
    return n + 1;
}

int lw_body_shapes_nodes(const lw_scene *s, int link, lw_vec2 *node, int room)
{
    const lw_assembly *k = &s->linkage;
    int n = 0;
    for (int i = 0; i < k->n_joint; i++)
        if (has_pin(&k->joint[i], link) || is_welded(&k->joint[i], link))
            n = add_node(node, room, n, k->joint[i].at);
    int n_pin = n;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *line = &k->joint[j];
        if (!lw_joint_slides(line->kind) || (line->link[0] != link && line->link[1] != link))
            continue;
        lw_slide w = lw_body_shapes_slide(s, j);
        if (w.block == link)
            n = add_node(node, room, n, w.at);
        else
            for (int i = 0; i < n_pin; i++)
                n = add_node(node, room, n, foot(line, node[i]));
        if (w.guide == link && n_pin == 0 && link != k->ground)       /* a yoke: only slides hold it */
            n = add_node(node, room, n, w.at);
    }
    for (int i = 0; i < k->n_tracer; i++)
        if (k->tracer[i].link == link)
            n = add_node(node, room, n, k->tracer[i].at);
    for (int i = 0; link != k->ground && s->model && i < s->model->n_spring + s->model->n_rope; i++) {
        int rope = i - s->model->n_spring;
        const int *of = rope < 0 ? s->model->spring[i].link : s->model->rope[rope].link;
        int end = of[1] == link;
        if (of[end] == link)
            n = add_node(node, room, n, rope < 0 ? lw_v3_xy(s->model->spring[i].at[end]) : s->model->rope[rope].at[end]);
    }
    if (n == 1 && link != k->ground && s->model && s->model->body[link].mass > 0)     /* a pendulum reaches to its mass */
        n = add_node(node, room, n, s->model->body[link].centre);
    for (int i = 0; n == 1 && link != k->ground && s->model && i < s->model->n_shape; i++)     /* or to the wheel that touches others */
        if (s->model->shape[i].link == link && s->model->shape[i].kind == LW_CONTOUR_CIRCLE)
            n = add_node(node, room, n, s->model->shape[i].at[0]);
    return n;
}

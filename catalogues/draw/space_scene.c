#include "catalogues/draw/space_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec3.h"
#include "catalogues/draw/motion_path.h"
#include "catalogues/draw/scene.h"
#include "mbs/elastic/superelement.h"
#include "mbs/space/space_trace.h"

lw_vec3 lw_space_scene_at(const lw_space_scene *s, size_t frame, int link, lw_vec3 p)
{
    const lw_space_pose *q = &s->pose[frame*(size_t)s->n_link + (size_t)link];
    lw_mat3 turn = lw_quaternion_matrix(q->turn);
    return lw_v3_add(q->at, lw_m3_apply(&turn, lw_v3_sub(p, s->origin[link])));
}

lw_vec3 lw_space_scene_point(const lw_space_scene *s, size_t frame, const lw_space_shape *shape, int k)
{
    return lw_space_scene_at(s, frame, shape->to >= 0 && k == shape->n - 1 ? shape->to : shape->link, shape->p[k]);
}

/* ---- motion ---------------------------------------------------------------------------------------------- */

#define PATH_STEPS 4                     /* of the path of a tracer from frame to frame */

typedef struct film { lw_space_scene *s; size_t most; double u; lw_vec3 *place, *rate; } film;     /* of the tracers (n_tracer) at the frame before */

/* A slope of a cubic over a step; at most three chords, since rates have no limit near a limit of the input. */
static lw_vec3 slope(lw_vec3 rate, double du, lw_vec3 chord)
{
    double most = 3*lw_v3_norm(chord), length = lw_v3_norm(rate)*fabs(du);
    return !isfinite(length) ? chord : lw_v3_scale(rate, length > most ? du*most/length : du);
}

/* Points of the paths after the frame before, by cubics with the rates at both ends, up to that at u. */
static void lead_paths(film *f, double u, const lw_space_tracer *tracer)
{
    lw_space_scene *s = f->s;
    size_t n = (size_t)s->n_tracer;
    for (size_t i = 0; i < n; i++) {
        lw_vec3 a = f->place[i], chord = lw_v3_sub(tracer[i].place, a);
        lw_vec3 from = slope(f->rate[i], u - f->u, chord), to = slope(tracer[i].velocity, u - f->u, chord);
        for (int k = 1; s->n_frame > 0 && k < PATH_STEPS; k++) {
            double x = (double)k/PATH_STEPS, y = 1 - x;
            lw_vec3 p = lw_v3_add(a, lw_v3_scale(chord, x*x*(3 - 2*x)));
            p = lw_v3_add(p, lw_v3_sub(lw_v3_scale(from, x*y*y), lw_v3_scale(to, x*x*y)));
            s->path[(s->n_path + (size_t)k - 1)*n + i] = p;
        }
        f->place[i] = tracer[i].place;
        f->rate[i] = tracer[i].velocity;
    }
    f->u = u;
    s->n_path += s->n_frame > 0 ? PATH_STEPS : 1;
    for (size_t i = 0; i < n; i++)
        s->path[(s->n_path - 1)*n + i] = tracer[i].place;
}

/* The tracers that follow those of the model are one for each link. */
static lw_status take_frame(void *context, double u, const double *input, const lw_space_tracer *tracer)
{
    film *f = context;
    lw_space_scene *s = f->s;
    (void)input;
    if (s->n_frame == f->most)
        return LW_OK;
    lead_paths(f, u, tracer);
    for (int i = 0; i < s->n_link; i++)
        s->pose[s->n_frame*(size_t)s->n_link + (size_t)i] = (lw_space_pose){ tracer[s->n_tracer + i].place,
                                                                             tracer[s->n_tracer + i].turn };
    s->n_frame++;
    return LW_OK;
}

/* The posture of the file. */
static void stand_still(lw_space_scene *s, const lw_spatial *m)
{
    s->n_frame = s->n_path = 1;
    for (int i = 0; i < s->n_link; i++)
        s->pose[i] = (lw_space_pose){ s->origin[i], { 1, 0, 0, 0 } };
    for (int i = 0; i < s->n_tracer; i++)
        s->path[i] = m->tracer[i].at;
}

static bool moves_in_time(const lw_spatial *m)
{
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].motion)
            return true;
    return false;
}

/* Do the last and the first pose agree, to a part of the size? */
static bool closes(const lw_space_scene *s)
{
    const lw_space_pose *a = s->pose, *b = s->pose + (s->n_frame - 1)*(size_t)s->n_link;
    for (int i = 0; i < s->n_link; i++) {
        lw_quaternion t = lw_quaternion_times(b[i].turn, lw_quaternion_inverse(a[i].turn));
        if (lw_v3_norm(lw_v3_sub(a[i].at, b[i].at)) > 1e-6*s->radius || lw_v3_norm(lw_quaternion_vector(t)) > 1e-6)
            return false;
    }
    return s->n_frame > 2;
}

typedef struct inputs_in_time { const lw_spatial *model; double (*value)[3]; } inputs_in_time;     /* value: (2*inputs) scratch */

static bool inputs_are_alike(void *context, double a, double b)
{
    inputs_in_time *c = context;
    double (*u)[3] = c->value, (*v)[3] = u + c->model->n_input;
    if (lw_space_motions((void *)(uintptr_t)c->model, a, u) != LW_OK || lw_space_motions((void *)(uintptr_t)c->model, b, v) != LW_OK)
        return false;
    for (int i = 0; i < c->model->n_input; i++)
        for (int k = 0; k < 2; k++)
            if (!(fabs(u[i][k] - v[i][k]) <= LW_INPUTS_ALIKE*(1 + fabs(u[i][k]))))
                return false;
    return true;
}

/* How long the motion of the inputs in time is shown [s]. */
static lw_status duration(const lw_spatial *m, double *out)
{
    inputs_in_time c = { m, malloc(2*(size_t)m->n_input*sizeof *c.value) };
    if (!c.value)
        return LW_E_MEMORY;
    *out = lw_motion_path_duration(inputs_are_alike, &c);
    free(c.value);
    return LW_OK;
}

/* The range of the first input is that of the stop of its joint, where the file gives none. */
static void limit_by_stop(const lw_spatial *m, lw_space_trace *t)
{
    const lw_spatial_input *in = &m->input[0];
    bool measures = in->measure.of == LW_OF_SLIDE || in->measure.of == LW_OF_TURN;
    const lw_spatial_joint *j = measures ? &m->joint[in->measure.index] : NULL;
    if (!t->whole || in->has_range || !j || !j->stop.has_least || !j->stop.has_greatest || (in->measure.of == LW_OF_SLIDE && j->kind != LW_SPATIAL_PRISMATIC))
        return;
    t->whole = false;
    t->from = lw_spatial_offset(in) + j->stop.least, t->to = lw_spatial_offset(in) + j->stop.greatest;
}

static lw_status make_motion(const lw_spatial *m, const lw_space_scene_options *o, lw_space_scene *s, lw_error *e)
{
    size_t n_tracer = (size_t)m->n_tracer;
    film f = { .s = s, .most = o->n_frame + 1 };
    lw_space_trace t = { .in_time = moves_in_time(m), .to = o->until, .intervals = (int)o->n_frame, .stop = o->stop };
    lw_spatial with = *m;                 /* the same model, with a tracer for each link */
    lw_error why = { 0 };
    t.whole = !t.in_time;
    if (m->n_input > 0)
        limit_by_stop(m, &t);
    if (o->pose) {
        s->n_frame = s->n_path = o->n_frame;
        s->seconds = o->until;
        s->ends = true;
        memcpy(s->pose, o->pose, s->n_frame*(size_t)s->n_link*sizeof *s->pose);
        if (s->n_tracer)
            memcpy(s->path, o->path, s->n_frame*(size_t)s->n_tracer*sizeof *s->path);
        return LW_OK;
    }
    if (m->n_input == 0) {
        stand_still(s, m);
        snprintf(s->note, sizeof s->note, "Shown without motion: the model has no input%s", m->n_drive > 0 ? "; its \"drives\" move by \"inputs\" only" : "");
        return LW_OK;
    }
    if (t.in_time && !(t.to > 0) && duration(m, &t.to) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double until = t.to;                  /* the run may end before */
    with.n_tracer = m->n_tracer + m->n_link;
    with.tracer = calloc((size_t)with.n_tracer, sizeof *with.tracer);
    f.place = calloc(2*n_tracer + 1, sizeof *f.place);
    f.rate = f.place + n_tracer;
    if (!with.tracer || !f.place) {
        free(with.tracer), free(f.place);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    if (n_tracer)
        memcpy(with.tracer, m->tracer, n_tracer*sizeof *m->tracer);
    for (int i = 0; i < m->n_link; i++)
        with.tracer[m->n_tracer + i] = (lw_spatial_tracer){ .link = i, .at = s->origin[i], .frame = { 1, 0, 0, 0 } };
    lw_status status = lw_space_trace_run(&with, &t, take_frame, &f, &why);
    free(with.tracer), free(f.place);
    if (status == LW_E_MEMORY)
        return lw_error_set(e, status, "%s", why.text[0] ? why.text : lw_status_text(status));
    if (status != LW_OK)
        snprintf(s->note, sizeof s->note, "%s: %.200s", s->n_frame > 0 ? "Shown as far as it moves" : "Shown without motion",
                 why.text[0] ? why.text : lw_status_text(status));
    if (s->n_frame == 0)
        stand_still(s, m);
    if (t.in_time)
        s->seconds = until*(double)(s->n_frame - 1)/(double)o->n_frame;
    s->loops = closes(s);
    s->n_frame -= s->loops;
    s->n_path -= s->loops;
    return LW_OK;
}

/* ---- shapes ---------------------------------------------------------------------------------------------- */

static void add(lw_space_scene *s, lw_space_shape shape)
{
    shape.to = -1;
    s->shape[s->n_shape++] = shape;
}

/* Add a point, unless it is there. */
static void add_point(lw_vec3 at, double near, lw_vec3 p[LW_SPACE_POINTS], int *n)
{
    for (int k = 0; k < *n; k++)
        if (lw_v3_norm(lw_v3_sub(p[k], at)) < near)
            return;
    if (*n < LW_SPACE_POINTS)
        p[(*n)++] = at;
}

/* Points of a link, each once: its joints and the ends of springs and cylinders, *n_held in all, its tracers, its centre of mass beside a single one. */
static int points_of(const lw_spatial *m, int link, double near, lw_vec3 p[LW_SPACE_POINTS], int *n_held)
{
    int n = 0;
    for (int i = 0; i < m->n_joint; i++)
        if (m->joint[i].link[0] == link || m->joint[i].link[1] == link)
            add_point(m->joint[i].at, near, p, &n);
    for (int i = 0; i < 2*m->n_spring; i++)
        if (m->spring[i/2].link[i%2] == link)
            add_point(m->spring[i/2].at[i%2], near, p, &n);
    *n_held = n;
    for (int i = 0; i < m->n_tracer; i++)
        if (m->tracer[i].link == link)
            add_point(m->tracer[i].at, near, p, &n);
    if (n == 1 && m->body[link].given)
        add_point(m->body[link].centre, near, p, &n);
    return n;
}

static lw_vec3 middle_of(const lw_vec3 *p, int n)
{
    lw_vec3 sum = { 0, 0, 0 };
    for (int i = 0; i < n; i++)
        sum = lw_v3_add(sum, p[i]);
    return lw_v3_scale(sum, 1.0/n);
}

/* The unit normal of the points if they are in a plane and not on a line. */
static bool are_flat(const lw_vec3 *p, int n, double near, lw_vec3 *normal)
{
    lw_vec3 best = { 0, 0, 0 };
    for (int i = 1; i < n; i++)
        for (int k = i + 1; k < n; k++) {
            lw_vec3 c = lw_v3_cross(lw_v3_sub(p[i], p[0]), lw_v3_sub(p[k], p[0]));
            best = lw_v3_norm(c) > lw_v3_norm(best) ? c : best;
        }
    double length = lw_v3_norm(best);
    if (!(length > near*near))
        return false;
    *normal = lw_v3_scale(best, 1/length);
    for (int i = 1; i < n; i++)
        if (fabs(lw_v3_dot(*normal, lw_v3_sub(p[i], p[0]))) > near)
            return false;
    return true;
}

/* The outline of points of a plane: their convex hull (Andrew 1979).  Returns its number of points. */
static int outline(lw_vec3 *p, int n, lw_vec3 normal)
{
    lw_vec3 x = lw_v3_across(normal), y = lw_v3_cross(normal, x), hull[2*LW_SPACE_POINTS];
    int size = 0;
    for (int i = 1; i < n; i++)
        for (int k = i; k > 0; k--) {
            double d = lw_v3_dot(lw_v3_sub(p[k], p[k - 1]), x);
            if (d > 0 || (d == 0 && lw_v3_dot(lw_v3_sub(p[k], p[k - 1]), y) >= 0))
                break;
            lw_vec3 q = p[k];
            p[k] = p[k - 1];
            p[k - 1] = q;
        }
    for (int side = 0; side < 2; side++) {
        int first = size;
        for (int i = 0; i < n; i++) {
            lw_vec3 q = p[side ? n - 1 - i : i];
            while (size > first + 1 && lw_v3_dot(normal, lw_v3_cross(lw_v3_sub(hull[size - 1], hull[size - 2]),
                                                                     lw_v3_sub(q, hull[size - 1]))) <= 0)
                size--;
            hull[size++] = q;
        }
        size--;                                            /* the last is the first of the other side */
    }
    memcpy(p, hull, (size_t)size*sizeof *p);
    return size;
}

static void add_bar(lw_space_scene *s, int link, lw_vec3 a, lw_vec3 b)
{
    add(s, (lw_space_shape){ .kind = LW_SPACE_BAR, .link = link, .item = link, .n = 2, .p = { a, b } });
}

/* Two points on a line: the ends of all of them. */
static void add_line(lw_space_scene *s, int link, const lw_vec3 *p, int n)
{
    int a = 0, b = n > 1 ? 1 : 0;
    for (int i = 0; i < n; i++)
        for (int k = i + 1; k < n; k++)
            if (lw_v3_norm(lw_v3_sub(p[i], p[k])) > lw_v3_norm(lw_v3_sub(p[a], p[b])))
                a = i, b = k;
    if (a != b)
        add_bar(s, link, p[a], p[b]);
}

/* Rigid arms to what acts beside a line of bars, from the nearest point of it. */
static void add_arms(lw_space_scene *s, int link, const lw_vec3 *line, int n_line, const lw_vec3 *p, int n)
{
    for (int i = 0; i < n; i++) {
        lw_vec3 best = line[0];
        for (int k = 0; k + 1 < n_line; k++) {
            lw_vec3 along = lw_v3_sub(line[k + 1], line[k]);
            double part = lw_v3_dot(lw_v3_sub(p[i], line[k]), along)/lw_v3_dot(along, along);
            lw_vec3 foot = lw_v3_add(line[k], lw_v3_scale(along, fmin(fmax(part, 0), 1)));
            best = lw_v3_norm(lw_v3_sub(p[i], foot)) < lw_v3_norm(lw_v3_sub(p[i], best)) ? foot : best;
        }
        if (lw_v3_norm(lw_v3_sub(p[i], best)) > 1e-6*s->radius)
            add_bar(s, link, best, p[i]);
    }
}

static bool is_node(const lw_spatial *m, int link)
{
    for (int i = 0; i < m->n_beam; i++)
        if (m->beam[i].link[0] == link || m->beam[i].link[1] == link)
            return true;
    for (int i = 0; i < m->n_super; i++)
        for (int k = 0; k < m->super[i].n; k++)
            if (m->super[i].link[k] == link)
                return true;
    return false;
}

/* Bars of a body with given stiffness.  node (n): the links that nodes are; NULL: all belong to `link`.  LW_E_MEMORY. */
static lw_status add_mesh(lw_space_scene *s, int link, const int *node, int n, int n_matrix, const lw_vec3 *at, const double *stiffness)
{
    int (*edge)[2], n_edge = lw_super_edges(n, n_matrix, at, stiffness, &edge);
    for (int i = 0; i < n_edge; i++) {
        const int *end = edge[i];
        add_bar(s, node ? node[end[0]] : link, at[end[0]], at[end[1]]);
        s->shape[s->n_shape - 1].to = node ? node[end[1]] : -1;
    }
    free(edge);
    return n_edge < 0 ? LW_E_MEMORY : LW_OK;
}

/* Arms from the nearest node to what acts on a body with nodes. */
static void add_arms_from_nodes(lw_space_scene *s, int link, const lw_elastic *body, const lw_vec3 *p, int n)
{
    for (int i = 0; i < n; i++) {
        int near = 0;
        for (int k = 1; k < body->n_node; k++)
            near = lw_v3_norm(lw_v3_sub(p[i], body->node[k])) < lw_v3_norm(lw_v3_sub(p[i], body->node[near])) ? k : near;
        add_arms(s, link, &body->node[near], 1, &p[i], 1);
    }
}

static void add_plate(lw_space_scene *s, int link, const lw_vec3 *p, int n, lw_vec3 normal)
{
    lw_space_shape plate = { .kind = LW_SPACE_PLATE, .link = link, .item = link };
    memcpy(plate.p, p, (size_t)n*sizeof *p);
    plate.n = outline(plate.p, n, normal);
    add(s, plate);
}

static lw_status add_link(const lw_spatial *m, int link, lw_space_scene *s)
{
    lw_status st = LW_OK;
    lw_vec3 p[LW_SPACE_POINTS], normal;
    double near = 1e-6*s->radius;
    int n_held, n = points_of(m, link, near, p, &n_held);
    const lw_elastic *own = m->elastic ? &m->elastic[link] : NULL, *bent = own && own->n_axis > 0 ? own : NULL;
    if (is_node(m, link)) {
        add_arms(s, link, &m->body[link].centre, 1, p, n);
    } else if (own && own->n_node > 0) {
        st = add_mesh(s, link, NULL, own->n_node, own->n_node, own->node, own->stiffness);
        add_arms_from_nodes(s, link, own, p, n);
    } else if (bent) {
        for (int i = 0; i + 1 < bent->n_axis; i++)
            add_bar(s, link, bent->axis[i], bent->axis[i + 1]);
        add_arms(s, link, bent->axis, bent->n_axis, p, n);
    } else if (n < 3) {
        add_line(s, link, p, n);
    } else if (are_flat(p, n, near, &normal)) {
        add_plate(s, link, p, n, normal);
    } else if (lw_v3_norm(lw_v3_cross(lw_v3_sub(p[1], p[0]), lw_v3_sub(p[n - 1], p[0]))) < near*s->radius && n == 3) {
        add_line(s, link, p, n);
    } else {                             /* a plate between the joints, if they lie in a plane, carries the tracers on arms */
        bool flat = n_held >= 3 && are_flat(p, n_held, near, &normal);
        lw_vec3 hub = middle_of(p, flat ? n_held : n);
        if (flat)
            add_plate(s, link, p, n_held, normal);
        for (int i = flat ? n_held : 0; i < n; i++)
            add_bar(s, link, hub, p[i]);
    }
    return st;
}

static void add_axis(lw_space_scene *s, lw_space_shape_kind kind, const lw_spatial_joint *j, int item, int link,
                     lw_vec3 axis, double half, bool grounded)
{
    lw_vec3 d = lw_v3_scale(axis, half);
    add(s, (lw_space_shape){ .kind = kind, .link = link, .item = item, .grounded = grounded, .n = 2,
                             .p = { lw_v3_sub(j->at, d), lw_v3_add(j->at, d) } });
}

/* The line of a slide on its first link: as long as the second link moves along it in all frames, and at least 16 pins. */
static void add_guide(lw_space_scene *s, const lw_spatial_joint *j, int item, double pin, bool grounded)
{
    double least = -8*pin, most = 8*pin;
    for (size_t f = 0; f < s->n_frame; f++) {
        lw_vec3 at = lw_space_scene_at(s, f, j->link[0], j->at), ahead = lw_space_scene_at(s, f, j->link[0], lw_v3_add(j->at, j->axis));
        double along = lw_v3_dot(lw_v3_sub(lw_space_scene_at(s, f, j->link[1], j->at), at), lw_v3_sub(ahead, at));
        least = fmin(least, along - 2*pin);
        most = fmax(most, along + 2*pin);
    }
    add(s, (lw_space_shape){ .kind = LW_SPACE_GUIDE, .link = j->link[0], .item = item, .grounded = grounded, .n = 2,
                             .p = { lw_v3_add(j->at, lw_v3_scale(j->axis, least)), lw_v3_add(j->at, lw_v3_scale(j->axis, most)) } });
}

/* A square around the place of a joint; half: half the length of its side [m]. */
static void add_square(lw_space_scene *s, const lw_spatial_joint *j, int item, lw_vec3 normal, double half, bool grounded)
{
    lw_vec3 x = lw_v3_scale(lw_v3_across(normal), half), y = lw_v3_cross(normal, x);
    add(s, (lw_space_shape){ .kind = LW_SPACE_PLATE, .link = j->link[0], .item = item, .grounded = grounded, .n = 4,
                             .p = { lw_v3_add(j->at, lw_v3_add(x, y)), lw_v3_add(j->at, lw_v3_sub(x, y)),
                                    lw_v3_sub(j->at, lw_v3_add(x, y)), lw_v3_sub(j->at, lw_v3_sub(x, y)) } });
}

/* A weld is a flange across a bar that ends there.  Where another joint has its sign, as on a hub with a hinge, it has none. */
static void add_flange(const lw_spatial *m, int item, lw_space_scene *s, double pin, bool grounded)
{
    const lw_spatial_joint *j = &m->joint[item];
    lw_vec3 normal = s->up;
    double near = 1e-6*s->radius;
    for (int i = 0; i < m->n_joint; i++) {
        lw_spatial_kind kind = lw_spatial_kind_given(&m->joint[i]);
        if (kind != LW_SPATIAL_FREE && (kind != LW_SPATIAL_FIXED || i < item) && lw_v3_norm(lw_v3_sub(m->joint[i].at, j->at)) < near)
            return;
    }
    for (int i = 0; i < s->n_shape; i++) {
        const lw_space_shape *bar = &s->shape[i];
        lw_vec3 way = lw_v3_sub(bar->p[1], bar->p[0]);
        bool ends = bar->kind == LW_SPACE_BAR && (bar->link == j->link[0] || bar->link == j->link[1] || bar->to == j->link[0] || bar->to == j->link[1]) &&
                    fmin(lw_v3_norm(lw_v3_sub(bar->p[0], j->at)), lw_v3_norm(lw_v3_sub(bar->p[1], j->at))) < near;
        if (ends) {
            normal = lw_v3_scale(way, 1/lw_v3_norm(way));
            break;
        }
    }
    add_square(s, j, item, normal, grounded ? 1.2*pin : 0.7*pin, grounded);
}

static void add_joint(const lw_spatial *m, int item, lw_space_scene *s)
{
    const lw_spatial_joint *j = &m->joint[item];
    double pin = 0.035*s->radius;
    bool grounded = j->link[0] == m->ground || j->link[1] == m->ground;
    int first = j->link[0], second = j->link[1];
    switch (lw_spatial_kind_given(j)) {
    case LW_SPATIAL_REVOLUTE:    add_axis(s, LW_SPACE_PIN, j, item, first, j->axis, pin, grounded); break;
    case LW_SPATIAL_CYLINDRICAL:
    case LW_SPATIAL_SCREW:
        add_guide(s, j, item, pin, grounded);
        add_axis(s, LW_SPACE_PIN, j, item, second, j->axis, 1.6*pin, grounded);
        break;
    case LW_SPATIAL_PRISMATIC:
        add_guide(s, j, item, pin, grounded);
        add_axis(s, LW_SPACE_PIN, j, item, second, j->axis, 1.3*pin, grounded);
        break;
    case LW_SPATIAL_UNIVERSAL:
        add_axis(s, LW_SPACE_PIN, j, item, first, j->axis, pin, grounded);
        add_axis(s, LW_SPACE_PIN, j, item, second, j->second, pin, grounded);
        break;
    case LW_SPATIAL_SPHERICAL:
        add(s, (lw_space_shape){ .kind = LW_SPACE_BALL, .link = first, .item = item, .grounded = grounded, .n = 1,
                                 .p = { j->at } });
        break;
    case LW_SPATIAL_PLANAR: add_square(s, j, item, j->axis, 4*pin, grounded); break;
    case LW_SPATIAL_FIXED:  add_flange(m, item, s, pin, grounded); break;
    case LW_SPATIAL_FREE:   break;
    }
}

static lw_status make_shapes(const lw_spatial *m, lw_space_scene *s)
{
    lw_status st = LW_OK;
    for (int i = 0; st == LW_OK && i < m->n_link; i++)
        if (i != m->ground)
            st = add_link(m, i, s);
    for (int i = 0; i < m->n_beam; i++) {
        const int *end = m->beam[i].link;
        add_bar(s, end[0], m->body[end[0]].centre, m->body[end[1]].centre);
        s->shape[s->n_shape - 1].to = end[1];
    }
    for (int i = 0; st == LW_OK && i < m->n_super; i++)
        st = add_mesh(s, -1, m->super[i].link, m->super[i].n_bound, m->super[i].n, m->super[i].at, m->super[i].stiffness);
    for (int i = 0; i < m->n_joint; i++)
        add_joint(m, i, s);
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spring *t = &m->spring[i];
        add(s, (lw_space_shape){ .kind = LW_SPACE_TIE, .link = t->link[0], .item = i, .n = 2, .p = { t->at[0], t->at[1] }, .tube = 0.95*t->extent[0] });
        s->shape[s->n_shape - 1].to = t->link[1];
    }
    for (int i = 0; i < m->n_tracer; i++)
        add(s, (lw_space_shape){ .kind = LW_SPACE_TRACER, .link = m->tracer[i].link, .item = i, .n = 1,
                                 .p = { m->tracer[i].at } });
    return st;
}

/* ---- the whole ------------------------------------------------------------------------------------------- */

/* A point on each link where nothing else can be wrong with it: a joint.  An idle link turns about the line of its joints. */
static lw_vec3 origin_of(const lw_spatial *m, int link)
{
    for (int i = 0; i < m->n_joint; i++)
        if (lw_spatial_kind_given(&m->joint[i]) != LW_SPATIAL_FREE && (m->joint[i].link[0] == link || m->joint[i].link[1] == link))
            return m->joint[i].at;
    return m->body[link].centre;
}

static void measure(lw_space_scene *s)
{
    lw_vec3 least = { INFINITY, INFINITY, INFINITY }, most = { -INFINITY, -INFINITY, -INFINITY };
    for (size_t f = 0; f < s->n_frame; f++)
        for (int i = 0; i < s->n_shape; i++)
            for (int k = 0; k < s->shape[i].n; k++) {
                lw_vec3 p = lw_space_scene_point(s, f, &s->shape[i], k);
                least = lw_v3(fmin(least.x, p.x), fmin(least.y, p.y), fmin(least.z, p.z));
                most = lw_v3(fmax(most.x, p.x), fmax(most.y, p.y), fmax(most.z, p.z));
            }
    if (s->n_shape == 0)
        return;
    s->middle = lw_v3_scale(lw_v3_add(least, most), 0.5);
    s->radius = fmax(0.5*lw_v3_norm(lw_v3_sub(most, least)), 1e-9);
}

static double distance_of_ends(const lw_space_scene *s, size_t frame, const void *spring)
{
    const lw_spring *p = spring;
    return lw_v3_norm(lw_v3_sub(lw_space_scene_at(s, frame, p->link[1], p->at[1]), lw_space_scene_at(s, frame, p->link[0], p->at[0])));
}

/* Turn, within half a turn either way, or slide from the posture. */
static double displacement(const lw_space_scene *s, size_t frame, const void *joint)
{
    const lw_spatial_joint *j = joint;
    lw_vec3 beside = lw_v3_add(j->at, lw_v3_across(j->axis)), at[2], way[2];
    for (int side = 0; side < 2; side++) {
        at[side] = lw_space_scene_at(s, frame, j->link[side], j->at);
        way[side] = lw_v3_sub(lw_space_scene_at(s, frame, j->link[side], beside), at[side]);
    }
    lw_vec3 axis = lw_v3_sub(lw_space_scene_at(s, frame, j->link[0], lw_v3_add(j->at, j->axis)), at[0]);
    return j->kind == LW_SPATIAL_PRISMATIC ? lw_v3_dot(lw_v3_sub(at[1], at[0]), axis)
                                           : atan2(lw_v3_dot(lw_v3_cross(way[0], way[1]), axis), lw_v3_dot(way[0], way[1]));
}

static void note_limit(lw_space_scene *s, double (*value)(const lw_space_scene *, size_t, const void *), const void *part, const char *limit, const char *name,
                       const double allowed[2], bool angle)
{
    double reached[2] = { INFINITY, -INFINITY };
    for (size_t f = 0; f < s->n_frame; f++)
        reached[0] = fmin(reached[0], value(s, f, part)), reached[1] = fmax(reached[1], value(s, f, part));
    lw_scene_note_limit(s->note, limit, name, reached, allowed, angle, &s->model->units);
}

/* Strokes of cylinders and stops of joints that the motion passes. */
static void note_limits(const lw_spatial *m, lw_space_scene *s)
{
    for (int i = 0; i < m->n_spring; i++)
        if (m->spring[i].extent[1] > 0)
            note_limit(s, distance_of_ends, &m->spring[i], "stroke of cylinder", m->spring[i].name, m->spring[i].extent, false);
    for (int i = 0; i < m->n_joint; i++) {
        const lw_spatial_joint *j = &m->joint[i];
        const lw_joint_stop *p = &j->stop;
        double allowed[2] = { p->has_least ? p->least : -INFINITY, p->has_greatest ? p->greatest : INFINITY };
        bool turns = j->kind == LW_SPATIAL_REVOLUTE, within = !turns || (fabs(p->least) < LW_PI && fabs(p->greatest) < LW_PI);
        if ((p->has_least || p->has_greatest) && within && (turns || j->kind == LW_SPATIAL_PRISMATIC))
            note_limit(s, displacement, j, "stop of joint", j->name, allowed, turns);
    }
}

static size_t pairs_of(int n) { return (size_t)n*(size_t)n/2; }

lw_status lw_space_scene_make(const lw_spatial *m, const lw_space_scene_options *o, lw_space_scene *s, lw_error *e)
{
    size_t n_frame = o->n_frame + 1, n_link = (size_t)m->n_link, n_tracer = (size_t)m->n_tracer;
    size_t n_shape = LW_SPACE_POINTS*n_link + 2*(size_t)m->n_joint + n_tracer + (size_t)m->n_beam + (size_t)m->n_spring;
    for (int i = 0; m->elastic && i < m->n_link; i++)
        n_shape += (size_t)m->elastic[i].n_axis + pairs_of(m->elastic[i].n_node);
    for (int i = 0; i < m->n_super; i++)
        n_shape += pairs_of(m->super[i].n);
    *s = (lw_space_scene){ .model = m, .n_link = m->n_link, .n_tracer = m->n_tracer, .up = { 0, 0, 1 }, .stop = o->stop };
    snprintf(s->title, sizeof s->title, "%s", o->title ? o->title : m->name);
    s->shape = calloc(n_shape + 1, sizeof *s->shape);
    s->origin = calloc(n_link, sizeof *s->origin);
    s->pose = calloc(n_frame*n_link, sizeof *s->pose);
    s->path = calloc(PATH_STEPS*n_frame*n_tracer + 1, sizeof *s->path);
    if (!s->shape || !s->origin || !s->pose || !s->path)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double g = lw_v3_norm(m->gravity);
    if (g > 0)
        s->up = lw_v3_scale(m->gravity, -1/g);
    s->radius = lw_spatial_size(m);
    for (int i = 0; i < m->n_link; i++)
        s->origin[i] = o->pose ? o->origin[i] : origin_of(m, i);
    lw_status status = make_motion(m, o, s, e);
    if (status != LW_OK)
        return status;
    if (make_shapes(m, s) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    measure(s);
    if (!o->pose)                        /* a run goes a little beyond, into the stops */
        note_limits(m, s);
    return LW_OK;
}

void lw_space_scene_free(lw_space_scene *s)
{
    free(s->shape);
    free(s->origin);
    free(s->pose);
    free(s->path);
    *s = (lw_space_scene){ 0 };
}

/* catalogues/draw/scene.c - see scene.h */
#include "catalogues/draw/scene.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/real.h"
#include "catalogues/draw/motion_path.h"
#include "catalogues/draw/walk.h"
#include "grammar/model/model.h"
#include "mbs/constraints/mobility.h"
#include "mbs/constraints/newton.h"
#include "mbs/formulations/follow_model.h"

/* Data that the steps of lw_scene_make share. */
#define POINTS_MAX 50000        /* of a curve: beyond, its steps are no longer halved */

typedef struct lw_work {
    lw_scene  *s;
    const lw_linkage *given;
    lw_linkage linkage;                    /* with an extra tracer for every link without a pin    */
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    int        pin[LW_LINK_MAX];           /* a joint of the link, or -1 - (index of its tracer)   */
    lw_posture    start, posture;          /* posture shown; posture being computed                */
    lw_motion  motion;
    lw_walk    walk;                       /* through the circuit that holds the posture shown     */
    bool       by_path;                    /* no closed-form plan: the motion comes from `path`, not from `walk` */
    lw_motion_path path;
    double     q[LW_SYSTEM_Q_MAX];         /* coordinates of the posture being computed             */
    bool       no_memory;                  /* while looking for a plan or a walk                    */
} lw_work;

static bool is_stopped(const lw_work *w) { return w->s->stop && *w->s->stop; }

/* The motion runs over t = 0 .. motion_length. */
static double motion_length(const lw_work *w) { return w->by_path ? 1 : w->walk.n_stage; }

static bool motion_loops(const lw_work *w) { return w->by_path ? w->path.loops : w->walk.loops; }

lw_scene_options lw_scene_options_default(void)
{
    return (lw_scene_options){ .n_frame = 120, .n_curve_point = 360 };
}

void lw_scene_free(lw_scene *s)
{
    for (int i = 0; i < s->n_curve; i++)
        free(s->curve[i].p);
    free(s->curve);
    free(s->origin);
    free(s->station);
    free(s->place);
    free(s->input);
    lw_assembly_free(&s->linkage);
    s->n_curve = 0;
    s->curve = NULL;
    s->origin = NULL;
    s->station = NULL;
    s->place = NULL;
    s->input = NULL;
}

static bool take_copy(lw_scene *s, lw_curve c)
{
    lw_vec2 *p = malloc((c.n + 1)*sizeof *p);
    if (!p)
        return false;
    memcpy(p, c.p, c.n*sizeof *p);
    c.p = p;
    c.tracer = -1;
    c.compared = c.shown_branch = true;
    s->curve[s->n_curve++] = c;
    return true;
}

/* The line through the joints and tracers of a link, around their middle. */
static size_t outline_of(const lw_assembly *linkage, int link, lw_vec2 *p, double *angle)
{
    lw_vec2 middle = { 0, 0 };
    size_t n = 0;
    for (int j = 0; j < linkage->n_joint; j++)
        if ((linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link)
            && lw_joint_has_position(linkage->joint[j].kind))
            p[n++] = linkage->joint[j].at;
    for (int i = 0; i < linkage->n_tracer; i++)
        if (linkage->tracer[i].link == link)
            p[n++] = linkage->tracer[i].at;
    for (size_t i = 0; i < n; i++)
        middle = lw_v2_add(middle, lw_v2_scale(p[i], 1.0/(double)n));
    for (size_t i = 0; i < n; i++) {
        angle[i] = atan2(p[i].y - middle.y, p[i].x - middle.x);
        for (size_t k = i; k > 0 && angle[k] < angle[k - 1]; k--) {
            double a = angle[k];
            lw_vec2 q = p[k];
            angle[k] = angle[k - 1], p[k] = p[k - 1];
            angle[k - 1] = a, p[k - 1] = q;
        }
    }
    return n;
}

lw_status lw_scene_compare(lw_scene *s, const lw_scene *other, lw_error *e)
{
    size_t most = (size_t)(other->linkage.n_joint + other->linkage.n_tracer) + 1;
    lw_vec2 *p = malloc(most*(sizeof *p + sizeof(double)));
    bool good = p != NULL;
    for (int link = 0; link < other->linkage.n_link && good && s->n_curve < s->max_curve; link++) {
        size_t n = link == other->linkage.ground ? 0 : outline_of(&other->linkage, link, p, (double *)(void *)(p + most));
        if (n > 1)
            good = take_copy(s, (lw_curve){ .outline = true, .closed = n > 2, .n = n, .p = p });
    }
    for (int i = 0; i < other->n_curve && good && s->n_curve < s->max_curve; i++)
        if (other->curve[i].shown_branch && !other->curve[i].compared)
            good = take_copy(s, other->curve[i]);
    free(p);
    return good ? LW_OK : lw_error_set(e, LW_E_MEMORY, "not enough memory for the picture");
}

lw_vec2 lw_scene_at(const lw_scene *s, size_t frame, int link, lw_vec2 p)
{
    const lw_place *a = &s->place[frame*(size_t)s->linkage.n_link + (size_t)link];
    return lw_v2_add(a->at, lw_v2_turn(lw_v2_sub(p, s->origin[link]), a->turn));
}

void lw_scene_note_limit(char note[256], const char *limit, const char *name, const double reached[2], const double allowed[2], bool angle,
                         const lw_units *units)
{
    double slack = 1e-6*fmax(reached[1] - reached[0], 1e-3*fabs(reached[1])), unit = angle ? units->radian : units->metre;
    char to[2][24];
    for (int k = 0; k < 2; k++)
        snprintf(to[k], sizeof to[k], isfinite(allowed[k]) ? "%.4g" : "any", allowed[k]/unit);
    if (!note[0] && (reached[0] < allowed[0] - slack || reached[1] > allowed[1] + slack))
        snprintf(note, 256, "Shown beyond the %s \"%.40s\": about %.4g to %.4g %s instead of %s to %s; limit the input by \"first\" and \"last\"", limit, name,
                 reached[0]/unit, reached[1]/unit, angle ? units->angle : units->length[0] ? units->length : "m", to[0], to[1]);
}

static double distance_of_ends(const lw_scene *s, size_t frame, const void *spring)
{
    const lw_spring *p = spring;
    return lw_v2_norm(lw_v2_sub(lw_scene_at(s, frame, p->link[1], p->at[1]), lw_scene_at(s, frame, p->link[0], p->at[0])));
}

/* Turn, within half a turn either way, or slide from the posture. */
static double displacement(const lw_scene *s, size_t frame, const void *joint)
{
    const lw_joint *j = joint;
    const lw_place *p = &s->place[frame*(size_t)s->linkage.n_link], *a = &p[j->link[0]], *b = &p[j->link[1]];
    if (j->kind == LW_JOINT_SLIDER)
        return lw_v2_dot(lw_v2_unturn(lw_v2_sub(lw_scene_at(s, frame, j->link[1], j->at), lw_scene_at(s, frame, j->link[0], j->at)), a->turn),
                         j->along);
    lw_vec2 turn = lw_v2_unturn(b->turn, a->turn);
    return (j->link[1] == s->linkage.ground ? -1 : 1)*atan2(turn.y, turn.x);
}

static void note_limit(lw_scene *s, double (*value)(const lw_scene *, size_t, const void *), const void *part, const char *limit, const char *name,
                       const double allowed[2], bool angle)
{
    double reached[2] = { INFINITY, -INFINITY };
    for (size_t f = 0; f < s->n_frame; f++)
        reached[0] = fmin(reached[0], value(s, f, part)), reached[1] = fmax(reached[1], value(s, f, part));
    lw_scene_note_limit(s->note, limit, name, reached, allowed, angle, &s->linkage.units);
}

/* Strokes of cylinders and stops of joints that the motion passes. */
static void note_limits(lw_scene *s)
{
    const lw_model *m = s->model;
    for (int i = 0; m && i < m->n_spring; i++)
        if (m->spring[i].extent[1] > 0)
            note_limit(s, distance_of_ends, &m->spring[i], "stroke of cylinder", m->spring[i].name, m->spring[i].extent, false);
    for (int i = 0; m && m->stop && i < s->linkage.n_joint; i++) {
        const lw_joint *j = &s->linkage.joint[i];
        const lw_joint_stop *p = &m->stop[i];
        double allowed[2] = { p->has_least ? p->least : -INFINITY, p->has_greatest ? p->greatest : INFINITY };
        bool turns = j->kind == LW_JOINT_REVOLUTE, within = !turns || (fabs(p->least) < LW_PI && fabs(p->greatest) < LW_PI);
        if ((p->has_least || p->has_greatest) && within && (turns || j->kind == LW_JOINT_SLIDER))
            note_limit(s, displacement, j, "stop of joint", j->name, allowed, turns);
    }
}

static bool copy_target(lw_scene *s, const lw_target *t)
{
    if (!t || !t->x || !t->y)
        return true;
    s->station = malloc((t->n*(size_t)(1 + t->n_also) + 1)*sizeof *s->station);
    if (!s->station)
        return false;
    for (int k = 0; k <= t->n_also; k++) {
        const double *x = k > 0 ? t->also[k - 1].x : t->x, *y = k > 0 ? t->also[k - 1].y : t->y;
        for (size_t i = 0; x && i < t->n; i++)
            s->station[s->n_station++] = lw_v2(x[i], y[i]);
    }
    s->n_each = t->n;
    s->station_closed = t->closed;
    return true;
}

static bool make_frames(lw_scene *s, size_t n)
{
    size_t n_link = (size_t)s->linkage.n_link;
    s->place = malloc(n*n_link*sizeof *s->place);
    s->input = calloc(n, sizeof *s->input);
    if (!s->place || !s->input)
        return false;
    s->n_frame = n;
    for (size_t i = 0; i < n*n_link; i++)
        s->place[i] = (lw_place){ s->origin[i % n_link], { 1, 0 } };
    return true;
}

/* Choose a reference point for every link: a pin, or an added tracer where the link has no pin. */
static bool choose_references(lw_work *w)
{
    lw_linkage *k = &w->linkage;
    for (int link = 0; link < k->n_link; link++) {
        int pin = -1;
        for (int i = 0; i < k->n_joint && pin < 0; i++)
            if (lw_joint_turns(k->joint[i].kind)
                && (k->joint[i].link[0] == link || k->joint[i].link[1] == link))
                pin = i;
        w->pin[link] = pin;
        if (pin >= 0 || link == k->ground)
            continue;
        if (k->n_tracer == LW_TRACER_MAX)
            return false;
        lw_tracer *t = &k->tracer[k->n_tracer];
        *t = (lw_tracer){ .link = link };
        snprintf(t->name, sizeof t->name, "link %d", link);
        for (int i = 0; i < k->n_joint; i++)
            if (k->joint[i].link[0] == link || k->joint[i].link[1] == link)
                t->at = k->joint[i].at;
        w->pin[link] = -1 - k->n_tracer++;
    }
    return true;
}

static lw_vec2 reference(const lw_work *w, const lw_posture *posture, int link)
{
    int pin = w->pin[link];
    return pin >= 0 ? posture->joint[pin][0] : posture->tracer[-1 - pin][0];
}

static void keep_dimensions(lw_work *w)
{
    lw_scene *s = w->s;
    int own = s->linkage.n_tracer;
    for (int i = 0; i < w->plan.n_dim; i++) {
        bool added = false;                            /* a coordinate of a reference tracer added here */
        for (int t = own; t < w->linkage.n_tracer; t++)
            added = added || w->plan.i_cx[t] == i || w->plan.i_cy[t] == i;
        if (added)
            continue;
        snprintf(s->dim_name[s->n_dim], sizeof s->dim_name[0], "%s", w->plan.dim[i].name);
        s->dim_kind[s->n_dim] = w->plan.dim[i].kind;
        s->dim_link[s->n_dim] = w->plan.dim[i].link;
        s->dim[s->n_dim++] = w->dim[i];
    }
}

/* Make plan, dimensions and starting posture. False: there is no plan in closed form, or the posture does not close.
 * Dimensions are filled whenever there is a plan. */
static bool prepare(lw_work *w)
{
    bool chosen = choose_references(w);                       /* adds tracers */
    const lw_plan_options outputs = { .tracers = (1u << w->linkage.n_tracer) - 1, .all_joints = true,
                                      .kind = LW_PLAN_HIGHER };
    lw_status st = chosen ? lw_plan_make(&w->linkage, outputs, &w->plan, NULL) : LW_E_KIND;
    w->no_memory |= st == LW_E_MEMORY;
    bool any = st == LW_OK && lw_plan_read(&w->plan, &w->linkage, w->dim, w->mode, &w->input, NULL) == LW_OK;
    if (any)
        keep_dimensions(w);
    return any && w->plan.n_higher == 0
           && lw_posture_solve(&w->plan, w->dim, w->mode, w->input, 0, &w->start) == LW_OK;
}

/* Size of the linkage: diagonal of the box around its joints, in the posture shown. */
static double span(const lw_assembly *linkage)
{
    double d = 0;
    for (int i = 0; i < linkage->n_joint; i++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(linkage->joint[i].at, linkage->joint[0].at)));
    for (int i = 0; i < linkage->n_tracer; i++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(linkage->tracer[i].at, linkage->joint[0].at)));
    return d;
}

double lw_scene_dimension(const lw_scene *s, int i)
{
    const lw_units *u = &s->linkage.units;
    bool angle = s->dim_kind[i] == LW_DIM_ANGLE;
    double noise = angle ? 1e-12 : 1e-9*span(&s->linkage);
    return fabs(s->dim[i]) < noise ? 0 : s->dim[i]/(angle ? u->radian : u->metre);
}

/* Move to t of the motion. Returns the input there. */
static double move_to(lw_work *w, double t)
{
    if (w->by_path)
        return lw_motion_path_at(&w->path, t, w->q);
    lw_walk_posture(&w->walk, t, &w->posture);
    return w->posture.input;
}

static lw_place place_now(const lw_work *w, int link)
{
    if (!w->by_path)
        return (lw_place){ reference(w, &w->posture, link),
                           lw_v2_polar(1, w->posture.angle[link][0] - w->start.angle[link][0]) };
    const lw_system *s = &w->path.s;
    int body = s->body[link];
    return (lw_place){ lw_system_point(s, body, lw_system_arm(s, body, w->s->origin[link]), w->q),
                       lw_v2_polar(1, w->q[3*body + 2]) };
}

/* Fill the frames of the motion: place of each link relative to the posture shown. */
static bool take_frames(lw_work *w, size_t n)
{
    lw_scene *s = w->s;
    size_t n_link = (size_t)s->linkage.n_link;
    if (!make_frames(s, n))
        return false;
    s->loops = motion_loops(w);
    double per = motion_length(w)/(s->loops ? (double)n : (double)(n - 1));
    double start = w->by_path ? w->path.start : w->walk.turns ? 0 : lw_walk_time(&w->walk, w->input);
    s->first_frame = (size_t)fmin(round(start/per), (double)n - 1);
    for (size_t f = 0; f < n && !is_stopped(w); f++) {
        s->input[f] = move_to(w, f == s->first_frame ? start : per*(double)f);
        for (size_t link = 0; link < n_link; link++)
            if ((int)link != s->linkage.ground)
                s->place[f*n_link + link] = place_now(w, (int)link);
    }
    return true;
}

typedef struct lw_growing { lw_vec2 *p; size_t n, capacity; bool failed; } lw_growing;

static void grow(lw_growing *g, lw_vec2 p)
{
    if (g->n == g->capacity) {
        size_t capacity = g->capacity ? 2*g->capacity : 1024;
        lw_vec2 *q = realloc(g->p, capacity*sizeof *q);
        g->failed = g->failed || !q;
        if (!q)
            return;
        g->p = q;
        g->capacity = capacity;
    }
    g->p[g->n++] = p;
}

static lw_vec2 trace(lw_work *w, int tracer, double t)
{
    move_to(w, t);
    if (!w->by_path)
        return w->posture.tracer[tracer][0];
    const lw_system *s = &w->path.s;
    return lw_system_point(s, s->tracer_body[tracer], s->tracer_arm[tracer], w->q);
}

/* Add points between t0 (point a, left out) and t1 (point b, included). Steps are halved until they are nearly
 * straight. A step that is still long is a jump from one end of an asymptote to the other: the line is interrupted
 * there. */
static void refine(lw_work *w, int tracer, double t0, lw_vec2 a, double t1, lw_vec2 b, double size,
                   int depth, lw_growing *g)
{
    double tm = t0 + (t1 - t0)/2;
    lw_vec2 m = trace(w, tracer, tm), chord = lw_v2_sub(b, a);
    double off = lw_v2_norm(lw_v2_sub(m, lw_v2_add(a, lw_v2_scale(chord, 0.5))));
    if (depth == 0 || g->n > POINTS_MAX || off < 4e-4*size || is_stopped(w)) {
        if (depth == 0 && lw_v2_norm(chord) > 0.1*size)
            grow(g, lw_v2(NAN, NAN));
        grow(g, b);
        return;
    }
    refine(w, tracer, t0, a, tm, m, size, depth - 1, g);
    refine(w, tracer, tm, m, t1, b, size, depth - 1, g);
}

static bool take_curve(lw_work *w, int tracer, bool shown, size_t n)
{
    lw_scene *s = w->s;
    lw_growing g = { 0 };
    bool loops = motion_loops(w);
    double size = 1e-9*span(&s->linkage), per = motion_length(w)/(double)n;
    lw_vec2 first = trace(w, tracer, 0), a = first;
    for (size_t i = 1; i < n; i++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(trace(w, tracer, per*(double)i), first)));
    grow(&g, first);
    for (size_t i = 1; i <= n; i++) {
        double t = i == n ? motion_length(w) : per*(double)i;
        lw_vec2 b = trace(w, tracer, t);
        refine(w, tracer, per*(double)(i - 1), a, t, b, size, 14, &g);
        a = b;
    }
    if (loops && g.n > 1)
        g.n--;                                         /* the last point equals the first */
    s->curve[s->n_curve++] = (lw_curve){ .tracer = tracer, .shown_branch = shown,
                                         .closed = loops, .n = g.n, .p = g.p };
    return !g.failed;
}

/* Does the file ask for a part of the input's range, and is the posture shown inside that part? */
static bool is_restricted(const lw_work *w)
{
    const lw_input *in = &w->linkage.input[0];
    double first = fmin(in->first, in->last), last = fmax(in->first, in->last);
    double tolerance = 1e-9*(last - first);
    bool full = !lw_joint_slides(w->linkage.joint[in->joint].kind) && last - first >= 2*LW_PI*(1 - 1e-12);
    return first < last && !full && in->value >= first - tolerance && in->value <= last + tolerance;
}

static bool take_curves(lw_work *w, bool shown, size_t n)
{
    for (int i = 0; n > 0 && i < w->s->linkage.n_tracer && !is_stopped(w); i++)
        if (!take_curve(w, i, shown, n < 8 ? 8 : n))
            return false;
    return true;
}

/* Add curves of the other circuits while there is space for them. False: out of memory. */
static bool take_others(lw_work *w, size_t n)
{
    const lw_walk own = w->walk;
    int shown = w->motion.arc[own.stage[0].arc].circuit, done[LW_ARC_MAX] = { 0 };
    bool ok = true;
    for (int i = 0; i < w->motion.n_arc && ok; i++) {
        int circuit = w->motion.arc[i].circuit;
        if (circuit == shown || done[circuit]++ || w->s->n_curve + LW_TRACER_MAX > LW_CURVE_MAX/2)
            continue;
        lw_walk_make(&w->plan, w->dim, &w->motion, i, w->motion.arc[i].first, &w->walk);
        ok = take_curves(w, false, n);
    }
    w->walk = own;
    return ok;
}

/* Find the walk through the posture shown; its input counts turns as the arc does. False: not found. */
static bool find_walk(lw_work *w)
{
    lw_status st = lw_motion_find(&w->plan, w->dim, &w->motion);
    w->no_memory |= st == LW_E_MEMORY;
    if (st < 0 || w->motion.change_point)
        return false;                                  /* through change points the motion curve goes straight on */
    int arc = lw_motion_arc(&w->plan, &w->motion, w->mode, w->input);
    if (arc < 0)
        return false;
    const lw_arc *a = &w->motion.arc[arc];
    if (!w->plan.input_is_slider && !a->turns)
        w->input -= 2*LW_PI*round((w->input - (a->first + a->last)/2)/(2*LW_PI));
    lw_walk_make(&w->plan, w->dim, &w->motion, arc, w->input, &w->walk);
    return true;
}

static bool draft_by_frames(lw_work *w, const lw_scene_options *o);

/* Compute curves and frames by the plan. False: out of memory. */
static bool show_walk(lw_work *w, const lw_scene_options *o)
{
    const lw_input *in = &w->linkage.input[0];
    if (o->other_branches && !take_others(w, o->n_curve_point))
        return false;
    if (is_restricted(w)) {
        if (!o->draft && !take_curves(w, false, o->n_curve_point))
            return false;
        lw_walk_restrict(&w->walk, w->input + (fmin(in->first, in->last) - in->value),
                         w->input + (fmax(in->first, in->last) - in->value));
    }
    if (o->draft)
        return draft_by_frames(w, o);
    return take_curves(w, true, o->n_curve_point)
        && take_frames(w, o->n_frame < 2 ? 2 : o->n_frame);
}

/* ---- motions without a plan --------------------------------------------------------------------- */

/* Prescribed motion of all inputs: each moves evenly, in the time 0 .. 1, from the first to the last value that the
 * linkage gives for it. Inputs without such values rest. */
static void sweep(void *linkage, double t, int order, double *u)
{
    const lw_linkage *k = linkage;
    for (int i = 0; i < lw_linkage_free_inputs(k); i++) {
        const lw_input *in = &k->input[i];
        double *out = u + i*(order + 1), range = in->last - in->first;
        memset(out, 0, (size_t)(order + 1)*sizeof *out);
        out[0] = range != 0 ? in->first + t*range : in->value;
        if (order > 0)
            out[1] = range;
    }
}

typedef struct inputs_in_time { const lw_model *model; double *value; } inputs_in_time;    /* value: (4*inputs) scratch */

static bool inputs_are_alike(void *context, double a, double b)
{
    inputs_in_time *c = context;
    int n = 2*lw_assembly_free_inputs(&c->model->linkage);
    double *u = c->value, *v = u + n;
    lw_prescribed_motion_of_model((void *)c->model, a, 1, u);
    lw_prescribed_motion_of_model((void *)c->model, b, 1, v);
    for (int i = 0; i < n; i++)
        if (!(fabs(u[i] - v[i]) <= LW_INPUTS_ALIKE*(1 + fabs(u[i]))))
            return false;
    return true;
}

/* How long a motion in time is shown [s]. */
static lw_status duration(const lw_model *m, const lw_scene_options *o, double *out)
{
    inputs_in_time c = { m, malloc(4*(size_t)m->linkage.n_input*sizeof *c.value) };
    if (!c.value)
        return LW_E_MEMORY;
    *out = o->until > 0 ? o->until : lw_motion_path_duration(inputs_are_alike, &c);
    free(c.value);
    return LW_OK;
}

/* Fix links whose rotation changes nothing else (a roller on its pin). False: there is none. */
static bool fasten_idle_links(lw_work *w)
{
    lw_linkage *linkage = &w->linkage;
    lw_mobility *m = malloc(sizeof *m);
    const lw_mobility_options o = lw_mobility_options_default();
    lw_status st = m ? lw_mobility_find(linkage, &o, m, NULL) : LW_E_MEMORY;
    uint32_t idle = st == LW_OK ? m->idle_links : 0;
    bool any = false;
    w->no_memory |= st == LW_E_MEMORY;
    free(m);
    for (int link = 0; link < linkage->n_link; link++)
        for (int i = 0; i < linkage->n_joint && idle >> link & 1; i++) {
            lw_joint *j = &linkage->joint[i];
            if (!lw_joint_turns(j->kind) || (j->link[0] != link && j->link[1] != link))
                continue;
            j->kind = LW_JOINT_FIXED;
            any = true;
            break;
        }
    return any;
}

/* Do several inputs move at once, by motions in time or through ranges? */
static bool move_together(const lw_linkage *k, const lw_scene_options *o, bool *motions)
{
    bool ranges = false;
    *motions = false;
    for (int i = 0; i < k->n_input && lw_linkage_free_inputs(k) > 1; i++) {
        *motions = *motions || (o->model && o->model->motion[i]);
        ranges = ranges || k->input[i].first != k->input[i].last;
    }
    return *motions || ranges;
}

/* Start a motion path: all inputs move at once if the linkage says how each of them moves, else the first one alone. */
static lw_status start_path(lw_work *w, const lw_scene_options *o, lw_error *why)
{
    const lw_linkage *k = &w->linkage;
    bool motions, together = move_together(k, o, &motions);
    double last = 0;
    if (motions && duration(o->model, o, &last) != LW_OK)
        return lw_error_set(why, LW_E_MEMORY, "out of memory");
    if (motions)
        return lw_motion_path_in_time(k, lw_prescribed_motion_of_model, (void *)o->model, 0, last, &w->path, why);
    if (together)
        return lw_motion_path_in_time(k, sweep, &w->linkage, 0, 1, &w->path, why);
    lw_status st = lw_motion_path_along(k, o->other_branches, &w->path, why);
    if (st != LW_E_ARG || k->n_input == 0 || !fasten_idle_links(w))
        return st;
    lw_motion_path_free(&w->path);
    return lw_motion_path_along(k, o->other_branches, &w->path, why);
}

/* ---- a draft: the motion quickly, for a linkage that is being dragged --------------------------------------
 * By the plan, without the proof that no gap is passed over between two inputs; else by the steps of Newton's method
 * (mbs/constraints/newton.h) and on cubics between them, without the other assembly modes past a limit. */

enum { TURNS = 12, NODES = 500 };                /* after so many turns, or steps, a motion that does not repeat is cut */
enum { DRAFT_STEPS = 96, DRAFT_STAGES = 6 };     /* inputs tried in a turn; arcs of a walk                             */

static const double draft_step = 0.25;          /* longest step [1], see lw_newton_step                   */
static const double draft_margin = 1e-3;        /* nearer to a change point the plan does not decide the way */

/* Curves of all tracers through the frames, with about n points each: cubics with the slopes of Catmull and Rom. */
static lw_status draft_curves(lw_scene *s, size_t n)
{
    size_t frames = s->n_frame, parts = s->loops ? frames : frames - 1, each = (n + parts - 1)/parts;
    if (frames < 2 || n == 0)
        return LW_OK;
    for (int t = 0; t < s->linkage.n_tracer && s->n_curve < s->max_curve; t++) {
        const lw_tracer *tracer = &s->linkage.tracer[t];
        lw_curve c = { .tracer = t, .shown_branch = true, .closed = s->loops, .n = parts*each + !s->loops };
        if (!(c.p = malloc(c.n*sizeof *c.p)))
            return LW_E_MEMORY;
        for (size_t i = 0; i < parts; i++) {
            size_t at[4] = { i ? i - 1 : s->loops ? frames - 1 : 0, i, (i + 1) % frames,
                             i + 2 < frames ? i + 2 : s->loops ? (i + 2) % frames : frames - 1 };
            lw_vec2 p[4];
            for (int k = 0; k < 4; k++)
                p[k] = lw_scene_at(s, at[k], tracer->link, tracer->at);
            lw_vec2 v = lw_v2_scale(lw_v2_sub(p[2], p[0]), 0.5), w = lw_v2_scale(lw_v2_sub(p[3], p[1]), 0.5);
            for (size_t k = 0; k < each; k++) {
                double x = (double)k/(double)each, y = 1 - x;
                lw_vec2 q = lw_v2_add(lw_v2_scale(p[1], y*y*(1 + 2*x)), lw_v2_scale(p[2], x*x*(1 + 2*y)));
                c.p[i*each + k] = lw_v2_add(q, lw_v2_sub(lw_v2_scale(v, x*y*y), lw_v2_scale(w, x*x*y)));
            }
        }
        if (!s->loops)
            c.p[c.n - 1] = lw_scene_at(s, frames - 1, tracer->link, tracer->at);
        s->curve[s->n_curve++] = c;
    }
    return LW_OK;
}

/* Drop every second frame, but not the one of the posture shown. */
static void draft_thin(lw_scene *s)
{
    size_t n_link = (size_t)s->linkage.n_link, odd = s->first_frame % 2, n = (s->n_frame - odd + 1)/2;
    if (n < 2)
        return;
    for (size_t f = 0; f < n; f++) {
        memmove(s->place + f*n_link, s->place + (2*f + odd)*n_link, n_link*sizeof *s->place);
        s->input[f] = s->input[2*f + odd];
    }
    s->n_frame = n;
    s->first_frame /= 2;
}

/* Frames of w, and curves through twice as many.  False: out of memory. */
static bool draft_by_frames(lw_work *w, const lw_scene_options *o)
{
    if (!take_frames(w, 2*(o->n_frame < 2 ? 2 : o->n_frame)) || draft_curves(w->s, o->n_curve_point) != LW_OK)
        return false;
    draft_thin(w->s);
    return true;
}

static bool plan_closes(lw_work *w, const double *mode, double input)
{
    return lw_posture_solve(&w->plan, w->dim, mode, input, 0, &w->posture) == LW_OK;
}

/* The last input from `from` towards `end` that closes, looked for in `steps` steps; lowers *least to the margins met. */
static double plan_end(lw_work *w, const double *mode, double from, double end, int steps, double *least)
{
    double good = 0, bad = 2;
    for (int i = 1; i <= steps && bad > 1; i++)
        if (plan_closes(w, mode, from + (end - from)*i/steps)) {
            good = (double)i/steps;
            *least = fmin(*least, w->posture.margin);
        } else
            bad = (double)i/steps;
    while (bad <= 1 && bad - good > 1e-12) {
        double middle = 0.5*(good + bad);
        *(plan_closes(w, mode, from + (end - from)*middle) ? &good : &bad) = middle;
    }
    return good == 1 ? end : from + (end - from)*good;
}

static bool has_mode(const lw_plan *p, int dyad)
{
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].dyad == dyad && (p->step[i].kind == LW_STEP_PRP || p->step[i].kind == LW_STEP_PPR))
            return false;
    return true;
}

/* The assembly mode beyond a limit: it differs in one dyad and has the same posture there.  Returns how many there are. */
static int mode_beyond(lw_work *w, const double *mode, double limit, double *next)
{
    lw_posture here, there;
    int n = 0, flips = 0;
    lw_posture_solve(&w->plan, w->dim, mode, limit, 0, &here);
    memcpy(next, mode, sizeof w->mode);
    for (int i = 0; i < w->plan.n_dyad; i++) {
        next[i] = -next[i];
        lw_posture_solve(&w->plan, w->dim, next, limit, 0, &there);
        next[i] = -next[i];
        if (has_mode(&w->plan, i) && lw_plan_posture_distance(&w->plan, &here, &there) < 1e-4*span(&w->s->linkage)) {
            n++;
            flips = i;
        }
    }
    next[flips] = n == 1 ? -next[flips] : next[flips];
    return n;
}

/* The walk from the posture shown, along the plan: a full turn, or from limit to limit and back in the other assembly
 * modes.  False: near a change point. */
static bool draft_walk(lw_work *w)
{
    bool slides = w->plan.input_is_slider;
    double least = 1, none = 1, way = slides ? 8*span(&w->s->linkage) : 2*LW_PI;
    double last = plan_end(w, w->mode, w->input, w->input + way, DRAFT_STEPS, &least);
    bool turns = !slides && last == w->input + way;
    double first = turns ? w->input : plan_end(w, w->mode, w->input, w->input - way, DRAFT_STEPS, &none);
    lw_walk *k = &w->walk;
    *k = (lw_walk){ .plan = &w->plan, .dim = w->dim, .n_stage = 1, .loops = turns, .turns = turns };
    k->stage[0] = (lw_walk_stage){ .from = first, .to = last };
    memcpy(k->stage[0].mode, w->mode, sizeof w->mode);
    if (turns || !(last > first))
        return turns && least > draft_margin;
    if (slides && (last == w->input + way || first == w->input - way))
        return true;
    while (k->n_stage < DRAFT_STAGES) {
        const lw_walk_stage *s = &k->stage[k->n_stage - 1];
        lw_walk_stage *next = &k->stage[k->n_stage];
        double end = s->to + (s->from < s->to ? -way : way);
        int n = mode_beyond(w, s->mode, s->to, next->mode);
        k->loops = n == 1 && fabs(s->to - first) < 1e-6*way
                   && memcmp(next->mode, w->mode, (size_t)w->plan.n_dyad*sizeof *w->mode) == 0;
        if (n != 1 || k->loops)
            return n < 2;
        next->from = s->to;
        next->to = plan_end(w, next->mode, s->to, end, DRAFT_STEPS, &none);
        if (next->to == end || next->to == next->from)
            break;
        if (!plan_closes(w, next->mode, 0.5*(next->from + next->to)) || w->posture.margin < 1e-6)
            return false;                                       /* two links lie on each other: the plan does not move */
        k->n_stage++;
    }
    return true;
}

/* The steps of a motion, in the order of the input. */
typedef struct draft_nodes { double *q; size_t n, size; bool failed; } draft_nodes;

static void draft_keep(draft_nodes *d, const lw_newton *m)
{
    if (d->n % 64 == 0) {
        double *q = realloc(d->q, (d->n + 64)*d->size*sizeof *q);
        d->failed = d->failed || !q;
        d->q = q ? q : d->q;
    }
    if (!d->failed)
        lw_newton_keep(m, d->q + d->size*d->n++);
}

/* Step from the present posture to `input`, and keep the postures on the way. */
static lw_status draft_go(draft_nodes *d, lw_newton *m, double input)
{
    lw_status st = LW_STOPPED;
    while (st == LW_STOPPED && d->n < NODES && !d->failed) {
        st = lw_newton_step(m, input, draft_step);
        if (st >= 0)
            draft_keep(d, m);
    }
    return d->failed ? LW_E_MEMORY : st;
}

static bool is_back(const lw_newton *m, int n_link)
{
    for (int i = 0; i < n_link; i++)
        if (fabs(remainder(lw_newton_angle(m, i), 2*LW_PI)) > 1e-6)
            return false;
    return true;
}

static void draft_reverse(draft_nodes *d)
{
    for (size_t i = 0; i < d->n/2; i++)
        for (size_t k = 0; k < d->size; k++) {
            double *a = d->q + d->size*i + k, *b = d->q + d->size*(d->n - 1 - i) + k, old = *a;
            *a = *b;
            *b = old;
        }
}

/* Step through the whole motion: turns until it is back where it began, else from limit to limit, only within
 * range[0] .. range[1] if range is not NULL.  A branch that is lost ends it: *lost. */
static lw_status draft_steps(draft_nodes *d, lw_newton *m, lw_scene *s, const double *range, bool *lost)
{
    bool slides = lw_joint_slides(s->linkage.joint[s->linkage.input[0].joint].kind);
    double now = lw_newton_input(m), far = slides ? 8*span(&s->linkage) : 2*LW_PI;
    lw_status st = LW_OK;
    draft_keep(d, m);
    for (int turn = 1; turn <= (range || slides ? 1 : TURNS) && st == LW_OK && !s->loops; turn++) {
        st = draft_go(d, m, range ? range[1] : now + turn*far);
        s->loops = st == LW_OK && !range && !slides && (is_back(m, s->linkage.n_link) || turn == TURNS);
    }
    *lost = st == LW_E_NUMERIC || st == LW_STOPPED;
    if (s->loops || st == LW_E_MEMORY)
        return st;
    size_t up = d->n;
    lw_newton_reset(m);
    draft_nodes down = { .size = d->size };
    st = draft_go(&down, m, range ? range[0] : now - far);
    *lost = *lost || st == LW_E_NUMERIC || st == LW_STOPPED;
    draft_reverse(&down);
    double *q = realloc(d->q, (up + down.n + 1)*d->size*sizeof *q);
    if (q) {
        d->q = q;
        memmove(q + down.n*d->size, q, up*d->size*sizeof *q);
        if (down.n)
            memcpy(q, down.q, down.n*d->size*sizeof *q);
        d->n = up + down.n;
    }
    free(down.q);
    return !q || st == LW_E_MEMORY ? LW_E_MEMORY : LW_OK;
}

/* Move m to `input`, between node *at or a later one and the next. */
static void draft_place(const draft_nodes *d, lw_newton *m, double input, size_t *at)
{
    double lo = 0, hi = 1;
    for (lw_newton_between(m, d->q, d->q, 1); *at + 2 < d->n; ++*at) {
        const double *next = d->q + d->size*(*at + 1);
        lw_newton_between(m, next, next, 1);
        if (lw_newton_input(m) >= input)
            break;
    }
    for (int i = 0; i < 30; i++) {
        double x = 0.5*(lo + hi);
        lw_newton_between(m, d->q + d->size**at, d->q + d->size*(*at + 1), x);
        *(lw_newton_input(m) < input ? &lo : &hi) = x;
    }
}

static bool draft_frames(lw_scene *s, const draft_nodes *d, lw_newton *m, double now, size_t n)
{
    const double *last = d->q + d->size*(d->n - 1);
    if (!make_frames(s, n))
        return false;
    lw_newton_between(m, d->q, d->q, 0);
    double from = lw_newton_input(m);
    lw_newton_between(m, last, last, 1);
    double to = lw_newton_input(m), middle = 0.5*(from + to), half = 0.5*(to - from);
    if (!s->loops)
        s->first_frame = (size_t)round(acos(fmin(fmax((middle - now)/half, -1), 1))/LW_PI*(double)(n - 1));
    size_t at = 0, n_link = (size_t)s->linkage.n_link;
    for (size_t f = 0; f < n; f++) {
        s->input[f] = f == s->first_frame ? now : s->loops ? from + (to - from)*(double)f/(double)n
                                                           : middle - half*cos(LW_PI*(double)f/(double)(n - 1));
        draft_place(d, m, s->input[f], &at);
        for (size_t i = 0; i < n_link && f != s->first_frame; i++)
            s->place[f*n_link + i] = (lw_place){ lw_newton_point(m, (int)i, s->origin[i]),
                                                 lw_v2_polar(1, lw_newton_angle(m, (int)i)) };
    }
    return true;
}

static bool draft_lines(lw_scene *s, const draft_nodes *d, lw_newton *m, size_t n)
{
    size_t parts = d->n - 1, each = (n + parts - 1)/parts, first = (size_t)s->n_curve;
    for (int t = 0; t < s->linkage.n_tracer && s->n_curve < s->max_curve; t++) {
        lw_curve *c = &s->curve[s->n_curve];
        *c = (lw_curve){ .tracer = t, .shown_branch = true, .closed = s->loops, .n = parts*each + !s->loops };
        if (!(c->p = malloc((parts*each + 1)*sizeof *c->p)))
            return false;
        s->n_curve++;
    }
    for (size_t i = 0; i <= parts*each && (int)first < s->n_curve; i++) {
        size_t part = i < parts*each ? i/each : parts - 1;
        const double *a = d->q + d->size*part;
        lw_newton_between(m, a, a + d->size, (double)(i - part*each)/(double)each);
        for (size_t c = first; c < (size_t)s->n_curve; c++)
            s->curve[c].p[i] = lw_newton_tracer(m, s->curve[c].tracer);
    }
    return true;
}

/* The draft of any linkage by steps.  LW_E_MEMORY, LW_E_ARG: as lw_newton_create, without a scene.  Other faults of
 * lw_newton_create give a scene that does not move. */
static lw_status draft_by_steps(lw_scene *s, const lw_linkage *linkage, const double *range, const lw_scene_options *o)
{
    lw_newton *m = NULL;
    lw_error e = { 0 };
    bool lost = false;
    lw_status st = lw_newton_create(linkage, &m, &e);
    draft_nodes d = { .size = m ? lw_newton_node_size(m) : 0 };
    double now = m ? lw_newton_input(m) : 0;
    if (st == LW_OK)
        st = draft_steps(&d, m, s, range, &lost);
    bool moves = st == LW_OK && d.n > 1;
    if (moves && !(draft_frames(s, &d, m, now, o->n_frame < 2 ? 2 : o->n_frame) && draft_lines(s, &d, m, o->n_curve_point)))
        st = LW_E_MEMORY;
    if (st != LW_E_MEMORY && st != LW_E_ARG && !moves) {
        st = make_frames(s, 1) ? LW_OK : LW_E_MEMORY;
        snprintf(s->note, sizeof s->note, "Shown without motion: %.200s",
                 e.text[0] ? e.text : "two branches of the motion are too close to each other here");
    } else if (lost)
        snprintf(s->note, sizeof s->note, "Shown in part while it is dragged: the rest takes longer to follow");
    free(d.q);
    lw_newton_free(m);
    return st;
}

static bool show_course(lw_work *w, const lw_scene_options *o)
{
    lw_error why = { 0 };
    lw_scene *s = w->s;
    size_t n = o->n_curve_point;
    const lw_input *in = &w->linkage.input[0];
    w->linkage = *w->given;                                       /* without added tracers */
    w->by_path = true;
    bool motions;
    if (o->draft && w->linkage.n_input > 0 && !move_together(&w->linkage, o, &motions)) {
        double range[2] = { fmin(in->first, in->last), fmax(in->first, in->last) };
        lw_status drafted = draft_by_steps(s, w->given, is_restricted(w) ? range : NULL, o);
        if (drafted != LW_E_ARG)
            return drafted == LW_OK;
    }
    lw_status st = start_path(w, o, &why);
    if (st == LW_E_MEMORY || w->no_memory)
        return false;
    if (st == LW_OPEN && w->path.drive)
        snprintf(s->note, sizeof s->note, "Shown in part: %.200s", why.text);
    else if (st != LW_OK) {
        snprintf(s->note, sizeof s->note, "Shown without motion: %.200s",
                 why.text[0] ? why.text : lw_status_text(st));
        return make_frames(s, 1);
    }
    if (o->draft && w->path.drive)
        return draft_by_frames(w, o);
    for (int i = 1; i < w->path.curves.n && s->n_curve + LW_TRACER_MAX <= LW_CURVE_MAX/2; i++) {
        lw_motion_path_choose(&w->path, i);
        if (!take_curves(w, false, n))
            return false;
    }
    if (!w->path.drive)
        lw_motion_path_choose(&w->path, 0);
    n *= (size_t)fmin(fmax(w->path.turns, 1), 20);
    if (!w->path.drive && is_restricted(w)) {
        if (!take_curves(w, false, n))
            return false;
        lw_motion_path_restrict(&w->path, fmin(in->first, in->last), fmax(in->first, in->last));
    }
    return take_curves(w, true, n) && take_frames(w, o->n_frame < 2 ? 2 : o->n_frame);
}

/* ---- all of it ---------------------------------------------------------------------------------- */

static bool show_motion(lw_work *w, const lw_scene_options *o)
{
    bool walks = prepare(w) && (o->draft ? draft_walk(w) : find_walk(w));
    for (int i = 0; i < w->s->linkage.n_link && walks; i++)
        if (i != w->s->linkage.ground)
            w->s->origin[i] = reference(w, &w->start, i);
    if (w->no_memory)
        return false;
    return walks ? show_walk(w, o) : show_course(w, o);
}

/* Title, parts, target and room of a scene. */
static bool begin(lw_scene *s, const lw_assembly *parts, const lw_target *t, const lw_scene_options *o)
{
    lw_text_clean(s->title, sizeof s->title, o->title ? o->title : parts->name);
    s->model = o->model;
    s->stop = o->stop;
    s->max_curve = LW_CURVE_MAX + (parts->n_tracer > LW_TRACER_MAX ? parts->n_tracer : 0);
    s->curve = calloc((size_t)s->max_curve, sizeof *s->curve);
    s->origin = calloc((size_t)parts->n_link + 1, sizeof *s->origin);
    if (!s->curve || !s->origin || lw_assembly_copy(parts, &s->linkage) != LW_OK)
        return false;
    for (int j = 0; j < parts->n_joint; j++)
        for (int end = 0; end < 2; end++)
            s->origin[parts->joint[j].link[end]] = parts->joint[j].at;
    return copy_target(s, t);
}

/* What was stopped is not shown in part. */
static bool drop_motion(lw_scene *s)
{
    while (s->n_curve > 0)
        free(s->curve[--s->n_curve].p);
    free(s->place), free(s->input);
    s->place = NULL, s->input = NULL;
    s->loops = false;
    s->first_frame = 0;
    snprintf(s->note, sizeof s->note, "Shown without motion: stopped");
    return make_frames(s, 1);
}

lw_status lw_scene_make(const lw_linkage *linkage, const lw_target *t, const lw_scene_options *o,
                        lw_scene *s, lw_error *e)
{
    lw_scene_options standard = lw_scene_options_default();
    o = o ? o : &standard;
    *s = (lw_scene){ .n_frame = 0 };
    lw_status st = lw_linkage_check(linkage, e);
    if (st != LW_OK)
        return st;
    lw_assembly parts = lw_linkage_view(linkage);
    lw_work *w = calloc(1, sizeof *w);
    bool ok = w && begin(s, &parts, t, o);
    if (ok) {
        w->s = s;
        w->given = linkage;
        w->linkage = *linkage;
        ok = show_motion(w, o) && (!is_stopped(w) || drop_motion(s));
        lw_motion_path_free(&w->path);
    }
    free(w);
    if (ok)
        return LW_OK;
    lw_scene_free(s);
    return lw_error_set(e, LW_E_MEMORY, "not enough memory for the motion of the linkage");
}

/* ---- models of any size ------------------------------------------------------------------------- */

/* Frames first, first + step .. before last, from where f is, at time[k]. */
static lw_status large_frames(lw_scene *s, lw_follow *f, size_t first, size_t last, int step, const double *time, lw_error *why)
{
    const lw_system *sys = lw_follow_system(f);
    size_t n_link = (size_t)s->linkage.n_link;
    for (size_t k = first; k != last; k = (size_t)((long)k + step)) {
        lw_status st = lw_follow_to(f, time[k], why);
        if (st == LW_OPEN)
            lw_error_set(why, st, "the motion meets a limit where none was before, at %.9g", lw_follow_time(f));
        if (st != LW_OK)
            return st;
        const double *q = lw_follow_series(f);
        for (size_t i = 0; i < n_link; i++) {
            int body = sys->body[i];
            if (body >= 0)
                s->place[k*n_link + i] = (lw_place){ lw_system_point(sys, body, lw_system_arm(sys, body, s->origin[i]), q),
                                                     lw_v2_polar(1, q[3*body + 2]) };
        }
        s->input[k] = time[k];
    }
    return LW_OK;
}

static lw_status large_motion(const lw_model *m, const lw_scene_options *o, lw_scene *s, lw_error *why)
{
    const lw_assembly *a = &m->linkage;
    size_t n = o->n_frame < 2 ? 2 : 2*o->n_frame;             /* thinned by half at the end */
    bool timed = false;
    for (int i = 0; i < a->n_input; i++)
        timed = timed || m->motion[i];
    if (a->n_input == 0)
        return lw_error_set(why, LW_E_ARG, "it has no input");
    const lw_input *in = &a->input[0];
    bool slides = lw_joint_slides(a->joint[in->joint].kind), ranged = in->first != in->last;
    double now = timed ? 0 : in->value, ends[2] = { now, now + 2*LW_PI };
    if (timed && duration(m, o, &ends[1]) != LW_OK)
        return lw_error_set(why, LW_E_MEMORY, "out of memory");
    if (!timed && ranged)
        ends[0] = fmin(in->first, in->last), ends[1] = fmax(in->first, in->last);
    else if (!timed && slides)
        ends[0] = now - span(a), ends[1] = now + span(a);
    lw_follow *f;
    lw_input_function *motion = timed ? lw_prescribed_motion_of_model : lw_prescribed_motion_first_alone;
    lw_status st = lw_follow_create(m, motion, (void *)(uintptr_t)m, now, o->stop, &f, why);
    if (st != LW_OK)
        return st;
    lw_error ignored = { 0 };
    bool open[2] = { false, false };
    for (int side = 1; side >= 0; side--) {                   /* how far it goes; a whole turn from below too where above is a limit */
        if (side == 0 && open[1] && !timed && !ranged && !slides)
            ends[0] = now - 2*LW_PI;
        if (ends[side] == now)
            continue;
        st = lw_follow_to(f, ends[side], &ignored);
        open[side] = st == LW_OPEN;
        if (open[side])
            ends[side] = now + (lw_follow_time(f) - now)*(1 - 1e-6);
        lw_follow_free(f);
        if ((st != LW_OK && st != LW_OPEN) || (st = lw_follow_create(m, motion, (void *)(uintptr_t)m, now, o->stop, &f, why)) != LW_OK)
            return !why->text[0] ? lw_error_set(why, st, "%.200s", ignored.text) : st;
    }
    if (timed && open[1])
        snprintf(s->note, sizeof s->note, "Shown in part: the motions lead beyond a limit of the linkage at t = %.6g s", ends[1]);
    s->loops = !timed && !open[0] && !open[1] && !ranged && !slides;
    double span_of = ends[1] - ends[0], share = span_of > 0 ? fmin(fmax((now - ends[0])/span_of, 0), 1) : 0;
    size_t start = (size_t)round(share*(double)(n - 1));
    start -= start % 2;                                       /* it stays when the frames are thinned */
    double *time = malloc(n*sizeof *time);
    if (!time || !make_frames(s, n))
        st = lw_error_set(why, LW_E_MEMORY, "out of memory");
    s->first_frame = start;
    for (size_t k = 0; time && k < n; k++)                    /* the posture of the file is a frame */
        time[k] = s->loops ? ends[0] + span_of*(double)k/(double)n
                : k < start ? ends[0] + (now - ends[0])*(double)k/(double)start
                : now + (ends[1] - now)*(double)(k - start)/(double)(n - 1 - start + (start == n - 1));
    if (st == LW_OK && start > 0)
        st = large_frames(s, f, start, (size_t)-1, -1, time, why);
    if (st == LW_OK)
        st = large_frames(s, f, start, n, 1, time, why);
    lw_follow_free(f);
    free(time);
    if (st != LW_OK && st != LW_E_MEMORY) {
        free(s->place);
        free(s->input);
        s->place = NULL, s->input = NULL, s->n_frame = 0, s->first_frame = 0, s->loops = false;
    }
    return st;
}

static lw_status make_large(const lw_model *m, const lw_target *t, const lw_scene_options *o, lw_scene *s, lw_error *e)
{
    lw_scene_options standard = lw_scene_options_default();
    lw_error why = { 0 };
    o = o ? o : &standard;
    *s = (lw_scene){ .n_frame = 0 };
    bool ok = begin(s, &m->linkage, t, o);
    lw_status st = ok ? large_motion(m, o, s, &why) : LW_E_MEMORY;
    ok = ok && st != LW_E_MEMORY;
    if (ok && st == LW_OK)
        ok = draft_curves(s, o->n_curve_point) == LW_OK;
    if (ok && st == LW_OK)
        draft_thin(s);
    else if (ok) {
        snprintf(s->note, sizeof s->note, "Shown without motion: %.200s", why.text[0] ? why.text : lw_status_text(st));
        ok = make_frames(s, 1);
    }
    if (ok)
        return LW_OK;
    lw_scene_free(s);
    return lw_error_set(e, LW_E_MEMORY, "not enough memory for the motion of the model");
}

/* Where no input has a range or a motion, the range of the first is that of the stop of its joint. */
static void limit_by_stop(const lw_model *m, lw_linkage *k)
{
    lw_input *in = &k->input[0];
    const lw_joint_stop *p = m->stop && k->n_input > 0 ? &m->stop[in->joint] : NULL;
    for (int i = 0; i < k->n_input; i++)
        if (k->input[i].first != k->input[i].last || m->motion[i])
            return;
    if (p && p->has_least && p->has_greatest)
        in->first = in->value + p->least, in->last = in->value + p->greatest;
}

lw_status lw_scene_make_any(const lw_assembly *parts, const lw_model *m, const lw_target *t, const lw_scene_options *o,
                            lw_scene *s, lw_error *e)
{
    lw_model own = { .n_spring = 0 };
    lw_status st = m ? LW_OK : lw_assembly_check(parts, e);
    *s = (lw_scene){ .n_frame = 0 };
    if (st == LW_OK && !m && lw_model_from_assembly(parts, &own) != LW_OK)
        st = lw_error_set(e, LW_E_MEMORY, "not enough memory for the motion of the linkage");
    m = m ? m : &own;
    if (st == LW_OK && m->small) {
        lw_linkage with = *m->small;
        limit_by_stop(m, &with);
        st = lw_scene_make(&with, t, o, s, e);
    } else if (st == LW_OK)
        st = make_large(m, t, o, s, e);
    if (st == LW_OK)
        note_limits(s);
    lw_model_free(&own);
    return st;
}

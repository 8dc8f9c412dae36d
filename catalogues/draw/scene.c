/* catalogues/draw/scene.c - curves and motion of a linkage: along its plan, or along its motion curve; see scene.h. */
#include "catalogues/draw/scene_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/growable_array.h"
#include "base/real.h"
#include "grammar/model/model.h"
#include "mbs/constraints/mobility.h"

#define POINTS_MAX 50000        /* of a curve: beyond, its steps are no longer halved */

typedef struct growing { lw_vec2 *p; int n, capacity; bool failed; } growing;

static void grow(growing *g, lw_vec2 p)
{
    lw_vec2 *q = lw_array_grow(g->p, g->n, &g->capacity, sizeof *q);
    g->failed = g->failed || !q;
    if (!q)
        return;
    g->p = q;
    g->p[g->n++] = p;
}

static lw_vec2 trace(lw_scene_work *w, int tracer, double t)
{
    lw_scene_work_move_to(w, t);
    if (!w->by_path)
        return w->posture.tracer[tracer][0];
    const lw_system *s = &w->path.s;
    return lw_system_point(s, s->tracer_body[tracer], s->tracer_arm[tracer], w->q);
}

/* Add points between t0 (point a, left out) and t1 (point b, included). Steps are halved until they are nearly
 * straight. A step that is still long is a jump from one end of an asymptote to the other: the line is interrupted
 * there. */
static void refine(lw_scene_work *w, int tracer, double t0, lw_vec2 a, double t1, lw_vec2 b, double size,
                   int depth, growing *g)
{
    double tm = t0 + (t1 - t0)/2;
    lw_vec2 m = trace(w, tracer, tm), chord = lw_v2_sub(b, a);
    double off = lw_v2_norm(lw_v2_sub(m, lw_v2_add(a, lw_v2_scale(chord, 0.5))));
    if (depth == 0 || g->n > POINTS_MAX || off < 4e-4*size || lw_scene_work_is_stopped(w)) {
        if (depth == 0 && lw_v2_norm(chord) > 0.1*size)
            grow(g, lw_v2(NAN, NAN));
        grow(g, b);
        return;
    }
    refine(w, tracer, t0, a, tm, m, size, depth - 1, g);
    refine(w, tracer, tm, m, t1, b, size, depth - 1, g);
}

static bool take_curve(lw_scene_work *w, int tracer, bool shown, size_t n)
{
    lw_scene *s = w->s;
    growing g = { 0 };
    bool loops = lw_scene_work_loops(w);
    double size = 1e-9*lw_scene_span(&s->linkage), per = lw_scene_work_length(w)/(double)n;
    lw_vec2 first = trace(w, tracer, 0), a = first;
    for (size_t i = 1; i < n; i++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(trace(w, tracer, per*(double)i), first)));
    grow(&g, first);
    for (size_t i = 1; i <= n; i++) {
        double t = i == n ? lw_scene_work_length(w) : per*(double)i;
        lw_vec2 b = trace(w, tracer, t);
        refine(w, tracer, per*(double)(i - 1), a, t, b, size, 14, &g);
        a = b;
    }
    if (loops && g.n > 1)
        g.n--;                                         /* the last point equals the first */
    s->curve[s->n_curve++] = (lw_curve){ .tracer = tracer, .shown_branch = shown,
                                         .closed = loops, .n = (size_t)g.n, .p = g.p };
    return !g.failed;
}

/* Does the file ask for a part of the input's range, and is the posture shown inside that part? */
static bool is_restricted(const lw_scene_work *w)
{
    const lw_input *in = &w->linkage.input[0];
    double first = fmin(in->first, in->last), last = fmax(in->first, in->last);
    double tolerance = 1e-9*(last - first);
    bool full = !lw_joint_slides(w->linkage.joint[in->joint].kind) && last - first >= 2*LW_PI*(1 - 1e-12);
    return first < last && !full && in->value >= first - tolerance && in->value <= last + tolerance;
}

static bool take_curves(lw_scene_work *w, bool shown, size_t n)
{
    for (int i = 0; n > 0 && i < w->s->linkage.n_tracer && !lw_scene_work_is_stopped(w); i++)
        if (!take_curve(w, i, shown, n < 8 ? 8 : n))
            return false;
    return true;
}

/* Add curves of the other circuits while there is space for them. False: out of memory. */
static bool take_others(lw_scene_work *w, size_t n)
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
static bool find_walk(lw_scene_work *w)
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

/* Compute curves and frames by the plan. False: out of memory. */
static bool show_walk(lw_scene_work *w, const lw_scene_options *o)
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
        return lw_scene_draft_frames(w, o);
    return take_curves(w, true, o->n_curve_point)
        && lw_scene_take_frames(w, o->n_frame < 2 ? 2 : o->n_frame);
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

lw_status lw_scene_duration(const lw_model *m, const lw_scene_options *o, double *out)
{
    inputs_in_time c = { m, malloc(4*(size_t)m->linkage.n_input*sizeof *c.value) };
    if (!c.value)
        return LW_E_MEMORY;
    *out = o->until > 0 ? o->until : lw_motion_path_duration(inputs_are_alike, &c);
    free(c.value);
    return LW_OK;
}

/* Fix links whose rotation changes nothing else (a roller on its pin). False: there is none. */
static bool fasten_idle_links(lw_scene_work *w)
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
static lw_status start_path(lw_scene_work *w, const lw_scene_options *o, lw_error *why)
{
    const lw_linkage *k = &w->linkage;
    bool motions, together = move_together(k, o, &motions);
    double last = 0;
    if (motions && lw_scene_duration(o->model, o, &last) != LW_OK)
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

static bool show_course(lw_scene_work *w, const lw_scene_options *o)
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
        lw_status drafted = lw_scene_draft_steps(s, w->given, is_restricted(w) ? range : NULL, o);
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
        return lw_scene_make_frames(s, 1);
    }
    if (o->draft && w->path.drive)
        return lw_scene_draft_frames(w, o);
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
    return take_curves(w, true, n) && lw_scene_take_frames(w, o->n_frame < 2 ? 2 : o->n_frame);
}

/* ---- all of it ---------------------------------------------------------------------------------- */

static bool show_motion(lw_scene_work *w, const lw_scene_options *o)
{
    bool walks = lw_scene_work_prepare(w) && (o->draft ? lw_scene_draft_walk(w) : find_walk(w));
    for (int i = 0; i < w->s->linkage.n_link && walks; i++)
        if (i != w->s->linkage.ground)
            w->s->origin[i] = lw_scene_work_reference(w, &w->start, i);
    if (w->no_memory)
        return false;
    return walks ? show_walk(w, o) : show_course(w, o);
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
    return lw_scene_make_frames(s, 1);
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
    lw_scene_work *w = calloc(1, sizeof *w);
    bool ok = w && lw_scene_begin(s, &parts, t, o);
    if (ok) {
        w->s = s;
        w->given = linkage;
        w->linkage = *linkage;
        ok = show_motion(w, o) && (!lw_scene_work_is_stopped(w) || drop_motion(s));
        lw_motion_path_free(&w->path);
    }
    free(w);
    if (ok)
        return LW_OK;
    lw_scene_free(s);
    return lw_error_set(e, LW_E_MEMORY, "not enough memory for the motion of the linkage");
}

/* catalogues/draw/scene_frames.c - what a scene holds, and where links are at any time of its motion. */
#include "catalogues/draw/scene_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include "base/bytes.h"
#include "base/real.h"
#include "grammar/model/model.h"

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
    for (int i = 0; i < s->n_bend; i++)
        free(s->bend[i].p);
    free(s->bend);
    lw_assembly_free(&s->linkage);
    s->n_curve = s->n_bend = 0;
    s->bend = NULL;
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

bool lw_scene_make_frames(lw_scene *s, size_t n)
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
static bool choose_references(lw_scene_work *w)
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

lw_vec2 lw_scene_work_reference(const lw_scene_work *w, const lw_posture *posture, int link)
{
    int pin = w->pin[link];
    return pin >= 0 ? posture->joint[pin][0] : posture->tracer[-1 - pin][0];
}

static void keep_dimensions(lw_scene_work *w)
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

bool lw_scene_work_prepare(lw_scene_work *w)
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

double lw_scene_span(const lw_assembly *linkage)
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
    double noise = angle ? 1e-12 : 1e-9*lw_scene_span(&s->linkage);
    return fabs(s->dim[i]) < noise ? 0 : s->dim[i]/(angle ? u->radian : u->metre);
}

double lw_scene_work_move_to(lw_scene_work *w, double t)
{
    if (w->by_path)
        return lw_motion_path_at(&w->path, t, w->q);
    lw_walk_posture(&w->walk, t, &w->posture);
    return w->posture.input;
}

static lw_place place_now(const lw_scene_work *w, int link)
{
    if (!w->by_path)
        return (lw_place){ lw_scene_work_reference(w, &w->posture, link),
                           lw_v2_polar(1, w->posture.angle[link][0] - w->start.angle[link][0]) };
    const lw_system *s = &w->path.s;
    int body = s->body[link];
    return (lw_place){ lw_system_point(s, body, lw_system_arm(s, body, w->s->origin[link]), w->q),
                       lw_v2_polar(1, w->q[3*body + 2]) };
}

bool lw_scene_take_frames(lw_scene_work *w, size_t n)
{
    lw_scene *s = w->s;
    size_t n_link = (size_t)s->linkage.n_link;
    if (!lw_scene_make_frames(s, n))
        return false;
    s->loops = lw_scene_work_loops(w);
    double per = lw_scene_work_length(w)/(s->loops ? (double)n : (double)(n - 1));
    double start = w->by_path ? w->path.start : w->walk.turns ? 0 : lw_walk_time(&w->walk, w->input);
    s->first_frame = (size_t)fmin(round(start/per), (double)n - 1);
    for (size_t f = 0; f < n && !lw_scene_work_is_stopped(w); f++) {
        s->input[f] = lw_scene_work_move_to(w, f == s->first_frame ? start : per*(double)f);
        for (size_t link = 0; link < n_link; link++)
            if ((int)link != s->linkage.ground)
                s->place[f*n_link + link] = place_now(w, (int)link);
    }
    return true;
}

bool lw_scene_begin(lw_scene *s, const lw_assembly *parts, const lw_target *t, const lw_scene_options *o)
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

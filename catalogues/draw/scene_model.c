/* catalogues/draw/scene_model.c - the scene of a model of any size, and the limits of its stops and cylinders that the motion passes. */
#include "catalogues/draw/scene_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "grammar/model/model.h"
#include "mbs/constraints/newton.h"
#include "mbs/formulations/follow_model.h"

/* ---- limits ------------------------------------------------------------------------------------------------- */

static double distance_of_ends(const lw_scene *s, size_t frame, const void *spring)
{
    const lw_spring *p = spring;
    return lw_v2_norm(lw_v2_sub(lw_scene_at(s, frame, p->link[1], lw_v3_xy(p->at[1])), lw_scene_at(s, frame, p->link[0], lw_v3_xy(p->at[0]))));
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

/* ---- motion -------------------------------------------------------------------------------------------------- */

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
    if (timed && lw_scene_duration(m, o, &ends[1]) != LW_OK)
        return lw_error_set(why, LW_E_MEMORY, "out of memory");
    if (!timed && ranged)
        ends[0] = fmin(in->first, in->last), ends[1] = fmax(in->first, in->last);
    else if (!timed && slides)
        ends[0] = now - lw_scene_span(a), ends[1] = now + lw_scene_span(a);
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
    if (!time || !lw_scene_make_frames(s, n))
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
    bool ok = lw_scene_begin(s, &m->linkage, t, o);
    lw_status st = ok ? large_motion(m, o, s, &why) : LW_E_MEMORY;
    ok = ok && st != LW_E_MEMORY;
    if (ok && st == LW_OK)
        ok = lw_scene_draft_curves(s, o->n_curve_point) == LW_OK;
    if (ok && st == LW_OK)
        lw_scene_draft_thin(s);
    else if (ok) {
        snprintf(s->note, sizeof s->note, "Shown without motion: %.200s", why.text[0] ? why.text : lw_status_text(st));
        ok = lw_scene_make_frames(s, 1);
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

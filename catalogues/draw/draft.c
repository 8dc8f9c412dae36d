/* catalogues/draw/draft.c - see draft.h */
#include "catalogues/draw/draft.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/constraints/newton.h"

enum { TURNS = 12 };                /* after so many turns a motion that does not repeat is cut */

/* Where the motion begins and ends; turns 0: it goes to and fro between them. */
typedef struct reach { double from, to; int turns; } reach;

static bool is_back(const lw_newton *m, int n_link)
{
    for (int i = 0; i < n_link; i++)
        if (fabs(remainder(lw_newton_angle(m, i), 2*LW_PI)) > 1e-6)
            return false;
    return true;
}

static lw_status find_reach(lw_newton *m, const lw_scene *s, const double *range, reach *r)
{
    double now = lw_newton_input(m), size = 0, reached;
    bool slides = lw_joint_slides(s->linkage.joint[s->linkage.input[0].joint].kind);
    for (int i = 0; i < s->linkage.n_joint; i++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(s->linkage.joint[i].at, s->linkage.joint[0].at)));
    double far = slides ? 8*size : 2*LW_PI;
    lw_status st = LW_OK;
    *r = (reach){ now, range ? range[1] : now + far, 0 };
    for (int turn = 1; !range && !slides && turn <= TURNS && st == LW_OK; turn++) {
        st = lw_newton_move(m, now + turn*2*LW_PI, &reached);
        r->turns = st == LW_OK && is_back(m, s->linkage.n_link) ? turn : 0;
        if (r->turns || (st == LW_OK && turn == TURNS)) {
            r->to = now + turn*2*LW_PI;
            lw_newton_reset(m);
            return LW_OK;
        }
    }
    if (st == LW_OK)
        st = lw_newton_move(m, r->to, &reached);
    if (st < 0)
        return st;
    r->to = reached;
    lw_newton_reset(m);
    st = lw_newton_move(m, range ? range[0] : now - far, &reached);
    r->from = reached;
    lw_newton_reset(m);
    return st < 0 ? st : LW_OK;
}

static void take_frame(lw_scene *s, const lw_newton *m, size_t f)
{
    size_t n_link = (size_t)s->linkage.n_link;
    s->input[f] = lw_newton_input(m);
    for (size_t i = 0; i < n_link; i++)
        s->place[f*n_link + i] = (lw_place){ lw_newton_point(m, (int)i, s->origin[i]),
                                             lw_v2_polar(1, lw_newton_angle(m, (int)i)) };
}

lw_status lw_draft_frames(lw_scene *s, const double *range, size_t n)
{
    lw_newton *m = NULL;
    lw_error e;
    reach r = { 0 };
    lw_status st = lw_newton_create(&s->linkage, &m, &e);
    if (st == LW_OK)
        st = find_reach(m, s, range, &r);
    if (st == LW_OK && !(r.to - r.from > 0))
        st = LW_E_NUMERIC;
    s->place = st == LW_OK ? malloc(n*(size_t)s->linkage.n_link*sizeof *s->place) : NULL;
    s->input = st == LW_OK ? malloc(n*sizeof *s->input) : NULL;
    if (st == LW_OK && (!s->place || !s->input))
        st = LW_E_MEMORY;
    s->loops = st == LW_OK && r.turns > 0;
    double now = st == LW_OK ? lw_newton_input(m) : 0, middle = 0, half = 0;
    if (st == LW_OK && !s->loops) {
        middle = 0.5*(r.from + r.to);
        half = 0.5*(r.to - r.from);
        double first = acos(fmin(fmax((middle - now)/half, -1), 1))/LW_PI;
        s->first_frame = (size_t)round(first*(double)(n - 1));
        st = lw_newton_move(m, r.from, NULL);
    }
    for (size_t f = 0; f < n && st >= 0; f++) {
        double u = s->loops ? r.from + (r.to - r.from)*(double)f/(double)n
                            : middle - half*cos(LW_PI*(double)f/(double)(n - 1));
        if (!s->loops || f > 0)
            st = lw_newton_move(m, f == s->first_frame ? now : u, NULL);
        take_frame(s, m, f);
    }
    if (st >= 0)
        s->n_frame = n;
    else {
        free(s->place);
        free(s->input);
        s->place = NULL;
        s->input = NULL;
        s->first_frame = 0;
        s->loops = false;
    }
    lw_newton_free(m);
    return st < 0 ? st : LW_OK;
}

lw_status lw_draft_curves(lw_scene *s, size_t n)
{
    size_t frames = s->n_frame, parts = s->loops ? frames : frames - 1, each = (n + parts - 1)/parts;
    if (frames < 2)
        return LW_OK;
    for (int t = 0; t < s->linkage.n_tracer && s->n_curve < LW_CURVE_MAX; t++) {
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

void lw_draft_thin(lw_scene *s)
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

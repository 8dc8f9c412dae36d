/* studio/motion.c - how a linkage moves: postures and curves, velocities, instant centres, limits, forces. */
#include "studio/studio_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/real.h"
#include "catalogues/draw/scene.h"
#include "grammar/model/model.h"
#include "linkwright.h"
#include "mbs/analysis/freedoms.h"
#include "mbs/batch/posture.h"
#include "mbs/kinematics/output_limits.h"
#include "mbs/plan/plan.h"

/* ---- postures and curves ----------------------------------------------------------------------------------------- */

static void put_joints(lw_bytes *b, const lw_assembly *k)
{
    double u = k->units.metre;
    studio_put_key(b, "joints");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_joint; i++) {
        const lw_joint *j = &k->joint[i];
        studio_put_key(b, NULL);
        lw_bytes_text(b, "{");
        studio_put_text(b, "name", j->name);
        studio_put_text(b, "kind", (char[]){ (char)j->kind, 0 });
        studio_put_reals(b, "links", (double[]){ j->link[0], j->link[1] }, 2, 1, 1);
        studio_put_reals(b, "at", &j->at.x, 2, 1, u);
        studio_put_reals(b, "along", &j->along.x, 2, 1, 1);
        lw_bytes_text(b, "}");
    }
    lw_bytes_text(b, "]");
    studio_put_key(b, "tracers");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_tracer; i++) {
        studio_put_key(b, NULL);
        lw_bytes_text(b, "{");
        studio_put_text(b, "name", k->tracer[i].name);
        studio_put_real(b, "link", k->tracer[i].link);
        studio_put_reals(b, "at", &k->tracer[i].at.x, 2, 1, u);
        lw_bytes_text(b, "}");
    }
    lw_bytes_text(b, "]");
}

static void put_curves(lw_bytes *b, const lw_scene *s)
{
    double u = s->linkage.units.metre;
    studio_put_key(b, "curves");
    lw_bytes_text(b, "[");
    for (int i = 0; i < s->n_curve; i++) {
        const lw_curve *c = &s->curve[i];
        studio_put_key(b, NULL);
        lw_bytes_text(b, "{");
        studio_put_real(b, "tracer", c->tracer);
        studio_put_bool(b, "shown", c->shown_branch);
        studio_put_bool(b, "closed", c->closed);
        studio_put_reals(b, "x", &c->p->x, c->n, 2, u);
        studio_put_reals(b, "y", &c->p->y, c->n, 2, u);
        lw_bytes_text(b, "}");
    }
    lw_bytes_text(b, "]");
}

/* places: x, y, cos, sin of every link in every frame, behind the origins: a point p of a link is at
 * (x, y) + turn (p - origin). */
static void put_frames(lw_bytes *b, const lw_scene *s)
{
    double u = s->linkage.units.metre, v[4];
    size_t links = (size_t)s->linkage.n_link;
    studio_put_real(b, "frames", (double)s->n_frame);
    studio_put_real(b, "first", (double)s->first_frame);
    studio_put_bool(b, "loops", s->loops);
    studio_put_reals(b, "origins", &s->origin->x, 2*links, 1, u);
    studio_put_reals(b, "inputs", s->input, s->n_frame, 1, 1);
    studio_put_key(b, "places");
    lw_bytes_text(b, "[");
    for (size_t i = 0; i < s->n_frame*links; i++) {
        memcpy(v, &s->place[i], sizeof v);
        for (int k = 0; k < 4; k++) {
            if (i > 0 || k > 0)
                lw_bytes_add(b, ",", 1);
            lw_bytes_number(b, k < 2 ? v[k]/u : v[k], 8);
        }
    }
    lw_bytes_text(b, "]");
}

static void put_dimensions(lw_bytes *b, const lw_scene *s)
{
    studio_put_key(b, "dimensions");
    lw_bytes_text(b, "{");
    for (int i = 0; i < s->n_dim; i++)
        studio_put_real(b, s->dim_name[i], lw_scene_dimension(s, i));
    lw_bytes_text(b, "}");
}

static void put_motion(lw_bytes *b, const lw_scene *s)
{
    const lw_assembly *k = &s->linkage;
    lw_bytes_text(b, "{");
    studio_put_text(b, "name", k->name);
    studio_put_text(b, "unit", k->units.length[0] ? k->units.length : "m");
    studio_put_key(b, "links");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_link; i++)
        studio_put_text(b, NULL, k->link_name[i]);
    lw_bytes_text(b, "]");
    studio_put_real(b, "ground", k->ground);
    studio_put_real(b, "input", k->n_input > 0 ? k->input[0].joint : -1);
    put_joints(b, k);
    put_frames(b, s);
    put_curves(b, s);
    put_dimensions(b, s);
    studio_put_text(b, "note", s->note);
    studio_put_real(b, "mobility", lw_assembly_mobility(k));
}

/* { linkage, points, frames, others, draft }: everything to show of its motion; draft: quickly, while it is dragged. */
lw_status studio_motion(studio *st, const json_t *ask, studio_reply *r, lw_error *e)
{
    double start = lw_clock_wall();
    lw_scene_options o = lw_scene_options_default();
    lw_assembly k = { 0 };
    lw_scene *scene = calloc(1, sizeof *scene);
    (void)st;
    lw_status s = scene ? studio_parts(ask, "linkage", &k, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    o.n_curve_point = (size_t)fmin(fmax(studio_real(ask, "points", 1000), 16), 20000);
    o.n_frame = (size_t)fmin(fmax(studio_real(ask, "frames", 180), 2), 2000);
    o.other_branches = studio_bool(ask, "others");
    o.draft = studio_bool(ask, "draft");
    if (s == LW_OK)
        s = lw_scene_make_any(&k, NULL, NULL, &o, scene, e);
    if (s == LW_OK) {
        put_motion(&r->body, scene);
        studio_put_real(&r->body, "ms", 1e3*(lw_clock_wall() - start));
        lw_bytes_text(&r->body, "}\n");
    }
    if (scene)
        lw_scene_free(scene);
    free(scene);
    lw_assembly_free(&k);
    return s;
}

/* { linkage }: how freely it moves, found by moving it. */
lw_status studio_mobility(studio *st, const json_t *ask, studio_reply *r, lw_error *e)
{
    lw_assembly k = { 0 };
    lw_linkage *small = malloc(sizeof *small);
    lw_model m = { 0 };
    lw_freedoms f = { 0 };
    lw_mobility_info i = { 0 };
    (void)st;
    lw_status s = small ? studio_parts(ask, "linkage", &k, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    bool large = s == LW_OK && lw_assembly_linkage(&k, small, NULL) != LW_OK;
    if (large) {
        s = lw_model_from_assembly(&k, &m);
        if (s == LW_OK)
            s = lw_freedoms_find(&m, 1e-12, 1, &f, e);
        i = (lw_mobility_info){ .kind = lw_mobility_kind_text(f.kind), .count = f.count, .freedom = f.freedom,
                                .redundant = f.n_redundant, .driven = f.driven };
        lw_freedoms_free(&f);
        lw_model_free(&m);
    } else if (s == LW_OK)
        s = lw_linkage_analyse_mobility(small, 1e-12, 1, &i, e);
    if (s >= 0) {
        lw_bytes_text(&r->body, "{");
        studio_put_text(&r->body, "kind", i.kind);
        studio_put_real(&r->body, "count", i.count);
        studio_put_real(&r->body, "freedom", i.freedom);
        studio_put_real(&r->body, "redundant", i.redundant);
        studio_put_real(&r->body, "driven", i.driven);
        if (!large)
            studio_put_real(&r->body, "idle", i.idle);
        lw_bytes_text(&r->body, "}\n");
    }
    lw_assembly_free(&k);
    free(small);
    return s;
}

/* Where each link is in the posture of mode, as one frame of a motion: the points (0, 0) and (1, 0) of the link move with
 * it as its tracers. */
static void put_assembly(lw_bytes *b, const lw_plan *plan, const double *dim, const double *mode, double input, lw_linkage *k)
{
    lw_linkage *moved = malloc(sizeof *moved);
    double place[4*LW_LINK_MAX] = { 0 }, origin[2*LW_LINK_MAX] = { 0 };
    k->n_tracer = 2;
    for (int i = 0; i < k->n_link && moved; i++) {
        for (int p = 0; p < 2; p++)
            k->tracer[p] = (lw_tracer){ .link = i, .at = lw_v2(p, 0) };
        *moved = *k;
        lw_plan_write(plan, dim, mode, input, moved);
        lw_vec2 at = moved->tracer[0].at, turn = lw_v2_sub(moved->tracer[1].at, at);
        memcpy(place + 4*i, (double[]){ at.x/k->units.metre, at.y/k->units.metre, turn.x, turn.y }, 4*sizeof *place);
    }
    lw_bytes_text(b, "{");
    studio_put_key(b, "links");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_link; i++)
        studio_put_text(b, NULL, k->link_name[i]);
    lw_bytes_text(b, "]");
    studio_put_real(b, "frames", 1);
    studio_put_reals(b, "origins", origin, 2*(size_t)k->n_link, 1, 1);
    studio_put_reals(b, "places", place, moved ? 4*(size_t)k->n_link : 0, 1, 1);
    lw_bytes_text(b, "}\n");
    free(moved);
}

/* { linkage }: the same lengths at the same input, put together the next other way, as a motion of one frame. */
lw_status studio_assembly(studio *st, const json_t *ask, studio_reply *r, lw_error *e)
{
    lw_linkage *k = malloc(sizeof *k);
    lw_plan *plan = malloc(sizeof *plan);
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    (void)st;
    lw_status s = k && plan ? studio_linkage(ask, "linkage", k, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_plan_options o = { .kind = LW_PLAN_GEARED, .all_joints = true };
    if (s == LW_OK)
        s = lw_plan_make(k, o, plan, e);
    if (s == LW_OK)
        s = lw_plan_read(plan, k, dim, mode, &input, e);
    unsigned ways = s == LW_OK ? 1u << plan->n_dyad : 0, code = 0, next = 1;
    for (int d = 0; ways && d < plan->n_dyad; d++)
        code |= (unsigned)(mode[d] < 0) << d;
    for (; next < ways; next++) {                     /* mode + and - as the bits of a number, counted on */
        for (int d = 0; d < plan->n_dyad; d++)
            mode[d] = (code + next) >> d & 1 ? -1 : 1;
        if (lw_plan_write(plan, dim, mode, input, k) == LW_OK)
            break;
    }
    if (s == LW_OK && next < ways)                    /* as it was: places are counted from there */
        s = studio_linkage(ask, "linkage", k, e);
    if (s == LW_OK && next >= ways)
        s = lw_error_set(e, LW_E_ARG, "these lengths close in one way only where the input stands; move the input first");
    if (s == LW_OK)
        put_assembly(&r->body, plan, dim, mode, input, k);
    free(k);
    free(plan);
    return s;
}

/* ---- velocities, centres, limits ------------------------------------------------------------------------------ */

/* One frame with derivatives; false: the frame stands in another assembly mode than the posture, or at a limit. */
typedef struct moment { lw_vec2 joint[LW_JOINT_MAX][3], tracer[LW_TRACER_MAX][3]; double margin; bool valid; } moment;

static void find_moment(const lw_kinematics *m, const lw_scene *s, size_t frame, moment *out)
{
    const lw_assembly *k = &s->linkage;
    double size = 0;
    lw_status st = lw_kinematics_posture(m, s->input[frame], 2, out->joint[0], NULL, out->tracer[0], &out->margin);
    out->valid = st == LW_OK;
    for (int i = 0; i < k->n_joint; i++)
        size = fmax(size, hypot(k->joint[i].at.x, k->joint[i].at.y));
    for (int i = 0; i < k->n_joint && out->valid; i++) {
        if (!lw_joint_turns(k->joint[i].kind))
            continue;
        lw_vec2 p = lw_scene_at(s, frame, k->joint[i].link[0], k->joint[i].at);
        out->valid = hypot(p.x - out->joint[i][0].x, p.y - out->joint[i][0].y) <= 1e-6*size;
    }
}

static double or_nan(const moment *m, double v) { return m->valid ? v : NAN; }

/* vx, vy, ax, ay of one point in all frames, by the input. */
static void put_point(lw_bytes *b, const char *name, const moment *m, size_t n, bool tracer, int i, double u)
{
    double *v = malloc(sizeof *v*4*(n + 1));
    studio_put_key(b, NULL);
    lw_bytes_text(b, "{");
    studio_put_text(b, "name", name);
    for (size_t f = 0; f < n && v; f++)
        for (int d = 0; d < 4; d++) {
            const lw_vec2 *p = &(tracer ? m[f].tracer[i] : m[f].joint[i])[1 + d/2];
            v[4*f + (size_t)d] = or_nan(&m[f], (d % 2 ? p->y : p->x)/u);
        }
    if (v)
        studio_put_reals(b, "rates", v, 4*n, 1, 1);
    b->failed = b->failed || !v;
    lw_bytes_text(b, "}");
    free(v);
}

static void put_rates(lw_bytes *b, const lw_linkage *k, const moment *m, size_t n)
{
    double u = k->units.metre;
    studio_put_key(b, "points");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_tracer; i++)
        put_point(b, k->tracer[i].name, m, n, true, i, u);
    for (int i = 0; i < k->n_joint; i++)
        if (lw_joint_turns(k->joint[i].kind) && k->joint[i].link[0] != k->ground && k->joint[i].link[1] != k->ground)
            put_point(b, k->joint[i].name, m, n, false, i, u);
    lw_bytes_text(b, "]");
}

/* x, y of an instant centre and, with `inflection`, of the end of the inflection circle's diameter, in all frames. */
static void put_centre(lw_bytes *b, const lw_kinematics *kin, const lw_scene *s, const moment *m, int link, int base,
                       bool inflection)
{
    double u = s->linkage.units.metre;
    size_t width = inflection ? 4 : 2;
    double *v = malloc(sizeof *v*4*s->n_frame);
    studio_put_key(b, NULL);
    lw_bytes_text(b, "{");
    studio_put_reals(b, "links", (double[]){ link, base }, 2, 1, 1);
    for (size_t f = 0; f < s->n_frame && v; f++) {
        lw_instant_motion at;
        lw_kinematics_instant(kin, s->input[f], link, base, &at);
        double all[4] = { at.centre.x, at.centre.y, at.inflection.x, at.inflection.y };
        for (size_t d = 0; d < width; d++)
            v[width*f + d] = or_nan(&m[f], all[d]/u);
    }
    if (v)
        studio_put_reals(b, "at", v, width*s->n_frame, 1, 1);
    b->failed = b->failed || !v;
    lw_bytes_text(b, "}");
    free(v);
}

static void put_centres(lw_bytes *b, const lw_kinematics *kin, const lw_scene *s, const moment *m)
{
    const lw_assembly *k = &s->linkage;
    studio_put_key(b, "centres");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_link && k->n_link <= 10; i++)
        for (int j = 0; j < i; j++)
            if (i != k->ground && j != k->ground)
                put_centre(b, kin, s, m, i, j, false);
    for (int i = 0; i < k->n_link; i++)
        if (i != k->ground)
            put_centre(b, kin, s, m, i, k->ground, true);
    lw_bytes_text(b, "]");
}

/* Places that the paths of the tracers pass twice. */
static void put_doubles(lw_bytes *b, const lw_scene *s)
{
    double u = s->linkage.units.metre;
    studio_put_key(b, "doubles");
    lw_bytes_text(b, "[");
    for (int i = 0; i < s->n_curve; i++) {
        const lw_curve *c = &s->curve[i];
        size_t n = c->n + c->closed;
        lw_double_point found[16];
        double *xy = c->shown_branch ? malloc(2*n*sizeof *xy) : NULL;
        b->failed = b->failed || (c->shown_branch && !xy);
        for (size_t k = 0; xy && k < n; k++) {
            xy[k] = c->p[k % c->n].x;
            xy[n + k] = c->p[k % c->n].y;
        }
        int all = xy ? lw_path_double_points(n, xy, xy + n, found, 16) : 0;
        for (int d = 0; d < all; d++)
            studio_put_reals(b, NULL, &found[d].at.x, 2, 1, u);
        free(xy);
    }
    lw_bytes_text(b, "]");
}

static lw_status put_range(void *context, const lw_input_range *a)
{
    lw_bytes *b = context;
    studio_put_key(b, NULL);
    lw_bytes_text(b, "{");
    studio_put_real(b, "first", a->first);
    studio_put_real(b, "last", a->last);
    studio_put_bool(b, "turns", a->turns);
    studio_put_real(b, "circuit", a->circuit);
    studio_put_bool(b, "own", a->own);
    studio_put_reals(b, "transmission", a->transmission, 2, 1, 1);
    lw_bytes_text(b, "}");
    return LW_OK;
}

/* Inputs at which a link at the ground stands still: dead points when it drives. */
static void put_dead_points(lw_bytes *b, const lw_linkage *k, const lw_scene *s)
{
    lw_plan plan;
    lw_output_limits dead[32];
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input, first = INFINITY, last = -INFINITY;
    lw_plan_options o = { .kind = LW_PLAN_GEARED, .all_joints = true };
    if (lw_plan_make(k, o, &plan, NULL) != LW_OK || lw_plan_read(&plan, k, dim, mode, &input, NULL) != LW_OK)
        return;
    for (size_t f = 0; f < s->n_frame; f++) {
        first = fmin(first, s->input[f]);
        last = fmax(last, s->input[f]);
    }
    if (s->loops && !plan.input_is_slider)
        last = first + 2*LW_PI;
    int n = lw_output_limits_find(&plan, k, dim, mode, first, last, dead, 32);
    studio_put_key(b, "dead");
    lw_bytes_text(b, "[");
    for (int i = 0; i < n; i++) {
        studio_put_key(b, NULL);
        lw_bytes_text(b, "{");
        studio_put_real(b, "link", dead[i].link);
        studio_put_real(b, "input", dead[i].input);
        lw_bytes_text(b, "}");
    }
    lw_bytes_text(b, "]");
}

/* The cognates of a four-bar, as linkages in the same posture of the tracer. */
static void put_cognates(lw_bytes *b, const lw_linkage *k)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input, other[2][9], other_mode[2], angle[2];
    static const char *const names[9] = { "r1", "r2", "r3", "r4", "cx", "cy", "x0", "y0", "theta0" };
    lw_plan_options o = { .tracers = 1, .all_joints = true };
    bool pins = k->n_link == 4 && k->n_joint == 4 && k->n_tracer > 0;
    for (int i = 0; i < k->n_joint; i++)
        pins = pins && lw_joint_turns(k->joint[i].kind);
    if (!pins || lw_plan_make(k, o, &plan, NULL) != LW_OK || lw_plan_read(&plan, k, dim, mode, &input, NULL) != LW_OK
        || plan.n_dim != 9)
        return;
    for (int i = 0; i < 9; i++)
        if (strcmp(plan.dim[i].name, names[i]) != 0)
            return;
    if (lw_fourbar_cognates(dim, mode[0], other, other_mode) != LW_OK
        || lw_fourbar_cognate_posture(dim, mode[0], input, angle, other_mode) != LW_OK)
        return;
    studio_put_key(b, "cognates");
    lw_bytes_text(b, "[");
    for (int i = 0; i < 2; i++) {
        lw_linkage *c = malloc(sizeof *c);
        if (c) {
            *c = *k;
            c->input[0].first = c->input[0].last = 0;
        }
        if (c && lw_plan_write(&plan, other[i], &other_mode[i], angle[i], c) == LW_OK)
            studio_put_linkage(b, NULL, LW_VIEW(c));
        b->failed = b->failed || !c;
        free(c);
    }
    lw_bytes_text(b, "]");
}

static void put_class(lw_bytes *b, const lw_scene *s)
{
    lw_fourbar_class c;
    double r[4] = { 0 };
    for (int i = 0; i < s->n_dim; i++)
        if (s->dim_name[i][0] == 'r' && s->dim_name[i][1] >= '1' && s->dim_name[i][1] <= '4' && !s->dim_name[i][2])
            r[s->dim_name[i][1] - '1'] = s->dim[i];
    bool pins = s->linkage.n_link == 4 && s->linkage.n_joint == 4;
    for (int i = 0; i < s->linkage.n_joint; i++)
        pins = pins && lw_joint_turns(s->linkage.joint[i].kind);
    if (!pins || lw_fourbar_classify(r, 1e-12, &c, NULL) != LW_OK)
        return;
    studio_put_key(b, "class");
    lw_bytes_text(b, "{");
    studio_put_text(b, "symbol", c.symbol);
    studio_put_text(b, "name", c.name);
    studio_put_bool(b, "grashof", c.grashof);
    studio_put_real(b, "margin", c.margin);
    lw_bytes_text(b, "}");
}

static void put_analysis(lw_bytes *b, const lw_linkage *k, const lw_scene *s, lw_kinematics *kin, moment *m)
{
    double *angle = malloc(sizeof *angle*(s->n_frame + 1));
    for (size_t f = 0; f < s->n_frame; f++) {
        find_moment(kin, s, f, &m[f]);
        if (angle)
            angle[f] = or_nan(&m[f], m[f].margin >= 0 ? asin(sqrt(fmin(m[f].margin, 1))) : NAN);
    }
    if (angle)
        studio_put_reals(b, "transmission", angle, s->n_frame, 1, 1);
    b->failed = b->failed || !angle;
    free(angle);
    put_rates(b, k, m, s->n_frame);
    put_centres(b, kin, s, m);
    studio_put_key(b, "ranges");
    lw_bytes_text(b, "[");
    b->failed = lw_kinematics_ranges(kin, put_range, b) == LW_E_MEMORY || b->failed;
    lw_bytes_text(b, "]");
    put_dead_points(b, k, s);
    put_doubles(b, s);
    put_cognates(b, k);
    put_class(b, s);
}

/* { linkage, frames }: what the overlays show, frame by frame as `motion` counts them.  LW_E_NOTATION for more parts
 * than a linkage holds: they have no plan. */
lw_status studio_analyse(studio *st, const json_t *ask, studio_reply *r, lw_error *e)
{
    lw_scene_options o = lw_scene_options_default();
    lw_linkage *k = malloc(sizeof *k);
    lw_scene *scene = calloc(1, sizeof *scene);
    lw_kinematics *kin = NULL;
    moment *m = NULL;
    (void)st;
    lw_status s = k && scene ? studio_linkage(ask, "linkage", k, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    o.n_frame = (size_t)fmin(fmax(studio_real(ask, "frames", 180), 2), 2000);
    o.n_curve_point = 720;
    if (s == LW_OK)
        s = lw_kinematics_create(k, &kin, e);
    if (s == LW_OK)
        s = lw_scene_make(k, NULL, &o, scene, e);
    if (s == LW_OK && !(m = calloc(scene->n_frame, sizeof *m)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        lw_bytes_text(&r->body, "{");
        put_analysis(&r->body, k, scene, kin, m);
        lw_bytes_text(&r->body, "}\n");
    }
    free(m);
    lw_kinematics_destroy(kin);
    if (scene)
        lw_scene_free(scene);
    free(scene);
    free(k);
    return s;
}

/* ---- forces --------------------------------------------------------------------------------------------------- */

typedef struct load_rows { size_t n, joints; double *v; } load_rows;      /* t, input, drive, joint forces */

static lw_status keep_row(void *context, const lw_simulation_sample *sample)
{
    load_rows *rows = context;
    double *v = realloc(rows->v, sizeof *v*(rows->n + 1)*(3 + rows->joints));
    if (!v)
        return LW_E_MEMORY;
    rows->v = v;
    v += rows->n++*(3 + rows->joints);
    v[0] = sample->t;
    v[1] = sample->input[0];
    v[2] = sample->drive[0];
    for (size_t i = 0; i < rows->joints; i++)
        v[3 + i] = hypot(sample->joint[i].force.x, sample->joint[i].force.y);
    return LW_OK;
}

static void put_loads(lw_bytes *b, const load_rows *rows, const lw_assembly *k)
{
    size_t width = 3 + rows->joints;
    lw_bytes_text(b, "{");
    studio_put_reals(b, "t", rows->v, rows->n, width, 1);
    studio_put_reals(b, "input", rows->v + 1, rows->n, width, 1);
    studio_put_reals(b, "drive", rows->v + 2, rows->n, width, 1);
    studio_put_text(b, "unit", lw_joint_slides(k->joint[k->input[0].joint].kind) ? "N" : "N m");
    studio_put_key(b, "joints");
    lw_bytes_text(b, "[");
    for (size_t i = 0; i < rows->joints; i++) {
        studio_put_key(b, NULL);
        lw_bytes_text(b, "{");
        studio_put_text(b, "name", k->joint[i].name);
        studio_put_reals(b, "force", rows->v + 3 + i, rows->n, width, 1);
        lw_bytes_text(b, "}");
    }
    lw_bytes_text(b, "]}\n");
}

/* { linkage, speed [rad/s] or [m/s], seconds }: torque or force of the drive and forces of the joints while the input
 * moves at even speed. */
lw_status studio_forces(studio *st, const json_t *ask, studio_reply *r, lw_error *e)
{
    char *text, motion[96];
    size_t size;
    lw_model *m = NULL;
    lw_simulation *run = NULL;
    lw_simulation_options o = lw_simulation_options_default();
    load_rows rows = { 0 };
    double speed = studio_real(ask, "speed", 2*LW_PI);
    (void)st;
    lw_status s = studio_source(ask, "linkage", &text, &size, e);
    if (s == LW_OK) {
        s = lw_model_parse(text, size, NULL, &m, e);
        free(text);
    }
    const lw_assembly *k = s == LW_OK ? &m->linkage : NULL;
    if (s == LW_OK && k->n_input == 0)
        s = lw_error_set(e, LW_E_ARG, "forces need an input that moves");
    if (s == LW_OK) {
        char start[32], rate[32];
        lw_number_text(start, k->input[0].value, 17);
        lw_number_text(rate, speed, 17);
        snprintf(motion, sizeof motion, "%s + (%s)*t", start, rate);
        s = lw_model_drive(m, 0, motion, e);
    }
    o.analysis = "kinematic";
    o.to = fmax(studio_real(ask, "seconds", 2*LW_PI/fmax(fabs(speed), 1e-9)), 1e-9);
    o.intervals = 180;
    o.max_seconds = 5;
    if (s == LW_OK)
        s = lw_simulation_create(m, &o, &run, e);
    if (s == LW_OK) {
        rows.joints = (size_t)k->n_joint;
        s = lw_simulation_run(run, keep_row, &rows, NULL, e);
    }
    if (s >= 0 && rows.n > 0)
        put_loads(&r->body, &rows, k);
    else if (s >= 0)
        s = lw_error_set(e, LW_E_NUMERIC, "the forces could not be worked out");
    free(rows.v);
    lw_simulation_destroy(run);
    lw_model_destroy(m);
    return s;
}

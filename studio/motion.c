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
#include "mbs/formulations/follow_model.h"
#include "mbs/kinematics/instant.h"
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

/* The motion of points and links in all frames, derivatives by the input; NAN in a frame that stands in another assembly mode than
 * the posture, or at a limit.  Points are the tracers, then the pins that move. */
typedef struct rates {
    const lw_scene    *s;
    double            *point;        /* [point][frame]: vx, vy, ax, ay [m]                                        */
    double            *transmission; /* [frame] [rad]                                                             */
    lw_instant_motion *link;         /* [link][frame], against the ground                                         */
} rates;

static bool is_moving_pin(const lw_assembly *k, int i)
{
    return lw_joint_turns(k->joint[i].kind) && k->joint[i].link[0] != k->ground && k->joint[i].link[1] != k->ground;
}

static lw_status make_rates(const lw_scene *s, rates *r)
{
    size_t n_point = (size_t)(s->linkage.n_tracer + s->linkage.n_joint), n_link = (size_t)s->linkage.n_link;
    *r = (rates){ .s = s, .point = malloc((n_point*s->n_frame + 1)*4*sizeof *r->point), .transmission = malloc(s->n_frame*sizeof *r->transmission),
                  .link = malloc(n_link*s->n_frame*sizeof *r->link) };
    if (!r->point || !r->transmission || !r->link)
        return LW_E_MEMORY;
    for (size_t i = 0; i < 4*n_point*s->n_frame; i++)
        r->point[i] = NAN;
    for (size_t f = 0; f < s->n_frame; f++)
        r->transmission[f] = NAN;
    for (size_t i = 0; i < n_link*s->n_frame; i++)
        r->link[i] = (lw_instant_motion){ .centre = { NAN, NAN }, .inflection = { NAN, NAN } };
    return LW_OK;
}

static void free_rates(rates *r)
{
    free(r->point), free(r->transmission), free(r->link);
}

/* Keep the motion of the points in a frame; false: it does not stand where the joints are. */
static bool keep_points(rates *r, size_t frame, lw_vec2 (*joint)[3], lw_vec2 (*tracer)[3])
{
    const lw_scene *s = r->s;
    const lw_assembly *k = &s->linkage;
    double size = 0, *out = r->point + 4*frame;
    for (int i = 0; i < k->n_joint; i++)
        size = fmax(size, hypot(k->joint[i].at.x, k->joint[i].at.y));
    for (int i = 0; i < k->n_joint; i++) {
        if (!lw_joint_turns(k->joint[i].kind))
            continue;
        lw_vec2 p = lw_scene_at(s, frame, k->joint[i].link[0], k->joint[i].at);
        if (!(hypot(p.x - joint[i][0].x, p.y - joint[i][0].y) <= 1e-6*size))
            return false;
    }
    for (int i = 0; i < k->n_tracer + k->n_joint; i++) {
        const lw_vec2 *p = i < k->n_tracer ? tracer[i] : joint[i - k->n_tracer];
        if (i < k->n_tracer || is_moving_pin(k, i - k->n_tracer)) {
            memcpy(out, (double[]){ p[1].x, p[1].y, p[2].x, p[2].y }, 4*sizeof *out);
            out += 4*s->n_frame;
        }
    }
    return true;
}

/* By the plan of the linkage, from its input in each frame. */
static void plan_rates(rates *r, const lw_kinematics *kin)
{
    const lw_scene *s = r->s;
    lw_vec2 joint[LW_JOINT_MAX][3], tracer[LW_TRACER_MAX][3];
    for (size_t f = 0; f < s->n_frame; f++) {
        double margin;
        if (lw_kinematics_posture(kin, s->input[f], 2, joint[0], NULL, tracer[0], &margin) != LW_OK || !keep_points(r, f, joint, tracer))
            continue;
        r->transmission[f] = margin >= 0 ? asin(sqrt(fmin(margin, 1))) : NAN;
        for (int i = 0; i < s->linkage.n_link; i++)
            if (i != s->linkage.ground)
                lw_kinematics_instant(kin, s->input[f], i, s->linkage.ground, &r->link[(size_t)i*s->n_frame + f]);
    }
}

/* Position, velocity and acceleration of a point of a link from the series of the coordinates by the input. */
static void point_rates(const lw_system *y, int link, lw_vec2 at, const double *series, lw_vec2 out[3])
{
    lw_system_point_series(y, y->body[link], lw_system_arm(y, y->body[link], at), 2, series, out);
    out[2] = lw_v2_scale(out[2], 2);
}

static void keep_series(rates *r, size_t frame, const lw_system *y, const double *series, lw_vec2 (*joint)[3], lw_vec2 (*tracer)[3])
{
    const lw_assembly *k = &r->s->linkage;
    for (int i = 0; i < k->n_joint; i++)
        point_rates(y, k->joint[i].link[0], k->joint[i].at, series, joint[i]);
    for (int i = 0; i < k->n_tracer; i++)
        point_rates(y, k->tracer[i].link, k->tracer[i].at, series, tracer[i]);
    if (!keep_points(r, frame, joint, tracer))
        return;
    for (int i = 0; i < k->n_link; i++) {
        const double *q = series + 3*y->body[i] + 2;
        lw_vec2 p[3];
        if (y->body[i] < 0)
            continue;
        point_rates(y, i, r->s->origin[i], series, p);
        r->link[(size_t)i*r->s->n_frame + frame] = lw_instant_motion_at(p, (double[]){ q[0], q[y->n_q], 2*q[2*y->n_q] });
    }
}

/* Without a plan: along the input from the posture, upwards and downwards, with sparse rows for any number of links. */
static lw_status follow_rates(rates *r, lw_error *e)
{
    const lw_scene *s = r->s;
    const lw_assembly *k = &s->linkage;
    lw_vec2 (*point)[3] = malloc((size_t)(k->n_joint + k->n_tracer)*sizeof *point);
    lw_model m = { 0 };
    lw_status st = point ? lw_model_from_assembly(k, &m) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (long step = 1; step >= -1 && st == LW_OK; step -= 2) {
        lw_follow *f = NULL;
        st = k->n_input == 0 ? lw_error_set(e, LW_E_ARG, "the linkage has no input to move it by")
           : lw_follow_create(&m, lw_prescribed_motion_first_alone, &m, k->input[0].value, NULL, &f, e);
        for (long i = (long)s->first_frame - (step < 0); st == LW_OK && i >= 0 && i < (long)s->n_frame; i += step)
            if (lw_follow_to(f, s->input[i], NULL) == LW_OK)
                keep_series(r, (size_t)i, lw_follow_system(f), lw_follow_series(f), point, point + k->n_joint);
        lw_follow_free(f);
    }
    lw_model_free(&m);
    free(point);
    return st;
}

static void put_point(lw_bytes *b, const char *name, const double *v, const lw_scene *s)
{
    studio_put_key(b, NULL);
    lw_bytes_text(b, "{");
    studio_put_text(b, "name", name);
    studio_put_reals(b, "rates", v, 4*s->n_frame, 1, s->linkage.units.metre);
    lw_bytes_text(b, "}");
}

static void put_rates(lw_bytes *b, const rates *r)
{
    const lw_assembly *k = &r->s->linkage;
    const double *v = r->point;
    studio_put_key(b, "points");
    lw_bytes_text(b, "[");
    for (int i = 0; i < k->n_tracer; i++, v += 4*r->s->n_frame)
        put_point(b, k->tracer[i].name, v, r->s);
    for (int i = 0; i < k->n_joint; i++)
        if (is_moving_pin(k, i)) {
            put_point(b, k->joint[i].name, v, r->s);
            v += 4*r->s->n_frame;
        }
    lw_bytes_text(b, "]");
}

/* x, y of the instant centre of two links in all frames; against the ground also of the end of the inflection circle's diameter. */
static void put_centre(lw_bytes *b, const rates *r, int link, int base, const lw_instant_motion *at)
{
    const lw_scene *s = r->s;
    size_t width = base == s->linkage.ground ? 4 : 2;
    double *v = malloc(sizeof *v*4*s->n_frame);
    studio_put_key(b, NULL);
    lw_bytes_text(b, "{");
    studio_put_reals(b, "links", (double[]){ link, base }, 2, 1, 1);
    for (size_t f = 0; f < s->n_frame && v; f++)
        memcpy(v + width*f, (double[]){ at[f].centre.x, at[f].centre.y, at[f].inflection.x, at[f].inflection.y }, width*sizeof *v);
    if (v)
        studio_put_reals(b, "at", v, width*s->n_frame, 1, s->linkage.units.metre);
    b->failed = b->failed || !v;
    lw_bytes_text(b, "}");
    free(v);
}

/* kin NULL: no centres of two moving links. */
static void put_centres(lw_bytes *b, const rates *r, const lw_kinematics *kin)
{
    const lw_assembly *k = &r->s->linkage;
    lw_instant_motion *at = malloc(r->s->n_frame*sizeof *at);
    studio_put_key(b, "centres");
    lw_bytes_text(b, "[");
    for (int i = 0; at && kin && i < k->n_link && k->n_link <= 10; i++)
        for (int j = 0; j < i; j++) {
            if (i == k->ground || j == k->ground)
                continue;
            for (size_t f = 0; f < r->s->n_frame; f++) {
                at[f] = (lw_instant_motion){ .centre = { NAN, NAN } };
                if (!isnan(r->link[(size_t)i*r->s->n_frame + f].centre.x) || !isnan(r->link[(size_t)j*r->s->n_frame + f].centre.x))
                    lw_kinematics_instant(kin, r->s->input[f], i, j, &at[f]);
            }
            put_centre(b, r, i, j, at);
        }
    for (int i = 0; i < k->n_link; i++)
        if (i != k->ground)
            put_centre(b, r, i, k->ground, r->link + (size_t)i*r->s->n_frame);
    lw_bytes_text(b, "]");
    b->failed = b->failed || !at;
    free(at);
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
    if (!pins || lw_plan_make(k, o, &plan, NULL) != LW_OK || lw_plan_read(&plan, k, dim, mode, &input, NULL) != LW_OK || plan.n_dim != 9)
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

/* What only a plan tells: ranges of the input, dead points, cognates. */
static void put_plan(lw_bytes *b, const lw_linkage *k, const lw_scene *s, lw_kinematics *kin)
{
    studio_put_key(b, "ranges");
    lw_bytes_text(b, "[");
    b->failed = (kin && lw_kinematics_ranges(kin, put_range, b) == LW_E_MEMORY) || b->failed;
    lw_bytes_text(b, "]");
    if (kin) {
        put_dead_points(b, k, s);
        put_cognates(b, k);
    }
}

/* { linkage, frames }: what the overlays show, frame by frame as `motion` counts them. */
lw_status studio_analyse(studio *st, const json_t *ask, studio_reply *r, lw_error *e)
{
    lw_scene_options o = lw_scene_options_default();
    lw_linkage *k = malloc(sizeof *k);
    lw_scene *scene = calloc(1, sizeof *scene);
    lw_kinematics *kin = NULL;
    lw_assembly parts = { 0 };
    rates all = { 0 };
    (void)st;
    lw_status s = k && scene ? studio_parts(ask, "linkage", &parts, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    o.n_frame = (size_t)fmin(fmax(studio_real(ask, "frames", 180), 2), 2000);
    o.n_curve_point = 720;
    if (s == LW_OK)
        s = lw_scene_make_any(&parts, NULL, NULL, &o, scene, e);
    if (s == LW_OK && (s = make_rates(scene, &all)) != LW_OK)
        lw_error_set(e, s, "out of memory");
    lw_status planned = s == LW_OK ? lw_assembly_linkage(&parts, k, NULL) : s;
    if (planned == LW_OK)
        planned = lw_kinematics_create(k, &kin, NULL);
    if (s == LW_OK && planned == LW_E_MEMORY)
        s = lw_error_set(e, planned, "out of memory");
    if (planned == LW_OK)
        plan_rates(&all, kin);
    else if (s == LW_OK)
        s = follow_rates(&all, e);
    if (s == LW_OK) {
        lw_bytes_text(&r->body, "{");
        studio_put_reals(&r->body, "transmission", all.transmission, scene->n_frame, 1, 1);
        put_rates(&r->body, &all);
        put_centres(&r->body, &all, kin);
        put_plan(&r->body, k, scene, kin);
        put_doubles(&r->body, scene);
        put_class(&r->body, scene);
        lw_bytes_text(&r->body, "}\n");
    }
    free_rates(&all);
    lw_kinematics_destroy(kin);
    if (scene)
        lw_scene_free(scene);
    free(scene);
    lw_assembly_free(&parts);
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

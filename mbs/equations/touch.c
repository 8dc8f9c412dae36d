/* mbs/equations/touch.c - geometry of contact between shapes.
 *
 * A corner behind a face may be inside the body or far behind it, beyond its other side.  It counts as inside while it
 * is no deeper than half the thickness of the body there, and nearer to this face than to the next ones: below the
 * bisectors of the corners at both ends, whose slopes are slope[].  So exactly one face of a corner of a body repels.
 * Where two corners meet end on, their sides decide it, see corners_hold. */
#include "mbs/equations/touch.h"

#include <stdlib.h>
#include <string.h>
#include "base/key_table.h"
#include "base/real.h"

/* Corners that overlap by `depth` and are nearer to each other than `end_on` times that meet end on, where depth is below this part of the thickness. */
static const double end_on = 10, thin_part = 0.05;

static const double meet = 1e-9;             /* outlines that are nearer, over the size of the shape, meet */

/* ---- discs and faces of a shape ------------------------------------------------------------------ */

typedef struct disc { lw_vec2 at, edge[2], into; double radius, size; } disc;
typedef struct face { lw_vec2 from, to, beyond[2]; double radius, deepest, slope[2], notch[2]; bool infinite, two_sided; } face;

static int disc_count(const lw_contour *p)
{
    return p->kind == LW_CONTOUR_LINE ? 0 : p->kind == LW_CONTOUR_CIRCLE ? 1 : p->n;
}

static int face_count(const lw_contour *p)
{
    return p->kind == LW_CONTOUR_CIRCLE ? 0 : p->kind == LW_CONTOUR_POLYGON ? p->n : 1;
}

static double extent(const lw_contour *p)
{
    double most = p->radius;
    for (int i = 1; i < p->n; i++)
        most = fmax(most, lw_v2_norm(lw_v2_sub(p->at[i], p->at[0])));
    return most;
}

static lw_vec2 unit_vector(lw_vec2 v) { return lw_v2_scale(v, 1/fmax(lw_v2_norm(v), 1e-300)); }

static disc disc_of(const lw_contour *p, int i)
{
    disc d = { .at = p->at[i], .radius = p->radius, .size = extent(p) };
    bool sharp = p->kind == LW_CONTOUR_POLYGON || (p->kind == LW_CONTOUR_SEGMENT && !(p->radius > 0));
    for (int k = 0; sharp && k < 2; k++)
        d.edge[k] = lw_v2_sub(p->at[(i + (k ? 1 : p->n - 1))%p->n], p->at[i]);
    d.into = p->kind == LW_CONTOUR_SEGMENT ? lw_v2_sub(p->at[1 - i], p->at[i]) : lw_v2_add(unit_vector(d.edge[0]), unit_vector(d.edge[1]));
    d.into = unit_vector(d.into);
    return d;
}

/* A corner that no disc can reach and that touches nothing: a notch. */
static bool is_notch(const lw_contour *p, int i)
{
    if (p->kind != LW_CONTOUR_POLYGON)
        return false;
    lw_vec2 before = p->at[(i + p->n - 1)%p->n], at = p->at[i], after = p->at[(i + 1)%p->n];
    return lw_v2_cross(lw_v2_sub(at, before), lw_v2_sub(after, at)) <= 0;
}

/* Slope of the bisector at corner i of a polygon; at a notch all below the face is inside. */
static double bisector(const lw_contour *p, int i)
{
    lw_vec2 a = lw_v2_sub(p->at[(i + p->n - 1)%p->n], p->at[i]), b = lw_v2_sub(p->at[(i + 1)%p->n], p->at[i]);
    double angle = atan2(lw_v2_cross(b, a), lw_v2_dot(a, b));          /* inside the solid */
    return angle > 0 && angle < LW_PI ? tan(0.5*angle) : INFINITY;
}

/* How far the body goes on behind a notch, to half the way to the nearest other side, as the side of a square; 0: corner i is no notch. */
static double notch_depth(const lw_contour *p, int i)
{
    double least = INFINITY;
    for (int j = 0; j < p->n && is_notch(p, i); j++)
        if (j != i && j != (i + p->n - 1)%p->n)
            least = fmin(least, lw_v2_segment_distance(p->at[i], p->at[j], p->at[(j + 1)%p->n]));
    return least < INFINITY ? 0.35*least : 0;
}

/* Half the least thickness of the polygon behind face i. */
static double half_thickness(const lw_contour *p, int i)
{
    enum { SAMPLES = 9 };
    lw_vec2 a = p->at[i], b = p->at[(i + 1)%p->n], u = lw_v2_sub(b, a), in;
    double least = INFINITY;
    in = lw_v2_scale(lw_v2_perp(u), 1/lw_v2_norm(u));
    for (int k = 0; k < SAMPLES; k++) {
        lw_vec2 from = lw_v2_add(a, lw_v2_scale(u, (k + 0.5)/SAMPLES));
        for (int j = 0; j < p->n; j++) {
            if (j == i)
                continue;
            lw_vec2 c = p->at[j], w = lw_v2_sub(p->at[(j + 1)%p->n], c);
            double across = lw_v2_cross(in, w), x, s;
            if (across == 0)
                continue;
            x = lw_v2_cross(lw_v2_sub(c, from), w)/across;
            s = lw_v2_cross(lw_v2_sub(c, from), in)/across;
            bool next = j == (i + 1)%p->n || i == (j + 1)%p->n;          /* the bisector looks after these */
            if (x > 0 && s >= 0 && s <= 1 && !next)
                least = fmin(least, x);
        }
    }
    return 0.5*(least < INFINITY ? least : lw_v2_norm(u));
}

/* Outside is on the left of the direction from `from` to `to`. */
static face face_of(const lw_contour *p, int i)
{
    lw_vec2 a = p->at[i], b = p->at[(i + 1)%p->n];
    face f = { .from = a, .to = b, .radius = p->radius, .deepest = INFINITY, .slope = { INFINITY, INFINITY } };
    f.infinite = p->kind == LW_CONTOUR_LINE;
    f.two_sided = p->kind == LW_CONTOUR_SEGMENT;
    if (p->kind != LW_CONTOUR_POLYGON)
        return f;
    f.from = b;
    f.to = a;
    f.deepest = half_thickness(p, i);
    f.slope[0] = bisector(p, (i + 1)%p->n);
    f.slope[1] = bisector(p, i);
    f.notch[0] = notch_depth(p, (i + 1)%p->n);
    f.notch[1] = notch_depth(p, i);
    f.beyond[0] = lw_v2_sub(p->at[(i + 2)%p->n], b);
    f.beyond[1] = lw_v2_sub(p->at[(i + p->n - 1)%p->n], a);
    return f;
}

/* ---- shapes of one link that meet, as the pieces of a rail -------------------------------------------- */

/* The outlines of other shapes of its link that go through corner `at` of shape p: up to two directions from there that are not those of its own sides. */
static void find_onward(const lw_model *m, const lw_contour *p, lw_vec2 at, const lw_vec2 edge[2], lw_vec2 onward[2])
{
    int n = 0;
    for (int i = 0; i < m->n_shape; i++) {
        const lw_contour *o = &m->shape[i];
        double near = meet*extent(p);
        for (int j = 0; o != p && o->link == p->link && !(o->radius > 0) && j < face_count(o); j++) {
            lw_vec2 a = o->at[j], b = o->at[(j + 1)%o->n], u = unit_vector(lw_v2_sub(b, a)), d = lw_v2_sub(at, a);
            double place = lw_v2_dot(u, d), length = lw_v2_norm(lw_v2_sub(b, a));
            bool endless = o->kind == LW_CONTOUR_LINE, on = fabs(lw_v2_cross(u, d)) <= near && (endless || fmin(place, length - place) >= -near);
            for (int back = 0; on && back < 2; back++) {
                lw_vec2 way = lw_v2_scale(u, back ? -1 : 1);
                bool goes_on = endless || (back ? place : length - place) > near, own = false;
                for (int k = 0; k < 2; k++)
                    own = own || lw_v2_dot(way, unit_vector(edge[k])) > 1 - 0.5*meet;
                if (goes_on && !own && n < 2)
                    onward[n++] = way;
            }
        }
    }
}

/* Does another shape of its link go on from this end of a bar? */
static bool goes_on_from(const lw_model *m, const lw_contour *bar, int end)
{
    lw_vec2 onward[2] = { { 0, 0 }, { 0, 0 } }, edge[2];
    edge[0] = edge[1] = lw_v2_sub(bar->at[1 - end], bar->at[end]);
    find_onward(m, bar, bar->at[end], edge, onward);
    return onward[0].x != 0 || onward[0].y != 0;
}

/* Is the point in the solid of a polygon or line? */
static bool is_inside(const lw_contour *p, lw_vec2 c)
{
    bool in = p->kind == LW_CONTOUR_LINE && lw_v2_cross(lw_v2_sub(p->at[1], p->at[0]), lw_v2_sub(c, p->at[0])) < 0;
    for (int j = 0; p->kind == LW_CONTOUR_POLYGON && j < p->n; j++) {
        lw_vec2 a = p->at[j], b = p->at[(j + 1)%p->n];
        if ((a.y > c.y) != (b.y > c.y) && c.x < a.x + (c.y - a.y)/(b.y - a.y)*(b.x - a.x))
            in = !in;
    }
    return in;
}

static bool crosses(const lw_contour *p, lw_vec2 from, lw_vec2 to)
{
    bool any = false;
    for (int j = 0; p->kind == LW_CONTOUR_POLYGON && j < p->n; j++) {
        lw_vec2 a = p->at[j], b = p->at[(j + 1)%p->n], u = lw_v2_sub(to, from), w = lw_v2_sub(b, a);
        bool apart = (lw_v2_cross(u, lw_v2_sub(a, from)) > 0) == (lw_v2_cross(u, lw_v2_sub(b, from)) > 0)
                  || (lw_v2_cross(w, lw_v2_sub(from, a)) > 0) == (lw_v2_cross(w, lw_v2_sub(to, a)) > 0);
        any = any || !apart;
    }
    return any;
}

/* At which ends do other solids of its link lie on face f of polygon p?  True: one of them lies on all of it. */
static bool find_covered(const lw_model *m, const lw_contour *p, const face *f, bool end[2])
{
    lw_vec2 u = lw_v2_sub(f->to, f->from), out = lw_v2_scale(lw_v2_perp(u), meet), in = lw_v2_scale(u, 1e-3);
    lw_vec2 a = lw_v2_add(lw_v2_add(f->from, in), out), b = lw_v2_add(lw_v2_sub(f->to, in), out);
    bool whole = false;
    end[0] = end[1] = false;
    for (int i = 0; p->kind == LW_CONTOUR_POLYGON && i < m->n_shape; i++) {
        const lw_contour *o = &m->shape[i];
        if (o == p || o->link != p->link)
            continue;
        bool first = is_inside(o, a), last = is_inside(o, b);
        end[0] = end[0] || first;
        end[1] = end[1] || last;
        whole = whole || (first && last && !crosses(o, a, b));
    }
    return whole;
}

/* ---- the list ------------------------------------------------------------------------------------ */

typedef struct maker { const lw_model *m; const lw_system *s; lw_touch_list *list; bool counting; } maker;

static lw_touch *next_touch(maker *w)
{
    lw_touch *p = w->counting ? NULL : &w->list->touch[w->list->n];
    w->list->n++;
    if (p)
        *p = (lw_touch){ .length = INFINITY, .deepest = INFINITY, .slope = { INFINITY, INFINITY }, .size = INFINITY };
    return p;
}

static void set_ends(const maker *w, lw_touch *p, int link0, lw_vec2 at0, int link1, lw_vec2 at1)
{
    p->link = link0;
    p->drawn = at0;
    p->body[0] = w->s->body[link0];
    p->body[1] = w->s->body[link1];
    p->arm[0] = lw_system_arm(w->s, p->body[0], at0);
    p->arm[1] = lw_system_arm(w->s, p->body[1], at1);
}

/* Discs of p against faces of o and, unless done already, its discs. */
static void add_discs(maker *w, const lw_contour *p, const lw_contour *o, bool discs_too)
{
    double unit = w->s->unit;
    for (int i = 0; i < disc_count(p); i++) {
        if (is_notch(p, i))
            continue;
        disc a = disc_of(p, i);
        lw_vec2 onward[2] = { { 0, 0 }, { 0, 0 } };
        if (!w->counting && !(a.radius > 0))
            find_onward(w->m, p, a.at, a.edge, onward);
        for (int j = 0; j < face_count(o); j++) {
            face f = face_of(o, j);
            bool covered[2];
            if (find_covered(w->m, o, &f, covered))
                continue;
            lw_touch *t = next_touch(w);
            if (!t)
                continue;
            lw_vec2 u = lw_v2_sub(f.to, f.from);
            double length = lw_v2_norm(u);
            set_ends(w, t, p->link, a.at, o->link, f.from);
            t->kind = LW_TOUCH_FACE;
            for (int k = 0; k < 2; k++) {
                t->edge[k] = lw_v2_scale(a.edge[k], 1/unit);
                t->onward[k] = onward[k];
                t->covered[k] = covered[k];
                t->beyond[k] = lw_v2_scale(f.beyond[k], 1/unit);
                t->notch[k] = f.notch[k]/unit;
            }
            t->into = a.into;
            t->radius[0] = a.radius/unit;
            t->radius[1] = f.radius/unit;
            t->along = lw_v2_scale(u, 1/length);
            t->length = f.infinite ? INFINITY : length/unit;
            t->deepest = f.deepest/unit;
            t->slope[0] = f.slope[0];
            t->slope[1] = f.slope[1];
            for (int k = 0; f.two_sided && k < 2; k++)
                t->joined[k] = goes_on_from(w->m, o, k);
            t->side = f.two_sided ? LW_TOUCH_NO_SIDE : 0;
            t->size = f.infinite ? INFINITY : (f.two_sided ? 2*(a.radius + f.radius) : 2*f.deepest)/unit;
            t->least_size = 1e-4*fmin(length, a.size > 0 ? a.size : length)/unit;
        }
        for (int j = 0; discs_too && j < disc_count(o); j++) {
            disc b = disc_of(o, j);
            lw_touch *t = is_notch(o, j) || !(a.radius + b.radius > 0) ? NULL : next_touch(w);
            if (!t)
                continue;
            set_ends(w, t, p->link, a.at, o->link, b.at);
            t->kind = LW_TOUCH_DISCS;
            t->radius[0] = a.radius/unit;
            t->radius[1] = b.radius/unit;
            t->size = (a.radius + b.radius)/unit;
        }
    }
}

static void add_contacts(maker *w)
{
    const lw_model *m = w->m;
    for (int c = 0; c < m->n_contact; c++) {
        int first = w->list->n;
        const lw_contact *q = &m->contact[c];
        for (int i = 0; i < m->n_shape; i++)
            for (int j = 0; m->shape[i].link == q->link[0] && j < m->n_shape; j++) {
                if (m->shape[j].link != q->link[1])
                    continue;
                add_discs(w, &m->shape[i], &m->shape[j], true);
                add_discs(w, &m->shape[j], &m->shape[i], false);
            }
        for (int i = first; !w->counting && i < w->list->n; i++) {
            w->list->touch[i].owner = c;
            w->list->touch[i].surface = &q->surface;
        }
    }
}

static void add_ropes(maker *w)
{
    for (int i = 0; i < w->m->n_rope; i++) {
        const lw_rope *r = &w->m->rope[i];
        lw_touch *t = next_touch(w);
        if (!t)
            continue;
        set_ends(w, t, r->link[0], r->at[0], r->link[1], r->at[1]);
        t->kind = LW_TOUCH_ROPE;
        t->limit = r->length/w->s->unit;
        t->surface = &r->surface;
        t->owner = i;
    }
}

static void add_stops(maker *w)
{
    for (int j = 0; j < w->s->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            const lw_joint_stop *p = &w->m->stop[j];
            if (p->stiffness > 0 || !(end ? p->has_greatest : p->has_least))
                continue;
            lw_touch *t = next_touch(w);
            if (!t)
                continue;
            t->kind = LW_TOUCH_STOP;
            t->sign = end ? -1 : 1;
            t->limit = (end ? p->greatest : p->least)/lw_system_joint_unit(w->s, j);
            t->owner = j;
            t->surface = &w->list->stop_surface[j];
            w->list->stop_surface[j] = (lw_surface){ .restitution = p->restitution, .exponent = 1 };
            t->body[0] = w->s->joint[j].body[0];
            t->body[1] = w->s->joint[j].body[1];
        }
}

static void add_all(maker *w)
{
    w->list->n = 0;
    add_contacts(w);
    add_ropes(w);
    add_stops(w);
}

static bool is_pinned(const lw_assembly *k, int a, int b, lw_vec2 at)
{
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *p = &k->joint[j];
        bool both = (p->link[0] == a && p->link[1] == b) || (p->link[0] == b && p->link[1] == a);
        if (both && lw_joint_turns(p->kind) && p->at.x == at.x && p->at.y == at.y)
            return true;
    }
    return false;
}

static bool same_point(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }

/* Do two links that are pinned together touch the same thing with equal discs about the pin, or two shapes of one link with equal discs where they meet?
 * One of them is enough. */
static bool is_twin(const lw_model *m, const lw_touch *p, const lw_touch *q)
{
    return p->kind == q->kind && p->kind <= LW_TOUCH_DISCS && same_point(p->drawn, q->drawn)
        && p->radius[0] == q->radius[0] && p->radius[1] == q->radius[1] && p->body[1] == q->body[1]
        && same_point(p->arm[1], q->arm[1]) && same_point(p->along, q->along) && p->length == q->length
        && memcmp(p->surface, q->surface, sizeof *p->surface) == 0
        && (p->link == q->link || is_pinned(&m->linkage, p->link, q->link, p->drawn));
}

/* One of n bins; twins are in one. */
static int bin_of(const lw_touch *p, int n)
{
    double x[] = { p->drawn.x + 0.0, p->drawn.y + 0.0, p->arm[1].x + 0.0, p->arm[1].y + 0.0 };     /* -0 is 0 */
    return (int)(lw_key_table_hash(x, sizeof x) % (unsigned)n);
}

static lw_status drop_twins(const lw_model *m, lw_touch_list *list, lw_error *e)
{
    int n = 0, *first = malloc((2*(size_t)list->n + 1)*sizeof *first), *next = first + list->n;
    if (!first)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < list->n; i++)
        first[i] = -1;
    for (int i = 0; i < list->n; i++) {
        const lw_touch *p = &list->touch[i];
        int bin = bin_of(p, list->n), j = -1;
        for (int k = first[bin]; k >= 0; k = next[k])
            j = is_twin(m, p, &list->touch[k]) ? k : j;                      /* the first one of the list, since bins begin with the last */
        if (j < 0) {
            next[n] = first[bin];
            first[bin] = n;
            list->touch[n++] = *p;
        } else if (p->link != list->touch[j].link) {                         /* it stands for the corners of two links */
            memset(list->touch[j].edge, 0, sizeof list->touch[j].edge);
            memset(list->touch[j].onward, 0, sizeof list->touch[j].onward);
            list->touch[j].into = lw_v2(0, 0);
        }
    }
    free(first);
    list->n = n;
    return LW_OK;
}

lw_status lw_touch_make(const lw_model *m, const lw_system *s, lw_touch_list *list, lw_error *e)
{
    maker w = { m, s, list, true };
    memset(list, 0, sizeof *list);
    add_all(&w);
    w.counting = false;
    list->touch = calloc((size_t)list->n + 1, sizeof *list->touch);
    list->stop_surface = calloc((size_t)s->n_joint + 1, sizeof *list->stop_surface);
    if (!list->touch || !list->stop_surface)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    add_all(&w);
    return drop_twins(m, list, e);
}

void lw_touch_free(lw_touch_list *list)
{
    free(list->touch);
    free(list->stop_surface);
    memset(list, 0, sizeof *list);
}

const char *lw_touch_name(const lw_model *m, const lw_touch *p)
{
    return p->kind == LW_TOUCH_ROPE ? m->rope[p->owner].name : p->kind == LW_TOUCH_STOP
         ? m->linkage.joint[p->owner].name : m->contact[p->owner].name;
}

/* ---- geometry ------------------------------------------------------------------------------------ */

/* A point of a body: place, velocity, and the part of its acceleration that velocities cause. */
typedef struct point { lw_vec2 r, p, v, a; double w; } point;

static point point_of(const lw_touch *t, int end, const lw_body_frame *f, const double *v)
{
    int b = t->body[end];
    point k = { .r = lw_v2_turn(t->arm[end], f[b + 1].dir) };
    k.p = lw_v2_add(f[b + 1].at, k.r);
    if (b < 0 || !v)
        return k;
    k.w = v[3*b + 2];
    k.v = lw_v2_add(lw_v2(v[3*b], v[3*b + 1]), lw_v2_scale(lw_v2_perp(k.r), k.w));
    k.a = lw_v2_scale(k.r, -k.w*k.w);
    return k;
}

/* Derivatives, by the coordinates of both bodies, of w . (point at c of body 0 less that of body 1). */
static void fill_row(const lw_touch *t, const lw_body_frame *f, lw_vec2 w, lw_vec2 c, double *row)
{
    for (int end = 0; end < 2; end++) {
        double sign = end ? -1 : 1, moment = lw_v2_cross(lw_v2_sub(c, f[t->body[end] + 1].at), w);
        bool fixed = t->body[end] < 0;
        row[3*end] = fixed ? 0 : sign*w.x;
        row[3*end + 1] = fixed ? 0 : sign*w.y;
        row[3*end + 2] = fixed ? 0 : sign*moment;
    }
}

static double row_rate(const lw_touch *t, const double *row, const double *v)
{
    double sum = 0;
    for (int i = 0; v && i < 6; i++)
        if (t->body[i/3] >= 0)
            sum += row[i]*v[3*t->body[i/3] + i%3];
    return sum;
}

/* Slip at the point c = p0 - radius n of body 0, with n turning at the rate w: its row, value and bias.  The tangent is
 * the normal turned clockwise; its rate is w n. */
static void fill_slip(const lw_touch *t, const lw_body_frame *f, const double *v, const point *k, double w, lw_touch_motion *m)
{
    lw_vec2 n = m->normal, tangent = lw_v2(n.y, -n.x);
    m->at = lw_v2_sub(k[0].p, lw_v2_scale(n, t->radius[0]));
    fill_row(t, f, tangent, m->at, m->t);
    m->slip = row_rate(t, m->t, v);
    m->slip_bias = 0;
    if (!v)
        return;
    lw_vec2 relative = lw_v2(0, 0), dc = lw_v2_sub(k[0].v, lw_v2_scale(lw_v2_perp(n), t->radius[0]*w));
    for (int end = 0; end < 2; end++) {
        int b = t->body[end];
        if (b < 0)
            continue;
        double sign = end ? -1 : 1, turn = v[3*b + 2];
        lw_vec2 from = lw_v2_sub(m->at, f[b + 1].at), own = lw_v2(v[3*b], v[3*b + 1]);
        relative = lw_v2_add(relative, lw_v2_scale(lw_v2_add(own, lw_v2_scale(lw_v2_perp(from), turn)), sign));
        m->slip_bias += sign*turn*lw_v2_dot(tangent, lw_v2_perp(lw_v2_sub(dc, own)));
    }
    m->slip_bias += w*lw_v2_dot(n, relative);
}

/* The distance d of two points less `reach`, times sign. */
static void between_points(const lw_touch *t, const lw_body_frame *f, const double *v, const point *k, double sign,
                           double reach, lw_touch_motion *m)
{
    lw_vec2 d = lw_v2_sub(k[0].p, k[1].p), dd = lw_v2_sub(k[0].v, k[1].v);
    double length = lw_v2_norm(d);
    lw_vec2 n = length > 0 ? lw_v2_scale(d, 1/length) : lw_v2(1, 0);
    double across = lw_v2_cross(n, dd), w = length > 0 ? across/length : 0;
    m->normal = lw_v2_scale(n, sign);
    m->gap = m->straight = sign*(length - reach);
    fill_row(t, f, m->normal, k[0].p, m->n);
    m->rate = row_rate(t, m->n, v);
    m->bias = v ? sign*(lw_v2_dot(n, lw_v2_sub(k[0].a, k[1].a)) + across*w) : 0;
    fill_slip(t, f, v, k, w, m);
    m->place = m->place_rate = 0;
    double turned = remainder(atan2(n.y, n.x) - t->anchor_angle, 2*LW_PI);
    m->path = t->radius[0]*f[t->body[0] + 1].turn + t->radius[1]*f[t->body[1] + 1].turn
            - (t->radius[0] + t->radius[1])*turned;
}

/* Does one of two sides, or outlines, of a corner of body 0 (2) run behind the face with this normal? */
static bool runs_behind(const lw_touch *t, const lw_body_frame *f, lw_vec2 normal, const lw_vec2 *side)
{
    static const double least = 1e-6;                    /* sine of the angle behind the face */
    bool behind = false;
    for (int k = 0; k < 2; k++)
        behind = behind || lw_v2_dot(normal, lw_v2_turn(side[k], f[t->body[0] + 1].dir)) < -least*lw_v2_norm(side[k]);
    return behind;
}

/* How far the corner with sides e, at d from one with sides f, is from it along n; below 0: they overlap by so much. */
static double apart_along(lw_vec2 n, lw_vec2 d, const lw_vec2 e[2], const lw_vec2 f[2])
{
    double own = fmin(0, fmin(lw_v2_dot(n, e[0]), lw_v2_dot(n, e[1]))), other = fmax(0, fmax(lw_v2_dot(n, f[0]), lw_v2_dot(n, f[1])));
    return lw_v2_dot(n, d) + own - other;
}

static lw_vec2 at_most(lw_vec2 v, double length) { return lw_v2_scale(v, fmin(1, length/fmax(lw_v2_norm(v), 1e-300))); }

typedef enum corner_hold { HOLDS_NOT, HOLDS, HOLDS_ELSEWHERE } corner_hold;

/* Two corners that overlap are held along the normal of that of their four sides along which they overlap least (separating axes).  The corner of body 0
 * is `depth` behind the face with the normal n and the direction u, at d from the corner at its end.  HOLDS: it is this face; HOLDS_NOT: they do not overlap.
 * Of two axes that are as good, as of faces that lie on each other, each holds the corners that are beside its face. */
static corner_hold corners_hold(const lw_touch *t, const lw_body_frame *f, int end, lw_vec2 n, lw_vec2 u, lw_vec2 d, double depth)
{
    double turn = end ? 1 : -1, reach = 2*end_on*depth;
    lw_vec2 e[2], own[2] = { at_most(lw_v2_scale(u, -turn*t->length), reach), at_most(lw_v2_turn(t->beyond[end], f[t->body[1] + 1].dir), reach) };
    for (int k = 0; k < 2; k++)
        e[k] = at_most(lw_v2_turn(t->edge[k], f[t->body[0] + 1].dir), reach);
    enum { SIDES = 3, AXES = 5 };                        /* the other sides, and the lines across the corners where they are cut off */
    lw_vec2 axis[AXES] = { lw_v2_scale(lw_v2_perp(own[1]), turn), lw_v2_scale(lw_v2_perp(e[0]), -1), lw_v2_perp(e[1]),
                           lw_v2_scale(lw_v2_perp(lw_v2_sub(own[0], own[1])), turn), lw_v2_perp(lw_v2_sub(e[0], e[1])) };
    double least = apart_along(n, d, e, own);
    bool beside = turn*lw_v2_dot(u, d) <= 0;
    corner_hold held = HOLDS;
    least += beside ? 1e-3*fabs(least) + LW_TOUCH_END : 0;
    for (int k = 0; k < AXES; k++) {
        double apart = apart_along(unit_vector(axis[k]), d, e, own);
        if (apart > 0 || (k >= SIDES && apart > least))
            return HOLDS_NOT;
        held = apart > least ? HOLDS_ELSEWHERE : held;
    }
    return held;
}

/* The corner of body 0 is `depth` behind the face, at d from its begin.  Does a corner at an end of the face meet it? */
static corner_hold meets_end_on(const lw_touch *t, const lw_body_frame *f, lw_vec2 n, lw_vec2 u, lw_vec2 d, double place, double depth)
{
    bool corners = t->side == 0 && t->length < INFINITY && lw_v2_norm(t->edge[0]) > 0;
    corner_hold held = HOLDS_NOT;
    if (!corners || !(depth > 0 && depth < fmin(t->deepest, fmax(thin_part*t->deepest, 2*t->loose))))
        return HOLDS_NOT;
    for (int end = 0; held == HOLDS_NOT && end < 2; end++)
        if (!(t->notch[end] > 0) && fabs(end ? t->length - place : place) < end_on*depth)
            held = corners_hold(t, f, end, n, u, end ? lw_v2_sub(d, lw_v2_scale(u, t->length)) : d, depth);
    return held;
}

/* The gap of a disc at `place` along a face with the normal n and the direction u, and `height` in front of it, at d from its begin. */
static double gap_at_face(const lw_touch *t, const lw_body_frame *f, lw_vec2 n, lw_vec2 u, lw_vec2 d, double place, double height)
{
    double reach = t->radius[0] + t->radius[1], depth = -height;
    if (t->state == LW_TOUCH_HELD)
        return height - reach;
    /* at a notch the next face holds the disc, up to interpolation: this face goes on there */
    double begin = t->notch[0], end = t->notch[1], deepest = place < 0 ? begin : place > t->length ? end : t->deepest;
    double past = t->length < INFINITY ? fmax(-place - begin, place - t->length - end) : 0;
    corner_hold held = meets_end_on(t, f, n, u, d, place, depth);
    if (held == HOLDS)
        return height - reach;
    if (past > 0)                            /* an end: the disc there repels, and this less than that */
        return hypot(past, height) - reach + past;
    bool behind = t->side == 0 && depth > 0 && t->length < INFINITY &&
                  (held == HOLDS_ELSEWHERE || depth > deepest || (begin == 0 && depth > place*t->slope[0])
                    || (end == 0 && depth > (t->length - place)*t->slope[1]));
    return behind ? depth : height - reach;
}

static void at_face(const lw_touch *t, const lw_body_frame *f, const double *v, const point *k, lw_touch_motion *m)
{
    lw_vec2 u = lw_v2_turn(t->along, f[t->body[1] + 1].dir), d = lw_v2_sub(k[0].p, k[1].p);
    lw_vec2 n = lw_v2_scale(lw_v2_perp(u), t->side < 0 ? -1 : 1), dd = lw_v2_sub(k[0].v, k[1].v);
    double reach = t->radius[0] + t->radius[1], w = k[1].w, height = lw_v2_dot(n, d);
    m->normal = n;
    m->place = lw_v2_dot(u, d);
    m->place_rate = lw_v2_dot(u, dd) + w*lw_v2_cross(u, d);
    m->straight = height - reach;
    m->gap = gap_at_face(t, f, n, u, d, m->place, height);
    fill_row(t, f, n, k[0].p, m->n);
    m->rate = row_rate(t, m->n, v);
    m->bias = v ? lw_v2_dot(n, lw_v2_sub(k[0].a, k[1].a)) + 2*w*lw_v2_dot(lw_v2_perp(n), dd) - w*w*height : 0;
    fill_slip(t, f, v, k, w, m);
    m->path = (t->side < 0 ? -1 : 1)*m->place
            + t->radius[0]*(f[t->body[0] + 1].turn - f[t->body[1] + 1].turn);
}

void lw_touch_at(const lw_touch *p, const lw_equations *eq, const lw_body_frame *frames, const double *v, lw_touch_motion *out)
{
    if (p->kind == LW_TOUCH_STOP) {
        int body[LW_ROW_BLOCKS];
        double row[LW_ROW_SIZE] = { 0 };
        eq->measure_blocks(eq->context, p->owner, body);
        memset(out, 0, sizeof *out);
        out->gap = out->straight = p->sign*(eq->measure(eq->context, p->owner, row, body) - p->limit);
        for (int k = 0; k < LW_ROW_BLOCKS && body[k] >= 0; k++)
            for (int i = 0; i < 3; i++)
                out->n[3*(body[k] != p->body[0]) + i] += p->sign*row[3*k + i];
        out->rate = row_rate(p, out->n, v);
        out->bias = v ? p->sign*eq->measure_bias(eq->context, p->owner, v) : 0;
        return;
    }
    point k[2] = { point_of(p, 0, frames, v), point_of(p, 1, frames, v) };
    if (p->kind == LW_TOUCH_FACE)
        at_face(p, frames, v, k, out);
    else if (p->kind == LW_TOUCH_ROPE)
        between_points(p, frames, v, k, -1, p->limit, out);
    else
        between_points(p, frames, v, k, 1, p->radius[0] + p->radius[1], out);
}

double lw_touch_gap(const lw_touch *p, const lw_equations *eq, const lw_body_frame *frames)
{
    lw_touch_motion m;
    if (p->kind == LW_TOUCH_STOP) {
        lw_touch_at(p, eq, frames, NULL, &m);
        return m.gap;
    }
    lw_vec2 d = lw_v2_sub(point_of(p, 0, frames, NULL).p, point_of(p, 1, frames, NULL).p);
    if (p->kind == LW_TOUCH_ROPE)
        return p->limit - lw_v2_norm(d);
    if (p->kind == LW_TOUCH_DISCS)
        return lw_v2_norm(d) - (p->radius[0] + p->radius[1]);
    lw_vec2 u = lw_v2_turn(p->along, frames[p->body[1] + 1].dir), n = lw_v2_scale(lw_v2_perp(u), p->side < 0 ? -1 : 1);
    return gap_at_face(p, frames, n, u, d, lw_v2_dot(u, d), lw_v2_dot(n, d));
}

bool lw_touch_choose_side(lw_touch *p, const lw_body_frame *frames, bool anew, double near)
{
    if (p->kind != LW_TOUCH_FACE || p->side == 0)
        return true;
    point k[2] = { point_of(p, 0, frames, NULL), point_of(p, 1, frames, NULL) };
    lw_vec2 u = lw_v2_turn(p->along, frames[p->body[1] + 1].dir), d = lw_v2_sub(k[0].p, k[1].p);
    double place = lw_v2_dot(u, d), across = lw_v2_cross(u, d), reach = p->radius[0] + p->radius[1];
    bool beside = fmin(place, p->length - place) > LW_TOUCH_END;
    p->side = anew ? LW_TOUCH_NO_SIDE : p->side;
    if (beside && p->side != LW_TOUCH_NO_SIDE)
        return true;
    bool on_line = fabs(across) <= (reach > 0 ? fmin(near, 0.5*reach) : near);
    if (on_line)                             /* its shape tells the side, unless that is parallel; or it is where it was */
        across = lw_v2_cross(u, lw_v2_turn(p->into, frames[p->body[0] + 1].dir));
    if (!on_line || fabs(across) > 1e-3)
        p->side = across < 0 ? -1 : 1;
    return !beside || p->side != LW_TOUCH_NO_SIDE;
}

void lw_touch_round_end(lw_touch *p, const lw_touch_motion *m, double since)
{
    bool begin = m->place < 0.5*p->length;
    double in = begin ? m->place : p->length - m->place, rate = begin ? m->place_rate : -m->place_rate;
    bool came = p->kind == LW_TOUCH_FACE && abs(p->side) == 1 && !p->joined[!begin] && in > LW_TOUCH_END && in < rate*since;
    if (came && m->gap + p->radius[0] + p->radius[1] - m->rate*in/rate < -1e-7)          /* there, by more than rounding */
        p->side = -p->side;
}

/* Near a corner the way through the body from one face to the next is short, and round the end of a segment there is none.  A disc that has jumped through a
 * rigid bar beside its ends is still seen, since the bar keeps the side from which it is touched. */
double lw_touch_size(const lw_touch *p, const lw_touch_motion *m)
{
    double size = p->side != 0 && !(p->surface->stiffness > 0) ? INFINITY : p->size, place = m->place + (m->rate < 0 && m->gap > 0 ? -m->place_rate*m->gap/m->rate : 0);
    for (int end = 0; p->kind == LW_TOUCH_FACE && p->length < INFINITY && end < 2; end++) {
        double slope = p->slope[end], along = end ? p->length - place : place;
        bool notch = p->side == 0 && !(slope < INFINITY);
        if (!notch)
            size = fmin(size, along*(slope < 1 ? 2*slope/(1 + slope*slope) : 1));
    }
    return fmax(size, p->least_size);
}

bool lw_touch_past_end(const lw_touch *p, const lw_touch_motion *m)
{
    if (p->kind != LW_TOUCH_FACE || !(p->length < INFINITY))
        return false;
    bool begin = m->place < 0.5*p->length;
    double past = (begin ? -m->place : m->place - p->length) - p->notch[!begin], rate = begin ? -m->place_rate : m->place_rate;
    return past > (rate > 0 ? 0.5 : 1)*LW_TOUCH_END;
}

static bool at_end(const lw_touch *p, const lw_touch_motion *m, double near)
{
    return p->kind == LW_TOUCH_FACE && p->length < INFINITY && !(p->radius[1] > 0) && !(fmin(m->place, p->length - m->place) > near);
}

bool lw_touch_goes_on(const lw_touch *p, const lw_body_frame *frames, const lw_touch_motion *m, double near)
{
    bool meets = p->onward[0].x != 0 || p->onward[0].y != 0;
    return at_end(p, m, near) && (p->covered[m->place > 0.5*p->length] || (meets && (runs_behind(p, frames, m->normal, p->edge)
                                                                                      || runs_behind(p, frames, m->normal, p->onward))));
}

/* Bodies that touch corner to corner have a line between them along one of the four sides, so that one of the faces stays. */
bool lw_touch_beside_end(const lw_touch *p, const lw_body_frame *frames, const lw_touch_motion *m)
{
    return at_end(p, m, LW_TOUCH_END) && (runs_behind(p, frames, m->normal, p->edge) || lw_touch_goes_on(p, frames, m, LW_TOUCH_END));
}

bool lw_touch_crosses(const lw_touch *p, const lw_body_frame *frames, double by)
{
    if (p->kind != LW_TOUCH_FACE || p->side != 0 || !(p->length < INFINITY))
        return false;
    point k[2] = { point_of(p, 0, frames, NULL), point_of(p, 1, frames, NULL) };
    lw_vec2 u = lw_v2_turn(p->along, frames[p->body[1] + 1].dir), n = lw_v2_perp(u), d = lw_v2_sub(k[0].p, k[1].p);
    double height = lw_v2_dot(n, d), place = lw_v2_dot(u, d);
    for (int e = 0; height > by && e < 2; e++) {
        lw_vec2 side = lw_v2_turn(p->edge[e], frames[p->body[0] + 1].dir);
        double down = -lw_v2_dot(n, side), at = place + lw_v2_dot(u, side)*height/down;
        if (down > height + by && fmin(at, p->length - at)*down > by*lw_v2_norm(side))
            return true;
    }
    return false;
}

double lw_touch_force(const lw_surface *s, double unit, double depth, double rate)
{
    if (!(depth > 0))
        return 0;
    double x = depth*unit, power = s->exponent == 1 ? x : pow(x, s->exponent);
    return s->stiffness*power*fmax(0, 1 + s->damping*rate*unit);
}

/* catalogues/exchange/export_solvespace.c - write a linkage as a sketch of SolveSpace (file format of SolveSpace 3):
 * every link is a set of points at constant distances, points on one pin are coincident, the points of the ground are
 * fixed. One degree of freedom is left to drag. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/union_find.h"
#include "catalogues/exchange/export.h"

#define MM        1000.0
#define DIGITS    15
#define REQUESTS  0x7fffu                           /* their numbers are the upper half of a handle; the first bit is taken */

enum { COINCIDENT = 20, DISTANCE = 30, LINE_DISTANCE = 32, ON_LINE = 42, FIXED = 200 };   /* types of its constraints */

typedef struct sketch_point { lw_vec2 at; int link; unsigned entity; } sketch_point;      /* [mm]               */

typedef struct writer {
    const lw_assembly *k;
    lw_bytes          *out;
    int                n;
    sketch_point      *p;
    int              (*on)[2][2];                /* of a joint: point on its two links; or two points of its line on
                                                  * link[0], two of link[1] on that line                         */
    int              *group;                    /* of points on one pin                                         */
    int              *first, *last, *next;      /* points of a link, rising; -1: none, the end                  */
    unsigned           request, constraint;
    double             size;                     /* [mm]                                                         */
} writer;

/* ---- text ------------------------------------------------------------------------------------------------ */

static void put(writer *w, const char *key, const char *value)
{
    lw_bytes_text(w->out, key);
    lw_bytes_text(w->out, "=");
    lw_bytes_text(w->out, value);
    lw_bytes_text(w->out, "\n");
}

static void put_handle(writer *w, const char *key, unsigned v)
{
    char text[16];
    snprintf(text, sizeof text, "%08x", v);
    put(w, key, text);
}

static void put_int(writer *w, const char *key, int v)
{
    char text[16];
    snprintf(text, sizeof text, "%d", v);
    put(w, key, text);
}

static void put_real(writer *w, const char *key, double v)
{
    char text[32];
    lw_number_text(text, v, DIGITS);
    put(w, key, text);
}

static void put_param(writer *w, unsigned handle, double v)
{
    put_handle(w, "Param.h.v.", handle);
    put_real(w, "Param.val", v);
    lw_bytes_text(w->out, "AddParam\n\n");
}

/* type 101: a point; 200: a line segment. */
static unsigned put_request(writer *w, int type)
{
    unsigned h = ++w->request;
    put_handle(w, "Request.h.v", h);
    put_int(w, "Request.type", type);
    put_handle(w, "Request.workplane.v", 0x80020000u);
    put_handle(w, "Request.group.v", 2);
    put_int(w, "Request.construction", 0);
    lw_bytes_text(w->out, "AddRequest\n\n");
    return h << 16;
}

static void put_constraint(writer *w, int type, double value, unsigned a, unsigned b, unsigned line)
{
    put_handle(w, "Constraint.h.v", ++w->constraint);
    put_int(w, "Constraint.type", type);
    put_handle(w, "Constraint.group.v", 2);
    put_handle(w, "Constraint.workplane.v", 0x80020000u);
    if (type == DISTANCE || type == LINE_DISTANCE)
        put_real(w, "Constraint.valA", value);
    put_handle(w, "Constraint.ptA.v", a);
    if (b)
        put_handle(w, "Constraint.ptB.v", b);
    if (line)
        put_handle(w, "Constraint.entityA.v", line);
    put_int(w, "Constraint.other", 0);
    put_int(w, "Constraint.other2", 0);
    put_int(w, "Constraint.reference", 0);
    lw_bytes_text(w->out, "AddConstraint\n\n");
}

/* ---- points ------------------------------------------------------------------------------------------------ */

/* The point of a link at this place. Several joints of a link at one place use the same point. */
static int point_of(writer *w, int link, lw_vec2 at)
{
    lw_vec2 p = lw_v2_scale(at, MM);
    for (int i = w->first[link]; i >= 0; i = w->next[i])
        if (fabs(w->p[i].at.x - p.x) < 1e-9*w->size && lw_v2_norm(lw_v2_sub(w->p[i].at, p)) < 1e-9*w->size)
            return i;
    if (w->first[link] < 0)
        w->first[link] = w->n;
    else
        w->next[w->last[link]] = w->n;
    w->last[link] = w->n;
    w->next[w->n] = -1;
    w->p[w->n] = (sketch_point){ .at = p, .link = link };
    return w->n++;
}

static void collect(writer *w)
{
    const lw_assembly *k = w->k;
    for (int i = 0; i < k->n_link; i++)
        w->first[i] = -1;
    for (int j = 0; j < k->n_joint && w->n - k->n_link <= (int)REQUESTS; j++) {
        const lw_joint *p = &k->joint[j];
        lw_vec2 half = lw_v2_scale(p->along, 0.25*w->size/MM);
        if (lw_joint_turns(p->kind)) {
            w->on[j][0][0] = point_of(w, p->link[0], p->at);
            w->on[j][1][0] = point_of(w, p->link[1], p->at);
            continue;
        }
        w->on[j][0][0] = point_of(w, p->link[0], lw_v2_sub(p->at, lw_v2_scale(half, 2)));
        w->on[j][0][1] = point_of(w, p->link[0], lw_v2_add(p->at, lw_v2_scale(half, 2)));
        w->on[j][1][0] = point_of(w, p->link[1], p->at);
        w->on[j][1][1] = lw_joint_has_slot(p->kind) ? w->on[j][1][0] : point_of(w, p->link[1], lw_v2_add(p->at, half));
    }
    for (int t = 0; t < k->n_tracer && w->n - k->n_link <= (int)REQUESTS; t++)
        point_of(w, k->tracer[t].link, k->tracer[t].at);
}

/* Find the two points of a link that are farthest apart. False: it has only one point. */
static bool base_line(const writer *w, int link, int base[2])
{
    double most = 0;
    lw_vec2 lo = { INFINITY, INFINITY }, hi = { -INFINITY, -INFINITY };        /* of the points before i: no search where even */
    for (int i = w->first[link]; i >= 0; i = w->next[i]) {                     /* its corners are nearer than two points were */
        lw_vec2 p = w->p[i].at, far = { fmax(p.x - lo.x, hi.x - p.x), fmax(p.y - lo.y, hi.y - p.y) };
        for (int j = w->first[link]; j != i && lw_v2_norm(far)*(1 + 1e-9) > most; j = w->next[j]) {
            double d = lw_v2_norm(lw_v2_sub(w->p[i].at, w->p[j].at));
            if (d > most) {
                most = d;
                base[0] = j;
                base[1] = i;
            }
        }
        lo = lw_v2(fmin(lo.x, p.x), fmin(lo.y, p.y));
        hi = lw_v2(fmax(hi.x, p.x), fmax(hi.y, p.y));
    }
    return most > 0;
}

static unsigned put_line(writer *w, const lw_vec2 a, const lw_vec2 b)
{
    unsigned h = put_request(w, 200);
    put_param(w, h | 0x10, a.x);
    put_param(w, h | 0x11, a.y);
    put_param(w, h | 0x13, b.x);
    put_param(w, h | 0x14, b.y);
    return h;
}

static void put_point(writer *w, sketch_point *p)
{
    p->entity = put_request(w, 101);
    put_param(w, p->entity | 0x10, p->at.x);
    put_param(w, p->entity | 0x11, p->at.y);
}

/* Fix a point of a moving link by its distance from the link's base line and by its distance from one end of that line,
 * the end farther from it along the line. */
static void hold(writer *w, const sketch_point *p, const sketch_point *a, const sketch_point *b, unsigned line)
{
    lw_vec2 d = lw_v2_sub(b->at, a->at), q = lw_v2_sub(p->at, a->at);
    double length = lw_v2_norm(d), height = lw_v2_cross(d, q)/length, along = lw_v2_dot(d, q)/length;
    const sketch_point *from = along > 0.5*length ? a : b;
    if (fabs(height) < 1e-9*w->size)
        put_constraint(w, ON_LINE, 0, p->entity, 0, line);
    else
        put_constraint(w, LINE_DISTANCE, -height, p->entity, 0, line);
    put_constraint(w, DISTANCE, lw_v2_norm(lw_v2_sub(p->at, from->at)), p->entity, from->entity, 0);
}

static void put_link(writer *w, int link)
{
    int base[2] = { -1, -1 };
    bool ground = link == w->k->ground, has_line = base_line(w, link, base);
    unsigned line = 0;
    if (has_line) {
        line = put_line(w, w->p[base[0]].at, w->p[base[1]].at);
        w->p[base[0]].entity = line | 1;
        w->p[base[1]].entity = line | 2;
    }
    for (int i = w->first[link]; i >= 0; i = w->next[i])
        if (i != base[0] && i != base[1])
            put_point(w, &w->p[i]);
    for (int i = w->first[link]; i >= 0; i = w->next[i])
        if (ground)
            put_constraint(w, FIXED, 0, w->p[i].entity, 0, 0);
        else if (i != base[0] && i != base[1] && has_line)
            hold(w, &w->p[i], &w->p[base[0]], &w->p[base[1]], line);
    if (!ground && has_line)
        put_constraint(w, DISTANCE, lw_v2_norm(lw_v2_sub(w->p[base[0]].at, w->p[base[1]].at)), line | 1, line | 2, 0);
}

/* ---- joints -------------------------------------------------------------------------------------------------- */

/* Join pins that share a link and a place once: a point already joined to another is not joined again. */
static void put_pins(writer *w)
{
    int *group = w->group;
    for (int i = 0; i < w->n; i++)
        group[i] = i;
    for (int j = 0; j < w->k->n_joint; j++) {
        int a = lw_root_of(group, w->on[j][0][0]), b = lw_root_of(group, w->on[j][1][0]);
        if (!lw_joint_turns(w->k->joint[j].kind) || a == b)
            continue;
        put_constraint(w, COINCIDENT, 0, w->p[w->on[j][0][0]].entity, w->p[w->on[j][1][0]].entity, 0);
        group[b] = a;
    }
}

/* Write a separate line along the rail, its ends coincident with the rail's points. */
static void put_slide(writer *w, int j)
{
    const int *rail = w->on[j][0], *block = w->on[j][1];
    unsigned line = put_line(w, w->p[rail[0]].at, w->p[rail[1]].at);
    put_constraint(w, COINCIDENT, 0, line | 1, w->p[rail[0]].entity, 0);
    put_constraint(w, COINCIDENT, 0, line | 2, w->p[rail[1]].entity, 0);
    put_constraint(w, ON_LINE, 0, w->p[block[0]].entity, 0, line);
    if (block[1] != block[0])
        put_constraint(w, ON_LINE, 0, w->p[block[1]].entity, 0, line);
}

static void put_head(writer *w)
{
    static const char groups[] =
        "\xb1\xb2\xb3SolveSpaceREVa\n\n\n"
        "Group.h.v=00000001\nGroup.type=5000\nGroup.name=#references\nGroup.color=ff000000\nGroup.visible=1\n"
        "Group.scale=1.00000000000000000000\nGroup.remap={\n}\nAddGroup\n\n"
        "Group.h.v=00000002\nGroup.type=5001\nGroup.order=1\nGroup.name=linkage\nGroup.activeWorkplane.v=80020000\n"
        "Group.color=ff000000\nGroup.subtype=6000\nGroup.predef.q.w=1.00000000000000000000\n"
        "Group.predef.origin.v=00010001\nGroup.visible=1\nGroup.allowRedundant=0\n"
        "Group.scale=1.00000000000000000000\nGroup.remap={\n}\nAddGroup\n\n"
        "Request.h.v=00000001\nRequest.type=100\nRequest.group.v=00000001\nRequest.construction=0\nAddRequest\n\n"
        "Request.h.v=00000002\nRequest.type=100\nRequest.group.v=00000001\nRequest.construction=0\nAddRequest\n\n"
        "Request.h.v=00000003\nRequest.type=100\nRequest.group.v=00000001\nRequest.construction=0\nAddRequest\n\n";
    lw_bytes_add(w->out, groups, sizeof groups - 1);
    w->request = 3;
}

static lw_status check(const lw_assembly *linkage, lw_error *e)
{
    lw_status s = lw_assembly_check(linkage, e);
    for (int j = 0; s == LW_OK && j < linkage->n_joint; j++)
        if (!lw_joint_has_position(linkage->joint[j].kind))
            s = lw_error_set(e, LW_E_KIND, "joint '%s': gears and welds have no form in this sketch", linkage->joint[j].name);
    return s;
}

lw_status lw_export_solvespace(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    (void)o;
    lw_status s = check(linkage, e);
    size_t points = 4*(size_t)linkage->n_joint + (size_t)linkage->n_tracer + 1;
    if (s != LW_OK)
        return s;
    writer w = { .k = linkage, .out = out, .size = MM*lw_export_size(linkage) };
    w.p = malloc(points*sizeof *w.p);
    w.on = calloc((size_t)linkage->n_joint + 1, sizeof *w.on);
    w.group = malloc(points*sizeof *w.group);
    w.next = malloc(points*sizeof *w.next);
    w.first = malloc((size_t)linkage->n_link*sizeof *w.first);
    w.last = malloc((size_t)linkage->n_link*sizeof *w.last);
    bool room = w.p && w.on && w.group && w.next && w.first && w.last;
    if (room)
        collect(&w);
    if (room && w.n - linkage->n_link <= (int)REQUESTS) {
        put_head(&w);
        for (int link = 0; link < linkage->n_link; link++)
            put_link(&w, link);
        put_pins(&w);
        for (int j = 0; j < linkage->n_joint; j++)
            if (!lw_joint_turns(linkage->joint[j].kind))
                put_slide(&w, j);
        s = lw_bytes_end(out, e);
    } else if (!room)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory for a sketch");
    if (s == LW_OK && (w.n - linkage->n_link > (int)REQUESTS || w.request > REQUESTS)) {
        lw_bytes_free(out);
        s = lw_error_set(e, LW_E_KIND, "a sketch of SolveSpace numbers up to %u points and lines, and this linkage needs more", REQUESTS);
    }
    free(w.p), free(w.on), free(w.group), free(w.next), free(w.first), free(w.last);
    return s;
}

/* mbs/space/kernel_tree.c - the accelerations of a tree and its loops in eight states at once: motion outwards, inertias and loads
 * inwards, then the multipliers of the loops' rows, accelerations outwards.  Legs are solved on the way inwards, and add what they resist
 * with to the body that they carry.  The formulas are those of mbs/space/recursive.c, one value for all lanes in each register.  Called again
 * for states nearby, it keeps the factors and changes the accelerations and multipliers of the last call by what these lack.  Compiled
 * once per instruction set. */
#include "mbs/space/kernel_tree_internal.h"
#include "mbs/space/kernel_vec_internal.h"

#define lw_tree_kernel_here LW_OF_ISA(lw_tree_kernel, LW_ISA)

static const double no_mass = 1e-13;         /* inertia along a rate, over the greatest: none */
static const double no_pivot = 1e-13;        /* of loops, over the first: singular */
static const double weak_leg = 1e-3;         /* least pivot of a leg over its first, below which legs are solved with all loops */

typedef struct articulated { pack j[6], m[6]; vec b[3]; } articulated;       /* moment = J alpha + B a, force = B^T alpha + M a */
typedef struct body {
    quat  turn;
    vec   row[3];                            /* of the turn */
    vec   at, from_parent;
    screw velocity, trial;                   /* trial: acceleration with that of the rates in the last call, or none */
    articulated inertia;                     /* without children only J, M is the mass and B 0 */
    screw load;                              /* then the acceleration */
} body;
typedef struct rate { screw axis, push; pack by_inertia, free; } rate;
_Static_assert(sizeof(body) == LW_TREE_BODY_PACKS*sizeof(pack), "size of a body's state");
_Static_assert(sizeof(rate) == LW_TREE_RATE_PACKS*sizeof(pack), "size of a rate's state");

LW_INLINE vec turned(const body *b, lw_vec3 a) { return (vec){ by(b->row[0], a), by(b->row[1], a), by(b->row[2], a) }; }
LW_INLINE vec turned_by(const body *b, vec a) { return (vec){ dot(b->row[0], a), dot(b->row[1], a), dot(b->row[2], a) }; }
LW_INLINE vec to_own(const body *b, vec a)
{
    const vec *r = b->row;
    return (vec){ r[0].x*a.x + r[1].x*a.y + r[2].x*a.z, r[0].y*a.x + r[1].y*a.y + r[2].y*a.z, r[0].z*a.x + r[1].z*a.y + r[2].z*a.z };
}
/* The matrix of a quaternion whose length is 1 but for rounding. */
LW_INLINE void set_rows(body *b)
{
    quat a = b->turn;
    pack s = 2*(2 - (a.w*a.w + a.x*a.x + a.y*a.y + a.z*a.z));
    pack sx = s*a.x, sy = s*a.y, sz = s*a.z, xx = sx*a.x, yy = sy*a.y, zz = sz*a.z, xy = sx*a.y, xz = sx*a.z, yz = sy*a.z,
         wx = sx*a.w, wy = sy*a.w, wz = sz*a.w;
    b->row[0] = (vec){ 1 - yy - zz, xy - wz, xz + wy };
    b->row[1] = (vec){ xy + wz, 1 - xx - zz, yz - wx };
    b->row[2] = (vec){ xz - wy, yz + wx, 1 - xx - yy };
}

LW_INLINE quat angle_part(const lw_stage_body *p, pack c, pack s)
{
    return (quat){ c*p->part[0].w + s*p->part[1].w, c*p->part[0].x + s*p->part[1].x, c*p->part[0].y + s*p->part[1].y,
                   c*p->part[0].z + s*p->part[1].z };
}

/* Turn of body 1 against body 0, and the slide along directions of body 0. */
LW_INLINE quat relative(const lw_tree_stages *t, const lw_stage_body *p, const double *y, int lane, vec *slide, bool *slides)
{
    const double *x = y + 8*p->x, *c = t->cosine + 8*p->angle + lane, *s = t->sine + 8*p->angle + lane;
    *slides = true;
    switch (p->kind) {
    case LW_SPATIAL_PRISMATIC: *slide = times(fixed(p->along[0]), pick(x)); return fixed_quat(p->part[0]);
    case LW_SPATIAL_CYLINDRICAL: *slide = times(fixed(p->along[0]), pick(x + 8)); return angle_part(p, pick(c), pick(s));
    case LW_SPATIAL_SCREW: *slide = times(fixed(p->along[0]), p->pitch*pick(x)); return angle_part(p, pick(c), pick(s));
    case LW_SPATIAL_PLANAR:
        *slide = add(times(fixed(p->along[0]), pick(x)), times(fixed(p->along[1]), pick(x + 8)));
        return angle_part(p, pick(c), pick(s));
    case LW_SPATIAL_FREE: *slide = (vec){ pick(x), pick(x + 8), pick(x + 16) }; return unit_quat(x + 24);
    default: break;
    }
    *slides = false;
    switch (p->kind) {
    case LW_SPATIAL_UNIVERSAL: {
        pack c1 = pick(c + 8), s1 = pick(s + 8);
        return quat_times(angle_part(p, pick(c), pick(s)), (quat){ c1, s1*p->second.x, s1*p->second.y, s1*p->second.z });
    }
    case LW_SPATIAL_SPHERICAL: return quat_times(unit_quat(x), fixed_quat(p->part[0]));
    case LW_SPATIAL_FIXED: return fixed_quat(p->part[0]);
    default: return angle_part(p, pick(c), pick(s));
    }
}

/* Motions of body 1 against body 0: turns about an axis or slides along it (ground axes), or both (screw). */
typedef struct motion { rate *rate; const double *u; vec arm, turn, slide; } motion;
LW_INLINE void turn_about(motion *m, vec axis, double pitch)
{
    pack u = pick(m->u);
    vec by_u = times(axis, u);
    m->rate->axis = (screw){ axis, cross(m->arm, axis) };
    m->turn = add(m->turn, by_u);
    if (pitch != 0) {
        m->rate->axis.move = add(m->rate->axis.move, times(axis, all_lanes(pitch)));
        m->slide = add(m->slide, times(by_u, all_lanes(pitch)));
    }
    m->rate++, m->u += 8;
}
LW_INLINE void slide_along(motion *m, vec axis)
{
    m->slide = add(m->slide, times(axis, pick(m->u)));
    m->rate->axis = (screw){ none, axis };
    m->rate++, m->u += 8;
}

LW_INLINE vec column(const body *b, int k)
{
    const pack *x = &b->row[0].x + k, *y = &b->row[1].x + k, *z = &b->row[2].x + k;
    return (vec){ *x, *y, *z };
}

typedef struct slide { vec by; bool any; } slide;

static void orient(const lw_tree_stages *t, const lw_stage_body *p, const double *y, int lane, const body *b, body *to, slide *s)
{
    quat q = relative(t, p, y, lane, &s->by, &s->any);
    to->turn = quat_times(b->turn, p->back ? (quat){ q.w, -q.x, -q.y, -q.z } : q);
    set_rows(to);
}

/* A body that is oriented; du: accelerations of the rates for the trial, NULL: none. */
static void place(const lw_tree_stages *t, const lw_stage_body *p, const double *y, const double *du, const slide *s, const body *b,
                  body *to, rate *rates)
{
    const body *b0 = p->back ? to : b, *b1 = p->back ? b : to;
    vec e0 = turned(b0, p->arm[0]), e1 = turned(b1, p->arm[1]);      /* from the centres to the joint's point on body 1 */
    e0 = s->any ? add(e0, turned_by(b0, s->by)) : e0;
    to->from_parent = p->back ? sub(e1, e0) : sub(e0, e1);
    to->at = add(b->at, to->from_parent);
    const double *u = y + 8*(t->n_x + p->u);
    motion m = { rates + p->u, u, p->back ? e0 : e1, none, none };
    vec z = turned(b0, p->z), second = none;
    switch (p->kind) {
    case LW_SPATIAL_PRISMATIC: slide_along(&m, z); break;
    case LW_SPATIAL_CYLINDRICAL: turn_about(&m, z, 0), slide_along(&m, z); break;
    case LW_SPATIAL_SCREW: turn_about(&m, z, p->pitch); break;
    case LW_SPATIAL_PLANAR:
        slide_along(&m, turned(b0, p->along[0])), slide_along(&m, turned(b0, p->along[1])), turn_about(&m, z, 0);
        break;
    case LW_SPATIAL_UNIVERSAL: turn_about(&m, z, 0), turn_about(&m, second = turned(b1, p->second), 0); break;
    case LW_SPATIAL_FREE:
        for (int k = 0; k < 3; k++)
            slide_along(&m, column(b0, k));
        for (int k = 0; k < 3; k++)
            turn_about(&m, column(b0, k), 0);
        break;
    case LW_SPATIAL_SPHERICAL:
        for (int k = 0; k < 3; k++)
            turn_about(&m, column(b0, k), 0);
        break;
    case LW_SPATIAL_FIXED: break;
    default: turn_about(&m, z, 0);
    }
    const vec w = b->velocity.turn;
    to->velocity.turn = p->back ? sub(w, m.turn) : add(w, m.turn);
    vec w0 = p->back ? to->velocity.turn : w, w1 = p->back ? w : to->velocity.turn;
    vec c0 = cross(w0, e0), c1 = cross(w1, e1), change = sub(c0, c1), twist = cross(w0, m.turn);
    if (p->kind == LW_SPATIAL_UNIVERSAL)
        twist = add(cross(w0, times(z, pick(u))), cross(w1, times(second, pick(u + 8))));
    vec rest = sub(sub(cross(w0, c0), cross(w1, c1)), cross(twist, m.arm));
    if (s->any)
        change = add(change, m.slide), rest = add(rest, times(cross(w0, m.slide), all_lanes(2)));
    if (p->back) {
        change = minus(change), twist = minus(twist), rest = minus(rest);
        for (rate *r = rates + p->u; r < m.rate; r++)
            r->axis = (screw){ minus(r->axis.turn), minus(r->axis.move) };
    }
    to->velocity.move = add(b->velocity.move, change);
    to->trial.turn = add(b->trial.turn, twist);
    to->trial.move = add(add(b->trial.move, cross(b->trial.turn, to->from_parent)), rest);
    for (const rate *r = rates + p->u; du && r < m.rate; r++)
        to->trial = add_screw(to->trial, times_screw(r->axis, pick(du + 8*(r - rates))));
}

LW_INLINE vec sym_times(const pack *m, vec a)
{
    return (vec){ m[0]*a.x + m[3]*a.y + m[4]*a.z, m[3]*a.x + m[1]*a.y + m[5]*a.z, m[4]*a.x + m[5]*a.y + m[2]*a.z };
}

LW_INLINE articulated alone(const articulated *i, double mass)
{
    const pack m = all_lanes(mass), no = { 0 };
    return (articulated){ { i->j[0], i->j[1], i->j[2], i->j[3], i->j[4], i->j[5] }, { m, m, m, no, no, no }, { none, none, none } };
}

/* The load: what the trial acceleration and spinning need, minus the weight; and, if wanted, the inertia about the centre in ground axes. */
LW_INLINE void weigh(const lw_stage_body *p, const bool inertia, body *b)
{
    const vec *a = b->row;
    vec w = b->velocity.turn, need;
    if (inertia) {
        vec i[3];
        for (int k = 0; k < 3; k++)
            i[k] = (vec){ p->mass[1]*a[k].x, p->mass[2]*a[k].y, p->mass[3]*a[k].z };
        pack *j = b->inertia.j;
        j[0] = dot(i[0], a[0]), j[1] = dot(i[1], a[1]), j[2] = dot(i[2], a[2]);
        j[3] = dot(i[0], a[1]), j[4] = dot(i[0], a[2]), j[5] = dot(i[1], a[2]);
        need = add(cross(w, sym_times(j, w)), sym_times(j, b->trial.turn));
    }
    else {                                   /* Euler's equations in the axes of the body */
        vec s = to_own(b, w), n = to_own(b, b->trial.turn);
        need = turned_by(b, (vec){ p->mass[1]*n.x + (p->mass[3] - p->mass[2])*(s.y*s.z), p->mass[2]*n.y + (p->mass[1] - p->mass[3])*(s.z*s.x),
                                   p->mass[3]*n.z + (p->mass[2] - p->mass[1])*(s.x*s.y) });
    }
    if (inertia && p->carried)
        b->inertia = alone(&b->inertia, p->mass[0]);
    b->load = (screw){ need, sub(times(b->trial.move, all_lanes(p->mass[0])), fixed(p->weight)) };
}

/* Some bodies at a time, in three passes: those are short, so the processor works at several bodies side by side, while their state is in its
 * first cache. */
LW_INLINE void place_all(const lw_tree_stages *t, const bool again, const double *y, int lane, const double *du, body *all, rate *rates)
{
    enum { SOME = 8 };
    slide slides[SOME];
    for (int from = 0, end; from < t->n_body; from = end) {
        end = from + SOME < t->n_body ? from + SOME : t->n_body;
        for (int i = from; i < end; i++)
            orient(t, &t->body[i], y, lane, &all[t->body[i].parent], &all[i], &slides[i - from]);
        for (int i = from; i < end; i++)
            place(t, &t->body[i], y, again ? du : NULL, &slides[i - from], &all[t->body[i].parent], &all[i], rates);
        for (int i = from; i < end; i++)
            weigh(&t->body[i], !again, &all[i]);
    }
}

/* Springs and dampers between points; returns the power of the dampers. */
static pack pull(const lw_tree_stages *t, body *all)
{
    pack power = { 0 };
    for (int i = 0; i < t->n_spring; i++) {
        const lw_stage_spring *p = &t->spring[i];
        vec arm[2], d = none, v = none;
        for (int k = 0; k < 2; k++) {
            const body *b = &all[p->body[k]];
            vec at = add(b->at, arm[k] = turned(b, p->arm[k])), to = add(b->velocity.move, cross(b->velocity.turn, arm[k]));
            d = k ? sub(at, d) : at, v = k ? sub(to, v) : to;
        }
        pack length = root(dot(d, d));
        vec along = times(d, 1/choose(length > 0, length, all_lanes(1)));
        pack speed = t->unit*dot(along, v);
        pack tension = p->stiffness*(t->unit*length - p->free) + p->damping*speed;
        vec force = times(along, t->unit*tension);
        power -= p->damping*speed*speed;
        for (int k = 0; k < 2; k++) {
            screw *load = &all[p->body[k]].load;
            vec f = k ? force : (vec){ -force.x, -force.y, -force.z };
            load->move = add(load->move, f), load->turn = add(load->turn, cross(arm[k], f));
        }
    }
    return power;
}

LW_INLINE screw inertia_times(const articulated *i, screw a)
{
    const vec *b = i->b, t = a.turn, v = a.move;
    return (screw){ add(sym_times(i->j, t), (vec){ dot(b[0], v), dot(b[1], v), dot(b[2], v) }),
                    add(add(times(b[0], t.x), add(times(b[1], t.y), times(b[2], t.z))), sym_times(i->m, v)) };
}

/* i -= p p^T s */
LW_INLINE void take_away(articulated *i, screw p, pack s)
{
    vec a = times(p.turn, s), b = times(p.move, s), t = p.turn, v = p.move;
    i->j[0] -= a.x*t.x, i->j[1] -= a.y*t.y, i->j[2] -= a.z*t.z, i->j[3] -= a.x*t.y, i->j[4] -= a.x*t.z, i->j[5] -= a.y*t.z;
    i->m[0] -= b.x*v.x, i->m[1] -= b.y*v.y, i->m[2] -= b.z*v.z, i->m[3] -= b.x*v.y, i->m[4] -= b.x*v.z, i->m[5] -= b.y*v.z;
    i->b[0] = sub(i->b[0], times(v, a.x)), i->b[1] = sub(i->b[1], times(v, a.y)), i->b[2] = sub(i->b[2], times(v, a.z));
}

/* The same inertia about a point -d away, added to that of a body; first: of its children, so it is of this mass alone yet. */
LW_INLINE void add_shifted(articulated *to, bool first, double mass, const articulated *i, vec d)
{
    const pack *m = i->m;
    vec c[3] = { cross(d, (vec){ m[0], m[3], m[4] }), cross(d, (vec){ m[3], m[1], m[5] }), cross(d, (vec){ m[4], m[5], m[2] }) };
    vec b[3] = { add(i->b[0], (vec){ c[0].x, c[1].x, c[2].x }), add(i->b[1], (vec){ c[0].y, c[1].y, c[2].y }),
                 add(i->b[2], (vec){ c[0].z, c[1].z, c[2].z }) }, p[3];
    for (int k = 0; k < 3; k++)              /* J stays symmetric, so the terms of b before and after the shift may be averaged */
        p[k] = cross(d, add(i->b[k], b[k]));
    to->j[0] += i->j[0] + p[0].x, to->j[1] += i->j[1] + p[1].y, to->j[2] += i->j[2] + p[2].z;
    to->j[3] += i->j[3] + 0.5*(p[0].y + p[1].x), to->j[4] += i->j[4] + 0.5*(p[0].z + p[2].x);
    to->j[5] += i->j[5] + 0.5*(p[1].z + p[2].y);
    if (first) {
        for (int k = 0; k < 3; k++)
            to->b[k] = b[k], to->m[k] = mass + m[k], to->m[k + 3] = m[k + 3];
        return;
    }
    for (int k = 0; k < 3; k++)
        to->b[k] = add(to->b[k], b[k]);
    for (int k = 0; k < 6; k++)
        to->m[k] += m[k];
}

LW_INLINE articulated with_shifted(const articulated *own, double mass, const articulated *i, vec d)
{
    articulated to;
    for (int k = 0; k < 6; k++)
        to.j[k] = own->j[k];
    add_shifted(&to, true, mass, i, d);
    return to;
}

/* ---- loops --------------------------------------------------------------------------------------------------- */

typedef struct ends { vec arm[2], d, dd, rest; } ends;       /* of a joint: as in mbs/space/space_rows.c */

LW_INLINE ends ends_of(const lw_stage_loop *p, const body *all)
{
    ends n;
    for (int k = 0; k < 2; k++) {
        const body *b = &all[p->body[k]];
        vec arm = n.arm[k] = turned(b, p->arm[k]), turn = cross(b->velocity.turn, arm), at = add(b->at, arm);
        vec v = add(b->velocity.move, turn), rest = cross(b->velocity.turn, turn);
        n.d = k ? sub(at, n.d) : at, n.dd = k ? sub(v, n.dd) : v, n.rest = k ? sub(rest, n.rest) : rest;
    }
    return n;
}

typedef struct pulls { screw on[2]; pack goal; } pulls;      /* a row, and what it has to be times the accelerations */
_Static_assert(sizeof(pulls) == LW_TREE_PULL_PACKS*sizeof(pack), "size of a row");

/* A row on body k, 0 or 1. */
LW_INLINE screw pull_of(const lw_stage_row *p, const int k, const ends *n, const body *b0, const body *b1)
{
    if (p->kind == LW_STAGE_TURN) {
        vec c = cross(turned(b0, p->a), turned(b1, p->b));
        return (screw){ k ? minus(c) : c, none };
    }
    bool line = p->kind == LW_STAGE_LINE;
    vec a = line ? turned(b0, p->a) : fixed(p->a);
    return k ? (screw){ cross(n->arm[1], a), a } : (screw){ cross(a, line ? add(n->d, n->arm[0]) : n->arm[0]), minus(a) };
}

static pulls pulls_of(const lw_stage_row *p, const ends *n, const body *b0, const body *b1)
{
    const screw on0 = pull_of(p, 0, n, b0, b1), on1 = pull_of(p, 1, n, b0, b1);
    vec w0 = b0->velocity.turn, w1 = b1->velocity.turn;
    if (p->kind == LW_STAGE_TURN) {
        vec a = turned(b0, p->a), b = turned(b1, p->b), da = cross(w0, a), db = cross(w1, b);
        return (pulls){ { on0, on1 }, dot(sub(w1, w0), add(cross(da, b), cross(a, db))) };
    }
    vec a = on1.move;
    pack bends = dot(a, n->rest);
    if (p->kind == LW_STAGE_LINE) {
        vec da = cross(w0, a);
        bends += dot(cross(w0, da), n->d) + 2*dot(da, n->dd);
    }
    return (pulls){ { on0, on1 }, -bends };
}

/* By how much a row and its rate are off. */
typedef struct misfit { pack place, rate; } misfit;

LW_INLINE misfit misfit_of(const lw_stage_row *p, const ends *n, const body *b0, const body *b1)
{
    vec w0 = b0->velocity.turn, w1 = b1->velocity.turn, a = p->kind == LW_STAGE_POINT ? fixed(p->a) : turned(b0, p->a), da = cross(w0, a);
    if (p->kind == LW_STAGE_TURN) {
        vec b = turned(b1, p->b);
        return (misfit){ dot(a, b) - p->fixed, dot(da, b) + dot(a, cross(w1, b)) };
    }
    pack speed = dot(a, n->dd);
    return (misfit){ dot(a, n->d), p->kind == LW_STAGE_LINE ? speed + dot(da, n->d) : speed };
}

/* Rows of Y, at most ROWS of one loop: what their pulls g leave at each rate, going inwards.  Rows side by side hide that the next rate
 * waits for this one; n_row is a constant where this is inlined. */
enum { ROWS = 3 };
LW_INLINE void halve_along(const lw_tree_stages *t, const int n_row, int n, const int *path, const body *all, const rate *rates, screw *g,
                           pack *const *y)
{
    for (int i = 0; i < n; i++) {
        const lw_stage_body *b = &t->body[path[i]];
        for (const rate *r = rates + b->u + b->n_u - 1; r >= rates + b->u; r--)
            for (int k = 0; k < n_row; k++) {
                pack s = y[k][r - rates] = dot_screw(r->axis, g[k]);
                g[k] = add_screw(g[k], times_screw(r->push, -s*r->by_inertia));
            }
        for (int k = 0; k < n_row; k++)
            g[k].turn = add(g[k].turn, cross(all[path[i]].from_parent, g[k].move));
    }
}

typedef struct ways { const screw *on[2][ROWS]; pack *y[ROWS]; } ways;      /* pulls of rows on the sides of a loop, and their Y */

/* side: of the loop, -1: both */
LW_INLINE void halve_rows(const lw_tree_stages *t, const lw_stage_loop *p, int side, const int n_row, const ways *w, int first, const body *all,
                          const rate *rates)
{
    screw g[2][ROWS];
    const int *path = p->path;
    pack *const *y = w->y + first;
    for (int k = 0; k < 2; path += p->n_path[k++]) {
        if (side == 1 - k)
            continue;
        for (int i = 0; i < n_row; i++)
            g[k][i] = *w->on[k][first + i];
        halve_along(t, n_row, p->n_path[k], path, all, rates, g[k], y);
    }
    if (side >= 0 || p->n_path[2] == 0)
        return;
    for (int i = 0; i < n_row; i++)
        g[0][i] = add_screw(g[0][i], g[1][i]);
    halve_along(t, n_row, p->n_path[2], path, all, rates, g[0], y);
}

static void halve(const lw_tree_stages *t, const lw_stage_loop *p, int side, int n_row, const ways *w, const body *all, const rate *rates)
{
    if (n_row == ROWS)
        halve_rows(t, p, side, ROWS, w, 0, all, rates);
    else
        for (int i = 0; i < n_row; i++)
            halve_rows(t, p, side, 1, w, i, all, rates);
}

/* The factors U^T D^-1 U of m (n x n) from row and column `from` on, of which the upper triangle is given: U, and on the diagonal D^-1.
 * Returns the least pivot over the first, 0 if that is none. */
static double factor_rows(int from, int n, pack *m)
{
    const pack first = m[from*n + from];
    pack least = first;
    mask singular = { 0 };
    for (int k = from; k < n; k++) {
        pack *u = m + k*n, d = u[k];
        singular |= ~(mask)(d > no_pivot*first);
        least = choose((mask)(d < least), d, least);
        u[k] = 1/d;
        for (int i = k + 1; i < n; i++) {
            pack by = u[i]*u[k], *to = m + i*n;
            for (int j = i; j < n; j++)
                to[j] -= by*u[j];
        }
    }
    return any_lane(singular) ? 0 : least_lane(least/first);
}

/* l by these factors */
static void solve_rows(int from, int n, const pack *m, pack *l)
{
    for (int k = from; k < n; k++)
        for (int i = k + 1; i < n; i++)
            l[i] -= m[k*n + i]*m[k*n + k]*l[k];
    for (int i = n - 1; i >= from; i--) {
        pack sum = l[i];
        for (int j = i + 1; j < n; j++)
            sum -= m[i*n + j]*l[j];
        l[i] = sum*m[i*n + i];
    }
}

/* The kept rows.  Y, the factors and l stay for calls that go on from them. */
typedef struct kept_rows {
    pack *y, *product, *l, *off;             /* Y (n x n_u); Y D Y^T, then its factors (n x n); multipliers; what l changes by */
    pulls *row;                              /* (n) */
    screw *carried;                          /* (n) of legs: their pulls on the body that they carry, less those of the rows before */
} kept_rows;

static void place_rows(const lw_tree_stages *t, const body *all, kept_rows *z)
{
    for (const lw_stage_loop *p = t->loop; p < t->loop + t->n_loop; p++) {
        ends e = ends_of(p, all);
        for (int i = 0; i < p->n_row; i++) {
            int at = p->row[i].at;
            if (at < 0)
                continue;
            z->row[at] = pulls_of(&p->row[i], &e, &all[p->body[0]], &all[p->body[1]]);
        }
    }
}

/* The forces of the multipliers that the rows have, as loads. */
static void load_rows(const lw_tree_stages *t, body *all, const kept_rows *z)
{
    for (const lw_stage_loop *p = t->loop; p < t->loop + t->n_loop; p++)
        for (int i = 0; i < p->n_row; i++)
            for (int k = 0; k < 2 && p->row[i].at >= 0; k++) {
                screw *load = &all[p->body[k]].load;
                *load = add_screw(*load, times_screw(z->row[p->row[i].at].on[k], z->l[p->row[i].at]));
            }
}

/* Y of the rows of a loop along a side, -1: both.  Where a leg ends at the other side, this is of the rows that the leg leaves. */
static void fill_rows(const lw_tree_stages *t, const lw_stage_loop *p, int side, const body *all, const rate *rates, kept_rows *z)
{
    const bool left = p->apart >= 0 && side != p->side;
    ways w;
    int n = 0;
    for (int i = 0; i < p->n_row; i++) {
        int at = p->row[i].at;
        if (at < (left ? t->n_apart : 0))
            continue;
        for (int k = 0; k < 2; k++)
            w.on[k][n] = left ? &z->carried[at] : &z->row[at].on[k];
        w.y[n++] = z->y + at*t->n_u;
        if (n == ROWS)
            halve(t, p, side, n, &w, all, rates), n = 0;
    }
    halve(t, p, side, n, &w, all, rates);
}

typedef unsigned long long rate_set;

/* Rows i and j of Y D Y^T, in the rates of a set. */
LW_INLINE pack product_of(const lw_tree_stages *t, const rate *rates, const kept_rows *z, int i, int j, rate_set set)
{
    pack sum = { 0 };
    for (; set; set &= set - 1) {
        int k = __builtin_ctzll(set);
        sum += z->y[i*t->n_u + k]*rates[k].by_inertia*z->y[j*t->n_u + k];
    }
    return sum;
}

/* Y times the free rates of a set. */
LW_INLINE pack free_along(const lw_tree_stages *t, const rate *rates, const kept_rows *z, int i, rate_set set)
{
    pack sum = { 0 };
    for (; set; set &= set - 1) {
        int k = __builtin_ctzll(set);
        sum += z->y[i*t->n_u + k]*rates[k].free;
    }
    return sum;
}

/* How far the trial accelerations are from the goal of a row. */
LW_INLINE pack miss(const lw_tree_stages *t, const body *all, const kept_rows *z, int i)
{
    const int *on = t->loop[t->kept[i].loop].body;
    return dot_screw(z->row[i].on[0], all[on[0]].trial) + dot_screw(z->row[i].on[1], all[on[1]].trial) - z->row[i].goal;
}

/* The change of a multiplier, in z->off, changes the free rates of a set. */
LW_INLINE void hold_rates(const lw_tree_stages *t, rate *rates, const kept_rows *z, int i, rate_set set)
{
    for (; set; set &= set - 1) {
        int k = __builtin_ctzll(set);
        rates[k].free -= z->y[i*t->n_u + k]*z->off[i]*rates[k].by_inertia;
    }
}

/* ---- legs: rows that hold their rates, l = (Y D Y^T)^-1 (off + P a), a: acceleration of the body that they carry ---- */

/* Row i of a leg; those that it leaves to all loops come last. */
LW_INLINE int leg_row(const lw_stage_leg *g, int i) { return i < g->n_row ? g->row + i : g->left + i - g->n_row; }

/* The factors of a leg, which adds P^T (Y D Y^T)^-1 P to the inertia of the body that it carries.  Returns the least pivot over the first. */
LW_INLINE double factor_leg(const lw_tree_stages *t, const lw_stage_leg *g, body *all, const rate *rates, kept_rows *z)
{
    const int n = g->n_row + g->n_left;
    pack first = { 0 }, least = first;
    for (int a = 0; a < n; a++) {
        const int i = leg_row(g, a), side = t->loop[t->kept[i].loop].side;
        z->carried[i] = side < 0 ? (screw){ none, none } : z->row[i].on[1 - side];
        for (int b = 0; b <= a && b < g->n_row; b++) {
            const int k = g->row + b;
            pack *m = &z->product[k*t->n_kept + i];
            *m = product_of(t, rates, z, k, i, t->kept[k].own & t->kept[i].own);
            for (int c = g->row; c < k; c++)
                *m -= z->product[c*t->n_kept + k]*z->product[c*t->n_kept + c]*z->product[c*t->n_kept + i];
        }
        for (int k = g->row; k < i && k < g->row + g->n_row; k++)
            z->carried[i] = add_screw(z->carried[i], times_screw(z->carried[k], -z->product[k*t->n_kept + i]*z->product[k*t->n_kept + k]));
        if (a >= g->n_row)
            continue;
        pack *d = &z->product[i*t->n_kept + i];
        first = a ? first : *d, least = a ? choose((mask)(*d < least), *d, least) : *d;
        *d = 1/ *d;
        if (g->carries >= 0)
            take_away(&all[g->carries].inertia, z->carried[i], -*d);
    }
    return least_lane(least/first);
}

/* The load of a leg on the body that it carries. */
LW_INLINE void load_leg(const lw_tree_stages *t, const lw_stage_leg *g, body *all, const rate *rates, kept_rows *z)
{
    for (int a = 0; a < g->n_row + g->n_left; a++) {
        const int i = leg_row(g, a);
        z->off[i] = miss(t, all, z, i) + free_along(t, rates, z, i, t->kept[i].own);
        for (int k = g->row; k < i && k < g->row + g->n_row; k++)
            z->off[i] -= z->product[k*t->n_kept + i]*z->product[k*t->n_kept + k]*z->off[k];
        if (a >= g->n_row || g->carries < 0)
            continue;
        screw *load = &all[g->carries].load;
        *load = add_screw(*load, times_screw(z->carried[i], z->product[i*t->n_kept + i]*z->off[i]));
    }
}

/* The multipliers of a leg, when the acceleration of the body that it carries is known, and what they change its free rates by. */
LW_INLINE void hold_leg(const lw_tree_stages *t, const bool again, const lw_stage_leg *g, const body *all, rate *rates, kept_rows *z)
{
    for (int a = g->n_row + g->n_left - 1; a >= 0; a--) {
        const int i = leg_row(g, a);
        if (a < g->n_row) {
            pack sum = z->off[i];
            if (g->carries >= 0)
                sum += dot_screw(z->carried[i], all[g->carries].load);
            for (int b = a + 1; b < g->n_row + g->n_left; b++)
                sum -= z->product[i*t->n_kept + leg_row(g, b)]*z->off[leg_row(g, b)];
            z->off[i] = sum*z->product[i*t->n_kept + i];
            z->l[i] = again ? z->l[i] + z->off[i] : z->off[i];
        }
        hold_rates(t, rates, z, i, t->kept[i].own);
    }
}

/* ---- loops that are not of legs, and what legs leave --------------------------------------------------------------- */

/* The upper triangle of Y D Y^T, and its factors.  Returns the least pivot over the first. */
static double factor_loops(const lw_tree_stages *t, const body *all, const rate *rates, kept_rows *z)
{
    for (const lw_stage_loop *p = t->loop; p < t->loop + t->n_loop; p++)
        if (p->apart < 0)
            fill_rows(t, p, -1, all, rates, z);
        else if (p->side >= 0)
            fill_rows(t, p, 1 - p->side, all, rates, z);
    for (int i = t->n_apart; i < t->n_kept; i++) {
        const pack *y = z->y + i*t->n_u;
        pack scaled[LW_STAGE_RATES];
        for (rate_set left = t->kept[i].rates; left; left &= left - 1) {
            int k = __builtin_ctzll(left);
            scaled[k] = y[k]*rates[k].by_inertia;
        }
        for (int j = i; j < t->n_kept; j++) {
            pack sum = { 0 };
            for (rate_set both = t->kept[i].rates & t->kept[j].rates; both; both &= both - 1) {
                int k = __builtin_ctzll(both);
                sum += scaled[k]*z->y[j*t->n_u + k];
            }
            z->product[i*t->n_kept + j] = sum;
        }
    }
    return factor_rows(t->n_apart, t->n_kept, z->product);
}

/* Change the rates that are free by what the kept rows add.  Returns the least pivot, as factor_rows does; 1 where the factors are kept. */
static double hold_loops(const lw_tree_stages *t, bool again, const body *all, rate *rates, kept_rows *z)
{
    double weak = again ? 1 : factor_loops(t, all, rates, z);
    for (int i = t->n_apart; i < t->n_kept; i++)
        z->off[i] = (t->loop[t->kept[i].loop].apart < 0 ? miss(t, all, z, i) : z->off[i]) + free_along(t, rates, z, i, t->kept[i].rates);
    solve_rows(t->n_apart, t->n_kept, z->product, z->off);
    for (int i = t->n_apart; i < t->n_kept; i++) {
        z->l[i] = again ? z->l[i] + z->off[i] : z->off[i];
        hold_rates(t, rates, z, i, t->kept[i].rates);
    }
    return weak;
}

/* ---- all of it ------------------------------------------------------------------------------------------------- */

static void place_ground(body *ground)       /* its inertia and its place from a parent are not used */
{
    ground->turn = (quat){ .w = all_lanes(1) };
    set_rows(ground);
    ground->at = none;
    ground->velocity = ground->trial = ground->load = (screw){ none, none };
}

/* Factors of the masses, again: those of an earlier call, and the rates that are free under the loads, for bodies from `at` to `end`, inwards.
 * What a chain passes on to its next body goes through no memory.  False: a motion without mass. */
LW_INLINE bool go_inwards(const lw_tree_stages *t, const bool again, const int *at, const int *end, pack *greatest, body *all, rate *rates)
{
    mask massless = { 0 };
    pack most = *greatest;
    articulated inertia;
    screw load = { none, none };
    for (bool passed = false; at < end; at++) {
        const lw_stage_body *p = &t->body[*at];
        const body *b = &all[*at];
        body *to = &all[p->parent];
        if (!again && !passed)
            inertia = p->leaf ? alone(&b->inertia, p->mass[0]) : b->inertia;
        if (!passed)
            load = b->load;
        passed = p->passes;
        for (rate *r = rates + p->u + p->n_u - 1; r >= rates + p->u; r--) {
            if (!again) {
                r->push = inertia_times(&inertia, r->axis);
                pack d = dot_screw(r->axis, r->push);
                most = choose((mask)(d > most), d, most);
                massless |= ~(mask)(d > no_mass*most);
                r->by_inertia = 1/d;
            }
            r->free = -dot_screw(r->axis, load)*r->by_inertia;
            load = add_screw(load, times_screw(r->push, r->free));
            if (!again)
                take_away(&inertia, r->push, r->by_inertia);
        }
        if (p->parent < 0)
            continue;
        load.turn = add(to->load.turn, add(load.turn, cross(b->from_parent, load.move)));
        load.move = add(to->load.move, load.move);
        if (!passed)
            to->load = load;
        if (!again && passed)
            inertia = with_shifted(&to->inertia, t->body[p->parent].mass[0], &inertia, b->from_parent);
        else if (!again)
            add_shifted(&to->inertia, p->last_child, t->body[p->parent].mass[0], &inertia, b->from_parent);
    }
    *greatest = most;
    return !any_lane(massless);
}

/* The least pivot of the legs over their first. */
LW_INLINE double go_through_legs(const lw_tree_stages *t, const bool again, body *all, const rate *rates, kept_rows *z)
{
    const lw_stage_leg *end = t->leg + (t->n_apart ? t->n_leg : 0);
    double weak = 1;
    for (const lw_stage_loop *p = t->loop; !again && p < t->loop + t->n_loop; p++)
        if (p->apart >= 0)
            fill_rows(t, p, p->side, all, rates, z);
    for (const lw_stage_leg *g = t->leg; !again && g < end; g++) {
        double least = factor_leg(t, g, all, rates, z);
        weak = least >= weak ? weak : least;
    }
    for (const lw_stage_leg *g = t->leg; g < end; g++)
        load_leg(t, g, all, rates, z);
    return weak;
}

/* The accelerations of the rates, added to those of the trial if they had some, for bodies from those before `at` to `end`, outwards. */
LW_INLINE void go_outwards(const lw_tree_stages *t, const bool again, const int *at, const int *end, body *all, const rate *rates, double *du)
{
    screw a = { none, none };
    for (bool first = true; at-- > end; first = false) {
        const lw_stage_body *p = &t->body[*at];
        if (first || !p->passes)             /* else that of the last body */
            a = all[p->parent].load;
        a.move = add(a.move, cross(a.turn, all[*at].from_parent));
        for (int k = p->u; k < p->u + p->n_u; k++) {
            const rate *r = &rates[k];
            pack by = r->free - dot_screw(r->push, a)*r->by_inertia;
            a = add_screw(a, times_screw(r->axis, by));
            keep(du + 8*k, again ? pick(du + 8*k) + by : by);
        }
        all[*at].load = a;
    }
}

/* The state of the lanes of a register. */
typedef struct lanes { body *all; rate *rates; kept_rows z; } lanes;

LW_INLINE lanes lanes_from(const lw_tree_stages *t, int lane)
{
    lanes s;
    s.all = (body *)(void *)((char *)t->state + (size_t)lane/WIDTH*lw_tree_state_size(WIDTH, t->n_body, t->n_u, t->n_row)) + 1;
    s.rates = (rate *)(void *)(s.all + t->n_body);       /* all[-1]: the ground */
    kept_rows *z = &s.z;
    z->row = (pulls *)(void *)(s.rates + t->n_u), z->carried = (screw *)(void *)(z->row + t->n_row), z->y = (pack *)(void *)(z->carried + t->n_row);
    z->product = z->y + t->n_row*t->n_u, z->l = z->product + t->n_row*t->n_row, z->off = z->l + t->n_row;
    return s;
}

/* Place bodies and rows; the loads that act, and those that the trial accelerations need.  y and dy begin with lane `lane`. */
LW_INLINE void load(const lw_tree_stages *t, const bool again, int lane, const double *y, double *dy, lanes *s)
{
    double *du = dy + 8*t->n_x;
    place_ground(&s->all[-1]);
    place_all(t, again, y, lane, du, s->all, s->rates);
    pack power = pull(t, s->all);
    if (t->has_work)
        keep(du + 8*t->n_u, power);
    place_rows(t, s->all, &s->z);
    if (again)
        load_rows(t, s->all, &s->z);
}

/* The accelerations that loads and goals of the rows ask for, to du; again: added to it.  Returns what rates_of returns. */
LW_INLINE double answer(const lw_tree_stages *t, const bool again, lanes *s, double *du)
{
    body *all = s->all;
    rate *rates = s->rates;
    kept_rows *z = &s->z;
    const int *trunk = t->order + t->n_hanging, *end = t->order + t->n_body;
    pack most = { 0 };
    if (!go_inwards(t, again, t->order, trunk, &most, all, rates))
        return 0;
    double weak = go_through_legs(t, again, all, rates, z);
    if (!(weak > weak_leg))
        return -1;
    if (!go_inwards(t, again, trunk, end, &most, all, rates))
        return 0;
    if (t->n_kept > t->n_apart) {
        double loops = hold_loops(t, again, all, rates, z);
        weak = loops < weak ? loops : weak;
    }
    all[-1].load = (screw){ none, none };
    go_outwards(t, again, end, trunk, all, rates, du);
    for (const lw_stage_leg *g = t->leg; g < t->leg + (t->n_apart ? t->n_leg : 0); g++)
        hold_leg(t, again, g, all, rates, z);
    go_outwards(t, again, trunk, t->order, all, rates, du);
    return weak;
}

static double answer_anew(const lw_tree_stages *t, lanes *s, double *du) { return answer(t, false, s, du); }
static double answer_again(const lw_tree_stages *t, lanes *s, double *du) { return answer(t, true, s, du); }

LW_INLINE double rates_of_some(const lw_tree_stages *t, const bool again, int lane, const double *y, double *dy)
{
    lanes s = lanes_from(t, lane);
    load(t, again, lane, y, dy, &s);
    return again ? answer_again(t, &s, dy + 8*t->n_x) : answer_anew(t, &s, dy + 8*t->n_x);
}

static double rates_of(const lw_tree_stages *t, bool again, const double *y, double *dy)
{
    double weak = 1;
    for (int lane = 0; lane < 8; lane += WIDTH) {
        double here = again ? rates_of_some(t, true, lane, y + lane, dy + lane) : rates_of_some(t, false, lane, y + lane, dy + lane);
        weak = here < weak ? here : weak;
    }
    return weak;
}

/* At most how far a body's coordinates and those of all bodies inwards have moved since they were factored, summed: the farthest body of each ring. */
LW_INLINE pack farthest(const lw_tree_stages *t, int lane, const double *y)
{
    pack far = { 0 }, ring = { 0 };
    for (int i = 0, first = 0; i < t->n_body; i++) {
        const lw_stage_body *p = &t->body[i];
        pack own = { 0 };
        if (p->parent >= first)              /* one ring farther out */
            far += ring, ring = all_lanes(0), first = i;
        for (int k = 8*p->x; k < 8*(p->x + p->n_x); k += 8) {
            pack off = pick(y + k) - pick(t->factored + lane + k);
            own += choose((mask)(off < 0), -off, off);
        }
        ring = choose((mask)(own > ring), own, ring);
    }
    return far + ring;
}

static double prepare(const lw_tree_stages *t, bool again, const double *y)
{
    double far = 0;
    for (int i = 0; i < t->n_angle; i++)
        for (int k = 0; k < 8; k += WIDTH)
            keep(t->angle + 8*i + k, 0.5*pick(y + 8*t->turn[i] + k));
    for (int lane = 0; again && lane < 8; lane += WIDTH) {
        double here = -least_lane(-farthest(t, lane, y + lane));
        far = here > far ? here : far;
    }
    return far;
}

/* ---- rows of output ------------------------------------------------------------------------------------------------- */

/* The greater of a and the size of b.  The bits of sizes, as integers, are in the order of the sizes, and those of what is no number are greater. */
LW_INLINE pack greater(pack a, pack b)
{
    const mask size = (mask)b & 0x7fffffffffffffff;
    return choose(size > (mask)a, (pack)size, a);
}

static double close_some(const lw_tree_stages *t, const bool again, bool speeds, int lane, const double *y, double *du)
{
    lanes s = lanes_from(t, lane);
    pack off = { 0 };
    place_ground(&s.all[-1]);
    place_all(t, again, y, lane, du, s.all, s.rates);
    place_rows(t, s.all, &s.z);
    for (body *b = s.all; b < s.all + t->n_body; b++) {
        b->load = (screw){ none, none };
        b->trial = speeds ? b->velocity : b->load;
    }
    for (const lw_stage_loop *p = t->loop; p < t->loop + t->n_loop; p++) {
        const body *b0 = &s.all[p->body[0]], *b1 = &s.all[p->body[1]];
        ends e = ends_of(p, s.all);
        for (int i = 0; i < p->n_row; i++) {
            const int at = p->row[i].at;
            s.z.row[at].goal = speeds ? none.x : -misfit_of(&p->row[i], &e, b0, b1).place;
            off = greater(off, miss(t, s.all, &s.z, at));
        }
    }
    double weak = again ? answer_again(t, &s, du) : answer_anew(t, &s, du);
    return weak > 0 ? -least_lane(-off) : INFINITY;
}

static double close_loops(const lw_tree_stages *t, bool again, bool speeds, const double *y, double *du)
{
    double most = 0;
    for (int lane = 0; lane < 8; lane += WIDTH) {
        double here = close_some(t, again, speeds, lane, y + lane, du + lane);
        most = here <= most ? most : here;
    }
    return most;
}

/* Multipliers of the rows of a joint of the tree that put this load on a body.  Rows with a force have forces of length 1 at right angles to
 * each other; at most three others are moments alone. */
LW_INLINE void multipliers(const lw_stage_loop *p, const screw *pull, screw load, pack *l)
{
    vec turn[3] = { none, none, none }, moment = load.turn;
    int turns = 0, at[3];
    for (int i = 0; i < p->n_row; i++) {
        if (p->row[i].kind == LW_STAGE_TURN)
            at[turns] = i, turn[turns++] = pull[i].turn;
        else
            l[i] = dot(pull[i].move, load.move), moment = sub(moment, times(pull[i].turn, l[i]));
    }
    if (turns == 0)
        return;
    if (turns == 1) {
        l[at[0]] = dot(turn[0], moment)/dot(turn[0], turn[0]);
        return;
    }
    if (turns == 2)
        turn[2] = cross(turn[0], turn[1]);
    pack by = 1/dot(turn[0], cross(turn[1], turn[2]));
    for (int i = 0; i < turns; i++)
        l[at[i]] = by*dot(moment, cross(turn[(i + 1)%3], turn[(i + 2)%3]));
}

/* One number of n moments, and three. */
LW_INLINE void give(const lw_tree_stages *t, int n, pack v, double *to)
{
    to[0] = v[0];                            /* often all */
    for (int k = 1; k < n; k++)
        to[k*t->n_moment] = v[k];
}
LW_INLINE void give_three(const lw_tree_stages *t, int n, vec v, double *to)
{
    give(t, n, v.x, to), give(t, n, v.y, to + 1), give(t, n, v.z, to + 2);
}

LW_INLINE misfit greatest_misfit(const lw_stage_loop *p, const ends *e, const body *all, misfit m)
{
    for (int i = 0; i < p->n_row; i++) {
        misfit here = misfit_of(&p->row[i], e, &all[p->body[0]], &all[p->body[1]]);
        m = (misfit){ greater(m.place, here.place), greater(m.rate, here.rate) };
    }
    return m;
}

/* After answer_anew: the accelerations of the bodies to their trial; what these leave of the loads, which is what the joints of the tree carry. */
LW_INLINE void carry(const lw_tree_stages *t, lanes *s)
{
    for (int i = 0; i < t->n_body; i++) {
        body *b = &s->all[i];
        b->trial = add_screw(b->trial, b->load);
        weigh(&t->body[i], false, b);
    }
    pull(t, s->all);
    load_rows(t, s->all, &s->z);
}

static void moments_of_some(const lw_tree_stages *t, int lane, int n, double *out)
{
    lanes s = lanes_from(t, lane);
    body *all = s.all;
    double *q = out, *v = q + 7*t->n_body, *a = v + 6*t->n_body, *l = a + 6*t->n_body, *rest = l + t->n_model_row;
    misfit off = { { 0 }, { 0 } };
    carry(t, &s);
    for (const lw_stage_loop *p = t->loop; p < t->loop + t->n_loop; p++) {
        ends e = ends_of(p, all);
        for (int i = 0; i < p->n_row; i++)
            give(t, n, s.z.l[p->row[i].at], l + p->first + i);
        off = greatest_misfit(p, &e, all, off);
    }
    for (const int *at = t->order; at < t->order + t->n_body; at++) {
        const body *b = &all[*at];
        const lw_stage_body *p = &t->body[*at];
        const lw_stage_loop *j = &t->inner[*at];
        const body *b0 = &all[j->body[0]], *b1 = &all[j->body[1]];
        screw pull[6];
        pack force[6];
        ends e = ends_of(j, all);
        for (int i = 0; i < j->n_row; i++)
            pull[i] = p->back ? pull_of(&j->row[i], 0, &e, b0, b1) : pull_of(&j->row[i], 1, &e, b0, b1);
        multipliers(j, pull, times_screw(b->load, all_lanes(-1)), force);
        for (int i = 0; i < j->n_row; i++)
            give(t, n, force[i], l + j->first + i);
        off = greatest_misfit(j, &e, all, off);
        screw *to = &all[p->parent].load;
        to->turn = add(to->turn, add(b->load.turn, cross(b->from_parent, b->load.move)));
        to->move = add(to->move, b->load.move);
        double *place = q + 7*p->body, *speed = v + 6*p->body, *bend = a + 6*p->body;
        give_three(t, n, b->at, place);
        give(t, n, b->turn.w, place + 3), give_three(t, n, (vec){ b->turn.x, b->turn.y, b->turn.z }, place + 4);
        give_three(t, n, b->velocity.move, speed), give_three(t, n, to_own(b, b->velocity.turn), speed + 3);
        give_three(t, n, b->trial.move, bend), give_three(t, n, to_own(b, b->trial.turn), bend + 3);
    }
    give(t, n, off.place, rest), give(t, n, off.rate, rest + 1);
}

static void moments(const lw_tree_stages *t, int n, double *out)
{
    for (int lane = 0; lane < n; lane += WIDTH)
        moments_of_some(t, lane, n - lane < WIDTH ? n - lane : WIDTH, out + lane*t->n_moment);
}

const lw_tree_kernel lw_tree_kernel_here = { LW_ISA_NAME, WIDTH, prepare, rates_of, close_loops, moments };

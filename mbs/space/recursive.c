/* mbs/space/recursive.c - a spatial model in the coordinates of its joints: tree, motion outwards, inertias inwards. */
#include "mbs/space/recursive.h"

#include <stdlib.h>
#include <string.h>
#include "base/union_find.h"
#include "base/vector.h"

static const double no_mass = 1e-13;         /* inertia along a rate, over the greatest: none */
static const double no_pivot = 1e-13;        /* of loops, over the greatest: singular */

/* ---- tree --------------------------------------------------------------------------------------------------- */

static int rates_of_kind(lw_spatial_kind k) { return 6 - lw_spatial_kind_of(k)->rows; }
static bool turns_by_quaternion(lw_spatial_kind k) { return k == LW_SPATIAL_SPHERICAL || k == LW_SPATIAL_FREE; }

static lw_status reserve(const lw_space *s, lw_recursive *r, lw_error *e)
{
    size_t b = (size_t)s->n_body, rows = (size_t)r->n_row, u = (size_t)r->n_u, joints = (size_t)s->n_joint + 1, sides = (size_t)s->n_side;
    size_t doubles = 3*u + rows*u + rows*rows + 2*rows + 6*rows*sides;
    size_t bytes = (b + 1)*sizeof *r->body + (2*u + b + rows*sides)*sizeof *r->axis + rows*sizeof *r->row + (b + 1)*sizeof *r->frame
                 + doubles*sizeof(double) + (joints + b + rows + (rows + 1)*sides)*sizeof(int);
    char *at = r->memory = calloc(1, bytes);
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    r->body = (lw_recursive_body *)(void *)at + 1, at += (b + 1)*sizeof *r->body;
    r->body[-1] = (lw_recursive_body){ .axes = { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } }, .turn = { 1, 0, 0, 0 } };
    r->axis = (lw_screw *)(void *)at, at += u*sizeof *r->axis;
    r->push = (lw_screw *)(void *)at, at += u*sizeof *r->push;
    r->pull = (lw_screw *)(void *)at, at += b*sizeof *r->pull;
    lw_screw *pull = (lw_screw *)(void *)at;
    at += rows*sides*sizeof *pull;
    r->row = (lw_recursive_row *)(void *)at, at += rows*sizeof *r->row;
    r->frame = (lw_space_frame *)(void *)at, at += (b + 1)*sizeof *r->frame;
    r->by_inertia = (double *)(void *)at, at += u*sizeof(double);
    r->free_rate = (double *)(void *)at, at += u*sizeof(double);
    r->along = (double *)(void *)at, at += u*sizeof(double);
    r->half = (double *)(void *)at, at += rows*u*sizeof(double);
    r->schur = (double *)(void *)at, at += rows*rows*sizeof(double);
    r->l = (double *)(void *)at, at += rows*sizeof(double);
    r->sorted = (double *)(void *)at, at += rows*sizeof(double);
    double *jac = (double *)(void *)at;
    at += 6*rows*sides*sizeof *jac;
    r->cut = (int *)(void *)at, at += joints*sizeof(int);
    r->place = (int *)(void *)at, at += b*sizeof(int);
    r->order = (int *)(void *)at, at += rows*sizeof(int);
    r->side = (int *)(void *)at, at += sides*sizeof(int);
    for (size_t i = 0; i < rows; i++)
        r->row[i] = (lw_recursive_row){ .body = (int *)(void *)at + i*sides, .jac = jac + 6*i*sides, .pull = pull + i*sides };
    return LW_OK;
}

static void put_body(lw_recursive *r, int n, int body, int parent, int joint, bool back)
{
    const lw_space *s = r->s;
    lw_recursive_body *p = &r->body[n];
    const lw_space_joint *j = joint < 0 ? NULL : &s->joint[joint];
    *p = (lw_recursive_body){ .body = body, .parent = parent, .joint = joint, .back = back, .x = r->n_x, .u = r->n_u,
                              .kind = j ? j->kind : LW_SPATIAL_FREE, .fixed = { 1, 0, 0, 0 } };
    p->n_u = rates_of_kind(p->kind);
    r->place[body] = n;
    r->n_x += p->n_u + turns_by_quaternion(p->kind);
    r->n_u += p->n_u;
    if (!j) {
        p->fixed = (lw_quaternion){ 1, 0, 0, 0 };
        return;
    }
    lw_quaternion own[2];
    for (int k = 0; k < 2; k++) {
        own[k] = j->body[k] < 0 ? (lw_quaternion){ 1, 0, 0, 0 } : s->axes[j->body[k]];
        p->arm[k] = lw_v3_scale(j->arm[k], 1/s->unit);
    }
    p->fixed = lw_quaternion_times(lw_quaternion_inverse(own[0]), own[1]);
}

/* The joints of the tree: those with the most rows that join bodies not yet joined.  above: scratch (n_body + 1). */
static void choose_joints(const lw_space *s, lw_recursive *r, bool *kept, int *above)
{
    r->n_u = 6*s->n_body, r->n_row = s->n_coupling + r->n_extra;
    for (int b = 0; b <= s->n_body; b++)
        above[b] = b;
    for (int rows = 6; rows > 0; rows--)
        for (int j = 0; j < s->n_joint; j++) {
            const lw_space_joint *p = &s->joint[j];
            if (lw_spatial_kind_of(p->kind)->rows != rows)
                continue;
            int a = lw_root_of(above, p->body[0] + 1), b = lw_root_of(above, p->body[1] + 1);
            kept[j] = a != b;
            above[a] = b;
            *(kept[j] ? &r->n_u : &r->n_row) += kept[j] ? -rows : rows;
        }
}

/* The tree outwards from the ground, the bodies in rings.  at: zeros (n_body + 3); end: scratch (2 n_joint). */
static void grow(lw_recursive *r, const bool *kept, int *at, int *end)
{
    const lw_space *s = r->s;
    int n = 0, loose = 0;
    for (int i = 0; i < 2*s->n_joint; i++)               /* ends of kept joints by their bodies: joint i/2, side i%2 */
        if (kept[i/2])
            at[s->joint[i/2].body[i%2] + 3]++;
    for (int b = 0; b < s->n_body; b++)
        at[b + 3] += at[b + 2];
    for (int i = 0; i < 2*s->n_joint; i++)
        if (kept[i/2])
            end[at[s->joint[i/2].body[i%2] + 2]++] = i;
    r->n_x = r->n_u = 0;
    for (int b = 0; b < s->n_body; b++)
        r->place[b] = -1;
    for (int ring = -1; n < s->n_body;) {
        int before = n, from = ring < 0 ? -1 : r->body[ring].body;
        for (int i = at[from + 1]; i < at[from + 2]; i++) {
            int j = end[i]/2, k = end[i]%2, other = s->joint[j].body[1 - k];
            if (other >= 0 && r->place[other] < 0)
                put_body(r, n++, other, ring, j, k == 1);
        }
        if (n == before && ring == n - 1) {      /* a part that does not hang on the ground */
            while (r->place[loose] >= 0)
                loose++;
            put_body(r, n++, loose, -1, -1, false);
        }
        ring++;
    }
}

lw_status lw_recursive_make(const lw_space *s, const double *mass, const lw_space_extra *extra, int n_extra, lw_recursive *r,
                            lw_error *e)
{
    *r = (lw_recursive){ .s = s, .mass = mass, .extra = extra, .n_extra = n_extra, .weak = 1 };
    size_t bodies = (size_t)s->n_body, joints = (size_t)s->n_joint;
    int *above = calloc(2*bodies + 2*joints + 4, sizeof *above);
    bool *kept = calloc(joints + 1, sizeof *kept);
    lw_status st = above && kept ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        choose_joints(s, r, kept, above);
        st = reserve(s, r, e);
    }
    if (st == LW_OK)
        grow(r, kept, above + bodies + 1, above + 2*bodies + 4);
    for (int j = 0; st == LW_OK && j < s->n_joint; j++)
        if (!kept[j] && lw_spatial_kind_of(s->joint[j].kind)->rows > 0)
            r->cut[r->n_cut++] = j;
    free(above);
    free(kept);
    r->rank = r->n_row;
    return st;
}

void lw_recursive_free(lw_recursive *r)
{
    free(r->memory);
    *r = (lw_recursive){ 0 };
}

/* ---- motion --------------------------------------------------------------------------------------------------- */

static lw_quaternion about(lw_vec3 axis, double angle)
{
    double c, s;
    sincos(0.5*angle, &s, &c);
    return (lw_quaternion){ c, s*axis.x, s*axis.y, s*axis.z };
}

/* Turn of body 1 against body 0, and its joint's point against that of body 0 in the axes of body 0, at coordinates x. */
static lw_quaternion relative(const lw_recursive *r, const lw_recursive_body *p, const double *x, lw_vec3 *slide)
{
    const lw_space_joint *j = p->joint < 0 ? NULL : &r->s->joint[p->joint];
    lw_quaternion t = { 1, 0, 0, 0 };
    *slide = lw_v3(0, 0, 0);
    switch (p->kind) {
    case LW_SPATIAL_REVOLUTE: t = about(j->z[0], x[0]); break;
    case LW_SPATIAL_PRISMATIC: *slide = lw_v3_scale(j->z[0], x[0]); break;
    case LW_SPATIAL_CYLINDRICAL: t = about(j->z[0], x[0]), *slide = lw_v3_scale(j->z[0], x[1]); break;
    case LW_SPATIAL_SCREW: t = about(j->z[0], x[0]), *slide = lw_v3_scale(j->z[0], x[0]*j->pitch/r->s->unit); break;
    case LW_SPATIAL_PLANAR:
        t = about(j->z[0], x[2]), *slide = lw_v3_add(lw_v3_scale(j->x[0], x[0]), lw_v3_scale(j->y[0], x[1]));
        break;
    case LW_SPATIAL_UNIVERSAL:
        return lw_quaternion_times(lw_quaternion_times(about(j->x[0], x[0]), p->fixed), about(j->x[1], x[1]));
    case LW_SPATIAL_SPHERICAL: t = lw_quaternion_unit((lw_quaternion){ x[0], x[1], x[2], x[3] }); break;
    case LW_SPATIAL_FREE:
        *slide = lw_v3(x[0], x[1], x[2]);
        return lw_quaternion_unit((lw_quaternion){ x[3], x[4], x[5], x[6] });
    case LW_SPATIAL_FIXED: break;
    }
    return lw_quaternion_times(t, p->fixed);
}

void lw_recursive_place(lw_recursive *r, const double *x, double *q)
{
    for (int i = 0; i < r->s->n_body; i++) {
        lw_recursive_body *p = &r->body[i];
        const lw_recursive_body *b = &r->body[p->parent];
        lw_vec3 slide;
        lw_quaternion t = relative(r, p, x + p->x, &slide);
        p->turn = lw_quaternion_times(b->turn, p->back ? lw_quaternion_inverse(t) : t);
        p->axes = lw_quaternion_matrix(p->turn);
        if (p->back)
            p->from_parent = lw_v3_sub(lw_m3_apply(&b->axes, p->arm[1]), lw_m3_apply(&p->axes, lw_v3_add(p->arm[0], slide)));
        else
            p->from_parent = lw_v3_sub(lw_m3_apply(&b->axes, lw_v3_add(p->arm[0], slide)), lw_m3_apply(&p->axes, p->arm[1]));
        p->at = lw_v3_add(b->at, p->from_parent);
        double *to = q + 7*p->body;
        to[0] = p->at.x, to[1] = p->at.y, to[2] = p->at.z;
        to[3] = p->turn.w, to[4] = p->turn.x, to[5] = p->turn.y, to[6] = p->turn.z;
    }
}

static lw_vec3 along_axes(const lw_mat3 *m, const double *u)
{
    return lw_m3_apply(m, lw_v3(u[0], u[1], u[2]));
}

/* The motions of body 1 against body 0: turns about `turn`, slides along `slide`, in ground axes; how many. */
typedef struct freedom { lw_vec3 turn, slide; } freedom;

static void freedoms(const lw_recursive *r, const lw_recursive_body *p, const lw_mat3 *axes0, const lw_mat3 *axes1, freedom *f)
{
    const lw_space_joint *j = p->joint < 0 ? NULL : &r->s->joint[p->joint];
    lw_vec3 none = lw_v3(0, 0, 0), z = j ? lw_m3_apply(axes0, j->z[0]) : none;
    switch (p->kind) {
    case LW_SPATIAL_REVOLUTE: f[0] = (freedom){ z, none }; break;
    case LW_SPATIAL_PRISMATIC: f[0] = (freedom){ none, z }; break;
    case LW_SPATIAL_CYLINDRICAL: f[0] = (freedom){ z, none }, f[1] = (freedom){ none, z }; break;
    case LW_SPATIAL_SCREW: f[0] = (freedom){ z, lw_v3_scale(z, j->pitch/r->s->unit) }; break;
    case LW_SPATIAL_PLANAR:
        f[0] = (freedom){ none, lw_m3_apply(axes0, j->x[0]) }, f[1] = (freedom){ none, lw_m3_apply(axes0, j->y[0]) };
        f[2] = (freedom){ z, none };
        break;
    case LW_SPATIAL_UNIVERSAL:
        f[0] = (freedom){ lw_m3_apply(axes0, j->x[0]), none }, f[1] = (freedom){ lw_m3_apply(axes1, j->x[1]), none };
        break;
    case LW_SPATIAL_SPHERICAL: case LW_SPATIAL_FREE:
        for (int k = 0, n = p->kind == LW_SPATIAL_FREE ? 3 : 0; k < n + 3; k++) {
            lw_vec3 c = lw_m3_column(axes0, k%3);
            f[k] = k < n ? (freedom){ none, c } : (freedom){ c, none };
        }
        break;
    case LW_SPATIAL_FIXED: break;
    }
}

void lw_recursive_velocities(lw_recursive *r, const double *u, double *v)
{
    for (int i = 0; i < r->s->n_body; i++) {
        lw_recursive_body *p = &r->body[i];
        const lw_recursive_body *b = &r->body[p->parent];
        const lw_mat3 *axes0 = p->back ? &p->axes : &b->axes, *axes1 = p->back ? &b->axes : &p->axes;
        freedom f[6];
        freedoms(r, p, axes0, axes1, f);
        lw_vec3 e1 = lw_m3_apply(axes1, p->arm[1]), turn = lw_v3(0, 0, 0), slide = turn, twist = turn;
        lw_vec3 e0 = p->back ? lw_v3_sub(e1, p->from_parent) : lw_v3_add(e1, p->from_parent);
        double sign = p->back ? -1 : 1;
        for (int k = 0; k < p->n_u; k++) {
            double rate = u[p->u + k];
            turn = lw_v3_add(turn, lw_v3_scale(f[k].turn, rate));
            slide = lw_v3_add(slide, lw_v3_scale(f[k].slide, rate));
            lw_vec3 arm = lw_v3_cross(f[k].turn, p->back ? e0 : e1);       /* from the centre to the joint's point */
            r->axis[p->u + k] = (lw_screw){ lw_v3_scale(f[k].turn, sign), lw_v3_scale(lw_v3_sub(f[k].slide, arm), sign) };
        }
        lw_screw w = b->velocity, *to = &p->velocity;
        to->turn = lw_v3_add(w.turn, lw_v3_scale(turn, sign));
        lw_vec3 w0 = p->back ? to->turn : w.turn, w1 = p->back ? w.turn : to->turn;
        lw_vec3 c0 = lw_v3_cross(w0, e0), c1 = lw_v3_cross(w1, e1), change = lw_v3_sub(lw_v3_add(c0, slide), c1);
        to->move = lw_v3_add(w.move, lw_v3_scale(change, sign));
        if (p->kind == LW_SPATIAL_UNIVERSAL)
            twist = lw_v3_add(lw_v3_cross(w0, lw_v3_scale(f[0].turn, u[p->u])), lw_v3_cross(w1, lw_v3_scale(f[1].turn, u[p->u + 1])));
        else
            twist = lw_v3_cross(w0, turn);
        lw_vec3 rest = lw_v3_add(lw_v3_sub(lw_v3_cross(w0, c0), lw_v3_cross(w1, c1)), lw_v3_scale(lw_v3_cross(w0, slide), 2));
        rest = lw_v3_sub(rest, lw_v3_cross(twist, p->back ? e0 : e1));
        p->bias = (lw_screw){ lw_v3_scale(twist, sign), lw_v3_scale(rest, sign) };
        lw_vec3 own = lw_m3_unapply(&p->axes, to->turn);
        double *out = v + 6*p->body;
        out[0] = to->move.x, out[1] = to->move.y, out[2] = to->move.z, out[3] = own.x, out[4] = own.y, out[5] = own.z;
    }
}

void lw_recursive_rates(const lw_recursive *r, const double *x, const double *u, double *dx)
{
    for (int i = 0; i < r->s->n_body; i++) {
        const lw_recursive_body *p = &r->body[i];
        int n = turns_by_quaternion(p->kind) ? p->n_u - 3 : p->n_u, at = p->x + n;
        memcpy(dx + p->x, u + p->u, (size_t)n*sizeof *dx);
        if (n == p->n_u)
            continue;
        const double *w = u + p->u + n;
        lw_quaternion t = lw_quaternion_times((lw_quaternion){ 0, 0.5*w[0], 0.5*w[1], 0.5*w[2] },
                                              (lw_quaternion){ x[at], x[at + 1], x[at + 2], x[at + 3] });
        dx[at] = t.w, dx[at + 1] = t.x, dx[at + 2] = t.y, dx[at + 3] = t.z;
    }
}

void lw_recursive_move(const lw_recursive *r, double *x, const double *by)
{
    for (int i = 0; i < r->s->n_body; i++) {
        const lw_recursive_body *p = &r->body[i];
        int n = turns_by_quaternion(p->kind) ? p->n_u - 3 : p->n_u;
        double *at = x + p->x + n;
        const double *w = by + p->u + n;
        for (int k = 0; k < n; k++)
            x[p->x + k] += by[p->u + k];
        if (n == p->n_u)
            continue;
        lw_quaternion t = lw_quaternion_unit(lw_quaternion_times(lw_quaternion_of_vector(lw_v3(w[0], w[1], w[2])),
                                                                 (lw_quaternion){ at[0], at[1], at[2], at[3] }));
        at[0] = t.w, at[1] = t.x, at[2] = t.y, at[3] = t.z;
    }
}

static bool wrap(double *angle)
{
    bool far = fabs(*angle) > 2*LW_PI;
    *angle = far ? remainder(*angle, 2*LW_PI) : *angle;
    return far;
}

bool lw_recursive_wrap(const lw_recursive *r, double *x)
{
    bool any = false;
    for (int i = 0; i < r->s->n_body; i++) {
        const lw_recursive_body *p = &r->body[i];
        double *at = x + p->x;
        if (p->kind == LW_SPATIAL_REVOLUTE || p->kind == LW_SPATIAL_CYLINDRICAL || p->kind == LW_SPATIAL_UNIVERSAL)
            any = wrap(at) || any;
        if (p->kind == LW_SPATIAL_UNIVERSAL || p->kind == LW_SPATIAL_PLANAR)
            any = wrap(at + p->n_u - 1) || any;
    }
    return any;
}

void lw_recursive_count_turns(const lw_recursive *r, const double *x, double *turn)
{
    for (int i = 0; i < r->s->n_body; i++) {
        const lw_recursive_body *p = &r->body[i];
        if (p->joint < 0 || !lw_spatial_kind_of(p->kind)->turns)
            continue;
        double off = x[p->x + (p->kind == LW_SPATIAL_PLANAR ? 2 : 0)] - turn[p->joint];
        turn[p->joint] += fabs(off) < LW_PI ? off : remainder(off, 2*LW_PI);
    }
}

void lw_recursive_normalise(const lw_recursive *r, double *x)
{
    for (int i = 0; i < r->s->n_body; i++) {
        const lw_recursive_body *p = &r->body[i];
        double *q = x + p->x + p->n_u - 3;
        if (!turns_by_quaternion(p->kind))
            continue;
        lw_quaternion t = lw_quaternion_unit((lw_quaternion){ q[0], q[1], q[2], q[3] });
        q[0] = t.w, q[1] = t.x, q[2] = t.y, q[3] = t.z;
    }
}

static double angle_about(lw_quaternion t, lw_vec3 axis)
{
    return 2*atan2(lw_v3_dot(lw_v3(t.x, t.y, t.z), axis), t.w);
}

/* Angles are those nearest to 0, of a screw nearest to its slide. */
static void coordinates(const lw_recursive *r, const lw_recursive_body *p, lw_quaternion all, lw_vec3 slide, double *x)
{
    const lw_space_joint *j = p->joint < 0 ? NULL : &r->s->joint[p->joint];
    lw_quaternion t = lw_quaternion_times(all, lw_quaternion_inverse(p->fixed));
    switch (p->kind) {
    case LW_SPATIAL_REVOLUTE: x[0] = remainder(angle_about(t, j->z[0]), 2*LW_PI); break;
    case LW_SPATIAL_PRISMATIC: x[0] = lw_v3_dot(slide, j->z[0]); break;
    case LW_SPATIAL_CYLINDRICAL: x[0] = remainder(angle_about(t, j->z[0]), 2*LW_PI), x[1] = lw_v3_dot(slide, j->z[0]); break;
    case LW_SPATIAL_SCREW: {
        double near = lw_v3_dot(slide, j->z[0])*r->s->unit/j->pitch;
        x[0] = near + remainder(angle_about(t, j->z[0]) - near, 2*LW_PI);
        break;
    }
    case LW_SPATIAL_PLANAR:
        x[0] = lw_v3_dot(slide, j->x[0]), x[1] = lw_v3_dot(slide, j->y[0]), x[2] = remainder(angle_about(t, j->z[0]), 2*LW_PI);
        break;
    case LW_SPATIAL_UNIVERSAL: {             /* the axis of body 1 turns about that of body 0 */
        lw_mat3 from = lw_quaternion_matrix(p->fixed), to = lw_quaternion_matrix(all);
        lw_vec3 a = lw_m3_apply(&from, j->x[1]), b = lw_m3_apply(&to, j->x[1]);
        x[0] = atan2(lw_v3_dot(j->x[0], lw_v3_cross(a, b)), lw_v3_dot(lw_v3_cross(j->x[0], a), lw_v3_cross(j->x[0], b)));
        t = lw_quaternion_times(lw_quaternion_times(lw_quaternion_inverse(p->fixed), about(j->x[0], -x[0])), all);
        x[1] = remainder(angle_about(t, j->x[1]), 2*LW_PI);
        break;
    }
    case LW_SPATIAL_SPHERICAL: x[0] = t.w, x[1] = t.x, x[2] = t.y, x[3] = t.z; break;
    case LW_SPATIAL_FREE:
        x[0] = slide.x, x[1] = slide.y, x[2] = slide.z, x[3] = all.w, x[4] = all.x, x[5] = all.y, x[6] = all.z;
        break;
    case LW_SPATIAL_FIXED: break;
    }
}

void lw_recursive_of_bodies(lw_recursive *r, const double *q, const double *v, double *x, double *u)
{
    for (int i = 0; i < r->s->n_body; i++) {
        lw_recursive_body *p = &r->body[i];
        const double *own = q + 7*p->body, *rate = v + 6*p->body;
        p->turn = lw_quaternion_unit((lw_quaternion){ own[3], own[4], own[5], own[6] });
        p->axes = lw_quaternion_matrix(p->turn);
        p->at = lw_v3(own[0], own[1], own[2]);
        p->velocity = (lw_screw){ along_axes(&p->axes, rate + 3), lw_v3(rate[0], rate[1], rate[2]) };
        const lw_recursive_body *b = &r->body[p->parent], *b0 = p->back ? p : b, *b1 = p->back ? b : p;
        lw_vec3 e0 = lw_m3_apply(&b0->axes, p->arm[0]), e1 = lw_m3_apply(&b1->axes, p->arm[1]);
        lw_vec3 apart = lw_v3_sub(lw_v3_add(b1->at, e1), lw_v3_add(b0->at, e0));
        coordinates(r, p, lw_quaternion_times(lw_quaternion_inverse(b0->turn), b1->turn), lw_m3_unapply(&b0->axes, apart), x + p->x);
        freedom f[6];
        freedoms(r, p, &b0->axes, &b1->axes, f);
        lw_vec3 turn = lw_v3_sub(b1->velocity.turn, b0->velocity.turn);
        lw_vec3 move = lw_v3_sub(lw_v3_add(b1->velocity.move, lw_v3_cross(b1->velocity.turn, e1)),
                                 lw_v3_add(b0->velocity.move, lw_v3_cross(b0->velocity.turn, lw_v3_add(e0, apart))));
        for (int k = 0; k < p->n_u; k++)
            u[p->u + k] = lw_v3_norm(f[k].turn) > 0 ? lw_v3_dot(f[k].turn, turn) : lw_v3_dot(f[k].slide, move);
        if (p->kind == LW_SPATIAL_UNIVERSAL) {           /* its axes need not be square */
            double c = lw_v3_dot(f[0].turn, f[1].turn), a = u[p->u], d = u[p->u + 1];
            u[p->u] = (a - c*d)/(1 - c*c), u[p->u + 1] = (d - c*a)/(1 - c*c);
        }
    }
}

/* ---- inertias --------------------------------------------------------------------------------------------------- */

static lw_vec3 sym_apply(const double *m, lw_vec3 a)
{
    return lw_v3(m[0]*a.x + m[3]*a.y + m[4]*a.z, m[3]*a.x + m[1]*a.y + m[5]*a.z, m[4]*a.x + m[5]*a.y + m[2]*a.z);
}

static lw_screw inertia_apply(const lw_articulated *i, lw_screw a)
{
    lw_vec3 up = lw_v3_add(lw_v3_scale(i->b[0], a.turn.x), lw_v3_add(lw_v3_scale(i->b[1], a.turn.y), lw_v3_scale(i->b[2], a.turn.z)));
    lw_vec3 along = lw_v3(lw_v3_dot(i->b[0], a.move), lw_v3_dot(i->b[1], a.move), lw_v3_dot(i->b[2], a.move));
    return (lw_screw){ lw_v3_add(sym_apply(i->j, a.turn), along), lw_v3_add(up, sym_apply(i->m, a.move)) };
}

static double screw_dot(lw_screw a, lw_screw b) { return lw_v3_dot(a.turn, b.turn) + lw_v3_dot(a.move, b.move); }
static lw_screw screw_add(lw_screw a, lw_screw b) { return (lw_screw){ lw_v3_add(a.turn, b.turn), lw_v3_add(a.move, b.move) }; }
static lw_screw screw_scale(lw_screw a, double s) { return (lw_screw){ lw_v3_scale(a.turn, s), lw_v3_scale(a.move, s) }; }

static void sym_add(double *m, double s, lw_vec3 a, lw_vec3 b)       /* s (a b^T + b a^T)/2 */
{
    m[0] += s*a.x*b.x, m[1] += s*a.y*b.y, m[2] += s*a.z*b.z;
    m[3] += 0.5*s*(a.x*b.y + a.y*b.x), m[4] += 0.5*s*(a.x*b.z + a.z*b.x), m[5] += 0.5*s*(a.y*b.z + a.z*b.y);
}

/* i -= p p^T s */
static void take_away(lw_articulated *i, lw_screw p, double s)
{
    sym_add(i->j, -s, p.turn, p.turn);
    sym_add(i->m, -s, p.move, p.move);
    i->b[0] = lw_v3_sub(i->b[0], lw_v3_scale(p.move, s*p.turn.x));
    i->b[1] = lw_v3_sub(i->b[1], lw_v3_scale(p.move, s*p.turn.y));
    i->b[2] = lw_v3_sub(i->b[2], lw_v3_scale(p.move, s*p.turn.z));
}

/* The same inertia about a point -d away, added. */
static void add_shifted(lw_articulated *to, const lw_articulated *i, lw_vec3 d)
{
    const double *m = i->m;
    const lw_vec3 column[3] = { { m[0], m[3], m[4] }, { m[3], m[1], m[5] }, { m[4], m[5], m[2] } };
    lw_vec3 c[3], b[3];                      /* rows of d x M; of B + d x M */
    for (int k = 0; k < 3; k++)
        c[k] = lw_v3_cross(d, column[k]);
    b[0] = lw_v3_add(i->b[0], lw_v3(c[0].x, c[1].x, c[2].x));
    b[1] = lw_v3_add(i->b[1], lw_v3(c[0].y, c[1].y, c[2].y));
    b[2] = lw_v3_add(i->b[2], lw_v3(c[0].z, c[1].z, c[2].z));
    lw_vec3 p[3];                            /* J stays symmetric, so the terms of b before and after the shift may be averaged */
    for (int k = 0; k < 3; k++) {
        p[k] = lw_v3_cross(d, lw_v3_scale(lw_v3_add(i->b[k], b[k]), 0.5));
        to->b[k] = lw_v3_add(to->b[k], b[k]);
    }
    to->j[0] += i->j[0] + 2*p[0].x, to->j[1] += i->j[1] + 2*p[1].y, to->j[2] += i->j[2] + 2*p[2].z;
    to->j[3] += i->j[3] + p[0].y + p[1].x, to->j[4] += i->j[4] + p[0].z + p[2].x, to->j[5] += i->j[5] + p[1].z + p[2].y;
    for (int k = 0; k < 6; k++)
        to->m[k] += m[k];
}

static void own_inertia(const lw_recursive *r, lw_recursive_body *p)
{
    const double *m = r->mass + 6*p->body;
    const lw_vec3 *a = p->axes.row;
    p->inertia = (lw_articulated){ .m = { m[0], m[1], m[2] } };
    double *j = p->inertia.j;
    for (int k = 0; k < 3; k++)
        j[k] = m[3]*a[k].x*a[k].x + m[4]*a[k].y*a[k].y + m[5]*a[k].z*a[k].z;
    j[3] = m[3]*a[0].x*a[1].x + m[4]*a[0].y*a[1].y + m[5]*a[0].z*a[1].z;
    j[4] = m[3]*a[0].x*a[2].x + m[4]*a[0].y*a[2].y + m[5]*a[0].z*a[2].z;
    j[5] = m[3]*a[1].x*a[2].x + m[4]*a[1].y*a[2].y + m[5]*a[1].z*a[2].z;
}

static lw_status factor_masses(lw_recursive *r)
{
    double most = 0;
    for (int i = 0; i < r->s->n_body; i++)
        own_inertia(r, &r->body[i]);
    for (int i = r->s->n_body - 1; i >= 0; i--) {
        lw_recursive_body *p = &r->body[i];
        for (int k = p->u + p->n_u - 1; k >= p->u; k--) {
            r->push[k] = inertia_apply(&p->inertia, r->axis[k]);
            double d = screw_dot(r->axis[k], r->push[k]);
            most = lw_greater(most, d);
            if (!(d > no_mass*most))
                return LW_E_ARG;
            r->by_inertia[k] = 1/d;
            take_away(&p->inertia, r->push[k], 1/d);
        }
        if (p->parent >= 0)
            add_shifted(&r->body[p->parent].inertia, &p->inertia, p->from_parent);
    }
    return LW_OK;
}

/* ---- loops ---------------------------------------------------------------------------------------------------- */

static void put_bodies(const lw_recursive *r, lw_recursive_row *row, int n, const int *body)
{
    for (int k = 0; k < r->s->n_side; k++)
        row->body[k] = k < n ? body[k] : -1;
}

void lw_recursive_rows(lw_recursive *r, const double *near, const double (*wanted)[3], const double *turn, const double *v)
{
    double phi[6], jac[6*LW_SPACE_ROW], bias[6];
    int n = 0;
    r->frame[0] = (lw_space_frame){ { 0, 0, 0 }, r->body[-1].axes };
    for (const lw_recursive_body *p = r->body; p < r->body + r->s->n_body; p++)
        r->frame[p->body + 1] = (lw_space_frame){ lw_v3_scale(p->at, r->s->unit), p->axes };
    for (int i = 0; i < r->n_cut; i++) {
        const lw_space_joint *j = &r->s->joint[r->cut[i]];
        int rows = lw_spatial_kind_of(j->kind)->rows;
        lw_space_joint_rows(r->s, r->cut[i], r->frame, phi, jac);
        if (v)
            lw_space_joint_bias(r->s, r->cut[i], r->frame, v, bias);
        for (int k = 0; k < rows; k++, n++) {
            put_bodies(r, &r->row[n], 2, j->body);
            r->row[n].phi = phi[k];
            r->row[n].bias = v ? bias[k] : 0;
            memcpy(r->row[n].jac, jac + k*LW_SPACE_ROW, LW_SPACE_ROW*sizeof *jac);
        }
    }
    for (int i = 0; i < r->s->n_coupling; i++, n++) {
        lw_recursive_row *p = &r->row[n];
        put_bodies(r, p, r->s->coupling[i].n_side, r->s->coupling[i].body);
        lw_space_coupling_row(r->s, i, r->frame, turn, &p->phi, p->jac);
        p->bias = v ? lw_space_coupling_bias(r->s, i, r->frame, v) : 0;
    }
    for (int i = 0; i < r->n_extra; i++, n++) {
        lw_recursive_row *p = &r->row[n];
        const lw_space_extra *x = &r->extra[i];
        p->phi = p->bias = 0;
        memset(p->jac, 0, LW_SPACE_ROW*sizeof *p->jac);
        put_bodies(r, p, 0, NULL);
        lw_space_bodies(r->s, x, p->body);
        if (x->spin)
            p->jac[3] = x->axis.x, p->jac[4] = x->axis.y, p->jac[5] = x->axis.z;
        else {
            p->phi = lw_space_measure(r->s, r->frame, x->measure, near[i], p->jac) - wanted[i][0];
            p->bias = wanted[i][2] - (v ? lw_space_measure_bias(r->s, r->frame, x->measure, v) : 0);
        }
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < r->s->n_side; k++) {
            const double *j = r->row[i].jac + 6*k;
            lw_screw *pull = &r->row[i].pull[k];
            if (r->row[i].body[k] < 0)
                continue;
            pull->move = lw_v3(j[0], j[1], j[2]);
            pull->turn = along_axes(&r->frame[r->row[i].body[k] + 1].turn, j + 3);
        }
}

/* A row of Y, whose numbers are n_row apart: what the pulls of a row leave at each rate, going inwards. */
static void halve(lw_recursive *r, const lw_recursive_row *row, double *y)
{
    int *place = r->side, last;
    memset(r->pull, 0, (size_t)r->s->n_body*sizeof *r->pull);
    for (int k = 0; k < r->s->n_side; k++) {
        place[k] = row->body[k] < 0 ? -1 : r->place[row->body[k]];
        if (place[k] >= 0)
            r->pull[place[k]] = screw_add(r->pull[place[k]], row->pull[k]);
    }
    for (;;) {
        last = place[0] > place[1] ? place[0] : place[1];
        for (int k = 2; k < r->s->n_side; k++)
            last = place[k] > last ? place[k] : last;
        if (last < 0)
            return;
        const lw_recursive_body *p = &r->body[last];
        lw_screw g = r->pull[last];
        for (int k = p->u + p->n_u - 1; k >= p->u; k--) {
            double s = y[k*r->n_row] = screw_dot(r->axis[k], g);
            g = screw_add(g, screw_scale(r->push[k], -s*r->by_inertia[k]));
        }
        if (p->parent >= 0) {
            g.turn = lw_v3_add(g.turn, lw_v3_cross(p->from_parent, g.move));
            r->pull[p->parent] = screw_add(r->pull[p->parent], g);
        }
        for (int k = 0; k < r->s->n_side; k++)
            place[k] = place[k] == last ? p->parent : place[k];
    }
}

/* The upper triangle of Y D Y^T.  A rate of the tree moves the bodies of a few rows, others leave zeros. */
static void fill_schur(lw_recursive *r)
{
    int n = r->n_row;
    double *m = r->schur;
    memset(r->half, 0, (size_t)n*(size_t)r->n_u*sizeof *r->half);
    memset(m, 0, (size_t)n*(size_t)n*sizeof *m);
    for (int i = 0; i < n; i++) {
        halve(r, &r->row[i], r->half + i);
        r->order[i] = i;
    }
    for (int k = 0; k < r->n_u; k++)
        for (int i = 0; i < n; i++) {
            const double *y = r->half + k*n;
            if (y[i] == 0)
                continue;
            double by = y[i]*r->by_inertia[k];
            for (int j = i; j < n; j++)
                m[i*n + j] += by*y[j];
        }
}

static void swap(double *a, double *b)
{
    double t = *a;
    *a = *b, *b = t;
}

/* Exchange rows and columns a < b of the symmetric matrix of which r->schur is the upper triangle. */
static void exchange(lw_recursive *r, int a, int b)
{
    int n = r->n_row, o = r->order[a];
    double *m = r->schur;
    r->order[a] = r->order[b], r->order[b] = o;
    swap(m + a*n + a, m + b*n + b);
    for (int k = 0; k < a; k++)
        swap(m + k*n + a, m + k*n + b);
    for (int k = a + 1; k < b; k++)
        swap(m + a*n + k, m + k*n + b);
    for (int k = b + 1; k < n; k++)
        swap(m + a*n + k, m + b*n + k);
}

/* Y D Y^T = U^T U, its rows and columns in r->order, by Cholesky's method with pivots: `rank` rows of U. */
static lw_status factor_rows(lw_recursive *r)
{
    int n = r->n_row;
    double *m = r->schur, first = 0;
    fill_schur(r);
    for (int k = 0; k < r->rank; k++) {
        double *u = m + k*n;
        int best = k;
        for (int i = k + 1; i < n; i++)
            best = m[i*n + i] > m[best*n + best] ? i : best;
        if (best > k)
            exchange(r, k, best);
        first = k == 0 ? u[k] : first;
        r->weak = u[k]/first;
        if (!(u[k] > no_pivot*first))
            return LW_OPEN;
        double root = u[k] = sqrt(u[k]), by = 1/root;
        for (int i = k + 1; i < n; i++)
            u[i] *= by;
        for (int i = k + 1; i < n; i++)
            for (int j = i; j < n; j++)
                m[i*n + j] -= u[i]*u[j];
    }
    return LW_OK;
}

lw_status lw_recursive_factor(lw_recursive *r)
{
    lw_status st = factor_masses(r);
    r->weak = 1;
    return st == LW_OK && r->n_row ? factor_rows(r) : st;
}

/* ---- accelerations ---------------------------------------------------------------------------------------------- */

static void push_inwards(lw_recursive *r, const double *force)
{
    for (int i = 0; i < r->s->n_body; i++) {
        lw_recursive_body *p = &r->body[i];
        const double *f = force + 6*p->body;
        p->load = (lw_screw){ lw_v3_scale(along_axes(&p->axes, f + 3), -1), lw_v3(-f[0], -f[1], -f[2]) };
    }
    for (int i = r->s->n_body - 1; i >= 0; i--) {
        lw_recursive_body *p = &r->body[i];
        for (int k = p->u + p->n_u - 1; k >= p->u; k--) {
            r->free_rate[k] = -screw_dot(r->axis[k], p->load)*r->by_inertia[k];
            p->load = screw_add(p->load, screw_scale(r->push[k], r->free_rate[k]));
        }
        if (p->parent < 0)
            continue;
        lw_screw f = screw_add(p->load, inertia_apply(&p->inertia, p->bias));
        f.turn = lw_v3_add(f.turn, lw_v3_cross(p->from_parent, f.move));
        r->body[p->parent].load = screw_add(r->body[p->parent].load, f);
    }
}

/* du from the free rates, and the accelerations of the bodies. */
static void go_outwards(lw_recursive *r, bool bias, double *du)
{
    for (int i = 0; i < r->s->n_body; i++) {
        lw_recursive_body *p = &r->body[i];
        lw_screw a = r->body[p->parent].a;
        a.move = lw_v3_add(a.move, lw_v3_cross(a.turn, p->from_parent));
        if (bias)
            a = screw_add(a, p->bias);
        for (int k = p->u; k < p->u + p->n_u; k++) {
            du[k] = r->free_rate[k] - screw_dot(r->push[k], a)*r->by_inertia[k];
            a = screw_add(a, screw_scale(r->axis[k], du[k]));
        }
        p->a = a;
    }
}

/* l of Y D Y^T l = r->l over the kept rows, others 0. */
static void solve_rows(lw_recursive *r)
{
    int n = r->n_row, rank = r->rank;
    const double *m = r->schur;
    double *x = r->sorted;
    for (int i = 0; i < rank; i++)
        x[i] = r->l[r->order[i]];
    for (int i = 0; i < rank; i++) {
        x[i] /= m[i*n + i];
        for (int j = i + 1; j < rank; j++)
            x[j] -= m[i*n + j]*x[i];
    }
    for (int i = rank - 1; i >= 0; i--) {
        for (int j = rank - 1; j > i; j--)
            x[i] -= m[i*n + j]*x[j];
        x[i] /= m[i*n + i];
    }
    for (int i = 0; i < n; i++)
        r->l[r->order[i]] = i < rank ? x[i] : 0;
}

void lw_recursive_dependence(lw_recursive *r, int i)
{
    const int n = r->n_row, left = r->rank + i;
    const double *m = r->schur;
    double *x = r->sorted;
    memset(r->l, 0, (size_t)n*sizeof *r->l);
    r->l[r->order[left]] = 1;
    for (int k = r->rank - 1; k >= 0; k--) {
        x[k] = -m[k*n + left];
        for (int j = k + 1; j < r->rank; j++)
            x[k] -= m[k*n + j]*x[j];
        r->l[r->order[k]] = x[k] /= m[k*n + k];
    }
}

void lw_recursive_solve(lw_recursive *r, const double *force, lw_recursive_want want, double *du)
{
    memset(du, 0, (size_t)r->n_u*sizeof *du);
    if (force) {
        push_inwards(r, force);
        go_outwards(r, true, du);
    }
    if (r->n_row == 0)
        return;
    for (int i = 0; i < r->n_row; i++) {
        const lw_recursive_row *row = &r->row[i];
        double is = 0, goal = want == LW_WANT_CLOSED ? -row->phi : want == LW_WANT_MOTION ? row->bias : r->l[i];
        for (int k = 0; force && k < r->s->n_side; k++)
            if (row->body[k] >= 0)
                is += screw_dot(row->pull[k], r->body[r->place[row->body[k]]].a);
        r->l[i] = is - goal;
    }
    solve_rows(r);
    for (int k = 0; k < r->n_u; k++) {
        double sum = 0;
        for (int i = 0; i < r->n_row; i++)
            sum += r->half[k*r->n_row + i]*r->l[i];
        r->free_rate[k] = -sum*r->by_inertia[k];
    }
    go_outwards(r, false, r->along);
    for (int k = 0; k < r->n_u; k++)
        du[k] += r->along[k];
}

void lw_recursive_accelerations(lw_recursive *r, const double *du, double *a)
{
    for (int i = 0; i < r->s->n_body; i++) {
        lw_recursive_body *p = &r->body[i];
        double *out = a + 6*p->body;
        p->a = r->body[p->parent].a;
        p->a.move = lw_v3_add(p->a.move, lw_v3_cross(p->a.turn, p->from_parent));
        p->a = screw_add(p->a, p->bias);
        for (int k = p->u; k < p->u + p->n_u; k++)
            p->a = screw_add(p->a, screw_scale(r->axis[k], du[k]));
        lw_vec3 own = lw_m3_unapply(&p->axes, p->a.turn);
        out[0] = p->a.move.x, out[1] = p->a.move.y, out[2] = p->a.move.z, out[3] = own.x, out[4] = own.y, out[5] = own.z;
    }
}

/* mbs/clearance/clearance_tree.c - tree coordinates of a linkage with some joints opened. */
#include <assert.h>
#include <string.h>
#include "mbs/clearance/clearance_tree_internal.h"

/* ---- making -------------------------------------------------------------------------------------- */

static void add_path(lw_tree_joint *b, int k)
{
    if (k < 0)
        return;
    for (int i = 0; i < b->n_path; i++)
        if (b->path[i] == k)
            return;
    b->path[b->n_path++] = k;
}

/* Connect a body to its parent by joint j, whose link[end] is the parent. */
static void hang(lw_tree *t, int body, int j, int end)
{
    const lw_system_joint *p = &t->s->joint[j];
    lw_tree_joint *b = &t->hang[body];
    const lw_tree_joint *up = p->body[end] < 0 ? NULL : &t->hang[p->body[end]];
    *b = (lw_tree_joint){ .parent = p->body[end], .joint = j, .arm = { p->arm[end], p->arm[1 - end] },
                      .sign = end == 0 ? 1.0 : -1.0, .coordinate = -1, .turn = up ? up->turn : -1 };
    for (int i = 0; up && i < up->n_path; i++)
        add_path(b, up->path[i]);
    add_path(b, b->turn);
    b->kind = lw_joint_turns(p->kind) ? LW_TREE_PIN : lw_joint_slides(p->kind) ? LW_TREE_SLIDE : LW_TREE_WELD;
    if (b->kind != LW_TREE_WELD)
        add_path(b, b->coordinate = t->n_u++);
    if (b->kind == LW_TREE_PIN)
        b->turn = b->coordinate;
    t->order[t->n_body++] = body;
}

static void add_free_body(lw_tree *t, int body)
{
    lw_tree_joint *b = &t->hang[body];
    *b = (lw_tree_joint){ .parent = -1, .kind = LW_TREE_FREE, .joint = -1, .coordinate = t->n_u, .turn = t->n_u + 2 };
    for (int i = 0; i < 3; i++)
        add_path(b, t->n_u++);
    t->order[t->n_body++] = body;
}

static bool can_hang(lw_joint_kind kind) { return lw_joint_freedoms(kind) <= 1; }

/* Add one body by the first joint from a connected body (or ground) to one that is not. */
static bool grow(lw_tree *t, const bool *opened, const bool *apart, bool *hangs, bool *used)
{
    for (int j = 0; j < t->s->n_joint; j++)
        for (int end = 0; end < 2 && !opened[j] && !apart[j] && !used[j] && can_hang(t->s->joint[j].kind); end++) {
            int from = t->s->joint[j].body[end], to = t->s->joint[j].body[1 - end];
            if (to < 0 || hangs[to] || (from >= 0 && !hangs[from]))
                continue;
            used[j] = hangs[to] = true;
            hang(t, to, j, end);
            return true;
        }
    return false;
}

void lw_tree_make(const lw_system *s, const bool *opened, const bool *apart, lw_tree *t)
{
    bool hangs[LW_LINK_MAX] = { false }, used[LW_JOINT_MAX] = { false };
    memset(t, 0, sizeof *t);
    t->s = s;
    while (t->n_body < s->n_body) {
        if (grow(t, opened, apart, hangs, used))
            continue;
        int body = 0;
        while (hangs[body])
            body++;
        hangs[body] = true;
        add_free_body(t, body);
    }
    assert(t->n_u <= LW_SYSTEM_Q_MAX);
    for (int j = 0; j < s->n_joint; j++)
        if (!opened[j] && !used[j]) {
            t->close[t->n_close++] = j;
            t->n_row += lw_joint_equations(s->joint[j].kind);
        }
}

/* ---- moments ------------------------------------------------------------------------------------- */

static inline lw_vec2 *columns(const lw_tree *t, const lw_tree_state *s, int body)
{
    return s->b + (size_t)body*(size_t)t->n_u;
}

static inline void add_to(lw_vec2 *b, int k, lw_vec2 v)
{
    if (k >= 0)
        b[k] = lw_v2_add(b[k], v);
}

static void place_free(const lw_tree_joint *b, const double *u, const double *du, int body, lw_vec2 *col, lw_tree_state *s)
{
    int k = b->coordinate;
    s->at[body + 1] = lw_v2(u[k], u[k + 1]);
    s->turn[body + 1] = u[k + 2];
    s->dir[body + 1] = lw_v2_polar(1.0, u[k + 2]);
    s->spin[body + 1] = du ? du[k + 2] : 0.0;
    s->bias[body + 1] = lw_v2(0.0, 0.0);
    col[k] = lw_v2(1.0, 0.0);
    col[k + 1] = lw_v2(0.0, 1.0);
    col[k + 2] = lw_v2(0.0, 0.0);
}

/* The place of a body is p + r_p [+ sign u w] - r_b, with r_p, r_b the turned arms of the joint on parent and body,
 * and w the turned line of the slide. */
static void place_one(const lw_tree *t, const double *u, const double *du, int body, lw_tree_state *s)
{
    const lw_tree_joint *b = &t->hang[body];
    lw_vec2 *col = columns(t, s, body);
    if (b->kind == LW_TREE_FREE) {
        place_free(b, u, du, body, col, s);
        return;
    }
    int p = b->parent + 1, i = body + 1;
    bool pin = b->kind == LW_TREE_PIN, slide = b->kind == LW_TREE_SLIDE;
    s->turn[i] = pin ? u[b->coordinate] : s->turn[p];
    s->dir[i] = pin ? lw_v2_polar(1.0, s->turn[i]) : s->dir[p];
    s->spin[i] = pin && du ? du[b->coordinate] : s->spin[p];
    lw_vec2 rp = lw_v2_turn(b->arm[0], s->dir[p]), rb = lw_v2_turn(b->arm[1], s->dir[i]), w = { 0.0, 0.0 };
    if (slide) {
        w = lw_v2_scale(lw_v2_turn(t->s->joint[b->joint].along, s->dir[p]), b->sign);
        rp = lw_v2_add(rp, lw_v2_scale(w, u[b->coordinate]));
    }
    s->at[i] = lw_v2_sub(lw_v2_add(s->at[p], rp), rb);
    const lw_vec2 *up = b->parent < 0 ? NULL : columns(t, s, b->parent);
    for (int k = 0; k < b->n_path; k++)
        col[b->path[k]] = up ? up[b->path[k]] : lw_v2(0.0, 0.0);
    add_to(col, b->parent < 0 ? -1 : t->hang[b->parent].turn, lw_v2_perp(rp));
    add_to(col, b->turn, lw_v2_scale(lw_v2_perp(rb), -1.0));
    if (slide)
        add_to(col, b->coordinate, w);
    double wp = s->spin[p]*s->spin[p], wb = s->spin[i]*s->spin[i];
    s->bias[i] = lw_v2_add(lw_v2_sub(s->bias[p], lw_v2_scale(rp, wp)), lw_v2_scale(rb, wb));
    if (slide && du)
        s->bias[i] = lw_v2_add(s->bias[i], lw_v2_scale(lw_v2_perp(w), 2.0*s->spin[p]*du[b->coordinate]));
}

void lw_tree_place(const lw_tree *t, const double *u, const double *du, lw_tree_state *s)
{
    s->at[0] = s->bias[0] = lw_v2(0.0, 0.0);
    s->dir[0] = lw_v2(1.0, 0.0);
    s->turn[0] = s->spin[0] = 0.0;
    for (int i = 0; i < t->n_body; i++)
        place_one(t, u, du, t->order[i], s);
}

void lw_tree_read(const lw_tree *t, const double *q, const double *v, double *u, double *du)
{
    for (int i = 0; i < t->n_body; i++) {
        const lw_tree_joint *b = &t->hang[t->order[i]];
        int body = t->order[i], k = b->coordinate;
        if (b->kind == LW_TREE_PIN) {
            u[k] = q[3*body + 2];
            if (du)
                du[k] = v[3*body + 2];
        } else if (b->kind == LW_TREE_FREE) {
            memcpy(u + k, q + 3*body, 3*sizeof *u);
            if (du)
                memcpy(du + k, v + 3*body, 3*sizeof *du);
        } else if (b->kind == LW_TREE_SLIDE) {
            double row[LW_SYSTEM_Q_MAX], sum = 0.0;
            u[k] = lw_system_measure(t->s, b->joint, q, du ? row : NULL);
            for (int c = 0; du && c < t->s->n_q; c++)
                sum += row[c]*v[c];
            if (du)
                du[k] = sum;
        }
    }
}

void lw_tree_write(const lw_tree *t, const lw_tree_state *s, const double *du, double *q, double *v)
{
    for (int body = 0; body < t->n_body; body++) {
        q[3*body] = s->at[body + 1].x;
        q[3*body + 1] = s->at[body + 1].y;
        q[3*body + 2] = s->turn[body + 1];
        if (!v)
            continue;
        lw_vec2 rate = lw_tree_velocity(t, s, body, lw_v2(0.0, 0.0), du);
        v[3*body] = rate.x;
        v[3*body + 1] = rate.y;
        v[3*body + 2] = s->spin[body + 1];
    }
}

void lw_tree_accelerations(const lw_tree *t, const lw_tree_state *s, const double *ddu, double *a)
{
    for (int body = 0; body < t->n_body; body++) {
        const lw_tree_joint *b = &t->hang[body];
        lw_vec2 sum = s->bias[body + 1];
        for (int i = 0; i < b->n_path; i++)
            sum = lw_v2_add(sum, lw_v2_scale(columns(t, s, body)[b->path[i]], ddu[b->path[i]]));
        a[3*body] = sum.x;
        a[3*body + 1] = sum.y;
        a[3*body + 2] = b->turn >= 0 ? ddu[b->turn] : 0.0;
    }
}

lw_vec2 lw_tree_velocity(const lw_tree *t, const lw_tree_state *s, int body, lw_vec2 r, const double *du)
{
    if (body < 0)
        return lw_v2(0.0, 0.0);
    const lw_tree_joint *b = &t->hang[body];
    const lw_vec2 *col = columns(t, s, body);
    lw_vec2 v = lw_v2_scale(lw_v2_perp(r), s->spin[body + 1]);
    for (int i = 0; i < b->n_path; i++)
        v = lw_v2_add(v, lw_v2_scale(col[b->path[i]], du[b->path[i]]));
    return v;
}

void lw_tree_push(const lw_tree *t, const lw_tree_state *s, int body, lw_vec2 r, lw_vec2 f, double torque, double *force)
{
    if (body < 0)
        return;
    const lw_tree_joint *b = &t->hang[body];
    const lw_vec2 *col = columns(t, s, body);
    for (int i = 0; i < b->n_path; i++)
        force[b->path[i]] += lw_v2_dot(f, col[b->path[i]]);
    if (b->turn >= 0)
        force[b->turn] += lw_v2_cross(r, f) + torque;
}

/* mbs/newton_loop.c - the loop equations of a planar linkage and their Jacobian.
 *
 * With u = R(turn) v for what a link carries, the point of a joint on link i is q_i = x_i + R_i arm_i:
 *
 *     pin       q_0 - q_1 = 0
 *     slider    turn_1 - turn_0 = 0,   u x (q_1 - q_0) = 0      u the slide on link 0
 *     slot                             u x (q_1 - q_0) = 0
 *     input     turn of the driven link = change,  or  u . (q_1 - q_0) = change                   */
#include "mbs/newton_internal.h"
#include <string.h>

static lw_status count_equations(const lw_linkage *k, lw_loop *p, lw_error *e)
{
    p->n = 3*(k->n_link - 1);
    p->m = k->n_input;
    for (int j = 0; j < k->n_joint; j++) {
        if (k->joint[j].kind == LW_JOINT_GEAR)
            return lw_error_set(e, LW_E_KIND, "joint %s is a gear or cam; the loop equations here know "
                                "pins, sliders and slots", k->joint[j].name);
        p->m += k->joint[j].kind == LW_JOINT_SLOT ? 1 : 2;
    }
    if (k->n_input < 1)
        return lw_error_set(e, LW_E_ARG, "the linkage has no input to move it by");
    if (p->m < p->n)
        return lw_error_set(e, LW_E_ARG, "the linkage has %d freedoms but %d inputs; drive %d more joints",
                            lw_linkage_mobility(k), k->n_input, p->n - p->m);
    return LW_OK;
}

/* Middle and size of what is drawn.  Differences are taken before sums, so that a posture far from
 * the origin keeps its digits. */
static void measure(const lw_linkage *k, lw_loop *p)
{
    lw_vec2 first = k->joint[0].at, sum = { 0.0, 0.0 };
    for (int j = 0; j < k->n_joint; j++)
        sum = lw_v2_add(sum, lw_v2_sub(k->joint[j].at, first));
    p->centre = lw_v2_add(first, lw_v2_scale(sum, 1.0/k->n_joint));
    p->size = 0.0;
    for (int j = 0; j < k->n_joint; j++)
        p->size = fmax(p->size, lw_v2_norm(lw_v2_sub(k->joint[j].at, p->centre)));
}

static lw_vec2 reduced(const lw_loop *p, lw_vec2 at)
{
    return lw_v2_scale(lw_v2_sub(at, p->centre), 1.0/p->size);
}

static void place_links(const lw_linkage *k, lw_loop *p)
{
    int count[LW_LINK_MAX] = { 0 };
    for (int j = 0; j < k->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            int i = k->joint[j].link[end];
            p->middle[i] = lw_v2_add(p->middle[i], reduced(p, k->joint[j].at));
            count[i]++;
        }
    for (int i = 0, column = 0; i < k->n_link; i++) {
        p->middle[i] = lw_v2_scale(p->middle[i], 1.0/count[i]);
        p->column[i] = i == k->ground ? -1 : column;
        column += i == k->ground ? 0 : 3;
    }
}

lw_status lw_loop_make(const lw_linkage *k, lw_loop *p, lw_error *e)
{
    memset(p, 0, sizeof *p);
    lw_status status = lw_linkage_check(k, e);
    if (status == LW_OK)
        status = count_equations(k, p, e);
    if (status != LW_OK)
        return status;
    measure(k, p);
    if (!(p->size > 0.0))
        return lw_error_set(e, LW_E_ARG, "all joints of the posture are at one point");
    p->n_link = k->n_link;
    p->n_joint = k->n_joint;
    p->n_input = k->n_input;
    place_links(k, p);
    for (int j = 0; j < k->n_joint; j++) {
        lw_loop_joint *q = &p->joint[j];
        q->kind = k->joint[j].kind;
        q->along = k->joint[j].along;
        for (int end = 0; end < 2; end++) {
            q->link[end] = k->joint[j].link[end];
            q->arm[end] = lw_loop_arm(p, q->link[end], k->joint[j].at);
        }
    }
    for (int i = 0; i < k->n_input; i++)
        p->input[i] = k->input[i].joint;
    return LW_OK;
}

void lw_loop_posture(const lw_loop *p, double *z)
{
    for (int i = 0; i < p->n_link; i++)
        if (p->column[i] >= 0) {
            z[p->column[i]] = p->middle[i].x;
            z[p->column[i] + 1] = p->middle[i].y;
            z[p->column[i] + 2] = 0.0;
        }
    z[p->n] = 0.0;
}

/* --- one evaluation --- */

typedef struct frames {
    lw_vec2 origin[LW_LINK_MAX], dir[LW_LINK_MAX];
    double  turn[LW_LINK_MAX];
} frames;

static void make_frames(const lw_loop *p, const double *z, frames *f)
{
    for (int i = 0; i < p->n_link; i++) {
        int c = p->column[i];
        f->origin[i] = c < 0 ? p->middle[i] : lw_v2(z[c], z[c + 1]);
        f->turn[i] = c < 0 ? 0.0 : z[c + 2];
        f->dir[i] = c < 0 ? lw_v2(1.0, 0.0) : lw_v2_polar(1.0, z[c + 2]);
    }
}

/* A joint at its two links: r the turned arms, q the points, d = q_1 - q_0, u the slide. */
typedef struct contact { lw_vec2 r[2], d, u; } contact;

static contact touch(const lw_loop_joint *q, const frames *f)
{
    contact t;
    t.r[0] = lw_v2_turn(q->arm[0], f->dir[q->link[0]]);
    t.r[1] = lw_v2_turn(q->arm[1], f->dir[q->link[1]]);
    t.d = lw_v2_sub(lw_v2_add(f->origin[q->link[1]], t.r[1]), lw_v2_add(f->origin[q->link[0]], t.r[0]));
    t.u = lw_v2_turn(q->along, f->dir[q->link[0]]);
    return t;
}

/* turn_1 - turn_0; whole turns do not count, as coordinates are kept within half a turn */
static double relative_turn(const lw_loop_joint *q, const frames *f, double wanted)
{
    return remainder(f->turn[q->link[1]] - f->turn[q->link[0]] - wanted, 2.0*LW_PI);
}

/* The turn of a pin's driven link: the moving one, or link[1] against link[0]. */
static double drive_sign(const lw_loop *p, const lw_loop_joint *q)
{
    return p->column[q->link[1]] < 0 ? -1.0 : 1.0;
}

static void add(double *j, int ld, int row, int column, double x, double y, double turn)
{
    if (column < 0)
        return;
    j[row + (long)ld*column] += x;
    j[row + (long)ld*(column + 1)] += y;
    j[row + (long)ld*(column + 2)] += turn;
}

/* Row of  v . d  where v is a unit vector: fixed in the plane, or carried by link 0 (then dv is its
 * derivative by the turn of link 0, else 0). */
static void add_projection(const lw_loop *p, const lw_loop_joint *q, const contact *t, lw_vec2 v,
                           lw_vec2 dv, double *j, int ld, int row)
{
    lw_vec2 w0 = lw_v2_perp(t->r[0]), w1 = lw_v2_perp(t->r[1]);
    add(j, ld, row, p->column[q->link[1]], v.x, v.y, lw_v2_dot(v, w1));
    add(j, ld, row, p->column[q->link[0]], -v.x, -v.y, lw_v2_dot(dv, t->d) - lw_v2_dot(v, w0));
}

static void add_turn(const lw_loop *p, const lw_loop_joint *q, double sign, double *j, int ld, int row)
{
    add(j, ld, row, p->column[q->link[1]], 0.0, 0.0, sign);
    add(j, ld, row, p->column[q->link[0]], 0.0, 0.0, -sign);
}

/* Equations of one joint from row `row`; returns the next free row. */
static int joint_rows(const lw_loop *p, const lw_loop_joint *q, const frames *f, double *r, double *j,
                      int ld, int row)
{
    static const lw_vec2 none = { 0.0, 0.0 }, ex = { 1.0, 0.0 }, ey = { 0.0, 1.0 };
    contact t = touch(q, f);
    if (q->kind == LW_JOINT_REVOLUTE) {
        r[row] = t.d.x;
        r[row + 1] = t.d.y;
        if (j) {
            add_projection(p, q, &t, ex, none, j, ld, row);
            add_projection(p, q, &t, ey, none, j, ld, row + 1);
        }
        return row + 2;
    }
    lw_vec2 across = lw_v2_perp(t.u), against = lw_v2_scale(t.u, -1.0);
    r[row] = lw_v2_dot(across, t.d);
    if (j)
        add_projection(p, q, &t, across, against, j, ld, row);
    if (q->kind == LW_JOINT_SLOT)
        return row + 1;
    r[row + 1] = relative_turn(q, f, 0.0);
    if (j)
        add_turn(p, q, 1.0, j, ld, row + 1);
    return row + 2;
}

static void input_row(const lw_loop *p, int which, const frames *f, double change, double *r, double *j,
                      int ld, int row)
{
    const lw_loop_joint *q = &p->joint[p->input[which]];
    if (q->kind == LW_JOINT_REVOLUTE) {
        double sign = drive_sign(p, q);
        r[row] = sign*relative_turn(q, f, sign*change);
        if (j)
            add_turn(p, q, sign, j, ld, row);
    } else {
        contact t = touch(q, f);
        r[row] = lw_v2_dot(t.u, t.d) - change;
        if (j)
            add_projection(p, q, &t, t.u, lw_v2_perp(t.u), j, ld, row);
    }
    if (j && which == 0)
        j[row + (long)ld*p->n] = -1.0;
}

double lw_loop_equations(const lw_loop *p, const double *z, double *f, double *j, int ld)
{
    frames at;
    make_frames(p, z, &at);
    if (j)
        for (int c = 0; c <= p->n; c++)
            memset(j + (long)ld*c, 0, (size_t)p->m*sizeof *j);
    int row = 0;
    for (int k = 0; k < p->n_joint; k++)
        row = joint_rows(p, &p->joint[k], &at, f, j, ld, row);
    for (int k = 0; k < p->n_input; k++)
        input_row(p, k, &at, k == 0 ? z[p->n] : 0.0, f, j, ld, row++);
    double most = 0.0;
    for (int i = 0; i < p->m; i++)
        most = fmax(most, fabs(f[i]));
    return most;
}

lw_vec2 lw_loop_point(const lw_loop *p, const double *z, int link, lw_vec2 arm)
{
    int c = p->column[link];
    lw_vec2 q = c < 0 ? lw_v2_add(p->middle[link], arm)
              : lw_v2_add(lw_v2(z[c], z[c + 1]), lw_v2_turn(arm, lw_v2_polar(1.0, z[c + 2])));
    return lw_v2_add(p->centre, lw_v2_scale(q, p->size));
}

lw_vec2 lw_loop_arm(const lw_loop *p, int link, lw_vec2 at)
{
    return lw_v2_sub(reduced(p, at), p->middle[link]);
}

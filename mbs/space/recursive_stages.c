/* mbs/space/recursive_stages.c - a tree and its loops made ready for the kernels of eight states. */
#include "base/real.h"
#include "base/vector.h"
#include "mbs/space/kernel_tree_internal.h"

#include <stdlib.h>
#include <string.h>

static const double near = 0.08;             /* sum over a body's path to the ground of how far coordinates [rad, sizes] move while the factors serve, */
static const double weak_loops = 0.01;       /* less where the least pivot of the loops is below this */
static const double firm_leg = 0.01;         /* least pivot of a leg over its first, from which on legs are solved apart in a step */

enum { NO_LOOP = -3, MANY = -2, GROUND = -1 };           /* lw_stage_body.onto */

static const lw_tree_kernel *const kernels[] = {
#ifdef __x86_64__
    &lw_tree_kernel_x86_64_v4, &lw_tree_kernel_x86_64_v3, &lw_tree_kernel_x86_64
#else
    &lw_tree_kernel_native
#endif
};

const lw_tree_kernel *lw_tree_kernel_of(const char *isa)
{
    size_t i = 0;
    while (i + 1 < sizeof kernels/sizeof *kernels && strcmp(kernels[i]->isa, isa) != 0)
        i++;
    return kernels[i];
}

static bool suits(const lw_recursive *r)
{
    const lw_spatial *m = r->s->model;
    bool stops = false, laws = false, screws = false;
    for (int i = 0; i < m->n_joint; i++)
        stops = stops || m->joint[i].stop.has_least || m->joint[i].stop.has_greatest;
    for (int i = 0; i < m->n_spring; i++)
        laws = laws || m->spring[i].law;
    for (int i = 0; i < r->n_cut; i++)
        screws = screws || r->s->joint[r->cut[i]].kind == LW_SPATIAL_SCREW;
    return !stops && !laws && !screws && m->n_joint_spring + m->n_force + m->n_motor + m->n_beam + m->n_super == 0
        && m->n_contact == 0 && m->states.n_state == 0 && r->n_extra + r->s->n_coupling == 0
        && (r->n_row == 0 || (r->n_row <= LW_STAGE_ROWS && r->n_u <= LW_STAGE_RATES));
}

static lw_quaternion about(lw_vec3 axis) { return (lw_quaternion){ 0, axis.x, axis.y, axis.z }; }

static void put_body(const lw_recursive *r, const lw_space_forces *f, int i, lw_tree_stages *s)
{
    const lw_recursive_body *p = &r->body[i];
    const lw_space_joint *j = p->joint < 0 ? NULL : &r->s->joint[p->joint];
    const double *m = r->mass + 6*p->body, *w = f->weight + 6*p->body;
    lw_stage_body *b = &s->body[i];
    *b = (lw_stage_body){ .parent = p->parent, .body = p->body, .kind = p->kind, .back = p->back, .x = p->x, .u = p->u, .n_u = p->n_u, .onto = NO_LOOP,
                          .root = p->parent < 0 ? i : s->body[p->parent].root,
                          .n_x = p->n_u + (p->kind == LW_SPATIAL_SPHERICAL || p->kind == LW_SPATIAL_FREE),     /* quaternions */
                          .angle = s->n_angle, .arm = { p->arm[0], p->arm[1] }, .part = { p->fixed },
                          .mass = { m[0], m[3], m[4], m[5] }, .weight = { w[0], w[1], w[2] } };
    if (!j)
        return;
    bool universal = p->kind == LW_SPATIAL_UNIVERSAL;
    b->z = universal ? j->x[0] : j->z[0];
    b->second = j->x[1];
    b->pitch = j->pitch/r->s->unit;
    b->along[0] = p->kind == LW_SPATIAL_PLANAR ? j->x[0] : j->z[0];
    b->along[1] = j->y[0];
    b->part[1] = lw_quaternion_times(about(b->z), p->fixed);
    if (lw_spatial_kind_of(p->kind)->turns || universal)
        s->turn[s->n_angle++] = p->x + (p->kind == LW_SPATIAL_PLANAR ? 2 : 0);
    if (universal)
        s->turn[s->n_angle++] = p->x + 1;
}

/* The rows of lw_space_joint_rows, in its order. */
static int put_rows(const lw_space_joint *j, lw_stage_row *row)
{
    lw_spatial_kind k = j->kind;
    int n = 0;
    if (k == LW_SPATIAL_SPHERICAL || k == LW_SPATIAL_REVOLUTE || k == LW_SPATIAL_UNIVERSAL || k == LW_SPATIAL_FIXED)
        for (int i = 0; i < 3; i++)
            row[n++] = (lw_stage_row){ .kind = LW_STAGE_POINT, .a = lw_v3(i == 0, i == 1, i == 2) };
    else if (k == LW_SPATIAL_PLANAR)
        row[n++] = (lw_stage_row){ .kind = LW_STAGE_LINE, .a = j->z[0] };
    else {
        row[n++] = (lw_stage_row){ .kind = LW_STAGE_LINE, .a = j->x[0] };
        row[n++] = (lw_stage_row){ .kind = LW_STAGE_LINE, .a = j->y[0] };
    }
    if (k == LW_SPATIAL_SPHERICAL)
        return n;
    if (k == LW_SPATIAL_UNIVERSAL) {
        row[n++] = (lw_stage_row){ .kind = LW_STAGE_TURN, .a = j->x[0], .b = j->x[1], .fixed = j->fixed };
        return n;
    }
    row[n++] = (lw_stage_row){ .kind = LW_STAGE_TURN, .a = j->x[0], .b = j->z[1] };
    row[n++] = (lw_stage_row){ .kind = LW_STAGE_TURN, .a = j->y[0], .b = j->z[1] };
    if (k == LW_SPATIAL_FIXED || k == LW_SPATIAL_PRISMATIC)
        row[n++] = (lw_stage_row){ .kind = LW_STAGE_TURN, .a = j->y[0], .b = j->x[1] };
    return n;
}

/* The bodies from those of a loop inwards that lead to one of them alone, or (side 2) to both; returns how many. */
static int walk(const lw_tree_stages *s, const lw_stage_loop *p, int side, int *path)
{
    int at[2] = { p->body[0], p->body[1] }, n = 0;
    while (at[0] != at[1]) {
        int k = at[0] < at[1];
        if (k == side)
            path[n++] = at[k];
        at[k] = s->body[at[k]].parent;
    }
    for (int b = at[0]; side == 2 && b >= 0; b = s->body[b].parent)
        path[n++] = b;
    return n;
}

static void put_joint(const lw_recursive *r, int joint, lw_stage_loop *p)
{
    const lw_space_joint *j = &r->s->joint[joint];
    *p = (lw_stage_loop){ .path = p->path, .first = j->row };
    for (int k = 0; k < 2; k++) {
        p->body[k] = j->body[k] < 0 ? -1 : r->place[j->body[k]];
        p->arm[k] = lw_v3_scale(j->arm[k], 1/r->s->unit);
    }
    p->n_row = put_rows(j, p->row);
}

static void put_loop(const lw_recursive *r, int cut, lw_tree_stages *s)
{
    lw_stage_loop *p = &s->loop[cut];
    int n = 0;
    put_joint(r, r->cut[cut], p);
    for (int k = 0; k < 3; k++)
        n += p->n_path[k] = walk(s, p, k, p->path + n);
    for (int i = 0; i < n; i++) {
        const lw_stage_body *b = &s->body[p->path[i]];
        for (int k = b->u; k < b->u + b->n_u; k++)
            p->rates |= 1ULL << k;
    }
}

/* ---- legs -------------------------------------------------------------------------------------------------------- */

static lw_stage_body *root_of(const lw_tree_stages *s, int body) { return body < 0 ? NULL : &s->body[s->body[body].root]; }

static int leg_of(const lw_tree_stages *s, int body)
{
    int g = body < 0 ? -1 : s->n_leg - 1;
    while (g >= 0 && s->leg[g].root != s->body[body].root)
        g--;
    return g;
}

static void find_legs(lw_tree_stages *s)
{
    for (int i = 0; i < 2*s->n_loop; i++) {
        int body = s->loop[i/2].body[i%2], other = s->loop[i/2].body[1 - i%2];
        lw_stage_body *root = root_of(s, body);
        if (!root)
            continue;
        if (other < 0 || root_of(s, other) == root)
            root->onto = root->onto == NO_LOOP ? GROUND : root->onto;
        else
            root->onto = root->onto == NO_LOOP || root->onto == GROUND || root->onto == other ? other : MANY;
    }
    for (int i = 0; i < s->n_body; i++)
        if (s->body[i].root == i && s->body[i].onto >= 0)
            root_of(s, s->body[i].onto)->ending++;
    for (int i = 0; i < s->n_body; i++) {
        const lw_stage_body *b = &s->body[i];
        if (b->root == i && (b->onto == GROUND || (b->onto >= 0 && root_of(s, b->onto)->ending > 1)))
            s->leg[s->n_leg++] = (lw_stage_leg){ .root = i, .carries = b->onto };
    }
    if (s->n_leg == 1 && s->leg[0].carries < 0)
        s->n_leg = 0;
    for (lw_stage_loop *p = s->loop; p < s->loop + s->n_loop; p++) {
        int leg[2] = { leg_of(s, p->body[0]), leg_of(s, p->body[1]) };
        p->leg = leg[0] < 0 ? leg[1] : leg[0];
        p->side = p->body[0] < 0 || p->body[1] < 0 || leg[0] == leg[1] ? -1 : leg[0] < 0;
        for (int i = 0; p->leg >= 0 && i < s->n_body; i++)
            for (int k = s->body[i].u; leg_of(s, i) == p->leg && k < s->body[i].u + s->body[i].n_u; k++)
                p->own |= p->rates & 1ULL << k;
    }
}

/* The loop of a row that is counted through all loops, and the row. */
static int loop_of(const lw_tree_stages *s, int row, lw_stage_row **at)
{
    int i = 0;
    for (; row >= s->loop[i].n_row; i++)
        row -= s->loop[i].n_row;
    *at = &s->loop[i].row[row];
    return i;
}

/* Put those of the n rows of a leg first that hold it, of the greatest pivots in its own rates, as r was factored last.  Returns how many; -1:
 * they do not hold it firmly. */
static int hold_firmly(const lw_recursive *r, unsigned long long rates, bool carries, int n, int *row)
{
    double half[LW_STAGE_ROWS][LW_STAGE_RATES], first = 0;
    int hold = 0, n_rate = 0;
    for (; rates; rates &= rates - 1, n_rate++) {
        int k = __builtin_ctzll(rates);
        for (int i = 0; i < n; i++)
            half[i][n_rate] = r->half[k*r->n_row + row[i]]*sqrt(r->by_inertia[k]);
    }
    for (; hold < n && hold < n_rate; hold++) {
        double greatest = 0;
        int best = hold;
        for (int i = hold; i < n; i++) {
            double size = 0;
            for (int k = 0; k < n_rate; k++)
                size += half[i][k]*half[i][k];
            if (size > greatest)
                greatest = size, best = i;
        }
        first = hold ? first : greatest;
        if (!(greatest > firm_leg*first))
            return -1;
        for (int k = 0; k < n_rate; k++) {
            double taken = half[best][k];
            half[best][k] = half[hold][k], half[hold][k] = taken;
        }
        int taken = row[best];
        row[best] = row[hold], row[hold] = taken;
        for (int i = hold + 1; i < n; i++) {             /* less what lies along this one */
            double along = 0;
            for (int k = 0; k < n_rate; k++)
                along += half[i][k]*half[hold][k]/greatest;
            for (int k = 0; k < n_rate; k++)
                half[i][k] -= along*half[hold][k];
        }
    }
    return hold == 0 || (hold < n && !carries) ? -1 : hold;
}

/* The kept rows in the order of their places with legs apart: those that hold legs, those beyond them, all others.  False: a leg is not held
 * firmly. */
static bool take_apart(lw_tree_stages *s, const lw_recursive *r, int *row)
{
    int left[LW_STAGE_ROWS], n_left = 0, n = 0;
    lw_stage_row *at;
    for (int i = 0; i < s->n_leg; i++) {
        lw_stage_leg *g = &s->leg[i];
        unsigned long long rates = 0;
        int all = 0;
        for (int k = 0; k < s->n_kept; k++) {
            const lw_stage_loop *p = &s->loop[loop_of(s, s->sorted[k], &at)];
            if (p->leg == i)
                row[n + all++] = s->sorted[k], rates |= p->own;
        }
        g->n_row = hold_firmly(r, rates, g->carries >= 0, all, row + n);
        if (g->n_row < 0)
            return false;
        g->row = n, n += g->n_row;
        g->left = n_left, g->n_left = all - g->n_row;
        memcpy(left + n_left, row + n, (size_t)g->n_left*sizeof *row);
        n_left += g->n_left;
    }
    s->n_apart = n;
    for (int i = 0; i < s->n_leg; i++)
        s->leg[i].left += n;
    memcpy(row + n, left, (size_t)n_left*sizeof *row);
    n += n_left;
    for (int k = 0; k < s->n_kept; k++)
        if (s->loop[loop_of(s, s->sorted[k], &at)].leg < 0)
            row[n++] = s->sorted[k];
    return true;
}

/* Places of the kept rows, and the order of the bodies. */
static void arrange(lw_tree_stages *s, const int *row)
{
    const bool apart = s->n_apart > 0;
    for (lw_stage_loop *p = s->loop; p < s->loop + s->n_loop; p++) {
        p->apart = apart ? p->leg : -1;
        for (int k = 0; k < p->n_row; k++)
            p->row[k].at = -1;
    }
    for (int i = 0; i < s->n_kept; i++) {
        lw_stage_row *at;
        int loop = loop_of(s, row[i], &at);
        const lw_stage_loop *p = &s->loop[loop];
        const unsigned long long own = apart ? p->own : 0;
        at->at = i;
        s->kept[i] = (lw_stage_kept){ loop, p->rates & ~own, own };
    }
    for (int i = 0; i < s->n_body; i++)
        s->body[i].carried = false, s->body[i].leaf = true;
    for (int g = 0; apart && g < s->n_leg; g++)
        if (s->leg[g].carries >= 0)
            s->body[s->leg[g].carries].carried = true, s->body[s->leg[g].carries].leaf = false;
    s->n_hanging = 0;
    for (int i = s->n_body - 1; i >= 0; i--) {
        lw_stage_body *b = &s->body[i];
        if (b->parent >= 0)
            b->last_child = s->body[b->parent].leaf, s->body[b->parent].leaf = false;
    }
    for (int g = 0; apart && g < s->n_leg; g++)
        for (int i = s->n_body - 1; i >= s->leg[g].root; i--)
            if (s->body[i].root == s->leg[g].root)
                s->order[s->n_hanging++] = i;
    for (int i = s->n_body - 1, n = s->n_hanging; i >= 0; i--)
        if (!apart || leg_of(s, i) < 0)
            s->order[n++] = i;
    for (int i = 0; i + 1 < s->n_body; i++) {
        lw_stage_body *b = &s->body[s->order[i]];
        b->passes = b->last_child && s->order[i + 1] == b->parent;
    }
}

void lw_tree_stages_keep_rows(lw_tree_stages *s, const lw_recursive *r)
{
    int row[LW_STAGE_ROWS];
    if (s->n_loop == 0)
        return;
    s->n_kept = r->rank;
    memcpy(s->sorted, r->order, (size_t)s->n_kept*sizeof *row);
    s->n_apart = 0;
    arrange(s, s->n_leg > 0 && take_apart(s, r, row) ? row : s->sorted);
}

lw_status lw_tree_stages_make(const lw_recursive *r, const lw_space_forces *f, lw_tree_stages *s)
{
    const lw_spatial *m = r->s->model;
    size_t bodies = (size_t)r->s->n_body, u = (size_t)r->n_u, springs = (size_t)m->n_spring, loops = (size_t)r->n_cut;
    const lw_kernels *best = lw_kernels_supported(0);
    *s = (lw_tree_stages){ .n_body = r->s->n_body, .n_x = r->n_x, .n_u = r->n_u, .n_row = r->n_row, .n_spring = m->n_spring, .n_loop = r->n_cut,
                           .n_model_row = r->s->n_joint_row, .n_moment = 19*r->s->n_body + r->s->n_joint_row + 2,
                           .unit = r->s->unit, .turns = best->turns, .isa = best->isa, .kernel = lw_tree_kernel_of(best->isa) };
    if (!suits(r))
        return LW_E_KIND;
    size_t state = lw_tree_state_size(8, r->s->n_body, r->n_u, r->n_row);
    size_t doubles = 3*8*(u + 1) + 8*(size_t)(3*r->n_x + 2*r->n_u + 2 + s->n_moment), ints = u + 1 + loops*bodies + bodies;
    char *at = s->memory = malloc(state + LW_SCRATCH_ALIGNMENT + bodies*sizeof *s->body + springs*sizeof *s->spring + (bodies + loops)*sizeof *s->loop
                                  + loops*sizeof *s->leg + doubles*sizeof(double) + ints*sizeof(int));
    if (!at)
        return LW_E_MEMORY;
    s->state = lw_scratch_align(at), at = (char *)s->state + state;
    s->angle = (double *)(void *)at, s->cosine = s->angle + 8*(u + 1), s->sine = s->cosine + 8*(u + 1);
    s->factored = s->sine + 8*(u + 1);
    s->y = s->factored + 8*s->n_x, s->dy = s->y + 8*(s->n_x + s->n_u + 1), s->moment = s->dy + 8*(s->n_x + s->n_u + 1);
    at += doubles*sizeof(double);
    s->body = (lw_stage_body *)(void *)at, at += bodies*sizeof *s->body;
    s->spring = (lw_stage_spring *)(void *)at, at += springs*sizeof *s->spring;
    s->loop = (lw_stage_loop *)(void *)at, at += loops*sizeof *s->loop;
    s->inner = (lw_stage_loop *)(void *)at, at += bodies*sizeof *s->inner;
    s->leg = (lw_stage_leg *)(void *)at, at += loops*sizeof *s->leg;
    s->turn = (int *)(void *)at;
    s->order = s->turn + u + 1;
    for (size_t i = 0; i < loops; i++)
        s->loop[i].path = s->order + bodies + i*bodies;
    for (int i = 0; i < s->n_body; i++) {
        put_body(r, f, i, s);
        s->inner[i] = (lw_stage_loop){ .body = { -1, -1 } };
        if (r->body[i].joint >= 0 && r->body[i].kind != LW_SPATIAL_SCREW)
            put_joint(r, r->body[i].joint, &s->inner[i]);
    }
    for (int i = 0; i < s->n_loop; i++)
        put_loop(r, i, s);
    find_legs(s);
    arrange(s, s->sorted);
    for (int i = 0; i < s->n_spring; i++) {
        const lw_spring *p = &m->spring[i];
        s->spring[i] = (lw_stage_spring){ .stiffness = p->stiffness, .damping = p->damping, .free = p->free };
        for (int k = 0; k < 2; k++) {
            lw_space_point end = f->spring_end[i][k];
            s->spring[i].body[k] = end.body < 0 ? -1 : r->place[end.body];
            s->spring[i].arm[k] = lw_v3_scale(end.arm, 1/r->s->unit);
        }
    }
    return LW_OK;
}

void lw_tree_stages_free(lw_tree_stages *s)
{
    free(s->memory);
    *s = (lw_tree_stages){ 0 };
}

lw_space_tree *lw_space_tree_new(int n_extra)
{
    size_t n = (size_t)n_extra;
    lw_space_tree *t = calloc(1, sizeof *t + n*(sizeof *t->extra + sizeof *t->wanted + sizeof *t->near));
    if (!t)
        return NULL;
    t->extra = (lw_space_extra *)(t + 1);
    t->wanted = (double (*)[3])(void *)(t->extra + n);
    t->near = (double *)(t->wanted + n);
    return t;
}

void lw_space_tree_free(lw_space_tree *t)
{
    if (!t)
        return;
    lw_recursive_free(&t->r);
    lw_tree_stages_free(&t->stages);
    free(t);
}

lw_status lw_tree_stages_rates(lw_tree_stages *s, bool again, const double *y, double *dy)
{
    const double moved = s->kernel->prepare(s, again, y);
    again = again && s->n_kept == s->n_row && moved <= near*fmin(1, s->weak/weak_loops);
    if (!again)
        memcpy(s->factored, y, 8*(size_t)s->n_x*sizeof *y);
    s->turns(8*(size_t)s->n_angle, s->angle, s->cosine, s->sine);
    double weak = s->kernel->rates(s, again, y, dy);
    if (weak < 0) {
        s->n_apart = 0;
        arrange(s, s->sorted);
        weak = s->kernel->rates(s, false, y, dy);
    }
    s->weak = again ? s->weak : weak;
    return s->weak > 0 ? LW_OK : LW_E_ARG;
}

/* Half the product of the quaternion 0, w with q. */
static void turn_rates(const double *w, const double *q, double *to)
{
    for (int k = 0; k < 8; k++) {
        double x = 0.5*w[k], y = 0.5*w[8 + k], z = 0.5*w[16 + k];
        to[k] = -x*q[8 + k] - y*q[16 + k] - z*q[24 + k];
        to[8 + k] = x*q[k] + y*q[24 + k] - z*q[16 + k];
        to[16 + k] = y*q[k] + z*q[8 + k] - x*q[24 + k];
        to[24 + k] = z*q[k] + x*q[16 + k] - y*q[8 + k];
    }
}

/* x' of states whose rates are u. */
static void motion_of(const lw_tree_stages *s, const double *x, const double *u, double *dx)
{
    for (int i = 0; i < s->n_body; i++) {
        const lw_stage_body *b = &s->body[i];
        const double *from = u + 8*b->u;
        int n = b->n_x > b->n_u ? b->n_u - 3 : b->n_u;
        memcpy(dx + 8*b->x, from, 8*(size_t)n*sizeof *dx);
        if (n < b->n_u)
            turn_rates(from + 8*n, x + 8*(b->x + n), dx + 8*(b->x + n));
    }
}

void lw_tree_stages_motion(const lw_tree_stages *s, const double *y, double *dx) { motion_of(s, y, y + 8*s->n_x, dx); }

/* ---- rows of output ---------------------------------------------------------------------------------------------------- */

static const double nearly_closed = 1e-3;    /* misfit below which factors serve for the next pass */
static const double far_open = 0.1, closed = 1e-9;       /* misfit that is not closed at all; with which states still count as closed */

static double close_once(lw_tree_stages *s, bool again, bool speeds, double *du)
{
    s->kernel->prepare(s, false, s->y);
    s->turns(8*(size_t)s->n_angle, s->angle, s->cosine, s->sine);
    return s->kernel->close(s, again, speeds, s->y, du);
}

/* Passes end where rounding is reached, or nearly and a pass does not help. */
static bool is_rounding(double off, double before, double rounding) { return off <= rounding || (off < 2000*rounding && off >= 0.5*before); }

static lw_status close_loops(lw_tree_stages *s)
{
    enum { PLACES = 12, SPEEDS = 6 };
    const double rounding = 4e-16*(s->n_u + 4);
    double *dx = s->dy, *du = dx + 8*s->n_x, *u = s->y + 8*s->n_x, off = INFINITY, before, most = 0;
    for (int pass = 0; pass < PLACES; pass++) {
        before = off;
        memset(du, 0, 8*(size_t)s->n_u*sizeof *du);
        off = close_once(s, before < nearly_closed, false, du);
        if (!(off < far_open))
            return LW_OPEN;
        if (is_rounding(off, before, rounding))
            break;
        motion_of(s, s->y, du, dx);
        for (int i = 0; i < 8*s->n_x; i++)
            s->y[i] += dx[i];
    }
    for (int i = 0; i < 8*s->n_u; i++)
        most = fmax(most, fabs(u[i]));
    before = INFINITY;
    for (int pass = 0; off <= closed && pass < SPEEDS; pass++) {
        double rate = close_once(s, true, true, u);
        if (is_rounding(rate, before, rounding*most))
            break;
        before = rate;
    }
    return off <= closed ? LW_OK : LW_OPEN;
}

lw_status lw_tree_stages_moments(lw_tree_stages *s, bool open, int n)
{
    bool screws = false;
    for (int i = 0; i < s->n_body; i++)
        screws = screws || s->body[i].kind == LW_SPATIAL_SCREW;
    if (screws || s->n_kept < s->n_row)
        return LW_E_KIND;
    if ((open && s->n_loop > 0 && close_loops(s) != LW_OK) || lw_tree_stages_rates(s, false, s->y, s->dy) != LW_OK)
        return LW_OPEN;
    s->kernel->moments(s, n, s->moment);
    return LW_OK;
}

/* mbs/space/recursive_stages.c - a tree and its loops made ready for the kernels of eight states. */
#include "base/real.h"
#include "mbs/space/kernel_tree_internal.h"

#include <stdlib.h>
#include <string.h>

static const double near = 0.03;             /* coordinates [rad, sizes] that states move while the factors serve, */
static const double weak_loops = 0.01;       /* less where the least pivot of the loops is below this */

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

static bool suits(const lw_recursive *r, const lw_space_forces *f)
{
    const lw_spatial *m = r->s->model;
    bool stops = false, laws = false, screws = false;
    for (int i = 0; i < m->n_joint; i++)
        stops = stops || m->joint[i].stop.has_least || m->joint[i].stop.has_greatest;
    for (int i = 0; i < m->n_spring; i++)
        laws = laws || m->spring[i].law;
    for (int i = 0; i < r->n_cut; i++)
        screws = screws || r->s->joint[r->cut[i]].kind == LW_SPATIAL_SCREW;
    return !stops && !laws && !screws && !f->held && m->n_joint_spring + m->n_force + m->n_motor + m->n_beam + m->n_super == 0
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
    *b = (lw_stage_body){ .parent = p->parent, .kind = p->kind, .back = p->back, .x = p->x, .u = p->u, .n_u = p->n_u, .leaf = true,
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
        row[n++] = (lw_stage_row){ .kind = LW_STAGE_TURN, .a = j->x[0], .b = j->x[1] };
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

static void put_loop(const lw_recursive *r, int cut, lw_tree_stages *s)
{
    const lw_space_joint *j = &r->s->joint[r->cut[cut]];
    lw_stage_loop *p = &s->loop[cut];
    int n = 0;
    *p = (lw_stage_loop){ .path = p->path };
    for (int k = 0; k < 2; k++) {
        p->body[k] = j->body[k] < 0 ? -1 : r->place[j->body[k]];
        p->arm[k] = lw_v3_scale(j->arm[k], 1/r->s->unit);
    }
    p->n_row = put_rows(j, p->row);
    for (int k = 0; k < 3; k++)
        n += p->n_path[k] = walk(s, p, k, p->path + n);
    for (int i = 0; i < n; i++) {
        const lw_stage_body *b = &s->body[p->path[i]];
        for (int k = b->u; k < b->u + b->n_u; k++)
            p->rates |= 1ULL << k;
    }
}

void lw_tree_stages_keep_rows(lw_tree_stages *s, const lw_recursive *r)
{
    s->n_kept = r->rank;
    for (int i = 0; i < s->n_loop; i++)
        for (int k = 0; k < s->loop[i].n_row; k++)
            s->loop[i].row[k].at = -1;
    for (int i = 0; i < s->n_kept; i++) {
        lw_stage_loop *p = s->loop;
        int row = r->order[i];
        for (; row >= p->n_row; p++)
            row -= p->n_row;
        p->row[row].at = i;
    }
}

lw_status lw_tree_stages_make(const lw_recursive *r, const lw_space_forces *f, bool has_work, lw_tree_stages *s)
{
    const lw_spatial *m = r->s->model;
    size_t bodies = (size_t)r->s->n_body, u = (size_t)r->n_u, springs = (size_t)m->n_spring, loops = (size_t)r->n_cut;
    const lw_kernels *best = lw_kernels_supported(0);
    *s = (lw_tree_stages){ .n_body = r->s->n_body, .n_x = r->n_x, .n_u = r->n_u, .n_row = r->n_row, .n_spring = m->n_spring, .n_loop = r->n_cut,
                           .has_work = has_work, .unit = r->s->unit, .turns = best->turns, .isa = best->isa,
                           .kernel = lw_tree_kernel_of(best->isa) };
    if (!suits(r, f))
        return LW_E_KIND;
    size_t state = lw_tree_state_size(8, r->s->n_body, r->n_u, r->n_row);
    char *at = s->memory = malloc(state + LW_SCRATCH_ALIGNMENT + bodies*sizeof *s->body + springs*sizeof *s->spring + loops*sizeof *s->loop
                                     + (3*8*(u + 1) + 8*(size_t)r->n_x)*sizeof(double) + (u + 1 + loops*bodies)*sizeof(int));
    if (!at)
        return LW_E_MEMORY;
    s->state = lw_scratch_align(at), at = (char *)s->state + state;
    s->body = (lw_stage_body *)(void *)at, at += bodies*sizeof *s->body;
    s->spring = (lw_stage_spring *)(void *)at, at += springs*sizeof *s->spring;
    s->loop = (lw_stage_loop *)(void *)at, at += loops*sizeof *s->loop;
    s->angle = (double *)(void *)at, s->cosine = s->angle + 8*(u + 1), s->sine = s->cosine + 8*(u + 1);
    s->factored = s->sine + 8*(u + 1);
    s->turn = (int *)(void *)(s->factored + 8*s->n_x);
    for (size_t i = 0; i < loops; i++)
        s->loop[i].path = s->turn + u + 1 + i*bodies;
    for (int i = 0; i < s->n_body; i++)
        put_body(r, f, i, s);
    for (int i = s->n_body - 1; i >= 0; i--)
        if (s->body[i].parent >= 0) {
            lw_stage_body *parent = &s->body[s->body[i].parent];
            s->body[i].last_child = parent->leaf;
            parent->leaf = false;
        }
    for (int i = 0; i < s->n_loop; i++)
        put_loop(r, i, s);
    for (int i = 0; i < s->n_spring; i++) {
        const lw_spatial_spring *p = &m->spring[i];
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

/* Are all states near those of the factors? */
static bool is_near(const lw_tree_stages *s, const double *y)
{
    double far[8] = { 0 }, most = 0;
    for (int i = 0; i < 8*s->n_x; i += 8)
        for (int k = 0; k < 8; k++) {
            double off = fabs(y[i + k] - s->factored[i + k]);
            far[k] = off > far[k] ? off : far[k];
        }
    for (int k = 0; k < 8; k++)
        most = far[k] > most ? far[k] : most;
    return most <= near*fmin(1, s->weak/weak_loops);
}

lw_status lw_tree_stages_rates(lw_tree_stages *s, bool again, const double *y, double *dy)
{
    again = again && s->n_kept == s->n_row && is_near(s, y);
    if (!again)
        memcpy(s->factored, y, 8*(size_t)s->n_x*sizeof *y);
    for (int i = 0; i < s->n_angle; i++)
        for (int k = 0; k < 8; k++)
            s->angle[8*i + k] = 0.5*y[8*s->turn[i] + k];
    s->turns(8*(size_t)s->n_angle, s->angle, s->cosine, s->sine);
    double weak = s->kernel->rates(s, again, y, dy);
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

void lw_tree_stages_motion(const lw_tree_stages *s, const double *y, double *dx)
{
    for (int i = 0; i < s->n_body; i++) {
        const lw_stage_body *b = &s->body[i];
        const double *u = y + 8*(s->n_x + b->u);
        int n = b->n_x > b->n_u ? b->n_u - 3 : b->n_u;
        memcpy(dx + 8*b->x, u, 8*(size_t)n*sizeof *dx);
        if (n < b->n_u)
            turn_rates(u + 8*n, y + 8*(b->x + n), dx + 8*(b->x + n));
    }
}

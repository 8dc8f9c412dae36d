#include "mbs/equations/flying.h"

#include <stdlib.h>
#include <string.h>
#include "base/union_find.h"

static void join(int *parent, int a, int b)
{
    parent[lw_root_of(parent, a)] = lw_root_of(parent, b);
}

/* Join the links of everything that acts between two links, or on one from the ground. */
static void join_links(const lw_spatial *m, int *parent)
{
    for (int j = 0; j < m->n_joint; j++)
        if (m->joint[j].kind != LW_SPATIAL_FREE || m->joint[j].opened)
            join(parent, m->joint[j].link[0], m->joint[j].link[1]);
    for (int i = 0; i < m->n_spring; i++)
        join(parent, m->spring[i].link[0], m->spring[i].link[1]);
    for (int i = 0; i < m->n_beam; i++)
        join(parent, m->beam[i].link[0], m->beam[i].link[1]);
    for (int i = 0; i < m->n_super; i++)
        for (int k = 1; k < m->super[i].n; k++)
            join(parent, m->super[i].link[0], m->super[i].link[k]);
    for (int i = 0; i < m->n_force; i++)
        join(parent, m->force[i].link, m->ground);
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].measure.of >= LW_OF_X)
            join(parent, m->tracer[m->input[i].measure.index].link, m->ground);
    for (int i = 0; i < m->states.n_rotor; i++)
        join(parent, m->states.rotor[i].link, m->ground);
}

lw_status lw_flying_make(const lw_space *s, lw_flying *f, lw_error *e)
{
    const lw_spatial *m = s->model;
    size_t links = (size_t)m->n_link + 1, bodies = (size_t)s->n_body + 1;
    int *parent = malloc(2*links*sizeof *parent), *number = parent ? parent + links : NULL;
    *f = (lw_flying){ .group = malloc(bodies*sizeof *f->group), .kept = calloc(bodies, sizeof *f->kept), .now = calloc(bodies, sizeof *f->now) };
    bool room = parent && f->group && f->kept && f->now;
    for (int i = 0; room && i < m->n_link; i++)
        parent[i] = i, number[i] = -1;
    if (room)
        join_links(m, parent);
    for (int b = 0; room && b < s->n_body; b++) {
        int root = lw_root_of(parent, s->link_of[b]);
        if (number[root] < 0 && root != lw_root_of(parent, m->ground))
            number[root] = f->n++;
        f->group[b] = number[root];
    }
    free(parent);
    return room ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void lw_flying_free(lw_flying *f)
{
    free(f->group), free(f->kept), free(f->now);
    *f = (lw_flying){ 0 };
}

/* Masses, centres, inertias and momenta of all groups. */
static void find(const lw_space_forces *forces, const lw_space_frame *frame, const double *v, const lw_flying *f, lw_flying_group *out)
{
    const lw_space *s = forces->s;
    lw_super_whole w;
    memset(out, 0, (size_t)f->n*sizeof *out);
    for (int b = 0; b < s->n_body; b++)
        if (f->group[b] >= 0) {
            lw_flying_group *g = &out[f->group[b]];
            double mass = s->mass[6*b]/(s->unit*s->unit);
            g->mass += mass;
            g->centre = lw_v3_add(g->centre, lw_v3_scale(frame[b + 1].at, mass));
            g->linear = lw_v3_add(g->linear, lw_v3_scale(lw_v3(v[6*b], v[6*b + 1], v[6*b + 2]), s->unit*mass));
            g->bodies++, g->body = b;
        }
    for (int i = 0; i < s->model->n_super; i++) {
        int group = f->group[s->body_of[s->model->super[i].link[0]]];
        if (group < 0)
            continue;
        lw_space_super_whole(forces, frame, v, i, lw_v3(0, 0, 0), &w);
        out[group].centre = lw_v3_add(out[group].centre, w.first);
        out[group].linear = lw_v3_add(out[group].linear, w.linear);
    }
    for (int i = 0; i < f->n; i++)
        out[i].centre = lw_v3_scale(out[i].centre, 1/out[i].mass);
    for (int b = 0; b < s->n_body; b++)
        if (f->group[b] >= 0) {
            lw_flying_group *g = &out[f->group[b]];
            const double *own = s->mass + 6*b, *u = v + 6*b;
            double mass = own[0]/(s->unit*s->unit);
            lw_vec3 d = lw_v3_sub(frame[b + 1].at, g->centre), speed = lw_v3_scale(lw_v3(u[0], u[1], u[2]), s->unit);
            lw_vec3 spin = lw_m3_apply(&frame[b + 1].turn, lw_v3(own[3]*u[3], own[4]*u[4], own[5]*u[5]));
            g->spin += own[3]*u[3]*u[3] + own[4]*u[4]*u[4] + own[5]*u[5]*u[5];
            g->angular = lw_v3_add(g->angular, lw_v3_add(spin, lw_v3_scale(lw_v3_cross(d, speed), mass)));
            const double far[6] = { d.y*d.y + d.z*d.z, d.x*d.x + d.z*d.z, d.x*d.x + d.y*d.y, -d.x*d.y, -d.x*d.z, -d.y*d.z };
            for (int k = 0; k < 6; k++) {
                static const int row[6] = { 0, 1, 2, 0, 0, 1 }, column[6] = { 0, 1, 2, 1, 2, 2 };
                const double *r = &frame[b + 1].turn.row[row[k]].x, *c = &frame[b + 1].turn.row[column[k]].x;
                g->inertia[k] += mass*far[k] + r[0]*own[3]*c[0] + r[1]*own[4]*c[1] + r[2]*own[5]*c[2];
            }
        }
    for (int i = 0; i < s->model->n_super; i++) {
        int group = f->group[s->body_of[s->model->super[i].link[0]]];
        if (group < 0)
            continue;
        lw_space_super_whole(forces, frame, v, i, out[group].centre, &w);
        out[group].angular = lw_v3_add(out[group].angular, w.angular);
        for (int k = 0; k < 6; k++)
            out[group].inertia[k] += w.inertia[k];
    }
}

void lw_flying_note(const lw_space_forces *forces, const lw_space_frame *frame, const double *v, double t, lw_flying *f)
{
    find(forces, frame, v, f, f->kept);
    f->since = t;
}

/* Angular velocity of a rigid group with this angular momentum; about an axis without inertia 0. */
static lw_vec3 turn_of(const double inertia[6], lw_vec3 angular)
{
    double moment[3], part[3];
    lw_mat3 axes;
    lw_m3_principal(inertia, moment, &axes);
    lw_vec3 own = lw_m3_unapply(&axes, angular);
    const double l[3] = { own.x, own.y, own.z }, most = fmax(moment[0], fmax(moment[1], moment[2]));
    for (int i = 0; i < 3; i++)
        part[i] = moment[i] > 1e-12*most ? l[i]/moment[i] : 0;
    return lw_m3_apply(&axes, lw_v3(part[0], part[1], part[2]));
}

/* A body with principal inertias j and angular momentum L, own: L in its axes, has the energy sum of own_i^2/(2 j_i); a small turn by
 * a changes it by a . (w x own), w_i = own_i/j_i.  No turn where it spins about a principal axis. */
static void turn_to_energy(const double *j, lw_vec3 angular, double twice, double *q, lw_space_frame *frame)
{
    for (int pass = 0; pass < 2; pass++) {
        lw_vec3 own = lw_m3_unapply(&frame->turn, angular), w = lw_v3(own.x/j[0], own.y/j[1], own.z/j[2]);
        lw_vec3 way = lw_v3_cross(w, own);
        double square = lw_v3_dot(way, way), missing = 0.5*(twice - lw_v3_dot(own, w));
        if (!(square > 1e-12*lw_v3_dot(own, own)*lw_v3_dot(w, w)))
            return;
        lw_quaternion turn = { q[0], q[1], q[2], q[3] };
        turn = lw_quaternion_unit(lw_quaternion_times(turn, lw_quaternion_of_vector(lw_v3_scale(way, missing/square))));
        q[0] = turn.w, q[1] = turn.x, q[2] = turn.y, q[3] = turn.z;
        frame->turn = lw_quaternion_matrix(turn);
    }
}

void lw_flying_hold(const lw_space_forces *forces, double t, double *q, lw_space_frame *frame, double *v, double *rigid, lw_flying *f)
{
    const lw_space *s = forces->s;
    find(forces, frame, v, f, f->now);
    for (int i = 0; i < f->n; i++)
        if (f->now[i].bodies == 1) {
            int b = f->now[i].body;
            turn_to_energy(s->mass + 6*b + 3, f->kept[i].angular, f->kept[i].spin, q + 7*b + 3, &frame[b + 1]);
        }
    find(forces, frame, v, f, f->now);
    memset(rigid, 0, (size_t)s->n_v*sizeof *rigid);
    for (int i = 0; i < f->n; i++) {         /* `now` becomes velocities of the group: kept, and what they lack; centre stays */
        lw_flying_group *now = &f->now[i];
        const lw_flying_group *kept = &f->kept[i];
        lw_vec3 weight = lw_v3_scale(s->model->gravity, now->mass*(t - f->since)), wanted = lw_v3_add(kept->linear, weight);
        lw_vec3 turn = turn_of(now->inertia, kept->angular), lacks = turn_of(now->inertia, lw_v3_sub(kept->angular, now->angular));
        lw_vec3 speed = lw_v3_scale(wanted, 1/now->mass), slow = lw_v3_scale(lw_v3_sub(wanted, now->linear), 1/now->mass);
        for (int b = 0; b < s->n_body; b++) {
            if (f->group[b] != i)
                continue;
            lw_vec3 d = lw_v3_sub(frame[b + 1].at, now->centre);
            lw_vec3 part[4] = { lw_v3_add(speed, lw_v3_cross(turn, d)), lw_m3_unapply(&frame[b + 1].turn, turn),
                                lw_v3_add(slow, lw_v3_cross(lacks, d)), lw_m3_unapply(&frame[b + 1].turn, lacks) };
            for (int k = 0; k < 4; k++) {
                double *to = (k < 2 ? rigid : v) + 6*b + 3*(k%2), scale = k%2 ? 1 : 1/s->unit;
                to[0] += scale*part[k].x, to[1] += scale*part[k].y, to[2] += scale*part[k].z;
            }
        }
    }
}

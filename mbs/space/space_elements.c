/* mbs/space/space_elements.c - elastic elements of a spatial model: beams between two nodes, superelements of several. */
#include "mbs/space/space_forces.h"

#include <stdlib.h>
#include <string.h>

/* The element with its axes in those of its nodes. */
static void make_beam(const lw_space *s, const lw_spatial_beam *p, lw_beam_space *out)
{
    *out = (lw_beam_space){ .length = p->length, .damping = p->damping };
    memcpy(out->stiffness, p->stiffness, sizeof out->stiffness);
    for (int k = 0; k < 2; k++) {
        lw_mat3 turn = lw_quaternion_matrix(s->axes[s->body_of[p->link[k]]]);
        out->axes[k] = lw_m3_columns(lw_m3_unapply(&turn, lw_m3_column(&p->axes, 0)), lw_m3_unapply(&turn, lw_m3_column(&p->axes, 1)),
                                     lw_m3_unapply(&turn, lw_m3_column(&p->axes, 2)));
    }
}

lw_status lw_space_elements_make(const lw_space *s, lw_space_forces *f, lw_error *e)
{
    const lw_spatial *m = s->model;
    size_t most = 1;
    for (int i = 0; i < m->n_beam; i++) {
        make_beam(s, &m->beam[i], &f->beam[i]);
        f->conservative = f->conservative && m->beam[i].damping == 0;
    }
    f->super = calloc((size_t)m->n_super + 1, sizeof *f->super);
    for (int i = 0; i < m->n_super; i++)
        most = (size_t)m->super[i].n > most ? (size_t)m->super[i].n : most;
    f->super_work = calloc(6*most + 72*most*most + most*(sizeof(lw_beam_node)/sizeof(double) + 1), sizeof(double));
    lw_mat3 *turn = calloc(most, sizeof *turn);
    lw_status st = f->super && f->super_work && turn ? LW_OK : LW_E_MEMORY;
    for (int i = 0; st == LW_OK && i < m->n_super; i++) {
        for (int k = 0; k < m->super[i].n; k++)
            turn[k] = lw_quaternion_matrix(s->axes[s->body_of[m->super[i].link[k]]]);
        st = lw_super_make(&m->super[i], turn, m->gravity, &f->super[f->n_super++]);
        f->conservative = f->conservative && m->super[i].damping == 0;
    }
    free(turn);
    return st == LW_OK ? st : lw_error_set(e, st, "out of memory");
}

void lw_space_add_element(const lw_space *s, const lw_space_frame *frame, int n, const int *body, const double *load,
                          const double *by_x, const double *by_v, double *force, const lw_space_sink *sink)
{
    for (int i = 0; i < n; i++) {
        if (body[i] < 0)
            continue;
        const double *l = load + 6*i;
        const lw_mat3 *turn = &frame[body[i] + 1].turn;
        lw_vec3 own = lw_m3_unapply(turn, lw_v3(l[3], l[4], l[5]));
        double *to = force + 6*body[i];
        to[0] += s->unit*l[0], to[1] += s->unit*l[1], to[2] += s->unit*l[2];
        to[3] += own.x, to[4] += own.y, to[5] += own.z;
        for (int j = 0; sink && j < n; j++)
            for (int c = 0; c < 6 && body[j] >= 0; c++) {
                /* a coordinate of body j is a displacement by `unit`, or a turn about one of its own axes */
                lw_vec3 axis = c < 3 ? lw_v3_scale(lw_v3(c == 0, c == 1, c == 2), s->unit) : lw_m3_column(&frame[body[j] + 1].turn, c - 3);
                const double along[3] = { axis.x, axis.y, axis.z };
                double column[2][6];
                for (int way = 0; way < 2; way++) {
                    const double *from = way ? by_v : by_x;
                    double d[6] = { 0 };
                    for (int a = 0; a < 6; a++)
                        for (int k = 0; k < 3; k++)
                            d[a] += from[(6*i + a)*6*n + 6*j + (c < 3 ? k : 3 + k)]*along[k];
                    lw_vec3 m = lw_m3_unapply(turn, lw_v3(d[3], d[4], d[5]));
                    if (way == 0 && i == j && c >= 3)
                        m = lw_v3_add(m, lw_v3_cross(own, lw_v3(c == 3, c == 4, c == 5)));
                    const double out[6] = { s->unit*d[0], s->unit*d[1], s->unit*d[2], m.x, m.y, m.z };
                    memcpy(column[way], out, sizeof out);
                }
                for (int a = 0; a < 6; a++)
                    sink->add(sink->context, 6*body[i] + a, 6*body[j] + c, column[0][a], column[1][a]);
            }
    }
}

void lw_space_beam(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i, bool derivatives,
                   lw_beam_space_state *out)
{
    const lw_space *s = f->s;
    lw_beam_node node[2];
    for (int k = 0; k < 2; k++) {
        int b = s->body_of[s->model->beam[i].link[k]];
        lw_space_point centre = { b, { 0, 0, 0 } };
        node[k] = (lw_beam_node){ frame[b + 1].at, frame[b + 1].turn, lw_space_point_velocity(s, frame, centre, v),
                                  lw_space_omega(frame, b, v) };
    }
    lw_beam_space_at(&f->beam[i], node, derivatives, isnan(f->pull[i]) ? NULL : &f->pull[i], out);
    /* Derivatives of forces hold where velocity coordinates stay, which turn with the node. */
    for (int k = 0; k < 2 && derivatives && f->beam[i].damping > 0; k++)
        for (int c = 0; c < 3; c++) {
            lw_vec3 by = lw_v3_cross(lw_v3(c == 0, c == 1, c == 2), node[k].omega);
            for (int a = 0; a < 12; a++) {
                const double *w = &out->by_v[a][6*k + 3];
                out->by_x[a][6*k + 3 + c] += w[0]*by.x + w[1]*by.y + w[2]*by.z;
            }
        }
}

void lw_space_foresee(const lw_space_forces *f, const lw_space_frame *frame, const double *by)
{
    lw_beam_space_state z;
    for (int i = 0; i < f->s->model->n_beam; i++) {
        if (by)
            lw_space_beam(f, frame, by, i, false, &z);
        f->pull[i] = by ? f->beam[i].stiffness[0]*(z.stretch + z.stretch_rate) : NAN;
    }
}

/* Nodes of a superelement at one moment, behind the matrices of the scratch; v NULL: at rest. */
static lw_beam_node *super_nodes(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i)
{
    const lw_space *s = f->s;
    const lw_superelement *p = &s->model->super[i];
    lw_beam_node *node = (lw_beam_node *)(void *)(f->super_work + 6*p->n + 72*p->n*p->n);
    for (int k = 0; k < p->n; k++) {
        int b = s->body_of[p->link[k]];
        node[k] = (lw_beam_node){ .at = frame[b + 1].at, .turn = frame[b + 1].turn };
        if (v) {
            node[k].v = lw_v3_scale(lw_v3(v[6*b], v[6*b + 1], v[6*b + 2]), s->unit);
            node[k].omega = lw_space_omega(frame, b, v);
        }
    }
    return node;
}

void lw_space_push_elements(const lw_space_forces *f, const lw_space_frame *frame, const double *v, double *force, double *power,
                            const lw_space_sink *sink)
{
    const lw_space *s = f->s;
    for (int i = 0; i < s->model->n_beam; i++) {
        const lw_spatial_beam *p = &s->model->beam[i];
        lw_beam_space_state at;
        lw_space_beam(f, frame, v, i, sink != NULL, &at);
        lw_space_add_element(s, frame, 2, (const int[2]){ s->body_of[p->link[0]], s->body_of[p->link[1]] }, at.force,
                             &at.by_x[0][0], &at.by_v[0][0], force, sink);
        *power += at.power;
    }
    for (int i = 0; i < s->model->n_super; i++) {
        const lw_superelement *p = &s->model->super[i];
        lw_beam_node *node = super_nodes(f, frame, v, i);
        double *load = f->super_work, *by_x = load + 6*p->n, *by_v = by_x + 36*p->n*p->n, own;
        int body[LW_SUPER_NODES];
        for (int k = 0; k < p->n; k++)
            body[k] = s->body_of[p->link[k]];
        lw_super_at(&f->super[i], node, load, sink ? by_x : NULL, by_v, &own);
        lw_space_add_element(s, frame, p->n, body, load, by_x, by_v, force, sink);
        *power += own;
    }
}

double lw_space_elements_energy(const lw_space_forces *f, const lw_space_frame *frame, double energy)
{
    const lw_space *s = f->s;
    double power;
    for (int i = 0; i < s->model->n_beam; i++) {
        lw_beam_node node[2];
        for (int k = 0; k < 2; k++) {
            const lw_space_frame *p = &frame[s->body_of[s->model->beam[i].link[k]] + 1];
            node[k] = (lw_beam_node){ .at = p->at, .turn = p->turn };
        }
        lw_beam_space_state z;
        lw_beam_space_at(&f->beam[i], node, false, NULL, &z);
        energy += z.energy;
    }
    for (int i = 0; i < s->model->n_super; i++)
        energy += lw_super_at(&f->super[i], super_nodes(f, frame, NULL, i), f->super_work, NULL, NULL, &power);
    return energy;
}

double lw_space_strain(const lw_space_forces *f, const lw_space_frame *frame)
{
    double energy = lw_space_elements_energy(f, frame, 0);
    for (int i = 0; i < f->s->model->n_super; i++) {
        const lw_super *p = &f->super[i];
        const lw_superelement *given = &f->s->model->super[i];
        const lw_beam_node *node = super_nodes(f, frame, NULL, i);
        double mass = 0;
        for (int k = 0; k < given->n; k++)
            mass += given->lump[k];
        energy += lw_v3_dot(p->gravity, lw_v3_add(lw_v3_scale(node[p->a].at, mass), lw_super_moment(p, node)));
    }
    return energy;
}

/* Entries of the mass matrix m (6n x 6n), by displacements and turns of n nodes in the axes of a frame. */
static void add_mass(const lw_space *s, const lw_space_frame *frame, const lw_mat3 *axes, int n, const int *link, const double *m,
                     const lw_space_sink *sink)
{
    for (int i = 0; i < 2*n; i++)
        for (int j = 0; j < 2*n; j++) {
            double to[2][3][3];                  /* a coordinate's motion in the frame */
            int body[2] = { s->body_of[link[i/2]], s->body_of[link[j/2]] };
            for (int side = 0; side < 2; side++)
                for (int c = 0; c < 3; c++) {
                    lw_vec3 e = lw_v3(c == 0, c == 1, c == 2);
                    e = lw_m3_unapply(axes, (side ? j : i)%2 ? lw_m3_apply(&frame[body[side] + 1].turn, e) : lw_v3_scale(e, s->unit));
                    to[side][0][c] = e.x, to[side][1][c] = e.y, to[side][2][c] = e.z;
                }
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++) {
                    double all = 0;
                    for (int x = 0; x < 3; x++)
                        for (int y = 0; y < 3; y++)
                            all += to[0][x][a]*m[(3*i + x)*6*n + 3*j + y]*to[1][y][b];
                    sink->add(sink->context, 6*body[0] + 3*(i%2) + a, 6*body[1] + 3*(j%2) + b, all, 0);
                }
        }
}

/* The inertia j (as lw_spatial_body's) of a node by its angular velocity or acceleration w, ground axes. */
static lw_vec3 node_spin(const lw_space *s, const lw_space_frame *frame, int b, const double *j, lw_vec3 w)
{
    const lw_mat3 inertia = { { { j[0], j[3], j[4] }, { j[3], j[1], j[5] }, { j[4], j[5], j[2] } } }, start = lw_quaternion_matrix(s->axes[b]);
    lw_vec3 own = lw_m3_apply(&start, lw_m3_unapply(&frame[b + 1].turn, w));
    return lw_m3_apply(&frame[b + 1].turn, lw_m3_unapply(&start, lw_m3_apply(&inertia, own)));
}

bool lw_space_more_mass(const lw_space_forces *f, const lw_space_frame *frame, const lw_space_sink *sink)
{
    const lw_space *s = f->s;
    const lw_spatial *model = s->model;
    bool any = model->n_super > 0;
    for (int i = 0; i < model->n_beam; i++) {
        const lw_spatial_beam *p = &model->beam[i];
        lw_beam_node node[2];
        lw_beam_space_state z;
        double m[12][12];
        any = any || p->consistent;
        if (!p->consistent || !sink)
            continue;
        for (int k = 0; k < 2; k++) {
            const lw_space_frame *at = &frame[s->body_of[p->link[k]] + 1];
            node[k] = (lw_beam_node){ .at = at->at, .turn = at->turn };
        }
        lw_beam_space_at(&f->beam[i], node, false, NULL, &z);
        lw_beam_space_mass(p, m);
        add_mass(s, frame, &z.frame, 2, p->link, &m[0][0], sink);
    }
    for (int i = 0; sink && i < model->n_super; i++) {
        const lw_superelement *p = &model->super[i];
        const lw_mat3 ground = lw_m3_columns(lw_v3(1, 0, 0), lw_v3(0, 1, 0), lw_v3(0, 0, 1));
        int rows = 6*p->n;
        double *m = f->super_work;
        lw_super_mass(&f->super[i], super_nodes(f, frame, NULL, i), m);
        for (int k = 0; k < p->n; k++) {         /* less what the nodes have */
            int b = s->body_of[p->link[k]];
            for (int c = 0; c < 3; c++) {
                lw_vec3 spin = node_spin(s, frame, b, p->turning + 6*k, lw_v3(c == 0, c == 1, c == 2));
                double *to = m + (6*k + 3 + c)*rows + 6*k + 3;
                to[0] -= spin.x, to[1] -= spin.y, to[2] -= spin.z;
                m[(6*k + c)*(rows + 1)] -= p->lump[k];
            }
        }
        add_mass(s, frame, &ground, p->n, p->link, m, sink);
    }
    return any;
}

const double *lw_space_super(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i)
{
    double power;
    lw_super_at(&f->super[i], super_nodes(f, frame, v, i), f->super_work, NULL, NULL, &power);
    return f->super_work;
}

const double *lw_space_super_inertia(const lw_space_forces *f, const lw_space_frame *frame, const double *v, const double *a, int i)
{
    const lw_space *s = f->s;
    const lw_superelement *p = &s->model->super[i];
    lw_vec3 *rate = (lw_vec3 *)(void *)(f->super_work + 6*p->n);
    const lw_beam_node *node = super_nodes(f, frame, v, i);
    for (int k = 0; k < p->n; k++) {
        int b = s->body_of[p->link[k]];
        rate[2*k] = lw_v3_scale(lw_v3(a[6*b], a[6*b + 1], a[6*b + 2]), s->unit);
        rate[2*k + 1] = lw_space_omega(frame, b, a);
    }
    lw_super_inertia(&f->super[i], node, rate, f->super_work, NULL);
    return f->super_work;
}

double lw_space_more_inertia(const lw_space_forces *f, const lw_space_frame *frame, const double *v, const double *a, double *out)
{
    const lw_space *s = f->s;
    double energy = 0;
    for (int i = 0; i < s->model->n_super; i++) {
        const lw_superelement *p = &s->model->super[i];
        double *load = f->super_work;
        if (a)
            lw_space_super_inertia(f, frame, v, a, i);
        else
            energy += lw_super_inertia(&f->super[i], super_nodes(f, frame, v, i), NULL, NULL, load);
        for (int k = 0; k < p->n; k++) {
            int b = s->body_of[p->link[k]];
            const double *x = a ? a : v, *by = load + 6*k, m = p->lump[k]*s->unit;
            lw_vec3 omega = lw_space_omega(frame, b, v), spin = node_spin(s, frame, b, p->turning + 6*k, omega);
            lw_vec3 turn = lw_v3_sub(lw_v3(by[3], by[4], by[5]), a ? lw_v3_cross(omega, spin) : spin);
            if (a)
                turn = lw_v3_sub(turn, node_spin(s, frame, b, p->turning + 6*k, lw_space_omega(frame, b, a)));
            else
                energy -= 0.5*(m*s->unit*(v[6*b]*v[6*b] + v[6*b + 1]*v[6*b + 1] + v[6*b + 2]*v[6*b + 2]) + lw_v3_dot(spin, omega));
            turn = lw_m3_unapply(&frame[b + 1].turn, turn);
            for (int c = 0; out && c < 3; c++)
                out[6*b + c] += s->unit*(by[c] - m*x[6*b + c]);
            if (out)
                out[6*b + 3] += turn.x, out[6*b + 4] += turn.y, out[6*b + 5] += turn.z;
        }
    }
    return energy;
}

void lw_space_super_whole(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i, lw_vec3 about, lw_super_whole *out)
{
    static const int row[6] = { 0, 1, 2, 0, 0, 1 }, column[6] = { 0, 1, 2, 1, 2, 2 };
    const lw_space *s = f->s;
    const lw_superelement *p = &s->model->super[i];
    lw_beam_node *node = super_nodes(f, frame, v, i);
    double total = 0, spin[3][3];
    *out = (lw_super_whole){ .first = lw_super_moment(&f->super[i], node) };
    for (int k = 0; k < p->n; k++) {
        total += p->lump[k];
        out->first = lw_v3_sub(out->first, lw_v3_scale(lw_v3_sub(node[k].at, about), p->lump[k]));
    }
    out->first = lw_v3_add(out->first, lw_v3_scale(lw_v3_sub(node[f->super[i].a].at, about), total));
    for (int turn = -1; turn < 3; turn++) {      /* as it moves; as a rigid body that turns about an axis */
        lw_vec3 axis = lw_v3(turn == 0, turn == 1, turn == 2), linear = { 0, 0, 0 }, angular = { 0, 0, 0 };
        for (int k = 0; turn >= 0 && k < p->n; k++)
            node[k].v = lw_v3_cross(axis, lw_v3_sub(node[k].at, about)), node[k].omega = axis;
        lw_super_inertia(&f->super[i], node, NULL, NULL, f->super_work);
        for (int k = 0; k < p->n; k++) {
            const double *m = f->super_work + 6*k;
            lw_vec3 push = lw_v3_sub(lw_v3(m[0], m[1], m[2]), lw_v3_scale(node[k].v, p->lump[k]));
            lw_vec3 own = lw_v3_sub(lw_v3(m[3], m[4], m[5]), node_spin(s, frame, s->body_of[p->link[k]], p->turning + 6*k, node[k].omega));
            linear = lw_v3_add(linear, push);
            angular = lw_v3_add(angular, lw_v3_add(own, lw_v3_cross(lw_v3_sub(node[k].at, about), push)));
        }
        if (turn < 0)
            out->linear = linear, out->angular = angular;
        else
            spin[turn][0] = angular.x, spin[turn][1] = angular.y, spin[turn][2] = angular.z;
    }
    for (int k = 0; k < 6; k++)
        out->inertia[k] = spin[row[k]][column[k]];
}

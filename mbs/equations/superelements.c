/* mbs/equations/superelements.c - superelements in the plane. */
#include "mbs/equations/superelements.h"

#include <stdlib.h>
#include <string.h>

static const int plane[3] = { 0, 1, 5 };         /* of the six coordinates of a node */

static double scale(const lw_superelements *x, int c) { return c == 2 ? 1 : x->system->unit; }

lw_status lw_superelements_make(const lw_model *m, const lw_system *s, lw_superelements *x)
{
    size_t most = 0, n_q = (size_t)s->n_q;
    *x = (lw_superelements){ .system = s, .given = m->super };
    if (m->n_super == 0)
        return LW_OK;
    for (int i = 0; i < m->n_super; i++)
        most = (size_t)m->super[i].n > most ? (size_t)m->super[i].n : most;
    lw_mat3 *turn = calloc(most, sizeof *turn);
    x->super = calloc((size_t)m->n_super, sizeof *x->super);
    x->work = calloc(6*most + 72*most*most + most*(sizeof(lw_beam_node)/sizeof(double) + 1) + 6*most, sizeof *x->work);
    x->placed = calloc(2*n_q, sizeof *x->placed), x->out = x->placed ? x->placed + n_q : NULL;
    lw_status st = turn && x->super && x->work && x->placed ? LW_OK : LW_E_MEMORY;
    for (size_t i = 0; st == LW_OK && i < most; i++)
        turn[i] = lw_m3_columns(lw_v3(1, 0, 0), lw_v3(0, 1, 0), lw_v3(0, 0, 1));
    for (int i = 0; st == LW_OK && i < m->n_super; i++)
        st = lw_super_make(&m->super[i], turn, lw_v3(m->gravity.x, m->gravity.y, 0), &x->super[x->n++]);
    free(turn);
    for (int b = 0; st == LW_OK && b < s->n_body; b++)
        x->placed[3*b] = s->reference[b].x, x->placed[3*b + 1] = s->reference[b].y;
    x->start = st == LW_OK ? lw_superelements_potential(x, x->placed) : 0;
    return st;
}

void lw_superelements_free(lw_superelements *x)
{
    for (int i = 0; i < x->n; i++)
        lw_super_free(&x->super[i]);
    free(x->super), free(x->work), free(x->placed);
    memset(x, 0, sizeof *x);
}

/* Nodes of superelement i, behind the matrices of the scratch; v NULL: at rest. */
static lw_beam_node *nodes(const lw_superelements *x, const double *q, const double *v, int i)
{
    const lw_superelement *p = &x->given[i];
    double unit = x->system->unit;
    lw_beam_node *node = (lw_beam_node *)(void *)(x->work + 6*p->n + 72*p->n*p->n);
    for (int k = 0; k < p->n; k++) {
        int b = x->system->body[p->link[k]];
        const double *at = q + 3*b, c = cos(at[2]), s = sin(at[2]);
        node[k] = (lw_beam_node){ .at = lw_v3(unit*at[0], unit*at[1], 0), .turn = lw_m3_columns(lw_v3(c, s, 0), lw_v3(-s, c, 0), lw_v3(0, 0, 1)) };
        if (v)
            node[k].v = lw_v3(unit*v[3*b], unit*v[3*b + 1], 0), node[k].omega = lw_v3(0, 0, v[3*b + 2]);
    }
    return node;
}

/* Entries of a matrix (6n x 6n) that act in the plane; second: a derivative by rates, or NULL. */
static void put_matrix(const lw_superelements *x, int i, const double *matrix, const double *second, const lw_force_sink *sink)
{
    const lw_superelement *p = &x->given[i];
    for (int row = 0; row < 3*p->n; row++)
        for (int column = 0; column < 3*p->n; column++) {
            int at = (6*(row/3) + plane[row%3])*6*p->n + 6*(column/3) + plane[column%3];
            double both = scale(x, row%3)*scale(x, column%3);
            sink->add(sink->context, 3*x->system->body[p->link[row/3]] + row%3, 3*x->system->body[p->link[column/3]] + column%3,
                      both*matrix[at], second ? both*second[at] : 0);
        }
}

void lw_superelements_forces(const lw_superelements *x, const double *q, const double *v, double *force, double *power, const lw_force_sink *sink)
{
    for (int i = 0; i < x->n; i++) {
        const lw_superelement *p = &x->given[i];
        double *load = x->work, *by_x = load + 6*p->n, *by_v = by_x + 36*p->n*p->n, lost;
        lw_super_at(&x->super[i], nodes(x, q, v, i), load, sink ? by_x : NULL, by_v, &lost);
        *power += lost;
        for (int k = 0; k < 3*p->n; k++)
            force[3*x->system->body[p->link[k/3]] + k%3] += scale(x, k%3)*load[6*(k/3) + plane[k%3]];
        if (sink)
            put_matrix(x, i, by_x, by_v, sink);
    }
}

void lw_superelements_pattern(const lw_superelements *x, const lw_force_sink *sink)
{
    for (int i = 0; i < x->n; i++) {
        for (int k = 0; k < 36*x->given[i].n*x->given[i].n; k++)
            x->work[k] = 1;
        put_matrix(x, i, x->work, x->work, sink);
    }
}

void lw_superelements_mass(const lw_superelements *x, const double *q, const lw_force_sink *sink)
{
    for (int i = 0; i < x->n; i++) {
        const lw_superelement *p = &x->given[i];
        int rows = 6*p->n;
        double *m = x->work;
        lw_super_mass(&x->super[i], nodes(x, q, NULL, i), m);
        for (int k = 0; k < p->n; k++) {         /* less what the nodes have */
            m[6*k*(rows + 1)] -= p->lump[k], m[(6*k + 1)*(rows + 1)] -= p->lump[k];
            m[(6*k + 5)*(rows + 1)] -= p->turning[6*k + 2];
        }
        put_matrix(x, i, m, NULL, sink);
    }
}

/* Force and moment that each node of superelement i takes for its motion (6n). */
static const double *inertia_of(const lw_superelements *x, const double *q, const double *v, const double *a, int i)
{
    const lw_superelement *p = &x->given[i];
    const lw_beam_node *node = nodes(x, q, v, i);
    lw_vec3 *rate = (lw_vec3 *)(void *)(x->work + 6*p->n);
    for (int k = 0; k < p->n; k++) {
        int b = x->system->body[p->link[k]];
        rate[2*k] = lw_v3(x->system->unit*a[3*b], x->system->unit*a[3*b + 1], 0), rate[2*k + 1] = lw_v3(0, 0, a[3*b + 2]);
    }
    lw_super_inertia(&x->super[i], node, rate, x->work, NULL);
    return x->work;
}

void lw_superelements_inertia(const lw_superelements *x, const double *q, const double *v, const double *a, double *out)
{
    for (int i = 0; i < x->n; i++) {
        const lw_superelement *p = &x->given[i];
        const double *load = inertia_of(x, q, v, a, i);
        for (int k = 0; k < 3*p->n; k++) {
            int at = 3*x->system->body[p->link[k/3]] + k%3;
            double own = k%3 == 2 ? p->turning[6*(k/3) + 2] : p->lump[k/3]*x->system->unit;
            out[at] += scale(x, k%3)*(load[6*(k/3) + plane[k%3]] - own*a[at]);
        }
    }
}

double lw_superelements_kinetic(const lw_superelements *x, const double *v)
{
    double energy = 0, unit = x->system->unit;
    for (int i = 0; i < x->n; i++) {
        const lw_superelement *p = &x->given[i];
        energy += lw_super_inertia(&x->super[i], nodes(x, x->placed, v, i), NULL, NULL, NULL);
        for (int k = 0; k < p->n; k++) {
            const double *rate = v + 3*x->system->body[p->link[k]];
            energy -= 0.5*(p->lump[k]*unit*unit*(rate[0]*rate[0] + rate[1]*rate[1]) + p->turning[6*k + 2]*rate[2]*rate[2]);
        }
    }
    return energy;
}

double lw_superelements_potential(const lw_superelements *x, const double *q)
{
    double energy = -x->start, lost;
    for (int i = 0; i < x->n; i++)
        energy += lw_super_at(&x->super[i], nodes(x, q, NULL, i), x->work, NULL, NULL, &lost);
    return energy;
}

double lw_superelements_strain(const lw_superelements *x, const double *q)
{
    double energy = lw_superelements_potential(x, q) + x->start;
    for (int i = 0; i < x->n; i++) {             /* less that of the weight */
        const lw_super *s = &x->super[i];
        const lw_beam_node *node = nodes(x, q, NULL, i);
        double mass = 0;
        for (int k = 0; k < x->given[i].n; k++)
            mass += x->given[i].lump[k];
        energy += lw_v3_dot(s->gravity, lw_v3_add(lw_v3_scale(node[s->a].at, mass), lw_super_moment(s, node)));
    }
    return energy;
}

void lw_superelements_end(const lw_superelements *x, const double *q, const double *v, const double *a, int i, int end, double out[3])
{
    double lost;
    lw_super_at(&x->super[i], nodes(x, q, v, i), x->work, NULL, NULL, &lost);
    for (int c = 0; c < 3; c++)
        out[c] = x->work[6*end + plane[c]];
    const double *own = a ? inertia_of(x, q, v, a, i) : NULL;
    for (int c = 0; own && c < 3; c++)
        out[c] -= own[6*end + plane[c]];
}

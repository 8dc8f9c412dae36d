/* mbs/elastic/superelement.c - derivation.
 *
 * T is the frame half-way between nodes a and b (lw_mid_frame_of), p_i = T^T (r_i - r_a), g_i the rotation vector of node i against T;
 * e_i = (p_i - P_i, g_i).  For small motions r, t of the nodes, written in the frame, with its turn s = (t_a + t_b)/2 - q g x (t_b - t_a):
 *
 *     dp_i = r_i - r_a + p_i x s,     dg_i = L(g_i) (t_i - s),     L(g) = 1 - g x /2 + k g x g x,  k = (1 - f/2 cot f/2)/f^2, f = |g|
 *
 * With the stress (N_i, M_i) = K (e + d e'), h_i = L^T M_i and c = sum of N_i x p_i - h_i, the gradient of the energy is N_i by r_i
 * (less their sum by r_a), h_i by t_i, and c/2 + q c x g by t_a, c/2 - q c x g by t_b.  Its change has the exact part B^T K B and
 * that of the directions at constant stress, which is small beside it and is found by central differences.
 *
 * The weight has the potential -g.(m r_a + T w), w = m C + S e, C the centre of mass in the posture against node a, S = sum of the rows
 * of the mass matrix along each axis; w is found as S (P + e) + beside, since S P is m C for no bodies but straight ones: it adds -S^T T^T g to the
 * stress, -w x T^T g to c, and pulls at node a by m g. */
#include "mbs/elastic/superelement.h"

#include <stdlib.h>
#include <string.h>
#include "base/eigen.h"
#include "base/linalg.h"
#include "base/vector.h"

static lw_vec3 vec(const double *x) { return lw_v3(x[0], x[1], x[2]); }
static void put(double *to, lw_vec3 a) { to[0] = a.x, to[1] = a.y, to[2] = a.z; }

lw_status lw_super_make(const lw_superelement *p, const lw_mat3 *turn, lw_vec3 gravity, lw_super *s)
{
    size_t n = 6*(size_t)p->n;
    *s = (lw_super){ .p = p, .gravity = gravity, .axes = calloc((size_t)p->n, sizeof *s->axes), .work = calloc(2*n*n + 11*n + 6, sizeof *s->work),
                     .still = calloc((size_t)p->n, sizeof *s->still), .rate = calloc(2*(size_t)p->n, sizeof *s->rate) };
    if (!s->axes || !s->work || !s->still || !s->rate)
        return LW_E_MEMORY;
    for (int i = 0; i < p->n; i++) {
        double away = lw_v3_norm(lw_v3_sub(p->at[i], p->at[0]));
        if (away > s->size)
            s->size = away, s->b = i;
        s->axes[i] = lw_m3_columns(turn[i].row[0], turn[i].row[1], turn[i].row[2]);      /* the inverse */
    }
    return LW_OK;
}

void lw_super_free(lw_super *s)
{
    free(s->axes), free(s->work), free(s->still), free(s->rate);
    memset(s, 0, sizeof *s);
}

static lw_mid_frame frame_of(const lw_super *s, const lw_beam_node *node)
{
    lw_mat3 a = lw_m3_times(&node[s->a].turn, &s->axes[s->a]), b = lw_m3_times(&node[s->b].turn, &s->axes[s->b]);
    return lw_mid_frame_of(&a, &b);
}

/* The rotation vector.  Strains are small: half the skew part is the axis times the sine x, and the angle over it a series in x^2, to 1e-19. */
static lw_vec3 rotation_vector(const lw_mat3 *m)
{
    const lw_vec3 *r = m->row;
    lw_vec3 axis = lw_v3(0.5*(r[2].y - r[1].z), 0.5*(r[0].z - r[2].x), 0.5*(r[1].x - r[0].y));
    double x2 = lw_v3_dot(axis, axis);
    if (x2 < 1e-3 && r[0].x + r[1].y + r[2].z > 2)
        return lw_v3_scale(axis, 1 + x2*(1./6 + x2*(3./40 + x2*(5./112 + x2*(35./1152 + x2*(63./2816 + x2*231./13312))))));
    return lw_quaternion_vector(lw_quaternion_unit(lw_quaternion_of_matrix(m)));
}

/* p_i and g_i. */
static void place(const lw_super *s, const lw_mid_frame *z, const lw_beam_node *node, int i, lw_vec3 *p, lw_vec3 *g)
{
    lw_mat3 own = lw_m3_times(&node[i].turn, &s->axes[i]), back = lw_m3_columns(z->turn.row[0], z->turn.row[1], z->turn.row[2]);
    own = lw_m3_times(&back, &own);
    *p = lw_m3_unapply(&z->turn, lw_v3_sub(node[i].at, node[s->a].at));
    *g = rotation_vector(&own);
}

/* L(g) t, or with sense 1 L^T t. */
static lw_vec3 log_rate(lw_vec3 g, lw_vec3 t, double sense)
{
    double f2 = lw_v3_dot(g, g), f = sqrt(f2);
    double k = f2 < 1e-3 ? 1./12 + f2*(1./720 + f2*(1./30240 + f2/1209600)) : (1 - 0.5*f/tan(0.5*f))/f2;
    lw_vec3 across = lw_v3_cross(g, t);
    return lw_v3_add(lw_v3_add(t, lw_v3_scale(across, 0.5*sense)), lw_v3_scale(lw_v3_cross(g, across), k));
}

/* Row k of S times the strains of node i, less those of the posture where they are e. */
static double moment_part(const lw_super *s, int k, int i, lw_vec3 p, lw_vec3 g)
{
    const double *row = s->p->first + k*6*s->p->n + 6*i;
    return lw_v3_dot(vec(row), p) + lw_v3_dot(vec(row + 3), g);
}

static double total_mass(const lw_super *s)
{
    double m = 0;
    for (int i = 0; i < s->p->n; i++)
        m += s->p->lump[i];
    return m;
}

/* The gradient (6n), in ground axes, of an energy whose derivatives by e are in out, by turns of the frame c, and by the place of node a
 * -pull. */
static void spread(const lw_super *s, const lw_mid_frame *z, const lw_beam_node *node, lw_vec3 c, lw_vec3 pull, double *out)
{
    for (int i = 0; i < s->p->n; i++) {
        lw_vec3 p, g, n = vec(out + 6*i);
        place(s, z, node, i, &p, &g);
        lw_vec3 h = log_rate(g, vec(out + 6*i + 3), 1);
        pull = lw_v3_add(pull, n);
        c = lw_v3_add(c, lw_v3_sub(lw_v3_cross(n, p), h));
        put(out + 6*i + 3, h);
    }
    lw_vec3 half = lw_v3_scale(c, 0.5), turn = lw_v3_scale(lw_v3_cross(c, z->g), z->q);
    put(out + 6*s->a, lw_v3_sub(vec(out + 6*s->a), pull));
    put(out + 6*s->a + 3, lw_v3_add(vec(out + 6*s->a + 3), lw_v3_add(half, turn)));
    put(out + 6*s->b + 3, lw_v3_add(vec(out + 6*s->b + 3), lw_v3_sub(half, turn)));
    for (int i = 0; i < 2*s->p->n; i++)
        put(out + 3*i, lw_m3_apply(&z->turn, vec(out + 3*i)));
}

/* The gradient (6n), in ground axes, of the energy for a stress, and of the weight. */
static void gradient(const lw_super *s, const lw_beam_node *node, const double *stress, double *out)
{
    lw_mid_frame z = frame_of(s, node);
    lw_vec3 down = lw_m3_unapply(&z.turn, s->gravity);
    double w[3] = { s->p->beside.x, s->p->beside.y, s->p->beside.z };
    for (int i = 0; i < s->p->n; i++) {
        lw_vec3 p, g, n = vec(stress + 6*i), m = vec(stress + 6*i + 3);
        place(s, &z, node, i, &p, &g);
        for (int k = 0; k < 3; k++) {
            const double *row = s->p->first + k*6*s->p->n + 6*i, part = k == 0 ? down.x : k == 1 ? down.y : down.z;
            w[k] += moment_part(s, k, i, p, g);
            n = lw_v3_sub(n, lw_v3_scale(vec(row), part));
            m = lw_v3_sub(m, lw_v3_scale(vec(row + 3), part));
        }
        put(out + 6*i, n), put(out + 6*i + 3, m);
    }
    spread(s, &z, node, lw_v3_cross(down, lw_v3(w[0], w[1], w[2])), lw_v3_scale(down, total_mass(s)), out);
}

/* B (6n x 6n): change of e by motions of the nodes about ground axes. */
static void strain_matrix(const lw_super *s, const lw_beam_node *node, double *matrix)
{
    lw_mid_frame z = frame_of(s, node);
    int n = s->p->n, rows = 6*n;
    memset(matrix, 0, (size_t)rows*(size_t)rows*sizeof *matrix);
    for (int i = 0; i < n; i++) {
        lw_vec3 p, g;
        place(s, &z, node, i, &p, &g);
        for (int column = 0; column < rows; column++) {
            int j = column/6;
            lw_vec3 axis = lw_v3(column%3 == 0, column%3 == 1, column%3 == 2), own = lw_m3_unapply(&z.turn, axis);
            lw_vec3 none = { 0, 0, 0 }, turn = none, dp = none;
            if (column%6 >= 3 && (j == s->a || j == s->b))
                turn = lw_v3_add(lw_v3_scale(own, 0.5), lw_v3_scale(lw_v3_cross(z.g, own), j == s->b ? -z.q : z.q));
            if (column%6 < 3)
                dp = lw_v3_scale(own, (i == j) - (j == s->a));
            dp = lw_v3_add(dp, lw_v3_cross(p, turn));
            lw_vec3 dg = log_rate(g, lw_v3_sub(column%6 >= 3 && i == j ? own : none, turn), -1);
            const double all[6] = { dp.x, dp.y, dp.z, dg.x, dg.y, dg.z };
            for (int k = 0; k < 6; k++)
                matrix[(6*i + k)*rows + column] = all[k];
        }
    }
}

/* B^T x: a row of B has entries at its own node and at those of the frame. */
static void transposed_times(const lw_super *s, const double *b, const double *x, double *out)
{
    int rows = 6*s->p->n;
    memset(out, 0, (size_t)rows*(size_t)rows*sizeof *out);
    for (int l = 0; l < rows; l++) {
        const int node[3] = { l/6, s->a, s->b };
        for (int c = 0; c < 3; c++)
            for (int j = 6*node[c]; j < 6*node[c] + 6 && (c == 0 || node[c] != node[0]); j++)
                for (int i = 0; b[l*rows + j] != 0 && i < rows; i++)
                    out[j*rows + i] += b[l*rows + j]*x[l*rows + i];
    }
}

double lw_super_at(const lw_super *s, lw_beam_node *node, double *force, double *by_x, double *by_v, double *power)
{
    const double step = 1e-6;                /* the differences are off by its square */
    int n = s->p->n, rows = 6*n;
    size_t square = (size_t)rows*(size_t)rows;
    double *e = s->work, *rate = e + rows, *stress = rate + rows, *side[2] = { stress + rows, stress + 2*rows };
    double *matrix = stress + 3*rows, *product = matrix + square, energy = 0;
    const double *k = s->p->stiffness;
    lw_mid_frame z = frame_of(s, node);
    lw_vec3 down = lw_m3_unapply(&z.turn, s->gravity);
    for (int i = 0; i < n; i++) {
        lw_vec3 p, g;
        place(s, &z, node, i, &p, &g);
        energy -= down.x*moment_part(s, 0, i, p, g) + down.y*moment_part(s, 1, i, p, g) + down.z*moment_part(s, 2, i, p, g);
        put(e + 6*i, lw_v3_sub(p, lw_v3_sub(s->p->at[i], s->p->at[s->a])));
        put(e + 6*i + 3, g);
    }
    energy -= total_mass(s)*lw_v3_dot(s->gravity, node[s->a].at) + lw_v3_dot(down, s->p->beside);
    memset(rate, 0, (size_t)rows*sizeof *rate);
    if (s->p->damping > 0 || by_x)
        strain_matrix(s, node, matrix);
    for (int i = 0; s->p->damping > 0 && i < rows; i++)
        for (int j = 0; j < n; j++) {
            const double *b = matrix + i*rows + 6*j;
            rate[i] += lw_v3_dot(vec(b), node[j].v) + lw_v3_dot(vec(b + 3), node[j].omega);
        }
    *power = 0;
    for (int i = 0; i < rows; i++) {
        double still = 0, moving = 0;
        for (int j = 0; j < rows; j++)
            still += k[i*rows + j]*e[j], moving += k[i*rows + j]*rate[j];
        stress[i] = still + s->p->damping*moving;
        energy += 0.5*e[i]*still;
        *power -= s->p->damping*rate[i]*moving;
    }
    gradient(s, node, stress, force);
    for (int i = 0; i < rows; i++)
        force[i] = -force[i];
    if (!by_x)
        return energy;
    transposed_times(s, matrix, k, product);
    for (int i = 0; i < rows; i++)           /* K B */
        for (int j = 0; j < i; j++) {
            double swap = product[i*rows + j];
            product[i*rows + j] = product[j*rows + i], product[j*rows + i] = swap;
        }
    transposed_times(s, matrix, product, by_x);
    for (size_t i = 0; i < square; i++)
        by_x[i] = -by_x[i], by_v[i] = s->p->damping*by_x[i];
    for (int column = 0; column < rows; column++) {
        lw_beam_node *at = &node[column/6], old = *at;
        double h = column%6 < 3 ? step*s->size : step;
        for (int way = 0; way < 2; way++) {
            lw_vec3 by = lw_v3_scale(lw_v3(column%3 == 0, column%3 == 1, column%3 == 2), way ? h : -h);
            lw_mat3 turn = lw_quaternion_matrix(lw_quaternion_of_vector(by));
            *at = old;
            if (column%6 < 3)
                at->at = lw_v3_add(old.at, by);
            else
                at->turn = lw_m3_times(&turn, &old.turn);
            gradient(s, node, stress, side[way]);
        }
        *at = old;
        for (int i = 0; i < rows; i++)
            by_x[i*rows + column] -= (side[1][i] - side[0][i])/(2*h);
    }
    return energy;
}

/* ---- inertia ------------------------------------------------------------------------------------------------------
 *
 * A point of the whole mesh has the velocity, in the frame's axes, n + s x (X + w) + w', with s the frame's angular velocity and the
 * displacement w = F e in the frame, F the shapes of the coordinates that are kept.  u are the velocities v_i and angular velocities t_i of
 * the nodes in the frame's axes, and the rates e' of nodes that carry modes.  Since F u moves as a rigid body does where e = 0,
 *
 *     U = F u + sum of s_k Y_k e,      Y_k e = e_k x (F e) - F (e_k x e)      (places only, of nodes that carry no modes)
 *     T = 1/2 u.M u + sum of s_k u.H_k e + 1/2 sum of s_k s_l e.G_kl e,       H_k = F^T M Y_k,   G_kl = Y_k^T M Y_l
 *
 * With p, c and f the derivatives of T by u, s and e, and virtual motions r_i, t_i of the nodes and o of the frame, all in its axes, for
 * which  d v_i = r_i' + s x r_i - o x v_i,  d t_i = t_i' + (s - t_i) x t_i - o x t_i,  d s = o' + s x o,  the inertia is
 *
 *     p_i' + s x p_i  by r_i,   q_i' + (s - t_i) x q_i  by t_i,   p_m' - f  by e,   c' + s x c + sum of v_i x p_i + t_i x q_i  by o
 *
 * so that momentum, angular momentum and energy are kept, whatever e. */

/* The change of L(g) x while g changes by dg. */
static lw_vec3 log_rate_change(lw_vec3 g, lw_vec3 dg, lw_vec3 x)
{
    double f2 = lw_v3_dot(g, g), f = sqrt(f2), s = sin(0.5*f), h = f2 < 1e-3 ? 0 : 0.5*f*cos(0.5*f)/s;
    double k = f2 < 1e-3 ? 1./12 + f2*(1./720 + f2*(1./30240 + f2/1209600)) : (1 - h)/f2;
    double by = f2 < 1e-3 ? 1./720 + f2*(1./15120 + f2/403200) : (0.125/(s*s) - 0.5*h/f2)/f2 - (1 - h)/(f2*f2);
    lw_vec3 across = lw_v3_cross(g, x), own = lw_v3_cross(dg, x);
    lw_vec3 twice = lw_v3_add(lw_v3_cross(dg, across), lw_v3_cross(g, own));
    return lw_v3_add(lw_v3_add(lw_v3_scale(own, -0.5), lw_v3_scale(twice, k)), lw_v3_scale(lw_v3_cross(g, across), 2*by*lw_v3_dot(g, dg)));
}

lw_vec3 lw_super_moment(const lw_super *s, const lw_beam_node *node)
{
    lw_mid_frame z = frame_of(s, node);
    double w[3] = { s->p->beside.x, s->p->beside.y, s->p->beside.z };
    for (int i = 0; i < s->p->n; i++) {
        lw_vec3 p, g;
        place(s, &z, node, i, &p, &g);
        for (int k = 0; k < 3; k++)
            w[k] += moment_part(s, k, i, p, g);
    }
    return lw_m3_apply(&z.turn, vec(w));
}

static void multiply(int rows, const double *a, double by, const double *x, double *out)
{
    for (int i = 0; by != 0 && i < rows; i++) {
        double sum = 0;
        for (int j = 0; j < rows; j++)
            sum += a[i*rows + j]*x[j];
        out[i] += by*sum;
    }
}

/* The same for a symmetric matrix, with little work where few x are not 0. */
static void multiply_symmetric(int rows, const double *a, const double *x, double *out)
{
    for (int j = 0; j < rows; j++)
        for (int i = 0; x[j] != 0 && i < rows; i++)
            out[i] += a[j*rows + i]*x[j];
}

static const lw_vec3 none = { 0, 0, 0 };

/* How a superelement moves, in the axes of its frame: angular velocity of the frame and its rate; u, e and their rates (6n, in s->work).
 * rates: du and dspin are known. */
typedef struct motion { lw_mid_frame z; lw_vec3 spin, dspin; double *u, *du, *e, *de; bool rates; } motion;

/* rate: accelerations of the nodes, or NULL. */
static motion motion_of(const lw_super *s, const lw_beam_node *node, const lw_vec3 *rate)
{
    const lw_superelement *own = s->p;
    const int rows = 6*own->n;
    motion m = { .z = frame_of(s, node), .u = s->work, .du = s->work + rows, .e = s->work + 2*rows, .de = s->work + 3*rows, .rates = rate };
    const lw_mat3 *turn = &m.z.turn;
    const lw_vec3 ta = lw_m3_unapply(turn, node[s->a].omega), tb = lw_m3_unapply(turn, node[s->b].omega), w = lw_v3_sub(tb, ta);
    const lw_vec3 va = lw_m3_unapply(turn, node[s->a].v);
    lw_vec3 dva = none;
    m.spin = lw_v3_sub(lw_v3_scale(lw_v3_add(ta, tb), 0.5), lw_v3_scale(lw_v3_cross(m.z.g, w), m.z.q));
    if (rate) {
        lw_vec3 dta = lw_v3_sub(lw_m3_unapply(turn, rate[2*s->a + 1]), lw_v3_cross(m.spin, ta));
        lw_vec3 dtb = lw_v3_sub(lw_m3_unapply(turn, rate[2*s->b + 1]), lw_v3_cross(m.spin, tb));
        lw_vec3 dg = lw_v3_add(lw_v3_scale(w, m.z.k), lw_v3_scale(m.z.g, m.z.n*lw_v3_dot(m.z.g, w)));
        lw_vec3 qg = lw_v3_add(lw_v3_scale(m.z.g, 0.5*m.z.dq*lw_v3_dot(m.z.g, dg)), lw_v3_scale(dg, m.z.q));
        m.dspin = lw_v3_sub(lw_v3_scale(lw_v3_add(dta, dtb), 0.5), lw_v3_cross(qg, w));
        m.dspin = lw_v3_sub(m.dspin, lw_v3_scale(lw_v3_cross(m.z.g, lw_v3_sub(dtb, dta)), m.z.q));
        dva = lw_v3_sub(lw_m3_unapply(turn, rate[2*s->a]), lw_v3_cross(m.spin, va));
    }
    for (int i = 0; i < own->n; i++) {
        lw_vec3 x, g, v = lw_m3_unapply(turn, node[i].v), t = lw_m3_unapply(turn, node[i].omega), dv = none, dt = none;
        place(s, &m.z, node, i, &x, &g);
        lw_vec3 against = lw_v3_sub(t, m.spin), dx = lw_v3_add(lw_v3_sub(v, va), lw_v3_cross(x, m.spin)), dg = log_rate(g, against, -1);
        if (rate) {
            dv = lw_v3_sub(lw_m3_unapply(turn, rate[2*i]), lw_v3_cross(m.spin, v));
            dt = lw_v3_sub(lw_m3_unapply(turn, rate[2*i + 1]), lw_v3_cross(m.spin, t));
        }
        put(m.e + 6*i, lw_v3_sub(x, lw_v3_sub(own->at[i], own->at[s->a]))), put(m.e + 6*i + 3, g);
        put(m.de + 6*i, dx), put(m.de + 6*i + 3, dg);
        if (i >= own->n_bound) {                 /* the rates of modes and those of these */
            v = dx, t = dg;
            dv = lw_v3_add(lw_v3_sub(dv, dva), lw_v3_add(lw_v3_cross(dx, m.spin), lw_v3_cross(x, m.dspin)));
            dt = lw_v3_add(log_rate_change(g, dg, against), log_rate(g, lw_v3_sub(dt, m.dspin), -1));
        }
        put(m.u + 6*i, v), put(m.u + 6*i + 3, t);
        put(m.du + 6*i, dv), put(m.du + 6*i + 3, dt);
    }
    return m;
}

/* Derivatives of T: by u (6n, in s->work) and, if rates are known, the rate of that, and by e; by the angular velocity of the frame and the
 * rate of that. */
typedef struct momenta { double *p, *dp, *by_e, c[3], dc[3], twice; } momenta;       /* twice: 2 T */

/* Add what H and G give.  he (3 x 6n), ege (6): H_k e and e.G_kl e, which another motion of the same strains finds there (again). */
static void add_turning(const lw_superelement *own, const motion *m, bool again, double *product, double *he, double *ege, momenta *to)
{
    static const int pair[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    const int rows = 6*own->n, size = rows*rows;
    const double omega[3] = { m->spin.x, m->spin.y, m->spin.z }, domega[3] = { m->dspin.x, m->dspin.y, m->dspin.z };
    const bool change = m->rates && lw_dot(rows, m->de, m->de) > 0;         /* of strains */
    for (int k = 0; k < 3; k++, he += rows) {
        const double *h = own->turn + k*size;
        if (!again) {
            memset(he, 0, (size_t)rows*sizeof *he);
            multiply(rows, h, 1, m->e, he);
        }
        memset(product, 0, (size_t)rows*sizeof *product);
        multiply(rows, h, change, m->de, product);
        double by = lw_dot(rows, m->u, he);
        for (int i = 0; i < rows; i++) {
            to->p[i] += omega[k]*he[i];
            to->dp[i] += domega[k]*he[i] + omega[k]*product[i];
            for (int j = 0; m->rates && omega[k] != 0 && j < rows; j++)
                to->by_e[j] += omega[k]*h[i*rows + j]*m->u[i];
        }
        to->c[k] += by;
        to->dc[k] += lw_dot(rows, m->du, he) + lw_dot(rows, m->u, product);
        to->twice += 2*omega[k]*by;
    }
    for (int k = 0; k < 6; k++) {
        const int a = pair[k][0], b = pair[k][1], both = a == b ? 1 : 2;
        const double *g = own->turn + (3 + k)*size, by = both*omega[a]*omega[b];
        double rate = 0;
        if (!again || omega[a] != 0 || omega[b] != 0) {
            memset(product, 0, (size_t)rows*sizeof *product);
            multiply(rows, g, 1, m->e, product);
            ege[k] = lw_dot(rows, m->e, product);
            rate = 2*lw_dot(rows, m->de, product);
            for (int i = 0; i < rows; i++)
                to->by_e[i] += by*product[i];
        }
        to->twice += by*ege[k];
        for (int side = 0; side < both; side++) {
            to->c[side ? b : a] += omega[side ? a : b]*ege[k];
            to->dc[side ? b : a] += domega[side ? a : b]*ege[k] + omega[side ? a : b]*rate;
        }
    }
}

/* The derivatives of T by velocities and angular velocities of the nodes, ground axes. */
static void to_momentum(const lw_super *s, const lw_beam_node *node, const motion *m, const momenta *t, double *out)
{
    const int rows = 6*s->p->n, bound = 6*s->p->n_bound;
    for (int i = 0; i < rows; i++)
        out[i] = i < bound ? 0 : t->p[i];
    spread(s, &m->z, node, vec(t->c), none, out);
    for (int i = 0; i < bound; i += 3)
        put(out + i, lw_v3_add(vec(out + i), lw_m3_apply(&m->z.turn, vec(t->p + i))));
}

/* Force and moment that each node takes, ground axes. */
static void to_force(const lw_super *s, const lw_beam_node *node, const motion *m, const momenta *t, double *out)
{
    const int rows = 6*s->p->n, bound = 6*s->p->n_bound;
    lw_vec3 c = lw_v3_add(vec(t->dc), lw_v3_cross(m->spin, vec(t->c)));
    for (int i = 0; i < rows; i++)
        out[i] = (i < bound ? 0 : t->dp[i]) - t->by_e[i];
    for (int i = 0; i < bound; i += 3)
        c = lw_v3_add(c, lw_v3_cross(vec(m->u + i), vec(t->p + i)));
    spread(s, &m->z, node, c, none, out);
    for (int i = 0; i < bound; i += 3) {
        lw_vec3 turns = i%6 ? lw_v3_sub(m->spin, vec(m->u + i)) : m->spin;
        lw_vec3 rate = lw_v3_add(vec(t->dp + i), lw_v3_cross(turns, vec(t->p + i)));
        put(out + i, lw_v3_add(vec(out + i), lw_m3_apply(&m->z.turn, rate)));
    }
}

/* lw_super_inertia; again: the nodes are where they were in the call before. */
static double inertia(const lw_super *s, const lw_beam_node *node, const lw_vec3 *rate, bool again, double *force, double *momentum)
{
    const int rows = 6*s->p->n;
    double *work = s->work + 4*rows;
    motion m = motion_of(s, node, rate);
    momenta t = { .p = work, .dp = work + rows, .by_e = work + 2*rows };
    memset(work, 0, 3*(size_t)rows*sizeof *work);
    multiply_symmetric(rows, s->p->rate, m.u, t.p);
    if (rate)
        multiply_symmetric(rows, s->p->rate, m.du, t.dp);
    t.twice = lw_dot(rows, m.u, t.p);
    if (s->p->turn)
        add_turning(s->p, &m, again, work + 3*rows, work + 4*rows, work + 7*rows, &t);
    if (momentum)
        to_momentum(s, node, &m, &t, momentum);
    if (force)
        to_force(s, node, &m, &t, force);
    return 0.5*t.twice;
}

double lw_super_inertia(const lw_super *s, const lw_beam_node *node, const lw_vec3 *rate, double *force, double *momentum)
{
    return inertia(s, node, rate, false, force, momentum);
}

void lw_super_mass(const lw_super *s, const lw_beam_node *node, double *out)
{
    int n = s->p->n, rows = 6*n;
    lw_beam_node *still = s->still;
    lw_vec3 *rate = s->rate;
    for (int i = 0; i < n; i++)
        still[i] = (lw_beam_node){ .at = node[i].at, .turn = node[i].turn };
    memset(rate, 0, 2*(size_t)n*sizeof *rate);
    for (int c = 0; c < rows; c++) {
        rate[c/3] = lw_v3(c%3 == 0, c%3 == 1, c%3 == 2);
        inertia(s, still, rate, c > 0, out + c*rows, NULL);
        rate[c/3] = lw_v3(0, 0, 0);
    }
}

/* ---- mass and condensation ---------------------------------------------------------------------------------------- */

static bool across(int coordinate) { return coordinate%6 >= 2 && coordinate%6 <= 4; }

/* The lowest modes of `inner` coordinates (indices `other`) with the rest of the mesh at rest: squared frequencies w, shapes x (inner x modes).
 * plane: those along x and y and about z are modes in the plane, the others are modes across it. */
static lw_status inner_modes(int n, const double *k, const double *mass, int inner, const int *other, int modes, bool plane, double *w, double *x)
{
    size_t size = (size_t)inner;
    double *work = calloc(3*size*size + size, sizeof *work), *m = work + size*size, *all = m + size*size, *values = all + size*size;
    int *own = calloc(size, sizeof *own);
    lw_status s = work && own ? LW_OK : LW_E_MEMORY;
    for (int side = 0; s == LW_OK && side <= plane; side++) {
        int count = 0, found = 0;
        for (int i = 0; i < inner; i++)
            if (!plane || across(other[i]) == side)
                own[count++] = i;
        for (int i = 0; i < count*count; i++) {
            int at = other[own[i/count]]*n + other[own[i%count]];
            work[i] = k[at], m[i] = mass[at];
        }
        s = lw_eigen_symmetric(count, work, m, values, all);
        for (int j = 0; s == LW_OK && j < modes; j++) {
            if (plane && across(j) != side)
                continue;
            w[j] = values[found];
            for (int i = 0; i < count; i++)
                x[(size_t)j*size + (size_t)own[i]] = all[found*count + i];
            found++;
        }
    }
    free(work), free(own);
    return s;
}

/* Condense; shapes (n x (m + modes)): the motion of all coordinates with each that is kept. */
static lw_status condense(int n, double *k, double *mass, int m, const int *keep, int modes, bool plane, double *shapes)
{
    int inner = n - m, *other = calloc((size_t)n + 1, sizeof *other), found = 0, rows = m + modes;
    size_t size = (size_t)inner + 1, both = (size_t)rows + 1;
    double *a = calloc(size*size + size + size*both + both, sizeof *a), *diag = a + size*size, *shape = diag + size, *w = shape + size*both;
    double *out[2] = { calloc(both*both, sizeof(double)), calloc(both*both, sizeof(double)) };
    lw_status s = other && a && out[0] && out[1] ? LW_OK : LW_E_MEMORY;
    for (int i = 0, kept = 0; s == LW_OK && i < n; i++)
        if (kept < m && keep[kept] == i)
            kept++;
        else
            other[found++] = i;
    for (int j = 0; s == LW_OK && j < inner; j++)
        for (int i = 0; i < inner; i++)
            a[i + inner*j] = k[other[i]*n + other[j]];
    if (s == LW_OK && inner > 0 && !(lw_qr_factor(inner, inner, a, diag) > 1e-15))
        s = LW_E_NUMERIC;
    for (int j = 0; s == LW_OK && j < m; j++) {          /* motion of the others with those that are kept */
        double *b = shape + (size_t)j*(size_t)inner;
        for (int i = 0; i < inner; i++)
            b[i] = -k[other[i]*n + keep[j]];
        if (inner > 0)
            lw_qr_solve(inner, inner, a, diag, b);
    }
    if (s == LW_OK && modes > 0)
        s = inner_modes(n, k, mass, inner, other, modes, plane, w, shape + (size_t)m*(size_t)inner);
    for (int which = 1; s == LW_OK && which >= 0; which--)
        for (int j = 0; j < rows; j++) {
            const double *x = which ? mass : k, *v = shape + (size_t)j*(size_t)inner;
            for (int i = 0; i < rows; i++) {
                const double *u = shape + (size_t)i*(size_t)inner;
                double sum = i < m && j < m ? x[keep[i]*n + keep[j]] : 0;
                for (int l = 0; i < m && l < inner; l++)
                    sum += x[keep[i]*n + other[l]]*v[l];
                for (int r = 0; which && r < inner; r++) {
                    double row = j < m ? x[other[r]*n + keep[j]] : 0;
                    for (int l = 0; l < inner; l++)
                        row += x[other[r]*n + other[l]]*v[l];
                    sum += u[r]*row;
                }
                out[which][i*rows + j] = which || (i < m && j < m) ? sum : i == j ? w[i - m]*out[1][i*rows + i] : 0;
            }
        }
    for (int which = 0; s == LW_OK && which < 2; which++)
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < rows; j++)
                (which ? mass : k)[i*rows + j] = 0.5*(out[which][i*rows + j] + out[which][j*rows + i]);
    for (int j = 0; s == LW_OK && j < rows; j++) {
        for (int i = 0; i < m; i++)
            shapes[keep[i]*rows + j] = i == j;
        for (int i = 0; i < inner; i++)
            shapes[other[i]*rows + j] = shape[(size_t)j*(size_t)inner + (size_t)i];
    }
    free(other), free(a), free(out[0]), free(out[1]);
    return s;
}

/* Turn the 6 more modes that follow the coordinates of n nodes into the motions of `more` nodes, which lie at the first node and
 * move with the frame of the superelement as long as no mode is excited; rate: mass by the rates of their strains, which are the modes. */
static void modal_nodes(int n, int more, const lw_vec3 *at, double *k, double *mass, int all, double *rate, double *shapes)
{
    int m = 6*n, rows = m + 6*more, b = 0;
    double total = 0, size = 0;
    for (int i = 0; i < n; i++) {
        double away = lw_v3_norm(lw_v3_sub(at[i], at[0]));
        if (away > size)
            size = away, b = i;
        for (int j = 0; j < n; j++)
            total += mass[6*i*rows + 6*j];
    }
    for (int r = m; r < rows; r++) {         /* modal coordinate r = scale (motion r of the new node - that of the frame) */
        int c = r%6;
        double scale = sqrt((c < 3 ? total : 0.1*total*size*size)/mass[r*(rows + 1)]);
        const int from[2] = { c, 6*b + c };
        for (int i = 0; i < all; i++)
            shapes[i*rows + r] *= scale;
        for (int i = 0; i < rows; i++)
            rate[i*rows + r] *= scale, rate[r*rows + i] *= scale;
        for (int i = 0; i < rows; i++) {
            mass[i*rows + r] *= scale, k[i*rows + r] *= scale;
            for (int end = 0; end < (c < 3 ? 1 : 2); end++)
                mass[i*rows + from[end]] -= mass[i*rows + r]*(c < 3 ? 1 : 0.5);
        }
        for (int i = 0; i < rows; i++) {
            mass[r*rows + i] *= scale, k[r*rows + i] *= scale;
            for (int end = 0; end < (c < 3 ? 1 : 2); end++)
                mass[from[end]*rows + i] -= mass[r*rows + i]*(c < 3 ? 1 : 0.5);
        }
    }
}

/* H_k and G_kl (see "inertia") of a mass matrix (n x n) and shapes (n x rows); nodes: kept ones.  LW_E_MEMORY. */
static lw_status turning(int n, const double *mass, int rows, int nodes, const double *shapes, double *out)
{
    static const int pair[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    size_t part = (size_t)n*(size_t)rows;
    double *y = calloc(6*part, sizeof *y), *my = y + 3*part;
    if (!y)
        return LW_E_MEMORY;
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < rows; j++)
            for (int i = 0; i < n; i++) {
                double *to = y + (size_t)k*part + i*rows + j;
                if (i%6 < 3 && i%6 != k)         /* e_k x: from axis k + 1 to k + 2, from k + 2 to -(k + 1) */
                    *to = i%6 == (k + 2)%3 ? shapes[(i - i%6 + (k + 1)%3)*rows + j] : -shapes[(i - i%6 + (k + 2)%3)*rows + j];
                if (j < 6*nodes && j%6 < 3 && j%6 != k)
                    *to -= j%6 == (k + 1)%3 ? shapes[i*rows + j - j%6 + (k + 2)%3] : -shapes[i*rows + j - j%6 + (k + 1)%3];
            }
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < n; i++)
            for (int l = 0; l < n; l++) {
                double by = mass[i*n + l];
                for (int j = 0; by != 0 && j < rows; j++)
                    my[(size_t)k*part + i*rows + j] += by*y[(size_t)k*part + l*rows + j];
            }
    for (int which = 0; which < 9; which++)
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < rows; j++) {
                int a = which < 3 ? which : pair[which - 3][0], b = which < 3 ? which : pair[which - 3][1];
                double sum = 0;
                for (int l = 0; l < n; l++)
                    sum += which < 3 ? shapes[l*rows + i]*my[(size_t)a*part + l*rows + j]
                         : 0.5*(y[(size_t)a*part + l*rows + i]*my[(size_t)b*part + l*rows + j]
                              + y[(size_t)b*part + l*rows + i]*my[(size_t)a*part + l*rows + j]);
                out[(which*rows + i)*rows + j] = sum;
            }
    free(y);
    return LW_OK;
}

lw_status lw_super_reduce(int n, double *k, double *mass, int nodes, const int *keep, const lw_vec3 *at, int more, bool plane,
                          double **rate, double **turn)
{
    int rows = 6*(nodes + more), *kept = calloc(6*(size_t)nodes, sizeof *kept);
    size_t all = (size_t)n*(size_t)n, square = (size_t)rows*(size_t)rows;
    double *whole = malloc(all*sizeof *whole), *shapes = calloc((size_t)n*(size_t)rows, sizeof *shapes);
    *rate = malloc(square*sizeof **rate);
    *turn = rows > 0 && 6*nodes < n ? malloc(9*square*sizeof **turn) : NULL;
    lw_status s = kept && whole && shapes && *rate && (*turn || 6*nodes == n) ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < 6*nodes; i++)
        kept[i] = 6*keep[i/6] + i%6;
    if (s == LW_OK) {
        for (int i = 0; plane && i < n*n; i++)
            if (across(i/n) != across(i%n))
                k[i] = mass[i] = 0;
        memcpy(whole, mass, all*sizeof *whole);
        s = condense(n, k, mass, 6*nodes, kept, 6*more, plane, shapes);
    }
    if (s == LW_OK) {
        memcpy(*rate, mass, square*sizeof **rate);
        modal_nodes(nodes, more, at, k, mass, n, *rate, shapes);
        s = *turn ? turning(n, whole, rows, nodes, shapes, *turn) : LW_OK;
    }
    free(kept), free(whole), free(shapes);
    return s;
}

void lw_super_rigid_mass(int n, const lw_vec3 *at, const double *mass, double *total, lw_vec3 *centre, double inertia[6])
{
    static const int entry[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    double all[6][6] = { { 0 } };            /* about the origin: by motions along and turns about x, y, z */
    int rows = 6*n;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            for (int a = 0; a < 6; a++)
                for (int b = 0; b < 6; b++) {
                    double part[2];
                    for (int side = 0; side < 2; side++) {
                        int c = side ? j : i, k = side ? b : a;
                        lw_vec3 axis = lw_v3(k%3 == 0, k%3 == 1, k%3 == 2), move = k < 3 ? axis : lw_v3_cross(axis, at[c/6]);
                        const double x[6] = { move.x, move.y, move.z, k > 2 ? axis.x : 0, k > 2 ? axis.y : 0, k > 2 ? axis.z : 0 };
                        part[side] = x[c%6];
                    }
                    all[a][b] += part[0]*mass[i*rows + j]*part[1];
                }
    double m = *total = (all[0][0] + all[1][1] + all[2][2])/3;
    lw_vec3 c = *centre = lw_v3_scale(lw_v3(all[1][5], all[2][3], all[0][4]), 1/m);
    const double x[3] = { c.x, c.y, c.z }, square = lw_v3_dot(c, c);
    for (int k = 0; k < 6; k++) {
        int i = entry[k][0], j = entry[k][1];
        inertia[k] = all[3 + i][3 + j] - m*((i == j ? square : 0) - x[i]*x[j]);
    }
}

void lw_super_lump(int n, const lw_vec3 *at, const double *mass, double total, lw_vec3 centre, const double rigid[6], double *lump,
                   double *inertia)
{
    static const int entry[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    int rows = 6*n;
    double sum = 0, lacks[6], value[3];
    lw_mat3 axes;
    memcpy(lacks, rigid, sizeof lacks);
    for (int i = 0; i < rows; i++)
        sum += i%6 < 3 ? mass[i*rows + i]/3 : 0;
    for (int i = 0; i < n; i++) {
        const double *block = mass + 6*i*rows + 6*i;
        lw_vec3 away = lw_v3_sub(at[i], centre);
        const double x[3] = { away.x, away.y, away.z }, square = lw_v3_dot(away, away);
        lump[i] = total/sum*(block[0] + block[rows + 1] + block[2*rows + 2])/3;
        for (int k = 0; k < 6; k++) {
            int a = entry[k][0], b = entry[k][1];
            inertia[6*i + k] = total/sum*block[(3 + a)*rows + 3 + b];
            lacks[k] -= inertia[6*i + k] + lump[i]*((a == b ? square : 0) - x[a]*x[b]);
        }
    }
    lw_m3_principal(lacks, value, &axes);
    for (int i = 0; i < 3; i++) {
        lw_vec3 axis = lw_m3_column(&axes, i);
        const double x[3] = { axis.x, axis.y, axis.z };
        for (int k = 0; k < 6*n && value[i] > 0; k++)
            inertia[k] += value[i]/n*x[entry[k%6][0]]*x[entry[k%6][1]];
    }
}

/* ---- pictures -------------------------------------------------------------------------------------------------- */

static bool are_coupled(int n, const double *stiffness, int i, int k)
{
    static const double rounding = 1e-12;
    double between = 0, own = 0;
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            between = fmax(between, fabs(stiffness[(6*i + a)*6*n + 6*k + b]));
            own = fmax(own, fabs(stiffness[(6*i + a)*6*n + 6*i + b]));
        }
    return between > rounding*own;
}

int lw_super_edges(int n, int n_matrix, const lw_vec3 *at, const double *stiffness, int (**out)[2])
{
    bool reached[LW_SUPER_NODES] = { true };
    int n_edge = 0, (*edge)[2] = *out = malloc((size_t)n*(size_t)n/2*sizeof *edge + 1);
    if (!edge)
        return -1;
    for (int i = 0; i < n; i++)
        for (int k = i + 1; k < n; k++)
            if (are_coupled(n_matrix, stiffness, i, k))
                edge[n_edge][0] = i, edge[n_edge++][1] = k;
    if (n_edge < n*(n - 1)/2)
        return n_edge;
    for (n_edge = 0; n_edge < n - 1; n_edge++) {
        int a = -1, b = -1;
        for (int i = 0; i < n; i++)
            for (int k = 0; k < n; k++)
                if (reached[i] && !reached[k] && (a < 0 || lw_v3_norm(lw_v3_sub(at[k], at[i])) < lw_v3_norm(lw_v3_sub(at[b], at[a]))))
                    a = i, b = k;
        reached[b] = true;
        edge[n_edge][0] = a, edge[n_edge][1] = b;
    }
    return n_edge;
}

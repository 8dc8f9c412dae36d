/* mbs/elastic/beam_space.c - derivation.
 *
 * T is the mid frame, R_b = T exp(g/2), R_a = T exp(-g/2), a = g/|g|, f = |g|/2; d the vector between the nodes, p = T^T d.  For small
 * turns t_a, t_b of the nodes, with m = T^T (t_a + t_b)/2 and w = T^T (t_b - t_a):
 *
 *     dg = A w,      A = k 1 + n g g^T,    k = f/sin f,  n = (1 - k)/(4 f^2)
 *     T turns by  m - q g x w  in its own axes,   q = tan(f/2)/(4 f)
 *     dp = T^T (d r_b - d r_a) + p x (that turn)
 *
 * With the force N by p and the moment M of the strains, c = N x p and h = A M - q c x g, the gradient of U is T N by r_b, T (c/2 + h) by
 * t_b, T (c/2 - h) by t_a.  All is written in the mid frame and turned to ground axes at the end. */
#include "mbs/elastic/beam_space.h"

#include <string.h>
#include "mbs/elastic/beam.h"

void lw_beam_space_stiffness(const lw_section *s, const lw_material *m, double h, double out[6])
{
    double ky = 12*s->zeta_y*m->e*s->iz/(m->g*s->area*h*h), kz = 12*s->zeta_z*m->e*s->iy/(m->g*s->area*h*h);
    out[0] = m->e*s->area/h;
    out[1] = 12*m->e*s->iz/(h*h*h*(1 + ky));
    out[2] = 12*m->e*s->iy/(h*h*h*(1 + kz));
    out[3] = m->g*s->it/h;
    out[4] = m->e*s->iy/h;
    out[5] = m->e*s->iz/h;
}

/* k, n, q and their derivatives by f^2. */
typedef struct factors { double k, n, q, dk, dn, dq; } factors;

static factors factors_of(double f2)
{
    if (f2 < 1e-2)                               /* Taylor's series: f/sin f = 1 + f^2/6 + ..., tan(f/2)/f = 1/2 + f^2/24 + ... */
        return (factors){
            1 + f2*(1./6 + f2*(7./360 + f2*(31./15120 + f2*(127./604800 + f2*(73./3421440))))),
            -0.25*(1./6 + f2*(7./360 + f2*(31./15120 + f2*(127./604800 + f2*(73./3421440))))),
            0.125*(1 + f2*(1./12 + f2*(1./120 + f2*(17./20160 + f2*(31./362880 + f2*(691./79833600)))))),
            1./6 + f2*(7./180 + f2*(31./5040 + f2*(127./151200 + f2*(73./684288)))),
            -0.25*(7./360 + f2*(31./7560 + f2*(127./201600 + f2*(73./855360)))),
            0.125*(1./12 + f2*(1./60 + f2*(17./6720 + f2*(31./90720 + f2*(691./15966720))))) };
    double f = sqrt(f2), s = sin(f), c = cos(f), t = tan(0.5*f), k = f/s, dk = (s - f*c)/(2*f*s*s);
    return (factors){ k, (1 - k)/(4*f2), t/(4*f), dk, (-dk*f2 - (1 - k))/(4*f2*f2),
                      (0.5*(1 + t*t)/(4*f) - t/(4*f2))/(2*f) };
}

/* A M for A = k 1 + n g g^T. */
static lw_vec3 apply(const factors *z, lw_vec3 g, lw_vec3 m)
{
    return lw_v3_add(lw_v3_scale(m, z->k), lw_v3_scale(g, z->n*lw_v3_dot(g, m)));
}

/* The strains at one moment, in the mid frame. */
typedef struct strain { lw_mat3 t; lw_vec3 p, g; factors z; } strain;

lw_mid_frame lw_mid_frame_of(const lw_mat3 *a, const lw_mat3 *b)
{
    lw_quaternion first = lw_quaternion_of_matrix(a), second = lw_quaternion_of_matrix(b);
    lw_vec3 g = lw_quaternion_vector(lw_quaternion_unit(lw_quaternion_times(lw_quaternion_inverse(first), second)));
    lw_quaternion middle = lw_quaternion_times(first, lw_quaternion_of_vector(lw_v3_scale(g, 0.5)));
    factors z = factors_of(0.25*lw_v3_dot(g, g));
    return (lw_mid_frame){ lw_quaternion_matrix(middle), g, z.q, z.dq, z.k, z.n };
}

static strain strain_of(const lw_beam_space *b, const lw_beam_node node[2])
{
    lw_mat3 a = lw_m3_times(&node[0].turn, &b->axes[0]), c = lw_m3_times(&node[1].turn, &b->axes[1]);
    lw_mid_frame mid = lw_mid_frame_of(&a, &c);
    strain s = { .t = mid.turn, .g = mid.g, .z = factors_of(0.25*lw_v3_dot(mid.g, mid.g)) };
    s.p = lw_m3_unapply(&s.t, lw_v3_sub(node[1].at, node[0].at));
    return s;
}

/* Effect of a small motion of the nodes, r and turns in the mid frame: turn of the frame, change of p and g. */
typedef struct change { lw_vec3 turn, p, g; } change;

static change change_of(const strain *s, const lw_vec3 r[2], const lw_vec3 turn[2])
{
    lw_vec3 m = lw_v3_scale(lw_v3_add(turn[0], turn[1]), 0.5), w = lw_v3_sub(turn[1], turn[0]);
    change c = { .turn = lw_v3_sub(m, lw_v3_scale(lw_v3_cross(s->g, w), s->z.q)), .g = apply(&s->z, s->g, w) };
    c.p = lw_v3_add(lw_v3_sub(r[1], r[0]), lw_v3_cross(s->p, c.turn));
    return c;
}

/* Change of the stretch and the shears, e = (p.x - h + (p.y^2 + p.z^2)/2h, p.y, p.z), by that of p; and the force by p of forces w by e. */
static lw_vec3 strain_change(const lw_beam_space *b, lw_vec3 p, lw_vec3 dp) { return lw_v3(dp.x + (p.y*dp.y + p.z*dp.z)/b->length, dp.y, dp.z); }
static lw_vec3 force_of(const lw_beam_space *b, lw_vec3 p, lw_vec3 w) { return lw_v3(w.x, w.y + w.x*p.y/b->length, w.z + w.x*p.z/b->length); }

static lw_vec3 scaled(const double k[3], lw_vec3 a) { return lw_v3(k[0]*a.x, k[1]*a.y, k[2]*a.z); }

static void put(const lw_mat3 *t, lw_vec3 a, double *out)
{
    lw_vec3 g = lw_m3_apply(t, a);
    out[0] = g.x, out[1] = g.y, out[2] = g.z;
}

/* h = A M - q c x g, and its change. */
static lw_vec3 moment(const strain *s, lw_vec3 c, lw_vec3 m)
{
    return lw_v3_sub(apply(&s->z, s->g, m), lw_v3_scale(lw_v3_cross(c, s->g), s->z.q));
}

static lw_vec3 moment_change(const strain *s, lw_vec3 c, lw_vec3 m, lw_vec3 dc, lw_vec3 dm, lw_vec3 dg)
{
    const factors *z = &s->z;
    double df2 = 0.5*lw_v3_dot(s->g, dg), gm = lw_v3_dot(s->g, m);
    lw_vec3 out = apply(z, s->g, dm);
    out = lw_v3_add(out, lw_v3_scale(m, z->dk*df2));
    out = lw_v3_add(out, lw_v3_scale(s->g, z->dn*df2*gm + z->n*lw_v3_dot(dg, m)));
    out = lw_v3_add(out, lw_v3_scale(dg, z->n*gm));
    out = lw_v3_sub(out, lw_v3_scale(lw_v3_cross(c, s->g), z->dq*df2));
    return lw_v3_sub(out, lw_v3_scale(lw_v3_add(lw_v3_cross(dc, s->g), lw_v3_cross(c, dg)), z->q));
}

void lw_beam_space_at(const lw_beam_space *b, const lw_beam_node node[2], bool derivatives, const double *pull, lw_beam_space_state *out)
{
    const double *k = b->stiffness;
    strain s = strain_of(b, node);
    lw_vec3 e = lw_v3(s.p.x - b->length + 0.5*(s.p.y*s.p.y + s.p.z*s.p.z)/b->length, s.p.y, s.p.z);
    lw_vec3 v[2] = { lw_m3_unapply(&s.t, node[0].v), lw_m3_unapply(&s.t, node[1].v) };
    lw_vec3 omega[2] = { lw_m3_unapply(&s.t, node[0].omega), lw_m3_unapply(&s.t, node[1].omega) };
    change rate = change_of(&s, v, omega);
    lw_vec3 rate_e = strain_change(b, s.p, rate.p), w = scaled(k, lw_v3_add(e, lw_v3_scale(rate_e, b->damping))), n = force_of(b, s.p, w);
    lw_vec3 m = scaled(k + 3, lw_v3_add(s.g, lw_v3_scale(rate.g, b->damping)));
    lw_vec3 c = lw_v3_cross(n, s.p), h = moment(&s, c, m), half = lw_v3_scale(c, 0.5);
    out->frame = s.t;
    out->stretch = e.x, out->stretch_rate = rate_e.x;
    out->energy = 0.5*(lw_v3_dot(e, scaled(k, e)) + lw_v3_dot(s.g, scaled(k + 3, s.g)));
    out->power = -b->damping*(lw_v3_dot(rate_e, scaled(k, rate_e)) + lw_v3_dot(rate.g, scaled(k + 3, rate.g)));
    put(&s.t, n, out->force);
    put(&s.t, lw_v3_sub(h, half), out->force + 3);
    put(&s.t, lw_v3_scale(n, -1), out->force + 6);
    put(&s.t, lw_v3_scale(lw_v3_add(h, half), -1), out->force + 9);
    if (derivatives)
        memset(out->by_v, 0, sizeof out->by_v);
    if (pull) {
        w.x = *pull, n = force_of(b, s.p, w), c = lw_v3_cross(n, s.p);
        h = moment(&s, c, m), half = lw_v3_scale(c, 0.5);
    }
    for (int column = 0; derivatives && column < 12; column++) {
        lw_vec3 axis = lw_v3(column%3 == 0, column%3 == 1, column%3 == 2), own = lw_m3_unapply(&s.t, axis);
        lw_vec3 r[2] = { { 0, 0, 0 }, { 0, 0, 0 } }, turn[2] = { { 0, 0, 0 }, { 0, 0, 0 } };
        *(column%6 < 3 ? &r[column/6] : &turn[column/6]) = own;
        change z = change_of(&s, r, turn);
        for (int damp = 0; damp <= (b->damping > 0); damp++) {
            double part = damp ? b->damping : 1;
            lw_vec3 dn = lw_v3_scale(force_of(b, s.p, scaled(k, strain_change(b, s.p, z.p))), part), dm = lw_v3_scale(scaled(k + 3, z.g), part),
                    zero = { 0, 0, 0 };
            if (!damp)
                dn = lw_v3_add(dn, lw_v3_scale(lw_v3(0, z.p.y, z.p.z), w.x/b->length));
            lw_vec3 dc = lw_v3_add(lw_v3_cross(dn, s.p), damp ? zero : lw_v3_cross(n, z.p));
            lw_vec3 dh = moment_change(&s, c, m, dc, dm, damp ? zero : z.g), dhalf = lw_v3_scale(dc, 0.5);
            if (!damp) {                         /* the frame turns with what it shows */
                dn = lw_v3_add(dn, lw_v3_cross(z.turn, n));
                dh = lw_v3_add(dh, lw_v3_cross(z.turn, h));
                dhalf = lw_v3_add(dhalf, lw_v3_cross(z.turn, half));
            }
            double col[12];
            put(&s.t, dn, col);
            put(&s.t, lw_v3_sub(dh, dhalf), col + 3);
            put(&s.t, lw_v3_scale(dn, -1), col + 6);
            put(&s.t, lw_v3_scale(lw_v3_add(dh, dhalf), -1), col + 9);
            for (int i = 0; i < 12; i++)
                (damp ? out->by_v : out->by_x)[i][column] = col[i];
        }
    }
}

void lw_beam_space_mass(const lw_spatial_beam *p, double out[12][12])
{
    const double *k = p->stiffness, polar = p->mass*(p->gyration[0] + p->gyration[1]), h = p->length;
    /* In either plane: along, across, turn of the first node, then of the second; a positive turn about y lowers z. */
    static const int place[2][6] = { { 0, 1, 5, 6, 7, 11 }, { 0, 2, 4, 6, 8, 10 } };
    memset(out, 0, 144*sizeof out[0][0]);
    for (int plane = 0; plane < 2; plane++) {
        double m[6][6], shear = 12*k[5 - plane]/(k[1 + plane]*h*h) - 1;
        lw_beam_mass(p->mass, h, shear, p->gyration[1 - plane], 0, m);
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++)
                out[place[plane][i]][place[plane][j]] = (plane && (i%3 == 2) != (j%3 == 2) ? -1 : 1)*m[i][j];
    }
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++)
            out[6*i + 3][6*j + 3] = polar/(i == j ? 3 : 6);
    const double lump[6] = { p->mass, p->mass, p->mass, polar, p->mass*p->gyration[0], p->mass*p->gyration[1] };
    for (int i = 0; i < 12; i++)
        out[i][i] -= 0.5*lump[i%6];
}

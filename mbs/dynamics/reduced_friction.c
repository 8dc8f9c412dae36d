/* mbs/dynamics/reduced_friction.c - Coulomb friction of a linkage in one coordinate.
 *
 * Friction of joint k is tau_k = -sense side_k mu_k N_k along its measure, N_k the size of its reaction [N], side_k
 * the sign of the measure's derivative by s.  The reactions follow from the forces on the links dyad by dyad, from the
 * last to the first.  Let link 1 of a dyad carry the wrench W1, link 2 W2 (loads less inertia), t1 and t2 the twists
 * that their outer joints allow, and e1, e2 the two wrenches that the inner joint can transmit.  The inner reaction
 * x1 e1 + x2 e2, on link 1, satisfies
 *     t1.(W1 + x1 e1 + x2 e2) = 0,    t2.(W2 - x1 e1 - x2 e2) = 0,
 * and what is left of either link acts on the link that its outer joint holds it to.  Second derivatives of the links
 * by s follow from the transposed equations, from the first dyad to the last.
 *
 * N = |R(N)| is solved by Newton's method: with n the direction of the last reaction, N = n.R, and everything is linear.  Friction
 * F N of an outer joint then adds F n to the translation of t, and friction g N of the inner joint adds (n.e) g to either e: the
 * dyads with friction are solved as those without.  The last equation, of the input's link, gives s''.  Where friction changes a
 * determinant much, the reactions may not be determined: see mbs/equations/friction.h. */
#include "base/real.h"
#include "mbs/dynamics/reduced_internal.h"

#include <string.h>

enum { PASSES = 8 };
static const double weak = 0.5;            /* friction leaves at least this part of each determinant */

/* Rotation, and velocity of the point of the body that is at the origin of the ground frame. */
typedef struct twist { double w; lw_vec2 v; } twist;

static double power_of(twist t, lw_wrench w) { return t.w*w.m + lw_v2_dot(t.v, w.f); }
static twist plus(twist a, double x, twist b) { return (twist){ a.w + x*b.w, lw_v2_add(a.v, lw_v2_scale(b.v, x)) }; }
static lw_wrench wrench_plus(lw_wrench a, double x, lw_wrench b)
{
    return (lw_wrench){ lw_v2_add(a.f, lw_v2_scale(b.f, x)), a.m + x*b.m };
}
static lw_wrench at_point(lw_vec2 p, lw_vec2 f) { return (lw_wrench){ f, lw_v2_cross(p, f) }; }

/* A joint at the registers: its place, direction of the slide, and derivatives by s. */
typedef struct joint_now { lw_reg1 at; lw_vec2 u; double turn; } joint_now;

/* A dyad at the registers.  before: the bodies that its outer joints hold it to; inverse, det: of its 2 x 2 matrix. */
typedef struct group_now { int before[2]; twist t[2]; lw_wrench e[2]; double inverse[2][2], det; } group_now;

typedef struct balance {
    joint_now joint[LW_JOINT_MAX];
    group_now group[LW_DYAD_MAX], rubbed[LW_DYAD_MAX];    /* without friction; with it, linear in the reactions */
    lw_vec2  along[LW_JOINT_MAX];                 /* of the linkage's joints: n times the friction of 1 N on body[1] */
    twist    first[LW_LINK_MAX + 1];              /* of the ground, then of the bodies */
    twist    second[LW_LINK_MAX];                 /* second derivatives of the bodies by s */
    lw_wrench rest[LW_LINK_MAX], by_push[LW_LINK_MAX];   /* loads less inertia at s'' = 0; inertia for s'' = 1 */
    lw_wrench carried[2][LW_LINK_MAX];
    double rate[LW_JOINT_MAX], part[LW_JOINT_MAX];     /* of joints with friction: by s; part times arm */
    double push, mass;                            /* force at s'' = 0 and without friction; M */
} balance;

static twist twist_of(const lw_reduced *r, int body)
{
    const lw_end_point *c = &r->centre[body];
    double w = r->reg[c->dir].d.x;
    const lw_reg1 *o = &r->reg[c->origin];
    return (twist){ w, lw_v2_sub(o->d, lw_v2_scale(lw_v2_perp(o->p), w)) };
}

static twist allowed(const lw_reduced *r, const balance *z, int joint)
{
    const joint_now *j = &z->joint[joint];
    return r->joint[joint].slides ? (twist){ 0, j->u } : (twist){ 1, { j->at.p.y, -j->at.p.x } };
}

/* Rate of the twist that a joint allows, by s. */
static twist allowed_rate(const lw_reduced *r, const balance *z, int joint)
{
    const joint_now *j = &z->joint[joint];
    return r->joint[joint].slides ? (twist){ 0, lw_v2_scale(lw_v2_perp(j->u), j->turn) }
                                  : (twist){ 0, { j->at.d.y, -j->at.d.x } };
}

/* Rate by s of the joint's freedom between two bodies. */
static double rate_between(const lw_reduced *r, const balance *z, int joint, int from, int to)
{
    twist a = z->first[from + 1], b = z->first[to + 1];
    return r->joint[joint].slides ? lw_v2_dot(lw_v2_sub(b.v, a.v), z->joint[joint].u) : b.w - a.w;
}

static void place_joint(const lw_reduced *r, balance *z, int joint)
{
    const lw_reduced_joint *j = &r->joint[joint];
    const lw_end_point *p = &j->point[1];
    const lw_reg1 *u = &r->reg[j->dir[0]];
    z->joint[joint].at = j->pin >= 0 ? r->reg[j->pin] : lw_rate_point(r->reg, p->origin, p->dir, p->arm);
    if (j->slides)
        z->joint[joint].u = lw_v2_turn(j->along, u->p), z->joint[joint].turn = u->d.x;
}

/* A dyad of three pins at a, b and between them c: the same in fewer operations. */
static bool place_pins(const lw_reduced *r, balance *z, int k)
{
    const lw_reduced_group *g = &r->friction->group[k];
    group_now *now = &z->group[k];
    const lw_reg1 *p[3];
    lw_vec2 up[2];
    double w[2];
    for (int i = 0; i < 3; i++)
        p[i] = &r->reg[r->joint[g->joint[i]].pin];
    /* accelerations of c as a point of either link, without those of the links' turns */
    for (int i = 0; i < 2; i++) {
        const lw_reg1 *outer = p[2*i];
        const int *body = r->joint[g->joint[2*i]].body;
        int before = now->before[i] = body[body[0] == g->body[i]];
        twist first = z->first[before + 1], second = before < 0 ? (twist){ 0, { 0, 0 } } : z->second[before];
        w[i] = z->first[g->body[i] + 1].w;
        up[i] = lw_v2_add(lw_v2_add(second.v, lw_v2_scale(lw_v2_perp(outer->p), second.w)),
                          lw_v2_scale(lw_v2_perp(outer->d), first.w));
        now->t[i] = (twist){ 1, { outer->p.y, -outer->p.x } };
    }
    lw_vec2 a = lw_v2_sub(p[1]->p, p[0]->p), b = lw_v2_sub(p[1]->p, p[2]->p);
    double det = lw_v2_cross(a, b), by = 1/det;
    if (!(fabs(det) > 1e-12*(fabs(a.x) + fabs(a.y))*(fabs(b.x) + fabs(b.y))))
        return false;
    now->e[0] = at_point(p[1]->p, lw_v2(1, 0));
    now->e[1] = at_point(p[1]->p, lw_v2(0, 1));
    now->inverse[0][0] = b.x*by, now->inverse[0][1] = -a.x*by;
    now->inverse[1][0] = b.y*by, now->inverse[1][1] = -a.y*by;
    now->det = det;
    /* up0 - w0^2 a + x i a = up1 - w1^2 b + y i b */
    lw_vec2 apart = lw_v2_sub(lw_v2_sub(up[1], lw_v2_scale(b, w[1]*w[1])), lw_v2_sub(up[0], lw_v2_scale(a, w[0]*w[0])));
    double turn[2] = { lw_v2_dot(apart, b)*by, lw_v2_dot(apart, a)*by };
    for (int i = 0; i < 2; i++) {
        const lw_reg1 *outer = p[2*i];
        lw_vec2 v = lw_v2_sub(up[i], lw_v2_scale(lw_v2_perp(outer->p), turn[i]));
        z->second[g->body[i]] = (twist){ turn[i], lw_v2_sub(v, lw_v2_scale(lw_v2_perp(outer->d), w[i])) };
    }
    return true;
}

/* Invert the matrix of a dyad.  false: it is singular. */
static bool invert(group_now *now)
{
    double a = power_of(now->t[0], now->e[0]), b = power_of(now->t[0], now->e[1]);
    double d = power_of(now->t[1], now->e[0]), e = power_of(now->t[1], now->e[1]), by;
    now->det = a*e - b*d;
    by = 1/now->det;
    now->inverse[0][0] = e*by, now->inverse[0][1] = -b*by;
    now->inverse[1][0] = -d*by, now->inverse[1][1] = a*by;
    return fabs(now->det) > 1e-12*(fabs(a) + fabs(b))*(fabs(d) + fabs(e));
}

/* Matrix of a dyad and second derivatives of its links.  false: a dead point. */
static bool place_group(const lw_reduced *r, balance *z, int k)
{
    const lw_reduced_group *g = &r->friction->group[k];
    group_now *now = &z->group[k];
    int inner = g->joint[1];
    twist up[2];
    if (g->pins)
        return place_pins(r, z, k);
    for (int i = 0; i < 3; i++)
        place_joint(r, z, g->joint[i]);
    for (int i = 0; i < 2; i++) {
        int outer = g->joint[2*i];
        const int *body = r->joint[outer].body;
        now->before[i] = body[body[0] == g->body[i]];
        now->t[i] = allowed(r, z, outer);
        up[i] = now->before[i] < 0 ? (twist){ 0, { 0, 0 } } : z->second[now->before[i]];
        up[i] = plus(up[i], rate_between(r, z, outer, now->before[i], g->body[i]), allowed_rate(r, z, outer));
    }
    const joint_now *c = &z->joint[inner];
    if (r->joint[inner].slides) {
        now->e[0] = at_point(c->at.p, lw_v2_perp(c->u));
        now->e[1] = (lw_wrench){ { 0, 0 }, 1 };
    } else {
        now->e[0] = at_point(c->at.p, lw_v2(1, 0));
        now->e[1] = at_point(c->at.p, lw_v2(0, 1));
    }
    if (!invert(now))
        return false;
    /* e.(up1 + x2 t1 + ... - up0 - x1 t0) = e.(rate of the inner joint's twist) */
    twist inner_rate = allowed_rate(r, z, inner), apart = plus(up[1], -1, up[0]);
    apart = plus(apart, -rate_between(r, z, inner, g->body[0], g->body[1]), inner_rate);
    double p = power_of(apart, now->e[0]), q = power_of(apart, now->e[1]);
    double x = now->inverse[0][0]*p + now->inverse[1][0]*q, y = now->inverse[0][1]*p + now->inverse[1][1]*q;
    z->second[g->body[0]] = plus(up[0], x, now->t[0]);
    z->second[g->body[1]] = plus(up[1], -y, now->t[1]);
    return true;
}

/* Wrenches of inertia, and M'/2 s'^2. */
static double place_inertia(const lw_reduced *r, balance *z, double ds)
{
    const lw_dynamics *d = r->dynamics;
    double bend = 0;
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_body *body = &d->model->body[d->s.link[b]];
        lw_reg1 c = r->at[b];
        double w = z->first[b + 1].w, dw = z->second[b].w;
        lw_vec2 dd = lw_v2_add(z->second[b].v, lw_v2_add(lw_v2_scale(lw_v2_perp(c.p), dw),
                                                         lw_v2_scale(lw_v2_perp(c.d), w)));
        lw_wrench second = at_point(c.p, lw_v2_scale(dd, body->mass));
        second.m += body->inertia*dw;
        z->by_push[b] = at_point(c.p, lw_v2_scale(c.d, body->mass));
        z->by_push[b].m += body->inertia*w;
        z->rest[b] = wrench_plus(r->load[b], -ds*ds, second);
        bend += body->mass*lw_v2_dot(c.d, dd) + body->inertia*w*dw;
    }
    return bend*ds*ds;
}

/* Reaction of a joint on the side of `wrench`, as far as friction depends on it. */
static lw_vec2 reaction(const lw_reduced *r, const balance *z, int joint, lw_wrench wrench)
{
    return r->joint[joint].slides ? lw_v2(lw_v2_cross(z->joint[joint].u, wrench.f), 0) : wrench.f;
}

/* Carry n columns of z->carried to the ground; each[c]: reactions of the linkage's joints.  Columns side by side fill the waits for
 * one another of the dyads. */
static inline void carry(const lw_reduced *r, balance *z, const group_now *group, int n, lw_vec2 (*each)[LW_JOINT_MAX])
{
    const lw_reduced_friction *f = r->friction;
    for (int k = f->n_group - 1; k >= 0; k--) {
        const lw_reduced_group *g = &f->group[k];
        const group_now *now = &group[k];
        for (int c = 0; c < n; c++) {
            lw_wrench *carried = z->carried[c], w1 = carried[g->body[0]], w2 = carried[g->body[1]];
            double a = -power_of(now->t[0], w1), b = power_of(now->t[1], w2);
            double x = now->inverse[0][0]*a + now->inverse[0][1]*b, y = now->inverse[1][0]*a + now->inverse[1][1]*b;
            lw_wrench inner = wrench_plus((lw_wrench){ lw_v2_scale(now->e[0].f, x), x*now->e[0].m }, y, now->e[1]);
            w1 = wrench_plus(w1, 1, inner);
            w2 = wrench_plus(w2, -1, inner);
            each[c][g->joint[0]] = reaction(r, z, g->joint[0], w1);
            each[c][g->joint[1]] = reaction(r, z, g->joint[1], inner);
            each[c][g->joint[2]] = reaction(r, z, g->joint[2], w2);
            if (now->before[0] >= 0)
                carried[now->before[0]] = wrench_plus(carried[now->before[0]], 1, w1);
            if (now->before[1] >= 0)
                carried[now->before[1]] = wrench_plus(carried[now->before[1]], 1, w2);
        }
    }
    for (int c = 0; c < n; c++)
        each[c][f->input_joint] = reaction(r, z, f->input_joint, z->carried[c][f->input_body]);
}

/* Add the wrenches of friction `force` along the measure of joint i with friction. */
static void push(const lw_reduced *r, balance *z, int i, double force)
{
    int joint = r->friction->joint[i];
    const lw_reduced_joint *j = &r->joint[joint];
    lw_wrench w = { { 0, 0 }, j->sign*force };
    if (j->slides)
        w = at_point(z->joint[joint].at.p, lw_v2_scale(z->joint[joint].u, j->sign*force));
    for (int side = 0; side < 2; side++)
        if (j->body[side] >= 0)
            z->carried[0][j->body[side]] = wrench_plus(z->carried[0][j->body[side]], side ? 1 : -1, w);
}

/* Reactions for given sizes, which are those of friction; returns the force of the friction. */
static double reactions(const lw_reduced *r, balance *z, const double *size, lw_vec2 *out)
{
    const lw_reduced_friction *f = r->friction;
    lw_vec2 each[1][LW_JOINT_MAX];
    double q = 0;
    for (int i = 0; i < f->n; i++)
        q -= z->part[i]*size[i]*z->rate[i];
    double dds = (z->push + q)/z->mass;
    for (int b = 0; b < r->dynamics->s.n_body; b++)
        z->carried[0][b] = wrench_plus(z->rest[b], -dds, z->by_push[b]);
    for (int i = 0; i < f->n; i++)
        push(r, z, i, -z->part[i]*size[i]);
    carry(r, z, z->group, 1, each);
    for (int i = 0; i < f->n; i++)
        out[i] = each[0][f->joint[i]];
    return q;
}

/* Newton's method for N = |R(N)|, R being affine in N. */
static lw_status by_newton(const lw_reduced *r, balance *z, double *size)
{
    int n = r->friction->n;
    double one[LW_JOINT_MAX] = { 0 };
    lw_vec2 rest[LW_JOINT_MAX], *response = r->friction->response;
    reactions(r, z, one, rest);
    for (int k = 0; k < n; k++) {
        one[k] = 1;
        reactions(r, z, one, response + k*n);
        one[k] = 0;
        for (int j = 0; j < n; j++)
            response[j + k*n] = lw_v2_sub(response[j + k*n], rest[j]);
    }
    return lw_friction_sizes(n, 0, 2, &rest[0].x, &response[0].x, size, r->friction->work, NULL);
}

/* The friction on a body at a joint, for 1 N and along the measure of the joint, times n. */
static lw_vec2 along(const lw_reduced *r, const balance *z, int joint, int body)
{
    return r->joint[joint].body[1] == body ? z->along[joint] : lw_v2_scale(z->along[joint], -1);
}

/* The dyads with friction that is linear in the reactions.  false: it changes a determinant much. */
static bool rub(const lw_reduced *r, balance *z)
{
    const lw_reduced_friction *f = r->friction;
    for (int i = 0; i < f->n; i++) {
        int joint = f->joint[i];
        lw_vec2 n = f->reaction[i];
        double by = f->size[i] != 0 ? -r->joint[joint].sign*z->part[i]/f->size[i] : 0;
        z->along[joint] = lw_v2_scale(r->joint[joint].slides ? lw_v2_scale(lw_v2_perp(z->joint[joint].u), n.x) : n, by);
    }
    for (int k = 0; k < f->n_group; k++) {
        const lw_reduced_group *g = &f->group[k];
        const group_now *plain = &z->group[k];
        group_now *now = &z->rubbed[k];
        lw_vec2 inner = along(r, z, g->joint[1], g->body[0]);
        *now = *plain;
        for (int i = 0; i < 2; i++)
            now->t[i].v = lw_v2_add(plain->t[i].v, along(r, z, g->joint[2*i], g->body[i]));
        for (int i = 0; i < 2; i++) {
            double force = lw_v2_dot(inner, plain->e[i].f);
            const joint_now *c = &z->joint[g->joint[1]];
            now->e[i] = wrench_plus(plain->e[i], force, r->joint[g->joint[1]].slides ? at_point(c->at.p, c->u)
                                                                                  : (lw_wrench){ { 0, 0 }, 1 });
        }
        if (!invert(now) || !(now->det/plain->det > weak))
            return false;
    }
    return true;
}

/* each[0]: reactions of the linkage's joints, where friction is linear in them.  false: the friction changes a determinant much. */
static bool linear_reactions(const lw_reduced *r, balance *z, lw_vec2 (*each)[LW_JOINT_MAX])
{
    const lw_reduced_friction *f = r->friction;
    int input = f->input_joint, body = f->input_body, n_body = r->dynamics->s.n_body;
    twist t = allowed(r, z, input);
    double size = rate_between(r, z, input, -1, body);
    if (!rub(r, z))
        return false;
    t.v = lw_v2_add(t.v, along(r, z, input, body));
    memcpy(z->carried[0], z->rest, (size_t)n_body*sizeof *z->rest);
    memcpy(z->carried[1], z->by_push, (size_t)n_body*sizeof *z->by_push);
    carry(r, z, z->rubbed, 2, each);
    double mass = power_of(t, z->carried[1][body]), dds = power_of(t, z->carried[0][body])/mass;
    for (int i = 0; i < f->n; i++) {
        int j = f->joint[i];
        each[0][j] = lw_v2_sub(each[0][j], lw_v2_scale(each[1][j], dds));
    }
    return mass*size > weak*z->mass;
}

/* Sizes from the reactions of the last evaluation on, by Newton's method; *q: force of the friction. */
static lw_status find_sizes(lw_reduced *r, balance *z, double *q)
{
    lw_reduced_friction *f = r->friction;
    lw_vec2 each[2][LW_JOINT_MAX];
    bool found = false;
    for (int pass = 0; pass < PASSES && !found && linear_reactions(r, z, each); pass++) {
        double off = 0, greatest = 0;
        *q = 0;
        for (int i = 0; i < f->n; i++) {
            lw_vec2 now = each[0][f->joint[i]];
            double size = f->press[i] != 0 ? f->press[i]*now.x : sqrt(lw_v2_dot(now, now));
            double more = fabs(size - (f->size[i] != 0 ? lw_v2_dot(f->reaction[i], now)/f->size[i] : 0));
            off = more > off ? more : off;
            greatest = size > greatest ? size : greatest;
            f->reaction[i] = now;
            f->size[i] = size;
            *q -= z->part[i]*size*z->rate[i];
        }
        found = !(off > f->tolerance*greatest);
    }
    if (found)
        return LW_OK;
    if (by_newton(r, z, f->size) == LW_OK) {
        *q = reactions(r, z, f->size, f->reaction);
        return LW_OK;
    }
    memset(f->size, 0, (size_t)f->n*sizeof *f->size);
    f->undetermined = true;
    return LW_OPEN;
}

lw_status lw_reduced_friction_add(lw_reduced *r, double ds, double mass, double *q, double *power)
{
    lw_reduced_friction *f = r->friction;
    balance z;
    double drag;
    z.mass = mass;
    z.first[0] = (twist){ 0, { 0, 0 } };
    for (int b = 0; b < r->dynamics->s.n_body; b++)
        z.first[b + 1] = twist_of(r, b);
    place_joint(r, &z, f->input_joint);
    z.second[f->input_body] = (twist){ 0, { 0, 0 } };
    for (int k = 0; k < f->n_group; k++)
        if (!place_group(r, &z, k))
            return LW_OPEN;
    memset(z.along, 0, (size_t)r->linkage.n_joint*sizeof *z.along);
    z.push = *q - place_inertia(r, &z, ds);
    for (int i = 0; i < f->n; i++) {
        z.rate[i] = lw_reduced_joint_rate(r, f->joint[i]);
        z.part[i] = f->sense*f->side[i]*f->arm[i];
        f->feel[i] = fabs(z.part[i]*z.rate[i])/sqrt(mass);
    }
    f->undetermined = false;
    lw_status s = find_sizes(r, &z, &drag);
    if (s != LW_OK)
        return s;
    *q += drag;
    *power += drag*ds;
    return LW_OK;
}

/* ---- reversals ---------------------------------------------------------------------------------------- */

static lw_status rates_at(lw_reduced *r, double input, double *rate)
{
    lw_status s = lw_reduced_registers(r, input);
    for (int i = 0; s == LW_OK && i < r->friction->n; i++)
        rate[i] = lw_reduced_joint_rate(r, r->friction->joint[i]);
    return s;
}

static const double look = 1e-5;             /* distance at which the side after a reversal shows, in units of s */
static const double idle = 1e-13;            /* rates below this are rounding, in the same units */

lw_status lw_reduced_friction_sides(lw_reduced *r, double input, double direction)
{
    lw_reduced_friction *f = r->friction;
    double rate[LW_JOINT_MAX], ahead[LW_JOINT_MAX];
    lw_status s = rates_at(r, input + (direction < 0 ? -look : look)*r->scale, ahead);
    if (s == LW_OK)
        s = rates_at(r, input, rate);
    for (int i = 0; i < f->n && s == LW_OK; i++) {
        double unit = r->scale/(r->joint[f->joint[i]].slides ? r->dynamics->s.unit : 1);
        double g = fabs(rate[i]) > 1e-3*fabs(ahead[i] - rate[i]) ? rate[i] : ahead[i];
        f->side[i] = fabs(g)*unit > idle ? (g > 0) - (g < 0) : 0;
    }
    return s;
}

/* Zero of the rate of joint i with friction between a and b, by the Illinois method. */
static lw_status reversal_between(lw_reduced *r, int i, double a, double b, double at_a, double at_b, double *out)
{
    lw_status s = LW_OK;
    int joint = r->friction->joint[i], side = 0;
    for (int k = 0; k < 60 && s == LW_OK && fabs(b - a) > 4e-16*(fabs(a) + fabs(b)); k++) {
        double x = a + (b - a)*at_a/(at_a - at_b);
        s = lw_reduced_registers(r, x);
        double now = lw_reduced_joint_rate(r, joint);
        *out = x;
        if (now == 0 || x == a || x == b)
            break;
        if ((now > 0) == (at_b > 0)) {
            b = x, at_b = now;
            at_a *= side == 1 ? 0.5 : 1;
            side = 1;
        } else {
            a = x, at_a = now;
            at_b *= side == -1 ? 0.5 : 1;
            side = -1;
        }
    }
    return s;
}

/* Cells begin at this part of their width: reversals of symmetric linkages are at simple fractions of a turn. */
static const double shift = 0.3819660112501051;

/* The cell of this number.  Two reversals of one joint within a cell are not seen; the joint hardly moves between. */
static lw_status reversals_of(lw_reduced *r, long number, double width, const lw_reversal_cell **out)
{
    lw_reduced_friction *f = r->friction;
    long turn = number - LW_REVERSAL_CELLS*(long)floor((double)number/LW_REVERSAL_CELLS);
    lw_reversal_cell *c = &f->cell[turn];
    double before[LW_JOINT_MAX], behind[LW_JOINT_MAX];
    *out = c;
    if (!r->plan.input_is_slider)
        number = turn;
    if (c->number == number + 1)
        return LW_OK;
    double low = ((double)number + shift)*width, high = ((double)number + 1 + shift)*width;
    bool last = !r->plan.input_is_slider && turn == LW_REVERSAL_CELLS - 1;       /* it ends where the first begins */
    lw_status s = rates_at(r, low, before);
    if (s == LW_OK)
        s = rates_at(r, last ? shift*width : high, behind);
    c->n = 0;
    for (int i = 0; i < f->n && s == LW_OK && c->n < LW_REVERSAL_MOST; i++)
        if (f->side[i] != 0 && (before[i] < 0) != (behind[i] < 0))
            s = reversal_between(r, i, low, high, before[i], behind[i], &c->at[c->n++]);
    c->number = s == LW_OK ? number + 1 : 0;             /* 0: not known */
    return s;
}

lw_status lw_reduced_next_reversal(lw_reduced *r, double input, double direction, double *next)
{
    double width = (r->plan.input_is_slider ? 4*r->scale : 2*LW_PI)/LW_REVERSAL_CELLS;
    double around = r->plan.input_is_slider ? 0 : 2*LW_PI;
    long first = (long)floor(input/width - shift);
    int sense = direction < 0 ? -1 : 1;
    for (int k = 0; k < LW_REVERSAL_CELLS/2; k++) {
        long number = first + sense*k;
        const lw_reversal_cell *c;
        double turns = around*floor((double)number/LW_REVERSAL_CELLS);
        lw_status s = reversals_of(r, number, width, &c);
        if (s != LW_OK && s != LW_OPEN)
            return s;
        /* near a dead point look again at each cell, which the motion does not reach */
        *next = ((double)(number + (sense > 0)) + shift)*width;
        if (s == LW_OPEN)
            return LW_OK;
        bool found = false;
        for (int i = 0; i < c->n; i++) {
            double at = c->at[i] + turns;
            if (sense*(at - input) > 1e-9*r->scale && (!found || sense*(at - *next) < 0))
                *next = at, found = true;
        }
        if (found)
            return LW_OK;
    }
    return LW_OK;
}

/* mbs/reduced/friction.c - Coulomb friction of a linkage in one coordinate.
 *
 * Friction of joint k is tau_k = -sense side_k mu_k N_k along its measure, N_k the size of its reaction [N], side_k
 * the sign of the measure's derivative by s; that of a joint with a "speed" has tanh(rate/speed) in place of sense side_k.
 * The reactions follow from the forces on the links dyad by dyad, from the last to the first.
 * Let link 1 of a dyad carry the wrench W1, link 2 W2 (loads less inertia), t1 and t2 the twists
 * that their outer joints allow, and e1, e2 the two wrenches that the inner joint can transmit.  The inner reaction
 * x1 e1 + x2 e2, on link 1, satisfies
 *     t1.(W1 + x1 e1 + x2 e2) = 0,    t2.(W2 - x1 e1 - x2 e2) = 0,
 * and what is left of either link acts on the link that its outer joint holds it to.  Second derivatives of the links
 * by s follow from the transposed equations, from the first dyad to the last.
 *
 * N = |R(N)| is solved by Newton's method, from the reactions that the last evaluations predict: with n the direction of a reaction,
 * N = n.R, and everything is linear.  Friction F N of an outer joint then adds F n to the translation of t, and friction g N of the inner
 * joint adds (n.e) g to either e: the dyads with friction are solved as those without.  The last equation, of the
 * input's link, gives s''.  Where friction changes a determinant much, the reactions may not be determined: see mbs/equations/friction.h. */
#include "base/real.h"
#include "mbs/reduced/reduced_internal.h"

#include <string.h>

enum { PASSES = 8 };
static const double weak = 0.5;            /* friction leaves at least this part of each determinant */
static const double most_weight = 20;      /* sum of the weights of a prediction, by which errors of its values grow */
static const double far = 0.01;            /* error of a size over the greatest size: earlier reactions do not predict this one */

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

/* A dyad at the registers.  inverse, det: of its 2 x 2 matrix. */
typedef struct group_now { twist t[2]; lw_wrench e[2]; double inverse[2][2], det; } group_now;

/* Two right-hand sides, solved side by side. */
typedef double columns __attribute__((vector_size(16)));
typedef struct wrenches { columns x, y, m; } wrenches;

typedef struct balance {
    joint_now joint[LW_JOINT_MAX];
    group_now group[LW_DYAD_MAX];                 /* without friction */
    twist    first[LW_LINK_MAX + 1];              /* of the ground, then of the bodies */
    twist    second[LW_LINK_MAX];                 /* second derivatives of the bodies by s */
    wrenches load[LW_LINK_MAX];                   /* less inertia at s'' = 0, and inertia for s'' = 1 */
    wrenches carried[LW_LINK_MAX];
    /* Of joints with friction, and in slot n of all others. */
    double x[2][LW_JOINT_MAX + 1], y[2][LW_JOINT_MAX + 1];     /* reactions, of both right-hand sides */
    double nx[LW_JOINT_MAX], ny[LW_JOINT_MAX];    /* directions of the reactions */
    double force[LW_JOINT_MAX];                   /* friction on body[1] for a reaction of 1 N */
    double ax[LW_JOINT_MAX + 1], ay[LW_JOINT_MAX + 1];         /* the same for a force f: ax f.x + ay f.y */
    double rate[LW_JOINT_MAX], part[LW_JOINT_MAX];     /* by s; part times arm */
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
    const twist *a = &z->first[from + 1], *b = &z->first[to + 1];
    return r->joint[joint].slides ? lw_v2_dot(lw_v2_sub(b->v, a->v), z->joint[joint].u) : b->w - a->w;
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
        int before = g->before[i];
        twist first = z->first[before + 1], second = before < 0 ? (twist){ 0, { 0, 0 } } : z->second[before];
        w[i] = z->first[g->body[i] + 1].w;
        up[i] = lw_v2_add(lw_v2_add(second.v, lw_v2_scale(lw_v2_perp(outer->p), second.w)), lw_v2_scale(lw_v2_perp(outer->d), first.w));
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
        int outer = g->joint[2*i], before = g->before[i];
        now->t[i] = allowed(r, z, outer);
        up[i] = before < 0 ? (twist){ 0, { 0, 0 } } : z->second[before];
        up[i] = plus(up[i], rate_between(r, z, outer, before, g->body[i]), allowed_rate(r, z, outer));
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
        lw_vec2 dd = lw_v2_add(z->second[b].v, lw_v2_add(lw_v2_scale(lw_v2_perp(c.p), dw), lw_v2_scale(lw_v2_perp(c.d), w)));
        lw_wrench second = at_point(c.p, lw_v2_scale(dd, body->mass));
        second.m += body->inertia*dw;
        lw_wrench first = at_point(c.p, lw_v2_scale(c.d, body->mass)), rest = wrench_plus(r->load[b], -ds*ds, second);
        first.m += body->inertia*w;
        z->load[b] = (wrenches){ { rest.f.x, first.f.x }, { rest.f.y, first.f.y }, { rest.m, first.m } };
        bend += body->mass*lw_v2_dot(c.d, dd) + body->inertia*w*dw;
    }
    return bend*ds*ds;
}

static columns powers_of(twist t, const wrenches *w) { return t.w*w->m + t.v.x*w->x + t.v.y*w->y; }
static columns at_rate(columns c, double dds) { return (columns){ c[0] - dds*c[1], 0 }; }
static void add(wrenches *to, const wrenches *w) { to->x += w->x, to->y += w->y, to->m += w->m; }

static void put(balance *z, int slot, columns x, columns y)
{
    z->x[0][slot] = x[0], z->x[1][slot] = x[1];
    z->y[0][slot] = y[0], z->y[1][slot] = y[1];
}

/* Store the part of a joint's reaction on the side of w that its friction depends on. */
static void react(const lw_reduced *r, balance *z, int joint, int slot, const wrenches *w)
{
    columns x = w->x, y = w->y;
    if (r->joint[joint].slides) {
        lw_vec2 u = z->joint[joint].u;
        x = u.x*w->y - u.y*w->x;
        y = (columns){ 0, 0 };
    }
    put(z, slot, x, y);
}

/* Add the reaction of an outer joint of a dyad to the link before it. */
static void hand_on(balance *z, const lw_reduced_group *g, int side, const wrenches *w)
{
    if (g->before[side] >= 0)
        add(&z->carried[g->before[side]], w);
}

/* Carry z->carried from the links of dyad k to those before them. */
static void carry(const lw_reduced *r, balance *z, int k, const group_now *now)
{
    const lw_reduced_group *g = &r->friction->group[k];
    wrenches w1 = z->carried[g->body[0]], w2 = z->carried[g->body[1]], inner;
    columns a = -powers_of(now->t[0], &w1), b = powers_of(now->t[1], &w2);
    columns x = now->inverse[0][0]*a + now->inverse[0][1]*b, y = now->inverse[1][0]*a + now->inverse[1][1]*b;
    inner.x = now->e[0].f.x*x + now->e[1].f.x*y;
    inner.y = now->e[0].f.y*x + now->e[1].f.y*y;
    inner.m = now->e[0].m*x + now->e[1].m*y;
    add(&w1, &inner);
    w2.x -= inner.x, w2.y -= inner.y, w2.m -= inner.m;
    react(r, z, g->joint[0], g->slot[0], &w1);
    react(r, z, g->joint[1], g->slot[1], &inner);
    react(r, z, g->joint[2], g->slot[2], &w2);
    hand_on(z, g, 0, &w1);
    hand_on(z, g, 1, &w2);
}

/* add_friction and carry of a dyad of three pins in fewer operations.  false: friction changes its determinant much. */
static bool carry_pins(balance *z, const lw_reduced_group *g, const group_now *plain)
{
    wrenches w1 = z->carried[g->body[0]], w2 = z->carried[g->body[1]];
    double m[2] = { plain->e[0].m + g->side[1]*z->ax[g->slot[1]], plain->e[1].m + g->side[1]*z->ay[g->slot[1]] };
    lw_vec2 v[2];
    for (int i = 0; i < 2; i++) {
        int slot = g->slot[2*i];
        double side = g->side[2*i];
        v[i] = lw_v2_add(plain->t[i].v, lw_v2(side*z->ax[slot], side*z->ay[slot]));
    }
    double a = m[0] + v[0].x, b = m[1] + v[0].y, c = m[0] + v[1].x, d = m[1] + v[1].y, det = a*d - b*c, by = 1/det;
    if (!(det*plain->det > weak*plain->det*plain->det))
        return false;
    columns p = w1.m + v[0].x*w1.x + v[0].y*w1.y, q = w2.m + v[1].x*w2.x + v[1].y*w2.y;
    columns x = -(d*by)*p - (b*by)*q, y = (c*by)*p + (a*by)*q, moment = m[0]*x + m[1]*y;
    w1.x += x, w1.y += y, w1.m += moment;
    w2.x -= x, w2.y -= y, w2.m -= moment;
    put(z, g->slot[0], w1.x, w1.y);
    put(z, g->slot[1], x, y);
    put(z, g->slot[2], w2.x, w2.y);
    hand_on(z, g, 0, &w1);
    hand_on(z, g, 1, &w2);
    return true;
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
            add(&z->carried[j->body[side]], &(wrenches){ { side ? w.f.x : -w.f.x }, { side ? w.f.y : -w.f.y }, { side ? w.m : -w.m } });
}

/* Reactions for given sizes, which are those of friction; returns the force of the friction. */
static double reactions(const lw_reduced *r, balance *z, const double *size, lw_vec2 *out)
{
    const lw_reduced_friction *f = r->friction;
    double q = 0;
    for (int i = 0; i < f->n; i++)
        q -= z->part[i]*size[i]*z->rate[i];
    double dds = (z->push + q)/z->mass;
    for (int b = 0; b < r->dynamics->s.n_body; b++)
        z->carried[b] = (wrenches){ at_rate(z->load[b].x, dds), at_rate(z->load[b].y, dds), at_rate(z->load[b].m, dds) };
    for (int i = 0; i < f->n; i++)
        push(r, z, i, -z->part[i]*size[i]);
    for (int k = f->n_group - 1; k >= 0; k--)
        carry(r, z, k, &z->group[k]);
    react(r, z, f->input_joint, f->input_slot, &z->carried[f->input_body]);
    for (int i = 0; i < f->n; i++)
        out[i] = lw_v2(z->x[0][i], z->y[0][i]);
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

/* Directions of the reactions last found or predicted, and the friction along them. */
static void set_directions(const lw_reduced *r, balance *z)
{
    const lw_reduced_friction *f = r->friction;
    for (int i = 0; i < f->n; i++) {
        double by = f->size[i] != 0 ? 1/f->size[i] : 0;
        z->nx[i] = by*f->x[i];
        z->ny[i] = by*f->y[i];
        z->ax[i] = z->force[i]*z->nx[i];
        z->ay[i] = z->force[i]*z->ny[i];
    }
    for (int k = 0; k < f->n_slide; k++) {
        int i = f->slide[k];
        lw_vec2 u = z->joint[f->joint[i]].u;
        z->ay[i] = u.x*z->ax[i];
        z->ax[i] *= -u.y;
    }
}

/* The equations of dyad k with friction linear in its reactions.  false: friction changes the determinant much. */
static bool add_friction(const lw_reduced *r, const balance *z, int k, group_now *now)
{
    const lw_reduced_group *g = &r->friction->group[k];
    const group_now *plain = &z->group[k];
    const joint_now *c = &z->joint[g->joint[1]];
    lw_vec2 along = lw_v2(z->ax[g->slot[1]], z->ay[g->slot[1]]);
    for (int i = 0; i < 2; i++) {
        double force = g->side[1]*lw_v2_dot(along, plain->e[i].f), side = g->side[2*i];
        int outer = g->slot[2*i];
        now->t[i] = plain->t[i];
        now->t[i].v = lw_v2_add(plain->t[i].v, lw_v2(side*z->ax[outer], side*z->ay[outer]));
        now->e[i] = wrench_plus(plain->e[i], force, r->joint[g->joint[1]].slides ? at_point(c->at.p, c->u) : (lw_wrench){ { 0, 0 }, 1 });
    }
    return invert(now) && now->det/plain->det > weak;
}

/* The next f->x and f->y, where friction is linear in them.  false: the friction changes a determinant much. */
static bool linear_reactions(const lw_reduced *r, balance *z)
{
    lw_reduced_friction *f = r->friction;
    int input = f->input_joint, body = f->input_body;
    twist t = allowed(r, z, input);
    double size = rate_between(r, z, input, -1, body), side = r->joint[input].body[1] == body ? 1 : -1;
    group_now now;
    set_directions(r, z);
    memcpy(z->carried, z->load, (size_t)r->dynamics->s.n_body*sizeof *z->load);
    for (int k = f->n_group - 1; k >= 0; k--) {
        bool pins = f->group[k].pins;
        if (!(pins ? carry_pins(z, &f->group[k], &z->group[k]) : add_friction(r, z, k, &now)))
            return false;
        if (!pins)
            carry(r, z, k, &now);
    }
    react(r, z, input, f->input_slot, &z->carried[body]);
    t.v = lw_v2_add(t.v, lw_v2(side*z->ax[f->input_slot], side*z->ay[f->input_slot]));
    columns p = powers_of(t, &z->carried[body]);
    double mass = p[1], dds = p[0]/mass;
    if (!(mass*size > weak*z->mass))
        return false;
    for (int i = 0; i < f->n; i++) {
        f->x[i] = z->x[0][i] - dds*z->x[1][i];
        f->y[i] = z->y[0][i] - dds*z->y[1][i];
    }
    return true;
}

/* Sizes of the reactions f->x and f->y. */
static void measure(lw_reduced_friction *f)
{
    for (int i = 0; i < f->n; i++)
        f->size[i] = sqrt(f->x[i]*f->x[i] + f->y[i]*f->y[i]);
    for (int k = 0; k < f->n_slide; k++)
        if (f->press[f->slide[k]] != 0)
            f->size[f->slide[k]] = f->press[f->slide[k]]*f->x[f->slide[k]];
}

/* Reactions and sizes at t by the polynomial through those of the last evaluations. */
static void predict(lw_reduced_friction *f, double t)
{
    const lw_reaction_past *past[LW_REACTION_PAST];
    double weight[LW_REACTION_PAST], sum = INFINITY;
    int n = f->n_past;
    for (int k = 0; k < n; k++)
        past[k] = &f->past[(f->newest + LW_REACTION_PAST - k)%LW_REACTION_PAST];
    for (; n > 0 && !(sum <= most_weight); n -= !(sum <= most_weight)) {
        sum = 0;
        for (int k = 0; k < n; k++) {
            double top = 1, bottom = 1;
            for (int j = 0; j < n; j++)
                if (j != k)
                    top *= t - past[j]->t, bottom *= past[k]->t - past[j]->t;
            weight[k] = top/bottom;
            sum += fabs(weight[k]);
        }
    }
    for (int k = 0; k < n; k++)
        for (int i = 0; i < f->n; i++) {
            f->x[i] = weight[k]*past[k]->x[i] + (k ? f->x[i] : 0);
            f->y[i] = weight[k]*past[k]->y[i] + (k ? f->y[i] : 0);
        }
    if (n > 0)
        measure(f);
}

/* Keep the reactions at t for predictions, in place of those at the same t or of the oldest. */
static void keep(lw_reduced_friction *f, double t)
{
    int at = (f->newest + 1)%LW_REACTION_PAST;
    for (int k = 0; k < f->n_past; k++) {
        int old = (f->newest + LW_REACTION_PAST - k)%LW_REACTION_PAST;
        at = f->past[old].t == t ? old : at;
    }
    if (at == (f->newest + 1)%LW_REACTION_PAST) {
        f->newest = at;
        f->n_past += f->n_past < LW_REACTION_PAST;
    }
    f->past[at].t = t;
    memcpy(f->past[at].x, f->x, (size_t)f->n*sizeof *f->x);
    memcpy(f->past[at].y, f->y, (size_t)f->n*sizeof *f->y);
}

void lw_reduced_friction_expect(lw_reduced_friction *f, double t, const lw_vec2 *reaction)
{
    f->n_past = 1;
    f->past[f->newest].t = t;
    for (int i = 0; i < f->n; i++)
        f->past[f->newest].x[i] = reaction[i].x, f->past[f->newest].y[i] = reaction[i].y;
}

/* Sizes from predicted reactions on, by Newton's method; *q: force of the friction. */
static lw_status find_sizes(lw_reduced *r, balance *z, double *q)
{
    lw_reduced_friction *f = r->friction;
    bool found = false;
    for (int pass = 0; pass < PASSES && !found && linear_reactions(r, z); pass++) {
        double off = 0, greatest = 0;
        *q = 0;
        measure(f);
        for (int i = 0; i < f->n; i++) {
            double more = fabs(f->size[i] - (z->nx[i]*f->x[i] + z->ny[i]*f->y[i]));
            off = more > off ? more : off;
            greatest = f->size[i] > greatest ? f->size[i] : greatest;
            *q -= z->part[i]*f->size[i]*z->rate[i];
        }
        found = !(off > f->tolerance*greatest);
        if (off > far*greatest)
            f->n_past = 0;
    }
    if (found)
        return LW_OK;
    f->n_past = 0;
    lw_vec2 out[LW_JOINT_MAX];
    if (by_newton(r, z, f->size) == LW_OK) {
        *q = reactions(r, z, f->size, out);
        for (int i = 0; i < f->n; i++)
            f->x[i] = out[i].x, f->y[i] = out[i].y;
        return LW_OK;
    }
    memset(f->size, 0, (size_t)f->n*sizeof *f->size);
    f->undetermined = true;
    return LW_OPEN;
}

lw_status lw_reduced_friction_add(lw_reduced *r, double t, double ds, double mass, double *q, double *power)
{
    lw_reduced_friction *f = r->friction;
    balance z;
    double drag, by_mass = 1/sqrt(mass);
    z.mass = mass;
    z.first[0] = (twist){ 0, { 0, 0 } };
    for (int b = 0; b < r->dynamics->s.n_body; b++)
        z.first[b + 1] = twist_of(r, b);
    place_joint(r, &z, f->input_joint);
    z.second[f->input_body] = (twist){ 0, { 0, 0 } };
    for (int k = 0; k < f->n_group; k++)
        if (!place_group(r, &z, k))
            return LW_OPEN;
    z.ax[f->n] = z.ay[f->n] = 0;
    z.push = *q - place_inertia(r, &z, ds);
    for (int i = 0; i < f->n; i++) {
        const lw_reduced_joint *j = &r->joint[f->joint[i]];
        z.rate[i] = j->sign*rate_between(r, &z, f->joint[i], j->body[0], j->body[1]);
        const lw_friction_joint *own = &r->dynamics->friction[i];
        z.part[i] = own->ideal ? f->sense*f->side[i]*f->arm[i] : -lw_friction_push(own, z.rate[i]*ds);
        z.force[i] = -j->sign*z.part[i];
        f->feel[i] = fabs(z.part[i]*z.rate[i])*by_mass;
        if (own->ideal && z.part[i] != f->part[i])           /* the reactions jump */
            f->n_past = 0;
        f->part[i] = z.part[i];
    }
    f->undetermined = false;
    predict(f, t);
    lw_status s = find_sizes(r, &z, &drag);
    if (s != LW_OK)
        return s;
    keep(f, t);
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
        f->side[i] = r->dynamics->friction[i].ideal && fabs(g)*unit > idle ? (g > 0) - (g < 0) : 0;
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
    *next = sense*INFINITY;
    for (int k = 0; k < LW_REVERSAL_CELLS/2 && r->friction->set_valued; k++) {
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

/* cli/motion/simulate_balance.c - counterweights that hold the common centre of mass still.
 *
 * The shaking force of masses in motion is -M times the acceleration of their common centre.  A counterweight m at the
 * place a (from a pin J of its link, in the link's frame) adds m J(t) and m a turned by the link's angle; with p = m a
 *     sum of m c(t) + sum over links of (m_l J_l(t) + turn_l(t) p_l)  =  constant.
 * On links that turn about ground pins J stands still, and this is linear in the p: least squares over the sampled
 * postures.  Where they do not remove all of it, links that float get weights too, the one that helps most first; their
 * masses |p|/radius are found by repetition.  Where a force remains, no such weights remove all of it (Berkof &
 * Lowen 1969: every link must reach ground by pins alone). */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/rank.h"
#include "cli/program/output.h"
#include "cli/motion/simulate.h"

#define UNKNOWNS (2*LW_LINK_MAX + 2)

typedef struct balance {
    const lw_system *s;
    int    n_link, body[LW_LINK_MAX], joint[LW_LINK_MAX];
    bool   floats[LW_LINK_MAX];
    double radius[LW_LINK_MAX], weight[LW_LINK_MAX];     /* of counterweights: from the pin, masses      */
    double mass;                          /* of all moving links                                        */
} balance;

/* A counterweight as far out on its link as the link's other joints are. */
static double radius_of(const cli_simulate *c, const balance *b, int l)
{
    const lw_linkage *k = &c->model->linkage;
    int link = b->s->link[b->body[l]];
    double far = 0;
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].link[0] == link || k->joint[j].link[1] == link)
            far = fmax(far, lw_v2_norm(lw_v2_sub(k->joint[j].at, k->joint[b->joint[l]].at)));
    return far > 0 ? far : b->s->unit;
}

static void add_link(const cli_simulate *c, balance *b, int body, int joint, bool floats)
{
    int l = b->n_link++;
    b->body[l] = body;
    b->joint[l] = joint;
    b->floats[l] = floats;
    b->weight[l] = 0;
    b->radius[l] = radius_of(c, b, l);
}

/* Links that turn about a pin at the ground. */
static void find_links(const cli_simulate *c, balance *b)
{
    b->s = lw_dynamics_system(c->d);
    for (int j = 0; j < b->s->n_joint; j++) {
        const lw_system_joint *p = &b->s->joint[j];
        if (p->kind == LW_JOINT_REVOLUTE && (p->body[0] < 0 || p->body[1] < 0))
            add_link(c, b, p->body[0] < 0 ? p->body[1] : p->body[0], j, false);
    }
    for (int i = 0; i < b->s->n_body; i++)
        b->mass += c->model->body[b->s->link[i]].mass;
}

/* The pin that counterweight l is placed from, at posture q. */
static lw_vec2 pin_of(const balance *b, int l, const double *q)
{
    const lw_system_joint *p = &b->s->joint[b->joint[l]];
    return lw_system_point(b->s, b->body[l], p->arm[p->body[1] == b->body[l]], q);
}

/* Sum of m c at posture q, with the m J of counterweights that float. */
static lw_vec2 moment_of(const cli_simulate *c, const balance *b, const double *q)
{
    lw_vec2 sum = { 0, 0 };
    for (int i = 0; i < b->s->n_body; i++)
        sum = lw_v2_add(sum, lw_v2_scale(lw_system_point(b->s, i, lw_v2(0, 0), q), c->model->body[b->s->link[i]].mass));
    for (int l = 0; l < b->n_link; l++)
        if (b->floats[l])
            sum = lw_v2_add(sum, lw_v2_scale(pin_of(b, l, q), b->weight[l]));
    return sum;
}

/* Spread of the sum about its mean over the postures, with weights p (2 a link) or none. */
static double spread(const cli_simulate *c, const balance *b, const double *p)
{
    lw_vec2 mean = { 0, 0 };
    double sum = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < c->n_row; i++) {
            const double *q = c->q + i*(size_t)b->s->n_q;
            lw_vec2 z = moment_of(c, b, q);
            for (int l = 0; p && l < b->n_link; l++)
                z = lw_v2_add(z, lw_v2_turn(lw_v2(p[2*l], p[2*l + 1]), lw_v2_polar(1, q[3*b->body[l] + 2])));
            lw_vec2 d = lw_v2_sub(z, mean);
            if (pass == 0)
                mean = lw_v2_add(mean, lw_v2_scale(z, 1.0/(double)c->n_row));
            else
                sum += lw_v2_dot(d, d);
        }
    return sqrt(sum/(double)c->n_row);
}

static lw_status solve(const cli_simulate *c, const balance *b, double *p)
{
    int m = 2*(int)c->n_row, n = 2*b->n_link + 2;
    lw_rank r;
    double *room = calloc(lw_rank_doubles(m, n) + (size_t)m, sizeof *room);
    int *ints = calloc(lw_rank_ints(m, n), sizeof *ints);
    if (!room || !ints) {
        free(room);
        free(ints);
        return LW_E_MEMORY;
    }
    double *rhs = room + lw_rank_doubles(m, n);
    lw_rank_place(&r, m, n, room, ints);
    for (int i = 0; i < (int)c->n_row; i++) {
        const double *q = c->q + (size_t)i*(size_t)b->s->n_q;
        lw_vec2 z = moment_of(c, b, q);
        rhs[2*i] = -z.x;
        rhs[2*i + 1] = -z.y;
        for (int l = 0; l < b->n_link; l++) {
            lw_vec2 u = lw_v2_polar(1, q[3*b->body[l] + 2]);
            r.a[2*i + m*2*l] = u.x;
            r.a[2*i + 1 + m*2*l] = u.y;
            r.a[2*i + m*(2*l + 1)] = -u.y;
            r.a[2*i + 1 + m*(2*l + 1)] = u.x;
        }
        r.a[2*i + m*(n - 2)] = -1;
        r.a[2*i + 1 + m*(n - 1)] = -1;
    }
    lw_rank_factor(&r, 1e-9);
    lw_rank_solve(&r, rhs, p);
    free(room);
    free(ints);
    return LW_OK;
}

static bool is_still(const cli_simulate *c, const balance *b, const double *p, double before)
{
    return spread(c, b, p) <= 1e-9*fmax(before, b->mass*b->s->unit);
}

/* Masses of floating counterweights that fit their p; false: they do not settle. */
static bool settle_weights(const cli_simulate *c, balance *b, double *p, lw_status *status)
{
    for (int round = 0; round < 400; round++) {
        double change = 0, most = 0;
        for (int l = 0; l < b->n_link; l++) {
            double weight = b->floats[l] ? hypot(p[2*l], p[2*l + 1])/b->radius[l] : 0;
            change = fmax(change, fabs(weight - b->weight[l]));
            most = fmax(most, weight);
            b->weight[l] = weight;
        }
        if (change <= 1e-14*most)
            return true;
        if (!(most < 1e6*b->mass) || (*status = solve(c, b, p)) != LW_OK)
            return false;
    }
    return false;
}

/* One floating link more: that whose weight leaves least; false: there is none that helps. */
static bool add_floating(const cli_simulate *c, balance *b, double *p, lw_status *status)
{
    const lw_system *s = b->s;
    int best_body = -1, best_joint = -1;
    double least = 0.9*spread(c, b, p), trial[UNKNOWNS];
    for (int j = 0; j < s->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            int body = s->joint[j].body[end];
            bool known = body < 0 || s->joint[j].kind != LW_JOINT_REVOLUTE || b->n_link == LW_LINK_MAX;
            for (int l = 0; l < b->n_link; l++)
                known = known || b->body[l] == body;
            if (known)
                continue;
            add_link(c, b, body, j, true);
            *status = solve(c, b, trial);
            double left = *status == LW_OK ? spread(c, b, trial) : INFINITY;
            b->n_link--;
            if (left < least) {
                least = left;
                best_body = body, best_joint = j;
            }
        }
    if (best_body < 0)
        return false;
    add_link(c, b, best_body, best_joint, true);
    *status = solve(c, b, p);
    return *status == LW_OK;
}

/* Weights on floating links too; where their masses do not settle they go further out. */
static lw_status let_float(const cli_simulate *c, balance *b, double *p, double before)
{
    balance ground = *b;
    double alone[UNKNOWNS], found[UNKNOWNS];
    lw_status s = LW_OK;
    memcpy(alone, p, sizeof alone);
    while (!is_still(c, b, p, before) && add_floating(c, b, p, &s))
        ;
    if (s != LW_OK || b->n_link == ground.n_link)
        return s;
    memcpy(found, p, sizeof found);
    for (int tries = 0; s == LW_OK && tries < 6; tries++) {
        memcpy(p, found, sizeof found);
        if (settle_weights(c, b, p, &s))
            return s;
        for (int l = ground.n_link; l < b->n_link; l++) {
            b->radius[l] *= 2;
            b->weight[l] = 0;
        }
    }
    *b = ground;
    memcpy(p, alone, sizeof alone);
    return s;
}

lw_status cli_simulate_balance(cli_simulate *c, FILE *f, lw_error *e)
{
    balance b = { .mass = 0 };
    double p[UNKNOWNS] = { 0 };
    const lw_linkage *k = &c->model->linkage;
    find_links(c, &b);
    if (b.n_link == 0)
        return lw_error_set(e, LW_E_KIND, "no link turns about a pin at the ground, where a counterweight could sit");
    if (c->n_row < (size_t)(b.s->n_body + 2))
        return lw_error_set(e, LW_E_ARG, "too few postures to balance over: more --steps");
    double before = spread(c, &b, NULL);
    if (solve(c, &b, p) != LW_OK || let_float(c, &b, p, before) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double after = spread(c, &b, p);
    cli_json j = cli_json_begin(f, 1);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "length_unit", k->units.length[0] ? k->units.length : "m");
    cli_json_array(&j, "counterweights");
    for (int l = 0; l < b.n_link; l++) {
        lw_vec2 w = lw_v2(p[2*l], p[2*l + 1]), pin = k->joint[b.joint[l]].at;
        double product = lw_v2_norm(w), radius = b.radius[l], metre = k->units.metre;
        lw_vec2 at = lw_v2_add(pin, lw_v2_scale(w, product > 0 ? radius/product : 0));
        cli_json_object(&j, NULL);
        cli_json_text(&j, "link", k->link_name[b.s->link[b.body[l]]]);
        cli_json_text(&j, "pin", k->joint[b.joint[l]].name);
        cli_json_real(&j, "mass_times_radius", product);
        cli_json_real(&j, "mass", product/radius);
        cli_json_reals(&j, "at", (double[]){ at.x/metre, at.y/metre }, 2);
        cli_json_end(&j);
    }
    cli_json_end(&j);
    cli_json_real(&j, "moved_before", before);
    cli_json_real(&j, "moved_after", after);
    cli_json_bool(&j, "balanced", is_still(c, &b, p, before));
    cli_json_end(&j);
    return LW_OK;
}

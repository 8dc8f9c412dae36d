#include "mbs/analysis/counterweights.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/real.h"

#define UNKNOWNS (2*LW_LINK_MAX + 2)

typedef struct balance {
    const lw_model  *m;
    const lw_system *s;
    size_t n_posture;
    const double *q;                      /* (n_posture*n_q) */
    int    n_link, body[LW_LINK_MAX], joint[LW_LINK_MAX];
    bool   floats[LW_LINK_MAX];
    double radius[LW_LINK_MAX], weight[LW_LINK_MAX];     /* of the counterweights: distance from the pin, mass */
    double mass;                          /* of all moving links */
} balance;

/* Distance of a counterweight from its pin: that of the farthest other joint of the link. */
static double radius_of(const balance *b, int l)
{
    const lw_assembly *linkage = &b->m->linkage;
    int link = b->s->link[b->body[l]];
    double farthest = 0;
    for (int j = 0; j < linkage->n_joint; j++)
        if (linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link)
            farthest = fmax(farthest, lw_v2_norm(lw_v2_sub(linkage->joint[j].at, linkage->joint[b->joint[l]].at)));
    return farthest > 0 ? farthest : b->s->unit;
}

static void add_link(balance *b, int body, int joint, bool floats)
{
    int l = b->n_link++;
    b->body[l] = body;
    b->joint[l] = joint;
    b->floats[l] = floats;
    b->weight[l] = 0;
    b->radius[l] = radius_of(b, l);
}

/* Links on ground pins, and the mass of all. */
static void find_links(balance *b)
{
    for (int j = 0; j < b->s->n_joint; j++) {
        const lw_system_joint *p = &b->s->joint[j];
        if (lw_joint_turns(p->kind) && (p->body[0] < 0 || p->body[1] < 0))
            add_link(b, p->body[0] < 0 ? p->body[1] : p->body[0], j, false);
    }
    for (int i = 0; i < b->s->n_body; i++)
        b->mass += b->m->body[b->s->link[i]].mass;
}

/* The pin that counterweight l is placed from, at posture q. */
static lw_vec2 pin_of(const balance *b, int l, const double *q)
{
    const lw_system_joint *p = &b->s->joint[b->joint[l]];
    return lw_system_point(b->s, b->body[l], p->arm[p->body[1] == b->body[l]], q);
}

/* Sum of m c at posture q, with the m J of the counterweights on floating links. */
static lw_vec2 moment_of(const balance *b, const double *q)
{
    lw_vec2 sum = { 0, 0 };
    for (int i = 0; i < b->s->n_body; i++)
        sum = lw_v2_add(sum, lw_v2_scale(lw_system_point(b->s, i, lw_v2(0, 0), q), b->m->body[b->s->link[i]].mass));
    for (int l = 0; l < b->n_link; l++)
        if (b->floats[l])
            sum = lw_v2_add(sum, lw_v2_scale(pin_of(b, l, q), b->weight[l]));
    return sum;
}

/* Deviation (root mean square) of the sum from its mean over the postures, with the products p (2 a link) or none. */
static double deviation(const balance *b, const double *p)
{
    lw_vec2 mean = { 0, 0 };
    double sum = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < b->n_posture; i++) {
            const double *q = b->q + i*(size_t)b->s->n_q;
            lw_vec2 z = moment_of(b, q);
            for (int l = 0; p && l < b->n_link; l++)
                z = lw_v2_add(z, lw_v2_turn(lw_v2(p[2*l], p[2*l + 1]), lw_v2_polar(1, q[3*b->body[l] + 2])));
            lw_vec2 d = lw_v2_sub(z, mean);
            if (pass == 0)
                mean = lw_v2_add(mean, lw_v2_scale(z, 1.0/(double)b->n_posture));
            else
                sum += lw_v2_dot(d, d);
        }
    return sqrt(sum/(double)b->n_posture);
}

static lw_status solve(const balance *b, double *p)
{
    int m = 2*(int)b->n_posture, n = 2*b->n_link + 2;
    lw_rank r;
    double *memory = calloc(lw_rank_doubles(m, n) + (size_t)m, sizeof *memory);
    int *ints = calloc(lw_rank_ints(m, n), sizeof *ints);
    if (!memory || !ints) {
        free(memory);
        free(ints);
        return LW_E_MEMORY;
    }
    double *rhs = memory + lw_rank_doubles(m, n);
    lw_rank_place(&r, m, n, memory, ints);
    for (int i = 0; i < (int)b->n_posture; i++) {
        const double *q = b->q + (size_t)i*(size_t)b->s->n_q;
        lw_vec2 z = moment_of(b, q);
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
    free(memory);
    free(ints);
    return LW_OK;
}

/* Is the common centre of mass still? */
static bool is_still(const balance *b, const double *p, double before)
{
    return deviation(b, p) <= 1e-9*fmax(before, b->mass*b->s->unit);
}

/* Find masses of the counterweights on floating links that fit their products p, by repetition; false: they do not
 * converge. */
static bool find_weights(balance *b, double *p, lw_status *status)
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
        if (!(most < 1e6*b->mass) || (*status = solve(b, p)) != LW_OK)
            return false;
    }
    return false;
}

/* Add the floating link whose counterweight leaves the least deviation; false: none helps. */
static bool add_floating(balance *b, double *p, lw_status *status)
{
    const lw_system *s = b->s;
    int best_body = -1, best_joint = -1;
    double least = 0.9*deviation(b, p), p_tried[UNKNOWNS];
    for (int j = 0; j < s->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            int body = s->joint[j].body[end];
            bool known = body < 0 || !lw_joint_turns(s->joint[j].kind) || b->n_link == LW_LINK_MAX;
            for (int l = 0; l < b->n_link; l++)
                known = known || b->body[l] == body;
            if (known)
                continue;
            add_link(b, body, j, true);
            *status = solve(b, p_tried);
            double left = *status == LW_OK ? deviation(b, p_tried) : INFINITY;
            b->n_link--;
            if (left < least) {
                least = left;
                best_body = body, best_joint = j;
            }
        }
    if (best_body < 0)
        return false;
    add_link(b, best_body, best_joint, true);
    *status = solve(b, p);
    return *status == LW_OK;
}

/* Add counterweights on floating links.  Where their masses do not converge, put them further out. */
static lw_status let_float(balance *b, double *p, double before)
{
    balance ground = *b;
    double alone[UNKNOWNS], found[UNKNOWNS];
    lw_status s = LW_OK;
    memcpy(alone, p, sizeof alone);
    while (!is_still(b, p, before) && add_floating(b, p, &s))
        ;
    if (s != LW_OK || b->n_link == ground.n_link)
        return s;
    memcpy(found, p, sizeof found);
    for (int tries = 0; s == LW_OK && tries < 6; tries++) {
        memcpy(p, found, sizeof found);
        if (find_weights(b, p, &s))
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

lw_status lw_counterweights_find(const lw_model *m, const lw_system *s, size_t n_posture, const double *q,
                                 lw_counterweights *out, lw_error *e)
{
    balance b = { .m = m, .s = s, .n_posture = n_posture, .q = q };
    double p[UNKNOWNS] = { 0 };
    *out = (lw_counterweights){ .n = 0 };
    if (!m->small)
        return lw_error_set(e, LW_E_KIND, "counterweights are chosen link by link, each from all postures, for at most %d links and %d "
                            "joints; this model has %d and %d", LW_LINK_MAX, LW_JOINT_MAX, m->linkage.n_link, m->linkage.n_joint);
    if (m->n_elastic)
        return lw_error_set(e, LW_E_KIND, "counterweights are found for rigid links; make the elastic ones rigid (--rigid)");
    find_links(&b);
    if (b.n_link == 0)
        return lw_error_set(e, LW_E_KIND, "no link turns about a pin at the ground, where a counterweight could sit");
    if (n_posture < (size_t)(s->n_body + 2))
        return lw_error_set(e, LW_E_ARG, "too few postures to balance over: at least %d are needed",
                            s->n_body + 2);
    out->deviation_before = deviation(&b, NULL);
    if (solve(&b, p) != LW_OK || let_float(&b, p, out->deviation_before) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    out->deviation_after = deviation(&b, p);
    out->balanced = is_still(&b, p, out->deviation_before);
    out->n = b.n_link;
    for (int l = 0; l < b.n_link; l++) {
        lw_vec2 w = lw_v2(p[2*l], p[2*l + 1]), pin = m->linkage.joint[b.joint[l]].at;
        double product = lw_v2_norm(w);
        lw_vec2 at = lw_v2_add(pin, lw_v2_scale(w, product > 0 ? b.radius[l]/product : 0));
        out->weight[l] = (lw_counterweight){ .link = s->link[b.body[l]], .joint = b.joint[l], .product = product,
                                             .mass = product/b.radius[l], .at = at };
    }
    return LW_OK;
}

#include "mbs/analysis/counterweights.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/real.h"

/* A link that carries a counterweight: its body, its pin, distance of the weight from the pin, mass of it. */
typedef struct carrier { int body, joint; bool floats; double radius, weight; } carrier;

typedef struct balance {
    const lw_model  *m;
    const lw_system *s;
    size_t n_posture;
    const double *q;                      /* (n_posture*n_q) */
    int      n_link;
    carrier *link;                        /* (n_link; room for all pins and bodies) */
    double   mass;                        /* of all moving links */
    lw_vec2 *still;                       /* (n_posture) sum of m c */
    lw_vec2 *turn;                        /* (n_posture*n_body) directions of the links */
    lw_rank  r;                           /* of the columns of all carriers */
    double  *memory, *rhs;                /* (2 n_posture) */
    int     *ints;
} balance;

/* Distance of a counterweight from its pin: that of the farthest other joint of the link. */
static double radius_of(const balance *b, int body, int joint)
{
    const lw_assembly *linkage = &b->m->linkage;
    int link = b->s->link[body];
    double farthest = 0;
    for (int j = 0; j < linkage->n_joint; j++)
        if (linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link)
            farthest = fmax(farthest, lw_v2_norm(lw_v2_sub(linkage->joint[j].at, linkage->joint[joint].at)));
    return farthest > 0 ? farthest : b->s->unit;
}

static void add_link(balance *b, int body, int joint, bool floats)
{
    b->link[b->n_link++] = (carrier){ .body = body, .joint = joint, .floats = floats, .radius = radius_of(b, body, joint) };
}

/* Links on ground pins, and what does not change with the counterweights. */
static void find_links(balance *b)
{
    for (int j = 0; j < b->s->n_joint; j++) {
        const lw_system_joint *p = &b->s->joint[j];
        if (lw_joint_turns(p->kind) && (p->body[0] < 0 || p->body[1] < 0))
            add_link(b, p->body[0] < 0 ? p->body[1] : p->body[0], j, false);
    }
    for (int i = 0; i < b->s->n_body; i++)
        b->mass += b->m->body[b->s->link[i]].mass;
    for (size_t k = 0; k < b->n_posture; k++) {
        const double *q = b->q + k*(size_t)b->s->n_q;
        for (int i = 0; i < b->s->n_body; i++) {
            b->still[k] = lw_v2_add(b->still[k], lw_v2_scale(lw_system_point(b->s, i, lw_v2(0, 0), q), b->m->body[b->s->link[i]].mass));
            b->turn[k*(size_t)b->s->n_body + (size_t)i] = lw_v2_polar(1, q[3*i + 2]);
        }
    }
}

static lw_vec2 turn_of(const balance *b, size_t posture, int body) { return b->turn[posture*(size_t)b->s->n_body + (size_t)body]; }

/* Sum of m c in a posture, with the m J of the counterweights on floating links. */
static lw_vec2 moment_of(const balance *b, size_t posture)
{
    lw_vec2 sum = b->still[posture];
    for (int l = 0; l < b->n_link; l++)
        if (b->link[l].floats) {
            const lw_system_joint *p = &b->s->joint[b->link[l].joint];
            lw_vec2 arm = p->arm[p->body[1] == b->link[l].body];
            lw_vec2 pin = lw_system_point(b->s, b->link[l].body, arm, b->q + posture*(size_t)b->s->n_q);
            sum = lw_v2_add(sum, lw_v2_scale(pin, b->link[l].weight));
        }
    return sum;
}

/* Deviation (root mean square) of the sum from its mean over the postures, with the products p (2 a link) or none. */
static double deviation(const balance *b, const double *p)
{
    lw_vec2 mean = { 0, 0 };
    double sum = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < b->n_posture; i++) {
            lw_vec2 z = moment_of(b, i);
            for (int l = 0; p && l < b->n_link; l++)
                z = lw_v2_add(z, lw_v2_turn(lw_v2(p[2*l], p[2*l + 1]), turn_of(b, i, b->link[l].body)));
            lw_vec2 d = lw_v2_sub(z, mean);
            if (pass == 0)
                mean = lw_v2_add(mean, lw_v2_scale(z, 1.0/(double)b->n_posture));
            else
                sum += lw_v2_dot(d, d);
        }
    return sqrt(sum/(double)b->n_posture);
}

/* The columns x, y (2 n_posture) of the unknowns p.x, p.y of a link. */
static void columns_of(const balance *b, int body, double *x, double *y)
{
    for (size_t i = 0; i < b->n_posture; i++) {
        lw_vec2 u = turn_of(b, i, body);
        x[2*i] = u.x, x[2*i + 1] = u.y;
        y[2*i] = -u.y, y[2*i + 1] = u.x;
    }
}

/* Factor the columns of the links chosen, with two for the place of the centre at rest. */
static lw_status factor(balance *b)
{
    int m = 2*(int)b->n_posture, n = 2*b->n_link + 2;
    free(b->memory), free(b->ints);
    b->memory = calloc(lw_rank_doubles(m, n) + (size_t)m, sizeof *b->memory);
    b->ints = calloc(lw_rank_ints(m, n), sizeof *b->ints);
    if (!b->memory || !b->ints)
        return LW_E_MEMORY;
    b->rhs = b->memory + lw_rank_doubles(m, n);
    lw_rank_place(&b->r, m, n, b->memory, b->ints);
    for (int l = 0; l < b->n_link; l++)
        columns_of(b, b->link[l].body, b->r.a + (size_t)m*2*(size_t)l, b->r.a + (size_t)m*(2*(size_t)l + 1));
    for (size_t i = 0; i < b->n_posture; i++)
        for (size_t end = 0; end < 2; end++)
            b->r.a[2*i + end + (size_t)m*((size_t)n - 2 + end)] = -1;
    lw_rank_factor(&b->r, 1e-9);
    return LW_OK;
}

/* p (2 n_link + 2) for the masses of the counterweights so far. */
static void solve(balance *b, double *p)
{
    for (size_t i = 0; i < b->n_posture; i++) {
        lw_vec2 z = moment_of(b, i);
        b->rhs[2*i] = -z.x, b->rhs[2*i + 1] = -z.y;
    }
    lw_rank_solve(&b->r, b->rhs, p);
}

/* The deviation below which the common centre of mass is still. */
static double still_below(const balance *b, double before) { return 1e-9*fmax(before, b->mass*b->s->unit); }

static bool is_still(const balance *b, const double *p, double before) { return deviation(b, p) <= still_below(b, before); }

/* Find masses of the counterweights on floating links that fit their products p, by repetition; false: they do not
 * converge. */
static bool find_weights(balance *b, double *p)
{
    for (int round = 0; round < 400; round++) {
        double change = 0, most = 0;
        for (int l = 0; l < b->n_link; l++) {
            carrier *c = &b->link[l];
            double weight = c->floats ? hypot(p[2*l], p[2*l + 1])/c->radius : 0;
            change = fmax(change, fabs(weight - c->weight));
            most = fmax(most, weight);
            c->weight = weight;
        }
        if (change <= 1e-14*most)
            return true;
        if (!(most < 1e6*b->mass))
            return false;
        solve(b, p);
    }
    return false;
}

/* ---- floating links ------------------------------------------------------------------------------------------ */

/* Complex vectors over the postures: x is the real part.  Sum of conj(a) b. */
static lw_vec2 product(size_t n, const lw_vec2 *a, const lw_vec2 *b)
{
    lw_vec2 sum = { 0, 0 };
    for (size_t i = 0; i < n; i++)
        sum = lw_v2_add(sum, lw_v2(lw_v2_dot(a[i], b[i]), lw_v2_cross(a[i], b[i])));
    return sum;
}

static double square(size_t n, const lw_vec2 *a) { return product(n, a, a).x; }

static void take_part_out(size_t n, const lw_vec2 *unit, lw_vec2 *b)
{
    lw_vec2 by = product(n, unit, b);
    for (size_t i = 0; i < n; i++)
        b[i] = lw_v2_sub(b[i], lw_v2_turn(by, unit[i]));
}

/* A link that has or may get a counterweight; its turns, less what those chosen before can do (n_posture). */
typedef struct candidate { int body, joint; bool chosen; lw_vec2 *turn; } candidate;

/* left: what the counterweights chosen leave of the motion of the centre (n_posture). */
typedef struct pursuit { size_t n_posture; int n; candidate *all; lw_vec2 *left; } pursuit;

/* Choose a vector (n_posture; made of length 1): what it can do is taken out of what is left and out of the other candidates.  One
 * nearly in the span of those before it can do nothing. */
static void choose(pursuit *p, lw_vec2 *vector)
{
    double size = sqrt(square(p->n_posture, vector));
    if (!(size > 1e-9*sqrt((double)p->n_posture)))
        return;
    for (size_t i = 0; i < p->n_posture; i++)
        vector[i] = lw_v2_scale(vector[i], 1/size);
    take_part_out(p->n_posture, vector, p->left);
    for (int k = 0; k < p->n; k++)
        if (!p->all[k].chosen)
            take_part_out(p->n_posture, vector, p->all[k].turn);
}

static void add_candidate(const balance *b, pursuit *p, int body, int joint)
{
    p->all[p->n] = (candidate){ body, joint, false, p->left + p->n_posture*((size_t)p->n + 2) };
    for (size_t i = 0; i < p->n_posture; i++)
        p->all[p->n].turn[i] = turn_of(b, i, body);
    p->n++;
}

/* The candidate that leaves the least motion of the centre, if that is less than 0.9 of what is left; -1: there is none. */
static int best_candidate(const pursuit *p)
{
    double all = square(p->n_posture, p->left), least = 0.81*all;
    int best = -1;
    for (int k = 0; k < p->n; k++) {
        double size = p->all[k].chosen ? 0 : square(p->n_posture, p->all[k].turn);
        lw_vec2 by = product(p->n_posture, p->all[k].turn, p->left);
        double without = size > 1e-18*(double)p->n_posture ? all - lw_v2_dot(by, by)/size : INFINITY;
        if (without < least)
            least = without, best = k;
    }
    return best;
}

/* Add floating links, the one that helps most first, until the centre is still (deviation `still` or less) or none helps. */
static lw_status choose_floating(balance *b, double still)
{
    size_t n = b->n_posture, most = (size_t)(b->n_link + b->s->n_body);
    pursuit p = { .n_posture = n, .all = calloc(most, sizeof *p.all), .left = calloc((most + 2)*n, sizeof *p.left) };
    bool *known = calloc((size_t)b->s->n_body, sizeof *known);
    bool room = p.all && p.left && known;
    int n_ground = b->n_link;
    for (int l = 0; room && l < n_ground; l++) {
        add_candidate(b, &p, b->link[l].body, b->link[l].joint);
        known[b->link[l].body] = true;
    }
    for (int j = 0; room && j < b->s->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            int body = b->s->joint[j].body[end];
            if (body < 0 || !lw_joint_turns(b->s->joint[j].kind) || known[body])
                continue;
            add_candidate(b, &p, body, j);
            known[body] = true;
        }
    for (size_t i = 0; room && i < n; i++) {
        p.left[i] = b->still[i];
        p.left[n + i] = lw_v2(1, 0);
    }
    if (room)
        choose(&p, p.left + n);                          /* the place of the centre is free */
    for (int k = 0; room && k < p.n && (k < n_ground || sqrt(square(n, p.left)/(double)n) > still); k++) {
        int next = k < n_ground ? k : best_candidate(&p);
        if (next < 0)
            break;
        p.all[next].chosen = true;
        choose(&p, p.all[next].turn);
        if (k >= n_ground)
            add_link(b, p.all[next].body, p.all[next].joint, true);
    }
    free(p.all), free(p.left), free(known);
    return room ? LW_OK : LW_E_MEMORY;
}

/* Add counterweights on floating links.  Where their masses do not converge, put them further out. */
static lw_status balance_floating_links(balance *b, double *p, double *found, double before)
{
    int n_ground = b->n_link;
    if (is_still(b, p, before))
        return LW_OK;
    lw_status s = choose_floating(b, still_below(b, before));
    if (s != LW_OK || b->n_link == n_ground || (s = factor(b)) != LW_OK)
        return s;
    solve(b, found);
    for (int tries = 0; tries < 6; tries++) {
        memcpy(p, found, (2*(size_t)b->n_link + 2)*sizeof *p);
        if (find_weights(b, p))
            return LW_OK;
        for (int l = n_ground; l < b->n_link; l++) {
            b->link[l].radius *= 2;
            b->link[l].weight = 0;
        }
    }
    b->n_link = n_ground;
    s = factor(b);
    if (s == LW_OK)
        solve(b, p);
    return s;
}

/* ---- all of it ----------------------------------------------------------------------------------------------- */

void lw_counterweights_free(lw_counterweights *c)
{
    free(c->weight);
    *c = (lw_counterweights){ .n = 0 };
}

static lw_status find(balance *b, double *p, double *found, lw_counterweights *out)
{
    out->deviation_before = deviation(b, NULL);
    lw_status s = factor(b);
    if (s == LW_OK) {
        solve(b, p);
        s = balance_floating_links(b, p, found, out->deviation_before);
    }
    out->weight = calloc((size_t)b->n_link, sizeof *out->weight);
    if (s != LW_OK || !out->weight)
        return LW_E_MEMORY;
    out->deviation_after = deviation(b, p);
    out->balanced = is_still(b, p, out->deviation_before);
    out->n = b->n_link;
    for (int l = 0; l < b->n_link; l++) {
        const carrier *c = &b->link[l];
        lw_vec2 w = lw_v2(p[2*l], p[2*l + 1]), pin = b->m->linkage.joint[c->joint].at;
        double product_of = lw_v2_norm(w);
        lw_vec2 at = lw_v2_add(pin, lw_v2_scale(w, product_of > 0 ? c->radius/product_of : 0));
        out->weight[l] = (lw_counterweight){ .link = b->s->link[c->body], .joint = c->joint, .product = product_of,
                                             .mass = product_of/c->radius, .at = at };
    }
    return LW_OK;
}

lw_status lw_counterweights_find(const lw_model *m, const lw_system *s, size_t n_posture, const double *q,
                                 lw_counterweights *out, lw_error *e)
{
    balance b = { .m = m, .s = s, .n_posture = n_posture, .q = q };
    size_t bodies = (size_t)s->n_body, room = (size_t)s->n_joint + bodies + 1;
    *out = (lw_counterweights){ .n = 0 };
    if (m->n_elastic)
        return lw_error_set(e, LW_E_KIND, "counterweights are found for rigid links; make the elastic ones rigid (--rigid)");
    if (n_posture < bodies + 2)
        return lw_error_set(e, LW_E_ARG, "too few postures to balance over: at least %zu are needed", bodies + 2);
    b.link = calloc(room, sizeof *b.link);
    b.still = calloc(n_posture*(bodies + 1), sizeof *b.still);
    double *p = calloc(4*room + 4, sizeof *p);
    lw_status st = LW_E_MEMORY;
    if (b.link && b.still && p) {
        b.turn = b.still + n_posture;
        find_links(&b);
        st = b.n_link ? find(&b, p, p + 2*room + 2, out) : LW_E_KIND;
    }
    free(b.link), free(b.still), free(b.memory), free(b.ints), free(p);
    return st == LW_E_MEMORY ? lw_error_set(e, st, "out of memory")
         : st == LW_E_KIND ? lw_error_set(e, st, "no link turns about a pin at the ground, where a counterweight could sit") : st;
}

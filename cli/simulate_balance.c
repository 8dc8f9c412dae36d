/* cli/simulate_balance.c - counterweights that hold the common centre of mass still.
 *
 * The shaking force of masses in motion is -M times the acceleration of their common centre.  A counterweight m at the
 * place a (from the pin, in its link's frame) on a link that turns about a ground pin adds m a turned by the link's
 * angle, so with p = m a the sum over all masses
 *     sum of m c(t) + sum over links of turn_l(t) p_l  =  constant
 * is linear in the p; it is solved by least squares over the sampled postures.  Where a force remains, no such
 * weights remove all of it (Berkof & Lowen 1969: every link must reach ground by pins alone). */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/rank.h"
#include "cli/output.h"
#include "cli/simulate.h"

typedef struct balance {
    const lw_system *s;
    int    n_link, body[LW_LINK_MAX], joint[LW_LINK_MAX];
    double mass;                          /* of all moving links                                        */
} balance;

/* Links that turn about a pin at the ground. */
static void find_links(const cli_simulate *c, balance *b)
{
    b->s = lw_dynamics_system(c->d);
    for (int j = 0; j < b->s->n_joint; j++) {
        const lw_system_joint *p = &b->s->joint[j];
        int body = p->body[0] < 0 ? p->body[1] : p->body[0];
        if (p->kind != LW_JOINT_REVOLUTE || (p->body[0] >= 0 && p->body[1] >= 0))
            continue;
        b->body[b->n_link] = body;
        b->joint[b->n_link++] = j;
    }
    for (int i = 0; i < b->s->n_body; i++)
        b->mass += c->model->body[b->s->link[i]].mass;
}

/* Sum of m c at posture q. */
static lw_vec2 moment_of(const cli_simulate *c, const balance *b, const double *q)
{
    lw_vec2 sum = { 0, 0 };
    for (int i = 0; i < b->s->n_body; i++)
        sum = lw_v2_add(sum, lw_v2_scale(lw_system_point(b->s, i, lw_v2(0, 0), q), c->model->body[b->s->link[i]].mass));
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

lw_status cli_simulate_balance(cli_simulate *c, FILE *f, lw_error *e)
{
    balance b = { .mass = 0 };
    double p[2*LW_LINK_MAX + 2] = { 0 };
    const lw_linkage *k = &c->model->linkage;
    find_links(c, &b);
    if (b.n_link == 0)
        return lw_error_set(e, LW_E_KIND, "no link turns about a pin at the ground, where a counterweight could sit");
    if (c->n_row < (size_t)(b.n_link + 2))
        return lw_error_set(e, LW_E_ARG, "too few postures to balance over: more --steps");
    if (solve(c, &b, p) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double before = spread(c, &b, NULL), after = spread(c, &b, p), metre = k->units.metre;
    cli_json j = cli_json_begin(f, 1);
    cli_json_object(&j, NULL);
    cli_json_text(&j, "length_unit", k->units.length[0] ? k->units.length : "m");
    cli_json_array(&j, "counterweights");
    for (int l = 0; l < b.n_link; l++) {
        lw_vec2 w = lw_v2(p[2*l], p[2*l + 1]), pin = k->joint[b.joint[l]].at;
        double product = lw_v2_norm(w), radius = radius_of(c, &b, l);
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
    cli_json_bool(&j, "balanced", after <= 1e-9*fmax(before, b.mass*b.s->unit));
    cli_json_end(&j);
    return LW_OK;
}

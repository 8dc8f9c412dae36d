/* catalogues/curves/curves_topology.c - random linkages of a topology with more than four links, each from its own key.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "catalogues/curves/curves_internal.h"
#include "grammar/linkage/sketch.h"
#include "mbs/batch/batch.h"
#include "optimise/search/random_linkage.h"

#define REACH 1.5        /* a tracer is drawn up to this distance from the middle of its link, in lengths of the link */

/* ---- as text ---------------------------------------------------------------------------------------- */

lw_status lw_curve_topology_text(const char *name, const lw_linkage *linkage, char text[LW_CURVE_WORD])
{
    int n = snprintf(text, LW_CURVE_WORD, "%.60s=", name);
    for (int i = 0; i < n; i++)
        text[i] = text[i] == ',' ? ';' : text[i] == '=' && i + 1 < n ? '-' : text[i];
    for (int j = 0; j < linkage->n_joint && n < LW_CURVE_WORD; j++)
        n += snprintf(text + n, LW_CURVE_WORD - (size_t)n, "%s%d-%d%c", j ? "." : "", linkage->joint[j].link[0] + 1,
                      linkage->joint[j].link[1] + 1, (char)linkage->joint[j].kind);
    if (n < LW_CURVE_WORD)
        n += snprintf(text + n, LW_CURVE_WORD - (size_t)n, "=g%di%dt%d", linkage->ground + 1,
                      linkage->input[0].joint + 1, linkage->tracer[0].link + 1);
    return n < LW_CURVE_WORD ? LW_OK : LW_E_ARG;
}

/* Read the joints between the two '='; *rest is what follows the second one. */
static bool read_joints(const char *text, lw_mechanism *m, const char **rest)
{
    int a[LW_JOINT_MAX], b[LW_JOINT_MAX], n = 0, most = 0, used = 0;
    char kind[LW_JOINT_MAX];
    for (;; text += used + 1) {
        if (n == LW_JOINT_MAX || sscanf(text, "%2d-%2d%c%n", &a[n], &b[n], &kind[n], &used) < 3)
            return false;
        if (a[n] < 1 || b[n] < 1 || a[n] > LW_LINK_MAX || b[n] > LW_LINK_MAX || (kind[n] != 'r' && kind[n] != 't'))
            return false;
        most = a[n] > most ? a[n] : most;
        most = b[n] > most ? b[n] : most;
        n++;
        if (text[used] != '.')
            break;
    }
    *rest = text + used;
    if (lw_mechanism_clear(m, most) != LW_OK)
        return false;
    for (int j = 0; j < n; j++)
        if (lw_mechanism_join(m, a[j] - 1, b[j] - 1, kind[j]) != LW_OK)
            return false;
    return m->n_joint == n;
}

bool lw_curve_topology_read(const char *text, char name[64], lw_mechanism *m)
{
    const char *end = strchr(text, '='), *rest;
    int ground, input, tracer, used = 0;
    if (!end || end - text >= 64 || !read_joints(end + 1, m, &rest))
        return false;
    snprintf(name, 64, "%.*s", (int)(end - text), text);
    for (char *c = name; *c; c++)
        *c = *c == ';' ? ',' : *c;
    if (sscanf(rest, "=g%2di%2dt%2d%n", &ground, &input, &tracer, &used) < 3 || rest[used])
        return false;
    if (ground < 1 || ground > m->n_link || tracer < 1 || tracer > m->n_link || input < 1 || input > m->n_joint)
        return false;
    m->ground = ground - 1;
    m->output = tracer - 1;
    m->n_input = 1;
    m->input[0] = (uint8_t)(input - 1);
    return true;
}

static size_t rounded(size_t size) { return (size + 63)/64*64; }

/* ---- making ------------------------------------------------------------------------------------------- */

/* Does the point move with all dyads?  The links of others would have no dimensions. */
static bool moves_with_all(const lw_plan *p)
{
    bool moves[LW_DYAD_MAX] = { false };
    int n = 0;
    for (int i = 0; i < p->n_output_step[0]; i++) {
        int dyad = p->step[p->output_step[0][i]].dyad;
        n += dyad >= 0 && !moves[dyad];
        if (dyad >= 0)
            moves[dyad] = true;
    }
    return n >= p->n_dyad;
}

/* Drawing needs a problem. Its target is the unit circle, so that scaling changes nothing. */
static lw_status make_problem(lw_curve_topology *t, lw_error *e)
{
    static const double x[] = { 1, 0, -1, 0 }, y[] = { 0, 1, 0, -1 };
    lw_target circle;
    lw_fit_spec spec = lw_fit_spec_default();
    spec.timing = LW_TIMING_NONE;
    t->family = (lw_family){ .name = t->name, .linkage = &t->linkage, .links = t->linkage.n_link, .blocks = 1 };
    if (lw_joint_slides(t->linkage.joint[t->linkage.input[0].joint].kind))
        return lw_error_set(e, LW_E_KIND, "%s: a slider drives it, which makes no full turn", t->name);
    lw_status s = lw_target_make(4, x, y, NULL, NULL, NULL, 1, &circle, e);
    if (s != LW_OK)
        return s;
    s = lw_problem_make(&circle, &spec, &t->family, 1, 1, &t->problem, e);
    lw_target_free(&circle);
    const char *wrong = s != LW_OK ? NULL : t->problem.plan.n_higher > 0 ? "more than dyads"
                      : !moves_with_all(&t->problem.plan) ? "its point moves without some of the links" : NULL;
    if (wrong) {
        lw_problem_free(&t->problem);
        s = lw_error_set(e, LW_E_KIND, "%s: %s", t->name, wrong);
    }
    return s;
}

lw_status lw_curve_topology_make(const char *text, lw_curve_topology **topology, lw_error *e)
{
    lw_mechanism m;
    lw_rng rng;
    lw_curve_topology *t = calloc(1, sizeof *t);
    *topology = NULL;
    if (!t)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_rng_seed(&rng, 1, 0x6c6f706f74u);
    lw_status s = lw_curve_topology_read(text, t->name, &m) && lw_linkage_sketch(&m, &rng, &t->linkage) == LW_OK ? LW_OK
                : lw_error_set(e, LW_E_NOTATION, "there is no family '%.60s' in this program", text);
    if (s == LW_OK)
        s = make_problem(t, e);
    if (s != LW_OK) {
        free(t);
        return s;
    }
    for (int j = 0; j < t->linkage.n_joint; j++)
        t->slides |= lw_joint_slides(t->linkage.joint[j].kind);
    t->work = aligned_alloc(64, rounded(sizeof(lw_problem)) + rounded(lw_problem_work_size(&t->problem)));
    t->batch = aligned_alloc(64, rounded(lw_batch_work_size(&t->problem.plan)));
    if (!t->work || !t->batch) {
        lw_curve_topology_free(t);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    *topology = t;
    return LW_OK;
}

void lw_curve_topology_free(lw_curve_topology *t)
{
    if (!t)
        return;
    lw_problem_free(&t->problem);
    free(t->work);
    free(t->batch);
    free(t);
}

/* ---- drawing ------------------------------------------------------------------------------------------ */

/* Distance of the link's first two pins; 1 if it has no such dimension. */
static double link_length(const lw_plan *plan, int link, const double *dim)
{
    for (int i = 0; i < plan->n_dim; i++)
        if (plan->dim[i].role == LW_ROLE_R && plan->dim[i].link == link)
            return dim[i];
    return 1;
}

bool lw_curve_topology_draw(lw_curve_topology *t, const uint32_t key[2], bool turns, double *dim, double *mode, lw_range *range)
{
    lw_problem *p = t->work;
    void *own = (unsigned char *)t->work + rounded(sizeof *p);
    const lw_plan *plan = &t->problem.plan;
    double u[LW_RANDOM_LINKAGE_DRAW_MAX + 2];
    lw_rng rng;
    lw_rng_seed(&rng, (uint64_t)key[1] << 32 | key[0], 0x6d656d62u);
    for (int i = 0; i < LW_RANDOM_LINKAGE_DRAW_MAX + 2; i++)
        u[i] = lw_rng_uniform(&rng);
    *p = t->problem;
    lw_problem_work_init(p, own);
    if (!lw_random_linkage_draw(p, u, turns, dim, own))
        return false;
    double length = link_length(plan, t->linkage.tracer[0].link, dim);
    lw_vec2 at = lw_v2_polar(REACH*length*u[LW_RANDOM_LINKAGE_DRAW_MAX], 2*LW_PI*u[LW_RANDOM_LINKAGE_DRAW_MAX + 1]);
    dim[plan->i_cx[0]] = 0.5*length + at.x;
    dim[plan->i_cy[0]] = at.y;
    memcpy(mode, p->intended.mode, sizeof *mode*(size_t)plan->n_dyad);
    *range = (lw_range){ .first = 0, .last = 2*LW_PI, .turns = true };
    if (!p->intended.turns)
        *range = (lw_range){ .first = p->intended.mid - p->intended.half, .last = p->intended.mid + p->intended.half };
    return true;
}

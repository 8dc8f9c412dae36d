/* Gear pairs in a plan: which wheel is turned by which, how often the input must turn until all comes back.
 *
 * Relative to the link that carries both wheels the one turns `ratio` times as fast as the other.  As soon as the
 * carrier and one wheel are known the other wheel is: with directions as unit vectors
 *     u = e^{i phi} c^{1 - ratio} w^{ratio},   c of the carrier, w of the known wheel, phi the phase,
 * for whole ratios.  Wheels whose carrier and partner turn with the input at constant rates do so themselves, at any
 * ratio of whole numbers: where a rate is a fraction, the plan counts its input in so many turns (plan->laps) that all
 * rates become whole numbers m, u = e^{i (phi + m input)}.
 *
 * A tied input (grammar/linkage.h) turns its link so many times as fast as the first input does its own, both seen
 * from the ground: the ground carries the two, as if a belt or wheels went from the one to the other. */
#include "mbs/plan_build_internal.h"

#include <math.h>

#define WHOLE 1e-9           /* a ratio nearer to a whole number is meant to be one */

static bool is_whole(double a) { return fabs(a - round(a)) <= WHOLE*fmax(1, fabs(a)); }

/* The pin on which a wheel turns on its carrier, -1: it slides there. */
static int centre_pin(const lw_topology *t, int wheel, int carrier)
{
    for (int j = 0; j < t->k->n_joint; j++)
        if (t->k->joint[j].kind == LW_JOINT_REVOLUTE && t->pin[j] == j && t->on_pin[j] >> wheel & 1
            && t->on_pin[j] >> carrier & 1)
            return j;
    return -1;
}

/* The gear as a group, when carrier and one wheel are known and the other is not. */
static bool try_gear(const lw_topology *t, int joint, lw_group *g)
{
    const lw_joint *q = &t->k->joint[joint];
    lw_gear gear;
    if (t->geared[joint] || lw_linkage_gear(t->k, joint, &gear, NULL) != LW_OK || gear.slider[0] >= 0
        || gear.slider[1] >= 0 || t->rank[gear.carrier] < 0)
        return false;
    int wheel = t->rank[q->link[0]] < 0 ? 0 : 1;
    if (t->rank[q->link[wheel]] >= 0 || t->rank[q->link[!wheel]] < 0)
        return false;
    int pin = centre_pin(t, q->link[wheel], gear.carrier);
    if (pin < 0)
        return false;
    *g = (lw_group){ .kind = LW_STEP_GEAR, .link = { q->link[wheel], q->link[wheel] }, .joint = { pin, joint, pin },
                     .base = { gear.carrier, q->link[!wheel] }, .ratio = wheel ? q->ratio : 1/q->ratio };
    return true;
}

bool lw_plan_find_gear(lw_topology *t, lw_group *g)
{
    for (int j = 0; j < t->k->n_joint; j++)
        if (t->k->joint[j].kind == LW_JOINT_GEAR && try_gear(t, j, g)) {
            t->geared[j] = true;
            return true;
        }
    return false;
}

void lw_plan_tie_inputs(lw_topology *t, int *known)
{
    const lw_linkage *k = t->k;
    for (int i = 1; i < k->n_input; i++) {
        int j = k->input[i].joint, link = lw_joint_other(&k->joint[j], k->ground), pin = t->pin[j];
        t->group[t->n_group++] = (lw_group){ .kind = LW_STEP_GEAR, .link = { link, link }, .joint = { pin, j, pin },
                                             .base = { k->ground, t->driven }, .ratio = k->input[i].ratio };
        t->n_gear++;
        t->rank[link] = (*known)++;
    }
}

static bool has_rate(const lw_topology *t, const lw_group *g)
{
    return isfinite(t->rate[g->base[0]]) && isfinite(t->rate[g->base[1]]);
}

lw_status lw_plan_gear_rates(lw_topology *t, lw_error *e)
{
    const lw_linkage *k = t->k;
    for (int i = 0; i < LW_LINK_MAX; i++)
        t->rate[i] = NAN;
    t->rate[k->ground] = 0;
    t->laps = 1;
    if (t->driven >= 0 && k->joint[t->input_joint].kind == LW_JOINT_REVOLUTE)
        t->rate[t->driven] = 1;
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].kind == LW_JOINT_GEAR && !t->geared[j])
            return lw_error_set(e, LW_E_KIND, "gear \"%s\": its wheels are not known one after the other, with the link that "
                                "carries both before them", k->joint[j].name);
    for (int i = 0; i < t->n_group; i++) {
        const lw_group *g = &t->group[i];
        if (g->kind != LW_STEP_GEAR)
            continue;
        double c = t->rate[g->base[0]], w = t->rate[g->base[1]], rate = c + g->ratio*(w - c);
        t->rate[g->link[0]] = rate;
        int laps = t->laps;
        while (isfinite(rate) && laps <= LW_LAP_MAX && !is_whole(laps*rate))
            laps += t->laps;
        bool good = isfinite(rate) ? laps <= LW_LAP_MAX && fabs(laps*rate) <= LW_POWER_MAX
                                   : is_whole(g->ratio) && fabs(g->ratio) <= LW_POWER_MAX;
        if (!good)
            return lw_error_set(e, LW_E_KIND, "%s \"%s\": plans take ratios of whole numbers where the wheels turn "
                                "evenly with the input, in at most %d of its turns, else whole numbers",
                                k->joint[g->joint[1]].kind == LW_JOINT_GEAR ? "gear" : "tied input", k->joint[g->joint[1]].name,
                                LW_LAP_MAX);
        t->laps = laps;
    }
    return LW_OK;
}

/* The direction of a driven link that makes several turns. */
int lw_build_laps(lw_builder *b, int input)
{
    if (b->t->laps == 1)
        return input;
    lw_step *s = lw_build_step(b, LW_STEP_GEAR);
    s->in[0] = b->lap_reg = input;
    s->power[0] = b->t->laps;
    return s->out[0] = lw_build_reg(b);
}

void lw_build_gear(lw_builder *b, const lw_group *g)
{
    int wheel = g->link[0], origin = lw_build_pin(b, g->joint[0], g->base[0]);
    int phase = lw_build_dim(b, LW_ROLE_PHASE, wheel, g->joint[1], 0);
    lw_step *s = lw_build_step(b, LW_STEP_GEAR);
    if (has_rate(b->t, g)) {
        s->in[0] = b->lap_reg;
        s->power[0] = (int)lround(b->t->laps*b->t->rate[wheel]);
    } else {
        s->in[0] = b->p->link_dir[g->base[0]];
        s->in[1] = b->p->link_dir[g->base[1]];
        s->power[1] = (int)lround(g->ratio);
        s->power[0] = 1 - s->power[1];
    }
    s->dim[0] = phase;
    lw_build_link(b, wheel, origin, s->out[0] = lw_build_reg(b));
}

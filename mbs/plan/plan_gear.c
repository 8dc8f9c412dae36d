/* Gears in a plan: which gear moves which wheel or rack, and the turns of the input until all gears are back.
 *
 * Relative to the link that carries both wheels, one wheel turns `ratio` times as fast as the other.  When the carrier
 * and one wheel are known, the other wheel is too.  With directions as unit vectors and a whole ratio,
 *     u = e^{i phi} c^{1 - ratio} w^{ratio},   c of the carrier, w of the known wheel, phi the phase.
 * A wheel whose carrier and partner turn at constant rates with the input turns at a constant rate itself, for any
 * ratio of whole numbers.  When a rate is a fraction, one turn of the plan's input is input_turns_per_period turns of
 * the linkage's input, so that all rates become whole numbers m:  u = e^{i (phi + m input)}.  A known rack determines
 * its pinion, a known pinion its rack.
 *
 * A tied input (grammar/linkage/linkage.h) turns its link at a given ratio to the first input, both measured against the
 * ground.  It is a wheel that the ground carries, with the driven link as partner.
 *
 * All other gears are equations of the group of their wheels, which may be one wheel alone.  A ratio p/q gives
 *     q phi_1 - p phi_0 - (q - p) phi_c = q phi,
 * which q directions of wheel 1 fulfil.  They are told apart by following the motion from the seed; they follow each
 * other in q turns of wheel 0.  lw_plan_gear_turns bounds the turns of the input in which all of them occur. */
#include "base/real.h"
#include "mbs/plan/plan_build_internal.h"

#include <stdlib.h>

#define WHOLE 1e-9           /* relative distance at which a ratio counts as a whole number */

static bool is_whole(double a) { return fabs(a - round(a)) <= WHOLE*fmax(1, fabs(a)); }

/* Write a ratio as p/q in lowest terms within the limits of mbs/plan/plan.h; false when it is no such fraction. */
static bool as_fraction(double ratio, int *p, int *q)
{
    for (*q = 1; *q <= LW_INPUT_TURNS_PER_PERIOD_MAX; ++*q)
        if (is_whole(*q*ratio) && fabs(*q*ratio) <= LW_POWER_MAX) {
            *p = (int)lround(*q*ratio);
            return *p != 0;
        }
    return false;
}

lw_status lw_plan_start_gears(lw_topology *t, lw_error *e)
{
    const lw_linkage *k = t->k;
    t->input_turns_per_period = 1;
    for (int i = 0; i < LW_LINK_MAX; i++)
        t->rate[i] = NAN;
    t->rate[k->ground] = 0;
    if (t->driven >= 0 && lw_joint_turns(k->joint[t->input_joint].kind))
        t->rate[t->driven] = 1;
    for (int j = 0, p, q; j < k->n_joint; j++) {
        lw_gear *g = &t->gear[j];
        if (!lw_joint_has_ratio(k->joint[j].kind))
            continue;
        lw_status s = lw_linkage_gear(k, j, g, e);
        if (s != LW_OK)
            return s;
        if (g->slider[0] >= 0 && g->slider[1] >= 0)
            return lw_error_set(e, LW_E_KIND,
                                "gear \"%s\": both its links slide on \"%s\"; plans take a rack with a pinion",
                                k->joint[j].name, k->link_name[g->carrier]);
        if (g->slider[0] < 0 && g->slider[1] < 0 && !as_fraction(k->joint[j].ratio, &p, &q))
            return lw_error_set(e, LW_E_KIND,
                                "gear \"%s\": plans take ratios of whole numbers up to %d over up to %d, not %g",
                                k->joint[j].name, LW_POWER_MAX, LW_INPUT_TURNS_PER_PERIOD_MAX, k->joint[j].ratio);
    }
    return LW_OK;
}

/* ---- one link known by its gear ------------------------------------------------------------------------ */

/* The pin on which a wheel turns on its carrier. */
static int centre_pin(const lw_topology *t, int wheel, int carrier)
{
    for (int j = 0; j < t->k->n_joint; j++)
        if (lw_joint_turns(t->k->joint[j].kind) && t->pin[j] == j && t->on_pin[j] >> wheel & 1 && t->on_pin[j] >> carrier & 1)
            return j;
    return -1;
}

/* Make a group of the gear; false unless the carrier and exactly one side are known. */
static bool as_group(const lw_topology *t, int joint, lw_plan_group *g)
{
    const lw_joint *q = &t->k->joint[joint];
    const lw_gear *gear = &t->gear[joint];
    int found = t->rank[q->link[0]] < 0 ? 0 : 1, slider = gear->slider[found];
    if (t->geared[joint] || t->rank[gear->carrier] < 0 || t->rank[q->link[found]] >= 0 || t->rank[q->link[!found]] < 0)
        return false;
    int at = slider >= 0 ? slider : centre_pin(t, q->link[found], gear->carrier);
    *g = (lw_plan_group){ .kind = slider >= 0 ? LW_STEP_RACK : gear->slider[!found] >= 0 ? LW_STEP_ROLL : LW_STEP_GEAR,
                     .link = { q->link[found], q->link[found] }, .joint = { at, joint, at },
                     .base = { gear->carrier, q->link[!found] }, .ratio = found ? q->ratio : 1/q->ratio };
    return at >= 0;
}

/* Turns of the wheel per turn of the input; NaN when its rate is not constant. */
static double rate_of(const lw_topology *t, const lw_plan_group *g)
{
    double c = t->rate[g->base[0]], w = t->rate[g->base[1]];
    return g->kind == LW_STEP_GEAR ? c + g->ratio*(w - c) : NAN;
}

static lw_status too_many(const lw_topology *t, int joint, lw_error *e)
{
    const lw_joint *j = &t->k->joint[joint];
    return lw_error_set(e, LW_E_KIND,
                        "%s \"%s\": plans take ratios of whole numbers; with this one all comes back after more "
                        "than %d turns of the input, or wheels turn more than %d times in these",
                        lw_joint_has_ratio(j->kind) ? "gear" : "tied input", j->name, LW_INPUT_TURNS_PER_PERIOD_MAX,
                        LW_POWER_MAX);
}

/* Take the group.  If its wheel turns at a constant rate, increase input_turns_per_period until the wheel is back. */
static lw_status take(lw_topology *t, const lw_plan_group *g, int *known, lw_error *e)
{
    double rate = rate_of(t, g);
    int turns = t->input_turns_per_period;
    while (isfinite(rate) && turns <= LW_INPUT_TURNS_PER_PERIOD_MAX && !is_whole(turns*rate))
        turns += t->input_turns_per_period;
    if (turns > LW_INPUT_TURNS_PER_PERIOD_MAX || fabs(turns*rate) > LW_POWER_MAX)
        return too_many(t, g->joint[1], e);
    t->input_turns_per_period = turns;
    t->rate[g->link[0]] = rate;
    t->rank[g->link[0]] = (*known)++;
    t->group[t->n_group++] = *g;
    t->n_gear++;
    return LW_OK;
}

lw_status lw_plan_tie_inputs(lw_topology *t, int *known, lw_error *e)
{
    const lw_linkage *k = t->k;
    lw_status s = LW_OK;
    for (int i = 1; i < k->n_input && s == LW_OK; i++) {
        int j = k->input[i].joint, link = lw_joint_other(&k->joint[j], k->ground), pin = t->pin[j];
        const lw_plan_group g = { .kind = LW_STEP_GEAR, .link = { link, link }, .joint = { pin, j, pin },
                             .base = { k->ground, t->driven }, .ratio = k->input[i].ratio };
        s = take(t, &g, known, e);
    }
    return s;
}

lw_status lw_plan_find_gear(lw_topology *t, int *known, bool *found, lw_error *e)
{
    lw_plan_group g;
    *found = false;
    for (int j = 0; j < t->k->n_joint; j++) {
        if (!lw_joint_has_ratio(t->k->joint[j].kind) || !as_group(t, j, &g))
            continue;
        bool whole = is_whole(g.ratio) && fabs(g.ratio) <= LW_POWER_MAX;
        if (g.kind == LW_STEP_GEAR && !whole && !isfinite(rate_of(t, &g)))
            continue;                                    /* this gear is an equation of a group             */
        *found = t->geared[j] = true;
        return take(t, &g, known, e);
    }
    return LW_OK;
}

/* ---- gears of a group ------------------------------------------------------------------------------------ */

static int common_multiple(int a, int b)
{
    int m = a;
    while (m % b)
        m += a;
    return m;
}

/* In the row  q phi_1 - p phi_0 - (q - p) phi_c  the factors of the unknown wheels, or else that of the carrier: each
 * of these links is back after as many turns of the links that move it. */
static int turns_of(const lw_topology *t, const lw_cluster *c, int joint)
{
    const lw_joint *j = &t->k->joint[joint];
    int p, q, turns = 1;
    if (t->gear[joint].slider[0] >= 0 || t->gear[joint].slider[1] >= 0 || !as_fraction(j->ratio, &p, &q))
        return 1;
    if (c->links >> j->link[1] & 1)
        turns = q;
    if (c->links >> j->link[0] & 1)
        turns = common_multiple(turns, abs(p));
    return turns > 1 || p == q || !(c->links >> t->gear[joint].carrier & 1) || c->links >> j->link[0] & 1
           || c->links >> j->link[1] & 1 ? turns : abs(q - p);
}

lw_status lw_plan_gear_turns(lw_topology *t, const lw_cluster *c, lw_error *e)
{
    bool turns = lw_joint_turns(t->k->joint[t->input_joint].kind);
    for (int i = 0; i < c->n_gear; i++) {
        t->geared[c->gear[i]] = true;
        t->input_turns_per_period *= turns ? turns_of(t, c, c->gear[i]) : 1;
        if (t->input_turns_per_period > LW_INPUT_TURNS_PER_PERIOD_MAX)
            return too_many(t, c->gear[i], e);
    }
    return LW_OK;
}

lw_status lw_plan_check_gears(const lw_topology *t, lw_error *e)
{
    for (int j = 0; j < t->k->n_joint; j++)
        if (lw_joint_has_ratio(t->k->joint[j].kind) && !t->geared[j])
            return lw_error_set(e, LW_E_KIND, "gear \"%s\" holds links that others hold already", t->k->joint[j].name);
    return LW_OK;
}

/* ---- frames ----------------------------------------------------------------------------------------------- */

void lw_build_gear_frame(lw_builder *b, const lw_plan_group *g)
{
    b->p->frame[g->link[0]] = lw_build_turning_frame(b, g->link[0], g->joint[0]);
}

/* ---- steps ------------------------------------------------------------------------------------------------ */

int lw_build_turns_per_period(lw_builder *b, int input)
{
    if (b->t->input_turns_per_period == 1)
        return input;
    lw_step *s = lw_build_step(b, LW_STEP_GEAR);
    s->in[0] = b->period_reg = input;
    s->power[0] = b->t->input_turns_per_period;
    return s->out[0] = lw_build_reg(b);
}

static void build_wheel(lw_builder *b, const lw_plan_group *g)
{
    int wheel = g->link[0], origin = lw_build_pin(b, g->joint[0], g->base[0]);
    int phase = lw_build_dim(b, LW_ROLE_PHASE, wheel, g->joint[1], 0);
    lw_step *s = lw_build_step(b, LW_STEP_GEAR);
    if (isfinite(rate_of(b->t, g))) {
        s->in[0] = b->period_reg;
        s->power[0] = (int)lround(b->t->input_turns_per_period*b->t->rate[wheel]);
    } else {
        s->in[0] = b->p->link_dir[g->base[0]];
        s->in[1] = b->p->link_dir[g->base[1]];
        s->power[1] = (int)lround(g->ratio);
        s->power[0] = 1 - s->power[1];
    }
    s->dim[0] = phase;
    lw_build_link(b, wheel, origin, s->out[0] = lw_build_reg(b));
}

/* Add a rack to the plan and its dimensions rho and shift. */
static void build_rack(lw_builder *b, int joint, int *rho, int *shift)
{
    const lw_linkage *k = b->t->k;
    const lw_gear *g = &b->t->gear[joint];
    lw_plan *p = b->p;
    int side = g->slider[1] >= 0, slider = g->slider[side];
    lw_rack r = { joint, slider, k->joint[joint].link[side], k->joint[joint].link[!side], g->carrier, side, 1 };
    r.sign = p->slider_sign[slider]*(p->slider_base[slider] == r.carrier ? 1 : -1);
    *rho = lw_build_dim(b, LW_ROLE_PITCH, r.link, joint, 0);
    *shift = lw_build_dim(b, LW_ROLE_SHIFT, r.link, joint, 0);
    if (p->n_rack == LW_RACK_MAX)
        b->full = true;
    else
        p->rack[p->n_rack++] = r;
}

static void build_pinion(lw_builder *b, const lw_plan_group *g)
{
    lw_plan *p = b->p;
    const int *sliders = b->t->gear[g->joint[1]].slider, slider = sliders[0] >= 0 ? sliders[0] : sliders[1];
    int base = p->slider_base[slider], rider = lw_joint_other(&b->t->k->joint[slider], base), rho, shift;
    build_rack(b, g->joint[1], &rho, &shift);
    lw_step *s = lw_build_step(b, LW_STEP_ALONG);
    s->in[0] = p->link_origin[base];
    s->in[1] = p->slider_dir[slider];
    s->in[2] = p->link_origin[rider];
    int along = s->out[0] = lw_build_reg(b);
    s = lw_build_step(b, LW_STEP_ROLL);
    s->in[0] = p->link_dir[g->base[0]];
    s->in[1] = along;
    s->dim[0] = rho;
    s->dim[1] = shift;
    int dir = s->out[0] = lw_build_reg(b);
    lw_build_link(b, g->link[0], lw_build_pin(b, g->joint[0], g->base[0]), dir);
}

static void build_rack_link(lw_builder *b, const lw_plan_group *g)
{
    lw_plan *p = b->p;
    int rack = g->link[0], rho, shift;
    build_rack(b, g->joint[1], &rho, &shift);
    int middle = lw_build_dim(b, LW_ROLE_MIDDLE, rack, g->joint[1], 0);
    lw_step *s = lw_build_step(b, LW_STEP_RACK);
    s->in[0] = p->link_dir[g->base[1]];
    s->in[1] = p->link_dir[g->base[0]];
    s->dim[0] = rho;
    s->dim[1] = shift;
    s->dim[2] = middle;
    b->full |= p->n_dyad == LW_DYAD_MAX;
    s->dyad = b->full ? 0 : p->n_dyad++;
    p->dyad[s->dyad] = (lw_dyad){ { rack, rack }, { g->joint[0], g->joint[1], g->joint[2] } };
    int along = s->out[0] = lw_build_reg(b), q, w;
    lw_build_line(b, g->joint[0], g->base[0], &q, &w);
    lw_build_ride(b, rack, q, w, along);
}

void lw_build_gear(lw_builder *b, const lw_plan_group *g)
{
    switch (g->kind) {
    case LW_STEP_ROLL: build_pinion(b, g); break;
    case LW_STEP_RACK: build_rack_link(b, g); break;
    default:           build_wheel(b, g);
    }
}

/* ---- rows of a higher group ------------------------------------------------------------------------------- */

static void add_term(lw_higher_gear *g, int dir, int link, int power)
{
    if (dir < 0 || power == 0)
        return;
    g->dir[g->n_term] = (short)dir;
    g->link[g->n_term] = (short)link;
    g->power[g->n_term++] = (short)power;
}

lw_higher_gear lw_build_gear_row(lw_builder *b, int joint, const int *dir, int disp)
{
    const lw_joint *j = &b->t->k->joint[joint];
    const lw_gear *gear = &b->t->gear[joint];
    lw_higher_gear g = { .count = 1, .phase = -1, .angle = -1, .disp = (short)disp, .rho = -1, .shift = -1,
                         .middle = -1 };
    int p = 1, q = 1, rho, shift, pinion = gear->slider[0] >= 0 ? 1 : 0;
    if (disp != -1) {
        add_term(&g, dir[pinion], j->link[pinion], 1);
        add_term(&g, dir[2], gear->carrier, -1);
        build_rack(b, joint, &rho, &shift);
        g.rho = (short)rho;
        g.shift = (short)shift;
        g.middle = (short)lw_build_dim(b, LW_ROLE_MIDDLE, j->link[!pinion], joint, 0);
        return g;
    }
    as_fraction(j->ratio, &p, &q);
    add_term(&g, dir[1], j->link[1], q);
    add_term(&g, dir[0], j->link[0], -p);
    add_term(&g, dir[2], gear->carrier, p - q);
    g.count = (short)q;
    g.phase = (short)lw_build_dim(b, LW_ROLE_PHASE, j->link[1], joint, 0);
    return g;
}

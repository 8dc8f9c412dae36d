/* The topology of a plan: which joints are one pin, and the order in which links become known.
 *
 * The loop looks for a dyad (Assur 1914): two unknown links that are joined to each other and, by one joint each, to
 * known links.  All dyads are found in any order, since a dyad stays one when other links become known.  When there is
 * none, the smallest group that known links determine is next (mbs/plan/plan_assur.c). */
#include "mbs/plan/plan_internal.h"

#include <stdio.h>
#include <string.h>

/* ---- pins ------------------------------------------------------------------------------------- */

/* Join pins that share a link and whose coordinates are equal bit by bit, until no more are found. */
static void join_pins(lw_topology *t)
{
    const lw_linkage *k = t->k;
    for (int i = 0; i < k->n_joint; i++) {
        t->pin[i] = i;
        t->on_pin[i] = 1u << k->joint[i].link[0] | 1u << k->joint[i].link[1];
    }
    for (bool more = true; more; ) {
        more = false;
        for (int i = 0; i < k->n_joint; i++)
            for (int j = 0; j < i; j++) {
                int a = t->pin[i], b = t->pin[j];
                if (a == b || !lw_joint_turns(k->joint[i].kind) || !lw_joint_turns(k->joint[j].kind) ||
                    !(t->on_pin[a] & t->on_pin[b]) || !lw_same_place(k->joint[i].at, k->joint[j].at))
                    continue;
                int keep = a < b ? a : b, drop = a < b ? b : a;
                for (int h = 0; h < k->n_joint; h++)
                    if (t->pin[h] == drop)
                        t->pin[h] = keep;
                t->on_pin[keep] |= t->on_pin[drop];
                more = true;
            }
    }
}

/* ---- dyads ------------------------------------------------------------------------------------ */

static bool is_gear(const lw_topology *t, int joint) { return lw_joint_has_ratio(t->k->joint[joint].kind); }

/* The first joint between an unknown link and a known one; -1 when there is none. */
static int outer_joint(const lw_topology *t, int link)
{
    for (int j = 0; j < t->k->n_joint; j++) {
        bool carries = lw_plan_is_pin(t, j) ? t->on_pin[t->pin[j]] >> link & 1 : lw_joint_has(&t->k->joint[j], link);
        if (carries && !is_gear(t, j) && lw_known_link(t, j) >= 0)
            return j;
    }
    return -1;
}

static int inner_joint(const lw_topology *t, int a, int b)
{
    for (int j = 0; j < t->k->n_joint; j++) {
        const lw_joint *q = &t->k->joint[j];
        if (is_gear(t, j) || lw_known_link(t, j) >= 0)
            continue;
        if (lw_plan_is_pin(t, j) ? (t->on_pin[t->pin[j]] >> a & 1 && t->on_pin[t->pin[j]] >> b & 1)
                         : lw_joint_has(q, a) && lw_joint_has(q, b))
            return j;
    }
    return -1;
}

/* The kind of dyad by its joints outer, inner, outer.  Three sliders are no dyad: two links that cannot turn against
 * each other would have three conditions for two freedoms. */
static bool dyad_kind(const lw_topology *t, lw_plan_group *g)
{
    static const lw_step_kind kind[8] = {                /* a bit is set for a pin: outer, inner, outer */
        LW_STEP_POINT, LW_STEP_PPR, LW_STEP_PRP, LW_STEP_RRP, LW_STEP_PPR, LW_STEP_RPR, LW_STEP_RRP, LW_STEP_RRR
    };
    g->kind = kind[4*lw_plan_is_pin(t, g->joint[0]) + 2*lw_plan_is_pin(t, g->joint[1]) + lw_plan_is_pin(t, g->joint[2])];
    return g->kind != LW_STEP_POINT;
}

static bool try_dyad(const lw_topology *t, int a, int b, lw_plan_group *g)
{
    *g = (lw_plan_group){ .link = { a, b }, .joint = { outer_joint(t, a), inner_joint(t, a, b), outer_joint(t, b) } };
    if (g->joint[0] < 0 || g->joint[1] < 0 || g->joint[2] < 0 || !dyad_kind(t, g))
        return false;
    for (int h = 0; h < 3; h++)
        if (t->pin[g->joint[h]] == t->pin[t->input_joint] && t->driven < 0)
            return false;                                /* the input adds a condition between the links */
    g->base[0] = lw_known_link(t, g->joint[0]);
    g->base[1] = lw_known_link(t, g->joint[2]);
    if (t->rank[g->base[0]] < t->rank[g->base[1]])
        *g = (lw_plan_group){ g->kind, { b, a }, { g->joint[2], g->joint[1], g->joint[0] },
                         { g->base[1], g->base[0] }, { false, false }, 0, 0 };
    return true;
}

static bool find_dyad(const lw_topology *t, lw_plan_group *g)
{
    for (int a = 0; a < t->k->n_link; a++)
        for (int b = a + 1; t->rank[a] < 0 && b < t->k->n_link; b++)
            if (t->rank[b] < 0 && try_dyad(t, a, b, g))
                return true;
    return false;
}

/* ---- the whole -------------------------------------------------------------------------------- */

/* The mobility: a pin of m links takes 2 (m - 1) freedoms, a tied input takes 1. */
static int mobility(const lw_topology *t)
{
    int f = 3*(t->k->n_link - 1) - (t->k->n_input - 1);
    for (int j = 0; j < t->k->n_joint; j++)
        if (!lw_plan_is_pin(t, j))
            f -= is_gear(t, j) ? 1 : 2;
        else if (t->pin[j] == j)
            f -= 2*(__builtin_popcount(t->on_pin[j]) - 1);
    return f;
}

static lw_status check_inputs(const lw_linkage *linkage, bool tied, lw_error *e)
{
    int own = lw_linkage_free_inputs(linkage);
    if (own != 1)
        return lw_error_set(e, LW_E_KIND, "a plan needs one input, this linkage has %d", own);
    for (int i = 0; i < linkage->n_input && linkage->n_input > 1; i++) {
        const lw_joint *j = &linkage->joint[linkage->input[i].joint];
        if (!tied || !lw_joint_turns(j->kind) || !lw_joint_has(j, linkage->ground))
            return lw_error_set(e, LW_E_KIND, "inputs \"%s\" and \"%s\" are tied%s",
                                linkage->joint[linkage->input[0].joint].name,
                                linkage->joint[linkage->input[i > 0 ? i : 1].joint].name,
                                tied ? "; plans take such inputs only where they turn on the ground" : "");
    }
    return LW_OK;
}

static lw_status check_joints(const lw_linkage *linkage, lw_plan_kind plan_kind, lw_error *e)
{
    const bool higher = plan_kind >= LW_PLAN_HIGHER, gears = plan_kind == LW_PLAN_GEARED;
    for (int j = 0; j < linkage->n_joint; j++) {
        lw_joint_kind kind = linkage->joint[j].kind;
        bool known = false;
        switch (kind) {
        case LW_JOINT_REVOLUTE: case LW_JOINT_SLIDER: known = true; break;
        case LW_JOINT_SLOT:  known = higher; break;
        case LW_JOINT_GEAR:  known = gears;  break;
        case LW_JOINT_FIXED: case LW_JOINT_FREE: break;
        }
        if (known)
            continue;
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" is of kind '%c'; %s plans know pins ('r')%s sliders ('t')%s",
                            linkage->joint[j].name, (char)kind, higher ? "the" : "closed-form", higher ? "," : " and",
                            higher ? " and pins in slots ('p')" : "");
    }
    return check_inputs(linkage, gears, e);
}

/* An input at the ground makes its link known.  An input between two moving links belongs to their group. */
static void find_input(lw_topology *t)
{
    const lw_linkage *k = t->k;
    t->input_joint = k->input[0].joint;
    const lw_joint *j = &k->joint[t->input_joint];
    t->rank[k->ground] = 0;
    t->driven = -1;
    if (!lw_joint_has(j, k->ground))
        return;
    t->driven = lw_joint_other(j, k->ground);
    t->rank[t->driven] = 1;
}

static lw_status add_cluster(lw_topology *t, int *known, lw_error *e)
{
    if (t->n_cluster == LW_HIGHER_MAX)
        return lw_error_set(e, LW_E_KIND, "more than %d higher Assur groups", LW_HIGHER_MAX);
    lw_cluster *c = &t->cluster[t->n_cluster];
    lw_status s = lw_plan_find_cluster(t, c, e);
    if (s != LW_OK || (s = lw_plan_gear_turns(t, c, e)) != LW_OK)
        return s;
    t->group[t->n_group++] = (lw_plan_group){ .kind = LW_STEP_HIGHER, .cluster = t->n_cluster++ };
    for (int i = 0; i < c->n_link; i++)
        t->rank[c->reach[i].b] = (*known)++;
    return LW_OK;
}

static lw_status left_over(const lw_topology *t, lw_error *e)
{
    char list[400] = "";
    const lw_joint *j = &t->k->joint[t->input_joint];
    if (t->driven < 0)
        return lw_error_set(e, LW_E_KIND, "the input joint \"%s\" does not touch the ground link \"%s\"; closed-form "
                            "plans start from a driven link at the ground", j->name, t->k->link_name[t->k->ground]);
    lw_plan_list_unknown(t, list, sizeof list);
    return lw_error_set(e, LW_E_KIND, "not a chain of dyads (pairs of links joined to what is known already): %s left over", list);
}

/* Take gears and dyads as long as there are any, then the smallest higher group, and so on. */
static lw_status find_groups(lw_topology *t, bool higher, lw_error *e)
{
    int known = t->driven < 0 ? 1 : 2;
    lw_status s = lw_plan_tie_inputs(t, &known, e);
    while (s == LW_OK && known < t->k->n_link) {
        lw_plan_group g;
        bool geared;
        s = lw_plan_find_gear(t, &known, &geared, e);
        if (s != LW_OK || geared)
            continue;
        if (!find_dyad(t, &g)) {
            s = higher ? add_cluster(t, &known, e) : left_over(t, e);
            continue;
        }
        if (t->n_group - t->n_cluster - t->n_gear == LW_DYAD_MAX)
            return lw_error_set(e, LW_E_KIND, "more than %d dyads", LW_DYAD_MAX);
        t->group[t->n_group++] = g;
        t->rank[g.link[0]] = known++;
        t->rank[g.link[1]] = known++;
    }
    return s;
}

/* Find the links that the outputs need, from the last group to the first: a link is needed if an output is on it, or if
 * a needed group is joined to it. */
static void slice(lw_topology *t, lw_plan_options options)
{
    bool need[LW_LINK_MAX] = { false };
    for (int i = 0; i < t->k->n_link; i++)
        need[i] = options.all_joints;
    for (int i = 0; i < t->k->n_tracer; i++)
        if (options.tracers >> i & 1)
            need[t->k->tracer[i].link] = true;
    for (int i = t->n_group - 1; i >= 0; i--) {
        lw_plan_group *g = &t->group[i];
        if (g->kind == LW_STEP_HIGHER) {
            lw_cluster *c = &t->cluster[g->cluster];
            for (int l = 0; l < t->k->n_link; l++)
                c->need |= need[l] && c->links >> l & 1;
            for (int l = 0; c->need && l < t->k->n_link; l++)
                need[l] |= c->bases >> l & 1;
            continue;
        }
        g->need[0] = need[g->link[0]];
        g->need[1] = need[g->link[1]];
        if (g->need[0] || g->need[1])
            need[g->base[0]] = need[g->base[1]] = true;
    }
}

lw_status lw_plan_expand(const lw_linkage *linkage, lw_linkage *wide, int *slot, lw_error *e)
{
    *wide = *linkage;
    for (int j = 0; slot && j < LW_JOINT_MAX; j++)
        slot[j] = -1;
    for (int j = 0; j < linkage->n_joint; j++) {
        if (linkage->joint[j].kind != LW_JOINT_SLOT)
            continue;
        if (wide->n_link == LW_LINK_MAX || wide->n_joint == LW_JOINT_MAX)
            return lw_error_set(e, LW_E_KIND,
                                "pins in slots count as links and joints of their own; with them there are more "
                                "than %d links or %d joints", LW_LINK_MAX, LW_JOINT_MAX);
        int die = wide->n_link++;
        lw_joint *pin = &wide->joint[j], *slide = &wide->joint[wide->n_joint++];
        char name[LW_NAME_SIZE];
        memcpy(name, pin->name, sizeof name);
        snprintf(wide->link_name[die], LW_NAME_SIZE, "die of %.20s", name);
        *slide = *pin;
        slide->kind = LW_JOINT_SLIDER;
        slide->link[1] = die;
        snprintf(slide->name, LW_NAME_SIZE, "slot of %.20s", name);
        pin->kind = LW_JOINT_REVOLUTE;
        pin->link[0] = die;
        pin->along = lw_v2(0, 0);
        if (slot)
            slot[j] = wide->n_joint - 1;
    }
    return LW_OK;
}

static lw_status no_freedom(const lw_topology *t, lw_error *e)
{
    int n = t->k->n_input;
    return lw_error_set(e, LW_E_KIND, "the linkage has freedom F = %d; %s F = %d", mobility(t) + n - 1,
                        n == 1 ? "one input needs" : "its inputs need", n);
}

static lw_status make(lw_topology *t, const lw_linkage *linkage, lw_plan_options options, lw_plan *plan, lw_error *e)
{
    const bool higher = options.kind >= LW_PLAN_HIGHER;
    lw_linkage wide;
    lw_status s = lw_plan_expand(linkage, &wide, t->slot, e);
    if (s != LW_OK)
        return s;
    t->k = &wide;
    find_input(t);
    join_pins(t);
    if (higher && mobility(t) != 1)                 /* without higher groups the message about dyads is clearer */
        return no_freedom(t, e);
    if ((s = lw_plan_start_gears(t, e)) != LW_OK || (s = find_groups(t, higher, e)) != LW_OK || (s = lw_plan_check_gears(t, e)) != LW_OK)
        return s;
    if (mobility(t) != 1)
        return no_freedom(t, e);
    slice(t, options);
    memset(plan, 0, sizeof *plan);
    plan->input_turns_per_period = t->input_turns_per_period;
    return lw_plan_emit(t, options, plan, e);
}

lw_status lw_plan_make(const lw_linkage *linkage, lw_plan_options options, lw_plan *plan, lw_error *e)
{
    lw_topology t = { .k = linkage };
    for (int i = 0; i < LW_LINK_MAX; i++)
        t.rank[i] = -1;
    lw_status s = lw_linkage_check(linkage, e);
    if (s != LW_OK)
        return s;
    if (linkage->n_tracer < 32 && options.tracers >> linkage->n_tracer)
        return lw_error_set(e, LW_E_ARG, "a tracer is wanted that the linkage does not have (it has %d)", linkage->n_tracer);
    if (!options.tracers && !options.all_joints)
        return lw_error_set(e, LW_E_ARG, "nothing is wanted of the plan");
    s = check_joints(linkage, options.kind, e);
    return s == LW_OK ? make(&t, linkage, options, plan, e) : s;
}

int lw_plan_dim(const lw_plan *plan, const char *name)
{
    for (int d = 0; d < plan->n_dim; d++)
        if (strcmp(plan->dim[d].name, name) == 0)
            return d;
    return -1;
}

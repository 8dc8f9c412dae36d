/* grammar/linkage/linkage_gear.c - finds the link that carries a gear pair, or a rack and its pinion. */
#include "base/real.h"
#include "grammar/linkage/linkage.h"

#include <stdbool.h>

#define CONTACT_TOLERANCE 1e-6

/* Links welded together, as bits; bit of `link` included. */
static uint32_t welded(const lw_linkage *linkage, int link)
{
    uint32_t set = 1u << link, before = 0;
    while (set != before) {
        before = set;
        for (int j = 0; j < linkage->n_joint; j++) {
            uint32_t pair = 1u << linkage->joint[j].link[0] | 1u << linkage->joint[j].link[1];
            if (lw_joint_freedoms(linkage->joint[j].kind) == 0 && set & pair)
                set |= pair;
        }
    }
    return set;
}

static bool same_place(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }

/* The links in `set` and all links that share a pin with them at `at`: joints at one place make one pin. */
static uint32_t on_pin(const lw_linkage *linkage, uint32_t set, lw_vec2 at)
{
    uint32_t before = 0;
    while (set != before) {
        before = set;
        for (int j = 0; j < linkage->n_joint; j++) {
            const lw_joint *q = &linkage->joint[j];
            uint32_t pair = 1u << q->link[0] | 1u << q->link[1];
            if (lw_joint_turns(q->kind) && same_place(q->at, at) && set & pair)
                set |= pair;
        }
    }
    return set;
}

/* True if a link of side i turns or slides on a link of `carrier`; g gets the place. */
static bool runs_on(const lw_linkage *linkage, uint32_t side, uint32_t carrier, int i, lw_gear *g)
{
    for (int j = 0; j < linkage->n_joint; j++) {
        const lw_joint *q = &linkage->joint[j];
        uint32_t a = 1u << q->link[0], b = 1u << q->link[1];
        bool touches = (a | b) & side;
        g->centre[i] = q->at;
        g->slider[i] = lw_joint_translates(q->kind) ? j : -1;
        g->way[i] = b & side ? 1.0 : -1.0;
        if (lw_joint_translates(q->kind) && ((a & side && b & carrier) || (b & side && a & carrier)))
            return true;
        if (lw_joint_turns(q->kind) && touches && on_pin(linkage, side & (a | b), q->at) & carrier)
            return true;
    }
    return false;
}

/* From the pinion's centre to the point that moves by `way` along the rack as the pinion turns by 1. */
static lw_vec2 pitch_arm(const lw_linkage *linkage, int slider, double way)
{
    return lw_v2_scale(lw_v2_perp(linkage->joint[slider].along), -way);
}

lw_vec2 lw_linkage_contact(const lw_linkage *linkage, int joint, const lw_gear *g)
{
    double ratio = linkage->joint[joint].ratio;
    const lw_vec2 *c = g->centre;
    if (g->slider[0] >= 0 && g->slider[1] >= 0)
        return linkage->joint[joint].at;
    if (g->slider[1] >= 0)
        return lw_v2_add(c[0], pitch_arm(linkage, g->slider[1], ratio));
    if (g->slider[0] >= 0)
        return lw_v2_add(c[1], pitch_arm(linkage, g->slider[0], 1.0/ratio));
    if (ratio == 1.0)
        return lw_v2_scale(lw_v2_add(c[0], c[1]), 0.5);
    return lw_v2_scale(lw_v2_sub(c[0], lw_v2_scale(c[1], ratio)), 1.0/(1.0 - ratio));
}

double lw_linkage_gear_unit(const lw_gear *g, double metre)
{
    return (g->slider[1] >= 0 ? metre : 1.0)/(g->slider[0] >= 0 ? metre : 1.0);
}

static bool touches_there(const lw_linkage *linkage, int joint, const lw_gear *g)
{
    double off = lw_v2_norm(lw_v2_sub(lw_linkage_contact(linkage, joint, g), linkage->joint[joint].at));
    return off <= CONTACT_TOLERANCE*lw_v2_norm(lw_v2_sub(g->centre[0], g->centre[1]));
}

lw_status lw_linkage_gear(const lw_linkage *linkage, int joint, lw_gear *g, lw_error *e)
{
    const lw_joint *q = &linkage->joint[joint];
    uint32_t side[2] = { welded(linkage, q->link[0]), welded(linkage, q->link[1]) }, seen = 0;
    int found = 0, touching = 0;
    lw_gear any = { 0 }, best = { 0 };
    for (int c = 0; c < linkage->n_link; c++) {
        uint32_t carrier = welded(linkage, c);
        lw_gear try = { .carrier = c };
        if (carrier & (side[0] | side[1] | seen))
            continue;
        seen |= carrier;
        if (!runs_on(linkage, side[0], carrier, 0, &try) || !runs_on(linkage, side[1], carrier, 1, &try))
            continue;
        any = try;
        found++;
        if (touches_there(linkage, joint, &try)) {
            best = try;
            touching++;
        }
    }
    if (found == 0)
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear, but no link carries both \"%s\" and \"%s\": give a "
                            "link that both turn (\"r\") or slide (\"t\") on", q->name, linkage->link_name[q->link[0]],
                            linkage->link_name[q->link[1]]);
    if (found > 1 && touching != 1)
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear whose two links turn on %d links in common; put "
                            "\"at\" at the point of contact, so that the line of centres tells which", q->name, found);
    *g = found == 1 ? any : best;
    return LW_OK;
}

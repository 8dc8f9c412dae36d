/* grammar/linkage/linkage_gear.c - finds the link that carries a gear pair, or a rack and its pinion. */
#include "base/real.h"
#include "base/union_find.h"
#include "grammar/linkage/assembly.h"

#include <stdbool.h>
#include <stdlib.h>

#define CONTACT_TOLERANCE 1e-6

/* Scratch of one search.  A set of links or joints is named by one of them, its root. */
typedef struct pin_place { lw_vec2 at; int joint; } pin_place;
typedef struct bearings {
    int *weld;           /* (n_link) links welded together */
    int *pin;            /* (n_joint) joints that share links at one place and so make one pin */
    int *first[2];       /* (n_link) of each weld: the first joint in which side 0, 1 runs on it; -1: none */
    int *side_joint;     /* (n_joint) of each pin: its first joint with a link of the side; -1: none */
    int *last_joint;     /* (n_link) */
    pin_place *place;    /* (n_joint) */
} bearings;

static void join(int *set, int a, int b) { set[lw_root_of(set, a)] = lw_root_of(set, b); }

static int by_place(const void *first, const void *second)
{
    const pin_place *a = first, *b = second;
    int order = (a->at.x > b->at.x) - (a->at.x < b->at.x);
    order = order ? order : (a->at.y > b->at.y) - (a->at.y < b->at.y);
    return order ? order : (a->joint > b->joint) - (a->joint < b->joint);
}

static bool same_place(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }

/* Find the links that are welded together and the joints that make one pin. */
static void find_sets(const lw_assembly *a, bearings *b)
{
    int n = 0;
    for (int i = 0; i < a->n_link; i++) {
        b->weld[i] = i;
        b->last_joint[i] = -1;
    }
    for (int j = 0; j < a->n_joint; j++) {
        const lw_joint *q = &a->joint[j];
        b->pin[j] = j;
        if (lw_joint_freedoms(q->kind) == 0)
            join(b->weld, q->link[0], q->link[1]);
        if (lw_joint_turns(q->kind))
            b->place[n++] = (pin_place){ q->at, j };
    }
    qsort(b->place, (size_t)n, sizeof *b->place, by_place);
    for (int k = 0; k < n; k++)
        for (int end = 0; end < 2; end++) {
            int j = b->place[k].joint, *last = &b->last_joint[a->joint[j].link[end]];
            if (*last >= 0 && same_place(a->joint[*last].at, a->joint[j].at))
                join(b->pin, *last, j);
            *last = j;
        }
}

static void keep_first(int *joint, int j) { *joint = *joint < 0 || j < *joint ? j : *joint; }

/* Find where side i of the gear, the weld `side`, turns or slides on other links. */
static void find_bearings(const lw_assembly *a, bearings *b, int i, int side)
{
    for (int c = 0; c < a->n_link; c++)
        b->first[i][c] = -1;
    for (int j = 0; j < a->n_joint; j++)
        b->side_joint[j] = -1;
    for (int j = 0; j < a->n_joint; j++) {
        const lw_joint *q = &a->joint[j];
        int weld[2] = { lw_root_of(b->weld, q->link[0]), lw_root_of(b->weld, q->link[1]) };
        if (weld[0] != side && weld[1] != side)
            continue;
        if (lw_joint_translates(q->kind))
            keep_first(&b->first[i][weld[weld[0] == side]], j);
        if (lw_joint_turns(q->kind))
            keep_first(&b->side_joint[lw_root_of(b->pin, j)], j);
    }
    for (int j = 0; j < a->n_joint; j++) {
        int at_side = b->side_joint[lw_root_of(b->pin, j)];
        for (int end = 0; at_side >= 0 && end < 2; end++)
            keep_first(&b->first[i][lw_root_of(b->weld, a->joint[j].link[end])], at_side);
    }
}

/* From the pinion's centre to the point that moves by `way` along the rack as the pinion turns by 1. */
static lw_vec2 pitch_arm(const lw_joint *joint, int slider, double way)
{
    return lw_v2_scale(lw_v2_perp(joint[slider].along), -way);
}

lw_vec2 lw_gear_contact(const lw_joint *joint, int gear, const lw_gear *g)
{
    double ratio = joint[gear].ratio;
    const lw_vec2 *c = g->centre;
    if (g->slider[0] >= 0 && g->slider[1] >= 0)
        return joint[gear].at;
    if (g->slider[1] >= 0)
        return lw_v2_add(c[0], pitch_arm(joint, g->slider[1], ratio));
    if (g->slider[0] >= 0)
        return lw_v2_add(c[1], pitch_arm(joint, g->slider[0], 1.0/ratio));
    if (ratio == 1.0)
        return lw_v2_scale(lw_v2_add(c[0], c[1]), 0.5);
    return lw_v2_scale(lw_v2_sub(c[0], lw_v2_scale(c[1], ratio)), 1.0/(1.0 - ratio));
}

double lw_linkage_gear_unit(const lw_gear *g, double metre)
{
    return (g->slider[1] >= 0 ? metre : 1.0)/(g->slider[0] >= 0 ? metre : 1.0);
}

static bool touches_there(const lw_joint *joint, int gear, const lw_gear *g)
{
    double off = lw_v2_norm(lw_v2_sub(lw_gear_contact(joint, gear, g), joint[gear].at));
    return off <= CONTACT_TOLERANCE*lw_v2_norm(lw_v2_sub(g->centre[0], g->centre[1]));
}

/* The gear of two sides (welds) that run on link `carrier`. */
static lw_gear gear_on(const lw_assembly *a, bearings *b, const int *side, int carrier)
{
    lw_gear g = { .carrier = carrier };
    for (int i = 0; i < 2; i++) {
        int j = b->first[i][lw_root_of(b->weld, carrier)];
        const lw_joint *q = &a->joint[j];
        g.centre[i] = q->at;
        g.slider[i] = lw_joint_translates(q->kind) ? j : -1;
        g.way[i] = lw_root_of(b->weld, q->link[1]) == side[i] ? 1.0 : -1.0;
    }
    return g;
}

static lw_status find_carrier(const lw_assembly *a, int joint, bearings *b, lw_gear *g, lw_error *e)
{
    const lw_joint *q = &a->joint[joint];
    int found = 0, touching = 0, side[2];
    lw_gear any = { 0 }, best = { 0 };
    find_sets(a, b);
    for (int i = 0; i < 2; i++) {
        side[i] = lw_root_of(b->weld, q->link[i]);
        find_bearings(a, b, i, side[i]);
    }
    for (int c = 0; c < a->n_link; c++) {
        int weld = lw_root_of(b->weld, c);
        if (weld == side[0] || weld == side[1] || b->first[0][weld] < 0 || b->first[1][weld] < 0)
            continue;
        lw_gear try = gear_on(a, b, side, c);
        b->first[0][weld] = -1;                              /* count links welded to c no more */
        any = try;
        found++;
        if (touches_there(a->joint, joint, &try)) {
            best = try;
            touching++;
        }
    }
    if (found == 0)
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear, but no link carries both \"%s\" and \"%s\": give a "
                            "link that both turn (\"r\") or slide (\"t\") on", q->name, a->link_name[q->link[0]],
                            a->link_name[q->link[1]]);
    if (found > 1 && touching != 1)
        return lw_error_set(e, LW_E_KIND, "joint \"%s\" is a gear whose two links turn on %d links in common; put "
                            "\"at\" at the point of contact, so that the line of centres tells which", q->name, found);
    *g = found == 1 ? any : best;
    return LW_OK;
}

lw_status lw_assembly_gear(const lw_assembly *a, int joint, lw_gear *g, lw_vec2 *contact, lw_error *e)
{
    int small[4*LW_LINK_MAX + 2*LW_JOINT_MAX], *ints = small;
    pin_place few[LW_JOINT_MAX], *place = few;
    size_t n_link = (size_t)a->n_link, n_joint = (size_t)a->n_joint;
    if (n_link > LW_LINK_MAX || n_joint > LW_JOINT_MAX) {
        ints = malloc((4*n_link + 2*n_joint)*sizeof *ints);
        place = malloc(n_joint*sizeof *place);
    }
    lw_status s = ints && place ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        int *of_joint = ints + 4*n_link;
        bearings b = { .weld = ints, .first = { ints + n_link, ints + 2*n_link }, .last_joint = ints + 3*n_link,
                       .pin = of_joint, .side_joint = of_joint + n_joint, .place = place };
        s = find_carrier(a, joint, &b, g, e);
    }
    if (ints != small) {
        free(ints);
        free(place);
    }
    if (s == LW_OK && contact)
        *contact = lw_gear_contact(a->joint, joint, g);
    return s;
}

lw_status lw_linkage_gear(const lw_linkage *linkage, int joint, lw_gear *g, lw_error *e)
{
    return lw_assembly_gear(LW_VIEW(linkage), joint, g, NULL, e);
}

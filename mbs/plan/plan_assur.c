/* Find the next Assur group when there is no dyad: the fewest unknown links that known links determine together.
 *
 * A graph has two nodes a link, its place (two freedoms) and its turn (one freedom).  A joint puts conditions on the
 * nodes of its links: two for a pin or slider, one for a gear, one more at the input.  Every condition is assigned to
 * one of its nodes, so that each node owns as many conditions as it has freedoms.  An arrow goes from the owner of a
 * condition to its other nodes, and both ways between place and turn of a link.  The strong components of this graph
 * are the Assur groups, whatever assignment was found (Servatius, Shai & Whiteley 2010).  The conditions of gears and
 * of parallel slides contain turns only, so that two of them cannot hold a place.  A pin of three or more unknown
 * links is a node of its own with two freedoms. */
#include "mbs/plan/plan_internal.h"

#include <stdio.h>
#include <string.h>

#define NODE_MAX (2*LW_LINK_MAX + LW_JOINT_MAX)
#define CONDITION_MAX (4*LW_JOINT_MAX)
#define END_MAX  6

/* A condition, its nodes and the node that owns it. */
typedef struct condition { int n, end[END_MAX], owner; } condition;

typedef struct graph {
    const lw_topology *t;
    int  n_node, n_condition;
    int  freedom[NODE_MAX], load[NODE_MAX];
    int  place[LW_LINK_MAX];                 /* node of each link, its turn is the next; -1: known */
    condition condition[CONDITION_MAX];
    bool reach[NODE_MAX][NODE_MAX];
} graph;

int lw_known_link(const lw_topology *t, int joint)
{
    uint32_t on = lw_plan_is_pin(t, joint) ? t->on_pin[t->pin[joint]]
                                   : 1u << t->k->joint[joint].link[0] | 1u << t->k->joint[joint].link[1];
    int best = -1;
    for (int i = 0; i < t->k->n_link; i++)
        if (on >> i & 1 && t->rank[i] >= 0 && (best < 0 || t->rank[i] < t->rank[best]))
            best = i;
    return best;
}

void lw_plan_list_unknown(const lw_topology *t, char *list, size_t size)
{
    list[0] = 0;
    for (int i = 0; i < t->k->n_link; i++)
        if (t->rank[i] < 0) {
            size_t n = strlen(list);
            snprintf(list + n, size - n, "%s\"%s\"", n ? ", " : "", t->k->link_name[i]);
        }
}

static void add_end(condition *u, int node)
{
    if (node >= 0)
        u->end[u->n++] = node;
}

static void add_turn(const graph *g, condition *u, int link)
{
    add_end(u, g->place[link] < 0 ? -1 : g->place[link] + 1);
}

static void add_place(const graph *g, condition *u, int link)
{
    add_end(u, g->place[link]);
    add_turn(g, u, link);
}

static void add_condition(graph *g, const condition *u)
{
    if (u->n > 0 && g->n_condition < CONDITION_MAX)
        g->condition[g->n_condition++] = *u;
}

/* A point of link a coincides with one of link b, or with the pin `body`. */
static void add_point(graph *g, int a, int b, int body)
{
    condition u = { .owner = -1 };
    add_place(g, &u, a);
    if (b >= 0)
        add_place(g, &u, b);
    add_end(&u, body);
    add_condition(g, &u);
    add_condition(g, &u);
}

/* The unknown links on a pin. */
static int free_links(const lw_topology *t, int pin, int *link)
{
    int n = 0;
    for (int i = 0; i < t->k->n_link; i++)
        if (t->on_pin[pin] >> i & 1 && t->rank[i] < 0)
            link[n++] = i;
    return n;
}

static void add_pin(graph *g, int pin)
{
    const lw_topology *t = g->t;
    int link[LW_LINK_MAX], n = free_links(t, pin, link);
    if (n == 2 && lw_known_link(t, pin) < 0) {
        add_point(g, link[0], link[1], -1);
        return;
    }
    int centre = -1;
    if (n > 2 && lw_known_link(t, pin) < 0) {
        centre = g->n_node++;
        g->freedom[centre] = 2;
    }
    for (int i = 0; i < n; i++)
        add_point(g, link[i], -1, centre);
}

/* The links do not turn against each other. */
static void add_parallel(graph *g, const lw_joint *q)
{
    condition u = { .owner = -1 };
    add_turn(g, &u, q->link[0]);
    add_turn(g, &u, q->link[1]);
    add_condition(g, &u);
}

/* One link does not move across the line of the other (or along it, for an input). */
static void add_line(graph *g, const lw_joint *q)
{
    condition u = { .owner = -1 };
    add_place(g, &u, q->link[0]);
    add_place(g, &u, q->link[1]);
    add_condition(g, &u);
}

/* A gear joins the turns of wheels and carrier; with a rack also the places of rack and carrier. */
static void add_gear(graph *g, int j)
{
    const lw_gear *gear = &g->t->gear[j];
    bool rack = gear->slider[0] >= 0 || gear->slider[1] >= 0;
    condition u = { .owner = -1 };
    for (int side = 0; side < 2; side++)
        if (gear->slider[side] >= 0)
            add_place(g, &u, g->t->k->joint[j].link[side]);
        else
            add_turn(g, &u, g->t->k->joint[j].link[side]);
    if (rack)
        add_place(g, &u, gear->carrier);
    else
        add_turn(g, &u, gear->carrier);
    add_condition(g, &u);
}

static void add_links(graph *g)
{
    for (int i = 0; i < g->t->k->n_link; i++) {
        g->place[i] = g->t->rank[i] < 0 ? g->n_node : -1;
        if (g->t->rank[i] >= 0)
            continue;
        g->freedom[g->n_node++] = 2;
        g->freedom[g->n_node++] = 1;
    }
}

static void build(graph *g)
{
    const lw_topology *t = g->t;
    add_links(g);
    for (int j = 0; j < t->k->n_joint; j++) {
        const lw_joint *q = &t->k->joint[j];
        bool driven = j == t->input_joint && t->driven < 0;
        if (lw_plan_is_pin(t, j) && t->pin[j] == j)
            add_pin(g, j);
        if (lw_joint_translates(q->kind)) {
            add_parallel(g, q);
            add_line(g, q);
        }
        if (driven && lw_plan_is_pin(t, j))
            add_parallel(g, q);
        else if (driven)
            add_line(g, q);
        if (lw_joint_has_ratio(q->kind) && !t->geared[j])
            add_gear(g, j);
    }
}

/* Make room for one more condition at a node: move others to other nodes (augmenting path). */
static bool make_room(graph *g, int node, bool *seen)
{
    if (seen[node])
        return false;
    seen[node] = true;
    if (g->load[node] < g->freedom[node])
        return true;
    for (int i = 0; i < g->n_condition; i++) {
        condition *u = &g->condition[i];
        for (int h = 0; u->owner == node && h < u->n; h++)
            if (u->end[h] != node && make_room(g, u->end[h], seen)) {
                u->owner = u->end[h];
                g->load[u->end[h]]++;
                g->load[node]--;
                return true;
            }
    }
    return false;
}

static bool assign(graph *g)
{
    for (int i = 0; i < g->n_condition; i++) {
        condition *u = &g->condition[i];
        bool seen[NODE_MAX] = { false };
        for (int h = 0; h < u->n && u->owner < 0; h++)
            if (make_room(g, u->end[h], seen))
                u->owner = u->end[h];
        if (u->owner < 0)
            return false;
        g->load[u->owner]++;
    }
    for (int i = 0; i < g->n_node; i++)
        if (g->load[i] != g->freedom[i])
            return false;
    return true;
}

/* The nodes that each node depends on, itself included. */
static void set_reach(graph *g)
{
    for (int i = 0; i < g->n_node; i++)
        g->reach[i][i] = true;
    for (int l = 0; l < g->t->k->n_link; l++)
        if (g->place[l] >= 0)
            g->reach[g->place[l]][g->place[l] + 1] = g->reach[g->place[l] + 1][g->place[l]] = true;
    for (int i = 0; i < g->n_condition; i++)
        for (int h = 0; h < g->condition[i].n; h++)
            g->reach[g->condition[i].owner][g->condition[i].end[h]] = true;
    for (int m = 0; m < g->n_node; m++)
        for (int i = 0; i < g->n_node; i++)
            for (int j = 0; g->reach[i][m] && j < g->n_node; j++)
                g->reach[i][j] = g->reach[i][j] || g->reach[m][j];
}

/* The component with the fewest links that depends on no other. */
static uint32_t smallest(const graph *g)
{
    uint32_t best = 0;
    for (int i = 0; i < g->n_node; i++) {
        bool closed = true;
        for (int j = 0; j < g->n_node; j++)
            closed = closed && (!g->reach[i][j] || g->reach[j][i]);
        uint32_t links = 0;
        for (int l = 0; l < g->t->k->n_link; l++)
            if (g->place[l] >= 0 && g->reach[i][g->place[l]])
                links |= 1u << l;
        if (closed && links && (!best || __builtin_popcount(links) < __builtin_popcount(best)))
            best = links;
    }
    return best;
}

/* ---- a tree over the group, and its loops ------------------------------------------------------------- */

typedef struct tree {
    const lw_topology *t;
    uint32_t links;
    int      n_tie;
    lw_tie   tie[2*LW_JOINT_MAX];
    bool     in_tree[2*LW_JOINT_MAX];
    int      part[LW_LINK_MAX];              /* tree that each link is in; known links share one    */
} tree;

static bool inside(const tree *r, int link) { return r->links >> link & 1; }

static void add_tie(tree *r, int a, int b, int joint)
{
    if (r->n_tie < 2*LW_JOINT_MAX)
        r->tie[r->n_tie++] = inside(r, b) ? (lw_tie){ a, b, joint } : (lw_tie){ b, a, joint };
}

static bool on_links(const tree *r, int a, int b)
{
    const lw_topology *t = r->t;
    return (inside(r, a) || inside(r, b)) && (inside(r, a) || t->rank[a] >= 0) && (inside(r, b) || t->rank[b] >= 0);
}

/* Does the input turn the two links of this tie against each other? */
static bool is_input(const lw_topology *t, const lw_tie *q)
{
    const lw_joint *in = &t->k->joint[t->input_joint];
    return t->driven < 0 && t->pin[q->joint] == t->pin[t->input_joint] && lw_joint_has(in, q->a)
        && lw_joint_has(in, q->b);
}

/* The order in which ties enter the tree, chosen to keep loops short: slides, which must be in it; the input; pins to
 * known links; the rest. */
static int urgency(const tree *r, const lw_tie *q)
{
    if (!lw_plan_is_pin(r->t, q->joint))
        return 0;
    if (is_input(r->t, q))
        return 1;
    return inside(r, q->a) ? 3 : 2;
}

/* Tie the links of a pin to the known link on it, else to the first one; tie the links of the input to each other. */
static void tie_pin(tree *r, int pin)
{
    const lw_topology *t = r->t;
    const lw_joint *in = &t->k->joint[t->input_joint];
    bool driven = t->driven < 0 && lw_plan_is_pin(t, t->input_joint) && t->pin[t->input_joint] == pin
                  && inside(r, in->link[0]) && inside(r, in->link[1]);
    int centre = lw_known_link(t, pin);
    if (centre < 0 && driven)
        centre = in->link[0];
    for (int l = 0; l < t->k->n_link; l++) {
        if (!(t->on_pin[pin] >> l & 1) || !inside(r, l) || l == centre)
            continue;
        if (driven && l == in->link[1])
            add_tie(r, in->link[0], l, pin);
        else if (centre >= 0)
            add_tie(r, centre, l, pin);
        else
            centre = l;
    }
}

static void collect_ties(tree *r)
{
    const lw_topology *t = r->t;
    for (int j = 0; j < t->k->n_joint; j++) {
        const lw_joint *q = &t->k->joint[j];
        if (lw_joint_has_ratio(q->kind))                    /* a gear gives no path from link to link */
            continue;
        if (!lw_plan_is_pin(t, j)) {
            if (on_links(r, q->link[0], q->link[1]))
                add_tie(r, q->link[0], q->link[1], j);
            continue;
        }
        if (t->pin[j] == j)
            tie_pin(r, j);
    }
}

static int part_of(const tree *r, int link) { return inside(r, link) ? r->part[link] : -1; }

static lw_status grow(tree *r, lw_error *e)
{
    for (int l = 0; l < LW_LINK_MAX; l++)
        r->part[l] = l;
    for (int rank = 0; rank < 4; rank++)
        for (int i = 0; i < r->n_tie; i++) {
            int a = part_of(r, r->tie[i].a), b = part_of(r, r->tie[i].b);
            if (urgency(r, &r->tie[i]) != rank)
                continue;
            if (a == b && rank < 2)
                return lw_error_set(e, LW_E_KIND,
                                    "the slide or input \"%s\" closes a chain of slides, which hold each other "
                                    "from turning more than once", r->t->k->joint[r->tie[i].joint].name);
            r->in_tree[i] = a != b;
            int keep = a < b ? a : b, drop = a < b ? b : a;
            for (int l = 0; a != b && l < LW_LINK_MAX; l++)
                if (r->part[l] == drop)
                    r->part[l] = keep;
        }
    return LW_OK;
}

/* List the links in the order of their distance from known ones, then the loops and the known links. */
static void walk(const tree *r, lw_cluster *c)
{
    uint32_t seen = 0;
    for (bool more = true; more; ) {
        uint32_t before = seen;
        for (int i = 0; i < r->n_tie; i++) {
            lw_tie q = r->tie[i];
            bool a = !inside(r, q.a) || before >> q.a & 1, b = before >> q.b & 1;
            if (!r->in_tree[i] || a == b || seen >> (a ? q.b : q.a) & 1)
                continue;
            c->reach[c->n_link++] = a ? q : (lw_tie){ q.b, q.a, q.joint };
            seen |= 1u << c->reach[c->n_link - 1].b;
        }
        more = seen != before;
    }
    for (int i = 0; i < r->n_tie; i++) {
        if (!r->in_tree[i])
            c->loop[c->n_loop++] = r->tie[i];
        for (int h = 0; h < 2; h++) {
            int l = h ? r->tie[i].b : r->tie[i].a;
            if (!inside(r, l))
                c->bases |= 1u << l;
        }
    }
}

static lw_status cannot_own(const lw_topology *t, lw_error *e)
{
    char list[400];
    bool turns = false;
    lw_plan_list_unknown(t, list, sizeof list);
    for (int j = 0; j < t->k->n_joint; j++)
        turns = turns || !lw_plan_is_pin(t, j);
    return lw_error_set(e, LW_E_KIND,
                        "some of the links %s are held more than once and others not at all%s, so that the input "
                        "does not say where they are", list,
                        turns ? " (rings of slides, or gears, may hold turns alone)" : "");
}

/* List the gears whose links are in the group or known. */
static void collect_gears(const lw_topology *t, lw_cluster *c)
{
    for (int j = 0; j < t->k->n_joint; j++) {
        const lw_joint *q = &t->k->joint[j];
        if (!lw_joint_has_ratio(q->kind) || t->geared[j])
            continue;
        uint32_t links = 1u << q->link[0] | 1u << q->link[1] | 1u << t->gear[j].carrier;
        bool inside = links & c->links;
        for (int l = 0; l < t->k->n_link; l++)
            inside = inside && (!(links >> l & 1) || c->links >> l & 1 || t->rank[l] >= 0);
        if (!inside)
            continue;
        c->gear[c->n_gear++] = j;
        c->bases |= links & ~c->links;
    }
}

lw_status lw_plan_find_cluster(const lw_topology *t, lw_cluster *c, lw_error *e)
{
    graph g = { .t = t };
    tree r = { .t = t };
    *c = (lw_cluster){ 0 };
    build(&g);
    if (!assign(&g))
        return cannot_own(t, e);
    set_reach(&g);
    c->links = r.links = smallest(&g);
    collect_ties(&r);
    lw_status s = grow(&r, e);
    if (s != LW_OK)
        return s;
    walk(&r, c);
    collect_gears(t, c);
    if (2*c->n_loop + c->n_gear > LW_UNKNOWN_MAX)
        return lw_error_set(e, LW_E_KIND,
                            "a group of %d links with %d loops and %d gears has to be solved at once; plans go up "
                            "to %d equations", c->n_link, c->n_loop, c->n_gear, LW_UNKNOWN_MAX);
    return LW_OK;
}

#include "enumerate/assur.h"

#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/freedom.h"
#include "grammar/text/text_internal.h"
#include "grammar/topology/circuit.h"
#include "grammar/topology/graph6.h"

/* ---- which link owns which condition ----------------------------------------------------------- */

#define UNIT_MAX (3*LW_LINK_MAX)

typedef struct ownership {
    int     n_unit, ground;
    uint8_t end[UNIT_MAX][2], owner[UNIT_MAX];   /* owner: which end, 0 or 1 */
    int     n_owned[LW_LINK_MAX];
} ownership;

static bool is_driven(const lw_mechanism *m, int joint)
{
    return memchr(m->input, joint, (size_t)m->n_input) != NULL;
}

/* Let `link` own one more condition; if necessary it passes one of its own to the other end. */
static bool make_room(ownership *o, int link, uint32_t *tried)
{
    if (link == o->ground || *tried >> link & 1)
        return false;
    *tried |= 1u << link;
    if (o->n_owned[link] < 3)
        return true;
    for (int u = 0; u < o->n_unit; u++) {
        int other = o->end[u][!o->owner[u]];
        if (o->end[u][o->owner[u]] == link && make_room(o, other, tried)) {
            o->owner[u] = !o->owner[u];
            o->n_owned[other]++;
            o->n_owned[link]--;
            return true;
        }
    }
    return false;
}

/* True when every condition found an owner. */
static bool assign_owners(const lw_mechanism *m, ownership *o)
{
    *o = (ownership){ .ground = m->ground };
    for (int j = 0; j < m->n_joint; j++)
        for (int k = is_driven(m, j) ? 3 : lw_joint_equations(m->kind[j]); k > 0; k--) {
            int side = 0, u = o->n_unit;
            for (; side < 2; side++) {
                uint32_t tried = 0;
                if (make_room(o, m->link[j][side], &tried))
                    break;
            }
            if (side == 2 || u == UNIT_MAX)
                return false;
            memcpy(o->end[u], m->link[j], 2);
            o->owner[u] = (uint8_t)side;
            o->n_owned[m->link[j][side]]++;
            o->n_unit++;
        }
    return o->n_unit == 3*(m->n_link - 1);
}

/* reach[i]: all links that link i depends on, by any number of steps, and itself. */
static void depend(const ownership *o, int n_link, uint32_t *reach)
{
    for (int i = 0; i < n_link; i++)
        reach[i] = 1u << i;
    for (int u = 0; u < o->n_unit; u++)
        reach[o->end[u][o->owner[u]]] |= 1u << o->end[u][!o->owner[u]];
    for (int k = 0; k < n_link; k++)
        for (int i = 0; i < n_link; i++)
            if (reach[i] >> k & 1)
                reach[i] |= reach[k];
}

/* ---- class ------------------------------------------------------------------------------------- */

/* A group with p and g as binary links, in which links connected by a driven joint inside count as one. */
typedef struct body { int n, outer; uint32_t row[LW_LINK_MAX]; int inner[LW_LINK_MAX]; } body;

static void join_inside(body *b, int i, int k)
{
    b->row[i] |= 1u << k;
    b->row[k] |= 1u << i;
    b->inner[i]++;
    b->inner[k]++;
}

/* number[i]: the body of link i; links connected by a driven joint inside share a body. */
static int number_bodies(const lw_mechanism *m, const lw_assur_group *g, int *number)
{
    uint8_t tied[LW_LINK_MAX];
    int n = 0;
    for (int i = 0; i < m->n_link; i++)
        tied[i] = (uint8_t)i;
    for (uint64_t s = g->inner; s; s &= s - 1) {
        int j = __builtin_ctzll(s), from = tied[m->link[j][1]], to = tied[m->link[j][0]];
        for (int i = 0; is_driven(m, j) && i < m->n_link; i++)
            if (tied[i] == from)
                tied[i] = (uint8_t)to;
    }
    for (int i = 0; i < m->n_link; i++)
        number[i] = LW_NONE;
    for (uint32_t s = g->links; s; s &= s - 1) {
        int i = __builtin_ctz(s), to = tied[i];
        if (number[to] == LW_NONE)
            number[to] = n++;
        number[i] = number[to];
    }
    return n;
}

/* False when the expanded group has too many links. */
static bool expand(const lw_mechanism *m, const lw_assur_group *g, body *b)
{
    int number[LW_LINK_MAX];
    *b = (body){ .n = number_bodies(m, g, number) };
    for (uint64_t s = g->inner | g->outer; s; s &= s - 1) {
        int j = __builtin_ctzll(s), ends[2], n_end = 0;
        for (int side = 0; side < 2; side++)
            if (g->links >> m->link[j][side] & 1)
                ends[n_end++] = number[m->link[j][side]];
        bool second = lw_joint_freedoms(m->kind[j]) == 2;
        if (second && b->n == LW_LINK_MAX)
            return false;
        if (second)
            join_inside(b, ends[0], b->n);
        if (n_end == 2 && (second || ends[0] != ends[1]))
            join_inside(b, second ? b->n : ends[0], ends[1]);
        b->outer += n_end == 1;
        b->n += second;
    }
    return true;
}

static int class_of(const body *b)
{
    lw_chain_circuits c;
    int best = 2;
    if (b->n == 1)
        return 1;
    if (b->n == 2 || lw_circuit_basis(b->n, b->row, &c) != LW_OK)
        return b->n == 2 ? 2 : 0;
    for (int i = 0; i < b->n; i++)
        best = b->inner[i] > best ? b->inner[i] : best;
    for (int k = 0; k < c.n_circuit; k++)
        if (c.first[k + 1] - c.first[k] > best)
            best = c.first[k + 1] - c.first[k];
    return best;
}

/* ---- assembly modes ---------------------------------------------------------------------------- */

/* Baranov trusses by graph6 and the number of their assembly modes over the complex numbers, counted by
 * following the solutions of the loop equations around random loops in the space of dimensions
 * (monodromy) until no new one appeared; for 3, 5 and 7 links known since Innocenti and Rojas & Thomas 2011.
 * The numbers belong to the truss, whichever link is removed. */
static const struct { const char *truss; int n_mode; } known_modes[] = {
    { "Bw", 2 }, { "D]o", 6 }, { "FqLH_", 16 }, { "FFqb?", 14 }, { "F?o~_", 18 }, { "HQo_`S[", 44 },
    { "Hr`?XOS", 38 }, { "HLgG?lQ", 36 }, { "HEgORHa", 40 }, { "HKAhqGP", 44 }, { "HcQAHWq", 46 },
    { "HQeAHGq", 46 }, { "HqKC?kM", 50 }, { "HE?DRG{", 40 }, { "HCO{Q_b", 58 }, { "H]CSQGB", 40 },
    { "HSPEBaK", 54 }, { "H?{cIGR", 56 }, { "H?hcabo", 30 }, { "H?h\\Af?", 50 }, { "H@JEogK", 42 },
    { "HPFM?dG", 46 }, { "H??BvI[", 52 }, { "Hi??\\Wq", 42 }, { "H`XO[aO", 48 }, { "H_?B|aK", 54 },
    { "HY_Q[_W", 52 }, { "H?FPdPg", 50 }, { "H?AHv`S", 42 }, { "HIaqU?B", 48 }, { "Hai`cCo", 48 },
    { "HG@DKww", 48 }, { "HQBECpg", 48 },
};

/* The group with everything outside as one link.  False unless all joints are pins and the links fit. */
static bool truss_of(const lw_mechanism *m, const lw_assur_group *g, lw_chain *truss)
{
    int number[LW_LINK_MAX], n = number_bodies(m, g, number);
    if (n != __builtin_popcount(g->links) || lw_chain_clear(truss, n + 1) != LW_OK)
        return false;
    for (uint64_t s = g->inner | g->outer; s; s &= s - 1) {
        int j = __builtin_ctzll(s), a = number[m->link[j][0]], b = number[m->link[j][1]];
        a = a == LW_NONE ? n : a;
        b = b == LW_NONE ? n : b;
        if (!lw_joint_turns(m->kind[j]) || lw_chain_freedom(truss, a, b))
            return false;                             /* two pins to the same link: not in the table */
        lw_chain_join(truss, a, b, 1);
    }
    return true;
}

static bool same_assortment(const lw_chain *a, const lw_chain *b)
{
    int in_a[LW_LINK_MAX], in_b[LW_LINK_MAX];
    if (a->n_link != b->n_link)
        return false;
    lw_chain_assortment(a, in_a);
    lw_chain_assortment(b, in_b);
    return memcmp(in_a, in_b, sizeof in_a) == 0;
}

static int modes_of(const lw_mechanism *m, const lw_assur_group *g)
{
    lw_chain truss, form, known;
    int n_slider = 0;
    for (uint64_t s = g->inner | g->outer; s; s &= s - 1)
        n_slider += lw_joint_holds_rotation(m->kind[__builtin_ctzll(s)]);
    for (uint64_t s = g->inner | g->outer; s; s &= s - 1)
        if (is_driven(m, __builtin_ctzll(s)) || lw_joint_freedoms(m->kind[__builtin_ctzll(s)]) == 2)
            return 0;
    if (__builtin_popcount(g->links) == 2)            /* two circles, or a circle and a line, or two lines */
        return n_slider < 2 ? 2 : 1;
    if (n_slider > 0 || !truss_of(m, g, &truss) || lw_chain_canonical(&truss, &form) != LW_OK)
        return 0;
    for (size_t i = 0; i < sizeof known_modes/sizeof *known_modes; i++)
        if (lw_graph6_read(known_modes[i].truss, strlen(known_modes[i].truss), NULL, &known, NULL) == LW_OK
            && same_assortment(&known, &form) && lw_chain_canonical(&known, &known) == LW_OK
            && lw_chain_same(&known, &form))
            return known_modes[i].n_mode;
    return 0;
}

/* ---- decomposition ----------------------------------------------------------------------------- */

static void describe(const lw_mechanism *m, uint32_t solved, lw_assur_group *g)
{
    body b;
    for (int j = 0; j < m->n_joint; j++) {
        bool first = g->links >> m->link[j][0] & 1, second = g->links >> m->link[j][1] & 1;
        uint32_t ends = 1u << m->link[j][0] | 1u << m->link[j][1];
        if (first && second)
            g->inner |= (uint64_t)1 << j;
        else if ((first || second) && ends & solved)
            g->outer |= (uint64_t)1 << j;
    }
    g->order = __builtin_popcountll(g->outer);
    g->n_class = expand(m, g, &b) ? class_of(&b) : 0;
    g->n_mode = modes_of(m, g);
}

static lw_status check_inputs(const lw_mechanism *m, lw_error *e)
{
    lw_chain c;
    uint64_t driven = 0;
    lw_mechanism_chain(m, &c);
    for (int i = 0; i < m->n_input; i++)
        driven |= (uint64_t)1 << m->input[i];
    if (m->ground == LW_NONE)
        return lw_error_set(e, LW_E_ARG, "the mechanism has no ground link");
    if (m->n_input != lw_chain_mobility(&c))
        return lw_error_set(e, LW_E_ARG, "F = %d wants as many inputs, not %d", lw_chain_mobility(&c), m->n_input);
    if (!lw_mechanism_drives(m, driven))
        return lw_error_set(e, LW_E_ARG, "the inputs do not drive every link, or a part is overconstrained");
    return LW_OK;
}

lw_status lw_assur_decompose(const lw_mechanism *m, lw_assur *a, lw_error *e)
{
    ownership o;
    uint32_t reach[LW_LINK_MAX], solved, all = (uint32_t)(((uint64_t)1 << m->n_link) - 1);
    lw_status s = check_inputs(m, e);
    if (s != LW_OK)
        return s;
    if (!assign_owners(m, &o))
        return lw_error_set(e, LW_E_ARG, "a part of the mechanism is overconstrained");
    depend(&o, m->n_link, reach);
    *a = (lw_assur){ 0 };
    for (solved = 1u << m->ground; solved != all;)
        for (int i = 0; i < m->n_link; i++) {
            uint32_t links = 0;                       /* i, and the links that i depends on and that depend on i */
            if (solved >> i & 1)
                continue;
            for (uint32_t r = reach[i]; r; r &= r - 1)
                if (reach[__builtin_ctz(r)] >> i & 1)
                    links |= r & -r;
            if (reach[i] & ~links & ~solved)
                continue;
            lw_assur_group *g = &a->group[a->n_group++];
            *g = (lw_assur_group){ .links = links };
            describe(m, solved, g);
            solved |= links;
            break;
        }
    return LW_OK;
}

size_t lw_assur_print(const lw_mechanism *m, const lw_assur_group *g, char *buf, size_t size)
{
    static const char *const roman[] = { "?", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X" };
    lw_text t = lw_text_start(buf, size);
    if (g->n_class <= 10)
        lw_text_add(&t, "class %s, order %d: links", roman[g->n_class], g->order);
    else
        lw_text_add(&t, "class %d, order %d: links", g->n_class, g->order);
    for (uint32_t s = g->links; s; s &= s - 1)
        lw_text_add(&t, " %d", __builtin_ctz(s) + 1);
    lw_text_add(&t, ", joints");
    for (uint64_t s = g->inner | g->outer; s; s &= s - 1) {
        int j = __builtin_ctzll(s);
        lw_text_add(&t, " %d-%d:%c%s", m->link[j][0] + 1, m->link[j][1] + 1, m->kind[j], is_driven(m, j) ? "!" : "");
    }
    if (g->n_mode > 0)
        lw_text_add(&t, ", %d assembly modes", g->n_mode);
    return t.length;
}

/* ---- all groups -------------------------------------------------------------------------------- */

typedef struct listing { lw_assur_visit *visit; void *context; } listing;

static lw_status list_truss(void *context, const lw_chain_item *item)
{
    const listing *l = context;
    lw_mechanism m;
    uint8_t lowest[LW_LINK_MAX];
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    lw_chain_item_orbits(item, lowest);
    for (int i = 0; i < m.n_link && s == LW_OK; i++) {
        lw_assur_group g = { .links = lw_chain_links(item->chain) & ~(1u << i) };
        if (lowest[i] != i)
            continue;
        describe(&m, 1u << i, &g);
        s = l->visit(l->context, item->chain, i, &g);
    }
    return s;
}

static lw_status find_trusses(int n_link, int n_thread, lw_chains **trusses, lw_error *e)
{
    if (n_link < 2 || n_link % 2)
        return lw_error_set(e, LW_E_ARG, "an Assur group of pins has 3N/2 joints, so its number of links N is even, not %d", n_link);
    return lw_chains_create(n_link + 1, 0, n_thread, trusses, e);
}

lw_status lw_assur_count(int n_link, int n_thread, uint64_t *n, lw_error *e)
{
    lw_chains *trusses;
    lw_chain_table table;
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = n_thread;
    lw_status s = find_trusses(n_link, n_thread, &trusses, e);
    if (s != LW_OK)
        return s;
    s = lw_chains_count(trusses, &how, &table);
    *n = table.total.n_ground;
    lw_chain_table_free(&table);
    lw_chains_free(trusses);
    return s;
}

lw_status lw_assur_each(int n_link, int n_thread, lw_assur_visit *visit, void *context, lw_error *e)
{
    listing l = { visit, context };
    lw_chains *trusses;
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = n_thread;
    lw_status s = find_trusses(n_link, n_thread, &trusses, e);
    if (s != LW_OK)
        return s;
    s = lw_chains_each(trusses, &how, list_truss, &l);
    lw_chains_free(trusses);
    return s;
}

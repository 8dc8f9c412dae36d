/* Assur groups: smallest by brute force, the same whatever the numbering, and as many as published. */
#include "all_chains.h"
#include "check.h"
#include "enumerate/assur.h"
#include "enumerate/inputs.h"
#include "grammar/topology/edges.h"

static lw_assur decompose(const lw_mechanism *m)
{
    lw_assur a = { 0 };
    CHECK_SILENT(lw_assur_decompose(m, &a, &check_error));
    return a;
}

TEST(four_bar)
{
    static const char text[] = "1-2! 2-3 3-4 1-4 @1";
    lw_mechanism m;
    char line[200];
    lw_edges_read(text, strlen(text), NULL, &m, NULL);
    lw_assur a = decompose(&m);
    CHECK_INT(a.n_group, 2);
    CHECK_INT(a.group[0].n_class, 1);
    CHECK_INT(a.group[0].links, 2);
    CHECK_INT(a.group[1].n_class, 2);
    CHECK_INT(a.group[1].n_mode, 2);
    lw_assur_print(&m, &a.group[1], line, sizeof line);
    CHECK_TEXT(line, "class II, order 2: links 3 4, joints 1-4:r 2-3:r 3-4:r, 2 assembly modes");
    lw_assur_print(&m, &a.group[0], line, sizeof line);
    CHECK_TEXT(line, "class I, order 1: links 2, joints 1-2:r!");
}

/* Texts with groups that every book on the subject shows. */
TEST(known_mechanisms)
{
    static const struct { const char *text; int n_group, n_class, order, n_mode; } known[] = {
        { "1-2! 2-3 3-4 1-4 3-5 5-6 1-6 @1", 3, 2, 2, 2 },            /* Stephenson III: two dyads     */
        { "1-2! 2-3 3-4 1-4 3-5 5-6 4-6 @1", 3, 2, 2, 2 },            /* Watt I: two dyads             */
        { "1-2! 2-4 3-4 3-5 3-6 1-5 1-6 @1", 2, 3, 3, 6 },            /* the triad                     */
        { "1-2! 2-3 1-4 3-5 4-5 3-6 4-6 @1", 2, 4, 2, 6 },            /* a loop of four                */
        { "1-2! 2-3 3-4 3-5 3-6:t 1-4 @1", 0, 0, 0, 0 },              /* 5, 6 hang loose: refused      */
        { "1-2! 2-3 3-4 1-4 3-5 1-5 @1", 0, 0, 0, 0 },                /* F = 0: refused                */
        { "1-2! 2-3 3-4 3-5 3-6 1-4 1-5 @1", 0, 0, 0, 0 },
        { "1-2! 2-3 3-4:t 1-4 @1", 2, 2, 2, 2 },                      /* crank, inner slider           */
        { "1-2! 2-3:t 3-4 1-4:t @1", 2, 2, 2, 1 },                    /* two lines meet once           */
        { "1-2! 2-3 3-1:p @1", 2, 2, 2, 0 },                          /* one link with a slot: a dyad  */
        { "1-2 2-3! 3-4 1-4 @1", 1, 2, 2, 0 },                        /* driven coupler joint          */
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_mechanism m;
        lw_assur a;
        CHECK_OK(lw_edges_read(known[i].text, strlen(known[i].text), NULL, &m, &check_error));
        if (known[i].n_group == 0) {
            CHECK_INT(lw_assur_decompose(&m, &a, &check_error), LW_E_ARG);
            continue;
        }
        a = decompose(&m);
        lw_assur_group *last = &a.group[a.n_group - 1];
        CHECK_INT(a.n_group, known[i].n_group);
        CHECK_INT(last->n_class, known[i].n_class);
        CHECK_INT(last->order, known[i].order);
        CHECK_INT(last->n_mode, known[i].n_mode);
    }
}

/* ---- smallest, and no matter how numbered ------------------------------------------------------- */

/* Conditions among the links of `set` and to solved ones, minus freedoms: 0 when solvable. */
static int freedom_of(const lw_mechanism *m, uint32_t set, uint32_t solved)
{
    int f = 3*__builtin_popcount(set);
    for (int j = 0; j < m->n_joint; j++) {
        uint32_t ends = 1u << m->link[j][0] | 1u << m->link[j][1];
        if (ends & set && !(ends & ~(set | solved)))
            f -= memchr(m->input, j, (size_t)m->n_input) ? 3 : 3 - lw_joint_freedoms(m->kind[j]);
    }
    return f;
}

static void check_smallest(const lw_mechanism *m, const lw_assur *a)
{
    uint32_t solved = 1u << m->ground;
    for (int k = 0; k < a->n_group; k++) {
        uint32_t links = a->group[k].links;
        CHECK_INT(freedom_of(m, links, solved), 0);
        for (uint32_t part = (links - 1) & links; part; part = (part - 1) & links)
            CHECK(freedom_of(m, part, solved) > 0);
        CHECK((links & solved) == 0);
        solved |= links;
    }
    CHECK_INT(solved, (1u << m->n_link) - 1);
}

static bool has_group(const lw_assur *a, uint32_t links, int n_class, int n_mode)
{
    for (int k = 0; k < a->n_group; k++)
        if (a->group[k].links == links)
            return a->group[k].n_class == n_class && a->group[k].n_mode == n_mode;
    return false;
}

typedef struct tour { lw_rng rng; int dof, n_seen, of_class[16]; } tour;

static lw_status at_input(void *context, const lw_mechanism *m)
{
    tour *t = context;
    lw_assur a = decompose(m), b;
    lw_mechanism renamed;
    uint8_t to[LW_LINK_MAX];
    check_smallest(m, &a);
    random_permutation(&t->rng, m->n_link, to);
    lw_mechanism_relabel(m, to, &renamed);
    b = decompose(&renamed);
    CHECK_INT(a.n_group, b.n_group);
    for (int k = 0; k < a.n_group; k++) {
        uint32_t links = 0;
        for (uint32_t s = a.group[k].links; s; s &= s - 1)
            links |= 1u << to[__builtin_ctz(s)];
        CHECK(has_group(&b, links, a.group[k].n_class, a.group[k].n_mode));
        t->of_class[a.group[k].n_class & 15]++;
    }
    t->n_seen++;
    return LW_OK;
}

static lw_status at_ground(void *context, const lw_mechanism *m)
{
    return lw_inputs_each(m, ((tour *)context)->dof, false, at_input, context);
}

TEST(every_small_mechanism)
{
    static const struct { int n_link, dof; } known[] = { { 4, 1 }, { 6, 1 }, { 8, 1 }, { 5, 2 }, { 7, 2 } };
    tour t = { 0 };
    lw_rng_seed(&t.rng, check_seed(), 1);
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        chain_list all = all_chains(known[i].n_link, known[i].dof);
        t.dof = known[i].dof;
        for (int k = 0; k < all.n; k++) {
            lw_mechanism m;
            lw_mechanism_from_chain(&all.chain[k], &m);
            CHECK_INT(lw_grounds_each(&m, at_ground, &t), LW_OK);
        }
        free(all.chain);
    }
    CHECK(t.n_seen > 500 && t.of_class[0] == 0 && t.of_class[2] > 100 && t.of_class[3] > 100 && t.of_class[4] > 10);
}

/* ---- listing ------------------------------------------------------------------------------------ */

typedef struct listed { int n, of_class[16], with_modes; } listed;

static lw_status count_group(void *context, const lw_chain *truss, int lost, const lw_assur_group *g)
{
    listed *l = context;
    CHECK(!(g->links >> lost & 1));
    CHECK_INT(lw_chain_degree(truss, lost), g->order);
    CHECK_INT(__builtin_popcountll(g->inner) + __builtin_popcountll(g->outer), 3*__builtin_popcount(g->links)/2);
    l->n++;
    l->of_class[g->n_class]++;
    l->with_modes += g->n_mode > 0;
    return LW_OK;
}

/* Numbers: catalogues/data/published-counts.csv. */
TEST(all_groups)
{
    static const struct { int n_link, n; } known[] = { { 2, 1 }, { 4, 2 }, { 6, 10 }, { 8, 173 } };   /* the last is ours */
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        listed l = { 0 };
        uint64_t n = 0;
        CHECK_INT(lw_assur_each(known[i].n_link, 1, count_group, &l, NULL), LW_OK);
        CHECK_INT(lw_assur_count(known[i].n_link, 1, &n, NULL), LW_OK);
        CHECK_INT(n, known[i].n);
        CHECK_INT(l.n, known[i].n);
        CHECK_INT(l.with_modes, l.n);
        CHECK_INT(l.of_class[2], known[i].n_link == 2);
        if (known[i].n_link == 4)
            CHECK(l.of_class[3] == 1 && l.of_class[4] == 1);
    }
    CHECK_FAILS(lw_assur_each(3, 1, count_group, NULL, &check_error), LW_E_ARG, "even");
}

TEST(refusals)
{
    lw_chain c = ring_of(5);
    lw_mechanism m;
    lw_assur a;
    lw_mechanism_from_chain(&c, &m);
    CHECK_FAILS(lw_assur_decompose(&m, &a, &check_error), LW_E_ARG, "no ground");
    m.ground = 0;
    m.n_input = 1;
    CHECK_FAILS(lw_assur_decompose(&m, &a, &check_error), LW_E_ARG, "F = 2 wants as many inputs, not 1");
}

/* Coverage of the published grammar: forwards and backwards give the numbers of docs/theory.md. */
#include "all_chains.h"
#include "check.h"
#include "enumerate/derive.h"
#include "grammar/topology/growth.h"

static lw_status count_one(void *context, const lw_mechanism *m)
{
    (void)m;
    ++*(int *)context;
    return LW_OK;
}

static int reached(int n_link, const char *rules, const char *kinds, bool regions)
{
    lw_derive how = lw_derive_default(n_link);
    int n = 0;
    for (int r = 1; r <= 4; r++)
        how.rule[r] = strchr(rules, '0' + r) != NULL;
    how.kinds = kinds;
    how.regions = regions;
    CHECK_INT(lw_derive_each(&how, count_one, &n), LW_OK);
    return n;
}

/* Chains with pins only: theory, section "The published grammar". */
static const struct { int n_link, n_chain, n_planar, n_reached, by_regions; } known[] = {
    { 4, 1, 1, 1, 1 }, { 6, 2, 2, 2, 2 }, { 8, 16, 16, 12, 12 }, { 10, 230, 219, 140, 136 },
    { 12, 6856, 5918, 3110, 2781 },
};

TEST(coverage_backwards)
{
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_coverage c;
        CHECK_INT(lw_coverage_count(known[i].n_link, 1, NULL, &c, NULL), LW_OK);
        CHECK_INT(c.n_chain, known[i].n_chain);
        CHECK_INT(c.n_planar, known[i].n_planar);
        CHECK_INT(c.n_reached, known[i].n_reached);
        CHECK_INT(c.n_reached_by_regions, known[i].by_regions);
    }
    lw_error e = { 0 };
    lw_coverage c;
    CHECK_INT(lw_coverage_count(7, 1, NULL, &c, &e), LW_E_ARG);
    CHECK(e.text[0] != '\0');
}

TEST(coverage_forwards)
{
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        CHECK_INT(reached(known[i].n_link, "24", "r", false), known[i].n_reached);
        CHECK_INT(reached(known[i].n_link, "24", "r", true), known[i].by_regions);
    }
}

/* With all rules and kinds: everything reached is found to be reached, and of the labelled chains
 * nothing else is.  The other way round by all labellings of all chains with six links, and by kinds r, t, p
 * of rings. */
static lw_status check_reached(void *context, const lw_mechanism *m)
{
    lw_growth g;
    lw_reach reach;
    CHECK_INT(lw_growth_find(m, &g, &reach, NULL, NULL), LW_OK);
    CHECK_INT(reach, LW_REACHED);
    ++*(int *)context;
    return LW_OK;
}

TEST(all_rules)
{
    for (int n = 3; n <= 6; n++) {
        lw_derive how = lw_derive_default(n);
        int forwards = 0;
        how.kinds = "rt";
        CHECK_INT(lw_derive_each(&how, check_reached, &forwards), LW_OK);
        CHECK(forwards > 0);
    }
    CHECK_INT(reached(3, "1234", "r", true), 1);
    CHECK_INT(reached(3, "1234", "rt", true), 3);              /* k k p read either way: rr, rt, tt */
    CHECK_INT(reached(4, "2", "rt", true), 6);                 /* necklaces of four that may turn over */
    CHECK_INT(reached(4, "13", "r", true), 3);                 /* X, Y = 1,2 or 2,1 or 1,3 */
}

typedef struct labels { int n_reached; } labels;

static lw_status label_reached(void *context, const lw_mechanism *m)
{
    lw_growth g;
    lw_reach reach;
    CHECK_INT(lw_growth_find(m, &g, &reach, NULL, NULL), LW_OK);
    ((labels *)context)->n_reached += reach == LW_REACHED;
    return LW_OK;
}

static lw_status label_void(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints)
{
    (void)reason;
    (void)joints;
    return label_reached(context, m);
}

TEST(every_labelling_backwards)
{
    for (int n_link = 4; n_link <= 8; n_link += 2) {
        chain_list all = all_chains(n_link, 1);
        labels l = { 0 };
        for (int i = 0; i < all.n; i++) {
            lw_mechanism m;
            lw_mechanism_from_chain(&all.chain[i], &m);
            CHECK_INT(lw_kinds_each(&m, "rt", label_reached, label_void, &l), LW_OK);
        }
        CHECK_INT(reached(n_link, "24", "rt", true), l.n_reached);
        free(all.chain);
    }
}

TEST(refusals)
{
    lw_derive how = lw_derive_default(0);
    CHECK_INT(lw_derive_each(&how, count_one, NULL), LW_E_ARG);
    how = lw_derive_default(4);
    how.kinds = "rp";
    CHECK_INT(lw_derive_each(&how, count_one, NULL), LW_E_ARG);
    how.kinds = "rr";
    CHECK_INT(lw_derive_each(&how, count_one, NULL), LW_E_ARG);
}

/* Steps together: the numbers do not depend on which step comes first, and agree with single steps. */
#include "check.h"
#include "all_chains.h"
#include "enumerate/mechanisms.h"

typedef struct seen { uint64_t n, n_void; } seen;

static lw_status note(void *context, const lw_mechanism *m)
{
    (void)m;
    ((seen *)context)->n++;
    return LW_OK;
}

static lw_status note_void(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints)
{
    (void)m;
    CHECK(reason != LW_VOID_NOT && joints != 0);
    ((seen *)context)->n_void++;
    return LW_OK;
}

static lw_mechanism_counts run(int n_link, int dof, const lw_mechanism_steps *steps, seen *s)
{
    chain_list all = all_chains(n_link, dof);
    lw_mechanism_counts counts = { 0 };
    for (int i = 0; i < all.n; i++) {
        lw_mechanism m;
        lw_mechanism_from_chain(&all.chain[i], &m);
        CHECK_INT(lw_mechanisms_each(&m, steps, &counts, note, note_void, s), LW_OK);
    }
    free(all.chain);
    return counts;
}

TEST(published_numbers)
{
    lw_mechanism_steps steps = { .ground = true };
    seen s = { 0 };
    lw_mechanism_counts c = run(8, 1, &steps, &s);
    CHECK_INT(c.n_chain, 16);
    CHECK_INT(c.n_ground, 71);
    CHECK_INT(s.n, 71);
    steps.kinds = "rt";                              /* data: 234 inversions of six-link chains with r, t */
    s = (seen){ 0 };
    c = run(6, 1, &steps, &s);
    CHECK_INT(c.n_labelled, 234);
    CHECK_INT(s.n, 234);
    CHECK_INT(s.n_void, c.n_void[1] + c.n_void[2] + c.n_void[3] + c.n_void[4]);
}

/* Labelled first and then grounded, by hand, as against ground first. */
static lw_status then_ground(void *context, const lw_mechanism *m)
{
    lw_mechanism_steps steps = { .ground = true };
    lw_mechanism_counts counts = { 0 };
    steps.input = LW_INPUT_ANY;
    steps.output = true;
    return lw_mechanisms_each(m, &steps, &counts, note, NULL, context);
}

TEST(order_of_steps_does_not_matter)
{
    static const struct { int n_link, dof; } known[] = { { 4, 1 }, { 6, 1 }, { 5, 2 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_mechanism_steps steps = { true, "rt", LW_INPUT_ANY, true, false, false };
        seen first = { 0 }, second = { 0 };
        lw_mechanism_counts c = run(known[i].n_link, known[i].dof, &steps, &first);
        chain_list all = all_chains(known[i].n_link, known[i].dof);
        for (int k = 0; k < all.n; k++) {
            lw_mechanism m;
            lw_mechanism_from_chain(&all.chain[k], &m);
            CHECK_INT(lw_kinds_each(&m, "rt", then_ground, NULL, &second), LW_OK);
        }
        free(all.chain);
        CHECK_INT(first.n, second.n);
        CHECK_INT(c.n_output, first.n);
        CHECK(c.n_output > c.n_driven && c.n_driven > c.n_labelled && c.n_labelled > c.n_ground);
    }
}

TEST(steps_left_out)
{
    lw_mechanism_steps none = { 0 }, bad = { .output = true };
    seen s = { 0 };
    lw_mechanism_counts c = run(6, 1, &none, &s);
    CHECK_INT(s.n, 2);
    CHECK_INT(c.n_ground, 0);
    lw_chain four = ring_of(4);
    lw_mechanism m;
    lw_mechanism_from_chain(&four, &m);
    CHECK_INT(lw_mechanisms_each(&m, &bad, &c, NULL, NULL, NULL), LW_E_ARG);
    bad = (lw_mechanism_steps){ .input = LW_INPUT_GROUND };
    CHECK_INT(lw_mechanisms_each(&m, &bad, &c, NULL, NULL, NULL), LW_E_ARG);
}

/* A sketch has the mechanism's topology, and a plan can be made from it. */
#include "enumerate/chains.h"
#include "enumerate/mechanisms.h"
#include "grammar/linkage/sketch.h"
#include "tests/check.h"

static lw_rng rng;
static int n_seen;

static lw_status sketch(void *context, const lw_mechanism *m)
{
    lw_linkage k;
    lw_error e = { .text = "" };
    (void)context;
    n_seen++;
    CHECK_INT(lw_linkage_sketch(m, &rng, &k), LW_OK);
    CHECK_INT(lw_linkage_check(&k, &e), LW_OK);
    CHECK_INT(lw_linkage_mobility(&k), 1);
    CHECK_INT(k.tracer[0].link, m->output);
    CHECK_INT(k.input[0].joint, m->input[0]);
    for (int j = 0; j < m->n_joint; j++) {
        CHECK_INT(k.joint[j].kind, m->kind[j]);
        CHECK(k.joint[j].link[0] + k.joint[j].link[1] == m->link[j][0] + m->link[j][1]);
        CHECK(k.joint[j].link[1] != m->ground);
    }
    return LW_OK;
}

static lw_status each_chain(void *context, const lw_chain_item *item)
{
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    lw_mechanism_steps steps = { .ground = true, .kinds = "rt", .input = LW_INPUT_GROUND, .output = true };
    CHECK_INT(lw_mechanism_from_chain(item->chain, &m), LW_OK);
    return lw_mechanisms_each(&m, &steps, &counts, sketch, NULL, context);
}

TEST(six_link_mechanisms)
{
    lw_chains *all;
    lw_chain_walk how = lw_chain_walk_default();
    lw_rng_seed(&rng, check_seed(), 1);
    CHECK_INT(lw_chains_create(6, 1, 1, &all, NULL), LW_OK);
    CHECK_INT(lw_chains_each(all, &how, each_chain, NULL), LW_OK);
    CHECK(n_seen > 1000);
    lw_chains_free(all);
}

TEST(a_ground_and_an_output_are_needed)
{
    lw_mechanism m;
    lw_linkage k;
    CHECK_INT(lw_mechanism_clear(&m, 2), LW_OK);
    CHECK_INT(lw_mechanism_join(&m, 0, 1, 'r'), LW_OK);
    CHECK_INT(lw_linkage_sketch(&m, &rng, &k), LW_E_ARG);
    m.ground = 0;
    CHECK_INT(lw_linkage_sketch(&m, &rng, &k), LW_E_ARG);
    m.output = 1;
    CHECK_INT(lw_linkage_sketch(&m, &rng, &k), LW_OK);
}

/* Labellings with r and t against catalogues/data/published-counts.csv (family R/P labelled, one method
 * there) and Burnside's lemma; canonical forms of mechanisms. */
#include "check.h"
#include "all_chains.h"
#include "enumerate/inputs.h"
#include "enumerate/symmetry.h"

typedef struct count { int n_valid, n_void, n_ground, with_t[LW_JOINT_MAX + 1]; int reason[5]; } count;

static lw_status count_ground(void *context, const lw_mechanism *m)
{
    (void)m;
    ((count *)context)->n_ground++;
    return LW_OK;
}

static lw_status count_valid(void *context, const lw_mechanism *m)
{
    count *c = context;
    int t = 0;
    for (int j = 0; j < m->n_joint; j++)
        t += m->kind[j] == 't';
    c->n_valid++;
    c->with_t[t]++;
    return lw_grounds_each(m, count_ground, context);
}

static lw_status count_void(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints)
{
    count *c = context;
    CHECK(joints != 0 && joints >> m->n_joint == 0);
    c->n_void++;
    c->reason[reason]++;
    return LW_OK;
}

static count count_all(int n_link, int dof)
{
    chain_list all = all_chains(n_link, dof);
    count c = { 0 };
    for (int i = 0; i < all.n; i++) {
        lw_mechanism m;
        lw_mechanism_from_chain(&all.chain[i], &m);
        CHECK_INT(lw_kinds_each(&m, "rt", count_valid, count_void, &c), LW_OK);
    }
    free(all.chain);
    return c;
}

/* Four and six links: the data.  Eight: ours; test_freedom.c compares all of them with the rank. */
TEST(sliders_in_small_chains)
{
    static const struct { int n_link, n_valid, n_raw, n_ground, with_t[6]; } known[] = {
        { 4, 4, 6, 7, { 1, 1, 2 } },
        { 6, 52, 96, 234, { 2, 6, 16, 19, 9 } },
        { 8, 3107, 7185, 0, { 0 } },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        count c = count_all(known[i].n_link, 1);
        CHECK_INT(c.n_valid, known[i].n_valid);
        CHECK_INT(c.n_valid + c.n_void, known[i].n_raw);
        if (known[i].n_ground == 0)
            continue;
        CHECK_INT(c.n_ground, known[i].n_ground);
        for (int t = 0; t < 6; t++)
            CHECK_INT(c.with_t[t], known[i].with_t[t]);
    }
}

/* All labellings, void or not, by Burnside's lemma: 2^cycles averaged over the group. */
TEST(raw_number_by_burnside)
{
    for (int n_link = 4; n_link <= 8; n_link += 2) {
        chain_list all = all_chains(n_link, 1);
        count c = count_all(n_link, 1);
        double want = 0;
        for (int i = 0; i < all.n; i++) {
            lw_mechanism m;
            lw_symmetry s;
            double sum = 0;
            lw_mechanism_from_chain(&all.chain[i], &m);
            lw_symmetry_of(&m, false, &s);
            for (size_t k = 0; k < s.n; k++) {
                uint64_t seen = 0;
                int cycles = 0;
                for (int j = 0; j < m.n_joint; j++) {
                    cycles += !(seen >> j & 1);
                    for (int at = j; !(seen >> at & 1); at = s.joint[k][at])
                        seen |= (uint64_t)1 << at;
                }
                sum += ldexp(1, cycles);
            }
            want += sum/(double)s.n;
            lw_symmetry_free(&s);
        }
        CHECK_NEAR(c.n_valid + c.n_void, want, 0.5, 0);
        free(all.chain);
    }
}

/* Isomorphic mechanisms, and no others, have the same form: shuffled copies do. */
TEST(forms)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 1);
    for (int trial = 0; trial < 500; trial++) {
        lw_mechanism m = random_topology(&rng, 3 + trial % 8, trial % 6, "rtpg"), other, a, b;
        uint8_t to[LW_LINK_MAX];
        m.ground = trial % 3 ? 0 : LW_NONE;
        m.output = trial % 2 ? 1 : LW_NONE;
        m.n_input = lw_joint_freedoms(m.kind[0]) == 1;
        random_permutation(&rng, m.n_link, to);
        lw_mechanism_relabel(&m, to, &other);
        CHECK_INT(lw_mechanism_canonical(&m, &a), LW_OK);
        CHECK_INT(lw_mechanism_canonical(&other, &b), LW_OK);
        CHECK(lw_mechanism_same(&a, &b));
        other.kind[0] = other.kind[0] == 'p' ? 'g' : 'p';
        other.n_input = 0;
        lw_mechanism_canonical(&other, &b);
        CHECK(!lw_mechanism_same(&a, &b));
    }
}

static lw_status stop_at_once(void *context, const lw_mechanism *m)
{
    (void)context;
    (void)m;
    return LW_STOPPED;
}

TEST(refusals)
{
    lw_chain c = ring_of(4);
    lw_mechanism m;
    lw_mechanism_from_chain(&c, &m);
    CHECK_INT(lw_kinds_each(&m, "rx", count_valid, NULL, NULL), LW_E_ARG);
    CHECK_INT(lw_kinds_each(&m, "rr", count_valid, NULL, NULL), LW_E_ARG);
    CHECK_INT(lw_kinds_each(&m, "pg", count_valid, NULL, NULL), LW_E_ARG);
    CHECK_INT(lw_kinds_each(&m, "rt", stop_at_once, NULL, NULL), LW_STOPPED);
}

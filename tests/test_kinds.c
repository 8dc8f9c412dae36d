/* Labellings with r and t against catalogues/data/published-counts.csv (family R/P labelled, one method
 * there) and Burnside's lemma; canonical forms of mechanisms. */
#include "check.h"
#include "all_chains.h"
#include "enumerate/mechanisms.h"
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

static count count_all(int n_link, int dof, bool directed)
{
    chain_list all = all_chains(n_link, dof);
    count c = { 0 };
    for (int i = 0; i < all.n; i++) {
        lw_mechanism m;
        lw_mechanism_from_chain(&all.chain[i], &m);
        m.directed = directed;
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
        count c = count_all(known[i].n_link, 1, false);
        CHECK_INT(c.n_valid, known[i].n_valid);
        CHECK_INT(c.n_valid + c.n_void, known[i].n_raw);
        if (known[i].n_ground == 0)
            continue;
        CHECK_INT(c.n_ground, known[i].n_ground);
        for (int t = 0; t < 6; t++)
            CHECK_INT(c.with_t[t], known[i].with_t[t]);
    }
}

/* The slider-crank: textbooks count four inversions, because the guide may be on either link of the slider; without
 * directions there are two. */
static lw_status count_slider_crank(void *context, const lw_mechanism *m)
{
    int n = 0;
    for (int j = 0; j < m->n_joint; j++)
        n += m->kind[j] == 't';
    *(int *)context += n == 1;
    return LW_OK;
}

TEST(directions_and_cams)
{
    for (int directed = 0; directed < 2; directed++) {
        lw_mechanism_steps steps = { .ground = true, .kinds = "rt", .slider_direction = directed };
        lw_mechanism_counts c = { 0 };
        lw_mechanism m;
        lw_chain chain = ring_of(4);
        int n = 0;
        lw_mechanism_from_chain(&chain, &m);
        CHECK_INT(lw_mechanisms_each(&m, &steps, &c, count_slider_crank, NULL, &n), LW_OK);
        CHECK_INT(n, directed ? 4 : 2);
    }
    for (int cams = 0; cams < 2; cams++) {                  /* cam and follower at a frame: turning or sliding each */
        lw_mechanism_steps steps = { .kinds = "rtg", .translating_cams = cams };
        lw_mechanism_counts c = { 0 };
        lw_mechanism m;
        lw_mechanism_clear(&m, 3);
        lw_mechanism_join(&m, 0, 1, 'r');
        lw_mechanism_join(&m, 0, 2, 'r');
        lw_mechanism_join(&m, 1, 2, 'g');
        CHECK_INT(lw_mechanisms_each(&m, &steps, &c, NULL, NULL, NULL), LW_OK);
        CHECK_INT(c.n_labelled, cams ? 3 : 2);
    }
}

/* All labellings, void or not, by Burnside's lemma.  A cycle of joints under a symmetry has all the same kind: 2 ways.
 * Sliders with directions have 2 more unless the symmetry reverses a slider when it has gone once around the cycle. */
TEST(raw_number_by_burnside)
{
    for (int n_case = 0; n_case < 5; n_case++) {
        bool directed = n_case > 2;
        int n_link = directed ? 2*n_case - 2 : 2*n_case + 4;
        chain_list all = all_chains(n_link, 1);
        count c = count_all(n_link, 1, directed);
        double want = 0;
        for (int i = 0; i < all.n; i++) {
            lw_mechanism m;
            OWN(lw_symmetry) s = { 0 };
            double sum = 0;
            lw_mechanism_from_chain(&all.chain[i], &m);
            lw_symmetry_of(&m, false, &s);
            for (size_t k = 0; k < s.n; k++) {
                uint64_t seen = 0;
                double ways = 1;
                for (int j = 0; j < m.n_joint; j++) {
                    int from = m.link[j][0];
                    if (seen >> j & 1)
                        continue;
                    for (int at = j; !(seen >> at & 1); at = s.joint[k][at], from = s.link[k][from])
                        seen |= (uint64_t)1 << at;
                    ways *= !directed ? 2 : from == m.link[j][0] ? 3 : 1;
                }
                sum += ways;
            }
            want += sum/(double)s.n;
        }
        CHECK_NEAR(c.n_valid + c.n_void, want, 0.5, 0);
        free(all.chain);
    }
}

/* Isomorphic mechanisms, and no others, have the same form: shuffled copies do. */
TEST(forms)
{
    lw_rng rng = check_rng(1);
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

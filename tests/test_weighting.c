/* test_weighting.c - chains as weightings of structures: the critical sets against all circle sets, chains of
 * a structure against all distributions of binary links checked by the pebble game, symmetry against the canonical
 * form of the chains. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/critical.h"
#include "enumerate/invert.h"
#include "enumerate/structures.h"
#include "enumerate/synthesis.h"
#include "enumerate/canon.h"
#include "enumerate/weighting.h"
#include "tests/check.h"

static lw_structures *structures(int loops)
{
    lw_structures *set = NULL;
    CHECK_INT(lw_structures_create(loops, 1, &set), LW_OK);
    return set;
}

/* ---- all distributions, the slow way ------------------------------------------------------------- */

typedef struct collection { lw_chain form[1024]; size_t n; size_t n_ground; } collection;

static bool is_new(collection *c, const lw_chain *chain)
{
    lw_chain form;
    CHECK_INT(lw_chain_canonical(chain, &form), LW_OK);
    for (size_t k = 0; k < c->n; k++)
        if (lw_chain_same(&c->form[k], &form))
            return false;
    if (c->n < 1024)
        c->form[c->n++] = form;
    return true;
}

/* Give `left` binary links to lines e .. in every way; keep chains without rigid subchain. */
static void distribute(collection *c, const lw_structure *s, int e, int left, uint8_t *weight, bool truss)
{
    lw_chain chain;
    if (e < s->n_line - 1) {
        for (int n = 0; n <= left; n++) {
            weight[e] = (uint8_t)n;
            distribute(c, s, e + 1, left - n, weight, truss);
        }
        return;
    }
    weight[e] = (uint8_t)left;
    if (lw_structure_chain(s, weight, &chain) != LW_OK || lw_chain_rigid(&chain, truss, NULL) || !is_new(c, &chain))
        return;
    int n_class;
    uint8_t lowest[LW_LINK_MAX];
    CHECK_INT(lw_chain_orbits(&chain, lowest, &n_class), LW_OK);
    c->n_ground += (size_t)n_class;
}

/* One chain of the listing: sound, no image of an earlier one, orbits as the general way finds them. */
typedef struct checking { collection seen; const lw_weighting *w; uint8_t before[LW_LINE_MAX]; } checking;

static lw_status check_chain(void *context, const uint8_t *weight)
{
    checking *k = context;
    const lw_structure *s = lw_weighting_structure(k->w);
    lw_chain chain;
    uint8_t lowest[LW_LINK_MAX], want[LW_LINK_MAX];
    int n_class;
    CHECK_INT(lw_structure_chain(s, weight, &chain), LW_OK);
    CHECK(is_new(&k->seen, &chain));
    CHECK(k->seen.n == 1 || memcmp(k->before, weight, s->n_line) > 0);
    memcpy(k->before, weight, s->n_line);
    CHECK_INT(lw_chain_orbits(&chain, want, &n_class), LW_OK);
    CHECK_INT(lw_weighting_orbits(k->w, weight, lowest), n_class);
    CHECK(memcmp(lowest, want, (size_t)chain.n_link) == 0);
    k->seen.n_ground += (size_t)n_class;
    return LW_OK;
}

TEST(agrees_with_all_distributions)
{
    static const int most_dof[] = { [2] = LW_DOF_MAX, [3] = 7, [4] = 2 };
    static collection brute;
    static checking listed;
    lw_structures *set = structures(4);
    lw_weighting *w = lw_weighting_create();
    for (int loops = 2; loops <= 4; loops++)
        for (int dof = 0; dof <= most_dof[loops]; dof++)
            for (size_t k = 0; k < lw_structures_count(set, loops); k++) {
                lw_structure s;
                uint8_t weight[LW_LINE_MAX];
                lw_tally tally;
                lw_structures_get(set, loops, k, &s);
                brute.n = brute.n_ground = listed.seen.n = listed.seen.n_ground = 0;
                distribute(&brute, &s, 0, dof + 3 + 2*s.n_line - 3*s.n_circle, weight, dof == 0);
                CHECK_INT(lw_weighting_prepare(w, &s, dof), LW_OK);
                listed.w = w;
                CHECK_INT(lw_weighting_each(w, check_chain, &listed), LW_OK);
                CHECK_INT(lw_weighting_count(w, &tally), LW_OK);
                CHECK_INT(listed.seen.n, brute.n);
                CHECK_INT(listed.seen.n_ground, brute.n_ground);
                CHECK_INT(tally.n_chain, brute.n);
                CHECK_INT(tally.n_ground, brute.n_ground);
            }
    lw_weighting_free(w);
    lw_structures_free(set);
}

/* ---- counting against listing on larger structures ------------------------------------------------ */

typedef struct sum { const lw_weighting *w; uint64_t n_chain, n_ground; } sum;

static lw_status add_chain(void *context, const uint8_t *weight)
{
    sum *s = context;
    uint8_t lowest[LW_LINK_MAX];
    s->n_chain++;
    s->n_ground += (uint64_t)lw_weighting_orbits(s->w, weight, lowest);
    return LW_OK;
}

TEST(counting_agrees_with_listing)
{
    lw_structures *set = structures(6);
    lw_weighting *w = lw_weighting_create();
    for (int loops = 5; loops <= 6; loops++)
        for (int dof = 0; dof <= (loops == 6 ? 1 : 4); dof++)
            for (size_t k = 0; k < lw_structures_count(set, loops); k++) {
                lw_structure s;
                lw_tally tally;
                lw_structures_get(set, loops, k, &s);
                CHECK_INT(lw_weighting_prepare(w, &s, dof), LW_OK);
                sum listed = { .w = w };
                CHECK_INT(lw_weighting_each(w, add_chain, &listed), LW_OK);
                CHECK_INT(lw_weighting_count(w, &tally), LW_OK);
                CHECK_INT(tally.n_chain, listed.n_chain);
                CHECK_INT(tally.n_ground, listed.n_ground);
            }
    lw_weighting_free(w);
    lw_structures_free(set);
}

/* ---- critical sets -------------------------------------------------------------------------------- */

static int lines_inside(const lw_structure *s, uint32_t circles, const uint8_t *copies)
{
    int n = 0;
    for (int e = 0; e < s->n_line; e++)
        if (circles >> s->end[e][0] & circles >> s->end[e][1] & 1)
            n += copies ? copies[e] : 1;
    return n;
}

/* The sets kept decide as all sets of two or more circles do, whatever the copies. */
TEST(critical_sets_decide_for_all_sets)
{
    lw_structures *set = structures(5);
    lw_critical_list list = { 0 };
    uint64_t random = check_seed();
    for (int loops = 2; loops <= 5; loops++)
        for (size_t k = 0; k < lw_structures_count(set, loops); k++) {
            lw_structure s;
            lw_structures_get(set, loops, k, &s);
            CHECK_INT(lw_critical_sets(&s, true, &list), LW_OK);
            for (int trial = 0; trial < 50; trial++) {
                uint8_t copies[LW_LINE_MAX];
                for (int e = 0; e < s.n_line; e++) {
                    random = random*6364136223846793005u + 1442695040888963407u;
                    copies[e] = (uint8_t)((random >> 60)/6);                  /* 0, 1, 2 */
                }
                bool all_fit = true, critical_fit = true;
                for (uint32_t circles = 3; circles < (uint32_t)1 << s.n_circle; circles++)
                    if (circles & (circles - 1))
                        all_fit = all_fit && lines_inside(&s, circles, copies) <= 3*__builtin_popcount(circles) - 4;
                for (int c = 0; c < list.n; c++)
                    critical_fit = critical_fit && lines_inside(&s, list.set[c].circles, copies) <= list.set[c].room;
                CHECK_INT(critical_fit, all_fit);
            }
            for (int c = 0; c < list.n; c++) {
                const lw_critical *t = &list.set[c];
                CHECK_INT(__builtin_popcountll(t->lines), lines_inside(&s, t->circles, NULL));
                CHECK_INT(t->need, 2*__builtin_popcountll(t->lines) - t->room);
                CHECK(t->need > 0);
            }
        }
    free(list.set);
    lw_structures_free(set);
}

static lw_status stop_at_second(void *context, const uint8_t *weight)
{
    (void)weight;
    return ++*(int *)context == 2 ? LW_STOPPED : LW_OK;
}

TEST(limits)
{
    lw_weighting *w = lw_weighting_create();
    lw_structure s = lw_structure_theta();
    int n = 0;
    CHECK_INT(lw_weighting_prepare(w, &s, -1), LW_E_ARG);
    CHECK_INT(lw_weighting_prepare(w, &s, LW_DOF_MAX + 1), LW_E_ARG);
    CHECK_INT(lw_weighting_prepare(w, &s, LW_DOF_MAX), LW_OK);
    CHECK_INT(lw_weighting_each(w, stop_at_second, &n), LW_STOPPED);
    CHECK_INT(n, 2);
    lw_weighting_free(w);
    lw_weighting_free(NULL);
}

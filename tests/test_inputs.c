/* Ground, inputs, output: numbers of ways by steps against all choices made at once and told apart by
 * canonical form, in small cases; published numbers of ground choices. */
#include "check.h"
#include "all_chains.h"
#include "enumerate/inputs.h"
#include "enumerate/symmetry.h"

/* ---- by steps ---------------------------------------------------------------------------------- */

typedef struct steps { int n_input, n_ground, n_driven, n_output; bool at_ground; } steps;

static lw_status at_output(void *context, const lw_mechanism *m)
{
    CHECK(m->output != m->ground);
    ((steps *)context)->n_output++;
    return LW_OK;
}

static lw_status at_input(void *context, const lw_mechanism *m)
{
    ((steps *)context)->n_driven++;
    return lw_outputs_each(m, at_output, context);
}

static lw_status at_ground(void *context, const lw_mechanism *m)
{
    steps *s = context;
    s->n_ground++;
    return lw_inputs_each(m, s->n_input, s->at_ground, at_input, context);
}

static steps by_steps(const lw_chain *c, int n_input, bool only_ground)
{
    steps s = { .n_input = n_input, .at_ground = only_ground };
    lw_mechanism m;
    lw_mechanism_from_chain(c, &m);
    CHECK_INT(lw_grounds_each(&m, at_ground, &s), LW_OK);
    return s;
}

/* ---- all at once ------------------------------------------------------------------------------- */

/* Does driving hold by counting: with the driven joints rigid, no subchain has F < 0? */
static bool drives_by_count(const lw_chain *c, const lw_mechanism *m, uint64_t set)
{
    for (uint32_t links = 1; links < 1u << c->n_link; links++) {
        int f = lw_chain_mobility_of(c, links);
        for (uint64_t left = set; left; left &= left - 1) {
            int j = __builtin_ctzll(left);
            f -= (links >> m->link[j][0] & 1) && (links >> m->link[j][1] & 1);
        }
        if (f < 0)
            return false;
    }
    return true;
}

static int by_mechanism(const void *a, const void *b) { return memcmp(a, b, sizeof(lw_mechanism)); }

static int at_once(const lw_chain *c, int n_input, bool only_ground)
{
    static lw_mechanism form[40000];
    int n = 0, n_different = 0;
    lw_mechanism m, full;
    lw_mechanism_from_chain(c, &m);
    for (uint64_t set = 1; set < (uint64_t)1 << m.n_joint; set++)
        for (int g = 0; g < m.n_link; g++)
            for (int o = 0; o < m.n_link; o++) {
                uint32_t barred = 1u << g;
                bool fits = __builtin_popcountll(set) == n_input;
                full = m;
                full.ground = g;
                full.output = o;
                for (uint64_t left = set; left && fits; left &= left - 1) {
                    int j = __builtin_ctzll(left);
                    bool touches = m.link[j][0] == g || m.link[j][1] == g;
                    fits = touches || !only_ground;
                    barred |= touches ? 1u << m.link[j][0] | 1u << m.link[j][1] : 0;
                    full.input[full.n_input++] = (uint8_t)j;
                }
                if (!fits || barred >> o & 1 || !drives_by_count(c, &m, set))
                    continue;
                memset(&form[n], 0, sizeof *form);
                lw_mechanism_canonical(&full, &form[n++]);
            }
    qsort(form, (size_t)n, sizeof *form, by_mechanism);
    for (int i = 0; i < n; i++)
        n_different += i == 0 || by_mechanism(&form[i - 1], &form[i]) != 0;
    return n_different;
}

TEST(steps_against_all_at_once)
{
    static const struct { int n_link, dof; } known[] = { { 4, 1 }, { 6, 1 }, { 5, 2 }, { 7, 2 }, { 6, 3 } };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++)
        for (int only_ground = 0; only_ground < 2; only_ground++) {
            chain_list all = all_chains(known[i].n_link, known[i].dof);
            for (int k = 0; k < all.n; k++)
                CHECK_INT(by_steps(&all.chain[k], known[i].dof, only_ground).n_output, at_once(&all.chain[k], known[i].dof, only_ground));
            free(all.chain);
        }
}

/* Four-bar: one ground, one crank, coupler or follower; or the crank anywhere. */
TEST(four_bar)
{
    lw_chain c = ring_of(4);
    steps s = by_steps(&c, 1, true);
    CHECK_INT(s.n_ground, 1);
    CHECK_INT(s.n_driven, 1);
    CHECK_INT(s.n_output, 2);
    s = by_steps(&c, 1, false);
    CHECK_INT(s.n_driven, 2);
    CHECK_INT(s.n_output, 5);
}

/* Ground links up to symmetry: catalogues/data/published-counts.csv. */
TEST(grounds_of_all_chains)
{
    static const struct { int n_link, dof, n_ground; } known[] = {
        { 4, 1, 1 }, { 6, 1, 5 }, { 8, 1, 71 }, { 10, 1, 1834 }, { 5, 2, 1 }, { 7, 2, 11 }, { 9, 2, 220 },
        { 8, 3, 18 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        chain_list all = all_chains(known[i].n_link, known[i].dof);
        int n = 0;
        for (int k = 0; k < all.n; k++) {
            steps s = { .n_input = 1 };
            lw_mechanism m;
            lw_mechanism_from_chain(&all.chain[k], &m);
            OWN(lw_symmetry) sym = { 0 };
            lw_symmetry_of(&m, true, &sym);
            for (int l = 0; l < m.n_link; l++) {
                bool lowest = true;
                for (size_t q = 0; q < sym.n; q++)
                    lowest &= sym.link[q][l] >= l;
                s.n_ground += lowest;
            }
            n += s.n_ground;
        }
        CHECK_INT(n, known[i].n_ground);
        free(all.chain);
    }
}

TEST(refusals)
{
    lw_chain c = ring_of(4);
    lw_mechanism m;
    lw_mechanism_from_chain(&c, &m);
    CHECK_INT(lw_inputs_each(&m, 1, true, at_input, NULL), LW_E_ARG);
    CHECK_INT(lw_inputs_each(&m, 0, false, at_input, NULL), LW_E_ARG);
    CHECK_INT(lw_outputs_each(&m, at_output, NULL), LW_E_ARG);
    m.ground = 0;
    CHECK_INT(lw_grounds_each(&m, at_ground, NULL), LW_E_ARG);
    steps none = { 0 };
    CHECK_INT(lw_inputs_each(&m, 2, false, at_input, &none), LW_OK);        /* F = 1 takes no two */
    CHECK_INT(none.n_driven, 0);
}

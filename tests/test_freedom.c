/* The combinatorial rule for void labellings against the rank of the constraint matrix at random
 * dimensions.  The rank is exact: random dimensions and elimination modulo a prime near 2^31, so a wrong
 * answer has a chance of about 1e-8 a matrix. */
#include "check.h"
#include "all_chains.h"
#include "enumerate/freedom.h"

#define PRIME 2147483647ull
#define ROW_MAX (3*LW_JOINT_MAX)

typedef struct matrix { int n_col, rank; uint64_t row[ROW_MAX][3*LW_LINK_MAX]; int pivot[ROW_MAX]; } matrix;

static uint64_t power(uint64_t base, uint64_t n)
{
    uint64_t r = 1;
    for (; n; n >>= 1, base = base*base % PRIME)
        if (n & 1)
            r = r*base % PRIME;
    return r;
}

/* Reduce v by the rows there are; keep what is left.  False when nothing is. */
static bool add_row(matrix *m, const uint64_t *v, bool keep)
{
    uint64_t *r = m->row[m->rank];
    memcpy(r, v, sizeof *v*(size_t)m->n_col);
    for (int i = 0; i < m->rank; i++) {
        uint64_t f = r[m->pivot[i]];
        for (int c = 0; f && c < m->n_col; c++)
            r[c] = (r[c] + (PRIME - f)*m->row[i][c]) % PRIME;
    }
    for (int c = 0; c < m->n_col; c++)
        if (r[c]) {
            uint64_t inverse = power(r[c], PRIME - 2);
            for (int k = 0; k < m->n_col; k++)
                r[k] = r[k]*inverse % PRIME;
            m->pivot[m->rank] = c;
            m->rank += keep;
            return true;
        }
    return false;
}

/* Velocity of link b at (x, y) minus that of link a, times (dx, dy): 0. */
static void place_row(int a, int b, const uint64_t *g, bool across, uint64_t *v)
{
    uint64_t dx = across ? PRIME - g[3] : g[2], dy = across ? g[2] : g[3];
    uint64_t turn = (g[0]*dy + (PRIME - g[1])*dx) % PRIME;
    memset(v, 0, 3*LW_LINK_MAX*sizeof *v);
    v[3*b] = dx;
    v[3*b + 1] = dy;
    v[3*b + 2] = turn;
    v[3*a] = (PRIME - dx) % PRIME;
    v[3*a + 1] = (PRIME - dy) % PRIME;
    v[3*a + 2] = (PRIME - turn) % PRIME;
}

static void turn_row(int a, int b, uint64_t *v)
{
    memset(v, 0, 3*LW_LINK_MAX*sizeof *v);
    v[3*b + 2] = 1;
    v[3*a + 2] = PRIME - 1;
}

/* place (x, y) and direction (dx, dy) of each joint */
typedef uint64_t dimensions[LW_JOINT_MAX][4];

/* Rows of the joints; true when all are independent. */
static bool fill(const lw_mechanism *m, dimensions g, matrix *a)
{
    uint64_t v[3*LW_LINK_MAX];
    bool free_of_doubles = true;
    a->n_col = 3*m->n_link;
    a->rank = 0;
    for (int j = 0; j < m->n_joint; j++) {
        int p = m->link[j][0], q = m->link[j][1];
        place_row(p, q, g[j], true, v);                  /* all kinds: nothing across the line */
        free_of_doubles &= add_row(a, v, true);
        if (m->kind[j] == 'r')
            place_row(p, q, g[j], false, v);
        if (m->kind[j] == 't')
            turn_row(p, q, v);
        if (m->kind[j] == 'r' || m->kind[j] == 't')
            free_of_doubles &= add_row(a, v, true);
    }
    return free_of_doubles;
}

static bool all_used(const lw_mechanism *m, dimensions g, matrix *a)
{
    uint64_t v[3*LW_LINK_MAX];
    bool used = true;
    for (int j = 0; j < m->n_joint; j++) {
        turn_row(m->link[j][0], m->link[j][1], v);
        used &= m->kind[j] == 't' || add_row(a, v, false);
        place_row(m->link[j][0], m->link[j][1], g[j], false, v);
        used &= m->kind[j] == 'r' || add_row(a, v, false);
    }
    return used;
}

/* Compare rule and rank for one labelling; counts how the labellings fall. */
static void compare(const lw_mechanism *m, lw_rng *rng, int *seen)
{
    static matrix a;
    dimensions g;
    for (int j = 0; j < m->n_joint; j++)
        for (int k = 0; k < 4; k++)
            g[j][k] = 1 + lw_rng_bits(rng) % (PRIME - 1);
    uint64_t joints;
    lw_void reason = lw_mechanism_void(m, &joints);
    bool right = fill(m, g, &a), used = right && all_used(m, g, &a);
    CHECK_INT(reason == LW_VOID_NOT, used);
    if (reason == LW_VOID_LOCKED || reason == LW_VOID_DEPENDENT)
        CHECK_INT(reason == LW_VOID_LOCKED, right);
    if (reason == LW_VOID_SLIDER_LOOP)
        CHECK(!right);
    CHECK_INT(reason == LW_VOID_NOT, joints == 0);
    seen[reason]++;
}

static void every_labelling(const lw_chain *c, lw_rng *rng, int *seen)
{
    lw_mechanism m;
    lw_mechanism_from_chain(c, &m);
    for (unsigned set = 0; set < 1u << m.n_joint; set++) {
        for (int j = 0; j < m.n_joint; j++)
            m.kind[j] = lw_chain_freedom(c, m.link[j][0], m.link[j][1]) == 2 ? (set >> j & 1 ? 'g' : 'p')
                                                                               : (set >> j & 1 ? 't' : 'r');
        compare(&m, rng, seen);
    }
}

TEST(rings_and_six_links)
{
    int seen[5] = { 0 };
    lw_rng rng = check_rng(1);
    for (int n = 3; n <= 9; n++) {
        lw_chain c = ring_of(n);
        every_labelling(&c, &rng, seen);
    }
    lw_chain watt = watt_chain(), stephenson = stephenson_chain();
    every_labelling(&watt, &rng, seen);
    every_labelling(&stephenson, &rng, seen);
    for (int n = 3; n <= 6; n++)                              /* slots and gears in rings */
        for (int p = 1; p <= n; p++) {
            lw_chain c = ring_of(n);
            for (int i = 0; i < p; i++) {
                lw_chain_unjoin(&c, i, (i + 1) % n);
                lw_chain_join(&c, i, (i + 1) % n, 2);
            }
            every_labelling(&c, &rng, seen);
        }
    for (int k = 0; k < 3; k++)
        CHECK(seen[k] > 20);
}

TEST(eight_links)
{
    int seen[5] = { 0 };
    chain_list all = all_chains(8, 1);
    lw_rng rng = check_rng(4);
    CHECK_INT(all.n, 16);
    for (int i = 0; i < all.n; i++)
        every_labelling(&all.chain[i], &rng, seen);
    free(all.chain);
    CHECK_INT(seen[0] + seen[1] + seen[2] + seen[3] + seen[4], 16 << 10);
}

/* Any connected graph, rigid parts and all: independence must agree everywhere. */
TEST(random_graphs)
{
    int seen[5] = { 0 };
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 20000; trial++) {
        int n = 3 + trial % 8;
        lw_mechanism m = random_topology(&rng, n, 1 + trial % (n/2 + 2), trial % 3 ? "rt" : "rtpgpg");
        compare(&m, &rng, seen);
    }
    for (int k = 0; k < 5; k++)
        CHECK(seen[k] > 20);
}

/* Four-bars by hand: RRRR, RRRT, RRTT, RTRT move as F = 1 says; three sliders lock the pin, four move
 * with two freedoms. */
TEST(four_bars)
{
    static const struct { const char *kinds; lw_void reason; uint64_t joints; } known[] = {
        { "rrrr", LW_VOID_NOT, 0 }, { "rrrt", LW_VOID_NOT, 0 }, { "rrtt", LW_VOID_NOT, 0 },
        { "rtrt", LW_VOID_NOT, 0 }, { "rttt", LW_VOID_NO_TURN, 15 }, { "tttt", LW_VOID_SLIDER_LOOP, 15 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        lw_mechanism m;
        uint64_t joints;
        char text[200];
        lw_mechanism_clear(&m, 4);
        for (int k = 0; k < 4; k++)
            lw_mechanism_join(&m, k, (k + 1) % 4, known[i].kinds[k]);
        CHECK_INT(lw_mechanism_void(&m, &joints), known[i].reason);
        CHECK_INT(joints, known[i].joints);
        lw_void_print(&m, known[i].reason, joints, text, sizeof text);
        if (known[i].reason == LW_VOID_NO_TURN)
            CHECK_HAS(text, "are to turn at one joint: 1-2:r 1-4:t 2-3:t 3-4:t");
    }
}

/* Driving: F inputs, none of them within a part that another drives.  Held freedoms against the rank. */
TEST(driving)
{
    static matrix a;
    int n_yes = 0, n_no = 0;
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 4000; trial++) {
        lw_mechanism m = random_topology(&rng, 3 + trial % 7, 1 + trial % 5, "rrt");
        uint64_t joints = lw_rng_bits(&rng) & lw_rng_bits(&rng) & (((uint64_t)1 << m.n_joint) - 1);
        dimensions g;
        uint64_t v[3*LW_LINK_MAX];
        for (int j = 0; j < m.n_joint; j++)
            for (int k = 0; k < 4; k++)
                g[j][k] = 1 + lw_rng_bits(&rng) % (PRIME - 1);
        bool right = fill(&m, g, &a);
        for (int j = 0; j < m.n_joint; j++)
            if (joints >> j & 1) {
                if (m.kind[j] == 't')
                    place_row(m.link[j][0], m.link[j][1], g[j], false, v);
                else
                    turn_row(m.link[j][0], m.link[j][1], v);
                right &= add_row(&a, v, true);
            }
        CHECK_INT(lw_mechanism_drives(&m, joints), right);
        for (int j = 0; j < m.n_joint; j++)
            CHECK_INT(lw_mechanism_drivers(&m) >> j & 1, lw_mechanism_drives(&m, (uint64_t)1 << j));
        (*(right ? &n_yes : &n_no))++;
    }
    CHECK(n_yes > 200 && n_no > 200);
}

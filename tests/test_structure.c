/* test_structure.c - Franke structures: the ear grammar, all structures against published counts and against
 * the exhaustive search over multigraphs, derivations. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/structures.h"
#include "tests/check.h"
#include "tests/structure_check.h"

OWNS(lw_structures)

/* Biconnected loopless multigraphs with minimum degree 3, by loops and circles (2, 3, ...); published-counts.csv,
 * recomputed there with geng and multig.  Totals for 2 .. 8 loops: 1, 4, 17, 118, 1198, 17133, 311757. */
static const size_t by_circles[][9] = { [2] = { 1 }, [3] = { 1, 1, 2 }, [4] = { 1, 2, 5, 4, 5 },
                                        [5] = { 1, 3, 13, 24, 38, 23, 16 } };
static const size_t total[] = { [2] = 1, 4, 17, 118, 1198, 17133 };

TEST(counts_are_the_published_ones)
{
    lw_structures *set = NULL;
    CHECK_INT(lw_structures_create(7, 1, &set), LW_OK);
    CHECK_INT(lw_structures_loops(set), 7);
    for (int l = 2; l <= 7; l++)
        CHECK_INT(lw_structures_count(set, l), total[l]);
    CHECK_INT(lw_structures_count(set, 8), 0);
    CHECK_INT(lw_structures_count(set, 1), 0);
    for (int l = 2; l <= 5; l++) {
        size_t n[LW_CIRCLE_MAX + 1] = { 0 };
        lw_structure s;
        for (size_t k = 0; k < lw_structures_count(set, l); k++) {
            lw_structures_get(set, l, k, &s);
            n[s.n_circle]++;
        }
        for (int v = 2; v <= 2*(l - 1); v++)
            CHECK_INT(n[v], by_circles[l][v - 2]);
    }
    lw_structures_free(set);
    lw_structures_free(NULL);
}

TEST(refuses_impossible_loops)
{
    lw_structures *set = NULL;
    CHECK_INT(lw_structures_create(1, 1, &set), LW_E_ARG);
    CHECK_INT(lw_structures_create(LW_LOOP_MAX + 1, 1, &set), LW_E_ARG);
    CHECK(set == NULL);
}

static bool stop_at_thousand(void *context, int loops, size_t found)
{
    ++*(int *)context;
    return loops < 7 || found < 1000;
}

TEST(stops_when_asked)
{
    lw_structures *set = NULL;
    int n_call = 0;
    CHECK_INT(lw_structures_create_while(7, 1, stop_at_thousand, &n_call, &set), LW_STOPPED);
    CHECK(set == NULL && n_call >= 5);
}

/* Every structure passes its check, has its derivation, and stands after those with fewer circles. */
TEST(each_is_sound_and_replays)
{
    OWNED(lw_structures) *set = NULL;
    CHECK_INT(lw_structures_create(6, 1, &set), LW_OK);
    for (int l = 2; l <= 6; l++) {
        int circles = 0;
        for (size_t k = 0; k < lw_structures_count(set, l); k++) {
            lw_structure s, again;
            lw_derivation d;
            lw_structures_get(set, l, k, &s);
            lw_structures_derive(set, l, k, &d);
            CHECK(is_structure(&s));
            CHECK_INT(lw_structure_loops(&s), l);
            CHECK_INT(d.n_ear, l - 2);
            CHECK_INT(lw_derivation_replay(&d, &again), LW_OK);
            CHECK(lw_structure_same(&s, &again));
            CHECK(s.n_circle >= circles);
            circles = s.n_circle;
        }
    }
}

TEST(order_does_not_depend_on_threads)
{
    lw_structures *one = NULL, *three = NULL;
    CHECK_INT(lw_structures_create(6, 1, &one), LW_OK);
    CHECK_INT(lw_structures_create(6, 3, &three), LW_OK);
    for (size_t k = 0; k < lw_structures_count(one, 6); k++) {
        lw_structure a, b;
        lw_structures_get(one, 6, k, &a);
        lw_structures_get(three, 6, k, &b);
        CHECK(lw_structure_same(&a, &b));
    }
    lw_structures_free(one);
    lw_structures_free(three);
}

/* ---- exhaustive search over multigraphs ---------------------------------------------------------- */

typedef struct collection { lw_structure form[256]; size_t n; } collection;

static void collect(collection *c, const lw_structure *s)
{
    lw_structure form;
    CHECK_INT(lw_structure_canonical(s, &form), LW_OK);
    for (size_t k = 0; k < c->n; k++)
        if (lw_structure_same(&c->form[k], &form))
            return;
    if (c->n < 256)
        c->form[c->n++] = form;
}

/* Choose lines in rising order of their circles, parallel ones allowed. */
static void all_multigraphs(collection *c, lw_structure *s, int n_line, int a, int b)
{
    if (s->n_line == n_line) {
        if (is_structure(s))
            collect(c, s);
        return;
    }
    for (; a < s->n_circle - 1; a++, b = a + 1)
        for (; b < s->n_circle; b++) {
            s->end[s->n_line][0] = (uint8_t)a;
            s->end[s->n_line++][1] = (uint8_t)b;
            all_multigraphs(c, s, n_line, a, b);
            s->n_line--;
        }
}

TEST(agrees_with_all_multigraphs)
{
    OWNED(lw_structures) *set = NULL;
    CHECK_INT(lw_structures_create(5, 1, &set), LW_OK);
    for (int l = 2; l <= 5; l++)
        for (int v = 2; v <= 2*(l - 1) && v <= (l == 5 ? 4 : 6); v++) {
            static collection brute, grown;
            lw_structure s = { .n_circle = (uint8_t)v };
            brute.n = grown.n = 0;
            all_multigraphs(&brute, &s, l - 1 + v, 0, 1);
            for (size_t k = 0; k < lw_structures_count(set, l); k++) {
                lw_structures_get(set, l, k, &s);
                if (s.n_circle == v)
                    collect(&grown, &s);
            }
            CHECK_INT(brute.n, by_circles[l][v - 2]);
            CHECK_INT(grown.n, brute.n);
            for (size_t k = 0; k < grown.n; k++) {
                size_t n = brute.n;
                collect(&brute, &grown.form[k]);
                CHECK_INT(brute.n, n);
            }
        }
}

/* ---- single rules -------------------------------------------------------------------------------- */

static int possible_ears(const lw_structure *s, lw_ear *ear)
{
    lw_structure grown;
    int n = 0;
    for (int rule = LW_EAR_CIRCLES; rule <= LW_EAR_LINE; rule++)
        for (int a = 0; a < LW_LINE_MAX; a++)
            for (int b = 0; b < LW_LINE_MAX; b++) {
                lw_ear trial = { (uint8_t)rule, (uint8_t)a, (uint8_t)b };
                if (lw_structure_grow(s, trial, &grown) == LW_OK)
                    ear[n++] = trial;
            }
    return n;
}

/* V circles and E lines allow V (V - 1)/2 + V E + E (E - 1)/2 + E ears; each gives a structure with one loop
 * more, from which the new line can be taken. */
TEST(ears_keep_structures_sound)
{
    static lw_ear ear[4096];
    OWNED(lw_structures) *set = NULL;
    CHECK_INT(lw_structures_create(4, 1, &set), LW_OK);
    for (int l = 2; l <= 4; l++)
        for (size_t k = 0; k < lw_structures_count(set, l); k++) {
            lw_structure s, t;
            lw_structures_get(set, l, k, &s);
            int v = s.n_circle, e = s.n_line, n = possible_ears(&s, ear);
            CHECK_INT(n, v*(v - 1)/2 + v*e + e*(e - 1)/2 + e);
            for (int i = 0; i < n; i++) {
                CHECK_INT(lw_structure_grow(&s, ear[i], &t), LW_OK);
                CHECK(is_structure(&t));
                CHECK_INT(lw_structure_loops(&t), l + 1);
            }
        }
}

/* The slow way: take the line out, melt circles left with two lines, check what remains. */
static bool removable_by_trial(const lw_structure *s, int line)
{
    int end[LW_LINE_MAX][2], n = 0, degree[LW_CIRCLE_MAX] = { 0 };
    for (int e = 0; e < s->n_line; e++)
        if (e != line) {
            end[n][0] = s->end[e][0];
            end[n++][1] = s->end[e][1];
        }
    for (int side = 0; side < 2; side++) {
        int c = s->end[line][side], meet[2], n_meet = 0, far[2] = { 0, 0 };
        for (int e = 0; e < n; e++)
            for (int k = 0; k < 2; k++)
                if (end[e][k] == c && n_meet < 2) {
                    meet[n_meet] = e;
                    far[n_meet++] = end[e][1 - k];
                } else if (end[e][k] == c)
                    n_meet++;
        if (n_meet != 2)
            continue;
        end[meet[0]][0] = far[0];
        end[meet[0]][1] = far[1];
        n--;
        end[meet[1]][0] = end[n][0];
        end[meet[1]][1] = end[n][1];
    }
    lw_structure left = { 0 };
    uint8_t to[LW_CIRCLE_MAX];
    for (int e = 0; e < n; e++) {
        if (end[e][0] == end[e][1])
            return false;
        degree[end[e][0]]++;
        degree[end[e][1]]++;
    }
    for (int c = 0; c < s->n_circle; c++)
        if (degree[c])
            to[c] = left.n_circle++;
    left.n_line = (uint8_t)n;
    uint8_t same[LW_CIRCLE_MAX];
    for (int c = 0; c < LW_CIRCLE_MAX; c++)
        same[c] = (uint8_t)c;
    for (int e = 0; e < n; e++) {
        int a = to[end[e][0]], b = to[end[e][1]];
        left.end[e][0] = (uint8_t)(a < b ? a : b);
        left.end[e][1] = (uint8_t)(a < b ? b : a);
    }
    lw_structure_relabel(&left, same, &left);
    return is_structure(&left);
}

TEST(removable_lines_are_those_that_leave_a_structure)
{
    OWNED(lw_structures) *set = NULL;
    CHECK_INT(lw_structures_create(6, 1, &set), LW_OK);
    for (int l = 3; l <= 6; l++)
        for (size_t k = 0; k < lw_structures_count(set, l); k++) {
            lw_structure s;
            int n = 0;
            lw_structures_get(set, l, k, &s);
            for (int e = 0; e < s.n_line; e++) {
                CHECK_INT(lw_structure_removable(&s, e), removable_by_trial(&s, e));
                n += lw_structure_removable(&s, e);
            }
            CHECK(n > 0);                                     /* Whitney 1932 */
        }
}

/* ---- completeness by generating functions -------------------------------------------------------------
 * The sum of 1/|automorphisms of circles and lines| over all structures follows from the series of all loopless
 * multigraphs with labelled vertices (x) and edges (y): exp(y) for each pair.  Its logarithm counts connected ones, C;
 * blocks B satisfy B'(x C') = log C'; structures are the blocks other than rings and the single edge, with
 * y -> y/(1 + x y), which replaces strings of binary links by lines (Harary & Palmer 1973, section 1.3).  Every structure
 * adds a positive amount, so none is missing when the sums agree.  Numbers are modulo a prime. */
#define PRIME ((uint64_t)2305843009213693951u)
#define ORDER 24

typedef struct series { uint64_t c[ORDER]; } series;           /* in y */

__extension__ typedef unsigned __int128 wide;

static uint64_t times(uint64_t a, uint64_t b) { return (uint64_t)((wide)a*b % PRIME); }

static uint64_t inverse(uint64_t a)
{
    uint64_t r = 1;
    for (uint64_t n = PRIME - 2; n; n >>= 1, a = times(a, a))
        r = n & 1 ? times(r, a) : r;
    return r;
}

static uint64_t factorial(int n) { return n < 2 ? 1 : times((uint64_t)n, factorial(n - 1)); }

/* a += k b c; c NULL: 1 */
static void add_product(series *a, uint64_t k, const series *b, const series *c)
{
    for (int i = 0; i < ORDER; i++)
        for (int j = 0; j + i < ORDER && (c || j == 0); j++)
            a->c[i + j] = (a->c[i + j] + times(k, times(b->c[i], c ? c->c[j] : 1))) % PRIME;
}

/* out = log a for series in x with a[0] = 1; n + 1 terms. */
static void logarithm(const series *a, series *out, int n)
{
    memset(out, 0, (size_t)(n + 1)*sizeof *out);
    for (int k = 1; k <= n; k++) {
        series sum = { { 0 } };
        add_product(&sum, (uint64_t)k, &a[k], NULL);
        for (int i = 1; i < k; i++)
            add_product(&sum, PRIME - (uint64_t)i, &out[i], &a[k - i]);
        add_product(&out[k], inverse((uint64_t)k), &sum, NULL);
    }
}

/* Blocks with v vertices and e edges in b[v].c[e], v < n. */
static void count_blocks(series *b, int n)
{
    static series all[ORDER], connected[ORDER], rooted[ORDER], rest[ORDER], power[ORDER];
    memset(all, 0, sizeof all);
    memset(rooted, 0, sizeof rooted);
    memset(power, 0, sizeof power);
    memset(b, 0, (size_t)n*sizeof *b);
    for (int v = 0; v <= n; v++)
        for (int e = 0, pairs = v*(v - 1)/2; e < ORDER; e++) {
            uint64_t ways = 1;
            for (int i = 0; i < e; i++)
                ways = times(ways, (uint64_t)pairs);
            all[v].c[e] = times(ways, inverse(times(factorial(e), factorial(v))));
        }
    logarithm(all, connected, n);
    for (int v = 0; v < n; v++)
        add_product(&rooted[v], (uint64_t)v + 1, &connected[v + 1], NULL);           /* C' */
    logarithm(rooted, rest, n - 1);
    power[0].c[0] = 1;                                                               /* (x C')^k */
    for (int k = 0; k < n - 1; k++) {
        series next[ORDER] = { { { 0 } } }, coefficient = rest[k];
        add_product(&b[k + 1], inverse((uint64_t)k + 1), &coefficient, NULL);
        for (int i = k; i < n; i++)
            add_product(&rest[i], PRIME - 1, &coefficient, &power[i]);
        for (int i = k; i < n; i++)
            for (int j = 0; i + j + 1 < n; j++)
                add_product(&next[i + j + 1], 1, &power[i], &rooted[j]);
        memcpy(power, next, (size_t)n*sizeof *power);
    }
    b[2].c[1] = (b[2].c[1] + PRIME - inverse(2)) % PRIME;
    for (int v = 2; v < n; v++)
        b[v].c[v] = (b[v].c[v] + PRIME - inverse(2*(uint64_t)v)) % PRIME;
}

/* |automorphisms|, where parallel lines may be exchanged too. */
static uint64_t symmetries(const lw_structure *s)
{
    lw_graph g;
    uint64_t all = 0;
    lw_graph_of_structure(s, &g);
    CHECK_INT(lw_graph_symmetry(&g, NULL, &all), LW_OK);
    for (int i = 0; i < g.n; i++)
        for (int k = i + 1; k < g.n; k++)
            all = times(all, factorial(g.tie[i][k]));
    return all;
}

/* Counted without storing them, in three parts, there are as many, with the same sum of 1/|automorphisms|. */
TEST(counted_without_a_table)
{
    for (int loops = 3; loops <= 7; loops++) {
        lw_structures *parents, *set;
        lw_structures_tally by[LW_CIRCLE_MAX + 1], all[LW_CIRCLE_MAX + 1] = { 0 };
        CHECK_INT(lw_structures_create(loops - 1, 1, &parents), LW_OK);
        CHECK_INT(lw_structures_create(loops, 1, &set), LW_OK);
        for (int part = 0; part < 3; part++) {
            CHECK_INT(lw_structures_count_next(parents, part, 3, 1 + part, NULL, NULL, by), LW_OK);
            for (int v = 0; v <= LW_CIRCLE_MAX; v++) {
                all[v].n += by[v].n;
                all[v].weight += by[v].weight;
            }
        }
        for (size_t k = 0; k < lw_structures_count(set, loops); k++) {
            lw_structure s;
            lw_structures_get(set, loops, k, &s);
            all[s.n_circle].n--;
            all[s.n_circle].weight -= 1/(long double)symmetries(&s);
        }
        for (int v = 0; v <= LW_CIRCLE_MAX; v++) {
            CHECK(all[v].n == 0);
            CHECK_NEAR((double)all[v].weight, 0, 1e-12, 0);
        }
        lw_structures_free(parents);
        lw_structures_free(set);
    }
}

TEST(none_is_missing)
{
    static series block[ORDER];
    OWNED(lw_structures) *set = NULL;
    CHECK_INT(lw_structures_create(7, 1, &set), LW_OK);
    count_blocks(block, 14);
    for (int loops = 2; loops <= 7; loops++) {
        uint64_t have[LW_CIRCLE_MAX + 2] = { 0 };
        for (size_t k = 0; k < lw_structures_count(set, loops); k++) {
            lw_structure s;
            lw_structures_get(set, loops, k, &s);
            CHECK(is_structure(&s));
            have[s.n_circle] = (have[s.n_circle] + inverse(symmetries(&s))) % PRIME;
        }
        for (int v = 2; v <= 2*(loops - 1) + 1; v++) {          /* one circle more than there can be: 0 */
            uint64_t want = 0, binomial = 1;
            for (int k = 0; k <= v - 2; k++) {                  /* (1 + x y)^-e */
                uint64_t e = (uint64_t)(v - k + loops - 1);
                binomial = 1;
                for (uint64_t i = 0; i < (uint64_t)k; i++)
                    binomial = times(times(binomial, e + i), inverse(i + 1));
                uint64_t term = times(block[v - k].c[e], binomial);
                want = (want + (k & 1 ? PRIME - term : term)) % PRIME;
            }
            CHECK(have[v] == want);
        }
    }
}

/* Written and read, a set is the same; any byte of the file that changes is noticed. */
TEST(stored_sets_are_whole)
{
    lw_structures *set = NULL, *again = NULL;
    char *text = NULL;
    size_t size = 0;
    CHECK_INT(lw_structures_create(6, 1, &set), LW_OK);
    FILE *f = open_memstream(&text, &size);
    CHECK_INT(lw_structures_write(set, f), LW_OK);
    fclose(f);
    CHECK_INT(size, 16 + 4*8 + 8*(4 + 17 + 118 + 1198) + 8);
    f = fmemopen(text, size, "rb");
    CHECK_OK(lw_structures_read(f, "memory", &again, &check_error));
    fclose(f);
    for (size_t k = 0; again && k < lw_structures_count(set, 6); k++) {
        lw_structure a, b;
        lw_structures_get(set, 6, k, &a);
        lw_structures_get(again, 6, k, &b);
        CHECK(lw_structure_same(&a, &b));
    }
    CHECK(lw_structures_digest(set, 6) == lw_structures_digest(again, 6));
    CHECK(lw_structures_digest(set, 6) != lw_structures_digest(set, 5));
    lw_structures_free(again);
    for (size_t at = 0; at < size; at += at < 64 ? 1 : 211) {
        text[at] ^= 1;
        f = fmemopen(text, size, "rb");
        CHECK_INT(lw_structures_read(f, "memory", &again, &check_error), LW_E_NOTATION);
        fclose(f);
        text[at] ^= 1;
    }
    free(text);
    lw_structures_free(set);
}

TEST(faults_are_named)
{
    lw_structure s = lw_structure_theta();
    CHECK(is_structure(&s));
    CHECK(!lw_structure_removable(&s, 0));
    s.n_line = 2;
    CHECK(!is_structure(&s));
    s = (lw_structure){ 3, 6, { {0,1}, {0,1}, {0,1}, {1,2}, {1,2}, {1,2} } };
    CHECK(!is_structure(&s));
    s = (lw_structure){ 2, 3, { {0,1}, {1,1}, {0,1} } };
    CHECK(!is_structure(&s));
    s = (lw_structure){ 3, 5, { {0,2}, {0,1}, {0,1}, {1,2}, {1,2} } };
    CHECK(!is_structure(&s));
    s = (lw_structure){ 1, 0, { {0,0} } };
    CHECK(!is_structure(&s));
    CHECK_INT(lw_structure_grow(&s, (lw_ear){ 5, 0, 1 }, &s), LW_E_ARG);
    lw_derivation d = { 1, { { LW_EAR_LINES, 1, 1 } } };
    CHECK_INT(lw_derivation_replay(&d, &s), LW_E_ARG);
}

/* Weights 2, 2, 0 and 2, 1, 1 on the theta structure: Watt and Stephenson (errata of the source, no. 2). */
TEST(weights_make_chains)
{
    lw_structure s = lw_structure_theta();
    lw_chain c;
    CHECK_INT(lw_structure_chain(&s, (uint8_t[]){ 2, 2, 0 }, &c), LW_OK);
    CHECK_INT(c.n_link, 6);
    CHECK_INT(lw_chain_freedom(&c, 0, 1), 1);
    CHECK(lw_chain_freedom(&c, 0, 2) && lw_chain_freedom(&c, 2, 3) && lw_chain_freedom(&c, 3, 1));
    CHECK_INT(lw_chain_check(&c, NULL), LW_OK);
    CHECK_INT(lw_structure_chain(&s, (uint8_t[]){ 2, 1, 1 }, &c), LW_OK);
    CHECK_INT(lw_chain_mobility(&c), 1);
    CHECK_INT(lw_chain_freedom(&c, 0, 1), 0);
    CHECK_INT(lw_structure_chain(&s, (uint8_t[]){ 0, 4, 0 }, &c), LW_E_ARG);
    CHECK_INT(lw_structure_chain(&s, (uint8_t[]){ 30, 1, 0 }, &c), LW_E_ARG);
}

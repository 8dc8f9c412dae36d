/* test_cli_search.c - `linkwright fit --links`: searches over topologies. */
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/mechanisms.h"
#include "tests/cli_json.h"

TEST(every_topology_is_accounted_for)
{
    static const long known[2][3] = { { 6, 2, 5 }, { 8, 16, 71 } };        /* links, chains, ground choices   */
    json_auto_t *root = json_ending("LW_CLOCK_STEP=0.001 $C fit $D/t.csv --links 8 --time 1 --json", 5);
    json_t *list = json_object_get(root, "topologies");
    CHECK_INT(json_array_size(list), 2);
    for (size_t i = 0; i < json_array_size(list) && i < 2; i++) {
        const json_t *t = json_array_get(list, i);
        check_accounts(t, known[i]);
        CHECK(integer(t, "with_input") > integer(t, "with_tracer_link"));
        CHECK(integer(t, "families") >= integer(t, "fitted"));
        CHECK(integer(t, "with_linkage") <= integer(t, "searched"));
    }
}

/* Counting the mechanisms of eight links with sliders takes most of the time: what has fewer links is searched. */
TEST(smaller_mechanisms_are_searched_if_time_ends_while_larger_are_counted)
{
    json_auto_t *root = json_ending("LW_CLOCK_STEP=0.001 $C fit $D/t.csv --links 8 --joints r,t --time 1 --json", 5);
    CHECK_INT(integer(root, "uncounted_links"), 8);
    CHECK(json_is_false(json_object_get(root, "complete")));
    CHECK(json_array_size(json_object_get(root, "results")) > 0);
    CHECK_INT(json_array_size(json_object_get(root, "topologies")), 1);
}

/* Six links with sliders too: the report says how many families the budget did not reach. */
TEST(a_small_budget_is_accounted_for)
{
    const char *fit = "$P fit $D/t.csv --unlimited --links 6 --joints r,t --budget 2e4 --rounds 1 --json -q";
    json_t *root = json_of(fit), *t = json_array_get(json_object_get(root, "topologies"), 0);
    check_accounts(t, (const long[]){ 6, 2, 5 });
    CHECK_INT(integer(t, "fitted"), 435);
    CHECK_INT(integer(t, "families"), 435);
    CHECK(integer(t, "searched") > 0 && integer(t, "not_reached") > 0);
    json_decref(root);
}

TEST(more_links_are_never_worse)
{
    json_auto_t *root = json_of("$P fit $D/t.csv --unlimited --links 6 --budget 5000 --rounds 1 --json --seed 3");
    const json_t *stages = json_object_get(root, "by_links");
    CHECK_INT(json_array_size(stages), 2);
    for (size_t i = 1; i < json_array_size(stages); i++)
        CHECK(real(json_array_get(stages, i), "objective") <= real(json_array_get(stages, i - 1), "objective")*(1 + 1e-9) + 1e-26);
}

/* A linkage with a higher Assur group gives the same sum of squares again only up to rounding; its refinement must
 * end nevertheless, and not depend on the number of threads. */
TEST(higher_groups_end_for_any_threads)
{
    json_t *root = json_of("fit='fit examples/letters/S.csv --links 6 --timing none --budget 20000 --rounds 1 "
                           "--unlimited --seed 4 --json -q'; $P $fit -j 1 | grep objective > $D/one; $P $fit -j 2 | tee $D/two");
    json_t *best = json_array_get(json_object_get(root, "results"), 0);
    CHECK(integer(best, "links") == 6);
    CHECK(real(best, "objective") < 1);
    json_decref(root);
    expect("test -s $D/one && grep objective $D/two | diff - $D/one", 0, "", "");
}

TEST(only_the_topologies_asked_for)
{
    json_t *root = json_of("$P fit $D/t.csv --unlimited --links 6 --topology watt1 --budget 5000 --rounds 1 --json");
    json_t *results = json_object_get(root, "results");
    size_t six = 0;
    for (size_t i = 0; i < json_array_size(results); i++) {
        const json_t *r = json_array_get(results, i);
        if (integer(r, "links") == 6) {
            six++;
            CHECK_HAS(json_string_value(json_object_get(r, "family")), "Watt I,");
        }
        CHECK(json_is_true(json_object_get(r, "verified")));
    }
    CHECK(six > 0);
    json_decref(root);
    expect("$P fit $D/t.csv --links 6 --joints r,q", 2, NULL, "--joints takes r, or r with t");
    expect("$P fit $D/t.csv --links 6 --joints r,g --gear-ratios 1,1/0", 2, NULL, "'1/0' is none");
    expect("$P fit $D/t.csv --links 6 --topology wat", 3, NULL, "nothing up to 6 links is called 'wat'");
    expect("$P fit $D/t.csv --unlimited --results 2 --rounds 1 -q -o $D/two.json && $P trace $D/two.json --result 2 -n 3", 0,
           "arc,mode",
           NULL);
    expect("$P trace $D/two.json --result 9", 3, NULL, "result 9 is wanted");
    expect("$P fit $D/t.csv --topology watt1", 3, NULL, "more than four links");
    expect("$P fit $D/t.csv --bounds r1=5:5,r2=5:5,r3=5:5,r4=1e-3:1e-3 --crank-only --rounds 1 -j 1", 1, NULL, NULL);
}

TEST(a_resumed_fit_is_not_worse)
{
    json_t *first = json_of("$P fit $D/t.csv --unlimited --links 6 --topology watt --crank-only --budget 2000 --rounds 1 --seed 2 -o $D/r.json "
                            "-q; cat $D/r.json");
    json_t *then = json_of("$P fit $D/t.csv --unlimited --links 6 --topology watt --crank-only --budget 2000 --rounds 1 --seed 9 --start-from "
                           "$D/r.json --json");
    double before = real(json_array_get(json_object_get(first, "results"), 0), "objective");
    double after = real(json_array_get(json_object_get(then, "results"), 0), "objective");
    json_t *alone = json_of("$P fit $D/t.csv --unlimited --links 6 --topology watt --crank-only --budget 2000 --rounds 1 --seed 9 --json");
    CHECK(after <= before*(1 + 1e-6) + 1e-26);
    CHECK(real(json_array_get(json_object_get(alone, "results"), 0), "objective") > before*1.001);      /* else this would not notice */
    json_decref(first);
    json_decref(then);
    json_decref(alone);
    expect("$P fit $D/t.csv --start-from $D/none.json", 3, NULL, "none.json");
    expect("printf '{\"linkwright\":1,\"links\":[\"ground\",\"a\"],\"joints\":[{\"links\":[\"ground\",\"a\"],"
           "\"name\":\"A\",\"at\":[0,0]}]}' > $D/l.json; $P fit $D/t.csv --start-from $D/l.json", 3, NULL,
           "one input and a tracer");
}

TEST(error_against_links)
{
    expect("mkdir -p $D/p; cp $D/t.csv $D/p/; $P bench fit --links 6 --budget 3000 --problems $D/p -o $D/b", 0, "|  6 |", NULL);
    expect("head -2 $D/b/links.csv; ls $D/b", 0, "problem,links,evaluations,seconds,objective", NULL);
    expect("$P bench fit --links 7", 2, NULL, "even numbers from 4 to 10");
}

/* ---- pins in slots ---------------------------------------------------------------------------------------- */

/* Pins in slots counted another way: a pin in a slot is a binary link, here called a block, with a pin and a
 * slider. */
enum { FORMS = 1024 };
typedef struct blocks { int n2; long n; bool full; lw_graph form[FORMS]; } blocks;

/* May these links be blocks? A block is binary and neither ground nor output; no two blocks are joined to each
 * other or to the same pair of links, and none stands between two links that are joined. */
static bool may_be_blocks(const lw_mechanism *m, const lw_chain *c, uint32_t set)
{
    for (int i = 0; i < m->n_link; i++) {
        uint32_t beside = lw_chain_neighbours(c, i);
        if (!(set >> i & 1))
            continue;
        if (__builtin_popcount(beside) != 2 || i == m->ground || i == m->output || beside & set
            || lw_chain_neighbours(c, __builtin_ctz(beside)) & beside)
            return false;
        for (int k = 0; k < i; k++)
            if (set >> k & 1 && lw_chain_neighbours(c, k) == beside)
                return false;
    }
    return true;
}

static void keep_form(blocks *b, const lw_mechanism *m, uint32_t set)
{
    lw_graph g = { .n = m->n_link }, f = { .n = m->n_link };
    uint8_t to[LW_GRAPH_MAX];
    for (int i = 0; i < m->n_link; i++)
        g.colour[i] = (uint8_t)(set >> i & 1 ? 3 : m->ground == i ? 1 : m->output == i ? 2 : 0);
    for (int j = 0; j < m->n_joint; j++)
        g.tie[m->link[j][0]][m->link[j][1]] = g.tie[m->link[j][1]][m->link[j][0]] = (uint8_t)m->kind[j];
    CHECK(lw_graph_label(&g, to) == LW_OK);
    for (int i = 0; i < g.n; i++) {
        f.colour[to[i]] = g.colour[i];
        for (int k = 0; k < g.n; k++)
            f.tie[to[i]][to[k]] = g.tie[i][k];
    }
    for (int i = 0; i < b->n; i++)
        if (memcmp(&b->form[i], &f, sizeof f) == 0)
            return;
    b->full |= b->n == FORMS;
    if (!b->full)
        b->form[b->n++] = f;
}

/* Make one joint or the other of each block a slider: bit k of `way` chooses for block k. */
static void slide_blocks(blocks *b, const lw_mechanism *m, uint32_t set, unsigned way)
{
    lw_mechanism slides = *m;
    for (int i = 0, k = 0; i < m->n_link; i++) {
        int at[2], n = 0;
        if (!(set >> i & 1))
            continue;
        for (int j = 0; j < m->n_joint; j++)
            if (m->link[j][0] == i || m->link[j][1] == i)
                at[n++ & 1] = j;
        slides.kind[at[way >> k++ & 1]] = 't';
    }
    if (lw_mechanism_void(&slides, NULL) == LW_VOID_NOT)
        keep_form(b, &slides, set);
}

static lw_status choose_blocks(void *context, const lw_mechanism *m)
{
    blocks *b = context;
    lw_chain c;
    lw_mechanism_chain(m, &c);
    for (uint32_t set = 0; set < 1u << m->n_link; set++)
        if (__builtin_popcount(set) == b->n2 && may_be_blocks(m, &c, set))
            for (unsigned way = 0; way < 1u << b->n2; way++)
                slide_blocks(b, m, set, way);
    return LW_OK;
}

static lw_status blocks_of_chain(void *context, const lw_chain_item *item)
{
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    lw_mechanism_steps steps = { .ground = true, .output = true };
    CHECK(lw_mechanism_from_chain(item->chain, &m) == LW_OK);
    return lw_mechanisms_each(&m, &steps, &counts, choose_blocks, NULL, context);
}

static long count_by_blocks(int links, int n2)
{
    static blocks b;
    lw_chains *all;
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = 1;
    b = (blocks){ .n2 = n2 };
    CHECK(lw_chains_create(links + n2, 1, 1, &all, NULL) == LW_OK);
    CHECK(lw_chains_each(all, &how, blocks_of_chain, &b) == LW_OK);
    lw_chains_free(all);
    CHECK(!b.full);
    return b.n;
}

/* Three links, counted by hand: a ring of pin, pin, pin in slot. There are six choices of ground and tracer link,
 * since the slot tells the links apart; in four of them ground and tracer link share a pin. */
TEST(slots_are_counted_as_blocks)
{
    json_auto_t *root = json_of("$P fit $D/t.csv --unlimited --links 4 --joints r,p --rounds 1 --starts 32 --budget 1000 --json");
    json_t *list = json_object_get(root, "topologies");
    json_t *three = json_array_get(list, 0), *four = json_array_get(list, 1);
    CHECK_INT(json_array_size(list), 2);
    CHECK_INT(integer(three, "links"), 3);
    CHECK_INT(integer(three, "with_tracer_link"), 6);
    CHECK_INT(integer(three, "joined_to_ground"), 4);
    CHECK_INT(integer(three, "fitted"), 2);
    CHECK_INT(count_by_blocks(3, 1), 6);
    CHECK_INT(integer(four, "links"), 4);
    CHECK_INT(integer(four, "with_tracer_link"), count_by_blocks(4, 2) + count_by_blocks(4, 4));
}

/* Smallest distance of (x, y) from the points of a traced curve. */
static double from_curve(const char *csv, double x, double y)
{
    double least = INFINITY, at[4];
    for (const char *line = csv; line && *line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
        const char *from = strchr(line, ',');
        if (*line >= '0' && *line <= '9' && from && (from = strchr(from + 1, ','))
            && sscanf(from + 1, "%lf,%lf,%lf", &at[0], &at[1], &at[2]) == 3)
            least = fmin(least, hypot(at[1] - x, at[2] - y));
    }
    return least;
}

/* Results with a joint of this kind are traced from their file and pass the target as closely as the fit reports.
 * Returns the number of such results. */
static int trace_results(const json_t *root, char kind)
{
    static const double target_at[][2] = { { 0, 0 }, { 1, 0.2 }, { 2, 0 }, { 3, 0.3 }, { 3, 1.2 }, { 2.6, 2 },
                                           { 1.5, 1.7 }, { 0.4, 1.4 } };
    const json_t *results = json_object_get(root, "results");
    int found = 0;
    for (size_t i = 0; i < json_array_size(results); i++) {
        const json_t *r = json_array_get(results, i), *k = json_object_get(r, "linkage");
        char *text = json_dumps(k, JSON_COMPACT), word[16], path[96];
        CHECK(json_is_true(json_object_get(r, "verified")));
        CHECK(real(r, "verified_difference") <= 1e-7);
        snprintf(word, sizeof word, "\"kind\":\"%c\"", kind);
        if (strstr(text, word) && json_is_true(json_object_get(r, "crank"))) {
            snprintf(path, sizeof path, "%s/found.json", getenv("D"));
            FILE *f = fopen(path, "w");
            CHECK(f && fputs(text, f) >= 0 && fclose(f) == 0);
            OWN(ran) t = run("$P trace $D/found.json --mode file --steps 2000");
            CHECK_INT(t.code, 0);
            double most = real(r, "error_max");
            for (size_t p = 0; p < sizeof target_at/sizeof *target_at; p++)
                CHECK(from_curve(t.out, target_at[p][0], target_at[p][1]) <= 1.02*most + 0.05);
            found++;
        }
        free(text);
    }
    return found;
}

TEST(slots_are_fitted_and_traced)
{
    json_auto_t *root = json_of("$P fit $D/t.csv --unlimited --links 5 --joints r,p --crank-only --starts 32 "
                           "--rounds 1 --budget 1000 --json");
    json_auto_t *plain = json_of("$P fit $D/t.csv --unlimited --links 5 --crank-only --starts 32 --rounds 1 --budget 1000 --json");
    CHECK(trace_results(root, 'p') > 0);
    CHECK(real(json_array_get(json_object_get(root, "results"), 0), "objective")
          <= real(json_array_get(json_object_get(plain, "results"), 0), "objective"));
}

/* Counted by hand. Three links are a carrier and two wheels; only a point of the wheel that rolls on a fixed one
 * draws no circle. Five links are the carrier c, the wheels i and j, and x and y, with five pins: (a) the ring c i
 * x y j. Ground and tracer link c x and i y fit (i j is the case of three links); with ground x neither wheel is
 * known first, and x i and x c need a group. (b) A four-bar c i x y with the wheel j on c: x j, y j, j x, j y; with
 * j on the coupler a group is needed where the ratio is no whole number. (c) Three gear pairs on a tree of four
 * pins: the path of five links from end to end, and three more, each with all 27 sets of ratios.  (d) What moves as one with
 * fewer links only while the input is next to it: i j of (a) with x, and of (b) with y as the input; c x of (b) with the
 * input j; and three with three pairs. */
TEST(gear_pairs_are_counted)
{
    json_t *root = json_of("$P fit $D/t.csv --links 5 --joints r,g --gear-ratios -1,2,1/2 --rounds 1 --starts 32 "
                           "--budget 3e5 --unlimited --json");
    json_t *list = json_object_get(root, "topologies"), *three = json_array_get(list, 0);
    json_t *five = json_array_get(list, 2);
    CHECK_INT(json_array_size(list), 3);
    CHECK_INT(integer(three, "links"), 3);
    CHECK_INT(integer(three, "with_tracer_link"), 3);
    CHECK_INT(integer(three, "joined_to_ground"), 2);
    CHECK_INT(integer(three, "fitted"), 1);
    CHECK_INT(integer(three, "searched"), 3);
    CHECK_INT(integer(five, "links"), 5);
    CHECK_INT(integer(five, "fitted"), 6 + 2 + 3 + 4 + 3);       /* with groups: c and i with ground x */
    CHECK_INT(integer(five, "groups"), 3*3 + 3);                 /* these, and fractional ratios on a coupler */
    CHECK_INT(integer(five, "searched") + integer(five, "not_reached"), 11*3 + 7*27);
    CHECK(integer(five, "not_reached") <= integer(five, "groups"));
    CHECK(integer(five, "no_gear") >= 2);
    CHECK(integer(five, "with_linkage") <= integer(five, "searched"));
    CHECK(integer(five, "with_linkage") >= integer(five, "searched") - integer(five, "groups"));     /* these get few starts */
    json_decref(root);
    root = json_of("$P fit $D/t.csv --links 5 --joints r,g --gear-ratios -1,2,1/2 --rounds 1 --starts 8 --budget 3e5 --unlimited "
                   "--topology 5.1.1,5.1.3 --json");
    five = json_array_get(json_object_get(root, "topologies"), 2);
    CHECK_INT(integer(five, "fitted"), 6 + 2 + 3);
    CHECK_INT(integer(five, "searched") + integer(five, "not_reached"), 11*3);
    CHECK_INT(integer(five, "with_linkage"), integer(five, "searched"));
    json_decref(root);
}

/* Three links with a slider: the trochoids with every ratio. A wheel that rolls on the ground and, inverted, a rack
 * whose point is traced count once each: their pitch is a design variable. */
TEST(racks_are_counted)
{
    json_auto_t *root = json_of("$P fit $D/t.csv --links 4 --joints r,t,g --gear-ratios -1,2,1/2 --rounds 1 --starts 32 "
                           "--budget 1e5 --unlimited --json");
    json_t *three = json_array_get(json_object_get(root, "topologies"), 0);
    CHECK_INT(integer(three, "links"), 3);
    CHECK_INT(integer(three, "fitted"), 1 + 2);
    CHECK_INT(integer(three, "searched"), 3 + 2);
    CHECK_INT(integer(three, "with_linkage"), integer(three, "searched"));
}

/* Counting takes long with every kind of joint.  The signal is sent when the program has read and closed its target. */
TEST(counting_stops_when_asked)
{
    expect("mkfifo $D/fifo; $P fit $D/fifo --links 8 --joints r,t,p,g & cat $D/t.csv > $D/fifo; "
           "while ls -l /proc/$!/fd | grep -q $D/fifo; do sleep 0.01; done; "
           "kill -TERM $!; wait $!", 143, NULL, "stopped while mechanisms were still counted: none was searched");
}

TEST(gears_are_fitted_and_traced)
{
    json_auto_t *root = json_of("$P fit $D/t.csv --unlimited --links 5 --joints r,g --crank-only --starts 32 "
                           "--rounds 1 --budget 1000 --json");
    json_auto_t *plain = json_of("$P fit $D/t.csv --unlimited --links 5 --crank-only --starts 32 --rounds 1 --budget 1000 --json");
    CHECK(trace_results(root, 'g') > 0);
    CHECK(real(json_array_get(json_object_get(root, "results"), 0), "objective")
          <= real(json_array_get(json_object_get(plain, "results"), 0), "objective"));
}

CHECK_MAIN
{
    expect("printf 'x,y\\n0,0\\n1,0.2\\n2,0\\n3,0.3\\n3,1.2\\n2.6,2\\n1.5,1.7\\n0.4,1.4\\n' > $D/t.csv", 0, NULL, NULL);
    check_run();
    return check_end();
}

/* test_cli_freedoms.c - `linkwright fit --dof`: mechanisms of several degrees of freedom whose inputs are tied. */
#include <math.h>
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/mechanisms.h"
#include "grammar/linkage/sketch.h"
#include "mbs/plan/plan.h"
#include "tests/cli_json.h"

enum { STATIONS = 24 };

static const json_t *at(const json_t *root, const char *list, size_t i)
{
    return json_array_get(json_object_get(root, list), i);
}

/* A coupler point of a five-bar in closed form: cranks 18 and 14 on pins 60 apart, bars 55 and 62. The second crank
 * turns `ratio` times as fast as the first and is 0.7 rad ahead. */
static void five_bar_point(double ratio, double input, double *x, double *y)
{
    const double c = 55, d = 62;
    double ax = 18*cos(input), ay = 18*sin(input), bx = 60 + 14*cos(ratio*input + 0.7), by = 14*sin(ratio*input + 0.7);
    double dx = bx - ax, dy = by - ay, far = hypot(dx, dy);
    double along = (far*far + c*c - d*d)/(2*far), up = sqrt(c*c - along*along);
    double ux = (dx*along - dy*up)/far/c, uy = (dy*along + dx*up)/far/c;
    *x = ax + 30*ux - 20*uy;
    *y = ay + 30*uy + 20*ux;
}

static void write_target(const char *name, double ratio, bool timed)
{
    char path[96];
    run_prepare();
    snprintf(path, sizeof path, "%s/%s", getenv("D"), name);
    FILE *f = fopen(path, "w");
    CHECK(f != NULL);
    if (!f)
        return;
    fprintf(f, timed ? "x,y,angle\n" : "x,y\n");
    for (int k = 0; k < STATIONS; k++) {
        double x, y, input = 2*LW_PI*k/STATIONS;
        five_bar_point(ratio, input, &x, &y);
        fprintf(f, timed ? "%.12g,%.12g,%.12g\n" : "%.12g,%.12g\n", x, y, input);
    }
    fclose(f);
}

/* ---- coverage ----------------------------------------------------------------------------------------- */

/* The choices counted without symmetry: each ordered pair of joints at the ground, each ratio. Two choices are
 * equal if the two inputs turn the same way in both and the chains are isomorphic with ground, tracer link and the
 * sizes of both rates as colours. */
enum { FORMS = 4096 };
typedef struct plain {
    int n, n_ratio, sense[FORMS];
    const double *ratio;
    bool full;
    lw_graph form[FORMS];
    lw_rng rng;
} plain;

static bool felt_by_all(plain *p, const lw_mechanism *m, int first, int second, double ratio)
{
    static lw_plan plan;
    lw_linkage k;
    CHECK_INT(lw_linkage_sketch(m, &p->rng, &k), LW_OK);
    k.n_input = 2;
    k.input[0] = (lw_input){ .joint = first };
    k.input[1] = (lw_input){ .joint = second, .ratio = ratio };
    return lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_GEARED }, &plan, NULL) == LW_OK && plan.n_link == m->n_link;
}

static int other_end(const lw_mechanism *m, int joint)
{
    return m->link[joint][m->link[joint][0] == m->ground];
}

static void count_choice(plain *p, const lw_mechanism *m, int first, int second, double ratio)
{
    int lower = 1;
    while (fabs(lower*ratio - round(lower*ratio)) > 1e-9)
        lower++;
    lw_graph g = { .n = m->n_link }, *form = &p->form[p->n];
    uint8_t to[LW_GRAPH_MAX];
    for (int j = 0; j < m->n_joint; j++)
        g.tie[m->link[j][0]][m->link[j][1]] = g.tie[m->link[j][1]][m->link[j][0]] = 1;
    g.colour[m->ground] = 1;
    g.colour[m->output] = 2;
    g.colour[other_end(m, first)] = (uint8_t)(g.colour[other_end(m, first)] + 4*lower);
    g.colour[other_end(m, second)] = (uint8_t)(g.colour[other_end(m, second)] + 4*lround(fabs(lower*ratio)));
    CHECK_INT(lw_graph_label(&g, to), LW_OK);
    *form = (lw_graph){ .n = g.n };
    for (int i = 0; i < g.n; i++) {
        form->colour[to[i]] = g.colour[i];
        for (int l = 0; l < g.n; l++)
            form->tie[to[i]][to[l]] = g.tie[i][l];
    }
    p->sense[p->n] = ratio < 0 ? -1 : 1;
    for (int i = 0; i < p->n; i++)
        if (p->sense[i] == p->sense[p->n] && memcmp(&p->form[i], form, sizeof *form) == 0)
            return;
    p->full |= ++p->n == FORMS;
    p->n -= p->full;
}

static lw_status count_mechanism(void *context, const lw_mechanism *m)
{
    plain *p = context;
    if (lw_mechanism_joint(m, m->ground, m->output) != LW_NONE)
        return LW_OK;
    for (int i = 0; i < m->n_joint; i++)
        for (int j = 0; j < m->n_joint; j++) {
            bool ground = (m->link[i][0] == m->ground || m->link[i][1] == m->ground)
                       && (m->link[j][0] == m->ground || m->link[j][1] == m->ground);
            if (i == j || !ground || !felt_by_all(p, m, i, j, -1))
                continue;
            for (int r = 0; r < p->n_ratio; r++)
                count_choice(p, m, i, j, p->ratio[r]);
        }
    return LW_OK;
}

static lw_status count_chain(void *context, const lw_chain_item *item)
{
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    const lw_mechanism_steps steps = { .ground = true, .kinds = "r", .output = true };
    CHECK_INT(lw_mechanism_from_chain(item->chain, &m), LW_OK);
    return lw_mechanisms_each(&m, &steps, &counts, count_mechanism, NULL, context);
}

static int plain_count(int links, const double *ratio, int n_ratio)
{
    FREED plain *p = calloc(1, sizeof *p);
    lw_chains *chains;
    const lw_chain_walk how = lw_chain_walk_default();
    p->ratio = ratio;
    p->n_ratio = n_ratio;
    lw_rng_seed(&p->rng, 5, 0);
    CHECK_INT(lw_chains_create(links, 2, 1, &chains, NULL), LW_OK);
    CHECK_INT(lw_chains_each(chains, &how, count_chain, p), LW_OK);
    lw_chains_free(chains);
    CHECK(!p->full);
    int n = p->n;
    return n;
}

TEST(every_choice_is_accounted_for)
{
    static const long known[2][3] = { { 5, 1, 1 }, { 7, 3, 11 } };         /* links, chains, ground choices   */
    static const double all[] = { 1, -1, 2, -2, 3, -3 }, some[] = { 2, 0.5, -1.5 };
    write_target("m1.csv", -1, false);
    for (int given = 0; given < 2; given++) {
        char line[256];
        snprintf(line, sizeof line, "LW_CLOCK_STEP=0.001 $C fit $D/m1.csv --dof 2 --links 7 --time 0.3 --json -q%s",
                 given ? " --input-ratios 2,1/2,-3/2" : "");
        json_auto_t *root = json_ending(line, 5);
        CHECK_INT(json_array_size(json_object_get(root, "topologies")), 2);
        for (size_t i = 0; i < 2; i++) {
            const json_t *t = at(root, "topologies", i);
            check_accounts(t, known[i]);
            CHECK_INT(integer(t, "freedoms"), 2);
            CHECK(integer(t, "with_inputs_at_ground") > integer(t, "of_these_left_out"));
            CHECK_INT(integer(t, "families"), plain_count((int)known[i][0], given ? some : all, given ? 3 : 6));
        }
        const json_t *five = at(root, "topologies", 0);
        CHECK_INT(integer(five, "with_tracer_link"), 2);                   /* next to the ground, or not      */
        CHECK_INT(integer(five, "joined_to_ground"), 1);
        CHECK_INT(integer(five, "with_input"), 2*5*4/2);                   /* any two of five joints          */
        CHECK_INT(integer(five, "families"), given ? 4 : 10);              /* 1, -1 are the same either way   */
    }
}

/* With timing it matters which of the two inputs has the angles of the target. */
TEST(a_timing_tells_the_inputs_apart)
{
    write_target("timed.csv", 2, true);
    json_auto_t *root = json_of("$P fit $D/timed.csv --closed --dof 2 --budget 15000 --json -q");
    CHECK_INT(integer(at(root, "topologies", 0), "families"), 2*6);
    CHECK(real(at(root, "results", 0), "error_percent") < 1e-6);
}

/* With ratios -1 and 2 three inputs have 12 different rates up to a common factor. Exchanging two inputs keeps 2 of
 * them, a cyclic exchange of all three keeps none. Four sets of inputs are left: two without symmetry, one with
 * that of two inputs, one with that of all three (Burnside: (12 + 3 2 + 2 0)/6). */
TEST(three_freedoms_too)
{
    json_auto_t *root = json_of("$P fit $D/m1.csv --unlimited --dof 3 --input-ratios -1,2 --starts 32 --rounds 1 --budget 1000 --json -q");
    const json_t *six = at(root, "topologies", 0), *eight = at(root, "topologies", 1);
    CHECK_INT(integer(six, "chains"), 1);                                  /* a ring: two pins at the ground  */
    CHECK_INT(integer(six, "with_inputs_at_ground"), 0);
    CHECK_INT(integer(eight, "chains"), 5);
    CHECK_INT(integer(eight, "grounds"), 18);
    CHECK_INT(integer(eight, "with_inputs_at_ground") - integer(eight, "of_these_left_out"), 4);
    CHECK_INT(integer(eight, "families"), 12 + 12 + (12 + 2)/2 + (12 + 3*2)/6);
    CHECK_INT(json_array_size(json_object_get(json_object_get(at(root, "results", 0), "linkage"), "inputs")), 3);
}

/* ---- results ------------------------------------------------------------------------------------------- */

/* Distance of a point from the nearest row of a trace. */
static double from_rows(const char *rows, double x, double y)
{
    double least = INFINITY, input, px, py;
    int arc;
    char mode[16];
    for (const char *line = rows; line && *line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL)
        if (sscanf(line, "%d,%15[^,],%lf,%lf,%lf", &arc, mode, &input, &px, &py) == 5)
            least = fmin(least, hypot(px - x, py - y));
    return least;
}

/* The result with the least error: the first row may be another that is as good to build. */
static const json_t *most_exact(const json_t *root)
{
    const json_t *list = json_object_get(root, "results"), *best = json_array_get(list, 0);
    for (size_t i = 1; i < json_array_size(list); i++)
        if (real(json_array_get(list, i), "error_percent") < real(best, "error_percent"))
            best = json_array_get(list, i);
    return best;
}

/* The fit finds the five-bar that drew the curve again, up to rounding, with its ratio and phase; traced from its
 * file by the loop equations it draws the same curve. */
TEST(found_again)
{
    static const double ratio[] = { -1, 2 };
    for (int i = 0; i < 2; i++) {
        char path[96], by[32];
        write_target("drawn.csv", ratio[i], false);
        json_auto_t *root = json_of("$P fit $D/drawn.csv --closed --dof 2 --budget 15000 --json -q");
        const json_t *best = most_exact(root), *k = json_object_get(best, "linkage");
        CHECK(real(best, "error_percent") < 1e-8);
        CHECK(json_is_true(json_object_get(best, "verified")));
        snprintf(by, sizeof by, " by %g,", ratio[i]);
        CHECK_HAS(json_string_value(json_object_get(best, "family")), by);
        CHECK_NEAR(json_number_value(json_object_get(at(k, "inputs", 1), "ratio")), ratio[i], 0, 0);
        CHECK_NEAR(remainder(real(json_object_get(best, "dimensions"), "phi3") - 0.7, 2*LW_PI), 0, 1e-8, 0);
        snprintf(path, sizeof path, "%s/found.json", getenv("D"));
        CHECK(json_dump_file(k, path, 0) == 0);
        OWN(ran) t = run("$P trace $D/found.json --mode file --steps 24 -q");
        CHECK_INT(t.code, 0);
        for (int s = 0; s < STATIONS; s++) {
            double x, y;
            five_bar_point(ratio[i], 2*LW_PI*s/STATIONS, &x, &y);
            CHECK(from_rows(t.out, x, y) < 1e-7);
        }
        expect("$P draw $D/found.json -o $D/found.svg && grep -c input $D/found.svg", 0, NULL, NULL);
    }
}

TEST(threads_change_nothing)
{
    expect("$P fit $D/m1.csv --unlimited --dof 2 --links 7 --topology 7.1 --budget 1000 --json -q -j 1 | "
           "grep -v 'command\\|seconds' > $D/one; "
           "$P fit $D/m1.csv --unlimited --dof 2 --links 7 --topology 7.1 --budget 1000 --json -q -j 2 | "
           "grep -v 'command\\|seconds' | diff - $D/one", 0, "", "");
}

static double least_objective(const json_t *root)
{
    double least = INFINITY;
    for (size_t i = 0; i < json_array_size(json_object_get(root, "results")); i++)
        least = fmin(least, real(at(root, "results", i), "objective"));
    return least;
}

TEST(a_resumed_fit_is_not_worse)
{
    json_t *first = json_of("$P fit $D/m1.csv --dof 2 --budget 3000 -o $D/r.json -q; cat $D/r.json");
    json_t *then = json_of("$P fit $D/m1.csv --dof 2 --budget 3000 --seed 9 --start-from $D/r.json --json -q");
    CHECK(least_objective(then) <= least_objective(first)*(1 + 1e-6) + 1e-18);
    json_decref(first);
    json_decref(then);
}

/* Freedoms and links given in a task file, ratios on the command line; the command line has precedence. */
TEST(given_in_a_task_file)
{
    expect("printf '{\"linkwright-task\":1,\"target\":\"m1.csv\",\"dof\":2,\"links\":5}' > $D/task.json; "
           "$P fit $D/task.json --input-ratios -1,2 --budget 1e4 -q", 0, "; 3 searched", NULL);
    expect("$P fit $D/task.json --dof 3 --budget 1000", 3, "", "--dof 3 --links 5: with 3 inputs");
    expect("$P fit $D/task.json --dof 1 --links 4 --unlimited --starts 32 --rounds 1 -q", 0, "four-bar", NULL);
    expect("printf '{\"linkwright-task\":1,\"target\":\"m1.csv\",\"dof\":2,\"links\":6}' > $D/task.json; "
           "$P fit $D/task.json", 3, "", "two freedoms and pins have 5, 7 or 9 links");
}

TEST(refusals)
{
    expect("$P fit $D/m1.csv --dof 0", 2, "", "a linkage without freedom is a truss");
    expect("$P fit $D/m1.csv --dof 4", 2, "", "a mechanism has 11 links or more");
    expect("$P fit $D/m1.csv --dof 2 --links 4", 2, "", "with 2 inputs at the ground a mechanism has 5 links or more");
    expect("$P fit $D/m1.csv --dof 3 --links 7", 2, "", "8 links or more");
    expect("$P fit $D/m1.csv --dof 2 --type fourbar", 2, "", "goes together with no --type");
    expect("$P fit $D/m1.csv --dof 2 --exact", 2, "", "goes together with no --exact");
    expect("$P fit $D/m1.csv --input-ratios 2", 3, "", "give --dof 2");
    expect("$P fit $D/m1.csv --dof 2 --input-ratios 2,0.5", 2, "", "--input-ratios takes whole numbers");
    expect("$P fit $D/m1.csv --dof 2 --input-ratios ''", 2, "", "--input-ratios is empty");
}

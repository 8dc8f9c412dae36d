/* `fit --links`: searches over topologies, through the program. */
#include <jansson.h>
#include "tests/cli_run.h"

static const char *const target =
    "printf 'x,y\\n0,0\\n1,0.2\\n2,0\\n3,0.3\\n3,1.2\\n2.6,2\\n1.5,1.7\\n0.4,1.4\\n' > $D/t.csv; ";

static ran with_target(const char *command)
{
    char line[1024];
    snprintf(line, sizeof line, "%s%s", target, command);
    return run(line);
}

static json_t *json_ending(const char *command, int code)
{
    ran r = with_target(command);
    CHECK_INT(r.code, code);
    json_t *root = json_loads(r.out, 0, NULL);
    CHECK(root != NULL);
    ran_free(&r);
    return root;
}

static json_t *json_of(const char *command) { return json_ending(command, 0); }

static long integer(const json_t *o, const char *key) { return (long)json_integer_value(json_object_get(o, key)); }
static double real(const json_t *o, const char *key) { return json_number_value(json_object_get(o, key)); }

static void every_topology_is_accounted_for(void)
{
    static const long known[2][3] = { { 6, 2, 5 }, { 8, 16, 71 } };        /* links, chains, ground choices   */
    json_t *root = json_ending("$P fit $D/t.csv --links 8 --time 1 --json", 5);
    json_t *list = json_object_get(root, "topologies");
    CHECK_INT(json_array_size(list), 2);
    for (size_t i = 0; i < json_array_size(list) && i < 2; i++) {
        const json_t *t = json_array_get(list, i);
        long sum = 0;
        static const char *const fates[] = { "fitted", "joined_to_ground", "smaller", "no_plan", "groups", "not_asked" };
        for (int k = 0; k < 6; k++)
            sum += integer(t, fates[k]);
        CHECK_INT(integer(t, "links"), known[i][0]);
        CHECK_INT(integer(t, "chains"), known[i][1]);
        CHECK_INT(integer(t, "grounds"), known[i][2]);
        CHECK_INT(sum, integer(t, "with_tracer_link"));
        CHECK(integer(t, "with_input") > integer(t, "with_tracer_link"));
        CHECK(integer(t, "searched") >= integer(t, "fitted"));
    }
    json_decref(root);
}

static void more_links_are_never_worse(void)
{
    json_t *root = json_of("$P fit $D/t.csv --links 6 --budget 5000 --rounds 1 --json --seed 3");
    const json_t *stages = json_object_get(root, "by_links");
    CHECK_INT(json_array_size(stages), 2);
    for (size_t i = 1; i < json_array_size(stages); i++)
        CHECK(real(json_array_get(stages, i), "objective")
              <= real(json_array_get(stages, i - 1), "objective")*(1 + 1e-9) + 1e-26);
    json_decref(root);
}

static void only_the_topologies_asked_for(void)
{
    json_t *root = json_of("$P fit $D/t.csv --links 6 --topology watt1 --budget 5000 --json");
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
    expect("$P fit $D/t.csv --links 6 --joints r,q", 2, NULL, "--joints takes r or r,t");
    expect("$P fit $D/t.csv --links 6 --joints r,g", 2, NULL, "a search fits pins and sliders");
    expect("$P fit $D/t.csv --links 6 --topology wat", 3, NULL, "nothing up to 6 links is called 'wat'");
}

static void results_are_gone_on_from(void)
{
    json_t *first = json_of("$P fit $D/t.csv --links 6 --topology watt --crank-only --budget 5000 -o $D/r.json -q; cat $D/r.json");
    json_t *then = json_of("$P fit $D/t.csv --links 6 --topology watt --crank-only --budget 3000 --seed 9 --resume $D/r.json --json");
    double before = real(json_array_get(json_object_get(first, "results"), 0), "objective");
    double after = real(json_array_get(json_object_get(then, "results"), 0), "objective");
    CHECK(after <= before*(1 + 1e-6) + 1e-26);
    json_decref(first);
    json_decref(then);
    expect("$P fit $D/t.csv --resume $D/none.json", 3, NULL, "none.json");
    expect("printf '{\"linkwright\":1,\"links\":[\"ground\",\"a\"],\"joints\":[{\"links\":[\"ground\",\"a\"],"
           "\"name\":\"A\",\"at\":[0,0]}]}' > $D/l.json; $P fit $D/t.csv --resume $D/l.json", 3, NULL,
           "one input and a tracer");
}

static void error_against_links(void)
{
    expect("mkdir -p $D/p; cp $D/t.csv $D/p/; $P bench fit --links 6 --budget 3000 --problems $D/p -o $D/b", 0, "|  6 |",
           NULL);
    expect("head -2 $D/b/links.csv; ls $D/b", 0, "problem,links,evaluations,seconds,objective", NULL);
    expect("$P bench fit --links 7", 2, NULL, "even numbers from 4 to 10");
}

int main(void)
{
    RUN(every_topology_is_accounted_for);
    RUN(more_links_are_never_worse);
    RUN(only_the_topologies_asked_for);
    RUN(results_are_gone_on_from);
    RUN(error_against_links);
    return check_end();
}

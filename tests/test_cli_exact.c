/* test_cli_exact.c - `linkwright fit --exact`: five poses, a function, points, messages, saved files. */
#include "tests/cli_json.h"
#include "tests/mbs_linkage.h"

static const double bar[9] = { 3.2, 1.1, 2.9, 2.4, 1.6, 1.1, 0.5, -0.2, 0.3 };

/* Write n poses or points of the coupler of `bar`, or pairs of its input and output, to a file of $D. */
static void write_target(const char *name, const char *header, int n)
{
    char path[256];
    bool function = header[0] == 'a';
    snprintf(path, sizeof path, "%s/%s", temporary_folder(), name);
    FILE *f = fopen(path, "w");
    CHECK(f != NULL);
    fprintf(f, "%s\n", header);
    for (int j = 0; j < n; j++) {
        double in = 0.2 + 0.7*j;
        fourbar_joints q = fourbar_at(bar, 1, in);
        double coupler = atan2(q.b.y - q.a.y, q.b.x - q.a.x), out = atan2(q.b.y - q.b0.y, q.b.x - q.b0.x) - bar[8];
        if (function)
            fprintf(f, "%.17g,%.17g\n", in, out);
        else if (strstr(header, "theta"))
            fprintf(f, "%.17g,%.17g,%.17g\n", q.p.x, q.p.y, coupler + 0.4);
        else
            fprintf(f, "%.17g,%.17g\n", q.p.x, q.p.y);
    }
    fclose(f);
}

static json_t *fit(const char *arguments)
{
    char line[512];
    snprintf(line, sizeof line, "$P fit $D/%s --json --quiet", arguments);
    return json_of(line);
}

static double dimension(const json_t *result, const char *name)
{
    return json_number_value(json_object_get(json_object_get(result, "dimensions"), name));
}

TEST(five_poses)
{
    write_target("five.csv", "x,y,theta", 5);
    json_t *all = fit("five.csv --exact"), *exact = json_object_get(all, "exact"), *r;
    size_t i, own = 0;
    CHECK(json_is_true(json_object_get(exact, "complete")));
    size_t guides = json_array_size(json_object_get(exact, "guides"));
    CHECK(guides == 2 || guides == 4);
    CHECK_INT(json_array_size(json_object_get(all, "results")), guides*(guides - 1)/2);
    json_array_foreach(json_object_get(all, "results"), i, r) {
        own += fabs(dimension(r, "r1") - 3.2) < 1e-10 && fabs(dimension(r, "r2") - 1.1) < 1e-10
            && json_array_size(json_object_get(r, "defects")) == 0;
        CHECK(json_number_value(json_object_get(r, "error_max")) < 1e-10);
    }
    CHECK_INT(own, 1);
    json_decref(all);
}

TEST(four_pairs)
{
    write_target("pairs.csv", "angle,theta", 4);
    json_t *all = fit("pairs.csv --exact"), *r;
    size_t i, own = 0;
    json_array_foreach(json_object_get(all, "results"), i, r)
        own += fabs(dimension(r, "r2")/dimension(r, "r1") - 1.1/3.2) < 1e-9
            && fabs(dimension(r, "r3")/dimension(r, "r1") - 2.9/3.2) < 1e-9;
    CHECK(own >= 1);
    json_decref(all);
}

TEST(points)
{
    write_target("seven.csv", "x,y", 7);
    json_t *all = fit("seven.csv --exact --rounds 1"), *first;
    CHECK_HAS(json_string_value(json_object_get(json_object_get(all, "exact"), "free")), "2 of the coupler's angles");
    first = json_array_get(json_object_get(all, "results"), 0);
    CHECK(json_is_true(json_object_get(first, "verified")));
    CHECK_INT(json_array_size(json_object_get(first, "defects")), 0);
    json_decref(all);
    write_target("nine.csv", "x,y", 9);
    expect("$P fit $D/nine.csv --exact --rounds 12", 5, "not known to be complete", NULL);
    expect("$P fit $D/nine.csv --exact --rounds 12 --json", 5, "\"complete\": false,\n \"stop\"", NULL);
}

TEST(saves_and_traces)
{
    expect("$P fit $D/five.csv --exact --save $D/out -o $D/found.json && test -s $D/out/five-1.json "
           "&& test -s $D/out/five.svg && $P trace $D/out/five-1.json", 0, "guide 1", NULL);
    expect("$P draw $D/found.json --result 2 -o $D/second.svg && test -s $D/second.svg", 0, NULL, NULL);
}

TEST(says_what_is_wrong)
{
    write_target("six.csv", "x,y,theta", 6);
    write_target("ten.csv", "x,y", 10);
    write_target("two.csv", "angle,theta", 2);
    expect("$P fit $D/six.csv --exact", 3, NULL, "2 to 5 poses");
    expect("$P fit $D/ten.csv --exact", 3, NULL, "2 to 9 points");
    expect("$P fit $D/two.csv --exact", 3, NULL, "3 to 5 pairs");
    expect("$P fit $D/five.csv --exact --links 6", 2, NULL, "contradict");
    expect("$P fit $D/five.csv --exact --length-range 500:600", 1, NULL, "no real linkage");
    expect("printf 'x,y\\n0,0\\n1,1\\n0,0\\n' | $P fit - --exact", 3, NULL, "stations 1 and 3 are the same");
}

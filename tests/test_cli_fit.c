/* test_cli_fit.c - what `linkwright fit` says of its results: units, marks, limits. */
#include <math.h>
#include "tests/cli_json.h"

static double member(const json_t *o, const char *key) { return json_number_value(json_object_get(o, key)); }

/* The input of a slider is a length: in millimetres where the target is. */
static void inputs_of_sliders_have_the_unit_of_the_target(void)
{
    json_t *root = json_of("$P fit examples/figure-eight.csv --type sliderdriven --rounds 1 --json -q");
    json_t *best = json_array_get(json_object_get(root, "results"), 0), *linkage = json_object_get(best, "linkage");
    json_t *inputs = json_object_get(best, "inputs"), *range = json_object_get(best, "input_range"), *event;
    json_t *limits = json_object_get(best, "limits");
    double first = json_number_value(json_array_get(range, 0)), last = json_number_value(json_array_get(range, 1));
    size_t i;
    CHECK_TEXT(json_string_value(json_object_get(json_object_get(root, "target"), "length_unit")), "mm");
    CHECK_TEXT(json_string_value(json_object_get(json_object_get(linkage, "units"), "length")), "mm");
    CHECK(last - first > 1);                                          /* the target is 114 mm wide */
    CHECK(json_array_size(inputs) == 24 && json_array_size(limits) > 0);
    json_array_foreach(inputs, i, event)
        CHECK(json_number_value(event) >= first - 1e-6 && json_number_value(event) <= last + 1e-6);
    json_array_foreach(limits, i, event)
        CHECK(member(event, "input") == first || member(event, "input") == last);
    json_decref(root);
}

static void four_bars_near_a_change_point_are_marked(void)
{
    json_t *root = json_of("$P fit examples/film-advance.csv --rounds 1 -o $D/marked.json > $D/table; "
                           "cat $D/marked.json"), *r;
    size_t i;
    int n = 0;
    json_array_foreach(json_object_get(root, "results"), i, r) {
        bool near = json_is_true(json_object_get(r, "near_change_point"));
        CHECK(near == (member(r, "class_margin") < 1e-3));
        n += near;
    }
    CHECK(n > 0);
    json_decref(root);
    expect("grep -c '^ .*four-bar .*[*] ' $D/table", 0, NULL, NULL);
    expect("cat $D/table", 0, "* near a change point:", NULL);
}

/* The motion of an open target over a limit says so, as that of a closed one does. */
static void open_targets_over_limits_have_legs_and_modes(void)
{
    json_t *root = json_of("$P fit examples/pick-and-place.csv --rounds 1 --json -q"), *r;
    size_t i, points = (size_t)member(json_object_get(root, "target"), "points");
    int n = 0;
    CHECK(json_is_false(json_object_get(json_object_get(root, "target"), "closed")));
    json_array_foreach(json_object_get(root, "results"), i, r)
        if (!json_is_true(json_object_get(r, "crank")) && json_object_get(r, "modes")) {
            CHECK_INT(json_array_size(json_object_get(r, "modes")), points);
            CHECK(member(r, "legs") >= 2);
            n++;
        }
    CHECK(n > 0);
    json_decref(root);
}

/* Without timing half of the objective is the distance of the curve from the target: the second simulation computes
 * both halves, and comes to the same. */
static void both_simulations_come_to_one_objective(void)
{
    static const char *const run[] = {
        "$P fit examples/letters/S.csv --timing none --rounds 1 --json -q",
        "$P fit examples/letter-s.csv --timing none --rounds 1 --json -q",
    };
    for (size_t k = 0; k < sizeof run/sizeof *run; k++) {
        json_t *root = json_of(run[k]), *r;
        size_t i;
        json_array_foreach(json_object_get(root, "results"), i, r) {
            CHECK(json_is_true(json_object_get(r, "verified")) && json_is_null(json_object_get(r, "sense")));
            CHECK_NEAR(member(r, "verified_objective"), member(r, "objective"), 0, 1e-8);
        }
        CHECK(i > 0);
        json_decref(root);
    }
}

int main(void)
{
    RUN(inputs_of_sliders_have_the_unit_of_the_target);
    RUN(four_bars_near_a_change_point_are_marked);
    RUN(open_targets_over_limits_have_legs_and_modes);
    RUN(both_simulations_come_to_one_objective);
    return check_end();
}

/* test_cli_gallery.c - every mechanism of the gallery is traced, drawn and exported; those that draw exact lines draw
 * them. */
#include <jansson.h>
#include "tests/cli_run.h"

static json_t *list(void)
{
    json_t *all = json_load_file("examples/gallery/index.json", 0, NULL);
    CHECK(json_array_size(all) >= 24);
    return all;
}

TEST(every_mechanism_runs)
{
    json_t *all = list(), *row;
    size_t i;
    json_array_foreach(all, i, row) {
        const char *name = json_string_value(json_object_get(row, "name"));
        const char *title = json_string_value(json_object_get(row, "title"));
        static const char *const keys[] = { "title", "use", "year", "source" };
        for (int k = 0; k < 4; k++)
            CHECK(json_string_length(json_object_get(row, keys[k])) > 2);
        ran r = run_with("$P gallery %s -o $D/m.json --force && $P trace $D/m.json -n 24 --quiet -o $D/m.csv --force "
                         "&& $P draw $D/m.json -o $D/m.svg --force && $P convert $D/m.json -o $D/again.json --force", name);
        CHECK_INT(r.code, 0);
        if (r.code)
            fprintf(stderr, "%s: %s\n", name, r.err);
        ran_free(&r);
        expect_with(0, "1", NULL, "grep -c '\"name\": \"%s\"' $D/m.json", title);
        expect("test $(wc -l < $D/m.csv) -gt 10 && grep -q '</svg>' $D/m.svg && test $(wc -c < $D/m.svg) -lt 100000", 0, NULL, NULL);
    }
    json_decref(all);
}

/* Both draw a line x = constant on their first arc: columns arc,mode,input,x of the table. */
TEST(exact_lines_are_exact)
{
    static const char *const exact[] = { "peaucellier", "scott-russell" };
    for (int i = 0; i < 2; i++) {
        ran r = run_with("$P gallery %s | $P trace - -n 60 --quiet | grep '^1,' | cut -d, -f4", exact[i]);
        int n = 0;
        double first = strtod(r.out, NULL);
        for (char *p = r.out, *end; strtod(p, &end), end != p; p = end, n++)
            CHECK_NEAR(strtod(p, NULL), first, 1e-6, 0);
        CHECK(n > 20);
        ran_free(&r);
    }
}

TEST(wrong_names)
{
    expect("$P gallery klan", 2, NULL, "did you mean klann");
    expect("$P gallery", 0, "Windscreen", NULL);
    expect("$P gallery --json | head -n 1", 0, "\"source\":", NULL);
}

/* test_cli_mobility.c - `linkwright mobility`: its verdicts on the examples, and its refusals. */
#include "tests/cli_run.h"

TEST(verdicts_on_the_examples)
{
    expect("$P mobility examples/mobility/focal.json", 0, "moves because its dimensions are special", NULL);
    expect("$P mobility examples/mobility/focal.json", 0, "-1 = 3*7 - 22", NULL);
    expect("$P mobility examples/mobility/parallelogram.json", 0, "1  (0 with other dimensions)", NULL);
    expect("$P mobility examples/mobility/parallelogram.json", 0, "of C'  follows from A, A', B, B', C", NULL);
    expect("$P mobility examples/mobility/shaky.json", 0, "shaky: it yields, but cannot move", NULL);
    expect("$P mobility examples/mobility/roller.json", 0, "1 freedom that reaches no tracer: roller", NULL);
    expect("$P mobility examples/jansen.json", 0, "20 of 20 rows", NULL);
}

TEST(json_has_the_same)
{
    expect("$P mobility examples/mobility/roller.json --json", 0, "\"idle_links\": [\n    \"roller\"\n  ]", NULL);
    expect("$P mobility examples/mobility/parallelogram.json --json", 0, "\"verdict\": \"moves\"", NULL);
    expect("$P mobility examples/mobility/parallelogram.json --json", 0, "\"freedom_other_dimensions\": 0", NULL);
    expect("$P mobility - --json < examples/mobility/shaky.json", 0, "\"order\": 1", NULL);
    expect("$P mobility examples/jansen.json --json -o $D/a", 0, NULL, NULL);
    expect("$P mobility examples/jansen.json --json | cmp - $D/a", 0, NULL, NULL);
}

/* Rounded to four digits the focal linkage is rigid, unless its joints may have play of that size. */
TEST(rounded_files)
{
    expect("sed 's/\\(\\.[0-9]\\{4\\}\\)[0-9]*/\\1/g' examples/mobility/focal.json > $D/r.json", 0, NULL,
           NULL);
    expect("$P mobility $D/r.json", 0, "adjusted        joints by up to 5.", NULL);
    expect_words("$P mobility $D/r.json", "\nfreedom 1");
    expect("$P mobility $D/r.json --tolerance 1e-12", 0, "would move if joints opened by", NULL);
    expect_words("$P mobility $D/r.json --tolerance 1e-12", "\nfreedom 0");
    expect_words("$P mobility $D/r.json --tolerance 1e-4", "\nfreedom 1");
}

TEST(refusals)
{
    expect("$P mobility", 2, NULL, "MODEL.json");
    expect("$P mobility nowhere.json", 3, NULL, "nowhere.json");
    expect("$P mobility examples/jansen.json --tolerance 1", 2, NULL, "out of range");
    expect("$P mobilty examples/jansen.json", 2, NULL, "did you mean 'mobility'");
    expect("$P help mobility", 0, "Gruebler", NULL);
}

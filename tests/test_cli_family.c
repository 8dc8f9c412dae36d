/* test_cli_family.c - `linkwright family`: expansions that agree with hand-written models in every bit; tables, checks;
 * errors that name the master. */
#include "tests/cli_run.h"

#define LOADER "examples/families/loader.json"

static void expansions(void)
{
    expect("$P family expand " LOADER " | cmp - tests/data/family/loader.json", 0, "", NULL);
    expect("$P family expand " LOADER " --view kinematic | grep -c mass", 1, "0", NULL);
    expect("$P family expand " LOADER " --set 'reach=3200 mm' --configuration compact | grep '\"name\": \"loader'", 0, "reach 3.2 m, 400 kg", NULL);
    expect("$P family expand " LOADER " --map $D/map.csv -o $D/m.json && grep -c , $D/map.csv", 0, "", NULL);
}

/* The kinematic view moves like a linkage that was written by hand, in every bit. */
static void hand_written(void)
{
    expect("$P family expand tests/data/family/two-cylinders.json --view kinematic -o $D/made.json", 0, NULL, NULL);
    expect("for f in $D/made.json tests/data/family/hand.json; do $P trace $f --time-range 0:1:0.01 -q | grep -v '^#' > "
           "$D/$(basename $f).csv; done; wc -l < $D/made.json.csv && cmp $D/made.json.csv $D/hand.json.csv", 0, "10", NULL);
}

static void tables_and_checks(void)
{
    ran r = run("$P family table " LOADER);
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "payload                             800 kg          400 kg          2000 kg");
    CHECK_HAS(r.out, "the bucket stays above the ground   holds");
    ran_free(&r);
    expect("$P family table " LOADER " --json", 0, "\"unit\": \"kg/m^3\"", NULL);
    expect("$P family check " LOADER, 0, "3 configurations in 5 views: 15 models, 0 failed", NULL);
    expect("$P family check " LOADER " --set 'drop=2.2,pin_height=2'", 1, "the bucket stays above the ground (2.2 m against 2 m)", NULL);
    expect("$P family check " LOADER " --set 'drop=2.2,pin_height=2'", 1, "15 models, 3 failed", NULL);
}

static void wrong_use(void)
{
    expect("$P family expand " LOADER " --configuration huge", 2, NULL, "there is no configuration \"huge\"");
    expect("$P family expand " LOADER " --view kinematik", 2, NULL, "did you mean \"kinematic\"");
    expect("$P family expand " LOADER " --set reech=3", 2, NULL, "did you mean \"reach\"");
    expect("$P family expand " LOADER " --set 'reach=3 kg'", 3, NULL, "its unit is [m]");
    expect("$P family expand " LOADER " --set reach=9", 3, NULL, "outside its range 1.2 to 4 m");
    expect("$P family expand " LOADER " --set drop=2", 3, NULL, LOADER ":86:17: checks[0].require: this check does not hold");
    expect("$P family expand examples/loader.json", 3, NULL, "this is no master file");
    expect("$P family expend " LOADER, 2, NULL, "did you mean 'expand'");
}

int main(void)
{
    RUN(expansions);
    RUN(hand_written);
    RUN(tables_and_checks);
    RUN(wrong_use);
    return check_end();
}

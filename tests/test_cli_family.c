/* test_cli_family.c - `linkwright family`: expansions that agree with hand-written models in every bit; tables, checks;
 * errors that name the master. */
#include "tests/cli_run.h"

#define LOADER "examples/families/loader.json"

TEST(expansions)
{
    expect("$P family expand " LOADER " | cmp - tests/data/family/loader.json", 0, "", NULL);
    expect("$P family expand " LOADER " --view kinematic | grep -c mass", 1, "0", NULL);
    expect("$P family expand " LOADER " --set 'reach=3200 mm' --configuration compact | grep '\"name\": \"loader'", 0,
           "reach 3.2 m, 400 kg", NULL);
    expect("$P family expand " LOADER " --map $D/map.csv -o $D/m.json && grep -c , $D/map.csv", 0, "", NULL);
}

/* The kinematic view moves like a linkage that was written by hand, in every bit. */
TEST(hand_written)
{
    expect("$P family expand tests/data/family/two-cylinders.json --view kinematic -o $D/made.json", 0, NULL, NULL);
    expect("for f in $D/made.json tests/data/family/hand.json; do $P trace $f --time-range 0:1:0.01 -q | grep -v '^#' "
           "> "
           "$D/$(basename $f).csv; done; wc -l < $D/made.json.csv && cmp $D/made.json.csv $D/hand.json.csv", 0, "10",
               NULL);
    /* the rigid view of an elastic master: all columns of simulate */
    expect("$P family expand examples/families/boom.json -o $D/boom.json && for f in $D/boom.json "
           "tests/data/family/boom-rigid.json; do $P "
           "simulate $f --to 2 -n 50 -q | grep -v '^#' > $D/$(basename $f).csv; done; wc -l < $D/boom.json.csv && cmp "
           "$D/boom.json.csv "
           "$D/boom-rigid.json.csv", 0, "52", NULL);
}

TEST(tables_and_checks)
{
    ran r = run("$P family table " LOADER);
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "payload                             800 kg          400 kg          2000 kg");
    CHECK_HAS(r.out, "the bucket stays above the ground   holds");
    ran_free(&r);
    expect("$P family table " LOADER " --json", 0, "\"unit\": \"kg/m^3\"", NULL);
    expect("for f in delta gantry boom; do $P family check examples/families/$f.json || exit 9; done", 0,
           "15 models, 0 failed\n3 configurations in 5 views: 15 models, 0 failed\n3 configurations", NULL);
    expect("$P family expand examples/families/boom.json --view elastic -o $D/e.json && $P simulate $D/e.json "
           "--analysis linear --hold -q "
           /* 4.04 Hz with a rigid cylinder, by an independent beam model */
           "| grep -c '^1,0,1,4.0'", 0, "1", NULL);
    expect("$P family expand examples/families/gantry.json -o $D/g.json && $P drive load $D/g.json --to 1.2", 0,
           "96.7136", NULL);
    expect("$P family check " LOADER, 0, "3 configurations in 5 views: 15 models, 0 failed", NULL);
    expect("$P family check " LOADER " --set 'drop=2.2,pin_height=2'", 1,
           "the bucket stays above the ground (2.2 m against 2 m)", NULL);
    expect("$P family check " LOADER " --set 'drop=2.2,pin_height=2'", 1, "15 models, 3 failed", NULL);
}

/* The second column of a row of CSV that begins with `start`. */
static double second(const char *out, const char *start, int column)
{
    const char *at = strstr(out, start);
    for (int i = 1; at && i < column; i++)
        at = strchr(at + (i > 1 || *at != '\n'), ',') ? strchr(at + (i > 1 || *at != '\n'), ',') + 1 : NULL;
    return at ? strtod(at, NULL) : NAN;
}

/* Figures of a sweep are those of `simulate`; the boom weighs rho 2 t h l with h = l/10: exponents of the
 * sensitivity are known. */
TEST(sweeps)
{
    double peak = 0;
    expect("$P family expand " LOADER " --set reach=3 -o $D/three.json", 0, NULL, NULL);
    ran r = run("$P simulate $D/three.json --to 2 -n 200 | grep -v '^#' | cut -d, -f4");
    for (char *line = strchr(r.out, '\n'); line && line[1]; line = strchr(line + 1, '\n'))
        peak = fmax(peak, fabs(strtod(line + 1, NULL)));
    ran_free(&r);
    r = run("$P family sweep " LOADER " --vary reach=2:3:3 --to 2 --measure 'peak(lift.drive),hypot(reach, drop) as "
                                      "cm'");
    CHECK_INT(r.code, 0);
    CHECK(peak > 1e4);
    CHECK_NEAR(second(r.out, "\n3,", 2), peak, 1e-9*peak, 0);
    CHECK_NEAR(second(r.out, "\n3,", 3), 100*hypot(3, 1.2), 1e-9, 0);
    ran_free(&r);
    r = run("$P family sweep " LOADER " --vary reach,drop,plate=12:20,steel=7000:8000 --sensitivity --measure "
                                      "boom_mass --set 'reach=2,drop=2000 mm,pin_height=2.6'");
    CHECK_INT(r.code, 0);
    CHECK_NEAR(second(r.out, "\nreach,", 4), 1, 1e-4, 0);                     /* l^2 = reach^2 + drop^2, here both 2 */
    CHECK_NEAR(second(r.out, "\nsteel,", 4), 1, 1e-4, 0);
    ran_free(&r);
    expect("$P family sweep " LOADER " --vary reach,drop --samples 20 --measure boom_mass -j 1 -o $D/1.csv && $P "
                                     "family sweep " LOADER
           " --vary reach,drop --samples 20 --measure boom_mass -j 3 -o $D/3.csv && grep -v '^#' $D/1.csv > $D/a && "
           "grep -v '^#' "
           "$D/3.csv | cmp - $D/a && wc -l < $D/a", 0, "21", NULL);
    expect("$P family sweep " LOADER " --vary drop=1:2:3 --measure boom_mass", 0, "2,,checks[0].require", NULL);
    expect("$P family sweep " LOADER " --vary reach=2:3:5 --to 2 --normalised -p $D/s.svg -o $D/s.csv && grep -c "
                                     "'relative to the base' $D/s.svg", 0,
           "1", NULL);
}

/* A minimum that is known: the lever arm of a cylinder with this check at its limit; an inner one of a formula. */
TEST(optima)
{
    ran r = run("$P family optimise " LOADER " --vary reach=1.2:4,drop=0.5:1.4 --minimise '(reach/(1 m) - 2.5)^2 + "
                                             "(drop/(1 m) - 0.9)^2 + 1'");
    CHECK_INT(r.code, 0);
    const char *reach = strstr(r.out, "reach"), *drop = strstr(r.out, "drop ");
    CHECK_NEAR(reach ? strtod(reach + 6, NULL) : NAN, 2.5, 2e-4, 0);
    CHECK_NEAR(drop ? strtod(drop + 5, NULL) : NAN, 0.9, 2e-4, 0);
    ran_free(&r);
    r = run("$P family optimise " LOADER " --vary reach=1.2:4 --maximise boom_mass --require 'reach<=3,boom_length as "
                                         "cm <= 300' --json");
    CHECK_INT(r.code, 0);
    const char *value = strstr(r.out, "\"value\":");
    CHECK_NEAR(value ? strtod(value + 8, NULL) : NAN, sqrt(9 - 1.44), 1e-6, 0);
    ran_free(&r);
    expect("$P family optimise " LOADER " --vary reach --minimise boom_mass --require 'reach>=9'", 1, NULL,
           "no variant");
}

TEST(wrong_use)
{
    expect("$P family sweep " LOADER, 2, NULL, "--vary is missing");
    expect("$P family sweep " LOADER " --vary reech", 2, NULL, "did you mean \"reach\"");
    expect("$P family sweep " LOADER " --vary steel", 2, NULL, "steel has no range");
    expect("$P family sweep " LOADER " --vary reach=3:2", 2, NULL, "expected FROM:TO");
    expect("$P family sweep " LOADER " --vary reach --measure 'peak(lift.drove)'", 2, NULL, "did you mean lift.drive");
    expect("$P family sweep " LOADER " --vary reach --measure boom_mess", 2, NULL, "did you mean boom_mass");
    expect("$P family optimise " LOADER " --vary reach", 2, NULL, "to --minimise or to --maximise");
    expect("$P trace " LOADER, 3, NULL, "'linkwright family expand");
    expect("$P family expand " LOADER " --configuration huge", 2, NULL, "there is no configuration \"huge\"");
    expect("$P family expand " LOADER " --view kinematik", 2, NULL, "did you mean \"kinematic\"");
    expect("$P family expand " LOADER " --set reech=3", 2, NULL, "did you mean \"reach\"");
    expect("$P family expand " LOADER " --set 'reach=3 kg'", 3, NULL, "its unit is [m]");
    expect("$P family expand " LOADER " --set reach=9", 3, NULL, "outside its range 1.2 to 4 m");
    expect("$P family expand " LOADER " --set drop=2", 3, NULL, LOADER
           ":86:17: checks[0].require: this check does not hold");
    expect("$P family expand examples/loader.json", 3, NULL, "not a master file");
    expect("$P family expend " LOADER, 2, NULL, "did you mean 'expand'");
}

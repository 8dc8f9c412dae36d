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
    expect("for f in $D/made.json tests/data/family/hand.json; do $P trace $f --time-range 0:1:0.01 -q | grep -v '^#' > "
           "$D/$(basename $f).csv; done; wc -l < $D/made.json.csv && cmp $D/made.json.csv $D/hand.json.csv", 0, "10",
               NULL);
    /* the rigid view of an elastic master: all columns of simulate */
    expect("$P family expand examples/families/boom.json -o $D/boom.json && for f in $D/boom.json tests/data/family/boom-rigid.json; do $P "
           "simulate $f --to 2 -n 50 -q | grep -v '^#' > $D/$(basename $f).csv; done; wc -l < $D/boom.json.csv && cmp $D/boom.json.csv "
           "$D/boom-rigid.json.csv", 0, "52", NULL);
}

/* The second column of a row of CSV that begins with `start`. */
static double second(const char *out, const char *start, int column)
{
    const char *at = strstr(out, start);
    for (int i = 1; at && i < column; i++)
        at = strchr(at + (i > 1 || *at != '\n'), ',') ? strchr(at + (i > 1 || *at != '\n'), ',') + 1 : NULL;
    return at ? strtod(at, NULL) : NAN;
}

/* DELTA and gantry in space: the hand-written files give every column of simulate in the same bits. */
TEST(hand_written_in_space)
{
    static const char *const families[][2] = { { "delta", "--configuration optimum" }, { "gantry", "" } };
    for (int i = 0; i < 2; i++) {
        const char *n = families[i][0];
        expect_with(0, "22", NULL, "$P family expand examples/families/%s.json %s -o $D/%s.json && for f in $D/%s.json "
                    "tests/data/family/%s-hand.json; do $P simulate $f --to 0.1 -n 20 -q | grep -v '^#' > $D/$(basename $f).csv; "
                    "done; wc -l < $D/%s.json.csv && cmp $D/%s.json.csv $D/%s-hand.json.csv", n, families[i][1], n, n, n, n, n, n);
    }
}

/* The best ratio of a DELTA's links by the inertia of its motors, and without it a torque that rises with the ratio: known from an independent model,
 * whose links weigh in proportion to their length and keep l_u + 1.5 l_l = 1.505 m, as the source prints it. */
TEST(best_delta)
{
    static const double known[][2] = { { 0.10, 0.616 }, { 0.107, 0.630 }, { 0.11, 0.636 }, { 0.12, 0.656 } };
    ran r = run("sed -e 's|\"lever_mass\": {\"value\": 0.17|\"lever_mass\": {\"value\": \"=0.17 kg/(0.35 m)*p1*span/(1.5 + p1)\"|' "
                "-e 's|\"bar_mass\": {\"value\": 0.049|\"bar_mass\": {\"value\": \"=0.049 kg/(0.75 m)*span/(1.5 + p1)\"|' "
                "-e 's|\"value\": 1.475|\"value\": 1.505|' examples/families/delta.json > $D/heavy.json; "
                "$P family sweep $D/heavy.json --vary p1=0.35:0.95:7 --to 0.1 --measure 'peak(*.drive)'");
    CHECK_INT(r.code, 0);
    CHECK_NEAR(second(r.out, "\n0.35,", 2), 32.2, 0.05, 0);
    CHECK_NEAR(second(r.out, "\n0.95,", 2), 57.8, 0.05, 0);
    double before = 0;
    for (const char *line = strstr(r.out, "\n0.35,"); line && line[1]; line = strchr(line + 1, '\n')) {
        double peak = strtod(line + 1 + strcspn(line + 1, ",") + 1, NULL);
        CHECK(peak > before);
        before = peak;
    }
    ran_free(&r);
    for (int i = 0; i < 4; i++) {
        char command[300];
        snprintf(command, sizeof command, "$P family optimise $D/heavy.json --vary p1 --minimise 'peak(*.drive)' "
                 "--set motor_inertia=%g --to 0.1 -n 100", known[i][0]);
        r = run(command);
        CHECK_INT(r.code, 0);
        CHECK_NEAR(strtod(r.out + 2, NULL), known[i][1], 5e-4, 0);
        ran_free(&r);
    }
}

/* p2 = (base - plate)/lower and p1 at constant masses: torque at the start and the worst condition number of the way, as a model of all bodies by
 * Newton and Euler has them, whose rows are written alone and whose velocities are differences. */
TEST(sweeps_of_delta)
{
    static const struct { const char *vary, *row; double torque, condition; } known[] = {
        { "base=100:350:6", "\n100,", 40.570226, 2.3477696 }, { "base=100:350:6", "\n250,", 36.973164, 1.6427917 },
        { "base=100:350:6", "\n350,", 35.703222, 1.3402388 }, { "p1=0.35:0.95:4", "\n0.35,", 31.987485, 2.4134728 },
        { "p1=0.35:0.95:4", "\n0.75,", 48.880314, 1.3040271 }, { "p1=0.35:0.95:4", "\n0.95,", 55.980125, 1.6977192 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        char command[200];
        snprintf(command, sizeof command, "$P family sweep examples/families/delta.json --vary %s --to 0.1 --measure 'peak(*.drive),condition(tool)'", known[i].vary);
        ran r = run(command);
        CHECK_INT(r.code, 0);
        CHECK_NEAR(second(r.out, known[i].row, 2), known[i].torque, 0, 3e-8);
        CHECK_NEAR(second(r.out, known[i].row, 3), known[i].condition, 0, 3e-8);
        ran_free(&r);
    }
    /* the worst place is inside the way: an independent model of other data, at its 201 rows */
    ran r = run("$P family sweep examples/families/delta.json --set span=1.1,base=150,plate=40,width=80,height=450,stroke=250,time=0.15 --vary p1=0.8:0.9:2 "
                "--to 0.15 --measure 'condition(tool)'");
    CHECK_NEAR(second(r.out, "\n0.9,", 2), 1.7321327781, 0, 1e-9);
    ran_free(&r);
}

/* Figures of all drives, of robots and of `trace` are those that the other commands give. */
TEST(figures_of_other_commands)
{
    static const char four[] =
        "{\"linkwright\": 1, \"family\": \"four-bars\", \"parameters\": {\"d\": {\"value\": 4, \"unit\": \"m\", \"range\": [2, 9]}}, "
        "\"model\": {\"links\": [\"ground\", \"crank\", \"coupler\", \"rocker\"], \"joints\": ["
        "{\"name\": \"A\", \"links\": [\"ground\", \"crank\"], \"at\": [0, 0]}, {\"name\": \"B\", \"links\": [\"crank\", \"coupler\"], "
        "\"at\": [0, 1]}, {\"name\": \"C\", \"links\": [\"coupler\", \"rocker\"], \"at\": [3, 3]}, {\"name\": \"D\", \"links\": [\"rocker\", "
        "\"ground\"], \"at\": [\"=d\", 0]}], \"input\": {\"joint\": \"A\"}}}";
    char command[1600];
    ran r = run("$P family sweep examples/families/delta.json --vary p1=0.4:0.5:2 --to 0.1 --measure "
                "'peak(*.drive),peak(M1.drive),peak(M2.drive),min(*.rate),min(M1.rate),min(M2.rate),condition(tool)'");
    CHECK_INT(r.code, 0);
    CHECK(second(r.out, "\n0.5,", 2) == fmax(second(r.out, "\n0.5,", 3), second(r.out, "\n0.5,", 4)));
    CHECK(second(r.out, "\n0.5,", 5) == fmin(second(r.out, "\n0.5,", 6), second(r.out, "\n0.5,", 7)));
    double condition = second(r.out, "\n0.5,", 8);
    ran_free(&r);
    r = run("$P family expand examples/families/delta.json --set p1=0.5 -o $D/d.json && for x in -0.2 0 0.2; do $P robot jacobian "
            "$D/d.json --tool-at=$x,0,-0.65 | grep -i 'condition'; done");
    double most = 0;
    for (const char *at = r.out; (at = strstr(at, "ondition")); at++) {
        const char *digit = strpbrk(at, "0123456789");
        most = digit ? fmax(most, strtod(digit, NULL)) : most;
    }
    CHECK_NEAR(condition, most, 0, 1e-4);
    ran_free(&r);
    snprintf(command, sizeof command, "echo '%s' > $D/four.json; $P family sweep $D/four.json --vary d=4:5:2 --measure "
             "'arc(range),arc(transmission),arc(first)'; $P family expand $D/four.json -q | $P trace - -n 1 2>/dev/null", four);
    r = run(command);
    CHECK_INT(r.code, 0);
    const char *arc = strstr(r.out, "transmission ");
    arc = arc ? strstr(arc + 1, "transmission ") : NULL;
    CHECK(arc != NULL);
    if (arc)
        CHECK_NEAR(second(r.out, "\n4,", 3), strtod(arc + 13, NULL), 1e-4, 0);
    CHECK_NEAR(second(r.out, "\n4,", 2), 8*atan(1), 1e-9, 0);
    ran_free(&r);
    expect("$P family sweep $D/four.json --vary d=4:5:2 --measure 'arc(span)'", 2, NULL, "arc(first), arc(last)");
    expect("$P family sweep " LOADER " --vary reach=2:3:2 --measure 'condition(edge)'", 3, NULL, "spatial models");
}

/* A pendulum of 2 kg on an arm of length l in space: sqrt(m g l/(m l^2 + I))/(2 pi), from the posture at rest and from beside it. */
TEST(frequencies_in_space)
{
    static const char pendulum[] =
        "{\"linkwright\": 1, \"family\": \"pendulums\", \"parameters\": {\"l\": {\"value\": 1, \"unit\": \"m\", \"range\": [0.5, 2]}, "
        "\"x\": {\"value\": 0, \"unit\": \"m\"}}, \"model\": {\"links\": [\"ground\", {\"name\": \"arm\", \"mass\": 2, \"centre\": "
        "[\"=x\", 0, \"=-sqrt(l^2 - x^2)\"], \"inertia\": [0.01, 0.01, 0.01]}], \"joints\": [{\"name\": \"A\", \"kind\": \"revolute\", "
        "\"links\": [\"ground\", \"arm\"], \"at\": [0, 0, 0], \"axis\": [0, 1, 0]}], \"gravity\": [0, 0, -9.81]}}";
    char command[1200];
    snprintf(command, sizeof command, "echo '%s' > $D/pendulum.json; $P family sweep $D/pendulum.json --vary l=0.5:2:2 --measure "
             "'frequency(1)'", pendulum);
    for (int i = 0; i < 2; i++) {
        OWN(ran) r = run(command);
        CHECK_INT(r.code, 0);
        CHECK_NEAR(second(r.out, "\n0.5,", 2), sqrt(9.81/(2*0.25 + 0.01))/(8*atan(1)), 1e-8, 0);
        CHECK_NEAR(second(r.out, "\n2,", 2), sqrt(4*9.81/8.01)/(8*atan(1)), 1e-8, 0);
        strcat(command, " --set x=0.1");
    }
    expect("$P family sweep $D/pendulum.json --vary l=0.5:2:2 --measure 'frequency(2)'", 2, NULL, "has 1 natural frequenc");
}

/* Circles are named, units are compared, and every place is one of the master. */
TEST(impossible_masters)
{
    static const char *const rows[][2] = {
        { "\"parameters\": {\"a\": {\"value\": \"=b + 1\"}, \"b\": {\"value\": \"=a*2\"}}, \"model\": {\"links\": [\"ground\"]}",
          "parameters.a.value: a value needs itself: a -> b -> a" },
        { "\"parameters\": {\"a\": 1}, \"let\": {\"u\": \"w + a\", \"v\": \"u\", \"w\": \"v\"}, \"model\": {\"links\": [\"ground\"]}",
          "let.u: a value needs itself: u -> w -> v -> u" },
        { "\"parameters\": {\"a\": {\"value\": 1, \"unit\": \"m\"}, \"m\": {\"value\": 2, \"unit\": \"kg\"}}, \"let\": {\"u\": \"a + m\"}, "
          "\"model\": {\"links\": [\"ground\"]}", "let.u: the units do not fit: [m] and [kg] cannot be added" },
        { "\"parts\": {\"p\": {\"use\": [{\"part\": \"q\", \"name\": \"z\"}]}, \"q\": {\"use\": [{\"part\": \"p\", \"name\": \"y\"}]}}, "
          "\"model\": {\"links\": [\"ground\"], \"use\": [{\"part\": \"p\", \"name\": \"x\"}]}",
          "parts.p: a part uses itself: p -> q -> p" } };
    for (int i = 0; i < 4; i++) {
        expect_with(3, NULL, rows[i][1], "echo '{\"linkwright\": 1, \"family\": \"f\", %s}' > $D/bad.json; $P family expand $D/bad.json "
                    "-o $D/none.json; c=$?; test ! -e $D/none.json && exit $c", rows[i][0]);
    }
}

TEST(tables_and_checks)
{
    OWN(ran) r = run("$P family table " LOADER);
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "payload                             800 kg          400 kg          2000 kg");
    CHECK_HAS(r.out, "the bucket stays above the ground   holds");
    expect("$P family table " LOADER " --json", 0, "\"unit\": \"kg/m^3\"", NULL);
    expect("for f in delta gantry boom; do $P family check examples/families/$f.json || exit 9; done", 0,
           "15 models, 0 failed\n3 configurations in 5 views: 15 models, 0 failed\n3 configurations", NULL);
    expect("$P family expand examples/families/boom.json --view elastic -o $D/e.json && $P simulate $D/e.json --analysis linear --hold -q "
           /* 4.04 Hz with a rigid cylinder, by an independent beam model */
           "| grep -c '^1,0,1,4.0'", 0, "1", NULL);
    expect("$P family expand examples/families/gantry.json -o $D/g.json && $P drive load $D/g.json --to 1.2", 0, "96.7136", NULL);
    expect("$P family check " LOADER, 0, "3 configurations in 5 views: 15 models, 0 failed", NULL);
    expect("$P family check " LOADER " --set 'drop=2.2,pin_height=2'", 1, "the bucket stays above the ground (2.2 m against 2 m)", NULL);
    expect("$P family check " LOADER " --set 'drop=2.2,pin_height=2'", 1, "15 models, 3 failed", NULL);
}

/* Figures of a sweep are those of `simulate`; the boom weighs rho 2 t h l with h = l/10: exponents of the
 * sensitivity are known. */
TEST(sweeps)
{
    double peak = 0;
    expect("$P family expand " LOADER " --set reach=3 -o $D/three.json", 0, NULL, NULL);
    OWN(ran) r = run("$P simulate $D/three.json --to 2 -n 200 | grep -v '^#' | cut -d, -f4");
    for (char *line = strchr(r.out, '\n'); line && line[1]; line = strchr(line + 1, '\n'))
        peak = fmax(peak, fabs(strtod(line + 1, NULL)));
    ran_free(&r);
    r = run("$P family sweep " LOADER " --vary reach=2:3:3 --to 2 --measure 'peak(lift.drive),hypot(reach, drop) as cm'");
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
    expect("$P family sweep " LOADER " --vary reach,drop --samples 20 --measure boom_mass -j 1 -o $D/1.csv && $P family sweep " LOADER
           " --vary reach,drop --samples 20 --measure boom_mass -j 3 -o $D/3.csv && grep -v '^#' $D/1.csv > $D/a && grep -v '^#' "
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
    r = run("$P family optimise " LOADER " --vary reach=1.2:4 --maximise boom_mass --require 'reach<=3,boom_length as cm <= 300' --json");
    CHECK_INT(r.code, 0);
    const char *value = strstr(r.out, "\"value\":");
    CHECK_NEAR(value ? strtod(value + 8, NULL) : NAN, sqrt(9 - 1.44), 1e-6, 0);
    ran_free(&r);
    expect("$P family optimise " LOADER " --vary reach --minimise boom_mass --require 'reach>=9'", 1, NULL, "no variant");
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
    expect("$P family expand " LOADER " --set drop=2", 3, NULL, LOADER ":86:17: checks[0].require: this check does not hold");
    expect("$P family expand examples/loader.json", 3, NULL, "not a master file");
    expect("$P family expend " LOADER, 2, NULL, "did you mean 'expand'");
}

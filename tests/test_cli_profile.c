/* test_cli_profile.c - `linkwright profile`: summary, table, plot and JSON; known durations and swings; wrong use. */
#include "tests/cli_run.h"

static double number(const char *command, const char *key)
{
    OWN(ran) r = run(command);
    CHECK_INT(r.code, 0);
    const char *at = strstr(r.out, key);
    double x = at ? strtod(at + strlen(key), NULL) : NAN;
    return x;
}

#define LIMITS " --acceleration-limit 20 --jerk-limit 400 "

TEST(known_motions)
{
    CHECK_NEAR(number("$P profile 1" LIMITS "--speed-limit 3", "duration"), 0.533333333333, 1e-12, 0);
    CHECK_NEAR(number("$P profile 1" LIMITS "--speed-limit 3 --from-state 1,0 --to-state 0.5,0", "duration"), 0.45625, 1e-12, 0);
    CHECK_NEAR(number("$P profile -1" LIMITS "--speed-limit -3:1", "duration"), 0.533333333333, 1e-12, 0);
    CHECK_NEAR(number("$P profile 1" LIMITS "--speed-limit 3 --swing 5", "swing"), 0.0446890, 5e-5,
               0);    /* 44.689 mm */
    CHECK(number("$P profile 1" LIMITS "--speed-limit 3 --swing 20", "swing") < 1e-12);
    CHECK(number("$P profile 1" LIMITS "--speed-limit 3 --frequency 7", "swing") < 1e-12);
    CHECK(number("$P profile 0.01" LIMITS "--frequency 33", "swing") < 1e-14);
    CHECK_NEAR(number("$P profile 2 --law 345 --duration 4", "copper loss"), 17.1429, 1e-4, 0);
    CHECK_NEAR(number("$P profile 1 --law step --acceleration-limit 6", "duration"), 1, 1e-12, 0);
    /* three equal parts of the time: t_a = 2^(-2/3) (m s^2/P)^(1/3) */
    CHECK_NEAR(number("$P profile 1 --power 100 --mass 2", "duration"), 3*pow(2, -2/3.0)*cbrt(0.02), 1e-11, 0);
    CHECK_NEAR(number("$P profile 1" LIMITS "--duration 2", "duration"), 2, 1e-11, 0);
}

TEST(tables_and_pictures)
{
    OWN(ran) r = run("$P profile 90 --law modified-sine --duration 0.5 -n 4 -p $D/m.svg -o -");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "t,x,v,a,j\n0,0,0,0,");
    CHECK_HAS(r.out, "\n0.25,45,");
    CHECK_HAS(r.out, "\n0.5,90,");
    ran_free(&r);
    expect("grep -c 'speed .1/s' $D/m.svg", 0, "1", NULL);
    r = run("$P profile 0.1 --from-state 2,0" LIMITS "--speed-limit 3 --json -n 10");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "\"duration\": 0.26021287");
    CHECK_HAS(r.out, "\"phases\"");
    CHECK_HAS(r.out, "\"rows\"");
}

TEST(several_axes)
{
    CHECK_NEAR(number("$P profile 1,0.2,0.8" LIMITS "--speed-limit 3", "whole cycle"), 0.533333333333, 1e-10, 0);
    CHECK_NEAR(number("$P profile 1,0.2,0.8" LIMITS "--speed-limit 3 --straight", "whole cycle"), 0.533333333333, 1e-10, 0);
    expect("$P profile 1,0.5" LIMITS "--straight -n 2", 0, "\n0.25,0.5,4,", NULL);
    expect("$P profile 1,0.5" LIMITS "--duration 2 --json", 0, "\"cycle_time\": 2,", NULL);
    expect("$P profile 1,0.5,2" LIMITS "--speed-limit 3,1", 2, NULL, "one for all, or one each");
    expect("$P profile 1,x" LIMITS, 2, NULL, "a way each");
    expect("$P profile 1,2 --speed-limit 3", 3, NULL, "needs a limit");
    expect("$P profile 1,2" LIMITS "--law 345", 2, NULL, "--law is for a single move of a single axis");
}

TEST(several_moves)
{
    /* 0.8 m take 0.453112887 s, there and back, with a rest after each */
    CHECK_NEAR(number("$P profile 0.8 -0.8" LIMITS "--dwell 0.2", "whole cycle"), 2*(0.453112887412 + 0.2), 1e-9, 0);
    CHECK_NEAR(number("$P profile 0.8 --dwell 0.2" LIMITS, "whole cycle"), 0.653112887412, 1e-9, 0);
    CHECK_NEAR(number("$P profile 0.8,0 0,1 -0.8,-1" LIMITS, "whole cycle"), 0.453112887412 + 2*0.5, 1e-9, 0);
    CHECK_NEAR(number("$P profile 1 -0.4" LIMITS, "whole cycle"), 0.5 + number("$P profile 0.4" LIMITS, "duration"), 1e-9, 0);
    expect("$P profile 1 -0.4" LIMITS "-n 1 | tail -1 | cut -d, -f2", 0, "0.6\n", NULL);
    expect("$P profile 1 2,3" LIMITS, 2, NULL, "in each move");
    expect("$P profile 1 2" LIMITS "--power 3 --mass 2", 2, NULL, "--power is for a single move");
    expect("$P profile examples/cycles/gantry.json 2", 2, NULL, "a cycle is a single file");
    /* a speed limit for each direction counts: back at 0.5 m/s over 1 m takes longer than the way there at 3 m/s */
    double there = number("$P profile 1 --speed-limit 3" LIMITS, "duration"), back = number("$P profile 1 --speed-limit 0.5" LIMITS, "duration");
    CHECK_NEAR(number("$P profile 1 -1 --speed-limit -0.5:3" LIMITS, "whole cycle"), there + back, 1e-9, 0);
    expect("echo '{\"linkwright-cycle\": 1, \"axes\": [{\"name\": \"x\", \"speed\": [-0.5, 3], \"acceleration\": 20, \"jerk\": 400}], "
           "\"moves\": [{\"to\": {\"x\": 1}}, {\"to\": {\"x\": 0}}]}' > $D/sides.json; $P profile $D/sides.json -q > $D/a; "
           "$P profile 1 -1 --speed-limit -0.5:3" LIMITS "-q > $D/b; grep whole $D/a $D/b | cut -d: -f2 | uniq | wc -l", 0, "1\n", NULL);
    expect("sed 's/-0.5, 3/0.5, 3/' $D/sides.json > $D/s.json; $P profile $D/s.json", 3, NULL, "s.json:1:57: axes[0].speed: a limit is");
    expect("sed 's/{.to.: {.x.: 1}}/{\"to\": {\"x\": 1}, \"speed\": {\"x\": -0.6}}/' $D/sides.json > $D/s.json; $P profile $D/s.json", 3,
           NULL, "above the limit -0.5");
}

/* No way, ways and times beyond what anyone builds: still within the limits, and finite. */
TEST(hard_cases)
{
    expect("$P profile 0" LIMITS, 0, "duration      0 s\nspeed         0 to 0\n", NULL);
    expect("$P profile 0 --law 345 --duration 1", 0, "speed         0 to 0\n", NULL);
    expect("$P profile 0 --power 10 --mass 1" LIMITS, 0, "duration      0 s", NULL);
    expect("$P profile 0 --frequency 10" LIMITS, 0, "duration      0 s", NULL);
    expect("$P profile 1e9 --speed-limit 3" LIMITS, 0, "speed         0 to 3   (limits -3 to 3)\nacceleration  -20 to 20 ", NULL);
    expect("$P profile 1e-12 --speed-limit 3" LIMITS, 0, "jerk          -400 to 400 ", NULL);
    expect("$P profile 1 --duration 1e9 --speed-limit 3" LIMITS, 0, "duration      1000000000 s\nspeed         0 to 1", NULL);
    expect("$P profile 1 --frequency 1e8" LIMITS, 0, "acceleration", NULL);
    /* much slower than the limits allow: stretched, no digit is lost */
    for (int i = 3; i <= 12; i += 3) {
        char command[200];
        expect_with(0, "0.5\n", NULL, "$P profile 1" LIMITS "--duration 1e%d -n 2 | tail -2 | head -1 | cut -d, -f2", i);
        snprintf(command, sizeof command, "$P profile 1" LIMITS "--duration 1e%d", i);
        double peak = number(command, "speed         0 to ");
        CHECK(peak*pow(10, i) > 1 && peak*pow(10, i) < 2.0001);
    }
    expect("$P profile 1e300 --speed-limit 3" LIMITS, 2, NULL, "too many orders of magnitude");
    expect("$P profile 1e-300" LIMITS, 2, NULL, "too many orders of magnitude");
    expect("$P profile 1 --law copper-loss --duration 1 --json", 0, "\"law\": \"step\"", NULL);
    expect("$P profile 1 --law bang-bang --acceleration-limit 4", 0, "duration      1 s", NULL);
}

TEST(cycles)
{
    expect("$P profile examples/cycles/gantry.json", 0, " 2.418536337\nwanted", NULL);
    expect("$P profile examples/cycles/gantry.json --json", 0, "\"kept\": true", NULL);
    expect("sed 's/2.5/2.4/' examples/cycles/gantry.json > $D/late.json; $P profile $D/late.json", 1, "NOT kept", "more than wanted");
    expect("$P profile examples/cycles/blended.json -n 10 -p $D/cycle.svg -o -", 0, "t,y,y.v,y.a,y.j,z,z.v,z.a,z.j,payload\n0,0,0,0,0,0,", NULL);
    expect("$P profile examples/cycles/gantry.json --speed-limit 3", 2, NULL, "--speed-limit is for a single motion");
    expect("$P profile examples/loader.json", 3, NULL, "examples/loader.json:2:3: linkwright: this key is not known");
}

TEST(wrong_use)
{
    expect("$P profile 1" LIMITS "--speed-limit 3 --duration 0.3", 1, NULL, "next duration that is possible is 0.533333333 s");
    expect("$P profile 1 --speed-limit 3", 2, NULL, "neither acceleration nor jerk is limited");
    expect("$P profile 1" LIMITS "--to-state 4,0 --speed-limit 3", 2, NULL, "the last speed 4 is outside its limits -3 to 3");
    expect("$P profile 1 --law cycloids --duration 1", 2, NULL, "did you mean cycloid");
    expect("$P profile 1 --law havsin --jerk-limit 5 --duration 1", 2, NULL, "no limit of jerk can be kept");
    expect("$P profile 1 --law cycloid --acceleration-limit 1 --duration 1", 1, NULL, "needs at least 2.50662827 s");
    expect("$P profile 1 --law cycloid", 2, NULL, "needs --duration");
    expect("$P profile 1 --speed-limit 3x" LIMITS, 2, NULL, "expected a positive number, or MIN:MAX");
    expect("$P profile 1 --speed-limit 2:1" LIMITS, 2, NULL, "expected a positive number, or MIN:MAX");
    expect("$P profile 1 --from-state 1" LIMITS, 2, NULL, "expected speed and acceleration");
    expect("$P profile 1 --from-state 1,0 --frequency 5" LIMITS, 2, NULL, "from rest to rest");
    expect("$P profile x" LIMITS, 2, NULL, "WAY");
    expect("$P profile 1" LIMITS "-p $D/a.txt", 2, NULL, ".svg");
}

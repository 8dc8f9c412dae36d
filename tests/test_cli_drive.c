/* test_cli_drive.c - `linkwright drive`: loads against the equation of motion of an arm; wrong use. */
#include "base/vec2.h"
#include "tests/cli_run.h"

/* The figure of the first drive in the JSON of `load`. */
static double figure(const char *out, const char *key)
{
    const char *at = strstr(out, key);
    return at ? strtod(at + strlen(key), NULL) : NAN;
}

/* examples/drives/lifting-arm.json: J a + g (8*0.3 + 5*0.6) cos(angle), J = 0.24 + 8*0.09 + 0.02 + 5*0.36. */
TEST(arm)
{
    enum { N = 2000000 };
    const double j = 0.24 + 0.72 + 0.02 + 1.8, weight = 9.81*5.4;
    double square = 0, peak = 0, power_peak = 0, out = 0;
    for (int i = 0; i < N; i++) {
        double t = 2.5*(i + 0.5)/N, start = t < 1 ? 0 : 1.2, length = 0.8, sign = t < 1 ? 1 : -1;
        double u = (t - start)/length, w = LW_PI/length, moves = u > 0 && u < 1;
        double angle = (t < 1 ? -0.5 : 1) + sign*1.5*(u <= 0 ? 0 : u >= 1 ? 1 : 0.5*(1 - cos(LW_PI*u)));
        double v = moves*sign*0.75*w*sin(LW_PI*u), a = moves*sign*0.75*w*w*cos(LW_PI*u);
        double torque = j*a + weight*cos(angle), power = torque*v;
        square += torque*torque/N;
        peak = fmax(peak, fabs(torque));
        power_peak = fmax(power_peak, power);
        out += fmax(power, 0)*2.5/N;
    }
    OWN(ran) r = run("$P drive load examples/drives/lifting-arm.json --to 2.5 -n 5000 --json");
    CHECK_INT(r.code, 0);
    CHECK_NEAR(figure(r.out, "\"torque_rms\":"), sqrt(square), 1e-3*sqrt(square), 0);   /* a step of torque within a sample */
    CHECK_NEAR(figure(r.out, "\"torque_peak\":"), peak, 1e-4*peak, 0);
    CHECK_NEAR(figure(r.out, "\"power_peak\":"), power_peak, 1e-5*power_peak, 0);
    CHECK_NEAR(figure(r.out, "\"energy_out\":"), out, 1e-5*out, 0);
    CHECK_NEAR(figure(r.out, "\"energy_back\":"), out, 1e-5*out, 0);           /* a closed cycle without losses */
    CHECK_NEAR(figure(r.out, "\"speed_peak\":"), 0.75*LW_PI/0.8, 1e-5, 0);
}

/* A rigid axis behind a ramp lags by v/gain; its matrices have the poles that are printed. */
TEST(loop)
{
    static const char axis[] =
        "'{\"linkwright\": 1, \"servo\": {\"motor\": {\"torque_constant\": 1, \"inertia\": 0.001, \"resistance\": 1}, "
        "\"control\": {\"position\": {\"gain\": 20%s}, \"speed\": {\"proportional\": %s}}, \"motion\": {\"expression\": \"%s\"}}}'";
    char text[800];
    snprintf(text, sizeof text, axis, "", "100", "0.5*t");
    ran r = run_with("echo %s > $D/axis.json; $P drive simulate $D/axis.json --to 3 --json --matrices $D/m.json; cat $D/m.json", text);
    CHECK_INT(r.code, 0);
    CHECK_NEAR(figure(r.out, "\"error_end\":"), 0.5/20, 1e-9, 0);
    CHECK_NEAR(figure(r.out, "\"poles\": [\n    ["), -50 + sqrt(2500 - 2000), 1e-7, 0);
    CHECK_HAS(r.out, "\"stable\": true");
    CHECK_HAS(r.out, "[-2000, -100]");                      /* x'' = 100 (20 (-x) - x') */
    CHECK_HAS(r.out, "\"wanted position\"");
    ran_free(&r);
    snprintf(text, sizeof text, axis, ", \"sample\": 0.05, \"delay\": 0.05", "100", "0.001*sin(t)");
    expect_with(0, "poles of the whole", "unstable: its pole", "echo %s > $D/axis.json; $P drive simulate $D/axis.json --to 0.5", text);
    expect_with(4, NULL, "unstable, its pole", "echo %s > $D/axis.json; $P drive simulate $D/axis.json --to 1e3", text);
    /* the margins that are printed stand in the picture; the tables have the numbers of the JSON file, by name */
    expect("$P drive simulate examples/drives/servo-axis.json --bode $D/bode.svg --matrices-folder $D/axis --matrices $D/state.json -q "
           "-o $D/text && grep 'speed loop' $D/text && grep -o 'speed margin 42 deg at 238.6 Hz' $D/bode.svg && grep -c "
           "'poles of the whole' $D/bode.svg && ls $D/axis | wc -l && sed -n '3p' $D/axis/plant-B.csv", 0,
           "crossover 238.613 Hz, phase margin 42.03 deg", NULL);
    expect("head -2 $D/axis/plant-B.csv; sed -n 7p $D/axis/plant-B.csv; cat $D/state.json", 0,
           "name,voltage [V],force [N]\ncurrent [A],250,0\n", NULL);
    expect("echo mine > $D/axis/whole-A.csv; $P drive simulate examples/drives/servo-axis.json --matrices-folder $D/axis", 2, NULL,
           "linkwright did not write it");
    expect("$P drive simulate examples/drives/servo-axis.json --bode $D/bode.txt", 2, NULL, "svg");
    expect("$P drive simulate examples/drives/servo-axis.json -n 10", 0, "t,wanted,wanted_speed", NULL);
    /* a run that is stopped when its first rows are written keeps them */
    expect("$P drive simulate examples/drives/servo-axis.json -n 1e6 --to 1e3 -q -o $D/long.csv & "
           "until find $D -name '.lw-*' -size +8 | grep -q .; do sleep 0.01; done; kill -TERM $!; wait $!; test $? = 143 && test ! -e $D/long.csv && "
           "$P drive simulate examples/drives/servo-axis.json -n 100 --to 0.1 | head -n 4 > $D/first && head -n 4 $D/long.csv.partial | "
           "cmp - $D/first", 0, "", NULL);
    expect("$P drive simulate examples/drives/servo-axis.json --speed 3", 2, NULL, "drive load");
    expect("$P drive load examples/drives/lifting-arm.json --speed 3", 3, "", "here each has one");
    expect("$P family sweep examples/families/loader.json --vary reach=2:3:2 -n 2 --speed 3", 2, NULL, "here each has one");
    expect("$P simulate examples/space/arm.json --speed 3", 3, "", "here each has one");
    expect("$P drive simulate examples/drives/servo-axis.json --to 0", 2, NULL, "greater than 0");
    expect("$P drive simulate examples/drives/lifting-arm.json", 3, NULL, "units");
    expect("$P drive simulate $D/none.json", 3, NULL, "none.json");
}

#define PARTS " --motors examples/drives/motors.csv --gears examples/drives/gears.csv --amplifiers examples/drives/amplifiers.csv"
#define ARM "examples/drives/lifting-arm.json --to 2.5"

/* The DELTA robot of docs: known torques; its tool is driven, its motors carry the load. */
TEST(delta)
{
    ran r = run("$P drive load examples/space/delta.json --to 0.1 -n 200 --json");
    CHECK_INT(r.code, 0);
    CHECK_NEAR(figure(r.out, "\"torque_peak\":"), 37.7817, 5e-5, 0);
    CHECK_NEAR(figure(r.out, "\"speed_peak\":"), 16.7965, 5e-5, 0);
    ran_free(&r);
    for (int n = 200; n <= 201; n++) {                       /* the torque steps on a sample, and between two */
        char line[128];
        snprintf(line, sizeof line, "$P drive load examples/space/delta.json --to 0.1 -n %d --json", n);
        r = run(line);
        CHECK_NEAR(figure(r.out, "\"torque_rms\":"), 30.3835, 1e-4, 0);
        CHECK_NEAR(figure(r.out, "\"power_least\":"), -532.4, 0.1, 0);
        ran_free(&r);
    }
    r = run("$P drive load examples/space/delta.json --from 0.05000001 --to 0.1 -n 20 --json");    /* brakes from the middle */
    CHECK_NEAR(figure(r.out, "\"power_least\":"), -532.4, 0.05, 0);
    ran_free(&r);
    expect("$P family expand examples/families/delta.json -o $D/delta.json && $P drive load $D/delta.json --to 0.1 -n 200", 0,
           "M2               20.0403", NULL);
}

TEST(selections)
{
    expect("$P drive select " ARM PARTS, 0, "* S80-5.0            P80-40", NULL);
    expect("$P drive select " ARM PARTS " --json", 0, "\"pareto\": true", NULL);
    expect("for f in motors gears amplifiers; do $P catalogue add $D/parts.db examples/drives/$f.csv -q || exit 9; done; $P drive select " ARM
           " --motors $D/parts.db > $D/one && $P drive select " ARM PARTS " | cmp - $D/one && $P catalogue check $D/parts.db", 0, "", NULL);
    expect("$P drive select " ARM " --motors examples/drives/motors.csv", 1, "0 of 10 choices", "no choice can do the cycle; the nearest is");
    expect("$P drive select " ARM PARTS " -p $D/select.svg && grep -c 'continuous limit' $D/select.svg", 0, "1", NULL);
    ran r = run("$P drive load " ARM " --json");
    CHECK_NEAR(figure(r.out, "\"reflected_inertia\": ["), 2.78, 1e-9, 0);
    ran_free(&r);
    expect("$P drive radius examples/drives/paper-d.csv --mass 200 --way 4 --wanted-acceleration 20", 1,
           "5.9700    255.222     1.876     0.176     0.188    86.63%     1.5237    3.36366", NULL);
    expect("$P drive radius examples/drives/paper-d.csv --mass 200 --way 4 --wanted-acceleration 20", 1,
           "20 m/s^2 is impossible with this motor at any radius: its best is 2.2386 m/s^2 at r = 2.345 mm", NULL);
    expect("$P drive radius examples/drives/paper-d.csv --mass 200 --way 4 --wanted-acceleration 2 --json", 0, "\"possible\": true", NULL);
}

/* Shoulder of an arm with two links, by the formula: I1 + m1 c1^2 + I2 + m2 (L^2 + c2^2 + 2 L c2 cos q2), q2 from 0 to pi; friction does not count. */
TEST(inertia_of_an_arm)
{
    expect("printf '%s' '{\"linkwright\": 1, \"gravity\": [0, -9.81], \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 3, \"centre\": [0.4, 0], "
           "\"inertia\": 0.1}, {\"name\": \"b\", \"mass\": 2, \"centre\": [1.3, 0], \"inertia\": 0.05}], \"joints\": [{\"name\": \"S\", \"links\": "
           "[\"ground\", \"a\"], \"at\": [0, 0], \"friction\": {\"coefficient\": 0.2, \"radius\": 0.05}}, {\"name\": \"E\", \"links\": [\"a\", \"b\"], "
           "\"at\": [1, 0]}], \"inputs\": [{\"joint\": \"S\", \"motion\": \"t\"}, {\"joint\": \"E\", \"motion\": \"pi*t\"}]}' > $D/arm.json", 0, NULL, NULL);
    OWN(ran) r = run("$P drive load $D/arm.json -n 10 --json");
    double fixed = 0.1 + 3*0.16 + 0.05 + 2*(1 + 0.09), least = figure(r.out, "\"reflected_inertia\": [");
    CHECK_NEAR(least, fixed - 2*2*0.3, 1e-9, 0);
    char *elbow = strstr(r.out, "\"reflected_inertia\": [");
    CHECK_NEAR(strtod(strchr(elbow, ',') + 1, NULL), fixed + 2*2*0.3, 1e-9, 0);
    CHECK_NEAR(figure(strchr(elbow, ']'), "\"reflected_inertia\": ["), 0.05 + 2*0.09, 1e-9, 0);
}

TEST(wrong_use)
{
    expect("$P drive select " ARM, 2, NULL, "--motors is missing");
    expect("$P drive select " ARM PARTS " --drive sholder", 2, NULL, "did you mean \"shoulder\"");
    expect("$P drive select " ARM " --motors examples/drives/gears.csv", 3, NULL, "holds no motor");
    expect("$P drive select " ARM " --motors examples/ellipse.csv", 3, NULL, "this is a target");
    expect("sed s/,3000,/,5e-324,/ examples/drives/motors.csv > $D/slow.csv; $P drive radius $D/slow.csv --mass 20 --way 1", 3, "", "speed is too small");
    expect("sed s/,3000,/,1e200,/ examples/drives/motors.csv > $D/fast.csv; $P drive radius $D/fast.csv --mass 20 --way 1", 3, "", "speed is too large");
    expect("$P drive radius examples/drives/paper-d.csv --mass 200", 2, NULL, "--mass and --way");
    expect("$P drive", 2, NULL, "linkwright drive ACTION FILE");
    expect("$P drive lode x.json", 2, NULL, "did you mean 'load'");
    expect("$P drive load examples/drives/lifting-arm.json --from 2", 2, NULL, "--from must be less than --to");
    expect("$P drive load examples/pendulum.json", 3, NULL, NULL);
    expect("$P drive load examples/chebyshev.json", 3, NULL, "motion");
    expect("$P drive load examples/ellipse.csv", 3, NULL, "target");
    expect("$P drive load examples/drives/lifting-arm.json -p $D/x.txt", 2, NULL, "svg");
}

/* Nothing to do, and sizes and times that no machine has: an answer, or an error with its place. */
TEST(extreme_axes)
{
    static const struct { const char *edit; int code; const char *says; } rows[] = {
        { "s/\"to\": 1, /\"to\": 0, /", 0, NULL },
        { "s/\"mass\": 25/\"mass\": 1e300/", 3, "servo.load.mass: this number is too large" },
        { "s/\"jerk\": 400/\"jerk\": 1e-300/", 3, "moves[0]: the way 1, the limits and the time differ by too many orders" },
        { "s/\"dwell\": 0.1/\"dwell\": 1e300/", 3, "moves[0].dwell: this number is too large" },
        { "s/\"gain\": 40/\"gain\": -40/", 3, "gain: this must not be negative" },
        { "s/\"gain\": 40/\"gain\": 4000/", 0, "unstable: its pole 511.585 +1592.9 i 1/s grows" } };
    for (int i = 0; i < (int)(sizeof rows/sizeof *rows); i++) {
        expect_with(rows[i].code, NULL, rows[i].says, "sed '%s' examples/drives/servo-axis.json > $D/axis.json; $P drive simulate $D/axis.json",
                    rows[i].edit);
    }
}

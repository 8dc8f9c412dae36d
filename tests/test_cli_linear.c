/* test_cli_linear.c - `linkwright simulate --analysis linear`: modes as tables and JSON, at rest and along the
 * motion, and from a free vibration. */
#include "tests/cli_run.h"

/* A double pendulum of two rods of 0.4 m, drawn hanging and drawn to the side */
static const char models[] =
    "printf '%s' '{\"linkwright\": 1, \"units\": {\"length\": \"mm\"}, \"gravity\": [0, -9.81], \"links\": [\"ground\", "
    "{\"name\": \"a\", \"mass\": 3, \"centre\": [0, -400]}, {\"name\": \"b\", \"mass\": 3, \"centre\": [0, -800]}], "
    "\"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0]}, {\"name\": \"B\", "
    "\"links\": [\"a\", \"b\"], \"at\": [0, -400]}], \"input\": {\"joint\": \"A\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"b\", "
    "\"at\": [0, -800]}]}' > $D/hang.json; sed 's/\\[0, -400\\]/[400, 0]/g; s/\\[0, -800\\]/[600, 300]/g' $D/hang.json > $D/side.json; "
    "sed 's/\"mass\": 3/\"mass\": 0/g' $D/hang.json > $D/light.json; sed 's/\"input\".*\"A\"}, //' $D/hang.json > $D/free.json; ";

static double field(const char *row, int n)
{
    for (; row && n > 0; n--)
        row = (row = strchr(row, ',')) ? row + 1 : NULL;
    return row ? strtod(row, NULL) : NAN;
}

TEST(table)
{
    expect(models, 0, NULL, NULL);
    OWN(ran) r = run("$P simulate $D/hang.json --analysis linear --fft");
    CHECK_INT(r.code, 0);
    const char *row = strstr(r.out, "\n1,");
    for (int k = 0; k < 2; k++, row = row ? strchr(row + 1, '\n') : NULL) {
        double want = sqrt((2 + (k ? 1 : -1)*sqrt(2))*9.81/0.4)/(2*3.14159265358979323846);
        CHECK_INT(field(row + 1, 2), k + 1);
        CHECK_NEAR(field(row + 1, 3), want, 0, 1e-10);
        CHECK_NEAR(field(row + 1, 9), want, 0, 5e-3);
    }
    CHECK_HAS(r.err, "2 peaks of the free vibration: within");
    ran_free(&r);
    expect("sed 's/-400/400/g; s/-800/800/g' $D/hang.json > $D/up.json; $P simulate $D/up.json --analysis linear", 0,
           NULL, "the equilibrium is not stable: a mode grows 9.42e+03 times in a second");
    /* what turns at 50 rad/s has other modes than at rest, where they are printed */
    expect("$P simulate examples/elastic-spin-up.json --analysis linear --modes 2 --from 5", 0, NULL, "without centrifugal and gyroscopic forces");
    r = run("$P simulate examples/elastic-spin-up.json --analysis linear --modes 2");
    CHECK_INT(r.code, 0);
    CHECK(strstr(r.err, "centrifugal") == NULL);
    ran_free(&r);
    expect("$P simulate examples/elastic-cantilever.json --formulation radau --to 0.01", 0, NULL, "inner forces, shear and tension most, are less exact");
    expect("sed 's/\"segments\": 16/\"segments\": 4, \"damping\": 1e-5/' examples/elastic-cantilever.json > $D/damped.json", 0, NULL, NULL);
    r = run("$P simulate $D/damped.json --formulation radau --to 0.01");
    CHECK_INT(r.code, 0);
    CHECK(strstr(r.err, "less exact") == NULL);
    ran_free(&r);
    expect("$P simulate $D/damped.json --analysis static", 0, NULL, "of 4 elements, deflections under it may be off by 5 %");
    expect("sed 's/\"segments\": 16/\"frequency\": 30/' examples/elastic-cantilever.json > $D/auto.json; $P simulate $D/auto.json --analysis linear "
           "--modes 3", 0, NULL, "2 modes are above 30 Hz, up to which");
    r = run("$P simulate $D/hang.json --analysis linear --hold");
    row = strstr(r.out, "\n1,");
    CHECK_NEAR(field(row ? row + 1 : "", 3), sqrt(9.81/0.4)/(2*3.14159265358979323846), 0, 1e-10);
    CHECK(row && !strchr(row + 1, '\n')[1]);                     /* the input held: one mode */
}

TEST(rest_and_motion)
{
    expect("$P simulate $D/side.json --analysis linear", 0, NULL, "no equilibrium");
    OWN(ran) r = run("$P simulate $D/side.json --analysis linear --rest --json");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "\"redundant\": 0");
    CHECK_HAS(r.out, "\"link\": \"b\"");
    const char *unbalanced = strstr(r.out, "\"unbalanced\": ");
    CHECK(unbalanced && strtod(unbalanced + 14, NULL) < 1e-9);
    ran_free(&r);
    r = run("$P simulate $D/hang.json --analysis linear --along 8 --hold");
    CHECK_INT(r.code, 0);
    int n = 0;
    for (const char *p = r.out; (p = strchr(p, '\n')); p++)
        n++;
    CHECK_INT(n, 3 + 9);                                         /* comments, heading, a mode in each of 9 postures */
}

/* 20 parallel cranks' loops: (n + 1)/3 + n [kg m^2] turn against a spring, and gravity pushes them down. */
TEST(heard_in_large_models)
{
    expect("awk 'BEGIN {n = 20; q = \"\\\"\"; printf \"{@linkwright@:1,@gravity@:[0,-9.81],@links@:[@ground@\"; "
           "for (i = 0; i <= n; i++) printf \",{@name@:@c%d@,@mass@:1,@centre@:[%d,0.5],@inertia@:%.17g}\", i, i, 1/12; "
           "for (i = 0; i < n; i++) printf \",{@name@:@r%d@,@mass@:1,@centre@:[%.1f,1],@inertia@:0.1}\", i, i + .5; "
           "printf \"],@springs@:[{@joint@:@A0@,@stiffness@:1000}],@joints@:[{@name@:@A0@,@links@:[@ground@,@c0@],@at@:[0,0]}\"; "
           "for (i = 1; i <= n; i++) printf \",{@name@:@A%d@,@links@:[@ground@,@c%d@],@at@:[%d,0]},{@name@:@B%d@,@links@:[@c%d@,"
           "@r%d@],@at@:[%d,1]},{@name@:@C%d@,@links@:[@r%d@,@c%d@],@at@:[%d,1]}\", i, i, i, i, i-1, i-1, i-1, i, i-1, i, i; "
           "print \"]}\"}' | tr @ '\"' > $D/row.json", 0, NULL, NULL);
    OWN(ran) r = run("$P simulate $D/row.json --analysis linear --fft");
    CHECK_INT(r.code, 0);
    const char *row = strstr(r.out, "\n1,");
    double want = sqrt((1000 - 9.81*(10.5 + 20))/(7 + 20.0))/(2*3.14159265358979323846);
    CHECK_NEAR(field(row ? row + 1 : NULL, 3), want, 0, 1e-9);
    CHECK_NEAR(field(row ? row + 1 : NULL, 9), want, 0, 1e-6);
    CHECK_HAS(r.err, "1 peak of the free vibration");
    ran_free(&r);
    /* a top in space; elastic links have other masses in time */
    r = run("$P simulate examples/space/top.json --analysis linear --rest --fft");
    row = strstr(r.out, "\n1,0,2,") ? strstr(r.out, "\n1,0,2,") : strstr(r.out, "\n1,,2,");
    CHECK_NEAR(field(row ? row + 1 : NULL, 9), 1.00658424209, 0, 1e-6);
    expect("$P simulate examples/space/delta-elastic.json --analysis linear --fft", 3, NULL, "lumped masses");
}

/* Neighbours less than a tenth apart: no mode is taken for another one. */
TEST(heard_neighbours)
{
    expect("printf '%s' '{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"a\", \"mass\": 1, \"inertia\": 1, \"centre\": [0, 0]}, "
           "{\"name\": \"b\", \"mass\": 1, \"inertia\": 1, \"centre\": [0, 0]}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", "
           "\"a\"], \"at\": [0, 0]}, {\"name\": \"B\", \"links\": [\"ground\", \"b\"], \"at\": [0, 0]}], \"springs\": [{\"joint\": \"A\", "
           "\"stiffness\": 100}, {\"joint\": \"B\", \"stiffness\": 100}, {\"links\": [\"a\", \"b\"], \"at\": [[1, 0], [1, 1]], "
           "\"stiffness\": 3}]}' > $D/beat.json; $P simulate $D/beat.json --analysis linear --fft > $D/heard", 0, NULL, "2 peaks");
    OWN(ran) r = run("cat $D/heard");
    const char *row = strstr(r.out, "\n1,");
    for (int k = 0; k < 2; k++, row = row ? strchr(row + 1, '\n') : NULL)
        CHECK_NEAR(field(row ? row + 1 : NULL, 9), field(row ? row + 1 : NULL, 3), 0, 1e-5);
}

TEST(wrong_use)
{
    expect("$P simulate $D/free.json --analysis linear --along 4", 3, NULL, "has none");
    expect("$P simulate $D/light.json --analysis linear", 3, NULL, "no mass");
    expect("$P simulate $D/hang.json --along 4", 2, NULL, "--along");
}

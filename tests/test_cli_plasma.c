/* test_cli_plasma.c - `linkwright plasma`: every step is reported, and its tables agree with each other and with
 * the saved linkage. */
#include "tests/cli_run.h"

#include "catalogues/exchange/adams.h"
#include "catalogues/exchange/export.h"
#include "mbs/constraints/newton.h"

static const char whole[] =
    "$P plasma $D/lam.txt --target examples/ellipse.csv --points 401 --budget 2e4 --first 40 --save $D/out";

TEST(every_step_of_a_four_bar)
{
    expect("printf '0 1 0 2\\n0 0 3 0\\n0 0 0 4\\n0 0 0 0\\n' > $D/lam.txt", 0, NULL, NULL);
    OWN(ran) r = run(whole);
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.out, "0 1 0 2\n0 0 3 0\n0 0 0 4\n0 0 0 0\n\nParts: 4 Joints: 4\n");
    CHECK_HAS(r.out, "  Jnt  Prt1  Prt2  Mar1  Mar2  Jtyp ");
    CHECK_HAS(r.out, "\n    1     1     2   101   201    11 ");
    CHECK_HAS(r.out, "\n    4     3     4   302   402    11 ");
    CHECK_HAS(r.out, "\nJOINT/01, REVOLUTE, I = 0201, J = 0101\n");
    CHECK_HAS(r.out, "First dimensions, objective ");
    CHECK_HAS(r.out, "Accelerations of the joints:");
    CHECK_HAS(r.out, "Final dimensions:");
}

/* Rows of the path of the first linkage: position, velocity, acceleration. */
typedef struct row { double t, p[2], v, vx, vy, a, ax, ay; } row;

static int read_rows(const char *from, row *rows, int most)
{
    int n = 0, number, skip;
    const char *at = strstr(from, "AccY\n");
    for (at = at ? at + 5 : ""; n < most; n++, at += skip) {
        row *w = &rows[n];
        if (sscanf(at, "%d %lf %lf %lf %lf %lf %lf %lf %lf %lf\n%n", &number, &w->t, &w->p[0], &w->p[1], &w->v, &w->vx,
                   &w->vy, &w->a, &w->ax, &w->ay, &skip) != 10)
            break;
        CHECK_INT(number, n + 1);
    }
    return n;
}

/* Differences of positions are velocities, differences of velocities accelerations; the saved linkage has the same
 * positions. */
static void check_motion(const char *text, const char *model)
{
    static row rows[401];
    static lw_linkage k;
    lw_newton *s = NULL;
    CHECK_INT(read_rows(text, rows, 401), 401);
    double fast = 0, hard = 0, h = 2.0/400;
    for (int i = 0; i < 401; i++) {
        fast = fmax(fast, rows[i].v);
        hard = fmax(hard, rows[i].a);
        CHECK_NEAR(hypot(rows[i].vx, rows[i].vy), rows[i].v, 1e-3*rows[i].v, 0);
        CHECK_NEAR(hypot(rows[i].ax, rows[i].ay), rows[i].a, 1e-3*rows[i].a, 0);
    }
    for (int i = 1; i < 400; i++) {
        CHECK_NEAR(rows[i].vx, (rows[i + 1].p[0] - rows[i - 1].p[0])/h, 0.02*fast, 0);
        CHECK_NEAR(rows[i].vy, (rows[i + 1].p[1] - rows[i - 1].p[1])/h, 0.02*fast, 0);
        CHECK_NEAR(rows[i].ax, (rows[i + 1].vx - rows[i - 1].vx)/h, 0.02*hard, 0);
        CHECK_NEAR(rows[i].ay, (rows[i + 1].vy - rows[i - 1].vy)/h, 0.02*hard, 0);
    }
    OWN(ran) r = run_with("cat $D/%s", model);
    OWN(lw_assembly) parts = { 0 };
    CHECK_OK(lw_adams_read(r.out, strlen(r.out), "t", &parts, &check_error));
    CHECK_OK(lw_assembly_linkage(&parts, &k, &check_error));
    CHECK_OK(lw_newton_create(&k, &s, &check_error));
    lw_export_law law;
    CHECK_INT(lw_export_law_of(LW_VIEW(&k), NULL, 0, &law), LW_OK);
    for (int i = 0; s && i < 401; i += 8) {
        double a = 2*LW_PI*rows[i].t;
        double u = law.turns ? a : law.half*(sin(a + law.phase) - sin(law.phase));
        CHECK_INT(lw_newton_move(s, k.input[0].value + u, NULL), LW_OK);
        lw_vec2 p = lw_newton_tracer(s, 0);
        CHECK_NEAR(1e3*p.x, rows[i].p[0], 1e-3*(fast + fabs(rows[i].p[0])), 0);    /* time has three digits */
        CHECK_NEAR(1e3*p.y, rows[i].p[1], 1e-3*(fast + fabs(rows[i].p[1])), 0);
    }
    lw_newton_free(s);
}

TEST(motions_agree)
{
    OWN(ran) r = run(whole);
    check_motion(r.out, "out/first.adm");
    const char *final = strstr(r.out, "Final dimensions:");
    CHECK(final != NULL);
    check_motion(final ? final : "", "out/final.adm");
    expect("$P trace $D/out/final.json -n 5 && grep -q final.adm $D/out/final.acf", 0, NULL, NULL);
}

/* A six-bar with any numbering of its joints, a slider, another ground link. */
TEST(other_mechanisms)
{
    expect("printf '0 7 0 2 0 3\\n0 0 1 0 0 0\\n0 0 0 4 5 0\\n0 0 0 0 0 0\\n0 0 0 0 0 6\\n0 0 0 0 0 0\\n' > $D/six.txt;"
           "$P plasma $D/six.txt --target examples/ellipse.csv --points 3 --budget 1e4 --first 30", 0,
           "\n    7     1     2 ", NULL);
    expect("printf '0 1 0 4t\\n0 0 2 0\\n0 0 0 3\\n0 0 0 0\\n' > $D/slide.txt;"
           "$P plasma $D/slide.txt --target examples/ellipse.csv --points 3 --budget 1e4 --first 30", 0,
           "    4     1     4   102   402    12 ", NULL);
    expect("$P plasma $D/slide.txt --target examples/ellipse.csv --points 3 --budget 1e4 --first 30 --ground 3", 0,
           "PART/03, GROUND", NULL);
    expect("$P plasma $D/slide.txt --target examples/ellipse.csv --points 3 --budget 1e4 --first 30 --input-joint 4", 0,
           "MOTION/01, JOINT = 04, TRANSLATION", NULL);
    expect("for j in 1 2; do $P plasma $D/lam.txt --target examples/ellipse.csv --points 3 --budget 1e4 --first 30"
           " --jobs $j > $D/j$j; done; cmp $D/j1 $D/j2", 0, NULL, NULL);
}

TEST(refusals)
{
    expect("$P plasma $D/lam.txt", 2, NULL, "--target is missing");
    expect("$P plasma $D/lam.txt --target nowhere.csv", 3, NULL, "nowhere.csv");
    expect("$P plasma $D/lam.txt --target examples/function-log.csv", 3, NULL, "must be a path");
    expect("$P plasma $D/lam.txt --target examples/ellipse.csv --ground 5", 3, NULL, "there is no part 5");
    expect("$P plasma $D/lam.txt --target examples/ellipse.csv --input-joint 5", 3, NULL, "there is no joint 5");
    expect("$P plasma $D/lam.txt --target examples/ellipse.csv --tracer-link 1", 3, NULL, "which is the ground");
    expect("echo '0 1 3;0 0 2;0 0 0' | $P plasma --target examples/ellipse.csv", 3, NULL, "has 0 degrees of freedom");
    expect("echo '0 1 x' | $P plasma --target examples/ellipse.csv", 3, NULL, ":1:5:");
    expect("echo '0 1 x' | $P plasma --target examples/ellipse.csv -o $D/never; test ! -e $D/never", 0, NULL, NULL);
}

/* test_bench.c - `linkwright bench fit`: its CSV reads back and is consistent, its plots exist, wrong calls are
 * refused. */
#include "tests/check.h"
#include "tests/cli_run.h"

#define ROWS 4096

typedef struct row { char problem[64], solver[32]; long seed, evals; double seconds, objective; } row;

static char *read_file(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", getenv("D") ? getenv("D") : "", name);
    return slurp(path);
}

/* Every line other than comments and heading has six fields. */
static int read_curves(const char *name, row *r)
{
    char *text = read_file(name), *rest = text;
    int n = 0, headers = 0;
    for (char *line; (line = strsep(&rest, "\n")) && n < ROWS;) {
        if (*line == 0 || *line == '#')
            continue;
        if (strcmp(line, "problem,solver,seed,evals,seconds,objective") == 0) {
            headers++;
            continue;
        }
        row *q = &r[n++];
        CHECK_INT(sscanf(line, "%63[^,],%31[^,],%ld,%ld,%lf,%lf", q->problem, q->solver, &q->seed,
                         &q->evals, &q->seconds, &q->objective), 6);
    }
    CHECK_INT(headers, 1);
    free(text);
    return n;
}

static void write_problem(void)
{
    expect("mkdir -p $D/own && printf 'x,y\\n0,0\\n1,0.5\\n2,0.4\\n1.5,-0.2\\n' > $D/own/four.csv", 0, NULL, NULL);
}

TEST(curves_fall)
{
    static row r[ROWS];
    expect("LW_CLOCK_STEP=0.01 $C bench fit --seeds 0 --time 10 --solvers lm,slsqp,crs --seed 3 -o $D/out", 0,
           "| solver | line6 | arc5 | arch6 |", "");
    int n = read_curves("out/curves.csv", r);
    CHECK(n > 100);
    for (int i = 0; i < n; i++) {
        CHECK(r[i].seed == 3 && r[i].evals > 0 && r[i].seconds > 0 && r[i].objective >= 0);
        if (i == 0 || strcmp(r[i].problem, r[i - 1].problem) || strcmp(r[i].solver, r[i - 1].solver))
            continue;
        CHECK(r[i].objective < r[i - 1].objective);
        CHECK(r[i].evals >= r[i - 1].evals && r[i].seconds >= r[i - 1].seconds);
    }
}

TEST(files_say_where_they_come_from)
{
    static const char *const names[] = { "curves.csv", "reach.csv" };
    for (int i = 0; i < 2; i++) {
        char path[64];
        snprintf(path, sizeof path, "out/%s", names[i]);
        FREED char *text = read_file(path);
        CHECK_HAS(text, "# linkwright bench fit --seeds 0 ");
        CHECK_HAS(text, " | linkwright ");
    }
    FREED char *plot = read_file("out/closed18.svg");
    CHECK_HAS(plot, "<svg");
    CHECK_HAS(plot, "reachable");
    CHECK_HAS(plot, "Kunjur");
    CHECK_HAS(plot, "slsqp");
}

/* A run that stops later repeats the improvements of a shorter one with the same seed. The fit that the time limit
 * cuts off may differ. */
TEST(same_seed_same_way)
{
    static row a[ROWS], b[ROWS];
    write_problem();
    expect("LW_CLOCK_STEP=0.01 $C bench fit --problems $D/own --seeds 0 --time 10 --solvers lm -o $D/first -q", 0, "four", "");
    expect("LW_CLOCK_STEP=0.01 $C bench fit --problems $D/own --seeds 0 --time 20 --solvers lm -o $D/second -q", 0, "four", "");
    int n = read_curves("first/curves.csv", a), m = read_curves("second/curves.csv", b);
    CHECK(n > 0 && m > 0);
    for (int i = 0; i < n && i < m && a[i].seconds < 10; i++) {
        CHECK_INT(a[i].evals, b[i].evals);
        CHECK_NEAR(a[i].objective, b[i].objective, 0, 0);
    }
}

TEST(default_strategy_reaches)
{
    expect("mkdir -p $D/one && cp catalogues/data/paths/arc5.csv $D/one", 0, NULL, NULL);
    expect("$P bench fit --problems $D/one --solvers none --seeds 2 --reach-time 1e4 -j 2 -o $D/reach", 0, "| 2 of 2 |", "");
    FREED char *text = read_file("reach/reach.csv");
    CHECK_HAS(text, "problem,figure,seed,evals,seconds,objective,reached\narc5,7.4158e-07,1,");
    CHECK_HAS(text, "\narc5,7.4158e-07,2,");
}

TEST(bad_calls)
{
    expect("$P bench", 2, "", "a word is missing");
    expect("$P bench fits", 2, "", "there is no action 'fits'");
    expect("$P bench fit --solvers lm,slsq", 2, "", "did you mean 'slsqp'?");
    expect("$P bench fit --solvers lm,lm", 2, "", "names 'lm' twice");
    expect("$P bench fit --json", 2, "", "--json has no meaning here");
    expect("$P bench fit --time 0", 2, "", "out of range");
    expect("$P bench fit --problems $D/nowhere", 3, "", "nowhere: this folder of problems cannot be read");
    expect("mkdir -p $D/empty && $P bench fit --problems $D/empty", 3, "", "no CSV file of points in this folder");
    expect("mkdir -p $D/odd && printf 'angle,theta\\n0,0\\n1,1\\n' > $D/odd/f.csv && $P bench fit --problems $D/odd", 3,
           "", "odd/f.csv: a path is wanted");
    expect("printf 'x,y\\n0,zero\\n' > $D/odd/f.csv && $P bench fit --problems $D/odd", 3, "", "f.csv:2:3:");
    expect("$P bench fit --problems $D/one --solvers none --seeds 0 -o /dev/null/x", 3, "", "cannot be made");
}

/* `linkwright bench mbs` from outside: errors that fall with the tolerance, files that read back, wrong use. */
#include <math.h>
#include "tests/cli_run.h"

typedef struct row { char problem[32], solver[40]; double tolerance, setup, seconds, error; } row;

static int read_rows(row *r, int most)
{
    char path[256], *text, *rest;
    int n = 0;
    snprintf(path, sizeof path, "%s/out/mbs.csv", getenv("D"));
    text = rest = slurp(path);
    for (char *line; (line = strsep(&rest, "\n")) && n < most;)
        if (*line && *line != '#' && strncmp(line, "problem,", 8))
            n += sscanf(line, "%31[^,],%39[^,],%lf,%lf,%lf,%lf", r[n].problem, r[n].solver, &r[n].tolerance, &r[n].setup,
                        &r[n].seconds, &r[n].error) == 6;
    free(text);
    return n;
}

static double error_of(const row *r, int n, const char *problem, const char *solver, double tolerance)
{
    for (int i = 0; i < n; i++)
        if (!strcmp(r[i].problem, problem) && !strcmp(r[i].solver, solver) && fabs(r[i].tolerance/tolerance - 1) < 1e-6)
            return r[i].error;
    return NAN;
}

static void rows(void)
{
    static row r[200];
    expect("$P bench mbs --cases pendulum --time 0.001 -o $D/out", 0, "| reduced | 1e-10 |", "");
    int n = read_rows(r, 200);
    CHECK_INT(n, 10 + 10 + 9 + 9);
    for (int i = 0; i < n; i++)
        CHECK(r[i].setup > 0 && r[i].seconds > 0 && r[i].error > 0);
    CHECK(error_of(r, n, "pendulum", "reduced", 1e-13) < 1e-11);
    CHECK(error_of(r, n, "pendulum", "index1", 1e-13) < 1e-12);
    for (int k = 4; k < 10; k += 3) {                        /* three decades of tolerance give one of error at least */
        double loose = error_of(r, n, "pendulum", "ggl", pow(10, -k));
        CHECK(error_of(r, n, "pendulum", "ggl", pow(10, -k - 3)) < 0.1*loose);
    }
    expect("cat $D/out/mbs.csv", 0, "# linkwright bench mbs --cases", NULL);
    expect("cat $D/out/mbs-pendulum.svg", 0, "index1", NULL);
}

static void squeezer(void)
{
    static row r[200];
    expect("$P bench mbs -c andrews --tolerance 1e-11:1e-10 --time 0.001 -o $D/out -q", 0, "| andrews | ggl |", "");
    int n = read_rows(r, 200);
    CHECK_INT(n, 8);
    CHECK(error_of(r, n, "andrews", "reduced", 1e-11) < 1e-9);
    CHECK(error_of(r, n, "andrews", "index1", 1e-11) < 1e-10);
    CHECK(error_of(r, n, "andrews", "cvode", 1e-11) < 1e-7);
    CHECK(error_of(r, n, "andrews", "ggl", 1e-11) < 1e-7);
}

/* By place and branch, through the singular postures. */
static void branch(void)
{
    static row r[200];
    expect("$P bench mbs -c two-four-bars --tolerance 1e-10:1e-8 --time 0.001 -o $D/out -q", 0, "| two-four-bars | reduced |", "");
    int n = read_rows(r, 200);
    CHECK(error_of(r, n, "two-four-bars", "reduced", 1e-10) < 1e-6);
    CHECK(error_of(r, n, "two-four-bars", "index1", 1e-8) < 1e-3);
}

static void clearance(void)
{
    expect("$P bench mbs -c clearance-250 --tolerance 1e-9:1e-9 --time 0.001 -q", 0, "| clearance-250 | impact K=1e+08 | 1e-09 |", "");
}

static void wrong_use(void)
{
    expect("$P bench mbs --cases andrew", 2, NULL, "did you mean 'andrews'");
    expect("$P bench mbs --json", 2, NULL, "--json has no meaning here");
    expect("$P bench mbz", 2, NULL, "there are 'fit' and 'mbs'");
}

int main(void)
{
    RUN(rows);
    RUN(squeezer);
    RUN(branch);
    RUN(clearance);
    RUN(wrong_use);
    return check_end();
}

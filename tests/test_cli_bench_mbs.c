/* test_cli_bench_mbs.c - `linkwright bench mbs`: errors that fall with the tolerance, files that read back, wrong
 * use. */
#include <math.h>
#include "tests/bench/peer.h"
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
            n += sscanf(line, "%31[^,],%39[^,],%lf,%lf,%lf,%lf", r[n].problem, r[n].solver, &r[n].tolerance,
                        &r[n].setup, &r[n].seconds, &r[n].error) == 6;
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

TEST(rows)
{
    static row r[200];
    expect("LW_CLOCK_STEP=0.001 $C bench mbs --peers none --cases pendulum --time 0.001 -o $D/out", 0, "| reduced | 1e-10 |", "");
    int n = read_rows(r, 200);
    CHECK_INT(n, 10 + 10 + 10 + 9 + 9);
    CHECK(error_of(r, n, "pendulum", "quadrature", 1e-11) < 1e-12);
    for (int i = 0; i < n; i++)
        CHECK(r[i].setup > 0 && r[i].seconds > 0 && r[i].error > 0);
    CHECK(error_of(r, n, "pendulum", "reduced", 1e-13) < 1e-11);
    CHECK(error_of(r, n, "pendulum", "index1", 1e-13) < 1e-12);
    for (int k = 4; k < 10; k += 3) {                        /* a tolerance 1000 times smaller makes the error at least 10 times smaller */
        double loose = error_of(r, n, "pendulum", "ggl", pow(10, -k));
        CHECK(error_of(r, n, "pendulum", "ggl", pow(10, -k - 3)) < 0.1*loose);
    }
    expect("cat $D/out/mbs.csv", 0, "# linkwright bench mbs --peers none --cases", NULL);
    expect("cat $D/out/mbs-pendulum.svg", 0, "index1", NULL);
}

TEST(squeezer)
{
    static row r[200];
    expect("LW_CLOCK_STEP=0.001 $C bench mbs --peers none --cases andrews --tolerance-range 1e-11:1e-10 --time 0.001 -q -o $D/out", 0,
           "| andrews | ggl |", "");
    int n = read_rows(r, 200);
    CHECK_INT(n, 10);
    CHECK(error_of(r, n, "andrews", "quadrature", 1e-10) < 1e-11);
    CHECK(error_of(r, n, "andrews", "reduced", 1e-11) < 1e-9);
    CHECK(error_of(r, n, "andrews", "index1", 1e-11) < 1e-10);
    CHECK(error_of(r, n, "andrews", "cvode", 1e-11) < 1e-7);
    CHECK(error_of(r, n, "andrews", "ggl", 1e-11) < 1e-7);
}

/* The error counts the assembly mode too; the motion passes singular postures. */
TEST(branch)
{
    static row r[200];
    expect("LW_CLOCK_STEP=0.001 $C bench mbs --peers none --cases two-four-bars --tolerance-range 1e-10:1e-8 --time 0.001 -q -o $D/out", 0,
           "| two-four-bars | reduced |", "");
    int n = read_rows(r, 200);
    CHECK(error_of(r, n, "two-four-bars", "reduced", 1e-10) < 1e-6);
    CHECK(error_of(r, n, "two-four-bars", "index1", 1e-8) < 1e-3);
}

TEST(clearance)
{
    expect("LW_CLOCK_STEP=0.001 $C bench mbs --peers none --cases clearance-250 --tolerance-range 1e-9:1e-9 --time 0.001 -q", 0,
           "| clearance-250 | impact K=1e+08 | 1e-09 |", "");
}

/* ---- other programs, played by scripts --------------------------------------------------------------------------- */

#define PLACES "awk -F, '/^[0-9]/ { print $2, $3, 0 }' catalogues/data/mbs/pendulum.csv"
#define PEER(name, script) "mkdir -p $D/" name " && printf '%s\\n' '#!/bin/sh' \"" script "\" > $D/" name "/p && " \
                           "chmod +x $D/" name "/p && " \
                           "$P bench mbs --cases pendulum --tolerance-range 1e-4:1e-4 --time 0.001 -q " \
                           "-o $D/out --peers $D/" name

/* The model given to the other program, and the row made of its answer, here the exact positions. */
TEST(told_and_measured)
{
    static row r[200];
    static const char *const said[] = { "gravity 0 -9.8", "body 1 0 -1 0 0 bob\n", "pin 0 1 0 0\n", "run 10 101 ",
                                        "mjcf\n<mujoco" };
    expect("cat > $D/exact.sh << 'END'\n#!/bin/sh\ncat > $D/scene\necho 'run 1e-3 0.002 0.003 17 99 by heart'\n"
           PLACES "\necho 'fail 1e-6 by heart: forgotten'\nEND\nmkdir -p $D/good && mv $D/exact.sh $D/good/clever && "
           "chmod +x $D/good/clever && "
           "$P bench mbs --cases pendulum --tolerance-range 1e-4:1e-4 --time 0.001 -q -o $D/out --peers $D/good", 0,
           "| pendulum | clever by heart | 1e-06 | - | - | - | - | - | 0 | 0 | forgotten |", "");
    int n = read_rows(r, 200);
    CHECK_INT(n, 6);
    CHECK_TEXT(r[5].solver, "clever by heart");
    CHECK_NEAR(r[5].setup, 0.002, 0, 0);
    CHECK_NEAR(r[5].seconds, 0.003, 0, 0);
    CHECK(r[5].error < 1e-15);
    expect("cat $D/out/mbs-pendulum.svg", 0, "clever by heart", NULL);
    OWN(ran) scene = run("cat $D/scene");
    for (int i = 0; i < 5; i++)
        CHECK_HAS(scene.out, said[i]);
}

/* A program that fails has a row with the reason, and the rows of the others are not affected. */
TEST(bad_peers)
{
    static const char nonsense[] = "| pendulum | p | - | - | - | - | - | - | 0 | 0 | what it says is no row of numbers |";
    expect(PEER("talks", "echo hello"), 0, nonsense, "");
    expect(PEER("fails", "exit 7"), 0, "| ended with code 7 |", "");
    expect(PEER("dies", "kill -9 \\$\\$"), 0, "| ended by signal 9 |", "");
    expect(PEER("silent", "true"), 0, nonsense, "");
    expect(PEER("short", "echo run 1 1 1 1 1 it; echo 1 2 3"), 0, nonsense, "");
    expect(PEER("naught", "echo run 1 1 1 1 1 it; yes nan | head -400"), 0, nonsense, "");
    expect(PEER("short", "echo run 1 1 1 1 1 it; echo 1 2 3"), 0, "| pendulum | reduced | 1e-04 |", "");
    expect("$P bench mbs --peers $D/nowhere", 3, NULL, "nowhere: no such folder");
    expect("mkdir -p $D/empty && touch $D/empty/readme && $P bench mbs --peers $D/empty", 3, NULL, "no program in this folder");
}

/* A program that does not end in time keeps the rows it has given, and the programs and problems after it have theirs. */
TEST(slow_peers)
{
    ran r = run("mkdir -p $D/two && printf '%s\\n' '#!/bin/sh' 'echo fail 1e-3 quick: it is there' 'exec sleep 100' > $D/two/a && "
                "printf '%s\\n' '#!/bin/sh' 'echo fail 1e-3 next: it is there' > $D/two/b && chmod +x $D/two/a $D/two/b && "
                "LW_CLOCK_STEP=100 $C bench mbs --cases pendulum,andrews --tolerance-range 1e-4:1e-4 --time 0.001 -q --peers $D/two");
    for (int k = 0; k < 2; k++) {
        static const char *const wanted[] = { "| %s | a quick | 1e-03 | - | - | - | - | - | 0 | 0 | it is there |",
                                              "| %s | a | - | - | - | - | - | - | 0 | 0 | ended after 300 s |", "| %s | b next | 1e-03 |" };
        for (int i = 0; i < 3; i++) {
            char line[128];
            snprintf(line, sizeof line, wanted[i], k ? "andrews" : "pendulum");
            CHECK_HAS(r.out, line);
        }
    }
    CHECK_INT(r.code, 0);
    ran_free(&r);
}

static double wait_for_ever(void *context)
{
    (void)context;
    for (;;)
        pause();
    return 0;
}

static double answer(void *context)
{
    printf("run %s\n", (const char *)context);
    return 0;
}

/* A row of a peer that never ends loses itself only. */
TEST(slow_rows)
{
    FREED peer_scene *scene = calloc(1, sizeof *scene);
    char said[200] = "";
    int ends[2];
    if (!scene || pipe(ends) != 0)
        return;
    scene->longest = 0.01;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], 1);
        bool lost = peer_apart(scene, wait_for_ever, NULL, 1e-3, "one");
        bool kept = !peer_apart(scene, answer, "two", 1e-4, "one");
        fflush(stdout);
        _exit(lost && kept ? 0 : 1);
    }
    close(ends[1]);
    int status = 1, n = 0;
    for (ssize_t got; (got = read(ends[0], said + n, sizeof said - 1 - (size_t)n)) > 0; n += (int)got)
        ;
    close(ends[0]);
    waitpid(child, &status, 0);
    CHECK_INT(status, 0);
    CHECK_TEXT(said, "fail 0.001 one: not at the end after 1 s\nrun two\n");
}

TEST(models_of_choice)
{
    expect("$P bench mbs --peers none --cases choice:slack --tolerance-range 1e-4:1e-4 --time 0.001 -q -o $D/hard", 0,
           "| rope goes slack | index1 |", NULL);
    expect("cat $D/hard/mbs-choice.svg", 0, "capture", NULL);
    expect("$P bench mbs --peers none --cases choice:slack --tolerance-range 1e-4:1e-4 --time 0.001 -q | grep -c '| pendulum'", 1, "0", NULL);
}

TEST(wrong_use)
{
    expect("$P bench mbs --cases choice:nothing", 2, NULL, "no model of choice has this text in its name");
    expect("$P bench mbs --cases andrew", 2, NULL, "did you mean 'andrews'");
    expect("$P bench mbs --json", 2, NULL, "--json has no meaning here");
    expect("$P bench mbz", 2, NULL, "did you mean 'mbs'?");
}

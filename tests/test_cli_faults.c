/* test_cli_faults.c - a call of the system fails: the command ends with code 3 or 4 and a message, or with all output.
 * The same holds with few files, files of no size, and little memory.
 *
 * One row a command, with measured times taken out of what it prints.  Each row runs undisturbed first, which tells
 * how often each kind of call is made (tests/fail_at_call.c), then once for each call that fails.  Of many calls a
 * spread is taken: the first N_FIRST, then ever longer steps; fewer of searches.  LW_FAULTS=n makes the spread n times as dense;
 * LW_FAULTS_ROW=text runs the rows that hold the text. */
#include <stdbool.h>
#include "tests/cli_run.h"

enum { N_FIRST = 24, N_FIRST_OF_SEARCH = 3, MEMORY_ERROR = 4, WRITE_ERROR = 3 };

/* $C commands write to standard output or to $D/o, which is removed before each run. */
static const char *const rows[] = {
    "$C numbers --loops 4",
    "$C structures --loops 3",
    "$C chains --links 6 -j 1",
    "$C chains --links 6 -j 2 -o $D/o",
    "$C mechanisms --links 6 --joints r,t",
    "$C mechanisms < $D/watt.g6",
    "$C mechanisms --joints r,t --json < $D/watt.g6",
    "$C grammar parse < $D/watt.g6",
    "$C grammar print < $D/watt.g6",
    "$C grammar explain < $D/watt.g6",
    "$C grammar derive --links 6",
    "$C grammar coverage --links 6",
    "$C classify 40 10 35 30",
    "$C trace examples/jansen.json -n 8",
    "$C trace examples/klann.json -n 8 --json -o $D/o",
    "$C mobility examples/jansen.json",
    "$C simulate examples/dynamics/governor.json --to 0.01 -n 4",
    "$C simulate examples/pendulum.json --to 0.1 -n 4 -o $D/o",
    "$C simulate examples/pendulum.json --analysis linear",
    "$C convert examples/jansen.json --format pyslvs",
    "$C convert examples/chebyshev.json -o $D/o --format dxf",
    "$C draw examples/jansen.json -f svg -o $D/o",
    "$C draw examples/chebyshev.json -f html -o $D/o",
    "$C draw --grid 2x1 -f svg -o $D/o < $D/watt.g6",
    "$C clearance examples/clearance-four-bar.json --speeds 80 --to 0.02 --settle 0.01",
    "rm -f $D/a.db; $C catalogue build $D/a.db --links 6 -q -j 1 && $P catalogue export $D/a.db",
    ("rm -f $D/a.db; $C catalogue curves $D/a.db --links 4 --samples 40 -q -j 1 && "
     "$P catalogue nearest $D/a.db examples/ellipse.csv"),
    "$C catalogue query $D/six.db 'links=6'",
    "$C catalogue query $D/six.db 'links=6' -f csv -o $D/o",
    "$C catalogue query $D/six.db 'SELECT count(*) FROM chain' --sql",
    "$C catalogue export $D/six.db -f lam",
    "$C catalogue nearest $D/curves.db examples/ellipse.csv",
    "$C catalogue check $D/six.db",
    "rm -f $D/a.db; $C catalogue add $D/a.db $D/fit.json && $P catalogue query $D/a.db error\\<1",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --starts 1 --rounds 1 --results 2 -j 1 --json -o $D/o",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --starts 1 --rounds 1 --results 2 -j 2 -q",
    "LW_CLOCK_STEP=1e-9 $C fit $D/five.csv --exact -j 1 --json -q",
    "rm -rf $D/web; $C catalogue html $D/six.db -o $D/web -q && cat $D/web/*.html",
    "$C profile 2 --speed-limit 1 --acceleration-limit 20 -o $D/o",
    "$C profile 1 --acceleration-limit 20 --jerk-limit 400",
    "$C trace tests/data/linkages/triad-eight-bar.json -n 4",
    "$C draw tests/data/linkages/triad-eight-bar.json -f svg -o $D/o",
    "$C plasma $D/four.lam --target $D/five.csv --first 5 --budget 1000 --points 4 -q",
    "$C plasma $D/four.lam --target $D/five.csv --first 5 --budget 1000 --points 4 -q --save $D/out -o $D/o --force",
    "$C bench fit --problems $D/problems --solvers lm --seeds 0 --time 0.01 -o $D/out -q > $D/table && ls $D/out",
    "$C bench mbs --cases pendulum --tolerance-range 1e-4:1e-4 --peers none -o $D/out -q > $D/table && ls $D/out",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --links 6 --topology watt1 --budget 1000 --starts 1 --rounds 1 --results 1 -j 2 -q",
    "rm -rf $D/release; $C catalogue release -o $D/release --links 7 -q && cat $(find $D/release -type f | sort)",
    "$C drive load examples/drives/lifting-arm.json --to 0.1",
    "$C drive load examples/drives/lifting-arm.json --to 0.1 --plot $D/o.svg --force",
    "$C drive simulate examples/drives/servo-axis.json -n 8",
    "$C drive select examples/drives/lifting-arm.json --to 2.5 -n 20 --motors examples/drives/motors.csv --gears examples/drives/gears.csv",
    "$C drive radius examples/drives/motors.csv --mass 20 --way 1 --json",
    "$C profile examples/cycles/gantry.json",
    "$C family expand examples/families/loader.json -o $D/o",
    "$C family table examples/families/loader.json",
    "$C family check examples/families/loader.json",
    "$C family sweep examples/families/loader.json --vary reach=2:3:3 -n 10 -j 2",
    "$C family optimise examples/families/loader.json --vary reach=2:3 --minimise boom_mass --max-evaluations 20",
    "$C robot jacobian examples/space/stewart.json",
    "$C robot budget examples/space/delta-clearance.json",
    "$C robot workspace examples/space/delta.json --rays 3 -o $D/o",
    "$C robot map examples/space/delta.json --places 3",
    "$C robot map examples/space/delta-elastic.json --eigenfrequency --places 3 --plot $D/o.svg --force",
    "$C trace examples/space/bricard.json -n 4",
    "$C trace examples/klann.json -n 8 --geometry --plot $D/o.svg --force",
    "$C mobility examples/space/sarrus.json",
    "$C simulate examples/space/governor.json --to 0.01 -n 2",
    "$C draw examples/space/delta.json -f svg -o $D/o",
    "$C draw examples/space/bricard.json -f html -n 4 -o $D/o",
    "$C draw examples/hoeken.json examples/chebyshev.json -f svg -o $D/o",
    "$C draw examples/hoeken.json -f gif -n 4 -o $D/o && cksum < $D/o",
    "$C draw examples/hoeken.json -f png -o $D/o && cksum < $D/o",
    "$C draw examples/hoeken.json -f pdf -o $D/o && cksum < $D/o",
    "$C simulate examples/elastic-cantilever.json --to 0.001 -n 2",
    "$C simulate examples/elastic-frame.json --analysis static",
    "$C simulate examples/dynamics/boxes.json --to 0.01 -n 2",
    "$C simulate examples/dynamics/boom-cylinder.json --to 0.01 -n 2",
    "$C simulate examples/space/governor.json --to 0.01 -n 4 --plot $D/o.svg --gif $D/o.gif --force",
    "$C drive simulate examples/drives/servo-axis.json -n 8 --bode $D/o.svg --matrices-folder $D/out --force",
    "$C profile 0.5 0.3 -0.8 --acceleration-limit 2 --dwell 0.2",
    "$C mechanisms --links 6 --multiple-joints",
    "rm -f $D/a.db; $C catalogue add $D/a.db $D/curves.db -q && $P catalogue nearest $D/a.db examples/ellipse.csv",
    "XDG_STATE_HOME=$D XDG_CACHE_HOME=$D tests/studio_ask.py $D/bin/linkwright studio --no-browser -q --atlas $D/curves.db",
    "$D/bin/linkwright gallery klann",
};

TEST(every_command_has_its_row)
{
    char words[64][48], part[2][64];
    for (int i = 0, n = all_commands(words, 64); i < n; i++) {
        int found = 0;
        snprintf(part[0], sizeof part[0], "$C %.47s ", words[i]);
        snprintf(part[1], sizeof part[1], "bin/linkwright %.47s ", words[i]);
        for (size_t k = 0; k < sizeof rows/sizeof *rows; k++)
            found += strstr(rows[k], part[0]) || strstr(rows[k], part[1]);
        if (!found)
            fprintf(stderr, "'%s' has no row\n", words[i]);
        CHECK(found);
    }
}

static const char *const kinds[] = { "malloc", "fsync", "rename", "pthread_create", "write", "jansson", "sqlite" };

static ran run_once(const char *command, char **file)
{
    char line[1200], path[300];
    snprintf(line, sizeof line, "rm -f $D/o $D/o.partial; %s", command);
    ran r = run(line);
    snprintf(path, sizeof path, "%s/o", getenv("D"));
    *file = slurp(path);
    return r;
}

/* How often the kind of call is made in an undisturbed run. */
static long count_calls(const char *kind)
{
    char path[300];
    long n = 0;
    snprintf(path, sizeof path, "%s/calls", getenv("D"));
    char *text = slurp(path), *at = strstr(text, kind);
    if (at)
        n = atol(at + strlen(kind));
    free(text);
    return n;
}

/* Run the command while something fails: the same output with code 0, or the reason with another. */
static void disturb(const char *command, const char *by, const ran *whole, const char *whole_file)
{
    char *file;
    ran r = run_once(command, &file);
    bool same = r.code == whole->code && strcmp(r.out, whole->out) == 0 && strcmp(file, whole_file) == 0;
    bool said = (r.code == MEMORY_ERROR || r.code == WRITE_ERROR) && strstr(r.err, "linkwright") != NULL;
    bool kept = file[0] == 0 || strcmp(file, whole_file) == 0 || strstr(file, "\"complete\": false") != NULL;
    if (!kept)
        fprintf(stderr, "$D/o is not whole: ");
    if (!kept || (!same && !said))
        fprintf(stderr, "%s %s\n  ended with %d, output %s, and said: %s\n", by, command, r.code,
                strcmp(r.out, whole->out) ? "differs" : "is the same", r.err);
    CHECK(kept && (same || said));
    ran_free(&r);
    free(file);
}

static void fail_one(const char *command, const char *kind, long n, const ran *whole, const char *whole_file)
{
    char fault[64];
    snprintf(fault, sizeof fault, "%s:%ld", kind, n);
    setenv("LW_FAIL", fault, 1);
    disturb(command, fault, whole, whole_file);
    unsetenv("LW_FAIL");
}

#if !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__        /* which need files and terabytes themselves */
static const char *const limits[] = { "--nofile=4", "--nofile=6", "--fsize=0", "--data=2000000", "--data=10000000" };

static void limit_each(const char *command, const ran *whole, const char *whole_file)
{
    char limited[600], program[300];
    snprintf(program, sizeof program, "%s", getenv("C"));
    for (size_t k = 0; k < sizeof limits/sizeof *limits; k++) {
        snprintf(limited, sizeof limited, "prlimit %s %s", limits[k], program);
        setenv("C", limited, 1);
        disturb(command, limits[k], whole, whole_file);
    }
    setenv("C", program, 1);
}
#else
static void limit_each(const char *command, const ran *whole, const char *whole_file)
{
    (void)command; (void)whole; (void)whole_file;
}
#endif

static void fail_each(const char *command)
{
    char calls[300], *file;
    const char *denser = getenv("LW_FAULTS");
    bool search = strstr(command, "C fit ") || strstr(command, "C plasma ") || strstr(command, " studio ");
    double step = 1 + (search ? 2 : 0.6)/(denser ? atof(denser) : 1);
    snprintf(calls, sizeof calls, "%s/calls", getenv("D"));
    setenv("LW_CALLS_FILE", calls, 1);
    ran whole = run_once(command, &file);
    unsetenv("LW_CALLS_FILE");
    if (whole.code != 0)
        fprintf(stderr, "%s\n  said: %s", command, whole.err);
    CHECK_INT(whole.code, 0);
    for (size_t k = 0; k < sizeof kinds/sizeof *kinds; k++) {
        long n_call = count_calls(kinds[k]), n_first = search ? N_FIRST_OF_SEARCH : N_FIRST;
        n_first *= denser ? atol(denser) : 1;
        for (long n = 1; n <= n_call; n = n < n_first ? n + 1 : (long)(step*(double)n))
            fail_one(command, kinds[k], n, &whole, file);
    }
    limit_each(command, &whole, file);
    ran_free(&whole);
    free(file);
}

TEST(faults)
{
    const char *only = getenv("LW_FAULTS_ROW");
    expect("$P chains --links 6 -o $D/six.g6 && head -n 1 $D/six.g6 > $D/watt.g6 && "
           "$P chains --links 4 -f lam -o $D/four.lam && $P catalogue build $D/six.db --links 6 -q && "
           "mkdir $D/bin && cp $C $D/bin/linkwright && mkdir $D/examples && cp -r examples/gallery $D/examples/ && "
           "mkdir $D/problems && cp examples/ellipse.csv $D/problems && "
           "printf 'x,y,angle\\n0,0,0\\n30,11,0.3\\n61,14,0.6\\n90,9,0.9\\n120,-6,1.2\\n' > $D/timed.csv && "
           "$P catalogue curves $D/curves.db --links 4 --samples 200 -q && "
           "$P fit examples/ellipse.csv --starts 20 --rounds 1 --json -o $D/fit.json -q && "
           "printf 'x,y\\n0,0\\n30,11\\n61,14\\n90,9\\n120,-6\\n' > $D/five.csv", 0, NULL, NULL);
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (!only || strstr(rows[i], only))
            fail_each(rows[i]);
}

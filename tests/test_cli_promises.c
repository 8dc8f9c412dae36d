/* test_cli_promises.c - one row for each command: what it promises when it is stopped, killed, short of memory or stack, or
 * given outputs that are inputs or have long names (docs/promises.md).
 *
 * `slow` would work for minutes at least: a run that ends was stopped. No check depends on how soon it ends. A run is
 * stopped when it has worked: after BUSY hundredths of a second of processor time, however long these take.
 *
 * Of ways that end in the same code of all commands each row takes one, and the next row the next one; with LW_FAULTS=1 each takes all. */
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>
#include "tests/cli_run.h"

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define BUSY "100"              /* its start takes longer */
#define STACK "8192"
#elif defined __OPTIMIZE__
#define BUSY "5"
#define STACK "256"
#else                                        /* each variable of each block has bytes of its own */
#define BUSY "10"
#define STACK "1024"
#endif

typedef struct row {
    const char *small;                       /* writes all it finds to -o FILE, which is added       */
    const char *slow;                        /* the same for -o FILE; NULL: the command is never slow */
    const char *input;                       /* a file that `small` reads; NULL: none                */
    bool        marked;                      /* slow writes FILE itself, which says that it is partial */
} row;

/* Does row k take this one of n ways? */
static bool takes(size_t k, size_t way, size_t n) { return k%n == way || getenv("LW_FAULTS"); }

#define STREAM "yes \"$(head -n 1 $D/six.g6)\" | "

/* Commands whose output is no single file have their rows below: long_runs, catalogues. */
static const row rows[] = {
    { "numbers --loops 4", NULL, NULL, false },
    { "structures --loops 4", "structures --loops 9", NULL, false },
    { "chains --links 8", "chains --links 18", NULL, false },
    { "mechanisms --links 6", "mechanisms --links 14", NULL, false },
    { "mechanisms $D/six.g6", NULL, "$D/six.g6", false },
    { "grammar parse $D/six.g6", STREAM "$P grammar parse", "$D/six.g6", false },
    { "grammar print $D/six.g6", STREAM "$P grammar print", "$D/six.g6", false },
    { "grammar explain $D/six.g6", STREAM "$P grammar explain", "$D/six.g6", false },
    { "grammar derive --links 6", "grammar derive --links 9", NULL, false },
    { "grammar coverage --links 8", "grammar coverage --links 16", NULL, false },
    { "classify 40 10 35 30", NULL, NULL, false },
    { "gallery klann", NULL, NULL, false },
    { "profile 1 --acceleration-limit 20 --jerk-limit 400", NULL, NULL, false },
    { "robot jacobian examples/space/stewart.json", NULL, "examples/space/stewart.json", false },
    { "robot budget examples/space/delta-clearance.json", NULL, "examples/space/delta-clearance.json", false },
    { "robot workspace examples/space/delta.json --rays 6", "robot workspace examples/space/delta.json --rays 100000",
      "examples/space/delta.json", false },
    { "robot reachability examples/3-rrr.json", "robot workspace examples/space/delta.json --volume --rays 1000", "examples/3-rrr.json", false },
    { "robot map examples/space/delta.json --places 4", "robot map examples/space/delta.json --places 1000",
      "examples/space/delta.json", false },
    { "family expand examples/families/loader.json", NULL, "examples/families/loader.json", false },
    { "family table examples/families/loader.json", NULL, "examples/families/loader.json", false },
    { "family sweep examples/families/loader.json --vary reach=2:3:3 -n 10",
      "family sweep examples/families/loader.json --vary reach=2:3:1000000", "examples/families/loader.json", false },
    { "family optimise examples/families/loader.json --vary reach=2:3 --minimise boom_mass",
      "family optimise examples/families/loader.json --vary drop,pin_height --minimise peak\\(lift.drive\\) --to 2 "
      "--solver isres --max-evaluations 1e7", "examples/families/loader.json", false },
    { "family check examples/families/loader.json", NULL, "examples/families/loader.json", false },
    { "drive simulate examples/drives/servo-axis.json -n 8 --to 0.05", "drive simulate examples/drives/servo-axis.json --to 1e5",
      "examples/drives/servo-axis.json", false },
    { "drive select examples/drives/lifting-arm.json --to 2.5 -n 100 --motors examples/drives/motors.csv --gears examples/drives/gears.csv",
      "drive select examples/drives/lifting-arm.json --motors $D/motors.csv --gears $D/gears.csv", "examples/drives/motors.csv", false },
    { "drive radius examples/drives/motors.csv --mass 20 --way 1", NULL, "examples/drives/motors.csv", false },
    { "profile examples/cycles/gantry.json", NULL, "examples/cycles/gantry.json", false },
    { "trace examples/jansen.json -n 8", "trace examples/jansen.json -n 1e7", "examples/jansen.json", false },
    { "mobility examples/jansen.json", NULL, "examples/jansen.json", false },
    { "drive load examples/drives/lifting-arm.json -n 8", "drive load examples/drives/lifting-arm.json -n 1e7",
      "examples/drives/lifting-arm.json", false },
    { "simulate examples/dynamics/governor.json --to 0.01 -n 4",
      "simulate examples/dynamics/governor.json --to 1e5 -n 1e6", "examples/dynamics/governor.json", false },
    { "simulate examples/pendulum.json --analysis linear",
      "simulate examples/pendulum.json --analysis linear --along 1e6", "examples/pendulum.json", false },
    { "trace examples/space/bricard.json -n 8", "trace examples/space/bricard.json -n 1e7", "examples/space/bricard.json",
      false },
    { "mobility examples/space/sarrus.json", NULL, "examples/space/sarrus.json", false },
    { "simulate examples/space/governor.json --to 0.01 -n 4", "simulate examples/space/governor.json --to 1e5 -n 1e6",
      "examples/space/governor.json", false },
    { "simulate examples/elastic-cantilever.json --to 0.001 -n 2", "simulate examples/elastic-spin-up.json --to 1e5",
      "examples/elastic-cantilever.json", false },
    { "simulate examples/elastic-frame.json --analysis static", NULL, "examples/elastic-frame.json", false },
    { "simulate examples/dynamics/boxes.json --to 0.01 -n 4", "simulate examples/dynamics/boxes.json --to 1e6 -n 1e6",
      "examples/dynamics/boxes.json", false },
    { "simulate examples/dynamics/boom-cylinder.json --to 0.01 -n 4",
      "simulate examples/dynamics/boom-cylinder.json --to 1e6 -n 1e6", "examples/dynamics/boom-cylinder.json", false },
    { "convert examples/chebyshev.json --format pyslvs", NULL, "examples/chebyshev.json", false },
    { "draw examples/chebyshev.json -f svg", NULL, "examples/chebyshev.json", false },
    { "draw examples/hoeken.json examples/chebyshev.json -f svg", "draw examples/jansen.json -f gif -n 1e4 --size 2000x2000",
      "examples/chebyshev.json", false },
    { "draw examples/space/bricard.json -f svg", NULL, "examples/space/bricard.json", false },
    { "draw $D/six.g6 --grid 2x1 -f svg", STREAM "$P draw --grid 2x1 -f svg", "$D/six.g6", false },
    { "clearance examples/clearance-four-bar.json --speeds 80 --to 0.02 --settle 0.01",
      "clearance examples/clearance-four-bar.json --speeds 80 --to 1e5", "examples/clearance-four-bar.json", false },
    { "catalogue query $D/six.db links=6 -f csv",
      "catalogue query $D/six.db 'WITH RECURSIVE x(n) AS (SELECT 1 UNION ALL SELECT n+1 FROM x) SELECT n FROM x' --sql",
      "$D/six.db", false },
    { "catalogue export $D/six.db links=6", NULL, "$D/six.db", false },
    { "catalogue nearest $D/curves.db examples/ellipse.csv", NULL, "examples/ellipse.csv", false },
    { "catalogue check $D/six.db", "catalogue check $D/builds.db", "$D/six.db", false },
    { "fit examples/ellipse.csv --unlimited --starts 20 --rounds 1 --json", "fit examples/walking-foot.csv --links 8",
      "examples/ellipse.csv", true },
};

enum { N_ROW = sizeof rows/sizeof *rows };

/* "$P small", or a pipe as it stands. */
static const char *with_program(const char *command, char line[600])
{
    snprintf(line, 600, "%s%s", strstr(command, "$P") ? "" : "$P ", command);
    return line;
}

/* The shell command ends with code 0. */
static void demand(const char *command, const char *after)
{
    ran r = run(command);
    if (r.code != 0)
        fprintf(stderr, "%s\n  after %s: %s%s\n", command, after, r.out, r.err);
    CHECK_INT(r.code, 0);
    ran_free(&r);
}

/* `$T SIGNAL COMMAND...`, this program itself: send the signal to the command when it has been busy; end with its exit code.  A shell
 * would start a program each time that it waits. */
static int until_busy(int number, char **command)
{
    char path[64], text[512];
    pid_t child;
    int status = 0;
    signal(SIGINT, SIG_IGN);                     /* as in the background of a shell */
    if (posix_spawnp(&child, command[0], NULL, NULL, command, environ) != 0)
        return 127;
    snprintf(path, sizeof path, "/proc/%d/stat", (int)child);
    for (long ticks = 0; ticks < atol(BUSY); nanosleep(&(struct timespec){ .tv_nsec = 10000000 }, NULL)) {
        if (waitpid(child, &status, WNOHANG) == child)
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        FILE *f = fopen(path, "r");
        const char *after = f && fgets(text, sizeof text, f) ? strrchr(text, ')') : NULL;
        if (f)
            fclose(f);
        if (after)
            sscanf(after, ") %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %ld", &ticks);
    }
    kill(child, number);
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/* The file `name` in $D. */
static const char *in_folder(const char *name, char path[300])
{
    snprintf(path, 300, "%s/%s", getenv("D"), name);
    return path;
}

/* The input of a row, with $D in full. */
static const char *input_of(const row *t, char path[300])
{
    if (strncmp(t->input, "$D/", 3) == 0)
        return in_folder(t->input + 3, path);
    return t->input;
}

/* Two files of the same bytes; missing ones are not. */
static bool same_files(const char *a, const char *b)
{
    FILE *one = fopen(a, "rb"), *other = fopen(b, "rb");
    bool same = one && other;
    for (int byte = 0; same && byte != EOF;)
        same = (byte = getc(one)) == getc(other);
    if (one)
        fclose(one);
    if (other)
        fclose(other);
    return same;
}

static void copy_file(const char *from, const char *to)
{
    FILE *one = fopen(from, "rb"), *other = fopen(to, "wb");
    for (int byte; one && other && (byte = getc(one)) != EOF;)
        putc(byte, other);
    CHECK(one && other && !ferror(one) && fclose(one) == 0 && fclose(other) == 0);
}

/* No file whose name begins so is in the folder, if there is one. */
static bool none_begins(const char *folder, const char *with)
{
    DIR *d = opendir(folder);
    bool none = true;
    for (const struct dirent *e; d && (e = readdir(d));)
        none &= strncmp(e->d_name, with, strlen(with)) != 0;
    if (d)
        closedir(d);
    return none;
}

static void check_after(bool condition, const char *what, const char *command)
{
    if (!condition)
        fprintf(stderr, "%s\n  leaves %s\n", command, what);
    CHECK(condition);
}

/* Stop the slow work; $D/o is there before, and stays as it is. */
static void stop(const row *t, const char *how, int code)
{
    char line[2000], slow[600], path[300], old[300];
    bool by_time = how[0] == '-';
    with_program(t->slow, slow);
    const char *at = strstr(slow, "$P"), *end = at + 2;
    remove(in_folder("o.partial", path));
    copy_file(in_folder("six.g6", old), in_folder("o", path));
    snprintf(line, sizeof line, "%.*s%s$P%s -o $D/o --force %s", (int)(at - slow), slow, by_time ? "" : how, end, by_time ? how : "");
    ran r = run(line);
    if (r.code != code)
        fprintf(stderr, "%s\n  said: %s", line, r.err);
    CHECK_INT(r.code, code);
    ran_free(&r);
    char *now = slurp(path);
    check_after(same_files(old, path) || (t->marked && strstr(now, "\"complete\": false")), "another FILE", line);
    free(now);
    if (code != 128 + SIGKILL)
        check_after(none_begins(getenv("D"), ".lw-"), "a temporary file", line);
}

/* What is added to a command, or before $P, to stop it, and the code it then ends with. */
static const struct { const char *how; int code; } ends[] = {
    { "$T HUP ", 128 + SIGHUP }, { "$T INT ", 128 + SIGINT }, { "--time 0.1", 5 }, { "$T TERM ", 128 + SIGTERM },
};
enum { N_END = sizeof ends/sizeof *ends };

TEST(stopped_in_order)
{
    size_t n = 0;
    for (int i = 0; i < N_ROW; i++) {
        if (!rows[i].slow)
            continue;
        for (size_t k = 0; k < N_END; k++)
            if (takes(n, k, N_END))
                stop(&rows[i], ends[k].how, ends[k].code);
        n++;
    }
}

/* A catalogue that was ended by force before its first commit is empty; a journal beside it takes back what it held. */
#define CATALOGUE "! test -e $D/x || $P catalogue check $D/x 2> $D/said || grep -q 'is empty' $D/said || { cat $D/said; false; }"

/* Runs in phases that the rows above do not reach, and commands that write folders, databases or tables. The check that
 * follows tells that what they leave is whole, or a database that was not begun; bench has no --time of the
 * whole run: its rows take other ways. */
static const struct { const char *slow, *then; } long_runs[] = {
    { "plasma $D/four.lam --target examples/walking-foot.csv --budget 1e12 -o $D/x", "test ! -e $D/x" },
    { "fit examples/walking-foot.csv --links 7 --dof 2 -q", NULL },
    { "fit examples/walking-foot.csv --links 8 --joints r,t -q --save $D/x", NULL },
    { "fit $D/nine.csv --exact -q", NULL },
    { "catalogue curves $D/x --links 6 --samples 1e6 -q", CATALOGUE },
    { "catalogue build $D/x --links 16 -q", CATALOGUE },
    { "catalogue add $D/x $D/many.json -q", CATALOGUE },
    { "catalogue html $D/endless.db -o $D/x -q", NULL },
    { "catalogue release -o $D/x --links 14 -q", NULL },
    { "classify $D/lengths -o $D/x", "test ! -e $D/x" },
    { "simulate $D/pile.json --to 10", NULL },
    { "simulate $D/snake.json --to 10", NULL },
    { "mobility $D/flat.json", NULL },
    { "draw $D/whip.json -f svg -o $D/x", "test ! -e $D/x" },
    { "draw $D/whip.json -f html -o $D/x", "test ! -e $D/x" },
    { "trace $D/whip.json -n 2 -o $D/x", "test ! -e $D/x" },
    { "trace examples/gallery/strandbeest.json --all-assemblies", NULL },
    { "simulate $D/rope.json --analysis static", NULL },
    { "simulate $D/rope.json --analysis linear --rest", NULL },
    { "structures --loops 10", NULL },
    { "grammar derive --links 12 --rules 1,2,3,4", NULL },
    { "grammar coverage --links 18", NULL },
    { "chains --links 18 --count", NULL },
    { "bench fit --problems $D/problems --seeds 1000", NULL },
    { "bench fit --problems $D/problems --links 6 --budget 1e12 -o $D/x", NULL },
    { "bench mbs --cases row-of-400 --peers none -o $D/x", NULL },
};

TEST(long_runs_stop)
{
    for (size_t i = 0; i < sizeof long_runs/sizeof *long_runs; i++) {
        char line[1200], path[300];
        bool bench = strncmp(long_runs[i].slow, "bench", 5) == 0;
        for (size_t k = 0; k < N_END; k++) {
            bool by_time = ends[k].code == 5;
            if (!takes(i, k, N_END) || (bench && by_time))
                continue;
            if (remove(in_folder("x", path)) != 0 && errno != ENOENT)
                demand("rm -r $D/x", "");
            snprintf(line, sizeof line, "%s$P %s %s", by_time ? "" : ends[k].how, long_runs[i].slow, by_time ? ends[k].how : "");
            expect(line, ends[k].code, NULL, NULL);
            check_after(none_begins(getenv("D"), ".lw-") && none_begins(path, ".lw-"), "a temporary file", line);
            if (long_runs[i].then)
                demand(long_runs[i].then, line);
        }
    }
    demand("rm -rf $D/x", "");
}

/* Where the system queues no signal and so refuses timers of timer_create, --time ends a command that does not read the clock. */
TEST(no_queued_signals)
{
    struct rlimit usual, none;
    CHECK(getrlimit(RLIMIT_SIGPENDING, &usual) == 0);
    none = (struct rlimit){ 0, usual.rlim_max };
    CHECK(setrlimit(RLIMIT_SIGPENDING, &none) == 0);
    expect("timeout 60 $P robot map examples/space/delta.json --places 1000 --time 0.1 -o $D/none", 5, NULL, NULL);
    CHECK(setrlimit(RLIMIT_SIGPENDING, &usual) == 0);
}

/* Hundreds of links, with and without rows that depend on others: none of them needs a full matrix. */
TEST(many_links)
{
    expect("$P mobility $D/snake.json", 0, "freedom         1000", NULL);
    expect("$P robot jacobian $D/row.json", 0, "singular values 1 in (1.000000, 0.000000, 0.000000)", NULL);
}

/* Pictures of a stopped run show what was found; whole ones stay. */
TEST(stopped_pictures)
{
    static const char *const models[] = { "examples/dynamics/governor.json", "examples/space/governor.json" };
    for (size_t i = 0; i < sizeof models/sizeof *models; i++) {
        char line[600];
        snprintf(line, sizeof line, "cp docs/pictures/leg.svg $D/whole.svg; $P simulate %s --to 10 --max-steps 50 --plot $D/whole.svg "
                 "--force > $D/rows; test $? = 5 && cmp docs/pictures/leg.svg $D/whole.svg && grep -q '<polyline' $D/whole.partial.svg && "
                 "rm $D/whole.partial.svg", models[i]);
        demand(line, models[i]);
    }
}

/* Several targets share --time: each of them is searched. */
TEST(targets_share_time)
{
    demand("LW_CLOCK_STEP=0.0003 $C fit examples/walking-foot.csv examples/ellipse.csv examples/walking-foot.csv --time 3 --json -q "
           "> $D/three; test $? = 5 && test $(grep -c '\"results\": *\\[' $D/three) = 3 && "
           "python3 -c 'import json, sys; t = open(sys.argv[1]).read(); d = json.JSONDecoder(); n = 0\n"
           "while t.strip(): o, end = d.raw_decode(t.strip()); t = t.strip()[end:]; n += len(o[\"results\"]) > 0\n"
           "sys.exit(n != 3)' $D/three", "three targets");
}

/* A search that the time ended before it found anything is not complete: exit code 5, not 1. */
TEST(nothing_found_when_the_time_ends)
{
    expect("LW_CLOCK_STEP=0.005 $C fit examples/ellipse.csv --type fourbar --crank-only --bounds r1=100:100,r2=1:1,r3=5:5,r4=1:1 "
           "--stations 8 --starts 2 --rounds 100000 --time 1 -j 1 -q --save $D/unmet > $D/unmet.txt; code=$?; "
           "grep -c '^0 results.*time limit' $D/unmet.txt; exit $code", 5, "1\n", NULL);
}

/* Targets that are not begun are counted. */
TEST(targets_not_begun)
{
    expect("LW_CLOCK_STEP=0.0003 $C fit $(yes examples/ellipse.csv | head -n 1000) --time 0.3 -q > $D/many", 5, NULL,
           "of 1000 targets were not begun");
}

/* A killed run leaves FILE as it was; the next run removes its temporary file. */
TEST(killed)
{
    for (int i = 0; i < N_ROW; i += 3) {
        if (rows[i].slow && !rows[i].marked)
            stop(&rows[i], "$T KILL ", 128 + SIGKILL);
    }
    demand("$T KILL $P grammar derive --links 9 -o $D/o --force; ls -A $D | grep '^[.]lw-' && "
           "$P numbers --loops 4 -o $D/n && ! ls -A $D | grep '^[.]lw-'", "kill -9");
    static const char *const others[] = { "trace examples/hoeken.json -n 4 --plot $D/left/x.svg", "catalogue html $D/six.db -o $D/left -q",
        "drive simulate examples/drives/servo-axis.json -n 4 --to 0.01 --matrices-folder $D/left" };
    for (size_t i = 0; i < sizeof others/sizeof *others; i++) {
        char line[400];
        snprintf(line, sizeof line, "mkdir $D/left && touch $D/left/.lw-1-0.tmp $D/left/.lw-1-0.tmp-journal $D/left/.lw-1-0.tmp-lock && $P %s > $D/rows && test -n \"$(ls $D/left)\" && "
                 "! ls -A $D/left | grep '^[.]lw-'; c=$?; rm -r $D/left; exit $c", others[i]);
        demand(line, others[i]);
    }
}

/* A run that is ended by force keeps the rows that are on the disk, and the next run may begin. */
TEST(ended_by_force)
{
    demand("rm -f $D/forced*; " STREAM "$P grammar parse -o $D/forced & p=$!; until test -s $D/.lw-*.tmp; do sleep 0.02; done; for i in 1 2 3 4 5 6; do "
           "kill -ALRM $p; done 2> /dev/null; wait $p; test $? = 5 && test -s $D/forced.partial && test ! -e $D/forced && ! ls -A $D | grep '^[.]lw-' && "
           "$P chains --links 6 -o $D/forced && test -s $D/forced", "ended by force");
}

/* The shell command ends with code 0.  A stack of 256 KB is enough: threads have as much as the first one. */
static void demand_with_little_stack(const char *command, const char *after)
{
    struct rlimit usual, little;
    CHECK(getrlimit(RLIMIT_STACK, &usual) == 0);
    little = usual;
    little.rlim_cur = 1024*(rlim_t)atol(STACK);
    CHECK(setrlimit(RLIMIT_STACK, &little) == 0);
    demand(command, after);
    CHECK(setrlimit(RLIMIT_STACK, &usual) == 0);
}

/* Parts of the program that the rows do not reach. */
TEST(little_stack)
{
    static const char *const more[] = {
        "fit examples/function-log.csv --links 6 --budget 1000 --starts 5 --rounds 1 --results 2",
        "$P fit examples/walking-foot.csv --links 8 --time 0.5; test $? = 5",
        "fit examples/walking-foot.csv --links 4 --crank-only --max-size 1.5 --min-transmission-angle 30 --starts 20 --rounds 1",
        "fit $D/five.csv --exact", "trace $D/group.json -n 8", "simulate examples/andrews.json --to 0.01 -n 4",
        "simulate examples/pendulum.json --analysis linear --along 4 --rest", "mobility examples/gallery/klann.json",
        "plasma $D/four.lam --target examples/ellipse.csv --budget 1e4", "catalogue nearest $D/curves.db examples/ellipse.csv",
        "rm -f $D/c.db; $P catalogue curves $D/c.db --links 6 --samples 20",
        "bench fit --problems $D/problems --solvers lm --time 0.01 --seeds 1 --reach-time 0.1",
    };
    char line[600];
    for (size_t i = 0; i < sizeof more/sizeof *more; i++)
        demand_with_little_stack(with_program(more[i], line), "little stack");
}

/* An input is never the output; a long name is no obstacle, nor is a small stack. */
TEST(inputs_and_long_names)
{
    char line[1600], small[600], before[300], file[2000];
    size_t end = (size_t)snprintf(file, sizeof file, "%s", getenv("D")), base = end;
    for (int i = 0; i < 6; i++) {
        file[end++] = '/';
        memset(file + end, 'n', 250);
        file[end += 250] = 0;
        CHECK(mkdir(file, 0777) == 0);
    }
    setenv("L", file, 1);
    for (int i = 0; i < N_ROW; i++) {
        with_program(rows[i].small, small);
        if (rows[i].input) {
            char full[300];
            const char *input = input_of(&rows[i], full);
            copy_file(input, in_folder("before", before));
            snprintf(line, sizeof line, "%s -o %s --force", small, rows[i].input);
            expect(line, 2, NULL, NULL);
            check_after(same_files(input, before), "another input", line);
        }
        snprintf(line, sizeof line, "%s -o $L/file", small);
        demand_with_little_stack(line, small);
        struct stat about;
        strcpy(file + end, "/file");
        check_after(stat(file, &about) == 0 && about.st_size > 0 && remove(file) == 0, "no output", line);
        file[end] = 0;
        check_after(rmdir(file) == 0 && mkdir(file, 0777) == 0, "other files", line);
    }
    for (; end > base; end -= 251, file[end] = 0)
        CHECK(rmdir(file) == 0);
}

/* Too little memory is an error with a message, or does not matter. */
TEST(bounded_memory)
{
    for (int i = 0; i < N_ROW; i++) {
        char small[600], path[300];
        remove(in_folder("o", path));
        ran r = run_with("%s --memory 0.01 -o $D/o", with_program(rows[i].small, small));
        CHECK(r.code == 0 || (r.code == 4 && r.err[0]));
        ran_free(&r);
    }
    if (SANITIZED)                               /* the system holds no limit then */
        return;
    expect("$P grammar derive --links 12 --rules 1,2,3,4 --memory 0.1 -o $D/none", 4, "", "the limit is 0.1 GB (--memory)");
    expect("$P structures --loops 12 --memory 1 -o $D/none", 4, "", "need about");
    expect("$P chains --links 18 --count --memory 0.02 -o $D/none", 4, "", "need about");
    demand("test ! -e $D/none", "too little memory");
}

/* Streams that are closed, or that nobody reads, and names that are no plain text. */
TEST(odd_streams_and_names)
{
    static const char *const commands[] = { "fit examples/ellipse.csv --unlimited --starts 5 --rounds 1", "trace examples/jansen.json -n 4",
        "family table examples/families/loader.json", "drive load examples/drives/lifting-arm.json -n 4" };
    char line[1000];
    for (size_t i = 0; i < sizeof commands/sizeof *commands; i++) {
        snprintf(line, sizeof line, "$P %s --json -o $D/o --force -q && $P %s --json -o $D/p --force -q <&- >&- 2>&- && "
                 "grep -v 'command\\|seconds' $D/o > $D/o1; grep -v 'command\\|seconds' $D/p > $D/p1; cmp $D/o1 $D/p1 && "
                 "n=$D/$(printf 'a \\351\\\\\\n\\303\\251b') && $P %s --json -o \"$n\" -q && "
                 "python3 -c 'import json, sys; json.loads(open(sys.argv[1], \"rb\").read().split(b\"\\n{\")[0])' \"$n\" && rm \"$n\"",
                 commands[i], commands[i], commands[i]);
        demand(line, commands[i]);
    }
    expect("n=$D/$(printf 'a\\n\\351b.json') && cp examples/jansen.json \"$n\" && $P trace \"$n\" -n 4 -o $D/o --force -q && "
           "test $(grep -c '^#' $D/o) -gt 0 && ! grep -v '^#' $D/o | grep jansen && rm \"$n\"", 0, NULL, NULL);
    expect("$P catalogue build $D/closed.db --links 6 -q <&- >&- 2>&- && $P catalogue check $D/closed.db", 0, NULL, NULL);
    expect("mkfifo $D/pipe; sleep 60 < $D/pipe & $P chains --links 12 --time 0.2 > $D/pipe; c=$?; kill $!; exit $c", 5, NULL, NULL);
    expect("$P chains --links 8 -o $D/pipe --time 0.2", 5, NULL, NULL);
    expect("$P trace $D/pipe --time 0.2", 5, NULL, NULL);
    expect("timeout 60 $P catalogue nearest $D/curves.db $D/pipe --time 0.2", 5, NULL, NULL);
    expect("truncate -s 4G $D/sparse; for c in trace simulate mobility fit 'family table' 'robot map' 'drive load' mechanisms "
           "'drive radius --mass 1 --way 1' 'catalogue query' \"catalogue add $D/six.db\"; do $P $c $D/sparse; test $? = 3 || exit 1; "
           "done; rm $D/sparse", 0, NULL, NULL);
    expect(": > $D/empty; for c in trace simulate fit 'family table' 'robot map' 'drive load' 'drive simulate' clearance; do "
           "$P $c $D/empty; test $? = 3 || exit 3; done; for c in classify mechanisms \"catalogue add $D/six.db\"; do $P $c $D/empty; "
           "test $? = 1 || exit 1; done", 0, NULL, NULL);
    expect("printf '\\000' > $D/empty; $P catalogue add $D/six.db $D/empty", 3, NULL, "this is no text");
}

/* `command` with `to` in the place of `from`. */
static void replace(const char *command, const char *from, const char *to, char line[600])
{
    const char *at = strstr(command, from);
    snprintf(line, 600, "%.*s%s%s", (int)(at - command), command, to, at + strlen(from));
}

/* Write the text into a pipe that somebody opens. */
static pid_t write_once(const char *path, const char *text)
{
    pid_t child = fork();
    if (child != 0)
        return child;
    FILE *f = fopen(path, "w");
    _exit(!f || fputs(text, f) < 0 || fclose(f) != 0);
}

static void end_writer(pid_t writer)
{
    if (writer <= 0)
        return;
    kill(writer, SIGKILL);
    waitpid(writer, NULL, 0);
}

/* The lines without times, and without the name of the input.  Free with free(). */
static char *without_names(const char *text, const char *name)
{
    char *copy = strdup(text), *rest = copy, *out = calloc(1, strlen(text) + 2), *to = out;
    for (char *line; (line = strsep(&rest, "\n"));) {
        if (strstr(line, "seconds"))
            continue;
        for (char *at; (at = strstr(line, name)); line = at + strlen(name))
            to += sprintf(to, "%.*s", (int)(at - line), line);
        to += sprintf(to, "%s\n", rest ? line : "");
    }
    free(copy);
    return out;
}

/* A pipe gives its text once: the answer is that to the file, and an error is said without waiting for more. */
TEST(inputs_that_are_read_once)
{
    char plain[600], piped[600], name[40], path[300], full[300];
    for (int i = 0; i < N_ROW; i++) {
        const row *r = &rows[i];
        if (!r->input || strstr(r->input, ".db") || strstr(r->small, "draw $D/six.g6"))    /* databases; pictures need the kind first */
            continue;
        snprintf(name, sizeof name, "$D/once%s", strrchr(r->input, '.'));
        in_folder(name + 3, path);
        remove(path);
        CHECK(mkfifo(path, 0666) == 0);
        replace(with_program(r->small, plain), r->input, name, piped);
        const char *input = input_of(r, full);
        char *text = slurp(input), *said[2];
        for (int once = 0; once < 2; once++) {
            pid_t writer = once ? write_once(path, text) : 0;
            ran whole = run_with(once ? "timeout 60 %s -q" : "%s -q", once ? piped : plain);
            CHECK_INT(whole.code, 0);
            said[once] = without_names(whole.out, once ? path : input);
            ran_free(&whole);
            end_writer(writer);
        }
        if (strcmp(said[0], said[1]) != 0)
            fprintf(stderr, "%s: another answer to a pipe\n", r->small);
        CHECK(strlen(said[0]) > 2 && strcmp(said[0], said[1]) == 0);
        free(said[0]), free(said[1]), free(text);
        pid_t writer = write_once(path, "\"?");
        ran bad = run_with("timeout 60 %s", piped);
        CHECK(bad.code == 3 || bad.code == 1);
        ran_free(&bad);
        end_writer(writer);
        remove(path);
    }
    expect("$P fit examples/ellipse.csv --unlimited --starts 20 --rounds 1 --json -q > $D/start.json && for from in $D/start.json -; do $P fit "
           "examples/figure-eight.csv --unlimited --links 4 --crank-only --start-from $from --starts 5 --rounds 1 -q --json < $D/start.json | grep -v 'seconds\\|command' > $D/by$(basename $from); done; "
           "cmp $D/by- $D/bystart.json", 0, NULL, NULL);
}

/* An output that cannot be written ends the work at once: these would go on for minutes at least. */
TEST(failed_outputs_end_the_work)
{
    static const char *const slow[] = { "$P trace examples/jansen.json -n 1e7", "$P trace examples/jansen.json -n 1e7 --json",
        "$P trace examples/space/bricard.json -n 1e7", STREAM "$P grammar explain", "$P chains --links 16",
        "$P simulate examples/space/governor.json --to 1e5 -n 1e6", "$P robot map examples/space/delta.json --places 1000",
        "$P robot workspace examples/space/delta.json --rays 100000", "$P family sweep examples/families/loader.json --vary reach=2:3:1000000",
        "$P family sweep examples/families/loader.json --vary reach=2:3:1000000 --json", "$P drive simulate examples/drives/servo-axis.json -n 1e6 --to 1e5",
        "$P catalogue query $D/six.db 'WITH RECURSIVE x(n) AS (SELECT 1 UNION ALL SELECT n+1 FROM x) SELECT n FROM x' --sql" };
    char line[800], bounded[600];
    for (size_t i = 0; i < sizeof slow/sizeof *slow; i++) {
        replace(slow[i], "$P", "timeout 100 $P", bounded);
        snprintf(line, sizeof line, "%s -q -o /dev/full; test $? = 3", bounded);
        demand(line, slow[i]);
    }
    demand("trap '' PIPE; { timeout 100 $P trace examples/jansen.json -n 1e7 -q; echo $? > $D/code; } | head -n 1; test $(cat $D/code) = 3",
           "a pipe that nobody reads, and no SIGPIPE");
}

/* --json prints JSON: one value, or one a line. */
TEST(json_is_json)
{
    char line[900], small[600];
    demand("mkdir $D/json", "");
    for (int i = 0; i < N_ROW; i++) {
        with_program(rows[i].small, small);
        if (strstr(small, " --json") || strstr(small, " --format ") || strstr(small, " -f "))
            continue;
        snprintf(line, sizeof line, "%s --json -q -o $D/json/%d.json", small, i);
        demand(line, small);
    }
    demand("$P plasma $D/four.lam --target $D/five.csv --first 5 --budget 1000 --points 4 --json -q -o $D/json/plasma.json && "
           "$P grammar print $D/six.g6 --format lam --json -o $D/json/grammar.json", "plasma, grammar");
    expect("$P convert examples/chebyshev.json --format dxf --json", 2, "", "--json prints JSON, not dxf");
    demand("cd $D/json && python3 -c 'import json, sys\n"
           "for name in sys.argv[1:]:\n"
           "    t = open(name).read().strip()\n"
           "    try:\n"
           "        while t: t = t[json.JSONDecoder().raw_decode(t)[1]:].strip()\n"
           "    except ValueError: sys.exit(name + \": \" + t[:60])' *", "--json");
}

/* A text of each format, and a command that reads it. */
static const struct { const char *text, *end, *read; } texts[] = {
    { "cat examples/ellipse.csv", "csv", "catalogue nearest $D/curves.db $Z" }, { "cat examples/jobs/heart-drawn.svg", "svg", "catalogue nearest $D/curves.db $Z" },
    { "cat tests/fuzz/corpus/dxf/circle.dxf", "dxf", "catalogue nearest $D/curves.db $Z" }, { "cat examples/tasks/dwell.json", "json", "fit $Z --links 4 --budget 1000 --unlimited --starts 1 --rounds 1 --results 1" },
    { "$P convert examples/chebyshev.json --format pyslvs", "pyslvs", "convert $Z" },
    { "$P convert examples/chebyshev.json --format pmks", "txt", "convert $Z" },
    { "$P convert examples/chebyshev.json --format adams", "adm", "convert $Z" },
    { "cat examples/jansen.json", "json", "trace $Z -n 4" }, { "cat examples/space/stewart.json", "json", "robot jacobian $Z" },
    { "cat examples/families/loader.json", "json", "family table $Z" }, { "cat examples/cycles/gantry.json", "json", "profile $Z" },
    { "cat examples/drives/servo-axis.json", "json", "drive simulate $Z -n 4 --to 0.01" },
    { "cat examples/drives/motors.csv", "csv", "drive radius $Z --mass 20 --way 1" },
    { "$P chains --links 6 -f graph6", "g6", "mechanisms $Z" }, { "$P chains --links 6 -f lam", "lam", "mechanisms $Z" },
    { "$P chains --links 6 -f sentence", "txt", "grammar parse $Z" }, { "$P chains --links 6 -f franke", "txt", "mechanisms $Z" },
    { "$P chains --links 6 -f edges", "txt", "mechanisms $Z" }, { "$P chains --links 6 -f json", "json", "mechanisms $Z" },
    { "$P chains --links 6 -f dot", "dot", "mechanisms $Z" }, { "$P chains --links 6 -f graphml", "graphml", "mechanisms $Z" },
    { "yes '40 10 35 30' | head -n 9", "txt", "classify $Z" }, { "cat examples/jansen.json", "json", "catalogue add $D/z.db $Z" },
};

/* A byte 0 in the middle of a text of each format is an error with its place, and never the end of the text. */
TEST(no_text_holds_a_byte_0)
{
    for (size_t i = 0; i < sizeof texts/sizeof *texts; i++) {
        char line[1200];
        snprintf(line, sizeof line, "%s > $D/whole && n=$(($(stat -c %%s $D/whole)/2)) && Z=$D/zero.%s && { head -c $n $D/whole; "
                 "printf '\\000'; tail -c +$((n + 1)) $D/whole; } > $Z; $P %s 2> $D/said; test $? = 3 && "
                 "grep -q 'zero[.a-z0-9]*:[0-9]*:[0-9]*: ' $D/said || { cat $D/said; exit 1; }", texts[i].text, texts[i].end, texts[i].read);
        demand(line, texts[i].read);
    }
}

/* Texts as Windows saves them, with a byte order mark and CR LF, or in UTF-16: the answer is the same.  Chains, which are read as
 * they come, are in UTF-8. */
TEST(texts_of_windows)
{
    for (size_t i = 0; i < sizeof texts/sizeof *texts; i++) {
        char line[1600];
        snprintf(line, sizeof line, "Z=$D/z.%s; answer() { cp $D/six.db $D/z.db; $P %s -q > $D/all 2>&1 && sed '/[0-9] s;/d' $D/all; }; "
                 "%s > $D/whole && cp $D/whole $Z && answer > $D/plain && { printf '\\357\\273\\277'; sed 's/$/\\r/' $D/whole; } > $Z && "
                 "answer > $D/marked && cmp $D/marked $D/plain && iconv -f UTF-8 -t UTF-16 $D/whole > $Z && answer > $D/wide && cmp $D/wide $D/plain || "
                 "grep 'this text is in UTF-16; save it in UTF-8' $D/all", texts[i].end, texts[i].read, texts[i].text);
        demand(line, texts[i].read);
    }
}

/* A database that is cut short while it is read. */
TEST(catalogues)
{
    expect("$P catalogue check $D/six.db", 0, NULL, NULL);
    expect("$P catalogue build $D/two.db --links 7 --dof 2 -q && $P catalogue check $D/two.db", 0, NULL, NULL);
    expect("size=$(stat -c %s $D/six.db); cp $D/six.db $D/cut.db; truncate -s $((size/2)) $D/cut.db; "
           "$P catalogue query $D/cut.db links=6", 3, NULL, "damaged");
    expect("head -c 1 $D/six.db > $D/cut.db; for c in query check export; do $P catalogue $c $D/cut.db; test $? = 3 || exit 1; done; "
           "test $(stat -c %s $D/cut.db) = 1", 0, NULL, "no SQLite file");
    expect("python3 -c 'import sqlite3, sys; sqlite3.connect(sys.argv[1]).execute(\"VACUUM\")' $D/void.db; cp $D/void.db $D/void; "
           "for c in query check export; do $P catalogue $c $D/void.db; test $? = 3 || exit 1; done; cmp $D/void $D/void.db", 0, NULL,
           "is empty");
    expect("cp $D/six.db $D/cut.db; (sleep 0.3; truncate -s 8192 $D/cut.db) & $P catalogue query $D/cut.db "
           "'WITH RECURSIVE x(n) AS (SELECT 1 UNION ALL SELECT n+1 FROM x LIMIT 100000) SELECT sum(length(graph6)) "
           "FROM x, chain' --sql > $D/rows; c=$?; wait; test $c = 3 -o $c = 0", 0, NULL, NULL);
}

/* Outputs that cannot be written: a full disk, a limit of file sizes, a folder, a closed stream, another name of an input. */
TEST(bad_outputs)
{
    static const char *const bad[] = { "/dev/full", "$D", "$D/none/x" };
    char small[600];
    for (int i = 0; i < N_ROW; i++)
        for (size_t k = 0; k < 3; k++)
            if (takes((size_t)i, k, 3))
                expect_with(3, NULL, NULL, "%s -o %s", with_program(rows[i].small, small), bad[k]);
    expect("ulimit -f 1; $P chains --links 10 -o $D/none", 3, "", "cannot be written");
    expect("ulimit -f 1; $P chains --links 10 > $D/rows", 3, "", "cannot be written");
    expect("ulimit -f 20; $P chains --links 12 -o $D/rows --force -q; c=$?; rm -f $D/rows.partial; exit $c", 3, "", "rows: cannot be written: the file would become too large");
    expect("ulimit -f 20; $P mechanisms --links 10 -o $D/rows --force -q; c=$?; rm -f $D/rows.partial; exit $c", 3, "", "rows: cannot be written: the file would become too large");
    expect("ulimit -f 20; $P catalogue build $D/none --links 8 -q", 3, "", "linkwright catalogue");
    expect("$P chains --links 10 >&-", 3, "", "cannot be written");
    expect("$P mechanisms <&-", 3, "", "cannot be read");
    expect("ln -s $D/six.g6 $D/link; $P mechanisms $D/six.g6 -o $D/link --force", 2, "", "is an input");
    demand("cp examples/space/superelement.json examples/space/box-*.mtx $D && for c in 'simulate --analysis static' 'convert --format mjcf' "
           "'robot jacobian' 'trace -n 1' mobility 'draw -f svg'; do $P $c $D/superelement.json -o $D/box-mass.mtx --force 2> $D/said; "
           "test $? = 3 && grep -q 'is an input' $D/said || exit 1; done; cmp $D/box-mass.mtx examples/space/box-mass.mtx",
           "an output that is a matrix of the model");
    expect("$P fit examples/ellipse.csv --save $D/six.g6", 3, "", "cannot be made");
    expect("$P drive load examples/drives/lifting-arm.json --to 0.1 --plot $D/p.svg -o $D/p.svg", 2, "", "are one file");
    expect("ln -s $D/nowhere $D/hanging; $P numbers --loops 3 -o $D/hanging", 3, "", "a link to a file that does not exist");
    expect("echo mine > $D/mine; ln $D/mine $D/q.partial; for c in 'chains --links 6' 'numbers --loops 3'; do $P $c -o $D/q; "
           "test $? = 2 || exit 1; done; grep -q mine $D/mine && test ! -e $D/q", 0, "", "linkwright did not finish it");
    expect("$P chains --links 10 | head -n 1 > $D/rows; test -s $D/rows", 0, "", NULL);
    demand("n=$D/$(printf %0250d 0); for o in \"-o $n\" \"--plot $n.svg\" \"--plot ${n%000000}.svg\"; do "
           "$P simulate examples/pendulum.json --to 1 $o 2> $D/said; test $? = 2 && grep -q 'name is too long' $D/said || exit 1; done; "
           "$P simulate examples/pendulum.json --to 1 -o ${n%000} -q && rm ${n%000} && mkdir $D/long-names && cp examples/ellipse.csv $n.csv && "
           "$P fit $n.csv --save $D/long-names 2> $D/said; test $? = 2 && grep -q 'become too long' $D/said && rm $n.csv", "long names");
}

/* No command and no action is missing from the tables; bench and studio have tests of their own kind. */
TEST(every_command_has_its_row)
{
    char words[64][48];
    for (int i = 0, n = all_commands(words, 64); i < n; i++) {
        int found = strcmp(words[i], "studio") == 0;         /* tests/test_cli_studio.c */
        size_t size = strlen(words[i]);
        for (int k = 0; k < N_ROW; k++)
            found += strncmp(rows[k].small, words[i], size) == 0 && rows[k].small[size] == ' ';
        for (size_t k = 0; k < sizeof long_runs/sizeof *long_runs; k++)
            found += strncmp(long_runs[k].slow, words[i], size) == 0 && long_runs[k].slow[size] == ' ';
        if (!found)
            fprintf(stderr, "'%s' has no row\n", words[i]);
        CHECK(found);
    }
}

static void prepare(void)
{
    demand("$P chains --links 6 -o $D/six.g6 && $P catalogue build $D/six.db --links 6 -q && "
           "cp $D/six.db $D/endless.db && cp $D/six.db $D/builds.db", "");
    demand("$P chains --links 4 -f lam -o $D/four.lam && $P catalogue curves $D/curves.db --links 4 --samples 100 -q && "
           "printf 'x,y\\n0,0\\n30,11\\n61,14\\n90,9\\n120,-6\\n' > $D/five.csv && mkdir $D/problems && yes '40 10 35 30' | head -n 1000000 > $D/lengths && "
           "cp examples/ellipse.csv $D/problems", "");
    /* nine points of a coupler curve: the search for all linkages through them takes minutes */
    demand("printf 'x,y\\n0.25,0\\n0.52,0.1\\n0.8,0.7\\n1.2,1\\n1.2,1.3\\n1.1,1.48\\n0.7,1.4\\n0.2,1\\n0.02,0.4\\n' > $D/nine.csv", "");
    /* an eight-bar with a higher group */
    demand("cp tests/data/linkages/triad-eight-bar.json $D/group.json", "");
    /* a pile of 300 boxes, chains of 4000 links in the plane and of 1000 bodies in space, a row of 299 parallelograms in space, as drawn and flat, many linkages, tables of many motors and gears */
    demand("python3 - $D << 'END'\n"
           "import json, sys\n"
           "def write(name, **model): json.dump({'linkwright': 1, 'gravity': [0, -9.81], **model}, open(sys.argv[1] + name, 'w'))\n"
           "links, joints, contacts = [{'name': 'ground', 'shapes': [{'line': [[-9, 0], [9, 0]]}]}], [], []\n"
           "for i in range(300):\n"
           "    x, y, name, under = i%30*0.3, 0.1 + i//30*0.25, 'b%d' % i, 'b%d' % (i - 30) if i >= 30 else 'ground'\n"
           "    links.append({'name': name, 'mass': 1, 'centre': [x, y], 'inertia': 0.007, 'shapes': [{'polygon': \n"
           "        [[x - .1, y - .1], [x + .1, y - .1], [x + .1, y + .1], [x - .1, y + .1]]}]})\n"
           "    joints.append({'name': 'F%d' % i, 'kind': 'n', 'links': ['ground', name]})\n"
           "    contacts.append({'name': 'c%d' % i, 'links': [under, name], 'friction': 0.5, 'restitution': 0.3})\n"
           "write('/pile.json', links=links, joints=joints, contacts=contacts)\n"
           "links, joints = ['ground'], []\n"
           "for i in range(4000):\n"
           "    links.append({'name': 'b%d' % i, 'mass': 1, 'centre': [i + .5, 0], 'inertia': .1})\n"
           "    joints.append({'name': 'J%d' % i, 'links': [links[i]['name'] if i else 'ground', 'b%d' % i], 'at': [i, 0]})\n"
           "write('/rope.json', links=links, joints=joints)\n"
           "links, joints = ['ground'], []\n"
           "for i in range(1000):\n"
           "    links.append({'name': 'b%d' % i, 'mass': 1, 'centre': [i + .5, 0, 0], 'inertia': [.1, .1, .1]})\n"
           "    joints.append({'name': 'J%d' % i, 'kind': 'revolute', 'links': ['b%d' % (i - 1) if i else 'ground', 'b%d' % i],\n"
           "                   'at': [i, 0, 0], 'axis': [0, i%2, 1 - i%2]})\n"
           "write('/snake.json', links=links, joints=joints, gravity=[0, 0, -9.81])\n"
           "links, joints, turns = ['ground'], [], {'kind': 'revolute', 'axis': [0, 0, 1]}\n"
           "for i in range(300):\n"
           "    for kind in 'rc': links.append({'name': kind + '%d' % i, 'mass': 1, 'centre': [i, 1, 0], 'inertia': [.1, .1, .1]})\n"
           "    joints.append({'name': 'G%d' % i, 'links': ['ground', 'r%d' % i], 'at': [i, 0, 0], **turns})\n"
           "    joints.append({'name': 'A%d' % i, 'links': ['r%d' % i, 'c%d' % i], 'at': [i, 1, 0], **turns})\n"
           "    if i: joints.append({'name': 'B%d' % i, 'links': ['c%d' % (i - 1), 'r%d' % i], 'at': [i, 1, 0], **turns})\n"
           "links.pop(), joints.pop(-2)\n"
           "write('/row.json', links=links, joints=joints, gravity=[0, 0, -9.81], inputs=[{'joint': 'G0', 'motion': 't'}],\n"
           "    tracers=[{'name': 'tool', 'link': 'c298', 'at': [299, 1, 0]}])\n"
           "flat = [{**j, 'at': [j['at'][0] + j['at'][1]/2, 0, 0]} for j in joints]\n"
           "write('/flat.json', links=links, joints=flat, gravity=[0, 0, -9.81], inputs=[{'joint': 'G0', 'motion': 't'}])\n"
           "write('/whip.json', joints=[{'name': 'J%d' % i, 'links': ['p%d' % i, 'p%d' % (i + 1)], 'at': [i, 0]} for i in range(500)],\n"
           "    ground='p0', inputs=[{'joint': 'J%d' % i, 'motion': '1000*t'} for i in range(500)])\n"
           "model, f = json.load(open('examples/chebyshev.json')), open(sys.argv[1] + '/many.json', 'w')\n"
           "for i in range(10000):\n"
           "    for joint in model['joints']: joint['at'][0] *= 1.0001\n"
           "    print(json.dumps(model), file=f)\n"
           "for name in 'motors.csv', 'gears.csv':\n"
           "    head, rows = [], []\n"
           "    for line in open('examples/drives/' + name):\n"
           "        (head if line[0] == '#' or line.startswith('name') else rows).append(line)\n"
           "    open(sys.argv[1] + '/' + name, 'w').write(''.join(head) + ''.join('%d%s' % (i, line) for i in range(300) "
           "for line in rows))\n"
           "END", "");
    /* a view in the place of the chains that never ends */
    demand("python3 - $D/endless.db << 'END'\n"
           "import sqlite3, sys\n"
           "db = sqlite3.connect(sys.argv[1])\n"
           "names = [row[1] for row in db.execute('PRAGMA table_info(chain)')]\n"
           "db.execute('PRAGMA legacy_alter_table=ON')\n"
           "db.execute('ALTER TABLE chain RENAME TO chain_rows')\n"
           "db.execute('CREATE VIEW chain AS WITH RECURSIVE x(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM x) '\n"
           "           'SELECT chain_rows.* FROM x, chain_rows')\n"
           "db.commit()\n"
           "db = sqlite3.connect(sys.argv[1].replace('endless', 'builds'))\n"
           "db.execute('ALTER TABLE build RENAME TO build_rows')\n"
           "db.execute('CREATE VIEW build AS WITH RECURSIVE x(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM x) '\n"
           "           'SELECT build_rows.* FROM x, build_rows')\n"
           "db.commit()\n"
           "END", "");
}

CHECK_MAIN
{
    static const struct { const char *name; int number; } signals[] = { { "HUP", SIGHUP }, { "INT", SIGINT }, { "TERM", SIGTERM }, { "KILL", SIGKILL } };
    char self[300] = "";
    for (int i = 0; argc > 2 && i < 4; i++)
        if (strcmp(argv[1], signals[i].name) == 0)
            return until_busy(signals[i].number, argv + 2);
    CHECK(readlink("/proc/self/exe", self, sizeof self - 1) > 0);
    setenv("T", self, 1);
    RUN(prepare);
    check_run();
    return check_end();
}

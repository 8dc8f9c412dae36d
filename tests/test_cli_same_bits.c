/* test_cli_same_bits.c - each command prints the same text with the kernels of each instruction set, with the C library's
 * variants for lesser processors, and in locales with a decimal comma or a Turkish i. */
#include <stdbool.h>
#include "tests/cli_run.h"

/* What a user compares; times of a run are not. */
static const char *const rows[] = {
    "$C fit examples/ellipse.csv --max-size 1.5 --crank-only --starts 5 --rounds 1 --json | grep -v seconds",
    "$C fit examples/walking-foot.csv --unlimited --links 6 --budget 1000 --starts 10 --rounds 1 --results 3 --json | grep -v seconds",
    "$C fit $D/timed.csv --unlimited --links 6 --topology watt1,stephenson3 --budget 1000 --starts 1 --rounds 1 --json | grep -v seconds",
    "$C fit $D/five.csv --exact --json | grep -v seconds",
    "$C trace examples/klann.json -n 24",
    "$C trace examples/jansen.json -n 24 --json",
    "$C fit examples/film-advance.csv --unlimited --crank-only --starts 5 --rounds 1 --json | grep -v seconds",
    "$C fit examples/function-log.csv --links 4 --starts 5 --rounds 1 --json | grep -v seconds",
    "$C fit examples/jobs/noisy-oval.csv --smooth auto --crank-only --unlimited --starts 5 --rounds 1 --tolerances 0.1,0.05 --json | grep -v seconds",
    "$C trace examples/trammel.json -n 12 --geometry",
    "$C trace examples/geared-five-bar.json -n 12",
    "$C trace examples/chebyshev.json --cycle -n 12",
    "$C trace tests/data/linkages/triad-eight-bar.json -n 6",
    "$C trace examples/space/bricard.json -n 6",
    "$C simulate examples/dynamics/governor.json --to 0.2 -n 20",
    "$C simulate examples/slider-crank.json --speed 10 --to 0.3 -n 8 --formulation driven",
    "$C simulate examples/pendulum.json --to 1 -n 8 --formulation quadrature",
    "$C simulate examples/pendulum.json --to 0.2 -n 8 --formulation reduced",
    "$C simulate examples/pendulum.json --to 0.1 -n 4 --formulation index1",
    "$C simulate examples/pendulum.json --to 0.1 -n 4 --formulation cvode",
    "$C simulate examples/pendulum.json --to 0.1 -n 4 --formulation ggl",
    "$C simulate examples/andrews.json --to 0.005 -n 4 --formulation radau",
    "$C simulate examples/elastic-cantilever.json --to 0.002 -n 2 --formulation alpha",
    "$C simulate examples/elastic-cantilever.json --to 0.002 -n 2 --formulation radau",
    "$C simulate examples/dynamics/boxes.json --to 0.15 -n 4 --formulation capture",
    "$C simulate examples/dynamics/boxes.json --to 0.15 -n 4",
    "$C simulate examples/elastic-frame.json --analysis static",
    "$C simulate examples/space/governor.json --to 0.02 -n 12 --formulation recursive",
    "$C simulate examples/space/governor.json --to 0.02 -n 2 --formulation index1",
    "$C simulate examples/space/delta.json --to 0.02 -n 2",
    "$C simulate examples/space/superelement.json --analysis static",
    "$C simulate examples/space/superelement.json --to 0.001 -n 2",
    "$C simulate examples/space/superelement-modes.json --to 0.001 -n 2",
    "$C simulate examples/space/crane.json --to 0.02 -n 2",
    "$C robot jacobian examples/space/delta.json --tool-at 0.2,0,-0.65",
    "$C robot map examples/space/delta-elastic.json --places 3 --eigenfrequency",
    "$C robot budget examples/space/delta-clearance.json --gear-play 0.02",
    "$C drive load examples/drives/lifting-arm.json --to 2.5 -n 20",
    "$C drive simulate examples/drives/servo-axis.json",
    "$C profile 90 --law modified-sine --duration 0.5 -n 20",
    "$C family sweep examples/families/loader.json --vary reach=2:3:2 -n 5",
    "$C simulate examples/andrews.json --to 0.01 -n 5",
    "$C simulate examples/pendulum.json --analysis linear",
    "$C clearance examples/clearance-four-bar.json --speeds 80 --to 0.05 --settle 0.01",
    "$C mobility examples/jansen.json",
    ("rm -f $D/c.db; $C catalogue curves $D/c.db --links 4 --samples 100 -q && $C catalogue nearest $D/c.db examples/ellipse.csv"),
    "$C draw examples/chebyshev.json -f svg",
    "$C convert examples/chebyshev.json --format pyslvs",
    "$C classify 40 10 35 30",
    "$C plasma $D/four.lam --target $D/five.csv --first 5 --budget 1000 --points 4 -q",
    "$C family table examples/families/loader.json",
    "$C family check examples/families/loader.json --json",
    "$C family expand examples/families/delta.json",
    "$C family optimise examples/families/loader.json --vary reach=2:3 --minimise 'peak(lift.drive)' --max-evaluations 10 -n 20",
    "$C drive select examples/drives/lifting-arm.json --to 2.5 -n 20 --motors examples/drives/motors.csv --gears examples/drives/gears.csv",
    "$C drive radius examples/drives/motors.csv --mass 20 --way 1",
    "$C robot workspace examples/space/delta.json --rays 3",
    "$C robot reachability examples/3-rrr.json --rays 3",
    "$C profile examples/cycles/gantry.json",
    "$C simulate examples/space/delta-elastic.json --analysis linear --rest",
};

/* Variants of the C library are chosen by the processor's features, which this variable takes away. */
static const char *const machines[] = {
    "LW_LESSER=1 LOCPATH=$D/locale LC_ALL=de_DE",
    "LW_LESSER=2 GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX LOCPATH=$D/locale LC_ALL=tr_TR",
};

/* In characters of one byte, of which tables are compiled in a tenth of the time of those of UTF-8. */
TEST(prepare)
{
    expect("mkdir $D/locale; for l in de_DE:1 tr_TR:9; do i=${l%:*}; for c in CTYPE:$i NUMERIC:$i COLLATE:POSIX MONETARY:POSIX TIME:POSIX MESSAGES:POSIX; do "
           "printf 'LC_%s\ncopy \"%s\"\nEND LC_%s\n' ${c%:*} ${c#*:} ${c%:*}; done > $D/$i; localedef -c -i $D/$i -f ISO-8859-${l#*:} $D/locale/$i; done; "
           "export LOCPATH=$D/locale; LC_ALL=de_DE bash -c 'printf \"%.1f\\n\" 1,5' && LC_ALL=tr_TR bash -c 'x=I; test ${x,,} = $(printf \"\\375\")'",
           0, "1,5", NULL);
    expect("printf 'x,y\\n0,0\\n30,11\\n61,14\\n90,9\\n120,-6\\n' > $D/five.csv && "
           "printf 'x,y,angle\\n0,0,0\\n30,11,0.3\\n61,14,0.6\\n90,9,0.9\\n120,-6,1.2\\n' > $D/timed.csv && $P chains --links 4 -f lam -o $D/four.lam", 0, NULL, NULL);
}

/* The others print whole numbers, names, or what a file holds; bench measures times, and the studio answers by the same functions. */
TEST(every_command_with_numbers_has_its_row)
{
    static const char *const others[] = { "numbers", "structures", "chains", "mechanisms", "grammar", "gallery", "catalogue build", "catalogue add",
        "catalogue query", "catalogue export", "catalogue check", "catalogue html", "catalogue release", "studio", "bench" };
    char words[64][48], call[64];
    for (int i = 0, n = all_commands(words, 64); i < n; i++) {
        bool found = false;
        snprintf(call, sizeof call, "$C %.47s ", words[i]);
        for (size_t k = 0; k < sizeof rows/sizeof *rows && !found; k++)
            found = strstr(rows[k], call) != NULL;
        for (size_t k = 0; k < sizeof others/sizeof *others && !found; k++)
            found = strncmp(words[i], others[k], strlen(others[k])) == 0;
        if (!found)
            fprintf(stderr, "'%s' has no row\n", words[i]);
        CHECK(found);
    }
}

TEST(same_everywhere)
{
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        OWN(ran) usual = run(rows[i]);
        if (usual.code != 0)
            fprintf(stderr, "%s\n  said: %s", rows[i], usual.err);
        CHECK_INT(usual.code, 0);
        CHECK(strlen(usual.out) > 20);
        for (size_t m = 0; m < (size_t)check_cases(sizeof machines/sizeof *machines); m++) {
            char line[1200];
            snprintf(line, sizeof line, "export %s; %s", machines[m], rows[i]);
            OWN(ran) other = run(line);
            CHECK_INT(other.code, usual.code);
            CHECK(strcmp(other.out, usual.out) == 0);
            if (strcmp(other.out, usual.out) != 0)
                fprintf(stderr, "differs: %s\n", line);
        }
    }
}

/* test_cli_faults.c - a call of the system fails: the command ends with code 3 or 4 and a message, or with all output.
 * The same holds with few files, files of no size, and little memory.
 *
 * One row a command, with measured times taken out of what it prints.  Each row runs undisturbed first, which tells
 * how often each kind of call is made, and from which places (tests/fail_at_call.c).  Then it runs once for each place of which no
 * call failed in a row before, and once for each other kind, with a call that LW_SEED chooses.  LW_FAULTS=n adds a spread of the calls
 * of each kind in each row, the first n, then ever longer steps, and all limits; LW_FAULTS_ROW=text runs the rows that hold the text. */
#include <stdbool.h>
#include "tests/cli_run.h"

enum { MEMORY_ERROR = 4, WRITE_ERROR = 3 };

/* A program that finds the gallery beside it, wherever it was built. */
#define PROGRAM_WITH_GALLERY "mkdir -p $D/bin $D/examples && cp $C $D/bin/linkwright && cp -r examples/gallery $D/examples/ && "

/* $C commands write to standard output or to $D/o, which is removed before each run. */
static const char *const rows[] = {
    "$C numbers --loops 4 --dof 2 --n2 1",
    "$C structures --loops 3",
    "$C chains --links 6 -j 1",
    "$C chains --links 6 -j 2 -o $D/o",
    "$C chains --links 8 -j 1 --filter planar",
    "$C mechanisms --links 6 --joints r,t",
    "$C mechanisms --keep-going --format franke < $D/watt.g6",
    "$C mechanisms --joints r,t --json < $D/watt.g6",
    "$C grammar parse --keep-going --format lam < $D/watt.g6",
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
    "$C simulate examples/pendulum.json --analysis linear --along 2",
    "$C convert examples/jansen.json --format pyslvs",
    "$C convert examples/chebyshev.json -o $D/o --format dxf",
    "$C draw examples/jansen.json -f svg -o $D/o",
    "$C draw examples/chebyshev.json -f html -o $D/o",
    "$C draw --grid 2x1 -f svg -o $D/o < $D/watt.g6",
    "$C clearance examples/clearance-four-bar.json --speeds 80 --to 0.02 --settle 0.01",
    "rm -f $D/a.db; $C catalogue build $D/a.db --links 6 -q -j 1 && $P catalogue export $D/a.db",
    ("rm -f $D/a.db; $C catalogue curves $D/a.db --links 4 --samples 40 -q -j 1 && $P catalogue nearest $D/a.db examples/ellipse.csv"),
    "$C catalogue query $D/six.db 'links=6'",
    "$C catalogue query $D/six.db 'links=6' -f csv -o $D/o",
    "$C catalogue query $D/six.db 'SELECT count(*) FROM chain' --sql",
    "$C catalogue export $D/six.db -f lam",
    "$C catalogue nearest $D/curves.db examples/ellipse.csv",
    "$C catalogue check $D/six.db",
    "rm -f $D/a.db; $C catalogue add $D/a.db $D/fit.json && $P catalogue query $D/a.db error\\<1",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --crank-only --starts 1 --rounds 1 --results 2 -j 1 --json -o $D/o",
    "rm -rf $D/web; $C catalogue html $D/six.db -o $D/web -q && cat $D/web/*.html",
    "$C profile 2 --speed-limit 1 --acceleration-limit 20 -o $D/o",
    "$C profile 1 --acceleration-limit 20 --jerk-limit 400",
    "$C trace tests/data/linkages/triad-eight-bar.json -n 4",
    "$C draw tests/data/linkages/triad-eight-bar.json -f svg -o $D/o",
    "$C plasma $D/four.lam --target $D/five.csv --first 5 --budget 1000 --points 4 -q",
    "$C plasma $D/four.lam --target $D/five.csv --first 5 --budget 1000 --points 4 -q --ground 1 --input-joint 1 --tracer-link 3 --crank-only --length-unit mm "
    "--save $D/out -o $D/o --force",
    "$C bench fit --problems $D/problems --solvers lm --seeds 0 --time 0.01 -o $D/out -q > $D/table && ls $D/out",
    "$C bench mbs --cases pendulum --tolerance-range 1e-4:1e-4 --peers none --time 0.001 -o $D/out -q > $D/table && ls $D/out",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --links 6 --topology watt1 --budget 1000 --starts 1 --rounds 1 --results 1 -j 2 -q",
    "rm -rf $D/release; $C catalogue release -o $D/release --links 7 -q && cat $(find $D/release -type f | sort)",
    "$C drive load examples/drives/lifting-arm.json --to 0.1 -n 5",
    "$C drive load examples/drives/lifting-arm.json --to 0.1 -n 5 --plot $D/o.svg --force",
    "$C drive simulate examples/drives/servo-axis.json -n 8 --to 0.05",
    "$C drive select examples/drives/lifting-arm.json --to 2.5 -n 20 --motors examples/drives/motors.csv --gears examples/drives/gears.csv",
    "$C drive radius examples/drives/motors.csv --mass 20 --way 1 --wanted-acceleration 3 --json",
    "$C profile examples/cycles/gantry.json",
    "$C family expand examples/families/loader.json -o $D/o",
    "$C family table examples/families/loader.json",
    "$C family check examples/families/loader.json",
    "$C family sweep examples/families/loader.json --vary reach=2:3:3 -n 10 -j 2",
    "$C family optimise examples/families/loader.json --vary reach=2:3 --minimise boom_mass --require boom_mass\\<=200 --solver sbplx "
    "--max-evaluations 20",
    "$C robot jacobian examples/space/stewart.json --tool-turn 0,0,5",
    "$C robot budget examples/space/delta-clearance.json --gear-play 0.02 --slide-play 1e-4 --tool-force 0,0,-5",
    "$C robot workspace examples/space/delta.json --rays 3 -o $D/o",
    "$C robot reachability examples/3-rrr.json",
    "$C robot map examples/space/delta.json --places 3",
    "$C trace examples/space/bricard.json -n 4",
    "$C trace examples/klann.json -n 8 --geometry --plot $D/o.svg --force",
    "$C mobility examples/space/sarrus.json --tolerance 1e-9",
    "$C simulate examples/space/governor.json --to 0.01 -n 2",
    "$C draw examples/space/delta.json --azimuth 20 --elevation 10 -f svg -o $D/o",
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
    "$C drive simulate examples/drives/servo-axis.json -n 8 --to 0.05 --bode $D/o.svg --matrices-folder $D/out --force",
    "$C profile 0.5 0.3 -0.8 --acceleration-limit 2 --dwell 0.2",
    "$C mechanisms --links 6 --multiple-joints",
    "rm -f $D/a.db; $C catalogue add $D/a.db $D/curves.db -q && $P catalogue nearest $D/a.db examples/ellipse.csv",
    "XDG_STATE_HOME=$D XDG_CACHE_HOME=$D tests/studio_ask.py $D/bin/linkwright studio --no-browser -q --port 0 --atlas $D/curves.db",
    "$D/bin/linkwright gallery klann",
};

/* The same for each option, and each kind of output and of input file, with a call of one kind by chance, and without limits unless
 * LW_FAULTS asks for them. */
static const char *const outputs[] = {
    "$C numbers --loops 4 --labelled --json",
    "$C structures --loops 4 --derive --non-planar",
    "$C structures --loops 4 --count --part 1/2",
    "$C structures --replay 'theta 3(1,2)'",
    "rm -f $D/s; $C structures --loops 5 --count --structures $D/s && cksum < $D/s",
    "$C chains --links 8 --count --by assortment",
    "rm -f $D/k; $C chains --links 8 --count -j 1 --keep $D/k",
    "rm -f $D/s; $C chains --links 8 --count -j 1 --structures $D/s && cksum < $D/s",
    "$C chains --links 7 --dof 2 --fractionated --json",
    "$C chains --links 8 --count --filter generating",
    "$C chains --links 8 --count --filter asymmetric",
    "$C structures --loops 4 --planar",
    "$C chains --links 6 --format graph6",
    "$C chains --links 6 --planar --format lam",
    "$C chains --links 6 --format sentence",
    "$C chains --links 6 --format franke",
    "$C chains --links 10 --non-planar --part 2/2 --format edges",
    "$C chains --links 6 --format json",
    "$C chains --links 6 --format dot",
    "$C chains --links 6 --format graphml",
    "$C mechanisms --links 4 --joints r,t --void",
    "$C mechanisms --links 6 --input ground --assur",
    "$C mechanisms --assur-groups 4",
    "$C mechanisms --links 4 --joints r,t --input any --output-link --count",
    "$C classify $D/lengths.csv --tolerance 1e-9 --angle-unit rad",
    "$D/bin/linkwright gallery --json",
    "$C profile 1 --from-state 0.1,0 --to-state 0.2,0 --swing 8 --acceleration-limit 20 --jerk-limit 400 -n 5 --plot $D/x.svg && cksum < $D/x.svg",
    "$C trace examples/chebyshev.json --cycle --tracer P -n 8",
    "$C trace examples/gallery/peaucellier.json --all-assemblies -n 2",
    "$C trace examples/loader.json --time-range 0:0.2:0.1",
    "$C trace examples/klann.json --explain",
    "$C mobility examples/mobility/focal.json --json",
    "$C simulate examples/slider-crank.json --speed 6 --balance",
    "$C simulate examples/slider-crank.json --speed 6 --analysis quasistatic --to 0.1 -n 2",
    "$C simulate examples/pendulum.json --analysis linear --rest --fft",
    "$C simulate examples/andrews.json --to 0.001 -n 2 --formulation radau",
    "$C simulate examples/dynamics/governor.json --to 0.001 -n 2 --formulation index1 --explain",
    "$C simulate examples/pendulum.json --from 0.001 --to 0.01 -n 2 --formulation cvode --tolerance 1e-6 --max-steps 1000",
    "$C simulate examples/pendulum.json --to 0.01 -n 2 --formulation ggl",
    "$C simulate examples/elastic-cantilever.json --to 1e-4 -n 1 --formulation alpha --rho 0.5",
    "$C simulate examples/dynamics/boxes.json --to 0.02 -n 2 --formulation capture",
    "$C simulate examples/space/governor.json --to 0.001 -n 1 --formulation recursive",
    "$C simulate examples/space/superelement.json --analysis static",
    "$C simulate examples/space/delta-clearance.json --to 1e-5 -n 1",
    "$C simulate examples/pendulum.json --to 0.1 -n 4 --columns kinetic --plot $D/x.svg --gif $D/x.gif && cksum < $D/x.svg && cksum < $D/x.gif",
    "$C clearance examples/clearance-four-bar.json --speeds 80 --to 0.01 --settle 0 --every 1e-3 --passes $D/w.svg --path $D/x.svg --force-plot $D/y.svg --history $D/z.csv && cksum < $D/w.svg && cksum < $D/x.svg && cksum < $D/y.svg && cat $D/z.csv",
    "$C clearance examples/clearance-four-bar.json --speeds 80,90 --stiffness 1e6,1e7 --damping 100 --start seated --tolerance 1e-8 --to 0.01 --settle 0 --plot $D/x.svg && cksum < $D/x.svg",
    "$C robot map examples/space/delta-clearance.json --errors --places 3",
    "$C robot workspace examples/3-rrr.json --rays 3 --plot $D/x.svg && cksum < $D/x.svg",
    "$C robot map examples/3-rrr.json --links-only --places 3 --plot $D/x.svg && cksum < $D/x.svg",
    "$C drive load examples/slider-crank.json --from 0.05 --to 0.1 -n 5 --speed 1 --plot $D/x.svg && cksum < $D/x.svg",
    "$C drive select examples/drives/lifting-arm.json --to 2.5 -n 20 --motors examples/drives/motors.csv --gears examples/drives/gears.csv --amplifiers examples/drives/amplifiers.csv --drive shoulder --inertia-ratio 20 --results 3 "
    "--plot $D/x.svg && cksum < $D/x.svg",
    "$C drive simulate examples/drives/servo-axis.json --to 0.05 --matrices $D/m.json --plot $D/x.svg && cat $D/m.json && cksum < $D/x.svg",
    "$C family expand examples/families/loader.json --map $D/m.csv && cat $D/m.csv",
    "$C family sweep examples/families/loader.json --configuration large --set drop=1 --view dynamic --measure 'peak(lift.drive)' --vary reach=2:3:2 "
    "--from 0.1 --to 0.5 -n 5 --normalised --plot $D/x.svg && cksum < $D/x.svg",
    "$C family sweep examples/families/loader.json --vary reach --sensitivity -n 5 -j 1",
    "$C convert examples/chebyshev.json --format json",
    "$C convert examples/chebyshev.json --format pmks --length-unit mm --input-joint A",
    "$C convert examples/chebyshev.json --format adams",
    "$C convert examples/space/delta.json --format mjcf",
    "$C convert examples/chebyshev.json --format urdf",
    "$C convert examples/chebyshev.json --format sdf",
    "$C convert examples/chebyshev.json --format acf",
    "$C convert examples/chebyshev.json --format scad",
    "$C convert examples/chebyshev.json --format step",
    "$C convert examples/chebyshev.json --format stl",
    "$C convert examples/chebyshev.json --format slvs",
    "$C convert examples/chebyshev.json --format svg",
    "$C convert $D/fit.json --result 2 --format poses",
    "$C convert examples/chebyshev.json --format motiongen",
    "$C convert $D/in.adm --format json",
    "$C convert $D/in.pmks --format json",
    "$C convert $D/in.pyslvs --format json",
    "$C draw examples/hoeken.json --target examples/ellipse.csv --all-modes -f svg --title 'a title' --size 300x200",
    "rm -f $D/x-*; $C draw --each --caption graph6 --numbers --keep-going -o $D/x.svg < $D/six.g6 && cat $D/x-*.svg | cksum",
    "$C draw --grid 2x1 -f pdf -o $D/x.pdf --force < $D/watt.g6 && cksum < $D/x.pdf",
    "rm -rf $D/out; LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --crank-only --starts 1 --rounds 1 --results 1 -j 1 -q --save $D/out && ls $D/out && cat $D/out/*.json",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --task path --timing prescribed --angle-from frame --weight-path 2 --weight-angle 3 --angle-length 5 --length-range 1:500 --position-range -500:500 --solver lbfgs "
    "--starts 1 --rounds 1 --results 1 -j 1 -q --plot $D/x.svg && cksum < $D/x.svg",
    "rm -f $D/k; LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --crank-only --open --length-unit mm --angle-unit deg "
    "--starts 1 --rounds 1 --results 1 -j 1 -q --keep $D/k",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --closed --full-turn "
    "--starts 1 --rounds 1 --results 1 -j 1 -q --start-from $D/fit.json",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --crank-only --smooth 0.1 "
    "--starts 1 --rounds 1 --results 1 -j 1 -q --tolerances 0.1,0.05",
    "LW_CLOCK_STEP=1e-9 $C fit examples/drawings/step-librecad.dxf#all --point-links any --stations 8 --unlimited --starts 1 --rounds 1 --results 1 -j 1 -q",
    "rm -f $D/a.db; $C catalogue build $D/a.db --links 4 --joints r,t --multiple-joints --input any --no-pictures --wait 1 --commit 1 --time 60 -q -j 1 && $P catalogue export $D/a.db",
    "rm -f $D/a.db; $C catalogue add $D/a.db examples/drives/motors.csv -q && $P catalogue query $D/a.db 'SELECT count(*) FROM motor' --sql",
    "rm -f $D/a.db; $C catalogue curves $D/a.db --links 6 --curves both --part 1/1 --samples 5 -q -j 1 && $P catalogue nearest $D/a.db examples/ellipse.csv",
    "$C simulate examples/dynamics/cantilever.json --analysis linear --modes 3",
    "$C simulate examples/space/delta-elastic.json --analysis linear --rest",
    "$C catalogue query $D/six.db --fields",
    "$C catalogue query $D/six.db links=6 -f json --list mechanisms",
    "$C catalogue query $D/six.db links=6 -f table",
    "$C catalogue export $D/six.db -f graph6",
    "$C catalogue export $D/six.db -f sentence",
    "$C catalogue export $D/six.db -f franke",
    "$C catalogue export $D/six.db -f edges",
    "$C catalogue export $D/six.db -f dot",
    "$C catalogue export $D/six.db -f graphml",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --min-transmission-angle 0 --type fourbar --max-size 1.5 --length-ratio 100 --class-margin 0 --through-limits "
    "--max-acceleration 1e4 --tolerance 10 --bounds r1=1:400 --starts 1 --rounds 1 --results 2 -j 2 -q",
    "LW_CLOCK_STEP=1e-9 $C fit $D/five.csv --exact -j 1 --json -q",
    "$C robot map examples/space/delta-elastic.json --eigenfrequency --places 3 --plot $D/o.svg --force",
    "$C simulate examples/elastic-cantilever.json --rigid --to 0.01 -n 2",
    "$C robot workspace examples/3-rrr.json --rays 3 --max-condition 10",
    "$C robot budget examples/space/delta-clearance.json --joint-gap 1e-4",
    "$C drive simulate examples/drives/servo-axis.json --to 0.05 -n 4 --band 0.01",
    "$C profile 1 --straight 0.5 --speed-limit 1 --acceleration-limit 20",
    "$C mechanisms --links 4 --joints r,t --slider-direction",
    "$C grammar derive --links 6 --rules 1,2,3 --joints r,t --anywhere --count",
    "$C grammar derive --sentence '((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r))' --rule 4 --at 3,4 --word 1 --joints r,r,t",
    "$C catalogue query $D/six.db links=6 --columns links,graph6 --sort links --results 2",
    "$C catalogue check $D/six.db --disagreeing",
    "$C convert $D/in.pmks --from-format pmks --format stl --plate-width 10 --plate-thickness 3 --hole 4 --hole-clearance 0.2",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --links 5 --joints r,g --gear-ratios 2,-1 --budget 1000 --starts 1 --rounds 1 --results 1 -j 1 -q",
    "LW_CLOCK_STEP=1e-9 $C fit $D/timed.csv --unlimited --links 5 --dof 2 --input-ratios 2 --budget 1000 --starts 1 --rounds 1 --results 1 -j 1 -q",
    "$C trace $D/fit.json --result 2 --mode file --input-range 10:40 --speed 60rpm -n 4",
    "$C mobility $D/fit.json --result 2",
    "$C draw $D/fit.json --result 2 --to 1 -f svg",
    "$C simulate examples/dynamics/cantilever.json --analysis linear --hold",
    "$C simulate $D/space.json --planar --to 0.01 -n 2",
    "$C clearance examples/clearance-four-bar.json --speeds 8,9 --speed-unit rad/s --model impact --limits --refine 0.5 --to 0.01 --settle 0",
    "$C profile 1 --law cycloid --duration 0.5 -n 4",
    "$C profile 1 --acceleration-limit 20 --frequency 5",
    "$C profile 1 --power 10 --mass 2",
    "$C robot jacobian examples/space/delta.json --tool tool --tool-at 0,0,-0.65",
    "$C robot jacobian examples/space/delta.json --drives-at 1,2,3",
    "$C robot workspace examples/space/delta.json --volume --rays 3",
    "$C family sweep examples/families/loader.json --vary reach=2:3 --samples 2 -n 5",
    "$C family sweep $D/cranks.json --vary mass=1:2:2 --speed 3 -n 5",
    "$C family optimise examples/families/loader.json --vary reach=2:3 --maximise boom_mass --max-evaluations 20",
    "rm -f $D/r; $P chains --links 8 -q -o $D/r; $C chains --links 8 --resume -o $D/r && cksum < $D/r",
    "$C mechanisms --links 5 --dof 2 --no-ground --format lam",
    "$C mechanisms --links 3 --n2 1 --joints r,g --translating-cams",
    "$C mechanisms --links 7 --dof 2 --multiple-joints --fractionated",
    "rm -f $D/a.db; $C catalogue build $D/a.db --links 5 --dof 2 -q -j 1 && $P catalogue export $D/a.db",
    "rm -f $D/a.db; $C catalogue curves $D/a.db --type slidercrank --samples 20 -q -j 1 && $P catalogue query $D/a.db --sql 'SELECT count(*) FROM curve_segment'",
    "$C catalogue nearest $D/curves.db examples/ellipse.csv --shape closed --full-turn --min-transmission-angle 10 --length-range 1:500 --results 3",
    "$C bench fit --problems $D/problems --solvers lm --seeds 1 --seed 2 --reach-time 0.05 --time 0.01 -q > $D/table",
    "rm -f $D/k; $C bench fit --problems $D/problems --links 6 --budget 1000 --both-ways --keep $D/k --part 2/2 -q > $D/table && cat $D/k",
};

enum { N_ROW = sizeof rows/sizeof *rows, N_OUTPUT = sizeof outputs/sizeof *outputs };

/* Has the row this word, with this value after it (NULL: any)? */
static bool has_word(const char *row, const char *word, const char *value)
{
    size_t length = strlen(word), of_value = value ? strlen(value) : 0;
    for (const char *at = row; (at = strstr(at, word)); at += length)
        if (at > row && at[-1] == ' ' && (at[length] == 0 || at[length] == ' ')
            && (!value || (at[length] && strncmp(at + length + 1, value, of_value) == 0 && (at[length + 1 + of_value] == 0 || at[length + 1 + of_value] == ' '))))
            return true;
    return false;
}

static bool runs(const char *row, const char *command)
{
    char call[2][64];
    snprintf(call[0], sizeof call[0], "$C %.47s ", command);
    snprintf(call[1], sizeof call[1], "bin/linkwright %.47s ", command);
    return strstr(row, call[0]) || strstr(row, call[1]);
}

/* Does a row run the command with this option and value (NULL: any)? */
static bool has_option(const char *command, char letter, const char *option, const char *value)
{
    char word[64], brief[3] = { '-', letter, 0 };
    snprintf(word, sizeof word, "--%s", option);
    for (int i = 0; i < N_ROW + N_OUTPUT; i++) {
        const char *row = i < N_ROW ? rows[i] : outputs[i - N_ROW];
        if (runs(row, command) && (has_word(row, word, value) || (letter && has_word(row, brief, value))))
            return true;
    }
    fprintf(stderr, "'%s --%s%s%s' has no row\n", command, option, value ? " " : "", value ? value : "");
    return false;
}

/* The line of an option in the help of a command: each has a row, those of --mpi in test_cli_enumerate.c, and each format has one.  Pictures of chains do not
 * depend on the notation that the chains are read in (`draw`); the notations of grammar and mechanisms are those of chains. */
static void check_option(const char *command, char *line)
{
    char letter = 0, option[32], argument[160] = "";
    char *at = strstr(line, "--");
    if (sscanf(line, " -%c,", &letter) == 1 && letter == '-')
        letter = 0;
    if (!at || sscanf(at, "--%31[a-z0-9-] %159s", option, argument) < 1 || strcmp(option, "mpi") == 0)
        return;
    CHECK(has_option(command, letter, option, NULL));
    if (strcmp(option, "format") == 0 && strcmp(command, "grammar") != 0 && strcmp(command, "mechanisms") != 0)
        for (char *word = strtok(argument, "|"); word; word = strtok(NULL, "|"))
            CHECK((strcmp(command, "draw") == 0 && !strstr("svg pdf png gif html", word)) || has_option(command, letter, option, word));
}

TEST(every_option_has_its_row)
{
    char words[64][48];
    int n_option = 0;
    for (int i = 0, n = all_commands(words, 64); i < n; i++) {
        words[i][strcspn(words[i], " ")] = 0;                    /* actions share the options of their command */
        if (i > 0 && strcmp(words[i], words[i - 1]) == 0)
            continue;
        ran r = run_with("$P help %.47s", words[i]);
        char *own = strstr(r.out, "\nOptions:"), *all = strstr(r.out, "\nOptions of every command:");
        if (all)
            *all = 0;
        for (char *at = own ? own + 1 : NULL; at; at = strchr(at, '\n'), at += at != NULL)
            if (strncmp(at, "  -", 3) == 0 || strncmp(at, "      --", 8) == 0) {
                char copy[256];
                snprintf(copy, sizeof copy, "%.*s", (int)strcspn(at, "\n"), at);
                check_option(words[i], copy);
                n_option++;
            }
        ran_free(&r);
    }
    CHECK(n_option > 250);
}

TEST(every_command_has_its_row)
{
    char words[64][48];
    for (int i = 0, n = all_commands(words, 64); i < n; i++) {
        bool found = false;
        for (int k = 0; k < N_ROW && !found; k++)
            found = runs(rows[k], words[i]);
        if (!found)
            fprintf(stderr, "'%s' has no row\n", words[i]);
        CHECK(found);
    }
}

/* A library that is loaded late is not installed: each command that needs it names its package, and leaves no output. */
TEST(missing_libraries)
{
    static const struct { const char *library, *package, *command; } missing[] = {
        { "igraph", "libigraph3", "$C structures --loops 4" },
        { "igraph", "libigraph3", "$C structures --loops 4 --count --part 1/2" },
        { "igraph", "libigraph3", "$C chains --links 6" },
        { "igraph", "libigraph3", "$C chains --links 8 --count" },
        { "igraph", "libigraph3", "$C chains --links 4 --count --filter asymmetric" },
        { "igraph", "libigraph3", "$C chains --links 7 --dof 2 --fractionated" },
        { "igraph", "libigraph3", "$C mechanisms --links 6" },
        { "igraph", "libigraph3", "$C mechanisms --links 6 --joints r,t" },
        { "igraph", "libigraph3", "$C mechanisms --links 6 --multiple-joints" },
        { "igraph", "libigraph3", "$C mechanisms --assur-groups 4" },
        { "igraph", "libigraph3", "$P chains --links 6 | $C mechanisms" },
        { "igraph", "libigraph3", "$C grammar derive --links 6" },
        { "igraph", "libigraph3", "$C grammar coverage --links 6" },
        { "igraph", "libigraph3", "$C fit examples/ellipse.csv --links 6 --budget 1000" },
        { "igraph", "libigraph3", "$C catalogue build $D/hidden.db --links 6 -q" },
        { "igraph", "libigraph3", "$C catalogue curves $D/hidden.db --links 6 --samples 10 -q" },
        { "igraph", "libigraph3", "$C catalogue release -o $D/hidden --links 7 -q" },
        { "igraph", "libigraph3", "mkdir -p $D/one && cp examples/ellipse.csv $D/one && $C bench fit --problems $D/one --links 6 --budget 1000" },
        { "cairo", "libcairo2", "$C draw examples/hoeken.json -f png -o $D/hidden.png" },
        { "cairo", "libcairo2", "$C draw examples/hoeken.json -f gif -n 2 -o $D/hidden.gif" },
        { "microhttpd", "libmicrohttpd12", "XDG_STATE_HOME=$D XDG_CACHE_HOME=$D $C studio --no-browser --time 1" },
    };
    for (size_t i = 0; i < sizeof missing/sizeof *missing; i++) {
        expect_with(3, "", missing[i].package, "export LW_HIDE=%s; %s", missing[i].library, missing[i].command);
    }
    expect("test ! -e $D/hidden/SHA256SUMS && rm -r $D/hidden && rm -f $D/hidden.db; ls -d $D/hidden* && exit 1; rm -r $D/one", 0, "", NULL);
    expect("LW_HIDE=igraph $C catalogue release -o $D/hidden --links 7", 3, "", "only a part of the data set, without SHA256SUMS");
    expect("rm -r $D/hidden", 0, "", NULL);
}

/* Work that would take too much memory is not begun, either, when memory runs out while this is estimated. */
TEST(estimates_that_fail)
{
    expect("$C structures --loops 12 -q", MEMORY_ERROR, "", "need about");
    expect("LW_FAIL=malloc:5000 timeout 60 $C structures --loops 12 -q", MEMORY_ERROR, "", "out of memory");
}

static const char *const kinds[] = { "malloc", "fsync", "rename", "pthread_create", "write", "jansson", "sqlite" };
enum { N_KIND = sizeof kinds/sizeof *kinds };

static ran run_once(const char *command, char **file)
{
    char path[300], partial[320];
    snprintf(path, sizeof path, "%s/o", getenv("D"));
    snprintf(partial, sizeof partial, "%s.partial", path);
    remove(path);
    remove(partial);
    ran r = run(command);
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
    bool memory = strncmp(by, "malloc:", 7) == 0;         /* no fault of an input */
    bool said = (r.code == MEMORY_ERROR || (r.code == WRITE_ERROR && !memory)) && strstr(r.err, "linkwright") != NULL;
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

static void limit(const char *command, const char *by, const ran *whole, const char *whole_file)
{
    char limited[600], program[300];
    snprintf(program, sizeof program, "%s", getenv("C"));
    snprintf(limited, sizeof limited, "prlimit %s %s", by, program);
    setenv("C", limited, 1);
    disturb(command, by, whole, whole_file);
    setenv("C", program, 1);
}

/* Lack of memory is named, not a kind of mechanism that was left out before, or a file that cannot be read. */
TEST(last_failure_is_named)
{
    for (int n = 8; n < 16; n++)                 /* among them those of the matrices that the model names */
        expect_with(MEMORY_ERROR, "", "out of memory", "LW_FAIL=malloc:%d $C simulate examples/space/superelement.json --analysis static", n);
    for (int n = 4; n < 9; n++)
        expect_with(MEMORY_ERROR, "", "memory", "rm -f $D/k; LW_FAIL=malloc:%d $C chains --links 8 --count -j 1 --keep $D/k", n);
    for (int n = 11; n < 14; n++)                /* among them that of the last line of a listing that is continued */
        expect_with(MEMORY_ERROR, NULL, "memory", "rm -f $D/r; $P chains --links 8 -q -o $D/r; LW_FAIL=malloc:%d $C chains --links 8 --resume -o $D/r", n);
    for (int n = 13; n < 17; n++)                /* a sentence that is not made was left out, with code 0 */
        expect_with(MEMORY_ERROR, NULL, "memory", "LW_FAIL=malloc:%d $C chains --links 6 --format sentence -j 1", n);
    for (int n = 165; n < 168; n++)
        expect_with(MEMORY_ERROR, NULL, "memory", "LW_FAIL=malloc:%d $C numbers --loops 4 --labelled --json", n);
    expect(PROGRAM_WITH_GALLERY "LW_CALLS_FILE=$D/calls $D/bin/linkwright gallery --json && LW_FAIL=jansson:$(sed -n 's/^jansson //p' $D/calls) $D/bin/linkwright gallery --json",
           MEMORY_ERROR, NULL, "memory");
    for (int n = 8; n < 13; n++)                 /* among them one in which jansson's own reader would lose a byte, and read past its memory */
        expect_with(MEMORY_ERROR, "", "memory", "LW_FAIL=jansson:%d $C simulate examples/dynamics/cantilever.json --analysis linear", n);
    if (!SANITIZED)
        expect("rm -f $D/a.db; prlimit --data=11000000 $C catalogue curves $D/a.db --links 6 --samples 1 -q -j 2", MEMORY_ERROR, "", "out of memory");
}

/* The places of which a call has failed. */
static struct { size_t n; unsigned long long key[1 << 14]; } failed;

static bool fails_first(unsigned long long key)
{
    for (size_t i = 0; i < failed.n; i++)
        if (failed.key[i] == key)
            return false;
    CHECK(failed.n < sizeof failed.key/sizeof *failed.key);
    failed.key[failed.n++%(sizeof failed.key/sizeof *failed.key)] = key;
    return true;
}

/* Fail the first call of each place in $D/calls of which none has failed.  Returns the kinds of these calls, as bits. */
static unsigned fail_new_places(const char *command, const ran *whole, const char *whole_file)
{
    char path[300], kind[32];
    long n;
    unsigned long long key;
    unsigned of_kind = 0;
    snprintf(path, sizeof path, "%s/calls", getenv("D"));
    FREED char *text = slurp(path);
    for (const char *at = text; (at = strstr(at, "\nplace ")); at++)
        if (sscanf(at, " place %31[a-z_]:%ld %llx", kind, &n, &key) == 3 && fails_first(key)) {
            fail_one(command, kind, n, whole, whole_file);
            for (int k = 0; k < N_KIND; k++)
                of_kind |= (unsigned)(strcmp(kind, kinds[k]) == 0) << k;
        }
    return of_kind;
}

static void fail_each(int row, const char *command)
{
    static const char *const limits[] = { "--nofile=4", "--nofile=6", "--fsize=0", "--data=2000000", "--data=10000000" };
    enum { N_LIMIT = sizeof limits/sizeof *limits };
    char calls[300], *file;
    lw_rng rng = check_rng(strlen(command));
    const char *dense = getenv("LW_FAULTS");
    snprintf(calls, sizeof calls, "%s/calls", getenv("D"));
    setenv("LW_CALLS_FILE", calls, 1);
    ran whole = run_once(command, &file);
    unsetenv("LW_CALLS_FILE");
    if (whole.code != 0)
        fprintf(stderr, "%s\n  said: %s", command, whole.err);
    CHECK_INT(whole.code, 0);
    unsigned by_chance = ~fail_new_places(command, &whole, file);
    if (row >= N_ROW) {                                                      /* of one kind, which has calls */
        int k = (int)(lw_rng_bits(&rng)%N_KIND);
        while (count_calls(kinds[k]) == 0)
            k = (k + 1)%N_KIND;
        by_chance = 1u << k;
    }
    for (int k = 0; k < N_KIND && !SANITIZED; k++) {
        long n_call = count_calls(kinds[k]);
        if (n_call > 0 && by_chance >> k & 1)
            fail_one(command, kinds[k], 1 + (long)(lw_rng_bits(&rng) % (uint64_t)n_call), &whole, file);
        for (long n = 1; dense && n <= n_call; n = n < atol(dense) ? n + 1 : (long)((1 + 3/atof(dense))*(double)n))
            fail_one(command, kinds[k], n, &whole, file);
    }
    for (int k = 0; k < N_LIMIT && !SANITIZED; k++)                          /* sanitizers need files and terabytes themselves */
        if (dense || (row < N_ROW && (k == row%N_LIMIT || k == (row + 2)%N_LIMIT)))
            limit(command, limits[k], &whole, file);
    ran_free(&whole);
    free(file);
}

/* Nobody would know where a studio is whose address is lost. */
TEST(a_lost_address_ends_the_studio)
{
    expect("XDG_STATE_HOME=$D XDG_CACHE_HOME=$D timeout 60 $P studio --no-browser > /dev/full", WRITE_ERROR, "", "cannot be written");
}

TEST(faults)
{
    const char *only = getenv("LW_FAULTS_ROW");
    expect("$P chains --links 6 -o $D/six.g6 && head -n 1 $D/six.g6 > $D/watt.g6 && "
           "$P chains --links 4 -f lam -o $D/four.lam && $P catalogue build $D/six.db --links 6 -q && "
           PROGRAM_WITH_GALLERY
           "mkdir $D/problems && cp examples/ellipse.csv $D/problems && "
           "printf 'x,y,angle\\n0,0,0\\n30,11,0.3\\n61,14,0.6\\n90,9,0.9\\n120,-6,1.2\\n' > $D/timed.csv && "
           "$P catalogue curves $D/curves.db --links 4 --samples 200 -q && "
           "$P fit examples/ellipse.csv --unlimited --starts 20 --rounds 1 --json -o $D/fit.json -q && "
           "printf 'x,y\\n0,0\\n30,11\\n61,14\\n90,9\\n120,-6\\n' > $D/five.csv", 0, NULL, NULL);
    expect("for f in adams pmks pyslvs; do $P convert examples/chebyshev.json --format $f > $D/$f || exit 1; done; cd $D && mv adams in.adm && "
           "mv pmks in.pmks && mv pyslvs in.pyslvs && printf '40,10,35,30\\n1,2,3,4\\n' > lengths.csv && "
           "echo '{\"linkwright\": 1, \"gravity\": [0, -9.81, 0], \"links\": [\"ground\", {\"name\": \"rod\", \"mass\": 2, \"centre\": [1, 0, 0], "
           "\"inertia\": [1, 2, 2]}], \"joints\": [{\"name\": \"O\", \"kind\": \"revolute\", \"links\": [\"ground\", \"rod\"], \"at\": [0, 0, 0], \"axis\": [0, 0, 1]}]}' "
           "> space.json && "
           "echo '{\"linkwright\": 1, \"family\": \"cranks\", \"parameters\": {\"mass\": {\"value\": 2, \"unit\": \"kg\"}}, \"model\": {\"links\": [\"ground\", "
           "{\"name\": \"rod\", \"mass\": \"=mass\", \"centre\": [1, 0]}], \"joints\": [{\"name\": \"O\", \"links\": [\"ground\", \"rod\"], \"at\": [0, 0]}], \"input\": {\"joint\": \"O\"}}}' "
           "> cranks.json", 0, NULL, NULL);
    for (int n = 9; n < 14; n++)                 /* a file of another run */
        expect_with(MEMORY_ERROR, NULL, "memory", "rm -f $D/k; LW_FAIL=malloc:%d $C bench fit --problems $D/problems --solvers lm --seeds 0 --time 0.01 --keep $D/k --part 1/1 -q", n);
    expect("LW_CALLS_FILE=$D/calls $C catalogue query $D/six.db links=6 -f json --list mechanisms && LW_FAIL=malloc:$(($(sed -n 's/^malloc //p' $D/calls) - 3)) $C "
           "catalogue query $D/six.db links=6 -f json --list mechanisms > $D/json; test $? = 4 || cmp $D/json $D/stdout", 0, "II2:5,6", NULL);
    for (int i = 0; i < N_ROW + N_OUTPUT; i++) {
        const char *row = i < N_ROW ? rows[i] : outputs[i - N_ROW];
        if (!only || strstr(row, only))
            fail_each(i, row);
    }
}

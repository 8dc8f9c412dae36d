/* test_cli_enumerate.c - the commands numbers, structures and chains: output, refusals, resumed listings. */
#include "tests/cli_run.h"

TEST(help_shows_examples_first)
{
    expect("$P help numbers", 0, "Examples:", NULL);
    expect("$P structures --help", 0, "linkwright structures --loops 3", NULL);
    expect("$P chains --help", 0, "--fractionated", NULL);
    expect("$P chain --links 8", 2, NULL, "did you mean 'chains'?");
}

TEST(numbers)
{
    expect_row("$P numbers --dof 1 --loops 4", "L|n1|n2|P|P2|P3|P4|P5", "4|13|0|10|6|3|0|1");
    expect("$P numbers --dof 1 --loops 4 | grep -vc '^#'", 0, "7\n", NULL);
    expect_row("$P numbers --loops 1 --n2 2", "n1|n2|P|P2", "0|2|2|2");
    expect("$P numbers --loops 1 --n2 2", 0, "two joints between the same links\n", NULL);
    expect("$P numbers --loops 2 --json | head -1", 0, "\"links_with_2_3_joints\"", NULL);
    expect("$P numbers --dof 11", 2, NULL, "dof");
    expect("$P numbers --dof 3 --loops 15", 3, NULL, "more than 32");
}

TEST(structures)
{
    expect("$P structures --loops 2", 0, "(3 3) 1-2 1-2 1-2\n", NULL);
    expect("$P structures --loops 3 --derive", 0, "(3 3 3 3) 1-2 1-3 1-4 2-3 2-4 3-4 | theta 3(1,2)\n", NULL);
    expect_row("$P structures --loops 6 --count", "circles|structures", "all|1198");
    expect("$P structures --loops 5 --count --json", 0, "\"structures\":118", NULL);
    expect("$P structures --loops 4 --non-planar", 0, "(3 3 3 3 3 3)", NULL);
    expect("$P structures --loops 3 --non-planar", 1, NULL, NULL);
    expect("$P structures --replay 'theta 3(1,2) 4(6)'", 0,
           "(3 3 3 3 3 3) 1-2 1-3 1-4 2-3 2-4 3-5 4-6 5-6 5-6 | theta 3(1,2) 4(6)\n", NULL);
    expect("$P structures --replay 'theta 5(1,2)'", 3, NULL, "--replay:1:7: an ear begins with its rule");
    expect("$P structures", 2, NULL, "--loops");
    /* every derivation replays to its structure */
    expect("$P structures --loops 5 --derive > $D/d; while IFS='|' read s d; do "
           "$P structures --replay \"${d# }\" | tail -1; done < $D/d | cmp - $D/d && echo same", 0, "same\n", NULL);
}

TEST(chain_counts)
{
    expect("$P chains --links 10 --count", 0, "230\n", NULL);
    expect("$P chains --links 9 --dof 2 --count --fractionated", 0,
           "35 not fractionated\n5 fractionated, 0 of them with a bridge joint\n40 in all\n", NULL);
    expect("$P chains --links 8 --dof 3 --count --fractionated", 0, "2 fractionated, 1 of them with a bridge joint", NULL);
    expect_row("$P chains --links 10 --count --by assortment", "P2|P3|P4|P5|chains|ground links", "5|4|1|0|95|868");
    expect("$P chains --links 12 --count --planar", 0, "5918\n", NULL);
    expect("$P chains --links 12 --count --non-planar", 0, "938\n", NULL);
    expect("$P chains --links 12 --count --filter asymmetric", 0, "3950\n", NULL);
    expect("$P chains --links 12 --count --json", 0, "\"ground_links\":75397", NULL);
    expect("$P chains --links 9 --dof 0 --count", 0, "28\n", NULL);
    expect("for r in 1 2 3 4 5; do $P chains --links 12 --count --part $r/5; done | awk '{n += $1} END {print n}'", 0,
           "6856\n", NULL);
    expect("for r in 1 2 3; do $P chains --links 11 --dof 2 --count --fractionated --part $r/3 | tail -1; done "
           "| awk '{n += $1} END {print n}'", 0, "839\n", NULL);
}

TEST(chain_lists)
{
    expect("$P chains --links 4", 0, "Cl\n", NULL);
    expect("$P chains --links 6 --format franke", 0, "(3 3) 1-2:0 1-2:2 1-2:2\n", NULL);
    expect("$P chains --links 6 --format edges", 0, "1-2 1-3 1-5 2-4 2-6 3-4 5-6\n", NULL);
    expect("$P chains --links 6 --format sentence", 0, "((1 r ", NULL);
    expect("$P chains --links 6 --format lam", 0, "0 1 2 0 3 0\n", NULL);
    expect("$P chains --links 4 --json", 0, "{\"linkwright\"", NULL);
    expect("$P chains --links 4 --format dot", 0, "graph topology", NULL);
    expect("$P chains --links 4 --format graphml", 0, "<graphml", NULL);
    expect("$P chains --links 8 --non-planar", 1, NULL, NULL);
    expect("$P chains --links 12 --jobs 1 > $D/one; $P chains --links 12 --jobs 3 | cmp - $D/one && echo same", 0, "same\n", NULL);
    expect("for r in 1 2 3; do $P chains --links 10 --part $r/3; done | sort > $D/parts; "
           "$P chains --links 10 | sort | cmp - $D/parts && echo same", 0, "same\n", NULL);
}

/* A listing cut anywhere, even inside a line, is completed as if it had not been cut. */
TEST(resume)
{
    expect("$P chains --links 9 --dof 2 --fractionated -o $D/whole && for n in 0 1 12 13 200 399 400 401 500 520; do "
           "head -c $n $D/whole > $D/cut; $P chains --links 9 --dof 2 --fractionated -o $D/cut --resume; "
           "cmp $D/cut $D/whole || echo differs; done; wc -l < $D/whole", 0, "40\n", NULL);
    expect("for n in 0 1 12 399 520; do head -c 200 $D/whole > $D/cut; head -c $n $D/whole > $D/cut.partial; "
           "$P chains --links 9 --dof 2 --fractionated -o $D/cut --resume; "
           "cmp $D/cut $D/whole || echo differs; ls $D/cut.partial 2>&-; done", 2, "", NULL);
    expect("rm -f $D/new; $P chains --links 8 -o $D/new --resume; wc -l < $D/new", 0, "16\n", NULL);
    expect("$P chains --links 8 --resume", 2, NULL, "-o FILE");
    expect("$P chains --links 8 --resume -o $D/x --format dot", 2, NULL, "one line");
}

/* The lines that a killed program had written are kept; a listing of something else is not changed. */
TEST(resume_after_a_kill)
{
    expect("$P chains --links 14 -o $D/all && { $P chains --links 14 -o $D/killed & "
           "until [ -s $D/killed.partial ] || ! kill -0 $!; do sleep 0.01; done; kill -KILL $!; wait; "
           "$P chains --links 14 -o $D/killed --resume; } 2>&-; cmp $D/all $D/killed && ls $D/killed*", 0,
           "/killed\n", NULL);
    expect("$P chains --links 12 -o $D/other && $P chains --links 12 --planar -o $D/other --resume", 3, NULL,
           "other:6856:1: another chain comes here");
    expect("head -n 5918 $D/other > $D/planar && $P chains --links 12 --planar -o $D/planar --resume", 3, NULL, ":5918:1:");
    expect("$P chains --links 10 -o $D/all --resume", 3, NULL, "all:318162:1:");
    expect("wc -l < $D/all", 0, "318162\n", NULL);
    expect("rm $D/*.partial; $P chains --links 6 -o $D/plain && rm $D/plain && ls $D/*.partial 2>&-", 2, "", NULL);
}

/* A kept count goes on where it ended, leaves complete parts alone, and sums files that are joined; the table is that of
 * the count in one go. */
TEST(kept_counts)
{
    expect("$P chains --links 16 --count --by assortment > $D/once; "
           "$P chains --links 16 --count --by assortment --keep $D/k --structures $D/7.bin | cmp - $D/once && echo same",
           0, "same\n", "complete: ");
    expect("head -n 4 $D/k > $D/cut; printf 'part 5 struct' >> $D/cut; "
           "$P chains --links 16 --count --keep $D/cut --structures $D/7.bin; sort $D/k > $D/a; sort $D/cut | cmp - $D/a",
           0, "19819281\n", "each of the 5 parts once, with all 17133 structures");
    expect("for r in 1 2; do $P chains --links 16 --count --keep $D/k$r --structures $D/7.bin --part $r/2 --quiet; "
           "done | awk '{n += $1} END {print n}'", 0, "19819281\n", NULL);
    expect("cat $D/k1 $D/k2 > $D/both; $P chains --links 16 --count --by assortment --keep $D/both | cmp - $D/once", 0, "", "complete");
    expect("LW_CLOCK_STEP=0.01 $C chains --links 16 --count --keep $D/late --structures $D/7.bin --time 0.01", 5, "0\n",
           "holds 0 of 5 parts");
    expect("cat $D/k1 >> $D/both; $P chains --links 16 --count --keep $D/both", 3, NULL, "a second time");
    expect("sed -i 's/chains 4/chains 5/' $D/k2; $P chains --links 16 --count --keep $D/k2", 3, NULL, ": this part is damaged");
    expect("$P chains --links 14 --count --keep $D/k", 3, NULL, "16 links");
    expect("awk '{print $1, $2, $3, $4, $5, $6, $7, $8}' $D/once > $D/a; G='chains --links 16 --count --filter generating --by "
           "assortment'; $P $G --keep $D/g --structures $D/7.bin | awk '{print $1, $2, $3, $4, $5, $6, $7, $8}' | cmp - $D/a && "
           "$P $G | tail -n 1; sed -i 5d $D/g; LW_CLOCK_STEP=0.01 $C $G --keep $D/g --structures $D/7.bin --time 0.01", 5, "19819281\n", "holds 4 of 5");
    expect("$P chains --links 16 --count --filter generating --part 1/2", 2, NULL, "--keep");
    expect("$P numbers --loops 7 --labelled | tail -n 1", 0, "1144398473330112000", NULL);
    expect("$P numbers --dof 0 --labelled", 2, NULL, "F must be 1 or more");
    expect("$P chains --links 16 --planar --count --keep $D/k", 3, NULL, "filter none");
    expect("printf hello > $D/text; $P chains --links 14 --count --keep $D/text; cat $D/text", 0, "hello", "kept count");
    expect("$P structures --loops 6 --structures $D/7.bin --count", 0, "1198", NULL);
    expect("$P structures --loops 8 --structures $D/7.bin --count", 3, NULL, "up to 7 loops");
    expect("head -c 90000 $D/7.bin > $D/half; $P structures --loops 7 --structures $D/half", 3, NULL, "cut short");
    expect("$P chains --links 8 --keep $D/k", 2, NULL, "--count");
}

/* Each command with --mpi, as one process: a call for memory that fails is an error with a message, or the answer is whole. */
static void processes_without_memory(void)
{
    static const char *const rows[] = {
        "chains --links 6 -j 1", "fit examples/ellipse.csv --unlimited --starts 1 --rounds 1 --results 1 -j 1 -q",
        "catalogue curves $D/short.db --links 4 --samples 40 -q", "bench fit --problems $D/problems --solvers lm --seeds 0 --time 0.01 -q",
    };
    expect("mkdir $D/problems && cp examples/ellipse.csv $D/problems", 0, NULL, NULL);
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        for (int n = 1; n <= 200; n += 1 + n/3) {
            ran r = run_with("rm -f $D/short.db; LW_FAIL=malloc:%d $C %s --mpi", n, rows[i]);
            CHECK(r.code == 0 || (r.code == 4 && r.err[0] && !r.out[0]));
            ran_free(&r);
        }
}

/* Needs a program built with `make MPI=1`. */
TEST(processes)
{
    ran r = run("$P chains --links 4 --mpi && command -v mpirun");
    if (r.code != 0) {
        printf("test_cli_enumerate: no MPI here, processes skipped\n");
        ran_free(&r);
        expect("$P chains --links 4 --mpi", 2, NULL, "make MPI=1");
        return;
    }
    ran_free(&r);
    setenv("RUN", "mpirun --allow-run-as-root --oversubscribe -n 3", 1);
    expect("$P chains --links 9 --dof 2 --fractionated > $D/one; $RUN $P chains --links 9 --dof 2 --fractionated --mpi "
           "| cmp - $D/one && echo same", 0, "same\n", NULL);
    expect("$RUN $P chains --links 12 --mpi --count --by assortment > $D/three; "
           "$P chains --links 12 --count --by assortment | cmp - $D/three && echo same", 0, "same\n", NULL);
    expect("$P chains --links 16 --count --keep $D/m1 --part 2/3; $P chains --links 16 --count > $D/all; "
           "$RUN $P chains --links 16 --count --mpi --keep $D/m1 --structures $D/m.bin | cmp - $D/all && echo same", 0,
           "same\n", "complete");
    /* a process that does a task is killed: its task is done again, once, and nothing else changes */
    expect("$P catalogue curves $D/c1 --samples 66000 -q && { $RUN $P catalogue curves $D/c3 --samples 66000 --mpi -q & } 2> "
           "$D/killed; until w=$(pgrep -P \"$(pgrep -d, -P $!)\" | head -n 1) && test -n \"$w\"; do sleep 0.01; done; "
           "kill -9 $w; wait $! && grep -c 'only this task is done again' $D/killed", 0, "1\n", NULL);
    expect("for c in c1 c3; do $P catalogue query $D/$c --sql --format csv 'SELECT c.id, hex(terms), hex(linkages), g.number, "
           "hex(boxes), s.samples FROM curve_block c, curve_segment g, sweep s' > $D/$c.csv; done; cmp $D/c1.csv "
           "$D/c3.csv && test -s $D/c1.csv && echo same", 0, "same\n", NULL);
    /* all processes are killed in the middle of a listing, which goes on with another number of them */
    expect("$P chains --links 14 > $D/l1; { $RUN $P chains --links 14 --mpi -q -o $D/l3 & } 2> $D/killed; "
           "until test -s $D/l3.partial; do sleep 0.01; done; kill -9 $(pgrep -P $!); wait $!; test -e $D/l3 || "
           "mpirun --allow-run-as-root --oversubscribe -n 2 $P chains --links 14 --mpi -q -o $D/l3 --resume; "
           "cmp $D/l1 $D/l3 && echo same", 0, "same\n", NULL);
    expect("$P fit examples/figure-eight.csv --rounds 2 -q -o $D/f1.json && $RUN $P fit examples/figure-eight.csv --rounds 2 -q "
           "--mpi --keep $D/fk -o $D/f3.json && for f in f1 f3; do grep -v '\"seconds\"\\|\"command\"' $D/$f.json > $D/$f; done; "
           "cmp $D/f1 $D/f3 && echo same", 0, "same\n", NULL);
    processes_without_memory();
    expect("$RUN $P catalogue curves /no/such/folder/x --samples 100 --mpi", 3, NULL, "/no/such/folder");
    expect("$RUN $P chains --links 5 --dof 2 --mpi", 0, "Dhc\n", NULL);
    expect("$RUN $P chains --links 8 --mpi -o /no/such/folder/x", 3, NULL, "/no/such/folder");
    expect("$RUN $P chains --links 7 --mpi", 3, NULL, "P = F + 2 L + 1 - n2");
    expect("$RUN $P chains --links 19 --dof 6 --mpi --time 1e-9 > $D/cut", 5, NULL, NULL);
}

TEST(limits_and_faults)
{
    expect("$P chains --links 7", 3, NULL, "P = F + 2 L + 1 - n2");
    expect("$P chains --dof 1", 2, NULL, "--links");
    expect("$P chains --links 33", 2, NULL, "links");
    expect("$P chains --links 8 --part 4/3", 2, NULL, "R/M");
    expect("$P structures --loops 6 --part 1/2", 2, NULL, "--count");
    expect("for r in 1 2 3; do $P structures --loops 6 --count --part $r/3 | tail -n 1; done | awk '{ n += $2 } END { print n }'", 0,
           "1198\n", NULL);
    expect("$P structures --loops 6 --count --structures $D/6.bin -q > $D/six; $P structures --loops 6 --count --part 1/2 "
           "--structures $D/6.bin", 3, NULL, "more than 5 loops");
    expect("$P chains --links 8 --part x", 2, NULL, "R/M");
    expect("$P chains --links 8 --filter plannar", 2, NULL, "did you mean 'planar'?");
    expect("$P chains --links 8 --planar --non-planar", 2, NULL, "non-planar");
    expect("$P chains --links 14 --dof 5 --time 1e-9", 5, NULL, "stopped");
    /* stopped in the middle of the listing: whole lines only */
    expect("LW_CLOCK_STEP=0.01 $C chains --links 14 --jobs 1 --time 8 -o $D/part", 5, NULL, NULL);
    expect("test -s $D/part.partial && test -z \"$(tail -c1 $D/part.partial)\" && test ! -e $D/part", 0, NULL, NULL);
    expect("$P chains --links 21 --dof 6 --time 1e-9 --count", 5, NULL, "stopped");
    expect("LW_CLOCK_STEP=0.01 $C chains --links 18 --time 0.1 --count", 5, NULL, "structures with 8 loops");
    expect("LW_CLOCK_STEP=0.01 $C structures --loops 9 --time 0.1", 5, NULL, "stopped");
    expect("$P chains --links 32 --count", 4, NULL, "--memory");
    expect("$P chains --links 8 -o /no/such/folder/x", 3, NULL, "/no/such/folder");
    expect("$P chains --links 12 > /dev/full", 3, NULL, NULL);
}

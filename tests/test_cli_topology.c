/* test_cli_topology.c - the commands grammar, mechanisms and catalogue check. */
#include "tests/cli_run.h"

#define FOUR "((1 r 2 r 3 r 4 r) (1 r 2 r 3 r 4 r))"
#define WATT "((1 r 2 r 3 r 4 r 5 r 6 r) (1 r 2 r 3 r 4 r) (1 r 4 r 5 r 6 r))"

TEST(notations)
{
    expect("echo '" WATT "' | $P grammar parse", 0, "1-2 1-4 1-6 2-3 3-4 4-5 5-6\n", NULL);
    expect("echo '" WATT "' | $P grammar parse --format lam", 0, "0 1 0 2 0 3\n0 0 4 0 0 0\n0 0 0 5 0 0\n", NULL);
    expect("echo '" WATT "' | $P grammar parse -f lam | $P grammar print", 0, WATT "\n", NULL);
    expect("echo '" WATT "' | $P grammar parse -f franke", 0, "(3 3) 1-2:0 1-2:2 1-2:2\n", NULL);
    expect("echo '" WATT "' | $P grammar parse -f graph6 | $P grammar print -", 0, WATT "\n", NULL);
    expect("echo '" WATT "' | $P grammar parse --json | $P grammar print", 0, WATT "\n", NULL);
    expect("echo '" WATT "' | $P grammar parse -f dot", 0, "graph topology {", NULL);
    expect("echo '" WATT "' | $P grammar parse -f graphml", 0, "</graphml>", NULL);
    expect("$P grammar parse", 1, NULL, NULL);
}

TEST(faults_of_input)
{
    expect("printf 'Cl\\n((1 r 2 r)\\n (1 r 2 r' | $P grammar parse", 3, "1-2 1-4 2-3 3-4", "standard input:3:2: this word is not closed");
    expect("echo '((1 r 1 r))' > $D/s; $P grammar parse $D/s", 3, NULL, "s:1:3: part 1 is joined to itself");
    expect("printf '0 1 2\\n0 0 1\\n0 0 0\\n' | $P grammar print", 3, NULL, "2:5: joint 1 is numbered twice");
    expect("echo 'E!' | $P mechanisms", 3, NULL, "1:2: '!' is no byte of graph6");
    expect("echo '{\"links\": 4, \"joints\": [[1, 2, \"k\"]]}' | $P mechanisms", 3, NULL, "1:32:");
    expect("printf '\\nCl\\n1-2 2-3 1-3 3-4 4-5 1-5\\nCl\\n' | $P mechanisms --count", 3, NULL, "3:1: links 1, 2, 3 form a rigid subchain");
    expect("printf 'Cl\\n1-2 2-3 1-3 3-4 4-5 1-5\\nCl\\n' | $P mechanisms --keep-going -f edges", 3,
           "1-2 1-4 2-3 3-4 @1\n1-2 1-4 2-3 3-4 @1\n", "rigid subchain");
    expect("$P grammar parse $D/none", 3, NULL, "none");
    expect("echo '1-2 2-3' | $P grammar parse -f franke", 3, NULL, "cannot be written as franke");
    expect("$P mechanisms --links 7", 3, NULL, "P = F + 2 L + 1 - n2");
}

TEST(derive)
{
    /* paper F, eq. 25 */
    expect("$P grammar derive --sentence '" FOUR "' --rule 3 --at 3,4", 0,
           "((1 r 2 r 3 r 5 p 4 r) (4 r 3 r 5 p) (1 r 2 r 3 r 4 r))\n", NULL);
    expect("$P grammar derive --sentence '" FOUR "' --rule 4 --at 4,1 --word 2 --joints rtr -f edges", 0,
           "1-2 1-4 1-6 2-3 3-4 4-5 5-6:t\n", NULL);
    expect("$P grammar derive --rule 1", 0, "((1 r 2 r 3 p) (1 r 2 r 3 p))\n", NULL);
    expect("$P grammar derive --links 8 --rules 2,4 --count", 0, "12\n", NULL);
    expect("$P grammar derive --links 6 --rules 2,4 | $P grammar parse -f franke", 0, "(3 3) 1-2:1 1-2:1 1-2:2", NULL);
    expect("$P grammar derive --links 7 --rules 2,4", 1, NULL, NULL);
    expect("$P grammar derive --sentence '" FOUR "' --rule 4 --at 2,2", 3, NULL, "X and Y must differ");
    expect("$P grammar derive --sentence '((1 r 2 r' --rule 4 --at 1,2", 3, NULL, "--sentence:1:2:");
    expect("$P grammar derive --rule 4", 2, NULL, "give --sentence");
    expect("$P grammar derive --sentence '" FOUR "' --rule 4 --at 34", 2, NULL, "--at takes two");
    expect("$P grammar derive --sentence '" FOUR "' --rule 4 --at 3,4 --joints rr", 2, NULL, "rule 4 has 3 joints k");
    expect("$P grammar derive --links 6 --joints r,t --count && $P grammar derive --links 6 --joints rt --count", 0, "2465\n2465\n", NULL);
    expect("$P grammar derive --links 6 --joints rp", 3, NULL, "takes r, t or r,t");
    expect("$P grammar derive --links 6 --rules 5", 2, NULL, "numbers 1 to 4");
    expect("$P grammar derive --links 6 --rules ,", 2, NULL, "numbers 1 to 4");
    expect("$P grammar derive", 2, NULL, "--links N");
    expect("$P grammar derive x", 2, NULL, "one word too many");
    expect("$P grammar diagram", 2, NULL, "there is no action 'diagram'");
}

TEST(explain_and_coverage)
{
    expect("echo '" WATT "' | $P grammar explain", 0, "  rules 1 to 4 reach it\n  rule 2, k = r r r r\n      " FOUR, NULL);
    expect("echo '(3 3) 1-2:1 1-2:2 1-2:2' | $P grammar explain", 0, "this chain has F = 2", NULL);
    expect("echo '(3 3 3 3) 1-2:1 1-3:1 1-4:0 2-3:0 2-4:1 3-4:1' | $P grammar explain", 0,
           "ends at links 1 2 3 4 5 6 7 8, which are no seed", NULL);
    expect("echo '(3 3 3 3) 1-2:1 1-3:1 1-4:0 2-3:0 2-4:1 3-4:1' | $P grammar explain --json", 0, "\"reach\":\"core\"", NULL);
    expect_words("$P grammar coverage --links 12", "\n 12 6856 5918 3110 45.36 % 2781 40.56 %\n");
    expect("$P grammar coverage --links 8 --json", 0, "\"reached_by_regions\": 12", NULL);
    expect("$P grammar coverage --links 7", 2, NULL, "P = 2 L + 2");
    expect("$P grammar coverage", 2, NULL, "--links N");
}

TEST(steps)
{
    expect_words("$P mechanisms --links 10 --count", "with ground link 1834\n");
    expect_words("$P mechanisms --links 6 --joints r,t --count", "with joint kinds 234\n");
    expect("$P mechanisms --links 4 --joints t,r --void --no-ground", 0, "a loop of sliders only: 1-2:t 1-4:t 2-3:t 3-4:t", NULL);
    expect("$P mechanisms --links 4 --input ground --output-link -f edges", 0, "1-2! 1-4 2-3 3-4 @1 >3\n1-2! 1-4 2-3 3-4 @1 >4\n", NULL);
    expect("$P mechanisms --links 4 --input any --output-link --count --json", 0, "\"output\": 5", NULL);
    expect("$P mechanisms --links 3 --n2 1 --no-ground --joints r,t,p -f edges", 0, "1-2 1-3:p 2-3\n1-2 1-3:p 2-3:t\n", NULL);
    expect("echo '1-2! 1-4 2-3 3-4 @1' | $P mechanisms --assur", 0,
           "  class II, order 2: links 3 4, joints 1-4:r 2-3:r 3-4:r, 2 assembly modes\n", NULL);
    expect("echo '1-2! 1-4 2-3 3-4 @1' | $P mechanisms --assur --json", 0, "\"class\":2", NULL);
    expect("echo 'Cl' | $P mechanisms --assur", 3, NULL, "wants as many inputs");
    expect("$P mechanisms --assur-groups 6 --count", 0, "10\n", NULL);
    expect("$P mechanisms --links 4 --no-ground --joints r,t --format graph6 | sort -u", 0, "Cl\n", "no joint kinds");
    expect("$P mechanisms --links 4 --format franke | head -1", 0, NULL, "no ground link");
    expect("for f in dot graphml; do $P chains --links 8 --format $f | $P mechanisms --no-ground --format graph6; done "
           "| sort | uniq -c | awk '{print $1}' | sort -u", 0, "2\n", NULL);
    expect("printf '0,1,0,1\n1,0,1,0\n0,1,0,1\n1,0,1,0\n' | $P mechanisms --no-ground --format edges", 0, "1-2 1-4 2-3 3-4\n", NULL);
    expect("$P mechanisms --links 8 --multiple-joints --count", 0, "44\n", NULL);
    expect("$P mechanisms --links 10 --joints r,t --input any --time 1e-9 --count", 5, "with inputs", "stopped by --time");
    expect("$P mechanisms --links 4 --joints r,x", 2, NULL, "letters of r, t, p, g");
    expect("$P mechanisms --links 4 --joints p", 3, NULL, "a letter for each freedom");
    expect("$P mechanisms --links 4 file", 2, NULL, "not both");
    expect("$P mechanisms --links 4 --no-ground --input ground", 3, NULL, "want a ground link");
}

TEST(catalogue_check)
{
    expect("printf 'family,dof,links,loops,what,count,source,verified_by\\n"
           "simple-joint,1,8,3,nonfractionated chains,16,here,\\n"
           "simple-joint,1,8,3,nonfractionated chains,17,here,refuted\\n' > $D/t.csv; $P catalogue check $D/t.csv --time 1e6", 0, "[here]",
           "1 rows agree, 0 disagree, 1 known errata, 0 too long");
    expect_row("$P catalogue check $D/t.csv --time 1e6", "published|counted|verdict|what",
               "16|16|agrees|simple-joint: F=1 P=8 nonfractionated chains");
    expect("printf 'family,dof,links,loops,what,count,source,verified_by\\n"
           "simple-joint,1,18,8,nonfractionated chains,1,here,\\n' > $D/t.csv; $P catalogue check $D/t.csv --time 1e-9",
           0, NULL, "0 rows agree, 0 disagree, 0 known errata, 1 too long");
    expect("printf 'family,dof,links,loops,what,count,source,verified_by\\n"
           "simple-joint,1,8,3,nonfractionated chains,17,here,\\n' > $D/t.csv; $P catalogue check $D/t.csv --json", 4,
           "\"counted\":16,\"verdict\":\"DISAGREES\"", NULL);
    expect("$P catalogue check --time 1e-9 --disagreeing", 0, NULL, " 0 disagree, ");
    expect("head -c 8192 /dev/zero > $D/cut; $P catalogue check $D/cut", 3, NULL, "not a catalogue");   /* as a killed build leaves it */
    expect("echo a,b > $D/t.csv; $P catalogue check $D/t.csv", 3, NULL, "t.csv:1:1: the header must be");
    expect("$P catalogue count", 2, NULL, "there are build");
}

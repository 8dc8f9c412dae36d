/* test_cli_draw_chains.c - `linkwright draw` on chains and mechanisms. */
#include "tests/cli_run.h"

TEST(pages)
{
    expect("$P chains --links 8 | $P draw --format g6 | grep -c 'class=\"joint\"'", 0, "160", NULL);
    expect("$P chains --links 8 > $D/c.g6 && $P draw $D/c.g6 > $D/a.svg && $P draw < $D/c.g6 | cmp - $D/a.svg", 0, NULL, NULL);
    expect("$P draw $D/c.g6 --grid 4x2 -o $D/s.svg && ls $D", 0, "s-001.svg\ns-002.svg\nstd", NULL);
    expect("$P draw $D/c.g6 --each -o $D/e.png && ls $D/e-0*.png | wc -l", 0, "16", NULL);
    expect("$P draw $D/c.g6 --grid 4x2 -o $D/s.pdf && grep -ac '/Count 2' $D/s.pdf", 0, "1", NULL);
    expect("$P draw $D/c.g6 --grid 4x2", 3, NULL, "name a file with -o");
    expect("$P draw $D/c.g6 --grid 4x2 -f pdf | head -c 4", 0, "%PDF", NULL);
    expect("$P draw - < $D/c.g6 | cmp - $D/a.svg && $P draw examples/hoeken.json > $D/h.svg", 0, "", NULL);
    expect("cat examples/hoeken.json | $P draw | cmp - $D/h.svg && $P draw - < examples/hoeken.json | cmp - $D/h.svg", 0, "", NULL);
    expect("(printf '\\357\\273\\277' && cat examples/hoeken.json) > $D/mark.json && $P draw - < $D/mark.json | cmp - $D/h.svg", 0, "", NULL);
    expect("$P draw $D/mark.json | cmp - $D/h.svg", 0, "", NULL);
    expect("$P mechanisms --links 4 --input ground | $P draw --numbers --grid 1x1 --caption joints | grep '@1'", 0, "@1", NULL);
    expect("$P mechanisms --links 4 --joints r,t > $D/m.jsonl && $P draw $D/m.jsonl | grep -c '\"slider\"' > $D/n && "
           "test $(grep -o '\"t\"' $D/m.jsonl | wc -l) = $(cat $D/n)", 0, NULL, NULL);
    expect("$P draw $D/c.g6 --caption graph6 | grep -c '<text'", 0, "16", NULL);
    expect("$P draw $D/c.g6 --caption assortment | grep -c '>4, 4<'", 0, "9", NULL);
}

TEST(faults)
{
    expect("printf '1-2 2-3 3-4 4-1\\n1-2 3-4\\n' | $P draw", 3, NULL, "2:1: the links do not hang together");
    expect("printf '1-2 2-3 3-4 4-1\\n1-2 3-4\\n' | $P draw -k", 3, "</svg>", "hang together");
    expect("printf '1-2 2-3 3-4 4-1\\n1-2x\\n' | $P draw", 3, NULL, "2:");
    expect("printf '\\n\\n1-2 2-3 3-4 4-1\\n1-2x\\n' | $P draw", 3, NULL, "standard input:4:");
    expect("printf '\\n\\n{\"joints\": }\\n' | $P draw -", 3, NULL, "standard input:3:12");
    expect("printf '' | $P draw", 1, NULL, NULL);
    expect("$P chains --links 6 | $P draw -o $D/x.gif", 2, NULL, "does not move");
    expect("$P chains --links 6 | $P draw --target examples/ellipse.csv", 2, NULL, "--target is for linkages");
    expect("$P draw examples/hoeken.json --numbers", 2, NULL, "--numbers is for chains");
    expect("$P draw $D/none.g6", 3, NULL, "none.g6");
    expect("$P mechanisms $D/none.g6", 3, NULL, "no such file or folder; check the spelling");
    expect("$P chains --links 6 | $P draw --grid 64x64", 3, NULL, "too small");
    expect("$P chains --links 6 | $P draw -o /dev/full -f svg", 3, NULL, "no space left");
}

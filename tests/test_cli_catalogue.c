/* test_cli_catalogue.c - catalogues: their content, and their state after kills, full disks and files of other
 * programs. */
#include "tests/catalogue_file.h"
#include "tests/cli_run.h"

TEST(help)
{
    expect("$P help catalogue", 0, "Examples:", NULL);
    expect("$P catalogue biuld x.db", 2, NULL, "did you mean 'build'?");
    expect("$P catalogue wash x.db", 2, NULL, "there are build");
    expect("$P catalogue build", 2, NULL, "more words are missing");
    expect("$P catalogue build $D/a.db", 2, NULL, "--links P");
    expect("$P catalogue build $D/a.db --links 8 --joints q", 2, NULL, "r, t or r,t");
    expect("$P catalogue build $D/a.db --links 7 && ls $D", 3, NULL, "P = F + 2 L + 1 - n2");
}

TEST(parts_of_curves)
{
    expect("$P catalogue curves $D/p.db --samples 65600 --part 3/2", 2, NULL, "R/M");
    expect("$P catalogue curves $D/p.db --samples 65600 --part 2/3; ls $D/p.db", 2, NULL, "do not give 3 parts");
    expect("$P catalogue curves $D/p.db --samples 65600 --part 2/2", 0, "", "64 of 64 samples");
    expect("$P catalogue add $D/q.db $D/p.db", 3, "", "add part 1 first");
    expect("$P catalogue build $D/r.db --links 4; $P catalogue add $D/q.db $D/r.db", 3, "", "0 sequences of curves");
    expect("$P catalogue curves $D/s.db --samples 30 -q; $P catalogue add $D/q.db $D/s.db", 0, "", "curves added");
    expect("$P catalogue add $D/q.db $D/s.db", 0, "", "already");
    expect("$P catalogue check $D/q.db", 0, NULL, NULL);
    /* a catalogue of linkages alone lists them */
    expect("$P catalogue add $D/k.db examples/chebyshev.json -q && $P catalogue export $D/k.db", 0, "\"linkage\":", NULL);
    expect("$P catalogue query $D/k.db links=4 -f csv", 0, "transmission_min", NULL);
}

/* 16 chains and 71 ground links with eight links: OEIS A233288 and the table of published counts. */
TEST(build)
{
    expect("$P catalogue build $D/a.db --links 8", 0, "", "16 of 16 chains");
    expect("$P catalogue build $D/a.db --links 8", 0, "", "complete already: 16 chains");
    expect("$P catalogue build $D/a.db --links 5 --dof 2 && $P catalogue build $D/a.db --links 4", 0, "", NULL);
    expect("$P catalogue check $D/a.db", 0, NULL, "18 chains are what their labels say");
    expect_words("$P catalogue check $D/a.db", " 71 71 agrees P=8 F=1 inversions of nonfractionated");
    expect("$P catalogue check $D/a.db --json | grep -c '\"verdict\":\"agrees\"'", 0, "", NULL);
    expect("$P catalogue build $D/sliders.db --links 6 && $P catalogue build $D/sliders.db --links 6 --joints r,t", 0, "", NULL);
    expect("$P catalogue check $D/sliders.db", 0, NULL, "2 chains");
    for (int i = 0; i < 2; i++)                                  /* the second call finds them there */
        expect("$P catalogue build $D/pins.db --links 8 --multiple-joints", 0, "", "44 chains with multiple joints");
    expect("$P catalogue check $D/pins.db", 0, NULL, "60 chains are what their labels say");
    expect_words("$P catalogue check $D/pins.db", " 44 44 agrees P=8 F=1 nonfractionated chains with at least one multiple");
    expect("sqlite3 $D/pins.db \"UPDATE multiple SET symmetry = 7 WHERE id = 5\"; $P catalogue check $D/pins.db", 3, NULL,
           "1 of 60 chains are not what their label");
    expect("sqlite3 $D/pins.db 'DELETE FROM multiple WHERE id = 5'; $P catalogue check $D/pins.db", 3, NULL,
           "multiple joints of a finished build are missing");
    expect("$P catalogue build $D/b.db --links 8 --jobs 1 --command x", 2, NULL, "no option");
    expect("ls $D/*-lock $D/*-journal", 2, "", NULL);
}

/* 153 mechanisms of eight links with an input at the ground, 513 of six links with sliders: `mechanisms --count`
 * counts them without a catalogue. */
TEST(mechanisms_as_counted)
{
    static const struct { const char *file; int n; } row[] = { { "a.db", 153 + 1 + 1 }, { "sliders.db", 513 } };
    expect("$P mechanisms --links 8 --input ground --count", 0, "153\n", NULL);
    expect("$P mechanisms --links 6 --joints r,t --input ground --count", 0, "513\n", NULL);
    for (size_t i = 0; i < 2; i++) {
        char path[200];
        int n = 0;
        snprintf(path, sizeof path, "%s/%s", temporary_folder(), row[i].file);
        FREED char *text = dump_catalogue(path);
        for (const char *at = text; (at = strstr(at, "\nmechanism|")); at++)
            n++;
        CHECK_INT(n, row[i].n);
    }
}

/* The content does not depend on the number of threads. */
TEST(threads)
{
    char path[200];
    expect("mkdir $D/one $D/three; cd $D/one; Q=$(cd - > /dev/null; realpath $P); $Q catalogue build x.db --links 10 "
           "--jobs 1; cd $D/three; $Q catalogue build x.db --links 10 --jobs 3", 0, NULL, NULL);
    snprintf(path, sizeof path, "%s/one/x.db", temporary_folder());
    FREED char *one = dump_catalogue(path);
    snprintf(path, sizeof path, "%s/three/x.db", temporary_folder());
    FREED char *three = dump_catalogue(path);
    /* only the command line itself differs */
    char *a = strstr(one, "--jobs 1"), *b = strstr(three, "--jobs 3");
    CHECK(a && b);
    if (a && b)
        a[7] = b[7] = '?';
    CHECK(strlen(one) > 10000 && strcmp(one, three) == 0);
}

TEST(killed_builds)
{
    expect("mkdir $D/killed", 0, NULL, NULL);
    kill_at_random("x.db", "catalogue build x.db --links 10 --commit 0 --no-pictures", 25, "build|1|10|1|r|230|1");
}

/* --time ends a build in good order, and the next one goes on. */
TEST(stopped_builds)
{
    const char *build = "LW_CLOCK_STEP=0.01 $C catalogue build $D/t.db --links 12 --no-pictures --time 0.2 --commit 0";
    expect(build, 5, NULL, "the same command goes on");
    expect("$P catalogue check $D/t.db", 0, NULL, "1 build is not finished");
    expect(build, 5, NULL, "continued after");
}

TEST(full_disk)
{
    expect("trap '' XFSZ; ulimit -f 400; $P catalogue build $D/full.db --links 10 --commit 0", 3, NULL, "full.db: ");
    expect("$P catalogue check $D/full.db", 0, NULL, "1 build is not finished");
    expect_words("$P catalogue build $D/full.db --links 10 && $P catalogue check $D/full.db", " 230 230 agrees");
    expect("trap '' XFSZ; ulimit -f 1; $P catalogue build $D/tiny.db --links 10", 3, NULL, "tiny.db: ");
    expect("$P catalogue build $D/tiny.db --links 6", 0, NULL, "2 of 2");
    expect("$P catalogue build /dev/full --links 6", 3, NULL, "no plain file");
}

/* A row of 40 loops: 82 links, 120 pins.  The first loop is a parallelogram. */
TEST(linkages_of_any_size)
{
    expect("awk 'BEGIN {n = 40; printf \"{@linkwright@:1,@links@:[@ground@,@c0@\"; for (i = 1; i <= n; i++) printf \",@c%d@,@r%d@\", i, i; "
           "printf \"],@input@:{@joint@:@A0@},@tracers@:[{@name@:@P@,@link@:@r40@,@at@:[39.5,2]}],"
           "@joints@:[{@name@:@A0@,@links@:[@ground@,@c0@],@at@:[0,0]}\"; "
           "for (i = 1; i <= n; i++) printf \",{@name@:@A%d@,@links@:[@ground@,@c%d@],@at@:[%d,0]},{@name@:@B%d@,@links@:[@c%d@,@r%d@],"
           "@at@:[%d,1]},{@name@:@C%d@,@links@:[@r%d@,@c%d@],@at@:[%d,1]}\", i, i, i, i, i-1, i, i-1, i, i, i, i; "
           "print \"]}\"}' | tr @ '\"' > $D/row.json; rm -f $D/rows.db; $P catalogue add $D/rows.db $D/row.json", 0, NULL, "1 added");
    expect("$P catalogue add $D/rows.db $D/row.json", 0, NULL, "1 linkages read, 0 added");
    expect("$P catalogue query $D/rows.db --sql 'SELECT links, joints, dof, class, length(curve) > 1000 FROM linkage' -f csv", 0, "82,121,1,CP3X,1", NULL);
    expect("$P catalogue export $D/rows.db | sed 's/.*\"linkage\": *//; s/}$//' > $D/again.json; $P catalogue add $D/rows.db $D/again.json", 0,
           NULL, "0 added");
}

TEST(files_that_are_none)
{
    expect("chmod 444 $D/a.db; $P catalogue build $D/a.db --links 6; c=$?; chmod 644 $D/a.db; exit $c", 3, NULL, "read-only");
    expect("chmod 444 $D/a.db; $P catalogue check $D/a.db; c=$?; chmod 644 $D/a.db; exit $c", 0, NULL, "whole");
    expect("$P catalogue build $D --links 6", 3, NULL, "a folder");
    expect("$P catalogue build $D/no/such.db --links 6", 3, NULL, "no such file");
    expect("$P catalogue check $D/none.db", 3, NULL, "no such file");
    expect("echo hello > $D/text.db; $P catalogue build $D/text.db --links 6", 3, NULL, "no SQLite file");
    expect("cat $D/text.db", 0, "hello\n", NULL);
    expect("$P catalogue build '' --links 6", 3, NULL, "empty");
    /* names with a meaning for SQLite or a shell are plain names of files here */
    expect("cd $D; Q=$(cd - > /dev/null; realpath $P); $Q catalogue build ':memory:' --links 4 && "
           "$Q catalogue build 'file:x?mode=ro' --links 4 && $Q catalogue build '; DROP TABLE chain --' --links 4 && "
           "ls ':memory:' 'file:x?mode=ro' '; DROP TABLE chain --'", 0, "file:x?mode=ro", NULL);
}

TEST(damaged_files)
{
    static const char *const cut[] = { "0", "99", "100", "4095", "4096", "20000", "60000" };
    for (size_t i = 0; i < sizeof cut/sizeof *cut; i++) {
        char line[300];
        expect_with(3, NULL, "cut.db: ", "head -c %s $D/a.db > $D/cut.db; $P catalogue check $D/cut.db", cut[i]);
        snprintf(line, sizeof line, "head -c %s $D/a.db > $D/cut.db; $P catalogue build $D/cut.db --links 10", cut[i]);
        expect(line, i ? 3 : 0, NULL, NULL);
    }
    /* a changed byte anywhere is reported or harmless; the program never crashes */
    for (int at = 60; at < 70000; at += 4211) {
        expect_with(0, NULL, NULL, "cp $D/a.db $D/wild.db; printf '\\377\\001\\377' | dd of=$D/wild.db bs=1 seek=%d "
                    "conv=notrunc 2>&-; $P catalogue check $D/wild.db > /dev/null; c=$?; [ $c = 0 ] || [ $c = 3 ] || [ $c = 4 ]", at);
    }
}

/* A second program reports the one that writes, or waits for it. */
TEST(two_at_once)
{
    /* the first, which would take minutes, is halted once it holds the file */
    expect("$P catalogue build $D/two.db --links 14 --no-pictures --quiet & "
           "until [ -s $D/two.db-lock ] || ! kill -0 $!; do sleep 0.01; done; kill -STOP $!; "
           "$P catalogue build $D/two.db --links 6 --wait 0; c=$?; kill -KILL $!; wait; exit $c", 3, NULL,
           "--links 14");
    expect("$P catalogue build $D/w.db --links 10 & $P catalogue build $D/w.db --links 8 --wait 1e6; wait; "
           "$P catalogue check $D/w.db", 0, "230          230", "246 chains are what their labels say");
}

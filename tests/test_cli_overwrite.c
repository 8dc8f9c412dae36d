/* test_cli_overwrite.c - files of the user are not overwritten, and outputs are checked before a long search. */
#include "tests/cli_run.h"

#define PREPARE "cd $D; P=$(realpath $OLDPWD/$P); "

TEST(prepare)
{
    expect("cp examples/hoeken.json $D/model.json; cp examples/ellipse.csv $D/target.csv; "
           "ln -s model.json $D/link.json; ln $D/model.json $D/hard.json; mkdir $D/sub; "
           "echo mine > $D/mine.txt; echo mine > $D/target.svg", 0, NULL, NULL);
}

/* An input is never overwritten, however its path is written, not even with --force. */
TEST(inputs)
{
    static const char *const outputs[] = { "$D/model.json", "$D/link.json", "$D/hard.json", "$D/sub/../model.json" };
    for (size_t i = 0; i < sizeof outputs/sizeof *outputs; i++) {
        expect_with(2, "", "an input of this command", "$P trace $D/model.json --force -o %s", outputs[i]);
    }
    expect("$P trace - -o $D/model.json < $D/model.json", 2, "", "standard input");
    expect("$P draw $D/model.json --target $D/target.csv --force -o $D/target.csv", 2, "", "an input of this command");
    expect("$P simulate $D/model.json --speed 1 --force --plot $D/model.json", 2, "", "an input of this command");
    /* the target of a task file, by a table or by a curve of a drawing */
    expect("mkdir -p $D/save && echo '<svg xmlns=\"http://www.w3.org/2000/svg\"><path id=\"a\" d=\"M0 0L9 0L9 9Z\"/></svg>' > "
           "$D/save/task.svg && cp $D/target.csv $D/points", 0, NULL, NULL);
    expect("echo '{ \"linkwright-task\": 1, \"target\": \"points\" }' > $D/task.json && $P fit $D/task.json --force "
           "-o $D/points", 2, "", "an input of this command");
    expect("echo '{ \"linkwright-task\": 1, \"target\": \"save/task.svg#a\" }' > $D/task.json && $P fit $D/task.json --force "
           "--save $D/save", 2, "", "an input of this command");
    expect("cmp $D/model.json examples/hoeken.json && cmp $D/target.csv examples/ellipse.csv", 0, "", "");
}

/* Files that linkwright did not write, or that were changed since, are replaced with --force only. */
TEST(others)
{
    expect("$P chains --links 6 -o $D/mine.txt", 2, "", "--force");
    expect("cat $D/mine.txt", 0, "mine\n", NULL);
    expect("$P chains --links 6 -o $D/mine.txt --force && cat $D/mine.txt", 0, "ERr?", NULL);
    expect("$P trace $D/model.json -q -o $D/t.csv && $P trace $D/model.json -q -o $D/t.csv", 0, "", "");
    expect("cp $D/t.csv $D/copy.csv && $P trace $D/model.json -q -o $D/copy.csv", 0, "", "");     /* its comment says who wrote it */
    expect("$P draw $D/model.json > $D/redirected.svg; $P draw $D/model.json -o $D/redirected.svg", 2, "", "--force");
    expect(": > $D/empty.svg; $P draw $D/model.json -o $D/empty.svg", 0, "", "");
    expect("$P trace $D/model.json -q -o /dev/null", 0, "", "");
}

/* A change by hand is noticed on file systems that keep attributes; there pictures need no --force either. */
TEST(changed)
{
    OWN(ran) r = run("$P draw $D/model.json -o $D/p.png && $P draw $D/model.json -o $D/p.png");
    bool keeps = r.code == 0;
    CHECK(keeps || strstr(r.err, "--force"));
    if (keeps)
        expect("echo note >> $D/p.png; $P draw $D/model.json -o $D/p.png", 2, "", "changed since");
}

/* The end of a name promises the kind of data: told before the work. */
TEST(kinds_of_data)
{
    static const char *const texts[] = { "numbers --dof 1 --loops 2", "structures --loops 2", "chains --links 6", "mechanisms --links 4",
        "grammar parse", "mobility examples/hoeken.json", "gallery", "robot jacobian examples/space/delta.json",
        "family table examples/families/loader.json", "family check examples/families/loader.json" };
    for (size_t i = 0; i < sizeof texts/sizeof *texts; i++) {
        expect_with(2, "", "this command writes text; end the name in .json for JSON, or in .txt", "$P %s -o $D/table.csv < /dev/null", texts[i]);
    }
    expect("$P fit examples/ellipse.csv -o $D/found.txt", 2, "", "this command writes JSON; end the name in .json");
    expect("$P fit examples/ellipse.csv -o $D/found.csv", 2, "", "this command writes JSON; end the name in .json");
    expect("$P family expand examples/families/loader.json -o $D/loader.csv", 2, "", "this command writes JSON");
    expect("$P trace examples/hoeken.json -o $D/t.svg", 2, "", "--plot FILE draws them");
    expect("ls $D/table.csv $D/found.* $D/loader.csv $D/t.svg", 2, "", "No such file");
}

TEST(two_outputs)
{
    expect("$P simulate examples/pendulum.json --to 0.1 -o $D/a.csv --plot $D/sub/../a.csv", 2, "", "one file");
    expect("$P simulate examples/pendulum.json --to 0.1 -o $D/a.csv --plot $D/none/a.svg", 3, "", "no such file or folder");
    expect("test -e $D/a.csv", 1, "", "");
}

/* The outputs are checked before the search, which would not end in hours. */
TEST(folders)
{
    expect(PREPARE "$P fit target.csv --links 8 --budget 1e12 --save .", 2, "", "./target.svg exists");
    expect(PREPARE "mkdir other; cp target.csv other; $P fit target.csv other/target.csv --budget 1e12 --links 8 --save two",
           2, "", "under one name");
    expect(PREPARE "$P fit target.csv --links 8 --budget 1e12 --save mine.txt/sub", 3, "", "cannot be made");
    expect(PREPARE "$P fit target.csv --links 8 --budget 1e12 --save two -o two/target-2.json", 2, "", "two/target-2.json");
    expect(PREPARE "$P fit target.csv --rounds 1 --starts 20 -q --save new/folder > table; ls new/folder", 0, "target-1.json", NULL);
    expect("LW_CLOCK_STEP=1 $C fit $D/target.csv --time 0.001 -q --save $D/none/folder; test $? = 5 || exit 1; ls -d $D/none", 2, "", NULL);
    expect("echo mine > $D/curves.csv; $P bench fit --seeds 1 -o $D", 2, "", "curves.csv");
    expect("$P catalogue build $D/a.db --links 4 -q; echo mine > $D/index.html; $P catalogue html $D/a.db -o $D", 2, "",
           "index.html exists");
    expect("$P chains --links 6 | $P draw --each -o $D/sheet.svg; echo mine > $D/sheet-001.svg; "
           "$P chains --links 6 | $P draw --each -o $D/sheet.svg", 2, "", "sheet-001.svg");
}

/* test_cli.c - the built program: help, exit codes, wrong usage, bad input, output. */
#include "tests/cli_json.h"

/* Every command of `linkwright help`. */
static int list_commands(char name[32][32])
{
    int n = 0;
    OWN(ran) r = run("$P help | grep -oE '^  [a-z]+ ' | grep -v help");
    for (char *word = strtok(r.out, " \n"); word && n < 32; word = strtok(NULL, " \n"))
        snprintf(name[n++], sizeof name[0], "%s", word);
    return n;
}

TEST(help_of_every_command)
{
    static const char *const common[] = { "--seed", "--jobs", "--time", "--json", "--output", "--quiet", "--help" };
    char name[32][32], line[1200];
    int n = list_commands(name);
    CHECK(n >= 4);
    for (int i = 0; i < n; i++) {
        OWN(ran) a = run_with("$P %s --help", name[i]);
        OWN(ran) b = run_with("$P help %s", name[i]);
        CHECK_INT(a.code, 0);
        CHECK_TEXT(a.out, b.out);
        CHECK(strstr(a.out, "Examples:") && strstr(a.out, "Examples:") < strstr(a.out, "Options"));
        for (size_t o = 0; o < sizeof common/sizeof *common; o++)
            CHECK_HAS(a.out, common[o]);
        snprintf(line, sizeof line, ".SS %s ", name[i]);
        expect("$P help --roff", 0, line, NULL);
    }
    expect("$P help", 0, "classify", NULL);
    expect("$P --help", 0, "classify", NULL);
    expect("$P --version", 0, "linkwright 0.", NULL);
    expect("$P", 2, NULL, "Usage:");
}

/* A plot or an animation stands alone: nothing else on standard output unless -o or --json asks for the data. The end of
 * every name goes with what is written, else nothing is computed. */
TEST(plots_stand_alone)
{
    static const char *const lines[] = {
        "trace examples/jansen.json -n 8 --plot $D/p.svg", "simulate examples/pendulum.json --to 0.1 -n 4 --plot $D/p.svg",
        "simulate examples/pendulum.json --to 0.1 -n 4 --gif $D/p.gif",
        "simulate examples/pendulum.json --analysis static --from 2 --plot $D/p.svg",
        "simulate examples/space/top.json --to 0.1 -n 4 --plot $D/p.svg",
        "clearance examples/clearance-four-bar.json --speeds 80 --to 0.02 --settle 0.01 --plot $D/p.svg",
        "clearance examples/clearance-four-bar.json --speeds 80 --to 0.02 --settle 0.01 --path $D/p.pdf --force-plot $D/p.svg",
        "profile 1 --acceleration-limit 20 --plot $D/p.svg", "fit examples/ellipse.csv --unlimited --starts 20 --rounds 1 --plot $D/p.svg",
        "profile examples/cycles/gantry.json -n 9 --plot $D/p.svg",
        "robot workspace examples/space/delta.json --rays 4 --plot $D/p.svg",
        "robot map examples/space/delta.json --places 3 --plot $D/p.png",
        "drive load examples/drives/lifting-arm.json --to 0.1 -n 8 --plot $D/p.svg",
        ("drive select examples/drives/lifting-arm.json --to 2.5 -n 100 --motors examples/drives/motors.csv "
         "--gears examples/drives/gears.csv --plot $D/p.svg"),
        "drive simulate examples/drives/servo-axis.json --to 0.1 --plot $D/p.svg",
        "drive simulate examples/drives/servo-axis.json --to 0.1 --bode $D/p.svg",
        "family sweep examples/families/loader.json --vary reach=2:3:2 -n 10 --plot $D/p.svg",
    };
    char name[32][32], line[600], wanted[64];
    for (size_t i = 0; i < sizeof lines/sizeof *lines; i++) {
        ran r = run_with("rm -f $D/p.*; $P %s --quiet && ls $D/p.* | wc -l | tr -dc 12", lines[i]);
        CHECK_INT(r.code, 0);
        CHECK_TEXT(r.out, strstr(lines[i], "force-plot") ? "2" : "1");
        if (r.code != 0 || strlen(r.out) > 1)
            fprintf(stderr, "%s\n%s\n", lines[i], r.err);
        ran_free(&r);
    }
    for (int k = 0, n = list_commands(name); k < n; k++) {                /* each command with a plot has a row here */
        bool here = false;
        snprintf(line, sizeof line, "$P help %.31s | grep -c -- ' --plot FILE'", name[k]);
        snprintf(wanted, sizeof wanted, "%.31s ", name[k]);
        for (size_t i = 0; i < sizeof lines/sizeof *lines; i++)
            here = here || strncmp(lines[i], wanted, strlen(wanted)) == 0;
        expect(line, here ? 0 : 1, here ? "" : "0", NULL);
    }
    expect("$P profile 1 --acceleration-limit 20 --plot $D/p.svg -o $D/p.json && head -c 1 $D/p.json", 0, "{", NULL);
    expect("$P profile 1 --acceleration-limit 20 --plot $D/p.svg --json", 0, "\"duration\"", NULL);
    expect("$P profile 1 --acceleration-limit 20 --plot $D/p.gif", 2, "", "end it in .svg, .pdf or .png");
    expect("$P simulate examples/pendulum.json --gif $D/p.svg", 2, "", "end it in .gif");
    expect("$P fit examples/ellipse.csv -o $D/e.svg", 2, "", "--save FOLDER draws them");
    expect("$P trace examples/jansen.json -o $D/e.PNG", 2, "", "--plot FILE draws them");
    expect("$P trace examples/jansen.json --json -o $D/e.csv", 2, "", "--json writes JSON");
    expect("$P drive radius examples/drives/motors.csv --mass 20 --way 1 --plot $D/p.svg", 2, "", "no option of 'drive radius'");
}

TEST(misspelt_words)
{
    expect("$P clasify 4 2 5 3", 2, NULL, "did you mean 'classify'?");
    expect("$P help clasify", 2, NULL, "did you mean 'classify'?");
    expect("$P xyzzy", 2, NULL, "there is no command 'xyzzy'\n");
    expect("$P classify 4 2 5 3 --tolerence 1", 2, NULL, "did you mean --tolerance?");
    expect("$P classify 4 2 5 3 --angle-unit=grad", 2, NULL, "deg|rad|turn");
}

TEST(options_are_strict)
{
    expect("$P classify 5 2 4 4 --tolerance", 2, NULL, "needs a value");
    expect("$P classify 5 2 4 4 --tolerance --json", 2, NULL, "needs a value");
    expect("$P classify 5 2 4 4 --tolerance 1 --tolerance 2", 2, NULL, "out of range");
    expect("$P classify 5 2 4 4 --json --json", 2, NULL, "twice");
    expect("$P classify 5 2 4 4 --json=yes", 2, NULL, "takes no value");
    expect("$P classify 5 2 4 4 --seed -1", 2, NULL, "no seed");
    expect("$P classify 5 2 4 4 --seed 18446744073709551616", 2, NULL, "no seed");
    expect("$P classify 5 2 4 4 --jobs 1.5", 2, NULL, "no whole number");
    expect("$P classify 5 2 4 4 --tolerance 0x10", 2, NULL, "no number");
    expect("$P classify 5 2 4 4 -z", 2, NULL, "there is no option");
    expect("$P classify 5 2 4", 2, NULL, "L1 L2 L3 L4");
    expect("$P classify 5 2 4 4 7", 2, NULL, "one word too many");
    /* every form of an option, in any order */
    expect("$P classify --angle-unit rad 5 --tolerance=1e-9 2 -qj2 -- 4 4", 0, "crank-rocker", NULL);
    expect("$P trace examples/hoeken.json -n2 -mfile", 0, "arc,mode,input", NULL);
    /* a negative number is a word, not an option */
    expect("$P classify -5 2 4 4", 3, NULL, "positive");
}

/* One row of each kind of docs/theory.md, "Four-bars": (frame, input, coupler, output). */
TEST(classify_table)
{
    static const struct { const char *lengths; int number; const char *symbol; } row[] = {
        { "1 4 5 4", 1, "GCCC" },  { "5 2 4 4", 2, "GCRR" },  { "4 4 1 5", 3, "GRCR" },
        { "5 4 4 2", 4, "GRRC" },  { "7 3 4 4", 5, "RRR1" },  { "4 7 3 4", 6, "RRR2" },
        { "4 4 7 3", 7, "RRR3" },  { "3 4 4 7", 8, "RRR4" },  { "2 3 5 4", 9, "CPCCC" },
        { "4 2 5 3", 10, "CPCRR" }, { "4 5 2 3", 11, "CPRCR" }, { "5 3 4 2", 12, "CPRRC" },
        { "4 2 4 2", 13, "CP2X" }, { "3 3 3 3", 14, "CP3X" },
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        json_auto_t *j = json_with("$P classify %s --json", row[i].lengths);
        CHECK_INT(json_integer_value(json_object_get(j, "class")), row[i].number);
        CHECK_TEXT(json_string_value(json_object_get(j, "symbol")), row[i].symbol);
    }
}

/* Dead points of a crank-rocker, crank and coupler in line, by the cosine rule. */
TEST(classify_numbers)
{
    json_t *j = json_of("$P classify 5 2 4 4 --json --angle-unit rad"), *d = json_object_get(j, "dead_points");
    double out = acos((25.0 + 36 - 16)/(2*5*6)), in = acos((25.0 + 4 - 16)/(2*5*2));
    CHECK_INT(json_array_size(d), 4);
    CHECK_NEAR(json_real_value(json_array_get(d, 2)), out, 1e-14, 0);
    CHECK_NEAR(json_real_value(json_array_get(d, 3)), M_PI - in, 1e-14, 0);      /* folded */
    json_decref(j);
    expect("$P classify 5 2 4 100", 3, NULL, "cannot be assembled");
    expect("$P classify 5 2 4 0", 3, NULL, "positive");
    expect("$P classify 5 2 4 four", 3, NULL, "'four' is no number");
    expect("$P classify 5 2 4 4 --memory 200M", 2, NULL, "--memory GB: '200M' is no number");
    expect("$P classify 5 2 4 nan", 3, NULL, "no number");
}

TEST(output_is_whole_or_absent)
{
    expect("$P classify 5 2 4 4 > /dev/full", 3, NULL, "no space left");
    expect("$P help > /dev/full", 3, NULL, "cannot write");
    expect("$P classify 5 2 4 4 -o /dev/full", 3, NULL, "no space left");
    expect("$P classify 5 2 4 4 -o $D/none/x.txt", 3, NULL, "no such file or folder");
    expect("$P classify 5 2 4 4 -o $D", 3, NULL, "folder");
    expect("echo old > $D/x.txt; $P classify 5 2 4 100 -o $D/x.txt --force; cat $D/x.txt", 0, "old", NULL);
    expect("$P classify 5 2 4 4 -o $D/x.txt --force && cat $D/x.txt && ls -A $D | grep -v std", 0, "crank-rocker", NULL);
    expect("ls -A $D | grep tmp", 1, NULL, NULL);
}

/* Every command that README.md shows after a $ prints the lines that stand below it; "..." stands for the rest of a line. */
TEST(readme_shows_what_is_printed)
{
    char *text = slurp("README.md"), *rest = text;
    char *printed = NULL;
    int commands = 0;
    for (char *line; (line = strsep(&rest, "\n"));) {
        if (strncmp(line, "    $ linkwright ", 17) == 0) {
            ran r = run_with("mkdir -p $D/bin && ln -sf $(realpath $P) $D/bin/linkwright && PATH=$D/bin:$PATH && %s", line + 6);
            CHECK_INT(r.code, 0);
            free(printed);
            printed = r.out;
            free(r.err);
            commands++;
        } else if (strncmp(line, "    ", 4) != 0) {
            free(printed);
            printed = NULL;
        } else if (printed) {
            char *rest_of_line = strstr(line, "...");
            if (rest_of_line)
                *rest_of_line = 0;
            if (!strstr(printed, line + 4))
                fprintf(stderr, "README.md shows a line that is not printed: %s\n", line + 4);
            CHECK_HAS(printed, line + 4);
        }
    }
    CHECK(commands >= 7);
    free(printed);
    free(text);
}

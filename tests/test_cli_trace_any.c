/* test_cli_trace_any.c - `linkwright trace` without a closed form: gears, several inputs, motion laws, closed
 * motions. */
#include "tests/cli_json.h"

/* Read the numbers of the last line of CSV text from the third column on. Returns the number of lines with numbers. */
static int last_row(const char *text, double v[20])
{
    int n = 0;
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        if (*line < '0' || *line > '9')
            continue;
        n++;
        const char *at = line + strcspn(line, ",") + 1;
        at += strcspn(at, ",") + 1;
        for (int c = 0; c < 20; c++) {
            v[c] = *at == ',' ? NAN : strtod(at, NULL);
            at += strcspn(at, ",\n");
            if (*at != ',')
                break;
            at++;
        }
    }
    return n;
}

static int trace(const char *arguments, double v[20])
{
    char line[512];
    snprintf(line, sizeof line, "$P trace %s", arguments);
    OWN(ran) r = run(line);
    if (r.code)
        fprintf(stderr, "%s: %s", line, r.err);
    CHECK_INT(r.code, 0);
    int n = last_row(r.out, v);
    return n;
}

/* The double rocker of Chebyshev as one closed curve: the end is the beginning, and the coupler has made one turn. */
TEST(a_cycle_over_both_limits)
{
    double v[20];
    CHECK_INT(trace("examples/chebyshev.json --cycle --steps 40", v), 41);
    enum { ALONG, INPUT, X, Y, ANGLE = 10 };
    CHECK_NEAR(v[INPUT], acos(0.6)*180/M_PI, 1e-9, 0);
    CHECK_NEAR(v[X], 0, 1e-10, 0);
    CHECK_NEAR(v[Y], 40, 1e-10, 0);
    CHECK_NEAR(v[ANGLE], 360, 1e-9, 0);
    expect("$P trace examples/chebyshev.json --cycle -n 4", 0, "limit of the input: pin O turns back, at input 101.5369590328", NULL);
    expect("$P trace examples/chebyshev.json --cycle -n 4", 0, "circuit 1: closes, the input swings", NULL);
}

/* A model with more parts than a linkage holds: 20 four-bars in a row, whose cranks stay parallel through flat postures. */
TEST(any_number_of_links)
{
    char path[] = "/tmp/linkwright-row-XXXXXX", line[200];
    int fd = mkstemp(path);
    FILE *f = fdopen(fd, "w");
    fputs("{\"linkwright\": 1, \"links\": [\"ground\"", f);
    for (int i = 0; i <= 20; i++)
        fprintf(f, i < 20 ? ", \"c%d\", \"r%d\"" : ", \"c%d\"", i, i);
    fputs("], \"joints\": [{\"name\": \"A0\", \"links\": [\"ground\", \"c0\"], \"at\": [0, 0]}", f);
    for (int i = 1; i <= 20; i++)
        fprintf(f, ", {\"name\": \"A%d\", \"links\": [\"ground\", \"c%d\"], \"at\": [%d, 0]}, {\"name\": \"B%d\", \"links\": [\"c%d\", \"r%d\"], "
                "\"at\": [%d, 1]}, {\"name\": \"C%d\", \"links\": [\"r%d\", \"c%d\"], \"at\": [%d, 1]}", i, i, i, i, i - 1, i - 1, i - 1, i,
                i - 1, i, i);
    fputs("], \"input\": {\"joint\": \"A0\", \"motion\": "
          "\"1.5707963267948966 + 2*t\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"r19\", \"at\": [19.5, 1]}]}", f);
    fclose(f);
    double v[20];
    snprintf(line, sizeof line, "%s -n 7", path);
    CHECK_INT(trace(line, v), 8);
    CHECK_NEAR(v[0], 2.5*M_PI, 1e-12, 0);
    CHECK_NEAR(v[1], 19.5, 1e-10, 0);
    CHECK_NEAR(v[2], 1, 1e-10, 0);
    CHECK_NEAR(v[3], -1, 1e-10, 0);
    CHECK_NEAR(v[6], -1, 1e-9, 0);
    snprintf(line, sizeof line, "%s --time-range 0:3:0.5", path);
    CHECK_INT(trace(line, v), 7);
    CHECK_NEAR(v[2], 19.5 - sin(6), 1e-10, 0);
    CHECK_NEAR(v[4], -2*cos(6), 1e-9, 0);
    expect_with(0, "driven          1 of 1 freedom by 1 input", NULL, "$P mobility %s", path);
    expect_with(0, "P.x", NULL, "$P simulate %s --to 1 -n 2", path);
    static const char *const kinds[] = { "svg", "pdf", "gif", "html" }, *const formats[] = { "mjcf", "adams", "urdf", "svg", "poses", "pyslvs", "pmks", "slvs" };
    for (size_t i = 0; i < sizeof kinds/sizeof *kinds; i++) {
        OWN(ran) r = run_with("$P draw %s --format %s -n 6 | wc -c", path, kinds[i]);
        CHECK(atoi(r.out) > 900 && !r.err[0]);
    }
    for (size_t i = 0; i < sizeof formats/sizeof *formats; i++) {
        OWN(ran) r = run_with("$P convert %s --format %s | wc -c", path, formats[i]);
        CHECK(atoi(r.out) > 900 && !r.err[0]);
    }
    expect_with(0, NULL, NULL, "$P convert %s --format json > %s.json && $P convert %s.json --format json | cmp - %s.json", path, path,
                path, path);
    snprintf(line, sizeof line, "%s.json -n 7", path);
    CHECK_INT(trace(line, v), 8);
    CHECK_NEAR(v[2], 1, 1e-10, 0);
    remove(strcat(strcpy(line, path), ".json"));
    expect_with(0, "# circuit 1: closes after 1 turn of the input", NULL, "$P trace %s --cycle -n 2 --quiet | grep -v '^# linkwright'", path);
    snprintf(line, sizeof line, "%s --cycle -n 4", path);
    CHECK_INT(trace(line, v), 5);
    CHECK_NEAR(v[1], 2.5*M_PI, 1e-12, 0);
    CHECK_NEAR(v[2], 19.5, 1e-12, 0);
    CHECK_NEAR(v[3], 1, 1e-12, 0);
    CHECK_NEAR(v[4], -1, 1e-10, 0);
    expect_with(0, "42 links and 61 joints, all at once: 123 coordinates", NULL, "$P trace %s --explain", path);
    remove(path);
}

/* Scissors of 16 stages, moved by a slider: 34 links and 49 joints are cut as plates in few layers. */
TEST(plates_of_any_number)
{
    char path[] = "/tmp/linkwright-scissors-XXXXXX";
    FILE *f = fdopen(mkstemp(path), "w");
    fputs("{\"linkwright\": 1, \"units\": {\"length\": \"m\"}, \"joints\": [{\"name\": \"S\", \"kind\": \"t\", \"links\": [\"ground\", \"s\"], "
          "\"at\": [2, 0], \"along\": [1, 0]}", f);
    for (int i = 0; i < 16; i++)
        fprintf(f, ", {\"name\": \"A%d\", \"links\": [\"%s%.0d\", \"a%d\"], \"at\": [0, %d]}, {\"name\": \"B%d\", \"links\": [\"%s%.0d\", "
                "\"b%d\"], \"at\": [2, %d]}, {\"name\": \"M%d\", \"links\": [\"a%d\", \"b%d\"], \"at\": [1, %d.5]}",
                i, i == 0 ? "ground" : i == 1 ? "b0" : "b", i > 1 ? i - 1 : 0, i, i, i, i == 0 ? "s" : i == 1 ? "a0" : "a",
                i > 1 ? i - 1 : 0, i, i, i, i, i, i);
    fputs("], \"links\": [\"ground\", \"s\"", f);
    for (int i = 0; i < 16; i++)
        fprintf(f, ", \"a%d\", \"b%d\"", i, i);
    fputs("], \"input\": {\"joint\": \"S\", \"first\": -0.3, \"last\": 0.1}}", f);
    fclose(f);
    expect_with(0, "84", NULL, "$P convert %s --format stl | grep -c ^solid", path);                               /* 34 plates, 48 pins and the two of the slider */
    remove(path);
}

/* The closed form and the continuation give the same curve: every posture of the plan lies on the closed curve,
 * found by its input. */
TEST(two_ways_agree)
{
    OWN(ran) r = run("$P trace examples/slider-crank.json --tracer piston --mode file --input-range 37:37.5 -n 1");
    double plan[20], curve[20];
    last_row(r.out, plan);
    ran_free(&r);
    r = run("sed 's/\"input\": {\"joint\": \"O\"\\([^}]*\\)}/\"inputs\": [{\"joint\": \"O\"\\1}, {\"joint\": \"W\"}]/;"
            "s/\"joints\": \\[/\"joints\": [{\"name\": \"W\", \"links\": [\"ground\", \"wheel\"], \"at\": [0, -90]},/;"
            "s/\"rod\", \"slider\"\\],$/\"rod\", \"slider\", \"wheel\"],/' examples/slider-crank.json | "
            "$P trace - --tracer piston --mode file --input-range 37:37.5 -n 1");
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.err, "input 1 moves, the other rests");
    CHECK_INT(last_row(r.out, curve), 2);
    for (int i = 0; i < 13; i++)
        CHECK_NEAR(curve[i], plan[i], 1e-10, 1e-10);
}

TEST(a_geared_five_bar_closes_after_two_turns)
{
    double v[20];
    CHECK_INT(trace("examples/geared-five-bar.json -n 8", v), 9);
    CHECK_NEAR(v[0], 45 + 720, 1e-9, 0);
    CHECK_NEAR(v[1], 35, 1e-10, 0);
    CHECK_NEAR(v[2], 75, 1e-10, 0);
    CHECK_INT(trace("examples/geared-five-bar.json -n 10 --input-range 400:410", v), 11);
    CHECK_NEAR(v[0], 410, 1e-9, 0);
    expect("$P trace examples/geared-five-bar.json -n 2", 0, "closes after 2 turns of the input", "motion curve");
    expect("$P trace examples/geared-five-bar.json -n 2 --all-assemblies", 0, "# circuit 2: closes after 2 turns",
           "2 circuits found so far; the last 300 of");
    expect("$P trace examples/geared-five-bar.json -n 2 --speed 2", 0, "v a j mm/s mm/s^2", NULL);
}

/* The loader's cylinders stop after 2 s, so it stands still. */
TEST(inputs_move_in_time)
{
    double v[20], w[20];
    CHECK_INT(trace("examples/loader.json --time-range 0:2.5:0.05", v), 51);
    CHECK_NEAR(v[0], 2.5, 0, 0);
    CHECK_NEAR(v[1], 0.55, 1e-15, 0);
    CHECK_NEAR(v[2], -0.12, 1e-15, 0);
    CHECK(v[5] == 0 && v[6] == 0 && v[7] == 0 && v[14] == 0);
    trace("examples/loader.json --time-range 0:3:3", w);       /* the same posture with one step of output */
    CHECK_NEAR(w[3], v[3], 1e-12, 0);
    CHECK_NEAR(w[4], v[4], 1e-12, 0);
    CHECK_INT(trace("examples/five-bar.json --time-range 0:1:0.1", v), 11);
    CHECK_NEAR(v[3], 0, 1e-11, 0);
    CHECK_NEAR(v[4], 100, 1e-11, 0);
    expect("$P trace examples/five-bar.json --time-range 0:1:0.5", 0, "time,input,input_2,x,y", "in time by Newton");
    expect("sed 's/\"speed\": -1/\"motion\": \"pi*(t + 0.5)\"/' examples/two-four-bars.json |"
           /* a row at a change point */
           "$P trace - --time-range 0:2:0.5", 0, "# branch points passed straight on: 2, the last at time 1.5", NULL);
}

TEST(json_can_be_read)
{
    static const char *const argument[] = { "examples/geared-five-bar.json -n 3", "examples/klann.json --cycle -n 3",
                                            "examples/five-bar.json --time-range 0:1:0.5",
                                            "examples/geared-five-bar.json -n 2 --all-assemblies" };
    static const char *const way[] = { "curve", "cycle", "time", "curve" };
    for (int i = 0; i < 4; i++) {
        json_auto_t *root = json_with("$P trace %s --json", argument[i]);
        CHECK_TEXT(json_string_value(json_object_get(root, "way")), way[i]);
        const json_t *arcs = json_object_get(root, "arcs"), *rows = json_object_get(json_array_get(arcs, 0), "rows");
        CHECK_INT(json_array_size(arcs), i == 3 ? 2 : 1);
        CHECK_INT(json_array_size(json_array_get(rows, 0)), json_array_size(json_object_get(root, "columns")));
    }
}

#define MODEL(joints, inputs) "printf '%s' '{\"linkwright\":1,\"ground\":\"g\",\"joints\":[" joints "]," \
    inputs ",\"tracers\":[{\"name\":\"P\",\"link\":\"b\",\"at\":[1,2]}]}' | $P trace - "
#define FIVE_BAR "{\"name\":\"A\",\"links\":[\"g\",\"a\"],\"at\":[0,0]}," \
    "{\"name\":\"B\",\"links\":[\"a\",\"b\"],\"at\":[0,1]}," \
    "{\"name\":\"C\",\"links\":[\"b\",\"c\"],\"at\":[1,2]},{\"name\":\"D\",\"links\":[\"c\",\"d\"],\"at\":[3,1]}," \
    "{\"name\":\"E\",\"links\":[\"d\",\"g\"],\"at\":[3,0]}"
#define FOUR_BAR "{\"name\":\"A\",\"links\":[\"g\",\"a\"],\"at\":[0,0]}," \
    "{\"name\":\"B\",\"links\":[\"a\",\"b\"],\"at\":[0,3]}," \
    "{\"name\":\"C\",\"links\":[\"b\",\"c\"],\"at\":[2,3]},{\"name\":\"E\",\"links\":[\"c\",\"g\"],\"at\":[4,0]}"
#define THREE(more) "\"inputs\":[{\"joint\":\"A\"},{\"joint\":\"E\"},{\"joint\":\"C\"" more "}]"
#define MOTION(text) "\"input\":{\"joint\":\"A\",\"value\":1.5707963267948966,\"motion\":\"" text "\"}"

TEST(faults_are_reported)
{
    expect(MODEL(FIVE_BAR, "\"input\":{\"joint\":\"A\"}"), 3, NULL, "2 freedoms but 1 input; drive 1 more joint");
    expect(MODEL(FIVE_BAR, THREE("")), 3, NULL, "2 freedoms but 3 inputs; leave out 1");
    expect(MODEL(FIVE_BAR, THREE(",\"motion\":\"t\"")) "--time-range 0:1:0.1", 3, NULL, "2 freedoms but 3 inputs");
    expect(MODEL(FOUR_BAR, MOTION("1.5+sin(t")) "--time-range 0:1:0.1", 3, NULL, "input:1:276: input.motion: ");
    expect(MODEL(FOUR_BAR, "\"input\":{\"joint\":\"A\"}") "--time-range 0:1:0.1", 3, NULL, "no input has a \"motion\"");
    expect("$P trace examples/five-bar.json --time-range 0:1", 2, NULL, "T0:T1:DT");
    expect("$P trace examples/five-bar.json --time-range 0:1:-1", 2, NULL, "T0:T1:DT");
    expect("$P trace examples/five-bar.json --time-range 0:x:1", 2, NULL, "time-range");
    expect("$P trace examples/geared-five-bar.json --tracer Q", 3, NULL, "no tracer 'Q'");
    expect("$P trace examples/chebyshev.json --cycle --input-range 1:2", 2, NULL, "cycle");
    /* the motion reaches the limit of the rocker: the rows before it are kept */
    expect(MODEL(FOUR_BAR, MOTION("pi/2 - t")) "--time-range 0:3:0.1", 5, "1,.,0.1,", "beyond a limit of the linkage");
    expect(MODEL(FOUR_BAR, MOTION("pi/2 + 0*sqrt(1 - t)")) "--time-range 0:3:0.5", 4, NULL, "no number there");
    expect(MODEL(FOUR_BAR, MOTION("pi/2 + 0.1*sign(t - 1)")) "--time-range 0:3:0.3", 3, "", "jumps by 0.2 at t = 1 s");
    expect(MODEL(FOUR_BAR, MOTION("stepp(t, 0, 0, 1, 1)")) "--time-range 0:3:0.3", 3, "", "did you mean step?");
    expect(MODEL(FOUR_BAR, MOTION("3 + t")) "--time-range 0:3:0.1", 4, "", "cannot get to where the motions begin");
}

/* Stephenson III driven where its dyad stands on the ground, a triad; and the boom of a loader on
 * its cylinder, an input between moving links. */
#define TRIAD "'{\"linkwright\":1,\"links\":[\"ground\",\"bar\",\"coupler\",\"rocker\",\"arm\",\"crank\"],\"joints\":[" \
    "{\"name\":\"A\",\"links\":[\"ground\",\"bar\"],\"at\":[0,0]},{\"name\":\"B\",\"links\":[\"bar\",\"coupler\"],\"at\":[0.5,0.8]}," \
    "{\"name\":\"C\",\"links\":[\"coupler\",\"rocker\"],\"at\":[2.6,2.1]},{\"name\":\"D\",\"links\":[\"ground\",\"rocker\"],\"at\":[3,0]}," \
    "{\"name\":\"E\",\"links\":[\"coupler\",\"arm\"],\"at\":[1.1,2.4]},{\"name\":\"F\",\"links\":[\"arm\",\"crank\"],\"at\":[-0.3,3]}," \
    "{\"name\":\"G\",\"links\":[\"ground\",\"crank\"],\"at\":[-1.5,3]}],\"input\":{\"joint\":\"G\"}," \
    "\"tracers\":[{\"name\":\"P\",\"link\":\"arm\",\"at\":[0.2,2.9]}]}'"
#define BOOM "'{\"linkwright\":1,\"units\":{\"length\":\"m\",\"angle\":\"deg\"},\"links\":[\"ground\",\"boom\",\"tube\",\"rod\"]," \
    "\"joints\":[{\"name\":\"O\",\"links\":[\"ground\",\"boom\"],\"at\":[0,1.5]},{\"name\":\"L\",\"links\":[\"ground\",\"tube\"],\"at\":[0.3,0.6]}," \
    "{\"name\":\"lift\",\"kind\":\"t\",\"links\":[\"tube\",\"rod\"],\"at\":[0.3,0.6],\"along\":[1.1,0.4]}," \
    "{\"name\":\"R\",\"links\":[\"rod\",\"boom\"],\"at\":[1.4,1]}],\"input\":{\"joint\":\"lift\"}," \
    "\"tracers\":[{\"name\":\"edge\",\"link\":\"boom\",\"at\":[2.4,0.3]}]}'"

/* Rows of CSV, 13 columns from the third on; returns how many. */
static int all_rows(const char *text, double (*v)[13], int room)
{
    int n = 0;
    for (const char *line = text; *line && n < room; line += strcspn(line, "\n"), line += *line == '\n') {
        if (*line < '0' || *line > '9')
            continue;
        const char *at = line;
        for (int skip = 0; skip < 2; skip++)
            at += strcspn(at, ",") + 1;
        for (int c = 0; c < 13; c++, at += strcspn(at, ",\n"), at += *at == ',')
            v[n][c] = *at == ',' || *at == '\n' ? NAN : strtod(at, NULL);
        n++;
    }
    return n;
}

static int rows_of(const char *line, double (*v)[13], int room)
{
    OWN(ran) r = run(line);
    CHECK_INT(r.code, 0);
    int n = all_rows(r.out, v, room);
    return n;
}

/* Between the postures of the curve the rows are solved by Assur groups. Every 16th row of a fine table is on the
 * curve, and with 16 times fewer rows all are: both are compared, and the rates with differences of neighbouring
 * rows. */
TEST(groups_and_curve_agree)
{
    enum { FINE = 1008, COARSE = 63, ROOM = 4*(FINE + 1) };
    static const char *const model[] = { TRIAD, BOOM };
    static double fine[ROOM][13], coarse[ROOM][13];
    char line[4096];
    for (int i = 0; i < 2; i++) {
        snprintf(line, sizeof line, "echo %s | $P trace - -n %d", model[i], FINE);
        int n = rows_of(line, fine, ROOM), arcs = n/(FINE + 1), worse = 0;
        CHECK(arcs >= 2 && n == arcs*(FINE + 1));
        snprintf(line, sizeof line, "echo %s | $P trace - -n %d", model[i], COARSE);
        CHECK_INT(rows_of(line, coarse, ROOM), arcs*(COARSE + 1));
        for (int arc = 0; arc < arcs; arc++)
            for (int r = 0; r <= COARSE; r++) {
                const double *a = fine[arc*(FINE + 1) + FINE/COARSE*r], *b = coarse[arc*(COARSE + 1) + r];
                for (int c = 0; c < 13; c++)
                    if (!(isnan(a[c]) && isnan(b[c])))
                        CHECK_NEAR(a[c], b[c], 1e-9, 1e-8);
            }
        for (int r = 1; r + 1 < n; r++) {                       /* velocity and rotation against differences */
            const double *a = fine[r - 1], *b = fine[r], *c = fine[r + 1];
            int at = r % (FINE + 1);
            if (at < 40 || at > FINE - 40)                       /* steep at limits */
                continue;
            double by = c[0] - a[0], tolerance = 1e-2*(1 + fabs(b[3]) + fabs(b[5])/10);
            worse += !(fabs((c[1] - a[1])/by - b[3]) < tolerance) + !(fabs(c[9] - a[9]) < 20);
        }
        CHECK_INT(worse, 0);
    }
}

TEST(the_way_is_told)
{
    expect("echo " TRIAD " | $P trace - --explain", 0, "by these groups", NULL);
    expect("echo " TRIAD " | $P trace - --explain", 0, "class III", NULL);
    expect("echo " BOOM " | $P trace - --explain", 0, "inside a group", NULL);
    expect("$P trace examples/jansen.json --explain", 0, "traced in closed form over all arcs", NULL);
    expect("$P trace examples/geared-five-bar.json --explain", 0, "all links at once: joint \"G\" is of kind 'g'", NULL);
}

/* Two parallelograms are dyads, but an assembly mode of a dyad changes direction at a change point; the circuit of
 * the file goes straight on, with every crank turning like the first. */
TEST(change_points_are_passed_straight_on)
{
    static double v[2*61][13];
    const char *named = "# circuit 1: branch point, passed straight on; circuit 2 crosses, at input 3.14159265358";
    expect("$P trace examples/two-four-bars.json -n 2", 0, named, "passes change points");
    CHECK_INT(rows_of("sed 's/\"link\": \"crank0\"/\"link\": \"crank2\"/' examples/two-four-bars.json |"
                      "$P trace - -m file -n 60 --input-range 0:12", v, 61), 61);
    for (int i = 0; i <= 60; i++) {
        CHECK_NEAR(v[i][0], 0.2*i, 1e-14, 0);
        CHECK_NEAR(v[i][9], v[i][0] - 0.5*M_PI, 1e-12, 0);
        CHECK_NEAR(v[i][10], 1, 1e-11, 0);
        CHECK_NEAR(v[i][11], 0, 1e-9, 0);
        CHECK_NEAR(v[i][12], 0, 1e-6, 0);
        CHECK_NEAR(v[i][1], 2 + cos(v[i][0]) - 2*sin(v[i][0]), 1e-11, 0);   /* (0, 1), 2 left of the crank's pin */
    }
}

#define NO_BAR "{\"name\":\"A\",\"links\":[\"g\",\"a\"],\"at\":[0,0]}," \
    "{\"name\":\"B\",\"links\":[\"a\",\"b\"],\"at\":[1,0]},{\"name\":\"C\",\"links\":[\"b\",\"c\"],\"at\":[1,0]}," \
    "{\"name\":\"D\",\"links\":[\"c\",\"g\"],\"at\":[2,1]}"

/* The roller of a Scotch yoke can spin without effect on the tracer. */
TEST(idle_freedoms_are_held)
{
    expect("$P trace examples/mobility/roller.json -n 2", 0, "closes after 1 turn", "R is held still");
    expect("$P trace examples/mobility/roller.json --explain", 0, "links at once", "R is held still");
}

/* A bar of length zero spins while all other links stand still. A window may hold many turns, but not any number of
 * swings. */
TEST(odd_ranges_of_the_input)
{
    static double v[4][13];
    expect(MODEL(NO_BAR, "\"input\":{\"joint\":\"A\"}"), 1, "closes, the input stands still", "--cycle shows how");
    CHECK_INT(rows_of("$P trace examples/geared-five-bar.json -n 3 --input-range -1395:765", v, 4), 4);
    for (int c = 1; c < 13; c++)
        if (c != 9)
            CHECK_NEAR(v[0][c], v[3][c], 1e-8, 1e-9);           /* 3 times 2 turns later */
    expect("echo " TRIAD " | $P trace - -n 1 --input-range -1e9:1e9 -o /dev/null", 5, NULL, "more arcs than the 1024");
    expect("$P trace examples/chebyshev.json -n 1 --input-range -1e9:1e9 -o /dev/null", 5, NULL, "more arcs than");
}

/* Seven rockers on one crank have 2^7 assembly modes, more than are listed in closed form: the search along curves finds them all.  A
 * limit of 1000 readings of the clock ends it early. */
TEST(more_arcs_than_in_closed_form)
{
    char path[] = "/tmp/linkwright-rockers-XXXXXX";
    char line[200];
    FILE *f = fdopen(mkstemp(path), "w");
    fputs("{\"linkwright\": 1, \"links\": [\"ground\", \"crank\"", f);
    for (int i = 0; i < 7; i++)
        fprintf(f, ", \"b%d\", \"r%d\"", i, i);
    fputs("], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"crank\"], \"at\": [0, 0]}", f);
    for (int i = 0; i < 7; i++) {
        double bx = cos(1), by = sin(1), rod = 2.8 + 0.03*i, rocker = 2 + 0.02*i, dx = 3*cos(0.7*i + 0.1), dy = 3*sin(0.7*i + 0.1);
        double far = hypot(dx - bx, dy - by), along = (rod*rod - rocker*rocker + far*far)/(2*far), high = sqrt(rod*rod - along*along);
        fprintf(f, ", {\"name\": \"B%d\", \"links\": [\"crank\", \"b%d\"], \"at\": [%.17g, %.17g]}, {\"name\": \"C%d\", \"links\": "
                "[\"b%d\", \"r%d\"], \"at\": [%.17g, %.17g]}, {\"name\": \"D%d\", \"links\": [\"ground\", \"r%d\"], \"at\": "
                "[%.17g, %.17g]}", i, i, bx, by, i, i, i, bx + (along*(dx - bx) - high*(dy - by))/far,
                by + (along*(dy - by) + high*(dx - bx))/far, i, i, dx, dy);
    }
    fputs("], \"input\": {\"joint\": \"A\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"b6\", \"at\": [1, 2]}]}", f);
    fclose(f);
    OWN(ran) r = run_with("$P trace %s -n 1", path);
    double v[20];
    CHECK_INT(r.code, 0);
    CHECK_HAS(r.err, "128 circuits found");
    CHECK_INT(last_row(r.out, v), 256);
    ran_free(&r);
    snprintf(line, sizeof line, "LW_CLOCK_STEP=0.001 $C trace %s -n 1 --all-assemblies --time 1", path);
    r = run(line);
    CHECK_INT(r.code, 5);
    CHECK_HAS(r.err, "half of --time ended the search");
    CHECK(last_row(r.out, v) < 256);
    remove(path);
}

/* Three parallel bars, rounded to 1e-5, move after they are adjusted; the search begins from there. */
TEST(circuits_of_a_rounded_overconstrained_linkage)
{
    char path[] = "/tmp/linkwright-bars-XXXXXX";
    FILE *f = fdopen(mkstemp(path), "w");
    fputs("{\"linkwright\": 1, \"links\": [\"ground\", \"c0\", \"c1\", \"c2\", \"b\"], \"joints\": ["
          "{\"name\": \"A0\", \"links\": [\"ground\", \"c0\"], \"at\": [0, 0]}, {\"name\": \"B0\", \"links\": [\"c0\", \"b\"], \"at\": [1.00001, 1.7]}, "
          "{\"name\": \"A1\", \"links\": [\"ground\", \"c1\"], \"at\": [4, 0]}, {\"name\": \"B1\", \"links\": [\"c1\", \"b\"], \"at\": [5, 1.70002]}, "
          "{\"name\": \"A2\", \"links\": [\"ground\", \"c2\"], \"at\": [9, 0]}, {\"name\": \"B2\", \"links\": [\"c2\", \"b\"], \"at\": [10, 1.69999]}], "
          "\"input\": {\"joint\": \"A0\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"b\", \"at\": [6, 3]}]}", f);
    fclose(f);
    expect_with(0, "# circuit 1: closes after 1 turn of the input", "joints were moved", "$P trace %s --all-assemblies -n 4", path);
    remove(path);
}

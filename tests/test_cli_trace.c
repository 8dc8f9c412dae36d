/* test_cli_trace.c - `linkwright trace` on the models of examples/. */
#include "tests/cli_json.h"

/* ---- tables ------------------------------------------------------------------------------------ */

enum { ARC, MODE, INPUT, X, Y, VX, VY, AX, AY, JX, JY, ANGLE, COLUMNS = 20 };
static const char *const known[] = { "arc", "mode", "input", "x", "y", "vx", "vy", "ax", "ay", "jx", "jy", "angle" };

/* v[row][column]; columns with a known name in that order, then the others as they come */
typedef struct table { int n, n_column; char name[COLUMNS][32], mode[4096]; double v[4096][COLUMNS]; } table;

static int column(const table *t, const char *name)
{
    for (int c = 0; c < t->n_column; c++)
        if (strcmp(t->name[c], name) == 0)
            return c;
    return -1;
}

/* The rows of CSV text; an empty field is NAN. */
static table *read_csv(char *text)
{
    table *t = calloc(1, sizeof *t);
    char *rest = text, *cell[CELLS];
    int to[COLUMNS] = { 0 };
    for (char *line; (line = strsep(&rest, "\n")) && t->n < 4096;) {
        bool heading = strncmp(line, "arc,", 4) == 0;
        if (!heading && (*line < '0' || *line > '9'))
            continue;
        int n = split_cells(line, true, cell);
        CHECK(n <= COLUMNS);
        if (heading) {
            for (size_t k = 0; k < sizeof known/sizeof *known; k++)
                snprintf(t->name[t->n_column++], sizeof t->name[0], "%s", known[k]);
            for (int c = 0; c < n && c < COLUMNS; c++) {
                if (column(t, cell[c]) < 0 && t->n_column < COLUMNS)
                    snprintf(t->name[t->n_column++], sizeof t->name[0], "%s", cell[c]);
                to[c] = column(t, cell[c]);
            }
            continue;
        }
        for (int c = 0; c < n && c < COLUMNS; c++)
            t->v[t->n][to[c]] = cell[c][0] ? strtod(cell[c], NULL) : NAN;
        t->mode[t->n++] = cell[1][0];
    }
    return t;
}

static table *trace(const char *arguments)
{
    char line[512];
    snprintf(line, sizeof line, "$P trace %s", arguments);
    OWN(ran) r = run(line);
    if (r.code)
        fprintf(stderr, "%s: %s", line, r.err);
    CHECK_INT(r.code, 0);
    table *t = read_csv(r.out);
    return t;
}

/* Offset slider-crank in closed form: piston at r cos q + sqrt(l^2 - (r sin q - e)^2) and its
 * derivatives; r 30, l 80, e 10 as in the file [mm]. */
static void piston(double q, double d[4])
{
    double r = 30, l = 80, e = 10;
    double u = r*sin(q) - e, u1 = r*cos(q), u2 = -r*sin(q), u3 = -r*cos(q);
    double w = sqrt(l*l - u*u), w1 = -u*u1/w, w2 = -(u1*u1 + u*u2 + w1*w1)/w;
    double w3 = -(3*u1*u2 + u*u3 + 3*w1*w2)/w;
    d[0] = r*cos(q) + w;
    d[1] = -r*sin(q) + w1;
    d[2] = -r*cos(q) + w2;
    d[3] = r*sin(q) + w3;
}

TEST(slider_crank_is_exact)
{
    FREED table *t = trace("examples/slider-crank.json --tracer piston --mode file --steps 72");
    CHECK_INT(t->n, 73);
    for (int i = 0; i < t->n; i++) {
        double d[4];
        piston(t->v[i][INPUT]*M_PI/180, d);
        for (int order = 0; order < 4; order++) {
            CHECK_NEAR(t->v[i][X + 2*order], d[order], 1e-10, 0);
            CHECK_NEAR(t->v[i][Y + 2*order], order ? 0 : 10, 1e-10, 0);
        }
        CHECK_NEAR(t->v[i][ANGLE], 0, 1e-10, 0);
    }
}

TEST(speed_scales_by_powers)
{
    FREED table *t = trace("examples/slider-crank.json --tracer piston -m file -n 12 --speed -3");
    for (int i = 0; i < t->n; i++) {
        double d[4];
        piston(t->v[i][INPUT]*M_PI/180, d);
        CHECK_NEAR(t->v[i][VX], -3*d[1], 1e-9, 0);
        CHECK_NEAR(t->v[i][AX], 9*d[2], 1e-9, 0);
        CHECK_NEAR(t->v[i][JX], -27*d[3], 1e-9, 0);
    }
}

TEST(both_modes)
{
    table *t = trace("examples/slider-crank.json --tracer piston --steps 10");
    CHECK_INT(t->n, 22);
    CHECK(t->mode[0] != t->mode[21]);
    free(t);
    t = trace("examples/hoeken.json --steps 10");
    CHECK_INT(t->n, 22);
    free(t);
}

/* Chebyshev: 40, 50, 20, 50 mm. The input ends where coupler and output are in line, so that its end is
 * 70 or 30 mm from the other pivot: cos q = (50^2 + 40^2 - s^2)/(2 50 40). */
TEST(limits_are_found)
{
    table *t = trace("examples/chebyshev.json --mode file --steps 4");
    double a = acos((4100 - 900)/4000.0)*180/M_PI, b = acos((4100 - 4900)/4000.0)*180/M_PI;
    CHECK_INT(t->n, 5);
    CHECK_NEAR(t->v[0][INPUT], a, 6e-9, 0);           /* 1e-10 rad */
    CHECK_NEAR(t->v[4][INPUT], b, 6e-9, 0);
    CHECK(isnan(t->v[0][VX]) && isnan(t->v[4][JY]));
    CHECK(isfinite(t->v[0][X]) && isfinite(t->v[2][JY]));
    free(t);
    expect("$P trace examples/chebyshev.json -m file", 0, "(limit) to ", NULL);
    t = trace("examples/jansen.json --steps 2");          /* both assembly modes meet in the posture of the limit */
    for (int end = 0; end < 3; end += 2)
        for (int c = INPUT; c <= ANGLE; c++)
            if (c < VX || c > JY)
                CHECK_NEAR(t->v[end][c], t->v[3 + end][c], c == ANGLE ? 1e-10 : 1e-11, 0);
    free(t);
    t = trace("examples/chebyshev.json --steps 2");
    CHECK_NEAR(t->v[2][X], 20, 1e-13, 0);                 /* coupler and rocker in line: below the pin */
    CHECK_NEAR(t->v[5][X], 20, 1e-13, 0);
    CHECK_NEAR(remainder(t->v[2][ANGLE] - 90, 360), 0, 1e-12, 0);
    free(t);
}

/* Hoeken, crank 20, frame 40, coupler and rocker 50: rocker turns back where crank and coupler are in
 * line, 70 and 30 mm from its pivot on a triangle with 40 and 50. */
TEST(dead_points_are_reported)
{
    json_auto_t *j = json_of("$P trace examples/hoeken.json -m file -n 4 --json");
    json_t *d = json_object_get(json_array_get(json_object_get(j, "arcs"), 0), "dead_points");
    double out = acos((4900 + 1600 - 2500)/5600.0), in = acos((900 + 1600 - 2500)/2400.0);
    CHECK_INT(json_array_size(d), 2);
    for (size_t i = 0; i < json_array_size(d); i++) {
        double q = json_number_value(json_object_get(json_array_get(d, i), "input"))*M_PI/180;
        double off = fmin(fabs(remainder(q - out, 2*M_PI)), fabs(remainder(q + out, 2*M_PI)));
        off = fmin(off, fmin(fabs(remainder(q - in - M_PI, 2*M_PI)), fabs(remainder(q + in - M_PI, 2*M_PI))));
        CHECK_NEAR(off, 0, 1e-9, 0);
        CHECK_TEXT(json_string_value(json_object_get(json_array_get(d, i), "link")), "rocker");
    }
}

TEST(windows_are_cut)
{
    table *t = trace("examples/slider-crank.json --tracer piston -m file --input-range -30:400 -n 43");
    CHECK_INT(t->n, 44);
    CHECK_NEAR(t->v[0][INPUT], -30, 1e-12, 0);
    CHECK_NEAR(t->v[43][INPUT], 400, 1e-12, 0);
    CHECK_NEAR(t->v[1][X], t->v[37][X], 1e-10, 0);        /* one turn later */
    free(t);
    t = trace("examples/chebyshev.json -m file --input-range 0:60 -n 2");
    CHECK_INT(t->n, 3);
    CHECK_NEAR(t->v[2][INPUT], 60, 1e-12, 0);
    CHECK(isnan(t->v[0][VX]) && isfinite(t->v[2][VX]));   /* one limit, one cut */
    free(t);
    t = trace("examples/scott-russell.json -m file -n 16");     /* first and last input are given in the file */
    CHECK_NEAR(t->v[0][INPUT], -80, 1e-12, 0);
    CHECK_NEAR(t->v[16][INPUT], 80, 1e-12, 0);
    for (int i = 0; i < t->n; i++)
        CHECK_NEAR(t->v[i][X], 0, 1e-11, 0);              /* the exact straight line */
    free(t);
    expect("$P trace examples/chebyshev.json --input-range 200:210", 1, NULL, "does not reach");
}

/* x^2/a^2 + y^2/b^2 = 1 for a point of the bar of an elliptic trammel; rates by the slider. */
TEST(trammel_draws_an_ellipse)
{
    FREED table *t = trace("examples/trammel.json -m file -n 20");
    for (int i = 0; i < t->n; i++)
        CHECK_NEAR(t->v[i][X]*t->v[i][X]/(150*150) + t->v[i][Y]*t->v[i][Y]/(50*50), 1, 1e-11, 0);
    CHECK_NEAR(t->v[10][VX], 1.5, 1e-11, 0);              /* x = 1.5 times the displacement */
}

TEST(several_tracers_and_all_examples)
{
    expect("$P trace examples/slider-crank.json -n 2", 0, "arc,mode,input,tracer,x,y", NULL);
    expect("$P trace examples/slider-crank.json -n 2", 0, ",middle,", NULL);
    expect("$P trace examples/hoeken.json -n 2", 0, "arc,mode,input,x,y,vx", NULL);
    expect("for f in $(grep -l tracers $(grep -l '\"input' examples/*.json)); do "
           "$P trace $f -n 5 > $D/t.csv || exit 1; grep -qi nan $D/t.csv && exit 1; done; true",
           0, NULL, NULL);
    expect("$P trace - < examples/hoeken.json -n 2", 0, "arc,mode,input,x,y,vx", NULL);
}

TEST(json_has_the_same)
{
    FREED table *t = trace("examples/hoeken.json -n 7");
    json_auto_t *j = json_of("$P trace examples/hoeken.json -n 7 --json");
    json_t *arcs = json_object_get(j, "arcs"), *columns = json_object_get(j, "columns");
    size_t n = json_array_size(columns);
    CHECK(n >= 10);                                          /* all known columns but arc and mode */
    int row = 0;
    for (size_t a = 0; a < json_array_size(arcs); a++) {
        json_t *rows = json_object_get(json_array_get(arcs, a), "rows");
        for (size_t i = 0; i < json_array_size(rows); i++, row++)
            for (size_t c = 0; c < n; c++) {
                const char *name = json_string_value(json_array_get(columns, c));    /* of a tracer: P.x */
                int k = column(t, strncmp(name, "P.", 2) == 0 ? name + 2 : name);
                CHECK(k >= 0 && json_number_value(json_array_get(json_array_get(rows, i), c)) == t->v[row][k]);
            }
    }
    CHECK_INT(row, t->n);
}

TEST(bad_models)
{
    expect("$P trace none.json", 3, NULL, "no such file");
    expect("$P trace examples", 3, NULL, "folder");
    expect("$P trace examples/ellipse.csv", 3, NULL, "ellipse.csv: this is a target, not a linkage");
    expect("$P trace examples/hoeken.json --tracer Q", 3, NULL, "no tracer 'Q'");
    expect("$P trace examples/slider-crank.json --tracer pistn", 3, NULL, "did you mean 'piston'");
    expect("$P trace examples/hoeken.json --input-range 3", 2, NULL, "no range");
    expect("$P trace examples/hoeken.json --input-range 3:1", 2, NULL, "empty");
    expect("$P trace examples/hoeken.json --steps 0", 2, NULL, "out of range");
    expect("sed 's/\"tracers\"/\"x-tracers\"/' examples/hoeken.json > $D/m.json; $P trace $D/m.json", 0, NULL,
           "its moving pins are traced");
    expect("sed 's/\\[40, 50\\]/[40, 5O]/' examples/hoeken.json > $D/m.json; $P trace $D/m.json", 3, NULL, "m.json:9:");
    expect("$P trace examples/hoeken.json > /dev/full", 3, NULL, "no space left");
}

TEST(time_is_a_limit)
{
    expect("LW_CLOCK_STEP=0.01 $C trace examples/jansen.json -n 1000 --time 8 -o $D/cut.csv", 5, "", NULL);
    expect("tail -c 1 $D/cut.csv.partial | od -c; test $(wc -l < $D/cut.csv.partial) -gt 400 -a ! -e $D/cut.csv", 0, "\\n", NULL);
    expect("LW_CLOCK_STEP=0.01 $C trace examples/jansen.json -n 1000 --time 8 --json -o $D/cut.json; c=$?; "
           "tail -n 1 $D/cut.json.partial; exit $c", 5, "}", NULL);
}

TEST(ctrl_c_keeps_what_is_there)
{
    expect("LW_SIGNAL=2 LW_SIGNAL_AT=800 $C trace examples/jansen.json -n 1000 --time 1e9 -o $D/cut.csv", 130, "", NULL);
    expect("tail -c 1 $D/cut.csv.partial | od -c; test $(wc -l < $D/cut.csv.partial) -gt 400 -a ! -e $D/cut.csv", 0, "\\n", NULL);
}

/* Speeds have units; a plot has a panel for each unit and nothing of it on standard output. */
TEST(speeds_and_plots)
{
    const char *const same[] = { "6.283185307179586", "60rpm", "'60 rpm'", "1Hz", "'360 deg/s'", "1turn/s" };
    OWN(ran) first = { 0 };
    for (int i = 0; i < 6; i++) {
        ran r = run_with("$P trace examples/jansen.json -n 8 --speed %s --quiet | grep -v '^#'", same[i]);
        CHECK_INT(r.code, 0);
        if (i == 0)
            first = r;
        else {
            double a[4], b[4];
            for (int k = 0; k < 4; k++) {                  /* fields of the first row with rates */
                const char *p = strchr(strchr(first.out, '\n') + 1, '\n') + 1, *q = strchr(strchr(r.out, '\n') + 1, '\n') + 1;
                for (int f = 0; f < 5 + k; f++)
                    p += strcspn(p, ",") + 1, q += strcspn(q, ",") + 1;
                a[k] = strtod(p, NULL), b[k] = strtod(q, NULL);
                CHECK_NEAR(b[k], a[k], 1e-9, 1e-12);
            }
            ran_free(&r);
        }
    }
    expect("$P trace examples/jansen.json --speed 5mm/s", 2, NULL, "(the input turns)");
    expect("$P trace examples/trammel.json --speed 5rpm", 2, NULL, "(the input slides)");
    expect("$P trace examples/trammel.json --speed 0.5m/s -n 4 --quiet", 0, "mm/s", NULL);
    expect("$P trace examples/jansen.json --speed 5x", 2, NULL, "expected a number, alone or with a unit");
    expect("$P trace examples/slider-crank.json --speed 60rpm --tracer piston --plot $D/t.svg -o $D/t.csv && "
           "grep -c 'mm/s^2' $D/t.svg", 0, "1", NULL);
    expect("$P trace examples/jansen.json --plot $D/t.txt", 2, NULL, "kind of picture");
    expect("$P simulate examples/pendulum.json --to 1 --plot $D/s.svg --columns kinetic,A,P -o $D/s.csv && "
           "grep -c '>angular velocity .rad/s.<' $D/s.svg", 0, "1", NULL);
}

TEST(geometry_of_the_path)
{
    expect("$P trace examples/gallery/watt.json --geometry --cycle --quiet | grep -c 'double point of arc 1: P at 60, '", 0, "1", NULL);
    expect("$P trace examples/gallery/watt.json --geometry --cycle --quiet --json | grep -A 2 double_points", 0, "\"tracer\"", NULL);
    expect("$P trace examples/slider-crank.json --tracer piston --geometry -n 4 --mode file --quiet | tail -n 1 | grep -c ',,,,,,$'", 0,
           "1", NULL);                                                        /* it only shifts: no instant centre */
    expect("$P trace examples/hoeken.json --geometry --mode file --plot $D/g.svg --quiet && grep -c '>curvature .1/mm.<' $D/g.svg", 0,
           "1", NULL);
    /* the coupler's centre lies on the line of the crank through O (0, 0), and turns with the angular velocity it tells */
    expect("$P trace examples/hoeken.json --geometry --mode file --quiet | grep '^1,+' | awk -F, '$17 != \"\" { u = $3*3.14159265358979/180; "
           "d = $18*cos(u) - $17*sin(u); if (d*d > 1e-16*($17*$17 + $18*$18)) bad++; v = $6 + $13*($5 - $18); "
           "if (v*v > 1e-16*($6*$6 + $18*$18)) bad++ } END { print bad + 0 }'", 0, "0", NULL);
}

/* All lengths of an output are in one unit: the piston moves by simulate as by trace, in mm, mm/s and mm/s^2. */
TEST(one_system_of_units)
{
    OWN(ran) a = run("$P simulate examples/slider-crank.json --speed 60rpm -n 2 -q | grep -v '^[#t]' | head -n 1 | cut -d, -f5-10");
    OWN(ran) u = run("$P simulate examples/slider-crank.json --speed 60rpm -n 2 -q | head -n 1 | cut -d, -f5-10");
    double v[6];
    CHECK_TEXT(u.out, "mm,mm,mm/s,mm/s,mm/s^2,mm/s^2\n");
    CHECK_INT(sscanf(a.out, "%lf,%lf,%lf,%lf,%lf,%lf", v, v + 1, v + 2, v + 3, v + 4, v + 5), 6);
    /* crank 30 mm, rod 70 mm, offset 10 mm at 2 pi rad/s: x = r cos a + sqrt(l^2 - (r sin a - e)^2), checked by differences */
    double w = 6.283185307179586, a0 = atan2(24, 18), h = 1e-5, x[3];
    for (int i = 0; i < 3; i++) {
        double angle = a0 + w*h*(i - 1), y = 30*sin(angle) - 10;
        x[i] = 30*cos(angle) + sqrt(v[0]*v[0] - 36*v[0] + 324 + 196 - y*y);
    }
    CHECK_NEAR(v[0], x[1], 1e-9, 0);
    CHECK_NEAR(v[2], (x[2] - x[0])/(2*h), 1e-4, 0);
    CHECK_NEAR(v[4], (x[2] - 2*x[1] + x[0])/(h*h), 1e-2, 0);
}

/* Write a swing with more parts to $D/swing.json, and simulate it. */
static void swing(const char *tracer, const char *more, int code, const char *out, const char *err)
{
    expect_with(code, out, err, "printf '%%s' '{\"linkwright\": 1, \"links\": [{\"name\": \"ground\", \"shapes\": [{\"line\": [[0, -5], "
                "[1, -5]]}]}, {\"name\": \"arm\", \"mass\": 1, \"centre\": [0.5, 0], \"inertia\": 0.1, \"shapes\": [{\"circle\": [1, 0], "
                "\"radius\": 0.1}]}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"arm\"], \"at\": [0, 0]}], \"tracers\": "
                "[{\"name\": \"%s\", \"link\": \"arm\", \"at\": [1, 0]}]%s}' > $D/swing.json; $P simulate $D/swing.json -n 1", tracer, more);
}

/* Loads that are no numbers are named, with contacts too; columns have different names; two contacts of one pair are refused; where
 * nothing has a mass, forces of 0 have a reason. */
TEST(models_that_mislead)
{
    expect("$P simulate examples/loader.json --to 0.1 -n 2", 0, NULL, "no link has a mass and nothing pulls on one");
    expect("! $P simulate examples/pendulum.json --to 0.1 -n 2 2>&1 | grep 'no link has'", 0, NULL, NULL);
    swing("P", ", \"contacts\": [{\"links\": [\"ground\", \"arm\"]}], \"forces\": [{\"link\": \"arm\", \"torque\": \"sqrt(-1-t)\"}]", 4, NULL,
          "a force on link \"arm\" is not a number at t = 0 s");
    swing("P", ", \"states\": [{\"name\": \"z\", \"rate\": \"log(-1-t)\"}]", 4, NULL, "the rate of state \"z\" is not a number at t = 0 s");
    swing("arm", "", 0, "t,arm.x,arm.y,arm.vx,arm.vy,arm.ax,arm.ay,arm.x 2,arm.y 2,arm.turn,arm.vx 2,", "one of them is called \"arm.x 2\"");
    swing("P", ", \"contacts\": [{\"links\": [\"ground\", \"arm\"]}, {\"links\": [\"arm\", \"ground\"]}]", 3, NULL,
          "contacts[1]: \"contact 1\" is a contact of these two links already");
    expect("sed 's/\"name\": \"A\"/\"name\": \"A\", \"kind\": \"revolute\"/' $D/swing.json | $P simulate -", 3, NULL, "unknown kind \"revolute\"");
}

/* A second, coarser run tells how far the places of a run with contacts may be off: about as far as they are, where contacts are captured; it tells
 * where impacts make a motion chaotic, too, and nothing where index1 is exact.  Steps of second order that are 2.8 times as long
 * are 2.8^2 - 1 = 7 times farther off. */
TEST(coarse_run_tells_the_error)
{
    expect("for f in hook boxes walking-machine; do for k in index1 capture; do\n"
           "$P simulate examples/dynamics/$f.json --formulation $k --json > $D/$k.json || exit 1; done; python3 - $D << 'END' || exit 1; done\n"
           "import json, math, sys\n"
           "exact, run = (json.load(open(sys.argv[1] + '/' + k + '.json')) for k in ('index1', 'capture'))\n"
           "names = exact['columns']\n"
           "bodies = [names.index(n[:-5] + '.x') for n in names if n.endswith('.turn')]\n"
           "off = max(math.hypot(a[i] - b[i], a[i + 1] - b[i + 1]) for a, b in zip(exact['rows'], run['rows']) for i in bodies)\n"
           "said = run['coarse_run']['place']\n"
           "assert 1e-6 < off < 1e-4 and off/2 < said < 1e-3, (off, said)\n"
           "assert exact['coarse_run']['place'] < 1e-8\n"
           "END", 0, NULL, NULL);
    expect("! $P simulate examples/dynamics/hook.json 2>&1 | grep 'a run with a tolerance'", 0, NULL, NULL);
    expect("$P simulate examples/dynamics/boxes.json --formulation capture --time 900", 0, "# a run with a tolerance of 1.7e-08 differs by", NULL);
    expect("$P simulate examples/dynamics/boxes.json --formulation capture", 0, "# a run with a tolerance of 1.7e-08 differs by", "m/s count as rest");
    /* a ball that bounces inside a wheel: each impact multiplies an error, and after 20 s its place is not known */
    expect("printf '%s' '{\"linkwright\": 1, \"gravity\": [0, -9.81], \"links\": [{\"name\": \"ground\", \"shapes\": [{\"circle\": [0, 0], \"radius\": 1}, "
           "{\"circle\": [3, 0], \"radius\": 1}, {\"polygon\": [[-2, 0], [-1, 0], [-1, 4], [-2, 4]]}, {\"polygon\": [[4, 0], [5, 0], [5, 4], [4, 4]]}, "
           "{\"polygon\": [[-2, -2], [5, -2], [5, 0], [-2, 0]]}]}, {\"name\": \"ball\", \"mass\": 1, \"centre\": [0.6, 3], \"inertia\": 0.01, \"shapes\": "
           "[{\"circle\": [0.6, 3], \"radius\": 0.1}]}], \"joints\": [{\"name\": \"F\", \"kind\": \"n\", \"links\": [\"ground\", \"ball\"]}], \"contacts\": "
           "[{\"links\": [\"ground\", \"ball\"], \"restitution\": 1}]}' > $D/pinball.json; $P simulate $D/pinball.json --to 20",
           4, NULL, "a run with a tolerance of 1e-08 differs by up to");
    /* the same with a compliant rim, whose impacts are no events; the exit code is the same without notes */
    expect("sed 's/\"restitution\": 1}/\"stiffness\": 1e6}/' $D/pinball.json | $P simulate - --to 20 -q",
           4, NULL, "the rows are not reliable: a run with a tolerance of 1e-08 differs by up to");
}

/* A four-bar drawn with rounded numbers beside a change point: trace and simulate say which way it goes and why; for a
 * parallelogram, a kite, both signs of the misfit.  Exact ones and those far from it say nothing of the kind. */
TEST(rounded_change_points_are_named)
{
    static const struct { double crank, coupler, rocker, frame; bool near; } bar[] = {
        { 1, 4, 1, 4, false }, { 1, 4.0003, 1, 4, true }, { 1, 3.9997, 1, 4, true }, { 1.00002, 4, 1, 4, true }, { 2, 2.001, 4, 4, true },
        { 1, 4.4, 2, 4, false } };
    for (size_t k = 0; k < sizeof bar/sizeof *bar; k++) {
        double a = 1, x = bar[k].crank*cos(a), y = bar[k].crank*sin(a), dx = bar[k].frame - x, d = hypot(dx, y);
        double along = (d*d + bar[k].coupler*bar[k].coupler - bar[k].rocker*bar[k].rocker)/(2*d);
        double across = sqrt(bar[k].coupler*bar[k].coupler - along*along);
        char path[400];
        run_prepare();
        snprintf(path, sizeof path, "%s/rounded.json", getenv("D"));
        FILE *f = fopen(path, "w");
        fprintf(f, "{\"linkwright\": 1, \"links\": [\"ground\", \"a\", {\"name\": \"b\", \"mass\": 1, \"centre\": [1, 1], \"inertia\": 1}, \"c\"], \"joints\": ["
                "{\"name\": \"A\", \"links\": [\"ground\", \"a\"], \"at\": [0, 0]}, {\"name\": \"B\", \"links\": [\"a\", \"b\"], \"at\": [%.17g, %.17g]}, "
                "{\"name\": \"C\", \"links\": [\"b\", \"c\"], \"at\": [%.17g, %.17g]}, {\"name\": \"D\", \"links\": [\"ground\", \"c\"], \"at\": [%.17g, 0]}], "
                "\"tracers\": [{\"name\": \"P\", \"link\": \"b\", \"at\": [1, 1]}], \"input\": {\"joint\": \"A\", \"motion\": \"1 + 0.1*t\"}}",
                x, y, x + (along*dx + across*y)/d, y + (across*dx - along*y)/d, bar[k].frame);
        fclose(f);
        for (int simulate = 0; simulate < 2; simulate++) {
            OWN(ran) r = run(simulate ? "$P simulate $D/rounded.json -n 2" : "$P trace $D/rounded.json -n 4");
            CHECK_INT(r.code, 0);
            CHECK((strstr(r.err, "without passing it") != NULL) == bar[k].near);
        }
    }
}

/* Targets from CSV: what is read, and that every fault names its place, the reason and the remedy. */
#include "base/file.h"
#include "base/vec2.h"
#include "optimise/task/read_file.h"
#include "optimise/task/target_tour.h"
#include "tests/check.h"

static lw_status read_with(const char *text, size_t size, const lw_target_options *o, lw_target *t, lw_error *e)
{
    FREED char *copy = malloc(size + 1);                    /* exact size, no terminator: a step beyond it shows */
    memcpy(copy, text, size);
    memset(e, 0, sizeof *e);
    lw_status s = lw_target_read(copy, size, "p.csv", o, t, e);
    return s;
}

static lw_status read(const char *text, lw_target *t, lw_error *e)
{
    return read_with(text, strlen(text), NULL, t, e);
}

static void check_reads(const char *text, size_t n)
{
    OWN(lw_target) t = { 0 };
    CHECK_SILENT(read(text, &t, &check_error));
    CHECK_INT(t.n, n);
}

/* ---- files ------------------------------------------------------------------------------------- */

static lw_target from_file(const char *path)
{
    FREED char *text = NULL;
    size_t size = 0;
    lw_target t = { .n = 0 };
    lw_error e = { .text = "" };
    CHECK_INT(lw_file_read(path, &text, &size, &e), LW_OK);
    CHECK_INT(lw_target_read(text, size, path, NULL, &t, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    return t;
}

TEST(published_files)
{
    static const struct { const char *path; size_t n; bool x, theta, angle, closed; } files[] = {
        { "catalogues/data/paths/line6.csv", 6, 1, 0, 0, 0 },
        { "catalogues/data/paths/arc5.csv", 5, 1, 0, 1, 0 },
        { "catalogues/data/paths/arch6.csv", 6, 1, 0, 1, 0 },
        { "catalogues/data/paths/closed18.csv", 18, 1, 0, 1, 1 },
        { "catalogues/data/paths/closed18free.csv", 18, 1, 0, 0, 1 },
        { "catalogues/data/paths/ellipse10.csv", 10, 1, 0, 0, 1 },
        { "tests/data/tasks/s03-slidercrank-path36.csv", 36, 1, 1, 1, 1 },
        { "tests/data/tasks/f01-log.csv", 61, 0, 1, 1, 0 },
        { "tests/data/tasks/f02-x15.csv", 61, 0, 1, 1, 0 },
        { "tests/data/tasks/f03-sin.csv", 61, 0, 1, 1, 0 },
        { "tests/data/tasks/f04-square.csv", 61, 0, 1, 1, 0 },
    };
    for (size_t i = 0; i < sizeof files/sizeof *files; i++) {
        OWN(lw_target) t = from_file(files[i].path);
        CHECK_INT(t.n, files[i].n);
        CHECK(!t.x == !files[i].x && !t.y == !files[i].x && !t.theta == !files[i].theta);
        CHECK(!t.angle == !files[i].angle && t.closed == files[i].closed);
    }
}

/* theta_in_rad is the input, angle the tool: the coupler's direction oscillates about theta0 = 0.35. */
TEST(published_names_of_columns)
{
    OWN(lw_target) t = from_file("tests/data/tasks/s03-slidercrank-path36.csv");
    CHECK_NEAR(t.angle[1], 10*LW_PI/180, 0, 1e-14);
    CHECK_NEAR(t.theta[0], 0.495675987553583, 0, 0);
    CHECK_NEAR(t.angle[35], 350*LW_PI/180, 0, 1e-14);
    lw_target_free(&t);
    t = from_file("tests/data/tasks/f01-log.csv");
    CHECK_NEAR(t.angle[60], LW_PI/3, 0, 1e-10);
    CHECK_NEAR(t.theta[60], LW_PI/2, 0, 1e-10);
}

TEST(further_points)
{
    OWN(lw_target) t = { 0 };
    CHECK_OK(read("# closed: yes\n# units: mm "
                  "deg\nx,y2,x2,y,theta3,weight3,angle\n0,5,100,0,90,1,0\n3,5,103,0,180,2,10\n3,9,103,4,0,0,20\n",
                  &t, &check_error));
    CHECK_INT(t.n_also, 2);
    CHECK(t.also[0].x && t.also[0].y && !t.also[0].theta && t.also[0].weight == t.weight);
    CHECK(!t.also[1].x && !t.also[1].y && t.also[1].theta && t.also[1].weight != t.weight);
    CHECK_NEAR(t.also[0].x[1], 0.103, 0, 1e-15);
    CHECK_NEAR(t.also[0].y[2], 0.009, 0, 1e-15);
    CHECK_NEAR(t.also[1].theta[1], LW_PI, 0, 1e-15);
    CHECK_NEAR(t.also[1].weight[1], 2, 0, 0);
    CHECK(t.closed);
    CHECK_NEAR(t.also[0].length, 0.012, 0, 1e-14);
    CHECK_NEAR(t.size, 0.005, 0, 1e-14);
    CHECK_NEAR(t.extent, hypot(0.103, 0.009), 0, 1e-14);
    lw_target_free(&t);
    CHECK_OK(read("angle,theta,theta2\n0,1,2\n1,2,3\n", &t, &check_error));
    CHECK(t.n_also == 1 && !t.x && t.also[0].theta[1] == 3);
    lw_target_free(&t);
    CHECK_OK(read("x1,y1,x2,y2\n0,1,2,3\n1,2,3,4\n", &t, &check_error));        /* the first may bear its number */
    CHECK(t.n_also == 1 && t.y[1] == 2);
}

/* Parts with a path, a path and weights, an output angle. */
TEST(parts_are_joined_row_by_row)
{
    lw_target part[3], t;
    lw_error e = { .text = "" };
    const lw_target *p[5] = { &part[0], &part[1], &part[2], &part[0], &part[0] };
    CHECK_INT(read("# units: mm\n# closed: no\nx,y\n0,1\n1,2\n2,2\n", &part[0], &e), LW_OK);
    CHECK_INT(read("x_mm,y,weight\n5,6,2\n6,7,1\n7,7,0\n", &part[1], &e), LW_OK);
    CHECK_INT(read("angle_deg,theta\n0,90\n10,100\n20,110\n", &part[2], &e), LW_OK);
    CHECK_INT(lw_target_join(p, 3, &t, &e), LW_OK);
    CHECK(t.n == 3 && t.n_also == 2 && !t.closed && t.line[2] == 6);
    CHECK_NEAR(t.also[0].x[1], 0.006, 0, 1e-15);
    CHECK_NEAR(t.also[0].weight[0], 2, 0, 0);
    CHECK_NEAR(t.weight[0], 1, 0, 0);
    CHECK_NEAR(t.angle[1], LW_PI/18, 0, 1e-15);               /* one part's timing is that of all */
    CHECK_NEAR(t.also[1].theta[2], 110*LW_PI/180, 0, 1e-15);
    CHECK(!t.also[1].x);
    lw_target_free(&t);
    CHECK_INT(lw_target_join(p, 5, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "4 points at most");
    const lw_target *turned[] = { &part[2], &part[0] };
    CHECK_INT(lw_target_join(turned, 2, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "put those with a path first");
    lw_target_free(&part[1]);
    CHECK_INT(read("x,y\n5,6\n6,7\n", &part[1], &e), LW_OK);
    CHECK_INT(lw_target_join(p, 2, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "tracer 2 has 2 stations, the first one 3");
    lw_target_free(&part[1]);
    CHECK_INT(read("x,y,angle_deg\n5,6,0\n6,7,10\n7,7,21\n", &part[1], &e), LW_OK);
    const lw_target *timed[] = { &part[1], &part[2] };
    CHECK_INT(lw_target_join(timed, 2, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "station 3 has the input angle 21 for the first tracer and 20 for tracer 2");
    lw_target_free(&part[1]);
    CHECK_INT(read("x,y,x2,y2\n5,6,0,0\n6,7,1,0\n7,7,2,1\n", &part[1], &e), LW_OK);
    CHECK_INT(lw_target_join(p, 2, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "tracer 2 has columns of further points itself");
    for (int i = 0; i < 3; i++)
        lw_target_free(&part[i]);
}

TEST(length_and_size)
{
    OWN(lw_target) t = { 0 };
    CHECK_OK(read("x,y\n0,0\n3,0\n3,2\n3,4\n", &t, &check_error));
    CHECK(!t.closed);                                         /* gap 5 > 1.35 * 3 */
    lw_target_free(&t);
    CHECK_OK(read("# closed: yes\nx,y\n0,0\n3,0\n3,4\n", &t, &check_error));
    CHECK_NEAR(t.length, 12, 0, 0);
    CHECK_NEAR(t.size, 5, 0, 0);
    lw_target_free(&t);
    CHECK_OK(read("# closed: no\nx,y\n0,0\n3,0\n3,4\n", &t, &check_error));
    CHECK(!t.closed);
    CHECK_NEAR(t.length, 7, 0, 0);
    lw_target_free(&t);
    t = from_file("catalogues/data/paths/line6.csv");
    CHECK_NEAR(t.length, 25, 0, 0);
    CHECK_INT(t.line[0], 7);
    CHECK_INT(t.line[5], 12);
}

/* ---- forms ------------------------------------------------------------------------------------- */

/* docs/notation.md, "Target"; there every line is set in by four blanks. */
/* The size of a target, which limits are counted in, does not depend on how it is turned or where it lies. */
TEST(size_of_a_turned_target)
{
    const double x[] = { 0, 4, 4, 0, 1 }, y[] = { 0, 0, 3, 3, 1 }, far_x[] = { 4, 4, 12, 4, 4 }, far_y[] = { 3, 3, 6, 3, 3 };
    for (int k = 0; k < 12; k++) {
        const double c = cos(0.29*k), s = sin(0.29*k);
        OWN(lw_target) t = { 0 };
        double px[5], py[5], qx[5], qy[5];
        for (int i = 0; i < 5; i++) {
            px[i] = c*x[i] - s*y[i] - 70*k;
            py[i] = s*x[i] + c*y[i] + 30*k;
            qx[i] = c*far_x[i] - s*far_y[i] - 70*k;
            qy[i] = s*far_x[i] + c*far_y[i] + 30*k;
        }
        const lw_also also = { .x = qx, .y = qy };
        CHECK_OK(lw_target_make_all(5, px, py, NULL, NULL, NULL, &also, 1, 0, &t, &check_error));
        CHECK_NEAR(t.size, 5, 1e-9, 0);
        CHECK_NEAR(t.extent, hypot(12, 6), 1e-9, 0);
    }
}

TEST(the_example_of_the_manual)
{
    static const char example[] = "    # units: mm deg\n    # closed: no\n    x,y,theta,angle,weight\n"
                                  "    20,10,0,30,1\n    17.66,15.142,5,60,1\n    11.736,17.878,12,90,0.5\n";
    char *manual = NULL;
    size_t size;
    OWN(lw_target) t = { 0 };
    CHECK_INT(lw_file_read("docs/notation.md", &manual, &size, NULL), LW_OK);
    CHECK_HAS(manual, example);
    free(manual);
    CHECK_OK(read(example, &t, &check_error));
    CHECK(t.n == 3 && !t.closed && t.weight[2] == 0.5);
    CHECK_NEAR(t.y[1], 0.015142, 0, 1e-15);
    CHECK_NEAR(t.theta[2], 12*LW_PI/180, 0, 1e-15);
    CHECK_NEAR(t.angle[0], LW_PI/6, 0, 1e-15);
}

TEST(separators_and_line_ends)
{
    check_reads("x,y\n1,2\n3,4\n", 2);
    check_reads("x,y\n1,2\n3,4", 2);
    check_reads("x,y\r\n1,2\r\n3,4\r\n", 2);
    check_reads("x,y\r1,2\r3,4\r", 2);
    check_reads("\xef\xbb\xbfx,y\n1,2\n", 1);
    check_reads("x;y\n1;2\n", 1);
    check_reads("x\ty\n1\t2\n", 1);
    check_reads("x y\n 1   2 \n\t3\t4\n", 2);
    check_reads("\"x\" , \"y\"\n\" 1\" ,\"2\"\n", 1);
    check_reads("\n\n# a comment\n  # another\nX,Y\n\n1,2 # and behind a line\n\n", 1);
}

TEST(units_by_comment_suffix_and_option)
{
    static const struct { const char *text; double x, angle; } cases[] = {
        { "# units: mm deg\nx,y,angle\n1,2,90\n", 1e-3, LW_PI/2 },
        { "# Units : deg, mm\nx,y,angle\n1,2,90\n", 1e-3, LW_PI/2 },
        { "x_mm,y_mm,angle_deg\n1,2,90\n", 1e-3, LW_PI/2 },
        { "x_mm,y,angle\n1,2,90\n", 1e-3, 90 },
        { "x_in,y,theta_in_deg\n1,2,90\n", 0.0254, LW_PI/2 },
        { "x,y,theta_in\n1,2,3\n", 1, 3 },
        { "x,y,angle_turn\n1,2,0.25\n", 1, LW_PI/2 },
        { "x,y,t\n1,2,0.25\n", 1, LW_PI/2 },
        { "# units: mm\nx_mm,y,t\n1,2,0.5\n", 1e-3, LW_PI },
        { "x;y;angle;weight\n\nmm;[mm];\xc2\xb0;-\n1;2;90;1\n", 1e-3, LW_PI/2 },     /* a line of units below the names */
    };
    for (size_t i = 0; i < sizeof cases/sizeof *cases; i++) {
        OWN(lw_target) t = { 0 };
        CHECK_SILENT(read(cases[i].text, &t, &check_error));
        CHECK_NEAR(t.x[0], cases[i].x, 0, 1e-15);
        CHECK_NEAR(t.y[0], 2*cases[i].x, 0, 1e-15);
        CHECK_NEAR(t.angle[0], cases[i].angle, 0, 1e-15);
    }
}

TEST(options_overrule_comments)
{
    static const char text[] = "# units: mm deg\n# closed: yes\nx,y,angle\n1,2,3\n4,5,6\n";
    const lw_target_options o = { .closed = 0, .length_unit = "cm", .angle_unit = "rad" };
    lw_target t;
    lw_error e;
    CHECK_INT(read_with(text, strlen(text), &o, &t, &e), LW_OK);
    CHECK_NEAR(t.x[0], 0.01, 0, 0);
    CHECK_NEAR(t.angle[1], 6, 0, 0);
    CHECK(!t.closed);
    CHECK_TEXT(t.units.length, "cm");
    lw_target_free(&t);
    CHECK_INT(read_with("x_mm,y\n1,2\n", 11, &o, &t, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "units are mixed");
    CHECK_HAS(e.text, "the command line said cm");
    CHECK_INT(read_with("x,y\n1,2\n", 8, &(lw_target_options){ .closed = -1, .length_unit = "mile" }, &t, &e),
              LW_E_ARG);
    CHECK_HAS(e.text, "\"mile\"");
    CHECK_FAILS(read_with("x,y\n1,2\n", 8, &(lw_target_options){ .closed = -1, .angle_unit = "grad" }, &t, &check_error), LW_E_ARG, "\"grad\"");
}

TEST(columns_in_any_order)
{
    OWN(lw_target) t = { 0 };
    CHECK_OK(read("weight,theta,y,angle,x\n0.5,1,2,3,4\n0,1,2,4,4\n", &t, &check_error));
    CHECK(t.weight[0] == 0.5 && t.theta[0] == 1 && t.y[0] == 2 && t.angle[0] == 3 && t.x[0] == 4);
    CHECK(t.weight[1] == 0);
    lw_target_free(&t);
    CHECK_OK(read("x,y\n1,2\n", &t, &check_error));
    CHECK(t.weight[0] == 1);
    CHECK_TEXT(t.units.length, "");
}

/* A file that does not say whether its path or function is closed: the points, the angles of a body and those of the input have to come back. */
TEST(closed_by_guess)
{
    static const struct { const char *rows; bool closed; } known[] = {
        { "x,y\n0,0\n3,0\n3,4\n", false },                                             /* three places on a stroke        */
        { "x,y\n0,0\n3,0\n3,4\n0,4\n", true },
        { "# units: mm deg\nx,y,theta\n0,0,0\n-14,22,45\n-6,38,95\n", false },           /* a hinge of a door               */
        { "# units: deg\nx,y,theta\n0,0,0\n3,0,45\n3,3,90\n0,3,135\n", false },          /* a box that is turned over        */
        { "# units: mm deg\nx,y,theta\n0,0,0\n0,-120,0\n-250,-380,-60\n-320,-420,-90\n", false },      /* a folding table  */
        { "# units: deg\nx,y,theta\n0,0,0\n3,0,5\n3,3,9\n0,3,4\n", true },
        { "# units: deg\nx,y,theta\n0,0,350\n3,0,80\n3,3,170\n0,3,260\n", true },        /* a planet: the body turns once    */
        { "# units: deg\nx,y,angle\n0,0,0\n3,0,10\n3,3,20\n0,3,30\n", false },
        { "# units: deg\nx,y,angle\n0,0,300\n3,0,30\n3,3,120\n0,3,210\n", true },
        { "# units: deg\nx,y,angle\n0,0,240\n3,0,120\n3,3,0\n", true },
        { "# units: deg\nx,y,angle\n0,0,0\n3,0,120\n3,3,240\n0,0,360\n", true },
        { "# units: deg\nangle,theta\n0,0\n90,20\n180,30\n270,10\n360,0\n", true },       /* a function over a whole turn      */
        { "# units: deg\nangle,theta\n0,0\n120,120\n240,250\n", true },                    /* whose output may turn, too        */
        { "# units: deg\nangle,theta\n0,0\n90,20\n180,40\n270,60\n350,80\n", false },
        { "# units: deg\nangle,theta\n0,0\n30,20\n60,30\n90,0\n", false },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        OWN(lw_target) t = { 0 };
        lw_error e = { .text = "" };
        CHECK_INT(read(known[i].rows, &t, &e), LW_OK);
        CHECK(t.closed == known[i].closed || (printf("%s", known[i].rows), false));
    }
}

TEST(few_stations_and_repeated_points)
{
    check_reads("x,y\n1,2\n", 1);
    check_reads("x,y\n1,2\n1,2\n", 2);
    check_reads("x,y\n0,0\n0,0\n0,0\n", 3);
    check_reads("x,y\n-0,1e-9\n1e9,1E9\n", 2);
    OWN(lw_target) t = { 0 };
    CHECK_OK(read("x,y\n5,5\n5,5\n5,5\n", &t, &check_error));
    CHECK(!t.closed && t.size == 0 && t.length == 0);
}

/* A closed path that returns to its first station has one station less, with the same length; rows that belong to input angles, or
 * to another place or angle, all stay. */
TEST(the_first_station_repeated_at_the_end)
{
    static const struct { const char *text; size_t n; bool said; } rows[] = {
        { "x_mm,y_mm\n0,0\n2,0\n2,1\n0,1\n0,0\n", 4, true },
        { "x_mm,y_mm\n0,0\n2,0\n2,1\n0,0\n", 3, true },
        { "x_mm,y_mm\n0,0\n2,0\n0,0\n", 3, false },
        { "# closed: no\nx_mm,y_mm\n0,0\n2,0\n2,1\n0,1\n0,0\n", 5, false },
        { "x_mm,y_mm\n0,0\n2,0\n2,1\n0,1\n0,0.001\n", 5, false },
        { "x_mm,y_mm,theta_deg\n0,0,0\n2,0,90\n2,1,180\n0,1,270\n0,0,360\n", 4, true },
        { "x_mm,y_mm,theta_deg\n0,0,0\n2,0,90\n2,1,180\n0,1,270\n0,0,350\n", 5, false },
        { "x_mm,y_mm,angle_deg\n0,0,0\n2,0,90\n2,1,180\n0,1,270\n0,0,360\n", 5, false },
        { "x_mm,y_mm,x2,y2\n0,0,5,5\n2,0,6,5\n2,1,7,5\n0,1,6,5\n0,0,5,5\n", 4, true },
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        OWN(lw_target) t = { 0 }, whole = { 0 };
        CHECK_OK(lw_target_read_text(rows[i].text, strlen(rows[i].text), "path.csv", NULL, &t, &check_error));
        CHECK_OK(lw_target_read(rows[i].text, strlen(rows[i].text), "path.csv", NULL, &whole, &check_error));
        CHECK_INT(t.n, rows[i].n);
        CHECK_INT(t.closed, whole.closed);
        CHECK_NEAR(t.length, whole.length, 0, 0);
        CHECK_INT(strstr(t.note, "repeats the first station") != NULL, rows[i].said);
    }
}

/* ---- angles ------------------------------------------------------------------------------------ */

static void check_angles(const char *text, size_t n, const double *want)
{
    OWN(lw_target) t = { 0 };
    CHECK_SILENT(read(text, &t, &check_error));
    for (size_t i = 0; i < n && i < t.n; i++)
        CHECK_NEAR(t.angle[i]*180/LW_PI, want[i], 1e-12, 1e-15);
}

TEST(cyclic_order_is_order)
{
    check_angles("x,y,angle_deg\n0,0,0\n1,0,10\n2,0,350\n", 3, (double[]){ 0, 10, 350 });
    check_angles("x,y,angle_deg\n0,0,30\n1,0,20\n2,0,-200\n", 3, (double[]){ 30, 20, -200 });
    check_angles("x,y,angle_deg\n0,0,300\n1,0,340\n2,0,20\n3,0,60\n", 4, (double[]){ 300, 340, 380, 420 });
    check_angles("x,y,angle_deg\n0,0,20\n1,0,10\n2,0,350\n3,0,300\n", 4, (double[]){ 20, 10, -10, -60 });
    check_angles("x,y,angle_deg\n0,0,0\n1,0,180\n0,0,360\n", 3, (double[]){ 0, 180, 360 });
    check_angles("x,y,angle_deg\n0,0,0\n1,0,180\n0,0,0\n", 3, (double[]){ 0, 180, 360 });
    check_angles("x,y,angle_deg\n0,0,5\n0,0,5\n1,0,7\n", 3, (double[]){ 5, 5, 7 });
    check_angles("x,y,angle_deg\n0,0,5\n", 1, (double[]){ 5 });
    check_angles("x,y,angle_deg\n0,0,0\n1,0,200\n2,0,400\n3,0,720\n", 4, (double[]){ 0, 200, 400, 720 });
    check_angles("x,y,t\n0,0,1.5\n1,0,0.7\n2,0,0\n", 3, (double[]){ 540, 252, 0 });
    check_angles("angle_deg,theta_deg\n0,0\n350,20\n", 2, (double[]){ 0, 350 });
}

static double whole_turns(double a) { return floor(a/360)*360; }

/* Any sequence that a slow search finds to be cyclic within one turn, or to go on throughout, is read, and no other. */
TEST(order_against_brute_force)
{
    lw_rng r = check_rng(0);
    for (int trial = 0; trial < 5000; trial++) {
        int n = 2 + (int)(lw_rng_bits(&r)%5), ok = 0;
        double a[8], x[8], y[8], rad[8];
        for (int i = 0; i < n; i++) {
            a[i] = 30*(double)(lw_rng_bits(&r)%(trial%2 ? 13 : 40));    /* 0, 30, ... 360 or 1170 */
            rad[i] = a[i]*LW_PI/180;
            x[i] = i;
            y[i] = 0;
        }
        double least = a[0], most = a[0];
        for (int i = 1; i < n; i++) {
            least = fmin(least, a[i]);
            most = fmax(most, a[i]);
        }
        bool once = most - least <= 360;
        for (int sense = -1; sense <= 1; sense += 2)          /* wrap behind place k, n: nowhere */
            for (int k = 1; k <= n; k++) {
                int good = 1;
                double b[8];
                for (int i = 0; i < n; i++)
                    b[i] = sense*a[i] + (i >= k ? 360 : 0);
                for (int i = 1; i < n; i++)
                    good &= b[i] >= b[i-1];
                ok |= good && (k == n || b[n-1] - b[0] <= 360);
            }
        for (int i = 0; i < n; i++)                           /* every point is another one */
            for (int j = 0; j < i; j++)
                ok &= once ? a[i] - whole_turns(a[i]) != a[j] - whole_turns(a[j]) : a[i] != a[j];
        OWN(lw_target) t = { 0 };
        lw_error e = { .text = "" };
        lw_status s = lw_target_make((size_t)n, x, y, NULL, rad, NULL, -1, &t, &e);
        CHECK_INT(s, ok ? LW_OK : LW_E_ARG);
        CHECK(ok || strstr(e.text, "station") || strstr(e.text, "turn"));
        for (int i = 1; ok && i < n; i++)
            CHECK((t.angle[i] - t.angle[i-1])*(t.angle[n-1] - t.angle[0]) >= 0);
    }
}

/* ---- tables as programs write them ----------------------------------------------------------------------------- */

/* The same three stations each time: (12.5, -3) (7, 4.25) (0, 1) mm. */
TEST(tables_of_programs)
{
    static const struct { const char *text; size_t size; } rows[] = {
#define ROW(text) { text, sizeof (text) - 1 }
        ROW("x_mm,y_mm\n12.5,-3\n7,4.25\n0,1\n"),
        ROW("\xef\xbb\xbfX [mm];Y [mm]\r\n12,5;-3\r\n7;4,25\r\n0;1\r\n"),                /* Excel, German */
        ROW("sep=;\r\nx (mm);y (mm);\r\n12,5;-3;\r\n7;4,25;\r\n0;1;\r\n;;\r\n"),       /* Excel, empty column and row */
        ROW("x/mm\ty/mm\n12,5\t-3\n7\t4,25\n0\t1\n"),
        ROW("x [mm] y [mm]\n12.5 -3\n7 4.25\n0 1\n"),
        ROW("x mm,y mm\n12.5,-3\n7,4.25\n0,1\n"),
        ROW("\"x [mm]\",\"y [mm]\"\n\"12,5\",\"-3\"\n\"7\",\"4,25\"\n\"0\",\"1\"\n"),      /* LibreOffice, all quoted */
        ROW("x[mm];y[mm]\n+1,25E+01;-3,0E+00\n7;4,25\n0;1\n"),
        ROW("x [um];y [um]\n12 500,0;-3\xe2\x80\xaf""000\n7'000;4\xc2\xa0""250\n0;1\xe2\x80\x99""000\n"),     /* separators of thousands */
        ROW("x_mm;y_mm\n12.5;\xe2\x88\x92""3\n7;4.25\n0;1\n"),                           /* U+2212 */
        ROW("# units: mm\n12.5,-3\n7,4.25\n0,1\n"),                                       /* no header */
        ROW("# units: mm\n12,5;-3\n7;4,25\n0;1\n"),
        ROW("# units: mm\n12,5\t-3\n7\t4,25\n0\t1\n"),
        ROW("# units: mm\n12,5 -3\n7 4,25\n0 1\n"),
        ROW("x [millimetre],y\n12.5,-3\n7,4.25\n0,1\n"),
        ROW("\xff\xfex\0_\0m\0m\0\t\0y\0\n\0" "1\0" "2\0,\0" "5\0\t\0-\0" "3\0\n\0" "7\0\t\0" "4\0,\0" "2\0" "5\0\n\0" "0\0\t\0" "1\0\n\0"),
        ROW("\xfe\xff\0x\0_\0m\0m\0,\0y\0\n\0" "1\0" "2\0.\0" "5\0,\0-\0" "3\0\n\0" "7\0,\0" "4\0.\0" "2\0" "5\0\n\0" "0\0,\0" "1\0\n")
#undef ROW
    };
    static const double want[][2] = { { 12.5, -3 }, { 7, 4.25 }, { 0, 1 } };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        OWN(lw_target) t = { 0 };
        lw_error e = { .text = "" };
        CHECK_INT(read_with(rows[i].text, rows[i].size, NULL, &t, &e), LW_OK);
        CHECK_TEXT(e.text, "");
        CHECK_INT(t.n, 3);
        for (size_t k = 0; k < t.n; k++) {
            CHECK_NEAR(t.x[k], 1e-3*want[k][0], 1e-17, 0);
            CHECK_NEAR(t.y[k], 1e-3*want[k][1], 1e-17, 0);
        }
    }
}

TEST(angles_of_programs)
{
    static const char *const rows[] = {
        "x [mm];y [mm];theta [deg];angle [deg]\n1;2;90;0\n3;4;180;36,5\n5;5;0;90\n",
        "x (mm),y (mm),theta (\xc2\xb0),angle (\xb0)\n1,2,90,0\n3,4,180,36.5\n5,5,0,90\n",
        "x [mm] y [mm] theta [degrees] t\n1 2 90 0\n3 4 180 .101388888888888888\n5 5 0 .25\n"
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        OWN(lw_target) t = { 0 };
        lw_error e = { .text = "" };
        CHECK_INT(read_with(rows[i], strlen(rows[i]), NULL, &t, &e), LW_OK);
        CHECK_TEXT(e.text, "");
        if (t.n != 3)
            continue;
        CHECK_NEAR(t.theta[1], LW_PI, 1e-15, 0);
        CHECK_NEAR(t.angle[1], 36.5*LW_PI/180, 1e-15, 0);
    }
}

TEST(stations_of_a_table)
{
    static const char text[] = "x_mm,y_mm\n0,0\n30,0\n30,10\n0,10\n";
    lw_target_options o = { .closed = 1, .stations = 40 };
    lw_target t;
    lw_error e = { .text = "" };
    CHECK_INT(read_with(text, sizeof text - 1, &o, &t, &e), LW_OK);
    CHECK_INT(t.n, 40);
    CHECK_NEAR(t.length, 0.08, 1e-12, 0);
    CHECK_INT(t.line[39], 5);
    CHECK_HAS(t.note, "40 stations on the path through the 4 points");
    lw_target_free(&t);
    o = (lw_target_options){ .closed = -1, .smooth = 0.5 };
    static const char noisy[] = "x_mm,y_mm\n0,0\n10,0.4\n20,-.4\n30,.4\n40,-.3\n50,.3\n60,-.4\n";
    CHECK_INT(read_with(noisy, sizeof noisy - 1, &o, &t, &e), LW_OK);
    for (size_t i = 0; i < t.n; i++)
        CHECK(fabs(t.y[i]) < 2e-4);
    CHECK_HAS(t.note, "smoothed: the path lies 0.3");
    CHECK_NEAR(t.noise, 0.35e-3, 0.05e-3, 0);
    lw_target_free(&t);
    static const char motion[] = "x,y,theta\n0,0,0\n1,0,0\n";
    o.stations = 5;
    CHECK_INT(read_with(motion, sizeof motion - 1, &o, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "only a path of x and y");
}

enum { SHUFFLED = 48 };
typedef lw_vec2 curve(double u);
static lw_vec2 egg(double u)   { return lw_v2(40*cos(2*LW_PI*u), (22 + 6*cos(2*LW_PI*u))*sin(2*LW_PI*u)); }
static lw_vec2 eight(double u) { return lw_v2(40*sin(2*LW_PI*u), 25*sin(4*LW_PI*u)); }
static lw_vec2 wave(double u)  { return lw_v2(120*u, 25*sin(6*u)); }
static lw_vec2 line(double u)  { return lw_v2(80*u, 30*u); }

/* CSV text of the points of a curve, drawn by lot if rng is not NULL; their weights are the numbers of the points. */
static size_t write_points(curve *c, bool closed, lw_rng *rng, char *text, size_t size)
{
    size_t used = (size_t)snprintf(text, size, "x [mm],y [mm],weight\n"), order[SHUFFLED];
    for (size_t i = 0; i < SHUFFLED; i++)
        order[i] = i;
    for (size_t i = SHUFFLED - 1; i > 0 && rng; i--) {
        size_t k = (size_t)(lw_rng_uniform(rng)*(double)(i + 1)), one = order[i];
        order[i] = order[k];
        order[k] = one;
    }
    for (size_t i = 0; i < SHUFFLED; i++) {
        lw_vec2 p = c((double)order[i]/(SHUFFLED - !closed));
        used += (size_t)snprintf(text + used, size - used, "%.9f,%.9f,%zu\n", p.x, p.y, order[i] + 1);
    }
    return used;
}

/* Points in no order are put in that of a tour no longer than their curve, weights and lines with them; where it does not cross itself, it is
 * their curve.  Points in order are left as they are. */
TEST(points_in_no_order)
{
    static const struct { curve *at; bool closed, crosses; } row[] = { { egg, true, false }, { eight, true, true }, { wave, false, false },
                                                                      { line, false, false } };
    lw_rng rng = check_rng(31);
    char text[4096];
    for (size_t trial = 0; trial < 5*sizeof row/sizeof *row; trial++) {
        const size_t kind = trial % (sizeof row/sizeof *row);
        OWN(lw_target) in_order = { 0 }, t = { 0 }, left = { 0 };
        lw_error e = { .text = "" };
        size_t n = write_points(row[kind].at, row[kind].closed, NULL, text, sizeof text);
        CHECK_INT(read_with(text, n, NULL, &in_order, &e), LW_OK);
        CHECK_INT(lw_target_put_in_order(&in_order, &e), LW_OK);
        CHECK_TEXT(in_order.note, "");
        n = write_points(row[kind].at, row[kind].closed, &rng, text, sizeof text);
        CHECK_INT(read_with(text, n, NULL, &t, &e), LW_OK);
        CHECK_HAS(t.note, "the points jump to and fro");
        CHECK_INT(lw_target_put_in_order(&t, &e), LW_OK);
        CHECK(t.closed == row[kind].closed && in_order.closed == t.closed);
        CHECK(t.length <= in_order.length*(1 + 1e-12));
        CHECK_INT(read_with(text, n, NULL, &left, &e), LW_OK);
        for (size_t i = 0; i < SHUFFLED && t.n == SHUFFLED && left.n == SHUFFLED; i++) {
            size_t next = (i + 1) % SHUFFLED, of = (size_t)t.line[i] - 2;
            CHECK(left.line[i] == (long)i + 2 && left.x[of] == t.x[i] && left.y[of] == t.y[i] && left.weight[of] == t.weight[i]);
            double step = fabs(t.weight[next] - t.weight[i]);
            CHECK(row[kind].crosses || step == 1 || (step == SHUFFLED - 1 && (t.closed || next == 0)));
        }
    }
}

/* ---- faults ------------------------------------------------------------------------------------ */

TEST(every_fault_has_its_place)
{
    static const struct { const char *text; long line, column; const char *part; } faults[] = {
        { "", 1, 1, "nothing is in this file" },
        { "# only\n\n# comments\n", 3, 1, "nothing is in this file" },
        { "x,y\n", 1, 1, "no stations follow" },
        { "x,y\n# closed: yes\n\n", 3, 1, "no stations follow" },
        { "\xff\xfex\0", 1, 1, "column \"y\" is missing" },
        { "x\n1\n", 1, 1, "column \"y\" is missing" },
        { "y,angle\n1,2\n", 1, 1, "column \"x\" is missing" },
        { "weight\n1\n", 1, 1, "column \"x\" is missing" },
        { "theta\n1\n", 1, 1, "column \"angle\" is missing" },
        { "angle,weight\n1,1\n", 1, 1, "column \"theta\" is missing" },
        { "x,y,x\n1,2,3\n", 1, 5, "column \"x\" is there twice, here and as column 1" },
        { "x,y,x_mm\n1,2,3\n", 1, 5, "column \"x_mm\" is there twice" },
        { "x,y,wieght\n1,2,3\n", 1, 5, "did you mean \"weight\"" },
        { "x,y,x2\n1,2,3\n", 1, 5, "column \"y2\" is missing" },
        { "x,y,y3,x2,y2\n1,2,3,4,5\n", 1, 5, "column \"x3\" is missing" },
        { "x,y,x3,y3\n1,2,3,4\n", 1, 8, "columns of point 3 but none of point 2" },
        { "x,y,weight2\n1,2,3\n", 1, 5, "there is a weight2 but no x2" },
        { "angle,theta,x2,y2\n1,2,3,4\n", 1, 13, "let the point with a path be the first" },
        { "x,y,x2,y2,x2_mm\n1,2,3,4,5\n", 1, 11, "column \"x2_mm\" is there twice" },
        { "x,y,x5,y5\n1,2,3,4\n", 1, 5, "x2 .. x4" },
        { "x,y,angle2\n1,2,3\n", 1, 5, "unknown column \"angle2\"" },
        { "x,y,theta2_mm\n1,2,3\n", 1, 5, "is no length" },
        { "x,y,x2,y2\n1,2,3\n", 2, 6, "3 of the 4 fields" },
        { "x,y,x2,y2,weight2\n1,2,3,4,-1\n", 2, 9, "a weight is at least 0" },
        { "x,y,x2,y2\n1,2,3,inf\n", 2, 7, "y2 is \"inf\"" },
        { "x,y,angle,theta2\n1,2,0,0\n1,2,0,1\n", 3, 5, "" },
        { "x,y,x_furlong\n1,2,3\n", 1, 5, "unknown column \"x_furlong\"" },
        { "x,y,\n1,2,3\n", 2, 5, "more than the 2 fields" },
        { "x,,y\n1,2,3\n", 1, 3, "has no name" },
        { "1,2,3\n3,4,5\n", 1, 1, "only two columns need no names" },
        { "x [furlong],y\n1,2\n", 1, 4, "unknown unit \"furlong\"" },
        { "x,y,t [s]\n1,2,3\n", 1, 8, "t counts turns" },
        { "x;y\n1,5;2.5\n", 2, 5, "mixes decimal commas and decimal points (line 2 has a comma)" },
        { "x;y\n1.234,5;2\n", 2, 1, "separators of thousands" },
        { "x\ty\n\"1,234\"\t2\n", 2, 2, "without quotes" },
        { "x;y\n12 mm;2\n", 2, 1, "as x [mm]" }, { "x;y\n12 34;2\n", 2, 1, "no number" }, { "x;y\n1,234 567;2\n", 2, 1, "no number" },
        { "x,y;angle\n1,2;3\n", 1, 1, "commas and semicolons" },
        { "x,y,theta_mm\n1,2,3\n", 1, 5, "is no length, so mm cannot" },
        { "x_deg,y\n1,2\n", 1, 1, "is no angle, so deg cannot" },
        { "x,y,weight_m\n1,2,3\n", 1, 5, "is no length, so m cannot" },
        { "x,y,angle,t\n1,2,3,4\n", 1, 11, "both give the input angle" },
        { "x,y,t,theta_in\n1,2,3,4\n", 1, 7, "both give the input angle" },
        { "x,y,theta,angle,theta_in\n1,2,3,4,5\n", 1, 11, "both give the tool angle" },
        { "x_mm,y_cm\n1,2\n", 1, 6, "\"y_cm\" says cm, but \"x_mm\" said mm" },
        { "# units: mm\nx,y_cm\n1,2\n", 2, 3, "a comment said mm" },
        { "x [mm],y\nmm,cm\n1,2\n", 1, 8, "units are mixed" },
        { "x,y,theta\n0,0,0\n0,1,-10\n", 3, 5, "more than half a turn here, from 0 to -10" },
        { "x,y,theta2\n0,0,0\n0,1,5\n0,2,9\n", 4, 5, "call the column theta2_deg" },
        { "x,y,weight\nmm,mm,mm\n1,2,3\n", 1, 5, "is no" },
        { "x,y\nmm,ell\n1,2\n", 2, 1, "which is no number" },
        { "x,y\n1,2\n# units: mm m\n", 3, 13, "units are mixed" },
        { "x,y,theta_deg,theta_in_rad\n1,2,3,4\n", 1, 15, "units are mixed" },
        { "# units: mm\n# units: cm\nx,y\n1,2\n", 2, 10, "units are mixed" },
        { "# units: parsec\nx,y\n1,2\n", 1, 10, "unknown unit \"parsec\"" },
        { "# Title\n\nA page (of text), in words.\n\n    # units: input deg\n", 3, 1, "this is no target: its first line" },
        { "# closed: perhaps\nx,y\n1,2\n", 1, 11, "yes or no" },
        { "# closed:\nx,y\n1,2\n", 1, 10, "yes or no" },
        { "# closed: yes\n# closed: no\nx,y\n1,2\n", 2, 11, "keep one" },
        { "x,y\n1,two\n", 2, 3, "y is \"two\", which is no number" },
        { "x,y\n1,2\n1, 0x10\n", 3, 4, "\"0x10\"" },
        { "x,y\n1,NaN\n", 2, 3, "no finite number" },
        { "x,y\n-inf,1\n", 2, 1, "no finite number" },
        { "x,y\n1,1e999\n", 2, 3, "too large" },
        { "x,y\n1,1e101\n", 2, 3, "too large" },
        { "x,y,angle\n1,1,1e7\n", 2, 5, "too large" },
        { "x,y\n1,\n", 2, 3, "the field of y is empty" },
        { "x,y\n,1\n", 2, 1, "the field of x is empty" },
        { "x,y\n1,2\n3\n", 3, 2, "this line has 1 of the 2 fields" },
        { "x,y\n1,2,3\n", 2, 5, "more than the 2 fields" },
        { "x,y\n1 2\n", 2, 1, "\"1 2\", which is no number" },
        { "x,y\n1,5,2,5\n", 2, 5, "decimal commas need semicolons" },
        { "x y\n1 2 3\n", 2, 4, "more than the 2 fields" },
        { "x\ty\n1\t\t3\n", 2, 3, "the field of y is empty" },
        { "x,y,weight\n1,2,1\n1,2,-1\n", 3, 5, "a weight is at least 0" },
        { "x,y,weight\n1,2,0\n1,2,0\n", 2, 5, "all weights are 0" },
        { "x,y,angle_deg\n0,0,5\n1,0,7\n2,0,5\n", 4, 5, "angle 5 deg stands in line 2 already" },
        { "x,y,angle_deg\n0,0,0\n1,0,7\n2,0,360\n", 4, 5, "360 deg stands in line 2 already" },
        { "x,y,angle_deg\n0,0,1e-12\n1,0,7\n2,0,359.999999999\n", 4, 5, "stands in line 2 already" },
        { "angle,theta\n1,1\n1,2\n", 3, 1, "stands in line 2 already" },
        { "x,y,theta,angle_deg\n0,0,0,5\n0,0,1,5\n", 3, 7, "stands in line 2 already" },
        { "x,y,angle_deg\n0,0,0\n1,0,20\n2,0,10\n3,0,30\n", 4, 5, "rise up to line 3 and turn back here, from 20 to 10" },
        { "x,y,angle_deg\n0,0,30\n1,0,20\n2,0,25\n3,0,10\n", 4, 5, "fall up to line 3" },
        { "x,y,angle_deg\n0,0,200\n1,0,350\n2,0,10\n3,0,30\n4,0,20\n", 6, 5, "rise up to line 5" },
        { "x,y,angle_deg\n0,0,0\n1,0,200\n2,0,9000\n", 4, 5, "run over 25 turns" },
        { "x,y,t\n0,0,0\n1,0,0.7\n2,0,24.5\n", 4, 5, "run over 24.5 turns" },
        { "x,y,angle_deg\n0,0,0\n1,0,400\n2,0,300\n", 4, 5, "rise up to line 3 and turn back here, from 400 to 300" },
    };
    for (size_t i = 0; i < sizeof faults/sizeof *faults; i++) {
        lw_target t;
        lw_error e;
        size_t size = faults[i].text[0] == '\xff' ? 4 : strlen(faults[i].text);
        CHECK_INT(read_with(faults[i].text, size, NULL, &t, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, faults[i].part);
        CHECK_TEXT(e.file, "p.csv");
        CHECK_INT(e.line, faults[i].line);
        CHECK_INT(e.column, faults[i].column);
        CHECK(t.n == 0 && t.store == NULL);
    }
}

TEST(as_many_rows_as_allowed)
{
    size_t size = 0, n = LW_STATION_MAX + 1;
    FREED char *text = malloc(4 + 4*n + 1);
    size += (size_t)sprintf(text, "x,y\n");
    for (size_t i = 0; i < n; i++)
        size += (size_t)sprintf(text + size, "%zu,1\n", i%10);
    lw_target t;
    lw_error e;
    CHECK_INT(read_with(text, size - 4, NULL, &t, &e), LW_OK);
    CHECK_INT(t.n, LW_STATION_MAX);
    lw_target_free(&t);
    CHECK_INT(read_with(text, size, NULL, &t, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "this is station 100001");
    CHECK_INT(e.line, 100002);
}

/* ---- arrays ------------------------------------------------------------------------------------ */

TEST(made_from_arrays)
{
    const double x[] = { 0, 1, 1 }, y[] = { 0, 0, 1 }, a[] = { 0, 1, 2 }, w[] = { 0, 0, 0 }, bad[] = { 0, NAN, 1 };
    lw_target t;
    CHECK_OK(lw_target_make(3, x, y, a, a, NULL, 1, &t, &check_error));
    CHECK(t.closed && t.x != x && t.x[1] == 1 && t.theta[2] == 2 && t.weight[0] == 1 && t.line[2] == 0);
    CHECK_NEAR(t.length, 2 + sqrt(2), 0, 1e-15);
    lw_target_free(&t);
    lw_target_free(&t);                                          /* harmless twice */
    CHECK_OK(lw_target_make(3, NULL, NULL, a, a, NULL, -1, &t, &check_error));
    CHECK(!t.x && !t.closed);
    lw_target_free(&t);
    CHECK_INT(lw_target_make(0, x, y, NULL, NULL, NULL, -1, &t, &check_error), LW_E_ARG);
    CHECK_INT(lw_target_make(3, x, NULL, NULL, NULL, NULL, -1, &t, &check_error), LW_E_ARG);
    CHECK_INT(lw_target_make(3, NULL, NULL, a, NULL, NULL, -1, &t, &check_error), LW_E_ARG);
    CHECK_INT(lw_target_make(3, x, y, NULL, NULL, w, -1, &t, &check_error), LW_E_ARG);
    CHECK_FAILS(lw_target_make(3, x, bad, NULL, NULL, NULL, -1, &t, &check_error), LW_E_ARG, "station 2");
    CHECK_INT(lw_target_make(3, x, y, NULL, NULL, bad, -1, &t, NULL), LW_E_ARG);
    CHECK(t.store == NULL);
}

/* Stars of k rays, anywhere and turned, have k equal parts; with one ray longer, or drawn open, they have not.  A rectangle has two, which do
 * not count; 30 points of a wave round a circle have as many as the wave. */
TEST(equal_parts_are_counted)
{
    enum { MOST = 60 };
    double x[MOST], y[MOST];
    for (int k = 3; k <= 12; k++)
        for (int kind = 0; kind < 4; kind++) {               /* star, with one ray longer, open, wave                   */
            OWN(lw_target) t = { 0 };
            size_t n = kind == 3 ? (size_t)(k == 7 || k > 8 ? 5*k : 60/k*k) : (size_t)(2*k);
            for (size_t i = 0; i < n; i++) {
                double a = 0.3 + 2*LW_PI*(double)i/(double)n, r = kind == 3 ? 1 + 0.3*cos(k*a) : i % 2 ? 0.5 : 1;
                r *= kind == 1 && i == 2 ? 1.2 : 1;
                x[i] = 7 + r*cos(a);
                y[i] = -3 + r*sin(a);
            }
            CHECK_INT(lw_target_make(n, x, y, NULL, NULL, NULL, kind != 2, &t, NULL), LW_OK);
            CHECK_INT(lw_target_parts(&t, 0.02*t.extent), kind == 0 || kind == 3 ? k : 1);
        }
    lw_target t;
    static const double u[] = { 0, 3, 3, 0 }, v[] = { 0, 0, 1, 1 }, still[] = { 2, 2 };
    CHECK_INT(lw_target_make(4, u, v, NULL, NULL, NULL, true, &t, NULL), LW_OK);
    CHECK_INT(lw_target_parts(&t, 0.01), 1);
    lw_target_free(&t);
    if (lw_target_make(2, still, still, NULL, NULL, NULL, true, &t, NULL) == LW_OK) {
        CHECK_INT(lw_target_parts(&t, 0.01), 1);
        lw_target_free(&t);
    }
}

TEST(circles_are_recognised)
{
    double x[12], y[12], r;
    lw_vec2 c;
    for (int line = 0; line < 2; line++)
        for (size_t n = 5; n < 13; n += 7) {
            OWN(lw_target) t = { 0 };
            for (size_t i = 0; i < n; i++) {                  /* an arc of 80 degrees, shaken by 0.01    */
                lw_vec2 p = lw_v2_polar(900 + (i%2 ? 0.01 : -0.01), 0.3 + 1.4*(double)i/(double)n);
                x[i] = line ? (double)i : 5 + p.x;
                y[i] = line ? 3*(double)i : p.y - 7;
            }
            CHECK_INT(lw_target_make(n, x, y, NULL, NULL, NULL, 0, &t, NULL), LW_OK);
            double off = lw_target_circle(&t, &c, &r);
            if (line || n == 5)
                CHECK(isinf(off));
            else {
                CHECK(off > 0.009 && off < 0.015);
                CHECK_NEAR(lw_v2_norm(lw_v2_sub(c, lw_v2(5, -7))), 0, 0.05, 0);
                CHECK_NEAR(r, 900, 0.05, 0);
            }
        }
}

/* Poses about one pivot, and a path on a line that is inclined and far away; neither is found where it is not. */
TEST(pivots_and_straight_lines_are_recognised)
{
    enum { N = 7, PIVOT, OTHER_WAY, SHIFTED, LINE, BENT, KINDS };
    for (int kind = PIVOT; kind < KINDS; kind++) {
        double x[N], y[N], theta[N];
        OWN(lw_target) t = { 0 };
        lw_vec2 c = { NAN, NAN };
        bool path = kind == LINE || kind == BENT;
        for (int i = 0; i < N; i++) {
            double a = 0.3 + 0.2*i;
            lw_vec2 p = lw_v2_polar(90, a), u = lw_v2_polar(i*i, 0.6);
            x[i] = path ? 3e4 + u.x : 5 + (kind == SHIFTED ? i : p.x);
            y[i] = path ? u.y - 8e4 + (kind == BENT && i == 3 ? 0.4 : 0) : (kind == SHIFTED ? 2*i : p.y) - 7;
            theta[i] = kind == OTHER_WAY ? 1 - a : kind == SHIFTED ? 1 : 1 + a;
        }
        CHECK_INT(lw_target_make(N, x, y, path ? NULL : theta, NULL, NULL, 0, &t, NULL), LW_OK);
        double off = lw_target_pivot(&t, &c), bent = lw_target_straight(&t);
        if (kind == PIVOT) {
            CHECK_NEAR(off, 0, 1e-10, 0);
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(c, lw_v2(5, -7))), 0, 1e-10, 0);
        } else {
            CHECK(kind == OTHER_WAY ? off > 5 : isinf(off));
        }
        CHECK(kind == BENT ? bent > 0.1 && bent < 0.4 : kind == LINE || kind == SHIFTED ? bent < 1e-9 : bent > 5);
    }
}

/* No cut and no changed byte may do more harm than an error. */
TEST(any_bytes_are_survived)
{
    static const char good[] = "# units: mm deg\n# closed: yes\nx,y_mm,theta,theta_in_deg,weight\n1,2,3,4,1\n"
                               "2.5e1,-.5,6,7,0.25\r\n\n3,\"3\",3,9,1 # c\n";
    lw_rng r = check_rng(1);
    check_reads(good, 3);
    for (int trial = 0; trial < 50000; trial++) {
        char text[sizeof good];
        OWN(lw_target) t = { 0 };
        lw_error e;
        size_t n = trial%4 ? sizeof good - 1 : (size_t)(lw_rng_bits(&r)%sizeof good);
        memcpy(text, good, sizeof good);
        for (int i = 0; i < trial%4; i++)
            text[lw_rng_bits(&r)%(sizeof good - 1)] = i%2 ? (char)lw_rng_bits(&r) : good[lw_rng_bits(&r)%sizeof good];
        lw_status s = read_with(text, n, NULL, &t, &e);
        CHECK(s == LW_OK || s == LW_E_NOTATION);
        CHECK(s == LW_OK ? t.n > 0 : e.text[0] && e.line > 0 && e.column > 0);
    }
}

/* What the file does not say is said by the note, and nothing else. */
TEST(assumed_units)
{
    static const struct { const char *text; bool length, angle; } row[] = {
        { "x,y\n0,0\n1,2\n3,3\n", true, false },
        { "# units: mm\nx,y\n0,0\n1,2\n3,3\n", false, false },
        { "x_mm,y_mm,angle\n0,0,0\n1,2,1\n3,3,2\n", false, true },
        { "x_mm,y_mm,t\n0,0,0\n1,2,0.1\n3,3,0.2\n", false, false },
        { "angle,theta\n0,0\n1,2\n2,3\n", false, true },
        { "angle_deg,theta_deg\n0,0\n1,2\n2,3\n", false, false },
        { "0,0\n1,2\n3,3\n", true, false },
    };
    for (size_t i = 0; i < sizeof row/sizeof *row; i++) {
        OWN(lw_target) t = { 0 };
        CHECK_OK(lw_target_read(row[i].text, strlen(row[i].text), "f.csv", NULL, &t, &check_error));
        CHECK_INT(strstr(t.note, "lengths have no unit") != NULL, row[i].length);
        CHECK_INT(strstr(t.note, "count as rad") != NULL, row[i].angle);
        CHECK_INT(t.note[0] != 0, row[i].length || row[i].angle);
    }
}

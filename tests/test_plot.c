/* Plots: every point where its numbers say, ticks where people expect them, nothing lost on the way. */
#include "catalogues/pages/draw.h"
#include "catalogues/draw/plot.h"
#include "catalogues/draw/svg.h"
#include "tests/check.h"
#include "tests/scene_models.h"
#include "tests/xml_scan.h"

#define N 20

typedef struct lines { double x[N], y[N]; lw_series s; lw_level level; lw_plot p; } lines;

static void make(lines *l, bool log_x, bool log_y)
{
    for (int i = 0; i < N; i++) {
        l->x[i] = log_x ? pow(10, 0.25*i) : i;
        l->y[i] = log_y ? pow(10, 1 - 0.3*i) : 100 - 3*i;
    }
    l->s = (lw_series){ "a series", N, l->x, l->y, LW_SERIES_LINE };
    l->level = (lw_level){ "published best", log_y ? 1e-3 : 50 };
    l->p = (lw_plot){ .title = "Title", .x_label = "evaluations", .y_label = "error", .log_x = log_x, .log_y = log_y,
                      .n_series = 1, .n_level = 1, .series = &l->s, .level = &l->level };
}

static int n_of(const lw_drawing *d, lw_role role)
{
    int n = 0;
    for (size_t i = 0; i < d->n_shape; i++)
        n += d->shape[i].role == role;
    return n;
}

static lw_vec2 marker_at(const lw_drawing *d, int item)
{
    for (size_t i = 0; i < d->n_shape; i++)
        if (d->shape[i].role == LW_ROLE_MARKER && d->shape[i].item == item)
            return d->shape[i].at;
    return lw_v2(NAN, NAN);
}

/* Steps that are even in the logarithm are even on a logarithmic axis. */
TEST(points_lie_where_their_numbers_say)
{
    for (int kind = 0; kind < 4; kind++) {
        lines l;
        OWN(lw_drawing) d = { 0 };
        make(&l, kind & 1, kind & 2);
        CHECK_OK(lw_plot_draw(&l.p, &d, &check_error));
        CHECK_INT(n_of(&d, LW_ROLE_MARKER), N);
        CHECK_INT(n_of(&d, LW_ROLE_LEVEL), 2);
        CHECK(n_of(&d, LW_ROLE_SERIES) == 1);
        lw_vec2 step = lw_v2_sub(marker_at(&d, 1), marker_at(&d, 0));
        CHECK(step.x > 5 && step.y > 5);                            /* to the right and down */
        for (int i = 1; i < N; i++) {
            lw_vec2 s = lw_v2_sub(marker_at(&d, i), marker_at(&d, i - 1));
            CHECK_POINT(s, step.x, step.y, 1e-9, 0);
        }
        OWN(lw_bytes) b = { 0 };
        CHECK_OK(lw_svg_write(&d, &b, &check_error));
        CHECK(xml_scan(b.data, NULL, NULL) > 40);
    }
}

static bool has_text(const lw_drawing *d, lw_role role, const char *text)
{
    for (size_t i = 0; i < d->n_shape; i++)
        if (d->shape[i].role == role && d->shape[i].kind == LW_SHAPE_TEXT && strcmp(d->text + d->shape[i].first, text) == 0)
            return true;
    return false;
}

TEST(ticks_are_round_numbers)
{
    lines l;
    OWN(lw_drawing) d = { 0 };
    make(&l, true, true);
    CHECK_OK(lw_plot_draw(&l.p, &d, &check_error));
    static const char *const decades[] = { "1", "10", "100", "1000", "10000" };
    for (int i = 0; i < 5; i++)
        CHECK(has_text(&d, LW_ROLE_TICK, decades[i]));
    CHECK(has_text(&d, LW_ROLE_TICK, "0.001"));
    CHECK(has_text(&d, LW_ROLE_LEVEL, "published best"));
    CHECK(has_text(&d, LW_ROLE_LEGEND, "a series"));
    lw_drawing_free(&d);
    make(&l, false, false);
    CHECK_OK(lw_plot_draw(&l.p, &d, &check_error));
    CHECK(has_text(&d, LW_ROLE_TICK, "60"));
    CHECK(has_text(&d, LW_ROLE_TICK, "0"));
}

/* A turn in degrees is cut into parts of a turn, on both axes; some degrees are as other numbers. */
TEST(degrees_are_parts_of_a_turn)
{
    double x[] = { 0, 360 }, y[] = { -0.3, 0.4 };
    lw_series s = { .name = "a", .n = 2, .x = x, .y = y };
    lw_plot p = { .x_label = "input [deg]", .y_label = "angle [deg]", .n_series = 1, .series = &s };
    OWN(lw_drawing) d = { 0 };
    CHECK_OK(lw_plot_draw(&p, &d, &check_error));
    CHECK(has_text(&d, LW_ROLE_TICK, "90") && has_text(&d, LW_ROLE_TICK, "270") && has_text(&d, LW_ROLE_TICK, "360") && has_text(&d, LW_ROLE_TICK, "0.2"));
    CHECK(!has_text(&d, LW_ROLE_TICK, "100"));
    lw_drawing_free(&d);
    lw_plot two[] = { { .y_label = "place [m]", .n_series = 1, .series = &s }, p };
    CHECK_OK(lw_plot_draw_stack(2, two, &d, &check_error));
    CHECK(!has_text(&d, LW_ROLE_TICK, "100"));                /* the panel above has the same axis */
}

/* The numbers along an axis differ from each other. */
static void check_ticks_differ(const lw_drawing *d)
{
    for (size_t i = 0; i < d->n_shape; i++)
        for (size_t k = 0; k < i; k++) {
            const lw_shape *a = &d->shape[i], *b = &d->shape[k];
            if (a->role == LW_ROLE_TICK && b->role == LW_ROLE_TICK && a->align == b->align)
                CHECK(strcmp(d->text + a->first, d->text + b->first) != 0);
        }
}

/* Any range, however narrow, wide or far out, gets between 2 and 20 ticks an axis and stays finite. */
TEST(any_range_has_ticks)
{
    for (double middle = 1e-12; middle < 1e13; middle *= 1e4)
        for (double wide = 1e-9; wide <= 1; wide *= 10) {
            double x[2] = { middle, middle*(1 + wide) }, y[2] = { middle, middle*(1 - wide/2) };
            for (int log = 0; log < 2; log++) {
                lw_series s = { "s", 2, x, y, true };
                lw_plot p = { .log_x = log, .log_y = log, .n_series = 1, .series = &s };
                OWN(lw_drawing) d = { 0 };
                CHECK_OK(lw_plot_draw(&p, &d, &check_error));
                int n = n_of(&d, LW_ROLE_TICK);
                CHECK(n >= 2 && n <= 40);
                check_ticks_differ(&d);
                for (size_t i = 0; i < d.n_point; i++)
                    CHECK(d.point[i].x >= 0 && d.point[i].x <= 800 && d.point[i].y >= 0 && d.point[i].y <= 560);
            }
        }
}

TEST(unfit_points_are_left_out)
{
    double x[6] = { 1, 2, 0, -1, NAN, 5 }, y[6] = { 1, INFINITY, 3, 4, 5, 6 };
    lw_series s = { "s", 6, x, y, false };
    lw_plot p = { .log_x = true, .log_y = true, .n_series = 1, .series = &s };
    lw_drawing d;
    CHECK_OK(lw_plot_draw(&p, &d, &check_error));
    CHECK_INT(n_of(&d, LW_ROLE_MARKER), 2);
    lw_drawing_free(&d);
    s.n = 0;
    CHECK_INT(lw_plot_draw(&p, &d, &check_error), LW_NOTHING);
    CHECK(has_text(&d, LW_ROLE_NOTE, "no point to show"));
    lw_drawing_free(&d);
    p.n_series = LW_SERIES_MAX + 1;
    CHECK_INT(lw_plot_draw(&p, &d, &check_error), LW_E_ARG);
    p.n_series = 0;
    p.width = 1e6;
    CHECK_INT(lw_plot_draw(&p, &d, &check_error), LW_E_ARG);
}

/* Thousands of points: lines in pieces that touch, no markers. */
TEST(long_series_are_unbroken)
{
    enum { LONG = 5000 };
    static double x[LONG], y[LONG];
    for (int i = 0; i < LONG; i++) {
        x[i] = i;
        y[i] = sin(0.01*i);
    }
    for (int steps = 0; steps < 2; steps++) {
        lw_series s = { "s", LONG, x, y, steps };
        lw_plot p = { .n_series = 1, .series = &s };
        OWN(lw_drawing) d = { 0 };
        CHECK_OK(lw_plot_draw(&p, &d, &check_error));
        CHECK_INT(n_of(&d, LW_ROLE_MARKER), 0);
        lw_vec2 end = { NAN, NAN };
        size_t n = 0;
        for (size_t i = 0; i < d.n_shape; i++) {
            const lw_shape *q = &d.shape[i];
            if (q->role != LW_ROLE_SERIES)
                continue;
            CHECK(isnan(end.x) || (d.point[q->first].x == end.x && d.point[q->first].y == end.y));
            end = d.point[q->first + q->n - 1];
            n += q->n - 1;
        }
        CHECK_INT(n, (steps ? 2 : 1)*(LONG - 1));
    }
}

TEST(files_by_their_kind)
{
    static const struct { const char *name; lw_draw_kind kind; } known[] = {
        { "x.svg", LW_DRAW_SVG }, { "a.b/x.PNG", LW_DRAW_PNG }, { "pdf", LW_DRAW_PDF },
        { "x.gif", LW_DRAW_GIF }, { "index.html", LW_DRAW_HTML },
    };
    lw_draw_kind kind;
    for (int i = 0; i < 5; i++) {
        CHECK_OK(lw_draw_kind_of(known[i].name, &kind, &check_error));
        CHECK_INT(kind, known[i].kind);
    }
    CHECK_FAILS(lw_draw_kind_of("x.jpeg", &kind, &check_error), LW_E_ARG, ".svg");
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 4, &s), LW_OK);
    static const char *const begins[] = { "<?xml", "%PDF-", "\x89PNG", "GIF89a", "<!DOCTYPE html>" };
    for (int i = LW_DRAW_SVG; i <= LW_DRAW_HTML; i++) {
        OWN(lw_bytes) b = { 0 };
        CHECK_OK(lw_draw_bytes(&s, (lw_draw_kind)i, 200, 150, &b, &check_error));
        CHECK(strncmp(b.data, begins[i], strlen(begins[i])) == 0);
    }
    CHECK_INT(lw_draw_save(&s, LW_DRAW_SVG, "/dev/null/x.svg", 0, 0, &check_error), LW_E_IO);
    lines l;
    make(&l, true, true);
    CHECK_INT(lw_draw_plot(&l.p, "/dev/null/x.png", &check_error), LW_E_IO);
    CHECK_INT(lw_draw_plot(&l.p, "/dev/null/x.gif", &check_error), LW_E_ARG);
}

/* A circle is as wide as high, whatever the page; points alone have no line */
TEST(circles_stay_round)
{
    for (int wide = 0; wide < 2; wide++) {
        double x[N], y[N];
        for (int i = 0; i < N; i++) {
            x[i] = 3 + 2*cos(2*LW_PI*i/N);
            y[i] = 2*sin(2*LW_PI*i/N);
        }
        lw_series s = { "circle", N, x, y, wide ? LW_SERIES_POINTS : LW_SERIES_LINE };
        lw_plot p = { .width = wide ? 1200 : 500, .height = 500, .n_series = 1, .series = &s, .equal = true };
        OWN(lw_drawing) d = { 0 };
        CHECK_OK(lw_plot_draw(&p, &d, &check_error));
        double width = fabs(marker_at(&d, 0).x - marker_at(&d, N/2).x);
        double height = fabs(marker_at(&d, N/4).y - marker_at(&d, 3*N/4).y);
        CHECK_NEAR(height, width, 1e-9, 0);
        CHECK(width > 100);
        CHECK_INT(n_of(&d, LW_ROLE_SERIES), !wide);
        CHECK_INT(n_of(&d, LW_ROLE_MARKER), N);
    }
}

/* An axis is never numbered in multiples of rounding: such values are drawn as zero, and it is said. */
TEST(rounding_is_zero)
{
    for (int k = 0; k < 2; k++) {
        lines l;
        OWN(lw_drawing) d = { 0 };
        make(&l, false, false);
        l.p.n_level = 0;
        for (int i = 0; i < N; i++)
            l.y[i] = (k ? 1e-12 : 3e-17)*(i % 3 - 1);
        CHECK_OK(lw_plot_draw(&l.p, &d, &check_error));
        CHECK_INT(n_of(&d, LW_ROLE_NOTE), !k);
        CHECK((fabs(marker_at(&d, 0).y - marker_at(&d, 1).y) > 100) == k);
    }
}

/* Panels in columns: the same point of each lies one column further, then one row below; the legend is right of all. */
TEST(panels_in_columns)
{
    enum { PANELS = 5, COLUMNS = 3 };
    lines l;
    lw_plot p[PANELS];
    lw_vec2 first[PANELS], legend = { 0, 0 };
    OWN(lw_drawing) d = { 0 };
    int n = 0;
    make(&l, true, true);
    lw_series unnamed = l.s;
    unnamed.name = "";
    for (int i = 0; i < PANELS; i++) {
        p[i] = l.p;
        p[i].series = i == 1 ? &l.s : &unnamed;
        p[i].columns = COLUMNS, p[i].width = 1000, p[i].height = 500;
    }
    CHECK_OK(lw_plot_draw_stack(PANELS, p, &d, &check_error));
    for (size_t i = 0; i < d.n_shape; i++) {
        if (d.shape[i].role == LW_ROLE_MARKER && d.shape[i].item == 0 && n < PANELS)
            first[n++] = d.shape[i].at;
        if (d.shape[i].role == LW_ROLE_LEGEND && d.shape[i].kind == LW_SHAPE_CIRCLE)
            legend = d.shape[i].at;
    }
    CHECK_INT(n, PANELS);
    double column = first[1].x - first[0].x;
    CHECK(column > 250 && column < 333 && legend.x > 3*column && legend.x < 1000 && legend.y < 250);
    for (int i = 0; i < PANELS; i++)
        CHECK_POINT(first[i], first[0].x + column*(i % COLUMNS), first[0].y + 250*(i/COLUMNS), 1e-9, 0);
}

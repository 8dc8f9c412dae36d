/* Curves of drawings as targets: every command of a path, transforms, units; polylines, bulges, chains; faults. */
#include "optimise/task/target_outline.h"

#include "base/vec2.h"
#include "tests/check.h"

typedef lw_status reader(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t,
                         lw_error *e);

static lw_target read_text(reader *read, const char *text)
{
    lw_target t;
    lw_error e = { .text = "" };
    CHECK_INT(read(text, strlen(text), "t", NULL, &t, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    if (t.n == 0)
        fprintf(stderr, "    %s: %ld:%ld\n", text, e.line, e.column);
    return t;
}

static void stations(const lw_target *t, int closed, const double (*want)[2], size_t n, double unit)
{
    CHECK_INT(t->n, n);
    CHECK_INT(t->closed, closed);
    for (size_t i = 0; i < n && i < t->n; i++) {
        CHECK_NEAR(t->x[i], want[i][0]*unit, 1e-15, 1e-14);
        CHECK_NEAR(t->y[i], want[i][1]*unit, 1e-15, 1e-14);
    }
}

/* ---- SVG ------------------------------------------------------------------------------------------------- */

static void corners_are_stations(void)
{
    static const double square[][2] = { { 0, 0 }, { 10, 0 }, { 10, -5 }, { 0, -5 } };
    static const char *const rows[] = {
        "<svg><polygon points='0,0 10,0 10,5 0,5'/></svg>",
        "<svg><path d=\"M0 0H10V5H0Z\"/></svg>",
        "<svg><path d=\"m0,0h10v5h-10z\"/></svg>",
        "<svg><path d='M 0 0 10 0 10 5 0 5 z'/></svg>",
        "<svg><path d='m0 0l10 0 0 5-10 0z'/></svg>",
        "<svg><path d='M0 0L10 0 10 5L0 5 0 0'/></svg>",
        ("<?xml version='1.0'?><!-- <path d='M 9 9'/> --><svg><defs><path d='M 8 8 L 9 9'/></defs>"
         "<g transform='translate(5)'><g transform='translate(-5,0)'><path d='M.0.0L1e1,0 10.,5e0 0 5Z'/></g></g>"
         "</svg>"),
        "<svg><g transform='rotate(90)'><path d='M0 0V-10H5V0Z'/></g></svg>",
        "<svg><path transform='matrix(2 0 0 .5 -2 -1)' d='M1 2 6 2 6 12 1 12Z'/></svg>",
        "<svg><path transform='scale(2) translate(1 1) rotate(180 2 2)' d='M5 5H0V2.5H5Z'/></svg>"
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_target t = read_text(lw_target_read_svg, rows[i]);
        stations(&t, 1, square, 4, 1e-3);
        CHECK_TEXT(t.units.length, "mm");
        lw_target_free(&t);
    }
}

static void units_of_drawings(void)
{
    lw_target t = read_text(lw_target_read_svg,
                            "<svg width='12cm' viewBox='0 0 240 10'><path d='M0 0L2 0 2 4'/></svg>");
    CHECK_NEAR(t.x[1], 1e-3, 1e-17, 0);
    CHECK_INT(t.closed, 0);
    lw_target_free(&t);
    lw_error e;
    static const char text[] = "<svg><path d='M0 0L2 0 2 4'/></svg>";
    CHECK_INT(lw_target_read_svg(text, sizeof text - 1, "t", &(lw_target_options){ 1, "in", NULL }, &t, &e), LW_OK);
    CHECK_NEAR(t.x[1], 2*0.0254, 1e-17, 0);
    CHECK_INT(t.closed, 1);
    lw_target_free(&t);
    CHECK_INT(lw_target_read_svg(text, sizeof text - 1, "t", &(lw_target_options){ 1, "ell", NULL }, &t, &e), LW_E_ARG);
}

/* Evenly spread stations on a circle, whichever way it is said. */
static void circle(lw_target *t, double x, double y, double r)
{
    double step = 2*r*sin(LW_PI/LW_OUTLINE_STATIONS);
    CHECK_INT(t->n, LW_OUTLINE_STATIONS);
    CHECK_INT(t->closed, 1);
    for (size_t i = 0; i < t->n; i++) {
        size_t j = (i + 1) % t->n;
        CHECK_NEAR(hypot(t->x[i] - x, t->y[i] - y), r, 3.1e-4*r, 0);
        CHECK_NEAR(hypot(t->x[i] - t->x[j], t->y[i] - t->y[j]), step, 1e-3*step, 0);
    }
    lw_target_free(t);
}

static void arcs(void)
{
    static const char *const rows[] = {
        "<svg><path d='M10 0A10 10 0 0 1-10 0A10 10 0 0 1 10 0Z'/></svg>",
        "<svg><path d='M10 0a10,10,0,0,0,-20,0 10 10 0 0020 0'/></svg>",
        "<svg><path d='M10 0A1 1 0 1 1-10 0 1 1 30 0110 0'/></svg>",             /* radii too short */
        "<svg><path d='M10 0A10 10 0 1 0 0 10A10 10 0 0 0 10 0Z'/></svg>",
        "<svg><path transform='scale(2 1)' d='M5 0A5 10 0 1 0 0 10A5 10 0 0 0 5 0Z'/></svg>",
        "<svg><path transform='scale(1 2)' d='M10 0A5 10 90 1 0 0 5A5 10-90 0 0 10 0Z'/></svg>"
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_target t = read_text(lw_target_read_svg, rows[i]);
        circle(&t, 0, 0, 0.01);
    }
}

/* The distance of a station from a curve that is sown densely. */
static double off_cubic(const double p[8], double x, double y)
{
    double least = INFINITY;
    for (int i = 0; i <= 4000; i++) {
        double t = i/4000.0, s = 1 - t;
        double u = s*s*s*p[0] + 3*s*s*t*p[2] + 3*s*t*t*p[4] + t*t*t*p[6];
        double v = s*s*s*p[1] + 3*s*s*t*p[3] + 3*s*t*t*p[5] + t*t*t*p[7];
        least = fmin(least, hypot(u - x, v - y));
    }
    return least;
}

static void bent_curves(void)
{
    static const struct { const char *d; double p[8]; } rows[] = {
        { "M0 0C1 3 5-2 8 1", { 0, 0, 1, 3, 5, -2, 8, 1 } },
        { "m0 0c1 3 5-2 8 1", { 0, 0, 1, 3, 5, -2, 8, 1 } },
        { "M0 0S5-2 8 1", { 0, 0, 0, 0, 5, -2, 8, 1 } },
        { "M0 0Q3 6 6 0", { 0, 0, 2, 4, 4, 4, 6, 0 } },
        { "M0 0t6 0", { 0, 0, 0, 0, 2, 0, 6, 0 } }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        char text[128];
        snprintf(text, sizeof text, "<svg><path d='%s'/></svg>", rows[i].d);
        lw_target t = read_text(lw_target_read_svg, text);
        CHECK_INT(t.n, LW_OUTLINE_STATIONS);
        CHECK_INT(t.closed, 0);
        for (size_t k = 0; k < t.n; k++)
            CHECK_NEAR(off_cubic(rows[i].p, 1e3*t.x[k], -1e3*t.y[k]), 0, 2e-3, 0);
        CHECK_NEAR(1e3*t.x[t.n - 1], rows[i].p[6], 1e-12, 0);
        lw_target_free(&t);
    }
    /* S and T take the handle over: the same curve said in two ways */
    static const char *const same[][2] = {
        { "M0 0C1 3 5-2 8 1S 9 9 14 3", "M0 0C1 3 5-2 8 1C11 4 9 9 14 3" },
        { "M0 0Q3 6 6 0T12 1", "M0 0Q3 6 6 0Q9-6 12 1" },
        { "M0 0Q3 6 6 0t6 1", "M0 0q3 6 6 0q3-6 6 1" }
    };
    for (size_t i = 0; i < sizeof same/sizeof *same; i++) {
        lw_target t[2];
        for (int k = 0; k < 2; k++) {
            char text[128];
            snprintf(text, sizeof text, "<svg><path d='%s'/></svg>", same[i][k]);
            t[k] = read_text(lw_target_read_svg, text);
        }
        for (size_t k = 0; k < t[0].n; k++)
            CHECK_NEAR(hypot(t[0].x[k] - t[1].x[k], t[0].y[k] - t[1].y[k]), 0, 1e-15, 0);
        lw_target_free(&t[0]);
        lw_target_free(&t[1]);
    }
}

/* ---- DXF ------------------------------------------------------------------------------------------------- */

#define HEAD "0\nSECTION\n2\nENTITIES\n"
#define TAIL "0\nENDSEC\n0\nEOF\n"

static void polylines(void)
{
    static const double want[][2] = { { 0, 0 }, { 4, 0 }, { 4, 3 } };
    static const char *const rows[] = {
        HEAD "0\nLWPOLYLINE\n8\n0\n90\n3\n70\n1\n10\n0\n20\n0\n10\n4\n20\n0\n10\n4\n20\n3\n" TAIL,
        (HEAD "  0\r\nPOLYLINE\r\n 66\r\n1\r\n 70\r\n1\r\n 10\r\n0.0\r\n 20\r\n0.0\r\n  0\r\nVERTEX\r\n 10\r\n0.0\r\n"
             " 20\r\n0.0\r\n  0\r\nVERTEX\r\n 10\r\n4\r\n 20\r\n0\r\n  0\r\nVERTEX\r\n 10\r\n4\r\n 20\r\n3\r\n  0\r\n"
             "SEQEND\r\n" TAIL),
        (HEAD "0\nLINE\n10\n0\n20\n0\n11\n4\n21\n0\n0\nLINE\n10\n0\n20\n0\n11\n4\n21\n3\n"
         "0\nLINE\n10\n4\n20\n3\n11\n4\n21\n0\n" TAIL)
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_target t = read_text(lw_target_read_dxf, rows[i]);
        stations(&t, 1, want, 3, 1e-3);
        lw_target_free(&t);
    }
    lw_target t = read_text(lw_target_read_dxf, HEAD "0\nLINE\n10\n1\n20\n0\n11\n2\n21\n0\n"
                            "0\nLINE\n10\n0\n20\n1\n11\n1\n21\n0\n" TAIL);
    CHECK_INT(t.n, 3);                                     /* lines in any order, an open curve */
    CHECK_INT(t.closed, 0);
    lw_target_free(&t);
    t = read_text(lw_target_read_dxf, "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n5\n0\nENDSEC\n"
                  HEAD "0\nLINE\n10\n0\n20\n0\n11\n4\n21\n0\n" TAIL);
    CHECK_NEAR(t.x[1], 0.04, 1e-17, 0);
    CHECK_TEXT(t.units.length, "cm");
    lw_target_free(&t);
}

static void bulges_and_arcs(void)
{
    static const char *const rows[] = {
        HEAD "0\nCIRCLE\n10\n3\n20\n-2\n40\n2.5\n" TAIL,
        HEAD "0\nARC\n10\n3\n20\n-2\n40\n2.5\n50\n350\n51\n80\n0\nARC\n10\n3\n20\n-2\n40\n2.5\n50\n80\n51\n350\n" TAIL,
        HEAD "0\nLWPOLYLINE\n70\n1\n10\n.5\n20\n-2\n42\n1\n10\n5.5\n20\n-2\n42\n1\n" TAIL,
        HEAD "0\nLWPOLYLINE\n70\n1\n10\n.5\n20\n-2\n42\n-1\n10\n5.5\n20\n-2\n42\n-1\n" TAIL,
        HEAD "0\nPOLYLINE\n70\n1\n0\nVERTEX\n10\n5.5\n20\n-2\n42\n0.4142135623730951\n0\nVERTEX\n10\n3\n20\n.5\n42\n"
             "2.414213562373095\n0\nSEQEND\n" TAIL
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_target t = read_text(lw_target_read_dxf, rows[i]);
        circle(&t, 3e-3, -2e-3, 2.5e-3);
    }
}

/* ---- faults ------------------------------------------------------------------------------------------------ */

static void faults(void)
{
    static const struct { reader *read; const char *text; int line, column; const char *why; } rows[] = {
        { lw_target_read_svg, "", 1, 1, "there is no path" },
        { lw_target_read_svg, "<svg><rect width='3'/></svg>", 1, 29, "there is no path" },
        { lw_target_read_svg, "<svg>\n<path d='L 1 1'/></svg>", 2, 10, "begins with M" },
        { lw_target_read_svg, "<svg><path d='M 1 x'/></svg>", 1, 19, "a number is expected" },
        { lw_target_read_svg, "<svg><path d='M 1 1 B 3'/></svg>", 1, 21, "one of M L" },
        { lw_target_read_svg, "<svg><path d='M 1 1 2 2 M 3 3'/></svg>", 1, 25, "a second curve" },
        { lw_target_read_svg, "<svg><path d='M 1 1A1 1 0 2 0 3 3'/></svg>", 1, 27, "a flag of an arc" },
        { lw_target_read_svg, "<svg><path d='M 1 1L1e999 0'/></svg>", 1, 21, "a number is expected" },
        { lw_target_read_svg, "<svg><path d='M 1 1L1e200 0'/></svg>", 1, 1, "too far away" },
        { lw_target_read_svg, "<svg><path d='M 1 1L2 0", 1, 15, "has no end" },
        { lw_target_read_svg, "<svg><g transform='turn(3)'>", 1, 20, "a transform is" },
        { lw_target_read_svg, "<svg><path d=3/></svg>", 1, 15, "a quote is expected" },
        { lw_target_read_dxf, "", 1, 1, "there is no polyline" },
        { lw_target_read_dxf, "x,y\n1,2\n", 1, 1, "no DXF text" },
        { lw_target_read_dxf, HEAD "0\nLINE\n10\nab\n", 8, 1, "a number is expected" },
        { lw_target_read_dxf, HEAD "0\nLINE\n10\n0\n11\n1\n0\nLINE\n10\n5\n11\n6\n" TAIL, 16, 1,
          "more than one curve" },
        { lw_target_read_dxf, HEAD "0\nPOLYLINE\n0\nSEQEND\n0\nLWPOLYLINE\n" TAIL, 10, 1, "more than one polyline" }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        lw_target t;
        lw_error e = { .text = "" };
        CHECK_INT(rows[i].read(rows[i].text, strlen(rows[i].text), "t", NULL, &t, &e), LW_E_NOTATION);
        CHECK_HAS(e.text, rows[i].why);
        if (e.line != rows[i].line || e.column != rows[i].column)
            fprintf(stderr, "    %s\n", rows[i].text);
        CHECK_INT(e.line, rows[i].line);
        CHECK_INT(e.column, rows[i].column);
        CHECK(t.store == NULL);
    }
}

int main(void)
{
    RUN(corners_are_stations);
    RUN(units_of_drawings);
    RUN(arcs);
    RUN(bent_curves);
    RUN(polylines);
    RUN(bulges_and_arcs);
    RUN(faults);
    return check_end();
}

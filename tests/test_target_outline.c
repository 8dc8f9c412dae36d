/* Curves of drawings as targets: every command of a path, transforms, units; polylines, bulges, chains; faults. */
#include "optimise/task/target_outline.h"

#include "base/vec2.h"
#include "optimise/task/read_file.h"
#include "tests/check.h"

typedef lw_status reader(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);

static lw_target read_with(reader *read, const char *text, const lw_target_options *o)
{
    lw_target t;
    lw_error e = { .text = "" };
    CHECK_INT(read(text, strlen(text), "t", o, &t, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    if (t.n == 0)
        fprintf(stderr, "    %s: %ld:%ld\n", text, e.line, e.column);
    return t;
}

static lw_target read_text(reader *read, const char *text) { return read_with(read, text, NULL); }

/* The points as they are drawn. */
static lw_target read_drawn(reader *read, const char *text)
{
    return read_with(read, text, &(lw_target_options){ .closed = -1, .stations = -1 });
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

TEST(corners_are_stations)
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
         "<g transform='translate(5)'><g transform='translate(-5,0)'><path d='M.0.0L1e1,0 10.,5e0 0 5Z'/></g></g></svg>"),
        "<svg><g transform='rotate(90)'><path d='M0 0V-10H5V0Z'/></g></svg>",
        "<svg><path transform='matrix(2 0 0 .5 -2 -1)' d='M1 2 6 2 6 12 1 12Z'/></svg>",
        "<svg><path transform='scale(2) translate(1 1) rotate(180 2 2)' d='M5 5H0V2.5H5Z'/></svg>"
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        OWN(lw_target) t = read_drawn(lw_target_read_svg, rows[i]);
        stations(&t, 1, square, 4, 1e-3);
        CHECK_TEXT(t.units.length, "mm");
    }
}

TEST(units_of_drawings)
{
    lw_target t = read_drawn(lw_target_read_svg, "<svg width='12cm' viewBox='0 0 240 10'><path d='M0 0L2 0 2 4'/></svg>");
    CHECK_NEAR(t.x[1], 1e-3, 1e-17, 0);
    CHECK_INT(t.closed, 0);
    lw_target_free(&t);
    static const char text[] = "<svg><path d='M0 0L2 0 2 4'/></svg>";
    lw_target_options o = { .closed = 1, .length_unit = "in", .stations = -1 };
    CHECK_OK(lw_target_read_svg(text, sizeof text - 1, "t", &o, &t, &check_error));
    CHECK_NEAR(t.x[1], 2*0.0254, 1e-17, 0);
    CHECK_INT(t.closed, 1);
    lw_target_free(&t);
    o.length_unit = "ell";
    CHECK_INT(lw_target_read_svg(text, sizeof text - 1, "t", &o, &t, &check_error), LW_E_ARG);
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

TEST(arcs)
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

TEST(bent_curves)
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
        OWN(lw_target) t = read_text(lw_target_read_svg, text);
        CHECK_INT(t.n, LW_OUTLINE_STATIONS);
        CHECK_INT(t.closed, 0);
        for (size_t k = 0; k < t.n; k++)
            CHECK_NEAR(off_cubic(rows[i].p, 1e3*t.x[k], -1e3*t.y[k]), 0, 2e-3, 0);
        CHECK_NEAR(1e3*t.x[t.n - 1], rows[i].p[6], 1e-12, 0);
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

TEST(polylines)
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
        OWN(lw_target) t = read_drawn(lw_target_read_dxf, rows[i]);
        stations(&t, 1, want, 3, 1e-3);
    }
    lw_target t = read_drawn(lw_target_read_dxf, HEAD "0\nLINE\n10\n1\n20\n0\n11\n2\n21\n0\n"
                            "0\nLINE\n10\n0\n20\n1\n11\n1\n21\n0\n" TAIL);
    CHECK_INT(t.n, 3);                                     /* lines in any order, an open curve */
    CHECK_INT(t.closed, 0);
    lw_target_free(&t);
    t = read_drawn(lw_target_read_dxf, "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n5\n0\nENDSEC\n"
                  HEAD "0\nLINE\n10\n0\n20\n0\n11\n4\n21\n0\n" TAIL);
    CHECK_NEAR(t.x[1], 0.04, 1e-17, 0);
    CHECK_TEXT(t.units.length, "cm");
    lw_target_free(&t);
}

TEST(bulges_and_arcs)
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

/* ---- shapes, against their equations --------------------------------------------------------------------------- */

/* Largest value of (a x + c y + e)^2 + (b x + d y + f)^2 - 1 over the stations [mm]: 0 on an ellipse whose map to the
 * unit circle is m. */
static double off_ellipse(const lw_target *t, const double m[6])
{
    double most = 0;
    for (size_t i = 0; i < t->n; i++) {
        double x = 1e3*t->x[i], y = 1e3*t->y[i];
        most = fmax(most, fabs(hypot(m[0]*x + m[2]*y + m[4], m[1]*x + m[3]*y + m[5]) - 1));
    }
    return most;
}

/* The map of an ellipse to the unit circle: half axes a, b; its first axis turned by angle; centre x, y. */
static void ellipse_map(double a, double b, double angle, double x, double y, double m[6])
{
    double c = cos(angle), s = sin(angle);
    m[0] = c/a;
    m[1] = -s/b;
    m[2] = s/a;
    m[3] = c/b;
    m[4] = -m[0]*x - m[2]*y;
    m[5] = -m[1]*x - m[3]*y;
}

TEST(round_shapes)
{
    static const struct { const char *text; double a, b, degrees, x, y; } svg[] = {
        { "<svg><circle cx='7' cy='3' r='2'/></svg>", 2, 2, 0, 7, -3 },
        { "<svg><ellipse cx='-7' cy='30' rx='20' ry='5'/></svg>", 20, 5, 0, -7, -30 },
        { "<svg><ellipse cx='4' rx='20' ry='5' transform='translate(10,-2) rotate(30)'/></svg>", 20, 5, -30,
          10 + 3.4641016151377544, 0 },
        { "<svg><g transform='scale(2,.5)'><g transform='matrix(0 1 -1 0 3 4)'><circle r='8'/></g></g></svg>", 16, 4, 0,
          6, -2 },
        { "<svg width='100mm' height='50mm' viewBox='0 0 1000 500'><circle cx='70' cy='30' r='20'/></svg>", 2, 2, 0,
          7, -3 },
        { "<svg width='96px' height='192' viewBox='0 0 50.8 50.8'><circle r='20'/></svg>", 10, 10, 0, 0, -12.7 },
        { "<svg width='96px' height='100%' viewBox='0 0 50.8 50.8'><circle r='20'/></svg>", 10, 10, 0, 0, 0 },
        { "<svg width='2in'><circle r='96'/></svg>", 25.4, 25.4, 0, 0, 0 },
        /* another shape of the page than of the view box; places as Chromium's getScreenCTM has them */
        { "<svg width='200mm' height='100mm' viewBox='0 0 100 100'><circle cx='50' cy='50' r='20'/></svg>", 20, 20, 0, 100, -50 },
        { "<svg width='20mm' height='60mm' viewBox='0 0 10 10'><circle cx='5' cy='2' r='1'/></svg>", 2, 2, 0, 10, -24 },
        { "<svg width='20mm' height='60mm' viewBox='0 0 10 10' preserveAspectRatio='xMinYMax'><circle r='1'/></svg>", 2, 2, 0, 0, -40 },
        { "<svg width='20mm' height='60mm' viewBox='0 0 10 10' preserveAspectRatio='xMidYMid slice'><circle r='1'/></svg>", 6, 6, 0, -20, 0 },
        { "<svg><svg width='20' height='60' viewBox='5 5 10 10' preserveAspectRatio='xMaxYMin slice'><circle r='1'/></svg></svg>", 6, 6, 0,
          -70, 30 },
        { "<svg width='40mm' height='80mm'><circle r='1cm' cx='10mm'/></svg>", 10, 10, 0, 10, 0 },
        { "<svg width='10mm' height='40mm' viewBox='0 0 10 20' preserveAspectRatio='none'><circle r='2'/></svg>", 2,
          4, 0,
          0, 0 },
        { "<svg><svg x='5' y='1' width='20' height='20' viewBox='-1 -1 2 2'><circle r='1'/></svg></svg>", 10, 10, 0,
          15, -11 },
        { "<svg xmlns:xlink='x'><defs><circle id='c' r='3'/></defs><use xlink:href='#c' x='5' transform='scale(2)'/></svg>",
          6, 6, 0, 10, 0 },
        { "<svg><symbol id='s'><circle r='3'/></symbol><use href='#s' x='5' y='5'/></svg>", 3, 3, 0, 5, -5 },
        { "<svg viewBox='0 0 100 100'><symbol id='s' viewBox='0 0 10 10'><circle cx='5' cy='5' r='5'/></symbol><use href='#s' x='10' y='10' "
          "width='40' height='40'/></svg>", 20, 20, 0, 30, -30 },
        { "<svg viewBox='0 0 100 100'><symbol id='s' viewBox='0 0 10 10'><circle cx='5' cy='5' r='5'/></symbol><use href='#s'/></svg>",
          50, 50, 0, 50, -50 },
        { "<svg viewBox='0 0 100 100'><svg x='10' width='50%' height='25%' viewBox='0 0 10 10'><circle cx='5' cy='5' r='5'/></svg></svg>",
          12.5, 12.5, 0, 35, -12.5 },
        { "<svg:svg><svg:path d='M3&#10;0A3 3 0 1 1-3,0&#xA;A3 3 0 1 1 3 0z'/></svg:svg>", 3, 3, 0, 0, 0 },
        { "<!-- Generator: Adobe Illustrator 25.0 --><svg viewBox='0 0 72 72'><circle r='72'/></svg>", 25.4, 25.4, 0,
          0, 0 }
    };
    static const struct { const char *text; double a, b, degrees, x, y; } dxf[] = {
        { HEAD "0\nELLIPSE\n10\n3\n20\n4\n11\n0\n21\n10\n40\n0.5\n41\n0\n42\n6.283185307179586\n" TAIL, 10, 5, 90, 3,
          4 },
        { HEAD "0\nELLIPSE\n10\n3\n20\n4\n11\n6\n21\n8\n40\n0.25\n41\n1\n42\n5\n0\nELLIPSE\n10\n3\n20\n4\n11\n6\n"
          "21\n8\n"
          "40\n0.25\n41\n5\n42\n1\n" TAIL, 10, 2.5, 53.13010235415598, 3, 4 },
        { HEAD "0\nCIRCLE\n10\n3\n20\n4\n40\n5\n230\n-1\n" TAIL, 5, 5, 0, -3, 4 },
        { "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nWheel\n10\n1\n20\n1\n0\nCIRCLE\n10\n1\n20\n1\n40\n2\n0\nENDBLK\n0\n"
          "ENDSEC\n"
          HEAD "0\nINSERT\n2\nWHEEL\n10\n10\n20\n20\n41\n3\n42\n-1\n50\n30\n" TAIL, 6, 2, 30, 10, 20 },
        { "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nA\n0\nARC\n10\n1\n40\n2\n50\n10\n51\n200\n0\nARC\n10\n1\n40\n2\n50\n"
          "200\n51\n10\n0\n"
          "ENDBLK\n0\nBLOCK\n2\nB\n10\n0\n20\n5\n0\nINSERT\n2\nA\n20\n5\n50\n90\n0\nENDBLK\n0\nENDSEC\n"
          HEAD "0\nINSERT\n2\nB\n10\n7\n20\n0\n41\n2\n42\n2\n" TAIL, 4, 4, 0, 7, 2 },
        /* a circle as a rational spline of degree 2 (Piegl & Tiller 1997, section 7.5) */
        { HEAD "0\nSPLINE\n70\n11\n71\n2\n72\n12\n73\n9\n40\n0\n40\n0\n40\n0\n40\n1\n40\n1\n40\n2\n40\n2\n40\n3\n"
          "40\n3\n40\n4\n40\n4\n40\n4\n"
          "41\n1\n41\n.7071067811865476\n41\n1\n41\n.7071067811865476\n41\n1\n41\n.7071067811865476\n41\n1\n41\n"
            ".7071067811865476\n41\n1\n"
          "10\n5\n20\n0\n10\n5\n20\n5\n10\n0\n20\n5\n10\n-5\n20\n5\n10\n-5\n20\n0\n10\n-5\n20\n-5\n10\n0\n20\n-5\n"
            "10\n5\n20\n-5\n"
          "10\n5\n20\n0\n" TAIL, 5, 5, 0, 0, 0 }
    };
    double m[6];
    for (size_t i = 0; i < sizeof svg/sizeof *svg; i++) {
        OWN(lw_target) t = read_text(lw_target_read_svg, svg[i].text);
        ellipse_map(svg[i].a, svg[i].b, svg[i].degrees*LW_PI/180, svg[i].x, svg[i].y, m);
        CHECK_NEAR(off_ellipse(&t, m), 0, 3.1e-4, 0);
        CHECK_INT(t.closed, 1);
        CHECK_INT(t.n, LW_OUTLINE_STATIONS);
    }
    for (size_t i = 0; i < sizeof dxf/sizeof *dxf; i++) {
        OWN(lw_target) t = read_text(lw_target_read_dxf, dxf[i].text);
        ellipse_map(dxf[i].a, dxf[i].b, dxf[i].degrees*LW_PI/180, dxf[i].x, dxf[i].y, m);
        CHECK_NEAR(off_ellipse(&t, m), 0, 3.1e-4, 0);
        CHECK_INT(t.closed, 1);
        CHECK_INT(t.n, LW_OUTLINE_STATIONS);
    }
}

/* A cubic spline with one inner knot, against the recursion of its basis functions (Cox, de Boor). */
static double basis(const double *knot, int i, int degree, double u)
{
    if (degree == 0)
        return u >= knot[i] && (u < knot[i+1] || (u == 5 && knot[i+1] == 5 && knot[i] < 5));
    double a = knot[i + degree] - knot[i], b = knot[i + degree + 1] - knot[i+1];
    return (a > 0 ? (u - knot[i])/a*basis(knot, i, degree - 1, u) : 0)
         + (b > 0 ? (knot[i + degree + 1] - u)/b*basis(knot, i + 1, degree - 1, u) : 0);
}

TEST(splines)
{
    static const double knot[] = { 0, 0, 0, 0, 2, 5, 5, 5, 5 }, x[] = { 0, 3, 8, 9, 4 }, y[] = { 0, 6, 7, -2, -3 };
    char text[1024];
    int n = snprintf(text, sizeof text, HEAD "0\nSPLINE\n8\nPATH\n70\n8\n71\n3\n");
    for (int i = 0; i < 9; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "40\n%g\n", knot[i]);
    for (int i = 0; i < 5; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "10\n%g\n20\n%g\n30\n0\n", x[i], y[i]);
    snprintf(text + n, sizeof text - (size_t)n, TAIL);
    OWN(lw_target) t = read_text(lw_target_read_dxf, text);
    CHECK_INT(t.closed, 0);
    CHECK_HAS(t.note, "open curve 'PATH'");
    for (size_t k = 0; k < t.n; k++) {
        double least = INFINITY;
        for (int i = 0; i <= 20000; i++) {
            double p = 0, q = 0;
            for (int b = 0; b < 5 && (i % 20 == 0 || least < 0.05); b++) {
                double w = basis(knot, b, 3, 5*i/20000.0);
                p += w*x[b];
                q += w*y[b];
            }
            if (i % 20 == 0 || least < 0.05)
                least = fmin(least, hypot(1e3*t.x[k] - p, 1e3*t.y[k] - q));
        }
        CHECK_NEAR(least, 0, 2e-3, 0);
    }
}

/* A spline of a DXF through n points at equal angles of a circle of radius 10, `turns` of it. */
static lw_target fit_arc(int n, double turns, const char *more)
{
    char text[4096];
    int at = snprintf(text, sizeof text, HEAD "0\nSPLINE\n71\n3\n74\n%d\n%s", n, more);
    for (int i = 0; i < n; i++) {
        double a = 2*LW_PI*turns*i/(n - 1);
        at += snprintf(text + at, sizeof text - (size_t)at, "11\n%.15g\n21\n%.15g\n31\n0\n", 10*cos(a), 10*sin(a));
    }
    snprintf(text + at, sizeof text - (size_t)at, TAIL);
    return read_text(lw_target_read_dxf, text);
}

/* How far the stations are from that circle. */
static double off_circle(const lw_target *t)
{
    double off = 0;
    for (size_t k = 0; k < t->n; k++)
        off = fmax(off, fabs(hypot(1e3*t->x[k], 1e3*t->y[k]) - 10));
    return off;
}

/* Cubic splines leave a circle by h^4/384 if their ends are right (de Boor 2001), by some h^2/40 if these are natural.  Given directions
 * count as slopes of 1 over the chords, which are shorter than the arcs by h^2/24: that is as much again. */
TEST(splines_through_fit_points)
{
    double h = LW_PI/8;
    OWN(lw_target) round = fit_arc(17, 1, "70\n1\n"), half = fit_arc(9, 0.5, "12\n0\n22\n3\n13\n0\n23\n-3\n"), bare = fit_arc(9, 0.5, "");
    CHECK_INT(round.closed, 1);
    CHECK_INT(half.closed + bare.closed, 0);
    CHECK(off_circle(&round) < 10*pow(h, 4)/384*1.5 + 3e-4);
    CHECK(off_circle(&half) < 10*pow(h, 4)/384*3);
    CHECK(off_circle(&bare) > 10*h*h/100 && off_circle(&bare) < 10*h*h/20);
    /* three points with equal chords: half-way up the natural spline is at (1.5, 2.75) */
    OWN(lw_target) t = read_text(lw_target_read_dxf, HEAD "0\nSPLINE\n71\n3\n11\n0\n21\n0\n11\n0\n21\n0\n11\n3\n21\n4\n11\n6\n21\n0\n" TAIL);
    double least = INFINITY;
    for (size_t k = 1; k < t.n; k++)
        least = lw_v2_nearer(lw_v2(1.5e-3, 2.75e-3), lw_v2(t.x[k-1], t.y[k-1]), lw_v2(t.x[k], t.y[k]), least);
    CHECK_NEAR(1e3*least, 0, 2e-3, 0);
}

TEST(straight_shapes)
{
    static const double rect[][2] = { { 1, -2 }, { 11, -2 }, { 11, -7 }, { 1, -7 } }, line[][2] = { { 1, -2 }, { 4,
        -6 } };
    lw_target t = read_drawn(lw_target_read_svg, "<svg><rect width='100%' height='100%'/><rect x='1' y='2' width='10' height='5'/></svg>");
    stations(&t, 1, rect, 4, 1e-3);
    lw_target_free(&t);
    t = read_drawn(lw_target_read_svg, "<svg><line x1='1' y1='2' x2='4' y2='6'/></svg>");
    stations(&t, 0, line, 2, 1e-3);
    lw_target_free(&t);
    t = read_text(lw_target_read_svg, "<svg><rect x='-10' y='-6' width='20' height='12' rx='4' ry='2'/></svg>");
    for (size_t i = 0; i < t.n; i++) {                          /* its corners are quarters of ellipses */
        double x = fabs(1e3*t.x[i]), y = fabs(1e3*t.y[i]);
        bool corner = x > 6 && y > 4;
        CHECK_NEAR(corner ? hypot((x - 6)/4, (y - 4)/2) : fmax(x/10, y/6), 1, 1e-4, 0);
    }
    lw_target_free(&t);
}

/* What is not seen is no target. */
TEST(hidden_shapes)
{
    static const char *const svg[] = {
        "<svg><g style='display:none'><circle r='1'/></g><circle r='5'/></svg>",
        "<svg><g style='fill:none; display : none'><circle r='1'/></g><circle r='5'/></svg>",
        "<svg><style>.a{fill:red}.st1,.st0{display:none;}</style><g class='x st0'><circle r='1'/></g><circle class='a' r='5'/></svg>",
        "<svg><style><![CDATA[ .st10 { display:none } ]]></style><circle class='st1' r='5'/><circle class='st10' r='1'/></svg>",
        "<svg><defs><circle r='1'/></defs><clipPath><rect width='3' height='3'/></clipPath><circle r='5'/></svg>",
        "<svg><circle r='1' display='none'/><circle r='5'/><circle r='2' visibility='hidden'/></svg>",
        "<svg><metadata><a><b>M 0 0</b></a></metadata><sodipodi:namedview><inkscape:grid/></sodipodi:namedview><circle r='5'/></svg>"
    };
    static const char *const dxf[] = {
        HEAD "0\nCIRCLE\n8\nDefpoints\n40\n1\n0\nCIRCLE\n40\n5\n0\nCIRCLE\n67\n1\n40\n2\n0\nCIRCLE\n60\n1\n40\n3\n"
          "" TAIL,
        "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n2\n0\nLAYER\n2\nFrozen\n70\n1\n62\n7\n0\nLAYER\n2\nOff\n70\n"
          "0\n62\n-3\n"
        "0\nLAYER\n2\nOn\n70\n0\n62\n3\n0\nENDTAB\n0\nENDSEC\n"
        HEAD "0\nCIRCLE\n8\nFROZEN\n40\n1\n0\nCIRCLE\n8\nOn\n40\n5\n0\nCIRCLE\n8\nOff\n40\n2\n0\nTEXT\n1\nabc\n40\n"
          "9\n" TAIL
    };
    for (size_t i = 0; i < sizeof svg/sizeof *svg; i++) {
        lw_target t = read_text(lw_target_read_svg, svg[i]);
        circle(&t, 0, 0, 5e-3);
    }
    for (size_t i = 0; i < sizeof dxf/sizeof *dxf; i++) {
        lw_target t = read_text(lw_target_read_dxf, dxf[i]);
        circle(&t, 0, 0, 5e-3);
    }
}

/* ---- several curves ---------------------------------------------------------------------------------------------- */

static const char three[] = "<svg xmlns:inkscape='i'><g inkscape:label='Foot path'><path id='p1' inkscape:label='toe' "
    "d='M0 0L10 0L10 10L0 10z'/><circle id='heel' r='3' cx='20'/></g><path id='p3' d='M0 0L5 5'/></svg>";

TEST(curves_by_name)
{
    static const struct { const char *name; size_t n_also; double size; } rows[] = {
        { "1", 0, 14.142 }, { "toe", 0, 14.142 }, { "P1", 0, 14.142 }, { "heel", 0, 8.485 }, { "3", 0, 7.0711 },
        { "Foot path", 1, 14.142 }, { "2,1", 1, 8.485 }, { "heel,toe", 1, 8.485 }
    };
    lw_error e = { .text = "" };
    lw_target t;
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        t = read_with(lw_target_read_svg, three, &(lw_target_options){ .closed = -1, .curve = rows[i].name });
        CHECK_INT(t.n_also, rows[i].n_also);
        CHECK_NEAR(1e3*t.size, rows[i].size, 2e-2, 0);
        lw_target_free(&t);
    }
    lw_target_options o = { .closed = -1, .curve = "toes" };
    CHECK_INT(lw_target_read_svg(three, strlen(three), "t", &o, &t, &e), LW_E_ARG);
    CHECK_HAS(e.text, "no curve 'toes' in this drawing; it has 1 'toe' closed 40 mm, 2 'heel' closed");
    o.curve = "all";                                                    /* two closed, one open */
    CHECK_INT(lw_target_read_svg(three, strlen(three), "t", &o, &t, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "closed and one open");
    o.curve = "";
    CHECK_INT(lw_target_read_svg(three, strlen(three), "t", &o, &t, &e), LW_E_ARG);
    CHECK_INT(lw_target_read_svg(three, strlen(three), "t", NULL, &t, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "FILE#1,2");
}

/* Pieces join where two ends meet, not where three do, and only within a layer. */
TEST(pieces_join)
{
    static const struct { const char *text; int curves; } rows[] = {
        { "0\nLINE\n11\n5\n0\nLINE\n10\n5\n11\n5\n21\n5\n", 1 },
        { "0\nLINE\n11\n5\n0\nLINE\n10\n5\n11\n5\n21\n5\n0\nLINE\n10\n5\n11\n9\n", 3 },
        { "0\nLINE\n11\n5\n0\nLINE\n8\nB\n10\n5\n11\n5\n21\n5\n", 2 },
        { "0\nLINE\n11\n5\n0\nLINE\n10\n5.00001\n11\n5\n21\n5\n", 1 },
        { "0\nLINE\n21\n-19\n0\nARC\n10\n2\n20\n-9.5\n40\n9.70824\n50\n258.11\n51\n101.89\n", 1 },    /* ends apart by 1e-5 of it */
        { "0\nLINE\n11\n5\n0\nLWPOLYLINE\n10\n5\n20\n0\n10\n5\n20\n3\n10\n8\n20\n3\n0\nARC\n10\n8\n20\n4\n40\n1\n"
          "50\n270\n51\n0\n", 1 }
    };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        char text[512], want[32];
        lw_error e = { .text = "" };
        OWN(lw_target) t = { 0 };
        snprintf(text, sizeof text, HEAD "%s" TAIL, rows[i].text);
        snprintf(want, sizeof want, "has %d curves", rows[i].curves);
        lw_status s = lw_target_read_dxf(text, strlen(text), "t", NULL, &t, &e);
        CHECK_INT(s, rows[i].curves == 1 ? LW_OK : LW_E_NOTATION);
        CHECK_HAS(rows[i].curves == 1 ? want : e.text, want);
    }
}

TEST(points_are_stations)
{
    static const double want[][2] = { { 3, 4 }, { 0, 0 }, { 7, -1 } };
    lw_target t = read_text(lw_target_read_dxf, HEAD "0\nPOINT\n10\n3\n20\n4\n0\nPOINT\n10\n0\n20\n0\n0\nPOINT\n10\n"
      "7\n20\n-1\n"
                            TAIL);
    stations(&t, 0, want, 3, 1e-3);                             /* open by the rule of tables */
    lw_target_free(&t);
}

/* ---- files as programs write them -------------------------------------------------------------------------------- */

/* examples/drawings; the lengths of slot, step and ellipse are worked out by hand (Ramanujan's formula), those of the
 * curves from Bernstein polynomials and the uniform cubic B-spline. Chords between stations are shorter. */
TEST(example_drawings)
{
    double r = 40*sqrt(2) + 10, slot = 2*(60 + 10*LW_PI), step = 80 + 2*10*0.75*LW_PI + r*LW_PI/2;
    const struct { const char *path; int n_also; double length; } rows[] = {
        { "slot-autocad.dxf", 0, slot }, { "step-librecad.dxf", 0, step }, { "loop-freecad.dxf", 0, 263.11 },
        { "foot-inkscape.svg", 0, 161.01 }, { "foot-inkscape.svg#step", 0, 161.01 }, { "foot-inkscape.svg#foot", 0,
            161.01 },
        { "heart-illustrator.svg", 0, 185.02 }, { "pair-inkscape.svg#left", 0, 94.411 }, { "pair-inkscape.svg#all",
            1, 94.411 },
        { "pair-inkscape.svg#hooks", 1, 94.411 }
    };
    lw_target t;
    lw_error e = { .text = "" };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++) {
        char path[128];
        snprintf(path, sizeof path, "examples/drawings/%s", rows[i].path);
        CHECK_INT(lw_target_read_file(path, NULL, &t, &e), LW_OK);
        CHECK_TEXT(e.text, "");
        CHECK_INT(t.n, LW_OUTLINE_STATIONS);
        CHECK_INT(t.closed, 1);
        CHECK_INT(t.n_also, rows[i].n_also);
        CHECK_NEAR(1e3*t.length, rows[i].length, 0, 2e-3);
        CHECK_TEXT(t.units.length, "mm");
        lw_target_free(&t);
    }
    CHECK_INT(lw_target_read_file("examples/drawings/measured-excel.csv", NULL, &t, &e), LW_OK);
    CHECK_INT(t.n, 90);
    CHECK_NEAR(t.x[0], 0.13114, 2e-3, 0);
    lw_target_free(&t);
    CHECK_INT(lw_target_read_file("examples/drawings/pair-inkscape.svg", NULL, &t, &e), LW_E_NOTATION);
    CHECK_INT(lw_target_read_file("examples/drawings/pair-inkscape.svg#middle", NULL, &t, &e), LW_E_ARG);
    CHECK_INT(lw_target_read_file("examples/ellipse.csv#a", NULL, &t, &e), LW_E_ARG);
}

/* ---- faults ------------------------------------------------------------------------------------------------ */

TEST(faults)
{
    static const struct { reader *read; const char *text; int line, column; const char *why; } rows[] = {
        { lw_target_read_svg, "", 1, 1, "there is no visible path" },
        { lw_target_read_svg, "<svg><rect width='3'/><text>a</text></svg>", 1, 1, "convert text to paths" },
        { lw_target_read_svg, "<svg>\n<path d='L 1 1'/></svg>", 2, 10, "begins with M" },
        { lw_target_read_svg, "<svg><path d='M 1 x'/></svg>", 1, 19, "a number is expected" },
        { lw_target_read_svg, "<svg><path d='M 1 1 B 3'/></svg>", 1, 21, "one of M L" },
        { lw_target_read_svg, "<svg><path id='a' d='M 1 1 2 2 M 3 3\n4 4'/></svg>", 1, 1,
          "1 'a' open 1.4142 mm, 2 'a'" },
        { lw_target_read_svg, "<svg><path d='M 1 1A1 1 0 2 0 3 3'/></svg>", 1, 27, "a flag of an arc" },
        { lw_target_read_svg, "<svg><path d='M 1 1L1e999 0'/></svg>", 1, 21, "a number is expected" },
        { lw_target_read_svg, "<svg><path d='M 1 1L1e200 0'/></svg>", 1, 1, "too far away" },
        { lw_target_read_svg, "<svg><path d='M 1 1L2 0", 1, 15, "has no end" },
        { lw_target_read_svg, "<svg><g><path d='M 1 1L2 0'/></g>", 1, 34, "ends before the end of its elements" },
        { lw_target_read_svg, "<svg><g transform='turn(3)'>", 1, 20, "a transform is" },
        { lw_target_read_svg, "<svg><path d=3/></svg>", 1, 15, "a quote is expected" },
        { lw_target_read_dxf, "", 1, 1, "no visible line, arc" },
        { lw_target_read_dxf, "x,y\n1,2\n", 1, 1, "no DXF text" },
        { lw_target_read_dxf, HEAD "0\nLINE\n10\nab\n" TAIL, 8, 1, "a number is expected" },
        { lw_target_read_dxf, HEAD "0\nLINE\n10\n0\n11\n1\n", 11, 1, "ends within its ENTITIES" },
        { lw_target_read_dxf, HEAD "0\nLINE\n10\n0\n11\n1\n0\nLINE\n10\n5\n11\n6\n" TAIL, 12, 1,
          "has 2 curves: 1 open 1 mm, 2 open 1 mm" }
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

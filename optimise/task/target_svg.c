/* optimise/task/target_svg.c - read the curves of an SVG file (SVG 1.1: chapters 7 to 9).
 *
 * The tags are read here and not by a library, because libxml2 and expat know the place of an element only; this
 * reader names the line and column of a wrong number inside a path. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "grammar/text/text_internal.h"
#include "optimise/task/target_outline_internal.h"

#define DEPTH_MAX 64
#define CLONE_MAX 64                   /* <use> elements in a file                                    */
#define STYLE_MAX 8
#define PIXEL     (25.4/96)            /* [mm]                                                        */

typedef lw_affine matrix;

/* The attributes that are read. */
#define ATTRIBUTES(X) \
    X(D, "d") X(POINTS, "points") X(TRANSFORM, "transform") X(ORIGIN, "transform-origin") X(WIDTH, "width") \
    X(HEIGHT, "height") X(VIEW, "viewBox") X(ASPECT, "preserveAspectRatio") X(X, "x") X(Y, "y") X(X1, "x1") \
    X(Y1, "y1") X(X2, "x2") X(Y2, "y2") X(CX, "cx") X(CY, "cy") X(R, "r") X(RX, "rx") X(RY, "ry") X(ID, "id") \
    X(LABEL, "inkscape:label") X(DATA_NAME, "data-name") X(TRACER, "data-tracer") X(VERSION, "inkscape:version") \
    X(STYLE, "style") X(DISPLAY, "display") X(VISIBILITY, "visibility") X(CLASS, "class") X(HREF, "href") \
    X(XLINK, "xlink:href")
enum {
#define X(key, name) ATTRIBUTE_##key,
    ATTRIBUTES(X)
#undef X
    ATTRIBUTE_COUNT
};

typedef struct element {
    char      name[24];
    lw_cursor at;
    lw_cursor value[ATTRIBUTE_COUNT];               /* text NULL: missing; size: end of the value        */
    bool      ends, empty;                          /* </x>, <x/>                                        */
} element;

/* An open element. */
typedef struct level { matrix m; bool hidden; char group[48]; double window[2]; } level;

typedef struct reader {
    lw_cursor  c;                      /* the whole file                                              */
    lw_outlines out;
    lw_cursor  style[STYLE_MAX];       /* style sheets                                                */
    int        n_style, clones;
    bool       illustrator, has_text, rooted;
} reader;

/* ---- numbers -------------------------------------------------------------------------------------------- */

/* Does the text begin with a line end or blank that is written as &#10; or &#xA;? */
static bool begins_blank(const lw_cursor *c)
{
    static const char *const rows[] = { "&#10;", "&#xA;", "&#xa;", "&#13;", "&#xD;", "&#9;", "&#x9;", "&#32;",
                                        "&#x20;" };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (lw_cursor_begins(c, rows[i]))
            return true;
    return false;
}

static void skip_space(lw_cursor *c, bool comma)
{
    for (;; lw_cursor_next(c)) {
        int byte = lw_cursor_peek(c);
        if (byte == ',' && comma)
            comma = false;
        else if (byte == '&' && begins_blank(c))
            lw_cursor_step(c, (size_t)((const char *)memchr(c->text + c->at, ';', 6) - (c->text + c->at)));
        else if (byte != ' ' && byte != '\t' && byte != '\n' && byte != '\r')
            return;
    }
}

static bool begins_number(int byte)
{
    return (byte >= '0' && byte <= '9') || byte == '.' || byte == '-' || byte == '+';
}

static void skip_digits(lw_cursor *c)
{
    while (lw_cursor_peek(c) >= '0' && lw_cursor_peek(c) <= '9')
        lw_cursor_next(c);
}

/* Read a number. "1.5-2.25.5e3" is three numbers: each ends where it cannot continue. */
static lw_status take_number(lw_cursor *c, double *v)
{
    skip_space(c, true);
    lw_cursor start = *c;
    if (lw_cursor_peek(c) == '-' || lw_cursor_peek(c) == '+')
        lw_cursor_next(c);
    skip_digits(c);
    if (lw_cursor_peek(c) == '.') {
        lw_cursor_next(c);
        skip_digits(c);
    }
    lw_cursor ahead = *c;
    if (lw_cursor_peek(&ahead) == 'e' || lw_cursor_peek(&ahead) == 'E') {
        lw_cursor_next(&ahead);
        if (lw_cursor_peek(&ahead) == '-' || lw_cursor_peek(&ahead) == '+')
            lw_cursor_next(&ahead);
        if (lw_cursor_peek(&ahead) >= '0' && lw_cursor_peek(&ahead) <= '9') {
            skip_digits(&ahead);
            *c = ahead;
        }
    }
    const char *s = start.text + start.at;
    size_t skip = c->at > start.at && *s == '+';
    return lw_number_parse(s + skip, c->at - start.at - skip, v) == LW_OK ? LW_OK
         : lw_cursor_fail(&start, "a number is expected here");
}

static lw_status take_numbers(lw_cursor *c, double *v, int n)
{
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < n; i++)
        s = take_number(c, &v[i]);
    return s;
}

/* Read a flag, 0 or 1; flags need no separator. */
static lw_status take_flag(lw_cursor *c, bool *flag)
{
    skip_space(c, true);
    int byte = lw_cursor_peek(c);
    if (byte != '0' && byte != '1')
        return lw_cursor_fail(c, "a flag of an arc is 0 or 1");
    *flag = lw_cursor_next(c) == '1';
    return LW_OK;
}

/* ---- path data -------------------------------------------------------------------------------------------- */

typedef struct pen {
    lw_outlines *out;
    const char *name, *label, *group;  /* of its curves                                           */
    matrix      m;
    lw_vec2     at, start, handle;     /* current point, start of the subpath, last control point  */
    int         last;                  /* command, in capitals; 0: none                            */
    bool        drawing;               /* a curve is begun                                         */
} pen;

/* Point on the page, with y up. */
static lw_vec2 on_page(const matrix *m, lw_vec2 p)
{
    p = lw_affine_point(m, p);
    return lw_v2(p.x, -p.y);
}

static void mark(pen *p, lw_vec2 q, long line) { lw_outlines_add(p->out, on_page(&p->m, q), line); }

static void begin_curve(pen *p, lw_vec2 at, long line)
{
    lw_outlines_begin(p->out, p->name, p->label, p->group);
    p->at = p->start = at;
    p->drawing = true;
    mark(p, at, line);
}

static void line_to(pen *p, lw_vec2 q, long line)
{
    mark(p, q, line);
    p->at = q;
}

static void bezier(pen *p, lw_vec2 b, lw_vec2 c, lw_vec2 d, long line)
{
    lw_vec2 a = p->at;
    for (int i = 1; i < LW_OUTLINE_ARCS; i++) {
        double t = (double)i/LW_OUTLINE_ARCS, s = 1 - t, w[4] = { s*s*s, 3*s*s*t, 3*s*t*t, t*t*t };
        mark(p, lw_v2(w[0]*a.x + w[1]*b.x + w[2]*c.x + w[3]*d.x, w[0]*a.y + w[1]*b.y + w[2]*c.y + w[3]*d.y), line);
    }
    line_to(p, d, line);
}

/* Convert an arc from end points to its centre (SVG 1.1, F.6.5); radii that are too short are enlarged. */
static void arc_to(pen *p, lw_vec2 r, double turn, bool large, bool sweep, lw_vec2 to, long line)
{
    lw_vec2 u = lw_v2_polar(1, turn), h = lw_v2_unturn(lw_v2_scale(lw_v2_sub(p->at, to), 0.5), u), start = p->at;
    r = lw_v2(fabs(r.x), fabs(r.y));
    if (!(r.x > 0 && r.y > 0) || (h.x == 0 && h.y == 0)) {
        line_to(p, to, line);
        return;
    }
    double over = h.x*h.x/(r.x*r.x) + h.y*h.y/(r.y*r.y);
    r = lw_v2_scale(r, fmax(1, sqrt(over)));
    over = fmin(over, 1);
    double k = (large == sweep ? -1 : 1)*sqrt(fmax(0, 1/over - 1));
    lw_vec2 c = lw_v2(k*r.x*h.y/r.y, -k*r.y*h.x/r.x);
    double t0 = atan2((h.y - c.y)/r.y, (h.x - c.x)/r.x), t1 = atan2((-h.y - c.y)/r.y, (-h.x - c.x)/r.x), d = t1 - t0;
    d += sweep && d < 0 ? 2*LW_PI : !sweep && d > 0 ? -2*LW_PI : 0;
    lw_vec2 middle = lw_v2_scale(lw_v2_add(start, to), 0.5);
    for (int i = 1; i < LW_OUTLINE_ARCS; i++) {
        double t = t0 + d*i/LW_OUTLINE_ARCS;
        mark(p, lw_v2_add(middle, lw_v2_turn(lw_v2(c.x + r.x*cos(t), c.y + r.y*sin(t)), u)), line);
    }
    line_to(p, to, line);
}

static lw_status take_point(lw_cursor *c, lw_vec2 base, lw_vec2 *q)
{
    double v[2];
    lw_status s = take_numbers(c, v, 2);
    *q = lw_v2_add(base, lw_v2(v[0], v[1]));
    return s;
}

static lw_status do_curve(lw_cursor *c, pen *p, int command, lw_vec2 base, long line)
{
    bool cubic = command == 'C' || command == 'S', smooth = command == 'S' || command == 'T';
    bool follows = cubic ? p->last == 'C' || p->last == 'S' : p->last == 'Q' || p->last == 'T';
    lw_vec2 b = follows ? lw_v2_sub(lw_v2_scale(p->at, 2), p->handle) : p->at, d = p->at, to = p->at;
    lw_status s = smooth ? LW_OK : take_point(c, base, &b);
    if (s == LW_OK && cubic)
        s = take_point(c, base, &d);
    if (s == LW_OK)
        s = take_point(c, base, &to);
    if (s != LW_OK)
        return s;
    p->handle = cubic ? d : b;
    if (!cubic) {                              /* replace it by the equal cubic curve */
        d = lw_v2_scale(lw_v2_add(to, lw_v2_scale(b, 2)), 1.0/3);
        b = lw_v2_scale(lw_v2_add(p->at, lw_v2_scale(b, 2)), 1.0/3);
    }
    bezier(p, b, d, to, line);
    return LW_OK;
}

static lw_status do_arc(lw_cursor *c, pen *p, lw_vec2 base, long line)
{
    double v[3];
    bool large = false, sweep = false;
    lw_vec2 to = p->at;
    lw_status s = take_numbers(c, v, 3);
    if (s == LW_OK)
        s = take_flag(c, &large);
    if (s == LW_OK)
        s = take_flag(c, &sweep);
    if (s == LW_OK)
        s = take_point(c, base, &to);
    if (s == LW_OK)
        arc_to(p, lw_v2(v[0], v[1]), v[2]*LW_PI/180, large, sweep, to, line);
    return s;
}

/* Read the numbers of one command; the caller has found the first one. */
static lw_status do_command(lw_cursor *c, pen *p, int command, bool relative)
{
    lw_vec2 base = relative ? p->at : lw_v2(0, 0), q = p->at;
    double v = 0;
    long line = c->line;
    lw_status s = LW_OK;
    switch (command) {
    case 'M':
        if ((s = take_point(c, base, &q)) == LW_OK)
            begin_curve(p, q, line);
        break;
    case 'L':
        if ((s = take_point(c, base, &q)) == LW_OK)
            line_to(p, q, line);
        break;
    case 'H':
    case 'V':
        if ((s = take_number(c, &v)) == LW_OK)
            line_to(p, command == 'H' ? lw_v2(base.x + v, p->at.y) : lw_v2(p->at.x, base.y + v), line);
        break;
    case 'A':
        s = do_arc(c, p, base, line);
        break;
    default:
        s = do_curve(c, p, command, base, line);
    }
    p->last = command;
    return s;
}

/* Read the curves of a path: each M begins one. */
static lw_status read_path(lw_cursor *c, pen *p)
{
    lw_status s = LW_OK;
    int command = 0;
    bool relative = false;
    char name[24];
    for (skip_space(c, false); s == LW_OK && lw_cursor_peek(c) >= 0; skip_space(c, command != 0)) {
        int byte = lw_cursor_peek(c);
        if (byte > 0 && strchr("MLHVCSQTAZmlhvcsqtaz", byte)) {
            relative = byte >= 'a';
            command = relative ? byte - 'a' + 'A' : byte;
            if (p->last == 0 && command != 'M')
                return lw_cursor_fail(c, "a path begins with M");
            lw_cursor_next(c);
            if (command == 'Z') {
                lw_outlines_close(p->out);
                p->at = p->start;
                p->drawing = false;
                p->last = command;
                continue;
            }
        } else if (command == 0 || command == 'Z' || !begins_number(byte)) {
            return lw_cursor_fail(c, "one of M L H V C S Q T A Z or a number is expected, not %s", lw_byte_name(byte, name));
        }
        if (command != 'M' && !p->drawing)             /* behind a Z the path goes on from where it began */
            begin_curve(p, p->at, c->line);
        s = do_command(c, p, command, relative);
        command = command == 'M' ? 'L' : command;
    }
    return s;
}

/* Read points="x,y x,y ...". */
static lw_status read_points(lw_cursor *c, pen *p)
{
    lw_status s = LW_OK;
    for (skip_space(c, false); s == LW_OK && lw_cursor_peek(c) >= 0; skip_space(c, false)) {
        lw_vec2 q;
        s = take_point(c, lw_v2(0, 0), &q);
        if (s == LW_OK && !p->drawing)
            begin_curve(p, q, c->line);
        else if (s == LW_OK)
            line_to(p, q, c->line);
    }
    return s;
}

/* ---- transforms --------------------------------------------------------------------------------------------- */

static lw_status make_transform(const lw_cursor *at, const char *name, const double *v, int n, matrix *m)
{
    double u = LW_PI/180;
    if (strcmp(name, "matrix") == 0 && n == 6)
        *m = (matrix){ v[0], v[1], v[2], v[3], v[4], v[5] };
    else if (strcmp(name, "translate") == 0 && (n == 1 || n == 2))
        *m = (matrix){ 1, 0, 0, 1, v[0], n == 2 ? v[1] : 0 };
    else if (strcmp(name, "scale") == 0 && (n == 1 || n == 2))
        *m = (matrix){ v[0], 0, 0, v[n - 1], 0, 0 };
    else if (strcmp(name, "rotate") == 0 && (n == 1 || n == 3)) {
        double c = cos(v[0]*u), s = sin(v[0]*u), x = n == 3 ? v[1] : 0, y = n == 3 ? v[2] : 0;
        *m = (matrix){ c, s, -s, c, x - c*x + s*y, y - s*x - c*y };
    } else if (strcmp(name, "skewX") == 0 && n == 1)
        *m = (matrix){ 1, 0, tan(v[0]*u), 1, 0, 0 };
    else if (strcmp(name, "skewY") == 0 && n == 1)
        *m = (matrix){ 1, tan(v[0]*u), 0, 1, 0, 0 };
    else
        return lw_cursor_fail(at, "a transform is matrix, translate, scale, rotate, skewX or skewY with its numbers");
    return LW_OK;
}

static lw_status read_transform(lw_cursor *c, matrix *m)
{
    for (skip_space(c, true); lw_cursor_peek(c) >= 0; skip_space(c, true)) {
        lw_cursor start = *c;
        char name[16];
        double v[6] = { 0 };
        size_t n = 0;
        int count = 0;
        matrix own = { 0 };
        for (int byte; (byte = lw_cursor_peek(c)) > ' ' && byte != '(' && n + 1 < sizeof name; lw_cursor_next(c))
            name[n++] = (char)byte;
        name[n] = 0;
        skip_space(c, false);
        if (lw_cursor_next(c) != '(')
            return lw_cursor_fail(&start, "a transform is a name and numbers in brackets");
        for (skip_space(c, false); lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != ')'; skip_space(c, false)) {
            if (count == 6)
                return lw_cursor_fail(c, "a transform has at most six numbers");
            lw_status s = take_number(c, &v[count++]);
            if (s != LW_OK)
                return s;
        }
        lw_cursor_next(c);
        lw_status s = make_transform(&start, name, v, count, &own);
        if (s != LW_OK)
            return s;
        *m = lw_affine_product(m, &own);
    }
    return LW_OK;
}

/* ---- elements ------------------------------------------------------------------------------------------------- */

static bool skip_past(lw_cursor *c, const char *what)
{
    while (c->at < c->size && !lw_cursor_begins(c, what))
        lw_cursor_next(c);
    bool found = c->at < c->size;
    lw_cursor_step(c, found ? strlen(what) : 0);
    return found;
}

static size_t take_name(lw_cursor *c, char *name, size_t size)
{
    size_t n = 0, all = 0;
    for (int byte; (byte = lw_cursor_peek(c)) > ' ' && !strchr("/>=<\"'", byte); lw_cursor_next(c), all++)
        if (n + 1 < size)
            name[n++] = (char)byte;
    name[n] = 0;
    return all;
}

static lw_status take_attribute(lw_cursor *c, element *el)
{
    static const char *const rows[] = {
#define X(key, name) name,
        ATTRIBUTES(X)
#undef X
    };
    char name[24];
    if (take_name(c, name, sizeof name) == 0)
        return lw_cursor_fail(c, "this is no SVG: an attribute is expected here");
    skip_space(c, false);
    if (lw_cursor_next(c) != '=')
        return lw_cursor_fail(c, "this is no SVG: '=' is expected behind '%s'", name);
    skip_space(c, false);
    int quote = lw_cursor_next(c);
    lw_cursor value = *c;
    if (quote != '"' && quote != '\'')
        return lw_cursor_fail(c, "this is no SVG: a quote is expected behind '%s='", name);
    while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != quote)
        lw_cursor_next(c);
    value.size = c->at;
    if (lw_cursor_next(c) < 0)
        return lw_cursor_fail(&value, "this is no SVG: the value of '%s' has no end", name);
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (strcmp(name, rows[i]) == 0)
            el->value[i] = value;
    return LW_OK;
}

/* Read the next tag; *found false at the end of the text. */
static lw_status take_element(lw_cursor *c, element *el, bool *found)
{
    *found = false;
    for (;;) {
        if (!skip_past(c, "<"))
            return LW_OK;
        const char *s = c->text + c->at;
        size_t left = c->size - c->at;
        if (left >= 3 && memcmp(s, "!--", 3) == 0)
            skip_past(c, "-->");
        else if (left >= 8 && memcmp(s, "![CDATA[", 8) == 0)
            skip_past(c, "]]>");
        else if (left >= 1 && (*s == '?' || *s == '!'))
            skip_past(c, ">");
        else
            break;
    }
    memset(el, 0, sizeof *el);
    el->at = *c;
    el->ends = lw_cursor_peek(c) == '/';
    if (el->ends)
        lw_cursor_next(c);
    if (take_name(c, el->name, sizeof el->name) == 0)
        return lw_cursor_fail(&el->at, "this is no SVG: a name is expected behind '<'");
    if (strncmp(el->name, "svg:", 4) == 0)
        memmove(el->name, el->name + 4, strlen(el->name + 4) + 1);
    lw_status s = LW_OK;
    for (skip_space(c, false); s == LW_OK; skip_space(c, false)) {
        int byte = lw_cursor_peek(c);
        if (byte == '>' || byte < 0)
            break;
        if (byte == '/') {
            el->empty = true;
            lw_cursor_next(c);
            continue;
        }
        s = take_attribute(c, el);
    }
    *found = s == LW_OK;
    return s;
}

/* ---- lengths -------------------------------------------------------------------------------------------------- */

/* A length in user units, px, or another unit (SVG 1.1, 7.10). *unit: size of the unit [mm]; 0: none is given. */
static lw_status take_length(lw_cursor *c, double *v, double *unit)
{
    static const struct { const char *unit; double mm; } rows[] = {
        { "mm", 1 }, { "cm", 10 }, { "in", 25.4 }, { "pt", 25.4/72 }, { "pc", 25.4/6 }, { "Q", 0.25 }, { "px", PIXEL }
    };
    lw_status s = take_number(c, v);
    *unit = 0;
    if (s != LW_OK)
        return s;
    skip_space(c, false);
    if (lw_cursor_peek(c) < 0)
        return LW_OK;
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (lw_cursor_begins(c, rows[i].unit)) {
            *unit = rows[i].mm;
            lw_cursor_step(c, strlen(rows[i].unit));
            return LW_OK;
        }
    return lw_cursor_fail(c, "a length is a number, alone or with mm, cm, in, pt, pc, Q or px");
}

static bool given(const element *el, int key) { return el->value[key].text != NULL; }

/* The value of an attribute in user units; `usual` if it is missing. */
static lw_status take_value(const element *el, int key, double usual, double *v)
{
    double unit;
    lw_cursor c = el->value[key];
    *v = usual;
    if (!c.text)
        return LW_OK;
    lw_status s = take_length(&c, v, &unit);
    *v *= unit > 0 ? unit/PIXEL : 1;
    return s;
}

static bool value_has(const element *el, int key, const char *word)
{
    lw_cursor c = el->value[key];
    for (size_t n = strlen(word); c.text && c.at + n <= c.size; c.at++)
        if (memcmp(c.text + c.at, word, n) == 0)
            return true;
    return false;
}

static void copy_value(const element *el, int key, char *out, size_t size)
{
    const lw_cursor *c = &el->value[key];
    snprintf(out, size, "%.*s", c->text ? (int)fmin((double)(c->size - c->at), 1000) : 0, c->text ? c->text + c->at : "");
}

/* A view box in a window of size[0] x size[1] (SVG 1.1, 7.8): how each axis is scaled, and how far the corner of the box then lies
 * from that of the window. */
static void fit_view(const element *el, const double size[2], const double view[4], double scale[2], double offset[2])
{
    static const char *const first[] = { "xMin", "YMin" }, *const last[] = { "xMax", "YMax" };
    double x = size[0]/view[2], y = size[1]/view[3], even = value_has(el, ATTRIBUTE_ASPECT, "slice") ? fmax(x, y) : fmin(x, y);
    bool uneven = value_has(el, ATTRIBUTE_ASPECT, "none");
    scale[0] = uneven ? x : even;
    scale[1] = uneven ? y : even;
    for (int i = 0; i < 2; i++) {
        double part = value_has(el, ATTRIBUTE_ASPECT, first[i]) ? 0 : value_has(el, ATTRIBUTE_ASPECT, last[i]) ? 1 : 0.5;
        offset[i] = part*(size[i] - scale[i]*view[2+i]);
    }
}

/* Size of the drawing's unit from width="120mm" height="80mm" viewBox="0 0 120 80" of the root, and where the drawing lies on the
 * page, whose corner keeps the coordinates of that of the view box. l->window: its size in its own units, 0 if it has none. Files of Illustrator count in points, those of Inkscape
 * before 0.92 in 1/90 inch, unless they say another size. */
static void read_scale(reader *r, const element *el, level *l)
{
    lw_error quiet;
    double v[2] = { 0, 0 }, unit[2] = { 0, 0 }, view[4] = { 0 }, scale[2] = { 0, 0 }, offset[2] = { 0, 0 };
    lw_cursor c;
    for (int i = 0; i < 2; i++) {
        c = el->value[i ? ATTRIBUTE_HEIGHT : ATTRIBUTE_WIDTH];
        c.e = &quiet;
        if (!c.text || take_length(&c, &v[i], &unit[i]) != LW_OK || !(v[i] > 0))
            v[i] = unit[i] = 0;
    }
    for (int i = 0; i < 2; i++)
        if (v[i] > 0 && unit[i] == 0 && unit[1-i] > 0)
            unit[i] = PIXEL;
    c = el->value[ATTRIBUTE_VIEW];
    c.e = &quiet;
    bool boxed = c.text && take_numbers(&c, view, 4) == LW_OK && view[2] > 0 && view[3] > 0, sized = unit[0] > 0 || unit[1] > 0;
    bool old = value_has(el, ATTRIBUTE_VERSION, "0.91") || value_has(el, ATTRIBUTE_VERSION, "0.48");
    double pixel = old ? 25.4/90 : r->illustrator ? 25.4/72 : PIXEL;
    for (int i = 0; i < 2; i++) {
        l->window[i] = boxed ? view[2+i] : v[i]*unit[i]/PIXEL;
        v[i] *= unit[i] == PIXEL ? pixel : unit[i];
    }
    if (boxed && sized) {
        double size[2] = { unit[0] > 0 ? v[0] : v[1]*view[2]/view[3], unit[1] > 0 ? v[1] : v[0]*view[3]/view[2] };
        fit_view(el, size, view, scale, offset);
    } else if (sized || old || r->illustrator) {
        scale[0] = scale[1] = pixel;
    }
    r->out.unit_given = scale[0] > 0;
    r->out.scale = scale[0] > 0 ? scale[0] : 1;
    if (scale[0] > 0)
        l->m = (matrix){ 1, 0, 0, scale[1]/scale[0], offset[0]/scale[0], offset[1]/scale[0] };
}

/* The width or height of a drawing in a drawing: without one, and in percent, it is that of the window around it. */
static lw_status take_part(const element *el, int key, double window, double *v)
{
    lw_cursor c = el->value[key];
    if (!value_has(el, key, "%"))
        return take_value(el, key, window, v);
    lw_status s = take_number(&c, v);
    *v *= window/100;
    return s;
}

/* A drawing in a drawing, or a symbol, is moved, and scaled to its width and height. */
static lw_status enter_inner(const element *el, level *l)
{
    double x, y, size[2], view[4] = { 0 }, scale[2] = { 1, 1 }, offset[2] = { 0, 0 };
    lw_cursor c = el->value[ATTRIBUTE_VIEW];
    lw_status s = take_value(el, ATTRIBUTE_X, 0, &x);
    if (s == LW_OK)
        s = take_value(el, ATTRIBUTE_Y, 0, &y);
    for (int i = 0; s == LW_OK && i < 2; i++)
        s = take_part(el, i ? ATTRIBUTE_HEIGHT : ATTRIBUTE_WIDTH, l->window[i], &size[i]);
    if (s == LW_OK && c.text)
        s = take_numbers(&c, view, 4);
    if (s != LW_OK)
        return s;
    bool fits = view[2] > 0 && view[3] > 0 && size[0] > 0 && size[1] > 0;
    if (fits)
        fit_view(el, size, view, scale, offset);
    matrix own = { scale[0], 0, 0, scale[1], x + offset[0] - (fits ? scale[0]*view[0] : 0), y + offset[1] - (fits ? scale[1]*view[1] : 0) };
    l->m = lw_affine_product(&l->m, &own);
    for (int i = 0; i < 2; i++)
        l->window[i] = fits ? view[2+i] : size[i];
    return LW_OK;
}

/* ---- what is hidden ------------------------------------------------------------------------------------------- */

static bool never_drawn(const char *name)
{
    static const char *const rows[] = { "defs", "clipPath", "mask", "marker", "symbol", "pattern", "metadata",
                                        "sodipodi:namedview", "foreignObject", "i:pgf", "flowRoot", "glyph", "font" };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (strcmp(name, rows[i]) == 0)
            return true;
    return false;
}

/* Is a property set to a word in declarations such as "fill:none; display : none"? */
static bool declares(const char *text, size_t size, const char *key, const char *word)
{
    size_t n = strlen(key);
    for (size_t i = 0; i + n <= size; i++) {
        if (memcmp(text + i, key, n) != 0 || (i > 0 && (isalnum((unsigned char)text[i-1]) || text[i-1] == '-')))
            continue;
        size_t at = i + n;
        while (at < size && isspace((unsigned char)text[at]))
            at++;
        if (at == size || text[at++] != ':')
            continue;
        while (at < size && isspace((unsigned char)text[at]))
            at++;
        if (at + strlen(word) <= size && memcmp(text + at, word, strlen(word)) == 0)
            return true;
    }
    return false;
}

/* Is the class in the selector of a rule that hides? */
static bool class_hides(const reader *r, const char *class, size_t size)
{
    for (int i = 0; i < r->n_style; i++) {
        const char *s = r->style[i].text;
        size_t end = r->style[i].size;
        for (size_t at = r->style[i].at; at + size < end; at++) {
            int next = (unsigned char)s[at + 1 + size];
            if (s[at] != '.' || memcmp(s + at + 1, class, size) != 0 || isalnum(next) || next == '-' || next == '_')
                continue;
            const char *open = memchr(s + at, '{', end - at), *close = open ? memchr(open, '}', (size_t)(s + end
                - open))
                             : NULL;
            if (close && !memchr(s + at, '}', (size_t)(open - s) - at) && declares(open, (size_t)(close - open), "display", "none"))
                return true;
        }
    }
    return false;
}

static bool is_hidden(const reader *r, const element *el)
{
    const lw_cursor *style = &el->value[ATTRIBUTE_STYLE], *c = &el->value[ATTRIBUTE_CLASS];
    const char *s = style->text ? style->text + style->at : "";
    size_t size = style->text ? style->size - style->at : 0;
    if (never_drawn(el->name) || value_has(el, ATTRIBUTE_DISPLAY, "none") || declares(s, size, "display", "none")
        || value_has(el, ATTRIBUTE_VISIBILITY, "hidden") || declares(s, size, "visibility", "hidden"))
        return true;
    for (size_t at = c->at, n; c->text && at < c->size; at += n + 1) {
        for (n = 0; at + n < c->size && !isspace((unsigned char)c->text[at + n]);)
            n++;
        if (n > 0 && class_hides(r, c->text + at, n))
            return true;
    }
    return false;
}

/* ---- shapes --------------------------------------------------------------------------------------------------- */

/* The attribute with the name that a person gave an element: by Inkscape, Illustrator, or our own export. */
static int label_of(const element *el)
{
    return given(el, ATTRIBUTE_LABEL) ? ATTRIBUTE_LABEL : given(el, ATTRIBUTE_DATA_NAME) ? ATTRIBUTE_DATA_NAME
         : ATTRIBUTE_TRACER;
}

/* Draw a rectangle with rounded corners as a path does (SVG 1.1, 9.2). */
static lw_status draw_rect(const element *el, pen *p)
{
    double v[6];
    static const int key[] = { ATTRIBUTE_X, ATTRIBUTE_Y, ATTRIBUTE_WIDTH, ATTRIBUTE_HEIGHT, ATTRIBUTE_RX,
                               ATTRIBUTE_RY };
    lw_status s = LW_OK;
    if (value_has(el, ATTRIBUTE_WIDTH, "%") || value_has(el, ATTRIBUTE_HEIGHT, "%"))
        return LW_OK;                              /* the background of the page */
    for (int i = 0; i < 6 && s == LW_OK; i++)
        s = take_value(el, key[i], i < 4 ? 0 : -1, &v[i]);
    if (s != LW_OK || !(v[2] > 0 && v[3] > 0))
        return s;
    double x = v[0], y = v[1], w = v[2], h = v[3], rx = v[4] < 0 ? v[5] : v[4], ry = v[5] < 0 ? v[4] : v[5];
    rx = fmax(0, fmin(rx, w/2));
    ry = fmax(0, fmin(ry, h/2));
    lw_vec2 r = lw_v2(rx, ry);
    long line = el->at.line;
    begin_curve(p, lw_v2(x + rx, y), line);
    line_to(p, lw_v2(x + w - rx, y), line);
    arc_to(p, r, 0, false, true, lw_v2(x + w, y + ry), line);
    line_to(p, lw_v2(x + w, y + h - ry), line);
    arc_to(p, r, 0, false, true, lw_v2(x + w - rx, y + h), line);
    line_to(p, lw_v2(x + rx, y + h), line);
    arc_to(p, r, 0, false, true, lw_v2(x, y + h - ry), line);
    line_to(p, lw_v2(x, y + ry), line);
    arc_to(p, r, 0, false, true, lw_v2(x + rx, y), line);
    lw_outlines_close(p->out);
    return LW_OK;
}

static lw_status draw_ellipse(const element *el, pen *p)
{
    double cx, cy, r, rx, ry;
    lw_status s = take_value(el, ATTRIBUTE_CX, 0, &cx);
    if (s == LW_OK)
        s = take_value(el, ATTRIBUTE_CY, 0, &cy);
    if (s == LW_OK)
        s = take_value(el, ATTRIBUTE_R, 0, &r);
    if (s == LW_OK)
        s = take_value(el, ATTRIBUTE_RX, r, &rx);
    if (s == LW_OK)
        s = take_value(el, ATTRIBUTE_RY, r, &ry);
    if (s != LW_OK || !(rx > 0 && ry > 0))
        return s;
    begin_curve(p, lw_v2(cx + rx, cy), el->at.line);
    arc_to(p, lw_v2(rx, ry), 0, false, true, lw_v2(cx - rx, cy), el->at.line);
    arc_to(p, lw_v2(rx, ry), 0, false, true, lw_v2(cx + rx, cy), el->at.line);
    lw_outlines_close(p->out);
    return LW_OK;
}

static lw_status draw_line(const element *el, pen *p)
{
    double v[4];
    lw_status s = LW_OK;
    for (int i = 0; i < 4 && s == LW_OK; i++)
        s = take_value(el, ATTRIBUTE_X1 + i, 0, &v[i]);
    if (s != LW_OK)
        return s;
    begin_curve(p, lw_v2(v[0], v[1]), el->at.line);
    line_to(p, lw_v2(v[2], v[3]), el->at.line);
    return LW_OK;
}

static lw_status draw(reader *r, const element *el, const level *in)
{
    char name[48], label[48];
    copy_value(el, ATTRIBUTE_ID, name, sizeof name);
    copy_value(el, label_of(el), label, sizeof label);
    pen p = { .out = &r->out, .m = in->m, .name = name, .label = label, .group = in->group };
    lw_cursor d = el->value[ATTRIBUTE_D], points = el->value[ATTRIBUTE_POINTS];
    bool polygon = strcmp(el->name, "polygon") == 0;
    lw_status s = LW_OK;
    if (strcmp(el->name, "path") == 0 && d.text)
        return read_path(&d, &p);
    if ((polygon || strcmp(el->name, "polyline") == 0) && points.text) {
        s = read_points(&points, &p);
        if (polygon && p.drawing)
            lw_outlines_close(&r->out);
        return s;
    }
    r->has_text = r->has_text || strcmp(el->name, "text") == 0;
    return strcmp(el->name, "rect") == 0 ? draw_rect(el, &p)
         : strcmp(el->name, "circle") == 0 || strcmp(el->name, "ellipse") == 0 ? draw_ellipse(el, &p)
         : strcmp(el->name, "line") == 0 ? draw_line(el, &p) : LW_OK;
}

/* ---- the tree ------------------------------------------------------------------------------------------------- */

static lw_status read_tree(reader *r, lw_cursor c, const element *use, const level *in);

/* Find the element with an id; behind it, *c is where its text begins. */
static bool find_element(const reader *r, const char *id, lw_cursor *c)
{
    lw_error quiet;
    bool more = true;
    *c = r->c;
    c->e = &quiet;
    for (;;) {
        element el;
        char name[256];
        lw_cursor start = *c;
        if (take_element(c, &el, &more) != LW_OK || !more)
            return false;
        copy_value(&el, ATTRIBUTE_ID, name, sizeof name);
        if (!el.ends && strcmp(name, id) == 0) {
            *c = start;
            c->e = r->c.e;
            return true;
        }
    }
}

/* Draw a clone: <use href="#id" x y transform>. */
static lw_status draw_clone(reader *r, const element *el, const level *in)
{
    int key = given(el, ATTRIBUTE_HREF) ? ATTRIBUTE_HREF : ATTRIBUTE_XLINK;
    char id[256];
    level own = *in;
    double x, y;
    lw_cursor c;
    copy_value(el, key, id, sizeof id);
    lw_status s = take_value(el, ATTRIBUTE_X, 0, &x);
    if (s == LW_OK)
        s = take_value(el, ATTRIBUTE_Y, 0, &y);
    if (s != LW_OK || id[0] != '#' || !find_element(r, id + 1, &c))
        return s;
    if (++r->clones > CLONE_MAX)
        return lw_cursor_fail(&el->at, "the drawing has more than %d clones, or one that holds itself; convert them to paths", CLONE_MAX);
    matrix m = { 1, 0, 0, 1, x, y };
    own.m = lw_affine_product(&in->m, &m);
    copy_value(el, ATTRIBUTE_ID, own.group, sizeof own.group);
    return read_tree(r, c, el, &own);
}

/* Set the map, the visibility and the group of an element's inside. */
static lw_status open_level(reader *r, const element *el, bool root, level *l)
{
    const lw_cursor *style = &el->value[ATTRIBUTE_STYLE];
    lw_status s = LW_OK;
    if (root)
        read_scale(r, el, l);
    if (given(el, ATTRIBUTE_TRANSFORM)) {
        lw_cursor c = el->value[ATTRIBUTE_TRANSFORM];
        if (given(el, ATTRIBUTE_ORIGIN))
            return lw_cursor_fail(&el->value[ATTRIBUTE_ORIGIN], "transform-origin is not read; apply the transform to "
                                  "the curve in the drawing program");
        s = read_transform(&c, &l->m);
    }
    if (style->text && declares(style->text + style->at, style->size - style->at, "transform", ""))
        return lw_cursor_fail(style, "a transform inside of a style is not read; apply it to the curve in the drawing program");
    if (s == LW_OK && !root && strcmp(el->name, "svg") == 0)
        s = enter_inner(el, l);
    l->hidden = l->hidden || is_hidden(r, el);
    if (strcmp(el->name, "g") == 0 && (given(el, label_of(el)) || given(el, ATTRIBUTE_ID)))
        copy_value(el, given(el, label_of(el)) ? label_of(el) : ATTRIBUTE_ID, l->group, sizeof l->group);
    return s;
}

static void take_style(reader *r, lw_cursor *c)
{
    lw_cursor start = *c;
    while (c->at < c->size && !lw_cursor_begins(c, "</"))
        lw_cursor_next(c);
    start.size = c->at;
    if (r->n_style < STYLE_MAX)
        r->style[r->n_style++] = start;
}

/* A clone says how large the symbol or the drawing is that it shows. */
static void size_clone(element *el, const element *use)
{
    static const int key[] = { ATTRIBUTE_WIDTH, ATTRIBUTE_HEIGHT };
    if (strcmp(el->name, "symbol") == 0)
        strcpy(el->name, "svg");
    for (int i = 0; i < 2 && strcmp(el->name, "svg") == 0; i++)
        if (given(use, key[i]))
            el->value[key[i]] = use->value[key[i]];
}

/* Draw the elements from c on, or only the first one, with what it holds, even if it is only defined, if a clone shows it. */
static lw_status read_tree(reader *r, lw_cursor c, const element *use, const level *in)
{
    level open[DEPTH_MAX];
    int depth = 0;
    for (;;) {
        element el;
        bool more;
        level l = depth > 0 ? open[depth - 1] : *in;
        lw_status s = take_element(&c, &el, &more);
        if (s == LW_OK && !more && depth > 0)
            return lw_cursor_fail(&c, "the drawing ends before the end of its elements (</svg>): a part of the file is missing; save or copy it again");
        if (s != LW_OK || !more)
            return s;
        if (el.ends) {
            depth -= depth > 0;
        } else {
            bool root = !r->rooted && strcmp(el.name, "svg") == 0;
            r->rooted = r->rooted || root;
            if (use && depth == 0)
                size_clone(&el, use);
            s = open_level(r, &el, root, &l);
            if (s == LW_OK && strcmp(el.name, "style") == 0 && !el.empty)
                take_style(r, &c);
            else if (s == LW_OK && !l.hidden && strcmp(el.name, "use") == 0)
                s = draw_clone(r, &el, &l);
            else if (s == LW_OK && !l.hidden)
                s = draw(r, &el, &l);
            if (s == LW_OK && !el.empty && depth == DEPTH_MAX)
                s = lw_cursor_fail(&el.at, "elements are nested deeper than %d", DEPTH_MAX);
            if (s != LW_OK)
                return s;
            if (!el.empty)
                open[depth++] = l;
        }
        if (use && depth == 0)
            return LW_OK;
    }
}

static bool has_word(const char *text, size_t size, const char *word)
{
    size_t n = strlen(word);
    for (size_t i = 0; i + n <= size; i++)
        if (memcmp(text + i, word, n) == 0)
            return true;
    return false;
}

lw_status lw_target_read_svg(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_error own = { .text = "" };
    e = e ? e : &own;
    reader r = { .out = { .unit = "mm", .scale = 1 } };
    level top = { .m = { .a = 1, .d = 1 } };
    *t = (lw_target){ .n = 0 };
    r.c = lw_cursor_start(text, size, file, e);
    r.illustrator = has_word(text, size < 1000 ? size : 1000, "Adobe Illustrator");
    lw_status s = lw_text_check(text, size, file, e);
    if (s == LW_OK)
        s = read_tree(&r, r.c, NULL, &top);
    if (s == LW_OK && r.out.n == 0)
        s = lw_error_at(e, LW_E_NOTATION, file, 1, 1, "there is no visible path, line, polygon, rectangle, circle or "
                        "ellipse in this drawing%s", r.has_text ? "; convert text to paths" : "");
    if (s == LW_OK)
        s = lw_outlines_target(&r.out, file, o, t, e);
    lw_outlines_free(&r.out);
    return s;
}

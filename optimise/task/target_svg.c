/* optimise/task/target_svg.c - read the first curve of an SVG file (paths: SVG 1.1, chapter 8). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "grammar/text_internal.h"
#include "optimise/task/target_outline_internal.h"

#define DEPTH_MAX 64

typedef struct matrix { double a, b, c, d, e, f; } matrix;     /* x' = a x + c y + e, y' = b x + d y + f */

typedef struct reader {
    lw_cursor  c;                      /* in the file                                              */
    int        depth, hidden;          /* open elements; depth from which elements are hidden, or 0 */
    matrix     m[DEPTH_MAX];
    lw_outline out;
    double     width, view;            /* of the root: in millimetres, in units; 0: not given      */
    bool       found;
} reader;

/* ---- numbers -------------------------------------------------------------------------------------------- */

static void skip_space(lw_cursor *c, bool comma)
{
    for (;; lw_cursor_next(c)) {
        int byte = lw_cursor_peek(c);
        if (byte == ',' && comma)
            comma = false;
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
    lw_outline *out;
    matrix      m;
    lw_vec2     at, start, handle;     /* current point, start of the subpath, last control point  */
    int         last;                  /* command, in capitals; 0: none                            */
    bool        drawn;                 /* something was drawn since the first M                    */
} pen;

/* Point on the page, with y up. */
static lw_vec2 on_page(const matrix *m, lw_vec2 p)
{
    return lw_v2(m->a*p.x + m->c*p.y + m->e, -(m->b*p.x + m->d*p.y + m->f));
}

static void mark(pen *p, lw_vec2 q, long line) { lw_outline_add(p->out, on_page(&p->m, q), line); }

static void line_to(pen *p, lw_vec2 q, long line)
{
    mark(p, q, line);
    p->at = q;
    p->drawn = true;
}

static void bezier(pen *p, lw_vec2 b, lw_vec2 c, lw_vec2 d, long line)
{
    lw_vec2 a = p->at;
    p->out->curved = true;
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
    p->out->curved = true;
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
        s = take_point(c, base, &q);
        if (s == LW_OK) {
            mark(p, q, line);
            p->at = p->start = q;
        }
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

/* Read one curve. A second M after something was drawn is an error: it is not clear which curve is meant. */
static lw_status read_path(lw_cursor *c, pen *p)
{
    lw_status s = LW_OK;
    int command = 0;
    bool relative = false;
    char name[24];
    for (skip_space(c, false); s == LW_OK && lw_cursor_peek(c) >= 0; skip_space(c, command != 0)) {
        int byte = lw_cursor_peek(c);
        if (byte > 0 && strchr("MLHVCSQTAZmlhvcsqtaz", byte)) {
            if ((p->drawn || p->out->closed) && (byte == 'M' || byte == 'm'))
                return lw_cursor_fail(c, "the path begins a second curve here; a target is one curve, leave the others "
                                      "out");
            relative = byte >= 'a';
            command = relative ? byte - 'a' + 'A' : byte;
            if (p->last == 0 && command != 'M')
                return lw_cursor_fail(c, "a path begins with M");
            lw_cursor_next(c);
            if (command == 'Z') {
                p->at = p->start;
                p->out->closed = true;
                p->last = command;
                continue;
            }
        } else if (command == 0 || command == 'Z' || !begins_number(byte)) {
            return lw_cursor_fail(c, "one of M L H V C S Q T A Z or a number is expected, not %s",
                                  lw_byte_name(byte, name));
        }
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
        if (s == LW_OK)
            line_to(p, q, c->line);
    }
    return s;
}

/* ---- transforms --------------------------------------------------------------------------------------------- */

static matrix product(const matrix *m, const matrix *n)
{
    return (matrix){ m->a*n->a + m->c*n->b, m->b*n->a + m->d*n->b, m->a*n->c + m->c*n->d, m->b*n->c + m->d*n->d,
                     m->a*n->e + m->c*n->f + m->e, m->b*n->e + m->d*n->f + m->f };
}

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
        *m = product(m, &own);
    }
    return LW_OK;
}

/* ---- elements ------------------------------------------------------------------------------------------------- */

typedef struct element {
    char      name[24];
    lw_cursor at;
    lw_cursor d, points, transform, width, view;    /* values; text NULL: missing                */
    bool      ends, empty;                          /* </x>, <x/>                                */
} element;

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
    static const struct { const char *name; size_t place; } rows[] = {
        { "d", offsetof(element, d) }, { "points", offsetof(element, points) }, { "width", offsetof(element, width) },
        { "transform", offsetof(element, transform) }, { "viewBox", offsetof(element, view) }
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
        if (strcmp(name, rows[i].name) == 0)
            memcpy((char *)el + rows[i].place, &value, sizeof value);
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

/* Read the scale from width="120mm" and viewBox="x y 120 h". */
static void read_scale(reader *r, const element *el)
{
    static const struct { const char *unit; double mm; } rows[] = {
        { "mm", 1 }, { "cm", 10 }, { "in", 25.4 }, { "pt", 25.4/72 }, { "pc", 25.4/6 }, { "Q", 0.25 }, { "px", 25.4/96 }
    };
    lw_error quiet;
    double width = 0, view[4] = { 0 };
    if (!el->width.text || !el->view.text)
        return;
    lw_cursor w = el->width, v = el->view;
    w.e = v.e = &quiet;
    if (take_number(&w, &width) != LW_OK || take_numbers(&v, view, 4) != LW_OK || !(width > 0) || !(view[2] > 0))
        return;
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (w.size - w.at == strlen(rows[i].unit) && memcmp(w.text + w.at, rows[i].unit, w.size - w.at) == 0) {
            r->width = width*rows[i].mm;
            r->view = view[2];
        }
}

static bool hides(const char *name)
{
    static const char *const rows[] = { "defs", "clipPath", "mask", "marker", "symbol", "pattern" };
    for (size_t i = 0; i < sizeof rows/sizeof *rows; i++)
        if (strcmp(name, rows[i]) == 0)
            return true;
    return false;
}

static lw_status draw(reader *r, const element *el, const matrix *m)
{
    bool path = strcmp(el->name, "path") == 0, open = strcmp(el->name, "polyline") == 0;
    lw_cursor c = path ? el->d : el->points;
    if (!c.text || (!path && !open && strcmp(el->name, "polygon") != 0))
        return LW_OK;
    pen p = { .out = &r->out, .m = *m };
    lw_status s = path ? read_path(&c, &p) : read_points(&c, &p);
    if (!path && !open)
        r->out.closed = true;
    r->found = r->out.n > 0;
    return s;
}

static lw_status enter(reader *r, const element *el)
{
    matrix m = r->depth > 0 ? r->m[r->depth - 1] : (matrix){ .a = 1, .d = 1 };
    lw_status s = LW_OK;
    if (el->transform.text) {
        lw_cursor c = el->transform;
        s = read_transform(&c, &m);
    }
    if (s == LW_OK && r->depth == 0 && strcmp(el->name, "svg") == 0)
        read_scale(r, el);
    if (s == LW_OK && !r->hidden)
        s = draw(r, el, &m);
    if (s != LW_OK || el->empty)
        return s;
    if (r->depth == DEPTH_MAX)
        return lw_cursor_fail(&el->at, "elements are nested deeper than %d", DEPTH_MAX);
    r->m[r->depth++] = m;
    if (!r->hidden && hides(el->name))
        r->hidden = r->depth;
    return LW_OK;
}

static void leave(reader *r)
{
    if (r->hidden == r->depth)
        r->hidden = 0;
    if (r->depth > 0)
        r->depth--;
}

lw_status lw_target_read_svg(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t,
                             lw_error *e)
{
    lw_error own = { .text = "" };
    e = e ? e : &own;
    reader *r = calloc(1, sizeof *r);
    *t = (lw_target){ .n = 0 };
    if (!r)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a curve");
    r->c = lw_cursor_start(text, size, file, e);
    lw_status s = LW_OK;
    bool more = true;
    while (s == LW_OK && !r->found && more) {
        element el;
        s = take_element(&r->c, &el, &more);
        if (s == LW_OK && more && el.ends)
            leave(r);
        else if (s == LW_OK && more)
            s = enter(r, &el);
    }
    if (s == LW_OK && !r->found)
        s = lw_cursor_fail(&r->c, "there is no path, polyline or polygon in this file");
    for (size_t i = 0; s == LW_OK && r->view > 0 && i < r->out.n; i++)
        r->out.p[i] = lw_v2_scale(r->out.p[i], r->width/r->view);
    if (s == LW_OK)
        s = lw_outline_target(&r->out, file, "mm", o, t, e);
    lw_outline_free(&r->out);
    free(r);
    return s;
}

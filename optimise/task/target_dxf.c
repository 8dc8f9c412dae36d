/* optimise/task/target_dxf.c - read the curve of a DXF file: groups of a code and a value, one line each (R12 to 2018).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "grammar/text_internal.h"
#include "optimise/task/target_outline_internal.h"

#define PIECE_MAX 20000

/* Values of an entity; 0 if a code is missing. */
typedef struct entity {
    char   kind[16];
    double v[100];                     /* numbers by code, 10 .. 59 and 70                         */
    long   line;
} entity;

typedef struct group { int code; const char *text; size_t size; long line; } group;

typedef struct reader {
    lw_cursor   c;
    lw_outline  out;                   /* of the polyline                                           */
    int         n_outline;             /* polylines                                                 */
    lw_outline *piece;                 /* lines, arcs, circles                    (n_piece) owned   */
    int         n_piece, room;
    const char *unit;
    double      bulge;                 /* of the last vertex                                        */
    bool        in_polyline;
} reader;

/* ---- groups ------------------------------------------------------------------------------------------- */

static void take_line(lw_cursor *c, const char **text, size_t *size)
{
    lw_cursor_skip(c, false, 0);
    *text = c->text + c->at;
    size_t start = c->at;
    while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '\n')
        lw_cursor_next(c);
    *size = c->at - start;
    lw_cursor_next(c);
    while (*size > 0 && ((*text)[*size - 1] == '\r' || (*text)[*size - 1] == ' '))
        --*size;
}

/* Read a group. *more false: end of the text. A code that is no number is an error. */
static lw_status take_group(lw_cursor *c, group *g, bool *more)
{
    const char *text;
    size_t size;
    double code;
    lw_cursor start = *c;
    *more = lw_cursor_peek(c) >= 0;
    if (!*more)
        return LW_OK;
    take_line(c, &text, &size);
    if (size == 0 && lw_cursor_peek(c) < 0) {
        *more = false;
        return LW_OK;
    }
    if (lw_number_parse(text, size, &code) != LW_OK || !(code >= -5 && code <= 1071) || code != floor(code))
        return lw_cursor_fail(&start, "this is no DXF text: a group code is expected here");
    g->code = (int)code;
    g->line = c->line;
    take_line(c, &g->text, &g->size);
    return LW_OK;
}

static bool is(const group *g, const char *word)
{
    return g->size == strlen(word) && memcmp(g->text, word, g->size) == 0;
}

static lw_status number(const reader *r, const group *g, double *v)
{
    const char *s = g->text;
    size_t skip = g->size > 0 && *s == '+';
    if (lw_number_parse(s + skip, g->size - skip, v) == LW_OK)
        return LW_OK;
    return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, g->line, 1, "a number is expected behind group code %d",
                       g->code);
}

/* ---- curves --------------------------------------------------------------------------------------------- */

static lw_vec2 point(const entity *n, int code) { return lw_v2(n->v[code], n->v[code + 10]); }

/* Add a vertex of a polyline. The bulge of the vertex before, tan(sweep/4), makes the segment to this one an arc. */
static void vertex(reader *r, lw_vec2 p, double bulge, long line)
{
    lw_outline *c = &r->out;
    if (c->n > 0 && r->bulge != 0 && (c->p[c->n - 1].x != p.x || c->p[c->n - 1].y != p.y)) {
        lw_vec2 a = c->p[c->n - 1], d = lw_v2_sub(p, a), middle = lw_v2_scale(lw_v2_add(a, p), 0.5);
        double h = (1 - r->bulge*r->bulge)/(4*r->bulge);
        lw_outline_arc(c, lw_v2_add(middle, lw_v2_scale(lw_v2_perp(d), h)), 4*atan(r->bulge), p, line);
    } else {
        lw_outline_add(c, p, line);
    }
    r->bulge = bulge;
}

/* End a polyline; a closed one gets the segment back to its beginning. */
static void close_polyline(reader *r, bool closed)
{
    if (closed && r->out.n > 1) {
        vertex(r, r->out.p[0], 0, r->out.line[r->out.n - 1]);
        r->out.closed = true;
    }
    r->bulge = 0;
    r->in_polyline = false;
}

static lw_outline *add_piece(reader *r)
{
    if (r->n_piece == r->room) {
        int room = r->room ? 2*r->room : 64;
        lw_outline *p = room <= PIECE_MAX ? realloc(r->piece, (size_t)room*sizeof *p) : NULL;
        if (!p)
            return NULL;
        r->piece = p;
        r->room = room;
    }
    r->piece[r->n_piece] = (lw_outline){ .n = 0 };
    return &r->piece[r->n_piece++];
}

static lw_status add_bent(reader *r, const entity *n)
{
    lw_outline *c = add_piece(r);
    bool circle = strcmp(n->kind, "CIRCLE") == 0;
    if (!c)
        return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, n->line, 1, "the drawing has more than %d lines and arcs, "
                           "or memory ran out", PIECE_MAX/2);
    if (strcmp(n->kind, "LINE") == 0) {
        lw_outline_add(c, point(n, 10), n->line);
        lw_outline_add(c, point(n, 11), n->line);
        return LW_OK;
    }
    double from = circle ? 0 : n->v[50]*LW_PI/180, sweep = circle ? 2*LW_PI : n->v[51]*LW_PI/180 - from;
    sweep = circle ? sweep : sweep - 2*LW_PI*floor(sweep/(2*LW_PI));
    lw_vec2 at = point(n, 10), start = lw_v2_add(at, lw_v2_polar(n->v[40], from));
    lw_outline_add(c, start, n->line);
    lw_outline_arc(c, at, sweep, lw_v2_add(at, lw_v2_polar(n->v[40], from + sweep)), n->line);
    c->closed = circle;
    return LW_OK;
}

/* ---- pieces into one -------------------------------------------------------------------------------------- */

static lw_vec2 end_of(const lw_outline *c, bool last) { return c->p[last ? c->n - 1 : 0]; }

static bool near(lw_vec2 a, lw_vec2 b, double size) { return lw_v2_norm(lw_v2_sub(a, b)) <= 1e-6*size; }

static void append(lw_outline *to, const lw_outline *from, bool backwards)
{
    for (size_t i = 1; i < from->n; i++) {
        size_t at = backwards ? from->n - 1 - i : i;
        lw_outline_add(to, from->p[at], from->line[at]);
    }
    to->curved = to->curved || from->curved;
}

static void turn_round(lw_outline *c)
{
    for (size_t i = 0, j = c->n; j > i + 1; i++) {
        lw_vec2 p = c->p[i];
        long l = c->line[i];
        c->p[i] = c->p[--j];
        c->line[i] = c->line[j];
        c->p[j] = p;
        c->line[j] = l;
    }
}

/* Join lines and arcs that meet end to end, in any order of the file. */
static lw_status join_pieces(reader *r)
{
    lw_outline *c = &r->piece[0];
    double size = 0;
    int left = r->n_piece - 1;
    for (int i = 0; i < r->n_piece; i++) {
        if (r->piece[i].n < 1 || r->piece[i].failed)
            return lw_cursor_fail(&r->c, "out of memory for the lines of this drawing");
        for (size_t k = 0; k < r->piece[i].n; k++)
            size = fmax(size, lw_v2_norm(lw_v2_sub(r->piece[i].p[k], r->piece[0].p[0])));
    }
    for (int turned = 0; left > 0 && turned < 2;) {
        int met = -1;
        bool backwards = false;
        for (int i = 1; i < r->n_piece && met < 0; i++)
            for (int last = 0; r->piece[i].n > 1 && last < 2; last++)
                if (near(end_of(c, true), end_of(&r->piece[i], last), size)) {
                    met = i;
                    backwards = last;
                    break;
                }
        if (met < 0) {
            turn_round(c);
            turned++;
            continue;
        }
        append(c, &r->piece[met], backwards);
        r->piece[met].n = 1;                       /* used; its memory is freed with the others */
        left--;
    }
    for (int i = 1; i < r->n_piece; i++)
        if (r->piece[i].n > 1)
            return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, r->piece[i].line[0], 1, "the lines and arcs of this "
                               "drawing make more than one curve; a target is one, leave the others out");
    r->out = *c;
    *c = (lw_outline){ .n = 0 };
    return LW_OK;
}

/* ---- entities ---------------------------------------------------------------------------------------------- */

/* Add an entity; it is complete when the next one begins. */
static lw_status finish_entity(reader *r, const entity *n)
{
    if (strcmp(n->kind, "LINE") == 0 || strcmp(n->kind, "ARC") == 0 || strcmp(n->kind, "CIRCLE") == 0)
        return add_bent(r, n);
    if (strcmp(n->kind, "VERTEX") == 0 && r->in_polyline)
        vertex(r, point(n, 10), n->v[42], n->line);
    else if (strcmp(n->kind, "LWPOLYLINE") == 0) {
        if (r->out.n > 0 || n->v[20] != 0 || n->v[10] != 0)
            vertex(r, point(n, 10), n->v[42], n->line);
        close_polyline(r, (int)n->v[70] & 1);
    }
    return LW_OK;
}

/* Begin a polyline. The target must be one polyline: of two it is not clear which is meant. */
static lw_status begin_polyline(reader *r, const group *g)
{
    if (r->n_outline++ == 0)
        return LW_OK;
    return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, g->line, 1, "this drawing has more than one polyline; a "
                       "target is one, leave the others out");
}

static lw_status begin_entity(reader *r, const group *g, entity *n, bool *closes)
{
    lw_status s = finish_entity(r, n);
    if (s == LW_OK && r->in_polyline && is(g, "SEQEND"))
        close_polyline(r, *closes);
    memset(n, 0, sizeof *n);
    n->line = g->line;
    for (size_t i = 0; i < g->size && i + 1 < sizeof n->kind; i++)
        n->kind[i] = g->text[i];
    if (s == LW_OK && (is(g, "LWPOLYLINE") || is(g, "POLYLINE")))
        s = begin_polyline(r, g);
    if (is(g, "POLYLINE"))
        r->in_polyline = true;
    return s;
}

/* Take a value of an entity. The x of a vertex of an LWPOLYLINE ends the vertex before it. */
static lw_status take_value(reader *r, const group *g, entity *n, int *vertices)
{
    double v;
    lw_status s = number(r, g, &v);
    if (s != LW_OK)
        return s;
    if (strcmp(n->kind, "LWPOLYLINE") == 0 && g->code == 10) {
        if ((*vertices)++ > 0)
            vertex(r, point(n, 10), n->v[42], n->line);
        n->v[42] = n->v[20] = 0;
    }
    n->v[g->code] = v;
    n->line = g->line;
    return LW_OK;
}

static lw_status read_entities(reader *r)
{
    entity n = { .kind = "" };
    bool more = true, closes = false;
    int vertices = 0;
    group g;
    lw_status s;
    while ((s = take_group(&r->c, &g, &more)) == LW_OK && more) {
        if (g.code == 0) {
            if (strcmp(n.kind, "POLYLINE") == 0)
                closes = (int)n.v[70] & 1;
            s = begin_entity(r, &g, &n, &closes);
            vertices = 0;
            if (is(&g, "ENDSEC") || is(&g, "EOF"))
                return s;
        } else if ((g.code >= 10 && g.code < 60) || g.code == 70) {
            s = take_value(r, &g, &n, &vertices);
        }
        if (s != LW_OK)
            return s;
    }
    return s == LW_OK ? finish_entity(r, &n) : s;
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static lw_status set_unit(reader *r, const group *g)
{
    static const struct { int code; const char *unit; } rows[] = {
        { 1, "in" }, { 2, "ft" }, { 4, "mm" }, { 5, "cm" }, { 6, "m" }, { 7, "km" }, { 13, "um" }
    };
    double v;
    lw_status s = number(r, g, &v);
    for (size_t i = 0; s == LW_OK && i < sizeof rows/sizeof *rows; i++)
        if (rows[i].code == v)
            r->unit = rows[i].unit;
    return s;
}

/* Read up to the section of entities and through it. */
static lw_status read_sections(reader *r)
{
    bool more = true, unit = false, section = false;
    group g;
    lw_status s;
    while ((s = take_group(&r->c, &g, &more)) == LW_OK && more) {
        if (g.code == 9)
            unit = is(&g, "$INSUNITS");
        else if (g.code == 70 && unit)
            s = set_unit(r, &g);
        else if (g.code == 2 && section && is(&g, "ENTITIES"))
            return read_entities(r);
        if (s != LW_OK)
            return s;
        section = g.code == 0 && is(&g, "SECTION");
    }
    return s;
}

static lw_status choose(reader *r)
{
    if (r->n_outline == 0 && r->n_piece > 0)
        return join_pieces(r);
    return r->out.n > 0 ? LW_OK
         : lw_cursor_fail(&r->c, "there is no polyline, line, arc or circle in the ENTITIES of this drawing");
}

lw_status lw_target_read_dxf(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t,
                             lw_error *e)
{
    lw_error own = { .text = "" };
    reader r = { .c = lw_cursor_start(text, size, file, e ? e : &own), .unit = "mm" };
    lw_status s = read_sections(&r);
    *t = (lw_target){ .n = 0 };
    if (s == LW_OK)
        s = choose(&r);
    if (s == LW_OK)
        s = lw_outline_target(&r.out, file, r.unit, o, t, e ? e : &own);
    lw_outline_free(&r.out);
    for (int i = 0; i < r.n_piece; i++)
        lw_outline_free(&r.piece[i]);
    free(r.piece);
    return s;
}

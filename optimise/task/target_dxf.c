/* optimise/task/target_dxf.c - read the curves of a DXF file (R12 to 2018): groups of a code and a value, one line
 * each. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/number.h"
#include "base/real.h"
#include "base/spline.h"
#include "grammar/text/text_internal.h"
#include "optimise/task/target_outline_internal.h"

#define DEPTH_MAX  16                  /* of blocks in blocks                                          */
#define INSERT_MAX 20000               /* blocks drawn                                                 */
#define ENTITY_MAX 2000000             /* entities drawn, those of blocks each time                    */
#define DEGREE_MAX 15                  /* of splines                                                   */
#define SPAN_STEPS 128                 /* points on each polynomial of a spline                        */
#define SAME_POINT 1e-9                /* of the extent: fit points of a spline that are one                       */
#define SEAM       60                  /* points before and after a closed spline: ends matter less by 2 at least for each  */

typedef struct group { int code; const char *text; size_t size; long line; } group;

/* The groups first .. last - 1 of the file; the first one has code 0. */
typedef struct entity { size_t first, last; } entity;

typedef struct block { size_t name, first, last; lw_vec2 base; } block;       /* entities first .. last - 1 */

typedef struct reader {
    lw_cursor  c;
    group     *g;                      /* of the sections that are drawn, and of the layers         (n_group) owned */
    entity    *entity;                 /*                                                          (n_entity) owned */
    block     *block;                  /*                                                           (n_block) owned */
    size_t     n_group, n_entity, n_block, room_group, room_entity, room_block;
    size_t     drawn, hidden, n_hidden; /* first entity of ENTITIES; first layer record and their number             */
    lw_outlines out;                    /* what is drawn                                                             */
    int        inserts, entities, n_point;
    char       other[32];              /* a kind of entity that is not drawn                                        */
} reader;

/* ---- groups ---------------------------------------------------------------------------------------------------- */

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

static bool same(const group *a, const group *b)
{
    return a->size == b->size && strncasecmp(a->text, b->text, a->size) == 0;
}

/* Make room for one more item. */
static bool grow(void **p, size_t n, size_t *room, size_t size)
{
    if (n < *room)
        return true;
    size_t more = *room ? 2**room : 256;
    void *q = realloc(*p, more*size);
    if (!q)
        return false;
    *p = q;
    *room = more;
    return true;
}

static lw_status no_memory(const reader *r)
{
    return lw_error_set(r->c.e, LW_E_MEMORY, "out of memory for this drawing");
}

static lw_status number_of(const reader *r, const group *g, double *v)
{
    const char *s = g->text;
    size_t skip = g->size > 0 && *s == '+';
    if (lw_number_parse(s + skip, g->size - skip, v) == LW_OK)
        return LW_OK;
    return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, g->line, 1, "a number is expected behind group code %d", g->code);
}

/* ---- values of an entity ---------------------------------------------------------------------------------------- */

static const group *head(const reader *r, const entity *n) { return &r->g[n->first]; }

/* The first group with this code; NULL: none. */
static const group *find(const reader *r, const entity *n, int code)
{
    for (size_t i = n->first + 1; i < n->last; i++)
        if (r->g[i].code == code)
            return &r->g[i];
    return NULL;
}

/* Values of n codes; those that are missing are left as they are. */
static lw_status take(const reader *r, const entity *n, const int *code, double *v, int count)
{
    for (int i = 0; i < count; i++) {
        const group *g = find(r, n, code[i]);
        lw_status s = g ? number_of(r, g, &v[i]) : LW_OK;
        if (s != LW_OK)
            return s;
    }
    return LW_OK;
}

static double value(const reader *r, const entity *n, int code)
{
    double v = 0;
    lw_error quiet;
    reader silent = *r;
    silent.c.e = &quiet;
    take(&silent, n, &code, &v, 1);
    return v;
}

/* Entities may have a coordinate system of their own, by the direction in which they are extruded; those of the page
 * have +z or, when they were mirrored, -z, which turns x round. */
static lw_status own_system(const reader *r, const entity *n, lw_affine *m)
{
    static const int code[] = { 210, 220, 230 };
    double v[3] = { 0, 0, 1 };
    lw_status s = take(r, n, code, v, 3);
    if (s != LW_OK)
        return s;
    if (!(fabs(v[0]) < 1e-6 && fabs(v[1]) < 1e-6 && v[2] != 0))
        return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, head(r, n)->line, 1, "this %.*s is not in the plane of x "
                           "and y", (int)head(r, n)->size, head(r, n)->text);
    lw_affine mirrored = { -1, 0, 0, 1, 0, 0 };
    if (v[2] < 0)
        *m = lw_affine_product(m, &mirrored);
    return LW_OK;
}

/* ---- curves ------------------------------------------------------------------------------------------------------ */

/* Where an entity is drawn: the map of its block, the name of the block, the layer of the insert. */
typedef struct place { lw_affine m; char block[48]; const group *layer; } place;

static const group *layer_of(const reader *r, const entity *n, const place *in)
{
    const group *layer = find(r, n, 8);
    return in->layer && (!layer || is(layer, "0")) ? in->layer : layer;
}

static void begin(reader *r, const entity *n, const place *in)
{
    const group *layer = layer_of(r, n, in);
    char text[48];
    snprintf(text, sizeof text, "%.*s", layer ? (int)fmin((double)layer->size, 47) : 0, layer ? layer->text : "");
    lw_outlines_begin(&r->out, "", text, in->block);
}

static void add(reader *r, const lw_affine *m, lw_vec2 p, long line)
{
    lw_outlines_add(&r->out, lw_affine_point(m, p), line);
}

/* Add an arc of an ellipse with two half diameters; it ends exactly at `end`. */
static void add_arc(reader *r, const lw_affine *m, lw_vec2 at, lw_vec2 a, lw_vec2 b, double from, double sweep, lw_vec2 end, long line)
{
    int n = (int)ceil(fmin(fabs(sweep)/(2*LW_PI), 1)*4*LW_OUTLINE_ARCS) + 1;      /* a circle as long as 1e-5 of it */
    for (int i = 1; i < n; i++) {
        double t = from + sweep*i/n;
        add(r, m, lw_v2_add(at, lw_v2_add(lw_v2_scale(a, cos(t)), lw_v2_scale(b, sin(t)))), line);
    }
    add(r, m, end, line);
}

/* LINE, and ARC, CIRCLE, ELLIPSE as arcs of an ellipse. */
static lw_status draw_line(reader *r, const entity *n, const place *in)
{
    static const int code[] = { 10, 20, 11, 21 };
    double v[4] = { 0 };
    lw_status s = take(r, n, code, v, 4);
    if (s != LW_OK)
        return s;
    begin(r, n, in);
    add(r, &in->m, lw_v2(v[0], v[1]), head(r, n)->line);
    add(r, &in->m, lw_v2(v[2], v[3]), head(r, n)->line);
    return LW_OK;
}

static lw_status draw_bent(reader *r, const entity *n, const place *in)
{
    static const int round[] = { 10, 20, 40, 50, 51 }, oval[] = { 10, 20, 11, 21, 40, 41, 42 };
    bool ellipse = is(head(r, n), "ELLIPSE"), circle = is(head(r, n), "CIRCLE");
    double v[7] = { 0, 0, 0, 0, 0, 0, 2*LW_PI };
    lw_affine m = in->m, flat = in->m;
    lw_status s = ellipse ? take(r, n, oval, v, 7) : take(r, n, round, v, 5);
    if (s == LW_OK)
        s = own_system(r, n, ellipse ? &flat : &m);
    if (s != LW_OK)
        return s;
    lw_vec2 at = lw_v2(v[0], v[1]), a = lw_v2(v[2], ellipse ? v[3] : 0), b = lw_v2_perp(a);
    double from = ellipse ? v[5] : circle ? 0 : v[3]*LW_PI/180, to = ellipse ? v[6] : circle ? 2*LW_PI : v[4]*LW_PI/180;
    if (ellipse)                                    /* its points are those of the page; -z turns its sense round */
        b = lw_v2_scale(b, value(r, n, 230) < 0 ? -v[4] : v[4]);
    double sweep = to - from - 2*LW_PI*floor((to - from)/(2*LW_PI) - 1e-9);
    bool whole = fabs(sweep - 2*LW_PI) < 1e-7;
    lw_vec2 start = lw_v2_add(at, lw_v2_add(lw_v2_scale(a, cos(from)), lw_v2_scale(b, sin(from)))), end = start;
    if (!whole)
        end = lw_v2_add(at, lw_v2_add(lw_v2_scale(a, cos(to)), lw_v2_scale(b, sin(to))));
    begin(r, n, in);
    add(r, &m, start, head(r, n)->line);
    add_arc(r, &m, at, a, b, from, sweep, end, head(r, n)->line);
    if (whole)
        lw_outlines_close(&r->out);
    return LW_OK;
}

/* A vertex of a polyline. */
typedef struct vertex { lw_vec2 p; double bulge; long line; } vertex;

/* Draw from one vertex to the next. The bulge, tan(sweep/4), makes an arc of it. */
static void draw_side(reader *r, const lw_affine *m, const vertex *from, const vertex *to)
{
    lw_vec2 a = from->p, p = to->p, d = lw_v2_sub(p, a), middle = lw_v2_scale(lw_v2_add(a, p), 0.5);
    double bulge = from->bulge;
    if (bulge == 0 || (d.x == 0 && d.y == 0)) {
        add(r, m, p, to->line);
        return;
    }
    lw_vec2 at = lw_v2_add(middle, lw_v2_scale(lw_v2_perp(d), (1 - bulge*bulge)/(4*bulge))), radius = lw_v2_sub(a, at);
    add_arc(r, m, at, radius, lw_v2_perp(radius), 0, 4*atan(bulge), p, to->line);
}

/* Draw a polyline; `next` gives its vertices one after the other. */
static lw_status draw_vertices(reader *r, const entity *n, const place *in, bool closed, size_t *last)
{
    bool light = is(head(r, n), "LWPOLYLINE");
    vertex first = { .line = 0 }, before = first, v = first;
    lw_affine m = in->m;
    size_t count = 0, at = n->first + 1, now = *last;
    lw_status s = own_system(r, n, &m);
    begin(r, n, in);
    while (s == LW_OK) {
        v = (vertex){ .line = head(r, n)->line };
        if (light) {                               /* its groups: 10, 20, [42], 10, 20, [42], ... */
            while (at < n->last && r->g[at].code != 10)
                at++;
            if (at == n->last)
                break;
            v.line = r->g[at].line;
            for (size_t i = at++; s == LW_OK && i < n->last && (i + 1 == at || r->g[i].code != 10); i++)
                if (r->g[i].code == 10 || r->g[i].code == 20 || r->g[i].code == 42)
                    s = number_of(r, &r->g[i], r->g[i].code == 10 ? &v.p.x : r->g[i].code == 20 ? &v.p.y : &v.bulge);
        } else {                                   /* entities that follow, up to SEQEND */
            static const int code[] = { 10, 20, 42, 70 };
            double number[4] = { 0 };
            const entity *each = &r->entity[++now];
            if (now >= r->n_entity || !is(head(r, each), "VERTEX"))
                break;
            s = take(r, each, code, number, 4);
            v = (vertex){ { number[0], number[1] }, number[2], head(r, each)->line };
            if ((int)number[3] & 16)               /* frame of a spline, not on the curve */
                continue;
        }
        if (count++ == 0) {
            first = v;
            add(r, &m, v.p, v.line);
        } else {
            draw_side(r, &m, &before, &v);
        }
        before = v;
    }
    if (s == LW_OK && closed && count > 1) {
        draw_side(r, &m, &before, &first);
        lw_outlines_close(&r->out);
    }
    if (!light)
        *last = now < r->n_entity && is(head(r, &r->entity[now]), "SEQEND") ? now : now - 1;
    return s;
}

/* The numbers behind a code that repeats. */
static lw_status take_list(const reader *r, const entity *n, int code, double *v, size_t room, size_t *count)
{
    lw_status s = LW_OK;
    *count = 0;
    for (size_t i = n->first + 1; s == LW_OK && i < n->last; i++)
        if (r->g[i].code == code && *count < room)
            s = number_of(r, &r->g[i], &v[(*count)++]);
    return s;
}

/* Point of a rational spline at u in the span `k`: de Boor's algorithm. */
static lw_vec2 spline_point(int degree, const double *knot, const double *x, const double *y, const double *weight, size_t k, double u)
{
    double p[DEGREE_MAX + 1][3];
    for (int i = 0; i <= degree; i++) {
        size_t at = k - (size_t)degree + (size_t)i;
        p[i][0] = x[at]*weight[at];
        p[i][1] = y[at]*weight[at];
        p[i][2] = weight[at];
    }
    for (int level = 1; level <= degree; level++)
        for (int i = degree; i >= level; i--) {
            double a = knot[k - (size_t)degree + (size_t)i], b = knot[k + 1 + (size_t)(i - level)];
            double w = b > a ? (u - a)/(b - a) : 0;
            for (int d = 0; d < 3; d++)
                p[i][d] = (1 - w)*p[i-1][d] + w*p[i][d];
        }
    return lw_v2(p[degree][0]/p[degree][2], p[degree][1]/p[degree][2]);
}

/* Take out points that stand twice, to rounding, one after the other or at both ends of a closed curve. */
static size_t without_twins(double *x, double *y, size_t n, bool closed)
{
    size_t kept = 0;
    double near = 0;
    for (size_t i = 0; i < n; i++)
        near = fmax(near, SAME_POINT*hypot(x[i] - x[0], y[i] - y[0]));
    for (size_t i = 0; i < n; i++)
        if (kept == 0 || hypot(x[i] - x[kept-1], y[i] - y[kept-1]) > near) {
            x[kept] = x[i];
            y[kept++] = y[i];
        }
    return closed && kept > 1 && hypot(x[kept-1] - x[0], y[kept-1] - y[0]) <= near ? kept - 1 : kept;
}

/* Draw a spline that is given by the n points which it fits: the cubic one over the lengths of the chords, as CAD programs do.  A
 * closed one is smooth at its seam too: it is the middle of one whose points are repeated so often that its ends do not matter. */
static lw_status draw_through(reader *r, const entity *n, const place *in, double *x, double *y, size_t n_point, bool closed)
{
    static const int code[] = { 12, 22, 13, 23 };
    const char *fault = NULL;
    double way[4] = { 0 }, slope[2][2];
    size_t count = without_twins(x, y, n_point, closed), more = 0;
    closed &= count > 2;
    more = closed ? SEAM : 0;
    lw_status s = take(r, n, code, way, 4);
    size_t all = count + 2*more + closed;
    double *u = s == LW_OK ? malloc(6*(all + 1)*sizeof *u) : NULL;
    if (!u)
        return s == LW_OK ? no_memory(r) : s;
    double *p = u + all, *q = p + all, *work = q + all, *bend_p = work + all, *bend_q = bend_p + all;
    for (size_t i = 0; i < all; i++) {
        size_t from = (i + SEAM*count - more) % count;
        p[i] = x[from];
        q[i] = y[from];
        u[i] = i == 0 ? 0 : u[i-1] + hypot(p[i] - p[i-1], q[i] - q[i-1]);
    }
    for (int end = 0; end < 2; end++) {
        double size = closed ? 0 : hypot(way[2*end], way[2*end + 1]);
        for (int d = 0; d < 2; d++)
            slope[d][end] = size > 0 ? way[2*end + d]/size : NAN;
    }
    if (all < 2)
        fault = "this spline has no control points and less than two fit points";
    else {
        lw_spline_bend((int)all, u, p, slope[0], work, bend_p);
        lw_spline_bend((int)all, u, q, slope[1], work, bend_q);
        begin(r, n, in);
        for (size_t i = more; i + 1 < all - more; i++)
            for (int k = i > more; k <= SPAN_STEPS; k++) {
                double at = u[i] + (u[i+1] - u[i])*k/SPAN_STEPS;
                lw_vec2 point = lw_v2(lw_spline_value(u, p, bend_p, (int)i, at), lw_spline_value(u, q, bend_q, (int)i, at));
                add(r, &in->m, point, head(r, n)->line);
            }
        if (closed)
            lw_outlines_close(&r->out);
    }
    free(u);
    return fault ? lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, head(r, n)->line, 1, "%s", fault) : LW_OK;
}

static lw_status draw_spline(reader *r, const entity *n, const place *in)
{
    size_t room = n->last - n->first, n_knot, nx, ny, n_weight;
    double *knot = malloc(4*room*sizeof *knot);
    long line = head(r, n)->line;
    int degree = (int)value(r, n, 71);
    const char *fault = NULL;
    if (!knot)
        return no_memory(r);
    double *x = knot + room, *y = x + room, *weight = y + room;
    lw_status s = take_list(r, n, 40, knot, room, &n_knot);
    if (s == LW_OK)
        s = take_list(r, n, 10, x, room, &nx);
    if (s == LW_OK)
        s = take_list(r, n, 20, y, room, &ny);
    if (s == LW_OK)
        s = take_list(r, n, 41, weight, room, &n_weight);
    if (s != LW_OK) {
        free(knot);
        return s;
    }
    if (nx == 0) {
        s = take_list(r, n, 11, x, room, &nx);
        if (s == LW_OK)
            s = take_list(r, n, 21, y, room, &ny);
        if (s == LW_OK && nx != ny)
            s = lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, line, 1, "the fit points of this spline do not have two coordinates each");
        if (s == LW_OK)
            s = draw_through(r, n, in, x, y, nx, (int)value(r, n, 70) & 1);
        free(knot);
        return s;
    }
    bool rising = true;
    for (size_t i = 1; i < n_knot; i++)
        rising = rising && knot[i] >= knot[i-1];
    for (size_t i = 0; i < nx; i++) {
        weight[i] = n_weight == nx ? weight[i] : 1;
        rising = rising && weight[i] > 0;
    }
    if (degree < 1 || degree > DEGREE_MAX)
        fault = "the degree of this spline is not between 1 and 15";
    else if (nx != ny || nx < (size_t)degree + 1 || n_knot != nx + (size_t)degree + 1 || !rising)
        fault = "the knots, weights and control points of this spline do not belong together";
    if (!fault) {
        begin(r, n, in);
        bool first = true;
        for (size_t k = (size_t)degree; k < nx; k++) {
            int steps = degree == 1 ? 1 : SPAN_STEPS;
            if (!(knot[k+1] > knot[k]))
                continue;
            for (int i = first ? 0 : 1; i <= steps; i++)
                add(r, &in->m, spline_point(degree, knot, x, y, weight, k, knot[k] + (knot[k+1] - knot[k])*i/steps), line);
            first = false;
        }
        if ((int)value(r, n, 70) & 1)
            lw_outlines_close(&r->out);
    }
    free(knot);
    return fault ? lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, line, 1, "%s", fault) : LW_OK;
}

/* ---- what is drawn --------------------------------------------------------------------------------------------- */

/* Is the layer off (a negative colour) or frozen? */
static bool layer_hidden(const reader *r, const group *layer)
{
    if (layer && layer->size == 9 && strncasecmp(layer->text, "Defpoints", 9) == 0)
        return true;
    for (size_t i = r->hidden; layer && i < r->hidden + r->n_hidden; i++) {
        const group *name = find(r, &r->entity[i], 2);
        if (name && same(name, layer))
            return value(r, &r->entity[i], 62) < 0 || (int)value(r, &r->entity[i], 70) & 1;
    }
    return false;
}

static lw_status draw_all(reader *r, size_t first, size_t last, const place *in, int depth);

/* Draw a block: base point to the origin, scale, turn, move; in columns and rows. */
static lw_status draw_insert(reader *r, const entity *n, const place *in, int depth)
{
    static const int code[] = { 10, 20, 41, 42, 50, 70, 71, 44, 45 };
    double v[9] = { 0, 0, 1, 1, 0, 1, 1, 0, 0 };
    const group *name = find(r, n, 2);
    const block *b = NULL;
    place own = { .m = in->m, .layer = layer_of(r, n, in) };
    lw_status s = take(r, n, code, v, 9);
    if (s == LW_OK)
        s = own_system(r, n, &own.m);
    for (size_t i = 0; s == LW_OK && name && i < r->n_block && !b; i++)
        if (same(&r->g[r->block[i].name], name))
            b = &r->block[i];
    if (s != LW_OK || !b)
        return s;
    if (depth == DEPTH_MAX)
        return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, head(r, n)->line, 1, "blocks are nested deeper than %d, "
                           "or one holds itself", DEPTH_MAX);
    double c = cos(v[4]*LW_PI/180), d = sin(v[4]*LW_PI/180);
    lw_affine at = own.m, turn = { c, d, -d, c, v[0], v[1] };
    snprintf(own.block, sizeof own.block, "%.*s", name->size > 47 ? 47 : (int)name->size, name->text);
    for (int row = 0; s == LW_OK && row < fmin(fmax(v[6], 1), INSERT_MAX); row++)
        for (int column = 0; s == LW_OK && column < fmin(fmax(v[5], 1), INSERT_MAX); column++) {
            lw_affine scale = { v[2], 0, 0, v[3], column*v[7] - v[2]*b->base.x, row*v[8] - v[3]*b->base.y };
            own.m = lw_affine_product(&turn, &scale);
            own.m = lw_affine_product(&at, &own.m);
            if (++r->inserts > INSERT_MAX)
                return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, head(r, n)->line, 1, "the drawing inserts more "
                                   "than %d blocks", INSERT_MAX);
            s = draw_all(r, b->first, b->last, &own, depth + 1);
        }
    return s;
}

static lw_status draw_entity(reader *r, size_t *at, const place *in, int depth)
{
    const entity *n = &r->entity[*at];
    const group *kind = head(r, n);
    if (is(kind, "LINE"))
        return draw_line(r, n, in);
    if (is(kind, "ARC") || is(kind, "CIRCLE") || is(kind, "ELLIPSE"))
        return draw_bent(r, n, in);
    if (is(kind, "SPLINE"))
        return draw_spline(r, n, in);
    if (is(kind, "LWPOLYLINE") || is(kind, "POLYLINE")) {
        int flags = (int)value(r, n, 70);
        if (is(kind, "LWPOLYLINE") || !(flags & (16 | 64)))           /* else a mesh */
            return draw_vertices(r, n, in, flags & 1, at);
    }
    if (is(kind, "INSERT"))
        return draw_insert(r, n, in, depth);
    if (is(kind, "POINT"))
        r->n_point++;
    else if (!is(kind, "VERTEX") && !is(kind, "SEQEND") && !is(kind, "ATTRIB"))
        snprintf(r->other, sizeof r->other, "%.*s", kind->size > 31 ? 31 : (int)kind->size, kind->text);
    return LW_OK;
}

static lw_status draw_all(reader *r, size_t first, size_t last, const place *in, int depth)
{
    lw_status s = LW_OK;
    for (size_t i = first; s == LW_OK && i < last; i++) {
        const entity *n = &r->entity[i];
        if (++r->entities > ENTITY_MAX)
            return lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, head(r, n)->line, 1, "the drawing has more than %d "
                               "entities, those of blocks counted each time", ENTITY_MAX);
        if (value(r, n, 67) == 0 && value(r, n, 60) == 0 && !layer_hidden(r, layer_of(r, n, in)))
            s = draw_entity(r, &i, in, depth);
    }
    return s;
}

/* Points alone are stations. */
static lw_status draw_points(reader *r, const place *in)
{
    static const int code[] = { 10, 20 };
    lw_status s = LW_OK;
    bool begun = false;
    for (size_t i = r->drawn; s == LW_OK && i < r->n_entity; i++) {
        const entity *n = &r->entity[i];
        double v[2] = { 0 };
        if (!is(head(r, n), "POINT") || layer_hidden(r, find(r, n, 8)) || value(r, n, 67) != 0)
            continue;
        if (!begun)
            begin(r, n, in);
        begun = true;
        if ((s = take(r, n, code, v, 2)) == LW_OK)
            add(r, &in->m, lw_v2(v[0], v[1]), head(r, n)->line);
    }
    r->out.only_points = true;
    return s;
}

/* ---- pieces into curves ------------------------------------------------------------------------------------------ */

/* An end of an open piece: 2 i is the first point of curve i, 2 i + 1 the last one. */
typedef struct end { lw_vec2 p; int id; } end;

static int compare_ends(const void *a, const void *b)
{
    const end *p = a, *q = b;
    return p->p.x < q->p.x ? -1 : p->p.x > q->p.x ? 1 : p->id - q->id;
}

/* Find for each end the one it meets, -1 if there is none, or more than one. */
static void match_ends(const lw_outlines *d, end *ends, size_t n, int *mate, double near)
{
    int *met = mate + 2*d->n;
    for (int i = 0; i < 2*d->n; i++) {
        mate[i] = -1;
        met[i] = 0;
    }
    qsort(ends, n, sizeof *ends, compare_ends);
    for (size_t i = 0; i < n; i++)
        for (size_t k = i + 1; k < n && ends[k].p.x - ends[i].p.x <= near; k++) {
            int a = ends[i].id, b = ends[k].id;
            if (lw_v2_norm(lw_v2_sub(ends[i].p, ends[k].p)) > near || strcmp(d->curve[a/2].name[1], d->curve[b/2].name[1]) != 0)
                continue;
            mate[a] = ++met[a] == 1 ? b : -1;
            mate[b] = ++met[b] == 1 ? a : -1;
        }
    for (int i = 0; i < 2*d->n; i++)
        if (mate[i] >= 0 && mate[mate[i]] != i)
            mate[i] = -1;
}

/* Follow the pieces from one end on and write them as one curve. */
static void write_chain(lw_outlines *to, const lw_outlines *d, const int *mate, int start, bool *used)
{
    const lw_outline *c = &d->curve[start/2];
    lw_outlines_begin(to, c->name[0], c->name[1], c->name[2]);
    int at = start;
    for (;;) {
        c = &d->curve[at/2];
        used[at/2] = true;
        bool first = at == start;
        for (size_t i = first ? 0 : 1; i < c->n; i++) {
            size_t k = at & 1 ? c->n - 1 - i : i;
            lw_outlines_add(to, c->p[k], c->line[k]);
        }
        int next = mate[at ^ 1];
        if (next < 0)
            return;
        if (used[next/2]) {
            lw_outlines_close(to);
            return;
        }
        at = next;
    }
}

static int compare_curves(const void *a, const void *b)
{
    const lw_outline *p = a, *q = b;
    long i = p->n > 0 ? p->line[0] : 0, k = q->n > 0 ? q->line[0] : 0;
    return i < k ? -1 : i > k;
}

/* Ends that are nearer than this part of the drawing meet: angles of arcs with two decimals move their ends so. */
#define MEETING 1e-4

/* Join open pieces that meet end to end, in any order of the file. */
static lw_status join_pieces(reader *r)
{
    lw_outlines *d = &r->out, joined = { .unit = d->unit, .scale = d->scale, .unit_given = d->unit_given };
    size_t n = 0, count = (size_t)d->n;
    lw_vec2 lo = { INFINITY, INFINITY }, hi = { -INFINITY, -INFINITY };
    end *ends = malloc((2*count + 1)*sizeof *ends);
    int *mate = malloc((4*count + 1)*sizeof *mate);
    bool *used = calloc(count + 1, sizeof *used);
    if (!ends || !mate || !used || d->failed) {
        free(ends);
        free(mate);
        free(used);
        return d->failed ? LW_OK : no_memory(r);
    }
    for (int i = 0; i < d->n; i++) {
        const lw_outline *c = &d->curve[i];
        for (size_t k = 0; k < c->n; k++) {
            lo = lw_v2(fmin(lo.x, c->p[k].x), fmin(lo.y, c->p[k].y));
            hi = lw_v2(fmax(hi.x, c->p[k].x), fmax(hi.y, c->p[k].y));
        }
        for (int last = 0; last < 2 && !c->closed && c->n > 1; last++)
            ends[n++] = (end){ c->p[last ? c->n - 1 : 0], 2*i + last };
    }
    match_ends(d, ends, n, mate, MEETING*hypot(hi.x - lo.x, hi.y - lo.y));
    for (int pass = 0; pass < 2; pass++)               /* open chains from one of their ends; then the closed ones */
        for (int i = 0; i < d->n; i++)
            for (int last = 0; last < 2 && !used[i]; last++) {
                const lw_outline *c = &d->curve[i];
                if (c->n > 1 && (pass > 0 || c->closed || mate[2*i + last] < 0)) {
                    write_chain(&joined, d, mate, 2*i + last, used);
                    if (c->closed && joined.n > 0)
                        joined.curve[joined.n - 1].closed = true;
                }
            }
    lw_outlines_free(d);
    *d = joined;
    if (!d->failed && d->n > 0)
        qsort(d->curve, (size_t)d->n, sizeof *d->curve, compare_curves);
    free(ends);
    free(mate);
    free(used);
    return LW_OK;
}

/* ---- the file --------------------------------------------------------------------------------------------------- */

/* Unit of the drawing by $INSUNITS (AutoCAD 2018, DXF reference). */
static lw_status set_unit(reader *r, const group *g)
{
    static const struct { int code; const char *unit; double scale; } rows[] = {
        { 1, "in", 1 }, { 2, "ft", 1 }, { 3, "ft", 5280 }, { 4, "mm", 1 }, { 5, "cm", 1 }, { 6, "m", 1 },
        { 7, "km", 1 }, { 8, "in", 1e-6 }, { 9, "in", 1e-3 }, { 10, "ft", 3 }, { 12, "um", 1e-3 }, { 13, "um", 1 },
        { 14, "cm", 10 }, { 15, "m", 10 }, { 16, "m", 100 }
    };
    double v;
    lw_status s = number_of(r, g, &v);
    for (size_t i = 0; s == LW_OK && i < sizeof rows/sizeof *rows; i++)
        if (rows[i].code == v) {
            r->out.unit = rows[i].unit;
            r->out.scale = rows[i].scale;
            r->out.unit_given = true;
        }
    return s;
}

/* Keep a group of a section that is drawn; code 0 begins an entity. */
static lw_status keep(reader *r, const group *g)
{
    if (!grow((void **)&r->g, r->n_group, &r->room_group, sizeof *r->g)
        || !grow((void **)&r->entity, r->n_entity, &r->room_entity, sizeof *r->entity))
        return no_memory(r);
    if (g->code == 0)
        r->entity[r->n_entity++] = (entity){ r->n_group, r->n_group + 1 };
    else if (r->n_entity == 0)
        return LW_OK;
    r->g[r->n_group++] = *g;
    r->entity[r->n_entity - 1].last = r->n_group;
    return LW_OK;
}

/* Find the blocks among the entities first .. n_entity - 1. */
static lw_status find_blocks(reader *r, size_t first)
{
    static const int code[] = { 10, 20 };
    lw_status s = LW_OK;
    for (size_t i = first; s == LW_OK && i < r->n_entity; i++) {
        const group *name = is(head(r, &r->entity[i]), "BLOCK") ? find(r, &r->entity[i], 2) : NULL;
        double v[2] = { 0 };
        size_t last = i + 1;
        if (!name)
            continue;
        if (!grow((void **)&r->block, r->n_block, &r->room_block, sizeof *r->block))
            return no_memory(r);
        while (last < r->n_entity && !is(head(r, &r->entity[last]), "ENDBLK"))
            last++;
        s = take(r, &r->entity[i], code, v, 2);
        r->block[r->n_block++] = (block){ (size_t)(name - r->g), i + 1, last, { v[0], v[1] } };
        i = last;
    }
    return s;
}

/* Read the sections: the unit from HEADER, layers from TABLES, then BLOCKS and ENTITIES. */
static lw_status read_sections(reader *r)
{
    enum { OTHER, TABLES, BLOCKS, ENTITIES } in = OTHER;
    bool more = true, unit = false, section = false, layer = false;
    size_t blocks = 0;
    group g;
    lw_status s;
    r->drawn = SIZE_MAX;
    while ((s = take_group(&r->c, &g, &more)) == LW_OK && more) {
        if (g.code == 0 && (is(&g, "ENDSEC") || is(&g, "EOF"))) {
            s = in == BLOCKS ? find_blocks(r, blocks) : LW_OK;
            if (s != LW_OK || in == ENTITIES)
                return s;
            in = OTHER;
        } else if (g.code == 9) {
            unit = is(&g, "$INSUNITS");
        } else if (g.code == 70 && unit && in == OTHER) {
            s = set_unit(r, &g);
        } else if (g.code == 2 && section) {
            in = is(&g, "TABLES") ? TABLES : is(&g, "BLOCKS") ? BLOCKS : is(&g, "ENTITIES") ? ENTITIES : OTHER;
            blocks = r->n_entity;
            r->drawn = in == ENTITIES ? r->n_entity : r->drawn;
        } else if (in == TABLES) {
            if (g.code == 0)
                layer = is(&g, "LAYER");
            if (g.code == 0 && layer) {
                r->hidden = r->n_hidden == 0 ? r->n_entity : r->hidden;
                r->n_hidden++;
            }
            s = layer ? keep(r, &g) : LW_OK;
        } else if (in != OTHER) {
            s = keep(r, &g);
        }
        if (s != LW_OK)
            return s;
        section = g.code == 0 && is(&g, "SECTION");
    }
    if (s == LW_OK && in == ENTITIES)
        s = lw_error_at(r->c.e, LW_E_NOTATION, r->c.file, r->c.line, 1, "the drawing ends within its ENTITIES, without ENDSEC: a part of the "
                        "file is missing; save or copy it again");
    return s;
}

lw_status lw_target_read_dxf(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_error own = { .text = "" };
    e = e ? e : &own;
    reader r = { .c = lw_cursor_start(text, size, file, e), .out = { .unit = "mm", .scale = 1 } };
    place page = { .m = { .a = 1, .d = 1 } };
    *t = (lw_target){ .n = 0 };
    lw_status s = lw_text_check(text, size, file, e);
    if (s == LW_OK)
        s = read_sections(&r);
    if (s == LW_OK)
        s = draw_all(&r, r.drawn == SIZE_MAX ? r.n_entity : r.drawn, r.n_entity, &page, 0);
    if (s == LW_OK && r.out.n > 0)
        s = join_pieces(&r);
    else if (s == LW_OK && r.n_point > 0 && r.drawn != SIZE_MAX)
        s = draw_points(&r, &page);
    if (s == LW_OK && r.out.n == 0 && !r.out.failed)
        s = lw_error_at(e, LW_E_NOTATION, file, r.c.line, 1, "there is no visible line, arc, circle, ellipse, spline "
                        "or polyline in the ENTITIES of this drawing%s%s", r.other[0] ? ", only things such as " : "",
                        r.other);
    if (s == LW_OK)
        s = lw_outlines_target(&r.out, file, o, t, e);
    lw_outlines_free(&r.out);
    free(r.g);
    free(r.entity);
    free(r.block);
    return s;
}

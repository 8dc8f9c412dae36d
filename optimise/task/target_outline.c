/* optimise/task/target_outline.c - make stations from the points of a drawn curve. */
#include "optimise/task/target_outline_internal.h"

#include <math.h>
#include <stdlib.h>

#include "grammar/linkage.h"

void lw_outline_free(lw_outline *c)
{
    free(c->p);
    free(c->line);
    *c = (lw_outline){ .n = 0 };
}

void lw_outline_add(lw_outline *c, lw_vec2 p, long line)
{
    if (c->failed || (c->n > 0 && c->p[c->n - 1].x == p.x && c->p[c->n - 1].y == p.y))
        return;
    if (c->n == c->room) {
        size_t room = c->room ? 2*c->room : 256;
        lw_vec2 *q = room <= LW_OUTLINE_MAX ? realloc(c->p, room*sizeof *q) : NULL;
        c->p = q ? q : c->p;
        long *l = q ? realloc(c->line, room*sizeof *l) : NULL;
        c->line = l ? l : c->line;
        c->failed = !l;
        if (!l)
            return;
        c->room = room;
    }
    c->p[c->n] = p;
    c->line[c->n++] = line;
}

void lw_outline_arc(lw_outline *c, lw_vec2 at, double sweep, lw_vec2 end, long line)
{
    int n = (int)ceil(fmin(fabs(sweep)/(2*LW_PI), 1)*LW_OUTLINE_ARCS) + 1;
    if (c->n == 0)
        return;
    lw_vec2 radius = lw_v2_sub(c->p[c->n - 1], at);
    c->curved = true;
    for (int i = 1; i < n; i++)
        lw_outline_add(c, lw_v2_add(at, lw_v2_turn(radius, lw_v2_polar(1, sweep*i/n))), line);
    lw_outline_add(c, end, line);
}

/* Place points at equal steps along the polygon; a closed one ends at its first point. */
static lw_status spread(lw_outline *c, bool closed, lw_error *e)
{
    size_t n = LW_OUTLINE_STATIONS, at = 0, last = c->n - (closed ? 0 : 1);
    double length = 0, before = 0;
    lw_vec2 *p = malloc(n*sizeof *p);
    long *line = malloc(n*sizeof *line);
    if (!p || !line) {
        free(p);
        free(line);
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a curve");
    }
    for (size_t i = 0; i < last; i++)
        length += lw_v2_norm(lw_v2_sub(c->p[(i + 1) % c->n], c->p[i]));
    for (size_t i = 0; i < n; i++) {
        double at_length = length*(double)i/(double)(closed ? n : n - 1), step = 0;
        for (; at < last; at++) {
            step = lw_v2_norm(lw_v2_sub(c->p[(at + 1) % c->n], c->p[at]));
            if (before + step >= at_length)
                break;
            before += step;
        }
        at = at < last ? at : last - 1;
        lw_vec2 a = c->p[at], b = c->p[(at + 1) % c->n];
        double u = step > 0 ? fmin(1, (at_length - before)/step) : 0;
        p[i] = lw_v2_add(a, lw_v2_scale(lw_v2_sub(b, a), u));
        line[i] = c->line[at];
    }
    free(c->p);
    free(c->line);
    c->p = p;
    c->line = line;
    c->n = n;
    return LW_OK;
}

static lw_status check(const lw_outline *c, const char *file, lw_error *e)
{
    if (c->failed)
        return lw_error_at(e, LW_E_MEMORY, file, 0, 0, "the curve has more than %d points, or memory ran out",
                           LW_OUTLINE_MAX/2);
    for (size_t i = 0; i < c->n; i++)
        if (!(fabs(c->p[i].x) <= LW_COORDINATE_MAX && fabs(c->p[i].y) <= LW_COORDINATE_MAX))
            return lw_error_at(e, LW_E_NOTATION, file, c->line[i], 1, "a point of the curve is too far away, or no "
                               "number");
    if (!c->curved && c->n > LW_STATION_MAX)
        return lw_error_at(e, LW_E_NOTATION, file, 1, 1, "the curve has %zu corners; %d are allowed", c->n,
                           LW_STATION_MAX);
    return LW_OK;
}

static lw_status to_target(const lw_outline *c, const char *file, double metre, int closed, lw_target *t, lw_error *e)
{
    lw_error why = { .text = "" };
    double *xy = malloc((2*c->n + 1)*sizeof *xy);
    if (!xy)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a curve");
    for (size_t i = 0; i < c->n; i++) {
        xy[i] = c->p[i].x*metre;
        xy[c->n + i] = c->p[i].y*metre;
    }
    lw_status s = lw_target_make(c->n, xy, xy + c->n, NULL, NULL, NULL, closed, t, &why);
    if (s != LW_OK)
        lw_error_at(e, LW_E_NOTATION, file, 1, 1, "%s", why.text);
    for (size_t i = 0; s == LW_OK && i < c->n; i++)
        t->line[i] = c->line[i];
    free(xy);
    return s;
}

lw_status lw_outline_target(lw_outline *c, const char *file, const char *unit, const lw_target_options *o, lw_target *t,
                            lw_error *e)
{
    lw_units units = lw_units_si();
    lw_status s = check(c, file, e);
    *t = (lw_target){ .n = 0 };
    const char *length = o && o->length_unit ? o->length_unit : unit;
    if (s == LW_OK && !lw_units_set_length(&units, length))
        s = lw_error_set(e, LW_E_ARG, "there is no length unit '%s'; m, mm, cm, km, um, in and ft are known", length);
    if (s == LW_OK && o && o->angle_unit && !lw_units_set_angle(&units, o->angle_unit))
        s = lw_error_set(e, LW_E_ARG, "there is no angle unit '%s'; rad, deg and turn are known", o->angle_unit);
    double size = 0;
    for (size_t i = 1; s == LW_OK && i < c->n; i++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(c->p[i], c->p[0])));
    bool meets = c->n > 2 && s == LW_OK && lw_v2_norm(lw_v2_sub(c->p[c->n - 1], c->p[0])) <= 1e-6*size;
    bool closed = c->closed || meets;
    if (meets)
        c->n--;
    if (o && o->closed >= 0)
        closed = o->closed > 0;
    if (s == LW_OK && c->n > 1 && c->curved)
        s = spread(c, c->n > 2 && closed, e);
    if (s == LW_OK)
        s = to_target(c, file, units.metre, closed && c->n > 2, t, e);
    if (s == LW_OK)
        t->units = units;
    lw_outline_free(c);
    return s;
}

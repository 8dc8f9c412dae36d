/* optimise/task/target_outline.c - the curves of a drawing, and the target made of those that are wanted. */
#include "base/number.h"
#include "base/real.h"
#include "optimise/task/target_outline_internal.h"
#include "optimise/task/target_tour.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "grammar/linkage/linkage.h"

#define POINTS (1 + LW_ALSO_MAX)

/* ---- memory --------------------------------------------------------------------------------------------------- */

void lw_outlines_free(lw_outlines *d)
{
    for (int i = 0; i < d->n; i++) {
        free(d->curve[i].p);
        free(d->curve[i].line);
    }
    free(d->curve);
    *d = (lw_outlines){ .n = 0 };
}

void lw_outlines_begin(lw_outlines *d, const char *name, const char *label, const char *group)
{
    if (d->n == d->room) {
        int room = d->room ? 2*d->room : 64;
        lw_outline *p = room <= LW_DRAWN_CURVE_MAX ? realloc(d->curve, (size_t)room*sizeof *p) : NULL;
        d->failed = d->failed || !p;
        if (!p)
            return;
        d->curve = p;
        d->room = room;
    }
    lw_outline *c = &d->curve[d->n++];
    *c = (lw_outline){ .n = 0 };
    snprintf(c->name[0], sizeof c->name[0], "%s", name);
    snprintf(c->name[1], sizeof c->name[1], "%s", label);
    snprintf(c->name[2], sizeof c->name[2], "%s", group);
}

void lw_outlines_add(lw_outlines *d, lw_vec2 p, long line)
{
    lw_outline *c = d->n > 0 ? &d->curve[d->n - 1] : NULL;
    if (!c || d->failed || (c->n > 0 && c->p[c->n - 1].x == p.x && c->p[c->n - 1].y == p.y))
        return;
    if (c->n == c->room) {
        size_t room = c->room ? 2*c->room : 8;
        lw_vec2 *q = d->points <= LW_OUTLINE_MAX ? realloc(c->p, room*sizeof *q) : NULL;
        c->p = q ? q : c->p;
        long *l = q ? realloc(c->line, room*sizeof *l) : NULL;
        c->line = l ? l : c->line;
        d->failed = !l;
        if (!l)
            return;
        c->room = room;
    }
    c->p[c->n] = p;
    c->line[c->n++] = line;
    d->points++;
}

/* Close the last curve; a last point that repeats the first is dropped. */
void lw_outlines_close(lw_outlines *d)
{
    lw_outline *c = d->n > 0 ? &d->curve[d->n - 1] : NULL;
    if (!c || c->n < 2)
        return;
    c->closed = c->n > 2;
    if (c->n > 3 && c->p[c->n - 1].x == c->p[0].x && c->p[c->n - 1].y == c->p[0].y)
        c->n--;
}

/* ---- what is drawn -------------------------------------------------------------------------------------------- */

static double length_of(const lw_outline *c)
{
    double length = 0;
    for (size_t i = 1; i < c->n; i++)
        length += lw_v2_norm(lw_v2_sub(c->p[i], c->p[i-1]));
    return length;
}

/* Drop points that repeat the one before but for rounding, where pieces meet: their direction would be a corner. */
static void drop_repeats(lw_outline *c, double near)
{
    size_t n = c->n > 0;
    for (size_t i = 1; i < c->n; i++)
        if (lw_v2_norm(lw_v2_sub(c->p[i], c->p[n-1])) > near) {
            c->p[n] = c->p[i];
            c->line[n++] = c->line[i];
        }
    c->n = n;
}

/* Drop curves without a length, and close those whose ends nearly meet. */
static void tidy(lw_outlines *d)
{
    int n = 0;
    for (int i = 0; i < d->n; i++) {
        lw_outline *c = &d->curve[i];
        double length = length_of(c), gap = c->n > 2 ? lw_v2_norm(lw_v2_sub(c->p[c->n - 1], c->p[0])) : INFINITY;
        if (!d->only_points)
            drop_repeats(c, 1e-7*length);
        if (c->n < 2 && !d->only_points) {
            free(c->p);
            free(c->line);
            continue;
        }
        if (!c->closed && !d->only_points && gap <= length/20)
            c->closed = true;
        if (c->closed && c->n > 3 && gap <= 1e-6*length)
            c->n--;
        d->curve[n++] = *c;
    }
    d->n = n;
}

static lw_status check(const lw_outlines *d, const char *file, lw_error *e)
{
    if (d->failed)
        return lw_error_at(e, LW_E_MEMORY, file, 0, 0, "the drawing has more than %d curves or %d points, or memory "
                           "ran out", LW_DRAWN_CURVE_MAX, LW_OUTLINE_MAX);
    for (int i = 0; i < d->n; i++)
        for (size_t k = 0; k < d->curve[i].n; k++)
            if (!(fabs(d->curve[i].p[k].x)*d->scale <= LW_COORDINATE_MAX && fabs(d->curve[i].p[k].y)*d->scale <= LW_COORDINATE_MAX))
                return lw_error_at(e, LW_E_NOTATION, file, d->curve[i].line[k], 1, "a point of the curve is too far away, or no number");
    return LW_OK;
}

/* ---- which are wanted ----------------------------------------------------------------------------------------- */

static const char *name_of(const lw_outline *c)
{
    return c->name[1][0] ? c->name[1] : c->name[0][0] ? c->name[0] : c->name[2];
}

static double length_in(const lw_outlines *d, const lw_outline *c)
{
    double gap = c->closed ? lw_v2_norm(lw_v2_sub(c->p[c->n - 1], c->p[0])) : 0;
    return (length_of(c) + gap)*d->scale;
}

/* List the curves: "1 'rect4' closed 120 mm, 2 'path10' open 84.2 mm". */
static void list_curves(const lw_outlines *d, char *text, size_t size)
{
    size_t used = 0;
    for (int i = 0; i < d->n; i++) {
        const lw_outline *c = &d->curve[i];
        const char *name = name_of(c);
        if (used + 120 > size) {
            snprintf(text + used, size - used, ", ...");
            return;
        }
        used += (size_t)snprintf(text + used, size - used, "%s%d%s%s%s %s %.5g %s", i ? ", " : "", i + 1,
                                 name[0] ? " '" : "", name, name[0] ? "'" : "", c->closed ? "closed" : "open",
                                 length_in(d, c), d->unit);
    }
}

static lw_status take_curve(int which, int chosen[POINTS], int *n, lw_error *e)
{
    for (int i = 0; i < *n; i++)
        if (chosen[i] == which)
            return LW_OK;
    if (*n == POINTS)
        return lw_error_set(e, LW_E_ARG, "more than %d curves are named; a linkage is fitted to %d points at most", POINTS, POINTS);
    chosen[(*n)++] = which;
    return LW_OK;
}

/* Take the curves that a word means: their name, else a number from 1, else all. */
static lw_status take_word(const lw_outlines *d, const char *word, size_t size, int chosen[POINTS], int *n, lw_error *e)
{
    char list[420];
    int before = *n;
    lw_status s = LW_OK;
    for (int i = 0; i < d->n && s == LW_OK; i++)
        for (int k = 0; k < 3; k++)
            if (strlen(d->curve[i].name[k]) == size && strncasecmp(d->curve[i].name[k], word, size) == 0) {
                s = take_curve(i, chosen, n, e);
                break;
            }
    if (s != LW_OK || *n > before)
        return s;
    long number = size > 0 && size < 7 && isdigit((unsigned char)*word) ? strtol(word, NULL, 10) : 0;
    if (number >= 1 && number <= d->n && strspn(word, "0123456789") >= size)
        return take_curve((int)number - 1, chosen, n, e);
    if (size == 3 && strncasecmp(word, "all", 3) == 0) {
        for (int i = 0; i < d->n && s == LW_OK; i++)
            s = take_curve(i, chosen, n, e);
        return s;
    }
    list_curves(d, list, sizeof list);
    return lw_error_set(e, LW_E_ARG, "there is no curve '%.*s' in this drawing; it has %s", size > 40 ? 40 : (int)size, word, list);
}

static lw_status choose(const lw_outlines *d, const char *file, const char *words, int chosen[POINTS], int *n, lw_error *e)
{
    lw_status s = LW_OK;
    char list[420];
    lw_error why = { .text = "" };
    *n = 0;
    if (!words && d->n == 1)
        return take_curve(0, chosen, n, e);
    if (!words) {
        list_curves(d, list, sizeof list);
        return lw_error_at(e, LW_E_NOTATION, file, d->curve[1].line[0], 1, "this drawing has %d curves: %s. Put the "
                           "one that is wanted behind the name of the file, as FILE#1 or FILE#NAME; several (FILE#1,2 "
                           "or FILE#all, at most %d) become the points of one linkage", d->n, list, POINTS);
    }
    while (s == LW_OK && *words) {
        size_t size = strcspn(words, ",");
        s = take_word(d, words, size, chosen, n, &why);
        words += size + (words[size] == ',');
    }
    if (s == LW_OK && *n == 0)
        s = lw_error_set(&why, LW_E_ARG, "the name of the curve that is wanted is empty");
    return s == LW_OK ? s : lw_error_at(e, s, file, 0, 0, "%s", why.text);
}

/* ---- the target ----------------------------------------------------------------------------------------------- */

/* Places of one curve in metres, in arrays of m. */
typedef struct places { double *x, *y; long *line; } places;

/* Smooth a curve and put its stations. */
static lw_status place(const lw_outline *c, double metre, bool closed, double smooth, size_t m, bool drawn,
                       bool by_curvature, places *to, double moved[2], lw_error *e)
{
    size_t n = c->n, *from = malloc((m + 1)*sizeof *from);
    double *xy = malloc(2*n*sizeof *xy), rms = 0, most = 0;
    lw_vec2 *p = malloc((n + m)*sizeof *p);
    lw_status s = from && xy && p ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory for a curve");
    for (size_t i = 0; s == LW_OK && i < n; i++) {
        xy[i] = c->p[i].x*metre;
        xy[n + i] = c->p[i].y*metre;
    }
    if (s == LW_OK && smooth > 0)
        s = lw_smooth(xy, xy + n, n, closed, smooth, &rms, &most, e);
    for (size_t i = 0; s == LW_OK && i < n; i++)
        p[i] = lw_v2(xy[i], xy[n + i]);
    if (s == LW_OK && !drawn)
        s = lw_resample(p, n, closed, by_curvature, m, p + n, from, e);
    for (size_t i = 0; s == LW_OK && i < m; i++) {
        lw_vec2 q = p[drawn ? i : n + i];
        to->x[i] = q.x;
        to->y[i] = q.y;
        to->line[i] = c->line[drawn ? i : from[i]];
    }
    moved[0] = fmax(moved[0], rms);
    moved[1] = fmax(moved[1], most);
    free(from);
    free(xy);
    free(p);
    return s;
}

/* Say what was assumed; length: that of the first curve in the unit. */
static void write_note(const lw_outlines *d, const lw_outline *c, int n, const lw_target *t, double length,
                       bool unit_known, const double *moved, char *note, size_t size)
{
    const char *name = name_of(c), *unit = t->units.length;
    int used = 0;
    if (n > 1)
        used = snprintf(note, size, "%d curves, %zu stations each; stations at the same share of the length belong together", n, t->n);
    else if (d->only_points)
        used = snprintf(note, size, "%zu point%s as stations, in the order of the file", t->n, lw_plural((long long)t->n));
    else
        used = snprintf(note, size, "%s curve%s%s%s, %.5g %s long, %zu stations", t->closed ? "closed" : "open",
                        name[0] ? " '" : "", name, name[0] ? "'" : "", length, unit, t->n);
    if (moved)
        used += snprintf(note + used, size - (size_t)used, "; smoothed: it lies %.3g %s (RMS) from the drawn points, "
                         "%.3g at most", moved[0]/t->units.metre, unit, moved[1]/t->units.metre);
    if (!unit_known)
        snprintf(note + used, size - (size_t)used, "; lengths count as %s, since the drawing has no unit", unit);
}

static lw_status to_target(const lw_outlines *d, const int chosen[POINTS], int n, const char *file, const char *unit,
                           const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_units units = lw_units_si();
    lw_also also[LW_ALSO_MAX];
    lw_error why = { .text = "" };
    double moved[2] = { 0, 0 };
    const lw_outline *first = &d->curve[chosen[0]];
    bool closed = o && o->closed >= 0 ? o->closed > 0 : first->closed, drawn = d->only_points || (o && o->stations < 0);
    size_t m = drawn ? first->n : o && o->stations > 0 ? (size_t)o->stations : LW_OUTLINE_STATIONS;
    lw_units_set_length(&units, d->unit);
    double metre = units.metre*d->scale;
    if (unit) {                                   /* the drawing is in this unit, whatever it says */
        lw_units_set_length(&units, unit);
        metre = units.metre;
    }
    double smooth = o ? o->smooth*units.metre : 0;
    for (int i = 0; i < n; i++) {
        const lw_outline *c = &d->curve[chosen[i]];
        if (!(o && o->closed >= 0) && c->closed != closed)
            return lw_error_at(e, LW_E_NOTATION, file, c->line[0], 1, "one of these curves is closed and one open; "
                               "points of one linkage run through theirs together (--closed or --open decides)");
        if (drawn && c->n != m)
            return lw_error_at(e, LW_E_NOTATION, file, c->line[0], 1, "these curves are drawn with %zu and %zu points; "
                               "give a number of stations", m, c->n);
    }
    if (m > LW_STATION_MAX)
        return lw_error_at(e, LW_E_NOTATION, file, first->line[0], 1, "the curve has %zu points; %d stations are allowed",
                           m, LW_STATION_MAX);
    double *xy = malloc((size_t)n*2*m*sizeof *xy);
    long *line = malloc(m*sizeof *line);
    lw_status s = xy && line ? LW_OK : lw_error_set(&why, LW_E_MEMORY, "out of memory for a curve");
    for (int i = n - 1; i >= 0 && s == LW_OK; i--) {
        places to = { xy + (size_t)(2*i)*m, xy + (size_t)(2*i + 1)*m, line };
        const lw_outline *c = &d->curve[chosen[i]];
        s = place(c, metre, closed && c->n > 2, smooth, m, drawn, n == 1, &to, moved, &why);
        if (i > 0)
            also[i-1] = (lw_also){ .x = to.x, .y = to.y };
    }
    if (s == LW_OK)
        s = lw_target_make_all(m, xy, xy + m, NULL, NULL, NULL, also, n - 1,
                               d->only_points ? (o ? o->closed : -1) : closed && m > 2, t, &why);
    if (s != LW_OK)
        lw_error_at(e, s == LW_E_ARG ? LW_E_NOTATION : s, file, 1, 1, "%s", why.text);
    for (size_t i = 0; s == LW_OK && i < m; i++)
        t->line[i] = line[i];
    if (s == LW_OK) {
        double gap = t->closed ? lw_v2_norm(lw_v2_sub(first->p[first->n - 1], first->p[0])) : 0;
        t->units = units;
        t->noise = moved[0];
        write_note(d, first, n, t, (length_of(first) + gap)*metre/units.metre, unit || d->unit_given,
                   smooth > 0 ? moved : NULL, t->note, sizeof t->note);
        if (d->only_points)
            s = lw_target_look_at_order(t, o ? o->closed : -1, e);
    }
    free(xy);
    free(line);
    return s == LW_E_ARG ? LW_E_NOTATION : s;
}

lw_status lw_outlines_target(lw_outlines *d, const char *file, const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_units units = lw_units_si();
    int chosen[POINTS], n = 0;
    lw_status s = check(d, file, e);
    const char *unit = o ? o->length_unit : NULL;
    *t = (lw_target){ .n = 0 };
    if (s == LW_OK && unit && !lw_units_set_length(&units, unit))
        s = lw_error_set(e, LW_E_ARG, "there is no length unit '%s'; m, mm, cm, km, um, in and ft are known", unit);
    if (s == LW_OK && o && o->angle_unit && !lw_units_set_angle(&units, o->angle_unit))
        s = lw_error_set(e, LW_E_ARG, "there is no angle unit '%s'; rad, deg and turn are known", o->angle_unit);
    tidy(d);
    if (s == LW_OK && d->n == 0)
        s = lw_error_at(e, LW_E_NOTATION, file, 1, 1, "all curves of this drawing have no length");
    if (s == LW_OK)
        s = choose(d, file, o ? o->curve : NULL, chosen, &n, e);
    if (s == LW_OK)
        s = to_target(d, chosen, n, file, unit, o, t, e);
    if (s == LW_OK && o && o->angle_unit)
        lw_units_set_angle(&t->units, o->angle_unit);
    return s;
}

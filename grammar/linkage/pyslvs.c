#include "grammar/linkage/pyslvs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/growable_array.h"
#include "base/vec2.h"
#include "grammar/linkage/points_internal.h"

typedef struct reader {
    lw_cursor c;
    lw_points *p;
    double    metre;
    int       n_pair, most_pairs;
    struct pair { int point[2]; lw_cursor at; } *pair;      /* points of the inputs */
} reader;

/* ---- comments ---------------------------------------------------------------------------------- */

/* Read the two numbers of points behind "# input". */
static lw_status read_pair(reader *r, const lw_cursor *start)
{
    int a, b;
    lw_cursor_skip(&r->c, false, 0);
    bool good = lw_cursor_number(&r->c, &a);
    lw_cursor_skip(&r->c, false, 0);
    if (!good || !lw_cursor_number(&r->c, &b))
        return lw_cursor_fail(start, "\"# input\" is followed by the numbers of two points: at the base, on the driven link");
    struct pair *more = lw_array_grow(r->pair, r->n_pair, &r->most_pairs, sizeof *more);
    if (!more)
        return lw_error_set(start->e, LW_E_MEMORY, "out of memory");
    r->pair = more;
    more[r->n_pair++] = (struct pair){ { a, b }, *start };
    return LW_OK;
}

/* Skip blanks, line ends and comments. */
static lw_status skip(reader *r)
{
    lw_cursor *c = &r->c;
    for (;;) {
        lw_cursor_skip(c, true, 0);
        lw_cursor start = *c;
        if (lw_cursor_begins(c, "#[")) {
            while (lw_cursor_peek(c) >= 0 && !lw_cursor_begins(c, "#]"))
                lw_cursor_next(c);
            if (lw_cursor_peek(c) < 0)
                return lw_cursor_fail(&start, "this comment is not closed by #]");
        } else if (lw_cursor_peek(c) == '#') {
            lw_cursor_next(c);
            lw_cursor_skip(c, false, 0);
            if (lw_cursor_begins(c, "input ")) {
                lw_cursor_step(c, 6);
                lw_status s = read_pair(r, &start);
                if (s != LW_OK)
                    return s;
            }
        } else {
            return LW_OK;
        }
        while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '\n')
            lw_cursor_next(c);
    }
}

/* ---- grammar ------------------------------------------------------------------------------------ */

static lw_status want(reader *r, const char *token, const char *where)
{
    char buf[24];
    lw_status s = skip(r);
    if (s != LW_OK)
        return s;
    for (const char *t = token; *t; t++) {
        if (lw_cursor_peek(&r->c) != *t)
            return lw_cursor_fail(&r->c, "'%s' is expected %s, not %s", token, where, lw_byte_name(lw_cursor_peek(&r->c), buf));
        lw_cursor_next(&r->c);
    }
    return LW_OK;
}

/* Length of the letters, digits and underscores that come next; r->c does not move. */
static size_t word(reader *r)
{
    size_t n = 0;
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
    while (r->c.at + n < r->c.size && r->c.text[r->c.at + n]
           && strchr(n ? letters : (char[]){ "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_" },
                     r->c.text[r->c.at + n]))
        n++;
    return n;
}

static lw_status number(reader *r, const char *what, double *v)
{
    lw_status s = skip(r);
    return s == LW_OK ? lw_points_number(&r->c, what, v) : s;
}

static lw_status read_type(reader *r, lw_point *q)
{
    lw_status s = skip(r);
    size_t n = word(r);
    char name[8] = "";
    if (s != LW_OK)
        return s;
    for (int i = 0; i < 3; i++)
        if (strlen(lw_point_type_text[i]) == n && lw_cursor_begins(&r->c, lw_point_type_text[i])) {
            q->type = (lw_point_type)i;
            lw_cursor_step(&r->c, n);
            return LW_OK;
        }
    snprintf(name, sizeof name, "%.*s", n < sizeof name ? (int)n : 7, r->c.text + r->c.at);
    return lw_cursor_fail(&r->c, "a joint is R, P or RP%s%s", n ? ", not " : "", name);
}

/* Skip color[NAME] or color[(r, g, b)]. */
static lw_status read_color(reader *r)
{
    lw_cursor start = r->c;
    lw_status s = want(r, "color[", "here");
    while (s == LW_OK && lw_cursor_peek(&r->c) >= 0 && lw_cursor_peek(&r->c) != ']')
        lw_cursor_next(&r->c);
    if (s == LW_OK && lw_cursor_next(&r->c) < 0)
        s = lw_cursor_fail(&start, "this colour is not closed by ]");
    return s;
}

static lw_status read_angle(reader *r, lw_point *q)
{
    double v = 0;
    lw_status s = want(r, "A[", "here");
    if (s == LW_OK)
        s = number(r, "an angle", &v);
    q->angle = v*(LW_PI/180);
    return s == LW_OK ? want(r, "]", "behind an angle") : s;
}

static lw_status read_place(reader *r, lw_point *q)
{
    double x = 0, y = 0;
    lw_status s = want(r, "P[", "for the place");
    if (s == LW_OK)
        s = number(r, "x", &x);
    if (s == LW_OK)
        s = want(r, ",", "between x and y");
    if (s == LW_OK)
        s = number(r, "y", &y);
    q->at = lw_v2(x*r->metre, y*r->metre);
    return s == LW_OK ? want(r, "]", "behind a place") : s;
}

/* Read a list after "X[" up to the closing bracket: items by `item`, separated by commas; a last comma is allowed. */
static lw_status read_list(reader *r, lw_status (*item)(reader *r, lw_point *q), lw_point *q, const char *what)
{
    char buf[24];
    for (;;) {
        lw_status s = skip(r);
        if (s != LW_OK)
            return s;
        if (lw_cursor_peek(&r->c) == ']') {
            lw_cursor_next(&r->c);
            return LW_OK;
        }
        s = item(r, q);
        if (s == LW_OK)
            s = skip(r);
        if (s != LW_OK)
            return s;
        if (lw_cursor_peek(&r->c) == ',')
            lw_cursor_next(&r->c);
        else if (lw_cursor_peek(&r->c) != ']')
            return lw_cursor_fail(&r->c, "',' or ']' is expected behind %s, not %s", what, lw_byte_name(lw_cursor_peek(&r->c), buf));
    }
}

static lw_status read_link(reader *r, lw_point *q)
{
    char buf[24];
    size_t n = word(r);
    if (n == 0)
        return lw_cursor_fail(&r->c, "a link's name is expected (letters, digits, _), not %s", lw_byte_name(lw_cursor_peek(&r->c), buf));
    lw_status s = lw_points_join(r->p, q, &r->c, n);
    lw_cursor_step(&r->c, n);
    return s;
}

static lw_status read_joint(reader *r, lw_point *unused)
{
    (void)unused;
    lw_point *q = NULL;
    lw_cursor start = r->c;
    bool turned = false;
    lw_status s = lw_points_add(r->p, &start, &q);
    if (s == LW_OK)
        s = want(r, "J[", "for a joint");
    if (s == LW_OK)
        s = read_type(r, q);
    if (s == LW_OK)
        s = want(r, ",", "behind the kind of a joint");
    while (s == LW_OK && (s = skip(r)) == LW_OK
           && (lw_cursor_begins(&r->c, "A[") || lw_cursor_begins(&r->c, "color["))) {
        turned = turned || lw_cursor_begins(&r->c, "A[");
        s = lw_cursor_begins(&r->c, "A[") ? read_angle(r, q) : read_color(r);
        if (s == LW_OK)
            s = want(r, ",", "here");
    }
    if (s == LW_OK && q->type != LW_POINT_PIN && !turned)
        s = lw_cursor_fail(&r->c, "the angle of the slide line, A[...], is missing");
    if (s == LW_OK)
        s = read_place(r, q);
    if (s == LW_OK)
        s = want(r, ",", "behind the place");
    if (s == LW_OK)
        s = want(r, "L[", "for the links");
    if (s == LW_OK)
        s = read_list(r, read_link, q, "a link");
    return s == LW_OK ? want(r, "]", "at the end of a joint") : s;
}

/* The link that a pair drives: a link at the base, not the ground, that also has the other point. */
static lw_status set_inputs(reader *r)
{
    lw_points *p = r->p;
    for (int i = 0; i < r->n_pair; i++) {
        int a = r->pair[i].point[0], b = r->pair[i].point[1];
        if (a >= p->n_point || b >= p->n_point)
            return lw_cursor_fail(&r->pair[i].at, "there is no point %d; they count from 0 to %d", a >= p->n_point ? a : b, p->n_point - 1);
        lw_point *base = &p->point[a], *tip = &p->point[b];
        base->driven = true;
        for (int k = 0; k < base->n_link; k++)
            for (int l = 0; l < tip->n_link; l++)
                if (base->link[k] == tip->link[l] && base->link[k] != p->ground)
                    base->driven_link = base->link[k];
        if (base->driven_link < 0)
            return lw_cursor_fail(&r->pair[i].at, "points %d and %d are on no moving link together", a, b);
    }
    return LW_OK;
}

lw_status lw_pyslvs_read(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e)
{
    char buf[24];
    lw_points *p = lw_points_create();
    *linkage = (lw_assembly){ 0 };
    if (!p)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    reader r = { .c = lw_cursor_start(text, size, file, e), .p = p, .metre = units->metre };
    lw_status s = lw_text_check(text, size, file, e);
    if (s == LW_OK)
        s = want(&r, "M[", "at the beginning");
    if (s == LW_OK)
        s = read_list(&r, read_joint, NULL, "a joint");
    if (s == LW_OK)
        s = skip(&r);
    if (s == LW_OK && lw_cursor_peek(&r.c) >= 0)
        s = lw_cursor_fail(&r.c, "nothing is expected behind the expression, not %s", lw_byte_name(lw_cursor_peek(&r.c), buf));
    if (s == LW_OK)
        s = set_inputs(&r);
    if (s == LW_OK)
        s = lw_points_linkage(p, units, &r.c, linkage);
    free(r.pair);
    lw_points_free(p);
    return s;
}

/* ---- writing ----------------------------------------------------------------------------------- */

static void print_point(FILE *f, const lw_points *p, const lw_point *q, double metre)
{
    lw_point_numbers n = lw_point_print(q, metre);
    fprintf(f, "J[%s", lw_point_type_text[q->type]);
    if (q->type != LW_POINT_PIN)
        fprintf(f, ", A[%s]", n.angle);
    fprintf(f, ", color[%s], P[%s, %s], L[", q->n_link == 1 ? "Blue" : "Green", n.x, n.y);
    for (int i = 0; i < q->n_link; i++)
        fprintf(f, "%s%s", i ? ", " : "", p->name[q->link[i]]);
    fputs("]]", f);
}

/* Another point of the link than `base`; base itself if there is none, and for sliders. */
static int tip_of(const lw_points *p, int base)
{
    int link = p->point[base].driven_link;
    for (int i = 0; p->point[base].type == LW_POINT_PIN && i < p->n_point; i++)
        for (int l = 0; i != base && l < p->point[i].n_link; l++)
            if (p->point[i].link[l] == link)
                return i;
    return base;
}

static void print_points(FILE *f, const lw_points *p, double metre)
{
    for (int i = 0; i < p->n_point; i++) {
        fputs(i ? ",\n  " : "M[", f);
        print_point(f, p, &p->point[i], metre);
    }
    fputs("]\n", f);
    for (int i = 0; i < p->n_point; i++)
        if (p->point[i].driven)
            fprintf(f, "# input %d %d\n", i, tip_of(p, i));
}

char *lw_pyslvs_write(const lw_assembly *linkage, lw_error *e) { return lw_points_text(linkage, print_points, e); }

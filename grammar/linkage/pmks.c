#include "grammar/linkage/pmks.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "base/growable_array.h"
#include "base/vec2.h"
#include "grammar/linkage/points_internal.h"

/* The pieces of a joint, separated by commas and blanks. */
typedef struct piece { lw_cursor at; size_t size; } piece;
typedef struct entry { int n, capacity; piece *piece; } entry;

/* ---- tokens ------------------------------------------------------------------------------------- */

static bool ends_entry(int byte) { return byte < 0 || byte == '\n' || byte == '|'; }

static bool take_separator(lw_cursor *c)
{
    int byte = lw_cursor_peek(c);
    if (lw_cursor_begins(c, "%20"))
        lw_cursor_step(c, 2);
    else if (byte != ',' && byte != ' ' && byte != '\t' && byte != '\r')
        return false;
    lw_cursor_next(c);
    return true;
}

/* Read the pieces up to the end of the line or a bar, and skip that. */
static lw_status split(lw_cursor *c, entry *t)
{
    t->n = 0;
    for (;;) {
        while (take_separator(c))
            ;
        if (ends_entry(lw_cursor_peek(c))) {
            lw_cursor_next(c);
            return LW_OK;
        }
        piece *more = lw_array_grow(t->piece, t->n, &t->capacity, sizeof *more);
        if (!more)
            return lw_error_set(c->e, LW_E_MEMORY, "out of memory");
        t->piece = more;
        lw_cursor start = more[t->n].at = *c, ahead = *c;
        while (!ends_entry(lw_cursor_peek(c)) && !take_separator(&ahead)) {
            lw_cursor_next(c);
            ahead = *c;
        }
        more[t->n++].size = c->at - start.at;
    }
}

static bool is(const entry *t, int i, const char *word)
{
    return strlen(word) == t->piece[i].size && strncasecmp(t->piece[i].at.text + t->piece[i].at.at, word, t->piece[i].size) == 0;
}

/* ---- a joint ------------------------------------------------------------------------------------ */

static int type_of(const entry *t, int i)
{
    for (int k = 0; k < 3; k++)
        if (is(t, i, lw_point_type_text[k]))
            return k;
    return is(t, i, "G") ? 3 : -1;
}

static bool is_flags(const entry *t, int i)
{
    size_t n = 0;
    while (n < t->piece[i].size && t->piece[i].at.text[t->piece[i].at.at + n] && strchr("tfTF", t->piece[i].at.text[t->piece[i].at.at + n]))
        n++;
    return n == 4 && t->piece[i].size == 4;
}

/* PMKS writes these words in small letters and takes them for the ground. */
static lw_status join(lw_points *p, lw_point *q, const entry *t, int i)
{
    static const char ground[] = "ground";
    static const char *const names[] = { "ground", "gnd", "grnd", "0", "1" };
    for (size_t k = 0; k < sizeof names/sizeof *names; k++)
        if (is(t, i, names[k])) {
            lw_cursor at = t->piece[i].at;
            at.text = ground;
            at.at = 0;
            return lw_points_join(p, q, &at, sizeof ground - 1);
        }
    return lw_points_join(p, q, &t->piece[i].at, t->piece[i].size);
}

static lw_status token_number(const entry *t, int i, const char *what, double *v)
{
    lw_cursor c = t->piece[i].at, start = c;
    lw_status s = lw_points_number(&c, what, v);
    if (s == LW_OK && c.at - start.at != t->piece[i].size)
        s = lw_cursor_fail(&start, "%s: this is no number", what);
    return s;
}

static lw_status read_numbers(const entry *t, int first, const lw_cursor *end, double metre, lw_point *q)
{
    double x = 0, y = 0, angle = 0;
    int i = first;
    if (t->n - first < 2)
        return lw_cursor_fail(end, "x and y are wanted behind the kind of joint");
    lw_status s = token_number(t, i++, "x", &x);
    if (s == LW_OK)
        s = token_number(t, i++, "y", &y);
    if (s == LW_OK && i < t->n && !is_flags(t, i))
        s = token_number(t, i++, "the angle", &angle);
    if (s == LW_OK && i < t->n && is_flags(t, i)) {
        q->driven = tolower((unsigned char)t->piece[i].at.text[t->piece[i].at.at + 3]) == 't';
        i++;
    }
    if (s == LW_OK && i < t->n)
        s = lw_cursor_fail(&t->piece[i].at, "links, kind, x, y, angle and four letters t or f make a joint; this is more");
    q->at = lw_v2(x*metre, y*metre);
    q->angle = angle*(LW_PI/180);
    return s;
}

static lw_status read_entry(lw_points *p, const entry *t, const lw_cursor *end, double metre)
{
    lw_point *q = NULL;
    int kind = 1;
    lw_status s = lw_points_add(p, &t->piece[0].at, &q);
    while (s == LW_OK && kind < t->n && type_of(t, kind) < 0)
        kind++;
    if (s == LW_OK && kind >= t->n)
        return lw_cursor_fail(&t->piece[0].at, "a joint is: links, then R, P or RP, then x and y; there is no R, P or RP");
    if (s == LW_OK && type_of(t, kind) == 3)
        return lw_cursor_fail(&t->piece[kind].at, "gears (G) are not read: their ratio is not said");
    for (int i = 0; s == LW_OK && i < kind; i++)
        s = join(p, q, t, i);
    if (s != LW_OK)
        return s;
    q->type = (lw_point_type)type_of(t, kind);
    return read_numbers(t, kind + 1, end, metre, q);
}

/* Skip "mech=" and the web address before it.  True if a whole line was skipped (a setting such as d=0). */
static bool take_setting(lw_cursor *c)
{
    lw_cursor ahead = *c;
    while (lw_cursor_begins(c, "http") && lw_cursor_peek(&ahead) >= 0 && lw_cursor_peek(&ahead) != '\n'
           && !lw_cursor_begins(&ahead, "mech="))
        lw_cursor_next(&ahead);
    if (lw_cursor_begins(&ahead, "mech=")) {
        lw_cursor_step(&ahead, 5);
        *c = ahead;
        return false;
    }
    for (ahead = *c; lw_cursor_peek(&ahead) > 0 && isalpha(lw_cursor_peek(&ahead));)
        lw_cursor_next(&ahead);
    if (ahead.at == c->at || lw_cursor_peek(&ahead) != '=')
        return false;
    while (lw_cursor_peek(&ahead) >= 0 && lw_cursor_peek(&ahead) != '\n')
        lw_cursor_next(&ahead);
    *c = ahead;
    return true;
}

/* If no joint is marked as driven, the joint of a link named "input" at the ground is. */
static void default_input(lw_points *p)
{
    for (int i = 0; i < p->n_point; i++)
        if (p->point[i].driven)
            return;
    for (int i = 0; i < p->n_point; i++) {
        lw_point *q = &p->point[i];
        int input = -1;
        bool ground = false;
        for (int l = 0; l < q->n_link; l++) {
            ground = ground || q->link[l] == p->ground;
            if (strcasecmp(p->name[q->link[l]], "input") == 0)
                input = q->link[l];
        }
        if (input >= 0 && ground && q->type != LW_POINT_SLOT) {
            q->driven = true;
            q->driven_link = input;
            return;
        }
    }
}

lw_status lw_pmks_read(const char *text, size_t size, const char *file, const lw_units *units, lw_assembly *linkage, lw_error *e)
{
    lw_points *p = lw_points_create();
    entry t = { 0 };
    *linkage = (lw_assembly){ 0 };
    lw_status s = p ? lw_text_check(text, size, file, e) : lw_error_set(e, LW_E_MEMORY, "out of memory for a linkage");
    lw_cursor c = lw_cursor_start(text, size, file, e), end = c;
    while (s == LW_OK && lw_cursor_peek(&c) >= 0) {
        if (c.column == 1 && take_setting(&c))
            continue;
        s = split(&c, &t);
        end = t.n > 0 ? t.piece[t.n - 1].at : c;
        if (s == LW_OK && t.n > 0)
            s = read_entry(p, &t, &end, units->metre);
    }
    if (s == LW_OK) {
        default_input(p);
        s = lw_points_linkage(p, units, &c, linkage);
    }
    free(t.piece);
    lw_points_free(p);
    return s;
}

/* ---- writing ----------------------------------------------------------------------------------- */

static void print_points(FILE *f, const lw_points *p, double metre)
{
    for (int i = 0; i < p->n_point; i++) {
        const lw_point *q = &p->point[i];
        lw_point_numbers n = lw_point_print(q, metre);
        for (int l = 0; l < q->n_link; l++)
            fprintf(f, "%s,", p->name[q->link[l]]);
        fprintf(f, "%s,%s,%s", lw_point_type_text[q->type], n.x, n.y);
        if (q->type != LW_POINT_PIN)
            fprintf(f, ",%s", n.angle);
        fprintf(f, ",%cff%c\n", q->n_link == 1 ? 't' : 'f', q->driven ? 't' : 'f');
    }
}

char *lw_pmks_write(const lw_assembly *linkage, lw_error *e) { return lw_points_text(linkage, print_points, e); }

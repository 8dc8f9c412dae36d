#include "grammar/topology/franke.h"

#include <string.h>
#include "grammar/text/text_internal.h"

/* Keep the lines sorted by circles, then by weight. */
static bool insert_line(lw_franke *f, int a, int b, int weight)
{
    uint8_t row[3] = { (uint8_t)(a < b ? a : b), (uint8_t)(a < b ? b : a), (uint8_t)weight };
    int at = f->n_line;
    if (at == LW_FRANKE_LINE_MAX)
        return false;
    for (; at > 0; at--) {
        uint8_t before[3] = { f->end[at - 1][0], f->end[at - 1][1], f->weight[at - 1] };
        if (memcmp(before, row, sizeof row) <= 0)
            break;
        memcpy(f->end[at], f->end[at - 1], sizeof *f->end);
        f->weight[at] = f->weight[at - 1];
    }
    f->end[at][0] = row[0];
    f->end[at][1] = row[1];
    f->weight[at] = row[2];
    f->n_line++;
    return true;
}

/* Follow the string of binary links from circle a over link b to the next circle. */
static int follow(const lw_chain *c, uint32_t circles, int a, int b, int *weight, int *last)
{
    *weight = 0;
    *last = a;
    while (!(circles >> b & 1)) {
        int next = __builtin_ctz(lw_chain_neighbours(c, b) & ~(1u << *last));
        ++*weight;
        *last = b;
        b = next;
    }
    return b;
}

static lw_status lines_of(const lw_chain *c, uint32_t circles, const int *number, lw_franke *f)
{
    for (uint32_t m = circles; m; m &= m - 1) {
        int a = __builtin_ctz(m), weight, last;
        for (uint32_t to = lw_chain_neighbours(c, a); to; to &= to - 1) {
            int first = __builtin_ctz(to), b = follow(c, circles, a, first, &weight, &last);
            /* each line is found from both of its ends; count it once */
            if ((b > a || (b == a && last > first)) && !insert_line(f, number[a], number[b], weight))
                return LW_E_ARG;
        }
    }
    return LW_OK;
}

lw_status lw_franke_from_chain(const lw_chain *c, lw_franke *f)
{
    uint32_t circles = 0;
    int number[LW_LINK_MAX] = { 0 };
    memset(f, 0, sizeof *f);
    if (lw_chain_count(c, 2) > 0)
        return LW_E_KIND;
    if (!lw_chain_is_connected(c))
        return LW_E_ARG;
    for (int i = 0; i < c->n_link; i++) {
        if (lw_chain_degree(c, i) < 2)
            return LW_E_ARG;
        if (lw_chain_degree(c, i) > 2) {
            number[i] = f->n_circle++;
            circles |= 1u << i;
        }
    }
    if (f->n_circle > 0)
        return lines_of(c, circles, number, f);
    insert_line(f, 0, 0, c->n_link);
    return LW_OK;
}

/* Add line l as a string of links that begins at `next`.  Returns NULL, or the error as text. */
static const char *add_string(const lw_franke *f, int l, int *next, lw_chain *c)
{
    int at = f->end[l][0], last = f->end[l][1], n = f->weight[l];
    if (*next + n > LW_LINK_MAX)
        return "the chain would have too many links";
    if (f->n_circle == 0) {                       /* a ring: its first link serves as both ends */
        at = last = (*next)++;
        n--;
    }
    for (; n > 0; n--) {
        if (lw_chain_freedom(c, at, *next) || lw_chain_join(c, at, *next, 1) != LW_OK)
            return "this line cannot be strung";
        at = (*next)++;
    }
    if (at == last)
        return "this line joins a link to itself";
    if (lw_chain_freedom(c, at, last))
        return "this line joins two links that share a joint already";
    return lw_chain_join(c, at, last, 1) == LW_OK ? NULL : "this line cannot be strung";
}

/* Returns NULL, or the error as text; *line gets the faulty line, LW_FRANKE_LINE_MAX for the whole. */
static const char *build(const lw_franke *f, lw_chain *c, int *line)
{
    int n_link = f->n_circle, next = f->n_circle;
    uint8_t degree[LW_LINK_MAX] = { 0 };
    *line = LW_FRANKE_LINE_MAX;
    for (int l = 0; l < f->n_line; l++)
        n_link += f->weight[l];
    if (n_link > LW_LINK_MAX)
        return "the chain would have too many links";
    if (lw_chain_clear(c, n_link) != LW_OK)
        return "there is no link";
    if (f->n_circle == 0 && f->n_line != 1)
        return "a chain without circles is one closed line";
    for (int l = 0; l < f->n_line; l++) {
        *line = l;
        const char *fault = add_string(f, l, &next, c);
        if (fault)
            return fault;
        degree[f->end[l][0]]++;
        degree[f->end[l][1]]++;
    }
    *line = LW_FRANKE_LINE_MAX;
    for (int i = 0; i < f->n_circle; i++)
        if (degree[i] < 3)
            return "a circle has three lines or more";
    return lw_chain_is_connected(c) ? NULL : "the lines do not connect all circles";
}

lw_status lw_franke_chain(const lw_franke *f, lw_chain *c)
{
    int line;
    lw_chain out;
    if (build(f, &out, &line))
        return LW_E_ARG;
    *c = out;
    return LW_OK;
}

size_t lw_franke_print(const lw_franke *f, char *buf, size_t size)
{
    lw_text t = lw_text_start(buf, size);
    int degree[LW_LINK_MAX] = { 0 };
    for (int l = 0; l < f->n_line; l++) {
        degree[f->end[l][0]]++;
        degree[f->end[l][1]]++;
    }
    lw_text_byte(&t, '(');
    for (int i = 0; i < f->n_circle; i++)
        lw_text_add(&t, "%s%d", i > 0 ? " " : "", degree[i]);
    lw_text_byte(&t, ')');
    for (int l = 0; l < f->n_line; l++)
        if (f->n_circle == 0)
            lw_text_add(&t, " :%d", f->weight[l]);
        else
            lw_text_add(&t, " %d-%d:%d", f->end[l][0] + 1, f->end[l][1] + 1, f->weight[l]);
    return t.length;
}

/* ---- reading ----------------------------------------------------------------------------------- */

/* The text read so far, and the place of each line (in the order of reading). */
typedef struct reading {
    lw_franke *f;
    int        said[LW_LINK_MAX];          /* number inside a circle */
    lw_cursor  circle[LW_LINK_MAX];
    int        n_read, row[LW_FRANKE_LINE_MAX][3];
    lw_cursor  place[LW_FRANKE_LINE_MAX];
} reading;

static lw_status want_byte(lw_cursor *c, char byte, const char *why)
{
    char name[24];
    if (lw_cursor_peek(c) != byte)
        return lw_cursor_fail(c, "%s where '%c' %s was expected", lw_byte_name(lw_cursor_peek(c), name), byte, why);
    lw_cursor_next(c);
    return LW_OK;
}

static lw_status want_number(lw_cursor *c, int least, int most, const char *what, int *value)
{
    lw_cursor at = *c;
    char name[24];
    if (!lw_cursor_number(c, value))
        return lw_cursor_fail(&at, "%s where %s was expected", lw_byte_name(lw_cursor_peek(c), name), what);
    if (*value < least || *value > most)
        return lw_cursor_fail(&at, "%d is no %s, which is %d to %d here", *value, strchr(what, ' ') + 1, least, most);
    return LW_OK;
}

static lw_status read_circles(lw_cursor *c, reading *r)
{
    lw_status s = want_byte(c, '(', "before the circles");
    for (;;) {
        lw_cursor_skip(c, false, 0);
        if (s != LW_OK || lw_cursor_peek(c) == ')')
            break;
        if (r->f->n_circle == LW_LINK_MAX)
            return lw_cursor_fail(c, "more than %d circles", LW_LINK_MAX);
        r->circle[r->f->n_circle] = *c;
        s = want_number(c, 3, LW_LINK_MAX - 1, "a number of joints", &r->said[r->f->n_circle++]);
    }
    return s == LW_OK ? want_byte(c, ')', "after the circles") : s;
}

static lw_status read_line(lw_cursor *c, reading *r)
{
    int a = 1, b = 1, weight = 0, n = r->f->n_circle;
    lw_cursor at = *c;
    lw_status s = LW_OK;
    if (n > 0) {
        s = want_number(c, 1, n, "a circle", &a);
        if (s == LW_OK)
            s = want_byte(c, '-', "between two circles");
        if (s == LW_OK)
            s = want_number(c, 1, n, "a circle", &b);
    }
    if (s == LW_OK)
        s = want_byte(c, ':', "before the binary links");
    if (s == LW_OK)
        s = want_number(c, 0, LW_LINK_MAX, "a number of binary links", &weight);
    if (s != LW_OK)
        return s;
    if (r->n_read == LW_FRANKE_LINE_MAX)
        return lw_cursor_fail(&at, "more than %d lines", LW_FRANKE_LINE_MAX);
    int *row = r->row[r->n_read];
    row[0] = (a < b ? a : b) - 1;
    row[1] = (a < b ? b : a) - 1;
    row[2] = weight;
    r->place[r->n_read++] = at;
    insert_line(r->f, row[0], row[1], weight);
    return LW_OK;
}

/* The last place in the text of a sorted line: of equal lines the later one is reported. */
static const lw_cursor *place_of(const reading *r, int l)
{
    for (int k = r->n_read - 1; k > 0; k--)
        if (r->row[k][0] == r->f->end[l][0] && r->row[k][1] == r->f->end[l][1] && r->row[k][2] == r->f->weight[l])
            return &r->place[k];
    return &r->place[0];
}

static lw_status check_reading(const reading *r, const lw_cursor *start)
{
    lw_chain c;
    int line, degree[LW_LINK_MAX] = { 0 };
    for (int l = 0; l < r->f->n_line; l++) {
        degree[r->f->end[l][0]]++;
        degree[r->f->end[l][1]]++;
    }
    for (int i = 0; i < r->f->n_circle; i++)
        if (degree[i] != r->said[i])
            return lw_cursor_fail(&r->circle[i], "circle %d is said to have %d joints, but %d line "
                                  "ends are there", i + 1, r->said[i], degree[i]);
    const char *fault = build(r->f, &c, &line);
    if (fault)
        return lw_cursor_fail(line < LW_FRANKE_LINE_MAX ? place_of(r, line) : start, "%s", fault);
    return LW_OK;
}

lw_status lw_franke_read(const char *text, size_t size, const char *file, lw_franke *f, lw_error *e)
{
    lw_cursor c = lw_cursor_start(text, size, file, e), start = c;
    lw_franke out = { 0 };
    reading r = { .f = &out };
    lw_cursor_skip(&c, false, 0);
    lw_status s = read_circles(&c, &r);
    for (;;) {
        lw_cursor_skip(&c, false, 0);
        int byte = lw_cursor_peek(&c);
        if (s != LW_OK || byte < 0 || byte == '\n' || byte == '\r')
            break;
        s = read_line(&c, &r);
    }
    lw_cursor_skip(&c, true, 0);
    if (s == LW_OK && lw_cursor_peek(&c) >= 0)
        s = lw_cursor_fail(&c, "one line of text is one chain");
    if (s == LW_OK)
        s = check_reading(&r, &start);
    if (s == LW_OK)
        *f = out;
    return s;
}

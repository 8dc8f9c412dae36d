/* grammar/topology/derivation.c - see derivation.h. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "grammar/topology/derivation.h"

/* Text that grows in a buffer and keeps counting when it is full. */
typedef struct writer { char *buf; size_t size, used; } writer;

__attribute__((format(printf, 2, 3)))
static void write(writer *w, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    bool room = w->used < w->size;
    int n = vsnprintf(room ? w->buf + w->used : NULL, room ? w->size - w->used : 0, format, arg);
    va_end(arg);
    w->used += n > 0 ? (size_t)n : 0;
}

size_t lw_derivation_print(const lw_derivation *d, char *buf, size_t size)
{
    writer w = { buf, size, 0 };
    write(&w, "theta");
    for (int k = 0; k < d->n_ear; k++) {
        const lw_ear *ear = &d->ear[k];
        write(&w, " %d(%d", ear->rule, ear->a + 1);
        if (ear->rule != LW_EAR_LINE)
            write(&w, ",%d", ear->b + 1);
        write(&w, ")");
    }
    return w.used;
}

size_t lw_structure_print(const lw_structure *s, char *buf, size_t size)
{
    writer w = { buf, size, 0 };
    uint8_t degree[LW_CIRCLE_MAX];
    lw_structure_degrees(s, degree);
    for (int c = 0; c < s->n_circle; c++)
        write(&w, "%s%d", c ? " " : "(", degree[c]);
    write(&w, ")");
    for (int e = 0; e < s->n_line; e++)
        write(&w, " %d-%d", s->end[e][0] + 1, s->end[e][1] + 1);
    return w.used;
}

/* ---- reading -------------------------------------------------------------------------------------- */

typedef struct reader { const char *text, *file; size_t size, at; lw_error *e; } reader;

static lw_status fault(const reader *r, size_t at, const char *what)
{
    return lw_error_at(r->e, LW_E_NOTATION, r->file, 1, (long)at + 1, "%s", what);
}

static bool take(reader *r, char c)
{
    bool is = r->at < r->size && r->text[r->at] == c;
    r->at += is;
    return is;
}

/* 1 .. 255; 0 when there is no number. */
static int take_number(reader *r)
{
    int n = 0;
    while (r->at < r->size && r->text[r->at] >= '0' && r->text[r->at] <= '9' && n < 100)
        n = 10*n + r->text[r->at++] - '0';
    return n < 256 ? n : 0;
}

static lw_status take_ear(reader *r, lw_structure *s, lw_derivation *d)
{
    size_t start = r->at;
    int rule = take_number(r);
    if (rule < LW_EAR_CIRCLES || rule > LW_EAR_LINE)
        return fault(r, start, "an ear begins with its rule, 1 to 4");
    if (!take(r, '('))
        return fault(r, r->at, "after the rule stands '(' and what the new line joins, for example 1(1,2)");
    int a = take_number(r), b = rule == LW_EAR_LINE ? a : 0;
    if (rule != LW_EAR_LINE && take(r, ','))
        b = take_number(r);
    if (a == 0 || b == 0 || !take(r, ')'))
        return fault(r, r->at, rule == LW_EAR_LINE ? "rule 4 takes one line, as in 4(2)" : "rules 1 to 3 take two numbers, as in 2(1,3)");
    lw_ear ear = { (uint8_t)rule, (uint8_t)(a - 1), (uint8_t)(b - 1) };
    if (d->n_ear == LW_LOOP_MAX - 2 || lw_structure_grow(s, ear, s) != LW_OK)
        return fault(r, start, d->n_ear == LW_LOOP_MAX - 2 ? "there are too many ears"
                     : "the structure has no such circles or lines at this step (the smaller comes first)");
    d->ear[d->n_ear++] = ear;
    return LW_OK;
}

lw_status lw_derivation_read(const char *text, size_t size, const char *file, lw_derivation *d, lw_error *e)
{
    reader r = { text, file, size, 0, e };
    lw_structure s = lw_structure_theta();
    lw_derivation read = { 0 };
    while (r.size > 0 && (text[r.size - 1] == '\n' || text[r.size - 1] == '\r'))
        r.size--;
    if (r.size < 5 || memcmp(text, "theta", 5) != 0)
        return fault(&r, 0, "a derivation begins with its seed, the word theta");
    r.at = 5;
    while (r.at < r.size) {
        if (!take(&r, ' '))
            return fault(&r, r.at, "ears are kept apart by one blank");
        lw_status status = take_ear(&r, &s, &read);
        if (status != LW_OK)
            return status;
    }
    *d = read;
    return LW_OK;
}

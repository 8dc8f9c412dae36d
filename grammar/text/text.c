#include "grammar/text/text_internal.h"
#include "grammar/text/json_locate_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

lw_cursor lw_cursor_start(const char *text, size_t size, const char *file, lw_error *e)
{
    return (lw_cursor){ .text = text, .size = size, .line = 1, .column = 1, .file = file, .e = e };
}

int lw_cursor_peek(const lw_cursor *c)
{
    return c->at < c->size ? (unsigned char)c->text[c->at] : -1;
}

int lw_cursor_next(lw_cursor *c)
{
    int byte = lw_cursor_peek(c);
    if (byte < 0)
        return byte;
    c->at++;
    c->column++;
    if (byte == '\n') {
        c->line++;
        c->column = 1;
    }
    return byte;
}

bool lw_cursor_begins(const lw_cursor *c, const char *word)
{
    size_t n = strlen(word);
    return c->size - c->at >= n && memcmp(c->text + c->at, word, n) == 0;
}

void lw_cursor_step(lw_cursor *c, size_t n)
{
    while (n-- > 0)
        lw_cursor_next(c);
}

void lw_cursor_skip(lw_cursor *c, bool lines, char comment)
{
    for (;;) {
        int byte = lw_cursor_peek(c);
        if (byte == ' ' || byte == '\t' || (lines && (byte == '\n' || byte == '\r')))
            lw_cursor_next(c);
        else if (lines && comment && byte == comment)
            while (lw_cursor_peek(c) >= 0 && lw_cursor_peek(c) != '\n')
                lw_cursor_next(c);
        else
            return;
    }
}

bool lw_cursor_number(lw_cursor *c, int *value)
{
    lw_cursor ahead = *c;
    int v = 0, n = 0;
    for (int byte; (byte = lw_cursor_peek(&ahead)) >= '0' && byte <= '9'; lw_cursor_next(&ahead)) {
        if (++n > 9)
            return false;
        v = 10*v + byte - '0';
    }
    if (n == 0)
        return false;
    *c = ahead;
    *value = v;
    return true;
}

lw_status lw_cursor_fail(const lw_cursor *at, const char *format, ...)
{
    char text[sizeof ((lw_error *)0)->text];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return lw_error_at(at->e, LW_E_NOTATION, at->file ? at->file : "", at->line, at->column, "%s", text);
}

lw_status lw_text_check(const char *text, size_t size, const char *file, lw_error *e)
{
    long line, column;
    const char *zero = size > 0 ? memchr(text, 0, size) : NULL;
    if (!zero)
        return LW_OK;
    lw_text_place(text, size, (size_t)(zero - text), &line, &column);
    return lw_error_at(e, LW_E_NOTATION, file ? file : "", line, column, "a byte 0, which no text holds: the file is damaged, or "
                       "not in UTF-8");
}

const char *lw_byte_name(int byte, char *buf)
{
    if (byte < 0)
        return "the end of the text";
    if (byte == '\n' || byte == '\r')
        return "the end of the line";
    if (byte > ' ' && byte < 127)
        snprintf(buf, 24, "'%c'", byte);
    else
        snprintf(buf, 24, "byte 0x%02x", (unsigned)byte);
    return buf;
}

lw_text lw_text_start(char *buf, size_t size)
{
    if (size > 0)
        buf[0] = '\0';
    return (lw_text){ buf, size, 0 };
}

void lw_text_byte(lw_text *t, char byte)
{
    if (t->length + 1 < t->size) {
        t->buf[t->length] = byte;
        t->buf[t->length + 1] = '\0';
    }
    t->length++;
}

void lw_text_add(lw_text *t, const char *format, ...)
{
    char piece[512];
    va_list list;
    va_start(list, format);
    vsnprintf(piece, sizeof piece, format, list);
    va_end(list);
    for (const char *s = piece; *s; s++)
        lw_text_byte(t, *s);
}

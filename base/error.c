#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Messages quote what was found in files: whatever bytes that were, the text stays one line and
 * cannot steer a terminal. */
static void make_printable(char *s)
{
    for (; *s; s++)
        if ((unsigned char)*s < 0x20 || *s == 0x7f)
            *s = '?';
}

static void fill(lw_error *e, lw_status s, const char *file, long line, long column, const char *format, va_list arg)
{
    e->status = s;
    snprintf(e->file, sizeof e->file, "%s", file ? file : "");
    e->line = line > 0 ? line : 0;
    e->column = line > 0 && column > 0 ? column : 0;
    vsnprintf(e->text, sizeof e->text, format, arg);
    make_printable(e->file);
    make_printable(e->text);
}

lw_status lw_error_set(lw_error *e, lw_status s, const char *format, ...)
{
    if (e) {
        va_list arg;
        va_start(arg, format);
        fill(e, s, "", 0, 0, format, arg);
        va_end(arg);
    }
    return s;
}

lw_status lw_error_at(lw_error *e, lw_status s, const char *file, long line, long column, const char *format, ...)
{
    if (e) {
        va_list arg;
        va_start(arg, format);
        fill(e, s, file, line, column, format, arg);
        va_end(arg);
    }
    return s;
}

void lw_error_print(const lw_error *e, char *buf, int size)
{
    if (!buf || size <= 0)
        return;
    char place[sizeof e->file + 64] = "";
    int n = 0;
    if (e->file[0])
        n = snprintf(place, sizeof place, "%s:", strcmp(e->file, "-") ? e->file : "standard input");
    if (e->line > 0)
        n += snprintf(place + n, sizeof place - (size_t)n, "%s%ld:", n ? "" : "line ", e->line);
    if (e->line > 0 && e->column > 0)
        n += snprintf(place + n, sizeof place - (size_t)n, "%ld:", e->column);
    snprintf(buf, (size_t)size, "%s%s%s", place, n ? " " : "", e->text);
}

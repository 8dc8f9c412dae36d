/* Lines and fields of tables, as people and spreadsheets write them; notes on what was read. */
#include "optimise/task/target_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static bool is_blank(char c) { return c == ' ' || c == '\t'; }

lw_lines lw_lines_start(const char *text, size_t size)
{
    bool marked = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0;     /* byte order mark */
    return (lw_lines){ .text = text, .size = size, .at = marked ? 3 : 0 };
}

/* A line ends with \n, \r\n or \r. */
bool lw_lines_next(lw_lines *l)
{
    if (l->at >= l->size)
        return false;
    const char *s = l->text + l->at;
    size_t rest = l->size - l->at, n = 0;
    while (n < rest && s[n] != '\n' && s[n] != '\r')
        n++;
    l->at += n + (n < rest) + (n + 1 < rest && s[n] == '\r' && s[n+1] == '\n');
    l->number++;
    const char *hash = memchr(s, '#', n);
    l->line = (lw_text_span){ s, hash ? (size_t)(hash - s) : n };
    l->comment = (lw_text_span){ NULL, 0 };
    if (hash)
        l->comment = lw_span_trim((lw_text_span){ hash + 1, n - l->line.n - 1 });
    return true;
}

lw_text_span lw_span_trim(lw_text_span s)
{
    while (s.n > 0 && is_blank(*s.s))
        s.s++, s.n--;
    while (s.n > 0 && is_blank(s.s[s.n - 1]))
        s.n--;
    return s;
}

bool lw_span_blank(lw_text_span s)
{
    while (s.n > 0 && (is_blank(*s.s) || *s.s == ',' || *s.s == ';'))
        s.s++, s.n--;
    return s.n == 0;
}

bool lw_span_is(lw_text_span s, const char *word)
{
    return s.n == strlen(word) && strncasecmp(s.s, word, s.n) == 0;
}

static lw_text_span unquote(lw_text_span s)
{
    if (s.n >= 2 && s.s[0] == '"' && s.s[s.n - 1] == '"')
        return lw_span_trim((lw_text_span){ s.s + 1, s.n - 2 });
    return s;
}

bool lw_field_next(lw_text_span line, char separator, size_t *at, lw_text_span *field)
{
    size_t i = *at;
    if (separator == ' ') {
        while (i < line.n && is_blank(line.s[i]))
            i++;
        if (i == line.n)
            return false;
    } else if (i > line.n) {
        return false;                      /* the field after the last separator was the last one */
    }
    size_t start = i;
    while (i < line.n && is_blank(line.s[i]) && line.s[i] != separator)
        i++;
    const char *quote = i < line.n && line.s[i] == '"' ? memchr(line.s + i + 1, '"', line.n - i - 1) : NULL;
    if (quote)                             /* separators between quotes do not count */
        i = (size_t)(quote - line.s);
    while (i < line.n && (separator == ' ' ? !is_blank(line.s[i]) : line.s[i] != separator))
        i++;
    *field = unquote(lw_span_trim((lw_text_span){ line.s + start, i - start }));
    *at = separator == ' ' ? i : i + 1;
    return true;
}

void lw_target_add_note(lw_target *t, const char *format, ...)
{
    size_t used = strlen(t->note);
    va_list list;
    if (used > 0 && used + 2 < sizeof t->note)
        strcpy(t->note + used, "; ");
    used = strlen(t->note);
    va_start(list, format);
    vsnprintf(t->note + used, sizeof t->note - used, format, list);
    va_end(list);
}

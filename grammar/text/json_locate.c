#include "grammar/text/json_locate_internal.h"

#include <string.h>

typedef struct scan { const char *text; size_t size, at; } scan;

static int peek(const scan *s) { return s->at < s->size ? (unsigned char)s->text[s->at] : -1; }

static void skip_blanks(scan *s)
{
    while (s->at < s->size && strchr(" \t\r\n", s->text[s->at]) && s->text[s->at])
        s->at++;
}

static void skip_string(scan *s)
{
    for (s->at++; s->at < s->size && s->text[s->at] != '"'; s->at++)
        if (s->text[s->at] == '\\')
            s->at++;
    s->at++;
}

/* Skip one value of any kind; brackets are counted, without recursion. */
static void skip_value(scan *s)
{
    long depth = 0;
    do {
        skip_blanks(s);
        int c = peek(s);
        if (c == '"') {
            skip_string(s);
            continue;
        }
        if (c == '{' || c == '[')
            depth++;
        else if (c == '}' || c == ']')
            depth--;
        else if (c != ',' && c != ':')
            while (s->at + 1 < s->size && !strchr(" \t\r\n,:]}", s->text[s->at + 1]))
                s->at++;
        s->at++;
    } while (depth > 0 && s->at < s->size);
}

/* Go from the opening bracket to element `index` (or its key).  False when there are fewer elements. */
static bool enter(scan *s, size_t index, bool key)
{
    bool object = peek(s) == '{';
    if (!object && peek(s) != '[')
        return false;
    s->at++;
    for (size_t i = 0; ; i++) {
        skip_blanks(s);
        if (peek(s) < 0 || peek(s) == '}' || peek(s) == ']')
            return false;
        if (i == index && key)
            return true;
        if (object) {
            skip_string(s);
            skip_blanks(s);
            s->at++;                                  /* the colon */
            skip_blanks(s);
        }
        if (i == index)
            return true;
        skip_value(s);
        skip_blanks(s);
        if (peek(s) == ',')
            s->at++;
    }
}

size_t lw_json_locate(const char *text, size_t size, const lw_json_path *path, bool key)
{
    scan s = { text, size, 0 };
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        s.at = 3;
    skip_blanks(&s);
    for (int i = 0; i < path->n; i++)
        if (!enter(&s, path->index[i], key && i == path->n - 1))
            return size;
    return s.at < size ? s.at : size;
}

void lw_text_place(const char *text, size_t size, size_t offset, long *line, long *column)
{
    size_t start = 0;
    *line = 1;
    for (size_t i = 0; i < offset && i < size; i++)
        if (text[i] == '\n') {
            ++*line;
            start = i + 1;
        }
    *column = (long)(offset - start) + 1;
}

#include "enumerate/published.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define N_COLUMN 8

static const char header[] = "family,dof,links,loops,what,count,source,verified_by";

/* Fields of one line, terminated and freed of their quotes in place.  Returns how many; *at is behind the line. */
static int split(char **at, char **field)
{
    char *s = *at;
    int n = 0;
    for (bool more = true; more;) {
        char *out = s, *start = s;
        bool quoted = *s == '"';
        s += quoted;
        for (; *s && (quoted || (*s != ',' && *s != '\n')); s++) {
            if (quoted && *s == '"' && *++s != '"') {
                quoted = false;
                s--;
                continue;
            }
            *out++ = *s;
        }
        more = *s == ',';
        if (n < N_COLUMN)
            field[n] = start;
        n++;
        s += *s != '\0';
        while (out > start && out[-1] == '\r')
            out--;
        *out = '\0';
    }
    *at = s;
    return n;
}

static bool read_number(const char *text, long long *out)
{
    char *end;
    errno = 0;
    *out = strtoll(text, &end, 10);
    return !errno && end != text && !*end;
}

/* A small number, or -1 for an empty field. */
static bool read_small(const char *text, int *out)
{
    long long v = -1;
    if (*text && (!read_number(text, &v) || v < 0 || v > 1000))
        return false;
    *out = (int)v;
    return true;
}

static lw_status read_row(char **field, int n, const char *file, lw_published *row, lw_error *e)
{
    if (n != N_COLUMN)
        return lw_error_at(e, LW_E_NOTATION, file, row->line, 1, "%d fields, where the header has %d", n, N_COLUMN);
    row->family = field[0];
    row->what = field[4];
    row->source = field[6];
    row->refuted = strncmp(field[7], "refuted", 7) == 0;
    if (!read_small(field[1], &row->dof) || !read_small(field[2], &row->links) || !read_small(field[3], &row->loops))
        return lw_error_at(e, LW_E_NOTATION, file, row->line, 1, "dof, links and loops are small numbers or empty");
    if (!read_number(field[5], &row->count))
        return lw_error_at(e, LW_E_NOTATION, file, row->line, 1, "the count '%.40s' is no whole number", field[5]);
    return LW_OK;
}

static size_t count_lines(const char *text)
{
    size_t n = 1;
    for (; *text; text++)
        n += *text == '\n';
    return n;
}

static lw_status read_rows(const char *file, lw_published_table *t, lw_error *e)
{
    char *at = t->text, *field[N_COLUMN];
    long line = 1;
    if (strncmp(at, header, sizeof header - 1) != 0)
        return lw_error_at(e, LW_E_NOTATION, file, 1, 1, "the header must be %s", header);
    at += strcspn(at, "\n");
    at += *at == '\n';
    for (line = 2; *at; line++) {
        bool empty = *at == '\n' || *at == '\r';
        lw_published *row = &t->row[t->n];
        *row = (lw_published){ .line = line };
        int n = split(&at, field);
        lw_status s = empty ? LW_OK : read_row(field, n, file, row, e);
        if (s != LW_OK)
            return s;
        t->n += !empty;
    }
    return LW_OK;
}

lw_status lw_published_read(const char *text, size_t size, const char *file, lw_published_table *t, lw_error *e)
{
    *t = (lw_published_table){ .text = malloc(size + 1) };
    if (t->text) {
        memcpy(t->text, text, size);
        t->text[size] = '\0';
        t->row = calloc(count_lines(t->text), sizeof *t->row);
    }
    lw_status s = t->row ? read_rows(file ? file : "", t, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s != LW_OK)
        lw_published_free(t);
    return s;
}

void lw_published_free(lw_published_table *t)
{
    free(t->row);
    free(t->text);
    *t = (lw_published_table){ 0 };
}

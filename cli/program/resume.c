#include "cli/program/resume.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The whole lines of a file: their number, where they end, where the last one begins. */
typedef struct lines { uint64_t n; off_t end, last; } lines;

static bool count_lines(FILE *f, lines *l)
{
    char part[1 << 14];
    size_t got;
    off_t at = 0;
    *l = (lines){ 0, 0, 0 };
    rewind(f);
    for (; (got = fread(part, 1, sizeof part, f)) > 0; at += (off_t)got)
        for (char *p = part; (p = memchr(p, '\n', (size_t)(part + got - p))); p++) {
            l->n++;
            l->last = l->end;
            l->end = at + (p - part) + 1;
        }
    return !ferror(f);
}

static bool copy(FILE *from, FILE *to, off_t size)
{
    char part[1 << 14];
    rewind(from);
    for (size_t got; size > 0; size -= (off_t)got) {
        got = fread(part, 1, size < (off_t)sizeof part ? (size_t)size : sizeof part, from);
        if (got == 0 || fwrite(part, 1, got, to) != got)
            return false;
    }
    return fflush(to) == 0;
}

/* Cut f to its first `size` bytes and move to the end. */
static bool cut(FILE *f, off_t size)
{
    return fflush(f) == 0 && ftruncate(fileno(f), size) == 0 && fseeko(f, size, SEEK_SET) == 0;
}

/* Leave in f the lines of `old` if `old` has more, else its own. Keep a copy of the last line. */
static lw_status take_over(FILE *f, FILE *old, cli_resume *r)
{
    lines mine, theirs = { 0, 0, 0 };
    if (!count_lines(f, &mine) || (old && !count_lines(old, &theirs)))
        return LW_E_IO;
    if (theirs.n > mine.n) {
        if (!cut(f, 0) || !copy(old, f, theirs.end))
            return LW_E_IO;
        mine = theirs;
    }
    r->n_line = mine.n;
    r->size = (size_t)(mine.end - mine.last);
    r->last = malloc(r->size + 1);
    if (!r->last)
        return LW_E_MEMORY;
    bool whole = fseeko(f, mine.last, SEEK_SET) == 0 && fread(r->last, 1, r->size, f) == r->size && cut(f, mine.end);
    return whole ? LW_OK : LW_E_IO;
}

lw_status cli_resume_open(const cli_call *call, bool resume, lw_output *o, cli_resume *r, lw_error *e)
{
    const char *path = call->common.output ? call->common.output : "-";
    *r = (cli_resume){ 0, NULL, 0 };
    lw_status status = lw_output_open_partial(o, path, e);
    if (status != LW_OK || !o->temp[0])
        return status;                           /* a pipe or device has no lines to continue */
    FILE *old = resume ? fopen(o->path, "rb") : NULL;
    status = resume ? take_over(o->f, old, r) : cut(o->f, 0) ? LW_OK : LW_E_IO;
    if (old)
        fclose(old);
    if (status == LW_E_MEMORY)
        return lw_error_set(e, status, "out of memory");
    return status == LW_OK ? status : lw_error_at(e, status, path, 0, 0, "the listing so far cannot be read or copied to %s", o->temp);
}

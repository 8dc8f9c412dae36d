#include "cli/program/topology.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/bytes.h"
#include "base/clock.h"
#include "base/file.h"

/* Text is read in portions, so that chains can be processed while others are still being made. A text longer than
 * PIECE_MAX for one topology is an error. */
#define PORTION   ((size_t)1 << 16)
#define PIECE_MAX ((size_t)1 << 24)

typedef struct source {
    FILE         *f;
    struct stat   opened;
    const char   *path;
    char         *text;
    size_t        capacity;
    lw_topologies t;
    bool          broken;         /* reading has failed */
} source;

static lw_status open_source(source *s, const char *path, lw_error *e)
{
    *s = (source){ .path = path, .f = strcmp(path, "-") ? fopen(path, "rb") : stdin };
    if (!s->f || fstat(fileno(s->f), &s->opened) != 0)
        return lw_file_failed(e, "read", path, errno);
    if (s->f == stdin)
        cli_say_waiting("chains or mechanisms");
    s->t = lw_topologies_open(NULL, 0, path);
    s->t.more = true;
    return LW_OK;
}

static void close_source(source *s)
{
    if (s->f && s->f != stdin)
        fclose(s->f);
    free(s->text);
}

/* Keep the unused text and read more after it. */
static lw_status read_on(source *s, lw_error *e)
{
    size_t left = s->t.size - s->t.at;
    if (left > 0)
        memmove(s->text, s->text + s->t.at, left);
    if (left > PIECE_MAX)
        return lw_error_at(e, LW_E_NOTATION, s->path, s->t.line, 1, "this topology does not end");
    if (left + PORTION > s->capacity) {
        char *more = realloc(s->text, 2*(left + PORTION));
        if (!more)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        s->text = more;
        s->capacity = 2*(left + PORTION);
    }
    size_t n = fread(s->text + left, 1, s->capacity - left, s->f);
    if (ferror(s->f))
        return lw_file_failed(e, "read", s->path, errno);
    bool begins = s->t.text == NULL;             /* a byte order mark may stand before the first topology */
    if (begins && lw_text_is_utf16(s->text, n))
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "this text is in UTF-16; save it in UTF-8");
    s->t.text = s->text;
    s->t.at = begins && n >= 3 && memcmp(s->text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    s->t.size = left + n;
    s->t.more = n > 0;
    return n > 0 ? LW_OK : lw_file_unchanged(fileno(s->f), &s->opened, s->path, e);
}

static lw_status next_topology(source *s, lw_mechanism *m, lw_error *e)
{
    lw_status status;
    while ((status = lw_topologies_next(&s->t, m, e)) == LW_STOPPED)
        if ((status = read_on(s, e)) != LW_OK) {
            s->broken = true;
            return status;
        }
    return status;
}

int cli_topologies_each(const cli_call *call, const char *file, bool keep_going, cli_topology_visit *visit, void *context)
{
    source from;
    lw_error e = { 0 };
    int code = CLI_DONE;
    if (open_source(&from, file ? file : "-", &e) != LW_OK)
        return cli_fail(call, &e);
    while (!cli_interrupted()) {
        lw_mechanism m;
        e = (lw_error){ 0 };
        lw_status s = next_topology(&from, &m, &e);
        if (s == LW_NOTHING || cli_interrupted())
            break;
        bool was_read = s == LW_OK;
        if (was_read)
            s = visit(context, &m, &e);
        if (s == LW_OK)
            continue;
        if (s == LW_STOPPED)
            break;
        if (was_read && e.line == 0 && s != LW_E_IO) {      /* the error concerns the piece as a whole */
            snprintf(e.file, sizeof e.file, "%s", from.path);
            e.line = from.t.first_line;
            e.column = 1;
        }
        code = cli_fail(call, &e);
        if (!keep_going || from.broken || s == LW_E_IO)
            break;
    }
    close_source(&from);
    return code;
}

/* Say once what the notation does not keep. */
static void say_lost(const cli_call *call, const lw_notation *n, const lw_mechanism *m)
{
    static bool said[2];                         /* kinds, choices */
    bool kinds = false, choices = m->ground != LW_NONE || m->output != LW_NONE || m->n_input > 0;
    for (int j = 0; j < m->n_joint; j++)
        kinds = kinds || lw_joint_translates(m->kind[j]) || lw_joint_has_ratio(m->kind[j]);
    if (kinds && !n->keeps_kinds && !said[0])
        cli_note(call, "%s has no joint kinds: sliders and gears are written as joints of one and two freedoms; edges and "
                 "json keep them", n->name);
    if (choices && !n->keeps_choices && !said[1])
        cli_note(call, "%s has no ground link, inputs and output: they are left out; edges and json keep them", n->name);
    said[0] = said[0] || (kinds && !n->keeps_kinds);
    said[1] = said[1] || (choices && !n->keeps_choices);
}

lw_status cli_topology_write(const cli_call *call, FILE *f, const lw_notation *n, const lw_mechanism *m, lw_error *e)
{
    char text[LW_NOTATION_SIZE];
    size_t length;
    say_lost(call, n, m);
    lw_status s = n->print(m, text, sizeof text, &length);
    if (s != LW_OK)
        return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory") : lw_error_set(e, s, "this topology cannot be written as %s", n->name);
    fputs(text, f);
    fputc('\n', f);
    return ferror(f) ? lw_file_failed(e, "written", call->common.output ? call->common.output : "-", errno) : LW_OK;
}

cli_watch cli_watch_begin(const cli_call *call, const char *what, const char *unit)
{
    return (cli_watch){ .call = call, .progress = cli_progress_begin(call, what, unit), .start = lw_clock_wall() };
}

bool cli_watch_goes_on(cli_watch *w, double done)
{
    double limit = w->call->common.time;
    cli_progress_show(&w->progress, done, 0, NULL);
    w->over = w->over || (limit > 0 && lw_clock_wall() - w->start >= limit);
    return !cli_interrupted() && !w->over;
}

int cli_watch_end(cli_watch *w, int code)
{
    cli_progress_end(&w->progress);
    if (w->over && !cli_interrupted())
        cli_note(w->call, "stopped by --time; the results so far are kept");
    return w->over && (code == CLI_DONE || code == CLI_NOTHING) ? CLI_LIMIT : code;
}

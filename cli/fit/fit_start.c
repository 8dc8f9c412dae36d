/* cli/fit/fit_start.c - linkages from which a search starts. */
#include <stdlib.h>

#include "cli/fit/fit.h"
#include "cli/program/model.h"
#include "cli/program/output.h"

enum { START_MAX = 256 };

static lw_status add_start(cli_fit_start *s, const lw_linkage *linkage, lw_error *e)
{
    lw_linkage *more = realloc(s->linkage, sizeof *more*(size_t)(s->n + 1));
    if (!more)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    more[s->n++] = *linkage;
    s->linkage = more;
    return LW_OK;
}

/* Results from the first on, or the one linkage of the text. */
static lw_status add_starts(const char *path, const char *text, size_t size, cli_fit_start *s, lw_error *e)
{
    for (int which = 0; ; which++) {
        lw_linkage k;
        lw_error why = { .text = "" };
        lw_status st = cli_linkage_text(path, which == 0 ? 0 : which + 1, text, size, &k, &why);
        if (st == LW_E_ARG && which > 0)
            return LW_OK;                                /* a single linkage, or the last result was read */
        if (st == LW_OK && which == START_MAX)
            return lw_error_at(e, LW_E_ARG, path, 0, 0, "it holds more than %d linkages, too many to start from", START_MAX);
        if (st != LW_OK) {
            *e = why;
            return st;
        }
        if ((st = lw_start_check(&k, &why)) != LW_OK)
            return lw_error_at(e, st, path, 0, 0, "%s", why.text);
        if ((st = add_start(s, &k, e)) != LW_OK)
            return st;
    }
}

lw_status cli_fit_start_read(const char *path, cli_fit_start *s, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status st = cli_read_file(path, "linkages to start from (JSON)", &text, &size, e);
    if (st == LW_OK)
        st = add_starts(path, text, size, s, e);
    free(text);
    return st;
}

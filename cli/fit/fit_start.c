/* cli/fit/fit_start.c - linkages from which a search starts. */
#include <stdlib.h>

#include "cli/fit/fit.h"
#include "cli/program/model.h"

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

lw_status cli_fit_start_read(const char *path, cli_fit_start *s, lw_error *e)
{
    for (int which = 0; which < START_MAX; which++) {
        lw_linkage k;
        lw_error why = { .text = "" };
        lw_status st = cli_read_linkage(path, which == 0 ? 0 : which + 1, &k, &why);
        if (st != LW_OK && which > 0)
            break;                                       /* a single linkage, or the last result was read */
        if (st != LW_OK) {
            *e = why;
            return st;
        }
        if ((st = lw_start_check(&k, &why)) != LW_OK)
            return lw_error_at(e, st, path, 0, 0, "%s", why.text);
        if ((st = add_start(s, &k, e)) != LW_OK)
            return st;
    }
    return LW_OK;
}

/* cli/fit/fit_start.c - linkages from which a search starts: from an earlier fit, a file, or a catalogue. */
#include <stdlib.h>
#include <string.h>

#include "catalogues/store/nearest.h"
#include "cli/fit/fit.h"
#include "cli/program/model.h"

enum { START_MAX = 256, NEAREST = 24 };

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

lw_status cli_fit_start_nearest(const char *path, const lw_target *t, int links, cli_fit_start *s, lw_error *e)
{
    lw_store *store;
    lw_atlas_hit *hit = calloc(NEAREST, sizeof *hit);
    lw_vec2 *p = malloc(sizeof *p*(t->n + 1));
    int n = 0;
    lw_status st = hit && p ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK && !t->x)
        st = lw_error_set(e, LW_E_ARG, "--atlas starts from curves, and the target has no points");
    for (size_t i = 0; st == LW_OK && i < t->n; i++)
        p[i] = lw_v2(t->x[i], t->y[i]);
    if (st == LW_OK && (st = lw_store_open(path, &(lw_store_options){ .write = false }, &store, e)) == LW_OK) {
        st = lw_store_nearest(store, p, t->n, t->closed, NULL, NEAREST, hit, &n, NULL, e);
        lw_store_close(store);
        st = st == LW_NOTHING ? LW_OK : st;
    }
    for (int i = 0; i < n && st == LW_OK; i++)
        if (hit[i].linkage.n_link <= links && lw_start_check(&hit[i].linkage, NULL) == LW_OK)
            st = add_start(s, &hit[i].linkage, e);
    free(hit);
    free(p);
    return st;
}

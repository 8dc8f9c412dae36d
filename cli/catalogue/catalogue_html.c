/* linkwright catalogue html - a catalogue as web pages that need no server. */

#include "catalogues/pages/atlas_html.h"
#include "cli/catalogue/catalogue.h"

static bool goes_on(void *watch, double done, double total)
{
    cli_catalogue_watch *w = watch;
    w->total = total;
    return cli_catalogue_goes_on(w, done);
}

#define MUCH 200e6               /* bytes of pages above which a limit must be given */

/* CLI_DONE, or the exit code if very many pages would be written and the user has set no limit. */
static int look_ahead(const cli_call *call, lw_store *store, const lw_atlas_html_options *o)
{
    lw_error e = { 0 };
    size_t n = 0;
    double size = 0;
    if (lw_atlas_html_expect(store, o, &n, &size, &e) != LW_OK)
        return cli_fail(call, &e);
    if (size <= MUCH || cli_given(&call->parsed, "results"))
        return CLI_DONE;
    return cli_usage(call, "%zu chains make about %.0f MB of pages: --results 1000 takes the first thousand, --links P "
                     "those with P links, --results %zu all of them", n, 1e-6*size, n);
}

int cli_catalogue_html(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    const char *dir = call->common.output;
    lw_atlas_html_options o = lw_atlas_html_options_default();
    lw_store *store = NULL;
    lw_error e = { 0 };
    size_t n_page = 0, n_byte = 0;
    if (!dir || (dir[0] == '-' && !dir[1]))
        return cli_usage(call, "html makes a folder of pages: name it with -o FOLDER");
    lw_status st = cli_catalogue_open(call, false, &store, &e);
    if (st != LW_OK)
        return cli_fail(call, &e);
    o.links = cli_given(&call->parsed, "links") ? s->links : 0;
    o.limit = cli_given(&call->parsed, "results") ? s->results : 0;
    int code = look_ahead(call, store, &o);
    if (code == CLI_DONE)
        code = cli_catalogue_folder(call, dir, NULL, ".html");
    if (code != CLI_DONE) {
        lw_store_close(store);
        return code;
    }
    cli_catalogue_watch w = cli_catalogue_watch_begin(call, "html", "chains");
    o.jobs = call->common.jobs;
    o.goes_on = goes_on;
    o.context = &w;
    st = lw_atlas_html_write(store, dir, &o, &n_page, &n_byte, &e);
    lw_store_close(store);
    code = cli_catalogue_watch_end(&w, CLI_DONE);
    if (st == LW_STOPPED && code == CLI_LIMIT)
        cli_note(call, "%s; %zu pages are there", e.text, n_page);
    else if (st != LW_OK)
        code = cli_fail(call, &e);
    else
        cli_note(call, "%zu pages, %.1f MB: open %s/index.html", n_page, 1e-6*(double)n_byte, dir);
    return code;
}

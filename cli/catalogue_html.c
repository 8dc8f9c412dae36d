/* linkwright catalogue html - a catalogue as web pages that work from a disk. */
#include "catalogues/atlas_html.h"
#include "cli/catalogue.h"

static bool goes_on(void *watch, double done, double total)
{
    cli_catalogue_watch *w = watch;
    w->total = total;
    return cli_catalogue_goes_on(w, done);
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
    cli_catalogue_watch w = cli_catalogue_watch_begin(call, "html", "chains");
    o.links = cli_given(&call->parsed, "links") ? s->links : 0;
    o.jobs = call->common.jobs;
    o.goes_on = goes_on;
    o.context = &w;
    st = lw_atlas_html_write(store, dir, &o, &n_page, &n_byte, &e);
    lw_store_close(store);
    int code = cli_catalogue_watch_end(&w, CLI_DONE);
    if (st == LW_STOPPED && code == CLI_LIMIT)
        cli_note(call, "%s; %zu pages are there", e.text, n_page);
    else if (st != LW_OK)
        code = cli_fail(call, &e);
    else
        cli_note(call, "%zu pages, %.1f MB: open %s/index.html", n_page, 1e-6*(double)n_byte, dir);
    return code;
}

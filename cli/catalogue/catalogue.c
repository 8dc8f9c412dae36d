/* cli/catalogue/catalogue.c - what the actions of the catalogue command share. */
#include "cli/catalogue/catalogue.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"

void cli_catalogue_limit(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    if (cli_given(&call->parsed, "time"))
        cli_limit_time(s->time);
}

lw_status cli_catalogue_open(const cli_call *call, bool write, lw_store **store, lw_error *e)
{
    const cli_catalogue_settings *s = call->settings;
    lw_store_options o = { .write = write, .create = write, .wait = s->wait, .command = call->line,
                           .stop = cli_stop_flag() };
    cli_catalogue_limit(call);
    return lw_store_open(call->parsed.word[1], &o, store, e);
}

lw_status cli_catalogue_list(const cli_call *call, const char *text, lw_query_list last, lw_query_options *o, lw_error *e)
{
    static const char *const filled[] = { "SELECT EXISTS(SELECT 1 FROM chain)", "SELECT EXISTS(SELECT 1 FROM mechanism)",
                                          "SELECT EXISTS(SELECT 1 FROM linkage)", "SELECT EXISTS(SELECT 1 FROM structure)" };
    const cli_catalogue_settings *s = call->settings;
    o->list = s->list ? (lw_query_list)(s->list - 1) : LW_LIST_ANY;
    if (s->list)
        return LW_OK;
    lw_store *store = NULL;
    lw_query *q = calloc(1, sizeof *q);
    lw_status status = q ? cli_catalogue_open(call, false, &store, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int list = 0; status == LW_OK && list <= (int)last && o->list == LW_LIST_ANY; list++) {
        lw_query_options one = *o;
        lw_error no_field = { 0 };
        long long n = 0;
        one.list = (lw_query_list)list;
        lw_status fits = lw_query_compile(text, &one, q, &no_field);
        lw_query_free(q);
        if (fits == LW_OK && (status = lw_store_number(store, filled[list], NULL, 0, &n, e)) == LW_OK && n)
            o->list = one.list;
        else if (fits == LW_E_MEMORY) {
            *e = no_field;
            status = fits;
        }
    }
    lw_store_close(store);
    free(q);
    return status;
}

int cli_catalogue_folder(const cli_call *call, const char *folder, const char *under, const char *ending)
{
    char path[CLI_PATH_SIZE];
    if ((size_t)snprintf(path, sizeof path, "%s%s%s", folder, under ? "/" : "", under ? under : "") >= sizeof path)
        return cli_usage(call, "the name of the folder '%.60s...' is too long", folder);
    int code = cli_make_folder(call, path);
    DIR *d = code == CLI_DONE ? opendir(path) : NULL;
    for (struct dirent *file; d && code == CLI_DONE && (file = readdir(d));) {
        size_t n = strlen(file->d_name), tail = strlen(ending);
        if (n > tail && strcmp(file->d_name + n - tail, ending) == 0)
            code = cli_may_write_in(call, path, "%s", file->d_name);
    }
    if (d)
        closedir(d);
    return code;
}

cli_catalogue_watch cli_catalogue_watch_begin(const cli_call *call, const char *what, const char *unit)
{
    const cli_catalogue_settings *s = call->settings;
    cli_catalogue_limit(call);
    return (cli_catalogue_watch){ .progress = cli_progress_begin(call, what, unit),
                                  .start = lw_clock_wall(), .limit = cli_given(&call->parsed, "time") ? s->time : 0 };
}

bool cli_catalogue_goes_on(cli_catalogue_watch *w, double done)
{
    cli_progress_show(&w->progress, done, w->total, NULL);
    w->over = w->over || (w->limit > 0 && lw_clock_wall() - w->start >= w->limit);
    return !cli_interrupted() && !w->over;
}

int cli_catalogue_watch_end(cli_catalogue_watch *w, int code)
{
    cli_progress_end(&w->progress);
    return w->over && code == CLI_DONE ? CLI_LIMIT : code;
}

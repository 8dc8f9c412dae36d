/* linkwright catalogue check - check a catalogue, or count again what the table of published counts lists. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "catalogues/build/build.h"
#include "cli/catalogue/catalogue.h"
#include "cli/program/data.h"
#include "cli/program/file_kind.h"
#include "cli/program/json.h"
#include "cli/program/progress.h"

static const char *const verdict_text[] = {
    [LW_AGREES] = "agrees", [LW_DISAGREES] = "DISAGREES", [LW_ERRATUM] = "known erratum",
    [LW_TOO_LONG] = "too long", [LW_NOT_COUNTED] = "not counted",
};

/* ---- the table of published counts ---------------------------------------------------------------------- */

typedef struct table_check {
    const cli_call *call;
    lw_output       out;
    cli_json        json;
    double          start;                      /* [s] lw_clock_wall                                     */
    int             n[LW_NOT_COUNTED + 1];
} table_check;

static void write_json(table_check *c, const lw_published *row, const lw_recount_result *r)
{
    cli_json *w = &c->json;
    *w = cli_json_begin(c->out.f, 0);
    cli_json_object(w, NULL);
    cli_json_int(w, "line", row->line);
    cli_json_text(w, "family", row->family);
    cli_json_int(w, "dof", row->dof);
    cli_json_int(w, "links", row->links);
    cli_json_int(w, "loops", row->loops);
    cli_json_text(w, "what", row->what);
    cli_json_int(w, "published", row->count);
    if (r->verdict <= LW_ERRATUM)
        cli_json_int(w, "counted", r->counted);
    cli_json_text(w, "verdict", verdict_text[r->verdict]);
    cli_json_text(w, "source", row->source);
    cli_json_end(w);
}

static void write_text(table_check *c, const lw_published *row, const lw_recount_result *r)
{
    char counted[32] = "", links[16] = "", dof[16] = "";
    if (r->verdict <= LW_ERRATUM)
        snprintf(counted, sizeof counted, "%lld", r->counted);
    if (r->verdict == LW_TOO_LONG && r->seconds > 0)
        snprintf(counted, sizeof counted, "(%.0f s)", r->seconds);
    if (row->links >= 0)
        snprintf(links, sizeof links, "P=%d ", row->links);
    if (row->dof >= 0)
        snprintf(dof, sizeof dof, "F=%d ", row->dof);
    fprintf(c->out.f, "%12lld %12s  %-13s  %s: %s%s%s", row->count, counted, verdict_text[r->verdict], row->family, dof, links, row->what);
    fprintf(c->out.f, "  [%s]\n", row->source);
}

static double time_left(const table_check *c)
{
    const cli_catalogue_settings *s = c->call->settings;
    return s->time > 0 ? s->time - (lw_clock_wall() - c->start) : INFINITY;
}

static bool goes_on(void *context)
{
    return !cli_interrupted() && time_left(context) > 0;
}

static lw_status check_rows(table_check *c, const lw_published_table *t, lw_recount *r, lw_error *e)
{
    const cli_catalogue_settings *s = c->call->settings;
    cli_progress p = cli_progress_begin(c->call, "check", "rows");
    lw_status status = LW_OK;
    if (!c->call->common.json)
        fprintf(c->out.f, "%12s %12s  %-13s  what  [source]\n", "published", "counted", "verdict");
    for (size_t i = 0; i < t->n && status == LW_OK && !cli_interrupted(); i++) {
        lw_recount_result result;
        status = lw_recount_row(r, &t->row[i], time_left(c), &result);
        if (status != LW_OK || cli_interrupted())
            break;
        c->n[result.verdict]++;
        if (!s->disagreeing || result.verdict == LW_DISAGREES)
            (c->call->common.json ? write_json : write_text)(c, &t->row[i], &result);
        cli_progress_show(&p, (double)(i + 1), (double)t->n, NULL);
    }
    cli_progress_end(&p);
    return status == LW_OK ? LW_OK : lw_error_set(e, status, "out of memory");
}

static lw_status read_table(const char *path, lw_published_table *table, lw_error *e)
{
    char *text = NULL;
    size_t size;
    lw_status s = lw_file_read(path, &text, &size, e);
    if (s == LW_OK)
        s = lw_published_read(text, size, path, table, e);
    free(text);
    return s;
}

static int check_table(const cli_call *call)
{
    table_check c = { .call = call, .start = lw_clock_wall() };
    lw_published_table table = { 0 };
    lw_error e = { 0 };
    char path[CLI_PATH_SIZE];
    if (call->parsed.n_word > 1)
        snprintf(path, sizeof path, "%s", call->parsed.word[1]);
    else
        cli_data_path("published-counts.csv", path, sizeof path);
    lw_status s = read_table(path, &table, &e);
    lw_recount *r = s == LW_OK ? lw_recount_create(call->common.jobs, goes_on, &c) : NULL;
    if (s == LW_OK && !r)
        s = lw_error_set(&e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        s = cli_open(call, &c.out, &e);
    int code = CLI_DONE;
    if (s != LW_OK) {
        code = cli_fail(call, &e);
    } else {
        if (check_rows(&c, &table, r, &e) != LW_OK)
            code = cli_fail(call, &e);
        else if (c.n[LW_DISAGREES] > 0)
            code = CLI_NUMERIC;
        code = (code == CLI_NUMERIC && c.n[LW_DISAGREES] > 0 ? cli_close_marked : cli_close)(call, &c.out, code);
        cli_note(call, "%d rows agree, %d disagree, %d known errata, %d too long, %d not counted here",
                 c.n[LW_AGREES], c.n[LW_DISAGREES], c.n[LW_ERRATUM], c.n[LW_TOO_LONG], c.n[LW_NOT_COUNTED]);
    }
    lw_recount_free(r);
    lw_published_free(&table);
    return code;
}

/* ---- a catalogue ---------------------------------------------------------------------------------------- */

typedef struct file_check {
    const cli_call *call;
    lw_output       out;
    long            n_agree, n_differ;
} file_check;

static void show_row(void *context, const lw_published *row, long long counted)
{
    file_check *c = context;
    const cli_catalogue_settings *s = c->call->settings;
    bool agrees = counted == row->count;
    const char *verdict = verdict_text[agrees ? LW_AGREES : row->refuted ? LW_ERRATUM : LW_DISAGREES];
    c->n_agree += agrees;
    c->n_differ += !agrees && !row->refuted;
    if (s->disagreeing && (agrees || row->refuted))
        return;
    if (!c->call->common.json) {
        fprintf(c->out.f, "%12lld %12lld  %-13s  P=%d F=%d %s\n", row->count, counted, verdict, row->links, row->dof, row->what);
        return;
    }
    cli_json w = cli_json_begin(c->out.f, 0);
    cli_json_object(&w, NULL);
    cli_json_int(&w, "links", row->links);
    cli_json_int(&w, "dof", row->dof);
    cli_json_text(&w, "what", row->what);
    cli_json_int(&w, "published", row->count);
    cli_json_int(&w, "counted", counted);
    cli_json_text(&w, "verdict", verdict);
    cli_json_text(&w, "source", row->source);
    cli_json_end(&w);
}

static bool not_interrupted(void *context, double done, double total)
{
    (void)context, (void)done, (void)total;
    return !cli_interrupted();
}

static int check_store(const cli_call *call, lw_store *store)
{
    file_check c = { .call = call };
    lw_build_control control = { .goes_on = not_interrupted };
    lw_published_table table = { 0 };
    lw_error e = { 0 };
    uint64_t n_chain, n_open;
    char path[CLI_PATH_SIZE];
    lw_status s = lw_build_check(store, &control, &n_chain, &n_open, &e);
    if (s == LW_OK)
        s = cli_open(call, &c.out, &e);
    if (s != LW_OK)
        return cli_fail(call, &e);
    if (!call->common.json)
        fprintf(c.out.f, "%12s %12s  %-13s  what\n", "published", "counted", "verdict");
    cli_data_path("published-counts.csv", path, sizeof path);
    s = read_table(path, &table, &e);
    if (s == LW_OK)
        s = lw_build_check_published(store, &table, show_row, &c, &e);
    lw_published_free(&table);
    if (s < 0) {
        lw_output_abandon(&c.out);
        return cli_fail(call, &e);
    }
    int code = cli_close_marked(call, &c.out, c.n_differ > 0 ? CLI_NUMERIC : CLI_DONE);
    cli_note(call, "the file is whole; %llu chains are what their labels say; %ld published numbers agree, %ld do not; "
             "%llu build%s not finished", (unsigned long long)n_chain, c.n_agree, c.n_differ,
             (unsigned long long)n_open, n_open == 1 ? " is" : "s are");
    return code;
}

/* A file is a catalogue by its first bytes or by its name; any other file is a table. */
static bool is_catalogue(const char *path)
{
    const char *dot = strrchr(path, '.');
    return cli_is_catalogue(path) || (dot && (strcmp(dot, ".db") == 0 || strcmp(dot, ".sqlite") == 0));
}

int cli_catalogue_check(const cli_call *call)
{
    lw_store *store;
    lw_error e = { 0 };
    if (call->parsed.n_word < 2 || !is_catalogue(call->parsed.word[1]))
        return check_table(call);
    if (cli_catalogue_open(call, false, &store, &e) != LW_OK)
        return cli_fail(call, &e);
    int code = check_store(call, store);
    lw_store_close(store);
    return code;
}

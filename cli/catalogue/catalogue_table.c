/* linkwright catalogue check - the published tables, recounted. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "cli/catalogue/catalogue.h"
#include "cli/program/data.h"
#include "cli/program/json.h"
#include "cli/program/progress.h"
#include "enumerate/published.h"

static const char *const verdict_text[] = {
    [LW_AGREES] = "agrees", [LW_DISAGREES] = "DISAGREES", [LW_ERRATUM] = "known erratum",
    [LW_TOO_LONG] = "too long", [LW_NOT_COUNTED] = "not counted",
};

typedef struct check {
    const cli_call *call;
    lw_output       out;
    cli_json        json;
    int             n[LW_NOT_COUNTED + 1];
} check;

static void write_json(check *c, const lw_published *row, const lw_recount_result *r)
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

static void write_text(check *c, const lw_published *row, const lw_recount_result *r)
{
    char counted[32] = "", links[16] = "", dof[16] = "";
    if (r->verdict <= LW_ERRATUM)
        snprintf(counted, sizeof counted, "%lld", r->counted);
    if (r->verdict == LW_TOO_LONG)
        snprintf(counted, sizeof counted, "(%.0f s)", r->seconds);
    if (row->links >= 0)
        snprintf(links, sizeof links, "P=%d ", row->links);
    if (row->dof >= 0)
        snprintf(dof, sizeof dof, "F=%d ", row->dof);
    fprintf(c->out.f, "%12lld %12s  %-13s  %s: %s%s%s", row->count, counted, verdict_text[r->verdict], row->family,
            dof, links, row->what);
    fprintf(c->out.f, "  [%s]\n", row->source);
}

static lw_status check_rows(check *c, const lw_published_table *t, lw_recount *r, lw_error *e)
{
    const cli_catalogue_settings *s = c->call->settings;
    double start = lw_clock_wall();
    cli_progress p = cli_progress_begin(c->call, "check", "rows");
    lw_status status = LW_OK;
    if (!c->call->common.json)
        fprintf(c->out.f, "%12s %12s  %-13s  what  [source]\n", "published", "counted", "verdict");
    for (size_t i = 0; i < t->n && status == LW_OK && !cli_interrupted(); i++) {
        lw_recount_result result;
        status = lw_recount_row(r, &t->row[i], s->time - (lw_clock_wall() - start), &result);
        if (status != LW_OK)
            break;
        c->n[result.verdict]++;
        if (!s->disagreeing || result.verdict == LW_DISAGREES)
            (c->call->common.json ? write_json : write_text)(c, &t->row[i], &result);
        cli_progress_show(&p, (double)(i + 1), (double)t->n, NULL);
    }
    cli_progress_end(&p);
    return status == LW_OK ? LW_OK : lw_error_set(e, status, "out of memory");
}

/* The table of the user, else the one that comes with the program. */
static void table_path(const cli_call *call, char *path, size_t size)
{
    if (call->parsed.n_word > 1)
        snprintf(path, size, "%s", call->parsed.word[1]);
    else
        cli_data_path("published-counts.csv", path, size);
}

int cli_catalogue_check(const cli_call *call)
{
    check c = { .call = call };
    char *text = NULL;
    size_t size;
    lw_published_table table = { 0 };
    lw_error e = { 0 };
    char path[4096];
    table_path(call, path, sizeof path);
    lw_status s = lw_file_read(path, &text, &size, &e);
    if (s == LW_OK)
        s = lw_published_read(text, size, path, &table, &e);
    free(text);
    lw_recount *r = s == LW_OK ? lw_recount_create(call->common.jobs) : NULL;
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
        code = cli_close(call, &c.out, code);
        cli_note(call, "%d rows agree, %d disagree, %d known errata, %d too long, %d not counted here",
                 c.n[LW_AGREES], c.n[LW_DISAGREES], c.n[LW_ERRATUM], c.n[LW_TOO_LONG], c.n[LW_NOT_COUNTED]);
    }
    lw_recount_free(r);
    lw_published_free(&table);
    return code;
}

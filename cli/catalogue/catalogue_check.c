/* linkwright catalogue check FILE - a catalogue against itself and against the published counts. */
#include <stdlib.h>
#include <string.h>

#include "cli/catalogue/catalogue.h"
#include "cli/program/data.h"
#include "cli/program/json.h"
#include "enumerate/canon.h"
#include "enumerate/published.h"
#include "grammar/graph6.h"

typedef struct check {
    const cli_call *call;
    lw_store       *store;
    lw_output       out;
    lw_error        e;
    long            n_agree, n_differ;
    /* the chain at hand */
    unsigned long long n_chain, n_wrong;
    char            wrong[LW_GRAPH6_SIZE];
} check;

/* ---- every chain: is it what its label says, and does it move with its freedoms? --------------------- */

static lw_status check_chain(void *context, int n_column, const char *const *name, const lw_value *value)
{
    check *c = context;
    lw_chain chain, form;
    char label[LW_GRAPH6_SIZE];
    bool good = value[0].text && value[1].text
             && lw_graph6_read(value[1].text, value[1].size, NULL, &chain, NULL) == LW_OK
             && lw_chain_check(&chain, NULL) == LW_OK && lw_chain_canonical(&chain, &form) == LW_OK
             && lw_chain_mobility(&chain) == (int)value[2].integer && chain.n_link == (int)value[3].integer;
    (void)n_column, (void)name;
    if (good) {
        lw_graph6_print(&form, label, sizeof label);
        good = strcmp(label, value[0].text) == 0;
    }
    c->n_chain++;
    c->n_wrong += !good;
    if (!good && !c->wrong[0])
        snprintf(c->wrong, sizeof c->wrong, "%s", value[1].text ? value[1].text : "");
    return cli_interrupted() ? LW_STOPPED : LW_OK;
}

static lw_status check_chains(check *c)
{
    lw_store_query q = { .sql = "SELECT label, graph6, dof, links FROM chain", .row = check_chain, .context = c };
    lw_status s = lw_store_ask(c->store, &q, &c->e);
    if (s == LW_OK && c->n_wrong > 0)
        s = lw_error_at(&c->e, LW_E_NOTATION, c->call->parsed.word[1], 0, 0, "%llu of %llu chains are not what their "
                        "label says, the first is %s", c->n_wrong, c->n_chain, c->wrong);
    return s;
}

/* ---- counts ---------------------------------------------------------------------------------------- */

#define COMPLETE " FROM chain c WHERE c.links = ?1 AND c.dof = ?2"
#define GROUNDS  "SELECT count(*) FROM ground g JOIN chain c ON c.id = g.chain WHERE c.links = ?1 AND c.dof = ?2"

/* The first row whose text the wording begins with; ?3 is the assortment.  The catalogue has no fractionated
 * chains, so that rows about all chains are told apart by F = 1, where there are none. */
static const struct { const char *begin; const char *sql; bool only_dof_1; } wordings[] = {
    { "all chains with nonplanar", "SELECT count(*)" COMPLETE " AND NOT c.planar", true },
    { "all chains; assortment", "SELECT count(*)" COMPLETE " AND c.assortment = ?3", true },
    { "all chains", "SELECT count(*)" COMPLETE, true },
    { "nonfractionated; assortment", "SELECT count(*)" COMPLETE " AND c.assortment = ?3", false },
    { "assortment", "SELECT count(*)" COMPLETE " AND c.assortment = ?3", false },
    { "inversions; assortment", GROUNDS " AND c.assortment = ?3", false },
    { "inversions of all chains", GROUNDS, true },
    { "inversions of nonfractionated", GROUNDS, false },
    { "nonfractionated chains with nonplanar", "SELECT count(*)" COMPLETE " AND NOT c.planar", false },
    { "chains with nonplanar", "SELECT count(*)" COMPLETE " AND NOT c.planar", false },
    { "nonfractionated chains", "SELECT count(*)" COMPLETE, false },
    { "chains with trivial automorphism", "SELECT count(*)" COMPLETE " AND c.symmetry = 1", false },
};

/* "... [4 4 0]" as it stands in the catalogue: zeros at the end left out. */
static void read_assortment(const char *what, char text[64])
{
    const char *at = strrchr(what, '[');
    size_t n = at ? strcspn(at + 1, "]") : 0;
    text[0] = 0;
    if (!at || n > 60)
        return;
    memcpy(text, at + 1, n);
    text[n] = 0;
    while (n > 2 && text[n - 1] == '0' && text[n - 2] == ' ')
        text[n -= 2] = 0;
}

static const char *sql_of(const lw_published *row)
{
    for (size_t i = 0; i < sizeof wordings/sizeof *wordings; i++)
        if (strncmp(row->what, wordings[i].begin, strlen(wordings[i].begin)) == 0)
            return wordings[i].only_dof_1 && row->dof != 1 ? NULL : wordings[i].sql;
    return NULL;
}

static void show_row(check *c, const lw_published *row, long long counted, bool agrees)
{
    const cli_catalogue_settings *s = c->call->settings;
    const char *verdict = agrees ? "agrees" : row->refuted ? "known erratum" : "DISAGREES";
    if (s->disagreeing && (agrees || row->refuted))
        return;
    if (!c->call->common.json) {
        fprintf(c->out.f, "%12lld %12lld  %-13s  P=%d F=%d %s\n", row->count, counted, verdict, row->links, row->dof,
                row->what);
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

/* A row about a build that is complete in this file. */
static lw_status check_row(check *c, const lw_published *row)
{
    char links[64];
    const char *sql = strcmp(row->family, "simple-joint") == 0 ? sql_of(row) : NULL;
    long long n = 0;
    lw_value v[3] = { { .kind = LW_VALUE_INTEGER, .integer = row->links },
                      { .kind = LW_VALUE_INTEGER, .integer = row->dof }, { .kind = LW_VALUE_TEXT, .text = links } };
    if (!sql)
        return LW_OK;
    lw_status s = lw_store_number(c->store, "SELECT count(*) FROM build WHERE links = ?1 AND dof = ?2 AND complete", v,
                                  2, &n, &c->e);
    if (s != LW_OK || n == 0)
        return s;
    read_assortment(row->what, links);
    v[2].size = strlen(links);
    s = lw_store_number(c->store, sql, v, strstr(sql, "?3") ? 3 : 2, &n, &c->e);
    if (s != LW_OK)
        return s;
    show_row(c, row, n, n == row->count);
    if (n == row->count)
        c->n_agree++;
    else
        c->n_differ += !row->refuted;
    return LW_OK;
}

static lw_status check_published(check *c)
{
    char path[4096], *text = NULL;
    size_t size;
    lw_published_table table = { 0 };
    cli_data_path("published-counts.csv", path, sizeof path);
    lw_status s = lw_file_read(path, &text, &size, &c->e);
    if (s == LW_OK)
        s = lw_published_read(text, size, path, &table, &c->e);
    free(text);
    for (size_t i = 0; i < table.n && s == LW_OK; i++)
        s = check_row(c, &table.row[i]);
    lw_published_free(&table);
    return s;
}

/* Every number of the file that another one of the file fixes. */
static lw_status check_sums(check *c)
{
    static const struct { const char *what, *sql; } sums[] = {
        { "chains of a finished build are missing",
          "SELECT count(*) FROM build b WHERE complete AND done != "
          "(SELECT count(*) FROM chain c WHERE c.links = b.links AND c.dof = b.dof)" },
        { "chains have not all their ground links",
          "SELECT count(*) FROM chain c WHERE grounds != (SELECT count(*) FROM ground g WHERE g.chain = c.id) "
          "OR links != (SELECT sum(alike) FROM ground g WHERE g.chain = c.id)" },
        { "ground links have no input",
          "SELECT count(*) FROM ground g WHERE NOT EXISTS "
          "(SELECT 1 FROM mechanism m WHERE m.chain = g.chain AND m.ground = g.link)" },
        { "chains stand at the wrong structure",
          "SELECT count(*) FROM chain c JOIN structure s ON s.id = c.structure "
          "WHERE s.loops != c.loops OR s.circles != c.links - c.binary OR s.planar != c.planar" },
        { "segments of curves lack blocks or have too many",
          "SELECT count(*) FROM curve_segment s WHERE n != "
          "(SELECT coalesce(sum(length(terms)), 0)/64 FROM curve_block b "
          "WHERE b.id >= s.first_block AND b.id < s.first_block + length(s.boxes)/68) "
          "OR n != (SELECT coalesce(sum(length(linkages)), 0)/36 FROM curve_block b "
          "WHERE b.id >= s.first_block AND b.id < s.first_block + length(s.boxes)/68)" },
        { "sequences of curves lack segments",
          "SELECT count(*) FROM sweep w WHERE segments != "
          "(SELECT count(DISTINCT number) FROM curve_segment s WHERE s.sweep = w.id)" },
    };
    for (size_t i = 0; i < sizeof sums/sizeof *sums; i++) {
        long long n;
        lw_status s = lw_store_number(c->store, sums[i].sql, NULL, 0, &n, &c->e);
        if (s != LW_OK)
            return s;
        if (n > 0)
            return lw_error_at(&c->e, LW_E_NOTATION, c->call->parsed.word[1], 0, 0, "%lld %s", n, sums[i].what);
    }
    return LW_OK;
}

/* ---- the action ------------------------------------------------------------------------------------- */

static int run_check(check *c)
{
    const cli_call *call = c->call;
    long long n_open = 0;
    lw_status s = lw_store_verify(c->store, &c->e);
    if (s == LW_OK)
        s = check_chains(c);
    if (s == LW_OK)
        s = check_sums(c);
    if (s == LW_OK)
        s = lw_store_number(c->store, "SELECT count(*) FROM build WHERE NOT complete", NULL, 0, &n_open, &c->e);
    if (s == LW_OK)
        s = cli_open(call, &c->out, &c->e);
    if (s != LW_OK)
        return cli_fail(call, &c->e);
    if (!call->common.json)
        fprintf(c->out.f, "%12s %12s  %-13s  what\n", "published", "counted", "verdict");
    s = check_published(c);
    if (s < 0) {
        lw_output_abandon(&c->out);
        return cli_fail(call, &c->e);
    }
    int code = cli_close(call, &c->out, c->n_differ > 0 ? CLI_NUMERIC : CLI_DONE);
    cli_note(call, "the file is whole; %llu chains are what their labels say; %ld published numbers agree, %ld do not; "
             "%lld build%s not finished", c->n_chain, c->n_agree, c->n_differ, n_open, n_open == 1 ? " is" : "s are");
    return code;
}

/* A catalogue, by its first bytes or else by its name; a table otherwise. */
static bool is_catalogue(const char *path)
{
    char head[16] = "";
    FILE *f = fopen(path, "rb");
    size_t n = f ? fread(head, 1, sizeof head, f) : 0;
    const char *dot = strrchr(path, '.');
    if (f)
        fclose(f);
    return (n == sizeof head && memcmp(head, "SQLite format 3", sizeof head) == 0)
        || (dot && (strcmp(dot, ".db") == 0 || strcmp(dot, ".sqlite") == 0));
}

int cli_catalogue_check_file(const cli_call *call)
{
    if (call->parsed.n_word < 2 || !is_catalogue(call->parsed.word[1]))
        return cli_catalogue_check(call);
    check c = { .call = call };
    if (cli_catalogue_open(call, false, &c.store, &c.e) != LW_OK)
        return cli_fail(call, &c.e);
    int code = run_check(&c);
    lw_store_close(c.store);
    return code;
}

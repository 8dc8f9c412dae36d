/* linkwright catalogue export - chains and mechanisms in any notation; linkages in the form that `catalogue add` reads.
 */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/store/query.h"
#include "cli/catalogue/catalogue.h"
#include "cli/program/json.h"
#include "grammar/linkage/assembly.h"
#include "grammar/topology/graph6.h"
#include "grammar/topology/notation.h"

typedef struct job {
    const cli_call     *call;
    cli_catalogue_watch watch;
    const lw_notation  *notation;
    lw_output           out;
    uint64_t            n;
    lw_error            e;
} job;

/* Columns of the rows below, in this order. */
static const char mechanism_columns[] = "graph6,ground,kinds,inputs";
static const char linkage_columns[] =
    "json,type,family,class,task,timing,target,objective,error,error_mean,error_rms,error_max,error_curve,angle_error,"
    "crank,circuits,transmission_min,transmission_max";
enum { L_JSON, L_TYPE, L_FAMILY, L_CLASS, L_TASK, L_TIMING, L_TARGET, L_FIRST_NUMBER };

/* ---- topologies ------------------------------------------------------------------------------------------ */

static lw_status damaged(job *j, const char *what)
{
    return lw_error_at(&j->e, LW_E_NOTATION, j->call->parsed.word[1], 0, 0, "the file is damaged: row %llu has %s",
                       (unsigned long long)j->n + 1, what);
}

/* Read inputs such as "1-2 3-4". */
static bool set_inputs(lw_mechanism *m, const char *text)
{
    while (text && *text) {
        char *end;
        long a = strtol(text, &end, 10), b = *end == '-' ? strtol(end + 1, &end, 10) : 0;
        bool links = a > 0 && b > 0 && a <= m->n_link && b <= m->n_link;
        int joint = links ? lw_mechanism_joint(m, (int)a - 1, (int)b - 1) : LW_NONE;
        if (joint == LW_NONE || m->n_input == LW_INPUT_MAX)
            return false;
        m->input[m->n_input++] = (uint8_t)joint;
        text = end + strspn(end, " ");
    }
    return true;
}

static lw_status write_topology(job *j, int n_column, const lw_value *v)
{
    lw_chain c;
    lw_mechanism m;
    char text[LW_NOTATION_SIZE];
    size_t length;
    if (!v[0].text || lw_graph6_read(v[0].text, v[0].size, NULL, &c, NULL) != LW_OK || lw_mechanism_from_chain(&c, &m) != LW_OK)
        return damaged(j, "a chain that is none");
    if (n_column > 1) {
        m.ground = (int)v[1].integer - 1;
        if (v[2].size != (size_t)m.n_joint || m.ground < 0 || m.ground >= m.n_link)
            return damaged(j, "joints or a ground link that are none");
        memcpy(m.kind, v[2].text, v[2].size);
        for (int i = 0; i < m.n_joint; i++)
            if (lw_joint_freedoms(m.kind[i]) != 1)
                return damaged(j, "a joint that is none");
        if (!set_inputs(&m, v[3].text))
            return damaged(j, "inputs that are none");
    }
    lw_status s = j->notation->print(&m, text, sizeof text, &length);
    if (s != LW_OK)
        return lw_error_set(&j->e, s, "%s cannot say this", j->notation->name);
    fprintf(j->out.f, "%s\n", text);
    return LW_OK;
}

/* ---- linkages -------------------------------------------------------------------------------------------- */

static void put_text(cli_json *w, const char *name, const lw_value *v)
{
    if (v->kind == LW_VALUE_TEXT)
        cli_json_text(w, name, v->text);
}

static lw_status write_linkage(job *j, int n_column, const char *const *name, const lw_value *v)
{
    cli_json w = cli_json_begin(j->out.f, 0);
    const char *json = v[L_JSON].kind == LW_VALUE_TEXT ? v[L_JSON].text : "";
    lw_assembly k = { 0 };
    lw_status s = lw_assembly_read_result(json, strlen(json), NULL, 0, &k, NULL);
    lw_assembly_free(&k);
    if (s != LW_OK)
        return s == LW_E_MEMORY ? lw_error_set(&j->e, s, "out of memory") : damaged(j, "a linkage that is none");
    cli_json_object(&w, NULL);
    for (int i = L_TYPE; i <= L_TIMING; i++)
        put_text(&w, name[i], &v[i]);
    if (v[L_TARGET].kind == LW_VALUE_TEXT) {
        cli_json_object(&w, "target");
        put_text(&w, "file", &v[L_TARGET]);
        cli_json_text(&w, "length_unit", "m");
        cli_json_end(&w);
    }
    for (int i = L_FIRST_NUMBER; i < n_column; i++) {
        bool flag = strcmp(name[i], "crank") == 0;
        const char *key = strcmp(name[i], "angle_error") == 0 ? "angle_error_mean" : name[i];
        if (v[i].kind == LW_VALUE_NULL)
            continue;
        if (strcmp(name[i], "error") == 0)
            cli_json_real(&w, "error_percent", 100*v[i].real);
        else if (flag)
            cli_json_bool(&w, key, v[i].real != 0);
        else if (strcmp(name[i], "circuits") == 0)
            cli_json_int(&w, key, (long long)v[i].real);
        else
            cli_json_real(&w, key, v[i].real);
    }
    cli_json_raw(&w, "linkage", json);
    cli_json_end(&w);
    return LW_OK;
}

/* ---- the action ------------------------------------------------------------------------------------------ */

static lw_status take_row(void *context, int n_column, const char *const *name, const lw_value *v)
{
    job *j = context;
    lw_status s = n_column > 4 ? write_linkage(j, n_column, name, v) : write_topology(j, n_column, v);
    j->n += s == LW_OK;
    return s;
}

static bool goes_on(void *context)
{
    job *j = context;
    return cli_catalogue_goes_on(&j->watch, (double)j->n);
}

static int write_all(job *j, const lw_query *q)
{
    const cli_call *call = j->call;
    lw_store *store;
    lw_store_query sql = { .sql = q->sql.data, .value = q->value, .n_value = q->n_value, .row = take_row,
                           .goes_on = goes_on, .context = j };
    if (cli_open(call, &j->out, &j->e) != LW_OK)
        return cli_fail(call, &j->e);
    lw_status s = cli_catalogue_open(call, false, &store, &j->e);
    if (s == LW_OK)
        s = lw_store_ask(store, &sql, &j->e);
    lw_store_close(store);
    if (s < 0) {
        lw_output_abandon(&j->out);
        return cli_fail(call, &j->e);
    }
    return cli_close(call, &j->out, j->n == 0 && s != LW_STOPPED ? CLI_NOTHING : CLI_DONE);
}

/* The columns depend on the list, which is known only once the query is read. */
static lw_status compile(const cli_call *call, lw_query *q, lw_error *e)
{
    const cli_catalogue_settings *s = call->settings;
    const char *text = call->parsed.n_word > 2 ? call->parsed.word[2] : "";
    lw_query_options o = { .sort = s->sort, .limit = s->results };
    lw_status status = cli_catalogue_list(call, text, LW_LIST_LINKAGES, &o, e);
    if (status == LW_OK)
        status = lw_query_compile(text, &o, q, e);
    if (status != LW_OK)
        return status;
    o.list = q->list;
    if (o.list == LW_LIST_STRUCTURES)
        return lw_error_set(e, LW_E_ARG, "structures are listed by query; chains, mechanisms and linkages are exported");
    o.columns = o.list == LW_LIST_CHAINS ? "graph6" : linkage_columns;
    if (o.list == LW_LIST_MECHANISMS)
        o.columns = mechanism_columns;
    lw_query_free(q);
    return lw_query_compile(text, &o, q, e);
}

/* The choices of --format. */
static const char *const formats[] = { "table", "json", "csv", "graph6", "lam", "sentence", "franke", "edges",
                                      "dot", "graphml" };

int cli_catalogue_export(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    lw_query *q = calloc(1, sizeof *q);
    job j = { .call = call, .watch = cli_catalogue_watch_begin(call, "export", "rows") };
    if (!q)
        return cli_fail(call, &j.e);
    lw_status status = compile(call, q, &j.e);
    bool chosen = cli_given(&call->parsed, "format");
    const char *name = chosen ? formats[s->format] : q->list == LW_LIST_MECHANISMS ? "json" : "graph6";
    j.notation = lw_notation_find(call->common.json ? "json" : name);
    int code = status != LW_OK ? cli_fail(call, &j.e)
             : !j.notation ? cli_usage(call, "export writes a notation, not --format %s; query prints tables", name)
             : write_all(&j, q);
    lw_query_free(q);
    free(q);
    return cli_catalogue_watch_end(&j.watch, code);
}

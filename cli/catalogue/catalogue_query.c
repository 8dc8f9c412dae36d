/* linkwright catalogue query - rows of a catalogue as a table, as JSON or CSV. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/real.h"
#include "catalogues/store/query.h"
#include "cli/catalogue/catalogue.h"
#include "cli/program/json.h"

#define WIDTH_ROWS 400                     /* the first rows, from which the widths of columns are chosen */
#define WIDTH_MAX  60

enum { TABLE, JSON, CSV };

typedef struct job {
    const cli_call     *call;
    cli_catalogue_watch watch;
    int                 format;
    bool                sql;               /* the question is SQL, whose columns are not fields       */
    lw_output           out;
    uint64_t            n;
    int                 n_column, width[128];
    char              **cell;              /* cells of the first rows, until the widths are known; row 0: names */
    size_t              n_cell, capacity;
    bool                right[128];        /* a column of numbers                                     */
    lw_error            e;
} job;

/* ---- a table ------------------------------------------------------------------------------------------- */

/* Replace control characters, which a terminal would obey, by '?'. */
static void clean(char *text)
{
    for (unsigned char *c = (unsigned char *)text; *c; c++)
        if (*c == '\n' || *c == '\t')
            *c = ' ';
        else if (*c < 32 || *c == 127)
            *c = '?';
}

static char *cell_text(const lw_value *v)
{
    char text[64] = "-";
    if (v->kind == LW_VALUE_TEXT) {
        char *copy = malloc(v->size + 1);
        if (copy) {
            memcpy(copy, v->text, v->size);
            copy[v->size] = 0;
            clean(copy);
        }
        return copy;
    }
    if (v->kind == LW_VALUE_INTEGER)
        snprintf(text, sizeof text, "%lld", v->integer);
    else if (v->kind == LW_VALUE_REAL)
        snprintf(text, sizeof text, "%.6g", v->real);
    else if (v->kind == LW_VALUE_BLOB)
        snprintf(text, sizeof text, "(%zu bytes)", v->size);
    return strdup(text);
}

static void print_cells(job *j, char **cell)
{
    for (int i = 0; i < j->n_column; i++)
        if (i + 1 == j->n_column && !j->right[i])
            fprintf(j->out.f, "%s", cell[i]);
        else
            fprintf(j->out.f, j->right[i] ? "%*s%s" : "%-*s%s", j->width[i], cell[i], i + 1 < j->n_column ? "  " : "");
    fputc('\n', j->out.f);
}

static void print_kept(job *j)
{
    size_t n = (size_t)j->n_column;
    for (size_t i = 0; i < j->n_cell; i++) {
        int w = (int)strlen(j->cell[i]);
        w = w > WIDTH_MAX ? WIDTH_MAX : w;
        j->width[i%n] = w > j->width[i%n] ? w : j->width[i%n];
    }
    for (size_t i = 0; i < j->n_cell; i += n)
        print_cells(j, j->cell + i);
    for (size_t i = 0; i < j->n_cell; i++)
        free(j->cell[i]);
    j->n_cell = 0;
}

static lw_status keep_cells(job *j, char **cell)
{
    size_t n = (size_t)j->n_column;
    if (j->n_cell + n > j->capacity) {
        char **more = realloc(j->cell, (2*j->capacity + n)*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        j->cell = more;
        j->capacity = 2*j->capacity + n;
    }
    memcpy(j->cell + j->n_cell, cell, n*sizeof *cell);
    j->n_cell += n;
    return LW_OK;
}

static lw_status table_row(job *j, const lw_value *v)
{
    char *cell[128];
    bool good = true, keep = j->n <= WIDTH_ROWS;
    for (int i = 0; i < j->n_column; i++) {
        cell[i] = cell_text(&v[i]);
        good = good && cell[i];
        if (keep && (v[i].kind == LW_VALUE_INTEGER || v[i].kind == LW_VALUE_REAL))
            j->right[i] = true;
    }
    if (good && keep && keep_cells(j, cell) == LW_OK)
        return LW_OK;
    if (good && !keep && j->n_cell > 0)
        print_kept(j);
    if (good && !keep)
        print_cells(j, cell);
    for (int i = 0; i < j->n_column; i++)
        free(cell[i]);
    return good && !keep ? LW_OK : LW_E_MEMORY;
}

/* ---- JSON, CSV ------------------------------------------------------------------------------------------- */

static lw_status json_row(job *j, const char *const *name, const lw_value *v)
{
    cli_json w = cli_json_begin(j->out.f, 0);
    cli_json_object(&w, NULL);
    for (int i = 0; i < j->n_column; i++) {
        if (v[i].kind == LW_VALUE_INTEGER)
            cli_json_int(&w, name[i], v[i].integer);
        else if (v[i].kind == LW_VALUE_REAL)
            cli_json_real(&w, name[i], v[i].real);
        else if (v[i].kind == LW_VALUE_BLOB)
            cli_json_int(&w, name[i], (long long)v[i].size);
        else
            cli_json_text(&w, name[i], v[i].kind == LW_VALUE_TEXT ? v[i].text : NULL);
    }
    cli_json_end(&w);
    return LW_OK;
}

static lw_status csv_row(job *j, const lw_value *v)
{
    for (int i = 0; i < j->n_column; i++) {
        char number[LW_NUMBER_SIZE];
        if (i > 0)
            fputc(',', j->out.f);
        if (v[i].kind == LW_VALUE_TEXT)
            cli_csv_field(j->out.f, v[i].text, v[i].size);
        else if (v[i].kind == LW_VALUE_INTEGER)
            fprintf(j->out.f, "%lld", v[i].integer);
        else if (v[i].kind == LW_VALUE_REAL) {
            lw_number_print(v[i].real, number);
            fputs(number, j->out.f);
        } else if (v[i].kind == LW_VALUE_BLOB)
            fprintf(j->out.f, "%zu", v[i].size);
    }
    fputs("\r\n", j->out.f);
    return LW_OK;
}

/* The name of a column with the unit of its values, which are in SI. */
static void name_with_unit(const char *name, char *text, size_t size)
{
    const lw_query_field *f = lw_fields;
    while (f->name && strcmp(f->name, name) != 0)
        f++;
    const char *unit = !f->name ? "" : f->kind == LW_FIELD_LENGTH ? " [m]" : f->kind == LW_FIELD_ANGLE ? " [rad]"
                     : strcmp(name, "error") == 0 ? " [of path]" : "";
    snprintf(text, size, "%s%s", name, unit);
}

static lw_status take_head(void *context, int n_column, const char *const *name)
{
    job *j = context;
    lw_value v[128];
    char title[128][64];
    j->n_column = n_column;
    for (int i = 0; i < n_column; i++) {
        const char *text = name[i];
        if (j->format == TABLE && !j->sql)
            name_with_unit(name[i], title[i], sizeof title[i]), text = title[i];
        v[i] = (lw_value){ .kind = LW_VALUE_TEXT, .text = text, .size = strlen(text) };
    }
    return j->format == TABLE ? table_row(j, v) : j->format == CSV ? csv_row(j, v) : LW_OK;
}

static lw_status take_row(void *context, int n_column, const char *const *name, const lw_value *v)
{
    job *j = context;
    (void)n_column;
    j->n++;
    if (j->format == JSON)
        return json_row(j, name, v);
    return j->format == CSV ? csv_row(j, v) : table_row(j, v);
}

static bool goes_on(void *context)
{
    job *j = context;
    return cli_catalogue_goes_on(&j->watch, (double)j->n);
}

/* ---- the action ------------------------------------------------------------------------------------------ */

static int print_fields(const cli_call *call)
{
    lw_output out;
    lw_error e = { 0 };
    if (cli_open(call, &out, &e) != LW_OK)
        return cli_fail(call, &e);
    for (const lw_query_field *f = lw_fields; f->name; f++) {
        fprintf(out.f, "%-17s %s [", f->name, f->about);
        for (int l = 0, n = 0; l < LW_LIST_ANY; l++)
            if (f->sql[l])
                fprintf(out.f, "%s%s", n++ ? ", " : "", lw_list_names[l]);
        fputs("]\n", out.f);
    }
    return cli_close(call, &out, CLI_DONE);
}

static lw_status ask(job *j, lw_store_query *sql, lw_error *e)
{
    lw_store *store;
    sql->row = take_row;
    sql->head = take_head;
    sql->goes_on = goes_on;
    sql->context = j;
    lw_status s = cli_catalogue_open(j->call, false, &store, e);
    if (s == LW_OK)
        s = lw_store_ask(store, sql, e);
    lw_store_close(store);
    return s;
}

static int run_query(job *j)
{
    const cli_call *call = j->call;
    const cli_catalogue_settings *s = call->settings;
    const char *text = call->parsed.n_word > 2 ? call->parsed.word[2] : "";
    lw_query_options o = { .columns = s->columns, .sort = s->sort, .limit = s->results };
    lw_query *q = calloc(1, sizeof *q);
    lw_status status = q ? LW_OK : lw_error_set(&j->e, LW_E_MEMORY, "out of memory");
    lw_store_query sql = { .sql = text, .foreign = true };
    if (status == LW_OK && !s->sql)
        status = cli_catalogue_list(call, text, LW_LIST_STRUCTURES, &o, &j->e);
    if (status == LW_OK && !s->sql) {
        status = lw_query_compile(text, &o, q, &j->e);
        sql = (lw_store_query){ .sql = q->sql.data, .value = q->value, .n_value = q->n_value };
    }
    if (status == LW_OK)
        status = cli_open(call, &j->out, &j->e);
    if (status != LW_OK) {
        if (q)
            lw_query_free(q);
        free(q);
        return cli_fail(call, &j->e);
    }
    status = ask(j, &sql, &j->e);
    if (j->format == TABLE)
        print_kept(j);
    lw_query_free(q);
    free(q);
    if (status < 0) {
        lw_output_abandon(&j->out);
        return cli_fail(call, &j->e);
    }
    return cli_close(call, &j->out, j->n == 0 && status != LW_STOPPED ? CLI_NOTHING : CLI_DONE);
}

int cli_catalogue_query(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    job j = { .call = call, .watch = cli_catalogue_watch_begin(call, "query", "rows") };
    if (s->fields)
        return print_fields(call);
    j.format = call->common.json || s->format == JSON ? JSON : s->format == CSV ? CSV : TABLE;
    j.sql = s->sql;
    if (s->format > CSV)
        return cli_usage(call, "query prints table, json or csv; export writes notations");
    if (s->sql && call->parsed.n_word < 3)
        return cli_usage(call, "--sql wants a SELECT: linkwright catalogue query FILE 'SELECT ...' --sql");
    int code = cli_catalogue_watch_end(&j.watch, run_query(&j));
    free(j.cell);
    return code;
}

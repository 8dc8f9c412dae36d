/* linkwright gallery - known mechanisms as files to trace, draw and change. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "base/suggest.h"
#include "cli/program/data.h"
#include "cli/program/output.h"
#include "grammar/text/json_internal.h"

static void gallery_path(const char *name, char *path, size_t size)
{
    cli_document_folder(path, size - 256);
    size_t n = strlen(path);
    snprintf(path + n, size - n, "/examples/gallery/%s", name);
}

static const char *text_of(const json_t *row, const char *key)
{
    const char *text = json_string_value(json_object_get(row, key));
    return text ? text : "";
}

static lw_status write_list(FILE *f, const json_t *list, bool as_json, lw_error *e)
{
    size_t i;
    const json_t *row;
    json_array_foreach(list, i, row)
        if (as_json) {
            if (json_dumpf(row, f, JSON_COMPACT) != 0 && !ferror(f))
                return lw_error_set(e, LW_E_MEMORY, "out of memory");
            fputc('\n', f);
        } else
            fprintf(f, "%-20s %-34s %-24s %s\n", text_of(row, "name"), text_of(row, "title"), text_of(row, "year"), text_of(row, "use"));
    return LW_OK;
}

/* The file of one mechanism, as it stands. */
static lw_status write_mechanism(FILE *f, const json_t *list, const char *name, lw_error *e)
{
    const char *known[64];
    int n = 0;
    size_t i, size;
    const json_t *row, *found = NULL;
    json_array_foreach(list, i, row) {
        if (n < 64)
            known[n++] = text_of(row, "name");
        if (!strcmp(text_of(row, "name"), name))
            found = row;
    }
    if (!found) {
        const char *near = lw_suggest(name, known, n);
        return lw_error_set(e, LW_E_ARG, "the gallery has no mechanism \"%.60s\"%s%s; linkwright gallery lists them",
                            name,
                            near ? ", did you mean " : "", near ? near : "");
    }
    char file[128], path[CLI_PATH_SIZE + 256], *text;
    snprintf(file, sizeof file, "%.100s.json", text_of(found, "name"));
    gallery_path(file, path, sizeof path);
    lw_status s = lw_file_read(path, &text, &size, e);
    if (s == LW_OK) {
        fwrite(text, 1, size, f);
        free(text);
    }
    return s;
}

static int run(const cli_call *call)
{
    char path[CLI_PATH_SIZE + 256], *text = NULL;
    size_t size;
    lw_error e = { 0 };
    lw_output out;
    json_error_t fault;
    gallery_path("index.json", path, sizeof path);
    lw_status s = lw_file_read(path, &text, &size, &e);
    json_t *list = NULL;
    if (s == LW_OK)
        s = lw_json_load(text, size, 0, &list, &fault);
    free(text);
    if (s == LW_E_MEMORY)
        s = lw_error_set(&e, s, "out of memory");
    else if (s == LW_E_NOTATION)
        s = lw_error_at(&e, LW_E_NOTATION, path, fault.line, fault.column, "%s", fault.text);
    if (s == LW_OK)
        s = cli_open(call, &out, &e);
    if (s == LW_OK) {
        s = call->parsed.n_word == 0 ? write_list(out.f, list, call->common.json, &e)
                                     : write_mechanism(out.f, list, call->parsed.word[0], &e);
        if (s != LW_OK)
            lw_output_abandon(&out);
    }
    json_decref(list);
    if (s != LW_OK)
        return s == LW_E_ARG ? cli_usage(call, "%s", e.text) : cli_fail(call, &e);
    return cli_close(call, &out, CLI_DONE);
}

static const cli_option options[] = { { .name = NULL } };

const cli_command cli_gallery_command = {
    .name = "gallery",
    .words = "[NAME]",
    .title = "known mechanisms: straight lines, legs, machines of every day",
    .examples =
        "  linkwright gallery                                 name, title, year and use of each\n"
        "  linkwright gallery klann -o klann.json             the file of one, to change it\n"
        "  linkwright gallery peaucellier | linkwright draw - -o line.svg\n",
    .about =
        "Without NAME prints the list of mechanisms; with --json one object a line, with the source of each. With NAME prints\n"
        "the linkage as JSON (docs/notation.md), which trace, draw, simulate and convert read. Pictures: docs/gallery.md.\n",
    .options = options,
    .settings_size = 1,
    .most_words = 1,
    .run = run,
    .writes = "text",
};

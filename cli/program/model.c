/* Read linkages that are stored inside other JSON files (bridge to jansson). */
#include "cli/program/model.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/program/output.h"
#include "grammar/model.h"

/* The linkage of a result as separate text; NULL with e filled. Free with free(). */
static char *result_text(const json_t *results, const char *file, int which, lw_error *e)
{
    size_t n = json_array_size(results), at = which > 0 ? (size_t)which - 1 : 0;
    if (at >= n) {
        lw_error_at(e, LW_E_ARG, file, 0, 0, "result %zu is wanted, but there %s %zu", at + 1,
                    n == 1 ? "is" : "are", n);
        return NULL;
    }
    const json_t *linkage = json_object_get(json_array_get(results, at), "linkage");
    if (!json_is_object(linkage)) {
        lw_error_at(e, LW_E_NOTATION, file, 0, 0, "result %zu has no linkage", at + 1);
        return NULL;
    }
    char *text = json_dumps(linkage, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    if (!text)
        lw_error_at(e, LW_E_MEMORY, file, 0, 0, "out of memory");
    return text;
}

bool cli_is_target(const char *text, size_t size)
{
    lw_target t;
    if (lw_target_read(text, size, "", NULL, &t, NULL) != LW_OK)
        return false;
    lw_target_free(&t);
    return true;
}

/* If *text holds results, replace it by the text of the requested result. */
static lw_status unwrap(const char *file, int which, char **text, size_t *size, lw_error *e)
{
    json_t *root = json_loadb(*text, *size, 0, NULL);
    const json_t *results = json_object_get(root, "results");
    lw_status s = LW_OK;
    if (json_object_get(root, "linkwright-task") || (!root && cli_is_target(*text, *size))) {
        s = lw_error_at(e, LW_E_NOTATION, file, 0, 0, "this is a %s, not a linkage: did you mean 'linkwright fit %s'?",
                        root ? "task" : "target", file);
    } else if (json_is_array(results)) {
        char *inner = result_text(results, file, which, e);
        if (inner) {
            free(*text);
            *text = inner;
            *size = strlen(inner);
        } else {
            s = LW_E_ARG;
        }
    } else if (root && which > 0) {
        s = lw_error_at(e, LW_E_ARG, file, 0, 0, "the file holds one linkage and no list of results; "
                        "leave --result out");
    }
    json_decref(root);
    return s;
}

lw_status cli_read_linkage(const char *path, int which, lw_linkage *k, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = cli_read_file(path, "a linkage (JSON)", &text, &size, e);
    if (s == LW_OK)
        s = cli_linkage_text(path, which, &text, &size, k, e);
    free(text);
    return s;
}

lw_model *cli_read_model(const char *path, int which, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_model *m = calloc(1, sizeof *m);
    lw_status s = m ? cli_read_file(path, "a linkage (JSON)", &text, &size, e) : lw_error_set(e, LW_E_MEMORY,
                                                                                              "out of memory");
    if (s == LW_OK)
        s = unwrap(path, which, &text, &size, e);
    if (s == LW_OK)
        s = lw_model_read(text, size, path, m, e);
    free(text);
    if (s == LW_OK)
        return m;
    free(m);
    return NULL;
}

void cli_free_model(lw_model *m)
{
    if (m)
        lw_model_free(m);
    free(m);
}

lw_status cli_linkage_text(const char *path, int which, char **text, size_t *size, lw_linkage *k, lw_error *e)
{
    lw_status s = unwrap(path, which, text, size, e);
    return s == LW_OK ? lw_linkage_read(*text, *size, path, k, e) : s;
}

/* Status of a read that may have waited for input: Ctrl-C ends it. */
static lw_status waited(const char *path, lw_status s, lw_error *e)
{
    bool stopped = strcmp(path, "-") == 0 && cli_interrupted();
    return stopped ? lw_error_at(e, LW_STOPPED, path, 0, 0, "interrupted while it was read") : s;
}

lw_status cli_read_target(const char *path, const lw_target_options *o, lw_target *t, lw_error *e)
{
    if (strcmp(path, "-") == 0)
        cli_say_waiting("a target (CSV)");
    return waited(path, lw_target_read_file(path, o, t, e), e);
}

lw_status cli_read_task_file(const char *path, const lw_target_options *o, lw_task_file *b, lw_target *t, lw_error *e)
{
    if (strcmp(path, "-") == 0)
        cli_say_waiting("a task (JSON)");
    lw_status s = waited(path, lw_task_file_read_file(path, o, b, t, e), e);
    char *text = NULL;
    size_t size;
    if (s == LW_E_NOTATION && strcmp(path, "-") != 0 && lw_file_read(path, &text, &size, NULL) == LW_OK) {
        json_t *root = json_loadb(text, size, 0, NULL);
        bool results = json_is_array(json_object_get(root, "results"));
        if (results || json_object_get(root, "linkwright"))
            s = lw_error_at(e, s, path, 0, 0, "this is a %s, not a target or a task: did you mean 'linkwright trace "
                            "%s', or 'linkwright fit TARGET.csv --start-from %s'?",
                            results ? "list of results" : "linkage", path, path);
        json_decref(root);
    }
    free(text);
    return s;
}

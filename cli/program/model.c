/* Read files of the user; a file of another kind is named (bridge to jansson). */
#include "cli/program/model.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "cli/program/output.h"
#include "grammar/model.h"

bool cli_is_target(const char *text, size_t size)
{
    lw_target t;
    if (lw_target_read(text, size, "", NULL, &t, NULL) != LW_OK)
        return false;
    lw_target_free(&t);
    return true;
}

/* After a failed read of a linkage: does the text hold something else, for which there is a command? */
static lw_status hint(const char *file, const char *text, size_t size, lw_status s, lw_error *e)
{
    if (s != LW_E_NOTATION)
        return s;
    json_t *root = json_loadb(text, size, 0, NULL);
    if (json_object_get(root, "linkwright-task") || (!root && cli_is_target(text, size)))
        s = lw_error_at(e, LW_E_NOTATION, file, 0, 0, "this is a %s, not a linkage: did you mean 'linkwright fit %s'?",
                        root ? "task" : "target", file);
    json_decref(root);
    return s;
}

lw_status cli_linkage_text(const char *path, int which, const char *text, size_t size, lw_linkage *k, lw_error *e)
{
    return hint(path, text, size, lw_linkage_read_result(text, size, path, which, k, e), e);
}

lw_status cli_read_linkage(const char *path, int which, lw_linkage *k, lw_error *e)
{
    char *text = NULL;
    size_t size = 0;
    lw_status s = cli_read_file(path, "a linkage (JSON)", &text, &size, e);
    if (s == LW_OK)
        s = cli_linkage_text(path, which, text, size, k, e);
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
        s = hint(path, text, size, lw_model_read_result(text, size, path, which, m, e), e);
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

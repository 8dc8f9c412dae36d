/* tests/planar_models.h - planar models and linkages from text and from files; one that cannot be read ends the test. */
#ifndef LW_TESTS_PLANAR_MODELS_H
#define LW_TESTS_PLANAR_MODELS_H

#include "base/file.h"
#include "grammar/model/model.h"
#include "tests/json_text.h"

static inline void need_planar(lw_status s, const char *file, const lw_error *e)
{
    if (s != LW_OK) {
        fprintf(stderr, "%s:%ld:%ld: %s\n", file, e->line, e->column, e->text);
        exit(1);
    }
}

/* Read a text with ' for ". */
static inline void read_planar(const char *quoted, const char *name, lw_model *m)
{
    lw_error e = { 0 };
    char *json = json_quotes(strdup(quoted));
    need_planar(lw_model_read(json, strlen(json), name, m, &e), name, &e);
    free(json);
}

static inline char *need_json(const char *path, size_t *size)
{
    char *json = NULL;
    lw_error e = { 0 };
    need_planar(lw_file_read(path, &json, size, &e), path, &e);
    return json;
}

static inline void load_planar(const char *path, lw_model *m)
{
    size_t size;
    char *json = need_json(path, &size);
    lw_error e = { 0 };
    need_planar(lw_model_read(json, size, path, m, &e), path, &e);
    free(json);
}

static inline void load_linkage(const char *path, lw_linkage *k)
{
    size_t size;
    char *json = need_json(path, &size);
    lw_error e = { 0 };
    need_planar(lw_linkage_read(json, size, path, k, &e), path, &e);
    free(json);
}

#endif

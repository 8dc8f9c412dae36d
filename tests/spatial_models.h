/* tests/spatial_models.h - spatial models of examples/space for tests. */
#ifndef LW_TESTS_SPATIAL_MODELS_H
#define LW_TESTS_SPATIAL_MODELS_H

#include "base/file.h"
#include "grammar/model/spatial.h"
#include "tests/json_text.h"

/* Read JSON. */
static inline void read_spatial_json(const char *text, size_t size, const char *file, lw_spatial *m)
{
    lw_error e = { 0 };
    CHECK(lw_spatial_text(text, size));
    if (lw_spatial_read(text, size, file, m, &e) != LW_OK) {
        fprintf(stderr, "%s:%ld:%ld: %s\n", file, e.line, e.column, e.text);
        exit(1);
    }
}

/* Read a text with ' for ". */
static inline void read_spatial(const char *text, const char *name, lw_spatial *m)
{
    char *json = json_quotes(strdup(text));
    read_spatial_json(json, strlen(json), name, m);
    free(json);
}

static inline void load_spatial_file(const char *path, lw_spatial *m)
{
    char *text;
    size_t size;
    lw_error e = { 0 };
    if (lw_file_read(path, &text, &size, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        exit(1);
    }
    read_spatial_json(text, size, path, m);
    free(text);
}

static inline void load_spatial(const char *name, lw_spatial *m)
{
    char path[128];
    snprintf(path, sizeof path, "examples/space/%s.json", name);
    load_spatial_file(path, m);
}

#endif

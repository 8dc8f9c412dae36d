/* tests/spatial_models.h - spatial models of examples/space for tests. */
#ifndef LW_TESTS_SPATIAL_MODELS_H
#define LW_TESTS_SPATIAL_MODELS_H

#include "base/file.h"
#include "grammar/model/spatial.h"
#include "tests/check.h"

static inline void read_spatial(const char *text, size_t size, const char *file, lw_spatial *m)
{
    lw_error e = { 0 };
    CHECK(lw_spatial_text(text, size));
    if (lw_spatial_read(text, size, file, m, &e) != LW_OK) {
        fprintf(stderr, "%s:%ld:%ld: %s\n", file, e.line, e.column, e.text);
        exit(1);
    }
}

static inline void load_spatial(const char *file, lw_spatial *m)
{
    char path[128], *text;
    size_t size;
    lw_error e = { 0 };
    snprintf(path, sizeof path, "examples/space/%s.json", file);
    if (lw_file_read(path, &text, &size, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        exit(1);
    }
    read_spatial(text, size, path, m);
    free(text);
}

#endif

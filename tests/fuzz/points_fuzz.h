/* tests/fuzz/points_fuzz.h - a linkage that can be read from a list of points can be written, unless its input is a
 * pin of several moving links, and is the same linkage when it is read again. */
#ifndef LW_TESTS_POINTS_FUZZ_H
#define LW_TESTS_POINTS_FUZZ_H

#include <math.h>
#include "grammar/linkage/assembly.h"
#include "tests/fuzz/fuzz.h"

/* Points at the same place may become one point, which changes the order of the joints, but not the linkage. */
static inline int points_same(const lw_assembly *a, const lw_assembly *b)
{
    int n[256] = { 0 }, same = a->n_link == b->n_link && a->n_joint == b->n_joint && a->n_tracer == b->n_tracer
                            && a->n_input == b->n_input;
    double x = 0, y = 0, size = 0;
    for (int j = 0; same && j < a->n_joint; j++) {
        n[a->joint[j].kind]++;
        n[b->joint[j].kind]--;
        x += a->joint[j].at.x - b->joint[j].at.x;
        y += a->joint[j].at.y - b->joint[j].at.y;
        size += fabs(a->joint[j].at.x) + fabs(a->joint[j].at.y);
    }
    for (int i = 0; i < 256; i++)
        same = same && n[i] == 0;
    return same && fabs(x) + fabs(y) <= 1e-13*size;
}

static inline int points_fuzz(const uint8_t *data, size_t size,
                              lw_status (*read)(const char *text, size_t size, const char *file,
                                                const lw_units *units, lw_assembly *k, lw_error *e),
                              char *(*write)(const lw_assembly *k, lw_error *e))
{
    lw_assembly k[3] = { { .n_link = 0 } };
    lw_error e = { 0 };
    lw_units u = lw_units_si();
    if (read((const char *)data, size, "fuzz", &u, &k[0], &e) != LW_OK) {
        if (e.line < 1 || e.column < 1 || !e.text[0])
            abort();
        return 0;
    }
    for (int i = 0; i < 2; i++) {
        char *text = write(&k[i], &e);
        if (!text) {
            if (e.status != LW_E_KIND || k[i].n_input == 0)
                abort();
            break;
        }
        if (read(text, strlen(text), "fuzz", &u, &k[i + 1], &e) != LW_OK)
            abort();
        if (!points_same(&k[i], &k[i + 1]))
            abort();
        free(text);
    }
    for (int i = 0; i < 3; i++)
        lw_assembly_free(&k[i]);
    return 0;
}

#endif

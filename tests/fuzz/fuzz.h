/* tests/fuzz/fuzz.h - for fuzz targets: their entry, and the target of a format that is read and printed. */
#ifndef LW_TESTS_FUZZ_H
#define LW_TESTS_FUZZ_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/error.h"
#include "tests/program.h"

/* The target, in each file: calls abort() on a fault of the library; returns 0. */
static int one_input(const uint8_t *data, size_t size);

/* The entry of libFuzzer, which links one target. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
__attribute__((weak)) int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) { return one_input(data, size); }

/* In `make test`: each file of the corpus once (tests/fuzz/replay.c). */
int replay(int argc, char **argv, int (*target)(const uint8_t *data, size_t size));
static int replay_here(int argc, char **argv) { return replay(argc, argv, one_input); }
TEST_PROGRAM(replay_here)

static inline void demand(int condition)
{
    if (!condition)
        abort();
}

/* Has a reader refused the text?  Then it says why and where. */
static inline int refused(lw_status s, const lw_error *e)
{
    if (s == LW_OK)
        return 0;
    demand(e->status == s && e->text[0] && memchr(e->text, '\0', sizeof e->text) != NULL);
    demand(s != LW_E_NOTATION || (e->line > 0 && e->column > 0));
    return 1;
}

/* Text that can be read as `type` is printed in less than `most` bytes and reads back the same: `same` is a condition
 * on the two values a and b. */
#define FUZZ_READS_BACK(type, read, print, most, same) \
    static int one_input(const uint8_t *data, size_t size) \
    { \
        type a, b; \
        lw_error e; \
        char text[most]; \
        if (read((const char *)data, size, "fuzz", &a, &e) != LW_OK) \
            return 0; \
        size_t n = print(&a, text, sizeof text); \
        if (n >= sizeof text || read(text, n, "fuzz", &b, &e) != LW_OK || !(same)) \
            abort(); \
        return 0; \
    }

#endif

/* Any bytes are a file of structures, and each structure in it is valid, or there is an error. */
#include <stdio.h>
#include "enumerate/structures.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_structures *set;
    lw_error e = { 0 };
    FILE *f = size ? fmemopen((void *)(uintptr_t)data, size, "rb") : NULL;
    if (!f)
        return 0;
    if (lw_structures_read(f, "fuzz", &set, &e) == LW_OK) {
        int loops = lw_structures_loops(set);
        for (size_t k = 0; k < lw_structures_count(set, loops); k++) {
            lw_structure s;
            lw_structures_get(set, loops, k, &s);
            if (lw_structure_loops(&s) != loops)
                abort();
        }
        lw_structures_free(set);
    } else if (!e.text[0]) {
        abort();
    }
    fclose(f);
    return 0;
}

/* tests/fake_processor.c - the test build of the program on a lesser processor.
 *
 *     LW_LESSER=n        without the n best instruction sets for which kernels exist, as far as one is left
 *
 * The linker sends the calls of lw_kernels_supported here (--wrap in the Makefile). */
#include <stdlib.h>
#include "mbs/batch/kernels_internal.h"

const lw_kernels *__real_lw_kernels_supported(int rank);
const lw_kernels *__wrap_lw_kernels_supported(int rank);

const lw_kernels *__wrap_lw_kernels_supported(int rank)
{
    const char *text = getenv("LW_LESSER");
    int lesser = text ? atoi(text) : 0;
    while (lesser > 0 && !__real_lw_kernels_supported(lesser))
        lesser--;
    return rank < 0 ? NULL : __real_lw_kernels_supported(rank + lesser);
}

/* Which instruction sets does this processor have? A file of its own: the test build replaces it. */
#include "mbs/batch/kernels_internal.h"

#ifdef __x86_64__
extern const lw_kernels lw_kernels_x86_64, lw_kernels_x86_64_v3, lw_kernels_x86_64_v4;

/* The features of levels 4 and 3 of the x86-64 psABI that compilers use in these loops. */
static bool runs_v4(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
}
static bool runs_v3(void)
{
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2");
}

const lw_kernels *lw_kernels_supported(int rank)
{
    const lw_kernels *list[4] = { 0 };
    int n = 0;
    __builtin_cpu_init();
    if (runs_v4() && runs_v3())
        list[n++] = &lw_kernels_x86_64_v4;
    if (runs_v3())
        list[n++] = &lw_kernels_x86_64_v3;
    list[n++] = &lw_kernels_x86_64;
    return rank >= 0 && rank < n ? list[rank] : NULL;
}
#else
extern const lw_kernels lw_kernels_native;

const lw_kernels *lw_kernels_supported(int rank) { return rank == 0 ? &lw_kernels_native : NULL; }
#endif

#include "base/clock.h"

#include <time.h>

static double seconds(clockid_t clock)
{
    struct timespec t;
    if (clock_gettime(clock, &t) != 0)
        return 0;
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}

double lw_clock_wall(void) { return seconds(CLOCK_MONOTONIC); }
double lw_clock_cpu(void)  { return seconds(CLOCK_THREAD_CPUTIME_ID); }

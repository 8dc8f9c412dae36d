/* tests/fake_clock.c - replaces base/clock.c in the test build of the program, so that a time limit is a number of
 * readings of the clock, the same on every machine.
 *
 *     LW_CLOCK_STEP=0.01     each reading is 0.01 s later than the one before; without it the clock is the real one. The timer
 *                            of --time follows it: SIGALRM comes at a reading, and nothing is ended by force
 *     LW_SIGNAL=2 LW_SIGNAL_AT=100    the hundredth reading sends signal 2 to the program itself */
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include "base/clock.h"

static double step;
static int signal_number;
static long signal_at;
static atomic_long readings, alarm_at;
static atomic_bool stopped;                      /* by a signal: no other one comes */

__attribute__((constructor)) static void read_environment(void)
{
    const char *by = getenv("LW_CLOCK_STEP"), *number = getenv("LW_SIGNAL"), *at = getenv("LW_SIGNAL_AT");
    step = by ? strtod(by, NULL) : 0;
    signal_number = number ? atoi(number) : 0;
    signal_at = at ? atol(at) : 0;
}

static double read_clock(clockid_t clock)
{
    long n = ++readings;
    struct timespec t;
    if (signal_number > 0 && n == signal_at) {
        stopped = true;
        raise(signal_number);
    }
    long at = alarm_at;
    if (at > 0 && n >= at && atomic_compare_exchange_strong(&alarm_at, &at, 0)) {
        stopped = true;
        raise(SIGALRM);
    }
    if (step > 0)
        return (double)n*step;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}

int __real_setitimer(__itimer_which_t which, const struct itimerval *to, struct itimerval *from);
int __wrap_setitimer(__itimer_which_t which, const struct itimerval *to, struct itimerval *from);
int __wrap_setitimer(__itimer_which_t which, const struct itimerval *to, struct itimerval *from)
{
    if (!(step > 0))
        return __real_setitimer(which, to, from);
    double seconds = (double)to->it_value.tv_sec + 1e-6*(double)to->it_value.tv_usec;
    long was = alarm_at, left = was > 0 ? was - readings : 0;
    if (from)
        *from = (struct itimerval){ .it_value = { (time_t)((double)left*step), (suseconds_t)(1e6*((double)left*step
                                                  - (double)(time_t)((double)left*step))) } };
    alarm_at = seconds > 0 && !stopped ? readings + 1 + (long)(seconds/step) : 0;
    return 0;
}

double lw_clock_wall(void) { return read_clock(CLOCK_MONOTONIC); }
double lw_clock_cpu(void)  { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

/* mbs/equations/limits_internal.h - how a caller ends a run, and the limit of its time; internal to mbs/. */
#ifndef LW_MBS_EQUATIONS_LIMITS_INTERNAL_H
#define LW_MBS_EQUATIONS_LIMITS_INTERNAL_H

#include <signal.h>
#include "base/clock.h"
#include "base/error.h"

/* LW_STOPPED, with a text, when *stop is not 0 (stop may be NULL) or, where look_at_clock is true, when lw_clock_wall
 * has passed `until` (0: no limit). */
static inline lw_status lw_limits_check(const volatile sig_atomic_t *stop, double until, bool look_at_clock, double t, lw_error *e)
{
    if (stop && *stop)
        return lw_error_set(e, LW_STOPPED, "stopped at t = %.9g s", t);
    if (until > 0 && look_at_clock && lw_clock_wall() > until)
        return lw_error_set(e, LW_STOPPED, "the time allowed was used up at t = %.9g s", t);
    return LW_OK;
}

#endif

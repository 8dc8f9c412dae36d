/* base/clock.h - clocks for limits and reports. A result that must be repeatable never depends on them.
 * A program linked with the static library may define both functions itself and so set the time: tests/fake_clock.c. */
#ifndef LW_BASE_CLOCK_H
#define LW_BASE_CLOCK_H

double lw_clock_wall(void);   /* monotonic [s]                                  */
double lw_clock_cpu(void);    /* processor time of the calling thread [s]       */

#endif

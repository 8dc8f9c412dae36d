/* base/clock.h - seconds for limits and reports; never part of a result that must repeat. */
#ifndef LW_BASE_CLOCK_H
#define LW_BASE_CLOCK_H

double lw_clock_wall(void);   /* monotonic [s]                                  */
double lw_clock_cpu(void);    /* processor time of the calling thread [s]       */

#endif

/* enumerate/estimate.h - estimates the size of a listing and its time before it starts. */
#ifndef LW_ENUMERATE_ESTIMATE_H
#define LW_ENUMERATE_ESTIMATE_H

#include "base/error.h"

typedef struct lw_estimate {
    double structures, chains;            /* exact numbers of structures up to 8 loops              */
    double structure_seconds;             /* one core of this machine, now                [s]       */
    double count_seconds, list_seconds;   /* after the structures; without writing        [s]       */
    double bytes;                         /* memory for the structures                    [byte]    */
} lw_estimate;

/* Estimate for the chains with P links and F freedoms that are not fractionated.  Up to six loops it is based on a
 * sample of their own structures.  Above, chains per structure and times are extrapolated from five and six loops,
 * within a factor of two for seven and eight.  Takes some hundredths of a second, up to a second for F = 6.
 * LW_E_ARG when no chain has P links and F freedoms, LW_E_MEMORY. */
lw_status lw_chains_estimate(int n_link, int dof, lw_estimate *estimate, lw_error *e);

#endif

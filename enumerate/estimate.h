/* enumerate/estimate.h - estimates the size of a listing and its time before it starts. */
#ifndef LW_ENUMERATE_ESTIMATE_H
#define LW_ENUMERATE_ESTIMATE_H

#include <stdbool.h>
#include "base/error.h"

typedef struct lw_estimate {
    double structures, chains;            /* exact numbers of structures up to 9 loops              */
    double structure_seconds;             /* one core of this machine, now                [s]       */
    double count_seconds, list_seconds;   /* after the structures; without writing        [s]       */
    double bytes;                         /* memory for the structures                    [byte]    */
} lw_estimate;

/* Estimate for the chains with P links and F freedoms that are not fractionated.  Up to six loops it is based on a
 * sample of their own structures.  Above, chains per structure and times are extrapolated from samples of levels up to
 * six or seven loops; the numbers are within a factor of 1.5 up to nine loops.  Takes some hundredths of a second, up to
 * a second for F = 6.  LW_E_ARG when no chain has P links and F freedoms, LW_E_MEMORY. */
lw_status lw_chains_estimate(int n_link, int dof, lw_estimate *estimate, lw_error *e);

/* The same; go_on is called from time to time, and if it returns false: LW_STOPPED. */
lw_status lw_chains_estimate_while(int n_link, int dof, bool (*go_on)(void *context), void *context, lw_estimate *estimate, lw_error *e);

#endif

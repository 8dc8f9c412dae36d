/* enumerate/estimate.h - how large a listing is and how long it takes, said before it starts. */
#ifndef LW_ENUMERATE_ESTIMATE_H
#define LW_ENUMERATE_ESTIMATE_H

#include "base/error.h"

typedef struct lw_estimate {
    double structures, chains;            /* exact numbers of structures up to 8 loops              */
    double structure_seconds;             /* one core of this machine, now                [s]       */
    double count_seconds, list_seconds;   /* after the structures; without writing        [s]       */
    double bytes;                         /* memory for the structures                    [byte]    */
} lw_estimate;

/* For the chains with P links and F freedoms, not fractionated.  Up to six loops from a sample of their own
 * structures; above, chains per structure and times are carried on from five and six loops, which comes
 * within a factor of two for seven and eight.  Takes some hundredths of a second, up to a second for
 * F = 6.  LW_E_ARG when P and F do not go together, LW_E_MEMORY. */
lw_status lw_chains_estimate(int n_link, int dof, lw_estimate *estimate, lw_error *e);

#endif

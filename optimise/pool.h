/* optimise/pool.h - the best linkages found so far, no linkage twice. */
#ifndef LW_OPTIMISE_POOL_H
#define LW_OPTIMISE_POOL_H

#include "optimise/solver.h"

#define LW_POOL_MAX 64

typedef struct lw_found {
    double  f;                   /* scaled                                                         */
    double  x[LW_VAR_MAX];
    int     arm;                 /* which problem it belongs to                                    */
    lw_course branch;
    bool    polished;
    long    evals;
    double  seconds;
    lw_stop stop;
    int     hits;                /* how often it was found                                         */
} lw_found;

typedef struct lw_pool { int n; lw_found item[LW_POOL_MAX]; } lw_pool;

/* Put one in, in order of f.  When it is there already (same arm, variables equal to 1e-4 and f to
 * 1e-4 of its own) the better one stays and the hit is counted. */
void lw_pool_put(lw_pool *p, const lw_found *c, const lw_problem *problem);

#endif

/* optimise/search/pool.h - the best linkages found so far, no linkage twice. */
#ifndef LW_OPTIMISE_SEARCH_POOL_H
#define LW_OPTIMISE_SEARCH_POOL_H

#include "optimise/solvers/solver.h"

#define LW_POOL_MAX 64

typedef struct lw_found {
    double  f;                   /* scaled                                                         */
    double  x[LW_VAR_MAX];
    int     arm;                 /* which problem it belongs to                                    */
    lw_intended_motion branch;
    bool    polished;
    long    evals;
    double  seconds;
    lw_stop stop;
    int     hits;                /* how often it was found                                         */
} lw_found;

typedef struct lw_pool { int n; lw_found item[LW_POOL_MAX]; } lw_pool;

/* What tells two finds of a problem apart: its variables, and which of them are angles (bit i of angle[i/64]). */
typedef struct lw_variables { int n; uint64_t angle[(LW_VAR_MAX + 63)/64]; } lw_variables;
lw_variables lw_pool_variables(const lw_problem *p);

/* Put one in, in order of f.  When it is there already (same arm, variables equal to 1e-4 and f to
 * 1e-4 of its own) the better one stays and the hit is counted. */
void lw_pool_put(lw_pool *p, const lw_found *c, const lw_variables *of);

/* The few best of a pool in as little memory as they need. */
typedef struct lw_best_starts {
    int          n, n_mode, arm;
    lw_variables of;
    double       number[];       /* of each: f, sense, turns, mid, half; variables; modes           */
} lw_best_starts;

/* NULL: out of memory, or nothing is in the pool.  Free with free().  n_mode: numbers of a course that count. */
lw_best_starts *lw_best_starts_of(const lw_pool *p, int most, const lw_variables *of, int n_mode);

/* f of the i-th, 0 <= i < n; all of it. */
double lw_best_starts_f(const lw_best_starts *few, int i);
void   lw_best_starts_get(const lw_best_starts *few, int i, lw_found *c);

#endif

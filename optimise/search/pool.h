/* optimise/search/pool.h - the best linkages found so far, each linkage once. */
#ifndef LW_OPTIMISE_SEARCH_POOL_H
#define LW_OPTIMISE_SEARCH_POOL_H

#include "optimise/solvers/solver.h"

#define LW_POOL_MAX 64
#define LW_BEYOND   0.01         /* of the squared sine of the transmission angle                   */

typedef struct lw_found {
    double  f;                   /* scaled                                                          */
    double  x[LW_VAR_MAX];
    int     candidate;           /* of the search: which problem x belongs to                       */
    lw_intended_motion intended;
    bool    polished;
    double  gentle;              /* least transmission angle that it was fitted with beyond that of the problem [deg] */
    double  size;                /* scaled, of polished finds; else 0                               */
    int     beyond;              /* 0: it keeps all conditions; else how far it is from that, in steps of LW_BEYOND */
    long    evals;
    double  seconds;
    lw_stop stop;
    bool    guided;              /* a start of lw_start_guided that was not improved                 */
    double  cost;                /* of finds for few stations what they count as (lw_search_weigh); INFINITY: no result */
    bool    moved;               /* to where the linkage counts as less (lw_search_climb)            */
    int     hits;                /* how often it was found                                          */
} lw_found;

typedef struct lw_pool {
    int      n;                          /* at most LW_POOL_MAX; one more while a find is put in    */
    bool     by_cost;                    /* ordered by that alone                                   */
    lw_found item[LW_POOL_MAX + 1];
} lw_pool;

/* How to compare two finds of a problem: the number of variables, and which are angles (bit i%64 of angle[i/64]). */
typedef struct lw_variables { int n; uint64_t angle[(LW_VAR_MAX + 63)/64]; } lw_variables;
lw_variables lw_pool_variables(const lw_problem *p);

/* Put a find in, in order of `beyond` and f, or of cost; a full pool drops one as lw_pool_shorten does.  A find is in the pool already if
 * it has the same candidate, and its variables and f agree to 1e-4: then the better one stays and the hit is counted. */
void lw_pool_put(lw_pool *p, const lw_found *c, const lw_variables *of);

/* Drop finds until `most` >= 1 are left: the last one with a better one before it that is as small and as gentle, while there is one, else
 * the last, so that the smallest linkages are not lost to many with less error.  In order of cost: the last. */
void lw_pool_shorten(lw_pool *p, int most);

/* The best finds of a pool in as little memory as they need. */
typedef struct lw_best_starts {
    int          n, n_mode, candidate;
    lw_variables of;
    double       number[];       /* of each: f, sense, turns, mid, half; variables; modes           */
} lw_best_starts;

/* The first `most` of the pool, with the first n_mode numbers of each assembly.  NULL: out of memory, or the pool is
 * empty. Free with free(). */
lw_best_starts *lw_best_starts_of(const lw_pool *p, int most, const lw_variables *of, int n_mode);

/* f of find i, 0 <= i < n; the whole find. */
double lw_best_starts_f(const lw_best_starts *starts, int i);
void   lw_best_starts_get(const lw_best_starts *starts, int i, lw_found *c);

#endif

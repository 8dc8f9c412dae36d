/* optimise/fit_internal.h - the state of one search, and its parts: which problems there are (fit_arms.c),
 * one round of starts and improvements (fit_round.c), what the caller gets (rank.c). */
#ifndef LW_OPTIMISE_FIT_INTERNAL_H
#define LW_OPTIMISE_FIT_INTERNAL_H

#include "optimise/fit.h"
#include "optimise/pool.h"

enum {
    LW_BLOCK = 400,         /* draws of one job                                                   */
    LW_KEEP = 8,            /* finds of a job that are handed to the pool                         */
    LW_ARM_MAX = 80,        /* by types                                                           */
    LW_ARM_BEST = 4,        /* finds that an arm remembers, to look around them                   */
    LW_JOB_MAX = 4096
};

/* A family (of four links: in one assembly mode and sense): one problem, and a coarser one for the search
 * when the target has many stations. */
typedef struct lw_arm {
    lw_problem fine, coarse;
    bool       has_coarse;
    int        family;                       /* number in lw_fit_options.family                  */
    int        block, settle, improve;       /* of a job: draws, those settled, those improved   */
    int        cost;                         /* of one evaluation, in those of dyads             */
    lw_pool   *best;                         /* of its search, with families; else NULL          */
    long       starts, improved;
} lw_arm;

/* One piece of work of a round: draw from an arm, or look around what it found. */
typedef struct lw_search_job { int arm; bool around; } lw_search_job;

typedef struct lw_search {
    const lw_target      *t;
    const lw_fit_options *o;
    lw_target  thin;                         /* fewer stations                                   */
    int        n_arm, n_thread, n_job, round;
    lw_arm    *arm;
    lw_search_job job[LW_JOB_MAX];
    lw_problem *local;                       /* of each thread: the problem in one branch        */
    void     **work;                         /* of each thread                                   */
    lw_pool    pool, raw;                    /* polished; of this round's search                 */
    lw_found  *found;                        /* LW_KEEP of each job                              */
    double     started, best_raw;            /* the latter in the search's own scale             */
    long       hits;                         /* how often the best of the search was found       */
    long      *evals, *improved;             /* of each job                                      */
} lw_search;

/* Make the arms of the families that are asked for, and the thinner target of a long one. */
lw_status lw_search_arms(lw_search *s, lw_fit *out, lw_error *e);

/* The problem of a find in its branch, in the memory of one thread; work follows. */
lw_problem *lw_search_problem(lw_search *s, int thread, const lw_found *c, bool coarse);

/* The jobs of a round; none when memory fails. */
void lw_search_share(lw_search *s, int round);

/* Draw, improve, polish; the pool gets what was found. */
void lw_search_round(lw_search *s);

/* Time over, or asked to stop. */
bool lw_search_stopped(const lw_search *s);

/* The pool as candidates, best first, each curve once. */
lw_status lw_search_rank(lw_search *s, lw_fit *out);

#endif

/* optimise/search/fit_internal.h - the state of one search, and its parts: which problems there are (fit_arms.c),
 * one round of starts and improvements (fit_round.c), what the caller gets (rank.c). */
#ifndef LW_OPTIMISE_SEARCH_FIT_INTERNAL_H
#define LW_OPTIMISE_SEARCH_FIT_INTERNAL_H

#include "optimise/search/fit.h"
#include "optimise/search/pool.h"

enum {
    LW_SEARCH_BLOCK = 400,         /* draws of one job                                                   */
    LW_KEEP = 8,            /* finds of a job that are handed to the pool                         */
    LW_SEARCH_CANDIDATE_MAX = 80,        /* by types                                                           */
    LW_SEARCH_CANDIDATE_BEST = 4,        /* finds that an arm remembers, to look around them                   */
    LW_JOB_MAX = 4096
};

/* A family (of four links: in one assembly mode and sense), as far as a search must remember it.  Its problem is made
 * where somebody works on it. */
typedef struct lw_search_candidate {
    const lw_family *row;                    /* of four links; NULL: that of this number in the families */
    signed char mode, sense;
    lw_fit_state state;
    long        starts;
    lw_best_starts     *best;                        /* of its search, with families; NULL: nothing         */
} lw_search_candidate;

/* One piece of work of a round: draw from an arm, or look around what it found; and what came of it. */
typedef struct lw_search_job {
    int          arm;
    bool         around;
    lw_status    status;                     /* of making the problem                               */
    int          block, n_mode;              /* draws; see lw_best_starts                                   */
    long         evals, improved;
    lw_variables of;
} lw_search_job;

/* How much is done in a job. */
typedef struct lw_effort {
    int block, settle, improve;              /* draws, those settled, those improved                */
    int cost;                                /* of one evaluation, in those of dyads                */
} lw_effort;

enum { LW_SLOTS = 6 };

/* What one thread works with: problems made last, one of them in one branch, and scratch. */
typedef struct lw_slot {
    int            arm;                      /* -1: empty                                           */
    bool           coarse;
    long           used;                     /* when last                                           */
    lw_family_made made;
    lw_problem     problem;
} lw_slot;

typedef struct lw_workbench {
    lw_slot    *slot;                        /* (LW_SLOTS)                                          */
    lw_problem  local;
    void       *work;
    size_t      work_size;
    long        used;
} lw_workbench;

/* Where a sweep over families stands (fit_share.c). */
typedef struct lw_sweep {
    int *order, next;                        /* of all arms; the next that has not had its turn (n_arm) */
    int *arm, n, rung;                       /* those of this sweep, n at its beginning             */
    int go_on, n_sweep;                      /* after the first look; sweeps begun                  */
    bool apart;                              /* those with groups beyond dyads by themselves        */
    long mean_job;                           /* else what a job costs in the mean                   */
} lw_sweep;

typedef struct lw_search {
    const lw_target      *t;
    const lw_fit_options *o;
    lw_target  thin;                         /* fewer stations, for the search on a long target; n 0: not so */
    int        n_arm, n_thread, n_job, round;
    lw_search_candidate    *arm;
    lw_search_job job[LW_JOB_MAX];
    lw_sweep   sweep;
    lw_workbench *bench;                     /* of each thread                                      */
    lw_pool    pool, raw;                    /* polished; of this round's search                    */
    lw_found  *found;                        /* LW_KEEP of each job                        (n_found) */
    int        n_found;
    double     started, best_raw;            /* the latter in the search's own scale                */
    long       hits;                         /* how often the best of the search was found          */
    long       evals, improved;
} lw_search;

/* Make the arms of the families that are asked for, and the thinner target of a long one. */
lw_status lw_search_make_candidates(lw_search *s, lw_fit *out, lw_error *e);

/* The problem of an arm, for the search (coarse) or for the full target; it stays until LW_SLOTS others were made in this
 * thread.  NULL: *st says why. */
const lw_problem *lw_search_made(lw_search *s, int thread, int arm, bool coarse, lw_status *st);

/* A copy of it whose branch may be changed, the thread's only one, with scratch.  NULL as above. */
lw_problem *lw_search_problem(lw_search *s, int thread, int arm, bool coarse, lw_status *st);

/* Why the problem of an arm could not be made, with a text. */
lw_status lw_search_fault(lw_search *s, int arm, lw_error *e);

/* Family of an arm: the row of its type, or made in `made`. */
lw_status lw_search_family(const lw_search *s, int arm, lw_family_made *made, const lw_family **family);

lw_effort lw_search_effort(const lw_search *s, const lw_problem *p);

/* Begin to share; LW_E_MEMORY.  Then the jobs of a round, after what the arms have found. */
lw_status lw_search_halving_begin(lw_search *s);
void      lw_search_halving(lw_search *s);

/* Draw, improve, polish; the pool gets what was found.  LW_E_MEMORY, or as lw_problem_make what a family cannot be
 * excused for. */
lw_status lw_search_round(lw_search *s, lw_error *e);

/* Time over, or asked to stop. */
bool lw_search_stopped(const lw_search *s);

/* The pool as candidates, best first, each curve once. */
lw_status lw_search_rank(lw_search *s, lw_fit *out);

#endif

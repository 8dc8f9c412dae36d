/* optimise/search/fit_internal.h - the state of one search and its parts, from bottom to top: candidates and their
 * problems (fit.c), the work of a round (successive_halving.c), what finds are worth (judge.c), one round (fit_round.c), finds moved to where the
 * linkage counts as less (climb.c), the list of results (rank.c), the search (fit_run.c). */
#ifndef LW_OPTIMISE_SEARCH_FIT_INTERNAL_H
#define LW_OPTIMISE_SEARCH_FIT_INTERNAL_H

#include <stdatomic.h>

#include "optimise/problem/work.h"
#include "optimise/search/fit.h"
#include "optimise/search/pool.h"
#include "optimise/solvers/lm.h"

enum {
    LW_SEARCH_BLOCK = 400,             /* starts drawn by one job                                   */
    LW_SEARCH_BLOCK_MAX = 8,           /* jobs of a four-link candidate in a round                  */
    LW_KEEP = 8,                       /* finds that a job hands to the pool                        */
    LW_SEARCH_CANDIDATE_MAX = 80,      /* candidates of a search by types                           */
    LW_SEARCH_CANDIDATE_BEST = 4,      /* finds that a candidate keeps, to look around them         */
    LW_JOB_MAX = 4096,
    LW_SLOTS = 6                       /* problems that a thread keeps                              */
};

/* So small an f is that of an exact find or of a near miss.  Other starts have to be improved beside it, since an exact find
 * has f of about 1e-6 before its polish. */
#define LW_SEARCH_NEAR_MISS 1e-9

/* Something to search in: a family, and of four-link types one assembly mode and sense.  Only this much is kept of
 * it; its problem is made by the thread that works on it. */
typedef struct lw_search_candidate {
    const lw_family *row;              /* of a four-link type; NULL: the family with this number in the options */
    signed char      mode, sense;
    lw_fit_state     state;
    long             starts;
    lw_best_starts  *best;             /* best finds of a search over families; NULL: none yet      */
} lw_search_candidate;

/* One piece of work of a round: draw starts from a candidate, or search around its best finds; and its outcome. */
typedef struct lw_search_job {
    int          candidate;
    bool         around;
    lw_status    status;               /* of making the problem                                     */
    int          block, n_mode;        /* starts drawn; see lw_best_starts                          */
    long         evals, improved;
    lw_variables of;
} lw_search_job;

/* The work of one job. */
typedef struct lw_effort {
    int block, settle, improve;        /* starts drawn; of these settled; of these improved         */
    int cost;                          /* of one evaluation, in evaluations of a linkage of dyads   */
} lw_effort;

typedef struct lw_slot {
    int            candidate;          /* -1: the slot is empty                                     */
    bool           coarse;
    long           used;               /* when it was used last, counted by lw_workbench.used       */
    lw_family_made made;
    lw_problem     problem;
} lw_slot;

/* The data of one thread: its last problems, a copy of one with an intended motion of its own, and scratch. */
typedef struct lw_workbench {
    lw_slot    *slot;                  /* (LW_SLOTS)                                                */
    lw_problem  local;
    void       *work;
    size_t      work_size;
    double     *draws;                 /* (LW_SEARCH_BLOCK*LW_START_DRAWS)                          */
    long        used;
} lw_workbench;

/* The state of successive halving. */
typedef struct lw_family_sweep {
    int *order, next;                  /* all candidates in the order of their turns; the next one  (n_candidate) */
    int *candidate, n, rung;           /* candidates of this sweep; how often it was halved    (n)  */
    int  go_on, n_sweep;               /* how many go on after the first look; sweeps begun         */
    bool apart;                        /* candidates with groups beyond dyads are swept by themselves */
    long mean_job;                     /* if not: mean cost of a job                                */
} lw_family_sweep;

typedef struct lw_search {
    const lw_target      *t;
    const lw_fit_options *o;           /* own                                                       */
    lw_fit_options       own;
    lw_target            thin;         /* of a long target fewer stations, to search with; n 0: none */
    int                  n_candidate, n_thread, n_job, round;
    lw_search_candidate *candidate;
    lw_search_job        job[LW_JOB_MAX];
    lw_family_sweep             sweep;
    lw_workbench        *bench;        /* of each thread                                (n_thread)  */
    lw_pool              pool, raw;    /* polished finds; finds of this round before that           */
    lw_pool              shrunk;       /* finds made smaller within spec.tolerance                  */
    lw_pool              light;        /* finds for few stations that count as least, before they are polished */
    lw_found            *found;        /* LW_KEEP of each job                                       */
    int                  n_found;      /* jobs that `found` has memory for                          */
    double               started;      /* wall clock                                                */
    double               best_raw;     /* least f before polishing, in the scale of the search      */
    long                 hits;         /* how often that was found                                  */
    long                 evals, improved, starts;      /* starts: of candidates that were replaced    */
    atomic_bool          no_memory;    /* a part of the search found no memory: the search fails    */
} lw_search;

/* ---- fit.c */

/* Make the candidates that the options ask for, and the thin target.  LW_E_ARG: no type can do the task;
 * LW_E_MEMORY. */
lw_status lw_search_make_candidates(lw_search *s, lw_fit *out, lw_error *e);

/* The problem of a candidate for the thin target (coarse) or the full one.  It stays until this thread has made
 * LW_SLOTS others.  NULL: *st says why; without memory s->no_memory is set too. */
const lw_problem *lw_search_made(lw_search *s, int thread, int candidate, bool coarse, lw_status *st);

/* The thread's only copy of that problem, whose intended motion may be changed, with scratch in the thread's bench. */
lw_problem *lw_search_problem(lw_search *s, int thread, int candidate, bool coarse, lw_status *st);

/* Free the problems that a thread keeps. */
void lw_search_empty_slots(lw_workbench *b);

/* Why the problem of a candidate could not be made, with a text. */
lw_status lw_search_fault(lw_search *s, int candidate, lw_error *e);

/* The family of a candidate: the row of its type, or made in `made`. */
lw_status lw_search_family(const lw_search *s, int candidate, lw_family_made *made, const lw_family **family);

/* Evaluations of a search over families; fitting its finds again (lw_search_widen) may take as many again. */
long      lw_search_budget(const lw_search *s);

/* Evaluations of a linkage of dyads that one of a linkage with higher groups costs. */
int       lw_search_group_cost(const lw_search *s);
lw_effort lw_search_effort(const lw_search *s, const lw_problem *p);

/* Wall clock at which the jobs of a time limit end, 0: no limit; seconds after that, or after an interrupt, for the
 * last polish. */
double lw_search_end(const lw_search *s);
double lw_search_grace(const lw_search *s);

/* At most so many finds are fitted again for a front (lw_search_widen). */
#define LW_SEARCH_LEFT 15

/* Is that done, and which seconds of a time limit are kept for it? */
bool   lw_search_widens(const lw_search *s);
double lw_search_widening(const lw_search *s);

/* Is the time over, or was the search asked to stop? */
bool lw_search_stopped(const lw_search *s);

/* ---- successive_halving.c: prepare, or LW_E_MEMORY; make the jobs of the next round */
lw_status lw_search_halving_begin(lw_search *s);
void      lw_search_halving(lw_search *s);

/* ---- judge.c */

/* The problem of a find with its conditions and a least transmission angle [deg], in the find's intended motion; scratch in the thread's
 * bench.  NULL: *st says why. */
lw_problem *lw_search_problem_again(lw_search *s, int thread, double angle, lw_found *c, lw_status *st);

/* Find out f of an improved find and how far it is from keeping the conditions; f becomes INFINITY if it is no result. */
void lw_search_judge(const lw_search *s, const lw_problem *p, lw_work *work, lw_found *c);

/* Are finds of this search moved to where the linkage counts as less (lw_fit_options.cost)?  They are for few stations. */
bool lw_search_climbs(const lw_search *s);

/* What a judged find counts as; INFINITY: it is no result. */
double lw_search_cost(lw_search *s, int thread, const lw_found *c);

/* Judge a find for few stations, unless it is polished, and find out what it counts as: its `cost`. */
void lw_search_weigh(lw_search *s, int thread, lw_found *c);

/* ---- fit_round.c: run the jobs, improve and polish their finds, and put these in the pool.  LW_E_MEMORY, or a failure
 * of lw_problem_make other than that a family cannot do the task. */
lw_status lw_search_round(lw_search *s, lw_error *e);

/* After a search without timing: the pool again, its stations in their order along the curves. */
lw_status lw_search_order_stations(lw_search *s, lw_fit *out, lw_error *e);

/* Before the pool is ranked: fit its best finds again with less size and with greater transmission angles, so that the
 * results are a front; `go_on` then moves them until a time (0: no limit), lw_search_climb.  With spec.tolerance, at last put the smallest linkages
 * within it into s->shrunk. */
lw_status lw_search_widen(lw_search *s, lw_status (*go_on)(lw_search *s, double until));

/* Improve c by least squares; with `conditions`, by a solver that keeps conditions on the motion where these are violated. */
void lw_search_improve(lw_search *s, const lw_problem *p, const lw_lm_options *o, bool conditions, void *work, lw_found *c);

/* ---- climb.c */

/* Move the finds of both pools that count as least to where the linkage counts as less (lw_fit_options.cost), until wall clock `until` (0: no
 * limit).  LW_E_MEMORY. */
lw_status lw_search_climb(lw_search *s, double until);

/* ---- rank.c: the pool as candidates for the caller, best first, each curve once */
lw_status lw_search_rank(lw_search *s, lw_fit *out);

/* Fill `out` with one find, by the bench of this thread; false: no memory, which s->no_memory tells, or no inputs suit its stations. */
bool lw_search_fill(lw_search *s, int thread, const lw_found *c, lw_candidate *out);

#endif

/* optimise/search/fit.h - from a target to a ranked list of linkages.
 *
 * A search consists of rounds.  A round draws many low-discrepancy starts in every family, assembly mode and sense
 * (optimise/search/start.h), improves the best of them by local least squares, and polishes the best of these.
 * Rounds and evaluations end the search, not seconds; so the answer depends on the seed only and not on the number
 * of threads.  A time limit can end it earlier, which `stop` then says. */
#ifndef LW_OPTIMISE_SEARCH_FIT_H
#define LW_OPTIMISE_SEARCH_FIT_H

#include "base/parallel.h"
#include "optimise/search/families.h"
#include "optimise/solvers/solver.h"

#define LW_HIGHER_COST 20
#define LW_FIT_BUDGET 1000000        /* evaluations of a search over families                       */

/* Which of the four-link families to search in.  A search of all of them is one in the cranks, which is what
 * `crank_only` without drag links asks for, and one in the others: so it is never worse than that.  LW_FIT_COMPACT: in
 * cranks no larger than LW_COMPACT_SIZE, or of a function with no greater ratio of lengths than LW_COMPACT_RATIO, which a
 * search that only lowers the error passes by. */
typedef enum lw_fit_part { LW_FIT_WHOLE, LW_FIT_CRANKS, LW_FIT_OTHERS, LW_FIT_COMPACT, LW_FIT_PARTS } lw_fit_part;
#define LW_COMPACT_SIZE  1.5         /* diagonals of the target                                     */
#define LW_COMPACT_RATIO 8

struct lw_candidate;

typedef struct lw_fit_options {
    lw_fit_spec spec;
    lw_fit_part part;            /* of `types` (LW_FIT_WHOLE)                                        */
    bool        both_ways;       /* with free timing: search without timing, from the points to the curve and back, then
                                  * order the stations along the curves found                       */
    const char *types;           /* names or letters of mbs/plan/types.h with commas between, or "all" ("fourbar") */
    const lw_families *families; /* search in these by successive halving instead of in types; NULL: in types */
    long        budget;          /* with `families`: no round begins after this many evaluations, and finds are fitted again at
                                  * other sizes with as many again.  An evaluation of a linkage with higher groups counts as
                                  * LW_HIGHER_COST.  0: LW_FIT_BUDGET */
    long        sweep;           /* with `families`: evaluations that the first look of the first sweep may cost, and
                                  * the same number for its halvings; each further sweep costs twice as much as the
                                  * one before.  0: 500000                                          */
    const lw_solver *solver;     /* local solver that improves starts; NULL: lm                     */
    uint64_t    seed;            /* 1                                                               */
    int         part_number;     /* with `families`: of a search in parts; each draws starts of its own */
    bool        whole_rounds;    /* other searches have results with as many links: a short round that time ends counts as
                                  * not begun, so that a search with more time finds all that one with less does */
    int         jobs;            /* threads; < 1: one per core                                      */
    double      max_seconds;     /* 0: no limit                                                     */
    const lw_sharing *sharing;   /* who runs the loops of a round; NULL: the threads of this process.  Processes that share
                                  * a search must all have the same target and options, and max_seconds 0 */
    long        starts;          /* starts of each candidate in a round; 0: by the type              */
    int         max_rounds;      /* 0: by the size of the problem                                   */
    double      rounds_from, rounds_to;      /* with `types`: only this part of the rounds, 0 to 1; rounds_to 0: to the end */
    bool        no_front;        /* another search starts from what is found: unless the target is met exactly, finds are not fitted again
                                  * at other sizes                                                  */
    int         n_result;        /* most results (10)                                               */
    const volatile int *interrupt;   /* the search stops when it becomes nonzero; NULL: nothing stops it */
    /* Called after each round, may be NULL; done in [0, 1], best objective so far. */
    void      (*progress)(void *context, double done, double seconds, double best);
    /* Called before each part of a search in stages, of linkages with so many links; may be NULL.  `done` begins again. */
    void      (*begun)(void *context, int links);
    /* Called after each round that found something better, for work-precision curves; may be NULL. */
    void      (*improved)(void *context, long evals, double seconds, double best);
    /* Called after each round whose best find is better than that of the rounds before; may be NULL. */
    void      (*found)(void *context, const struct lw_candidate *best);
    void       *context;
    /* What a linkage counts as, less is better, as a logarithm; INFINITY: it is no result.  Called from several threads.  With default limits
     * finds for a few stations are moved to where they count as less; NULL: they are not. */
    double    (*cost)(const lw_target *t, const lw_fit_spec *s, const struct lw_candidate *c);
} lw_fit_options;
lw_fit_options lw_fit_options_default(void);

/* How many candidates a search keeps: with default limits more than results, to choose from. */
int lw_fit_kept(const lw_fit_options *o);

/* One linkage found. Dimensions in SI, in the user's frame; inputs in the ground frame, as the plan counts them
 * (mbs/plan/plan.h, input_turns_per_period). */
typedef struct lw_candidate {
    const lw_family *family;
    lw_family_made  *own;        /* with families: the memory that `family` points to               */
    lw_intended_motion intended; /* assembly mode, sense of the run                                 */
    double  dim[LW_DIM_MAX];     /* in the order of the plan of its type                            */
    int     n_dim;
    double  input0, tool0;       /* 0 where the task has none                                       */
    double  tool[LW_ALSO_MAX];   /* mounting angles of further points [rad]; 0 where there is none  */
    double  objective;           /* eq. 17 in SI                                                    */
    int     beyond;              /* 0: it keeps the conditions; greater: the farther from that      */
    double  longest;             /* greatest length or coordinate of its dimensions [m], of a function lw_problem_size */
    double  gentle;              /* least transmission angle that it was fitted with beyond that of the specification [deg] */
    bool    shrunk;              /* a find made smaller within spec.tolerance: only results look at it, a search goes on without it */
    int     n_sample;            /* without timing: curve samples whose distance from the target is in the objective */
    double  sample_weight;       /* of each, as lw_target.weight                                    */
    double *input;               /* of each station and sample [rad] or [m]   (n_station + n_sample) */
    double *mode_of;             /* assembly mode of each dyad there; NULL: intended.mode everywhere
                                  *                                 ((n_station + n_sample)*n_dyad) */
    int     n_dyad;
    long    evals;               /* of the start and improvement that led here                      */
    lw_fit_part part;            /* of the options of the search, and ...                           */
    int     part_number;         /* ... this one                                                    */
    double  seconds;             /* when it was found                                               */
    lw_stop stop;                /* why its improvement ended                                       */
    struct lw_fit_report *report;    /* made before, plain data; NULL: not yet                      */
} lw_candidate;

/* The outcome of one family of lw_fit_options.families. */
typedef enum lw_fit_state {
    LW_FIT_UNREACHED,            /* the budget ended before its turn                                */
    LW_FIT_UNABLE,               /* it cannot do this task (LW_E_KIND)                              */
    LW_FIT_LOOKED,               /* starts were drawn; no linkage that closes was found             */
    LW_FIT_CLOSED,               /* a linkage that closes was found                                 */
    LW_FIT_STATES
} lw_fit_state;

typedef struct lw_fit {
    int           n;             /* candidates, best first, no two with the same curve              */
    lw_candidate *candidate;
    long          starts, improved, evals, rounds;
    double        seconds;
    lw_stop       stop;          /* LW_STOP_F_TARGET exact; _F_TOL the best was found again and again; _EVALS all rounds
                                  * or the budget; _TIME; _USER                                     */
    int           n_state;       /* with families: their number                                     */
    unsigned char *state;        /* lw_fit_state of each                                   (n_state) */
    char          skipped[512];  /* types that cannot do this task, with the reason                 */
} lw_fit;

/* LW_OK; LW_NOTHING when no family has a feasible linkage; LW_STOPPED with what was found when the time or the user
 * ended it; failures < 0 as lw_problem_make.  After LW_NOTHING, LW_STOPPED and LW_OK free `out`. */
lw_status lw_fit_run(const lw_target *t, const lw_fit_options *o, lw_fit *out, lw_error *e);
void      lw_fit_free(lw_fit *f);
void      lw_candidate_free(lw_candidate *c);

/* Links of a candidate's mechanism. */
int lw_candidate_links(const lw_candidate *c);

#endif

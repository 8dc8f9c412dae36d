/* optimise/search/fit.h - from a target to a ranked list of linkages.
 *
 * Rounds of: many low-discrepancy starts in every family, assembly mode and sense (optimise/search/start.h),
 * the best by their error improved by local least squares, the best of these polished.  Rounds and
 * not seconds decide when it ends, so that the answer depends on the seed only, not on the number of
 * threads; a time limit can end it earlier and is then given as the reason. */
#ifndef LW_OPTIMISE_SEARCH_FIT_H
#define LW_OPTIMISE_SEARCH_FIT_H

#include "optimise/search/families.h"
#include "optimise/solvers/solver.h"

#define LW_HIGHER_COST 20

typedef struct lw_fit_options {
    lw_fit_spec spec;
    const char *types;           /* names or letters of mbs/plan/types.h, comma separated, or "all"
                                  * ("fourbar")                                                     */
    const lw_families *families; /* look in these instead, by successive halving; NULL: by types     */
    long        budget;          /* evaluations of f after which no further round begins, with `families`; one
                                  * of a linkage with higher groups counts LW_HIGHER_COST of them; 0: by
                                  * default                                                          */
    long        sweep;           /* evaluations that the first look of the first sweep over families may cost, and as
                                  * many the rest of it; each further sweep twice as many; 0: 500000   */
    const lw_solver *solver;     /* local solver of the improvement; NULL: lm                       */
    uint64_t    seed;            /* 1                                                               */
    int         jobs;            /* threads; < 1: one per core                                      */
    double      max_seconds;     /* 0: no limit                                                     */
    long        starts;          /* a round and arm; 0: by default                                  */
    int         max_rounds;      /* 0: by the effort of a problem of this size                      */
    int         n_result;        /* 10                                                              */
    const volatile int *interrupt;
    void      (*progress)(void *context, double done, double seconds, double best);
    /* called after each round that found something better, for work-precision curves; may be NULL */
    void      (*improved)(void *context, long evals, double seconds, double best);
    void       *context;
} lw_fit_options;
lw_fit_options lw_fit_options_default(void);

/* One linkage found. Dimensions in SI, in the user's frame; inputs in the ground frame, as
 * the plan counts them (mbs/plan/plan.h, laps). */
typedef struct lw_candidate {
    const lw_family *family;
    lw_family_made  *own;        /* with families: where `family` points                            */
    lw_intended_motion branch;            /* assembly, sense of the run                                      */
    double  dim[LW_DIM_MAX];     /* in the order of the plan of its type                            */
    int     n_dim;
    double  input0, tool0;       /* 0 where the task has none                                       */
    double  tool[LW_ALSO_MAX];   /* mounting angles of further points [rad]; 0 where there is none  */
    double  objective;           /* eq. 17 in the user's units (SI)                                 */
    double *input;               /* of each station [rad] or [m]                     (n_station)    */
    double *mode_of;             /* assembly at each station, one after the other; NULL: branch.mode (n_station*n_dyad) */
    int     n_dyad;
    long    evals;               /* of the start and improvement that led here                      */
    double  seconds;             /* when it was found                                               */
    lw_stop stop;                /* why its improvement ended                                       */
} lw_candidate;

/* What became of one family of lw_fit_options.families. */
typedef enum lw_fit_state {
    LW_FIT_UNREACHED,            /* the budget ended before its turn                                */
    LW_FIT_UNABLE,               /* it cannot do this task (LW_E_KIND)                              */
    LW_FIT_LOOKED,               /* starts were drawn; no linkage that closes was found             */
    LW_FIT_CLOSED,               /* a linkage that closes was found                                 */
    LW_FIT_STATES
} lw_fit_state;

typedef struct lw_fit {
    int           n;             /* candidates, best first, no two of one curve                     */
    lw_candidate *candidate;
    long          starts, improved, evals, rounds;
    double        seconds;
    lw_stop       stop;          /* LW_STOP_F_TARGET exact, _F_TOL nothing better in many rounds, _EVALS all
                                  * rounds, _TIME, _USER                                            */
    int           n_state;       /* with families: as many as these                                 */
    unsigned char *state;        /* lw_fit_state of each                                   (n_state) */
    char          skipped[512];  /* types that cannot do this task, with the reason              */
} lw_fit;

/* LW_OK, LW_NOTHING when no family has a feasible member, LW_STOPPED with what was found when time
 * or the user ended it; failures < 0 as lw_problem_make. */
lw_status lw_fit_run(const lw_target *t, const lw_fit_options *o, lw_fit *out, lw_error *e);
void      lw_fit_free(lw_fit *f);
void      lw_candidate_free(lw_candidate *c);

/* Links of a candidate's mechanism. */
int lw_candidate_links(const lw_candidate *c);

#endif

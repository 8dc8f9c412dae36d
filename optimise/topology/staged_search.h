/* optimise/topology/staged_search.h - fits of one target stage by stage: linkages of four, six, eight, ... links.
 *
 * The best linkages of a stage with two links fewer, and a dyad added, are starts of the next stage; so more links
 * are never worse than fewer.  The caller says which families a stage has.
 *
 * With default limits, and under a time limit, stages are searched in parts of growing size that start again from their best linkages.
 * Neither budget nor time change the parts, and what was found is kept: a larger budget, or more time, finds all that a smaller one finds.
 * Without a time limit the parts of a stage of families end after 1e4, 3e4, 1e5, 3e5, 1e6, ... evaluations; a search of a part that would exceed
 * the budget is not begun.  Under a time limit parts double, and the stage that gains most per evaluation has the next part.
 *
 * With default limits a part divides its budget among a search for cranks, one for small cranks, and the better of the two.  If the
 * input need not turn, linkages of other kinds then have half as much again.  Searches for cranks see only what searches for cranks
 * found: a search for all linkages makes all searches of one with `crank_only`, and finds what that finds.
 */
#ifndef LW_OPTIMISE_TOPOLOGY_STAGED_SEARCH_H
#define LW_OPTIMISE_TOPOLOGY_STAGED_SEARCH_H

#include "optimise/report/report.h"

#define LW_STAGE_MAX 24

typedef struct lw_search_stage {
    int              links;
    lw_families      families;       /* make NULL: the four-link types of lw_fit_options.types      */
    double           unless;         /* > 0, with default limits: this stage and all after it are left out if of the cranks found the first row
                                      * counts as no more than this (lw_fit_report.counts_as), or is within spec.tolerance.  Once begun, they
                                      * end after a part after which both are so, or which lowered what the row counts as by less than a twentieth,
                                      * to no more than 0.05: without a time limit from 3e4 evaluations on, of more than LW_FEW_STATIONS from 3e5 on,
                                      * unless the row counts as no more than LW_GOOD; under a time limit to no more than LW_ENOUGH after any part.
                                      * If it counts as no more than LW_ENOUGH with others than cranks, only cranks are searched */
    long             budget;         /* of the stage; 0: that of lw_fit_options                      */
    /* Write the name of a linkage with an added dyad.  LW_NOTHING: the linkage is not wanted; a failure ends the search.
     * NULL: names come from the parent. */
    lw_status      (*name)(void *context, const lw_linkage *linkage, char *name, size_t size);
    void            *context;
} lw_search_stage;

typedef struct lw_stage_result {
    int        links, n_grown;       /* n_grown: starts with an added dyad                          */
    int        n_part;               /* searches made, ...                                          */
    int        n_of[2];              /* ... of families: for cranks or of all, and for others       */
    double     best;                 /* objective; INFINITY: nothing was found                      */
    long       starts, improved, evals;
    double     seconds;              /* of the stage                                                */
    int        n_state;
    unsigned char *state;            /* lw_fit_state of the stage's families, without those grown (n_state) */
    lw_stop    stop;
} lw_stage_result;

typedef struct lw_staged_search {
    lw_fit          fit;             /* candidates of all stages, best first; some of every number of links */
    int             n_stage;
    lw_stage_result stage[LW_STAGE_MAX];
} lw_staged_search;

/* o->families is not used; o->budget is that of each stage.  With budget 0 and a time limit each stage has LW_FIT_BUDGET, and
 * then the stages of families go on until the time ends; LW_OK says that they had so much.  Other statuses as lw_fit_run. */
lw_status lw_staged_search_run(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, int n_stage,
                               lw_staged_search *out, lw_error *e);
void      lw_staged_search_free(lw_staged_search *s);

#endif

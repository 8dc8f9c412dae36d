/* optimise/topology/staged_search.h - one target, linkages of four, six, eight links: fits stage by stage, the best of
 * each stage grown into starts of the next, so that more links are never worse than fewer.
 *
 * Which topologies there are the caller says (enumerate/ is not known here). */
#ifndef LW_OPTIMISE_TOPOLOGY_STAGED_SEARCH_H
#define LW_OPTIMISE_TOPOLOGY_STAGED_SEARCH_H

#include "optimise/report/report.h"

#define LW_STAGE_MAX 24

/* The families of one number of links; families.make NULL: four-link types, as lw_fit_options.types says. */
typedef struct lw_search_stage {
    int              links;
    lw_families      families;
    /* What a grown linkage of the stage is called; false: it is not wanted.  NULL: by its parent. */
    bool           (*name)(void *context, const lw_linkage *k, char *name, size_t size);
    void            *context;
} lw_search_stage;

/* What came of a stage. */
typedef struct lw_stage_result {
    int        links, n_grown;       /* starts grown out of the stage before                        */
    double     best;                 /* objective; INFINITY: nothing                                */
    long       starts, improved, evals;
    double     seconds;              /* of the stage                                                */
    int        n_state;
    unsigned char *state;            /* lw_fit_state of the stage's families, without grown ones (n_state) */
    lw_stop    stop;
} lw_stage_result;

typedef struct lw_staged_search {
    lw_fit          fit;             /* candidates of all stages, best first; of every stage its best  */
    int             n_stage;
    lw_stage_result stage[LW_STAGE_MAX];
} lw_staged_search;

/* o->families is not used; o->budget counts for each stage.  Statuses as lw_fit_run. */
lw_status lw_staged_search_run(const lw_target *t, const lw_fit_options *o, const lw_search_stage *stage, int n_stage,
                        lw_staged_search *out, lw_error *e);
void      lw_staged_search_free(lw_staged_search *s);

#endif

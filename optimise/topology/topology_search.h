/* optimise/topology/topology_search.h - a search over topologies in one call: from a target to ranked linkages of
 * four, six, eight, ... links that pass a second, independent simulation.
 *
 *     lw_topology_search_options o = lw_topology_search_options_default();
 *     lw_topology_search found;
 *     o.links = 6;
 *     if (lw_topology_search_run(&target, &o, &found, &e) >= 0) {
 *         for (int i = 0; i < found.results.n; i++)
 *             ... found.results.report[i].linkage, .error_mean, ...
 *         lw_topology_search_free(&found);
 *     }
 *
 * The search goes through stages in a fixed order: the four-link types; mechanisms of pins with six, eight, ...
 * links, and with them the starting linkages of that size; mechanisms with sliders; mechanisms with slots and
 * gears.  A stage is the same search whatever follows it.  The best linkages of a stage with two links fewer, and a
 * dyad added, are starts of the next stage, so more links are never worse than fewer.  Same seed, same answer, for
 * any number of threads. */
#ifndef LW_OPTIMISE_TOPOLOGY_TOPOLOGY_SEARCH_H
#define LW_OPTIMISE_TOPOLOGY_TOPOLOGY_SEARCH_H

#include "optimise/report/results.h"
#include "optimise/topology/mechanism_set.h"

#define LW_DEFAULT_GEAR_RATIOS  "1,-1,2,-2,1/2,-1/2,3,-3,1/3,-1/3"
#define LW_DEFAULT_INPUT_RATIOS "1,-1,2,-2,3,-3"

typedef struct lw_topology_search_options {
    lw_fit_options fit;          /* conditions, four-link types, solver, seed, threads, limits, number of results,
                                  * callbacks, stop flag.  `budget` and the progress count for each stage; `families` is
                                  * not used                                                        */
    int         links;           /* most links of a mechanism, 10 at most; 0: the fewest with these freedoms, and as
                                  * `more` says                                                     */
    bool        more;            /* links 0, four-bars with default limits: slider-cranks too for a straight path with prescribed timing; six
                                  * links too if of the cranks found the first row counts as more than LW_ENOUGH, or of few stations
                                  * LW_GOOD (lw_fit_report.counts_as), or is not within spec.tolerance; with as much of the budget as
                                  * lw_search_stage.unless says */
    int         freedoms;        /* degree of freedom F, 1 .. LW_PACKED_INPUT_MAX (1).  F inputs are at the ground; all
                                  * but one are tied to that one, by a ratio of input_ratios        */
    const char *joints;          /* kinds of joints beyond the four-link types: letters of "rtpg", with or without
                                  * commas; r pin, t slider, p pin in a slot, g gear pair ("r")     */
    const char *topologies;      /* which mechanisms, see lw_mechanism_request.only ("all")         */
    const char *gear_ratios;     /* ratios that gear pairs are tried with (LW_DEFAULT_GEAR_RATIOS)  */
    const char *input_ratios;    /* ratios of tied inputs (LW_DEFAULT_INPUT_RATIOS)                 */
    int               n_start;
    const lw_linkage *start;     /* linkages to start from as well, see lw_start_check      (n_start) */
} lw_topology_search_options;
lw_topology_search_options lw_topology_search_options_default(void);

/* The search with one number of links, and its best result. */
typedef struct lw_links_summary {
    int    links;
    int    n_stage;              /* stages with this number of links that were searched            */
    int    best;                 /* result with the least objective and at most this many links; -1: none */
    int    n_grown;              /* starts that are a smaller result with a dyad added              */
    int    n_point_choice;       /* choices of links for the target's further points                */
    long   starts, improved;     /* starting points; local fits                                     */
    double seconds;
} lw_links_summary;

/* The outcome of the mechanisms of one lw_mechanism_stage. */
typedef struct lw_mechanism_summary {
    int               links;
    bool              two_freedoms;           /* chains with slots or gears                         */
    lw_mechanism_tally tally;
    long              state[LW_FIT_STATES];   /* how many of the mechanisms fitted are in each state; of a target with
                                               * several points, of the choices of links for them   */
} lw_mechanism_summary;

/* Plain memory: may be copied and moved; only the last copy is freed. */
typedef struct lw_topology_search {
    lw_staged_search found;                   /* candidates, and what each stage did                */
    lw_fit_results   results;                 /* the candidates that were verified                  */
    int              n_links;
    lw_links_summary by_links[LW_LINK_MAX];   /* by rising number of links                (n_links) */
    int              freedoms, n_input_ratio; /* as requested; how many ratios tied inputs were tried with */
    int                  uncounted_links;         /* links of the smallest mechanisms left out since counting them took more
                                               * than half of the time limit; 0: none               */
    int                  n_mechanisms;        /* 0: no topologies beyond the four-link types        */
    lw_mechanism_summary mechanisms[LW_STAGE_MAX];                               /* (n_mechanisms)  */
} lw_topology_search;

/* LW_OK; LW_STOPPED with what was found when the time or the user ended it; LW_NOTHING, no linkage was found.  LW_OK
 * does not say that a candidate was verified: results.n may be 0, results.left_out says why. Failures < 0 with a
 * text: LW_E_ARG an option, LW_E_KIND no type can do the task, LW_E_MEMORY, or as lw_problem_make.  After LW_NOTHING
 * and failures there is nothing to free. */
lw_status lw_topology_search_run(const lw_target *t, const lw_topology_search_options *o, lw_topology_search *out, lw_error *e);
void      lw_topology_search_free(lw_topology_search *s);

/* May a search start from this linkage?  It needs one input, beside those tied to it, and a tracer.  LW_E_ARG. */
lw_status lw_start_check(const lw_linkage *linkage, lw_error *e);

#endif

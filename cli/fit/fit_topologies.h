/* cli/fit/fit_topologies.h - from numbers of links to families that a fit can search: every chain, ground link and
 * tracer link once up to symmetry, those left out with the reason, and the inputs of each counted. */
#ifndef CLI_FIT_FIT_TOPOLOGIES_H
#define CLI_FIT_FIT_TOPOLOGIES_H

#include "cli/fit/fit_topology.h"
#include "optimise/search/staged_search.h"

/* Why a ground and tracer link is not fitted by itself. */
typedef enum cli_topology_fate {
    CLI_TOPOLOGY_FITTED,
    CLI_TOPOLOGY_CIRCLE,       /* the tracer link is joined to the ground: a circle or a line     */
    CLI_TOPOLOGY_SMALLER,      /* its point moves as that of a mechanism with fewer links          */
    CLI_TOPOLOGY_NO_PLAN,      /* no input lets it be worked out; F > 1: no F pins at the ground  */
    CLI_TOPOLOGY_GEAR,         /* no link, or more than one, on which both sides of a gear turn or slide */
    CLI_TOPOLOGY_NOT_ASKED,    /* --topology leaves it out                                        */
    CLI_TOPOLOGY_FATES
} cli_topology_fate;

/* Chains with slots and gears: at most so many links and such joints together.  A pin in a slot moves as a pin and a
 * slider with a massless block between, which is not counted as a link. */
#define CLI_TOPOLOGY_EXPANDED 8

/* What there is with one number of links. */
typedef struct cli_topology_stage {
    int         links;
    bool        higher;                                            /* chains with slots or gears    */
    int         stage, slides;                                     /* of the search, see cli_fit_stages_make */
    long        n_chain, n_ground, n_labelled, n_pair, n_driven;   /* pairs of ground and tracer link, slots either way;
                                                                    * with F inputs                 */
    long        n_set, n_set_out;                                  /* F > 1, of the pairs not left out: with all inputs
                                                                    * at the ground; of these left out */
    long        fate[CLI_TOPOLOGY_FATES];                          /* of the pairs                  */
    long        n_group;                                           /* fitted that hold a group beyond dyads */
    int         n_family, n_pins, capacity;                        /* those of pins alone come first */
    cli_topology *family;                                          /* (n_family) owned              */
    int         n_list, list_capacity;
    cli_topology_chain *list;                                      /* (n_list) owned                */
    const struct cli_topologies *all;
} cli_topology_stage;

/* Stays where it is made: its stages point to it. */
typedef struct cli_topologies {
    int                n, dof;
    bool               wish_all, timed;
    cli_topology_ratios ratio;
    cli_topology_stage stage[LW_STAGE_MAX];
} cli_topologies;

typedef struct cli_topology_request {
    int         links;         /* 4, 6, 8: all up to these; with slots and gears odd ones too; F = 2: 5, 7, 9 */
    int         dof;           /* F, 1 .. CLI_TOPOLOGY_INPUTS: so many inputs, all but the first tied */
    const char *kinds;         /* letters of joints, of "rtpg"                                    */
    cli_topology_ratios ratio;
    const char *only;          /* "watt1,stephenson3", "8.5", "5.1.2", or "all"                    */
    lw_task     task;
    bool        timed;         /* the input matters: every input at the ground by itself           */
    int         jobs;          /* threads; < 1: one per core                                       */
    const volatile int *interrupt;   /* not 0: count no further; NULL: nobody asks                  */
} cli_topology_request;

/* Do these kinds of joints hold one of two freedoms? */
bool cli_topology_higher(const char *kinds);

/* Those of pins and sliders by rising number of links, with F = 1 from six, then those with slots and gears from three.
 * With a text: LW_E_ARG, a name in `only` that nothing bears; LW_NOTHING, interrupted. */
lw_status cli_topologies_make(const cli_topology_request *w, cli_topologies *t, lw_error *e);
void      cli_topologies_free(cli_topologies *t);

/* The mechanisms of a stage, as families: all, those of pins alone, the others. */
lw_families cli_topology_families(const cli_topology_stage *s);
lw_families cli_topology_pins(const cli_topology_stage *s);
lw_families cli_topology_slides(const cli_topology_stage *s);

/* The name of the topology of a linkage, by its chain, ground and tracer link (an lw_search_stage.name with a
 * cli_topologies as context); false: it is not among those to be fitted. */
bool cli_topologies_name(void *topologies, const lw_linkage *k, char *name, size_t size);

const char *cli_topology_fate_text(cli_topology_fate f);

#endif

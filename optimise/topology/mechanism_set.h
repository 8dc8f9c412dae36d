/* optimise/topology/mechanism_set.h - from numbers of links to families that a fit can search: every chain, ground link and
 * tracer link once up to symmetry, those left out with the reason, and the inputs of each counted. */
#ifndef LW_OPTIMISE_TOPOLOGY_MECHANISM_SET_H
#define LW_OPTIMISE_TOPOLOGY_MECHANISM_SET_H

#include "optimise/topology/packed_mechanism.h"
#include "optimise/topology/staged_search.h"

/* Why a ground and tracer link is not fitted by itself. */
typedef enum lw_pair_outcome {
    LW_PAIR_FITTED,
    LW_PAIR_CIRCLE,       /* the tracer link is joined to the ground: a circle or a line     */
    LW_PAIR_SMALLER,      /* its point moves as that of a mechanism with fewer links          */
    LW_PAIR_NO_PLAN,      /* no input lets it be worked out; F > 1: no F pins at the ground  */
    LW_PAIR_NO_CARRIER,         /* no link, or more than one, on which both sides of a gear turn or slide */
    LW_PAIR_NOT_REQUESTED,    /* --topology leaves it out                                        */
    LW_PAIR_OUTCOMES
} lw_pair_outcome;

/* Chains with slots and gears: at most so many links and such joints together.  A pin in a slot moves as a pin and a
 * slider with a massless block between, which is not counted as a link. */
#define LW_EXPANDED_LINK_MAX 8

/* What there is with one number of links. */
typedef struct lw_mechanism_stage {
    int         links;
    bool        higher;                                            /* chains with slots or gears    */
    int         stage, slides;                                     /* of the search, see cli_fit_stages_make */
    long        n_chain, n_ground, n_labelled, n_pair, n_driven;   /* pairs of ground and tracer link, slots either way;
                                                                    * with F inputs                 */
    long        n_set, n_set_out;                                  /* F > 1, of the pairs not left out: with all inputs
                                                                    * at the ground; of these left out */
    long        fate[LW_PAIR_OUTCOMES];                          /* of the pairs                  */
    long        n_group;                                           /* fitted that hold a group beyond dyads */
    int         n_family, n_pins, capacity;                        /* those of pins alone come first */
    lw_packed_mechanism *family;                                          /* (n_family) owned              */
    int         n_list, list_capacity;
    lw_numbered_chain *list;                                      /* (n_list) owned                */
    const struct lw_mechanism_set *all;
} lw_mechanism_stage;

/* Stays where it is made: its stages point to it. */
typedef struct lw_mechanism_set {
    int                n, dof;
    bool               wish_all, timed;
    lw_ratio_choices ratio;
    lw_mechanism_stage stage[LW_STAGE_MAX];
} lw_mechanism_set;

typedef struct lw_mechanism_request {
    int         links;         /* 4, 6, 8: all up to these; with slots and gears odd ones too; F = 2: 5, 7, 9 */
    int         dof;           /* F, 1 .. LW_PACKED_INPUT_MAX: so many inputs, all but the first tied */
    const char *kinds;         /* letters of joints, of "rtpg"                                    */
    lw_ratio_choices ratio;
    const char *only;          /* "watt1,stephenson3", "8.5", "5.1.2", or "all"                    */
    lw_task     task;
    bool        timed;         /* the input matters: every input at the ground by itself           */
    int         jobs;          /* threads; < 1: one per core                                       */
    const volatile int *interrupt;   /* not 0: count no further; NULL: nobody asks                  */
} lw_mechanism_request;

/* Do these kinds of joints hold one of two freedoms? */
bool lw_kinds_have_two_freedoms(const char *kinds);

/* Those of pins and sliders by rising number of links, with F = 1 from six, then those with slots and gears from three.
 * With a text: LW_E_ARG, a name in `only` that nothing bears; LW_NOTHING, interrupted. */
lw_status lw_mechanism_set_make(const lw_mechanism_request *w, lw_mechanism_set *t, lw_error *e);
void      lw_mechanism_set_free(lw_mechanism_set *t);

/* The mechanisms of a stage, as families: all, those of pins alone, the others. */
lw_families lw_mechanism_stage_families(const lw_mechanism_stage *s);
lw_families lw_mechanism_stage_pins(const lw_mechanism_stage *s);
lw_families lw_mechanism_stage_others(const lw_mechanism_stage *s);

/* The name of the topology of a linkage, by its chain, ground and tracer link (an lw_search_stage.name with a
 * lw_mechanism_set as context); false: it is not among those to be fitted. */
bool lw_mechanism_set_name(void *topologies, const lw_linkage *k, char *name, size_t size);

const char *lw_pair_outcome_text(lw_pair_outcome f);

#endif

/* optimise/topology/mechanism_set.h - the mechanisms that a search goes through: from numbers of links to chains,
 * ground links, tracer links and inputs, each once up to symmetry, as families to fit.
 *
 * A pair of ground link and tracer link that is not fitted is counted by the reason. */
#ifndef LW_OPTIMISE_TOPOLOGY_MECHANISM_SET_H
#define LW_OPTIMISE_TOPOLOGY_MECHANISM_SET_H

#include "optimise/topology/packed_mechanism.h"
#include "optimise/topology/staged_search.h"

/* The decision about a pair of ground link and tracer link. */
typedef enum lw_pair_outcome {
    LW_PAIR_FITTED,
    LW_PAIR_CIRCLE,            /* the tracer link is joined to the ground: its points draw circles or lines */
    LW_PAIR_SMALLER,           /* a mechanism with fewer links moves the point in the same way      */
    LW_PAIR_NO_PLAN,           /* no input makes the posture computable; F > 1: there are no F pins at the ground */
    LW_PAIR_NO_CARRIER,        /* a gear pair has no link, or several, on which both its sides turn or slide */
    LW_PAIR_NOT_REQUESTED,     /* lw_mechanism_request.only leaves it out                           */
    LW_PAIR_OUTCOMES
} lw_pair_outcome;

const char *lw_pair_outcome_text(lw_pair_outcome outcome);

/* Most links and joints of two freedoms together of chains with slots and gears.  A pin in a slot moves as a pin and a
 * slider with a massless block between, which is not counted as a link. */
#define LW_EXPANDED_LINK_MAX 8

/* How many mechanisms there are with one number of links. */
typedef struct lw_mechanism_tally {
    long n_chain, n_ground;            /* chains; with a ground link                                */
    long n_pair;                       /* with ground link and tracer link, each slot on either of its links */
    long n_driven;                     /* pairs with F inputs anywhere                              */
    long n_set, n_set_out;             /* F > 1, of the pairs not left out: sets of inputs at the ground; those of
                                        * these sets that are left out                              */
    long outcome[LW_PAIR_OUTCOMES];    /* of the pairs                                              */
    long n_group;                      /* fitted mechanisms with an Assur group beyond dyads        */
} lw_mechanism_tally;

/* The mechanisms with one number of links. */
typedef struct lw_mechanism_stage {
    int                 links;
    bool                two_freedoms;                    /* chains with slots or gears              */
    lw_mechanism_tally  tally;
    int                 n_family, n_pins, capacity;      /* those of pins alone come first          */
    lw_packed_mechanism *family;                         /* (n_family) owned                        */
    int                 n_list, list_capacity;
    lw_numbered_chain  *list;                            /* (n_list) owned                          */
    const struct lw_mechanism_set *all;
} lw_mechanism_stage;

/* Must stay where it is made: its stages point to it. */
typedef struct lw_mechanism_set {
    int                n, dof;
    int                uncounted;                        /* links of the stage that `until` ended: it and those after it
                                                          * are not in the set; 0: all are          */
    bool               every, timed;                     /* as requested: only is "all"; timed      */
    lw_ratio_choices   ratio;
    lw_mechanism_stage stage[LW_STAGE_MAX];
} lw_mechanism_set;

typedef struct lw_mechanism_request {
    int         links;         /* most links: 4, 6, 8, ...; with slots and gears odd numbers too; F = 2: 5, 7, 9 */
    int         dof;           /* F, 1 .. LW_PACKED_INPUT_MAX: number of inputs, all but the first tied */
    const char *kinds;         /* letters of the joints, of "rtpg"                                  */
    lw_ratio_choices ratio;
    const char *only;          /* names with commas between: "watt1,stephenson3", "watt" (both), chains by links and
                                * number "8.5", by links, joints of two freedoms and number "5.1.2"; or "all" */
    lw_task     task;
    bool        timed;         /* it matters which input has the target's angles: fit each at the ground by itself */
    int         jobs;          /* threads; < 1: one per core                                        */
    double      until;         /* lw_clock_wall [s]: the stage that is counted then is the first one left out; 0: none */
    const volatile int *interrupt;   /* stops when it becomes nonzero; NULL: nothing stops it       */
} lw_mechanism_request;

/* Is one of these kinds of joints, of "rtpg", of two freedoms? */
bool lw_kinds_have_two_freedoms(const char *kinds);

/* Fewest links of a mechanism with F inputs that are pins at the ground, F >= 1. */
int lw_mechanism_least_links(int dof);

/* Mechanisms of pins and sliders by rising number of links, with F = 1 from six, then those with slots and gears from
 * three links.  With a text: LW_E_ARG, no mechanism bears a name in `only`; LW_NOTHING, interrupted; LW_E_MEMORY. */
lw_status lw_mechanism_set_make(const lw_mechanism_request *request, lw_mechanism_set *set, lw_error *e);
void      lw_mechanism_set_free(lw_mechanism_set *set);

/* The mechanisms of a stage as families to fit: all; those of pins alone; the others.  The stage must stay. */
lw_families lw_mechanism_stage_families(const lw_mechanism_stage *s);
lw_families lw_mechanism_stage_pins(const lw_mechanism_stage *s);
lw_families lw_mechanism_stage_others(const lw_mechanism_stage *s);

/* Write the name of the mechanism in the set that the linkage is one of, by chain, ground link and tracer link (an
 * lw_search_stage.name with an lw_mechanism_set as context).  LW_NOTHING: it is none of the mechanisms requested;
 * LW_E_MEMORY, LW_E_IO as lw_graph_label. */
lw_status lw_mechanism_set_name(void *set, const lw_linkage *linkage, char *name, size_t size);

#endif

/* optimise/topology/packed_mechanism.h - one mechanism of a search in a few bytes, and its linkage and name when they
 * are needed.
 *
 * A mechanism is a chain with kinds of joints, ground link, tracer link, inputs, and ratios of gears and tied
 * inputs. */
#ifndef LW_OPTIMISE_TOPOLOGY_PACKED_MECHANISM_H
#define LW_OPTIMISE_TOPOLOGY_PACKED_MECHANISM_H

#include "enumerate/canon.h"
#include "grammar/topology/mechanism.h"
#include "optimise/search/families.h"

/* Ratios that gear pairs, or tied inputs, are tried with. */
#define LW_RATIO_MAX 24
typedef struct lw_ratio { double value; char text[12]; } lw_ratio;
typedef struct lw_ratio_list { int n; lw_ratio of[LW_RATIO_MAX]; } lw_ratio_list;

/* Read "-1,1/2,3": whole numbers and fractions of whole numbers up to LW_INPUT_TURNS_PER_PERIOD_MAX.  LW_E_ARG with
 * a text that begins with `name`. */
lw_status lw_ratio_list_read(const char *name, const char *text, lw_ratio_list *r, lw_error *e);

/* The ratios of gear pairs and of tied inputs that a packed mechanism refers to. */
typedef struct lw_ratio_choices { lw_ratio_list gear, tie; } lw_ratio_choices;

/* A chain and its index in the list of chains with its number of links. */
typedef struct lw_numbered_chain {
    lw_mechanism m;            /* nothing is chosen on it                                         */
    int          number, n2;   /* place in the list, from 1; number of joints of two freedoms     */
} lw_numbered_chain;

/* Most joints: ten links have 13. */
#define LW_PACKED_JOINT_MAX 16

/* Most inputs: a mechanism with F inputs at the ground has 3 F - 1 links or more. */
#define LW_PACKED_INPUT_MAX 3

/* The choices that make a mechanism of a chain. */
typedef struct lw_packed_mechanism {
    uint32_t kinds;            /* of the joints, two bits each, the first joint's lowest: place in "rtpg" */
    uint16_t chain;            /* number of the chain in its stage, from 0                        */
    uint8_t  ground, tracer;   /* links                                                           */
    uint8_t  n_input;
    uint8_t  input[LW_PACKED_INPUT_MAX];       /* joints; those after the first are tied to it    */
    uint8_t  tie[LW_PACKED_INPUT_MAX];         /* numbers of their ratios                         */
    uint8_t  turned;           /* bit i: slot i is on the second link of its joint                */
    uint8_t  ratio;            /* set of ratios of the gear pairs, from 1; 0: none                */
    uint8_t  turn;             /* lw_turn                                                         */
} lw_packed_mechanism;

/* Most sets of ratios that one mechanism is tried with.  g gear pairs and n ratios have n^g sets.  If there are more,
 * the sets are: all pairs with the same ratio; the second pair one place further on in the list, the third two; and
 * so on, so that every pair has every ratio equally often. */
#define LW_GEAR_SET_MAX 32

/* How many sets of ratios a linkage with gears is tried with; 1 if all gears are racks, whose pitch is a dimension;
 * 0: a gear has no link that carries both its sides, or several. */
int lw_gear_sets(const lw_linkage *linkage, const lw_ratio_list *gear);

/* Pack a mechanism with ground and output link, without inputs. */
lw_packed_mechanism lw_packed_mechanism_of(const lw_mechanism *m, int chain, unsigned turned, int ratio);

/* Unpack it, without inputs. */
lw_mechanism lw_packed_mechanism_unpack(const lw_numbered_chain *c, const lw_packed_mechanism *p);

/* A linkage of the mechanism, without a name; the same linkage each time. */
lw_status lw_packed_mechanism_sketch(const lw_numbered_chain *c, const lw_packed_mechanism *p,
                                     const lw_ratio_choices *r, lw_linkage *linkage);

/* "Watt I, point on link 5"; with `input`, or with several inputs, also these: "Watt I, input 2, point on link 5",
 * "5-link chain 1, ground 1, inputs 1+4 by -2, point on link 4". */
void lw_packed_mechanism_name(const lw_numbered_chain *c, const lw_packed_mechanism *p, const lw_ratio_choices *r,
                              bool input, char *name, size_t size);

/* The name in lw_mechanism_request.only of the chain and its ground link: "watt1", "8.5", "5.1.2". */
void lw_packed_mechanism_key(const lw_numbered_chain *c, const lw_packed_mechanism *p, char *key, size_t size);

/* The canonical form of a linkage: links as vertices with colours for ground and tracer, more vertices for slots,
 * gears and tied inputs.  Two linkages of one topology have equal forms.  LW_NOTHING: ratios that no form can hold.
 * LW_E_MEMORY, LW_E_IO as lw_graph_label. */
lw_status lw_linkage_canonical_form(const lw_linkage *linkage, lw_graph *form);

#endif

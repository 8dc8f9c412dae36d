/* optimise/topology/packed_mechanism.h - one mechanism of a search in a few bytes, and what is made of it when
 * somebody wants it: its linkage, its name. */
#ifndef LW_OPTIMISE_TOPOLOGY_PACKED_MECHANISM_H
#define LW_OPTIMISE_TOPOLOGY_PACKED_MECHANISM_H

#include "enumerate/canon.h"
#include "grammar/mechanism.h"
#include "optimise/search/families.h"

/* Ratios that gear pairs, or tied inputs, are tried with. */
#define LW_RATIO_MAX 24
typedef struct lw_ratio { double value; char text[12]; } lw_ratio;
typedef struct lw_ratio_list { int n; lw_ratio of[LW_RATIO_MAX]; } lw_ratio_list;

/* "-1,1/2,3": whole numbers and fractions of two to 24, in either way.  LW_E_ARG with a text that names the option. */
lw_status lw_ratio_list_read(const char *option, const char *text, lw_ratio_list *r, lw_error *e);

/* Those of both; a lw_packed_mechanism holds numbers in them. */
typedef struct lw_ratio_choices { lw_ratio_list gear, tie; } lw_ratio_choices;

/* A chain of the list it is enumerated in. */
typedef struct lw_numbered_chain {
    lw_mechanism m;            /* nothing chosen                                                  */
    int          number, n2;   /* in the list, from 1; joints of two freedoms of these chains     */
} lw_numbered_chain;

/* Joints that a lw_packed_mechanism can hold: ten links have 13. */
#define LW_PACKED_JOINT_MAX 16

/* Inputs that it can hold: with F of them at the ground a mechanism has 3 F - 1 links or more. */
#define LW_PACKED_INPUT_MAX 3

/* What is chosen on a chain. */
typedef struct lw_packed_mechanism {
    uint32_t kinds;            /* of the joints, two bits each, the first joint's lowest: place in "rtpg" */
    uint16_t chain;            /* index                                                           */
    uint8_t  ground, tracer;   /* links                                                           */
    uint8_t  n_input;
    uint8_t  input[LW_PACKED_INPUT_MAX];       /* joints, those after the first tied to it        */
    uint8_t  tie[LW_PACKED_INPUT_MAX];         /* ratios of these, from 0                         */
    uint8_t  turned;           /* slots on the later link, bit i: the i-th                        */
    uint8_t  ratio;            /* set of ratios of the gear pairs, from 1; 0: there are none      */
    uint8_t  turn;             /* lw_turn                                                         */
} lw_packed_mechanism;

/* Sets of ratios that one mechanism is tried with.  Of g gear pairs and n ratios there are n^g sets; where that is
 * more, the first of those that give all pairs the same ratio, then of those in which the second pair is one, the
 * third two further on in the list, and so on: every pair meets every ratio equally often. */
#define LW_GEAR_SET_MAX 32

/* How many sets of ratios a linkage with gears is tried with, 1 when all are racks, whose pitch is a dimension; 0:
 * one of its gears has no carrier, or several. */
int lw_gear_sets(const lw_linkage *k, const lw_ratio_list *gear);

/* Of a mechanism with ground and output, its inputs left open. */
lw_packed_mechanism lw_packed_mechanism_of(const lw_mechanism *m, int chain, unsigned turned, int ratio);

/* Without inputs. */
lw_mechanism lw_packed_mechanism_unpack(const lw_numbered_chain *c, const lw_packed_mechanism *f);

/* A linkage of it, without a name: the same each time. */
lw_status lw_packed_mechanism_sketch(const lw_numbered_chain *c, const lw_packed_mechanism *f, const lw_ratio_choices *r, lw_linkage *k);

/* "Watt I, point on link 5", with `input` or several inputs "Watt I, input 2, point on link 5", "5-link chain 1,
 * ground 1, inputs 1+4 by -2, point on link 4". */
void lw_packed_mechanism_name(const lw_numbered_chain *c, const lw_packed_mechanism *f, const lw_ratio_choices *r, bool input,
                       char *name, size_t size);

/* What --topology calls its ground choice: "watt1", "8.5", "5.1.2". */
void lw_packed_mechanism_key(const lw_numbered_chain *c, const lw_packed_mechanism *f, char *key, size_t size);

/* Links as vertices, coloured by ground and tracer, dies in slots too; the kinds of joints between them, and ties of
 * inputs: canonical.  false: out of memory, or ratios that no form tells apart. */
bool lw_linkage_canonical_form(const lw_linkage *k, lw_graph *form);

#endif

/* cli/fit/fit_topology.h - one mechanism of a search in a few bytes, and what is made of it when somebody wants it: its
 * linkage, its name. */
#ifndef CLI_FIT_FIT_TOPOLOGY_H
#define CLI_FIT_FIT_TOPOLOGY_H

#include "enumerate/canon.h"
#include "grammar/mechanism.h"
#include "optimise/search/families.h"

/* Ratios that gear pairs, or tied inputs, are tried with. */
#define CLI_RATIO_MAX 24
typedef struct cli_ratio { double value; char text[12]; } cli_ratio;
typedef struct cli_ratios { int n; cli_ratio of[CLI_RATIO_MAX]; } cli_ratios;

/* "-1,1/2,3": whole numbers and fractions of two to 24, in either way.  LW_E_ARG with a text that names the option. */
lw_status cli_ratios_read(const char *option, const char *text, cli_ratios *r, lw_error *e);

/* Those of both; a cli_topology holds numbers in them. */
typedef struct cli_topology_ratios { cli_ratios gear, tie; } cli_topology_ratios;

/* A chain of the list it is enumerated in. */
typedef struct cli_topology_chain {
    lw_mechanism m;            /* nothing chosen                                                  */
    int          number, n2;   /* in the list, from 1; joints of two freedoms of these chains     */
} cli_topology_chain;

/* Joints that a cli_topology can hold: ten links have 13. */
#define CLI_TOPOLOGY_JOINTS 16

/* Inputs that it can hold: with F of them at the ground a mechanism has 3 F - 1 links or more. */
#define CLI_TOPOLOGY_INPUTS 3

/* What is chosen on a chain. */
typedef struct cli_topology {
    uint32_t kinds;            /* of the joints, two bits each, the first joint's lowest: place in "rtpg" */
    uint16_t chain;            /* index                                                           */
    uint8_t  ground, tracer;   /* links                                                           */
    uint8_t  n_input;
    uint8_t  input[CLI_TOPOLOGY_INPUTS];       /* joints, those after the first tied to it        */
    uint8_t  tie[CLI_TOPOLOGY_INPUTS];         /* ratios of these, from 0                         */
    uint8_t  turned;           /* slots on the later link, bit i: the i-th                        */
    uint8_t  ratio;            /* set of ratios of the gear pairs, from 1; 0: there are none      */
    uint8_t  turn;             /* lw_turn                                                         */
} cli_topology;

/* Sets of ratios that one mechanism is tried with.  Of g gear pairs and n ratios there are n^g sets; where that is more,
 * the first of those that give all pairs the same ratio, then of those in which the second pair is one, the third two
 * further on in the list, and so on: every pair meets every ratio equally often. */
#define CLI_GEAR_SETS 32

/* How many sets of ratios a linkage with gears is tried with, 1 when all are racks, whose pitch is a dimension; 0: one of
 * its gears has no carrier, or several. */
int cli_topology_sets(const lw_linkage *k, const cli_ratios *gear);

/* Of a mechanism with ground and output, its inputs left open. */
cli_topology cli_topology_of(const lw_mechanism *m, int chain, unsigned turned, int ratio);

/* Without inputs. */
lw_mechanism cli_topology_mechanism(const cli_topology_chain *c, const cli_topology *f);

/* A linkage of it, without a name: the same each time. */
lw_status cli_topology_sketch(const cli_topology_chain *c, const cli_topology *f, const cli_topology_ratios *r, lw_linkage *k);

/* "Watt I, point on link 5", with `input` or several inputs "Watt I, input 2, point on link 5", "5-link chain 1, ground 1,
 * inputs 1+4 by -2, point on link 4". */
void cli_topology_name(const cli_topology_chain *c, const cli_topology *f, const cli_topology_ratios *r, bool input,
                       char *name, size_t size);

/* What --topology calls its ground choice: "watt1", "8.5", "5.1.2". */
void cli_topology_key(const cli_topology_chain *c, const cli_topology *f, char *key, size_t size);

/* Links as vertices, coloured by ground and tracer, dies in slots too; the kinds of joints between them, and ties of
 * inputs: canonical.  false: out of memory, or ratios that no form tells apart. */
bool cli_topology_form(const lw_linkage *k, lw_graph *form);

#endif

/* grammar/topology/mechanism.h - a mechanism: a chain with joint kinds and, if chosen, a ground link, driven joints and an
 * output link.
 *
 * A chain with joint kinds alone is the same type with ground and output LW_NONE and no inputs.  Joints are
 * numbered from 0 in the order of the link adjacency matrix read row by row (by their smaller, then their larger
 * link).  Links count from 0 here and from 1 in every text.  Plain data, copied
 * with '='. */
#ifndef LW_GRAMMAR_TOPOLOGY_MECHANISM_H
#define LW_GRAMMAR_TOPOLOGY_MECHANISM_H

#include "grammar/topology/chain.h"
#include "grammar/topology/joint_kind.h"

#define LW_NONE (-1)                    /* ground or output not chosen */

typedef struct lw_mechanism {
    int     n_link, n_joint, n_input;
    int     ground, output;             /* links, or LW_NONE                                  */
    uint8_t link[LW_JOINT_MAX][2];      /* links of a joint, the smaller first; rising order  */
    char    kind[LW_JOINT_MAX];         /* lw_joint_kind: 'r', 't', 'p', 'g'                  */
    uint8_t input[LW_INPUT_MAX];        /* driven joints of one freedom, in rising order      */
    bool    directed;                   /* sliders have a direction: one link has the guide, the other the block */
    bool    translating_cams;           /* links that never turn against each other may touch (g)               */
    uint64_t guide;                     /* directed: bit j: the guide of slider j is on link[j][1], else link[j][0] */
} lw_mechanism;

/* The links of joint j as they are printed: of a directed slider the one with the guide first. */
static inline int lw_mechanism_printed(const lw_mechanism *m, int j, int side)
{
    return m->link[j][side ^ (m->guide >> j & 1)];
}

/* n_link links, no joint, no ground, inputs or output.  LW_E_ARG when n_link is not 1 .. LW_LINK_MAX. */
lw_status lw_mechanism_clear(lw_mechanism *m, int n_link);

/* Add a joint between links i and k.  LW_E_ARG, m untouched: i == k, no such link or kind, they share
 * a joint already, there are LW_JOINT_MAX joints, or inputs are chosen (their numbers would change). */
lw_status lw_mechanism_join(lw_mechanism *m, int i, int k, char kind);

/* Number of the joint between links i and k; LW_NONE when they share none. */
int lw_mechanism_joint(const lw_mechanism *m, int i, int k);

/* The chain as a mechanism without ground, inputs and output; its joints become pins (r) and pins in slots (p).
 * LW_E_ARG when it has more than LW_JOINT_MAX joints. */
lw_status lw_mechanism_from_chain(const lw_chain *c, lw_mechanism *m);

/* The chain of a mechanism, without kinds and choices. */
void lw_mechanism_chain(const lw_mechanism *m, lw_chain *c);

/* Rename links: link i becomes link to[i]; joints keep their kinds; ground, inputs and output are renamed too. */
void lw_mechanism_relabel(const lw_mechanism *m, const uint8_t *to, lw_mechanism *out);

/* Same links, joints, kinds and choices (not: isomorphic). */
bool lw_mechanism_same(const lw_mechanism *a, const lw_mechanism *b);

#endif

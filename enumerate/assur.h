/* enumerate/assur.h - Assur groups: the pieces by which a mechanism is solved, one after the other.
 *
 * With its inputs held a mechanism of F inputs is a structure without freedom, and falls apart uniquely into
 * smallest groups of links that are determined together by links solved before (Assur 1914; Servatius, Shai &
 * Whiteley 2010).  Method of the latter: give every condition of a joint (two of r and t, one of p and g, three
 * of a driven joint) to one of its links so that each link but the ground owns three; the strong components
 * of "owns a condition to" are the groups, whatever orientation was found.
 *
 * Class and order after Artobolevsky: order is the number of joints to links outside; class I is a link
 * driven from outside, II a dyad, and otherwise the largest closed contour, where a link counts with its joints
 * inside the group and a circuit of links with its length (circuits of a shortest cycle basis).  p and g count
 * as a binary link with its two joints in their place. */
#ifndef LW_ENUMERATE_ASSUR_H
#define LW_ENUMERATE_ASSUR_H

#include "enumerate/chains.h"
#include "grammar/mechanism.h"

typedef struct lw_assur_group {
    uint32_t links;          /* solved together, as bits                                           */
    uint64_t inner, outer;   /* joints between them; to links solved before                        */
    int      n_class;        /* 1, 2, 3, ...                                                       */
    int      order;
    int      n_mode;         /* assembly modes over the complex numbers, 0 where not known: dyads with r
                                and t, and groups of r alone with up to eight links                */
} lw_assur_group;

typedef struct lw_assur {
    int            n_group;
    lw_assur_group group[LW_LINK_MAX];   /* in order of solution; among those that could come next the one
                                            with the lowest link                                   */
} lw_assur;

/* Decompose.  LW_E_ARG with a text: no ground, not F inputs, or inputs that do not drive everything. */
lw_status lw_assur_decompose(const lw_mechanism *m, lw_assur *a, lw_error *e);

/* One group as text, "class II, order 2: links 3 4, joints 1-4:r 2-3:r 3-4:r, 2 assembly modes". */
size_t lw_assur_print(const lw_mechanism *m, const lw_assur_group *g, char *buf, size_t size);

/* One group to be listed: a Baranov truss and the link that was taken away from it; what is left are the
 * links of the group, and the joints at the lost link are its outer joints. */
typedef lw_status lw_assur_visit(void *context, const lw_chain *truss, int lost, const lw_assur_group *group);

/* Every Assur group of pins with n_link links (even, 2 ..), each once: the Baranov trusses with one link more,
 * one of the links alike taken away (Baranov 1952).  Numbers: 1, 2, 10, 173, 5438.  LW_E_ARG with a
 * text for an odd number, LW_E_MEMORY. */
lw_status lw_assur_each(int n_link, int n_thread, lw_assur_visit *visit, void *context, lw_error *e);

#endif

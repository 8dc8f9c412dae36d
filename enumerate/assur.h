/* enumerate/assur.h - Assur groups: the groups of links in which a mechanism is solved, one after the other.
 *
 * With its F inputs held, a mechanism is a structure without freedom.  It decomposes uniquely into smallest groups
 * of links that links solved before determine (Assur 1914; Servatius, Shai & Whiteley 2010).  The method is that of
 * the latter: assign every condition of a joint (two for r and t, one for p and g, three for a driven joint) to one
 * of its links so that each link but the ground owns three.  The strong components of the relation "owns a condition
 * to" are the groups; they do not depend on the assignment.
 *
 * Class and order follow Artobolevsky.  The order is the number of joints to links outside.  A link driven from
 * outside has class I, a dyad class II.  Otherwise the class is the size of the largest closed contour, where a link
 * counts with its joints inside the group and a circuit of links with its length (circuits of a shortest cycle
 * basis).  A joint p or g counts as a binary link with two joints. */
#ifndef LW_ENUMERATE_ASSUR_H
#define LW_ENUMERATE_ASSUR_H

#include "enumerate/chains.h"
#include "grammar/topology/mechanism.h"

typedef struct lw_assur_group {
    uint32_t links;          /* solved together, as bits                                           */
    uint64_t inner, outer;   /* joints between them; to links solved before                        */
    int      n_class;        /* 1, 2, 3, ...                                                       */
    int      order;
    int      n_mode;         /* assembly modes over the complex numbers; 0: not known.  Known for dyads of
                                r and t, and for groups of r alone with up to eight links          */
} lw_assur_group;

typedef struct lw_assur {
    int            n_group;
    lw_assur_group group[LW_LINK_MAX];   /* in order of solution; if several could come next, the one with
                                            the lowest link                                        */
} lw_assur;

/* Decompose.  LW_E_ARG with a text: no ground, not F inputs, or inputs that do not determine every motion. */
lw_status lw_assur_decompose(const lw_mechanism *m, lw_assur *a, lw_error *e);

/* One group as text, "class II, order 2: links 3 4, joints 1-4:r 2-3:r 3-4:r, 2 assembly modes". */
size_t lw_assur_print(const lw_mechanism *m, const lw_assur_group *g, char *buf, size_t size);

/* Receives one group: a Baranov truss and the link that was removed from it.  The remaining links are the links of
 * the group, and the joints at the lost link are its outer joints. */
typedef lw_status lw_assur_visit(void *context, const lw_chain *truss, int lost, const lw_assur_group *group);

/* Visit every Assur group of pins with n_link links (even, 2 ..) once: from each Baranov truss with n_link + 1
 * links, one link of each class of equivalent links is removed (Baranov 1952).  Numbers: 1, 2, 10, 173, 5438.
 * LW_E_ARG with a text for an odd number, LW_E_MEMORY. */
lw_status lw_assur_each(int n_link, int n_thread, lw_assur_visit *visit, void *context, lw_error *e);

/* The number of groups that lw_assur_each visits, without a listing: the ground links of the trusses up to symmetry. */
lw_status lw_assur_count(int n_link, int n_thread, uint64_t *n, lw_error *e);

#endif

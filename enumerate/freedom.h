/* enumerate/freedom.h - how freely a mechanism moves at general dimensions, from its topology alone.
 *
 * At general dimensions every joint gives linear conditions on the velocities of its two links: a pin r
 * two that involve places, a slider t one that involves places and one on the turning speeds alone
 * (they are equal), p and g one that involves places.  A set of conditions is independent exactly when it splits
 * into three forests over the links, those on turning speeds all in the first (2 x translation, 1 x
 * turning; the planar case of Lee-St.John & Sidman 2013, which for pins alone is the count F =
 * 3 (P - 1) - 2 n1 - n2 with no overfull subchain of Tay and Lee & Streinu).  That slider directions
 * and pins are general enough for the theorem is checked in the tests by the rank of the matrix at random
 * dimensions, for every labelling of small chains.
 *
 * The splitting is found by augmenting paths (matroid union, Edmonds 1965). */
#ifndef LW_ENUMERATE_FREEDOM_H
#define LW_ENUMERATE_FREEDOM_H

#include "grammar/mechanism.h"

/* Kinematically void: the count F is not how the mechanism moves. */
typedef enum lw_void {
    LW_VOID_NOT,             /* F counts rightly and every freedom of every joint is used            */
    LW_VOID_SLIDER_LOOP,     /* a loop of sliders only: its links cannot turn, so it moves more
                                easily than F counts                                                 */
    LW_VOID_NO_TURN,         /* a pin, slot or gear between links that only sliders connect: they
                                never turn against each other                                        */
    LW_VOID_DEPENDENT,       /* sliders keep several links parallel, so that F counts wrongly        */
    LW_VOID_LOCKED           /* F counts rightly, but a freedom of a joint is never used             */
} lw_void;

/* Whether and why m is void.  *joints (may be NULL): the joints concerned, as bits; for LW_VOID_DEPENDENT
 * the first joint whose conditions depend on those before it. */
lw_void lw_mechanism_void(const lw_mechanism *m, uint64_t *joints);

/* One sentence that names the reason and the joints by their links, counted from 1. */
size_t lw_void_print(const lw_mechanism *m, lw_void reason, uint64_t joints, char *buf, size_t size);

/* Do the driven joints given as bits determine every motion: with their freedoms held, is the mechanism
 * at general dimensions still free of dependent conditions?  True for no more than F joints. */
bool lw_mechanism_drives(const lw_mechanism *m, uint64_t joints);

/* The joints that drive alone, as bits: those j for which lw_mechanism_drives(m, 1 << j), at the price of one. */
uint64_t lw_mechanism_drivers(const lw_mechanism *m);

#endif

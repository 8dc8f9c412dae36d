/* enumerate/freedom.h - the freedom of a mechanism at general dimensions, from its topology alone.
 *
 * At general dimensions every joint gives linear conditions on the velocities of its two links.  A pin r gives two
 * that involve places; a slider t gives one that involves places and one on the turning speeds alone (they are
 * equal); p and g give one that involves places.  A set of conditions is independent exactly when it splits into
 * three forests over the links, with all conditions on turning speeds in the first (2 x translation, 1 x turning; the
 * planar case of Lee-St.John & Sidman 2013; for pins alone this is the count F = 3 (P - 1) - 2 n1 - n2 with no
 * overfull subchain of Tay and Lee & Streinu).  Tests check that slider directions and pins are general enough for
 * the theorem: they compare with the rank of the matrix at random dimensions, for every labelling of small chains.
 *
 * The splitting is found by augmenting paths (matroid union, Edmonds 1965). */
#ifndef LW_ENUMERATE_FREEDOM_H
#define LW_ENUMERATE_FREEDOM_H

#include "grammar/topology/mechanism.h"

/* Kinematically void: the count F is not the true freedom of the mechanism, or a joint never moves. */
typedef enum lw_void {
    LW_VOID_NOT,             /* F is right and every freedom of every joint is used                  */
    LW_VOID_SLIDER_LOOP,     /* a loop of sliders only: its links cannot turn, so it moves more
                                easily than F counts                                                 */
    LW_VOID_NO_TURN,         /* a pin, slot or gear between links that only sliders connect: they
                                never turn against each other                                        */
    LW_VOID_DEPENDENT,       /* sliders keep several links parallel, so that F is wrong              */
    LW_VOID_LOCKED           /* F is right, but a freedom of a joint is never used                   */
} lw_void;

/* The reason why m is void, or LW_VOID_NOT.  *joints (may be NULL) gets the joints concerned, as bits; for
 * LW_VOID_DEPENDENT the first joint whose conditions depend on those before it. */
lw_void lw_mechanism_void(const lw_mechanism *m, uint64_t *joints);

/* One sentence that names the reason and the joints by their links, counted from 1. */
size_t lw_void_print(const lw_mechanism *m, lw_void reason, uint64_t joints, char *buf, size_t size);

/* True if the conditions that hold the given driven joints (as bits) are independent of all others at general
 * dimensions.  F such joints determine every motion; more than F never pass. */
bool lw_mechanism_drives(const lw_mechanism *m, uint64_t joints);

/* The joints that can drive alone, as bits: those j with lw_mechanism_drives(m, 1 << j), at the cost of one call. */
uint64_t lw_mechanism_drivers(const lw_mechanism *m);

#endif

/* enumerate/grow.h - the ears that are added to a structure.
 *
 * A structure with 8 loops can be grown from its parents in about twenty ways, one for each removable line.  A child
 * is kept only if its new line is a best one of its removable lines.  The measure does not depend on the numbering:
 * first the smaller and then the larger degree of the two circles of the line, then a colour of its surroundings
 * (McKay 1998, canonical construction path, with a measure that may tie).  No structure is lost, because every
 * structure has a best line.  Nearly every other child is refused before it is built. */
#ifndef LW_ENUMERATE_GROW_H
#define LW_ENUMERATE_GROW_H

#include "grammar/topology/structure.h"

/* A child with the ear that made it.  A status other than LW_OK ends the growth. */
typedef lw_status lw_grow_visit(void *context, lw_ear ear, const lw_structure *child);

/* Visit the children of a structure, in the order of rule, a, b.  Some may be isomorphic. */
lw_status lw_grow(const lw_structure *parent, lw_grow_visit *visit, void *context);

/* The same, but a child is visited only if an automorphism maps its new line to the one best line of the child, ties decided
 * by canonical form.  So children of different parents are never isomorphic, and of those of one parent `visit` gets
 * the first of each kind: every structure is visited once, and none is stored but the children of one parent. */
lw_status lw_grow_once(const lw_structure *parent, lw_grow_visit *visit, void *context);

#endif

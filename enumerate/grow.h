/* enumerate/grow.h - the ears worth adding to a structure.
 *
 * A structure with 8 loops can be grown from its parents in about twenty ways, one for each line that
 * may be taken away.  Only one kind of way is kept: the new line must be the best of the lines that
 * could be taken away again, by a measure that does not depend on the numbering: first the smaller and then the
 * larger degree of its two circles, then a colour of its surroundings (McKay 1998, canonical construction
 * path, with a measure that may tie).  Nothing is lost, because every structure has a best line; and
 * nearly every way that is not kept is refused before the child is built. */
#ifndef LW_ENUMERATE_GROW_H
#define LW_ENUMERATE_GROW_H

#include "grammar/structure.h"

/* A child with the ear that made it.  Anything but LW_OK ends the growth. */
typedef lw_status lw_grow_visit(void *context, lw_ear ear, const lw_structure *child);

/* Visit the children of a structure, in the order of rule, a, b.  Some may be isomorphic. */
lw_status lw_grow(const lw_structure *parent, lw_grow_visit *visit, void *context);

#endif

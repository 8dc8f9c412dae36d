/* enumerate/higher.h - chains with joints of two freedoms (pins in slots, gears, cams).
 *
 * A joint of two freedoms moves like two joints of one freedom with a binary link between them, and blocks as much.
 * So the chains with P links and n2 such joints are the chains of P + n2 links with joints of one freedom, in which
 * n2 binary links are marked and shrink to a joint.  Marked links are not adjacent, and two links get at most one
 * joint.  Subchains keep their mobility, so nothing becomes rigid.  Two results are isomorphic exactly when a
 * symmetry maps one set of marks to the other, so no canonical form is needed.  Circles are never marked, so only
 * structures with at most P circles are grown. */
#ifndef LW_ENUMERATE_HIGHER_H
#define LW_ENUMERATE_HIGHER_H

#include "enumerate/chains.h"

typedef lw_status lw_higher_visit(void *context, const lw_chain *c);

/* Every chain with n_link links, F = dof and n2 >= 0 joints of two freedoms once, not fractionated.  Order: that
 * of chains.h for the chains of n_link + n2 links, then marks by their lowest link that differs.  Links keep
 * their order.  LW_E_ARG with the equation when the numbers do not go together; LW_E_MEMORY. */
lw_status lw_higher_each(int n_link, int dof, int n2, int n_thread, lw_higher_visit *visit, void *context, lw_error *e);

/* The same; go_on is called from time to time, also where nothing is found.  If it returns false: LW_STOPPED. */
lw_status lw_higher_each_while(int n_link, int dof, int n2, int n_thread, bool (*go_on)(void *context),
                               lw_higher_visit *visit, void *context, lw_error *e);

#endif

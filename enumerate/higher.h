/* enumerate/higher.h - chains with joints of two freedoms (pins in slots, gears, cams).
 *
 * A joint of two freedoms moves as two joints of one freedom with a binary link between, and blocks as much.  So
 * the chains with P links and n2 such joints are the chains of P + n2 links and joints of one freedom alone,
 * n2 of whose binary links are marked and shrink to a joint.  Marked links do not touch each other, and two links
 * get one joint at most.  Subchains keep their mobility, so nothing gets rigid; two results are isomorphic
 * exactly when a symmetry carries the one set of marks into the other, so no canonical form is
 * needed. */
#ifndef LW_ENUMERATE_HIGHER_H
#define LW_ENUMERATE_HIGHER_H

#include "enumerate/chains.h"

typedef lw_status lw_higher_visit(void *context, const lw_chain *c);

/* Every chain with n_link links, F = dof and n2 >= 0 joints of two freedoms once, not fractionated.  Order: that
 * of chains.h for the chains of n_link + n2 links, then marks by their lowest link that differs.  Links keep
 * their order.  LW_E_ARG with the equation when the numbers do not go together; LW_E_MEMORY. */
lw_status lw_higher_each(int n_link, int dof, int n2, int n_thread, lw_higher_visit *visit, void *context,
                         lw_error *e);

#endif

/* enumerate/inputs.h - ground, driven joints and output link, up to symmetry: the steps from a chain to a
 * mechanism.
 *
 * Every step takes a mechanism in which something is not yet chosen and visits all its choices, one of each set
 * that the symmetries of the mechanism so far map to each other.  Steps commute with symmetry, so the number of
 * finished mechanisms does not depend on the order of the steps. */
#ifndef LW_ENUMERATE_INPUTS_H
#define LW_ENUMERATE_INPUTS_H

#include "enumerate/kinds.h"

/* Every link as ground, in the order of links.  LW_E_ARG when m has a ground; LW_E_MEMORY. */
lw_status lw_grounds_each(const lw_mechanism *m, lw_mechanism_visit *visit, void *context);

/* Every set of n driven joints of one freedom, at the ground link or anywhere, that drives: holding their freedoms
 * overconstrains nothing (freedom.h), so n = F of them determine every motion.  In rising order of joint numbers.
 * LW_E_ARG when inputs are chosen already, n is not 1 .. LW_INPUT_MAX, or at_ground is set and there is no ground;
 * LW_E_MEMORY. */
lw_status lw_inputs_each(const lw_mechanism *m, int n, bool at_ground, lw_mechanism_visit *visit, void *context);

/* Every output link: not the ground, and not a link that a driven joint connects to the ground, whose motion is
 * the input itself.  LW_E_ARG when there is no ground or an output already; LW_E_MEMORY. */
lw_status lw_outputs_each(const lw_mechanism *m, lw_mechanism_visit *visit, void *context);

#endif

/* enumerate/kinds.h - choices of joint kinds up to symmetry, without void labellings.
 *
 * A joint of one freedom is r or t, one of two freedoms p or g.  A labelling counts if, at general
 * dimensions, F is the true freedom and every freedom of every joint is used; freedom.h decides this from the
 * topology.  So a four-bar may have no, one, or two sliders (1 + 1 + 2 ways), but not three: its pin would never
 * turn.  Three links in a loop of three sliders do move, but F counts 0 for them, so they are not among the chains. */
#ifndef LW_ENUMERATE_KINDS_H
#define LW_ENUMERATE_KINDS_H

#include "enumerate/freedom.h"

/* A status other than LW_OK ends a walk and is returned by it. */
typedef lw_status lw_mechanism_visit(void *context, const lw_mechanism *m);

/* A labelling that is left out, with the reason and the joints concerned. */
typedef lw_status lw_void_visit(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints);

/* Visit every labelling of m once up to the symmetries of m, which keep freedoms, ground, inputs and output; the
 * present kinds of m do not matter.  If m is directed, each slider has its guide on one of its two links, chosen
 * too; if m has translating cams, a contact g need not turn.  kinds: the letters allowed, of "rtpg"; at least one for each number of freedoms
 * that joints of m have.  Order: lexicographic in the kinds of joints 0, 1, 2, ..., by their
 * order in `kinds`.  left_out may be NULL.  LW_E_ARG, LW_E_MEMORY. */
lw_status lw_kinds_each(const lw_mechanism *m, const char *kinds, lw_mechanism_visit *visit, lw_void_visit *left_out, void *context);

#endif

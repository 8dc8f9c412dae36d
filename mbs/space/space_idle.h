/* mbs/space/space_idle.h - links of a spatial model that spin without moving anything else. */
#ifndef LW_MBS_SPACE_SPACE_IDLE_H
#define LW_MBS_SPACE_SPACE_IDLE_H

#include "mbs/space/space.h"

/* Bodies between ball joints on one line spin about it without moving anything else: rows that hold these spins, into
 * out (n_body), and how many.  slender: so do bodies without inertia about their axis that fly or hang on balls on this axis.  A body whose tracers,
 * loads or springs lie off the line does not idle. */
int lw_space_idle(const lw_space *s, bool slender, lw_space_extra *out);

#endif

/* optimise/task/target_tour.h - points of a path in no order, and the order of a short tour through them.
 *
 * Points jump to and fro if the polygon through them is more than twice as long as a short tour, which nearest neighbours begin and which reversing
 * (Croes 1958) and moving (Or 1976) of parts make shorter.  Of more than 10000 points the order is not looked at. */
#ifndef LW_OPTIMISE_TASK_TARGET_TOUR_H
#define LW_OPTIMISE_TASK_TARGET_TOUR_H

#include "optimise/task/target.h"

/* If the points of a path without input angles jump to and fro, say so in the note, and decide by the tour whether the path is closed, unless
 * `closed` (as in lw_target_options) says it.  LW_OK or LW_E_MEMORY. */
lw_status lw_target_look_at_order(lw_target *t, int closed, lw_error *e);

/* If they jump to and fro, put the stations in the order of the tour, closed if the target is, and say so in the note.  LW_OK or LW_E_MEMORY. */
lw_status lw_target_put_in_order(lw_target *t, lw_error *e);

#endif

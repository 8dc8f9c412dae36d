/* mbs/constraints/adjust.h - overconstrained linkages that move, drawn with rounded numbers.
 *
 * Three parallel bars, Burmester's focal linkage: such linkages move for special dimensions only.  Written with a few
 * digits they are rigid, by a hair.  The least change of the dimensions, in the sense of least squares, makes them move:
 * places of joints on their links and directions of slides, so that all rows can be satisfied in several postures along
 * the motion at once. */
#ifndef LW_MBS_CONSTRAINTS_ADJUST_H
#define LW_MBS_CONSTRAINTS_ADJUST_H

#include "mbs/constraints/system.h"

#define LW_ADJUST_MOST 2e-3              /* greatest change, scaled: more is another linkage */

/* Adjust the dimensions of s, a system of a linkage, at the posture q (n_q), which is put on the rows.  *by: greatest
 * change of a dimension, scaled or [rad].  LW_NOTHING: there is nothing to adjust, s and q are unchanged: no row nearly
 * depends on others, or no motion is as near as LW_ADJUST_MOST. */
lw_status lw_system_adjust(lw_system *s, double *q, double *by, lw_error *e);

#endif

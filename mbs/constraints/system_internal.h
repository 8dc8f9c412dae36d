/* mbs/constraints/system_internal.h - the rows of a system for a matrix of any layout; internal to mbs/. */
#ifndef LW_MBS_CONSTRAINTS_SYSTEM_INTERNAL_H
#define LW_MBS_CONSTRAINTS_SYSTEM_INTERNAL_H

#include "mbs/constraints/system.h"

/* Positions of the bodies at one q: body b has index b + 1, the ground index 0. */
typedef struct lw_system_frames {
    lw_vec2 at[LW_LINK_MAX], dir[LW_LINK_MAX];
    double  turn[LW_LINK_MAX];
} lw_system_frames;

void lw_system_place(const lw_system *s, const double *q, lw_system_frames *f);

/* Add the derivative of row r by coordinate i to jac[r*row_step + i*column_step].  Only entries that are not 0 for
 * every q are touched, so zero jac first.  jac and phi may be NULL. */
void lw_system_fill(const lw_system *s, const lw_system_frames *f, double *phi, double *jac, long row_step,
                    long column_step);

/* lw_system_measure for given frames; derivatives are added to row[i*step]. */
double lw_system_count(const lw_system *s, const lw_system_frames *f, int j, double *row, long step);

/* What whole turns of the bodies add to rows (n_row) and input values (n_input), in turns. */
void lw_system_turns(const lw_system *s, const int *turns, double *rows, double *inputs);

#endif

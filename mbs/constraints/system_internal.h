/* mbs/constraints/system_internal.h - the rows of a system for a matrix of any layout; internal to mbs/. */
#ifndef LW_MBS_CONSTRAINTS_SYSTEM_INTERNAL_H
#define LW_MBS_CONSTRAINTS_SYSTEM_INTERNAL_H

#include "mbs/constraints/system.h"

/* Where the bodies are at one q: body b at index b + 1, the ground at 0. */
typedef struct lw_system_frames {
    lw_vec2 at[LW_LINK_MAX], dir[LW_LINK_MAX];
    double  turn[LW_LINK_MAX];
} lw_system_frames;

void lw_system_place(const lw_system *s, const double *q, lw_system_frames *f);

/* Derivative of row r by coordinate i goes to jac[r*row_step + i*column_step]; jac, of which only entries that
 * are not 0 for every q are written (by adding: zero it first), may be NULL, and so may phi. */
void lw_system_fill(const lw_system *s, const lw_system_frames *f, double *phi, double *jac, long row_step,
                    long column_step);

/* lw_system_measure for frames; row[i*step] gets its derivatives added. */
double lw_system_count(const lw_system *s, const lw_system_frames *f, int j, double *row, long step);

/* What whole turns of the bodies add to rows (n_row) and input counts (n_input), in turns. */
void lw_system_turns(const lw_system *s, const int *turns, double *rows, double *inputs);

#endif

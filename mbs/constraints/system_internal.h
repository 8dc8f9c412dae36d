/* mbs/constraints/system_internal.h - the rows of a system for a matrix of any layout; internal to mbs/. */
#ifndef LW_MBS_CONSTRAINTS_SYSTEM_INTERNAL_H
#define LW_MBS_CONSTRAINTS_SYSTEM_INTERNAL_H

#include "mbs/constraints/system.h"

/* Position of a body at one q.  Arrays of frames have the ground at 0 and body b at b + 1. */
typedef struct lw_body_frame { lw_vec2 at, dir; double turn; } lw_body_frame;

void lw_system_place(const lw_system *s, const double *q, lw_body_frame *f);

/* Add the derivative of row r by coordinate i to jac[r*row_step + i*column_step].  Only entries that are not 0 for
 * every q are touched, so zero jac first.  jac and phi may be NULL. */
void lw_system_fill(const lw_system *s, const lw_body_frame *f, double *phi, double *jac, long row_step, long column_step);

/* The same in blocks: the derivatives of row r by the three coordinates of body[r][k] at jac[r*LW_SYSTEM_ROW_SIZE + 3*k];
 * body (n_row) is that of lw_system_row_bodies. */
#define LW_SYSTEM_ROW_SIZE (3*LW_SYSTEM_ROW_BODIES)
typedef int lw_row_bodies[LW_SYSTEM_ROW_BODIES];
void lw_system_fill_blocks(const lw_system *s, const lw_body_frame *f, double *phi, double *jac, lw_row_bodies *body);

/* lw_system_measure for given frames; derivatives are added to row[i*step]. */
double lw_system_count(const lw_system *s, const lw_body_frame *f, int j, double *row, long step);

/* The same, derivatives by coordinate i of body[k] at row[3*k + i]. */
double lw_system_count_block(const lw_system *s, const lw_body_frame *f, int j, double *row, const int *body);

/* The amounts that whole turns of the bodies add to rows (n_row) and input values (n_input), in turns. */
void lw_system_turns(const lw_system *s, const int *turns, double *rows, double *inputs);

#endif

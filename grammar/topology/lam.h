/* grammar/topology/lam.h - the link adjacency matrix (Makkonen 1999, paper F section 7): entry (i, j), i < j,
 * is the number 1..J of the joint between links i and j, 0 for none.
 *
 *     0 1 0 2
 *     0 0 3 0          the four-bar with its joints numbered row by row
 *     0 0 0 4
 *     0 0 0 0
 *
 * The source writes no joint kinds; here a letter may follow a number, "4p", and none means r.  A matrix of 0 and 1
 * without letters is a plain adjacency matrix: its joints are numbered row by row. */
#ifndef LW_GRAMMAR_TOPOLOGY_LAM_H
#define LW_GRAMMAR_TOPOLOGY_LAM_H

#include <stddef.h>
#include "grammar/topology/mechanism.h"

typedef struct lw_lam {
    int     n_link, n_joint;
    uint8_t number[LW_LINK_MAX][LW_LINK_MAX];   /* upper triangle; 1 .. n_joint, each once, or 0 */
    char    kind[LW_JOINT_MAX];                 /* of joint number k + 1                         */
} lw_lam;

/* Room for the largest matrix as text. */
#define LW_LAM_SIZE (LW_LINK_MAX*LW_LINK_MAX*5)

/* Joints of a mechanism numbered row by row: joint k of m is number k + 1. */
void lw_lam_from_mechanism(const lw_mechanism *m, lw_lam *a);

/* The mechanism without ground, inputs and output.  number_of (LW_JOINT_MAX, may be NULL) gets the number in
 * the matrix of each of its joints. */
void lw_lam_mechanism(const lw_lam *a, lw_mechanism *m, uint8_t *number_of);

/* Rows as lines, each ended by a newline; returns the length as snprintf does. */
size_t lw_lam_print(const lw_lam *a, char *buf, size_t size);

/* Read a square matrix: blanks or commas separate numbers, line ends or ';' separate rows, '#' begins a comment.
 * Below the diagonal is 0 or the mirror image.  LW_E_NOTATION with line and column: rows of unequal
 * length, a link joined to itself, a number given twice, missing or above the number of joints,
 * unknown joint letters. */
lw_status lw_lam_read(const char *text, size_t size, const char *file, lw_lam *a, lw_error *e);

#endif

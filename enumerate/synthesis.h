/* enumerate/synthesis.h - number synthesis: how many links, joints and loops, and which links.
 *
 *     F  = 3 (P - 1) - 2 n1 - n2        Makkonen 1999, eq. 2
 *     L  = n1 + n2 - P + 1              eq. 10
 *     2j = sum of i P_i                 eq. 8, handshake
 *
 * so that P = F + 2 L + 1 - n2 and n1 = F + 3 L - 2 n2: F, L and n2 determine the rest.  A chain with
 * L loops that is not fractionated has no link with more than L + 1 joints (a cut link may have 2 L). */
#ifndef LW_ENUMERATE_SYNTHESIS_H
#define LW_ENUMERATE_SYNTHESIS_H

#include <stdbool.h>
#include "base/error.h"
#include "grammar/topology/structure.h"

#define LW_DOF_MAX 10

typedef struct lw_numbers {
    int  dof, n_loop;       /* F, L                                                              */
    int  n1, n2;            /* joints of one and of two freedoms                                  */
    int  n_link;            /* P                                                                  */
    bool simple;            /* the joints fit with at most one between any two links              */
} lw_numbers;

/* The numbers for F, L and n2.  LW_E_ARG when F is not 0 .. LW_DOF_MAX, L < 1 or n2 < 0, and when there is
 * no solution with P >= 2 and n1 >= 0, or one with more than LW_LINK_MAX links. */
lw_status lw_numbers_of(int dof, int n_loop, int n2, lw_numbers *numbers, lw_error *e);

/* The same from P, F and n2.  The error for an impossible P shows the equation. */
lw_status lw_numbers_for_links(int n_link, int dof, int n2, lw_numbers *numbers, lw_error *e);

/* How many links have i joints: n_with[2] binary, n_with[3] ternary, ... up to n_with[L + 1].  For chains that
 * are not fractionated. */
typedef struct lw_assortment { int n_with[LW_LOOP_MAX + 2]; } lw_assortment;

/* Assortments one after the other, those with the largest links first (by P_{L+1}, then P_L, ...).  False when there
 * is none, or no further one. */
bool lw_assortment_first(const lw_numbers *numbers, lw_assortment *a);
bool lw_assortment_next(const lw_numbers *numbers, lw_assortment *a);

#endif

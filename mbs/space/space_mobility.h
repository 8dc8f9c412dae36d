/* mbs/space/space_mobility.h - degrees of freedom of a spatial model: counted, of first order, and real. */
#ifndef LW_MBS_SPACE_SPACE_MOBILITY_H
#define LW_MBS_SPACE_SPACE_MOBILITY_H

#include "mbs/space/space_solve.h"

/* A row that follows from rows before it. */
typedef struct lw_space_redundant { int joint; const char *row; } lw_space_redundant;     /* joint: as in lw_space_row_name */

typedef struct lw_space_mobility {
    int    count;                /* 6 bodies less rows                                                     */
    int    n_body, n_row, rank;  /* rank along the motion                                                  */
    int    instant;              /* freedoms of first order in the posture                                 */
    int    freedom;              /* of the motion; 0: nothing moves                                        */
    bool   shaky;                /* moves of first order, but cannot move                                  */
    int    idle;                 /* spins of links between ball joints                                     */
    double moved, residual;      /* distance moved in sizes and radians; how well the joints closed there [m] */
    int    n_redundant;
    lw_space_redundant *redundant;
    int   *idle_link;            /* (idle)                                                                 */
} lw_space_mobility;

/* tolerance: rows that fit to within it (in sizes and radians) are taken as closed; rounded files need more than 1e-12.
 * stop: LW_STOPPED when it is not 0; may be NULL.  The result needs lw_space_mobility_free. */
lw_status lw_space_mobility_find(const lw_spatial *m, double tolerance, uint64_t seed, const volatile sig_atomic_t *stop,
                                 lw_space_mobility *out, lw_error *e);
void      lw_space_mobility_free(lw_space_mobility *m);

#endif

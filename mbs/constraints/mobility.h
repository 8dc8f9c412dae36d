/* mbs/constraints/mobility.h - the true mobility of a linkage, found by moving it numerically.
 *
 * A count of links and joints ignores lengths.  A parallelogram with a third bar and the linkages of Kempe, Dixon and
 * Burmester move although the count denies it; two bars in line yield a little although nothing can move.  The rank
 * of the constraints in the drawn posture cannot distinguish these cases.  So this module pushes the linkage along
 * motions of first order and closes it again by least-norm steps.  If it closes away from the posture again and
 * again, it moves.  If it returns to the posture every time, it is shaky.  Ranks are then computed at the postures
 * reached in this way, which are not special any more unless all postures are.
 *
 * Limits: motions that leave the posture only in directions that none of the random pushes comes near, and motions
 * shorter than 1/1000 of the size, are not found.  Links shorter than about 1e-5 of the size count as points. */
#ifndef LW_MBS_CONSTRAINTS_MOBILITY_H
#define LW_MBS_CONSTRAINTS_MOBILITY_H

#include <stdbool.h>
#include <stdint.h>
#include "mbs/constraints/system.h"

typedef enum lw_mobility_kind {
    LW_MOBILITY_RIGID,        /* no motion, not even of first order                                  */
    LW_MOBILITY_SHAKY,        /* motions of first order only: it yields but cannot move away         */
    LW_MOBILITY_MOVES
} lw_mobility_kind;

typedef struct lw_mobility_options {
    double   tolerance;       /* largest residual of a closed posture, relative to the size; 0 .. 1e-4 */
    uint64_t seed;            /* of the random directions                                            */
} lw_mobility_options;

/* One redundant constraint: its row, and the joints (as bits) whose rows imply it. */
typedef struct lw_redundant { lw_system_row row; uint64_t joints; } lw_redundant;

typedef struct lw_mobility {
    lw_mobility_kind kind;
    int    n_body, n_q, n_row;    /* of the system of the linkage, and its unit [m]                   */
    double unit;
    int    count;             /* coordinates minus rows, welds included: Gruebler's count            */
    int    freedom;           /* dimension of the motion through the posture                         */
    int    least_freedom;     /* smaller if branches of different dimension meet in the posture      */
    int    generic;           /* freedom of the same topology with other dimensions; -1: unknown      */
    int    instant;           /* first-order freedoms in the posture                                 */
    int    along;             /* the same along the motion; > freedom: shaky everywhere              */
    int    rank, posture_rank;   /* rank of the rows along the motion and in the posture             */
    int    order;             /* if shaky with instant 1: it closes up to this order; else 0         */
    double distance;          /* distance moved: root of the sum of squares of sizes and radians     */
    double residual;          /* largest residual along it [m]                                       */
    double misfit;            /* rigid or shaky: how far joints must open to move by 1/20 [m];
                               * NaN if nothing comes near to a motion                               */
    int    n_redundant;
    lw_redundant redundant[LW_SYSTEM_ROW_MAX];
    int      driven;          /* freedoms that the inputs determine                                  */
    int      idle;            /* freedoms that affect neither inputs nor tracers; without tracers:
                               * those of links that can move alone                                  */
    uint32_t idle_links;      /* links that move in them, as bits                                    */
    uint32_t loose_links;     /* links that move while the inputs rest, and are not idle             */
    uint32_t still_links;     /* links that never move, without the ground                           */
    uint64_t still_joints;    /* joints in which nothing moves, without welds                        */
} lw_mobility;

lw_mobility_options lw_mobility_options_default(void);     /* 1e-12, seed 1 */

/* LW_E_ARG: tolerance out of range; LW_E_MEMORY; fails as lw_system_make. */
lw_status lw_mobility_find(const lw_linkage *linkage, const lw_mobility_options *o, lw_mobility *m, lw_error *e);

/* Weld joints (returned in *joints as bits) until no freedom is idle, such as a roller that spins.  Inputs and tracers
 * move as before.  An idle freedom that no single pin or slider can remove stays.  Fails as lw_mobility_find. */
lw_status lw_mobility_hold_idle(lw_linkage *linkage, uint64_t *joints, lw_error *e);

const char *lw_mobility_kind_text(lw_mobility_kind kind);  /* "rigid", "shaky", "moves" */

#endif

/* mbs/constraints/mobility.h - how freely a linkage moves, found by moving it.
 *
 * A count of freedoms knows nothing of lengths: a parallelogram with a third bar, Kempe's, Dixon's and
 * Burmester's linkages move although the count says no, and two bars in line yield although nothing
 * moves.  The rank of the constraints in the drawn posture cannot tell these apart either.  So the
 * linkage is pushed along motions of first order and brought back to closure by least-norm steps:
 * where it closes to the tolerance away from the posture again and again it moves; where it falls back
 * every time it only shakes.  Ranks are then taken at postures reached that way, which no longer are
 * special, unless all are.
 *
 * Not found: motions that leave the posture only in directions which none of the random pushes comes
 * near, and motions shorter than 1/1000 of the size.  Links below about 1e-5 of the size count as points. */
#ifndef LW_MBS_CONSTRAINTS_MOBILITY_H
#define LW_MBS_CONSTRAINTS_MOBILITY_H

#include <stdbool.h>
#include <stdint.h>
#include "mbs/constraints/system.h"

typedef enum lw_mobility_kind {
    LW_MOBILITY_RIGID,        /* no motion, not even of first order                                  */
    LW_MOBILITY_SHAKY,        /* motions of first order only: it yields, and goes nowhere            */
    LW_MOBILITY_MOVES
} lw_mobility_kind;

typedef struct lw_mobility_options {
    double   tolerance;       /* closed: largest row, in multiples of the size; 0 .. 1e-4            */
    uint64_t seed;            /* of the directions                                                   */
} lw_mobility_options;

/* One redundant constraint: row of lw_system, and joints whose rows it follows from, as bits. */
typedef struct lw_redundant { int row; uint64_t joints; } lw_redundant;

typedef struct lw_mobility {
    lw_mobility_kind kind;
    lw_system system;
    int    count;             /* freedoms less rows, welds counted: Gruebler's number                */
    int    freedom;           /* dimension of the motion that holds the posture                      */
    int    least_freedom;     /* less where branches of different dimension meet in the posture      */
    int    generic;           /* that of the same links and joints with other dimensions; -1: unknown */
    int    instant;           /* freedoms of first order in the posture                              */
    int    along;             /* the same at postures along the motion; > freedom: shaky everywhere  */
    int    rank, posture_rank;   /* of the rows, along the motion and in the posture                 */
    int    order;             /* shaky with instant 1: closes up to this order; else 0               */
    double distance;          /* way that was moved: sizes and radians, root of the sum of squares   */
    double residual;          /* largest row on that way [m]                                         */
    double misfit;            /* rigid or shaky: by how much joints must open to move on by 1/20 [m];
                               * NaN where nothing comes near to a motion                            */
    int    n_redundant;
    lw_redundant redundant[LW_SYSTEM_ROW_MAX];
    int      driven;          /* freedoms that the inputs set                                        */
    int      idle;            /* freedoms that neither inputs nor tracers notice; without tracers those
                               * of links that can move alone                                        */
    uint32_t idle_links;      /* the links that move in them, as bits                                */
    uint32_t loose_links;     /* those that move while the inputs stand still and are not idle       */
    uint32_t still_links;     /* those that stand still with the ground, itself left out             */
    uint64_t still_joints;    /* joints in which nothing moves, welds left out                       */
} lw_mobility;

lw_mobility_options lw_mobility_options_default(void);     /* 1e-12, seed 1 */

/* LW_E_ARG: tolerance out of range; failures of lw_system_make; LW_E_MEMORY. */
lw_status lw_mobility_find(const lw_linkage *k, const lw_mobility_options *o, lw_mobility *m,
                           lw_error *e);

/* Weld joints of k, *joints as bits, until no freedom is idle: a roller that spins, a lever nobody looks at. What
 * inputs and tracers notice moves as before.  Idle freedoms that no single pin or slider takes away stay.  Failures
 * of lw_mobility_find. */
lw_status lw_mobility_hold_idle(lw_linkage *k, uint64_t *joints, lw_error *e);

const char *lw_mobility_kind_text(lw_mobility_kind kind);  /* "rigid", "shaky", "moves" */

#endif

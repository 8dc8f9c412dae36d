/* mbs/constraints/motion_curve_internal.h - data shared by the files motion_curve*.c. */
#ifndef LW_MBS_CONSTRAINTS_MOTION_CURVE_INTERNAL_H
#define LW_MBS_CONSTRAINTS_MOTION_CURVE_INTERNAL_H

#include "mbs/constraints/motion_curve.h"
#include "mbs/constraints/continuation_internal.h"

#define LW_MOTION_CURVE_ORDER 8                  /* order of the series across a branch point                */
#define LW_MOTION_CURVE_KNOTS 6                  /* points from which rates beside a branch point come       */
#define LW_MOTION_CURVE_BESIDE (4*LW_MOTION_CURVE_KNOTS + LW_MOTION_CURVE_ORDER + 2)

typedef struct lw_motion_curve_node {
    double *q;                             /* posture, unit tangent, half the curvature vector: 3 x n */
    double  kappa;
} lw_motion_curve_node;

/* From node `base` to node `far`, on planes across the tangent of the base at distances 0 .. length. */
typedef struct lw_motion_curve_segment {
    int    base, far;
    int    way;                            /* +1: base first; -1: far first                           */
    double length, arc;                    /* arc: of the segment                                     */
    double square, cube;                   /* d arc / d h = 1 + square h^2 + cube h^3                   */
    double singular;                       /* h of a branch point on it, -1: none                     */
} lw_motion_curve_segment;

struct lw_motion_curve {
    const lw_system *s;
    lw_continuation         f;                   /* on the curve                                            */
    lw_continuation         driven;              /* all inputs given                                        */
    const volatile sig_atomic_t *stop;
    int               n, input, most;
    double            reach;
    lw_motion_curve_node   *node;
    lw_motion_curve_segment *segment;
    double           *before;              /* arc before each segment (n_segment + 1)                  */
    int               n_node, n_segment;
    int               start;               /* segments before the posture                             */
    lw_motion_curve_end     end;
    bool              rests;               /* the free input, all along                               */
    double            worst;
    lw_motion_curve_event  *event;
    int               n_event;
    double           *series;              /* (LW_MOTION_CURVE_ORDER + 1) x n                               */
    double           *a, *b, *c;           /* scratch, n each                                         */
    double           *beside;              /* LW_MOTION_CURVE_BESIDE x n                              */
    double           *motion;              /* 2 x n_input x (LW_MOTION_CURVE_ORDER + 1)               */
};

static inline double *lw_node_tangent(const lw_motion_curve *b, int node) { return b->node[node].q + b->n; }
static inline double *lw_node_bend(const lw_motion_curve *b, int node) { return b->node[node].q + 2*b->n; }

/* Follow the curve from the posture of node 0, in both directions if it does not close (motion_curve_walk.c). */
lw_status lw_motion_curve_walk(lw_motion_curve *b, lw_error *e);

/* Posture at distance h from the base of a segment; the tangent points to growing stations. */
void lw_motion_curve_at(lw_motion_curve *b, const lw_motion_curve_segment *s, double h, double *q, double *tangent);

/* Move q from a simple branch point a short distance along the branch on which the input moves faster.  False, and q
 * unchanged, if there is none (motion_curve_singular.c). */
bool lw_motion_curve_leave(lw_motion_curve *b, double *q);

/* Fill b->event, sorted by station (motion_curve_event.c). */
lw_status lw_motion_curve_find_events(lw_motion_curve *b);

static inline double lw_segment_way(const lw_motion_curve_segment *s, double share)
{
    return s->way > 0 ? share*s->length : (1.0 - share)*s->length;
}

#endif

/* mbs/kinematics/motion_internal.h - what the files of mbs/motion*.c share. */
#ifndef LW_MBS_KINEMATICS_MOTION_INTERNAL_H
#define LW_MBS_KINEMATICS_MOTION_INTERNAL_H

#include "mbs/kinematics/motion.h"

/* ---- one dyad at one posture (mbs/kinematics/motion_span.c) ---- */

/* 1 - cos and 1 + cos of a dyad's transmission angle, each worked out as a product of differences;
 * negative when the dyad cannot close.  The margin is less*more. */
typedef struct lw_opening { double less, more; } lw_opening;

lw_opening lw_dyad_opening(const double *dim, const lw_step *step, const lw_vec2 *reg);

/* ---- the input's range for one dyad, in closed form (mbs/kinematics/motion_span.c) ---- */

typedef enum lw_span_kind {
    LW_SPAN_UNKNOWN,              /* its joints hang on other dyads                                  */
    LW_SPAN_NEVER,
    LW_SPAN_ALL,                  /* wherever the input stands                                       */
    LW_SPAN_RING,                 /* in <= |v| <= out, v the input from `centre`; for a pin |v| <= pi */
    LW_SPAN_HALVES                /* between centre and centre + pi, and centre + pi and + 2 pi      */
} lw_span_kind;

typedef struct lw_motion_span {
    lw_span_kind kind;
    double centre, in, out;
    bool   has_in, has_out;       /* else no limit on that side                                      */
    bool   touch_in, touch_out;   /* the margin touches 0 at v = 0, at v = pi                        */
} lw_motion_span;

lw_motion_span lw_dyad_span(const lw_plan *plan, const double *dim, const lw_step *step);

/* Is the dyad one with two assembly modes? */
static inline bool lw_step_has_modes(const lw_step *s)
{
    return s->kind == LW_STEP_RRR || s->kind == LW_STEP_RRP || s->kind == LW_STEP_RPR;
}

/* ---- pieces of the input's way ---- */

typedef struct lw_mark { double at; int dyad; } lw_mark;     /* dyad -1: nobody's limit */

#define LW_MARK_MAX 16
typedef struct lw_motion_piece {
    lw_mark end[2];
    bool    turns;                /* a full turn; the ends are one place                             */
    double  mode[LW_MODE_MAX];
    int     n_touch;
    lw_mark touch[LW_MARK_MAX];   /* where a margin touches 0                                        */
} lw_motion_piece;

#define LW_PIECE_MAX 24           /* of one dyad along one piece                                     */

/* Where along `whole` dyad `dyad` (its step) closes, by samples of its margin (mbs/kinematics/motion_search.c);
 * returns the number of pieces. */
int lw_piece_search(const lw_plan *plan, const double *dim, int dyad, const lw_step *step,
                    const lw_motion_piece *whole, lw_motion_piece *part);

/* Least and greatest transmission angle of the dyad along the piece. */
void lw_piece_transmission(const lw_plan *plan, const double *dim, int dyad, const lw_step *step,
                           const lw_motion_piece *p, double range[2]);

#endif

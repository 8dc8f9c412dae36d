/* mbs/kinematics/motion_internal.h - types and functions shared by mbs/kinematics/motion*.c. */
#ifndef LW_MBS_KINEMATICS_MOTION_INTERNAL_H
#define LW_MBS_KINEMATICS_MOTION_INTERNAL_H

#include "mbs/kinematics/motion.h"

/* ---- one dyad at one posture (mbs/kinematics/motion_span.c) ---- */

/* 1 - cos and 1 + cos of a dyad's transmission angle, computed as products of differences.  One is negative when the
 * dyad cannot close.  The margin is less*more. */
typedef struct lw_opening { double less, more; } lw_opening;

lw_opening lw_dyad_opening(const double *dim, const lw_step *step, const lw_vec2 *reg);

/* ---- the input's range for one dyad, in closed form (mbs/kinematics/motion_span.c) ---- */

typedef enum lw_span_kind {
    LW_SPAN_UNKNOWN,              /* other dyads move its joints: no closed form                     */
    LW_SPAN_NEVER,                /* the dyad closes at no input                                     */
    LW_SPAN_ALL,                  /* the dyad closes at every input                                  */
    LW_SPAN_RING,                 /* in <= |v| <= out, v = input - centre; for a pin |v| <= pi       */
    LW_SPAN_HALVES                /* two halves of a turn that meet at centre and centre + pi        */
} lw_span_kind;

typedef struct lw_motion_span {
    lw_span_kind kind;
    double centre, in, out;
    bool   has_in, has_out;       /* is there a limit on that side?                                  */
    bool   touch_in, touch_out;   /* does the margin touch 0 at v = 0, at v = pi?                    */
} lw_motion_span;

lw_motion_span lw_dyad_span(const lw_plan *plan, const double *dim, const lw_step *step);

/* Is the dyad one with two assembly modes? */
static inline bool lw_step_has_modes(const lw_step *s)
{
    return s->kind == LW_STEP_RRR || s->kind == LW_STEP_RRP || s->kind == LW_STEP_RPR;
}

/* ---- pieces of the input's range ---- */

typedef struct lw_mark { double at; int dyad; } lw_mark;     /* an input; the dyad whose limit it is, or -1 */

#define LW_MARK_MAX 16
typedef struct lw_motion_piece {
    lw_mark end[2];
    bool    turns;                /* a full turn: both ends are the same input                       */
    double  mode[LW_MODE_MAX];
    int     n_touch;
    lw_mark touch[LW_MARK_MAX];   /* inputs where a margin touches 0                                 */
} lw_motion_piece;

#define LW_PIECE_MAX 24           /* pieces of one dyad within one piece                             */

/* Find the parts of `whole` in which dyad `dyad` closes, by samples of its margin (mbs/kinematics/motion_search.c).
 * Returns their number. */
int lw_piece_search(const lw_plan *plan, const double *dim, int dyad, const lw_step *step,
                    const lw_motion_piece *whole, lw_motion_piece *part);

/* The least and greatest transmission angle of the dyad in the piece. */
void lw_piece_transmission(const lw_plan *plan, const double *dim, int dyad, const lw_step *step,
                           const lw_motion_piece *p, double range[2]);

#endif

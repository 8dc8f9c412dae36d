/* mbs/space/space_hold.h - how well drives hold a spatial model along a motion. */
#ifndef LW_MBS_SPACE_SPACE_HOLD_H
#define LW_MBS_SPACE_SPACE_HOLD_H

#include "mbs/space/space_follow.h"

#define LW_SPACE_HELD 12                         /* most drives                                         */

typedef struct lw_space_hold {
    int     n, n_v;                              /* drives, as many as freedoms, at most LW_SPACE_HELD   */
    double *column;                              /* (n x n_v) velocities of all bodies that span the motions which the joints allow */
    double *motions[3];                          /* (n x n_v) orthonormal, the same: at the last posture; at the one looked at now; kept */
    double  holds, kept;                         /* at the last posture; 0: not known                   */
    bool    unsure;                              /* the motions now differ too much from those at the last posture */
} lw_space_hold;

/* LW_E_MEMORY. */
lw_status lw_space_hold_make(int n, int n_v, lw_space_hold *h, lw_error *e);
void      lw_space_hold_free(lw_space_hold *h);

/* Forget the last posture. */
void lw_space_hold_begin(lw_space_hold *h);

/* Keep the last posture; go back to the one kept. */
void lw_space_hold_keep(lw_space_hold *h);
void lw_space_hold_back(lw_space_hold *h);

/* Fill `column` with the velocities of unit rates of the inputs of f (n), at f->q, where its rows are filled, and a (n x n) with the rates of
 * the drives, a column for each input.  false: the posture is singular for the inputs. */
bool lw_space_hold_rates(lw_space_hold *h, lw_space_follow *f, const lw_spatial_measure *drive, double *a);

/* The determinant of the rates a of the drives (NULL: the drives are the inputs; a is changed) by orthonormal coordinates of the motions in `column`.  It
 * is smooth along a motion, and 0 exactly where the drives lose the model: it can move while they stand still.  The coordinates keep the orientation of
 * those at the last posture.  0: not known. */
double lw_space_hold_now(lw_space_hold *h, double *a);

/* Have the drives lost the model between the last posture and this one, or are the two too different to tell?  If not, this one is the last one from
 * now on. */
bool lw_space_hold_lost(lw_space_hold *h, double holds);

/* The motion v (n_v, of length 1) that moves the drives least, from their rates a and the motions `column` as above: where the drives lose the model, it
 * is that of the links while the drives stand still.  false: not known. */
bool lw_space_unheld(int n, int n_v, const double *a, const double *column, double *v);

/* Write how the link of the first tracer moves, or the one that moves most if that moves ten times as much, rounded to hundredths of the size of the
 * model: `link "plate" turns about the axis (0.00, 0.00, 1.00) through (0.1, 0, 1) m`. */
#define LW_SPACE_MOTION_TEXT 240
void lw_space_motion_text(const lw_space *s, const lw_space_frame *frame, const double *v, char text[LW_SPACE_MOTION_TEXT]);

/* The same along the path of a follow, at every posture that it passes. */
typedef struct lw_space_watch {
    lw_space_hold hold;
    lw_space_follow *f;
    lw_spatial_measure drive[LW_SPACE_HELD];
    double  at;                                  /* parameter of the last posture                       */
    bool    lost;                                /* the drives lose the model between these parameters: the first time */
    double  between[2];
    char    how[LW_SPACE_MOTION_TEXT];           /* the links move there while they stand still         */
    double  rates[LW_SPACE_HELD*LW_SPACE_HELD];  /* at the last posture: of the drives                  */
    double *last, *motion;                       /* the same: column (n x n_v), posture (n_q); scratch (2 n_v + n_q) */
} lw_space_watch;

/* Watch f from its present posture on with the drives of its model, or its inputs.  Nothing is watched, and column is NULL, where nothing can be
 * lost: in open chains, of one input that drives; or where the drives are not as many as the freedoms.  LW_E_MEMORY. */
lw_status lw_space_watch_begin(lw_space_watch *w, lw_space_follow *f, lw_error *e);
void      lw_space_watch_end(lw_space_watch *w);

#endif

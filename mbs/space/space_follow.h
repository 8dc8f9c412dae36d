/* mbs/space/space_follow.h - postures of a spatial model along its inputs, by continuation without jumps between branches. */
#ifndef LW_MBS_SPACE_SPACE_FOLLOW_H
#define LW_MBS_SPACE_SPACE_FOLLOW_H

#include "mbs/space/space_solve.h"

/* Where the inputs are at parameter u: value, rate and second rate by u, SI units, out[i][3] of input i. */
typedef lw_status lw_space_path(void *context, double u, double (*out)[3]);

typedef struct lw_space_follow {
    lw_space_rows_set z;
    int     n_input, n_idle, freedom;    /* freedom: left when the inputs stand still                      */
    int     redundant;                   /* rows of joints that depend on others                           */
    double  u;                           /* parameter reached                                              */
    double *q, *v, *a;                   /* (n_q) posture there; (n_v) rates by u                          */
    double *q_try, *v_try, *target, *rhs, *l, (*path)[3];
    double *seen, *kept;                 /* room for postures beside a singular one, and for what holds in it */
    double  made_at, (*made)[3];         /* the path at u; v is that of this path at made_at               */
    double *off, *before, *again;        /* (n_v) where steps end beside h v + h^2 a/2: the last one, the one before in proportion, the next one */
    double  off_h, before_h;             /* lengths of the two along the path; 0: none                     */
    double *column;                      /* (n_input x n_v) where to keep the motions by a unit rate of one input (over its scale) each; NULL: nowhere */
    bool    has_column;                  /* they are those at q                                            */
    bool    has_second;                  /* a, too                                                         */
    bool    between;                     /* v and a come from postures beside a singular one               */
    double  clear;                       /* greatest z.weak of the postures gone through: far from singular ones */
    double  open;                        /* rows that depend on others stay closed to this; 0: not known yet */
    double  yields;                      /* until then: how much they open along v and a, over the second order of the motion */
    bool    opened;                      /* the last step tried would open rows that depend on others farther than rounded numbers do: an
                                          * overconstrained linkage that does not move as drawn */
    double  least;                       /* share of the way of a call to which a limit is found           */
    lw_space_path *made_by;
    void   (*passed)(void *context, const double *q);    /* sees every posture on the way, less than half a turn apart; NULL */
    void   *passed_by;
    void   *memory;
} lw_space_follow;

/* Begin in the posture of the file with these inputs.  LW_E_ARG: the inputs do not leave the freedom 0 (unless
 * `any`), or ask for more than the freedoms. */
lw_status lw_space_follow_make(const lw_space *s, const lw_spatial_measure *input, int n_input, bool any,
                               lw_space_follow *f,
                               lw_error *e);
void      lw_space_follow_free(lw_space_follow *f);

/* How many freedoms of first order in the posture of the file are none of the motion: 0, or it is singular.  Also 0 if the model has no dependent rows,
 * more than LW_SPACE_MANY_ROWS, or if memory is lacking.  It takes as long as lw_space_mobility_find. */
int lw_space_lost_freedoms(const lw_space_follow *f);

/* Go along the path from f->u to u, whose value at f->u must be that of the posture f->q (else it is first gone to in a
 * straight line).  A singular posture at u on a smooth motion is reached between others.  LW_OPEN with a text: a limit of the motion or
 * another singular posture lies before; f is at the last posture reached.  e NULL: no text, which takes longer to find than the limit. */
lw_status lw_space_follow_to(lw_space_follow *f, lw_space_path *path, void *context, double u, lw_error *e);

/* f->a, which going fills only where it is needed: the second rates by f->u, just after going there. */
void lw_space_follow_second(lw_space_follow *f);

/* Once the second rates are known: do rows left out as dependent open with the square of any step from here?  Then no motion has these rates. */
bool lw_space_follow_opens(const lw_space_follow *f);

/* f->v and f->a for output just after going along the path: within 0.003 of a singular posture, where solving loses digits, they come
 * from the postures before and behind it (f->between), good to LW_SPACE_BETWEEN. */
#define LW_SPACE_BETWEEN 3e-9
void lw_space_follow_rates(lw_space_follow *f, lw_space_path *path, void *context);

/* Does a link slide away without bound where going has ended, as those of an RCCC linkage do at limits of its crank?  The fastest link, if it is far
 * on a slide c/sqrt(left) where `left` of the parameter is left; that slide over the size of the model; otherwise -1. */
#define LW_SPACE_FAR 100.0               /* as far out as a slide is of use */
int lw_space_away(const lw_space_follow *f, double *slide, double *left);

/* Distance of a link that is a body from its place in the file, over the size of the model. */
double lw_space_distance(const lw_space_follow *f, int link);

/* Values of the inputs at f->q [SI]. */
void lw_space_follow_values(const lw_space_follow *f, double *value);

/* The path of the model `context` (lw_spatial) in time: its inputs move as their "motion" says, or stand still. */
lw_space_path lw_space_motions;

/* A limit of the input, or where the model is singular, in direction `to` from the posture of f (one input): the last
 * value reached and *limit; or `to` and no limit.  LW_OPEN with a text: f->opened.  LW_E_MEMORY. */
lw_status lw_space_reach(lw_space_follow *f, double to, double *reached, bool *limit, lw_error *e);

#endif

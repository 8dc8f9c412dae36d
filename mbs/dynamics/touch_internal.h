/* mbs/dynamics/touch_internal.h - the places where a model touches, in its equations; internal to mbs/.
 *
 * Places that are held are rows of the constraints, after those of the rigid stops: gaps, and slips that stick.  At
 * places that slip, friction is a force in proportion to the multiplier of the gap (mbs/equations/friction.h).  Forces
 * of compliant contacts depend on the state. */
#ifndef LW_MBS_DYNAMICS_TOUCH_INTERNAL_H
#define LW_MBS_DYNAMICS_TOUCH_INTERNAL_H

#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/equations/touch.h"

typedef struct lw_touch_row { int touch; bool tangent; } lw_touch_row;

struct lw_touching {
    lw_touch_list list;
    int     n_row, row_max;
    lw_touch_row *row;                   /* (row_max)                                                  */
    int     n_redundant;                 /* forces whose rows depend on those in `row`: touch_shares.c */
    lw_touch_row *redundant;             /* (row_max)                                                  */
    double *share;                       /* those forces (n_redundant) as they were found last, scaled; then memory */
    int     n_slip;                      /* rigid places that slip; they follow the joints in d->friction */
    double *response;                    /* as that of lw_dynamics, n_slip more                         */
    double  determinant;                 /* of the friction equations; 1 without friction              */
    int     sense;                       /* its sign after the last event; 0: not known yet            */
    bool    captured;                    /* rows are all near places, closed or not (mbs/formulations/capture.c) */
    bool    goes_on;                     /* the run goes on with the end of a piece, whose overlaps are known already */
    bool    events;                      /* where compliant contacts begin and end                     */
    double  least_force;                 /* a force below this is rounding                             */
    double  most_force;                  /* above this a force may grow without bound: contacts are decided anew */
    long    stalled;                     /* events in a row without progress in time, */
    double  last;                        /* and the time of the last                                   */
};

/* Find the places of a model with contacts or ropes; d->touch stays NULL for others. */
lw_status lw_mbs_touch_make(lw_dynamics *d, lw_error *e);
void      lw_mbs_touch_free(lw_dynamics *d);

/* Memory for the shares of the rows and redundant forces that are set.  LW_E_MEMORY. */
lw_status lw_mbs_touch_share_make(lw_dynamics *d);

/* The margin of the forces of all these places to their limits, scaled, when they share the load so that it is greatest; below 0: no sharing keeps
 * to the limits.
 * l: multipliers (n_c); the rows and their factors are those of lw_mbs_accelerate.  Places whose friction is at its limit get
 * `yields`, none where a normal force is. */
double lw_mbs_touch_share(lw_dynamics *d, const double *v, const double *l);

/* Share the load of a sample among all these places, with the least sum of squares within the limits, and change the multipliers l (n_c) accordingly.  Rows
 * and factors are those of the sample. */
void lw_mbs_touch_spread(lw_dynamics *d, const double *v, double *l);

/* Has any of its places friction? */
bool      lw_mbs_touch_rubs(const lw_dynamics *d);

/* Rows from `row` on: their bodies; values and derivatives; what J v' has to be. */
void lw_mbs_touch_bodies(lw_dynamics *d, int row);
void lw_mbs_touch_rows(lw_dynamics *d, int row);
void lw_mbs_touch_bias(lw_dynamics *d, int row, const double *v);

/* Add the forces of compliant contacts, with their friction unless it sticks; frames are those of the rows. */
void lw_mbs_touch_forces(lw_dynamics *d, const double *v, double *force, double *power);

/* Normal force [N] at place i, and in *f the force on its link 0; placed at the coordinates, l the multipliers. */
double lw_mbs_touch_load(const lw_dynamics *d, int i, const double *v, const double *l, lw_vec2 *f);

/* Generalised force (n_q) of the friction of slipping place k for a normal force of 1 N; returns its power [W]. */
double lw_mbs_touch_slip(lw_dynamics *d, int k, const double *v, double *force);

#endif

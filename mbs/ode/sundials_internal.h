/* mbs/ode/sundials_internal.h - what the bridges to CVODE and IDA share: one context per solver; its messages and the
 * status of callbacks are stored instead of printed; matrices are plain columns. */
#ifndef LW_MBS_ODE_SUNDIALS_INTERNAL_H
#define LW_MBS_ODE_SUNDIALS_INTERNAL_H

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sunmatrix/sunmatrix_dense.h>
#include "mbs/ode/sundials.h"

struct lw_columns;
typedef struct lw_sun lw_sun;

/* The functions of a solver that both have under other names. */
typedef struct lw_sun_calls {
    const char *name;
    int  (*advance)(lw_sun *s, double t_end, double *reached, int task);
    int  (*current_time)(void *solver, realtype *t), (*stop_time)(void *solver, realtype t);
    int  (*root_info)(void *solver, int *info), (*dense)(void *solver, realtype t, int derivative, N_Vector out);
    int  (*count[4])(void *solver, long *n);       /* steps, refused, rates or residuals, Jacobians */
    void (*free)(void **solver);
    int  normal, one_step, root_return;
} lw_sun_calls;

enum { LW_SUN_NOW, LW_SUN_EACH, LW_SUN_SCRATCH, LW_SUN_RATE, LW_SUN_KIND, LW_SUN_SPARE, LW_SUN_EMPTY, LW_SUN_VECTORS };

struct lw_sun {
    const lw_sun_calls *call;
    const void     *problem;             /* lw_ode or lw_dae                                           */
    lw_ode_options  o;
    void           *solver;
    int             n;
    N_Vector        v[LW_SUN_VECTORS];
    SUNMatrix       saved;               /* for the copy of the Jacobian matrix that CVODE keeps, until it takes it */
    bool            no_room;             /* there was no memory for a vector of the solver, which took LW_SUN_SPARE for it */
    SUNContext      context;
    SUNMatrix       matrix;
    SUNLinearSolver linear;
    lw_status       failed;              /* the status with which a callback ended the run             */
    char            message[256];        /* message of the solver                                      */
    int             still;               /* steps in a row that did not move t                         */
    long            before[4];           /* counts before the last restart                             */
    int             n_event, direction[LW_EVENT_MAX];
    const bool     *passing;             /* these three: of the problem                                */
    void          (*seen)(void *context, int event, double t, const double *y);
    void           *context_of;
};

static inline double *lw_sun_array(N_Vector v) { return N_VGetArrayPointer(v); }

/* Make w->own with context, linear solver and vectors for the n variables of a problem; pattern NULL: dense.
 * lw_sundials_free undoes it, after a failure too. */
lw_status lw_sun_make(lw_sundials *w, const lw_sun_calls *call, const void *problem, int n, int n_event,
                      const struct lw_columns *pattern, const lw_ode_options *o, double t, lw_error *e);

/* The failure of a solver that could not be set up; frees it. */
lw_status lw_sun_cannot_start(lw_sundials *w, lw_error *e);

/* Take new values, unless they are NULL, before the solver starts anew; it will count from 0. */
void lw_sun_restart(lw_sundials *w, const double *y, const double *dy);

/* The status of a callback for SUNDIALS: 0 success, > 0 try a shorter step, < 0 give up. */
int lw_sun_code(lw_sun *s, lw_status status);
void lw_sun_message(int code, const char *module, const char *function, char *message, void *user);
lw_status lw_sun_error(const lw_sun *s, double t, lw_error *e);
double *lw_sun_values(SUNMatrix a);      /* of a matrix with a pattern */

#endif

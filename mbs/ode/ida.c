/* mbs/ode/ida.c - bridge to IDA of SUNDIALS 6. */
#include "mbs/ode/ida.h"

#include <ida/ida.h>
#include <string.h>
#include "base/real.h"
#include "mbs/ode/sundials_internal.h"

static const lw_dae *dae_of(void *user) { return ((const lw_sun *)user)->problem; }

/* ---- callbacks ----------------------------------------------------------------------------------- */

static int residual(realtype t, N_Vector y, N_Vector dy, N_Vector r, void *user)
{
    const lw_dae *dae = dae_of(user);
    return lw_sun_code(user, dae->residual(dae->context, t, lw_sun_array(y), lw_sun_array(dy), lw_sun_array(r)));
}

static int jacobian(realtype t, realtype c, N_Vector y, N_Vector dy, N_Vector r, SUNMatrix j, void *user, N_Vector a,
                    N_Vector b, N_Vector d)
{
    (void)r, (void)a, (void)b, (void)d;
    const lw_dae *dae = dae_of(user);
    SUNMatZero(j);
    double *value = dae->pattern ? lw_sun_values(j) : SUNDenseMatrix_Data(j);
    return lw_sun_code(user, dae->jacobian(dae->context, t, c, lw_sun_array(y), lw_sun_array(dy), value));
}

static int roots(realtype t, N_Vector y, N_Vector dy, realtype *g, void *user)
{
    (void)dy;
    const lw_dae *dae = dae_of(user);
    return lw_sun_code(user, dae->event(dae->context, t, lw_sun_array(y), g)) ? -1 : 0;
}

/* IDASVtolerances cannot be called again during a run; this function reads the current tolerances before every step */
static int weights(N_Vector y, N_Vector weight, void *user)
{
    const lw_sun *s = user;
    const double *each = lw_sun_array(s->v[LW_SUN_EACH]), *at = lw_sun_array(y);
    for (int i = 0; i < s->n; i++) {
        double allowed = s->o.relative*fabs(at[i]) + each[i];
        if (!(allowed > 0))
            return -1;
        lw_sun_array(weight)[i] = 1/allowed;
    }
    return 0;
}

static int advance(lw_sun *s, double t_end, double *reached, int task)
{
    return IDASolve(s->solver, t_end, reached, s->v[LW_SUN_NOW], s->v[LW_SUN_RATE], task);
}

static const lw_sun_calls calls = {
    .name = "IDA", .advance = advance, .current_time = IDAGetCurrentTime, .stop_time = IDASetStopTime,
    .root_info = IDAGetRootInfo, .dense = IDAGetDky, .free = IDAFree,
    .count = { IDAGetNumSteps, IDAGetNumErrTestFails, IDAGetNumResEvals, IDAGetNumJacEvals },
    .normal = IDA_NORMAL, .one_step = IDA_ONE_STEP, .root_return = IDA_ROOT_RETURN
};

/* ---- making -------------------------------------------------------------------------------------- */

/* If algebraic variables are excluded from the error test, Newton's method converges to a hundredth of the allowed
 * error of a step.  IDA's own limit, a third, disturbs the error test of the other variables and halves the steps. */
static const double newton = 0.01;

static bool set_kinds(lw_sun *own)
{
    const lw_dae *dae = own->problem;
    bool any = false;
    for (int i = 0; i < dae->n; i++) {
        bool algebraic = dae->algebraic && dae->algebraic[i];
        lw_sun_array(own->v[LW_SUN_KIND])[i] = algebraic ? 0.0 : 1.0;
        any = any || algebraic;
    }
    return IDASetId(own->solver, own->v[LW_SUN_KIND]) == 0 && IDASetSuppressAlg(own->solver, any) == 0
        && (!any || IDASetNonlinConvCoef(own->solver, newton) == 0);
}

static const int most_failures = 30;         /* of the error test in a row: a run that begins on a jump of F needs a very short first step */

static bool set_up(lw_sun *own, double t)
{
    const lw_dae *dae = own->problem;
    void *s = own->solver = IDACreate(own->context);
    bool ok = s && IDASetErrHandlerFn(s, lw_sun_message, own) == 0
        && IDAInit(s, residual, t, own->v[LW_SUN_NOW], own->v[LW_SUN_RATE]) == 0 && IDASetUserData(s, own) == 0
        && IDAWFtolerances(s, weights) == 0
        && IDASetLinearSolver(s, own->linear, own->matrix) == 0 && IDASetMaxNumSteps(s, -1) == 0 && IDASetMaxErrTestFails(s, most_failures) == 0
        && set_kinds(own);
    ok = ok && (!dae->jacobian || IDASetJacFn(s, jacobian) == 0);
    ok = ok && (dae->n_event == 0 || (IDARootInit(s, dae->n_event, roots) == 0
        && IDASetRootDirection(s, own->direction) == 0 && IDASetNoInactiveRootWarn(s) == 0));
    ok = ok && (own->o.order == 0 || IDASetMaxOrd(s, own->o.order) == 0);
    ok = ok && (own->o.first <= 0.0 || IDASetInitStep(s, own->o.first) == 0);
    return ok && !own->no_room && (own->o.greatest <= 0.0 || IDASetMaxStep(s, own->o.greatest) == 0);
}

lw_status lw_ida_make(lw_sundials *w, const lw_dae *dae, const lw_ode_options *o, double t, const double *y, const double *dy, lw_error *e)
{
    lw_status st = lw_sun_make(w, &calls, dae, dae->n, dae->n_event, dae->pattern, o, t, e);
    if (st != LW_OK)
        return st;
    lw_sun *s = w->own;
    s->passing = dae->passing, s->seen = dae->seen, s->context_of = dae->context;
    for (int i = 0; i < dae->n_event; i++)
        s->direction[i] = dae->direction[i];
    memcpy(lw_sun_array(s->v[LW_SUN_NOW]), y, sizeof(double)*(size_t)dae->n);
    memcpy(lw_sun_array(s->v[LW_SUN_RATE]), dy, sizeof(double)*(size_t)dae->n);
    w->y = lw_sun_array(s->v[LW_SUN_NOW]);
    return set_up(s, t) ? LW_OK : lw_sun_cannot_start(w, e);
}

lw_status lw_ida_restart(lw_sundials *w, const double *y, const double *dy, lw_error *e)
{
    lw_sun_restart(w, y, dy);
    return IDAReInit(w->own->solver, w->t, w->own->v[LW_SUN_NOW], w->own->v[LW_SUN_RATE]) == 0
         ? LW_OK : lw_sun_error(w->own, w->t, e);
}

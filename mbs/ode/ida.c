/* mbs/ode/ida.c - bridge to IDA of SUNDIALS 6. */
#include "mbs/ode/ida.h"

#include <ida/ida.h>
#include <stdlib.h>
#include "mbs/ode/sundials_internal.h"

enum { NOW, RATE, SCRATCH, EACH, KIND, N_VECTOR };

struct lw_ida_own {
    lw_sun         sun;
    const lw_dae  *dae;
    lw_ode_options o;
    void          *solver;
    N_Vector       v[N_VECTOR];
    long           before[4];            /* counts before the last restart: steps, refused, residuals, Jacobians */
};

static double *array(N_Vector v)
{
    return N_VGetArrayPointer(v);
}

/* ---- callbacks ----------------------------------------------------------------------------------- */

static int residual(realtype t, N_Vector y, N_Vector dy, N_Vector r, void *user)
{
    struct lw_ida_own *w = user;
    return lw_sun_code(&w->sun, w->dae->residual(w->dae->context, t, array(y), array(dy), array(r)));
}

static int jacobian(realtype t, realtype c, N_Vector y, N_Vector dy, N_Vector r, SUNMatrix j, void *user, N_Vector a,
                    N_Vector b, N_Vector d)
{
    (void)r, (void)a, (void)b, (void)d;
    struct lw_ida_own *w = user;
    SUNMatZero(j);
    double *value = w->dae->pattern ? lw_sun_values(j) : SUNDenseMatrix_Data(j);
    return lw_sun_code(&w->sun, w->dae->jacobian(w->dae->context, t, c, array(y), array(dy), value));
}

static int roots(realtype t, N_Vector y, N_Vector dy, realtype *g, void *user)
{
    (void)dy;
    struct lw_ida_own *w = user;
    return lw_sun_code(&w->sun, w->dae->event(w->dae->context, t, array(y), g)) ? -1 : 0;
}

/* IDASVtolerances cannot be called again during a run; this function reads the current tolerances before every step */
static int weights(N_Vector y, N_Vector weight, void *user)
{
    const struct lw_ida_own *w = user;
    const double *each = array(w->v[EACH]), *at = array(y);
    for (int i = 0; i < w->dae->n; i++) {
        double allowed = w->o.relative*fabs(at[i]) + each[i];
        if (!(allowed > 0))
            return -1;
        array(weight)[i] = 1/allowed;
    }
    return 0;
}

/* ---- making -------------------------------------------------------------------------------------- */

/* If algebraic variables are excluded from the error test, Newton's method converges to a hundredth of the allowed
 * error of a step.  IDA's own limit, a third, disturbs the error test of the other variables and halves the steps. */
static const double newton = 0.01;

static bool set_kinds(struct lw_ida_own *own)
{
    const lw_dae *dae = own->dae;
    bool any = false;
    for (int i = 0; i < dae->n; i++) {
        bool algebraic = dae->algebraic && dae->algebraic[i];
        array(own->v[KIND])[i] = algebraic ? 0.0 : 1.0;
        any = any || algebraic;
    }
    return IDASetId(own->solver, own->v[KIND]) == 0 && IDASetSuppressAlg(own->solver, any) == 0
        && (!any || IDASetNonlinConvCoef(own->solver, newton) == 0);
}

static bool set_up(lw_ida *w, double t, const double *y, const double *dy)
{
    struct lw_ida_own *own = w->own;
    const lw_dae *dae = own->dae;
    if (!lw_sun_make(&own->sun, dae->n, dae->pattern, own->v, N_VECTOR))
        return false;
    own->solver = IDACreate(own->sun.context);
    if (!own->solver)
        return false;
    memcpy(array(own->v[NOW]), y, sizeof(double)*(size_t)dae->n);
    memcpy(array(own->v[RATE]), dy, sizeof(double)*(size_t)dae->n);
    lw_sun_tolerances(&own->o, own->v[EACH]);
    void *s = own->solver;
    int directions[LW_EVENT_MAX];
    for (int i = 0; i < dae->n_event; i++)
        directions[i] = dae->direction[i];
    bool ok = IDASetErrHandlerFn(s, lw_sun_message, &own->sun) == 0
        && IDAInit(s, residual, t, own->v[NOW], own->v[RATE]) == 0 && IDASetUserData(s, own) == 0
        && IDAWFtolerances(s, weights) == 0
        && IDASetLinearSolver(s, own->sun.linear, own->sun.matrix) == 0 && IDASetMaxNumSteps(s, -1) == 0
        && set_kinds(own);
    ok = ok && (!dae->jacobian || IDASetJacFn(s, jacobian) == 0);
    ok = ok && (dae->n_event == 0 || (IDARootInit(s, dae->n_event, roots) == 0
        && IDASetRootDirection(s, directions) == 0 && IDASetNoInactiveRootWarn(s) == 0));
    ok = ok && (own->o.first <= 0.0 || IDASetInitStep(s, own->o.first) == 0);
    return ok && (own->o.greatest <= 0.0 || IDASetMaxStep(s, own->o.greatest) == 0);
}

lw_status lw_ida_make(lw_ida *w, const lw_dae *dae, const lw_ode_options *o, double t, const double *y,
                      const double *dy, lw_error *e)
{
    if (dae->n < 1 || dae->n_event < 0 || dae->n_event > LW_EVENT_MAX || o->fixed > 0.0)
        return lw_error_set(e, LW_E_ARG, "IDA wants 1 or more numbers, 0 to %d events and no fixed step", LW_EVENT_MAX);
    *w = (lw_ida){ .t = t, .t_old = t, .own = calloc(1, sizeof *w->own) };
    if (!w->own)
        return lw_error_set(e, LW_E_MEMORY, "no memory for IDA");
    w->own->dae = dae;
    w->own->o = *o;
    if (!set_up(w, t, y, dy)) {
        lw_status s = lw_error_set(e, w->own->sun.message[0] ? LW_E_ARG : LW_E_MEMORY, "IDA cannot start: %s",
                                   w->own->sun.message[0] ? w->own->sun.message : "out of memory");
        lw_ida_free(w);
        return s;
    }
    w->y = array(w->own->v[NOW]);
    w->dy = array(w->own->v[RATE]);
    return LW_OK;
}

void lw_ida_free(lw_ida *w)
{
    if (!w->own)
        return;
    IDAFree(&w->own->solver);
    lw_sun_free(&w->own->sun, w->own->v, N_VECTOR);
    free(w->own);
    w->own = NULL;
}

/* IDA restarts its counters at 0. */
static void count(lw_ida *w)
{
    long now[4] = { 0 };
    IDAGetNumSteps(w->own->solver, &now[0]);
    IDAGetNumErrTestFails(w->own->solver, &now[1]);
    IDAGetNumResEvals(w->own->solver, &now[2]);
    IDAGetNumJacEvals(w->own->solver, &now[3]);
    w->n_step = w->own->before[0] + now[0];
    w->n_refused = w->own->before[1] + now[1];
    w->n_residual = w->own->before[2] + now[2];
    w->n_jacobian = w->own->before[3] + now[3];
}

lw_status lw_ida_restart(lw_ida *w, const double *y, const double *dy, lw_error *e)
{
    struct lw_ida_own *own = w->own;
    size_t bytes = sizeof(double)*(size_t)own->dae->n;
    if (y)
        memcpy(array(own->v[NOW]), y, bytes);
    if (dy)
        memcpy(array(own->v[RATE]), dy, bytes);
    own->sun.failed = LW_OK;
    w->events = 0;
    count(w);
    memcpy(own->before, (long[]){ w->n_step, w->n_refused, w->n_residual, w->n_jacobian }, sizeof own->before);
    if (IDAReInit(own->solver, w->t, own->v[NOW], own->v[RATE]) != 0)
        return lw_sun_error(&own->sun, "IDA", w->t, e);
    return LW_OK;
}

/* ---- stepping ------------------------------------------------------------------------------------ */

/* Record the events that happened; true if one of them ends the step. */
static bool take_roots(lw_ida *w)
{
    const lw_dae *dae = w->own->dae;
    int info[LW_EVENT_MAX];
    bool end = false;
    IDAGetRootInfo(w->own->solver, info);
    for (int i = 0; i < dae->n_event; i++) {
        if (!info[i])
            continue;
        w->events |= 1ull << i;
        end = end || !dae->passing[i];
        if (dae->passing[i] && dae->seen)
            dae->seen(dae->context, i, w->t, w->y);
    }
    return end;
}

lw_status lw_ida_step(lw_ida *w, double t_end, lw_ode_stop *stop, lw_error *e)
{
    struct lw_ida_own *own = w->own;
    double reached = w->t, ahead = w->t;
    *stop = LW_ODE_END;
    w->events = 0;
    if (t_end == w->t)
        return LW_OK;
    if (t_end < w->t)
        return lw_error_set(e, LW_E_ARG, "IDA runs forward only");
    w->t_old = w->t;
    for (;;) {
        if (own->o.max_step > 0 && w->n_step >= own->o.max_step)
            return lw_error_set(e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", w->t, own->o.max_step);
        /* after an event, IDA itself is already at a later time */
        bool beyond = IDAGetCurrentTime(own->solver, &ahead) == 0 && ahead >= t_end && w->n_step > own->before[0];
        int code = beyond ? 0 : IDASetStopTime(own->solver, t_end);
        if (code == 0)
            code = IDASolve(own->solver, t_end, &reached, own->v[NOW], own->v[RATE],
                            beyond ? IDA_NORMAL : IDA_ONE_STEP);
        count(w);
        if (code < 0 || (!beyond && lw_sun_stands_still(&own->sun, w->t, reached)))
            return lw_sun_error(&own->sun, "IDA", w->t, e);
        w->t = reached;
        bool ended = code == IDA_ROOT_RETURN && take_roots(w);
        if (code == IDA_ROOT_RETURN && !ended && w->t < t_end)
            continue;
        *stop = ended ? LW_ODE_EVENT : w->t >= t_end ? LW_ODE_END : LW_ODE_STEP;
        return LW_OK;
    }
}

lw_status lw_ida_dense(lw_ida *w, double t, double *y)
{
    struct lw_ida_own *own = w->own;
    if (t == w->t) {
        memcpy(y, w->y, sizeof(double)*(size_t)own->dae->n);
        return LW_OK;
    }
    if (IDAGetDky(own->solver, t, 0, own->v[SCRATCH]) != 0)
        return LW_E_ARG;
    memcpy(y, array(own->v[SCRATCH]), sizeof(double)*(size_t)own->dae->n);
    return LW_OK;
}

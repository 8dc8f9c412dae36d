/* mbs/ode/cvode.c - bridge to CVODE of SUNDIALS 6. */
#include "mbs/ode/cvode.h"

#include <cvode/cvode.h>
#include <cvode/cvode_proj.h>
#include <stdlib.h>
#include "mbs/ode/sundials_internal.h"

enum { NOW, SCRATCH, EACH, N_VECTOR };

struct lw_cvode_own {
    lw_sun         sun;
    const lw_ode  *ode;
    lw_ode_options o;
    void          *solver;
    N_Vector       v[N_VECTOR];
    long           before[4];            /* counts before the last restart: steps, refused, rates, Jacobians */
};

static double *array(N_Vector v)
{
    return N_VGetArrayPointer(v);
}

/* ---- callbacks ----------------------------------------------------------------------------------- */

static int rate(realtype t, N_Vector y, N_Vector dy, void *user)
{
    struct lw_cvode_own *w = user;
    return lw_sun_code(&w->sun, w->ode->rate(w->ode->context, t, array(y), array(dy)));
}

static int jacobian(realtype t, N_Vector y, N_Vector dy, SUNMatrix j, void *user, N_Vector a, N_Vector b, N_Vector c)
{
    (void)a, (void)b, (void)c;
    struct lw_cvode_own *w = user;
    SUNMatZero(j);
    return lw_sun_code(&w->sun, w->ode->jacobian(w->ode->context, t, array(y), array(dy), SUNDenseMatrix_Data(j)));
}

static int roots(realtype t, N_Vector y, realtype *g, void *user)
{
    struct lw_cvode_own *w = user;
    return lw_sun_code(&w->sun, w->ode->event(w->ode->context, t, array(y), g)) ? -1 : 0;
}

/* CVODE asks for the correction and for the projected error vector; the error vector stays unchanged */
static int project(realtype t, N_Vector y, N_Vector correction, realtype tolerance, N_Vector error, void *user)
{
    (void)tolerance, (void)error;
    struct lw_cvode_own *w = user;
    N_VScale(1.0, y, correction);
    int code = lw_sun_code(&w->sun, w->ode->project(w->ode->context, t, array(correction)));
    N_VLinearSum(1.0, correction, -1.0, y, correction);
    return code;
}

/* ---- making -------------------------------------------------------------------------------------- */

static bool set_up(lw_cvode *w, lw_cvode_method method, double t, const double *y)
{
    struct lw_cvode_own *own = w->own;
    const lw_ode *ode = own->ode;
    if (!lw_sun_make(&own->sun, ode->n, NULL, own->v, N_VECTOR))
        return false;
    own->solver = CVodeCreate(method == LW_CVODE_ADAMS ? CV_ADAMS : CV_BDF, own->sun.context);
    if (!own->solver)
        return false;
    memcpy(array(own->v[NOW]), y, sizeof(double)*(size_t)ode->n);
    lw_sun_tolerances(&own->o, own->v[EACH]);
    void *s = own->solver;
    int directions[LW_EVENT_MAX];
    for (int i = 0; i < ode->n_event; i++)
        directions[i] = ode->direction[i];
    bool ok = CVodeSetErrHandlerFn(s, lw_sun_message, &own->sun) == 0 && CVodeInit(s, rate, t, own->v[NOW]) == 0
        && CVodeSetUserData(s, own) == 0 && CVodeSVtolerances(s, own->o.relative, own->v[EACH]) == 0
        && CVodeSetLinearSolver(s, own->sun.linear, own->sun.matrix) == 0 && CVodeSetMaxNumSteps(s, -1) == 0
        && CVodeSetMaxHnilWarns(s, -1) == 0;
    ok = ok && (!ode->jacobian || CVodeSetJacFn(s, jacobian) == 0);
    ok = ok && (ode->n_event == 0 || (CVodeRootInit(s, ode->n_event, roots) == 0
        && CVodeSetRootDirection(s, directions) == 0 && CVodeSetNoInactiveRootWarn(s) == 0));
    ok = ok && (own->o.first <= 0.0 || CVodeSetInitStep(s, own->o.first) == 0);
    ok = ok && (own->o.greatest <= 0.0 || CVodeSetMaxStep(s, own->o.greatest) == 0);
    return ok && (!ode->project || method == LW_CVODE_ADAMS || CVodeSetProjFn(s, project) == 0);
}

lw_status lw_cvode_make(lw_cvode *w, const lw_ode *ode, const lw_ode_options *o, lw_cvode_method method,
                        double t, const double *y, lw_error *e)
{
    if (ode->n < 1 || ode->n_event < 0 || ode->n_event > LW_EVENT_MAX || o->fixed > 0.0)
        return lw_error_set(e, LW_E_ARG, "CVODE needs at least one variable, 0 to %d events and no fixed step",
                            LW_EVENT_MAX);
    *w = (lw_cvode){ .t = t, .t_old = t, .own = calloc(1, sizeof *w->own) };
    if (!w->own)
        return lw_error_set(e, LW_E_MEMORY, "no memory for CVODE");
    w->own->ode = ode;
    w->own->o = *o;
    if (!set_up(w, method, t, y)) {
        lw_status s = lw_error_set(e, w->own->sun.message[0] ? LW_E_ARG : LW_E_MEMORY, "CVODE cannot start: %s",
                                   w->own->sun.message[0] ? w->own->sun.message : "out of memory");
        lw_cvode_free(w);
        return s;
    }
    w->y = array(w->own->v[NOW]);
    return LW_OK;
}

void lw_cvode_free(lw_cvode *w)
{
    if (!w->own)
        return;
    CVodeFree(&w->own->solver);
    lw_sun_free(&w->own->sun, w->own->v, N_VECTOR);
    free(w->own);
    w->own = NULL;
}

/* CVODE restarts its counters at 0. */
static void count(lw_cvode *w)
{
    long now[4] = { 0 };
    CVodeGetNumSteps(w->own->solver, &now[0]);
    CVodeGetNumErrTestFails(w->own->solver, &now[1]);
    CVodeGetNumRhsEvals(w->own->solver, &now[2]);
    CVodeGetNumJacEvals(w->own->solver, &now[3]);
    w->n_step = w->own->before[0] + now[0];
    w->n_refused = w->own->before[1] + now[1];
    w->n_rate = w->own->before[2] + now[2];
    w->n_jacobian = w->own->before[3] + now[3];
}

lw_status lw_cvode_restart(lw_cvode *w, const double *y, double first, lw_error *e)
{
    struct lw_cvode_own *own = w->own;
    if (y)
        memcpy(array(own->v[NOW]), y, sizeof(double)*(size_t)own->ode->n);
    own->sun.failed = LW_OK;
    w->events = 0;
    count(w);
    memcpy(own->before, (long[]){ w->n_step, w->n_refused, w->n_rate, w->n_jacobian }, sizeof own->before);
    if (CVodeReInit(own->solver, w->t, own->v[NOW]) != 0
        || CVodeSetInitStep(own->solver, first > 0 ? first : fmax(own->o.first, 0)) != 0)
        return lw_sun_error(&own->sun, "CVODE", w->t, e);
    return LW_OK;
}

/* ---- stepping ------------------------------------------------------------------------------------ */

/* Record the events that happened; true if one of them ends the step. */
static bool take_roots(lw_cvode *w)
{
    const lw_ode *ode = w->own->ode;
    int info[LW_EVENT_MAX];
    bool end = false;
    CVodeGetRootInfo(w->own->solver, info);
    for (int i = 0; i < ode->n_event; i++) {
        if (!info[i])
            continue;
        w->events |= 1ull << i;
        end = end || !ode->passing[i];
        if (ode->passing[i] && ode->seen)
            ode->seen(ode->context, i, w->t, w->y);
    }
    return end;
}

lw_status lw_cvode_step(lw_cvode *w, double t_end, lw_ode_stop *stop, lw_error *e)
{
    struct lw_cvode_own *own = w->own;
    double reached = w->t, ahead = w->t;
    *stop = LW_ODE_END;
    w->events = 0;
    if (t_end == w->t)
        return LW_OK;
    if (t_end < w->t)
        return lw_error_set(e, LW_E_ARG, "CVODE runs forward only");
    w->t_old = w->t;
    for (;;) {
        if (own->o.max_step > 0 && w->n_step >= own->o.max_step)
            return lw_error_set(e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", w->t, own->o.max_step);
        /* after an event, CVODE itself is already at a later time */
        bool beyond = CVodeGetCurrentTime(own->solver, &ahead) == 0 && ahead >= t_end && w->n_step > own->before[0];
        int code = beyond ? 0 : CVodeSetStopTime(own->solver, t_end);
        if (code == 0)
            code = CVode(own->solver, t_end, own->v[NOW], &reached, beyond ? CV_NORMAL : CV_ONE_STEP);
        count(w);
        if (code < 0 || (!beyond && lw_sun_stands_still(&own->sun, w->t, reached)))
            return lw_sun_error(&own->sun, "CVODE", w->t, e);
        w->t = reached;
        bool ended = code == CV_ROOT_RETURN && take_roots(w);
        if (code == CV_ROOT_RETURN && !ended && w->t < t_end)
            continue;
        *stop = ended ? LW_ODE_EVENT : w->t >= t_end ? LW_ODE_END : LW_ODE_STEP;
        return LW_OK;
    }
}

lw_status lw_cvode_dense(lw_cvode *w, double t, double *y)
{
    struct lw_cvode_own *own = w->own;
    if (t == w->t) {
        memcpy(y, w->y, sizeof(double)*(size_t)own->ode->n);
        return LW_OK;
    }
    if (CVodeGetDky(own->solver, t, 0, own->v[SCRATCH]) != 0)
        return LW_E_ARG;
    memcpy(y, array(own->v[SCRATCH]), sizeof(double)*(size_t)own->ode->n);
    return LW_OK;
}

/* mbs/ode/cvode.c - bridge to CVODE of SUNDIALS 6. */
#include "mbs/ode/cvode.h"

#include <cvode/cvode.h>
#include <cvode/cvode_proj.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/ode/sundials_internal.h"

static const lw_ode *ode_of(void *user) { return ((const lw_sun *)user)->problem; }

/* ---- callbacks ----------------------------------------------------------------------------------- */

static int rate(realtype t, N_Vector y, N_Vector dy, void *user)
{
    const lw_ode *ode = ode_of(user);
    return lw_sun_code(user, ode->rate(ode->context, t, lw_sun_array(y), lw_sun_array(dy)));
}

static int jacobian(realtype t, N_Vector y, N_Vector dy, SUNMatrix j, void *user, N_Vector a, N_Vector b, N_Vector c)
{
    (void)a, (void)b, (void)c;
    const lw_ode *ode = ode_of(user);
    SUNMatZero(j);
    return lw_sun_code(user, ode->jacobian(ode->context, t, lw_sun_array(y), lw_sun_array(dy), SUNDenseMatrix_Data(j)));
}

static int roots(realtype t, N_Vector y, realtype *g, void *user)
{
    const lw_ode *ode = ode_of(user);
    return lw_sun_code(user, ode->event(ode->context, t, lw_sun_array(y), g)) ? -1 : 0;
}

/* CVODE asks for the correction and for the projected error vector; the error vector stays unchanged */
static int project(realtype t, N_Vector y, N_Vector correction, realtype tolerance, N_Vector error, void *user)
{
    (void)tolerance, (void)error;
    const lw_ode *ode = ode_of(user);
    N_VScale(1.0, y, correction);
    int code = lw_sun_code(user, ode->project(ode->context, t, lw_sun_array(correction)));
    N_VLinearSum(1.0, correction, -1.0, y, correction);
    return code;
}

static int advance(lw_sun *s, double t_end, double *reached, int task)
{
    return CVode(s->solver, t_end, s->v[LW_SUN_NOW], reached, task);
}

static const lw_sun_calls calls = {
    .name = "CVODE", .advance = advance, .current_time = CVodeGetCurrentTime, .stop_time = CVodeSetStopTime,
    .root_info = CVodeGetRootInfo, .dense = CVodeGetDky, .free = CVodeFree,
    .count = { CVodeGetNumSteps, CVodeGetNumErrTestFails, CVodeGetNumRhsEvals, CVodeGetNumJacEvals },
    .normal = CV_NORMAL, .one_step = CV_ONE_STEP, .root_return = CV_ROOT_RETURN
};

/* ---- making -------------------------------------------------------------------------------------- */

static bool set_up(lw_sun *own, lw_cvode_method method, double t)
{
    const lw_ode *ode = own->problem;
    void *s = own->solver = CVodeCreate(method == LW_CVODE_ADAMS ? CV_ADAMS : CV_BDF, own->context);
    bool ok = s && CVodeSetErrHandlerFn(s, lw_sun_message, own) == 0;
    if (ok && CVodeInit(s, rate, t, own->v[LW_SUN_NOW]) != 0) {
        free(s);                             /* its vectors are free, and CVodeFree would free them again */
        own->solver = NULL;
        return false;
    }
    ok = ok && CVodeSetUserData(s, own) == 0 && CVodeSVtolerances(s, own->o.relative, own->v[LW_SUN_EACH]) == 0
        && CVodeSetLinearSolver(s, own->linear, own->matrix) == 0 && CVodeSetMaxNumSteps(s, -1) == 0
        && CVodeSetMaxHnilWarns(s, -1) == 0;
    ok = ok && (!ode->jacobian || CVodeSetJacFn(s, jacobian) == 0);
    ok = ok && (ode->n_event == 0 || (CVodeRootInit(s, ode->n_event, roots) == 0
        && CVodeSetRootDirection(s, own->direction) == 0 && CVodeSetNoInactiveRootWarn(s) == 0));
    ok = ok && (own->o.first <= 0.0 || CVodeSetInitStep(s, own->o.first) == 0);
    ok = ok && (own->o.greatest <= 0.0 || CVodeSetMaxStep(s, own->o.greatest) == 0);
    return ok && !own->no_room && (!ode->project || method == LW_CVODE_ADAMS || CVodeSetProjFn(s, project) == 0);
}

lw_status lw_cvode_make(lw_sundials *w, const lw_ode *ode, const lw_ode_options *o, lw_cvode_method method,
                        double t, const double *y, lw_error *e)
{
    lw_status st = lw_sun_make(w, &calls, ode, ode->n, ode->n_event, NULL, o, t, e);
    if (st != LW_OK)
        return st;
    lw_sun *s = w->own;
    s->passing = ode->passing, s->seen = ode->seen, s->context_of = ode->context;
    for (int i = 0; i < ode->n_event; i++)
        s->direction[i] = ode->direction[i];
    memcpy(lw_sun_array(s->v[LW_SUN_NOW]), y, sizeof(double)*(size_t)ode->n);
    w->y = lw_sun_array(s->v[LW_SUN_NOW]);
    return set_up(s, method, t) ? LW_OK : lw_sun_cannot_start(w, e);
}

lw_status lw_cvode_restart(lw_sundials *w, const double *y, double first, lw_error *e)
{
    lw_sun *s = w->own;
    lw_sun_restart(w, y, NULL);
    bool ok = CVodeReInit(s->solver, w->t, s->v[LW_SUN_NOW]) == 0
           && CVodeSetInitStep(s->solver, first > 0 ? first : fmax(s->o.first, 0)) == 0;
    return ok ? LW_OK : lw_sun_error(s, w->t, e);
}

/* mbs/ode/sundials_internal.h - shared by the bridges to SUNDIALS: one context per solver; its messages and the
 * status of callbacks are stored instead of printed; matrices are plain columns. */
#ifndef LW_MBS_ODE_SUNDIALS_INTERNAL_H
#define LW_MBS_ODE_SUNDIALS_INTERNAL_H

#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sunmatrix/sunmatrix_dense.h>
#include "base/real.h"
#include "base/sparse.h"
#include "base/sparse_lu.h"
#include "mbs/ode/integrate.h"

typedef struct lw_sun {
    SUNContext      context;
    SUNMatrix       matrix;
    SUNLinearSolver linear;
    lw_status       failed;              /* the status with which a callback ended the run             */
    char            message[256];        /* message of the solver                                      */
    int             still;               /* steps in a row that did not move t                         */
} lw_sun;

/* ---- linear systems: SUNDIALS has dense ones; ours skip the zeros of connected bodies -------------- */

typedef struct lw_sun_linear { lw_sparse f; bool prepared; } lw_sun_linear;

static inline SUNLinearSolver_Type lw_sun_type(SUNLinearSolver s)
{
    (void)s;
    return SUNLINEARSOLVER_DIRECT;
}

static inline int lw_sun_setup(SUNLinearSolver s, SUNMatrix a)
{
    lw_sun_linear *l = s->content;
    if (!l->prepared)
        lw_sparse_prepare(&l->f, SUNDenseMatrix_Data(a));
    l->prepared = true;
    return lw_sparse_factor(&l->f, SUNDenseMatrix_Data(a)) ? SUNLS_LUFACT_FAIL : SUNLS_SUCCESS;
}

static inline int lw_sun_solve(SUNLinearSolver s, SUNMatrix a, N_Vector x, N_Vector b, realtype tolerance)
{
    (void)a, (void)tolerance;
    lw_sparse_solve(&((lw_sun_linear *)s->content)->f, N_VGetArrayPointer(b), N_VGetArrayPointer(x));
    return SUNLS_SUCCESS;
}

static inline int lw_sun_end(SUNLinearSolver s)
{
    free(s->content);
    s->content = NULL;
    SUNLinSolFreeEmpty(s);
    return SUNLS_SUCCESS;
}

static inline SUNLinearSolver lw_sun_linear_make(int n, SUNContext context)
{
    size_t doubles = lw_sparse_doubles(n)*sizeof(double), ints = lw_sparse_ints(n)*sizeof(int);
    size_t head = (sizeof(lw_sun_linear) + 15)/16*16;
    char *room = calloc(1, head + doubles + ints);
    SUNLinearSolver s = room ? SUNLinSolNewEmpty(context) : NULL;
    if (!s) {
        free(room);
        return NULL;
    }
    lw_sparse_place(&((lw_sun_linear *)(void *)room)->f, n, (double *)(void *)(room + head),
                    (int *)(void *)(room + head + doubles));
    s->content = room;
    s->ops->gettype = lw_sun_type;
    s->ops->setup = lw_sun_setup;
    s->ops->solve = lw_sun_solve;
    s->ops->free = lw_sun_end;
    return s;
}

/* ---- large linear systems: a matrix is its values in a fixed pattern, factored by KLU -------------------- */

typedef struct lw_sun_large { const lw_columns *pattern; double *value; lw_sparse_lu *f; } lw_sun_large;

static inline double *lw_sun_values(SUNMatrix a) { return ((lw_sun_large *)a->content)->value; }
static inline SUNMatrix_ID lw_sun_id(SUNMatrix a)
{
    (void)a;
    return SUNMATRIX_CUSTOM;
}

static inline int lw_sun_zero(SUNMatrix a)
{
    const lw_sun_large *l = a->content;
    memset(l->value, 0, (size_t)l->pattern->at[l->pattern->n]*sizeof *l->value);
    return 0;
}

/* The matrix owns the memory, which the solver shares. */
static inline void lw_sun_destroy(SUNMatrix a)
{
    lw_sun_large *l = a->content;
    if (l) {
        lw_sparse_lu_free(l->f);
        free(l->value);
    }
    free(l);
    a->content = NULL;
    SUNMatFreeEmpty(a);
}

static inline int lw_sun_large_setup(SUNLinearSolver s, SUNMatrix a)
{
    (void)s;
    lw_sun_large *l = a->content;
    return lw_sparse_lu_factor(l->f, l->value) ? SUNLS_SUCCESS : SUNLS_LUFACT_FAIL;
}

static inline int lw_sun_large_solve(SUNLinearSolver s, SUNMatrix a, N_Vector x, N_Vector b, realtype tolerance)
{
    (void)s, (void)tolerance;
    double *to = N_VGetArrayPointer(x), *from = N_VGetArrayPointer(b);
    if (to != from)
        memcpy(to, from, (size_t)N_VGetLength(b)*sizeof *to);
    lw_sparse_lu_solve(((lw_sun_large *)a->content)->f, to);
    return SUNLS_SUCCESS;
}

static inline bool lw_sun_large_make(lw_sun *s, const lw_columns *pattern)
{
    s->matrix = SUNMatNewEmpty(s->context);
    if (!s->matrix)
        return false;
    s->matrix->ops->getid = lw_sun_id;
    s->matrix->ops->zero = lw_sun_zero;
    s->matrix->ops->destroy = lw_sun_destroy;
    lw_sun_large *l = s->matrix->content = calloc(1, sizeof *l);
    if (!l)
        return false;
    l->pattern = pattern;
    l->value = calloc((size_t)pattern->at[pattern->n] + 1, sizeof *l->value);
    l->f = lw_sparse_lu_create(pattern);
    s->linear = l->value && l->f ? SUNLinSolNewEmpty(s->context) : NULL;
    if (!s->linear)
        return false;
    s->linear->ops->gettype = lw_sun_type;
    s->linear->ops->setup = lw_sun_large_setup;
    s->linear->ops->solve = lw_sun_large_solve;
    s->linear->ops->free = lw_sun_end;
    return true;
}

/* pattern NULL: dense. */
static inline bool lw_sun_make(lw_sun *s, int n, const lw_columns *pattern, N_Vector *v, int n_vector)
{
    if (SUNContext_Create(NULL, &s->context) != 0)
        return false;
    for (int i = 0; i < n_vector; i++) {
        v[i] = N_VNew_Serial(n, s->context);
        if (!v[i])
            return false;
        N_VConst(0.0, v[i]);
    }
    if (pattern)
        return lw_sun_large_make(s, pattern);
    s->matrix = SUNDenseMatrix(n, n, s->context);
    s->linear = s->matrix ? lw_sun_linear_make(n, s->context) : NULL;
    return s->linear != NULL;
}

static inline void lw_sun_free(lw_sun *s, N_Vector *v, int n_vector)
{
    if (s->linear)
        SUNLinSolFree(s->linear);
    if (s->matrix)
        SUNMatDestroy(s->matrix);
    for (int i = 0; i < n_vector; i++)
        if (v[i])
            N_VDestroy(v[i]);
    if (s->context)
        SUNContext_Free(&s->context);
}

/* The status of a callback for SUNDIALS: 0 success, > 0 try a shorter step, < 0 give up. */
static inline int lw_sun_code(lw_sun *s, lw_status status)
{
    if (status == LW_OK)
        return 0;
    if (status == LW_OPEN)
        return 1;
    s->failed = status;
    return -1;
}

static inline void lw_sun_message(int code, const char *module, const char *function, char *message, void *user)
{
    (void)module, (void)function;
    if (code < 0)                        /* ignore warnings */
        snprintf(((lw_sun *)user)->message, sizeof ((lw_sun *)user)->message, "%s", message);
}

static inline void lw_sun_tolerances(const lw_ode_options *o, N_Vector each)
{
    double *v = N_VGetArrayPointer(each);
    for (int i = 0; i < (int)N_VGetLength(each); i++)
        v[i] = o->absolute_each ? o->absolute_each[i] : o->absolute;
}

/* Both solvers only warn if steps become too small to change t, and never end. */
#define LW_SUN_STILL_MAX 100

static inline bool lw_sun_stands_still(lw_sun *s, double before, double now)
{
    s->still = now == before ? s->still + 1 : 0;
    if (s->still < LW_SUN_STILL_MAX)
        return false;
    snprintf(s->message, sizeof s->message, "its steps became too short to move on: the motion is singular there, or "
             "the tolerance is below rounding");
    return true;
}

static inline lw_status lw_sun_error(const lw_sun *s, const char *solver, double t, lw_error *e)
{
    lw_status status = s->failed != LW_OK ? s->failed : LW_E_NUMERIC;
    if (status == LW_STOPPED && e && e->text[0])
        return status;                   /* in the callback's own words                                */
    return lw_error_set(e, status, "%s gave up at t = %.9g s: %s", solver, t,
                        s->failed != LW_OK ? lw_status_text(s->failed)
                        : s->message[0] ? s->message : "no reason given");
}

#endif

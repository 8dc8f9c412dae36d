/* mbs/ode/sundials.c - what the bridges to CVODE and IDA of SUNDIALS 6 share. */
#include "mbs/ode/sundials_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/sparse.h"
#include "base/sparse_lu.h"

/* ---- linear systems: SUNDIALS has dense ones; ours skip the zeros of connected bodies -------------- */

typedef struct lw_sun_linear { lw_sparse f; bool prepared; } lw_sun_linear;

static SUNLinearSolver_Type lw_sun_type(SUNLinearSolver s)
{
    (void)s;
    return SUNLINEARSOLVER_DIRECT;
}

static int lw_sun_setup(SUNLinearSolver s, SUNMatrix a)
{
    lw_sun_linear *l = s->content;
    if (!l->prepared)
        lw_sparse_prepare(&l->f, SUNDenseMatrix_Data(a));
    l->prepared = true;
    return lw_sparse_factor(&l->f, SUNDenseMatrix_Data(a)) ? SUNLS_LUFACT_FAIL : SUNLS_SUCCESS;
}

static int lw_sun_solve(SUNLinearSolver s, SUNMatrix a, N_Vector x, N_Vector b, realtype tolerance)
{
    (void)a, (void)tolerance;
    lw_sparse_solve(&((lw_sun_linear *)s->content)->f, N_VGetArrayPointer(b), N_VGetArrayPointer(x));
    return SUNLS_SUCCESS;
}

static int lw_sun_end(SUNLinearSolver s)
{
    free(s->content);
    s->content = NULL;
    SUNLinSolFreeEmpty(s);
    return SUNLS_SUCCESS;
}

static SUNLinearSolver lw_sun_linear_make(int n, SUNContext context)
{
    size_t doubles = lw_sparse_doubles(n)*sizeof(double), ints = lw_sparse_ints(n)*sizeof(int);
    size_t head = (sizeof(lw_sun_linear) + 15)/16*16;
    char *room = calloc(1, head + doubles + ints);
    SUNLinearSolver s = room ? SUNLinSolNewEmpty(context) : NULL;
    if (!s) {
        free(room);
        return NULL;
    }
    lw_sparse_place(&((lw_sun_linear *)(void *)room)->f, n, (double *)(void *)(room + head), (int *)(void *)(room + head + doubles));
    s->content = room;
    s->ops->gettype = lw_sun_type;
    s->ops->setup = lw_sun_setup;
    s->ops->solve = lw_sun_solve;
    s->ops->free = lw_sun_end;
    return s;
}

/* ---- large linear systems: a matrix is its values in a fixed pattern, factored by KLU -------------------- */

typedef struct lw_sun_large { const lw_columns *pattern; double *value; lw_sparse_lu *f; lw_status *failed; } lw_sun_large;

double *lw_sun_values(SUNMatrix a) { return ((lw_sun_large *)a->content)->value; }
static SUNMatrix_ID lw_sun_id(SUNMatrix a)
{
    (void)a;
    return SUNMATRIX_CUSTOM;
}

static int lw_sun_zero(SUNMatrix a)
{
    const lw_sun_large *l = a->content;
    memset(l->value, 0, (size_t)l->pattern->at[l->pattern->n]*sizeof *l->value);
    return 0;
}

/* The matrix owns the memory, which the solver shares. */
static void lw_sun_destroy(SUNMatrix a)
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

static int lw_sun_large_setup(SUNLinearSolver s, SUNMatrix a)
{
    (void)s;
    lw_sun_large *l = a->content;
    lw_status status = lw_sparse_lu_factor(l->f, l->value);
    if (status != LW_E_MEMORY)
        return status == LW_OK ? SUNLS_SUCCESS : SUNLS_LUFACT_FAIL;
    *l->failed = status;
    return SUNLS_MEM_FAIL;
}

static int lw_sun_large_solve(SUNLinearSolver s, SUNMatrix a, N_Vector x, N_Vector b, realtype tolerance)
{
    (void)s, (void)tolerance;
    double *to = N_VGetArrayPointer(x), *from = N_VGetArrayPointer(b);
    if (to != from)
        memcpy(to, from, (size_t)N_VGetLength(b)*sizeof *to);
    lw_sparse_lu_solve(((lw_sun_large *)a->content)->f, to);
    return SUNLS_SUCCESS;
}

static bool lw_sun_large_make(lw_sun *s, const lw_columns *pattern)
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
    l->failed = &s->failed;
    l->value = calloc((size_t)pattern->at[pattern->n] + 1, sizeof *l->value);
    l->f = lw_sparse_lu_create(pattern, false, false);
    s->linear = l->value && l->f ? SUNLinSolNewEmpty(s->context) : NULL;
    if (!s->linear)
        return false;
    s->linear->ops->gettype = lw_sun_type;
    s->linear->ops->setup = lw_sun_large_setup;
    s->linear->ops->solve = lw_sun_large_solve;
    s->linear->ops->free = lw_sun_end;
    return true;
}

/* ---- making ------------------------------------------------------------------------------------------------- */

/* SUNDIALS 6 makes its vectors as copies of ours, and writes into a copy without a look whether there was memory for it.  So it gets the
 * spare vector then, and the solver is not used. */
typedef struct lw_sun_content { struct _N_VectorContent_Serial serial; lw_sun *own; } lw_sun_content;

static lw_sun *owner_of(N_Vector v) { return ((lw_sun_content *)v->content)->own; }

static bool set_owner(N_Vector v, lw_sun *own)
{
    lw_sun_content *c = realloc(v->content, sizeof *c);
    if (!c)
        return false;
    c->own = own;
    v->content = c;
    return true;
}

static N_Vector copy_vector(N_Vector from);
static N_Vector copy_empty(N_Vector from);
static void free_vector(N_Vector v);

static N_Vector make_vector(lw_sun *own, bool empty)
{
    N_Vector v = empty ? N_VNewEmpty_Serial(own->n, own->context) : N_VNew_Serial(own->n, own->context);
    if (v && !set_owner(v, own)) {
        N_VDestroy_Serial(v);
        v = NULL;
    }
    if (v) {
        v->ops->nvclone = copy_vector;
        v->ops->nvcloneempty = copy_empty;
        v->ops->nvdestroy = free_vector;
    }
    return v;
}

static N_Vector copy_vector(N_Vector from)
{
    lw_sun *own = owner_of(from);
    N_Vector v = make_vector(own, false);
    own->no_room |= !v;
    return v ? v : own->v[LW_SUN_SPARE];
}

static void free_vector(N_Vector v)
{
    lw_sun *own = owner_of(v);
    if (v != own->v[LW_SUN_SPARE] && v != own->v[LW_SUN_EMPTY])
        N_VDestroy_Serial(v);
}

/* One without an array, which differences for a Jacobian matrix use for a while. */
static N_Vector copy_empty(N_Vector from) { return owner_of(from)->v[LW_SUN_EMPTY]; }

/* CVODE copies its matrix once, without a look whether there was memory for the copy, which is made before. */
typedef struct lw_sun_dense { struct _SUNMatrixContent_Dense dense; lw_sun *own; } lw_sun_dense;

static SUNMatrix copy_matrix(SUNMatrix from)
{
    lw_sun *own = ((lw_sun_dense *)from->content)->own;
    SUNMatrix saved = own->saved;
    own->saved = NULL;
    return saved;
}

static bool make_matrices(lw_sun *s)
{
    s->matrix = SUNDenseMatrix(s->n, s->n, s->context);
    s->saved = s->matrix ? SUNDenseMatrix(s->n, s->n, s->context) : NULL;
    lw_sun_dense *c = s->saved ? realloc(s->matrix->content, sizeof *c) : NULL;
    if (!c)
        return false;
    c->own = s;
    s->matrix->content = c;
    s->matrix->ops->clone = copy_matrix;
    return true;
}

/* SUNDIALS 6.4 allocates four blocks for a context and does not check two of these calls (SUNHashMap_New, SUNLogger_Create).  malloc of
 * the GNU C library keeps small blocks that a thread has freed for the next calls of this thread.  So blocks of these sizes are
 * allocated and freed first: the calls of SUNDIALS then get them. */
static bool make_context(lw_sun *s)
{
    static const size_t size[] = { 96, 16, 64, 32 };     /* logger, its table of files, the entries of it, context */
    enum { N = sizeof size/sizeof *size };
    void *volatile block[N];
    bool ok = true;
    for (int i = 0; i < N; i++)
        ok &= (block[i] = malloc(size[i])) != NULL;
    for (int i = 0; i < N; i++)
        free(block[i]);
    return ok && SUNContext_Create(NULL, &s->context) == 0;
}

static bool make_parts(lw_sun *s, const lw_columns *pattern)
{
    if (!make_context(s))
        return false;
    for (int i = 0; i < LW_SUN_VECTORS; i++) {
        s->v[i] = make_vector(s, i == LW_SUN_EMPTY);
        if (!s->v[i])
            return false;
        if (i != LW_SUN_EMPTY)
            N_VConst(0.0, s->v[i]);
    }
    if (pattern)
        return lw_sun_large_make(s, pattern);
    s->linear = make_matrices(s) ? lw_sun_linear_make(s->n, s->context) : NULL;
    return s->linear != NULL;
}

lw_status lw_sun_make(lw_sundials *w, const lw_sun_calls *call, const void *problem, int n, int n_event,
                      const lw_columns *pattern, const lw_ode_options *o, double t, lw_error *e)
{
    *w = (lw_sundials){ .t = t, .t_old = t };
    if (n < 1 || n_event < 0 || n_event > LW_EVENT_MAX || o->fixed > 0.0)
        return lw_error_set(e, LW_E_ARG, "%s needs at least one variable, 0 to %d events and no fixed step", call->name, LW_EVENT_MAX);
    lw_sun *s = w->own = calloc(1, sizeof *s);
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %s", call->name);
    s->call = call;
    s->problem = problem;
    s->n = n;
    s->n_event = n_event;
    s->o = *o;
    if (!make_parts(s, pattern))
        return lw_sun_cannot_start(w, e);
    for (int i = 0; i < n; i++)
        lw_sun_array(s->v[LW_SUN_EACH])[i] = o->absolute_each ? o->absolute_each[i] : o->absolute;
    return LW_OK;
}

lw_status lw_sun_cannot_start(lw_sundials *w, lw_error *e)
{
    const char *why = w->own->message;
    lw_status st = lw_error_set(e, *why ? LW_E_ARG : LW_E_MEMORY, "%s cannot start: %s", w->own->call->name, *why ? why : "out of memory");
    lw_sundials_free(w);
    return st;
}

void lw_sundials_free(lw_sundials *w)
{
    lw_sun *s = w->own;
    if (!s)
        return;
    if (s->solver)
        s->call->free(&s->solver);
    if (s->linear)
        SUNLinSolFree(s->linear);
    if (s->matrix)
        SUNMatDestroy(s->matrix);
    if (s->saved)
        SUNMatDestroy(s->saved);
    for (int i = 0; i < LW_SUN_VECTORS; i++)
        if (s->v[i])
            N_VDestroy_Serial(s->v[i]);
    if (s->context)
        SUNContext_Free(&s->context);
    free(s);
    w->own = NULL;
}

int lw_sun_code(lw_sun *s, lw_status status)
{
    if (status == LW_OK)
        return 0;
    if (status == LW_OPEN)
        return 1;
    s->failed = status;
    return -1;
}

void lw_sun_message(int code, const char *module, const char *function, char *message, void *user)
{
    (void)module, (void)function;
    if (code < 0)                        /* ignore warnings */
        snprintf(((lw_sun *)user)->message, sizeof ((lw_sun *)user)->message, "%s", message);
}

lw_status lw_sun_error(const lw_sun *s, double t, lw_error *e)
{
    lw_status status = s->failed != LW_OK ? s->failed : LW_E_NUMERIC;
    if (status == LW_STOPPED && e && e->text[0])
        return status;                   /* in the callback's own words                                */
    return lw_error_set(e, status, "%s gave up at t = %.9g s: %s", s->call->name, t,
                        s->failed != LW_OK ? lw_status_text(s->failed)
                        : s->message[0] ? s->message : "no reason given");
}

/* ---- stepping ------------------------------------------------------------------------------------------------ */

/* The solvers restart their counters at 0. */
static void count(lw_sundials *w)
{
    long *const to[4] = { &w->n_step, &w->n_refused, &w->n_rate, &w->n_jacobian };
    for (int i = 0; i < 4; i++) {
        long now = 0;
        w->own->call->count[i](w->own->solver, &now);
        *to[i] = w->own->before[i] + now;
    }
}

void lw_sun_restart(lw_sundials *w, const double *y, const double *dy)
{
    lw_sun *s = w->own;
    size_t bytes = sizeof(double)*(size_t)s->n;
    if (y)
        memcpy(lw_sun_array(s->v[LW_SUN_NOW]), y, bytes);
    if (dy)
        memcpy(lw_sun_array(s->v[LW_SUN_RATE]), dy, bytes);
    s->failed = LW_OK;
    w->events = 0;
    count(w);
    memcpy(s->before, (long[]){ w->n_step, w->n_refused, w->n_rate, w->n_jacobian }, sizeof s->before);
}

/* Record the events that happened; true if one of them ends the step. */
static bool take_roots(lw_sundials *w)
{
    const lw_sun *s = w->own;
    int info[LW_EVENT_MAX];
    bool end = false;
    s->call->root_info(s->solver, info);
    for (int i = 0; i < s->n_event; i++) {
        if (!info[i])
            continue;
        w->events |= 1ull << i;
        end = end || !s->passing[i];
        if (s->passing[i] && s->seen)
            s->seen(s->context_of, i, w->t, w->y);
    }
    return end;
}

/* Both solvers only warn if steps become too small to change t, and never end. */
#define LW_SUN_STILL_MAX 100

static bool lw_sun_stands_still(lw_sun *s, double before, double now)
{
    s->still = now == before ? s->still + 1 : 0;
    if (s->still < LW_SUN_STILL_MAX)
        return false;
    snprintf(s->message, sizeof s->message, "its steps became too short to move on: the motion is singular there, or "
             "the tolerance is below rounding");
    return true;
}

lw_status lw_sundials_step(lw_sundials *w, double t_end, lw_ode_stop *stop, lw_error *e)
{
    lw_sun *s = w->own;
    const lw_sun_calls *call = s->call;
    double reached = w->t, ahead = w->t;
    *stop = LW_ODE_END;
    w->events = 0;
    if (lw_ode_at_end(w->t, t_end)) {
        w->t = t_end;
        return LW_OK;
    }
    if (t_end < w->t)
        return lw_error_set(e, LW_E_ARG, "%s runs forward only", call->name);
    w->t_old = w->t;
    for (;;) {
        if (s->o.max_step > 0 && w->n_step >= s->o.max_step)
            return lw_error_set(e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", w->t, s->o.max_step);
        /* after an event, the solver itself is already at a later time */
        bool beyond = call->current_time(s->solver, &ahead) == 0 && ahead >= t_end && w->n_step > s->before[0];
        int code = beyond ? 0 : call->stop_time(s->solver, t_end);
        if (code == 0)
            code = call->advance(s, t_end, &reached, beyond ? call->normal : call->one_step);
        count(w);
        if (code < 0 || (!beyond && lw_sun_stands_still(s, w->t, reached)))
            return lw_sun_error(s, w->t, e);
        w->t = reached;
        bool ended = code == call->root_return && take_roots(w);
        if (code == call->root_return && !ended && w->t < t_end)
            continue;
        *stop = ended ? LW_ODE_EVENT : w->t >= t_end ? LW_ODE_END : LW_ODE_STEP;
        return LW_OK;
    }
}

lw_status lw_sundials_dense(lw_sundials *w, double t, double *y)
{
    lw_sun *s = w->own;
    size_t bytes = sizeof(double)*(size_t)s->n;
    if (t != w->t && s->call->dense(s->solver, t, 0, s->v[LW_SUN_SCRATCH]) != 0)
        return LW_E_ARG;
    memcpy(y, t == w->t ? w->y : lw_sun_array(s->v[LW_SUN_SCRATCH]), bytes);
    return LW_OK;
}

lw_status lw_sundials_slope(lw_sundials *w, double *dy)
{
    lw_sun *s = w->own;
    if (s->call->dense(s->solver, w->t, 1, s->v[LW_SUN_SCRATCH]) != 0)
        return LW_E_ARG;
    memcpy(dy, lw_sun_array(s->v[LW_SUN_SCRATCH]), sizeof(double)*(size_t)s->n);
    return LW_OK;
}

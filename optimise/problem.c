#include "optimise/problem.h"

#include <stdlib.h>
#include <string.h>

#include "optimise/family.h"
#include "optimise/problem_internal.h"

lw_fit_spec lw_fit_spec_default(void)
{
    return (lw_fit_spec){ .task = LW_TASK_PATH, .timing = LW_TIMING_FREE, .datum = LW_DATUM_FREE,
                          .a = 1, .b = 1 };
}

const char *lw_problem_variable(const lw_problem *p, int i)
{
    if (i < p->n_dim)
        return p->plan.dim[i].name;
    return i == p->i_input0 ? "input0" : "tool0";
}

int lw_problem_index(const lw_problem *p, const char *name)
{
    for (int i = 0; i < p->n_var; i++)
        if (strcmp(lw_problem_variable(p, i), name) == 0)
            return i;
    return -1;
}

void lw_problem_to_dims(const lw_problem *p, const double *x, double *dim)
{
    for (int i = 0; i < p->n_dim; i++)
        dim[i] = p->plan.dim[i].kind == LW_DIM_ANGLE ? x[i] : p->unit*x[i];
    dim[p->plan.i_x0] += p->origin.x;
    dim[p->plan.i_y0] += p->origin.y;
}

void lw_problem_from_dims(const lw_problem *p, const double *dim, double *x)
{
    for (int i = 0; i < p->n_dim; i++)
        x[i] = p->plan.dim[i].kind == LW_DIM_ANGLE ? dim[i] : dim[i]/p->unit;
    x[p->plan.i_x0] = (dim[p->plan.i_x0] - p->origin.x)/p->unit;
    x[p->plan.i_y0] = (dim[p->plan.i_y0] - p->origin.y)/p->unit;
}

/* ---- making ------------------------------------------------------------------------------- */

/* "+r3+r4-r1-r2" into coefficients by variable. */
static void linear_row(const lw_problem *p, const char *text, double *row)
{
    while (*text) {
        double sign = *text++ == '-' ? -1 : 1;
        char name[16] = "";
        for (size_t k = 0; *text && *text != '+' && *text != '-' && k + 1 < sizeof name; text++)
            name[k++] = *text;
        int i = lw_problem_index(p, name);
        if (i >= 0)
            row[i] += sign;
    }
}

static lw_status make_stations(const lw_target *t, lw_problem *p, lw_error *e)
{
    size_t n = p->n = t->n;
    double *a = calloc(n*9 + 1, sizeof *a), sum = 0, w = 0;
    if (!a)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", n);
    p->store = a;
    p->x = a; p->y = a + n; p->w = a + 2*n; p->c = a + 3*n; p->s = a + 4*n; p->angle = a + 5*n;
    p->theta = t->theta ? a + 6*n : NULL;
    p->wa = a + 7*n; p->wb = a + 8*n;
    p->origin = lw_v2(0, 0);
    for (size_t i = 0; t->x && i < n; i++) {
        w += t->weight[i];
        p->origin.x += t->weight[i]*(t->x[i] - t->x[0]);
        p->origin.y += t->weight[i]*(t->y[i] - t->y[0]);
    }
    if (t->x)
        p->origin = lw_v2(t->x[0] + p->origin.x/w, t->y[0] + p->origin.y/w);
    for (size_t i = 0; t->x && i < n; i++)
        sum += t->weight[i]/w*(pow(t->x[i] - p->origin.x, 2) + pow(t->y[i] - p->origin.y, 2));
    p->unit = sum > 0 ? sqrt(sum) : 1;
    for (size_t i = 0; i < n; i++) {
        p->x[i] = t->x ? (t->x[i] - p->origin.x)/p->unit : 0;
        p->y[i] = t->x ? (t->y[i] - p->origin.y)/p->unit : 0;
        p->w[i] = t->weight[i]*(p->timing == LW_TIMING_NONE ? 0.5 : 1);   /* each way one half    */
        if (p->theta)
            p->theta[i] = t->theta[i];
        p->angle[i] = t->angle ? t->angle[i] : 0;
        p->c[i] = cos(p->angle[i]);
        p->s[i] = sin(p->angle[i]);
    }
    return LW_OK;
}

static lw_status make_plan(const lw_type *type, lw_problem *p, lw_error *e)
{
    lw_linkage k;
    lw_type_linkage(type, &k);
    if (p->task == LW_TASK_FUNCTION)                       /* the output is the link at the ground   */
        k.tracer[0].link = 3;
    lw_status s = lw_plan_make(&k, (lw_want){ .tracers = 1, .all_joints = true }, &p->plan, e);
    if (s != LW_OK)
        return s;
    p->n_dim = p->n_var = p->plan.n_dim;
    p->i_input0 = p->timing == LW_TIMING_PRESCRIBED ? p->n_var++ : -1;
    p->i_tool0 = p->theta ? p->n_var++ : -1;
    return LW_OK;
}

/* Limits of link sizes relative to the path when nobody gave any: 1/1000 to 10 diagonals. */
static void default_range(const lw_target *t, const lw_fit_spec *s, lw_fit_spec *out)
{
    double d = t->x && t->size > 0 ? t->size : 1;
    *out = *s;
    if (!(s->length_hi > 0)) {
        out->length_lo = t->x ? 1e-3*d : 0.02;       /* of a function: in frame lengths           */
        out->length_hi = t->x ? 10*d : 50;
    }
    if (!(s->position_hi > s->position_lo)) {
        out->position_lo = -INFINITY;
        out->position_hi = INFINITY;
    }
}

static lw_status bad_bound(lw_error *e, const char *name, double lo, double hi)
{
    return lw_error_set(e, LW_E_ARG, "bounds of %s exclude everything: %g to %g; the lower end must "
                        "not exceed the upper, and a length must be able to be positive", name, lo, hi);
}

static void fix(lw_problem *p, int i, double value)
{
    if (i >= 0)
        p->lo[i] = p->hi[i] = value;
}

static bool is_coordinate_free(const lw_fit_spec *s)
{
    return !isfinite(s->position_lo) && !isfinite(s->position_hi);
}

static void range_of(const lw_problem *p, const lw_fit_spec *s, const lw_target *t, int i)
{
    lw_problem *q = (lw_problem *)p;
    double lo = -INFINITY, hi = INFINITY;
    if (i < p->n_dim && p->plan.dim[i].kind == LW_DIM_LENGTH) {
        lo = s->length_lo/p->unit;
        hi = s->length_hi/p->unit;
    } else if (i < p->n_dim && p->plan.dim[i].kind == LW_DIM_COORDINATE) {
        double shift = i == p->plan.i_x0 ? p->origin.x : i == p->plan.i_y0 ? p->origin.y : 0;
        double reach = 10*(t->x && t->size > 0 ? t->size : 1)/p->unit;
        lo = is_coordinate_free(s) ? -reach : (s->position_lo - shift)/p->unit;
        hi = is_coordinate_free(s) ? reach : (s->position_hi - shift)/p->unit;
    }
    q->lo[i] = lo;
    q->hi[i] = hi;
}

static lw_status named_bound(lw_problem *p, const lw_bound *b, lw_error *e)
{
    int i = lw_problem_index(p, b->name);
    if (i < 0)
        return LW_OK;                                        /* a name of another type's dimension    */
    bool angle = i >= p->n_dim || p->plan.dim[i].kind == LW_DIM_ANGLE;
    double shift = i == p->plan.i_x0 ? p->origin.x : i == p->plan.i_y0 ? p->origin.y : 0;
    p->lo[i] = angle ? b->lo : (b->lo - shift)/p->unit;
    p->hi[i] = angle ? b->hi : (b->hi - shift)/p->unit;
    if (!(b->lo <= b->hi))
        return bad_bound(e, b->name, b->lo, b->hi);
    return LW_OK;
}

static lw_status make_bounds(const lw_target *t, const lw_fit_spec *spec, lw_problem *p, lw_error *e)
{
    lw_fit_spec s;
    default_range(t, spec, &s);
    if (!(s.length_lo <= s.length_hi) || s.length_lo < 0)
        return bad_bound(e, "the lengths", s.length_lo, s.length_hi);
    for (int i = 0; i < p->n_var; i++)
        range_of(p, &s, t, i);
    if (p->datum != LW_DATUM_FREE)
        fix(p, p->i_input0, 0);
    for (int i = 0; i < s.n_bound; i++) {
        lw_status st = named_bound(p, &s.bound[i], e);
        if (st != LW_OK)
            return st;
    }
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH) {
            if (!(p->hi[i] > 0))
                return bad_bound(e, p->plan.dim[i].name, p->lo[i]*p->unit, p->hi[i]*p->unit);
            p->lo[i] = fmax(p->lo[i], 1e-9*fmin(1, p->hi[i]));    /* a link has a length          */
        }
    if (p->task == LW_TASK_FUNCTION) {                       /* place, size, tracer do not matter     */
        static const char *const idle[] = { "x0", "y0", "theta0", "cy" };
        for (int k = 0; k < 4; k++)
            fix(p, lw_problem_index(p, idle[k]), 0);
        fix(p, lw_problem_index(p, "cx"), 1);
        if (!(spec->length_hi > 0))                          /* else any size in that range will do */
            fix(p, lw_problem_index(p, p->family->shape[0]), 1);
    }
    return LW_OK;
}

static lw_status check_task(const lw_target *t, const lw_fit_spec *s, const lw_type *type, lw_error *e)
{
    if (t->n < 2)
        return lw_error_set(e, LW_E_ARG, "one point only: a linkage is found for two points or more");
    if (s->task != LW_TASK_FUNCTION && t->x && !(t->size > 0))
        return lw_error_set(e, LW_E_ARG, "all points are at one place: a path needs some extent");
    if (s->task != LW_TASK_FUNCTION && !t->x)
        return lw_error_set(e, LW_E_ARG, "the target has no columns x and y, which a path needs; "
                            "for input and output angles use the function task");
    if (s->task != LW_TASK_PATH && !t->theta)
        return lw_error_set(e, LW_E_ARG, "the target has no column theta (tool or output angle), "
                            "which the %s task needs",
                            s->task == LW_TASK_MOTION ? "motion" : "function");
    bool timed = s->timing == LW_TIMING_PRESCRIBED || s->task == LW_TASK_FUNCTION;
    if (timed && !t->angle)
        return lw_error_set(e, LW_E_ARG, "prescribed timing needs a column angle (input angle) in the "
                            "target; without one use free timing");
    if (type->input_is_slider && timed)
        return lw_error_set(e, LW_E_KIND, "its input is a slider, which has no crank angle to "
                            "prescribe");
    if (s->task == LW_TASK_FUNCTION && type->letters[3] == 'P')
        return lw_error_set(e, LW_E_KIND, "its output slides and has no angle");
    return LW_OK;
}

lw_status lw_problem_make(const lw_target *t, const lw_fit_spec *s, const lw_family *family,
                          double mode, int sense, lw_problem *p, lw_error *e)
{
    memset(p, 0, sizeof *p);
    const lw_type *type = lw_type_find(family->type);
    if (!type)
        return lw_error_set(e, LW_E_KIND, "no linkage type %s", family->type);
    lw_status st = check_task(t, s, type, e);
    if (st != LW_OK)
        return st;
    p->family = family;
    p->task = s->task;
    p->timing = s->task == LW_TASK_FUNCTION ? LW_TIMING_PRESCRIBED : s->timing;
    p->datum = s->datum;
    p->turns = family->turns;
    p->sense = sense < 0 ? -1 : 1;
    p->closed = t->closed;
    for (int d = 0; d < LW_DYAD_MAX; d++)
        p->mode[d] = mode;
    if ((st = make_stations(t, p, e)) != LW_OK)
        return st;
    if (p->task == LW_TASK_PATH)
        p->theta = NULL;
    if ((st = make_plan(type, p, e)) != LW_OK || (st = make_bounds(t, s, p, e)) != LW_OK) {
        lw_problem_free(p);
        return st;
    }
    /* f counts in units of the scaled target; the user's objective is scale * f */
    p->scale = p->task == LW_TASK_FUNCTION ? 1 : s->a*p->unit*p->unit;
    p->a = p->task == LW_TASK_FUNCTION ? 0 : 1;
    p->b = p->task == LW_TASK_PATH ? 0 : p->task == LW_TASK_FUNCTION ? s->b : s->b/p->scale;
    for (size_t i = 0; i < p->n; i++) {
        p->wa[i] = sqrt(p->a*p->w[i]);
        p->wb[i] = sqrt(p->b*p->w[i]);
    }
    p->min_transmission = s->min_transmission;
    p->max_acceleration = type->input_is_slider ? s->max_acceleration*p->unit       /* [1/m]      */
                                                : s->max_acceleration/p->unit;
    for (int j = 0; j < 4 && family->linear[j]; j++)
        linear_row(p, family->linear[j], p->linear[p->n_linear++]);
    return LW_OK;
}

void lw_problem_free(lw_problem *p)
{
    free(p->store);
    p->store = NULL;
}

/* ---- scratch ------------------------------------------------------------------------------ */

static size_t lane_count(const lw_problem *p)
{
    return p->n + (p->timing == LW_TIMING_NONE ? LW_CURVE_SAMPLES : 0);
}

int lw_problem_component_count(const lw_problem *p)
{
    return p->task == LW_TASK_PATH ? 2 : p->task == LW_TASK_MOTION ? 3 : 1;
}

/* Hand out 64-byte aligned pieces; with base NULL it only counts. */
static void *piece(char *base, size_t *at, size_t bytes)
{
    size_t here = *at;
    *at = (*at + bytes + 63) & ~(size_t)63;
    return base ? base + here : NULL;
}

static size_t lay_out(const lw_problem *p, lw_work *w, char *base)
{
    size_t at = (sizeof *w + 63) & ~(size_t)63;
    size_t lanes = lane_count(p), ld = (lanes + 7) & ~(size_t)7, v = sizeof(double);
    size_t m = LW_CURVE_SAMPLES;
    w->n = p->n;
    w->n_lane = lanes;
    w->ld = ld;
    w->n_row = lw_problem_component_count(p);
    double **lane_arrays[] = { &w->phase, &w->input, &w->rate, &w->normal_x, &w->normal_y,
                               &w->by_input, &w->c, &w->s, &w->jac.x, &w->jac.y, &w->jac.u, &w->jac.v,
                               &w->jac.margin, &w->jac.tx, &w->jac.ty, &w->jac.tt };
    for (size_t i = 0; i < sizeof lane_arrays/sizeof *lane_arrays; i++)
        *lane_arrays[i] = piece(base, &at, ld*v);
    w->mode = piece(base, &at, ld*v*(size_t)(p->plan.n_dyad > 0 ? p->plan.n_dyad : 1));
    w->jac.jx = piece(base, &at, ld*v*(size_t)p->n_dim);
    w->jac.jy = piece(base, &at, ld*v*(size_t)p->n_dim);
    w->jac.jt = p->theta ? piece(base, &at, ld*v*(size_t)p->n_dim) : NULL;
    w->jac.ld = ld;
    if (!p->theta)
        w->jac.tt = NULL;
    w->row = piece(base, &at, ld*v*(size_t)(w->n_row*p->n_var));
    w->res = piece(base, &at, ld*v*(size_t)w->n_row);
    double **curve[] = { &w->turn_c, &w->turn_s, &w->curve_x, &w->curve_y, &w->curve_m,
                         &w->curve_u, &w->curve_v,
                         &w->foot_x, &w->foot_y, &w->turn, &w->turn_mode };
    for (size_t i = 0; i < sizeof curve/sizeof *curve; i++)
        *curve[i] = piece(base, &at, m*v);
    size_t poses = ld > m ? ld : m, g = lw_problem_constraint_count(p) + 1;
    double **pose[] = { &w->pose_c, &w->pose_s, &w->pose_x, &w->pose_y, &w->pose_u, &w->pose_v,
                        &w->pose.x, &w->pose.y, &w->pose.u, &w->pose.v, &w->pose.margin };
    for (size_t i = 0; i < sizeof pose/sizeof *pose; i++)
        *pose[i] = piece(base, &at, poses*v);
    w->pose.jx = piece(base, &at, poses*v*(size_t)p->n_dim);
    w->pose.jy = piece(base, &at, poses*v*(size_t)p->n_dim);
    w->pose.jt = w->pose.tt = NULL;
    w->pose.ld = poses;
    w->g_now = piece(base, &at, g*v);
    w->g_up = piece(base, &at, g*v);
    w->g_down = piece(base, &at, g*v);
    w->cost = piece(base, &at, p->n*(LW_CURVE_SAMPLES + 1)*v);
    w->best = piece(base, &at, 2*(LW_CURVE_SAMPLES + 1)*v);
    w->from = piece(base, &at, p->n*(LW_CURVE_SAMPLES + 1)*sizeof(short));
    w->order = piece(base, &at, 2*p->n*sizeof(short));
    w->try_theta = piece(base, &at, 3*ld*v);
    w->pool = piece(base, &at, 3*ld*v);
    w->slide = piece(base, &at, ld*v*(size_t)p->n_var);
    w->keep_theta = piece(base, &at, ld*v);
    w->best_theta = piece(base, &at, ld*v);
    w->slip = piece(base, &at, ld*v);
    w->tie = piece(base, &at, ld*sizeof(bool));
    w->batch = piece(base, &at, lw_batch_work_size(&p->plan));
    return at;
}

size_t lw_problem_work_size(const lw_problem *p)
{
    lw_work w;
    return lay_out(p, &w, NULL);
}

void lw_problem_work_init(const lw_problem *p, void *work)
{
    lw_work *w = work;
    memset(work, 0, lay_out(p, w, NULL));         /* lanes beyond the last stay zero in sums        */
    lay_out(p, w, work);
    for (int j = 0; j < LW_CURVE_SAMPLES; j++) {
        w->turn[j] = 2*LW_PI*(j + (p->turns ? 0 : 0.5))/LW_CURVE_SAMPLES;
        w->turn_c[j] = cos(w->turn[j]);
        w->turn_s[j] = sin(w->turn[j]);
    }
    w->least_margin = !p->turns && p->timing != LW_TIMING_PRESCRIBED ? -1e-9 : 0;
}

/* ---- evaluation --------------------------------------------------------------------------- */

/* Lanes first .. last-1, all in one assembly mode. */
static void lanes_of_mode(const lw_problem *p, const double *x, lw_work *w, size_t first, size_t last,
                          const double *mode)
{
    lw_lanes in = { .n = last - first, .c = w->c + first, .s = w->s + first, .dim = x, .mode = mode };
    lw_jacobian j = w->jac;
    double **each[] = { &j.x, &j.y, &j.u, &j.v, &j.margin, &j.jx, &j.jy, &j.jt, &j.tx, &j.ty, &j.tt };
    for (size_t i = 0; i < sizeof each/sizeof *each; i++)
        if (*each[i])
            *each[i] += first;
    lw_batch_jacobian(&p->plan, &in, 0, w->batch, &j);
}

/* A circuit through both modes: run by run of equal mode; then derivatives by the phase. */
static void lanes_of_circuit(const lw_problem *p, const double *x, lw_work *w)
{
    for (size_t first = 0, k = 1; k <= w->n_lane; k++)
        if (k == w->n_lane || w->mode[k] != w->mode[first]) {
            lanes_of_mode(p, x, w, first, k, w->mode + first);
            first = k;
        }
    for (size_t k = 0; k < w->n_lane; k++) {
        w->jac.tx[k] *= w->rate[k];
        w->jac.ty[k] *= w->rate[k];
        if (w->jac.tt)
            w->jac.tt[k] *= w->rate[k];
    }
}

bool lw_problem_lanes(const lw_problem *p, const double *x, lw_work *w)
{
    double least = 1;
    if (p->turns || p->timing == LW_TIMING_PRESCRIBED)
        lanes_of_mode(p, x, w, 0, w->n_lane, p->mode);
    else
        lanes_of_circuit(p, x, w);
    for (size_t k = 0; k < w->n_lane; k++)
        least = fmin(least, w->jac.margin[k]);
    return least >= w->least_margin;
}

bool lw_problem_turn_stations(const lw_problem *p, const double *x, lw_work *w)
{
    if (!lw_circuit_find(p, x, w))
        return false;
    bool samples_stand = p->turns;                    /* their inputs are those of the turn       */
    size_t n = samples_stand ? p->n : w->n_lane, rest = w->n_lane - n;
    lw_circuit_inputs(p, w, n, w->phase, w->c, w->s, w->mode, w->input, w->rate);
    memcpy(w->c + n, w->turn_c, sizeof *w->c*rest);
    memcpy(w->s + n, w->turn_s, sizeof *w->s*rest);
    return true;
}

void lw_problem_prescribe(const lw_problem *p, const double *x, lw_work *w)
{
    double first = x[p->i_input0] - (p->datum == LW_DATUM_PLANE ? x[p->plan.i_theta0] : 0);
    double c = cos(first), s = sin(first);
    for (size_t k = 0; k < p->n; k++) {
        w->c[k] = c*p->c[k] - s*p->s[k];
        w->s[k] = s*p->c[k] + c*p->s[k];
        w->input[k] = first + p->angle[k];
    }
}

/* Residuals of station k: what f squares and adds. */
static void station_residuals(const lw_problem *p, const double *x, lw_work *w)
{
    const lw_jacobian *j = &w->jac;
    int row = 0;
    if (p->task != LW_TASK_FUNCTION) {
        for (size_t k = 0; k < p->n; k++) {
            w->res[k] = p->wa[k]*(j->x[k] - p->x[k]);
            w->res[w->ld + k] = p->wa[k]*(j->y[k] - p->y[k]);
        }
        row = 2;
    }
    if (p->theta)
        for (size_t k = 0; k < p->n; k++) {
            double turn = atan2(j->v[k], j->u[k]) + x[p->i_tool0] - p->theta[k];
            w->res[(size_t)row*w->ld + k] = p->wb[k]*remainder(turn, 2*LW_PI);
        }
}

/* One row of derivatives: those of the plan, and by input0 and tool0. */
static void component_rows(const lw_problem *p, lw_work *w, int row, const double *by_dim,
                           const double *by_input, const double *weight, bool angle)
{
    size_t ld = w->ld, n = p->n;
    double *base = w->row + (size_t)row*(size_t)p->n_var*ld;
    for (int d = 0; d < p->n_dim; d++)
        for (size_t k = 0; k < n; k++)
            base[(size_t)d*ld + k] = by_dim[(size_t)d*w->jac.ld + k]*weight[k];
    for (size_t k = 0; p->i_input0 >= 0 && k < n; k++)
        base[(size_t)p->i_input0*ld + k] = by_input[k]*weight[k];
    for (size_t k = 0; p->i_input0 >= 0 && p->datum == LW_DATUM_PLANE && k < n; k++)
        base[(size_t)p->plan.i_theta0*ld + k] -= by_input[k]*weight[k];
    for (size_t k = 0; p->i_tool0 >= 0 && k < n; k++)
        base[(size_t)p->i_tool0*ld + k] = angle ? weight[k] : 0;
}

static void station_rows(const lw_problem *p, lw_work *w)
{
    const lw_jacobian *j = &w->jac;
    int row = 0;
    if (p->task != LW_TASK_FUNCTION) {
        component_rows(p, w, 0, j->jx, j->tx, p->wa, false);
        component_rows(p, w, 1, j->jy, j->ty, p->wa, false);
        row = 2;
    }
    if (p->theta)
        component_rows(p, w, row, j->jt, j->tt, p->wb, true);
}

/* Derivatives of the samples' distances, whose normals (weighted) are nx, ny.  Where the limits of the
 * input move with the dimensions, samples stay at their phases. */
static void sample_rows(const lw_problem *p, const double *x, lw_work *w, const double *nx,
                        const double *ny)
{
    size_t ld = w->ld, nv = (size_t)p->n_var;
    memset(w->by_input, 0, sizeof *w->by_input*w->n_lane);
    lw_circuit_slopes(p, x, w);
    for (size_t k = p->n; k < w->n_lane && !w->turning; k++)
        if (w->rate[k] != 0)
            w->by_input[k] = (nx[k]*w->jac.tx[k] + ny[k]*w->jac.ty[k])/w->rate[k];
    for (size_t c = 0; c < nv*(size_t)w->n_row; c++) {
        double *row = w->row + c*ld;
        if (c >= (size_t)p->n_dim) {
            memset(row + p->n, 0, sizeof *row*(w->n_lane - p->n));
            continue;
        }
        const double *jx = w->jac.jx + c*w->jac.ld, *jy = w->jac.jy + c*w->jac.ld;
        for (size_t k = p->n; k < w->n_lane; k++)
            row[k] = nx[k]*jx[k] + ny[k]*jy[k];
        for (size_t k = p->n; k < w->n_lane && !w->turning; k++)
            row[k] += w->by_input[k]*(w->mid_by[c] - w->half_by[c]*cos(w->phase[k]));
    }
}

/* Curve samples against the target polygon: distance to the nearest point of it (timing none). */
static void sample_residuals(const lw_problem *p, const double *x, lw_work *w, bool derivatives)
{
    size_t ld = w->ld;
    double weight = sqrt(p->a*w->sample_weight);
    for (size_t k = p->n; k < w->n_lane; k++) {
        double dx = w->jac.x[k] - w->foot_x[k - p->n], dy = w->jac.y[k] - w->foot_y[k - p->n];
        double d = sqrt(dx*dx + dy*dy), per = d > 0 ? weight/d : 0;
        w->normal_x[k] = dx*per;
        w->normal_y[k] = dy*per;
        w->res[k] = weight*d;
        for (int i = 1; i < w->n_row; i++)
            w->res[(size_t)i*ld + k] = 0;
    }
    if (derivatives)
        sample_rows(p, x, w, w->normal_x, w->normal_y);
}

double lw_problem_rows(const lw_problem *p, const double *x, lw_work *w, bool derivatives)
{
    double f = 0;
    station_residuals(p, x, w);
    if (derivatives) {
        station_rows(p, w);
        if (p->timing != LW_TIMING_PRESCRIBED)
            lw_problem_eliminate(p, x, w);
    }
    if (p->timing == LW_TIMING_NONE)
        sample_residuals(p, x, w, derivatives);
    for (int i = 0; i < w->n_row; i++)
        for (size_t k = 0; k < w->n_lane; k++)
            f += w->res[(size_t)i*w->ld + k]*w->res[(size_t)i*w->ld + k];
    return f;
}

bool lw_problem_settle(const lw_problem *p, const double *x, lw_work *w)
{
    if (p->timing == LW_TIMING_PRESCRIBED) {
        lw_problem_prescribe(p, x, w);
        return lw_problem_lanes(p, x, w);
    }
    return lw_assign(p, x, w) && lw_assign_refine(p, x, w, 60);
}

double lw_problem_value(const lw_problem *p, const double *x, double *grad, void *work)
{
    lw_work *w = work;
    if (grad)
        memset(grad, 0, sizeof *grad*(size_t)p->n_var);
    if (!lw_problem_settle(p, x, w))
        return INFINITY;
    double f = lw_problem_rows(p, x, w, grad != NULL);
    size_t ld = w->ld, nv = (size_t)p->n_var;
    for (size_t d = 0; grad && d < nv; d++)
        for (size_t i = 0; i < (size_t)w->n_row; i++)
            for (size_t k = 0; k < w->n_lane; k++)
                grad[d] += 2*w->row[(i*nv + d)*ld + k]*w->res[i*ld + k];
    return f;
}

size_t lw_problem_residual_count(const lw_problem *p)
{
    return lane_count(p)*(size_t)lw_problem_component_count(p);
}

bool lw_problem_residuals(const lw_problem *p, const double *x, double *r, double *j, void *work)
{
    lw_work *w = work;
    if (!lw_problem_settle(p, x, w))
        return false;
    lw_problem_rows(p, x, w, j != NULL);
    size_t ld = w->ld, nv = (size_t)p->n_var, at = 0;
    for (size_t i = 0; i < (size_t)w->n_row; i++)
        for (size_t k = 0; k < w->n_lane; k++, at++) {
            r[at] = w->res[i*ld + k];
            for (size_t d = 0; j && d < nv; d++)
                j[at*nv + d] = w->row[(i*nv + d)*ld + k];
        }
    return true;
}

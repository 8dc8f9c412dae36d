/* optimise/problem_make.c - from a target and what is asked for to a problem: stations scaled, the plan
 * of the family, variables with their bounds, linear conditions. */
#include <stdlib.h>
#include <string.h>

#include "optimise/family.h"
#include "optimise/problem_internal.h"

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

static lw_status make_plan(lw_problem *p, lw_error *e)
{
    lw_linkage k;
    lw_family_linkage(p->family, p->task, &k);
    lw_status s = lw_plan_make_any(&k, (lw_want){ .tracers = 1, .all_joints = true }, &p->plan, e);
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

int lw_problem_first_length(const lw_problem *p)
{
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH)
            return i;
    return -1;
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
            fix(p, p->family->linkage ? lw_problem_first_length(p) : lw_problem_index(p, p->family->shape[0]), 1);
    }
    return LW_OK;
}

static lw_status check_task(const lw_target *t, const lw_fit_spec *s, lw_error *e)
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
    return LW_OK;
}

/* Can linkages of this family do it at all? */
static lw_status check_family(const lw_problem *p, lw_error *e)
{
    if (p->plan.input_is_slider && p->timing == LW_TIMING_PRESCRIBED)
        return lw_error_set(e, LW_E_KIND, "its input is a slider, which has no crank angle to "
                            "prescribe");
    if (p->task == LW_TASK_FUNCTION && p->family->type && p->family->type[3] == 'P')
        return lw_error_set(e, LW_E_KIND, "its output slides and has no angle");
    return LW_OK;
}

/* Every length at most `ratio` times every other. */
static lw_status ratio_rows(double ratio, lw_problem *p, lw_error *e)
{
    for (int i = 0; i < p->n_dim && ratio > 0; i++)
        for (int j = 0; j < p->n_dim; j++) {
            if (i == j || p->plan.dim[i].kind != LW_DIM_LENGTH || p->plan.dim[j].kind != LW_DIM_LENGTH)
                continue;
            if (p->n_linear == LW_LINEAR_MAX)
                return lw_error_set(e, LW_E_KIND, "it has too many lengths for a bound on their ratio");
            p->linear[p->n_linear][i] = ratio;
            p->linear[p->n_linear++][j] = -1;
        }
    return LW_OK;
}

static void scale_zones(const lw_fit_spec *s, lw_problem *p)
{
    p->n_zone = s->n_zone;
    for (int i = 0; i < s->n_zone; i++) {
        lw_zone *z = &p->zone[i];
        *z = s->zone[i];
        z->at = lw_v2_scale(lw_v2_sub(z->at, p->origin), 1/p->unit);
        if (z->kind == LW_ZONE_PIVOTS_BOX || z->kind == LW_ZONE_NO_BOX)
            z->to = lw_v2_scale(lw_v2_sub(z->to, p->origin), 1/p->unit);
        z->reach /= p->unit;
    }
}

lw_status lw_problem_make(const lw_target *t, const lw_fit_spec *s, const lw_family *family,
                          double mode, int sense, lw_problem *p, lw_error *e)
{
    memset(p, 0, sizeof *p);
    if (!family->linkage && !lw_type_find(family->type))
        return lw_error_set(e, LW_E_KIND, "no linkage type %s", family->type);
    lw_status st = check_task(t, s, e);
    if (st != LW_OK)
        return st;
    p->family = family;
    p->task = s->task;
    p->timing = s->task == LW_TASK_FUNCTION ? LW_TIMING_PRESCRIBED : s->timing;
    p->datum = s->datum;
    p->branch.turns = family->turns;
    p->must_turn = s->crank_only;
    p->branch.sense = sense < 0 ? -1 : 1;
    p->closed = t->closed;
    for (int d = 0; d < LW_MODE_MAX; d++)
        p->branch.mode[d] = mode;
    if ((st = make_stations(t, p, e)) != LW_OK)
        return st;
    if (p->task == LW_TASK_PATH)
        p->theta = NULL;
    if ((st = make_plan(p, e)) != LW_OK || (st = check_family(p, e)) != LW_OK
        || (st = make_bounds(t, s, p, e)) != LW_OK) {
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
    p->max_acceleration = p->plan.input_is_slider ? s->max_acceleration*p->unit       /* [1/m]      */
                                                : s->max_acceleration/p->unit;
    for (int j = 0; j < 4 && family->linear[j]; j++)
        linear_row(p, family->linear[j], p->linear[p->n_linear++]);
    scale_zones(s, p);
    if ((st = ratio_rows(s->length_ratio, p, e)) != LW_OK)
        lw_problem_free(p);
    return st;
}

void lw_problem_free(lw_problem *p)
{
    free(p->store);
    p->store = NULL;
}

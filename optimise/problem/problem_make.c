/* optimise/problem/problem_make.c - make a problem from a target and a specification: stations scaled, the plan of the
 * family, variables with their bounds, linear conditions. */
#include <stdlib.h>
#include <string.h>

#include "optimise/problem/problem.h"
#include "optimise/problem/tracers.h"

/* Turn a text such as "+r3+r4-r1-r2" into coefficients of the variables. */
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

/* Sums over the weighted points of the target, relative to its first point. */
typedef struct moments { double weight, x, y; } moments;

static void add_points(const lw_target *t, const double *x, const double *y, const double *weight, moments *m)
{
    for (size_t i = 0; x && i < t->n; i++) {
        m->weight += weight[i];
        m->x += weight[i]*(x[i] - t->x[0]);
        m->y += weight[i]*(y[i] - t->y[0]);
    }
}

static double spread(const lw_problem *p, const double *x, const double *y, const double *weight, double all)
{
    double sum = 0;
    for (size_t i = 0; x && i < p->n; i++)
        sum += weight[i]/all*(pow(x[i] - p->origin.x, 2) + pow(y[i] - p->origin.y, 2));
    return sum;
}

/* Set origin and unit: centre of all points, and their mean distance from it. */
static void find_scale(const lw_target *t, lw_problem *p)
{
    moments m = { 0, 0, 0 };
    p->origin = lw_v2(0, 0);
    p->unit = 1;
    if (!t->x)
        return;
    add_points(t, t->x, t->y, t->weight, &m);
    for (int i = 0; i < t->n_also; i++)
        add_points(t, t->also[i].x, t->also[i].y, t->also[i].weight, &m);
    p->origin = lw_v2(t->x[0] + m.x/m.weight, t->y[0] + m.y/m.weight);
    double sum = spread(p, t->x, t->y, t->weight, m.weight);
    for (int i = 0; i < t->n_also; i++)
        sum += spread(p, t->also[i].x, t->also[i].y, t->also[i].weight, m.weight);
    p->unit = sum > 0 ? sqrt(sum) : 1;
}

static void scale_points(const lw_problem *p, const double *x, const double *y, double *to_x, double *to_y)
{
    for (size_t i = 0; i < p->n; i++) {
        to_x[i] = (x[i] - p->origin.x)/p->unit;
        to_y[i] = (y[i] - p->origin.y)/p->unit;
    }
}

/* Set the arrays of a further point, five of length n from a on: scaled places and angles; weights are set later. */
static void make_aim(const lw_target *t, const lw_also *from, const lw_problem *p, double *a, lw_aim *aim)
{
    size_t n = p->n;
    *aim = (lw_aim){ .x = from->x ? a : NULL, .y = from->x ? a + n : NULL, .theta = from->theta ? a + 2*n : NULL,
                     .wa = a + 3*n, .wb = a + 4*n, .i_tool = -1 };
    if (aim->x)
        scale_points(p, from->x, from->y, aim->x, aim->y);
    if (aim->theta)
        memcpy(aim->theta, from->theta, sizeof *aim->theta*t->n);
}

static lw_status make_stations(const lw_target *t, lw_problem *p, lw_error *e)
{
    size_t n = p->n = t->n;
    double *a = calloc(n*(10 + 5*(size_t)t->n_also) + 1, sizeof *a);
    if (!a)
        return lw_error_set(e, LW_E_MEMORY, "no memory for %zu stations", n);
    p->store = a;
    p->x = a; p->y = a + n; p->w = a + 2*n; p->c = a + 3*n; p->s = a + 4*n; p->angle = a + 5*n;
    p->theta = t->theta ? a + 6*n : NULL;
    p->wa = a + 7*n; p->wb = a + 8*n;
    p->along = a + n*(9 + 5*(size_t)t->n_also);
    find_scale(t, p);
    if (t->x)
        scale_points(p, t->x, t->y, p->x, p->y);
    for (size_t i = 0; t->x && i < n; i++) {
        size_t next = i + 1 < n ? i + 1 : t->closed ? 0 : i;
        p->along[i + 1] = p->along[i] + hypot(p->x[next] - p->x[i], p->y[next] - p->y[i]);
    }
    for (size_t i = 0; i < n; i++) {
        /* one half for each direction of the comparison */
        p->w[i] = t->weight[i]*(p->timing == LW_TIMING_NONE ? 0.5 : 1);
        if (p->theta)
            p->theta[i] = t->theta[i];
    }
    p->n_also = t->n_also;
    for (int i = 0; i < t->n_also; i++)
        make_aim(t, &t->also[i], p, a + n*(9 + 5*(size_t)i), &p->also[i]);
    return LW_OK;
}

/* Divide the prescribed inputs by p->plan.input_turns_per_period, which is how the plan counts them. A timing of one
 * turn may lie in any turn of the period: the phases of the wheels, which are dimensions, decide in which. */
static void make_timing(const lw_target *t, lw_problem *p)
{
    for (size_t i = 0; i < p->n; i++) {
        p->angle[i] = t->angle ? t->angle[i]/p->plan.input_turns_per_period : 0;
        p->c[i] = cos(p->angle[i]);
        p->s[i] = sin(p->angle[i]);
    }
}

static lw_status make_plan(const lw_target *t, const lw_fit_spec *s, lw_problem *p, lw_error *e)
{
    lw_linkage k;
    lw_status st = lw_tracers_linkage(p->family, t, s, &k, e);
    if (st == LW_OK)
        st = lw_plan_make(&k, (lw_plan_options){ .tracers = lw_tracers_mask(t), .all_joints = true,
                                               .kind = LW_PLAN_GEARED }, &p->plan, e);
    if (st != LW_OK)
        return st;
    p->n_dim = p->n_var = p->plan.n_dim;
    p->i_input0 = p->timing == LW_TIMING_PRESCRIBED ? p->n_var++ : -1;
    p->i_tool0 = p->theta ? p->n_var++ : -1;
    for (int i = 0; i < p->n_also; i++)
        p->also[i].i_tool = p->also[i].theta ? p->n_var++ : -1;
    return LW_OK;
}

/* Most length and coordinate if the user gave no range, in diagonals of the path. */
static double most_size(const lw_fit_spec *s) { return s->max_size > 0 ? s->max_size : 10; }

/* Limits of link lengths if the user gave none: 1/1000 to 10 diagonals of the path. */
static void default_range(const lw_target *t, const lw_fit_spec *s, lw_fit_spec *out)
{
    double d = t->x && t->extent > 0 ? t->extent : 1;
    *out = *s;
    if (!(s->length_hi > 0)) {
        out->length_lo = t->x ? 1e-3*d : 0.02;       /* for a function: in lengths of the frame   */
        out->length_hi = t->x ? most_size(s)*d : 50;
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
        double reach = most_size(s)*(t->x && t->extent > 0 ? t->extent : 1)/p->unit;
        if (s->by_default & LW_LIMIT_SIZE && i != p->plan.i_x0 && i != p->plan.i_y0)    /* arms to its corners, ... */
            reach *= p->plan.dim[i].role == LW_ROLE_CX || p->plan.dim[i].role == LW_ROLE_CY ? sqrt(0.5) : 0.5;
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
        return LW_OK;                                        /* a dimension of another type           */
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
            p->lo[i] = fmax(p->lo[i], 1e-9*fmin(1, p->hi[i]));    /* a link length is positive    */
        }
    for (int i = 0; i < p->n_also; i++)
        if (!p->also[i].x) {                                 /* its position on the link does not matter */
            fix(p, p->plan.i_cx[i + 1], 0);
            fix(p, p->plan.i_cy[i + 1], 0);
        }
    if (!lw_task_has_place(p->task)) {                       /* place, size and tracer do not matter  */
        static const char *const idle[] = { "x0", "y0", "theta0", "cy" };
        for (int k = 0; k < 4; k++)
            fix(p, lw_problem_index(p, idle[k]), 0);
        fix(p, lw_problem_index(p, "cx"), 1);
        if (!(spec->length_hi > 0))                          /* else any size in that range is possible */
            fix(p, p->family->linkage ? lw_problem_first_length(p) : lw_problem_index(p, p->family->shape[0]), 1);
    }
    return LW_OK;
}

static lw_status check_task(const lw_target *t, const lw_fit_spec *s, lw_error *e)
{
    if (t->n < 2)
        return lw_error_set(e, LW_E_ARG, "one point only: a linkage is found for two points or more");
    if (lw_task_has_place(s->task) && t->x && !(t->size > 0))
        return lw_error_set(e, LW_E_ARG, "all points are at one place: a path needs some extent");
    if (s->timing == LW_TIMING_NONE && lw_task_has_place(s->task) && t->n_also > 0)
        return lw_error_set(e, LW_E_ARG, "several points are where the target says at the same time, so their stations "
                            "have an order; timing none, which scores one curve both ways, knows none: use free timing");
    for (int i = 0; i < t->n_also && !lw_task_has_place(s->task); i++)
        if (t->also[i].x)
            return lw_error_set(e, LW_E_ARG, "a function has no place in the plane, so point %d cannot have x and y; "
                                "use the path task, with the output angle as a further point", i + 2);
    if (!lw_task_has_place(s->task) && s->n_zone > 0)
        return lw_error_set(e, LW_E_ARG, "a function has no place in the plane: places of pivots and forbidden zones "
                            "mean nothing to it; leave them out, or use the path task");
    if (lw_task_has_place(s->task) && !t->x)
        return lw_error_set(e, LW_E_ARG, "the target has no columns x and y, which a path needs; "
                            "for input and output angles use the function task");
    if (lw_task_has_angle(s->task) && !t->theta)
        return lw_error_set(e, LW_E_ARG, "the target has no column theta (tool or output angle), which the %s task needs",
                            lw_task_table[s->task].name);
    bool timed = s->timing == LW_TIMING_PRESCRIBED || lw_task_table[s->task].prescribed;
    if (timed && !t->angle)
        return lw_error_set(e, LW_E_ARG, "prescribed timing needs a column angle (input angle) in the target; without one use free timing");
    return LW_OK;
}

/* Check that linkages of this family can do the task. */
static lw_status check_family(const lw_problem *p, lw_error *e)
{
    if (p->plan.input_is_slider && p->timing == LW_TIMING_PRESCRIBED)
        return lw_error_set(e, LW_E_KIND, "its input is a slider, which has no crank angle to prescribe");
    if (p->must_turn && p->within_limits && p->plan.input_is_slider)
        return lw_error_set(e, LW_E_KIND, "its input is a slider, which cannot turn");
    if (!lw_task_has_place(p->task) && p->family->type && p->family->type[3] == 'P')
        return lw_error_set(e, LW_E_KIND, "its output slides and has no angle");
    return LW_OK;
}

static bool has_named_bound(const lw_fit_spec *s, const char *name)
{
    int i = 0;
    while (i < s->n_bound && strcmp(s->bound[i].name, name) != 0)
        i++;
    return i < s->n_bound;
}

/* Add rows: the arms of the points, to the corners of their boxes, are at most `ratio` times each of these n lengths. */
static void arm_rows(const lw_fit_spec *s, const int *length, int n, lw_problem *p)
{
    for (int d = 0; d < p->n_dim; d++) {
        lw_dim_role role = p->plan.dim[d].role;
        bool arm = (role == LW_ROLE_CX || role == LW_ROLE_CY) && p->lo[d] < p->hi[d];
        if (!arm || has_named_bound(s, p->plan.dim[d].name) || p->n_linear + 2*n > LW_LINEAR_MAX)
            continue;
        for (int i = 0; i < n; i++)
            for (int sign = -1; sign <= 1; sign += 2) {
                p->linear[p->n_linear][length[i]] = sqrt(0.5)*s->length_ratio;
                p->linear[p->n_linear++][d] = sign;
            }
    }
}

/* Add rows: every length is at most `ratio` times every other.  The default ratio gives way to bounds of single lengths.
 * With too many lengths for rows, the default becomes a lower bound of each. */
static lw_status ratio_rows(const lw_fit_spec *s, lw_problem *p, lw_error *e)
{
    bool by_default = s->by_default & LW_LIMIT_RATIO;
    int length[LW_DIM_MAX], n = 0;
    for (int i = 0; i < p->n_dim && s->length_ratio > 0; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH && !(by_default && has_named_bound(s, p->plan.dim[i].name)))
            length[n++] = i;
    bool rows = p->n_linear + n*(n - 1) <= LW_LINEAR_MAX;
    if (!rows && !by_default)
        return lw_error_set(e, LW_E_KIND, "it has too many lengths for a bound on their ratio");
    for (int i = 0; i < n && !rows; i++)
        p->lo[length[i]] = fmax(p->lo[length[i]], fmin(p->hi[length[i]], 1)/s->length_ratio);
    p->ratio_row = p->n_linear;
    for (int i = 0; i < n && rows; i++)
        for (int j = 0; j < n; j++)
            if (i != j) {
                p->linear[p->n_linear][length[i]] = s->length_ratio;
                p->linear[p->n_linear++][length[j]] = -1;
            }
    p->n_ratio_row = p->n_linear - p->ratio_row;
    if (lw_task_has_place(p->task))
        arm_rows(s, length, n, p);
    return LW_OK;
}

/* The points of a link by the variables that are their coordinates: the pins of the plan, and its tracers. */
typedef struct link_points { int n, pins, of[LW_DIM_MAX][2]; } link_points;

static void points_of_link(const lw_problem *p, int link, link_points *out)
{
    *out = (link_points){ .n = 1, .of = { { -1, -1 } } };                /* the origin of its frame          */
    for (int tracers = 0; tracers < 2; tracers++) {
        for (int d = 0; d < p->n_dim; d++) {
            const lw_dim_info *i = &p->plan.dim[d];
            bool first = tracers ? i->role == LW_ROLE_CX : i->role == LW_ROLE_R || i->role == LW_ROLE_X;
            if (i->link != link)
                continue;
            if (first) {
                out->of[out->n][0] = d;
                out->of[out->n++][1] = -1;
            } else if (i->role == (tracers ? LW_ROLE_CY : LW_ROLE_Y))
                out->of[out->n - 1][1] = d;
        }
        if (!tracers)
            out->pins = out->n;
    }
}

/* The longest and the shortest of the lengths that are variables. */
static void longest_and_shortest(const lw_problem *p, const double *x, double *longest, double *shortest)
{
    *longest = 0;
    *shortest = INFINITY;
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH) {
            *longest = fmax(*longest, x[i]);
            *shortest = fmin(*shortest, x[i]);
        }
}

double lw_problem_size(const lw_problem *p, const double *x)
{
    double most = 0, least;
    if (!lw_task_has_place(p->task)) {
        longest_and_shortest(p, x, &most, &least);
        return most/least;
    }
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind != LW_DIM_ANGLE && i != p->plan.i_x0 && i != p->plan.i_y0)
            most = fmax(most, fabs(x[i]));
    for (int l = 0; l < p->plan.n_link; l++) {
        link_points of;
        points_of_link(p, p->plan.link[l], &of);
        for (int b = 1; b < of.n; b++)
            for (int a = 0; a < b && a < of.pins; a++)
                most = fmax(most, lw_v2_norm(lw_v2_sub(lw_point_on_link(x, of.of[a]), lw_point_on_link(x, of.of[b]))));
    }
    return most;
}

double lw_problem_uneven(const lw_problem *p, const double *x)
{
    double most, least;
    longest_and_shortest(p, x, &most, &least);
    return most > 0 ? lw_uneven(most, least) : 1;
}

void lw_problem_limit_size(lw_problem *p, double most)
{
    const bool has_place = lw_task_has_place(p->task);
    for (int j = p->ratio_row; j < p->ratio_row + p->n_ratio_row && !has_place; j++)
        for (int i = 0; i < p->n_dim; i++)
            p->linear[j][i] = fmin(p->linear[j][i], most);
    for (int i = 0; i < p->n_dim && has_place; i++) {
        bool place = i == p->plan.i_x0 || i == p->plan.i_y0;
        if (p->plan.dim[i].kind == LW_DIM_ANGLE || p->lo[i] >= p->hi[i] || place)
            continue;
        p->hi[i] = fmax(fmin(p->hi[i], most), p->lo[i] < 0 ? 0 : p->lo[i]);
        p->lo[i] = p->lo[i] < 0 ? fmax(p->lo[i], -most) : p->lo[i];
    }
    for (int i = 0; i < p->n_side; i++)
        if (p->side[i].most)
            p->side[i].limit = fmin(p->side[i].limit, most);
}

/* Is the length from point a to point b of the link a variable? */
static bool is_variable(const lw_problem *p, const link_points *of, int a, int b)
{
    return a == 0 && of->of[b][1] < 0 && p->plan.dim[of->of[b][0]].kind == LW_DIM_LENGTH;
}

/* Bound the sides of links with three and more pins from below, by the longest length over s->length_ratio, as ratio_rows bounds the lengths
 * that are variables.  Without that, most finds of six and more links have two pins of a link near each other.  The default limit does so of many
 * stations only: few leave dimensions free, and the search moves its finds to better ratios. */
static void ratio_sides(const lw_fit_spec *s, lw_problem *p)
{
    const bool gives_way = s->by_default & LW_LIMIT_RATIO && (s->n_bound > 0 || p->n <= LW_FEW_STATIONS);
    for (int l = 0; l < p->plan.n_link && s->length_ratio > 0 && !gives_way && !s->dimensions_only && lw_task_has_place(p->task); l++) {
        link_points of;
        points_of_link(p, p->plan.link[l], &of);
        for (int b = 1; b < of.pins; b++)
            for (int a = 0; a < b && p->n_side < LW_SIDE_MAX; a++)
                if (!is_variable(p, &of, a, b)) {
                    lw_side *side = &p->side[p->n_side++];
                    *side = (lw_side){ .ratio = s->length_ratio };
                    memcpy(side->from, of.of[a], sizeof side->from);
                    memcpy(side->to, of.of[b], sizeof side->to);
                }
    }
    p->n_side_known = p->n_side;
}

/* Bound the lengths that are no variables: sides of links with three and more pins, within the range of the lengths;
 * distances of tracers from the pins of their links, at most its upper end.  The default range does not bound them from the
 * beginning: the search may do it later (n_side_known). */
static lw_status make_sides(const lw_target *t, const lw_fit_spec *spec, lw_problem *p, lw_error *e)
{
    lw_fit_spec range = *spec;
    const lw_fit_spec *s = &range;
    const bool asked = spec->length_hi > 0;
    ratio_sides(spec, p);
    if (!asked && spec->by_default) {
        default_range(t, spec, &range);
        range.length_lo = 0;
    }
    for (int l = 0; l < p->plan.n_link && s->length_hi > 0 && !s->dimensions_only && lw_task_has_place(p->task);
         l++) {
        link_points of;
        points_of_link(p, p->plan.link[l], &of);
        for (int b = 1; b < of.n; b++)
            for (int a = 0; a < b && a < of.pins; a++) {
                bool variable = is_variable(p, &of, a, b);
                bool pins = b < of.pins && s->length_lo > 0;
                for (int most = 1; most >= (pins ? 0 : 1) && !variable; most--) {
                    if (p->n_side_known == LW_SIDE_MAX && asked)
                        return lw_error_set(e, LW_E_KIND, "it has too many lengths to bound each of them");
                    if (p->n_side_known == LW_SIDE_MAX)
                        continue;
                    lw_side *side = &p->side[p->n_side_known++];
                    *side = (lw_side){ .most = most, .limit = (most ? s->length_hi : s->length_lo)/p->unit };
                    memcpy(side->from, of.of[a], sizeof side->from);
                    memcpy(side->to, of.of[b], sizeof side->to);
                }
            }
    }
    p->n_side = asked ? p->n_side_known : p->n_side;
    return LW_OK;
}

/* A family's conditions for a full turn, with a distance of `margin` perimeters from the change point. */
static void turning_rows(double margin, lw_problem *p)
{
    for (int j = 0; j < 4 && p->family->linear[j]; j++, p->n_linear++) {
        double *row = p->linear[p->n_linear];
        linear_row(p, p->family->linear[j], row);
        for (int i = 0; i < p->n_dim; i++)
            if (p->plan.dim[i].kind == LW_DIM_LENGTH)
                row[i] -= margin;
    }
}

static void scale_zones(const lw_fit_spec *s, lw_problem *p)
{
    p->n_zone = s->n_zone;
    for (int i = 0; i < s->n_zone; i++) {
        lw_zone *z = &p->zone[i];
        *z = s->zone[i];
        z->at = lw_v2_scale(lw_v2_sub(z->at, p->origin), 1/p->unit);
        if (z->kind != LW_ZONE_PIVOTS_LINE)
            z->to = lw_v2_scale(lw_v2_sub(z->to, p->origin), 1/p->unit);
        z->reach /= p->unit;
        for (int k = 0; k < z->n_corner && lw_zone_is_polygon(z); k++)
            z->corner[k] = lw_v2_scale(lw_v2_sub(z->corner[k], p->origin), 1/p->unit);
    }
    double x[LW_VAR_MAX] = { 0 };
    lw_pivots v;
    lw_problem_fixed_pivots(p, x, &v);
    for (int i = 0; i < s->n_zone; i++)
        p->n_zone_condition += lw_zone_forbids(&s->zone[i]) ? LW_ZONE_SAMPLES : (size_t)(v.n*lw_zone_sides(&s->zone[i]));
}

/* Set scale and weights: f is in units of the scaled target; the user's objective is scale * f. */
static void weigh(const lw_target *t, const lw_fit_spec *s, lw_problem *p)
{
    bool function = !lw_task_has_place(p->task);
    double angle = function ? s->b : s->b/(s->a*p->unit*p->unit);
    p->scale = function ? 1 : s->a*p->unit*p->unit;
    p->a = function ? 0 : 1;
    p->b = !lw_task_has_angle(p->task) ? 0 : angle;
    for (size_t i = 0; i < p->n; i++) {
        p->wa[i] = sqrt(p->a*p->w[i]);
        p->wb[i] = sqrt(p->b*p->w[i]);
        for (int k = 0; k < p->n_also; k++) {
            p->also[k].wa[i] = sqrt(p->a*t->also[k].weight[i]);
            p->also[k].wb[i] = sqrt(angle*t->also[k].weight[i]);
        }
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
    p->timing = lw_task_table[s->task].prescribed ? LW_TIMING_PRESCRIBED : s->timing;
    p->datum = s->datum;
    p->intended.turns = family->turns;
    p->must_turn = s->crank_only;
    p->within_limits = s->within_limits;
    p->intended.sense = sense < 0 ? -1 : 1;
    p->closed = t->closed;
    for (int d = 0; d < LW_MODE_MAX; d++)
        p->intended.mode[d] = mode;
    if ((st = make_stations(t, p, e)) != LW_OK)
        return st;
    if (!lw_task_has_angle(p->task))
        p->theta = NULL;
    if ((st = make_plan(t, s, p, e)) != LW_OK || (st = check_family(p, e)) != LW_OK
        || (st = make_bounds(t, s, p, e)) != LW_OK) {
        lw_problem_free(p);
        return st;
    }
    make_timing(t, p);
    weigh(t, s, p);
    p->min_transmission = s->min_transmission;
    p->transmission_is_soft = s->by_default & LW_LIMIT_TRANSMISSION;
    int turns = p->plan.input_turns_per_period;
    p->max_acceleration = p->plan.input_is_slider ? s->max_slide_acceleration*p->unit
                                                  : s->max_acceleration*turns*turns/p->unit;
    turning_rows(s->class_margin, p);
    scale_zones(s, p);
    if ((st = ratio_rows(s, p, e)) != LW_OK || (st = make_sides(t, s, p, e)) != LW_OK)
        lw_problem_free(p);
    return st;
}

void lw_problem_free(lw_problem *p)
{
    free(p->store);
    p->store = NULL;
}

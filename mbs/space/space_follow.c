/* mbs/space/space_follow.c - postures along the inputs.
 *
 * A step goes along the tangent and closes the joints by Newton's method.  It is taken when the correction is small
 * beside the step and the tangents at its ends agree: then the step is short beside the radius of the curve of
 * postures, and with it beside the distance to another branch. */
#include "mbs/space/space_follow.h"
#include "base/number.h"
#include "base/vector.h"
#include "mbs/space/space_idle.h"
#include "mbs/space/space_mobility.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double longest_step = 0.25;     /* lengths over the size, radians */
static const double greatest_correction = 0.1, greatest_change = 0.35;     /* of the step; of the tangent */

/* ---- making -------------------------------------------------------------------------------------------- */

void lw_space_follow_free(lw_space_follow *f)
{
    lw_space_rows_free(&f->z);
    free(f->memory);
    memset(f, 0, sizeof *f);
}

/* Rank of the rows of the joints and the idle spins, without inputs. */
static lw_status rank_of_joints(const lw_space *s, const lw_space_extra *x, int n, const double *metric, int *rank,
                                lw_error *e)
{
    lw_space_rows_set z;
    lw_status st = lw_space_rows_make(s, x, n, metric, s->start, &z, e);
    *rank = st == LW_OK ? z.n_kept : 0;
    if (st == LW_OK)
        lw_space_rows_free(&z);
    return st;
}

int lw_space_lost_freedoms(const lw_space_follow *f)
{
    lw_space_mobility m;
    if (f->redundant == 0 || f->z.n_row > LW_SPACE_MANY_ROWS || lw_space_mobility_find(f->z.s->model, 0, 1, NULL, &m, NULL) != LW_OK)
        return 0;
    int lost = m.instant - m.freedom;
    lw_space_mobility_free(&m);
    return lost;
}

/* The *n inputs whose rows depend on those of the joints and of the other inputs, "A, B and C": without one of them the rank is the same. */
static lw_status name_dependent(const lw_space_follow *f, const double *metric, int *n, char *text, size_t size, lw_error *e)
{
    const lw_space *s = f->z.s;
    int *of = calloc((size_t)f->n_input + 1, sizeof *of), rank;
    lw_space_extra *x = calloc((size_t)(f->n_idle + f->n_input), sizeof *x);
    lw_status st = of && x ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; st == LW_OK && i < f->n_input; i++) {
        size_t before = (size_t)(f->n_idle + i), after = (size_t)(f->n_input - 1 - i);
        memcpy(x, f->z.extra, before*sizeof *x);
        memcpy(x + before, f->z.extra + before + 1, after*sizeof *x);
        if ((st = rank_of_joints(s, x, f->n_idle + f->n_input - 1, metric, &rank, e)) == LW_OK && rank == f->z.n_kept)
            of[(*n)++] = i;
    }
    size_t used = 0;
    text[0] = 0;
    for (int i = 0; st == LW_OK && i < *n; i++) {
        char name[64];
        lw_spatial_measure_name(s->model, f->z.extra[f->n_idle + of[i]].measure, name, sizeof name);
        used += (size_t)snprintf(text + used, size - used, "%s%s", i == 0 ? "" : i + 1 == *n ? " and " : ", ", name);
        used = used < size ? used : size - 1;
    }
    free(of), free(x);
    return st;
}

static lw_status count_freedoms(lw_space_follow *f, int rank, const double *metric, bool any, lw_error *e)
{
    char names[200];
    const lw_space *s = f->z.s;
    int freedom = s->n_v - rank, lost;
    f->freedom = s->n_v - f->z.n_kept;
    f->redundant = s->n_row + f->n_idle - rank;
    if (freedom == 0 && f->n_input > 0)
        return lw_error_set(e, LW_E_ARG, "the model cannot move in the posture of the file: it has 0 freedoms and %d input%s; linkwright mobility tells "
                            "what holds it", f->n_input, lw_plural(f->n_input));
    int n = 0;
    lw_status st = f->z.n_kept < rank + f->n_input ? name_dependent(f, metric, &n, names, sizeof names, e) : LW_OK;
    if (st != LW_OK)
        return st;
    if (f->n_input > freedom)
        return lw_error_set(e, LW_E_ARG, "the model has %d freedom%s and %d inputs: %d input%s too many; %s cannot %s",
                            freedom, lw_plural(freedom), f->n_input, f->n_input - freedom, f->n_input - freedom == 1 ? " is" : "s are", names,
                            n == 1 ? "be an input" : "all be inputs");
    if (f->z.n_kept < rank + f->n_input)
        return lw_error_set(e, LW_E_ARG, "%d input%s only %d of %d freedom%s in the posture of the file: %s%s the posture is singular for %s",
                            f->n_input, f->n_input == 1 ? " moves" : "s move", f->z.n_kept - rank, freedom, lw_plural(freedom),
                            names, n == 1 ? " is held by the joints, or" : " contradict each other, or", n == 1 ? "it" : "them");
    if (f->freedom > 0 && !any && (lost = lw_space_lost_freedoms(f)) > 0)
        return lw_error_set(e, LW_E_ARG, "the posture of the file is singular: to first order the links have %d freedoms there, but the motion has %d; take "
                            "another posture of the motion", freedom, freedom - lost);
    if (f->freedom > 0 && !any) {
        bool heavy = false;
        for (int b = 0; b < s->n_body; b++)
            heavy = heavy || s->model->body[s->link_of[b]].mass > 0;
        return lw_error_set(e, LW_E_ARG, "the model has %d freedom%s and %d input%s: %d more input%s needed to move it by inputs alone%s", freedom,
                            lw_plural(freedom), f->n_input, lw_plural(f->n_input), f->freedom, f->freedom == 1 ? " is" : "s are",
                            heavy ? "; 'linkwright simulate' moves it by its forces, too" : "");
    }
    return LW_OK;
}

lw_status lw_space_follow_make(const lw_space *s, const lw_spatial_measure *input, int n_input, bool any,
                               lw_space_follow *f,
                               lw_error *e)
{
    size_t q = (size_t)s->n_q, v = (size_t)s->n_v, extras = (size_t)s->n_body + (size_t)n_input + 1;
    size_t rows = (size_t)s->n_row + extras, near = extras + (size_t)s->n_joint;
    memset(f, 0, sizeof *f);
    double *at = f->memory = calloc(10*q + 10*v + 7*extras + 2*rows + near, sizeof *at);
    lw_space_extra *x = calloc(extras, sizeof *x);
    if (!at || !x) {
        free(at), free(x);
        f->memory = NULL;
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    f->q = at, at += q;
    f->q_try = at, at += q;
    f->v = at, at += v;
    f->a = at, at += v;
    f->v_try = at, at += v;
    f->off = at, at += v;
    f->before = at, at += v;
    f->again = at, at += v;
    f->target = at, at += extras;
    f->rhs = at, at += rows;
    f->l = at, at += rows;
    f->path = (double (*)[3])(void *)at, at += 3*extras;
    f->made = (double (*)[3])(void *)at, at += 3*extras;
    f->made_at = NAN;
    f->least = 1e-10;
    f->seen = at, at += 7*q + v;
    f->kept = at, at += q + 2*v + near;
    double *metric = at;
    memcpy(f->q, s->start, q*sizeof *f->q);
    lw_space_metric(s, metric);
    f->n_idle = lw_space_idle(s, false, x);
    f->n_input = n_input;
    int rank = 0;
    lw_status st = n_input > 0 ? rank_of_joints(s, x, f->n_idle, metric, &rank, e) : LW_OK;
    for (int i = 0; i < n_input; i++)
        x[f->n_idle + i] = (lw_space_extra){ .measure = input[i] };
    if (st == LW_OK)
        st = lw_space_rows_make(s, x, f->n_idle + n_input, metric, s->start, &f->z, e);
    if (st == LW_OK)
        st = count_freedoms(f, n_input > 0 ? rank : f->z.n_kept, metric, any, e);
    free(x);
    if (st != LW_OK)
        lw_space_follow_free(f);
    return st;
}

void lw_space_follow_values(const lw_space_follow *f, double *value)
{
    const lw_space *s = f->z.s;
    lw_space_place(s, f->q, f->z.frame);
    for (int i = 0; i < f->n_input; i++) {
        lw_spatial_measure of = f->z.extra[f->n_idle + i].measure;
        value[i] = lw_space_scale(s, of)*lw_space_measure(s, f->z.frame, of, f->z.near[f->n_idle + i], NULL);
    }
}

/* ---- going ------------------------------------------------------------------------------------------------ */

/* Values of the path at u as targets of the rows, and its first or second rates as right-hand sides. */
static lw_status aim(lw_space_follow *f, lw_space_path *path, void *context, double u)
{
    lw_status s = path(context, u, f->path);
    for (int i = 0; i < f->n_idle; i++)
        f->target[i] = 0;
    for (int i = 0; i < f->n_input && s == LW_OK; i++) {
        double scale = lw_space_scale(f->z.s, f->z.extra[f->n_idle + i].measure);
        f->target[f->n_idle + i] = f->path[i][0]/scale;
        if (!isfinite(f->path[i][0]) || !isfinite(f->path[i][1]) || !isfinite(f->path[i][2]))
            return LW_E_NUMERIC;
    }
    return s;
}

static void wanted(lw_space_follow *f, int rate)
{
    int first = f->z.s->n_row + f->n_idle;
    if (rate == 1)
        memset(f->rhs, 0, (size_t)f->z.n_row*sizeof *f->rhs);
    for (int i = 0; i < f->n_input; i++)
        f->rhs[first + i] += f->path[i][rate]/lw_space_scale(f->z.s, f->z.extra[f->n_idle + i].measure);
}

/* Rates by u for the rows filled and factored. */
static bool rates(lw_space_follow *f, double *v)
{
    int n_v = f->z.s->n_v;
    if (!f->column) {
        wanted(f, 1);
        return lw_space_rows_solve(&f->z, NULL, f->rhs, true, v, f->l);
    }
    memset(v, 0, (size_t)n_v*sizeof *v);
    f->has_column = lw_space_rows_motions(&f->z, f->n_input, f->z.s->n_row + f->n_idle, f->column);
    for (int i = 0; i < f->n_input; i++) {
        double rate = f->path[i][1]/lw_space_scale(f->z.s, f->z.extra[f->n_idle + i].measure);
        for (int k = 0; k < n_v; k++)
            v[k] += rate*f->column[i*n_v + k];
    }
    return f->has_column;
}

/* Rates by u at q_try, which is on the rows; factored there, and filled if not yet. */
static bool tangent(lw_space_follow *f, bool filled, double *v)
{
    if (!filled)
        lw_space_rows_fill(&f->z, f->q_try, f->target);
    return lw_space_rows_factor_near(&f->z) && (rates(f, v) || (lw_space_rows_factor(&f->z) && rates(f, v)));
}

void lw_space_follow_second(lw_space_follow *f)
{
    if (f->has_second)
        return;
    lw_space_rows_bias(&f->z, f->v, f->rhs);
    wanted(f, 2);
    lw_space_rows_solve(&f->z, NULL, f->rhs, true, f->a, f->l);
    f->has_second = true;
    f->yields = 0;
    if (f->open == 0 && f->z.n_kept < f->z.n_row) {
        double speed = lw_space_length(f->z.s, f->v), second = lw_space_length(f->z.s, f->a) + speed*speed;
        f->yields = second > 0 ? lw_space_rows_left_out(&f->z, f->a, f->rhs)/second : 0;
    }
}

/* |a - b| over the greater of both. */
static double change(const lw_space *s, const double *a, const double *b, double *scratch)
{
    double top = fmax(lw_space_length(s, a), lw_space_length(s, b));
    for (int i = 0; i < s->n_v; i++)
        scratch[i] = a[i] - b[i];
    return top > 0 ? lw_space_length(s, scratch)/top : 0;
}

/* How much the rates of the inputs change in a step to where f->path holds, over the greater. */
static double change_of_inputs(const lw_space_follow *f)
{
    double most = 0, top = 0;
    for (int i = 0; i < f->n_input; i++) {
        double unit = lw_space_scale(f->z.s, f->z.extra[f->n_idle + i].measure), from = f->made[i][1]/unit, to = f->path[i][1]/unit;
        most = fmax(most, fabs(to - from));
        top = fmax(top, fmax(fabs(from), fabs(to)));
    }
    return top > 0 ? most/top : 0;
}

/* Does the tangent v_try after a step of length h show the same curve?  It changes little, or as its rate predicts where the inputs start,
 * stop or turn back. */
static bool same_curve(lw_space_follow *f, double h)
{
    const lw_space *s = f->z.s;
    double top = fmax(lw_space_length(s, f->v), lw_space_length(s, f->v_try)), *off = f->z.full;
    if (top*fabs(h) <= 1e-6 || change(s, f->v, f->v_try, off) <= greatest_change)
        return true;
    for (int i = 0; i < s->n_v; i++)
        off[i] = f->v[i] + h*f->a[i] - f->v_try[i];
    return change_of_inputs(f) > greatest_change/2 && lw_space_length(s, off) <= greatest_change*top;
}

static const double of_second_order = 1e-4;

bool lw_space_follow_opens(const lw_space_follow *f) { return f->yields > of_second_order; }

/* Do the rows left out as dependent hold, too, after a step of this length?  Where the rows kept are singular they have other curves, which are none
 * of the linkage.  One drawn with rounded numbers opens as it moves: how fast shows in the first step.  One that yields to first order only, or in a
 * posture that is singular for its inputs, opens with the square of the step. */
static bool stays_closed(lw_space_follow *f, double length)
{
    static const double exact = 1e-7, faster = 1e4, clear_step = 1e-3, rounded = 1e-3;
    if (f->z.n_kept == f->z.n_row)
        return true;
    double open = lw_space_rows_open(&f->z);
    f->opened = open > rounded || lw_space_follow_opens(f);
    if (f->open > 0 || f->opened)
        return open <= f->open && !lw_space_follow_opens(f);
    if (length > clear_step)
        f->open = fmin(fmax(exact, faster*open/length), rounded);
    return true;
}

/* The cube of the ratio of a step of length h to the last one; 0: too much longer, or there was none. */
static double cube_of(const lw_space_follow *f, double h)
{
    double r = f->off_h != 0 ? h/f->off_h : 0;
    return fabs(r) < 2 ? r*r*r : 0;
}

/* f->again: where a step of length h will end beside v and a, extrapolated from the last two steps.  It grows with the cube of the step, by a factor that
 * changes along the way.  Returns its size; 0: not known, or more than `most`. */
static double extrapolate(lw_space_follow *f, double h, double most)
{
    const lw_space *s = f->z.s;
    double share = cube_of(f, h), on = f->before_h != 0 ? (h + f->off_h)/(f->before_h + f->off_h) : 0;
    on = fabs(on) < 2 ? on : 0;
    for (int i = 0; i < s->n_v; i++)
        f->again[i] = share*(f->off[i] + on*(f->off[i] - f->before[i]));
    double size = lw_space_length(s, f->again);
    if (size < most)
        return size;
    memset(f->again, 0, (size_t)s->n_v*sizeof *f->again);
    return 0;
}

/* The last step, of length h, has ended z.moved beside the place extrapolated. */
static void keep_end(lw_space_follow *f, double h)
{
    double share = cube_of(f, h);
    for (int i = 0; i < f->z.s->n_v; i++) {
        f->before[i] = share*f->off[i];
        f->off[i] = f->again[i] + f->z.moved[i];
    }
    f->before_h = share != 0 ? f->off_h : 0;
    f->off_h = h;
}

/* The posture is left along another path with rates v_try instead of v: measure the last steps along this path, or forget them. */
static void change_path(lw_space_follow *f)
{
    int n = f->z.s->n_v;
    double old = lw_dot(n, f->v, f->v), now = lw_dot(n, f->v_try, f->v_try), both = lw_dot(n, f->v, f->v_try);
    double r = both*both > 0.9*old*now ? both/now : 0;
    f->off_h *= r;
    f->before_h *= r;
}

/* One step of length h; false: too long. */
static lw_status try_step(lw_space_follow *f, lw_space_path *path, void *context, double h, bool *taken)
{
    const lw_space *s = f->z.s;
    double length, most;
    *taken = f->opened = f->has_column = false;
    lw_space_follow_second(f);
    memcpy(f->q_try, f->q, (size_t)s->n_q*sizeof *f->q);
    for (int i = 0; i < s->n_v; i++)
        f->z.step[i] = h*(f->v[i] + h/2*f->a[i]);
    length = lw_space_length(s, f->z.step);
    if (length > longest_step)
        return LW_OK;
    most = greatest_correction*length + 1e-7;
    most -= extrapolate(f, h, most/2);
    for (int i = 0; i < s->n_v; i++)
        f->z.step[i] += f->again[i];
    lw_space_move(s, f->q_try, f->z.step);
    lw_status st = aim(f, path, context, f->u + h);
    if (st != LW_OK)
        return st;
    if (lw_space_rows_close(&f->z, f->q_try, f->target, most) != LW_OK ||
        !tangent(f, memcmp(f->z.filled, f->q_try, (size_t)s->n_q*sizeof *f->q_try) == 0, f->v_try))
        return LW_OK;
    if (!same_curve(f, h) || !stays_closed(f, length)) {
        f->has_column = false;
        return LW_OK;
    }
    memcpy(f->q, f->q_try, (size_t)s->n_q*sizeof *f->q);
    memcpy(f->v, f->v_try, (size_t)s->n_v*sizeof *f->v);
    memcpy(f->z.near, f->target, (size_t)f->z.n_extra*sizeof *f->z.near);
    if (s->n_coupling)
        lw_space_count_turns(s, f->z.frame, f->z.near + f->z.n_extra);
    keep_end(f, h);
    f->u += h;
    f->clear = fmax(f->clear, f->z.weak);
    if (f->passed)
        f->passed(f->passed_by, f->q);
    f->has_second = f->between = false;
    *taken = true;
    return LW_OK;
}

double lw_space_distance(const lw_space_follow *f, int link)
{
    size_t at = 7*(size_t)f->z.s->body_of[link];
    const double *q = f->q + at, *p = f->z.s->start + at;
    return lw_v3_norm(lw_v3(q[0] - p[0], q[1] - p[1], q[2] - p[2]));
}

int lw_space_away(const lw_space_follow *f, double *slide, double *left)
{
    static const double near_end = 1e-3, far = 2;            /* at a common limit, c sqrt(left), the slide found so is 3 c sqrt(left) */
    const lw_space *s = f->z.s;
    int fastest = -1;
    double most = 0;
    for (int b = 0; b < s->n_body && f->has_second; b++) {
        const double *v = f->v + 6*b;
        double rate = lw_v3_norm(lw_v3(v[0], v[1], v[2]));
        if (rate > most)
            fastest = b, most = rate;
    }
    if (fastest < 0)
        return -1;
    const double *a = f->a + 6*fastest;
    *left = 1.5*most/lw_v3_norm(lw_v3(a[0], a[1], a[2]));    /* x ~ left^-1/2: x' = x/(2 left), x'' = 3 x'/(2 left) */
    *slide = 2*(*left)*most;
    double distance = lw_space_distance(f, s->link_of[fastest]);         /* the slide begins elsewhere; rates that are rounding do not fit */
    bool fits = distance > far && *slide < 4*distance && distance < 4*(*slide);
    return fits && (*left < near_end || *slide > LW_SPACE_FAR) ? s->link_of[fastest] : -1;
}

/* How far the joints stay apart at best with these inputs (SI), found from f->q: the greatest gap [m] or angle [rad],
 * and its joint. */
static double gap_of(const lw_space_follow *f, const double *value, int *joint, bool *angle)
{
    const lw_space *s = f->z.s;
    lw_space_rows_set z;
    lw_space_dense d;
    lw_error none;
    double gap = 0, *q = malloc((size_t)s->n_q*sizeof *q), *by = malloc((size_t)s->n_v*sizeof *by), *target, *b;
    *joint = -1;
    *angle = false;
    target = calloc((size_t)f->z.n_extra + 1, sizeof *target);
    b = malloc(((size_t)f->z.n_row + 1)*sizeof *b);
    bool good = q && by && target && b && lw_space_rows_make(s, f->z.extra, f->z.n_extra, f->z.weight, f->q, &z,
                                                             &none) == LW_OK;
    if (good && lw_space_dense_make(&z, &d, &none) != LW_OK) {
        lw_space_rows_free(&z);
        good = false;
    }
    if (good) {
        for (int i = 0; i < f->n_input; i++)
            target[f->n_idle + i] = value[i]/lw_space_scale(s, f->z.extra[f->n_idle + i].measure);
        memcpy(q, f->q, (size_t)s->n_q*sizeof *q);
        memcpy(z.near, f->z.near, (size_t)z.n_near*sizeof *z.near);
        double weight = 1e3;                 /* inputs are kept more exactly than joints */
        for (int round = 0; round < 60; round++) {
            lw_space_rows_fill(&z, q, target);
            for (int r = s->n_row; r < z.n_row; r++) {
                z.phi[r] *= weight;
                for (int i = z.at[r]; i < z.at[r + 1]; i++)
                    z.jac[i] *= weight;
            }
            lw_space_dense_factor(&z, &d, 1e-6);
            memcpy(b, z.phi, (size_t)z.n_row*sizeof *b);
            lw_rank_solve_transposed(&d.rank, b, by);
            for (int i = 0; i < s->n_v; i++)
                by[i] = -by[i];
            double length = lw_space_length(s, by);
            for (int i = 0; i < s->n_v && length > 0.2; i++)
                by[i] *= 0.2/length;
            if (!isfinite(length) || length < 1e-10)
                break;
            lw_space_move(s, q, by);
        }
        lw_space_rows_fill(&z, q, target);
        for (int j = 0; j < s->n_joint; j++) {
            int rows = lw_spatial_kind_of(s->joint[j].kind)->rows;
            double off = 0, tilt = 0;
            for (int k = 0; k < rows; k++) {
                const char *name = lw_space_row_name(s, s->joint[j].row + k, &(int){ 0 });
                double p = z.phi[s->joint[j].row + k];
                if (name[0] == 't')
                    tilt += p*p;
                else
                    off += p*p*s->unit*s->unit;
            }
            if (sqrt(off)/s->unit > (*angle ? gap : gap/s->unit))
                gap = sqrt(off), *joint = j, *angle = false;
            if (sqrt(tilt) > (*angle ? gap : gap/s->unit))
                gap = sqrt(tilt), *joint = j, *angle = true;
        }
        lw_space_dense_free(&d);
        lw_space_rows_free(&z);
    }
    free(q), free(by), free(target), free(b);
    return gap;
}

/* Why the path to u ends at f->u. */
static lw_status cannot(lw_space_follow *f, lw_space_path *path, void *context, double u, lw_error *e)
{
    if (!e)                                  /* how far the joints stay open takes as long as many steps */
        return LW_OPEN;
    const lw_space *s = f->z.s;
    char where[200] = "";
    size_t used = 0;
    double value[8];
    int joint = -1, n = f->n_input < 4 ? f->n_input : 4;
    bool angle;
    double *want = calloc((size_t)f->n_input + 1, sizeof *want), *got = calloc((size_t)f->n_input + 1, sizeof *got);
    if (!want || !got) {
        free(want), free(got);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    bool known = path(context, u, f->path) == LW_OK;
    for (int i = 0; i < f->n_input; i++)
        want[i] = f->path[i][0];
    lw_space_follow_values(f, got);
    memcpy(value, got, (size_t)n*sizeof *value);
    for (int i = 0; i < n; i++) {
        char name[64];
        lw_spatial_measure of = f->z.extra[f->n_idle + i].measure;
        bool turns = of.of == LW_OF_TURN;
        double rounded = fabs(value[i]) > 1e-12*(turns ? 1 : s->unit) ? value[i] : 0;
        lw_spatial_measure_name(s->model, of, name, sizeof name);
        used += (size_t)snprintf(where + used, sizeof where - used, "%s%s = %.9g %s", i ? ", " : "", name, rounded, turns ? "rad" : "m");
        used = used < sizeof where ? used : sizeof where - 1;
    }
    double slide, left;
    int away = lw_space_away(f, &slide, &left);
    if (away >= 0) {
        free(want), free(got);
        return lw_error_set(e, LW_OPEN, "the motion ends near %s, where link \"%s\" slides away without bound: it is %.3g m from its place in the file",
                            where, s->model->body[away].name,
                            lw_space_distance(f, away)*s->unit);
    }
    if (f->opened) {
        free(want), free(got);
        return lw_error_set(e, LW_OPEN, "joints open beyond %s: the linkage is overconstrained, and its dimensions do not let it move farther%s "
                            "(linkwright mobility)", where, f->n_input > 1 ? ", or its inputs contradict each other" : "");
    }
    bool small = f->z.n_row <= LW_SPACE_MANY_ROWS;       /* the search for the gap takes full matrices */
    double gap = known && small ? gap_of(f, want, &joint, &angle) : 0;
    free(want), free(got);
    if (!small)
        return lw_error_set(e, LW_OPEN, "the motion cannot be followed beyond %s: a joint would open there, or the posture is singular "
                            "or too near to it", where);
    if (joint >= 0 && gap > 1e-7)
        return lw_error_set(e, LW_OPEN, "the joints cannot be closed beyond %s: at the inputs wanted, joint \"%s\" "
                                        "stays %.3g %s "
                                        "open", where, s->model->joint[joint].name, gap, angle ? "rad" : "m");
    return lw_error_set(e, LW_OPEN, "the motion ends at %s in a singular posture: it can go on in several ways, or "
                                    "not at all",
                        where);
}

/* ---- through singular postures ------------------------------------------------------------------------------ */

/* Places of the body at 6 even distances h about the middle, as seen from q: the polynomial of degree 5 in the middle and its rates there. */
static void in_the_middle(const double *place[6], const double *q, double h, double *at, double *rate, double *second)
{
    lw_quaternion back = lw_quaternion_inverse((lw_quaternion){ q[3], q[4], q[5], q[6] });
    double z[6][6];
    for (int k = 0; k < 6; k++) {
        const double *p = place[k];
        lw_vec3 turn = lw_quaternion_vector(lw_quaternion_times(back, (lw_quaternion){ p[3], p[4], p[5], p[6] }));
        for (int i = 0; i < 3; i++)
            z[k][i] = p[i] - q[i];
        z[k][3] = turn.x, z[k][4] = turn.y, z[k][5] = turn.z;
    }
    for (int i = 0; i < 6; i++) {
        double near = z[3][i] + z[2][i], far = z[4][i] + z[1][i], end = z[5][i] + z[0][i];
        at[i] = (15*near - 6*far + end)/20;
        rate[i] = (45*(z[3][i] - z[2][i]) - 9*(z[4][i] - z[1][i]) + z[5][i] - z[0][i])/(60*h);
        second[i] = (270*near - 27*far + 2*end - 490*at[i])/(180*h*h);
    }
}

/* To u, where the rows are singular but the motion is smooth: the posture between others before and behind it. */
static lw_status go_between(lw_space_follow *f, lw_space_path *path, void *context, double u, bool *taken)
{
    static const double apart = 0.01;        /* lengths over the size, radians: the rows lose two digits there */
    static const int side[6] = { -3, -2, -1, 1, 2, 3 };
    const lw_space *s = f->z.s;
    size_t n = (size_t)s->n_q;
    double rate = lw_space_length(s, f->v), h = copysign(apart/rate, u - f->u), *seen = f->seen, *q = seen + 6*n, *by = q + n;
    *taken = false;
    if (!isfinite(h))
        return LW_OK;
    lw_status st = LW_OK;
    memset(f->a, 0, (size_t)s->n_v*sizeof *f->a);            /* second rates here are rounding */
    f->has_second = true;
    for (int k = 0; k < 6; k++) {
        if ((st = try_step(f, path, context, u + side[k]*h - f->u, taken)) != LW_OK || !*taken)
            break;
        memcpy(seen + (size_t)k*n, f->q, n*sizeof *f->q);
    }
    if (st == LW_OK && *taken) {
        memcpy(q, seen + 2*n, n*sizeof *q);
        for (int pass = 0; pass < 2; pass++) {               /* seen from the middle itself, rates are velocities */
            for (int b = 0; b < s->n_body; b++) {
                const double *place[6];
                for (int k = 0; k < 6; k++)
                    place[k] = seen + (size_t)k*n + 7*b;
                in_the_middle(place, q + 7*b, h, by + 6*b, f->v + 6*b, f->a + 6*b);
            }
            lw_space_move(s, q, by);
        }
        memcpy(f->q, q, n*sizeof *q);
        f->has_column = false;
        st = aim(f, path, context, u);
        memcpy(f->z.near, f->target, (size_t)f->z.n_extra*sizeof *f->z.near);
        f->u = u;
        f->has_second = f->between = true;
    }
    return st;
}

/* Rows left out as dependent that are open at the end of a way, by more than rounding and less than those of rounded numbers: the basis kept is
 * bad there, and a better one closes them. */
static lw_status close_better(lw_space_follow *f, lw_space_path *path, void *context, lw_error *e)
{
    static const double drift = 1e-12, rounded = 1e-9;
    size_t bytes = (size_t)f->z.s->n_q*sizeof *f->q;
    double open = f->z.n_kept < f->z.n_row ? lw_space_rows_open(&f->z) : 0;
    if (!(open > drift && open < rounded))
        return LW_OK;
    lw_status st = lw_space_rows_arrange(&f->z, f->q, e);
    if (st != LW_OK || (st = aim(f, path, context, f->u)) != LW_OK)
        return st;
    memcpy(f->q_try, f->q, bytes);
    if (lw_space_rows_close(&f->z, f->q_try, f->target, 0) != LW_OK)
        memcpy(f->q_try, f->q, bytes);
    if (!tangent(f, false, f->v_try))
        return LW_OPEN;
    memcpy(f->q, f->q_try, bytes);
    memcpy(f->v, f->v_try, (size_t)f->z.s->n_v*sizeof *f->v);
    return LW_OK;
}

static lw_status go(lw_space_follow *f, lw_space_path *path, void *context, double u, lw_error *e)
{
    static const double at_end = 1e-5;       /* lengths over the size, radians: the singular posture is that at u */
    lw_status st = aim(f, path, context, f->u);
    bool same = f->made_at == f->u && f->made_by == path;
    for (int i = 0; i < f->n_input && st == LW_OK; i++)
        same = same && memcmp(f->path[i], f->made[i], sizeof f->made[i]) == 0;
    size_t bytes = (size_t)f->z.s->n_q*sizeof *f->q;
    memcpy(f->q_try, f->q, bytes);
    if (!same || !(f->has_second || memcmp(f->z.filled, f->q, bytes) == 0)) {    /* else the rates of the last step still hold */
        f->has_second = false;
        bool found = st == LW_OK && tangent(f, false, f->v_try);
        if (st == LW_OK && !found && f->z.n_kept < f->z.n_row)        /* the basis kept may be that of a singular end of another way */
            found = (st = lw_space_rows_arrange(&f->z, f->q, e)) == LW_OK && tangent(f, false, f->v_try);
        if (st == LW_OK && !found)
            return cannot(f, path, context, u, e);
        change_path(f);
        memcpy(f->v, f->v_try, (size_t)f->z.s->n_v*sizeof *f->v);
        memcpy(f->made, f->path, (size_t)f->n_input*sizeof *f->made);
        f->made_at = NAN;                    /* no step has been made from here */
    }
    double whole = u - f->u, h = whole;
    int steps = 0;
    bool arranged = false;
    while (st == LW_OK && f->u != u) {
        bool taken, last = fabs(h) >= fabs(u - f->u);
        double by = last ? u - f->u : h, at = f->u;
        if ((st = try_step(f, path, context, by, &taken)) != LW_OK)
            break;
        if (taken) {
            f->u = last ? u : at + by;
            f->made_at = f->u;
            f->made_by = path;
            memcpy(f->made, f->path, (size_t)f->n_input*sizeof *f->made);
            h = last ? by : 1.6*by;
            arranged = false;
            if (last && (st = close_better(f, path, context, e)) == LW_OPEN)
                return cannot(f, path, context, u, e);
            steps = lw_space_length(f->z.s, f->v)*fabs(by) > 1e-2 ? 0 : steps;       /* many turns are no lack of progress */
        } else if (f->z.n_kept < f->z.n_row && !arranged && fabs(by) < 1e-3*fabs(whole)) {
            st = lw_space_rows_arrange(&f->z, f->q, e);    /* the basis kept may be singular where the rows are not */
            arranged = true;
        } else if (fabs(by) < f->least*fabs(whole) || ++steps > 100000) {
            bool between = false;
            if (lw_space_length(f->z.s, f->v)*fabs(u - f->u) < at_end && (st = go_between(f, path, context, u, &between)) != LW_OK)
                break;
            if (!between)
                return cannot(f, path, context, u, e);
            f->made_at = u;
            f->made_by = path;
            memcpy(f->made, f->path, (size_t)f->n_input*sizeof *f->made);
        } else
            h = by*0.4;
    }
    if (st == LW_E_NUMERIC)
        return lw_error_set(e, st, "the motion of an input is not a number at %.9g", f->u);
    return st;
}

void lw_space_follow_rates(lw_space_follow *f, lw_space_path *path, void *context)
{
    static const double lost = 7e-6, beside = 1e-3;          /* second rates are wrong by rounding/lost^(3/2) = 1e-8, */
    static const double lost_place = 1e-8;                   /* places by rounding/lost^(1/2) */
    const lw_space *s = f->z.s;
    size_t n_q = (size_t)s->n_q, n_v = (size_t)s->n_v, n_near = (size_t)f->z.n_near;
    double weak = f->z.weak, u = f->u, *kept = f->kept;
    lw_space_follow_second(f);
    if (f->between || !(weak < lost && weak < beside*f->clear))
        return;
    double *v = kept + n_q, *a = v + n_v, *near = a + n_v;
    bool between;
    memcpy(kept, f->q, n_q*sizeof *kept);
    memcpy(v, f->v, n_v*sizeof *v);
    memcpy(a, f->a, n_v*sizeof *a);
    memcpy(near, f->z.near, n_near*sizeof *near);
    if (go_between(f, path, context, u, &between) != LW_OK || !between) {
        memcpy(f->v, v, n_v*sizeof *v);
        memcpy(f->a, a, n_v*sizeof *a);
        f->between = false;
    }
    if (!f->between || weak > lost_place) {
        memcpy(f->q, kept, n_q*sizeof *kept);
        f->has_column = false;
        memcpy(f->z.near, near, n_near*sizeof *near);
    }
    f->u = u;
    f->has_second = true;
}

typedef struct straight { lw_space_follow *f; const double *from; double (*to)[3]; } straight;

static lw_status straight_path(void *context, double u, double (*out)[3])
{
    const straight *p = context;
    for (int i = 0; i < p->f->n_input; i++) {
        out[i][0] = p->from[i] + u*(p->to[i][0] - p->from[i]);
        out[i][1] = p->to[i][0] - p->from[i];
        out[i][2] = 0;
    }
    return LW_OK;
}

lw_status lw_space_follow_to(lw_space_follow *f, lw_space_path *path, void *context, double u, lw_error *e)
{
    int n = f->n_input;
    double apart = 0, *from = calloc(4*(size_t)n + 1, sizeof *from), (*to)[3];
    if (!from)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    to = (double (*)[3])(void *)(from + n);
    lw_status st = path(context, f->u, to);
    lw_space_follow_values(f, from);
    for (int i = 0; i < n; i++)
        apart = fmax(apart, fabs(to[i][0] - from[i])/lw_space_scale(f->z.s, f->z.extra[f->n_idle + i].measure));
    if (st == LW_OK && !isfinite(apart))
        st = lw_error_set(e, LW_E_NUMERIC, "the motion of an input is not a number at %.9g", f->u);
    if (st == LW_OK && apart > 1e-9) {
        straight line = { f, from, to };
        double at = f->u;
        f->u = 0;
        st = go(f, straight_path, &line, 1, e);
        f->u = at;
    }
    free(from);
    if (st == LW_OK)
        st = go(f, path, context, u, e);
    return st;
}

lw_status lw_space_motions(void *context, double t, double (*out)[3])
{
    const lw_spatial *m = context;
    const double at[3] = { t, 1, 0 };
    for (int i = 0; i < m->n_input; i++) {
        double series[3] = { m->input[i].value, 0, 0 };
        if (m->input[i].motion)
            lw_expression_series(m->input[i].motion, 2, at, series);
        out[i][0] = series[0] - lw_spatial_offset(&m->input[i]), out[i][1] = series[1], out[i][2] = 2*series[2];
    }
    return LW_OK;
}

static lw_status own_value(void *context, double u, double (*out)[3])
{
    (void)context;
    out[0][0] = u, out[0][1] = 1, out[0][2] = 0;
    return LW_OK;
}

lw_status lw_space_reach(lw_space_follow *f, double to, double *reached, bool *limit, lw_error *e)
{
    lw_space_follow_values(f, reached);
    f->u = *reached;
    lw_status s = lw_space_follow_to(f, own_value, NULL, to, e);
    *limit = s == LW_OPEN && !f->opened;
    *reached = f->u;
    return *limit ? LW_OK : s;
}

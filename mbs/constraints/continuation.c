/* mbs/constraints/continuation.c - Newton's method, Taylor series and the bound of a safe step. */
#include "mbs/constraints/continuation_internal.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/vector.h"

/* ---- making ------------------------------------------------------------------------------------ */

/* Norms include all rotations, and positions that a row projects on a rotating line. */
static void choose_norm(lw_continuation *f)
{
    for (int b = 0; b < f->s->n_body; b++)
        f->curved[3*b + 2] = true;
    for (int j = 0; j < f->s->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            int b = f->s->joint[j].body[end];
            if (lw_joint_slides(f->s->joint[j].kind) && b >= 0)
                f->curved[3*b] = f->curved[3*b + 1] = true;
        }
}

bool lw_continuation_create(const lw_system *s, const int *held, int n_held, bool plane, lw_continuation *f)
{
    memset(f, 0, sizeof *f);
    f->s = s;
    f->n = s->n_q;
    f->n_held = n_held;
    f->plane = plane;
    f->m = s->n_row + n_held + plane;
    size_t n = (size_t)f->n, m = (size_t)f->m, longest = m > n ? m : n, h = (size_t)n_held;
    bool sparse = s->n_q > LW_SYSTEM_Q_MAX;
    f->store = calloc((sparse ? n : m*n) + 4*n + 2*longest + m + 2*n + (LW_SYSTEM_ORDER_MAX + 1)*longest
                      + (size_t)(s->n_input + s->n_tie), sizeof *f->store);
    f->frame = calloc((size_t)s->n_body + 1, sizeof *f->frame);
    f->curved = calloc(n + 1, sizeof *f->curved);
    f->held = calloc(h + 1, sizeof *f->held);
    if (!f->store || !f->frame || !f->curved || !f->held)
        return false;
    if (h > 0)
        memcpy(f->held, held, h*sizeof *held);
    choose_norm(f);
    f->matrix = sparse ? NULL : f->store;
    f->null = sparse ? f->store : NULL;
    f->diag = f->store + (sparse ? n : m*n);
    f->row = f->diag + n;
    f->origin = f->row + n;
    f->tangent = f->origin + n;
    f->rest = f->tangent + n;
    f->work = f->rest + longest;
    f->located = f->work + longest;
    f->series = f->located + m + 2*n;
    f->value = f->series + (LW_SYSTEM_ORDER_MAX + 1)*longest;
    return !sparse || lw_sparse_rows_create(s, f->held, n_held, &f->sparse);
}

void lw_continuation_free(lw_continuation *f)
{
    free(f->store);
    free(f->frame);
    free(f->curved);
    free(f->held);
    lw_sparse_rows_free(&f->sparse);
}

/* ---- equations --------------------------------------------------------------------------------- */

/* Equations at q into f->rest, and their derivatives; returns the largest residual. */
static double assemble(lw_continuation *f, const double *q, bool derivatives)
{
    const lw_system *s = f->s;
    lw_body_frame *at = f->frame;
    double most = 0.0, *jac = derivatives ? f->matrix : NULL;
    if (jac)
        memset(jac, 0, (size_t)f->m*(size_t)f->n*sizeof *jac);
    lw_system_place(s, q, at);
    lw_system_fill(s, at, f->rest, jac, 1, f->m);
    if (derivatives && !f->matrix)
        lw_sparse_rows_fill(&f->sparse, at);
    for (int i = 0; i < f->n_held; i++) {
        int r = s->n_row + i;
        f->rest[r] = lw_system_count(s, at, s->input_joint[f->held[i]], jac ? jac + r : NULL, f->m) - f->value[i];
    }
    if (f->plane) {
        double off = -f->distance;
        for (int i = 0; i < f->n; i++) {
            off += f->row[i]*(q[i] - f->origin[i]);
            if (jac)
                jac[f->m - 1 + (long)f->m*i] = f->row[i];
        }
        f->rest[f->m - 1] = off;
    }
    for (int r = 0; r < f->m; r++)
        most = fmax(most, fabs(f->rest[r]));
    return most;
}

void lw_continuation_assemble(lw_continuation *f, const double *q) { assemble(f, q, true); }

/* Factor what was assembled.  Sparse rows are completed by the coordinate that changes most along the plane's normal. */
static double factor(lw_continuation *f)
{
    if (f->matrix)
        return lw_qr_factor(f->m, f->n, f->matrix, f->diag);
    int widest = 0;
    double *weight = lw_sparse_rows_weights(&f->sparse);
    memset(weight, 0, (size_t)f->n*sizeof *weight);
    for (int i = 1; i < f->n; i++)
        widest = fabs(f->row[i]) > fabs(f->row[widest]) ? i : widest;
    weight[widest] = f->plane;
    double share = lw_sparse_rows_factor(&f->sparse, 0.0, NULL);
    if (!f->plane || !(share > 0.0))
        return share;
    lw_sparse_rows_null(&f->sparse, widest, f->null);
    return isfinite(lw_dot(f->n, f->null, f->row)) ? share : 0.0;
}

/* Least squares with the factors; the first n numbers of b receive the solution. */
static void solve(const lw_continuation *f, double *b)
{
    if (f->matrix) {
        lw_qr_solve(f->m, f->n, f->matrix, f->diag, b);
        return;
    }
    double last = f->plane ? b[f->m - 1] : 0.0;
    lw_sparse_rows_solve(&f->sparse, b, f->rough, f->diag);
    double by = f->plane ? (last - lw_dot(f->n, f->diag, f->row))/lw_dot(f->n, f->null, f->row) : 0.0;
    for (int i = 0; i < f->n; i++)
        b[i] = f->diag[i] + (f->plane ? by*f->null[i] : 0.0);
}

double lw_continuation_factor(lw_continuation *f, const double *q)
{
    f->has_tangent = false;
    assemble(f, q, true);
    return f->m < f->n ? 0.0 : factor(f);
}

void lw_continuation_solve(const lw_continuation *f, double *b)
{
    double last = f->plane ? b[f->m - 1] : 0.0, along = 0.0;
    solve(f, b);
    if (!f->has_tangent)
        return;
    for (int i = 0; i < f->n; i++)
        along += f->tangent[i]*b[i];
    for (int i = 0; i < f->n; i++)
        b[i] += (last - along)*f->tangent[i];
}

bool lw_continuation_tangent(lw_continuation *f)
{
    double length = 0.0;
    memset(f->work, 0, (size_t)f->m*sizeof *f->work);
    f->work[f->m - 1] = 1.0;
    solve(f, f->work);
    for (int i = 0; i < f->n; i++)
        length += f->work[i]*f->work[i];
    length = sqrt(length);
    for (int i = 0; i < f->n; i++)
        f->tangent[i] = f->work[i]/length;
    f->has_tangent = isfinite(length) && length > 0.0;
    return f->has_tangent;
}

/* Residual that rounding alone can cause. */
static double rounding(const lw_continuation *f, const double *q)
{
    double most = 1.0;
    for (int i = 0; i < f->n; i++)
        most = fmax(most, fabs(q[i]));
    return 8.0*DBL_EPSILON*most;
}

bool lw_continuation_correct(lw_continuation *f, double *q)
{
    double last = 0.0, enough = fmin(1e-9, 1e-9/sqrt(fmax(1.0, f->kappa)));
    for (int iteration = 0; iteration < 20; iteration++) {
        double left = assemble(f, q, true), length = 0.0;
        f->has_tangent = false;
        if (!isfinite(left) || !(factor(f) > 1e-15))
            return false;
        solve(f, f->rest);
        for (int i = 0; i < f->n; i++)
            length = fmax(length, fabs(f->rest[i]));
        if (iteration > 0 && !(length < 0.5*last))
            return left <= rounding(f, q);             /* limited by rounding, or no convergence */
        for (int i = 0; i < f->n; i++)
            q[i] -= f->rest[i];
        if (length <= enough)                          /* the next step would be below rounding     */
            return lw_continuation_residual(f, q) <= rounding(f, q);
        last = length;
    }
    return false;
}

double lw_continuation_residual(lw_continuation *f, const double *q)
{
    double most = 0.0;
    assemble(f, q, false);
    for (int r = 0; r < f->m - f->plane; r++)
        most = fmax(most, fabs(f->rest[r]));
    return most;
}

double lw_continuation_distance(const lw_continuation *f, const double *q, const double *p)
{
    double sum = 0.0;
    for (int i = 0; i < f->n; i++)
        sum += f->curved[i] ? (q[i] - p[i])*(q[i] - p[i]) : 0.0;
    return sqrt(sum);
}

/* ---- the bound --------------------------------------------------------------------------------- */

static double dot(const lw_continuation *f, const double *a, const double *b)
{
    double sum = 0.0;
    for (int i = 0; i < f->n; i++)
        sum += f->curved[i] ? a[i]*b[i] : 0.0;
    return sum;
}

/* The arms of body b at its pins, rotated by `by`, as right-hand side; false if it has none. */
static bool stack_arms(const lw_continuation *f, const lw_body_frame *at, int b, lw_vec2 by, double *out)
{
    bool any = false;
    lw_vec2 dir = lw_v2_turn(at[b + 1].dir, by);
    memset(out, 0, (size_t)f->m*sizeof *out);
    for (int k = 0; k < f->s->n_joint; k++) {
        const lw_system_joint *j = &f->s->joint[k];
        if (!lw_joint_holds_point(j->kind) || (j->body[0] != b && j->body[1] != b))
            continue;
        int end = j->body[1] == b;
        lw_vec2 r = lw_v2_scale(lw_v2_turn(j->arm[end], dir), end ? -1.0 : 1.0);
        out[j->row] = r.x;
        out[j->row + 1] = r.y;
        any = true;
    }
    return any;
}

/* Largest length, over all bodies and rotations, of A^+ (second derivative by the body's rotation). */
static double pin_bound(lw_continuation *f, const lw_body_frame *at)
{
    double most = 0.0, *g = f->rest, *h = f->work;
    for (int b = 0; b < f->s->n_body; b++) {
        if (!stack_arms(f, at, b, lw_v2(1.0, 0.0), g))
            continue;
        lw_continuation_solve(f, g);
        stack_arms(f, at, b, lw_v2(0.0, 1.0), h);
        lw_continuation_solve(f, h);
        double gg = dot(f, g, g), hh = dot(f, h, h), gh = dot(f, g, h);
        most = fmax(most, 0.5*(gg + hh) + hypot(0.5*(gg - hh), gh));
    }
    return sqrt(most);
}

/* The bilinear form of v . (p_1 - p_0), v carried by link 0, in the norms of (turn 0, turn 1, place 1, place 0), as
 * v . r_0 is constant: with D = |x_1 + r_1 - x_0|, at most D0 + what `reach` can add,
 *     (turn 0)^2 D,   (turn 1)^2 |a_1|,   turn 0 turn 1 |a_1|,   turn 0 place 1,   turn 0 place 0. */
static double projection_norm(const lw_system_joint *j, const lw_body_frame *at, double reach)
{
    int b0 = j->body[0] + 1, b1 = j->body[1] + 1;
    double arm = lw_v2_norm(j->arm[1]);
    lw_vec2 r1 = lw_v2_turn(j->arm[1], at[b1].dir);
    double d = lw_v2_norm(lw_v2_sub(lw_v2_add(at[b1].at, r1), at[b0].at)) + reach*sqrt(2.0 + arm*arm);
    if (b0 == 0)
        return arm;
    return b1 == 0 ? sqrt(d*d + 2.0) : sqrt(d*d + 3.0*arm*arm + 4.0);
}

/* |A^+ e_row| */
static double row_gain(lw_continuation *f, int row)
{
    memset(f->work, 0, (size_t)f->m*sizeof *f->work);
    f->work[row] = 1.0;
    lw_continuation_solve(f, f->work);
    return sqrt(dot(f, f->work, f->work));
}

static double projection_bound(lw_continuation *f, const lw_body_frame *at, double reach)
{
    const lw_system *s = f->s;
    double sum = 0.0;
    for (int k = 0; k < s->n_joint; k++) {
        const lw_system_joint *j = &s->joint[k];
        if (lw_joint_slides(j->kind))
            sum += row_gain(f, j->row)*projection_norm(j, at, reach);
        for (int side = 0; side < 2 && lw_joint_has_ratio(j->kind); side++)
            if (j->slider[side] >= 0)
                sum += row_gain(f, j->row)*projection_norm(&s->joint[j->slider[side]], at, reach)
                     * (side == 1 ? 1.0 : fabs(j->ratio))/(1.0 + fabs(j->ratio));
    }
    for (int i = 0; i < f->n_held; i++) {
        const lw_system_joint *j = &s->joint[s->input_joint[f->held[i]]];
        if (lw_joint_slides(j->kind))
            sum += row_gain(f, s->n_row + i)*projection_norm(j, at, reach);
    }
    return sum;
}

double lw_continuation_bound(lw_continuation *f, const double *q)
{
    const lw_body_frame *at = f->frame;
    lw_system_place(f->s, q, f->frame);
    f->rough = true;
    double pins = pin_bound(f, at), slides = projection_bound(f, at, 0.0);
    if (slides > 0.0)                       /* the reach without growth is larger than the reach with it */
        slides = projection_bound(f, at, 1.0/(pins + slides));
    f->rough = false;
    f->kappa = fmax(pins + slides, 1e-3);
    return f->kappa;
}

/* ---- series ------------------------------------------------------------------------------------ */

void lw_continuation_series(lw_continuation *f, int order, const double *value, double *q)
{
    const lw_system *s = f->s;
    double count[LW_SYSTEM_ORDER_MAX + 1];
    for (int k = 1; k <= order; k++) {
        double *c = q + (long)k*f->n;
        memset(c, 0, (size_t)f->n*sizeof *c);
        lw_system_series(s, k, q, f->series);
        memset(f->work, 0, (size_t)f->m*sizeof *f->work);
        for (int r = 0; r < s->n_row; r++)
            f->work[r] = -f->series[(long)k*s->n_row + r];
        for (int i = 0; i < f->n_held; i++) {
            lw_system_measure_series(s, s->input_joint[f->held[i]], k, q, count);
            f->work[s->n_row + i] = (value ? value[i*(order + 1) + k] : 0.0) - count[k];
        }
        if (f->plane)
            f->work[f->m - 1] = k == 1 ? 1.0 : 0.0;
        lw_continuation_solve(f, f->work);
        memcpy(c, f->work, (size_t)f->n*sizeof *c);
    }
}

double lw_continuation_misfit(lw_continuation *f, int order, const double *value, const double *q, double *rate)
{
    const lw_system *s = f->s;
    double count[LW_SYSTEM_ORDER_MAX + 1], scale = 1.0, most = 0.0;
    bool given = *rate > 0.0;
    for (int k = 1; k <= order && !given; k++) {
        double greatest = 0.0;
        for (int i = 0; i < f->n; i++)
            greatest = fmax(greatest, fabs(q[(long)k*f->n + i]));
        for (int i = 0; i < f->n_held; i++)
            greatest = fmax(greatest, fabs(value[i*(order + 1) + k]));
        *rate = fmax(*rate, pow(greatest, 1.0/k));
    }
    lw_system_series(s, order, q, f->series);
    for (int k = 1; k <= order && *rate > 0.0; k++) {
        scale *= *rate;
        for (int r = 0; r < s->n_row; r++)
            most = fmax(most, fabs(f->series[(long)k*s->n_row + r])/scale);
        for (int i = 0; i < f->n_held; i++) {
            lw_system_measure_series(s, s->input_joint[f->held[i]], k, q, count);
            most = fmax(most, fabs(count[k] - value[i*(order + 1) + k])/scale);
        }
    }
    return most;
}

void lw_continuation_sum(const lw_continuation *f, int order, const double *q, double h, double *out)
{
    for (int i = 0; i < f->n; i++) {
        double sum = q[(long)order*f->n + i];
        for (int k = order - 1; k >= 0; k--)
            sum = sum*h + q[(long)k*f->n + i];
        out[i] = sum;
    }
}

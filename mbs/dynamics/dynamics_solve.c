/* mbs/dynamics/dynamics_solve.c - rows, factors, accelerations and reactions at one moment. */
#include "mbs/dynamics/dynamics_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double weakest_fast = 1e-4;     /* pivots below this are left to the sure way              */
static const double no_rank = 1e-9;          /* diagonals of the sure way below this count as 0         */

/* ---- rows -------------------------------------------------------------------------------------- */

lw_status lw_mbs_motion(const lw_dynamics *d, int i, double t, double out[3])
{
    int input = d->driven[i], j = d->s.input_joint[input];
    const lw_expression *x = d->model->motion[input];
    const int *which;
    double series[3] = { t, 1, 0 };
    int n = lw_expression_variables(x, &which);
    double scale = d->s.joint[j].kind == LW_JOINT_REVOLUTE ? 1 : 1/d->s.unit;
    (void)n;
    lw_expression_series(x, 2, series, out);
    out[0] = (out[0] - d->s.input_value[input])*scale;
    out[1] *= scale;
    out[2] *= 2*scale;
    return isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]) ? LW_OK : LW_E_NUMERIC;
}

static double stop_value(const lw_dynamics *d, const lw_contact *c)
{
    const lw_joint_stop *p = &d->model->stop[c->joint];
    double scale = d->s.joint[c->joint].kind == LW_JOINT_REVOLUTE ? 1 : 1/d->s.unit;
    return (c->greatest ? p->greatest : p->least)*scale;
}

lw_status lw_mbs_rows(lw_dynamics *d, double t, const double *q)
{
    const lw_system *s = &d->s;
    int row = s->n_row;
    lw_system_place(s, q, &d->frames);
    for (int r = 0; r < d->n_c; r++)                 /* elsewhere it is 0 since the rows were arranged */
        for (int k = 0; k < LW_SYSTEM_ROW_BODIES && d->row_body[r][k] >= 0; k++)
            memset(d->jac + r*d->n_q + 3*d->row_body[r][k], 0, 3*sizeof *d->jac);
    lw_system_fill(s, &d->frames, d->phi, d->jac, d->n_q, 1);
    for (int i = 0; i < d->n_driven; i++, row++) {
        double motion[3];
        if (lw_mbs_motion(d, i, t, motion) != LW_OK)
            return lw_error_set(d->e, LW_E_NUMERIC, "the motion of input \"%s\" is not a number at t = %.9g s",
                                d->model->linkage.joint[s->input_joint[d->driven[i]]].name, t);
        d->phi[row] = lw_system_count(s, &d->frames, s->input_joint[d->driven[i]], d->jac + row*d->n_q, 1) - motion[0];
    }
    for (int i = 0; i < d->n_touching; i++, row++) {
        const lw_contact *c = &d->contact[d->touching[i]];
        d->phi[row] = lw_system_count(s, &d->frames, c->joint, d->jac + row*d->n_q, 1) - stop_value(d, c);
    }
    return LW_OK;
}

lw_status lw_mbs_rate_wanted(lw_dynamics *d, double t)
{
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    for (int i = 0; i < d->n_driven; i++) {
        double motion[3];
        if (lw_mbs_motion(d, i, t, motion) != LW_OK)
            return LW_E_NUMERIC;
        d->rhs[d->n_row + i] = motion[1];
    }
    return LW_OK;
}

/* A joint's points, their velocities and what their acceleration is without any of the coordinates'. */
typedef struct swing { lw_vec2 d, dd, ddd, u, du, ddu; } swing;

static swing swing_of(const lw_dynamics *d, const lw_system_joint *j, const double *v)
{
    swing z;
    lw_vec2 p[2], dp[2], ddp[2];
    double w[2];
    for (int end = 0; end < 2; end++) {
        int b = j->body[end];
        lw_vec2 r = lw_v2_turn(j->arm[end], d->frames.dir[b + 1]);
        w[end] = b < 0 ? 0 : v[3*b + 2];
        p[end] = lw_v2_add(d->frames.at[b + 1], r);
        dp[end] = lw_v2_add(b < 0 ? lw_v2(0, 0) : lw_v2(v[3*b], v[3*b + 1]), lw_v2_scale(lw_v2_perp(r), w[end]));
        ddp[end] = lw_v2_scale(r, -w[end]*w[end]);
    }
    z.d = lw_v2_sub(p[1], p[0]);
    z.dd = lw_v2_sub(dp[1], dp[0]);
    z.ddd = lw_v2_sub(ddp[1], ddp[0]);
    z.u = lw_v2_turn(j->along, d->frames.dir[j->body[0] + 1]);
    z.du = lw_v2_scale(lw_v2_perp(z.u), w[0]);
    z.ddu = lw_v2_scale(z.u, -w[0]*w[0]);
    return z;
}

/* The second rate of what a joint counts, less J a. */
static double count_bias(const lw_dynamics *d, int joint, const double *v)
{
    const lw_system_joint *j = &d->s.joint[joint];
    if (j->kind != LW_JOINT_SLIDER && j->kind != LW_JOINT_SLOT)
        return 0;
    swing z = swing_of(d, j, v);
    return lw_v2_dot(z.ddu, z.d) + 2*lw_v2_dot(z.du, z.dd) + lw_v2_dot(z.u, z.ddd);
}

static void joint_bias(lw_dynamics *d, const lw_system_joint *j, const double *v)
{
    double *to = d->rhs + j->row;
    swing z;
    switch (j->kind) {
    case LW_JOINT_REVOLUTE: case LW_JOINT_FIXED:
        z = swing_of(d, j, v);
        to[0] = -z.ddd.x;
        to[1] = -z.ddd.y;
        break;
    case LW_JOINT_SLIDER: case LW_JOINT_SLOT:
        z = swing_of(d, j, v);
        to[0] = -lw_v2_cross(z.ddu, z.d) - 2*lw_v2_cross(z.du, z.dd) - lw_v2_cross(z.u, z.ddd);
        break;
    case LW_JOINT_GEAR:
        for (int side = 0; side < 2; side++)
            if (j->slider[side] >= 0)
                to[0] -= lw_system_gear_factor(j, side)*j->slider_sign[side]*count_bias(d, j->slider[side], v);
    }
}

static lw_status acceleration_wanted(lw_dynamics *d, double t, const double *v)
{
    int row = d->n_row;
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    for (int j = 0; j < d->s.n_joint; j++)
        joint_bias(d, &d->s.joint[j], v);
    for (int i = 0; i < d->n_driven; i++, row++) {
        double motion[3];
        if (lw_mbs_motion(d, i, t, motion) != LW_OK)
            return LW_E_NUMERIC;
        d->rhs[row] = motion[2] - count_bias(d, d->s.input_joint[d->driven[i]], v);
    }
    for (int i = 0; i < d->n_touching; i++, row++)
        d->rhs[row] = -count_bias(d, d->contact[d->touching[i]].joint, v);
    return LW_OK;
}

/* ---- the fast way ------------------------------------------------------------------------------ */

/* S = J M^-1 J^T over the kept rows, upper triangle: entry (i, j) at schur[i*n + j], only those of the pattern. */
static void form_schur(lw_dynamics *d)
{
    int n = d->n_kept, q = d->n_q;
    const double *by_mass = d->by_mass;
    for (int i = 0; i < n; i++) {
        double *row = d->schur + i*n;
        row[i] = 0;
        for (int k = d->after_at[i]; k < d->after_at[i + 1]; k++)
            row[d->after[k]] = 0;
    }
    for (int p = 0; p < d->n_pair; p++) {
        const lw_pair *pair = &d->pair[p];
        int at = 3*pair->body;
        const double *a = d->jac + pair->row*q + at, *b = d->jac + pair->other*q + at, *m = by_mass + at;
        d->schur[pair->to] += (a[0]*b[0] + a[1]*b[1])*m[0] + a[2]*b[2]*m[2];
    }
}

/* S = U^T U by rows, over the pattern; d->weak: least pivot over its diagonal. */
static void cholesky(lw_dynamics *d)
{
    int n = d->n_kept;
    for (int i = 0; i < n; i++)
        d->diag[i] = d->schur[i*n + i];
    d->weak = 1;
    for (int i = 0; i < n; i++) {
        double *row = d->schur + i*n, pivot = row[i];
        const int *after = d->after + d->after_at[i];
        int m = d->after_at[i + 1] - d->after_at[i];
        d->weak = fmin(d->weak, pivot/d->diag[i]);
        if (!(pivot > 0)) {
            d->weak = 0;
            return;
        }
        double factor = d->diag[i] = 1/sqrt(pivot);
        for (int k = 0; k < m; k++)
            row[after[k]] *= factor;
        for (int k = 0; k < m; k++) {
            double *below = d->schur + after[k]*n, x = row[after[k]];
            for (int j = k; j < m; j++)
                below[after[j]] -= x*row[after[j]];
        }
    }
}

/* S x = b over the kept rows, in place. */
static void schur_solve(const lw_dynamics *d, double *b)
{
    int n = d->n_kept;
    for (int i = 0; i < n; i++) {
        const double *row = d->schur + i*n;
        double x = b[i] *= d->diag[i];
        for (int k = d->after_at[i]; k < d->after_at[i + 1]; k++)
            b[d->after[k]] -= row[d->after[k]]*x;
    }
    for (int i = n - 1; i >= 0; i--) {
        const double *row = d->schur + i*n;
        double sum = b[i];
        for (int k = d->after_at[i]; k < d->after_at[i + 1]; k++)
            sum -= row[d->after[k]]*b[d->after[k]];
        b[i] = sum*d->diag[i];
    }
}

static double row_dot(const lw_dynamics *d, int row, const double *x)
{
    const double *jac = d->jac + row*d->n_q;
    double sum = 0;
    for (int k = 0; k < LW_SYSTEM_ROW_BODIES && d->row_body[row][k] >= 0; k++) {
        int at = 3*d->row_body[row][k];
        sum += jac[at]*x[at] + jac[at + 1]*x[at + 1] + jac[at + 2]*x[at + 2];
    }
    return sum;
}

/* x += sign J^T l, the rows of l */
static void add_rows(const lw_dynamics *d, double sign, const double *l, double *x)
{
    for (int r = 0; r < d->n_c; r++) {
        const double *jac = d->jac + r*d->n_q;
        for (int k = 0; l[r] != 0 && k < LW_SYSTEM_ROW_BODIES && d->row_body[r][k] >= 0; k++) {
            int at = 3*d->row_body[r][k];
            for (int i = at; i < at + 3; i++)
                x[i] += sign*l[r]*jac[i];
        }
    }
}

/* x = M^-1 (Q - J^T l), J x = rhs */
static void fast_solve(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
{
    double *b = d->small;
    for (int i = 0; i < d->n_q; i++)
        x[i] = force ? force[i]*d->by_mass[i] : 0;
    for (int i = 0; i < d->n_kept; i++)
        b[i] = row_dot(d, d->kept[i], x) - rhs[d->kept[i]];
    schur_solve(d, b);
    memset(l, 0, (size_t)d->n_c*sizeof *l);
    for (int i = 0; i < d->n_kept; i++)
        l[d->kept[i]] = b[i];
    double *push = d->bias;
    memset(push, 0, (size_t)d->n_q*sizeof *push);
    add_rows(d, -1, l, push);
    for (int i = 0; i < d->n_q; i++)
        x[i] += push[i]*d->by_mass[i];
}

/* ---- the sure way ------------------------------------------------------------------------------ */

/* N^T M N by Cholesky; LW_E_ARG names the link whose motion has no mass. */
static lw_status factor_null(lw_dynamics *d)
{
    int n = d->freedom, q = d->n_q;
    double *m = d->mass_null, top = 0;
    for (int i = 0; i < n; i++)
        lw_rank_left_null(&d->rank_of, i, d->null + i*q);
    for (int i = 0; i < q; i++)
        top = fmax(top, d->f.mass[i]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (int k = 0; k < q; k++)
                sum += d->null[i*q + k]*d->f.mass[k]*d->null[j*q + k];
            for (int k = 0; k < j; k++)
                sum -= m[i*n + k]*m[j*n + k];
            if (j < i) {
                m[i*n + j] = sum/m[j*n + j];
                continue;
            }
            if (!(sum > 1e-14*top)) {
                int worst = 0;
                for (int k = 0; k < q; k++)
                    worst = fabs(d->null[i*q + k]) > fabs(d->null[i*q + worst]) ? k : worst;
                return lw_error_set(d->e, LW_E_ARG, "link \"%s\" can move without moving any mass: give it a \"mass\" "
                                    "and an \"inertia\", or hold it",
                                    d->model->linkage.link_name[d->s.link[worst/3]]);
            }
            m[i*n + i] = sqrt(sum);
        }
    }
    return LW_OK;
}

static void null_solve(const lw_dynamics *d, double *b)
{
    int n = d->freedom;
    const double *m = d->mass_null;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= m[i*n + k]*b[k];
        b[i] /= m[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= m[k*n + i]*b[k];
        b[i] /= m[i*n + i];
    }
}

/* x += N (N^T M N)^-1 N^T (force - M x) */
static lw_status add_free(lw_dynamics *d, const double *force, double *x)
{
    int n = d->freedom, q = d->n_q;
    double b[LW_SYSTEM_Q_MAX];
    lw_status s = d->null_ready ? LW_OK : factor_null(d);
    if (s != LW_OK)
        return s;
    d->null_ready = true;
    for (int i = 0; i < n; i++) {
        b[i] = 0;
        for (int k = 0; k < q; k++)
            b[i] += d->null[i*q + k]*((force ? force[k] : 0) - d->f.mass[k]*x[k]);
    }
    null_solve(d, b);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < q; k++)
            x[k] += b[i]*d->null[i*q + k];
    return LW_OK;
}

static lw_status sure_solve(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
{
    lw_rank_solve_transposed(&d->rank_of, rhs, x);
    lw_status s = add_free(d, force, x);
    for (int i = 0; i < d->n_q; i++)
        d->bias[i] = (force ? force[i] : 0) - d->f.mass[i]*x[i];
    lw_rank_solve(&d->rank_of, d->bias, l);
    return s;
}

static void factor_rank(lw_dynamics *d)
{
    for (int r = 0; r < d->n_c; r++)
        memcpy(d->rank_of.a + r*d->n_q, d->jac + r*d->n_q, (size_t)d->n_q*sizeof *d->jac);
    d->rank_of.most = d->rank;               /* off the constraints redundant rows are not quite so */
    lw_rank_factor(&d->rank_of, no_rank);
    d->null_ready = false;
}

/* ---- either -------------------------------------------------------------------------------------- */

lw_status lw_mbs_factor(lw_dynamics *d, bool sure)
{
    d->sure = sure || d->has_zero_mass;
    if (!d->sure) {
        form_schur(d);
        cholesky(d);
        d->sure = !(d->weak > weakest_fast);
    }
    if (!d->sure)
        return LW_OK;
    factor_rank(d);
    if (d->has_zero_mass)
        d->weak = d->rank_of.weakest*d->rank_of.weakest;
    return d->rank_of.rank < d->rank ? LW_OPEN : LW_OK;
}

lw_status lw_mbs_linear(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
{
    if (d->sure)
        return sure_solve(d, force, rhs, x, l);
    fast_solve(d, force, rhs, x, l);
    return LW_OK;
}

lw_status lw_mbs_solve(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                       double *power)
{
    lw_forces_apply(&d->f, t, q, v, d->force, NULL, NULL, power);
    for (int i = 0; i < d->n_q; i++)
        if (!isfinite(d->force[i]))
            return lw_error_set(d->e, LW_E_NUMERIC, "a force on link \"%s\" is not a number at t = %.9g s",
                                d->model->linkage.link_name[d->s.link[i/3]], t);
    if (acceleration_wanted(d, t, v) != LW_OK)
        return LW_E_NUMERIC;
    lw_status s = lw_mbs_linear(d, d->force, d->rhs, a, l);
    return s == LW_OK && d->n_friction ? lw_mbs_friction(d, q, v, a, l, power) : s;
}

lw_status lw_mbs_accelerate(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                            double *power)
{
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    if (s != LW_OK || !d->sure || d->has_zero_mass)
        return s == LW_OK ? lw_mbs_solve(d, t, q, v, a, l, power) : s;
    /* Near a singular posture what lies off the constraints is magnified: put it on them first. */
    memcpy(d->q_try, q, (size_t)d->n_q*sizeof *q);
    memcpy(d->v_try, v, (size_t)d->n_q*sizeof *v);
    s = lw_mbs_settle(d, t, d->q_try, d->v_try);
    return s == LW_OK ? lw_mbs_solve(d, t, d->q_try, d->v_try, a, l, power) : s;
}

double lw_mbs_impulse(lw_dynamics *d, const double *g, double *change)
{
    double whole = 0;
    if (d->sure) {
        memset(change, 0, (size_t)d->n_q*sizeof *change);
        if (add_free(d, g, change) != LW_OK)
            return 0;
    } else {
        memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
        fast_solve(d, g, d->rhs, change, d->l_each);
    }
    for (int i = 0; i < d->n_q; i++)
        whole += g[i]*change[i];
    return whole;
}

/* ---- onto the constraints ------------------------------------------------------------------------ */

static double greatest(const double *x, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = !(fabs(x[i]) <= most) ? fabs(x[i]) : most;
    return most;
}

/* x with J x = rhs, the least in the metric of the masses or of the coordinates. */
static void least_change(lw_dynamics *d, const double *rhs, double *x)
{
    if (d->sure)
        lw_rank_solve_transposed(&d->rank_of, rhs, x);
    else
        fast_solve(d, NULL, rhs, x, d->l_each);
}

lw_status lw_mbs_project_q(lw_dynamics *d, double t, double *q, double far)
{
    double *step = d->hold, before = INFINITY;
    for (int pass = 0; pass < 12; pass++) {
        lw_status s = lw_mbs_rows(d, t, q);
        if (s != LW_OK)
            return s;
        double off = greatest(d->phi, d->n_c);
        if (!(off < INFINITY))
            return LW_E_NUMERIC;
        if (off <= 4*DBL_EPSILON || (off < 1e-12 && off >= 0.5*before)) {
            if (pass == 0)
                s = lw_mbs_factor(d, false);
            return s;
        }
        before = off;
        /* factors of the step before serve when little has changed since */
        if ((pass < 1 || off > 1e-7) && (s = lw_mbs_factor(d, d->has_zero_mass || d->sure)) != LW_OK)
            return s;
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] = -d->phi[r];
        least_change(d, d->rhs, step);
        if (!(greatest(step, d->n_q) <= far))
            return LW_OPEN;
        for (int i = 0; i < d->n_q; i++)
            q[i] += step[i];
    }
    return LW_OPEN;
}

/* Rows and factors are those of q. */
lw_status lw_mbs_project_v(lw_dynamics *d, double t, const double *q, double *v)
{
    double *step = d->hold, *want = d->l_each + d->n_c;
    (void)q;
    for (int pass = 0; pass < 8; pass++) {
        if (lw_mbs_rate_wanted(d, t) != LW_OK)
            return LW_E_NUMERIC;
        double off = 0, size = greatest(v, d->n_q);
        for (int r = 0; r < d->n_c; r++) {
            want[r] = d->rhs[r] - row_dot(d, r, v);
            off = fmax(off, fabs(want[r]));
        }
        if (off <= 4*DBL_EPSILON*size)
            return LW_OK;
        least_change(d, want, step);
        for (int i = 0; i < d->n_q; i++)
            v[i] += step[i];
    }
    return LW_OK;
}

lw_status lw_mbs_settle(lw_dynamics *d, double t, double *q, double *v)
{
    lw_status s = lw_mbs_project_q(d, t, q, 0.1);
    return s == LW_OK ? lw_mbs_project_v(d, t, q, v) : s;
}

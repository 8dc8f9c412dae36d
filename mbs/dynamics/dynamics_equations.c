/* mbs/dynamics/dynamics_equations.c - rows, factors, accelerations and reactions at one moment. */
#include "mbs/dynamics/dynamics_equations_internal.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/sparse.h"
#include "mbs/dynamics/friction.h"

static const double least_pivot = 1e-4;     /* relative pivots below this: solve by rank */

/* ---- rows -------------------------------------------------------------------------------------- */

lw_status lw_mbs_motion(const lw_dynamics *d, int i, double t, double out[3])
{
    return lw_input_motion(d->model, &d->s, d->driven[i], t, out);
}

lw_status lw_mbs_rows(lw_dynamics *d, double t, const double *q)
{
    const lw_system *s = &d->s;
    int row = s->n_row;
    lw_system_place(s, q, d->frames);
    for (int r = 0; r < d->n_c; r++)                 /* other entries are 0 since lw_mbs_arrange */
        for (int k = 0; k < LW_SYSTEM_ROW_BODIES && d->row_body[r][k] >= 0; k++)
            memset(d->jac + r*d->n_q + 3*d->row_body[r][k], 0, 3*sizeof *d->jac);
    lw_system_fill(s, d->frames, d->phi, d->jac, d->n_q, 1);
    for (int i = 0; i < d->n_driven; i++, row++) {
        double motion[3];
        if (lw_mbs_motion(d, i, t, motion) != LW_OK)
            return lw_error_set(d->e, LW_E_NUMERIC, "the motion of input \"%s\" is not a number at t = %.9g s",
                                d->model->linkage.joint[s->input_joint[d->driven[i]]].name, t);
        d->phi[row] = lw_system_count(s, d->frames, s->input_joint[d->driven[i]], d->jac + row*d->n_q, 1) - motion[0];
    }
    for (int i = 0; i < d->n_resting; i++, row++) {
        const lw_rigid_stop *stop = &d->stop[d->resting[i]];
        d->phi[row] = lw_system_count(s, d->frames, stop->joint, d->jac + row*d->n_q, 1) - stop->limit;
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

/* The two points of a joint and their relative motion, with the part of the acceleration that velocities cause. */
typedef struct joint_motion { lw_vec2 d, dd, ddd, u, du, ddu; } joint_motion;

static joint_motion joint_motion_of(const lw_dynamics *d, const lw_system_joint *j, const double *v)
{
    joint_motion z;
    lw_vec2 p[2], dp[2], ddp[2];
    double w[2];
    for (int end = 0; end < 2; end++) {
        int b = j->body[end];
        lw_vec2 r = lw_v2_turn(j->arm[end], d->frames[b + 1].dir);
        w[end] = b < 0 ? 0 : v[3*b + 2];
        p[end] = lw_v2_add(d->frames[b + 1].at, r);
        dp[end] = lw_v2_add(b < 0 ? lw_v2(0, 0) : lw_v2(v[3*b], v[3*b + 1]), lw_v2_scale(lw_v2_perp(r), w[end]));
        ddp[end] = lw_v2_scale(r, -w[end]*w[end]);
    }
    z.d = lw_v2_sub(p[1], p[0]);
    z.dd = lw_v2_sub(dp[1], dp[0]);
    z.ddd = lw_v2_sub(ddp[1], ddp[0]);
    z.u = lw_v2_turn(j->along, d->frames[j->body[0] + 1].dir);
    z.du = lw_v2_scale(lw_v2_perp(z.u), w[0]);
    z.ddu = lw_v2_scale(z.u, -w[0]*w[0]);
    return z;
}

/* Second rate of the measure of a joint, without J a. */
static double count_bias(const lw_dynamics *d, int joint, const double *v)
{
    const lw_system_joint *j = &d->s.joint[joint];
    if (!lw_joint_slides(j->kind))
        return 0;
    joint_motion z = joint_motion_of(d, j, v);
    return lw_v2_dot(z.ddu, z.d) + 2*lw_v2_dot(z.du, z.dd) + lw_v2_dot(z.u, z.ddd);
}

static void joint_bias(lw_dynamics *d, const lw_system_joint *j, const double *v)
{
    double *to = d->rhs + j->row;
    joint_motion z;
    if (lw_joint_holds_point(j->kind)) {
        z = joint_motion_of(d, j, v);
        to[0] = -z.ddd.x;
        to[1] = -z.ddd.y;
    } else if (lw_joint_slides(j->kind)) {
        z = joint_motion_of(d, j, v);
        to[0] = -lw_v2_cross(z.ddu, z.d) - 2*lw_v2_cross(z.du, z.dd) - lw_v2_cross(z.u, z.ddd);
    }
    if (lw_joint_has_ratio(j->kind))
        for (int side = 0; side < 2; side++)
            if (j->slider[side] >= 0)
                to[0] -= lw_system_gear_factor(j, side)*j->slider_sign[side]*count_bias(d, j->slider[side], v);
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
    for (int i = 0; i < d->n_resting; i++, row++)
        d->rhs[row] = -count_bias(d, d->stop[d->resting[i]].joint, v);
    return LW_OK;
}

/* ---- the fast way ------------------------------------------------------------------------------ */

/* S = J M^-1 J^T over the kept rows, upper triangle: entry (i, j) at schur[i*n + j], only entries of the pattern. */
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
        const lw_row_pair *pair = &d->pair[p];
        int at = 3*pair->body;
        const double *a = d->jac + pair->row*q + at, *b = d->jac + pair->other*q + at, *m = by_mass + at;
        d->schur[pair->to] += (a[0]*b[0] + a[1]*b[1])*m[0] + a[2]*b[2]*m[2];
    }
}

/* S = U^T U by rows, over the pattern.  d->weak: least pivot over its diagonal. */
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

/* Solve S x = b over the kept rows, in place. */
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

/* ---- by rank ------------------------------------------------------------------------------ */

/* Factor N^T M N by Cholesky's method.  LW_E_ARG names the link whose motion has no mass. */
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

static lw_status solve_by_rank(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
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
    d->rank_of.most = d->rank;               /* off the constraints, redundant rows look independent */
    lw_rank_factor(&d->rank_of, LW_RANK_TOLERANCE);
    d->null_ready = false;
}

/* ---- either -------------------------------------------------------------------------------------- */

lw_status lw_mbs_factor(lw_dynamics *d, bool by_rank)
{
    d->by_rank = by_rank || d->has_zero_mass;
    if (!d->by_rank) {
        form_schur(d);
        cholesky(d);
        d->by_rank = !(d->weak > least_pivot);
    }
    if (!d->by_rank)
        return LW_OK;
    factor_rank(d);
    if (d->has_zero_mass)
        d->weak = d->rank_of.weakest*d->rank_of.weakest;
    return d->rank_of.rank < d->rank ? LW_OPEN : LW_OK;
}

lw_status lw_mbs_linear(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
{
    if (d->by_rank)
        return solve_by_rank(d, force, rhs, x, l);
    fast_solve(d, force, rhs, x, l);
    return LW_OK;
}

/* ---- friction ------------------------------------------------------------------------------------- */

/* a and l, found without friction, become those with it. */
static lw_status add_friction(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                              double *power)
{
    int n = d->n_friction, stride = d->n_q + d->n_c;
    double size[LW_JOINT_MAX], unit_power[LW_JOINT_MAX];
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    lw_status s = LW_OK;
    for (int j = 0; s == LW_OK && j < n; j++) {
        double *to = d->response + j*stride;
        unit_power[j] = lw_friction_force(&d->s, &d->friction[j], q, v, d->force);
        s = lw_mbs_linear(d, d->force, d->rhs, to, to + d->n_q);
    }
    if (s == LW_OK)
        s = lw_friction_add(d->model, &d->s, n, d->friction, d->friction_row, d->response, t, d->n_q, a, d->n_c, l,
                            size, d->e);
    for (int j = 0; s == LW_OK && power && j < n; j++)
        *power += size[j]*unit_power[j];
    return s;
}

/* ---- accelerations -------------------------------------------------------------------------------- */

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
    return s == LW_OK && d->n_friction ? add_friction(d, t, q, v, a, l, power) : s;
}

lw_status lw_mbs_accelerate(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                            double *power)
{
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    if (s != LW_OK || !d->by_rank || d->has_zero_mass)
        return s == LW_OK ? lw_mbs_solve(d, t, q, v, a, l, power) : s;
    /* Near a singular posture residuals of the constraints are magnified: project first. */
    memcpy(d->q_try, q, (size_t)d->n_q*sizeof *q);
    memcpy(d->v_try, v, (size_t)d->n_q*sizeof *v);
    s = lw_mbs_settle(d, t, d->q_try, d->v_try);
    return s == LW_OK ? lw_mbs_solve(d, t, d->q_try, d->v_try, a, l, power) : s;
}

double lw_mbs_impulse(lw_dynamics *d, const double *g, double *change)
{
    double whole = 0;
    if (d->by_rank) {
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

/* The least x with J x = rhs, in the metric of the masses or of the coordinates. */
static void least_change(lw_dynamics *d, const double *rhs, double *x)
{
    if (d->by_rank)
        lw_rank_solve_transposed(&d->rank_of, rhs, x);
    else
        fast_solve(d, NULL, rhs, x, d->l_each);
}

lw_status lw_mbs_project_q(lw_dynamics *d, double t, double *q, double longest)
{
    double *step = d->hold, before = INFINITY;
    for (int pass = 0; pass < 12; pass++) {
        lw_status s = lw_mbs_rows(d, t, q);
        if (s != LW_OK)
            return s;
        double off = greatest(d->phi, d->n_c);
        if (!(off < INFINITY))
            return LW_E_NUMERIC;
        /* rounding of the rows grows with the distance travelled */
        if (off <= 4*DBL_EPSILON || (off < 1e-12*fmax(1, greatest(q, d->n_q)) && off >= 0.5*before)) {
            if (pass == 0)
                s = lw_mbs_factor(d, false);
            return s;
        }
        before = off;
        /* the factors of the last pass serve when little has changed since */
        if ((pass < 1 || off > 1e-7) && (s = lw_mbs_factor(d, d->has_zero_mass || d->by_rank)) != LW_OK)
            return s;
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] = -d->phi[r];
        least_change(d, d->rhs, step);
        if (!(greatest(step, d->n_q) <= longest))
            return LW_OPEN;
        for (int i = 0; i < d->n_q; i++)
            q[i] += step[i];
    }
    return LW_OPEN;
}

/* Rows and factors are those at q. */
lw_status lw_mbs_project_v(lw_dynamics *d, double t, double *v)
{
    double *step = d->hold, *missing = d->l_each + d->n_c;
    for (int pass = 0; pass < 8; pass++) {
        if (lw_mbs_rate_wanted(d, t) != LW_OK)
            return LW_E_NUMERIC;
        double off = 0, size = greatest(v, d->n_q);
        for (int r = 0; r < d->n_c; r++) {
            missing[r] = d->rhs[r] - row_dot(d, r, v);
            off = fmax(off, fabs(missing[r]));
        }
        if (off <= 4*DBL_EPSILON*size)
            return LW_OK;
        least_change(d, missing, step);
        for (int i = 0; i < d->n_q; i++)
            v[i] += step[i];
    }
    return LW_OK;
}

lw_status lw_mbs_settle(lw_dynamics *d, double t, double *q, double *v)
{
    lw_status s = lw_mbs_project_q(d, t, q, 0.1);
    return s == LW_OK ? lw_mbs_project_v(d, t, v) : s;
}

/* ---- rows and who shares bodies ------------------------------------------------------------------ */

static void find_row_bodies(lw_dynamics *d)
{
    int row = d->n_row;
    for (int r = 0; r < d->n_row; r++)
        lw_system_row_bodies(&d->s, r, d->row_body[r]);
    for (int i = 0; i < d->n_driven; i++)
        lw_system_joint_bodies(&d->s, d->s.input_joint[d->driven[i]], d->row_body[row++]);
    for (int i = 0; i < d->n_resting; i++)
        lw_system_joint_bodies(&d->s, d->stop[d->resting[i]].joint, d->row_body[row++]);
}

enum { SHARED = LW_SYSTEM_ROW_BODIES*LW_SYSTEM_ROW_BODIES };

/* Body that two rows share as number k/4 of the first and k%4 of the second; -1: none. */
static int shared_body(const lw_dynamics *d, int row, int other, int k)
{
    int b = d->row_body[row][k/LW_SYSTEM_ROW_BODIES];
    return b >= 0 && b == d->row_body[other][k%LW_SYSTEM_ROW_BODIES] ? b : -1;
}

/* Pattern of J M^-1 J^T: near[i*n + j] for places i, j among the kept rows. */
static void find_meetings(const lw_dynamics *d, unsigned char *near)
{
    int n = d->n_kept;
    memset(near, 0, (size_t)n*(size_t)n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; i != j && k < SHARED; k++)
                near[i*n + j] |= shared_body(d, d->kept[i], d->kept[j], k) >= 0;
}

/* Order the kept rows for elimination, and find the pattern of U. */
static void order_rows(lw_dynamics *d)
{
    int n = d->n_kept, order[LW_MBS_ROW_MAX], kept[LW_MBS_ROW_MAX], used = 0;
    find_meetings(d, d->near);
    lw_sparse_order(n, d->near, order);
    memcpy(kept, d->kept, (size_t)n*sizeof *kept);
    for (int i = 0; i < n; i++) {
        d->kept[i] = kept[order[i]];
        d->place[d->kept[i]] = i;
        d->after_at[i] = used;
        for (int j = i + 1; j < n; j++)
            if (d->near[order[i]*n + order[j]])
                d->after[used++] = j;
    }
    d->after_at[n] = used;
}

static int compare(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

/* Pairs of kept rows that share a body, the later row first: the upper triangle of J M^-1 J^T. */
static void find_pairs(lw_dynamics *d)
{
    int n = d->n_kept;
    d->n_pair = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++)
            for (int k = 0; k < SHARED; k++) {
                int b = shared_body(d, d->kept[i], d->kept[j], k);
                if (b >= 0)
                    d->pair[d->n_pair++] = (lw_row_pair){ d->kept[i], d->kept[j], b, j*n + i };
            }
    assert(d->n_pair <= d->most_pair*LW_SYSTEM_ROW_BODIES);
}

/* Keep a basis of the rows, as the factorisation found it. */
static void keep_basis(lw_dynamics *d)
{
    d->n_kept = d->rank_of.rank;
    assert(d->n_kept <= d->n_c);
    for (int r = 0; r < d->n_c; r++)
        d->place[r] = -1;
    memcpy(d->kept, d->rank_of.column, (size_t)d->n_kept*sizeof *d->kept);
    qsort(d->kept, (size_t)d->n_kept, sizeof *d->kept, compare);
    order_rows(d);
    find_pairs(d);
}

static void set_rank(lw_dynamics *d, int rank)
{
    d->rank = rank;
    d->freedom = d->n_q - rank;
}

lw_status lw_mbs_arrange(lw_dynamics *d, double t, const double *q)
{
    d->n_c = d->n_row + d->n_driven + d->n_resting;
    assert(d->n_c <= LW_MBS_ROW_MAX);
    find_row_bodies(d);
    memset(d->jac, 0, (size_t)d->n_c*(size_t)d->n_q*sizeof *d->jac);
    lw_rank_place(&d->rank_of, d->n_q, d->n_c, d->rank_work, d->rank_ints);
    lw_status s = lw_mbs_rows(d, t, q);
    if (s != LW_OK)
        return s;
    set_rank(d, 0);
    lw_mbs_factor(d, true);
    set_rank(d, d->rank_of.rank);
    keep_basis(d);
    return LW_OK;
}

/* ---- moments ----------------------------------------------------------------------------------- */

lw_status lw_mbs_measure(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m)
{
    lw_status s = lw_mbs_rows(d, t, q);
    *m = (lw_moment){ .t = t, .q = q, .v = v, .a = d->a, .l = d->l, .work = work };
    if (s == LW_OK)
        s = lw_mbs_rate_wanted(d, t);
    for (int r = 0; s == LW_OK && r < d->n_c; r++) {
        double rate = -d->rhs[r];
        for (int i = 0; i < d->n_q; i++)
            rate += d->jac[r*d->n_q + i]*v[i];
        m->off = fmax(m->off, fabs(d->phi[r]));
        m->off_rate = fmax(m->off_rate, fabs(rate));
    }
    m->kinetic = lw_forces_kinetic(&d->f, v);
    m->potential = lw_forces_potential(&d->f, q);
    m->unique = d->rank == d->n_c;
    return s;
}

lw_status lw_mbs_moment(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m)
{
    lw_status s = lw_mbs_measure(d, t, q, v, work, m);
    if (s == LW_OK)
        s = lw_mbs_factor(d, !m->unique);
    return s == LW_OK ? lw_mbs_solve(d, t, q, v, d->a, d->l, NULL) : s;
}

/* ---- stiffness ---------------------------------------------------------------------------------------- */

/* Fastest decay by dampers times the length of the run; above this an explicit method takes too many steps. */
static const double stiff = 2e4;

/* Speed along a measure for an impulse of 1 [1/kg] or [1/(kg m^2)]. */
static double mobility(lw_dynamics *d, const lw_measure *m)
{
    double g[LW_SYSTEM_Q_MAX] = { 0 }, change[LW_SYSTEM_Q_MAX];
    for (int i = 0; i < 6; i++)
        if (m->body[i/3] >= 0)
            g[3*m->body[i/3] + i%3] += m->g[i];
    return lw_mbs_impulse(d, g, change);
}

/* The fastest decay that dampers cause at the start [1/s]. */
static double fastest_decay(lw_dynamics *d)
{
    const lw_model *model = d->model;
    double most = 0;
    lw_measure m;
    if (lw_mbs_rows(d, d->o.from, d->start_q) != LW_OK || lw_mbs_factor(d, false) != LW_OK)
        return 0;
    for (int i = 0; i < model->n_spring; i++) {
        int body[2] = { d->s.body[model->spring[i].link[0]], d->s.body[model->spring[i].link[1]] };
        lw_measure_length(&d->s, body, d->f.spring_arm[i], d->start_q, d->start_v, false, &m);
        most = fmax(most, model->spring[i].damping*mobility(d, &m));
    }
    for (int i = 0; i < model->n_joint_spring; i++) {
        lw_measure_joint(&d->s, model->joint_spring[i].joint, d->start_q, d->start_v, false, &m);
        most = fmax(most, model->joint_spring[i].damping*mobility(d, &m));
    }
    for (int i = 0; i < model->n_motor; i++) {
        lw_measure_joint(&d->s, model->motor[i].joint, d->start_q, d->start_v, false, &m);
        most = fmax(most, model->motor[i].stall/model->motor[i].free_speed*mobility(d, &m));
    }
    return most;
}

bool lw_mbs_is_stiff(lw_dynamics *d)
{
    if (!d->decay_known)
        d->decay = fastest_decay(d);
    d->decay_known = true;
    return d->decay*(d->o.to - d->o.from) > stiff;
}

/* mbs/dynamics/dynamics_equations.c - rows, factors, accelerations and reactions at one moment. */
#include "base/real.h"
#include "base/vector.h"
#include "mbs/dynamics/dynamics_equations_internal.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/dynamics/touch_internal.h"
#include "mbs/equations/friction.h"

static const double least_pivot = 1e-4;     /* relative pivots below this: solve by rank */
static const double least_pivot_large = 1e-9;     /* the same of large models: singular */
static const double least_pivot_fronts = 1e-11;   /* the same where factors come from the rows of a model that is not large: solve by rank */

/* ---- rows -------------------------------------------------------------------------------------- */

void lw_mbs_driven_inputs(void *context, double t, int order, double *u)
{
    const lw_dynamics *d = context;
    double at[LW_SERIES_ORDER_MAX + 1] = { t, 1 };
    for (int i = 0; i < d->n_driven; i++)
        if (d->model->motion[d->driven[i]])
            lw_expression_series(d->model->motion[d->driven[i]], order, at, u + i*(order + 1));
        else                                                 /* held */
            for (int k = 0; k <= order; k++)
                u[i*(order + 1) + k] = k ? 0 : d->s.input_value[d->driven[i]];
}

lw_status lw_mbs_motion(const lw_dynamics *d, int i, double t, double out[3])
{
    if (!d->frozen)
        return d->eq.motion(d->eq.context, d->driven[i], t, out);
    out[0] = d->held[i], out[1] = out[2] = 0;
    return LW_OK;
}

void lw_mbs_freeze(lw_dynamics *d, const double *q)
{
    d->eq.place(d->eq.context, q);
    for (int i = 0, row = d->n_row; i < d->n_driven; i++, row++)
        d->held[i] = d->eq.measure(d->eq.context, d->driven_measure[i], lw_mbs_jac(d, row), lw_mbs_blocks(d, row));
    d->frozen = true;
}

int lw_mbs_bends(const lw_dynamics *d, int row)
{
    int driven = row - d->n_row;
    return driven < 0 ? d->eq.bends(d->eq.context, row, d->bend)
         : driven < d->n_driven ? d->eq.measure_bends(d->eq.context, d->driven_measure[driven], d->bend) : 0;
}

lw_status lw_mbs_rows(lw_dynamics *d, double t, const double *q)
{
    int row = d->n_row;
    d->eq.place(d->eq.context, q);
    memset(d->jac, 0, (size_t)d->n_c*(size_t)d->row_size*sizeof *d->jac);
    d->eq.rows(d->eq.context, d->phi, d->jac, d->row_block);
    for (int i = 0; i < d->n_driven; i++, row++) {
        double motion[3];
        if (lw_mbs_motion(d, i, t, motion) != LW_OK)
            return lw_error_set(d->e, LW_E_NUMERIC, "the motion of input \"%s\", its rate or its acceleration is not a number at t = %.9g s",
                                d->eq.name(d->eq.context, LW_NAMED_INPUT, d->driven[i]), t);
        d->phi[row] = d->eq.measure(d->eq.context, d->driven_measure[i], lw_mbs_jac(d, row), lw_mbs_blocks(d, row))
                    - motion[0];
    }
    for (int i = 0; i < d->n_resting; i++, row++) {
        const lw_rigid_stop *stop = &d->stop[d->resting[i]];
        d->phi[row] = d->eq.measure(d->eq.context, stop->measure, lw_mbs_jac(d, row), lw_mbs_blocks(d, row))
                    - stop->limit;
    }
    if (d->touch)
        lw_mbs_touch_rows(d, row);
    return LW_OK;
}

void lw_mbs_row(const lw_dynamics *d, int r, double *out)
{
    const int *block = lw_mbs_blocks(d, r);
    memset(out, 0, (size_t)d->n_v*sizeof *out);
    for (int k = 0; k < d->eq.n_slot && block[k] >= 0; k++)
        memcpy(out + LW_BLOCK*block[k], lw_mbs_jac(d, r) + LW_BLOCK*k, LW_BLOCK*sizeof *out);
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

lw_status lw_mbs_acceleration_wanted(lw_dynamics *d, double t, const double *v)
{
    int row = d->n_row;
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    d->eq.bias(d->eq.context, v, d->rhs);
    for (int i = 0; i < d->n_driven; i++, row++) {
        double motion[3];
        if (lw_mbs_motion(d, i, t, motion) != LW_OK)
            return LW_E_NUMERIC;
        d->rhs[row] = motion[2] - d->eq.measure_bias(d->eq.context, d->driven_measure[i], v);
    }
    for (int i = 0; i < d->n_resting; i++, row++)
        d->rhs[row] = -d->eq.measure_bias(d->eq.context, d->stop[d->resting[i]].measure, v);
    if (d->touch)
        lw_mbs_touch_bias(d, row, v);
    return LW_OK;
}

/* ---- the fast way ------------------------------------------------------------------------------ */

void lw_mbs_form_schur(lw_dynamics *d)
{
    double *value = d->schur.value;
    memset(value, 0, (size_t)(d->schur.n_entry + d->schur.n)*sizeof *value);
    for (int i = 0; i < d->n_kept; i++) {
        int row = d->kept[i];
        const int *block = lw_mbs_blocks(d, row);
        const double *jac = lw_mbs_jac(d, row);
        double *to = d->jac_by_mass + row*d->row_size;
        for (int k = 0; k < d->eq.n_slot && block[k] >= 0; k++, jac += LW_BLOCK, to += LW_BLOCK) {
            const double *m = d->by_mass + LW_BLOCK*block[k];
            double n = d->n_weld ? d->parts[block[k]] : 1;
            to[0] = jac[0]*m[0]*n, to[1] = jac[1]*m[1]*n, to[2] = jac[2]*m[2]*n;
        }
    }
    for (int p = 0; p < d->n_pair; p++) {
        const lw_row_pair *pair = &d->pair[p];
        const double *a = d->jac + pair->row, *b = d->jac_by_mass + pair->other;
        value[pair->to] += a[0]*b[0] + a[1]*b[1] + a[2]*b[2];
    }
    for (int i = 0; i < d->n_weld; i++) {
        const lw_weld *w = &d->weld[i];
        double x = w->at_row ? d->jac_by_mass[w->from] : d->by_mass[w->from];
        value[w->to] += w->at_row || x != 0 ? w->by*x : w->by > 0;        /* no mass that could move: any diagonal */
    }
}

double lw_mbs_factor_kept(lw_dynamics *d, double tolerance, bool *dependent)
{
    if (!d->by_fronts) {
        lw_mbs_form_schur(d);
        return lw_cholesky_factor(&d->schur, tolerance, dependent);
    }
    for (int i = 0; i < d->fronts.at[d->fronts.n_row]; i++)
        d->front_value[i] = d->jac[d->front_entry[2*i]]*sqrt(d->by_mass[d->front_entry[2*i + 1]]);
    return lw_row_fronts_factor(&d->fronts, &d->schur, d->front_value, tolerance, dependent);
}

static double row_dot(const lw_dynamics *d, int row, const double *x)
{
    const double *jac = lw_mbs_jac(d, row);
    const int *block = lw_mbs_blocks(d, row);
    double sum = 0;
    for (int k = 0; k < d->eq.n_slot && block[k] >= 0; k++, jac += 3) {
        const double *at = x + LW_BLOCK*block[k];
        sum += jac[0]*at[0] + jac[1]*at[1] + jac[2]*at[2];
    }
    return sum;
}

double lw_mbs_row_rate(const lw_dynamics *d, int r, const double *x) { return row_dot(d, r, x); }

void lw_mbs_times(const lw_dynamics *d, const double *x, double *out)
{
    for (int r = 0; r < d->n_c; r++)
        out[r] = row_dot(d, r, x);
}

/* x += sign J^T l, the rows of l */
static void add_rows(const lw_dynamics *d, double sign, const double *l, double *x)
{
    const double *jac = d->jac;
    const int *block = d->row_block;
    int slots = d->eq.n_slot;
    for (int r = 0; r < d->n_c; r++, jac += LW_BLOCK*slots, block += slots) {
        double f = sign*l[r];
        for (int k = 0; f != 0 && k < slots && block[k] >= 0; k++) {
            double *at = x + LW_BLOCK*block[k];
            const double *by = jac + LW_BLOCK*k;
            at[0] += f*by[0], at[1] += f*by[1], at[2] += f*by[2];
        }
    }
}

/* Does a model that is not large take its factor from the rows, beside a singular posture? */
static bool is_beside_by_fronts(const lw_dynamics *d) { return d->by_fronts && !d->large; }

/* x = M^-1 (Q - J^T l), J x = rhs.  Welds magnify rounding, and so do the normal equations beside a singular posture: there the remaining
 * error of J x is corrected once (Bjoerck 1987). */
static void fast_solve(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
{
    double *b = d->small, *push = d->bias;
    for (int i = 0; i < d->n_v; i++)
        x[i] = force ? force[i]*d->by_mass[i] : 0;
    memset(l, 0, (size_t)d->n_c*sizeof *l);
    for (int pass = 0; pass < (d->n_weld || is_beside_by_fronts(d) ? 2 : 1); pass++) {
        if (d->n_weld)
            memset(b, 0, (size_t)d->schur.n*sizeof *b);
        for (int i = 0; i < d->n_kept; i++)
            b[d->unknown[i]] = row_dot(d, d->kept[i], x) - rhs[d->kept[i]];
        lw_cholesky_solve(&d->schur, b);
        for (int i = 0; i < d->n_kept; i++)
            l[d->kept[i]] += b[d->unknown[i]];
        memset(push, 0, (size_t)d->n_v*sizeof *push);
        add_rows(d, -1, l, push);
        for (int i = 0; i < d->n_v; i++)
            x[i] = (force ? force[i]*d->by_mass[i] : 0) + push[i]*d->by_mass[i];
    }
}

/* ---- by rank ------------------------------------------------------------------------------ */

/* Factor N^T M N by Cholesky's method.  Returns the link whose motion has no mass; -1: there is none. */
static int factor_null(lw_dynamics *d)
{
    int n = d->freedom, q = d->n_v;
    double *m = d->mass_null, top = 0;
    for (int i = 0; i < n; i++)
        lw_rank_left_null(&d->rank_of, i, d->null + i*q);
    for (int i = 0; i < q; i++)
        top = fmax(top, d->eq.mass[i]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (int k = 0; k < q; k++)
                sum += d->null[i*q + k]*d->eq.mass[k]*d->null[j*q + k];
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
                return worst/LW_BLOCK;
            }
            m[i*n + i] = sqrt(sum);
        }
    }
    d->null_ready = true;
    return -1;
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

/* x += N (N^T M N)^-1 N^T (force - M x), where all free motions have mass; returns as factor_null. */
static int move_free(lw_dynamics *d, const double *force, double *x)
{
    int n = d->freedom, q = d->n_v, without = d->null_ready ? -1 : factor_null(d);
    double *b = d->along_null;
    if (without >= 0)
        return without;
    for (int i = 0; i < n; i++) {
        b[i] = 0;
        for (int k = 0; k < q; k++)
            b[i] += d->null[i*q + k]*((force ? force[k] : 0) - d->eq.mass[k]*x[k]);
    }
    null_solve(d, b);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < q; k++)
            x[k] += b[i]*d->null[i*q + k];
    return -1;
}

static lw_status add_free(lw_dynamics *d, const double *force, double *x)
{
    int without = move_free(d, force, x);
    return without < 0 ? LW_OK
         : lw_error_set(d->e, LW_E_ARG, "link \"%s\" can move without moving any mass: give it a \"mass\" and an \"inertia\", or hold it",
                        d->eq.name(d->eq.context, LW_NAMED_BLOCK, without));
}

/* Where masses are far apart, the rounding of reactions of heavy links, and of N^T M N, moves light ones: what the first solution leaves of their
 * equations is corrected once. */
static lw_status solve_by_rank(lw_dynamics *d, const double *force, const double *rhs, double *x, double *l)
{
    lw_rank_solve_transposed(&d->rank_of, rhs, x);
    lw_status s = add_free(d, force, x);
    for (int pass = 0; pass < (s == LW_OK && d->uneven ? 2 : 1); pass++) {
        if (pass > 0) {
            for (int i = 0; i < d->n_v; i++)
                d->bias[i] = force ? force[i] : 0;
            add_rows(d, -1, l, d->bias);
            move_free(d, d->bias, x);
        }
        for (int i = 0; i < d->n_v; i++)
            d->bias[i] = (force ? force[i] : 0) - d->eq.mass[i]*x[i];
        lw_rank_solve(&d->rank_of, d->bias, l);
    }
    return s;
}

static void factor_rank(lw_dynamics *d)
{
    for (int r = 0; r < d->n_c; r++)
        lw_mbs_row(d, r, d->rank_of.a + r*d->n_v);
    d->rank_of.most = d->rank;               /* off the constraints, redundant rows look independent */
    lw_rank_factor(&d->rank_of, LW_RANK_TOLERANCE);
    d->null_ready = false;
}

/* ---- either -------------------------------------------------------------------------------------- */

lw_status lw_mbs_factor(lw_dynamics *d, bool by_rank)
{
    d->by_rank = !d->large && (by_rank || d->has_zero_mass);
    d->by_fronts = d->by_fronts && d->large;
    if (!d->by_rank) {
        double scale = d->weak_scale > 0 ? d->weak_scale : 1, pivot = lw_mbs_factor_kept(d, 0, NULL);
        d->weak = pivot/scale;
        if (d->large)
            return d->weak > (d->by_fronts ? LW_MBS_LEAST_SHARE_ROWS : least_pivot_large) ? LW_OK : LW_OPEN;
        d->by_rank = !((d->space ? d->weak : pivot) > least_pivot);         /* a small pivot loses digits, if by masses alone, too */
        if (d->by_rank && d->front_entry) {
            d->by_fronts = true;
            d->weak = lw_mbs_factor_kept(d, 0, NULL)/scale;
            d->by_rank = !(d->weak > least_pivot_fronts);
            d->by_fronts = !d->by_rank;
        }
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

/* The reaction of a joint in space that its rows transmit as a force: on link[1] from the rows' derivatives by its centre, or
 * the same from the other side. */
static void reaction_in_space(const lw_dynamics *d, int joint, const double *l, double *out)
{
    const lw_space_joint *j = &d->space->s.joint[joint];
    int side = j->body[1] >= 0 ? 6 : 0;
    out[0] = out[1] = out[2] = 0;
    for (int r = j->row; r < j->row + lw_spatial_kind_of(j->kind)->rows; r++) {
        const lw_space_slots *t = &d->space->slots[r];
        for (int k = 0; k < t->n; k++)
            for (int i = 0; t->from[k] == side && i < 3; i++)
                out[i] -= l[r]*lw_mbs_jac(d, r)[LW_BLOCK*k + i]/d->eq.unit;
    }
}

/* The same of all; of a contact its force along the normal. */
static void reaction_of(const void *context, int j, const double *l, double *out)
{
    const lw_dynamics *d = context;
    int joint = d->friction[j].joint;
    if (d->space) {
        reaction_in_space(d, joint, l, out);
        return;
    }
    const double *own = l + d->friction_row[j];
    lw_vec2 f = joint < 0 ? lw_v2(-own[0]/d->s.unit, 0) : lw_friction_reaction(&d->s, joint, own);
    out[0] = f.x, out[1] = f.y;
}

static const char *rubbing(const void *context, int j)
{
    const lw_dynamics *d = context;
    return d->space ? d->space->model->joint[d->friction[j].joint].name : d->model->linkage.joint[d->friction[j].joint].name;
}

static double reaction_size(const lw_dynamics *d, int j, const double *l)
{
    double f[3];
    reaction_of(d, j, l, f);
    return sqrt(f[0]*f[0] + f[1]*f[1] + (d->space ? f[2]*f[2] : 0));
}

double lw_mbs_reaction(const lw_dynamics *d, int j) { return reaction_size(d, j, d->l); }

double lw_mbs_rub_one(const lw_dynamics *d, const lw_friction_joint *f, const double *q, const double *v, double size, double *force)
{
    return d->space ? lw_spatial_rub(d->space, f, v, size, force) : lw_friction_force(&d->s, f, q, v, size, force);
}

double lw_mbs_rub(lw_dynamics *d, const double *q, const double *v, double *force)
{
    double power = 0;
    for (int j = 0; j < d->n_friction; j++)
        power += lw_mbs_rub_one(d, &d->friction[j], q, v, lw_mbs_reaction(d, j), force);
    return power;
}

void lw_mbs_rub_slopes(lw_dynamics *d, const double *q, const double *v, const lw_force_sink *sink)
{
    double *unit = d->small_v;
    const int width = d->space ? 2*LW_BLOCK : LW_BLOCK;
    memset(unit, 0, (size_t)d->n_v*sizeof *unit);
    for (int j = 0; j < d->n_friction; j++) {
        const lw_friction_joint *f = &d->friction[j];
        const int *body = d->space ? d->space->s.joint[f->joint].body : d->s.joint[f->joint].body;
        lw_friction_joint whole = *f;
        int at[4*LW_BLOCK], n = 0;
        whole.held = true, whole.part = -1;
        double arm = f->coefficient*f->lever_arm, rate = lw_mbs_rub_one(d, &whole, q, v, 1, unit)/arm;
        double part = tanh(f->lever_arm*rate/f->speed), slope = -lw_mbs_reaction(d, j)*(1 - part*part)/(f->coefficient*f->speed);
        for (int i = 0; i < 2*width; i++)
            if (body[i/width] >= 0 && unit[width*body[i/width] + i%width] != 0)
                at[n++] = width*body[i/width] + i%width;
        for (int a = 0; a < n; a++)
            for (int b = 0; b < n; b++)
                sink->add(sink->context, at[a], at[b], 0, slope*unit[at[a]]*unit[at[b]]);
        for (int a = 0; a < n; a++)
            unit[at[a]] = 0;
    }
}

double *lw_mbs_response(lw_dynamics *d, int n, int most)
{
    if (!d->response)
        d->response = malloc(((size_t)n*((size_t)most + 2) + lw_friction_doubles(n, 3))*sizeof *d->response);
    return d->response;
}

enum { MANY = 16 };                      /* joints with friction, from which on equations for all at once cost more than passes */

/* a and l, found without friction, become those with it, in passes whose cost is linear in the number of joints: the change of the
 * reactions in one pass causes the friction of the next.  Reactions begin beside those without friction, so that no way in which they
 * could grow is left out: if all changes fall to `least` of themselves in each pass, the friction of any part of the joints determines its reactions
 * too, and there is no paradox.  false: they do not fall so fast; then a and l are as before. */
static bool rub_in_passes(lw_dynamics *d, const double *q, const double *v, double *a, double *l, double *power)
{
    static const double least = 0.4, beside = 0.1;
    const int n = d->n_friction, n_x = d->n_v + d->n_c;
    double *size = d->rub, *x = size + n, *was = x + n_x, scale = 0, before = INFINITY, ratio = 0, work = 0;
    for (int j = 0; j < n; j++) {
        size[j] = 0;
        scale = fmax(scale, reaction_size(d, j, l));
    }
    memcpy(was, a, (size_t)d->n_v*sizeof *a);
    memcpy(was + d->n_v, l, (size_t)d->n_c*sizeof *l);
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    for (int pass = 0; ratio < least; pass++) {
        double most = 0;
        memset(d->hold, 0, (size_t)d->n_v*sizeof *d->hold);
        for (int j = 0; j < n; j++) {
            double more = reaction_size(d, j, l) - size[j] + (pass ? 0 : beside*scale*fmod(0.6180339887498949*(j + 1), 1));
            work += lw_mbs_rub_one(d, &d->friction[j], q, v, more, d->hold);
            size[j] += more;
            scale = fmax(scale, size[j]);
            most = !(fabs(more) <= most) ? fabs(more) : most;
        }
        if (most <= 64*DBL_EPSILON*scale) {
            *(d->touch ? &d->touch->determinant : &d->friction_determinant) = 1 - ratio;
            if (power)
                *power += work;
            return true;
        }
        if (pass > 1)
            ratio = !(most <= ratio*before) ? most/before : ratio;
        if (pass > 0)
            before = most;
        if (lw_mbs_linear(d, d->hold, d->rhs, x, x + d->n_v) != LW_OK)
            break;
        for (int i = 0; i < d->n_v; i++)
            a[i] += x[i];
        for (int r = 0; r < d->n_c; r++)
            l[r] += x[d->n_v + r];
    }
    memcpy(a, was, (size_t)d->n_v*sizeof *a);
    memcpy(l, was + d->n_v, (size_t)d->n_c*sizeof *l);
    return false;
}

void lw_mbs_full_friction(lw_dynamics *d, int n, const double *v)
{
    static const double rounding = 1e-9;     /* slip, over the greatest velocity */
    double least = fmax(rounding*d->eq.unit*lw_greatest(d->n_v, v), 1e-300);
    for (int j = 0; j < n; j++)
        d->friction[j].speed = d->friction[j].ideal ? least : d->friction[j].speed;
}

/* Is one solution by the factored rows accurate without corrections? */
static bool solves_at_once(const lw_dynamics *d) { return !d->by_rank && !d->n_weld && !is_beside_by_fronts(d); }

/* What the friction of each joint causes for a reaction of 1 N, four joints at a time: in response (n_friction x (n_v + n_c)) the accelerations of
 * free bodies, then the multipliers; in power (n_friction) its power. */
static void respond_by_four(lw_dynamics *d, const double *q, const double *v, double *response, double *power)
{
    const int n = d->n_friction, stride = d->n_v + d->n_c, slots = d->eq.n_slot;
    double (*b)[4] = (double (*)[4])(void *)d->small, (*x)[4] = b + d->n_c;
    for (int first = 0; first < n; first += 4, response += 4*stride) {
        const int lanes = n - first < 4 ? n - first : 4;
        memset(response, 0, (size_t)(lanes*stride)*sizeof *response);
        memset(b, 0, (size_t)(d->n_c + d->n_v)*sizeof *b);
        for (int k = 0; k < lanes; k++) {
            double *a = response + k*stride;
            power[first + k] = lw_mbs_rub_one(d, &d->friction[first + k], q, v, 1, a);
            for (int i = 0; i < d->n_v; i++)
                x[i][k] = a[i] *= d->by_mass[i];
        }
        for (int i = 0; i < d->n_kept; i++) {
            const double *jac = lw_mbs_jac(d, d->kept[i]);
            const int *block = lw_mbs_blocks(d, d->kept[i]);
            lw_pair *to = (lw_pair *)b[d->unknown[i]], left = { 0 }, right = { 0 };
            for (int k = 0; k < slots && block[k] >= 0; k++)
                for (int j = 0; j < LW_BLOCK; j++) {
                    const lw_pair *by = (const lw_pair *)x[LW_BLOCK*block[k] + j];
                    left += jac[LW_BLOCK*k + j]*by[0], right += jac[LW_BLOCK*k + j]*by[1];
                }
            to[0] = left, to[1] = right;
        }
        lw_cholesky_solve_four(&d->schur, b);
        for (int k = 0; k < lanes; k++)
            for (int i = 0; i < d->n_kept; i++)
                response[k*stride + d->n_v + d->kept[i]] = b[d->unknown[i]][k];
    }
}

/* a and l, found without friction, become those with it. */
static lw_status add_friction(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                              double *power)
{
    int joints = d->n_friction, n = joints + (d->touch ? d->touch->n_slip : 0), stride = d->n_v + d->n_c;
    bool by_four = n == joints && solves_at_once(d);
    bool driven = d->choice.formulation == LW_FORMULATION_DRIVEN;
    if (driven)
        lw_mbs_full_friction(d, d->n_friction, v);
    if (n == joints && n >= MANY && rub_in_passes(d, q, v, a, l, power)) {
        if (!d->touch && !(d->friction_determinant > d->least_determinant))
            d->least_determinant = d->friction_determinant;
        return LW_OK;
    }
    double *response = d->touch && d->touch->response ? d->touch->response       /* before the run: none */
                     : lw_mbs_response(d, n, stride - d->n_c + d->n_row + d->n_input + LW_STOP_ROW_MAX + (d->touch ? d->touch->row_max : 0));
    if (!response)
        return lw_error_set(d->e, LW_E_MEMORY, "out of memory");
    int dim = d->space ? 3 : 2;
    double *size = response + (size_t)n*(size_t)stride + lw_friction_doubles(n, dim), *unit_power = size + n;
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    lw_status s = LW_OK;
    if (by_four) {
        respond_by_four(d, q, v, response, unit_power);
        memcpy(d->l_each, l, (size_t)d->n_c*sizeof *l);
    }
    for (int j = 0; s == LW_OK && !by_four && j < n; j++) {
        double *to = response + (size_t)j*(size_t)stride;
        if (j < joints)
            memset(d->hold, 0, (size_t)d->n_v*sizeof *d->hold);
        unit_power[j] = j < joints ? lw_mbs_rub_one(d, &d->friction[j], q, v, 1, d->hold) : lw_mbs_touch_slip(d, j - joints, v, d->hold);
        s = lw_mbs_linear(d, d->hold, d->rhs, to, to + d->n_v);
    }
    if (s == LW_OK)
        s = lw_friction_add(&(lw_friction_scene){ d, dim, reaction_of, rubbing }, n, d->friction, response, t, d->n_v, a,
                            d->n_c, l, size, d->touch ? &d->touch->determinant : &d->friction_determinant, driven ? NULL : d->e);
    if (s == LW_E_NUMERIC && driven) {       /* the motion goes on without them */
        for (int r = 0; r < d->n_c; r++)
            l[r] = NAN;
        d->jams = true;
        return LW_OK;
    }
    if (s == LW_OK && by_four) {             /* what the change of the multipliers does */
        for (int r = 0; r < d->n_c; r++)
            d->l_each[r] -= l[r];
        memset(d->hold, 0, (size_t)d->n_v*sizeof *d->hold);
        add_rows(d, 1, d->l_each, d->hold);
        for (int i = 0; i < d->n_v; i++)
            a[i] += d->hold[i]*d->by_mass[i];
    }
    if (!d->touch && !(d->friction_determinant > d->least_determinant))
        d->least_determinant = d->friction_determinant;
    for (int j = 0; s == LW_OK && power && j < n; j++)
        *power += size[j]*unit_power[j];
    return s;
}

/* ---- accelerations -------------------------------------------------------------------------------- */

/* What J a = rhs leaves is corrected once.  Where all is driven, a large model's accelerations follow from rows alone, and the condition of J M^-1 J^T is
 * the square of that of the rows and grows with the ratios of inertias.  (A small model has factors of the rows.)  A link of little mass would take the
 * rounding of forces that its neighbours carry, over its own mass, for an acceleration. */
lw_status lw_mbs_refine(lw_dynamics *d, double *a, double *l)
{
    lw_mbs_times(d, a, d->l_each);
    for (int r = 0; r < d->n_c; r++)
        d->rhs[r] -= d->l_each[r];
    lw_status s = lw_mbs_linear(d, NULL, d->rhs, d->hold, d->l_each);
    for (int i = 0; i < d->n_v; i++)
        a[i] += d->hold[i];
    for (int r = 0; r < d->n_c; r++)
        l[r] += d->l_each[r];
    return s;
}

lw_status lw_mbs_solve(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                       double *power)
{
    d->eq.forces(d->eq.context, d->frozen ? d->o.from : t, q, v, d->force, power);
    for (int i = 0; d->settling > 0 && i < d->n_v; i++)
        d->force[i] -= d->settling*v[i]/d->by_mass[i];
    if (d->touch)
        lw_mbs_touch_forces(d, v, d->force, power);
    for (int i = 0; i < d->n_v; i++)
        if (!isfinite(d->force[i]) && t > d->o.from && (d->touch || d->eq.next_piece || d->elastic))
            return LW_OPEN;              /* a trial step far into a stiff contact, or one that is long beside the fastest modes */
        else if (!isfinite(d->force[i]))
            return lw_error_set(d->e, LW_E_NUMERIC, "a force on link \"%s\" is not a number at t = %.9g s",
                                d->eq.name(d->eq.context, LW_NAMED_BLOCK, i/LW_BLOCK), t);
    if (lw_mbs_acceleration_wanted(d, t, v) != LW_OK)
        return LW_E_NUMERIC;
    lw_status s = LW_OK;
    if (d->eq.more_inertia) {
        s = d->accelerate(d, q, v, d->force, a, l);
        if (s == LW_OK && d->n_friction && power)
            *power += lw_mbs_rub(d, q, v, d->hold);
        return s;
    }
    if (d->weighed && (s = lw_mbs_linear(d, NULL, d->rhs, a, l)) == LW_OK)       /* all is driven: a follows from rows alone, */
        for (int i = 0; i < d->n_v; i++)                 /* and what the metric adds to the masses must not count */
            d->force[i] += a[i]*(1/d->by_mass[i] - d->eq.mass[i]);
    if (s == LW_OK)
        s = lw_mbs_linear(d, d->force, d->rhs, a, l);
    if (s == LW_OK && (d->large ? d->freedom == 0 : d->uneven && !d->by_rank))
        s = lw_mbs_refine(d, a, l);
    bool slips = d->n_friction || (d->touch && d->touch->n_slip);
    return s == LW_OK && slips ? add_friction(d, t, q, v, a, l, power) : s;
}

double lw_mbs_drive_by_power(lw_dynamics *d, double t, const double *q, const double *v)
{
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    double rate = d->n_driven == 1 && !d->n_friction ? lw_mbs_row_rate(d, d->n_row, v) : 0, power = 0;
    memset(d->v_try, 0, (size_t)d->n_v*sizeof *d->v_try);
    d->eq.forces(d->eq.context, t, q, still ? d->v_try : v, d->force, NULL);
    for (int i = 0; i < d->n_v; i++) {
        d->force[i] -= still ? 0 : d->eq.mass[i]*d->a[i];
        power += d->force[i]*v[i];
    }
    return rate != 0 ? power/rate : NAN;
}

lw_status lw_mbs_state_rates(lw_dynamics *d, double t, const double *q, const double *v, double *rate)
{
    d->eq.state_rates(d->eq.context, t, q, v, rate);
    for (int i = 0; i < d->eq.n_z; i++)
        if (!isfinite(rate[i]))
            return lw_error_set(d->e, LW_E_NUMERIC, "the rate of state \"%s\" is not a number at t = %.9g s",
                                d->eq.name(d->eq.context, LW_NAMED_STATE, i), t);
    return LW_OK;
}

double lw_mbs_impulse(lw_dynamics *d, const double *g, double *change)
{
    double whole = 0;
    if (d->by_rank) {
        memset(change, 0, (size_t)d->n_v*sizeof *change);
        if (add_free(d, g, change) != LW_OK)
            return 0;
    } else {
        memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
        fast_solve(d, g, d->rhs, change, d->l_each);
    }
    for (int i = 0; i < d->n_v; i++)
        whole += g[i]*change[i];
    return whole;
}

/* ---- onto the constraints ------------------------------------------------------------------------ */

/* The least x with J x = rhs in the metric of the masses, which leaves the momenta of the free motions as they are; in that of the
 * coordinates where a motion has no mass. */
static void least_change(lw_dynamics *d, const double *rhs, double *x)
{
    if (d->by_rank) {
        lw_rank_solve_transposed(&d->rank_of, rhs, x);
        move_free(d, NULL, x);
    } else
        fast_solve(d, NULL, rhs, x, d->l_each);
}

/* factored: rows and factors are those at q. */
static lw_status project_q(lw_dynamics *d, double t, double *q, double longest, bool factored)
{
    double *step = d->hold, before = INFINITY;
    for (int pass = 0; pass < 12; pass++, factored = false) {
        lw_status s = factored ? LW_OK : lw_mbs_rows(d, t, q);
        if (s != LW_OK)
            return s;
        double off = lw_greatest_or_infinite(d->n_c, d->phi);
        if (!(off < INFINITY))
            return LW_E_NUMERIC;
        /* rounding of the rows grows with the distance travelled */
        if (off <= 4*DBL_EPSILON || (off < 1e-12*fmax(1, lw_greatest_or_infinite(d->n_q, q)) && off >= 0.5*before)) {
            return pass == 0 && !factored ? lw_mbs_factor(d, false) : LW_OK;
        }
        before = off;
        /* the factors of the last pass serve when little has changed since */
        if (!factored && (pass < 1 || off > 1e-7) && (s = lw_mbs_factor(d, d->has_zero_mass || d->by_rank)) != LW_OK)
            return s;
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] = -d->phi[r];
        least_change(d, d->rhs, step);
        if (!(lw_greatest_or_infinite(d->n_v, step) <= longest))
            return LW_OPEN;
        d->eq.move(d->eq.context, q, step);
    }
    return LW_OPEN;
}

/* Rates of rows that may be left: over the greatest velocity, since beside a singular posture corrections magnify rounding; of bodies at rest [1/s]. */
static const double most_left = 1e-6, least_left = 1e-14;

/* Rows and factors are those at q. */
lw_status lw_mbs_project_v(lw_dynamics *d, double t, double *v)
{
    double *step = d->hold, *missing = d->l_each + d->n_c, off = 0, size = 0;
    if (lw_mbs_rate_wanted(d, t) != LW_OK)
        return LW_E_NUMERIC;
    for (int pass = 0;; pass++) {
        off = 0, size = lw_greatest_or_infinite(d->n_v, v);
        for (int r = 0; r < d->n_c; r++) {
            missing[r] = d->rhs[r] - row_dot(d, r, v);
            off = fmax(off, fabs(missing[r]));
        }
        if (off <= 4*DBL_EPSILON*size)
            return LW_OK;
        if (pass == 8)
            return off <= fmax(most_left*size, least_left) ? LW_OK : LW_OPEN;
        least_change(d, missing, step);
        for (int i = 0; i < d->n_v; i++)
            v[i] += step[i];
    }
}

lw_status lw_mbs_project_q(lw_dynamics *d, double t, double *q, double longest) { return project_q(d, t, q, longest, false); }

lw_status lw_mbs_settle(lw_dynamics *d, double t, double *q, double *v)
{
    lw_status s = lw_mbs_project_q(d, t, q, 0.1);
    return s == LW_OK ? lw_mbs_project_v(d, t, v) : s;
}

lw_status lw_mbs_accelerate(lw_dynamics *d, double t, const double *q, const double *v, double *a, double *l,
                            double *power)
{
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    bool beside = d->large || d->by_fronts ? d->weak < least_pivot : d->by_rank && !d->has_zero_mass;
    if (s != LW_OK || !beside)
        return s == LW_OK ? lw_mbs_solve(d, t, q, v, a, l, power) : s;
    /* Near a singular posture residuals of the constraints are magnified: project first. */
    memcpy(d->q_try, q, (size_t)d->n_q*sizeof *q);
    memcpy(d->v_try, v, (size_t)d->n_v*sizeof *v);
    s = project_q(d, t, d->q_try, 0.1, true);
    s = s == LW_OK ? lw_mbs_project_v(d, t, d->v_try) : s;
    return s == LW_OK ? lw_mbs_solve(d, t, d->q_try, d->v_try, a, l, power) : s;
}

/* ---- moments ----------------------------------------------------------------------------------- */

lw_status lw_mbs_measure(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m)
{
    lw_status s = lw_mbs_rows(d, t, q);
    *m = (lw_moment){ .t = t, .q = q, .v = v, .a = d->a, .l = d->l, .z = d->eq.z, .work = work };
    if (s == LW_OK)
        s = lw_mbs_rate_wanted(d, t);
    int held = d->n_c - (d->touch && d->touch->captured ? d->touch->n_row : 0);
    double most = 0, most_rate = 0;
    for (int r = 0; s == LW_OK && r < held; r++) {
        most = lw_greater(most, fabs(d->phi[r]));
        most_rate = lw_greater(most_rate, fabs(row_dot(d, r, v) - d->rhs[r]));
    }
    m->off = most, m->off_rate = most_rate;
    m->kinetic = d->eq.kinetic(d->eq.context, v);
    m->potential = d->eq.potential(d->eq.context, q);
    m->unique = d->rank == d->n_c;
    return s;
}

void lw_mbs_dependence(lw_dynamics *d, double *x)
{
    double *push = d->hold, *change = d->small_v;
    for (int i = 0; i < d->n_kept; i++)
        x[d->kept[i]] = 0;
    memset(push, 0, (size_t)d->n_v*sizeof *push);
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    add_rows(d, 1, x, push);
    fast_solve(d, push, d->rhs, change, d->l_each);
    for (int i = 0; i < d->n_kept; i++)
        x[d->kept[i]] = -d->l_each[d->kept[i]];
}

/* lw_mbs_dependence is a linear map N from the values of the rows left out to all rows.  Write N^T x into the rows of out (n_c) that
 * are left out.  Returns |N^T x|^2. */
static double across_dependence(lw_dynamics *d, const double *x, double *out)
{
    double sum = 0;
    fast_solve(d, NULL, x, d->small_v, d->l_each);
    for (int r = 0; r < d->n_c; r++)
        if (d->place[r] < 0) {
            out[r] = x[r] - row_dot(d, r, d->small_v);
            sum += out[r]*out[r];
        }
    return sum;
}

/* Minimise |l - N y| over y by conjugate gradients.  They need one pass for each row left out at most, and mostly far fewer. */
void lw_mbs_least_norm(lw_dynamics *d, double *l)
{
    double *way = d->l_each + d->n_c, *along = way + d->n_c, before = 0, all = 0;
    for (int r = 0; r < d->n_c; r++)
        all += l[r]*l[r];
    if (!isfinite(all) || d->by_rank || d->n_kept >= d->n_c || (d->touch && d->touch->captured)
        || lw_mbs_factor(d, !d->large) != LW_OK)
        return;
    if (d->by_rank) {
        memset(d->hold, 0, (size_t)d->n_v*sizeof *d->hold);
        add_rows(d, 1, l, d->hold);
        lw_rank_solve(&d->rank_of, d->hold, l);
        return;
    }
    memset(along, 0, (size_t)d->n_c*sizeof *along);
    for (int pass = d->n_kept; pass <= d->n_c; pass++) {
        double now = across_dependence(d, l, way), square = 0;
        if (!(now > 1e-28*all) || (now < 1e-20*all && now > 0.25*before && pass > d->n_kept))            /* rounding */
            return;
        for (int r = 0; r < d->n_c; r++)
            if (d->place[r] < 0)
                way[r] = along[r] = way[r] + (before > 0 ? now/before : 0)*along[r];
        before = now;
        lw_mbs_dependence(d, way);
        for (int r = 0; r < d->n_c; r++)
            square += way[r]*way[r];
        for (int r = 0; r < d->n_c; r++)
            l[r] -= now/square*way[r];
    }
}

lw_status lw_mbs_moment_forces(lw_dynamics *d, const lw_moment *m)
{
    lw_status s = lw_mbs_factor(d, !m->unique);
    if (s == LW_OK)
        s = lw_mbs_solve(d, m->t, m->q, m->v, d->a, d->l, NULL);
    if (s == LW_OK)
        lw_mbs_least_norm(d, d->l);
    return s;
}

lw_status lw_mbs_moment(lw_dynamics *d, double t, const double *q, const double *v, double work, lw_moment *m)
{
    lw_status s = lw_mbs_measure(d, t, q, v, work, m);
    return s == LW_OK ? lw_mbs_moment_forces(d, m) : s;
}

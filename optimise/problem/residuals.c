#include "optimise/problem/residuals.h"

#include <string.h>

#include "base/vector.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/variable_projection.h"

void lw_problem_inputs(const lw_problem *p, lw_work *w, size_t n)
{
    if (p->plan.input_is_slider) {
        memcpy(w->posture_c, w->posture_x, n*sizeof *w->posture_c);
        memset(w->posture_s, 0, n*sizeof *w->posture_s);
    } else
        lw_batch_turns(&p->plan, n, w->posture_x, w->posture_c, w->posture_s);
}

void lw_problem_margin(const lw_problem *p, const lw_lanes *in, lw_work *w, double *margin)
{
    lw_batch_frame(&p->plan, in, 0, w->batch, w->posture_x, w->posture_y, w->posture_u, w->posture_v, margin);
    for (int i = 1; i <= p->n_also; i++) {
        lw_batch_frame(&p->plan, in, i, w->batch, w->posture_x, w->posture_y, w->posture_u, w->posture_v, w->posture_m);
        for (size_t k = 0; k < in->n; k++)
            margin[k] = lw_lesser(margin[k], w->posture_m[k]);
    }
}

/* Evaluate lanes first .. last-1, all in one assembly mode. */
static void lanes_of_mode(const lw_problem *p, const double *x, lw_work *w, size_t first, size_t last, const double *mode)
{
    lw_lanes in = { .n = last - first, .c = w->c + first, .s = w->s + first, .dim = x, .mode = mode };
    for (int k = 0; k <= p->n_also; k++) {
        lw_jacobian j = *lw_work_jac(w, k);
        double **each[] = { &j.x, &j.y, &j.u, &j.v, &j.margin, &j.jx, &j.jy, &j.jt, &j.tx, &j.ty, &j.tt };
        for (size_t i = 0; i < sizeof each/sizeof *each; i++)
            if (*each[i])
                *each[i] += first;
        lw_batch_jacobian(&p->plan, &in, k, w->batch, &j);
    }
}

/* Evaluate all lanes on a circuit, one run of lanes on the same stroke after the other; then turn derivatives by the
 * input into derivatives by the phase. */
static void lanes_of_circuit(const lw_problem *p, const double *x, lw_work *w)
{
    if (!lw_problem_has_modes(p))
        lanes_of_mode(p, x, w, 0, w->n_lane, p->intended.mode);
    else
        for (size_t first = 0, next; first < w->n_lane; first = next) {
            next = lw_circuit_run(w, first, w->n_lane);
            lanes_of_mode(p, x, w, first, next, w->swing.stroke[w->leg[first]].mode);
        }
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        for (size_t k = 0; k < w->n_lane; k++) {
            j->tx[k] *= w->rate[k];
            j->ty[k] *= w->rate[k];
            if (j->tt)
                j->tt[k] *= w->rate[k];
        }
    }
}

/* Least margin over a full turn, or between the inputs of the first and the last station. */
static double margin_of_range(const lw_problem *p, const double *x, double shift, lw_work *w)
{
    size_t n = LW_CURVE_SAMPLES;
    double lo = w->input[0], hi = w->input[0], least = 1;
    for (size_t k = 1; k < p->n && !p->intended.turns; k++) {
        lo = fmin(lo, w->input[k]);
        hi = fmax(hi, w->input[k]);
    }
    if (p->intended.turns)
        hi = lo + 2*LW_PI;
    for (size_t k = 0; k < n; k++)
        w->posture_x[k] = lo + (hi - lo)*((double)k + shift)/(double)n;
    lw_problem_inputs(p, w, n);
    lw_lanes in = { .n = n, .c = w->posture_c, .s = w->posture_s, .dim = x, .mode = p->intended.mode };
    lw_problem_margin(p, &in, w, w->posture.margin);
    for (size_t k = 0; k < n; k++)
        least = lw_lesser(least, w->posture.margin[k]);
    return least;
}

/* Least margin along the whole circuit. Near a limit the margin is divided by psi_s^2, since it vanishes there in any
 * linkage. */
static double margin_of_circuit(const lw_problem *p, const double *x, double shift, lw_work *w)
{
    size_t n = LW_CURVE_SAMPLES;
    double least = 1, part[LW_CURVE_SAMPLES], phase[LW_CURVE_SAMPLES];
    lw_cycle_point each[LW_CURVE_SAMPLES];
    lw_lanes in = { .n = n, .c = w->posture_c, .s = w->posture_s, .dim = x, .mode = w->turn_mode, .mode_stride = n };
    if (!lw_circuit_find(p, x, w))
        return -1;
    for (size_t k = 0; k < n; k++)
        phase[k] = 2*LW_PI*((double)k + shift)/(double)n;
    lw_circuit_points(p, w, n, phase, each);
    for (size_t k = 0; k < n; k++) {
        lw_cycle_point at = each[k];
        w->posture_c[k] = at.c;
        w->posture_s[k] = at.s;
        part[k] = w->swing.turning ? 1 : fmax(at.psi_s*at.psi_s, 1e-9);
        lw_circuit_put_mode(p, w, at.leg, w->turn_mode + k, n);
    }
    lw_problem_margin(p, &in, w, w->posture.margin);
    for (size_t k = 0; k < n; k++)
        least = lw_lesser(least, w->posture.margin[k]/part[k]);
    return least;
}

/* Least margin at samples shifted by `shift` of their distance. */
static double margin_between(const lw_problem *p, const double *x, double shift, lw_work *w)
{
    return lw_problem_has_modes(p) ? margin_of_circuit(p, x, shift, w) : margin_of_range(p, x, shift, w);
}

/* If the margin of a dyad falls below this, its square root [rad] is so small that the linkage may change its assembly
 * mode between two samples. */
#define LEAST_MARGIN 1e-4

bool lw_problem_stays(const lw_problem *p, const double *x, lw_work *w)
{
    enum { TIMES = 12 };
    for (int i = 0; p->family->linkage && i < TIMES; i++)
        if (!(margin_between(p, x, (i + 0.5)/TIMES, w) > 0.1*LEAST_MARGIN))
            return false;
    return true;
}

bool lw_problem_lanes(const lw_problem *p, const double *x, lw_work *w)
{
    double least = 1;
    if (p->intended.turns || p->timing == LW_TIMING_PRESCRIBED)
        lanes_of_mode(p, x, w, 0, w->n_lane, p->intended.mode);
    else
        lanes_of_circuit(p, x, w);
    for (int i = 0; i <= p->n_also; i++)
        for (size_t k = 0; k < w->n_lane; k++)
            least = lw_lesser(least, lw_work_jac(w, i)->margin[k]);
    return least >= w->least_margin && (!p->family->linkage || margin_between(p, x, 0.5, w) > LEAST_MARGIN);
}

bool lw_problem_turn_stations(const lw_problem *p, const double *x, lw_work *w)
{
    if (!lw_circuit_find(p, x, w))
        return false;
    bool samples_stand = p->intended.turns;                    /* the inputs of the samples are then those of a turn */
    size_t n = samples_stand ? p->n : w->n_lane, rest = w->n_lane - n;
    lw_circuit_lanes(p, w, n);
    memcpy(w->c + n, w->turn_c, sizeof *w->c*rest);
    memcpy(w->s + n, w->turn_s, sizeof *w->s*rest);
    return true;
}

void lw_problem_prescribe(const lw_problem *p, const double *x, lw_work *w)
{
    double theta0 = p->datum == LW_DATUM_PLANE ? x[p->plan.i_theta0]/p->plan.input_turns_per_period : 0;
    double first = x[p->i_input0] - theta0;
    double c = cos(first), s = sin(first), sign = lw_problem_turns_either_way(p) ? p->intended.sense : 1;
    for (size_t k = 0; k < p->n; k++) {
        w->c[k] = c*p->c[k] - s*sign*p->s[k];
        w->s[k] = s*p->c[k] + c*sign*p->s[k];
        w->input[k] = first + sign*p->angle[k];
    }
}

/* Residuals of the stations, of which f is the weighted sum of squares. */
static void station_residuals(const lw_problem *p, const double *x, lw_work *w)
{
    double *res = w->res;
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_aim aim = lw_problem_aim(p, i);
        if (aim.x) {
            for (size_t k = 0; k < p->n; k++) {
                res[k] = aim.wa[k]*(j->x[k] - aim.x[k]);
                res[w->ld + k] = aim.wa[k]*(j->y[k] - aim.y[k]);
            }
            res += 2*w->ld;
        }
        if (aim.theta) {
            for (size_t k = 0; k < p->n; k++) {
                double turn = atan2(j->v[k], j->u[k]) + x[aim.i_tool] - aim.theta[k];
                res[k] = aim.wb[k]*remainder(turn, 2*LW_PI);
            }
            res += w->ld;
        }
    }
}

/* One row of derivatives: by the dimensions from the plan, by input0, and by the tool's mounting angle (-1: none). */
static void component_rows(const lw_problem *p, lw_work *w, int row, const double *by_dim, const double *by_input,
                           const double *weight, int tool)
{
    size_t ld = w->ld, n = p->n;
    double *base = w->row + (size_t)row*(size_t)p->n_var*ld;
    for (int d = 0; d < p->n_dim; d++)
        for (size_t k = 0; k < n; k++)
            base[(size_t)d*ld + k] = by_dim[(size_t)d*w->jac.ld + k]*weight[k];
    for (size_t k = 0; p->i_input0 >= 0 && k < n; k++)
        base[(size_t)p->i_input0*ld + k] = by_input[k]*weight[k];
    for (size_t k = 0; p->i_input0 >= 0 && p->datum == LW_DATUM_PLANE && k < n; k++)
        base[(size_t)p->plan.i_theta0*ld + k] -= by_input[k]*weight[k]/p->plan.input_turns_per_period;
    for (int d = p->n_dim + (p->i_input0 >= 0); d < p->n_var; d++)
        for (size_t k = 0; k < n; k++)
            base[(size_t)d*ld + k] = d == tool ? weight[k] : 0;
}

static void station_rows(const lw_problem *p, lw_work *w)
{
    int row = 0;
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_aim aim = lw_problem_aim(p, i);
        if (aim.x) {
            component_rows(p, w, row++, j->jx, j->tx, aim.wa, -1);
            component_rows(p, w, row++, j->jy, j->ty, aim.wa, -1);
        }
        if (aim.theta)
            component_rows(p, w, row++, j->jt, j->tt, aim.wb, aim.i_tool);
    }
}

/* Derivatives of the distances of the samples, whose weighted normals are nx, ny. Where the limits of the input depend
 * on the dimensions, samples keep their phases. */
static void sample_rows(const lw_problem *p, const double *x, lw_work *w, const double *nx, const double *ny)
{
    size_t ld = w->ld, nv = (size_t)p->n_var;
    memset(w->by_input, 0, sizeof *w->by_input*w->n_lane);
    lw_circuit_slopes(p, x, w);
    for (size_t k = p->n; k < w->n_lane && !w->swing.turning; k++)
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
        for (size_t k = p->n; k < w->n_lane && !w->swing.turning; k++)
            row[k] += w->by_input[k]*lw_circuit_drift(w, k, c);
    }
}

/* Residuals of the curve samples: distance to the nearest point of the target polygon (timing none). */
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
            lw_variable_projection(p, x, w);
    }
    if (p->timing == LW_TIMING_NONE)
        sample_residuals(p, x, w, derivatives);
    for (int i = 0; i < w->n_row; i++)
        for (size_t k = 0; k < w->n_lane; k++)
            f += w->res[(size_t)i*w->ld + k]*w->res[(size_t)i*w->ld + k];
    return f;
}

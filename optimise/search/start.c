#include "optimise/search/start.h"

#include <string.h>

#include "base/real_complex.h"
#include "base/vector.h"
#include "optimise/problem/family.h"
#include "optimise/solvers/lm.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"

static int shape_draws(const lw_problem *p)
{
    return p->family->linkage ? lw_random_linkage_draws(p) : p->family->n_draw;
}

int lw_start_draws(const lw_problem *p)
{
    return shape_draws(p) + (p->timing == LW_TIMING_PRESCRIBED ? 1 : 4);
}

#define RIDGE   1e-12       /* added to the diagonal of normal equations, relative                     */
#define PIVOT   1e-14       /* least pivot, relative                                                   */

/* z0, a, b of  P = z0 + a o + b d  by weighted least squares.  RIDGE lets one or two stations, or a curve that is a
 * circle, have a solution too. */
typedef struct linear_fit { double complex z0, a, b, also[LW_ALSO_MAX]; double residual; } linear_fit;

static linear_fit fit_one(const lw_problem *p, const lw_work *w)
{
    double complex so = 0, sd = 0, sp = 0;
    double mass = 0;
    for (size_t k = 0; k < p->n; k++) {
        mass += p->w[k];
        so += p->w[k]*(w->jac.x[k] + I*w->jac.y[k]);
        sd += p->w[k]*(w->jac.u[k] + I*w->jac.v[k]);
        sp += p->w[k]*(p->x[k] + I*p->y[k]);
    }
    so /= mass; sd /= mass; sp /= mass;
    double oo = 0, dd = 0, pp = 0;
    double complex od = 0, op = 0, dp = 0;
    for (size_t k = 0; k < p->n; k++) {
        double complex o = (w->jac.x[k] + I*w->jac.y[k]) - so;
        double complex d = (w->jac.u[k] + I*w->jac.v[k]) - sd;
        double complex q = (p->x[k] + I*p->y[k]) - sp;
        oo += p->w[k]*(creal(o)*creal(o) + cimag(o)*cimag(o));
        dd += p->w[k]*(creal(d)*creal(d) + cimag(d)*cimag(d));
        pp += p->w[k]*(creal(q)*creal(q) + cimag(q)*cimag(q));
        od += p->w[k]*conj(o)*d;
        op += p->w[k]*conj(o)*q;
        dp += p->w[k]*conj(d)*q;
    }
    oo += RIDGE*(oo + mass);
    dd += RIDGE*(dd + mass);
    double det = oo*dd - creal(od)*creal(od) - cimag(od)*cimag(od);
    det = fmax(det, PIVOT*oo*dd);
    linear_fit f;
    f.a = (dd*op - od*dp)/det;
    f.b = (oo*dp - conj(od)*op)/det;
    f.z0 = sp - f.a*so - f.b*sd;
    f.residual = pp - creal(conj(op)*f.a + conj(dp)*f.b);
    return f;
}

/* Normal equations of several points at once: unknown z0, a and the place of each point on its link. */
enum { UNKNOWN_MAX = 2 + LW_PROBLEM_TRACER_MAX };

typedef struct normal {
    int            n;
    double complex m[UNKNOWN_MAX][UNKNOWN_MAX], r[UNKNOWN_MAX];
    double         pp;
} normal;

/* Add |sum of row[i] x[i] - value|^2, weighted. */
static void add_row(normal *s, double weight, const double complex *row, double complex value)
{
    for (int i = 0; i < s->n; i++) {
        for (int k = 0; k < s->n; k++)
            s->m[i][k] += weight*conj(row[i])*row[k];
        s->r[i] += weight*conj(row[i])*value;
    }
    s->pp += weight*(creal(value)*creal(value) + cimag(value)*cimag(value));
}

/* Solve by Cholesky's factors of the Hermitian matrix, with the diagonal enlarged as in fit_one.  r becomes the
 * solution. Returns the residual, pp less what the solution explains. */
static double solve_normal(normal *s)
{
    double complex rhs[UNKNOWN_MAX];
    double size = 0, residual = s->pp;
    memcpy(rhs, s->r, sizeof rhs);
    for (int i = 0; i < s->n; i++)
        size = fmax(size, creal(s->m[i][i]));
    for (int i = 0; i < s->n; i++) {
        s->m[i][i] += RIDGE*(creal(s->m[i][i]) + size);
        for (int k = 0; k <= i; k++) {
            double complex v = s->m[i][k];
            for (int l = 0; l < k; l++)
                v -= s->m[i][l]*conj(s->m[k][l]);
            s->m[i][k] = k < i ? v/s->m[k][k] : sqrt(fmax(creal(v), PIVOT*size));
        }
        for (int k = 0; k < i; k++)
            s->r[i] -= s->m[i][k]*s->r[k];
        s->r[i] /= s->m[i][i];
    }
    for (int i = s->n - 1; i >= 0; i--) {
        for (int k = i + 1; k < s->n; k++)
            s->r[i] -= conj(s->m[k][i])*s->r[k];
        s->r[i] /= s->m[i][i];
    }
    for (int i = 0; i < s->n; i++)
        residual -= creal(conj(rhs[i])*s->r[i]);
    return residual;
}

static linear_fit fit_all(const lw_problem *p, const lw_work *w)
{
    normal s = { .n = 2 };
    int at[LW_PROBLEM_TRACER_MAX];
    for (int i = 0; i <= p->n_also; i++)
        at[i] = lw_problem_aim(p, i).x ? s.n++ : -1;
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_aim aim = lw_problem_aim(p, i);
        for (size_t k = 0; k < p->n && at[i] >= 0; k++) {
            double complex row[UNKNOWN_MAX] = { 1, j->x[k] + I*j->y[k] };
            row[at[i]] = j->u[k] + I*j->v[k];
            add_row(&s, aim.wa[k]*aim.wa[k], row, aim.x[k] + I*aim.y[k]);
        }
    }
    linear_fit f = { .residual = solve_normal(&s) };
    f.z0 = s.r[0];
    f.a = s.r[1];
    f.b = s.r[at[0]];
    for (int i = 0; i < p->n_also; i++)
        f.also[i] = at[i + 1] >= 0 ? s.r[at[i + 1]] : 0;
    return f;
}

static linear_fit fit_linear(const lw_problem *p, const lw_work *w)
{
    return p->n_also > 0 ? fit_all(p, w) : fit_one(p, w);
}

/* Compute the variables from a shape of size one and the linear fit. */
static bool put_together(const lw_problem *p, const double *shape, linear_fit f, double *x)
{
    double size = cabs(f.a);
    if (!(size > 1e-9) || !isfinite(size))
        return false;
    double complex turn = f.a/size, tracer = f.b/turn;
    for (int i = 0; i < p->n_dim; i++)
        x[i] = p->plan.dim[i].kind == LW_DIM_ANGLE ? shape[i] : size*shape[i];
    x[p->plan.i_cx[0]] = creal(tracer);
    x[p->plan.i_cy[0]] = cimag(tracer);
    for (int i = 0; i < p->n_also; i++) {
        x[p->plan.i_cx[i + 1]] = creal(f.also[i]/turn) + 0.0;   /* never -0 */
        x[p->plan.i_cy[i + 1]] = cimag(f.also[i]/turn) + 0.0;
    }
    x[p->plan.i_x0] = creal(f.z0);
    x[p->plan.i_y0] = cimag(f.z0);
    x[p->plan.i_theta0] = carg(turn);
    return true;
}

/* Set the mounting angles of the tools: the circular mean of the angle between link and tool. */
static void mount_tools(const lw_problem *p, const lw_work *w, double *x)
{
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_aim aim = lw_problem_aim(p, i);
        double c = 0, s = 0;
        if (!aim.theta)
            continue;
        for (size_t k = 0; k < p->n; k++) {
            double a = aim.theta[k] - atan2(j->v[k], j->u[k]) - x[p->plan.i_theta0];
            c += p->w[k]*cos(a);
            s += p->w[k]*sin(a);
        }
        x[aim.i_tool] = fmin(fmax(atan2(s, c), p->lo[aim.i_tool]), p->hi[aim.i_tool]);
    }
}

/* Compute the frames of the tracers' links at the stations' inputs, in a linkage of this shape.  false: it does not
 * close. */
static bool frames(const lw_problem *p, const double *shape, lw_work *w)
{
    lw_lanes in = { .n = p->n, .c = w->c, .s = w->s, .dim = shape, .mode = p->intended.mode };
    double least = 1;
    lw_circuit_modes(p, w, &in);
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_batch_frame(&p->plan, &in, i, w->batch, j->x, j->y, j->u, j->v, j->margin);
        for (size_t k = 0; k < p->n; k++)
            least = lw_lesser(least, j->margin[k]);
    }
    return least >= w->least_margin;
}

static bool draw_shape(lw_problem *p, const double *u, double *shape, lw_work *w)
{
    double value[LW_SHAPE_MAX];
    if (p->family->linkage) {
        if (p->timing == LW_TIMING_FREE || lw_problem_turns_either_way(p))     /* both senses are equally likely */
            p->intended.sense = u[shape_draws(p) - 1] < 0.5 ? -1 : 1;
        return lw_random_linkage_draw(p, u, p->must_turn, shape, w);
    }
    p->family->draw(u, value);
    memset(shape, 0, sizeof *shape*(size_t)p->n_dim);
    for (int i = 0; p->family->shape[i]; i++)
        shape[lw_plan_dim(&p->plan, p->family->shape[i])] = value[i];
    return true;
}

static double settle_and_score(const lw_problem *p, double *x, lw_work *w)
{
    if (!lw_lm_feasible(p, x, w))
        return INFINITY;
    if (p->timing == LW_TIMING_PRESCRIBED)
        lw_problem_prescribe(p, x, w);
    else if (!lw_timing_assign(p, x, w))
        return INFINITY;
    else if (!lw_problem_turn_stations(p, x, w))
        return INFINITY;
    if (!lw_problem_lanes(p, x, w))
        return INFINITY;
    return lw_problem_rows(p, x, w, false);
}

/* A function leaves the size open: take the size that a fixed first length gives, or else the middle of what the
 * bounds of the lengths allow. */
static double function_size(const lw_problem *p, const double *shape)
{
    int first = p->family->linkage ? lw_problem_first_length(p) : lw_plan_dim(&p->plan, p->family->shape[0]);
    double least = 0, most = INFINITY;
    if (p->lo[first] == p->hi[first])
        return p->lo[first]/shape[first];
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH) {
            least = fmax(least, p->lo[i]/shape[i]);
            most = fmin(most, p->hi[i]/shape[i]);
        }
    return sqrt(least*most);
}

static double start_prescribed(lw_problem *p, const double *u, double *x, lw_work *w)
{
    double shape[LW_VAR_MAX];
    double first = p->datum == LW_DATUM_FRAME ? 0 : 2*LW_PI*u[shape_draws(p)] - LW_PI;
    memset(x, 0, sizeof *x*(size_t)p->n_var);
    if (!draw_shape(p, u, shape, w))
        return INFINITY;
    double sign = lw_problem_turns_either_way(p) ? p->intended.sense : 1;
    for (size_t k = 0; k < p->n; k++) {
        w->c[k] = cos(first)*p->c[k] - sin(first)*sign*p->s[k];
        w->s[k] = sin(first)*p->c[k] + cos(first)*sign*p->s[k];
    }
    if (!frames(p, shape, w))
        return INFINITY;
    if (!lw_task_has_place(p->task)) {
        double size = function_size(p, shape);
        for (int i = 0; i < p->n_dim; i++)
            x[i] = p->plan.dim[i].kind == LW_DIM_ANGLE ? shape[i] : shape[i]*size;
    } else if (!put_together(p, shape, fit_linear(p, w), x))
        return INFINITY;
    mount_tools(p, w, x);
    x[p->i_input0] = p->datum == LW_DATUM_FREE ? first : 0;
    if (p->datum == LW_DATUM_PLANE)
        x[p->plan.i_theta0] = -first*p->plan.input_turns_per_period;
    return settle_and_score(p, x, w);
}

/* Guess the inputs of the stations: by their place along the target, warped and shifted.  A closed target may also be
 * passed in a part of the turn; the rest of the turn lies between two stations. */
static void guess_phases(const lw_problem *p, const double *u, lw_work *w)
{
    double first = 2*LW_PI*u[0], warp = 0.9*u[1], phase = 2*LW_PI*u[2], total = p->along[p->n];
    bool hurried = p->closed && u[3] < 0.25;
    double span = p->closed ? (hurried ? 0.1 + 3.2*u[3] : 1) : 0.15 + 0.85*u[3];
    size_t gap = hurried ? (size_t)(u[1]*(double)p->n) : p->n;
    for (size_t k = 0; k < p->n; k++) {
        double t = total > 0 ? 2*LW_PI*p->along[k]/total : 0;
        if (!hurried)
            t += warp*(sin(t + phase) - sin(phase));
        w->phase[k] = first + p->intended.sense*(span*t + (k > gap ? 2*LW_PI*(1 - span) : 0));
    }
}

/* Fit place, size and tracer, then assign the inputs of the stations anew; repeat. */
static double start_free(lw_problem *p, const double *u, double *x, lw_work *w)
{
    enum { ROUNDS = 4 };
    double shape[LW_VAR_MAX];
    memset(x, 0, sizeof *x*(size_t)p->n_var);
    if (!draw_shape(p, u, shape, w))
        return INFINITY;
    guess_phases(p, u + shape_draws(p), w);
    if (!lw_problem_turn_stations(p, shape, w))
        return INFINITY;
    for (int i = 0; i < ROUNDS; i++) {
        if (!frames(p, shape, w) || !put_together(p, shape, fit_linear(p, w), x))
            return INFINITY;
        mount_tools(p, w, x);
        if (i + 1 == ROUNDS)
            break;
        if (!lw_timing_assign(p, x, w) || !lw_problem_turn_stations(p, shape, w))
            return INFINITY;
    }
    return settle_and_score(p, x, w);
}

double lw_start_estimate(lw_problem *p, const double *u, void *work)
{
    double shape[LW_VAR_MAX];
    if (!draw_shape(p, u, shape, work))
        return INFINITY;
    guess_phases(p, u + shape_draws(p), work);
    return lw_problem_turn_stations(p, shape, work) && frames(p, shape, work) ? fit_linear(p, work).residual : INFINITY;
}

double lw_start(lw_problem *p, const double *u, double *x, void *work)
{
    return p->timing == LW_TIMING_PRESCRIBED ? start_prescribed(p, u, x, work)
                                             : start_free(p, u, x, work);
}

/* ---- pins on circles ---------------------------------------------------------------------------------------------- */

#define NEAREST 0.03        /* sizes of the target: a pin from the point ...                          */
#define FARTHEST 3.0        /* ... at most                                                            */
#define STRAIGHT 1e-9       /* a path whose width is so small a part of its length is no circle        */

bool lw_start_has_guides(const lw_problem *p)
{
    return p->task == LW_TASK_MOTION && p->timing == LW_TIMING_FREE && p->n_also == 0 && p->n >= 3 && !p->family->linkage
        && strcmp(p->family->type, "RRRR") == 0;
}

/* A point of the body, from the tracer in the first pose, and the circle that its places are nearest to: least squares of
 * |place - centre|^2 - radius^2.  off: what they miss it by, squared and weighted; INFINITY: they lie on a line. */
typedef struct guide { double complex pin, centre; double radius, off; } guide;

static double complex place_of(const lw_problem *p, double complex pin, size_t k)
{
    return p->x[k] + I*p->y[k] + pin*cexp(I*(p->theta[k] - p->theta[0]));
}

static guide draw_guide(const lw_problem *p, const double *u)
{
    guide g = { .pin = NEAREST*pow(FARTHEST/NEAREST, u[0])*cexp(2*LW_PI*I*u[1]) };
    double complex mean = 0;
    double mass = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
    for (size_t k = 0; k < p->n; k++) {
        mass += p->w[k];
        mean += p->w[k]*place_of(p, g.pin, k);
    }
    mean /= mass;
    for (size_t k = 0; k < p->n; k++) {
        double complex q = place_of(p, g.pin, k) - mean;
        double x = creal(q), y = cimag(q), z = x*x + y*y;
        xx += p->w[k]*x*x;
        xy += p->w[k]*x*y;
        yy += p->w[k]*y*y;
        xz += p->w[k]*x*z/2;
        yz += p->w[k]*y*z/2;
    }
    double det = xx*yy - xy*xy;
    if (!(det > STRAIGHT*(xx + yy)*(xx + yy))) {
        g.off = INFINITY;
        return g;
    }
    double complex c = (yy*xz - xy*yz)/det + I*((xx*yz - xy*xz)/det);
    g.centre = mean + c;
    g.radius = sqrt(creal(c)*creal(c) + cimag(c)*cimag(c) + (xx + yy)/mass);
    for (size_t k = 0; k < p->n; k++) {
        double d = cabs(place_of(p, g.pin, k) - g.centre) - g.radius;
        g.off += p->w[k]*d*d;
    }
    return g;
}

/* The four-bar with these two points as pins; in one of both orders it has the intended mode. */
double lw_start_guided(lw_problem *p, const double *u, double *x, void *work)
{
    const guide g[2] = { draw_guide(p, u), draw_guide(p, u + 2) };
    double best = INFINITY, now[LW_VAR_MAX];
    for (int i = 0; i < 2 && isfinite(g[0].off + g[1].off); i++) {
        const guide *crank = &g[i], *rocker = &g[1-i];
        double complex base = rocker->centre - crank->centre, coupler = rocker->pin - crank->pin;
        const double length[] = { cabs(base), crank->radius, cabs(coupler), rocker->radius };
        double complex tracer = -crank->pin*length[2]/coupler;
        memset(now, 0, sizeof *now*(size_t)p->n_var);
        for (int k = 0; k < 4; k++)
            now[lw_plan_dim(&p->plan, p->family->shape[k])] = length[k];
        now[p->plan.i_cx[0]] = creal(tracer);
        now[p->plan.i_cy[0]] = cimag(tracer);
        now[p->plan.i_x0] = creal(crank->centre);
        now[p->plan.i_y0] = cimag(crank->centre);
        now[p->plan.i_theta0] = carg(base);
        now[p->i_tool0] = remainder(p->theta[0] - carg(coupler), 2*LW_PI);
        double f = length[0] > 0 && length[2] > 0 ? settle_and_score(p, now, work) : INFINITY;
        if (f < best) {
            best = f;
            memcpy(x, now, sizeof *x*(size_t)p->n_var);
        }
    }
    return best;
}

double lw_start_guided_estimate(const lw_problem *p, const double *u)
{
    return draw_guide(p, u).off + draw_guide(p, u + 2).off;
}

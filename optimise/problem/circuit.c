/* optimise/problem/circuit.c - see circuit.h.
 *
 * Near a limit the posture varies like the square root of the input's distance from the limit. With input = mid - half
 * cos(psi) this root is proportional to sqrt(half) psi. Each stroke gets a part of the phase in proportion to
 * sqrt(half), so that the speed is continuous from one stroke to the next. */
#include "optimise/problem/circuit.h"

#include <assert.h>
#include <string.h>

#include "mbs/kinematics/motion.h"

/* ---- strokes and phases ----------------------------------------------------------------------------- */

static void set_stroke(const lw_problem *p, lw_swing *s, int j, double mid, double half, const double *mode)
{
    s->stroke[j].mid = mid;
    s->stroke[j].half = half;
    memcpy(s->stroke[j].mode, mode, sizeof *mode*(size_t)p->plan.n_dyad);
}

/* Set where each stroke begins, and its angle psi as a function of the phase: psi = rate phase + shift. */
static void share_phases(lw_swing *s)
{
    double sum = 0, done = 0;
    for (int j = 0; j < s->n; j++)
        sum += sqrt(s->stroke[j].half);
    for (int j = 0; j < s->n; j++) {
        lw_stroke *k = &s->stroke[j];
        double root = sqrt(k->half);
        k->from = 2*LW_PI*(done/sum);
        k->rate = sum/(2*root);
        k->shift = j*LW_PI - k->rate*k->from;
        done += root;
    }
}

static bool to_and_fro(const lw_problem *p, lw_swing *s, double mid, double half, const double *up, const double *down)
{
    s->n = 2;
    set_stroke(p, s, 0, mid, half, up);
    set_stroke(p, s, 1, mid, half, down);
    share_phases(s);
    return half > 0;
}

/* Unit of the inputs of p->intended: a slider's travel scales with the linkage's first length; angles do not scale. */
static double input_unit(const lw_problem *p, const double *x)
{
    int size = p->plan.input_is_slider ? lw_problem_first_length(p) : -1;
    return size >= 0 ? x[size] : 1;
}

/* Range of a four-link family, in closed form. */
static bool find_range(const lw_problem *p, const double *x, lw_swing *s)
{
    static const double left = 1, right = -1;
    lw_range r;
    if (lw_motion_range(&p->plan, x, p->intended.mode[0], &r) != LW_OK)
        return false;
    s->turning = r.turns;
    const double *here = p->intended.mode;
    bool changes = r.limits && !p->within_limits;
    return to_and_fro(p, s, 0.5*(r.first + r.last), 0.5*(r.last - r.first), changes ? &left : here, changes ? &right : here) || s->turning;
}

static bool find_cycle(const lw_problem *p, const double *x, lw_work *w)
{
    lw_swing *s = &w->swing;
    lw_closed_motion *c = &w->cycle;
    if (lw_closed_motion_find(&p->plan, x, p->intended.mode, p->intended.mid*input_unit(p, x), w->batch, c) != LW_OK)
        return false;
    s->turning = c->n == 0;
    assert(c->n <= LW_LEG_MAX);
    s->n = c->n;
    s->gain = c->gain;
    for (int j = 0; j < c->n; j++) {
        double first = lw_closed_motion_first(c, j), last = c->leg[j].last;
        set_stroke(p, s, j, 0.5*(first + last), 0.5*fabs(last - first), c->leg[j].mode);
        if (!(s->stroke[j].half > 0))
            return false;
    }
    share_phases(s);
    return true;
}

static bool find(const lw_problem *p, const double *x, lw_work *w)
{
    lw_swing *s = &w->swing;
    s->turning = p->intended.turns;
    s->n = 1;
    s->gain = 0;
    memcpy(s->stroke[0].mode, p->intended.mode, sizeof s->stroke[0].mode);
    if (s->turning)
        return true;
    if (!p->family->linkage)
        return find_range(p, x, s);
    if (p->intended.through)
        return find_cycle(p, x, w);
    double unit = input_unit(p, x);
    return to_and_fro(p, s, p->intended.mid*unit, p->intended.half*unit, p->intended.mode, p->intended.mode);
}

bool lw_circuit_find(const lw_problem *p, const double *x, lw_work *w)
{
    size_t bytes = sizeof *x*(size_t)p->n_dim;
    if (!w->swing.known || memcmp(w->swing.of, x, bytes) != 0) {
        w->swing.closes = find(p, x, w);
        w->swing.known = true;
        w->swing.has_slopes = false;
        memcpy(w->swing.of, x, bytes);
    }
    return w->swing.closes;
}

/* ---- derivatives by the dimensions ------------------------------------------------------------------ */

/* Derivatives of mid and half; the same for both strokes.  The margin is 0 at a limit: its exact derivatives give those of
 * the limit, also near a change point, where they grow beyond all bounds.  Other ends vary slowly: central differences. */
static void range_slopes(const lw_problem *p, const double *x, lw_work *w)
{
    enum { LANES = 8 };
    lw_swing *s = &w->swing;
    double at[LW_VAR_MAX], turn[LANES] = { 0 }, c[LANES], sine[LANES] = { 0 }, px[LANES], py[LANES], margin[LANES];
    double by_dim[LW_DIM_MAX*LANES], by_input[LANES];
    lw_range r[2];
    memcpy(at, x, sizeof at[0]*(size_t)p->n_var);
    if (lw_motion_range(&p->plan, x, p->intended.mode[0], &r[0]) != LW_OK)
        return;
    bool limits = r[0].limits;
    turn[0] = c[0] = r[0].first;
    turn[1] = c[1] = r[0].last;
    if (limits && !p->plan.input_is_slider)
        lw_batch_turns(&p->plan, 2, turn, c, sine);
    if (limits)
        lw_batch_jacobian(&p->plan, &(lw_lanes){ .n = 2, .c = c, .s = sine, .dim = x, .mode = p->intended.mode }, 0, w->batch,
                          &(lw_jacobian){ .x = px, .y = py, .margin = margin, .ld = LANES, .jm = by_dim, .tm = by_input });
    for (int k = 0; p->family->shape[k]; k++) {            /* limits depend on the shape only        */
        int d = lw_plan_dim(&p->plan, p->family->shape[k]);
        double h = 1e-6*fmax(1, fabs(x[d])), end[2] = { 0, 0 };
        bool there = true;
        for (int side = 0; !limits && side < 2; side++) {
            at[d] = side ? x[d] + h : x[d] - h;
            there &= lw_motion_range(&p->plan, at, p->intended.mode[0], &r[side]) == LW_OK && !r[side].turns
                  && r[side].last > r[side].first;
        }
        at[d] = x[d];
        for (int e = 0; e < 2 && there; e++)
            end[e] = limits ? -by_dim[d*LANES + e]/by_input[e]
                            : (e ? r[1].last - r[0].last : r[1].first - r[0].first)/(2*h);
        for (int j = 0; j < 2; j++) {
            s->mid_by[j][d] = 0.5*(end[0] + end[1]);
            s->half_by[j][d] = 0.5*(end[1] - end[0]);
        }
    }
}

static void cycle_slopes(const lw_problem *p, const double *x, lw_work *w)
{
    double by[LW_LEG_MAX*LW_DIM_MAX];
    lw_swing *s = &w->swing;
    lw_closed_motion_slopes(&p->plan, x, &w->cycle, w->batch, by);
    for (int j = 0; j < s->n; j++)
        for (int d = 0; d < p->n_dim; d++) {
            double first = by[(j > 0 ? j - 1 : s->n - 1)*LW_DIM_MAX + d], last = by[j*LW_DIM_MAX + d];
            s->mid_by[j][d] = 0.5*(first + last);
            s->half_by[j][d] = 0.5*(last - first)*(j % 2 ? -1 : 1);
        }
}

/* Derivatives of rate and shift of the strokes from those of their halves. */
static void phase_slopes(const lw_problem *p, lw_swing *s)
{
    double sum = 0;
    for (int j = 0; j < s->n; j++)
        sum += sqrt(s->stroke[j].half);
    for (int d = 0; d < p->n_dim; d++) {
        double sum_by = 0, done = 0, done_by = 0;
        for (int j = 0; j < s->n; j++)
            sum_by += s->half_by[j][d]/(2*sqrt(s->stroke[j].half));
        for (int j = 0; j < s->n; j++) {
            const lw_stroke *k = &s->stroke[j];
            double root = sqrt(k->half), root_by = s->half_by[j][d]/(2*root);
            double from_by = 2*LW_PI*(done_by*sum - done*sum_by)/(sum*sum);
            s->rate_by[j][d] = (sum_by*root - sum*root_by)/(2*k->half);
            s->shift_by[j][d] = -(s->rate_by[j][d]*k->from + k->rate*from_by);
            done += root;
            done_by += root_by;
        }
    }
}

void lw_circuit_slopes(const lw_problem *p, const double *x, lw_work *w)
{
    lw_swing *s = &w->swing;
    int size = p->plan.input_is_slider ? lw_problem_first_length(p) : -1;
    if (!lw_circuit_find(p, x, w) || s->turning || s->has_slopes)
        return;
    for (int j = 0; j < s->n; j++) {
        memset(s->mid_by[j], 0, sizeof s->mid_by[j]);
        memset(s->half_by[j], 0, sizeof s->half_by[j]);
        if (p->family->linkage && size >= 0) {
            s->mid_by[j][size] = p->intended.mid;
            s->half_by[j][size] = p->intended.half;
        }
    }
    if (p->intended.through)
        cycle_slopes(p, x, w);
    else if (!p->family->linkage)
        range_slopes(p, x, w);
    phase_slopes(p, s);
    s->has_slopes = true;
}

double lw_circuit_drift_at(const lw_work *w, const lw_cycle_point *at, size_t d)
{
    const lw_swing *s = &w->swing;
    int j = at->leg;
    double psi_by = s->rate_by[j][d]*at->around + s->shift_by[j][d];
    return s->mid_by[j][d] - s->half_by[j][d]*at->psi_c + s->stroke[j].half*at->psi_s*psi_by;
}

double lw_circuit_drift(const lw_work *w, size_t k, size_t d)
{
    lw_cycle_point at = { .leg = w->leg[k], .around = w->around[k], .psi_c = w->psi_c[k], .psi_s = w->psi_s[k] };
    return lw_circuit_drift_at(w, &at, d);
}

/* ---- postures on the circuit ----------------------------------------------------------------------------- */

enum { BLOCK = 64 };

/* The points at n <= BLOCK phases. */
static void block_points(const lw_problem *p, const lw_work *w, size_t n, const double *phase, lw_cycle_point *at)
{
    const lw_swing *s = &w->swing;
    double angle[BLOCK] = { 0 }, turn_c[BLOCK], turn_s[BLOCK], gained[BLOCK];
    for (size_t i = 0; i < n; i++) {
        at[i] = (lw_cycle_point){ .around = phase[i], .input = phase[i], .rate = 1 };
        angle[i] = phase[i];
        if (s->turning)
            continue;
        double turns = floor(phase[i]/(2*LW_PI));
        at[i].around = phase[i] - 2*LW_PI*turns;
        while (at[i].leg + 1 < s->n && at[i].around >= s->stroke[at[i].leg + 1].from)
            at[i].leg++;
        const lw_stroke *k = &s->stroke[at[i].leg];
        angle[i] = k->rate*at[i].around + k->shift;
        gained[i] = turns*s->gain;
    }
    lw_batch_turns(&p->plan, n, angle, turn_c, turn_s);
    for (size_t i = 0; i < n; i++) {
        at[i].c = at[i].psi_c = turn_c[i];
        at[i].s = at[i].psi_s = turn_s[i];
        if (s->turning)
            continue;
        const lw_stroke *k = &s->stroke[at[i].leg];
        angle[i] = at[i].input = k->mid - k->half*at[i].psi_c + gained[i];
        at[i].rate = k->half*at[i].psi_s*k->rate;
    }
    if (s->turning)
        return;
    lw_batch_turns(&p->plan, n, angle, turn_c, turn_s);
    for (size_t i = 0; i < n; i++) {
        at[i].c = p->plan.input_is_slider ? at[i].input : turn_c[i];
        at[i].s = p->plan.input_is_slider ? 0 : turn_s[i];
    }
}

void lw_circuit_points(const lw_problem *p, const lw_work *w, size_t n, const double *phase, lw_cycle_point *at)
{
    for (size_t first = 0; first < n; first += BLOCK)
        block_points(p, w, n - first < BLOCK ? n - first : BLOCK, phase + first, at + first);
}

void lw_circuit_put_mode(const lw_problem *p, const lw_work *w, int leg, double *mode, size_t stride)
{
    for (int d = 0; d < p->plan.n_dyad; d++)
        mode[(size_t)d*stride] = w->swing.stroke[leg].mode[d];
}

void lw_circuit_lanes(const lw_problem *p, lw_work *w, size_t n)
{
    bool modes = lw_problem_has_modes(p);
    if (w->swing.turning && !modes) {
        lw_batch_turns(&p->plan, n, w->phase, w->c, w->s);
        memcpy(w->input, w->phase, n*sizeof *w->input);
        for (size_t k = 0; k < n; k++)
            w->rate[k] = 1;
        return;
    }
    for (size_t first = 0; first < n; first += BLOCK) {
        lw_cycle_point each[BLOCK];
        size_t count = n - first < BLOCK ? n - first : BLOCK;
        block_points(p, w, count, w->phase + first, each);
        for (size_t k = first; k < first + count; k++) {
            lw_cycle_point at = each[k - first];
            w->c[k] = at.c;
            w->s[k] = at.s;
            w->input[k] = at.input;
            w->rate[k] = at.rate;
            w->around[k] = at.around;
            w->psi_c[k] = at.psi_c;
            w->psi_s[k] = at.psi_s;
            w->leg[k] = (short)at.leg;
            if (modes)
                lw_circuit_put_mode(p, w, at.leg, w->mode + k, w->ld);
        }
    }
}

size_t lw_circuit_run(const lw_work *w, size_t first, size_t n)
{
    size_t k = first + 1;
    while (k < n && w->leg[k] == w->leg[first])
        k++;
    return k;
}

void lw_circuit_modes(const lw_problem *p, const lw_work *w, lw_lanes *in)
{
    if (!lw_problem_has_modes(p))
        return;
    in->mode = w->mode;
    in->mode_stride = w->ld;
}

#include "optimise/search/random_linkage.h"

#include <stdlib.h>
#include <string.h>

#include "base/real_complex.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/residuals.h"

enum { M = LW_CURVE_SAMPLES };

/* Points and directions of the plan's registers over the inputs of the motion: over a turn, or at one input. */
typedef struct drawing {
    const lw_plan *plan;
    const double  *u;               /* random numbers not used yet                                  */
    double        *shape, *mode;
    int            n;               /* inputs                                                       */
    double         input[M];
    bool           must_turn;               /* lengths are chosen with room for a full turn between the samples too  */
    bool           drawn[LW_DIM_MAX];
    double         length[LW_LINK_MAX];     /* of the first two pins of a link, 0: not known        */
    double complex (*reg)[M];
} drawing;

int lw_random_linkage_draws(const lw_problem *p)
{
    const lw_linkage *k = p->family->linkage;
    int n = p->plan.n_dim + p->plan.n_dyad + 2;
    if (p->plan.n_higher > 0)
        n = 2 + 3*k->n_joint;
    return n < LW_RANDOM_LINKAGE_DRAW_MAX ? n : LW_RANDOM_LINKAGE_DRAW_MAX;
}

static double ratio(double u, double lo, double hi)
{
    return lo*exp(u*log(hi/lo));
}

static void choose(drawing *d, int dim, double value)
{
    d->shape[dim] = value;
    d->drawn[dim] = true;
    if (d->plan->dim[dim].role == LW_ROLE_R)
        d->length[d->plan->dim[dim].link] = value;
}

/* ---- points and lines on links -------------------------------------------------------------------- */

/* Choose a pin of a link: the crank's at distance one, others near the size of their link. */
static void draw_point(drawing *d, const lw_step *s)
{
    if (s->dim[0] < 0 || d->drawn[s->dim[0]])            /* the link's origin needs no numbers      */
        return;
    int link = d->plan->dim[s->dim[0]].link;
    double size = d->length[link] > 0 ? d->length[link] : link == d->plan->link[1] ? 1 : 2.5;
    if (s->dim[1] < 0) {
        choose(d, s->dim[0], link == d->plan->link[1] ? 1 : size*ratio(*d->u++, 0.12, 4));
        return;
    }
    double complex at = size*ratio(d->u[0], 0.15, 3)*cexp(2*LW_PI*I*d->u[1]);
    d->u += 2;
    choose(d, s->dim[0], creal(at));
    choose(d, s->dim[1], cimag(at));
}

static void step_point(drawing *d, const lw_step *s)
{
    draw_point(d, s);
    double complex lever_arm = (s->dim[0] >= 0 ? d->shape[s->dim[0]] : 0)
                               + (s->dim[1] >= 0 ? I*d->shape[s->dim[1]] : 0);
    for (int k = 0; k < d->n; k++)
        d->reg[s->out[0]][k] = d->reg[s->in[0]][k] + lever_arm*d->reg[s->in[1]][k];
}

static void step_line(drawing *d, const lw_step *s)
{
    if (s->dim[0] >= 0 && !d->drawn[s->dim[0]]) {
        double v = 2**d->u++ - 1;
        choose(d, s->dim[0], 4*v*v*v);
    }
    if (s->dim[1] >= 0 && !d->drawn[s->dim[1]])
        choose(d, s->dim[1], LW_PI*(2**d->u++ - 1));
    double e = s->dim[0] >= 0 ? d->shape[s->dim[0]] : 0;
    double complex turn = cexp(I*(s->dim[1] >= 0 ? d->shape[s->dim[1]] : 0));
    for (int k = 0; k < d->n; k++) {
        double complex w = d->reg[s->in[1]][k]*turn;
        d->reg[s->out[1]][k] = w;
        d->reg[s->out[0]][k] = d->reg[s->in[0]][k] + I*e*w;
    }
}

/* ---- dyads ------------------------------------------------------------------------------------------ */

static double sign_of(drawing *d, const lw_step *s)
{
    return d->mode[s->dyad] = *d->u++ < 0.5 ? -1 : 1;
}

/* The greatest of sign*v over the samples and, where the input must turn, between them: a sample that is greater than
 * both neighbours is raised to the vertex of the parabola through the three and by half of that again, since curves are
 * steeper. */
static double greatest(const drawing *d, const double *v, double sign)
{
    int n = d->n;
    double most = -INFINITY;
    for (int k = 0; k < n; k++) {
        double before = sign*v[k > 0 ? k - 1 : n - 1], now = sign*v[k], after = sign*v[k + 1 < n ? k + 1 : 0];
        double bend = 2*now - before - after, slope = after - before;
        bool top = d->must_turn && now >= before && now >= after && bend > 0;
        most = fmax(most, now + (top ? 1.5*slope*slope/(8*bend) : 0));
    }
    return most;
}

/* Least and greatest distance of two points over the motion. */
static void distances(const drawing *d, int a, int b, double *least, double *most)
{
    double r[M];
    for (int k = 0; k < d->n; k++)
        r[k] = cabs(d->reg[b][k] - d->reg[a][k]);
    *least = fmax(0, -greatest(d, r, -1));
    *most = greatest(d, r, 1);
}

/* The sum of both lengths exceeds the greatest distance; their difference is below the least. */
static bool step_rrr(drawing *d, const lw_step *s)
{
    double least, most, mode = sign_of(d, s);
    distances(d, s->in[0], s->in[1], &least, &most);
    double sum = fmax(most, 1e-3)*(1 + ratio(d->u[0], 0.004, 4)), differ = least*0.995*(2*d->u[1] - 1);
    d->u += 2;
    choose(d, s->dim[0], 0.5*(sum + differ));
    choose(d, s->dim[1], 0.5*(sum - differ));
    for (int k = 0; k < d->n; k++) {
        double complex a = d->reg[s->in[0]][k], b = d->reg[s->in[1]][k];
        double r = cabs(b - a), r1 = d->shape[s->dim[0]], r2 = d->shape[s->dim[1]];
        double along = (r*r + r1*r1 - r2*r2)/(2*r), h2 = r1*r1 - along*along;
        if (!(h2 > 0))
            return false;
        double complex c = a + (b - a)/r*(along + I*mode*sqrt(h2));
        d->reg[s->out[0]][k] = (c - a)/r1;
        if (s->out[1] >= 0)
            d->reg[s->out[1]][k] = (c - b)/r2;
        if (s->out[2] >= 0)
            d->reg[s->out[2]][k] = c;
    }
    return true;
}

/* The link is longer than the pin's greatest distance from the line. */
static bool step_rrp(drawing *d, const lw_step *s)
{
    double mode = sign_of(d, s), off[M];
    for (int k = 0; k < d->n; k++)
        off[k] = cimag((d->reg[s->in[0]][k] - d->reg[s->in[1]][k])*conj(d->reg[s->in[2]][k]));
    double most = fmax(greatest(d, off, 1), greatest(d, off, -1));
    choose(d, s->dim[0], most > 1e-6 ? most*(1 + ratio(*d->u++, 0.004, 8)) : ratio(*d->u++, 0.2, 4));
    double r = d->shape[s->dim[0]];
    for (int k = 0; k < d->n; k++) {
        double complex a = d->reg[s->in[0]][k], w = d->reg[s->in[2]][k];
        double complex foot = (a - d->reg[s->in[1]][k])*conj(w);
        double complex c = d->reg[s->in[1]][k] + w*(creal(foot) + mode*sqrt(r*r - cimag(foot)*cimag(foot)));
        d->reg[s->out[0]][k] = (c - a)/r;
        if (s->out[1] >= 0)
            d->reg[s->out[1]][k] = c;
    }
    return true;
}

/* The offset is smaller than the least distance of the pins. */
static bool step_rpr(drawing *d, const lw_step *s)
{
    double least, most, mode = sign_of(d, s), v;
    distances(d, s->in[0], s->in[1], &least, &most);
    if (!(least > 0))
        return false;
    if (s->dim[0] >= 0) {
        v = 2**d->u++ - 1;
        choose(d, s->dim[0], 0.99*least*v*v*v);
    }
    double e = s->dim[0] >= 0 ? d->shape[s->dim[0]] : 0;
    for (int k = 0; k < d->n; k++) {
        double complex ab = d->reg[s->in[1]][k] - d->reg[s->in[0]][k];
        double r2 = creal(ab)*creal(ab) + cimag(ab)*cimag(ab);
        d->reg[s->out[0]][k] = ab/(mode*sqrt(r2 - e*e) + I*e);
    }
    return true;
}

static bool step_lines(drawing *d, const lw_step *s)
{
    for (int k = 0; k < d->n; k++) {
        double complex q = d->reg[s->in[0]][k], w = d->reg[s->in[1]][k];
        double complex across = d->reg[s->in[3]][k];
        double sine = cimag(conj(w)*across);
        if (!(fabs(sine) > 1e-3))
            return false;
        double t = cimag(conj(d->reg[s->in[2]][k] - q)*across)/sine;
        d->reg[s->out[0]][k] = q + t*w;
    }
    return true;
}

static bool step_gear(drawing *d, const lw_step *s)
{
    if (s->dim[0] >= 0)
        choose(d, s->dim[0], LW_PI*(2**d->u++ - 1));
    for (int k = 0; k < d->n; k++) {
        double complex u = cexp(I*(s->dim[0] >= 0 ? d->shape[s->dim[0]] : 0));
        for (int h = 0; h < 2 && s->in[h] >= 0; h++)
            for (int m = 0; m < abs(s->power[h]); m++)
                u *= s->power[h] < 0 ? conj(d->reg[s->in[h]][k]) : d->reg[s->in[h]][k];
        d->reg[s->out[0]][k] = u;
    }
    return true;
}

/* ---- racks ----------------------------------------------------------------------------------------- */

/* A pitch radius of either sign. */
static double radius(double u, double lo, double hi)
{
    double v = 2*u - 1;
    return copysign(ratio(fabs(v), lo, hi), v);
}

static void step_slide(drawing *d, const lw_step *s)
{
    for (int k = 0; k < d->n; k++)
        d->reg[s->out[0]][k] = d->reg[s->in[0]][k] + creal(d->reg[s->in[2]][k])*d->reg[s->in[1]][k];
}

static void step_along(drawing *d, const lw_step *s)
{
    for (int k = 0; k < d->n; k++)
        d->reg[s->out[0]][k] = creal((d->reg[s->in[2]][k] - d->reg[s->in[0]][k])*conj(d->reg[s->in[1]][k]));
}

/* The pinion turns back and forth by a third of 1 rad to two turns. */
static void step_roll(drawing *d, const lw_step *s)
{
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < d->n; k++) {
        least = fmin(least, creal(d->reg[s->in[1]][k]));
        most = fmax(most, creal(d->reg[s->in[1]][k]));
    }
    double stroke = most - least > 1e-3 ? most - least : 2;
    choose(d, s->dim[0], radius(*d->u++, stroke/12, 3*stroke));
    choose(d, s->dim[1], least - d->shape[s->dim[0]]*2*LW_PI**d->u++);
    for (int k = 0; k < d->n; k++)
        d->reg[s->out[0]][k] = d->reg[s->in[0]][k]
                             *cexp(I*(creal(d->reg[s->in[1]][k]) - d->shape[s->dim[1]])/d->shape[s->dim[0]]);
}

/* The middle of the rack belongs to the middle of its pinion's angles, whose range is less than a turn. */
static bool step_rack(drawing *d, const lw_step *s)
{
    double angle[M] = { 0 }, least = INFINITY, most = -INFINITY;
    for (int k = 0; k < d->n; k++) {
        double a = carg(d->reg[s->in[0]][k]*conj(d->reg[s->in[1]][k]));
        angle[k] = k > 0 ? angle[k - 1] + remainder(a - angle[k - 1], 2*LW_PI) : a;
        least = fmin(least, angle[k]);
        most = fmax(most, angle[k]);
    }
    double back = angle[0] - angle[d->n - 1];
    if (most - least > 2*LW_RACK_REACH || fabs(back - remainder(back, 2*LW_PI)) > 1)
        return false;
    double middle = 0.5*(least + most), v = 2*d->u[1] - 1;
    choose(d, s->dim[0], radius(d->u[0], 0.15, 3));
    choose(d, s->dim[1], 4*v*v*v - d->shape[s->dim[0]]*middle);
    choose(d, s->dim[2], middle);
    d->mode[s->dyad] = 1;
    d->u += 2;
    for (int k = 0; k < d->n; k++)
        d->reg[s->out[0]][k] = d->shape[s->dim[1]] + d->shape[s->dim[0]]*angle[k];
    return true;
}

/* ---- all steps ---------------------------------------------------------------------------------------- */

static bool take_step(drawing *d, const lw_step *s)
{
    switch (s->kind) {
    case LW_STEP_INPUT_PIN:
        for (int k = 0; k < d->n; k++)
            d->reg[s->out[0]][k] = cexp(I*d->input[k]);
        return true;
    case LW_STEP_INPUT_SLIDE:
        for (int k = 0; k < d->n; k++)
            d->reg[s->out[0]][k] = d->reg[s->in[0]][k] + d->input[k]*d->reg[s->in[1]][k];
        return true;
    case LW_STEP_POINT: step_point(d, s); return true;
    case LW_STEP_LINE:  step_line(d, s); return true;
    case LW_STEP_RRR:   return step_rrr(d, s);
    case LW_STEP_RRP:   return step_rrp(d, s);
    case LW_STEP_RPR:   return step_rpr(d, s);
    case LW_STEP_PRP:
    case LW_STEP_PPR:   return step_lines(d, s);
    case LW_STEP_GEAR:  return step_gear(d, s);
    case LW_STEP_SLIDE: step_slide(d, s); return true;
    case LW_STEP_ALONG: step_along(d, s); return true;
    case LW_STEP_ROLL:  step_roll(d, s); return true;
    case LW_STEP_RACK:  return step_rack(d, s);
    case LW_STEP_HIGHER:
    case LW_STEP_TURN:  break;                             /* not in plans of dyads and gears */
    }
    return false;
}

/* Take the steps that the tracers depend on.  The places of the tracers on their links are not drawn but solved for. */
static bool run_steps(drawing *d)
{
    const lw_plan *plan = d->plan;
    for (int k = 0; k < d->n; k++) {
        d->reg[0][k] = 0;
        d->reg[1][k] = 1;
    }
    bool all = plan->n_output > 1;                   /* several points: the steps of all               */
    for (int i = 0; i < (all ? plan->n_step : plan->n_output_step[0]); i++) {
        const lw_step *s = &plan->step[all ? i : plan->output_step[0][i]];
        bool tracer = s->kind == LW_STEP_POINT && s->dim[0] >= 0 && plan->dim[s->dim[0]].role == LW_ROLE_CX;
        if (!tracer && !take_step(d, s))
            return false;
    }
    return true;
}

/* Find the range around p->intended.mid in which the linkage closes, within `reach` to each side: at M samples, and at
 * FINER times as many, so that no gap wider than a hundredth of a radian is stepped over. */
static bool find_range(lw_problem *p, const double *shape, double reach, lw_work *w)
{
    enum { FINER = 8 };
    int half = M/2, lo = 0, hi = M - 1;
    double width = reach/half;
    for (int part = 0; part < FINER; part++) {
        int first = half, last = half;
        for (int k = 0; k < M; k++)
            w->posture_x[k] = p->intended.mid + (k - half + (double)part/FINER)*width;
        lw_problem_inputs(p, w, M);
        lw_lanes in = { .n = M, .c = w->posture_c, .s = w->posture_s, .dim = shape, .mode = p->intended.mode };
        lw_problem_margin(p, &in, w, w->posture.margin);
        if (part > 0 && !(w->posture.margin[half - 1] > 1e-3))   /* between the middle and the samples beside it */
            lo = half;
        if (part > 0 && !(w->posture.margin[half] > 1e-3))
            hi = half;
        while (first > 0 && w->posture.margin[first - 1] > 1e-3)
            first--;
        while (last < M - 1 && w->posture.margin[last + (part == 0)] > 1e-3)
            last++;
        lo = first > lo ? first : lo;
        hi = last < hi ? last : hi;
    }
    int size = p->plan.input_is_slider ? lw_problem_first_length(p) : -1;
    double unit = size >= 0 ? shape[size] : 1;
    p->intended.half = 0.5*(hi - lo)*width/unit;
    p->intended.mid = (p->intended.mid + (0.5*(hi + lo) - half)*width)/unit;
    return hi > lo + 2;
}

/* Find the circuit through p->intended.mid, across the limits of the motion.  mid and half become those of its first
 * stroke, without the limits themselves. */
static bool find_circuit(lw_problem *p, const double *shape, lw_work *w)
{
    int size = p->plan.input_is_slider ? lw_problem_first_length(p) : -1;
    double unit = size >= 0 ? shape[size] : 1, mid = p->intended.mid;
    if (!p->closed || p->within_limits || p->timing == LW_TIMING_PRESCRIBED || p->plan.n_higher > 0)
        return false;
    p->intended.through = true;
    p->intended.mid = mid/unit;
    lw_problem_work_intended(p, w);
    bool found = lw_circuit_find(p, shape, w) && !w->swing.turning;
    p->intended.through = found;
    p->intended.mid = found ? w->swing.stroke[0].mid/unit : mid;
    p->intended.half = found ? (1 - 1e-6)*w->swing.stroke[0].half/unit : 0;
    lw_problem_work_intended(p, w);
    return found;
}

/* Find a motion: for a closed curve one that returns another way, else back and forth in a range. */
static bool find_motion(lw_problem *p, const double *shape, lw_work *w)
{
    return find_circuit(p, shape, w) || find_range(p, shape, p->plan.input_is_slider ? 8 : LW_PI, w);
}

/* A group with gears is computed by continuation from its seed, half a turn to either side: do both sides end at the
 * same posture?  Compare the step across that input with the steps just before and after it.  (Lanes in order of their
 * inputs would all be continued from one side.) */
static bool comes_back(const lw_problem *p, const double *x, lw_work *w)
{
    enum { N = 4 };
    static const double off[N] = { -1e-4, 1e-4, -2e-4, 2e-4 };
    static const int before[N - 1] = { 2, 0, 1 }, behind[N - 1] = { 0, 1, 3 };
    const lw_plan *plan = &p->plan;
    double c[N], s[N], px[N], py[N], u[N], v[N], step[N - 1];
    bool gears = false;
    for (int g = 0; g < plan->n_higher; g++)
        gears = gears || plan->higher[g].n_gear > 0;
    if (!gears)
        return true;
    for (int k = 0; k < N; k++) {
        double t = p->intended.mode[plan->n_mode - 1] + LW_PI + off[k];
        c[k] = cos(t);
        s[k] = sin(t);
    }
    lw_lanes in = { .n = N, .c = c, .s = s, .dim = x, .mode = p->intended.mode };
    lw_batch_point(plan, &in, 0, w->batch, px, py, u, v, NULL);
    for (int k = 0; k < N - 1; k++) {
        int a = before[k], b = behind[k];
        step[k] = hypot(px[b] - px[a], py[b] - py[a])/lw_plan_size(plan, x) + hypot(u[b] - u[a], v[b] - v[a]);
    }
    return step[1] <= 10*(step[0] + step[2]) + 1e-9;
}

/* Does the linkage close at every sample of a turn, and return to its first posture? */
static bool closes_all_round(const lw_problem *p, const double *x, lw_work *w)
{
    lw_lanes in = { .n = M, .c = w->turn_c, .s = w->turn_s, .dim = x, .mode = p->intended.mode };
    lw_problem_margin(p, &in, w, w->posture.margin);
    for (int k = 0; k < M; k++)
        if (!(w->posture.margin[k] > 0))
            return false;
    return comes_back(p, x, w);
}

bool lw_random_linkage_posture(lw_problem *p, double *x, void *work)
{
    double dim[LW_DIM_MAX], input;
    memset(x, 0, sizeof *x*(size_t)p->n_var);
    if (lw_plan_read(&p->plan, p->family->linkage, dim, p->intended.mode, &input, NULL) != LW_OK)
        return false;
    lw_problem_from_dims(p, dim, x);
    for (int i = 0; i < p->n_dim; i++)
        x[i] = fmin(fmax(x[i], p->lo[i]), p->hi[i]);
    if (p->i_input0 >= 0 && p->datum == LW_DATUM_FREE)
        x[p->i_input0] = input;
    p->intended.mid = p->plan.input_is_slider ? input/p->unit : input;
    p->intended.through = false;
    p->intended.turns = true;
    lw_problem_work_intended(p, work);
    p->intended.turns = !p->plan.input_is_slider && closes_all_round(p, x, work);
    if (p->must_turn && !p->intended.turns)
        return false;
    lw_problem_work_intended(p, work);
    return p->intended.turns || find_motion(p, x, work);
}

/* ---- postures ------------------------------------------------------------------------------------------ */

static int driven_link(const lw_linkage *linkage, int input)
{
    const lw_joint *j = &linkage->joint[linkage->input[input].joint];
    return j->link[j->link[0] == linkage->ground];
}

/* The input whose driven link carries this joint besides the input's own joint; -1: none. */
static int crank_with(const lw_linkage *linkage, int joint)
{
    for (int i = 0; i < linkage->n_input; i++) {
        int driven = driven_link(linkage, i);
        if (joint != linkage->input[i].joint && (linkage->joint[joint].link[0] == driven || linkage->joint[joint].link[1] == driven))
            return i;
    }
    return -1;
}

/* The pin about which a driven link turns; of a sliding one the middle of the square. */
static lw_vec2 hub(const lw_linkage *linkage, int input)
{
    const lw_joint *j = &linkage->joint[linkage->input[input].joint];
    return lw_joint_turns(j->kind) ? j->at : lw_v2(0, 0);
}

/* Place the joints anywhere in a square of four crank lengths to each side of the first input's pin; joints of driven
 * links about one crank length from the link's own pin. */
static void scatter(const lw_problem *p, const double *u, lw_linkage *linkage)
{
    *linkage = *p->family->linkage;
    for (int j = 0; j < linkage->n_joint; j++) {
        lw_joint *i = &linkage->joint[j];
        const double *v = u + (3*j) % (LW_RANDOM_LINKAGE_DRAW_MAX - 2);
        i->at = lw_v2(8*v[0] - 4, 8*v[1] - 4);
        if (j == linkage->input[0].joint && lw_joint_turns(i->kind))
            i->at = lw_v2(0, 0);
        if (!lw_joint_turns(i->kind))
            i->along = lw_v2_polar(1, LW_PI*v[2]);
    }
    for (int j = 0; j < linkage->n_joint; j++) {
        const double *v = u + (3*j) % (LW_RANDOM_LINKAGE_DRAW_MAX - 2);
        int crank = crank_with(linkage, j);
        if (crank >= 0 && lw_joint_turns(linkage->joint[j].kind))
            linkage->joint[j].at = lw_v2_add(hub(linkage, crank), lw_v2_polar(ratio(v[0], 0.7, 1.4), 2*LW_PI*v[1]));
    }
    for (int r = 0; r < p->plan.n_rack; r++) {
        const lw_rack *q = &p->plan.rack[r];
        double rho = radius(u[(3*q->joint) % (LW_RANDOM_LINKAGE_DRAW_MAX - 2)], 0.15, 3);
        linkage->joint[q->joint].ratio = q->side ? rho : 1/rho;
    }
    linkage->tracer[0].at = lw_v2(1, 1);
}

/* Scale the driven links about their pins at the ground. */
static void shorten_cranks(lw_linkage *linkage, double by)
{
    for (int j = 0; j < linkage->n_joint; j++) {
        int crank = crank_with(linkage, j);
        if (crank < 0)
            continue;
        lw_vec2 pin = hub(linkage, crank);
        linkage->joint[j].at = lw_v2_add(pin, lw_v2_scale(lw_v2_sub(linkage->joint[j].at, pin), by));
    }
}

/* Draw a posture and read its dimensions; its crank turns fully, or it moves back and forth around the posture. */
static bool draw_posture(lw_problem *p, const double *u, double *shape, lw_work *w)
{
    lw_linkage k;
    double input;
    scatter(p, u, &k);
    for (int i = 0; i < 5; i++, shorten_cranks(&k, 0.5)) {
        if (lw_plan_read(&p->plan, &k, shape, p->intended.mode, &input, NULL) != LW_OK)
            return false;
        if (!p->intended.turns) {
            p->intended.mid = input;
            return find_motion(p, shape, w);
        }
        if (closes_all_round(p, shape, w))
            return true;
    }
    return false;
}

/* Does a linkage that closes at the samples of a turn also close between them? */
static bool closes_between(const lw_problem *p, const double *shape, lw_work *w)
{
    enum { FINER = 8 };
    for (int part = 1; part < FINER; part++) {
        for (int k = 0; k < M; k++)
            w->posture_x[k] = 2*LW_PI*(k + (double)part/FINER)/M;
        lw_problem_inputs(p, w, M);
        lw_lanes in = { .n = M, .c = w->posture_c, .s = w->posture_s, .dim = shape, .mode = p->intended.mode };
        lw_problem_margin(p, &in, w, w->posture.margin);
        for (int k = 0; k < M; k++)
            if (!(w->posture.margin[k] > 1e-6))
                return false;
    }
    return true;
}

bool lw_random_linkage_draw(lw_problem *p, const double *u, bool turns, double *shape, void *work)
{
    lw_work *w = work;
    drawing d = { .plan = &p->plan, .u = u + 2, .shape = shape, .mode = p->intended.mode, .reg = w->registers,
                  .must_turn = turns && !p->plan.input_is_slider };
    bool slides = p->plan.input_is_slider;
    p->intended.turns = !slides && (turns || u[0] < 0.5);
    p->intended.through = false;
    p->intended.mid = slides ? 6*u[1] - 3 : 2*LW_PI*u[1];
    d.n = p->intended.turns ? M : 1;
    for (int k = 0; k < d.n; k++)
        d.input[k] = p->intended.turns ? 2*LW_PI*k/M : p->intended.mid;
    memset(shape, 0, sizeof *shape*(size_t)p->n_dim);
    if (p->plan.n_higher > 0) {
        lw_problem_work_intended(p, work);
        return draw_posture(p, u + 2, shape, work);
    }
    for (int i = 0; i < LW_MODE_MAX; i++)
        p->intended.mode[i] = 1;
    if (!run_steps(&d))
        return false;
    if (p->intended.turns && !turns && !closes_between(p, shape, work)) {
        p->intended.turns = false;
        lw_problem_work_intended(p, work);
        return find_motion(p, shape, work);
    }
    lw_problem_work_intended(p, work);
    return p->intended.turns || find_motion(p, shape, work);
}

/* tests/test_swing.c - closed curves of six-bars whose input does not turn: traced by arc length over all limits
 * (mbs/constraints/motion_curve.h, which knows no assemblies), they are curves of the problem with the true dimensions; its derivatives
 * over limits; and a search that is told the topology alone finds them. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "mbs/constraints/motion_curve.h"
#include "optimise/search/fit.h"
#include "optimise/search/random_linkage.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"
#include "optimise/problem/variable_projection.h"
#include "optimise/report/report.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

/* Stephenson III driven at the rocker of its four-bar, and Watt's six-bar at its own. */
static const pin_net net[] = {
    { "Stephenson III", 6, 7, 4, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 2, 4 }, { 4, 5 }, { 5, 0 } } },
    { "Watt I", 6, 7, 4, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 2, 4 }, { 4, 5 }, { 5, 3 } } },
    { "Watt II", 6, 7, 4, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 3, 4 }, { 4, 5 }, { 5, 0 } } },
};
enum { N_NET = sizeof net/sizeof *net, STATIONS = 40, BUDGET = 100000 };

/* The whole motion, even in arc length: points, inputs beyond that of the posture, limits passed before each. */
typedef struct journey { int limits, passed[STATIONS]; double x[STATIONS], y[STATIONS], input[STATIONS]; } journey;

/* false: it is no linkage whose motion goes over limits and closes. */
static bool travel(const lw_linkage *k, size_t n, journey *to)
{
    lw_system *s = malloc(sizeof *s);
    lw_motion_curve *b = NULL;
    double q[LW_SYSTEM_Q_MAX];
    int n_event = 0;
    to->limits = 0;
    if (lw_system_make(k, NULL, 0, s, NULL) == LW_OK
        && lw_motion_curve_create(s, NULL, &(lw_motion_curve_options){ .input = 0 }, &b, NULL) == LW_OK
        && lw_motion_curve_ended(b) == LW_MOTION_CURVE_CLOSED) {
        const lw_motion_curve_event *e = lw_motion_curve_events(b, &n_event);
        for (int i = 0; i < n_event; i++)
            to->limits += e[i].kind == LW_EVENT_LIMIT;
        for (size_t i = 0; i < n; i++) {
            double place = lw_motion_curve_station(b, lw_motion_curve_length(b)*(double)i/(double)n);
            lw_motion_curve_posture(b, place, q, NULL);
            lw_vec2 p = lw_system_point(s, s->tracer_body[0], s->tracer_arm[0], q);
            to->x[i] = p.x;
            to->y[i] = p.y;
            to->input[i] = lw_motion_curve_input(b, q) - k->input[0].value;
            to->passed[i] = 0;
            for (int j = 0; j < n_event; j++)
                to->passed[i] += e[j].kind == LW_EVENT_LIMIT && e[j].station < place;
        }
    }
    lw_motion_curve_free(b);
    lw_system_free(s);
    free(s);
    return to->limits > 0;
}

static lw_fit_spec wide_spec(void)
{
    lw_fit_spec spec = lw_fit_spec_default();
    spec.length_lo = 1e-4;
    spec.length_hi = 1e3;
    spec.position_lo = -1e3;
    spec.position_hi = 1e3;
    return spec;
}

/* The problem of a target with the family of k, at k's own dimensions. */
static void *begin(const lw_family *f, const lw_target *t, lw_problem *p, double *x)
{
    lw_fit_spec spec = wide_spec();
    lw_error e = { .text = "" };
    CHECK_INT(lw_problem_make(t, &spec, f, 1, 1, p, &e), LW_OK);
    void *work = aligned_alloc(64, (lw_problem_work_size(p) + 127) & ~(size_t)63);
    lw_problem_work_init(p, work);
    CHECK(lw_random_linkage_posture(p, x, work));
    return work;
}

/* Put the stations where they are: as many strokes on as limits were passed, at their inputs. */
static void place(const lw_problem *p, const journey *way, double first, lw_work *w)
{
    for (size_t i = 0; i < p->n; i++) {
        int j = way->passed[i] % w->swing.n;
        const lw_stroke *s = &w->swing.stroke[j];
        double away = remainder(s->mid - first - way->input[i], 2*LW_PI)/s->half;
        double psi = acos(fmax(-1, fmin(1, away)));
        w->phase[i] = (j*LW_PI + (j % 2 ? LW_PI - psi : psi) - s->shift)/s->rate;
    }
}

/* Inputs are rounded by some units in the last place; near a limit the point moves much farther.  What that adds to f. */
static double rounding(const lw_problem *p, const lw_work *w)
{
    double f = 0, t[LW_PROBLEM_ROW_MAX];
    for (size_t k = 0; k < p->n; k++) {
        double off = 4*DBL_EPSILON*fabs(w->input[k])/w->rate[k];
        f += off*off*lw_problem_tangent(p, w, k, t);
    }
    return f;
}

/* Is the linkage refused, though it closes at all stations, since a dyad comes near to a dead point between limits? */
static bool is_refused(const lw_problem *p, const double *x, lw_work *w)
{
    bool refused = lw_problem_turn_stations(p, x, w) && !lw_problem_lanes(p, x, w);
    for (size_t k = 0; k < p->n; k++)
        refused = refused && w->jac.margin[k] > 0;
    return refused;
}

TEST(the_true_dimensions_have_no_error)
{
    int seen[N_NET] = { 0 }, many = 0, other = 0, refused = 0, settled = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 90; trial++) {
        lw_linkage k = random_net(&net[trial % N_NET], &rng);
        lw_family f = { .name = net[trial % N_NET].name, .linkage = &k, .posture = true, .links = 6 };
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        journey way;
        double x[LW_VAR_MAX], dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
        if (!travel(&k, STATIONS, &way))
            continue;
        CHECK_INT(lw_target_make(STATIONS, way.x, way.y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
        FREED lw_work *w = begin(&f, &t, &p, x);
        settled += lw_problem_value(&p, x, NULL, w) < 1e-20;
        CHECK_INT(lw_plan_read(&p.plan, &k, dim, mode, &input, NULL), LW_OK);
        if (!p.intended.through || !lw_circuit_find(&p, x, w) || w->swing.n != way.limits)
            other++;                                     /* limits closer than samples                   */
        else {
            place(&p, &way, input, w);
            if (is_refused(&p, x, w)) {
                refused++;
                continue;
            }
            CHECK(lw_timing_refine(&p, x, w, 60));
            CHECK_NEAR(lw_problem_rows(&p, x, w, false), 0, 1e-18 + rounding(&p, w), 0);
            seen[trial % N_NET]++;
            many += way.limits > 2;
        }
    }
    for (int i = 0; i < N_NET; i++)
        CHECK(seen[i] > 10);
    CHECK(many > 5 && other <= 3 && refused <= 3);
    CHECK(settled > 40);             /* from scratch: stations at a sharp bend may stay on the wrong side of it */
}

/* Do the stations rest where they are: is f the same after more steps? */
static bool at_rest(const lw_problem *p, const double *x, double f, lw_work *w)
{
    return lw_problem_settle(p, x, w) && lw_timing_refine(p, x, w, 60) && lw_timing_refine(p, x, w, 60)
        && fabs(lw_problem_rows(p, x, w, false) - f) < 1e-10*f;
}

TEST(derivatives_hold_over_limits)
{
    int checked = 0, rough = 0, idle = 0;
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 24; trial++) {
        lw_linkage k = random_net(&net[trial % N_NET], &rng);
        lw_family f = { .name = net[trial % N_NET].name, .linkage = &k, .posture = true, .links = 6 };
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        journey way;
        double x[LW_VAR_MAX], grad[LW_VAR_MAX];
        if (!travel(&k, 15, &way))
            continue;
        CHECK_INT(lw_target_make(15, way.x, way.y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
        FREED void *work = begin(&f, &t, &p, x);
        for (int v = 0; v < p.n_var; v++)
            x[v] += 0.003*lw_rng_normal(&rng);
        double here = lw_problem_value(&p, x, grad, work);
        if (!isfinite(here) || !at_rest(&p, x, here, work))
            idle++;                                      /* it closes nowhere any more, or stations still move */
        for (int v = 0; v < p.n_var && isfinite(here) && at_rest(&p, x, here, work); v++) {
            double at = x[v], slope[2], bump = 0;
            for (int i = 0; i < 2; i++) {
                double h = i ? 2e-6 : 1e-6, value[2];
                for (int side = 0; side < 2; side++) {
                    x[v] = side ? at + h : at - h;
                    value[side] = lw_problem_value(&p, x, NULL, work);
                }
                slope[i] = (value[1] - value[0])/(2*h);
                bump = fmax(bump, fabs(0.5*(value[1] + value[0]) - here));
            }
            x[v] = at;
            if (!(fabs(slope[1] - slope[0]) < 1e-6*(1 + fabs(slope[0])) && bump < 1e-8)) {
                rough++;                                 /* a station passes to another place           */
                continue;
            }
            CHECK_NEAR(grad[v], slope[0], 1e-6, 1e-5);
            checked++;
        }
    }
    CHECK(checked > 100 && rough < checked/5 && idle < 8);
}

/* A search that knows the topology and none of the dimensions. */
TEST(a_search_finds_the_curve)
{
    lw_rng rng;
    FREED lw_fit_report *r = malloc(sizeof *r);
    lw_rng_seed(&rng, 20260101, 4);
    for (int which = 0; which < 2; which++) {
        lw_linkage k;
        journey way;
        OWN(lw_target) t = { 0 };
        OWN(lw_fit) fit = { 0 };
        lw_error e = { .text = "" };
        lw_fit_options o = lw_fit_options_default();
        do
            k = random_net(&net[which], &rng);
        while (!travel(&k, 30, &way));
        CHECK_INT(lw_target_make(30, way.x, way.y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
        lw_family f = { .name = net[which].name, .linkage = &k, .links = 6 };
        lw_families all = lw_families_of(&f, 1);
        o.families = &all;
        o.budget = BUDGET;
        o.jobs = 1;
        o.n_result = 1;
        CHECK_INT(lw_fit_run(&t, &o, &fit, &e), LW_OK);
        CHECK_INT(fit.n, 1);
        if (fit.n > 0) {
            const lw_candidate *c = &fit.candidate[0];
            CHECK(sqrt(c->objective/30) < 0.01*t.size);
            CHECK_INT(lw_fit_report_make(&t, &o.spec, c, r, &e), LW_OK);
            CHECK_TEXT(r->fault, "");
            CHECK(r->verified);
        }
    }
}

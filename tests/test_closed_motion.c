/* tests/test_closed_motion.c - legs of closed curves of postures: against every arc of every assembly, against the
 * curve followed by arc length, which knows no dyads; their ends' derivatives against differences. */
#include "mbs/kinematics/closed_motion.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/batch/batch.h"
#include "mbs/constraints/motion_curve.h"
#include "mbs/kinematics/motion.h"
#include "tests/check.h"
#include "tests/kept_system.h"
#include "tests/mbs_random.h"

/* Joints of pins: Stephenson III driven at the four-bar's rocker, Watt's six-bar, an eight-bar; a four-bar. */
static const pin_net net[] = {
    { NULL, 4, 4, 2, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 } } },
    { NULL, 6, 7, 4, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 2, 4 }, { 4, 5 }, { 5, 0 } } },
    { NULL, 6, 7, 4, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 3, 4 }, { 4, 5 }, { 5, 0 } } },
    { NULL, 6, 7, 4, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 2, 4 }, { 4, 5 }, { 5, 3 } } },
    { NULL, 8, 10, 6, { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 2, 4 }, { 4, 5 }, { 5, 0 }, { 4, 6 }, { 6, 7 },
                        { 7, 1 } } },
};
enum { N_NET = sizeof net/sizeof *net };

typedef struct subject {
    lw_linkage k;
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    void      *batch;
    lw_closed_motion   cycle;
    lw_status  status;
} subject;

static subject *begin(const lw_linkage *k)
{
    subject *s = malloc(sizeof *s);
    s->k = *k;
    CHECK_INT(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &s->plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&s->plan, k, s->dim, s->mode, &s->input, NULL), LW_OK);
    s->batch = aligned_alloc(64, (lw_batch_work_size(&s->plan) + 127) & ~(size_t)63);
    s->status = lw_closed_motion_find(&s->plan, s->dim, s->mode, s->input, s->batch, &s->cycle);
    return s;
}

static void end(subject *s)
{
    free(s->batch);
    free(s);
}

/* ---- against arcs ---------------------------------------------------------------------------------- */

/* The arc that is this leg; -1: there is none. */
static int arc_of_leg(const subject *s, const lw_motion *m, int j, double tolerance)
{
    double a = lw_closed_motion_first(&s->cycle, j), b = s->cycle.leg[j].last, lo = fmin(a, b), hi = fmax(a, b);
    for (int i = 0; i < m->n_arc; i++)
        if (memcmp(m->arc[i].mode, s->cycle.leg[j].mode, sizeof(double)*(size_t)s->plan.n_dyad) == 0
            && fabs(remainder(m->arc[i].first - lo, 2*LW_PI)) < tolerance
            && fabs(m->arc[i].last - m->arc[i].first - (hi - lo)) < tolerance)
            return i;
    return -1;
}

TEST(legs_are_the_arcs_of_a_circuit)
{
    int cycles = 0, turning = 0, stopped = 0, most = 0, other = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 250; trial++) {
        lw_linkage k = random_net(&net[trial % N_NET], &rng);
        subject *s = begin(&k);
        lw_motion *m = malloc(sizeof *m);
        lw_status st = lw_motion_find(&s->plan, s->dim, m);
        int at = lw_motion_arc(&s->plan, m, s->mode, s->input), legs = 0;
        CHECK(at >= 0 && st == LW_OK);
        if (s->status == LW_STOPPED)
            stopped++;
        else if (s->cycle.n == 0) {
            turning++;
            CHECK(m->arc[at].turns);
        } else {
            cycles++;
            most = s->cycle.n > most ? s->cycle.n : most;
            CHECK_INT(s->status, LW_OK);
            for (int i = 0; i < m->n_arc; i++)
                legs += m->arc[i].circuit == m->arc[at].circuit;
            bool same = legs == s->cycle.n;
            for (int j = 0; j < s->cycle.n && same; j++) {
                int arc = arc_of_leg(s, m, j, 1e-9);
                same = arc >= 0 && m->arc[arc].circuit == m->arc[at].circuit && (j > 0 || arc == at);
            }
            other += !same;
        }
        free(m);
        end(s);
    }
    CHECK(cycles > 120 && turning > 10 && most >= 6);
    CHECK(other <= cycles/60);                       /* gaps narrower than a sample                       */
    CHECK(stopped <= 3);
}

/* A four-bar whose crank cannot point away from the other ground pin.  Wherever its motion begins, beside the gap too, the gap is
 * found: the limits are where coupler and rocker are in line. */
TEST(narrow_gaps_are_found_from_everywhere)
{
    lw_rng rng = check_rng(4);
    for (int trial = 0; trial < 300; trial++) {
        double half = pow(10, lw_rng_range(&rng, -2.5, 0)), way = 2*(LW_PI - half), beside = way*pow(10, lw_rng_range(&rng, -6, -0.4));
        double d = lw_rng_range(&rng, 2, 4), line = sqrt(1 + d*d + 2*d*cos(half)), rocker = lw_rng_range(&rng, 0.4, 0.6)*line;
        const double dim[9] = { d, 1, line - rocker, rocker, 0.5, 0.5 };
        lw_linkage k;
        fourbar_linkage(&k, dim, trial % 2 ? 1 : -1, trial % 3 ? LW_PI + half + beside : LW_PI - half - beside);
        subject *s = begin(&k);
        CHECK_INT(s->status, LW_OK);
        CHECK_INT(s->cycle.n, 2);
        for (int j = 0; j < s->cycle.n; j++)
            CHECK_NEAR(fabs(remainder(s->cycle.leg[j].last - LW_PI, 2*LW_PI)), half, 1e-12/half, 0);
        CHECK_NEAR(fabs(s->cycle.leg[0].last - s->cycle.leg[1].last), way, 1e-12/half, 0);
        end(s);
    }
}

/* ---- against the curve followed by arc length -------------------------------------------------------- */

TEST(limits_are_those_of_the_branch)
{
    int compared = 0, other = 0;
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 40; trial++) {
        lw_linkage k = random_net(&net[trial % N_NET], &rng);
        subject *s = begin(&k);
        KEPT_SYSTEM y = { 0 };
        lw_motion_curve *b = NULL;
        if (s->status == LW_OK && s->cycle.n > 0 && lw_system_make(&k, NULL, 0, &y, NULL) == LW_OK
            && lw_motion_curve_create(&y, NULL, &(lw_motion_curve_options){ .input = 0 }, &b, NULL) == LW_OK
            && lw_motion_curve_ended(b) == LW_MOTION_CURVE_CLOSED) {
            int n, limits = 0;
            bool same = true;
            const lw_motion_curve_event *e = lw_motion_curve_events(b, &n);
            for (int i = 0; i < n; i++) {
                if (e[i].kind != LW_EVENT_LIMIT)
                    continue;
                double at = e[i].input - k.input[0].value + s->input;
                same &= fabs(remainder(at - s->cycle.leg[limits % s->cycle.n].last, 2*LW_PI)) < 1e-9;
                limits++;
            }
            same &= limits == s->cycle.n && 2*LW_PI*abs(lw_motion_curve_turns(b, -1)) == fabs(s->cycle.gain);
            other += !same;
            compared++;
        }
        lw_motion_curve_free(b);
        end(s);
    }
    CHECK(compared > 15 && other <= 1);              /* gaps narrower than a sample                       */
}

/* ---- derivatives ------------------------------------------------------------------------------------ */

/* d(end of leg j)/d(dim d), differenced with step h; NAN where the cycle becomes another. */
static double differenced(subject *s, int j, int d, double h)
{
    double at = s->dim[d], end[2];
    for (int side = 0; side < 2; side++) {
        lw_closed_motion c;
        s->dim[d] = side ? at + h : at - h;
        bool same = lw_closed_motion_find(&s->plan, s->dim, s->mode, s->input, s->batch, &c) == LW_OK
            && c.n == s->cycle.n;
        end[side] = same && c.leg[j].dyad == s->cycle.leg[j].dyad ? c.leg[j].last : NAN;
    }
    s->dim[d] = at;
    return (end[1] - end[0])/(2*h);
}

TEST(ends_have_the_derivatives_they_claim)
{
    int checked = 0, rough = 0;
    double *by = malloc(sizeof *by*LW_LEG_MAX*LW_DIM_MAX);
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage k = random_net(&net[trial % N_NET], &rng);
        subject *s = begin(&k);
        int n = s->status == LW_OK ? s->cycle.n : 0;
        if (n > 0)
            lw_closed_motion_slopes(&s->plan, s->dim, &s->cycle, s->batch, by);
        for (int j = 0; j < n; j++)
            for (int d = 0; d < s->plan.n_dim; d++) {
                double fine = differenced(s, j, d, 1e-6), error = fabs(differenced(s, j, d, 2e-6) - fine);
                if (!(error < 1e-3*(1 + fabs(fine)))) {
                    rough++;                         /* next to where legs join or part              */
                    continue;
                }
                CHECK_NEAR(by[j*LW_DIM_MAX + d], fine, 1e-7 + 3*error, 1e-7);
                checked++;
            }
        end(s);
    }
    free(by);
    CHECK(checked > 1000 && rough < checked/20);
}

/* mbs/formulations/analyse.c - the analysis of a model, whichever it is, and how far a run with contacts is from a coarser one. */
#include "base/real.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/formulations/formulations.h"

#include <stdlib.h>
#include <string.h>

static const double longer = 32;             /* tolerance of captured contacts with steps twice as long, which are in proportion to tolerance^(1/5) */
static const double looser = 100;
static const double most_kept = 2e7;         /* coordinates: 160 MB */

/* The postures of a run, and the run compared with them. */
typedef struct comparison {
    lw_dynamics    *d;
    lw_moment_sink *sink;                    /* of the first run */
    void           *context;
    lw_coarse_run  *coarse;
    double         *q;                       /* (n of n_q) */
    size_t          n, stride;               /* samples so far; sample k of the coarse run is k*stride of the other */
} comparison;

static lw_status keep(void *context, const lw_moment *m)
{
    comparison *c = context;
    memcpy(c->q + c->n++*(size_t)c->d->n_q, m->q, (size_t)c->d->n_q*sizeof *m->q);
    return c->sink ? c->sink(c->context, m) : LW_OK;
}

static lw_status compare(void *context, const lw_moment *m)
{
    comparison *c = context;
    lw_coarse_compare(c->d, m->t, c->q + c->n++*c->stride*(size_t)c->d->n_q, m->q, c->coarse);
    return LW_OK;
}

void lw_coarse_compare(const lw_dynamics *d, double t, const double *q, const double *coarse, lw_coarse_run *r)
{
    const lw_system *s = &d->s;
    double most = looser*r->tolerance;
    for (int b = 0; b < s->n_body; b++, q += 3, coarse += 3) {
        double place = s->unit*hypot(coarse[0] - q[0], coarse[1] - q[1]), turn = fabs(coarse[2] - q[2]);
        if (place > r->place)
            r->place = place, r->place_t = t, r->placed = s->link[b];
        if (turn > r->turn)
            r->turn = turn, r->turn_t = t, r->turned = s->link[b];
    }
    r->large = r->large || r->place > most*s->unit || r->turn > most;
}

bool lw_coarse_suits(const lw_dynamics *d)
{
    lw_formulation f = d->choice.formulation;
    return d->o.compare && d->o.until == 0 && d->given && (d->given->n_contact || d->given->n_rope)
        && (f == LW_FORMULATION_CAPTURE || f == LW_FORMULATION_INDEX1);
}

lw_coarse_run lw_coarse_begin(bool captured, lw_dynamics_options *o)
{
    double tolerance = (captured ? longer : looser)*o->relative;
    o->relative *= captured ? 1 : looser;
    o->absolute *= captured ? 1 : looser;
    o->coarse = captured;
    o->compare = false;
    return (lw_coarse_run){ .tolerance = tolerance, .large = captured };
}

/* Rows of the coarse run lie on every stride-th row of the other.  1 if steps twice as long end within an interval; else the smallest divisor above 1. */
static int find_stride(const lw_dynamics_options *o, double step)
{
    int n = o->intervals, stride = 2;
    if (2*step*n <= o->to - o->from)
        return 1;
    while (stride < n && n % stride)
        stride++;
    return stride;
}

/* Repeat the run of c with steps of twice the length if contacts were captured, else with 100 times the tolerance.  A run that ends early is not
 * compared. */
static lw_status run_coarsely(comparison *c, lw_dynamics_report *r, lw_error *e)
{
    bool captured = r->captured_step > 0;
    lw_dynamics_options o = c->d->o;
    lw_dynamics_report report;
    lw_dynamics *d = NULL;
    lw_error why = { 0 };
    int stride = captured ? find_stride(&o, r->captured_step) : 1;
    r->coarse = lw_coarse_begin(captured, &o);
    o.formulation = r->formulation;
    o.intervals /= stride;
    c->n = 0;
    c->stride = (size_t)stride;
    c->coarse = &r->coarse;
    lw_status s = lw_dynamics_make(c->d->given, &o, &d, &why);
    if (s == LW_OK)
        s = lw_dynamics_run(d, compare, c, &report, &why);
    if (s != LW_OK)
        r->coarse = (lw_coarse_run){ 0 };
    lw_dynamics_free(d);
    return s == LW_E_MEMORY ? lw_error_set(e, s, "%s", why.text) : LW_OK;
}

static lw_status run_compared(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e)
{
    comparison c = { .d = d, .sink = sink, .context = context, .q = malloc(((size_t)d->o.intervals + 1)*(size_t)d->n_q*sizeof *c.q) };
    if (!c.q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_dynamics_run(d, keep, &c, r, e);
    if (s == LW_OK)
        s = run_coarsely(&c, r, e);
    free(c.q);
    return s;
}

lw_status lw_dynamics_analyse(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_rest *rest,
                              lw_error *e)
{
    bool little = ((double)d->o.intervals + 1)*d->n_q < most_kept;
    if (d->o.analysis != LW_ANALYSIS_STATIC)
        return little && lw_coarse_suits(d) ? run_compared(d, sink, context, r, e) : lw_dynamics_run(d, sink, context, r, e);
    *r = d->choice;
    double *q = calloc((size_t)d->n_q + 1, sizeof *q);
    lw_status s = q ? lw_statics_rest(d, d->o.from, q, rest, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    r->steps = rest->iterations;
    if (s == LW_OK) {
        s = lw_statics_moment(d, d->o.from, q, sink, context, e);
        r->samples = s == LW_OK || s == LW_OPEN;
        if (s == LW_OPEN)
            s = LW_OK, r->without_forces = 1, r->without_forces_t = d->o.from;
    }
    free(q);
    return s;
}

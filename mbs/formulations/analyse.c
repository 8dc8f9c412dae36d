/* mbs/formulations/analyse.c - the analysis of a model, whichever it is, and how far a run with contacts is from a coarser one. */
#include "base/real.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/formulations/formulations.h"

#include <stdlib.h>
#include <string.h>

/* Captured contacts: no whole number, so that few ends of steps are the same.  Steps are in proportion to tolerance^(1/5). */
static const double longer = 2.8;
static const double looser = 100;            /* tolerance of index1 */
static const double most_apart = 0.1;        /* greatest difference that is allowed, where the tolerance does not set a smaller limit, over the size */
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

static double moved(const double *from, const double *to) { return hypot(to[0] - from[0], to[1] - from[1]); }

void lw_coarse_compare(const lw_dynamics *d, double t, const double *q, const double *coarse, lw_coarse_run *r)
{
    const lw_system *s = &d->s;
    double most = looser*r->tolerance;
    for (int b = 0; b < s->n_body; b++) {
        double place = s->unit*moved(q + 3*b, coarse + 3*b), turn = fabs(coarse[3*b + 2] - q[3*b + 2]);
        if (place > r->place)
            r->place = place, r->place_t = t, r->placed = s->link[b];
        if (turn > r->turn)
            r->turn = turn, r->turn_t = t, r->turned = s->link[b];
        r->apart = fmax(r->apart, place/s->unit);
    }
    for (int i = 0; d->touch && i < d->touch->list.n; i++) {
        const lw_touch *p = &d->touch->list.touch[i];
        for (int k = 0; p->kind != LW_TOUCH_STOP && k < 2; k++)
            if (p->body[k] >= 0) {
                const double *at = q + 3*p->body[k], *to = coarse + 3*p->body[k];
                r->apart = fmax(r->apart, moved(at, to) + fabs(to[2] - at[2])*(lw_v2_norm(p->arm[k]) + p->radius[k]));
            }
    }
    r->large = r->large || r->place > most*s->unit || r->turn > most;
}

bool lw_coarse_suits(const lw_dynamics *d)
{
    lw_formulation f = d->choice.formulation;
    return d->o.compare && d->given && (d->given->n_contact || d->given->n_rope)
        && (f == LW_FORMULATION_CAPTURE || f == LW_FORMULATION_INDEX1);
}

lw_coarse_run lw_coarse_begin(bool captured, lw_dynamics_options *o)
{
    double tolerance = (captured ? pow(longer, 5) : looser)*o->relative;
    o->relative *= captured ? 1 : looser;
    o->absolute *= captured ? 1 : looser;
    o->coarse = captured ? longer : 0;
    o->compare = false;
    return (lw_coarse_run){ .tolerance = tolerance, .large = captured };
}

/* Rows of the coarse run lie on every stride-th row of the other.  1 if its longer steps end within an interval; else a divisor of the intervals. */
static int find_stride(const lw_dynamics_options *o, double step)
{
    int n = o->intervals, stride = 2;
    double interval = (o->to - o->from)/n;
    if (longer*step <= interval)
        return 1;
    stride = (int)fmin(fmax(2, ceil((longer - 1e-6)*step/interval)), n);
    while (stride < n && n % stride)
        stride++;
    return stride;
}

/* Repeat the run of c with longer steps if contacts were captured, else with a looser tolerance. */
static lw_status run_coarsely(comparison *c, lw_dynamics_report *r, lw_error *e)
{
    bool captured = r->captured_step > 0;
    lw_dynamics_options o = c->d->o;
    lw_dynamics_report report = { .t = o.from };
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
        r->coarse.ended = r->coarse.large = true, r->coarse.ended_t = d ? report.t : o.from;
    lw_dynamics_free(d);
    return s == LW_E_MEMORY ? lw_error_set(e, s, "%s", why.text) : LW_OK;
}

/* Bodies move up to tolerance^(1/5) of their size in a captured step.  If two runs differ by more than this part of the size of the linkage and the
 * greatest way of a link from its start, neither is known to be near the motion. */
static lw_status check_coarse(const comparison *c, const lw_coarse_run *r, lw_error *e)
{
    const lw_dynamics *d = c->d;
    double most = fmin(pow(d->o.relative, 0.2), most_apart), size = 1;
    for (int k = 1; k <= d->o.intervals; k++)
        for (int b = 0; b < d->s.n_body; b++)
            size = fmax(size, 1 + moved(c->q + 3*b, c->q + k*d->n_q + 3*b));
    if (!(r->apart > most*size))
        return LW_OK;
    return lw_error_set(e, LW_E_NUMERIC, "the rows are not reliable: a run with a tolerance of %.2g differs by up to %.2g m and %.2g rad, in places by "
                        "%.2g of the size of the linkage and its motion, where tolerance^(1/5) = %.2g is allowed; ask for a smaller tolerance or an "
                        "earlier end", r->tolerance, r->place, r->turn, r->apart/size, most);
}

static lw_status run_compared(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e)
{
    comparison c = { .d = d, .sink = sink, .context = context, .q = malloc(((size_t)d->o.intervals + 1)*(size_t)d->n_q*sizeof *c.q) };
    if (!c.q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_dynamics_run(d, keep, &c, r, e);
    if (s == LW_OK)
        s = run_coarsely(&c, r, e);
    s = s == LW_OK ? check_coarse(&c, &r->coarse, e) : s;
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

#include "cli/motion/coarse_run.h"

#include "base/real.h"

static const double longer = 32;             /* steps of captured contacts are in proportion to tolerance^(1/5): twice as long */
static const double looser = 100;
static const double most_kept = 2e7;         /* coordinates: 160 MB */

typedef struct comparison {
    cli_simulate *s;
    size_t sample, stride;                   /* sample k of the coarse run is k*stride of the other */
} comparison;

static lw_status compare(void *context, const lw_moment *m)
{
    comparison *c = context;
    const lw_system *sys = lw_dynamics_system(c->s->d);
    char (*name)[LW_NAME_SIZE] = lw_dynamics_model(c->s->d)->linkage.link_name;
    const double *q = c->s->q + c->sample*c->stride*(size_t)sys->n_q;
    cli_coarse_run *r = &c->s->coarse;
    for (int b = 0; b < sys->n_body; b++) {
        double place = sys->unit*hypot(m->q[3*b] - q[3*b], m->q[3*b + 1] - q[3*b + 1]), turn = fabs(m->q[3*b + 2] - q[3*b + 2]);
        if (place > r->place)
            r->place = place, r->place_t = m->t, r->placed = name[sys->link[b]];
        if (turn > r->turn)
            r->turn = turn, r->turn_t = m->t, r->turned = name[sys->link[b]];
    }
    c->sample++;
    return LW_OK;
}

bool cli_coarse_run_suits(const cli_simulate *s)
{
    lw_formulation f = lw_dynamics_choice(s->d)->formulation;
    bool little = ((double)s->options.intervals + 1)*lw_dynamics_system(s->d)->n_q < most_kept;
    return little && (s->model->n_contact || s->model->n_rope) && (f == LW_FORMULATION_CAPTURE || f == LW_FORMULATION_INDEX1);
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

lw_status cli_coarse_run_compare(cli_simulate *s, lw_error *e)
{
    cli_coarse_run *r = &s->coarse;
    bool captured = s->report.captured_step > 0;
    const lw_dynamics_options *o = &s->options;
    int stride = captured ? find_stride(o, s->report.captured_step) : 1;
    lw_dynamics_options coarse = *o;
    lw_dynamics_report report;
    lw_dynamics *d = NULL;
    lw_error why = { 0 };
    comparison c = { s, 0, (size_t)stride };
    *r = (cli_coarse_run){ .placed = "no link", .turned = "no link" };
    if (!captured && s->report.n_event_seen == 0)
        return LW_OK;
    coarse.formulation = s->report.formulation;
    coarse.relative = (captured ? longer : looser)*o->relative;
    coarse.absolute = (captured ? longer : looser)*o->absolute;
    coarse.intervals = o->intervals/stride;
    lw_status status = lw_dynamics_make(s->model, &coarse, &d, &why);
    if (status == LW_OK)
        status = lw_dynamics_run(d, compare, &c, &report, &why);
    if (status == LW_OK) {
        double most = looser*coarse.relative;
        r->tolerance = coarse.relative;
        r->told = captured || r->place > most*lw_dynamics_system(s->d)->unit || r->turn > most;
    }
    lw_dynamics_free(d);
    return status == LW_E_MEMORY ? lw_error_set(e, status, "%s", why.text) : LW_OK;
}

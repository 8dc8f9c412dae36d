#include "mbs/clearance/clearance_sweep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/parallel.h"
#include "base/real.h"
#include "mbs/equations/limits_internal.h"

/* ---- laws ---------------------------------------------------------------------------------------- */

/* Make a law: the model with the law in every joint with clearance.  NAN: as the model has it. */
static lw_status make_law(const lw_sweep *c, lw_sweep_law *l, lw_error *e)
{
    size_t size = (size_t)c->m->linkage.n_joint*sizeof *l->m->clearance;
    l->m = malloc(sizeof *l->m);
    l->clearance = malloc(size);
    if (!l->m || !l->clearance)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *l->m = *c->m;
    l->m->clearance = memcpy(l->clearance, c->m->clearance, size);
    bool any = false;
    for (int j = 0; j < l->m->linkage.n_joint; j++) {
        lw_clearance *p = &l->m->clearance[j];
        if (p->model == LW_CLEARANCE_NONE)
            continue;
        p->model = l->model != LW_CLEARANCE_NONE ? l->model : p->model;
        p->stiffness = isnan(l->stiffness) ? p->stiffness : l->stiffness;
        p->damping = isnan(l->damping) ? p->damping : l->damping;
        if (!any) {                                  /* the law is reported by its first joint */
            l->model = p->model;
            l->stiffness = p->stiffness;
            l->damping = p->damping;
        }
        any = true;
    }
    return lw_clearance_make(l->m, &l->scene, e);
}

/* Does a joint of the law feel a stiffness, or a damping?  The losses of the others are those of a restitution. */
static bool feels(const lw_sweep *c, lw_clearance_model model, bool damping)
{
    for (int j = 0; j < c->m->linkage.n_joint; j++) {
        lw_clearance_model own = c->m->clearance[j].model, of = own == LW_CLEARANCE_NONE || model == LW_CLEARANCE_NONE ? own : model;
        if (of == LW_CLEARANCE_MLSD || of == LW_CLEARANCE_IMPACT || (!damping && (of == LW_CLEARANCE_HUNT_CROSSLEY || of == LW_CLEARANCE_LANKARANI)))
            return true;
    }
    return false;
}

/* A law that feels no stiffness or no damping is run once, as the file has it. */
static lw_status make_laws(lw_sweep *c, lw_error *e)
{
    static const double as_given = NAN;
    const lw_sweep_options *o = &c->o;
    const lw_clearance_model own = LW_CLEARANCE_NONE, *model = o->n_model ? o->model : &own;
    const double *stiffness = o->n_stiffness ? o->stiffness : &as_given;
    const double *damping = o->n_damping ? o->damping : &as_given;
    int n_model = o->n_model ? o->n_model : 1, n_stiffness = o->n_stiffness ? o->n_stiffness : 1;
    int n_damping = o->n_damping ? o->n_damping : 1;
    if ((double)n_model*n_stiffness*n_damping*o->n_speed > LW_SWEEP_RUN_MAX)
        return lw_error_set(e, LW_E_ARG, "the lists make more than %d runs", LW_SWEEP_RUN_MAX);
    c->law = calloc((size_t)n_model*(size_t)n_stiffness*(size_t)n_damping, sizeof *c->law);
    if (!c->law)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = LW_OK;
    bool stiff = false, damped = false;
    for (int m = 0; m < n_model; m++) {
        bool feels_stiffness = feels(c, model[m], false), feels_damping = feels(c, model[m], true);
        stiff = stiff || feels_stiffness, damped = damped || feels_damping;
        for (int k = 0; k < (feels_stiffness ? n_stiffness : 1); k++)
            for (int d = 0; s == LW_OK && d < (feels_damping ? n_damping : 1); d++) {
                lw_sweep_law *l = &c->law[c->n_law++];
                *l = (lw_sweep_law){ .model = model[m], .stiffness = feels_stiffness ? stiffness[k] : NAN, .damping = feels_damping ? damping[d] : NAN };
                s = make_law(c, l, e);
            }
    }
    if (s == LW_OK && ((o->n_stiffness && !stiff) || (o->n_damping && !damped)))
        s = lw_error_set(e, LW_E_ARG, o->n_stiffness && !stiff ? "a stiffness of the contact has no effect: models \"zero\" and \"link\" have none"
                         : "a damping of the contact has no effect: only models \"mlsd\" and \"impact\" have one; the losses of \"hunt-crossley\" and "
                           "\"lankarani-nikravesh\" are those of the \"restitution\" in the file");
    return s;
}

lw_status lw_sweep_make(const lw_model *m, const lw_sweep_options *o, lw_sweep *c, lw_error *e)
{
    *c = (lw_sweep){ .m = m, .o = *o };
    lw_status s = make_laws(c, e);
    if (s != LW_OK)
        return s;
    c->n_row = c->n_law*o->n_speed;
    c->row = calloc((size_t)c->n_row + 1, sizeof *c->row);
    c->limit = calloc((size_t)c->n_law*LW_CLEARANCE_JOINT_MAX, sizeof *c->limit);
    if (!c->row || !c->limit)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < c->n_row; i++)
        c->row[i] = (lw_sweep_row){ .law = i/o->n_speed, .speed = o->speed[i%o->n_speed] };
    return LW_OK;
}

void lw_sweep_free(lw_sweep *c)
{
    for (int i = 0; i < c->n_law; i++) {
        lw_clearance_free(c->law[i].scene);
        free(c->law[i].clearance);
        free(c->law[i].m);                           /* a shallow copy: the rest that it points to is the caller's */
    }
    for (int i = 0; c->row && i < c->n_row; i++)
        free(c->row[i].pass);
    free(c->law);
    free(c->row);
    free(c->limit);
}

/* ---- runs ---------------------------------------------------------------------------------------- */

static bool out_of_time(const lw_sweep *c)
{
    return lw_limits_check(c->o.run.stop, c->o.run.until, true, 0, NULL) != LW_OK;
}

typedef struct passer { lw_sweep_row *row; double settle; } passer;

static lw_status keep_pass(void *context, const lw_clearance_sample *s)
{
    passer *p = context;
    lw_sweep_row *r = p->row;
    if (s->t < p->settle || s->n_point == 0)
        return LW_OK;
    if (r->n_pass == r->most_pass) {
        int most = 2*r->most_pass + 16;
        lw_sweep_pass *more = realloc(r->pass, (size_t)most*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        r->pass = more;
        r->most_pass = most;
    }
    const lw_clearance_point *at = &s->point[0];
    double turn = atan2(at->in_bush.y, at->in_bush.x)*180/LW_PI;
    r->pass[r->n_pass++] = (lw_sweep_pass){ turn, at->touching };
    return LW_OK;
}

static void run_row(const lw_sweep *c, lw_sweep_row *row)
{
    lw_clearance_options o = c->o.run;
    passer p = { row, o.settle };
    if (c->o.passes)
        o.strobe = keep_pass, o.context = &p;
    lw_error e = { 0 };
    if (out_of_time(c))
        return;
    o.speed = c->m->motion[0] ? NAN : row->speed*c->o.unit;
    row->status = lw_clearance_run(c->law[row->law].scene, &o, &row->r, &e);
    snprintf(row->why, sizeof row->why, "%.255s", row->status == LW_OK ? "" : e.text);
    row->done = row->status != LW_STOPPED || !out_of_time(c);    /* a run cut short is no result */
}

typedef struct work { lw_sweep *c; int n_done; } work;

static void run_job(void *context, size_t job, int thread)
{
    work *w = context;
    run_row(w->c, &w->c->row[job]);
    int n = __atomic_add_fetch(&w->n_done, 1, __ATOMIC_RELAXED);
    if (thread == 0 && w->c->o.progress)
        w->c->o.progress(w->c->o.context, n, w->c->n_row);
}

static bool is_lost(const lw_sweep_row *r, int joint) { return r->r.joint[joint].lost; }

/* Rows of one law by speed, whichever direction it has */
static int by_speed(const void *a, const void *b)
{
    const lw_sweep_row *const *x = a, *const *y = b;
    double u = fabs((*x)->speed), v = fabs((*y)->speed);
    return (u > v) - (u < v);
}

static void find_limit(const lw_sweep *c, int law, int joint, lw_sweep_row **sorted, lw_sweep_limit *l)
{
    int n = 0;
    for (int i = law*c->o.n_speed; i < (law + 1)*c->o.n_speed; i++)
        if (c->row[i].done && c->row[i].status == LW_OK)
            sorted[n++] = &c->row[i];
    qsort(sorted, (size_t)n, sizeof *sorted, by_speed);
    *l = (lw_sweep_limit){ law, joint, NAN, NAN, NAN, NAN, 0, n };
    for (int i = 0; i < n; i++) {
        bool lost = is_lost(sorted[i], joint), before = i > 0 && is_lost(sorted[i - 1], joint);
        l->n_lost += lost;
        if (i > 0 && lost && !before && isnan(l->lost)) {
            l->kept = sorted[i - 1]->speed;
            l->lost = sorted[i]->speed;
        }
        if (i > 0 && !lost && before) {
            l->lost_again = sorted[i - 1]->speed;
            l->kept_again = sorted[i]->speed;
        }
    }
    if (n > 0 && is_lost(sorted[n - 1], joint))
        l->lost_again = l->kept_again = NAN;         /* contact is lost at the top: no upper limit here */
}

/* Halve the interval between two speeds of which one keeps contact and the other does not. */
static void refine(const lw_sweep *c, int law, int joint, double *kept, double *lost)
{
    lw_sweep_row row = { .law = law };
    while (fabs(*lost - *kept) > c->o.refine && !out_of_time(c)) {
        row.speed = 0.5*(*kept + *lost);
        if (row.speed == *kept || row.speed == *lost)
            break;
        run_row(c, &row);
        if (!row.done || row.status != LW_OK)
            break;
        *(is_lost(&row, joint) ? lost : kept) = row.speed;
    }
    free(row.pass);
}

static void refine_job(void *context, size_t job, int thread)
{
    lw_sweep *c = context;
    lw_sweep_limit *l = &c->limit[job/2];
    (void)thread;
    if (job%2 == 0 && !isnan(l->lost))
        refine(c, l->law, l->joint, &l->kept, &l->lost);
    if (job%2 == 1 && !isnan(l->kept_again))
        refine(c, l->law, l->joint, &l->kept_again, &l->lost_again);
}

lw_status lw_sweep_run(lw_sweep *c, lw_error *e)
{
    int jobs = c->o.jobs;
    work w = { c, 0 };
    lw_status s = lw_parallel(jobs, (size_t)c->n_row, run_job, &w);
    lw_sweep_row **sorted = malloc(sizeof *sorted*(size_t)(c->o.n_speed + 1));
    if (s != LW_OK || !sorted) {
        free(sorted);
        return lw_error_set(e, s != LW_OK ? s : LW_E_MEMORY, "the runs cannot be started: out of memory");
    }
    int n_joint = 0;
    for (int i = 0; i < c->n_row; i++)
        n_joint = c->row[i].done && c->row[i].r.n_joint > n_joint ? c->row[i].r.n_joint : n_joint;
    for (int law = 0; law < c->n_law; law++)
        for (int joint = 0; joint < n_joint; joint++)
            find_limit(c, law, joint, sorted, &c->limit[c->n_limit++]);
    free(sorted);
    return c->o.refine > 0 ? lw_parallel(jobs, 2*(size_t)c->n_limit, refine_job, c) : LW_OK;
}

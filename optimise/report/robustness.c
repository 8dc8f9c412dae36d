#include "optimise/report/robustness.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/rng.h"
#include "base/vector.h"
#include "mbs/batch/batch.h"

enum { TRIALS = 1000 };
#define SIGMA (1/3.0)               /* of the tolerance                                                */

typedef struct spread {
    lw_plan plan;
    size_t  n;
    double  dim[LW_DIM_MAX], mode[LW_MODE_MAX], sigma[LW_DIM_MAX];
    double *c, *s, *x, *y, *margin, *far;      /* of each posture; far: the greatest distance in each trial */
    double *by[3];                             /* derivatives of x, y and the angle       (n_dim*n)      */
    double *by_input[3];                       /* and by the input                                       */
    double  weight[3];                         /* what each of the three counts: their squares are added */
    double  start;                             /* input of the posture of the linkage ...                */
    const double *input;                       /* ... and what each posture adds                 (n)     */
    double  clearance;
    int     n_pin, pin[LW_JOINT_MAX];          /* with clearance                                         */
    double  play[LW_JOINT_MAX][2][LW_DIM_MAX], play_input[LW_JOINT_MAX][2];        /* as lw_plan_read_play */
    void   *work;
} spread;

static void set_deviations(const lw_tolerances *of, spread *p)
{
    double size = lw_plan_size(&p->plan, p->dim);
    for (int d = 0; d < p->plan.n_dim; d++) {
        const lw_dim_info *i = &p->plan.dim[d];
        double length = SIGMA*of->length;
        p->sigma[d] = i->kind == LW_DIM_ANGLE ? length/(size > 0 ? size : 1) : length;
        if (i->role == LW_ROLE_PHASE || i->role == LW_ROLE_MIDDLE)
            p->sigma[d] = 0;                               /* phases of wheels are set when they are mounted */
    }
}

/* What play in each pin does to the dimensions and the input. */
static lw_status read_play(const lw_linkage *linkage, const lw_tolerances *of, spread *p, lw_error *e)
{
    lw_status st = LW_OK;
    p->clearance = of->clearance;
    for (int j = 0; of->clearance > 0 && j < linkage->n_joint && st == LW_OK; j++) {
        double *const by[2] = { p->play[p->n_pin][0], p->play[p->n_pin][1] };
        if (!lw_joint_turns(linkage->joint[j].kind) && !lw_joint_has_slot(linkage->joint[j].kind))
            continue;
        st = lw_plan_read_play(&p->plan, linkage, j, by, p->play_input[p->n_pin], e);
        p->pin[p->n_pin++] = j;
    }
    return st;
}

static void set_inputs(spread *p, double more)
{
    for (size_t i = 0; i < p->n; i++) {
        double at = p->start + p->input[i] + more;
        p->c[i] = p->plan.input_is_slider ? at : cos(at);
        p->s[i] = p->plan.input_is_slider ? 0 : sin(at);
    }
}

static lw_status prepare(const lw_linkage *linkage, const double *input, size_t n, int trials, spread *p, lw_error *e)
{
    double at;
    lw_status st = lw_plan_make(linkage, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_GEARED }, &p->plan, e);
    if (st == LW_OK)
        st = lw_plan_read(&p->plan, linkage, p->dim, p->mode, &at, e);
    if (st != LW_OK)
        return st;
    size_t dims = (size_t)p->plan.n_dim, work = (lw_batch_work_size(&p->plan) + 127) & ~(size_t)63;
    double *m = malloc(sizeof *m*(n*(8 + 3*dims) + (size_t)trials));
    p->n = n;
    p->start = at;
    p->input = input;
    p->c = m;
    p->work = aligned_alloc(64, work);
    if (!m || !p->work)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the tolerances");
    p->s = m + n;
    p->x = m + 2*n;
    p->y = m + 3*n;
    p->margin = m + 4*n;
    for (size_t c = 0; c < 3; c++) {
        p->by_input[c] = m + (5 + c)*n;
        p->by[c] = m + (8 + c*dims)*n;
    }
    p->far = m + (8 + 3*dims)*n;
    set_inputs(p, 0);
    return LW_OK;
}

/* The squares of what a change of place and angle counts, added. */
static double square_of(const spread *p, const double change[3])
{
    double square = 0;
    for (int c = 0; c < 3; c++)
        square += pow(p->weight[c]*change[c], 2);
    return square;
}

/* The variance in posture k for a deviation of dimension d. */
static double variance_of_dimension(const spread *p, int d, size_t k)
{
    const size_t at = (size_t)d*p->n + k;
    return p->sigma[d]*p->sigma[d]*square_of(p, (double[3]){ p->by[0][at], p->by[1][at], p->by[2][at] });
}

/* The variance in posture k for play in pin i of spread.pin. */
static double variance_of_play(const spread *p, int i, size_t k)
{
    double square = 0;
    for (int axis = 0; axis < 2; axis++) {
        double change[3];
        for (int c = 0; c < 3; c++) {
            change[c] = p->play_input[i][axis]*p->by_input[c][k];
            for (int d = 0; d < p->plan.n_dim; d++)
                change[c] += p->play[i][axis][d]*p->by[c][(size_t)d*p->n + k];
        }
        square += square_of(p, change);
    }
    return 0.25*p->clearance*p->clearance*square;
}

static void name_parts(const spread *p, const lw_linkage *linkage, double all, lw_robustness *out)
{
    int dims = p->plan.n_dim;
    out->n_part = dims + p->n_pin;
    for (int i = 0; i < out->n_part; i++) {
        if (i < dims)
            snprintf(out->name[i], sizeof out->name[i], "%s", p->plan.dim[i].name);
        else
            snprintf(out->name[i], sizeof out->name[i], "pin %s", linkage->joint[p->pin[i - dims]].name);
        out->part[i] /= all > 0 ? all : 1;
        if (out->part[i] > out->part[out->first])
            out->first = i;
    }
}

/* Places and derivatives of the linkage itself, and what they say. */
static lw_status linearise(spread *p, const lw_linkage *linkage, lw_robustness *out, lw_error *e)
{
    lw_lanes in = { .n = p->n, .c = p->c, .s = p->s, .dim = p->dim, .mode = p->mode };
    lw_jacobian j = { .x = p->x, .y = p->y, .margin = p->margin, .jx = p->by[0], .jy = p->by[1], .jt = p->by[2], .tx = p->by_input[0],
                      .ty = p->by_input[1], .tt = p->by_input[2], .ld = p->n };
    double *u = malloc(sizeof *u*2*p->n), all = 0;
    if (!u)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the tolerances");
    j.u = u;
    j.v = u + p->n;
    lw_batch_jacobian(&p->plan, &in, 0, p->work, &j);
    free(u);
    for (size_t k = 0; k < p->n; k++) {
        double here = 0;
        if (!(p->margin[k] > 0))
            return lw_error_set(e, LW_OPEN, "the linkage does not close at posture %zu", k + 1);
        for (int d = 0; d < p->plan.n_dim; d++) {
            double part = variance_of_dimension(p, d, k);
            here += part;
            out->part[d] += part;
        }
        for (int i = 0; i < p->n_pin; i++) {
            double part = variance_of_play(p, i, k);
            here += part;
            out->part[p->plan.n_dim + i] += part;
        }
        all += here;
        out->worst = fmax(out->worst, here);
    }
    out->worst = sqrt(out->worst);
    out->rms = sqrt(all/(double)p->n);
    name_parts(p, linkage, all, out);
    return LW_OK;
}

/* Add play in each pin, drawn from its circle, to the dimensions; set the inputs with what it does to them. */
static void draw_play(spread *p, lw_rng *rng, double *dim)
{
    double more = 0;
    for (int i = 0; i < p->n_pin; i++) {
        double far = p->clearance*sqrt(lw_rng_uniform(rng)), angle = 2*LW_PI*lw_rng_uniform(rng);
        double by[2] = { far*cos(angle), far*sin(angle) };
        for (int axis = 0; axis < 2; axis++) {
            more += by[axis]*p->play_input[i][axis];
            for (int d = 0; d < p->plan.n_dim; d++)
                dim[d] += by[axis]*p->play[i][axis][d];
        }
    }
    if (p->n_pin > 0)
        set_inputs(p, more);
}

/* Random linkages.  p->by becomes their places. */
static void draw(spread *p, const lw_tolerances *of, lw_robustness *out)
{
    lw_rng rng;
    double sum = 0, dim[LW_DIM_MAX];
    int n = 0;
    lw_rng_seed(&rng, of->seed, 0x746f6c65u);
    for (int t = 0; t < out->trials; t++) {
        bool closes = true;
        double square = 0, most = 0;
        for (int d = 0; d < p->plan.n_dim; d++)
            dim[d] = p->dim[d] + p->sigma[d]*lw_rng_normal(&rng);
        draw_play(p, &rng, dim);
        for (int d = 0; d < p->plan.n_dim; d++)
            closes &= p->plan.dim[d].kind != LW_DIM_LENGTH || dim[d] > 0;
        lw_lanes in = { .n = p->n, .c = p->c, .s = p->s, .dim = dim, .mode = p->mode };
        lw_batch_point(&p->plan, &in, 0, p->work, p->by[0], p->by[1], NULL, NULL, p->margin);
        for (size_t k = 0; k < p->n; k++) {
            double dx = p->by[0][k] - p->x[k], dy = p->by[1][k] - p->y[k];
            closes &= p->margin[k] >= 0;
            square += dx*dx + dy*dy;
            most = fmax(most, hypot(dx, dy));
        }
        if (!closes)
            continue;
        sum += square/(double)p->n;
        p->far[n++] = most;
    }
    out->open = out->trials - n;
    out->trial_rms = n > 0 ? sqrt(sum/n) : NAN;
    lw_sort((size_t)n, p->far);
    out->within = n > 0 ? p->far[(int)ceil(0.95*n) - 1] : NAN;
}

/* place, angle: what a distance of the point and an angle of its link count to first order. */
static lw_status spread_of(const lw_linkage *linkage, const double *input, size_t n, const lw_tolerances *of, double place, double angle,
                           int trials, lw_robustness *out, lw_error *e)
{
    memset(out, 0, sizeof *out);
    out->trials = trials;
    if (n == 0 || !(of->length >= 0 && of->clearance >= 0) || linkage->n_tracer == 0)
        return lw_error_set(e, LW_E_ARG, "tolerances need a point, postures, and lengths that are not negative");
    spread *p = calloc(1, sizeof *p);
    if (!p)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the tolerances");
    lw_status st = prepare(linkage, input, n, out->trials, p, e);
    if (st == LW_OK) {
        p->weight[0] = p->weight[1] = place;
        p->weight[2] = angle;
        set_deviations(of, p);
        st = read_play(linkage, of, p, e);
    }
    if (st == LW_OK)
        st = linearise(p, linkage, out, e);
    if (st == LW_OK && trials > 0)
        draw(p, of, out);
    free(p->work);
    free(p->c);
    free(p);
    return st;
}

lw_status lw_robustness_make(const lw_linkage *linkage, const double *input, size_t n, const lw_tolerances *of,
                             lw_robustness *out, lw_error *e)
{
    return spread_of(linkage, input, n, of, 1, 0, of->trials > 0 ? of->trials : TRIALS, out, e);
}

enum { POSTURES = 64 };

/* Inputs of a result over the turn or between its stations, from that of its posture on. */
static lw_status postures_of(const lw_target *t, const lw_candidate *c, const lw_fit_report *r, double input[POSTURES], lw_error *e)
{
    double lo, hi;
    size_t dyads = (size_t)c->n_dyad;
    for (size_t i = dyads; c->mode_of && i < t->n*dyads; i++)
        if (c->mode_of[i] != c->mode_of[i - dyads])
            return lw_error_set(e, LW_E_KIND, "its motion passes a limit of the input, where the point's place has no "
                                "derivative by the dimensions");
    lw_fit_report_range(t, c, &lo, &hi);
    for (int i = 0; i < POSTURES; i++)
        input[i] = r->turns ? 2*LW_PI*i/POSTURES : lo - c->input[0] + (hi - lo)*i/(POSTURES - 1);
    return LW_OK;
}

lw_status lw_robustness_of(const lw_target *t, const lw_candidate *c, const lw_fit_report *r, const lw_tolerances *of,
                           lw_robustness *out, lw_error *e)
{
    double input[POSTURES];
    memset(out, 0, sizeof *out);
    lw_status st = postures_of(t, c, r, input, e);
    return st == LW_OK ? lw_robustness_make(&r->linkage, input, POSTURES, of, out, e) : st;
}

lw_status lw_robustness_deviation(const lw_target *t, const lw_candidate *c, const lw_fit_report *r, const lw_tolerances *of, double *out)
{
    const bool function = !(t->extent > 0);
    double input[POSTURES];
    lw_robustness one;
    lw_status st = postures_of(t, c, r, input, NULL);
    if (st == LW_OK)
        st = spread_of(&r->linkage, input, POSTURES, of, function ? 0 : 1, function ? 1 : t->theta ? 0.5*t->extent : 0, 0, &one, NULL);
    *out = st == LW_OK ? one.worst : NAN;
    return st;
}

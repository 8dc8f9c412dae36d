/* cli/motion/simulate_linear.c - print modes as tables. */
#include "cli/motion/simulate_linear.h"

#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/real.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "mbs/analysis/modes_fft.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"

typedef struct linear {
    const cli_call   *call;
    const lw_model   *m;                 /* whose links the modes are of: nodes of elastic ones too */
    lw_model         *given;
    lw_spatial       *space;             /* a spatial model instead; NULL: a planar one */
    const cli_linear *o;
    lw_dynamics *d;                      /* large models and elastic links; NULL: others */
    lw_system own_s;
    lw_forces own_f;
    const lw_system *s;
    const lw_forces *f;
    lw_modes  modes;
    double   *q, peak[2*LW_SYSTEM_Q_MAX];
    FILE     *out;
    cli_json  j;
    int       n_posture, n_heard;
    double    worst;                     /* greatest relative difference between a peak and its eigenfrequency */
} linear;

/* ---- writing ------------------------------------------------------------------------------------- */

static void head(linear *l)
{
    if (l->call->common.json) {
        l->j = cli_json_begin(l->out, 2);
        cli_json_object(&l->j, NULL);
        cli_json_text(&l->j, "command", l->call->line);
        cli_json_array(&l->j, "postures");
        return;
    }
    fprintf(l->out, "# %s\n# frequencies [Hz], eigenvalue re + i im [1/s], input [rad or m; empty: none], unbalanced: force left over in "
            "shares of the greatest\nposture,input,mode,frequency,natural,damping,re,im,unbalanced%s\n", l->call->line,
            l->o->fft ? ",heard" : "");
}

static void tail(linear *l)
{
    if (!l->call->common.json)
        return;
    cli_json_end(&l->j);
    cli_json_end(&l->j);
}

/* The same of a spatial model: displacement of the centre in ground axes [m], turn about the principal axes [rad]. */
static void write_space_shape(linear *l, const lw_mode *m)
{
    const lw_space *s = lw_dynamics_space(l->d);
    cli_json_array(&l->j, "shape");
    for (int b = 0; b < s->n_body; b++) {
        double v[12];
        for (int i = 0; i < 6; i++) {
            v[i] = m->shape[6*b + i]*(i < 3 ? s->unit : 1.0);
            v[6 + i] = m->phase[6*b + i];
        }
        cli_json_object(&l->j, NULL);
        cli_json_text(&l->j, "link", s->model->body[s->link_of[b]].name);
        cli_json_reals(&l->j, "x_y_z_turns", v, 6);
        cli_json_reals(&l->j, "phase", v + 6, 6);
        cli_json_end(&l->j);
    }
    cli_json_end(&l->j);
}

/* Write each link's displacement [m] and rotation [rad] in the mode shape. */
static void write_shape(linear *l, const lw_mode *m)
{
    cli_json_array(&l->j, "shape");
    for (int b = 0; b < l->s->n_body; b++) {
        double v[6];
        for (int i = 0; i < 3; i++) {
            v[i] = m->shape[3*b + i]*(i < 2 ? l->s->unit : 1.0);
            v[3 + i] = m->phase[3*b + i];
        }
        cli_json_object(&l->j, NULL);
        cli_json_text(&l->j, "link", l->m->linkage.link_name[l->s->link[b]]);
        cli_json_reals(&l->j, "x_y_turn", v, 3);
        cli_json_reals(&l->j, "phase", v + 3, 3);
        cli_json_end(&l->j);
    }
    cli_json_end(&l->j);
}

static void write_mode(linear *l, int k, double input)
{
    const lw_mode *m = &l->modes.mode[k];
    if (!l->call->common.json) {
        fprintf(l->out, "%d,", l->n_posture);
        if (isfinite(input))
            fprintf(l->out, "%.12g", input);
        fprintf(l->out, ",%d,%.12g,%.12g,%.12g,%.12g,%.12g,%.3g", k + 1, m->frequency, m->natural, m->damping, m->re, m->im,
                l->modes.unbalanced);
        if (l->o->fft && isfinite(l->peak[k]))
            fprintf(l->out, ",%.9g", l->peak[k]);
        else if (l->o->fft)
            fputc(',', l->out);
        fputc('\n', l->out);
        return;
    }
    cli_json_object(&l->j, NULL);
    cli_json_real(&l->j, "frequency", m->frequency);
    cli_json_real(&l->j, "natural", m->natural);
    cli_json_real(&l->j, "damping", m->damping);
    cli_json_reals(&l->j, "eigenvalue", (double[]){ m->re, m->im }, 2);
    if (l->o->fft)
        cli_json_real(&l->j, "heard", l->peak[k]);
    if (l->space)
        write_space_shape(l, m);
    else
        write_shape(l, m);
    cli_json_end(&l->j);
}

/* Value of the first input in the posture [rad or m]; NaN: the model has none.  LW_E_MEMORY. */
static lw_status find_input(const linear *l, double *input, lw_error *e)
{
    *input = NAN;
    if (l->space && l->space->n_input > 0) {
        const lw_space *s = lw_dynamics_space(l->d);
        const lw_spatial_input *in = &l->space->input[0];
        lw_space_frame *frame = malloc(((size_t)s->n_body + 1)*sizeof *frame);
        if (!frame)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        lw_space_place(s, l->q, frame);
        *input = lw_space_scale(s, in->measure)*lw_space_measure(s, frame, in->measure, 0, NULL) + lw_spatial_offset(in);
        free(frame);
    } else if (!l->space && l->s->n_input > 0) {
        int j = l->s->input_joint[0];
        *input = l->s->input_value[0] + lw_system_joint_unit(l->s, j)*lw_system_measure(l->s, j, l->q, NULL);
    }
    return LW_OK;
}

static void write_posture(linear *l, double input)
{
    l->n_posture++;
    if (l->call->common.json) {
        cli_json_object(&l->j, NULL);
        cli_json_real(&l->j, "input", input);
        cli_json_real(&l->j, "unbalanced", l->modes.unbalanced);
        cli_json_int(&l->j, "freedom", l->modes.freedom);
        cli_json_int(&l->j, "redundant", l->modes.redundant);
        cli_json_array(&l->j, "modes");
    }
    for (int k = 0; k < l->modes.n_mode; k++)
        write_mode(l, k, input);
    if (l->call->common.json) {
        cli_json_end(&l->j);
        cli_json_end(&l->j);
    }
}

/* ---- working ------------------------------------------------------------------------------------- */

static void compare(linear *l)
{
    for (int k = 0; k < l->modes.n_mode; k++)
        if (isfinite(l->peak[k])) {
            l->n_heard++;
            l->worst = fmax(l->worst, fabs(l->peak[k]/l->modes.mode[k].frequency - 1.0));
        }
}

/* The mode that grows fastest; NULL: no mode grows. */
static const lw_mode *growing(const lw_modes *m)
{
    const lw_mode *most = NULL;
    for (int k = 0; k < m->n_mode; k++)
        if (m->mode[k].re > 1e-9*(fabs(m->mode[k].im) + fabs(m->mode[m->n_mode - 1].natural)) && (!most || m->mode[k].re > most->re))
            most = &m->mode[k];
    return most;
}

/* The model made ready, at time t, for equilibrium and modes. */
static lw_status make_ready(const linear *l, lw_dynamics **d, lw_error *e)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    o.from = l->o->t;
    o.stop = cli_stop_flag();
    o.hold_inputs = l->o->hold;
    o.rigid = l->o->rigid;
    return l->space ? lw_dynamics_make_spatial(l->space, &o, d, e) : lw_dynamics_make(l->given, &o, d, e);
}

static lw_status listen(linear *l, lw_error *e)
{
    lw_dynamics *d = NULL;
    lw_status s = make_ready(l, &d, e);
    if (s == LW_OK)
        s = lw_modes_from_spectra(d, l->q, &l->modes, l->peak, e);
    lw_dynamics_free(d);
    return s;
}

static lw_status one(linear *l, bool rest, lw_error *e)
{
    lw_modes_options o = { .hold_inputs = l->o->hold, .rest = rest };
    lw_modes_free(&l->modes);
    lw_status s = l->d ? lw_modes_find_large(l->d, &o, l->o->modes, l->o->t, l->q, &l->modes, e)
                : lw_modes_find(l->f, &o, l->o->t, l->q, &l->modes, e);
    if (s != LW_OK)
        return s;
    if (l->space && l->modes.unbalanced > 1e-6)
        return lw_error_set(e, LW_E_ARG, "the posture is no equilibrium: %.3g of the greatest force is left over; modes in space are "
                            "those of an equilibrium: --rest goes to one", l->modes.unbalanced);
    if (l->o->fft && (s = listen(l, e)) < 0)
        return s;
    if (l->o->fft)
        compare(l);
    double input;
    if ((s = find_input(l, &input, e)) == LW_OK)
        write_posture(l, input);
    return s;
}

/* Make a large model or one with elastic links ready, at its posture. */
static lw_status open_large(linear *l, lw_error *e)
{
    lw_dynamics_free(l->d);
    l->d = NULL;
    lw_status s = make_ready(l, &l->d, e);
    if (s != LW_OK)
        return s;
    const char *massless = lw_dynamics_massless(l->d);
    if (massless)
        return lw_error_set(e, LW_E_ARG, "link \"%s\" has no mass, or no inertia about an axis, so its motion has no frequency: give it a \"mass\" "
                            "and an \"inertia\"", massless);
    l->s = lw_dynamics_system(l->d);
    l->f = lw_dynamics_forces(l->d);
    l->m = lw_dynamics_model(l->d);
    size_t n = (size_t)(l->space ? lw_dynamics_space(l->d)->n_q : l->s->n_q);
    free(l->q);
    l->q = calloc(2*n, sizeof *l->q);
    if (!l->q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_dynamics_start(l->d, l->q, l->q + n);
    return LW_OK;
}

static lw_status open_small(linear *l, lw_error *e)
{
    lw_status s = lw_forces_system(l->m, false, &l->own_s, e);
    if (s == LW_OK)
        s = lw_forces_make(l->m, &l->own_s, NULL, &l->own_f, e);
    l->s = &l->own_s;
    l->f = &l->own_f;
    if (s == LW_OK && !(l->q = calloc((size_t)l->own_s.n_q + 1, sizeof *l->q)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        lw_system_posture(l->s, l->q);
    return s;
}

/* Move input 0 from end to end. Links held by springs find their rest position with the inputs fixed. */
static lw_status along(linear *l, lw_error *e)
{
    const lw_input *in = &l->m->linkage.input[0];
    if (l->s->n_input == 0)
        return lw_error_set(e, LW_E_ARG, "modes along the motion need an input, and the model has none");
    bool pin = lw_joint_turns(l->s->joint[l->s->input_joint[0]].kind), whole = in->first == in->last;
    if (whole && !pin)
        return lw_error_set(e, LW_E_ARG, "modes along the motion of a slider need its range: give the input a \"from\" and a \"to\"");
    double first = whole ? in->value : in->first, last = whole ? in->value + 2*LW_PI : in->last;
    lw_status s = LW_OK;
    for (int k = 0; s == LW_OK && k <= l->o->along && !cli_interrupted(); k++) {
        if (l->d) {                                        /* elastic: the input is held at each place */
            char value[40];
            snprintf(value, sizeof value, "%.17g", first + (last - first)*k/l->o->along);
            s = lw_model_drive(l->given, 0, value, e);
            s = s == LW_OK ? open_large(l, e) : s;
            s = s == LW_OK ? one(l, l->o->rest, e) : s;
            continue;
        }
        s = lw_modes_move_input(l->f, l->o->t, 0, first + (last - first)*k/l->o->along, l->q, e);
        if (s == LW_OK && l->o->rest) {
            lw_modes_free(&l->modes);
            lw_status st = lw_modes_find(l->f, &(lw_modes_options){ .hold_inputs = true, .rest = true }, l->o->t, l->q, &l->modes, e);
            s = st == LW_NOTHING ? LW_OK : st;
        }
        if (s == LW_OK)
            s = one(l, false, e);
    }
    return s;
}

/* Does a value that depends on time alone change at t?  x NULL: no. */
static bool changes(const lw_expression *x, double t)
{
    const double at[2] = { t, 1 };
    double rate[2] = { 0, 0 };
    if (x)
        lw_expression_series(x, 1, at, rate);
    return rate[1] != 0;
}

static bool inputs_move(const linear *l)
{
    for (int i = 0; l->space && i < l->space->n_input; i++)
        if (changes(l->space->input[i].motion, l->o->t) || (l->space->input[i].has_speed && l->space->input[i].speed != 0))
            return true;
    for (int i = 0; !l->space && i < l->given->linkage.n_input; i++)
        if (changes(l->given->motion[i], l->o->t) || (l->given->has_speed[i] && l->given->speed[i] != 0))
            return true;
    return false;
}

/* Say which modes are beyond the frequency for which elements were chosen. */
static void note_elements(const linear *l)
{
    const lw_spatial_expansion *space = lw_dynamics_spatial_elastic(l->d);
    const lw_elastic_expansion *plane = lw_dynamics_elastic(l->d);
    double least = INFINITY;
    int above = 0, n = space ? space->n_chain : plane ? plane->n_chain : 0;
    for (int k = 0; k < n; k++) {
        const lw_elastic_chain *c = space ? &space->chain[k] : &plane->chain[k];
        least = c->frequency > 0 && !c->condensed ? fmin(least, c->frequency) : least;
    }
    for (int k = 0; k < l->modes.n_mode; k++)
        above += l->modes.mode[k].natural > 1.001*least;
    if (above > 0)
        cli_note(l->call, "%d mode%s above %.4g Hz, up to which the elements of elastic links were chosen for errors below 1 %%; faster modes have greater ones: "
                 "give the links the \"frequency\" [Hz] up to which modes matter", above, above == 1 ? " is" : "s are", least);
}

static void free_linear(linear *l)
{
    lw_forces_free(&l->own_f);
    lw_system_free(&l->own_s);
    lw_dynamics_free(l->d);
    lw_modes_free(&l->modes);
    free(l->q);
    free(l);
}

int cli_simulate_linear(const cli_call *call, lw_model *m, lw_spatial *space, const cli_linear *o)
{
    lw_error e = { 0 };
    lw_output out;
    linear *l = calloc(1, sizeof *l);
    if (!l) {
        lw_error_set(&e, LW_E_MEMORY, "out of memory");
        return cli_fail(call, &e);
    }
    l->call = call, l->m = l->given = m, l->space = space, l->o = o;
    const lw_linkage *small;
    bool large = space || m->n_elastic || lw_model_small(m, &small, NULL) != LW_OK;
    if (o->fft && !o->rigid && (space ? space->n_elastic : m->n_elastic))
        lw_error_set(&e, LW_E_KIND, "--fft is for rigid links: motion in time knows lumped masses of elastic ones only, and these have "
                     "other frequencies (--rigid leaves elasticity out)");
    if (e.status != LW_OK || (large ? open_large(l, &e) : open_small(l, &e)) != LW_OK || cli_open(call, &out, &e) != LW_OK) {
        free_linear(l);
        return cli_fail(call, &e);
    }
    l->out = out.f;
    head(l);
    lw_status s = o->along > 0 ? along(l, &e) : one(l, o->rest, &e);
    tail(l);
    if (s == LW_OK && l->modes.cut)
        cli_note(call, "some loads have no potential: modes faster than the first %d are not found to 1e-6, and are left out", l->modes.n_mode);
    if (s == LW_OK && l->d)
        note_elements(l);
    if (s == LW_OK && !o->rest && !o->along && l->modes.unbalanced > 1e-9)
        cli_note(call, "the posture is no equilibrium: %.3g of the greatest force is left over; --rest goes to one", l->modes.unbalanced);
    if (s == LW_OK && !o->along && inputs_move(l))
        cli_note(call, "inputs move at t = %g s, but the modes are those at rest: without centrifugal and gyroscopic forces, which a run in "
                 "time has", o->t);
    bool still = s == LW_OK && !o->along && (o->rest || l->modes.unbalanced <= 1e-9);
    const lw_mode *grows = still ? growing(&l->modes) : NULL;
    if (grows)
        cli_note(call, "the equilibrium is not stable: a mode grows %.3g times in a second", exp(grows->re));
    if (s == LW_OK && o->fft && l->n_heard == 0)
        cli_note(call, "no mode vibrates long enough to be heard");
    else if (s == LW_OK && o->fft)
        cli_note(call, "%d peak%s of the free vibration: within %.2g %% of the eigenfrequencies", l->n_heard,
                 lw_plural(l->n_heard), 100*l->worst);
    int code = s == LW_OK ? CLI_DONE : cli_fail(call, &e);
    free_linear(l);
    return cli_close(call, &out, code);
}

/* cli/motion/simulate_elastic.c - what --explain says of elastic links: their elements, and the rules by which Makkonen (1999)
 * decides how to analyse them. */
#include "base/real.h"
#include "cli/motion/simulate.h"
#include "mbs/dynamics/modes.h"

#include <stdlib.h>
#include "cli/program/output.h"

/* The lowest frequency about the posture with the inputs held [Hz]; 0: not found. */
static double first_frequency(const cli_simulate *s)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    lw_modes modes = { 0 };
    lw_error e = { 0 };
    double found = 0;
    o.analysis = LW_ANALYSIS_STATIC;
    o.hold_inputs = true;
    if (lw_dynamics_make(s->model, &o, &d, &e) != LW_OK)
        return 0;
    size_t n = (size_t)lw_dynamics_system(d)->n_q;
    double *q = calloc(2*n, sizeof *q);
    if (q) {
        lw_dynamics_start(d, q, q + n);
        if (lw_modes_find_large(d, &(lw_modes_options){ 0 }, 1, 0, q, &modes, &e) == LW_OK && modes.n_mode > 0)
            found = modes.mode[0].frequency;
    }
    lw_modes_free(&modes);
    lw_dynamics_free(d);
    free(q);
    return found;
}

/* The greatest speed of an input over the run, of turning ones [rad/s]; 0: none turns. */
static double drive_speed(const cli_simulate *s, double from, double to)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    const lw_model *m = lw_dynamics_model(s->d);
    double most = 0, at[3];
    for (int i = 0; i < sys->n_input; i++) {
        if (!lw_joint_turns(sys->joint[sys->input_joint[i]].kind))
            continue;
        if (m->has_speed[i])
            most = fmax(most, fabs(m->speed[i]));
        for (int k = 0; m->motion[i] && k <= 200; k++)
            if (lw_input_motion(m, sys, i, from + (to - from)*k/200, at) == LW_OK)
                most = fmax(most, fabs(at[1]));
    }
    return most;
}

void cli_explain_chain(const cli_call *call, const char *name, const lw_elastic_chain *k)
{
    if (k->frequency > 0)
        cli_note(call, "elastic link \"%s\": %.4g m, %.4g kg; %d elements, for errors below 1 %% of frequencies up to %.4g Hz; "
                 "first bending frequency with hinged ends %.4g Hz", name, k->length, k->mass, k->n_node - 1, k->frequency, k->first);
    else
        cli_note(call, "elastic link \"%s\": %.4g m, %.4g kg; %d elements; first bending frequency with hinged ends %.4g Hz",
                 name, k->length, k->mass, k->n_node - 1, k->first);
}

void cli_simulate_explain_elastic(const cli_simulate *s, double from, double to)
{
    enum { HIGHER = 4, SAMPLES = 10 };           /* N and S of eq. 21 */
    const lw_elastic_expansion *x = lw_dynamics_elastic(s->d);
    const cli_call *call = s->call;
    double pass = INFINITY;
    for (int c = 0; x && c < x->n_chain; c++) {
        const lw_elastic_chain *k = &x->chain[c];
        const lw_material *m = &k->elastic->material;
        double h = INFINITY;
        for (int i = 0; i + 1 < k->n_node; i++)
            h = fmin(h, x->model.beam[k->first_beam + i].length);
        pass = fmin(pass, h/sqrt(m->e/m->density));
        cli_explain_chain(call, s->model->linkage.link_name[k->link], k);
    }
    if (!x)
        return;
    double first = first_frequency(s), drive = drive_speed(s, from, to), ratio = drive > 0 ? 2*LW_PI*first/drive : 0;
    if (first > 0)
        cli_note(call, "first frequency in the posture of the file, inputs held: %.4g Hz", first);
    if (ratio > 0)
        cli_note(call, "that is %.3g times the greatest speed of the drive, %.4g rad/s: %s (rule of Sanders and Tesar: 20 times)",
                 ratio, drive, ratio > 20 ? "vibrations are small, a quasi-static run (--analysis quasistatic) or rigid links (--rigid) are enough"
                 : "vibrations matter, run the model in time");
    if (drive > 0)
        cli_note(call, "longest step to see %d harmonics with %d samples each: %.3g s (Makkonen 1999, eq. 21)", HIGHER, SAMPLES,
                 2*LW_PI/(20*HIGHER*SAMPLES*drive));
    cli_note(call, "a shock wave passes the shortest element in %.3g s, the longest step for impacts (eq. 22)", pass);
}

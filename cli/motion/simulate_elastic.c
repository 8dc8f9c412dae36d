/* cli/motion/simulate_elastic.c - what --explain says of elastic links: their elements, and the rules by which Makkonen (1999)
 * decides how to analyse them. */
#include "base/real.h"
#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "mbs/dynamics/modes.h"

#include <stdlib.h>
#include "cli/program/output.h"

/* The lowest frequency of d, made for a static analysis, about its start [Hz]; 0: not found.  Frees d. */
static double first_frequency(lw_dynamics *d, int n_q)
{
    lw_modes modes = { 0 };
    lw_error e = { 0 };
    double found = 0, *q = calloc(2*(size_t)n_q, sizeof *q);
    if (q) {
        lw_dynamics_start(d, q, q + n_q);
        if (lw_modes_find_large(d, &(lw_modes_options){ 0 }, 1, 0, q, &modes, &e) == LW_OK && modes.n_mode > 0)
            found = modes.mode[0].frequency;
    }
    lw_modes_free(&modes);
    lw_dynamics_free(d);
    free(q);
    return found;
}

static lw_dynamics_options held(void)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = LW_ANALYSIS_STATIC;
    o.hold_inputs = true;
    return o;
}

static void explain_chain(const cli_call *call, const char *name, const lw_elastic_chain *k)
{
    if (k->condensed)
        cli_note(call, "elastic link \"%s\": %.4g kg; superelements between %d nodes%s, which move with their whole mass matrix; tension does not "
                 "stiffen a piece, so each is to turn slowly beside its first frequency", name, k->mass, k->n_bound,
                 k->elastic->modes ? ", with modes" : "");
    else if (k->frequency > 0)
        cli_note(call, "elastic link \"%s\": %.4g m, %.4g kg; %d elements, for errors below 1 %% of frequencies up to %.4g Hz; "
                 "first bending frequency with hinged ends %.4g Hz", name, k->length, k->mass, k->n_node - 1, k->frequency, k->first);
    else
        cli_note(call, "elastic link \"%s\": %.4g m, %.4g kg; %d elements; first bending frequency with hinged ends %.4g Hz",
                 name, k->length, k->mass, k->n_node - 1, k->first);
}

/* first: the lowest frequency [Hz]; drive: the angular frequency of the inputs [rad/s]; pass: the shortest time in which a
 * wave passes an element [s]. */
static void explain_rules(const cli_call *call, double first, double drive, double pass)
{
    enum { HIGHER = 4, SAMPLES = 10 };           /* N and S of eq. 21 */
    double ratio = drive > 0 ? 2*LW_PI*first/drive : 0;
    if (first > 0)
        cli_note(call, "first frequency in the posture of the file, inputs held: %.4g Hz", first);
    if (ratio > 0)
        cli_note(call, "that is %.3g times the frequency of the drive, %.4g rad/s (its speed, or acceleration over speed): %s (rule of Sanders and Tesar: 20 times)",
                 ratio, drive, ratio > 20 ? "vibrations are small, a quasi-static run (--analysis quasistatic) or rigid links (--rigid) are enough"
                 : "vibrations matter, run the model in time");
    if (drive > 0)
        cli_note(call, "longest step to see %d harmonics with %d samples each: %.3g s (Makkonen 1999, eq. 21)", HIGHER, SAMPLES,
                 2*LW_PI/(20*HIGHER*SAMPLES*drive));
    if (isfinite(pass))
        cli_note(call, "a shock wave passes the shortest element in %.3g s, the longest step for impacts (eq. 22)", pass);
}

/* Time in which a wave passes an element of a link. */
static double passing(const lw_elastic_chain *k, double length)
{
    return length/sqrt(k->elastic->material.e/k->elastic->material.density);
}

void cli_explain_elastic(const cli_call *call, const lw_model *m, const lw_dynamics *solved, double from, double to)
{
    const lw_elastic_expansion *x = lw_dynamics_elastic(solved);
    double pass = INFINITY, drive = 0;
    lw_dynamics *d;
    for (int c = 0; x && c < x->n_chain; c++) {
        const lw_elastic_chain *k = &x->chain[c];
        for (int i = 0; i + 1 < k->n_node && !k->condensed; i++)
            pass = fmin(pass, passing(k, x->model.beam[k->first_beam + i].length));
        explain_chain(call, m->linkage.link_name[k->link], k);
    }
    if (!x)
        return;
    for (int i = 0; i < m->linkage.n_input; i++)
        drive = fmax(drive, lw_motion_frequency(m->motion[i], lw_joint_turns(m->linkage.joint[m->linkage.input[i].joint].kind),
                                                m->has_speed[i] ? m->speed[i] : 0, from, to));
    lw_dynamics_options o = held();
    double first = lw_dynamics_make(m, &o, &d, NULL) == LW_OK ? first_frequency(d, lw_dynamics_system(d)->n_q) : 0;
    explain_rules(call, first, drive, pass);
}

void cli_explain_elastic_spatial(const cli_call *call, const lw_spatial *m, const lw_dynamics *solved, double from, double to)
{
    const lw_spatial_expansion *x = lw_dynamics_spatial_elastic(solved);
    double pass = INFINITY, drive = 0;
    lw_dynamics *d;
    for (int c = 0; x && c < x->n_chain; c++) {
        const lw_elastic_chain *k = &x->chain[c];
        for (int i = 0; i + 1 < k->n_node && !k->condensed; i++)
            pass = fmin(pass, passing(k, x->model.beam[k->first_beam + i].length));
        explain_chain(call, m->body[k->link].name, k);
    }
    if (!x || x->n_chain == 0)
        return;
    for (int i = 0; i < m->n_input; i++)
        drive = fmax(drive, lw_motion_frequency(m->input[i].motion, m->input[i].measure.of == LW_OF_TURN,
                                                m->input[i].has_speed ? m->input[i].speed : 0, from, to));
    lw_dynamics_options o = held();
    double first = lw_dynamics_make_spatial(m, &o, &d, NULL) == LW_OK ? first_frequency(d, lw_dynamics_space(d)->n_q) : 0;
    explain_rules(call, first, drive, pass);
}

#include "base/real.h"
#include "mbs/analysis/elastic_rules.h"

#include <stdlib.h>
#include "mbs/equilibrium/modes.h"
#include "mbs/formulations/formulations.h"

/* d: made for a static analysis with its inputs held; freed here. */
static double first_frequency(lw_dynamics *d, int n_q)
{
    lw_modes modes = { 0 };
    double found = 0, *q = calloc(2*(size_t)n_q, sizeof *q);
    if (q) {
        lw_dynamics_start(d, q, q + n_q);
        if (lw_modes_find_large(d, &(lw_modes_options){ 0 }, 1, 0, q, &modes, NULL) == LW_OK && modes.n_mode > 0)
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

/* Time in which a wave passes an element of a link. */
static double passing(const lw_elastic_chain *k, double length)
{
    return length/sqrt(k->elastic->material.e/k->elastic->material.density);
}

static lw_elastic_rules rules(double first, double drive, double wave)
{
    double ratio = drive > 0 ? 2*LW_PI*first/drive : 0;
    return (lw_elastic_rules){ first, drive, ratio, ratio > 20,
                               drive > 0 ? 2*LW_PI/(20*LW_RULE_HARMONICS*LW_RULE_SAMPLES*drive) : INFINITY, wave };
}

lw_elastic_rules lw_elastic_rules_find(const lw_model *m, const lw_dynamics *solved, double from, double to)
{
    const lw_elastic_expansion *x = lw_dynamics_elastic(solved);
    const lw_dynamics_options o = held();
    lw_dynamics *d;
    double drive = 0, wave = INFINITY;
    for (const lw_elastic_chain *k = x->chain; k < x->chain + x->n_chain; k++)
        for (int i = 0; i + 1 < k->n_node && !k->condensed; i++)
            wave = fmin(wave, passing(k, x->model.beam[k->first_beam + i].length));
    for (int i = 0; i < m->linkage.n_input; i++)
        drive = fmax(drive, lw_motion_frequency(m->motion[i], lw_joint_turns(m->linkage.joint[m->linkage.input[i].joint].kind),
                                                m->has_speed[i] ? m->speed[i] : 0, from, to));
    return rules(lw_dynamics_make(m, &o, &d, NULL) == LW_OK ? first_frequency(d, lw_dynamics_system(d)->n_q) : 0, drive, wave);
}

lw_elastic_rules lw_elastic_rules_find_spatial(const lw_spatial *m, const lw_dynamics *solved, double from, double to)
{
    const lw_spatial_expansion *x = lw_dynamics_spatial_elastic(solved);
    const lw_dynamics_options o = held();
    lw_dynamics *d;
    double drive = 0, wave = INFINITY;
    for (const lw_elastic_chain *k = x->chain; k < x->chain + x->n_chain; k++)
        for (int i = 0; i + 1 < k->n_node && !k->condensed; i++)
            wave = fmin(wave, passing(k, x->model.beam[k->first_beam + i].length));
    for (int i = 0; i < m->n_input; i++)
        drive = fmax(drive, lw_motion_frequency(m->input[i].motion, m->input[i].measure.of == LW_OF_TURN,
                                                m->input[i].has_speed ? m->input[i].speed : 0, from, to));
    return rules(lw_dynamics_make_spatial(m, &o, &d, NULL) == LW_OK ? first_frequency(d, lw_dynamics_space(d)->n_q) : 0, drive, wave);
}

/* cli/motion/simulate_elastic.c - what --explain says of elastic links: their elements, and the rules of how to analyse them. */
#include "base/real.h"
#include "cli/motion/simulate.h"
#include "cli/motion/spatial.h"
#include "cli/program/output.h"
#include "mbs/analysis/elastic_rules.h"

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

static void explain_rules(const cli_call *call, const lw_elastic_rules *r)
{
    if (r->first > 0)
        cli_note(call, "first frequency in the posture of the file, inputs held: %.4g Hz", r->first);
    if (r->ratio > 0)
        cli_note(call, "that is %.3g times the frequency of the drive, %.4g rad/s "
                 "(its speed, or acceleration over speed): %s (rule of Sanders and Tesar: 20 times)",
                 r->ratio, r->drive, r->quasi_static ? "vibrations are small, a quasi-static run (--analysis quasistatic) or rigid links (--rigid) are enough"
                 : "vibrations matter, run the model in time");
    if (isfinite(r->harmonic_step))
        cli_note(call, "longest step to see %d harmonics with %d samples each: %.3g s (Makkonen 1999, eq. 21)", LW_RULE_HARMONICS, LW_RULE_SAMPLES,
                 r->harmonic_step);
    if (isfinite(r->wave_step))
        cli_note(call, "a shock wave passes the shortest element in %.3g s, the longest step for impacts (eq. 22)", r->wave_step);
}

void cli_explain_elastic(const cli_call *call, const lw_model *m, const lw_dynamics *solved, double from, double to)
{
    const lw_elastic_expansion *x = lw_dynamics_elastic(solved);
    if (!x)
        return;
    for (int c = 0; c < x->n_chain; c++)
        explain_chain(call, m->linkage.link_name[x->chain[c].link], &x->chain[c]);
    lw_elastic_rules r = lw_elastic_rules_find(m, solved, from, to);
    explain_rules(call, &r);
}

void cli_explain_elastic_spatial(const cli_call *call, const lw_spatial *m, const lw_dynamics *solved, double from, double to)
{
    const lw_spatial_expansion *x = lw_dynamics_spatial_elastic(solved);
    if (!x || x->n_chain == 0)
        return;
    for (int c = 0; c < x->n_chain; c++)
        explain_chain(call, m->body[x->chain[c].link].name, &x->chain[c]);
    lw_elastic_rules r = lw_elastic_rules_find_spatial(m, solved, from, to);
    explain_rules(call, &r);
}

#include "cli/motion/dynamics_report.h"

#include <string.h>

#include "base/number.h"
#include "cli/motion/trace.h"
#include "cli/program/output.h"

void cli_dynamics_explain(const cli_call *call, const lw_dynamics_report *r)
{
    cli_note(call, "%s: %s; %d unknown%s, %d freedom%s, %d redundant constraint%s", lw_formulation_name(r->formulation),
             r->why, r->unknowns, lw_plural(r->unknowns), r->freedom, lw_plural(r->freedom), r->redundant,
             lw_plural(r->redundant));
}

void cli_dynamics_remarks(FILE *f, const lw_dynamics_report *r, lw_status status, const lw_error *e)
{
    if (r->without_forces)
        fprintf(f, "# singular posture in %ld row%s, first at t = %.12g s: forces without a limit there are left empty\n",
                r->without_forces, lw_plural(r->without_forces), r->without_forces_t);
    if (r->adjusted > 0) {
        fprintf(f, "# assumed: dimensions of the overconstrained linkage changed by up to %.3g m", r->adjusted);
        if (r->adjusted_turn > 0)
            fprintf(f, " and %.3g rad", r->adjusted_turn);
        fputs(" so that it moves\n", f);
    }
    if (r->gave_up)
        fprintf(f, "# %s gave up at t = %.12g s; what follows is by %s\n", lw_formulation_name(r->gave_up), r->gave_up_t, lw_formulation_name(r->formulation));
    if (r->smooth_friction)
        fputs("# assumed: friction is regularised by a speed of 0.001 m/s; a joint at rest under load creeps\n", f);
    if (r->no_friction)
        fputs("# assumed: equilibria without friction\n", f);
    if (r->undetermined)
        fprintf(f, "# several motions from t = %.12g s on: contact %s and others share a load in several ways while they slip\n", r->undetermined_t,
                r->undetermined);
    if (r->jammed)
        fprintf(f, "# friction at contact %s can give way earlier or later than t = %.12g s\n", r->jammed, r->jammed_t);
    if (r->captured_step > 0)
        fprintf(f, "# assumed: contacts are captured in steps of up to %.2g s; impacts are up to %.2g s off their time, overlaps within a step "
                "reach %.2g m\n", r->captured_step, r->captured_late, r->overlap);
    if (r->coarse.large)
        fprintf(f, "# a run with a tolerance of %.2g differs by up to %.2g m and %.2g rad\n", r->coarse.tolerance, r->coarse.place,
                r->coarse.turn);
    if (r->coarse.ended)
        fprintf(f, "# that run ended at t = %.6g s\n", r->coarse.ended_t);
    if (status != LW_OK)
        fprintf(f, "# incomplete: ended at t = %.12g s: %s\n", r->t, e->text);
}

static void put_event(cli_json *j, const lw_run_event *h)
{
    cli_json_object(j, NULL);
    cli_json_real(j, "t", h->t);
    cli_json_text(j, h->touch ? "touch" : "joint", h->name);
    if (!h->touch)
        cli_json_text(j, "stop", h->greatest ? "greatest" : "least");
    cli_json_text(j, "what", h->impact ? "impact" : "leaves");
    cli_json_real(j, "speed", h->speed);
    cli_json_end(j);
}

void cli_dynamics_tail(cli_json *j, const lw_dynamics *d, const lw_dynamics_report *r, lw_status status, const lw_error *e)
{
    cli_json_end(j);
    cli_json_text(j, "formulation", r->formulation == LW_FORMULATION_AUTO ? "equilibrium" : lw_formulation_name(r->formulation));
    if (r->gave_up) {
        cli_json_text(j, "gave_up", lw_formulation_name(r->gave_up));
        cli_json_real(j, "gave_up_t", r->gave_up_t);
    }
    cli_json_bool(j, "complete", status == LW_OK);
    if (status != LW_OK)
        cli_json_text(j, "ended", e->text);
    cli_json_real(j, "t", r->t);
    cli_json_array(j, "assumed_at_rest");
    for (int i = 0; i < lw_dynamics_inputs(d); i++)
        if (lw_dynamics_starts_at_rest(d, i))
            cli_json_text(j, NULL, lw_dynamics_input_name(d, i));
    cli_json_end(j);
    cli_json_int(j, "rows_without_forces", r->without_forces);
    cli_json_bool(j, "friction_creeps", r->smooth_friction);
    cli_json_bool(j, "friction_left_out", r->no_friction);
    if (r->undetermined)
        cli_json_real(j, "undetermined_from", r->undetermined_t);
    if (r->jammed)
        cli_json_real(j, "jammed_until", r->jammed_t);
    if (r->captured_step > 0) {
        cli_json_real(j, "captured_step", r->captured_step);
        cli_json_real(j, "captured_late", r->captured_late);
        cli_json_real(j, "captured_rest", r->captured_rest);
        cli_json_real(j, "overlap", r->overlap);
    }
    if (r->coarse.tolerance > 0) {
        cli_json_object(j, "coarse_run");
        cli_json_real(j, "tolerance", r->coarse.tolerance);
        cli_json_real(j, "place", r->coarse.place);
        cli_json_real(j, "turn", r->coarse.turn);
        if (r->coarse.ended)
            cli_json_real(j, "ended", r->coarse.ended_t);
        cli_json_end(j);
    }
    cli_json_int(j, "steps", r->steps);
    cli_json_int(j, "evaluations", r->rates);
    cli_json_int(j, "redundant", r->redundant);
    cli_json_int(j, "idle", lw_dynamics_idle(d));
    cli_json_real(j, "adjusted", r->adjusted);
    if (r->adjusted_turn > 0)
        cli_json_real(j, "adjusted_turn", r->adjusted_turn);
    cli_json_real(j, "residual", r->worst_off);
    cli_json_real(j, "residual_rate", r->worst_off_rate);
    cli_json_real(j, "energy_error", r->energy_error);
    cli_json_real(j, "energy_held", r->energy_held);
    if (r->period > 0) {
        cli_json_real(j, "period", r->period);
        cli_json_real(j, "period_off", r->period_off);
    }
    cli_json_real(j, "energy_scale", r->energy_scale);
    cli_json_array(j, "events");
    for (int i = 0; i < r->n_event; i++)
        put_event(j, &r->event[i]);
    cli_json_end(j);
    cli_json_end(j);
}

void cli_dynamics_notes(const cli_call *call, const lw_dynamics *d, const lw_dynamics_report *r)
{
    lw_linkage linkage;
    if (lw_dynamics_model(d) && lw_assembly_linkage(&lw_dynamics_model(d)->linkage, &linkage, NULL) == LW_OK)
        cli_note_nearly_flat(call, &linkage);
    lw_dynamics_notes(cli_notes(call), d, r);
}

void cli_suction_see(cli_suction *low, const lw_states *states, const double *z, double t)
{
    for (int i = 0; i < states->n_state; i++)
        if (strcmp(states->state[i].unit, "Pa") == 0 && z[i] < low->pressure)
            *low = (cli_suction){ states->state[i].name, z[i], t };
}

void cli_suction_note(const cli_call *c, const cli_suction *low)
{
    static const double air = 101325;
    if (low->pressure < -air)
        cli_note(c, "%s falls to %.4g Pa at t = %.6g s, below vacuum (%.4g Pa against the air): oil tears there, which is not modelled, and the cylinder "
                 "pulls too much", low->state, low->pressure, low->t, -air);
}

void cli_pull_see(cli_pull *p, const lw_elastic_chain *c, double normal, double length, double second)
{
    double share = normal*length*length/(LW_PI*LW_PI*c->elastic->material.e*second);
    if (fabs(share) > fabs(p->share))
        *p = (cli_pull){ share, c };
}

void cli_note_pull(const cli_call *c, const cli_pull *p, const char *node)
{
    if (fabs(p->share) > 0.01)
        cli_note(c, "the axial force in \"%.*s\" reaches %.3g of the buckling load of one of its superelements, in %s, and they bend as if they had "
                 "none; take more \"superelements\"", (int)strlen(node) - 2, node, fabs(p->share), p->share > 0 ? "tension" : "compression");
}

#include "cli/motion/dynamics_report.h"

#include <string.h>

#include "base/number.h"
#include "cli/motion/trace.h"
#include "cli/program/output.h"
#include "mbs/dynamics/dynamics_space.h"

void cli_dynamics_explain(const cli_call *call, const lw_dynamics_report *r)
{
    cli_note(call, "%s: %s; %d unknown%s, %d freedom%s, %d redundant constraint%s", lw_formulation_name(r->formulation),
             r->why, r->unknowns, lw_plural(r->unknowns), r->freedom, lw_plural(r->freedom), r->redundant,
             lw_plural(r->redundant));
}

void cli_dynamics_remarks(FILE *f, const lw_dynamics_report *r, const cli_coarse_run *coarse, lw_status status, const lw_error *e)
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
    if (r->captured_step > 0)
        fprintf(f, "# assumed: contacts are captured in steps of up to %.2g s; impacts are up to %.2g s late, overlaps within a step "
                "reach %.2g m\n", r->captured_step, r->captured_late, r->overlap);
    if (coarse && coarse->told)
        fprintf(f, "# a run with a tolerance of %.2g differs by up to %.2g m and %.2g rad\n", coarse->tolerance, coarse->place, coarse->turn);
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

void cli_dynamics_tail(cli_json *j, const lw_dynamics *d, const lw_dynamics_report *r, const cli_coarse_run *coarse, lw_status status, const lw_error *e)
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
    if (r->captured_step > 0) {
        cli_json_real(j, "captured_step", r->captured_step);
        cli_json_real(j, "captured_late", r->captured_late);
        cli_json_real(j, "captured_rest", r->captured_rest);
        cli_json_real(j, "overlap", r->overlap);
    }
    if (coarse && coarse->tolerance > 0) {
        cli_json_object(j, "coarse_run");
        cli_json_real(j, "tolerance", coarse->tolerance);
        cli_json_real(j, "place", coarse->place);
        cli_json_real(j, "turn", coarse->turn);
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

/* In a run in time the mass of an elastic link is lumped at its nodes; say where these are so few that its inertia is wrong.  The name of
 * a link is that of its node 0, NAME.0. */
static void note_lumps(const cli_call *c, const lw_dynamics *d)
{
    static const double told = 0.05;             /* of the inertia; the time of a swing is off by up to a half of it */
    const lw_spatial_expansion *space = lw_dynamics_spatial_elastic(d);
    const lw_elastic_expansion *plane = lw_dynamics_elastic(d);
    const lw_elastic_chain *worst = NULL;
    int links = 0, n = space ? space->n_chain : plane && lw_dynamics_model(d) ? plane->n_chain : 0;
    for (int k = 0; k < n && lw_dynamics_in_time(d); k++) {
        const lw_elastic_chain *one = space ? &space->chain[k] : &plane->chain[k];
        links += one->too_much > told;
        worst = one->too_much > (worst ? worst->too_much : told) ? one : worst;
    }
    if (!worst)
        return;
    const char *name = space ? lw_dynamics_space(d)->model->body[worst->link].name : plane->model.linkage.link_name[worst->link];
    cli_note(c, "the mass of elastic links is lumped at their nodes, and %d link%s too few of them: the %d nodes of \"%.*s\" have %.3g times its inertia "
             "about its centre of mass, so that it moves too slowly; take more \"segments\"", links, links == 1 ? " has" : "s have", worst->n_node,
             (int)strlen(name) - 2, name, 1 + worst->too_much);
}

/* Implicit methods keep places within the tolerance and damp what vibrates faster than their steps; without damping of the links that
 * is a part of their inner forces.  A cantilever loaded at once, at 1e-7: tip 1e-4, moment 6e-3, shear 6e-2 of the greatest. */
static void note_inner(const cli_call *c, const lw_dynamics *d, const lw_dynamics_report *r)
{
    const lw_spatial_expansion *space = lw_dynamics_spatial_elastic(d);
    const lw_elastic_expansion *plane = lw_dynamics_elastic(d);
    int n = space ? space->n_chain : plane && lw_dynamics_model(d) ? plane->n_chain : 0;
    bool damped = n == 0 || !lw_dynamics_in_time(d) || (r->formulation != LW_FORMULATION_RADAU && r->formulation != LW_FORMULATION_ALPHA);
    for (int k = 0; !damped && k < n; k++) {
        const lw_elastic *one = space ? space->chain[k].elastic : plane->chain[k].elastic;
        damped = one->damping > 0 || one->n_node > 0;
    }
    if (!damped)
        cli_note(c, "elastic links without damping: vibrations faster than the steps are damped by the method, so inner forces, shear and tension most, are "
                 "less exact than places (often some percent at a tolerance of 1e-7); compare with a smaller --tolerance, as 1e-9, or give the links damping");
}

/* A linkage that comes from `fit` or from a drawing has neither masses nor loads. */
static void note_weightless(const cli_call *c, const lw_model *m)
{
    bool loaded = m->n_elastic || m->n_super || m->n_spring || m->n_joint_spring || m->n_force || m->n_motor || m->states.n_state;
    for (int i = 0; !loaded && i < m->linkage.n_link; i++)
        loaded = m->body[i].given;
    if (!loaded)
        cli_note(c, "no link has a mass and nothing pulls on one, so all forces and torques are 0; give links a \"mass\", \"centre\" and \"inertia\" in the file");
}

static void note_start(const cli_call *c, const lw_dynamics *d, const lw_dynamics_report *r)
{
    char text[1024];
    int idle = lw_dynamics_idle(d);
    if (r->adjusted > 0)
        cli_note_adjusted(c, r->adjusted, r->adjusted_turn);
    lw_linkage linkage;
    if (lw_dynamics_model(d) && lw_assembly_linkage(&lw_dynamics_model(d)->linkage, &linkage, NULL) == LW_OK)
        cli_note_nearly_flat(c, &linkage);
    if (lw_dynamics_model(d))
        note_weightless(c, lw_dynamics_model(d));
    if (r->moved > 1e-9)
        cli_note(c, "the posture of the file violates the constraints by %.3g of its size and was closed", r->moved);
    lw_dynamics_redundant(d, text, sizeof text);
    if (r->redundant)
        cli_note(c, "%d constraint%s redundant: %s reactions%s%s are not unique, those of least norm are given", r->redundant,
                 r->redundant == 1 ? " is" : "s are", *text ? "the" : "some", *text ? " at" : "", text);
    if (r->redundant && r->freedom == 0 && !lw_dynamics_model(d))
        cli_note(c, "no freedom is left, so nothing moves; if the linkage should move, its numbers are rounded: \"mobility --tolerance 1e-4\" "
                 "tells, and more digits help");
    if (idle)
        cli_note(c, "%d spin%s of links between ball joints, or without inertia about their axis, %s held", idle, lw_plural(idle), idle == 1 ? "is" : "are");
    const lw_spatial_expansion *x = lw_dynamics_spatial_elastic(d);
    const lw_elastic_expansion *plane = lw_dynamics_model(d) ? lw_dynamics_elastic(d) : NULL;
    const lw_elastic_chain *chain = x ? x->chain : plane ? plane->chain : NULL;
    note_lumps(c, d);
    note_inner(c, d, r);
    for (int k = 0; chain && k < (x ? x->n_chain : plane->n_chain); k++)
        if (chain[k].elastic->n_node > 0) {                  /* the name is that of node 0, NAME.0 */
            const char *name = x ? lw_dynamics_space(d)->model->body[chain[k].link].name : plane->model.linkage.link_name[chain[k].link];
            cli_note(c, "elastic link \"%.*s\" has no section: its inner forces are known at its joints only, as their reactions",
                     (int)strlen(name) - 2, name);
        }
    if (lw_dynamics_many_drives(d))
        cli_note(c, "there are more drives than freedoms: their forces are not unique, those of least norm are given");
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

void cli_dynamics_notes(const cli_call *c, const lw_dynamics *d, const lw_dynamics_report *r, const cli_coarse_run *coarse)
{
    if (r->period_off > 0)
        cli_note(c, "the motion repeats itself every %.12g s; what follows ten periods is taken from them, its phase good "
                 "to %.1e periods at the end", r->period, r->period_off);
    if (r->gave_up)
        cli_note(c, "%s; the rest of the run is by %s", r->why, lw_formulation_name(r->formulation));
    if (r->without_forces)
        cli_note(c, "%ld row%s in a singular posture, the first at t = %.12g s: forces without a limit there are left "
                 "empty", r->without_forces, r->without_forces == 1 ? " is" : "s are", r->without_forces_t);
    if (r->lost)
        cli_note_lost(c, "t", r->lost_t, 1, "s");
    if (r->smooth_friction)
        cli_note(c, "friction without a \"speed\" sticks only in planar linkages of one freedom that are solved in closed form, and at pins and sliders "
                 "in space; here it is regularised by 0.001 m/s, and a joint at rest under load creeps");
    if (r->no_friction)
        cli_note(c, "equilibria are those without friction: with it the model also rests around them, and its drives need as much "
                 "more or less; a slow run in time (dynamic) shows it");
    if (r->undetermined)
        cli_note(c, "from t = %.12g s on contact %s and others share a load in several ways while they slip, each with other friction: rigid bodies have "
                 "several motions then, of which one is given; a \"stiffness\" of the contacts determines it", r->undetermined_t, r->undetermined);
    if (r->captured_late > 0)
        cli_note(c, "contacts are captured in steps of up to %.2g s: impacts that follow each other, or many at once, are up to %.2g s late, and overlaps "
                 "within a step reach %.2g m; the error is of first order (--formulation index1 locates each event)", r->captured_step, r->captured_late,
                 r->overlap);
    else if (r->captured_step > 0)
        cli_note(c, "contacts are captured in steps of up to %.2g s, and each impact was located: the error is of second order", r->captured_step);
    if (r->captured_rest > 0)
        cli_note(c, "bounces of up to %.2g m/s count as rest", r->captured_rest);
    if (coarse && coarse->told)
        cli_note(c, "a run with a tolerance of %.2g differs by up to %.2g m (%s, t = %.6g s) and %.2g rad (%s, t = %.6g s); expect errors of about that size",
                 coarse->tolerance, coarse->place, coarse->placed, coarse->place_t, coarse->turn, coarse->turned, coarse->turn_t);
    note_start(c, d, r);
    for (int i = 0; i < r->n_event && i < 10; i++) {
        const lw_run_event *h = &r->event[i];
        if (h->touch)
            cli_note(c, "t = %.15g s: %s %s", h->t, h->name, h->impact ? "strikes" : "leaves");
        else
            cli_note(c, "t = %.15g s: joint %s %s its %s stop", h->t, h->name, h->impact ? "strikes" : "leaves",
                     h->greatest ? "greatest" : "least");
    }
    if (r->n_event_seen > 10)
        cli_note(c, "%d events in all", r->n_event_seen);
    if (r->energy_scale > 0)
        cli_note(c, r->energy_held > 0 ? "energy error %.3g J of %.3g J; %.3g J in all were put back after steps"
                 : "energy error %.3g J of %.3g J", r->energy_error, r->energy_scale, r->energy_held);
    if (r->energy_steps > 0)
        cli_note(c, "that is %.2g times the error allowed a step: the motion is less accurate than --tolerance asks; a smaller one or another --formulation "
                 "shows by how much", r->energy_steps);
    if (r->added > 0)
        cli_note(c, "the estimated errors of all steps of alpha add up to %.2g (angles in rad, places as parts of the size of the linkage), more than --tolerance "
                 "asks for; the true error can be several times as great. --formulation radau is of higher order", r->added);
    if (r->momentum_scale > 1e-290)          /* something moved                                         */
        cli_note(c, "momentum error %.3g of %.3g kg m^2/s or kg m/s", r->momentum_error, r->momentum_scale);
    if (r->steps > 0)
        cli_note(c, "constraint residual %.3g, of rates %.3g 1/s; %ld step%s, %ld refused, %ld evaluation%s", r->worst_off,
                 r->worst_off_rate, r->steps, lw_plural(r->steps), r->refused, r->rates, lw_plural(r->rates));
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

void cli_taut_see(cli_taut *p, const lw_elastic_chain *c, double h, double apart, double second)
{
    double share = c->elastic->section.area*(apart/h - 1)*h*h/(12*second);
    if (share > p->share)
        *p = (cli_taut){ share, c };
}

lw_status cli_note_taut(const cli_call *c, const cli_taut *p, const char *node, lw_status st, lw_error *e)
{
    static const double lost = 0.9, large = 0.1;
    int n = p->chain ? (int)strlen(node) - 2 : 0, elements = p->chain ? p->chain->n_node - 1 : 0;
    double needed = ceil(elements*sqrt(p->share/large));
    if (p->share > lost && (st == LW_OK || st == LW_STOPPED))
        return lw_error_set(e, LW_E_NUMERIC, "the tension in \"%.*s\" reaches %.3g of 12 E I/h^2, where elements of its length h turn out of their direction and stretch "
                            "without resistance: the motion is not that of the link; take at least %.0f \"segments\"", n, node, p->share, needed);
    if (p->share > large)
        cli_note(c, "the tension in \"%.*s\" reaches %.3g of 12 E I/h^2, where elements of its length h turn out of their direction: how it bends may be off by a like "
                 "share; %.0f \"segments\" bring it below 0.1", n, node, p->share, needed);
    return st;
}

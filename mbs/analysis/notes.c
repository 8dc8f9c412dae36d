#include "mbs/analysis/notes.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "base/number.h"
#include "mbs/dynamics/dynamics_space.h"

static void note(lw_note_sink to, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void note(lw_note_sink to, const char *format, ...)
{
    char text[1536];
    va_list arg;
    va_start(arg, format);
    vsnprintf(text, sizeof text, format, arg);
    va_end(arg);
    to.say(to.context, text);
}

void lw_note_adjusted(lw_note_sink c, double moved, double turned)
{
    char axes[64] = "";
    if (turned > 0)
        snprintf(axes, sizeof axes, " and their axes turned by up to %.3g rad", turned);
    note(c, "the linkage is overconstrained and moves only if its dimensions fit: joints were moved by up to %.3g m%s so that they do, "
         "by least squares", moved, axes);
}

void lw_note_lost(lw_note_sink c, const char *what, const double between[2], double unit, const char *name, const char *how)
{
    if (between[0] == between[1]) {
        note(c, "at %s = %.9g %s the motion passes a singular posture, where links can move while the drive stands still: forces of joints may grow without "
             "limit near it, and a machine may leave it on another branch", what, between[0]/unit, name);
        return;
    }
    note(c, "between %s = %.9g and %.9g %s the motion passes a parallel singularity, where the drives lose control of the links: links can move there "
         "while all drives stand still%s%s%s, drive forces grow without limit near it, and a machine may leave it on another branch (robot reachability, "
         "workspace)", what, between[0]/unit, between[1]/unit, name, *how ? " (" : "", how, *how ? ")" : "");
}

/* In a run in time the mass of an elastic link is lumped at its nodes; say where these are so few that its inertia is wrong.  The name of
 * a link is that of its node 0, NAME.0. */
static void note_lumps(lw_note_sink c, const lw_dynamics *d)
{
    static const double told = 0.01;             /* of the inertia; the time of a swing is off by up to a half of it */
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
    note(c, "the mass of elastic links is lumped at their nodes, and %d link%s too few of them: the %d nodes of \"%.*s\" have %.3g times its inertia "
         "about its centre of mass, so that it moves too slowly; take more \"segments\"", links, links == 1 ? " has" : "s have", worst->n_node,
         (int)strlen(name) - 2, name, 1 + worst->too_much);
}

/* The weight of elastic links acts at their nodes, also that of consistent masses: a deflection between supports is too small by up to 0.8/n^2, n elements.
 * In a run in time note_lumps says so of lumps. */
static void note_weight(lw_note_sink c, const lw_dynamics *d)
{
    static const double told = 0.005;
    const lw_spatial_expansion *space = lw_dynamics_spatial_elastic(d);
    const lw_elastic_expansion *plane = lw_dynamics_elastic(d);
    int few = 0, n = space ? space->n_chain : plane && lw_dynamics_model(d) ? plane->n_chain : 0;
    bool weighs = space ? lw_v3_norm(lw_dynamics_space(d)->model->gravity) > 0 : n > 0 && lw_v2_norm(lw_dynamics_model(d)->gravity) > 0;
    for (int k = 0; k < n && weighs; k++) {
        const lw_elastic_chain *one = space ? &space->chain[k] : &plane->chain[k];
        if ((one->elastic->consistent || !lw_dynamics_in_time(d)) && !one->condensed && 0.8 > told*(one->n_node - 1)*(one->n_node - 1))
            few = few && few < one->n_node - 1 ? few : one->n_node - 1;
    }
    if (few)
        note(c, "the weight of elastic links acts at their nodes: of %d elements, deflections under it may be off by %.2g %%; take more \"segments\"",
             few, 80.0/few/few);
}

/* Implicit methods keep places within the tolerance and damp what vibrates faster than their steps; without damping of the links that
 * is a part of their inner forces.  A cantilever loaded at once, at 1e-7: tip 1e-4, moment 6e-3, shear 6e-2 of the greatest. */
static void note_inner(lw_note_sink c, const lw_dynamics *d, const lw_dynamics_report *r)
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
        note(c, "elastic links without damping: vibrations faster than the steps are damped by the method, so inner forces, shear and tension most, are "
             "less exact than places (often some percent at a tolerance of 1e-7); compare with a smaller tolerance, as 1e-9, or give the links damping");
}

/* A linkage that comes from `fit` or from a drawing has neither masses nor loads. */
static void note_weightless(lw_note_sink c, const lw_model *m)
{
    bool loaded = m->n_elastic || m->n_super || m->n_spring || m->n_joint_spring || m->n_force || m->n_motor || m->states.n_state;
    for (int i = 0; !loaded && i < m->linkage.n_link; i++)
        loaded = m->body[i].given;
    if (!loaded)
        note(c, "no link has a mass and nothing pulls on one, so all forces and torques are 0; give links a \"mass\", \"centre\" and \"inertia\" in the file");
}

static bool drives_rest(const lw_spatial *m)
{
    bool moved = false;
    for (int i = 0; i < m->n_input; i++)
        moved = moved || m->input[i].motion;
    return m->n_drive > 0 && !moved;
}

static void note_start(lw_note_sink c, const lw_dynamics *d, const lw_dynamics_report *r)
{
    char text[1024];
    int idle = lw_dynamics_idle(d);
    if (r->adjusted > 0)
        lw_note_adjusted(c, r->adjusted, r->adjusted_turn);
    if (lw_dynamics_model(d))
        note_weightless(c, lw_dynamics_model(d));
    if (!lw_dynamics_model(d) && drives_rest(lw_dynamics_space(d)->model))
        note(c, "the \"drives\" have no force here: they carry the forces of \"inputs\" with a \"motion\", and the model has none, so it moves freely; list "
             "joints as such inputs to hold or move them");
    if (r->moved > 1e-9)
        note(c, "the posture of the file violates the constraints by %.3g of its size and was closed", r->moved);
    bool rubs = lw_dynamics_redundant(d, text, sizeof text);
    if (r->redundant)
        note(c, "%d constraint%s redundant: %s reactions%s%s are not unique, those of least norm are given", r->redundant,
             r->redundant == 1 ? " is" : "s are", *text ? "the" : "some", *text ? " at" : "", text);
    if (r->redundant && rubs && !r->no_friction)
        note(c, "friction acts in joints whose reactions are not unique: rigid links do not determine how these share the load, and the friction, the motion "
             "and the forces of drives may depend on it; elastic links, or joints with more freedoms, determine it");
    if (r->redundant && r->freedom == 0 && !lw_dynamics_model(d))
        note(c, "no freedom is left, so nothing moves; if the linkage should move, its numbers are rounded: \"mobility --tolerance 1e-4\" "
             "tells, and more digits help");
    if (idle)
        note(c, "%d spin%s of links between ball joints, or without inertia about their axis, %s held", idle, lw_plural(idle), idle == 1 ? "is" : "are");
    const lw_spatial_expansion *x = lw_dynamics_spatial_elastic(d);
    const lw_elastic_expansion *plane = lw_dynamics_model(d) ? lw_dynamics_elastic(d) : NULL;
    const lw_elastic_chain *chain = x ? x->chain : plane ? plane->chain : NULL;
    note_lumps(c, d);
    note_weight(c, d);
    note_inner(c, d, r);
    for (int k = 0; chain && k < (x ? x->n_chain : plane->n_chain); k++)
        if (chain[k].elastic->n_node > 0) {                  /* the name is that of node 0, NAME.0 */
            const char *name = x ? lw_dynamics_space(d)->model->body[chain[k].link].name : plane->model.linkage.link_name[chain[k].link];
            note(c, "elastic link \"%.*s\" has no section: its inner forces are known at its joints only, as their reactions",
                 (int)strlen(name) - 2, name);
        }
    if (lw_dynamics_many_drives(d))
        note(c, "there are more drives than freedoms: their forces are not unique, those of least norm are given");
}

void lw_dynamics_notes(lw_note_sink c, const lw_dynamics *d, const lw_dynamics_report *r)
{
    if (r->period_off > 0)
        note(c, "the motion repeats itself every %.12g s; what follows ten periods is taken from them, its phase good "
             "to %.1e periods at the end", r->period, r->period_off);
    if (r->gave_up)
        note(c, "%s; the rest of the run is by %s", r->why, lw_formulation_name(r->formulation));
    if (r->without_forces)
        note(c, "%ld row%s in a singular posture%s, the first at t = %.12g s: forces without a limit there are left "
             "empty", r->without_forces, r->without_forces == 1 ? " is" : "s are",
             r->jams ? ", or in one where friction of rigid links leaves no forces or several (self-locking, Painleve's paradox)" : "", r->without_forces_t);
    if (r->lost)
        lw_note_lost(c, "t", r->lost_t, 1, "s", r->lost_how);
    if (r->smooth_friction)
        note(c, "friction without a \"speed\" sticks only in planar linkages of one freedom that are solved in closed form, and at pins and sliders "
             "in space; here it is regularised by 0.001 m/s, and a joint at rest under load creeps");
    if (r->no_friction)
        note(c, "equilibria are those without friction: with it the model also rests around them, and its drives need as much "
             "more or less; a slow run in time (dynamic) shows it");
    if (r->undetermined)
        note(c, "from t = %.12g s on contact %s and others share a load in several ways while they slip, each with other friction: rigid bodies have "
             "several motions then, of which one is given; a \"stiffness\" of the contacts determines it", r->undetermined_t, r->undetermined);
    if (r->jammed)
        note(c, "contact %s and others can share their load in several ways, and at t = %.12g s friction held in some of these ways only: rigid "
             "bodies can slip earlier or later than given; a \"stiffness\" of the contacts determines when", r->jammed, r->jammed_t);
    if (r->captured_late > 0)
        note(c, "contacts are captured in steps of up to %.2g s: impacts that follow each other, or many at once, are up to %.2g s off their time, and overlaps "
             "within a step reach %.2g m; the error is of first order (formulation index1 locates each event)", r->captured_step, r->captured_late,
             r->overlap);
    else if (r->captured_step > 0)
        note(c, "contacts are captured in steps of up to %.2g s, and each impact but slow ones was located: the error is of second order%s", r->captured_step,
             r->captured_rest > 0 ? ", but for low bounces" : "");
    if (r->captured_rest > 0)
        note(c, "bounces of up to %.2g m/s count as rest; the error is of first order there", r->captured_rest);
    if (r->coarse.large)
        note(c, "a run with a tolerance of %.2g differs by up to %.2g m (%s, t = %.6g s) and %.2g rad (%s, t = %.6g s); expect errors of up to about that size",
             r->coarse.tolerance, r->coarse.place, lw_dynamics_model(d)->linkage.link_name[r->coarse.placed], r->coarse.place_t, r->coarse.turn,
             lw_dynamics_model(d)->linkage.link_name[r->coarse.turned], r->coarse.turn_t);
    if (r->coarse.ended)
        note(c, "that run ended at t = %.6g s, so later errors are not known; a smaller tolerance may show them, or more time if that was limited",
             r->coarse.ended_t);
    if (r->captured_step > 0 && r->coarse.tolerance == 0)
        note(c, "the error of captured contacts is not known: so many rows are not kept for a comparison with a second run");
    note_start(c, d, r);
    for (int i = 0; i < r->n_event && i < 10; i++) {
        const lw_run_event *h = &r->event[i];
        if (h->touch)
            note(c, "t = %.15g s: %s %s", h->t, h->name, h->impact ? "strikes" : "leaves");
        else
            note(c, "t = %.15g s: joint %s %s its %s stop", h->t, h->name, h->impact ? "strikes" : "leaves",
                 h->greatest ? "greatest" : "least");
    }
    if (r->n_event_seen > 10)
        note(c, "%d events in all", r->n_event_seen);
    if (r->energy_scale > 0)
        note(c, r->energy_held > 0 ? "energy error %.3g J of %.3g J; %.3g J in all were put back after steps"
             : "energy error %.3g J of %.3g J", r->energy_error, r->energy_scale, r->energy_held);
    if (r->energy_steps > 0)
        note(c, "that is %.2g times the error allowed a step: the motion is less accurate than the tolerance asks; a smaller one or another formulation "
             "shows by how much", r->energy_steps);
    if (r->added > 0)
        note(c, "the estimated errors of all steps of alpha add up to %.2g (angles in rad, places as parts of the size of the linkage), more than the "
             "tolerance asks for; the true error can be ten times as great or more, because errors of velocities go on. Formulation radau is of higher order", r->added);
    if (r->momentum_scale > 1e-290)          /* something moved                                         */
        note(c, "momentum error %.3g of %.3g kg m^2/s or kg m/s", r->momentum_error, r->momentum_scale);
    if (r->steps > 0)
        note(c, "constraint residual %.3g, of rates %.3g 1/s; %ld step%s, %ld refused, %ld evaluation%s", r->worst_off,
             r->worst_off_rate, r->steps, lw_plural(r->steps), r->refused, r->rates, lw_plural(r->rates));
}

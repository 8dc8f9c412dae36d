/* mbs/dynamics/dynamics_choose.c - which equations a scene needs. */
#include "mbs/dynamics/dynamics_run_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/ode/panel_internal.h"
#include "mbs/dynamics/reduced.h"

static const double stiff = 2e4;             /* fastest decay times length of the run                     */

/* The mobility along a measure: speed for an impulse of 1 [1/kg] or [1/(kg m^2)]. */
static double mobility(lw_dynamics *d, const lw_measure *m)
{
    double g[LW_SYSTEM_Q_MAX] = { 0 }, change[LW_SYSTEM_Q_MAX];
    for (int i = 0; i < 6; i++)
        if (m->body[i/3] >= 0)
            g[3*m->body[i/3] + i%3] += m->g[i];
    return lw_mbs_impulse(d, g, change);
}

/* The fastest decay that dampers cause at the start [1/s]. */
static double fastest_decay(lw_dynamics *d)
{
    const lw_model *k = d->model;
    double most = 0;
    lw_measure m;
    if (lw_mbs_rows(d, d->o.from, d->start_q) != LW_OK || lw_mbs_factor(d, false) != LW_OK)
        return 0;
    for (int i = 0; i < k->n_spring; i++) {
        int body[2] = { d->s.body[k->spring[i].link[0]], d->s.body[k->spring[i].link[1]] };
        lw_measure_length(&d->s, body, d->f.spring_arm[i], d->start_q, d->start_v, false, &m);
        most = fmax(most, k->spring[i].damping*mobility(d, &m));
    }
    for (int i = 0; i < k->n_joint_spring; i++) {
        lw_measure_joint(&d->s, k->joint_spring[i].joint, d->start_q, d->start_v, false, &m);
        most = fmax(most, k->joint_spring[i].damping*mobility(d, &m));
    }
    for (int i = 0; i < k->n_motor; i++) {
        lw_measure_joint(&d->s, k->motor[i].joint, d->start_q, d->start_v, false, &m);
        most = fmax(most, k->motor[i].stall/k->motor[i].free_speed*mobility(d, &m));
    }
    return most;
}

static lw_status say(lw_dynamics_report *r, lw_formulation f, int unknowns, const char *why)
{
    r->formulation = f;
    r->unknowns = unknowns;
    snprintf(r->why, sizeof r->why, "%s", why);
    return LW_OK;
}

/* A mass where forward dynamics needs one: an error that names the link otherwise. */
static lw_status check_masses(lw_dynamics *d)
{
    lw_status s = lw_mbs_rows(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, true);
    return s == LW_OK ? lw_mbs_solve(d, d->o.from, d->start_q, d->start_v, d->a, d->l, NULL) : s;
}

static bool driven_wanted(const lw_dynamics *d, lw_error *e, lw_status *s)
{
    lw_analysis a = d->o.analysis;
    bool driven = a == LW_ANALYSIS_KINEMATIC || a == LW_ANALYSIS_QUASISTATIC || d->freedom == 0 ||
                  d->o.formulation == LW_FORMULATION_DRIVEN;
    *s = LW_OK;
    if (driven && d->freedom > 0)
        *s = lw_error_set(e, LW_E_ARG, "%d more freedom%s would have to be driven for this analysis: give every "
                          "input a \"motion\", or ask for dynamic", d->freedom, d->freedom == 1 ? "" : "s");
    return driven;
}

static bool of_length_alone(const lw_expression *law)
{
    const int *which;
    int n = law ? lw_expression_variables(law, &which) : 0;
    return n == 0 || (n == 1 && which[0] == lw_variable(LW_QUANTITY_LENGTH, 0));
}

static bool constant(const lw_expression *x)
{
    const int *which;
    return !x || lw_expression_variables(x, &which) == 0;
}

/* Does the posture alone decide the forces? */
static bool by_posture(const lw_dynamics *d)
{
    const lw_model *m = d->model;
    bool yes = m->n_motor == 0 && !d->f.caller.apply && d->n_driven == 0 && d->n_friction == 0;
    for (int i = 0; i < m->n_spring; i++)
        yes = yes && m->spring[i].damping == 0 && of_length_alone(m->spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        yes = yes && m->joint_spring[i].damping == 0 && of_length_alone(m->joint_spring[i].law);
    for (int i = 0; i < m->n_force; i++)
        yes = yes && constant(m->force[i].fx) && constant(m->force[i].fy) && constant(m->force[i].torque);
    return yes;
}

static lw_status say_quadrature(lw_dynamics *d, lw_dynamics_report *r, const char *why)
{
    d->rule = d->rule ? d->rule : malloc(sizeof *d->rule);
    if (!d->rule || lw_panel_rule_make(d->rule) != LW_OK)
        return LW_E_MEMORY;
    return say(r, LW_FORMULATION_QUADRATURE, 1, why);
}

static lw_status forced(lw_dynamics *d, lw_dynamics_report *r, lw_error *e)
{
    int n = 2*d->n_q;
    char text[160];
    lw_status s;
    switch (d->o.formulation) {
    case LW_FORMULATION_QUADRATURE:
    case LW_FORMULATION_REDUCED:
        s = lw_reduced_able(d, text, sizeof text);
        if (s != LW_OK)
            return lw_error_set(e, LW_E_KIND, "the %s formulation cannot do this model: %s",
                                lw_formulation_name(d->o.formulation), text);
        if (d->o.formulation == LW_FORMULATION_QUADRATURE && !by_posture(d))
            return lw_error_set(e, LW_E_KIND, "the quadrature formulation cannot do this model: forces depend on time or "
                                "speed");
        return d->o.formulation == LW_FORMULATION_REDUCED ? say(r, LW_FORMULATION_REDUCED, 2, "asked for")
                                                          : say_quadrature(d, r, "asked for");
    case LW_FORMULATION_GGL:
        if (d->n_contact)
            return lw_error_set(e, LW_E_KIND, "the ggl formulation knows no rigid stops; give them a \"stiffness\"");
        return say(r, LW_FORMULATION_GGL, n + 2*d->n_kept, "asked for");
    default:
        return say(r, d->o.formulation, n, "asked for");
    }
}

lw_status lw_dynamics_choose(lw_dynamics *d, lw_dynamics_report *r, lw_error *e)
{
    char text[160];
    lw_status s;
    r->freedom = d->freedom + d->n_driven;
    r->redundant = d->n_c - d->rank;
    r->moved = d->moved;
    r->moved_rate = d->moved_rate;
    r->t = d->o.from;
    if (d->o.analysis == LW_ANALYSIS_STATIC)
        return say(r, LW_FORMULATION_AUTO, d->freedom, "at rest");
    if (driven_wanted(d, e, &s))
        return s != LW_OK ? s : say(r, LW_FORMULATION_DRIVEN, d->n_q,
                                       "every freedom is driven: kinematics, then forces");
    if ((s = check_masses(d)) != LW_OK)
        return s;
    if (d->o.formulation != LW_FORMULATION_AUTO)
        return forced(d, r, e);
    if (d->n_friction)
        return say(r, LW_FORMULATION_CVODE, 2*d->n_q, "friction makes the equations stiff: an implicit method");
    if (fastest_decay(d)*(d->o.to - d->o.from) > stiff)
        return say(r, LW_FORMULATION_CVODE, 2*d->n_q, "dampers make the equations stiff: an implicit method");
    if (lw_reduced_able(d, text, sizeof text) == LW_OK)
        return by_posture(d) ? say_quadrature(d, r, "one freedom, rigid, forces by the posture alone: time is an integral "
                                              "over one coordinate")
             : say(r, LW_FORMULATION_REDUCED, 2, "one freedom, rigid, solved in closed form by dyads: one coordinate");
    char why[200];
    snprintf(why, sizeof why, "bodies' coordinates: %s", text);
    return say(r, LW_FORMULATION_INDEX1, 2*d->n_q, why);
}

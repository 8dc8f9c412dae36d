#include "mbs/elastic/contact.h"

#include <string.h>
#include "base/real.h"

bool lw_contact_rises(const lw_clearance *c)
{
    return c->model == LW_CLEARANCE_IMPACT && c->damping > 0.0 && c->depth > 0.0;
}

lw_contact_phase lw_contact_phase_at(const lw_clearance *c, double depth)
{
    if (c->model == LW_CLEARANCE_MLSD)
        return LW_CONTACT_FULL;
    if (!(depth > 0.0))
        return LW_CONTACT_APART;
    return lw_contact_rises(c) && depth < c->depth ? LW_CONTACT_RISING : LW_CONTACT_FULL;
}

/* depth^e; stages of a step may evaluate a little below 0 */
static double power(double depth, double e)
{
    return e == 1.0 ? depth : depth > 0.0 ? pow(depth, e) : 0.0;
}

double lw_contact_force(const lw_clearance *c, lw_contact_phase phase, double depth, double rate, double struck)
{
    if (phase == LW_CONTACT_APART)
        return 0.0;
    double v = fmax(struck, LW_CONTACT_SLOWEST), s = c->restitution;
    switch (c->model) {
    case LW_CLEARANCE_MLSD:
        return c->stiffness*depth + c->damping*rate;
    case LW_CLEARANCE_IMPACT: {
        double x = phase == LW_CONTACT_RISING ? fmax(depth, 0.0)/c->depth : 1.0;
        return c->stiffness*power(depth, c->exponent) + x*x*x*c->damping*rate;
    }
    case LW_CLEARANCE_HUNT_CROSSLEY:
        return c->stiffness*power(depth, c->exponent)*(1.0 + 1.5*(1.0 - s)*rate/v);
    case LW_CLEARANCE_LANKARANI:
        return c->stiffness*power(depth, c->exponent)*(1.0 + 0.75*(1.0 - s*s)*rate/v);
    default:
        return 0.0;
    }
}

/* Derivative of depth^e */
static double power_slope(double depth, double e)
{
    return e == 1.0 ? 1.0 : depth > 0.0 ? e*pow(depth, e - 1.0) : 0.0;
}

double lw_contact_spring(const lw_clearance *c, double depth)
{
    return c->stiffness*(c->model == LW_CLEARANCE_MLSD ? depth : power(depth, c->exponent));
}

double lw_contact_gradient(const lw_clearance *c, lw_contact_phase phase, double depth, double rate, double struck,
                           double *by_depth, double *by_rate)
{
    *by_depth = *by_rate = 0.0;
    if (phase == LW_CONTACT_APART)
        return 0.0;
    double v = fmax(struck, LW_CONTACT_SLOWEST), s = c->restitution, f = c->stiffness*power(depth, c->exponent);
    double slope = c->stiffness*power_slope(depth, c->exponent), part;
    switch (c->model) {
    case LW_CLEARANCE_MLSD:
        *by_depth = c->stiffness, *by_rate = c->damping;
        break;
    case LW_CLEARANCE_IMPACT:
        part = phase == LW_CONTACT_RISING ? fmax(depth, 0.0)/c->depth : 1.0;
        *by_rate = part*part*part*c->damping;
        *by_depth = slope + (phase == LW_CONTACT_RISING ? 3.0*part*part/c->depth*c->damping*rate : 0.0);
        break;
    case LW_CLEARANCE_HUNT_CROSSLEY:
    case LW_CLEARANCE_LANKARANI:
        part = (c->model == LW_CLEARANCE_LANKARANI ? 0.75*(1.0 - s*s) : 1.5*(1.0 - s))/v;
        *by_rate = part*f;
        *by_depth = slope*(1.0 + part*rate);
        break;
    default:
        break;
    }
    return lw_contact_force(c, phase, depth, rate, struck);
}

double lw_contact_within(const lw_clearance *c, lw_contact_phase phase, double depth)
{
    if (c->model == LW_CLEARANCE_MLSD)
        return INFINITY;
    if (phase == LW_CONTACT_APART)
        return -depth;
    return phase == LW_CONTACT_RISING ? fmin(depth, c->depth - depth) : lw_contact_rises(c) ? depth - c->depth : depth;
}

lw_contact_phase lw_contact_next(const lw_clearance *c, lw_contact_phase phase, double depth)
{
    bool rises = lw_contact_rises(c);
    if (phase == LW_CONTACT_APART)
        return rises ? LW_CONTACT_RISING : LW_CONTACT_FULL;
    if (phase == LW_CONTACT_RISING)
        return depth > 0.5*c->depth ? LW_CONTACT_FULL : LW_CONTACT_APART;
    return rises ? LW_CONTACT_RISING : LW_CONTACT_APART;
}

double lw_contact_energy(const lw_clearance *c, lw_contact_phase phase, double depth)
{
    if (phase == LW_CONTACT_APART)
        return 0.0;
    if (c->model == LW_CLEARANCE_MLSD)
        return 0.5*c->stiffness*depth*depth;
    return c->stiffness*power(depth, c->exponent)*depth/(c->exponent + 1.0);
}

double lw_contact_depth(const lw_clearance *c, double f)
{
    return f > 0.0 ? pow(f/c->stiffness, 1.0/(c->model == LW_CLEARANCE_MLSD ? 1.0 : c->exponent)) : 0.0;
}

double lw_contact_friction(const lw_clearance *c, double force, double slip)
{
    return c->friction > 0.0 ? c->friction*fabs(force)*tanh(slip/c->friction_speed) : 0.0;
}

static const char *const names[] = { "", "zero", "link", "mlsd", "impact", "hunt-crossley", "lankarani-nikravesh" };

const char *lw_clearance_name(lw_clearance_model m)
{
    return (size_t)m < sizeof names/sizeof *names ? names[m] : "";
}

lw_clearance_model lw_clearance_named(const char *name)
{
    for (size_t i = 1; i < sizeof names/sizeof *names; i++)
        if (strcmp(names[i], name) == 0)
            return (lw_clearance_model)i;
    return LW_CLEARANCE_NONE;
}

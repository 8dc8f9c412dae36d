#include "mbs/dynamics/contact.h"

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

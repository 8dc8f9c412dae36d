/* mbs/dynamics/dynamics_stiffness.c - how fast a model decays and vibrates, which the choice of a formulation asks. */
#include "base/real.h"
#include "base/vector.h"
#include "mbs/dynamics/dynamics_equations_internal.h"

#include <string.h>

/* Fastest decay by dampers times the length of the run; above this an explicit method takes too many steps. */
static const double damped = 300, damped_reduced = 3e3;      /* the same where an implicit method of high order serves; of one coordinate */
static const double stiff = 1e4, stiff_space = 1e6;          /* where no implicit method with exact derivatives is known */
/* Where springs vibrate by so many radians in a run, an implicit method is faster if dampers end the vibrations or nothing excites them;
 * if it is not, it goes on by the explicit one (mbs/formulations/radau.c). */
static const double vibrating = 2e3;
/* Decay of first-order states times the length of the run above which an implicit method takes less time for the same error than
 * the explicit one of order 8: more at tighter tolerances, which cost it more steps but the explicit one, whose steps are short for
 * stability, none.  Measured for motors and controllers from 600 to 8000: damped_states at states_at, times this power of the tolerance. */
static const double damped_states = 640, states_at = 1e-3, states_power = 0.15;
static const double at_limit = 4;            /* decay times the length of explicit steps which it limits: 6, less where lengths vary */
static const double may_limit = 0.5, worth = 150;        /* the same where it may limit them, at small tolerances; steps left */
enum { most_looked = 400 };              /* dampers and motors that are looked at, evenly spread */

/* The fastest decay of a state by itself: the greatest derivative of a rate by its own state. */
typedef struct own_decay { int n_v; double most; } own_decay;

static void no_force(void *context, int row, int column, double by_q, double by_v)
{
    (void)context, (void)row, (void)column, (void)by_q, (void)by_v;
}

static void see_state(void *context, int row, int column, double by_q, double by_v)
{
    own_decay *o = context;
    (void)by_v;
    if (row == column && row >= o->n_v)
        o->most = fmax(o->most, -by_q);
}

enum { PASSES = 12 };                    /* of the power method for the fastest decay or vibration */

bool lw_mbs_friction_is_stiff(lw_dynamics *d)
{
    static const double slow = 1e-9;         /* greatest velocity at which the joints slip: all of them rub in proportion to it */
    double load = 0, decay = 0, *u = d->v_try;
    if (lw_mbs_rows(d, d->o.from, d->start_q) != LW_OK || lw_mbs_factor(d, false) != LW_OK)
        return true;
    d->eq.forces(d->eq.context, d->o.from, d->start_q, d->start_v, d->force, NULL);
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    if (lw_mbs_linear(d, d->force, d->rhs, d->a, d->l) != LW_OK)
        return true;
    for (int j = 0; j < d->n_friction; j++)
        load = fmax(load, 2*lw_mbs_reaction(d, j));
    for (int i = 0; i < d->n_v; i++)
        u[i] = slow*(fmod(0.6180339887498949*(i + 1), 1) - 0.5);
    for (int pass = 0; pass < PASSES; pass++) {
        memset(d->force, 0, (size_t)d->n_v*sizeof *d->force);
        for (int j = 0; j < d->n_friction; j++) {
            lw_friction_joint f = d->friction[j];
            f.speed = f.speed > 0 ? f.speed : LW_FRICTION_SPEED;
            lw_mbs_rub_one(d, &f, d->start_q, u, load, d->force);
        }
        lw_mbs_impulse(d, d->force, d->small_v);
        decay = lw_greatest(d->n_v, d->small_v)/slow;
        for (int i = 0; i < d->n_v; i++)
            u[i] = decay > 0 ? d->small_v[i]/decay : 0;
    }
    return !(decay*(d->o.to - d->o.from) <= stiff);
}

/* Forces on the velocities by a change of places or of velocities. */
typedef struct response { int n; bool by_v; const double *change; double *force; } response;

static void add_response(void *context, int row, int column, double by_q, double by_v)
{
    response *r = context;
    if (row < r->n && column < r->n)
        r->force[row] += (r->by_v ? by_v : by_q)*r->change[column];
}

double lw_mbs_fastest(lw_dynamics *d, double t, const double *q, const double *v, bool by_v, bool rubs)
{
    double *u = d->v_try, *force = d->a, size = 0;
    response r = { d->n_v, by_v, u, force };
    if (lw_mbs_rows(d, t, q) != LW_OK || lw_mbs_factor(d, false) != LW_OK)
        return 0;
    for (int i = 0; i < d->n_v; i++)
        u[i] = fmod(0.6180339887498949*(i + 1), 1) - 0.5;
    for (int pass = 0; pass < PASSES; pass++) {
        double most = 0;
        for (int i = 0; i < d->n_v; i++)
            most = fmax(most, fabs(u[i]));
        bool known = pass > 1 && fabs(most - size) <= 1e-3*most;
        size = pass ? most : 0;
        if (known || !(most > 0 && most < INFINITY))
            break;
        for (int i = 0; i < d->n_v; i++)
            u[i] /= most;
        memset(force, 0, (size_t)d->n_v*sizeof *force);
        d->eq.derivatives(d->eq.context, t, q, v, d->force, &(lw_force_sink){ &r, add_response, NULL });
        if (rubs)
            lw_mbs_rub_slopes(d, q, v, &(lw_force_sink){ &r, add_response, NULL });
        lw_mbs_impulse(d, force, d->small_v);
        memcpy(u, d->small_v, (size_t)d->n_v*sizeof *u);
    }
    return size;
}

static bool knows_dampers_together(const lw_dynamics *d) { return !d->space && d->eq.exact && !d->o.force.apply; }

double lw_mbs_fastest_decay(lw_dynamics *d, double t, const double *q, const double *v, bool rubs)
{
    bool together = rubs || knows_dampers_together(d), looks = !together && d->eq.n_damper > 0;
    double most = together ? lw_mbs_fastest(d, t, q, v, true, rubs) : 0, *g = d->small_v, *change = d->v_try;
    if (looks && (lw_mbs_rows(d, t, q) != LW_OK || lw_mbs_factor(d, false) != LW_OK))
        return 0;
    for (int k = 0; k < d->eq.n_damper && looks; k += 1 + d->eq.n_damper/most_looked) {
        memset(g, 0, (size_t)d->n_v*sizeof *g);
        double c = d->eq.damper(d->eq.context, k, q, v, g);
        most = fmax(most, c > 0 ? c*lw_mbs_impulse(d, g, change) : 0);
    }
    own_decay own = { d->n_v, most };
    if (d->eq.n_z)
        d->eq.derivatives(d->eq.context, t, q, v, d->force, &(lw_force_sink){ &own, no_force, see_state });
    return own.most;
}

bool lw_mbs_is_stiff(lw_dynamics *d)
{
    if (!d->decay_known) {
        d->decay = lw_mbs_fastest_decay(d, d->o.from, d->start_q, d->start_v, false);
        d->frequency = knows_dampers_together(d) ? sqrt(lw_mbs_fastest(d, d->o.from, d->start_q, d->start_v, false, false)) : 0;
    }
    d->decay_known = true;
    return d->decay*(d->o.to - d->o.from) > (d->space ? stiff_space : stiff);
}

bool lw_mbs_became_stiff(lw_dynamics *d, double t, const double *q, const double *v, double h, bool returns)
{
    bool rubs = returns && d->n_friction > 0;
    if (d->eq.conservative && d->eq.n_z == 0 && !rubs)
        return false;
    double decay = lw_mbs_fastest_decay(d, t, q, v, rubs), left = d->o.to - t;
    return returns ? decay*h > may_limit && left > worth*h : decay*h > at_limit && decay*left > (d->space ? stiff_space : stiff);
}

bool lw_mbs_states_decay(lw_dynamics *d)
{
    return !d->space && !d->large && d->eq.n_z && !d->n_friction && !d->touch
        && (lw_mbs_is_stiff(d) || d->decay*(d->o.to - d->o.from) > damped_states*pow(states_at/d->o.relative, states_power));
}

bool lw_mbs_is_damped(lw_dynamics *d, bool reduced)
{
    if (lw_mbs_is_stiff(d) || d->space)
        return lw_mbs_is_stiff(d);
    return !d->n_friction && !d->n_stop && !d->touch && !d->has_zero_mass && !d->s.n_tie && !d->n_driven && d->eq.exact
        && (d->decay*(d->o.to - d->o.from) > (reduced ? damped_reduced : damped) || (!reduced && lw_mbs_vibrates(d)));
}

bool lw_mbs_vibrates(lw_dynamics *d)
{
    lw_mbs_is_stiff(d);                      /* for its frequency */
    return d->frequency*(d->o.to - d->o.from) > vibrating;
}

bool lw_mbs_has_derivatives(const lw_dynamics *d)
{
    bool slide = false;
    for (int i = 0; i < d->n_driven && !d->space; i++)
        slide = slide || !lw_joint_turns(d->s.joint[d->driven_measure[i]].kind);
    return d->eq.exact && !d->n_friction && (d->space || (d->large ? !slide : d->n_c == d->n_row));
}

bool lw_mbs_suits_ggl(lw_dynamics *d)
{
    return !d->space && !d->large && d->n_stop == 0 && !d->touch && lw_mbs_has_derivatives(d) && lw_mbs_is_stiff(d);
}

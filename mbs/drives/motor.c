#include "mbs/drives/motor.h"

#include <stdlib.h>
#include "base/real.h"

const char *lw_drive_limit_text(int limit)
{
    static const char *const texts[] = {
#define X(name, text) text,
        LW_DRIVE_LIMIT_LIST(X)
#undef X
    };
    return limit >= 0 && limit < LW_DRIVE_N_LIMIT ? texts[limit] : "";
}

/* x on both sides of the kink in the interval before sample k, straight on from the intervals beside it, and the share of the interval
 * before the kink.  Without one the end of the interval, x[k] twice. */
typedef struct two_sides { double share, before, behind; } two_sides;

static two_sides sides(const lw_load *l, const double *x, size_t k)
{
    double c = l->kink ? l->kink[k] : 0;
    if (!(c > 0))
        return (two_sides){ 1, x[k], x[k] };
    double rise = k > 1 && !(l->kink[k - 1] > 0) ? x[k - 1] - x[k - 2] : 0;
    double fall = k + 1 < l->n && !(l->kink[k + 1] > 0) ? x[k + 1] - x[k] : 0;
    return (two_sides){ c, x[k - 1] + c*rise, x[k] - (1 - c)*fall };
}

/* Mean square over the interval before sample k. */
static double mean_square(const lw_load *l, const double *x, size_t k)
{
    two_sides s = sides(l, x, k);
    double a = x[k - 1], b = s.before, c = s.behind, d = x[k];
    return (s.share*(a*a + a*b + b*b) + (1 - s.share)*(c*c + c*d + d*d))/3;
}

/* Greatest |x| of sample k and of the kink before it. */
static double greatest(const lw_load *l, const double *x, size_t k)
{
    two_sides s = k > 0 ? sides(l, x, k) : (two_sides){ 1, x[k], x[k] };
    return fmax(fabs(x[k]), fmax(fabs(s.before), fabs(s.behind)));
}

/* Power that goes straight from a to b during a time. */
static void add_energy(lw_load_figures *f, double a, double b, double time)
{
    double cross = a != b ? a/(a - b) : 0;                     /* where it changes its sign */
    if (a*b < 0) {
        *(a > 0 ? &f->energy_out : &f->energy_back) += fabs(a)*cross/2*time;
        *(b > 0 ? &f->energy_out : &f->energy_back) += fabs(b)*(1 - cross)/2*time;
    } else
        *(a + b > 0 ? &f->energy_out : &f->energy_back) += fabs(a + b)/2*time;
}

lw_load_figures lw_load_figures_of(const lw_load *l)
{
    lw_load_figures f = { .power_least = INFINITY, .power_peak = -INFINITY };
    double square = 0;
    for (size_t i = 0; i < l->n; i++) {
        double power[4] = { 0, l->speed[i]*l->torque[i], l->speed[i]*l->torque[i], l->speed[i]*l->torque[i] }, share = 1;
        if (i > 0) {
            two_sides torque = sides(l, l->torque, i);
            double speed = sides(l, l->speed, i).behind;          /* the speed does not step */
            power[0] = l->speed[i - 1]*l->torque[i - 1];
            power[1] = speed*torque.before;
            power[2] = speed*torque.behind;
            share = torque.share;
            square += mean_square(l, l->torque, i);
            add_energy(&f, power[0], power[1], share*l->step);
            add_energy(&f, power[2], power[3], (1 - share)*l->step);
        }
        f.torque_peak = fmax(f.torque_peak, greatest(l, l->torque, i));
        f.speed_peak = fmax(f.speed_peak, fabs(l->speed[i]));
        for (int k = 1; k < 4; k++) {
            f.power_peak = fmax(f.power_peak, power[k] + 0.0);    /* no -0 */
            f.power_least = fmin(f.power_least, power[k] + 0.0);
        }
    }
    double time = (double)(l->n - 1)*l->step, energy = f.energy_out - f.energy_back;
    f.torque_rms = sqrt(square*l->step/time);
    f.power_mean = fabs(energy) > 1e-12*f.energy_out ? energy/time : 0;
    return f;
}

/* ---- one choice ------------------------------------------------------------------------------------ */

static void limit(lw_drive_choice *c, int which, double value, double most)
{
    if (!(most > 0))
        return;
    c->use[which] = value/most;
    c->worst = fmax(c->worst, c->use[which]);
    if (c->use[which] > 1 + 1e-12)
        c->fails |= 1u << which;
}

const lw_gear_part *lw_drive_gear(const lw_drive_parts *p, int gear)
{
    static const lw_gear_part none = { .name = "(none)", .ratio = 1 };
    return gear >= 0 ? &p->gear[gear] : &none;
}

double lw_drive_torque(const lw_load *l, size_t k, double ratio, double efficiency, double inertia)
{
    double through = l->torque[k]*l->speed[k] >= 0 ? l->torque[k]/efficiency : l->torque[k]*efficiency;
    return through/ratio + inertia*ratio*l->acceleration[k];
}

/* Greatest voltage R I + Kt w + L dI/dt, in the middle of each interval.  Where the torque steps (it changes over one interval
 * by more than 8 times as much as over those beside it) the current cannot follow: L dI/dt is left out there, as it is
 * everywhere if the inductance is not known. */
static double voltage_of(const lw_motor_part *m, size_t n, double step, const double *torque, const double *speed, int *steps)
{
    double most = 0, peak = 0, r = m->resistance/m->torque_constant, l = m->inductance/m->torque_constant/step;
    *steps = 0;
    for (size_t k = 0; k < n; k++) {
        if (l == 0)
            most = fmax(most, fabs(r*torque[k] + m->torque_constant*speed[k]));
        peak = fmax(peak, fabs(torque[k]));
    }
    for (size_t k = 0; l > 0 && k + 1 < n; k++) {
        double change = torque[k + 1] - torque[k], before = k > 0 ? fabs(torque[k] - torque[k - 1]) : INFINITY;
        double after = k + 2 < n ? fabs(torque[k + 2] - torque[k + 1]) : INFINITY;
        if (k == 0 || k + 2 == n)                          /* an end has one neighbour */
            before = after = fmin(before, after);
        bool jumps = n > 8 && fabs(change) > 8*fmax(before, after) && fabs(change) > 0.01*peak;
        *steps += jumps;
        for (int i = 0; i < 2 && jumps; i++)
            most = fmax(most, fabs(r*torque[k + i] + m->torque_constant*speed[k + i]));
        if (!jumps)
            most = fmax(most, fabs(r*(torque[k] + torque[k + 1])/2 + m->torque_constant*(speed[k] + speed[k + 1])/2 + l*change));
    }
    return most;
}

lw_drive_choice lw_drive_try(const lw_load *l, const lw_drive_parts *p, int motor, int gear, int amplifier,
                             double greatest_inertia, double *work)
{
    const lw_motor_part *m = &p->motor[motor];
    const lw_gear_part *g = lw_drive_gear(p, gear);
    const lw_amplifier_part *a = amplifier >= 0 ? &p->amplifier[amplifier] : NULL;
    lw_drive_choice c = { .motor = motor, .gear = gear, .amplifier = amplifier };
    double efficiency = g->efficiency > 0 ? g->efficiency : 1, inertia = m->inertia + g->inertia;
    double square = 0, out_square = 0, out_peak = 0, wheel = l->slides ? g->radius : 1;
    for (int i = 0; i < LW_DRIVE_N_LIMIT; i++)
        c.use[i] = NAN;
    c.ratio = l->slides ? g->ratio/g->radius : g->ratio;
    for (size_t k = 0; k < l->n; k++) {
        double torque = lw_drive_torque(l, k, c.ratio, efficiency, inertia), speed = c.ratio*l->speed[k];
        work[k] = torque;
        work[l->n + k] = speed;
    }
    for (size_t k = 0; k < l->n; k++) {
        c.torque_peak = fmax(c.torque_peak, greatest(l, work, k));
        c.speed = fmax(c.speed, fabs(work[l->n + k]));
        out_peak = fmax(out_peak, wheel*greatest(l, l->torque, k));
        square += k > 0 ? mean_square(l, work, k) : 0;
        out_square += k > 0 ? wheel*wheel*mean_square(l, l->torque, k) : 0;
    }
    c.torque_rms = sqrt(square/(double)(l->n - 1));
    c.current_peak = c.torque_peak/m->torque_constant;
    c.current_rms = c.torque_rms/m->torque_constant;
    c.voltage = voltage_of(m, l->n, l->step, work, work + l->n, &c.torque_steps);
    c.heat = m->resistance*c.current_rms*c.current_rms;
    c.inertia_ratio = l->inertia[1]/(c.ratio*c.ratio*inertia);
    limit(&c, LW_DRIVE_SPEED, c.speed, m->speed);
    limit(&c, LW_DRIVE_PEAK, c.torque_peak, m->torque_peak > 0 ? m->torque_peak : 3*m->torque);
    limit(&c, LW_DRIVE_RMS, c.torque_rms, m->torque);
    limit(&c, LW_DRIVE_GEAR_SPEED, c.speed, g->speed);
    limit(&c, LW_DRIVE_GEAR_PEAK, out_peak, g->torque_peak);
    limit(&c, LW_DRIVE_GEAR_RMS, sqrt(out_square/(double)(l->n - 1)), g->torque);
    if (isfinite(greatest_inertia) && !isnan(c.inertia_ratio))
        limit(&c, LW_DRIVE_INERTIA, c.inertia_ratio, greatest_inertia);
    if (a) {
        double peak = a->current_peak > 0 ? a->current_peak : a->current, room
            = (peak*peak - a->current*a->current)*a->peak_time;
        double charge = 0, most = 0;
        for (int cycle = 0; cycle < 2 && room > 0; cycle++)         /* the second cycle begins charged */
            for (size_t k = 0; k + 1 < l->n; k++) {
                double i = work[k]/m->torque_constant;
                charge = fmax(0, charge + (i*i - a->current*a->current)*l->step);
                most = fmax(most, charge);
            }
        c.i2t = room > 0 ? most/room : 0;
        limit(&c, LW_DRIVE_VOLTAGE, c.voltage, a->voltage);
        limit(&c, LW_DRIVE_CURRENT, c.current_peak, peak);
        limit(&c, LW_DRIVE_CURRENT_RMS, c.current_rms, a->current);
        limit(&c, LW_DRIVE_HEAT, most, room);
    }
    double price = m->price + g->price + (a ? a->price : 0), mass = m->mass + g->mass + (a ? a->mass : 0);
    c.cost = m->price > 0 ? price : m->mass > 0 ? mass : m->torque*m->speed;
    return c;
}

static int by_rank(const void *a, const void *b)
{
    const lw_drive_choice *x = a, *y = b;
    if (!x->fails != !y->fails)
        return x->fails ? 1 : -1;
    double dx = x->fails ? x->worst : x->cost, dy = y->fails ? y->worst : y->cost;
    if (dx != dy)
        return dx < dy ? -1 : 1;
    if (x->worst != y->worst)
        return x->worst < y->worst ? -1 : 1;
    return x->motor != y->motor ? x->motor - y->motor : x->gear != y->gear ? x->gear - y->gear
        : x->amplifier - y->amplifier;
}

lw_status lw_drive_choose(const lw_load *l, const lw_drive_parts *p, double greatest_inertia, const volatile int *stop, size_t *n,
                          lw_drive_choice **out, bool **front, lw_error *e)
{
    size_t amplifiers = p->n_amplifier > 0 ? (size_t)p->n_amplifier : 1, room
        = (size_t)p->n_motor*(size_t)(p->n_gear ? p->n_gear : 1)*amplifiers;
    *n = 0;
    *out = malloc((room + 1)*sizeof **out);
    *front = calloc(room + 1, sizeof **front);
    double *work = malloc(2*(l->n + 1)*sizeof *work);
    if (!*out || !*front || !work) {
        free(work);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    for (int m = 0; m < p->n_motor; m++)
        for (int g = p->n_gear ? 0 : -1; g < p->n_gear; g++)
            for (int a = p->n_amplifier ? 0 : -1; a < p->n_amplifier && !(stop && *stop); a++)
                if (!l->slides == !(lw_drive_gear(p, g)->radius > 0))          /* a wheel for a slider, none for a turn */
                    (*out)[(*n)++] = lw_drive_try(l, p, m, g, a, greatest_inertia, work);
    qsort(*out, *n, sizeof **out, by_rank);
    double least = INFINITY;
    for (size_t i = 0; i < *n && !(*out)[i].fails; i++)
        if ((*out)[i].worst < least) {
            (*front)[i] = true;
            least = (*out)[i].worst;
        }
    free(work);
    return stop && *stop ? lw_error_set(e, LW_STOPPED, "stopped after %zu of %zu choices", *n, room) : LW_OK;
}

/* ---- paper D ------------------------------------------------------------------------------------------ */

static double acceleration_at(const lw_motor_part *m, double mass, double r) { return m->torque*r/(m->inertia
    + mass*r*r); }

static double time_at(const lw_motor_part *m, double mass, double way, double r)
{
    double v = m->speed*r, a = acceleration_at(m, mass, r);
    return way >= v*v/a ? way/v + v/a : 2*sqrt(way/a);
}

lw_radius lw_radius_at(const lw_motor_part *m, double mass, double way, double limit_, double r)
{
    double v = m->speed*r;
    return (lw_radius){ .r = r, .alpha = m->torque/(m->inertia + mass*r*r), .speed = v,
                        .efficiency = 1/(1 + m->inertia/(mass*r*r)), .printed_way = v*v/limit_, .printed_time
                            = 2*v/limit_,
                        .acceleration = acceleration_at(m, mass, r), .time = time_at(m, mass, way, r) };
}

double lw_radius_printed(const lw_motor_part *m, double limit_) { return limit_*m->inertia/m->torque; }

double lw_radius_of_way(const lw_motor_part *m, double mass, double way)
{
    return pow(way*m->torque/(2*m->speed*m->speed*mass), 1/3.0);
}

double lw_radius_of_acceleration(const lw_motor_part *m, double mass) { return sqrt(m->inertia/mass); }

/* The time falls to one minimum: at the radius of greatest acceleration if the motor never reaches its speed there,
 * else between it and where the printed formula is, or where the speed is just reached. */
double lw_radius_best(const lw_motor_part *m, double mass, double way)
{
    double low = lw_radius_of_acceleration(m, mass)*1e-3, high = lw_radius_of_acceleration(m, mass)*1e3, golden
        = (sqrt(5) - 1)/2;
    double a = log(low), b = log(high);
    for (int i = 0; i < 200; i++) {
        double x = b - golden*(b - a), y = a + golden*(b - a);
        if (time_at(m, mass, way, exp(x)) < time_at(m, mass, way, exp(y)))
            b = y;
        else
            a = x;
    }
    return exp((a + b)/2);
}

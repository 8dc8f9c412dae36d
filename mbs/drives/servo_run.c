/* mbs/drives/servo_run.c - see servo_run.h.
 *
 *     Mm vm' = K i/r - friction - f,  M v' = f - friction + force,  f = c gap(xm - x) + d (vm - v) in contact,
 *     L i' = u - R i - K vm/r
 *
 * xm, vm: motor seen at the load by the factor r; rigid: one mass Mm + M.  The position controller wants the speed
 * p e + share v_wanted, the speed controller the acceleration P e + I, which gives a current; the current controller
 * gives the voltage.  At a limit the integrals follow back in their own time I/P. */
#include "mbs/drives/servo_run.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vec2.h"
#include "mbs/drives/servo_internal.h"

/* ---- equations ------------------------------------------------------------------------------------------- */

lw_servo_axis lw_servo_axis_of(const lw_servo *s, bool linear)
{
    double motor = s->inertia/(s->factor*s->factor);
    return (lw_servo_axis){ .s = s, .linear = linear, .motor_mass = motor, .mass = motor + s->load };
}

static double friction(const lw_servo_axis *a, const lw_servo_friction *f, double v)
{
    if (a->linear || !(f->breakaway > 0 || f->coulomb > 0))
        return f->viscous*v;
    double slow = v/f->stribeck, dry = f->coulomb;
    if (f->breakaway != f->coulomb)
        dry += (f->breakaway - f->coulomb)*exp(-slow*slow);
    return dry*tanh(v/f->smoothing) + f->viscous*v;
}

static lw_axis_state wanted(const lw_servo_axis *a, double t) { return a->linear ? a->wanted : lw_servo_wanted(a->s, t); }

static double measured_position(const lw_servo_axis *a, const double *y)
{
    const lw_servo *s = a->s;
    double x = s->encoder_at_load && s->elastic ? y[LW_SERVO_X] : y[LW_SERVO_XM];
    if (a->linear || !(s->encoder > 0))
        return x;
    double step = (s->encoder_at_load ? s->slides ? 1 : 2*LW_PI : 2*LW_PI*s->factor)/s->encoder;
    return floor(x/step)*step;
}

/* The speed at a sample: from two positions where they have steps. */
static double measured_speed(const lw_servo_axis *a, const double *y)
{
    const lw_servo *s = a->s;
    if (s->encoder > 0)
        return (measured_position(a, y) - a->held[LW_HELD_POSITION])/s->speed.sample;
    return s->encoder_at_load && s->elastic ? y[LW_SERVO_V] : y[LW_SERVO_VM];
}

static double limit(const lw_servo_axis *a, double x, double most)
{
    return a->linear ? x : fmin(fmax(x, -most), most);
}

static double want_speed(const lw_servo_axis *a, double t, const double *y)
{
    lw_axis_state w = wanted(a, t);
    return a->s->position.proportional*(w.x - measured_position(a, y)) + a->s->speed_feed_forward*w.v;
}

/* Current for the wanted acceleration.  *excess: limited less unlimited acceleration. */
static double want_current(const lw_servo_axis *a, double t, const double *y, double sum, double *error, double *excess)
{
    const lw_servo *s = a->s;
    double speed = s->position.sample > 0 ? a->held[LW_HELD_SPEED] : want_speed(a, t, y);
    double by_current = s->constant/s->factor/a->mass;     /* acceleration of 1 A */
    *error = speed - measured_speed(a, y);
    double acceleration = s->speed.proportional**error + sum;
    if (s->acceleration_feed_forward > 0)
        acceleration += s->acceleration_feed_forward*wanted(a, t).a;
    double free = acceleration/by_current, current = limit(a, free, s->current);
    *excess = (current - free)*by_current;
    return current;
}

static double current_of(const lw_servo_axis *a, double t, const double *y)
{
    double error, excess;
    return a->s->speed.sample > 0 ? a->held[LW_HELD_CURRENT]
         : want_current(a, t, y, y[LW_SERVO_SUM_S], &error, &excess);
}

static double want_voltage(const lw_servo_axis *a, double t, const double *y, double sum, double *error, double *excess)
{
    const lw_servo *s = a->s;
    *error = current_of(a, t, y) - y[LW_SERVO_I];
    double free = s->circuit.proportional**error + sum;
    if (s->emf_compensation)
        free += s->constant/s->factor*y[LW_SERVO_VM];
    double u = limit(a, free, s->voltage);
    *excess = u - free;
    return u;
}

/* Share of an integral that follows a limit. */
static double back(const lw_servo_loop *l, double excess)
{
    return l->proportional > 0 ? excess*l->integral/l->proportional : 0;
}

void lw_servo_outputs(const lw_servo_axis *a, double t, const double *y, double *current, double *voltage, bool limited[2])
{
    const lw_servo *s = a->s;
    double error, excess;
    *current = s->ideal_current ? current_of(a, t, y) : y[LW_SERVO_I];
    if (s->ideal_current)
        *voltage = s->resistance**current + s->constant/s->factor*y[LW_SERVO_VM];
    else
        *voltage = s->circuit.sample > 0 ? a->held[LW_HELD_VOLTAGE]
                 : want_voltage(a, t, y, y[LW_SERVO_SUM_C], &error, &excess);
    limited[0] = fabs(current_of(a, t, y)) >= s->current;
    limited[1] = fabs(*voltage) >= s->voltage;
}

void lw_servo_rates(const lw_servo_axis *a, double t, const double *y, double *dy)
{
    const lw_servo *s = a->s;
    double i, u, error, excess, coupling = 0, rub = 0, force = a->force, vm = y[LW_SERVO_VM];
    bool limited[2];
    memset(dy, 0, LW_SERVO_N*sizeof *dy);
    lw_servo_outputs(a, t, y, &i, &u, limited);
    if (!a->linear && s->force)
        force = lw_expression_value(s->force, &t);
    double lost = friction(a, &s->motor, vm/s->factor)/s->factor, push = s->constant/s->factor*i - lost;
    rub = lost*vm;
    if (s->elastic) {
        double d = y[LW_SERVO_XM] - y[LW_SERVO_X], v = y[LW_SERVO_V], half = a->linear ? 0 : s->backlash/2;
        double gap = d > half ? d - half : d < -half ? d + half : 0, damper = gap != 0 || half == 0 ? s->damping*(vm - v) : 0;
        double load = friction(a, &s->friction, v);
        coupling = s->stiffness*gap + damper;
        dy[LW_SERVO_X] = v;
        dy[LW_SERVO_V] = (coupling - load + force)/s->load;
        dy[LW_SERVO_TRANSMISSION] = damper*(vm - v);
        dy[LW_SERVO_WORK] = force*v;
        rub += load*v;
        dy[LW_SERVO_VM] = (push - coupling)/a->motor_mass;
    } else {
        double load = friction(a, &s->friction, vm);
        rub += load*vm;
        dy[LW_SERVO_WORK] = force*vm;
        dy[LW_SERVO_VM] = (push - load + force)/a->mass;
    }
    dy[LW_SERVO_XM] = vm;
    if (s->speed.sample == 0) {
        want_current(a, t, y, y[LW_SERVO_SUM_S], &error, &excess);
        dy[LW_SERVO_SUM_S] = s->speed.integral*error + back(&s->speed, excess);
    }
    if (!s->ideal_current) {
        dy[LW_SERVO_I] = (u - s->resistance*i - s->constant/s->factor*vm)/s->inductance;
        if (s->circuit.sample == 0) {
            want_voltage(a, t, y, y[LW_SERVO_SUM_C], &error, &excess);
            dy[LW_SERVO_SUM_C] = s->circuit.integral*error + back(&s->circuit, excess);
        }
    }
    dy[LW_SERVO_ELECTRICAL] = u*i;
    dy[LW_SERVO_HEAT] = s->resistance*i*i;
    dy[LW_SERVO_FRICTION] = rub;
    dy[LW_SERVO_SQUARE] = i*i;
}

/* ---- samples ---------------------------------------------------------------------------------------------- */

static const lw_servo_loop *loop_of(const lw_servo *s, int k) { return k == 0 ? &s->position : k == 1 ? &s->speed : &s->circuit; }

static bool is_sampled(const lw_servo *s, int k) { return loop_of(s, k)->sample > 0 && !(k == 2 && s->ideal_current); }

static double next_sample(const lw_servo_axis *a, int k)
{
    return is_sampled(a->s, k) ? a->n_sample[k]*loop_of(a->s, k)->sample : INFINITY;
}

/* The next time at which a controller samples or its output changes, from n_sample and pending; infinite: none. */
static double next_event(const lw_servo_axis *a)
{
    double t = INFINITY;
    for (int k = 0; k < 3; k++) {
        t = fmin(t, next_sample(a, k));
        t = a->pending[k].is ? fmin(t, a->pending[k].t) : t;
    }
    return t;
}

static void sample(lw_servo_axis *a, int k, double t, const double *y)
{
    const lw_servo_loop *l = loop_of(a->s, k);
    double error = 0, excess = 0, value;
    if (k == 0)
        value = want_speed(a, t, y);
    else if (k == 1) {
        value = want_current(a, t, y, a->held[LW_HELD_SUM_S], &error, &excess);
        a->held[LW_HELD_SUM_S] += l->sample*(l->integral*error + back(l, excess));
        a->held[LW_HELD_POSITION] = measured_position(a, y);
    } else {
        value = want_voltage(a, t, y, a->held[LW_HELD_SUM_C], &error, &excess);
        a->held[LW_HELD_SUM_C] += l->sample*(l->integral*error + back(l, excess));
    }
    a->n_sample[k]++;
    if (l->delay > 0) {
        a->pending[k].is = true;
        a->pending[k].t = t + l->delay;
        a->pending[k].value = value;
    } else
        a->held[LW_HELD_SPEED + k] = value;
}

/* Times that differ by rounding are one. */
static double same(double t) { return 1e-12*(fabs(t) + 1e-6); }

/* Outputs that are due at t, then samples unless `last`. */
static void pass_events(lw_servo_axis *a, double t, const double *y, bool last)
{
    double now = t + same(t);
    for (int k = 0; k < 3; k++)
        if (a->pending[k].is && a->pending[k].t <= now) {
            a->held[LW_HELD_SPEED + k] = a->pending[k].value;
            a->pending[k].is = false;
        }
    for (int k = 0; k < 3 && !last; k++)                  /* the outer controller first */
        if (next_sample(a, k) <= now)
            sample(a, k, t, y);
}

static const double absurd = 1e100;

static lw_status rate(void *context, double t, const double *y, double *dy)
{
    lw_servo_rates(context, t, y, dy);
    for (int i = 0; i < LW_SERVO_N; i++)
        if (!(fabs(dy[i]) < absurd))                       /* squares of errors of steps stay finite */
            return LW_E_NUMERIC;
    return LW_OK;
}

lw_status lw_servo_integrate(lw_servo_axis *a, double t, double end, double tolerance, double *y, lw_servo_seen *seen,
                             void *context, long *steps, lw_error *e)
{
    lw_ode ode = { .n = LW_SERVO_N, .context = a, .rate = rate };
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    double *work = calloc(lw_integrate_work(ode.n, 0), sizeof *work);
    if (!work)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    o.relative = tolerance;
    o.absolute = 1e-3*tolerance;                          /* ways are fractions of a metre */
    o.max_step = 0;
    pass_events(a, t, y, false);
    lw_status s = lw_integrate_start(&w, &ode, &o, work, t, y, e);
    while (s == LW_OK && w.t < end) {
        double kink = a->linear ? INFINITY : lw_servo_next_kink(a->s, w.t + same(w.t)), event = next_event(a);
        double until = fmin(kink, event);
        until = until > end - same(end) ? end : until;
        lw_ode_stop stop = LW_ODE_STEP;
        while (s == LW_OK && stop != LW_ODE_END) {
            s = lw_integrate_step(&w, until, &stop, e);
            if (s == LW_OK && seen)
                s = seen(context, &w);
        }
        if (s != LW_OK || !(until < end))
            break;
        pass_events(a, until, w.y, false);
        s = lw_integrate_restart(&w, NULL, e);
    }
    if (s == LW_OK) {
        memcpy(y, w.y, LW_SERVO_N*sizeof *y);
        pass_events(a, end, y, true);
    }
    *steps += w.n_step;
    free(work);
    return s;
}

/* ---- a run -------------------------------------------------------------------------------------------------- */

lw_servo_options lw_servo_options_default(void)
{
    return (lw_servo_options){ .intervals = 1000, .tolerance = 1e-9, .band = 1e-3 };
}

typedef struct watcher {
    lw_servo_axis  *a;
    const lw_servo_options *o;
    lw_servo_callback  *sink;
    void           *context;
    lw_servo_report *r;
    int    next;                         /* row */
    double inside, last_t, last_size;    /* since when |error| is within the band; the last look at it */
} watcher;

static lw_servo_row row_at(const lw_servo_axis *a, double t, const double *y)
{
    const lw_servo *s = a->s;
    lw_servo_row row = { .t = t, .wanted = lw_servo_wanted(s, t), .motor_position = y[LW_SERVO_XM],
                         .motor_speed = y[LW_SERVO_VM], .heat = y[LW_SERVO_HEAT], .electrical = y[LW_SERVO_ELECTRICAL] };
    bool limited[2];
    row.position = y[s->elastic ? LW_SERVO_X : LW_SERVO_XM];
    row.speed = y[s->elastic ? LW_SERVO_V : LW_SERVO_VM];
    row.error = row.wanted.x - row.position;
    lw_servo_outputs(a, t, y, &row.current, &row.voltage, limited);
    row.torque = s->constant*row.current;
    return row;
}

static void look(watcher *w, double t, const double *y)
{
    lw_servo_report *r = w->r;
    const lw_servo *s = w->a->s;
    lw_servo_row row = row_at(w->a, t, y);
    bool limited[2];
    double current, voltage, size = fabs(row.error), dt = t - w->last_t;
    lw_servo_outputs(w->a, t, y, &current, &voltage, limited);
    r->current_limited += limited[0]*dt;
    r->voltage_limited += limited[1]*dt;
    if (size > r->error_peak)
        r->error_peak = size, r->error_peak_t = t;
    r->current_peak = fmax(r->current_peak, fabs(current));
    r->voltage_peak = fmax(r->voltage_peak, fabs(voltage));
    r->torque_peak = fmax(r->torque_peak, fabs(row.torque));
    r->speed_peak = fmax(r->speed_peak, fabs(row.motor_speed)/s->factor);
    if (s->moves.n && t >= s->moves.move[s->moves.n - 1].start) {
        const lw_move *m = &s->moves.move[s->moves.n - 1];
        r->overshoot = fmax(r->overshoot, (row.position - m->from - m->way)*(m->way < 0 ? -1 : 1));
    }
    if (size > w->o->band)
        w->inside = NAN;
    else if (isnan(w->inside))                             /* where the straight line between both looks enters */
        w->inside = w->last_size > w->o->band
                  ? w->last_t + dt*(w->last_size - w->o->band)/(w->last_size - size) : w->last_t;
    w->last_t = t;
    w->last_size = size;
}

/* Look at a step at even distances, and take the rows that lie in it. */
static lw_status see(void *context, lw_integrator *g)
{
    watcher *w = context;
    const lw_servo_options *o = w->o;
    double y[LW_SERVO_N];
    int n = (int)fmin(fmax(1, ceil((g->t - g->t_old)/2.5e-4)), 64);
    lw_status s = o->stop && *o->stop ? LW_STOPPED : LW_OK;
    for (int k = 1; s == LW_OK && k <= n; k++) {
        double t = k == n ? g->t : g->t_old + (g->t - g->t_old)*k/n;
        s = lw_integrate_dense(g, t, y);
        if (s == LW_OK)
            look(w, t, y);
    }
    while (s == LW_OK && w->next <= o->intervals && w->r->to*w->next/o->intervals <= g->t) {
        double t = w->next == o->intervals ? w->r->to : w->r->to*w->next/o->intervals;
        s = lw_integrate_dense(g, t, y);
        lw_servo_row row = row_at(w->a, t, y);
        if (s == LW_OK && w->sink)
            s = w->sink(w->context, &row);
        w->next++;
    }
    return s;
}

static double stored(const lw_servo_axis *a, const double *y)
{
    const lw_servo *s = a->s;
    double vm = y[LW_SERVO_VM], i = s->ideal_current ? 0 : y[LW_SERVO_I];
    double sum = 0.5*(s->elastic ? a->motor_mass : a->mass)*vm*vm + 0.5*s->inductance*i*i;
    if (s->elastic) {
        double d = fabs(y[LW_SERVO_XM] - y[LW_SERVO_X]) - s->backlash/2;
        sum += 0.5*s->load*y[LW_SERVO_V]*y[LW_SERVO_V] + (d > 0 ? 0.5*s->stiffness*d*d : 0);
    }
    return sum;
}

lw_status lw_servo_run(const lw_servo *s, const lw_servo_options *o, lw_servo_callback *sink, void *context,
                       lw_servo_report *r, lw_error *e)
{
    lw_servo_axis a = lw_servo_axis_of(s, false);
    lw_axis_state start = lw_servo_wanted(s, 0);
    double y[LW_SERVO_N] = { 0 };
    watcher w = { .a = &a, .o = o, .sink = sink, .context = context, .r = r, .next = 1, .inside = 0 };
    *r = (lw_servo_report){ .end = s->moves.end, .to = o->to > 0 ? o->to : s->moves.end > 0 ? 1.5*s->moves.end : 1 };
    y[LW_SERVO_XM] = y[LW_SERVO_X] = start.x;
    a.held[LW_HELD_POSITION] = measured_position(&a, y);
    double before = stored(&a, y);
    lw_servo_axis first = a;                               /* the row of t = 0 is after the first samples */
    pass_events(&first, 0, y, false);
    lw_servo_row row = row_at(&first, 0, y);
    w.last_size = fabs(row.error);
    lw_status status = sink ? sink(context, &row) : LW_OK;
    if (status == LW_OK)
        status = lw_servo_integrate(&a, 0, r->to, o->tolerance, y, see, &w, &r->steps, e);
    if (status == LW_STOPPED)
        return lw_error_set(e, status, "stopped at t = %.9g s", w.last_t);
    if (status != LW_OK)
        return lw_error_set(e, LW_E_NUMERIC, "at t = %.9g s the axis moves beyond all numbers, or faster than steps can follow", w.last_t);
    r->error_end = row_at(&a, r->to, y).error;
    r->settled = w.inside;
    r->current_rms = sqrt(y[LW_SERVO_SQUARE]/r->to);
    r->electrical = y[LW_SERVO_ELECTRICAL];
    r->heat = y[LW_SERVO_HEAT];
    r->friction = y[LW_SERVO_FRICTION];
    r->transmission = y[LW_SERVO_TRANSMISSION];
    r->work = y[LW_SERVO_WORK];
    r->stored = stored(&a, y) - before;
    r->energy_error = r->electrical + r->work - r->heat - r->friction - r->transmission - r->stored;
    return LW_OK;
}

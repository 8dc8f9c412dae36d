#include "mbs/drives/servo_linear.h"

#include <string.h>
#include "base/real_complex.h"
#include "base/vec2.h"
#include "mbs/drives/servo_internal.h"
#include "base/eigen.h"

/* ---- matrices ------------------------------------------------------------------------------------------------ */

static const char *const physical[LW_SERVO_PHYSICAL] = { "motor position", "motor speed", "position", "speed", "current",
                                                         "speed integral", "current integral" };
static const char *const held[LW_HELD_N] = { "wanted speed held", "wanted current held", "voltage held",
                                             "speed sum", "current sum", "position held" };

/* Unit of a state, input or output by its name, which ends alike for all of one unit. */
static const char *unit_of(const char *name, bool slides)
{
    static const struct { const char *end, *slide, *shaft; } units[] = {
        { "current integral", "V", "V" }, { "current sum", "V", "V" }, { "speed integral", "m/s^2", "rad/s^2" },
        { "speed sum", "m/s^2", "rad/s^2" }, { "acceleration", "m/s^2", "rad/s^2" }, { "position", "m", "rad" },
        { "position held", "m", "rad" }, { "speed", "m/s", "rad/s" }, { "speed held", "m/s", "rad/s" },
        { "current", "A", "A" }, { "current held", "A", "A" }, { "voltage", "V", "V" }, { "voltage held", "V", "V" },
        { "force", "N", "N" }, { "torque", "N m", "N m" } };
    for (size_t i = 0; i < sizeof units/sizeof *units; i++) {
        size_t n = strlen(name), k = strlen(units[i].end);
        if (n >= k && strcmp(name + n - k, units[i].end) == 0)
            return slides ? units[i].slide : units[i].shaft;
    }
    return "1";
}

static void add_units(lw_state_matrices *m, bool slides)
{
    for (int i = 0; i < m->n_state; i++)
        m->state_unit[i] = unit_of(m->state[i], slides);
    for (int i = 0; i < m->n_input; i++)
        m->input_unit[i] = unit_of(m->input[i], slides);
    for (int i = 0; i < m->n_output; i++)
        m->output_unit[i] = unit_of(m->output[i], slides);
}

/* States of the plant alone. */
static int plant_states(const lw_servo *s, int *which)
{
    int n = 0;
    which[n++] = LW_SERVO_XM;
    which[n++] = LW_SERVO_VM;
    if (s->elastic) {
        which[n++] = LW_SERVO_X;
        which[n++] = LW_SERVO_V;
    }
    if (!s->ideal_current)
        which[n++] = LW_SERVO_I;
    return n;
}

/* A column of the outputs: position, speed, motor position, motor speed, current, voltage. */
static void put_outputs(const lw_servo_axis *a, const double *y, lw_state_matrices *m, double *to, int stride, int column)
{
    bool limited[2];
    double out[6] = { y[a->s->elastic ? LW_SERVO_X : LW_SERVO_XM], y[a->s->elastic ? LW_SERVO_V : LW_SERVO_VM],
                      y[LW_SERVO_XM], y[LW_SERVO_VM] };
    lw_servo_outputs(a, 0, y, &out[4], &out[5], limited);
    for (int i = 0; i < m->n_output; i++)
        to[i*stride + column] = out[i];
}

static void name_outputs(lw_state_matrices *m, int n)
{
    static const char *const names[] = { "position", "speed", "motor position", "motor speed", "current", "voltage" };
    m->n_output = n;
    for (int i = 0; i < n; i++)
        m->output[i] = names[i];
}

void lw_servo_plant(const lw_servo *s, lw_state_matrices *m)
{
    lw_servo plant = *s;
    int which[LW_SERVO_PHYSICAL], n = plant_states(s, which);
    /* controllers that hold their outputs: the input */
    plant.speed.sample = plant.circuit.sample = 1;
    lw_servo_axis a = lw_servo_axis_of(&plant, true);
    double y[LW_SERVO_N] = { 0 }, dy[LW_SERVO_N];
    memset(m, 0, sizeof *m);
    m->n_state = n;
    m->n_input = 2;
    m->input[0] = s->ideal_current ? "current" : "voltage";
    m->input[1] = s->slides ? "force" : "torque";
    name_outputs(m, 5);
    for (int k = 0; k < n + 2; k++) {
        double *unit = k < n ? &y[which[k]] : k == n ? &a.held[s->ideal_current ? LW_HELD_CURRENT : LW_HELD_VOLTAGE] : &a.force;
        *unit = 1;
        lw_servo_rates(&a, 0, y, dy);
        for (int i = 0; i < n; i++)
            *(k < n ? &m->a[i*n + k] : &m->b[i*2 + k - n]) = dy[which[i]];
        if (k < n)
            put_outputs(&a, y, m, m->c, n, k);
        else
            put_outputs(&a, y, m, m->d, 2, k - n);
        *unit = 0;
    }
    for (int i = 0; i < n; i++)
        m->state[i] = physical[which[i]];
    add_units(m, s->slides);
}

/* The time after which all controllers sample together; 0: none samples; < 0: there is none. */
static double period_of(const lw_servo *s)
{
    const lw_servo_loop *loop[] = { &s->position, &s->speed, &s->circuit };
    double longest = 0;
    int n = s->ideal_current ? 2 : 3;
    for (int k = 0; k < n; k++)
        longest = fmax(longest, loop[k]->sample);
    for (int k = 0; k < n && longest > 0; k++) {
        double times = loop[k]->sample > 0 ? longest/loop[k]->sample : 1;
        if (fabs(times - rint(times)) > 1e-9*times)
            return -1;
    }
    return longest;
}

/* The unknowns of the whole: those of y, then those held.  A sum without a gain, and what is not used, stay away. */
static int whole_states(const lw_servo *s, int *which)
{
    int n = plant_states(s, which);
    bool circuit = !s->ideal_current;
    if (s->speed.sample == 0 && s->speed.integral > 0)
        which[n++] = LW_SERVO_SUM_S;
    if (circuit && s->circuit.sample == 0 && s->circuit.integral > 0)
        which[n++] = LW_SERVO_SUM_C;
    if (s->position.sample > 0)
        which[n++] = LW_SERVO_N + LW_HELD_SPEED;
    if (s->speed.sample > 0) {
        which[n++] = LW_SERVO_N + LW_HELD_CURRENT;
        if (s->speed.integral > 0)
            which[n++] = LW_SERVO_N + LW_HELD_SUM_S;
    }
    if (circuit && s->circuit.sample > 0) {
        which[n++] = LW_SERVO_N + LW_HELD_VOLTAGE;
        if (s->circuit.integral > 0)
            which[n++] = LW_SERVO_N + LW_HELD_SUM_C;
    }
    if (s->encoder > 0)
        which[n++] = LW_SERVO_N + LW_HELD_POSITION;
    return n;
}

static double *number_at(lw_servo_axis *a, double *y, int which)
{
    return which < LW_SERVO_N ? &y[which] : &a->held[which - LW_SERVO_N];
}

lw_status lw_servo_closed(const lw_servo *s, lw_state_matrices *m, lw_error *e)
{
    int which[LW_MATRIX_STATE_MAX], n = whole_states(s, which);
    double period = period_of(s);
    memset(m, 0, sizeof *m);
    if (period < 0)
        return lw_error_set(e, LW_E_KIND, "the longest sampling time is no multiple of the others: the whole has no period, and "
                            "its poles are not found");
    m->sample = period;
    m->n_state = n;
    m->n_input = 4;
    for (int i = 0; i < n; i++)
        m->state[i] = which[i] < LW_SERVO_N ? physical[which[i]] : held[which[i] - LW_SERVO_N];
    m->input[0] = "wanted position";
    m->input[1] = "wanted speed";
    m->input[2] = "wanted acceleration";
    m->input[3] = s->slides ? "force" : "torque";
    name_outputs(m, 6);
    add_units(m, s->slides);
    for (int k = 0; k < n + 4; k++) {
        lw_servo_axis a = lw_servo_axis_of(s, true);
        double y[LW_SERVO_N] = { 0 }, after[LW_SERVO_N];
        double *const input[] = { &a.wanted.x, &a.wanted.v, &a.wanted.a, &a.force };
        *(k < n ? number_at(&a, y, which[k]) : input[k - n]) = 1;
        if (k < n)
            put_outputs(&a, y, m, m->c, n, k);
        else
            put_outputs(&a, y, m, m->d, 4, k - n);
        if (period > 0) {
            long steps = 0;
            lw_status status = lw_servo_integrate(&a, 0, period, 1e-13, memcpy(after, y, sizeof y), NULL, NULL, &steps, e);
            if (status != LW_OK)
                return status;
        } else
            lw_servo_rates(&a, 0, y, after);
        for (int i = 0; i < n; i++)
            *(k < n ? &m->a[i*n + k] : &m->b[i*4 + k - n]) = *number_at(&a, after, which[i]);
    }
    return LW_OK;
}

lw_status lw_matrices_poles(const lw_state_matrices *m, int *n, double *re, double *im)
{
    double a[LW_MATRIX_STATE_MAX*LW_MATRIX_STATE_MAX], r[LW_MATRIX_STATE_MAX], i[LW_MATRIX_STATE_MAX];
    double x[LW_MATRIX_STATE_MAX*LW_MATRIX_STATE_MAX], y[LW_MATRIX_STATE_MAX*LW_MATRIX_STATE_MAX];
    memcpy(a, m->a, sizeof a);
    *n = 0;
    lw_status s = lw_eigen_general(m->n_state, a, r, i, x, y);
    for (int k = 0; s == LW_OK && k < m->n_state; k++) {
        double size = hypot(r[k], i[k]), pr = r[k], pi = i[k];
        if (m->sample > 0) {
            if (size < 1e-9)
                continue;
            pr = log(size)/m->sample;
            pi = atan2(i[k], r[k])/m->sample;
        }
        int at = (*n)++;
        for (; at > 0 && re[at - 1] < pr; at--)
            re[at] = re[at - 1], im[at] = im[at - 1];
        re[at] = pr;
        im[at] = pi;
    }
    return s;
}

lw_status lw_servo_poles(const lw_servo *servo, int *n, double *re, double *im, lw_error *error)
{
    lw_state_matrices m;
    *n = 0;
    lw_status s = lw_servo_closed(servo, &m, error);
    if (s == LW_OK && (s = lw_matrices_poles(&m, n, re, im)) != LW_OK)
        lw_error_set(error, s, "the eigenvalues of the closed loop are not found");
    return s;
}

/* ---- frequency responses --------------------------------------------------------------------------------------- */

/* Solve (s I - A) x = b by elimination with row exchanges. */
static void solve(const lw_state_matrices *m, double complex s, double complex *x)
{
    int n = m->n_state;
    double complex a[5*5];
    for (int i = 0; i < n; i++) {
        x[i] = m->b[i*m->n_input];
        for (int k = 0; k < n; k++)
            a[i*n + k] = (i == k ? s : 0) - m->a[i*n + k];
    }
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            pivot = cabs(a[i*n + k]) > cabs(a[pivot*n + k]) ? i : pivot;
        for (int j = 0; j < n && pivot != k; j++) {
            double complex keep = a[k*n + j];
            a[k*n + j] = a[pivot*n + j];
            a[pivot*n + j] = keep;
        }
        double complex keep = x[k];
        x[k] = x[pivot];
        x[pivot] = keep;
        for (int i = k + 1; i < n; i++) {
            double complex f = a[i*n + k]/a[k*n + k];
            for (int j = k; j < n; j++)
                a[i*n + j] -= f*a[k*n + j];
            x[i] -= f*x[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= a[i*n + k]*x[k];
        x[i] /= a[i*n + i];
    }
}

/* Hold of the output between samples, and the delay of the computation. */
static double complex hold(const lw_servo_loop *l, double complex s)
{
    return l->sample > 0 ? (1 - cexp(-s*l->sample))/(s*l->sample)*cexp(-s*l->delay) : 1;
}

static double complex controller(const lw_servo_loop *l, double complex s)
{
    double complex sum = l->sample > 0 ? l->sample/(cexp(s*l->sample) - 1) : 1/s;
    return (l->proportional + l->integral*sum)*hold(l, s);
}

static double complex response(const lw_servo *p, const lw_state_matrices *plant, int loop, double w)
{
    double complex x[5], s = I*w;
    solve(plant, s, x);
    double complex current = p->ideal_current ? 1 : x[plant->n_state - 1];
    int side = p->encoder_at_load && p->elastic ? 2 : 0;
    double complex position = x[side], speed = x[side + 1], by_current = 1;
    if (!p->ideal_current) {
        double complex c = controller(&p->circuit, s);
        double complex emf = p->emf_compensation ? hold(&p->circuit, s)*p->constant/p->factor*x[1] : 0;
        if (loop == LW_SERVO_CIRCUIT)
            return c*current/(1 - emf);
        by_current = c/(1 + c*current - emf);
    } else if (loop == LW_SERVO_CIRCUIT)
        return 0;
    if (p->encoder > 0)                                    /* speed from the difference of two positions */
        speed *= (1 - cexp(-s*p->speed.sample))/(s*p->speed.sample);
    double mass = p->inertia/(p->factor*p->factor) + p->load;
    double complex wanted = controller(&p->speed, s)*(p->factor*mass/p->constant)*by_current;
    if (loop == LW_SERVO_SPEED)
        return wanted*speed;
    return p->position.proportional*hold(&p->position, s)*wanted*position/(1 + wanted*speed);
}

void lw_servo_response(const lw_servo *s, int loop, double w, double *gain, double *phase)
{
    lw_state_matrices plant;
    lw_servo_plant(s, &plant);
    double complex z = response(s, &plant, loop, w);
    *gain = cabs(z);
    *phase = carg(z);
}

/* The phase at w that continues one near it. */
static double phase_near(double complex z, double near)
{
    double p = carg(z);
    return p + 2*LW_PI*rint((near - p)/(2*LW_PI));
}

lw_servo_margin lw_servo_margin_of(const lw_servo *s, int loop)
{
    enum { N = 4000 };
    const lw_servo_loop *loops[] = { &s->position, &s->speed, &s->circuit };
    lw_servo_margin m = { NAN, NAN, NAN, NAN };
    lw_state_matrices plant;
    lw_servo_plant(s, &plant);
    /* up to half the sampling frequency, beyond which a sampled loop has no response */
    double low = log(1e-3), high = log(loops[loop]->sample > 0 ? LW_PI/loops[loop]->sample : 1e6), was = low, phase = 0, gain = 0;
    for (int k = 0; k <= N; k++) {
        double at = low + (high - low)*k/N;
        double complex z = response(s, &plant, loop, exp(at));
        double g = cabs(z), p = phase_near(z, k ? phase : -LW_PI/2);
        for (int what = 0; k > 0 && what < 2; what++) {    /* gain 1; phase -180 degrees */
            double a = was, b = at, turn = 2*LW_PI, level = floor((fmax(phase, p) + LW_PI)/turn)*turn - LW_PI;
            if (what == 0 ? (gain >= 1) == (g >= 1) : !(fmin(phase, p) < level))
                continue;
            for (int i = 0; i < 60; i++) {
                double mid = 0.5*(a + b);
                double complex there = response(s, &plant, loop, exp(mid));
                bool before = what == 0 ? (cabs(there) >= 1) == (gain >= 1)
                                        : (phase_near(there, phase) >= level) == (phase >= level);
                *(before ? &a : &b) = mid;
            }
            double complex there = response(s, &plant, loop, exp(b));
            double margin = LW_PI + carg(there), factor = 1/cabs(there);
            margin = margin > LW_PI ? margin - turn : margin;
            if (what == 0 && !(fabs(margin) >= fabs(m.phase)))
                m.crossover = exp(b), m.phase = margin;
            else if (what == 1 && !(fabs(log(factor)) >= fabs(log(m.gain))))
                m.reversal = exp(b), m.gain = factor;
        }
        was = at, phase = p, gain = g;
    }
    return m;
}

/* mbs/analysis/modes_fft.c - eigenfrequencies from the spectra of a small free vibration (bridge to GSL's FFT).
 *
 * The window is a Gaussian bell over 8 standard deviations.  The spectrum of a decaying vibration through it is a
 * bell too, so the parabola through the logarithms of three neighbours gives its top without bias. */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_fft_real.h>
#include <stdlib.h>
#include <string.h>
#include "base/gsl_errors.h"
#include "base/real.h"
#include "mbs/analysis/modes_fft.h"
#include "mbs/run/run_internal.h"

#define PUSH       1e-4              /* amplitude of each mode, over the size of the linkage or in rad */
#define PERIODS    32                /* of the slowest mode in a run, */
#define APART      16                /* and of the beat of two neighbours: 12 times the width of a peak */
#define PER_PERIOD 8                 /* samples in a period of the fastest mode */
#define LONGEST    (1 << 18)         /* most samples */

typedef struct recorder {
    lw_dynamics *d;
    lw_run run;
    lw_dynamics_report report;
    int    n;                        /* number of samples */
    double step;                     /* between them [s] */
    int    n_track, *velocity;       /* velocities recorded */
    double *track;                   /* (n_track * n) */
} recorder;

static bool vibrates(const lw_mode *m) { return m->im > 0.0 && m->damping < 0.1 && m->damping > -1e-9; }

/* Distance to the next other frequency, at most that of the mode */
static double gap(const lw_modes *modes, int mode)
{
    double own = modes->mode[mode].frequency, least = own;
    for (int k = 0; k < modes->n_mode; k++) {
        double apart = fabs(modes->mode[k].frequency - own);
        least = apart > 1e-6*own ? fmin(least, apart) : least;
    }
    return least;
}

/* The velocity that is greatest in a mode */
static int greatest_velocity(const lw_mode *m, int n_v)
{
    int top = 0;
    for (int i = 1; i < n_v; i++)
        top = m->shape[i] > m->shape[top] ? i : top;
    return top;
}

/* Choose number and spacing of samples by the slowest and the fastest mode, and the velocities to record */
static lw_status choose(recorder *l, const lw_modes *modes, lw_error *e)
{
    double longest = 0.0, quick = 0.0;
    l->velocity = calloc((size_t)modes->n_mode + 1, sizeof *l->velocity);
    if (!l->velocity)
        return lw_error_set(e, LW_E_MEMORY, "no memory for spectra");
    for (int k = 0; k < modes->n_mode; k++) {
        const lw_mode *m = &modes->mode[k];
        int top = greatest_velocity(m, l->d->n_v), i = 0;
        if (!vibrates(m))
            continue;
        longest = fmax(longest, fmax(PERIODS/m->frequency, APART/gap(modes, k)));
        quick = fmax(quick, m->frequency);
        while (i < l->n_track && l->velocity[i] != top)
            i++;
        if (i == l->n_track)
            l->velocity[l->n_track++] = top;
    }
    if (l->n_track == 0)
        return lw_error_set(e, LW_NOTHING, "no mode vibrates long enough for its spectrum");
    l->step = 1.0/(PER_PERIOD*quick);
    for (l->n = 1024; l->n < LONGEST && l->n*l->step < longest; l->n *= 2)
        continue;
    l->track = calloc((size_t)l->n_track*(size_t)l->n, sizeof *l->track);
    return l->track ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for spectra");
}

/* Posture and velocities y in which every mode takes part, put on the rows; by (n_v): scratch */
static lw_status start_vibration(recorder *l, const lw_modes *modes, const double *q, double *y, double *by)
{
    lw_dynamics *d = l->d;
    double *v = y + d->n_q;
    memcpy(y, q, (size_t)d->n_q*sizeof *q);
    for (int k = 0; k < modes->n_mode; k++) {
        const lw_mode *m = &modes->mode[k];
        for (int i = 0; vibrates(m) && i < d->n_v; i++) {
            by[i] += PUSH*m->shape[i]*cos(m->phase[i]);
            v[i] += PUSH*m->shape[i]*(m->re*cos(m->phase[i]) - m->im*sin(m->phase[i]));
        }
    }
    if (d->eq.along)
        d->eq.along(d->eq.context, by, v);
    d->eq.move(d->eq.context, y, by);
    memcpy(y + lw_run_states(&l->run), d->start_z, (size_t)d->eq.n_z*sizeof *y);
    lw_status s = lw_mbs_arrange(d, d->o.from, q);
    if (s != LW_OK)
        return s;
    lw_mbs_freeze(d, q);
    return lw_run_project(&l->run, d->o.from, y);
}

static void store_sample(recorder *l, int sample, const double *y)
{
    for (int i = 0; i < l->n_track; i++)
        l->track[(size_t)i*(size_t)l->n + (size_t)sample] = y[l->d->n_q + l->velocity[i]];
}

static lw_status record(recorder *l, const double *y, const double *each, double *now, double *work, lw_error *e)
{
    lw_integrator in;
    lw_ode ode = { .n = l->run.n, .context = &l->run, .rate = lw_run_rate, .project = lw_run_project };
    lw_ode_options o = { .absolute_each = each };
    lw_status s = lw_integrate_start(&in, &ode, &o, work, 0.0, y, e);
    int sample = 0;
    if (s == LW_OK)
        store_sample(l, sample++, y);
    while (s == LW_OK && sample < l->n) {
        lw_ode_stop stop;
        s = lw_integrate_step(&in, l->n*l->step, &stop, e);
        for (; s == LW_OK && sample < l->n && sample*l->step <= in.t; sample++) {
            s = lw_integrate_dense(&in, sample*l->step, now);
            store_sample(l, sample, now);
        }
    }
    return s;
}

/* The highest peak of a spectrum, nearer to a frequency than to another one */
static double find_peak(const recorder *l, const double *spectrum, double frequency, double within)
{
    double bin = 1.0/(l->n*l->step), best = 0.0, found = NAN;
    int from = (int)fmax(2, floor((frequency - within)/bin)), to = (int)fmin(l->n/2 - 2, ceil((frequency + within)/bin));
    for (int i = from; i <= to; i++) {
        double a = spectrum[i - 1], b = spectrum[i], c = spectrum[i + 1];
        if (!(b > a && b >= c && b > best))
            continue;
        best = b;
        double la = log(a), lb = log(b), lc = log(c), bow = la - 2.0*lb + lc;
        found = bin*(i + (bow < 0.0 ? 0.5*(la - lc)/bow : 0.0));
    }
    return found;
}

/* Turn a track (n) into the amplitudes of its spectrum (n/2) */
static lw_status transform(const recorder *l, double *track)
{
    int n = l->n;
    double mean = 0.0;
    for (int i = 0; i < n; i++)
        mean += track[i]/n;
    for (int i = 0; i < n; i++) {
        double x = 8.0*(i + 0.5)/n - 4.0;
        track[i] = (track[i] - mean)*exp(-0.5*x*x);
    }
    lw_gsl_begin();
    int code = gsl_fft_real_radix2_transform(track, 1, (size_t)n);
    lw_gsl_end();
    if (code != GSL_SUCCESS)
        return LW_E_NUMERIC;
    for (int i = 1; i < n/2; i++)                            /* real parts stand first, imaginary parts at the end */
        track[i] = hypot(track[i], track[n - i]);
    return LW_OK;
}

static lw_status find_peaks(recorder *l, const lw_modes *modes, const double *q, double *peak, lw_error *e)
{
    int n = l->run.n;
    double *y = calloc(4*(size_t)n + lw_integrate_work(n, 0), sizeof *y), *each = y + n, quick = 0.0;
    if (!y)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a run");
    for (int k = 0; k < modes->n_mode; k++)
        quick = fmax(quick, 2.0*LW_PI*modes->mode[k].natural);
    for (int i = 0; i < n; i++)
        each[i] = 1e-7*PUSH*(i < l->d->n_q ? 1.0 : quick);
    lw_status s = start_vibration(l, modes, q, y, y + 2*n);
    if (s != LW_OK)
        lw_error_set(e, s, "the vibration cannot be started");
    else
        s = record(l, y, each, y + 3*n, y + 4*n, e);
    free(y);
    for (int i = 0; s == LW_OK && i < l->n_track; i++)
        s = transform(l, l->track + (size_t)i*(size_t)l->n);
    for (int k = 0; s == LW_OK && k < modes->n_mode; k++)
        for (int i = 0; vibrates(&modes->mode[k]) && i < l->n_track; i++)
            if (l->velocity[i] == greatest_velocity(&modes->mode[k], l->d->n_v))
                peak[k] = find_peak(l, l->track + (size_t)i*(size_t)l->n, modes->mode[k].frequency,
                                    fmin(0.1*modes->mode[k].frequency, 0.5*gap(modes, k)));
    return s;
}

lw_status lw_modes_from_spectra(lw_dynamics *d, const double *q, const lw_modes *modes, double *peak, lw_error *e)
{
    lw_error own = { 0 };
    for (int k = 0; k < modes->n_mode; k++)
        peak[k] = NAN;
    recorder *l = calloc(1, sizeof *l);
    if (!l)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    l->d = d;
    d->e = e ? e : &own;
    d->n_friction = 0;                       /* as for the modes */
    l->run = (lw_run){ .d = d, .r = &l->report, .e = d->e, .n = d->n_q + d->n_v + d->eq.n_z };
    lw_status s = choose(l, modes, d->e);
    if (s == LW_OK)
        s = find_peaks(l, modes, q, peak, d->e);
    free(l->velocity);
    free(l->track);
    free(l);
    return s;
}

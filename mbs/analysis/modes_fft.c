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
#include "mbs/clearance/clearance_internal.h"
#include "mbs/dynamics/modes.h"
#include "mbs/ode/integrate.h"

#define PUSH       1e-4              /* amplitude of each mode, over the size of the linkage or in rad */
#define PERIODS    128               /* of the slowest mode in a run */
#define PER_PERIOD 8                 /* samples in a period of the fastest mode */
#define LONGEST    (1 << 18)         /* most samples */

typedef struct recorder {
    lw_clearance_scene scene;
    lw_clearance_work  work;
    double held[LW_INPUT_MAX], at;   /* values of held inputs; time of the loads */
    int    n;                        /* number of samples */
    double step;                     /* between them [s] */
    int    n_track, coordinate[LW_SYSTEM_Q_MAX];     /* coordinates recorded */
    double *track;                   /* (n_track * n) */
} recorder;

static bool vibrates(const lw_mode *m) { return m->im > 0.0 && m->damping < 0.1 && m->damping > -1e-9; }

/* The coordinate that moves most in a mode */
static int largest_coordinate(const lw_mode *m, int n_q)
{
    int top = 0;
    for (int i = 1; i < n_q; i++)
        top = m->shape[i] > m->shape[top] ? i : top;
    return top;
}

static lw_status rate_of(void *context, double t, const double *y, double *dy)
{
    recorder *l = context;
    int n = l->work.n_u;
    (void)t;
    memcpy(dy, y + n, sizeof(double)*(size_t)n);
    return lw_clearance_accelerate(&l->work, l->at, y, y + n, dy + n);
}

static lw_status put_back(void *context, double t, double *y)
{
    recorder *l = context;
    (void)t;
    return lw_clearance_project(&l->work, &l->work.rows, l->at, y, y + l->work.n_u);
}

/* Choose number and spacing of samples by the slowest and the fastest mode, and the coordinates to record */
static lw_status choose(recorder *l, const lw_modes *modes, lw_error *e)
{
    double slow = INFINITY, quick = 0.0;
    for (int k = 0; k < modes->n_mode; k++) {
        const lw_mode *m = &modes->mode[k];
        int top = largest_coordinate(m, l->scene.s.n_q), i = 0;
        if (!vibrates(m))
            continue;
        slow = fmin(slow, m->frequency);
        quick = fmax(quick, m->frequency);
        while (i < l->n_track && l->coordinate[i] != top)
            i++;
        if (i == l->n_track)
            l->coordinate[l->n_track++] = top;
    }
    if (l->n_track == 0)
        return lw_error_set(e, LW_NOTHING, "no mode vibrates long enough for its spectrum");
    l->step = 1.0/(PER_PERIOD*quick);
    for (l->n = 1024; l->n < LONGEST && l->n*l->step*slow < PERIODS; l->n *= 2)
        continue;
    l->track = calloc((size_t)l->n_track*(size_t)l->n, sizeof *l->track);
    return l->track ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for spectra");
}

/* Posture and velocities in which every mode takes part, put on the rows */
static lw_status start_vibration(recorder *l, const lw_modes *modes, const double *q, double *y)
{
    int n_q = l->scene.s.n_q, n = l->work.n_u;
    double at[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX] = { 0.0 };
    memcpy(at, q, sizeof *q*(size_t)n_q);
    for (int k = 0; k < modes->n_mode; k++) {
        const lw_mode *m = &modes->mode[k];
        for (int i = 0; vibrates(m) && i < n_q; i++) {
            at[i] += PUSH*m->shape[i]*cos(m->phase[i]);
            v[i] += PUSH*m->shape[i]*(m->re*cos(m->phase[i]) - m->im*sin(m->phase[i]));
        }
    }
    lw_tree_read(&l->scene.tree, at, v, y, y + n);
    return lw_clearance_project(&l->work, &l->work.rows, l->at, y, y + n);
}

static void store_sample(recorder *l, int sample, const double *y)
{
    double q[LW_SYSTEM_Q_MAX];
    lw_tree_place(&l->scene.tree, y, NULL, &l->work.state);
    lw_tree_write(&l->scene.tree, &l->work.state, NULL, q, NULL);
    for (int i = 0; i < l->n_track; i++)
        l->track[(size_t)i*(size_t)l->n + (size_t)sample] = q[l->coordinate[i]];
}

static lw_status record(recorder *l, const double *y, const double *each, double *work, lw_error *e)
{
    lw_integrator in;
    lw_ode ode = { .n = 2*l->work.n_u, .context = l, .rate = rate_of,
                   .project = lw_clearance_count_rows(&l->scene, &l->work.rows) ? put_back : NULL };
    lw_ode_options o = { .absolute_each = each };
    double now[2*LW_SYSTEM_Q_MAX];
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

/* Peak of a spectrum nearest to a frequency, within a tenth of it */
static double find_peak(const recorder *l, const double *spectrum, double frequency)
{
    double bin = 1.0/(l->n*l->step), best = 0.0, found = NAN;
    int from = (int)fmax(2, floor(0.9*frequency/bin)), to = (int)fmin(l->n/2 - 2, ceil(1.1*frequency/bin));
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
    int n = 2*l->work.n_u;
    double *memory = calloc(2*(size_t)n + lw_integrate_work(n, 0), sizeof *memory), quick = 0.0;
    if (!memory)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a run");
    for (int k = 0; k < modes->n_mode; k++)
        quick = fmax(quick, 2.0*LW_PI*modes->mode[k].natural);
    for (int i = 0; i < n; i++)
        memory[n + i] = 1e-7*PUSH*(i < n/2 ? 1.0 : quick);
    lw_status s = start_vibration(l, modes, q, memory);
    if (s != LW_OK)
        lw_error_set(e, s, "the vibration cannot be started");
    else
        s = record(l, memory, memory + n, memory + 2*n, e);
    free(memory);
    for (int i = 0; s == LW_OK && i < l->n_track; i++)
        s = transform(l, l->track + (size_t)i*(size_t)l->n);
    for (int k = 0; s == LW_OK && k < modes->n_mode; k++)
        for (int i = 0; vibrates(&modes->mode[k]) && i < l->n_track; i++)
            if (l->coordinate[i] == largest_coordinate(&modes->mode[k], l->scene.s.n_q))
                peak[k] = find_peak(l, l->track + (size_t)i*(size_t)l->n, modes->mode[k].frequency);
    return s;
}

lw_status lw_modes_from_spectra(const lw_forces *f, const lw_modes_options *o, double t, const double *q,
                          const lw_modes *modes, double *peak, lw_error *e)
{
    for (int k = 0; k < modes->n_mode; k++)
        peak[k] = NAN;
    if (f->system->n_tie > 0)
        return lw_error_set(e, LW_E_KIND, "frequencies from spectra (--fft) are not available with tied inputs");
    recorder *l = calloc(1, sizeof *l);
    if (!l)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_clearance_plain(f, &l->scene);
    lw_clearance_options none = lw_clearance_options_default();
    lw_status s = lw_clearance_work_make(&l->scene, &none, &l->work);
    if (s == LW_OK) {
        l->at = t;
        l->work.held = l->held;
        for (int i = 0; i < l->scene.s.n_input; i++) {
            l->work.rows.input[i] = o->hold_inputs || f->model->motion[i];
            l->held[i] = lw_system_measure(&l->scene.s, l->scene.s.input_joint[i], q, NULL);
        }
        s = choose(l, modes, e);
        if (s == LW_OK)
            s = find_peaks(l, modes, q, peak, e);
        lw_clearance_work_free(&l->work);
    } else
        lw_error_set(e, s, "out of memory");
    free(l->track);
    free(l);
    return s;
}

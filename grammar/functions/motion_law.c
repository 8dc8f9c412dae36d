#include "grammar/functions/motion_law.h"

#include <stddef.h>
#include <string.h>
#include "base/real.h"
#include "base/vec2.h"

#define PI LW_PI

/* The acceleration of a law up to u = to: size*sin(rate*(u - start) + phase). */
typedef struct wave { double to, size, rate, phase; } wave;

typedef struct row {
    lw_motion_law about;
    double        power[8];            /* of a polynomial: factors of u^k             */
    wave          wave[6];             /* else: its accelerations one after the other */
} row;

#define CONSTANT(to, a) { (to), (a), 0, PI/2 }
#define MODIFIED_TRAPEZOID (8*PI/(PI + 2))
#define MODIFIED_SINE      (4*PI*PI/(PI + 4))

static const row laws[] = {
    { { "345", "polynomial of degree 5: acceleration without steps", NULL, 1.875, 5.7735026918962573, 60, 120/7.0 },
      { 0, 0, 0, 10, -15, 6 }, { { 0, 0, 0, 0 } } },
    { { "4567", "polynomial of degree 7: jerk without steps", NULL, 2.1875, 7.5131884043994884, 52.5, 280/11.0 },
      { 0, 0, 0, 0, 35, -84, 70, -20 }, { { 0, 0, 0, 0 } } },
    { { "cycloid", "acceleration is a sine wave", NULL, 2, 2*PI, 4*PI*PI, 2*PI*PI },
      { 0 }, { { 1, 2*PI, 2*PI, 0 } } },
    { { "modified-sine", "quick and slow sine waves joined: low peak torque of a cam shaft", NULL, MODIFIED_SINE/PI,
        MODIFIED_SINE, 4*PI*MODIFIED_SINE, MODIFIED_SINE*MODIFIED_SINE/2 },
      { 0 }, { { 0.125, MODIFIED_SINE, 4*PI, 0 }, { 0.875, MODIFIED_SINE, 4*PI/3, PI/2 },
               { 1, MODIFIED_SINE, 4*PI, -PI/2 } } },
    { { "modified-trapezoid", "trapezoid of acceleration with rounded flanks: least peak acceleration without steps", NULL, 2,
        MODIFIED_TRAPEZOID, 4*PI*MODIFIED_TRAPEZOID, 0.75*MODIFIED_TRAPEZOID*MODIFIED_TRAPEZOID },
      { 0 }, { { 0.125, MODIFIED_TRAPEZOID, 4*PI, 0 }, CONSTANT(0.375, MODIFIED_TRAPEZOID),
               { 0.625, MODIFIED_TRAPEZOID, 4*PI, PI/2 }, CONSTANT(0.875, -MODIFIED_TRAPEZOID),
               { 1, MODIFIED_TRAPEZOID, 4*PI, -PI/2 } } },
    { { "havsin", "half a wave of a cosine; acceleration steps at both ends", NULL, PI/2, PI*PI/2, INFINITY, PI*PI*PI*PI/8 },
      { 0 }, { { 1, PI*PI/2, PI, PI/2 } } },
    { { "step", "cubic, speed is a parabola: least copper loss; acceleration steps at both ends", "copper-loss", 1.5, 6, INFINITY,
        12 },
      { 0, 0, 3, -2 }, { { 0, 0, 0, 0 } } },
    { { "trapezoid", "speed rises, stays and falls, a third of the time each", NULL, 1.5, 4.5, INFINITY, 13.5 },
      { 0 }, { CONSTANT(1/3.0, 4.5), CONSTANT(2/3.0, 0), CONSTANT(1, -4.5) } },
    { { "triangle", "speed rises and falls: least time at a given acceleration", "bang-bang", 2, 4, INFINITY, 16 },
      { 0 }, { CONSTANT(0.5, 4), CONSTANT(1, -4) } }
};

#define N_LAW ((int)(sizeof laws/sizeof *laws))

const lw_motion_law *lw_motion_law_get(int law) { return law >= 0 && law < N_LAW ? &laws[law].about : NULL; }

int lw_motion_law_find(const char *name)
{
    for (int i = 0; i < N_LAW; i++)
        if (!strcmp(name, laws[i].about.name) || (laws[i].about.also && !strcmp(name, laws[i].about.also)))
            return i;
    return -1;
}

static void polynomial_at(const double power[8], double u, double out[4])
{
    for (int k = 7; k >= 0; k--) {                         /* Horner's scheme for the value and three derivatives */
        for (int d = 3; d > 0; d--)
            out[d] = out[d]*u + d*out[d - 1];
        out[0] = out[0]*u + power[k];
    }
}

static void waves_at(const wave *w, double u, double out[4])
{
    double start = 0;
    for (;; w++) {
        double d = fmin(u, w->to) - start, r = w->rate, p = w->phase, a = w->size;
        double way = r ? a*(cos(p)*d/r - (sin(r*d + p) - sin(p))/(r*r)) : a*d*d/2;
        out[0] += out[1]*d + way;
        out[1] += r ? a*(cos(p) - cos(r*d + p))/r : a*d;
        out[2] = a*sin(r*d + p);
        out[3] = r ? a*r*cos(r*d + p) : 0;
        if (u < w->to || w->to == 1)
            return;
        start = w->to;
    }
}

void lw_motion_law_at(int law, double u, double out[4])
{
    for (int k = 0; k < 4; k++)
        out[k] = 0;
    if (u >= 1)
        out[0] = 1;
    else if (u >= 0 && laws[law].wave[0].to > 0)
        waves_at(laws[law].wave, u, out);
    else if (u >= 0)
        polynomial_at(laws[law].power, u, out);
}

double lw_motion_law_border(int law, int i)
{
    const wave *w = laws[law].wave;
    for (int k = 0; w[0].to > 0 && w[k].to < 1; k++)
        if (k == i)
            return w[k].to;
    return 1;
}

void lw_motion_law_series(int law, double u, int direction, int order, double *out)
{
    const wave *w = laws[law].wave;
    double at[4], start = 0, factor = 1;
    u = fmin(fmax(u, 0), 1);
    if (!(w->to > 0)) {                                    /* the polynomial about u, by repeated division */
        double c[8];
        memcpy(c, laws[law].power, sizeof c);
        for (int k = 0; k <= order; k++) {
            for (int i = 6; i >= k && k < 8; i--)
                c[i] += u*c[i + 1];
            out[k] = k < 8 ? c[k] : 0;
        }
        return;
    }
    while (w->to < 1 && (u > w->to || (u == w->to && direction >= 0)))
        start = w++->to;
    lw_motion_law_at(law, fmin(u, 1 - 1e-16), at);
    double d = u - start;
    for (int k = 0; k <= order; k++, factor *= k) {        /* the acceleration is size sin(rate d + phase) */
        double rate = k < 2 ? 1 : pow(w->rate, k - 2);
        out[k] = (k < 2 ? at[k] : k > 2 && w->rate == 0 ? 0 : w->size*rate*sin(w->rate*d + w->phase + (k - 2)*PI/2))/factor;
    }
}

/* bench_branch.c - following a linkage: the whole curve of postures by steps that provably stay on it, a posture
 * anywhere on it with rates, and the verifier over the first arc.  Processor seconds of a thread, best of five. */
#include <stdio.h>
#include <stdlib.h>
#include "base/clock.h"
#include "base/file.h"
#include "mbs/constraints/motion_curve.h"
#include "mbs/constraints/newton.h"

static const char *const files[] = { "examples/hoeken.json", "examples/chebyshev.json", "examples/klann.json",
                                     "examples/jansen.json", "examples/geared-five-bar.json",
                                     "examples/scott-russell.json" };

static bool read_model(const char *file, lw_linkage *k)
{
    char *text = NULL;
    size_t size;
    bool good = lw_file_read(file, &text, &size, NULL) == LW_OK && lw_linkage_read(text, size, file, k, NULL) == LW_OK;
    free(text);
    return good;
}

/* Seconds for the curve; *b is kept. */
static double whole_curve(const lw_system *s, lw_motion_curve **b)
{
    double best = HUGE_VAL;
    for (int i = 0; i < 5; i++) {
        double start = lw_clock_cpu();
        lw_motion_curve_free(*b);
        if (lw_motion_curve_create(s, NULL, &(lw_motion_curve_options){ .input = 0 }, b, NULL) != LW_OK)
            return NAN;
        best = fmin(best, lw_clock_cpu() - start);
    }
    return best;
}

static double one_posture(const lw_system *s, lw_motion_curve *b)
{
    enum { N = 2000 };
    double q[4*LW_SYSTEM_Q_MAX], speed[4*LW_INPUT_MAX] = { 0, 1 }, start = lw_clock_cpu();
    for (int i = 0; i < N; i++) {
        lw_motion_curve_posture(b, lw_motion_curve_segments(b)*(i + 0.5)/N, q, NULL);
        lw_motion_curve_rates(b, 3, speed, q);
    }
    (void)s;
    return (lw_clock_cpu() - start)/N;
}

static double verifier(const lw_linkage *k)
{
    lw_newton *n;
    double best = HUGE_VAL;
    if (lw_newton_create(k, &n, NULL) != LW_OK)
        return NAN;
    for (int i = 0; i < 5; i++) {
        double start = lw_clock_cpu();
        lw_newton_reset(n);
        lw_newton_move(n, lw_newton_input(n) + 2*LW_PI, NULL);
        best = fmin(best, lw_clock_cpu() - start);
    }
    lw_newton_free(n);
    return best;
}

int main(void)
{
    printf("%-30s %8s %10s %14s %14s\n", "linkage", "segments", "curve, ms", "posture, us", "verifier, ms");
    for (size_t i = 0; i < sizeof files/sizeof *files; i++) {
        static lw_linkage k;
        static lw_system s;
        lw_motion_curve *b = NULL;
        if (!read_model(files[i], &k) || lw_system_make(&k, NULL, 0, &s, NULL) != LW_OK)
            continue;
        double curve = whole_curve(&s, &b);
        if (b)
            printf("%-30s %8d %10.3f %14.1f %14.3f\n", files[i], lw_motion_curve_segments(b), 1e3*curve,
                   1e6*one_posture(&s, b), 1e3*verifier(&k));
        lw_motion_curve_free(b);
    }
    return 0;
}

/* tests/motion_curve.h - the motion curve of a linkage, followed from its first input. */
#ifndef LW_TESTS_MOTION_CURVE_H
#define LW_TESTS_MOTION_CURVE_H

#include "mbs/constraints/motion_curve.h"
#include "tests/check.h"

typedef struct curve { lw_system s; lw_motion_curve *b; } curve;

static inline double distance(lw_vec2 a, lw_vec2 b) { return lw_v2_norm(lw_v2_sub(a, b)); }

/* At most so many segments, 0: until it ends by itself.  Free with curve_free. */
static inline curve *follow(const lw_linkage *k, int most_segments)
{
    curve *c = calloc(1, sizeof *c);
    lw_error e = { 0 };
    CHECK_INT(lw_system_make(k, NULL, 0, &c->s, &e), LW_OK);
    lw_motion_curve_options o = { .input = 0, .most_segments = most_segments };
    CHECK_INT(lw_motion_curve_create(&c->s, NULL, &o, &c->b, &e), LW_OK);
    if (!c->b)
        fprintf(stderr, "%s\n", e.text);
    return c;
}

static inline void curve_free(curve *c)
{
    lw_motion_curve_free(c->b);
    lw_system_free(&c->s);
    free(c);
}
OWNS(curve)

static inline lw_vec2 tracer(const curve *c, int i, const double *q)
{
    return lw_system_point(&c->s, c->s.tracer_body[i], c->s.tracer_arm[i], q);
}

static inline lw_vec2 tracer_at(const curve *c, int i, double station)
{
    double q[LW_SYSTEM_Q_MAX];
    lw_motion_curve_posture(c->b, station, q, NULL);
    return tracer(c, i, q);
}

static inline double input_at(const curve *c, double station)
{
    double q[LW_SYSTEM_Q_MAX];
    lw_motion_curve_posture(c->b, station, q, NULL);
    return lw_motion_curve_input(c->b, q);
}

static inline double residual(const curve *c, const double *q)
{
    double phi[LW_SYSTEM_ROW_MAX], most = 0;
    lw_system_rows(&c->s, q, phi, NULL);
    for (int i = 0; i < c->s.n_row; i++)
        most = fmax(most, fabs(phi[i]));
    return most;
}

/* The number of events of this kind. */
static inline int count(const curve *c, lw_motion_curve_event_kind kind)
{
    int n, found = 0;
    const lw_motion_curve_event *e = lw_motion_curve_events(c->b, &n);
    for (int i = 0; i < n; i++)
        found += e[i].kind == kind;
    return found;
}

#endif

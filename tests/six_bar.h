/* tests/six_bar.h - six-bars in a posture: a four-bar A B C D whose coupler point E drives a dyad E F G.
 * Stephenson III with G on the ground; the tracer P rides on E F. */
#ifndef LW_TESTS_SIX_BAR_H
#define LW_TESTS_SIX_BAR_H

#include <stdlib.h>
#include <string.h>

#include "grammar/linkage/linkage.h"
#include "mbs/batch/posture.h"
#include "optimise/task/target.h"
#include "tests/check.h"

static inline lw_linkage six_bar(void)
{
    static const char text[] =
        "{\"linkwright\":1,\"links\":[\"ground\",\"crank\",\"coupler\",\"rocker\",\"arm\",\"stay\"],\"joints\":["
        "{\"name\":\"A\",\"links\":[\"ground\",\"crank\"],\"at\":[0,0]},"
        "{\"name\":\"B\",\"links\":[\"crank\",\"coupler\"],\"at\":[0.5,0.8]},"
        "{\"name\":\"C\",\"links\":[\"coupler\",\"rocker\"],\"at\":[2.6,2.1]},"
        "{\"name\":\"D\",\"links\":[\"ground\",\"rocker\"],\"at\":[3,0]},{\"name\":\"E\",\"links\":[\"coupler\",\"arm\"],\"at\":[1.1,2.4]},"
        "{\"name\":\"F\",\"links\":[\"arm\",\"stay\"],\"at\":[-0.4,5.2]},{\"name\":\"G\",\"links\":[\"ground\",\"stay\"],\"at\":[-3,2.5]}],"
        "\"input\":{\"joint\":\"A\"},\"tracers\":[{\"name\":\"P\",\"link\":\"arm\",\"at\":[0.2,2.9]}]}";
    lw_linkage k;
    lw_error e = { .text = "" };
    CHECK_INT(lw_linkage_read(text, strlen(text), "six-bar", &k, &e), LW_OK);
    return k;
}

/* n points of its curve at equal steps of a full turn of the crank, with the input angles. */
static inline void six_bar_curve(const lw_linkage *k, size_t n, double *x, double *y, double *angle)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    CHECK_INT(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, k, dim, mode, &input, NULL), LW_OK);
    for (size_t i = 0; i < n; i++) {
        lw_posture posture;
        angle[i] = 2*LW_PI*(double)i/(double)n;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + angle[i], 0, &posture), LW_OK);
        x[i] = posture.tracer[0][0].x;
        y[i] = posture.tracer[0][0].y;
    }
}

/* The same as a target; without angles when `timed` is false. */
static inline void six_bar_target(const lw_linkage *k, size_t n, bool timed, lw_target *t)
{
    double *v = malloc(sizeof *v*3*n);
    six_bar_curve(k, n, v, v + n, v + 2*n);
    CHECK_INT(lw_target_make(n, v, v + n, NULL, timed ? v + 2*n : NULL, NULL, 1, t, NULL), LW_OK);
    free(v);
}

#endif

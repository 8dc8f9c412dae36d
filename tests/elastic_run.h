/* tests/elastic_run.h - elastic links in space, read from a text with its numbers, and their runs and frequencies. */
#ifndef LW_TESTS_ELASTIC_RUN_H
#define LW_TESTS_ELASTIC_RUN_H

#include "mbs/elastic/expand_space.h"
#include "mbs/equilibrium/modes.h"
#include "tests/space_run.h"
#include "tests/temporary.h"

#define SQUARE "{'shape': 'rectangle', 'width': 0.1, 'height': 0.1}"
#define STEEL  "{'E': 210e9, 'nu': 0.3, 'density': 7850}"

static lw_status read_text(lw_spatial *m, lw_error *e, const char *format, ...) __attribute__((format(printf, 3, 4), unused));
static lw_status read_text(lw_spatial *m, lw_error *e, const char *format, ...)
{
    static char text[1 << 16];
    va_list arg;
    va_start(arg, format);
    vsnprintf(text, sizeof text, format, arg);
    va_end(arg);
    json_quotes(text);
    *e = (lw_error){ 0 };
    return lw_spatial_read(text, strlen(text), "test", m, e);
}

/* Run m, which is freed. */
static inline void run(lw_spatial *m, lw_dynamics_options o, srun *r)
{
    srun_go(m, &o, r);
    lw_spatial_free(m);
}

/* The slowest frequencies about the posture of the file [Hz]. */
static inline void frequencies(lw_spatial *m, bool hold, int n, double *out)
{
    OWN(lw_modes) modes = { 0 };
    lw_dynamics_options o = lw_dynamics_options_default();
    lw_dynamics *d;
    o.analysis = LW_ANALYSIS_STATIC;
    o.hold_inputs = hold;
    lw_status st = lw_dynamics_make_spatial(m, &o, &d, &check_error);
    memset(out, 0, (size_t)n*sizeof *out);
    if (st == LW_OK) {
        FREED double *q = calloc((size_t)lw_dynamics_space(d)->n_q + (size_t)lw_dynamics_space(d)->n_v, sizeof *q);
        lw_dynamics_start(d, q, q + lw_dynamics_space(d)->n_q);
        st = lw_modes_find_large(d, &(lw_modes_options){ .hold_inputs = hold }, n, 0, q, &modes, &check_error);
        for (int i = 0; i < n && i < modes.n_mode; i++)
            out[i] = modes.mode[i].frequency;
        CHECK(modes.n_mode >= n);
    }
    CHECK_OK(st);
    lw_dynamics_free(d);
    lw_spatial_free(m);
}

/* A bar of 2 m along x, clamped at 0, with a tracer and a force at its end; `more` belongs to "elastic". */
static inline lw_status read_bar(lw_spatial *m, const char *elastic, double gravity, double force)
{
    lw_status st = read_text(m, &check_error, "{'linkwright': 1, 'links': ['ground', {'name': 'bar', 'elastic': {%s}}], 'joints': [{'name': 'A', 'kind': "
                             "'fixed', 'links': ['ground', 'bar'], 'at': [0, 0, 0]}], 'tracers': [{'name': 'P', 'link': 'bar', 'at': [2, 0, "
                             "0]}], 'gravity': [0, 0, %.17g], 'forces': [{'link': 'bar', 'at': [2, 0, 0], 'fz': %.17g}]}", elastic, gravity, force);
    CHECK_OK(st);
    return st;
}

#define BAR "'section': {'shape': 'box', 'width': 0.05, 'height': 0.08, 'wall': 0.004}, 'height': [0, 0, 1], 'material': " STEEL \
            ", 'axis': [[0, 0, 0], [2, 0, 0]]"

#endif

/* tests/touch_run.h - a run of a planar model with contacts, which the tests of a file share. */
#ifndef LW_TESTS_TOUCH_RUN_H
#define LW_TESTS_TOUCH_RUN_H

#include "mbs/analysis/reactions.h"
#include "tests/dynamics_run.h"
#include "tests/planar_models.h"

OWNS(lw_dynamics)

static drun d;

static const double g = 9.81;

/* A model of the ground and one free link: its shape, mass and place, contact and gravity. */
#define FREE(ground, link, shape, contact)                                                                    \
    "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [" ground "]}, {'name': 'b', " link             \
    ", 'shapes': [" shape "]}], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', 'b']}],"            \
    " 'contacts': [{'name': 'c', 'links': ['ground', 'b'], " contact "}], 'gravity': [0, -9.81],"             \
    " 'tracers': [{'name': 'P', 'link': 'b', 'at': [0, 0]}]}"
#define FLOOR "{'line': [[0, 0], [1, 0]]}"

static inline void free_model(const char *format, double a, double b)
{
    drun_read_format(&d, format, a, b);
}

static inline double state(const double *q, int i) { return q[i]*(i%3 < 2 ? d.system.unit : 1); }

/* The drive, the first contact and the first joint of the last moment kept. */
typedef struct carried { const lw_dynamics *d; double drive; lw_vec2 contact; lw_reaction pin; } carried;

static inline lw_status keep_carried(void *context, const lw_moment *m)
{
    carried *z = context;
    double rope[1];
    lw_reactions_driving(z->d, m, &z->drive);
    lw_reactions_joints(z->d, m, &z->pin);
    lw_reactions_contacts(z->d, m, &z->contact, rope);
    return LW_OK;
}

/* Analyse the model in d, which stays. */
static inline lw_status carry(lw_analysis analysis, double to, int intervals, carried *z, lw_moment_sink *keep)
{
    OWNED(lw_dynamics) *m = NULL;
    lw_rest rest;
    d.o.analysis = analysis;
    d.o.to = to;
    d.o.intervals = intervals;
    d.e.text[0] = 0;
    lw_status s = lw_dynamics_make(&d.model, &d.o, &m, &d.e);
    z->d = m;
    s = s == LW_OK ? lw_dynamics_analyse(m, keep, z, &d.report, &rest, &d.e) : s;
    return s;
}

#endif

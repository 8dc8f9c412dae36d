/* mbs/space/space_run.h - how a spatial model moves in time and what its joints carry: kinematics with forces where the
 * inputs leave no freedom, dynamics else, and equilibrium.
 *
 *     driven   postures by continuation along the motions of the inputs; forces from J^T l = Q - M a
 *     index1   M a + J^T l = Q with J a = c in every evaluation, explicit method of order 8 in places, quaternions and
 *              velocities; the state is put back on the constraints after every step
 *     cvode    the same equations by an implicit method, where dampers make them stiff */
#ifndef LW_MBS_SPACE_SPACE_RUN_H
#define LW_MBS_SPACE_SPACE_RUN_H

#include <signal.h>
#include "mbs/space/space_forces.h"
#include "mbs/space/space_trace.h"

typedef enum lw_space_analysis {         /* as those of planar models, in the same order (lw_analysis) */
    LW_SPACE_TRANSIENT, LW_SPACE_STATIC, LW_SPACE_QUASISTATIC, LW_SPACE_KINEMATIC, LW_SPACE_DYNAMIC
} lw_space_analysis;

typedef enum lw_space_formulation {
    LW_SPACE_AUTO, LW_SPACE_DRIVEN, LW_SPACE_INDEX1, LW_SPACE_CVODE, LW_SPACE_EQUILIBRIUM
} lw_space_formulation;
const char *lw_space_formulation_name(lw_space_formulation f);      /* "index1" */

typedef struct lw_space_options {
    lw_space_analysis analysis;
    lw_space_formulation formulation;    /* auto, driven, index1, cvode */
    double from, to;             /* [s] */
    int    intervals;            /* samples less one */
    double relative;             /* error of a step: of angles, and of lengths over the size */
    long   max_step;             /* 0: no limit */
    double until;                /* lw_clock_wall at which to stop; 0: no limit */
    const volatile sig_atomic_t *stop;
} lw_space_options;

lw_space_options lw_space_options_default(void);     /* transient, 0 to 1 s, 100 intervals, 1e-10 */

typedef lw_spatial_reaction lw_space_reaction;

/* One moment; arrays are the solver's. */
typedef struct lw_space_moment {
    double t;
    const double *q, *v, *a;
    const lw_space_frame *frame;
    const double *input, *input_rate;    /* (n_input) as people count them */
    const double *drive;                 /* force [N] or torque [N m] of each drive (or input,
                                                                                     if the model has no drives);
                                            0 for inputs that run freely */
    const lw_space_reaction *joint;      /* on link[1], about the joint's point there, ground axes */
    double kinetic, potential, work;     /* [J]; work since the start, NaN in a driven run */
    double off, off_rate;                /* greatest residual of the rows, and of their rates */
} lw_space_moment;

typedef lw_status lw_space_moment_sink(void *context, const lw_space_moment *m);

typedef struct lw_space_report {
    lw_space_formulation formulation;
    char   why[256];
    int    unknowns, freedom, redundant, idle;
    long   steps, refused, rates, samples;
    double worst_off, worst_off_rate;
    double energy_error, energy_scale;   /* of dynamics: greatest |E - E(start) - work| [J]; greatest energy */
    double t;
    bool   stable;               /* of an equilibrium: every small displacement raises the potential */
} lw_space_report;

typedef struct lw_space_run lw_space_run;

/* The model must outlive the run.  LW_E_ARG: a mass is missing, the inputs or velocities contradict the joints;
 * LW_E_KIND: the model has what is not handled; LW_OPEN: the start cannot be closed. */
lw_status lw_space_run_make(const lw_spatial *m, const lw_space_options *o, lw_space_run **out, lw_error *e);
void      lw_space_run_free(lw_space_run *r);
const lw_space        *lw_space_run_space(const lw_space_run *r);
const lw_space_report *lw_space_run_report(const lw_space_run *r);

/* Run and hand out all samples; static: one, the equilibrium near the posture of the file. */
lw_status lw_space_run_go(lw_space_run *r, lw_space_moment_sink *sink, void *context, lw_error *e);

/* Motion of all links (n_link) at a moment of a run. */
void lw_space_links(const lw_space *s, const lw_space_moment *m, lw_frame_motion *out);

/* Names of joints whose reactions are not unique, " A B"; they are given with the least norm. */
void lw_space_run_redundant(const lw_space_run *r, char *text, size_t size);

#endif

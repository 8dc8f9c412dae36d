/* mbs/clearance/clearance_sweep.h - a model with clearance over speeds of its input and laws of contact.
 *
 * A law is one choice of model, stiffness and damping for all joints with clearance; models without a stiffness ("zero", "link") or without a damping
 * (all but "mlsd" and "impact") are run once, with those of the file, and a list that none of the models feels is refused.  Every law runs at every speed,
 * on several threads; the results do not depend on their number. */
#ifndef LW_MBS_CLEARANCE_CLEARANCE_SWEEP_H
#define LW_MBS_CLEARANCE_CLEARANCE_SWEEP_H

#include "mbs/clearance/clearance.h"

#define LW_SWEEP_RUN_MAX 1000000

/* The arrays are the caller's and must outlive the sweep. */
typedef struct lw_sweep_options {
    const lw_clearance_model *model;      /* (n_model), (n_stiffness) [N/m], (n_damping) [N s/m]; none: as the model of
                                             the linkage has them */
    const double *stiffness, *damping;
    const double *speed;                  /* (n_speed), 1 or more, of input 0 at the start, in `unit` */
    int    n_model, n_stiffness, n_damping, n_speed;
    double unit;                          /* of the speeds [rad/s] or [m/s] */
    lw_clearance_options run;             /* of every run, speed aside */
    bool   passes;                        /* keep the passes of each run */
    double refine;                        /* > 0: halve the limits to this width, in `unit` */
    int    jobs;                          /* threads; below 1: one a core */
    void (*progress)(void *context, int n_done, int n_run);    /* called in the first thread; may be NULL */
    void  *context;
} lw_sweep_options;

/* One law, with a copy of the model that has it. */
typedef struct lw_sweep_law {
    lw_clearance_model  model;            /* these three: of the first joint with clearance */
    double              stiffness, damping;
    lw_model           *m;
    lw_clearance       *clearance;       /* of m */
    lw_clearance_scene *scene;
} lw_sweep_law;

/* The pin of the first joint each time the input passes its start. */
typedef struct lw_sweep_pass {
    double direction;                     /* of the pin in its bush [deg] */
    bool   touching;
} lw_sweep_pass;

typedef struct lw_sweep_row {
    int       law;
    double    speed;                      /* in `unit` */
    bool      done;                       /* false: a limit came first */
    lw_status status;
    lw_clearance_result r;
    char      why[256];                   /* of a failure */
    int       n_pass, most_pass;
    lw_sweep_pass *pass;                  /* (n_pass) after the time to settle */
} lw_sweep_row;

/* The speeds between which contact ends and comes back as the speed rises, of one law and joint; NAN: not within the
 * sweep. */
typedef struct lw_sweep_limit {
    int    law, joint;
    double kept, lost;                    /* the first pair of neighbouring speeds with and without contact */
    double lost_again, kept_again;        /* the last pair the other way round */
    int    n_lost, n;                     /* runs in which contact is lost; all */
} lw_sweep_limit;

typedef struct lw_sweep {
    const lw_model  *m;
    lw_sweep_options o;
    int n_law, n_row, n_limit;
    lw_sweep_law   *law;
    lw_sweep_row   *row;                  /* by law, then by speed */
    lw_sweep_limit *limit;                /* by law, then by joint */
} lw_sweep;

/* Make the laws; m must outlive the sweep.  LW_E_ARG: more than LW_SWEEP_RUN_MAX runs; failures of lw_clearance_make.
 * lw_sweep_free is due after a failure too. */
lw_status lw_sweep_make(const lw_model *m, const lw_sweep_options *o, lw_sweep *s, lw_error *e);
void      lw_sweep_free(lw_sweep *s);

/* Run all and find the limits.  Runs that fail say so in their rows. */
lw_status lw_sweep_run(lw_sweep *s, lw_error *e);

#endif

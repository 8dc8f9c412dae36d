/* mbs/clearance/clearance.h - a linkage with clearance in some of its pins (Makkonen 1999, section 5.2 and paper C).
 *
 * link[0] of the joint carries the bush, link[1] the pin.  A force between the two centres (mbs/elastic/contact.h)
 * replaces the two rows of the joint.  The model `link` keeps the distance of the centres; `zero` keeps the joint and
 * judges its reaction.  The motion is found in the coordinates of a tree of the other joints, by the explicit method of
 * order 8; contact made and lost is located as events.
 *
 * A scene is constant once made: threads may run it at the same time. */
#ifndef LW_MBS_CLEARANCE_CLEARANCE_H
#define LW_MBS_CLEARANCE_CLEARANCE_H

#include <signal.h>
#include "grammar/model/model.h"

#define LW_CLEARANCE_JOINT_MAX 8
#define LW_CLEARANCE_STOP_MAX  16

typedef struct lw_clearance_scene lw_clearance_scene;

/* The model must outlive the scene.  LW_E_ARG: no joint with clearance, more than LW_CLEARANCE_JOINT_MAX, or one
 * that is no pin; a gap or a stiffness that is not positive; a missing mass (the link is named); more than
 * LW_CLEARANCE_STOP_MAX rigid stops.  LW_E_KIND: friction at a massless link, which has no surface. */
lw_status lw_clearance_make(const lw_model *m, lw_clearance_scene **scene, lw_error *e);
void      lw_clearance_free(lw_clearance_scene *scene);

/* Place of the pin in the bush at the start; posture and input are those of the file in each case. */
typedef enum lw_clearance_start {
    LW_CLEARANCE_CLOSED,             /* centres at one place, all links at the speeds of the closed linkage */
    LW_CLEARANCE_SEATED,             /* pressed in, and moving, as the reaction without clearance demands */
    LW_CLEARANCE_CRANK               /* as closed, but only the driven link moves (Makkonen 1999, paper C, 7e) */
} lw_clearance_start;

typedef struct lw_clearance_sample {
    double t;
    double input, input_rate;        /* of input 0 [rad] or [m]; 0 without an input */
    double energy;                   /* kinetic, and of gravity, springs and contacts [J] */
    int    n_point;
    lw_clearance_point point[LW_CLEARANCE_JOINT_MAX];
} lw_clearance_sample;

/* Takes a sample.  LW_OK: go on; else the run ends with that status. */
typedef lw_status lw_clearance_sink(void *context, const lw_clearance_sample *s);

typedef struct lw_clearance_options {
    double time, settle;             /* end; start of judging contact [s]; 1.25, 0.4 */
    double tolerance;                /* error of a step, lengths in sizes of the linkage; 1e-9; at most a 500th of a
                                        gap and a tenth of the depth of the damping */
    double speed;                    /* of input 0 at the start [rad/s] or [m/s]; NAN: the model's */
    lw_clearance_start start;
    long   max_step;                 /* 0: no limit */
    double until;                    /* time of lw_clock_wall at which to stop; 0: no limit */
    const volatile sig_atomic_t *stop;   /* the run ends when it is not 0; may be NULL */
    double every;                    /* time between samples [s]; 0: none */
    lw_clearance_sink *sink;
    lw_clearance_sink *strobe;       /* takes a sample each time input 0 passes its start, also after whole turns;
                                        NULL: none.  Its status is ignored */
    void  *context;
} lw_clearance_options;

lw_clearance_options lw_clearance_options_default(void);

typedef struct lw_clearance_result {
    int    n_joint;
    lw_clearance_outcome joint[LW_CLEARANCE_JOINT_MAX];
    double t;                        /* time reached */
    double speed_least, speed_most;  /* of input 0 after settle */
    double energy_first, energy_last;/* [J] */
    long   strikes;                  /* on rigid stops */
    long   steps, refused, rates, events;
} lw_clearance_result;

/* LW_OK; LW_STOPPED (max_step, until, stop); the status of the sink; LW_E_NUMERIC, LW_OPEN: e says where the run
 * broke off, and r holds the results till then. */
lw_status lw_clearance_run(const lw_clearance_scene *scene, const lw_clearance_options *o, lw_clearance_result *r, lw_error *e);

#endif

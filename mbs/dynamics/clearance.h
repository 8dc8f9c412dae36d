/* mbs/dynamics/clearance.h - a linkage some of whose pins have clearance (Makkonen 1999, section 5.2 and paper C).
 *
 * Joint link[0] carries the bush, link[1] the pin.  The joint's two rows are taken away and a force between the two
 * centres (mbs/dynamics/contact.h) takes their place; `link` keeps the distance of the centres, `zero` keeps the joint and
 * looks at its reaction.  Motion in the coordinates of a tree of the other joints, by the explicit method
 * of order 8, contact made and lost located as events.
 *
 * A scene is const once made: threads may run it side by side. */
#ifndef LW_MBS_DYNAMICS_CLEARANCE_H
#define LW_MBS_DYNAMICS_CLEARANCE_H

#include <signal.h>
#include "grammar/model.h"

#define LW_CLEARANCE_JOINT_MAX 8
#define LW_CLEARANCE_STOP_MAX  16

typedef struct lw_clearance_scene lw_clearance_scene;

/* The model must outlive the scene.  LW_E_ARG: no joint with clearance, more than LW_CLEARANCE_JOINT_MAX, one that
 * is no pin, a gap that is not positive, a law without stiffness; a mass that is missing (the link is named); more than
 * LW_CLEARANCE_STOP_MAX rigid stops.  LW_E_KIND: friction at a massless link, which has no surface. */
lw_status lw_clearance_make(const lw_model *m, lw_clearance_scene **scene, lw_error *e);
void      lw_clearance_free(lw_clearance_scene *scene);

/* How pin and bush stand to each other at the start; posture and input are those of the file in each case. */
typedef enum lw_clearance_start {
    LW_CLEARANCE_CLOSED,             /* centres on each other, all links at the speeds of the closed linkage */
    LW_CLEARANCE_SEATED,             /* pressed in and moving as the reaction without clearance asks   */
    LW_CLEARANCE_CRANK               /* as closed, but only the driven link moves (Makkonen 1999, paper C, 7e) */
} lw_clearance_start;

typedef struct lw_clearance_sample {
    double t;
    double input, input_rate;        /* of input 0, as it counts [rad] or [m]; 0 without an input       */
    double energy;                   /* kinetic, of gravity, of springs and contacts [J]               */
    int    n_point;
    lw_clearance_point point[LW_CLEARANCE_JOINT_MAX];
} lw_clearance_sample;

/* LW_OK goes on; else the run ends with that status. */
typedef lw_status lw_clearance_sink(void *context, const lw_clearance_sample *s);

typedef struct lw_clearance_options {
    double time, settle;             /* run from 0 to time; contact counts after settle [s]; 1.25, 0.4 */
    double tolerance;                /* of a step, of lengths in sizes of the linkage; 1e-9; never coarser than a 500th
                                        of a gap and a tenth of the depth of the damping step */
    double speed;                    /* of input 0 at the start [rad/s] or [m/s]; NAN: the model's      */
    lw_clearance_start start;
    long   max_step;                 /* 0: no limit                                                   */
    double until;                    /* of lw_clock_wall; 0: no limit                                 */
    const volatile sig_atomic_t *stop;   /* not 0: end here; may be NULL                              */
    double every;                    /* time between samples [s]; 0: none                              */
    lw_clearance_sink *sink;
    lw_clearance_sink *strobe;       /* handed a sample each time input 0 is, whole turns aside, where it started; NULL:
                                        none.  What it returns is not looked at */
    void  *context;
} lw_clearance_options;

lw_clearance_options lw_clearance_options_default(void);

typedef struct lw_clearance_result {
    int    n_joint;
    lw_clearance_outcome joint[LW_CLEARANCE_JOINT_MAX];
    double t;                        /* how far it came                                                */
    double speed_least, speed_most;  /* of input 0 after settle                                        */
    double energy_first, energy_last;/* [J]                                                            */
    long   strikes;                  /* on rigid stops                                                 */
    long   steps, refused, rates, events;
} lw_clearance_result;

/* LW_OK, LW_STOPPED (max_step, until, stop), what the sink said; LW_E_NUMERIC, LW_OPEN: where it broke is in e, what
 * was found till then in r. */
lw_status lw_clearance_run(const lw_clearance_scene *scene, const lw_clearance_options *o, lw_clearance_result *r,
                           lw_error *e);

#endif

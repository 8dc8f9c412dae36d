/* mbs/plan.h - how the pose of a linkage is worked out: a plan made once from its topology, then
 * evaluated many times with the caller's memory.
 *
 * A plan is a list of closed-form steps: the input link, then one Assur dyad after the other (RRR,
 * RRP, RPR, PRP, PPR), then the tracer points; only what the wanted outputs depend on is in it.
 * It knows no numbers.  The numbers are
 *     dim[n_dim]    dimensions, read off a posture by lw_plan_read or chosen by an optimiser,
 *     mode[n_dyad]  +1 or -1 per dyad, which of its two assemblies; ignored for PRP and PPR,
 *     the input     as a unit vector (cos, sin) for a pin, as (displacement, 0) for a slider.
 *
 * Frames.  Everything is worked out in the ground frame of the linkage (origin: first ground pin;
 * x axis: towards the second ground pin, else along the first ground slide; see lw_plan_make), where
 * coordinates are of the size of the links, and moved into the plane at the end by x0, y0, theta0:
 *     P = (x0, y0) + e^{i theta0} p.
 * The input angle is counted from the x axis of the GROUND FRAME, counter-clockwise.
 * Each moving link has a frame too: origin at the joint by which its dyad found it, x axis towards
 * its next joint (pin) or along its slide.
 *
 * Names of dimensions follow the links, numbered in the order in which the plan meets them, ground 1,
 * input link 2 ("r1 r2 r3 r4 cx cy x0 y0 theta0" for a four-bar with its tracer on the coupler):
 *     r<k>     distance of the first two pins of link k                      length, > 0
 *     e<k>     signed distance of a slide line from the origin of link k, positive to the left of the
 *              line's direction                                             coordinate
 *     beta<k>  direction of a further slide line in the frame of link k      angle
 *     x<k>_<j> y<k>_<j>   a further pin (joint number j) on link k           coordinate
 *     cx cy    the first tracer in the frame of its link (cx2 cy2 the next)  coordinate
 *     x0 y0    place of the ground frame                                     coordinate
 *     theta0   its angle                                                     angle
 */
#ifndef LW_MBS_PLAN_H
#define LW_MBS_PLAN_H

#include <stddef.h>
#include "grammar/linkage.h"

#define LW_DIM_MAX   64
#define LW_DYAD_MAX  16
#define LW_STEP_MAX  96
#define LW_REG_MAX  128

typedef enum lw_dim_kind { LW_DIM_LENGTH, LW_DIM_COORDINATE, LW_DIM_ANGLE } lw_dim_kind;

typedef struct lw_dim_info {
    char        name[16];
    lw_dim_kind kind;         /* length and coordinate scale with the linkage, angle does not    */
    int         link;         /* the link it belongs to (index in the linkage)                   */
} lw_dim_info;

typedef enum lw_step_kind {
    LW_STEP_INPUT_PIN,        /* direction of the input link from the input                      */
    LW_STEP_INPUT_SLIDE,      /* origin of the input link from the input                         */
    LW_STEP_POINT,            /* point on a link                                                 */
    LW_STEP_LINE,             /* slide line on a link: a point of it and its direction           */
    LW_STEP_RRR, LW_STEP_RRP, LW_STEP_RPR, LW_STEP_PRP, LW_STEP_PPR
} lw_step_kind;

/* in[], out[] are register numbers, dim[] dimension numbers, -1 where unused; the meaning by kind
 * stands at the kernels in mbs/plan_make.c. */
typedef struct lw_step {
    lw_step_kind kind;
    int in[4], out[4], dim[3], dyad;
} lw_step;

typedef struct lw_plan {
    int         n_dim, n_dyad, n_step, n_reg, n_output;
    bool        input_is_slider;
    lw_dim_info dim[LW_DIM_MAX];
    lw_step     step[LW_STEP_MAX];
    int         i_x0, i_y0, i_theta0;             /* where these stand in dim                     */
    int         output_point[LW_TRACER_MAX];      /* register of each output's point ...          */
    int         output_dir[LW_TRACER_MAX];        /* ... and of the direction of its link         */
    int         output_link[LW_TRACER_MAX];
    int         i_cx[LW_TRACER_MAX], i_cy[LW_TRACER_MAX];   /* its coordinates in dim, or -1      */
    int         link_origin[LW_LINK_MAX];         /* registers of each link's frame, -1: left out */
    int         link_dir[LW_LINK_MAX];
    int         joint_point[LW_JOINT_MAX];        /* register of each joint's pin, -1: left out   */
    const struct lw_kernels *kernels;             /* chosen for this processor                    */
} lw_plan;

/* What a caller wants worked out. */
typedef struct lw_want {
    unsigned tracers;         /* bit i: tracer i                                                  */
    bool     all_joints;      /* every joint and link too (for drawings and traces)               */
} lw_want;

/* Make the plan.  LW_E_KIND, with a text saying which links are left over, when the linkage is not
 * a chain of one input and dyads; other failures as lw_linkage_check. */
lw_status lw_plan_make(const lw_linkage *k, lw_want want, lw_plan *plan, lw_error *e);

/* Read dimensions, modes and input value [rad] or [m] off the posture of k (the linkage the plan was
 * made from, or another of the same topology).  LW_E_ARG when the posture contradicts itself. */
lw_status lw_plan_read(const lw_plan *plan, const lw_linkage *k, double *dim, double *mode,
                       double *input, lw_error *e);

/* The other way: put the posture at `input` with these dimensions into k, which brings the topology
 * and names.  Needs a plan with all_joints.  LW_OPEN when it cannot close there. */
lw_status lw_plan_write(const lw_plan *plan, const double *dim, const double *mode, double input,
                        lw_linkage *k);

/* Index of a dimension by name, -1 if there is none. */
int lw_plan_dim(const lw_plan *plan, const char *name);

#endif

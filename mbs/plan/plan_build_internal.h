/* mbs/plan/plan_build_internal.h - a plan while it is being made (mbs/plan/plan_steps.c, mbs/plan/plan_higher.c).  Not
 * for users of the library. */
#ifndef LW_MBS_PLAN_PLAN_BUILD_INTERNAL_H
#define LW_MBS_PLAN_PLAN_BUILD_INTERNAL_H

#include "mbs/plan/plan_internal.h"

typedef struct lw_builder {
    const lw_topology *t;
    lw_plan *p;
    int      number[LW_LINK_MAX];          /* in the names of dimensions: ground 1, input 2, ...    */
    int      pin_reg[LW_JOINT_MAX];        /* register of each pin (first joint), -1: not yet        */
    int      place[LW_DIM_MAX];            /* sort key of each dimension                             */
    int      n_named[LW_LINK_MAX][LW_ROLE_MIDDLE - LW_ROLE_E + 1];     /* of each role from e on, so far */
    int      input_reg;                    /* of an input between moving links                       */
    int      period_reg;                   /* unit vector of the plan's input: what even gears turn by */
    bool     full;                         /* a table of the plan overflowed                         */
} lw_builder;

static inline bool lw_build_is_slider(const lw_builder *b, int j)
{
    return b->t->k->joint[j].kind == LW_JOINT_SLIDER;
}

/* New registers, steps and dimensions; the same dimension asked for again is not new. */
int      lw_build_reg(lw_builder *b);
lw_step *lw_build_step(lw_builder *b, lw_step_kind kind);
int      lw_build_dim(lw_builder *b, lw_dim_role role, int link, int joint, int count);

/* Where a pin (first joint) sits on a link, and a slide line: dimensions, -1 for 0. */
void lw_build_pin_dims(lw_builder *b, int link, int pin, int *x, int *y);
void lw_build_line_dims(lw_builder *b, int j, int base, int *e, int *beta);

/* Registers of points and lines of links that are known; steps are added where needed. */
int  lw_build_point(lw_builder *b, int link, int dim_x, int dim_y);
int  lw_build_pin(lw_builder *b, int joint, int base);
void lw_build_line(lw_builder *b, int j, int base, int *q, int *w);

void lw_build_link(lw_builder *b, int link, int origin, int dir);
void lw_build_slider(lw_builder *b, int j, int base, int ref);

/* The frame of a link that turns on this pin. */
lw_frame lw_build_turning_frame(const lw_builder *b, int link, int pin);

/* The direction of a driven link from the input's; a wheel, pinion or rack; a row of a higher group, from the numbers
 * of the directions of the gear's links and its carrier (-1: they do not turn) and of a rack's displacement (-1:
 * wheels). */
int  lw_build_turns_per_period(lw_builder *b, int input);
void lw_build_gear(lw_builder *b, const lw_plan_group *g);
void lw_build_gear_frame(lw_builder *b, const lw_plan_group *g);
lw_higher_gear lw_build_gear_row(lw_builder *b, int joint, const int *dir, int disp);

/* A link at a displacement along a line. */
void lw_build_ride(lw_builder *b, int link, int q, int w, int along);

/* Frames of a higher group's links; then its step and those that follow from it. */
void lw_build_higher_frames(lw_builder *b, const lw_cluster *c);
void lw_build_rack_frame(lw_builder *b, const lw_plan_group *g);
void lw_build_higher(lw_builder *b, const lw_cluster *c);
void lw_build_higher_renumber(lw_higher *g, const int *to);
void lw_build_higher_angle(lw_higher *g, int dim, int number);
/* Is one of the registers the group puts out needed?  Then so are those it takes. */
bool lw_build_higher_needs(const lw_higher *g, bool *need);

#endif

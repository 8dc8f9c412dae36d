/* mbs/plan/plan_build_internal.h - functions that add to a plan while it is being made.  Not for users of the
 * library. */
#ifndef LW_MBS_PLAN_PLAN_BUILD_INTERNAL_H
#define LW_MBS_PLAN_PLAN_BUILD_INTERNAL_H

#include "mbs/plan/plan_internal.h"

typedef struct lw_builder {
    const lw_topology *t;
    lw_plan *p;
    int      number[LW_LINK_MAX];          /* of links in names of dimensions: ground 1, input 2, ... */
    int      pin_reg[LW_JOINT_MAX];        /* register of each pin (first joint); -1: none yet       */
    int      place[LW_DIM_MAX];            /* sort key of each dimension                             */
    int      n_named[LW_LINK_MAX][LW_ROLE_MIDDLE - LW_ROLE_E + 1];     /* dimensions of each role from e on, so far */
    int      input_reg;                    /* register of an input between moving links              */
    int      period_reg;                   /* register of the unit vector of the plan's input       */
    bool     full;                         /* a table of the plan overflowed                         */
} lw_builder;

static inline bool lw_build_is_slider(const lw_builder *b, int j)
{
    return lw_joint_translates(b->t->k->joint[j].kind);
}

/* Add a register, a step, a dimension.  A dimension that exists already is returned again. */
int      lw_build_reg(lw_builder *b);
lw_step *lw_build_step(lw_builder *b, lw_step_kind kind);
int      lw_build_dim(lw_builder *b, lw_dim_role role, int link, int joint, int count);

/* Dimensions of a pin (first joint) on a link, and of the line of slider j on link `base`; -1: the value is 0. */
void lw_build_pin_dims(lw_builder *b, int link, int pin, int *x, int *y);
void lw_build_line_dims(lw_builder *b, int j, int base, int *e, int *beta);

/* Registers of a point of a known link, of a pin on it, of the line of slider j on it (point q and direction w).  Steps
 * are added where they are missing. */
int  lw_build_point(lw_builder *b, int link, int dim_x, int dim_y);
int  lw_build_pin(lw_builder *b, int joint, int base);
void lw_build_line(lw_builder *b, int j, int base, int *q, int *w);

/* Set the registers of a link's frame; the link that carries a slide line and the pin whose path the line is. */
void lw_build_link(lw_builder *b, int link, int origin, int dir);
void lw_build_slider(lw_builder *b, int j, int base, int ref);

/* The frame of a link that turns on this pin. */
lw_frame lw_build_turning_frame(const lw_builder *b, int link, int pin);

/* The register of the driven link's direction, from that of the plan's input. */
int  lw_build_turns_per_period(lw_builder *b, int input);

/* Add the steps of a wheel, pinion or rack; set the frame of a wheel or pinion. */
void lw_build_gear(lw_builder *b, const lw_plan_group *g);
void lw_build_gear_frame(lw_builder *b, const lw_plan_group *g);

/* The equation of a gear in a higher group.  dir: numbers of the directions of the gear's links and of its carrier, -1:
 * fixed; disp: number of a rack's displacement, -1: wheels. */
lw_higher_gear lw_build_gear_row(lw_builder *b, int joint, const int *dir, int disp);

/* Add a link that slides on the line (q, w), by the displacement in register `along`. */
void lw_build_ride(lw_builder *b, int link, int q, int w, int along);

/* Set the frames of a higher group's links; of a rack, as of a link that is reached by a slide. */
void lw_build_higher_frames(lw_builder *b, const lw_cluster *c);
void lw_build_rack_frame(lw_builder *b, const lw_plan_group *g);

/* Add the step of a higher group and the steps that depend on it. */
void lw_build_higher(lw_builder *b, const lw_cluster *c);

/* Replace each number d of a dimension by to[d]; set the number in plan.angle of dimension `dim`. */
void lw_build_higher_renumber(lw_higher *g, const int *to);
void lw_build_higher_angle(lw_higher *g, int dim, int number);

/* Is an output register of the group needed?  If so, mark its input registers as needed. */
bool lw_build_higher_needs(const lw_higher *g, bool *need);

#endif

/* mbs/space/space_forces.h - masses and loads of a spatial model as generalised forces. */
#ifndef LW_MBS_SPACE_SPACE_FORCES_H
#define LW_MBS_SPACE_SPACE_FORCES_H

#include "mbs/space/space.h"

typedef struct lw_space_forces {
    const lw_space *s;
    lw_space_point (*spring_end)[2];     /* (n_spring) */
    lw_space_point  *force_at;           /* (n_force) */
    double          *turn;               /* (n_joint) turns accepted last, from which angles are counted */
    bool conservative;                   /* no dampers, motors, laws, forces */
    void *memory;
} lw_space_forces;

lw_status lw_space_forces_make(const lw_space *s, lw_space_forces *f, lw_error *e);
void      lw_space_forces_free(lw_space_forces *f);

/* Take the turns at a posture that is accepted. */
void lw_space_forces_accept(lw_space_forces *f, const lw_space_frame *frame);

/* Forces (n_v) [J] with gravity and what spinning bodies add; power of those without potential, unless NULL. */
void lw_space_forces_apply(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v,
                           double *force,
                           double *power);
/* Unit force of spring number `spring` (those between points, then those at joints), added to force (n_v). */
void lw_space_forces_unit(const lw_space_forces *f, const lw_space_frame *frame, int spring, double *force);

double lw_space_potential(const lw_space_forces *f, const lw_space_frame *frame);
double lw_space_kinetic(const lw_space *s, const double *v);

/* Linear momentum, and angular momentum about the origin (ground axes). */
void lw_space_momentum(const lw_space *s, const lw_space_frame *frame, const double *v, lw_vec3 *linear,
                       lw_vec3 *angular);

#endif

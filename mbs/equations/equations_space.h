/* mbs/equations/equations_space.h - the equations of motion of a spatial model (mbs/space). */
#ifndef LW_MBS_EQUATIONS_EQUATIONS_SPACE_H
#define LW_MBS_EQUATIONS_EQUATIONS_SPACE_H

#include "mbs/equations/equations.h"
#include "mbs/equations/flying.h"
#include "mbs/equations/friction.h"
#include "mbs/space/space_follow.h"
#include "mbs/space/space_forces.h"

/* Where the row of a joint or a measure finds its derivatives among the 12 of mbs/space/space.h: n groups of three. */
typedef struct lw_space_slots { int joint /* -1: a coupling, or a spin */, n, from[LW_ROW_BLOCKS], block[LW_ROW_BLOCKS]; } lw_space_slots;

typedef struct lw_spatial_scene {
    const lw_spatial *model;
    lw_space        s;
    lw_space_forces f;
    lw_space_frame *frame;                       /* (n_body + 1) at the q placed last */
    int             n_idle;                      /* spins of links between ball joints, which rows after the joints' hold */
    lw_space_extra *idle;                        /* (n_body) */
    lw_space_slots *slots;                       /* (n_row) */
    int             n_slot;                      /* of the equations */
    double         *sum;                         /* (6*s.n_side) derivatives of a coupling: scratch */
    lw_space_bend  *bend;                        /* (s.n_term*LW_SPACE_BENDS) scratch */
    lw_flying       flying;                      /* bodies that nothing joins to the ground */
    double         *mass;                        /* (n_v) with an inertia for each spin that is held */
    lw_space_follow follow;                      /* postures along the inputs that have a motion; memory NULL: not made */
    int             massless;                    /* a body whose mass or inertia was made up, and acts; -1: none */
    bool            has_drives, many_drives;     /* drives carry the forces of the inputs; more of them than freedoms */
    int             n_kink, n_jump;              /* of the equations */
    int             n_rub;                       /* joints whose friction drives carry, too */
    lw_space_rows_set drives;                    /* joints, spins, drives */
    lw_space_dense    drives_least;              /* the same, for drives that share a force */
    double           *drive_l, *drive_f;         /* scratch, of results too */
    lw_spatial_reaction *joint;                  /* (n_joint) */
    double         *pull;                        /* (n_coupling) forces of couplings */
} lw_spatial_scene;

/* The model must outlive c.  LW_E_MEMORY.  c needs lw_spatial_scene_free, after a failure too. */
lw_status lw_spatial_scene_make(const lw_spatial *m, lw_spatial_scene *c, lw_error *e);
void      lw_spatial_scene_free(lw_spatial_scene *c);

/* Hold the spin of a body about an axis (in its own axes), which changes nothing else; before the equations are taken. */
void lw_spatial_scene_hold(lw_spatial_scene *c, int body, lw_vec3 axis);

lw_equations lw_spatial_equations(lw_spatial_scene *c);

/* Give massless bodies masses and inertias: at rest they do not matter.  Otherwise LW_E_ARG names a link without mass. */
lw_status lw_spatial_weigh_massless(lw_spatial_scene *c, bool at_rest, lw_error *e);

/* Friction of joint f->joint for a reaction of `size` [N], at the posture placed last: generalised force, added to force (n_v);
 * returns its power [W].
 *
 *     revolute, prismatic     along the turn or the slide
 *     cylindrical             against the slip of the pin's surface, slide and turn together
 *     spherical               a torque against the relative angular velocity
 *     universal               about each of the two axes for itself */
double lw_spatial_rub(const lw_spatial_scene *c, const lw_friction_joint *f, const double *v, double size, double *force);

/* Numbers of measures in the layer. */
int                lw_spatial_number(const lw_spatial_scene *c, lw_spatial_measure of);
lw_spatial_measure lw_spatial_numbered(const lw_spatial_scene *c, int number);

#endif

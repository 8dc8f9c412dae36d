/* mbs/dynamics/reduced_internal.h - one freedom, one coordinate: the motion of a rigid linkage of dyads along its motion
 * curve; internal to mbs/.
 *
 *     M(s) s'' + M'(s)/2 s'^2 = Q(s, s'),     M = sum of m |c'|^2 + I phi'^2,   Q = sum of F.c' + T phi'
 *
 * (primes of c and phi: by the input s of the plan).  With p = sqrt(M) s', so that p^2/2 is the kinetic energy, it is
 *     s' = p/sqrt(M),   p' = Q/sqrt(M)
 * and M' is not wanted: p p' = s' (M s'' + M'/2 s'^2).  Everything comes from the plan's closed forms and their first
 * derivatives, nothing is solved.  Where a dyad passes through a position in which its two
 * assemblies meet and part again (change points: parallelograms), the velocities continue, so its mode
 * changes; near such a place, where the closed forms lose digits, M and Q are taken from a polynomial through
 * places beside it. */
#ifndef LW_MBS_DYNAMICS_REDUCED_INTERNAL_H
#define LW_MBS_DYNAMICS_REDUCED_INTERNAL_H

#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/plan/plan.h"

typedef struct lw_reduced lw_reduced;

/* A point with its derivative by the input; a direction: u in p, the rate of its angle in d.x. */
typedef struct lw_reg1 { lw_vec2 p, d; } lw_reg1;

/* A step of the plan with its numbers put in: r1 is the offset of RPR; sum2, dif2 = (r1 +- r2)^2. */
typedef struct lw_dyad_step {
    lw_step_kind kind;
    int     in[4], out[4], dyad;
    double  r1, r2, sum2, dif2, product, inv1, inv2, flat;
    lw_vec2 at, line;
} lw_dyad_step;

#define LW_TOUCH_MAX   32
#define LW_BRIDGE_SIZE 12             /* coefficients of a polynomial across a change point                */

/* Angles of a dyad's links across a change point: polynomials of (input - at)/reach. */
typedef struct lw_bridge { int dyad; double c[2][LW_BRIDGE_SIZE]; } lw_bridge;

/* A change point: the dyads that pass through it, and modes beyond it. */
typedef struct lw_change_point {
    double    at, reach;
    int       n_bridge;
    lw_bridge bridge[LW_DYAD_MAX];
} lw_change_point;

/* A body with mass; of one on a ground pin, which come first, the inertia is about the pin. */
typedef struct lw_mass_point { int origin, dir; lw_vec2 arm; double mass, inertia; lw_vec2 weight; } lw_mass_point;
typedef struct lw_end_point { int origin, dir; lw_vec2 arm; } lw_end_point;      /* origin -1: of ground   */

struct lw_reduced {
    lw_linkage linkage;
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_DYAD_MAX];
    int        n_step;                        /* steps that move and that something depends on            */
    lw_dyad_step step[LW_STEP_MAX];
    lw_reg1    reg[LW_REG_MAX];               /* of the last evaluation; those of ground stay              */
    double     known;                         /* the input whose registers these are; NAN: none            */
    double     first, start, scale;           /* input at the start, in the posture; unit of the coordinate */
    double     way;                           /* -1: the displacement of the input joint falls with s     */
    lw_vec2    z0, turn;                      /* ground frame in the plane                               */
    int        n_mass, n_pivot;
    lw_mass_point mass[LW_LINK_MAX];
    lw_end_point  centre[LW_LINK_MAX];        /* of body b                                               */
    lw_end_point  end[LW_LOAD_MAX][2], point[LW_LOAD_MAX];
    double     dir0[LW_LINK_MAX];             /* angle of each body's link in the posture                  */
    const lw_model *model;
    /* change points: touch[i] between piece i and i + 1; pieces from `first` on; period 0: none */
    int        n_touch;
    lw_change_point   touch[LW_TOUCH_MAX];
    double     piece_mode[LW_TOUCH_MAX + 1][LW_DYAD_MAX];
    double     low, high, period;             /* range that was looked through                            */
};

/* Makes d->reduced ready, once.  LW_E_KIND: the model is not of this kind, for the reason in d->not_reduced. */
lw_status lw_reduced_able(lw_dynamics *d);

/* The coordinate at the start and p = sqrt(M) s' there, by the velocities in y = (q, v) of the bodies. */
lw_status lw_reduced_start(lw_reduced *r, const lw_dynamics *d, const double *y, double *s, double *p);

/* A mass M so many times the least one means that a dead point is near.  There the links move like the square root of
 * the distance to it, which magnifies rounding and the allowed error of the coordinate too much. */
#define LW_REDUCED_TURNING_BACK 100

/* All registers at an input; LW_OPEN where the linkage does not close, or nearly not. */
lw_status lw_reduced_registers(lw_reduced *r, double input);

/* The same with given modes and bridges; *margin: least of all dyads, each in margin_of (n_dyad) if given. */
void lw_reduced_plain(lw_reduced *r, const double *mode, const lw_change_point *bridge, double input, double *margin_of,
                      double *margin);

/* Find the change points, looking from an input at which the modes are those of r->mode; false: at one of them the
 * assemblies come so near each other that which of them goes on cannot be told in closed form. */
bool lw_reduced_change_points(lw_reduced *r, double from);

/* s' and p' at (t, s, p), p = sqrt(M) s', and the power of what the potential does not hold. */
lw_status lw_reduced_rate(lw_reduced *r, double t, double s, double p, double *ds, double *dp, double *power);
lw_status lw_reduced_mass(lw_reduced *r, double s, double *mass);

/* A point of a link, with its derivative; origin -1: of ground. */
static inline lw_reg1 lw_reduced_point(const lw_reg1 *reg, int origin, int dir, lw_vec2 arm)
{
    if (origin < 0)
        return (lw_reg1){ arm, { 0, 0 } };
    const lw_reg1 *o = &reg[origin], *u = &reg[dir];
    lw_vec2 r = lw_v2_turn(arm, u->p);
    double w = u->d.x;
    return (lw_reg1){ lw_v2_add(o->p, r), lw_v2(o->d.x - w*r.y, o->d.y + w*r.x) };
}

/* At the registers [J], but for a constant. */
double lw_reduced_potential(const lw_reduced *r, double s);

/* System coordinates of every body at the registers and s'; turns are taken near those in q. */
void lw_reduced_state(const lw_reduced *r, const lw_dynamics *d, double ds, double *q, double *v);

#endif

/* mbs/dynamics/equations.h - the equations of motion of a scene as its solvers see them.
 *
 *     q' = G(q) v,   M v' = Q(t, q, v, z) - J^T l,   z' = f(t, q, v, z),   Phi(q) = 0,   J = dPhi/dq G
 *
 * The solvers know rows, blocks and numbers, and nothing of the plane: velocities come in blocks of one body each, a row
 * touches at most LW_SYSTEM_ROW_BODIES bodies, which never change, and a step moves q along v.  In the plane a body has
 * three coordinates and as many velocities, G is the unit matrix, and M is constant and diagonal (equations_planar.c).
 *
 * place comes first; what has no q of its own holds at the q placed last, what has no z at the z placed last. */
#ifndef LW_MBS_DYNAMICS_EQUATIONS_H
#define LW_MBS_DYNAMICS_EQUATIONS_H

#include "mbs/constraints/system_internal.h"
#include "mbs/dynamics/forces.h"

/* A second derivative of a row that is not 0: by coordinates a and b, and by b and a. */
typedef struct lw_bend { int a, b; double h; } lw_bend;
#define LW_BEND_MAX 8

typedef struct lw_equations {
    int   n_q, n_v;              /* coordinates; velocities                                             */
    int   n_body;                /* those of body b are v[LW_BODY_WIDTH*b] ..                            */
    int   n_row;                 /* rows of the joints                                                  */
    int   n_z;                   /* first-order states: currents, pressures, integrals                  */
    const double *mass;          /* (n_v) diagonal of M                                                 */
    void *context;
    /* The bodies of a row, and of the measure of a joint (rotation or displacement): each once, -1 after the last. */
    void   (*row_bodies)(void *context, int row, int body[LW_SYSTEM_ROW_BODIES]);
    void   (*measure_bodies)(void *context, int joint, int body[LW_SYSTEM_ROW_BODIES]);
    void   (*place)(void *context, const double *q);
    /* Rows phi (n_row) and J in blocks (lw_system_fill_blocks), added to jac. */
    void   (*rows)(void *context, double *phi, double *jac, lw_row_bodies *body);
    /* A measure and its derivatives, added to row. */
    double (*measure)(void *context, int joint, double *row, const int *body);
    /* What J v' has to be: minus the part of the second rate of the rows that velocities cause; added to out (n_row).  And
     * that part of the second rate of a measure. */
    void   (*bias)(void *context, const double *v, double *out);
    double (*measure_bias)(void *context, int joint, const double *v);
    /* Second derivatives of a row, at most LW_BEND_MAX; returns how many.  Not for gears and ties. */
    int    (*bends)(void *context, int row, lw_bend *out);
    /* Generalised forces (n_v) and the power of those without potential (unless NULL); their derivatives by q and v, to a
     * sink; all entries that these can have. */
    void   (*forces)(void *context, double t, const double *q, const double *v, double *force, double *power);
    void   (*derivatives)(void *context, double t, const double *q, const double *v, double *force,
                          const lw_force_sink *sink);
    void   (*pattern)(void *context, const lw_force_sink *sink);
    /* Take z (n_z); its rates; its values at the start; the size of state i against which its error counts. */
    void   (*place_states)(void *context, const double *z);
    void   (*state_rates)(void *context, double t, const double *q, const double *v, double *rate);
    void   (*state_start)(void *context, double t, const double *q, const double *v, double *z);
    double (*state_scale)(void *context, int i);
    double (*kinetic)(void *context, const double *v);
    double (*potential)(void *context, const double *q);
    /* Move q by a small displacement (n_v), on the manifold of coordinates; q' = G v. */
    void   (*move)(void *context, double *q, const double *by);
    void   (*rates)(void *context, const double *q, const double *v, double *dq);
} lw_equations;

#define LW_BODY_WIDTH 3          /* velocities of a body in the plane */

/* Equations of a planar model.  frames (n_body + 1) is scratch that holds the bodies at the q placed last. */
typedef struct lw_planar { const lw_system *s; const lw_forces *f; lw_body_frame *frames; } lw_planar;
lw_equations lw_planar_equations(lw_planar *p);

#endif

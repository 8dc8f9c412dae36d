/* mbs/equations/equations.h - the equations of motion of a scene as its solvers see them.
 *
 *     q' = G(q) v,   M v' = Q(t, q, v, z) - J^T l,   z' = f(t, q, v, z),   Phi(q) = 0,   J = dPhi/dq G
 *
 * The solvers know rows, blocks and numbers, and neither the plane nor space: velocities come in blocks of three, a row
 * touches few blocks, which never change, and a step moves q along v.  Lengths are in multiples of the
 * size of the scene, so forces are energies [J] and masses are in [kg m^2].  Two files fill this:
 *
 *     equations_planar.c    a block is a body: three coordinates, as many velocities, G is the unit matrix
 *     equations_space.c     a body has two blocks: velocity of its centre, and angular velocity in its principal axes; it has
 *                           7 coordinates, centre and quaternion, so n_q is not n_v
 *
 * M is constant and diagonal in both, but for superelements (more_inertia).  A measure is a number that a posture has, such as
 * the turn of a joint; how measures are numbered is the filler's.
 *
 * place comes first; what has no q of its own holds at the q placed last, what has no z at the z placed last. */
#ifndef LW_MBS_EQUATIONS_EQUATIONS_H
#define LW_MBS_EQUATIONS_EQUATIONS_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "mbs/equations/timed.h"

#define LW_BLOCK      3                      /* velocities of a block */
#define LW_ROW_BLOCKS 4                      /* most blocks that a measure touches, and a row of a joint */
#define LW_ROW_SIZE   (LW_BLOCK*LW_ROW_BLOCKS)

/* The derivative by velocity coordinate b of entry a of a row of J, where it is not 0. */
typedef struct lw_bend { int a, b; double h; } lw_bend;

/* Takes derivatives of forces; they are sums, so an entry may come several times. */
typedef struct lw_force_sink {
    void *context;
    void (*add)(void *context, int row, int column, double by_q, double by_v);
    /* The same for states: row n_v + i is the rate of state i, with by_q and by_v for a column below n_v; column n_v + k
     * is state k, with the derivative in by_q.  NULL: they are not wanted. */
    void (*add_state)(void *context, int row, int column, double by_q, double by_v);
} lw_force_sink;

typedef enum lw_named { LW_NAMED_BLOCK, LW_NAMED_ROW, LW_NAMED_MEASURE, LW_NAMED_INPUT, LW_NAMED_STATE } lw_named;

typedef struct lw_equations {
    int   n_q, n_v;              /* coordinates; velocities                                             */
    int   n_block;               /* those of block b are v[LW_BLOCK*b] ..                               */
    int   n_row;                 /* rows of the joints                                                  */
    int   n_slot;                /* blocks for which each row has room: LW_ROW_BLOCKS, more where a coupling needs them */
    int   bend_most;             /* second derivatives that a row or a measure has at most              */
    int   n_z;                   /* first-order states: currents, pressures, integrals                  */
    int   n_damper;              /* dampers and motors, for an estimate of how stiff they are           */
    const double *mass;          /* (n_v) diagonal of M                                                 */
    const double *z;             /* (n_z) states placed last                                           */
    const double *weight;        /* (n_v) generalised force of gravity in the posture of the file       */
    double unit;                 /* size of the scene [m]                                               */
    bool  conservative;          /* all forces have a potential                                         */
    bool  smooth;                /* forces and rows are accurate to rounding, with no steps or kinks    */
    bool  exact;                 /* derivatives and bends below are complete                            */
    void *context;
    /* Name of the link of a block, the joint of a row, ... */
    const char *(*name)(void *context, lw_named what, int index);
    /* block (n_slot, of a measure LW_ROW_BLOCKS): each once, -1 after the last */
    void   (*row_blocks)(void *context, int row, int *block);
    void   (*measure_blocks)(void *context, int measure, int *block);
    void   (*place)(void *context, const double *q);
    /* Rows phi (n_row) and J in blocks: derivatives by block[n_slot*r + k] at jac[LW_BLOCK*(n_slot*r + k)], added to jac. */
    void   (*rows)(void *context, double *phi, double *jac, int *block);
    /* A measure over its unit (1 rad, or `unit`), and its derivatives, added to row; the unit. */
    double (*measure)(void *context, int measure, double *row, const int *block);
    double (*measure_unit)(void *context, int measure);
    /* The right-hand side of J v' = out: minus the part of the second rate of the rows that velocities cause; added to out
     * (n_row).  measure_bias: this part of the second rate of a measure. */
    void   (*bias)(void *context, const double *v, double *out);
    double (*measure_bias)(void *context, int measure, const double *v);
    /* Second derivatives of a row, or of a measure over its unit; returns how many.  For vibrations and implicit steps. */
    int    (*bends)(void *context, int row, lw_bend *out);
    int    (*measure_bends)(void *context, int measure, lw_bend *out);
    /* Motion prescribed for an input at t: value of its measure, rate and second rate, over the unit.  LW_E_NUMERIC: a number
     * that is not finite. */
    lw_status (*motion)(void *context, int input, double t, double out[3]);
    /* Generalised forces (n_v) and the power of those without potential (unless NULL); their derivatives by q and v, to a
     * sink; all entries that these can have. */
    void   (*forces)(void *context, double t, const double *q, const double *v, double *force, double *power);
    void   (*derivatives)(void *context, double t, const double *q, const double *v, double *force, const lw_force_sink *sink);
    void   (*pattern)(void *context, const lw_force_sink *sink);
    /* Until the next call derivatives are taken with the tensions in elements that a small displacement `by` (n_v) from q changes linearly; by NULL:
     * with those at hand.  Newton's method needs it where elements resist stretch far more than bending.  NULL: there are no elements. */
    void   (*foresee)(void *context, const double *q, const double *by);
    /* Entries of the mass matrix besides its diagonal at q, to by_q of a sink (consistent masses of elements, which only
     * modes and equilibrium know, and of superelements).  NULL: there are none. */
    void   (*more_mass)(void *context, const double *q, const lw_force_sink *sink);
    /* The mass matrix depends on q.  Add to out (n_v) what it, less its diagonal, adds to the left-hand side for accelerations a.  Where the
     * strains of superelements are 0 its derivatives by a are more_mass.  NULL: M is `mass`. */
    void   (*more_inertia)(void *context, const double *q, const double *v, const double *a, double *out);
    /* Damper k as a coefficient [SI] and the gradient g (n_v, zeroed) of its measure in SI units, at (q, v). */
    double (*damper)(void *context, int k, const double *q, const double *v, double *g);
    /* Show the expressions of forces, motions and states (timed.h).  NULL: there are none. */
    void   (*expressions)(void *context, lw_expression_sink *see, void *of);
    lw_timed_values *values;
    /* Forces have smooth pieces, such as contacts that are open or closed.  How far a posture is from the end of its piece,
     * < 0 beyond it; take the piece that begins at (q, v), or at the start of a run.  NULL: there is one piece only. */
    double (*piece_left)(void *context, const double *q);
    void   (*next_piece)(void *context, const double *q, const double *v, bool start);
    void   (*watch)(void *context, double t, const double *q, const double *v, bool first);     /* in steps, and after each; times rise */
    /* Where forces jump or have a kink that is no piece, as where compliant stops begin to push: side (n_switch) > 0 on one side;
     * the last are n_kink of functions with kinks in expressions, and n_jump of sign() and mod().  force (n_v): the forces, where there are any
     * of these. */
    int    n_switch, n_kink, n_jump;
    void   (*switches)(void *context, double t, const double *q, const double *v, double *force, double *side);
    /* Take z (n_z); its rates; its values at the start; the size of state i against which its error counts. */
    void   (*place_states)(void *context, const double *z);
    void   (*state_rates)(void *context, double t, const double *q, const double *v, double *rate);
    void   (*state_start)(void *context, double t, const double *q, const double *v, double *z);
    double (*state_scale)(void *context, int i);
    double (*potential)(void *context, const double *q);                 /* places q where M depends on it */
    double (*kinetic)(void *context, const double *v);                   /* at the q placed last */
    /* A momentum that the scene keeps, and its size for comparison.  NULL: none is known. */
    double (*momentum)(void *context, const double *q, const double *v, double *size);
    /* Momenta of parts that nothing joins to the ground: note them at the start of a run; put v on them at time t, and rigid (n_v)
     * is the part of v by which these move as one body.  Bodies that fly alone are turned in q, too.  NULL: there are none. */
    void   (*note_momenta)(void *context, double t, const double *q, const double *v);
    void   (*keep_momenta)(void *context, double t, double *q, double *v, double *rigid);
    /* Move q by a small displacement (n_v), on the manifold of coordinates; q' = G v. */
    void   (*move)(void *context, double *q, const double *by);
    /* Velocities while q is moved by a displacement `by` that changes with the given rates, which they replace.  NULL: they are
     * the rates. */
    void   (*along)(void *context, const double *by, double *rate);
    void   (*rates)(void *context, const double *q, const double *v, double *dq);
    /* Column i of G at q: velocity i moves coordinates at[k], rising, at the rates by[k], at most 4; returns how many.  Columns of
     * a quaternion p are p times unit vectors over 2, also where its length is not 1.  NULL: G is the unit matrix. */
    int    (*column)(void *context, const double *q, int i, int *at, double *by);
    /* q is a state of the run: put it on its manifold (quaternions of length 1), count turns from it.  NULL: nothing to do. */
    void   (*accept)(void *context, double *q);
} lw_equations;

#endif

/* mbs/space/recursive_stages.h - the equations of a spatial model in the coordinates of its joints (mbs/space/recursive.h) in eight
 * states at once.
 *
 * For integrators whose stages do not depend on each other (mbs/ode/collocation.h).  The loads are gravity and linear springs and
 * dampers between points; joints of any kind close loops, but no screws, couplings or inputs.  Number i of a state in lane k is
 * y[8*i + k]; a state is x, u and, if wanted, the work that dampers have done [J]. */
#ifndef LW_MBS_SPACE_RECURSIVE_STAGES_H
#define LW_MBS_SPACE_RECURSIVE_STAGES_H

#include "mbs/space/recursive.h"
#include "mbs/space/space_forces.h"

typedef struct lw_stage_body {
    int  parent;                             /* place in the order of the tree, -1: ground */
    lw_spatial_kind kind;
    int  body;                               /* of the model */
    bool back;                               /* the body is link 0 of the joint */
    bool carried, leaf, last_child;          /* legs end at it; no child and no leg does; its inertia is the first that its parent's gets */
    bool passes;                             /* its parent comes next inwards, and has no other child */
    int  root, onto, ending;                 /* the first body of its part; of that: the only body of another part where loops of this one end,
                                              * -1: none do, -2: there are more, -3: no loops; how many parts end in this one alone */
    int  x, u, n_x, n_u, angle;              /* its first coordinate, rate, half angle */
    lw_vec3 arm[2], z, along[2];             /* joint's point over unit; axis, and directions of slides in body 0; */
    lw_vec3 second;                          /* universal: the axis of body 1 */
    double  pitch;                           /* slide over unit for each radian */
    lw_quaternion part[2];                   /* body 1 against body 0: cosine and sine of the half angle times these */
    double  mass[4];                         /* of the centre; about the principal axes */
    lw_vec3 weight;                          /* generalised force of gravity */
} lw_stage_body;

typedef struct lw_stage_spring { int body[2]; lw_vec3 arm[2]; double stiffness, damping, free; } lw_stage_spring;  /* over unit */

/* A joint that closes a loop, and its rows (mbs/space/space_rows.c): e . d with e fixed in the ground, a . d, a . b. */
typedef enum lw_stage_row_kind { LW_STAGE_POINT, LW_STAGE_LINE, LW_STAGE_TURN } lw_stage_row_kind;
/* at: place among those kept, -1: none; fixed: a . b of a turn. */
typedef struct lw_stage_row { lw_stage_row_kind kind; lw_vec3 a, b; double fixed; int at; } lw_stage_row;
typedef struct lw_stage_loop {
    int     body[2], n_row, first, n_path[3];            /* first: of the rows of the model */
    lw_vec3 arm[2];                          /* over unit */
    lw_stage_row row[6];
    int    *path;                            /* the ancestors of body 0 and itself, those of body 1, and those of both, outermost first */
    unsigned long long rates, own;           /* bit k: rate k is one of theirs; of its leg's */
    int     leg, side, apart;                /* its leg, -1: none, and the side where this is, -1: both; the same, -1: solved with all loops */
} lw_stage_loop;

/* A leg: a part of the tree that starts at the ground and whose loops all end in itself, at the ground, or at one body of another part, at which two
 * legs or more end.  Rows that are independent in its own rates hold these once the acceleration of that body is known, so the leg acts on the body as an
 * inertia and a load do, and its rows meet those of no other leg.  Rows beyond these, less what they have in common with them, are rows of
 * that body alone. */
typedef struct lw_stage_leg {
    int     root, carries;                   /* its first body, and the body that it carries; -1: the ground */
    int     row, n_row, left, n_left;        /* places of the first row that holds it and of the first one beyond these, and how many */
} lw_stage_leg;

typedef struct lw_stage_kept { int loop; unsigned long long rates, own; } lw_stage_kept;    /* rates of all loops, and of its leg */

enum { LW_STAGE_ROWS = 24, LW_STAGE_RATES = 64 };        /* most rows of loops, and rates where there are any */

typedef struct lw_tree_stages {
    int     n_body, n_x, n_u, n_angle, n_spring, n_loop, n_row, n_leg;
    int     n_kept, n_apart;                 /* rows; the first n_apart hold legs, 0: all loops are solved together */
    bool    has_work;
    double  unit, weak;                      /* weak: least pivot of the loops, or of legs, over the first, of the states factored last; 1: no loops */
    lw_stage_body   *body;                   /* (n_body) */
    lw_stage_spring *spring;
    lw_stage_loop   *loop;                   /* (n_loop) */
    lw_stage_loop   *inner;                  /* (n_body) joints of the tree, without paths; no rows: of a free body, of one on a screw */
    lw_stage_leg    *leg;                    /* (n_leg) */
    lw_stage_kept    kept[LW_STAGE_ROWS];
    int     sorted[LW_STAGE_ROWS];           /* the kept rows, counted through the loops, from the greatest pivot of them all on */
    int    *order, n_hanging;                /* (n_body) the bodies inwards; the first n_hanging are those of legs */
    int    *turn;                            /* (n_angle) coordinates of the angles */
    double *angle, *cosine, *sine;           /* (8 n_angle) halves */
    double *y, *dy, *moment;                 /* of lw_tree_stages_moments: states and rates, (8 n_moment) what it gives */
    int     n_moment, n_model_row;
    double *factored;                        /* (8 n_x) coordinates of the factors */
    void   *state;                           /* scratch of the kernels, */
    const struct lw_tree_kernel *kernel;     /* which are those of the processor */
    const char *isa;
    void  (*turns)(size_t n, const double *angle, double *cosine, double *sine);
    void   *memory;
} lw_tree_stages;

/* f: the loads of r; both must outlive s.  LW_E_KIND: other loads or rows than those above, or too many rows; LW_E_MEMORY.  In both cases
 * s->body is NULL.  Loads that f holds (f->held) are left out, and so is the work of dampers until s->has_work is set. */
lw_status lw_tree_stages_make(const lw_recursive *r, const lw_space_forces *f, lw_tree_stages *s);
void      lw_tree_stages_free(lw_tree_stages *s);

/* Both of a model, with the rows of r beside the joints', the motions wanted of them and the angles near which they count (n_extra). */
typedef struct lw_space_tree {
    lw_recursive    r;
    lw_tree_stages  stages;                  /* no bodies: the model has other loads or rows */
    lw_space_extra *extra;
    double        (*wanted)[3], *near;
} lw_space_tree;

/* NULL: out of memory.  The arrays come with it; r and stages are empty. */
lw_space_tree *lw_space_tree_new(int n_extra);
void     lw_space_tree_free(lw_space_tree *t);           /* t may be NULL */

/* Keep the independent rows that r was factored with last, in that order, for the states to come. */
void      lw_tree_stages_keep_rows(lw_tree_stages *s, const lw_recursive *r);

/* dy of eight states y, but x'.  again: dy holds the rates of the last call.  Where the states are near those factored last, these factors
 * improve dy: repeated calls tend to the rates, and each costs three quarters or, with loops, half.  Not where rows are left out: near
 * singular postures of such loops steps would fail more often.  LW_E_ARG: a motion without mass, or loops in a singular posture. */
lw_status lw_tree_stages_rates(lw_tree_stages *s, bool again, const double *y, double *dy);

/* Close the loops of the eight states s->y, if they are open, and work out what the first n of them are in the coordinates of the model: (n_moment)
 * for each in s->moment are q, v and a of its bodies (mbs/space/space.h), the multipliers of its rows (n_model_row), and the greatest misfit of a row and of
 * its rate.  s->dy is the rates.  LW_OPEN: loops that do not close, or what lw_tree_stages_rates refuses; LW_E_KIND: rows were left out,
 * or a joint of the tree is a screw. */
lw_status lw_tree_stages_moments(lw_tree_stages *s, bool open, int n);

/* x' of eight states y. */
void      lw_tree_stages_motion(const lw_tree_stages *s, const double *y, double *dx);

#endif

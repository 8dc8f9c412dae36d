/* mbs/plan/plan.h - how the posture of a linkage is worked out: a plan is made once from the topology, then evaluated
 * many times in the caller's memory.
 *
 * A plan is a list of steps: the input link, then one Assur group after the other, then the tracer points.  It holds
 * only the steps that the outputs depend on.  Dyads (RRR, RRP, RPR, PRP, PPR) are steps in closed form.  Higher groups
 * (triads, tetrads, ..., and groups that contain the input joint) are solved by Newton's method on the loops of the
 * group alone, followed from a seed posture.  A pin in a slot counts as a pin and a slider with a die between them.  A
 * gear pair turns a wheel when carrier and partner are known, and a rack turns its pinion or a pinion moves its rack
 * (mbs/plan/plan_gear.c); any other gear is an equation of a group.
 *
 * The plan holds no numbers but the ratios of wheels.  The numbers are
 *     dim[n_dim]    dimensions, read off a posture by lw_plan_read or chosen by an optimiser;
 *     mode[n_mode]  first the assembly mode of each of the n_dyad dyads, +1 or -1 (ignored for PRP and PPR).  With
 *                   higher groups a seed for each follows, a posture near the solution: the turns of its links
 *                   against the ground frame [rad], then its displacements over lw_plan_size.  The last number is
 *                   the input of that posture.  n_mode is n_dyad for linkages made of dyads;
 *     the input     as a unit vector (cos, sin) for a pin, as (displacement, 0) for a slider.
 * A linkage of several freedoms has a plan when all inputs but the first are tied to it (grammar/linkage/linkage.h) and all
 * turn on the ground: a tied link is a wheel of constant rate, and its phase is a dimension.
 *
 * Higher groups.  The unknowns are one turn a link (links that slide on each other share one) and one displacement a
 * slider.  The equations are the group's independent loops, two rows each, and its gears, one each.  The posture is
 * followed from the seed to the requested input; mbs/batch/batch.h says how a jump to another posture is avoided.
 *
 * Frames.  All steps work in the ground frame of the linkage (origin: first ground pin; x axis: towards the second
 * ground pin, else along the first ground slide; see lw_plan_make).  There coordinates are of the size of the links.
 * The result is moved into the plane at the end by x0, y0, theta0:
 *     P = (x0, y0) + e^{i theta0} p.
 * The input angle is counted from the x axis of the GROUND FRAME, counter-clockwise.  With gears of fractional ratio
 * the plan's input is the linkage's input divided by plan->input_turns_per_period, and so are derivatives by it; all
 * links are back after one turn of the plan's input.
 * Each moving link has a frame too: its origin is the joint by which its dyad found it, its x axis points towards its
 * next joint (pin) or along its slide.
 *
 * Without a ground pin the origin is the meeting point of the first two ground lines.  When these are parallel in the
 * posture the plan was made from, it is a point of the first line.  A link without a pin has its origin where its
 * first two lines meet, so that neither needs an offset.
 * The driven link's x axis runs from the input pin to its next joint in the order of the linkage
 * (lw_linkage_posture_input).  Only the sum of the offsets of two links that slide on each other matters: it is one
 * dimension, of the link that was known first (of the first link, for the inner slider of RPR).
 * A link of a higher group that is reached by a pin has its origin there, and its x axis points towards its next pin,
 * else along its slide.  A link that is reached by a slide has its origin at its first pin and its x axis along the
 * slide.  An input between two moving links counts, for a pin, the direction of the x axis of link[1] minus that of
 * link[0]; for a slider, the place of the later link's origin along the line from the foot of the other's.  This is
 * the linkage's value plus a constant.
 *
 * Names of dimensions use the numbers of the links in the order in which the plan meets them: ground 1, input link 2
 * ("r1 r2 r3 r4 cx cy x0 y0 theta0" for a four-bar with its tracer on the coupler).  Dimensions stand in this order:
 * link by link, of the ground its pins only; then the slide lines of the ground; then the tracers; then x0 y0 theta0.
 *     r<k>     distance of the first two pins of link k                      length, > 0
 *     e<k>     signed distance of a slide line (the path of the pin that slides) from the origin of
 *              link k, positive to the left of the line's direction         coordinate
 *     beta<k>  direction of a slide line in the frame of link k, when that frame is not laid along it
 *                                                                            angle
 *     e<k>_<j> beta<k>_<j>  the same for a further line (joint number j, from 1) on link k
 *     x<k>_<j> y<k>_<j>     a further pin (joint number j, from 1) on link k  coordinate
 *     phi<k>   phase of wheel k in its gear pair                               angle
 *     rho<k> s<k>  a rack on link k moves by rho as its pinion turns by 1 rad: d = s + rho angle     coordinates
 *     mu<k>    angle of the pinion at the middle of the rack.  It selects one of the angles that differ by whole
 *              turns and moves nothing                                         angle
 *     cx cy    the first tracer in the frame of its link (cx2 cy2 the next)  coordinate
 *     x0 y0    place of the ground frame                                     coordinate
 *     theta0   its angle                                                     angle
 * No dimension is redundant, with two exceptions.  On a link that never turns (coupler of RRPP, PPRR) cx, cy only add
 * to x0, y0, but a linkage cannot be drawn without them.  The phase of a wheel that carries only its own pin and the
 * tracer turns cx, cy.
 */
#ifndef LW_MBS_PLAN_PLAN_H
#define LW_MBS_PLAN_PLAN_H

#include <stddef.h>
#include "grammar/linkage/linkage.h"

#define LW_DIM_MAX   64
#define LW_DYAD_MAX  16
#define LW_MODE_MAX  64
#define LW_HIGHER_MAX  4       /* higher groups of a plan                                         */
#define LW_PLAN_LOOP_MAX 10    /* loops of a higher group                                         */
#define LW_UNKNOWN_MAX (2*LW_PLAN_LOOP_MAX)
#define LW_STEP_MAX  96
#define LW_REG_MAX  128
#define LW_ORDER_MAX 3         /* of derivatives by the input: position, velocity, acceleration, jerk */
#define LW_INPUT_TURNS_PER_PERIOD_MAX 24    /* turns of the input until all gears are back         */
#define LW_POWER_MAX 99        /* turns of a wheel in that time                                   */

typedef enum lw_dim_kind { LW_DIM_LENGTH, LW_DIM_COORDINATE, LW_DIM_ANGLE } lw_dim_kind;

typedef enum lw_dim_role {
    LW_ROLE_R, LW_ROLE_X, LW_ROLE_Y,                  /* of pin `joint`, in the frame of `link`  */
    LW_ROLE_E, LW_ROLE_BETA,                          /* of the line of slider `joint`           */
    LW_ROLE_PHASE,                                    /* of wheel `link` in gear `joint`          */
    LW_ROLE_PITCH, LW_ROLE_SHIFT, LW_ROLE_MIDDLE,     /* of rack `link` in gear `joint`           */
    LW_ROLE_CX, LW_ROLE_CY,                           /* of tracer `joint`                       */
    LW_ROLE_X0, LW_ROLE_Y0, LW_ROLE_THETA0            /* of the whole                            */
} lw_dim_role;

typedef struct lw_dim_info {
    char        name[16];
    lw_dim_kind kind;         /* length and coordinate scale with the linkage, angle does not    */
    int         link;         /* the link it belongs to (index in the linkage)                   */
    lw_dim_role role;
    int         joint;        /* joint or tracer it is read from (index in the linkage), or -1   */
} lw_dim_info;

/* Where the frame of a link lies in a posture.  With origin -1 the origin is where the lines of the two sliders in
 * meet[] cross; with meet[1] -1 too, it is a point of the line of meet[0].  For the ground that point is the place of
 * the joint minus the input's value, so that displacement and input value are the same. */
typedef struct lw_frame {
    int origin;               /* pin (joint index) or -1                                         */
    int meet[2];              /* sliders                                                         */
    int axis;                 /* joint: x axis towards this pin or along this slider; -1: tracer */
    int axis_tracer;          /* when axis is -1: tracer, or -1: the x axis of the plane         */
} lw_frame;

/* A dyad: two links and the joints outer, inner, outer.  The first link is joined to the known link of the higher
 * number (both to the same link: the one of lower index in the linkage).  Assembly modes, +1 or -1:
 *     RRR   inner pin left (+1) or right of the line from the first outer pin to the second;
 *     RRP   inner pin ahead of (+1) or behind the foot of the outer pin, along the slide's direction;
 *     RPR   second outer pin ahead of (+1) or behind the first, along the slide's direction. */
typedef struct lw_dyad {
    int link[2];
    int joint[3];
} lw_dyad;

/* Kinds of steps: name, number of inputs, which inputs are points (bit h: in[h]; the others are directions and
 * displacements), number of outputs, number of dimensions that it has derivatives by.  The formulas stand in
 * mbs/plan/steps_internal.h.  Its switches have no default, so that a missing case does not compile (-Werror=switch);
 * docs/contributing.md lists the other files. */
#define LW_STEP_LIST(X)                                                                                        \
    X(INPUT_PIN,   0, 0, 1, 0)          /* direction of the input link from the input                      */  \
    X(INPUT_SLIDE, 2, 1, 1, 0)          /* origin of the input link from the input                         */  \
    X(POINT,       2, 1, 1, 2)          /* point on a link                                                 */  \
    X(LINE,        2, 1, 2, 2)          /* slide line on a link: a point of it and its direction           */  \
    X(RRR,         2, 3, 3, 2)          /* dyads                                                           */  \
    X(RRP,         3, 3, 2, 1)                                                                                 \
    X(RPR,         2, 3, 1, 1)                                                                                 \
    X(PRP,         4, 5, 1, 0)                                                                                 \
    X(PPR,         4, 5, 1, 0)                                                                                 \
    X(TURN,        2, 0, 1, 0)          /* direction turned by another                                     */  \
    X(SLIDE,       3, 1, 1, 0)          /* point along a line, by a displacement                           */  \
    X(GEAR,        2, 0, 1, 1)          /* direction of a wheel                                            */  \
    X(ALONG,       3, 5, 1, 0)          /* displacement of a slider between known links                    */  \
    X(ROLL,        2, 0, 1, 2)          /* direction of a pinion from its rack                             */  \
    X(RACK,        2, 0, 1, 3)          /* displacement of a rack from its pinion                          */

typedef enum lw_step_kind {
#define X(name, inputs, points, outputs, dims) LW_STEP_##name,
    LW_STEP_LIST(X)
#undef X
    LW_STEP_HIGHER            /* a higher group: its directions and displacements, found together            */
} lw_step_kind;

/* in[], out[] are register numbers, dim[] dimension numbers, -1 where unused.  A register is a point
 * or a direction (unit vector); 0 is the origin and 1 the x axis of the ground frame.
 *     kind          in                      out             dim
 *     INPUT_PIN                             u
 *     INPUT_SLIDE   q, w  (line)            q + s w
 *     POINT         o, d  (frame)           o + (x + iy) d  x, y
 *     LINE          o, d                    q, w            e, beta   w = d e^{i beta}, q = o + e i w;
 *                                                                     dim[2]: number in plan.angle
 *     RRR           a, b  (pins)            u1, u2, c       r1, r2    c = a + r1 u1 = b + r2 u2
 *     RRP           a, q, w                 u, c            r         c = a + r u = q + t w
 *     RPR           a, b                    u               e         b = a + (t + ie) u
 *     PRP, PPR      q1, w1, q2, w2          c                         c = q1 + t1 w1 = q2 + t2 w2
 *     TURN          u, v                    u v                       power[0]: +1, or -1 for u conj(v)
 *     SLIDE         q, w, (d, 0)            q + d w
 *     GEAR          u, v                    u^m v^n e^{i phi}  phi    m, n in power[]; v is 1 if in[1] is -1;
 *                                                                     dim[2] as for LINE
 *     ALONG         q, w, p                 (d, 0)                    d = (p - q) . w
 *     ROLL          u, (d, 0)               u e^{i (d - s)/rho}  rho, s        u of the carrier
 *     RACK          v, u                    (s + rho (mu + a), 0)  rho, s, mu
 *                                                                     mu + a the angle from u (carrier) to v (pinion),
 *                                                                     |a| <= pi
 *     HIGHER        see lw_higher                                     dim[0]: number in plan.higher
 * u2 of RRR is -1 when no step needs it.  q2, w2 of PPR is the line of its inner slider. */
typedef struct lw_step {
    lw_step_kind kind;
    int in[4], out[4], dim[3], dyad, power[2];
} lw_step;

/* A higher group is a set of closed loops of vectors,
 *     sum of  sign (x + iy) u  +  sign d u  +  sign P  = 0,
 * with u a direction of the list `dir`, x, y dimensions, d a displacement and P a known point.  A direction is one of
 *     unknown   root is its number among the turns, base is -1;
 *     known     root is -1;
 *     turned    from the earlier direction `base`, by a dimension (an angle) or by the input. */
typedef struct lw_higher_dir {
    short root, base;         /* unknown turn that moves it, or -1; direction it is turned from, or -1 */
    short reg;                /* its own register, or that of the input that turns it             */
    short dim, angle;         /* angle that turns it: dimension, number in plan.angle; or -1      */
    short input;              /* +1, -1: the input turns it; else 0                               */
} lw_higher_dir;
typedef struct lw_higher_vector { short loop, sign, dir, x, y, entry; } lw_higher_vector;
typedef struct lw_higher_slide { short loop, sign, dir, disp; } lw_higher_slide;
typedef struct lw_higher_point { short loop, sign, reg; } lw_higher_point;
typedef struct lw_higher_entry { short loop, dir; } lw_higher_entry;    /* vectors of one direction in a loop */

/* A gear in a higher group is the equation
 *     (sum of power angle(dir) - count phi)/count = 0         for wheels, with whole powers;
 *     angle(pinion) - angle(carrier) - (d - s)/rho = 0        for a rack.
 * The sum is the angle of the product of the directions to their powers, without whole turns.  Postures that differ by
 * whole turns are told apart by following the motion from the seed. */
typedef struct lw_higher_gear {
    short n_term, dir[3], link[3], power[3], count;
    short phase, angle;       /* wheels: dimension, number in plan.angle; else -1                 */
    short disp;               /* racks: displacement; else -1                                     */
    short rho, shift, middle; /* racks: dimensions; else -1                                       */
} lw_higher_gear;

#define LW_HIGHER_DIR_MAX  48
#define LW_HIGHER_TERM_MAX 160
#define LW_HIGHER_GEAR_MAX 8

typedef struct lw_higher {
    int              n_link, link[LW_LINK_MAX];       /* in the order in which they are reached   */
    int              n_loop, n_turn, n_disp;
    int              n_unknown;                       /* n_turn + n_disp = 2 n_loop + n_gear      */
    int              turn_reg[LW_UNKNOWN_MAX];        /* register each unknown turn's direction goes to */
    int              turn_link[LW_UNKNOWN_MAX];       /* the link whose direction it is           */
    int              disp_reg[LW_UNKNOWN_MAX + 1];    /* (d, 0); after the unknown ones that of the input */
    int              disp_joint[LW_UNKNOWN_MAX];      /* the slider                               */
    bool             disp_input;                      /* is the input a displacement of this group? */
    int              n_dir, n_vector, n_slide, n_point, n_entry, n_gear;
    lw_higher_dir    dir[LW_HIGHER_DIR_MAX];
    lw_higher_vector vector[LW_HIGHER_TERM_MAX];
    lw_higher_slide  slide[LW_HIGHER_TERM_MAX];
    lw_higher_point  point[LW_HIGHER_TERM_MAX];
    lw_higher_entry  entry[LW_HIGHER_TERM_MAX];
    lw_higher_gear   gear[LW_HIGHER_GEAR_MAX];
    int              first_mode;                      /* where its seed starts in mode[]          */
    int              first_row;                       /* where its rows start: x, y a turn, d a displacement */
} lw_higher;

/* A gear between a pinion and a rack. */
#define LW_RACK_MAX 8
#define LW_RACK_REACH (0.9*LW_PI)  /* largest turn of the pinion from the middle of the rack [rad]  */
typedef struct lw_rack {
    int joint, slider;        /* the gear; the slide of the rack on the carrier                   */
    int link, pinion, carrier;
    int side;                 /* link[side] of the gear is the rack                               */
    double sign;              /* +1, -1: does rho count along the slide's direction or against it */
} lw_rack;

/* The most frequent plans, which a loop of their own evaluates faster: a point A driven by the input (a pin of the
 * crank or of a slider) and one dyad from A to the ground, with the tracer on the link at A.
 *     A = r2 (cos, sin)  or  (displacement, e_in);   ground pin (b, 0), or line through (0, e) at angle beta;
 *     RRR lengths d1, d2;   RRP length d1;   RPR offset d1. */
typedef struct lw_fast_dyad {
    bool         applies;
    lw_step_kind dyad;
    int          r2, e_in, b, e, beta, d1, d2;    /* numbers of dimensions; -1: the value is 0     */
} lw_fast_dyad;

typedef struct lw_plan {
    int         n_dim, n_dyad, n_step, n_reg, n_output;
    int         n_mode, n_higher, n_row;          /* rows: numbers that give the posture of the higher groups */
    bool        input_is_slider;
    int         input_turns_per_period;           /* turns of the linkage's input in one turn of the plan's input */
    lw_dim_info dim[LW_DIM_MAX];
    lw_step     step[LW_STEP_MAX];
    lw_dyad     dyad[LW_DYAD_MAX];
    int         n_link;                           /* links that the plan works out                */
    int         link[LW_LINK_MAX];                /* their indices; link[0] ground, link[1] the   */
                                                  /* driven link, when it is joined to the ground */
    lw_frame    frame[LW_LINK_MAX];               /* by index in the linkage                      */
    int         input_joint;
    int         input_link[2];                    /* the input counts the second against the first */
    lw_higher   higher[LW_HIGHER_MAX];
    int         n_rack;
    lw_rack     rack[LW_RACK_MAX];
    int         joint_pin[LW_JOINT_MAX];          /* the first joint of the same pin, for pins    */
    int         slider_base[LW_JOINT_MAX];        /* the link that carries the slide line         */
    int         slider_ref[LW_JOINT_MAX];         /* the pin whose path a slide line is, or -1    */
    int         slider_dir[LW_JOINT_MAX];         /* register of its direction, or -1: left out   */
    double      slider_sign[LW_JOINT_MAX];        /* direction of the line over `along`           */
    int         i_x0, i_y0, i_theta0;             /* their numbers in dim[]                       */
    int         n_angle, angle[LW_DIM_MAX];       /* the dimensions that are angles, theta0 last  */
    int         output_point[LW_TRACER_MAX];      /* register of each output's point ...          */
    int         output_dir[LW_TRACER_MAX];        /* ... and of the direction of its link         */
    int         output_link[LW_TRACER_MAX];
    int         output_tracer[LW_TRACER_MAX];     /* index in the linkage                         */
    int         n_output_step[LW_TRACER_MAX];     /* the steps an output depends on, in order     */
    unsigned char output_step[LW_TRACER_MAX][LW_STEP_MAX];
    unsigned char output_keep[LW_TRACER_MAX][LW_STEP_MAX];  /* bit h: out[h] of that step is needed */
    lw_fast_dyad output_fast_dyad[LW_TRACER_MAX];
    int         i_cx[LW_TRACER_MAX], i_cy[LW_TRACER_MAX];   /* numbers of its coordinates in dim[], or -1 */
    int         link_origin[LW_LINK_MAX];         /* registers of each link's frame; -1: left out */
    int         link_dir[LW_LINK_MAX];
    int         joint_point[LW_JOINT_MAX];        /* register of each joint's pin; -1: left out   */
    const struct lw_kernels *kernels;             /* of mbs/batch; NULL: the best for this processor */
} lw_plan;

/* Which linkages a plan is made for; each kind includes those before it. */
typedef enum lw_plan_kind {
    LW_PLAN_DYADS,            /* pins and sliders, the input at the ground, dyads only: closed forms throughout */
    LW_PLAN_HIGHER,           /* pins in slots, inputs between moving links and higher groups too */
    LW_PLAN_GEARED            /* gear pairs, racks, and several inputs that are tied and turn on the ground */
} lw_plan_kind;

/* The outputs that a plan computes.  Outputs are numbered 0, 1, ... in the order of the tracers. */
typedef struct lw_plan_options {
    unsigned     tracers;     /* bit i: tracer i                                                  */
    bool         all_joints;  /* every joint and link too (for drawings and traces)               */
    lw_plan_kind kind;
} lw_plan_options;

/* Make the plan.  Pins of a link whose coordinates are equal bit by bit are one pin.  With gears one turn of the plan's
 * input is plan->input_turns_per_period turns of the linkage's.  Errors:
 *     LW_E_ARG   the options name no tracer and no joint, or a tracer that the linkage does not have
 *     LW_E_KIND  with a text: not one input that drives one freedom; joints or groups beyond options.kind (the
 *                text names the links that are left over); sliders that form a closed chain; some links held twice
 *                and others not at all; groups beyond the limits above; ratios of wheels that are not of small whole
 *                numbers or need more than LW_INPUT_TURNS_PER_PERIOD_MAX turns; racks on racks; gears without a carrier
 *     others     as lw_linkage_check */
lw_status lw_plan_make(const lw_linkage *linkage, lw_plan_options options, lw_plan *plan, lw_error *e);

/* Read dimensions, modes and input value [rad] or [m] off the posture of `linkage` (the linkage the plan was made
 * from, or another of the same topology).  LW_E_ARG when the posture contradicts itself. */
lw_status lw_plan_read(const lw_plan *plan, const lw_linkage *linkage, double *dim, double *mode, double *input, lw_error *e);

/* How dimensions and input change when the place of pin `joint` on one of its two links moves and all links keep their
 * posture: by[0] per metre along x of the plane, by[1] along y (n_dim); input[2] as the plan counts it.  This is what play
 * between the two does.  All 0 when the output does not depend on the pin.  LW_E_ARG as lw_plan_read. */
lw_status lw_plan_read_play(const lw_plan *plan, const lw_linkage *linkage, int joint, double *const by[2], double input[2], lw_error *e);

/* The unit of length for displacements in a seed: the mean absolute value of the lengths and coordinates [m]. */
double lw_plan_size(const lw_plan *plan, const double *dim);

/* Describe the plan as text, one line a group in the order of solution: class and order after Artobolevsky, links,
 * joints, closed form or Newton's method with the number of unknowns; then the links and joints that are left out
 * because no output needs them.  linkage: the one the plan was made from.  Returns the length, as snprintf does. */
size_t lw_plan_explain(const lw_plan *plan, const lw_linkage *linkage, char *buf, size_t size);

/* Index of a dimension by name, -1 if there is none. */
int lw_plan_dim(const lw_plan *plan, const char *name);

#endif

/* mbs/equations/touch.h - places where the parts of a model may touch, and their geometry at one moment.
 *
 * Shapes touch where a disc of one (a circle, the round end of a bar, a corner: a disc of radius 0) meets a face or a
 * disc of the other.  A rope that is taut and a rigid stop of a joint are the same kind of condition:
 *
 *     gap >= 0, force >= 0, one of them 0
 *
 * Lengths and coordinates are scaled as in mbs/constraints/system.h; so gaps of stops of pins are in rad. */
#ifndef LW_MBS_EQUATIONS_TOUCH_H
#define LW_MBS_EQUATIONS_TOUCH_H

#include "grammar/model/model.h"
#include "mbs/equations/equations_planar.h"

typedef enum lw_touch_kind { LW_TOUCH_FACE, LW_TOUCH_DISCS, LW_TOUCH_ROPE, LW_TOUCH_STOP } lw_touch_kind;

/* APART: no force.  PASSIVE: rigid, touches without force.  HELD: rigid, its gap is a row of the constraints.  PRESSED:
 * compliant, with a depth. */
typedef enum lw_touch_state { LW_TOUCH_APART, LW_TOUCH_PASSIVE, LW_TOUCH_HELD, LW_TOUCH_PRESSED } lw_touch_state;

typedef struct lw_touch {
    lw_touch_kind kind;
    lw_touch_state state;
    bool    held, stuck;                 /* state and `sticks` before the current event                 */
    bool    sticks;                      /* its slip is a row of the constraints, or depends on such rows */
    bool    redundant;                   /* PASSIVE: it presses, but its gap depends on the rows that are held */
    bool    yields;                      /* its friction reached its limit when the events were last evaluated */
    double  anchor, anchor_angle;        /* `path` and, of discs, direction of the normal where it began to stick */
    double  passed;                      /* APART: how far the gap was below 0 at the last event because of rounding */
    double  force;                       /* HELD: along the normal when the events were last evaluated, scaled */
    int     slips;                       /* sense of the slip, -1 or 1; 0: it sticks or has no friction */
    int     owner;                       /* index of the contact or rope of the model; of a stop its joint */
    const lw_surface *surface;
    int     link;                        /* that of body 0                                             */
    int     body[2];                     /* -1: ground                                                 */
    lw_vec2 drawn;                       /* centre of the disc in the posture [m]                      */
    lw_vec2 arm[2];                      /* centre of the disc, on body 0; begin of the face or centre, on body 1 */
    lw_vec2 edge[2];                     /* sides of a body from its corner or sharp end, in the frame of body 0; 0: none */
    lw_vec2 onward[2];                   /* of a sharp corner: where the outlines of other shapes of its link go on from it, as in a rail of pieces; 0: none */
    bool    covered[2];                  /* face: another solid of its link lies on it at this end      */
    bool    joined[2];                   /* face of a bar: another shape of its link goes on at this end */
    lw_vec2 into;                        /* direction from the disc into its shape, in the frame of body 0; 0: a circle */
    double  radius[2];                   /* of a face: half the thickness of a bar                       */
    lw_vec2 along;                       /* face: its direction in the frame of body 1; outside is on its left */
    double  length;                      /* of the face; infinite for a line                            */
    lw_vec2 beyond[2];                   /* of a polygon: its other sides at the ends of the face, from there, in the frame of body 1 */
    double  deepest, slope[2];           /* where behind a face a disc counts as inside, see touch.c     */
    double  notch[2];                    /* how far the face goes on, and the body behind it, beyond a notch at its ends; 0: no notch */
    int     side;                        /* face of a bar: the side of the disc, -1, 1 or LW_TOUCH_NO_SIDE; 0: one side only */
    double  size, least_size;            /* way of a disc through the body, away from its corners; a shorter one is not looked for */
    double  loose;                       /* way of bodies in a step that does not end where they touch, scaled; 0: it does */
    double  sign, limit;                 /* stop: gap = sign (measure - limit); rope: limit is its length */
} lw_touch;

typedef struct lw_touch_list {
    int        n;
    lw_touch  *touch;
    lw_surface *stop_surface;            /* of the stops                                               */
} lw_touch_list;

/* One place at one moment: gap, its rate, and the part of its second rate that velocities cause; the same of the slip
 * of link 0 along the tangent, the normal turned clockwise.  n, t: derivatives by the coordinates of both bodies. */
typedef struct lw_touch_motion {
    double  gap, rate, bias, n[6];
    double  slip, slip_bias, t[6];
    double  straight;                    /* gap as if a face had no ends and the solid behind it none; `rate` is its rate */
    double  place, place_rate;           /* distance along the face                                    */
    double  path;                        /* the slip is its rate: what has been slipped since the anchor, and more */
    lw_vec2 at, normal;                  /* point of contact, direction of the force on body 0         */
} lw_touch_motion;

/* All places of a model.  Needs lw_touch_free, after a failure too. */
lw_status lw_touch_make(const lw_model *m, const lw_system *s, lw_touch_list *list, lw_error *e);
void      lw_touch_free(lw_touch_list *list);

/* eq is placed at the coordinates, frames are those of its bodies; v NULL: at rest. */
void lw_touch_at(const lw_touch *p, const lw_equations *eq, const lw_body_frame *frames, const double *v, lw_touch_motion *out);

/* The gap of lw_touch_at alone. */
double lw_touch_gap(const lw_touch *p, const lw_equations *eq, const lw_body_frame *frames);

/* A bar is touched on the side where the disc was before it came beside the bar; anew: at the start.  A disc within `near` of the line of the
 * bar counts as on it.  False: it lies on a bar without thickness, and nothing tells its side. */
bool lw_touch_choose_side(lw_touch *p, const lw_body_frame *frames, bool anew, double near);

/* A disc that came beside a bar within the time `since`, at the rates in m, may have passed over its end to the other side, unless another shape goes on
 * there: that side is taken then. */
void lw_touch_round_end(lw_touch *p, const lw_touch_motion *m, double since);

#define LW_TOUCH_NO_SIDE 2               /* not known yet, taken as 1 */
#define LW_TOUCH_CLOSED 1e-12            /* a gap below this is closed, scaled */

/* Length of the way through the body for the disc where it is heading: it must not jump over that within a step, scaled. */
double lw_touch_size(const lw_touch *p, const lw_touch_motion *m);

/* A disc within this of the end of a face is still on it, scaled. */
#define LW_TOUCH_END 1e-9

/* Has the disc left the face over one of its ends? */
bool lw_touch_past_end(const lw_touch *p, const lw_touch_motion *m);

/* Is the disc within `near` of the end of a face, or beyond it, where the shapes of one link go on?  An outline goes on from the corner behind the face, as
 * at the joints of a rail, or another solid covers that end: then the face does not hold it. */
bool lw_touch_goes_on(const lw_touch *p, const lw_body_frame *frames, const lw_touch_motion *m, double near);

/* Is the disc a corner at the end of a face, and does one of its sides run behind the face, or do shapes go on there?  Then the face does not hold it: another
 * face that ends there, or one of the corner's own sides does. */
bool lw_touch_beside_end(const lw_touch *p, const lw_body_frame *frames, const lw_touch_motion *m);

/* Does a side of a corner that is outside cross the face, by more than this at both of their ends?  Then tips have passed each other, and bodies overlap
 * though no corner is inside. */
bool lw_touch_crosses(const lw_touch *p, const lw_body_frame *frames, double by);

/* Force of a compliant contact [N] at a scaled depth and its rate; unit of lengths [m].  Not less than 0. */
double lw_touch_force(const lw_surface *s, double unit, double depth, double rate);

/* Name of its owner in the model: a contact, a rope or a joint. */
const char *lw_touch_name(const lw_model *m, const lw_touch *p);

#endif

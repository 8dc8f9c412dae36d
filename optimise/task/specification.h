/* optimise/task/specification.h - what a person asks of a linkage: the task, its timing, and conditions. */
#ifndef LW_OPTIMISE_TASK_SPECIFICATION_H
#define LW_OPTIMISE_TASK_SPECIFICATION_H

#include "base/real.h"
#include "base/vec2.h"
#include "optimise/task/target.h"

#define LW_ZONE_MAX 8

/* The objectives: path, function and motion generation.  The columns are the name in task files and options, and:
 *   place       it compares places of the first point; without places, the output is the last link at the ground
 *   angle       it compares angles of the link that carries the first point
 *   prescribed  its timing is always prescribed */
#define LW_TASK_LIST(X)                          \
    X(PATH,     "path",     true,  false, false) \
    X(FUNCTION, "function", false, true,  true)  \
    X(MOTION,   "motion",   true,  true,  false)

/* How inputs belong to stations: as the target says; in the order of the stations; nearest points both ways. */
#define LW_TIMING_LIST(X) X(PRESCRIBED, "prescribed") X(FREE, "free") X(NONE, "none")

#define X(id, name, place, angle, prescribed) LW_TASK_##id,
typedef enum lw_task { LW_TASK_LIST(X) LW_TASKS } lw_task;
#undef X
#define X(id, name) LW_TIMING_##id,
typedef enum lw_timing { LW_TIMING_LIST(X) LW_TIMINGS } lw_timing;
#undef X

/* "|path|function|motion" and "|prescribed|free|none", the choices of an option. */
#define LW_TASK_WORD(id, name, place, angle, prescribed) "|" name
#define LW_TASK_WORDS LW_TASK_LIST(LW_TASK_WORD)
#define LW_TIMING_WORD(id, name) "|" name
#define LW_TIMING_WORDS LW_TIMING_LIST(LW_TIMING_WORD)

typedef struct lw_task_row { const char *name; bool place, angle, prescribed; } lw_task_row;

extern const lw_task_row lw_task_table[LW_TASKS];
extern const char *const lw_timing_names[LW_TIMINGS];

static inline bool lw_task_has_place(lw_task task) { return lw_task_table[task].place; }
static inline bool lw_task_has_angle(lw_task task) { return lw_task_table[task].angle; }

/* From where the angles of a prescribed timing count. */
typedef enum lw_datum {
    LW_DATUM_FREE,        /* only differences matter: the first angle is found                    */
    LW_DATUM_FRAME,       /* from the x axis of the ground frame (the line of the fixed pivots)   */
    LW_DATUM_PLANE        /* from the x axis of the plane                                         */
} lw_datum;

/* Where a further point lies: of four links on the coupler, or an angle alone on the output; of other linkages a
 * family says it. */
typedef enum lw_carrier {
    LW_CARRIER_ANY,
    LW_CARRIER_INPUT,     /* on the driven link                                                    */
    LW_CARRIER_COUPLER,   /* on a link that is not joined to the ground                            */
    LW_CARRIER_OUTPUT     /* on a link that is, and is not driven                                  */
} lw_carrier;

/* How exactly a linkage is made. */
typedef struct lw_tolerances {
    double   length, clearance;     /* [m]; the tolerance is three standard deviations; radius of the clearance */
    int      trials;                /* random linkages; 0: 1000                                        */
    uint64_t seed;
} lw_tolerances;

/* A task as a person states it, in SI units. */
typedef struct lw_fit_spec {
    lw_task   task;
    lw_timing timing;
    lw_datum  datum;
    double    a, b;                    /* eq. 17; [1/m^2], [1/rad^2]                              */
    double    angle_length;            /* the distance [m] that an angle error of 1 rad counts as; 0: not known */
    bool      crank_only;              /* the input must turn fully                               */
    bool      exclude_drag_link;       /* and be the shortest link (four-bars)                    */
    double    min_transmission;        /* [rad], 0: not asked                                     */
    double    max_acceleration;        /* of the tracer by the input angle [m/rad^2], of a function of the output
                                        * angle [rad/rad^2]; 0: not asked                         */
    double    max_slide_acceleration;  /* the same where the input is a slide [1/m]; 0: not asked  */
    double    length_lo, length_hi;    /* lengths [m]; hi 0: limited relative to the path.  Sides of links with
                                        * several pins are lengths too; tracers are at most hi from the pins */
    bool      dimensions_only;         /* the range bounds the variables that are lengths, and nothing else */
    double    position_lo, position_hi;/* coordinates [m]; lo == hi: the same                     */
    double    length_ratio;            /* of the longest length, or arm of a point, to the shortest length, 0: not asked */
    lw_carrier carrier[LW_ALSO_MAX];   /* of the target's further points                          */
    int       n_zone;
    lw_zone   zone[LW_ZONE_MAX];
    int       n_bound;
    lw_bound  bound[24];               /* by name, override the ranges [m], [rad]                 */
    double    max_size;                /* most length and coordinate, in diagonals of the target, where no range is
                                        * given; 0: 10                                            */
    double    class_margin;            /* least distance of a four-bar from a change point, in perimeters, or 0 */
    bool      within_limits;           /* the input passes no limit, dead point or change point   */
    double    tolerance;               /* the results are the simplest and smallest linkages that stray from the target by
                                        * no more [m]; 0: those with the least error               */
    lw_tolerances tolerances;          /* results count as far from the target as 95 of 100 linkages with these errors stay;
                                        * 0: exact ones                                            */
    unsigned  by_default;              /* LW_LIMIT_ bits: limits that nobody asked for: results that break them are
                                        * better than none                                        */
} lw_fit_spec;

/* Without limits but those of the range of the search. */
lw_fit_spec lw_fit_spec_default(void);

/* Set b and angle_length so that 1 rad counts as `length`; 0: as half the diagonal of the target, so that the unit of
 * its lengths does not matter.  Without places b becomes 1. */
void lw_fit_spec_weigh_angles(lw_fit_spec *s, const lw_target *t, double length);

/* The limits that a linkage keeps if it is to be built.  Each holds by default and can be given instead. */
enum {
    LW_LIMIT_TRANSMISSION = 1,         /* min_transmission                                        */
    LW_LIMIT_RATIO = 2,                /* length_ratio                                            */
    LW_LIMIT_SIZE = 4,                 /* max_size                                                */
    LW_LIMIT_MARGIN = 8,               /* class_margin                                            */
    LW_LIMIT_MOTION = 16,              /* within_limits                                                */
    LW_LIMITS = 5, LW_LIMIT_ALL = 31,
    LW_LIMIT_TURN = 32                 /* crank_only, for closed targets: gives way if no type can turn   */
};
#define LW_DEFAULT_TRANSMISSION_DEG 20
#define LW_DEFAULT_LENGTH_RATIO     20
#define LW_DEFAULT_MAX_SIZE         6
#define LW_DEFAULT_CLASS_MARGIN     1e-3

/* Set those of the limits that are not among `given` to their defaults for this target. */
void lw_fit_spec_set_limits(lw_fit_spec *s, const lw_target *t, unsigned given);

/* How far the curve of a result may leave a target between n stations, in sizes of the target, beside twice the greatest error at a
 * station: between few stations, and where the body turns much from one to the next, the target is not known. */
static inline double lw_stray_allowed(const lw_target *t, size_t n) { return 0.02 + fmax(0.5/(double)n, lw_target_arc(t)/t->size); }

/* An error of this part of the diagonal, 1 mm of a metre, is as good as none: play and tolerances are as much. */
#define LW_EXACT_ENOUGH 1e-3

/* Does a body on a single pin do the task, a motion without prescribed timing, to LW_EXACT_ENOUGH?  *pivot: where the pin is, within the
 * default sizes; *off: the greatest distance of a place from the one that the body then has [m]. */
bool lw_pin_does(const lw_target *t, const lw_fit_spec *s, lw_vec2 *pivot, double *off);

/* The objective that the columns of a target suggest: a function without x and y, a motion with theta, else a path. */
lw_task lw_task_suggested(const lw_target *t);

/* Is it a zone that no pin and no tracer may enter? */
static inline bool lw_zone_forbids(const lw_zone *zone)
{
    return zone->kind == LW_ZONE_NO_BOX || zone->kind == LW_ZONE_NO_CIRCLE || zone->kind == LW_ZONE_NO_POLYGON;
}

static inline bool lw_zone_is_polygon(const lw_zone *zone)
{
    return zone->kind == LW_ZONE_NO_POLYGON || zone->kind == LW_ZONE_PIVOTS_POLYGON;
}

/* Bring the corners of a polygon into counter-clockwise order, and its bounding box into at, to.  Other kinds stay as they
 * are.  LW_E_ARG: the number of corners, or a corner that points inwards. */
lw_status lw_zone_settle(lw_zone *zone, lw_error *e);

/* Straight sides within which a pivot has to be. */
static inline int lw_zone_sides(const lw_zone *zone)
{
    return lw_zone_is_polygon(zone) ? zone->n_corner : zone->kind == LW_ZONE_PIVOTS_LINE ? 2 : 4;
}

/* Outward unit normal of side i of a settled polygon. */
static inline lw_vec2 lw_zone_normal(const lw_zone *zone, int i)
{
    lw_vec2 side = lw_v2_sub(zone->corner[(i + 1) % zone->n_corner], zone->corner[i]);
    return lw_v2_scale(lw_v2(side.y, -side.x), 1/sqrt(lw_v2_dot(side, side)));
}

/* Distance of a place from a forbidden zone, or from a box or polygon in which the pivots have to be [m]; negative inside.  With
 * sqrt instead of hypot, which takes a fifth of the time of a fit with zones. */
static inline double lw_zone_outside(const lw_zone *zone, lw_vec2 at)
{
    lw_vec2 off = lw_v2_sub(at, zone->at);
    if (zone->kind == LW_ZONE_NO_CIRCLE)
        return sqrt(lw_v2_dot(off, off)) - zone->reach;
    if (lw_zone_is_polygon(zone)) {
        double most = -INFINITY, least = INFINITY;
        for (int i = 0; i < zone->n_corner; i++)
            most = fmax(most, lw_v2_dot(lw_zone_normal(zone, i), lw_v2_sub(at, zone->corner[i])));
        for (int i = 0; i < zone->n_corner && most > 0; i++)
            least = fmin(least, lw_v2_segment_distance(at, zone->corner[i], zone->corner[(i + 1) % zone->n_corner]));
        return most > 0 ? least : most;
    }
    lw_vec2 beyond = lw_v2(fmax(zone->at.x - at.x, at.x - zone->to.x), fmax(zone->at.y - at.y, at.y - zone->to.y));
    return beyond.x > 0 && beyond.y > 0 ? sqrt(lw_v2_dot(beyond, beyond)) : fmax(beyond.x, beyond.y);
}

/* Which conditions contradict each other, in words; NULL when none is found.  Compares places of the pivots with the
 * range of positions and with the forbidden zones, several of them together. */
const char *lw_contradiction(const lw_fit_spec *spec);

#endif

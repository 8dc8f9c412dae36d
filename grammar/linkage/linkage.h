/* grammar/linkage/linkage.h - a linkage as people draw one: links, joints with their positions in one assembled
 * posture, inputs, tracer points.
 *
 * The posture contains every dimension: the distances and angles between the joints and points of a link.  A
 * multiple joint (several links on one pin) is written as several joints at one place.  Plain data, copied
 * with '='; nothing here allocates or needs freeing.  All values are in SI units; `units` holds the units of the
 * file it was read from. */
#ifndef LW_GRAMMAR_LINKAGE_LINKAGE_H
#define LW_GRAMMAR_LINKAGE_LINKAGE_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/units.h"
#include "base/vec2.h"
#include "grammar/topology/chain.h"
#include "grammar/topology/joint_kind.h"

#define LW_TRACER_MAX 16
#define LW_NAME_SIZE  32

typedef struct lw_joint {
    char          name[LW_NAME_SIZE];
    lw_joint_kind kind;
    int           link[2];     /* the two links it joins                                       */
    lw_vec2       at;          /* r: the pin; t, p: a point of the slide line; g: contact, f: any [m] */
    lw_vec2       along;       /* t, p: unit direction of the slide line; else (0, 0)          */
    double        ratio;       /* g: speed of link[1] over that of link[0], see lw_linkage_gear; else 0 */
} lw_joint;

/* A driven joint, a pin or a slider.  For a pin the input is the direction [rad, counter-clockwise from
 * +x of the plane] of the driven link's x axis, see lw_linkage_posture_input; mbs/plan/plan.h counts it from the
 * ground frame instead.  For a slider it is the displacement [m] of link[1] relative to link[0]
 * along `along`, 0 in the given posture unless `value` says otherwise.
 *
 * A tied input moves with the first input, `ratio` times as far from the posture: a second motor whose controller
 * keeps the ratio, a belt, or a train of gears at the frame.  Free inputs come before tied ones. */
typedef struct lw_input {
    int    joint;
    double value;              /* in the given posture                     [rad] or [m]         */
    double first, last;        /* range of motion; first == last: the whole possible range       */
    double ratio;              /* tied: its motion over that of the first [rad/rad], [m/m], ...; 0: free */
} lw_input;

typedef struct lw_tracer {
    char    name[LW_NAME_SIZE];
    int     link;
    lw_vec2 at;                /* in the given posture [m]                                      */
    double  angle;             /* direction of a tool fixed to the link, in the posture [rad]   */
} lw_tracer;

typedef struct lw_linkage {
    char      name[64];
    int       n_link, n_joint, n_input, n_tracer;
    int       ground;                              /* the fixed link                            */
    char      link_name[LW_LINK_MAX][LW_NAME_SIZE];
    lw_joint  joint[LW_JOINT_MAX];
    lw_input  input[LW_INPUT_MAX];
    lw_tracer tracer[LW_TRACER_MAX];
    lw_units  units;
} lw_linkage;

/* F = 3 (P - 1) - 2 n1 - n2  (Makkonen 1999, eq. 2); a welded joint takes 3. */
int lw_linkage_mobility(const lw_linkage *linkage);

/* The number of free inputs.  They come first; the others are tied. */
int lw_linkage_free_inputs(const lw_linkage *linkage);

/* The bearings of a gear joint.  Speeds are relative to the carrier, so the ratio is that of the rotations, > 0
 * for an internal gear and < 0 for an external one.  With a rack it is the displacement of the rack along its
 * slide line over the rotation of the pinion [m/rad] if the rack is link[1], and the inverse [rad/m] if it is
 * link[0]. */
typedef struct lw_gear {
    int     carrier;           /* the link on which both links turn or slide                   */
    int     slider[2];         /* joint in which link[i] slides on the carrier, -1: it turns   */
    double  way[2];            /* +1 where link[i] (or what is welded to it) is that joint's link[1], else -1 */
    lw_vec2 centre[2];         /* centre of rotation; a point of its slide line [m]            */
} lw_gear;

/* Find the carrier of gear joint `joint`.  Links on one pin (joints at bit-equal places) turn on each other;
 * links welded together count as one.  If several links carry both, the carrier is the one on whose line of
 * centres the contact `at` divides by the ratio (to 1e-6 of the centres' distance).  LW_E_KIND: there is none (a
 * cam, for example), or more than one. */
lw_status lw_linkage_gear(const lw_linkage *linkage, int joint, lw_gear *g, lw_error *e);

/* Unit of a ratio, with `metre` the length unit: metre if link[1] is a rack, 1/metre if link[0] is, else 1. */
double lw_linkage_gear_unit(const lw_gear *g, double metre);

/* The pitch point of joint number `gear` of `joint`, where both sides have the same velocity; the middle of the centres for ratio 1. */
lw_vec2 lw_gear_contact(const lw_joint *joint, int gear, const lw_gear *g);

#define LW_COORDINATE_MAX 1e100   /* larger ones overflow when squared: refused [m] */

/* Check what a plan relies on: indices in range, two different links for each joint, a connected linkage, finite
 * numbers, unit directions, different names.  LW_E_ARG with a text naming the joint or link. */
lw_status lw_linkage_check(const lw_linkage *linkage, lw_error *e);

/* Default value of an input in the given posture.  A slider: 0 [m].  A pin [rad, in (-pi, pi]]: the direction of
 * the x axis of its driven link, which is the one of its two links that is not the ground; if both move, the
 * direction of link[1] minus that of link[0].  The x axis runs from the input pin to the first other joint of
 * the link in the order of `joint` (gears, welds and joints at the same place are skipped), or along that
 * joint's slide line if it is a slider or the link carries the slot.  If the link has no such joint, the axis
 * runs to its first tracer, otherwise along +x. */
double lw_linkage_posture_input(const lw_linkage *linkage, int joint);

/* Read one linkage from JSON text (docs/notation.md, "Linkage"), or the first of a text with results, as
 * `linkwright fit --json` prints them.  `file` is for messages only.  LW_E_NOTATION with line and column, also for errors
 * of meaning (a link that does not exist). */
lw_status lw_linkage_read(const char *text, size_t size, const char *file, lw_linkage *linkage, lw_error *e);

/* The same for result number `which` (from 1); 0: the first, or a text that holds one linkage.  LW_E_ARG: the text has
 * no such result. */
lw_status lw_linkage_read_result(const char *text, size_t size, const char *file, int which, lw_linkage *linkage, lw_error *e);

/* JSON text of a linkage, in its units.  Every double is written so that it reads back bit-equal (up to the rounding
 * of the unit conversion).  indent: blanks for each level, the text ends with a newline; 0: one line without a
 * newline.  Free with free(); NULL when out of memory. */
char *lw_linkage_write(const lw_linkage *linkage, int indent);

#endif

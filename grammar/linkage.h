/* grammar/linkage.h - a linkage as people draw one: links, joints with their place in one assembled
 * posture, the input, tracer points.
 *
 * The posture holds every dimension: distances and angles between what a link carries.  A multiple
 * joint (several links on one pin) is several joints at one place.  Plain data, copied with '=';
 * nothing here allocates or needs freeing.  All in SI; `units` says only how a person wrote it. */
#ifndef LW_GRAMMAR_LINKAGE_H
#define LW_GRAMMAR_LINKAGE_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/units.h"
#include "base/vec2.h"
#include "grammar/chain.h"
#include "grammar/joint_kind.h"

#define LW_JOINT_MAX  64
#define LW_TRACER_MAX 16
#define LW_INPUT_MAX   8
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
 * A tied input does not move by itself but with the first one, `ratio` times as far from the posture: a second motor
 * that is told so, a belt or a train of gears at the frame.  Tied inputs stand after those that move by
 * themselves. */
typedef struct lw_input {
    int    joint;
    double value;              /* in the given posture                     [rad] or [m]         */
    double first, last;        /* the motion wanted; first == last: all of it                    */
    double ratio;              /* tied: its way over that of the first [rad/rad], [m/m], ...; 0: free */
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
int lw_linkage_mobility(const lw_linkage *k);

/* How many inputs move by themselves: the first so many; the others are tied. */
int lw_linkage_free_inputs(const lw_linkage *k);

/* Where tied input i is when the first one is at `first` [rad] or [m]. */
double lw_linkage_tied_input(const lw_linkage *k, int i, double first);

/* What the ratio of input i counts in, `metre` the length unit: metre where it slides and the first one turns,
 * 1/metre the other way. */
double lw_linkage_tie_unit(const lw_linkage *k, int i, double metre);

/* What a gear joint runs on.  Speeds are relative to the carrier, so the ratio is that of the turns, > 0
 * for an internal gear and < 0 for an external one; with a rack it is [m/rad] of the rack along its slide
 * line over the pinion if the rack is link[1], [rad/m] if it is link[0]. */
typedef struct lw_gear {
    int     carrier;           /* the link on which both links turn or slide                   */
    int     slider[2];         /* joint in which link[i] slides on the carrier, -1: it turns   */
    double  way[2];            /* +1 where link[i] (or what is welded to it) is that joint's link[1], else -1 */
    lw_vec2 centre[2];         /* where it turns; a point of its slide line [m]                */
} lw_gear;

/* Find the carrier of gear joint `joint`.  Links on one pin (joints at the bit-same place) turn on each other,
 * links welded together are one.  Where several links carry both, the one on whose line of centres
 * the contact `at` divides by the ratio (to 1e-6 of the centres' distance).  LW_E_KIND: there is none (a
 * cam, say), or more than one. */
lw_status lw_linkage_gear(const lw_linkage *k, int joint, lw_gear *g, lw_error *e);

/* What a ratio counts in, `metre` the length unit: metre where link[1] is a rack, 1/metre where link[0] is. */
double lw_linkage_gear_unit(const lw_gear *g, double metre);

/* The pitch point of a gear: where both sides move alike; the middle of the centres for ratio 1. */
lw_vec2 lw_linkage_contact(const lw_linkage *k, int joint, const lw_gear *g);

#define LW_COORDINATE_MAX 1e100   /* larger ones overflow when squared: refused [m] */

/* Check what a plan may rely on: indices in range, two different links a joint, connected, finite
 * numbers, unit directions, different names.  LW_E_ARG with a text naming the joint or link. */
lw_status lw_linkage_check(const lw_linkage *k, lw_error *e);

/* What an input counts in the given posture when nobody says otherwise.  A slider: 0 [m].  A pin [rad, in
 * (-pi, pi]]: the direction of the x axis of its driven link, which is the one of its two links that is
 * not the ground; when both move, that of link[1] less that of link[0].  The x axis runs from the
 * input pin to the first other joint of the link in the order of `joint` (gears, welds, and joints at
 * the same place, are passed over), or along that joint's slide line if it is a slider or the link
 * carries the slot; to the link's first tracer when it has no such joint; else along +x. */
double lw_linkage_posture_input(const lw_linkage *k, int joint);

/* Read one linkage from JSON text (docs/notation.md, "Linkage").  `file` is for messages only.
 * LW_E_NOTATION with line and column, also for faults of meaning (a link that does not exist). */
lw_status lw_linkage_read(const char *text, size_t size, const char *file, lw_linkage *k,
                          lw_error *e);

/* JSON text of a linkage, in k->units, every double written so that it reads back bit-equal (to
 * rounding of the unit conversion).  indent: blanks a level, ends with a newline; 0: one line without
 * a newline.  Free with free(); NULL when out of memory. */
char *lw_linkage_write(const lw_linkage *k, int indent);

#endif

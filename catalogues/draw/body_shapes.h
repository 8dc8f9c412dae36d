/* catalogues/draw/body_shapes.h - the bodies that represent a linkage in a drawing: which link of a sliding pair is
 * the guide and which the block, where the block sits, how far it travels, which points a link must reach. In
 * metres, in the posture shown. */
#ifndef LW_CATALOGUES_DRAW_BODY_SHAPES_H
#define LW_CATALOGUES_DRAW_BODY_SHAPES_H

#include "catalogues/draw/scene.h"

#define LW_NODE_MAX (LW_JOINT_MAX + LW_TRACER_MAX)    /* of a link of a linkage */

typedef struct lw_slide {
    int     guide, block;      /* links                                                            */
    lw_vec2 at;                /* the block, on the line: at the foot of its nearest pin           */
    lw_vec2 along;             /* unit direction                                                   */
    double  lo, hi;            /* what the guide must cover, from `at` along `along` [m]; lo <= 0 <= hi:
                                * travel of the block and feet of the guide's own pins             */
} lw_slide;

/* Joint j of the scene's linkage, a slider or a pin in a slot.  The ground is always the guide;
 * else the block is the link whose pin lies nearer to the line, then the one without a tracer. */
lw_slide lw_body_shapes_slide(const lw_scene *s, int j);

/* A cylinder: an input between two moving links whose pins both lie on its line. */
typedef struct lw_cylinder {
    int     tube, rod;         /* links                                                            */
    lw_vec2 pin[2];            /* pin of the tube, pin of the rod                                  */
    lw_vec2 along;             /* unit, from the first to the second                               */
    double  tube_length;       /* from the tube's pin: it never reaches the rod's                  */
    double  rod_length;        /* from the rod's pin back to the piston, which stays in the tube   */
} lw_cylinder;

/* False: joint j is no such input, or its stroke is too long for a cylinder (over 0.9 of its shortest length). */
bool lw_body_shapes_cylinder(const lw_scene *s, int j, lw_cylinder *c);

/* One side of a gear pair: a wheel, or a rack. */
typedef struct lw_wheel {
    int     link;
    bool    rack, ring;        /* ring: the teeth stand inwards                                     */
    lw_vec2 centre;            /* rack: the pitch point                                             */
    double  radius;            /* of the pitch circle [m]                                           */
    lw_vec2 along;             /* to the pitch point; rack: unit direction of its line              */
    double  lo, hi;            /* rack: what its line must cover, from the pitch point              */
    int     teeth;             /* of the whole circle; rack: per 2 pi pitch                         */
    double  pitch;             /* along the pitch line [m]                                          */
    bool    gap;               /* at the pitch point stands a gap, not a tooth                      */
} lw_wheel;

/* Both sides of gear joint j; the numbers of teeth are chosen to fit the radii.  False: no gear pair that turns on a
 * carrier (a cam, say), or wheels without size. */
bool lw_body_shapes_gear(const lw_scene *s, int j, lw_wheel wheel[2]);

/* The points that a link's body must reach, at most `room`: its pins and welds (several at one place count once), tracers, blocks,
 * ends of springs, ropes and cylinders, and for a guide the feet of its pins on the line. Returns their number. */
int lw_body_shapes_nodes(const lw_scene *s, int link, lw_vec2 *node, int room);

#endif

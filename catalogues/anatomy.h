/* catalogues/anatomy.h - the bodies as which a linkage is drawn: which link of a sliding pair is the
 * guide and which the block, where the block sits, how far it travels, which points a link must reach.
 * All in metres, in the posture shown. */
#ifndef LW_CATALOGUES_ANATOMY_H
#define LW_CATALOGUES_ANATOMY_H

#include "catalogues/scene.h"

#define LW_NODE_MAX (LW_JOINT_MAX + LW_TRACER_MAX)

typedef struct lw_slide {
    int     guide, block;      /* links                                                            */
    lw_vec2 at;                /* the block, on the line: at the foot of its nearest pin           */
    lw_vec2 along;             /* unit direction                                                   */
    double  lo, hi;            /* what the guide must cover, from `at` along `along` [m]; lo <= 0 <= hi:
                                * travel of the block and feet of the guide's own pins             */
} lw_slide;

/* Joint j of the scene's linkage, LW_JOINT_SLIDER or LW_JOINT_SLOT.  The ground is always the guide;
 * else the block is the link whose pin lies nearer to the line, then the one without a tracer. */
lw_slide lw_anatomy_slide(const lw_scene *s, int j);

typedef struct lw_node { lw_vec2 at; int joint, tracer; } lw_node;   /* -1: not that */

/* The points that hold a link together: its pins (several on one place count once), its tracers, its
 * blocks, and for a guide the feet of its pins on the line.  Returns their number. */
int lw_anatomy_nodes(const lw_scene *s, int link, lw_node node[LW_NODE_MAX]);

#endif

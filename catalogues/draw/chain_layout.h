/* catalogues/draw/chain_layout.h - places of the joints of a chain on a page: a picture as in textbooks, with joints
 * as points, binary links as straight bars, links of more joints as polygons over their joints.
 *
 * A chain with a planar graph (links as vertices) has a picture in which no two links cross or overlap. The joints
 * stand around each link in the order of an embedding in the plane; then the map is planar too whose vertices are the
 * joints and whose faces are the links and loops. First, joints are placed by barycentres (Tutte 1963, "How to draw
 * a graph"), with an extra point in every loop so that no loop collapses. Then the picture is relaxed: links towards
 * regular shapes, joints towards distances like those in the chain (Kamada & Kawai 1989), joints away from links of
 * others. A barrier that no step jumps over keeps the map. Several embeddings and outer loops are tried; the most
 * even and symmetric picture is kept, and its symmetry is exact.
 *
 * With a ground link, the joints of the ground stand on one horizontal line and everything else above it, so that the
 * signs of the frame below the line touch nothing. A binary link with a pin and a slider (t) is drawn as a block:
 * its two joints are one point.
 *
 * A chain whose graph is not planar is cut at binary links until it is planar. The rest is drawn, and the cut bars
 * are put back straight where they cross the fewest links. The same chain gives the same picture. */
#ifndef LW_CATALOGUES_DRAW_CHAIN_LAYOUT_H
#define LW_CATALOGUES_DRAW_CHAIN_LAYOUT_H

#include "base/vec2.h"
#include "grammar/topology/mechanism.h"

typedef struct lw_chain_layout {
    int     n_joint;
    lw_vec2 at[LW_JOINT_MAX];            /* of a joint; y up; a bar is about 1 long                     */
    int     first[LW_LINK_MAX + 1];      /* link i has the joints ring[first[i]] .. ring[first[i+1]-1], */
    uint8_t ring[2*LW_JOINT_MAX];        /* in the order of its outline; ground: from left to right     */
    lw_vec2 end[LW_LINK_MAX];            /* free end of a link with a single joint                      */
    uint32_t axes;                       /* bits of links that are axes of multiple joints: one point each */
    bool    planar;                      /* the graph is planar                                         */
    int     n_cross;                     /* pairs of links that cross or overlap; 0 when planar         */
    int     symmetry;                    /* order of the symmetry group of the picture; 1: no symmetry */
    double  least_angle;                 /* between two links at a joint, and inside links [rad]        */
    double  least_gap;                   /* joint to joint, joint to another link; a mean bar is 1 long */
} lw_chain_layout;

/* m: any topology; the joints of its ground, if any, stand on a line.  LW_E_ARG with a text: not connected, fewer
 * than two links. */
lw_status lw_chain_layout_make(const lw_mechanism *m, lw_chain_layout *l, lw_error *e);

/* The same for a chain with multiple joints: m and axes from lw_multiple_mechanism.  All joints of an axis have one
 * place, and its ring tells the order of the links around it. */
lw_status lw_axes_layout_make(const lw_mechanism *m, uint32_t axes, lw_chain_layout *l, lw_error *e);

#endif

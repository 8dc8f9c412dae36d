/* catalogues/draw/chain_layout.h - where the joints of a chain go on the page: a picture as in textbooks, with
 * joints as points, binary links as straight bars, links of more joints as polygons over their joints.
 *
 * A chain with a planar graph (links as vertices) has a picture in which no two links cross or overlap:
 * around every link its joints stand in the order of an embedding in the plane; the map whose vertices are the joints
 * and whose faces are links and loops is planar too.  It is drawn first by barycentres (Tutte 1963, "How
 * to draw a graph"), with a point more in every loop so that nothing collapses; then it is relaxed: links
 * towards regular shapes, joints apart by their distance in the chain (Kamada & Kawai 1989), joints away
 * from links they do not belong to, by a barrier that no step jumps over, so that the map stays.  Among
 * embeddings and outer loops those of most symmetry and evenness are tried; symmetry is kept exactly.
 *
 * With a ground link its joints stand on one horizontal line and everything else above it, so that signs
 * of the frame below the line hit nothing.  A binary link of a pin and a slider (t) is drawn as the
 * block alone: its two joints are one point.
 *
 * A chain whose graph is not planar is cut at one binary link or more until it is, drawn, and the bars
 * are put back straight where they cross fewest links.  Same chain, same picture. */
#ifndef LW_CATALOGUES_DRAW_CHAIN_LAYOUT_H
#define LW_CATALOGUES_DRAW_CHAIN_LAYOUT_H

#include "base/vec2.h"
#include "grammar/mechanism.h"

typedef struct lw_chain_layout {
    int     n_joint;
    lw_vec2 at[LW_JOINT_MAX];            /* of a joint; y up; a bar is about 1 long                     */
    int     first[LW_LINK_MAX + 1];      /* link i has the joints ring[first[i]] .. ring[first[i+1]-1], */
    uint8_t ring[2*LW_JOINT_MAX];        /* in the order of its outline; ground: from left to right     */
    lw_vec2 end[LW_LINK_MAX];            /* free end of a link with a single joint                      */
    bool    planar;                      /* the graph is planar                                         */
    int     n_cross;                     /* pairs of links that cross or overlap; 0 when planar         */
    int     symmetry;                    /* order of the symmetry of the picture that was kept, 1: none */
    double  least_angle;                 /* between two links at a joint, and inside links [rad]        */
    double  least_gap;                   /* joint to joint, joint to a link it is not of; a mean bar: 1 */
} lw_chain_layout;

/* m: any topology; its ground, when chosen, stands on a line.  LW_E_ARG with a text: not connected, fewer
 * than two links. */
lw_status lw_chain_layout_make(const lw_mechanism *m, lw_chain_layout *l, lw_error *e);

/* Work out n_cross, least_angle and least_gap of the places in l. */
void lw_chain_layout_measure(const lw_mechanism *m, lw_chain_layout *l);

#endif

/* catalogues/exchange/layers_internal.h - how near two bodies come to each other in all of a motion.
 *
 * Between two postures a corner goes at least along the chord c and, the path bending, a little further.  With d2 the
 * second difference of its places at either end, we take  L = c + d2/2:  an arc of a circle is longer than its chord
 * by about a twelfth of that, and a cusp halfway by half of it.  A body of corners goes no further than its corners
 * do.  While two bodies make the ways La and Lb between distances d0 and d1, each has at any moment either less than
 * half of both ways behind it or before it, hence
 *     distance  >=  (d0 + d1 - La - Lb)/2. */
#ifndef LW_CATALOGUES_EXCHANGE_LAYERS_INTERNAL_H
#define LW_CATALOGUES_EXCHANGE_LAYERS_INTERNAL_H

#include "catalogues/exchange/layers.h"

/* A plate or a pin in every posture of a scene. */
typedef struct lw_plate_body {
    int      n;
    lw_vec2 *at;               /* corners in posture after posture                  (n_frame*n) owned  */
    double  *way;              /* L, the longest, from the posture before f to f    (n_frame)          */
} lw_plate_body;

/* Corners (n, in the posture of the file) that move with a link.  LW_E_MEMORY. */
lw_status lw_body_move(const lw_scene *s, int link, const lw_vec2 *corner, int n, lw_plate_body *b);
void      lw_body_free(lw_plate_body *b);

/* seen: the least distance in the postures; sure: what it is not less than in between. */
typedef struct lw_approach { double seen, sure; } lw_approach;
lw_approach lw_body_approach(const lw_scene *s, const lw_plate_body *a, const lw_plate_body *b);

#endif

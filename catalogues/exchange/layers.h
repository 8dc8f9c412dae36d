/* catalogues/exchange/layers.h - a linkage as plates on pins: the shape of each plate, and layers in which all links pass
 * each other and the pins over the whole motion.
 *
 * A plate is the convex hull of what its link carries, widened by `radius`.  A pin has a hole in each link it
 * joins and stands through all layers between them.  A slider is a slot in the guide and two pins of the block
 * that run in it, a pin in a slot one pin.  The ground is the base, alone in layer 0.  Two plates in one layer
 * must stay apart in all of the motion, and so must a pin and the plates it passes: between the scene's postures too,
 * by what each can move from one to the next; where that does not tell, 4 and 16 times as many postures are looked
 * at, and what is not certain then is taken to meet. */
#ifndef LW_CATALOGUES_EXCHANGE_LAYERS_H
#define LW_CATALOGUES_EXCHANGE_LAYERS_H

#include "catalogues/draw/scene.h"

#define LW_CORNER_MAX 64
#define LW_HOLE_MAX   64
#define LW_PIN_MAX    96

typedef struct lw_hole { lw_vec2 a, b; } lw_hole;      /* centres of its ends; equal: a round hole       */

typedef struct lw_plate {
    int     n_corner, n_hole;
    lw_vec2 corner[LW_CORNER_MAX];     /* of the hull before it is widened, counter-clockwise; 1: a disc,
                                        * 2: a bar; in the posture [m]                                 */
    lw_hole hole[LW_HOLE_MAX];
} lw_plate;

typedef struct lw_pin {
    lw_vec2  at;                       /* in the posture [m]                                           */
    uint32_t links;                    /* bit of each link it goes through                             */
    int      owner;                    /* the link it moves with                                       */
    int      low, high;                /* layers of the lowest and the highest of these                */
} lw_pin;

typedef struct lw_layers {
    double   radius;                   /* by which plates are wider than their hull [m]                */
    double   bore;                     /* radius of pins and holes, half the width of slots [m]        */
    double   thickness;                /* of a plate [m]                                               */
    double   room;                     /* between plates in one layer, and pins and plates they pass, at
                                        * least, over all of the motion; INFINITY: nothing passes [m]  */
    int      n_layer, n_pin;
    int      layer[LW_LINK_MAX];       /* 0: the ground's                                              */
    lw_plate plate[LW_LINK_MAX];
    lw_pin   pin[LW_PIN_MAX];
} lw_layers;

/* Fewest layers.  radius 0: a third of the shortest distance of two pins of a link, at most a
 * twenty-fifth of the posture's size.  LW_E_KIND: gears, welds, or no motion is known (s->note);
 * LW_NOTHING: there are no such layers, and a text; LW_STOPPED: none was found in a million steps. */
lw_status lw_layers_find(const lw_scene *s, double radius, lw_layers *l, lw_error *e);

/* The least distance of two convex plates, 0 when they meet; of corners as in lw_plate. */
double lw_hull_distance(const lw_vec2 *a, int n_a, const lw_vec2 *b, int n_b);

#endif

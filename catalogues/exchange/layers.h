/* catalogues/exchange/layers.h - a linkage as plates on pins: the shape of each plate, and layers in which all links
 * pass each other and the pins over the whole motion.
 *
 * A plate is the convex hull of the joints and tracers of its link, widened by `radius`. A pin has a hole in each
 * link it joins and passes through all layers between them. A slider is a slot in the guide with two pins of the
 * block in it; a pin in a slot is one such pin. The ground is the base, alone in layer 0. Two plates in one layer
 * must stay apart over the whole motion, and so must a pin and the plates it passes. Between two postures of the scene
 * this is concluded from how far each can move. Where that does not decide, 4 and 16 times as many postures are
 * computed; pairs that are still undecided count as touching. */
#ifndef LW_CATALOGUES_EXCHANGE_LAYERS_H
#define LW_CATALOGUES_EXCHANGE_LAYERS_H

#include "catalogues/draw/scene.h"

typedef struct lw_hole { lw_vec2 a, b; } lw_hole;      /* centres of its ends; equal: a round hole       */

typedef struct lw_plate {
    int     n_corner, n_hole;
    lw_vec2 *corner;                   /* of the hull before it is widened, counter-clockwise; 1: a disc,
                                        * 2: a bar; in the posture [m]                                 */
    lw_hole *hole;
} lw_plate;

typedef struct lw_pin {
    lw_vec2  at;                       /* in the posture [m]                                           */
    int      n_link, *link;            /* those it goes through                                        */
    int      owner;                    /* the link it moves with                                       */
    int      low, high;                /* layers of the lowest and the highest of these                */
} lw_pin;

typedef struct lw_layers {
    double   radius;                   /* by which plates are wider than their hull [m]                */
    double   bore;                     /* radius of holes, half the width of slots [m]                 */
    double   pin_radius;               /* of pins [m]                                                  */
    double   thickness;                /* of a plate [m]                                               */
    double   room;                     /* between plates in one layer, and pins and plates they pass, at
                                        * least, over all of the motion; INFINITY: nothing passes [m]  */
    int      n_layer, n_pin;
    bool     fewest;                   /* no fewer layers are possible; false: not proved              */
    int      *layer;                   /* of each link; 0: the ground's                                */
    lw_plate *plate;                   /* of each link                                                 */
    lw_pin   *pin;
    void     *memory[3];               /* of holes and corners; for hulls                              */
} lw_layers;

/* Is the link one of those that the pin goes through? */
bool lw_pin_joins(const lw_pin *p, int link);

/* Sizes of plates [m]; 0, and for the clearance a negative value: the usual ones. */
typedef struct lw_plate_size {
    double radius;                     /* half the width of a bar. Usual: a third of the shortest distance of two pins
                                        * of a link, at most 1/25 of the linkage's size                */
    double bore;                       /* radius of holes. Usual: 0.4 of `radius`                      */
    double thickness;                  /* Usual: `radius`                                              */
    double clearance;                  /* a pin's diameter is smaller than its hole by this. Usual: 0.1 `bore` */
} lw_plate_size;

/* Find the fewest layers. size NULL: the usual sizes. LW_E_ARG: a hole as wide as its plate, or a clearance as wide as
 * its hole; LW_E_KIND: gears, welds, or no motion is known (s->note); LW_NOTHING with a text: there are no such layers;
 * LW_STOPPED: none were found in about a second of work, or *s->stop. Free l with lw_layers_free, after a failure too. */
lw_status lw_layers_find(const lw_scene *s, const lw_plate_size *size, lw_layers *l, lw_error *e);
void      lw_layers_free(lw_layers *l);

/* Distance of two convex plates with corners as in lw_plate; 0 when they touch. */
double lw_hull_distance(const lw_vec2 *a, int n_a, const lw_vec2 *b, int n_b);

#endif

/* catalogues/exchange/plates.h - a linkage as plates and pins in layers (layers.h), and their outlines as closed loops
 * of lines and arcs. */
#ifndef LW_CATALOGUES_EXCHANGE_PLATES_H
#define LW_CATALOGUES_EXCHANGE_PLATES_H

#include "catalogues/exchange/export.h"
#include "catalogues/exchange/layers.h"

#define LW_PLATES_FRAMES 240               /* postures of the motion                                   */

/* A side of a loop, from its point to that of the next side: a line, or an arc about a centre, counter-clockwise. */
typedef struct lw_plate_side { lw_vec2 from, centre; bool arc; } lw_plate_side;

typedef struct lw_plate_loop {                   /* counter-clockwise [m]                                    */
    int     n;                             /* 1: a circle                                              */
    double  radius;                        /* of its arcs                                              */
    lw_plate_side *side;
} lw_plate_loop;

typedef struct lw_plates {
    lw_scene       scene;
    lw_layers      layers;
    lw_plate_side *side;                   /* room for the loops of any one slab                       */
    lw_plate_loop *hole;
} lw_plates;

/* Find the layers. Free it with lw_plates_free. LW_E_ARG: sizes that do not fit together; failures as in layers.h. */
lw_status lw_plates_make(const lw_assembly *linkage, const lw_export_options *o, lw_plates **out, lw_error *e);
void      lw_plates_free(lw_plates *w);

/* LW_E_KIND with a text: two holes of a plate meet, so that the plate is no solid with round holes and slots. */
lw_status lw_plates_check_holes(const lw_plates *w, lw_error *e);

/* One sentence that says what is known about the free space in the layers. */
void lw_plates_room(const lw_plates *w, char *text, size_t size);

/* The outline of a convex polygon (counter-clockwise, or a bar, or a point), widened by r, into `side` (2 n). */
void lw_loop_widen(const lw_vec2 *p, int n, double r, lw_plate_side *side, lw_plate_loop *loop);

/* A body between two heights: an outline and its holes. */
typedef struct lw_slab {
    char    name[LW_NAME_SIZE + 16];
    double  low, high;                     /* [m]                                                      */
    int     n_hole;
    lw_plate_loop outline, *hole;
} lw_slab;

/* Number of plates and pins; slab i of them, in the posture, until the next one is asked for. */
int  lw_plates_count(const lw_plates *w);
void lw_plates_slab(lw_plates *w, int i, lw_slab *s);

#endif

/* catalogues/draw/diagram_internal.h - the parts of a diagram: diagram.c (views, curves, target),
 * diagram_linkage.c (links, joints, their labels), diagram_margin.c (title, scale, legend). */
#ifndef LW_CATALOGUES_DRAW_DIAGRAM_INTERNAL_H
#define LW_CATALOGUES_DRAW_DIAGRAM_INTERNAL_H

#include "catalogues/draw/diagram.h"
#include "catalogues/draw/labels.h"

typedef struct lw_sketch {
    const lw_scene *s;
    const lw_diagram_options *o;
    lw_drawing *d;
    lw_label_map map;
    double u;                  /* size of things: 1 for a page of 1000 by 750                      */
} lw_sketch;

lw_vec2 lw_sketch_pixel(const lw_sketch *k, int panel, lw_vec2 p);
/* Cut the line a b to a box (Liang and Barsky 1984); false when it passes by or is not finite. */
bool    lw_sketch_clip(const lw_box *box, lw_vec2 *a, lw_vec2 *b);
lw_box  lw_view_box(const lw_view *v);                    /* where labels may stand                  */

void    lw_sketch_linkage(lw_sketch *k);                  /* in panel 0                              */
void    lw_sketch_label_linkage(lw_sketch *k);

double  lw_sketch_header(lw_sketch *k);                   /* paper, title, dimensions; height used   */
double  lw_sketch_foot(const lw_sketch *k, double width); /* height that a panel's foot takes        */
void    lw_sketch_feet(lw_sketch *k);                     /* scale bars, legend, note                */

#endif

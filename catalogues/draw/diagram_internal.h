/* catalogues/draw/diagram_internal.h - a diagram while it is drawn: what diagram_linkage.c, diagram_margins.c and diagram.c share. */
#ifndef LW_CATALOGUES_DRAW_DIAGRAM_INTERNAL_H
#define LW_CATALOGUES_DRAW_DIAGRAM_INTERNAL_H

#include "catalogues/draw/diagram.h"
#include "catalogues/draw/labels.h"
#include "grammar/model/model.h"

typedef struct lw_sketch {
    const lw_scene *s;
    const lw_diagram_options *o;
    lw_drawing *d;
    lw_label_map map;
    double u;                  /* size of signs and letters: 1 for a page of 1000 by 750           */
    double signs;              /* factor on those of links and joints                              */
    int    room;               /* for the points of a link, in metres and on the page              */
    lw_vec2 *node;
    lw_vec2 *corner;
} lw_sketch;

static inline const lw_assembly *lw_sketch_linkage_of(const lw_sketch *k)
{
    return &k->s->linkage;
}

static inline bool lw_sketch_on_ground(const lw_assembly *linkage, const lw_joint *j)
{
    return j->link[0] == linkage->ground || j->link[1] == linkage->ground;
}

static inline lw_vec2 lw_sketch_pixel(const lw_sketch *k, int panel, lw_vec2 p)
{
    return lw_view_pixel(&k->d->view[panel], p);
}

/* Where labels may stand. */
static inline lw_box lw_sketch_view_box(const lw_view *v)
{
    return (lw_box){ v->x + 2, v->y + 2, v->x + v->w - 2, v->y + v->h - 2 };
}

/* ---- diagram_linkage.c: links and joints ----------------------------------------------------------------------- */

/* Draw all parts. */
void lw_sketch_linkage(lw_sketch *k);

/* Clip the line a b to a box (Liang and Barsky 1984). False: the line misses the box or is not finite. */
bool lw_sketch_clip(const lw_box *box, lw_vec2 *a, lw_vec2 *b);

/* ---- diagram_margins.c: labels, title, dimensions, scale bar, legend ------------------------------------------------ */

/* Names of joints and tracers, and lengths. */
void lw_sketch_labels(lw_sketch *k);

/* Title and dimensions at the top of the page.  Returns where the views begin [px]. */
double lw_sketch_header(lw_sketch *k);

/* Scale bar, legend and note at the feet of the views, and the height that they need below a view of this width [px]. */
double lw_sketch_foot_height(const lw_sketch *k, double width);
void   lw_sketch_feet(lw_sketch *k);

#endif

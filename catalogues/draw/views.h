/* catalogues/draw/views.h - which part of the plane a diagram shows, and at what scale. */
#ifndef LW_CATALOGUES_DRAW_VIEWS_H
#define LW_CATALOGUES_DRAW_VIEWS_H

#include "catalogues/draw/drawing.h"
#include "catalogues/draw/labels.h"
#include "catalogues/draw/scene.h"

/* A path this many times smaller than the whole gets a panel of its own. */
#define LW_SPECK 4.0

bool    lw_box_is_empty(const lw_box *b);
double  lw_box_size(const lw_box *b);                     /* diagonal; 0 when empty                  */

lw_box  lw_scene_path_box(const lw_scene *s);             /* target points, else the shown curves    */
lw_box  lw_scene_box(const lw_scene *s, bool whole_motion);   /* everything worth showing [m]        */

/* A view of `content` in the box x, y, w, h [px] that keeps `margin` free all around. */
lw_view lw_view_fit(lw_box content, double x, double y, double w, double h, double margin);

#endif

/* catalogues/draw/labels.h - places for the labels of a drawing. Each label takes the candidate place that covers
 * the least ink and lies nearest, and never touches a label placed before.
 *
 * A coarse map holds how much is drawn where; a summed-area table (Crow 1984) makes the cost of a candidate four
 * look-ups. */
#ifndef LW_CATALOGUES_DRAW_LABELS_H
#define LW_CATALOGUES_DRAW_LABELS_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/vec2.h"

#define LW_LABEL_MAX 256

typedef struct lw_box { double x0, y0, x1, y1; } lw_box;            /* x0 <= x1, y0 <= y1          */

typedef struct lw_label_map {
    int     columns, rows;             /* cells of 4 px                                            */
    double *ink;                       /* (columns + 1)(rows + 1); summed once the first is placed */
    bool    summed;
    int     n_taken;
    lw_box  taken[LW_LABEL_MAX];       /* boxes no label may touch                                 */
} lw_label_map;

lw_status lw_label_map_make(lw_label_map *m, double width, double height, lw_error *e);
void      lw_label_map_free(lw_label_map *m);

/* Add a drawn line or disc to the map, before the first label is placed.  weight: cost of each cell. */
void lw_label_map_line(lw_label_map *m, lw_vec2 a, lw_vec2 b, double weight);
void lw_label_map_disc(lw_label_map *m, lw_vec2 at, double radius, double weight);

/* A box that labels must avoid.  Boxes beyond LW_LABEL_MAX are ignored. */
void lw_label_map_take(lw_label_map *m, lw_box box);

/* Find a place for a text of this size near the line from a to b (a point: a = b), at least `gap` away from it and
 * inside `within`, and mark its box as taken. False: there is none, or LW_LABEL_MAX boxes are taken. at: left end of the base line. */
bool lw_label_map_place(lw_label_map *m, const char *text, double size, lw_vec2 a, lw_vec2 b, double gap, lw_box within, lw_vec2 *at);

#endif

/* catalogues/draw/chain_drawing.h - a layout of a chain as a drawing: bars and shaded polygons with pins; for a
 * mechanism also frame, sliders, slots, gears and inputs, with the signs of catalogues/draw/symbols.h.
 *
 * A slider (t) is a block on a rail of its first link, on a hatched line when that is the frame; a pin in a
 * slot (p) a slot along the side of its link; a gear or cam contact (g) two circles that touch.  Driven
 * joints carry an arrow; the driven link is purple, the output green. */
#ifndef LW_CATALOGUES_DRAW_CHAIN_DRAWING_H
#define LW_CATALOGUES_DRAW_CHAIN_DRAWING_H

#include "base/bytes.h"
#include "catalogues/draw/chain_layout.h"
#include "catalogues/draw/drawing.h"
#include "catalogues/draw/labels.h"

typedef struct lw_chain_style {
    double width, height;         /* of the picture [px]           */
    bool   numbers;               /* of links, counted from 1      */
    const char *caption;          /* below the picture; NULL: none */
} lw_chain_style;

/* Add the picture of a chain inside `box` [px], as large as it fits; a bar is at most a third of the
 * smaller side.  A shape's item is its link or joint, counted from 0. */
void lw_chain_draw_into(const lw_mechanism *m, const lw_chain_layout *l, lw_box box, bool numbers, lw_drawing *d);

/* A drawing of its own.  LW_E_ARG for sizes outside 32 .. 8192 px. */
lw_status lw_chain_draw(const lw_mechanism *m, const lw_chain_layout *l, const lw_chain_style *s, lw_drawing *d, lw_error *e);

#endif

/* catalogues/draw/symbols.h - the signs of a kinematic diagram, in pixels, in the spirit of ISO 3952-1.
 * u is the size of things on the page: 1 for a picture of 1000 by 750. */
#ifndef LW_CATALOGUES_DRAW_SYMBOLS_H
#define LW_CATALOGUES_DRAW_SYMBOLS_H

#include "catalogues/draw/drawing.h"

typedef struct lw_bearer { int item, link, panel; } lw_bearer;   /* goes into every shape of a symbol */

void lw_symbol_pin(lw_drawing *d, lw_bearer b, lw_vec2 at, double u);
/* Triangle below the pin with a hatched base. */
void lw_symbol_pivot(lw_drawing *d, lw_bearer b, lw_vec2 at, double u);
/* Line from a to p with hatching on its right side, seen from a on the page. */
void lw_symbol_hatched_line(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u);
/* Rectangle with its long side along the unit vector. */
void lw_symbol_block(lw_drawing *d, lw_bearer b, lw_vec2 at, lw_vec2 along, lw_ink ink, double u);
/* Two lines on both sides of a slot, with round ends. */
void lw_symbol_slot(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, lw_ink ink, double u);
/* Arc with a head, counter-clockwise, beginning at angle `from` (counter-clockwise from the right); `back`: the same
 * arc with its head at the other end. */
void lw_symbol_turning(lw_drawing *d, lw_bearer b, lw_vec2 at, double from, bool back, double u);
void lw_symbol_arrow(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u);
void lw_symbol_tracer(lw_drawing *d, lw_bearer b, lw_vec2 at, double u);
void lw_symbol_station(lw_drawing *d, lw_role role, lw_bearer b, lw_vec2 at, double u);
/* Tube from a along the unit vector, as a box that a rod runs in. */
void lw_symbol_tube(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 along, double length, lw_ink ink, double u);
/* Rod from its pin p back along the unit vector to its piston. */
void lw_symbol_rod(lw_drawing *d, lw_bearer b, lw_vec2 p, lw_vec2 along, double length, lw_ink ink, double u);
/* Toothed wheel: a tooth, or a gap, at angle `at` on the page; ring: only its outline. */
void lw_symbol_wheel(lw_drawing *d, lw_bearer b, lw_vec2 centre, double radius, int teeth, double at, bool gap,
                     bool ring, lw_ink ink, double u);
/* Toothed line from lo to hi along the unit vector, `body` px thick on its left side, seen on the page. */
void lw_symbol_rack(lw_drawing *d, lw_bearer b, lw_vec2 p, lw_vec2 along, double lo, double hi, double pitch,
                    bool gap, double body, lw_ink ink, double u);
/* Filled corner between two unit vectors; a dot where there is no corner. */
void lw_symbol_weld(lw_drawing *d, lw_bearer b, lw_vec2 at, lw_vec2 one, lw_vec2 other, lw_ink ink, double u);
/* A wall across the end of a link that is held there and leaves along the unit vector; (0, 0): upwards. */
void lw_symbol_clamp(lw_drawing *d, lw_bearer b, lw_vec2 at, lw_vec2 leaves, double u);
/* A scale bar that begins at `at`, of a round length of at most `most` px, and its length with the unit and a remark; px: pixels per
 * unit.  Returns the width of all of it; 0: there is no such length. */
double lw_symbol_scale_bar(lw_drawing *d, lw_bearer b, lw_vec2 at, double px, double most, const char *unit, const char *remark, double u);
/* Bars one after the other between n points, n > 1. */
void lw_symbol_frame(lw_drawing *d, lw_bearer b, const lw_vec2 *p, int n, lw_ink ink, double u);
/* Bar for two points, shaded polygon for more (their convex hull); nothing for fewer. */
void lw_symbol_link(lw_drawing *d, lw_bearer b, const lw_vec2 *p, int n, lw_ink ink, double u);

#endif

/* catalogues/draw/svg.h - a drawing as SVG 1.1 text.  Elements carry class (role), data-item and data-link,
 * text stays text, and the same drawing gives the same bytes. */
#ifndef LW_CATALOGUES_DRAW_SVG_H
#define LW_CATALOGUES_DRAW_SVG_H

#include "base/bytes.h"
#include "catalogues/draw/drawing.h"

/* A file of its own, with fixed (light) colours. */
lw_status lw_svg_write(const lw_drawing *d, lw_bytes *out, lw_error *e);

/* The same for use inside a page: no XML header, colours by class ("i-blue" filled, "s-blue" stroked),
 * ids made different by `prefix`. */
void lw_svg_inline(const lw_drawing *d, const char *prefix, lw_bytes *out);

#endif

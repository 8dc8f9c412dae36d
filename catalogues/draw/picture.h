/* catalogues/draw/picture.h - the bridge to cairo: a drawing as PNG, PDF, or pixels. Files contain no dates and no
 * paths: the same drawing gives the same bytes with the same cairo and fonts. cairo is loaded with the first
 * picture. LW_E_IO: cairo is missing, or no more files can be opened; LW_E_MEMORY; LW_E_NUMERIC with the text of cairo. */
#ifndef LW_CATALOGUES_DRAW_PICTURE_H
#define LW_CATALOGUES_DRAW_PICTURE_H

#include <stdint.h>
#include "base/bytes.h"
#include "catalogues/draw/diagram.h"
#include "catalogues/draw/drawing.h"

lw_status lw_picture_png(const lw_drawing *d, lw_bytes *out, lw_error *e);
lw_status lw_picture_pdf(const lw_drawing *d, lw_bytes *out, lw_error *e);

/* Several drawings (n, 1 or more), each on a page of its own size; the title is that of the first. */
lw_status lw_picture_pdf_pages(const lw_drawing *d, size_t n, lw_bytes *out, lw_error *e);

/* Pixels 0x00RRGGBB, row by row, of the drawing with every link where it is in `frame` of the scene;
 * s NULL: as drawn.  pixel: (width * height), the sizes of d rounded up. */
lw_status lw_picture_pixels(const lw_drawing *d, const lw_scene *s, size_t frame, uint32_t *pixel, lw_error *e);

#endif

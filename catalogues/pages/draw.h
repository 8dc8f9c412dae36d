/* catalogues/pages/draw.h - write a scene to a file; the end of its name chooses SVG, PDF, PNG, GIF or HTML. */
#ifndef LW_CATALOGUES_PAGES_DRAW_H
#define LW_CATALOGUES_PAGES_DRAW_H

#include "base/bytes.h"
#include "catalogues/draw/plot.h"
#include "catalogues/draw/scene.h"
#include "catalogues/draw/space_scene.h"

typedef enum lw_draw_kind { LW_DRAW_SVG, LW_DRAW_PDF, LW_DRAW_PNG, LW_DRAW_GIF, LW_DRAW_HTML } lw_draw_kind;

/* Kind of picture by the end of a name, upper or lower case: "x.svg", or "svg" alone. LW_E_ARG with the list of
 * kinds. */
lw_status lw_draw_kind_of(const char *path, lw_draw_kind *kind, lw_error *e);

/* The scene as bytes of a file.  width, height [px]; 0: the default of the kind. */
lw_status lw_draw_bytes(const lw_scene *s, lw_draw_kind kind, int width, int height, lw_bytes *out, lw_error *e);

/* Write the scene to a file; path "-" is standard output. */
lw_status lw_draw_save(const lw_scene *s, lw_draw_kind kind, const char *path, int width, int height, lw_error *e);

/* The same of a spatial scene, seen from a direction. */
lw_status lw_draw_space(const lw_space_scene *s, lw_space_view view, lw_draw_kind kind, int width, int height, lw_bytes *out, lw_error *e);

/* A drawing as SVG, PNG or PDF.  LW_E_ARG: another kind. */
lw_status lw_draw_still(const lw_drawing *d, lw_draw_kind kind, lw_bytes *out, lw_error *e);

/* Write it, the kind by the end of the file's name. */
lw_status lw_draw_drawing(const lw_drawing *d, const char *path, lw_error *e);

/* Write a plot as SVG, PNG or PDF, by the end of the file's name. */
lw_status lw_draw_plot(const lw_plot *p, const char *path, lw_error *e);

/* Several plots on a page (lw_plot_draw_stack). */
lw_status lw_draw_plots(int n, const lw_plot *p, const char *path, lw_error *e);

#endif

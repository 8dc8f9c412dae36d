/* catalogues/pages/draw.h - from a scene to a file of the kind its name asks for. */
#ifndef LW_CATALOGUES_PAGES_DRAW_H
#define LW_CATALOGUES_PAGES_DRAW_H

#include "base/bytes.h"
#include "catalogues/draw/plot.h"
#include "catalogues/draw/scene.h"

typedef enum lw_draw_kind { LW_DRAW_SVG, LW_DRAW_PDF, LW_DRAW_PNG, LW_DRAW_GIF, LW_DRAW_HTML } lw_draw_kind;

/* By the end of a name, case ignored: "x.svg", or "svg" alone.  LW_E_ARG with the list of kinds. */
lw_status lw_draw_kind_of(const char *path, lw_draw_kind *kind, lw_error *e);

/* width, height [px] 0: the default of the kind. */
lw_status lw_draw_bytes(const lw_scene *s, lw_draw_kind kind, int width, int height, lw_bytes *out,
                        lw_error *e);

/* lw_draw_bytes and lw_file_write; path "-" with a kind chosen by the caller goes to standard output. */
lw_status lw_draw_save(const lw_scene *s, lw_draw_kind kind, const char *path, int width, int height,
                       lw_error *e);

/* A drawing as SVG, PNG or PDF.  LW_E_ARG for the other kinds. */
lw_status lw_draw_still(const lw_drawing *d, lw_draw_kind kind, lw_bytes *out, lw_error *e);

/* A plot as SVG, PNG or PDF by the name of the file. */
lw_status lw_draw_plot(const lw_plot *p, const char *path, lw_error *e);

#endif

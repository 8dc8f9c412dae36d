/* catalogues/draw/diagram.h - the kinematic diagram of a scene, as in textbooks (symbols in the spirit of
 * ISO 3952-1): ground hatched, pins as circles, sliders as blocks on their guides, links of three and
 * more joints as shaded polygons, the input with a turning arrow, tracer, coupler curve, target points
 * with their order, joints and lengths labelled, a scale bar.
 *
 * When the linkage is so much larger than the path that the path would be a speck, a second panel
 * shows the path alone. */
#ifndef LW_CATALOGUES_DRAW_DIAGRAM_H
#define LW_CATALOGUES_DRAW_DIAGRAM_H

#include "catalogues/draw/drawing.h"
#include "catalogues/draw/scene.h"

typedef struct lw_diagram_options {
    double width, height;      /* [px]                                               (1000, 750)  */
    double zoom;               /* factor on the size of signs and letters                  (1)    */
    bool   title;              /* the scene's title above                                  (true) */
    bool   labels;             /* names of joints, numbers of stations                     (true) */
    bool   length_labels;      /* names of lengths beside their links                      (true) */
    bool   length_values;      /* and their values                                         (true) */
    bool   whole_motion;       /* the view holds every posture, for animation              (false) */
    bool   dimensions;         /* the list of dimensions below the title                   (true) */
} lw_diagram_options;

lw_diagram_options lw_diagram_options_default(void);

/* LW_E_ARG: a size outside 64 .. 8192 px or a zoom outside 0.1 .. 10; LW_E_NUMERIC: nothing in the scene is finite. */
lw_status lw_diagram_draw(const lw_scene *s, const lw_diagram_options *o, lw_drawing *d, lw_error *e);

/* How link `link` moves on the page from the posture shown to `frame`, in view v:
 *     q -> to + turn * (q - from)   [px], turn a unit vector of the page (y down). */
typedef struct lw_page_motion { lw_vec2 from, to, turn; } lw_page_motion;
lw_page_motion lw_diagram_motion(const lw_scene *s, const lw_view *v, size_t frame, int link);

#endif

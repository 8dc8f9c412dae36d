/* catalogues/draw/drawing.h - a picture as a list of shapes in pixels; y points down; the first shape is at the
 * bottom. diagram.h (linkages) and plot.h (numbers) make drawings; svg.h, picture.h, gif.h and the pages write them.
 *
 * Shapes name inks instead of colours, so that a page can show the same drawing light and dark. They also name the
 * link they move with, so that an animation is the same drawing with moved links. */
#ifndef LW_CATALOGUES_DRAW_DRAWING_H
#define LW_CATALOGUES_DRAW_DRAWING_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/vec2.h"

/* name, colour on white, colour on black. Colours of series are those of Okabe and Ito 2008, which colour-blind
 * readers can distinguish; they are lighter on black. */
#define LW_INK_LIST(X)                            \
    X(NONE,    0xffffff, 0xffffff, "none")        \
    X(PAPER,   0xffffff, 0x15181c, "paper")       \
    X(TEXT,    0x1b1f24, 0xe8eaed, "text")        \
    X(FAINT,   0x6b7280, 0x9aa3ad, "faint")       \
    X(GRID,    0xdde1e6, 0x31363c, "grid")        \
    X(LINK,    0x3f4a57, 0xb9c2cc, "link")        \
    X(GROUND,  0x1b1f24, 0xe8eaed, "ground")      \
    X(BLUE,    0x0072b2, 0x56b4e9, "blue")        \
    X(RED,     0xd55e00, 0xff8a3d, "red")         \
    X(GREEN,   0x009e73, 0x2bc79a, "green")       \
    X(PURPLE,  0xa8447f, 0xe29cc4, "purple")      \
    X(ORANGE,  0xb87a00, 0xe69f00, "orange")      \
    X(SKY,     0x2a8fc7, 0x8fd0f5, "sky")         \
    X(YELLOW,  0x9a8f00, 0xf0e442, "yellow")
typedef enum lw_ink {
#define X(name, light, dark, text) LW_INK_##name,
    LW_INK_LIST(X)
#undef X
    LW_INK_COUNT
} lw_ink;

unsigned    lw_ink_light(lw_ink i);     /* 0xRRGGBB */
unsigned    lw_ink_dark(lw_ink i);
const char *lw_ink_name(lw_ink i);

/* What a shape stands for; becomes the class of its SVG element. */
#define LW_ROLE_LIST(X)                                                              \
    X(PAPER, "paper") X(FRAME, "frame") X(GRID, "grid") X(TITLE, "title")            \
    X(CURVE, "curve") X(OTHER_CURVE, "other-curve") X(TARGET, "target")              \
    X(STATION, "station") X(STATION_LABEL, "station-label") X(LINK, "link")          \
    X(GROUND, "ground") X(HATCH, "hatch") X(GUIDE, "guide") X(SLIDER, "slider")      \
    X(JOINT, "joint") X(JOINT_LABEL, "joint-label") X(LENGTH_LABEL, "length-label")  \
    X(INPUT, "input") X(TRACER, "tracer") X(SCALE, "scale") X(AXIS, "axis")          \
    X(TICK, "tick") X(SERIES, "series") X(MARKER, "marker") X(LEVEL, "level")        \
    X(LEGEND, "legend") X(INSET, "inset") X(NOTE, "note") X(LEADER, "leader")
typedef enum lw_role {
#define X(name, text) LW_ROLE_##name,
    LW_ROLE_LIST(X)
#undef X
    LW_ROLE_COUNT
} lw_role;

const char *lw_role_name(lw_role r);

typedef enum lw_shape_kind { LW_SHAPE_PATH, LW_SHAPE_CIRCLE, LW_SHAPE_TEXT } lw_shape_kind;

typedef struct lw_shape {
    lw_shape_kind kind;
    lw_role role;
    int     item;              /* which joint, link, station, ... it stands for; -1: none          */
    int     link;              /* the link it moves with; -1: stands still                          */
    int     tie;               /* a path from the point `at` of its link to the point `hold` of this one; -1: none */
    bool    rigid;             /* such a path keeps its length from `at` on, and does not stretch   */
    int     panel;             /* the view (0, 1) it lies in and is clipped to; -1: the whole page  */
    lw_ink  stroke, fill;
    double  width;             /* of the stroke [px]; for text: the size of the type                */
    double  alpha;             /* of the fill, 0 .. 1                                               */
    bool    dashed, closed;
    size_t  first, n;          /* path: points; text: first byte in `text`, n bytes                 */
    lw_vec2 at;                /* circle: centre; text: anchor on the base line; see `tie` [px]     */
    double  radius;            /* circle [px]                                                       */
    double  align;             /* text: 0 begins, 0.5 is centred, 1 ends at `at`                    */
    double  turn;              /* text: [rad], clockwise on the page (y is down)                    */
    bool    bold, italic;
    bool    upright;           /* moves as `hold` does, but does not turn                           */
    lw_vec2 hold;              /* the point of the link that it belongs to [px]                     */
} lw_shape;

/* A view of the plane:  pixel = centre + scale * (x - middle.x, -(y - middle.y)).  What lies in it is
 * clipped to its box. */
typedef struct lw_view {
    lw_vec2 middle;            /* [m]                              */
    double  scale;             /* [px/m]                           */
    lw_vec2 centre;            /* [px]                             */
    double  x, y, w, h;        /* box on the page [px]             */
} lw_view;

lw_vec2 lw_view_pixel(const lw_view *v, lw_vec2 p);

typedef struct lw_drawing {
    double    width, height;           /* [px]                                        */
    char      title[128], about[256];  /* for readers that cannot see it              */
    lw_shape *shape;   size_t n_shape, shape_room;
    lw_vec2  *point;   size_t n_point, point_room;
    char     *text;    size_t n_text,  text_room;
    int       n_view;
    lw_view   view[2];                 /* of panels 0 and 1                           */
    lw_shape  spare;                   /* returned after a failure                    */
    bool      failed;                  /* out of memory: lw_drawing_end reports it    */
} lw_drawing;                          /* { 0 } is empty                              */

void lw_drawing_free(lw_drawing *d);

/* Add shapes. The returned pointer is valid until the next call and never NULL (after a failure it points to
 * d->spare). Fields not named: no stroke, no fill, width 1, alpha 1, link -1, item -1, panel -1; text is filled with
 * LW_INK_TEXT. */
lw_shape *lw_drawing_path(lw_drawing *d, lw_role role, const lw_vec2 *p, size_t n, bool closed);
lw_shape *lw_drawing_line(lw_drawing *d, lw_role role, lw_vec2 a, lw_vec2 b);
lw_shape *lw_drawing_circle(lw_drawing *d, lw_role role, lw_vec2 at, double radius);
lw_shape *lw_drawing_text(lw_drawing *d, lw_role role, const char *text, lw_vec2 at, double size, double align);

lw_status lw_drawing_end(lw_drawing *d, lw_error *e);   /* LW_E_MEMORY, d freed, after a failure    */

/* Width of a line of text [px] by a table of letter widths that common sans-serif fonts stay within,
 * so that the layout does not depend on the fonts of a machine. */
double lw_text_width(const char *text, double size);

#endif

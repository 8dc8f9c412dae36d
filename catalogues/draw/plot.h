/* catalogues/draw/plot.h - series of numbers on linear or logarithmic axes. */
#ifndef LW_CATALOGUES_DRAW_PLOT_H
#define LW_CATALOGUES_DRAW_PLOT_H

#include "catalogues/draw/drawing.h"

#define LW_SERIES_MAX 32
#define LW_LEVEL_MAX   8
#define LW_PANEL_MAX  24

/* LINE joins the points, STEPS holds y until the next x (best so far), POINTS shows markers only. */
typedef enum lw_series_style { LW_SERIES_LINE, LW_SERIES_STEPS, LW_SERIES_POINTS } lw_series_style;

typedef struct lw_series {
    const char   *name;           /* in the legend; "": not there                                      */
    size_t        n;
    const double *x, *y;          /* points that are not finite, or not positive on a log axis, are left out; a line
                                     * has a gap where x is NaN */
    lw_series_style style;
} lw_series;

typedef struct lw_level { const char *name; double y; } lw_level;   /* "published best"             */

typedef struct lw_plot {
    const char *title, *x_label, *y_label;     /* NULL: none; a label with "[deg]": ticks in parts of a turn */
    bool        log_x, log_y;
    double      width, height;                 /* [px]; 0: 800 by 560                               */
    int         n_series, n_level;
    const lw_series *series;
    const lw_level  *level;
    bool          equal;                       /* both axes in one scale: circles stay round         */
    int           columns;                     /* of several plots on a page, said by the first; 0: 1 */
} lw_plot;

/* Write the result with svg.h or picture.h.  LW_E_ARG: too many series, sizes outside 64 .. 8192;
 * LW_NOTHING: there is no point to show (the drawing says so).  Where all y are at most 1e-13, they are drawn as zero, and the
 * drawing says so. */
lw_status lw_plot_draw(const lw_plot *p, lw_drawing *d, lw_error *e);

/* n plots, row by row, in columns of equal width; legends stand at the right end of their row.  The first says the size of the
 * page, height 0: 220 px a row. */
lw_status lw_plot_draw_stack(int n, const lw_plot *p, lw_drawing *d, lw_error *e);

#endif

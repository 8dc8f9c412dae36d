/* catalogues/pages/page.h - one HTML file that shows targets, the linkages found for them and how they move.
 *
 * Everything is inside the file: it opens from a disk without a network, and its content security policy forbids it to
 * load anything.  The script only plays postures that were computed before. */
#ifndef LW_CATALOGUES_PAGES_PAGE_H
#define LW_CATALOGUES_PAGES_PAGE_H

#include "base/bytes.h"
#include "catalogues/draw/drawing.h"
#include "catalogues/draw/scene.h"

/* One linkage found.  Numbers that are NAN and texts that are NULL are left out. */
typedef struct lw_page_result {
    const lw_scene *scene;        /* what is drawn, moved, and whose dimensions are listed          */
    const char *type;             /* "four-bar"                                                     */
    const char *class_name;       /* "GCRR crank-rocker"                                            */
    const char *dimensions;       /* written instead of those of the scene                          */
    const char *note;             /* a sentence below the picture                                   */
    const lw_linkage *linkage;    /* offered as JSON ...                                            */
    const char *file;             /* ... under this name; NULL: not offered                         */
    double transmission_min;      /* least transmission angle, 0 to pi/2 [rad]                      */
    double objective;             /* value of eq. 17; shown where results are not ordered by counts_as */
    double counts_as;             /* what results are ordered by (optimise/report/report.h); 0: they are not */
    double error_mean, error_max; /* [m]                                                            */
    double angle_mean, angle_max; /* errors of the angle of a body or output [rad]                     */
    double stray;                 /* greatest distance of curve and target, both ways [m]           */
    double size;                  /* of the greatest link over that of the target; 0: stray and size are left out   */
    const char *input;            /* "turns", "rocks", "passes a limit"; NULL                       */
    const char *limits;           /* limits that it is at: "r1, transmission", or does not keep; NULL */
    double error_percent;         /* mean error in percent of the path's length                     */
} lw_page_result;

typedef struct lw_page_target {
    const char *name;             /* of the tab                                                     */
    const char *about;            /* a paragraph; NULL: none                                        */
    int n_result;                 /* best first                                                     */
    const lw_page_result *result;
    const lw_drawing *curves;     /* a plot below the linkages; NULL: none                          */
} lw_page_target;

typedef struct lw_page {
    const char *title, *about;    /* about: NULL or a paragraph below the title                     */
    const char *home, *home_title;/* NULL, or where a link below that leads, and its words          */
    int n_target;
    const lw_page_target *target;
} lw_page;

/* Texts may hold anything; they are escaped.  LW_E_ARG for a page without a result. */
lw_status lw_page_write(const lw_page *p, lw_bytes *out, lw_error *e);

#endif

/* catalogues/pages/fit_page.h - the results of a fit in words, as a plot and as a page. */
#ifndef LW_CATALOGUES_PAGES_FIT_PAGE_H
#define LW_CATALOGUES_PAGES_FIT_PAGE_H

#include <stdio.h>

#include "base/bytes.h"
#include "catalogues/draw/drawing.h"
#include "catalogues/draw/scene.h"
#include "optimise/report/results.h"

/* Results for one target; nothing is owned. */
typedef struct lw_fitted {
    const char           *name;     /* of the target; linkages are offered as NAME-1.json, ...       */
    const lw_target      *target;
    lw_task               task;
    const lw_fit         *fit;
    const lw_fit_results *results;
} lw_fitted;

/* Value of dimension d of a result in these units of length: angles in radians. */
double lw_fitted_value(const lw_units *u, const lw_fit_report *r, int d, double si);

/* The dimensions of result i as " r1=12 ...": of a function those that it has, and the angles from which the target counts, in degrees. */
void lw_fitted_dimensions(const lw_fitted *f, int i, FILE *to);

/* What the column 'counts as' means, by which results with default limits are ordered. */
const char *lw_fitted_order(lw_task task);

/* Is the four-bar nearer than this to a change point, in perimeters, and its motion too (lw_fit_report_may_change)?  false without a class. */
#define LW_NEAR_CHANGE_POINT 1e-3
bool lw_fitted_near_change_point(const lw_fit_report *r);

/* Result i beside the stations of the target. */
lw_status lw_fitted_scene(const lw_fitted *f, int i, lw_scene *scene, lw_error *e);

/* Draw what is wanted and what the best results reach: of a function output over input, else paths. */
lw_status lw_fitted_curves(const lw_fitted *f, lw_drawing *d, lw_error *e);

/* One page of n targets; those without a result are left out.  LW_E_ARG: none has one. */
lw_status lw_fitted_page(const lw_fitted *f, int n, const char *title, lw_bytes *out, lw_error *e);

#endif

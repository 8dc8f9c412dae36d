/* optimise/precision/exact_internal.h - what the parts of exact synthesis share. */
#ifndef LW_OPTIMISE_PRECISION_EXACT_INTERNAL_H
#define LW_OPTIMISE_PRECISION_EXACT_INTERNAL_H

#include "optimise/precision/exact.h"

/* ---- guides through poses (exact_burmester.c) ---- */

/* z = (w, kx, ky, gx, gy, u, v): moving pin k/w and fixed pin g/w, both from the first pose's point in units
 * of the poses' size, and u + iv = conj(k) g / w. A pose says that a row times z is 0. */
enum { LW_GUIDE_Z = 7 };

typedef struct lw_guide_rows {
    int      n;                           /* independent rows, orthonormal                        */
    double   row[LW_GUIDE_Z][LW_GUIDE_Z];
    double   raw[LW_GUIDE_Z][LW_GUIDE_Z]; /* as they were given, to polish with                   */
    lw_vec2  origin;                      /* the point of the first pose                          */
    double   turn, unit;                  /* its angle; size of the poses                         */
} lw_guide_rows;

/* Rows of all poses but the first.  The unit is at least `size`. */
void lw_guide_rows_make(const lw_poses *at, double size, lw_guide_rows *r);

/* One further condition row . z = 0; false when it says nothing new. */
bool lw_guide_rows_add(lw_guide_rows *r, const double row[LW_GUIDE_Z]);

/* The guides that meet four independent rows; -1: infinitely many. */
int lw_guide_rows_solve(const lw_guide_rows *r, lw_guide out[4]);

/* Guides through two to four poses by free choices u[LW_GUIDE_DRAW] of [0, 1) within `reach` sizes of the
 * poses: at most four in out. */
enum { LW_GUIDE_DRAW = 5 };
int lw_guide_rows_draw(const lw_guide_rows *r, const double *u, double reach, bool slides, lw_guide out[4]);

/* ---- nine points of a path (exact_nine.c) ---- */

typedef struct lw_ranking lw_ranking;

/* All four-bars through them are offered to r; counts in out. */
lw_status lw_nine_solve(const lw_vec2 p[9], const lw_fit_options *o, lw_ranking *r, lw_exact *out);

/* ---- six to nine points (exact_path.c) ---- */

/* Newton's method for pins x a y b (moving, fixed; from the first point) and the coupler's angles (n, the first 0) at
 * points that are step[n - 1] from the first, of size about one.  false: it did not settle. */
bool lw_path_settle(size_t n, const lw_vec2 *step, lw_vec2 pin[4], double *angle);

/* ---- linkages of two guides, their defects and order (exact_rank.c) ---- */

/* theta of t is the tool angle; for a path it may be NULL.  family: infinitely many are offered, and those that
 * are much alike are listed once. */
lw_status lw_ranking_open(const lw_target *t, const lw_fit_options *o, bool family, lw_ranking **out, lw_error *e);
void      lw_ranking_close(lw_ranking *r);

/* Do the types asked for have slides? */
bool lw_ranking_slides(const lw_ranking *r);

/* The linkages of `from` too; it is empty afterwards. */
void lw_ranking_merge(lw_ranking *r, lw_ranking *from);

/* The linkage of two guides, driven from the better side; angle[] are the tool's at the stations. */
void lw_ranking_offer(lw_ranking *r, const lw_guide *a, const lw_guide *b, const double *angle);

/* The generator of a function. */
void lw_ranking_offer_function(lw_ranking *r, const lw_function_bar *bar);

/* Hand out, best first. */
lw_status lw_ranking_finish(lw_ranking *r, lw_exact *out);

#endif

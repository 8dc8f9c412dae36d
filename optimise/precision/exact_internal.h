/* optimise/precision/exact_internal.h - the parts of exact synthesis. */
#ifndef LW_OPTIMISE_PRECISION_EXACT_INTERNAL_H
#define LW_OPTIMISE_PRECISION_EXACT_INTERNAL_H

#include "optimise/precision/exact.h"

/* ---- guides through poses (exact_burmester.c) ---- */

/* z = (w, kx, ky, gx, gy, u, v): moving pin k/w and fixed pin g/w, both from the first pose's point in units of the
 * poses' size, and u + iv = conj(k) g / w.  Each pose is a condition row . z = 0. */
enum { LW_GUIDE_Z = 7 };

typedef struct lw_guide_rows {
    int      n;                           /* independent rows, orthonormal                        */
    double   row[LW_GUIDE_Z][LW_GUIDE_Z];
    double   raw[LW_GUIDE_Z][LW_GUIDE_Z]; /* as given, to polish solutions with                   */
    lw_vec2  origin;                      /* the point of the first pose                          */
    double   turn, unit;                  /* its angle; size of the poses                         */
} lw_guide_rows;

/* Rows of all poses but the first.  The unit is at least `size`. */
void lw_guide_rows_make(const lw_poses *at, double size, lw_guide_rows *r);

/* Add a condition row . z = 0; false: it depends on the others. */
bool lw_guide_rows_add(lw_guide_rows *r, const double row[LW_GUIDE_Z]);

/* The real guides that meet four independent rows, at most four: the zeros of a quartic, polished to rounding.  A pin farther away
 * than 1e9 sizes of the poses counts as at infinity and makes the guide a PR or RP.  -1: fewer rows are independent, so that
 * infinitely many guides suit. */
int lw_guide_rows_solve(const lw_guide_rows *r, lw_guide out[4]);

/* Guides through two to four poses, at most four in out.  The free dimensions are chosen by the numbers
 * u[LW_GUIDE_DRAW] in [0, 1), within `reach` sizes of the poses. */
enum { LW_GUIDE_DRAW = 5 };
int lw_guide_rows_draw(const lw_guide_rows *r, const double *u, double reach, bool slides, lw_guide out[4]);

/* ---- nine points of a path, or five with both fixed pins (exact_nine.c) ---- */

typedef struct lw_ranking lw_ranking;

/* Offer all four-bars through nine points p to r, or, with pivot[2] not NULL, all through five points whose fixed pins
 * are these; fill the counts of out. */
lw_status lw_nine_solve(const lw_vec2 *p, const lw_vec2 *pivot, const lw_fit_options *o, lw_ranking *r, lw_exact *out);

/* ---- six to nine points (exact_path.c) ---- */

/* Newton's method for pins x a y b (moving, fixed; from the first point) and the coupler's angles (n, the first is 0)
 * at the points step[n - 1] from the first, of size about one.  false: it did not converge. */
bool lw_path_settle(size_t n, const lw_vec2 *step, lw_vec2 pin[4], double *angle);

/* ---- linkages of two guides, their defects and order (exact_rank.c) ---- */

/* theta of t is the tool angle; for a path it may be NULL.  family: infinitely many linkages are offered; similar
 * ones are listed once. */
lw_status lw_ranking_open(const lw_target *t, const lw_fit_options *o, bool family, lw_ranking **out, lw_error *e);
void      lw_ranking_close(lw_ranking *r);

/* Do the requested types have slides? */
bool lw_ranking_slides(const lw_ranking *r);

/* Move the linkages of `from` to r. */
void lw_ranking_merge(lw_ranking *r, lw_ranking *from);

/* Offer the linkage of two guides, driven from the better side; angle[]: of the tool at the stations. */
void lw_ranking_offer(lw_ranking *r, const lw_guide *a, const lw_guide *b, const double *angle);

/* Offer a function generator. */
void lw_ranking_offer_function(lw_ranking *r, const lw_function_bar *bar);

/* A linkage could not be offered for lack of memory: lw_ranking_finish will fail. */
void lw_ranking_lose(lw_ranking *r);

/* Fill `out`, best first.  LW_OK, LW_NOTHING or LW_E_MEMORY. */
lw_status lw_ranking_finish(lw_ranking *r, lw_exact *out);

#endif

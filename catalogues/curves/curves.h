/* catalogues/curves/curves.h - coupler curves drawn at random from the families of four-link chains, or of any topology, and
 * the same curve again from the few numbers kept of it.
 *
 * A sample is a point u of the unit cube (optimise/solvers/lowdiscrepancy.h): which family, its shape, the tracer on
 * the coupler, and for an open curve which piece.  A closed curve is a whole circuit: a full turn of the input,
 * or from limit to limit and, through the limits, back in the other assembly.  An open one is a piece of a
 * circuit in one assembly, a tenth of the way at least.
 *
 * One assembly mode is enough: the other gives the mirror image with the tracer mirrored, and curves are
 * compared with their mirror images (descriptor.h). */
#ifndef LW_CATALOGUES_CURVES_CURVES_H
#define LW_CATALOGUES_CURVES_CURVES_H

#include "catalogues/curves/descriptor.h"
#include "mbs/kinematics/motion.h"
#include "optimise/problem/family.h"

#define LW_CURVE_DRAWS  8             /* numbers in [0, 1) a sample takes                             */
#define LW_CURVE_POINTS 192

/* What is kept of a curve: 36 bytes. */
typedef struct lw_curve_row {
    union {
        float    dim[LW_SHAPE_MAX + 2];   /* four links: the shape dimensions of the family, cx, cy [m, rad] */
        uint32_t key[2];              /* more: of the generator that draws the member                 */
    };
    float   first, last;              /* of the input; of a closed curve the whole range    [rad] or [m] */
    uint8_t family;                   /* of the maker's                                               */
    int8_t  mode;                     /* four links: +1 or -1; 0: a circuit through both.  More: +1 when the
                                       * member was drawn so that its input turns, else -1            */
    uint8_t unused[2];
} lw_curve_row;

/* The plans of the families wanted; const once made, so that threads share it. */
typedef struct lw_curve_maker lw_curve_maker;

/* types: names or letters of mbs/plan/types.h apart by commas, or "all"; NULL: none.  LW_E_ARG names what is no type. */
lw_status lw_curve_maker_create(const char *types, lw_curve_maker **maker, lw_error *e);
/* One family more: linkages of any topology that a plan of dyads works out (pins and sliders, one input, tracer 0).
 * Members are drawn as for a fit (optimise/search/random_linkage.h); their closed curves are those of a full turn of the input.
 * LW_E_KIND: no plan of dyads; LW_E_ARG: too many, too large. */
lw_status lw_curve_maker_add(lw_curve_maker *maker, const char *name, const lw_linkage *k, lw_error *e);

/* The same from what _families said of another maker, also one of another version of the program: row->family
 * counts in this list.  LW_E_NOTATION: a family that is not known here. */
lw_status lw_curve_maker_of(const char *families, lw_curve_maker **maker, lw_error *e);
void      lw_curve_maker_free(lw_curve_maker *maker);

const char      *lw_curve_maker_families(const lw_curve_maker *maker);
/* Its type is NULL for a topology with more than four links. */
const lw_family *lw_curve_family(const lw_curve_maker *maker, const lw_curve_row *row);    /* NULL: none such */

/* Scratch for the calls below, one a thread, 64-byte aligned. */
size_t lw_curve_work_size(const lw_curve_maker *maker);

/* The sample at u (LW_CURVE_DRAWS).  LW_OPEN: it cannot close, or its circuit is cut by sliders without end, or
 * opens on the way: no such curve. */
lw_status lw_curve_draw(const lw_curve_maker *maker, const double *u, bool closed, void *work, lw_curve_row *row);

/* Its points, in order.  p (LW_CURVE_POINTS).  LW_OPEN when the numbers are no linkage. */
lw_status lw_curve_points(const lw_curve_maker *maker, const lw_curve_row *row, bool closed, void *work, lw_vec2 *p);

/* The linkage, in the middle of its range, its tracer named P. */
lw_status lw_curve_linkage(const lw_curve_maker *maker, const lw_curve_row *row, lw_linkage *k);

/* Lay k elsewhere: mirrored in the x axis if so, then turned, stretched and moved, p -> shift + size e^{i turn} p. */
void lw_linkage_lay(lw_linkage *k, bool mirrored, double turn, double size, lw_vec2 shift);

#endif

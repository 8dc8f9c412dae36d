/* catalogues/curves/curves.h - coupler curves of random linkages, of four links or of any topology, and the same curve
 * again from the few numbers that are stored of it.
 *
 * A sample is a point u of the unit cube (optimise/solvers/lowdiscrepancy.h).  It chooses the family, the shape of the
 * linkage, the coupler point and, for an open curve, the piece.  A closed curve is a whole circuit: a full turn of the
 * input, or the range from limit to limit and, through the limits, back in the other assembly mode.  An open curve is a
 * piece of a circuit in one assembly mode, at least a tenth of it.
 *
 * One assembly mode is enough.  The other one draws the mirror image when the coupler point is mirrored too, and curves
 * are compared with their mirror images (descriptor.h). */
#ifndef LW_CATALOGUES_CURVES_CURVES_H
#define LW_CATALOGUES_CURVES_CURVES_H

#include "catalogues/curves/descriptor.h"
#include "mbs/kinematics/motion.h"
#include "optimise/problem/family.h"

#define LW_CURVE_DRAWS  8             /* numbers in [0, 1) a sample takes                             */
#define LW_CURVE_POINTS 192

/* A stored curve: 36 bytes. */
typedef struct lw_curve_row {
    union {
        float    dim[LW_SHAPE_MAX + 2];   /* four links: the shape dimensions of the family, cx, cy [m, rad] */
        struct {
            uint32_t key[2];          /* more links: of the generator that draws the linkage          */
            uint32_t more;            /* 256 times this is added to `family`                          */
        };
    };
    float   first, last;              /* input; of a closed curve the whole range       [rad] or [m]  */
    uint8_t family;                   /* index in the maker                                           */
    int8_t  mode;                     /* four links: assembly mode +1 or -1; 0: a circuit through both.  More
                                       * links: +1 when the linkage was drawn so that its input turns, else -1 */
    uint8_t transmission;         /* 1 + whole half degrees of the least transmission angle; 0: not known */
    uint8_t turns;                /* 2: the input turns fully; 1: it does not; 0: not known            */
} lw_curve_row;

/* The motion of a linkage while its tracer draws a curve. */
typedef struct lw_curve_traits {
    bool   turns;                 /* the input can turn fully                                         */
    double transmission;          /* least transmission angle of all dyads on the curve [rad]         */
} lw_curve_traits;

/* Families that curves are drawn from.  Constant once made, so that threads share it. */
typedef struct lw_curve_maker lw_curve_maker;

/* Scratch of one thread, with the plans of the topologies it has met. */
typedef struct lw_curve_work lw_curve_work;

/* types: names or letters of mbs/plan/types.h separated by commas, or "all"; NULL: none.  LW_E_ARG names an unknown
 * type. */
lw_status lw_curve_maker_create(const char *types, lw_curve_maker **maker, lw_error *e);

/* All mechanisms with so many links (6, 8) and one freedom, of pins ("r") or pins and sliders ("rt"), whose tracer moves in
 * a way that fewer links do not allow, driven by a pin from which dyads solve them.  Eight links with sliders take some
 * seconds; LW_STOPPED with a text: *interrupt became nonzero.  NULL: nothing stops it. */
lw_status lw_curve_maker_links(int links, const char *kinds, int jobs, const volatile int *interrupt, lw_curve_maker **maker, lw_error *e);

/* Add a family: linkages of any topology that a plan of dyads solves (pins and sliders, one pin as input, tracer 0).  They are
 * drawn as for a fit (optimise/search/random_linkage.h); their closed curves belong to a full turn of the input.
 * LW_E_KIND: no plan of dyads; LW_E_ARG: too many links, or more than 256 families some of which have four links. */
lw_status lw_curve_maker_add(lw_curve_maker *maker, const char *name, const lw_linkage *linkage, lw_error *e);

/* The maker that has these families, as lw_curve_maker_families gave them, also in another version of the program:
 * row->family is an index in this list.  LW_E_NOTATION: an unknown family.  Of a longer list only the first 256 are read now, the
 * others when they are needed. */
lw_status lw_curve_maker_of(const char *families, lw_curve_maker **maker, lw_error *e);
void      lw_curve_maker_free(lw_curve_maker *maker);

const char      *lw_curve_maker_families(const lw_curve_maker *maker);
/* Its name and, of four links, its type ("RRRP"), else NULL.  False: no such family. */
bool             lw_curve_family(const lw_curve_maker *maker, const lw_curve_row *row, char name[64], const char **type);

lw_status lw_curve_work_create(const lw_curve_maker *maker, lw_curve_work **work);                     /* LW_E_MEMORY */
void      lw_curve_work_free(lw_curve_work *work);

/* Draw the sample at u (LW_CURVE_DRAWS).  LW_OPEN: there is no such curve; the linkage cannot close, a slider without
 * end interrupts its circuit, or it opens on the way.  This and the next two: LW_E_MEMORY, and LW_E_NOTATION, LW_E_KIND of a
 * family that is no family. */
lw_status lw_curve_draw(const lw_curve_maker *maker, const double *u, bool closed, lw_curve_work *work, lw_curve_row *row);

/* Points of the curve in order: p (LW_CURVE_POINTS), and its traits unless that is NULL.  LW_OPEN when the numbers are not
 * those of a linkage. */
lw_status lw_curve_points(const lw_curve_maker *maker, const lw_curve_row *row, bool closed, lw_curve_work *work, lw_vec2 *p,
                          lw_curve_traits *traits);

/* Write the traits into the row, rounded.  False: the numbers of the row exclude a least transmission angle of `least`
 * [rad], or, if `turns`, an input that turns; true: they do not, or they are not known. */
void lw_curve_row_note(lw_curve_row *row, const lw_curve_traits *traits);
bool lw_curve_row_may(const lw_curve_row *row, bool turns, double least);

/* The linkage, in the middle of its range; its tracer is named P.  If the curve is open, the range of its input is that
 * of the curve. */
lw_status lw_curve_linkage(const lw_curve_maker *maker, const lw_curve_row *row, bool closed, lw_curve_work *work, lw_linkage *linkage);

/* Lay the linkage elsewhere: mirror it in the x axis if `mirrored`, then  p -> shift + size e^{i turn} p. */
void lw_linkage_lay(lw_linkage *linkage, bool mirrored, double turn, double size, lw_vec2 shift);

#endif

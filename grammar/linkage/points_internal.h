/* grammar/linkage/points_internal.h - shared by the formats of Pyslvs and PMKS: a linkage as a list of points, each with
 * the links that meet there.
 *
 *     pin       1 link: a tracer; 2 or more: pinned to each other
 *     slider    the first link carries the line, the second slides on it without turning; more are welded
 *               to the second
 *     slot      the first link carries the slot, the pin in it joins all others */
#ifndef LW_GRAMMAR_LINKAGE_POINTS_INTERNAL_H
#define LW_GRAMMAR_LINKAGE_POINTS_INTERNAL_H

#include <stdio.h>
#include "base/key_table.h"
#include "base/number.h"
#include "grammar/linkage/assembly.h"
#include "grammar/text/text_internal.h"

typedef enum lw_point_type { LW_POINT_PIN, LW_POINT_SLIDER, LW_POINT_SLOT } lw_point_type;

typedef struct lw_point {
    lw_point_type type;
    lw_vec2   at;                      /* [m]                                                       */
    double    angle;                   /* slider, slot: of the line [rad]                           */
    int       n_link, *link;           /* owned by the points                                       */
    bool      driven;
    int       driven_link;             /* which link the input turns; -1: not given                 */
    lw_cursor where;                   /* its place in the text                                     */
} lw_point;

typedef struct lw_points {
    int       n_point, n_link, ground; /* ground -1: not named yet                                  */
    int       most_points, most_links; /* the memory holds so many                                  */
    char    (*name)[LW_NAME_SIZE];
    lw_point *point;
    lw_key_table index;                /* of the links by their names                               */
} lw_points;

/* Without points; ground is -1.  NULL: out of memory. */
lw_points *lw_points_create(void);
void       lw_points_free(lw_points *p);                              /* NULL is fine */

/* Add a point, zeroed except for `where`; it stays at *out until another one is added.  An error: out of memory. */
lw_status lw_points_add(lw_points *p, const lw_cursor *where, lw_point **out);

/* Add the link of this name (n bytes at `where`) to point q; "ground" is the ground. */
lw_status lw_points_join(lw_points *p, lw_point *q, const lw_cursor *where, size_t n);

/* Points to a linkage, to be freed by lw_assembly_free; errors name the place of the point.  Inputs get the value of the
 * posture. */
lw_status lw_points_linkage(const lw_points *p, const lw_units *units, const lw_cursor *end, lw_assembly *linkage);

/* Convert the linkage to points and let `print` write them; returns the text, to be freed with free().  Names are
 * reduced to letters, digits and underscores, stay different if case is ignored, and the ground becomes "ground".
 * NULL with e filled: LW_E_KIND for gears and for welds that are not at a slider, LW_E_MEMORY. */
char *lw_points_text(const lw_assembly *linkage, void (*print)(FILE *f, const lw_points *p, double metre), lw_error *e);

/* The type of a point in both notations, and its numbers as text: lengths in units of `metre`, the angle in degrees. */
extern const char *const lw_point_type_text[3];
typedef struct lw_point_numbers { char x[LW_NUMBER_SIZE], y[LW_NUMBER_SIZE], angle[LW_NUMBER_SIZE]; } lw_point_numbers;
lw_point_numbers lw_point_print(const lw_point *q, double metre);

/* Read a number.  An error at its place if there is none. */
lw_status lw_points_number(lw_cursor *c, const char *what, double *v);

#endif

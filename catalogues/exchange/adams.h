/* catalogues/exchange/adams.h - read datasets of ADAMS/Solver (.adm), statement by statement.  Makkonen's PLASMA
 * passes mechanisms to an analysis program in this form (Makkonen 1999, paper F section 7).
 *
 *     PART/02                                    link 2; PART/01, GROUND is the fixed one
 *     MARKER/0201, PART = 02, QP = x, y, 0       marker 1 of part 2; REULER turns it (3-1-3)
 *     JOINT/01, REVOLUTE, I = 0201, J = 0101     z axis across the plane, or, TRANSLATIONAL, along it
 *     COUPLER/01, JOINTS = 1, 2, TYPE = R:R, SCALES = 2, 1      a gear
 *     MOTION/01, JOINT = 1, ROTATION, FUNCTION = 2*PI*TIME
 *     REQUEST/01, DISPLACEMENT, I = 0203, J = 0101
 *
 * A line that begins with a comma continues the statement before it.  '!' begins a comment.  The comment
 * adams_view_name='...' names the statement after it. */
#ifndef LW_CATALOGUES_EXCHANGE_ADAMS_H
#define LW_CATALOGUES_EXCHANGE_ADAMS_H

#include <stdbool.h>
#include "base/error.h"
#include "grammar/linkage/assembly.h"

#define LW_ADAMS_ARGUMENT_MAX 12
#define LW_ADAMS_VALUE_MAX     6

typedef struct lw_adams_argument {
    char   key[20];                        /* in capitals                                            */
    int    n;                              /* numbers after '='                                      */
    double value[LW_ADAMS_VALUE_MAX];      /* 90D is in degrees and read as radians                  */
    char   text[128];                      /* a word after '=', or the whole of FUNCTION; else ""    */
} lw_adams_argument;

typedef struct lw_adams_statement {
    char keyword[16];                      /* in capitals                                            */
    int  id;                               /* 0: none                                                */
    char name[LW_NAME_SIZE];               /* of the comment before it; else ""                      */
    long line;
    int  n_argument;
    lw_adams_argument argument[LW_ADAMS_ARGUMENT_MAX];
} lw_adams_statement;

/* Visit each statement in order, up to END; the first line is a title and is skipped. A status of visit other than
 * LW_OK ends the scan. LW_E_NOTATION with line and column. */
typedef lw_status lw_adams_visit(void *context, const lw_adams_statement *s, lw_error *e);
lw_status lw_adams_scan(const char *text, size_t size, const char *file, lw_adams_visit *visit, void *context, lw_error *e);

/* The argument of this name; NULL: there is none. */
const lw_adams_argument *lw_adams_find(const lw_adams_statement *s, const char *key);

/* The linkage of a dataset: pins, sliders, welds, INPLANE primitives (slots), couplers of two joints (gears), motions
 * (inputs, with the value of the posture), requests of displacement (tracers).  Other statements are
 * skipped; a mechanism outside the x-y plane is refused.  Free the linkage by lw_assembly_free. */
lw_status lw_adams_read(const char *text, size_t size, const char *file, lw_assembly *linkage, lw_error *e);

#endif

/* optimise/task/target_internal.h - shared by the parts of the target reader. */
#ifndef LW_OPTIMISE_TASK_TARGET_INTERNAL_H
#define LW_OPTIMISE_TASK_TARGET_INTERNAL_H

#include "grammar/linkage/linkage.h"
#include "optimise/task/target.h"

#define LW_ANGLE_MAX 1e6     /* larger angles have lost the digits that matter [rad] */

/* Role of a number in a row, known once the header is read. Each further point has four more roles, in the order x, y,
 * theta, weight. */
typedef enum lw_target_field {
    LW_TARGET_FIELD_X, LW_TARGET_FIELD_Y, LW_TARGET_FIELD_THETA, LW_TARGET_FIELD_ANGLE, LW_TARGET_FIELD_WEIGHT,
    LW_TARGET_FIELD_ALSO, LW_TARGET_FIELD_COUNT = LW_TARGET_FIELD_ALSO + 4*LW_ALSO_MAX
} lw_target_field;

/* The role of a further point's number, from the role of the first point; point from 0. */
static inline lw_target_field lw_field_also(lw_target_field role, int point)
{
    return (lw_target_field)(LW_TARGET_FIELD_ALSO + 4*point + (role == LW_TARGET_FIELD_WEIGHT ? 3 : (int)role));
}

/* The inverse: the corresponding role of the first point. */
static inline lw_target_field lw_field_first(lw_target_field role)
{
    int k = (int)role - LW_TARGET_FIELD_ALSO;
    return k < 0 ? role : k % 4 == 3 ? LW_TARGET_FIELD_WEIGHT : (lw_target_field)(k % 4);
}

/* The largest size of a number [m], [rad], [1]. */
static inline double lw_field_most(lw_target_field role)
{
    role = lw_field_first(role);
    return role == LW_TARGET_FIELD_THETA || role == LW_TARGET_FIELD_ANGLE ? LW_ANGLE_MAX : LW_COORDINATE_MAX;
}

/* ---- lines and fields (target_text.c) ---- */

typedef struct lw_text_span { const char *s; size_t n; } lw_text_span;

typedef struct lw_lines {
    const char *text;
    size_t      size, at;
    long        number;          /* of the line read last, from 1 */
    lw_text_span     line;            /* without its end and without a comment  */
    lw_text_span     comment;         /* after '#', without blanks at the ends; s NULL: none */
} lw_lines;

lw_lines lw_lines_start(const char *text, size_t size);
bool     lw_lines_next(lw_lines *l);
bool     lw_span_blank(lw_text_span s);                /* nothing but blanks and separators */
lw_text_span  lw_span_trim(lw_text_span s);              /* blanks at both ends */
bool     lw_span_is(lw_text_span s, const char *word);   /* capitals do not count */

/* Read the next field of a line from *at on, without blanks and quotes at its ends; separator ' ' means any number of
 * blanks. False: end of the line. */
bool lw_field_next(lw_text_span line, char separator, size_t *at, lw_text_span *field);

/* ---- the header and the comments (target_header.c) ---- */

typedef struct lw_header {
    const char *file;
    char        separator;                    /* 0: not known yet                 */
    char        decimal;                      /* '.' or ',' in the numbers read so far, 0: none */
    long        decimal_line;                 /* where the first one stands       */
    bool        named;                        /* there is a line that names the columns */
    bool        units_below;                  /* and one of units below it */
    int         n_column;
    lw_target_field     role[LW_TARGET_FIELD_COUNT];      /* by column of the file             */
    int         column[LW_TARGET_FIELD_COUNT];    /* by role, -1: missing              */
    char        name[LW_TARGET_FIELD_COUNT][16];  /* as the file calls it, by role     */
    double      factor[LW_TARGET_FIELD_COUNT];    /* to SI, by role                    */
    int         closed;                   /* 1, 0, -1: not given               */
    lw_units    units;
    char        length_by[48], angle_by[48];   /* where the unit was given; "": nowhere */
} lw_header;

/* Fill h (zeroed except for file, closed -1, units SI) from all comments of the file, then from the header line and the line below it, which may
 * hold units. */
lw_status lw_header_comments(lw_header *h, const lw_target_options *o, lw_lines l, lw_error *e);
lw_status lw_header_columns(lw_header *h, lw_text_span line, lw_text_span below, long number, lw_error *e);

/* ---- stations (target.c, target_order.c) ---- */

/* The station and number to which an error message refers. */
typedef struct lw_target_place { size_t station; lw_target_field role; } lw_target_place;

/* Make arrays for n stations with the numbers that `has` names; weight is 1, line 0. */
lw_status lw_target_allocate(lw_target *t, size_t n, const bool has[LW_TARGET_FIELD_COUNT], lw_error *e);
double   *lw_target_array(const lw_target *t, lw_target_field role);       /* NULL: not given */

/* Check weights and order of the angles, then set closed, length, size. closed as in the options. */
lw_status lw_target_finish(lw_target *t, int closed, lw_target_place *place, lw_error *e);

/* Add words to the note of the target, after "; " if it has some. */
__attribute__((format(printf, 2, 3))) void lw_target_add_note(lw_target *t, const char *format, ...);

/* Drop the last station of a closed path without input angles if it is the first one again, and say so in the note. */
void lw_target_drop_repeat(lw_target *t);

/* Check that the angles are in cyclic order, with one point for each angle; undo a wrap at the full turn. */
lw_status lw_target_order(lw_target *t, lw_target_place *place, lw_error *e);

#endif

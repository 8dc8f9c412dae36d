/* grammar/family/master.h - product families: a master file with parameters, formulas, parts and views that expands to
 * ordinary model files (docs/family.md).
 *
 * A master is constant once read; threads share it.  A variant is one choice of its parameters; each thread has its
 * own.
 * The expander makes JSON and knows of models only which keys hold places, directions and angles, and in which units
 * (master_keys.c), so that it serves planar and spatial models alike.
 *
 * Types and the functions that choose a variant: linkwright.h. */
#ifndef LW_GRAMMAR_FAMILY_MASTER_H
#define LW_GRAMMAR_FAMILY_MASTER_H

#include "grammar/functions/formula.h"

typedef struct lw_parameter {
    const char *name, *unit, *doc;       /* unit "": a plain number, a text or a condition; doc "": none */
    lw_amount_kind kind;
    bool        has_range;
    double      least, most;             /* in its unit                                             */
    bool        whole;                   /* takes whole numbers only                                */
} lw_parameter;

/* Read a master file.  LW_E_NOTATION with line and column, also for unknown names, circular parameters and parts that
 * use themselves. */
lw_status lw_master_read(const char *text, size_t size, const char *file, lw_master **out, lw_error *e);
void      lw_master_free(lw_master *m);

/* The i-th of its kind; NULL past the last one.  Lets are the derived values of "let". */
const char *lw_master_title(const lw_master *m);                       /* "" when there is none */
const lw_parameter *lw_master_parameter(const lw_master *m, int i);
const char *lw_master_let(const lw_master *m, int i);
const char *lw_master_check_text(const lw_master *m, int i);
int         lw_master_find_parameter(const lw_master *m, const char *name);       /* -1: none */

void      lw_variant_free(lw_variant *v);
lw_status lw_variant_set_number(lw_variant *v, int parameter, double value);        /* in the unit of the parameter */

/* The value of parameter i.  Checks ranges and choices first.  Its text belongs to the variant and holds until it
 * changes. */
lw_status lw_variant_value(lw_variant *v, int parameter, lw_amount *out, lw_error *e);
/* The number that a formula over parameters and lets gives, in SI or in the unit after `as`; *unit (64 bytes, may be NULL) gets that unit. */
lw_status lw_variant_quantity(lw_variant *v, const char *formula, double *out, char *unit, lw_error *e);

/* A value as text with its unit, as the user wrote the unit: "350 mm". */
void lw_variant_print(const lw_variant *v, int parameter, const lw_amount *a, char *text, size_t size);

/* Does check i hold?  *left, *right: the sides of its comparison, plain truths if it is none. */
lw_status lw_variant_check(lw_variant *v, int i, bool *holds, lw_amount *left, lw_amount *right, lw_error *e);

/* A model file and where it came from.  It needs the master. */
typedef struct lw_expansion { char *text; size_t size; void *map; } lw_expansion;

lw_status lw_variant_expand(lw_variant *v, lw_expansion *out, lw_error *e);
void      lw_expansion_free(lw_expansion *x);

/* Turn an error of a reader of x->text into one of the master file: its name, line and column; the text then tells the
 * part that the place belongs to. */
void      lw_expansion_fault(const lw_expansion *x, lw_error *e);

/* The place in the master of a place in the model; both count from 1.  False: there is none. */
bool      lw_expansion_place(const lw_expansion *x, long line, long column, long *master_line, long *master_column);

#endif

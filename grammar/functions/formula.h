/* grammar/functions/formula.h - formulas with units, for master files: numbers, texts and conditions that are known when a model
 * is made, not functions of time (those are grammar/functions/expression.h).
 *
 *     "2*l_u + 50 mm"     "rho*h^2*7850 [kg/m^3]"     "if(n > 2, 'long', 'short')"     "sqrt(a^2 + b^2) as mm"
 *
 * or; and; not; = == != < <= > >=; + -; * /; ^; numbers with a unit; 'texts'; true, false, pi; the functions of the
 * table in formula.c; words, which the caller knows.  `as UNIT` at the end gives the unit in which the result is
 * written.
 *
 * Units take part in the calculation: a length plus a mass is an error.  Radians are a unit of their own only where
 * nothing else has one, so that radius times angle is a length.  A formula is immutable once parsed. */
#ifndef LW_GRAMMAR_FUNCTIONS_FORMULA_H
#define LW_GRAMMAR_FUNCTIONS_FORMULA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "base/error.h"

enum { LW_DIMENSION_METRE, LW_DIMENSION_KILOGRAM, LW_DIMENSION_SECOND, LW_DIMENSION_AMPERE, LW_DIMENSION_KELVIN,
       LW_DIMENSION_RADIAN, LW_DIMENSION_COUNT };
typedef struct lw_dimension { int8_t of[LW_DIMENSION_COUNT]; } lw_dimension;       /* exponents */

typedef enum lw_amount_kind { LW_AMOUNT_NUMBER, LW_AMOUNT_TEXT, LW_AMOUNT_TRUTH } lw_amount_kind;

/* number*over/under in SI: 350 mm is 350*1/1000, so that it is exactly 350 in mm and the nearest double to 0.35 in
 * m. */
typedef struct lw_amount {
    lw_amount_kind kind;
    lw_dimension   dimension;
    double         number, over, under;      /* of a truth: number 0 or 1 */
    const char    *text;                     /* somebody else's           */
} lw_amount;

lw_amount lw_amount_plain(double number);
lw_amount lw_amount_of_text(const char *text);
double    lw_amount_si(const lw_amount *a);

/* Do the dimensions fit? */
bool      lw_dimension_fits(lw_dimension a, lw_dimension b);
/* "kg m^2/s^2"; "plain number". */
void      lw_dimension_print(lw_dimension d, char *text, size_t size);

/* *out: the number in this unit.  False: the dimensions do not fit, or it is no number. */
bool      lw_amount_in(const lw_amount *a, const lw_amount *unit, double *out);

/* The unit as an amount of 1: "mm", "kg m^2", "N/(rad/s)" is not known, "N s/rad" is.  LW_E_NOTATION with the
 * column. */
lw_status lw_unit_parse(const char *text, size_t size, lw_amount *out, lw_error *e);

typedef struct lw_formula lw_formula;

/* The caller's number (>= 0) of a word.  -1: unknown; `why` (256 bytes) then gets the reason, or stays empty. */
typedef int lw_formula_lookup(void *context, const char *word, char *why);

/* LW_E_NOTATION with the column (from 1, in bytes) of the error; LW_E_MEMORY. */
lw_status lw_formula_parse(const char *text, size_t size, lw_formula_lookup *lookup, void *context, lw_formula **out, lw_error *e);
void      lw_formula_free(lw_formula *f);

/* The unit after `as`; NULL: none. */
const lw_amount *lw_formula_unit(const lw_formula *f);

/* The words of the formula: *which gets the caller's numbers, some more than once. */
int lw_formula_words(const lw_formula *f, const int **which);

/* The value of word number w is value[w & 1][w >> 1]: words of two tables.  LW_E_NOTATION with the column: units that
 * do not fit, a number that is not finite. */
lw_status lw_formula_value(const lw_formula *f, const lw_amount *const value[2], lw_amount *out, lw_error *e);

/* The same; *left and *right get the sides of the comparison that the formula is, if it is one. */
lw_status lw_formula_compare(const lw_formula *f, const lw_amount *const value[2], lw_amount *out, lw_amount *left,
                             lw_amount *right, lw_error *e);

#endif

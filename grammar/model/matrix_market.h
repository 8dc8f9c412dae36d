/* grammar/model/matrix_market.h - square matrices from files of the Matrix Market (Boisvert, Pozo & Remington 1996): coordinate or
 * array, real or integer, general or symmetric. */
#ifndef LW_GRAMMAR_MODEL_MATRIX_MARKET_H
#define LW_GRAMMAR_MODEL_MATRIX_MARKET_H

#include <stddef.h>
#include "base/error.h"

#define LW_MATRIX_MOST 600               /* rows and columns */

/* *out (n*n, out[i*n + j]) is to be freed.  LW_E_NOTATION with line and column. */
lw_status lw_matrix_market_read(const char *text, size_t size, const char *file, int *n, double **out, lw_error *e);

#endif

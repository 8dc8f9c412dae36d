/* base/gsl_errors.h - calls of GSL that cannot abort the program.
 *
 * GSL calls one error handler for the whole process, which aborts unless the program replaced it.  Between these
 * two calls GSL returns its error codes instead.  Calls may be nested and may overlap in several threads; when the
 * last has ended, the program's handler is back.  Every call of GSL that can fail, and every one that allocates,
 * stands between them. */
#ifndef LW_BASE_GSL_ERRORS_H
#define LW_BASE_GSL_ERRORS_H

void lw_gsl_begin(void);
void lw_gsl_end(void);

#endif

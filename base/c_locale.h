/* base/c_locale.h - do one thing under the "C" locale, in this thread only, whatever the program set.
 *
 *     lw_c_locale old = lw_c_locale_enter();
 *     ... strtod, or a library that calls it ...
 *     lw_c_locale_leave(old);
 */
#ifndef LW_BASE_C_LOCALE_H
#define LW_BASE_C_LOCALE_H

#include <locale.h>

typedef struct lw_c_locale { locale_t here, before; } lw_c_locale;

lw_c_locale lw_c_locale_enter(void);
void        lw_c_locale_leave(lw_c_locale old);

#endif

/* base/c_locale.h - run a piece of code under the "C" locale, in this thread only, whatever locale the program uses.
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

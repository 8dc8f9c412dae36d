#include "base/c_locale.h"

/* glibc hands out one static object for "C": nothing is allocated, nothing fails there.  Elsewhere a
 * failure leaves the locale as it is. */
lw_c_locale lw_c_locale_enter(void)
{
    lw_c_locale l = { newlocale(LC_ALL_MASK, "C", (locale_t)0), (locale_t)0 };
    if (l.here != (locale_t)0)
        l.before = uselocale(l.here);
    return l;
}

void lw_c_locale_leave(lw_c_locale l)
{
    if (l.here == (locale_t)0)
        return;
    uselocale(l.before);
    freelocale(l.here);
}

/* base/units.h - unit names and their SI factors.  The library computes in SI; the factors are exact by definition. */
#ifndef LW_BASE_UNITS_H
#define LW_BASE_UNITS_H

#include <stdbool.h>

typedef struct lw_units {
    char   length[8];   /* "m", "mm", "cm", "km", "um", "in", "ft"; "" if not specified  */
    char   angle[8];    /* "rad", "deg", "turn"                                         */
    double metre;       /* one length unit [m]; 1 if not specified                      */
    double radian;      /* one angle unit [rad]                                         */
} lw_units;

lw_units lw_units_si(void);
bool     lw_units_set_length(lw_units *u, const char *name);   /* false: unknown name, u unchanged */
bool     lw_units_set_angle(lw_units *u, const char *name);

/* "mm/s" (order 1) or "mm/s^2" (order 2) for the length unit of u, "m/s", ... if it has none. */
const char *lw_units_rate(const lw_units *u, int order);

#endif

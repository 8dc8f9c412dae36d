/* base/units.h - SI inside, other units at the boundary.  Factors are exact by definition. */
#ifndef LW_BASE_UNITS_H
#define LW_BASE_UNITS_H

#include <stdbool.h>

typedef struct lw_units {
    char   length[8];   /* "m", "mm", "cm", "km", "um", "in", "ft"; "" when nobody said */
    char   angle[8];    /* "rad", "deg", "turn"                                         */
    double metre;       /* one length unit [m]; 1 when nobody said                      */
    double radian;      /* one angle unit [rad]                                         */
} lw_units;

lw_units lw_units_si(void);
bool     lw_units_set_length(lw_units *u, const char *name);   /* false: name unknown, u untouched */
bool     lw_units_set_angle(lw_units *u, const char *name);

#endif

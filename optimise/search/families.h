/* optimise/search/families.h - families of any linkage by the thousand.  Each is made in the memory of whoever works
 * on it and kept no longer. */
#ifndef LW_OPTIMISE_SEARCH_FAMILIES_H
#define LW_OPTIMISE_SEARCH_FAMILIES_H

#include "optimise/problem/family.h"

/* One family with all that it points to. */
typedef struct lw_family_made {
    lw_family  family;           /* its name and linkage are those below                            */
    lw_linkage linkage;
    char       name[96];
} lw_family_made;

/* In which order families are searched when there is no time for all: lower ones first. */
typedef enum lw_turn {
    LW_TURN_START,               /* its linkage is a start                                          */
    LW_TURN_DYADS,               /* a linkage of dyads                                              */
    LW_TURN_GROUPS               /* a linkage with higher groups: costs LW_HIGHER_COST times as much */
} lw_turn;

typedef struct lw_families {
    int         n;
    /* Make family i, 0 <= i < n, the same whenever it is made; called by several threads at once. */
    lw_status (*make)(const void *of, int i, lw_family_made *made);
    lw_turn   (*turn)(const void *of, int i);
    const void *of;
} lw_families;

/* The families of an array, which must stay, as must everything that they point to. */
lw_families lw_families_of(const lw_family *family, int n);

/* The second families after the first; `pair` must stay. */
typedef struct lw_families_pair { lw_families first, second; } lw_families_pair;
lw_families lw_families_join(const lw_families_pair *pair);

#endif

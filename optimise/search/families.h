/* optimise/search/families.h - families of any linkage by the thousand: each is made when somebody works on it, in his memory,
 * and is held no longer. */
#ifndef LW_OPTIMISE_SEARCH_FAMILIES_H
#define LW_OPTIMISE_SEARCH_FAMILIES_H

#include "optimise/problem/family.h"

/* One family with all that it points to. */
typedef struct lw_family_made {
    lw_family  family;           /* name and linkage are those below                                */
    lw_linkage linkage;
    char       name[96];
} lw_family_made;

/* When the turn of a family comes where not all can be looked at: lower ones first. */
typedef enum lw_turn {
    LW_TURN_START,               /* its linkage is a start                                          */
    LW_TURN_DYADS,               /* worked out by dyads alone                                       */
    LW_TURN_GROUPS               /* by groups beyond dyads too: LW_HIGHER_COST times as dear        */
} lw_turn;

typedef struct lw_families {
    int         n;
    /* Family i, 0 <= i < n, the same whenever it is asked for; several threads ask at once. */
    lw_status (*make)(const void *of, int i, lw_family_made *made);
    lw_turn   (*turn)(const void *of, int i);
    const void *of;
} lw_families;

/* Those of an array, which must stay, as must everything that they point to. */
lw_families lw_families_of(const lw_family *family, int n);

/* The second behind the first; `pair` must stay. */
typedef struct lw_families_pair { lw_families first, second; } lw_families_pair;
lw_families lw_families_join(const lw_families_pair *pair);

/* A copy of f that points to nothing outside. */
void lw_family_copy(const lw_family *f, lw_family_made *made);

#endif

/* enumerate/derive.h - the mechanisms that rules 1 to 4 of the published grammar (Makkonen 1999, paper F) reach.
 *
 * Forwards: apply the rules to everything with up to n_link links, and remove duplicates by canonical form after
 * every rule.  Backwards: take all chains and test which can be reduced to a seed (grammar/topology/growth.h).  Both give
 * the same numbers: with rules 2 and 4 and k = r, 2 of 2, 12 of 16, 140 of 230 and 3110 of 6856 chains of 6, 8, 10 and
 * 12 links; 2, 12, 136 and 2781 when the words must be regions of a drawing. */
#ifndef LW_ENUMERATE_DERIVE_H
#define LW_ENUMERATE_DERIVE_H

#include "enumerate/chains.h"
#include "enumerate/kinds.h"

typedef struct lw_derive {
    int         n_link;
    bool        rule[5];      /* which of rules 1 .. 4 may be used                                */
    const char *kinds;        /* kinds allowed for k: "r", "t" or "rt"                            */
    bool        regions;      /* X and Y must lie at one region: only planar graphs               */
    double      max_bytes;    /* memory that may be used [byte]; 0: no limit                      */
    const volatile int *stop; /* the work ends with LW_STOPPED when it becomes nonzero; NULL      */
} lw_derive;

/* All four rules, k = r, regions as the source requires. */
lw_derive lw_derive_default(int n_link);

/* Visit every mechanism reached with exactly n_link links once, in canonical form, in the order of its
 * bytes (kinds and links).  Needs memory for all mechanisms with n_link links and fewer: 220 bytes each, and as
 * much again while they are sorted.  LW_E_MEMORY as soon as the numbers found with fewer links show that max_bytes do
 * not suffice; LW_E_ARG; LW_STOPPED before the first visit. */
lw_status lw_derive_each(const lw_derive *how, lw_mechanism_visit *visit, void *context);

/* The number of chains of pins with n_link links and F = 1, and how many of them the rules reach: with X and Y
 * anywhere, and with X and Y at one region. */
typedef struct lw_coverage { uint64_t n_chain, n_planar, n_reached, n_reached_by_regions; } lw_coverage;

/* LW_E_ARG with the equation when n_link and F = 1 do not go together; LW_E_MEMORY. */
lw_status lw_coverage_count(int n_link, int n_thread, const volatile int *stop, lw_coverage *coverage, lw_error *e);

#endif

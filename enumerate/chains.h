/* enumerate/chains.h - all chains with P links and F freedoms, joints of one freedom, not fractionated
 * (for those see fractionated.h).
 *
 *     lw_chains *all;
 *     lw_chains_create(10, 1, 0, &all, &error);
 *     lw_chain_walk how = lw_chain_walk_default();
 *     lw_chains_each(all, &how, print_chain, NULL);          230 calls
 *     lw_chains_free(all);
 *
 * Order: structures as in structures.h, and the weightings of each as in weighting.h.  Links are numbered as by
 * lw_structure_chain.  Part r of m contains the structures r, r + m, r + 2m, ...; parts are disjoint, keep the
 * order, and together give all chains.  With L = 1 there is one chain, a ring of F + 3 links, in part 0.  F = 0
 * gives the Baranov trusses. */
#ifndef LW_ENUMERATE_CHAINS_H
#define LW_ENUMERATE_CHAINS_H

#include "enumerate/filter.h"
#include "enumerate/ordered.h"
#include "enumerate/structures.h"
#include "enumerate/synthesis.h"
#include "enumerate/weighting.h"

/* The structures of the chains with P links and F freedoms.  Read-only once made. */
typedef struct lw_chains lw_chains;

/* n_thread < 1: one per core.  LW_E_ARG with the equation when no chain has P links and F freedoms; LW_E_MEMORY. */
lw_status lw_chains_create(int n_link, int dof, int n_thread, lw_chains **chains, lw_error *e);
/* The same; tick can stop it with LW_STOPPED, as for lw_structures_create_while.  The structures are read from the
 * file `stored`, or written there, as by lw_structures_stored; NULL: no file. */
lw_status lw_chains_create_while(int n_link, int dof, int n_thread, const char *stored, lw_structures_tick *tick,
                                 void *context, lw_chains **chains, lw_error *e);
/* The same, but only chains with at most `most_circles` links of three or more joints. */
lw_status lw_chains_create_within(int n_link, int dof, int most_circles, int n_thread, lw_structures_tick *tick,
                                  void *context, lw_chains **chains, lw_error *e);
void      lw_chains_free(lw_chains *chains);

const lw_numbers    *lw_chains_numbers(const lw_chains *chains);
const lw_structures *lw_chains_structures(const lw_chains *chains);       /* NULL for L = 1 */

/* One chain and where it comes from; valid during the call. */
typedef struct lw_chain_item {
    const lw_chain     *chain;
    const lw_structure *structure;        /* NULL for a ring                                            */
    size_t              index;            /* of the structure                                           */
    const uint8_t      *weight;           /* binary links on each line                                  */
    const lw_weighting *weighting;        /* for lw_chain_item_orbits                                   */
} lw_chain_item;

/* Links equivalent by symmetry, as from lw_weighting_orbits. */
int lw_chain_item_orbits(const lw_chain_item *item, uint8_t *lowest);

/* How to walk. */
typedef struct lw_chain_walk {
    int              part, n_part;        /* 0 <= part < n_part                                         */
    const lw_filter *filter;              /* NULL: all chains                                           */
    uint64_t         skip;                /* number of chains to leave out at the beginning of the walk */
    int              n_thread;            /* < 1: one per core                                          */
    /* Called from time to time with the fraction done, 0 .. 1; false ends the walk with LW_STOPPED.  One
     * call at a time, from any thread.  NULL: none. */
    bool           (*tick)(void *context, double done);
    void            *tick_context;
} lw_chain_walk;

/* All chains, all cores, no tick. */
lw_chain_walk lw_chain_walk_default(void);

/* Visit the chains in order, from the calling thread.  A status of visit other than LW_OK ends the walk and is
 * returned. */
typedef lw_status lw_chain_visit(void *context, const lw_chain_item *item);
lw_status lw_chains_each(const lw_chains *chains, const lw_chain_walk *how, lw_chain_visit *visit, void *context);

/* Print each chain: `print` writes at most `most` bytes to text, and how many to *length.  It is called from several
 * threads at once; `sink` gets the texts in order (ordered.h).  A status of print other than LW_OK ends the walk and is returned. */
typedef lw_status lw_chain_print(void *context, const lw_chain_item *item, char *text, size_t most, size_t *length);
lw_status lw_chains_print(const lw_chains *chains, const lw_chain_walk *how, size_t most, lw_chain_print *print,
                          lw_text_sink *sink, void *context);

/* Numbers of chains, in all and for each assortment (in the order of synthesis.h). */
typedef struct lw_chain_row { lw_assortment links; lw_tally n; } lw_chain_row;
typedef struct lw_chain_table {
    lw_tally      total;
    size_t        n_row;
    lw_chain_row *row;                    /* (n_row) owned, see _free                                   */
} lw_chain_table;

/* A row for each assortment, all numbers 0.  LW_E_MEMORY. */
lw_status lw_chain_table_make(const lw_numbers *numbers, lw_chain_table *table);

/* Count without listing, unless the filter asks for single chains.  how->skip is not used.  With the filter "generating"
 * there are no ground links, and a part of several has n_labelled only (labelled.h); LW_E_ARG for F = 0. */
lw_status lw_chains_count(const lw_chains *chains, const lw_chain_walk *how, lw_chain_table *table);
void      lw_chain_table_free(lw_chain_table *table);

#endif

/* enumerate/kept.h - a long count in parts that are kept in a file, so that no interruption loses more than the parts
 * at work.
 *
 * Part r of m holds the structures r, r + m, r + 2m, ... (chains.h).  The file is text:
 *
 *     # a remark
 *     count links 20 dof 1 filter none structures 6803203 digest 5e2f... parts 1661
 *     part 17 structures 4096 chains 82345678 ground-links 1623456789 by-assortment 0:0 12:230 ... check 08d3...
 *
 * One line for each part: the numbers of structures, chains and ground links (inversions), and chains:ground-links for
 * each assortment in the order of synthesis.h; with the filter "generating" 0:0:n_labelled (weighting.h).
 * `check` is the FNV-1a hash of the line before it, `digest` that of the structures (structures.h).  Lines may come in any order.  Files of the same
 * count can be joined by `cat`: the line `count` may come again if it is the same, a part must not.  So the sum of a complete file is proved
 * complete: each part of 1 .. m is there once, and its structures add up to all of them. */
#ifndef LW_ENUMERATE_KEPT_H
#define LW_ENUMERATE_KEPT_H

#include "enumerate/chains.h"

typedef struct lw_kept lw_kept;

/* The count that a file keeps, and its number of parts. */
typedef struct lw_kept_head {
    int      n_link, dof;
    char     filter[24];                  /* "none" or the name of a filter  */
    uint64_t n_structure, digest;
    int      n_part;
} lw_kept_head;

/* Open the file, or make an empty one.  An incomplete last line is removed.  LW_E_NOTATION with the line if it is
 * damaged, holds a part twice, or counts anything but n_link, dof and filter (NULL: none); LW_E_IO, also while another
 * program has it open; LW_E_MEMORY. */
lw_status lw_kept_open(const char *path, int n_link, int dof, const lw_filter *filter, lw_kept **kept, lw_error *e);
void      lw_kept_close(lw_kept *k);

/* NULL while the file is empty. */
const lw_kept_head *lw_kept_head_of(const lw_kept *k);

/* Is part p (from 0) there?  The number of parts there of those with p mod m = r. */
bool lw_kept_has(const lw_kept *k, int p);
int  lw_kept_count(const lw_kept *k, int r, int m);

/* The number of parts that lw_kept_begin chooses. */
int lw_kept_parts(const lw_chains *chains);

/* Begin an empty file, or check that it belongs to these structures.  LW_E_NOTATION, LW_E_IO. */
lw_status lw_kept_begin(lw_kept *k, const lw_chains *chains, lw_error *e);

/* Add the table of part p; it is on disk when this returns.  Not for several threads at once.  LW_E_IO. */
lw_status lw_kept_add(lw_kept *k, int p, const lw_chain_table *table, lw_error *e);

/* Count the missing parts p with p mod how->n_part = how->part, and add each when it is done.  how->filter must be
 * that of the file.  LW_STOPPED, LW_E_IO, LW_E_MEMORY. */
lw_status lw_kept_run(lw_kept *k, const lw_chains *chains, const lw_chain_walk *how, lw_error *e);

/* The sum of the parts that are there of those with p mod m = r. */
lw_status lw_kept_sum(const lw_kept *k, int r, int m, lw_chain_table *table);

#endif

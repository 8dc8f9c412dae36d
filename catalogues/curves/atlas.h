/* catalogues/curves/atlas.h - an atlas of coupler curves, segment by segment in memory.
 *
 * A segment holds the curves of consecutive samples (curves.h) of one random sequence.  Its curves are sorted into
 * blocks of similar curves: the set is halved again and again at the median of the coefficient size |c_k| that varies
 * most (k-d tree, Bentley 1975).  Each block keeps the least and the greatest sizes of its curves.  They give a lower
 * bound for the distance of all its curves from any target (descriptor.h), so that a search can skip whole blocks. */
#ifndef LW_CATALOGUES_CURVES_ATLAS_H
#define LW_CATALOGUES_CURVES_ATLAS_H

#include "catalogues/curves/curves.h"

#define LW_BLOCK_MAX    256               /* curves in a block                                       */
#define LW_SEGMENT_MAX  65536             /* samples in a segment                                    */

/* Least and greatest |c_k| of the n curves of a block, as packed numbers. */
typedef struct lw_curve_box { uint16_t least[LW_TERMS], most[LW_TERMS]; uint32_t n; } lw_curve_box;

/* The closed or the open curves of a segment, block by block. */
typedef struct lw_atlas_tree {
    bool          closed;
    size_t        n, n_block;
    lw_packed    *terms;                  /* (n) owned                                               */
    lw_curve_row *row;                    /* (n) owned                                               */
    lw_curve_box *box;                    /* (n_block) owned                                         */
} lw_atlas_tree;

/* Which curves are drawn: closed and open ones in turn, or one kind only. */
typedef enum lw_atlas_kinds { LW_ATLAS_BOTH, LW_ATLAS_CLOSED, LW_ATLAS_OPEN } lw_atlas_kinds;

/* Draw segment `number` of the sequence of `seed`, with n samples (at most LW_SEGMENT_MAX).  tree[0] gets the closed
 * curves, tree[1] the open ones; either may be empty.  The same seed and number give the same trees for any number of
 * threads.  LW_STOPPED: *stop became nonzero (NULL: nothing stops it); LW_E_MEMORY. */
lw_status lw_atlas_segment(const lw_curve_maker *maker, uint64_t seed, size_t number, size_t n, lw_atlas_kinds kinds,
                           int n_thread, const volatile int *stop, lw_atlas_tree tree[2]);
void      lw_atlas_tree_free(lw_atlas_tree *t);

#endif

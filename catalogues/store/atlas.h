/* catalogues/store/atlas.h - an atlas of coupler curves, and the curves in it that are nearest to a target.
 *
 * Curves come in segments: so many samples (curves.h) of one sequence, sorted into blocks of curves alike by
 * halving at the median of the size |c_k| that varies most (k-d tree, Bentley 1975).  Of each block the
 * least and greatest sizes are kept, which bound the distance of all its curves from any target from
 * below (descriptor.h).  A search takes blocks in the order of that bound until it exceeds the worst of the
 * curves wanted: the answer is exact, as if every curve had been compared. */
#ifndef LW_CATALOGUES_STORE_ATLAS_H
#define LW_CATALOGUES_STORE_ATLAS_H

#include "catalogues/curves/curves.h"
#include "catalogues/store/store.h"

#define LW_BLOCK_MAX    256               /* curves in a block                                       */
#define LW_SEGMENT_MAX  65536             /* samples in a segment                                    */

/* Box of the |c_k| of a block, as packed numbers. */
typedef struct lw_curve_box { uint16_t least[LW_TERMS], most[LW_TERMS]; uint32_t n; } lw_curve_box;

/* The closed or the open curves of a segment, block by block. */
typedef struct lw_atlas_tree {
    bool          closed;
    size_t        n, n_block;
    lw_packed    *terms;                  /* (n) owned                                               */
    lw_curve_row *row;                    /* (n) owned                                               */
    lw_curve_box       *box;                    /* (n_block) owned                                         */
} lw_atlas_tree;

/* Which curves: both kinds (samples in turn), or one. */
typedef enum lw_atlas_kinds { LW_ATLAS_BOTH, LW_ATLAS_CLOSED, LW_ATLAS_OPEN } lw_atlas_kinds;

/* Segment number `number` of the sequence of `seed`, of n samples (at most LW_SEGMENT_MAX): tree[0] of closed and
 * tree[1] of open curves, either perhaps empty.  Same seed and number, same trees, for any number of threads.
 * LW_E_MEMORY. */
lw_status lw_atlas_segment(const lw_curve_maker *maker, uint64_t seed, size_t number, size_t n, lw_atlas_kinds kinds,
                           int n_thread, lw_atlas_tree tree[2]);
void      lw_atlas_tree_free(lw_atlas_tree *t);

/* A sequence in a catalogue: samples drawn so far, and segments.  Inside a transaction. */
typedef struct lw_atlas_sweep {
    const char    *families;               /* of lw_curve_maker_families                              */
    lw_atlas_kinds kinds;
    uint64_t       seed, samples, segments;
} lw_atlas_sweep;
lw_status lw_store_sweep_begin(lw_store *s, lw_atlas_sweep *sweep, lw_error *e);      /* fills samples, segments */
lw_status lw_store_put_segment(lw_store *s, const lw_atlas_tree tree[2], size_t n_sample, lw_error *e);

/* ---- nearest ------------------------------------------------------------------------------------- */

typedef struct lw_atlas_hit {
    double     distance;              /* root mean square distance of the points, run through at even speed,
                                       * over the size of the target (its root mean square distance from its
                                       * centre) [1]                                                  */
    double     distance_m;            /* the same [m]                                                 */
    lw_linkage linkage;               /* laid on the target; tracer 0 runs through the curve          */
    char       family[32];            /* "crank-rocker"; "" for a linkage that was added              */
    char       type[8];               /* "RRRR"                                                       */
    long long  id;                    /* of a linkage that was added; 0: of the generated ones        */
    bool       closed;
} lw_atlas_hit;

typedef struct lw_atlas_search {
    uint64_t n_curve, n_block, n_read, n_compared;      /* there are; looked into                     */
} lw_atlas_search;

/* The k nearest (hit (k), nearest first, *n_hit of them).  The target is a polygon p (n) [m]; few points are made
 * a smooth curve first.  LW_NOTHING: the catalogue has no curves of this kind.  LW_E_ARG: no curve; LW_E_NOTATION:
 * damaged; LW_E_MEMORY.  search may be NULL. */
lw_status lw_store_nearest(lw_store *s, const lw_vec2 *p, size_t n, bool closed, int k, lw_atlas_hit *hit, int *n_hit,
                           lw_atlas_search *search, lw_error *e);

#endif

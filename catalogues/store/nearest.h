/* catalogues/store/nearest.h - the coupler curves of a catalogue, and those of them that are nearest to a target.
 *
 * A search reads the blocks (curves/atlas.h) in the order of their lower bounds, until the bound exceeds the distance
 * of the worst curve kept so far.  The answer is exact: the same as if every curve had been compared. */
#ifndef LW_CATALOGUES_STORE_NEAREST_H
#define LW_CATALOGUES_STORE_NEAREST_H

#include "catalogues/curves/atlas.h"
#include "catalogues/store/store.h"

/* A sequence of samples in a catalogue: how many are drawn so far, in how many segments.  A catalogue may hold a part of
 * the sequence, which begins after `first` segments. */
typedef struct lw_atlas_sweep {
    const char    *families;               /* of lw_curve_maker_families                              */
    lw_atlas_kinds kinds;
    uint64_t       seed, first, samples, segments;
} lw_atlas_sweep;

/* Find the sequence with these families, kinds and seed, or start it; fills samples and segments.  Add a segment to
 * it.  Both inside a transaction.  LW_E_ARG: the catalogue holds another part of the sequence. */
lw_status lw_store_sweep_begin(lw_store *s, lw_atlas_sweep *sweep, lw_error *e);
lw_status lw_store_put_segment(lw_store *s, const lw_atlas_tree tree[2], size_t n_sample, lw_error *e);

/* Add the curves of another catalogue with the path `part`: one sequence, which must go on where that in s ends.  The
 * rows are those that one catalogue for all parts has.  All is added or nothing; not inside a transaction.  *n_curve:
 * curves added.  LW_E_ARG: parts before it are missing, or it is not complete; LW_NOTHING: s holds it already. */
lw_status lw_store_add_curves(lw_store *s, const char *part, const lw_store_run *run, uint64_t *n_curve, lw_error *e);

typedef struct lw_atlas_hit {
    double     distance;              /* root mean square distance of the points, both curves traversed at even
                                       * speed, divided by the size of the target (root mean square distance of its
                                       * points from their centre) [1]                                */
    double     distance_m;            /* the same [m]                                                 */
    lw_linkage linkage;               /* laid on the target; tracer 0 draws the curve                 */
    char       family[32];            /* "crank-rocker"; "" for a linkage that was added              */
    char       type[8];               /* "RRRR"                                                       */
    long long  id;                    /* of a linkage that was added; 0: of a generated one           */
    int        turns;                 /* the input turns fully: 1, 0, -1 not known                     */
    double     transmission;          /* least transmission angle on the curve [rad]; NaN: not known   */
} lw_atlas_hit;

/* Which linkages are wanted; all zeros: any.  A linkage that was added passes the first two only if its row in the
 * catalogue says so. */
typedef struct lw_atlas_filter {
    bool   turns;                     /* the input turns fully                                        */
    double min_transmission;          /* least transmission angle on the curve, at least this [rad]   */
    double min_length, max_length;    /* of the linkage laid on the target: limits of the lengths between pins of a
                                       * link [m]; the tracer is at most max_length from them; 0, 0: any */
    const volatile int *stop;         /* *stop not 0 ends the search with LW_STOPPED and a few of the nearest curves of
                                       * those that were compared; NULL: nothing stops it             */
} lw_atlas_filter;

/* How much a search did: curves and blocks in the catalogue, blocks read, curves compared. */
typedef struct lw_atlas_search {
    uint64_t n_curve, n_block, n_read, n_compared;
} lw_atlas_search;

/* Find the `count` curves nearest to the polygon p (n) [m], among the linkages that filter (NULL: all) admits.  hit
 * (count) gets *n_hit of them, nearest first.  A target of few points is made a smooth curve first.  LW_NOTHING: the
 * catalogue has no such curves.  LW_E_ARG: the target is no curve; LW_E_NOTATION: the file is damaged; LW_E_MEMORY.
 * search may be NULL. */
lw_status lw_store_nearest(lw_store *s, const lw_vec2 *p, size_t n, bool closed, const lw_atlas_filter *filter,
                           int count, lw_atlas_hit *hit, int *n_hit, lw_atlas_search *search, lw_error *e);

#endif

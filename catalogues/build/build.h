/* catalogues/build/build.h - fill a catalogue with chains, linkages and coupler curves, and check it.
 *
 *     lw_store *store;
 *     lw_chains *chains;
 *     lw_build_control control = { .jobs = 4 };
 *     lw_build_counts counts;
 *     lw_chains_create(8, 1, 4, &chains, &error);
 *     lw_store_open("atlas.db", &(lw_store_options){ .write = true, .create = true }, &store, &error);
 *     lw_build_topologies what = { .kinds = "r", .pictures = true };
 *     lw_build_chains(store, chains, &what, &control, &counts, &error);
 *
 * Work is committed from time to time.  A call that was stopped, or a program that was killed, is continued by the same
 * call; nothing is lost or stored twice. */
#ifndef LW_CATALOGUES_BUILD_BUILD_H
#define LW_CATALOGUES_BUILD_BUILD_H

#include "catalogues/store/nearest.h"
#include "enumerate/chains.h"
#include "enumerate/published.h"

/* How the work is done.  { 0 } is allowed. */
typedef struct lw_build_control {
    int         jobs;         /* threads; < 1: one for each core                                     */
    double      commit;       /* seconds between two commits                                         */
    uint64_t    seed;         /* stored with the run; of the samples of curves                       */
    int         part, n_part; /* of the curves: part 0 .. n_part - 1; n_part 0: all                  */
    size_t      segment;      /* samples of curves in a segment, at most and without it LW_SEGMENT_MAX */
    const char *command;      /* stored with the run: how the program was called; NULL: nothing      */
    /* Called now and then with the work done and the whole work (0: unknown).  false stops the work with LW_STOPPED;
     * what is done by then is committed.  NULL: never asked. */
    bool      (*goes_on)(void *context, double done, double total);
    void       *context;
    const volatile int *stop; /* the same when *stop becomes nonzero; threads look at it too.  NULL: nothing  */
} lw_build_control;

typedef struct lw_build_counts {
    uint64_t before;          /* in the catalogue when the call began                                */
    uint64_t done;            /* in the catalogue now: chains, samples; linkages read by this call   */
    uint64_t total;           /* wanted: chains, samples                                             */
    uint64_t added;           /* by this call: linkages, curves                                      */
    bool     was_complete;    /* there was nothing left to do                                        */
} lw_build_counts;

/* ---- topologies ------------------------------------------------------------------------------------------- */

typedef struct lw_build_topologies {
    const char *kinds;        /* kinds of joints: "r", "rt" or "t"; every assignment that can move is stored */
    bool        any_input;    /* any joint may be driven, not only joints at the ground               */
    bool        pictures;     /* store where the joints of each chain are drawn                       */
} lw_build_topologies;

/* Store every chain of `chains` with its structure and derivation, canonical label, symmetry, planarity, notations,
 * ground links, inputs and Assur groups.  Threads describe the chains block by block; one thread writes.
 * LW_E_ARG: kinds; LW_STOPPED, LW_E_IO, LW_E_MEMORY. */
lw_status lw_build_chains(lw_store *s, const lw_chains *chains, const lw_build_topologies *what,
                          const lw_build_control *control, lw_build_counts *counts, lw_error *e);

/* Store every chain with multiple joints that is not fractionated (enumerate/multiple.h), in one transaction: a call that
 * is stopped stores nothing.  LW_E_ARG, LW_STOPPED, LW_E_IO, LW_E_MEMORY. */
lw_status lw_build_multiple(lw_store *s, int links, int dof, const lw_build_control *control, lw_build_counts *counts, lw_error *e);

/* ---- linkages --------------------------------------------------------------------------------------------- */

/* Store the linkages of a JSON text that `file` is the name of: values one after the other, each what `fit --json` or
 * `catalogue nearest --json` prints (an object with `results`), one of these results (an object with `linkage`), or a
 * linkage.  A linkage that is stored already with the same target, task and objective is left out.
 * LW_E_NOTATION with the line of the fault: then nothing since the last commit is kept. */
lw_status lw_build_linkages(lw_store *s, const char *file, const char *text, size_t size,
                            const lw_build_control *control, lw_build_counts *counts, lw_error *e);

/* ---- coupler curves --------------------------------------------------------------------------------------- */

/* Draw samples of the maker's families until the catalogue has n_sample of them for this seed, or those of a part.  `about`
 * says of what linkages ("fourbar", "six links").  A part holds consecutive segments; lw_store_add_curves joins the parts.
 * LW_E_ARG: fewer segments than parts. */
lw_status lw_build_curves(lw_store *s, const lw_curve_maker *maker, lw_atlas_kinds kinds, uint64_t n_sample,
                          const char *about, const lw_build_control *control, lw_build_counts *counts, lw_error *e);

/* The same in steps, so that several processes can draw.  Process 0 begins; any process draws a segment; process 0 puts
 * the segments from sweep.segments to n_segment - 1 in order and frees the trees. */
typedef struct lw_build_sweep {
    const lw_curve_maker *maker;
    lw_atlas_sweep        sweep;
    uint64_t              n_sample;       /* of this part                                             */
    size_t                n_segment, size;/* of this part; samples in a segment                       */
} lw_build_sweep;

/* Which samples: no catalogue is needed. */
lw_status lw_build_sweep_make(const lw_curve_maker *maker, lw_atlas_kinds kinds, uint64_t n_sample,
                              const lw_build_control *control, lw_build_sweep *b, lw_error *e);
lw_status lw_build_sweep_begin(lw_build_sweep *b, lw_store *s, const char *about, const lw_build_control *control,
                               lw_build_counts *counts, lw_error *e);
lw_status lw_build_sweep_draw(const lw_build_sweep *b, size_t segment, const lw_build_control *control, lw_atlas_tree tree[2]);
lw_status lw_build_sweep_put(lw_build_sweep *b, lw_store *s, lw_atlas_tree tree[2], lw_build_counts *counts, lw_error *e);

/* ---- checking --------------------------------------------------------------------------------------------- */

/* Check the file (every page and reference), that every chain is the one its label names and moves with its number of
 * freedoms, and all sums that the tables must fulfil.  *n_chain: chains; *n_open: builds that are not finished.
 * LW_E_NOTATION with the first fault.  control may be NULL. */
lw_status lw_build_check(lw_store *s, const lw_build_control *control, uint64_t *n_chain, uint64_t *n_open, lw_error *e);

/* Compare published counts with the catalogue.  `row` is called for every published number about a build that is
 * finished in this catalogue. */
lw_status lw_build_check_published(lw_store *s, const lw_published_table *t,
                                   void (*row)(void *context, const lw_published *row, long long counted),
                                   void *context, lw_error *e);

#endif

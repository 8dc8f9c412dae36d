/* catalogues/build/build_curves.c - store coupler curves in a catalogue, one segment per transaction. */
#include <stdio.h>

#include "catalogues/build/build_internal.h"

static lw_status begin(lw_store *s, lw_atlas_sweep *sweep, uint64_t n_sample, const char *about,
                       const lw_build_control *control, lw_error *e)
{
    char what[128];
    snprintf(what, sizeof what, "%llu curves of %.90s", (unsigned long long)n_sample, about);
    lw_store_run run = { "curves", what, lw_build_command(control), control->seed };
    lw_status status = lw_store_begin(s, e);
    if (status == LW_OK)
        status = lw_store_sweep_begin(s, sweep, e);
    if (status == LW_OK && sweep->samples < n_sample)
        status = lw_store_run_begin(s, &run, e);
    if (status == LW_OK)
        return lw_store_commit(s, e);
    lw_store_rollback(s);
    return status;
}

static lw_status draw_segment(lw_store *s, const lw_curve_maker *maker, lw_atlas_sweep *sweep, uint64_t n_sample,
                              int jobs, uint64_t *n_curve, lw_error *e)
{
    lw_atlas_tree tree[2];
    uint64_t left = n_sample - sweep->samples;
    size_t n = left < LW_SEGMENT_MAX ? (size_t)left : LW_SEGMENT_MAX;
    lw_status status = lw_atlas_segment(maker, sweep->seed, sweep->segments, n, sweep->kinds, jobs, tree);
    if (status != LW_OK)
        return lw_error_set(e, status, "%s", lw_status_text(status));
    status = lw_store_begin(s, e);
    if (status == LW_OK)
        status = lw_store_put_segment(s, tree, n, e);
    sweep->samples += n;
    sweep->segments++;
    if (status == LW_OK && sweep->samples >= n_sample)
        status = lw_store_run_end(s, e);
    if (status == LW_OK)
        status = lw_store_commit(s, e);
    if (status != LW_OK)
        lw_store_rollback(s);
    *n_curve += tree[0].n + tree[1].n;
    lw_atlas_tree_free(&tree[0]);
    lw_atlas_tree_free(&tree[1]);
    return status;
}

lw_status lw_build_curves(lw_store *s, const lw_curve_maker *maker, lw_atlas_kinds kinds, uint64_t n_sample,
                          const char *about, const lw_build_control *control, lw_build_counts *counts, lw_error *e)
{
    lw_atlas_sweep sweep = { .families = lw_curve_maker_families(maker), .kinds = kinds, .seed = control->seed };
    *counts = (lw_build_counts){ .total = n_sample };
    lw_status status = begin(s, &sweep, n_sample, about, control, e);
    counts->before = sweep.samples;
    counts->was_complete = sweep.samples >= n_sample;
    while (status == LW_OK && sweep.samples < n_sample) {
        if (lw_build_goes_on(control, (double)sweep.samples, (double)n_sample))
            status = draw_segment(s, maker, &sweep, n_sample, control->jobs, &counts->added, e);
        else
            status = LW_STOPPED;
    }
    counts->done = sweep.samples;
    return status;
}

/* catalogues/build/build_curves.c - store coupler curves in a catalogue, one segment per transaction. */
#include <stdio.h>

#include "catalogues/build/build_internal.h"

lw_status lw_build_sweep_make(const lw_curve_maker *maker, lw_atlas_kinds kinds, uint64_t n_sample,
                              const lw_build_control *control, lw_build_sweep *b, lw_error *e)
{
    uint64_t size = control->segment > 0 ? control->segment : LW_SEGMENT_MAX, m = control->n_part > 0 ? control->n_part : 1;
    uint64_t all = (n_sample + size - 1)/size, part = (uint64_t)control->part;
    uint64_t first = all*part/m, end = all*(part + 1)/m;
    if (all < m && n_sample > 0)
        return lw_error_set(e, LW_E_ARG, "%llu samples are %llu segments of %llu; they do not give %llu parts",
                            (unsigned long long)n_sample, (unsigned long long)all, (unsigned long long)size,
                            (unsigned long long)m);
    *b = (lw_build_sweep){ .maker = maker, .n_segment = (size_t)(end - first), .size = (size_t)size };
    b->sweep = (lw_atlas_sweep){ .families = lw_curve_maker_families(maker), .kinds = kinds, .seed = control->seed,
                                 .first = first };
    b->n_sample = (end == all ? n_sample : end*size) - first*size;
    return LW_OK;
}

lw_status lw_build_sweep_begin(lw_build_sweep *b, lw_store *s, const char *about, const lw_build_control *control,
                               lw_build_counts *counts, lw_error *e)
{
    char what[128];
    snprintf(what, sizeof what, "%llu curves of %.90s", (unsigned long long)b->n_sample, about);
    lw_store_run run = { "curves", what, lw_build_command(control), control->seed };
    *counts = (lw_build_counts){ .total = b->n_sample };
    lw_status status = lw_store_begin(s, e);
    if (status == LW_OK)
        status = lw_store_sweep_begin(s, &b->sweep, e);
    if (status == LW_OK && b->sweep.samples < b->n_sample)
        status = lw_store_run_begin(s, &run, e);
    if (status == LW_OK)
        status = lw_store_commit(s, e);
    if (status != LW_OK) {
        lw_store_rollback(s);
        return status;
    }
    counts->before = counts->done = b->sweep.samples;
    counts->was_complete = b->sweep.samples >= b->n_sample;
    /* a segment may have been the short end of a smaller number of samples */
    uint64_t left = counts->was_complete ? 0 : b->n_sample - b->sweep.samples;
    b->n_segment = (size_t)(b->sweep.segments + (left + b->size - 1)/b->size);
    return LW_OK;
}

static size_t samples_of_segment(const lw_build_sweep *b, size_t segment)
{
    uint64_t at = b->sweep.samples + (segment - b->sweep.segments)*b->size, left = b->n_sample - at;
    return left < b->size ? (size_t)left : b->size;
}

lw_status lw_build_sweep_draw(const lw_build_sweep *b, size_t segment, const lw_build_control *control, lw_atlas_tree tree[2])
{
    return lw_atlas_segment(b->maker, b->sweep.seed, b->sweep.first + segment, samples_of_segment(b, segment),
                            b->sweep.kinds, control->jobs, control->stop, tree);
}

lw_status lw_build_sweep_put(lw_build_sweep *b, lw_store *s, lw_atlas_tree tree[2], lw_build_counts *counts, lw_error *e)
{
    size_t n = samples_of_segment(b, b->sweep.segments);
    lw_status status = lw_store_begin(s, e);
    if (status == LW_OK)
        status = lw_store_put_segment(s, tree, n, e);
    if (status == LW_OK && b->sweep.samples + n >= b->n_sample)
        status = lw_store_run_end(s, e);
    if (status == LW_OK)
        status = lw_store_commit(s, e);
    if (status == LW_OK) {
        b->sweep.samples += n;
        b->sweep.segments++;
        counts->done = b->sweep.samples;
        counts->added += tree[0].n + tree[1].n;
    } else {
        lw_store_rollback(s);
    }
    lw_atlas_tree_free(&tree[0]);
    lw_atlas_tree_free(&tree[1]);
    return status;
}

lw_status lw_build_curves(lw_store *s, const lw_curve_maker *maker, lw_atlas_kinds kinds, uint64_t n_sample,
                          const char *about, const lw_build_control *control, lw_build_counts *counts, lw_error *e)
{
    lw_build_sweep b;
    *counts = (lw_build_counts){ 0 };
    lw_status status = lw_build_sweep_make(maker, kinds, n_sample, control, &b, e);
    if (status == LW_OK)
        status = lw_build_sweep_begin(&b, s, about, control, counts, e);
    while (status == LW_OK && b.sweep.samples < b.n_sample) {
        lw_atlas_tree tree[2];
        if (!lw_build_goes_on(control, (double)b.sweep.samples, (double)b.n_sample))
            return LW_STOPPED;
        status = lw_build_sweep_draw(&b, b.sweep.segments, control, tree);
        if (status == LW_STOPPED)
            return status;
        status = status != LW_OK ? lw_graph_error(e, status) : lw_build_sweep_put(&b, s, tree, counts, e);
    }
    return status;
}

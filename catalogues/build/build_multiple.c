/* catalogues/build/build_multiple.c - chains with multiple joints into a catalogue, in one transaction. */
#include <stdio.h>

#include "catalogues/build/build_internal.h"
#include "enumerate/canon.h"
#include "enumerate/multiple.h"
#include "grammar/topology/planar.h"

typedef struct job {
    lw_store               *store;
    const lw_build_control *control;
    lw_build_counts        *counts;
    int                     dof;
    lw_error               *e;
} job;

/* Links with 2, 3, ... pins, and "1:2 3:1": each ground link with the number of links alike. */
static void print_texts(const lw_multiple *m, const uint8_t *lowest, char *assortment, char *grounds, size_t size, int *n_ground)
{
    int n_with[LW_LINK_MAX + 1] = { 0 }, most = 2;
    size_t at = 0;
    for (int i = 0; i < m->n_link; i++) {
        int n = 0;
        for (int k = 0; k < m->n_pin; k++)
            n += m->pin[k] >> i & 1;
        n_with[n]++;
        most = n > most ? n : most;
    }
    for (int d = 2; d <= most; d++)
        at += (size_t)snprintf(assortment + at, size - at, "%s%d", d > 2 ? " " : "", n_with[d]);
    *n_ground = 0;
    at = 0;
    for (int i = 0; i < m->n_link; i++) {
        int alike = 0;
        for (int k = 0; k < m->n_link; k++)
            alike += lowest[k] == i;
        if (alike > 0)
            at += (size_t)snprintf(grounds + at, size - at, "%s%d:%d", (*n_ground)++ ? " " : "", i + 1, alike);
    }
}

static lw_status take(void *context, const lw_multiple *found)
{
    job *j = context;
    lw_multiple m;
    lw_mechanism all;
    lw_chain graph;
    uint32_t axes, ties[LW_LINK_MAX];
    uint8_t lowest[LW_LINK_MAX];
    char pins[LW_MULTIPLE_SIZE], assortment[LW_LINK_MAX*8], grounds[LW_LINK_MAX*8];
    lw_store_multiple row = { .links = found->n_link, .dof = j->dof, .pins = pins, .assortment = assortment,
                              .ground_links = grounds };
    lw_status s = lw_multiple_canonical(found, &m);
    if (s == LW_OK)
        s = lw_multiple_symmetry(&m, lowest, &row.symmetry);
    if (s == LW_OK)
        s = lw_multiple_mechanism(&m, &all, &axes);
    if (s == LW_OK) {
        lw_mechanism_chain(&all, &graph);
        for (int i = 0; i < graph.n_link; i++)
            ties[i] = lw_chain_neighbours(&graph, i);
        s = lw_planar_test(graph.n_link, ties, &row.planar);
    }
    if (s != LW_OK)
        return lw_graph_error(j->e, s);
    row.joints = lw_multiple_joints(&m);
    row.loops = row.joints - m.n_link + 1;
    lw_multiple_print(&m, pins, sizeof pins);
    print_texts(&m, lowest, assortment, grounds, sizeof grounds, &row.n_ground);
    s = lw_store_put_multiple(j->store, &row, j->e);
    j->counts->done += s == LW_OK;
    return s == LW_OK && !lw_build_goes_on(j->control, (double)j->counts->done, 0) ? LW_STOPPED : s;
}

lw_status lw_build_multiple(lw_store *s, int links, int dof, const lw_build_control *control, lw_build_counts *counts, lw_error *e)
{
    char what[64];
    uint64_t done = 0;
    job j = { s, control, counts, dof, e };
    snprintf(what, sizeof what, "links %d, dof %d, multiple joints", links, dof);
    lw_store_run run = { "build", what, lw_build_command(control), control->seed };
    *counts = (lw_build_counts){ 0 };
    lw_status status = lw_store_begin(s, e);
    if (status == LW_OK)
        status = lw_store_build_begin(s, links, dof, "multiple", &done, &counts->was_complete, e);
    if (status == LW_OK && !counts->was_complete)
        status = lw_store_run_begin(s, &run, e);
    if (status == LW_OK && !counts->was_complete)
        status = lw_multiple_each(links, dof, control->jobs, take, &j, e);
    if (status == LW_OK && !counts->was_complete)
        status = lw_store_build_done(s, counts->done, true, e);
    if (status == LW_OK && !counts->was_complete)
        status = lw_store_run_end(s, e);
    if (status == LW_OK)
        status = lw_store_commit(s, e);
    if (status != LW_OK) {
        lw_store_rollback(s);
        counts->done = 0;
    }
    if (status == LW_OK && counts->was_complete)
        counts->done = done;
    counts->total = counts->done;
    return status;
}

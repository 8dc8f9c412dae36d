/* All six-link mechanisms with pins and sliders whose input is at the ground, one a line, with the class of their
 * hardest Assur group: the topology half of the library in one page.
 *
 *     cc topologies.c $(pkg-config --cflags --libs linkwright) -o topologies
 *     ./topologies | sort -n | uniq -c -w 1                                                             */
#include <stdio.h>

#include "enumerate/assur.h"
#include "enumerate/mechanisms.h"
#include "grammar/edges.h"

static lw_status print_mechanism(void *context, const lw_mechanism *m)
{
    lw_assur groups;
    char text[LW_EDGES_SIZE];
    int hardest = 0;
    lw_status s = lw_assur_decompose(m, &groups, NULL);
    for (int k = 0; s == LW_OK && k < groups.n_group; k++)
        if (groups.group[k].n_class > hardest)
            hardest = groups.group[k].n_class;
    lw_edges_print(m, text, sizeof text);
    fprintf(context, "%d  %s\n", hardest, text);
    return s;
}

static lw_status each_chain(void *context, const lw_chain_item *item)
{
    const lw_mechanism_steps steps = { .ground = true, .kinds = "rt", .input = LW_INPUT_GROUND };
    lw_mechanism_counts counts = { 0 };
    lw_mechanism m;
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    return s == LW_OK ? lw_mechanisms_each(&m, &steps, &counts, print_mechanism, NULL, context) : s;
}

int main(void)
{
    lw_chains *chains;
    lw_error e;
    lw_chain_walk how = lw_chain_walk_default();
    if (lw_chains_create(6, 1, 0, &chains, &e) != LW_OK) {
        fprintf(stderr, "%s\n", e.text);
        return 1;
    }
    lw_status s = lw_chains_each(chains, &how, each_chain, stdout);
    lw_chains_free(chains);
    return s == LW_OK ? 0 : 1;
}

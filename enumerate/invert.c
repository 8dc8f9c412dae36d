/* enumerate/invert.c - see invert.h. */
#include "enumerate/canon.h"
#include "enumerate/invert.h"

lw_status lw_chain_orbits(const lw_chain *c, uint8_t *lowest, int *n_class)
{
    lw_graph g;
    uint8_t ground[LW_LINK_MAX];
    lw_graph_of_chain(c, &g);
    lw_status status = lw_graph_symmetry(&g, lowest, NULL);
    if (status == LW_OK && n_class)
        *n_class = lw_ground_choices(lowest, c->n_link, ground);
    return status;
}

int lw_ground_choices(const uint8_t *lowest, int n_link, uint8_t *ground)
{
    int n = 0;
    for (int i = 0; i < n_link; i++)
        if (lowest[i] == i)
            ground[n++] = (uint8_t)i;
    return n;
}

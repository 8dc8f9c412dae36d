#include "enumerate/symmetry.h"

#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"

/* Joints that may be exchanged have the same number. */
static int tie_of(lw_joint_kind kind, bool kinds)
{
    if (!kinds)
        return lw_joint_freedoms(kind);
    switch (kind) {
    case LW_JOINT_REVOLUTE: return 1;
    case LW_JOINT_SLOT:     return 2;
    case LW_JOINT_SLIDER:   return 3;
    case LW_JOINT_GEAR:     return 4;
    case LW_JOINT_FIXED: case LW_JOINT_FREE: break;
    }
    return 0;
}

/* Ties distinguish kinds and driven joints; colours distinguish the ground and the output. */
static void graph_of(const lw_mechanism *m, bool kinds, lw_graph *g)
{
    memset(g, 0, sizeof *g);
    g->n = m->n_link;
    for (int i = 0; i < m->n_link; i++)
        g->colour[i] = (uint8_t)((i == m->ground) + 2*(i == m->output));
    for (int j = 0; j < m->n_joint; j++) {
        int a = m->link[j][0], b = m->link[j][1], tie = tie_of(m->kind[j], kinds);
        if (memchr(m->input, j, (size_t)m->n_input))
            tie += 4;
        g->tie[a][b] = g->tie[b][a] = (uint8_t)tie;
    }
}

lw_status lw_symmetry_of(const lw_mechanism *m, bool kinds, lw_symmetry *s)
{
    lw_graph g;
    graph_of(m, kinds, &g);
    *s = (lw_symmetry){ .n_joint = m->n_joint };
    lw_status status = lw_graph_elements(&g, &s->link, &s->n);
    if (status != LW_OK)
        return status;
    s->joint = malloc(s->n*sizeof *s->joint);
    if (!s->joint) {
        lw_symmetry_free(s);
        return LW_E_MEMORY;
    }
    size_t n = 0;
    for (size_t k = 0; k < s->n; k++) {
        bool keeps = true;
        for (int j = 0; j < m->n_joint; j++) {
            int image = lw_mechanism_joint(m, s->link[k][m->link[j][0]], s->link[k][m->link[j][1]]);
            s->joint[n][j] = (uint8_t)image;
            keeps = keeps && !(kinds && m->directed && m->kind[j] == LW_JOINT_SLIDER
                               && s->link[k][lw_mechanism_printed(m, j, 0)] != lw_mechanism_printed(m, image, 0));
        }
        memmove(s->link[n], s->link[k], sizeof s->link[k]);
        n += keeps;
    }
    s->n = n;
    return LW_OK;
}

void lw_symmetry_free(lw_symmetry *s)
{
    free(s->link);
    free(s->joint);
    *s = (lw_symmetry){ 0 };
}

lw_status lw_mechanism_orbits(const lw_mechanism *m, uint8_t *lowest)
{
    lw_graph g;
    graph_of(m, true, &g);
    if (m->directed) {
        lw_symmetry s;
        lw_status status = lw_symmetry_of(m, true, &s);
        for (int i = 0; status == LW_OK && i < m->n_link; i++) {
            lowest[i] = (uint8_t)i;
            for (size_t k = 0; k < s.n; k++)
                lowest[i] = s.link[k][i] < lowest[i] ? s.link[k][i] : lowest[i];
        }
        if (status == LW_OK)
            lw_symmetry_free(&s);
        return status;
    }
    return lw_graph_symmetry(&g, lowest, NULL);
}

lw_status lw_mechanism_canonical(const lw_mechanism *m, lw_mechanism *form)
{
    lw_graph g;
    uint8_t to[LW_LINK_MAX];
    graph_of(m, true, &g);
    lw_status status = lw_graph_label(&g, to);
    if (status == LW_OK)
        lw_mechanism_relabel(m, to, form);
    return status;
}

#include "grammar/topology/mechanism.h"

#include <string.h>

lw_status lw_mechanism_clear(lw_mechanism *m, int n_link)
{
    if (n_link < 1 || n_link > LW_LINK_MAX)
        return LW_E_ARG;
    *m = (lw_mechanism){ .n_link = n_link, .ground = LW_NONE, .output = LW_NONE };
    return LW_OK;
}

/* Number of joints before (i, k), i < k, in the order of the rows. */
static int rank_of(const lw_mechanism *m, int i, int k)
{
    int j = 0;
    while (j < m->n_joint && (m->link[j][0] < i || (m->link[j][0] == i && m->link[j][1] < k)))
        j++;
    return j;
}

int lw_mechanism_joint(const lw_mechanism *m, int i, int k)
{
    int a = i < k ? i : k, b = i < k ? k : i, j = rank_of(m, a, b);
    return j < m->n_joint && m->link[j][0] == a && m->link[j][1] == b ? j : LW_NONE;
}

lw_status lw_mechanism_join(lw_mechanism *m, int i, int k, char kind)
{
    int a = i < k ? i : k, b = i < k ? k : i;
    if (a < 0 || a == b || b >= m->n_link || !lw_joint_freedoms(kind) || m->n_input > 0
        || m->n_joint == LW_JOINT_MAX || lw_mechanism_joint(m, a, b) != LW_NONE)
        return LW_E_ARG;
    int j = rank_of(m, a, b);
    memmove(m->link + j + 1, m->link + j, (size_t)(m->n_joint - j)*sizeof *m->link);
    memmove(m->kind + j + 1, m->kind + j, (size_t)(m->n_joint - j));
    m->link[j][0] = (uint8_t)a;
    m->link[j][1] = (uint8_t)b;
    m->kind[j] = kind;
    m->n_joint++;
    return LW_OK;
}

lw_status lw_mechanism_from_chain(const lw_chain *c, lw_mechanism *m)
{
    if (lw_chain_count(c, 1) + lw_chain_count(c, 2) > LW_JOINT_MAX)
        return LW_E_ARG;
    lw_status s = lw_mechanism_clear(m, c->n_link);
    for (int i = 0; i < c->n_link && s == LW_OK; i++)
        for (uint32_t set = lw_chain_neighbours(c, i) >> i; set; set &= set - 1) {
            int j = m->n_joint++, k = i + __builtin_ctz(set);
            m->link[j][0] = (uint8_t)i;
            m->link[j][1] = (uint8_t)k;
            m->kind[j] = lw_chain_freedom(c, i, k) == 1 ? LW_JOINT_REVOLUTE : LW_JOINT_SLOT;
        }
    return s;
}

void lw_mechanism_chain(const lw_mechanism *m, lw_chain *c)
{
    lw_chain_clear(c, m->n_link);
    for (int j = 0; j < m->n_joint; j++)
        lw_chain_join(c, m->link[j][0], m->link[j][1], lw_joint_freedoms(m->kind[j]));
}

void lw_mechanism_relabel(const lw_mechanism *m, const uint8_t *to, lw_mechanism *out)
{
    uint64_t driven = 0;
    lw_mechanism_clear(out, m->n_link);
    for (int j = 0; j < m->n_joint; j++)
        lw_mechanism_join(out, to[m->link[j][0]], to[m->link[j][1]], m->kind[j]);
    out->directed = m->directed;
    out->translating_cams = m->translating_cams;
    for (int j = 0; m->directed && j < m->n_joint; j++) {
        int guide = to[lw_mechanism_printed(m, j, 0)], image = lw_mechanism_joint(out, guide, to[lw_mechanism_printed(m, j, 1)]);
        out->guide |= (uint64_t)(m->kind[j] == LW_JOINT_SLIDER && out->link[image][1] == guide) << image;
    }
    for (int n = 0; n < m->n_input; n++) {
        const uint8_t *l = m->link[m->input[n]];
        driven |= (uint64_t)1 << lw_mechanism_joint(out, to[l[0]], to[l[1]]);
    }
    for (; driven; driven &= driven - 1)
        out->input[out->n_input++] = (uint8_t)__builtin_ctzll(driven);
    out->ground = m->ground == LW_NONE ? LW_NONE : to[m->ground];
    out->output = m->output == LW_NONE ? LW_NONE : to[m->output];
}

bool lw_mechanism_same(const lw_mechanism *a, const lw_mechanism *b)
{
    return a->n_link == b->n_link && a->n_joint == b->n_joint && a->n_input == b->n_input
        && a->ground == b->ground && a->output == b->output && a->directed == b->directed && a->guide == b->guide
        && !memcmp(a->link, b->link, (size_t)a->n_joint*sizeof *a->link)
        && !memcmp(a->kind, b->kind, (size_t)a->n_joint)
        && !memcmp(a->input, b->input, (size_t)a->n_input);
}

#include "enumerate/inputs.h"

#include <string.h>
#include "enumerate/symmetry.h"

lw_status lw_grounds_each(const lw_mechanism *m, lw_mechanism_visit *visit, void *context)
{
    uint8_t lowest[LW_LINK_MAX];
    lw_mechanism chosen = *m;
    if (m->ground != LW_NONE)
        return LW_E_ARG;
    lw_status s = lw_mechanism_orbits(m, lowest);
    for (int i = 0; i < m->n_link && s == LW_OK; i++)
        if (lowest[i] == i) {
            chosen.ground = i;
            s = visit(context, &chosen);
        }
    return s;
}

/* Order of sets: by the lowest joint in which they differ. */
static bool set_before(uint64_t a, uint64_t b)
{
    uint64_t differ = a ^ b;
    return differ && (a & (differ & -differ));
}

static bool is_first_set(const lw_symmetry *s, uint64_t set)
{
    for (size_t k = 1; k < s->n; k++) {
        uint64_t image = 0;
        for (uint64_t left = set; left; left &= left - 1)
            image |= (uint64_t)1 << s->joint[k][__builtin_ctzll(left)];
        if (set_before(image, set))
            return false;
    }
    return true;
}

static bool at_link(const lw_mechanism *m, int joint, int link)
{
    return m->link[joint][0] == link || m->link[joint][1] == link;
}

/* All sets of n of the joints allowed, lowest members first. */
typedef struct choice {
    const lw_mechanism *m;
    const lw_symmetry  *symmetry;
    uint64_t            allowed;
    bool                drive;          /* each of them alone does                                   */
    lw_mechanism_visit *visit;
    void               *context;
} choice;

static lw_status choose(const choice *c, int n, int from, uint64_t set)
{
    if (n == 0) {
        lw_mechanism chosen = *c->m;
        if (!is_first_set(c->symmetry, set) || (!c->drive && !lw_mechanism_drives(c->m, set)))
            return LW_OK;
        for (; set; set &= set - 1)
            chosen.input[chosen.n_input++] = (uint8_t)__builtin_ctzll(set);
        return c->visit(c->context, &chosen);
    }
    lw_status s = LW_OK;
    for (int j = from; j < c->m->n_joint && s == LW_OK; j++)
        if (c->allowed >> j & 1)
            s = choose(c, n - 1, j + 1, set | (uint64_t)1 << j);
    return s;
}

lw_status lw_inputs_each(const lw_mechanism *m, int n, bool at_ground, lw_mechanism_visit *visit, void *context)
{
    lw_symmetry symmetry;
    choice c = { .m = m, .symmetry = &symmetry, .visit = visit, .context = context };
    if (m->n_input > 0 || n < 1 || n > LW_INPUT_MAX || (at_ground && m->ground == LW_NONE))
        return LW_E_ARG;
    for (int j = 0; j < m->n_joint; j++)
        if (lw_joint_freedoms(m->kind[j]) == 1 && (!at_ground || at_link(m, j, m->ground)))
            c.allowed |= (uint64_t)1 << j;
    if ((c.drive = n == 1))
        c.allowed &= lw_mechanism_drivers(m);
    lw_status s = lw_symmetry_of(m, true, &symmetry);
    if (s != LW_OK)
        return s;
    s = choose(&c, n, 0, 0);
    lw_symmetry_free(&symmetry);
    return s;
}

lw_status lw_outputs_each(const lw_mechanism *m, lw_mechanism_visit *visit, void *context)
{
    uint8_t lowest[LW_LINK_MAX];
    lw_mechanism chosen = *m;
    if (m->ground == LW_NONE || m->output != LW_NONE)
        return LW_E_ARG;
    uint32_t barred = 1u << m->ground;
    for (int i = 0; i < m->n_input; i++)
        if (at_link(m, m->input[i], m->ground))
            barred |= 1u << m->link[m->input[i]][0] | 1u << m->link[m->input[i]][1];
    lw_status s = lw_mechanism_orbits(m, lowest);
    for (int i = 0; i < m->n_link && s == LW_OK; i++)
        if (!(barred >> i & 1) && lowest[i] == i) {
            chosen.output = i;
            s = visit(context, &chosen);
        }
    return s;
}

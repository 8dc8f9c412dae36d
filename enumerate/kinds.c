#include "enumerate/kinds.h"

#include <string.h>
#include "enumerate/symmetry.h"

/* The letters a joint may have, by their place in the caller's list. */
typedef struct alphabet { int n; char letter[4]; } alphabet;

static lw_status read_alphabets(const char *kinds, const lw_mechanism *m, alphabet by_freedom[3])
{
    memset(by_freedom, 0, 3*sizeof *by_freedom);
    for (const char *k = kinds; *k; k++) {
        alphabet *a = &by_freedom[lw_joint_freedoms(*k)];
        if (!lw_joint_freedoms(*k) || memchr(a->letter, *k, (size_t)a->n))
            return LW_E_ARG;
        a->letter[a->n++] = *k;
    }
    for (int j = 0; j < m->n_joint; j++)
        if (by_freedom[lw_joint_freedoms(m->kind[j])].n == 0)
            return LW_E_ARG;
    return LW_OK;
}

/* True if the choice is the first among its images under the symmetries. */
static bool is_first(const lw_symmetry *s, const uint8_t *choice)
{
    for (size_t k = 1; k < s->n; k++) {
        const uint8_t *to = s->joint[k];
        int j = 0;
        while (j < s->n_joint && choice[to[j]] == choice[j])
            j++;
        if (j < s->n_joint && choice[to[j]] < choice[j])
            return false;
    }
    return true;
}

/* The next choice in lexicographic order; false after the last. */
static bool next_choice(const lw_mechanism *m, const alphabet *by_freedom, uint8_t *choice)
{
    for (int j = m->n_joint - 1; j >= 0; j--) {
        if (choice[j] + 1 < by_freedom[lw_joint_freedoms(m->kind[j])].n) {
            choice[j]++;
            return true;
        }
        choice[j] = 0;
    }
    return false;
}

lw_status lw_kinds_each(const lw_mechanism *m, const char *kinds, lw_mechanism_visit *visit,
                        lw_void_visit *left_out, void *context)
{
    alphabet by_freedom[3];
    lw_symmetry symmetry;
    uint8_t choice[LW_JOINT_MAX] = { 0 };
    lw_mechanism labelled = *m;
    lw_status s = read_alphabets(kinds, m, by_freedom);
    if (s == LW_OK)
        s = lw_symmetry_of(m, false, &symmetry);
    if (s != LW_OK)
        return s;
    do {
        uint64_t joints;
        if (!is_first(&symmetry, choice))
            continue;
        for (int j = 0; j < m->n_joint; j++)
            labelled.kind[j] = by_freedom[lw_joint_freedoms(m->kind[j])].letter[choice[j]];
        lw_void reason = lw_mechanism_void(&labelled, &joints);
        if (reason == LW_VOID_NOT)
            s = visit(context, &labelled);
        else if (left_out)
            s = left_out(context, &labelled, reason, joints);
    } while (s == LW_OK && next_choice(m, by_freedom, choice));
    lw_symmetry_free(&symmetry);
    return s;
}

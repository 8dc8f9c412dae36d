#include "enumerate/kinds.h"

#include <string.h>
#include "enumerate/symmetry.h"

/* The letters a joint may have, by their place in the caller's list. */
typedef struct alphabet { int n; char letter[4]; } alphabet;

#define GUIDE_ON_SECOND 'T'      /* a slider whose guide is on link[j][1], where sliders have directions */

static lw_status read_alphabets(const char *kinds, const lw_mechanism *m, alphabet by_freedom[3])
{
    memset(by_freedom, 0, 3*sizeof *by_freedom);
    for (const char *k = kinds; *k; k++) {
        alphabet *a = &by_freedom[lw_joint_freedoms(*k)];
        if (!lw_joint_freedoms(*k) || memchr(a->letter, *k, (size_t)a->n))
            return LW_E_ARG;
        a->letter[a->n++] = *k;
    }
    if (m->directed && memchr(by_freedom[1].letter, LW_JOINT_SLIDER, (size_t)by_freedom[1].n))
        by_freedom[1].letter[by_freedom[1].n++] = GUIDE_ON_SECOND;
    for (int j = 0; j < m->n_joint; j++)
        if (by_freedom[lw_joint_freedoms(m->kind[j])].n == 0)
            return LW_E_ARG;
    return LW_OK;
}

/* The choice that symmetry k brings to joint j: a slider is reversed if the symmetry exchanges its first and second link. */
static int image_of(const lw_mechanism *m, const alphabet *one, const lw_symmetry *s, size_t k, const uint8_t *choice, int j)
{
    int to = s->joint[k][j], c = choice[to];
    if (!m->directed || lw_joint_freedoms(m->kind[j]) != 1 || one->letter[c] == LW_JOINT_REVOLUTE
        || s->link[k][m->link[j][0]] == m->link[to][0])
        return c;
    char other = one->letter[c] == LW_JOINT_SLIDER ? GUIDE_ON_SECOND : LW_JOINT_SLIDER;
    return (int)((const char *)memchr(one->letter, other, (size_t)one->n) - one->letter);
}

/* True if the choice is the first among its images under the symmetries. */
static bool is_first(const lw_mechanism *m, const alphabet *one, const lw_symmetry *s, const uint8_t *choice)
{
    for (size_t k = 1; k < s->n; k++) {
        int j = 0;
        while (j < s->n_joint && image_of(m, one, s, k, choice, j) == choice[j])
            j++;
        if (j < s->n_joint && image_of(m, one, s, k, choice, j) < choice[j])
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

lw_status lw_kinds_each(const lw_mechanism *m, const char *kinds, lw_mechanism_visit *visit, lw_void_visit *left_out, void *context)
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
        if (!is_first(m, &by_freedom[1], &symmetry, choice))
            continue;
        labelled.guide = 0;
        for (int j = 0; j < m->n_joint; j++) {
            char letter = by_freedom[lw_joint_freedoms(m->kind[j])].letter[choice[j]];
            labelled.kind[j] = letter == GUIDE_ON_SECOND ? LW_JOINT_SLIDER : letter;
            labelled.guide |= (uint64_t)(letter == GUIDE_ON_SECOND) << j;
        }
        lw_void reason = lw_mechanism_void(&labelled, &joints);
        if (reason == LW_VOID_NOT)
            s = visit(context, &labelled);
        else if (left_out)
            s = left_out(context, &labelled, reason, joints);
    } while (s == LW_OK && next_choice(m, by_freedom, choice));
    lw_symmetry_free(&symmetry);
    return s;
}

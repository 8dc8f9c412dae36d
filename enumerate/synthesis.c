/* enumerate/synthesis.c - see synthesis.h. */
#include "enumerate/synthesis.h"

lw_status lw_numbers_of(int dof, int n_loop, int n2, lw_numbers *numbers, lw_error *e)
{
    if (dof < 0 || dof > LW_DOF_MAX)
        return lw_error_set(e, LW_E_ARG, "the degree of freedom is 0 to %d, not %d", LW_DOF_MAX, dof);
    if (n_loop < 1 || n_loop > LW_LOOP_MAX)
        return lw_error_set(e, LW_E_ARG, "the number of loops is 1 to %d, not %d", LW_LOOP_MAX, n_loop);
    if (n2 < 0)
        return lw_error_set(e, LW_E_ARG, "the number of joints of two freedoms cannot be negative");
    int n_link = dof + 2*n_loop + 1 - n2, n1 = dof + 3*n_loop - 2*n2;
    if (n_link < 2 || n1 < 0)
        return lw_error_set(e, LW_E_ARG, "no chain has F = %d, L = %d and n2 = %d: P = F + 2 L + 1 - n2 = %d, "
                            "n1 = F + 3 L - 2 n2 = %d", dof, n_loop, n2, n_link, n1);
    if (n_link > LW_LINK_MAX)
        return lw_error_set(e, LW_E_ARG, "P = F + 2 L + 1 - n2 = %d links are more than %d", n_link, LW_LINK_MAX);
    *numbers = (lw_numbers){ dof, n_loop, n1, n2, n_link, n1 + n2 <= n_link*(n_link - 1)/2 };
    return LW_OK;
}

lw_status lw_numbers_for_links(int n_link, int dof, int n2, lw_numbers *numbers, lw_error *e)
{
    int twice = n_link + n2 - dof - 1;      /* 2 L */
    if (n_link < 2 || n_link > LW_LINK_MAX)
        return lw_error_set(e, LW_E_ARG, "a chain has 2 to %d links, not %d", LW_LINK_MAX, n_link);
    if (twice < 2 || twice % 2 != 0)
        return lw_error_set(e, LW_E_ARG, "no closed chain has P = %d, F = %d, n2 = %d: P = F + 2 L + 1 - n2 needs "
                            "P + n2 - F odd and at least 3; try P = %d", n_link, dof, n2,
                            twice < 2 ? dof + 3 - n2 : n_link + 1);
    return lw_numbers_of(dof, twice/2, n2, numbers, e);
}

/* A link with i joints has i - 2 more than a binary one, and these excesses add up to
 * sum of (i - 2) P_i = 2j - 2P = 2 (L - 1).  So assortments are the partitions of 2 (L - 1) into at most
 * P parts, none above L - 1.
 *
 * Give the excess `rest` to at most `room` links of i joints or fewer, the largest first. */
static bool fill(lw_assortment *a, int i, int rest, int room)
{
    for (; i > 2; i--) {
        int n = rest/(i - 2);
        a->n_with[i] = n < room ? n : room;
        rest -= a->n_with[i]*(i - 2);
        room -= a->n_with[i];
    }
    a->n_with[2] = room;
    return rest == 0;
}

bool lw_assortment_first(const lw_numbers *numbers, lw_assortment *a)
{
    *a = (lw_assortment){ { 0 } };
    return fill(a, numbers->n_loop + 1, 2*(numbers->n_loop - 1), numbers->n_link);
}

/* Reduce the smallest link that allows it by one, and fill up with smaller links. */
bool lw_assortment_next(const lw_numbers *numbers, lw_assortment *a)
{
    int rest = 0, room = a->n_with[2];
    for (int i = 3; i <= numbers->n_loop + 1; i++) {
        for (; a->n_with[i] > 0; ) {
            a->n_with[i]--;
            rest += i - 2;
            room++;
            lw_assortment trial = *a;
            if (fill(&trial, i - 1, rest, room)) {
                *a = trial;
                return true;
            }
        }
    }
    return false;
}

/* test_synthesis.c - number synthesis against the printed table, all solutions by exhaustion, and the link
 * assortments that occur in the published counts. */
#include <string.h>
#include "enumerate/synthesis.h"
#include "tests/check.h"

/* Makkonen 1999, table after eq. 12 (F = 1; binary and ternary links only): L, n1, n2, P, P2, P3 */
TEST(agrees_with_the_printed_table)
{
    static const int row[][6] = { {1,4,0,4,4,0}, {1,2,1,3,3,0}, {2,7,0,6,4,2}, {2,5,1,5,3,2} };
    for (size_t k = 0; k < sizeof row/sizeof *row; k++) {
        lw_numbers n;
        lw_assortment a, last = { { 0 } };
        CHECK_INT(lw_numbers_of(1, row[k][0], row[k][2], &n, NULL), LW_OK);
        CHECK_INT(n.n1, row[k][1]);
        CHECK_INT(n.n_link, row[k][3]);
        CHECK(n.simple);
        bool more = lw_assortment_first(&n, &a);
        CHECK(more);
        for (; more; more = lw_assortment_next(&n, &a))
            last = a;                            /* the smallest links come last */
        CHECK_INT(last.n_with[2], row[k][4]);
        CHECK_INT(last.n_with[3], row[k][5]);
    }
}

TEST(solves_both_equations_and_misses_none)
{
    for (int dof = 0; dof <= LW_DOF_MAX; dof++)
        for (int links = 2; links <= LW_LINK_MAX; links++)
            for (int n1 = 0; n1 <= 60; n1++) {
                int n2 = 3*(links - 1) - 2*n1 - dof, loops = n1 + n2 - links + 1;
                lw_numbers n;
                if (n2 < 0 || loops < 1 || loops > LW_LOOP_MAX)
                    continue;
                CHECK_INT(lw_numbers_of(dof, loops, n2, &n, NULL), LW_OK);
                CHECK(n.n_link == links && n.n1 == n1 && n.n2 == n2 && n.n_loop == loops);
                CHECK_INT(lw_numbers_for_links(links, dof, n2, &n, NULL), LW_OK);
                CHECK(n.n_loop == loops && n.n1 == n1);
            }
}

TEST(two_links_and_two_contacts)
{
    lw_numbers n;           /* solves the equations, though no simple chain: the printed table stops before it */
    CHECK_INT(lw_numbers_of(1, 1, 2, &n, NULL), LW_OK);
    CHECK(n.n_link == 2 && n.n1 == 0 && n.n2 == 2 && !n.simple);
}

TEST(explains_what_cannot_be)
{
    lw_numbers n;
    lw_error e = { 0 };
    CHECK_INT(lw_numbers_for_links(7, 1, 0, &n, &e), LW_E_ARG);
    CHECK_HAS(e.text, "P = F + 2 L + 1 - n2");
    CHECK_HAS(e.text, "try P = 8");
    CHECK_FAILS(lw_numbers_for_links(3, 1, 0, &n, &check_error), LW_E_ARG, "try P = 4");
    CHECK_INT(lw_numbers_for_links(1, 1, 0, &n, &e), LW_E_ARG);
    CHECK_INT(lw_numbers_for_links(33, 0, 0, &n, &e), LW_E_ARG);
    CHECK_INT(lw_numbers_of(LW_DOF_MAX + 1, 1, 0, &n, &e), LW_E_ARG);
    CHECK_INT(lw_numbers_of(-1, 1, 0, &n, &e), LW_E_ARG);
    CHECK_INT(lw_numbers_of(1, 0, 0, &n, &e), LW_E_ARG);
    CHECK_INT(lw_numbers_of(1, LW_LOOP_MAX + 1, 0, &n, &e), LW_E_ARG);
    CHECK_INT(lw_numbers_of(1, 2, -1, &n, &e), LW_E_ARG);
    CHECK_FAILS(lw_numbers_of(1, 1, 3, &n, &check_error), LW_E_ARG, "n1 = F + 3 L - 2 n2 = -2");
    CHECK_INT(lw_numbers_of(2, LW_LOOP_MAX, 0, &n, &e), LW_E_ARG);
}

/* The slow way: count all (P2, P3, ...) with the right sums. */
static int count_by_exhaustion(int i, int links, int ends)
{
    if (i == 2)
        return ends == 2*links;
    int n = 0;
    for (int k = 0; k <= links && k*i <= ends; k++)
        n += count_by_exhaustion(i - 1, links - k, ends - k*i);
    return n;
}

static int compare(const lw_assortment *a, const lw_assortment *b)
{
    for (int i = LW_LOOP_MAX + 1; i >= 2; i--)
        if (a->n_with[i] != b->n_with[i])
            return a->n_with[i] > b->n_with[i] ? -1 : 1;
    return 0;
}

TEST(lists_every_assortment_once_in_order)
{
    for (int dof = 0; dof <= LW_DOF_MAX; dof++)
        for (int loops = 1; loops <= 9; loops++)
            for (int n2 = 0; n2 <= 12; n2++) {
                lw_numbers n;
                lw_assortment a, before = { { 0 } };
                if (lw_numbers_of(dof, loops, n2, &n, NULL) != LW_OK)
                    continue;
                int count = 0;
                for (bool more = lw_assortment_first(&n, &a); more; more = lw_assortment_next(&n, &a)) {
                    int links = 0, ends = 0;
                    for (int i = 2; i <= loops + 1; i++) {
                        links += a.n_with[i];
                        ends += i*a.n_with[i];
                    }
                    CHECK_INT(links, n.n_link);
                    CHECK_INT(ends, 2*(n.n1 + n.n2));
                    CHECK(count == 0 || compare(&before, &a) < 0);
                    before = a;
                    count++;
                }
                CHECK_INT(count, count_by_exhaustion(loops + 1, n.n_link, 2*(n.n1 + n.n2)));
            }
}

/* F = 1, L = 4: the seven assortments for which chains with ten links are published, and no other */
TEST(ten_links)
{
    static const int want[][4] = { {8,0,0,2}, {7,1,1,1}, {6,3,0,1}, {7,0,3,0}, {6,2,2,0}, {5,4,1,0}, {4,6,0,0} };
    lw_numbers n;
    lw_assortment a;
    CHECK_INT(lw_numbers_of(1, 4, 0, &n, NULL), LW_OK);
    bool more = lw_assortment_first(&n, &a);
    for (size_t k = 0; k < 7; k++, more = lw_assortment_next(&n, &a)) {
        CHECK(more);
        CHECK(memcmp(&a.n_with[2], want[k], sizeof want[k]) == 0);
    }
    CHECK(!more);
}

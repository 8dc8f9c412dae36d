/* Chains with joints of two freedoms against catalogues/data/published-counts.csv (family lower+higher pairs, one
 * method there: multigraphs and a test of all subsets) and against all graphs on few links. */
#include "check.h"
#include "all_chains.h"
#include "enumerate/higher.h"

typedef struct found { int n, n2, dof; chain_list list; } found;

static lw_status note(void *context, const lw_chain *c)
{
    found *f = context;
    CHECK_INT(lw_chain_mobility(c), f->dof);
    CHECK_INT(lw_chain_count(c, 2), f->n2);
    CHECK_INT(lw_chain_check(c, NULL), LW_OK);
    CHECK_INT(lw_chain_cut_links(c), 0);
    f->n++;
    if (c->n_link <= 5)
        add_form(&f->list, c);
    return LW_OK;
}

static int count(int n_link, int dof, int n2)
{
    found f = { .n2 = n2, .dof = dof };
    CHECK_INT(lw_higher_each(n_link, dof, n2, 1, note, &f, NULL), LW_OK);
    int n = f.list.n;
    prune_forms(&f.list);
    CHECK_INT(f.list.n, n);                                  /* each once */
    free(f.list.chain);
    return f.n;
}

TEST(published)
{
    static const struct { int n_link, n2, n; } known[] = {
        { 3, 1, 1 }, { 4, 0, 1 }, { 4, 2, 3 }, { 4, 4, 2 }, { 5, 1, 3 }, { 5, 3, 24 }, { 5, 5, 20 }, { 5, 7, 6 },
        { 5, 9, 1 },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++)
        CHECK_INT(count(known[i].n_link, 1, known[i].n2), known[i].n);
}

/* Every way to put nothing, a joint of one or one of two freedoms between any two links, tested by the count of
 * all subsets. */
static int by_brute_force(int n_link, int dof, int n2)
{
    chain_list list = { 0 };
    int n_pair = n_link*(n_link - 1)/2, n_way = 1;
    for (int i = 0; i < n_pair; i++)
        n_way *= 3;
    for (int way = 0; way < n_way; way++) {
        lw_chain c;
        bool rigid = false;
        lw_chain_clear(&c, n_link);
        for (int a = 0, left = way; a < n_link; a++)
            for (int b = 0; b < a; b++, left /= 3)
                if (left % 3)
                    lw_chain_join(&c, a, b, left % 3);
        if (lw_chain_mobility(&c) != dof || lw_chain_count(&c, 2) != n2 || !lw_chain_is_connected(&c) || lw_chain_cut_links(&c))
            continue;
        for (uint32_t s = 1; s < 1u << n_link; s++)
            rigid |= (s & (s - 1)) && lw_chain_mobility_of(&c, s) <= 0;
        if (!rigid)
            add_form(&list, &c);
    }
    prune_forms(&list);
    free(list.chain);
    return list.n;
}

TEST(brute_force)
{
    for (int n_link = 3; n_link <= 5; n_link++)
        for (int dof = 1; dof <= 3; dof++)
            for (int n2 = 0; n2 <= 10; n2++) {
                lw_numbers numbers;
                if (lw_numbers_for_links(n_link, dof, n2, &numbers, NULL) == LW_OK && numbers.n_loop >= 1)
                    CHECK_INT(count(n_link, dof, n2), by_brute_force(n_link, dof, n2));
            }
}

TEST(refusals)
{
    lw_error e = { 0 };
    CHECK_INT(lw_higher_each(4, 1, 1, 1, note, NULL, &e), LW_E_ARG);
    CHECK(e.text[0] != '\0');
}

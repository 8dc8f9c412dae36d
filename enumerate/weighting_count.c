/* enumerate/weighting_count.c - see weighting.h: counts the chains of a structure without listing them.
 *
 * Burnside's lemma: the number of orbits is the mean, over the automorphisms g, of the number of weightings that g
 * leaves unchanged.  For ground links the same mean runs over pairs (weighting, link) that g leaves unchanged, where
 * a link is a circle or a place on a line; parallel lines of equal weight count once. */
#include "enumerate/weighting_internal.h"

typedef struct tally {
    lw_weighting_search search;
    uint64_t  n_chain, n_place;           /* weightings; fixed places on lines, summed over them */
} tally;

/* Places on a line with n binary links that the automorphism keeps; only those not counted before. */
static int fixed_places(const lw_weighting_search *t, int k, int n, int before)
{
    const lw_unknown *x = &t->x[k];
    if (!x->fixed || ((t->tied >> k & 1) && n == before))
        return 0;
    return x->turned ? n & 1 : n;
}

/* One binary link is left: every candidate with one line can take it. */
static void count_last(tally *t, const lw_weighting_state *s, uint64_t can, int n_place)
{
    can &= t->search.single;
    uint64_t n = (uint64_t)__builtin_popcountll(can);
    bool alike = s->before == 1 && (can & t->search.tied);       /* parallel to a line with one too */
    t->n_chain += n;
    t->n_place += n*(uint64_t)(n_place + 1) - alike;
}

static void count_from(tally *t, const lw_weighting_state *s, int n_place)
{
    const lw_weighting_search *search = &t->search;
    uint64_t can = lw_weighting_candidates(search, s);
    if (s->left == 1) {
        count_last(t, s, can, n_place);
        return;
    }
    for (; can; can &= can - 1) {
        int k = __builtin_ctzll(can);
        if (s->left > search->most*search->lines_left[k])
            return;
        for (int n = lw_search_most(search, s, k); n > 0; n--) {
            lw_weighting_state after;
            if (!lw_search_settle(search, s, k, n, &after))
                continue;
            int places = n_place + fixed_places(search, k, n, s->before);
            if (after.left > 0) {
                count_from(t, &after, places);
                continue;
            }
            t->n_chain++;
            t->n_place += (uint64_t)places;
        }
    }
}

static void count_fixed(const lw_weighting *w, size_t g, tally *t)
{
    lw_weighting_state start = { .left = w->n_binary };
    lw_search_start(&t->search, w, g);
    t->n_chain = t->n_place = 0;
    if (w->n_binary > 0)
        count_from(t, &start, 0);
    else
        t->n_chain = w->critical.n == 0;
}

lw_status lw_weighting_count(const lw_weighting *w, lw_tally *out)
{
    tally t;
    *out = (lw_tally){ 0, 0 };
    if (w->n_binary < 0)
        return LW_OK;
    lw_status status = lw_search_open(&t.search, w);
    if (status != LW_OK)
        return status;
    for (size_t g = 0; g < w->n_element; g++) {
        uint64_t n_circle = 0;
        for (int c = 0; c < w->s.n_circle; c++)
            n_circle += w->circle[g][c] == c;
        count_fixed(w, g, &t);
        out->n_chain += t.n_chain;
        out->n_ground += t.n_place + n_circle*t.n_chain;
    }
    lw_search_close(&t.search);
    out->n_chain /= w->n_element;
    out->n_ground /= w->n_element;
    return LW_OK;
}

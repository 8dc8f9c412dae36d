/* enumerate/weighting_count.c - see weighting.h: counts the chains of a structure without listing them.
 *
 * Burnside's lemma: the number of orbits is the mean, over the automorphisms g, of the number of weightings that g
 * leaves unchanged.  For ground links the same mean runs over pairs (weighting, link) that g leaves unchanged, where
 * a link is a circle or a place on a line; parallel lines of equal weight count once. */
#include <string.h>
#include "enumerate/weighting_internal.h"

typedef struct tally {
    lw_weighting_search search;
    bool      identity;                   /* every unknown is one line, every place fixed        */
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

/* Two binary links are left, and the automorphism is the identity, so every unknown is one line.  A set that lacks one of them
 * allows two lines only if one of the two is inside; sets that lack both have limited `can`. */
static void count_last_two(tally *t, const lw_weighting_state *s, uint64_t can, int n_place)
{
    const lw_weighting_search *search = &t->search;
    uint64_t *inside = search->lacking, free_lines = can & ~search->tied, next = (uint64_t)1 << s->next;
    bool tied = search->tied & next;                 /* only the next line can be tied to one that has its number */
    int n_set = lw_weighting_lacking_one(search, s, inside);
    for (uint64_t rest = free_lines | (tied && s->before ? can & next : 0); rest; rest &= rest - 1) {
        int k = __builtin_ctzll(rest), before = tied && k == s->next ? s->before : 0;
        uint64_t partner = ~(uint64_t)0, twin = (uint64_t)2 << k & search->tied & can;
        for (int c = 0; c < n_set; c++)
            partner &= inside[c] | -(inside[c] >> k & 1);
        bool both = partner == ~(uint64_t)0 && search->most > 1 && before != 1;         /* two links on line k */
        partner &= (free_lines & ~(uint64_t)1 << k) | twin;
        uint64_t n = (uint64_t)__builtin_popcountll(partner);
        t->n_chain += n + both;
        t->n_place += n*(uint64_t)(n_place + 2 - (before == 1)) - ((partner & twin) != 0)
                    + (both ? (uint64_t)(n_place + (before == 2 ? 0 : 2)) : 0);
    }
}

static void count_from(tally *t, const lw_weighting_state *s, int n_place)
{
    const lw_weighting_search *search = &t->search;
    if (s->left == 2 && t->identity) {
        count_last_two(t, s, lw_weighting_allowed(search, s), n_place);
        return;
    }
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

/* The order in which lines get their binary links.  Lines in small critical sets that need much come first, because
 * then the last lines are nearly free: there are fewer partial weightings, and each is completed in more ways (eight
 * times fewer for nine loops than in the order of lines).  Parallel lines stay together. */
static void constrained_first(const lw_weighting *w, uint8_t *order)
{
    double score[LW_LINE_MAX];
    for (int e = 0; e < w->s.n_line; e++) {
        score[e] = w->parallel[e] ? score[e - 1] : 0;
        for (int c = 0; c < w->critical.n && !w->parallel[e]; c++) {
            const lw_critical *set = &w->critical.set[c];
            double size = __builtin_popcountll(set->lines);
            score[e] += set->lines >> e & 1 ? set->need/(size*size*size) : 0;
        }
        int i = e;
        for (; i > 0 && score[order[i - 1]] < score[e]; i--)
            order[i] = order[i - 1];
        order[i] = (uint8_t)e;
    }
}

/* apart: parallel lines are distinguishable. */
static void count_fixed(const lw_weighting *w, size_t g, const uint8_t *order, bool apart, tally *t)
{
    lw_weighting_state start = { .left = w->n_binary };
    lw_search_start(&t->search, w, g, order);
    if (apart)
        t->search.tied = 0;
    t->identity = g == 0;
    t->n_chain = t->n_place = 0;
    if (w->n_binary > 0)
        count_from(t, &start, 0);
    else
        t->n_chain = w->critical.n == 0;
}

/* n_labelled gets the number of weightings of distinguishable lines. */
static lw_status count(const lw_weighting *w, bool labelled, lw_tally *out)
{
    tally t;
    *out = (lw_tally){ 0, 0, 0 };
    if (w->n_binary < 0)
        return LW_OK;
    lw_status status = lw_search_open(&t.search, w);
    if (status != LW_OK)
        return status;
    uint8_t order[LW_LINE_MAX];
    constrained_first(w, order);
    for (size_t g = 0; g < w->n_element; g++) {
        uint64_t n_circle = 0;
        for (int c = 0; c < w->s.n_circle; c++)
            n_circle += w->circle[g][c] == c;
        count_fixed(w, g, order, false, &t);
        out->n_chain += t.n_chain;
        out->n_ground += t.n_place + n_circle*t.n_chain;
        if (g == 0 && labelled && t.search.tied)
            count_fixed(w, g, order, true, &t);
        if (g == 0)
            out->n_labelled = t.n_chain;
    }
    lw_search_close(&t.search);
    out->n_chain /= w->n_element;
    out->n_ground /= w->n_element;
    return LW_OK;
}

lw_status lw_weighting_count(const lw_weighting *w, lw_tally *out)
{
    lw_status status = count(w, false, out);
    out->n_labelled = 0;
    return status;
}

lw_status lw_weighting_count_labelled(const lw_weighting *w, lw_tally *out)
{
    uint64_t order = w->n_element;
    lw_status status = count(w, true, out);
    for (int e = 1, alike = 1; e < w->s.n_line; e++)
        order *= (uint64_t)(alike = w->parallel[e] ? alike + 1 : 1);
    return status != LW_OK ? status
         : lw_labelled_forms(w->s.n_circle + w->n_binary, order, (uint64_t)out->n_labelled, &out->n_labelled);
}

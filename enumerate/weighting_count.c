/* enumerate/weighting_count.c - see weighting.h: counts the chains of a structure without listing them.
 *
 * Burnside's lemma: the number of orbits is the mean, over the automorphisms g, of the number of weightings that g
 * leaves unchanged.  For ground links the same mean runs over pairs (weighting, link) that g leaves unchanged, where
 * a link is a circle or a place on a line; parallel lines of equal weight count once. */
#include <string.h>
#include "enumerate/weighting_internal.h"

typedef struct tally {
    lw_weighting_search search;
    bool      whole;                      /* every set has all lines of an unknown or none       */
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

/* Two binary links are left, and every set has all lines of an unknown or none.  A set that lacks one of them allows two lines
 * only if one of the two is inside; sets that lack both have limited `can`. */
static void count_last_two(tally *t, const lw_weighting_state *s, uint64_t can, int n_place)
{
    const lw_weighting_search *search = &t->search;
    uint64_t *inside = search->lacking, free_lines = can & ~search->tied, next = (uint64_t)1 << s->next;
    bool tied = search->tied & next;                 /* only the next line can be tied to one that has its number */
    int n_set = lw_weighting_lacking_one(search, s, inside);
    uint64_t pairs = can & search->pairs;            /* unknowns of two lines, one binary link on each */
    for (int c = 0; c < n_set; c++)
        pairs &= inside[c];
    t->n_chain += (uint64_t)__builtin_popcountll(pairs);
    free_lines &= search->single;
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
    if (s->left == 2 && t->whole) {
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

static void count_weightings(const lw_weighting *w, tally *t)
{
    lw_weighting_state start = { .left = w->n_binary };
    t->n_chain = t->n_place = 0;
    if (w->n_binary > 0)
        count_from(t, &start, 0);
    else
        t->n_chain = w->critical.n == 0;
}

static void count_fixed(const lw_weighting *w, size_t g, const uint8_t *order, tally *t)
{
    lw_search_start(&t->search, w, g, w->line[g], LW_LINE_MAX, order);
    t->whole = g == 0;
    count_weightings(w, t);
}

lw_status lw_weighting_count(const lw_weighting *w, lw_tally *out)
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
        count_fixed(w, g, order, &t);
        out->n_chain += t.n_chain;
        out->n_ground += t.n_place + n_circle*t.n_chain;
    }
    lw_search_close(&t.search);
    out->n_chain /= w->n_element;
    out->n_ground /= w->n_element;
    return LW_OK;
}

/* ---- excess over the labelled chains ------------------------------------------------------------- */

/* A set of n parallel lines, first .. first + n - 1, that a permutation exchanges. */
typedef struct exchange {
    const lw_weighting *w;
    const uint8_t      *order;
    tally              *t;
    int                 first, n;
    uint8_t             line[LW_LINE_MAX];
    uint64_t            n_fixed;          /* sum over the permutations but the identity of weightings unchanged */
} exchange;

/* `done` lines are permuted, the last of them in `same` cycles of `most` lines.  Permutations with cycles of the same lengths
 * leave as many weightings unchanged, so one of each is counted, `alike` times. */
static void exchange_lines(exchange *x, int done, int most, int same, uint64_t alike)
{
    if (done == x->n) {
        if (x->line[x->first] == x->first)             /* cycles of one line: the identity */
            return;
        lw_search_start(&x->t->search, x->w, 0, x->line, x->first, x->order);
        x->t->whole = true;
        count_weightings(x->w, x->t);
        x->n_fixed += alike*x->t->n_chain;
        return;
    }
    for (int n = 1; n <= most && n <= x->n - done; n++) {
        int again = n == most ? same + 1 : 1;
        for (int i = 0; i < n; i++)
            x->line[x->first + done + i] = (uint8_t)(x->first + done + (i + 1) % n);
        exchange_lines(x, done + n, n, again, alike/(uint64_t)(n*again));
    }
    for (int i = 0; i < x->n - done; i++)
        x->line[x->first + done + i] = (uint8_t)(x->first + done + i);
}

/* Burnside's lemma without the identity.  For one set of parallel lines after the other: those before are taken as alike, those
 * after as having names. */
lw_status lw_weighting_excess(const lw_weighting *w, lw_tally *out)
{
    tally t;
    uint8_t order[LW_LINE_MAX];
    exchange x = { .w = w, .order = order, .t = &t };
    uint64_t n_fixed = 0, n_exchange = 1;
    *out = (lw_tally){ 0, 0, 0 };
    if (w->n_binary < 0)
        return LW_OK;
    lw_status status = lw_search_open(&t.search, w);
    if (status != LW_OK)
        return status;
    constrained_first(w, order);
    for (int e = 0; e < w->s.n_line; e++)
        x.line[e] = (uint8_t)e;
    for (int e = 0; e < w->s.n_line; e += x.n) {
        uint64_t n_order = 1, before = x.n_fixed;
        x.n_fixed = 0;
        x.first = e;
        for (x.n = 1; e + x.n < w->s.n_line && w->parallel[e + x.n]; x.n++)
            n_order *= (uint64_t)x.n + 1;
        if (x.n > 1)
            exchange_lines(&x, 0, x.n, 0, n_order);
        x.n_fixed = before + x.n_fixed*n_exchange;
        n_exchange *= n_order;
    }
    for (size_t g = 1; g < w->n_element; g++) {
        count_fixed(w, g, order, &t);
        n_fixed += t.n_chain;
    }
    lw_search_close(&t.search);
    return lw_labelled_forms(w->s.n_circle + w->n_binary, n_exchange*w->n_element, x.n_fixed + n_exchange*n_fixed, &out->n_labelled);
}

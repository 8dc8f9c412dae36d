/* enumerate/weighting.c - see weighting.h: preparation, listing, symmetry of one weighting. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/synthesis.h"
#include "enumerate/weighting_internal.h"

lw_weighting *lw_weighting_create(void) { return calloc(1, sizeof(lw_weighting)); }

static void forget_group(lw_weighting *w)
{
    free(w->circle);
    free(w->line);
    w->circle = NULL;
    w->line = NULL;
    w->n_element = 0;
}

void lw_weighting_free(lw_weighting *w)
{
    if (!w)
        return;
    forget_group(w);
    free(w->critical.set);
    free(w);
}

const lw_structure *lw_weighting_structure(const lw_weighting *w) { return &w->s; }

/* The automorphisms as permutations of lines: parallel lines keep their order among themselves. */
static lw_status fill_lines(lw_weighting *w)
{
    const lw_structure *s = &w->s;
    uint8_t first[LW_CIRCLE_MAX][LW_CIRCLE_MAX];
    w->line = malloc(w->n_element*sizeof *w->line);
    if (!w->line)
        return LW_E_MEMORY;
    for (int e = s->n_line - 1; e >= 0; e--) {
        first[s->end[e][0]][s->end[e][1]] = (uint8_t)e;
        first[s->end[e][1]][s->end[e][0]] = (uint8_t)e;
    }
    for (size_t g = 0; g < w->n_element; g++) {
        const uint8_t *to = w->circle[g];
        for (int e = 0; e < s->n_line; e++)
            w->line[g][e] = (uint8_t)(w->parallel[e] ? w->line[g][e - 1] + 1 : first[to[s->end[e][0]]][to[s->end[e][1]]]);
    }
    return LW_OK;
}

static lw_status find_group(lw_weighting *w)
{
    lw_graph graph;
    forget_group(w);
    lw_graph_of_structure(&w->s, &graph);
    lw_status status = lw_graph_elements(&graph, &w->circle, &w->n_element);
    return status == LW_OK ? fill_lines(w) : status;
}

lw_status lw_weighting_prepare(lw_weighting *w, const lw_structure *s, int dof)
{
    int n_binary = dof + 3 + 2*s->n_line - 3*s->n_circle;
    if (dof < 0 || dof > LW_DOF_MAX || s->n_circle + n_binary > LW_LINK_MAX)
        return LW_E_ARG;
    w->s = *s;
    w->n_binary = n_binary;
    /* F = 1: the whole needs all binary links, which is the same as w_e <= 2 */
    w->most = dof < 2 ? dof + 1 : n_binary;
    for (int e = 0; e < s->n_line; e++)
        w->parallel[e] = e > 0 && memcmp(s->end[e - 1], s->end[e], 2) == 0;
    lw_status status = lw_critical_sets(s, dof > 1, &w->critical);
    return status == LW_OK ? find_group(w) : status;
}

/* ---- listing ------------------------------------------------------------------------------------- */

typedef struct listing {
    const lw_weighting *w;
    lw_weighting_visit *visit;
    void               *context;
    lw_weighting_search           search;
    uint8_t             weight[LW_LINE_MAX];
} listing;

/* True if no image of the weighting is lexicographically larger. */
static bool largest_of_orbit(const lw_weighting *w, const uint8_t *weight)
{
    for (size_t g = 1; g < w->n_element; g++) {
        const uint8_t *to = w->line[g];
        int e = 0;
        while (e < w->s.n_line && weight[to[e]] == weight[e])
            e++;
        if (e < w->s.n_line && weight[to[e]] > weight[e])
            return false;
    }
    return true;
}

static lw_status list_one(listing *l)
{
    return largest_of_orbit(l->w, l->weight) ? l->visit(l->context, l->weight) : LW_OK;
}

/* Earlier lines first, larger weights first: so weightings come in falling order. */
static lw_status list_from(listing *l, const lw_weighting_state *s)
{
    const lw_weighting_search *search = &l->search;
    uint64_t can = lw_weighting_candidates(search, s);
    lw_status status = LW_OK;
    for (; can && status == LW_OK; can &= can - 1) {
        int k = __builtin_ctzll(can);
        if (s->left == 1) {
            l->weight[k] = 1;
            status = list_one(l);
            l->weight[k] = 0;
            continue;
        }
        if (s->left > search->most*search->lines_left[k])
            break;
        for (int n = lw_search_most(search, s, k); n > 0 && status == LW_OK; n--) {
            lw_weighting_state after;
            if (!lw_search_settle(search, s, k, n, &after))
                continue;
            l->weight[k] = (uint8_t)n;
            status = after.left > 0 ? list_from(l, &after) : list_one(l);
        }
        l->weight[k] = 0;
    }
    return status;
}

lw_status lw_weighting_each(const lw_weighting *w, lw_weighting_visit *visit, void *context)
{
    lw_weighting_state start = { .left = w->n_binary };
    listing l = { .w = w, .visit = visit, .context = context };
    if (w->n_binary < 0)
        return LW_OK;
    lw_status status = lw_search_open(&l.search, w);
    if (status != LW_OK)
        return status;
    lw_search_start(&l.search, w, 0, w->line[0], LW_LINE_MAX, NULL);
    if (w->n_binary > 0)
        status = list_from(&l, &start);
    else if (w->critical.n == 0)
        status = list_one(&l);
    lw_search_close(&l.search);
    return status;
}

/* ---- symmetry of one weighting ------------------------------------------------------------------- */

static bool keeps_weighting(const lw_weighting *w, size_t g, const uint8_t *weight)
{
    for (int e = 0; e < w->s.n_line; e++)
        if (weight[w->line[g][e]] != weight[e])
            return false;
    return true;
}

/* Merge the classes of links i and k. */
static void join_classes(uint8_t *lowest, int n_link, int i, int k)
{
    uint8_t a = lowest[i], b = lowest[k];
    if (a == b)
        return;
    for (int j = 0; j < n_link; j++)
        if (lowest[j] == (a < b ? b : a))
            lowest[j] = a < b ? a : b;
}

/* Parallel lines with equal weights are equivalent, link by link. */
static void join_parallels(const lw_weighting *w, const uint8_t *weight, const uint8_t *start, int n_link, uint8_t *lowest)
{
    for (int e = 1; e < w->s.n_line; e++)
        for (int i = 0; w->parallel[e] && weight[e] == weight[e - 1] && i < weight[e]; i++)
            join_classes(lowest, n_link, start[e] + i, start[e - 1] + i);
}

int lw_weighting_orbits(const lw_weighting *w, const uint8_t *weight, uint8_t *lowest)
{
    const lw_structure *s = &w->s;
    uint8_t start[LW_LINE_MAX];                  /* first binary link of each line */
    int n_link = s->n_circle, n_class = 0;
    for (int e = 0; e < s->n_line; e++) {
        start[e] = (uint8_t)n_link;
        n_link += weight[e];
    }
    for (int i = 0; i < n_link; i++)
        lowest[i] = (uint8_t)i;
    join_parallels(w, weight, start, n_link, lowest);
    for (size_t g = 1; g < w->n_element; g++) {
        if (!keeps_weighting(w, g, weight))
            continue;
        for (int c = 0; c < s->n_circle; c++)
            join_classes(lowest, n_link, c, w->circle[g][c]);
        for (int e = 0; e < s->n_line; e++) {
            int f = w->line[g][e];
            bool turned = w->circle[g][s->end[e][0]] != s->end[f][0];
            for (int i = 0; i < weight[e]; i++)
                join_classes(lowest, n_link, start[e] + i, start[f] + (turned ? weight[e] - 1 - i : i));
        }
    }
    for (int i = 0; i < n_link; i++)
        n_class += lowest[i] == i;
    return n_class;
}

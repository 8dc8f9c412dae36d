/* enumerate/weighting_search.c - see weighting_internal.h. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/weighting_internal.h"

static int block_count(const lw_weighting *w) { return w->critical.n ? (w->critical.n + 15)/16 : 1; }

lw_status lw_search_open(lw_weighting_search *t, const lw_weighting *w)
{
    size_t n_block = (size_t)block_count(w), states = (size_t)(w->s.n_line + 1)*n_block;
    *t = (lw_weighting_search){ .n_block = (int)n_block, .most = w->most };
    t->column = malloc(3*states*sizeof *t->column + 2*16*n_block*sizeof *t->inside);
    if (!t->column)
        return LW_E_MEMORY;
    t->supply = t->column + states;
    t->lack = t->supply + states;
    t->inside = (uint64_t *)(t->lack + states);
    t->lacking = t->inside + 16*n_block;
    return LW_OK;
}

void lw_search_close(lw_weighting_search *t) { free(t->column); }

/* The cycles of lines of automorphism g, in the order of their first lines in `order`. */
static void find_unknowns(const lw_weighting *w, size_t g, const uint8_t *line, int apart, const uint8_t *order, lw_weighting_search *t)
{
    uint64_t seen = 0;
    t->n_unknown = 0;
    t->tied = t->single = t->pairs = 0;
    memset(t->column, 0, (size_t)(w->s.n_line*t->n_block)*sizeof *t->column);
    for (int i = 0; i < w->s.n_line; i++) {
        int e = order ? order[i] : i;
        if (seen >> e & 1)
            continue;
        int k = t->n_unknown++, n = 0, from = w->s.end[e][0];
        for (int f = e; !(seen >> f & 1); f = line[f], n++) {
            seen |= (uint64_t)1 << f;
            for (int c = 0; c < w->critical.n; c++)
                t->column[k*t->n_block + c/16][c % 16] += (int8_t)(w->critical.set[c].lines >> f & 1);
        }
        t->x[k] = (lw_unknown){ n, n == 1, w->circle[g][from] != from };
        t->tied |= (uint64_t)(w->parallel[e] && e < apart) << k;
        t->single |= (uint64_t)(n == 1) << k;
        t->pairs |= (uint64_t)(n == 2) << k;
    }
}

static void find_supply(lw_weighting_search *t)
{
    int n_block = t->n_block;
    memset(t->supply + t->n_unknown*n_block, 0, (size_t)n_block*sizeof *t->supply);
    t->lines_left[t->n_unknown] = 0;
    for (int k = t->n_unknown - 1; k >= 0; k--) {
        for (int b = 0; b < n_block; b++)
            t->supply[k*n_block + b] = t->supply[(k + 1)*n_block + b] + t->column[k*n_block + b]*(int8_t)2;
        t->lines_left[k] = t->lines_left[k + 1] + t->x[k].n_line;
    }
}

void lw_search_start(lw_weighting_search *t, const lw_weighting *w, size_t g, const uint8_t *line, int apart, const uint8_t *order)
{
    find_unknowns(w, g, line, apart, order, t);
    find_supply(t);
    memset(t->lack, 0, (size_t)t->n_block*sizeof *t->lack);
    for (int c = 0; c < w->critical.n; c++) {
        t->lack[c/16][c % 16] = (int8_t)w->critical.set[c].need;
        t->inside[c] = 0;
        for (int k = 0; k < t->n_unknown; k++)
            t->inside[c] |= (uint64_t)(t->column[k*t->n_block + c/16][c % 16] == t->x[k].n_line) << k;
    }
}

/* Does BODY for each set c that lacks exactly n. */
#define FOR_SETS_LACKING(t, s, n, c, BODY)                                                                  \
    for (int b_ = 0; b_ < (t)->n_block; b_++) {                                                             \
        lw_weighting_lanes found_ = (lw_weighting_lanes)((t)->lack[(s)->depth*(t)->n_block + b_] == (int8_t)(n)); \
        uint64_t half_[2];                                                                                  \
        memcpy(half_, &found_, sizeof half_);                                                               \
        for (int h_ = 0; h_ < 2; h_++)                                                                      \
            for (uint64_t rest_ = half_[h_] & 0x0101010101010101u; rest_; rest_ &= rest_ - 1) {             \
                int c = 16*b_ + 8*h_ + __builtin_ctzll(rest_)/8;                                            \
                BODY;                                                                                       \
            }                                                                                               \
    }

uint64_t lw_weighting_allowed(const lw_weighting_search *t, const lw_weighting_state *s)
{
    uint64_t can = (((uint64_t)1 << t->n_unknown) - 1) & ~(uint64_t)0 << s->next;
    FOR_SETS_LACKING(t, s, s->left, c, can &= t->inside[c])
    return can;
}

uint64_t lw_weighting_candidates(const lw_weighting_search *t, const lw_weighting_state *s)
{
    return lw_weighting_allowed(t, s) & (~t->tied | (s->before ? (uint64_t)1 << s->next : 0));
}

int lw_weighting_lacking_one(const lw_weighting_search *t, const lw_weighting_state *s, uint64_t *inside)
{
    int n = 0;
    FOR_SETS_LACKING(t, s, 1, c, inside[n++] = t->inside[c])
    return n;
}

bool lw_search_settle(const lw_weighting_search *t, const lw_weighting_state *s, int k, int n, lw_weighting_state *after)
{
    int n_block = t->n_block, given = n < 2 ? n : 2, left = s->left - n*t->x[k].n_line;
    const lw_weighting_lanes *lack = t->lack + s->depth*n_block, *column = t->column + k*n_block;
    const lw_weighting_lanes *supply = t->supply + (k + 1)*n_block;
    lw_weighting_lanes *next = t->lack + (s->depth + 1)*n_block, sign = { 0 };
    if (left > t->most*t->lines_left[k + 1])
        return false;
    for (int b = 0; b < n_block; b++) {
        next[b] = lack[b] - column[b]*(int8_t)given;
        sign |= ((int8_t)left - next[b]) | (supply[b] - next[b]);
    }
    *after = (lw_weighting_state){ s->depth + 1, k + 1, n, left };
    uint64_t half[2];
    memcpy(half, &sign, sizeof half);
    return !((half[0] | half[1]) & 0x8080808080808080u);
}

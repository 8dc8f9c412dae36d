/* enumerate/weighting_search.c - see weighting_internal.h. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/weighting_internal.h"

static int block_count(const lw_weighting *w) { return w->critical.n ? (w->critical.n + 15)/16 : 1; }

lw_status lw_search_open(lw_weighting_search *t, const lw_weighting *w)
{
    size_t n_block = (size_t)block_count(w), states = (size_t)(w->s.n_line + 1)*n_block;
    *t = (lw_weighting_search){ .n_block = (int)n_block, .most = w->most };
    t->column = malloc(3*states*sizeof *t->column + 16*n_block*sizeof *t->inside);
    if (!t->column)
        return LW_E_MEMORY;
    t->supply = t->column + states;
    t->lack = t->supply + states;
    t->inside = (uint64_t *)(t->lack + states);
    return LW_OK;
}

void lw_search_close(lw_weighting_search *t) { free(t->column); }

/* The cycles of lines of automorphism g, in the order of their first lines. */
static void find_unknowns(const lw_weighting *w, size_t g, lw_weighting_search *t)
{
    uint64_t seen = 0;
    t->n_unknown = 0;
    t->tied = t->single = 0;
    memset(t->column, 0, (size_t)(w->s.n_line*t->n_block)*sizeof *t->column);
    for (int e = 0; e < w->s.n_line; e++) {
        if (seen >> e & 1)
            continue;
        int k = t->n_unknown++, n = 0, from = w->s.end[e][0];
        for (int f = e; !(seen >> f & 1); f = w->line[g][f], n++) {
            seen |= (uint64_t)1 << f;
            for (int c = 0; c < w->critical.n; c++)
                t->column[k*t->n_block + c/16][c % 16] += (int8_t)(w->critical.set[c].lines >> f & 1);
        }
        t->x[k] = (lw_unknown){ n, n == 1, w->circle[g][from] != from };
        t->tied |= (uint64_t)w->parallel[e] << k;
        t->single |= (uint64_t)(n == 1) << k;
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

void lw_search_start(lw_weighting_search *t, const lw_weighting *w, size_t g)
{
    find_unknowns(w, g, t);
    find_supply(t);
    memset(t->lack, 0, (size_t)t->n_block*sizeof *t->lack);
    for (int c = 0; c < w->critical.n; c++) {
        t->lack[c/16][c % 16] = (int8_t)w->critical.set[c].need;
        t->inside[c] = 0;
        for (int k = 0; k < t->n_unknown; k++)
            t->inside[c] |= (uint64_t)(t->column[k*t->n_block + c/16][c % 16] == t->x[k].n_line) << k;
    }
}

uint64_t lw_weighting_candidates(const lw_weighting_search *t, const lw_weighting_state *s)
{
    const lw_weighting_lanes *lack = t->lack + s->depth*t->n_block;
    uint64_t later = (((uint64_t)1 << t->n_unknown) - 1) & ~(uint64_t)0 << s->next;
    uint64_t can = later & (~t->tied | (s->before ? (uint64_t)1 << s->next : 0));
    for (int b = 0; b < t->n_block; b++) {
        lw_weighting_lanes tight = (lw_weighting_lanes)(lack[b] == (int8_t)s->left);
        uint64_t half[2];
        memcpy(half, &tight, sizeof half);
        for (int h = 0; h < 2; h++)
            for (uint64_t rest = half[h] & 0x0101010101010101u; rest; rest &= rest - 1)
                can &= t->inside[16*b + 8*h + __builtin_ctzll(rest)/8];
    }
    return can;
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

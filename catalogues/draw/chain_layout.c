/* catalogues/draw/chain_layout.c - see chain_layout.h */
#include <stdlib.h>
#include <string.h>

#include "catalogues/draw/chain_layout_internal.h"

#define WAYS       8          /* ways that are drawn at all       */
#define FIRST_RUN  30         /* steps that each of them gets     */
#define LAST_RUN   400        /* steps of the best                */

void lw_layout_draft_places(const lw_layout_draft *t, lw_chain_layout *l)
{
    const lw_mechanism *m = t->m;
    const lw_embedding *way = t->way;
    const lw_web *w = &t->web;
    const lw_vec2 *p = t->p;
    l->n_joint = m->n_joint;
    for (int j = 0; j < m->n_joint; j++)
        l->at[j] = p[w->vertex_of[j]];
    for (int i = 0; i < m->n_link; i++) {
        int first = -1, n = l->first[i], d;
        for (d = way->rings.n_dart - 1; d >= 0; d--)
            if (way->rings.link[d] == i)
                first = d;
        if (i == m->ground)
            first = way->rings.after[way->outer ^ 1];
        d = first;
        do
            l->ring[n++] = (uint8_t)(d >> 1);
        while ((d = way->rings.after[d]) != first);
        l->first[i + 1] = n;
        l->end[i] = w->end_of[i] != 255 ? p[w->end_of[i]] : l->at[first >> 1];
    }
}

/* ---- which is best ------------------------------------------------------------------------------ */

lw_status lw_layout_draft_begin(const lw_mechanism *m, const lw_embedding *way, lw_layout_draft *t)
{
    t->m = m;
    t->way = way;
    lw_web_make(m, way, &t->web);
    lw_status s = lw_web_start(&t->web, t->p);
    if (s == LW_OK)
        s = lw_relax_make(&t->web, &t->relax);
    if (s != LW_OK)
        return s;
    double scale = 0, weight = 0;
    for (int i = 0; i < t->relax.n_spring; i++) {
        const lw_layout_spring *k = &t->relax.spring[i];
        scale += k->weight*lw_v2_norm(lw_v2_sub(t->p[k->a], t->p[k->b]))/k->length;
        weight += k->weight;
    }
    for (int i = 0; i < t->web.n_vertex; i++)
        t->p[i] = lw_v2_scale(t->p[i], weight/fmax(scale, 1e-9));
    return LW_OK;
}

/* Less is better: energy, with a little credit for symmetry. */
static double score(const lw_layout_draft *t)
{
    return t->energy*(1 - 0.1*fmin(2, log2(t->web.n_group)));
}

/* ---- how it stands on the page ------------------------------------------------------------------ */

/* Bars level or upright, wider than tall, the heavier half below. */
static double stance(const lw_layout_draft *t, lw_vec2 turn)
{
    double cost = 0, top = -1e9, low = 1e9, left = 1e9, right = -1e9, mean = 0;
    int n = t->web.n_vertex;
    for (int i = 0; i < n; i++) {
        lw_vec2 q = lw_v2_turn(t->p[i], turn);
        top = fmax(top, q.y);
        low = fmin(low, q.y);
        left = fmin(left, q.x);
        right = fmax(right, q.x);
        mean += q.y/n;
    }
    for (int i = 0; i < t->web.n_edge; i++) {
        lw_vec2 d = lw_v2_turn(lw_v2_sub(t->p[t->web.edge[i][1]], t->p[t->web.edge[i][0]]), turn);
        double slant = 2*d.x*d.y/fmax(lw_v2_dot(d, d), 1e-12);
        cost += slant*slant/t->web.n_edge;
    }
    double tall = (top - low)/fmax(right - left, 1e-9) - 0.95;
    return cost + 1.5*fmax(0, tall) + 0.6*(mean - (top + low)/2)/fmax(top - low, 1e-9);
}

static void try_stance(const lw_layout_draft *t, lw_vec2 turn, double extra, double *least, lw_vec2 *best)
{
    double cost = stance(t, turn) + extra;
    if (cost < *least - 1e-9) {
        *least = cost;
        *best = turn;
    }
}

/* An axis of symmetry upright, or level where that is much lower; without one a side of the outer loop level. */
void lw_layout_draft_stand_up(lw_layout_draft *t)
{
    double least = 1e9;
    lw_vec2 best = { 1, 0 };
    bool axis = false;
    for (int k = 0; k < t->web.n_group; k++)
        if (t->web.mirror[k]) {
            double turn = LW_PI/2 - atan2(t->web.turn[k].y, t->web.turn[k].x)/2;
            for (int quarter = 0; quarter < 4; quarter++)
                try_stance(t, lw_v2_polar(1, turn + quarter*LW_PI/2), quarter % 2 ? 0.6 : 0, &least, &best);
            axis = true;
        }
    int n = t->web.face_first[1];
    for (int i = 0; !axis && i < n; i++) {
        lw_vec2 d = lw_v2_sub(t->p[t->web.face[(i + 1) % n]], t->p[t->web.face[i]]);
        for (int quarter = 0; quarter < 4; quarter++)
            try_stance(t, lw_v2_polar(1, quarter*LW_PI/2 - atan2(d.y, d.x)), 0, &least, &best);
    }
    for (int i = 0; i < t->web.n_vertex; i++)
        t->p[i] = lw_v2_turn(t->p[i], best);
}

/* ---- all together ------------------------------------------------------------------------------- */

static lw_status lay_out(const lw_mechanism *m, const lw_embedding *way, int n_way, lw_chain_layout *l)
{
    lw_layout_draft *t = calloc((size_t)n_way, sizeof *t);
    int best[2] = { -1, -1 };
    lw_status s = t ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < n_way; i++) {
        s = lw_layout_draft_begin(m, &way[i], &t[i]);
        if (s != LW_OK)
            break;
        t[i].energy = lw_relax_run(&t[i].web, &t[i].relax, FIRST_RUN, t[i].p);
        for (int k = 0, mine = i; k < 2; k++)
            if (mine >= 0 && (best[k] < 0 || score(&t[mine]) < score(&t[best[k]]))) {
                int other = best[k];
                best[k] = mine;
                mine = other;
            }
    }
    for (int k = 0; s == LW_OK && k < 2 && best[k] >= 0; k++)
        t[best[k]].energy = lw_relax_run(&t[best[k]].web, &t[best[k]].relax, LAST_RUN, t[best[k]].p);
    if (s == LW_OK) {
        bool second = best[1] >= 0 && score(&t[best[1]]) < score(&t[best[0]]);
        lw_layout_draft *b = &t[best[second]];
        if (m->ground == LW_NONE)
            lw_layout_draft_stand_up(b);
        lw_layout_draft_places(b, l);
        l->symmetry = b->web.n_group;
    }
    for (int i = 0; t && i < n_way; i++)
        lw_relax_free(&t[i].relax);
    free(t);
    return s;
}

lw_status lw_chain_layout_make(const lw_mechanism *m, lw_chain_layout *l, lw_error *e)
{
    lw_chain c;
    int n_way;
    *l = (lw_chain_layout){ .n_joint = m->n_joint };
    lw_mechanism_chain(m, &c);
    if (m->n_link < 2 || !lw_chain_is_connected(&c))
        return lw_error_set(e, LW_E_ARG, m->n_link < 2 ? "a picture of a chain needs two links or more"
                                                       : "the links do not hang together: draw each part alone");
    lw_embedding *way = malloc(WAYS*sizeof *way);
    lw_status s = way ? lw_ways_find(m, WAYS, way, &n_way) : LW_E_MEMORY;
    l->planar = s == LW_OK;
    if (s == LW_OK)
        s = lay_out(m, way, n_way, l);
    free(way);
    if (s == LW_NOTHING)
        s = lw_layout_crossing(m, l);
    if (s == LW_OK)
        lw_chain_layout_measure(m, l);
    return s == LW_OK ? LW_OK : lw_error_set(e, s, "out of memory for the picture of a chain");
}

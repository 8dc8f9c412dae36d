/* catalogues/draw/chain_layout_cut.c - chains whose graph is not planar
 *
 * A binary link that is cut in two halves leaves two bars with free ends.  Chains are cut at as few binary links
 * as make them planar; each embedding of what is left is drawn, and the bars are put back straight.  The
 * picture with fewest crossings is relaxed; the barrier keeps its crossings as they are. */
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "catalogues/draw/chain_layout_internal.h"
#include "grammar/planar.h"

#define SETS_MAX  6         /* sets of bars that are tried                      */
#define WAYS      6         /* embeddings of each                               */
#define GHOST     14        /* steps while the cut bars pass through everything */
#define LAST_RUN  250
#define MORE      8         /* after a picture with one crossing, and none has less: for evenness */
#define STARTS    24        /* when cutting does not help                       */

typedef struct contest {
    const lw_mechanism *m;           /* pins only */
    lw_layout_draft *trial;                 /* two: */
    lw_layout_draft *now, *best;
    lw_embedding    way[2];                /* of trial[0], trial[1]          */
    int       n_cross;               /* of the best; -1: there is none */
} contest;

/* ---- cutting ------------------------------------------------------------------------------------ */

/* Each cut link keeps its first joint; a new link takes the second.  Joints keep number and sides. */
static bool cut_links(const lw_mechanism *m, uint32_t cut, lw_mechanism *out)
{
    *out = *m;
    if (m->n_link + __builtin_popcount(cut) > LW_LINK_MAX)
        return false;
    for (; cut; cut &= cut - 1)
        for (int j = m->n_joint - 1, i = __builtin_ctz(cut); j >= 0; j--)
            if (m->link[j][0] == i || m->link[j][1] == i) {
                out->link[j][m->link[j][1] == i] = (uint8_t)out->n_link++;
                break;
            }
    return true;
}

/* Is the chain planar without these links? */
static bool helps(const lw_mechanism *m, uint32_t cut)
{
    uint32_t mask[LW_LINK_MAX] = { 0 };
    bool planar = false;
    for (int j = 0; j < m->n_joint; j++)
        if (!((cut >> m->link[j][0] | cut >> m->link[j][1]) & 1)) {
            mask[m->link[j][0]] |= 1u << m->link[j][1];
            mask[m->link[j][1]] |= 1u << m->link[j][0];
        }
    return lw_planar_test(m->n_link, mask, &planar) == LW_OK && planar;
}

static uint32_t bars_of(const lw_mechanism *m)
{
    int n_joint[LW_LINK_MAX] = { 0 };
    uint32_t bars = 0;
    for (int j = 0; j < m->n_joint; j++)
        for (int side = 0; side < 2; side++)
            n_joint[m->link[j][side]]++;
    for (int i = 0; i < m->n_link; i++)
        if (n_joint[i] == 2 && i != m->ground)
            bars |= 1u << i;
    return bars;
}

/* Cut all bars, then mend one after the other, from bar `first` on, as long as the rest stays planar. */
static uint32_t cut_greedily(const lw_mechanism *m, uint32_t bars, int first)
{
    uint32_t cut = bars;
    for (int i = 0; i < m->n_link; i++) {
        uint32_t one = 1u << (first + i) % m->n_link;
        if (cut & one && helps(m, cut & ~one))
            cut &= ~one;
    }
    return helps(m, cut) ? cut : 0;
}

/* Sets of bars to cut, single ones if they do, else pairs, else what the greedy way finds. */
static int sets_of(const lw_mechanism *m, uint32_t *set)
{
    uint32_t bars = bars_of(m);
    int n = 0;
    for (uint32_t a = bars; a && n < SETS_MAX; a &= a - 1)
        if (helps(m, a & -a))
            set[n++] = a & -a;
    bool single = n > 0;
    for (uint32_t a = bars; a && !single; a &= a - 1)
        for (uint32_t b = a & (a - 1); b && n < SETS_MAX; b &= b - 1)
            if (helps(m, (a & -a) | (b & -b)))
                set[n++] = (a & -a) | (b & -b);
    for (int i = 0; n == 0 && i < m->n_link; i++) {
        set[0] = cut_greedily(m, bars, i);
        n += set[0] != 0;
    }
    return n;
}

/* ---- putting back ------------------------------------------------------------------------------- */

/* The embedding of the parts as orders of joints around the links of the whole. */
static void mend(const lw_mechanism *m, const lw_embedding *parts, lw_embedding *whole)
{
    *whole = *parts;
    whole->rings.n_link = m->n_link;
    for (int d = 0; d < whole->rings.n_dart; d++)
        whole->rings.link[d] = m->link[d >> 1][d & 1];
    for (int d = 0; d < whole->rings.n_dart; d++)
        if (parts->rings.link[d] >= m->n_link)
            for (int k = 0; k < whole->rings.n_dart; k++)
                if (k != d && whole->rings.link[k] == whole->rings.link[d]) {
                    whole->rings.after[d] = (uint8_t)k;
                    whole->rings.after[k] = (uint8_t)d;
                }
}

/* The trial is kept when it crosses less than the best, or as little with less energy. */
static void judge(contest *c)
{
    lw_chain_layout l = { .n_joint = c->m->n_joint };
    lw_layout_draft_places(c->now, &l);
    lw_chain_layout_measure(c->m, &l);
    l.n_cross += l.least_gap < 1e-3;                  /* a joint on a bar: nothing would push it away */
    bool better = c->n_cross < 0 || l.n_cross < c->n_cross
               || (l.n_cross == c->n_cross && c->now->energy < c->best->energy);
    if (!better) {
        lw_relax_free(&c->now->relax);
        return;
    }
    lw_layout_draft *t = c->best;
    if (c->n_cross >= 0)
        lw_relax_free(&t->relax);
    c->best = c->now;
    c->now = t;
    c->n_cross = l.n_cross;
}

static lw_embedding *way_of(contest *c, const lw_layout_draft *t)
{
    return &c->way[t - c->trial];
}

/* Draw one embedding of the parts, then the whole with its places. */
static lw_status enter_cut(contest *c, const lw_mechanism *parts, const lw_embedding *way, uint32_t cut)
{
    lw_layout_draft *t = c->now;
    lw_status s = lw_layout_draft_begin(parts, way, t);
    if (s != LW_OK) {
        lw_relax_free(&t->relax);
        return s;
    }
    lw_vec2 p[LW_WEB_VERTEX];
    uint8_t end_of[LW_LINK_MAX];
    memcpy(p, t->p, sizeof p);
    memcpy(end_of, t->web.end_of, sizeof end_of);
    lw_relax_free(&t->relax);
    t->m = c->m;
    t->way = way_of(c, t);
    mend(c->m, way, way_of(c, t));
    lw_web_make(c->m, t->way, &t->web);
    t->web.n_group = 1;
    for (int i = 0; i < c->m->n_link; i++)
        if (t->web.end_of[i] != 255)
            t->p[t->web.end_of[i]] = p[end_of[i]];
    for (int v = 0; v < t->web.n_vertex; v++)            /* no joint exactly on a bar by symmetry */
        t->p[v] = lw_v2_add(t->p[v], lw_v2_polar(0.02, 2.4*v));
    for (int i = 0; i < t->web.n_ground; i++)
        t->p[t->web.ground[i]].y = 0;
    s = lw_relax_make(&t->web, &t->relax);
    if (s != LW_OK)
        return s;
    t->relax.ghost = cut;
    t->energy = lw_relax_run(&t->web, &t->relax, GHOST, t->p);
    t->relax.ghost = 0;
    judge(c);
    return LW_OK;
}

static lw_status try_cuts(contest *c)
{
    uint32_t set[SETS_MAX];
    int n = sets_of(c->m, set);
    int left = MORE;
    lw_embedding *way = malloc(WAYS*sizeof *way);
    lw_status s = way ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < n && left > 0; i++) {
        lw_mechanism parts;
        int n_way;
        if (!cut_links(c->m, set[i], &parts))
            continue;
        s = lw_ways_find(&parts, WAYS, way, &n_way);
        if (s == LW_NOTHING)                             /* in pieces: none */
            s = LW_OK;
        for (int k = 0; s == LW_OK && k < n_way && left > 0; k++) {
            s = enter_cut(c, &parts, &way[k], set[i]);
            left -= c->n_cross == 1;
        }
    }
    free(way);
    return s;
}

/* ---- without an embedding ----------------------------------------------------------------------- */

/* Order the joints of every link by their direction from its middle. */
static void order_by_angle(const lw_mechanism *m, const lw_vec2 *p, lw_rings *r)
{
    for (int i = 0; i < m->n_link; i++) {
        double angle[LW_LINK_MAX];
        uint8_t dart[LW_LINK_MAX];
        lw_vec2 sum = { 0, 0 };
        int n = 0;
        for (int d = 0; d < r->n_dart; d++)
            if (r->link[d] == i) {
                sum = lw_v2_add(sum, p[d >> 1]);
                dart[n++] = (uint8_t)d;
            }
        for (int k = 0; k < n; k++) {
            lw_vec2 q = lw_v2_sub(p[dart[k] >> 1], lw_v2_scale(sum, 1.0/n));
            double a = i == m->ground ? p[dart[k] >> 1].x : atan2(q.y, q.x);
            uint8_t mine = dart[k];
            int at = k;
            for (; at > 0 && angle[at - 1] > a; at--) {
                angle[at] = angle[at - 1];
                dart[at] = dart[at - 1];
            }
            angle[at] = a;
            dart[at] = mine;
        }
        for (int k = 0; k < n; k++)
            r->after[dart[k]] = dart[(k + 1) % n];
    }
}

/* Any rings and places by chance, led to where the springs want them; then the rings that fit. */
static lw_status enter_chance(contest *c, lw_rng *rng)
{
    lw_layout_draft *t = c->now;
    lw_embedding *way = way_of(c, t);
    lw_status s = LW_OK;
    t->m = c->m;
    t->way = way;
    *way = (lw_embedding){ .rings = { .n_link = c->m->n_link, .n_dart = 2*c->m->n_joint } };
    for (int d = 0; d < way->rings.n_dart; d++)
        way->rings.link[d] = c->m->link[d >> 1][d & 1];
    for (int v = 0; v < LW_WEB_VERTEX; v++)
        t->p[v] = lw_v2(lw_rng_range(rng, -2, 2), lw_rng_range(rng, 0.5, 3));
    for (int pass = 0; s == LW_OK && pass < 2; pass++) {
        order_by_angle(c->m, t->p, &way->rings);
        for (int d = 0; d < way->rings.n_dart; d++)
            if (way->rings.link[d ^ 1] == c->m->ground && (c->m->ground == LW_NONE
                || t->p[d >> 1].x > t->p[way->rings.after[d ^ 1] >> 1].x))
                way->outer = (uint8_t)d;                       /* arrives at the rightmost joint of the ground */
        lw_web_make(c->m, way, &t->web);
        t->web.n_group = 1;
        for (int i = 0; i < t->web.n_ground; i++)
            t->p[t->web.ground[i]].y = 0;
        s = lw_relax_make(&t->web, &t->relax);
        t->relax.ghost = UINT32_MAX;
        if (s == LW_OK)
            t->energy = lw_relax_run(&t->web, &t->relax, 60, t->p);
        t->relax.ghost = 0;
        if (pass == 0)
            lw_relax_free(&t->relax);
    }
    if (s == LW_OK)
        judge(c);
    return s;
}

lw_status lw_layout_crossing(const lw_mechanism *m, lw_chain_layout *l)
{
    lw_mechanism pins = *m;
    lw_rng rng;
    lw_layout_draft *t = calloc(2, sizeof *t);
    contest c = { .m = &pins, .n_cross = -1, .trial = t, .now = t, .best = t + 1 };
    memset(pins.kind, 'r', sizeof pins.kind);
    lw_rng_seed(&rng, 1, 0);
    lw_status s = t ? try_cuts(&c) : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && c.n_cross < 0 && i < STARTS; i++)
        s = enter_chance(&c, &rng);
    if (s == LW_OK) {
        c.best->energy = lw_relax_run(&c.best->web, &c.best->relax, LAST_RUN, c.best->p);
        if (m->ground == LW_NONE)
            lw_layout_draft_stand_up(c.best);
        lw_layout_draft_places(c.best, l);
        l->symmetry = 1;
    }
    if (t && c.n_cross >= 0)
        lw_relax_free(&c.best->relax);
    free(t);
    return s;
}

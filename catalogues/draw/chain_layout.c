/* catalogues/draw/chain_layout.c - the layout of a chain: choice of the embedding, orientation on the page, and chains
 * whose graph is not planar. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/rng.h"
#include "catalogues/draw/chain_layout_internal.h"
#include "grammar/topology/planar.h"

/* One embedding with its web and places. */
typedef struct draft {
    const lw_mechanism *m;
    const lw_embedding *embedding;
    lw_web   web;
    lw_relax relax;                      /* free it by lw_relax_free */
    lw_vec2  p[LW_WEB_VERTEX];
    double   energy;
} draft;

/* ==== measures of a picture =================================================================================== */

static int outline_of(const lw_chain_layout *l, int link, lw_vec2 *p)
{
    int n = 0;
    for (int k = l->first[link]; k < l->first[link + 1]; k++)
        p[n++] = l->at[l->ring[k]];
    if (n == 1)
        p[n++] = l->end[link];
    return n;
}

/* Do the segments a b and c d cross? Also true when an end of one lies on the other. */
static bool segments_cross(lw_vec2 a, lw_vec2 b, lw_vec2 c, lw_vec2 d)
{
    lw_vec2 u = lw_v2_sub(b, a), v = lw_v2_sub(d, c);
    double s1 = lw_v2_cross(u, lw_v2_sub(c, a)), s2 = lw_v2_cross(u, lw_v2_sub(d, a));
    double s3 = lw_v2_cross(v, lw_v2_sub(a, c)), s4 = lw_v2_cross(v, lw_v2_sub(b, c));
    return s1*s2 < 0 && s3*s4 < 0;
}

static bool inside(const lw_vec2 *p, int n, lw_vec2 q)
{
    bool in = false;
    for (int i = 0, k = n - 1; n > 2 && i < n; k = i++)
        if ((p[i].y > q.y) != (p[k].y > q.y) && q.x < p[i].x + (q.y - p[i].y)*(p[k].x - p[i].x)/(p[k].y - p[i].y))
            in = !in;
    return in;
}

static int sides(int n)
{
    return n > 2 ? n : n - 1;
}

/* Corners that two links share are joints (or merged blocks) and do not count as crossings. */
static bool same_place(lw_vec2 a, lw_vec2 b)
{
    return a.x == b.x && a.y == b.y;
}

static bool links_cross(const lw_vec2 *p, int n, const lw_vec2 *q, int k, bool itself)
{
    for (int i = 0; i < sides(n); i++)
        for (int j = 0; j < sides(k); j++) {
            lw_vec2 a = p[i], b = p[(i + 1) % n], c = q[j], d = q[(j + 1) % k];
            bool touch = same_place(a, c) || same_place(a, d) || same_place(b, c) || same_place(b, d);
            if (!touch && segments_cross(a, b, c, d))
                return true;
        }
    for (int pass = 0; pass < 2 && !itself; pass++) {
        const lw_vec2 *out = pass ? q : p, *in = pass ? p : q;
        int n_out = pass ? k : n, n_in = pass ? n : k;
        for (int i = 0; i < n_in; i++) {
            bool corner = false;
            for (int j = 0; j < n_out; j++)
                corner = corner || same_place(out[j], in[i]);
            if (!corner && inside(out, n_out, in[i]))
                return true;
        }
    }
    return false;
}

/* Least angle between a side of one link and a side of the other at a corner they share. itself: both are the same
 * link; take the angles at its own corners. */
static double least_angle(const lw_vec2 *p, int n, const lw_vec2 *q, int k, bool itself)
{
    double least = LW_PI;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < k; j++) {
            if (!same_place(p[i], q[j]))
                continue;
            for (int embedding = 0; embedding < 4; embedding++) {
                int a = (i + (embedding & 1 ? 1 : n - 1)) % n, b = (j + (embedding & 2 ? 1 : k - 1)) % k;
                lw_vec2 u = lw_v2_sub(p[a], p[i]), v = lw_v2_sub(q[b], q[j]);
                if (itself && (a == b || n < 3))
                    continue;
                least = fmin(least, fabs(atan2(lw_v2_cross(u, v), lw_v2_dot(u, v))));
            }
        }
    return least;
}

/* Least squared distance between two joints, or between a joint and a link without it. */
static double least_gap2(const lw_chain_layout *l, const lw_vec2 *p, int n)
{
    double least = 1e18;
    for (int i = 0; i < sides(n); i++)
        for (int j = 0; j < l->n_joint; j++) {
            lw_vec2 a = p[i], b = p[(i + 1) % n];
            if (same_place(a, l->at[j]) || same_place(b, l->at[j]))
                continue;
            lw_vec2 off = lw_v2_off_segment(l->at[j], a, b);
            double d2 = lw_v2_dot(off, off);
            least = d2 < least ? d2 : least;
        }
    return least;
}

/* Compute n_cross, least_angle and least_gap of the places in l. */
static void measure_layout(const lw_mechanism *m, lw_chain_layout *l)
{
    lw_vec2 p[LW_LINK_MAX + 1], q[LW_LINK_MAX + 1];
    double length = 0;
    int n_side = 0;
    l->n_cross = 0;
    l->least_angle = LW_PI;
    l->least_gap = 1e9;
    for (int i = 0; i < m->n_link; i++) {
        int n = outline_of(l, i, p);
        if (i == m->ground || l->axes >> i & 1 || (n == 2 && same_place(p[0], p[1])))
            continue;
        for (int k = 0; k < sides(n); k++, n_side++)
            length += lw_v2_norm(lw_v2_sub(p[(k + 1) % n], p[k]));
        l->least_gap = fmin(l->least_gap, sqrt(least_gap2(l, p, n)));
        for (int k = i; k < m->n_link; k++) {
            int n_other = outline_of(l, k, q);
            if (k == m->ground || l->axes >> k & 1 || (n_other == 2 && same_place(q[0], q[1])))
                continue;
            l->n_cross += links_cross(p, n, q, n_other, k == i);
            l->least_angle = fmin(l->least_angle, least_angle(p, n, q, n_other, k == i));
        }
    }
    l->least_gap *= n_side/fmax(length, 1e-9);
}

/* ==== a draft ================================================================================================= */

#define EMBEDDINGS_MAX 8      /* embeddings that are drawn at all */
#define FIRST_RUN  30         /* steps for each of them           */
#define LAST_RUN   400        /* steps for the best one           */

static void copy_places(const draft *t, lw_chain_layout *l)
{
    const lw_mechanism *m = t->m;
    const lw_embedding *embedding = t->embedding;
    const lw_web *w = &t->web;
    const lw_vec2 *p = t->p;
    l->n_joint = m->n_joint;
    l->axes = embedding->rings.axes;
    for (int j = 0; j < m->n_joint; j++)
        l->at[j] = p[w->vertex_of[j]];
    for (int i = 0; i < m->n_link; i++) {
        int first = -1, n = l->first[i], d;
        for (d = embedding->rings.n_dart - 1; d >= 0; d--)
            if (embedding->rings.link[d] == i)
                first = d;
        if (i == m->ground)
            first = embedding->rings.after[embedding->outer ^ 1];
        d = first;
        do
            l->ring[n++] = (uint8_t)(d >> 1);
        while ((d = embedding->rings.after[d]) != first);
        l->first[i + 1] = n;
        l->end[i] = w->end_of[i] != 255 ? p[w->end_of[i]] : l->at[first >> 1];
    }
}

/* ---- which is best ------------------------------------------------------------------------------ */

static lw_status begin_draft(const lw_mechanism *m, const lw_embedding *embedding, draft *t)
{
    t->m = m;
    t->embedding = embedding;
    lw_web_make(m, embedding, &t->web);
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

/* Smaller is better: any symmetry comes before none, then the energy counts, reduced a little for more symmetry. */
static double score(const draft *t)
{
    return t->energy*(1 - 0.1*fmin(2, log2(t->web.n_group))) + (t->web.n_group > 1 ? 0 : 1e6);
}

/* ---- how it stands on the page ------------------------------------------------------------------ */

/* Smaller is better: bars horizontal or vertical, picture wider than tall, the heavier half below. */
static double stance(const draft *t, lw_vec2 turn)
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

static void try_stance(const draft *t, lw_vec2 turn, double extra, double *least, lw_vec2 *best)
{
    double cost = stance(t, turn) + extra;
    if (cost < *least - 1e-9) {
        *least = cost;
        *best = turn;
    }
}

/* Turn the picture: an axis of symmetry vertical, or horizontal where the picture is much lower that way. Without
 * symmetry, one side of the outer loop is horizontal. */
static void stand_up(draft *t)
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

/* ==== chains whose graph is not planar ======================================================================== */

#define SETS_MAX  24        /* sets of bars that are tried, and embeddings for each: few at first, then many */
#define CUT_EMBEDDINGS 40
#define FEW       6
#define GHOST     14        /* steps in which the cut bars repel nothing */
#define CUT_RUN  250
#define MORE      8       /* further trials for an even picture once one crossing is reached and fewer are impossible */
#define STARTS    24        /* random starts, when cutting does not help        */

typedef struct contest {
    const lw_mechanism *m;           /* pins only */
    uint32_t axes;                   /* of m: see lw_rings */
    draft *trial;                 /* (2) */
    draft *now, *best;
    lw_embedding    embedding[2];                /* of trial[0], trial[1]          */
    int       n_cross;               /* of the best; -1: none yet */
} contest;

/* ---- cutting ------------------------------------------------------------------------------------ */

/* Cut links: each keeps its first joint, a new link takes the second one. Joints keep their number and sides. */
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

/* Cut all bars, then restore one after the other, beginning with bar `first`, while the rest stays planar. */
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

/* Find sets of bars to cut: single bars if one is enough, else pairs, else what cut_greedily finds. */
static int sets_of(const lw_mechanism *m, int most, uint32_t *set)
{
    uint32_t bars = bars_of(m);
    int n = 0;
    for (uint32_t a = bars; a && n < most; a &= a - 1)
        if (helps(m, a & -a))
            set[n++] = a & -a;
    bool single = n > 0;
    for (uint32_t a = bars; a && !single; a &= a - 1)
        for (uint32_t b = a & (a - 1); b && n < most; b &= b - 1)
            if (helps(m, (a & -a) | (b & -b)))
                set[n++] = (a & -a) | (b & -b);
    for (int i = 0; n == 0 && i < m->n_link; i++) {
        set[0] = cut_greedily(m, bars, i);
        n += set[0] != 0;
    }
    return n;
}

/* ---- putting back ------------------------------------------------------------------------------- */

/* Turn the embedding of the cut chain into orders of joints around the links of the whole chain. */
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

/* Keep the trial if it has fewer crossings than the best, or as many with less energy. */
static void judge(contest *c)
{
    lw_chain_layout l = { .n_joint = c->m->n_joint };
    copy_places(c->now, &l);
    measure_layout(c->m, &l);
    l.n_cross += l.least_gap < 1e-3;                  /* a joint on a bar: nothing would push it away */
    bool better = c->n_cross < 0 || l.n_cross < c->n_cross
               || (l.n_cross == c->n_cross && c->now->energy < c->best->energy);
    if (!better) {
        lw_relax_free(&c->now->relax);
        return;
    }
    draft *t = c->best;
    if (c->n_cross >= 0)
        lw_relax_free(&t->relax);
    c->best = c->now;
    c->now = t;
    c->n_cross = l.n_cross;
}

static lw_embedding *way_of(contest *c, const draft *t)
{
    return &c->embedding[t - c->trial];
}

/* Draw one embedding of the cut chain, then the whole chain from those places. */
static lw_status enter_cut(contest *c, const lw_mechanism *parts, const lw_embedding *embedding, uint32_t cut)
{
    draft *t = c->now;
    lw_status s = begin_draft(parts, embedding, t);
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
    t->embedding = way_of(c, t);
    mend(c->m, embedding, way_of(c, t));
    lw_web_make(c->m, t->embedding, &t->web);
    t->web.n_group = 1;
    for (int i = 0; i < c->m->n_link; i++)
        if (t->web.end_of[i] != 255)
            t->p[t->web.end_of[i]] = p[end_of[i]];
    for (int v = 0; v < t->web.n_vertex; v++)       /* small offsets, so that symmetry puts no joint exactly on a bar */
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

static lw_status try_cuts(contest *c, int n_set, int n_try)
{
    uint32_t set[SETS_MAX];
    int n = sets_of(c->m, n_set, set);
    int left = MORE;
    lw_embedding *embedding = malloc((size_t)n_try*sizeof *embedding);
    lw_status s = embedding ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < n && left > 0; i++) {
        lw_mechanism parts;
        int n_embedding;
        if (!cut_links(c->m, set[i], &parts))
            continue;
        s = lw_embeddings_find(&parts, c->axes, n_try, embedding, &n_embedding);
        if (s == LW_NOTHING)                             /* the cut chain falls apart: no embedding */
            s = LW_OK;
        for (int k = 0; s == LW_OK && k < n_embedding && left > 0; k++) {
            s = enter_cut(c, &parts, &embedding[k], set[i]);
            left -= c->n_cross == 1;
        }
    }
    free(embedding);
    return s;
}

/* ---- without an embedding ----------------------------------------------------------------------- */

/* Order the joints of every link by their direction from the link's centre. */
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

/* Start from random rings and places, let the springs move them, then take the rings that fit the result. */
static lw_status enter_chance(contest *c, lw_rng *rng)
{
    draft *t = c->now;
    lw_embedding *embedding = way_of(c, t);
    lw_status s = LW_OK;
    t->m = c->m;
    t->embedding = embedding;
    *embedding = (lw_embedding){ .rings = { .n_link = c->m->n_link, .n_dart = 2*c->m->n_joint, .axes = c->axes } };
    for (int d = 0; d < embedding->rings.n_dart; d++)
        embedding->rings.link[d] = c->m->link[d >> 1][d & 1];
    for (int v = 0; v < LW_WEB_VERTEX; v++)
        t->p[v] = lw_v2(lw_rng_range(rng, -2, 2), lw_rng_range(rng, 0.5, 3));
    for (int pass = 0; s == LW_OK && pass < 2; pass++) {
        order_by_angle(c->m, t->p, &embedding->rings);
        for (int d = 0; d < embedding->rings.n_dart; d++)
            if (embedding->rings.link[d ^ 1] == c->m->ground && (c->m->ground == LW_NONE
                || t->p[d >> 1].x > t->p[embedding->rings.after[d ^ 1] >> 1].x))
                embedding->outer = (uint8_t)d;                       /* arrives at the rightmost joint of the ground */
        lw_web_make(c->m, embedding, &t->web);
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

static lw_status lay_out_nonplanar(const lw_mechanism *m, uint32_t axes, lw_chain_layout *l)
{
    lw_mechanism pins = *m;
    lw_rng rng;
    draft *t = calloc(2, sizeof *t);
    contest c = { .m = &pins, .axes = axes, .n_cross = -1, .trial = t, .now = t, .best = t + 1 };
    memset(pins.kind, 'r', sizeof pins.kind);
    lw_rng_seed(&rng, 1, 0);
    lw_status s = t ? try_cuts(&c, FEW, FEW) : LW_E_MEMORY;
    if (s == LW_OK && c.n_cross > 1)
        s = try_cuts(&c, SETS_MAX, CUT_EMBEDDINGS);
    for (int i = 0; s == LW_OK && c.n_cross < 0 && i < STARTS; i++)
        s = enter_chance(&c, &rng);
    if (s == LW_OK) {
        c.best->energy = lw_relax_run(&c.best->web, &c.best->relax, CUT_RUN, c.best->p);
        if (m->ground == LW_NONE)
            stand_up(c.best);
        copy_places(c.best, l);
        l->symmetry = 1;
    }
    if (t && c.n_cross >= 0)
        lw_relax_free(&c.best->relax);
    free(t);
    return s;
}

/* ==== all together ============================================================================================ */


static lw_status lay_out(const lw_mechanism *m, const lw_embedding *embedding, int n_embedding, lw_chain_layout *l)
{
    draft *t = calloc((size_t)n_embedding, sizeof *t);
    int best[2] = { -1, -1 };
    lw_status s = t ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < n_embedding; i++) {
        s = begin_draft(m, &embedding[i], &t[i]);
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
        draft *b = &t[best[second]];
        if (m->ground == LW_NONE)
            stand_up(b);
        copy_places(b, l);
        l->symmetry = b->web.n_group;
    }
    for (int i = 0; t && i < n_embedding; i++)
        lw_relax_free(&t[i].relax);
    free(t);
    return s;
}

lw_status lw_chain_layout_make(const lw_mechanism *m, lw_chain_layout *l, lw_error *e)
{
    return lw_axes_layout_make(m, 0, l, e);
}

lw_status lw_axes_layout_make(const lw_mechanism *m, uint32_t axes, lw_chain_layout *l, lw_error *e)
{
    lw_chain c;
    int n_embedding;
    *l = (lw_chain_layout){ .n_joint = m->n_joint, .axes = axes };
    lw_mechanism_chain(m, &c);
    if (m->n_link < 2 || !lw_chain_is_connected(&c))
        return lw_error_set(e, LW_E_ARG, m->n_link < 2 ? "a picture of a chain needs two links or more"
                                                       : "the links do not hang together: draw each part alone");
    lw_embedding *embedding = malloc(EMBEDDINGS_MAX*sizeof *embedding);
    lw_status s = embedding ? lw_embeddings_find(m, axes, EMBEDDINGS_MAX, embedding, &n_embedding) : LW_E_MEMORY;
    l->planar = s == LW_OK;
    if (s == LW_OK)
        s = lay_out(m, embedding, n_embedding, l);
    free(embedding);
    if (s == LW_NOTHING)
        s = lay_out_nonplanar(m, axes, l);
    if (s == LW_OK)
        measure_layout(m, l);
    return s == LW_OK ? LW_OK : lw_error_set(e, s, "out of memory for the picture of a chain");
}

/* catalogues/draw/chain_embedding.c - embeddings of a chain in the plane, and the choice of the outer loop. */
#include <string.h>

#include "catalogues/draw/chain_layout_internal.h"
#include "grammar/topology/planar.h"

/* If there are at most this many orders of joints around the links, all are tried (12 links have up to 14400); else
 * only the order that libplanarity gives. */
#define ORDERS_MAX 20000

#define CODE_MAX (2*LW_DART_MAX + LW_LINK_MAX)

int lw_rings_loops(const lw_rings *r, uint8_t *loop_of)
{
    uint64_t seen[2] = { 0, 0 };
    int n = 0;
    for (int first = 0; first < r->n_dart; first++) {
        if (seen[first >> 6] >> (first & 63) & 1)
            continue;
        for (int d = first; !(seen[d >> 6] >> (d & 63) & 1); d = r->after[d ^ 1]) {
            seen[d >> 6] |= (uint64_t)1 << (d & 63);
            if (loop_of)
                loop_of[d] = (uint8_t)n;
        }
        n++;
    }
    return n;
}

static void invert(const lw_rings *r, uint8_t *before)
{
    for (int d = 0; d < r->n_dart; d++)
        before[r->after[d]] = (uint8_t)d;
}

/* Describe the map as seen from dart `start`, turning by `next` around every link. Equal descriptions from two starts
 * mean a symmetry. seen: the darts in the order met. */
static int describe(const lw_mechanism *m, const lw_rings *r, const uint8_t *next, int start, uint8_t *code, uint8_t *seen)
{
    uint8_t number[LW_LINK_MAX], entry[LW_LINK_MAX];
    uint32_t met = 1u << r->link[start];
    int n_link = 1, n = 0, n_seen = 0;
    number[r->link[start]] = 0;
    entry[0] = (uint8_t)start;
    for (int k = 0; k < n_link; k++) {
        int d = entry[k];
        code[n++] = r->link[d] == m->ground ? 255 : r->axes >> r->link[d] & 1 ? 253 : 254;      /* a link begins */
        do {
            int other = r->link[d ^ 1];
            if (!(met >> other & 1)) {
                met |= 1u << other;
                number[other] = (uint8_t)n_link;
                entry[n_link++] = (uint8_t)(d ^ 1);
            }
            code[n++] = number[other];
            code[n++] = (uint8_t)m->kind[d >> 1];
            seen[n_seen++] = (uint8_t)d;
            d = next[d];
        } while (d != entry[k]);
    }
    return n;
}

typedef struct start { uint8_t dart; bool mirror; } start;

/* List the starts that keep the outer loop: each of its darts, in both orientations; with a ground only the darts at
 * its corner. */
static int starts_of(const lw_mechanism *m, const lw_embedding *w, start *s)
{
    const uint8_t *after = w->rings.after;
    int n = 0, d = w->outer;
    if (m->ground != LW_NONE) {
        s[n++] = (start){ w->outer, false };
        s[n++] = (start){ after[w->outer ^ 1] ^ 1, true };
        return n;
    }
    do {
        s[n++] = (start){ (uint8_t)d, false };
        s[n++] = (start){ (uint8_t)(d ^ 1), true };
        d = after[d ^ 1];
    } while (d != w->outer);
    return n;
}

void lw_embedding_symmetry(const lw_mechanism *m, const lw_embedding *w, lw_layout_symmetry *g)
{
    start s[2*LW_DART_MAX];
    uint8_t before[LW_DART_MAX], code[2][CODE_MAX], seen[2][LW_DART_MAX];
    int n = starts_of(m, w, s);
    invert(&w->rings, before);
    g->n = 0;
    for (int i = 0; i < n && g->n < LW_WEB_GROUP; i++) {
        int k = i > 0;
        int size = describe(m, &w->rings, s[i].mirror ? before : w->rings.after, s[i].dart, code[k], seen[k]);
        if (k && memcmp(code[0], code[1], (size_t)size) != 0)
            continue;
        for (int d = 0; d < w->rings.n_dart; d++)
            g->to[g->n][seen[0][d]] = seen[k][d];
        g->mirror[g->n++] = s[i].mirror;
    }
}

/* Hash the least description (FNV-1a) and count how often it occurs. */
static void characterise(const lw_mechanism *m, lw_embedding *w)
{
    start s[2*LW_DART_MAX];
    uint8_t before[LW_DART_MAX], least[CODE_MAX], code[CODE_MAX], seen[LW_DART_MAX];
    int n = starts_of(m, w, s), size = 0;
    invert(&w->rings, before);
    for (int i = 0; i < n; i++) {
        size = describe(m, &w->rings, s[i].mirror ? before : w->rings.after, s[i].dart, code, seen);
        int order = i ? memcmp(code, least, (size_t)size) : -1;
        if (order < 0) {
            memcpy(least, code, (size_t)size);
            w->symmetry = 0;
        }
        w->symmetry += order <= 0;
    }
    w->hash = 0xcbf29ce484222325u;
    for (int i = 0; i < size; i++)
        w->hash = (w->hash ^ least[i])*0x100000001b3u;
}

#define SYMMETRIC 1000.0     /* symmetric pictures come before all others */

/* Prefer symmetry, then a long outer loop and inner loops of similar length. */
static double promise_of(const lw_embedding *w, const int *length)
{
    double sum = 0, inner = w->rings.n_dart - w->n_outer, mean = inner/fmax(1, w->n_loop - 1);
    for (int i = 0; i < w->n_loop; i++)
        sum += (length[i] - mean)*(length[i] - mean);
    sum -= (w->n_outer - mean)*(w->n_outer - mean);
    return sqrt(sum) - w->n_outer - 1.5*log2(w->symmetry) - (w->symmetry > 1 ? SYMMETRIC : 0);
}

typedef struct finder {
    const lw_mechanism *m;
    int     capacity, n;
    lw_embedding *embedding;
} finder;

/* Insert w in the list of embeddings by promise, unless it is there already or promises too little. */
static void offer(finder *f, const lw_embedding *w)
{
    int at = f->n;
    for (int i = 0; i < f->n; i++)
        if (f->embedding[i].hash == w->hash)
            return;
    while (at > 0 && f->embedding[at - 1].promise > w->promise)
        at--;
    if (at == f->capacity)
        return;
    f->n += f->n < f->capacity;
    memmove(f->embedding + at + 1, f->embedding + at, (size_t)(f->n - at - 1)*sizeof *w);
    f->embedding[at] = *w;
}

/* Offer every loop, or with a ground every corner of it, as the outer one. */
static void offer_loops(finder *f, const lw_rings *r)
{
    uint8_t loop_of[LW_DART_MAX];
    int length[LW_DART_MAX] = { 0 }, ground = f->m->ground;
    lw_embedding w = { .rings = *r };
    uint64_t done[2] = { 0, 0 };
    w.n_loop = lw_rings_loops(r, loop_of);
    for (int d = 0; d < r->n_dart; d++)
        length[loop_of[d]]++;
    for (int d = 0; d < r->n_dart; d++) {
        int loop = loop_of[d];
        if (ground == LW_NONE ? done[loop >> 6] >> (loop & 63) & 1 : r->link[d ^ 1] != ground)
            continue;
        done[loop >> 6] |= (uint64_t)1 << (loop & 63);
        w.outer = (uint8_t)d;
        w.n_outer = length[loop];
        characterise(f->m, &w);
        w.promise = promise_of(&w, length);
        offer(f, &w);
    }
}

/* ---- all orders around all links ---------------------------------------------------------------- */

typedef struct orders {
    lw_rings rings;
    int      n[LW_LINK_MAX];
    uint8_t  dart[LW_LINK_MAX][LW_LINK_MAX];      /* around each link, ascending at first */
} orders;

static void set_ring(orders *o, int link)
{
    for (int k = 0; k < o->n[link]; k++)
        o->rings.after[o->dart[link][k]] = o->dart[link][(k + 1) % o->n[link]];
}

static void first_orders(const lw_mechanism *m, uint32_t axes, orders *o)
{
    *o = (orders){ .rings = { .n_link = m->n_link, .n_dart = 2*m->n_joint, .axes = axes } };
    for (int d = 0; d < 2*m->n_joint; d++) {
        int link = m->link[d >> 1][d & 1];
        o->rings.link[d] = (uint8_t)link;
        o->dart[link][o->n[link]++] = (uint8_t)d;
    }
    for (int i = 0; i < m->n_link; i++)
        set_ring(o, i);
}

/* Go to the next order (lexicographic) of darts 1 .. n-1 of a link. False: back at the first order. */
static bool next_order(orders *o, int link)
{
    uint8_t *a = o->dart[link] + 1;
    int n = o->n[link] - 1, i = n - 2;
    while (i >= 0 && a[i] > a[i + 1])
        i--;
    if (i >= 0) {
        int k = n - 1;
        while (a[k] < a[i])
            k--;
        uint8_t t = a[i];
        a[i] = a[k];
        a[k] = t;
    }
    for (int lo = i + 1, hi = n - 1; lo < hi; lo++, hi--) {
        uint8_t t = a[lo];
        a[lo] = a[hi];
        a[hi] = t;
    }
    set_ring(o, link);
    return i >= 0;
}

static bool few_orders(const orders *o)
{
    double n = 1;
    for (int i = 0; i < o->rings.n_link; i++)
        for (int k = 2; k < o->n[i]; k++)
            n *= k;
    return n <= ORDERS_MAX;
}

static void try_all_orders(finder *f, orders *o)
{
    const int wanted = f->m->n_joint - f->m->n_link + 2;                    /* Euler */
    int first = 0, link;
    while (first < o->rings.n_link && o->n[first] < 3)
        first++;
    do {
        /* skip mirror images: in one of the two maps the first such link is turned over */
        bool mirrored = first < o->rings.n_link && o->dart[first][1] > o->dart[first][o->n[first] - 1];
        if (!mirrored && lw_rings_loops(&o->rings, NULL) == wanted)
            offer_loops(f, &o->rings);
        for (link = 0; link < o->rings.n_link && !next_order(o, link); link++)
            ;
    } while (link < o->rings.n_link);
}

/* ---- the one of libplanarity -------------------------------------------------------------------- */

static lw_status try_one_order(finder *f, orders *o)
{
    uint32_t mask[LW_LINK_MAX] = { 0 };
    uint8_t dart[LW_LINK_MAX][LW_LINK_MAX];
    lw_regions region;
    for (int d = 0; d < o->rings.n_dart; d++) {
        mask[o->rings.link[d]] |= 1u << o->rings.link[d ^ 1];
        dart[o->rings.link[d]][o->rings.link[d ^ 1]] = (uint8_t)d;
    }
    lw_status s = lw_planar_regions(o->rings.n_link, mask, &region);
    for (int i = 0; s == LW_OK && i < region.n_region; i++) {
        const uint8_t *v = region.vertex + region.first[i];
        int n = region.first[i + 1] - region.first[i];
        for (int k = 0; k < n; k++) {
            int at = v[(k + 1) % n];
            o->rings.after[dart[at][v[k]]] = dart[at][v[(k + 2) % n]];
        }
    }
    if (s == LW_OK)
        offer_loops(f, &o->rings);
    return s;
}

lw_status lw_embeddings_find(const lw_mechanism *m, uint32_t axes, int capacity, lw_embedding *embedding, int *n_embedding)
{
    orders o;
    finder f = { .m = m, .capacity = capacity, .embedding = embedding };
    lw_status s = LW_OK;
    first_orders(m, axes, &o);
    if (few_orders(&o))
        try_all_orders(&f, &o);
    else
        s = try_one_order(&f, &o);
    *n_embedding = f.n;
    return s == LW_OK && f.n == 0 ? LW_NOTHING : s;
}

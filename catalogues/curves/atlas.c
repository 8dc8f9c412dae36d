/* catalogues/curves/atlas.c - segments of an atlas: threads draw many random curves, which are then sorted into blocks.
 */
#include "catalogues/curves/atlas.h"

#include <stdlib.h>
#include <string.h>
#include "base/parallel.h"
#include "base/real.h"
#include "optimise/solvers/lowdiscrepancy.h"

#define CHUNK 512                      /* samples per job */
#define TRIES 5
#define FAILED 3                       /* memory ran out for a sample */
#define GOOD_TRANSMISSION (LW_PI/6)    /* the transmission angle that textbooks ask for at least [rad] */

/* The same layout as in the file, docs/catalogue.md. */
_Static_assert(sizeof(lw_packed) == 64 && sizeof(lw_curve_row) == 36 && sizeof(lw_curve_box) == 68, "file layout");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "catalogues are little-endian; swap bytes in store_rows.c");

typedef struct job {
    const lw_curve_maker *maker;
    lw_atlas_kinds        kinds;
    size_t                n;
    const double         *u;           /* (n*LW_CURVE_DRAWS)              */
    lw_curve_work       **work;        /* one per thread                  */
    unsigned char        *good;        /* (n) 0: no curve, 1: closed, 2: open, FAILED */
    lw_packed            *terms;       /* (n)                             */
    lw_curve_row         *row;         /* (n)                             */
    const volatile int   *stop;
} job;

/* Draw sample i at u. False: no curve. */
static bool draw_one(job *j, size_t i, const double *u, bool closed, lw_curve_work *work, lw_curve_traits *traits)
{
    lw_vec2 p[LW_CURVE_POINTS];
    lw_descriptor d;
    lw_curve_row row;
    lw_curve_traits t;
    lw_status status = lw_curve_draw(j->maker, u, closed, work, &row);
    if (status == LW_OK)
        status = lw_curve_points(j->maker, &row, closed, work, p, &t);
    if (status < 0)
        j->good[i] = FAILED;
    if (status != LW_OK || j->good[i] == FAILED || lw_descriptor_make(p, LW_CURVE_POINTS, closed, &d) != LW_OK)
        return false;
    j->good[i] = closed ? 1 : 2;
    j->row[i] = row;
    *traits = t;
    lw_curve_row_note(&j->row[i], &t);
    lw_descriptor_pack(&d, &j->terms[i]);
    return true;
}

/* Half of the samples are for designers: a linkage whose input does not turn or whose transmission angle is too small is
 * drawn again, from other random numbers, up to TRIES times.  The last curve drawn stays. */
static void draw_chunk(void *context, size_t chunk, int thread)
{
    job *j = context;
    lw_curve_work *work = j->work[thread];
    for (size_t i = chunk*CHUNK; i < j->n && i < (chunk + 1)*CHUNK; i++) {
        bool closed = j->kinds == LW_ATLAS_CLOSED || (j->kinds == LW_ATLAS_BOTH && i%2 == 0);
        lw_curve_traits traits = { 0 };
        double u[LW_CURVE_DRAWS];
        lw_rng rng;
        if (j->stop && *j->stop) {
            j->good[i] = FAILED;
            continue;
        }
        j->good[i] = 0;
        memcpy(u, j->u + i*LW_CURVE_DRAWS, sizeof u);
        lw_rng_seed(&rng, (uint64_t)(u[1]*0x1p53), 0x64657369u);
        /* a random choice, since the place in Sobol's sequence fixes the first digits of u */
        bool chosen = lw_rng_uniform(&rng) < 0.5;
        draw_one(j, i, u, closed, work, &traits);
        for (int n = 0; chosen && n < TRIES && !(traits.turns && traits.transmission >= GOOD_TRANSMISSION); n++) {
            for (int k = 0; k < LW_CURVE_DRAWS; k++)
                u[k] = lw_rng_uniform(&rng);
            draw_one(j, i, u, closed, work, &traits);
        }
    }
}

/* ---- blocks ---------------------------------------------------------------------------------------- */

typedef struct sizes { uint16_t v[LW_TERMS]; } sizes;

static sizes sizes_of(const lw_packed *p)
{
    float v[LW_TERMS];
    sizes s;
    lw_packed_size(p, v);
    for (int k = 0; k < LW_TERMS; k++)
        s.v[k] = (uint16_t)(v[k]*(float)LW_TERM_ONE + 0.5f);
    return s;
}

/* Move the m smallest of n different keys to the front (Hoare's Find, 1961). */
static void select_first(uint64_t *key, size_t n, size_t m)
{
    ptrdiff_t lo = 0, hi = (ptrdiff_t)n - 1, index = (ptrdiff_t)m;
    while (lo < hi) {
        uint64_t pivot = key[lo + (hi - lo)/2];
        ptrdiff_t i = lo, j = hi;
        while (i <= j) {
            while (key[i] < pivot)
                i++;
            while (key[j] > pivot)
                j--;
            if (i <= j) {
                uint64_t t = key[i];
                key[i++] = key[j];
                key[j--] = t;
            }
        }
        if (index <= j)
            hi = j;
        else if (index >= i)
            lo = i;
        else
            return;
    }
}

typedef struct sorting {
    const sizes  *size;
    uint64_t     *key;
    uint32_t     *order;
    lw_curve_box *box;
    size_t        n_block;
} sorting;

static lw_curve_box box_of(const sorting *s, const uint32_t *order, size_t n)
{
    lw_curve_box b = { .n = (uint32_t)n };
    memset(b.least, 0xff, sizeof b.least);
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < LW_TERMS; k++) {
            uint16_t v = s->size[order[i]].v[k];
            b.least[k] = v < b.least[k] ? v : b.least[k];
            b.most[k] = v > b.most[k] ? v : b.most[k];
        }
    return b;
}

/* Halve until a block is small enough; all blocks but the last are full. */
static void sort_blocks(sorting *s, size_t first, size_t n)
{
    uint32_t *order = s->order + first;
    lw_curve_box b = box_of(s, order, n);
    if (n <= LW_BLOCK_MAX) {
        s->box[s->n_block++] = b;
        return;
    }
    int widest = 0;
    for (int k = 1; k < LW_TERMS; k++)
        if (b.most[k] - b.least[k] > b.most[widest] - b.least[widest])
            widest = k;
    size_t half = ((n + LW_BLOCK_MAX - 1)/LW_BLOCK_MAX + 1)/2*LW_BLOCK_MAX;
    for (size_t i = 0; i < n; i++)
        s->key[i] = (uint64_t)s->size[order[i]].v[widest] << 32 | order[i];
    select_first(s->key, n, half);
    for (size_t i = 0; i < n; i++)
        order[i] = (uint32_t)s->key[i];
    sort_blocks(s, first, half);
    sort_blocks(s, first + half, n - half);
}

void lw_atlas_tree_free(lw_atlas_tree *t)
{
    free(t->terms);
    free(t->row);
    free(t->box);
    *t = (lw_atlas_tree){ 0 };
}

static lw_status make_tree(const job *j, bool closed, lw_atlas_tree *t)
{
    lw_status status = LW_OK;
    *t = (lw_atlas_tree){ .closed = closed };
    sizes *size = malloc((j->n + 1)*sizeof *size);
    uint64_t *key = malloc((j->n + 1)*sizeof *key);
    uint32_t *order = malloc((j->n + 1)*sizeof *order);
    t->terms = malloc((j->n + 1)*sizeof *t->terms);
    t->row = malloc((j->n + 1)*sizeof *t->row);
    t->box = malloc((j->n/LW_BLOCK_MAX + 2)*sizeof *t->box);
    sorting s = { size, key, order, t->box, 0 };
    if (!size || !key || !order || !t->terms || !t->row || !t->box)
        status = LW_E_MEMORY;
    for (size_t i = 0; i < j->n && status == LW_OK; i++)
        if (j->good[i] == (closed ? 1 : 2)) {
            size[i] = sizes_of(&j->terms[i]);
            order[t->n++] = (uint32_t)i;
        }
    if (status == LW_OK && t->n > 0)
        sort_blocks(&s, 0, t->n);
    for (size_t i = 0; i < t->n && status == LW_OK; i++) {
        t->terms[i] = j->terms[order[i]];
        t->row[i] = j->row[order[i]];
    }
    t->n_block = s.n_block;
    free(size);
    free(key);
    free(order);
    if (status != LW_OK)
        lw_atlas_tree_free(t);
    return status;
}

/* ---- segments -------------------------------------------------------------------------------------- */

typedef struct pair { const job *j; lw_atlas_tree *tree; lw_status status[2]; } pair;

static void make_trees(void *context, size_t which, int thread)
{
    pair *p = context;
    (void)thread;
    p->status[which] = make_tree(p->j, which == 0, &p->tree[which]);
}

lw_status lw_atlas_segment(const lw_curve_maker *maker, uint64_t seed, size_t number, size_t n, lw_atlas_kinds kinds,
                           int n_thread, const volatile int *stop, lw_atlas_tree tree[2])
{
    lw_rng rng;
    if (n > LW_SEGMENT_MAX)
        return LW_E_ARG;
    n_thread = n_thread < 1 ? lw_core_count() : n_thread;
    job *j = malloc(sizeof *j);
    tree[0] = tree[1] = (lw_atlas_tree){ 0 };
    if (!j)
        return LW_E_MEMORY;
    *j = (job){ .maker = maker, .kinds = kinds, .n = n, .stop = stop };
    double *u = malloc((n*LW_CURVE_DRAWS + 1)*sizeof *u);
    j->u = u;
    j->work = calloc((size_t)n_thread, sizeof *j->work);
    bool good = j->work;
    for (int i = 0; i < n_thread && good; i++)
        good = lw_curve_work_create(maker, &j->work[i]) == LW_OK;
    j->good = malloc(n + 1);
    j->terms = malloc((n + 1)*sizeof *j->terms);
    j->row = malloc((n + 1)*sizeof *j->row);
    pair p = { j, tree, { LW_E_MEMORY, LW_E_MEMORY } };
    lw_rng_seed(&rng, seed, 0x61746c61u + number);             /* each segment uses its own random numbers */
    if (u && good && j->good && j->terms && j->row && lw_low_discrepancy(&rng, n, LW_CURVE_DRAWS, u)) {
        lw_parallel(n_thread, (n + CHUNK - 1)/CHUNK, draw_chunk, j);
        if (!memchr(j->good, FAILED, n))
            lw_parallel(n_thread, 2, make_trees, &p);
    }
    for (int i = 0; j->work && i < n_thread; i++)
        lw_curve_work_free(j->work[i]);
    free(u);
    free(j->work);
    free(j->good);
    free(j->terms);
    free(j->row);
    free(j);
    if (p.status[0] == LW_OK && p.status[1] == LW_OK)
        return LW_OK;
    lw_atlas_tree_free(&tree[0]);
    lw_atlas_tree_free(&tree[1]);
    return stop && *stop ? LW_STOPPED : LW_E_MEMORY;
}

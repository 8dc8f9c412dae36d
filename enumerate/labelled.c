/* enumerate/labelled.c - see labelled.h.
 *
 * A monomial of vertices with n in all is a partition: a vertex of degree 2 + i is a part i, and the rest are binary.  The
 * parts of a monomial that belongs to L loops add up to 2L + offset, with an offset for each kind of series: so a series
 * is, for each number of loops and each partition, a row of coefficients for n = 0 .. N. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/labelled.h"

#define PART_MAX  (2*LW_LOOP_MAX - 2)
#define INDEX_MAX (2*LW_LOOP_MAX + 1)

typedef struct row_set { int n; uint64_t *key; } row_set;          /* partitions of one number, keys rising */
typedef struct memo { size_t n, room; uint64_t *key, *value; } memo;

typedef struct series { int offset; uint64_t *row[LW_LOOP_MAX + 1]; } series;

typedef struct field {
    uint64_t prime;
    int      n_most, loops, part_most;
    uint64_t inverse[64];
    int      shift[PART_MAX + 2];            /* of the number of parts i in a key; of binary and of unary vertices */
    row_set  of[PART_MAX + 1];
    memo     known;                          /* numbers of simple graphs                                          */
    bool     failed;                         /* out of memory                                                     */
    series   graphs, rigid, blocks, power[LW_LINK_MAX + 1];
    series   w[INDEX_MAX], y[INDEX_MAX], b[INDEX_MAX], e[INDEX_MAX];
} field;

__extension__ typedef unsigned __int128 wide;

static uint64_t times(const field *f, uint64_t a, uint64_t b) { return (uint64_t)((wide)a*b % f->prime); }
static uint64_t minus(const field *f, uint64_t a) { return a ? f->prime - a : 0; }

static uint64_t power_of(uint64_t a, uint64_t n, uint64_t prime)
{
    uint64_t r = 1;
    for (; n; n >>= 1, a = (uint64_t)((wide)a*a % prime))
        r = n & 1 ? (uint64_t)((wide)r*a % prime) : r;
    return r;
}

static void *zeros(field *f, size_t n, size_t size)
{
    void *p = f->failed ? NULL : calloc(n ? n : 1, size);
    f->failed = f->failed || !p;
    return p;
}

/* ---- partitions ----------------------------------------------------------------------------------- */

static int parts_of(const field *f, uint64_t key, int part)
{
    return (int)(key >> f->shift[part] & (((uint64_t)1 << (f->shift[part + 1] - f->shift[part])) - 1));
}

static int part_count(const field *f, uint64_t key)
{
    int n = 0;
    for (int i = 1; i <= f->part_most; i++)
        n += parts_of(f, key, i);
    return n;
}

static void add_partitions(field *f, row_set *set, int room, int left, int most, uint64_t key)
{
    if (left == 0) {
        if (set->key && set->n < room)
            set->key[set->n] = key;
        set->n++;
    }
    for (int i = most < left ? most : left; i > 0; i--)
        add_partitions(f, set, room, left - i, i, key + ((uint64_t)1 << f->shift[i]));
}

static int by_key(const void *a, const void *b)
{
    const uint64_t *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

static void make_partitions(field *f)
{
    int shift = 0;
    for (int i = 1; i <= f->part_most; i++) {
        f->shift[i] = shift;
        for (int most = f->part_most/i; most; most >>= 1)
            shift++;
    }
    f->shift[f->part_most + 1] = shift;
    for (int total = 0; total <= f->part_most; total++) {
        row_set *set = &f->of[total];
        add_partitions(f, set, 0, total, total, 0);
        int n = set->n;
        *set = (row_set){ 0, zeros(f, (size_t)n, sizeof *set->key) };
        add_partitions(f, set, n, total, total, 0);
        if (set->key)
            qsort(set->key, (size_t)n, sizeof *set->key, by_key);
    }
}

static int find(const row_set *set, uint64_t key)
{
    int low = 0, high = set->n - 1;
    while (low < high) {
        int middle = (low + high)/2;
        if (set->key[middle] < key)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* ---- series --------------------------------------------------------------------------------------- */

static bool has_rows(const field *f, const series *s, int loops)
{
    int total = 2*loops + s->offset;
    return total >= 0 && total <= f->part_most;
}

static uint64_t *row_of(const field *f, const series *s, int loops, int k)
{
    return s->row[loops] + (size_t)k*(size_t)(f->n_most + 1);
}

static series make_series(field *f, int offset, int loops)
{
    series s = { .offset = offset };
    for (int l = 0; l <= loops; l++)
        if (has_rows(f, &s, l))
            s.row[l] = zeros(f, (size_t)f->of[2*l + offset].n*(size_t)(f->n_most + 1), sizeof **s.row);
    return s;
}

static void free_series(series *s)
{
    for (int l = 0; l <= LW_LOOP_MAX; l++)
        free(s->row[l]);
    *s = (series){ 0 };
}

static int first_of(const field *f, const uint64_t *row)
{
    int n = 0;
    while (n <= f->n_most && row[n] == 0)
        n++;
    return n;
}

/* out[loops] += factor times the part of a b with `loops` loops less `shift`; with rooted, a counts n times. */
static void add_product(field *f, series *out, int loops, int shift, uint64_t factor, bool rooted, const series *a, const series *b)
{
    int to = 2*(loops - shift) + a->offset + b->offset, most = f->n_most;
    if (f->failed || !has_rows(f, out, loops) || to < 0 || to > f->part_most)
        return;
    for (int l = 0; l <= loops - shift; l++) {
        int m = loops - shift - l;
        for (int i = 0; has_rows(f, a, l) && has_rows(f, b, m) && i < f->of[2*l + a->offset].n; i++) {
            const uint64_t *p = row_of(f, a, l, i);
            uint64_t scaled[LW_LINK_MAX + 1];
            int first = first_of(f, p);
            for (int n = first; n <= most; n++)
                scaled[n] = times(f, p[n], rooted ? times(f, factor, (uint64_t)n) : factor);
            for (int k = 0; first <= most && k < f->of[2*m + b->offset].n; k++) {
                const uint64_t *q = row_of(f, b, m, k);
                int start = first_of(f, q);
                if (first + start > most)
                    continue;
                uint64_t key = f->of[2*l + a->offset].key[i] + f->of[2*m + b->offset].key[k];
                uint64_t *r = row_of(f, out, loops, find(&f->of[to], key));
                for (int n = first + start; n <= most; n++) {
                    wide sum = r[n];
                    for (int x = first; x <= n - start; x++)
                        sum += (wide)scaled[x]*q[n - x];
                    r[n] = (uint64_t)(sum % f->prime);
                }
            }
        }
    }
}

/* ---- simple graphs -------------------------------------------------------------------------------- */

/* The value of a key, UINT64_MAX if it is new; NULL: out of memory. */
static uint64_t *recall(field *f, uint64_t key)
{
    memo *m = &f->known;
    if (f->failed)
        return NULL;
    if (2*m->n >= m->room) {
        memo more = { 0, m->room ? 4*m->room : 4096, NULL, NULL };
        more.key = zeros(f, more.room, sizeof *more.key);
        more.value = zeros(f, more.room, sizeof *more.value);
        for (size_t k = 0; k < m->room && !f->failed; k++)
            if (m->key[k]) {
                size_t at = m->key[k]*0x9e3779b97f4a7c15u >> 20 & (more.room - 1);
                while (more.key[at])
                    at = (at + 1) & (more.room - 1);
                more.key[at] = m->key[k];
                more.value[at] = m->value[k];
                more.n++;
            }
        memo old = f->failed ? more : *m;
        free(old.key);
        free(old.value);
        if (f->failed)
            return NULL;
        *m = more;
    }
    size_t at = key*0x9e3779b97f4a7c15u >> 20 & (m->room - 1);
    while (m->key[at] && m->key[at] != key)
        at = (at + 1) & (m->room - 1);
    if (!m->key[at]) {
        m->key[at] = key;
        m->value[at] = UINT64_MAX;
        m->n++;
    }
    return &m->value[at];
}

/* Numbers of vertices by the number of edges they still lack. */
typedef struct lacking { int n[PART_MAX + 3]; } lacking;

static uint64_t count_graphs(field *f, const lacking *c);

/* Join the vertex taken out to `left` others, those that lack k edges or fewer; ways to do it times graphs of the rest. */
static uint64_t join_rest(field *f, int k, int left, uint64_t ways, const lacking *before, lacking *after)
{
    if (k == 0)
        return left == 0 ? times(f, ways, count_graphs(f, after)) : 0;
    uint64_t sum = 0, choose = 1;
    for (int n = 0; n <= left && n <= before->n[k]; n++) {
        after->n[k] -= n;
        after->n[k - 1] += n;
        sum = (sum + join_rest(f, k - 1, left - n, times(f, ways, choose), before, after)) % f->prime;
        after->n[k] += n;
        after->n[k - 1] -= n;
        choose = times(f, times(f, choose, (uint64_t)(before->n[k] - n)), f->inverse[n + 1]);
    }
    return sum;
}

/* Labelled simple graphs modulo the prime, by the neighbours of a vertex of greatest degree. */
static uint64_t count_graphs(field *f, const lacking *c)
{
    int top = f->part_most + 2;
    uint64_t key = (uint64_t)1 << 63;
    while (top > 0 && c->n[top] == 0)
        top--;
    if (top == 0)
        return 1;
    for (int d = 1; d <= top; d++)
        key += (uint64_t)c->n[d] << (d > 2 ? f->shift[d - 2] : f->shift[f->part_most + 1] + 5*(d - 1));
    uint64_t *value = recall(f, key);
    if (!value || *value != UINT64_MAX)
        return value ? *value : 0;
    lacking before = *c, after;
    before.n[top]--;
    after = before;
    uint64_t n = join_rest(f, top, top, 1, &before, &after);
    value = recall(f, key);
    if (value)
        *value = n;
    return n;
}

/* f->graphs: connected ones; T A = A (T G) for all graphs A of degrees >= 2. */
static void find_graphs(field *f)
{
    series all = make_series(f, -2, f->loops);
    for (int l = 1; l <= f->loops; l++)
        for (int k = 0; k < f->of[2*l - 2].n && !f->failed; k++)
            for (int n = 3; n <= f->n_most; n++) {
                uint64_t key = f->of[2*l - 2].key[k], ways = 1;
                lacking c = { { 0 } };
                c.n[2] = n - part_count(f, key);
                for (int i = 1; i <= f->part_most; i++)
                    c.n[i + 2] = parts_of(f, key, i);
                for (int d = 2; d <= f->part_most + 2; d++)
                    for (int i = 2; i <= c.n[d]; i++)
                        ways = times(f, ways, f->inverse[i]);
                if (c.n[2] >= 0)
                    row_of(f, &all, l, k)[n] = times(f, ways, count_graphs(f, &c));
            }
    for (int n = 3; n <= f->n_most && !f->failed; n++)
        for (int l = 1; l <= f->loops; l++)
            for (int k = 0; k < f->of[2*l - 2].n; k++)
                row_of(f, &f->graphs, l, k)[n] = row_of(f, &all, l, k)[n];
    /* graphs of excess 2l - 2 that have a component with m vertices: n G_n = n A_n - sum of m G_m A_{n-m} */
    for (int n = 6; n <= f->n_most && !f->failed; n++)
        for (int l = 1; l <= f->loops; l++)
            for (int i = 1; i <= l; i++)
                for (int p = 0; p < f->of[2*i - 2].n; p++)
                    for (int q = 0; q < f->of[2*(l - i)].n; q++) {
                        uint64_t key = f->of[2*i - 2].key[p] + f->of[2*(l - i)].key[q];
                        uint64_t *to = &row_of(f, &f->graphs, l, find(&f->of[2*l - 2], key))[n];
                        const uint64_t *g = row_of(f, &f->graphs, i, p), *a = row_of(f, &all, l - i + 1, q);
                        wide sum = 0;
                        for (int m = 3; m <= n - 3; m++)
                            sum += (wide)times(f, (uint64_t)m, g[m])*a[n - m];
                        *to = (*to + times(f, minus(f, (uint64_t)(sum % f->prime)), f->inverse[n])) % f->prime;
                    }
    free_series(&all);
    free(f->known.key);
    free(f->known.value);
    f->known = (memo){ 0, 0, NULL, NULL };
}

/* ---- blocks put into blocks ----------------------------------------------------------------------- */

/* Add to b_j[loops] what comes from blocks with fewer loops whose circles but one of j lines are `key`; s is the product of
 * their y, which binary vertices complete. */
static void add_blocks(field *f, int loops, int total, uint64_t key, const series *s)
{
    for (int j = total % 2 ? 3 : 2; j <= loops; j += 2) {
        int l = (total + j - 2)/2 + 1, taken = j - 2;
        if (l >= loops)
            break;
        uint64_t whole = key + (taken ? (uint64_t)1 << f->shift[taken] : 0);
        const uint64_t *block = row_of(f, &f->blocks, l, find(&f->of[2*l - 2], whole));
        series sum = make_series(f, 0, loops - l);
        int circles = part_count(f, whole);
        for (int n = circles; n <= f->n_most && !f->failed; n++) {
            int binary = n - circles, alike = taken ? parts_of(f, whole, taken) : binary;
            uint64_t factor = times(f, block[n], (uint64_t)alike);
            for (int m = 0; factor && m <= loops - l; m++)
                for (int k = 0; k < f->of[2*m].n; k++)
                    for (int i = 0; i <= f->n_most; i++) {
                        uint64_t *to = &row_of(f, &sum, m, k)[i];
                        *to = (*to + times(f, factor, row_of(f, &f->power[binary - !taken], m, k)[i])) % f->prime;
                    }
        }
        add_product(f, &f->b[j], loops, l, 1, false, s, &sum);
        free_series(&sum);
    }
}

static void walk_blocks(field *f, int loops, int total, int last, uint64_t key, const series *s)
{
    add_blocks(f, loops, total, key, s);
    for (int part = 1; part <= last && !f->failed; part++) {
        int left = loops - (total + part + 1)/2 - 1;
        if (left < 1)
            break;
        series longer = make_series(f, total + part, left);
        for (int l = 0; l <= left; l++)
            add_product(f, &longer, l, 0, 1, false, s, &f->y[part + 2]);
        walk_blocks(f, loops, total + part, part, key + ((uint64_t)1 << f->shift[part]), &longer);
        free_series(&longer);
    }
}

/* ---- one level after the other -------------------------------------------------------------------- */

/* e_d[loops], from d e_d = sum of j b_j e_{d-j}. */
static void find_exponential(field *f, int loops)
{
    for (int d = 1; d <= 2*f->loops; d++) {
        if (has_rows(f, &f->e[d], loops) && f->e[d].row[loops])
            memset(f->e[d].row[loops], 0, (size_t)(f->of[2*loops - d].n*(f->n_most + 1))*sizeof(uint64_t));
        for (int j = 1; j <= d && j <= f->loops + 1; j++)
            add_product(f, &f->e[d], loops, 0, times(f, (uint64_t)j, f->inverse[d]), false, &f->b[j], &f->e[d - j]);
    }
}

/* to += D from; the partitions of `from` have sum total. */
static void derive(field *f, int total, const uint64_t *from, uint64_t *to)
{
    size_t width = (size_t)f->n_most + 1;
    for (int k = 0; k < f->of[total].n; k++)
        for (int i = 0; i <= total; i++) {
            uint64_t key = f->of[total].key[k];
            int n_part = part_count(f, key), alike = i ? parts_of(f, key, i) : 0;
            if (i && !alike)
                continue;
            key += ((uint64_t)1 << f->shift[i + 1]) - (i ? (uint64_t)1 << f->shift[i] : 0);
            uint64_t *row = to + (size_t)find(&f->of[total + 1], key)*width;
            for (int n = n_part; n <= f->n_most; n++)
                row[n] = (row[n] + times(f, from[(size_t)k*width + (size_t)n], (uint64_t)(i ? alike : n - n_part)))
                       % f->prime;
        }
}

/* What T G lacks with `loops` loops is n B or n R. */
static void find_unknown(field *f, int loops)
{
    series mixed = make_series(f, -2, f->loops);
    for (int d = 0; d <= 2*f->loops; d++)
        add_product(f, &mixed, loops, 0, 1, true, &f->w[d], &f->e[d]);
    for (int k = 0; k < f->of[2*loops - 2].n && !f->failed; k++)
        for (int n = 3; n <= f->n_most; n++) {
            uint64_t rest = times(f, row_of(f, &mixed, loops, k)[n], f->inverse[n]);
            rest = (row_of(f, &f->graphs, loops, k)[n] + minus(f, rest)) % f->prime;
            row_of(f, n > 2*loops + 1 ? &f->blocks : &f->rigid, loops, k)[n] = rest;
        }
    free_series(&mixed);
}

static void add_unknown(field *f, int loops)
{
    size_t width = (size_t)f->n_most + 1;
    for (int d = 0; d <= 2*(f->loops - loops) && !f->failed; d++) {
        uint64_t *to = f->w[d].row[loops];
        if (d == 0)
            memcpy(to, f->rigid.row[loops], (size_t)f->of[2*loops - 2].n*width*sizeof *to);
        else
            derive(f, 2*loops + d - 3, f->w[d - 1].row[loops], to);
    }
    for (int k = 0; k < f->of[2*loops - 2].n && !f->failed; k++)
        for (int j = 2; j <= loops + 1; j++) {
            uint64_t key = f->of[2*loops - 2].key[k];
            int n_part = part_count(f, key), alike = j > 2 ? parts_of(f, key, j - 2) : 0;
            const uint64_t *from = row_of(f, &f->blocks, loops, k);
            if (j > 2 && !alike)
                continue;
            key -= j > 2 ? (uint64_t)1 << f->shift[j - 2] : 0;
            uint64_t *to = row_of(f, &f->b[j], loops, find(&f->of[2*loops - j], key));
            for (int n = n_part + (j == 2); n <= f->n_most; n++)
                to[n - 1] = (to[n - 1] + times(f, from[n], (uint64_t)(j > 2 ? alike : n - n_part))) % f->prime;
        }
}

static void find_level(field *f, int loops)
{
    series one = make_series(f, 0, loops);
    if (!f->failed)
        one.row[0][0] = 1;
    walk_blocks(f, loops, 0, f->part_most, 0, &one);
    free_series(&one);
    find_exponential(f, loops);
    find_unknown(f, loops);
    add_unknown(f, loops);
    find_exponential(f, loops);
    for (int d = 0; d < 2*f->loops; d++)               /* b_1: a string of binary vertices, and what hangs from its end */
        add_product(f, &f->b[1], loops, 0, 1, false, &f->w[d + 1], &f->e[d]);
    for (int k = 0; has_rows(f, &f->b[1], loops) && !f->failed && k < f->of[2*loops - 1].n; k++)
        for (int n = 1; n <= f->n_most; n++)
            row_of(f, &f->b[1], loops, k)[n] = (row_of(f, &f->b[1], loops, k)[n] + row_of(f, &f->b[1], loops, k)[n - 1])
                                             % f->prime;
    find_exponential(f, loops);
    for (int j = 2; j <= f->loops + 1; j++)
        for (int d = 0; j + d <= 2*f->loops; d++)
            add_product(f, &f->y[j], loops, 0, 1, false, &f->w[j + d], &f->e[d]);
    for (int k = 1; k <= f->n_most; k++)
        add_product(f, &f->power[k], loops, 0, 1, false, &f->y[2], &f->power[k - 1]);
}

/* Make the series with their parts without loops: w_d = y_d = z_d, e_0 = 1. */
static void begin(field *f)
{
    f->inverse[1] = 1;
    for (uint64_t i = 2; i < 64; i++)
        f->inverse[i] = times(f, minus(f, f->prime/i), f->inverse[f->prime % i]);
    make_partitions(f);
    f->graphs = make_series(f, -2, f->loops);
    f->rigid = make_series(f, -2, f->loops);
    f->blocks = make_series(f, -2, f->loops);
    for (int d = 0; d <= 2*f->loops; d++) {
        f->w[d] = make_series(f, d - 2, f->loops);
        f->y[d] = make_series(f, d - 2, f->loops);
        f->b[d] = make_series(f, -d, f->loops);
        f->e[d] = make_series(f, -d, f->loops);
        if (d >= 2 && !f->failed) {
            int k = find(&f->of[d - 2], d > 2 ? (uint64_t)1 << f->shift[d - 2] : 0);
            row_of(f, &f->w[d], 0, k)[1] = row_of(f, &f->y[d], 0, k)[1] = 1;
        }
    }
    for (int k = 0; k <= f->n_most; k++) {
        f->power[k] = make_series(f, 0, f->loops);
        if (!f->failed)
            f->power[k].row[0][k] = 1;
    }
    if (!f->failed)
        f->e[0].row[0][0] = 1;
}

static void finish(field *f)
{
    series *one[] = { &f->graphs, &f->rigid, &f->blocks };
    for (int k = 0; k < 3; k++)
        free_series(one[k]);
    for (int d = 0; d < INDEX_MAX; d++) {
        free_series(&f->w[d]);
        free_series(&f->y[d]);
        free_series(&f->b[d]);
        free_series(&f->e[d]);
    }
    for (int k = 0; k <= LW_LINK_MAX; k++)
        free_series(&f->power[k]);
    for (int total = 0; total <= PART_MAX; total++)
        free(f->of[total].key);
    free(f->known.key);
    free(f->known.value);
}

/* The numbers of each row of the table, modulo the prime; false without memory. */
static bool count_modulo(uint64_t prime, const lw_numbers *numbers, const lw_chain_table *table, uint64_t *out)
{
    field *f = calloc(1, sizeof *f);
    if (!f)
        return false;
    f->prime = prime;
    f->n_most = numbers->n_link;
    f->loops = numbers->n_loop;
    f->part_most = f->loops > 1 ? 2*f->loops - 2 : 1;
    begin(f);
    find_graphs(f);
    for (int l = 1; l <= f->loops && !f->failed; l++)
        find_level(f, l);
    for (size_t k = 0; k < table->n_row && !f->failed; k++) {
        uint64_t key = 0, factor = 1;
        for (int i = 1; i < f->loops; i++)
            key += (uint64_t)table->row[k].links.n_with[i + 2] << f->shift[i];
        for (int i = 2; i <= f->n_most; i++)
            factor = times(f, factor, (uint64_t)i);
        out[k] = times(f, factor, row_of(f, &f->blocks, f->loops, find(&f->of[2*f->loops - 2], key))[f->n_most]);
    }
    bool done = !f->failed;
    finish(f);
    free(f);
    return done;
}

static lw_status too_many(const lw_numbers *n, lw_error *e)
{
    return lw_error_set(e, LW_E_ARG, "there are more than 5e36 labelled chains with %d links and F = %d", n->n_link, n->dof);
}

lw_status lw_labelled_chains(const lw_numbers *numbers, lw_chain_table *table, lw_error *e)
{
    static const uint64_t prime[] = { 2305843009213693951u, 2305843009213693921u, 2305843009213693907u };
    if (numbers->dof < 1 || numbers->n2 > 0)
        return lw_error_set(e, LW_E_ARG, "labelled chains are counted for F = 1 and more, with joints of one freedom");
    if (numbers->n_link > 31)                              /* a count of vertices fits 5 bits */
        return too_many(numbers, e);
    lw_status status = lw_chain_table_make(numbers, table);
    uint64_t *part = malloc(3*(table->n_row + 1)*sizeof *part);
    bool done = status == LW_OK && part;
    for (int i = 0; i < 3 && done; i++)
        done = count_modulo(prime[i], numbers, table, part + (size_t)i*table->n_row);
    status = done ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    uint64_t inverse = power_of(prime[0] % prime[1], prime[1] - 2, prime[1]);
    for (size_t k = 0; k < table->n_row && status == LW_OK; k++) {
        uint64_t a = part[k], b = part[table->n_row + k], c = part[2*table->n_row + k];
        uint64_t high = (uint64_t)((wide)((b + prime[1] - a % prime[1]) % prime[1])*inverse % prime[1]);
        table->row[k].n.n_labelled = a + (lw_whole)prime[0]*high;
        if (table->row[k].n.n_labelled % prime[2] != c || lw_tally_add(&table->total, &table->row[k].n) != LW_OK)
            status = too_many(numbers, e);
    }
    free(part);
    if (status != LW_OK)
        lw_chain_table_free(table);
    return status;
}

lw_status lw_labelled_complete(const lw_numbers *numbers, lw_chain_table *table, lw_error *e)
{
    lw_chain_table labelled;
    lw_whole forms = 0;
    lw_status status = lw_labelled_chains(numbers, &labelled, e);
    if (status != LW_OK)
        return status;
    (void)lw_labelled_forms(numbers->n_link, 1, 1, &forms);
    table->total.n_chain = 0;
    for (size_t k = 0; k < table->n_row && status == LW_OK; k++) {
        lw_whole all = labelled.row[k].n.n_labelled + table->row[k].n.n_labelled;
        if (all % forms)
            status = lw_error_set(e, LW_E_KIND, "symmetric chains and generating functions contradict each other");
        table->row[k].n.n_chain = (uint64_t)(all/forms);
        table->total.n_chain += table->row[k].n.n_chain;
    }
    lw_chain_table_free(&labelled);
    return status;
}

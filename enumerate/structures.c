/* enumerate/structures.c - see structures.h. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include "base/file.h"
#include "base/parallel.h"
#include "enumerate/canon.h"
#include "enumerate/grow.h"
#include "enumerate/structures.h"

/* The origin of a structure; its circles are kept for sorting. */
typedef struct origin {
    uint32_t parent;
    lw_ear   ear;
    uint8_t  n_circle;
} origin;

typedef struct level { size_t n; origin *origin; } level;

struct lw_structures {
    int   loops;
    level level[LW_LOOP_MAX + 1];
};

int lw_structures_loops(const lw_structures *set) { return set->loops; }

size_t lw_structures_count(const lw_structures *set, int loops)
{
    return loops < 2 || loops > set->loops ? 0 : set->level[loops].n;
}

void lw_structures_derive(const lw_structures *set, int loops, size_t index, lw_derivation *d)
{
    d->n_ear = loops - 2;
    for (int l = loops; l > 2; l--) {
        const origin *o = &set->level[l].origin[index];
        d->ear[l - 3] = o->ear;
        index = o->parent;
    }
}

void lw_structures_get(const lw_structures *set, int loops, size_t index, lw_structure *s)
{
    lw_derivation d;
    lw_structures_derive(set, loops, index, &d);
    (void)lw_derivation_replay(&d, s);      /* cannot fail: every ear in the set was valid when found */
}

/* ---- the file --------------------------------------------------------------------------------------- */

#define FILE_NAME    "lwstruct"
#define FILE_FORMAT  1
#define FILE_RECORDS 4096         /* records written or read at once */

static void put_number(uint8_t *at, uint64_t v, int size)
{
    for (int i = 0; i < size; i++)
        at[i] = (uint8_t)(v >> 8*i);
}

static uint64_t get_number(const uint8_t *at, int size)
{
    uint64_t v = 0;
    for (int i = size - 1; i >= 0; i--)
        v = v << 8 | at[i];
    return v;
}

static void put_record(uint8_t *at, const origin *o)
{
    put_number(at, o->parent, 4);
    memcpy(at + 4, (const uint8_t[]){ o->ear.rule, o->ear.a, o->ear.b, o->n_circle }, 4);
}

uint64_t lw_structures_digest(const lw_structures *set, int loops)
{
    uint64_t h = 14695981039346656037u;               /* FNV-1a, a record at a time, then mixed */
    for (int l = 3; l <= loops && l <= set->loops; l++)
        for (size_t k = 0; k < set->level[l].n; k++) {
            uint8_t record[8];
            put_record(record, &set->level[l].origin[k]);
            h = (h ^ get_number(record, 8))*1099511628211u;
            h ^= h >> 29;
        }
    return h;
}

static bool write_level(const level *l, FILE *f)
{
    uint8_t buffer[FILE_RECORDS][8];
    put_number(buffer[0], l->n, 8);
    bool good = fwrite(buffer, 8, 1, f) == 1;
    for (size_t k = 0; k < l->n && good; ) {
        size_t n = 0;
        for (; n < FILE_RECORDS && k < l->n; n++, k++)
            put_record(buffer[n], &l->origin[k]);
        good = fwrite(buffer, 8, n, f) == n;
    }
    return good;
}

lw_status lw_structures_write(const lw_structures *set, FILE *f)
{
    uint8_t head[16] = FILE_NAME, end[8];
    put_number(head + 8, FILE_FORMAT, 4);
    put_number(head + 12, (uint64_t)set->loops, 4);
    put_number(end, lw_structures_digest(set, set->loops), 8);
    bool good = fwrite(head, sizeof head, 1, f) == 1;
    for (int l = 3; l <= set->loops && good; l++)
        good = write_level(&set->level[l], f);
    return good && fwrite(end, sizeof end, 1, f) == 1 ? LW_OK : LW_E_IO;
}

/* Does the ear fit the parent, and give this number of circles? */
static bool record_valid(const origin *o, const lw_structures *set, int loops)
{
    if (o->parent >= set->level[loops - 1].n)
        return false;
    int n_circle = loops == 3 ? 2 : set->level[loops - 1].origin[o->parent].n_circle;
    int n_line = n_circle + loops - 2, a = o->ear.a, b = o->ear.b;
    switch ((lw_ear_rule)o->ear.rule) {
    case LW_EAR_CIRCLES:     return a < b && b < n_circle && o->n_circle == n_circle;
    case LW_EAR_CIRCLE_LINE: return a < n_circle && b < n_line && o->n_circle == n_circle + 1;
    case LW_EAR_LINES:       return a < b && b < n_line && o->n_circle == n_circle + 2;
    case LW_EAR_LINE:        return a == b && b < n_line && o->n_circle == n_circle + 2;
    }
    return false;
}

/* Read one level; false when the file ends too early or holds something else. */
static bool read_level(lw_structures *set, int loops, FILE *f, lw_status *status)
{
    uint8_t buffer[FILE_RECORDS][8];
    level *l = &set->level[loops];
    if (fread(buffer, 8, 1, f) != 1)
        return false;
    size_t n = (size_t)get_number(buffer[0], 8), room = 0;
    if (n == 0 || n > UINT32_MAX)
        return false;
    while (l->n < n) {
        size_t more = n - l->n < FILE_RECORDS ? n - l->n : FILE_RECORDS;
        if (fread(buffer, 8, more, f) != more)
            return false;
        if (l->n + more > room) {                     /* grows with what is really in the file */
            room = 2*room + more;
            origin *o = realloc(l->origin, room*sizeof *o);
            *status = o ? LW_OK : LW_E_MEMORY;
            if (!o)
                return false;
            l->origin = o;
        }
        for (size_t k = 0; k < more; k++) {
            const uint8_t *r = buffer[k];
            origin o = { (uint32_t)get_number(r, 4), { r[4], r[5], r[6] }, r[7] };
            if (!record_valid(&o, set, loops))
                return false;
            l->origin[l->n++] = o;
        }
    }
    return true;
}

lw_status lw_structures_read(FILE *f, const char *path, lw_structures **out, lw_error *e)
{
    uint8_t head[16], end[8];
    lw_status status = LW_OK;
    if (fread(head, sizeof head, 1, f) != 1 || memcmp(head, FILE_NAME, 8) != 0)
        return lw_error_set(e, LW_E_NOTATION, "%s is no file of structures that linkwright stored", path);
    uint64_t format = get_number(head + 8, 4), loops = get_number(head + 12, 4);
    if (format != FILE_FORMAT || loops < 2 || loops > LW_LOOP_MAX)
        return lw_error_set(e, LW_E_NOTATION, "%s: format %llu with %llu loops is not known here; this program reads "
                            "format %d", path, (unsigned long long)format, (unsigned long long)loops, FILE_FORMAT);
    lw_structures *set = calloc(1, sizeof *set);
    if (!set)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    set->loops = (int)loops;
    set->level[2].n = 1;
    bool good = true;
    for (int l = 3; l <= set->loops && good; l++)
        good = read_level(set, l, f, &status);
    good = good && fread(end, sizeof end, 1, f) == 1 && fgetc(f) == EOF
         && get_number(end, 8) == lw_structures_digest(set, set->loops);
    if (good) {
        *out = set;
        return LW_OK;
    }
    lw_structures_free(set);
    if (status == LW_OK && ferror(f))
        status = LW_E_IO;
    return status == LW_OK ? lw_error_set(e, LW_E_NOTATION, "%s is damaged or cut short; remove it, and it is made again", path)
         : lw_error_set(e, status, "cannot read %s: %s", path, lw_status_text(status));
}

/* ---- candidates: the children of one block of parents ----------------------------------------------- */

#define BLOCK 8           /* parents in one job     */
#define WAVE  64          /* blocks before a merge  */

typedef struct candidate {
    origin  from;
    uint8_t end[LW_LINE_MAX][2];      /* canonical form */
} candidate;

typedef struct block {
    const lw_structures *set;
    int        loops;                 /* of the parents */
    int        most_circles;          /* of a child     */
    size_t     first, last;           /* parents        */
    uint32_t   parent;                /* the one at work */
    candidate *found;
    size_t     n, room;
    lw_status  status;
} block;

static lw_status take_child(void *context, lw_ear ear, const lw_structure *child)
{
    block *b = context;
    lw_structure form;
    if (child->n_circle > b->most_circles)
        return LW_OK;
    if (b->n == b->room) {
        size_t room = b->room ? 2*b->room : 64;
        candidate *found = realloc(b->found, room*sizeof *found);
        if (!found)
            return LW_E_MEMORY;
        b->found = found;
        b->room = room;
    }
    lw_status status = lw_structure_canonical(child, &form);
    if (status != LW_OK)
        return status;
    candidate *c = &b->found[b->n++];
    c->from = (origin){ b->parent, ear, child->n_circle };
    memcpy(c->end, form.end, sizeof c->end);
    return LW_OK;
}

static void grow_block(void *context, size_t job, int thread)
{
    block *b = (block *)context + job;
    (void)thread;
    b->status = LW_OK;
    for (size_t p = b->first; p < b->last && b->status == LW_OK; p++) {
        lw_structure parent;
        lw_structures_get(b->set, b->loops, p, &parent);
        b->parent = (uint32_t)p;
        b->status = lw_grow(&parent, take_child, b);
    }
}

/* ---- the level being built ---------------------------------------------------------------------- */

/* New structures in order of discovery, their canonical forms (a line less than three per loop takes two
 * bytes), and a table of their numbers + 1 to find them again. */
typedef struct builder {
    size_t    n, room, n_slot;
    size_t    form_size;
    origin   *origin;
    uint8_t  *form;
    uint32_t *slot;
} builder;

static size_t find_slot(const builder *b, const uint8_t *form, size_t size)
{
    uint64_t h = 14695981039346656037u;               /* FNV-1a */
    for (size_t i = 0; i < size; i++)
        h = (h ^ form[i])*1099511628211u;
    size_t at = (size_t)(h ^ h >> 29) & (b->n_slot - 1);
    while (b->slot[at] && memcmp(b->form + (b->slot[at] - 1)*b->form_size, form, size) != 0)
        at = (at + 1) & (b->n_slot - 1);
    return at;
}

static lw_status enlarge(builder *b)
{
    size_t room = b->room ? 2*b->room : 64;
    origin *o = realloc(b->origin, room*sizeof *o);
    if (o)
        b->origin = o;
    uint8_t *form = realloc(b->form, room*b->form_size);
    if (form)
        b->form = form;
    free(b->slot);
    b->n_slot = 2*room;
    b->slot = calloc(b->n_slot, sizeof *b->slot);
    if (!o || !form || !b->slot || room > UINT32_MAX/2)
        return LW_E_MEMORY;
    b->room = room;
    for (size_t k = 0; k < b->n; k++)
        b->slot[find_slot(b, b->form + k*b->form_size, b->form_size)] = (uint32_t)k + 1;
    return LW_OK;
}

static lw_status add(builder *b, const candidate *c)
{
    if (b->n == b->room) {
        lw_status status = enlarge(b);
        if (status != LW_OK)
            return status;
    }
    size_t at = find_slot(b, c->end[0], b->form_size);
    if (b->slot[at])
        return LW_OK;
    b->origin[b->n] = c->from;
    memcpy(b->form + b->n*b->form_size, c->end, b->form_size);
    b->slot[at] = (uint32_t)++b->n;
    return LW_OK;
}

static lw_status grow_wave(builder *b, block *wave, size_t n_block, int n_thread)
{
    lw_status status = lw_parallel(n_thread, n_block, grow_block, wave);
    for (size_t k = 0; k < n_block; k++) {
        if (status == LW_OK)
            status = wave[k].status;
        for (size_t c = 0; c < wave[k].n && status == LW_OK; c++)
            status = add(b, &wave[k].found[c]);
        free(wave[k].found);
    }
    return status;
}

/* Fewer circles first, discovery order kept. */
static lw_status sort_level(const builder *b, level *l)
{
    size_t place[LW_CIRCLE_MAX + 2] = { 0 };
    l->origin = malloc((b->n ? b->n : 1)*sizeof *l->origin);
    if (!l->origin)
        return LW_E_MEMORY;
    l->n = b->n;
    for (size_t k = 0; k < b->n; k++)
        place[b->origin[k].n_circle + 1]++;
    for (int v = 1; v < LW_CIRCLE_MAX + 2; v++)
        place[v] += place[v - 1];
    for (size_t k = 0; k < b->n; k++)
        l->origin[place[b->origin[k].n_circle]++] = b->origin[k];
    return LW_OK;
}

static lw_status build_level(lw_structures *set, int loops, int most_circles, int n_thread, lw_structures_tick *tick, void *context)
{
    builder b = { .form_size = 2*3*(size_t)(loops - 1) };
    block *wave = malloc(WAVE*sizeof *wave);
    size_t n_parent = set->level[loops - 1].n;
    lw_status status = wave ? LW_OK : LW_E_MEMORY;
    for (size_t done = 0; done < n_parent && status == LW_OK; ) {
        size_t n_block = 0;
        for (; n_block < WAVE && done < n_parent; n_block++, done += BLOCK) {
            size_t last = done + BLOCK < n_parent ? done + BLOCK : n_parent;
            wave[n_block] = (block){ .set = set, .loops = loops - 1, .most_circles = most_circles, .first = done,
                                     .last = last };
        }
        status = grow_wave(&b, wave, n_block, n_thread);
        if (status == LW_OK && tick && !tick(context, loops, b.n))
            status = LW_STOPPED;
    }
    if (status == LW_OK)
        status = sort_level(&b, &set->level[loops]);
    free(wave);
    free(b.origin);
    free(b.form);
    free(b.slot);
    return status;
}

lw_status lw_structures_create(int loops, int n_thread, lw_structures **out)
{
    return lw_structures_create_while(loops, n_thread, NULL, NULL, out);
}

lw_status lw_structures_create_while(int loops, int n_thread, lw_structures_tick *tick, void *context, lw_structures **out)
{
    return lw_structures_create_within(loops, LW_CIRCLE_MAX, n_thread, tick, context, out);
}

lw_status lw_structures_create_within(int loops, int most_circles, int n_thread, lw_structures_tick *tick,
                                      void *context, lw_structures **out)
{
    if (loops < 2 || loops > LW_LOOP_MAX)
        return LW_E_ARG;
    lw_structures *set = calloc(1, sizeof *set);
    if (!set)
        return LW_E_MEMORY;
    set->loops = loops;
    set->level[2].n = 1;                              /* the theta structure has no origin */
    lw_status status = LW_OK;
    for (int l = 3; l <= loops && status == LW_OK; l++)
        status = build_level(set, l, most_circles, n_thread, tick, context);
    if (status != LW_OK) {
        lw_structures_free(set);
        return status;
    }
    *out = set;
    return LW_OK;
}

void lw_structures_free(lw_structures *set)
{
    if (!set)
        return;
    for (int l = 0; l <= LW_LOOP_MAX; l++)
        free(set->level[l].origin);
    free(set);
}

/* ---- made or read ------------------------------------------------------------------------------- */

static lw_status read_stored(FILE *f, const char *path, int loops, lw_structures **set, lw_error *e)
{
    lw_status status = lw_structures_read(f, path, set, e);
    fclose(f);
    if (status != LW_OK || (*set)->loops >= loops)
        return status;
    status = lw_error_set(e, LW_E_NOTATION, "%s holds the structures up to %d loops, and %d are needed; name another "
                          "file", path, (*set)->loops, loops);
    lw_structures_free(*set);
    return status;
}

lw_status lw_structures_stored(const char *path, int loops, int n_thread, lw_structures_tick *tick, void *context,
                               lw_structures **set, lw_error *e)
{
    FILE *f = path ? fopen(path, "rb") : NULL;
    if (f)
        return read_stored(f, path, loops, set, e);
    if (path && errno != ENOENT)
        return lw_file_failed(e, "read", path, errno);
    lw_output o;
    lw_status status = path ? lw_output_open(&o, path, e) : LW_OK;      /* before the work, to fail early */
    if (status != LW_OK)
        return status;
    status = lw_structures_create_while(loops, n_thread, tick, context, set);
    if (status != LW_OK)
        (void)(status == LW_E_IO ? lw_graph_error(e, status)
             : lw_error_set(e, status, status == LW_STOPPED ? "stopped while the structures with %d loops were grown"
                            : "the structures with %d loops do not fit into memory", loops));
    if (!path || status != LW_OK) {
        if (path)
            lw_output_abandon(&o);
        return status;
    }
    (void)lw_structures_write(*set, o.f);                   /* the commit sees an error of the stream */
    status = lw_output_commit(&o, e);
    if (status != LW_OK)
        lw_structures_free(*set);
    return status;
}

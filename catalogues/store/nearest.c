/* catalogues/store/nearest.c - the curves of a catalogue nearest to a target. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "catalogues/store/nearest.h"
#include "base/real.h"
#include "catalogues/store/store_internal.h"

#define SMOOTH_POINTS 512    /* a target of fewer points than FEW is replaced by a smooth curve with about as many */
#define FEW           64

/* The stored terms are rounded: a distance computed from them differs by at most this from that of the curve itself
 * (sqrt 32 numbers by half a unit are 0.9e-4; earlier versions computed the terms from 128 samples). */
#define ROUNDING 2e-4

typedef struct source { long long sweep; lw_curve_maker *maker; lw_curve_work *work; } source;
typedef struct block  { float bound; uint32_t n; long long id; int source; } block;

/* A curve that may be among the nearest: from a block, or (source -1) a linkage that was added. */
typedef struct found  { double distance; int source; long long id; uint32_t n, index; } found;

typedef struct search {
    lw_store     *store;
    lw_error     *e;
    bool          closed;
    lw_descriptor target;
    lw_matcher    matcher;
    float         forth[LW_TERMS], back[LW_TERMS];
    int           n_source, k, n_least;
    source       *source;
    size_t        n_block, capacity, n_found, found_max;
    block        *block;
    found        *found;               /* all that may be among the k nearest */
    double       *least;               /* (k) the least distances so far, as a heap whose top is the greatest */
    lw_atlas_search count;
    lw_atlas_filter filter;
    bool          filtered;
    long long     rows_of;             /* block whose rows are in `row`; 0: none */
    lw_curve_row  row[LW_BLOCK_MAX];
} search;

/* ---- reading the boxes ------------------------------------------------------------------------------ */

/* Lower bound of the squared distance between the target and any curve in the box. */
static float bound_of(const float size[LW_TERMS], const lw_curve_box *b)
{
    float sum = 0;
    for (int k = 0; k < LW_TERMS; k++) {
        /* half a unit allows for the rounding of the sizes */
        float least = ((float)b->least[k] - 1)*(float)(1/LW_TERM_ONE);
        float most = ((float)b->most[k] + 1)*(float)(1/LW_TERM_ONE);
        float off = size[k] < least ? least - size[k] : size[k] > most ? size[k] - most : 0;
        sum += off*off;
    }
    return sum;
}

static lw_status find_source(search *s, long long sweep, const lw_value *families, int *which)
{
    for (*which = 0; *which < s->n_source; ++*which)
        if (s->source[*which].sweep == sweep)
            return LW_OK;
    source *more = realloc(s->source, sizeof *more*(size_t)(s->n_source + 1));
    if (!more)
        return LW_E_MEMORY;
    s->source = more;
    lw_status status = lw_curve_maker_of(families->text ? families->text : "", &more[s->n_source].maker, s->e);
    if (status != LW_OK)
        return status;
    more[s->n_source].sweep = sweep;
    status = lw_curve_work_create(more[s->n_source].maker, &more[s->n_source].work);
    s->n_source++;
    return status;
}

static lw_status take_segment(void *context, int n_column, const char *const *name, const lw_value *v)
{
    search *s = context;
    size_t n = v[1].size/sizeof(lw_curve_box);
    int which;
    (void)n_column, (void)name;
    lw_status status = find_source(s, v[2].integer, &v[3], &which);
    if (status != LW_OK)
        return status;
    if (s->n_block + n > s->capacity) {
        size_t capacity = 2*s->capacity + n;
        block *more = realloc(s->block, capacity*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        s->block = more;
        s->capacity = capacity;
    }
    for (size_t i = 0; i < n; i++) {
        lw_curve_box b;
        memcpy(&b, v[1].text + i*sizeof b, sizeof b);
        if (b.n > LW_BLOCK_MAX)
            return lw_error_set(s->e, LW_E_NOTATION, "the catalogue is damaged: a block of %u curves", (unsigned)b.n);
        s->block[s->n_block++] = (block){ fminf(bound_of(s->forth, &b), bound_of(s->back, &b)), b.n,
                                          v[0].integer + (long long)i, which };
        s->count.n_curve += b.n;
    }
    return LW_OK;
}

static int by_bound(const void *a, const void *b)
{
    const block *x = a, *y = b;
    return x->bound < y->bound ? -1 : x->bound > y->bound ? 1 : x->id < y->id ? -1 : x->id > y->id;
}

/* ---- the linkages of what was found ------------------------------------------------------------------ */

typedef struct added { search *s; lw_atlas_hit *hit; lw_descriptor *curve; bool good; } added;

static lw_status read_added(void *context, int n_column, const char *const *name, const lw_value *v)
{
    added *a = context;
    (void)n_column, (void)name;
    size_t n = v[1].size/(2*sizeof(float));
    lw_vec2 *p = malloc((n + 1)*sizeof *p);
    if (!p)
        return LW_E_MEMORY;
    for (size_t i = 0; i < n; i++) {
        float xy[2];
        memcpy(xy, v[1].text + i*sizeof xy, sizeof xy);
        p[i] = lw_v2(xy[0], xy[1]);
    }
    a->hit->turns = v[3].kind == LW_VALUE_INTEGER ? v[3].integer != 0 : -1;
    a->hit->transmission = v[4].kind == LW_VALUE_REAL ? v[4].real : NAN;
    a->good = v[0].text && lw_linkage_read(v[0].text, v[0].size, "catalogue", &a->hit->linkage, a->s->e) == LW_OK
           && lw_descriptor_make(p, n, a->s->closed, a->curve) == LW_OK;
    if (v[2].text)
        snprintf(a->hit->type, sizeof a->hit->type, "%.7s", v[2].text);
    free(p);
    return LW_OK;
}

static lw_status fetch_added(search *s, const found *f, lw_atlas_hit *hit, lw_descriptor *curve, bool *good)
{
    added a = { s, hit, curve, false };
    lw_value id = { .kind = LW_VALUE_INTEGER, .integer = f->id };
    lw_store_query q = { .sql = "SELECT json, curve, type, crank, transmission_min FROM linkage WHERE id = ?1",
                         .value = &id, .n_value = 1, .row = read_added, .context = &a };
    lw_status status = lw_store_ask(s->store, &q, s->e);
    hit->id = f->id;
    *good = a.good;
    return status;
}

static lw_status load_rows(search *s, const found *f)
{
    if (s->rows_of == f->id)
        return LW_OK;
    lw_status status = lw_store_block(s->store, f->id, true, s->row, f->n*sizeof *s->row, s->e);
    s->rows_of = status == LW_OK ? f->id : 0;
    return status;
}

static lw_status fetch_drawn(search *s, const found *f, lw_atlas_hit *hit, lw_descriptor *curve, bool *good)
{
    const source *from = &s->source[f->source];
    const lw_curve_row *row = &s->row[f->index];
    lw_curve_traits traits;
    lw_vec2 p[LW_CURVE_POINTS];
    lw_status status = load_rows(s, f);
    if (status != LW_OK)
        return status;
    status = lw_curve_points(from->maker, row, s->closed, from->work, p, &traits);
    if (status == LW_OK)
        status = lw_curve_linkage(from->maker, row, s->closed, from->work, &hit->linkage);
    if (status == LW_E_NOTATION || status == LW_E_KIND)
        return lw_error_set(s->e, LW_E_NOTATION, "the catalogue is damaged: a family of curves is no family");
    if (status < 0)
        return status;
    *good = status == LW_OK && lw_descriptor_make(p, LW_CURVE_POINTS, s->closed, curve) == LW_OK;
    const char *type = NULL;
    char family[64];
    if (!*good || !lw_curve_family(from->maker, row, family, &type))
        return LW_OK;
    snprintf(hit->family, sizeof hit->family, "%.31s", family);
    snprintf(hit->type, sizeof hit->type, "%s", type ? type : "");
    hit->turns = traits.turns;
    hit->transmission = traits.transmission;
    return LW_OK;
}

static void lay_on_target(const search *s, const lw_descriptor *curve, lw_atlas_hit *hit)
{
    lw_match m;
    lw_vec2 centre = curve->centre;
    lw_descriptor_match(&s->target, curve, &m);
    double size = s->target.size/curve->size;
    centre.y = m.mirrored ? -centre.y : centre.y;
    centre = lw_v2_turn(centre, lw_v2_polar(size, m.turn));
    lw_linkage_lay(&hit->linkage, m.mirrored, m.turn, size, lw_v2_sub(s->target.centre, centre));
    hit->distance = m.distance;
    hit->distance_m = m.distance*s->target.size;
}

/* Is the length of every side of a link, and the distance of the tracer from the pins of its link, in the limits? */
static bool lengths_pass(const lw_atlas_filter *f, const lw_linkage *linkage)
{
    const lw_tracer *t = &linkage->tracer[0];
    for (int a = 0; a < linkage->n_joint; a++) {
        const lw_joint *i = &linkage->joint[a];
        if (!lw_joint_holds_point(i->kind))
            continue;
        if ((i->link[0] == t->link || i->link[1] == t->link) && lw_v2_norm(lw_v2_sub(i->at, t->at)) > f->max_length)
            return false;
        for (int b = 0; b < a; b++) {
            const lw_joint *j = &linkage->joint[b];
            bool joined = i->link[0] == j->link[0] || i->link[0] == j->link[1] || i->link[1] == j->link[0]
                       || i->link[1] == j->link[1];
            double length = lw_v2_norm(lw_v2_sub(i->at, j->at));
            if (joined && lw_joint_holds_point(j->kind) && !(length >= f->min_length && length <= f->max_length))
                return false;
        }
    }
    return true;
}

/* Make the hit of what was found. *good: its curve can be drawn and it passes the filter. */
static lw_status fetch(search *s, const found *f, lw_atlas_hit *hit, bool *good)
{
    lw_descriptor curve;
    const lw_atlas_filter *filter = &s->filter;
    *hit = (lw_atlas_hit){ 0 };
    *good = false;
    lw_status status = (f->source < 0 ? fetch_added : fetch_drawn)(s, f, hit, &curve, good);
    if (status != LW_OK || !*good)
        return status;
    lay_on_target(s, &curve, hit);
    *good = (!filter->turns || hit->turns == 1)
         && (!(filter->min_transmission > 0) || hit->transmission >= filter->min_transmission - 1e-9)
         && (!(filter->max_length > 0) || lengths_pass(filter, &hit->linkage));
    return LW_OK;
}

/* ---- comparing --------------------------------------------------------------------------------------- */

/* A curve whose distance by its stored terms is above this is not among the nearest. */
static double farthest(const search *s)
{
    return s->n_least < s->k ? INFINITY : s->least[0] + 2*ROUNDING;
}

/* The same for squares in single precision. */
static float farthest_square(const search *s)
{
    double d = farthest(s);
    return (float)(d*d + 1e-6);
}

/* Keep the distance if it is among the k least. */
static void keep_distance(search *s, double d)
{
    int at = 0;
    if (s->n_least < s->k) {
        for (at = s->n_least++; at > 0 && s->least[(at - 1)/2] < d; at = (at - 1)/2)
            s->least[at] = s->least[(at - 1)/2];
    } else if (d < s->least[0]) {
        for (int child = 1; child < s->k; child = 2*at + 1) {
            child += child + 1 < s->k && s->least[child + 1] > s->least[child];
            if (s->least[child] <= d)
                break;
            s->least[at] = s->least[child];
            at = child;
        }
    } else {
        return;
    }
    s->least[at] = d;
}

static lw_status keep(search *s, found f)
{
    if (s->n_found == s->found_max) {
        size_t n = 0;                                          /* first drop what is too far by now */
        for (size_t i = 0; i < s->n_found; i++)
            if (s->found[i].distance <= farthest(s))
                s->found[n++] = s->found[i];
        s->n_found = n;
        if (2*n >= s->found_max) {
            found *more = realloc(s->found, (2*s->found_max + 64)*sizeof *more);
            if (!more)
                return LW_E_MEMORY;
            s->found = more;
            s->found_max = 2*s->found_max + 64;
        }
    }
    s->found[s->n_found++] = f;
    keep_distance(s, f.distance);
    return LW_OK;
}

static lw_status compare(search *s, const lw_packed *p, found f)
{
    float size[LW_TERMS], forth = 0, back = 0;
    double most = farthest(s);
    lw_packed_size(p, size);
    for (int k = 0; k < LW_TERMS; k++) {
        float a = size[k] - s->forth[k], b = size[k] - s->back[k];
        forth += a*a;
        back += b*b;
    }
    if (fminf(forth, back) > farthest_square(s))
        return LW_OK;
    if (s->filtered && f.source >= 0) {
        lw_status status = load_rows(s, &f);
        if (status != LW_OK || !lw_curve_row_may(&s->row[f.index], s->filter.turns, s->filter.min_transmission))
            return status;
    }
    s->count.n_compared++;
    f.distance = sqrt(lw_matcher_square(&s->matcher, p, most*most));
    if (!(f.distance <= most))
        return LW_OK;
    if (s->filtered) {
        lw_atlas_hit hit;
        bool good;
        lw_status status = fetch(s, &f, &hit, &good);
        if (status != LW_OK || !good)
            return status;
    }
    return keep(s, f);
}

static bool is_stopped(const search *s) { return s->filter.stop && *s->filter.stop; }

static lw_status look_into_blocks(search *s)
{
    lw_packed terms[LW_BLOCK_MAX];
    if (s->n_block > 0)
        qsort(s->block, s->n_block, sizeof *s->block, by_bound);
    s->count.n_block = s->n_block;
    for (size_t i = 0; i < s->n_block && s->block[i].bound <= farthest_square(s); i++) {
        if (is_stopped(s) && s->n_found > 0)
            return LW_OK;
        const block *b = &s->block[i];
        lw_status status = lw_store_block(s->store, b->id, false, terms, b->n*sizeof *terms, s->e);
        if (status != LW_OK)
            return status;
        s->count.n_read++;
        for (uint32_t k = 0; k < b->n && status == LW_OK; k++)
            status = compare(s, &terms[k], (found){ 0, b->source, b->id, b->n, k });
        if (status != LW_OK)
            return status;
    }
    return LW_OK;
}

/* Compare the linkages that were added. They are few, so one after the other. */
static lw_status take_linkage(void *context, int n_column, const char *const *name, const lw_value *v)
{
    search *s = context;
    lw_packed p;
    (void)n_column, (void)name;
    if (v[1].size != sizeof p)
        return LW_OK;
    memcpy(&p, v[1].text, sizeof p);
    s->count.n_curve++;
    return compare(s, &p, (found){ 0, -1, v[0].integer, 0, 0 });
}

static lw_status find_all(search *s)
{
    lw_value closed = { .kind = LW_VALUE_INTEGER, .integer = s->closed };
    lw_store_query segments = {
        .sql = "SELECT first_block, boxes, sweep, families FROM curve_segment JOIN sweep ON sweep.id = "
               "curve_segment.sweep WHERE closed = ?1",
        .value = &closed, .n_value = 1, .row = take_segment, .context = s };
    lw_store_query linkages = { .sql = "SELECT id, terms FROM linkage WHERE closed = ?1 AND terms IS NOT NULL",
                                .value = &closed, .n_value = 1, .row = take_linkage, .context = s };
    lw_status status = lw_store_ask(s->store, &linkages, s->e);
    if (status == LW_OK)
        status = lw_store_ask(s->store, &segments, s->e);
    return status == LW_OK ? look_into_blocks(s) : status;
}

/* ---- the nearest of all ------------------------------------------------------------------------------ */

static int by_distance(const void *a, const void *b)
{
    const found *x = a, *y = b;
    if (x->distance != y->distance)
        return x->distance < y->distance ? -1 : 1;
    return x->source != y->source ? x->source - y->source : x->id != y->id ? (x->id < y->id ? -1 : 1)
         : (int)x->index - (int)y->index;
}

#define FEW_HITS 10            /* of a search that was stopped */

/* The k nearest by the curves themselves, from all that may be among them by their stored terms. */
static lw_status fetch_all(search *s, lw_atlas_hit *hit, int *n_hit)
{
    lw_status status = LW_OK;
    *n_hit = 0;
    if (s->n_found > 0)
        qsort(s->found, s->n_found, sizeof *s->found, by_distance);
    for (size_t i = 0; i < s->n_found && status == LW_OK; i++) {
        lw_atlas_hit h;
        bool good;
        if (*n_hit == s->k && s->found[i].distance - ROUNDING > hit[s->k - 1].distance)
            break;
        status = is_stopped(s) && *n_hit >= FEW_HITS ? LW_STOPPED : fetch(s, &s->found[i], &h, &good);
        if (status != LW_OK || !good)
            continue;
        if (*n_hit == s->k && h.distance >= hit[s->k - 1].distance)
            continue;
        int at = *n_hit < s->k ? (*n_hit)++ : s->k - 1;
        for (; at > 0 && hit[at - 1].distance > h.distance; at--)
            hit[at] = hit[at - 1];
        hit[at] = h;
    }
    return status;
}

/* ---- the whole ----------------------------------------------------------------------------------------- */

static lw_status describe_target(search *s, const lw_vec2 *p, size_t n)
{
    lw_vec2 smooth[SMOOTH_POINTS + FEW];
    bool few = n >= 3 && n < FEW;
    if (few) {
        /* as many points on each piece, so that the first point of a closed target does not matter */
        size_t pieces = s->closed ? n : n - 1;
        n = (SMOOTH_POINTS/pieces + 1)*pieces + !s->closed;
        lw_curve_smooth(p, pieces + !s->closed, s->closed, smooth, n);
        p = smooth;
    }
    if (lw_descriptor_make(p, n, s->closed, &s->target) != LW_OK)
        return lw_error_set(s->e, LW_E_ARG, "the target is no curve: it wants two different points at least");
    lw_matcher_make(&s->target, &s->matcher);
    lw_descriptor_sizes(&s->target, s->forth, s->back);
    return LW_OK;
}

lw_status lw_store_nearest(lw_store *store, const lw_vec2 *p, size_t n, bool closed, const lw_atlas_filter *filter,
                           int k, lw_atlas_hit *hit, int *n_hit, lw_atlas_search *count, lw_error *e)
{
    lw_error ignored;
    search *s = calloc(1, sizeof *s);
    *n_hit = 0;
    if (k < 1 || !s) {
        free(s);
        return lw_error_set(e, s ? LW_E_ARG : LW_E_MEMORY, s ? "at least one curve must be wanted" : "out of memory");
    }
    s->store = store;
    s->e = e ? e : &ignored;
    s->closed = closed;
    s->k = k;
    s->filter = filter ? *filter : (lw_atlas_filter){ 0 };
    s->filtered = s->filter.turns || s->filter.min_transmission > 0 || s->filter.max_length > 0;
    s->least = malloc((size_t)k*sizeof *s->least);
    lw_status status = s->least ? describe_target(s, p, n) : lw_error_set(s->e, LW_E_MEMORY, "out of memory");
    if (status == LW_OK)
        status = find_all(s);
    if (status == LW_OK)
        status = fetch_all(s, hit, n_hit);
    if (status == LW_OK && *n_hit == 0)
        status = lw_error_set(s->e, LW_NOTHING, "the catalogue holds no %s curves%s; 'linkwright catalogue curves' draws "
                              "some", closed ? "closed" : "open", s->filtered ? " that meet these conditions" : "");
    if (status == LW_E_MEMORY)
        lw_error_set(s->e, status, "out of memory");
    if (count)
        *count = s->count;
    for (int i = 0; i < s->n_source; i++) {
        lw_curve_maker_free(s->source[i].maker);
        lw_curve_work_free(s->source[i].work);
    }
    free(s->source);
    free(s->block);
    free(s->found);
    free(s->least);
    free(s);
    return status;
}

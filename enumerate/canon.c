/* enumerate/canon.c - see canon.h.  The only file that sees igraph. */
#include <igraph.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include "base/library.h"
#include "enumerate/canon.h"

void lw_graph_of_chain(const lw_chain *c, lw_graph *g)
{
    memset(g, 0, sizeof *g);
    g->n = c->n_link;
    for (int i = 0; i < c->n_link; i++)
        for (int k = 0; k < c->n_link; k++)
            g->tie[i][k] = (uint8_t)lw_chain_freedom(c, i, k);
}

void lw_graph_of_structure(const lw_structure *s, lw_graph *g)
{
    memset(g, 0, sizeof *g);
    g->n = s->n_circle;
    for (int e = 0; e < s->n_line; e++) {
        g->tie[s->end[e][0]][s->end[e][1]]++;
        g->tie[s->end[e][1]][s->end[e][0]]++;
    }
}

/* ---- refinement --------------------------------------------------------------------------------- */

/* A list of ties is faster to traverse than the matrix. */
typedef struct tie_list {
    int      n, n_neighbour[LW_GRAPH_MAX];
    uint8_t  neighbour[LW_GRAPH_MAX][LW_GRAPH_MAX], tie[LW_GRAPH_MAX][LW_GRAPH_MAX];
    uint32_t row[LW_GRAPH_MAX];
} tie_list;

static void list_ties(const lw_graph *g, tie_list *t)
{
    t->n = g->n;
    for (int i = 0; i < g->n; i++) {
        int n = 0;
        t->row[i] = 0;
        for (int k = 0; k < g->n; k++)
            if (g->tie[i][k]) {
                t->neighbour[i][n] = (uint8_t)k;
                t->tie[i][n++] = g->tie[i][k];
                t->row[i] |= (uint32_t)1 << k;
            }
        t->n_neighbour[i] = n;
    }
}

/* Finaliser of splitmix64 (Steele, Lea & Flood 2014): spreads every bit over the word. */
static uint64_t mix(uint64_t x)
{
    x = (x ^ x >> 30)*0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27)*0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* One round: combine the colour of each vertex with those of its neighbours, independent of their order. */
static void refine_once(const tie_list *t, uint64_t *colour)
{
    uint64_t next[LW_GRAPH_MAX];
    for (int i = 0; i < t->n; i++) {
        uint64_t sum = 0;
        for (int k = 0; k < t->n_neighbour[i]; k++)
            sum += mix(colour[t->neighbour[i][k]] + 0x9e3779b97f4a7c15u*t->tie[i][k]);
        next[i] = mix(colour[i] ^ mix(sum));
    }
    memcpy(colour, next, (size_t)t->n*sizeof *colour);
}

static int count_colours(const uint64_t *colour, int n)
{
    int distinct = 0;
    for (int i = 0; i < n; i++) {
        int k = 0;
        while (k < i && colour[k] != colour[i])
            k++;
        distinct += k == i;
    }
    return distinct;
}

/* Repeat rounds until the number of colours stays the same; returns that number. */
static int refine(const tie_list *t, uint64_t *colour)
{
    int before = 0, now = count_colours(colour, t->n);
    while (now > before && now < t->n) {
        before = now;
        refine_once(t, colour);
        refine_once(t, colour);
        now = count_colours(colour, t->n);
    }
    return now;
}

/* Colour vertices by the number of vertices at each distance; this distinguishes vertices of regular graphs. */
static uint64_t distance_colour(const tie_list *t, int vertex)
{
    uint32_t seen = (uint32_t)1 << vertex, layer = seen;
    uint64_t colour = 0;
    while (layer) {
        uint32_t next = 0;
        int inside = 0;
        for (uint32_t rest = layer; rest; rest &= rest - 1) {
            uint32_t row = t->row[__builtin_ctz(rest)];
            next |= row;
            inside += __builtin_popcount(row & layer);
        }
        layer = next & ~seen;
        seen |= layer;
        colour = mix(colour*64 + (uint64_t)(32*inside + __builtin_popcount(layer)));
    }
    return colour;
}

static int start_colours(const lw_graph *g, const tie_list *t, uint64_t *colour)
{
    for (int i = 0; i < t->n; i++)
        colour[i] = mix(distance_colour(t, i) + g->colour[i]);
    return refine(t, colour);
}

/* Distinguish vertices by the colours of the whole graph when one vertex is singled out. */
static int single_out(const tie_list *t, uint64_t *colour)
{
    uint64_t seen_from[LW_GRAPH_MAX], trial[LW_GRAPH_MAX];
    for (int i = 0; i < t->n; i++) {
        memcpy(trial, colour, (size_t)t->n*sizeof *trial);
        trial[i] = mix(~trial[i]);
        for (int round = 0; round < 4; round++)
            refine_once(t, trial);
        uint64_t sum = 0;
        for (int k = 0; k < t->n; k++)
            sum += mix(trial[k]);
        seen_from[i] = sum;
    }
    for (int i = 0; i < t->n; i++)
        colour[i] = mix(colour[i] + seen_from[i]);
    return refine(t, colour);
}

void lw_graph_refine(const lw_graph *g, uint64_t *colour)
{
    tie_list t;
    list_ties(g, &t);
    (void)start_colours(g, &t, colour);
}

/* Rank of each colour: 0 for the vertices of the lowest one, ... */
static void rank_colours(const uint64_t *colour, int n, uint8_t *rank)
{
    for (int i = 0; i < n; i++) {
        int lower = 0;
        for (int k = 0; k < n; k++)
            lower += colour[k] < colour[i];
        rank[i] = (uint8_t)lower;
    }
}

/* The colours from which both methods start; true when all vertices have different colours. */
static bool tell_apart(const lw_graph *g, uint8_t *rank)
{
    tie_list t;
    uint64_t colour[LW_GRAPH_MAX];
    list_ties(g, &t);
    int distinct = start_colours(g, &t, colour);
    if (distinct < g->n)
        distinct = single_out(&t, colour);
    rank_colours(colour, g->n, rank);
    return distinct == g->n;
}

/* ---- BLISS through igraph ----------------------------------------------------------------------- */

/* igraph keeps its error handler and its stack of half-built objects in process-wide variables. */
#ifdef PTHREAD_ADAPTIVE_MUTEX_INITIALIZER_NP    /* calls last microseconds, so spin before sleeping if possible */
static pthread_mutex_t igraph_lock = PTHREAD_ADAPTIVE_MUTEX_INITIALIZER_NP;
#else
static pthread_mutex_t igraph_lock = PTHREAD_MUTEX_INITIALIZER;
#endif

/* Loaded with the first graph that needs it (base/library.h); most commands need none. */
#if IGRAPH_VERSION_MAJOR == 0 && IGRAPH_VERSION_MINOR == 10
#define IGRAPH_FILE "libigraph.so.3"
#else
#error "igraph 0.10 is known here; see bliss_label about the sense of permutations, and name the file of the other"
#endif
#define CALLS(X) \
    X(automorphism_group) X(canonical_permutation) X(create) X(destroy) X(error_handler_ignore) X(set_error_handler) \
    X(vector_int_destroy) X(vector_int_init) X(vector_int_list_destroy) X(vector_int_list_get_ptr) \
    X(vector_int_list_init) X(vector_int_list_size) X(vector_int_push_back)

/* Filled under the lock. */
static struct {
#define X(f) __typeof__(igraph_##f) *f;
    CALLS(X)
#undef X
} igraph;

static lw_status need_igraph(lw_error *e)
{
    static const lw_library_call call[] = {
#define X(f) { "igraph_" #f, &igraph.f },
        CALLS(X)
#undef X
    };
    return igraph.create ? LW_OK : lw_library_load(IGRAPH_FILE, "libigraph3", call, (int)(sizeof call/sizeof *call), e);
}

typedef struct bliss {
    igraph_t            graph;
    igraph_vector_int_t colour, edges;
} bliss;

/* BLISS takes no multigraphs: a tie above 1 becomes a vertex in the middle, coloured by the tie. */
static igraph_error_t list_edges(bliss *b, const lw_graph *g, const uint8_t *rank)
{
    igraph_integer_t n = g->n;
    igraph_error_t error = IGRAPH_SUCCESS;
    for (int i = 0; i < g->n && !error; i++)
        error = igraph.vector_int_push_back(&b->colour, rank[i]);
    for (int i = 0; i < g->n; i++)
        for (int k = i + 1; k < g->n && !error; k++) {
            bool middle = g->tie[i][k] > 1;
            igraph_integer_t way[4] = { i, middle ? n : k, n, k };
            for (int j = 0; j < (!g->tie[i][k] ? 0 : middle ? 4 : 2) && !error; j++)
                error = igraph.vector_int_push_back(&b->edges, way[j]);
            if (middle && !error)
                error = igraph.vector_int_push_back(&b->colour, LW_GRAPH_MAX + g->tie[i][k]);
            n += middle;
        }
    return error ? error : igraph.create(&b->graph, &b->edges, n, IGRAPH_UNDIRECTED);
}

static igraph_error_t bliss_open(bliss *b, const lw_graph *g, const uint8_t *rank)
{
    igraph_error_t error = igraph.vector_int_init(&b->colour, 0);
    if (error)
        return error;
    error = igraph.vector_int_init(&b->edges, 0);
    if (!error) {
        error = list_edges(b, g, rank);
        igraph.vector_int_destroy(&b->edges);
    }
    if (error)
        igraph.vector_int_destroy(&b->colour);
    return error;
}

static void bliss_close(bliss *b)
{
    igraph.destroy(&b->graph);
    igraph.vector_int_destroy(&b->colour);
}

/* place[i] = new number of vertex i, as in igraph 0.10; igraph 1.0 gives the inverse (test_canon would fail). */
static igraph_error_t bliss_label(const lw_graph *g, const uint8_t *rank, uint8_t *to)
{
    bliss b;
    igraph_vector_int_t place;
    igraph_error_t error = igraph.vector_int_init(&place, 0);
    if (error)
        return error;
    error = bliss_open(&b, g, rank);
    if (error == IGRAPH_SUCCESS) {
        error = igraph.canonical_permutation(&b.graph, &b.colour, &place, IGRAPH_BLISS_FL, NULL);
        bliss_close(&b);
    }
    for (int i = 0; error == IGRAPH_SUCCESS && i < g->n; i++) {
        int lower = 0;                           /* places among the vertices proper */
        for (int k = 0; k < g->n; k++)
            lower += VECTOR(place)[k] < VECTOR(place)[i];
        to[i] = (uint8_t)lower;
    }
    igraph.vector_int_destroy(&place);
    return error;
}

static igraph_error_t take_generators(const igraph_vector_int_list_t *list, lw_symmetry_group *group)
{
    igraph_integer_t n = igraph.vector_int_list_size(list);
    group->generator = malloc((size_t)(n ? n : 1)*sizeof *group->generator);
    if (!group->generator)
        return IGRAPH_ENOMEM;
    for (igraph_integer_t k = 0; k < n; k++) {
        const igraph_vector_int_t *p = igraph.vector_int_list_get_ptr(list, k);
        for (int i = 0; i < group->n; i++)
            group->generator[k][i] = (uint8_t)VECTOR(*p)[i];
    }
    group->n_generator = (int)n;
    return IGRAPH_SUCCESS;
}

static igraph_error_t bliss_group(const lw_graph *g, const uint8_t *rank, lw_symmetry_group *group)
{
    bliss b;
    igraph_vector_int_list_t list;
    igraph_error_t error = igraph.vector_int_list_init(&list, 0);
    if (error)
        return error;
    error = bliss_open(&b, g, rank);
    if (error == IGRAPH_SUCCESS) {
        error = igraph.automorphism_group(&b.graph, &b.colour, &list, IGRAPH_BLISS_FL, NULL);
        bliss_close(&b);
    }
    if (error == IGRAPH_SUCCESS)
        error = take_generators(&list, group);
    igraph.vector_int_list_destroy(&list);
    return error;
}

/* Compute the labelling or the group; the pointer to the other is NULL. */
static lw_status ask_bliss(const lw_graph *g, const uint8_t *rank, uint8_t *to, lw_symmetry_group *group)
{
    pthread_mutex_lock(&igraph_lock);
    lw_status status = need_igraph(NULL);
    if (status == LW_OK) {
        igraph_error_handler_t *before = igraph.set_error_handler(igraph.error_handler_ignore);
        igraph_error_t error = to ? bliss_label(g, rank, to) : bliss_group(g, rank, group);
        igraph.set_error_handler(before);
        status = error == IGRAPH_SUCCESS ? LW_OK : LW_E_MEMORY;
    }
    pthread_mutex_unlock(&igraph_lock);
    return status;
}

lw_status lw_graph_error(lw_error *e, lw_status s)
{
    if (s >= LW_OK || !e || e->text[0])
        return s;
    if (s == LW_E_IO) {
        pthread_mutex_lock(&igraph_lock);
        (void)need_igraph(e);
        pthread_mutex_unlock(&igraph_lock);
    }
    return e->text[0] ? s : lw_error_set(e, s, "%s", lw_status_text(s));
}

lw_status lw_graph_label(const lw_graph *g, uint8_t *to)
{
    uint8_t rank[LW_GRAPH_MAX];
    if (!tell_apart(g, rank))
        return ask_bliss(g, rank, to, NULL);
    memcpy(to, rank, (size_t)g->n);
    return LW_OK;
}

lw_status lw_chain_canonical(const lw_chain *c, lw_chain *form)
{
    lw_graph g;
    uint8_t to[LW_GRAPH_MAX];
    lw_graph_of_chain(c, &g);
    lw_status status = lw_graph_label(&g, to);
    if (status == LW_OK)
        lw_chain_relabel(c, to, form);
    return status;
}

lw_status lw_structure_canonical(const lw_structure *s, lw_structure *form)
{
    lw_graph g;
    uint8_t to[LW_GRAPH_MAX];
    lw_graph_of_structure(s, &g);
    lw_status status = lw_graph_label(&g, to);
    if (status == LW_OK)
        lw_structure_relabel(s, to, form);
    return status;
}

/* ---- groups ------------------------------------------------------------------------------------- */

static void find_orbits(lw_symmetry_group *group)
{
    bool merged = true;
    for (int i = 0; i < group->n; i++)
        group->orbit[i] = (uint8_t)i;
    while (merged) {
        merged = false;
        for (int k = 0; k < group->n_generator; k++)
            for (int i = 0; i < group->n; i++) {
                uint8_t *a = &group->orbit[i], *b = &group->orbit[group->generator[k][i]];
                if (*a == *b)
                    continue;
                *a = *b = *a < *b ? *a : *b;
                merged = true;
            }
    }
}

lw_status lw_graph_group(const lw_graph *g, lw_symmetry_group *group)
{
    uint8_t rank[LW_GRAPH_MAX];
    *group = (lw_symmetry_group){ .n = g->n };
    lw_status status = tell_apart(g, rank) ? LW_OK : ask_bliss(g, rank, NULL, group);
    find_orbits(group);
    return status;
}

void lw_symmetry_group_free(lw_symmetry_group *group)
{
    free(group->generator);
    group->generator = NULL;
    group->n_generator = 0;
}

#define ELEMENT_MAX ((size_t)1 << 24)

/* Elements found so far, and a hash table of their numbers + 1. */
typedef struct element_set {
    uint8_t (*element)[LW_GRAPH_MAX];
    size_t   n, room;
    uint32_t *slot;
    size_t   n_slot;                   /* a power of two, at least twice the room */
    int      length;
} element_set;

static size_t slot_of(const element_set *set, const uint8_t *p)
{
    uint64_t h = 0;
    for (int i = 0; i < set->length; i++)
        h = mix(h + p[i] + 1);
    size_t at = (size_t)h & (set->n_slot - 1);
    while (set->slot[at] && memcmp(set->element[set->slot[at] - 1], p, (size_t)set->length) != 0)
        at = (at + 1) & (set->n_slot - 1);
    return at;
}

static lw_status enlarge(element_set *set)
{
    size_t room = set->room ? 4*set->room : 16;
    void *element = room <= ELEMENT_MAX ? realloc(set->element, room*sizeof *set->element) : NULL;
    if (!element)
        return LW_E_MEMORY;
    set->element = element;
    set->room = room;
    free(set->slot);
    set->n_slot = 2*room;
    set->slot = calloc(set->n_slot, sizeof *set->slot);
    if (!set->slot)
        return LW_E_MEMORY;
    for (size_t k = 0; k < set->n; k++)
        set->slot[slot_of(set, set->element[k])] = (uint32_t)k + 1;
    return LW_OK;
}

static lw_status add_element(element_set *set, const uint8_t *p)
{
    size_t at = set->n_slot ? slot_of(set, p) : 0;
    if (set->n_slot && set->slot[at])
        return LW_OK;
    if (set->n == set->room) {
        lw_status status = enlarge(set);
        if (status != LW_OK)
            return status;
        at = slot_of(set, p);
    }
    memcpy(set->element[set->n], p, LW_GRAPH_MAX);
    set->slot[at] = (uint32_t)++set->n;
    return LW_OK;
}

lw_status lw_symmetry_group_elements(const lw_symmetry_group *group, uint8_t (**element)[LW_GRAPH_MAX], size_t *n)
{
    element_set set = { .length = group->n };
    uint8_t p[LW_GRAPH_MAX] = { 0 };
    for (int i = 0; i < group->n; i++)
        p[i] = (uint8_t)i;
    lw_status status = add_element(&set, p);
    for (size_t done = 0; status == LW_OK && done < set.n; done++)
        for (int k = 0; k < group->n_generator && status == LW_OK; k++) {
            for (int i = 0; i < group->n; i++)
                p[i] = group->generator[k][set.element[done][i]];
            status = add_element(&set, p);
        }
    free(set.slot);
    if (status != LW_OK) {
        free(set.element);
        set.element = NULL;
        set.n = 0;
    }
    *element = set.element;
    *n = set.n;
    return status;
}

lw_status lw_graph_symmetry(const lw_graph *g, uint8_t *lowest, uint64_t *order)
{
    lw_symmetry_group group;
    uint8_t (*element)[LW_GRAPH_MAX] = NULL;
    size_t n = 1;
    lw_status status = lw_graph_group(g, &group);
    if (status == LW_OK && lowest)
        memcpy(lowest, group.orbit, (size_t)g->n);
    if (status == LW_OK && order) {
        if (group.n_generator > 0)
            status = lw_symmetry_group_elements(&group, &element, &n);
        *order = n;
    }
    free(element);
    lw_symmetry_group_free(&group);
    return status;
}

lw_status lw_graph_elements(const lw_graph *g, uint8_t (**element)[LW_GRAPH_MAX], size_t *n)
{
    lw_symmetry_group group;
    lw_status status = lw_graph_group(g, &group);
    if (status == LW_OK)
        status = lw_symmetry_group_elements(&group, element, n);
    lw_symmetry_group_free(&group);
    return status;
}

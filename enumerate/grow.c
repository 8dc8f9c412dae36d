/* enumerate/grow.c - see grow.h. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/grow.h"

/* Data of the parent, computed before any ear is tried. */
typedef struct parent_data {
    const lw_structure *parent;
    uint8_t             degree[LW_CIRCLE_MAX];
    uint64_t            removable;               /* lines, as bits                                */
    uint64_t            first;                   /* first line of each set of parallel lines      */
    uint64_t            second;                  /* second line of each set                       */
    bool                once;                    /* decide ties, see lw_grow_once                 */
} parent_data;

static bool same_ends(const lw_structure *s, int e, int f)
{
    return memcmp(s->end[e], s->end[f], 2) == 0;
}

static void prepare(parent_data *n, const lw_structure *parent, bool once)
{
    *n = (parent_data){ .parent = parent, .once = once };
    lw_structure_degrees(parent, n->degree);
    for (int e = 0; e < parent->n_line; e++) {
        bool parallel = e > 0 && same_ends(parent, e - 1, e);
        if (!parallel)
            n->first |= (uint64_t)1 << e;
        else if (n->first >> (e - 1) & 1)
            n->second |= (uint64_t)1 << e;
        if (parallel ? n->removable >> (e - 1) & 1 : lw_structure_removable(parent, e))
            n->removable |= (uint64_t)1 << e;
    }
}

/* Smaller and larger degree of the ends of a line as one number. */
static int line_measure(int degree_a, int degree_b)
{
    return degree_a < degree_b ? degree_a*256 + degree_b : degree_b*256 + degree_a;
}

/* True if a line of the parent that the ear does not touch beats a new line of the given measure.  A removable line
 * of the parent is removable from the child too, since an ear keeps the graph 2-connected. */
static bool beaten_by_parent(const parent_data *n, const uint8_t *degree, uint64_t touched, int measure)
{
    for (uint64_t rest = n->removable & ~touched; rest; rest &= rest - 1) {
        const uint8_t *end = n->parent->end[__builtin_ctzll(rest)];
        if (line_measure(degree[end[0]], degree[end[1]]) > measure)
            return true;
    }
    return false;
}

/* Colour of a line from those of its circles and the number of its parallels. */
static uint64_t line_colour(const lw_graph *g, const uint64_t *colour, const uint8_t *end)
{
    uint64_t a = colour[end[0]], b = colour[end[1]];
    return (a + b)*0x9e3779b97f4a7c15u + (a ^ b) + g->tie[end[0]][end[1]];
}

/* Canonical form of the graph with the pair of circles a, b marked. */
static lw_status marked_form(const lw_graph *g, int a, int b, lw_graph *form)
{
    lw_graph marked = *g;
    uint8_t to[LW_GRAPH_MAX];
    marked.colour[a] = marked.colour[b] = 1;
    lw_status status = lw_graph_label(&marked, to);
    if (status != LW_OK)
        return status;
    memset(form, 0, sizeof *form);
    for (int i = 0; i < g->n; i++) {
        form->colour[to[i]] = marked.colour[i];
        for (int k = 0; k < g->n; k++)
            form->tie[to[i]][to[k]] = g->tie[i][k];
    }
    return LW_OK;
}

/* True if the line a - b is a best removable line of the child. Ties count as best; with `once` the marked form decides
 * them, so that the best lines are one orbit. */
static bool best_of_child(const lw_structure *child, int a, int b, bool once, lw_status *status)
{
    lw_graph g, mine, other_form;
    bool formed = false;
    uint64_t colour[LW_GRAPH_MAX];
    uint8_t degree[LW_CIRCLE_MAX], end[2] = { (uint8_t)(a < b ? a : b), (uint8_t)(a < b ? b : a) };
    lw_graph_of_structure(child, &g);
    lw_graph_refine(&g, colour);
    lw_structure_degrees(child, degree);
    int measure = line_measure(degree[a], degree[b]);
    uint64_t own = line_colour(&g, colour, end);
    for (int e = 0; e < child->n_line; e++) {
        int other = line_measure(degree[child->end[e][0]], degree[child->end[e][1]]);
        if (other < measure || (e > 0 && same_ends(child, e - 1, e)))
            continue;
        uint64_t its = line_colour(&g, colour, child->end[e]);
        bool tie = other == measure && its == own && memcmp(child->end[e], end, 2) != 0;
        if (!(other > measure || its > own || (once && tie)) || !lw_structure_removable(child, e))
            continue;
        if (!tie)
            return false;
        if (!formed)
            *status = marked_form(&g, a, b, &mine);
        formed = true;
        if (*status == LW_OK)
            *status = marked_form(&g, child->end[e][0], child->end[e][1], &other_form);
        if (*status != LW_OK || memcmp(&other_form, &mine, sizeof mine) > 0)
            return false;
    }
    return true;
}

typedef struct growth { const parent_data *n; lw_grow_visit *visit; void *context; } growth;

/* Try one ear; degree is that of the child for the parent's circles, from and to the ends of the new line. */
static lw_status try_ear(const growth *w, lw_ear ear, uint64_t touched, const uint8_t *degree, int from, int to)
{
    const lw_structure *parent = w->n->parent;
    int degree_from = from < parent->n_circle ? degree[from] : 3;
    int degree_to = to < parent->n_circle ? degree[to] : 3;
    lw_structure child;
    if (beaten_by_parent(w->n, degree, touched, line_measure(degree_from, degree_to)))
        return LW_OK;
    lw_status status = LW_OK;
    if (lw_structure_grow(parent, ear, &child) != LW_OK || !best_of_child(&child, from, to, w->n->once, &status))
        return status;
    return w->visit(w->context, ear, &child);
}

static lw_status grow_circles(const growth *w)
{
    uint8_t degree[LW_CIRCLE_MAX];
    int n_circle = w->n->parent->n_circle;
    lw_status status = LW_OK;
    memcpy(degree, w->n->degree, sizeof degree);
    for (int a = 0; a < n_circle; a++) {
        degree[a]++;
        for (int b = a + 1; b < n_circle && status == LW_OK; b++) {
            degree[b]++;
            lw_ear ear = { LW_EAR_CIRCLES, (uint8_t)a, (uint8_t)b };
            status = try_ear(w, ear, 0, degree, a, b);
            degree[b]--;
        }
        degree[a]--;
    }
    return status;
}

static lw_status grow_circle_line(const growth *w)
{
    uint8_t degree[LW_CIRCLE_MAX];
    int n_circle = w->n->parent->n_circle;
    lw_status status = LW_OK;
    memcpy(degree, w->n->degree, sizeof degree);
    for (int a = 0; a < n_circle; a++) {
        degree[a]++;
        for (uint64_t rest = w->n->first; rest && status == LW_OK; rest &= rest - 1) {
            int b = __builtin_ctzll(rest);
            lw_ear ear = { LW_EAR_CIRCLE_LINE, (uint8_t)a, (uint8_t)b };
            status = try_ear(w, ear, (uint64_t)1 << b, degree, a, n_circle);
        }
        degree[a]--;
    }
    return status;
}

/* Parallel lines give the same child, so only the first line of each set of parallel lines is tried, and for two lines
 * of one set the first two. */
static lw_status grow_lines(const growth *w)
{
    const parent_data *n = w->n;
    int n_circle = n->parent->n_circle;
    lw_status status = LW_OK;
    for (uint64_t rest = n->first; rest; rest &= rest - 1) {
        int a = __builtin_ctzll(rest);
        uint64_t later = (rest & (rest - 1)) | (n->second & (uint64_t)2 << a);
        for (; later && status == LW_OK; later &= later - 1) {
            int b = __builtin_ctzll(later);
            lw_ear ear = { LW_EAR_LINES, (uint8_t)a, (uint8_t)b };
            status = try_ear(w, ear, (uint64_t)1 << a | (uint64_t)1 << b, n->degree, n_circle, n_circle + 1);
        }
    }
    for (uint64_t rest = n->first; rest && status == LW_OK; rest &= rest - 1) {
        int a = __builtin_ctzll(rest);
        lw_ear ear = { LW_EAR_LINE, (uint8_t)a, (uint8_t)a };
        status = try_ear(w, ear, (uint64_t)1 << a, n->degree, n_circle, n_circle + 1);
    }
    return status;
}

static lw_status grow(const lw_structure *parent, bool once, lw_grow_visit *visit, void *context)
{
    parent_data n;
    prepare(&n, parent, once);
    growth w = { &n, visit, context };
    lw_status status = grow_circles(&w);
    if (status == LW_OK)
        status = grow_circle_line(&w);
    if (status == LW_OK)
        status = grow_lines(&w);
    return status;
}

lw_status lw_grow(const lw_structure *parent, lw_grow_visit *visit, void *context)
{
    return grow(parent, false, visit, context);
}

/* The canonical forms of the children of one parent, to leave out the second of two isomorphic ones. */
typedef struct siblings {
    lw_grow_visit *visit;
    void          *context;
    size_t         n, room;
    uint8_t      (*form)[LW_LINE_MAX][2];
} siblings;

static lw_status visit_first(void *context, lw_ear ear, const lw_structure *child)
{
    siblings *b = context;
    lw_structure form;
    lw_status status = lw_structure_canonical(child, &form);
    for (size_t k = 0; k < b->n && status == LW_OK; k++)
        if (memcmp(b->form[k], form.end, sizeof form.end) == 0)
            return LW_OK;
    if (status != LW_OK)
        return status;
    if (b->n == b->room) {
        size_t room = 2*b->room + 64;
        void *more = realloc(b->form, room*sizeof *b->form);
        if (!more)
            return LW_E_MEMORY;
        b->form = more;
        b->room = room;
    }
    memcpy(b->form[b->n++], form.end, sizeof form.end);
    return b->visit(b->context, ear, child);
}

/* Isomorphic children of one parent come from ears that an automorphism of the parent exchanges. */
lw_status lw_grow_once(const lw_structure *parent, lw_grow_visit *visit, void *context)
{
    siblings b = { .visit = visit, .context = context };
    lw_graph g;
    lw_symmetry_group group;
    lw_graph_of_structure(parent, &g);
    lw_status status = lw_graph_group(&g, &group);
    bool symmetric = group.n_generator > 0;
    lw_symmetry_group_free(&group);
    if (status == LW_OK)
        status = symmetric ? grow(parent, true, visit_first, &b) : grow(parent, true, visit, context);
    free(b.form);
    return status;
}

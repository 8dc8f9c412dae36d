#include "catalogues/curves/curves.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/bytes.h"
#include "base/growable_array.h"
#include "base/real.h"
#include "catalogues/curves/curves_internal.h"
#include "mbs/batch/batch.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/types.h"
#include "optimise/topology/mechanism_set.h"

#define FAMILY_BYTE 256               /* lw_curve_row.family is a byte                                */
#define SLOTS       64                /* topologies that a thread keeps                               */
#define POINTS     LW_CURVE_POINTS
#define REACH      2.0        /* tracers are drawn up to this distance from the middle of the coupler, in its lengths */
#define PARALLEL   1e-4       /* squared sine: two guides that become so nearly parallel may pass through infinity */
#define LEAST_PART 0.1          /* of the input's range, for an open curve                            */

typedef struct kind {
    const lw_family   *family;                                  /* NULL: a topology                */
    lw_plan           *plan;                                    /* of a family; owned              */
    int                shape[LW_SHAPE_MAX], n_shape, coupler;   /* indices of dimensions; -1: none */
    size_t             text;                                    /* where its word begins           */
    double             upto;                                    /* cumulative share of the samples */
} kind;

struct lw_curve_maker {
    int      n, n_family, capacity;                             /* n_family: of four links         */
    size_t   batch_size;                                        /* scratch of the plans, bytes     */
    double   c[POINTS], s[POINTS];                              /* cosine and sine over a full turn */
    lw_bytes families;
    kind    *kind;                                              /* (n), owned                      */
};

typedef struct scratch { double c[POINTS], s[POINTS], x[POINTS], y[POINTS], margin[POINTS]; } scratch;

struct lw_curve_work {
    scratch            w;
    void              *batch;
    int                index[SLOTS];                            /* which topology is in a slot     */
    lw_curve_topology *topology[SLOTS];                         /* owned; NULL: none               */
};

/* ---- making ---------------------------------------------------------------------------------------- */

static lw_status add_kind(lw_curve_maker *m, const char *text, double share, kind **to, lw_error *e)
{
    kind *more = lw_array_grow(m->kind, m->n, &m->capacity, sizeof *m->kind);
    m->kind = more ? more : m->kind;
    if (m->n == FAMILY_BYTE && m->n_family > 0)
        return lw_error_set(e, LW_E_ARG, "more than %d families, some of them of four links", FAMILY_BYTE);
    if (m->n > 0)
        lw_bytes_text(&m->families, ",");
    size_t at = m->families.size;
    lw_bytes_text(&m->families, text);
    if (!more || lw_bytes_end(&m->families, NULL) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *to = &m->kind[m->n];
    **to = (kind){ .text = at, .upto = (m->n > 0 ? m->kind[m->n - 1].upto : 0) + share };
    m->n++;
    return LW_OK;
}

lw_status lw_curve_maker_add(lw_curve_maker *m, const char *name, const lw_linkage *linkage, lw_error *e)
{
    char text[LW_CURVE_WORD];
    kind *to;
    lw_curve_topology *t;
    if (linkage->n_input != 1 || linkage->n_tracer < 1 || lw_curve_topology_text(name, linkage, text) != LW_OK)
        return lw_error_set(e, LW_E_ARG, "curves are drawn of linkages with one input, a tracer and few links");
    lw_status status = lw_curve_topology_make(text, &t, e);
    if (status != LW_OK)
        return status;
    lw_curve_topology_free(t);
    return add_kind(m, text, 1, &to, e);
}

static lw_status add_family(lw_curve_maker *m, const lw_family *f, lw_error *e)
{
    lw_linkage k;
    kind *to;
    m->n_family++;
    lw_status status = add_kind(m, f->name, f->blocks, &to, e);
    if (status != LW_OK)
        return status;
    to->family = f;
    to->plan = malloc(sizeof *to->plan);
    if (!to->plan)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_type_linkage(lw_type_find(f->type), &k);
    status = lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, to->plan, e);
    if (status != LW_OK)
        return status;
    to->coupler = lw_plan_dim(to->plan, "r3");
    for (int i = 0; f->shape[i]; i++)
        to->shape[to->n_shape++] = lw_plan_dim(to->plan, f->shape[i]);
    size_t size = lw_batch_work_size(to->plan);
    m->batch_size = size > m->batch_size ? size : m->batch_size;
    return LW_OK;
}

/* The next word of a comma-separated list. False: end of the list. */
static bool next_word(const char **list, char word[LW_CURVE_WORD])
{
    size_t n = strcspn(*list, ",");
    if (!**list)
        return false;
    snprintf(word, LW_CURVE_WORD, "%.*s", (int)(n < LW_CURVE_WORD ? n : LW_CURVE_WORD - 1), *list);
    *list += n + ((*list)[n] == ',');
    return true;
}

static lw_status create(lw_curve_maker **maker, lw_error *e)
{
    lw_curve_maker *m = calloc(1, sizeof *m);
    *maker = m;
    if (!m)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < POINTS; i++) {
        m->c[i] = cos(2*LW_PI*i/POINTS);
        m->s[i] = sin(2*LW_PI*i/POINTS);
    }
    return LW_OK;
}

static lw_status add_type(lw_curve_maker *m, const lw_type *type, lw_error *e)
{
    lw_status status = LW_OK;
    for (const lw_family *f = lw_family_table; f->name && status == LW_OK; f++)
        if (!type || strcmp(f->type, type->letters) == 0)
            status = add_family(m, f, e);
    return status;
}

lw_status lw_curve_maker_create(const char *types, lw_curve_maker **maker, lw_error *e)
{
    char word[LW_CURVE_WORD];
    lw_status status = create(maker, e);
    if (status == LW_OK && !types)
        return LW_OK;
    if (status == LW_OK && strcmp(types, "all") == 0)
        status = add_type(*maker, NULL, e);
    else
        while (status == LW_OK && next_word(&types, word)) {
            const lw_type *t = lw_type_find(word);
            status = t ? add_type(*maker, t, e)
                   : lw_error_set(e, LW_E_ARG, "there is no type '%.60s'; 'linkwright help fit' lists them", word);
        }
    if (status == LW_OK && (*maker)->n == 0)
        status = lw_error_set(e, LW_E_ARG, "no type of linkage is named");
    if (status != LW_OK) {
        lw_curve_maker_free(*maker);
        *maker = NULL;
    }
    return status;
}

static lw_status add_word(lw_curve_maker *m, const char *word, lw_error *e)
{
    char name[64];
    lw_mechanism topology;
    kind *to;
    const lw_family *f = lw_family_table;
    while (f->name && strcmp(f->name, word) != 0)
        f++;
    if (f->name)
        return add_family(m, f, e);
    if (lw_text_has_control(word))           /* its linkages would have this name */
        return lw_error_set(e, LW_E_NOTATION, "the name of a family holds a control character");
    if (m->n < FAMILY_BYTE && !lw_curve_topology_read(word, name, &topology))
        return lw_error_set(e, LW_E_NOTATION, "there is no family '%.60s' in this program", word);
    return add_kind(m, word, 1, &to, e);
}

lw_status lw_curve_maker_of(const char *families, lw_curve_maker **maker, lw_error *e)
{
    char word[LW_CURVE_WORD];
    lw_status status = create(maker, e);
    while (status == LW_OK && next_word(&families, word))
        status = add_word(*maker, word, e);
    if (status != LW_OK) {
        lw_curve_maker_free(*maker);
        *maker = NULL;
    }
    return status;
}

/* The topologies with so many links. */
static lw_status add_set(lw_curve_maker *m, const lw_mechanism_set *all, int links, const volatile int *interrupt, lw_error *e)
{
    lw_status status = LW_OK;
    lw_family_made *made = malloc(sizeof *made);
    if (!made)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < all->n; i++) {
        lw_families f = lw_mechanism_stage_families(&all->stage[i]);
        for (int n = 0; n < f.n && all->stage[i].links == links && status == LW_OK; n++) {
            lw_error wrong = { .text = "" };
            status = interrupt && *interrupt ? LW_STOPPED : f.make(f.of, n, made);
            if (status == LW_OK)
                status = lw_curve_maker_add(m, made->name, &made->linkage, &wrong);
            status = status == LW_E_KIND ? LW_OK : status;
            if (status != LW_OK)
                lw_error_set(e, status, "%s", status == LW_STOPPED ? "stopped before all mechanisms were set up"
                             : wrong.text[0] ? wrong.text : lw_status_text(status));
        }
    }
    free(made);
    return status;
}

lw_status lw_curve_maker_links(int links, const char *kinds, int jobs, const volatile int *interrupt, lw_curve_maker **maker, lw_error *e)
{
    lw_mechanism_set all;
    lw_mechanism_request request = { .links = links, .dof = 1, .kinds = kinds, .only = "all", .task = LW_TASK_PATH,
                                     .jobs = jobs, .interrupt = interrupt };
    lw_status status = lw_curve_maker_create(NULL, maker, e);
    if (status != LW_OK)
        return status;
    status = lw_mechanism_set_make(&request, &all, e);
    if (status == LW_NOTHING)
        status = lw_error_set(e, LW_STOPPED, "stopped before all mechanisms were found");
    if (status == LW_OK) {
        status = add_set(*maker, &all, links, interrupt, e);
        lw_mechanism_set_free(&all);
    }
    if (status != LW_OK) {
        lw_curve_maker_free(*maker);
        *maker = NULL;
    }
    return status;
}

void lw_curve_maker_free(lw_curve_maker *maker)
{
    if (!maker)
        return;
    for (int i = 0; i < maker->n; i++)
        free(maker->kind[i].plan);
    free(maker->kind);
    lw_bytes_free(&maker->families);
    free(maker);
}

const char *lw_curve_maker_families(const lw_curve_maker *maker) { return maker->n > 0 ? maker->families.data : ""; }

/* The family of a row; -1: there is none. */
static int index_of(const lw_curve_maker *m, const lw_curve_row *row)
{
    uint32_t at = row->family + (m->n > FAMILY_BYTE ? (uint32_t)FAMILY_BYTE*(row->more & 0xffffff) : 0);
    return at < (uint32_t)m->n ? (int)at : -1;
}

static void word_of(const lw_curve_maker *m, int index, char word[LW_CURVE_WORD])
{
    const char *text = m->families.data + m->kind[index].text;
    next_word(&text, word);
}

bool lw_curve_family(const lw_curve_maker *maker, const lw_curve_row *row, char name[64], const char **type)
{
    char word[LW_CURVE_WORD];
    int at = index_of(maker, row);
    if (at < 0)
        return false;
    *type = maker->kind[at].family ? maker->kind[at].family->type : NULL;
    word_of(maker, at, word);
    snprintf(name, 64, "%.*s", (int)strcspn(word, "="), word);
    for (char *c = name; *c; c++)
        *c = *c == ';' ? ',' : *c;
    return true;
}

lw_status lw_curve_work_create(const lw_curve_maker *maker, lw_curve_work **work)
{
    lw_curve_work *w = calloc(1, sizeof *w);
    *work = w;
    if (w)
        w->batch = aligned_alloc(64, maker->batch_size/64*64 + 64);
    if (w && w->batch)
        return LW_OK;
    free(w);
    *work = NULL;
    return LW_E_MEMORY;
}

void lw_curve_work_free(lw_curve_work *work)
{
    if (!work)
        return;
    for (int i = 0; i < SLOTS; i++)
        lw_curve_topology_free(work->topology[i]);
    free(work->batch);
    free(work);
}

/* The topology of a row, made now unless it is in its slot. */
static lw_status topology_of(const lw_curve_maker *m, const lw_curve_row *row, lw_curve_work *work, lw_curve_topology **t)
{
    int at = index_of(m, row), slot = at%SLOTS;
    char word[LW_CURVE_WORD];
    if (!work->topology[slot] || work->index[slot] != at) {
        lw_curve_topology_free(work->topology[slot]);
        work->topology[slot] = NULL;
        word_of(m, at, word);
        lw_status status = lw_curve_topology_make(word, &work->topology[slot], NULL);
        if (status != LW_OK)
            return status;
        work->index[slot] = at;
    }
    *t = work->topology[slot];
    return LW_OK;
}

/* ---- postures ---------------------------------------------------------------------------------------- */

/* Set the inputs of lanes from..to-1 between `first` and `last`. ends: spaced like a cosine, dense near the ends, where
 * the linkage may be at a limit and move fast. */
static void set_inputs(const lw_plan *plan, scratch *w, int from, int to, double first, double last, bool ends)
{
    int n = to - from;
    for (int i = 0; i < n; i++) {
        double t = ends ? i/(double)(n - 1) : i/(double)n;
        double input = 0.5*(first + last) - 0.5*(last - first)*cos(LW_PI*t);
        w->c[from + i] = plan->input_is_slider ? input : cos(input);
        w->s[from + i] = plan->input_is_slider ? 0 : sin(input);
    }
}

static void solve_modes(const lw_plan *plan, const double *dim, const double *modes, const double *c, const double *s,
                        int from, int to, scratch *w, void *batch)
{
    lw_lanes in = { .n = (size_t)(to - from), .c = c + from, .s = s + from, .dim = dim, .mode = modes };
    lw_batch_point(plan, &in, 0, batch, w->x + from, w->y + from, NULL, NULL, w->margin + from);
}

static void solve(const lw_plan *plan, const double *dim, double mode, const double *c, const double *s, int from, int to,
                  scratch *w, void *batch)
{
    double modes[LW_DYAD_MAX];
    for (int i = 0; i < plan->n_dyad; i++)
        modes[i] = mode;
    solve_modes(plan, dim, modes, c, s, from, to, w, batch);
}

/* ---- drawing --------------------------------------------------------------------------------------- */

static void set_dims(const kind *k, const lw_curve_row *row, double *dim)
{
    memset(dim, 0, sizeof *dim*(size_t)k->plan->n_dim);
    for (int i = 0; i < k->n_shape; i++)
        dim[k->shape[i]] = row->dim[i];
    dim[k->plan->i_cx[0]] = row->dim[LW_SHAPE_MAX];
    dim[k->plan->i_cy[0]] = row->dim[LW_SHAPE_MAX + 1];
}

/* Draw a tracer: dense in the middle of the coupler, rarer towards REACH times its length. */
static void draw_tracer(const kind *k, const double *u, lw_curve_row *row)
{
    double coupler = 1, middle = 0;
    for (int i = 0; i < k->n_shape; i++)
        if (k->shape[i] == k->coupler) {
            coupler = row->dim[i];
            middle = 0.5*coupler;
        }
    lw_vec2 at = lw_v2_polar(REACH*coupler*u[0], 2*LW_PI*u[1]);
    row->dim[LW_SHAPE_MAX] = (float)(middle + at.x);
    row->dim[LW_SHAPE_MAX + 1] = (float)at.y;
}

/* Draw a part of the input range a .. b: u[0] gives its place, u[1] its size. */
static void draw_piece(const double *u, double a, double b, bool turns, lw_curve_row *row)
{
    double part = LEAST_PART + (1 - LEAST_PART)*u[1];
    double from = a + (b - a)*u[0]*(turns ? 1 : 1 - part);
    row->first = (float)from;
    row->last = (float)(from + (b - a)*part);
}

/* A row of a topology. */
typedef struct member {
    lw_curve_topology *topology;
    double   dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    lw_range range;
} member;

/* Draw the linkage of a row.  LW_OPEN: this row gives no linkage. */
static lw_status member_of(const lw_curve_maker *m, const lw_curve_row *row, lw_curve_work *work, member *t)
{
    lw_status status = topology_of(m, row, work, &t->topology);
    if (status != LW_OK)
        return status;
    return lw_curve_topology_draw(t->topology, row->key, row->mode > 0, t->dim, t->mode, &t->range) ? LW_OK : LW_OPEN;
}

/* The least margin of the postures, and between them that of the parabola through a least value and its neighbours, since the margin is
 * smooth: below 0 a dyad fails to close on the way. */
static double least_margin(const double *margin, bool round)
{
    double least = INFINITY;
    for (int i = 0; i < POINTS; i++) {
        double here = margin[i];
        double to_last = margin[(i + POINTS - 1)%POINTS] - here, to_next = margin[(i + 1)%POINTS] - here;
        least = fmin(least, here);
        if ((round || (i > 0 && i < POINTS - 1)) && to_last > 0 && to_next > 0)
            least = fmin(least, here - (to_next - to_last)*(to_next - to_last)/(8*(to_last + to_next)));
    }
    return least;
}

static void solve_member(const lw_curve_maker *m, const lw_curve_row *row, bool closed, const member *t, scratch *w)
{
    const lw_plan *plan = &t->topology->problem.plan;
    if (!closed)
        set_inputs(plan, w, 0, POINTS, row->first, row->last, true);
    solve_modes(plan, t->dim, t->mode, closed ? m->c : w->c, closed ? m->s : w->s, 0, POINTS, w, t->topology->batch);
}

static lw_status draw_member(const lw_curve_maker *m, const double *u, bool closed, lw_curve_work *work, lw_curve_row *row)
{
    member t;
    uint64_t key = (uint64_t)(u[1]*0x1p53)*0x9e3779b97f4a7c15u ^ (uint64_t)(u[2]*0x1p53)*0xbf58476d1ce4e5b9u;
    row->key[0] = (uint32_t)key;
    row->key[1] = (uint32_t)(key >> 32);
    row->mode = closed ? 1 : -1;
    lw_status status = member_of(m, row, work, &t);
    if (status != LW_OK || !(t.range.last - t.range.first > 1e-6))
        return status == LW_OK ? LW_OPEN : status;
    row->first = (float)t.range.first;
    row->last = (float)t.range.last;
    if (!closed)
        draw_piece(u + 6, t.range.first, t.range.last, t.range.turns, row);
    solve_member(m, row, closed, &t, &work->w);
    const double *margin = work->w.margin;
    return least_margin(margin, closed) < (t.topology->slides ? PARALLEL : 0) ? LW_OPEN : LW_OK;
}

lw_status lw_curve_draw(const lw_curve_maker *maker, const double *u, bool closed, lw_curve_work *work, lw_curve_row *row)
{
    double shape[LW_SHAPE_MAX] = { 0 }, dim[LW_DIM_MAX];
    int which = 0;
    lw_range range = { .first = 0, .last = 2*LW_PI, .turns = true };
    if (maker->n == 0)
        return LW_OPEN;
    for (int last = maker->n - 1; which < last;) {                           /* the first whose share is not below u[0] */
        int middle = (which + last)/2;
        bool beyond = u[0]*maker->kind[maker->n - 1].upto >= maker->kind[middle].upto;
        which = beyond ? middle + 1 : which;
        last = beyond ? last : middle;
    }
    const kind *k = &maker->kind[which];
    *row = (lw_curve_row){ .family = (uint8_t)which, .mode = 1 };
    if (!k->family) {
        row->more = (uint32_t)which/FAMILY_BYTE;
        return draw_member(maker, u, closed, work, row);
    }
    k->family->draw(u + 1, shape);
    for (int i = 0; i < k->n_shape; i++)
        row->dim[i] = (float)shape[i];
    draw_tracer(k, u + 4, row);
    set_dims(k, row, dim);
    if (!k->family->turns && lw_motion_range(k->plan, dim, 1, &range) != LW_OK)
        return LW_OPEN;
    if (!(range.last - range.first > 1e-6))
        return LW_OPEN;
    if (!closed) {
        /* the linkage passes through the limits into the other assembly mode: draw both */
        double at = u[6]*2;
        row->mode = !range.turns && range.limits && at >= 1 ? -1 : 1;
        draw_piece((double[2]){ range.turns ? u[6] : at - (at >= 1), u[7] }, range.first, range.last, range.turns, row);
        return LW_OK;
    }
    if (!range.turns && !range.limits)
        return LW_OPEN;
    row->mode = range.turns ? 1 : 0;
    row->first = (float)range.first;
    row->last = (float)range.last;
    return LW_OK;
}

/* ---- points ----------------------------------------------------------------------------------------- */

/* Solve all postures of a four-bar. */
static lw_status solve_type(const lw_curve_maker *maker, const lw_curve_row *row, bool closed, lw_curve_work *work, lw_curve_traits *traits)
{
    const kind *k = &maker->kind[row->family];
    scratch *w = &work->w;
    double dim[LW_DIM_MAX];
    lw_range range = { .turns = k->family->turns || (closed && row->mode != 0) };
    set_dims(k, row, dim);
    if (closed && row->mode != 0) {
        solve(k->plan, dim, row->mode, maker->c, maker->s, 0, POINTS, w, work->batch);
    } else if (closed) {
        set_inputs(k->plan, w, 0, POINTS/2, row->first, row->last, false);
        set_inputs(k->plan, w, POINTS/2, POINTS, row->last, row->first, false);
        solve(k->plan, dim, 1, w->c, w->s, 0, POINTS/2, w, work->batch);
        solve(k->plan, dim, -1, w->c, w->s, POINTS/2, POINTS, w, work->batch);
    } else {
        set_inputs(k->plan, w, 0, POINTS, row->first, row->last, true);
        solve(k->plan, dim, row->mode, w->c, w->s, 0, POINTS, w, work->batch);
        if (traits && !range.turns && lw_motion_range(k->plan, dim, 1, &range) != LW_OK)
            return LW_OPEN;
    }
    if (traits)
        traits->turns = range.turns;
    return LW_OK;
}

static lw_status solve_topology(const lw_curve_maker *m, const lw_curve_row *row, bool closed, lw_curve_work *work, lw_curve_traits *traits)
{
    member t;
    lw_status status = member_of(m, row, work, &t);
    if (status != LW_OK)
        return status;
    solve_member(m, row, closed, &t, &work->w);
    if (traits)
        traits->turns = closed || t.range.turns;
    return LW_OK;
}

lw_status lw_curve_points(const lw_curve_maker *maker, const lw_curve_row *row, bool closed, lw_curve_work *work, lw_vec2 *p,
                          lw_curve_traits *traits)
{
    const scratch *w = &work->w;
    int at = index_of(maker, row);
    if (at < 0)
        return LW_OPEN;
    bool topology = !maker->kind[at].family, limits = closed && !topology && row->mode == 0;
    lw_status status = (topology ? solve_topology : solve_type)(maker, row, closed, work, traits);
    if (status != LW_OK)
        return status;
    for (int i = 0; i < POINTS; i++)
        p[i] = lw_v2(w->x[i], w->y[i]);
    if (traits)
        traits->transmission = limits ? 0 : asin(sqrt(fmin(fmax(least_margin(w->margin, closed), 0), 1)));
    return LW_OK;
}

void lw_curve_row_note(lw_curve_row *row, const lw_curve_traits *traits)
{
    row->turns = traits->turns ? 2 : 1;
    row->transmission = (uint8_t)(1 + floor(traits->transmission*360/LW_PI));
}

bool lw_curve_row_may(const lw_curve_row *row, bool turns, double least)
{
    /* one unit more than the rounding, because processors may round differently */
    return !(turns && row->turns == 1) && (row->transmission == 0 || row->transmission + 1.0 >= least*360/LW_PI);
}

/* ---- the linkage ----------------------------------------------------------------------------------- */

static lw_status member_linkage(const lw_curve_maker *m, const lw_curve_row *row, lw_curve_work *work, lw_linkage *linkage)
{
    member t;
    lw_status status = member_of(m, row, work, &t);
    if (status != LW_OK)
        return status;
    *linkage = t.topology->linkage;
    snprintf(linkage->name, sizeof linkage->name, "%s", t.topology->name);
    return lw_plan_write(&t.topology->problem.plan, t.dim, t.mode, 0.5*(row->first + row->last), linkage);
}

static lw_status type_linkage(const lw_curve_maker *maker, const lw_curve_row *row, lw_linkage *linkage)
{
    double dim[LW_DIM_MAX], modes[LW_DYAD_MAX];
    const kind *from = &maker->kind[row->family];
    set_dims(from, row, dim);
    for (int i = 0; i < from->plan->n_dyad; i++)
        modes[i] = row->mode < 0 ? -1 : 1;
    lw_type_linkage(lw_type_find(from->family->type), linkage);
    return lw_plan_write(from->plan, dim, modes, 0.5*(row->first + row->last), linkage);
}

lw_status lw_curve_linkage(const lw_curve_maker *maker, const lw_curve_row *row, bool closed, lw_curve_work *work, lw_linkage *linkage)
{
    int at = index_of(maker, row);
    if (at < 0)
        return LW_OPEN;
    lw_status status = maker->kind[at].family ? type_linkage(maker, row, linkage)
                                              : member_linkage(maker, row, work, linkage);
    if (status == LW_OK && !closed) {
        double half = 0.5*fabs(row->last - row->first);
        linkage->input[0].first = linkage->input[0].value - half;
        linkage->input[0].last = linkage->input[0].value + half;
    }
    return status;
}

static lw_vec2 lay(lw_vec2 p, bool mirrored, lw_vec2 turn_and_size)
{
    return lw_v2_turn(mirrored ? lw_v2(p.x, -p.y) : p, turn_and_size);
}

void lw_linkage_lay(lw_linkage *linkage, bool mirrored, double turn, double size, lw_vec2 shift)
{
    lw_vec2 along = lw_v2_polar(1, turn), all = lw_v2_scale(along, size);
    double sense = mirrored ? -1 : 1;
    for (int j = 0; j < linkage->n_joint; j++) {
        linkage->joint[j].at = lw_v2_add(shift, lay(linkage->joint[j].at, mirrored, all));
        linkage->joint[j].along = lay(linkage->joint[j].along, mirrored, along);
        double length = lw_v2_norm(linkage->joint[j].along);
        if (length > 0)
            linkage->joint[j].along = lw_v2_scale(linkage->joint[j].along, 1/length);
    }
    for (int i = 0; i < linkage->n_tracer; i++) {
        linkage->tracer[i].at = lw_v2_add(shift, lay(linkage->tracer[i].at, mirrored, all));
        linkage->tracer[i].angle = sense*linkage->tracer[i].angle + turn;
    }
    for (int i = 0; i < linkage->n_input; i++) {
        lw_input *in = &linkage->input[i];
        const lw_joint *j = &linkage->joint[in->joint];
        bool pin = lw_joint_turns(j->kind), ground = j->link[0] == linkage->ground || j->link[1] == linkage->ground;
        double by = pin ? sense : size, plus = pin && ground ? turn : 0, first = in->first;
        bool all_of_it = in->first == in->last;
        in->value = by*in->value + plus;
        if (all_of_it)
            continue;
        in->first = by*(pin && mirrored ? in->last : first) + plus;
        in->last = by*(pin && mirrored ? first : in->last) + plus;
    }
}

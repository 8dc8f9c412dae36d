/* enumerate/recount.c - recounts the rows of the published table.  To recount another wording, add a row to
 * `wordings` or a family to `families`. */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "enumerate/chains.h"
#include "enumerate/estimate.h"
#include "enumerate/fractionated.h"
#include "enumerate/higher.h"
#include "enumerate/inputs.h"
#include "enumerate/invert.h"
#include "enumerate/multiple.h"
#include "enumerate/published.h"
#include "grammar/topology/planar.h"

#define FRACTIONATED_MAX 4096

/* All counts for the chains with one P and F; each part is computed when first needed. */
typedef struct chain_numbers {
    struct chain_numbers *next;
    int            n_link, dof;
    bool           have[4];                             /* by `enum part` below                         */
    lw_chains     *chains;
    lw_chain_table table;
    lw_tally       nonplanar, asymmetric;
    uint64_t       n_fractionated, n_bridged, n_fractionated_nonplanar, n_fractionated_ground;
    lw_assortment  of_fractionated[FRACTIONATED_MAX];
} chain_numbers;

enum part { TABLE, NONPLANAR, ASYMMETRIC, FRACTIONATED };

struct lw_recount { int n_thread; bool (*goes_on)(void *context); void *context; chain_numbers *first; };

lw_recount *lw_recount_create(int n_thread, bool (*goes_on)(void *context), void *context)
{
    lw_recount *r = calloc(1, sizeof *r);
    if (r)
        *r = (lw_recount){ .n_thread = n_thread, .goes_on = goes_on, .context = context };
    return r;
}

void lw_recount_free(lw_recount *r)
{
    while (r && r->first) {
        chain_numbers *n = r->first;
        r->first = n->next;
        lw_chain_table_free(&n->table);
        lw_chains_free(n->chains);
        free(n);
    }
    free(r);
}

/* ---- chains with simple joints ----------------------------------------------------------------- */

static chain_numbers *numbers_of(lw_recount *r, int n_link, int dof)
{
    for (chain_numbers *n = r->first; n; n = n->next)
        if (n->n_link == n_link && n->dof == dof)
            return n;
    chain_numbers *n = calloc(1, sizeof *n);
    if (n) {
        *n = (chain_numbers){ .next = r->first, .n_link = n_link, .dof = dof };
        r->first = n;
    }
    return n;
}

static bool goes_on(void *context)
{
    const lw_recount *r = context;
    return !r->goes_on || r->goes_on(r->context);
}

static bool structures_tick(void *context, int loops, size_t found)
{
    (void)loops, (void)found;
    return goes_on(context);
}

static bool chains_tick(void *context, double done)
{
    (void)done;
    return goes_on(context);
}

typedef struct fractionated { lw_recount *r; chain_numbers *n; } fractionated;

static lw_status tally_fractionated(void *context, const lw_chain *c, int n_bridge)
{
    const fractionated *f = context;
    chain_numbers *n = f->n;
    uint8_t lowest[LW_LINK_MAX];
    int n_class = 0;
    bool planar = true;
    lw_status s = goes_on(f->r) ? lw_chain_orbits(c, lowest, &n_class) : LW_STOPPED;
    if (s == LW_OK)
        s = lw_planar_chain(c, &planar);
    if (n->n_fractionated < FRACTIONATED_MAX)
        for (int i = 0; i < c->n_link; i++)
            if (lw_chain_degree(c, i) < LW_LOOP_MAX + 2)
                n->of_fractionated[n->n_fractionated].n_with[lw_chain_degree(c, i)]++;
    n->n_fractionated++;
    n->n_bridged += n_bridge > 0;
    n->n_fractionated_nonplanar += !planar;
    n->n_fractionated_ground += (uint64_t)n_class;
    return s;
}

static lw_chain_walk walk_of(lw_recount *r)
{
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = r->n_thread;
    how.tick = chains_tick;
    how.tick_context = r;
    return how;
}

static lw_status count_filtered(lw_recount *r, chain_numbers *n, const char *filter, lw_tally *tally)
{
    lw_chain_walk how = walk_of(r);
    lw_chain_table table;
    how.filter = lw_filter_find(filter);
    lw_status s = lw_chains_count(n->chains, &how, &table);
    *tally = table.total;
    lw_chain_table_free(&table);
    return s;
}

/* A count that was given up begins again. */
static lw_status count_fractionated(lw_recount *r, chain_numbers *n)
{
    n->n_fractionated = n->n_bridged = n->n_fractionated_nonplanar = n->n_fractionated_ground = 0;
    memset(n->of_fractionated, 0, sizeof n->of_fractionated);
    return lw_fractionated_each(n->n_link, n->dof, tally_fractionated, &(fractionated){ r, n }, NULL);
}

/* Estimated seconds for a part; 0 if it is already computed. */
static double seconds_of(const chain_numbers *n, enum part part)
{
    lw_estimate e;
    if (n->have[part] || lw_chains_estimate(n->n_link, n->dof, &e, NULL) != LW_OK)
        return 0;
    double structures = n->chains ? 0 : e.structure_seconds;
    switch (part) {
    case TABLE:        return structures + e.count_seconds;
    case NONPLANAR:    return structures + e.count_seconds;
    case ASYMMETRIC:   return structures + e.list_seconds + 6e-6*e.chains;
    case FRACTIONATED: return n->dof < 2 ? 0 : 1e-5*e.chains;
    }
    return 0;
}

static lw_status count_part(lw_recount *r, chain_numbers *n, enum part part)
{
    lw_status s = LW_OK;
    lw_chain_walk how = walk_of(r);
    if (n->have[part])
        return LW_OK;
    if (!n->chains)
        s = lw_chains_create_while(n->n_link, n->dof, r->n_thread, NULL, structures_tick, r, &n->chains, NULL);
    if (s == LW_OK && part == TABLE) {
        lw_chain_table_free(&n->table);      /* of a count that was given up */
        s = lw_chains_count(n->chains, &how, &n->table);
    }
    if (s == LW_OK && part == NONPLANAR)
        s = count_filtered(r, n, "non-planar", &n->nonplanar);
    if (s == LW_OK && part == ASYMMETRIC)
        s = count_filtered(r, n, "asymmetric", &n->asymmetric);
    if (s == LW_OK && part == FRACTIONATED)
        s = count_fractionated(r, n);
    n->have[part] = s == LW_OK;
    return s;
}

/* "... [4 2 0 1]": links with `from`, from + 1, ... joints. */
static lw_assortment read_assortment(const char *what, int from)
{
    lw_assortment a = { { 0 } };
    const char *at = strchr(what, '=') ? strchr(strchr(what, '='), '[') : NULL;
    char *end;
    if (!at)
        return a;
    at++;
    for (int i = from; i < LW_LOOP_MAX + 2; i++, at = end) {
        a.n_with[i] = (int)strtol(at, &end, 10);
        if (end == at)
            break;
    }
    return a;
}

static lw_tally in_table(const chain_numbers *n, const lw_assortment *links)
{
    for (size_t k = 0; k < n->table.n_row; k++)
        if (memcmp(&n->table.row[k].links, links, sizeof *links) == 0)
            return n->table.row[k].n;
    return (lw_tally){ 0, 0, 0 };
}

typedef enum number { ALL, WHOLE, GROUNDS, ALL_GROUNDS, ALL_OF, WHOLE_OF, GROUNDS_OF, NONPLANAR_WHOLE, NONPLANAR_ALL,
                      ASYMMETRIC_ONES, CUT, BRIDGED } number;

/* The first row whose text the wording begins with, and the parts it needs as bits. */
static const struct { const char *begin; number number; unsigned parts; } wordings[] = {
    { "all chains; assortment", ALL_OF, 1u << TABLE | 1u << FRACTIONATED },
    { "all chains with nonplanar", NONPLANAR_ALL, 1u << NONPLANAR | 1u << FRACTIONATED },
    { "all chains", ALL, 1u << TABLE | 1u << FRACTIONATED },
    { "chains (matches all", ALL, 1u << TABLE | 1u << FRACTIONATED },
    { "12-bar count", ALL, 1u << TABLE | 1u << FRACTIONATED },
    { "nonfractionated; assortment", WHOLE_OF, 1u << TABLE },
    { "assortment", WHOLE_OF, 1u << TABLE },
    { "inversions; assortment", GROUNDS_OF, 1u << TABLE },
    { "inversions of all chains", ALL_GROUNDS, 1u << TABLE | 1u << FRACTIONATED },
    { "inversions of nonfractionated", GROUNDS, 1u << TABLE },
    { "groups with N links", GROUNDS, 1u << TABLE },
    { "nonfractionated chains with nonplanar", NONPLANAR_WHOLE, 1u << NONPLANAR },
    { "chains with nonplanar", NONPLANAR_WHOLE, 1u << NONPLANAR },
    { "trusses with nonplanar", NONPLANAR_WHOLE, 1u << NONPLANAR },
    { "nonfractionated chains", WHOLE, 1u << TABLE },
    { "trusses", WHOLE, 1u << TABLE },
    { "chains with trivial automorphism", ASYMMETRIC_ONES, 1u << ASYMMETRIC },
    { "fractionated chains (have a cut link)", CUT, 1u << FRACTIONATED },
    { "fractionated chains that have a separating joint", BRIDGED, 1u << FRACTIONATED },
};

static uint64_t number_of(const chain_numbers *n, number which, const char *what)
{
    lw_assortment links = read_assortment(what, 2);
    uint64_t of_fractionated = 0;
    for (uint64_t k = 0; k < n->n_fractionated && k < FRACTIONATED_MAX; k++)
        of_fractionated += memcmp(&n->of_fractionated[k], &links, sizeof links) == 0;
    switch (which) {
    case ALL:             return n->table.total.n_chain + n->n_fractionated;
    case WHOLE:           return n->table.total.n_chain;
    case GROUNDS:         return n->table.total.n_ground;
    case ALL_GROUNDS:     return n->table.total.n_ground + n->n_fractionated_ground;
    case ALL_OF:          return in_table(n, &links).n_chain + of_fractionated;
    case WHOLE_OF:        return in_table(n, &links).n_chain;
    case GROUNDS_OF:      return in_table(n, &links).n_ground;
    case NONPLANAR_WHOLE: return n->nonplanar.n_chain;
    case NONPLANAR_ALL:   return n->nonplanar.n_chain + n->n_fractionated_nonplanar;
    case ASYMMETRIC_ONES: return n->asymmetric.n_chain;
    case CUT:             return n->n_fractionated;
    case BRIDGED:         return n->n_bridged;
    }
    return 0;
}

/* The result of a family: a number, or one of these. */
enum { NO_WAY = -1, TOO_LONG = -2 };

typedef struct job { lw_recount *r; const lw_published *row; double limit, seconds; long long n; } job;

static lw_status count_simple(job *j, int n_link)
{
    size_t k = 0, n_wording = sizeof wordings/sizeof *wordings;
    chain_numbers *n = numbers_of(j->r, n_link, j->row->dof);
    if (!n)
        return LW_E_MEMORY;
    while (k < n_wording && strncmp(j->row->what, wordings[k].begin, strlen(wordings[k].begin)) != 0)
        k++;
    j->n = NO_WAY;
    if (k == n_wording)
        return LW_OK;
    for (int part = TABLE; part <= FRACTIONATED; part++)
        if (wordings[k].parts >> part & 1)
            j->seconds += seconds_of(n, (enum part)part);
    j->n = TOO_LONG;
    if (j->seconds > j->limit)
        return LW_OK;
    for (int part = TABLE; part <= FRACTIONATED; part++) {
        lw_status s = wordings[k].parts >> part & 1 ? count_part(j->r, n, (enum part)part) : LW_OK;
        if (s != LW_OK)
            return s;
    }
    j->n = (long long)number_of(n, wordings[k].number, j->row->what);
    return LW_OK;
}

static lw_status simple_chains(job *j) { return count_simple(j, j->row->links); }
static lw_status assur_groups(job *j) { return count_simple(j, j->row->links + 1); }

/* ---- structures -------------------------------------------------------------------------------- */

/* Rows for one number of circles, for one assortment of circles, or for all. */
static lw_status structures(job *j)
{
    bool by_circles = j->row->links >= 0 && !strchr(j->row->what, '=');
    bool by_assortment = strchr(j->row->what, '=') != NULL;
    lw_assortment want = read_assortment(j->row->what, 3);
    lw_structures *set;
    j->n = NO_WAY;
    if (j->row->loops < 2 || j->row->loops > 7)
        return LW_OK;
    lw_status s = lw_structures_create_while(j->row->loops, j->r->n_thread, structures_tick, j->r, &set);
    if (s != LW_OK)
        return s;
    j->n = 0;
    for (size_t i = 0; i < lw_structures_count(set, j->row->loops); i++) {
        lw_structure one;
        lw_assortment has = { { 0 } };
        uint8_t degree[LW_CIRCLE_MAX];
        lw_structures_get(set, j->row->loops, i, &one);
        lw_structure_degrees(&one, degree);
        for (int c = 0; c < one.n_circle; c++)
            has.n_with[degree[c]]++;
        j->n += by_circles ? one.n_circle == j->row->links : !by_assortment || !memcmp(&has, &want, sizeof has);
    }
    lw_structures_free(set);
    return LW_OK;
}

/* ---- multiple joints, higher pairs, sliders ---------------------------------------------------- */

/* "{2 2}" of the row against the multiplicities of a chain, rising. */
typedef struct pins { lw_recount *r; long long n; bool any; int n_want, want[LW_JOINT_MAX]; } pins;

static lw_status match_pins(void *context, const lw_multiple *m)
{
    pins *p = context;
    int n = 0;
    bool same = true;
    for (int k = m->n_pin - 1; k >= 0; k--) {
        int joints = __builtin_popcount(m->pin[k]) - 1;
        if (joints < 2)
            continue;
        same = same && n < p->n_want && p->want[n] == joints;
        n++;
    }
    p->n += p->any || (same && n == p->n_want);
    return goes_on(p->r) ? LW_OK : LW_STOPPED;
}

static lw_status multiple_joints(job *j)
{
    pins p = { .r = j->r, .any = true };
    const char *at = strchr(j->row->what, '{');
    j->n = NO_WAY;
    if (j->row->links > 10)
        return LW_OK;
    if (at) {
        char *end;
        p.any = false;
        for (at++; p.n_want < LW_JOINT_MAX; at = end) {
            int v = (int)strtol(at, &end, 10);
            if (end == at)
                break;
            p.want[p.n_want++] = v;
        }
    }
    lw_status s = lw_multiple_each(j->row->links, j->row->dof, j->r->n_thread, match_pins, &p, NULL);
    j->n = p.n;
    return s;
}

typedef struct higher_count { lw_recount *r; long long n; } higher_count;

static lw_status count_higher(void *context, const lw_chain *c)
{
    (void)c;
    ((higher_count *)context)->n++;
    return LW_OK;
}

static bool higher_tick(void *context)
{
    return goes_on(((const higher_count *)context)->r);
}

/* "chains with 3 higher pairs" */
static lw_status higher_pairs(job *j)
{
    const char *at = strpbrk(j->row->what, "0123456789");
    higher_count n = { .r = j->r };
    int n2 = at ? atoi(at) : -1;
    j->n = NO_WAY;
    if (n2 < 0 || j->row->links + n2 > 14)
        return LW_OK;
    lw_status s = lw_higher_each_while(j->row->links, j->row->dof, n2, j->r->n_thread, higher_tick, count_higher, &n, NULL);
    j->n = n.n;
    return s;
}

typedef struct sliders { long long n_valid, n_void, n_ground, n_with; int want; } sliders;

static lw_status count_slider_ground(void *context, const lw_mechanism *m)
{
    (void)m;
    ((sliders *)context)->n_ground++;
    return LW_OK;
}

static lw_status count_sliders(void *context, const lw_mechanism *m)
{
    sliders *s = context;
    int n = 0;
    for (int j = 0; j < m->n_joint; j++)
        n += lw_joint_holds_rotation(m->kind[j]);
    s->n_valid++;
    s->n_with += n == s->want;
    return lw_grounds_each(m, count_slider_ground, s);
}

static lw_status count_void(void *context, const lw_mechanism *m, lw_void reason, uint64_t joints)
{
    (void)m, (void)reason, (void)joints;
    ((sliders *)context)->n_void++;
    return LW_OK;
}

static lw_status label_chain(void *context, const lw_chain_item *item)
{
    lw_mechanism m;
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    return s == LW_OK ? lw_kinds_each(&m, "rt", count_sliders, count_void, context) : s;
}

static lw_status with_sliders(job *j)
{
    const char *what = j->row->what, *at = strpbrk(what, "0123456789");
    sliders n = { .want = at ? atoi(at) : 0 };
    lw_chain_walk how = walk_of(j->r);
    lw_chains *chains;
    j->n = NO_WAY;
    if (j->row->links > 8)
        return LW_OK;
    lw_status s = lw_chains_create_while(j->row->links, j->row->dof, j->r->n_thread, NULL, structures_tick, j->r, &chains, NULL);
    if (s != LW_OK)
        return s;
    s = lw_chains_each(chains, &how, label_chain, &n);
    lw_chains_free(chains);
    j->n = strncmp(what, "raw", 3) == 0 ? n.n_valid + n.n_void : strncmp(what, "inversions", 10) == 0 ? n.n_ground
         : at ? n.n_with : n.n_valid;
    return s;
}

/* ---- the row ----------------------------------------------------------------------------------- */

static const struct { const char *name; lw_status (*count)(job *j); } families[] = {
    { "simple-joint", simple_chains },   { "Baranov truss", simple_chains },      { "Assur group", assur_groups },
    { "contracted graph", structures },  { "multiple-joint", multiple_joints },
    { "lower+higher pairs", higher_pairs },
    { "R/P labelled", with_sliders },
};

lw_status lw_recount_row(lw_recount *r, const lw_published *row, double seconds, lw_recount_result *result)
{
    job j = { .r = r, .row = row, .limit = seconds, .n = NO_WAY };
    *result = (lw_recount_result){ .verdict = LW_NOT_COUNTED };
    for (size_t k = 0; k < sizeof families/sizeof *families; k++)
        if (strcmp(row->family, families[k].name) == 0) {
            j.n = TOO_LONG;
            lw_status s = seconds > 0 ? families[k].count(&j) : LW_OK;
            if (s == LW_E_MEMORY)
                return s;
            if (s != LW_OK)
                j.n = s == LW_STOPPED ? TOO_LONG : NO_WAY;
        }
    result->seconds = j.seconds;
    if (j.n == TOO_LONG)
        result->verdict = LW_TOO_LONG;
    if (j.n < 0)
        return LW_OK;
    result->counted = j.n;
    result->verdict = j.n == row->count ? LW_AGREES : row->refuted ? LW_ERRATUM : LW_DISAGREES;
    return LW_OK;
}

#include "optimise/topology/mechanism_set.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/growable_array.h"
#include "enumerate/higher.h"
#include "enumerate/mechanisms.h"

/* What becomes of one chain. */
typedef struct maker {
    const lw_mechanism_request  *w;
    const lw_numbered_chain *chain;
    int                      index;              /* of the chain in the stage's list               */
    lw_mechanism_stage       own;                /* families and numbers of this chain alone       */
    lw_mechanism_counts      counts;
    unsigned                 turned;             /* slots on the later link, bit i: the i-th       */
    int                      ratio;              /* set of the gears' ratios, from 1; 0: no gears  */
    bool                     met[64];            /* names of `only` that something bore            */
    lw_pair_outcome        best;               /* of the sets of tied inputs of one mechanism    */
    lw_plan                 *plan;
    lw_status                status;
} maker;

const char *lw_pair_outcome_text(lw_pair_outcome f)
{
    static const char *const text[LW_PAIR_OUTCOMES] = {
        "fitted", "tracer link joined to the ground", "moves as one with fewer links",
        "no input by which it can be worked out", "a gear pair without a link that carries it, or with several",
        "not asked for"
    };
    return text[f];
}

/* Is one of `keys` (separated by commas) the word or its beginning up to digits? */
static bool asked_for(maker *mk, const char *key)
{
    bool found = strcmp(mk->w->only, "all") == 0;
    int k = 0;
    for (const char *at = mk->w->only; *at; k++) {
        size_t n = strcspn(at, ",");
        bool whole = strncmp(key, at, n) == 0 && key[n] == 0;
        bool begins = strncmp(key, at, n) == 0 && at[n - 1] > '9' && key[n] <= '9';     /* "watt": both */
        if ((whole || begins) && k < 64)
            mk->met[k] = found = true;
        at += n + (at[n] == ',');
    }
    return found;
}

/* ---- one pair of ground and tracer link ----------------------------------------------------------------- */

static lw_status count_input(void *context, const lw_mechanism *m)
{
    (void)m;
    ((maker *)context)->own.tally.n_driven++;
    return LW_OK;
}

static lw_status add_family(maker *mk, const lw_packed_mechanism *f)
{
    lw_mechanism_stage *s = &mk->own;
    lw_packed_mechanism *more = lw_array_grow(s->family, s->n_family, &s->capacity, sizeof *more);
    if (!more)
        return LW_E_MEMORY;
    s->family = more;
    s->family[s->n_family++] = *f;
    s->tally.n_group += f->turn == LW_TURN_GROUPS;
    return LW_OK;
}

/* Links that a plan works out, dies in slots not counted. */
static int links_of(const lw_plan *plan, const lw_linkage *k)
{
    int n = 0;
    for (int i = 0; i < plan->n_link; i++)
        n += plan->link[i] < k->n_link;
    return n;
}

/* May these inputs drive it?  Then *f says by what it is worked out; *links that the point feels. */
static bool try_inputs(maker *mk, lw_packed_mechanism *f, int *links)
{
    lw_linkage k;
    if (lw_packed_mechanism_sketch(mk->chain, f, &mk->w->ratio, &k) != LW_OK
        || lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_GEARED }, mk->plan, NULL) != LW_OK)
        return false;
    f->turn = mk->plan->n_higher > 0 ? LW_TURN_GROUPS : LW_TURN_DYADS;
    *links = links_of(mk->plan, &k);
    return true;
}

static bool try_input(maker *mk, int joint, lw_packed_mechanism *f, int *links)
{
    f->n_input = 1;
    f->input[0] = (uint8_t)joint;
    return try_inputs(mk, f, links);
}

/* Of the joints that may drive the one that makes the plainest plan: pins at the ground first, slides there.  false:
 * there is none. */
static bool best_input(maker *mk, const lw_mechanism *m, lw_packed_mechanism *best, int *links)
{
    bool found = false;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < m->n_joint && !(found && best->turn == LW_TURN_DYADS); j++) {
            bool ground = m->link[j][0] == m->ground || m->link[j][1] == m->ground;
            lw_packed_mechanism f = *best;
            int felt;
            if (!ground || m->kind[j] != (pass ? 't' : 'r') || !try_input(mk, j, &f, &felt)
                || (found && f.turn >= best->turn))
                continue;
            found = true;
            *links = felt;
            *best = f;
        }
    return found;
}

/* By a pin or a slide: then its points draw circles or lines. */
static bool joined_to_ground(const lw_mechanism *m)
{
    int j = lw_mechanism_joint(m, m->ground, m->output);
    return j != LW_NONE && lw_kind_freedom(m->kind[j]) == 1;
}

/* All inputs at the ground that a prescribed timing may mean. */
static lw_status add_timed(void *context, const lw_mechanism *m)
{
    maker *mk = context;
    lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, mk->ratio);
    int links;
    if (m->kind[m->input[0]] != 'r' || !try_input(mk, m->input[0], &f, &links) || links < m->n_link)
        return LW_OK;
    return add_family(mk, &f);
}

/* By the plainest of its inputs; with a timing, all of them. */
static lw_status add_driven(maker *mk, const lw_mechanism *m, lw_pair_outcome *fate)
{
    lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, mk->ratio);
    int links = 0, before = mk->own.n_family;
    bool driven = best_input(mk, m, &f, &links), fewer = driven && links < m->n_link;
    *fate = !driven ? LW_PAIR_NO_PLAN : fewer ? LW_PAIR_SMALLER : LW_PAIR_FITTED;
    if (*fate != LW_PAIR_FITTED && !(fewer && mk->w->timed))
        return LW_OK;
    if (!mk->w->timed)
        return add_family(mk, &f);
    lw_status st = lw_inputs_each(m, 1, true, add_timed, mk);
    *fate = mk->own.n_family > before ? LW_PAIR_FITTED : LW_PAIR_SMALLER;
    return st;
}

/* ---- tied inputs ---------------------------------------------------------------------------------------- */

/* The set of m with input `first` in front, the others tied by the digits of `code`. */
static void tie_inputs(const maker *mk, const lw_mechanism *m, int first, int code, lw_packed_mechanism *f)
{
    f->n_input = (uint8_t)m->n_input;
    f->input[0] = m->input[first];
    for (int i = 1; i < m->n_input && i < LW_PACKED_INPUT_MAX; i++) {
        f->input[i] = m->input[i <= first ? i - 1 : i];
        f->tie[i] = (uint8_t)(code % mk->w->ratio.tie.n);
        code /= mk->w->ratio.tie.n;
    }
}

/* Is this, seen from another input or through a symmetry, one of those before? */
static bool tied_before(const maker *mk, const lw_packed_mechanism *f, lw_graph *form, int *n)
{
    lw_linkage k;
    if (lw_packed_mechanism_sketch(mk->chain, f, &mk->w->ratio, &k) != LW_OK || !lw_linkage_canonical_form(&k, &form[*n]))
        return false;
    for (int i = 0; i < *n; i++)
        if (memcmp(&form[i], &form[*n], sizeof *form) == 0)
            return true;
    ++*n;
    return false;
}

static lw_status add_tied(maker *mk, const lw_packed_mechanism *f, lw_pair_outcome *fate)
{
    lw_packed_mechanism now = *f;
    int links;
    if (!try_inputs(mk, &now, &links))
        return LW_OK;
    lw_pair_outcome what = links < mk->chain->m.n_link ? LW_PAIR_SMALLER : LW_PAIR_FITTED;
    if (*fate != LW_PAIR_FITTED)
        *fate = what;
    return what == LW_PAIR_FITTED ? add_family(mk, &now) : LW_OK;
}

/* Inputs at the ground, all of them pins: each in front, the others tied by every ratio.  Which is in front matters
 * with a timing only. */
static lw_status add_ties(void *context, const lw_mechanism *m)
{
    maker *mk = context;
    lw_pair_outcome fate = LW_PAIR_NO_PLAN;
    lw_status st = LW_OK;
    int codes = 1, n = 0;
    bool pins = true;
    for (int i = 0; i < m->n_input; i++) {
        codes *= i > 0 ? mk->w->ratio.tie.n : 1;
        pins = pins && m->kind[m->input[i]] == 'r';
    }
    lw_graph *form = malloc(sizeof *form*(size_t)(m->n_input*codes + 1));
    if (!form)
        return LW_E_MEMORY;
    for (int first = 0; first < m->n_input && pins; first++) {
        n = mk->w->timed ? 0 : n;
        for (int code = 0; code < codes && st == LW_OK; code++) {
            lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, mk->ratio);
            tie_inputs(mk, m, first, code, &f);
            if (!tied_before(mk, &f, form, &n))
                st = add_tied(mk, &f, &fate);
        }
    }
    free(form);
    mk->own.tally.n_set++;
    mk->own.tally.n_set_out += fate != LW_PAIR_FITTED;
    if (mk->best == LW_PAIR_NO_PLAN || fate == LW_PAIR_FITTED)
        mk->best = fate;
    return st;
}

static lw_status add_pair(maker *mk, const lw_mechanism *m, lw_pair_outcome *fate)
{
    *fate = LW_PAIR_CIRCLE;
    if (joined_to_ground(m) && mk->w->task != LW_TASK_FUNCTION)
        return LW_OK;
    if (mk->w->dof == 1)
        return add_driven(mk, m, fate);
    mk->best = LW_PAIR_NO_PLAN;
    lw_status st = lw_inputs_each(m, mk->w->dof, true, add_ties, mk);
    *fate = mk->best;
    return st;
}

/* ---- variants ------------------------------------------------------------------------------------------- */

/* Is this set of ratios, through a symmetry, one of those before? */
static bool same_ratios(maker *mk, const lw_mechanism *m, lw_graph *form, int *n)
{
    lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, mk->ratio);
    return tied_before(mk, &f, form, n);
}

/* A mechanism with gears, with each set of ratios: what becomes of it with the one with which it does best. */
static lw_status add_geared(maker *mk, const lw_mechanism *m, lw_pair_outcome *fate)
{
    lw_linkage k;
    lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, 0);
    lw_status st = lw_packed_mechanism_sketch(mk->chain, &f, &mk->w->ratio, &k);
    int sets = st == LW_OK ? lw_gear_sets(&k, &mk->w->ratio.gear) : 0, n = 0;
    lw_graph *form = malloc(sizeof *form*(size_t)(sets + 1));
    *fate = sets > 0 ? LW_PAIR_NO_PLAN : LW_PAIR_NO_CARRIER;
    for (mk->ratio = 1; form && st == LW_OK && mk->ratio <= sets; mk->ratio++) {
        lw_pair_outcome now;
        if (same_ratios(mk, m, form, &n))
            continue;
        st = add_pair(mk, m, &now);
        if (*fate != LW_PAIR_FITTED && now != LW_PAIR_NO_PLAN)
            *fate = now;
    }
    free(form);
    mk->ratio = 0;
    return form ? st : LW_E_MEMORY;
}

static lw_status visit_variant(maker *mk, const lw_mechanism *m)
{
    lw_pair_outcome fate = LW_PAIR_NOT_REQUESTED;
    const lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, 0);
    lw_status st = LW_OK;
    char key[64];
    lw_packed_mechanism_key(mk->chain, &f, key, sizeof key);
    if (asked_for(mk, key))
        st = memchr(m->kind, 'g', (size_t)m->n_joint) ? add_geared(mk, m, &fate) : add_pair(mk, m, &fate);
    mk->own.tally.n_pair++;
    mk->own.tally.outcome[fate]++;
    return st;
}

/* Is this choice of slots, up to symmetry, one of those before? */
static bool seen(maker *mk, const lw_mechanism *m, lw_graph *form, int n)
{
    lw_linkage k;
    lw_packed_mechanism f = lw_packed_mechanism_of(m, mk->index, mk->turned, 0);
    if (lw_packed_mechanism_sketch(mk->chain, &f, &mk->w->ratio, &k) != LW_OK || !lw_linkage_canonical_form(&k, &form[n]))
        return false;
    for (int i = 0; i < n; i++)
        if (memcmp(&form[i], &form[n], sizeof *form) == 0)
            return true;
    return false;
}

/* Each pin in a slot both ways: the slot on the one link, the pin on the other.  Its inputs are the same. */
static lw_status visit_pair(void *context, const lw_mechanism *m)
{
    maker *mk = context;
    int slots = 0, n = 0;
    long before = mk->own.tally.n_driven;
    if (mk->w->interrupt && *mk->w->interrupt)
        return LW_STOPPED;
    lw_status st = lw_inputs_each(m, mk->w->dof, false, count_input, mk);
    for (int j = 0; j < m->n_joint; j++)
        slots += m->kind[j] == 'p';
    lw_graph *form = malloc(sizeof *form << slots);
    if (!form)
        return LW_E_MEMORY;
    for (mk->turned = 0; st == LW_OK && mk->turned < 1u << slots; mk->turned++)
        if (slots == 0 || !seen(mk, m, form, n)) {
            n++;
            st = visit_variant(mk, m);
        }
    mk->own.tally.n_driven = before + n*(mk->own.tally.n_driven - before);
    free(form);
    mk->turned = 0;
    return st;
}

/* ---- as families, and the other way ------------------------------------------------------------------------ */

static void stage_free(lw_mechanism_stage *s)
{
    free(s->family);
    free(s->list);
}

static lw_status make_family(const void *of, int i, lw_family_made *made)
{
    const lw_mechanism_stage *s = of;
    const lw_packed_mechanism *f = &s->family[i];
    const lw_numbered_chain *c = &s->list[f->chain];
    lw_packed_mechanism_name(c, f, &s->all->ratio, s->all->timed, made->name, sizeof made->name);
    made->family = (lw_family){ .name = made->name, .linkage = &made->linkage, .links = s->links };
    lw_status st = lw_packed_mechanism_sketch(c, f, &s->all->ratio, &made->linkage);
    snprintf(made->linkage.name, sizeof made->linkage.name, "%.*s", (int)sizeof made->linkage.name - 1, made->name);
    return st;
}

static lw_turn turn_of(const void *of, int i)
{
    return ((const lw_mechanism_stage *)of)->family[i].turn;
}

lw_families lw_mechanism_stage_families(const lw_mechanism_stage *s)
{
    return (lw_families){ s->n_family, make_family, turn_of, s };
}

lw_families lw_mechanism_stage_pins(const lw_mechanism_stage *s)
{
    return (lw_families){ s->n_pins, make_family, turn_of, s };
}

static lw_status make_slide(const void *of, int i, lw_family_made *made)
{
    return make_family(of, ((const lw_mechanism_stage *)of)->n_pins + i, made);
}

static lw_turn turn_of_slide(const void *of, int i)
{
    return turn_of(of, ((const lw_mechanism_stage *)of)->n_pins + i);
}

lw_families lw_mechanism_stage_others(const lw_mechanism_stage *s)
{
    return (lw_families){ s->n_family - s->n_pins, make_slide, turn_of_slide, s };
}

/* How many joints of each kind, and what is joined to ground and tracer link: alike where mechanisms are. */
static unsigned outline_of_joint(char kind, int a, int b, int ground, int tracer)
{
    int place = 2*(a == ground || b == ground) + (a == tracer || b == tracer);
    return (unsigned)kind*(unsigned)kind*(1 + 4096*(unsigned)place);
}

static unsigned outline_of_linkage(const lw_linkage *k)
{
    unsigned sum = 0;
    for (int j = 0; j < k->n_joint; j++)
        sum += outline_of_joint((char)k->joint[j].kind, k->joint[j].link[0], k->joint[j].link[1], k->ground,
                                k->tracer[0].link);
    return sum;
}

static unsigned outline_of(const lw_numbered_chain *c, const lw_packed_mechanism *f)
{
    lw_mechanism m = lw_packed_mechanism_unpack(c, f);
    unsigned sum = 0;
    for (int j = 0; j < m.n_joint; j++)
        sum += outline_of_joint(m.kind[j], m.link[j][0], m.link[j][1], m.ground, m.output);
    return sum;
}

bool lw_mechanism_set_name(void *context, const lw_linkage *k, char *name, size_t size)
{
    const lw_mechanism_set *set = context;
    unsigned outline = outline_of_linkage(k);
    lw_graph want, have;
    lw_linkage l;
    if (!lw_linkage_canonical_form(k, &want))
        return true;
    for (int i = 0; i < set->n; i++)
        for (int n = 0; set->stage[i].links == k->n_link && n < set->stage[i].n_family; n++) {
            const lw_packed_mechanism *f = &set->stage[i].family[n];
            const lw_numbered_chain *c = &set->stage[i].list[f->chain];
            if (outline_of(c, f) == outline && lw_packed_mechanism_sketch(c, f, &set->ratio, &l) == LW_OK
                && lw_linkage_canonical_form(&l, &have) && memcmp(&want, &have, sizeof want) == 0) {
                lw_packed_mechanism_name(c, f, &set->ratio, false, name, size);
                return true;
            }
        }
    return set->every;
}

/* ---- a number of links ------------------------------------------------------------------------------------ */

/* Every mechanism of one chain. */
static void make_chain(void *context, size_t job, int thread)
{
    maker *mk = (maker *)context + job;
    lw_mechanism_steps steps = { .ground = true, .kinds = mk->w->kinds, .output = true };
    (void)thread;
    mk->plan = malloc(sizeof *mk->plan);
    mk->status = mk->plan ? lw_mechanisms_each(&mk->chain->m, &steps, &mk->counts, visit_pair, NULL, mk) : LW_E_MEMORY;
    free(mk->plan);
}

static lw_status list_chain(lw_mechanism_stage *s, const lw_chain *c, int number, int n2)
{
    lw_numbered_chain *more = lw_array_grow(s->list, s->n_list, &s->list_capacity, sizeof *more);
    if (!more)
        return LW_E_MEMORY;
    s->list = more;
    s->list[s->n_list] = (lw_numbered_chain){ .number = number, .n2 = n2 };
    lw_status st = lw_mechanism_from_chain(c, &s->list[s->n_list].m);
    if (s->list[s->n_list++].m.n_joint > LW_PACKED_JOINT_MAX)
        return LW_E_ARG;
    return st;
}

typedef struct listing { lw_mechanism_stage *to; int number, n2; } listing;

static lw_status visit_chain(void *context, const lw_chain *c)
{
    listing *l = context;
    return list_chain(l->to, c, ++l->number, l->n2);
}

/* Chains with so many links of which n2 joints have two freedoms (Makkonen 1999, eq. 2). */
static lw_status list_chains(lw_mechanism_stage *to, int n2, lw_error *e)
{
    int links = to->links, dof = to->all->dof, twice = 3*(links - 1) - dof - n2;
    listing l = { to, 0, n2 };
    if (twice < 2 || twice % 2 || twice/2 + n2 > links*(links - 1)/2)
        return LW_OK;
    return lw_higher_each(links, dof, n2, 1, visit_chain, &l, e);
}

/* What a chain adds to the numbers of its stage, and to the names met. */
static lw_status join(const maker *part, lw_mechanism_stage *to, bool met[64])
{
    const lw_mechanism_tally *own = &part->own.tally;
    lw_mechanism_tally *sum = &to->tally;
    sum->n_chain += (long)part->counts.n_chain;
    sum->n_ground += (long)part->counts.n_ground;
    sum->n_pair += own->n_pair;
    sum->n_driven += own->n_driven;
    sum->n_set += own->n_set;
    sum->n_set_out += own->n_set_out;
    sum->n_group += own->n_group;
    for (int i = 0; i < LW_PAIR_OUTCOMES; i++)
        sum->outcome[i] += own->outcome[i];
    for (int i = 0; i < 64; i++)
        met[i] |= part->met[i];
    return part->status;
}

/* The families of all chains, those of pins alone first. */
static lw_status join_families(const maker *part, lw_mechanism_stage *to)
{
    for (int i = 0; i < to->n_list; i++)
        to->n_family += part[i].own.n_family;
    to->family = malloc(sizeof *to->family*((size_t)to->n_family + 1));
    to->n_family = 0;
    for (int slides = 0; to->family && slides < 2; slides++) {
        for (int i = 0; i < to->n_list; i++)
            for (int f = 0; f < part[i].own.n_family; f++)
                if ((part[i].own.family[f].kinds != 0) == slides)
                    to->family[to->n_family++] = part[i].own.family[f];
        to->n_pins = slides ? to->n_pins : to->n_family;
    }
    return to->family ? LW_OK : LW_E_MEMORY;
}

/* Those of pins and sliders alone (higher false), or those with slots and gears. */
static lw_status make_stage(const lw_mechanism_request *w, lw_mechanism_stage *to, bool met[64], lw_error *e)
{
    lw_status st = LW_OK;
    for (int n2 = to->two_freedoms; st == LW_OK && (n2 == 0 || (to->two_freedoms && to->links + n2 <= LW_EXPANDED_LINK_MAX)); n2++)
        st = list_chains(to, n2, e);
    maker *part = st == LW_OK ? calloc((size_t)to->n_list + 1, sizeof *part) : NULL;
    if (!part)
        return st == LW_OK ? LW_E_MEMORY : st;
    for (int i = 0; i < to->n_list; i++)
        part[i] = (maker){ .w = w, .chain = &to->list[i], .index = i };
    st = lw_parallel(w->jobs, (size_t)to->n_list, make_chain, part);
    for (int i = 0; i < to->n_list; i++)
        st = st == LW_OK ? join(&part[i], to, met) : st;
    st = st == LW_OK ? join_families(part, to) : st;
    for (int i = 0; i < to->n_list; i++)
        free(part[i].own.family);
    free(part);
    return st;
}

static lw_status check_names(const lw_mechanism_request *w, const bool met[64], lw_error *e)
{
    int k = 0;
    for (const char *at = w->only; strcmp(w->only, "all") != 0 && *at; k++) {
        size_t n = strcspn(at, ",");
        if (k < 64 && !met[k])
            return lw_error_set(e, LW_E_ARG, "topology: nothing up to %d links is called '%.*s'; there are watt1, "
                                "watt2, stephenson1, stephenson2, stephenson3, chains by links and number as 8.5, and by links, "
                                "number of slots and gears, and number as 5.1.2", w->links, (int)n, at);
        at += n + (at[n] == ',');
    }
    return LW_OK;
}

bool lw_kinds_have_two_freedoms(const char *kinds)
{
    return strpbrk(kinds, "pg") != NULL;
}

/* With F inputs at the ground that link has F joints, and each loop adds two links or more (Makkonen 1999, eq. 2):
 * P = F + 1 + 2 L with L = F - 1. */
int lw_mechanism_least_links(int dof)
{
    return dof > 1 ? 3*dof - 1 : 4;
}

/* A stage that holds nothing to count is none. */
static lw_status add_stage(const lw_mechanism_request *w, lw_mechanism_set *t, int links, bool two_freedoms, bool met[64], lw_error *e)
{
    if (t->n == LW_STAGE_MAX)
        return LW_OK;
    lw_mechanism_stage *to = &t->stage[t->n++];
    *to = (lw_mechanism_stage){ .links = links, .two_freedoms = two_freedoms, .all = t };
    lw_status st = make_stage(w, to, met, e);
    if (to->tally.n_chain == 0) {
        stage_free(to);
        t->n--;
    }
    return st;
}

lw_status lw_mechanism_set_make(const lw_mechanism_request *w, lw_mechanism_set *set, lw_error *e)
{
    lw_status st = LW_OK;
    bool met[64] = { false };
    lw_error why = { .text = "" };
    memset(set, 0, sizeof *set);
    set->every = strcmp(w->only, "all") == 0;
    set->timed = w->timed;
    set->ratio = w->ratio;
    set->dof = w->dof;
    for (int links = w->dof == 1 ? 6 : w->dof + 3; links <= w->links; links += 2)
        st = st == LW_OK ? add_stage(w, set, links, false, met, &why) : st;
    int most = w->links < LW_EXPANDED_LINK_MAX ? w->links : LW_EXPANDED_LINK_MAX - 1;
    if (!lw_kinds_have_two_freedoms(w->kinds))
        most = 0;
    for (int links = 3; links <= most; links++)
        st = st == LW_OK ? add_stage(w, set, links, true, met, &why) : st;
    if (st == LW_OK)
        st = check_names(w, met, e);
    else if (st == LW_STOPPED)
        st = lw_error_set(e, LW_NOTHING, "stopped while mechanisms were still counted: none was searched");
    else if (why.text[0] && e)
        *e = why;
    else
        lw_error_set(e, st, "out of memory");
    if (st != LW_OK)
        lw_mechanism_set_free(set);
    return st;
}

void lw_mechanism_set_free(lw_mechanism_set *set)
{
    for (int i = 0; i < set->n; i++)
        stage_free(&set->stage[i]);
    memset(set, 0, sizeof *set);
}

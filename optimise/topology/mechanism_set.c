#include "optimise/topology/mechanism_set.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "base/growable_array.h"
#include "enumerate/canon.h"
#include "enumerate/higher.h"
#include "enumerate/mechanisms.h"

enum {
    NAMES_MAX = 64,              /* of lw_mechanism_request.only that are checked                       */
    CLOCK_PAIRS = 64             /* pairs of a chain between two looks at the clock                     */
};

/* Make all mechanisms of one chain. */
typedef struct chain_job {
    const lw_mechanism_request *request;
    const lw_numbered_chain    *chain;
    int                  index;              /* of the chain in the stage's list                       */
    lw_mechanism_stage   own;                /* families and tally of this chain alone                 */
    lw_mechanism_counts  counts;
    unsigned             turned;             /* bit i: slot i is on the second link of its joint       */
    int                  ratio;              /* set of the gears' ratios, from 1; 0: no gears          */
    bool                 met[NAMES_MAX];     /* names of `only` that a mechanism bears                 */
    lw_pair_outcome      best;               /* of the sets of tied inputs of one mechanism            */
    lw_plan             *plan;
    lw_status            status;
} chain_job;

const char *lw_pair_outcome_text(lw_pair_outcome f)
{
    static const char *const text[LW_PAIR_OUTCOMES] = {
        "fitted", "tracer link joined to the ground", "moves as one with fewer links",
        "no input by which it can be worked out", "a gear pair without a link that carries it, or with several",
        "not asked for"
    };
    return text[f];
}

/* Does request->only name this key, or its beginning before the digits? */
static bool is_requested(chain_job *job, const char *key)
{
    bool found = strcmp(job->request->only, "all") == 0;
    int k = 0;
    for (const char *at = job->request->only; *at; k++) {
        size_t n = strcspn(at, ",");
        bool whole = strncmp(key, at, n) == 0 && key[n] == 0;
        bool begins = strncmp(key, at, n) == 0 && at[n - 1] > '9' && key[n] <= '9';     /* "watt": watt1 and watt2 */
        if ((whole || begins) && k < NAMES_MAX)
            job->met[k] = found = true;
        at += n + (at[n] == ',');
    }
    return found;
}

/* ---- one pair of ground and tracer link ----------------------------------------------------------------- */

static lw_status count_input(void *context, const lw_mechanism *m)
{
    (void)m;
    ((chain_job *)context)->own.tally.n_driven++;
    return LW_OK;
}

static lw_status add_family(chain_job *job, const lw_packed_mechanism *f)
{
    lw_mechanism_stage *s = &job->own;
    lw_packed_mechanism *more = lw_array_grow(s->family, s->n_family, &s->capacity, sizeof *more);
    if (!more)
        return LW_E_MEMORY;
    s->family = more;
    s->family[s->n_family++] = *f;
    s->tally.n_group += f->turn == LW_TURN_GROUPS;
    return LW_OK;
}

/* Links of a plan without the blocks in slots. */
static int links_of(const lw_plan *plan, const lw_linkage *linkage)
{
    int n = 0;
    for (int i = 0; i < plan->n_link; i++)
        n += plan->link[i] < linkage->n_link;
    return n;
}

/* May these inputs drive the mechanism?  Set f->turn, and *links to the number of links that the tracer depends on. */
static bool try_inputs(chain_job *job, lw_packed_mechanism *f, int *links)
{
    lw_linkage k;
    if (lw_packed_mechanism_sketch(job->chain, f, &job->request->ratio, &k) != LW_OK
        || lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .kind = LW_PLAN_GEARED }, job->plan, NULL) != LW_OK)
        return false;
    f->turn = job->plan->n_higher > 0 ? LW_TURN_GROUPS : LW_TURN_DYADS;
    *links = links_of(job->plan, &k);
    return true;
}

static bool try_input(chain_job *job, int joint, lw_packed_mechanism *f, int *links)
{
    f->n_input = 1;
    f->input[0] = (uint8_t)joint;
    return try_inputs(job, f, links);
}

/* Choose the joint at the ground that makes the plainest plan as the input: one with which the tracer depends on all
 * links before one with which it depends on fewer, pins before slides.  false: there is none. */
static bool best_input(chain_job *job, const lw_mechanism *m, lw_packed_mechanism *best, int *links)
{
    bool found = false;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < m->n_joint; j++) {
            bool ground = m->link[j][0] == m->ground || m->link[j][1] == m->ground;
            lw_packed_mechanism f = *best;
            int n;
            if (!ground || !lw_joint_can_drive(m->kind[j]) || lw_joint_turns(m->kind[j]) != !pass
                || !try_input(job, j, &f, &n) || (found && (n < *links || (n == *links && f.turn >= best->turn))))
                continue;
            found = true;
            *links = n;
            *best = f;
        }
    return found;
}

/* Is the tracer link joined to the ground by a pin or a slide?  Its points draw circles or lines then. */
static bool joined_to_ground(const lw_mechanism *m)
{
    int j = lw_mechanism_joint(m, m->ground, m->output);
    return j != LW_NONE && lw_joint_freedoms(m->kind[j]) == 1;
}

/* Add a family for an input at the ground that a prescribed timing may mean. */
static lw_status add_timed(void *context, const lw_mechanism *m)
{
    chain_job *job = context;
    lw_packed_mechanism f = lw_packed_mechanism_of(m, job->index, job->turned, job->ratio);
    int links;
    if (!lw_joint_turns(m->kind[m->input[0]]) || !try_input(job, m->input[0], &f, &links) || links < m->n_link)
        return LW_OK;
    return add_family(job, &f);
}

/* Add the family driven by the plainest input; with a timing, one family for each input. */
static lw_status add_driven(chain_job *job, const lw_mechanism *m, lw_pair_outcome *outcome)
{
    lw_packed_mechanism f = lw_packed_mechanism_of(m, job->index, job->turned, job->ratio);
    int links = 0, before = job->own.n_family;
    bool driven = best_input(job, m, &f, &links), fewer = driven && links < m->n_link;
    *outcome = !driven ? LW_PAIR_NO_PLAN : fewer ? LW_PAIR_SMALLER : LW_PAIR_FITTED;
    if (*outcome != LW_PAIR_FITTED && !(fewer && job->request->timed))
        return LW_OK;
    if (!job->request->timed)
        return add_family(job, &f);
    lw_status st = lw_inputs_each(m, 1, true, add_timed, job);
    *outcome = job->own.n_family > before ? LW_PAIR_FITTED : LW_PAIR_SMALLER;
    return st;
}

/* ---- tied inputs ---------------------------------------------------------------------------------------- */

/* Make input `first` of m the free one and tie the others to it; the digits of `code` are the numbers of their
 * ratios. */
static void tie_inputs(const chain_job *job, const lw_mechanism *m, int first, int code, lw_packed_mechanism *f)
{
    f->n_input = (uint8_t)m->n_input;
    f->input[0] = m->input[first];
    for (int i = 1; i < m->n_input && i < LW_PACKED_INPUT_MAX; i++) {
        f->input[i] = m->input[i <= first ? i - 1 : i];
        f->tie[i] = (uint8_t)(code % job->request->ratio.tie.n);
        code /= job->request->ratio.tie.n;
    }
}

/* Sketch the mechanism and find the form of the linkage.  LW_NOTHING: there is none.  LW_E_MEMORY, LW_E_IO. */
static lw_status form_of(const lw_numbered_chain *c, const lw_packed_mechanism *f, const lw_ratio_choices *r, lw_graph *form)
{
    lw_linkage k;
    lw_status st = lw_packed_mechanism_sketch(c, f, r, &k);
    if (st == LW_OK)
        return lw_linkage_canonical_form(&k, form);
    return st == LW_E_MEMORY ? st : LW_NOTHING;
}

/* *listed: is it the same as a mechanism listed before, by a symmetry, or seen from another input?  If not, add its form to
 * the n forms. */
static lw_status look_up(const chain_job *job, const lw_packed_mechanism *f, lw_graph *form, int *n, bool *listed)
{
    lw_status st = form_of(job->chain, f, &job->request->ratio, &form[*n]);
    *listed = false;
    if (st != LW_OK)
        return st == LW_NOTHING ? LW_OK : st;
    for (int i = 0; i < *n && !*listed; i++)
        *listed = memcmp(&form[i], &form[*n], sizeof *form) == 0;
    *n += !*listed;
    return LW_OK;
}

static lw_status add_tied(chain_job *job, const lw_packed_mechanism *f, lw_pair_outcome *outcome)
{
    lw_packed_mechanism now = *f;
    int links;
    if (!try_inputs(job, &now, &links))
        return LW_OK;
    lw_pair_outcome now_is = links < job->chain->m.n_link ? LW_PAIR_SMALLER : LW_PAIR_FITTED;
    if (*outcome != LW_PAIR_FITTED)
        *outcome = now_is;
    return now_is == LW_PAIR_FITTED ? add_family(job, &now) : LW_OK;
}

/* Add the families of a set of inputs, all pins at the ground: each input as the free one, the others tied to it by
 * every ratio.  Which input is free matters with a timing only. */
static lw_status add_ties(void *context, const lw_mechanism *m)
{
    chain_job *job = context;
    lw_pair_outcome outcome = LW_PAIR_NO_PLAN;
    lw_status st = LW_OK;
    int codes = 1, n = 0;
    bool pins = true, listed;
    for (int i = 0; i < m->n_input; i++) {
        codes *= i > 0 ? job->request->ratio.tie.n : 1;
        pins = pins && lw_joint_turns(m->kind[m->input[i]]);
    }
    lw_graph *form = malloc(sizeof *form*(size_t)(m->n_input*codes + 1));
    if (!form)
        return LW_E_MEMORY;
    for (int first = 0; first < m->n_input && pins; first++) {
        n = job->request->timed ? 0 : n;
        for (int code = 0; code < codes && st == LW_OK; code++) {
            lw_packed_mechanism f = lw_packed_mechanism_of(m, job->index, job->turned, job->ratio);
            tie_inputs(job, m, first, code, &f);
            st = look_up(job, &f, form, &n, &listed);
            if (st == LW_OK && !listed)
                st = add_tied(job, &f, &outcome);
        }
    }
    free(form);
    job->own.tally.n_set++;
    job->own.tally.n_set_out += outcome != LW_PAIR_FITTED;
    if (job->best == LW_PAIR_NO_PLAN || outcome == LW_PAIR_FITTED)
        job->best = outcome;
    return st;
}

static lw_status add_pair(chain_job *job, const lw_mechanism *m, lw_pair_outcome *outcome)
{
    *outcome = LW_PAIR_CIRCLE;
    if (joined_to_ground(m) && lw_task_has_place(job->request->task))
        return LW_OK;
    if (job->request->dof == 1)
        return add_driven(job, m, outcome);
    job->best = LW_PAIR_NO_PLAN;
    lw_status st = lw_inputs_each(m, job->request->dof, true, add_ties, job);
    *outcome = job->best;
    return st;
}

/* ---- variants ------------------------------------------------------------------------------------------- */

/* Add the families of a mechanism with gears with each set of ratios; *outcome is the best of the sets. */
static lw_status add_geared(chain_job *job, const lw_mechanism *m, lw_pair_outcome *outcome)
{
    lw_linkage k;
    lw_packed_mechanism f = lw_packed_mechanism_of(m, job->index, job->turned, 0);
    lw_status st = lw_packed_mechanism_sketch(job->chain, &f, &job->request->ratio, &k);
    int sets = st == LW_OK ? lw_gear_sets(&k, &job->request->ratio.gear) : 0, n = 0;
    lw_graph *form = malloc(sizeof *form*(size_t)(sets + 1));
    *outcome = sets > 0 ? LW_PAIR_NO_PLAN : LW_PAIR_NO_CARRIER;
    for (job->ratio = 1; form && st == LW_OK && job->ratio <= sets; job->ratio++) {
        lw_pair_outcome now = LW_PAIR_NO_PLAN;
        bool listed;
        f = lw_packed_mechanism_of(m, job->index, job->turned, job->ratio);
        st = look_up(job, &f, form, &n, &listed);
        if (st == LW_OK && !listed)
            st = add_pair(job, m, &now);
        if (*outcome != LW_PAIR_FITTED && now != LW_PAIR_NO_PLAN)
            *outcome = now;
    }
    free(form);
    job->ratio = 0;
    return form ? st : LW_E_MEMORY;
}

static lw_status visit_variant(chain_job *job, const lw_mechanism *m)
{
    lw_pair_outcome outcome = LW_PAIR_NOT_REQUESTED;
    const lw_packed_mechanism f = lw_packed_mechanism_of(m, job->index, job->turned, 0);
    lw_status st = LW_OK;
    char key[64];
    lw_packed_mechanism_key(job->chain, &f, key, sizeof key);
    if (is_requested(job, key))
        st = memchr(m->kind, 'g', (size_t)m->n_joint) ? add_geared(job, m, &outcome) : add_pair(job, m, &outcome);
    job->own.tally.n_pair++;
    job->own.tally.outcome[outcome]++;
    return st;
}

static bool is_stopped(const lw_mechanism_request *r) { return r->interrupt && *r->interrupt; }

static bool is_late(const lw_mechanism_request *r) { return r->until > 0 && lw_clock_wall() >= r->until; }

/* Visit a pair of ground and tracer link with each slot on the one or on the other link of its joint.  The inputs are
 * the same. */
static lw_status visit_pair(void *context, const lw_mechanism *m)
{
    chain_job *job = context;
    int slots = 0, n = 0, variants = 0;
    long before = job->own.tally.n_driven;
    if (is_stopped(job->request) || (job->own.tally.n_pair % CLOCK_PAIRS == 0 && is_late(job->request)))
        return LW_STOPPED;
    lw_status st = lw_inputs_each(m, job->request->dof, false, count_input, job);
    for (int j = 0; j < m->n_joint; j++)
        slots += lw_joint_has_slot(m->kind[j]);
    lw_graph *form = malloc(sizeof *form << slots);
    if (!form)
        return LW_E_MEMORY;
    for (job->turned = 0; st == LW_OK && job->turned < 1u << slots; job->turned++) {
        lw_packed_mechanism f = lw_packed_mechanism_of(m, job->index, job->turned, 0);
        bool listed = false;
        if (slots > 0)
            st = look_up(job, &f, form, &n, &listed);
        if (st == LW_OK && !listed) {
            variants++;
            st = visit_variant(job, m);
        }
    }
    job->own.tally.n_driven = before + variants*(job->own.tally.n_driven - before);
    free(form);
    job->turned = 0;
    return st;
}

/* ---- as families, and by name ------------------------------------------------------------------------ */

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

/* A sum over joints, by kind and by whether they join the ground or the tracer link; equal for equal mechanisms. */
static unsigned outline_of_joint(char kind, int a, int b, int ground, int tracer)
{
    int place = 2*(a == ground || b == ground) + (a == tracer || b == tracer);
    return (unsigned)kind*(unsigned)kind*(1 + 4096*(unsigned)place);
}

static unsigned outline_of_linkage(const lw_linkage *linkage)
{
    unsigned sum = 0;
    for (int j = 0; j < linkage->n_joint; j++)
        sum += outline_of_joint((char)linkage->joint[j].kind, linkage->joint[j].link[0], linkage->joint[j].link[1],
                                linkage->ground, linkage->tracer[0].link);
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

lw_status lw_mechanism_set_name(void *context, const lw_linkage *linkage, char *name, size_t size)
{
    const lw_mechanism_set *set = context;
    unsigned outline = outline_of_linkage(linkage);
    lw_graph form, other_form;
    lw_status st = lw_linkage_canonical_form(linkage, &form);
    if (st != LW_OK)
        return st == LW_NOTHING ? LW_OK : st;
    for (int i = 0; i < set->n; i++)
        for (int n = 0; set->stage[i].links == linkage->n_link && n < set->stage[i].n_family; n++) {
            const lw_packed_mechanism *f = &set->stage[i].family[n];
            const lw_numbered_chain *c = &set->stage[i].list[f->chain];
            if (outline_of(c, f) != outline)
                continue;
            st = form_of(c, f, &set->ratio, &other_form);
            if (st != LW_OK && st != LW_NOTHING)
                return st;
            if (st == LW_OK && memcmp(&form, &other_form, sizeof form) == 0) {
                lw_packed_mechanism_name(c, f, &set->ratio, false, name, size);
                return LW_OK;
            }
        }
    return set->every ? LW_OK : LW_NOTHING;
}

/* ---- a number of links ------------------------------------------------------------------------------------ */


static void make_chain(void *context, size_t i, int thread)
{
    chain_job *job = (chain_job *)context + i;
    lw_mechanism_steps steps = { .ground = true, .kinds = job->request->kinds, .output = true };
    (void)thread;
    job->plan = malloc(sizeof *job->plan);
    job->status = LW_E_MEMORY;
    if (job->plan)
        job->status = lw_mechanisms_each(&job->chain->m, &steps, &job->counts, visit_pair, NULL, job);
    free(job->plan);
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

/* List the chains with to->links links, of which n2 joints have two freedoms (Makkonen 1999, eq. 2). */
static lw_status list_chains(lw_mechanism_stage *to, int n2, lw_error *e)
{
    int links = to->links, dof = to->all->dof, twice = 3*(links - 1) - dof - n2;
    listing l = { to, 0, n2 };
    if (twice < 2 || twice % 2 || twice/2 + n2 > links*(links - 1)/2)
        return LW_OK;
    return lw_higher_each(links, dof, n2, 1, visit_chain, &l, e);
}

/* Add the tally of a chain to its stage's, and the names it bears. */
static lw_status join(const chain_job *part, lw_mechanism_stage *to, bool met[NAMES_MAX])
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
    for (int i = 0; i < NAMES_MAX; i++)
        met[i] |= part->met[i];
    return part->status;
}

/* Join the families of all chains, those of pins alone first. */
static lw_status join_families(const chain_job *part, lw_mechanism_stage *to)
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

/* Make the mechanisms of a stage: of pins and sliders alone, or with slots and gears (two_freedoms). */
static lw_status make_stage(const lw_mechanism_request *request, lw_mechanism_stage *to, bool met[NAMES_MAX], lw_error *e)
{
    lw_status st = LW_OK;
    int last = to->two_freedoms ? LW_EXPANDED_LINK_MAX - to->links : 0;
    for (int n2 = to->two_freedoms; st == LW_OK && n2 <= last; n2++)
        st = list_chains(to, n2, e);
    chain_job *part = st == LW_OK ? calloc((size_t)to->n_list + 1, sizeof *part) : NULL;
    if (!part)
        return st == LW_OK ? LW_E_MEMORY : st;
    for (int i = 0; i < to->n_list; i++)
        part[i] = (chain_job){ .request = request, .chain = &to->list[i], .index = i };
    st = lw_parallel(request->jobs, (size_t)to->n_list, make_chain, part);
    for (int i = 0; i < to->n_list; i++)
        st = st == LW_OK ? join(&part[i], to, met) : st;
    st = st == LW_OK ? join_families(part, to) : st;
    for (int i = 0; i < to->n_list; i++)
        free(part[i].own.family);
    free(part);
    return st;
}

static lw_status check_names(const lw_mechanism_request *request, const bool met[NAMES_MAX], lw_error *e)
{
    int k = 0;
    for (const char *at = request->only; strcmp(request->only, "all") != 0 && *at; k++) {
        size_t n = strcspn(at, ",");
        if (k < NAMES_MAX && !met[k])
            return lw_error_set(e, LW_E_ARG, "topology: nothing up to %d links is called '%.*s'; there are watt1, "
                                "watt2, stephenson1, stephenson2, stephenson3, chains by links and number as 8.5, and "
                                "by links, number of slots and gears, and number as 5.1.2", request->links, (int)n, at);
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

/* Add a stage, unless it has no chain. */
static lw_status add_stage(const lw_mechanism_request *request, lw_mechanism_set *t, int links, bool two_freedoms,
                           bool met[NAMES_MAX], lw_error *e)
{
    if (t->n == LW_STAGE_MAX || t->uncounted > 0)
        return LW_OK;
    lw_mechanism_stage *to = &t->stage[t->n++];
    *to = (lw_mechanism_stage){ .links = links, .two_freedoms = two_freedoms, .all = t };
    lw_status st = make_stage(request, to, met, e);
    if (to->tally.n_chain == 0 || st == LW_STOPPED) {
        stage_free(to);
        t->n--;
    }
    if (st != LW_STOPPED || is_stopped(request))
        return st;
    t->uncounted = links;
    return LW_OK;
}

lw_status lw_mechanism_set_make(const lw_mechanism_request *request, lw_mechanism_set *set, lw_error *e)
{
    lw_status st = LW_OK;
    bool met[NAMES_MAX] = { false };
    lw_error why = { .text = "" };
    memset(set, 0, sizeof *set);
    set->every = strcmp(request->only, "all") == 0;
    set->timed = request->timed;
    set->ratio = request->ratio;
    set->dof = request->dof;
    for (int links = request->dof == 1 ? 6 : request->dof + 3; links <= request->links; links += 2)
        st = st == LW_OK ? add_stage(request, set, links, false, met, &why) : st;
    int most = request->links < LW_EXPANDED_LINK_MAX ? request->links : LW_EXPANDED_LINK_MAX - 1;
    if (!lw_kinds_have_two_freedoms(request->kinds))
        most = 0;
    for (int links = 3; links <= most; links++)
        st = st == LW_OK ? add_stage(request, set, links, true, met, &why) : st;
    if (st == LW_OK)
        st = set->uncounted > 0 ? LW_OK : check_names(request, met, e);
    else if (st == LW_STOPPED)
        st = lw_error_set(e, LW_NOTHING, "stopped while mechanisms were still counted: none was searched");
    else if (why.text[0] && e)
        *e = why;
    else
        lw_graph_error(e, st);
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

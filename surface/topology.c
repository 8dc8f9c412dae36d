/* Chains and mechanisms, and which of them exist. */
#include "base/real.h"
#include "surface/surface.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "enumerate/assur.h"
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/derive.h"
#include "enumerate/estimate.h"
#include "enumerate/fractionated.h"
#include "enumerate/freedom.h"
#include "enumerate/higher.h"
#include "enumerate/labelled.h"
#include "enumerate/mechanisms.h"
#include "enumerate/multiple.h"
#include "enumerate/symmetry.h"
#include "grammar/topology/derivation.h"
#include "grammar/topology/growth.h"
#include "grammar/topology/notation.h"
#include "grammar/topology/planar.h"

/* ---- chains ---------------------------------------------------------------------------------------------- */

lw_status lw_chain_create(int n_link, lw_chain **out)
{
    lw_chain c;
    lw_status s = lw_chain_clear(&c, n_link);
    *out = NULL;
    return s == LW_OK ? LW_SURFACE_COPY(&c, out) : s;
}

lw_status lw_chain_copy(const lw_chain *chain, lw_chain **out) { return LW_SURFACE_COPY(chain, out); }
void      lw_chain_destroy(lw_chain *chain) { free(chain); }
int       lw_chain_n_link(const lw_chain *chain) { return chain->n_link; }

static bool has_link(int n_link, int i) { return i >= 0 && i < n_link; }

int lw_chain_joint_freedom(const lw_chain *chain, int i, int k)
{
    return has_link(chain->n_link, i) && has_link(chain->n_link, k) ? lw_chain_freedom(chain, i, k) : 0;
}

int lw_chain_links_with(const lw_chain *chain, int n_joint)
{
    int n_with[LW_LINK_MAX];
    lw_chain_assortment(chain, n_with);
    return n_joint >= 0 && n_joint < LW_LINK_MAX ? n_with[n_joint] : 0;
}

lw_status lw_chain_is_planar(const lw_chain *chain, bool *planar)
{
    return lw_planar_chain(chain, planar);
}

bool lw_chain_is_fractionated(const lw_chain *chain) { return lw_chain_cut_links(chain) != 0; }

lw_status lw_chain_is_isomorphic(const lw_chain *a, const lw_chain *b, bool *same)
{
    lw_chain fa, fb;
    lw_status s = lw_chain_canonical(a, &fa);
    if (s == LW_OK)
        s = lw_chain_canonical(b, &fb);
    *same = s == LW_OK && lw_chain_same(&fa, &fb);
    return s;
}

lw_status lw_chain_symmetries(const lw_chain *chain, uint64_t *order)
{
    lw_graph g;
    lw_graph_of_chain(chain, &g);
    return lw_graph_symmetry(&g, NULL, order);
}

/* ---- mechanisms --------------------------------------------------------------------------------------------- */

lw_status lw_mechanism_create(int n_link, lw_mechanism **out)
{
    lw_mechanism m;
    lw_status s = lw_mechanism_clear(&m, n_link);
    *out = NULL;
    return s == LW_OK ? LW_SURFACE_COPY(&m, out) : s;
}

lw_status lw_mechanism_copy(const lw_mechanism *from, lw_mechanism **out) { return LW_SURFACE_COPY(from, out); }
void      lw_mechanism_destroy(lw_mechanism *mechanism) { free(mechanism); }

lw_status lw_mechanism_of_chain(const lw_chain *chain, lw_mechanism **out)
{
    lw_mechanism m;
    lw_status s = lw_mechanism_from_chain(chain, &m);
    *out = NULL;
    return s == LW_OK ? LW_SURFACE_COPY(&m, out) : s;
}

int lw_mechanism_n_link(const lw_mechanism *mechanism) { return mechanism->n_link; }
int lw_mechanism_n_joint(const lw_mechanism *mechanism) { return mechanism->n_joint; }

char lw_mechanism_joint_kind(const lw_mechanism *mechanism, int joint, int link[2])
{
    if (joint < 0 || joint >= mechanism->n_joint)
        return 0;
    if (link) {
        link[0] = mechanism->link[joint][0];
        link[1] = mechanism->link[joint][1];
    }
    return mechanism->kind[joint];
}

int lw_mechanism_ground(const lw_mechanism *mechanism) { return mechanism->ground; }
int lw_mechanism_output(const lw_mechanism *mechanism) { return mechanism->output; }
int lw_mechanism_n_input(const lw_mechanism *mechanism) { return mechanism->n_input; }

int lw_mechanism_input(const lw_mechanism *mechanism, int i)
{
    return i >= 0 && i < mechanism->n_input ? mechanism->input[i] : -1;
}

int lw_mechanism_mobility(const lw_mechanism *mechanism)
{
    lw_chain c;
    lw_mechanism_chain(mechanism, &c);
    return lw_chain_mobility(&c);
}

lw_status lw_mechanism_choose(lw_mechanism *mechanism, int ground, int n_input, const int *input, int output)
{
    lw_mechanism m = *mechanism;
    if (ground < LW_NONE || ground >= m.n_link || output < LW_NONE || output >= m.n_link || n_input < 0 || n_input > LW_INPUT_MAX)
        return LW_E_ARG;
    m.ground = ground;
    m.output = output;
    m.n_input = n_input;
    for (int i = 0; i < n_input; i++) {
        if (input[i] < 0 || input[i] >= m.n_joint || (i > 0 && input[i] <= input[i - 1]) || lw_joint_freedoms(m.kind[input[i]]) != 1)
            return LW_E_ARG;
        m.input[i] = (uint8_t)input[i];
    }
    *mechanism = m;
    return LW_OK;
}

lw_status lw_mechanism_is_isomorphic(const lw_mechanism *a, const lw_mechanism *b, bool *same)
{
    lw_mechanism fa, fb;
    lw_status s = lw_mechanism_canonical(a, &fa);
    if (s == LW_OK)
        s = lw_mechanism_canonical(b, &fb);
    *same = s == LW_OK && lw_mechanism_same(&fa, &fb);
    return s;
}

lw_status lw_mechanism_moves(const lw_mechanism *mechanism, char *text, int size)
{
    uint64_t joints = 0;
    lw_void reason = lw_mechanism_void(mechanism, &joints);
    if (text && size > 0) {
        text[0] = 0;
        if (reason != LW_VOID_NOT)
            lw_void_print(mechanism, reason, joints, text, (size_t)size);
    }
    return reason == LW_VOID_NOT ? LW_OK : LW_NOTHING;
}

static lw_group_info group_info(const lw_assur_group *g, int link[LW_LINK_MAX])
{
    lw_group_info info = { .group_class = g->n_class, .order = g->order, .assembly_modes = g->n_mode, .link = link };
    for (int i = 0; i < LW_LINK_MAX; i++)
        if (g->links >> i & 1)
            link[info.n_link++] = i;
    return info;
}

lw_status lw_mechanism_groups(const lw_mechanism *mechanism, lw_group_visit *visit, void *context, lw_error *error)
{
    lw_assur a;
    int link[LW_LINK_MAX];
    lw_status s = lw_assur_decompose(mechanism, &a, error);
    for (int i = 0; s == LW_OK && i < a.n_group; i++) {
        lw_group_info info = group_info(&a.group[i], link);
        s = visit(context, &info);
    }
    return s;
}

lw_status lw_mechanism_derivation(const lw_mechanism *mechanism, char **out, lw_error *error)
{
    lw_growth g;
    lw_reach reach;
    uint32_t core = 0;
    char text[1024];
    lw_bytes b = { 0 };
    *out = NULL;
    lw_status s = lw_growth_find(mechanism, &g, &reach, &core, error);
    if (s != LW_OK)
        return s;
    lw_reach_print(mechanism, reach, core, text, sizeof text);
    lw_bytes_text(&b, text);
    lw_bytes_text(&b, "\n");
    for (int i = 0; reach <= LW_REACHED_NO_REGIONS && i < g.n_step; i++) {
        lw_production_print(&g.step[i], text, sizeof text);
        lw_bytes_text(&b, text);
        lw_bytes_text(&b, "\n");
    }
    return lw_surface_give(&b, out, NULL, error);
}

lw_status lw_sentence_derive(const char *sentence, int rule, const char *kinds, int x, int y, int word, char **out, lw_error *error)
{
    lw_production p = lw_production_of(rule);
    lw_sentence s;
    size_t n = (size_t)lw_rule_kinds(rule);
    *out = NULL;
    if (rule < 1 || rule > 4 || x < 0 || x > LW_LINK_MAX || y < 0 || y > LW_LINK_MAX || (kinds && strlen(kinds) != n)
        || (rule > 2 && !sentence))
        return lw_error_set(error, LW_E_ARG, "rules are 1 to 4, with as many kinds as they have joints k; 3 and 4 want "
                            "a sentence and two of its parts");
    if (kinds)
        memcpy(p.kind, kinds, n);
    p.x = (uint8_t)x;
    p.y = (uint8_t)y;
    p.word = word;
    lw_status status = rule <= 2 ? lw_rule_plant(&p, &s, error)
                     : lw_sentence_read(sentence, strlen(sentence), NULL, &s, error);
    if (status == LW_OK && rule > 2)
        status = lw_rule_apply(&s, &p, &s, error);
    if (status != LW_OK)
        return status;
    *out = malloc(LW_SENTENCE_SIZE);
    if (!*out)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_sentence_print(&s, *out, LW_SENTENCE_SIZE);
    return LW_OK;
}

/* ---- notations ------------------------------------------------------------------------------------------------ */

static lw_status notation_of(const char *name, const char *text, size_t size, const lw_notation **n, lw_error *e)
{
    *n = name ? lw_notation_find(name) : lw_notation_of(text, size);
    if (*n)
        return LW_OK;
    const char *known[16] = { 0 };
    for (int i = 0; i < 15 && lw_notations[i].name; i++)
        known[i] = lw_notations[i].name;
    lw_surface_word("notation", name, known, e);
    return LW_E_ARG;
}

static lw_status read_mechanism(const char *text, size_t size, const char *name, lw_mechanism *m, lw_error *e)
{
    const lw_notation *n;
    lw_status s = notation_of(name, text, size, &n, e);
    if (s != LW_OK)
        return s;
    return n->read ? n->read(text, size, NULL, m, e)
                   : lw_error_set(e, LW_E_ARG, "the notation %s is for writing only", n->name);
}

lw_status lw_mechanism_from_text(const char *text, size_t size, const char *notation, lw_mechanism **out, lw_error *error)
{
    lw_mechanism m;
    *out = NULL;
    lw_status s = read_mechanism(text, size, notation, &m, error);
    return s == LW_OK ? LW_SURFACE_COPY(&m, out) : s;
}

lw_status lw_chain_from_text(const char *text, size_t size, const char *notation, lw_chain **out, lw_error *error)
{
    lw_mechanism m;
    lw_chain c;
    *out = NULL;
    lw_status s = read_mechanism(text, size, notation, &m, error);
    if (s != LW_OK)
        return s;
    lw_mechanism_chain(&m, &c);
    return LW_SURFACE_COPY(&c, out);
}

lw_status lw_mechanism_to_text(const lw_mechanism *mechanism, const char *notation, char **out, lw_error *error)
{
    const lw_notation *n = NULL;
    size_t length;
    *out = NULL;
    lw_status s = notation ? notation_of(notation, "", 0, &n, error)
                           : lw_error_set(error, LW_E_ARG, "say in which notation");
    if (s != LW_OK)
        return s;
    char *text = malloc(LW_NOTATION_SIZE);
    if (!text)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    s = n->print(mechanism, text, LW_NOTATION_SIZE, &length);
    if (s == LW_OK) {
        *out = text;
        return s;
    }
    free(text);
    return lw_error_set(error, s, "this topology cannot be written as %s: %s", n->name, lw_status_text(s));
}

lw_status lw_chain_to_text(const lw_chain *chain, const char *notation, char **out, lw_error *error)
{
    lw_mechanism m;
    *out = NULL;
    if (lw_mechanism_from_chain(chain, &m) != LW_OK)
        return lw_error_set(error, LW_E_ARG, "more than %d joints", LW_JOINT_MAX);
    return lw_mechanism_to_text(&m, notation, out, error);
}

lw_status lw_mechanism_read_all(const char *text, size_t size, const char *file, lw_mechanism_callback *visit,
                                void *context, lw_error *error)
{
    lw_topologies t = lw_topologies_open(text, size, file);
    lw_mechanism m;
    lw_status s;
    while ((s = lw_topologies_next(&t, &m, error)) == LW_OK)
        if ((s = visit(context, &m)) != LW_OK)
            return s;
    return s == LW_NOTHING ? LW_OK : s;
}

/* ---- number synthesis, structures ----------------------------------------------------------------------------- */

static void put_numbers(const lw_numbers *n, lw_link_numbers *out)
{
    *out = (lw_link_numbers){ .links = n->n_link, .dof = n->dof, .loops = n->n_loop, .joints1 = n->n1,
                              .joints2 = n->n2 };
}

lw_status lw_link_numbers_of_loops(int dof, int loops, int joints2, lw_link_numbers *numbers, lw_error *error)
{
    lw_numbers n;
    lw_status s = lw_numbers_of(dof, loops, joints2, &n, error);
    if (s == LW_OK)
        put_numbers(&n, numbers);
    return s;
}

lw_status lw_link_numbers_of_links(int links, int dof, int joints2, lw_link_numbers *numbers, lw_error *error)
{
    lw_numbers n;
    lw_status s = lw_numbers_for_links(links, dof, joints2, &n, error);
    if (s == LW_OK)
        put_numbers(&n, numbers);
    return s;
}

lw_status lw_enumerate_assortments(const lw_link_numbers *numbers, lw_assortment_visit *visit, void *context)
{
    lw_numbers n;
    lw_assortment a;
    lw_status s = lw_numbers_of(numbers->dof, numbers->loops, numbers->joints2, &n, NULL);
    for (bool more = s == LW_OK && lw_assortment_first(&n, &a); more && s == LW_OK; more = lw_assortment_next(&n, &a))
        s = visit(context, a.n_with, n.n_loop + 2);
    return s;
}

lw_status lw_enumerate_structures(int loops, int jobs, lw_structure_visit *visit, void *context)
{
    lw_structures *set;
    lw_status s = lw_structures_create(loops, jobs, &set);
    if (s != LW_OK)
        return s;
    for (size_t i = 0; i < lw_structures_count(set, loops) && s == LW_OK; i++) {
        lw_structure structure;
        lw_derivation derivation;
        char text[LW_STRUCTURE_SIZE], way[LW_DERIVATION_SIZE];
        lw_structures_get(set, loops, i, &structure);
        lw_structures_derive(set, loops, i, &derivation);
        lw_structure_print(&structure, text, sizeof text);
        lw_derivation_print(&derivation, way, sizeof way);
        s = visit(context, text, way);
    }
    lw_structures_free(set);
    return s;
}

/* ---- chains that exist ------------------------------------------------------------------------------------------- */

lw_enumeration lw_enumeration_default(int links, int dof)
{
    return (lw_enumeration){ .links = links, .dof = dof, .parts = 1 };
}

typedef struct walk {
    const lw_enumeration *what;
    lw_chain_callback    *visit;
    void                 *context;
    double                begun;
    uint64_t              n;
} walk;

static lw_status visit_item(void *context, const lw_chain_item *item)
{
    walk *w = context;
    return w->visit(w->context, item->chain);
}

static lw_status visit_higher(void *context, const lw_chain *c)
{
    walk *w = context;
    w->n++;
    return w->visit ? w->visit(w->context, c) : LW_OK;
}

static lw_status visit_fractionated(void *context, const lw_chain *c, int n_bridge)
{
    (void)n_bridge;
    return visit_higher(context, c);
}

static bool tick(void *context, double done)
{
    const walk *w = context;
    return w->what->progress(w->what->context, done, lw_clock_wall() - w->begun, NAN);
}

static lw_status chains_of(walk *w, lw_chain_walk *how, lw_chains **all, lw_error *e)
{
    const lw_enumeration *o = w->what;
    *how = lw_chain_walk_default();
    *all = NULL;
    how->part = o->part;
    how->n_part = o->parts;
    how->skip = o->skip;
    how->n_thread = o->jobs;
    how->filter = o->filter ? lw_filter_find(o->filter) : NULL;
    how->tick = o->progress ? tick : NULL;
    how->tick_context = w;
    w->begun = lw_clock_wall();
    if (o->filter && !how->filter)
        return lw_error_set(e, LW_E_ARG, "there is no filter '%s'", o->filter);
    if (o->part < 0 || o->part >= o->parts)
        return lw_error_set(e, LW_E_ARG, "part %d of %d: parts count from 0", o->part, o->parts);
    return lw_chains_create(o->links, o->dof, o->jobs, all, e);
}

static lw_status special(walk *w, lw_error *e)
{
    const lw_enumeration *o = w->what;
    if (o->filter || o->parts != 1 || o->skip || (o->fractionated && o->joints2))
        return lw_error_set(e, LW_E_ARG, "filter, parts and skip are for chains of joints of one freedom that are not fractionated");
    return o->fractionated ? lw_fractionated_each(o->links, o->dof, visit_fractionated, w, e)
                           : lw_higher_each(o->links, o->dof, o->joints2, o->jobs, visit_higher, w, e);
}

lw_status lw_enumerate_chains(const lw_enumeration *what, lw_chain_callback *visit, void *context, lw_error *error)
{
    walk w = { .what = what, .visit = visit, .context = context };
    lw_chains *all;
    lw_chain_walk how;
    if (what->fractionated || what->joints2)
        return special(&w, error);
    lw_status s = chains_of(&w, &how, &all, error);
    if (s == LW_OK)
        s = lw_chains_each(all, &how, visit_item, &w);
    lw_chains_free(all);
    return s;
}

lw_status lw_enumerate_count(const lw_enumeration *what, uint64_t *chains, uint64_t *grounds, lw_error *error)
{
    walk w = { .what = what };
    lw_chains *all;
    lw_chain_walk how;
    lw_chain_table table = { .row = NULL };
    if (what->fractionated || what->joints2) {
        if (grounds)
            return lw_error_set(error, LW_E_ARG, "grounds are counted for joints of one freedom only");
        lw_status s = special(&w, error);
        *chains = w.n;
        return s;
    }
    if (what->filter && strcmp(what->filter, "generating") == 0 && (grounds || what->parts > 1))
        return lw_error_set(error, LW_E_ARG, "the filter 'generating' counts all chains, no parts and no ground links");
    lw_status s = chains_of(&w, &how, &all, error);
    if (s == LW_OK)
        s = lw_chains_count(all, &how, &table);
    if (s == LW_OK) {
        *chains = table.total.n_chain;
        if (grounds)
            *grounds = table.total.n_ground;
    }
    lw_chain_table_free(&table);
    lw_chains_free(all);
    return s;
}

lw_status lw_enumerate_labelled(int links, int dof, char *digits, lw_error *error)
{
    lw_numbers numbers;
    lw_chain_table table;
    lw_status s = lw_numbers_for_links(links, dof, 0, &numbers, error);
    if (s == LW_OK)
        s = lw_labelled_chains(&numbers, &table, error);
    if (s == LW_OK) {
        (void)lw_whole_print(table.total.n_labelled, digits);
        lw_chain_table_free(&table);
    }
    return s;
}

lw_status lw_enumerate_estimate(int links, int dof, lw_enumeration_cost *cost, lw_error *error)
{
    lw_estimate n;
    lw_status s = lw_chains_estimate(links, dof, &n, error);
    if (s == LW_OK)
        *cost = (lw_enumeration_cost){ .chains = n.chains, .count_seconds = n.structure_seconds + n.count_seconds,
                                       .list_seconds = n.structure_seconds + n.list_seconds, .bytes = n.bytes };
    return s;
}

typedef struct texts { lw_text_visit *visit; void *context; } texts;

static lw_status visit_multiple(void *context, const lw_multiple *m)
{
    const texts *t = context;
    char text[1024];
    lw_multiple_print(m, text, sizeof text);
    return t->visit(t->context, text);
}

lw_status lw_enumerate_multiple(int links, int dof, int jobs, lw_text_visit *visit, void *context, lw_error *error)
{
    texts t = { .visit = visit, .context = context };
    return lw_multiple_each(links, dof, jobs, visit_multiple, &t, error);
}

/* ---- mechanisms that exist -------------------------------------------------------------------------------------- */

lw_choices lw_choices_default(void) { return (lw_choices){ .ground = true }; }

typedef struct found { lw_mechanism_callback *visit; void *context; uint64_t n; } found;

static lw_status visit_mechanism(void *context, const lw_mechanism *m)
{
    found *f = context;
    f->n++;
    return f->visit ? f->visit(f->context, m) : LW_OK;
}

lw_status lw_enumerate_mechanisms(const lw_mechanism *of, const lw_choices *choices, lw_mechanism_callback *visit,
                                  void *context, uint64_t *n, lw_error *error)
{
    found f = { .visit = visit, .context = context };
    lw_mechanism_counts counts = { 0 };
    static const lw_input_choice input[] = { LW_INPUT_LEFT, LW_INPUT_GROUND, LW_INPUT_ANY };
    if (choices->inputs < 0 || choices->inputs > 2)
        return lw_error_set(error, LW_E_ARG, "inputs is 0, 1 or 2, not %d", choices->inputs);
    lw_mechanism_steps steps = { .ground = choices->ground, .kinds = choices->kinds, .output = choices->output,
                                 .input = input[choices->inputs] };
    lw_status s = lw_mechanisms_each(of, &steps, &counts, visit_mechanism, NULL, &f);
    if (n)
        *n = f.n;
    return s == LW_E_ARG ? lw_error_set(error, s, "these choices do not go together, or the mechanism has made them already") : s;
}

typedef struct groups { lw_assur_group_visit *visit; void *context; } groups;

static lw_status visit_group(void *context, const lw_chain *truss, int lost, const lw_assur_group *group)
{
    const groups *g = context;
    int link[LW_LINK_MAX];
    lw_group_info info = group_info(group, link);
    return g->visit(g->context, truss, lost, &info);
}

lw_status lw_enumerate_groups(int links, int jobs, lw_assur_group_visit *visit, void *context, lw_error *error)
{
    groups g = { .visit = visit, .context = context };
    return lw_assur_each(links, jobs, visit_group, &g, error);
}

lw_status lw_enumerate_grammar(int links, const char *rules, const char *kinds, bool regions,
                               lw_mechanism_callback *visit, void *context, lw_error *error)
{
    lw_derive how = lw_derive_default(links);
    how.regions = regions;
    how.kinds = kinds;
    for (int r = 1; r <= 4; r++)
        how.rule[r] = strchr(rules, '0' + r) != NULL;
    lw_status s = lw_derive_each(&how, visit, context);
    return s == LW_E_ARG ? lw_error_set(error, s, "rules are of 1234, kinds r, t or rt, links 3 to %d", LW_LINK_MAX) : s;
}

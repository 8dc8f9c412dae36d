/* catalogues/build/build_chains.c - chains, structures, ground links, inputs and Assur groups into a catalogue.
 *
 * Chains come in the order of their enumeration, in blocks.  All threads describe the chains of a block, then one
 * thread writes them.  Every transaction also stores how many chains are in the file: a later call continues there. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/growable_array.h"
#include "base/parallel.h"
#include "catalogues/build/build_internal.h"
#include "catalogues/store/store_layout.h"
#include "enumerate/assur.h"
#include "enumerate/canon.h"
#include "enumerate/mechanisms.h"
#include "grammar/topology/derivation.h"
#include "grammar/topology/graph6.h"
#include "grammar/topology/notation.h"

#define BLOCK 32                       /* chains described between two writes                        */

/* One chain and its description. */
typedef struct entry {
    lw_chain            chain;
    size_t              structure;             /* index among the structures with its number of loops */
    lw_store_chain      row;
    uint8_t             ground[LW_LINK_MAX], alike[LW_LINK_MAX];
    int                 n_with[5];
    lw_bytes            layout;
    lw_bytes            text;                  /* all texts; pointers into it are set at the end */
    int                 n_mechanism, capacity, place_capacity;
    lw_store_mechanism *mechanism;
    size_t             *place;                 /* offsets of kinds, inputs, groups in text     (3n)   */
    const lw_build_control *control;
    lw_status           status;
    lw_error            e;
} entry;

typedef struct job {
    const lw_build_topologies *what;
    const lw_build_control    *control;
    lw_build_counts           *counts;
    const lw_filter           *planar;
    const lw_chains           *chains;
    lw_build_transaction       transaction;
    int                        n;
    entry                      entry[BLOCK];
    lw_error                   e;
} job;

/* ---- description of a chain: any thread ---------------------------------------------------------- */

static size_t add_text(lw_bytes *b, const char *text)
{
    size_t at = b->size;
    lw_bytes_add(b, text, strlen(text) + 1);
    return at;
}

static void print_inputs(const lw_mechanism *m, char *text, size_t size)
{
    size_t n = 0;
    for (int i = 0; i < m->n_input && n < size; i++)
        n += (size_t)snprintf(text + n, size - n, "%s%d-%d", i ? " " : "", m->link[m->input[i]][0] + 1, m->link[m->input[i]][1] + 1);
}

#define GROUPS_SIZE (LW_LINK_MAX*16)

/* "I1:2 II2:3,4" */
static void print_groups(const lw_assur *a, char text[GROUPS_SIZE])
{
    static const char *const roman[] = { "?", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X" };
    size_t n = 0;
    text[0] = 0;
    for (int k = 0; k < a->n_group; k++) {
        const lw_assur_group *g = &a->group[k];
        n += (size_t)snprintf(text + n, GROUPS_SIZE - n, "%s%s%d:", k ? " " : "", g->n_class <= 10 ? roman[g->n_class] : "?", g->order);
        for (uint32_t l = g->links; l; l &= l - 1)
            n += (size_t)snprintf(text + n, GROUPS_SIZE - n, "%s%d", l == g->links ? "" : ",", __builtin_ctz(l) + 1);
    }
}

static lw_status take_mechanism(void *context, const lw_mechanism *m)
{
    entry *x = context;
    lw_assur a;
    char kinds[LW_JOINT_MAX + 1] = "", inputs[LW_INPUT_MAX*8], groups[GROUPS_SIZE];
    lw_status s = lw_build_stopped(x->control) ? LW_STOPPED : lw_assur_decompose(m, &a, &x->e);
    if (s != LW_OK)
        return s;
    void *mechanism = lw_array_grow(x->mechanism, x->n_mechanism, &x->capacity, sizeof *x->mechanism);
    x->mechanism = mechanism ? mechanism : x->mechanism;
    void *place = lw_array_grow(x->place, x->n_mechanism, &x->place_capacity, 3*sizeof *x->place);
    x->place = place ? place : x->place;
    if (!mechanism || !place)
        return LW_E_MEMORY;
    lw_store_mechanism *row = &x->mechanism[x->n_mechanism];
    *row = (lw_store_mechanism){ .ground = m->ground + 1, .n_group = a.n_group, .modes = 1 };
    memcpy(kinds, m->kind, (size_t)m->n_joint);
    for (int j = 0; j < m->n_joint; j++)
        row->n_slider += lw_joint_holds_rotation(m->kind[j]);
    for (int k = 0; k < a.n_group; k++) {
        row->highest = a.group[k].n_class > row->highest ? a.group[k].n_class : row->highest;
        row->modes *= a.group[k].n_class == 1 ? 1 : a.group[k].n_mode;     /* a crank's posture is given by its input */
    }
    print_inputs(m, inputs, sizeof inputs);
    print_groups(&a, groups);
    size_t *p = &x->place[3*x->n_mechanism++];
    p[0] = add_text(&x->text, kinds);
    p[1] = add_text(&x->text, inputs);
    p[2] = add_text(&x->text, groups);
    return LW_OK;
}

static lw_status count_symmetry(const lw_chain *c, entry *x)
{
    lw_graph g;
    uint8_t lowest[LW_GRAPH_MAX];
    lw_graph_of_chain(c, &g);
    lw_status s = lw_graph_symmetry(&g, lowest, &x->row.symmetry);
    if (s != LW_OK)
        return s;
    x->row.n_ground = 0;
    for (int i = 0; i < c->n_link; i++) {
        int alike = 0;
        for (int k = 0; k < c->n_link; k++)
            alike += lowest[k] == i;
        if (alike > 0) {
            x->ground[x->row.n_ground] = (uint8_t)(i + 1);
            x->alike[x->row.n_ground++] = (uint8_t)alike;
        }
    }
    return LW_OK;
}

static void print_assortment(const lw_chain *c, entry *x, char text[LW_LINK_MAX*4])
{
    int n_with[LW_LINK_MAX], most = 2;
    size_t n = 0;
    lw_chain_assortment(c, n_with);
    for (int d = 2; d < LW_LINK_MAX; d++)
        most = n_with[d] > 0 ? d : most;
    for (int d = 2; d <= most; d++)
        n += (size_t)snprintf(text + n, LW_LINK_MAX*4 - n, "%s%d", d > 2 ? " " : "", n_with[d]);
    memcpy(x->n_with, n_with + 2, sizeof x->n_with);
}

/* The texts of a chain, in the order in which they are stored. */
enum { LABEL, GRAPH6, FRANKE, SENTENCE, MATRIX, ASSORTMENT, N_TEXT };

static lw_status print_chain(const lw_chain *c, const lw_mechanism *m, entry *x, size_t place[N_TEXT])
{
    static const char *const notation[] = { [FRANKE] = "franke", [SENTENCE] = "sentence", [MATRIX] = "lam" };
    char text[LW_NOTATION_SIZE];
    lw_chain form;
    size_t length;
    lw_status s = lw_chain_canonical(c, &form);
    if (s != LW_OK)
        return s;
    lw_graph6_print(&form, text, sizeof text);
    place[LABEL] = add_text(&x->text, text);
    lw_graph6_print(c, text, sizeof text);
    place[GRAPH6] = add_text(&x->text, text);
    for (int i = FRANKE; i <= MATRIX && s == LW_OK; i++) {
        s = lw_notation_find(notation[i])->print(m, text, sizeof text, &length);
        place[i] = add_text(&x->text, text);
    }
    print_assortment(c, x, text);
    place[ASSORTMENT] = add_text(&x->text, text);
    return s;
}

static void set_texts(entry *x, const size_t place[N_TEXT])
{
    const char *t = x->text.data;
    x->row.label = t + place[LABEL];
    x->row.graph6 = t + place[GRAPH6];
    x->row.franke = t + place[FRANKE];
    x->row.sentence = t + place[SENTENCE];
    x->row.matrix = t + place[MATRIX];
    x->row.assortment = t + place[ASSORTMENT];
    for (int i = 0; i < x->n_mechanism; i++) {
        x->mechanism[i].kinds = t + x->place[3*i];
        x->mechanism[i].inputs = t + x->place[3*i + 1];
        x->mechanism[i].groups = t + x->place[3*i + 2];
    }
    x->row.n_with = x->n_with;
    x->row.ground = x->ground;
    x->row.alike = x->alike;
    x->row.mechanism = x->mechanism;
    x->row.n_mechanism = (size_t)x->n_mechanism;
}

/* Compute the places of the joints in a picture. */
static lw_status lay_out(const lw_mechanism *m, entry *x)
{
    lw_chain_layout l;
    lw_status s = lw_chain_layout_make(m, &l, &x->e);
    if (s != LW_OK)
        return s;
    lw_layout_pack(&l, m->n_link, &x->layout);
    x->row.layout = x->layout.data;
    x->row.layout_size = x->layout.size;
    return x->layout.failed ? LW_E_MEMORY : LW_OK;
}

static lw_status describe(const job *j, entry *x)
{
    const lw_chain *c = &x->chain;
    lw_mechanism m;
    lw_mechanism_counts counts = { 0 };
    lw_mechanism_steps steps = { .ground = true, .kinds = strcmp(j->what->kinds, "r") == 0 ? NULL : j->what->kinds,
                                 .input = j->what->any_input ? LW_INPUT_ANY : LW_INPUT_GROUND };
    size_t place[N_TEXT];
    lw_store_chain *r = &x->row;
    *r = (lw_store_chain){ .links = c->n_link, .dof = lw_chain_mobility(c), .joints = lw_chain_count(c, 1),
                           .loops = lw_chain_loops(c) };
    r->structure = r->loops > 1 ? (int)x->structure + 1 : 0;
    x->n_mechanism = 0;
    x->text.size = x->layout.size = 0;
    lw_status s = lw_mechanism_from_chain(c, &m);
    if (s == LW_OK)
        s = count_symmetry(c, x);
    if (s == LW_OK)
        s = j->planar->chain(c, &r->planar);
    if (s == LW_OK)
        s = print_chain(c, &m, x, place);
    if (s == LW_OK && j->what->pictures)
        s = lay_out(&m, x);
    if (s == LW_OK)
        s = lw_mechanisms_each(&m, &steps, &counts, take_mechanism, NULL, x);
    if (s == LW_OK && x->text.failed)
        s = LW_E_MEMORY;
    if (s == LW_OK)
        set_texts(x, place);
    return s;
}

static void describe_one(void *context, size_t i, int thread)
{
    job *j = context;
    (void)thread;
    j->entry[i].status = describe(j, &j->entry[i]);
}

/* ---- writing -------------------------------------------------------------------------------------- */

static lw_status close_transaction(job *j, bool complete)
{
    lw_store *store = j->transaction.store;
    lw_status s = lw_build_open(&j->transaction, &j->e);
    if (s == LW_OK)
        s = lw_store_build_done(store, j->counts->done, complete, &j->e);
    if (s == LW_OK && complete)
        s = lw_store_run_end(store, &j->e);
    return s == LW_OK ? lw_build_commit(&j->transaction, &j->e) : s;
}

static lw_status write_block(job *j)
{
    lw_build_transaction *t = &j->transaction;
    lw_parallel(j->control->jobs, (size_t)j->n, describe_one, j);
    lw_status s = j->n > 0 ? lw_build_open(t, &j->e) : LW_OK;
    for (int i = 0; i < j->n && s == LW_OK; i++) {
        entry *x = &j->entry[i];
        if (x->status != LW_OK)
            s = x->e.text[0] ? lw_error_set(&j->e, x->status, "%s", x->e.text) : lw_graph_error(&j->e, x->status);
        else
            s = lw_store_put_chain(t->store, &x->row, &j->e);
        j->counts->done += s == LW_OK;
    }
    j->n = 0;
    if (s == LW_OK && lw_build_due(t))
        s = close_transaction(j, false);
    if (s == LW_OK && !lw_build_goes_on(j->control, (double)j->counts->done, (double)j->counts->total))
        s = LW_STOPPED;
    return s;
}

static lw_status take_chain(void *context, const lw_chain_item *item)
{
    job *j = context;
    entry *x = &j->entry[j->n++];
    x->chain = *item->chain;
    x->structure = item->index;
    x->control = j->control;
    return j->n < BLOCK ? LW_OK : write_block(j);
}

static lw_status write_structures(job *j)
{
    const lw_structures *set = lw_chains_structures(j->chains);
    lw_status s = LW_OK;
    if (!set)
        return LW_OK;
    int loops = lw_structures_loops(set);
    for (size_t i = 0; i < lw_structures_count(set, loops) && s == LW_OK; i++) {
        lw_structure one;
        lw_derivation d;
        char form[LW_STRUCTURE_SIZE], derivation[LW_DERIVATION_SIZE];
        lw_structures_get(set, loops, i, &one);
        lw_structures_derive(set, loops, i, &d);
        lw_structure_print(&one, form, sizeof form);
        lw_derivation_print(&d, derivation, sizeof derivation);
        bool planar = false;
        s = lw_build_stopped(j->control) ? LW_STOPPED : lw_graph_error(&j->e, j->planar->structure(&one, &planar));
        lw_store_structure t = { loops, (int)i + 1, one.n_circle, one.n_line, planar, form, derivation };
        if (s == LW_OK)
            s = lw_store_put_structure(j->transaction.store, &t, &j->e);
    }
    return s;
}

/* ---- the whole ------------------------------------------------------------------------------------- */

/* Record the run, find out how many chains are stored, and store the structures first. */
static lw_status begin(job *j)
{
    const lw_numbers *numbers = lw_chains_numbers(j->chains);
    lw_store *store = j->transaction.store;
    char what[64], joints[16];
    snprintf(joints, sizeof joints, "%s%s", j->what->kinds, j->what->any_input ? " any" : "");
    snprintf(what, sizeof what, "links %d, dof %d, joints %s", numbers->n_link, numbers->dof, joints);
    lw_store_run run = { "build", what, lw_build_command(j->control), j->control->seed };
    lw_status status = lw_build_open(&j->transaction, &j->e);
    if (status == LW_OK)
        status = lw_store_build_begin(store, numbers->n_link, numbers->dof, joints, &j->counts->done, &j->counts->was_complete, &j->e);
    j->counts->before = j->counts->done;
    if (status != LW_OK || j->counts->was_complete)
        return status;
    status = lw_store_run_begin(store, &run, &j->e);
    if (status == LW_OK && j->counts->done == 0)
        status = write_structures(j);
    return status == LW_OK ? close_transaction(j, false) : status;
}

static bool not_stopped(void *job_of, double done)
{
    (void)done;
    return !lw_build_stopped(((job *)job_of)->control);
}

static lw_status write_all(job *j)
{
    lw_chain_walk how = lw_chain_walk_default();
    how.tick = not_stopped;
    how.tick_context = j;
    lw_chain_table table;
    lw_status s = lw_chains_count(j->chains, &how, &table);
    j->counts->total = table.total.n_chain;
    lw_chain_table_free(&table);
    how.skip = j->counts->done;
    if (s == LW_OK)
        s = lw_chains_each(j->chains, &how, take_chain, j);
    if (s == LW_OK)
        s = write_block(j);
    if (s == LW_OK || s == LW_STOPPED) {
        lw_status t = close_transaction(j, s == LW_OK);
        s = t == LW_OK ? s : t;
    }
    return s;
}

lw_status lw_build_chains(lw_store *s, const lw_chains *chains, const lw_build_topologies *what,
                          const lw_build_control *control, lw_build_counts *counts, lw_error *e)
{
    *counts = (lw_build_counts){ 0 };
    if (strcmp(what->kinds, "r") != 0 && strcmp(what->kinds, "rt") != 0 && strcmp(what->kinds, "t") != 0)
        return lw_error_set(e, LW_E_ARG, "kinds of joints are r, rt or t, not '%.20s'", what->kinds);
    job *j = calloc(1, sizeof *j);
    if (!j)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    *j = (job){ .what = what, .control = control, .counts = counts, .planar = lw_filter_find("planar"),
                .chains = chains, .transaction = { .store = s, .commit = control->commit } };
    lw_status status = begin(j);
    if (status == LW_OK && !counts->was_complete)
        status = write_all(j);
    lw_build_rollback(&j->transaction);
    for (int i = 0; i < BLOCK; i++) {
        lw_bytes_free(&j->entry[i].text);
        lw_bytes_free(&j->entry[i].layout);
        free(j->entry[i].mechanism);
        free(j->entry[i].place);
    }
    status = lw_build_fault(status, &j->e, e);
    free(j);
    return status;
}

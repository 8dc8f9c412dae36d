/* linkwright catalogue build - chains, structures, ground links, inputs and Assur groups into a catalogue.
 *
 * Chains come in the order of enumeration, in blocks.  All that is to be said of a block is worked out on all
 * cores, then written by one; with each transaction goes the number of chains that are in the file, which is
 * where a later call goes on. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "catalogues/store/store_layout.h"
#include "cli/catalogue/catalogue.h"
#include "enumerate/assur.h"
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/mechanisms.h"
#include "grammar/derivation.h"
#include "grammar/franke.h"
#include "grammar/graph6.h"
#include "grammar/notation.h"

#define BLOCK 32

/* One chain and all that is said of it. */
typedef struct entry {
    lw_chain            chain;
    size_t              structure;             /* index among those with its number of loops         */
    lw_store_chain      row;
    uint8_t             ground[LW_LINK_MAX], alike[LW_LINK_MAX];
    int                 n_with[5];
    lw_bytes            layout;
    lw_bytes            text;                  /* all texts; until the end pointers are offsets here */
    size_t              n_mechanism, room;
    lw_store_mechanism *mechanism;
    size_t             *place;                 /* kinds, inputs, groups of each               (3n)   */
    lw_status           status;
    lw_error            e;
} entry;

typedef struct job {
    const cli_call    *call;
    const char        *kinds;
    bool               any_input, no_pictures;
    const lw_filter   *planar;
    lw_store          *store;
    lw_chains         *chains;
    cli_catalogue_watch watch;
    uint64_t           done, total;
    bool               open;                   /* a transaction                                      */
    double             begun;
    int                n;
    entry              entry[BLOCK];
    lw_error           e;
} job;

/* ---- what is said of a chain: any thread ---------------------------------------------------------- */

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
        n += (size_t)snprintf(text + n, size - n, "%s%d-%d", i ? " " : "", m->link[m->input[i]][0] + 1,
                              m->link[m->input[i]][1] + 1);
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
        n += (size_t)snprintf(text + n, GROUPS_SIZE - n, "%s%s%d:", k ? " " : "",
                              g->n_class <= 10 ? roman[g->n_class] : "?", g->order);
        for (uint32_t l = g->links; l; l &= l - 1)
            n += (size_t)snprintf(text + n, GROUPS_SIZE - n, "%s%d", l == g->links ? "" : ",", __builtin_ctz(l) + 1);
    }
}

static lw_status make_room(entry *x)
{
    if (x->n_mechanism < x->room)
        return LW_OK;
    size_t room = x->room ? 2*x->room : 64;
    lw_store_mechanism *m = realloc(x->mechanism, room*sizeof *m);
    x->mechanism = m ? m : x->mechanism;
    size_t *p = realloc(x->place, 3*room*sizeof *p);
    x->place = p ? p : x->place;
    if (!m || !p)
        return LW_E_MEMORY;
    x->room = room;
    return LW_OK;
}

static lw_status take_mechanism(void *context, const lw_mechanism *m)
{
    entry *x = context;
    lw_assur a;
    char kinds[LW_JOINT_MAX + 1] = "", inputs[LW_INPUT_MAX*8], groups[GROUPS_SIZE];
    lw_status s = lw_assur_decompose(m, &a, &x->e);
    if (s == LW_OK)
        s = make_room(x);
    if (s != LW_OK)
        return s;
    lw_store_mechanism *row = &x->mechanism[x->n_mechanism];
    *row = (lw_store_mechanism){ .ground = m->ground + 1, .n_group = a.n_group, .modes = 1 };
    memcpy(kinds, m->kind, (size_t)m->n_joint);
    for (int j = 0; j < m->n_joint; j++)
        row->n_slider += m->kind[j] == LW_JOINT_SLIDER;
    for (int k = 0; k < a.n_group; k++) {
        row->highest = a.group[k].n_class > row->highest ? a.group[k].n_class : row->highest;
        row->modes *= a.group[k].n_class == 1 ? 1 : a.group[k].n_mode;     /* a crank stands where it is told */
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
    lw_symmetry_group group;
    uint8_t (*element)[LW_GRAPH_MAX] = NULL;
    size_t n = 1;
    lw_graph_of_chain(c, &g);
    lw_status s = lw_graph_group(&g, &group);
    if (s != LW_OK)
        return s;
    if (group.n_generator > 0)
        s = lw_symmetry_group_elements(&group, &element, &n);
    x->row.symmetry = n;
    x->row.n_ground = 0;
    for (int i = 0; i < c->n_link; i++) {
        int alike = 0;
        for (int k = 0; k < c->n_link; k++)
            alike += group.orbit[k] == i;
        if (alike > 0) {
            x->ground[x->row.n_ground] = (uint8_t)(i + 1);
            x->alike[x->row.n_ground++] = (uint8_t)alike;
        }
    }
    free(element);
    lw_symmetry_group_free(&group);
    return s;
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

/* The texts of the chain, in this order. */
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
    for (size_t i = 0; i < x->n_mechanism; i++) {
        x->mechanism[i].kinds = t + x->place[3*i];
        x->mechanism[i].inputs = t + x->place[3*i + 1];
        x->mechanism[i].groups = t + x->place[3*i + 2];
    }
    x->row.n_with = x->n_with;
    x->row.ground = x->ground;
    x->row.alike = x->alike;
    x->row.mechanism = x->mechanism;
    x->row.n_mechanism = x->n_mechanism;
}

/* Where the joints go in a picture. */
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
    lw_mechanism_steps steps = { .ground = true, .kinds = strcmp(j->kinds, "r") == 0 ? NULL : j->kinds,
                                 .input = j->any_input ? LW_INPUT_ANY : LW_INPUT_GROUND };
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
    r->planar = j->planar->chain(c);
    if (s == LW_OK)
        s = print_chain(c, &m, x, place);
    if (s == LW_OK && !j->no_pictures)
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

static lw_status open_transaction(job *j)
{
    if (j->open)
        return LW_OK;
    lw_status s = lw_store_begin(j->store, &j->e);
    j->open = s == LW_OK;
    j->begun = lw_clock_wall();
    return s;
}

static lw_status close_transaction(job *j, bool complete)
{
    lw_status s = open_transaction(j);
    if (s == LW_OK)
        s = lw_store_build_done(j->store, j->done, complete, &j->e);
    if (s == LW_OK && complete)
        s = lw_store_run_end(j->store, &j->e);
    if (s == LW_OK)
        s = lw_store_commit(j->store, &j->e);
    j->open = false;
    return s;
}

static lw_status write_block(job *j)
{
    const cli_catalogue_settings *settings = j->call->settings;
    lw_parallel(j->call->common.jobs, (size_t)j->n, describe_one, j);
    lw_status s = j->n > 0 ? open_transaction(j) : LW_OK;
    for (int i = 0; i < j->n && s == LW_OK; i++) {
        entry *x = &j->entry[i];
        if (x->status != LW_OK)
            s = lw_error_set(&j->e, x->status, "%s", x->e.text[0] ? x->e.text : lw_status_text(x->status));
        else
            s = lw_store_put_chain(j->store, &x->row, &j->e);
        j->done += s == LW_OK;
    }
    j->n = 0;
    if (s == LW_OK && j->open && lw_clock_wall() - j->begun >= settings->commit)
        s = close_transaction(j, false);
    if (s == LW_OK && !cli_catalogue_goes_on(&j->watch, (double)j->done))
        s = LW_STOPPED;
    return s;
}

static lw_status take_chain(void *context, const lw_chain_item *item)
{
    job *j = context;
    entry *x = &j->entry[j->n++];
    x->chain = *item->chain;
    x->structure = item->index;
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
        lw_store_structure t = { loops, (int)i + 1, one.n_circle, one.n_line, j->planar->structure(&one), form,
                                 derivation };
        s = lw_store_put_structure(j->store, &t, &j->e);
    }
    return s;
}

/* ---- the action ------------------------------------------------------------------------------------ */

static lw_status begin(job *j, bool *complete)
{
    const cli_catalogue_settings *s = j->call->settings;
    char what[64], joints[16];
    snprintf(joints, sizeof joints, "%s%s", j->kinds, j->any_input ? " any" : "");
    snprintf(what, sizeof what, "links %d, dof %d, joints %s", s->links, s->dof, joints);
    lw_store_run run = { .action = "build", .what = what, .command = j->call->line, .seed = j->call->common.seed };
    lw_status status = open_transaction(j);
    if (status == LW_OK)
        status = lw_store_build_begin(j->store, s->links, s->dof, joints, &j->done, complete, &j->e);
    if (status != LW_OK || *complete)
        return status;
    status = lw_store_run_begin(j->store, &run, &j->e);
    if (status == LW_OK && j->done == 0)
        status = write_structures(j);
    return status == LW_OK ? close_transaction(j, false) : status;
}

static lw_status write_all(job *j)
{
    lw_chain_walk how = lw_chain_walk_default();
    lw_chain_table table;
    lw_status s = lw_chains_count(j->chains, &how, &table);
    j->total = table.total.n_chain;
    lw_chain_table_free(&table);
    j->watch.total = (double)j->total;
    how.skip = j->done;
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

static lw_status build(job *j, bool *was_complete)
{
    const cli_catalogue_settings *s = j->call->settings;
    uint64_t before;
    lw_status status = lw_chains_create(s->links, s->dof, j->call->common.jobs, &j->chains, &j->e);
    if (status == LW_OK)
        status = cli_catalogue_open(j->call, true, &j->store, &j->e);
    if (status == LW_OK)
        status = begin(j, was_complete);
    before = j->done;
    if (status == LW_OK && !*was_complete) {
        if (before > 0)
            cli_note(j->call, "goes on behind %llu chains", (unsigned long long)before);
        status = write_all(j);
    }
    if (status < 0 && !j->e.text[0])
        lw_error_set(&j->e, status, "%s", lw_status_text(status));
    if (j->open)
        lw_store_rollback(j->store);
    return status;
}

static void free_job(job *j)
{
    for (int i = 0; i < BLOCK; i++) {
        lw_bytes_free(&j->entry[i].text);
        lw_bytes_free(&j->entry[i].layout);
        free(j->entry[i].mechanism);
        free(j->entry[i].place);
    }
    lw_store_close(j->store);
    lw_chains_free(j->chains);
    free(j);
}

/* "r", "rt", "t"; NULL for anything else. */
static const char *read_kinds(const char *text)
{
    static const char *const known[][2] = {
        { "r", "r" }, { "r,t", "rt" }, { "rt", "rt" }, { "t,r", "rt" }, { "t", "t" }
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++)
        if (strcmp(text, known[i][0]) == 0)
            return known[i][1];
    return NULL;
}

int cli_catalogue_build(const cli_call *call)
{
    const cli_catalogue_settings *s = call->settings;
    bool was_complete = false;
    if (s->links == 0)
        return cli_usage(call, "how many links? give --links P");
    if (!read_kinds(s->joints))
        return cli_usage(call, "--joints takes r, t or r,t, not '%s'", s->joints);
    job *j = calloc(1, sizeof *j);
    if (!j) {
        lw_error e;
        lw_error_set(&e, LW_E_MEMORY, "out of memory");
        return cli_fail(call, &e);
    }
    j->call = call;
    j->kinds = read_kinds(s->joints);
    j->any_input = s->input == 1;
    j->no_pictures = s->no_pictures;
    j->planar = lw_filter_find("planar");
    j->watch = cli_catalogue_watch_begin(call, "build", "chains");
    double start = lw_clock_wall();
    lw_status status = build(j, &was_complete);
    int code = cli_catalogue_watch_end(&j->watch, status < 0 ? cli_fail(call, &j->e) : CLI_DONE);
    if (status >= 0 && was_complete)
        cli_note(call, "it is complete already: %llu chains", (unsigned long long)j->done);
    else if (status >= 0)
        cli_note(call, "%llu of %llu chains in %.2f s%s", (unsigned long long)j->done, (unsigned long long)j->total,
                 lw_clock_wall() - start, status == LW_OK ? "" : "; the same command goes on from here");
    free_job(j);
    return code;
}

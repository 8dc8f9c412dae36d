/* catalogues/pages/atlas_html.c - see atlas_html.h; reads the chains, writes page after page */
#include "catalogues/pages/atlas_html.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/parallel.h"
#include "catalogues/pages/atlas_html_internal.h"
#include "catalogues/pages/page_files.h"             /* made from *.css and *.js by the Makefile */
#include "catalogues/pages/page_internal.h"
#include "grammar/notation.h"

#define PAGE_BYTES    8000.0   /* of a chain's page ...                              */
#define PICTURE_BYTES 6600.0   /* ... and of each picture of a ground link, measured */
#define BLOCK 64               /* chains whose pictures are worked out together, by all threads */

lw_atlas_html_options lw_atlas_html_options_default(void)
{
    return (lw_atlas_html_options){ .title = "Atlas of mechanisms", .n_linkage = 12 };
}

void lw_leaf_file(const lw_leaf *l, const char *kind, char file[LW_LEAF_FILE])
{
    snprintf(file, LW_LEAF_FILE, "%s-%d-%d-%d.html", kind, l->links, l->dof, l->number);
}

void lw_leaf_family(const lw_leaf *l, char *out, size_t size)
{
    snprintf(out, size, "%d links, F = %d", l->links, l->dof);
}

const char *lw_value_text(const lw_value *v)
{
    return v->kind == LW_VALUE_TEXT && v->text ? v->text : "";
}

lw_value lw_value_of_text(const char *text)
{
    return (lw_value){ .kind = LW_VALUE_TEXT, .text = text, .size = strlen(text) };
}

lw_value lw_value_of_integer(long long i)
{
    return (lw_value){ .kind = LW_VALUE_INTEGER, .integer = i };
}

lw_status lw_atlas_ask(lw_atlas_html *a, const char *sql, const lw_value *value,
                       lw_status (*row)(void *, int, const char *const *, const lw_value *), void *context,
                       lw_error *e)
{
    lw_store_query q = { .sql = sql, .value = value, .n_value = value ? 1 : 0, .row = row, .context = context };
    lw_status s = lw_store_ask(a->store, &q, e);
    return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory for the pages of the atlas") : s;
}

/* ---- reading ------------------------------------------------------------------------------------ */

static const char chain_sql[] =
    "SELECT c.id, c.links, c.dof, c.joints, c.loops, c.symmetry, c.grounds, c.planar, c.label, c.graph6,"
    " c.assortment, c.franke, c.sentence, c.matrix, s.form, s.derivation"
    " FROM chain c LEFT JOIN structure s ON s.id = c.structure WHERE ?1 = 0 OR c.links = ?1"
    " ORDER BY c.dof, c.links, c.id LIMIT ?2";
static const char size_sql[] =
    "SELECT count(*), total(grounds) FROM (SELECT grounds FROM chain WHERE ?1 = 0 OR links = ?1"
    " ORDER BY dof, links, id LIMIT ?2)";

/* A question about the chains that are shown. */
static lw_status ask_chains(lw_store *store, const lw_atlas_html_options *o, const char *sql,
                            lw_status (*row)(void *, int, const char *const *, const lw_value *), void *context,
                            lw_error *e)
{
    const lw_value v[] = { lw_value_of_integer(o->links), lw_value_of_integer(o->limit > 0 ? o->limit : -1) };
    lw_store_query q = { .sql = sql, .value = v, .n_value = 2, .row = row, .context = context };
    lw_status s = lw_store_ask(store, &q, e);
    return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory for the pages of the atlas") : s;
}

static lw_status take_size(void *context, int n, const char *const *name, const lw_value *v)
{
    double *size = context;
    (void)n, (void)name;
    size[0] = (double)v[0].integer;
    size[1] = v[1].real;
    return LW_OK;
}

lw_status lw_atlas_html_expect(lw_store *store, const lw_atlas_html_options *o, size_t *n_chain, double *n_byte,
                               lw_error *e)
{
    double size[2] = { 0, 0 };
    lw_status s = ask_chains(store, o, size_sql, take_size, size, e);
    *n_chain = (size_t)size[0];
    *n_byte = PAGE_BYTES*size[0] + PICTURE_BYTES*size[1];
    return s;
}

static bool copy_texts(lw_leaf *l, const lw_value *v)
{
    size_t size = 0;
    for (int i = 0; i < LW_LEAF_TEXTS; i++)
        size += strlen(lw_value_text(&v[i])) + 1;
    char *block = malloc(size);
    for (int i = 0; block && i < LW_LEAF_TEXTS; i++) {
        l->text[i] = block;
        block += strlen(strcpy(block, lw_value_text(&v[i]))) + 1;
    }
    return block != NULL;
}

static lw_status add_leaf(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    lw_atlas_html *a = context;
    if (a->n == a->room) {
        size_t room = 2*a->room + 64;
        lw_leaf *more = realloc(a->leaf, room*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        a->leaf = more;
        a->room = room;
    }
    lw_leaf *l = &a->leaf[a->n], *before = a->n ? l - 1 : NULL;
    *l = (lw_leaf){ .id = v[0].integer, .links = (int)v[1].integer, .dof = (int)v[2].integer,
                    .joints = (int)v[3].integer, .loops = (int)v[4].integer, .symmetry = v[5].integer,
                    .grounds = (int)v[6].integer, .planar = (int)v[7].integer };
    l->number = before && before->links == l->links && before->dof == l->dof ? before->number + 1 : 1;
    if (!copy_texts(l, v + 8))
        return LW_E_MEMORY;
    a->n++;
    return LW_OK;
}

static lw_status read_leaves(lw_atlas_html *a, lw_error *e)
{
    const lw_notation *graph6 = lw_notation_find("graph6");
    lw_status s = ask_chains(a->store, a->options, chain_sql, add_leaf, a, e);
    for (size_t i = a->n; i-- > 0;) {
        bool last = i + 1 == a->n || a->leaf[i + 1].number == 1;
        a->leaf[i].of = last ? a->leaf[i].number : a->leaf[i + 1].of;
    }
    for (size_t i = 0; s == LW_OK && i < a->n; i++) {
        const char *text = a->leaf[i].text[LW_LEAF_GRAPH6];
        s = graph6->read(text, strlen(text), "graph6 of a chain", &a->leaf[i].chain, e);
    }
    if (s == LW_OK && a->n == 0)
        s = lw_error_set(e, LW_NOTHING, "there is no chain in the catalogue to show: 'linkwright catalogue build' makes "
                         "them");
    return s;
}

/* Files of an older program have no table of linkages. */
static lw_status look_for_linkages(lw_atlas_html *a, lw_error *e)
{
    long long n = 0;
    lw_status s = lw_store_number(a->store, "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'linkage'",
                                  NULL, 0, &n, e);
    a->has_linkages = n > 0;
    return s;
}

/* ---- writing ------------------------------------------------------------------------------------ */

static lw_status write_page(lw_atlas_html *a, const char *file, lw_bytes *b, lw_error *e)
{
    char path[4096];
    lw_status s = lw_bytes_end(b, e);
    int n = snprintf(path, sizeof path, "%s/%s", a->dir, file);
    if (s == LW_OK && (n < 0 || (size_t)n >= sizeof path))
        s = lw_error_set(e, LW_E_ARG, "the name of the folder is too long");
    if (s == LW_OK)
        s = lw_file_write(path, b->data, b->size, e);
    if (s == LW_OK) {
        a->n_page++;
        a->n_byte += b->size;
    }
    lw_bytes_free(b);
    return s;
}

static lw_status write_linkages(lw_atlas_html *a, lw_leaf *l, lw_error *e)
{
    char file[LW_LEAF_FILE] = "linkages-other.html";
    lw_bytes b = { 0 };
    int n = 0;
    if (l)
        lw_leaf_file(l, "linkages", file);
    lw_status s = a->has_linkages ? lw_atlas_linkage_page(a, l, &b, &n, e) : LW_OK;
    if (l)
        l->n_linkage = n;
    else
        a->n_other = n;
    if (s == LW_OK && n > 0)
        return write_page(a, file, &b, e);
    lw_bytes_free(&b);
    return s;
}

static lw_status write_chain(lw_atlas_html *a, size_t i, lw_error *e)
{
    char file[LW_LEAF_FILE];
    lw_bytes b = { 0 };
    lw_leaf *l = &a->leaf[i];
    if (l->status != LW_OK)
        return lw_error_set(e, l->status, "chain %s cannot be drawn", l->text[LW_LEAF_GRAPH6]);
    lw_status s = write_linkages(a, l, e);
    if (s == LW_OK)
        s = lw_atlas_chain_page(a, i, &b, e);
    if (s != LW_OK) {
        lw_bytes_free(&b);
        return s;
    }
    lw_leaf_file(l, "chain", file);
    return write_page(a, file, &b, e);
}

/* ---- pictures ----------------------------------------------------------------------------------- */

static lw_status add_ground(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    lw_leaf *l = context;
    if (l->n_ground < LW_LINK_MAX && v[0].integer >= 1 && v[0].integer <= l->chain.n_link) {
        l->ground[l->n_ground] = (int)v[0].integer;
        l->alike[l->n_ground++] = (int)v[1].integer;
    }
    return LW_OK;
}

static void place_joints(void *context, size_t job, int thread)
{
    (void)thread;
    lw_leaf *l = (lw_leaf *)context + job;
    lw_mechanism m = l->chain;
    l->status = lw_chain_layout_make(&m, &l->layout, NULL);
    for (int i = 0; l->status == LW_OK && i < l->n_ground; i++) {
        m.ground = l->ground[i] - 1;
        l->status = lw_chain_layout_make(&m, &l->grounded[i], NULL);
    }
}

/* Ground links and places of joints of n chains from `first` on. */
static lw_status prepare_block(lw_atlas_html *a, size_t first, size_t n, lw_error *e)
{
    lw_status s = LW_OK;
    for (size_t i = first; s == LW_OK && i < first + n; i++) {
        lw_leaf *l = &a->leaf[i];
        const lw_value chain = lw_value_of_integer(l->id);
        s = lw_atlas_ask(a, "SELECT link, alike FROM ground WHERE chain = ?1 ORDER BY link", &chain, add_ground, l, e);
        l->grounded = malloc((size_t)(l->n_ground + 1)*sizeof *l->grounded);
        if (s == LW_OK && !l->grounded)
            s = lw_error_set(e, LW_E_MEMORY, "out of memory for pictures");
    }
    return s == LW_OK ? lw_parallel(a->options->jobs, n, place_joints, a->leaf + first) : s;
}

static lw_status write_block(lw_atlas_html *a, size_t first, size_t n, lw_error *e)
{
    const lw_atlas_html_options *o = a->options;
    lw_status s = prepare_block(a, first, n, e);
    for (size_t i = first; s == LW_OK && i < first + n; i++) {
        s = write_chain(a, i, e);
        if (s == LW_OK && o->goes_on && !o->goes_on(o->context, (double)(i + 1), (double)a->n))
            s = lw_error_set(e, LW_STOPPED, "stopped before the overview was written");
    }
    for (size_t i = first; i < first + n; i++) {
        free(a->leaf[i].grounded);
        a->leaf[i].grounded = NULL;
    }
    return s;
}

static lw_status write_all(lw_atlas_html *a, lw_error *e)
{
    lw_status s = LW_OK;
    lw_bytes b = { 0 };
    if (mkdir(a->dir, 0777) != 0 && errno != EEXIST)
        return lw_error_at(e, LW_E_IO, a->dir, 0, 0, "the folder cannot be made: %s", strerror(errno));
    for (size_t i = 0; s == LW_OK && i < a->n; i += BLOCK)
        s = write_block(a, i, a->n - i < BLOCK ? a->n - i : BLOCK, e);
    if (s == LW_OK)
        s = write_linkages(a, NULL, e);
    if (s != LW_OK)
        return s;
    lw_atlas_index_page(a, &b);
    return write_page(a, "index.html", &b, e);
}

lw_status lw_atlas_html_write(lw_store *store, const char *dir, const lw_atlas_html_options *o, size_t *n_page,
                              size_t *n_byte, lw_error *e)
{
    lw_atlas_html a = { .store = store, .dir = dir, .options = o };
    lw_page_style(&a.style, lw_page_css, lw_atlas_html_css);
    lw_page_script(&a.chain_script, lw_atlas_html_chain_js);
    lw_page_script(&a.index_script, lw_atlas_html_js);
    lw_status s = a.style.failed || a.chain_script.failed || a.index_script.failed
                ? lw_error_set(e, LW_E_MEMORY, "out of memory") : look_for_linkages(&a, e);
    if (s == LW_OK)
        s = read_leaves(&a, e);
    if (s == LW_OK)
        s = write_all(&a, e);
    for (size_t i = 0; i < a.n; i++)
        free(a.leaf[i].text[0]);
    free(a.leaf);
    lw_bytes_free(&a.style);
    lw_bytes_free(&a.chain_script);
    lw_bytes_free(&a.index_script);
    *n_page = a.n_page;
    *n_byte = a.n_byte;
    return s;
}

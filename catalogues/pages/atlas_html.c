/* catalogues/pages/atlas_html.c - the chains of a catalogue -> the pages of an atlas, or blocks of chains in the place of pages for large
 * families. */
#include "catalogues/pages/atlas_internal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/parallel.h"
#include "catalogues/pages/page_files.h"             /* made from *.css and *.js by the Makefile */
#include "catalogues/pages/page_head.h"
#include "grammar/topology/multiple.h"
#include "grammar/topology/notation.h"

#define PAGE_BYTES    8000.0   /* size of a chain's page ...                         */
#define PICTURE_BYTES 6600.0   /* ... and of each picture of a ground link, measured */
#define BLOCK_BYTES    1500.0  /* the same in blocks; with a few inputs for each ground link */
#define GROUND_BYTES   420.0

lw_atlas_html_options lw_atlas_html_options_default(void)
{
    return (lw_atlas_html_options){ .title = "Atlas of mechanisms", .n_linkage = 12, .single_pages = 1000 };
}

/* ---- reading ------------------------------------------------------------------------------------ */

static const char chain_sql[] =
    "SELECT c.id, c.links, c.dof, c.joints, c.loops, c.symmetry, c.grounds, c.planar, c.label, c.graph6,"
    " c.assortment, c.franke, c.sentence, c.matrix, s.form, s.derivation"
    " FROM chain c LEFT JOIN structure s ON s.id = c.structure WHERE ?1 = 0 OR c.links = ?1 ORDER BY c.dof, c.links, c.id LIMIT ?2";
/* The ground links stand where chains have their graph6. */
static const char multiple_sql[] =
    "SELECT id, links, dof, joints, loops, symmetry, grounds, planar, pins, ground_links, assortment, '', '', '', '', ''"
    " FROM multiple WHERE ?1 = 0 OR links = ?1 ORDER BY dof, links, id LIMIT ?2";
static const char size_sql[] =
    "SELECT count(*), total(grounds) FROM (SELECT dof, links, grounds FROM chain WHERE ?1 = 0 OR links = ?1"
    " ORDER BY dof, links, id LIMIT ?2) GROUP BY dof, links";
static const char multiple_size_sql[] =
    "SELECT count(*), total(grounds) FROM (SELECT dof, links, grounds FROM multiple WHERE ?1 = 0 OR links = ?1"
    " ORDER BY dof, links, id LIMIT ?2) GROUP BY dof, links";

/* Ask the store about the chains that are shown: those with simple joints, then, if the file has them, those with multiple
 * joints.  *n: counts them; it is what `row` has counted when the first question is answered. */
static lw_status ask_chains(lw_store *store, const lw_atlas_html_options *o, const char *simple, const char *multiple,
                            lw_status (*row)(void *, int, const char *const *, const lw_value *), void *context,
                            const size_t *n, lw_error *e)
{
    lw_value v[] = { lw_html_integer_value(o->links), lw_html_integer_value(o->limit > 0 ? o->limit : -1) };
    lw_store_query q = { .sql = simple, .value = v, .n_value = 2, .row = row, .context = context };
    bool has = false;
    lw_status s = lw_store_ask(store, &q, e);
    if (s == LW_OK)
        s = lw_store_has_table(store, "multiple", &has, e);
    if (o->limit > 0)
        v[1].integer = o->limit - (long long)*n;
    q.sql = multiple;
    if (s == LW_OK && has && v[1].integer != 0)
        s = lw_store_ask(store, &q, e);
    return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory for the pages of the atlas") : s;
}

struct expected { long long single_pages; size_t n_chain; double n_byte; };

static lw_status take_size(void *context, int n, const char *const *name, const lw_value *v)
{
    struct expected *x = context;
    bool in_block = v[0].integer > x->single_pages;
    (void)n, (void)name;
    x->n_chain += (size_t)v[0].integer;
    x->n_byte += in_block ? BLOCK_BYTES*(double)v[0].integer + GROUND_BYTES*v[1].real
                          : PAGE_BYTES*(double)v[0].integer + PICTURE_BYTES*v[1].real;
    return LW_OK;
}

lw_status lw_atlas_html_expect(lw_store *store, const lw_atlas_html_options *o, size_t *n_chain, double *n_byte, lw_error *e)
{
    struct expected x = { .single_pages = o->single_pages };
    lw_status s = ask_chains(store, o, size_sql, multiple_size_sql, take_size, &x, &x.n_chain, e);
    *n_chain = x.n_chain;
    *n_byte = x.n_byte;
    return s;
}

static bool copy_texts(lw_html_leaf *l, const lw_value *v)
{
    size_t size = 0;
    for (int i = 0; i < LW_LEAF_TEXTS; i++)
        size += strlen(lw_html_text(&v[i])) + 1;
    char *block = malloc(size);
    for (int i = 0; block && i < LW_LEAF_TEXTS; i++) {
        l->text[i] = block;
        block += strlen(strcpy(block, lw_html_text(&v[i]))) + 1;
    }
    return block != NULL;
}

static lw_status add_leaf(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    lw_html_atlas *a = context;
    if (a->n == a->capacity) {
        size_t capacity = 2*a->capacity + 64;
        lw_html_leaf *more = realloc(a->leaf, capacity*sizeof *more);
        if (!more)
            return LW_E_MEMORY;
        a->leaf = more;
        a->capacity = capacity;
    }
    lw_html_leaf *l = &a->leaf[a->n], *before = a->n ? l - 1 : NULL;
    *l = (lw_html_leaf){ .id = v[0].integer, .links = (int)v[1].integer, .dof = (int)v[2].integer,
                    .joints = (int)v[3].integer, .loops = (int)v[4].integer, .symmetry = v[5].integer,
                    .grounds = (int)v[6].integer, .planar = (int)v[7].integer };
    l->multiple = strchr(lw_html_text(&v[8]), '-');              /* the links on a pin; graph6 has no '-' */
    l->number = before && before->links == l->links && before->dof == l->dof && before->multiple == l->multiple
              ? before->number + 1 : 1;
    if (!copy_texts(l, v + 8))
        return LW_E_MEMORY;
    a->n++;
    a->n_multiple += l->multiple;
    return LW_OK;
}

/* The chain of a leaf from its texts; of one with multiple joints its ground links, too: "1:2 3:1". */
static lw_status read_chain(lw_html_leaf *l, lw_error *e)
{
    const char *text = l->text[LW_LEAF_GRAPH6], *pins = l->text[LW_LEAF_LABEL];
    lw_multiple m;
    int used = 0;
    if (!l->multiple)
        return lw_notation_find("graph6")->read(text, strlen(text), "graph6 of a chain", &l->chain, e);
    for (; l->n_ground < LW_LINK_MAX && sscanf(text, "%d:%d%n", &l->ground[l->n_ground], &l->alike[l->n_ground], &used) == 2; text += used)
        if (l->ground[l->n_ground] >= 1 && l->ground[l->n_ground] <= l->links)
            l->n_ground++;
    lw_status s = lw_multiple_read(pins, strlen(pins), "pins of a chain", &m, e);
    return s == LW_OK ? lw_multiple_mechanism(&m, &l->chain, &l->axes) : s;
}

static lw_status read_leaves(lw_html_atlas *a, lw_error *e)
{
    lw_status s = ask_chains(a->store, a->options, chain_sql, multiple_sql, add_leaf, a, &a->n, e);
    for (size_t i = a->n; i-- > 0;) {
        bool last = i + 1 == a->n || a->leaf[i + 1].number == 1;
        a->leaf[i].of = last ? a->leaf[i].number : a->leaf[i + 1].of;
        a->leaf[i].in_block = a->leaf[i].of > a->options->single_pages;
        a->has_blocks = a->has_blocks || a->leaf[i].in_block;
    }
    for (size_t i = 0; s == LW_OK && i < a->n; i++)
        s = read_chain(&a->leaf[i], e);
    if (s == LW_OK && a->n == 0)
        s = lw_error_set(e, LW_NOTHING, "there is no chain in the catalogue to show: 'linkwright catalogue build' makes them");
    return s;
}

/* ---- writing ------------------------------------------------------------------------------------ */

static lw_status write_page(lw_html_atlas *a, const char *file, lw_bytes *b, lw_error *e)
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

static lw_status write_linkages(lw_html_atlas *a, lw_html_leaf *l, lw_error *e)
{
    char file[LW_LEAF_FILE] = "linkages-other.html";
    lw_bytes b = { 0 };
    int n = 0;
    if (l)
        lw_html_page_file(l, "linkages", file);
    lw_status s = a->has_linkages ? lw_html_linkage_page(a, l, &b, &n, e) : LW_OK;
    if (l)
        l->n_linkage = n;
    else
        a->n_other = n;
    if (s == LW_OK && n > 0)
        return write_page(a, file, &b, e);
    lw_bytes_free(&b);
    return s;
}

static lw_status write_chain(lw_html_atlas *a, size_t i, lw_error *e)
{
    char file[LW_LEAF_FILE];
    lw_bytes b = { 0 };
    lw_html_leaf *l = &a->leaf[i];
    if (l->status != LW_OK)
        return lw_error_set(e, l->status, "chain %s cannot be drawn", l->text[LW_LEAF_GRAPH6]);
    lw_status s = l->multiple ? LW_OK : write_linkages(a, l, e);
    if (s == LW_OK && l->in_block)
        return LW_OK;
    if (s == LW_OK && !l->multiple)
        s = lw_html_slider_page(a, l, &b, &l->n_slider, e);
    lw_html_page_file(l, "sliders", file);
    if (s == LW_OK && l->n_slider > 0)
        s = write_page(a, file, &b, e);
    if (s == LW_OK)
        s = lw_html_chain_page(a, i, &b, e);
    if (s != LW_OK) {
        lw_bytes_free(&b);
        return s;
    }
    lw_html_page_file(l, "chain", file);
    return write_page(a, file, &b, e);
}

/* ---- pictures ----------------------------------------------------------------------------------- */

static lw_status add_ground(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    lw_html_leaf *l = context;
    if (l->n_ground < LW_LINK_MAX && v[0].integer >= 1 && v[0].integer <= l->chain.n_link) {
        l->ground[l->n_ground] = (int)v[0].integer;
        l->alike[l->n_ground++] = (int)v[1].integer;
    }
    return LW_OK;
}

static void place_joints(void *context, size_t job, int thread)
{
    (void)thread;
    lw_html_leaf *l = (lw_html_leaf *)context + job;
    lw_mechanism m = l->chain;
    l->status = lw_axes_layout_make(&m, l->axes, &l->layout, NULL);
    for (int i = 0; l->status == LW_OK && i < l->n_ground; i++) {
        m.ground = l->ground[i] - 1;
        l->status = lw_axes_layout_make(&m, l->axes, &l->grounded[i], NULL);
    }
}

/* Compute ground links and layouts of n chains from `first` on. */
static lw_status prepare_block(lw_html_atlas *a, size_t first, size_t n, lw_error *e)
{
    lw_status s = LW_OK;
    for (size_t i = first; s == LW_OK && i < first + n; i++) {
        lw_html_leaf *l = &a->leaf[i];
        const lw_value chain = lw_html_integer_value(l->id);
        if (!l->multiple)
            s = lw_html_ask(a, "SELECT link, alike FROM ground WHERE chain = ?1 ORDER BY link", &chain, add_ground, l, e);
        l->grounded = malloc((size_t)(l->n_ground + 1)*sizeof *l->grounded);
        if (s == LW_OK && !l->grounded)
            s = lw_error_set(e, LW_E_MEMORY, "out of memory for pictures");
    }
    return s == LW_OK ? lw_parallel(a->options->jobs, n, place_joints, a->leaf + first) : s;
}

/* Chains first .. first + n - 1, which are all of one family, as a script that hands them to atlasBlocks. */
static lw_status write_script(lw_html_atlas *a, size_t first, size_t n, lw_error *e)
{
    char file[LW_LEAF_FILE], text[96];
    const lw_html_leaf *l = &a->leaf[first];
    lw_status s = LW_OK;
    lw_bytes b = { 0 };
    snprintf(file, sizeof file, "chains-%d-%d-%s%d.js", l->links, l->dof, l->multiple ? "m" : "", (l->number - 1)/LW_LEAF_BLOCK);
    snprintf(text, sizeof text, "\"use strict\";\natlasBlocks.take(\"%d-%d-%s%d\",%d,[\n", l->links, l->dof,
             l->multiple ? "m" : "", (l->number - 1)/LW_LEAF_BLOCK, l->of);
    lw_bytes_text(&b, text);
    for (size_t i = first; s == LW_OK && i < first + n; i++) {
        lw_bytes_text(&b, i > first ? ",\n" : "");
        s = lw_html_json_chain(a, &a->leaf[i], &b, e);
    }
    lw_bytes_text(&b, "]);\n");
    if (s == LW_OK)
        return write_page(a, file, &b, e);
    lw_bytes_free(&b);
    return s;
}

static lw_status write_block(lw_html_atlas *a, size_t first, size_t n, lw_error *e)
{
    const lw_atlas_html_options *o = a->options;
    lw_status s = prepare_block(a, first, n, e);
    for (size_t i = first; s == LW_OK && i < first + n; i++) {
        s = write_chain(a, i, e);
        if (s == LW_OK && o->goes_on && !o->goes_on(o->context, (double)(i + 1), (double)a->n))
            s = lw_error_set(e, LW_STOPPED, "stopped before the overview was written");
    }
    if (s == LW_OK && a->leaf[first].in_block)
        s = write_script(a, first, n, e);
    for (size_t i = first; i < first + n; i++) {
        free(a->leaf[i].grounded);
        a->leaf[i].grounded = NULL;
    }
    return s;
}

static lw_status write_all(lw_html_atlas *a, lw_error *e)
{
    lw_status s = LW_OK;
    lw_bytes b = { 0 };
    if (mkdir(a->dir, 0777) != 0 && errno != EEXIST)
        return lw_file_failed(e, "made", a->dir, errno);
    for (size_t i = 0, n; s == LW_OK && i < a->n; i += n) {
        for (n = 1; n < LW_LEAF_BLOCK && i + n < a->n && a->leaf[i + n].number > 1; n++)
            ;
        s = write_block(a, i, n, e);
    }
    if (s == LW_OK)
        s = write_linkages(a, NULL, e);
    if (s == LW_OK && a->has_blocks) {
        lw_html_block_page(a, &b);
        s = write_page(a, "chain.html", &b, e);
    }
    if (s != LW_OK)
        return s;
    lw_html_index_page(a, &b);
    return write_page(a, "index.html", &b, e);
}

lw_status lw_atlas_html_write(lw_store *store, const char *dir, const lw_atlas_html_options *o, size_t *n_page, size_t *n_byte, lw_error *e)
{
    lw_html_atlas a = { .store = store, .dir = dir, .options = o };
    lw_page_style(&a.style, lw_page_css, lw_atlas_html_css);
    lw_page_script(&a.chain_script, lw_atlas_html_chain_js);
    lw_page_script(&a.index_script, lw_atlas_find_js);
    lw_page_script(&a.index_script, lw_atlas_sketch_js);
    lw_page_script(&a.index_script, lw_atlas_block_js);
    lw_page_script(&a.block_script, lw_atlas_block_js);
    lw_page_script(&a.block_script, lw_atlas_block_page_js);
    lw_page_script(&a.block_script, lw_atlas_html_chain_js);
    lw_page_script(&a.index_script, lw_atlas_html_js);
    lw_status s = a.style.failed || a.chain_script.failed || a.index_script.failed || a.block_script.failed
                ? lw_error_set(e, LW_E_MEMORY, "out of memory") : lw_store_has_table(store, "linkage", &a.has_linkages, e);
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
    lw_bytes_free(&a.block_script);
    *n_page = a.n_page;
    *n_byte = a.n_byte;
    return s;
}

/* catalogues/pages/atlas_html_chain.c - the page of a chain, and that of its linkages */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "catalogues/pages/atlas_html_internal.h"
#include "catalogues/draw/chain_drawing.h"
#include "catalogues/pages/page.h"
#include "catalogues/pages/page_internal.h"
#include "catalogues/draw/svg.h"
#include "grammar/edges.h"
#include "grammar/linkage.h"

#define ROWS_MAX 60            /* mechanisms listed for a ground link */

/* ---- pictures ----------------------------------------------------------------------------------- */

/* The chain with its n-th ground link (LW_NONE: without) as an <svg>. */
static lw_status picture(const lw_leaf *l, int n, lw_chain_style style, const char *title, lw_bytes *out, lw_error *e)
{
    lw_mechanism m = l->chain;
    lw_drawing d;
    m.ground = n == LW_NONE ? LW_NONE : l->ground[n] - 1;
    lw_status s = lw_chain_draw(&m, n == LW_NONE ? &l->layout : &l->grounded[n], &style, &d, e);
    if (s != LW_OK)
        return s;
    lw_text_clean(d.title, sizeof d.title, title);
    lw_svg_inline(&d, "", out);
    lw_drawing_free(&d);
    return LW_OK;
}

/* ---- head and properties ------------------------------------------------------------------------ */

static void step_link(lw_bytes *b, const lw_atlas_html *a, size_t i, bool there, const char *rel, const char *words)
{
    char file[LW_LEAF_FILE];
    if (!there)
        return;
    lw_leaf_file(&a->leaf[i], "chain", file);
    lw_bytes_text(b, "<li><a rel=\"");
    lw_bytes_text(b, rel);
    lw_page_text(b, "\" href=\"", file, "\">");
    lw_page_text(b, "", words, "</a></li>\n");
}

static void head(lw_bytes *b, const lw_atlas_html *a, size_t i)
{
    const lw_leaf *l = &a->leaf[i];
    char title[160], family[48], link[160];
    lw_leaf_family(l, family, sizeof family);
    snprintf(title, sizeof title, "Chain %d of %d: %s", l->number, l->of, family);
    lw_page_head(b, title, &a->style, &a->chain_script);
    lw_page_text(b, "<header>\n<nav aria-label=\"Atlas\"><ul>\n<li><a rel=\"up\" href=\"index.html\">",
                 a->options->title, "</a></li>\n");
    snprintf(link, sizeof link, "<li><a href=\"index.html#links=%d&amp;dof=%d\">", l->links, l->dof);
    lw_page_text(b, link, family, "</a></li>\n");
    lw_page_text(b, "<li><a href=\"index.html#assortment=", l->text[LW_LEAF_ASSORTMENT], "\">");
    lw_page_text(b, "assortment ", l->text[LW_LEAF_ASSORTMENT], "</a></li>\n");
    step_link(b, a, i - 1, i > 0, "prev", "Previous");
    step_link(b, a, i + 1, i + 1 < a->n, "next", "Next");
    lw_page_text(b, "</ul></nav>\n<h1>", title, "</h1>\n</header>\n");
}

static void row_text(lw_bytes *b, const char *name, const char *text)
{
    if (!text[0])
        return;
    lw_page_text(b, "<tr><th scope=\"row\">", name, "</th><td>");
    lw_page_text(b, "", text, "</td></tr>\n");
}

static void row_number(lw_bytes *b, const char *name, long long n)
{
    char text[32];
    snprintf(text, sizeof text, "%lld", n);
    row_text(b, name, text);
}

static void properties(lw_bytes *b, const lw_leaf *l)
{
    char text[96];
    lw_bytes_text(b, "<table class=\"facts\">\n");
    row_number(b, "Links", l->links);
    row_number(b, "Joints", l->joints);
    row_number(b, "Degree of freedom", l->dof);
    row_number(b, "Independent loops", l->loops);
    row_text(b, "Links of 2, 3, \xe2\x80\xa6 joints", l->text[LW_LEAF_ASSORTMENT]);
    row_text(b, "Structure", l->text[LW_LEAF_FORM]);
    row_text(b, "Derivation", l->text[LW_LEAF_DERIVATION]);
    row_number(b, "Symmetries", l->symmetry);
    row_number(b, "Ground links", l->grounds);
    snprintf(text, sizeof text, l->layout.n_cross == 1 ? "not planar: drawn with %d crossing"
                                                       : "not planar: drawn with %d crossings", l->layout.n_cross);
    row_text(b, "Graph", l->planar ? "planar" : text);
    lw_bytes_text(b, "</table>\n");
}

/* ---- notations ---------------------------------------------------------------------------------- */

static void notation(lw_bytes *b, const char *name, const char *text)
{
    if (!text[0])
        return;
    lw_page_text(b, "<div class=\"notation\"><h3>", name, "</h3><button type=\"button\" class=\"copy\" hidden>Copy"
                 "<span class=\"unseen\"> ");
    lw_page_text(b, "", name, "</span></button>\n<pre tabindex=\"0\"><code>");
    lw_page_text(b, "", text, "</code></pre></div>\n");
}

static void notations(lw_bytes *b, const lw_leaf *l)
{
    char edges[LW_EDGES_SIZE];
    lw_edges_print(&l->chain, edges, sizeof edges);
    lw_bytes_text(b, "<h2 id=\"notations\">Notations</h2>\n<p class=\"hint\" role=\"status\" id=\"said\"></p>\n"
                     "<div class=\"notations\">\n");
    notation(b, "graph6", l->text[LW_LEAF_GRAPH6]);
    notation(b, "canonical label", l->text[LW_LEAF_LABEL]);
    notation(b, "joints", edges);
    notation(b, "Franke", l->text[LW_LEAF_FRANKE]);
    notation(b, "sentence", l->text[LW_LEAF_SENTENCE]);
    notation(b, "link adjacency matrix", l->text[LW_LEAF_MATRIX]);
    lw_bytes_text(b, "</div>\n");
}

/* ---- ground links ------------------------------------------------------------------------------- */

typedef struct rows { lw_bytes *out; int n; } rows;

static lw_status write_mechanism(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    rows *r = context;
    char text[96];
    bool known = v[3].kind == LW_VALUE_INTEGER && v[3].integer > 0;
    if (r->n++ == 0)
        lw_bytes_text(r->out, "<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr><th scope=\"col\">Joints</th>"
                      "<th scope=\"col\">Input</th><th scope=\"col\">Assur groups</th><th scope=\"col\">Modes</th></tr>"
                      "</thead>\n<tbody>\n");
    if (r->n > ROWS_MAX)
        return LW_OK;
    snprintf(text, sizeof text, "%lld", v[3].integer);
    lw_page_text(r->out, "<tr><td data-label=\"Joints\">", lw_value_text(&v[0]), "</td>");
    lw_page_text(r->out, "<td data-label=\"Input\">", lw_value_text(&v[1]), "</td>");
    lw_page_text(r->out, "<td data-label=\"Assur groups\">", lw_value_text(&v[2]), "</td>");
    lw_page_text(r->out, "<td data-label=\"Modes\">", known ? text : "", "</td></tr>\n");
    return LW_OK;
}

static lw_status mechanisms(lw_atlas_html *a, const lw_leaf *l, int link, lw_bytes *b, lw_error *e)
{
    char sql[256], text[96];
    rows r = { .out = b };
    const lw_value chain = lw_value_of_integer(l->id);
    snprintf(sql, sizeof sql, "SELECT kinds, inputs, assur, modes FROM mechanism WHERE chain = ?1 AND ground = %d "
             "ORDER BY sliders, kinds, id", link);
    lw_status s = lw_atlas_ask(a, sql, &chain, write_mechanism, &r, e);
    if (r.n > 0)
        lw_bytes_text(b, "</tbody></table></div>\n");
    if (r.n > ROWS_MAX) {
        snprintf(text, sizeof text, "and %d more in the catalogue", r.n - ROWS_MAX);
        lw_page_text(b, "<p class=\"hint\">", text, "</p>\n");
    }
    return s;
}

static lw_status inversions(lw_atlas_html *a, const lw_leaf *l, lw_bytes *b, lw_error *e)
{
    char text[96];
    lw_status s = LW_OK;
    lw_bytes_text(b, "<h2 id=\"inversions\">Ground links</h2>\n<div class=\"inversions\">\n");
    for (int i = 0; s == LW_OK && i < l->n_ground; i++) {
        snprintf(text, sizeof text, l->alike[i] > 1 ? "Ground link %d, one of %d alike" : "Ground link %d", l->ground[i],
                 l->alike[i]);
        lw_page_text(b, "<article>\n<h3>", text, "</h3>\n<figure>");
        s = picture(l, i, (lw_chain_style){ .width = 240, .height = 180 }, text, b, e);
        lw_bytes_text(b, "</figure>\n");
        if (s == LW_OK)
            s = mechanisms(a, l, l->ground[i], b, e);
        lw_bytes_text(b, "</article>\n");
    }
    lw_bytes_text(b, "</div>\n");
    return s;
}

lw_status lw_atlas_chain_page(lw_atlas_html *a, size_t i, lw_bytes *b, lw_error *e)
{
    const lw_leaf *l = &a->leaf[i];
    char file[LW_LEAF_FILE], text[96];
    head(b, a, i);
    lw_bytes_text(b, "<main>\n<div class=\"first\">\n<figure>");
    const lw_chain_style large = { .width = 480, .height = 360, .numbers = true };
    lw_status s = picture(l, LW_NONE, large, "The chain, its links numbered", b, e);
    if (s != LW_OK)
        return s;
    lw_bytes_text(b, "</figure>\n");
    properties(b, l);
    lw_bytes_text(b, "</div>\n");
    if (l->n_linkage > 0) {
        lw_leaf_file(l, "linkages", file);
        snprintf(text, sizeof text, l->n_linkage == 1 ? "%lld linkage, moving" : "%lld linkages, moving", l->n_linkage);
        lw_page_text(b, "<p class=\"linkages\"><a href=\"", file, "\">");
        lw_page_text(b, "", text, "</a></p>\n");
    }
    notations(b, l);
    s = inversions(a, l, b, e);
    lw_bytes_text(b, "</main>\n<script>");
    lw_bytes_text(b, a->chain_script.data);
    lw_bytes_text(b, "</script>\n</body>\n</html>\n");
    return s;
}

/* ---- linkages ----------------------------------------------------------------------------------- */

typedef struct found {
    int              n, room;
    lw_scene        *scene;                    /* (room) */
    lw_page_result  *result;
    char           (*text)[2][64];             /* type and class */
    lw_linkage      *linkage;                  /* scratch */
    lw_error        *e;
} found;

static lw_status read_linkage(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    found *f = context;
    if (f->n == f->room)
        return LW_OK;
    lw_scene *s = &f->scene[f->n];
    const char *json = lw_value_text(&v[4]);
    lw_status st = lw_linkage_read(json, strlen(json), "linkage of the catalogue", f->linkage, f->e);
    if (st == LW_OK)
        st = lw_scene_make(f->linkage, NULL, NULL, s, f->e);
    if (st != LW_OK) {
        lw_scene_free(s);
        return st;
    }
    lw_text_clean(f->text[f->n][0], sizeof f->text[0][0], lw_value_text(&v[1]));
    lw_text_clean(f->text[f->n][1], sizeof f->text[0][1], lw_value_text(&v[2]));
    const char *type = f->text[f->n][0], *class_name = f->text[f->n][1];
    f->result[f->n] = (lw_page_result){
        .scene = s, .type = type[0] ? type : s->title, .class_name = class_name[0] ? class_name : NULL,
        .note = s->note[0] ? s->note : NULL, .objective = NAN, .error_max = NAN, .error_percent = NAN,
        .error_mean = v[3].kind == LW_VALUE_NULL ? NAN : v[3].real,
    };
    f->n++;
    return LW_OK;
}

/* Best first; those whose chain is in the atlas stand with it. */
#define LINKAGE_COLUMNS "SELECT name, type, class, error_mean, json FROM linkage WHERE "
#define LINKAGE_ORDER   " ORDER BY error_mean IS NULL, error_mean, id"

static lw_status read_linkages(lw_atlas_html *a, const lw_leaf *l, found *f, lw_error *e)
{
    static const char of_chain[] = LINKAGE_COLUMNS "label = ?1" LINKAGE_ORDER;
    static const char of_others[] = LINKAGE_COLUMNS "label IS NULL OR label NOT IN (SELECT label FROM chain"
                                    " WHERE ?1 = 0 OR links = ?1)" LINKAGE_ORDER;
    lw_value value = l ? lw_value_of_text(l->text[LW_LEAF_LABEL]) : lw_value_of_integer(a->options->links);
    return lw_atlas_ask(a, l ? of_chain : of_others, &value, read_linkage, f, e);
}

static lw_status write_linkage_page(const lw_leaf *l, const found *f, lw_bytes *out, lw_error *e)
{
    char title[160], family[48], file[LW_LEAF_FILE] = "index.html";
    if (l) {
        lw_leaf_family(l, family, sizeof family);
        snprintf(title, sizeof title, "Linkages of chain %d with %s", l->number, family);
        lw_leaf_file(l, "chain", file);
    }
    lw_page_target t = { .name = l ? title : "Linkages of other chains", .n_result = f->n, .result = f->result };
    lw_page p = { .title = t.name, .home = file, .home_title = l ? "The chain" : "Atlas", .n_target = 1, .target = &t };
    return lw_page_write(&p, out, e);
}

lw_status lw_atlas_linkage_page(lw_atlas_html *a, const lw_leaf *l, lw_bytes *out, int *n, lw_error *e)
{
    size_t room = (size_t)(a->options->n_linkage > 0 ? a->options->n_linkage : 0) + 1;
    found f = { .room = (int)room - 1, .e = e };
    f.scene = calloc(room, sizeof *f.scene);
    f.result = calloc(room, sizeof *f.result);
    f.text = calloc(room, sizeof *f.text);
    f.linkage = malloc(sizeof *f.linkage);
    lw_status s = f.scene && f.result && f.text && f.linkage ? read_linkages(a, l, &f, e)
                : lw_error_set(e, LW_E_MEMORY, "out of memory for %zu linkages", room);
    if (s == LW_OK && f.n > 0)
        s = write_linkage_page(l, &f, out, e);
    *n = s == LW_OK ? f.n : 0;
    for (int i = 0; f.scene && i < f.n; i++)
        lw_scene_free(&f.scene[i]);
    free(f.scene);
    free(f.result);
    free(f.text);
    free(f.linkage);
    return s;
}

/* catalogues/pages/atlas_pages.c - the text of each page of an atlas: the overview, a chain with its ground links, its mechanisms with
 * sliders, its linkages; a chain of a block. */
#include "catalogues/pages/atlas_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/draw/svg.h"
#include "catalogues/pages/page.h"
#include "catalogues/pages/page_head.h"
#include "grammar/linkage/assembly.h"
#include "grammar/topology/edges.h"
#include "grammar/topology/notation.h"

void lw_html_page_file(const lw_html_leaf *l, const char *kind, char file[LW_LEAF_FILE])
{
    bool in_block = l->in_block && strcmp(kind, "chain") == 0;
    snprintf(file, LW_LEAF_FILE, in_block ? "%s.html#%d-%d-%s%d" : "%s-%d-%d-%s%d.html", kind, l->links, l->dof,
             l->multiple ? "m" : "", l->number);
}

static void lw_html_family_name(const lw_html_leaf *l, char *out, size_t size)
{
    snprintf(out, size, "%d links, F = %d%s", l->links, l->dof, l->multiple ? ", multiple joints" : "");
}

static lw_value lw_html_text_value(const char *text)
{
    return (lw_value){ .kind = LW_VALUE_TEXT, .text = text, .size = strlen(text) };
}

lw_status lw_html_ask(lw_html_atlas *a, const char *sql, const lw_value *value,
                       lw_status (*row)(void *, int, const char *const *, const lw_value *), void *context,
                       lw_error *e)
{
    lw_store_query q = { .sql = sql, .value = value, .n_value = value ? 1 : 0, .row = row, .context = context };
    lw_status s = lw_store_ask(a->store, &q, e);
    return s == LW_E_MEMORY ? lw_error_set(e, s, "out of memory for the pages of the atlas") : s;
}

/* ==== overview ================================================================================================ */

#define ASSORTMENTS_MAX 64     /* for one number of links and freedoms; 14 links have 42 */


typedef struct family {
    size_t first, n;
    int    n_assortment, n_planar;
    long long n_ground, n_linkage;
    const char *assortment[ASSORTMENTS_MAX];
    int    n_with[ASSORTMENTS_MAX];
} family;

static void count_assortment(family *f, const char *text)
{
    int i = 0;
    while (i < f->n_assortment && strcmp(f->assortment[i], text) != 0)
        i++;
    if (i == ASSORTMENTS_MAX)
        return;
    if (i == f->n_assortment) {
        f->assortment[f->n_assortment++] = text;
        f->n_with[i] = 0;
    }
    f->n_with[i]++;
}

/* The chains from `first` on that have its number of links and freedoms, and multiple joints or not, as it has. */
static family family_from(const lw_html_atlas *a, size_t first)
{
    family f = { .first = first };
    while (first + f.n < a->n && (f.n == 0 || a->leaf[first + f.n].number > 1)) {
        const lw_html_leaf *l = &a->leaf[first + f.n++];
        count_assortment(&f, l->text[LW_LEAF_ASSORTMENT]);
        f.n_planar += l->planar != 0;
        f.n_ground += l->grounds;
        f.n_linkage += l->n_linkage;
    }
    return f;
}

static void cell_number(lw_bytes *b, const char *label, long long n)
{
    lw_page_text(b, "<td class=\"number\" data-label=\"", label, "\">");
    lw_bytes_integer(b, (long)n);
    lw_bytes_text(b, "</td>");
}

/* The part of an address that chooses chains with or without multiple joints; "" if the atlas has no such chains. */
static const char *joints_filter(const lw_html_atlas *a, const lw_html_leaf *l)
{
    return a->n_multiple == 0 ? "" : l->multiple ? "&amp;joints=multiple" : "&amp;joints=simple";
}

static void write_family(lw_bytes *b, const lw_html_atlas *a, const family *f)
{
    const lw_html_leaf *l = &a->leaf[f->first];
    char text[128], link[160];
    snprintf(link, sizeof link, "#links=%d&amp;dof=%d%s", l->links, l->dof, joints_filter(a, l));
    lw_bytes_text(b, "<tr><th scope=\"row\"><a href=\"");
    lw_bytes_text(b, link);
    lw_html_family_name(l, text, sizeof text);
    lw_page_text(b, "\">", text, "</a></th>");
    cell_number(b, "Chains", (long long)f->n);
    cell_number(b, "Planar", f->n_planar);
    cell_number(b, "Ground links", f->n_ground);
    if (a->has_linkages)
        cell_number(b, "Linkages shown", f->n_linkage);
    lw_bytes_text(b, "<td class=\"assortments\" data-label=\"Assortments\">");
    for (int i = 0; i < f->n_assortment; i++) {
        lw_bytes_text(b, "<a href=\"");
        lw_bytes_text(b, link);
        lw_page_text(b, "&amp;assortment=", f->assortment[i], "\">");
        snprintf(text, sizeof text, " <span>(%d)</span></a> ", f->n_with[i]);
        lw_page_text(b, "", f->assortment[i], text);
    }
    lw_bytes_text(b, "</td></tr>\n");
}

static void overview(lw_bytes *b, const lw_html_atlas *a)
{
    char text[96];
    lw_bytes_text(b, "<h2>Overview</h2>\n<div class=\"scroll\" tabindex=\"0\"><table>\n"
                     "<caption>Assortments count links of 2, 3, 4, \xe2\x80\xa6 joints.</caption>\n"
                     "<thead><tr><th scope=\"col\">Family</th>"
                     "<th scope=\"col\" class=\"number\">Chains</th><th scope=\"col\" class=\"number\">Planar</th>"
                     "<th scope=\"col\" class=\"number\">Ground links</th>");
    if (a->has_linkages)
        lw_bytes_text(b, "<th scope=\"col\" class=\"number\">Linkages shown</th>");
    lw_bytes_text(b, "<th scope=\"col\">Assortments</th></tr></thead>\n<tbody>\n");
    for (size_t i = 0; i < a->n;) {
        family f = family_from(a, i);
        write_family(b, a, &f);
        i += f.n;
    }
    lw_bytes_text(b, "</tbody></table></div>\n");
    if (a->n_other > 0) {
        snprintf(text, sizeof text, a->n_other == 1 ? "%lld linkage of another chain" : "%lld linkages of other chains", a->n_other);
        lw_page_text(b, "<p class=\"linkages\"><a href=\"linkages-other.html\">", text, "</a></p>\n");
    }
}

/* ---- search ------------------------------------------------------------------------------------- */

static void controls(lw_bytes *b)
{
    lw_bytes_text(b,
        "<h2 id=\"chains\">Chains</h2>\n<div class=\"filter\" role=\"search\" hidden>\n"
        "<label class=\"wide\">Search <textarea id=\"q\" rows=\"1\" autocomplete=\"off\" spellcheck=\"false\""
        " placeholder=\"10 links planar, Watt, Jansen, or a chain in any notation\"></textarea></label>\n"
        "<label>Links <select id=\"links\"><option value=\"\">all</option></select></label>\n"
        "<label>Freedom <select id=\"dof\"><option value=\"\">all</option></select></label>\n"
        "<label>Assortment <select id=\"assortment\"><option value=\"\">all</option></select></label>\n"
        "<label>Graph <select id=\"planar\"><option value=\"\">all</option><option value=\"1\">planar</option>"
        "<option value=\"0\">not planar</option></select></label>\n"
        "<label>Joints <select id=\"joints\"><option value=\"\">all</option><option value=\"simple\">simple</option>"
        "<option value=\"multiple\">multiple</option></select></label>\n"
        "<label>Order <select id=\"order\"><option value=\"\">by number</option><option value=\"symmetry\">most symmetric first</option>"
        "<option value=\"grounds\">fewest ground links first</option></select></label>\n"
        "<label class=\"check\"><input type=\"checkbox\" id=\"linkages\"> with linkages</label>\n"
        "<button type=\"button\" id=\"clear\">Clear</button>\n</div>\n"
        "<details class=\"sketch\" hidden><summary>Sketch a chain</summary>\n"
        "<p class=\"hint\">Draw bars from pin to pin, the frame too. A triangle of bars is one link with three pins.</p>\n"
        "<svg id=\"sheet\" viewBox=\"0 0 640 360\" role=\"application\" aria-label=\"Sheet to sketch a chain\"></svg>\n"
        "<button type=\"button\" id=\"undo\">Undo</button> <button type=\"button\" id=\"wipe\">Clear sketch</button>\n"
        "<p id=\"sketched\" role=\"status\"></p>\n</details>\n"
        "<p id=\"found\" role=\"status\"></p>\n<p id=\"count\" class=\"hint\" role=\"status\"></p>\n<ul id=\"cards\" class=\"cards\"></ul>\n"
        "<button type=\"button\" id=\"more\" hidden>Show more</button>\n"
        "<p class=\"hint keys\" hidden>Keys: / search, arrows from picture to picture, Enter opens.</p>\n");
}

static void plain_list(lw_bytes *b, const lw_html_atlas *a)
{
    char file[LW_LEAF_FILE], name[96];
    lw_bytes_text(b, "<noscript>\n<ul class=\"plain\">\n");
    for (size_t i = 0; i < a->n; i++) {
        const lw_html_leaf *l = &a->leaf[i];
        if (l->in_block)
            continue;
        lw_html_page_file(l, "chain", file);
        snprintf(name, sizeof name, "%d links, F = %d, %s %d", l->links, l->dof,
                 l->multiple ? "multiple joints, chain" : "chain", l->number);
        lw_page_text(b, "<li><a href=\"", file, "\">");
        lw_page_text(b, "", name, "</a></li>\n");
    }
    lw_bytes_text(b, a->has_blocks ? "</ul>\n<p>Families of many chains need scripts.</p>\n</noscript>\n" : "</ul>\n</noscript>\n");
}

/* ---- data --------------------------------------------------------------------------------------- */

/* Write a JSON string that cannot end the HTML element around it. */
static void json_text(lw_bytes *b, const char *text)
{
    char code[8];
    lw_bytes_text(b, "\"");
    for (const char *c = text; *c; c++) {
        if ((unsigned char)*c < 0x20 || strchr("\"\\<>&", *c)) {
            snprintf(code, sizeof code, "\\u%04x", (unsigned char)*c);
            lw_bytes_text(b, code);
        } else {
            lw_bytes_add(b, c, 1);
        }
    }
    lw_bytes_text(b, "\"");
}

/* Places of pins in 1/100 of a bar (y down), then the pins of each link in order, as atlas_block.js reads them.  Joints
 * of an axis are one pin. */
static void json_layout(lw_bytes *b, const lw_chain_layout *layout, int n_link)
{
    int pin[LW_JOINT_MAX], n_pin = 0, same[LW_JOINT_MAX];
    for (int j = 0; j < layout->n_joint; j++)
        same[j] = j;
    for (int i = n_link; i < LW_LINK_MAX && layout->axes >> i & 1; i++)
        for (int k = layout->first[i]; k < layout->first[i + 1]; k++)
            same[layout->ring[k]] = layout->ring[layout->first[i]];
    for (int j = 0; j < layout->n_joint; j++) {
        if (same[j] != j)
            continue;
        pin[j] = n_pin++;
        lw_bytes_text(b, n_pin > 1 ? "," : "[");
        lw_bytes_integer(b, lround(100*layout->at[j].x));
        lw_page_number(b, -lround(100*layout->at[j].y));
    }
    for (int i = 0; i < n_link; i++) {
        lw_bytes_text(b, i ? "],[" : "],[[");
        for (int k = layout->first[i]; k < layout->first[i + 1]; k++) {
            lw_bytes_text(b, k > layout->first[i] ? "," : "");
            lw_bytes_integer(b, pin[same[layout->ring[k]]]);
        }
    }
    lw_bytes_text(b, "]]");
}

/* Write the data of a chain as atlas_html.js reads it: numbers, texts, and the picture unless it stands in a block. */
static void json_leaf(lw_bytes *b, const lw_html_leaf *l)
{
    const lw_html_text_of texts[] = { LW_LEAF_ASSORTMENT, l->multiple ? LW_LEAF_LABEL : LW_LEAF_GRAPH6, LW_LEAF_FORM };
    lw_bytes_text(b, "[");
    lw_bytes_integer(b, l->links);
    lw_page_number(b, l->dof);
    lw_page_number(b, l->number);
    lw_page_number(b, l->planar != 0);
    lw_page_number(b, (long)l->symmetry);
    lw_page_number(b, l->grounds);
    lw_page_number(b, (long)l->n_linkage);
    lw_page_number(b, l->n_slider);
    for (size_t i = 0; i < sizeof texts/sizeof *texts; i++) {
        lw_bytes_text(b, ",");
        json_text(b, l->text[texts[i]]);
    }
    if (!l->in_block) {
        lw_bytes_text(b, ",");
        json_layout(b, &l->layout, l->links);
    }
    lw_bytes_text(b, "]");
}

void lw_html_index_page(const lw_html_atlas *a, lw_bytes *b)
{
    char about[128];
    int n;
    lw_page_head(b, a->options->title, &a->style, &a->index_script, a->has_blocks);
    lw_page_text(b, "<header>\n<h1>", a->options->title, "</h1>\n");
    n = snprintf(about, sizeof about, a->n == 1 ? "%zu kinematic chain" : "%zu kinematic chains", a->n);
    if (a->n_multiple > 0)
        snprintf(about + n, sizeof about - (size_t)n, ", %zu of them with multiple joints", a->n_multiple);
    lw_page_text(b, "<p class=\"about\">", about, "</p>\n</header>\n<main>\n");
    controls(b);
    plain_list(b, a);
    overview(b, a);
    lw_bytes_text(b, "</main>\n<script type=\"application/json\" id=\"data\">[\n");
    for (size_t i = 0; i < a->n; i++) {
        lw_bytes_text(b, i ? ",\n" : "");
        json_leaf(b, &a->leaf[i]);
    }
    lw_bytes_text(b, "\n]</script>\n<script>");
    lw_bytes_text(b, a->index_script.data);
    lw_bytes_text(b, "</script>\n</body>\n</html>\n");
}

/* ==== pages of a chain ======================================================================================== */

#define ROWS_MAX 60            /* mechanisms listed for a ground link */

/* ---- pictures ----------------------------------------------------------------------------------- */

/* Write the chain with its n-th ground link (LW_NONE: without) as an <svg>. */
static lw_status picture(const lw_html_leaf *l, int n, lw_chain_style style, const char *title, lw_bytes *out, lw_error *e)
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

static void step_link(lw_bytes *b, const lw_html_atlas *a, size_t i, bool there, const char *rel, const char *words)
{
    char file[LW_LEAF_FILE];
    if (!there)
        return;
    lw_html_page_file(&a->leaf[i], "chain", file);
    lw_bytes_text(b, "<li><a rel=\"");
    lw_bytes_text(b, rel);
    lw_page_text(b, "\" href=\"", file, "\">");
    lw_page_text(b, "", words, "</a></li>\n");
}

static void head(lw_bytes *b, const lw_html_atlas *a, size_t i)
{
    const lw_html_leaf *l = &a->leaf[i];
    char title[160], name[48], link[160];
    lw_html_family_name(l, name, sizeof name);
    snprintf(title, sizeof title, "Chain %d of %d: %s", l->number, l->of, name);
    lw_page_head(b, title, &a->style, &a->chain_script, false);
    lw_page_text(b, "<header>\n<nav aria-label=\"Atlas\"><ul>\n<li><a rel=\"up\" href=\"index.html\">", a->options->title, "</a></li>\n");
    snprintf(link, sizeof link, "<li><a href=\"index.html#links=%d&amp;dof=%d%s\">", l->links, l->dof, joints_filter(a, l));
    lw_page_text(b, link, name, "</a></li>\n");
    lw_page_text(b, "<li><a href=\"index.html#assortment=", l->text[LW_LEAF_ASSORTMENT], "\">");
    lw_page_text(b, "assortment ", l->text[LW_LEAF_ASSORTMENT], "</a></li>\n");
    step_link(b, a, i - 1, i > 0, "prev", "Previous");
    step_link(b, a, i + 1, i + 1 < a->n, "next", "Next");
    lw_page_text(b, "</ul></nav>\n<h1>", title, "</h1>\n</header>\n");
}

/* Names and texts of a chain's page. */
typedef struct pairs {
    int  n;
    char number[6][24], graph[64], edges[LW_EDGES_SIZE], axes[LW_LINK_MAX*8];
    struct { const char *name, *text; } at[12];
} pairs;

static void pair_text(pairs *p, const char *name, const char *text)
{
    if (!text[0])
        return;
    p->at[p->n].name = name;
    p->at[p->n++].text = text;
}

static void properties(const lw_html_leaf *l, pairs *p)
{
    const struct { const char *name; long long n; } number[6] = {
        { "Links", l->links }, { "Joints", l->joints }, { "Degree of freedom", l->dof },
        { "Independent loops", l->loops }, { "Symmetries", l->symmetry }, { "Ground links", l->grounds } };
    p->n = 0;
    for (int i = 0; i < 6; i++) {
        if (i == 4) {
            size_t n = 0;
            for (int axis = l->links; axis < LW_LINK_MAX && l->axes >> axis & 1; axis++)
                n += (size_t)snprintf(p->axes + n, sizeof p->axes - n, "%s%d", n ? ", " : "",
                                      l->layout.first[axis + 1] - l->layout.first[axis]);
            pair_text(p, l->multiple ? "Links of 2, 3, \xe2\x80\xa6 pins" : "Links of 2, 3, \xe2\x80\xa6 joints", l->text[LW_LEAF_ASSORTMENT]);
            pair_text(p, "Links on each multiple joint", l->multiple ? p->axes : "");
            pair_text(p, "Structure", l->text[LW_LEAF_FORM]);
            pair_text(p, "Derivation", l->text[LW_LEAF_DERIVATION]);
        }
        snprintf(p->number[i], sizeof p->number[i], "%lld", number[i].n);
        pair_text(p, number[i].name, p->number[i]);
    }
    snprintf(p->graph, sizeof p->graph, l->layout.n_cross == 1 ? "not planar: drawn with %d crossing"
                                                               : "not planar: drawn with %d crossings",
             l->layout.n_cross);
    pair_text(p, "Graph", l->planar ? "planar" : p->graph);
}

static void notations(const lw_html_leaf *l, pairs *p)
{
    p->n = 0;
    if (l->multiple) {
        pair_text(p, "pins", l->text[LW_LEAF_LABEL]);
        return;
    }
    lw_edges_print(&l->chain, p->edges, sizeof p->edges);
    pair_text(p, "graph6", l->text[LW_LEAF_GRAPH6]);
    pair_text(p, "canonical label", l->text[LW_LEAF_LABEL]);
    pair_text(p, "joints", p->edges);
    pair_text(p, "Franke", l->text[LW_LEAF_FRANKE]);
    pair_text(p, "sentence", l->text[LW_LEAF_SENTENCE]);
    pair_text(p, "link adjacency matrix", l->text[LW_LEAF_MATRIX]);
}

static void write_properties(lw_bytes *b, const lw_html_leaf *l)
{
    pairs p;
    properties(l, &p);
    lw_bytes_text(b, "<table class=\"facts\">\n");
    for (int i = 0; i < p.n; i++) {
        lw_page_text(b, "<tr><th scope=\"row\">", p.at[i].name, "</th><td>");
        lw_page_text(b, "", p.at[i].text, "</td></tr>\n");
    }
    lw_bytes_text(b, "</table>\n");
}

static void write_notations(lw_bytes *b, const lw_html_leaf *l)
{
    pairs p;
    notations(l, &p);
    lw_bytes_text(b, "<h2 id=\"notations\">Notations</h2>\n<p class=\"hint\" role=\"status\" id=\"said\"></p>\n"
                     "<div class=\"notations\">\n");
    for (int i = 0; i < p.n; i++) {
        lw_page_text(b, "<div class=\"notation\"><h3>", p.at[i].name, "</h3><button type=\"button\" class=\"copy\" hidden>"
                     "Copy<span class=\"unseen\"> ");
        lw_page_text(b, "", p.at[i].name, "</span></button>\n<pre tabindex=\"0\"><code>");
        lw_page_text(b, "", p.at[i].text, "</code></pre></div>\n");
    }
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
    lw_page_text(r->out, "<tr><td data-label=\"Joints\">", lw_html_text(&v[0]), "</td>");
    lw_page_text(r->out, "<td data-label=\"Input\">", lw_html_text(&v[1]), "</td>");
    lw_page_text(r->out, "<td data-label=\"Assur groups\">", lw_html_text(&v[2]), "</td>");
    lw_page_text(r->out, "<td data-label=\"Modes\">", known ? text : "", "</td></tr>\n");
    return LW_OK;
}

/* Ask for the mechanisms of a ground link. */
static lw_status ask_mechanisms(lw_html_atlas *a, const lw_html_leaf *l, int link,
                                lw_status (*row)(void *, int, const char *const *, const lw_value *), rows *r, lw_error *e)
{
    char sql[256];
    const lw_value chain = lw_html_integer_value(l->id);
    snprintf(sql, sizeof sql, "SELECT kinds, inputs, assur, modes FROM mechanism WHERE chain = ?1 AND ground = %d "
             "ORDER BY sliders, kinds, id", link);
    return lw_html_ask(a, sql, &chain, row, r, e);
}

static lw_status mechanisms(lw_html_atlas *a, const lw_html_leaf *l, int link, lw_bytes *b, lw_error *e)
{
    char text[96];
    rows r = { .out = b };
    lw_status s = ask_mechanisms(a, l, link, write_mechanism, &r, e);
    if (r.n > 0)
        lw_bytes_text(b, "</tbody></table></div>\n");
    if (r.n > ROWS_MAX) {
        snprintf(text, sizeof text, "and %d more in the catalogue", r.n - ROWS_MAX);
        lw_page_text(b, "<p class=\"hint\">", text, "</p>\n");
    }
    return s;
}

static lw_status inversions(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *b, lw_error *e)
{
    char text[96];
    lw_status s = LW_OK;
    lw_bytes_text(b, "<h2 id=\"inversions\">Ground links</h2>\n<div class=\"inversions\">\n");
    for (int i = 0; s == LW_OK && i < l->n_ground; i++) {
        snprintf(text, sizeof text, l->alike[i] > 1 ? "Ground link %d, one of %d alike" : "Ground link %d", l->ground[i], l->alike[i]);
        lw_page_text(b, "<article>\n<h3>", text, "</h3>\n<figure>");
        s = picture(l, i, (lw_chain_style){ .width = 240, .height = 180 }, text, b, e);
        lw_bytes_text(b, "</figure>\n");
        if (s == LW_OK && !l->multiple)
            s = mechanisms(a, l, l->ground[i], b, e);
        lw_bytes_text(b, "</article>\n");
    }
    lw_bytes_text(b, "</div>\n");
    return s;
}

lw_status lw_html_chain_page(lw_html_atlas *a, size_t i, lw_bytes *b, lw_error *e)
{
    const lw_html_leaf *l = &a->leaf[i];
    char file[LW_LEAF_FILE], text[96];
    head(b, a, i);
    lw_bytes_text(b, "<main>\n<div class=\"first\">\n<figure>");
    const lw_chain_style large = { .width = 480, .height = 360, .numbers = true };
    lw_status s = picture(l, LW_NONE, large, "The chain, its links numbered", b, e);
    if (s != LW_OK)
        return s;
    lw_bytes_text(b, "</figure>\n");
    write_properties(b, l);
    lw_bytes_text(b, "</div>\n");
    if (l->n_linkage > 0) {
        lw_html_page_file(l, "linkages", file);
        snprintf(text, sizeof text, l->n_linkage == 1 ? "%lld linkage, moving" : "%lld linkages, moving", l->n_linkage);
        lw_page_text(b, "<p class=\"linkages\"><a href=\"", file, "\">");
        lw_page_text(b, "", text, "</a></p>\n");
    }
    if (l->n_slider > 0) {
        lw_html_page_file(l, "sliders", file);
        snprintf(text, sizeof text, l->n_slider == 1 ? "%d mechanism with sliders" : "%d mechanisms with sliders", l->n_slider);
        lw_page_text(b, "<p class=\"linkages\"><a href=\"", file, "\">");
        lw_page_text(b, "", text, "</a></p>\n");
    }
    write_notations(b, l);
    s = inversions(a, l, b, e);
    lw_bytes_text(b, "</main>\n<script>");
    lw_bytes_text(b, a->chain_script.data);
    lw_bytes_text(b, "</script>\n</body>\n</html>\n");
    return s;
}

/* ---- mechanisms with sliders --------------------------------------------------------------------- */

#define SLIDERS_MAX 120        /* pictures on a page */

typedef struct slider_row { int ground; char kinds[LW_JOINT_MAX + 1]; } slider_row;
typedef struct slider_rows { int n, n_joint; slider_row *row; } slider_rows;

static lw_status add_slider_row(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    slider_rows *r = context;
    const char *kinds = lw_html_text(&v[1]);
    if (strlen(kinds) != (size_t)r->n_joint || strspn(kinds, "rt") != strlen(kinds) || v[0].integer < 1 || v[0].integer > LW_LINK_MAX)
        return LW_OK;                             /* not of this program */
    if (r->n++ < SLIDERS_MAX) {
        r->row[r->n - 1].ground = (int)v[0].integer;
        strcpy(r->row[r->n - 1].kinds, kinds);
    }
    return LW_OK;
}

/* One mechanism: its name, and its picture. */
static lw_status slider_article(const lw_html_leaf *l, const slider_row *r, lw_bytes *b, lw_error *e)
{
    lw_mechanism m = l->chain;
    lw_chain_layout layout;
    lw_drawing d;
    char text[LW_JOINT_MAX + 64];
    snprintf(text, sizeof text, "Ground link %d, joints %s", r->ground, r->kinds);
    m.ground = r->ground - 1;
    memcpy(m.kind, r->kinds, (size_t)m.n_joint);
    lw_status s = lw_chain_layout_make(&m, &layout, e);
    if (s == LW_OK)
        s = lw_chain_draw(&m, &layout, &(lw_chain_style){ .width = 240, .height = 180, .numbers = true }, &d, e);
    if (s != LW_OK)
        return s;
    lw_text_clean(d.title, sizeof d.title, text);
    lw_page_text(b, "<article>\n<h3>", text, "</h3>\n<figure>");
    lw_svg_inline(&d, "", b);
    lw_bytes_text(b, "</figure>\n</article>\n");
    lw_drawing_free(&d);
    return LW_OK;
}

lw_status lw_html_slider_page(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *b, int *n, lw_error *e)
{
    slider_rows r = { .n_joint = l->chain.n_joint, .row = malloc(SLIDERS_MAX*sizeof *r.row) };
    const lw_value chain = lw_html_integer_value(l->id);
    char text[160], name[48], file[LW_LEAF_FILE];
    lw_status s = r.row ? lw_html_ask(a, "SELECT DISTINCT ground, kinds FROM mechanism WHERE chain = ?1 AND sliders > 0 "
                                  "ORDER BY sliders, ground, kinds DESC", &chain, add_slider_row, &r, e)
                        : lw_error_set(e, LW_E_MEMORY, "out of memory for pictures");
    *n = r.n;
    if (s == LW_OK && r.n > 0) {
        lw_html_family_name(l, name, sizeof name);
        snprintf(text, sizeof text, "Chain %d of %d with sliders: %s", l->number, l->of, name);
        lw_html_page_file(l, "chain", file);
        lw_page_head(b, text, &a->style, &a->chain_script, false);
        lw_page_text(b, "<header>\n<nav aria-label=\"Atlas\"><ul>\n<li><a rel=\"up\" href=\"", file, "\">The chain</a></li>\n");
        lw_page_text(b, "</ul></nav>\n<h1>", text, "</h1>\n</header>\n<main>\n");
        snprintf(text, sizeof text, "%d choices of ground link and sliders; %s.", r.n,
                 r.n > SLIDERS_MAX ? "the first 120 are drawn, the catalogue has all" : "joints r turn, joints t slide");
        lw_page_text(b, "<p class=\"hint\">", text, "</p>\n<div class=\"inversions\">\n");
    }
    for (int i = 0; s == LW_OK && i < r.n && i < SLIDERS_MAX; i++)
        s = slider_article(l, &r.row[i], b, e);
    if (s == LW_OK && r.n > 0) {
        lw_bytes_text(b, "</div>\n<p class=\"hint\" role=\"status\" id=\"said\"></p>\n</main>\n<script>");
        lw_bytes_text(b, a->chain_script.data);
        lw_bytes_text(b, "</script>\n</body>\n</html>\n");
    }
    free(r.row);
    return s;
}

/* ---- blocks of chains ------------------------------------------------------------------------------ */

static lw_status json_mechanism(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    rows *r = context;
    if (r->n++ >= ROWS_MAX)
        return LW_OK;
    lw_bytes_text(r->out, r->n > 1 ? ",[" : "[");
    for (int i = 0; i < 3; i++) {
        json_text(r->out, lw_html_text(&v[i]));
        lw_bytes_text(r->out, ",");
    }
    lw_bytes_integer(r->out, v[3].kind == LW_VALUE_INTEGER ? (long)v[3].integer : 0);
    lw_bytes_text(r->out, "]");
    return LW_OK;
}

static void json_pairs(lw_bytes *b, const pairs *p)
{
    for (int i = 0; i < p->n; i++) {
        lw_bytes_text(b, i ? ",[" : ",[[");
        json_text(b, p->at[i].name);
        lw_bytes_text(b, ",");
        json_text(b, p->at[i].text);
        lw_bytes_text(b, "]");
    }
    lw_bytes_text(b, "]");
}

lw_status lw_html_json_chain(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *b, lw_error *e)
{
    lw_status s = LW_OK;
    pairs p;
    lw_bytes_text(b, "[");
    lw_bytes_integer(b, (long)l->n_linkage);
    lw_bytes_text(b, ",");
    json_layout(b, &l->layout, l->links);
    properties(l, &p);
    json_pairs(b, &p);
    notations(l, &p);
    json_pairs(b, &p);
    lw_bytes_text(b, ",[");
    for (int i = 0; s == LW_OK && i < l->n_ground; i++) {
        rows r = { .out = b };
        lw_bytes_text(b, i ? ",[" : "[");
        lw_bytes_integer(b, l->ground[i]);
        lw_page_number(b, l->alike[i]);
        lw_bytes_text(b, ",");
        json_layout(b, &l->grounded[i], l->links);
        lw_bytes_text(b, ",[");
        s = l->multiple ? LW_OK : ask_mechanisms(a, l, l->ground[i], json_mechanism, &r, e);
        lw_bytes_text(b, "]");
        lw_page_number(b, r.n);
        lw_bytes_text(b, "]");
    }
    lw_bytes_text(b, "]]");
    return s;
}

void lw_html_block_page(const lw_html_atlas *a, lw_bytes *b)
{
    lw_page_head(b, a->options->title, &a->style, &a->block_script, true);
    lw_page_text(b, "<header>\n<nav aria-label=\"Atlas\"><ul id=\"steps\">\n<li><a rel=\"up\" href=\"index.html\">",
                 a->options->title, "</a></li>\n</ul></nav>\n<h1>A chain</h1>\n</header>\n<main>\n");
    lw_bytes_text(b, "<noscript><p>This page needs scripts.</p></noscript>\n<div id=\"chain\"></div>\n"
                     "<p class=\"hint\" role=\"status\" id=\"said\"></p>\n</main>\n<script>");
    lw_bytes_text(b, a->block_script.data);
    lw_bytes_text(b, "</script>\n</body>\n</html>\n");
}

/* ---- linkages ----------------------------------------------------------------------------------- */

typedef struct found {
    int              n, capacity;
    lw_scene        *scene;                    /* (capacity) */
    lw_page_result  *result;
    char           (*text)[2][64];             /* type and class */
    lw_error        *e;
} found;

static lw_status read_linkage(void *context, int n, const char *const *name, const lw_value *v)
{
    (void)n, (void)name;
    found *f = context;
    if (f->n == f->capacity)
        return LW_OK;
    lw_scene *s = &f->scene[f->n];
    const char *json = lw_html_text(&v[4]);
    lw_assembly k = { 0 };
    lw_status st = lw_assembly_read_result(json, strlen(json), "linkage of the catalogue", 0, &k, f->e);
    if (st == LW_OK)
        st = lw_scene_make_any(&k, NULL, NULL, NULL, s, f->e);
    lw_assembly_free(&k);
    if (st != LW_OK) {
        lw_scene_free(s);
        return st;
    }
    lw_text_clean(f->text[f->n][0], sizeof f->text[0][0], lw_html_text(&v[1]));
    lw_text_clean(f->text[f->n][1], sizeof f->text[0][1], lw_html_text(&v[2]));
    const char *type = f->text[f->n][0], *class_name = f->text[f->n][1];
    f->result[f->n] = (lw_page_result){
        .scene = s, .type = type[0] ? type : s->title, .class_name = class_name[0] ? class_name : NULL,
        .note = s->note[0] ? s->note : NULL, .transmission_min = NAN, .objective = NAN,
        .error_max = NAN, .angle_mean = NAN, .angle_max = NAN, .error_percent = NAN,
        .error_mean = v[3].kind == LW_VALUE_NULL ? NAN : v[3].real,
    };
    f->n++;
    return LW_OK;
}

/* Best first. A linkage whose chain is in the atlas is shown on the chain's page. */
#define LINKAGE_COLUMNS "SELECT name, type, class, error_mean, json FROM linkage WHERE "
#define LINKAGE_ORDER   " ORDER BY error_mean IS NULL, error_mean, id"

static lw_status read_linkages(lw_html_atlas *a, const lw_html_leaf *l, found *f, lw_error *e)
{
    static const char of_chain[] = LINKAGE_COLUMNS "label = ?1" LINKAGE_ORDER;
    static const char of_others[] = LINKAGE_COLUMNS "label IS NULL OR label NOT IN (SELECT label FROM chain"
                                    " WHERE ?1 = 0 OR links = ?1)" LINKAGE_ORDER;
    lw_value value = l ? lw_html_text_value(l->text[LW_LEAF_LABEL]) : lw_html_integer_value(a->options->links);
    return lw_html_ask(a, l ? of_chain : of_others, &value, read_linkage, f, e);
}

static lw_status write_linkage_page(const lw_html_leaf *l, const found *f, lw_bytes *out, lw_error *e)
{
    char title[160], name[48], file[LW_LEAF_FILE] = "index.html";
    if (l) {
        lw_html_family_name(l, name, sizeof name);
        snprintf(title, sizeof title, "Linkages of chain %d with %s", l->number, name);
        lw_html_page_file(l, "chain", file);
    }
    lw_page_target t = { .name = l ? title : "Linkages of other chains", .n_result = f->n, .result = f->result };
    lw_page p = { .title = t.name, .home = file, .home_title = l ? "The chain" : "Atlas", .n_target = 1, .target = &t };
    return lw_page_write(&p, out, e);
}

lw_status lw_html_linkage_page(lw_html_atlas *a, const lw_html_leaf *l, lw_bytes *out, int *n, lw_error *e)
{
    size_t capacity = (size_t)(a->options->n_linkage > 0 ? a->options->n_linkage : 0) + 1;
    found f = { .capacity = (int)capacity - 1, .e = e };
    f.scene = calloc(capacity, sizeof *f.scene);
    f.result = calloc(capacity, sizeof *f.result);
    f.text = calloc(capacity, sizeof *f.text);
    lw_status s = f.scene && f.result && f.text ? read_linkages(a, l, &f, e)
                : lw_error_set(e, LW_E_MEMORY, "out of memory for %zu linkages", capacity);
    if (s == LW_OK && f.n > 0)
        s = write_linkage_page(l, &f, out, e);
    *n = s == LW_OK ? f.n : 0;
    for (int i = 0; f.scene && i < f.n; i++)
        lw_scene_free(&f.scene[i]);
    free(f.scene);
    free(f.result);
    free(f.text);
    return s;
}

/* ==== all pages =============================================================================================== */

/* catalogues/pages/atlas_html_index.c - the overview of an atlas, with all chains as data for search and filter */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "catalogues/pages/atlas_html_internal.h"
#include "catalogues/pages/page_internal.h"

#define ASSORTMENTS_MAX 64     /* of one number of links and freedoms: 14 links have 42 */

/* ---- overview ----------------------------------------------------------------------------------- */

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

/* The chains from `first` on with as many links and freedoms. */
static family family_from(const lw_atlas_html *a, size_t first)
{
    family f = { .first = first };
    while (first + f.n < a->n && (f.n == 0 || a->leaf[first + f.n].number > 1)) {
        const lw_leaf *l = &a->leaf[first + f.n++];
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

static void write_family(lw_bytes *b, const lw_atlas_html *a, const family *f)
{
    const lw_leaf *l = &a->leaf[f->first];
    char text[128], link[160];
    snprintf(link, sizeof link, "#links=%d&amp;dof=%d", l->links, l->dof);
    lw_bytes_text(b, "<tr><th scope=\"row\"><a href=\"");
    lw_bytes_text(b, link);
    lw_leaf_family(l, text, sizeof text);
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

static void overview(lw_bytes *b, const lw_atlas_html *a)
{
    char text[96];
    lw_bytes_text(b, "<h2>Overview</h2>\n<div class=\"scroll\" tabindex=\"0\"><table>\n<caption>Assortments count links of "
                     "2, 3, 4, \xe2\x80\xa6 joints.</caption>\n<thead><tr><th scope=\"col\">Family</th>"
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
        snprintf(text, sizeof text, a->n_other == 1 ? "%lld linkage of another chain" : "%lld linkages of other chains",
                 a->n_other);
        lw_page_text(b, "<p class=\"linkages\"><a href=\"linkages-other.html\">", text, "</a></p>\n");
    }
}

/* ---- search ------------------------------------------------------------------------------------- */

static void controls(lw_bytes *b)
{
    lw_bytes_text(b,
        "<h2 id=\"chains\">Chains</h2>\n<div class=\"filter\" role=\"search\" hidden>\n"
        "<label class=\"wide\">Search <input type=\"search\" id=\"q\" autocomplete=\"off\" spellcheck=\"false\""
        " placeholder=\"number, graph6, Franke, structure\"></label>\n"
        "<label>Links <select id=\"links\"><option value=\"\">all</option></select></label>\n"
        "<label>Freedom <select id=\"dof\"><option value=\"\">all</option></select></label>\n"
        "<label>Assortment <select id=\"assortment\"><option value=\"\">all</option></select></label>\n"
        "<label>Graph <select id=\"planar\"><option value=\"\">all</option><option value=\"1\">planar</option>"
        "<option value=\"0\">not planar</option></select></label>\n"
        "<label>Order <select id=\"order\"><option value=\"\">by number</option><option value=\"symmetry\">most symmetric "
        "first</option><option value=\"grounds\">fewest ground links first</option></select></label>\n"
        "<label class=\"check\"><input type=\"checkbox\" id=\"linkages\"> with linkages</label>\n"
        "<button type=\"button\" id=\"clear\">Clear</button>\n</div>\n"
        "<p id=\"count\" class=\"hint\" role=\"status\"></p>\n<ul id=\"cards\" class=\"cards\"></ul>\n"
        "<button type=\"button\" id=\"more\" hidden>Show more</button>\n"
        "<p class=\"hint keys\" hidden>Keys: / search, arrows from picture to picture, Enter opens.</p>\n");
}

static void plain_list(lw_bytes *b, const lw_atlas_html *a)
{
    char file[LW_LEAF_FILE], name[96];
    lw_bytes_text(b, "<noscript>\n<ul class=\"plain\">\n");
    for (size_t i = 0; i < a->n; i++) {
        const lw_leaf *l = &a->leaf[i];
        lw_leaf_file(l, "chain", file);
        snprintf(name, sizeof name, "%d links, F = %d, chain %d", l->links, l->dof, l->number);
        lw_page_text(b, "<li><a href=\"", file, "\">");
        lw_page_text(b, "", name, "</a></li>\n");
    }
    lw_bytes_text(b, "</ul>\n</noscript>\n");
}

/* ---- data --------------------------------------------------------------------------------------- */

/* A JSON string that cannot end the element it stands in. */
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

static void json_number(lw_bytes *b, long n)
{
    lw_bytes_text(b, ",");
    lw_bytes_integer(b, n);
}

/* See atlas_html.js: numbers, texts, places of joints in 1/100 of a bar (y down), joints of each link in order. */
static void json_leaf(lw_bytes *b, const lw_leaf *l)
{
    static const lw_leaf_text texts[] = { LW_LEAF_ASSORTMENT, LW_LEAF_GRAPH6, LW_LEAF_LABEL, LW_LEAF_FRANKE,
                                          LW_LEAF_FORM };
    lw_bytes_text(b, "[");
    lw_bytes_integer(b, l->links);
    json_number(b, l->dof);
    json_number(b, l->number);
    json_number(b, l->planar != 0);
    json_number(b, (long)l->symmetry);
    json_number(b, l->grounds);
    json_number(b, (long)l->n_linkage);
    for (size_t i = 0; i < sizeof texts/sizeof *texts; i++) {
        lw_bytes_text(b, ",");
        json_text(b, l->text[texts[i]]);
    }
    for (int j = 0; j < l->layout.n_joint; j++) {
        lw_bytes_text(b, j ? "," : ",[");
        lw_bytes_integer(b, lround(100*l->layout.at[j].x));
        json_number(b, -lround(100*l->layout.at[j].y));
    }
    for (int i = 0; i < l->links; i++) {
        lw_bytes_text(b, i ? "],[" : "],[[");
        for (int k = l->layout.first[i]; k < l->layout.first[i + 1]; k++) {
            lw_bytes_text(b, k > l->layout.first[i] ? "," : "");
            lw_bytes_integer(b, l->layout.ring[k]);
        }
    }
    lw_bytes_text(b, "]]]");
}

void lw_atlas_index_page(const lw_atlas_html *a, lw_bytes *b)
{
    char about[96];
    lw_page_head(b, a->options->title, &a->style, &a->index_script);
    lw_page_text(b, "<header>\n<h1>", a->options->title, "</h1>\n");
    snprintf(about, sizeof about, a->n == 1 ? "%zu kinematic chain" : "%zu kinematic chains", a->n);
    lw_page_text(b, "<p class=\"about\">", about, "</p>\n</header>\n<main>\n");
    overview(b, a);
    controls(b);
    plain_list(b, a);
    lw_bytes_text(b, "</main>\n<script type=\"application/json\" id=\"data\">[\n");
    for (size_t i = 0; i < a->n; i++) {
        lw_bytes_text(b, i ? ",\n" : "");
        json_leaf(b, &a->leaf[i]);
    }
    lw_bytes_text(b, "\n]</script>\n<script>");
    lw_bytes_text(b, a->index_script.data);
    lw_bytes_text(b, "</script>\n</body>\n</html>\n");
}

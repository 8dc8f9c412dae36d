/* catalogues/pages/page.c - see page.h */
#include "catalogues/pages/page.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "catalogues/draw/diagram.h"
#include "catalogues/pages/page_files.h"      /* made from page.css and page.js by the Makefile */
#include "catalogues/pages/page_internal.h"
#include "catalogues/draw/svg.h"

static bool same(const char *a, const char *b)
{
    return a && b && strcmp(a, b) == 0;
}

static void head(lw_bytes *b, const lw_page *p, const lw_bytes *style, const lw_bytes *script)
{
    lw_page_head(b, p->title, style, script);
    lw_page_text(b, "<header>\n<h1>", p->title, "</h1>\n");
    if (p->about)
        lw_page_text(b, "<p class=\"about\">", p->about, "</p>\n");
    if (p->home) {
        lw_page_text(b, "<p><a href=\"", p->home, "\">");
        lw_page_text(b, "", p->home_title ? p->home_title : p->home, "</a></p>\n");
    }
    lw_bytes_text(b, "</header>\n");
    if (p->n_target < 2)
        return;
    lw_bytes_text(b, "<nav aria-label=\"Targets\"><ul>\n");
    for (int i = 0; i < p->n_target; i++) {
        char t[48];
        snprintf(t, sizeof t, "<li><a href=\"#target-%d\">", i + 1);
        lw_page_text(b, t, p->target[i].name, "</a></li>\n");
    }
    lw_bytes_text(b, "</ul></nav>\n");
}

static void controls(lw_bytes *b)
{
    lw_bytes_text(b,
        "<div class=\"transport\" role=\"group\" aria-label=\"Motion\" hidden>\n"
        "<button type=\"button\" class=\"play\">Play</button>\n"
        "<input type=\"range\" class=\"time\" min=\"0\" max=\"1\" step=\"any\" value=\"0\""
        " aria-label=\"Place in the motion\">\n"
        "<label>Speed <select class=\"speed\"><option value=\"0.25\">1/4</option>"
        "<option value=\"0.5\">1/2</option><option value=\"1\" selected>1</option>"
        "<option value=\"2\">2</option></select></label>\n"
        "<label><input type=\"checkbox\" class=\"names\" checked> Labels</label>\n</div>\n");
}

/* The drawing of one result and its motion, which goes to the list of all motions. */
static lw_status figure(lw_bytes *b, lw_bytes *motions, const lw_page *p, int target, int result,
                        int *n_motion, lw_error *e)
{
    const lw_page_result *r = &p->target[target].result[result];
    lw_diagram_options o = lw_diagram_options_default();
    o.width = 440;                       /* small, with large signs: legible on a phone too */
    o.height = 360;
    o.zoom = 1.25;
    o.title = o.dimensions = o.length_values = false;             /* the table has them */
    o.whole_motion = true;
    lw_drawing d;
    lw_status st = lw_diagram_draw(r->scene, &o, &d, e);
    if (st != LW_OK)
        return st;
    char t[96];
    snprintf(t, sizeof t, "<figure data-result=\"%d\" data-motion=\"%d\">\n", result, *n_motion);
    lw_bytes_text(b, t);
    snprintf(t, sizeof t, "t%dr%d-", target + 1, result + 1);
    lw_svg_inline(&d, t, b);
    bool titled = !same(r->scene->title, p->title) && !same(r->scene->title, p->target[target].name);
    lw_page_text(b, "<figcaption>", titled ? r->scene->title : NULL, titled && r->note ? ": " : "");
    lw_page_text(b, "", r->note, "</figcaption>\n</figure>\n");
    lw_bytes_text(motions, *n_motion ? ",\n" : "");
    lw_page_motions(motions, r->scene, &d);
    ++*n_motion;
    lw_drawing_free(&d);
    return LW_OK;
}

static lw_status section(lw_bytes *b, lw_bytes *motions, const lw_page *p, int target,
                         int *n_motion, lw_error *e)
{
    const lw_page_target *t = &p->target[target];
    char open[64];
    snprintf(open, sizeof open, "<section id=\"target-%d\">\n", target + 1);
    lw_bytes_text(b, open);
    if (p->n_target > 1 || !same(t->name, p->title))
        lw_page_text(b, "<h2>", t->name, "</h2>\n");
    if (t->about)
        lw_page_text(b, "<p class=\"about\">", t->about, "</p>\n");
    for (int i = 0; i < t->n_result; i++) {
        lw_status st = t->result[i].scene
                     ? figure(b, motions, p, target, i, n_motion, e) : LW_OK;
        if (st != LW_OK)
            return st;
    }
    controls(b);
    lw_page_table(b, t, target);
    lw_bytes_text(b, "</section>\n");
    return LW_OK;
}

/* Body and script after the head; motions is scratch. */
static lw_status body(lw_bytes *b, lw_bytes *motions, const lw_page *p, const lw_bytes *script,
                      lw_error *e)
{
    int n_motion = 0;
    lw_bytes_text(b, "<main>\n");
    for (int i = 0; i < p->n_target; i++) {
        lw_status st = section(b, motions, p, i, &n_motion, e);
        if (st != LW_OK)
            return st;
    }
    lw_bytes_text(b, "</main>\n<script type=\"application/json\" id=\"motions\">[\n");
    lw_bytes_add(b, motions->data, motions->size);
    lw_bytes_text(b, "\n]</script>\n<script>");
    lw_bytes_text(b, script->data);
    lw_bytes_text(b, "</script>\n</body>\n</html>\n");
    b->failed = b->failed || motions->failed;
    return LW_OK;
}

lw_status lw_page_write(const lw_page *p, lw_bytes *out, lw_error *e)
{
    *out = (lw_bytes){ 0 };
    int n_result = 0;
    for (int i = 0; i < p->n_target; i++)
        n_result += p->target[i].n_result;
    if (n_result == 0)
        return lw_error_set(e, LW_E_ARG, "a page needs a result to show");
    lw_bytes style = { 0 }, script = { 0 }, motions = { 0 };
    lw_page_style(&style, lw_page_css, NULL);
    lw_page_script(&script, lw_page_js);
    out->failed = style.failed || script.failed;
    lw_status st = LW_OK;
    if (!out->failed) {
        head(out, p, &style, &script);
        st = body(out, &motions, p, &script, e);
    }
    lw_bytes_free(&style);
    lw_bytes_free(&script);
    lw_bytes_free(&motions);
    if (st == LW_OK)
        return lw_bytes_end(out, e);
    lw_bytes_free(out);
    return st;
}

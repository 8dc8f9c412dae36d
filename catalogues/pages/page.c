/* catalogues/pages/page.c - targets, results and moving linkages in one page; see page.h */
#include "catalogues/pages/page.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/draw/diagram.h"
#include "catalogues/draw/svg.h"
#include "catalogues/pages/page_files.h"      /* made from page.css and page.js by the Makefile */
#include "catalogues/pages/page_head.h"

/* ==== the table of results ==================================================================================== */

typedef enum column {
    TYPE, DOWNLOAD, CLASS, INPUT, MEAN, MAX, ANGLE_MEAN, ANGLE_MAX, STRAY, PERCENT, OBJECTIVE, COUNTS_AS, TRANSMISSION, SIZE, LIMITS, DIMENSIONS, N_COLUMN
} column;

static const struct { const char *title; bool number, length; } columns[N_COLUMN] = {
    [TYPE]       = { "Type", false, false },
    [DOWNLOAD]   = { "File", false, false },
    [CLASS]      = { "Class", false, false },
    [INPUT]      = { "Input", false, false },
    [MEAN]       = { "Mean error", true, true },
    [MAX]        = { "Largest error", true, true },
    [ANGLE_MEAN] = { "Mean angle error [deg]", true, false },
    [ANGLE_MAX]  = { "Largest angle error [deg]", true, false },
    [STRAY]      = { "Stray", true, true },
    [PERCENT]    = { "% of path", true, false },
    [OBJECTIVE]  = { "Objective", true, false },
    [COUNTS_AS]  = { "Counts as [%]", true, false },
    [TRANSMISSION] = { "Least transmission angle [deg]", true, false },
    [SIZE]       = { "Size over path", true, false },
    [LIMITS]     = { "At its limit", false, false },
    [DIMENSIONS] = { "Dimensions", false, false },
};

static const lw_units *units_of(const lw_page_result *r)
{
    static const lw_units metre = { "m", "rad", 1, 1 };
    return r->scene ? &r->scene->linkage.units : &metre;
}

static double number_in(const lw_page_result *r, column c)
{
    switch (c) {
    case MEAN:      return r->error_mean/units_of(r)->metre;
    case MAX:       return r->error_max/units_of(r)->metre;
    case ANGLE_MEAN: case ANGLE_MAX:
        return (c == ANGLE_MAX ? r->angle_max : r->angle_mean)*180/LW_PI;
    case STRAY:     return r->size > 0 ? r->stray/units_of(r)->metre : NAN;
    case SIZE:      return r->size > 0 ? r->size : NAN;
    case PERCENT:   return r->error_percent;
    case OBJECTIVE: return r->counts_as > 0 ? NAN : r->objective;
    case COUNTS_AS: return r->counts_as > 0 ? 100*r->counts_as : NAN;
    case TRANSMISSION: return r->transmission_min*180/LW_PI;
    default:        return NAN;
    }
}

static const char *text_in(const lw_page_result *r, column c)
{
    return c == TYPE ? r->type : c == CLASS ? r->class_name : c == INPUT ? r->input : c == LIMITS ? r->limits : NULL;
}

static bool has(const lw_page_result *r, column c)
{
    if (c == DOWNLOAD)
        return r->file != NULL;
    return c == DIMENSIONS ? r->dimensions || (r->scene && r->scene->n_dim > 0)
                           : text_in(r, c) ? *text_in(r, c) != 0 : !isnan(number_in(r, c));
}

static bool is_used(const lw_page_target *t, column c)
{
    for (int i = 0; i < t->n_result; i++)
        if (has(&t->result[i], c))
            return true;
    return false;
}

static void dimensions(lw_bytes *b, const lw_page_result *r)
{
    const lw_scene *s = r->scene;
    if (r->dimensions)
        lw_bytes_xml(b, r->dimensions);
    for (int i = 0; s && i < s->n_dim && !r->dimensions; i++) {
        lw_bytes_text(b, "<span>");
        lw_bytes_xml(b, s->dim_name[i]);
        lw_bytes_text(b, " = ");
        lw_bytes_number(b, lw_scene_dimension(s, i), 6);
        lw_bytes_text(b, "</span> ");
    }
}

/* A link that holds the linkage itself. */
static void download(lw_bytes *b, const lw_page_result *r)
{
    char *text = r->file ? lw_linkage_write(r->linkage, 1) : NULL, code[4];
    if (!text)
        return;
    lw_bytes_text(b, "<a download=\"");
    lw_bytes_xml(b, r->file);
    lw_bytes_text(b, "\" href=\"data:application/json;charset=utf-8,");
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        snprintf(code, sizeof code, isalnum(*c) && *c < 128 ? "%c" : "%%%02X", *c);
        lw_bytes_text(b, code);
    }
    lw_bytes_text(b, "\">JSON</a>");
    free(text);
}

/* Title of a column with its unit, such as "Mean error [mm]"; all results of a target share the unit. */
static void column_title(lw_bytes *b, const lw_page_target *t, column c)
{
    const lw_units *u = units_of(&t->result[0]);
    lw_bytes_text(b, columns[c].title);
    if ((!columns[c].length && c != DIMENSIONS) || !u->length[0])
        return;
    lw_bytes_text(b, " [");
    lw_bytes_xml(b, u->length);
    lw_bytes_text(b, c == DIMENSIONS ? ", " : "]");
    if (c == DIMENSIONS) {
        lw_bytes_xml(b, u->angle);
        lw_bytes_text(b, "]");
    }
}

static void column_heads(lw_bytes *b, const lw_page_target *t)
{
    lw_bytes_text(b, t->n_result > 1 ? "<thead><tr><th scope=\"col\">Rank</th>" : "<thead><tr>");
    for (int c = 0; c < N_COLUMN; c++) {
        if (!is_used(t, (column)c))
            continue;
        lw_bytes_text(b, columns[c].number ? "<th scope=\"col\" class=\"number\">" : "<th scope=\"col\">");
        column_title(b, t, (column)c);
        lw_bytes_text(b, "</th>");
    }
    lw_bytes_text(b, "</tr></thead>\n");
}

/* data-label: the text shown before the cell when the page is too narrow for columns. */
static void cell(lw_bytes *b, const lw_page_target *t, const lw_page_result *r, column c)
{
    lw_bytes_text(b, columns[c].number ? "<td class=\"number\" data-label=\""
                   : c == DIMENSIONS ? "<td class=\"dimensions\" data-label=\""
                   : "<td class=\"name\" data-label=\"");
    column_title(b, t, c);
    lw_bytes_text(b, "\">");
    if (c == DIMENSIONS)
        dimensions(b, r);
    else if (c == DOWNLOAD)
        download(b, r);
    else if (text_in(r, c))
        lw_bytes_xml(b, text_in(r, c));
    else if (!isnan(number_in(r, c)))
        lw_bytes_number(b, number_in(r, c), 4);
    lw_bytes_text(b, "</td>");
}

static void results_table(lw_bytes *b, const lw_page_target *t, int target)
{
    char text[192];
    int n_used = 0;
    for (int c = 0; c < N_COLUMN; c++)
        n_used += is_used(t, (column)c);
    if (t->n_result == 0) {
        lw_bytes_text(b, "<p>No linkage was found.</p>\n");
        return;
    }
    if (t->n_result == 1 && n_used == 0)                      /* a linkage alone, of which nothing is known but its picture */
        return;
    lw_bytes_text(b, "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Results\">\n<table>\n");
    if (t->n_result > 1)
        lw_bytes_text(b, "<caption>Results, best first. Choose one to see it move.</caption>\n");
    column_heads(b, t);
    lw_bytes_text(b, "<tbody>\n");
    for (int i = 0; i < t->n_result; i++) {
        snprintf(text, sizeof text, "<tr><td class=\"rank\"><label><input type=\"radio\" "
                 "name=\"shown-%d\"%s> %d</label></td>", target + 1, i ? "" : " checked", i + 1);
        lw_bytes_text(b, t->n_result > 1 ? text : "<tr>");
        for (int c = 0; c < N_COLUMN; c++)
            if (is_used(t, (column)c))
                cell(b, t, &t->result[i], (column)c);
        lw_bytes_text(b, "</tr>\n");
    }
    lw_bytes_text(b, "</tbody></table>\n</div>\n");
}

/* ==== motions ================================================================================================= */

/* Point to which the motion of a link's shapes refers in a panel: its reference point; in the enlarged panel its
 * tracer, so that rounding an angle has no visible effect. */
static lw_vec2 pole(const lw_scene *s, int link, int panel)
{
    if (panel > 0)
        for (int i = 0; i < s->linkage.n_tracer; i++)
            if (s->linkage.tracer[i].link == link)
                return s->linkage.tracer[i].at;
    return s->origin[link];
}

static bool moves_in(const lw_drawing *d, int link, int panel)
{
    for (size_t i = 0; i < d->n_shape; i++)
        if ((d->shape[i].link == link || d->shape[i].tie == link) && d->shape[i].panel == panel)
            return true;
    return false;
}

static long tenths(double px)
{
    return lround(10*fmin(fmax(px, -1e7), 1e7));
}

/* Write [link, panel, from, then per frame x, y, angle as differences]: see page.js. */
static void motion_of(lw_bytes *b, const lw_scene *s, const lw_view *v, int link, int panel)
{
    lw_vec2 p = pole(s, link, panel), from = lw_view_pixel(v, p);
    lw_bytes_text(b, "[");
    lw_bytes_integer(b, link);
    lw_page_number(b, panel);
    lw_page_number(b, tenths(from.x));
    lw_page_number(b, tenths(from.y));
    long x = 0, y = 0, angle = 0;
    double whole = 0;                                  /* angle so far, with whole turns [rad] */
    for (size_t f = 0; f < s->n_frame; f++) {
        lw_vec2 at = lw_view_pixel(v, lw_scene_at(s, f, link, p));
        lw_vec2 turn = s->place[f*(size_t)s->linkage.n_link + (size_t)link].turn;
        whole += remainder(atan2(-turn.y, turn.x) - whole, 2*LW_PI);         /* y points down on a page */
        long now[3] = { tenths(at.x), tenths(at.y), lround(10000*whole) };
        lw_page_number(b, now[0] - x);
        lw_page_number(b, now[1] - y);
        lw_page_number(b, now[2] - angle);
        x = now[0];
        y = now[1];
        angle = now[2];
    }
    lw_bytes_text(b, "]");
}

/* Write one JSON object, { "loops", "first", "links": [...] }, for page.js: every link that moves on the drawing, whole
 * numbers only. */
static void write_motions(lw_bytes *b, const lw_scene *s, const lw_drawing *d)
{
    lw_bytes_text(b, s->loops ? "{\"loops\":true,\"first\":" : "{\"loops\":false,\"first\":");
    lw_bytes_integer(b, (long)s->first_frame);
    lw_bytes_text(b, ",\"links\":[");
    const char *comma = "";
    for (int link = 0; link < s->linkage.n_link; link++)
        for (int panel = 0; panel < d->n_view; panel++)
            if (link != s->linkage.ground && moves_in(d, link, panel)) {
                lw_bytes_text(b, comma);
                motion_of(b, s, &d->view[panel], link, panel);
                comma = ",\n";
            }
    lw_bytes_text(b, "]}");
}

/* ==== the page ================================================================================================ */

static bool same(const char *a, const char *b)
{
    return a && b && strcmp(a, b) == 0;
}

static void head(lw_bytes *b, const lw_page *p, const lw_bytes *style, const lw_bytes *script)
{
    lw_page_head(b, p->title, style, script, false);
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
        "<input type=\"range\" class=\"time\" min=\"0\" max=\"1\" step=\"any\" value=\"0\" aria-label=\"Place in the motion\">\n"
        "<label>Speed <select class=\"speed\"><option value=\"0.25\">1/4</option>"
        "<option value=\"0.5\">1/2</option><option value=\"1\" selected>1</option><option value=\"2\">2</option></select></label>\n"
        "<label><input type=\"checkbox\" class=\"names\" checked> Labels</label>\n</div>\n");
}

/* Write the drawing of one result, and add its motion to the list of all motions. */
static lw_status figure(lw_bytes *b, lw_bytes *motions, const lw_page *p, int target, int result, int *n_motion, lw_error *e)
{
    const lw_page_result *r = &p->target[target].result[result];
    lw_diagram_options o = lw_diagram_options_default();
    o.width = 440;                       /* small, with large signs: legible on a phone too */
    o.height = 360;
    o.zoom = 1.25;
    o.title = o.dimensions = o.length_values = false;             /* the table shows them */
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
    write_motions(motions, r->scene, &d);
    ++*n_motion;
    lw_drawing_free(&d);
    return LW_OK;
}

static lw_status section(lw_bytes *b, lw_bytes *motions, const lw_page *p, int target, int *n_motion, lw_error *e)
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
    if (t->curves) {
        snprintf(open, sizeof open, "t%d-curves-", target + 1);
        lw_bytes_text(b, "<div class=\"curves\">\n");
        lw_svg_inline(t->curves, open, b);
        lw_bytes_text(b, "</div>\n");
    }
    results_table(b, t, target);
    lw_bytes_text(b, "</section>\n");
    return LW_OK;
}

/* Write body and script, which follow the head; motions is scratch. */
static lw_status body(lw_bytes *b, lw_bytes *motions, const lw_page *p, const lw_bytes *script, lw_error *e)
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

/* catalogues/draw/diagram_margins.c - what is written beside a diagram: labels, title, dimensions, scale bar, legend, notes. */
#include "catalogues/draw/diagram_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/number.h"
#include "base/real.h"
#include "catalogues/draw/body_shapes.h"
#include "catalogues/draw/symbols.h"
#include "catalogues/draw/views.h"

#define LABEL_SIZE 14.5
#define LENGTH_SIZE 12.5

/* Add a label that moves with a link: beside the line a b, or beside the point a if a = b. */
static void label(lw_sketch *k, lw_role role, int item, int link, const char *text, double size, lw_vec2 a, lw_vec2 b, double gap, lw_ink ink)
{
    lw_vec2 at;
    if (!lw_label_map_place(&k->map, text, size, a, b, gap, lw_sketch_view_box(&k->d->view[0]), &at))
        return;
    lw_shape *s = lw_drawing_text(k->d, role, text, at, size, 0);
    s->item = item;
    s->link = link == lw_sketch_linkage_of(k)->ground ? -1 : link;
    s->panel = 0;
    s->upright = true;
    s->hold = lw_v2_scale(lw_v2_add(a, b), 0.5);
    s->fill = ink;
    s->italic = role != LW_ROLE_LENGTH_LABEL;
}

static void label_points(lw_sketch *k)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    double u = k->u;
    for (int i = 0; i < l->n_tracer; i++) {
        lw_vec2 at = lw_sketch_pixel(k, 0, l->tracer[i].at);
        label(k, LW_ROLE_JOINT_LABEL, l->n_joint + i, l->tracer[i].link, l->tracer[i].name, LABEL_SIZE*u, at, at, 9*u, LW_INK_BLUE);
    }
    for (int i = 0; i < l->n_joint; i++) {
        const lw_joint *j = &l->joint[i];
        if (j->kind == LW_JOINT_FREE)
            continue;
        bool slides = lw_joint_translates(j->kind);
        lw_slide w = slides ? lw_body_shapes_slide(k->s, i) : (lw_slide){ .at = j->at };
        lw_cylinder c;
        if (slides && lw_body_shapes_cylinder(k->s, i, &c)) {
            w.at = lw_v2_add(c.pin[0], lw_v2_scale(c.along, 0.5*c.tube_length));
            w.block = c.tube;
        }
        lw_vec2 at = lw_sketch_pixel(k, 0, w.at);
        int link = slides ? w.block : lw_sketch_on_ground(l, j) ? l->ground : j->link[1];
        label(k, LW_ROLE_JOINT_LABEL, i, link, j->name, LABEL_SIZE*u, at, at, (slides ? 17 : 10)*u, LW_INK_TEXT);
    }
}

/* Find the two nodes of a link whose distance is `length`: the label of dimension "r<k>" stands between them. */
static bool find_length(const lw_sketch *k, int link, double length, lw_vec2 *a, lw_vec2 *b)
{
    const lw_vec2 *node = k->node;
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++)
            if (fabs(lw_v2_norm(lw_v2_sub(node[i], node[j])) - length) <= 1e-6*length) {
                *a = node[i];
                *b = node[j];
                return true;
            }
    return false;
}

static void label_length(lw_sketch *k, int link, const char *name, double length, lw_vec2 a, lw_vec2 b)
{
    char number[32], text[64];
    lw_number_text(number, length/lw_sketch_linkage_of(k)->units.metre, 4);
    bool both = name[0] && k->o->length_values;
    snprintf(text, sizeof text, "%s%s%s", name, both ? " = " : "", both || !name[0] ? number : "");
    lw_vec2 p = lw_sketch_pixel(k, 0, a), q = lw_sketch_pixel(k, 0, b);
    label(k, LW_ROLE_LENGTH_LABEL, link, link, text, LENGTH_SIZE*k->u, p, q, 6*k->u, LW_INK_FAINT);
}

static void label_lengths(lw_sketch *k)
{
    const lw_scene *s = k->s;
    lw_vec2 a, b;
    for (int i = 0; i < s->n_dim; i++)
        if (s->dim_kind[i] == LW_DIM_LENGTH && find_length(k, s->dim_link[i], s->dim[i], &a, &b))
            label_length(k, s->dim_link[i], s->dim_name[i], s->dim[i], a, b);
    for (int link = 0; s->n_dim == 0 && link < s->linkage.n_link; link++) {
        const lw_vec2 *node = k->node;
        if (link != s->linkage.ground && lw_body_shapes_nodes(s, link, k->node, k->room) == 2)
            label_length(k, link, "", lw_v2_norm(lw_v2_sub(node[0], node[1])), node[0], node[1]);
    }
}

void lw_sketch_labels(lw_sketch *k)
{
    label_points(k);
    if (k->o->length_labels)
        label_lengths(k);
}

/* ==== margins ================================================================================================= */

static void faint_line(lw_sketch *k, const char *text, double y)
{
    lw_drawing_text(k->d, LW_ROLE_NOTE, text, lw_v2(16*k->u, y), 12.5*k->u, 0)->fill = LW_INK_FAINT;
}

/* Text of dimension i, such as "r2 = 1.25", in the units of the file. */
static void dimension_text(const lw_scene *s, int i, char *text, size_t size)
{
    char number[32];
    lw_number_text(number, lw_scene_dimension(s, i), 5);
    snprintf(text, size, "%s = %s", s->dim_name[i], number);
}

/* Write the dimensions in at most four lines of the page's width. Returns the base line below them. */
static double list_dimensions(lw_sketch *k, double y)
{
    const lw_scene *s = k->s;
    char line[512] = "", item[64];
    double width = k->d->width - 32*k->u;
    int n_line = 0;
    for (int i = 0; i <= s->n_dim; i++) {
        if (i < s->n_dim)
            dimension_text(s, i, item, sizeof item);
        else
            snprintf(item, sizeof item, "[%s, %s]",
                     s->linkage.units.length[0] ? s->linkage.units.length : "length units",
                     s->linkage.units.angle[0] ? s->linkage.units.angle : "rad");
        size_t used = strlen(line);
        char longer[sizeof line + sizeof item + 4];
        snprintf(longer, sizeof longer, "%s%s%s", line, used ? "  " : "", item);
        if (used && (lw_text_width(longer, 12.5*k->u) > width || strlen(longer) >= sizeof line)) {
            faint_line(k, line, y);
            y += 17*k->u;
            snprintf(longer, sizeof longer, "%s", ++n_line == 4 ? "" : item);
        }
        memcpy(line, longer, strlen(longer) + 1);
        if (n_line == 4)
            return y;
    }
    faint_line(k, line, y);
    return y + 17*k->u;
}

/* Cut text to a width [px] and end it with three dots. */
static void shorten(char *text, double size, double width)
{
    size_t n = strlen(text);
    if (lw_text_width(text, size) <= width)
        return;
    while (n > 0 && lw_text_width(text, size) + 1.2*size > width) {
        do
            n--;
        while (n > 0 && ((unsigned char)text[n] & 0xc0) == 0x80);
        text[n] = 0;
    }
    memcpy(text + n, "...", 4);
}

double lw_sketch_header(lw_sketch *k)
{
    lw_drawing *d = k->d;
    double u = k->u, y = 14*u;
    lw_vec2 page[4] = { { 0, 0 }, { d->width, 0 }, { d->width, d->height }, { 0, d->height } };
    lw_drawing_path(d, LW_ROLE_PAPER, page, 4, true)->fill = LW_INK_PAPER;
    char title[sizeof k->s->title + 4];
    lw_text_clean(title, sizeof title - 4, k->s->title);
    if (title[0] && k->o->title) {
        shorten(title, 19*u, d->width - 32*u);
        y += 16*u;
        lw_drawing_text(d, LW_ROLE_TITLE, title, lw_v2(16*u, y), 19*u, 0)->bold = true;
        y += 21*u;
    } else if (k->o->dimensions)
        y += 8*u;
    if (k->o->dimensions && k->s->n_dim > 0)
        y = list_dimensions(k, y);
    return y - 8*u;
}

static void scale_bar(lw_sketch *k, int panel)
{
    const lw_view *v = &k->d->view[panel];
    const lw_units *units = &k->s->linkage.units;
    double u = k->u, px = v->scale*units->metre;                     /* [px] per unit of the file */
    lw_vec2 at = lw_v2(v->x + 16*u, v->y + v->h - 12*u);
    double w = lw_symbol_scale_bar(k->d, (lw_bearer){ panel, -1, -1 }, at, px, 0.24*v->w, units->length, "", u);
    if (w > 0)
        lw_label_map_take(&k->map, (lw_box){ at.x - 4, at.y - 16*u, at.x + w + 5*u, v->y + v->h });
}

/* The entries of the legend, from right to left: what each one shows, its text, width of its sample [px]. */
typedef enum lw_sample { TARGET, OTHER, COMPARED, TRACED, N_SAMPLE } lw_sample;
static const struct { const char *text; double room; } samples[N_SAMPLE] = {
    [TARGET] = { "target", 36 }, [OTHER] = { "also possible", 52 }, [COMPARED] = { "second linkage", 52 },
    [TRACED] = { "traced curve", 52 },
};

static bool is_shown(const lw_scene *s, lw_sample sample)
{
    if (sample == TARGET)
        return s->n_station > 0;
    for (int i = 0; i < s->n_curve; i++)
        if (s->curve[i].compared ? sample == COMPARED : sample != COMPARED && s->curve[i].shown_branch == (sample == TRACED))
            return true;
    return false;
}

static double legend_width(const lw_sketch *k)
{
    double w = 0;
    for (int i = 0; i < N_SAMPLE; i++)
        if (is_shown(k->s, (lw_sample)i))
            w += lw_text_width(samples[i].text, 12*k->u) + samples[i].room*k->u;
    return w;
}

double lw_sketch_foot_height(const lw_sketch *k, double width)
{
    bool beside = legend_width(k) + 0.24*width + 130*k->u < width;
    return (beside ? 30 : 48)*k->u;
}

/* Draw one entry that ends at x. Returns where the entry left of it ends. */
static double entry(lw_sketch *k, double x, double y, lw_sample sample)
{
    double u = k->u, left = x - lw_text_width(samples[sample].text, 12*u);
    lw_drawing_text(k->d, LW_ROLE_LEGEND, samples[sample].text, lw_v2(left, y), 12*u, 0);
    if (sample == TARGET)
        lw_symbol_station(k->d, LW_ROLE_LEGEND, (lw_bearer){ -1, -1, -1 },
                          lw_v2(left - 14*u, y - 4*u), u);
    else {
        lw_shape *s = lw_drawing_line(k->d, LW_ROLE_LEGEND, lw_v2(left - 34*u, y - 4*u), lw_v2(left - 8*u, y - 4*u));
        s->stroke = sample == COMPARED ? LW_INK_RED : LW_INK_BLUE;
        s->width = (sample == TRACED ? 2.6 : 1.6)*u;
        s->dashed = sample == OTHER;
    }
    return left - samples[sample].room*u;
}

/* Draw the legend in the last panel: beside the scale bar, or above it where the panel is narrow. */
static void legend(lw_sketch *k)
{
    const lw_view *v = &k->d->view[k->d->n_view - 1];
    double u = k->u, end = v->x + v->w - 14*u, x = end;
    double y = v->y + v->h - lw_sketch_foot_height(k, v->w) + 18*u;
    for (int i = 0; i < N_SAMPLE; i++)
        if (is_shown(k->s, (lw_sample)i))
            x = entry(k, x, y, (lw_sample)i);
    if (x < end)
        lw_label_map_take(&k->map, (lw_box){ x, y - 16*u, end, v->y + v->h });
}

void lw_sketch_feet(lw_sketch *k)
{
    for (int i = 0; i < k->d->n_view; i++)
        scale_bar(k, i);
    legend(k);
    const lw_view *v = &k->d->view[0];
    if (k->s->note[0] == 0)
        return;
    char note[sizeof k->s->note + 4];
    double u = k->u, y = v->y + v->h - 6*u - lw_sketch_foot_height(k, v->w);
    lw_text_clean(note, sizeof note - 4, k->s->note);
    shorten(note, 12*u, v->w - 32*u);
    lw_drawing_text(k->d, LW_ROLE_NOTE, note, lw_v2(16*u, y), 12*u, 0)->fill = LW_INK_FAINT;
    lw_label_map_take(&k->map, (lw_box){ 12*u, y - 14*u, 20*u + lw_text_width(note, 12*u), y + 5*u });
}

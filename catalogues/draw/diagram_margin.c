/* catalogues/draw/diagram_margin.c - what stands around a diagram: title, dimensions, scale bars, legend */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/bytes.h"
#include "catalogues/draw/diagram_internal.h"
#include "catalogues/draw/symbols.h"

static void faint_line(lw_sketch *k, const char *text, double y)
{
    lw_drawing_text(k->d, LW_ROLE_NOTE, text, lw_v2(16*k->u, y), 12.5*k->u, 0)->fill = LW_INK_FAINT;
}

/* "r2 = 1.25" in the units of the file. */
static void dimension_text(const lw_scene *s, int i, char *text, size_t size)
{
    char number[32];
    lw_number_text(number, lw_scene_dimension(s, i), 5);
    snprintf(text, size, "%s = %s", s->dim_name[i], number);
}

/* The dimensions in lines as wide as the page, four at most; returns the base line after them. */
static double list_dimensions(lw_sketch *k, double y)
{
    const lw_scene *s = k->s;
    char line[512] = "", item[64];
    double room = k->d->width - 32*k->u;
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
        if (used && (lw_text_width(longer, 12.5*k->u) > room || strlen(longer) >= sizeof line)) {
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

/* Cut text to a width [px], with three dots. */
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

/* The greatest of 1, 2, 5 times a power of ten that is no more than v. */
static double round_down(double v)
{
    double power = pow(10, floor(log10(v))), m = v/power;
    return power*(m >= 5 ? 5 : m >= 2 ? 2 : 1);
}

static void scale_bar(lw_sketch *k, int panel)
{
    const lw_view *v = &k->d->view[panel];
    const lw_units *units = &k->s->linkage.units;
    double u = k->u, px = v->scale*units->metre;                     /* [px] a unit of the file */
    double length = round_down(0.24*v->w/px);
    if (!isfinite(length) || !(length > 0))
        return;
    double x = v->x + 16*u, y = v->y + v->h - 12*u, w = length*px;
    lw_vec2 bar[4] = { { x, y - 5*u }, { x, y }, { x + w, y }, { x + w, y - 5*u } };
    lw_shape *s = lw_drawing_path(k->d, LW_ROLE_SCALE, bar, 4, false);
    s->stroke = LW_INK_TEXT;
    s->width = 1.5*u;
    s->item = panel;
    char number[32], text[48];
    lw_number_text(number, length, 3);
    snprintf(text, sizeof text, "%s%s%s", number, units->length[0] ? " " : "", units->length);
    lw_drawing_text(k->d, LW_ROLE_SCALE, text, lw_v2(x + w + 7*u, y), 12*u, 0);
    lw_label_map_take(&k->map, (lw_box){ x - 4, y - 16*u, x + w + 12*u + lw_text_width(text, 12*u),
                                         v->y + v->h });
}

/* The entries of the legend, from the right: what it shows, its text, room for the sample [px]. */
typedef enum lw_sample { TARGET, OTHER, TRACED, N_SAMPLE } lw_sample;
static const struct { const char *text; double room; } samples[N_SAMPLE] = {
    [TARGET] = { "target", 36 }, [OTHER] = { "also possible", 52 }, [TRACED] = { "traced curve", 52 },
};

static bool is_shown(const lw_scene *s, lw_sample sample)
{
    if (sample == TARGET)
        return s->n_station > 0;
    for (int i = 0; i < s->n_curve; i++)
        if (s->curve[i].shown_branch == (sample == TRACED))
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

double lw_sketch_foot(const lw_sketch *k, double width)
{
    bool beside = legend_width(k) + 0.24*width + 130*k->u < width;
    return (beside ? 30 : 48)*k->u;
}

/* One entry that ends at x; returns where the next may end. */
static double entry(lw_sketch *k, double x, double y, lw_sample sample)
{
    double u = k->u, left = x - lw_text_width(samples[sample].text, 12*u);
    lw_drawing_text(k->d, LW_ROLE_LEGEND, samples[sample].text, lw_v2(left, y), 12*u, 0);
    if (sample == TARGET)
        lw_symbol_station(k->d, LW_ROLE_LEGEND, (lw_bearer){ -1, -1, -1 },
                          lw_v2(left - 14*u, y - 4*u), u);
    else {
        lw_shape *s = lw_drawing_line(k->d, LW_ROLE_LEGEND, lw_v2(left - 34*u, y - 4*u),
                                      lw_v2(left - 8*u, y - 4*u));
        s->stroke = LW_INK_BLUE;
        s->width = (sample == OTHER ? 1.6 : 2.6)*u;
        s->dashed = sample == OTHER;
    }
    return left - samples[sample].room*u;
}

/* In the last panel, beside its scale bar, or above it where it is narrow. */
static void legend(lw_sketch *k)
{
    const lw_view *v = &k->d->view[k->d->n_view - 1];
    double u = k->u, end = v->x + v->w - 14*u, x = end;
    double y = v->y + v->h - lw_sketch_foot(k, v->w) + 18*u;
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
    double u = k->u, y = v->y + v->h - 6*u - lw_sketch_foot(k, v->w);
    lw_text_clean(note, sizeof note - 4, k->s->note);
    shorten(note, 12*u, v->w - 32*u);
    lw_drawing_text(k->d, LW_ROLE_NOTE, note, lw_v2(16*u, y), 12*u, 0)->fill = LW_INK_FAINT;
    lw_label_map_take(&k->map, (lw_box){ 12*u, y - 14*u, 20*u + lw_text_width(note, 12*u), y + 5*u });
}

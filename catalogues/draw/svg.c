/* catalogues/draw/svg.c - see svg.h */
#include "catalogues/draw/svg.h"

#include <stdio.h>
#include <string.h>
#include "base/real.h"

#define FONT "DejaVu Sans,Verdana,Arial,sans-serif"

static void number(lw_bytes *b, const char *before, double v, const char *after)
{
    lw_bytes_text(b, before);
    lw_bytes_fixed(b, v, 2);
    lw_bytes_text(b, after);
}

static void colour(lw_bytes *b, const char *attribute, lw_ink ink)
{
    char t[48];
    if (ink == LW_INK_NONE)
        snprintf(t, sizeof t, " %s=\"none\"", attribute);
    else
        snprintf(t, sizeof t, " %s=\"#%06x\"", attribute, lw_ink_light(ink));
    lw_bytes_text(b, t);
}

/* Write class, data attributes and colours: as attributes, or by class if the page's style sheet sets them. */
static void common(lw_bytes *b, const lw_shape *s, bool by_class)
{
    char t[160];
    snprintf(t, sizeof t, " class=\"%s", lw_role_name(s->role));
    lw_bytes_text(b, t);
    if (by_class && s->fill != LW_INK_NONE) {
        lw_bytes_text(b, " f-");
        lw_bytes_text(b, lw_ink_name(s->fill));
    }
    if (by_class && s->stroke != LW_INK_NONE) {
        lw_bytes_text(b, " s-");
        lw_bytes_text(b, lw_ink_name(s->stroke));
    }
    lw_bytes_text(b, "\"");
    if (s->item >= 0 && (snprintf(t, sizeof t, " data-item=\"%d\"", s->item), true))
        lw_bytes_text(b, t);
    if (s->tie >= 0) {
        snprintf(t, sizeof t, " data-ends=\"%d %d\" data-panel=\"%d\"%s", s->link, s->tie, s->panel, s->rigid ? " data-rigid=\"1\"" : "");
        lw_bytes_text(b, t);
        number(b, " data-line=\"", s->at.x, " ");
        number(b, "", s->at.y, " ");
        number(b, "", s->hold.x, " ");
        number(b, "", s->hold.y, "\"");
    } else if (s->link >= 0) {
        snprintf(t, sizeof t, " data-link=\"%d\" data-panel=\"%d\"", s->link, s->panel);
        lw_bytes_text(b, t);
        if (s->upright) {
            number(b, " data-hold=\"", s->hold.x, " ");
            number(b, "", s->hold.y, "\"");
        }
    }
    if (!by_class) {
        colour(b, "fill", s->fill);
        if (s->stroke != LW_INK_NONE)
            colour(b, "stroke", s->stroke);
    }
    if (s->fill != LW_INK_NONE && s->alpha < 1)
        number(b, " fill-opacity=\"", s->alpha, "\"");
    if (s->stroke != LW_INK_NONE && s->kind != LW_SHAPE_TEXT) {
        number(b, " stroke-width=\"", s->width, "\"");
        if (s->dashed)
            lw_bytes_text(b, " stroke-dasharray=\"6 4\"");
    }
}

static void path(lw_bytes *b, const lw_drawing *d, const lw_shape *s, bool by_class)
{
    if (s->n == 2 && !s->closed && s->tie < 0) {           /* pages move the points of those between two links */
        const lw_vec2 *p = d->point + s->first;
        number(b, "<line x1=\"", p[0].x, "\"");
        number(b, " y1=\"", p[0].y, "\"");
        number(b, " x2=\"", p[1].x, "\"");
        number(b, " y2=\"", p[1].y, "\"");
    } else {
        lw_bytes_text(b, s->closed ? "<polygon points=\"" : "<polyline points=\"");
        for (size_t i = 0; i < s->n; i++) {
            number(b, i ? " " : "", d->point[s->first + i].x, ",");
            number(b, "", d->point[s->first + i].y, "");
        }
        lw_bytes_text(b, "\"");
    }
    common(b, s, by_class);
    lw_bytes_text(b, "/>\n");
}

static void circle(lw_bytes *b, const lw_shape *s, bool by_class)
{
    number(b, "<circle cx=\"", s->at.x, "\"");
    number(b, " cy=\"", s->at.y, "\"");
    number(b, " r=\"", s->radius, "\"");
    common(b, s, by_class);
    lw_bytes_text(b, "/>\n");
}

static void text(lw_bytes *b, const lw_drawing *d, const lw_shape *s, bool by_class)
{
    number(b, "<text x=\"", s->at.x, "\"");
    number(b, " y=\"", s->at.y, "\"");
    number(b, " font-size=\"", s->width, "\"");
    if (s->align > 0)
        lw_bytes_text(b, s->align > 0.75 ? " text-anchor=\"end\"" : " text-anchor=\"middle\"");
    if (s->bold)
        lw_bytes_text(b, " font-weight=\"bold\"");
    if (s->italic)
        lw_bytes_text(b, " font-style=\"italic\"");
    if (s->turn != 0) {
        number(b, " transform=\"rotate(", s->turn*180/LW_PI, " ");
        number(b, "", s->at.x, " ");
        number(b, "", s->at.y, ")\"");
    }
    common(b, s, by_class);
    lw_bytes_text(b, ">");
    lw_bytes_xml(b, d->text + s->first);
    lw_bytes_text(b, "</text>\n");
}

static void clip_paths(lw_bytes *b, const lw_drawing *d, const char *prefix)
{
    char t[96];
    for (int i = 0; i < d->n_view; i++) {
        const lw_view *v = &d->view[i];
        snprintf(t, sizeof t, "<clipPath id=\"%sclip%d\">", prefix, i);
        lw_bytes_text(b, t);
        number(b, "<rect x=\"", v->x, "\"");
        number(b, " y=\"", v->y, "\"");
        number(b, " width=\"", v->w, "\"");
        number(b, " height=\"", v->h, "\"/></clipPath>\n");
    }
}

/* Write shapes in order. Runs of shapes in one panel are clipped to its box. */
static void shapes(lw_bytes *b, const lw_drawing *d, const char *prefix, bool by_class)
{
    int open = -1;
    for (size_t i = 0; i < d->n_shape; i++) {
        const lw_shape *s = &d->shape[i];
        int wanted = s->panel < d->n_view ? s->panel : -1;
        if (wanted != open) {
            char t[96];
            if (open >= 0)
                lw_bytes_text(b, "</g>\n");
            if (wanted >= 0) {
                snprintf(t, sizeof t, "<g clip-path=\"url(#%sclip%d)\">\n", prefix, wanted);
                lw_bytes_text(b, t);
            }
            open = wanted;
        }
        switch (s->kind) {
        case LW_SHAPE_PATH:   path(b, d, s, by_class); break;
        case LW_SHAPE_CIRCLE: circle(b, s, by_class); break;
        case LW_SHAPE_TEXT:   text(b, d, s, by_class); break;
        }
    }
    if (open >= 0)
        lw_bytes_text(b, "</g>\n");
}

static void element(lw_bytes *b, const lw_drawing *d, const char *prefix, bool by_class)
{
    lw_bytes_text(b, "<svg xmlns=\"http://www.w3.org/2000/svg\"");
    number(b, by_class ? " viewBox=\"0 0 " : " version=\"1.1\" viewBox=\"0 0 ", d->width, " ");
    number(b, "", d->height, "\"");
    if (!by_class) {
        number(b, " width=\"", d->width, "\"");
        number(b, " height=\"", d->height, "\"");
    }
    lw_bytes_text(b, " role=\"img\" font-family=\"" FONT "\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<title>");
    lw_bytes_xml(b, d->title);
    lw_bytes_text(b, "</title>\n<desc>");
    lw_bytes_xml(b, d->about);
    lw_bytes_text(b, "</desc>\n");
    clip_paths(b, d, prefix);
    shapes(b, d, prefix, by_class);
    lw_bytes_text(b, "</svg>\n");
}

lw_status lw_svg_write(const lw_drawing *d, lw_bytes *out, lw_error *e)
{
    *out = (lw_bytes){ 0 };
    lw_bytes_text(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    element(out, d, "", false);
    return lw_bytes_end(out, e);
}

void lw_svg_inline(const lw_drawing *d, const char *prefix, lw_bytes *out)
{
    element(out, d, prefix, true);
}

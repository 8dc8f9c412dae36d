/* catalogues/pages/draw.c - see draw.h */
#include "catalogues/pages/draw.h"

#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/real.h"
#include "catalogues/draw/diagram.h"
#include "catalogues/draw/gif.h"
#include "catalogues/pages/page.h"
#include "catalogues/pages/space_page.h"
#include "catalogues/draw/picture.h"
#include "catalogues/draw/svg.h"

lw_status lw_draw_kind_of(const char *path, lw_draw_kind *kind, lw_error *e)
{
    static const char *const end[] = { [LW_DRAW_SVG] = "svg", [LW_DRAW_PDF] = "pdf",
                                       [LW_DRAW_PNG] = "png", [LW_DRAW_GIF] = "gif",
                                       [LW_DRAW_HTML] = "html" };
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; i < sizeof end/sizeof *end; i++)
        if (strcasecmp(dot ? dot + 1 : path, end[i]) == 0) {
            *kind = (lw_draw_kind)i;
            return LW_OK;
        }
    return lw_error_set(e, LW_E_ARG, "\"%.200s\" does not say what kind of picture it is to be: end it "
                        "in .svg, .pdf, .png, .gif or .html", path);
}

lw_status lw_draw_still(const lw_drawing *d, lw_draw_kind kind, lw_bytes *out, lw_error *e)
{
    switch (kind) {
    case LW_DRAW_SVG: return lw_svg_write(d, out, e);
    case LW_DRAW_PDF: return lw_picture_pdf(d, out, e);
    case LW_DRAW_PNG: return lw_picture_png(d, out, e);
    default:          return lw_error_set(e, LW_E_ARG, "a still drawing goes to .svg, .pdf or .png");
    }
}

static lw_status still(const lw_scene *s, lw_draw_kind kind, int width, int height, lw_bytes *out, lw_error *e)
{
    lw_diagram_options o = lw_diagram_options_default();
    o.width = width > 0 ? width : o.width;
    o.height = height > 0 ? height : o.height;
    lw_drawing d;
    lw_status st = lw_diagram_draw(s, &o, &d, e);
    if (st != LW_OK)
        return st;
    st = lw_draw_still(&d, kind, out, e);
    lw_drawing_free(&d);
    return st;
}

static lw_status page(const lw_scene *s, lw_bytes *out, lw_error *e)
{
    lw_page_result r = { .scene = s, .transmission_min = NAN, .objective = NAN, .error_mean = NAN, .error_max = NAN,
                         .angle_mean = NAN, .angle_max = NAN, .error_percent = NAN };
    lw_page_target t = { .name = s->linkage.name, .n_result = 1, .result = &r };
    lw_page p = { .title = s->title, .n_target = 1, .target = &t };
    return lw_page_write(&p, out, e);
}

lw_status lw_draw_bytes(const lw_scene *s, lw_draw_kind kind, int width, int height, lw_bytes *out, lw_error *e)
{
    *out = (lw_bytes){ 0 };
    if (kind == LW_DRAW_HTML)
        return page(s, out, e);
    if (kind != LW_DRAW_GIF)
        return still(s, kind, width, height, out, e);
    lw_gif_options o = lw_gif_options_default();
    o.width = width > 0 ? width : o.width;
    o.height = height > 0 ? height : o.height;
    return lw_gif_write(s, &o, out, e);
}

typedef struct space_film { const lw_space_scene *s; lw_space_view view; int width, height; } space_film;

static lw_status render_space(void *context, size_t frame, uint32_t *pixel, lw_error *e)
{
    space_film *f = context;
    lw_drawing d;
    lw_status st = lw_space_draw(f->s, frame, f->view, f->width, f->height, &d, e);
    if (st == LW_OK)
        st = lw_picture_pixels(&d, NULL, 0, pixel, e);
    lw_drawing_free(&d);
    return st;
}

lw_status lw_draw_space(const lw_space_scene *s, lw_space_view view, lw_draw_kind kind, int width, int height, lw_bytes *out, lw_error *e)
{
    lw_gif_options o = lw_gif_options_default();
    lw_diagram_options page = lw_diagram_options_default();
    lw_drawing d;
    *out = (lw_bytes){ 0 };
    view.names = kind != LW_DRAW_GIF;
    if (kind == LW_DRAW_HTML)
        return lw_space_page_write(s, view, out, e);
    if (kind == LW_DRAW_GIF) {
        bool forward = s->loops || s->ends;
        if (s->seconds > 0)
            o = lw_gif_options_in_time(s->n_frame, s->seconds, NULL);
        o.n_frame *= s->seconds > 0 && !forward ? 2 : 1;       /* there and back */
        o.width = width > 0 ? width : o.width;
        o.height = height > 0 ? height : o.height;
        space_film f = { s, view, o.width, o.height };
        lw_gif_motion motion = { .n_frame = s->n_frame, .loops = forward, .stop = s->stop, .render = render_space, .context = &f };
        return lw_gif_encode(&motion, &o, out, e);
    }
    lw_status st = lw_space_draw(s, 0, view, width > 0 ? width : (int)page.width, height > 0 ? height : (int)page.height, &d, e);
    if (st != LW_OK)
        return st;
    st = lw_draw_still(&d, kind, out, e);
    lw_drawing_free(&d);
    return st;
}

lw_status lw_draw_save(const lw_scene *s, lw_draw_kind kind, const char *path, int width, int height, lw_error *e)
{
    lw_bytes b;
    lw_status st = lw_draw_bytes(s, kind, width, height, &b, e);
    if (st == LW_OK)
        st = lw_file_write(path, b.data, b.size, e);
    lw_bytes_free(&b);
    return st;
}

lw_status lw_draw_drawing(const lw_drawing *d, const char *path, lw_error *e)
{
    lw_draw_kind kind = LW_DRAW_SVG;
    lw_bytes b = { 0 };
    lw_status st = lw_draw_kind_of(path, &kind, e);
    if (st == LW_OK)
        st = lw_draw_still(d, kind, &b, e);
    if (st == LW_OK)
        st = lw_file_write(path, b.data, b.size, e);
    lw_bytes_free(&b);
    return st;
}

lw_status lw_draw_plots(int n, const lw_plot *p, const char *path, lw_error *e)
{
    lw_drawing d;
    lw_status st = lw_plot_draw_stack(n, p, &d, e);
    if (st < 0)
        return st;
    st = lw_draw_drawing(&d, path, e);
    lw_drawing_free(&d);
    return st;
}

lw_status lw_draw_plot(const lw_plot *p, const char *path, lw_error *e) { return lw_draw_plots(1, p, path, e); }

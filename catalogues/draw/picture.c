/* catalogues/draw/picture.c - see picture.h */
#include "catalogues/draw/picture.h"

#include <cairo-pdf.h>
#include <cairo.h>
#include <errno.h>
#include <pthread.h>
#include <string.h>
#include <unistd.h>
#include "base/library.h"
#include "base/real.h"

/* cairo and its libraries are loaded with the first picture (base/library.h). */
#define CALLS(X) \
    X(arc) X(clip) X(close_path) X(create) X(destroy) X(fill_preserve) X(font_options_create) \
    X(font_options_destroy) X(font_options_set_antialias) X(font_options_set_hint_metrics) \
    X(font_options_set_hint_style) X(image_surface_create) X(image_surface_get_data) X(image_surface_get_stride) \
    X(line_to) X(matrix_init) X(move_to) X(new_path) X(new_sub_path) X(pdf_surface_create_for_stream) \
    X(pdf_surface_set_metadata) X(pdf_surface_set_size) X(rectangle) X(restore) X(rotate) X(save) X(scale) \
    X(select_font_face) X(set_dash) X(set_font_options) X(set_font_size) X(set_line_cap) X(set_line_join) \
    X(set_line_width) X(set_source_rgba) X(show_page) X(show_text) X(status) X(status_to_string) \
    X(stroke_preserve) X(surface_destroy) X(surface_finish) X(surface_flush) X(surface_status) \
    X(surface_write_to_png_stream) X(text_extents) X(transform) X(translate)

static struct {
#define X(f) __typeof__(cairo_##f) *f;
    CALLS(X)
#undef X
} cairo;
static pthread_once_t loading = PTHREAD_ONCE_INIT;
static lw_error       not_loaded;                /* status LW_OK: cairo is loaded */

static void load(void)
{
    static const lw_library_call call[] = {
#define X(f) { "cairo_" #f, &cairo.f },
        CALLS(X)
#undef X
    };
    not_loaded.status = lw_library_load("libcairo.so.2", "libcairo2", call, (int)(sizeof call/sizeof *call), &not_loaded);
}

/* fontconfig skips each of its files that it cannot open, and takes another font without a word: see that it can open some. */
static lw_status need_files(lw_error *e)
{
    enum { N_PIPE = 4 };                         /* its files include others, three deep */
    int end[N_PIPE][2], n = 0, why = 0;
    while (n < N_PIPE && pipe(end[n]) == 0)
        n++;
    if (n < N_PIPE)
        why = errno;
    for (int i = 0; i < n; i++) {
        close(end[i][0]);
        close(end[i][1]);
    }
    return why == 0 ? LW_OK : lw_error_set(e, LW_E_IO, "the files of fonts cannot be opened: %s", strerror(why));
}

static lw_status need_cairo(lw_error *e)
{
    pthread_once(&loading, load);
    return not_loaded.status == LW_OK ? need_files(e)
         : lw_error_set(e, not_loaded.status, "pictures other than SVG need cairo: %s", not_loaded.text);
}

static void set_ink(cairo_t *c, lw_ink ink, double alpha)
{
    unsigned rgb = lw_ink_light(ink);
    cairo.set_source_rgba(c, (rgb >> 16 & 255)/255.0, (rgb >> 8 & 255)/255.0, (rgb & 255)/255.0, alpha);
}

static void paint_outline(cairo_t *c, const lw_shape *s)
{
    if (s->fill != LW_INK_NONE) {
        set_ink(c, s->fill, s->alpha);
        cairo.fill_preserve(c);
    }
    if (s->stroke != LW_INK_NONE) {
        static const double dash[] = { 6, 4 };
        set_ink(c, s->stroke, 1);
        cairo.set_line_width(c, s->width);
        cairo.set_dash(c, dash, s->dashed ? 2 : 0, 0);
        cairo.stroke_preserve(c);
    }
    cairo.new_path(c);
}

static void paint_path(cairo_t *c, const lw_drawing *d, const lw_shape *s)
{
    for (size_t i = 0; i < s->n; i++)
        cairo.line_to(c, d->point[s->first + i].x, d->point[s->first + i].y);
    if (s->closed)
        cairo.close_path(c);
    paint_outline(c, s);
}

static void paint_circle(cairo_t *c, const lw_shape *s)
{
    cairo.new_sub_path(c);
    cairo.arc(c, s->at.x, s->at.y, s->radius, 0, 2*LW_PI);
    paint_outline(c, s);
}

static void paint_text(cairo_t *c, const lw_drawing *d, const lw_shape *s)
{
    const char *text = d->text + s->first;
    cairo_text_extents_t size;
    cairo.select_font_face(c, "sans", s->italic ? CAIRO_FONT_SLANT_ITALIC : CAIRO_FONT_SLANT_NORMAL,
                           s->bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo.set_font_size(c, s->width);
    cairo.text_extents(c, text, &size);
    cairo.translate(c, s->at.x, s->at.y);
    cairo.rotate(c, s->turn);
    cairo.move_to(c, -s->align*size.x_advance, 0);
    set_ink(c, s->fill, s->alpha);
    cairo.show_text(c, text);
    cairo.new_path(c);
}

/* Write the path of a shape, moved with its link to the given frame. */
static void follow_link(cairo_t *c, const lw_drawing *d, const lw_shape *s, const lw_scene *scene, size_t frame)
{
    if (!scene || s->link < 0 || s->panel < 0 || s->panel >= d->n_view)
        return;
    const lw_view *v = &d->view[s->panel];
    for (int t = 0; t < scene->linkage.n_tracer && scene->n_bend > 0 && s->role == LW_ROLE_TRACER; t++)
        if (lw_v2_norm(lw_v2_sub(lw_view_pixel(v, scene->linkage.tracer[t].at), s->at)) < 0.01 && t < scene->n_curve) {
            lw_vec2 to = lw_view_pixel(v, scene->curve[t].p[frame]);         /* maybe inside a bar that bends */
            cairo.translate(c, to.x - s->at.x, to.y - s->at.y);
            return;
        }
    lw_page_motion m = lw_diagram_motion(scene, v, frame, s->link);
    if (s->upright) {
        lw_vec2 to = lw_v2_add(m.to, lw_v2_turn(lw_v2_sub(s->hold, m.from), m.turn));
        cairo.translate(c, to.x - s->hold.x, to.y - s->hold.y);
        return;
    }
    lw_vec2 shift = lw_v2_sub(m.to, lw_v2_turn(m.from, m.turn));
    cairo_matrix_t a;
    cairo.matrix_init(&a, m.turn.x, m.turn.y, -m.turn.y, m.turn.x, shift.x, shift.y);
    cairo.transform(c, &a);
}

static bool is_bar(const lw_drawing *d, const lw_shape *s)
{
    return s->kind == LW_SHAPE_PATH && s->role == LW_ROLE_LINK && !s->closed && s->panel >= 0 && s->panel < d->n_view;
}

/* The bars of a link that bends are lines through their points instead, all painted in place of the first; false: the shape is no such bar. */
static bool paint_bend(cairo_t *c, const lw_drawing *d, const lw_shape *s, const lw_scene *scene, size_t frame)
{
    bool bends = false, bar = scene && is_bar(d, s), first = s == d->shape || !is_bar(d, s - 1) || s[-1].link != s->link;
    for (int i = 0; bar && i < scene->n_bend; i++) {
        const lw_bent_bar *b = &scene->bend[i];
        if (b->link != s->link)
            continue;
        bends = true;
        cairo.new_sub_path(c);
        for (int k = 0; first && k < b->n; k++) {
            lw_vec2 p = lw_view_pixel(&d->view[s->panel], b->p[frame*(size_t)b->n + (size_t)k]);
            cairo.line_to(c, p.x, p.y);
        }
    }
    if (bends && first)
        paint_outline(c, s);
    return bends;
}

/* A path between two links: its ends move with them, its points stay in proportion along it, or as far if it is rigid, and as far aside. */
static bool paint_tie(cairo_t *c, const lw_drawing *d, const lw_shape *s, const lw_scene *scene, size_t frame)
{
    if (!scene || s->tie < 0 || s->panel < 0 || s->panel >= d->n_view)
        return false;
    const lw_vec2 *p = d->point + s->first;
    lw_vec2 old[2] = { s->at, s->hold }, now[2];
    for (int end = 0; end < 2; end++) {
        int link = end ? s->tie : s->link;
        lw_page_motion m = { .turn = { 1, 0 } };
        if (link >= 0 && link != scene->linkage.ground)
            m = lw_diagram_motion(scene, &d->view[s->panel], frame, link);
        now[end] = lw_v2_add(m.to, lw_v2_turn(lw_v2_sub(old[end], m.from), m.turn));
    }
    lw_vec2 was = lw_v2_sub(old[1], old[0]), is = lw_v2_sub(now[1], now[0]);
    double length = fmax(lw_v2_norm(was), 1e-9), now_long = fmax(lw_v2_norm(is), 1e-9);
    lw_vec2 across = lw_v2_scale(lw_v2_perp(is), 1/now_long);
    if (s->rigid)
        is = lw_v2_scale(is, length/now_long);
    for (size_t i = 0; i < s->n; i++) {
        lw_vec2 from = lw_v2_sub(p[i], old[0]);
        lw_vec2 to = lw_v2_add(lw_v2_add(now[0], lw_v2_scale(is, lw_v2_dot(from, was)/(length*length))),
                               lw_v2_scale(across, lw_v2_cross(was, from)/length));
        cairo.line_to(c, to.x, to.y);
    }
    paint_outline(c, s);
    return true;
}

/* Draw letters as the font defines them, without hints for a screen or its settings. */
static void set_font_options(cairo_t *c)
{
    cairo_font_options_t *o = cairo.font_options_create();
    cairo.font_options_set_antialias(o, CAIRO_ANTIALIAS_GRAY);
    cairo.font_options_set_hint_style(o, CAIRO_HINT_STYLE_NONE);
    cairo.font_options_set_hint_metrics(o, CAIRO_HINT_METRICS_OFF);
    cairo.set_font_options(c, o);
    cairo.font_options_destroy(o);
}

static void paint(cairo_t *c, const lw_drawing *d, const lw_scene *scene, size_t frame)
{
    set_font_options(c);
    cairo.set_line_cap(c, CAIRO_LINE_CAP_ROUND);
    cairo.set_line_join(c, CAIRO_LINE_JOIN_ROUND);
    for (size_t i = 0; i < d->n_shape; i++) {
        const lw_shape *s = &d->shape[i];
        cairo.save(c);
        if (s->panel >= 0 && s->panel < d->n_view) {
            const lw_view *v = &d->view[s->panel];
            cairo.rectangle(c, v->x, v->y, v->w, v->h);
            cairo.clip(c);
        }
        if (paint_tie(c, d, s, scene, frame) || paint_bend(c, d, s, scene, frame)) {
            cairo.restore(c);
            continue;
        }
        follow_link(c, d, s, scene, frame);
        switch (s->kind) {
        case LW_SHAPE_PATH:   paint_path(c, d, s); break;
        case LW_SHAPE_CIRCLE: paint_circle(c, s); break;
        case LW_SHAPE_TEXT:   paint_text(c, d, s); break;
        }
        cairo.restore(c);
    }
}

static cairo_status_t append(void *closure, const unsigned char *data, unsigned size)
{
    lw_bytes *out = closure;
    lw_bytes_add(out, data, size);
    return out->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

/* Turn cairo's status into ours; free the output after a failure. */
static lw_status outcome(cairo_status_t s, lw_bytes *out, lw_error *e)
{
    if (s == CAIRO_STATUS_SUCCESS)
        return out ? lw_bytes_end(out, e) : LW_OK;
    if (out)
        lw_bytes_free(out);
    return lw_error_set(e, s == CAIRO_STATUS_NO_MEMORY ? LW_E_MEMORY : LW_E_NUMERIC,
                        "the picture could not be drawn: %s", cairo.status_to_string(s));
}

/* Paint on a surface and destroy it. Returns the first failure. */
static cairo_status_t paint_on(cairo_surface_t *surface, const lw_drawing *d, const lw_scene *scene, size_t frame)
{
    cairo_t *c = cairo.create(surface);
    paint(c, d, scene, frame);
    cairo_status_t s = cairo.status(c);
    cairo.destroy(c);
    cairo.surface_flush(surface);
    return s ? s : cairo.surface_status(surface);
}

lw_status lw_picture_png(const lw_drawing *d, lw_bytes *out, lw_error *e)
{
    *out = (lw_bytes){ 0 };
    lw_status loaded = need_cairo(e);
    if (loaded != LW_OK)
        return loaded;
    cairo_surface_t *surface = cairo.image_surface_create(CAIRO_FORMAT_RGB24, (int)ceil(d->width), (int)ceil(d->height));
    cairo_status_t s = paint_on(surface, d, NULL, 0);
    if (!s)
        s = cairo.surface_write_to_png_stream(surface, append, out);
    cairo.surface_destroy(surface);
    return outcome(s, out, e);
}

lw_status lw_picture_pdf(const lw_drawing *d, lw_bytes *out, lw_error *e)
{
    return lw_picture_pdf_pages(d, 1, out, e);
}

lw_status lw_picture_pdf_pages(const lw_drawing *d, size_t n, lw_bytes *out, lw_error *e)
{
    *out = (lw_bytes){ 0 };
    lw_status loaded = need_cairo(e);
    if (loaded != LW_OK)
        return loaded;
    const double point = 0.75;                                   /* points of the page per CSS pixel */
    cairo_surface_t *surface = cairo.pdf_surface_create_for_stream(append, out, point*d->width, point*d->height);
    cairo.pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_TITLE, d->title);
    cairo.pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, NULL);
    cairo_t *c = cairo.create(surface);
    for (size_t i = 0; i < n && !cairo.status(c); i++) {
        cairo.pdf_surface_set_size(surface, point*d[i].width, point*d[i].height);
        cairo.save(c);
        cairo.scale(c, point, point);
        paint(c, &d[i], NULL, 0);
        cairo.restore(c);
        cairo.show_page(c);
    }
    cairo_status_t s = cairo.status(c);
    cairo.destroy(c);
    cairo.surface_finish(surface);
    s = s ? s : cairo.surface_status(surface);
    cairo.surface_destroy(surface);
    static const char mark[] = "%%EOF\n";                       /* cairo may leave out the end for lack of memory, and not say so */
    size_t last = sizeof mark - 1;
    if (!s && (out->failed || out->size < last || memcmp(out->data + out->size - last, mark, last) != 0))
        s = CAIRO_STATUS_NO_MEMORY;
    return outcome(s, out, e);
}

lw_status lw_picture_pixels(const lw_drawing *d, const lw_scene *scene, size_t frame, uint32_t *pixel, lw_error *e)
{
    int w = (int)ceil(d->width), h = (int)ceil(d->height);
    lw_status loaded = need_cairo(e);
    if (loaded != LW_OK)
        return loaded;
    cairo_surface_t *surface = cairo.image_surface_create(CAIRO_FORMAT_RGB24, w, h);
    cairo_status_t s = paint_on(surface, d, scene, frame);
    const unsigned char *row = cairo.image_surface_get_data(surface);
    for (int y = 0; !s && y < h; y++, row += cairo.image_surface_get_stride(surface)) {
        memcpy(pixel + (size_t)y*(size_t)w, row, (size_t)w*sizeof *pixel);
        for (int x = 0; x < w; x++)
            pixel[(size_t)y*(size_t)w + (size_t)x] &= 0xffffff;
    }
    cairo.surface_destroy(surface);
    return outcome(s, NULL, e);
}

/* Diagrams as SVG, PNG and PDF: read back, counted, measured, looked at pixel by pixel. */
#include <cairo.h>

#include "catalogues/draw/body_shapes.h"
#include "catalogues/draw/diagram.h"
#include "catalogues/draw/picture.h"
#include "catalogues/draw/svg.h"
#include "grammar/model/model.h"
#include "tests/check.h"
#include "tests/scene_models.h"
#include "tests/xml_scan.h"

/* What a scan of an SVG found. */
typedef struct found {
    int joints, links, pivots, stations, tracers, curves, sliders, labels;
    double station[64][2], joint[64][2];
} found;

static void middle_of(const char *points, double at[2])
{
    int n = 0;
    at[0] = at[1] = 0;
    for (char *s = (char *)points; *s; n++) {
        at[0] += strtod(s, &s);
        at[1] += strtod(s + 1, &s);
    }
    at[0] /= n;
    at[1] /= n;
}

static void count(const xml_element *e, void *context)
{
    found *f = context;
    int item = xml_get(e, "data-item") ? atoi(xml_get(e, "data-item")) : -1;
    f->links += xml_is(e, "link");
    f->pivots += xml_is(e, "ground");
    f->curves += xml_is(e, "curve");
    f->sliders += xml_is(e, "slider");
    f->tracers += xml_is(e, "tracer") && item >= 0;
    f->labels += strcmp(e->name, "text") == 0;
    if (xml_is(e, "joint") && item >= 0 && item < 64) {
        f->joint[item][0] = xml_number(e, "cx");
        f->joint[item][1] = xml_number(e, "cy");
        f->joints++;
    }
    if (xml_is(e, "station") && item >= 0 && item < 64) {
        middle_of(xml_get(e, "points"), f->station[item]);
        f->stations++;
    }
}

static found read_back(const lw_drawing *d)
{
    found f = { 0 };
    OWN(lw_bytes) b = { 0 };
    CHECK_OK(lw_svg_write(d, &b, &check_error));
    CHECK(xml_scan(b.data, count, &f) > 10);
    return f;
}

static lw_drawing draw(const lw_scene *s, double width, double height)
{
    lw_diagram_options o = lw_diagram_options_default();
    o.width = width;
    o.height = height;
    lw_drawing d;
    lw_error e = { .status = LW_OK };
    lw_status st = lw_diagram_draw(s, &o, &d, &e);
    CHECK_INT(st, LW_OK);
    if (st != LW_OK)
        fprintf(stderr, "%s\n", e.text);
    return d;
}

TEST(every_part_is_there_and_in_its_place)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 12, &s), LW_OK);
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    found f = read_back(&d);
    CHECK_INT(f.joints, 4);
    CHECK_INT(f.links, 3);
    CHECK_INT(f.pivots, 2);
    CHECK_INT(f.stations, 12);
    CHECK_INT(f.tracers, 1);
    CHECK_INT(f.curves, 1);
    for (int i = 0; i < 4; i++) {
        lw_vec2 p = lw_view_pixel(&d.view[0], s.linkage.joint[i].at);
        CHECK_NEAR(f.joint[i][0], p.x, 0.006, 0);
        CHECK_NEAR(f.joint[i][1], p.y, 0.006, 0);
    }
    for (int i = 0; i < 12; i++) {
        lw_vec2 p = lw_view_pixel(&d.view[0], s.station[i]);
        CHECK_NEAR(f.station[i][0], p.x, 0.006, 0);
        CHECK_NEAR(f.station[i][1], p.y, 0.006, 0);
        CHECK(p.x > 0 && p.x < 1000 && p.y > 0 && p.y < 750);
    }
}

/* All lengths are to one scale, y up. */
TEST(the_plane_is_not_distorted)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene(NULL, 0, &s), LW_OK);
    OWN(lw_drawing) d = draw(&s, 700, 900);
    found f = read_back(&d);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < i; k++) {
            lw_vec2 w = lw_v2_sub(s.linkage.joint[i].at, s.linkage.joint[k].at);
            CHECK_NEAR(f.joint[i][0] - f.joint[k][0], d.view[0].scale*w.x, 0.011, 0);
            CHECK_NEAR(f.joint[i][1] - f.joint[k][1], -d.view[0].scale*w.y, 0.011, 0);
        }
}

typedef struct text_box { double x0, y0, x1, y1; const char *text; } text_box;

/* Boxes of all texts, measured by cairo with the font that is there. */
static int measure_texts(const lw_drawing *d, text_box *box, int most)
{
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, 8, 8);
    cairo_t *c = cairo_create(surface);
    cairo_font_options_t *options = cairo_font_options_create();
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(c, options);
    cairo_font_options_destroy(options);
    int n = 0;
    for (size_t i = 0; i < d->n_shape && n < most; i++) {
        const lw_shape *s = &d->shape[i];
        if (s->kind != LW_SHAPE_TEXT)
            continue;
        const char *t = d->text + s->first;
        cairo_text_extents_t size;
        cairo_select_font_face(c, "sans", s->italic ? CAIRO_FONT_SLANT_ITALIC : CAIRO_FONT_SLANT_NORMAL,
                               s->bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_font_size(c, s->width);
        cairo_text_extents(c, t, &size);
        double x = s->at.x - s->align*size.x_advance + size.x_bearing, y = s->at.y + size.y_bearing;
        box[n++] = (text_box){ x, y, x + size.width, y + size.height, t };
        bool wide = !s->bold && size.width > lw_text_width(t, s->width);
        CHECK(!wide);
        if (wide)
            fprintf(stderr, "\"%s\" is %g wide, not %g\n", t, size.width, lw_text_width(t, s->width));
    }
    cairo_destroy(c);
    cairo_surface_destroy(surface);
    return n;
}

static void check_texts(const lw_drawing *d, const char *name)
{
    text_box b[300];
    int n = measure_texts(d, b, 300);
    CHECK(n > 4);
    for (int i = 0; i < n; i++) {
        bool inside = b[i].x0 >= 0 && b[i].y0 >= 0 && b[i].x1 <= d->width && b[i].y1 <= d->height;
        CHECK(inside);
        if (!inside)
            fprintf(stderr, "%s: \"%s\" is not on the page\n", name, b[i].text);
        for (int k = 0; k < i; k++) {
            bool apart = b[i].x1 <= b[k].x0 || b[k].x1 <= b[i].x0 || b[i].y1 <= b[k].y0
                      || b[k].y1 <= b[i].y0;
            CHECK(apart);
            if (!apart)
                fprintf(stderr, "%s: \"%s\" is on \"%s\"\n", name, b[i].text, b[k].text);
        }
    }
}

TEST(labels_do_not_overlap)
{
    static const double size[][2] = { { 1000, 750 }, { 500, 700 }, { 2000, 600 } };
    for (size_t i = 0; i < MODEL_FILES; i++) {
        lw_linkage k;
        OWN(lw_scene) s = { 0 };
        k = example(model_files[i]);
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        for (int q = 0; q < 3; q++) {
            OWN(lw_drawing) d = draw(&s, size[q][0], size[q][1]);
            check_texts(&d, model_files[i]);
        }
    }
    for (size_t n = 1; n < 200; n += 22) {
        OWN(lw_scene) s = { 0 };
        CHECK_INT(model_scene("Many target points", n, &s), LW_OK);
        OWN(lw_drawing) d = draw(&s, 1000, 750);
        check_texts(&d, "target points");
    }
}

/* All joints and lengths of the examples find a place. */
TEST(nothing_goes_without_its_label)
{
    for (size_t i = 0; i < MODEL_FILES; i++) {
        lw_linkage k;
        OWN(lw_scene) s = { 0 };
        k = example(model_files[i]);
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        OWN(lw_drawing) d = draw(&s, 1000, 750);
        int n_joint = 0, n_length = 0, n_want = 0;
        for (size_t q = 0; q < d.n_shape; q++) {
            n_joint += d.shape[q].role == LW_ROLE_JOINT_LABEL;
            n_length += d.shape[q].role == LW_ROLE_LENGTH_LABEL;
        }
        for (int q = 0; q < s.n_dim; q++)
            n_want += s.dim_kind[q] == LW_DIM_LENGTH;
        CHECK_INT(n_joint, k.n_joint + k.n_tracer);
        CHECK_INT(n_length, n_want);
    }
}

static unsigned pixel_at(cairo_surface_t *p, lw_vec2 at)
{
    const unsigned char *row = cairo_image_surface_get_data(p)
                             + (long)at.y*cairo_image_surface_get_stride(p);
    uint32_t v;
    memcpy(&v, row + 4*(long)at.x, 4);
    return v & 0xffffff;
}

typedef struct reader { const char *data; size_t left; } reader;
static cairo_status_t take(void *closure, unsigned char *data, unsigned n)
{
    reader *r = closure;
    if (n > r->left)
        return CAIRO_STATUS_READ_ERROR;
    memcpy(data, r->data, n);
    r->data += n;
    r->left -= n;
    return CAIRO_STATUS_SUCCESS;
}

TEST(png_shows_it)
{
    OWN(lw_scene) s = { 0 };
    OWN(lw_bytes) b = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 9, &s), LW_OK);
    OWN(lw_drawing) d = draw(&s, 900, 600);
    CHECK_OK(lw_picture_png(&d, &b, &check_error));
    reader r = { b.data, b.size };
    cairo_surface_t *p = cairo_image_surface_create_from_png_stream(take, &r);
    CHECK_INT(cairo_image_surface_get_width(p), 900);
    CHECK_INT(cairo_image_surface_get_height(p), 600);
    cairo_surface_flush(p);
    CHECK_INT(pixel_at(p, lw_v2(2, 300)), lw_ink_light(LW_INK_PAPER));
    for (size_t i = 1; i < 9; i++)
        CHECK_INT(pixel_at(p, lw_view_pixel(&d.view[0], s.station[i])), lw_ink_light(LW_INK_RED));
    for (int i = 0; i < 4; i++)                                          /* pins are open circles */
        CHECK_INT(pixel_at(p, lw_view_pixel(&d.view[0], s.linkage.joint[i].at)), lw_ink_light(LW_INK_PAPER));
    lw_vec2 crank = lw_v2_scale(lw_v2_add(s.linkage.joint[0].at, s.linkage.joint[1].at), 0.5);
    CHECK_INT(pixel_at(p, lw_view_pixel(&d.view[0], crank)), lw_ink_light(LW_INK_PURPLE));
    cairo_surface_destroy(p);
}

/* Moved by the frames of the motion: each pin is where the scene says, in every frame. */
TEST(frames_move_the_links)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 0, &s), LW_OK);
    lw_diagram_options o = { .width = 400, .height = 300, .zoom = 1, .whole_motion = true };
    OWN(lw_drawing) d = { 0 };
    CHECK_OK(lw_diagram_draw(&s, &o, &d, &check_error));
    FREED uint32_t *pixel = malloc(400*300*sizeof *pixel);
    for (size_t f = 0; f < s.n_frame; f += 17) {
        CHECK_OK(lw_picture_pixels(&d, &s, f, pixel, &check_error));
        for (int i = 1; i < 3; i++) {
            const lw_joint *j = &s.linkage.joint[i];
            for (int side = 0; side < 2; side++) {
                lw_vec2 p = lw_view_pixel(&d.view[0], lw_scene_at(&s, f, j->link[side], j->at));
                CHECK_INT(pixel[(int)p.y*400 + (int)p.x], lw_ink_light(LW_INK_PAPER));
                lw_page_motion m = lw_diagram_motion(&s, &d.view[0], f, j->link[side]);
                lw_vec2 q = lw_v2_sub(lw_view_pixel(&d.view[0], j->at), m.from);
                q = lw_v2_add(m.to, lw_v2_turn(q, m.turn));
                CHECK_POINT(q, p.x, p.y, 1e-6, 0);
            }
        }
    }
}

TEST(same_input_same_bytes)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Crank-rocker", 9, &s), LW_OK);
    lw_bytes b[2][3];
    for (int i = 0; i < 2; i++) {
        OWN(lw_drawing) d = draw(&s, 800, 600);
        CHECK_OK(lw_svg_write(&d, &b[i][0], &check_error));
        CHECK_OK(lw_picture_png(&d, &b[i][1], &check_error));
        CHECK_OK(lw_picture_pdf(&d, &b[i][2], &check_error));
    }
    for (int k = 0; k < 3; k++)
        CHECK(b[0][k].size == b[1][k].size && memcmp(b[0][k].data, b[1][k].data, b[0][k].size) == 0);
    CHECK(strncmp(b[0][2].data, "%PDF-", 5) == 0);
    CHECK(memmem(b[0][2].data, b[0][2].size, "CreationDate", 12) == NULL);
    for (int i = 0; i < 6; i++)
        lw_bytes_free(&b[i/3][i%3]);
}

/* A linkage of another size, in units of that size, is the same picture to the last byte. */
TEST(size_does_not_matter)
{
    OWN(lw_bytes) want = { 0 };
    for (int i = 0; i < 3; i++) {
        double by = ldexp(1, i == 0 ? 0 : i == 1 ? 30 : -30), r[9];
        for (int k = 0; k < 9; k++)
            r[k] = model_crank_rocker[k]*(k < 8 ? by : 1);
        lw_linkage k = model_four_bar(r, 1, 1);
        k.units.metre = by;
        OWN(lw_scene) s = { 0 };
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        OWN(lw_drawing) d = draw(&s, 1000, 750);
        lw_bytes b;
        CHECK_OK(lw_svg_write(&d, &b, &check_error));
        if (i == 0)
            want = b;
        else {
            CHECK_TEXT(b.data, want.data);
            lw_bytes_free(&b);
        }
    }
}

/* Path and linkage of very different size: a second panel, with every target point on it. */
TEST(specks_get_their_own_panel)
{
    for (double ratio = 2; ratio < 3e9; ratio *= 10) {
        const double r[9] = { ratio, 1, ratio + 0.3, 2.4, 1.5, 1.2, 0, 0, 0.2 };
        lw_linkage k = model_four_bar(r, 1, 1);
        OWN(lw_scene) s = { 0 };
        CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
        s.n_station = 5;
        s.station = calloc(5, sizeof *s.station);
        for (size_t i = 0; i < 5; i++)
            s.station[i] = s.curve[0].p[i*s.curve[0].n/5];
        OWN(lw_drawing) d = draw(&s, 1000, 750);
        CHECK_INT(d.n_view, ratio > 10 ? 2 : 1);
        found f = read_back(&d);
        CHECK_INT(f.stations, 5);
        check_texts(&d, "long links");
        const lw_view *v = &d.view[d.n_view - 1];
        double spread = 0;
        for (int i = 0; i < 5; i++) {
            CHECK(f.station[i][0] > v->x && f.station[i][0] < v->x + v->w);
            CHECK(f.station[i][1] > v->y && f.station[i][1] < v->y + v->h);
            spread = fmax(spread, hypot(f.station[i][0] - f.station[0][0], f.station[i][1] - f.station[0][1]));
        }
        CHECK(spread > 100);
    }
}

/* Far from the origin, on one point, with wild target points: still a picture. */
TEST(strange_coordinates_are_drawn)
{
    static const lw_vec2 wild[] = { { NAN, 0 }, { INFINITY, 1 }, { 1, -INFINITY } };
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene("Wild", 3, &s), LW_OK);
    memcpy(s.station, wild, sizeof wild);
    OWN(lw_drawing) d = draw(&s, 300, 200);
    found f = read_back(&d);
    CHECK_INT(f.joints, 4);
    lw_drawing_free(&d);
    for (size_t i = 0; i < 3; i++)
        s.station[i] = lw_v2(1e9, 1e9);
    d = draw(&s, 300, 200);
    read_back(&d);
    lw_drawing_free(&d);
    lw_scene_free(&s);
    lw_linkage k = { .name = "Bar", .n_link = 2, .n_joint = 1, .units = lw_units_si() };
    strcpy(k.link_name[0], "ground");
    strcpy(k.link_name[1], "link");
    k.joint[0] = (lw_joint){ .name = "A", .kind = LW_JOINT_REVOLUTE, .link = { 0, 1 }, .at = { 5, 5 } };
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    d = draw(&s, 300, 200);
    CHECK_INT(read_back(&d).joints, 1);
}

TEST(hostile_names_stay_text)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    strcpy(k.joint[0].name, "</text><script>");
    strcpy(k.joint[1].name, "A\"&'<!--\xff");
    lw_scene_options o = lw_scene_options_default();
    o.title = "<svg onload=alert(1)> ]]> \xc3\xa9 \xe2\x80";
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, &o, &s, &check_error));
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    found f = read_back(&d);
    CHECK_INT(f.joints, 4);
    OWN(lw_bytes) b = { 0 };
    CHECK_OK(lw_svg_write(&d, &b, &check_error));
    CHECK(!strstr(b.data, "<script") && !strstr(b.data, "<svg onload"));
    lw_bytes_free(&b);
    CHECK_OK(lw_picture_png(&d, &b, &check_error));
    lw_bytes_free(&b);
    CHECK_OK(lw_picture_pdf(&d, &b, &check_error));
}

/* Slots and gears, which have no plan yet, are drawn in the posture given. */
TEST(every_kind_of_joint_is_drawn)
{
    lw_linkage k = model_four_bar(model_crank_rocker, 1, 1);
    k.joint[2].kind = LW_JOINT_SLOT;
    k.joint[2].along = lw_v2_polar(1, 0.7);
    k.joint[k.n_joint++] = (lw_joint){ .name = "G", .kind = LW_JOINT_GEAR, .link = { 1, 3 },
                                       .at = { 1.2, 0 }, .ratio = -1 };
    OWN(lw_scene) s = { 0 };
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    CHECK_INT(read_back(&d).joints, 4);
    int guides = 0;
    for (size_t i = 0; i < d.n_shape; i++)
        guides += d.shape[i].role == LW_ROLE_GUIDE;
    CHECK_INT(guides, 3);                                       /* the slot and two pitch circles */
}

/* The teeth of a rack are as far apart as those of its pinion; a plate welded to the rack at an angle has a filled corner there. */
TEST(rack_and_weld)
{
    lw_linkage k = { .units = lw_units_si(), .n_link = 5, .n_joint = 5, .n_input = 1, .n_tracer = 1, .input = { { .joint = 0 } },
                     .link_name = { "ground", "arm", "wheel", "rack", "plate" }, .tracer = { { .name = "Q", .link = 4, .at = { 1.5, 0.4 } } },
                     .joint = { { .name = "A", .kind = LW_JOINT_REVOLUTE, .link = { 0, 1 } }, { .name = "P", .kind = LW_JOINT_REVOLUTE, .link = { 1, 2 }, .at = { 1, 0.5 } },
                                { .name = "S", .kind = LW_JOINT_SLIDER, .link = { 1, 3 }, .at = { 1, 0.2 }, .along = { 1, 0 } },
                                { .name = "G", .kind = LW_JOINT_GEAR, .link = { 2, 3 }, .at = { 1, 0.2 }, .ratio = 0.3 },
                                { .name = "W", .kind = LW_JOINT_FIXED, .link = { 3, 4 }, .at = { 1.4, 0.2 } } } };
    OWN(lw_scene) s = { 0 };
    lw_error e;
    CHECK_INT(lw_scene_make(&k, NULL, NULL, &s, &e), LW_OK);
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    double teeth = 0, pitch = 0;
    int corners = 0;
    for (size_t i = 0; i < d.n_shape; i++) {
        const lw_shape *a = &d.shape[i];
        const lw_vec2 *p = d.point + a->first;
        if (a->role == LW_ROLE_GUIDE && a->closed && a->link == 2)
            teeth = (double)a->n/4;
        if (a->role == LW_ROLE_GUIDE && a->closed && a->link == 3 && a->n%4 == 2)
            pitch = lw_v2_norm(lw_v2_sub(p[4], p[0]))/d.view[0].scale;
        corners += a->role == LW_ROLE_JOINT && a->kind == LW_SHAPE_PATH && a->n == 3 && a->link == 4;
    }
    CHECK(teeth > 5);
    CHECK_NEAR(pitch, 2*LW_PI*0.3/teeth, 0, 1e-9);
    CHECK_INT(corners, 1);
}

/* The trammel: two blocks on hatched guides of the ground that cover their travel. */
TEST(guides_cover_the_travel)
{
    lw_linkage k;
    OWN(lw_scene) s = { 0 };
    k = example("trammel");
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    for (int j = 0; j < k.n_joint; j++) {
        if (k.joint[j].kind != LW_JOINT_SLIDER)
            continue;
        lw_slide w = lw_body_shapes_slide(&s, j);
        CHECK_INT(w.guide, k.ground);
        CHECK_NEAR(w.hi - w.lo, 0.2, 1e-4, 0);          /* a bar of 0.1 m runs 0.1 m each way */
    }
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    CHECK_INT(read_back(&d).sliders, 2);
}

/* An input without a range is shown between the ends of the stop of its joint, whatever the sense of a pin that ends at the ground. */
TEST(stops_limit_the_input)
{
    static const char *const joint[] = { "'links': ['ground', 'a'], 'at': [0, 0]", "'links': ['a', 'ground'], 'at': [0, 0]",
                                         "'kind': 't', 'links': ['ground', 'a'], 'at': [0, 0], 'along': [1, 0]" };
    for (int i = 0; i < 3; i++) {
        OWN(lw_model) m = { 0 };
        OWN(lw_scene) s = { 0 };
        lw_scene_options o = lw_scene_options_default();
        char text[400];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', 'a'], 'joints': [{'name': 'A', %s, 'stop': {'least': -0.2, 'greatest': 0.5}}], "
                 "'input': {'joint': 'A'}, 'tracers': [{'name': 'T', 'link': 'a', 'at': [1, 0]}]}", joint[i]);
        read_planar(text, "stops", &m);
        o.model = &m;
        CHECK_OK(lw_scene_make_any(&m.linkage, &m, NULL, &o, &s, &check_error));
        double least = INFINITY, most = -INFINITY;
        for (size_t f = 0; f < s.n_frame; f++) {
            lw_vec2 at = lw_scene_at(&s, f, 1, lw_v2(1, 0));
            double moved = i == 2 ? at.x - 1 : atan2(at.y, at.x);
            least = fmin(least, moved), most = fmax(most, moved);
        }
        CHECK_NEAR(least, -0.2, 1e-9, 0);
        CHECK_NEAR(most, 0.5, 1e-9, 0);
    }
}

/* Guides, links and hatching of the picture of a model of examples/, and the greatest y of a guide [px]. */
typedef struct parts { int guides, links, hatching; double lowest; } parts;

static parts parts_of(const char *path)
{
    OWN(lw_model) m = { 0 };
    OWN(lw_scene) s = { 0 };
    lw_scene_options o = lw_scene_options_default();
    parts n = { .lowest = -1 };
    o.model = &m;
    load_planar(path, &m);
    CHECK_OK(lw_scene_make_any(&m.linkage, &m, NULL, &o, &s, &check_error));
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    for (size_t i = 0; i < d.n_shape; i++) {
        n.guides += d.shape[i].role == LW_ROLE_GUIDE;
        n.links += d.shape[i].role == LW_ROLE_LINK;
        n.hatching += d.shape[i].role == LW_ROLE_HATCH;
        if (d.shape[i].role == LW_ROLE_GUIDE)
            n.lowest = fmax(n.lowest, d.point[d.shape[i].first].y);
    }
    return n;
}

TEST(the_ground_is_seen)
{
    parts frame = parts_of("examples/elastic-frame.json"), boxes = parts_of("examples/dynamics/boxes.json");
    CHECK_INT(frame.guides, 2);                                 /* a wall at each of the two ends that are held */
    CHECK(frame.hatching >= 8);
    CHECK_INT(boxes.guides, 1);                                 /* the floor, above scale bar and note */
    CHECK(boxes.lowest > 400 && boxes.lowest < 690);
    CHECK_INT(parts_of("examples/dynamics/hook.json").links, 3);        /* the hook, the wheel and the bar from it to its mass */
}

/* The walls of a portal frame lie across its legs, also where it is a mesh of four nodes, whose middle lies beside them. */
TEST(meshes_leave_their_walls)
{
    OWN(lw_model) m = { 0 };
    OWN(lw_scene) s = { 0 };
    lw_scene_options o = lw_scene_options_default();
    o.model = &m;
    load_planar("examples/elastic-frame.json", &m);
    lw_elastic *e = &m.elastic[1];
    int n = e->n_axis, walls = 0;
    CHECK_INT(n, 4);
    e->node = calloc((size_t)n, sizeof *e->node);
    e->stiffness = calloc((size_t)(36*n*n), sizeof *e->stiffness);
    for (int i = 0; i < n; i++) {
        e->node[i] = e->axis[i];
        for (int k = 0; k < 6*n; k++)            /* neighbours hold each other */
            e->stiffness[(6*i + k % 6)*6*n + k] = k/6 == i ? 2 : abs(k/6 - i) == 1 ? -1 : 0;
    }
    e->n_node = n;
    e->n_axis = 0;
    CHECK_OK(lw_scene_make_any(&m.linkage, &m, NULL, &o, &s, &check_error));
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    for (size_t i = 0; i < d.n_shape; i++)
        if (d.shape[i].role == LW_ROLE_GUIDE) {
            const lw_vec2 *p = d.point + d.shape[i].first;
            CHECK(fabs(p[1].x - p[0].x) > 20);
            CHECK_NEAR(p[1].y, p[0].y, 1e-9, 0);
            walls++;
        }
    CHECK_INT(walls, 2);
}

/* In the panel of Evans' straight line, which its other assembly modes leave, no curve runs through the legend. */
TEST(legends_are_free_of_curves)
{
    lw_linkage k;
    OWN(lw_scene) s = { 0 };
    double lowest = 0, legend = INFINITY;
    k = example("gallery/evans");
    CHECK_OK(lw_scene_make(&k, NULL, NULL, &s, &check_error));
    OWN(lw_drawing) d = draw(&s, 1000, 750);
    CHECK_INT(d.n_view, 2);
    for (size_t i = 0; i < d.n_shape; i++) {
        const lw_shape *a = &d.shape[i];
        for (size_t p = 0; a->role == LW_ROLE_OTHER_CURVE && a->panel == 1 && p < a->n; p++)
            lowest = fmax(lowest, d.point[a->first + p].y);
        if (a->role == LW_ROLE_LEGEND && a->kind == LW_SHAPE_TEXT)
            legend = fmin(legend, a->at.y - a->width);
    }
    CHECK(lowest > 600 && lowest < legend);
}

TEST(unfit_sizes_are_refused)
{
    OWN(lw_scene) s = { 0 };
    CHECK_INT(model_scene(NULL, 0, &s), LW_OK);
    static const double size[][3] = { { 0, 100, 1 }, { 100, 1e9, 1 }, { NAN, 100, 1 }, { 100, 100, 0 } };
    for (int i = 0; i < 4; i++) {
        lw_diagram_options o = { .width = size[i][0], .height = size[i][1], .zoom = size[i][2] };
        lw_drawing d;
        CHECK_INT(lw_diagram_draw(&s, &o, &d, &check_error), LW_E_ARG);
        CHECK(d.shape == NULL);
    }
}

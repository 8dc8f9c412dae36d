/* catalogues/exchange/export_plates.c - write a linkage as plates, to cut (DXF R12) or to look at (OpenSCAD). */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/layers.h"

#define MM      1000.0
#define DIGITS  10
#define FRAMES  240
#define SHOWN   60               /* poses in an OpenSCAD file; a divisor of FRAMES */

typedef struct work { lw_scene s; lw_layers l; } work;

static lw_status make(const lw_linkage *k, work **out, lw_error *e)
{
    work *w = calloc(1, sizeof *w);
    if (!w)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for plates");
    lw_status s = lw_scene_make(k, NULL, &(lw_scene_options){ .n_frame = FRAMES, .n_curve_point = 8 }, &w->s, e);
    if (s == LW_OK) {
        s = lw_layers_find(&w->s, 0, &w->l, e);
        if (s != LW_OK)
            lw_scene_free(&w->s);
    }
    if (s != LW_OK) {
        free(w);
        return s;
    }
    *out = w;
    return LW_OK;
}

static void end(work *w)
{
    lw_scene_free(&w->s);
    free(w);
}

/* What is known about the layers, in one sentence. */
static void put_room(const work *w, char *text, size_t size)
{
    char room[32];
    lw_number_text(room, MM*w->l.room, 3);
    snprintf(text, size, isfinite(w->l.room) ? "in each layer at least %s mm are free over the whole motion"
             : "in no layer anything passes anything", room);
}

/* ---- DXF -------------------------------------------------------------------------------------------------- */

static void put_code(lw_bytes *out, int code, const char *text)
{
    char line[8];
    snprintf(line, sizeof line, "%3d\n", code);
    lw_bytes_text(out, line);
    lw_bytes_text(out, text);
    lw_bytes_text(out, "\n");
}

static void put_value(lw_bytes *out, int code, double v)
{
    char text[32];
    lw_number_text(text, fabs(v) < 1e-9 ? 0 : v, DIGITS);
    put_code(out, code, text);
}

static void put_point(lw_bytes *out, int code, lw_vec2 p)
{
    put_value(out, code, MM*p.x);
    put_value(out, code + 10, MM*p.y);
}

/* Layer names in R12: capitals, digits, - and _, at most 31 characters. */
static void layer_name(const work *w, int link, char name[32])
{
    int n = snprintf(name, 32, "L%d_", w->l.layer[link]);
    for (const char *c = w->s.linkage.link_name[link]; *c && n < 31; c++)
        name[n++] = (char)(isalnum((unsigned char)*c) && (unsigned char)*c < 128 ? toupper((unsigned char)*c) : '_');
    name[n] = 0;
}

static void put_line(lw_bytes *out, const char *layer, lw_vec2 a, lw_vec2 b)
{
    put_code(out, 0, "LINE");
    put_code(out, 8, layer);
    put_point(out, 10, a);
    put_point(out, 11, b);
}

static double degrees(lw_vec2 d)
{
    double a = atan2(d.y, d.x)*180/LW_PI;
    return a < 0 ? a + 360 : a;
}

/* Write an arc, counter-clockwise from direction `from` to `to`. */
static void put_arc(lw_bytes *out, const char *layer, lw_vec2 at, double r, lw_vec2 from, lw_vec2 to)
{
    put_code(out, 0, "ARC");
    put_code(out, 8, layer);
    put_point(out, 10, at);
    put_value(out, 40, MM*r);
    put_value(out, 50, degrees(from));
    put_value(out, 51, degrees(to));
}

static void put_circle(lw_bytes *out, const char *layer, lw_vec2 at, double r)
{
    put_code(out, 0, "CIRCLE");
    put_code(out, 8, layer);
    put_point(out, 10, at);
    put_value(out, 40, MM*r);
}

/* Write the outline of a convex polygon (counter-clockwise, or a bar, or a point) widened by r. */
static void put_outline(lw_bytes *out, const char *layer, const lw_vec2 *p, int n, double r, lw_vec2 shift)
{
    if (n == 1) {
        put_circle(out, layer, lw_v2_add(p[0], shift), r);
        return;
    }
    for (int i = 0; i < n; i++) {
        lw_vec2 a = p[i], b = p[(i + 1) % n], c = p[(i + 2) % n], d = lw_v2_sub(b, a), f = lw_v2_sub(c, b);
        lw_vec2 m = lw_v2_scale(lw_v2_perp(d), -1/lw_v2_norm(d)), o = lw_v2_scale(lw_v2_perp(f), -1/lw_v2_norm(f));
        lw_vec2 off = lw_v2_add(shift, lw_v2_scale(m, r));
        put_line(out, layer, lw_v2_add(a, off), lw_v2_add(b, off));
        put_arc(out, layer, lw_v2_add(b, shift), r, m, o);
    }
}

/* Lower left and upper right corner of a plate. */
static void plate_box(const work *w, int link, lw_vec2 *lo, lw_vec2 *hi)
{
    const lw_plate *p = &w->l.plate[link];
    *lo = *hi = p->corner[0];
    for (int i = 1; i < p->n_corner; i++) {
        *lo = lw_v2(fmin(lo->x, p->corner[i].x), fmin(lo->y, p->corner[i].y));
        *hi = lw_v2(fmax(hi->x, p->corner[i].x), fmax(hi->y, p->corner[i].y));
    }
    *lo = lw_v2_sub(*lo, lw_v2(w->l.radius, w->l.radius));
    *hi = lw_v2_add(*hi, lw_v2(w->l.radius, w->l.radius));
}

static void put_cut(const work *w, int link, lw_vec2 shift, lw_bytes *out)
{
    const lw_plate *p = &w->l.plate[link];
    char layer[32];
    layer_name(w, link, layer);
    put_outline(out, layer, p->corner, p->n_corner, w->l.radius, shift);
    for (int i = 0; i < p->n_hole; i++) {
        const lw_vec2 ends[2] = { p->hole[i].a, p->hole[i].b };
        bool round = lw_v2_norm(lw_v2_sub(ends[1], ends[0])) < 1e-9*w->l.radius;
        put_outline(out, layer, ends, round ? 1 : 2, w->l.bore, shift);
    }
}

static void put_tables(const work *w, lw_bytes *out)
{
    char name[32], count[12];
    put_code(out, 0, "SECTION");
    put_code(out, 2, "TABLES");
    put_code(out, 0, "TABLE");
    put_code(out, 2, "LAYER");
    snprintf(count, sizeof count, "%d", w->s.linkage.n_link);
    put_code(out, 70, count);
    for (int link = 0; link < w->s.linkage.n_link; link++) {
        layer_name(w, link, name);
        snprintf(count, sizeof count, "%d", 1 + w->l.layer[link] % 7);
        put_code(out, 0, "LAYER");
        put_code(out, 2, name);
        put_code(out, 70, "0");
        put_code(out, 62, count);
        put_code(out, 6, "CONTINUOUS");
    }
    put_code(out, 0, "ENDTAB");
    put_code(out, 0, "ENDSEC");
}

lw_status lw_export_dxf(const lw_linkage *k, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    (void)o;
    work *w;
    char note[120];
    lw_status s = make(k, &w, e);
    if (s != LW_OK)
        return s;
    put_code(out, 999, "plates in millimetres");
    put_room(w, note, sizeof note);
    put_code(out, 999, note);
    put_code(out, 0, "SECTION");
    put_code(out, 2, "HEADER");
    put_code(out, 9, "$ACADVER");
    put_code(out, 1, "AC1009");
    put_code(out, 0, "ENDSEC");
    put_tables(w, out);
    put_code(out, 0, "SECTION");
    put_code(out, 2, "ENTITIES");
    double x = 0;
    for (int link = 0; link < k->n_link; link++) {
        lw_vec2 lo, hi;
        plate_box(w, link, &lo, &hi);
        put_cut(w, link, lw_v2(x - lo.x, -lo.y), out);
        x += hi.x - lo.x + w->l.radius;
    }
    put_code(out, 0, "ENDSEC");
    put_code(out, 0, "EOF");
    end(w);
    return lw_bytes_end(out, e);
}

/* ---- OpenSCAD ---------------------------------------------------------------------------------------------- */

static void put_mm(lw_bytes *out, double v) { lw_bytes_number(out, fabs(MM*v) < 1e-9 ? 0 : MM*v, DIGITS); }

static void put_text_mm(lw_bytes *out, const char *text, double v, const char *more)
{
    lw_bytes_text(out, text);
    put_mm(out, v);
    lw_bytes_text(out, more);
}

static void put_disc(lw_bytes *out, lw_vec2 at, const char *radius)
{
    put_text_mm(out, " translate([", at.x, ", ");
    put_text_mm(out, "", at.y, "]) circle(");
    lw_bytes_text(out, radius);
    lw_bytes_text(out, ");");
}

/* A comment ends with its line: write the name without control characters. */
static void put_comment(lw_bytes *out, const char *name)
{
    char clean[LW_NAME_SIZE*4];
    lw_text_clean(clean, sizeof clean, name);
    for (char *c = clean; *c; c++)
        *c = (unsigned char)*c < ' ' ? ' ' : *c;
    lw_bytes_text(out, clean);
}

static void put_module(const work *w, int link, lw_bytes *out)
{
    const lw_plate *p = &w->l.plate[link];
    lw_vec2 o = w->s.origin[link];
    lw_bytes_text(out, "module link");
    lw_bytes_integer(out, link);
    lw_bytes_text(out, "() linear_extrude(thickness) difference() {   // ");
    put_comment(out, w->s.linkage.link_name[link]);
    lw_bytes_text(out, "\n    hull() {");
    for (int i = 0; i < p->n_corner; i++)
        put_disc(out, lw_v2_sub(p->corner[i], o), "radius");
    lw_bytes_text(out, " }\n");
    for (int i = 0; i < p->n_hole; i++) {
        lw_bytes_text(out, "    hull() {");
        put_disc(out, lw_v2_sub(p->hole[i].a, o), "bore");
        if (lw_v2_norm(lw_v2_sub(p->hole[i].b, p->hole[i].a)) > 0)
            put_disc(out, lw_v2_sub(p->hole[i].b, o), "bore");
        lw_bytes_text(out, " }\n");
    }
    lw_bytes_text(out, "}\n");
}

static void put_poses(const work *w, lw_bytes *out)
{
    size_t n = (size_t)w->s.linkage.n_link;
    lw_bytes_text(out, "\n// place and turn of each link\npose = [\n");
    for (size_t f = 0; f < w->s.n_frame; f += FRAMES/SHOWN) {
        lw_bytes_text(out, "    [");
        for (size_t i = 0; i < n; i++) {
            const lw_place *p = &w->s.place[f*n + i];
            put_text_mm(out, i ? ", [" : "[", p->at.x, ", ");
            put_text_mm(out, "", p->at.y, ", ");
            lw_bytes_number(out, atan2(p->turn.y, p->turn.x)*180/LW_PI, DIGITS);
            lw_bytes_text(out, "]");
        }
        lw_bytes_text(out, "],\n");
    }
    lw_bytes_text(out, "];\n");
}

static void put_assembly(const work *w, lw_bytes *out)
{
    lw_bytes_text(out, "\nfloor_height = thickness + gap;\nframe = floor($t*len(pose)) % len(pose);\n"
                       "module place(link, floor) {\n    p = pose[frame][link];\n"
                       "    translate([p[0], p[1], floor*floor_height]) rotate(p[2]) children();\n}\n\n");
    for (int link = 0; link < w->s.linkage.n_link; link++) {
        char line[96];
        snprintf(line, sizeof line, "color(hues[%d]) place(%d, %d) link%d();\n", link % 6, link, w->l.layer[link],
                 link);
        lw_bytes_text(out, line);
    }
    for (int i = 0; i < w->l.n_pin; i++) {
        const lw_pin *p = &w->l.pin[i];
        lw_vec2 at = lw_v2_sub(p->at, w->s.origin[p->owner]);
        char line[96];
        snprintf(line, sizeof line, "place(%d, %d)", p->owner, p->low);
        lw_bytes_text(out, line);
        put_text_mm(out, " translate([", at.x, ", ");
        put_text_mm(out, "", at.y, "]) cylinder(r = 0.95*bore, h = ");
        lw_bytes_integer(out, p->high - p->low + 1);
        lw_bytes_text(out, "*floor_height - gap);\n");
    }
}

lw_status lw_export_openscad(const lw_linkage *k, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    (void)o;
    work *w;
    char note[120];
    lw_status s = make(k, &w, e);
    if (s != LW_OK)
        return s;
    lw_bytes_text(out, "// ");
    put_comment(out, k->name);
    put_room(w, note, sizeof note);
    lw_bytes_text(out, "\n// millimetres; View > Animate moves it\n// ");
    lw_bytes_text(out, note);
    lw_bytes_text(out, "\n$fn = 48;\n");
    put_text_mm(out, "radius = ", w->l.radius, ";\n");
    put_text_mm(out, "bore = ", w->l.bore, ";\n");
    put_text_mm(out, "thickness = ", w->l.thickness, ";\n");
    put_text_mm(out, "gap = ", 0.1*w->l.thickness, ";\n");
    lw_bytes_text(out, "hues = [\"silver\", \"orange\", \"skyblue\", \"seagreen\", \"gold\", \"orchid\"];\n\n");
    for (int link = 0; link < k->n_link; link++)
        put_module(w, link, out);
    put_poses(w, out);
    put_assembly(w, out);
    end(w);
    return lw_bytes_end(out, e);
}

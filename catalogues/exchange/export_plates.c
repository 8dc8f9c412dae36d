/* catalogues/exchange/export_plates.c - write a linkage as plates, to cut (DXF R12) or to look at (OpenSCAD). */
#include <ctype.h>
#include <stdio.h>

#include "base/real.h"
#include "catalogues/exchange/plates.h"

#define MM      1000.0
#define DIGITS  10
#define SHOWN   60               /* frames in an OpenSCAD file; a divisor of LW_PLATES_FRAMES */

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
static void layer_name(const lw_plates *w, int link, char name[32])
{
    int n = snprintf(name, 32, "L%d_", w->layers.layer[link]);
    for (const char *c = w->scene.linkage.link_name[link]; *c && n < 31; c++)
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
static void put_outline(const lw_plates *w, lw_bytes *out, const char *layer, const lw_vec2 *p, int n, double r, lw_vec2 shift)
{
    lw_plate_loop loop;
    lw_loop_widen(p, n, r, w->side, &loop);
    if (loop.n == 1) {
        put_circle(out, layer, lw_v2_add(p[0], shift), r);
        return;
    }
    for (int i = 0; i < loop.n; i++) {
        const lw_plate_side *a = &loop.side[i], *b = &loop.side[(i + 1) % loop.n];
        if (a->arc)
            put_arc(out, layer, lw_v2_add(a->centre, shift), r, lw_v2_sub(a->from, a->centre), lw_v2_sub(b->from, a->centre));
        else
            put_line(out, layer, lw_v2_add(a->from, shift), lw_v2_add(b->from, shift));
    }
}

/* Lower left and upper right corner of a plate. */
static void plate_box(const lw_plates *w, int link, lw_vec2 *lo, lw_vec2 *hi)
{
    const lw_plate *p = &w->layers.plate[link];
    *lo = *hi = p->corner[0];
    for (int i = 1; i < p->n_corner; i++) {
        *lo = lw_v2(fmin(lo->x, p->corner[i].x), fmin(lo->y, p->corner[i].y));
        *hi = lw_v2(fmax(hi->x, p->corner[i].x), fmax(hi->y, p->corner[i].y));
    }
    *lo = lw_v2_sub(*lo, lw_v2(w->layers.radius, w->layers.radius));
    *hi = lw_v2_add(*hi, lw_v2(w->layers.radius, w->layers.radius));
}

static void put_cut(const lw_plates *w, int link, lw_vec2 shift, lw_bytes *out)
{
    const lw_plate *p = &w->layers.plate[link];
    char layer[32];
    layer_name(w, link, layer);
    put_outline(w, out, layer, p->corner, p->n_corner, w->layers.radius, shift);
    for (int i = 0; i < p->n_hole; i++) {
        const lw_vec2 ends[2] = { p->hole[i].a, p->hole[i].b };
        bool round = lw_v2_norm(lw_v2_sub(ends[1], ends[0])) < 1e-9*w->layers.radius;
        put_outline(w, out, layer, ends, round ? 1 : 2, w->layers.bore, shift);
    }
}

static void put_tables(const lw_plates *w, lw_bytes *out)
{
    char name[32], count[12];
    put_code(out, 0, "SECTION");
    put_code(out, 2, "TABLES");
    put_code(out, 0, "TABLE");
    put_code(out, 2, "LAYER");
    snprintf(count, sizeof count, "%d", w->scene.linkage.n_link);
    put_code(out, 70, count);
    for (int link = 0; link < w->scene.linkage.n_link; link++) {
        layer_name(w, link, name);
        snprintf(count, sizeof count, "%d", 1 + w->layers.layer[link] % 7);
        put_code(out, 0, "LAYER");
        put_code(out, 2, name);
        put_code(out, 70, "0");
        put_code(out, 62, count);
        put_code(out, 6, "CONTINUOUS");
    }
    put_code(out, 0, "ENDTAB");
    put_code(out, 0, "ENDSEC");
}

lw_status lw_export_dxf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_plates *w;
    char note[120];
    lw_status s = lw_plates_make(linkage, o, &w, e);
    if (s != LW_OK)
        return s;
    put_code(out, 999, "plates in millimetres");
    lw_plates_room(w, note, sizeof note);
    put_code(out, 999, note);
    snprintf(note, sizeof note, "thickness %.6g, holes %.6g, pins %.6g", MM*w->layers.thickness, 2*MM*w->layers.bore,
             2*MM*w->layers.pin_radius);
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
    for (int link = 0; link < linkage->n_link; link++) {
        lw_vec2 lo, hi;
        plate_box(w, link, &lo, &hi);
        put_cut(w, link, lw_v2(x - lo.x, -lo.y), out);
        x += hi.x - lo.x + w->layers.radius;
    }
    put_code(out, 0, "ENDSEC");
    put_code(out, 0, "EOF");
    lw_plates_free(w);
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

static void put_module(const lw_plates *w, int link, lw_bytes *out)
{
    const lw_plate *p = &w->layers.plate[link];
    lw_vec2 o = w->scene.origin[link];
    lw_bytes_text(out, "module link");
    lw_bytes_integer(out, link);
    lw_bytes_text(out, "() linear_extrude(thickness) difference() {   // ");
    put_comment(out, w->scene.linkage.link_name[link]);
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

static void put_poses(const lw_plates *w, lw_bytes *out)
{
    size_t n = (size_t)w->scene.linkage.n_link;
    lw_bytes_text(out, "\n// place and turn of each link\npose = [\n");
    for (size_t f = 0; f < w->scene.n_frame; f += LW_PLATES_FRAMES/SHOWN) {
        lw_bytes_text(out, "    [");
        for (size_t i = 0; i < n; i++) {
            const lw_place *p = &w->scene.place[f*n + i];
            put_text_mm(out, i ? ", [" : "[", p->at.x, ", ");
            put_text_mm(out, "", p->at.y, ", ");
            lw_bytes_number(out, atan2(p->turn.y, p->turn.x)*180/LW_PI, DIGITS);
            lw_bytes_text(out, "]");
        }
        lw_bytes_text(out, "],\n");
    }
    lw_bytes_text(out, "];\n");
}

static void put_assembly(const lw_plates *w, lw_bytes *out)
{
    lw_bytes_text(out, "\nfloor_height = thickness + gap;\nframe = floor($t*len(pose)) % len(pose);\n"
                       "module place(link, floor) {\n    p = pose[frame][link];\n"
                       "    translate([p[0], p[1], floor*floor_height]) rotate(p[2]) children();\n}\n\n");
    for (int link = 0; link < w->scene.linkage.n_link; link++) {
        char line[96];
        snprintf(line, sizeof line, "color(hues[%d]) place(%d, %d) link%d();\n", link % 6, link, w->layers.layer[link], link);
        lw_bytes_text(out, line);
    }
    for (int i = 0; i < w->layers.n_pin; i++) {
        const lw_pin *p = &w->layers.pin[i];
        lw_vec2 at = lw_v2_sub(p->at, w->scene.origin[p->owner]);
        char line[96];
        snprintf(line, sizeof line, "place(%d, %d)", p->owner, p->low);
        lw_bytes_text(out, line);
        put_text_mm(out, " translate([", at.x, ", ");
        put_text_mm(out, "", at.y, "]) cylinder(r = pin, h = ");
        lw_bytes_integer(out, p->high - p->low + 1);
        lw_bytes_text(out, "*floor_height - gap);\n");
    }
}

lw_status lw_export_openscad(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_plates *w;
    char note[120];
    lw_status s = lw_plates_make(linkage, o, &w, e);
    if (s != LW_OK)
        return s;
    lw_bytes_text(out, "// ");
    put_comment(out, linkage->name);
    lw_plates_room(w, note, sizeof note);
    lw_bytes_text(out, "\n// millimetres; View > Animate moves it\n// ");
    lw_bytes_text(out, note);
    lw_bytes_text(out, "\n$fn = 48;\n");
    put_text_mm(out, "radius = ", w->layers.radius, ";\n");
    put_text_mm(out, "bore = ", w->layers.bore, ";\n");
    put_text_mm(out, "pin = ", w->layers.pin_radius, ";\n");
    put_text_mm(out, "thickness = ", w->layers.thickness, ";\n");
    put_text_mm(out, "gap = ", 0.1*w->layers.thickness, ";\n");
    lw_bytes_text(out, "hues = [\"silver\", \"orange\", \"skyblue\", \"seagreen\", \"gold\", \"orchid\"];\n\n");
    for (int link = 0; link < linkage->n_link; link++)
        put_module(w, link, out);
    put_poses(w, out);
    put_assembly(w, out);
    lw_plates_free(w);
    return lw_bytes_end(out, e);
}
